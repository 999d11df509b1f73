"""Friction work W(x) and W of one cycle by brute force, in extended precision, with fronts straight from the path.

# notation: P_c front of slip, c = a(P_c); P_x load at which a = |x|; low = +-Q - f P, which grows in slip; A = 2/E*

    W(x) = (f A/pi) int p(x, P) low' arccosh(|x|/c) dt,    W = (f A/pi) int low' int_{P_c}^P ln(a(eta)/c) d eta dt

over all times of slip; p and the inner integral by quadrature over the pile, between all corners. E* = 1.
"""

from itertools import pairwise

import numpy as np

from semi_analytic.profiles import contact_of
from semi_analytic_fronts import LONG, phases_of, root, slips_of
from semi_analytic_oracle import PI, Bends, law_of


def _rule(step):
    s = LONG(step) * np.arange(-round(42 / step), round(42 / step) + 1)
    near = 1 / (1 + np.exp(np.abs(s)))
    return s < 0, near, LONG(step) * near * (1 - near)


def _bent_pressure(law, x, half):
    """p(x, P) at half-widths (n,) >= x: int_max(b, x)^a arccos(b/alpha) alpha d alpha/sqrt(alpha^2 - x^2) for a jump of h'' at b,

    that is sqrt(a^2 - x^2) arccos(b/a) - b ln[(B + X)/D] + x ln[(b X + x B)/(a D)] with B^2 = a^2 - b^2, X^2 = a^2 - x^2 and
    D^2 = |b^2 - x^2|.
    """
    total, edge = 0 * half, np.sqrt((half - x) * (half + x))
    for b, jump in zip(law.knots, law.jumps, strict=True):
        if not half[len(half) // 2] > b:
            continue
        inner = np.sqrt(np.maximum((half - b) * (half + b), 0))
        part = edge * np.arctan2(inner, b)
        if b > 0:
            apart = np.sqrt(np.abs((b - x) * (b + x))) or LONG(1)
            part = part - b * np.log((inner + edge) / apart)
            if x > 0:
                part = part + x * np.log((b * edge + x * inner) / half / apart)
        total = total + jump * part
    return total / PI


class Work:
    """W(x) at |x| and W of revolution number `cycle`, of a scene with E* = 1; every span of slip in `parts`."""

    def __init__(self, scene, cycle, step=0.3, parts=1):
        self.friction = LONG(scene.friction.coefficient)
        self.phases, self.first = phases_of(scene.load.path(), scene.friction.coefficient, cycle + 1)
        numbers = range(self.first, len(self.phases))
        self.slips = [slip for k in numbers for slip in slips_of(self.phases, k, self.friction)]
        self.law, self.parts, self.contact = law_of(scene.profile), parts, contact_of(scene.profile, scene.material)
        self.lower, self.near, self.weight = _rule(step)
        self.corners = [b for b in self.law.breaks if b > 0]
        self.corner_loads = [LONG(self.law.load(b)) for b in self.corners]

    def nodes(self, begin, end):
        """Nodes and weights on [begin, end]."""
        length = np.asarray(end - begin)[..., None]
        begin, end = np.asarray(begin)[..., None], np.asarray(end)[..., None]
        return np.where(self.lower, begin + length * self.near, end - length * self.near), length * self.weight

    def half(self, load):
        """a(P), (n,): Newton's method inside a bracket, from the engine's as a first guess."""
        load = np.atleast_1d(np.asarray(load, dtype=LONG))
        guess = self.contact.half_width(load.astype(float)).astype(LONG)
        least = self.law.breaks[0]
        low, high = np.full(load.shape, least), 2 * guess + least
        half = np.maximum(guess, least)
        for _ in range(100):
            fault, rate = self.law.load(half) - load, self.law.rate(half)
            low, high = np.where(fault <= 0, half, low), np.where(fault >= 0, half, high)
            newton = half - fault / np.where(rate > 0, rate, 1)
            new = np.where((newton >= low) & (newton <= high) & (rate > 0), newton, (low + high) / 2)
            if np.all(np.abs(new - half) <= 3e-19 * half):
                break
            half = new
        return np.where(load > 0, half, least)

    def _marks(self, slip, begin, end):
        """Times between `begin` and `end` at which an edge of contact or of stick passes a corner, and those of `parts`."""
        marks = [begin, end]
        for corner in self.corner_loads:
            marks += [t for t in (self._passes(slip.phase.of(LONG(1), 0), corner, begin, end),) if t is not None]
            marks += [t for t in (self._meets(slip, corner, begin, end),) if t is not None]
        marks = sorted(marks)
        return [a + (b - a) * k / self.parts for a, b in pairwise(marks) for k in range(self.parts)] + [end]

    @staticmethod
    def _passes(load, value, begin, end):
        ends = load(np.array([begin, end]))[0]
        return root(load, value, begin, end)[()] if (ends[0] - value) * (ends[1] - value) < 0 else None

    @staticmethod
    def _meets(slip, value, begin, end):
        """When the front, which runs down, is at `value`."""
        first, last = slip.front(np.array([begin, end]))
        if not first > value > last:
            return None
        for _ in range(100):
            middle = (begin + end) / 2
            if not begin < middle < end:
                break
            begin, end = (middle, end) if slip.front(middle) > value else (begin, middle)
        return (begin + end) / 2

    def times_at(self, slip, edge_load):
        """(begin, end) of the slip at points of that edge load, None if there is none."""
        begin, end = slip.begin, slip.end
        loads, fronts = slip.phase.loads(np.array([begin, end]))[0], slip.front(np.array([begin, end]))
        if fronts[1] >= edge_load or max(loads) <= edge_load:
            return None
        meets = self._meets(slip, edge_load, begin, end)
        passes = self._passes(slip.phase.of(LONG(1), 0), edge_load, begin, end)
        begin = begin if meets is None else meets
        if passes is not None:
            begin, end = (max(begin, passes), end) if loads[1] > loads[0] else (begin, min(end, passes))
        return (begin, end) if end > begin else None

    def pressure(self, x, half):
        """p(x, P) at the half-widths (n,), all between the same two corners."""
        if isinstance(self.law, Bends):
            return _bent_pressure(self.law, x, half)

        def strip(w):
            at = np.sqrt(x * x + w * w)
            return self.law.rate(at) / at / PI

        w, weight = self.nodes(0 * half, np.sqrt((half - x) * (half + x)))
        return np.sum(weight * strip(w), axis=-1)

    def density(self, x):
        """W(x) at |x| (m,), forward and in reverse: (2, m)."""
        return np.array([[self._at(LONG(at), sign) for at in np.abs(np.asarray(x, dtype=float))] for sign in (1, -1)])

    def _at(self, x, sign):
        edge_load = LONG(self.law.load(x)) if x > self.law.breaks[0] else LONG(0)
        total = LONG(0)
        for slip in self.slips:
            span = self.times_at(slip, edge_load) if slip.sign == sign else None
            for begin, end in pairwise(self._marks(slip, *span)) if span else ():
                times, weight = self.nodes(begin, end)
                p, front, growth = slip.phase.loads(times)[0], slip.front(times), slip.growth(times)[1]
                a, c = self.half(p), self.half(front)
                reach = np.arcsinh(np.sqrt(np.maximum((x - c) * (x + c), 0)) / c)
                total += np.sum(weight * self.pressure(x, np.maximum(a, x)) * growth * reach)
        return 2 / PI * self.friction * total

    def whole(self):
        """W, forward and in reverse."""
        total = {1: LONG(0), -1: LONG(0)}
        for slip in self.slips:
            for begin, end in pairwise(self._marks(slip, slip.begin, slip.end)):
                times, weight = self.nodes(begin, end)
                a, c = self.half(slip.phase.loads(times)[0]), self.half(np.maximum(slip.front(times), 0))
                total[slip.sign] += np.sum(weight * slip.growth(times)[1] * self._area(a, c))
        return 2 / PI * self.friction * np.array([total[1], total[-1]])

    def _area(self, half, stick):
        """int_{P_c}^P ln(a/c) d eta at half-widths (n,), the same corners between them."""
        inside = [b for b in self.law.breaks if stick[len(stick) // 2] < b < half[len(half) // 2]]
        marks = [stick, *(np.full(half.shape, b) for b in inside), half]
        area = 0 * half
        for low, high in pairwise(marks):
            at, weight = self.nodes(low, np.maximum(low, high))
            ratio = np.log1p(np.maximum(at - stick[:, None], 0) / stick[:, None])
            area += np.sum(weight * self.law.rate(at) * ratio, axis=-1)
        return area
