"""A whole load path through the interface: initial loading, then revolutions until the state repeats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import ContactProblem, InterfaceState, untouched
from halfplane_fe.energy import certificates
from halfplane_fe.path import stretches
from halfplane_fe.stepping import Increment, follow
from scenes import ConvergenceError, Interrupted, LoadPath, LoadSegment

Array = NDArray[np.float64]
Progress = Callable[[int, int | None, str], None]

# Two revolutions end alike when no nodal force differs by more than this share of the largest. Nodes at the rim of the permanent
# stick zone go on creeping towards the steady cycle, each time a tenth as far; what they leave is far below the mesh error.
REPEATS = 5e-4
# Dissipation over f^2 P^2/E* below which the step error need not follow it down.
_LEAST_DISSIPATION = 1e-2


@dataclass(eq=False)
class PathRun:
    """What a load path left behind; the first of `states` is the unloaded one.

    Attributes
    ----------
    states : (n_steps + 1)
    increments, checks : (n_steps)
    cycle_starts : index of the state at which each revolution starts
    cycle_density : per revolution, (n,) dissipation of each node; one for the whole path where it is not periodic
    steady_from : index of the first revolution that ended as it started
    cycle_change : per revolution, largest change of a nodal p or q/f (f < 1) from its start to its end, over the largest p
    failure : what stopped the run, or None
    """

    states: list[InterfaceState]
    increments: list[Increment] = field(default_factory=list)
    checks: list[dict[str, float]] = field(default_factory=list)
    cycle_starts: list[int] = field(default_factory=list)
    cycle_density: list[Array] = field(default_factory=list)
    steady_from: int | None = None
    cycle_change: list[float] = field(default_factory=list)
    failure: ConvergenceError | Interrupted | None = None


@dataclass(frozen=True)
class Pace:
    """How finely a path is stepped.

    Attributes
    ----------
    load : what loads are divided by
    steps_per_cycle : regular increments of one revolution, or of the longest leg of a polygon
    step_tolerance : step error of a revolution over its dissipation that calls for shorter increments
    """

    load: float
    steps_per_cycle: int
    step_tolerance: float


def run_path(problem: ContactProblem, path: LoadPath, pace: Pace, cycles: int, progress: Progress) -> PathRun:
    """Follow `path` for at most `cycles` revolutions; stop once a revolution repeats.

    Neither a ConvergenceError nor Ctrl-C gets lost: it ends the run and is kept in `failure` with everything solved before it.
    """
    run = PathRun([untouched(problem.height, path.start)])
    try:
        _follow_legs(problem, run, path.initial_loading, pace.steps_per_cycle / 8, pace, progress, "initial loading")
        if path.period is None:
            run.cycle_density.append(_density(problem, run.increments))
            return run
        for number in range(cycles):
            before = run.states[-1]
            first = len(run.increments)
            run.cycle_starts.append(first)
            _follow_legs(problem, run, path.cycle_legs(number), pace.steps_per_cycle, pace, progress, f"revolution {number + 1}")
            run.cycle_density.append(_density(problem, run.increments[first:]))
            run.cycle_change.append(_change(before, run.states[-1], problem.friction))
            if run.cycle_change[-1] <= REPEATS:
                run.steady_from = number
                break
    except ConvergenceError as failure:
        run.failure = failure
    except KeyboardInterrupt:
        _drop_unfinished(run)
        run.failure = Interrupted(f"interrupted at time {run.states[-1].time:.6g}, after {len(run.increments)} steps")
    return run


def _drop_unfinished(run: PathRun) -> None:
    """Leave only steps of which everything is there: an interrupt falls between any two instructions."""
    whole = min(len(run.increments), len(run.checks), len(run.states) - 1)
    del run.increments[whole:], run.checks[whole:], run.states[whole + 1 :]
    run.cycle_starts[:] = [start for start in run.cycle_starts if start <= whole]


def _density(problem: ContactProblem, increments: list[Increment]) -> Array:
    """Dissipation of each node in a number of increments."""
    return sum((increment.energy.dissipation for increment in increments), np.zeros_like(problem.height))


def _follow_legs(
    problem: ContactProblem, run: PathRun, legs: tuple[LoadSegment, ...], steps: float, pace: Pace, progress: Progress, text: str
) -> None:
    longest = max(leg.end - leg.start for leg in legs)
    pieces = [piece for leg in legs for piece in stretches(leg, problem.friction, steps * (leg.end - leg.start) / longest)]
    duration = legs[-1].end - legs[0].start
    # What the tolerance refers to: the dissipation of the revolution before; until there is one, a share of f^2 P^2/E*.
    expected = float(run.cycle_density[-1].sum()) if run.cycle_density else 0.0
    # Rounded down to a power of two: what the initial loading left in the revolution before shall not choose other increments.
    reference = max(2.0 ** np.floor(np.log2(max(expected, 1e-300))), _LEAST_DISSIPATION * problem.friction**2)

    def allowed(time: float) -> float:
        return pace.step_tolerance * reference * time / duration

    def said() -> str:
        return f"{text}, {len(run.increments)} steps, {problem.work['contact iterations']} contact iterations"

    for done, piece in enumerate(pieces):
        progress(done, len(pieces), said())
        for increment in follow(problem, run.states[-1], piece, pace.load, allowed):
            run.checks.append(certificates(problem, run.states[-1], increment.solved))
            run.increments.append(increment)
            run.states.append(increment.state)
    progress(len(pieces), len(pieces), said())


def _change(before: InterfaceState, after: InterfaceState, friction: float) -> float:
    """Largest change of a nodal p, or of a nodal q over f, over the largest p: with little friction all of q is little."""
    pressure, shear = (np.abs(getattr(after, name) - getattr(before, name)).max() for name in ("pressure", "shear"))
    return float(max(pressure, shear / min(friction, 1.0) if shear > 0 else 0.0) / np.max(after.pressure))
