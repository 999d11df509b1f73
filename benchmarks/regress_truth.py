"""The theory in 30-digit arithmetic, sharing no code with the engine: what `regress.py` and the tables of references are made by.

    python benchmarks/regress_truth.py table            the 63 steady ellipses of semi_analytic_reference.json (some minutes)
    python benchmarks/regress_truth.py harmonics        the loads of exact_history.json that are hard on a quadrature (some minutes)

Two routes. A steady ellipse has three phases of slip in closed form (`phases`). Any other load is followed segment by segment:
turning points are roots of polynomials, the edge of the slip zone is a root of the memory curve's level (`follow`). The friction
work is an integral over time between the instants at which something changes.

# notation: A = 2/E*; P_c load at the stick edge, c = a(P_c); eta load of a flat punch of the superposition, M(eta) memory curve;
#           d = +1 forward slip, -1 reverse; level of a load: d Q - f P, grows in slip; of the curve: d M(eta) - f eta; equal at P_c
"""

from __future__ import annotations

import itertools
import json
import math
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import mpmath as mp
from scipy.optimize import brentq

from scenes import Scene

DIGITS = 30
HERE = Path(__file__).parent
TABLE, NASTY_FILE = HERE / "semi_analytic_reference.json", HERE / "exact_history.json"
PLACES = (0.25, 0.6, 0.9)  # of a slip zone, at which W(x) is stored
FIELDS = ("tangential displacement", "stick half-width", "shear at 1", "shear at 2", "shear at 3", "slip at 3")
Number = Any  # mpf, or float for a first guess by the same formulas


# ------------------------------------------------------------------------------------------------------------ normal contact
class Contact(NamedTuple):
    """A parabola and a rounded flat superposed: E*, their curvatures, and the half-length b of the flat."""

    modulus: mp.mpf
    round: mp.mpf = mp.mpf(1)
    rounded: mp.mpf = mp.mpf(0)
    b: mp.mpf = mp.mpf(1)

    def _tau(self, a: mp.mpf) -> mp.mpf:
        return mp.sqrt(a * a / (self.b * self.b) - 1) if a > self.b else mp.mpf(0)

    def load(self, a: mp.mpf) -> mp.mpf:
        """P(a); the flat's by section 4.2 of the paper with b^2 in place of a^2 (a misprint there), a = b sqrt(1 + tau^2)."""
        tau = self._tau(a)
        return self.modulus * (self.round * mp.pi * a * a / 4 + self.rounded * self.b**2 * ((1 + tau**2) * mp.atan(tau) - tau) / 2)

    def half_width(self, p: mp.mpf) -> mp.mpf:
        """a(P): closed within b, else Newton for tau from beyond the root; P(tau) is convex there."""
        if not self.rounded or p <= self.load(self.b):
            return mp.sqrt(4 * p / (mp.pi * self.modulus * self.round)) if self.round else self.b
        tau = mp.mpf(1)
        while self.load(self.b * mp.sqrt(1 + tau**2)) < p:
            tau *= 2
        for _ in range(300):
            slope = self.modulus * self.b**2 * tau * (self.round * mp.pi / 2 + self.rounded * mp.atan(tau))
            step = (self.load(self.b * mp.sqrt(1 + tau**2)) - p) / slope
            tau -= step
            if abs(step) < tau * mp.mpf(10) ** (2 - mp.mp.dps):
                break
        return self.b * mp.sqrt(1 + tau**2)

    def pressure(self, x: mp.mpf, a: mp.mpf) -> mp.mpf:
        """p(x) at the half-width a; of a flat for x > b."""
        if x >= a:
            return mp.mpf(0)
        root, b = mp.sqrt((a - x) * (a + x)), self.b
        found = self.round * root / 2
        if self.rounded:
            m = mp.sqrt(a * a - b * b)
            flat = root * mp.acos(b / a) - b * mp.atanh(root / m) + x * mp.atanh(b * root / (x * m))
            found += self.rounded * flat / mp.pi
        return self.modulus * found

    def area(self, p: mp.mpf, front: mp.mpf) -> mp.mpf:
        """int ln(a(eta)/c) d eta over P_c < eta < P."""
        a, c = self.half_width(p), self.half_width(front)
        return p * mp.log(a / c) - self._below(a) + self._below(c)

    def _below(self, a: mp.mpf) -> mp.mpf:
        """int P(alpha)/alpha d alpha up to a."""
        tau = self._tau(a)
        flat = ((1 + tau**2) * mp.atan(tau) - tau) / 2 - tau + mp.atan(tau)
        return self.modulus * (self.round * mp.pi * a * a / 8 + self.rounded * self.b**2 / 2 * flat)


