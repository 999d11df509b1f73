"""The application `halfplane`: its help, its exit codes, and the parameters that commands share."""

from __future__ import annotations

from contextvars import ContextVar
from pathlib import Path
from typing import Annotated

from cyclopts import App, Group, Parameter

WITHIN, OUTSIDE, BAD_INPUT, NOT_CONVERGED, INTERNAL, INTERRUPTED = 0, 1, 2, 3, 70, 130

# The folder that the running command writes to, once it is known: run.log there takes the traceback of an internal error.
output_folder: ContextVar[Path | None] = ContextVar("output_folder", default=None)


# The list of commands by use, and within a group by `sort_key`.
SOLVE, JUDGE, SCENES, MACHINE = (Group(name, sort_key=k) for k, name in enumerate(("Solve", "Judge", "Scenes", "Machine")))


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("halfplane")
    except PackageNotFoundError:
        return "not installed: run from a checkout"


_HELP = "How wrong is the half-plane idealisation? One scene, two engines, one report."
_EXAMPLES = """\
Examples:
  halfplane scenes                          what the library has
  halfplane run hertz-paper                 both engines, verdict and page
  halfplane run hertz-paper --steps-per-cycle 320 --out out/fine
  halfplane run blocks --budget             where the discrepancy comes from
  halfplane init my.toml                    a commented scene to start from
  halfplane init my.toml --bodies           the same with a block and a pad
  halfplane check my.toml                   is it read, is it admissible?
  halfplane exact my.toml                   half-plane theory alone
  halfplane fe my.toml --method penalty     finite elements alone
  halfplane fields my.toml --at 12.6 14.1   both bodies for ParaView, pictures
  halfplane score my.csv --scene hertz-paper  somebody else's result
  halfplane export my.toml --to calculix    a deck for another code
  halfplane diff out/a out/b                two runs, or a run and a baseline
  halfplane sweep study.toml                a scene over axes of its keys
  halfplane advise my.toml                  may half-plane theory be used?
  halfplane paper                           the paper's figures and statements
  halfplane completion bash                 a script that completes words
Exit codes: 0 within tolerance, 1 outside or undecided, 2 bad input,
            3 not converged, 70 internal error, 130 interrupted (143 by
            SIGTERM, 129 by SIGHUP), 141 nobody read on.
"""

app = App(
    name="halfplane",
    help=_HELP,
    help_epilogue=_EXAMPLES,
    help_format="plaintext",
    version=_version,
    suppress_keyboard_interrupt=False,
    exit_on_error=False,
    print_error=False,
    result_action="return_value",
    group_commands=MACHINE,
)

Out = Annotated[Path | None, Parameter(help="Folder for the results; out/<scene name> if left out.")]
SceneName = Annotated[str, Parameter(help="Name of a library scene, or a .toml or .json file.")]
Quiet = Annotated[bool, Parameter(negative="", help="No progress on stderr.")]
Silent = Annotated[bool, Parameter(negative="", help="Say nothing: the exit code tells.")]
Json = Annotated[bool, Parameter(negative="", help="As JSON on stdout, and nothing else there.")]
