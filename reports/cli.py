"""The command line `halfplane`, from its words to an exit code. Each module that is imported here registers its commands; what a
command does is in `commands_engines`, `commands_scenes` and `commands_machine`, and heavy packages are loaded there."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from cyclopts import CycloptsError

from reports import cli_engines, cli_maps, cli_results, cli_scenes, cli_sweep  # noqa: F401 (they register themselves)
from reports.application import BAD_INPUT, INTERRUPTED, NOT_CONVERGED, WITHIN, app


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    tokens = list(sys.argv[1:] if arguments is None else arguments)
    try:
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
    except KeyboardInterrupt:
        _refused("interrupted; nothing was written")
        return INTERRUPTED


def _refused(sentence: str) -> int:
    from reports.console import complain

    complain(f"halfplane: {sentence}")
    return BAD_INPUT


def _one_line(text: str) -> str:
    return " ".join(text.split()).rstrip(".")
