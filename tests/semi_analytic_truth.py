"""Normal contact in 30 digits by quadrature, from h' and dP/da alone, and slip of an arc: what tests of profiles compare with."""

import math
from itertools import pairwise

import mpmath as mp
import numpy as np

from scenes import Elastic, Materials, ellipse_segment
from semi_analytic import friction_work
from semi_analytic.fields import Arc
from semi_analytic.memory import Piece, instant
from semi_analytic.profiles import contact_of, power_law
from semi_analytic.punch_superposition import PunchSuperposition
from semi_analytic.quadrature import graded

STEP, RANGE = mp.mpf("0.2"), 225
with mp.workdps(40):
    _NEAR = [1 / (1 + mp.exp(STEP * k)) for k in range(RANGE + 1)]
    _WEIGHT = [STEP * near * (1 - near) for near in _NEAR]


def integrate(function, marks):
    """int function between consecutive marks: trapezoidal rule in s of 1/(1 + exp(-s)), whatever the scale, whatever the ends."""
    with mp.workdps(34):
        total = mp.mpf(0)
        for left, right in pairwise(marks):
            begin, end = mp.mpf(left), mp.mpf(right)
            if end > begin:
                part = _WEIGHT[0] * function((begin + end) / 2)
                for near, weight in zip(_NEAR[1:], _WEIGHT[1:], strict=True):
                    step = (end - begin) * near
                    part += weight * (function(begin + step) + function(end - step))
                total += part * (end - begin)
        return total


class Truth:
    """slope: h'(x); rate: dP/da for E* = 1; both in mpmath; breaks: where they have corners; least: a(0)."""

    def __init__(self, modulus, slope, rate, breaks=(), least=0.0):
        self.modulus, self.slope, self.rate = mp.mpf(modulus), slope, rate
        self.breaks, self.least = sorted(breaks), least

    def marks(self, begin, end):
        return [begin, *(b for b in self.breaks if begin < b < end), end]

    def load_of_slope(self, a):
        """E* int x h'/sqrt(a^2 - x^2) dx with x = a sin(angle)."""
        a = mp.mpf(a)
        marks = [mp.asin(min(mp.mpf(m) / a, 1)) for m in self.marks(0, float(a))[:-1]] + [mp.pi / 2]
        return float(self.modulus * integrate(lambda angle: a * mp.sin(angle) * self.slope(a * mp.sin(angle)), marks))

    def pressure(self, x, a, weight=None):
        """(1/pi) int dP/sqrt(alpha^2 - x^2) with alpha^2 = x^2 + w^2."""
        x = mp.mpf(x)
        first = max(float(x), self.least)
        with mp.workdps(34):
            marks = [mp.sqrt(mp.mpf(m) ** 2 - x * x) for m in self.marks(first, a)]

        def strip(w):
            alpha = mp.sqrt(x * x + w * w)
            factor = weight(float(alpha)) if weight else 1
            return factor * self.rate(alpha) / alpha / mp.pi if alpha else mp.mpf(0)

        return float(self.modulus * integrate(strip, marks))

    def total(self, kernel, begin, end, weight=None):
        """int kernel(alpha) dP."""

        def strip(alpha):
            factor = weight(float(alpha)) if weight else 1
            return factor * self.rate(alpha) * kernel(alpha) if alpha else mp.mpf(0)

        return float(self.modulus * integrate(strip, self.marks(begin, end)))

    def slip_integral(self, x, a, weight=None):
        x = mp.mpf(x)
        return self.total(lambda alpha: mp.acosh(x / alpha) if alpha < x else mp.mpf(0), self.least, min(a, float(x)), weight)

    def logarithm(self, a, datum, weight=None):
        return self.total(lambda alpha: mp.log(2 * mp.mpf(datum) / alpha), self.least, a, weight)

    def area(self, a, c):
        return self.total(lambda alpha: mp.log(alpha / mp.mpf(c)), c, a)


def worst(contact, truth, widths, relative_x=(0.0, 0.3, 0.9, 0.999, 1.3), moments=True):
    """The largest relative error of each method at half-widths `widths`."""
    found = {}

    def note(name, value, exact):
        error = abs(float(value) - exact) / abs(exact) if exact else abs(float(value))
        found[name] = max(found.get(name, 0.0), error)

    weight = lambda alpha: mp.mpf(float(contact.load(alpha)))  # noqa: E731
    for a in widths:
        load = float(contact.load(a))
        note("load", load, truth.load_of_slope(a))
        note("half_width", contact.half_width(load), a)
        for part in relative_x:
            x = part * a
            if part < 1:
                note("pressure", contact.pressure(x, load), truth.pressure(x, a))
                if moments:
                    note("pressure_moment", contact.pressure_moment(x, load), truth.pressure(x, a, weight))
            if x > truth.least:
                note("slip_integral", contact.slip_integral(x, load), truth.slip_integral(x, a))
                if moments:
                    note("slip_integral_moment", contact.slip_integral_moment(x, load), truth.slip_integral(x, a, weight))
        note("log_distance", contact.log_distance(load), truth.logarithm(a, contact.datum_length))
        if moments:
            note("log_moment", contact.log_moment(load), truth.logarithm(a, contact.datum_length, weight))
        for part in (0.999, 0.7, 0.1):
            c = truth.least + part * (a - truth.least)
            slipped = load - float(contact.load(c))
            if front := load - slipped:  # as P - P_c has it: for |x|^20 nothing is left of 1e-20 P
                note(
                    "dissipation_kernel", contact.dissipation_kernel(load, slipped), truth.area(a, float(contact.half_width(front)))
                )
    return found


