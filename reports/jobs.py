"""The job: from a scene to solutions, stage by stage. Everything heavy is imported here, inside the stages."""

from __future__ import annotations

import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from meshes.interrupts import interrupts_wait
from reports.checking import require_admissible
from reports.console import Stages
from reports.folder import FilledBefore
from reports.options import FiniteElementOptions
from scenes import ContactSolution, InputError, Interrupted, Scene, load_scene

if TYPE_CHECKING:
    from reports.comparison import Comparison
    from reports.comparison import Report as Found
    from reports.third.opinion import ThirdOpinion


@dataclass(frozen=True)
class Report:
    """What a run leaves: the report, the path of its page, and the wall time of each stage."""

    found: Found
    page: Path
    seconds: Mapping[str, float]

    @property
    def comparison(self) -> Comparison:
        """What was compared."""
        return self.found.comparison

    @property
    def third(self) -> ThirdOpinion | None:
        """The answer of another code, if that was asked."""
        return self.found.third


def read(source: str) -> Scene:
    """The scene of `source`, its load path checked; InputError in a sentence otherwise."""
    scene = load_scene(source)
    require_admissible(scene, source)
    return scene


@contextmanager
def naming(source: str) -> Generator[None, None, None]:
    """Lets an engine's InputError name the scene it is about; one about an option or the file names that already."""
    try:
        yield
    except InputError as fault:
        if str(fault).startswith((source, "--")):
            raise
        raise InputError(f"{source}: {fault}") from fault


def load_engines(stages: Stages) -> None:
    """Import the engines as a stage of its own; InputError where a library can't be loaded."""
    with stages.stage("loading"):
        try:
            with interrupts_wait():  # compiled modules make an ImportError of it
                import_module("halfplane_fe")
                import_module("semi_analytic")
        except (ImportError, OSError) as reason:
            raise InputError(f"the engines can't be loaded: {reason}; `halfplane doctor` says what is missing") from reason


def solve_finite_elements(
    scene: Scene, options: FiniteElementOptions, stages: Stages, *, coarse_mesh: bool = False
) -> ContactSolution:
    """The finite-element answer, with what its dissipation is uncertain by at least if a coarse mesh is wanted for that."""
    import halfplane_fe

    mesh, settings = options.settings()
    with stages.stage("finite elements") as report:
        return halfplane_fe.solve(scene, mesh=mesh, settings=settings, progress=report, coarse_mesh=coarse_mesh)


def solve_half_plane(
    scene: Scene, stages: Stages, like: ContactSolution | None = None, *, straight_steps: bool = False
) -> ContactSolution:
    """The half-plane answer, on the points and instants of `like`."""
    import semi_analytic

    name = "half-plane theory" + (", on the polygon of the steps" if straight_steps else "")
    with stages.stage(name):
        if like is None:
            return semi_analytic.solve(scene)
        return semi_analytic.solve(scene, x=like.x, time=like.time, straight_steps=straight_steps)


def run(
    scene: Scene,
    out: Path,
    options: FiniteElementOptions,
    stages: Stages,
    *,
    vtu: tuple[str, ...] = (),
    budget: bool = False,
    command: str = "",
    third_limit: float | None = None,
    stress: tuple[str, ...] = (),
    pdf: bool = False,
    coarse_mesh: bool = False,
) -> Report:
    """Both engines, the comparison, with `budget` where its errors come from, and the report.

    With `third_limit`, in seconds, CalculiX' answer stands beside them; with `coarse_mesh`, what the dissipation is uncertain by.
    """
    if third_limit is not None:
        from reports.third.running import find_calculix

        find_calculix()  # before anything is solved
    if pdf:
        from reports.pdf import require_typst

        require_typst("--pdf")
    begun = time.process_time()
    result = solve_finite_elements(scene, options, stages, coarse_mesh=coarse_mesh)
    with _keeping(result):
        reference = solve_half_plane(scene, stages, result)
        polygon = solve_half_plane(scene, stages, result, straight_steps=True)
        with stages.stage("comparison"):
            from reports.comparison import Report as Found
            from reports.comparison import compare

            comparison = compare(reference, result, polygon_reference=polygon)
        found = Found(comparison)
        if budget:
            found = _with_budget(comparison, options, stages, time.process_time() - begun)
        if third_limit is not None:
            found = replace(found, third=_third(scene, options, result, third_limit, stages, command))
        with stages.stage("report"):
            from reports.fields import instants_of
            from reports.page.writing import write

            instants = [instant.time for instant in instants_of(vtu, result, "--vtu")]
            page = write(
                found,
                out,
                vtu_instants=instants,
                command=command,
                seconds=dict(stages.seconds),
                stress_instants=instants_of(stress, result, "--stress"),
                pdf=pdf,
                log=(f"{time.strftime('%Y-%m-%d %H:%M:%S %z')}  {command}", *stages.log),
            )
        return Report(found, page, stages.seconds)


@contextmanager
def _keeping(result: ContactSolution) -> Generator[None, None, None]:
    """Ctrl-C after the finite elements are solved hands on what they found, but where the whole report was written already."""
    try:
        yield
    except FilledBefore:
        raise
    except KeyboardInterrupt as stop:
        raise Interrupted("interrupted after the finite elements were solved", result) from stop


def _third(
    scene: Scene, options: FiniteElementOptions, result: ContactSolution, limit: float, stages: Stages, command: str
) -> ThirdOpinion:
    """CalculiX on the exported deck, at the instants a revolution that were asked for, if any were."""
    from reports.third.opinion import ask_calculix
    from reports.third.settings import DeckSettings

    steps = options.steps_per_cycle
    settings = DeckSettings() if steps is None else DeckSettings(steps_per_cycle=steps)
    return ask_calculix(scene, settings, limit, stages, getattr(result, "scales", None), command)


def _with_budget(comparison: Comparison, options: FiniteElementOptions, stages: Stages, plain_seconds: float) -> Found:
    """The comparison with its error budget: every rung a stage of its own."""
    from reports.comparison.budget import climb, error_budget, with_budget

    ladders = climb(comparison, *options.settings(), stages.stage)
    return with_budget(comparison, error_budget(comparison, ladders, plain_seconds))
