"""The stated error of the friction work of steady ellipses covers the true one, against seventy
digits, and is not far above it.
"""

import functools
from functools import cache
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest

from scenes import Compound, FlatRounded, PowerLaw, Wedge
from semi_analytic import solve
from semi_analytic.punch_superposition import PunchSuperposition
from semi_analytic_cases import ellipse, make_scene

# Lam at a slip of 1e-18 P is 1e-36 P^2, a difference of larger numbers.
DIGITS = 70
# The rounding of what is compared, and how far above the larger of it and the true error a stated
# one may be.
ROUNDING = 1e-13
ABOVE = 1e4


class Arcs:
    """P(a) for E* = 1 and h'' = `inner` up to x = b, `outer` beyond, and int_b^a P/alpha d
    alpha.
    """

    def __init__(self, inner, outer, b):
        self.inner = mp.mpf(inner)
        self.outer = mp.mpf(outer)
        self.b = mp.mpf(b)
        self.corner = self.load(self.b)

    def _root_and_angle(self, a):
        return mp.sqrt(a * a - self.b**2), mp.acos(self.b / a)

    def load(self, a):
        if a <= self.b:
            return mp.pi * self.inner * a * a / 4
        root, angle = self._root_and_angle(a)
        behind = a * a * angle - self.b * root
        return self.inner / 2 * (mp.pi / 2 * a * a - behind) + self.outer / 2 * behind

    def rate(self, a):
        angle = self._root_and_angle(a)[1] if a > self.b else 0
        return a * (self.inner * (mp.pi / 2 - angle) + self.outer * angle)

    def logarithm(self, a):
        if a <= self.b:
            return mp.pi * self.inner * (a * a - self.b**2) / 8
        root, angle = self._root_and_angle(a)
        behind = a * a * angle / 2 - self.b * root / 2 - self.b * (root - self.b * angle)
        return self.inner / 2 * (mp.pi / 4 * (a * a - self.b**2) - behind) + self.outer / 2 * behind

    def half_width(self, load):
        if self.inner and load <= self.corner:
            return mp.sqrt(4 * load / (mp.pi * self.inner))
        low = self.b
        high = 2 * self.b
        while self.load(high) < load:
            high *= 2
        for _ in range(12):
            middle = (low + high) / 2
            low, high = (middle, high) if self.load(middle) < load else (low, middle)
        a = high  # where P(a) bends up Newton's method comes down to the root
        for _ in range(100):
            step = (self.load(a) - load) / self.rate(a)
            a = max(a - step, (a + self.b) / 2)
            if abs(step) < mp.mpf(10) ** (8 - DIGITS) * a:
                break
        return a

    def area(self, load, slipped):
        a = self.half_width(load)
        c = self.half_width(load - slipped)
        return load * mp.log(a / c) - (self.logarithm(a) - self.logarithm(c))


class Power:
    """The same of |x|^n: Lam = [P ln(P/P_c) - P + P_c]/n."""

    corner = None

    def __init__(self, exponent):
        self.exponent = mp.mpf(exponent)

    def area(self, load, slipped):
        return (load * mp.log(load / (load - slipped)) - slipped) / self.exponent


def law_of(profile):
    match profile:
        case Wedge():
            return Arcs(1 / mp.mpf(profile.tip_radius), 0, profile.tip_half_length)
        case Compound():
            return Arcs(
                1 / mp.mpf(profile.inner_radius),
                1 / mp.mpf(profile.outer_radius),
                profile.inner_half_length,
            )
        case FlatRounded():
            return Arcs(0, 1 / mp.mpf(profile.radius), profile.flat_half_length)
    return Power(profile.exponent)


def crossings(function, length):
    """Where a function of s, 0 < s < `length`, changes its sign."""
    places = [length * k / 100 for k in range(101)]
    signs = [mp.sign(function(place)) for place in places]
    for (begin, before), (end, after) in pairwise(zip(places, signs, strict=True)):
        if before * after < 0:
            low = begin
            high = end
            while high - low > mp.mpf(10) ** -40 * length:
                middle = (low + high) / 2
                low, high = (middle, high) if mp.sign(function(middle)) == before else (low, middle)
            yield low


