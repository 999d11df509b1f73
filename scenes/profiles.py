"""Initial gap h(x) between the faces: falling nowhere away from x = 0, and symmetric, but for tables with two unequal sides.

The one verb that both engines share.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import ArrayLike, NDArray
from pydantic import BeforeValidator, Field, PrivateAttr, TypeAdapter, ValidationError, ValidationInfo, model_validator

from scenes.chebyshev import NODES, Pieces, Unresolved, fit, series, tail, values_of
from scenes.errors import InputError
from scenes.frozen import Frozen, Positive, PythonFunction, refusal
from scenes.measured import Fitted, Tabulated

Array = NDArray[np.float64]


class Gap(Frozen):
    """What every profile answers."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return ()

    @property
    def symmetric(self) -> bool:
        """Whether h(-x) = h(x)."""
        return True

    @property
    @abc.abstractmethod
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: the origin of displacements."""

    @abc.abstractmethod
    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""


def two_curvatures(x: ArrayLike, inner: float, middle: float, outer: float) -> Array:
    """h with the curvature `inner` up to |x| = `middle` and `outer` beyond [1/length]."""
    distance = np.abs(np.asarray(x, dtype=float))
    inside = np.minimum(distance, middle)
    beyond = distance - inside
    return np.asarray(inside * (inside / 2 + beyond) * inner + np.square(beyond) / 2 * outer)


class MayBeFitted(Gap):
    """A profile whose numbers may be fitted to measured rows."""

    fitted: Fitted | None = Field(None, description="where fitted numbers came from; written by `fit` of a tabulated profile")

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """As for every table; other numbers are fitted to nothing."""
        data = super().merged(changes)
        if "fitted" not in changes:
            data.pop("fitted", None)
        return data


class Hertz(MayBeFitted):
    """Parabola: h = x^2 / (2 R), R being the relative radius (1/R = 1/R1 + 1/R2).

    >>> float(Hertz(radius=1000.0).height(2.0))
    0.002
    """

    kind: Literal["hertz"] = "hertz"
    radius: Positive = Field(description="relative radius of curvature R, length units (library: mm)")

    @property
    def datum_length(self) -> float:
        return self.radius

    def height(self, x: ArrayLike) -> Array:
        return np.square(np.asarray(x, dtype=float)) / (2 * self.radius)


class FlatRounded(MayBeFitted):
    """Flat face |x| < b with parabolic edges: h = (|x| - b)^2 / (2 R) beyond.

    >>> FlatRounded(radius=10.0, flat_half_length=1.0).height([0.5, 3.0]).tolist()
    [0.0, 0.2]
    """

    kind: Literal["flat_rounded"] = "flat_rounded"
    radius: Positive = Field(description="edge radius R, length units (library: mm)")
    flat_half_length: Positive = Field(description="half-length b of the flat face, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.flat_half_length,)

    @property
    def datum_length(self) -> float:
        return self.radius

    def height(self, x: ArrayLike) -> Array:
        return two_curvatures(x, 0.0, self.flat_half_length, 1 / self.radius)


class PowerLaw(Gap):
    """Power of the distance: h = rise (|x| / length)^exponent, exponent >= 1 (1 is a sharp wedge, 2 the parabola of Hertz).

    >>> PowerLaw(exponent=3.0, length=2.0, rise=0.5).height([-1.0, 2.0]).tolist()
    [0.0625, 0.5]
    """

    kind: Literal["power_law"] = "power_law"
    exponent: float = Field(ge=1, description="exponent n, any real number")
    length: Positive = Field(description="distance at which the gap is `rise`, length units (library: mm)")
    rise: Positive = Field(description="gap at `length` (library: mm)")

    @property
    def datum_length(self) -> float:
        return self.length

    def in_words(self, length: str) -> str:
        return f"a profile that grows like |x|^{self.exponent:.6g}, {self.rise:.6g} {length} at {self.length:.6g} {length}"

    def height(self, x: ArrayLike) -> Array:
        return self.rise * np.power(np.abs(np.asarray(x, dtype=float)) / self.length, self.exponent)


class Compound(Gap):
    """Compound curvature: h' = x/R1 up to x = b, then b/R1 + (x - b)/R2.

    >>> Compound(inner_radius=1.0, outer_radius=2.0, inner_half_length=1.0).height([1.0, 3.0]).tolist()
    [0.5, 3.5]
    """

    kind: Literal["compound"] = "compound"
    inner_radius: Positive = Field(description="relative radius R1 of the middle, length units (library: mm)")
    outer_radius: Positive = Field(description="relative radius R2 of the rest, length units (library: mm)")
    inner_half_length: Positive = Field(description="half-length b of the middle, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.inner_half_length,)

    @property
    def datum_length(self) -> float:
        return min(self.inner_radius, self.outer_radius)

    def in_words(self, length: str) -> str:
        return (
            f"a profile of relative radius {self.inner_radius:.6g} {length} up to {self.inner_half_length:.6g} {length} from "
            f"the middle and {self.outer_radius:.6g} {length} beyond"
        )

    def height(self, x: ArrayLike) -> Array:
        return two_curvatures(x, 1 / self.inner_radius, self.inner_half_length, 1 / self.outer_radius)


class Wedge(Gap):
    """Wedge with a rounded tip: h' = x/R up to x = b, then b/R: the angle of the faces.

    >>> Wedge(tip_radius=10.0, tip_half_length=1.0).height([1.0, 3.0]).tolist()
    [0.05, 0.25]
    """

    kind: Literal["wedge"] = "wedge"
    tip_radius: Positive = Field(description="relative radius R of the tip, length units (library: mm)")
    tip_half_length: Positive = Field(description="half-length b of the tip, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.tip_half_length,)

    @property
    def datum_length(self) -> float:
        return self.tip_radius

    def in_words(self, length: str) -> str:
        return (
            f"a wedge whose tip of half-length {self.tip_half_length:.6g} {length} has the relative radius "
            f"{self.tip_radius:.6g} {length}"
        )

    def height(self, x: ArrayLike) -> Array:
        return two_curvatures(x, 1 / self.tip_radius, self.tip_half_length, 0.0)


def first_fall(coefficients: Array) -> float | None:
    """A place s > 0 in the first stretch where sum c_k s^k is negative, not all c_k (n,) being 0; None where it never is.

    >>> first_fall(np.array([2.0, -3.0, 1.0])), first_fall(np.array([1.0, 0.0]))  # (1 - s)(2 - s)
    (1.5, None)
    """
    roots = polynomial.polyroots(np.trim_zeros(coefficients, "b"))
    # Double roots come as pairs a root of a rounding apart.
    ends = np.sort(roots.real[(np.abs(roots.imag) <= 1e-7 * np.abs(roots)) & (roots.real > 0)])
    marks = np.concatenate([[0.0], ends, [2 * ends[-1] if len(ends) else 1.0]])
    between = (marks[:-1] + marks[1:]) / 2
    falls = between[polynomial.polyval(between, coefficients) < -1e-12 * polynomial.polyval(between, np.abs(coefficients))]
    return float(falls[0]) if len(falls) else None


class EvenPolynomial(MayBeFitted):
    """Even polynomial: h = sum over k of rises[k] (x / length)^(2 k + 2), rising for x > 0.

    >>> EvenPolynomial(length=2.0, rises=(0.5, 0.25)).height([2.0, 4.0]).tolist()
    [0.75, 6.0]
    """

    kind: Literal["polynomial"] = "polynomial"
    length: Positive = Field(description="length by which x is divided, length units (library: mm)")
    rises: tuple[float, ...] = Field(
        min_length=1, description="contributions of the powers 2, 4, 6, ... to the gap at `length` (library: mm)"
    )

    @model_validator(mode="after")
    def _rises(self) -> Self:
        # h' / (2 x) as a polynomial in (x/length)^2.
        slope = np.array(self.rises) * np.arange(1.0, len(self.rises) + 1)
        if not np.any(slope):
            raise ValueError("all powers are 0: a flat profile has no edge; one of them must be positive")
        square = first_fall(slope)
        if square is not None:
            raise ValueError(f"the profile falls at x = {self.length * np.sqrt(square):.6g}: it must rise for all x > 0")
        return self

    @property
    def datum_length(self) -> float:
        return self.length

    def in_words(self, length: str) -> str:
        return f"an even polynomial of {len(self.rises)} terms, {sum(self.rises):.6g} {length} high at {self.length:.6g} {length}"

    def height(self, x: ArrayLike) -> Array:
        square = np.square(np.asarray(x, dtype=float) / self.length)
        return np.asarray(square * polynomial.polyval(square, np.array(self.rises)))


# Octaves of x below the extent that a slope is taken over from; of those, the ones in which a series in x^2 may end.
_OCTAVES, _CORE = 53, 13


class CallableProfile(Gap):
    """Gap given by a Python function of x: the height h, or its slope h' (odd), on |x| <= extent; beyond, it goes on straight.

    The slope is taken over as piecewise Chebyshev series, resolved to rounding down to extent/10^16; where h is given and is a
    smooth function of x^2 near 0, as a series in x^2 there, since h has few digits left. A corner of the slope is found, a jump
    refused.

    >>> profile = CallableProfile(slope_function=lambda x: x**3, extent=2.0)
    >>> round(float(profile.height(1.0)), 14), round(float(profile.slope(0.5)), 14)
    (0.25, 0.125)
    """

    kind: Literal["callable"] = "callable"
    height_function: PythonFunction | None = Field(None, description="gap h of x, both length units (library: mm)")
    slope_function: PythonFunction | None = Field(None, description="slope h' of x")
    extent: Positive = Field(description="largest |x| at which the function is evaluated, length units (library: mm)")
    breaks: tuple[Positive, ...] = Field((), description="places x at which the slope has a corner, if known (library: mm)")

    _slope: Pieces = PrivateAttr()
    _core: chebyshev.Chebyshev | None = PrivateAttr(None)  # h'(x)/x as a series of x^2, up to the first edge of `_slope`
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
                core, end = _even_core(over, edges[edges >= self.extent * 0.5**_CORE])
                if core is not None and end == edges[-1]:
                    self._slope = fit(lambda x: x * core(x**2), edges[-2:])
                else:
                    self._slope = fit(over, edges[edges >= end]).derivative()
                self._core = core
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
        ends = np.array([chebyshev.chebval(side, self._slope.coefficients) for side in (-1.0, 1.0)])  # of each piece
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
        return tuple(self.breaks)

    @property
    def datum_length(self) -> float:
        return self.extent

    def in_words(self, length: str) -> str:
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
        below = inner * self._core(inner**2) if self._core is not None else above * (inner / first) ** self.exponent
        return np.asarray(np.where(at < first, below, above))

    def bend(self, x: ArrayLike) -> Array:
        """x h''(x) for x >= 0, any shape; 0 beyond the extent."""
        at, first = np.asarray(x, dtype=float), float(self._slope.edges[0])
        above = self._slope.derivative()(np.clip(at, first, self.extent)) * at
        inner = np.minimum(at, first)
        if self._core is not None:
            below = inner * (self._core(inner**2) + 2 * inner**2 * self._core.deriv()(inner**2))
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


def _even_core(over: Callable[[Array], Array], edges: Array) -> tuple[chebyshev.Chebyshev | None, float]:
    """The slope over x near 0 of a height that is smooth in x^2, as a series of x^2, and its end; None and 0 if there is none."""
    offset = float(over(np.zeros(1)).item())
    noise = 2e-16 * abs(float(over(edges[-1:]).item()) - offset)
    for end in edges[::-1].tolist():
        # T_2k(x/c) = T_k(2 (x/c)^2 - 1): an even series in x is a series in x^2.
        values = over(end * np.sqrt((1 + NODES) / 2)) - offset
        coefficients = series(values)
        if np.all(np.isfinite(values)) and float(tail(coefficients)) <= noise + 1e-15 * float(np.max(np.abs(values))):
            return chebyshev.Chebyshev(chebyshev.chebder(coefficients) * 4 / end**2, domain=[0.0, end**2]), end
    return None, 0.0


def _integral(pieces: Pieces) -> Pieces:
    """Integral from the first edge on; the term of highest degree, which is rounding, is dropped."""
    half = np.diff(pieces.edges) / 2
    primitive = chebyshev.chebint(pieces.coefficients, lbnd=-1)[:-1] * half
    rises = chebyshev.chebval(1.0, primitive)
    primitive[0] += np.concatenate([[0.0], np.cumsum(rises)[:-1]])
    return Pieces(pieces.edges, primitive)


def _curve_of_rows(data: Any, info: ValidationInfo) -> Any:
    """The keys of the curve through rows that come with the key `fit`; anything else as it is.

    What has passed a function in Python is checked as Python's, where a list is no tuple, wherever it came from.
    """
    if isinstance(data, Mapping):
        data = {
            key: tuple(value) if key in ("rises", "breaks") and isinstance(value, list) else value for key, value in data.items()
        }
    wanted = isinstance(data, Mapping) and data.get("kind") == "tabulated" and data.get("fit") is not None
    if not wanted and not (isinstance(data, Tabulated) and data.fit is not None):
        return data
    try:
        return Tabulated.model_validate(data, context=info.context).curve()
    except ValidationError:
        return data  # refused in what follows, by key and row


Profile = Annotated[
    Annotated[
        Hertz | FlatRounded | PowerLaw | Compound | Wedge | EvenPolynomial | Tabulated | CallableProfile,
        Field(discriminator="kind"),
    ],
    BeforeValidator(_curve_of_rows),
]
_ANY: TypeAdapter[Profile] = TypeAdapter(Profile)


def fit_profile(
    points: ArrayLike, kind: str, *, noise: float | None = None, centre: float | None = None, extent: float | None = None
) -> Hertz | FlatRounded | EvenPolynomial | Tabulated:
    """The profile fitted to measured rows (n, 2) of x and h: convex, symmetric about a middle that need not be at x = 0.

    Parameters
    ----------
    kind, noise, centre, extent : keys of `fit` of a tabulated profile

    Returns
    -------
    The profile, with `fitted` saying what it was fitted to. A `smoothing_spline` is a `Tabulated` of the curve's own rows.

    Raises
    ------
    InputError
        One sentence with the row: too few rows, x that does not ascend, rows that do not bend up.

    >>> x = np.linspace(-1.4, 1.6, 31)
    >>> profile = fit_profile(np.stack([x, (x - 0.1) ** 2 / 2000], axis=1), "hertz", noise=1e-9)
    >>> round(profile.radius, 6), round(profile.fitted.centre, 9)
    (1000.0, 0.1)
    """
    fit = {"kind": kind, "noise": noise, "centre": centre, "extent": extent}
    data = {"kind": "tabulated", "points": points, "fit": fit}
    try:
        return _ANY.validate_python(data)  # type: ignore[return-value]
    except ValidationError as faults:
        raise InputError(f"fit_profile: {refusal(faults, data, Tabulated)}") from faults