def check_close_pairs(contact, widths, tolerance):
    """`reach` and `inverse_root` of loads that are close: against their definitions, as far as these have digits."""
    for a in widths:
        load = float(contact.load(a))
        for part in (0.5, 1e-2, 1e-4, 1e-6):
            excess = part * load
            outer = float(contact.half_width(load + excess))
            inner = float(contact.half_width(load - excess))
            digits = tolerance + 4e-16 / part
            reach = np.arccosh(outer / a) if part > 1e-3 else np.arcsinh(np.sqrt((outer - a) * (outer + a)) / a)
            np.testing.assert_allclose(contact.arccosh_ratio(outer, excess, contact.advance(load)), reach, rtol=100 * digits)
            quotient = np.sqrt(excess / ((a - inner) * (a + inner)))
            np.testing.assert_allclose(
                np.sqrt(excess) * contact.inverse_root(inner, excess, contact.advance(load)), quotient, rtol=100 * digits
            )


def profile_contact(profile, modulus=1.0):
    """The contact of a profile between bodies of that composite modulus."""
    material = Elastic(young_modulus=2 * modulus, poisson_ratio=0.0)
    return contact_of(profile, Materials(upper=material, lower=material))


def check_errors_are_honest(contact, truth, widths, limit, relative_x=(0.3, 0.999, 1.3)):
    """Estimated errors: not below the true ones, and not above `limit` of the value."""
    for a in widths:
        load = float(contact.load(a))
        front = float(contact.load(truth.least + 0.6 * (a - truth.least)))
        cases = [("log_distance", (load,), truth.logarithm(a, contact.datum_length))]
        cases.append(("dissipation_kernel", (load, load - front), truth.area(a, float(contact.half_width(front)))))
        for x in (part * a for part in relative_x):
            if x < a:
                cases.append(("pressure", (x, load), truth.pressure(x, a)))
            elif x > truth.least:
                cases.append(("slip_integral", (x, load), truth.slip_integral(x, a)))
        for name, arguments, exact in cases:
            value = float(getattr(contact, name)(*arguments))
            estimate = float(contact.quadrature_error(name, *arguments))
            assert abs(value - exact) <= estimate, (name, a, arguments)
            assert estimate <= limit * abs(exact) * (1 + abs(np.log(a))), (name, a, arguments)


def slip_of_an_arc(n, place):
    """int dQ arccosh(x/a) over one arc on |x|^n, x being `place` half-widths out: found, and at thirty digits."""
    contact = PunchSuperposition(power_law(1.0, n, 1.0, 1.0), 3.0)
    whole = float(contact.load(1.0))
    leg, first, last = ellipse_segment(0.0, 10.0, (1.0, 0.0), (0.3, 0.3), 1.0), math.pi + 1.5, math.pi + 2.3
    x = place * contact.half_width(leg.loads(np.array([last]))[0])
    with mp.workdps(30):

        def moved(t):
            half = ((1 + mp.mpf(0.3) * mp.cos(t)) / whole) ** (1 / mp.mpf(n))
            return -mp.mpf(0.3) * mp.sin(t - 1) * mp.acosh(mp.mpf(x.item()) / half)

        exact = float(mp.quad(moved, [first, last]))
    end = instant(leg, last)
    below = Piece(None, instant(leg, first).normal, instant(leg, first), 0.0)
    piece = Piece(below, end.normal, end, 0.0, 0.0, (first, last))
    return Arc(contact, "slip", piece, np.atleast_1d(x)).up_to(np.array([last])).item(), exact


def work_over_points(contact, modulus, spans, work):
    """Integral of W(x) over the whole contact, about `work`: another way to W.

    W(x) is smooth between the edges of contact and of stick where a span begins, passes a corner of the profile or ends; where
    fronts run by no formula it may be steep anywhere.
    """
    marks = [np.array(contact.breaks, dtype=float)]
    for span in spans:
        times = np.array([span.begin.time, *friction_work.corner_times(contact, span), span.end.time])
        load = span.leg.loads(times)[0]
        marks += [contact.half_width(load), contact.half_width(np.maximum(load - span.slipped(times), 0.0))]
    every = np.unique(np.concatenate(marks))
    every = every[every <= max(float(np.max(half)) for half in marks[1:])]
    every = every[np.diff(every, prepend=-np.inf) > 1e-12 * every[-1]]

    def rule(_, low, high):
        x, weight = graded(low, high)
        density = friction_work.pointwise_dissipation(contact, modulus, spans, x.ravel()).total
        return 2 * np.sum(weight * density.reshape(x.shape), axis=-1)

    if not any(friction_work.uneven(contact, span) for span in spans):
        return float(np.sum(rule(None, every[:-1], every[1:])))
    return float(np.sum(friction_work.by_halving(rule, every[:-1], every[1:], friction_work.CONVERGED * work).value))
