"""Friction work in independent ways that shall be one number: slip areas, W(x) over x, closed integral of Q dU, the batch."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes import Compound, EllipseLoad, FlatRounded, Hertz, PowerLaw, Tabulated, Wedge, load_scene, scene_names
from semi_analytic import dissipation, solve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import closed_integral, global_dissipation
from semi_analytic.history import history_of
from semi_analytic.profiles import contact_of
from semi_analytic_cases import ellipse, make_scene
from semi_analytic_truth import work_over_points

LONG = {"harmonics", "time-series"}  # W(x) by halving, 25 s; 75 kinks, 2 s


def setup(scene):
    """Contact, E*, spans of the last cycle."""
    history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    return contact_of(scene.profile, scene.material), composite_modulus(scene.material), history.cycles[-1]


def batch(scene):
    """W by the batch."""
    load = scene.load
    names = ("mean_normal_load", "normal_amplitude", "mean_tangential_load", "tangential_amplitude")
    return float(
        dissipation(
            profile=scene.profile,
            material=scene.material,
            friction_coefficient=scene.friction.coefficient,
            phase=math.radians(load.phase_degrees),
            **{name: getattr(load, name) for name in names},
        ).value
    )


def routes(scene):
    """By slip areas first, then by every other way that there is."""
    contact, modulus, spans = setup(scene)
    work = float(global_dissipation(contact, modulus, spans).total)
    found = [work, solve(scene, x=[0.0], fields=("dissipation",)).dissipation]
    found.append(work_over_points(contact, modulus, spans, work))
    if scene.load.path().period is not None:
        found.append(closed_integral(contact, modulus, spans)[0])
    if isinstance(scene.load, EllipseLoad):
        found.append(batch(scene))
    return np.array(found)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in scene_names()])
def test_every_way_to_the_work_of_a_scene_of_the_library_meets(name):
    """Worst measured 3e-11 (tiny-slip, Q dU, where W is 1e-9 of A f^2 P^2), 1.2e-13 elsewhere; 0 where nothing slips."""
    scene = load_scene(name)
    found = routes(scene)
    size = 2 / composite_modulus(scene.material) * (scene.friction.coefficient * np.max(solve(scene, x=[0.0]).normal_load)) ** 2
    np.testing.assert_allclose(found, found[0], rtol=1e-10, atol=0 if found[0] else 1e-15 * size)


PROFILES = st.one_of(
    st.just(Hertz(radius=1.0)),
    st.sampled_from([0.1, 2.0]).map(lambda b: FlatRounded(radius=1.0, flat_half_length=b)),
    st.floats(1.1, 4.0).map(lambda n: PowerLaw(exponent=n, length=1.0, rise=0.5)),
    st.floats(0.3, 3.0).map(lambda r: Compound(inner_radius=1.0, outer_radius=r, inner_half_length=1.1)),
    st.just(Wedge(tip_radius=1.0, tip_half_length=0.9)),
)


@settings(max_examples=6)
@given(PROFILES, st.floats(0.0, 0.97), st.floats(0.05, 0.97), st.floats(-179, 179), st.floats(0.01, 5))
def test_every_way_to_the_work_of_an_ellipse_meets(profile, ratio, use, phase, friction):
    """1e-10, or 1e-14 of A f^2 P0^2 where there is next to no slip."""
    scene = make_scene(ellipse(1.0, ratio, 0.0, use * friction * (1 - ratio), phase), friction)
    found = routes(scene.vary(profile=profile))
    np.testing.assert_allclose(found, found[0], rtol=1e-10, atol=1e-14 * friction**2)


def table(count):
    x = np.linspace(0, 4, count)
    return Tabulated(points=np.column_stack([x, np.cosh(x) - 1]).tolist())


CORNERED = {
    "compound": Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=1.2),
    "wedge": Wedge(tip_radius=1.0, tip_half_length=0.9),
    "table of 31 rows": table(31),
    "table of 301 rows": table(301),
}


@pytest.mark.parametrize("profile", CORNERED.values(), ids=CORNERED)
def test_an_arc_that_passes_corners_of_the_profile_keeps_its_digits(profile):
    """Q dU takes the logarithm along the arc, tractions and slips its kernels: 1e-12 and 4e-13; 2e-6 and 2e-5 if not cut."""
    scene = make_scene(ellipse(1.0, 0.6, 0.1, 0.3, -70.0)).vary(profile=profile)
    answer = solve(scene, x=np.linspace(0.0, 1.6, 9), time=np.linspace(2.0, 20.0, 7))
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-11, abs=0)
    # The second rule of the estimate shares nothing but the kernel with the first.
    assert max(answer.record.errors[name] for name in ("shear", "slip")) < 1e-11
