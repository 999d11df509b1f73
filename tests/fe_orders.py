"""Observed orders of convergence of p, q, c and W over the paper's cycle, under uniform refinement, with their class.

Refined together: every element of the surface and the growth into the depth. Where in an element an edge stands is chance,
moves an error by a factor of up to two and W from one sign to the other; each rung of the ladder is therefore the root-mean-
square over seven meshes of nearly its size (three will do for p, q, a and c) (and, for p, q, a and c, over the instants of the
last cycle). The dissipation is compared with that of the polygon of the run's own increments, so that increments do not count.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from scenes import load_scene

QUANTITIES = ("p", "q", "a", "c", "W")
# Elements of a rung's meshes over its own number.
SPREAD = (1.0, 1.06, 1.13, 1.2, 1.27, 1.34, 1.42)
# What to expect: a square root inside an element costs quadratic ones all but one order, linear ones, whose p is smoother, less;
# W gains by errors of either sign, on the finest meshes less (a/160 to a/640: 1, since a node touches as a whole).
EXPECTED = {2: {"p": 1.0, "q": 1.0, "a": 0.8, "c": 1.1, "W": 1.7}, 1: {"p": 1.4, "q": 1.0, "a": 1.2, "c": 1.1, "W": 1.4}}
ROOM = 0.5


def _rms(values: ArrayLike) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@functools.cache
def errors(elements: float, order: int) -> dict[str, float]:
    """Errors on one mesh of `elements` a half-width: relative L2 of p, q over f p, half-widths a and c over a, W."""
    scene = load_scene("hertz-paper")
    mesh = MeshSettings(
        element_size=1 / elements, edge_element_size=1 / elements, growth=min(1.0, 3.2 / elements), far_radius=6.0, order=order
    )
    answer = halfplane_fe.solve(scene, mesh, SolverSettings(steps_per_cycle=48, step_tolerance=float("inf")))
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time)
    work = semi_analytic.solve(scene, x=[0.0], fields="dissipation").dissipation  # increments follow the curve of the loads
    cycle = answer.last_cycle

    def norm(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sqrt(np.trapezoid(values[cycle] ** 2, answer.x, axis=1))

    pressure, a = norm(exact.pressure), answer.scales.half_width
    return {
        "p": _rms(norm(answer.pressure - exact.pressure) / pressure),
        "q": _rms(norm(answer.shear - exact.shear) / pressure) / scene.friction.coefficient,
        "a": _rms((answer.contact_half_width - exact.contact_half_width)[cycle]) / a,
        "c": _rms((answer.stick_half_width - exact.stick_half_width)[cycle]) / a,
        "W": answer.dissipation / work - 1,
    }


def rung(elements: int, order: int, spread: Sequence[float] = SPREAD) -> dict[str, float]:
    """Errors of meshes of about `elements` a half-width, root-mean-square."""
    found = [errors(elements * share, order) for share in spread]
    return {name: _rms([one[name] for one in found]) for name in QUANTITIES}


def convergence_class(sequence: Sequence[float]) -> Literal["monotone", "oscillating", "diverging"]:
    """Of errors, signed or not, from coarse to fine: each smaller than the one before and of its sign; smaller in the end; not so.

    >>> convergence_class([4.0, 2.0, 1.0]), convergence_class([4.0, -2.0, 1.0]), convergence_class([1.0, 0.5, 2.0])
    ('monotone', 'oscillating', 'diverging')
    """
    given = np.asarray(sequence, dtype=float)
    size = np.abs(given)
    if not size[-1] < size[0]:
        return "diverging"
    steady = np.all(np.diff(size) < 0) and np.all(np.sign(given) == np.sign(given[0]))
    return "monotone" if steady else "oscillating"


def observed_order(cuts: Sequence[float], sequence: Sequence[float]) -> float:
    """Order in the element size of errors on meshes of `cuts` elements a half-width."""
    return -float(np.polyfit(np.log(cuts), np.log(np.abs(sequence)), 1)[0])
