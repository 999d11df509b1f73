"""What the metrics share: scales, norms, places of peaks. The metrics are in `metrics_tractions`, `_zones` and `_work`.

Every metric is a pure function of two cycles on the same points and instants, dimensionless. It takes the reference first
and the result second and returns result less reference, signed wherever a sign has a meaning. A NaN in an answer means "no
such thing at this instant" only where the docstring says so; any other NaN comes from the data and goes on to the verdict,
where it fails.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes import ContactSolution, EllipseLoad, Materials

Array = NDArray[np.float64]

# Peaks of the reference within this share of its largest count as equal: a flat and rounded face has one at each edge, and it
# is the points that decide which of the two comes out higher.
EQUAL_PEAKS = 0.05


@dataclass(frozen=True)
class Scales:
    """What makes the comparison dimensionless.

    Attributes
    ----------
    normal_load : P_ref, mean load of an ellipse, else the largest load of the last cycle [force / thickness]
    half_width : a_ref = a(P_ref) of the reference [length]
    pressure : p_ref = 2 P_ref/(pi a_ref) [stress], the peak of a Hertz contact of that size
    friction : f, or 1 for a frictionless scene, so that a shear that should not be there still shows
    compliance : A = 2/E* [1/stress]
    """

    normal_load: float
    half_width: float
    pressure: float
    friction: float
    compliance: float

    @property
    def shear(self) -> float:
        """f p_ref [stress]."""
        return self.friction * self.pressure

    @property
    def shift(self) -> float:
        """A f P_ref [length]."""
        return self.compliance * self.friction * self.normal_load

    @property
    def dissipation(self) -> float:
        """A f^2 P_ref^2 [energy / thickness]."""
        return self.compliance * (self.friction * self.normal_load) ** 2


def compliance(materials: Materials) -> float:
    """A = 2/E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [1/stress].

    >>> steel = Materials.model_validate({"young_modulus": 210e3, "poisson_ratio": 0.3})
    >>> round(2 / compliance(steel), 1)
    115384.6
    """
    return 2 * sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (materials.upper, materials.lower))


def scales(reference: ContactSolution) -> Scales:
    """The scales of `reference`; a(P_ref) is read off its own half-widths, linear in P between its instants."""
    load, friction = reference.scene.load, reference.scene.friction.coefficient
    if isinstance(load, EllipseLoad):
        normal_load = load.mean_normal_load
    else:
        normal_load = float(np.max(reference.normal_load[reference.last_cycle]))
    order = np.argsort(reference.normal_load, kind="stable")
    half_width = float(np.interp(normal_load, reference.normal_load[order], reference.contact_half_width[order]))
    return Scales(
        normal_load=normal_load,
        half_width=half_width,
        pressure=2 * normal_load / (np.pi * half_width),
        friction=friction or 1.0,
        compliance=compliance(reference.scene.material),
    )


def norm(x: Array, values: Array) -> Array:
    """L2 norm over x, sqrt(int values^2 dx) by the trapezoidal rule: (..., n) -> (...)."""
    return np.sqrt(np.trapezoid(np.square(values), x, axis=-1))


def over(numerator: Array, denominator: Array) -> Array:
    """Quotient; 0/0 is NaN ("nothing to compare"), anything else over 0 is infinite."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.asarray(numerator / denominator, dtype=float)


def mean_over_time(series: Array, applies: NDArray[np.bool_], time: Array) -> float | None:
    """Mean of `series` over `time` by the trapezoidal rule on the instants that apply; None where no time passes between them."""
    t = time[applies]
    if not len(t) or t[-1] == t[0]:
        return None
    return float(np.trapezoid(series[applies], t) / (t[-1] - t[0]))


def worst_point(difference: Array, x: Array) -> tuple[Array, Array]:
    """The entry of largest size in each row of (k, n) and its place: (k,), (k,). A NaN is the worst there is.

    >>> values, places = worst_point(np.array([[1.0, -3.0]]), np.array([0.0, 0.5]))
    >>> values.tolist(), places.tolist()
    ([-3.0], [0.5])
    """
    column = np.argmax(np.where(np.isnan(difference), np.inf, np.abs(difference)), axis=1)
    return np.asarray(difference[np.arange(len(difference)), column]), np.asarray(x[column])


def peak_place(expected: Array, found: Array, x: Array) -> Array:
    """Place of the largest `found` less that of `expected` in each row of (k, n), to a point: (k,) [length].

    Where several peaks of `expected` lie within `EQUAL_PEAKS` of its largest, the nearest of them counts. NaN where a row
    holds a NaN or where nothing of `expected` is above 0.

    >>> twin = np.array([[0.0, 1.0, 0.0, 0.99, 0.0]])
    >>> peak_place(twin, np.array([[0.0, 1.0, 0.0, 0.0, 2.0]]), np.arange(5.0)).tolist()
    [1.0]
    """
    rim = np.full((len(expected), 1), -np.inf)
    rises, falls = expected >= np.hstack([rim, expected[:, :-1]]), expected >= np.hstack([expected[:, 1:], rim])
    high = (expected >= (1 - EQUAL_PEAKS) * expected.max(axis=1, keepdims=True)) & (expected > 0)
    apart = x[np.argmax(found, axis=1)][:, None] - x
    size = np.where(rises & falls & high, np.abs(apart), np.inf)
    nearest = np.argmin(size, axis=1)
    rows = np.arange(len(expected))
    known = np.isfinite(size[rows, nearest]) & ~np.isnan(found).any(axis=1) & ~np.isnan(expected).any(axis=1)
    return np.where(known, apart[rows, nearest], np.nan)


def shares(at: Array) -> Array:
    """Weights of the trapezoidal rule on the points or instants `at`: (n,) -> (n,); 1 each where all are one, as loads alike are.

    >>> shares(np.array([0.0, 1.0, 3.0])).tolist(), shares(np.array([2.0])).tolist()
    ([0.5, 1.5, 1.0], [1.0])
    """
    if at[-1] == at[0]:
        return np.ones(len(at))
    steps = np.diff(at)
    return np.asarray(np.concatenate([steps, [0.0]]) + np.concatenate([[0.0], steps])) / 2


def spacing_at(x: Array, place: float) -> float:
    """Distance of the two points around `place` (at the ends of `x`: of the last two) [length].

    >>> spacing_at(np.array([0.0, 1.0, 3.0]), 2.5)
    2.0
    """
    right = int(np.clip(np.searchsorted(x, place, side="right"), 1, len(x) - 1))
    return float(x[right] - x[right - 1])