@cache
def double_exponential(level):
    """Ways from the lower end (t < 0) or the upper one over the length, and weights, of a rule for
    singular ends.
    """
    rule = []
    step = mp.mpf(2) ** (1 - level)
    with mp.workdps(30):
        for k in range(-int(4.2 / step), int(4.2 / step) + 1):
            t = k * step
            weight = step * mp.pi / 4 * mp.cosh(t) / mp.cosh(mp.pi / 2 * mp.sinh(t)) ** 2
            if weight > 1e-22:
                rule.append((k < 0, 1 / (1 + mp.exp(mp.pi * abs(mp.sinh(t)))), weight))
    return rule


@functools.cache
def exact_work(profile, friction, mean, amplitude, tangential, phase):
    """W of the steady ellipse for E* = 1, by the three phases of slip of `steady_ellipse`."""
    with mp.workdps(DIGITS):
        law = law_of(profile)
        angle = mp.radians(mp.mpf(phase))
        p0 = mp.mpf(mean)
        p1 = mp.mpf(amplitude)
        r = mp.mpf(tangential) / mp.mpf(friction)
        least = r * mp.expj(-angle) - p1
        u = abs(least)
        v = abs(r * mp.expj(-angle) + p1)
        turn = mp.atan2(2 * r * p1 * mp.sin(angle), p1**2 - r**2)
        start = -mp.arg(least / u)
        start = abs(start)
        phases = (  # rate over f, P - P_c and P at an angle s
            (
                turn,
                lambda s: (
                    v * mp.sin(turn - s),
                    u * mp.sin(s / 2) ** 2,
                    p0 + p1 * mp.cos(start + s),
                ),
            ),
            (
                mp.pi - turn,
                lambda s: (
                    u * mp.sin(s),
                    2 * p1 * mp.sin(start) * mp.sin(s),
                    p0 + p1 * mp.cos(start + mp.pi + s),
                ),
            ),
            (
                turn,
                lambda s: (
                    u * mp.sin(s),
                    v * mp.sin((turn + s) / 2) ** 2,
                    p0 + p1 * mp.cos(start - s),
                ),
            ),
        )
        pieces = []
        for length, at in phases:

            def work(s, at=at):
                rate, slipped, load = at(s)
                return rate * law.area(load, slipped) if slipped > 0 else mp.mpf(0)

            cuts = [mp.mpf(0), length]
            if law.corner:
                cuts += crossings(lambda s, at=at: at(s)[2] - law.corner, length)
                cuts += crossings(lambda s, at=at: at(s)[2] - at(s)[1] - law.corner, length)
            cuts.sort()
            pieces += [(work, low, high) for low, high in pairwise(cuts) if high > low]
        before = mp.mpf(0)
        for level in range(3, 8):
            total = mp.mpf(0)
            for work, low, high in pieces:
                for from_low, way, weight in double_exponential(level):
                    s = low + (high - low) * way if from_low else high - (high - low) * way
                    total += (high - low) * weight * work(s)
            if abs(total - before) < 1e-12 * total:
                break
            before = total
        return 2 * mp.mpf(friction) ** 2 / mp.pi * total


def random_loop(chance):
    """A profile, f, P0, P1, Q1 and the phase in degrees of a loop without gross sliding that slips
    somewhere.
    """
    b = 10 ** chance.uniform(-1, 0.5)
    profiles = (
        Wedge(tip_radius=1.0, tip_half_length=b),
        Compound(inner_radius=1.0, outer_radius=10 ** chance.uniform(-1, 1), inner_half_length=b),
        FlatRounded(radius=1.0, flat_half_length=b),
        PowerLaw(exponent=chance.uniform(1.2, 6), length=1.0, rise=0.5),
    )
    profile = profiles[chance.integers(len(profiles))]
    friction = chance.uniform(0.1, 1)
    mean = 10 ** chance.uniform(-1, 1)
    nearly_unloads = chance.random() < 0.3
    share = (
        1 - 10 ** chance.uniform(-7, -0.01) if nearly_unloads else 10 ** chance.uniform(-4, -0.05)
    )
    while True:
        phase = float(chance.choice([30.0, 60.0, 90.0, 120.0, chance.uniform(1, 179)]))
        ratio = mean * 10 ** chance.uniform(-11, -0.02)
        turned = ratio * np.exp(-1j * np.radians(phase))
        largest = max(abs(turned - share * mean), abs(turned + share * mean))
        if largest < mean * (1 - 1e-9):
            return profile, friction, mean, share * mean, friction * ratio, phase


