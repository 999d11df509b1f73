"""A whole load path through the interface: way in, then revolutions until the state repeats."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import ContactProblem, InterfaceState, untouched
from halfplane_fe.energy import IncrementEnergy, certificates, increment_energy
from halfplane_fe.path import stretches
from halfplane_fe.stepping import Increment, follow
from scenes import ConvergenceError, Leg, LoadPath

Array = NDArray[np.float64]
Progress = Callable[[int, int | None, str], None]

# Two revolutions end alike when no nodal force differs by more than this share of the largest. Nodes at the rim of the permanent
# stick zone go on creeping towards the steady cycle, each time a tenth as far; what they leave is far below the mesh error.
REPEATS = 5e-4


@dataclass(eq=False)
class PathRun:
    """What a load path left behind; the first of `states` is the unloaded one.

    Attributes
    ----------
    states, increments : (n_steps + 1) and (n_steps)
    energies, checks : one per increment
    cycle_density : per revolution, (n,) dissipation of each node; one for the whole path where it is not periodic
    steady_from : index of the first revolution that ended as it started
    cycle_change : per revolution, largest change of a nodal force from its start to its end, over the largest force
    failure : what stopped the run, or None
    """

    states: list[InterfaceState]
    increments: list[Increment] = field(default_factory=list)
    energies: list[IncrementEnergy] = field(default_factory=list)
    checks: list[dict[str, float]] = field(default_factory=list)
    cycle_density: list[Array] = field(default_factory=list)
    steady_from: int | None = None
    cycle_change: list[float] = field(default_factory=list)
    failure: ConvergenceError | None = None


def run_path(
    problem: ContactProblem, path: LoadPath, scale: float, steps_per_cycle: int, cycles: int, progress: Progress
) -> PathRun:
    """Follow `path`, loads divided by `scale`, for at most `cycles` revolutions; stop once a revolution repeats.

    A ConvergenceError does not get lost: it ends the run and is kept in `failure` with everything solved before it.
    """
    run = PathRun([untouched(problem.height, path.start)])
    try:
        _follow_legs(problem, run, path.way_in, steps_per_cycle / 8, scale, progress, "way in")
        if path.period is None:
            run.cycle_density.append(sum((e.dissipation for e in run.energies), np.zeros_like(problem.height)))
            return run
        for number in range(cycles):
            before = run.states[-1]
            first = len(run.energies)
            _follow_legs(problem, run, path.cycle_legs(number), steps_per_cycle, scale, progress, f"revolution {number + 1}")
            run.cycle_density.append(sum((e.dissipation for e in run.energies[first:]), np.zeros_like(problem.height)))
            run.cycle_change.append(_change(before, run.states[-1]))
            if run.cycle_change[-1] <= REPEATS:
                run.steady_from = number
                break
    except ConvergenceError as failure:
        run.failure = failure
    return run


def _follow_legs(
    problem: ContactProblem,
    run: PathRun,
    legs: tuple[Leg, ...],
    steps: float,
    scale: float,
    progress: Progress,
    text: str,
) -> None:
    longest = max(leg.end - leg.start for leg in legs)
    pieces = [piece for leg in legs for piece in stretches(leg, problem.friction, steps * (leg.end - leg.start) / longest)]
    for done, piece in enumerate(pieces):
        progress(done, len(pieces), text)
        for increment in _increments(problem, run, follow(problem, run.states[-1], piece, scale)):
            run.increments.append(increment)
            run.states.append(increment.state)
    progress(len(pieces), len(pieces), text)


def _increments(problem: ContactProblem, run: PathRun, following: Iterator[Increment]) -> Iterator[Increment]:
    """Pass increments on, keeping the books of each."""
    for increment in following:
        run.energies.append(increment_energy(problem, run.states[-1], increment.solved))
        run.checks.append(certificates(problem, run.states[-1], increment.solved))
        yield increment


def _change(before: InterfaceState, after: InterfaceState) -> float:
    change = max(np.abs(after.pressure - before.pressure).max(), np.abs(after.shear - before.shear).max())
    return float(change / np.max(after.pressure))
