"""Initial gap h(x) between the faces: falling nowhere away from x = 0, and symmetric, but for
tables with two unequal sides.

The one verb that both engines share.
"""

from __future__ import annotations

import abc
from collections.abc import Callable
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Generic,
    Literal,
    NamedTuple,
    Self,
    TypeVar,
)

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import ArrayLike, NDArray
from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    TypeAdapter,
    ValidationError,
    model_validator,
)

from scenes.array_types import Array
from scenes.chebyshev import (
    PiecewiseSeries,
    UnresolvedError,
    function_of_arrays,
    piecewise_series_of,
)
from scenes.errors import InputError, RowError
from scenes.frozen import Frozen, Positive, PositiveNumber, PythonFunction, refusal_sentence
from scenes.measured import (
    DESCRIPTION_OF_COLUMNS,
    DESCRIPTION_OF_READ_AS,
    DESCRIPTION_OF_SCALE,
    DESCRIPTION_OF_UNITS,
    DESCRIPTION_OF_ZERO,
    FromFile,
    ReadAs,
    Table,
)
from scenes.unit_words import Kind

if TYPE_CHECKING:
    from scenes.height_slopes import LoadErrors

# The slopes at both ends of an interval fit one parabola where their mean is that of the secant to
# this, over the slopes.
_ALIKE_SLOPES = 1e-12
# Largest difference of two neighbouring secants of rows on a line, over the slope. Round-off is
# less, and secants of a parabola differ by one part in as many as there are rows.
_SECANT_ROUNDOFF = 1e-9
# A knot inside an interval between two rows is at least this far from its ends, over its length. It
# changes a slope by as much; in a shorter part the curvature would have no digits left.
_SHORTEST_PART = 1e-6
# Least distance of two rows, over x: between nearer ones round-off leaves no slope.
_CLOSEST_DISTANCE = 1e-9
# Rows of one side. The normal load is a sum over all of them: 2,000 take 0.2 s, and the fields of a
# cycle some seconds.
_MOST_ROWS = 2_000
# A rise counts as a whole number of steps to this; steps are coarse where half of all rises are
# less than so many.
_ROUNDING_OF_STEPS = 1e-3
_COARSE_STEPS = 1000


class Spline(NamedTuple):
    """Quadratic spline of one side of a profile: a parabola between any two neighbouring knots.

    Attributes
    ----------
    x
        (n + 1,) distances of the knots from the middle, from 0 up [length]
    height
        (n + 1,) gap h at the knots [length]
    slope
        (n + 1,) h' at the knots
    curvature
        (n,) h'' between the knots [1/length]
    """

    x: Array
    height: Array
    slope: Array
    curvature: Array


class Gap(Frozen):
    """What every profile answers."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep
        there.
        """
        return ()

    @property
    def arc(self) -> tuple[float, float] | None:
        """Centre (x >= 0) and radius of the arc that the gap is from the centre outwards; None for
        other shapes.
        """
        return None

    @property
    def symmetric(self) -> bool:
        """Whether h(-x) = h(x)."""
        return True

    datum: ClassVar[str]
    """Which key is the `datum_length`."""

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: the origin of
        displacements.
        """
        return float(getattr(self, self.datum))

    @abc.abstractmethod
    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""


class TwoCurvatures(Gap):
    """A gap whose curvature jumps once on each side of the middle."""

    @property
    @abc.abstractmethod
    def curvatures(self) -> tuple[float, float, float]:
        """h'' up to b, b, h'' beyond [1/length, length, 1/length]."""

    @property
    def kinks(self) -> tuple[float, ...]:
        return (self.curvatures[1],)

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) [length] of the untouched faces, in the shape of x: zero with zero slope at
        x = 0, with one curvature up to a distance from there, another beyond.
        """
        # `curvatures`: h'' up to the distance b, b, and h'' beyond.
        inner_curvature, inner_half_length, outer_curvature = self.curvatures
        distance_from_middle = np.abs(np.asarray(x, dtype=float))
        inner_distance = np.minimum(distance_from_middle, inner_half_length)
        outer_distance = distance_from_middle - inner_distance
        return np.asarray(
            inner_distance * (inner_distance / 2 + outer_distance) * inner_curvature
            + np.square(outer_distance) / 2 * outer_curvature
        )


T = TypeVar("T")


class OfProfile(Frozen, Generic[T]):
    """One of each column of a profile; what is left out is not stated."""

    x: T | None = None
    h: T | None = None


FitKind = Literal["even_polynomial", "smoothing_spline", "flat_rounded", "hertz"]


class ProfileFit(Frozen):
    """How a smooth, convex and symmetric curve is laid through measured rows; the scene then holds
    that curve in their place.
    """

    kind: FitKind = Field(
        description=(
            "what is fitted: `hertz`, `flat_rounded`, `even_polynomial` (powers 2 to 8) or"
            " `smoothing_spline` (no formula)"
        )
    )
    noise: PositiveNumber | None = Field(
        None,
        description=(
            "standard deviation of h, length units (library: mm); left out, that of the residuals"
        ),
    )
    centre: float | None = Field(
        None,
        description=(
            "x of the middle of the contact, length units (library: mm); fitted if left out, but 0"
            " for rows of one side"
        ),
    )
    extent: Positive | None = Field(
        None,
        description=(
            "rows farther from the middle are left out, length units (library: mm); all count if"
            " left out"
        ),
    )
    tilt: float | None = Field(
        None,
        description=(
            "slope of the trace, taken out of the rows (library: rad); fitted if left out, but 0"
            " for rows of one side, and for a `hertz` whose middle is fitted"
        ),
    )


