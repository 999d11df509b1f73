"""The command line `halfplane`: names, options, exit codes. What a command does is in `commands`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter

from reports.options import FiniteElementOptions

WITHIN, OUTSIDE, BAD_INPUT, NOT_CONVERGED, INTERRUPTED = 0, 1, 2, 3, 130


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
  halfplane diff out/a out/b                two runs, or a run and a baseline
  halfplane paper                           the paper's figures and statements
Exit codes: 0 within tolerance, 1 outside, 2 bad input, 3 not converged,
            130 interrupted.
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
)

Out = Annotated[Path | None, Parameter(help="Folder for the results; out/<scene name> if left out.")]
SceneName = Annotated[str, Parameter(help="Name of a library scene, or a .toml or .json file.")]
Quiet = Annotated[bool, Parameter(negative="", help="No progress on stderr.")]
_DEFAULTS = FiniteElementOptions()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    tokens = list(sys.argv[1:] if arguments is None else arguments)
    try:
        return int(app(tokens) or WITHIN)
    except CycloptsError as fault:
        return _refused(f"{_one_line(str(fault))}; `halfplane --help` shows commands and options")
    except ValueError as fault:
        # scenes is heavy: it is imported when it must have been imported already, never for --help.
        from scenes import InputError

        if not isinstance(fault, InputError):
            raise
        return _refused(_one_line(str(fault)))
    except KeyboardInterrupt:
        _refused("interrupted; nothing was written")
        return INTERRUPTED


def _refused(sentence: str) -> int:
    from reports.console import complain

    complain(f"halfplane: {sentence}")
    return BAD_INPUT


def _one_line(text: str) -> str:
    return " ".join(text.split()).rstrip(".")


@app.command(sort_key=1, help_epilogue="")
def run(
    scene: SceneName,
    *,
    out: Out = None,
    vtu: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='Write both bodies for ParaView at these times, or at "events".'),
    ] = (),
    budget: Annotated[
        bool, Parameter(negative="", help="Measure where the discrepancy comes from: coarser meshes, other far fields.")
    ] = False,
    quiet: Quiet = False,
    finite_elements: FiniteElementOptions = _DEFAULTS,
) -> int:
    """Both engines on one scene: verdict, page and data."""
    from reports import commands

    return commands.run(scene, out, vtu, quiet, finite_elements, budget=budget)


@app.command(sort_key=2, help_epilogue="")
def exact(scene: SceneName, *, out: Out = None, quiet: Quiet = False) -> int:
    """Half-plane theory alone: summary, NetCDF and CSV, no page."""
    from reports import commands

    return commands.exact(scene, out, quiet)


@app.command(sort_key=3, help_epilogue="")
def fe(scene: SceneName, *, out: Out = None, quiet: Quiet = False, finite_elements: FiniteElementOptions = _DEFAULTS) -> int:
    """Finite elements alone: summary, NetCDF and CSV, no page."""
    from reports import commands

    return commands.fe(scene, out, quiet, finite_elements)


@app.command(sort_key=3, help_epilogue="")
def fields(
    scene: SceneName,
    *,
    at: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='Times of the path, or "events" of the last cycle, the default.'),
    ] = (),
    out: Out = None,
    pictures: Annotated[bool, Parameter(help="Draw the meshes and the von Mises stress as PNG.")] = True,
    quiet: Quiet = False,
    finite_elements: FiniteElementOptions = _DEFAULTS,
) -> int:
    """Displacement and stress in both bodies: files for ParaView, pictures of stress and mesh."""
    from reports import commands

    return commands.fields(scene, at, out, pictures, quiet, finite_elements)


@app.command(sort_key=3, help_epilogue="")
def paper(
    *, out: Annotated[Path | None, Parameter(help="Folder for the results; out/paper if left out.")] = None, quiet: Quiet = False
) -> int:
    """The paper again from half-plane theory: its figures, statements and misprints."""
    from reports import commands

    return commands.paper(out, quiet)


@app.command(sort_key=3, help_epilogue="")
def diff(
    a: Annotated[str, Parameter(help="Folder of a run, its comparison.json, a solution (.nc), or a baseline.")],
    b: Annotated[str, Parameter(help="The same; with --accept the baseline to write.")],
    *,
    tolerance: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='KEY=VALUE of one figure, or of many: "metric.*=1e-4".'),
    ] = (),
    accept: Annotated[bool, Parameter(negative="", help="Make B a baseline of A; the tolerances given are kept in it.")] = False,
    json: Annotated[bool, Parameter(negative="", help="The table as JSON.")] = False,
) -> int:
    """Two runs, or a run and a baseline, figure by figure: 0 the same within tolerance, 1 not."""
    from reports import regression

    return regression.diff(a, b, tolerance, accept, json)


@app.command(sort_key=4, help_epilogue="")
def scenes() -> int:
    """The library of scenes."""
    from reports import commands

    return commands.scenes()


@app.command(sort_key=5, help_epilogue="")
def init(
    file: Annotated[Path, Parameter(help="New file, ending in .toml.")],
    *,
    like: Annotated[str, Parameter(help="Start from this library scene instead of the commented example.")] = "",
    bodies: Annotated[bool, Parameter(negative="", help="The example with a block and a pad in place of half-planes.")] = False,
) -> int:
    """Write a commented scene to start from; never over a file that exists."""
    from reports import commands

    return commands.init(file, like, bodies)


@app.command(sort_key=6, help_epilogue="")
def check(scene: SceneName) -> int:
    """Read a scene, and see whether its loads stay clear of gross sliding and separation."""
    from reports import commands

    return commands.check(scene)


@app.command(sort_key=7, help_epilogue="")
def schema() -> int:
    """The JSON schema of a scene file, for editors."""
    from reports import commands

    return commands.schema()


@app.command(sort_key=8, help_epilogue="")
def doctor(*, out: Out = None) -> int:
    """Can this machine do the work?"""
    from reports import commands

    return commands.doctor(out)
