"""Profiles and faces: symmetric, rising from zero; arcs to full relative precision; splines that rise and bend as their rows."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from scenes import (
    Block,
    CallableProfile,
    Compound,
    Cylinder,
    EvenPolynomial,
    FlatRounded,
    HalfPlane,
    Hertz,
    Pad,
    PowerLaw,
    Scene,
    Tabulated,
    Wedge,
    load_scene,
)
from scenes.bodies import arc_depth, face_of

PROFILES = [
    Hertz(radius=2.0),
    FlatRounded(radius=2.0, flat_half_length=0.5),
    PowerLaw(exponent=1.7, length=2.0, rise=0.5),
    Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=0.5),
    Wedge(tip_radius=2.0, tip_half_length=0.5),
    EvenPolynomial(length=2.0, rises=(0.5, 0.2)),
    Tabulated(points=[[0, 0], [1, 0.3], [2, 1.3]]),
    CallableProfile(slope_function=np.sinh, extent=3.0),
]


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.kind)
def test_a_profile_is_symmetric_rises_from_zero_and_survives_json(profile):
    x = np.linspace(0, 4, 401)
    height = profile.height(x)
    assert height[0] == 0
    assert np.all(np.diff(height) >= -1e-15)
    np.testing.assert_array_equal(profile.height(-x), height)
    assert np.ndim(profile.height(1.0)) == 0
    assert profile.height(np.ones((2, 3))).shape == (2, 3)
    assert profile.datum_length > 0
    assert isinstance(profile, (Hertz, FlatRounded)) or "mm" in profile.in_words("mm")
    if not isinstance(profile, CallableProfile):
        scene = load_scene("hertz-paper").vary(profile=profile)
        again = Scene.model_validate_json(scene.model_dump_json())
        assert again == scene
        np.testing.assert_array_equal(again.profile.height(x), height)


def test_heights_by_hand():
    assert Hertz(radius=2.0).height([0.0, 1.0, -2.0]).tolist() == [0.0, 0.25, 1.0]
    assert FlatRounded(radius=2.0, flat_half_length=1.0).height([0.0, 1.0, -3.0]).tolist() == [0.0, 0.0, 1.0]
    sides = Tabulated(points=[[-2, 4.001], [-1, 1.0], [0, 0.0], [1, 1.001], [2, 4.0]])  # of which the mean counts
    np.testing.assert_allclose(sides.height([1.0, 2.0]), [1.0005, 4.0005])
    assert FlatRounded(radius=2.0, flat_half_length=1e-12).height(1.0) == pytest.approx(Hertz(radius=2.0).height(1.0))


@pytest.mark.parametrize("count", [6, 25])
def test_the_spline_rises_where_the_rows_do(count):
    rng = np.random.default_rng(3)
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, count))])
    rising = np.concatenate([[0.0], np.cumsum(rng.uniform(0, 1, count) ** 4)])
    profile = Tabulated(points=np.stack([x, rising], axis=1))
    assert np.all(profile.spline().slope >= 0)
    np.testing.assert_allclose(profile.height(x), rising, atol=1e-14 * rising[-1])


# ----------------------------------------------------------------------------------------------------------------- faces
@pytest.mark.parametrize("radius", [1e-3, 5.0, 1e6])
def test_depth_of_an_arc_to_the_last_digit(radius):
    """R - sqrt(R^2 - s^2) loses all digits at s = 1e-9 R; mpmath has them. Past the end by round-off is the end."""
    for share in (1e-9, 1e-4, 0.3, 0.99, 1 - 1e-9, 1.0):
        s = share * radius
        with mpmath.workdps(50):
            exact = float(mpmath.mpf(radius) - mpmath.sqrt(mpmath.mpf(radius) ** 2 - mpmath.mpf(s) ** 2))
        assert float(arc_depth(np.array(s), radius)) == pytest.approx(exact, rel=1e-14)
    assert float(arc_depth(np.array(radius * (1 + 4e-16)), radius)) == pytest.approx(radius, rel=1e-15)


def test_an_arc_is_deeper_than_its_parabola_by_the_fourth_power_and_may_start_at_a_flat():
    x = np.array([0.01, 0.02, 0.04])
    beyond = arc_depth(x, 1.0) - x**2 / 2
    np.testing.assert_allclose(beyond, x**4 / 8, rtol=2e-3)
    np.testing.assert_allclose(np.diff(np.log2(beyond)), 4.0, atol=3e-3)
    end = float(arc_depth(np.array(1.5), 4.0))
    np.testing.assert_allclose(arc_depth(np.array([-2.0, -0.5, 0.0, 0.3, 0.5, 2.0]), 4.0, 0.5), [end, 0, 0, 0, 0, end])


PAD = Pad(width=6.0, height=4.0)
FACES = [
    (Cylinder(radius=5.0), Hertz(radius=20.0), (0.0, 5.0), False),
    (PAD, Hertz(radius=20.0), (0.0, 20.0), False),
    (PAD, FlatRounded(radius=4.0, flat_half_length=0.5), (0.5, 4.0), False),
    (PAD, Wedge(tip_radius=5.0, tip_half_length=0.5), None, False),
    (PAD, PowerLaw(exponent=4.0, length=2.0, rise=0.1), None, False),
    (PAD, Compound(inner_radius=2.0, outer_radius=5.0, inner_half_length=0.5), None, False),
    (PAD, Tabulated(points=[(x / 4, x * x / 320) for x in range(13)]), None, False),
    (Block(width=8.0, height=5.0), Hertz(radius=20.0), None, True),
    (HalfPlane(), Hertz(radius=20.0), None, True),
]


@pytest.mark.parametrize(("shape", "profile", "arc", "flat"), FACES)
def test_faces(shape, profile, arc, flat):
    """Mirror-symmetric, at the origin at x = 0, never falling outwards; the profile itself where there is no arc."""
    face, x = face_of(shape, profile), np.linspace(0, 2.5, 41)
    depth = face.depth(x)
    assert (face.arc, face.flat) == (arc, flat)
    np.testing.assert_array_equal(face.depth(-x), depth)
    assert depth[0] == 0
    assert np.all(np.diff(depth) >= 0)
    if arc:
        start, radius = arc
        np.testing.assert_allclose(np.hypot(np.maximum(x - start, 0), radius - depth), radius, rtol=1e-15)
    else:
        np.testing.assert_array_equal(depth, 0 * x if flat else profile.height(x))
