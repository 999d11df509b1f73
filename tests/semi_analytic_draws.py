"""Profiles and loads at the ends of what the half-plane engine is asked, for the tests by brute force."""

import math

import numpy as np

from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    HarmonicLoad,
    Hertz,
    PowerLaw,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
)
from semi_analytic_cases import ellipse, make_scene, polygon

TURN = 2 * math.pi
ROWS = np.linspace(0.0, 9.0, 7)
CORNERS = [(1.9, 0.2), (1.0, 0.45), (0.05, -0.02), (1.3, -0.6), (1.7, 0.1)]
PROFILES = {
    "hertz": Hertz(radius=0.5),
    "long flat": FlatRounded(radius=1.0, flat_half_length=30.0),
    "short flat": FlatRounded(radius=1.0, flat_half_length=1e-3),
    "|x|^1.01": PowerLaw(exponent=1.01, length=1.0, rise=0.3),
    "|x|^3.5": PowerLaw(exponent=3.5, length=1.0, rise=0.6),
    "|x|^20": PowerLaw(exponent=20.0, length=1.0, rise=2.0),
    "compound": Compound(inner_radius=1.1, outer_radius=80.0, inner_half_length=0.0153),
    "wedge": Wedge(tip_radius=1.0, tip_half_length=0.46),
    "polynomial": EvenPolynomial(length=1.0, rises=(0.0, 0.0, 0.0, 1.0)),
    "hardly growing": EvenPolynomial(length=1.0, rises=(1.0, -0.9, 0.5)),
    "table": Tabulated(points=np.column_stack([ROWS, np.cosh(ROWS / 3) - 1])),
    "function": CallableProfile(slope_function=np.sinh, extent=12.0),
}


def steep(least):
    """An ellipse that unloads to `least` P0, to 0.9 of gross sliding."""
    swing = 1 - least
    return ellipse(1.0, swing, 0.0, 0.45 * math.sqrt(1 - swing**2), 90.0)


def waves(least):
    """Two harmonics of Q over one of P, to 0.9 of gross sliding."""
    t = np.linspace(0, TURN, 2001)
    wave = 0.7 * np.cos(t + math.pi / 4) + 0.3 * np.cos(2 * t - 1)
    force = 0.45 * float(np.min((1 + (1 - least) * np.cos(t)) / np.maximum(np.abs(wave), 1e-9)))
    tangential = [(0.7 * force, -45.0), (0.3 * force, math.degrees(1.0))]
    return HarmonicLoad(mean_normal_load=1.0, normal_harmonics=[(1 - least, 0.0)], tangential_harmonics=tangential)


LOADS = {
    "ellipse": steep(0.1),
    "ellipse to 1e-4": steep(1e-4),
    "tilted ellipse": ellipse(1.0, 0.99, 0.0, 0.0015, 33.34),
    "polygon": polygon(CORNERS[:1], CORNERS[1:]),
    "rows": TimeSeriesLoad(rows=[[float(k), *corner] for k, corner in enumerate([*CORNERS, CORNERS[0]])], repeats=True),
    "harmonics": waves(0.3),
    "harmonics to 1e-3": waves(1e-3),
}


def extreme(profile, load):
    """A scene with E* = 1 and f = 0.5 by its names in `PROFILES` and `LOADS`."""
    return make_scene(LOADS[load], 0.5, cycles=3).vary(profile=PROFILES[profile])
