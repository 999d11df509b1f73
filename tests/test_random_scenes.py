"""Random scenes: of every profile and load through the half-plane engine, and random loops through
the finite-element model.

Invariants: mirror (Q -> -Q), scale, superposition (p knows nothing of Q and friction), start-up
(the steady cycle knows nothing of the mean of Q), energy (slip areas against Q dU), certificates
(cone, M(P) = Q), W >= 0. A scene that once broke one stands in tests/data/regression_scenes with a
line that says what broke.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, seed, settings
from hypothesis import strategies as st

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from scenes import (
    CallableLoad,
    CallableProfile,
    Elastic,
    InadmissibleLoadError,
    Materials,
    Scene,
    load_scene,
)

PROFILES = (
    "hertz",
    "flat_rounded",
    "power_law",
    "compound",
    "wedge",
    "polynomial",
    "tabulated",
    "callable",
)
LOADS = ("ellipse", "polygon", "time_series", "harmonics", "callable")
SMOOTH = ("harmonics", "callable")
X = np.linspace(0.0, 12.0, 61)


@dataclass(frozen=True)
class Drawn:
    """The numbers of a scene.

    Attributes
    ----------
    part, sharp : size of the profile's second part over its first, and what else it is made of, 0
        to 1
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
        body = Elastic(young_modulus=2 * self.stress, poisson_ratio=0.0)
        return Scene(
            name="random",
            material=Materials(upper=body, lower=body),
            friction={"coefficient": self.friction},
            profile=_profile(self),
            load=_load(self),
        )


def drawn(
    profiles: tuple[str, ...] = PROFILES, loads: tuple[str, ...] = LOADS
) -> st.SearchStrategy[Drawn]:
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


def _profile(drawing: Drawn) -> object:
    unit = drawing.length
    part = drawing.part
    match drawing.profile:
        case "hertz":
            return {"kind": "hertz", "radius": part * unit}
        case "flat_rounded":
            return {"kind": "flat_rounded", "radius": unit, "flat_half_length": part * unit}
        case "power_law":
            return {
                "kind": "power_law",
                "exponent": 1.0 + 4.0 * drawing.sharp,
                "length": unit,
                "rise": part * unit,
            }
        case "compound":
            half = (0.2 + 0.8 * drawing.sharp) * unit
            return {
                "kind": "compound",
                "inner_radius": unit,
                "outer_radius": part * unit,
                "inner_half_length": half,
            }
        case "wedge":
            return {"kind": "wedge", "tip_radius": unit, "tip_half_length": part * unit}
        case "polynomial":
            return {"kind": "polynomial", "length": unit, "rises": [0.5 * unit, part * unit]}
        case "tabulated":
            rise = part * unit * (np.cosh(X / 3) - 1)
            return {"kind": "tabulated", "points": np.column_stack([unit * X, rise]).tolist()}
        case _:
            return CallableProfile(
                slope_function=lambda x: part * np.sinh(x / unit), extent=12 * unit
            )


