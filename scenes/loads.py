"""Load histories P(t), Q(t) as a sequence of load segments: the initial loading, then a cycle that repeats."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from scenes.frozen import Frozen
from scenes.materials import Positive
from scenes.segments import Loads, LoadSegment, Point, StraightSegment, ellipse_segment, parabola_segment


@dataclass(frozen=True)
class LoadPath:
    """The way in from (0, 0), then a cycle that repeats for ever (or nothing more, where `cycle` is empty)."""

    way_in: tuple[LoadSegment, ...]
    cycle: tuple[LoadSegment, ...]

    @property
    def start(self) -> float:
        """Time of the unloaded state."""
        return self.way_in[0].start

    @property
    def cycle_start(self) -> float:
        """Time at which the way in ends and the first cycle starts."""
        return self.way_in[-1].end

    @property
    def period(self) -> float | None:
        """Duration of a cycle; None for a path that is not periodic."""
        return self.cycle[-1].end - self.cycle[0].start if self.cycle else None

    def legs(self, cycles: int) -> Iterator[LoadSegment]:
        """The way in, then `cycles` revolutions."""
        yield from self.way_in
        for number in range(cycles):
            yield from self.cycle_legs(number)

    def cycle_legs(self, number: int) -> tuple[LoadSegment, ...]:
        """The legs of revolution `number`, counted from 0."""
        return tuple(leg.shifted(number * (self.period or 0.0)) for leg in self.cycle)

    def at(self, time: ArrayLike) -> Loads:
        """(P, Q) at `time`, shape of `time`; ValueError outside the path."""
        t = np.atleast_1d(np.asarray(time, dtype=float))
        inside = t
        if self.period is not None:
            late = t > self.cycle_start + self.period
            inside = np.where(late, self.cycle_start + np.mod(t - self.cycle_start, self.period), t)
        legs = (*self.way_in, *self.cycle)
        if np.any(inside < legs[0].start) or np.any(inside > legs[-1].end):
            raise ValueError(f"time outside the load path, which runs from {legs[0].start} to {legs[-1].end}")
        ends = np.array([leg.end for leg in legs])
        number = np.minimum(np.searchsorted(ends, inside, side="left"), len(legs) - 1)
        p, q = np.empty_like(inside), np.empty_like(inside)
        for k in np.unique(number):
            here = number == k
            p[here], q[here] = legs[k].loads(inside[here])
        shape = np.shape(time)
        return p.reshape(shape), q.reshape(shape)


def straight_legs(points: list[Point], start: float, duration: float) -> tuple[StraightSegment, ...]:
    """Legs through `points`, `duration` each."""
    return tuple(
        StraightSegment(start + k * duration, start + (k + 1) * duration, points[k], points[k + 1]) for k in range(len(points) - 1)
    )


WayIn = Literal["straight"] | tuple[Point, ...]


def straight_way_in(way_in: WayIn, first: LoadSegment, duration: float) -> tuple[StraightSegment, ...]:
    """From (0, 0) through the points of `way_in` to the start of the leg `first`, `duration` a line."""
    normal, tangential = first.loads(first.start)
    points = [(0.0, 0.0), *(() if way_in == "straight" else way_in), (float(normal), float(tangential))]
    return straight_legs(points, first.start - (len(points) - 1) * duration, duration)


class EllipseLoad(Frozen):
    """P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase); a revolution takes 2 pi.

    The cycle starts where |Q - Q0| is largest while P grows.

    >>> load = EllipseLoad(mean_normal_load=3, normal_amplitude=1, mean_tangential_load=1.1, tangential_amplitude=1)
    >>> p, q = load.path().at(load.path().cycle_start)  # the paper's point H
    >>> float(p), round(float(q), 12)
    (3.0, 0.1)
    """

    kind: Literal["ellipse"] = "ellipse"
    mean_normal_load: Positive = Field(description="P0, force per unit thickness (library: N/mm)")
    normal_amplitude: float = Field(0.0, ge=0, description="P1 >= 0")
    mean_tangential_load: float = Field(0.0, description="Q0")
    tangential_amplitude: float = Field(0.0, ge=0, description="Q1 >= 0")
    phase_degrees: float = Field(90.0, ge=-180, le=180, description="lag of Q behind P; positive goes round anticlockwise")
    way_in: Literal["straight", "parabola"] | tuple[Point, ...] = Field(
        "straight",
        description="from (0, 0) to the first point of the cycle: a straight line, the paper's parabola "
        "(tangent to the ellipse there), or the [P, Q] points of a polygon in between",
    )

    @property
    def phase(self) -> float:
        """Phase in radians."""
        return math.radians(self.phase_degrees)

    def path(self) -> LoadPath:
        """The legs of this history."""
        begin = self.phase + math.pi if self.phase >= 0 else self.phase + 2 * math.pi
        turn = ellipse_segment(
            begin,
            begin + 2 * math.pi,
            (self.mean_normal_load, self.mean_tangential_load),
            (self.normal_amplitude, self.tangential_amplitude),
            self.phase,
        )
        first: Point = tuple(float(load) for load in turn.loads(begin))  # type: ignore[assignment]
        if self.way_in == "parabola":
            return LoadPath((parabola_segment(begin - math.pi, begin, first, 0.0),), (turn,))
        return LoadPath(straight_way_in(self.way_in, turn, math.pi), (turn,))


class PolygonLoad(Frozen):
    """Straight lines in the P-Q plane, one unit of time each: from (0, 0) along `way_in`, then round `cycle` and back to its start.

    The cycle starts at the last point of the way in, which is not repeated in `cycle`; an empty cycle is a path that just ends.

    >>> load = PolygonLoad(way_in=[(2, 0)], cycle=[(2, 1), (2, -1)])
    >>> [float(v) for v in load.path().at(1.5)], load.path().period
    ([2.0, 0.5], 3.0)
    """

    kind: Literal["polygon"] = "polygon"
    way_in: tuple[Point, ...] = Field(min_length=1, description="[P, Q] points after (0, 0)")
    cycle: tuple[Point, ...] = Field((), description="[P, Q] points after the last one of the way in")

    @model_validator(mode="after")
    def _moves(self) -> Self:
        corners = [(0.0, 0.0), *self.way_in, *self.cycle, *(self.way_in[-1:] if self.cycle else ())]
        for first, last in itertools.pairwise(corners):
            if first == last:
                raise ValueError(f"the point {list(last)} stands twice in a row: leave one out")
        return self

    def path(self) -> LoadPath:
        """The legs of this history."""
        way_in = straight_legs([(0.0, 0.0), *self.way_in], 0.0, 1.0)
        corners = [self.way_in[-1], *self.cycle, self.way_in[-1]]
        return LoadPath(way_in, straight_legs(corners, float(len(way_in)), 1.0) if self.cycle else ())
