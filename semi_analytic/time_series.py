"""Long measured histories: friction work, stick and direction of slip row by row, without an object for each step.

# notation: A = 2/E*; P_c load at the front of slip, c = a(P_c); w level +-Q - f P

W = (f A/pi) int Lam(P, P_c) dw; along a record of the stack P and P_c are linear in w.
"""

from __future__ import annotations

import itertools
import time as clock
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes import InadmissibleLoadError, InputError, Scene, StraightLeg, TimeSeriesLoad, Work, freeze
from semi_analytic.contact import Contact, contact_of
from semi_analytic.elasticity import composite_modulus
from semi_analytic.history import check
from semi_analytic.pile import ROOTS
from semi_analytic.stack import Followed, Records, Stack, follow_rows

Array = NDArray[np.float64]

_ROUNDING = 1e-14
_REPEATS = 1e-12
_CHUNK = 200_000
# Nodes of Gauss' rule while P and P_c change by less than a share: 3e-13 by the distance of the singularity. Above, graded.
_RULES = ((0.05, 4), (0.3, 6), (0.6, 12), (0.9, 24))


@dataclass(frozen=True, eq=False)
class SeriesSolution:
    """What a time series does to the contact; one entry a row, the first row being the unloaded state.

    Attributes
    ----------
    time, normal_load, tangential_load : (n,) the rows; for a series that repeats, those of the last cycle
    contact_half_width, stick_half_width : (n,) a and c; c = a where nothing slips
    direction : (n,) +1 forward slip, -1 reverse slip, 0 none, in the step that ends at the row
    dissipation_so_far : (n,) friction work up to the row [energy per unit thickness]
    dissipation, forward, reverse : all of it, and its two parts
    cycle_dissipation : (n_cycles,) of each solved cycle; one for a series that does not repeat
    steady_from : index of the first cycle that ended as it began, None if none did
    work : rows, slips, pieces_alive, pieces_dropped; seconds
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    contact_half_width: Array
    stick_half_width: Array
    direction: NDArray[np.int8]
    dissipation_so_far: Array
    dissipation: float
    forward: float
    reverse: float
    cycle_dissipation: Array
    steady_from: int | None
    work: Work


def solve_series(scene: Scene) -> SeriesSolution:
    """The history of a scene whose load is a time series, of a million rows too.

    Raises
    ------
    InputError
        For a scene with another load.
    InadmissibleLoadError
        For gross sliding or separation, with the instant and the loads.

    >>> from scenes import load_scene
    >>> rows = [[0, 2, 0], [1, 2, 0.5], [2, 2, -0.5], [3, 2, 0.5]]
    >>> scene = load_scene("cattaneo-mindlin").model_copy(update={"load": TimeSeriesLoad(rows=rows)})
    >>> solution = solve_series(scene)
    >>> solution.direction.tolist(), solution.work.counts["pieces_alive"]
    ([0, 0, 1, -1, 1], 3)
    """
    if not isinstance(scene.load, TimeSeriesLoad):
        raise InputError(f"load.kind = {scene.load.kind!r}: a time series is needed; `solve` does the others")
    started = clock.perf_counter()
    rows, friction = scene.load.series(), scene.friction.coefficient
    _check_rows(rows, friction)
    contact, modulus = contact_of(scene.profile, scene.material), composite_modulus(scene.material)
    stack = Stack(friction)
    if not scene.load.repeats:
        runs = [follow_rows(stack, rows[1:, 1], rows[1:, 2])]
        steady, rows_shown = None, rows
    else:
        follow_rows(stack, rows[1:2, 1], rows[1:2, 2])
        runs, steady = _cycles(stack, rows[2:], scene.cycles)
        rows_shown = rows[1:]
    followed = clock.perf_counter()
    factor = 2 * friction / (np.pi * modulus)
    works = [factor * slip_work(contact, run.records) for run in runs]
    evaluated = clock.perf_counter()
    seconds = {"history": followed - started, "dissipation": evaluated - followed}
    return _solution(contact, rows_shown, runs, works, steady, seconds)


def _check_rows(rows: Array, friction: float) -> None:
    """Between admissible points a straight line is admissible: the rows are enough."""
    normal, tangential = rows[:, 1], rows[:, 2]
    slack = _ROUNDING * float(np.max(np.abs(normal)))
    bad = np.flatnonzero((normal < -slack) | (np.abs(tangential) > friction * normal + slack * max(friction, 1e-3)))
    if len(bad):
        before, after = rows[max(int(bad[0]) - 1, 0)].tolist(), rows[bad[0]].tolist()
        leg = StraightLeg(before[0], after[0], (before[1], before[2]), (after[1], after[2]))
        check([leg], friction)
        raise InadmissibleLoadError("gross sliding or separation", after[0], after[1], after[2])


def _cycles(stack: Stack, rows: Array, most: int) -> tuple[list[Followed], int | None]:
    runs: list[Followed] = []
    for number in range(most):
        before = list(stack.loads), list(stack.forces)
        runs.append(follow_rows(stack, rows[:, 1], rows[:, 2]))
        if _alike(before, (stack.loads, stack.forces), stack.friction):
            return runs, number
    return runs, None


def _alike(one: tuple[list[float], list[float]], other: tuple[list[float], list[float]], friction: float) -> bool:
    """Whether two curves agree to rounding at the knots of both."""
    top = max(one[0][-1], other[0][-1])
    knots = np.union1d(one[0], other[0])
    first, second = (np.interp(knots, *curve) for curve in (one, other))
    return bool(np.all(np.abs(first - second) <= _REPEATS * friction * top))


def slip_work(contact: Contact, records: Records) -> Array:
    """int Lam dw of each record (m,) [force^2 per thickness^2]."""
    slip = np.maximum(records.load - records.front, 0.0)
    slip_after = np.maximum(records.load_after - records.front_after, 0.0)
    # Along a record P and P_c are linear; the integrand is singular where either would be 0, beyond an end, if they went on.
    ends = ((records.load, records.load_after), (records.front, records.front_after))
    share = np.maximum(*(1 - np.minimum(a, b) / np.maximum(np.maximum(a, b), np.finfo(float).tiny) for a, b in ends))
    result = np.zeros(len(slip))
    below = -1.0
    for limit, count in (*_RULES, (np.inf, 0)):
        here = np.flatnonzero((share > below) & (share <= limit))
        below = limit
        node, weight = np.polynomial.legendre.leggauss(count) if count else (2 * ROOTS.up - 1, 2 * ROOTS.share)
        part = (1 + node) / 2
        for k in range(0, len(here), _CHUNK // len(node) + 1):
            some = here[k : k + _CHUNK // len(node) + 1]
            load = records.load[some, None] + (records.load_after - records.load)[some, None] * part
            slipped = slip[some, None] + (slip_after - slip)[some, None] * part
            area = contact.log_area(load, np.minimum(slipped, load))
            result[some] = records.rise[some] * np.sum(weight / 2 * area, axis=1)
    return result


def _solution(
    contact: Contact, rows: Array, runs: list[Followed], works: list[Array], steady: int | None, seconds: dict[str, float]
) -> SeriesSolution:
    last, work = runs[-1], works[-1]
    each = np.zeros(len(rows))
    np.add.at(each, last.records.row + 1, work)
    forward = float(np.sum(work[last.records.direction > 0]))
    front = np.concatenate([rows[:1, 1], last.front])
    half = contact.half_width(rows[:, 1])
    stick = np.where(front < rows[:, 1], contact.half_width(np.minimum(front, rows[:, 1])), half)
    counts = {
        "rows": sum(len(run.front) for run in runs),
        "slips": sum(len(run.records.row) for run in runs),
        "pieces_alive": max(run.alive for run in runs),
        "pieces_dropped": sum(run.dropped for run in runs),
    }
    return SeriesSolution(
        time=freeze(rows[:, 0]),
        normal_load=freeze(rows[:, 1]),
        tangential_load=freeze(rows[:, 2]),
        contact_half_width=freeze(half),
        stick_half_width=freeze(stick),
        direction=freeze(np.concatenate([[0], last.direction]), np.int8),
        dissipation_so_far=freeze(np.fromiter(itertools.accumulate(each.tolist()), float, len(each))),
        dissipation=float(np.sum(work)),
        forward=forward,
        reverse=float(np.sum(work)) - forward,
        cycle_dissipation=freeze(np.array([float(np.sum(part)) for part in works])),
        steady_from=steady,
        work=Work(counts, {}, seconds),
    )