def contact_of(scene: Scene) -> Contact | None:
    """Of the profiles that are a parabola and a rounded flat laid over each other; None for the others."""
    p = scene.profile
    curvatures: dict[str, Callable[[], tuple[Any, Any, Any]]] = {
        "hertz": lambda: (1 / mp.mpf(p.radius), 0, 1),
        "flat_rounded": lambda: (0, 1 / mp.mpf(p.radius), p.flat_half_length),
        "compound": lambda: (
            1 / mp.mpf(p.inner_radius),
            1 / mp.mpf(p.outer_radius) - 1 / mp.mpf(p.inner_radius),
            p.inner_half_length,
        ),
        "wedge": lambda: (1 / mp.mpf(p.tip_radius), -1 / mp.mpf(p.tip_radius), p.tip_half_length),
    }
    return Contact(modulus(scene), *map(mp.mpf, curvatures[p.kind]())) if p.kind in curvatures else None


def modulus(scene: Scene) -> mp.mpf:
    """E*."""
    bodies = scene.material.lower, scene.material.upper
    return 1 / sum((1 - mp.mpf(m.poisson_ratio) ** 2) / mp.mpf(m.young_modulus) for m in bodies)


# ----------------------------------------------------------------------------------------------------------- steady ellipses
class Case(NamedTuple):
    """A steady ellipse with E* = 1 and R = 1; `flat` is b, 0 for Hertz; `phase` in degrees, or in radians where it says so."""

    flat: float
    mean: float
    amplitude: float
    tangential: float
    phase: float
    friction: float
    radians: bool = False

    def contact(self) -> Contact:
        return Contact(mp.mpf(1), mp.mpf(0), mp.mpf(1), mp.mpf(self.flat)) if self.flat else Contact(mp.mpf(1))


def cases() -> list[Case]:
    """The paper's cycle, and 40 more over both geometries."""
    ratios, uses = itertools.cycle((0.1, 0.5, 0.9)), itertools.cycle((0.9, 0.2, 0.6, 0.99, 0.02))
    found = [Case(0.0, 3.0, 1.0, 1.0, 90.0, 1.0)]
    for phase, friction, flat in itertools.product((5.0, 45.0, 90.0, 135.0, 175.0), (1e-3, 0.3, 1.0, 10.0), (0.0, 0.7)):
        ratio, use = next(ratios), next(uses)
        found.append(Case(flat, 1.0, ratio, use * friction * (1 - ratio), phase, friction))
    return found


def extremes() -> list[Case]:
    """Where plain formulas lose their digits: tiny slip, next to gross sliding, to full unloading, to tangency, to a line."""
    f, right = 0.5, math.pi / 2
    of_load = [
        *((0.0, 1e-9 * f, 1.0), (0.3, 1e-9 * f, right), (0.5, 1e-6 * f, 1.0), (0.4, f * math.sqrt(1 - 0.16) * (1 - 1e-12), right)),
        *((1 - 1e-9, 1e-10 * f, right), (1 - 1e-9, 4e-5 * f, right), (0.3, 0.2 * f, 1e-9), (0.3, 0.4 * f, 1e-9)),
        *((0.25, 0.25 * f, 1e-9), (0.3, 0.2 * f, math.pi - 1e-9), (0.25, 0.25 * f, math.pi - 1e-9)),
    ]
    return [Case(flat, 1.0, p, q, phase, f, True) for flat in (0.0, 0.7) for p, q, phase in of_load]


class Phase(NamedTuple):
    """A phase of slip: times of begin and end, rate of Q - fP or Q + fP, load at the stick edge."""

    begin: mp.mpf
    end: mp.mpf
    rate: Callable[[mp.mpf], mp.mpf]
    front: Callable[[mp.mpf], mp.mpf]


def phases(case: Case) -> tuple[Callable[[mp.mpf], mp.mpf], list[Phase]]:
    """P(t), and the three phases of slip E-G, I-J, J-M of the steady cycle (0 < phase < 180 degrees, Q0 = 0).

    E maximum of Q - fP, G minimum of Q + fP, I minimum of Q - fP, J where the edge has passed G, M = E a turn later.
    """
    p0, p1, q1, f = (mp.mpf(v) for v in (case.mean, case.amplitude, case.tangential, case.friction))
    phase = mp.mpf(case.phase) * (1 if case.radians else mp.pi / 180)
    z_u, z_v = q1 * mp.expj(-phase) - f * p1, q1 * mp.expj(-phase) + f * p1
    t_e, size_u, size_v = -mp.arg(z_u), abs(z_u), abs(z_v)
    t_g = -mp.arg(z_v) + mp.pi
    t_g -= 2 * mp.pi * mp.floor((t_g - t_e) / (2 * mp.pi))
    t_i, t_m = t_e + mp.pi, t_e + 2 * mp.pi
    t_j = 2 * t_i - t_g
    u_max, v_min = size_u - f * p0, f * p0 - size_v

    def load(t: mp.mpf) -> mp.mpf:
        return p0 + p1 * mp.cos(t)

    def forward(t: mp.mpf) -> mp.mpf:
        return size_u * abs(mp.sin(t - t_e))

    return load, [
        Phase(
            t_e,
            t_g,
            lambda t: size_v * abs(mp.sin(t - t_g)),
            lambda t: (f * p0 - size_v * mp.cos(t - t_g) - u_max) / (2 * f),
        ),
        Phase(t_i, t_j, forward, lambda t: load(2 * t_i - t)),
        Phase(t_j, t_m, forward, lambda t: (v_min + f * p0 - size_u * mp.cos(t - t_e)) / (2 * f)),
    ]


