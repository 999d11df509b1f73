"""Profiles given as a height h(x): the same load P(a) as of their slope h'(x), and a sentence where
no load can be had.
"""

import numpy as np
import pytest

from scenes import CallableProfile, InputError
from scenes.chebyshev import UnresolvedError
from semi_analytic import profiles, solve
from semi_analytic.profiles import law_of_function
from semi_analytic_cases import ellipse, make_scene

HALF_WIDTHS = np.array([1e-6, 1e-4, 0.01, 0.1, 0.3, 0.7, 1.0, 1.9, 2.5, 2.99])
EXTENT = 3.0


def power(n):
    return lambda x: np.abs(x) ** n, lambda x: n * np.sign(x) * np.abs(x) ** (n - 1)


def arc(radius):
    return lambda x: radius - np.sqrt(radius**2 - x * x), lambda x: x / np.sqrt(radius**2 - x * x)


# Height and slope.
SHAPES = {
    "parabola": (lambda x: x * x / 2, lambda x: x),
    "|x|^1.1": power(1.1),
    "|x|^1.5": power(1.5),
    "|x|^2.5": power(2.5),
    "x^4": power(4.0),  # refused as too rough before
    "x^2/2 + x^4/10": (lambda x: x**2 / 2 + x**4 / 10, lambda x: x + 0.4 * x**3),
    "cosh": (lambda x: np.cosh(x) - 1, np.sinh),
    "log cosh": (lambda x: np.log(np.cosh(x)), np.tanh),
    "hyperbola": (lambda x: np.sqrt(1 + x * x) - 1, lambda x: x / np.sqrt(1 + x * x)),
    "arc": arc(10.0),
    "blunt cosine": (lambda x: 2 - 2 * np.cos(x * x / 4), lambda x: x * np.sin(x * x / 4)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_height_carries_what_its_slope_does(name):
    """|x|^1.5 did not end, an arc and log cosh raised what is no InputError.

    Equal to 1e-14, or to what the digits of a difference of larger numbers allow: measured 9e-16 to
    9e-15, 2e-14 of the cosine.
    """
    height, slope = SHAPES[name]
    profile = CallableProfile(height_function=height, extent=EXTENT)
    of_height = law_of_function(1.0, profile)
    of_slope = law_of_function(1.0, CallableProfile(slope_function=slope, extent=EXTENT))
    stated = profile.relative_load_errors
    assert stated.load < 2e-13
    np.testing.assert_allclose(
        of_height.load(HALF_WIDTHS), of_slope.load(HALF_WIDTHS), rtol=max(1e-14, stated.load)
    )
    np.testing.assert_allclose(
        of_height.stiffness(HALF_WIDTHS),
        of_slope.stiffness(HALF_WIDTHS),
        rtol=of_height.relative_roundoff,
    )
    # 1.1e-11 to 2.3e-11, of log cosh 4.6e-11 where a library rounds log and cosh less well
    assert 1e-11 <= of_height.relative_roundoff < 1e-10


@pytest.mark.parametrize("radius", [10.0, 1e3, 1e5])
def test_what_the_digits_of_an_arc_do_not_hold_is_stated(radius):
    """R - sqrt(R^2 - x^2) is known to a last digit of R: of a load that is eps R/h and more, and
    fits of many values leave less.
    """
    profile = CallableProfile(height_function=arc(radius)[0], extent=EXTENT)
    slope = law_of_function(1.0, profile)
    exact = law_of_function(1.0, CallableProfile(slope_function=arc(radius)[1], extent=EXTENT))
    error = np.max(np.abs(slope.load(HALF_WIDTHS) / exact.load(HALF_WIDTHS) - 1))
    of_one_value = np.finfo(float).eps * radius / arc(radius)[0](EXTENT)
    assert error <= profile.relative_load_errors.load < max(of_one_value, 1e-13)
    assert slope.relative_roundoff >= profile.relative_load_errors.stiffness

    load = float(slope.load(np.array(1.0)))
    scene = make_scene(ellipse(load, load / 3, 0.0, load / 3)).vary(profile=profile)
    solution = solve(scene, x=[0.0, 0.5], fields=("pressure", "dissipation"))
    assert min(solution.record.errors.values()) >= profile.relative_load_errors.stiffness


def test_a_rough_function_is_refused_in_a_sentence(monkeypatch):
    def rough(function, edges, scale=None):
        raise UnresolvedError(0.5, 1.0)

    profile = CallableProfile(height_function=SHAPES["arc"][0], extent=3.0)
    monkeypatch.setattr(profiles, "piecewise_series_by_halving", rough)
    with pytest.raises(InputError, match="the function is too rough near x = 1"):
        law_of_function(1.0, profile)
    with pytest.raises(ValueError, match="too rough"):
        CallableProfile(
            height_function=lambda x: x * x / 2 + 1e-6 * np.abs(np.sin(1e6 * x)), extent=3.0
        )


def test_a_height_of_seven_digits_is_solved_and_says_so():
    profile = CallableProfile(
        height_function=lambda x: np.float32(1 + x * x / 2) - 1.0, extent=EXTENT
    )
    error = np.max(
        np.abs(law_of_function(1.0, profile).load(HALF_WIDTHS) / (np.pi / 4 * HALF_WIDTHS**2) - 1)
    )
    assert 1e-11 < error <= profile.relative_load_errors.load < 1e-7