def _load(drawing: Drawn) -> object:
    force = drawing.length * drawing.stress
    friction = drawing.friction
    first, second = drawing.phases
    # no corner stands twice in a row
    swing = max(drawing.swing, 0.02) if drawing.load == "polygon" else drawing.swing
    p0 = force * drawing.mean
    p1 = force * drawing.mean * swing
    room = friction * (p0 - p1)
    q0 = drawing.sign * drawing.offset * room * (1 - drawing.use)
    q1 = drawing.sign * drawing.use * room
    amplitudes = {"mean_normal_load": p0, "mean_tangential_load": q0}
    if drawing.load == "ellipse":
        degrees = math.degrees(first) - (0 if q1 >= 0 else math.copysign(180, first))
        ellipse = {
            "normal_amplitude": p1,
            "tangential_amplitude": abs(q1),
            "phase_degrees": degrees,
        }
        return {"kind": "ellipse", **amplitudes, **ellipse}
    if drawing.load == "harmonics":
        turned = 0 if q1 >= 0 else 180
        waves = [
            [0.7 * abs(q1), math.degrees(first) + turned],
            [0.3 * abs(q1), math.degrees(second) + turned],
        ]
        return {
            "kind": "harmonics",
            **amplitudes,
            "normal_harmonics": [[p1, 0.0]],
            "tangential_harmonics": waves,
        }
    if drawing.load == "callable":
        return CallableLoad(
            normal_load=lambda t: p0 + p1 * math.cos(t),
            tangential_load=lambda t: q0 + q1 * math.cos(t - first),
            duration=2 * math.pi,
            repeats=True,
        )
    turn = (
        2
        * np.pi
        * np.arange(25 if drawing.load == "time_series" else 9)
        / (24 if drawing.load == "time_series" else 8)
    )
    waves = q0 + q1 * (0.7 * np.cos(turn - first) + 0.3 * np.cos(2 * turn - second))
    rows = np.column_stack([turn, p0 + p1 * np.cos(turn), waves])
    rows[-1, 1:] = rows[0, 1:]
    if drawing.load == "time_series":
        return {"kind": "time_series", "rows": rows.tolist(), "repeats": True}
    corners = rows[:-1, 1:].tolist()
    return {"kind": "polygon", "initial_loading": corners[:1], "cycle": corners[1:]}


# ---------------------------------------------------------------------------- the half-plane engine
SCENES = 2000
MODELS = 200
BLOCKS = 40
REGRESSIONS = sorted((Path(__file__).parent / "data" / "regression_scenes").glob("*.toml"))
NUMERICAL = ("tabulated", "callable")
CLOSED = tuple(name for name in PROFILES if name not in NUMERICAL)
TOLD = 0.05


def costs_seconds(drawing):
    """Smooth paths that are no ellipses, on a table: 1 to 10 s a solve, every law 13 to 37 s."""
    return drawing.profile == "tabulated" and drawing.load in SMOOTH


def solved(scene):
    """Dissipation of the steady cycle, without fields."""
    return semi_analytic.solve(scene, x=[0.0], fields=("loop_work",))


def unit_of(scene, answer):
    """f^2 P^2/E* with the largest load."""
    return (scene.friction.coefficient * float(np.max(answer.normal_load))) ** 2 / (
        scene.material.lower.young_modulus / 2
    )


def check(scene, answer):
    """What holds of any answer."""
    assert max(float(np.max(values)) for values in answer.record.certificates.values()) < 1e-11
    assert answer.dissipation >= 0
    if math.isfinite(answer.loop_work):
        allowed = 1e-7 + answer.record.errors.get("dissipation", 0.0)
        off = abs(answer.loop_work - answer.dissipation)
        assert off <= allowed * answer.dissipation + 1e-12 * unit_of(scene, answer)


