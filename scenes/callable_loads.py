"""Loads given as Python functions of time, taken over as Chebyshev series so that their turning points are found to rounding."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from scenes.callables import PythonFunction, values_of
from scenes.chebyshev import NODES, Unresolved, fit, series
from scenes.frozen import Frozen
from scenes.loads import LoadPath, WayIn, straight_way_in
from scenes.materials import Positive
from scenes.segments import Array, ChebyshevSegment

_ROUNDING = 1e-12


class CallableLoad(Frozen):
    """P and Q given by Python functions of time on 0 <= time <= duration; corners are found, jumps refused.

    >>> import math
    >>> load = CallableLoad(normal_load=lambda t: 2 + math.cos(t), tangential_load=math.sin, duration=2 * math.pi, repeats=True)
    >>> [round(float(v), 12) for v in load.path().at(math.pi / 2)]
    [2.0, 1.0]
    """

    kind: Literal["callable"] = "callable"
    normal_load: PythonFunction = Field(description="P(time), force per unit thickness")
    tangential_load: PythonFunction = Field(description="Q(time)")
    duration: Positive = Field(description="time that the functions cover: of one cycle if it repeats")
    repeats: bool = Field(False, description="whether the functions are one cycle that repeats for ever")
    way_in: WayIn = Field("straight", description="from (0, 0) to the loads at time 0: straight, or by the [P, Q] points")

    @model_validator(mode="after")
    def _check(self) -> Self:
        legs = self._legs()
        for before, after in pairwise(legs):
            self._meet(before, after, before.end)
        if self.repeats:
            self._meet(legs[-1], legs[0].shifted(self.duration), self.duration)
        return self

    def _meet(self, before: ChebyshevSegment, after: ChebyshevSegment, time: float) -> None:
        left, right = before.loads(before.end), after.loads(after.start)
        for name, one, two in zip(("normal_load", "tangential_load"), left, right, strict=True):
            if abs(float(one - two)) > 1e3 * _ROUNDING * max(abs(float(left[0])), abs(float(right[0]))):
                raise ValueError(f"{name} jumps from {float(one):.6g} to {float(two):.6g} at time {time:.6g}")

    def _legs(self) -> tuple[ChebyshevSegment, ...]:
        functions = [values_of(function) for function in (self.normal_load, self.tangential_load)]
        # Not in halves: a function of few turns is met between its corners, not on them.
        edges = self.duration * np.array([0.0, 0.23, 0.47, 0.74, 1.0])
        times = np.linspace(0, self.duration, 65)
        for name, function in zip(("normal_load", "tangential_load"), functions, strict=True):
            bad = ~np.isfinite(function(times))
            if np.any(bad):
                raise ValueError(f"{name} is not finite at time {times[bad][0]:.6g}")
        scale = float(np.max(np.abs(functions[0](times))))
        for _ in range(2):
            for name, function in zip(("normal_load", "tangential_load"), functions, strict=True):
                edges = _edges(name, function, edges, scale)
        found = []
        for low, high in pairwise(edges.tolist()):
            at = low + (high - low) * (1 + NODES) / 2
            normal, tangential = (_trimmed(series(function(at)), scale) for function in functions)
            found.append(ChebyshevSegment(low, high, normal, tangential))
        return tuple(found)

    def path(self) -> LoadPath:
        """The legs of this history."""
        legs = self._legs()
        first, last = (np.abs(leg.loads(time)) for leg, time in ((legs[0], 0.0), (legs[-1], self.duration)))
        unloaded = np.max(first) <= _ROUNDING * np.max(last) and self.way_in == "straight"
        if unloaded and not self.repeats:
            return LoadPath(legs, ())
        way_in = straight_way_in(self.way_in, legs[0], self.duration / 2)
        return LoadPath(way_in, legs) if self.repeats else LoadPath((*way_in, *legs), ())

    def in_words(self, unit: str) -> str:
        """The loads as the end of a sentence."""
        return f"the loads (in {unit}) are Python functions of time over {self.duration:.6g}{', repeated' if self.repeats else ''}"


def _edges(name: str, function: Callable[[Array], Any], edges: Array, scale: float) -> Array:
    try:
        return fit(function, edges, scale).edges
    except Unresolved as fault:
        raise ValueError(
            f"{name} is too rough between time {fault.low:.6g} and {fault.high:.6g}: not finite, or it jumps or swings too fast"
        ) from fault


def _trimmed(coefficients: Array, scale: float) -> tuple[float, ...]:
    """The series without what is rounding at its end."""
    kept = np.flatnonzero(np.abs(coefficients) > 1e-16 * scale)
    return tuple(coefficients[: kept[-1] + 1 if len(kept) else 1].tolist())
