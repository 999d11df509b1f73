"""The command line `halfplane`, from its words to an exit code. Each module that is imported here registers its commands; what a
command does is in `commands_engines`, `commands_scenes` and `commands_machine`, and heavy packages are loaded there."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import CycloptsError

from reports import cli_engines, cli_maps, cli_results, cli_scenes, cli_sweep  # noqa: F401 (they register themselves)
from reports.application import BAD_INPUT, INTERRUPTED, NOT_CONVERGED, WITHIN, app
from reports.process import settled


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; without `arguments` the process is ours, its streams and signals too."""
    if arguments is not None:
        return _run(list(arguments))
    with settled() as process:
        try:
            code = _run(sys.argv[1:])
            if (fault := process.unwritten()) is not None:
                code = _refused(f"the answer could not be written to stdout: {fault.strerror}; see to that and ask again")
        except KeyboardInterrupt:  # a second one, while the first was told
            code = INTERRUPTED
        except Exception:
            if not process.received:
                raise
            code = _interrupted("")  # compiled modules and locks make another error of it
        return process.exit_code(code)


def _run(tokens: list[str]) -> int:
    """The exit code of a command line; whatever is refused, in a sentence."""
    try:
        if any(token == "" or (token.startswith("--") and token.endswith("=")) for token in tokens):
            return _refused("one of the arguments is empty: is a variable of the shell not set? Give a value, or leave it out")
        if strange := next((token for token in tokens if not _is_text(token)), ""):
            encoding = sys.getfilesystemencoding()
            return _refused(f"{strange}: this is no text in {encoding}; name it otherwise, or set PYTHONUTF8=1 if it is UTF-8")
        return int(app(tokens) or WITHIN)
    except CycloptsError as fault:
        from reports.misspelt import sentence

        return _refused(sentence(fault))
    except ValueError as fault:
        # scenes is heavy: it is imported when it must have been imported already, never for --help.
        from scenes import InputError

        if not isinstance(fault, InputError):
            raise
        return _refused(_one_line(str(fault)))
    except RuntimeError as fault:
        from scenes import ConvergenceError

        if not isinstance(fault, ConvergenceError):
            raise
        _refused(f"not converged: {_one_line(str(fault))}")
        return NOT_CONVERGED
    except MemoryError as fault:
        why = f" ({_one_line(str(fault))})" if str(fault) else ""
        return _refused(f"there is not enough memory for this{why}; ask for a coarser mesh, fewer steps or fewer instants")
    except OSError as fault:
        return _refused(_of_the_system(fault))
    except KeyboardInterrupt as stop:
        return _interrupted(str(stop))


def _interrupted(what: str) -> int:
    _refused(f"interrupted; {what or 'nothing was written'}")
    return INTERRUPTED


def _refused(sentence: str) -> int:
    from reports.console import complain

    complain(f"halfplane: {sentence}")
    return BAD_INPUT


def _of_the_system(fault: OSError) -> str:
    """The sentence of a refusal that no door has words for."""
    where = f"{_one_line(os.fsdecode(fault.filename))}: " if isinstance(fault.filename, str | bytes) else ""
    return f"{where}the system refuses: {fault.strerror or _one_line(str(fault))}; see to that and ask again"


def _is_text(token: str) -> bool:
    """Not where a byte could not be decoded: it stands as a lone surrogate, which no file of ours can hold."""
    return not any("\ud800" <= sign <= "\udfff" for sign in token)


def _one_line(text: str) -> str:
    return " ".join(text.split()).rstrip(".")
