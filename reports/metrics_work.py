"""How far two cycles' rigid motion, loop and dissipation are apart: see `metrics` for what all have in common."""

from __future__ import annotations

import numpy as np

from reports.body_words import are_half_planes
from reports.metrics import Array, norm, peak_place, shares
from reports.sampling import Cycle
from scenes import ContactSolution

# Below this, in A f^2 P_ref^2, a dissipation of the reference is the rounding of a sum whose truth is 0.
NO_DISSIPATION = 1e-12


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
    over = np.max(np.abs(reference.dissipation_density)) if dissipates(reference, density_scale) else density_scale
    return (result.dissipation_density - reference.dissipation_density) / over


def tangential_displacement(reference: Cycle, result: Cycle, shift_scale: float) -> Array:
    """(U - U_ref) over the range of U_ref in the cycle, (k,); NaN where that is below 1e-12 of `shift_scale`."""
    stroke = float(np.ptp(reference.tangential_displacement))
    difference = result.tangential_displacement - reference.tangential_displacement
    return difference / stroke if stroke > 1e-12 * shift_scale else np.full_like(difference, np.nan)


def loop_work(cycle: Cycle) -> float:
    """Closed integral of Q dU by the trapezoidal rule over the instants [energy / thickness]: a second way to W."""
    return float(np.trapezoid(cycle.tangential_load, cycle.tangential_displacement))


def approach_work(solution: ContactSolution) -> float:
    """Closed integral of P dV, V the approach, over the last cycle by the trapezoidal rule [energy / thickness].

    What the normal load puts in. With Q dU it adds up to the dissipation; alone it is 0 where V hangs on P only, as between
    half-planes of like materials.
    """
    steps = solution.last_cycle
    return float(np.trapezoid(solution.normal_load[steps], solution.normal_approach[steps]))


def normal_work(solution: ContactSolution) -> float | None:
    """`approach_work` where it can be other than 0 and our own finite elements know it; else None."""
    still = np.ptp(solution.normal_load[solution.last_cycle]) == 0
    if still or are_half_planes(solution.scene) or solution.engine != "halfplane_fe" or np.isnan(solution.loop_work):
        return None
    return approach_work(solution)


def loop_distance(reference: Cycle, result: Cycle, shift_scale: float) -> Array:
    """(U - U_ref) less its mean over time, over the range of U_ref, (k,): the loops apart when laid on each other."""
    difference = tangential_displacement(reference, result, shift_scale)
    weight = shares(result.time)
    return difference - (weight @ difference) / weight.sum()


def density_norm(reference: Cycle, result: Cycle, density_scale: float, length: float) -> float:
    """||w - w_ref|| / ||w_ref|| >= 0; over `density_scale` sqrt(`length`) where w_ref is 0."""
    difference = norm(result.x, result.dissipation_density - reference.dissipation_density)
    if dissipates(reference, density_scale):
        return float(difference / norm(reference.x, reference.dissipation_density))
    return float(difference / (density_scale * np.sqrt(length)))


def density_peak(reference: Cycle, result: Cycle, density_scale: float) -> float:
    """(max w - max w_ref)/max w_ref; over `density_scale` where w_ref is 0."""
    expected, found = (float(cycle.dissipation_density.max()) for cycle in (reference, result))
    return (found - expected) / (expected if dissipates(reference, density_scale) else density_scale)


def density_peak_place(reference: Cycle, result: Cycle, length: float) -> float:
    """x of the largest w less that of the largest w_ref over `length`: see `peak_place`."""
    expected, found = (np.atleast_2d(cycle.dissipation_density) for cycle in (reference, result))
    return float(peak_place(expected, found, result.x)[0] / length)


def dissipates(cycle: Cycle, density_scale: float) -> bool:
    """Whether any point of `cycle` does friction work that is more than rounding (a NaN counts as work: it must not hide)."""
    return not bool(np.max(np.abs(cycle.dissipation_density)) <= NO_DISSIPATION * density_scale)
