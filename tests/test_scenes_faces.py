"""Faces as they are made: arcs to full relative precision, flats with arcs, profiles themselves."""

import mpmath
import numpy as np
import pytest

from scenes import Block, Compound, Cylinder, FlatRounded, HalfPlane, Hertz, Pad, PowerLaw, Tabulated, Wedge
from scenes.bodies import arc_depth, face_of

PAD = Pad(width=6.0, height=4.0)


@pytest.mark.parametrize("radius", [1e-3, 5.0, 1e6])
@pytest.mark.parametrize("share", [1e-9, 1e-4, 0.3, 0.99, 1 - 1e-9, 1.0])
def test_depth_of_an_arc_to_the_last_digit(radius, share):
    """R - sqrt(R^2 - s^2) loses all digits at s = 1e-9 R; mpmath has them."""
    s = share * radius
    with mpmath.workdps(50):
        exact = float(mpmath.mpf(radius) - mpmath.sqrt(mpmath.mpf(radius) ** 2 - mpmath.mpf(s) ** 2))
    # At the very end the depth grows like a root: half of the digits of s are lost in any formula's argument, none in this one's.
    assert float(arc_depth(np.array(s), radius)) == pytest.approx(exact, rel=1e-14)


def test_an_arc_is_deeper_than_its_parabola_by_the_fourth_power():
    x = np.array([0.01, 0.02, 0.04])
    beyond = arc_depth(x, 1.0) - x**2 / 2
    np.testing.assert_allclose(beyond, x**4 / 8, rtol=2e-3)
    np.testing.assert_allclose(np.diff(np.log2(beyond)), 4.0, atol=3e-3)


def test_a_flat_with_arcs():
    x = np.array([-2.0, -0.5, 0.0, 0.3, 0.5, 2.0])
    np.testing.assert_allclose(
        arc_depth(x, 4.0, 0.5), [*(arc_depth(np.array([1.5]), 4.0)), 0, 0, 0, 0, *arc_depth(np.array([1.5]), 4.0)]
    )


def test_past_the_end_by_rounding_is_the_end():
    end = 1.0 + 4e-16
    assert float(arc_depth(np.array(end), 1.0)) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize(
    ("shape", "profile", "arc", "flat"),
    [
        (Cylinder(radius=5.0), Hertz(radius=20.0), (0.0, 5.0), False),
        (PAD, Hertz(radius=20.0), (0.0, 20.0), False),
        (PAD, FlatRounded(radius=4.0, flat_half_length=0.5), (0.5, 4.0), False),
        (PAD, Wedge(tip_radius=5.0, tip_half_length=0.5), None, False),
        (PAD, PowerLaw(exponent=4.0, length=2.0, rise=0.1), None, False),
        (PAD, Compound(inner_radius=2.0, outer_radius=5.0, inner_half_length=0.5), None, False),
        (PAD, Tabulated(points=[(x / 4, x * x / 320) for x in range(13)]), None, False),
        (Block(width=8.0, height=5.0), Hertz(radius=20.0), None, True),
        (HalfPlane(), Hertz(radius=20.0), None, True),
    ],
)
def test_faces(shape, profile, arc, flat):
    """Mirror-symmetric, at the origin at x = 0, never falling outwards; the profile itself where there is no arc."""
    face, x = face_of(shape, profile), np.linspace(0, 2.5, 41)
    depth = face.depth(x)
    assert (face.arc, face.flat) == (arc, flat)
    np.testing.assert_array_equal(face.depth(-x), depth)
    assert depth[0] == 0
    assert np.all(np.diff(depth) >= 0)
    if flat:
        assert not depth.any()
    elif arc is None:
        np.testing.assert_array_equal(depth, profile.height(x))
    else:
        start, radius = arc
        on_circle = np.hypot(np.maximum(x - start, 0), radius - depth)
        np.testing.assert_allclose(on_circle, radius, rtol=1e-15)
