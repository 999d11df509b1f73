"""Scenes made from numbers, the brute-force oracle and the stored reference values that the tests of `semi_analytic` share."""

import json
from pathlib import Path

import numpy as np

from scenes import Elastic, EllipseLoad, FlatRounded, Friction, Hertz, Materials, PolygonLoad, Scene

UNIT = Elastic(young_modulus=2.0, poisson_ratio=0.0)  # two of these have E* = 1
_TABLE = json.loads((Path(__file__).parents[1] / "benchmarks" / "semi_analytic_reference.json").read_text(encoding="utf-8"))
REFERENCE = [row for row in _TABLE if not row.get("radians")]
EXTREMES = [row for row in _TABLE if row.get("radians")]


def make_scene(load, friction=1.0, flat=0.0, radius=1.0, modulus=1.0, cycles=6):
    """A scene with E* = `modulus` and the profile of that flat half-length (0: Hertz)."""
    material = Elastic(young_modulus=2 * modulus, poisson_ratio=0.0)
    profile = FlatRounded(radius=radius, flat_half_length=flat) if flat else Hertz(radius=radius)
    return Scene(
        name="test",
        material=Materials(upper=material, lower=material),
        profile=profile,
        friction=Friction(coefficient=friction),
        load=load,
        cycles=cycles,
    )


def ellipse(p0=3.0, p1=1.0, q0=1.1, q1=1.0, phase=90.0, initial_loading="straight"):
    return EllipseLoad(
        mean_normal_load=p0,
        normal_amplitude=p1,
        mean_tangential_load=q0,
        tangential_amplitude=q1,
        phase_degrees=phase,
        initial_loading=initial_loading,
    )


def polygon(initial_loading, cycle=()):
    return PolygonLoad(initial_loading=tuple(initial_loading), cycle=tuple(cycle))


def reference_scene(row):
    """The scene of a row of the reference table."""
    load = ellipse(row["mean"], row["amplitude"], 0.0, row["tangential"], row["phase"])
    return make_scene(load, row["friction"], row["flat"])


def brute_force_curve(points, friction, count=4001):
    """(eta, M) on a grid after a polygon through `points` from (0, 0): append and clip, word for word as in the theory."""
    top = max(p for p, _ in points)
    eta = np.linspace(0, top, count)
    held = np.zeros(count)
    p0, q0 = 0.0, 0.0
    for p, q in points:
        if p > p0:
            held = np.where(eta > p0, q0 + (q - q0) * (eta - p0) / (p - p0), held)
        low, high = q - friction * (p - eta), q + friction * (p - eta)
        held = np.where(eta <= p, np.minimum(np.maximum(held, low), high), np.nan)
        held = np.where(np.isnan(held), q, held)
        p0, q0 = p, q
    return eta[eta <= p0], held[eta <= p0]