class Fitted(Frozen):
    """Where fitted numbers came from: written by the fit, so that a saved scene gives the same
    answer without the file.
    """

    kind: FitKind = Field(description="what was fitted")
    source: str = Field(description="file with the rows, or `points`")
    rows: Table = Field(
        description="the rows that were fitted, [x, h] each, length units (library: mm)"
    )
    noise: PositiveNumber = Field(description="standard deviation of h, length units (library: mm)")
    noise_stated: bool = Field(description="whether that was stated, or is that of the residuals")
    centre: float = Field(description="x of the middle, length units (library: mm)")
    centre_fitted: bool = Field(description="whether that was fitted")
    tilt: float = Field(0.0, description="slope of the trace, taken out (library: rad)")
    tilt_fitted: bool = Field(False, description="whether that was fitted")
    offset: float = Field(description="fitted h there, length units (library: mm)")
    residual: float = Field(
        ge=0, description="root mean square of rows minus curve, length units (library: mm)"
    )
    freedom: int = Field(gt=0, description="rows less fitted numbers")
    extent: Positive = Field(
        description=(
            "distance from the middle that the rows reach on every side that has any (library: mm)"
        )
    )
    weight: float = Field(0.0, ge=0, description="of the smoothing against the rows")
    left_out: int = Field(0, ge=0, description="rows beyond the extent")
    spikes: tuple[int, ...] = Field(
        (), description="rows that stand out and were left out, by their numbers from 1 on"
    )
    read_as: ReadAs | None = Field(None, description=DESCRIPTION_OF_READ_AS)

    def used_rows(self) -> NDArray[np.int64]:
        """Numbers (n,) of the measured rows (x, h) that were fitted, from 0 on, ascending.

        Spikes are left out: `spikes` holds their row numbers from 1 on. So are the `left_out` rows
        farthest from the middle, which lies at x = `centre`.
        """
        spikes = np.array(self.spikes, dtype=np.int64) - 1
        rows_without_spikes = np.setdiff1d(np.arange(len(self.rows)), spikes)
        distances = np.abs(self.rows.values[rows_without_spikes, 0] - self.centre)
        nearest_rows = np.argsort(distances, kind="stable")[: len(distances) - self.left_out]
        return np.sort(rows_without_spikes[nearest_rows])

    def residuals(self, height: Callable[[Array], Array]) -> Array:
        """Rows minus offset, tilt and `height` of the profile, (n_rows,) [length]."""
        x = self.rows.values[:, 0] - self.centre
        return np.asarray(self.rows.values[:, 1] - self.offset - self.tilt * x - height(x))


class MayBeFitted(Gap):
    """A profile whose numbers may be fitted to measured rows."""

    keys_of_program = ("fitted",)

    fitted: Fitted | None = Field(
        None, description="where fitted numbers came from; written by `fit` of a tabulated profile"
    )


class Hertz(MayBeFitted):
    """Parabola: h = x^2 / (2 R), R being the relative radius (1/R = 1/R1 + 1/R2).

    >>> float(Hertz(radius=1000.0).height(2.0))
    0.002
    """

    datum = "radius"
    kind: Literal["hertz"] = "hertz"
    radius: Positive = Field(
        description="relative radius of curvature R, length units (library: mm)"
    )

    @property
    def arc(self) -> tuple[float, float]:
        return 0.0, self.radius

    def height(self, x: ArrayLike) -> Array:
        return np.square(np.asarray(x, dtype=float)) / (2 * self.radius)


class FlatRounded(MayBeFitted, TwoCurvatures):
    """Flat face |x| < b with parabolic edges: h = (|x| - b)^2 / (2 R) beyond.

    >>> FlatRounded(radius=10.0, flat_half_length=1.0).height([0.5, 3.0]).tolist()
    [0.0, 0.2]
    """

    datum = "radius"
    kind: Literal["flat_rounded"] = "flat_rounded"
    radius: Positive = Field(description="edge radius R, length units (library: mm)")
    flat_half_length: Positive = Field(
        description="half-length b of the flat face, length units (library: mm)"
    )

    @property
    def arc(self) -> tuple[float, float]:
        return self.flat_half_length, self.radius

    @property
    def curvatures(self) -> tuple[float, float, float]:
        return 0.0, self.flat_half_length, 1 / self.radius


class PowerLaw(Gap):
    """Power of the distance: h = rise (|x| / length)^exponent, exponent >= 1 (1 is a sharp wedge, 2
    the parabola of Hertz).

    >>> PowerLaw(exponent=3.0, length=2.0, rise=0.5).height([-1.0, 2.0]).tolist()
    [0.0625, 0.5]
    """

    datum = "length"
    kind: Literal["power_law"] = "power_law"
    exponent: float = Field(ge=1, description="exponent n, any real number")
    length: Positive = Field(
        description="distance at which the gap is `rise`, length units (library: mm)"
    )
    rise: Positive = Field(description="gap at `length` (library: mm)")

    def in_words(self, length: str) -> str:
        return (
            f"a profile that grows like |x|^{self.exponent:.6g}, {self.rise:.6g} {length} at"
            f" {self.length:.6g} {length}"
        )

    def height(self, x: ArrayLike) -> Array:
        return self.rise * np.power(np.abs(np.asarray(x, dtype=float)) / self.length, self.exponent)


class Compound(TwoCurvatures):
    """Compound curvature: h' = x/R1 up to x = b, then b/R1 + (x - b)/R2.

    >>> Compound(inner_radius=1.0, outer_radius=2.0, inner_half_length=1.0).height(
    ...     [1.0, 3.0]
    ... ).tolist()
    [0.5, 3.5]
    """

    kind: Literal["compound"] = "compound"
    inner_radius: Positive = Field(
        description="relative radius R1 of the middle, length units (library: mm)"
    )
    outer_radius: Positive = Field(
        description="relative radius R2 of the rest, length units (library: mm)"
    )
    inner_half_length: Positive = Field(
        description="half-length b of the middle, length units (library: mm)"
    )

    @property
    def datum_length(self) -> float:
        return min(self.inner_radius, self.outer_radius)

    def in_words(self, length: str) -> str:
        return (
            f"a profile of relative radius {self.inner_radius:.6g} {length} up to"
            f" {self.inner_half_length:.6g} {length} from the middle and {self.outer_radius:.6g}"
            f" {length} beyond"
        )

    @property
    def curvatures(self) -> tuple[float, float, float]:
        return 1 / self.inner_radius, self.inner_half_length, 1 / self.outer_radius


