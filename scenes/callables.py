"""Profiles and loads given as Python functions: only for scenes built in Python, never in a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray
from pydantic import BeforeValidator, Field, PlainSerializer, PrivateAttr, WithJsonSchema, model_validator

from scenes.chebyshev import NODES, Pieces, Unresolved, fit, series, tail
from scenes.frozen import Frozen
from scenes.materials import Positive

Array = NDArray[np.float64]

_OCTAVES = 53
_CORE = 13


def _function(value: Any) -> Any:
    if value is not None and not callable(value):
        raise ValueError("a Python function is needed: such a scene can only be built in Python, not read from a file")
    return value


def _refuse(function: Any) -> str:
    raise ValueError(
        f"the scene holds the Python function {getattr(function, '__name__', 'without a name')}, which can't be written to a file"
    )


PythonFunction = Annotated[
    Callable[[Any], Any],
    BeforeValidator(_function),
    PlainSerializer(_refuse, when_used="json-unless-none"),
    WithJsonSchema({"not": {}, "description": "a Python function: only in scenes built in Python"}),
]


def values_of(function: Callable[[Any], Any]) -> Callable[[Array], Array]:
    """The function over arrays, called point by point if it can't take them."""

    def over(x: Array) -> Array:
        try:
            values = np.asarray(function(x), dtype=float)
        except (TypeError, ValueError):
            values = np.empty(0)
        if values.shape != x.shape:
            values = np.array([float(function(float(at))) for at in x.ravel()]).reshape(x.shape)
        return values

    return over


@dataclass(frozen=True, eq=False)
class EvenCore:
    """h'(x)/x on 0 <= x <= end as a Chebyshev series in (x/end)^2."""

    end: float
    coefficients: Array

    def __call__(self, x: Array) -> Array:
        return np.asarray(chebyshev.chebval(2 * np.square(x / self.end) - 1, self.coefficients))

    def derivative(self) -> Callable[[Array], Array]:
        """Its derivative with respect to x."""
        slope = chebyshev.chebder(self.coefficients)
        return lambda x: np.asarray(4 * x / self.end**2 * chebyshev.chebval(2 * np.square(x / self.end) - 1, slope))


