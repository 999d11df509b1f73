"""How far two cycles' pressure and shear are apart: see `metrics` for what all have in common."""

from __future__ import annotations

import numpy as np

from reports.metrics import Array, norm, over, peak_place, shares, worst_point
from reports.sampling import Cycle


def peak_pressure(reference: Cycle, result: Cycle) -> Array:
    """(max p - max p_ref)/max p_ref at each instant, (k,); NaN where neither carries pressure.

    Both maxima are over the same points, so where these lie relative to the true peak cancels: a reference at its own
    peak would make every result look too low by up to (h/a)^2/8.
    """
    expected, found = reference.pressure.max(axis=1), result.pressure.max(axis=1)
    return over(found - expected, expected)


def pressure(reference: Cycle, result: Cycle) -> Array:
    """||p - p_ref|| / ||p_ref|| at each instant, (k,) >= 0; NaN where neither carries pressure."""
    return over(norm(result.x, result.pressure - reference.pressure), norm(result.x, reference.pressure))


def shear(reference: Cycle, result: Cycle, friction: float) -> Array:
    """||q - q_ref|| / (f ||p_ref||) at each instant, (k,) >= 0; over p, since q changes sign on the way."""
    return over(norm(result.x, result.shear - reference.shear), friction * norm(result.x, reference.pressure))


def pressure_maximum(reference: Cycle, result: Cycle) -> tuple[Array, Array]:
    """(p - p_ref)/max p_ref of the worst point of each instant and its x, (k,) and (k,); NaN where neither carries pressure."""
    difference = result.pressure - reference.pressure
    return worst_point(over(difference, reference.pressure.max(axis=1, keepdims=True)), result.x)


def shear_maximum(reference: Cycle, result: Cycle, friction: float) -> tuple[Array, Array]:
    """(q - q_ref)/(f max p_ref) of the worst point of each instant and its x, (k,) and (k,)."""
    difference = result.shear - reference.shear
    return worst_point(over(difference, friction * reference.pressure.max(axis=1, keepdims=True)), result.x)


def peak_shear(reference: Cycle, result: Cycle, friction: float) -> Array:
    """(max |q| - max |q_ref|)/(f max p_ref) at each instant, (k,), both maxima over the same points."""
    difference = np.abs(result.shear).max(axis=1) - np.abs(reference.shear).max(axis=1)
    return over(difference, friction * reference.pressure.max(axis=1))


def pressure_peak_place(reference: Cycle, result: Cycle, length: float) -> Array:
    """x of the largest p less that of the largest p_ref over `length`, (k,): see `peak_place`."""
    return peak_place(reference.pressure, result.pressure, result.x) / length


def shear_peak_place(reference: Cycle, result: Cycle, length: float) -> Array:
    """x of the largest |q| less that of the largest |q_ref| over `length`, (k,): see `peak_place`."""
    return peak_place(np.abs(reference.shear), np.abs(result.shear), result.x) / length


def resultants(cycle: Cycle, weights: Array | None, normals: Array | None) -> tuple[Array, Array]:
    """P and Q that the tractions of `cycle` carry, (k,) and (k,) [force / thickness].

    Parameters
    ----------
    weights : (n,) share of the surface of each point [length]; None: the trapezoidal rule
    normals : (2, n) out of the lower body, p acting along it and q across it; None: (0, 1) everywhere
    """
    surface = shares(cycle.x) if weights is None else weights
    along, across = (np.zeros_like(cycle.x), np.ones_like(cycle.x)) if normals is None else normals
    normal = cycle.pressure @ (surface * across) + cycle.shear @ (surface * along)
    return normal, cycle.shear @ (surface * across) - cycle.pressure @ (surface * along)
