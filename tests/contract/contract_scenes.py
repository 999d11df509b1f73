"""The scenes of the contract that are no files of the library: those of Python functions, which
can't be keys of the table of cases.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scene_cases import CASES
from scenes import CallableLoad, CallableProfile, Elastic, Materials, Scene, scene_names

# to 0.9 of gross sliding at f = 0.5
STEEP = {
    "kind": "ellipse",
    "mean_normal_load": 1.0,
    "normal_amplitude": 0.9,
    "mean_tangential_load": 0.0,
    "tangential_amplitude": 0.45 * math.sqrt(1 - 0.81),
    "phase_degrees": 90.0,
}


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
        "functions of time": scene("functions of time", {"kind": "hertz", "radius": 0.5}, load),
    }


def library() -> tuple[str, ...]:
    """Every scene that is a file: of the library, and of tests/scenes."""
    return tuple(sorted((*scene_names(), *CASES)))