def ellipse_dissipation(case: Case, contact: Contact | None = None) -> mp.mpf:
    """W of a steady cycle: (f A/pi) closed-int |u' or v'| int ln(a/c) d eta dt over the phases of slip."""
    contact = contact or case.contact()
    load, parts = phases(case)

    def power(part: Phase, t: mp.mpf) -> mp.mpf:
        p, front = load(t), part.front(t)
        return part.rate(t) * contact.area(p, front) if 0 < front < p else mp.mpf(0)

    # P(a) is smooth but for the load at which the edge passes b: cut there, for P and for the stick edge.
    corner = contact.load(contact.b) if contact.round and contact.rounded else None
    total = mp.mpf(0)
    for part in parts:
        marks = _towards_ends(part.begin, part.end) if case.radians else mp.linspace(part.begin, part.end, 4)
        if corner is not None:
            marks = sorted([*marks, *_crossings(load, corner, marks), *_crossings(part.front, corner, marks)])
        total += mp.quad(lambda t, part=part: power(part, t), marks)
    return mp.mpf(case.friction) * 2 / (mp.pi * contact.modulus) * total


def _towards_ends(begin: mp.mpf, end: mp.mpf) -> list[mp.mpf]:
    """Places ever closer to both ends."""
    steps = [(end - begin) * mp.mpf(10) ** -k / 2 for k in range(0, 14, 2)]
    return [begin, *(begin + step for step in reversed(steps)), *(end - step for step in steps[1:]), end]


def _crossings(function: Callable[[mp.mpf], mp.mpf], value: mp.mpf, marks: Sequence[mp.mpf]) -> list[mp.mpf]:
    """Where a function takes a value, between places that are dense beside its turning points."""
    grid = [t for a, b in pairwise(marks) for t in mp.linspace(a, b, 9)[:-1]] + [marks[-1]]
    found = []
    for a, b in pairwise(grid):
        if (function(a) > value) != (function(b) > value):
            found.append(mp.findroot(lambda t: function(t) - value, (a, b), solver="anderson", tol=mp.eps**2, verify=False))
    return found


# ------------------------------------------------------------------------------------------------------------- load segments
def same() -> mp.mpf:
    """What is round-off error: ten digits short of all."""
    return mp.mpf(10) ** (10 - mp.mp.dps)


