"""Scenes made from numbers, profiles and loads at the ends of what the half-plane engine is asked,
and stored reference values.
"""

import json
import math
from pathlib import Path

import mpmath
import numpy as np

from scenes import (
    CallableProfile,
    Compound,
    Elastic,
    EllipseLoad,
    EvenPolynomial,
    FlatRounded,
    Friction,
    HarmonicLoad,
    Hertz,
    Materials,
    PolygonLoad,
    PowerLaw,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
)

UNIT = Elastic(young_modulus=2.0, poisson_ratio=0.0)  # two of these have E* = 1
_TABLE = json.loads(
    (Path(__file__).parents[1] / "benchmarks" / "semi_analytic_reference.json").read_text(
        encoding="utf-8"
    )
)
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


def mindlin(share, friction, load):
    """W of a cycle of Q between +-share f P at constant P, E* = 1, by sixty digits.

    W = (4 f^2 P^2/(pi E*)) [(1 - k) ln(1 - k) + k - k^2/2], k = Q/(f P).
    """
    with mpmath.workdps(60):
        k = mpmath.mpf(share)
        return (
            4
            * (mpmath.mpf(friction) * load) ** 2
            / mpmath.pi
            * ((1 - k) * mpmath.log(1 - k) + k - k * k / 2)
        )


def reference_scene(row):
    """The scene of a row of the reference table."""
    load = ellipse(row["mean"], row["amplitude"], 0.0, row["tangential"], row["phase"])
    return make_scene(load, row["friction"], row["flat"])


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
    return HarmonicLoad(
        mean_normal_load=1.0, normal_harmonics=[(1 - least, 0.0)], tangential_harmonics=tangential
    )


LOADS = {
    "ellipse": steep(0.1),
    "ellipse to 1e-4": steep(1e-4),
    "tilted ellipse": ellipse(1.0, 0.99, 0.0, 0.0015, 33.34),
    "polygon": polygon(CORNERS[:1], CORNERS[1:]),
    "rows": TimeSeriesLoad(
        rows=[[float(k), *corner] for k, corner in enumerate([*CORNERS, CORNERS[0]])], repeats=True
    ),
    "harmonics": waves(0.3),
    "harmonics to 1e-3": waves(1e-3),
}


def extreme(profile, load):
    """A scene with E* = 1 and f = 0.5 by its names in `PROFILES` and `LOADS`."""
    return make_scene(LOADS[load], 0.5, cycles=3).vary(profile=PROFILES[profile])


# Bulk stress and tilt: E* = 1 and E' = 2 for both bodies: eps = sigma/2 of the lower one.
PAPER = {
    "mean_normal_load": 3,
    "normal_amplitude": 1,
    "mean_tangential_load": 1.1,
    "tangential_amplitude": 1,
    "phase_degrees": 90,
}


def fretting(eps, *, q=1.8, p=3.0, loading=(), **load_keys):
    """Constant P, Q between +-q with a bulk strain of +-eps in phase, from Q = 0."""
    before = [*loading, (p, 0), (p, q)]
    columns = {"bulk_stress_lower": (*[0] * (len(before) - 1), 2 * eps, -2 * eps)}
    return make_scene(PolygonLoad(initial_loading=before, cycle=[(p, -q)], **columns | load_keys))


def leaning(kappa, tilt=0.0, mirror=1, **load_keys):
    """The ellipse of the paper with alpha = tilt + kappa P and eps = kappa Q, or its mirror image;
    the upper body is pulled.
    """
    turned = math.copysign(90, mirror)
    stress = {
        "mean": -2.2 * kappa,
        "amplitude": 2 * abs(kappa),
        "phase_degrees": -90 if kappa > 0 else 90,
        "initial_loading": [0],
    }
    turn = {
        "mean": mirror * (tilt + 3 * kappa),
        "amplitude": abs(kappa),
        "phase_degrees": 0 if kappa * mirror > 0 else 180,
    }
    loads = PAPER | {
        "phase_degrees": turned,
        "mean_tangential_load": mirror * 1.1,
        "initial_loading": [(2, 0)],
    }
    turn["initial_loading"] = [mirror * (tilt + 2 * kappa)]
    return make_scene(EllipseLoad(**loads, bulk_stress_upper=stress, tilt=turn, **load_keys))
