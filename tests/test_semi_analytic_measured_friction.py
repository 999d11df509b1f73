"""The coefficient of friction from a measured dissipation: every root against brute force, the limit of large f, reasons."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from scenes import FlatRounded, Hertz, Materials, PowerLaw, load_scene
from semi_analytic import NoFriction, dissipation, friction_from, solve
from semi_analytic.measured_friction import sliding_limit
from semi_analytic_cases import UNIT

MATERIAL = Materials(upper=UNIT, lower=UNIT)
PROFILES = {
    "hertz": Hertz(radius=1.0),
    "flat and rounded": FlatRounded(radius=1.0, flat_half_length=1.0),
    "wedge": PowerLaw(exponent=1.0, length=1.0, rise=1.0),
    "radii": {"kind": "hertz", "radius": np.linspace(1.0, 2.0, 60)},
    "eighth power": PowerLaw(exponent=8.0, length=1.0, rise=1.0),
}


def random_loads(seed, count=60):
    rng = np.random.default_rng(seed)
    amplitude = rng.uniform(0.0, 0.98, count)
    amplitude[:10], amplitude[10:15] = 10 ** rng.uniform(-7, -1, 10), 0.0
    return {
        "material": MATERIAL,
        "mean_normal_load": 1.0,
        "normal_amplitude": amplitude,
        "mean_tangential_load": rng.uniform(-0.5, 0.5, count) * rng.integers(0, 2, count),
        "tangential_amplitude": 10 ** rng.uniform(-3, 0.3, count),
        "phase": rng.uniform(-3.1, 3.1, count),
    }


@pytest.mark.parametrize("name", PROFILES)
def test_every_root_is_found_as_brute_force_counts_them(name):
    question = {"profile": PROFILES[name]} | random_loads(sorted(PROFILES).index(name))
    span = friction_from(1.0, **question)
    target = span.least + (span.most - span.least) * np.random.default_rng(1).uniform(0.02, 0.98, 60)
    found = friction_from(target, **question)
    assert not found.reason.any()
    with np.errstate(divide="ignore"):
        no_slip = question["tangential_amplitude"] / question["normal_amplitude"]
    top = np.maximum(found.least_friction, np.where(np.isfinite(no_slip), no_slip, 0.0)) * 1e6
    every = found.least_friction * (1 + 1e-12) * (top / found.least_friction) ** np.linspace(0, 1, 1801)[:, None]
    works = dissipation(friction_coefficient=every, **question).value
    crossings = np.count_nonzero(np.diff(np.sign(works - target), axis=0), axis=0)
    near = np.min(np.abs(works - target), axis=0) < 1e-5 * target  # two roots between two samples of the brute force
    assert np.all((crossings == found.count) | near)
    assert np.count_nonzero(crossings != found.count) <= 2
    again = dissipation(friction_coefficient=np.moveaxis(found.roots, -1, 0), **question).value
    there = np.isfinite(found.roots).T
    assert np.allclose(again[there], np.broadcast_to(target, again.shape)[there], rtol=1e-8, atol=0)
    assert np.all(np.diff(found.roots, axis=-1)[there.T[:, 1:]] > 0)


def test_two_and_three_roots_where_the_normal_load_varies():
    question = {"profile": Hertz(radius=1.0), "material": MATERIAL, "mean_normal_load": 1.0}
    two = {"normal_amplitude": 1 / 3, "tangential_amplitude": 1 / 3, "phase": math.pi / 2}
    least = friction_from(1.0, **question, **two).least
    found = friction_from([1.01 * least, 1.001 * least, (1 + 1e-8) * least], **question, **two)
    assert found.count.tolist() == [2, 2, 2]  # the last two next to the turning point, between two samples of the search
    assert np.all(np.diff(np.diff(found.roots, axis=1), axis=0) < 0)
    dense = dissipation(friction_coefficient=np.linspace(0.6, 2.0, 20001), **question, **two).value
    assert least == pytest.approx(np.nanmin(dense), rel=1e-9)
    three = {"normal_amplitude": 0.7, "tangential_amplitude": 0.1, "phase": 1.66}
    friction = sliding_limit(1.0, 0.7, 0.0, 0.1, 1.66) * np.geomspace(1.000001, 1e4, 4001)
    works = dissipation(friction_coefficient=friction, **question, **three).value
    turns = np.flatnonzero(np.diff(np.sign(np.diff(works)))) + 1
    assert len(turns) == 2  # least, then most, then down to the limit
    between = (max(works[turns[0]], works[-1]) + min(works[0], works[turns[1]])) / 2
    assert friction_from(between, **question, **three).count == 3


@pytest.mark.parametrize(("amplitude", "tangential", "phase"), [(0.5, 0.1, 1.0), (0.9, 0.3, 2.0), (0.1, 0.01, -0.3)])
def test_dissipation_at_large_friction_is_its_closed_limit(amplitude, tangential, phase):
    work = dissipation(
        profile=Hertz(radius=1.0),
        material=MATERIAL,
        friction_coefficient=1e7,
        mean_normal_load=1.0,
        normal_amplitude=amplitude,
        tangential_amplitude=tangential,
        phase=phase,
    ).value
    inverse = quad(lambda t: math.sin(t) ** 3 / (2 * (1 + amplitude * math.cos(t))), 0, math.pi, epsabs=1e-14)[0]
    limit = 4 / math.pi * amplitude * (tangential * math.sin(phase)) ** 2 * inverse  # A = 2
    assert work == pytest.approx(limit, rel=1e-5)


def test_the_sliding_limit_is_the_largest_quotient_of_the_loads():
    loads = random_loads(3)
    time = np.linspace(0, 2 * math.pi, 20001)[:, None]
    normal = 1 + loads["normal_amplitude"] * np.cos(time)
    tangential = loads["mean_tangential_load"] + loads["tangential_amplitude"] * np.cos(time - loads["phase"])
    found = sliding_limit(
        1.0, *(loads[key] for key in ("normal_amplitude", "mean_tangential_load", "tangential_amplitude", "phase"))
    )
    assert np.allclose(found, np.max(np.abs(tangential) / normal, axis=0), rtol=1e-5)


def test_a_scene_with_another_load_is_inverted_by_the_engine_that_marches():
    scene = load_scene("cattaneo-mindlin")
    work = solve(scene, x=0.0, fields="dissipation").dissipation
    found = friction_from([work, 1e9], scene=scene)
    assert found.count.tolist() == [1, 0]
    assert found.roots[0, 0] == pytest.approx(scene.friction.coefficient, rel=1e-9)
    assert found.reason[1] == NoFriction.TOO_MUCH


def test_a_member_without_a_root_gets_one_reason():
    scene = load_scene("hertz-paper")
    found = friction_from([1e-9, 1.0, -1.0, np.nan], scene=scene)
    assert found.reason.tolist() == [NoFriction.TOO_LITTLE, NoFriction.TOO_MUCH, NoFriction.INVALID, NoFriction.INVALID]
    assert np.isnan(found.roots).all()
    assert len(found.sentences) == 4
    assert "the least is 0.002057" in found.sentences[0]
    assert "the most is 0.00230181, and they slide grossly below f = 0.79185" in found.sentences[1]
    question = {"profile": Hertz(radius=1.0), "material": UNIT, "mean_normal_load": 1.0, "tangential_amplitude": 0.1}
    apart = friction_from(0.1, normal_amplitude=[1.5, 0.5], **question)
    assert apart.reason[0] == NoFriction.LOADS
