"""The scenes of the contract: those of files, and drawn ones at the ends of what the half-plane
engine accepts.

A drawn scene is a plain dictionary, as a scene file holds it, so that the frozen file needs no code
to be read. Python functions cannot be frozen: the four scenes in `FUNCTIONS` are made here.
"""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np

from scene_cases import CASES
from scenes import CallableLoad, CallableProfile, Elastic, Materials, Scene, scene_names

UNIT = {"young_modulus": 2.0, "poisson_ratio": 0.0}  # two of these have E* = 1
ROWS = [[1.5 * k, math.cosh(0.5 * k) - 1] for k in range(7)]
PROFILES: dict[str, dict[str, Any]] = {
    "hertz": {"kind": "hertz", "radius": 0.5},
    "long-flat": {"kind": "flat_rounded", "radius": 1.0, "flat_half_length": 30.0},
    "short-flat": {"kind": "flat_rounded", "radius": 1.0, "flat_half_length": 1e-3},
    "power-1.01": {"kind": "power_law", "exponent": 1.01, "length": 1.0, "rise": 0.3},
    "power-3.5": {"kind": "power_law", "exponent": 3.5, "length": 1.0, "rise": 0.6},
    "power-20": {"kind": "power_law", "exponent": 20.0, "length": 1.0, "rise": 2.0},
    "compound": {
        "kind": "compound",
        "inner_radius": 1.1,
        "outer_radius": 80.0,
        "inner_half_length": 0.0153,
    },
    "wedge": {"kind": "wedge", "tip_radius": 1.0, "tip_half_length": 0.46},
    "polynomial": {"kind": "polynomial", "length": 1.0, "rises": [0.5, 0.3, 0.0, 0.2]},
    "hardly-growing": {"kind": "polynomial", "length": 1.0, "rises": [1.0, -0.9, 0.5]},
    "table": {"kind": "tabulated", "points": ROWS},
}
VERTICES = [[1.9, 0.2], [1.0, 0.45], [0.05, -0.02], [1.3, -0.6], [1.7, 0.1]]
POLYGON = {"kind": "polygon", "initial_loading": VERTICES[:1], "cycle": VERTICES[1:]}
SERIES = {
    "kind": "time_series",
    "rows": [[float(k), *point] for k, point in enumerate([*VERTICES, VERTICES[0]])],
    "repeats": True,
}


def ellipse(p0: float, p1: float, q0: float, q1: float, degrees: float) -> dict[str, Any]:
    names = (
        "mean_normal_load",
        "normal_amplitude",
        "mean_tangential_load",
        "tangential_amplitude",
        "phase_degrees",
    )
    return {"kind": "ellipse"} | dict(zip(names, (p0, p1, q0, q1, degrees), strict=True))


# to 0.9 of gross sliding at f = 0.5
STEEP = ellipse(1.0, 0.9, 0.0, 0.45 * math.sqrt(1 - 0.81), 90.0)
WAVES = {
    "kind": "harmonics",
    "mean_normal_load": 1.0,
    "mean_tangential_load": 0.02,
    "normal_harmonics": [[0.7, 0.0], [0.05, 40.0]],
    "tangential_harmonics": [[0.08, -45.0], [0.03, 57.3]],
}


def question(
    profile: dict[str, Any],
    load: dict[str, Any],
    friction: float = 0.5,
    unit: dict[str, float] = UNIT,
) -> dict[str, Any]:
    return {
        "material": unit,
        "profile": profile,
        "friction": {"coefficient": friction},
        "load": load,
        "cycles": 3,
    }


def random_rows(seed: int, count: int, friction: float) -> list[list[float]]:
    """(P, Q) with P from 0.3 to 2 and |Q| <= 0.9 f P; Python's own generator, the same
    everywhere.
    """
    draw = random.Random(seed)
    loads = [draw.uniform(0.3, 2.0) for _ in range(count)]
    return [[p, draw.uniform(-0.9, 0.9) * friction * p] for p in loads]


def random_series(seed: int, count: int, friction: float, repeats: bool) -> dict[str, Any]:
    rows = random_rows(seed, count, friction)
    rows = [*rows, rows[0]] if repeats else rows
    return {
        "kind": "time_series",
        "rows": [[float(k), *row] for k, row in enumerate(rows, 1)],
        "repeats": repeats,
    }


