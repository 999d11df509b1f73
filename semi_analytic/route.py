"""The route that a history takes: the scene's own path, or the straight steps between given times; and its instants."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from scenes import EllipseLeg, InputError, Leg, LoadPath, StraightLeg
from semi_analytic.history import History, Span, Turn, check, follow

Array = NDArray[np.float64]
Cycles = Literal["all", "steady"]

# Instants of a cycle and of the way in where none are asked for.
_INSTANTS = 400
_WAY_IN_INSTANTS = 100
# Share of a cycle, or of the whole path, within which somebody else's instant is one of the path's own.
_SLACK = 1e-9


@dataclass(frozen=True, eq=False)
class Route:
    """A solved history with its calendar.

    Attributes
    ----------
    history : the spans
    start, cycle_start : times of the unloaded state and of the start of the first cycle
    period : duration of a revolution, None for a path that is not periodic
    covered : for each whole cycle that the answer covers, the index of the solved cycle that it is or is a copy of
    straight : whether it is made of straight steps between given times
    loop : the ellipse, where that is the whole cycle
    """

    history: History
    start: float
    cycle_start: float
    period: float | None
    covered: tuple[int, ...]
    straight: bool = False
    loop: EllipseLeg | None = None

    def is_loop(self, cycle: int) -> bool:
        """Whether a solved cycle is the steady state of an ellipse."""
        return self.loop is not None and self.history.steady_from is not None and cycle >= self.history.steady_from


def own_route(path: LoadPath, friction: float, cycles: int, time: Array | None) -> Route:
    """The route along the scene's own path: as many cycles as `time` needs; until it is steady where it needs none."""
    check([*path.way_in, *path.cycle], friction)
    if path.period is None:
        history = follow((), [Turn(path.way_in)], friction)
        return Route(history, path.start, path.start, None, (0,))
    turns, whole = cycles, 0
    if time is not None:
        revolutions = (float(np.max(time)) - path.cycle_start) / path.period
        whole = max(math.floor(revolutions + _SLACK), 0)
        turns = max(math.ceil(revolutions - _SLACK), 0) if whole else max(cycles, math.ceil(revolutions - _SLACK))
    history = follow(path.way_in, (Turn(path.cycle, k * path.period) for k in range(turns)), friction)
    solved = len(history.cycles)
    covered = tuple(min(number, solved - 1) for number in range(whole or solved))
    loop = path.cycle[0] if len(path.cycle) == 1 and isinstance(path.cycle[0], EllipseLeg) else None
    return Route(history, path.start, path.cycle_start, path.period, covered, loop=loop)


def straight_route(path: LoadPath, friction: float, time: Array) -> Route:
    """The route along straight lines between the path's points at `time`, ascending; from (0, 0) to the first of them too.

    A revolution that starts between two of the times starts on the straight line between them.
    """
    if np.any(np.diff(time) <= 0):
        raise InputError("straight_steps: the times must ascend, no two of them equal")
    begin = float(time[0]) > path.start
    times = np.concatenate([[path.start], time]) if begin else time
    normal, tangential = path.at(times)
    if path.period is None:
        legs = _chords(times, normal, tangential)
        check(legs, friction)
        return Route(follow((), [Turn(legs)], friction), path.start, path.start, None, (0,), straight=True)
    whole = max(math.floor((float(times[-1]) - path.cycle_start) / path.period + _SLACK), 0)
    marks = path.cycle_start + path.period * np.arange(whole + 1)
    near = np.abs(times[:, None] - marks) <= _SLACK * path.period
    extra = marks[~near.any(axis=0) & (marks < times[-1])]
    every = np.sort(np.concatenate([times, extra]))
    legs = _chords(every, np.interp(every, times, normal), np.interp(every, times, tangential))
    check(legs, friction)
    number = np.searchsorted(marks - _SLACK * path.period, every[:-1], side="right")
    groups = [tuple(leg for leg, k in zip(legs, number, strict=True) if k == turn) for turn in range(whole + 2)]
    history = follow(groups[0], [Turn(group) for group in groups[1:] if group], friction, repeat=False)
    return Route(history, path.start, path.cycle_start, path.period, tuple(range(whole)) or (0,), straight=True)


def _chords(time: Array, normal: Array, tangential: Array) -> tuple[Leg, ...]:
    points = list(zip(normal.tolist(), tangential.tolist(), strict=True))
    times = time.tolist()
    return tuple(StraightLeg(times[k], times[k + 1], points[k], points[k + 1]) for k in range(len(times) - 1))


def default_times(route: Route, cycles: Cycles) -> Array:
    """Instants evenly spread over each span, both its ends among them: about 400 a cycle."""
    groups = [*route.history.cycles]
    if cycles == "steady":
        groups = groups[-1:]
    parts = [_instants(group, _INSTANTS) for group in groups]
    if cycles == "all" and route.history.way_in:
        parts.insert(0, _instants(route.history.way_in, _WAY_IN_INSTANTS))
    return np.unique(np.concatenate(parts))


def _instants(spans: tuple[Span, ...], count: int) -> Array:
    whole = sum(span.end.time - span.begin.time for span in spans)
    parts = []
    for span in spans:
        number = max(math.ceil(count * (span.end.time - span.begin.time) / whole), 2)
        parts.append(np.linspace(span.begin.time, span.end.time, number + 1) + span.delay)
    return np.concatenate(parts)


def locate(route: Route, time: Array) -> tuple[NDArray[np.int64], Array]:
    """Span number and time of the span's leg for each instant; an instant between two spans belongs to the one that ends there.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    spans = route.history.spans
    ends = np.array([span.end.time + span.delay for span in spans])
    slack = _SLACK * (ends[-1] - route.start)
    inside = np.asarray(time, dtype=float)
    if route.period is not None:
        over = np.maximum(np.ceil((inside - ends[-1] - slack) / route.period), 0.0)
        inside = inside - over * route.period
    if np.any(inside < route.start - slack) or np.any(inside > ends[-1] + slack):
        raise InputError(f"time: outside the load path, which runs from {route.start:.6g} to {ends[-1]:.6g}")
    # Less the slack: a turning point that somebody else found to rounding still belongs to the span that it ends.
    number = np.minimum(np.searchsorted(ends, inside - slack, side="left"), len(spans) - 1)
    begin, end, delay = (np.array(values) for values in zip(*((s.begin.time, s.end.time, s.delay) for s in spans), strict=True))
    return number, np.clip(inside - delay[number], begin[number], end[number])