class Wedge(TwoCurvatures):
    """Wedge with a rounded tip: h' = x/R up to x = b, then b/R: the angle of the faces.

    >>> Wedge(tip_radius=10.0, tip_half_length=1.0).height([1.0, 3.0]).tolist()
    [0.05, 0.25]
    """

    datum = "tip_radius"
    kind: Literal["wedge"] = "wedge"
    tip_radius: Positive = Field(
        description="relative radius R of the tip, length units (library: mm)"
    )
    tip_half_length: Positive = Field(
        description="half-length b of the tip, length units (library: mm)"
    )

    def in_words(self, length: str) -> str:
        return (
            f"a wedge whose tip of half-length {self.tip_half_length:.6g} {length} has the relative"
            f" radius {self.tip_radius:.6g} {length}"
        )

    @property
    def curvatures(self) -> tuple[float, float, float]:
        return 1 / self.tip_radius, self.tip_half_length, 0.0


def place_of_fall(coefficients: Array) -> float | None:
    """Place s > 0 at which a polynomial sum c_k s^k, such as a profile's slope, is negative; None
    where it never is.

    It is the middle of the first interval between roots on which the polynomial is negative.
    `coefficients` (n,) are c_k from k = 0 on, not all 0.

    In the example the first polynomial is (1 - s)(2 - s), negative between 1 and 2.

    >>> (
    ...     place_of_fall(np.array([2.0, -3.0, 1.0])),
    ...     place_of_fall(np.array([1.0, 0.0])),
    ... )
    (1.5, None)
    """
    roots = polynomial.polyroots(np.trim_zeros(coefficients, "b"))
    # Round-off splits a double root into a complex pair, apart by the square root of round-off.
    positive_roots = np.sort(
        roots.real[(np.abs(roots.imag) <= 1e-7 * np.abs(roots)) & (roots.real > 0)]
    )
    interval_ends = np.concatenate(
        [[0.0], positive_roots, [2 * positive_roots[-1] if len(positive_roots) else 1.0]]
    )
    middles = (interval_ends[:-1] + interval_ends[1:]) / 2
    # Relative to the sum of the sizes of all terms: less is round-off.
    values = polynomial.polyval(middles, coefficients)
    sizes_of_terms = polynomial.polyval(middles, np.abs(coefficients))
    negative_places = middles[values < -1e-12 * sizes_of_terms]
    return float(negative_places[0]) if len(negative_places) else None


