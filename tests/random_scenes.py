"""Whole scenes as Hypothesis draws them: every kind of profile and load, f from 1e-3 to 10, within the cone of friction."""

import math
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st

from scenes import CallableLoad, CallableProfile, Elastic, Materials, Scene

PROFILES = ("hertz", "flat_rounded", "power_law", "compound", "wedge", "polynomial", "tabulated", "callable")
LOADS = ("ellipse", "polygon", "time_series", "harmonics", "callable")
SMOOTH = ("harmonics", "callable")
X = np.linspace(0.0, 12.0, 61)


@dataclass(frozen=True)
class Drawn:
    """The numbers of a scene; `in_other_clothes` and `scene` make scenes of them.

    Attributes
    ----------
    part, sharp : size of the profile's second part over its first, and what else it is made of, 0 to 1
    mean, swing, use : mean load, its amplitude over it, and how much of the room for Q is taken
    offset : mean tangential load over the room that is left
    """

    profile: str
    load: str
    friction: float
    part: float
    sharp: float
    mean: float
    swing: float
    use: float
    phases: tuple[float, float]
    offset: float = 0.0
    sign: float = 1.0
    length: float = 1.0
    stress: float = 1.0

    @property
    def scene(self) -> Scene:
        """As the engines take it."""
        body = Elastic(young_modulus=2 * self.stress, poisson_ratio=0.0)
        return Scene(
            name="random",
            material=Materials(upper=body, lower=body),
            friction={"coefficient": self.friction},
            profile=_profile(self),
            load=_load(self),
        )

    def turned(self, **changes: float) -> "Drawn":
        """The same with other numbers."""
        return replace(self, **changes)


def drawn(profiles: tuple[str, ...] = PROFILES, loads: tuple[str, ...] = LOADS) -> st.SearchStrategy[Drawn]:
    """Scenes; P stays above a twentieth of its mean, Q within 0.99 of f P."""
    angle = st.floats(-math.pi, math.pi)
    return st.builds(
        Drawn,
        profile=st.sampled_from(profiles),
        load=st.sampled_from(loads),
        friction=st.floats(-3.0, 1.0).map(lambda power: 10.0**power),
        part=st.floats(-1.0, 0.5).map(lambda power: 10.0**power),
        sharp=st.floats(0.0, 1.0),
        mean=st.floats(0.3, 1.0),
        swing=st.floats(0.0, 0.95),
        use=st.one_of(st.sampled_from([0.01, 0.99]), st.floats(0.01, 0.99)),
        phases=st.tuples(angle, angle),
    )


def _profile(one: Drawn) -> object:
    unit, part = one.length, one.part
    match one.profile:
        case "hertz":
            return {"kind": "hertz", "radius": part * unit}
        case "flat_rounded":
            return {"kind": "flat_rounded", "radius": unit, "flat_half_length": part * unit}
        case "power_law":
            return {"kind": "power_law", "exponent": 1.0 + 4.0 * one.sharp, "length": unit, "rise": part * unit}
        case "compound":
            half = (0.2 + 0.8 * one.sharp) * unit
            return {"kind": "compound", "inner_radius": unit, "outer_radius": part * unit, "inner_half_length": half}
        case "wedge":
            return {"kind": "wedge", "tip_radius": unit, "tip_half_length": part * unit}
        case "polynomial":
            return {"kind": "polynomial", "length": unit, "rises": [0.5 * unit, part * unit]}
        case "tabulated":
            rise = part * unit * (np.cosh(X / 3) - 1)
            return {"kind": "tabulated", "points": np.column_stack([unit * X, rise]).tolist()}
        case _:
            return CallableProfile(slope_function=lambda x: part * np.sinh(x / unit), extent=12 * unit)


def _load(one: Drawn) -> object:
    force, friction, (first, second) = one.length * one.stress, one.friction, one.phases
    swing = max(one.swing, 0.02) if one.load == "polygon" else one.swing  # no corner stands twice in a row
    p0, p1 = force * one.mean, force * one.mean * swing
    room = friction * (p0 - p1)
    q0, q1 = one.sign * one.offset * room * (1 - one.use), one.sign * one.use * room
    amplitudes = {"mean_normal_load": p0, "mean_tangential_load": q0}
    if one.load == "ellipse":
        degrees = math.degrees(first) - (0 if q1 >= 0 else math.copysign(180, first))
        own = {"normal_amplitude": p1, "tangential_amplitude": abs(q1), "phase_degrees": degrees}
        return {"kind": "ellipse", **amplitudes, **own}
    if one.load == "harmonics":
        turned = 0 if q1 >= 0 else 180
        waves = [[0.7 * abs(q1), math.degrees(first) + turned], [0.3 * abs(q1), math.degrees(second) + turned]]
        return {"kind": "harmonics", **amplitudes, "normal_harmonics": [[p1, 0.0]], "tangential_harmonics": waves}
    if one.load == "callable":
        return CallableLoad(
            normal_load=lambda t: p0 + p1 * math.cos(t),
            tangential_load=lambda t: q0 + q1 * math.cos(t - first),
            duration=2 * math.pi,
            repeats=True,
        )
    turn = 2 * np.pi * np.arange(25 if one.load == "time_series" else 9) / (24 if one.load == "time_series" else 8)
    waves = q0 + q1 * (0.7 * np.cos(turn - first) + 0.3 * np.cos(2 * turn - second))
    rows = np.column_stack([turn, p0 + p1 * np.cos(turn), waves])
    rows[-1, 1:] = rows[0, 1:]
    if one.load == "time_series":
        return {"kind": "time_series", "rows": rows.tolist(), "repeats": True}
    corners = rows[:-1, 1:].tolist()
    return {"kind": "polygon", "initial_loading": corners[:1], "cycle": corners[1:]}
