"""The command line `halfplane`, from its words to an exit code. Each module that is imported here registers its commands; what a
command does is in `commands_engines`, `commands_scenes` and `commands_machine`, and heavy packages are loaded there."""

from __future__ import annotations

import os
import shlex
import sys
import tempfile
import textwrap
import time
import traceback
import warnings
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from cyclopts import CycloptsError

from reports import cli_engines, cli_maps, cli_results, cli_scenes, cli_sweep  # noqa: F401 (they register themselves)
from reports.application import BAD_INPUT, INTERNAL, INTERRUPTED, NOT_CONVERGED, WITHIN, app, output_folder
from reports.process import settled


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; without `arguments` the process is ours, its streams and signals too."""
    if arguments is not None:
        return _run(list(arguments))
    with settled() as process:
        try:
            code = _run(sys.argv[1:], process.received)
            if (fault := process.unwritten()) is not None:
                code = _refused(f"the answer could not be written to stdout: {fault.strerror}; see to that and ask again")
        except KeyboardInterrupt:  # a second one, while the first was told
            code = INTERRUPTED
        return process.exit_code(code)


def _run(tokens: list[str], received: Sequence[int] = ()) -> int:
    """The exit code of a command line; whatever is refused or goes wrong, in a sentence. `received`: signals until now."""
    output_folder.set(None)
    try:
        if any(token == "" or (token.startswith("--") and token.endswith("=")) for token in tokens):
            return _refused("one of the arguments is empty: is a variable of the shell not set? Give a value, or leave it out")
        if strange := next((token for token in tokens if not _is_text(token)), ""):
            encoding = sys.getfilesystemencoding()
            return _refused(f"{strange}: this is no text in {encoding}; name it otherwise, or set PYTHONUTF8=1 if it is UTF-8")
        with _old_names_shown():
            return int(app(tokens) or WITHIN)
    except KeyboardInterrupt as stop:
        return _interrupted(str(stop))
    except Exception as fault:  # noqa: BLE001 (the outermost door: nothing may leave it but an exit code)
        return _said(fault, tokens, received)


@contextmanager
def _old_names_shown() -> Generator[None, None, None]:
    """Each old name of a key that is read, in one line on stderr: Python itself shows no DeprecationWarning of a library."""
    shown: set[str] = set()
    with warnings.catch_warnings():
        others = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if not (issubclass(category, DeprecationWarning) and " is now called " in str(message)):
                others(message, category, *place, **more)
            elif str(message) not in shown:
                from reports.console import complain

                shown.add(str(message))
                complain(f"Note: {message}.")

        warnings.filterwarnings("always", ".* is now called ", DeprecationWarning)
        warnings.showwarning = show
        yield


def _said(fault: Exception, tokens: list[str], received: Sequence[int]) -> int:
    """The exit code of what went wrong, and its sentence on stderr."""
    # scenes is heavy: it is imported when it must have been imported already, never for --help.
    if isinstance(fault, ValueError | RuntimeError):
        from scenes import ConvergenceError, InputError

        if isinstance(fault, InputError):
            return _refused(_one_line(str(fault)))
        if isinstance(fault, ConvergenceError):
            _refused(f"not converged: {_one_line(str(fault))}")
            return NOT_CONVERGED
    if isinstance(fault, CycloptsError):
        from reports.misspelt import sentence

        return _refused(sentence(fault))
    if isinstance(fault, MemoryError):
        why = f" ({_one_line(str(fault))})" if str(fault) else ""
        return _refused(f"there is not enough memory for this{why}; ask for a coarser mesh, fewer steps or fewer instants")
    if isinstance(fault, OSError):
        return _refused(_of_the_system(fault))
    # Compiled modules and locks make another error of Ctrl-C.
    return _interrupted("") if received else _internal(fault, tokens)


def _interrupted(what: str) -> int:
    _refused(f"interrupted; {what or 'nothing was written'}")
    return INTERRUPTED


def _internal(fault: Exception, tokens: Sequence[str]) -> int:
    """A fault of the program: one sentence, and where its traceback is."""
    lines = [time.strftime("%Y-%m-%d %H:%M:%S %z  ") + shlex.join(["halfplane", *tokens]), *traceback.format_exception(fault)]
    place = _kept("\n".join(line.rstrip("\n") for line in lines) + "\n")
    what = ": ".join(filter(None, (type(fault).__name__, textwrap.shorten(str(fault), 200, placeholder=" ...").rstrip("."))))
    _refused(f"internal error, a fault of halfplane: {what}; the traceback is {place}: please report it")
    return INTERNAL


def _kept(text: str) -> str:
    """Keep a traceback in run.log of the output folder, else in the temporary folder, else on stderr; where that is, in words."""
    from reports.console import complain

    folder = output_folder.get()
    if folder is not None:
        from reports.folder import add_to_log

        # Where the folder can't take it, the next place does.
        with suppress(Exception):
            return f"in {add_to_log(folder, text)}"
    try:
        handle, name = tempfile.mkstemp(prefix="halfplane-", suffix=".log")
        with open(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
        return f"in {name}"
    except OSError:
        complain(text)
        return "above"


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
