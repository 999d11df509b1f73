"""Fields of any instant by brute force, in extended precision: integrals over the pile of punches, from h'' and M(eta).

# notation: alpha half-width of a punch in the pile, g = dP/d alpha, M' slope of the memory curve, A = 2/E*

p = (1/pi) int g/sqrt(alpha^2 - x^2), q the same with M', s = (A/pi) int M' g arccosh(|x|/alpha), U = (A/pi) int M' g ln(2 L/alpha):
each by one rule for singular ends between all knots and corners. The knots of the curve are the engine's own, the rest is not.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import mpmath as mp
import numpy as np

from scenes import CallableProfile, PowerLaw
from semi_analytic.history import history_of
from semi_analytic.memory import pieces
from semi_analytic.profiles import contact_of

LONG = np.longdouble
PI = LONG("3.14159265358979323846264338327950288")


def _rule(step):
    s = LONG(step) * np.arange(-round(46 / step), round(46 / step) + 1)
    near = 1 / (1 + np.exp(np.abs(s)))
    return s < 0, near, LONG(step) * near * (1 - near)


_RULES = {step: _rule(step) for step in (0.1, 0.2)}


def integrate(function, marks, step=0.2):
    """int function between consecutive marks: trapezoidal rule in s of 1/(1 + exp(-s))."""
    lower, near, weight = _RULES[step]
    total = LONG(0)
    for begin, end in pairwise(marks):
        if end > begin:
            length = end - begin
            total += length * np.sum(weight * function(np.where(lower, begin + length * near, end - length * near)))
    return total


def _flat(half, b):
    """P of a flat of half-length b whose edges have h'' = 1: (alpha^2 arccos(b/alpha) - b sqrt(alpha^2 - b^2))/2."""
    if b == 0:
        return PI / 4 * half * half
    tau = np.sqrt(np.maximum((half - b) * (half + b), 0)) / b
    whole = (1 + tau * tau) * np.arctan(tau) - tau
    if np.all(tau >= 0.1):
        return b * b / 2 * whole
    small = np.minimum(tau, LONG(0.1))
    series = 0 * small
    for k in range(11, 0, -1):
        series = small * small * (2 / LONG(4 * k * k - 1) - series)
    series = series * small
    return b * b / 2 * np.where(tau < 0.1, series, whole)


def _flat_rate(half, b):
    return half * np.arctan2(np.sqrt(np.maximum((half - b) * (half + b), 0)), b)


@dataclass(frozen=True)
class Bends:
    """h'' that jumps by `jumps` at `knots`: Hertz, flat and rounded, compound, wedge, tables. E* = 1."""

    knots: tuple
    jumps: tuple

    @property
    def breaks(self):
        return self.knots

    def load(self, half):
        return sum(jump * _flat(half, b) for b, jump in zip(self.knots, self.jumps, strict=True))

    def rate(self, half):
        return sum(jump * _flat_rate(half, b) for b, jump in zip(self.knots, self.jumps, strict=True))


@cache
def _sine_power(n):
    """int_0^(pi/2) sin^n."""
    with mp.workdps(40):
        value = mp.sqrt(mp.pi) / 2 * mp.gamma((mp.mpf(n) + 1) / 2) / mp.gamma(mp.mpf(n) / 2 + 1)
        return LONG(mp.nstr(value, 25))


@dataclass(frozen=True)
class Powers:
    """h = sum c |x|^n by (n, c). E* = 1."""

    terms: tuple
    breaks = (LONG(0),)

    def _sum(self, half, order):
        total = LONG(0) * half
        for n, c in self.terms:
            total = total + _sine_power(n) * n * c * n**order * half ** LONG(n - order)
        return total

    def load(self, half):
        return self._sum(half, 0)

    def rate(self, half):
        return self._sum(half, 1)


@dataclass(frozen=True)
class Bessel:
    """h' = part sinh x: P = (pi/2) part a I_1(a). E* = 1."""

    part: float
    breaks = (LONG(0),)

    def _series(self, half, order):
        term = LONG(1) + 0 * half
        total = term
        for k in range(1, 30):
            term = term * (half / 2) ** 2 / (k * (k + order))
            total = total + term
        return total

    def load(self, half):
        return PI / 4 * self.part * half**2 * self._series(half, 1)

    def rate(self, half):
        return PI / 2 * self.part * half * self._series(half, 0)