TIP = Wedge(tip_radius=1.0, tip_half_length=1.0)
BLUNT = PowerLaw(exponent=2.5, length=1.0, rise=0.5)
LOOPS = {
    "next to no slip, nearly unloads": (BLUNT, 0.5, 3.0, 3 * (1 - 1e-7), 1.5e-11, 90.0),
    "onset of slip": (BLUNT, 0.7, 3.0, 1.0, 0.7 * (1 + 1e-5), 0.0),
    "a corner within": (TIP, 0.5, 1.0, 0.5, 0.2, 60.0),
}
SLOWER = {
    "opposite phase": (TIP, 0.5, 1.0, 0.4, 0.05, 179.0),
    "a wedge, next to no slip, nearly unloads": (TIP, 0.5, 3.0, 3 * (1 - 1e-7), 1.5e-11, 90.0),
    "next to no slip": (
        Compound(inner_radius=1.0, outer_radius=0.3, inner_half_length=0.5),
        0.5,
        1.0,
        0.3,
        1e-11,
        90.0,
    ),
    "next to no slip, P hardly moves": (
        FlatRounded(radius=1.0, flat_half_length=0.5),
        0.3,
        1.0,
        1e-4,
        1e-10,
        70.0,
    ),
    "near gross sliding": (TIP, 0.5, 1.0, 0.0, 0.5 * (1 - 1e-5), 90.0),
}


def judged(loop):
    """True and stated relative error of W."""
    profile, friction, mean, amplitude, tangential, phase = loop
    scene = make_scene(ellipse(mean, amplitude, 0.0, tangential, phase), friction).vary(
        profile=profile
    )
    answer = solve(scene, x=[0.0], fields=("dissipation",), cycles="steady")
    error = float(abs(answer.dissipation / exact_work(*loop) - 1))
    return error, answer.record.errors.get("dissipation", 0.0)


@pytest.mark.parametrize(
    "name",
    [*LOOPS, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOWER)],
)
def test_the_stated_error_of_the_work_covers_and_is_of_its_size(name):
    """Of 300 random loops 53 stated more than 1 %, up to 6e3 times W, for true errors of 1e-13."""
    error, stated = judged((LOOPS | SLOWER)[name])
    assert error <= max(stated, ROUNDING)
    assert stated <= ABOVE * max(error, ROUNDING)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_so_it_is_of_random_loops(seed):
    """Eight a seed. Measured of 60: true errors up to 7e-14, stated ones of 3e-14 to 2e-13."""
    chance = np.random.default_rng(100 + seed)
    for _ in range(8):
        loop = random_loop(chance)
        error, stated = judged(loop)
        assert error <= max(stated, ROUNDING), loop
        assert stated <= ABOVE * max(error, ROUNDING), loop


def test_the_error_of_the_first_cycle_is_none_of_the_last():
    """With cycles="all" W of the last cycle stated 2e-4, which the first cycle alone has."""
    _, friction, mean, amplitude, tangential, phase = LOOPS["next to no slip, nearly unloads"]
    scene = make_scene(ellipse(mean, amplitude, 0.0, tangential, phase), friction)
    answer = solve(scene, x=[0.0], fields=("dissipation",))
    errors = answer.record.errors
    steady = solve(scene, x=[0.0], fields=("dissipation",), cycles="steady")
    assert errors.get("dissipation", 0.0) <= ABOVE * ROUNDING
    assert answer.dissipation == pytest.approx(steady.dissipation, rel=ROUNDING)
    assert 1e-6 < errors["cycle_dissipation"] < 1e-2


def test_what_the_kernel_loses_is_stated(monkeypatch):
    """Of the slip area by a rule of two nodes, not twelve: the two routes to W differ, and that
    counts.
    """
    monkeypatch.setattr("semi_analytic.punch_superposition._NODES_BETWEEN_CORNERS", 2)
    monkeypatch.setattr(
        PunchSuperposition,
        "_takes_difference_of_integrals",
        lambda self, load, load_above_stick: np.zeros(load.shape, dtype=bool),
    )
    error, stated = judged(LOOPS["a corner within"])
    assert 1e-9 < error <= stated < 1.0
