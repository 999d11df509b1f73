"""The job: from a scene to solutions, stage by stage. Everything heavy is imported here, inside the stages."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from reports.checking import require_admissible
from reports.console import Stages
from reports.options import FiniteElementOptions
from scenes import ContactSolution, InputError, Scene, load_scene

if TYPE_CHECKING:
    from reports.comparison import Comparison


@dataclass(frozen=True)
class Report:
    """What a run leaves: the comparison, the path of the page, and the wall time of each stage."""

    comparison: Comparison
    page: Path
    seconds: Mapping[str, float]


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
            import_module("halfplane_fe")
            import_module("semi_analytic")
        except (ImportError, OSError) as reason:
            raise InputError(f"the engines can't be loaded: {reason}; `halfplane doctor` says what is missing") from reason


def solve_finite_elements(scene: Scene, options: FiniteElementOptions, stages: Stages) -> ContactSolution:
    """The finite-element answer."""
    import halfplane_fe

    mesh, settings = options.settings()
    with stages.stage("finite elements") as report:
        return halfplane_fe.solve(scene, mesh=mesh, settings=settings, progress=report)


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
    command: str = "",
) -> Report:
    """Both engines, the comparison and the report."""
    result = solve_finite_elements(scene, options, stages)
    reference = solve_half_plane(scene, stages, result)
    polygon = solve_half_plane(scene, stages, result, straight_steps=True)
    with stages.stage("comparison"):
        from reports.comparison import compare

        comparison = compare(reference, result, polygon_reference=polygon)
    with stages.stage("report"):
        from reports.writing import write

        page = write(comparison, out, vtu_instants=vtu_instants(vtu, comparison), command=command, seconds=dict(stages.seconds))
    return Report(comparison, page, stages.seconds)


def vtu_instants(asked: tuple[str, ...], comparison: Comparison) -> tuple[float, ...]:
    """Times meant by --vtu: numbers are times, "events" the instants of the traction figure."""
    from reports.instants import events

    times: list[float] = []
    for word in asked:
        if word == "events":
            chosen = events(comparison.found, comparison.scene.friction.coefficient)
            times.extend(float(comparison.found.time[event.index]) for event in chosen)
        else:
            times.append(vtu_time(word))
    return tuple(sorted(set(times)))


def vtu_time(word: str) -> float:
    """A time from the command line; InputError for anything else."""
    try:
        return float(word)
    except ValueError:
        raise InputError(f"--vtu {word}: give times of the path, or events for the instants of the page") from None