def law_of(profile):
    """The same pile of punches from the numbers of the scene alone."""
    kind = profile.kind if not isinstance(profile, CallableProfile) else "callable"
    match kind:
        case "hertz":
            return Bends((LONG(0),), (1 / LONG(profile.radius),))
        case "flat_rounded":
            return Bends((LONG(profile.flat_half_length),), (1 / LONG(profile.radius),))
        case "compound":
            one, two = 1 / LONG(profile.inner_radius), 1 / LONG(profile.outer_radius)
            return Bends((LONG(0), LONG(profile.inner_half_length)), (one, two - one))
        case "wedge":
            return Bends((LONG(0), LONG(profile.tip_half_length)), (1 / LONG(profile.tip_radius), -1 / LONG(profile.tip_radius)))
        case "power_law":
            assert isinstance(profile, PowerLaw)
            n = float(profile.exponent)
            return Powers(((n, LONG(profile.rise) / LONG(profile.length) ** LONG(n)),))
        case "polynomial":
            length = LONG(profile.length)
            return Powers(tuple((2.0 * k, LONG(c) / length ** (2 * k)) for k, c in enumerate(profile.rises, 1)))
        case "tabulated":
            spline = profile.spline()
            bends = np.concatenate([[0.0], spline.curvature]).astype(LONG)
            jumps = np.diff(bends)
            first = int(np.flatnonzero(jumps)[0])
            return Bends(tuple(LONG(v) for v in spline.x[first:-1]), tuple(jumps[first:]))
    return Bessel(LONG(float(profile.slope_function(np.array(1.0)))) / np.sinh(LONG(1)))


def half_width(law, load, guess):
    """a(P) by Newton's method from a guess."""
    half = LONG(guess)
    if not load > 0:
        return law.breaks[0]
    for _ in range(60):
        step = (LONG(load) - law.load(half)) / law.rate(half)
        half = max(half + step, (half + law.breaks[0]) / 2)
        if abs(step) <= 1e-17 * half:
            break
    return half


def _slope_on(piece):
    """M' as a function of eta on a piece of the engine's curve."""
    leg, anchor = piece.anchor.leg, LONG(piece.anchor.normal)
    if piece.arc is None:
        return lambda eta: LONG(piece.slope) + 2 * LONG(piece.bend) * (eta - anchor)
    if leg.ellipse:
        p0, p1, q1 = (LONG(v) for v in (leg.mean[0], *leg.ellipse.amplitude))
        sine, cosine = np.sin(LONG(leg.ellipse.phase)), np.cos(LONG(leg.ellipse.phase))

        def slope(eta):
            up, down = (eta - (p0 - p1)) / (2 * p1), ((p0 + p1) - eta) / (2 * p1)
            return q1 / p1 * (cosine + sine * (up - down) / (2 * np.sqrt(up * down)))

        return slope
    return lambda eta: _slope_by_root(leg, eta, *piece.arc[:1], piece.anchor.time)


def _wave(waves, t, derivative=False):
    total = 0 * t
    for k, (size, phase) in enumerate(waves, 1):
        angle = k * t - LONG(phase)
        total = total + LONG(size) * (-k * np.sin(angle) if derivative else np.cos(angle))
    return total


def _load_at(leg, t):
    """P of harmonics."""
    return LONG(leg.mean[0]) + _wave(leg.normal, t)


