"""The answer to a scene whose load is a long time series: rows through the stack, fields at chosen instants alone.

# notation: A = 2/E*; P_c load at the front of slip, c = a(P_c)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes import InputError, Scene, TimeSeriesLoad
from semi_analytic.contact import Contact
from semi_analytic.rounding import repeats_within
from semi_analytic.route import Cycles
from semi_analytic.rows import Instants, Pass, Wanted, check_rows, run
from semi_analytic.snapshot import Snapshot
from semi_analytic.stack import Stack, follow_rows

Array = NDArray[np.float64]

LONG = 1000
"""Rows from which on a series is followed through the stack: below, leg by leg."""

_SLACK = 1e-9
_NEAR = 1e-12
_INSTANTS = 400


@dataclass(frozen=True, eq=False)
class Calendar:
    """The rows in the order in which they are followed.

    Attributes
    ----------
    tables : (m, 3) rows of the way in and of each solved cycle, or all rows as one table where they do not repeat
    covered : for each whole cycle that the answer covers, the table that it is or is a copy of
    period : duration of a cycle, None where the rows do not repeat
    steady_from : index of the first cycle that ends as it began
    """

    tables: tuple[Array, ...]
    covered: tuple[int, ...]
    period: float | None
    steady_from: int | None

    @property
    def rows(self) -> Array:
        """All of them, (m, 3)."""
        return np.concatenate(self.tables)

    @property
    def starts(self) -> NDArray[np.int64]:
        """Number of the first row of each table, and of rows in all."""
        return np.concatenate([[0], np.cumsum([len(table) for table in self.tables])])


@dataclass(frozen=True, eq=False)
class Series:
    """A series that has been followed.

    Attributes
    ----------
    calendar : its rows
    passes : what the stack left of each table
    snapshot : memory curves at the instants; without their pieces where no field needs them
    held : (n,) M(P_c) at the instants
    increments : (n,) friction work over f A/pi since the instant before; empty where instants lie between rows
    """

    calendar: Calendar
    passes: tuple[Pass, ...]
    snapshot: Snapshot
    held: Array
    increments: Array


def is_long(scene: Scene) -> bool:
    """Whether a scene is followed row by row."""
    return isinstance(scene.load, TimeSeriesLoad) and len(scene.load.rows) > LONG


def calendar_of(scene: Scene, time: Array | None, cycles: Cycles) -> Calendar:
    """The rows that have to be followed for these instants; a series that repeats is followed here once, until it is steady.

    Raises
    ------
    InadmissibleLoadError
        For gross sliding or separation, with the instant and the loads.
    """
    assert isinstance(scene.load, TimeSeriesLoad)
    rows, friction = scene.load.series(), scene.friction.coefficient
    check_rows(rows, friction)
    if not scene.load.repeats:
        return Calendar((rows,), (0,), None, None)
    period, whole, most = float(rows[-1, 0] - rows[1, 0]), 0, scene.cycles
    if time is not None:
        revolutions = (float(np.max(time)) - rows[1, 0]) / period
        whole = max(math.floor(revolutions + _SLACK), 0)
        most = max(math.ceil(revolutions - _SLACK), 1 if whole else most)
    steady, solved = _steady_cycle(rows, friction, most)
    tables = (rows[:2], *(rows[2:] + np.array([k * period, 0.0, 0.0]) for k in range(solved)))
    covered = tuple(min(number, solved - 1) + 1 for number in range(whole or solved))
    if cycles == "steady" and time is None:
        covered = covered[-1:]
    return Calendar(tables, covered, period, steady)


def _steady_cycle(rows: Array, friction: float, most: int) -> tuple[int | None, int]:
    """Index of the first cycle that ends as it began, None if none of `most` does; how many were followed."""
    stack = Stack(friction)
    follow_rows(stack, rows[:2, 1], rows[:2, 2])
    for number in range(most):
        before = stack.copy()
        slips = follow_rows(stack, rows[2:, 1], rows[2:, 2]).records
        deepest = float(np.max(np.maximum(slips.load - slips.front, slips.load_after - slips.front_after), initial=0.0))
        if _alike(before, stack, repeats_within(deepest / float(np.max(rows[1:, 1])))):
            return number, number + 1
    return None, most


def _alike(one: Stack, other: Stack, tolerance: float) -> bool:
    """Whether two curves agree within `tolerance` f P at the knots of both."""
    top = max(one.loads[-1], other.loads[-1])
    knots = np.union1d(one.loads, other.loads)
    first, second = (np.interp(knots, curve.loads, curve.forces) for curve in (one, other))
    return bool(np.all(np.abs(first - second) <= tolerance * one.friction * top))


def instants_of(calendar: Calendar, cycles: Cycles, few: bool) -> Array:
    """The times of the rows, of the last table with "steady"; about 400 of them where only a `few` can be afforded."""
    times, start = calendar.rows[:, 0], 0
    if cycles == "steady" and calendar.period is not None:
        start = int(calendar.starts[-2]) - 1
    chosen = times[start :: max((len(times) - start) // _INSTANTS, 1) if few else 1]
    return chosen if chosen[-1] == times[-1] else np.append(chosen, times[-1])


def follow(calendar: Calendar, friction: float, contact: Contact, time: Array, fields: frozenset[str], x: Array) -> Series:
    """The rows followed once more, with what `fields` need at the instants `time` (n,) and at |x| = `x` (k,).

    Raises
    ------
    InputError
        For a time outside the series.
    """
    rows, starts = calendar.rows, calendar.starts
    step, share = _located(calendar, rows[:, 0], time)
    order = np.lexsort((share, step))
    step, share = step[order], share[order]
    curves = not fields.isdisjoint(("shear", "slip", "rigid_shift"))
    stack, passes = Stack(friction), []
    for number, table in enumerate(calendar.tables):
        here = slice(*np.searchsorted(step, starts[number : number + 2]).tolist())
        points = x if "dissipation_density" in fields and number == calendar.covered[-1] else x[:0]
        wanted = Wanted("dissipation" in fields, curves, points)
        passes.append(run(stack, table[:, 1:], Instants(step[here] - starts[number], share[here]), wanted, contact))
    back = np.argsort(order)
    before = np.maximum(step - 1, 0)
    load, force = ((rows[before, k] + share * (rows[step, k] - rows[before, k])) for k in (1, 2))
    load, force = (np.where(share == 1, rows[step, k], v)[back] for k, v in ((1, load), (2, force)))
    increments = np.empty(0)
    if "dissipation" in fields and np.all(share == 1):
        so_far = np.cumsum(np.concatenate([part for each in passes for part in each.each]))[step[back]]
        increments = np.diff(so_far, prepend=so_far[0])
    snapshot, held = _snapshot(passes, time, load, force, back, friction)
    return Series(calendar, tuple(passes), snapshot, held, increments)


def _located(calendar: Calendar, times: Array, asked: Array) -> tuple[NDArray[np.int64], Array]:
    """The row that ends each instant's step, and how much of the step is over: 1 at a row."""
    slack = _SLACK * (times[-1] - times[0])
    inside = asked
    if calendar.period is not None:
        inside = asked - calendar.period * np.maximum(np.ceil((asked - times[-1] - slack) / calendar.period), 0.0)
    if np.any(inside < times[0] - slack) or np.any(inside > times[-1] + slack):
        raise InputError(f"time: outside the load path, which runs from {times[0]:.6g} to {times[-1]:.6g}")
    step = np.minimum(np.searchsorted(times, inside, side="left"), len(times) - 1)
    before = np.maximum(step - 1, 0)
    # A row that somebody else found to rounding is still the row.
    near = before[inside - times[before] <= _NEAR * (times[step] - times[before])]
    step[inside - times[before] <= _NEAR * (times[step] - times[before])] = near
    before = np.maximum(step - 1, 0)
    share = (inside - times[before]) / np.where(step > 0, times[step] - times[before], 1.0)
    return step, np.where((step == 0) | (share > 1 - _NEAR), 1.0, share)


def _snapshot(
    passes: list[Pass], time: Array, load: Array, force: Array, back: NDArray[np.intp], friction: float
) -> tuple[Snapshot, Array]:
    front, held, direction = (
        np.concatenate([part for each in passes for part in getattr(each, name)])[back] for name in ("front", "held", "direction")
    )
    curves = tuple(curve for each in passes for curve in each.curves)
    load = np.maximum(load, 0.0)
    which = back if curves else np.zeros(len(time), dtype=np.intp)
    slipped = np.maximum(load - front, 0.0)
    return Snapshot(time, load, force, slipped, direction.astype(np.int64), which, curves or (None,), friction), held