class CallableProfile(Frozen):
    """Gap given by a Python function of x: the height h, or its slope h' (odd), on |x| <= extent; beyond, it goes on straight.

    The slope is taken over as piecewise Chebyshev series, resolved to rounding down to extent/10^16; where h is given and is a
    smooth function of x^2 near 0, as a series in x^2 there, since h has few digits left. A corner of the slope is found, a jump
    refused.

    >>> profile = CallableProfile(slope_function=lambda x: x**3, extent=2.0)
    >>> round(float(profile.height(1.0)), 14), round(float(profile.slope(0.5)), 14)
    (0.25, 0.125)
    """

    kind: Literal["callable"] = "callable"
    height_function: PythonFunction | None = Field(None, description="h(x) [length] of x [length]")
    slope_function: PythonFunction | None = Field(None, description="h'(x) of x [length]")
    extent: Positive = Field(description="largest |x| at which the function is asked, length units")
    breaks: tuple[Positive, ...] = Field((), description="x > 0 at which the slope has a corner, where they are known")

    _slope: Pieces = PrivateAttr()
    _core: EvenCore | None = PrivateAttr(None)
    _height: Pieces | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _resolve(self) -> Self:
        if (self.height_function is None) == (self.slope_function is None):
            raise ValueError("either height_function or slope_function is needed, and not both")
        function = self.height_function or self.slope_function
        assert function is not None
        over, sign = values_of(function), -1.0 if self.height_function is None else 1.0
        edges = np.union1d(self.extent * 0.5 ** np.arange(_OCTAVES, -1.0, -1.0), [at for at in self.breaks if at < self.extent])
        self._check_symmetry(over, sign)
        try:
            if self.height_function is not None:
                core = self._core = _even_core(over, edges[edges >= self.extent * 0.5**_CORE])
                if core is not None and core.end == edges[-1]:
                    self._slope = fit(lambda x: x * core(x), edges[-2:])
                else:
                    self._slope = fit(over, edges[edges >= (core.end if core is not None else 0.0)]).derivative()
            else:
                self._slope = fit(over, edges)
                self._height = _integral(self._slope)
        except Unresolved as fault:
            raise ValueError(
                f"the function is too rough between x = {fault.low:.6g} and {fault.high:.6g}: no derivative can be had there"
            ) from fault
        self._check_slope()
        return self

    def _check_symmetry(self, over: Callable[[Array], Array], sign: float) -> None:
        x = self.extent * np.array([0.07, 0.31, 0.62, 0.97])
        try:
            right, left = over(x), over(-x)
        except (ArithmeticError, TypeError, ValueError) as reason:
            raise ValueError(f"the function can't be evaluated at x = +-{x[0]:.6g}: {reason}") from reason
        apart = np.abs(right - sign * left) > 1e-9 * np.abs(right).max()
        if np.any(apart):
            raise ValueError(f"the profile is not symmetric: its sides differ at x = {x[apart][0]:.6g}")

    def _check_slope(self) -> None:
        inside = self._slope.edges[:-1, None] + np.diff(self._slope.edges)[:, None] * np.linspace(0.02, 0.98, 25)
        slope = self._slope(inside)
        falls = slope < -1e-11 * np.max(np.abs(slope))
        if np.any(falls):
            raise ValueError(f"the profile falls at x = {inside[falls][0]:.6g}: it must rise for all x > 0")
        if not np.any(slope > 0):
            raise ValueError("the profile is flat from end to end: it must rise somewhere")
        ends = _ends(self._slope)
        jump = np.abs(ends[0, 1:] - ends[1, :-1]) > 1e-7 * (np.abs(ends[0, 1:]) + np.abs(ends[1, :-1])) + 1e-14 * np.max(slope)
        if np.any(jump):
            where = self._slope.edges[1:-1][jump][0]
            raise ValueError(f"the profile has no derivative at x = {where:.6g}: its slope jumps there")

    def __eq__(self, other: object) -> bool:
        """Whether the keys are the same: the series follow from them."""
        return isinstance(other, CallableProfile) and dict(self) == dict(other)

    def __hash__(self) -> int:
        return hash(tuple(dict(self).values()))

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: the breaks declared."""
        return tuple(self.breaks)

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.extent

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return f"a profile given by a Python function up to {self.extent:.6g} {length}"

    @property
    def corners(self) -> tuple[float, ...]:
        """x > 0 at which pieces of the slope meet: whatever corners it has are among them."""
        return tuple(self._slope.edges[1:-1].tolist())

    def slope(self, x: ArrayLike) -> Array:
        """h'(x) for x >= 0, any shape."""
        at, first = np.asarray(x, dtype=float), float(self._slope.edges[0])
        above = self._slope(np.clip(at, first, self.extent))
        inner = np.minimum(at, first)
        below = inner * self._core(inner) if self._core is not None else above * (inner / first) ** self.exponent
        return np.asarray(np.where(at < first, below, above))

    def bend(self, x: ArrayLike) -> Array:
        """x h''(x) for x >= 0, any shape; 0 beyond the extent."""
        at, first = np.asarray(x, dtype=float), float(self._slope.edges[0])
        above = self._slope.derivative()(np.clip(at, first, self.extent)) * at
        inner = np.minimum(at, first)
        if self._core is not None:
            below = inner * (self._core(inner) + inner * self._core.derivative()(inner))
        else:
            below = self.exponent * self.slope(inner)
        return np.asarray(np.where(at < first, below, np.where(at > self.extent, 0.0, above)))

    @property
    def exponent(self) -> float:
        """Power of x that the slope follows below the least x that is resolved."""
        first, second = self._slope.edges[0], self._slope.edges[0] * 2
        one, two = self._slope(np.array([first, second]))
        return float(np.log2(two / one)) if one > 0 else 1.0

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        distance = np.abs(np.asarray(x, dtype=float))
        inside = np.minimum(distance, self.extent)
        beyond = (distance - inside) * float(self.slope(self.extent))
        if self.height_function is not None:
            over = values_of(self.height_function)
            return over(inside) - over(np.zeros(1)).item() + beyond
        assert self._height is not None
        first = float(self._slope.edges[0])
        low = inside * self.slope(inside) / (self.exponent + 1)
        return np.asarray(
            np.where(inside < first, low, self._height(inside) + first * self.slope(first) / (self.exponent + 1)) + beyond
        )


def _even_core(over: Callable[[Array], Array], edges: Array) -> EvenCore | None:
    """The slope near 0 of a height that is smooth in x^2, on the largest part that one series follows; None if there is none."""
    offset = float(over(np.zeros(1)).item())
    noise = 2e-16 * abs(float(over(edges[-1:]).item()) - offset)
    for end in edges[::-1]:
        # T_2k(x/c) = T_k(2 (x/c)^2 - 1): an even series in x is a series in x^2.
        values = over(end * np.sqrt((1 + NODES) / 2)) - offset
        coefficients = series(values)
        if np.all(np.isfinite(values)) and float(tail(coefficients)) <= noise + 1e-15 * float(np.max(np.abs(values))):
            return EvenCore(float(end), chebyshev.chebder(coefficients) * 4 / end**2)
    return None


def _ends(pieces: Pieces) -> Array:
    """Values at the lower and upper end of each piece, (2, n)."""
    return np.array([chebyshev.chebval(-1.0, pieces.coefficients), chebyshev.chebval(1.0, pieces.coefficients)])


def _integral(pieces: Pieces) -> Pieces:
    """Integral from the first edge on; the term of highest degree, which is rounding, is dropped."""
    half = np.diff(pieces.edges) / 2
    primitive = chebyshev.chebint(pieces.coefficients, lbnd=-1)[:-1] * half
    rises = chebyshev.chebval(1.0, primitive)
    primitive[0] += np.concatenate([[0.0], np.cumsum(rises)[:-1]])
    return Pieces(pieces.edges, primitive)