def check_fields(drawing, answer):
    """Inside the cone, symmetric, and p the same without friction and without Q, at a few
    instants.
    """
    scene = drawing.scene
    half = float(np.max(answer.contact_half_width))
    places = {
        "x": half * np.linspace(-1.05, 1.05, 12),
        "time": answer.time[:: max(len(answer.time) // 4, 1)][-3:],
    }
    solution = semi_analytic.solve(scene, **places, fields=("pressure", "shear"))
    limit = scene.friction.coefficient * solution.pressure
    assert np.all(np.abs(solution.shear) <= limit * (1 + 1e-12) + 1e-9 * np.max(limit))
    size = 1e-12 * np.max(solution.pressure)
    np.testing.assert_allclose(solution.pressure, solution.pressure[:, ::-1], rtol=0, atol=size)
    pressed = replace(drawing, sign=0.0).scene.vary(friction=0.0)
    alone = semi_analytic.solve(pressed, **places, fields=("pressure", "dissipation"))
    np.testing.assert_allclose(alone.pressure, solution.pressure, rtol=0, atol=size)
    assert alone.dissipation == 0


def same_work(drawing, answer, changed, factor=1.0):
    """Other clothes, the same W: to 1e-9, to what the answers say of themselves, or to 1e-12 of f^2
    P^2/E*.
    """
    try:
        other_answer = solved(changed.scene)
    except InadmissibleLoadError:
        assert drawing.use > 0.98 or changed.offset, (
            "only rounding or an offset can make an admissible path slide"
        )
        return
    stated = max(each.record.errors.get("dissipation", 0.0) for each in (answer, other_answer))
    off = abs(other_answer.dissipation / factor - answer.dissipation)
    assert off <= (1e-9 + stated) * answer.dissipation + 1e-12 * unit_of(drawing.scene, answer)


def keeps_every_law(drawing):
    try:
        answer = solved(drawing.scene)
    except InadmissibleLoadError:
        assume(False)
    check(drawing.scene, answer)
    if costs_seconds(drawing):
        return
    check_fields(drawing, answer)
    same_work(drawing, answer, replace(drawing, sign=-1.0))
    same_work(drawing, answer, replace(drawing, length=2.0**30, stress=2.0**-40), 2.0**20)
    same_work(drawing, answer, replace(drawing, offset=0.5))


# Nothing is shrunk where a scene takes seconds: the one that failed is printed as it was drawn.
LONG = {
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.filter_too_much],
    "phases": [Phase.explicit, Phase.generate],
}


@settings(max_examples=6)
@given(drawn(CLOSED, ("ellipse", "polygon", "time_series")))
def test_a_few_random_scenes_keep_every_law(drawing):
    keeps_every_law(drawing)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_two_thousand_random_scenes_keep_every_law(block):
    """One in twenty of those that take seconds a solve is kept, with the laws of one answer; all
    others with every law.
    """
    count = {"smooth": 0}

    @seed(block)
    @settings(max_examples=SCENES // BLOCKS, **LONG)
    @given(drawn())
    def trial(drawing):
        if costs_seconds(drawing):
            count["smooth"] += 1
            assume(count["smooth"] % 20 == 1)
        keeps_every_law(drawing)

    trial()


def told(answer, *words):
    """Whether a note says so of what is asked."""
    return any(word in note for note in answer.record.notes for word in words)


def model_of(scene):
    """By finite elements on a coarse mesh."""
    return halfplane_fe.solve(scene, MeshSettings.coarse(), SolverSettings(steps_per_cycle=24))


def check_model(drawing):
    """Laws, mirror, and p, q and W against theory to 5 % each, or a note of the very thing that is
    off.
    """
    scene = drawing.scene
    try:
        answer = model_of(scene)
    except InadmissibleLoadError:
        assume(False)
    assert max(float(values.max()) for values in answer.record.certificates.values()) < 1e-7
    loaded = np.flatnonzero(answer.normal_load > 0.3 * answer.normal_load.max())
    last = np.intersect1d(loaded, np.arange(len(answer.time))[answer.last_cycle])
    chosen = last[np.unique(np.linspace(0, len(last) - 1, 6).astype(int))]
    exact = semi_analytic.solve(
        scene, x=answer.x, time=answer.time[chosen], fields=("pressure", "shear")
    )
    is_finite = np.isfinite(exact.pressure).all(axis=0)  # it is infinite at the tip of a wedge
    size = np.sqrt(exact.pressure[:, is_finite] ** 2 @ answer.face_lengths[is_finite])
    friction = scene.friction.coefficient
    differences = {
        name: (getattr(answer, name)[chosen] - getattr(exact, name))[:, is_finite]
        for name in ("pressure", "shear")
    }
    off = {
        name: float(
            np.max(np.sqrt(differences[name] ** 2 @ answer.face_lengths[is_finite]) / (unit * size))
        )
        for name, unit in (("pressure", 1.0), ("shear", friction))
    }
    assert off["pressure"] <= TOLD or told(
        answer, "the pressure by", "in the pressure (L2)", "tractions and dissipation"
    ), off
    assert off["shear"] <= TOLD or told(
        answer, "the shear may be off", "in the pressure (L2)", "tractions and dissipation"
    ), off
    work = solved(scene).dissipation
    astray = abs(answer.dissipation - work)
    assert astray <= TOLD * work or told(
        answer, "dissipation is", "its dissipation would", "tractions and dissipation"
    ), astray / work
    assert astray <= 0.1 * work + 1e-3 * 2 * unit_of(scene, answer)
    mirrored = model_of(replace(drawing, sign=-1.0).scene)
    assert mirrored.dissipation == pytest.approx(
        answer.dissipation, rel=1e-4, abs=1e-6 * unit_of(scene, answer)
    )


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_random_models_keep_every_law_and_theory(block):
    @seed(1000 + block)
    @settings(max_examples=MODELS // BLOCKS, **LONG)
    @given(
        drawn(loads=("ellipse", "polygon", "time_series", "harmonics")).filter(
            lambda drawing: not costs_seconds(drawing)
        )
    )
    def trial(drawing):
        check_model(drawing)

    trial()


@pytest.mark.parametrize("path", REGRESSIONS, ids=lambda path: path.stem)
def test_scenes_that_once_broke_keep_every_law(path):
    scene = load_scene(path)
    exact = solved(scene)
    check(scene, exact)
    assert exact.steady_from == 1
    answer = model_of(scene)
    assert max(float(values.max()) for values in answer.record.certificates.values()) < 1e-7
    off = abs(answer.dissipation - exact.dissipation)
    assert off <= 2e-3 * exact.dissipation + 1e-9 * unit_of(scene, exact)


# ---------------------------------------------------------- three hundred loops at default settings


def random_case(seed: int) -> tuple[Scene, MeshSettings]:
    """f from 0.01 to 2, loops up to 0.999 of gross sliding, either sense, like and unlike
    materials, mesh ratios up to 1 : 4.
    """
    rng = np.random.default_rng(seed)
    friction = 10 ** rng.uniform(-2, np.log10(2))
    swing = rng.uniform(0.0, 0.9)
    phase = rng.uniform(-180, 180)
    mean = 100.0
    angle = np.linspace(0, 2 * np.pi, 4001)
    room = friction * mean * (1 + swing * np.cos(angle))
    share = np.abs(np.cos(angle - np.radians(phase)))
    limit = float(np.min(room / np.maximum(share, 1e-12)))
    steel = {"young_modulus": 210e3, "poisson_ratio": 0.3}
    softer = {"young_modulus": 10 ** rng.uniform(4, 6), "poisson_ratio": rng.uniform(0.0, 0.49)}
    profiles = (
        {"kind": "hertz", "radius": 1000.0},
        {"kind": "flat_rounded", "radius": 500.0, "flat_half_length": 10 ** rng.uniform(-1, 0.5)},
    )
    scene = Scene.model_validate(
        {
            "name": f"random {seed}",
            "material": {"upper": steel if rng.random() < 0.5 else softer, "lower": steel},
            "profile": profiles[rng.integers(2)],
            "friction": {"coefficient": friction},
            "load": {
                "kind": "ellipse",
                "mean_normal_load": mean,
                "normal_amplitude": swing * mean,
                "tangential_amplitude": rng.choice([0.1, 0.5, 0.9, 0.99, 0.999]) * limit,
                "phase_degrees": phase,
            },
            "cycles": 3,
        }
    )
    ratio = float(rng.choice([1.0, 1.0, 0.25, 0.5, 2.0, 4.0]))
    return scene, MeshSettings(element_size=1 / 10, edge_element_size=1 / 24, upper_ratio=ratio)


@pytest.mark.parametrize(
    "seed",
    [
        number if number in (120, 190, 290) else pytest.param(number, marks=pytest.mark.slow)
        for number in range(300)
    ],
)
def test_a_random_admissible_scene_converges_and_keeps_every_law(seed: int) -> None:
    scene, mesh = random_case(seed)
    answer = halfplane_fe.solve(scene, mesh)
    worst = {name: float(values.max()) for name, values in answer.record.certificates.items()}
    assert answer.record.converged
    # beta/f = 15, 0.33 and 1.4: no convergence, or one jump behind the other, without the mesh's
    # own part of N - T and K
    if seed in (25, 55, 89):
        assert told(answer, "faces as they are")
    # Unlike bodies at 0.999 of gross sliding stick at two or three nodes, and the system is as ill
    # conditioned as that sounds.
    assert max(worst.values()) < 1e-7, worst
    assert answer.dissipation >= 0