class EvenPolynomial(MayBeFitted):
    """Even polynomial: h = sum over k of rises[k] (x / length)^(2 k + 2), rising for x > 0.

    >>> EvenPolynomial(length=2.0, rises=(0.5, 0.25)).height([2.0, 4.0]).tolist()
    [0.75, 6.0]
    """

    datum = "length"
    kind: Literal["polynomial"] = "polynomial"
    length: Positive = Field(description="length by which x is divided, length units (library: mm)")
    rises: tuple[float, ...] = Field(
        min_length=1,
        description="contributions of the powers 2, 4, 6, ... to the gap at `length` (library: mm)",
    )

    @model_validator(mode="after")
    def _require_rising_polynomial(self) -> Self:
        """Return this polynomial profile; refuse (ValueError with the place) one that is flat, or
        that falls somewhere on x > 0.
        """
        # h = sum of rises[k] s^(k + 1) with s = (x/length)^2: these are the coefficients of dh/ds,
        # which has the sign of h'.
        slope_coefficients = np.array(self.rises) * np.arange(1.0, len(self.rises) + 1)
        if not np.any(slope_coefficients):
            raise ValueError(
                "all powers are 0: a flat profile has no edge; one of them must be positive"
            )
        # Place s > 0 at which this polynomial in s is negative; None where it never is.
        s_of_fall = place_of_fall(slope_coefficients)
        if s_of_fall is not None:
            raise ValueError(
                f"the profile falls at x = {self.length * np.sqrt(s_of_fall):.6g}: it must rise for"
                " all x > 0"
            )
        return self

    def in_words(self, length: str) -> str:
        return (
            f"an even polynomial of {len(self.rises)} terms, {sum(self.rises):.6g} {length} high at"
            f" {self.length:.6g} {length}"
        )

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) [length]: the sum over k of rises[k] (x/length)^(2 k + 2), in the shape of x."""
        square = np.square(np.asarray(x, dtype=float) / self.length)
        return np.asarray(square * polynomial.polyval(square, np.array(self.rises)))


def _require_rising(slope: PiecewiseSeries) -> None:
    """Refuse a profile whose slope is negative somewhere, zero everywhere, or jumps (ValueError
    with the place).

    `slope` is h' for x > 0 as Chebyshev series on intervals: `interval_ends` (n + 1,),
    `coefficients` (k, n) hold a column for each interval.
    """
    # Slopes at 25 places of each interval.
    begins = slope.interval_ends[:-1, None]
    lengths = np.diff(slope.interval_ends)[:, None]
    places = begins + lengths * np.linspace(0.02, 0.98, 25)
    slopes = slope(places)
    is_falling = slopes < -1e-11 * np.max(np.abs(slopes))
    if np.any(is_falling):
        raise ValueError(
            f"the profile falls at x = {places[is_falling][0]:.6g}: it must rise for all x > 0"
        )
    if not np.any(slopes > 0):
        raise ValueError("the profile is flat from end to end: it must rise somewhere")

    # A jump is the difference of the slopes at the end of an interval and the begin of the next.
    slopes_at_begin = np.asarray(chebyshev.chebval(-1.0, slope.coefficients))
    slopes_at_end = np.asarray(chebyshev.chebval(1.0, slope.coefficients))
    jumps = np.abs(slopes_at_begin[1:] - slopes_at_end[:-1])
    slope_sizes = np.abs(slopes_at_begin[1:]) + np.abs(slopes_at_end[:-1])
    is_jump = jumps > 1e-7 * slope_sizes + 1e-14 * np.max(slopes)
    if np.any(is_jump):
        x_of_jump = slope.interval_ends[1:-1][is_jump][0]
        raise ValueError(
            f"the profile has no derivative at x = {x_of_jump:.6g}: its slope jumps there"
        )


def _integral_of_slope(slope: PiecewiseSeries) -> PiecewiseSeries:
    """Rise of a profile from the begin of the first interval on: the integral of its slope.

    Both are Chebyshev series of the same degree on the same intervals. The term of the next degree
    is round-off.
    """
    # rise from the begin of its own interval on, then from that of the first interval on
    rise_coefficients = (
        chebyshev.chebint(slope.coefficients, lbnd=-1)[:-1] * np.diff(slope.interval_ends) / 2
    )
    rise_over_intervals = chebyshev.chebval(1.0, rise_coefficients)
    rise_coefficients[0] += np.append(0.0, np.cumsum(rise_over_intervals)[:-1])
    return PiecewiseSeries(slope.interval_ends, rise_coefficients)


# Intervals of x are halved so often from the extent towards 0: down to extent/10^16.
_N_HALVINGS = 53


class CallableProfile(Gap):
    """Gap given by a Python function of x: the height h, or its slope h' (odd), on |x| <= extent;
    beyond, it goes on straight.

    The slope is taken over as piecewise Chebyshev series, resolved to rounding down to
    extent/10^16; where h is given, it is that of `height_slopes`. A corner of the slope is found, a
    jump refused.

    >>> profile = CallableProfile(slope_function=lambda x: x**3, extent=2.0)
    >>> round(float(profile.height(1.0)), 14), round(float(profile.slope(0.5)), 14)
    (0.25, 0.125)
    """

    datum = "extent"
    kind: Literal["callable"] = "callable"
    height_function: PythonFunction | None = Field(
        None, description="gap h of x, both length units (library: mm)"
    )
    slope_function: PythonFunction | None = Field(None, description="slope h' of x")
    extent: Positive = Field(
        description="largest |x| at which the function is evaluated, length units (library: mm)"
    )
    breaks: tuple[Positive, ...] = Field(
        (), description="places x at which the slope has a corner, if known (library: mm)"
    )

    _slope: PiecewiseSeries = PrivateAttr()
    _height: PiecewiseSeries = PrivateAttr()  # above that at the first edge
    _load_errors: LoadErrors = PrivateAttr()

    @model_validator(mode="after")
    def _resolve_slope(self) -> Self:
        """Approximate the profile's slope h' by Chebyshev series on intervals of x > 0, and
        integrate it to the height; return this profile. A Python function gives the height or the
        slope.

        The intervals end at extent, extent/2, extent/4, ... and at corners of the slope, jumps of
        h''; `breaks` are corners that the scene states.

        Raises
        ------
        ValueError
            For a function that can't be evaluated, is not symmetric, too rough for a derivative,
            falls, or has a slope that jumps.
        """
        from scenes.height_slopes import LoadErrors, slope_of_height  # no other profile needs it

        if (self.height_function is None) == (self.slope_function is None):
            raise ValueError("either height_function or slope_function is needed, and not both")
        # Height or slope as a function of arrays of places.
        values_at = function_of_arrays(self.height_function or self.slope_function)
        self._require_symmetric(values_at)
        # _N_HALVINGS: 53; intervals end at extent/2^53, ..., extent/2, extent
        interval_ends = np.union1d(
            self.extent * 0.5 ** np.arange(_N_HALVINGS, -1.0, -1.0),
            [place for place in self.breaks if place < self.extent],
        )
        try:
            slope_at: Callable[[Array], ArrayLike] = values_at
            # Relative errors of P and dP/da by round-off in heights: none where the slope is given.
            self._load_errors = LoadErrors(0.0, 0.0)
            if self.height_function is not None:
                # The derivative of the height, with ends of intervals at its corners.
                height_slope = slope_of_height(values_at, interval_ends)
                interval_ends = height_slope.interval_ends
                slope_at = height_slope.slope
                self._load_errors = height_slope.load_errors
            # Chebyshev series on intervals, halved until accurate.
            self._slope = piecewise_series_of(slope_at, interval_ends)
        except UnresolvedError as fault:
            raise ValueError(
                f"the function is too rough between x = {fault.low:.6g} and {fault.high:.6g}: no"
                " derivative can be had there"
            ) from fault
        _require_rising(self._slope)
        self._height = _integral_of_slope(self._slope)
        return self

    def _require_symmetric(self, values_at: Callable[[Array], Array]) -> None:
        """Refuse a function of x that cannot be evaluated on both sides, a height that is not even,
        or a slope that is not odd (ValueError).

        `values_at` gives its values at an array of places; four places up to the profile's largest
        x (`extent`) are tried. The function is the slope where `height_function` is None.
        """
        sign_at_mirrored_place = -1.0 if self.height_function is None else 1.0
        test_places = self.extent * np.array([0.07, 0.31, 0.62, 0.97])
        try:
            right_values = values_at(test_places)
            left_values = values_at(-test_places)
        except (ArithmeticError, TypeError, ValueError) as reason:
            raise ValueError(
                f"the function can't be evaluated at x = +-{test_places[0]:.6g}: {reason}"
            ) from reason
        is_unlike = (
            np.abs(right_values - sign_at_mirrored_place * left_values)
            > 1e-9 * np.abs(right_values).max()
        )
        if np.any(is_unlike):
            raise ValueError(
                "the profile is not symmetric: its sides differ at x ="
                f" {test_places[is_unlike][0]:.6g}"
            )

    def __eq__(self, profile: object) -> bool:
        """Whether the keys are the same: the series follow from them."""
        return isinstance(profile, CallableProfile) and dict(self) == dict(profile)

    def __hash__(self) -> int:
        return hash(tuple(dict(self).values()))

    @property
    def kinks(self) -> tuple[float, ...]:
        return tuple(self.breaks)

    def in_words(self, length: str) -> str:
        return f"a profile given by a Python function up to {self.extent:.6g} {length}"

    @property
    def corners(self) -> tuple[float, ...]:
        """x > 0 at which pieces of the slope meet: whatever corners it has are among them."""
        return tuple(self._slope.interval_ends[1:-1].tolist())

    def slope(self, x: ArrayLike) -> Array:
        """Slope h'(x) for x >= 0, in the shape of x.

        It is that of its Chebyshev series up to the extent, constant beyond. Below the x at which
        the series begin it is a power of x, of the exponent `exponent`.
        """
        distance = np.asarray(x, dtype=float)
        begin_of_series = float(self._slope.interval_ends[0])
        return (
            self._slope(np.clip(distance, begin_of_series, self.extent))
            * np.minimum(distance / begin_of_series, 1.0) ** self.exponent
        )

    def curvature_times_x(self, x: ArrayLike) -> Array:
        """x times the curvature h''(x) of the profile for x >= 0, in the shape of x; 0 beyond the
        extent.

        The slope h' is a piecewise series (`_slope`). Below the x at which it begins h' goes as
        x^`exponent`, so that x h'' is `exponent` times h' there.
        """
        distance = np.asarray(x, dtype=float)
        begin_of_series = float(self._slope.interval_ends[0])
        value_on_series = (
            self._slope.derivative(np.clip(distance, begin_of_series, self.extent)) * distance
        )
        return np.where(
            distance < begin_of_series,
            self.exponent * self.slope(distance),
            np.where(distance > self.extent, 0.0, value_on_series),
        )

    @property
    def relative_load_errors(self) -> LoadErrors:
        """Relative errors of P(a) and dP/da from round-off in a height function; 0 where the slope
        is given.
        """
        return self._load_errors

    @property
    def exponent(self) -> float:
        """Exponent of the power of x that the slope follows below the x at which its series begin.

        It follows from the slopes at that x and at twice that x; 1 where the slope is 0 there.
        """
        # `interval_ends`: of the series, ascending
        begin_of_series = self._slope.interval_ends[0]
        doubled_begin = self._slope.interval_ends[0] * 2
        slope_at_begin, slope_at_doubled_begin = self._slope(
            np.array([begin_of_series, doubled_begin])
        )
        return (
            float(np.log2(slope_at_doubled_begin / slope_at_begin)) if slope_at_begin > 0 else 1.0
        )

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) [length] of the untouched faces, in the shape of x: the integral of the slope
        h'.

        Near x = 0, up to the x at which the series of the slope begin, the slope is a power of x.
        Beyond the extent the gap goes on straight.
        """
        distance_from_middle = np.abs(np.asarray(x, dtype=float))
        inner_distance = np.minimum(distance_from_middle, self.extent)
        rise_beyond_extent = (distance_from_middle - inner_distance) * float(
            self.slope(self.extent)
        )

        # Below the begin of the series h' goes as x^exponent; `_height` is the integral beyond it.
        # `interval_ends`: of the series, ascending
        tip_distance = np.minimum(inner_distance, self._slope.interval_ends[0])
        tip_height = tip_distance * self.slope(tip_distance) / (self.exponent + 1)
        return (
            tip_height
            + np.where(inner_distance > tip_distance, self._height(inner_distance), 0.0)
            + rise_beyond_extent
        )