def _slope_by_root(leg, eta, first, last):
    """Q'/P' of harmonics at the time in [first, last] at which P = eta: half brackets, then Newton's method inside them."""
    low, high = np.full(np.shape(eta), LONG(first)), np.full(np.shape(eta), LONG(last))
    t = (low + high) / 2
    for _ in range(90):
        fault = _load_at(leg, t) - eta
        low, high = np.where(fault < 0, t, low), np.where(fault > 0, t, high)
        newton = t - fault / _wave(leg.normal, t, True)
        new = np.where((newton > low) & (newton < high), newton, (low + high) / 2)
        if np.all(np.abs(new - t) <= 1e-19 * np.abs(t)):
            break
        t = new
    return _wave(leg.tangential, t, True) / _wave(leg.normal, t, True)


class Oracle:
    """Every field of one scene; `at` gives those of one of `times` at points x."""

    def __init__(self, scene, times, step=0.2):
        history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles, np.array(times, dtype=float))
        self.snapshot, self.step = history.snapshot(np.array(times, dtype=float)), step
        self.law, self.contact = law_of(scene.profile), contact_of(scene.profile, scene.material)
        self.datum = LONG(scene.profile.datum_length)
        self.known = {}

    def half(self, load):
        if load not in self.known:
            self.known[load] = half_width(self.law, load, float(self.contact.half_width(load)))
        return self.known[load]

    def segments(self, k):
        """(lower, upper half-width, M'(eta)) of the curve of instant k."""
        s = self.snapshot
        front = float(s.load[k] - s.slipped[k])
        found = []
        if s.slipped[k]:
            line = LONG(float(s.direction[k]) * s.friction)
            found.append((self.half(front), self.half(float(s.load[k])), lambda eta: line + 0 * eta))
        upper = front
        for piece in pieces(s.actives[s.which[k]]):
            # What an arc starts from is its time: P0 + P1 cos t may have few digits of a small P.
            bottom = piece.bottom if piece.arc is None else _load_at(piece.anchor.leg, LONG(piece.arc[0]))
            found.append((self.half(bottom), self.half(upper), _slope_on(piece)))
            upper = piece.bottom
        return found

    def _marks(self, low, high):
        return [low, *(b for b in self.law.breaks if low < b < high), high]

    def _traction(self, x, low, high, weight):
        low = max(low, x)
        if not high > low:
            return LONG(0)
        marks = [np.sqrt((m - x) * (m + x)) for m in self._marks(low, high)]

        def strip(w):
            half = np.sqrt(x * x + w * w)
            return weight(half) * self.law.rate(half) / half / PI

        return integrate(strip, marks, self.step)

    def _total(self, kernel, low, high, weight):
        if not high > low:
            return LONG(0)
        return integrate(lambda half: weight(half) * self.law.rate(half) * kernel(half), self._marks(low, high), self.step)

    def at(self, k, x):
        """pressure, shear and slip at |x| (m,), and shift, approach, contact and stick half-width, of instant k."""
        half, least = self.half(float(self.snapshot.load[k])), self.law.breaks[0]
        one = lambda alpha: 1 + 0 * alpha  # noqa: E731
        parts = [(low, high, lambda alpha, slope=slope: slope(self.law.load(alpha))) for low, high, slope in self.segments(k)]
        points = np.abs(np.asarray(x, dtype=float)).astype(LONG)
        log = lambda alpha: np.log(2 * self.datum / alpha)  # noqa: E731
        reach = lambda at: lambda alpha: np.arcsinh(np.sqrt((at - alpha) * (at + alpha)) / alpha)  # noqa: E731
        front = self.half(float(self.snapshot.load[k] - self.snapshot.slipped[k]))
        return {
            "pressure": np.array([self._traction(at, least, half, one) for at in points]),
            "shear": np.array([sum(self._traction(at, *part) for part in parts) for at in points]),
            "slip": 2 / PI * np.array([sum(self._total(reach(at), a, min(b, at), m) for a, b, m in parts) for at in points]),
            "tangential_displacement": 2 / PI * sum(self._total(log, *part) for part in parts),
            "normal_approach": 2 / PI * self._total(log, least, half, one),
            "contact_half_width": half,
            "stick_half_width": front,
        }