class Waves(NamedTuple):
    """A segment P = P0 + sum P_k cos(k t - phi_k), Q likewise; (amplitude, phase) of k = 1, 2, ..."""

    begin: mp.mpf
    end: mp.mpf
    mean: tuple[mp.mpf, mp.mpf]
    waves: tuple[tuple[tuple[mp.mpf, mp.mpf], ...], ...]

    def loads(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        """P and Q."""
        mean = self.mean if lib is mp else tuple(map(float, self.mean))
        return tuple(m + _sum(waves, t, lib, 0) for m, waves in zip(mean, self.waves, strict=True))

    def rates(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        """P' and Q'."""
        return tuple(_sum(waves, t, lib, 1) for waves in self.waves)

    def turns(self, normal: mp.mpf, tangential: mp.mpf) -> list[mp.mpf]:
        """Times at which c_P P + c_Q Q turns round: Re sum A_k z^k = 0 on the unit circle z = exp(i t)."""
        order = max(len(waves) for waves in self.waves)
        a = [mp.mpc(0)] * (order + 1)
        for factor, waves in zip((normal, tangential), self.waves, strict=True):
            for k, (size, phase) in enumerate(waves, 1):
                a[k] += 1j * k * factor * size * mp.expj(-phase)
        while order and a[order] == 0:
            order -= 1
        if not order:
            return []
        polynomial = [*a[order:0:-1], mp.mpf(0), *(mp.conj(part) for part in a[1 : order + 1])]
        roots = mp.polyroots(polynomial, maxsteps=500, extraprec=400)
        angles = [mp.arg(root) for root in roots if abs(abs(root) - 1) < same()]
        return [t for angle in angles for k in range(-1, 3) if self.begin < (t := angle + 2 * mp.pi * k) < self.end]


def _sum(waves: Sequence[tuple[mp.mpf, mp.mpf]], t: Number, lib: Any, derivative: int) -> Number:
    total = 0 * t
    for k, pair in enumerate(waves, 1):
        size, phase = pair if lib is mp else map(float, pair)
        total += size * (lib.cos(k * t - phase) if not derivative else -k * lib.sin(k * t - phase))
    return total


class Polynomial(NamedTuple):
    """A segment in unit time from one point (P, Q) to another, straight, or with Q = .. + `bend` t (1 - t), in full stick."""

    first: tuple[mp.mpf, mp.mpf]
    last: tuple[mp.mpf, mp.mpf]
    bend: mp.mpf = mp.mpf(0)
    begin: mp.mpf = mp.mpf(0)
    end: mp.mpf = mp.mpf(1)

    def loads(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        p, q = (a + (b - a) * t for a, b in zip(self.first, self.last, strict=True))
        q += self.bend * t * (1 - t)
        return (p, q) if lib is mp else (float(p), float(q))

    def rates(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        p, q = (b - a for a, b in zip(self.first, self.last, strict=True))
        q += self.bend * (1 - 2 * t)
        return (p, q) if lib is mp else (float(p), float(q))

    def turns(self, normal: mp.mpf, tangential: mp.mpf) -> list[mp.mpf]:
        return []


Segment = Waves | Polynomial


def root(leg: Segment, what: tuple[Number, Number], wanted: mp.mpf, first: mp.mpf, last: mp.mpf) -> mp.mpf:
    """The time in [first, last] at which a combination of loads, monotone there, has a value: in doubles, then by Newton."""

    def off(t: Number, lib: Any = mp) -> Number:
        p, q = leg.loads(t, lib)
        c = what if lib is mp else (float(what[0]), float(what[1]))
        return c[0] * p + c[1] * q - (wanted if lib is mp else float(wanted))

    low, high = off(first), off(last)
    if low == 0 or high == 0 or (low > 0) == (high > 0):
        return first if abs(low) < abs(high) else last
    a, b = float(first), float(last)
    known = (off(a, math) > 0) != (off(b, math) > 0)
    t = min(max(mp.mpf(brentq(lambda s: off(s, math), a, b, xtol=1e-15)) if known else (first + last) / 2, first), last)
    floor, ceiling = first, last
    for _ in range(400):
        here = off(t)
        floor, ceiling = (t, ceiling) if (here > 0) == (low > 0) else (floor, t)
        rate = sum(c * r for c, r in zip(what, leg.rates(t), strict=True))
        new = t - (here / rate if rate else ceiling - floor)
        if not floor < new < ceiling:
            new = (floor + ceiling) / 2
        if abs(new - t) <= abs(t) * mp.eps * 4 or new == t:
            return new
        t = new
    return t


def _straight(points: list[tuple[float, float]], closed: bool = False) -> list[Polynomial]:
    exact = [(mp.mpf(p), mp.mpf(q)) for p, q in points]
    return [Polynomial(a, b) for a, b in pairwise([*exact, *exact[:closed]]) if a != b]


def waves(mean: Sequence[float], normal: Sequence[Any], tangential: Sequence[Any]) -> tuple[list[Segment], list[Segment]]:
    """Straight initial loading (the steady cycle forgets it) and revolution."""
    pairs = tuple(tuple((mp.mpf(size), mp.pi * mp.mpf(degrees) / 180) for size, degrees in one) for one in (normal, tangential))
    turn = Waves(mp.mpf(0), 2 * mp.pi, (mp.mpf(mean[0]), mp.mpf(mean[1])), pairs)
    return [Polynomial((mp.mpf(0), mp.mpf(0)), turn.loads(mp.mpf(0)))], [turn]


def segments(load: Any) -> tuple[list[Segment], list[Segment]] | None:
    """Initial loading and cycle of a load in mpmath; None for kinds that have no such form."""
    match load.kind:
        case "harmonics":
            return waves((load.mean_normal_load, load.mean_tangential_load), load.normal_harmonics, load.tangential_harmonics)
        case "ellipse":
            mean = load.mean_normal_load, load.mean_tangential_load
            return waves(mean, [(load.normal_amplitude, 0.0)], [(load.tangential_amplitude, load.phase_degrees)])
        case "polygon":
            cycle = _straight([load.initial_loading[-1], *load.cycle], closed=True) if load.cycle else []
            return _straight([(0.0, 0.0), *load.initial_loading]), cycle
        case "time_series":
            return _straight(load.series()[:, 1:].tolist()), []
    return None


# -------------------------------------------------------------------------------------------------------------- memory curve
class Piece(NamedTuple):
    """A piece of the memory curve up to the load `top`: a line through (p, q), or a segment's arc appended in full stick."""

    top: mp.mpf
    p: mp.mpf
    q: mp.mpf
    slope: mp.mpf = mp.mpf(0)
    arc: tuple[Segment, mp.mpf, mp.mpf] | None = None

    def value(self, eta: mp.mpf) -> mp.mpf:
        """M(eta)."""
        if self.arc is None:
            return self.q + self.slope * (eta - self.p)
        leg, first, last = self.arc
        return leg.loads(root(leg, (1, 0), eta, first, last))[1]

    def front(self, d: int, f: mp.mpf, level: mp.mpf) -> mp.mpf:
        """The eta at which d M(eta) - f eta is `level`."""
        if self.arc is None:
            return self.p + (level - d * self.q + f * self.p) / (d * self.slope - f)
        leg, first, last = self.arc
        return leg.loads(root(leg, (-f, d), level, first, last))[0]


class Run(NamedTuple):
    """Slip on one piece of the memory curve (None: on nothing, P_c = 0): times, direction, segment."""

    begin: mp.mpf
    end: mp.mpf
    direction: int
    leg: Segment
    piece: Piece | None

    def growth(self, f: mp.mpf, t: mp.mpf) -> mp.mpf:
        p, q = self.leg.rates(t)
        return max(self.direction * q - f * p, mp.mpf(0))

    def front(self, f: mp.mpf, t: mp.mpf) -> mp.mpf:
        p, q = self.leg.loads(t)
        return self.piece.front(self.direction, f, self.direction * q - f * p) if self.piece else mp.mpf(0)


Curve = tuple[Piece, ...]


def value(curve: Curve, eta: mp.mpf) -> mp.mpf:
    """M(eta)."""
    return next((piece for piece in curve if eta <= piece.top), curve[-1]).value(eta) if curve else mp.mpf(0)


def cut(curve: Curve, load: mp.mpf) -> Curve:
    """The curve below `load`."""
    bottoms = (mp.mpf(0), *(piece.top for piece in curve))
    kept = zip(curve, bottoms, strict=False)
    return tuple(piece._replace(top=min(piece.top, load)) for piece, bottom in kept if bottom < load)


def follow(curve: Curve, leg: Segment, f: mp.mpf) -> tuple[Curve, list[Run]]:
    """The memory curve after a segment, and its runs of slip."""
    turns = sorted(t for what in ((1, 0), (-f, 1), (-f, -1)) for t in leg.turns(*map(mp.mpf, what)))
    runs: list[Run] = []
    for begin, end in pairwise([leg.begin, *turns, leg.end]):
        if end - begin > same():
            curve, found = _between_turns(curve, leg, begin, end, f)
            runs += found
    return curve, runs


def _between_turns(curve: Curve, leg: Segment, begin: mp.mpf, end: mp.mpf, f: mp.mpf) -> tuple[Curve, list[Run]]:
    """The same where neither P, Q - fP nor Q + fP turns round."""
    p_rate, q_rate = leg.rates((begin + end) / 2)
    noise = same() * (abs(q_rate) + f * abs(p_rate))
    p_last, q_last = leg.loads(end)
    if p_rate > 0 and abs(q_rate) < f * p_rate - noise:
        if isinstance(leg, Polynomial) and not leg.bend:
            return (*curve, Piece(p_last, *leg.loads(begin), q_rate / p_rate)), []
        return (*curve, Piece(p_last, p_last, q_last, arc=(leg, begin, end))), []
    sides = [(begin, end, d) for d in (1, -1) if d * q_rate - f * p_rate > noise and d * q_rate + f * p_rate > -noise]
    sides = sides or _sides(curve, leg, begin, end)
    runs = [run for first, last, d in sides if d for run in _passed(curve, leg, first, last, d, f)]
    d = sides[-1][2]
    if not d:
        return cut(curve, p_last), runs
    return (*cut(curve, runs[-1].front(f, end)), Piece(p_last, p_last, q_last, d * f)), runs


def _sides(curve: Curve, leg: Segment, begin: mp.mpf, end: mp.mpf) -> list[tuple[mp.mpf, mp.mpf, int]]:
    """(begin, end, direction) of the parts of an unloading on which the path runs above, below, or along the curve."""

    def above(t: mp.mpf) -> mp.mpf:
        p, q = leg.loads(t)
        off = q - value(curve, p)
        return off if abs(off) > same() * p else mp.mpf(0)

    times = mp.linspace(begin, end, 200)[1:]
    signs = [int(mp.sign(above(t))) for t in times]
    marks, directions = [begin], [next((s for s in signs if s), 0)]
    for (t0, t1), (s0, s1) in zip(pairwise(times), pairwise(signs), strict=True):
        if s0 * s1 < 0:
            marks.append(mp.findroot(above, (t0, t1), solver="anderson", tol=mp.mpf(10) ** -50, verify=False))
            directions.append(s1)
    return list(zip(marks, [*marks[1:], end], directions, strict=True))


def _passed(curve: Curve, leg: Segment, begin: mp.mpf, end: mp.mpf, d: int, f: mp.mpf) -> list[Run]:
    """Runs of slip from `begin` to `end`, one for each piece that the stick edge is in."""
    runs, first = [], begin
    bottoms = [mp.mpf(0), *(piece.top for piece in curve)]
    for piece, bottom in zip(reversed(curve), reversed(bottoms[:-1]), strict=True):
        if piece.arc is None and piece.slope == d * f:
            continue  # at the limit already: the edge passes it at once
        level = d * value(curve, bottom) - f * bottom if bottom else mp.mpf(0)
        p, q = leg.loads(end)
        last = root(leg, (-f, d), level, first, end) if d * q - f * p > level else end
        if last > first:
            runs.append(Run(first, last, d, leg, piece))
            first = last
        if last == end:
            break
    return runs


def steady_runs(initial_loading: Sequence[Segment], cycle: Sequence[Segment], f: mp.mpf) -> list[Run]:
    """The runs of slip of the second cycle; of the initial loading where there is no cycle."""
    curve: Curve = ()
    runs: list[Run] = []
    for turn in (initial_loading, cycle, cycle) if cycle else (initial_loading,):
        runs = []
        for leg in turn:
            curve, found = follow(curve, leg, f)
            runs += found
    return runs


def dissipation(runs: Sequence[Run], contact: Contact, f: mp.mpf) -> mp.mpf:
    """Friction work of the runs: (f A/pi) int w' int ln(a/c) d eta dt."""

    def power(run: Run, t: mp.mpf) -> mp.mpf:
        p, front = run.leg.loads(t)[0], run.front(f, t)
        return run.growth(f, t) * contact.area(p, front) if 0 < front < p else mp.mpf(0)

    total = sum(_integral(lambda t, run=run: power(run, t), run.begin, run.end) for run in runs)
    return 2 * f / (mp.pi * contact.modulus) * total


def density(runs: Sequence[Run], contact: Contact, f: mp.mpf, x: mp.mpf) -> mp.mpf:
    """Friction work of the runs per unit area at x: (f A/pi) int p(x, P) w' arccosh(x/c) dt while c < x < a."""
    edge, total = contact.load(x), mp.mpf(0)

    def power(run: Run, t: mp.mpf) -> mp.mpf:
        p, front = run.leg.loads(t)[0], run.front(f, t)
        if not 0 < front < edge < p:
            return mp.mpf(0)
        return contact.pressure(x, contact.half_width(p)) * run.growth(f, t) * mp.acosh(max(x / contact.half_width(front), 1))

    for run in runs:
        marks = [run.begin, run.end, root(run.leg, (1, 0), edge, run.begin, run.end)]
        if run.piece and run.front(f, run.begin) > edge > run.front(f, run.end):
            level = run.direction * run.piece.value(edge) - f * edge
            marks.append(root(run.leg, (-f, run.direction), level, run.begin, run.end))
        for begin, end in pairwise(sorted(marks)):
            middle = (begin + end) / 2
            if end > begin and run.front(f, middle) < edge < run.leg.loads(middle)[0]:
                total += _integral(lambda t, run=run: power(run, t), begin, end)
    return 2 * f / (mp.pi * contact.modulus) * total


def _integral(power: Callable[[mp.mpf], mp.mpf], first: mp.mpf, last: mp.mpf) -> mp.mpf:
    """Tanh-sinh on four parts, and on halves of a part until its own estimate is small enough."""
    todo = list(pairwise(mp.linspace(first, last, 5)))
    total, size = mp.mpf(0), mp.mpf(0)
    while todo:
        begin, end = todo.pop()
        part, error = mp.quad(power, [begin, end], error=True)
        size = max(size, abs(part))
        if error > size * mp.mpf(10) ** (3 - mp.mp.dps) and end - begin > (last - first) / 4096:
            middle = (begin + end) / 2
            todo += [(begin, middle), (middle, end)]
        else:
            total += part
    return total


# -------------------------------------------------------------------------------------------------------------------- scenes
def truth(scene: Scene) -> mp.mpf | None:
    """Dissipation of the last cycle with 30 digits: a closed form, else integrals over time; None where there is no way yet."""
    load, f, contact = scene.load, mp.mpf(scene.friction.coefficient), contact_of(scene)
    if (closed := _closed_form(scene, f)) is not None:
        return closed
    if load.kind == "ellipse" and load.phase_degrees not in (0.0, 180.0, -180.0) and contact:
        return steady_ellipse(scene)
    if scene.profile.kind != "hertz" or (legs := segments(load)) is None:
        return None
    return dissipation(steady_runs(*legs, f), contact, f)


def steady_ellipse(scene: Scene) -> mp.mpf:
    """W of an ellipse scene by its three phases; Q mirrored where it turns the other way."""
    load = scene.load
    degrees = load.phase_degrees if load.phase_degrees > 0 else load.phase_degrees + 180
    amplitudes = load.mean_normal_load, load.normal_amplitude, load.tangential_amplitude
    return ellipse_dissipation(Case(0.0, *amplitudes, degrees, scene.friction.coefficient), contact_of(scene))


def _closed_form(scene: Scene, f: mp.mpf) -> mp.mpf | None:
    """Zero where P and Q are in proportion or Q is 0; Hertz, constant P, Q between +-k f P: Mindlin and Deresiewicz (1953)."""
    load = scene.load
    if load.kind == "polygon":
        points = [*load.initial_loading, *load.cycle]
        if all(q == 0 for _, q in points):
            return mp.mpf(0)
        loads, swing = {p for p, _ in points}, max(abs(mp.mpf(q)) for _, q in points)
    elif load.kind == "ellipse" and load.normal_amplitude == 0:
        loads, swing = {load.mean_normal_load}, mp.mpf(load.tangential_amplitude)
    elif load.kind == "ellipse" and load.phase_degrees in (0.0, 180.0, -180.0):
        ratio = load.mean_tangential_load / load.mean_normal_load
        one_ray = abs(load.tangential_amplitude - ratio * load.normal_amplitude) < 1e-12 * load.normal_amplitude
        return mp.mpf(0) if one_ray and abs(ratio) < f else None
    else:
        return None
    if scene.profile.kind != "hertz" or len(loads) != 1:
        return None
    return mindlin(swing / (f * mp.mpf(next(iter(loads)))), f * mp.mpf(next(iter(loads)))) / modulus(scene)


def mindlin(k: mp.mpf, limit: mp.mpf) -> mp.mpf:
    """E* W of a cycle of Q between +-k f P at constant P, limit = f P: (4 f^2 P^2/pi) [(1-k) ln(1-k) + k - k^2/2]."""
    log = (1 - k) * mp.log(1 - k) if k < 1 else mp.mpf(0)
    return 4 * limit**2 / mp.pi * (log + k - k**2 / 2)


def pointwise_truth(scene: Scene) -> dict[str, list]:
    """W(x) at three places of the slip zone, 30 digits, by the memory curve."""
    legs, contact = segments(scene.load), contact_of(scene)
    return _pointwise(*legs, contact, mp.mpf(scene.friction.coefficient))


def _pointwise(initial: list[Segment], cycle: list[Segment], contact: Contact, f: mp.mpf) -> dict[str, list]:
    runs = steady_runs(initial, cycle, f)
    inner = contact.half_width(min(run.front(f, run.end) for run in runs))
    outer = contact.half_width(
        max(leg.loads(t)[0] for leg in cycle or initial for t in (leg.begin, leg.end, *leg.turns(mp.mpf(1), mp.mpf(0))))
    )
    places = [float(inner + (outer - inner) * mp.mpf(part)) for part in PLACES]
    return {"x": places, "density": [mp.nstr(density(runs, contact, f, mp.mpf(x)), DIGITS) for x in places]}


def field_truth(scene: Scene, time: float, x: Sequence[float]) -> list[str] | None:
    """The `FIELDS` at one time and three points of a Hertz scene, 30 digits; None for rows, and where there is no friction.

    Of the memory curve M: q = int M'/(pi sqrt(a^2 - x^2)), s = (A/pi) int M' arccosh(x/a), U = (A/pi) int M' ln(2 L/a), each over
    the loads that count, on lines in closed form but for s, on arcs over time.
    """
    load, f = scene.load, mp.mpf(scene.friction.coefficient)
    if scene.profile.kind != "hertz" or load.kind not in ("ellipse", "polygon", "harmonics") or not f:
        return None
    curve, front = _state(scene, time, f)
    contact, datum = contact_of(scene), mp.mpf(scene.profile.datum_length)
    half = contact.half_width

    def whole(kernel: Callable, least: mp.mpf, most: mp.mpf, primitive: Callable | None = None) -> mp.mpf:
        """int M'(eta) kernel(eta) over least < eta < most."""
        total, bottom = mp.mpf(0), mp.mpf(0)
        for piece in curve:
            low, high = max(bottom, least), min(piece.top, most)
            bottom = piece.top
            if high <= low:
                continue
            if piece.arc is None:
                total += piece.slope * (primitive(high) - primitive(low) if primitive else mp.quad(kernel, [low, high]))
            else:
                leg, first, last = piece.arc
                ends = [root(leg, (1, 0), eta, first, last) for eta in (low, high)]
                total += mp.quad(lambda t, leg=leg: leg.rates(t)[1] * kernel(leg.loads(t)[0]), mp.linspace(*ends, 5))
        return total

    def shear(at: mp.mpf) -> mp.mpf:
        def kernel(p: mp.mpf) -> mp.mpf:
            return 1 / (mp.pi * mp.sqrt(half(p) ** 2 - at * at)) if half(p) > at else mp.mpf(0)

        return whole(kernel, contact.load(at), mp.inf, lambda p: contact.pressure(at, half(p)))

    def slip(at: mp.mpf) -> mp.mpf:
        return whole(lambda p: mp.acosh(max(at / half(p), 1)) if p else mp.mpf(0), mp.mpf(0), contact.load(at))

    def displacement(p: mp.mpf) -> mp.mpf:
        return p * (mp.log(2 * datum / half(p)) + mp.mpf(1) / 2) if p else mp.mpf(0)

    scale, points = 2 / (mp.pi * contact.modulus), [mp.mpf(place) for place in x]
    shift = whole(lambda p: mp.log(2 * datum / half(p)), mp.mpf(0), mp.inf, displacement)
    found = [scale * shift, half(front), *(shear(place) for place in points), scale * slip(points[-1])]
    return [mp.nstr(one, DIGITS) for one in found]


def _state(scene: Scene, time: float, f: mp.mpf) -> tuple[Curve, mp.mpf]:
    """The memory curve at a time, and the load at the stick edge."""
    path, (initial_loading, cycle) = scene.load.path(), segments(scene.load)
    if scene.load.kind == "ellipse":  # it starts where Q is least
        begin = mp.mpf(path.cycle_start)
        cycle = [cycle[0]._replace(begin=begin, end=begin + 2 * mp.pi)]
        first = cycle[0].loads(begin)
        bend = mp.mpf(0)
        if scene.load.initial_loading == "parabola":  # Q = alpha P + beta P^2 with the ellipse's own slope at the end
            p_rate, q_rate = cycle[0].rates(begin)
            bend = first[1] - q_rate / p_rate * first[0]
        initial_loading = [Polynomial((mp.mpf(0), mp.mpf(0)), first, bend)]
    whole, rest = (0, mp.mpf(time) - path.start) if path.period is None else divmod(mp.mpf(time) - path.cycle_start, path.period)
    legs = [*initial_loading, *cycle * min(int(whole), 2)] if cycle else []
    for leg in cycle or initial_loading:
        length = leg.end - leg.begin
        legs.append(leg._replace(end=leg.begin + min(rest, length)))
        rest -= length
        if rest <= 0:
            break
    curve: Curve = ()
    runs: list[Run] = []
    for leg in legs:
        curve, runs = follow(curve, leg, f)
    slips = runs and runs[-1].end == legs[-1].end
    return curve, runs[-1].front(f, legs[-1].end) if slips else legs[-1].loads(legs[-1].end)[0]


# -------------------------------------------------------------------------------------------------------------------- tables
def record(case: Case) -> dict[str, object]:
    """One entry of the table: W, and but for the extremes, which take many more digits on the way, W(x) at three places."""
    mp.mp.dps = 3 * DIGITS if case.radians else DIGITS + 8
    found = {**case._asdict(), "dissipation": mp.nstr(ellipse_dissipation(case), DIGITS)}
    if case.radians:
        return found
    f, legs = mp.mpf(case.friction), waves((case.mean, 0.0), [(case.amplitude, 0.0)], [(case.tangential, case.phase)])
    return found | _pointwise(*legs, case.contact(), f)


_SLIDING = 2.2656448181047733  # times this, |Q|/(f P) reaches 1 - 1e-6
NASTY: dict[str, dict[str, Any]] = {
    "square wave": {  # eleven odd harmonics of Q under a slow P: ripples of the stick edge
        "friction": 0.5,
        "mean": (1.0, 0.0),
        "normal": [(0.3, 0.0)],
        "tangential": [(0.25 / k if k % 2 else 0.0, 90.0) for k in range(1, 12)],
        "x": [0.75, 0.85, 0.98, 1.1],
    },
    "near sliding": {  # once a revolution
        "friction": 0.5,
        "mean": (1.0, 0.0),
        "normal": [(0.3, 0.0), (0.1, 50.0), (0.1, -30.0)],
        "tangential": [(size * _SLIDING, phase) for size, phase in ((0.1, 90.0), (0.05, 20.0), (0.06, 10.0), (0.02, 200.0))],
        "x": [0.2, 0.7, 0.95, 1.1],
    },
}
"""E* = 1, R = 1; [amplitude, phase in degrees] of k = 1, 2, ..."""


def harmonics(name: str) -> dict[str, Any]:
    """W and W(x) of a case of NASTY."""
    mp.mp.dps = DIGITS + 10
    case, contact = NASTY[name], Contact(mp.mpf(1))
    f = mp.mpf(case["friction"])
    runs = steady_runs(*waves(case["mean"], case["normal"], case["tangential"]), f)
    each = [mp.nstr(density(runs, contact, f, mp.mpf(x)), DIGITS) for x in case["x"]]
    return {**case, "dissipation": mp.nstr(dissipation(runs, contact, f), DIGITS), "density": each}


def main() -> None:
    with ProcessPoolExecutor() as pool:
        if sys.argv[1:] == ["table"]:
            file, found = TABLE, list(pool.map(record, [*cases(), *extremes()]))
        elif sys.argv[1:] == ["harmonics"]:
            file, found = NASTY_FILE, dict(zip(NASTY, pool.map(harmonics, NASTY), strict=True))
        else:
            sys.exit("regress_truth: name what to make: table or harmonics")
    file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