class Tabulated(FromFile):
    """Gap given by rows of x and h, joined by Schumaker's quadratic spline: it rises where the rows
    rise, bends up where they do.

    Rows of x >= 0 alone, or of both sides, which are then averaged. Beyond the last row the profile
    goes on straight.

    >>> rows = [[x / 4, x * x / 32] for x in range(5)]
    >>> [round(float(h), 12) for h in Tabulated(points=rows).height([0.1, 1.0])]  # x^2/2
    [0.005, 0.5]
    """

    key_of_rows = "points"
    quantities: ClassVar[dict[str, Kind]] = {"x": "length", "h": "length"}
    keys_of_program = ("fitted",)
    arc: ClassVar[None] = None
    kinks: ClassVar[tuple[float, ...]] = ()
    """Distances from the middle at which the curvature jumps [length]: none stated; it does a
    little at every row.
    """

    kind: Literal["tabulated"] = "tabulated"
    file: str | None = Field(
        None, description="text table with the columns x, h; path relative to the scene file"
    )
    points: Table = Field(
        default_factory=Table.before_reading,
        description=(
            "the rows themselves, [x, h] each, in place of a file, length units (library: mm)"
        ),
    )
    symmetric: bool = Field(
        True, description="false keeps two unequal sides as they are; each must rise from x = 0"
    )
    asymmetry: float = Field(
        1e-3, ge=0, description="admitted difference of the two sides over the largest gap"
    )
    columns: OfProfile[str | int] | None = Field(None, description=DESCRIPTION_OF_COLUMNS)
    units: OfProfile[str] | None = Field(None, description=DESCRIPTION_OF_UNITS)
    scale: OfProfile[Positive] | None = Field(None, description=DESCRIPTION_OF_SCALE)
    zero: OfProfile[float] | None = Field(None, description=DESCRIPTION_OF_ZERO)
    sign: OfProfile[Literal[1, -1]] | None = Field(
        None, description="-1 turns a column, such as a height counted the other way"
    )
    read_as: ReadAs | None = Field(None, description=DESCRIPTION_OF_READ_AS)
    fit: ProfileFit | None = Field(
        None, description="a curve through noisy rows, to be taken in their place"
    )
    fitted: Fitted | None = Field(
        None, description="where fitted numbers came from; written by `fit`"
    )

    _keys: dict[str, Any] = PrivateAttr(default_factory=dict)

    def check_rows(self) -> None:
        """Refuse rows that are no profile (RowError); with a key `fit`, fit a curve to them and
        store the keys of that curve.
        """
        if self.fit is None:
            self._rows_of_sides()
        else:
            from scenes.fitting import FitRequest, fitted_keys

            x, h = self.points.values.T
            self._keys = fitted_keys(x, h, FitRequest(**dict(self.fit)))

    def _rows_of_sides(self) -> tuple[tuple[Array, Array], ...]:
        """Measured rows of each side of the profile as arrays x (k,) and h (k,) [length] that start
        at x = 0, h = 0.

        A symmetric profile has one such pair, both sides averaged where their heights differ by no
        more than `asymmetry` over their range. An unsymmetric profile has two: the left side with x
        counted to the left, and the right side.

        Raises
        ------
        RowError
            For the first row that is no valid profile, counted in the whole table.
        """
        # `points`: the measured rows (x, h). A RowError holds in `row` the number of the row, from
        # 0, and in `rule` the sentence that says what is wrong with it.
        rows = self.points.values
        if self.symmetric:
            return (one_side_of_profile(rows, self.asymmetry),)
        # Rows (x, h) from x = 0 to the left; a table of another width is refused below.
        rows_of_left_side = (
            rows[rows[:, 0] <= 0][::-1] * [-1.0, 1.0] if rows.shape[1] == 2 else rows
        )
        try:
            left_side = one_side_of_profile(rows_of_left_side, self.asymmetry)
        except RowError as fault:
            # `fault.row` counts from the middle to the left.
            raise RowError(
                max(len(rows_of_left_side) - 1 - fault.row, 0),
                f"left side, x counted to the left: {fault.rule}",
            ) from fault
        try:
            return left_side, one_side_of_profile(rows[rows[:, 0] >= 0], self.asymmetry)
        except RowError as fault:
            raise RowError(len(rows[rows[:, 0] < 0]) + fault.row, fault.rule) from fault

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: the largest x
        of the table.
        """
        return float(np.max(self.points.values[:, 0]))

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return (
            f"a profile of {len(self.points)} tabulated rows up to {self.datum_length:.6g} {length}"
        )

    def keys_of_fitted_profile(self) -> dict[str, Any]:
        """The keys of the profile that `fit` makes of the rows: what stands in a scene in place of
        this one.
        """
        origin = {
            "source": self.file or self.key_of_rows,
            "rows": self.points,
            "read_as": self.read_as,
        }
        return self._keys | {"fitted": self._keys["fitted"] | origin}

    def spline(self) -> Spline:
        """The quadratic spline through the rows, for x >= 0; InputError where the two sides are
        unequal, and for rows that are to be fitted.
        """
        if not self.symmetric:
            raise InputError(
                "profile: its two sides are unequal, and each has a spline of its own: take `sides`"
            )
        return self.sides()[-1]

    def sides(self) -> tuple[Spline, Spline]:
        """The curve to the left of x = 0, x counted to the left, and to the right; the same one
        twice where they are averaged. InputError for rows that are to be fitted.
        """
        if self.fit is not None:
            raise InputError(
                "profile: rows with the key `fit` are to be part of a scene; without one take"
                " scenes.fit_profile"
            )
        splines = [rising_spline(*side) for side in self._rows_of_sides()]
        return splines[0], splines[-1]

    def row_before(self, distance: float) -> int:
        """Number, counted from 0, of the last row with x <= `distance` [length]; -1 before all."""
        return int(np.searchsorted(self.points.values[:, 0], distance, side="right")) - 1

    def place_in_input(self, row: int) -> str:
        """Where the user finds a row, counted from 0."""
        return (
            f"profile.file = {self.file!r}, row {row + 1}"
            if self.file
            else f"profile.points, row {row + 1}"
        )

    def step_of_heights(self) -> float | None:
        """Step in which the heights h of the rows are written, that of their last digit [length];
        None where it is too fine to matter, or not recognised.

        It is the least rise between neighbouring rows, if all rises are whole numbers of it, and
        their median is less than 1,000 of it.
        """
        _, heights = self._rows_of_sides()[-1]  # of the right side, or of both averaged
        rises = np.abs(np.diff(heights))
        least_rise = float(np.min(rises[rises > 0]))
        # _ROUNDING_OF_STEPS: 1e-3 of a step, by which a rise may miss a whole number of steps
        are_whole_steps = (
            np.max(np.abs(rises / least_rise - np.round(rises / least_rise))) < _ROUNDING_OF_STEPS
        )
        # _COARSE_STEPS: 1,000; the median rise is of fewer steps
        return (
            least_rise
            if are_whole_steps and np.median(rises) < _COARSE_STEPS * least_rise
            else None
        )

    def height(self, x: ArrayLike) -> Array:
        """Gap h(x) >= 0 [length] between the faces before they touch, at x [length] of any shape,
        by a quadratic spline on either side of x = 0.
        """
        x_array = np.asarray(x, dtype=float)

        def height_by(spline: Spline) -> Array:
            """Gap [length] on one side of the profile at the distances |x| of the places `x_array`,
            by the quadratic spline of that side; straight beyond its last knot.

            The spline holds distance, height and slope at its knots, and the curvature between
            them.
            """
            # of the last knot at or before each |x|
            knot_index = np.clip(
                np.searchsorted(spline.x, np.abs(x_array), side="right") - 1, 0, len(spline.x) - 1
            )
            distance_from_knot = np.abs(x_array) - spline.x[knot_index]
            curvature = np.append(spline.curvature, 0.0)[knot_index]
            slope = spline.slope[knot_index]
            height = spline.height[knot_index]
            return np.asarray(
                height + distance_from_knot * (slope + curvature * distance_from_knot / 2)
            )

        # Splines of the left and of the right side, the same one where both are averaged.
        left_height, right_height = map(height_by, self.sides())
        return np.where(x_array < 0, left_height, right_height)


def one_side_of_profile(points: Array, asymmetry: float) -> tuple[Array, Array]:
    """Arrays x (k,) and h (k,) [length] of one side x >= 0 of a measured symmetric profile; h is 0
    at x = 0. The rows are those of one side, or of both, which are then averaged.

    Parameters
    ----------
    points
        (n, 2) x, ascending, and h [length]
    asymmetry
        largest admitted difference of h between the two sides, over the range of h

    Raises
    ------
    RowError
        With the row: x that does not ascend, is too near to the row before, or has no partner on
        the other side; no row at x = 0, or fewer than two beyond; sides that differ too much; too
        many rows; h that falls or is flat.
    """
    if points.shape[1] != 2:
        raise RowError(0, f"two numbers (x, h) are needed, not {points.shape[1]}")
    # `RowError.refuse` raises for the first row at which a condition holds. Its last argument is
    # the number, in the whole table, of the row that the first condition is about.
    x, h = points.T
    RowError.refuse(np.diff(x) <= 0, lambda row: f"x = {x[row]:.6g} does not ascend", 1)
    # _CLOSEST_DISTANCE: 1e-9 of x
    RowError.refuse(
        np.diff(x) < _CLOSEST_DISTANCE * np.maximum(np.abs(x[1:]), np.abs(x[:-1])),
        lambda row: (
            f"x = {x[row]:.17g} is nearer to the row before than {_CLOSEST_DISTANCE:g} of itself:"
            " leave one of the two out"
        ),
        1,
    )
    if len(x[x >= 0]) < 3 or not np.any(x == 0):
        raise RowError(0, "a row with x = 0 and at least two with x > 0 are needed")

    # The right side, from x = 0 outwards.
    middle_row = int(np.flatnonzero(x == 0)[0])
    right_x = x[middle_row:]
    right_h = h[middle_row:]
    left_h = h[middle_row::-1]  # from the middle outwards, as right_h
    largest_difference = asymmetry * float(np.ptp(h))

    # Rows of both sides: the right side becomes the mean of both.
    if middle_row:
        left_x = -x[middle_row::-1]
        if len(right_x) != len(left_x) or np.any(np.abs(right_x - left_x) > 1e-9 * x[-1]):
            row = 0 if len(left_x) > len(right_x) else len(x) - 1
            raise RowError(
                row,
                f"x = {x[row]:.6g} has no partner on the other side: both sides, or x >= 0 alone",
            )
        fault_of_asymmetry = (
            f"the profile is not symmetric: the sides differ by more than {largest_difference:.3g}"
            " there"
        )
        RowError.refuse(
            np.abs(right_h - left_h) > largest_difference,
            lambda _: fault_of_asymmetry,
            middle_row,
        )
        right_h = (right_h + left_h) / 2

    # The side that remains must be short enough, and rise.
    # _MOST_ROWS: 2,000 rows of one side
    fault_of_size = (
        f"the profile has {len(right_x):,} rows of x >= 0, and at most {_MOST_ROWS:,} are taken:"
        " leave out all but every n-th"
    )
    RowError.refuse(np.arange(len(right_x)) >= _MOST_ROWS, lambda _: fault_of_size, middle_row)
    RowError.refuse(
        np.diff(right_h) < 0,
        lambda row: f"h = {h[row]:.6g} falls: the profile must rise for x > 0",
        middle_row + 1,
    )
    if right_h[-1] == right_h[0]:
        raise RowError(
            len(points) - 1, "the profile is flat from end to end: it must rise somewhere"
        )
    return right_x, right_h - right_h[0]


def _slopes_at_rows(interval_lengths: Array, secant_slopes: Array) -> Array:
    """Slopes (n,) of a rising spline at its n rows, from the lengths (n - 1,) of the intervals
    between neighbouring rows and the slopes (n - 1,) of the secants across them.

    The slope at a row is that of the parabola through the row and its two neighbours; 0 at the
    first row, x = 0; extrapolated at the last. It is at most twice that of a secant beside it, so
    that the spline rises. Where three rows lie on a line it is the slope of that line: any other
    one would bend the spline back.
    """
    left_secant_slopes = secant_slopes[:-1]
    right_secant_slopes = secant_slopes[1:]
    # An interval is on a line where its secant is that of a neighbour.
    # _SECANT_ROUNDOFF: 1e-9 of the slope
    is_row_in_line = np.concatenate(
        [
            [False],
            np.abs(np.diff(secant_slopes))
            <= _SECANT_ROUNDOFF * np.maximum(left_secant_slopes, right_secant_slopes),
            [False],
        ]
    )
    is_interval_on_line = is_row_in_line[:-1] | is_row_in_line[1:]
    slopes_of_lines = np.where(is_interval_on_line, secant_slopes, np.inf)
    line_slope_at_row = np.minimum(slopes_of_lines[:-1], slopes_of_lines[1:])
    parabola_slope_at_row = (
        left_secant_slopes * interval_lengths[1:] + right_secant_slopes * interval_lengths[:-1]
    ) / (interval_lengths[:-1] + interval_lengths[1:])
    slopes = np.zeros(len(secant_slopes) + 1)
    slopes[1:-1] = np.where(
        np.isfinite(line_slope_at_row), line_slope_at_row, parabola_slope_at_row
    )
    slopes[-1] = np.clip(2 * secant_slopes[-1] - slopes[-2], 0.0, 2 * secant_slopes[-1])
    slopes[1:-1] = np.minimum(slopes[1:-1], 2 * np.minimum(left_secant_slopes, right_secant_slopes))
    return slopes


def rising_spline(x: Array, h: Array) -> Spline:
    """Schumaker's quadratic spline through rows of one side of a profile, x (n,) from 0 up and h
    (n,) [length]. It rises wherever the rows rise, and is convex where they are.

    Between neighbouring rows it consists of one parabola, or of two with a knot between them: one
    parabola meets the slopes at both its ends only if their mean is the slope of the secant, the
    line between the two rows. The spline holds distance, height and slope at all knots, and the
    curvature between them.

    Source: Schumaker, SIAM J. Numer. Anal. 20 (1983).
    """
    interval_lengths = np.diff(x)
    secant_slopes = np.diff(h) / interval_lengths
    slopes = _slopes_at_rows(interval_lengths, secant_slopes)

    # Intervals that get a knot inside. Excess: slope at a row minus that of the secant.
    excess_at_begin = slopes[:-1] - secant_slopes
    excess_at_end = slopes[1:] - secant_slopes
    # _ALIKE_SLOPES: 1e-12 of both slopes
    split_intervals = np.flatnonzero(
        np.abs(excess_at_begin + excess_at_end) > _ALIKE_SLOPES * (slopes[:-1] + slopes[1:])
    )

    # Relative place of the knot inside, 0 at the begin of its interval, 1 at the end. Where the
    # secant's slope lies between both slopes, the place is such that both parabolas bend one way.
    # Else the spline has an inflection, and the place is the middle.
    bends_one_way = excess_at_begin * excess_at_end < 0
    difference_of_excess = np.where(bends_one_way, excess_at_end - excess_at_begin, 1.0)
    relative_knot_place = np.where(bends_one_way, excess_at_end / difference_of_excess, 0.5)[
        split_intervals
    ]
    # _SHORTEST_PART: 1e-6 of the interval
    relative_knot_place = np.clip(relative_knot_place, _SHORTEST_PART, 1 - _SHORTEST_PART)
    slope_at_knot = (
        2 * secant_slopes[split_intervals]
        - relative_knot_place * slopes[split_intervals]
        - (1 - relative_knot_place) * slopes[split_intervals + 1]
    )
    x_of_knot = x[split_intervals] + relative_knot_place * (
        x[split_intervals + 1] - x[split_intervals]
    )

    # Rows and inside knots together; heights are integrals of the piecewise linear slope.
    all_x = np.insert(x, split_intervals + 1, x_of_knot)
    # Slopes below 0 are so by round-off alone.
    all_slopes = np.maximum(np.insert(slopes, split_intervals + 1, slope_at_knot), 0.0)
    rises = np.diff(all_x) * (all_slopes[:-1] + all_slopes[1:]) / 2
    return Spline(
        x=all_x,
        height=np.concatenate([[0.0], np.cumsum(rises)]),
        slope=all_slopes,
        curvature=np.diff(all_slopes) / np.diff(all_x),
    )


Curve = Annotated[
    Hertz
    | FlatRounded
    | PowerLaw
    | Compound
    | Wedge
    | EvenPolynomial
    | Tabulated
    | CallableProfile,
    Field(discriminator="kind"),
]
# Built where it is first used: by fits.
_ANY_PROFILE: TypeAdapter[Curve] = TypeAdapter(Curve, config=ConfigDict(defer_build=True))


def _curve_of_rows(profile: Curve) -> Curve:
    """The curve through rows that come with the key `fit`; any other profile as it is."""
    return (
        _ANY_PROFILE.validate_python(profile.keys_of_fitted_profile())
        if profile.kind == "tabulated" and profile.fit is not None
        else profile
    )


Profile = Annotated[Curve, AfterValidator(_curve_of_rows)]


def fit_profile(
    points: ArrayLike,
    kind: str,
    *,
    noise: float | None = None,
    centre: float | None = None,
    extent: float | None = None,
    tilt: float | None = None,
) -> Hertz | FlatRounded | EvenPolynomial | Tabulated:
    """Smooth profile fitted to measured rows of x and h by least squares: convex, and symmetric
    about a middle that need not be at x = 0.

    Parameters
    ----------
    points
        (n, 2) x, ascending, and the gap h [length]
    kind
        of the fitted curve: "hertz" (parabola), "flat_rounded" (flat with parabolic edges),
        "even_polynomial" or "smoothing_spline"
    noise
        standard deviation of h [length]; by default that of the residuals
    centre
        x of the middle [length]; by default fitted, but 0 for rows of one side
    extent
        distance from the middle beyond which rows are left out [length]; by default none is
    tilt
        slope dh/dx by which the measured trace is turned; by default fitted, but 0 for rows of one
        side, and for a "hertz" whose middle is fitted

    Returns
    -------
    Hertz | FlatRounded | EvenPolynomial | Tabulated
        The profile, with a record of the fit in `fitted`. A `smoothing_spline` becomes a
        `Tabulated`, a table of rows on the fitted curve.

    Raises
    ------
    InputError
        One sentence with the row: too few rows, x that does not ascend, rows that do not bend up.

    Examples
    --------
    >>> x = np.linspace(-1.4, 1.6, 31)
    >>> profile = fit_profile(np.stack([x, (x - 0.1) ** 2 / 2000], axis=1), "hertz", noise=1e-9)
    >>> round(profile.radius, 6), round(profile.fitted.centre, 9)
    (1000.0, 0.1)
    """
    # As in a scene: a table of rows with the key `fit`, which validation turns into the curve.
    keys_of_fit = {"kind": kind, "noise": noise, "centre": centre, "extent": extent, "tilt": tilt}
    keys = {"kind": "tabulated", "points": points, "fit": keys_of_fit}
    try:
        # `_ANY_PROFILE` validates the keys of a profile and makes it.
        return _curve_of_rows(_ANY_PROFILE.validate_python(keys))  # type: ignore[return-value]
    except ValidationError as faults:
        raise InputError(f"fit_profile: {refusal_sentence(faults, keys, Tabulated)}") from faults
