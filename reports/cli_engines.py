"""The commands that solve: both engines, each alone, fields, the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from reports.application import JUDGE, SOLVE, Json, Out, Quiet, SceneName, app
from reports.options import FiniteElementOptions

_DEFAULTS = FiniteElementOptions()
_THIRD_LIMIT = 1800.0
CoarseMesh = Annotated[
    bool,
    Parameter(help="Solve on a coarse mesh too: what that changes, the dissipation is uncertain by at least."),
]


@app.command(group=SOLVE, sort_key=1, help_epilogue="")
def run(
    scene: SceneName,
    *,
    out: Out = None,
    vtu: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='Write both bodies for ParaView at these times, or at "events".'),
    ] = (),
    stress: Annotated[
        tuple[str, ...],
        Parameter(consume_multiple=True, negative="", help='Show von Mises stress on the page at these times, or at "events".'),
    ] = (),
    pdf: Annotated[bool, Parameter(negative="", help="Write report.pdf too; needs the extra halfplane[pdf].")] = False,
    budget: Annotated[
        bool, Parameter(negative="", help="Measure where the discrepancy comes from: coarser meshes, other far fields.")
    ] = False,
    third: Annotated[Literal["calculix"] | None, Parameter(help="A third opinion: runs `ccx` on the exported deck.")] = None,
    third_limit: Annotated[
        float | None, Parameter(help="Seconds after which the third opinion is stopped; 1800 if left out.")
    ] = None,
    coarse_mesh: CoarseMesh = True,
    json: Annotated[bool, Parameter(negative="", help="The verdict as JSON on stdout, and nothing else there.")] = False,
    quiet: Quiet = False,
    finite_elements: FiniteElementOptions = _DEFAULTS,
) -> int:
    """Both engines on one scene: verdict, page and data."""
    from reports import commands_engines
    from scenes import InputError

    if third is None and third_limit is not None:
        raise InputError(f"--third-limit {third_limit:g}: it goes with --third calculix")
    limit = None if third is None else _THIRD_LIMIT if third_limit is None else third_limit
    return commands_engines.run(
        scene,
        out,
        vtu,
        quiet,
        finite_elements,
        budget=budget,
        third_limit=limit,
        stress=stress,
        pdf=pdf,
        coarse_mesh=coarse_mesh,
        as_json=json,
    )


@app.command(group=SOLVE, sort_key=6, help_epilogue="")
def export(
    scene: SceneName,
    *,
    to: Annotated[Literal["calculix", "abaqus"], Parameter(help="The dialect of the deck.")],
    out: Out = None,
    steps_per_cycle: Annotated[int | None, Parameter(help="Instants of a revolution; turning points come on top.")] = None,
    cycles: Annotated[int | None, Parameter(help="Revolutions at most.")] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """The bodies and the load history as an input deck for another code."""
    from reports.third import exporting

    return exporting.export(scene, to, out, steps_per_cycle, cycles, quiet, json)


@app.command(group=SOLVE, sort_key=2, help_epilogue="")
def exact(scene: SceneName, *, out: Out = None, json: Json = False, quiet: Quiet = False) -> int:
    """Half-plane theory alone: summary, NetCDF and CSV, no page."""
    from reports import commands_engines

    return commands_engines.exact(scene, out, quiet, json)


@app.command(group=SOLVE, sort_key=3, help_epilogue="")
def fe(
    scene: SceneName,
    *,
    out: Out = None,
    coarse_mesh: CoarseMesh = True,
    json: Json = False,
    quiet: Quiet = False,
    finite_elements: FiniteElementOptions = _DEFAULTS,
) -> int:
    """Finite elements alone: summary, NetCDF and CSV, no page."""
    from reports import commands_engines

    return commands_engines.fe(scene, out, quiet, finite_elements, json, coarse_mesh=coarse_mesh)


@app.command(group=SOLVE, sort_key=4, help_epilogue="")
def fields(
    scene: SceneName,
    *,
    at: Annotated[
        tuple[str, ...],
        Parameter(
            consume_multiple=True,
            negative="",
            help='Times of the path, or "events" of the last cycle, the default without a series.',
        ),
    ] = (),
    every: Annotated[int | None, Parameter(help="A series over the last cycle: every Nth stored step.")] = None,
    frames: Annotated[int | None, Parameter(help="A series over the last cycle: N instants evenly in time.")] = None,
    animate: Annotated[
        bool,
        Parameter(
            negative="", help="The cycle as GIF and MP4: the instants of the series, 60 without one. MP4: halfplane[animation]."
        ),
    ] = False,
    out: Out = None,
    pictures: Annotated[bool, Parameter(help="Draw the meshes and the von Mises stress at the instants of --at as PNG.")] = True,
    json: Json = False,
    quiet: Quiet = False,
    finite_elements: FiniteElementOptions = _DEFAULTS,
) -> int:
    """Displacement, stress and tractions in both bodies: files for ParaView, pictures, an animation."""
    from reports import commands_engines
    from reports.series import Wish

    return commands_engines.fields(scene, Wish(at, every, frames, pictures, animate), out, quiet, finite_elements, json)


@app.command(group=JUDGE, sort_key=5, help_epilogue="")
def paper(
    *,
    out: Annotated[Path | None, Parameter(help="Folder for the results; out/paper if left out.")] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """The paper again from half-plane theory: its figures, statements and misprints."""
    from reports import commands_engines

    return commands_engines.paper(out, quiet, json)
