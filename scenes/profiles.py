"""Initial gap h(x) between the faces: symmetric, not falling for x > 0. The one verb that both engines share."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from scenes.callables import CallableProfile
from scenes.frozen import Frozen
from scenes.materials import Positive
from scenes.measured import Tabulated


class Hertz(Frozen):
    """Parabola: h = x^2 / (2 R), R being the relative radius (1/R = 1/R1 + 1/R2).

    >>> float(Hertz(radius=1000.0).height(2.0))
    0.002
    """

    kind: Literal["hertz"] = "hertz"
    radius: Positive = Field(description="relative radius of curvature R, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return ()

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.radius

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        return np.square(np.asarray(x, dtype=float)) / (2 * self.radius)


class FlatRounded(Frozen):
    """Flat face |x| < b with parabolic edges: h = (|x| - b)^2 / (2 R) beyond.

    >>> FlatRounded(radius=10.0, flat_half_length=1.0).height([0.5, 3.0]).tolist()
    [0.0, 0.2]
    """

    kind: Literal["flat_rounded"] = "flat_rounded"
    radius: Positive = Field(description="edge radius R, length units (library: mm)")
    flat_half_length: Positive = Field(description="half-length b of the flat face, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return (self.flat_half_length,)

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.radius

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        beyond = np.maximum(np.abs(np.asarray(x, dtype=float)) - self.flat_half_length, 0.0)
        return np.square(beyond) / (2 * self.radius)


class PowerLaw(Frozen):
    """Power of the distance: h = rise (|x| / length)^exponent, exponent >= 1 (1 is a sharp wedge, 2 the parabola of Hertz).

    >>> PowerLaw(exponent=3.0, length=2.0, rise=0.5).height([-1.0, 2.0]).tolist()
    [0.0625, 0.5]
    """

    kind: Literal["power_law"] = "power_law"
    exponent: float = Field(ge=1, description="exponent n >= 1, any real number")
    length: Positive = Field(description="distance at which the gap is `rise`, length units (library: mm)")
    rise: Positive = Field(description="gap at `length`, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return ()

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.length

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return f"a profile that grows like |x|^{self.exponent:.6g}, {self.rise:.6g} {length} at {self.length:.6g} {length}"

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        return self.rise * np.power(np.abs(np.asarray(x, dtype=float)) / self.length, self.exponent)


class Compound(Frozen):
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
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return (self.inner_half_length,)

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return min(self.inner_radius, self.outer_radius)

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return (
            f"a profile of relative radius {self.inner_radius:.6g} {length} up to {self.inner_half_length:.6g} {length} from "
            f"the middle and {self.outer_radius:.6g} {length} beyond"
        )

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        distance = np.abs(np.asarray(x, dtype=float))
        inside = np.minimum(distance, self.inner_half_length)
        beyond = distance - inside
        return inside * (inside / 2 + beyond) / self.inner_radius + np.square(beyond) / (2 * self.outer_radius)


class Wedge(Frozen):
    """Wedge with a rounded tip: h' = x/R up to x = b, then b/R: the angle of the faces.

    >>> Wedge(tip_radius=10.0, tip_half_length=1.0).height([1.0, 3.0]).tolist()
    [0.05, 0.25]
    """

    kind: Literal["wedge"] = "wedge"
    tip_radius: Positive = Field(description="relative radius R of the tip, length units (library: mm)")
    tip_half_length: Positive = Field(description="half-length b of the tip, length units (library: mm)")

    @property
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return (self.tip_half_length,)

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.tip_radius

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return (
            f"a wedge whose tip of half-length {self.tip_half_length:.6g} {length} has the relative radius "
            f"{self.tip_radius:.6g} {length}"
        )

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        distance = np.abs(np.asarray(x, dtype=float))
        inside = np.minimum(distance, self.tip_half_length)
        return inside * (distance - inside / 2) / self.tip_radius


def first_fall(coefficients: NDArray[np.float64]) -> float | None:
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


class EvenPolynomial(Frozen):
    """Even polynomial: h = sum over k of rises[k] (x / length)^(2 k + 2), rising for x > 0.

    >>> EvenPolynomial(length=2.0, rises=(0.5, 0.25)).height([2.0, 4.0]).tolist()
    [0.75, 6.0]
    """

    kind: Literal["polynomial"] = "polynomial"
    length: Positive = Field(description="length by which x is divided, length units (library: mm)")
    rises: tuple[float, ...] = Field(min_length=1, description="what the powers 2, 4, 6, ... add to the gap at `length`")

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
    def kinks(self) -> tuple[float, ...]:
        """Distances from the middle at which the curvature jumps [length]: pressure is steep there."""
        return ()

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.length

    def in_words(self, length: str) -> str:
        """The profile as part of a sentence; `length` is the unit."""
        return f"an even polynomial of {len(self.rises)} terms, {sum(self.rises):.6g} {length} high at {self.length:.6g} {length}"

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        square = np.square(np.asarray(x, dtype=float) / self.length)
        return np.asarray(square * polynomial.polyval(square, np.array(self.rises)))


Profile = Annotated[
    Hertz | FlatRounded | PowerLaw | Compound | Wedge | EvenPolynomial | Tabulated | CallableProfile, Field(discriminator="kind")
]