def drawn() -> dict[str, dict[str, Any]]:
    """Name to scene, about thirty."""
    flat, hertz = PROFILES["long-flat"], PROFILES["hertz"]
    middle_flat = {"kind": "flat_rounded", "radius": 2.0, "flat_half_length": 0.7}
    scenes = {f"{name}, ellipse": question(profile, STEEP) for name, profile in PROFILES.items()}
    scenes |= {
        f"{name}, polygon": question(PROFILES[name], POLYGON)
        for name in ("short-flat", "power-3.5", "compound", "table")
    }
    scenes |= {
        f"{name}, series": question(PROFILES[name], SERIES)
        for name in ("long-flat", "wedge", "polynomial")
    }
    scenes |= {
        f"{name}, harmonics": question(PROFILES[name], WAVES)
        for name in ("hertz", "long-flat", "table")
    }
    for seed, profile in enumerate((hertz, middle_flat, PROFILES["power-20"]), 1):
        rows = random_rows(seed, 9, 0.7)
        scenes[f"random polygon {seed}"] = question(
            profile, {"kind": "polygon", "initial_loading": rows[:2], "cycle": rows[2:]}, 0.7
        )
    scenes["rows 400"] = question(hertz, random_series(4, 400, 0.3, False), 0.3)
    scenes["rows 1500, repeated"] = question(hertz, random_series(5, 1500, 0.3, True), 0.3)
    scenes["rows 1200 on a flat"] = question(middle_flat, random_series(6, 1200, 0.3, False), 0.3)
    # Gross sliding at the phase 90 degrees: |(f P1, Q1)| = f P0.
    for name, apart in (("1e-6", 1e-6), ("1e-12", 1e-12)):
        scenes[f"{name} from sliding"] = question(
            hertz, ellipse(1.0, 0.4, 0.0, (1 - apart) * 0.5 * math.sqrt(1 - 0.16), 90.0)
        )
    scenes["slip of 1e-9"] = question(hertz, ellipse(1.0, 0.0, 0.0, 0.5e-9, 90.0))
    scenes["slip of 1e-5 on a flat"] = question(flat, ellipse(1.0, 0.3, 0.1, 0.5 * 0.3 + 1e-5, 0.0))
    scenes["P to 1e-9"] = question(hertz, ellipse(1.0, 1 - 1e-9, 0.0, 1e-5, 90.0))
    scenes["P to 1e-6 on a flat"] = question(middle_flat, ellipse(1.0, 1 - 1e-6, 0.0, 2e-4, 100.0))
    steel = {"young_modulus": 210e9, "poisson_ratio": 0.3}
    scenes["metres and pascals"] = question(
        {"kind": "hertz", "radius": 0.05}, ellipse(2e5, 5e4, 1e4, 4e4, 70.0), 0.5, steel
    )
    # Unequal sides and tilt where the answer is exact: one memory curve.
    unequal = {
        "kind": "tabulated",
        "symmetric": False,
        "points": [[-x, 0.7 * h] for x, h in ROWS[:0:-1]] + ROWS,
    }
    scenes |= {
        "unequal sides, polygon": question(unequal, POLYGON),
        "unequal sides, ellipse": question(unequal, STEEP),
    }
    scenes["line of action"] = question(
        hertz, STEEP | {"line_of_action": {"x": 0.05, "height": 0.0}}
    )
    scenes["separates"] = question(hertz, ellipse(1.0, 1.1, 0.0, 0.1, 90.0))
    scenes["slides"] = question(middle_flat, ellipse(1.0, 0.5, 0.0, 0.6, 45.0))
    scenes["slides on a line"] = question(
        hertz,
        {"kind": "polygon", "initial_loading": [[1.0, 0.2]], "cycle": [[0.3, 0.2], [1.1, 0.2]]},
    )
    return scenes


def functions() -> dict[str, Scene]:
    """Scenes with Python functions in them."""
    body = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    load = CallableLoad(
        normal_load=lambda t: 1 + 0.6 * math.cos(t),
        tangential_load=lambda t: 0.15 * math.cos(t - 1.2) + 0.02 * math.sin(3 * t),
        duration=2 * math.pi,
        repeats=True,
    )
    sinh = CallableProfile(slope_function=np.sinh, extent=12.0)

    def scene(name: str, profile: Any, loads: Any) -> Scene:
        given = {
            "material": Materials(upper=body, lower=body),
            "friction": {"coefficient": 0.5},
            "cycles": 3,
        }
        return Scene(name=name, profile=profile, load=loads, **given)

    return {
        "function of x, ellipse": scene("function of x, ellipse", sinh, STEEP),
        "functions of time": scene("functions of time", PROFILES["hertz"], load),
    }


def library() -> tuple[str, ...]:
    """Every scene that is a file: of the library, and of tests/scenes."""
    return tuple(sorted((*scene_names(), *CASES)))
