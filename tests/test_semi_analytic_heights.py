"""Profiles given as a height h(x): the same load P(a) as of their slope h'(x), and a sentence where no load can be had."""

import numpy as np
import pytest

from scenes import CallableProfile, InputError
from scenes.chebyshev import Unresolved, halved
from semi_analytic import profiles
from semi_analytic.profiles import slope_function

RADIUS = 10.0
HALF_WIDTHS = np.array([1e-6, 1e-4, 0.01, 0.1, 0.3, 0.7, 1.0, 1.9, 2.5, 2.99])
# Height, slope, and what the digits of the height allow: those of an arc are lost in the difference of two radii.
SHAPES = {
    "parabola": (lambda x: x * x / 2, lambda x: x, 1e-14),
    "cosh": (lambda x: np.cosh(x) - 1, np.sinh, 5e-14),
    "|x|^1.3": (lambda x: np.abs(x) ** 1.3, lambda x: 1.3 * np.sign(x) * np.abs(x) ** 0.3, 1e-13),
    "|x|^1.5": (lambda x: np.abs(x) ** 1.5, lambda x: 1.5 * np.sign(x) * np.abs(x) ** 0.5, 1e-13),
    "|x|^2.5": (lambda x: np.abs(x) ** 2.5, lambda x: 2.5 * np.sign(x) * np.abs(x) ** 1.5, 1e-13),
    "arc": (lambda x: RADIUS - np.sqrt(RADIUS**2 - x * x), lambda x: x / np.sqrt(RADIUS**2 - x * x), 1e-12),
    "log cosh": (lambda x: np.log(np.cosh(x)), np.tanh, 5e-13),
    "hyperbola": (lambda x: np.sqrt(1 + x * x) - 1, lambda x: x / np.sqrt(1 + x * x), 5e-13),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_height_carries_what_its_slope_does(name):
    """|x|^1.5 did not end, an arc and log cosh raised what is no InputError."""
    height, slope, digits = SHAPES[name]
    of_height = slope_function(1.0, CallableProfile(height_function=height, extent=3.0))
    of_slope = slope_function(1.0, CallableProfile(slope_function=slope, extent=3.0))
    np.testing.assert_allclose(of_height.load(HALF_WIDTHS), of_slope.load(HALF_WIDTHS), rtol=digits)
    np.testing.assert_allclose(of_height.stiffness(HALF_WIDTHS), of_slope.stiffness(HALF_WIDTHS), rtol=of_height.noise)


def test_few_pieces_are_needed(monkeypatch):
    """Each octave of a height has a noise floor: without one they were halved hundreds of times."""
    pieces = []

    def counted(function, edges, scale=None):
        found = halved(function, edges, scale)
        pieces.append(len(found.edges) / len(edges))
        return found

    monkeypatch.setattr(profiles, "halved", counted)
    slope_function(1.0, CallableProfile(height_function=SHAPES["|x|^1.5"][0], extent=3.0))
    assert max(pieces) < 2


def test_a_rough_function_is_refused_in_a_sentence(monkeypatch):
    def rough(function, edges, scale=None):
        raise Unresolved(0.5, 1.0)

    profile = CallableProfile(height_function=SHAPES["arc"][0], extent=3.0)
    monkeypatch.setattr(profiles, "halved", rough)
    with pytest.raises(InputError, match="the function is too rough near x = 1"):
        slope_function(1.0, profile)
    with pytest.raises(ValueError, match="too rough"):
        CallableProfile(height_function=lambda x: x * x / 2 + 1e-6 * np.abs(np.sin(1e6 * x)), extent=3.0)


def test_halving_ends_at_noise():
    """No piece gets shorter than 1e-14 of the first ones; that of pure noise is refused before."""
    rng = np.random.default_rng(1)
    with pytest.raises(Unresolved):
        halved(lambda x: rng.normal(size=x.shape), np.array([0.0, 1.0]))
