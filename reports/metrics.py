"""How far two cycles on the same points and instants are apart: one pure function for each metric, all dimensionless.

Every function takes the reference first and the result second and returns result less reference, signed wherever a
sign has a meaning. A NaN in an answer means "no such thing at this instant" only where the docstring says so; any other
NaN comes from the data and goes on to the verdict, where it fails.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.sampling import Cycle
from scenes import ContactSolution, EllipseLoad, Materials, SurfaceState

Array = NDArray[np.float64]

# Below this, in A f^2 P_ref^2, a dissipation of the reference is the rounding of a sum whose truth is 0.
NO_DISSIPATION = 1e-12


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


def _over(numerator: Array, denominator: Array) -> Array:
    """Quotient; 0/0 is NaN ("nothing to compare"), anything else over 0 is infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(numerator / denominator, dtype=float)


def peak_pressure(reference: Cycle, result: Cycle) -> Array:
    """(max p - max p_ref)/max p_ref at each instant, (k,); NaN where neither carries pressure.

    Both maxima are over the same points, so where these lie relative to the true peak cancels: a reference at its own
    peak would make every result look too low by up to (h/a)^2/8.
    """
    expected, found = reference.pressure.max(axis=1), result.pressure.max(axis=1)
    return _over(found - expected, expected)


def pressure(reference: Cycle, result: Cycle) -> Array:
    """||p - p_ref|| / ||p_ref|| at each instant, (k,) >= 0; NaN where neither carries pressure."""
    return _over(norm(result.x, result.pressure - reference.pressure), norm(result.x, reference.pressure))


def shear(reference: Cycle, result: Cycle, friction: float) -> Array:
    """||q - q_ref|| / (f ||p_ref||) at each instant, (k,) >= 0; over p, since q changes sign on the way."""
    return _over(norm(result.x, result.shear - reference.shear), friction * norm(result.x, reference.pressure))


def edge(expected: Array, found: Array, length: float) -> Array:
    """Outward shift of the worse of two edges over `length`, (k,) from (k, 2); positive where it reaches too far.

    NaN where either lacks the edge (a stick edge in full slip).

    >>> edge(np.array([[-1.0, 1.0]]), np.array([[-1.02, 1.01]]), 1.0).round(12).tolist()
    [0.02]
    """
    outward = (found - expected) * np.array([-1.0, 1.0]) / length
    worse = np.argmax(np.abs(outward), axis=1)
    return np.asarray(outward[np.arange(len(outward)), worse])


def stick_status(cycle: Cycle, length: float) -> NDArray[np.int8]:
    """What the whole contact does at each instant, (k,): 0 full slip, 1 partial slip, 2 full stick, -1 out of contact.

    Full stick is told by stick edges that are the contact edges (to 1e-9 `length`), full slip by NaN.
    """
    apart = np.max(np.abs(cycle.stick_edges - cycle.contact_edges), axis=1)
    status = np.where(np.isnan(apart), 0, np.where(apart <= 1e-9 * length, 2, 1))
    return np.where(cycle.pressure.max(axis=1) > 0, status, -1).astype(np.int8)


def state_disagreement(reference: Cycle, result: Cycle) -> Array:
    """Share of the length in contact (of either) whose state differs, at each instant, (k,); NaN out of contact."""
    touching = (reference.state != SurfaceState.OPEN) | (result.state != SurfaceState.OPEN)
    differs = reference.state != result.state
    length = np.gradient(result.x)
    return _over((differs * length).sum(axis=1), (touching * length).sum(axis=1))


def mean_over_time(series: Array, applies: NDArray[np.bool_], time: Array) -> float | None:
    """Mean of `series` over `time` by the trapezoidal rule on the instants that apply; None if fewer than two do."""
    if applies.sum() < 2:
        return None
    t = time[applies]
    return float(np.trapezoid(series[applies], t) / (t[-1] - t[0]))


def dissipation(expected: float, found: float, scale: float) -> tuple[float, bool]:
    """(W - W_ref)/W_ref and True; where W_ref is 0 (below 1e-12 of `scale` = A f^2 P_ref^2): W/scale and False.

    >>> dissipation(2.0, 2.02, 1.0)
    (0.01, True)
    >>> dissipation(0.0, 1e-3, 2.0)
    (0.0005, False)
    """
    if abs(expected) <= NO_DISSIPATION * scale:
        return (found - expected) / scale, False
    return (found - expected) / expected, True


def dissipation_density(reference: Cycle, result: Cycle, density_scale: float) -> Array:
    """(w - w_ref)/max w_ref at each point, (n,); over `density_scale` = A f^2 P_ref^2/a_ref where w_ref is 0."""
    largest = float(np.max(np.abs(reference.dissipation_density)))
    over = largest if largest > NO_DISSIPATION * density_scale else density_scale
    return (result.dissipation_density - reference.dissipation_density) / over


def rigid_shift(reference: Cycle, result: Cycle, shift_scale: float) -> Array:
    """(U - U_ref) over the range of U_ref in the cycle, (k,); NaN where that is below 1e-12 of `shift_scale`."""
    stroke = float(np.ptp(reference.rigid_shift))
    difference = result.rigid_shift - reference.rigid_shift
    return difference / stroke if stroke > 1e-12 * shift_scale else np.full_like(difference, np.nan)


def loop_work(cycle: Cycle) -> float:
    """Closed integral of Q dU by the trapezoidal rule over the instants [energy / thickness]: a second way to W."""
    return float(np.trapezoid(cycle.tangential_load, cycle.rigid_shift))
