"""Reference values of the dissipation in 30-digit arithmetic, straight from the one-dimensional integrals of the steady ellipse.

Shares no code with the engine. Run it to make `semi_analytic_reference.json` anew (some minutes):

    python benchmarks/semi_analytic_reference.py

# notation: u = Q - f P, v = Q + f P; E maximum of u, G minimum of v, I minimum of u, J = where the front has passed G,
#           M = E a turn later; A = 2/E*; P_c load at the front of slip, c = a(P_c); P_x load at which a = |x|
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import mpmath as mp

FILE = Path(__file__).with_suffix(".json")
DIGITS = 30


class Case(NamedTuple):
    """A steady ellipse with E* = 1 and R = 1; `flat` is b, 0 for Hertz; `phase` in degrees, or in radians where it says so."""

    flat: float
    mean: float
    amplitude: float
    tangential: float
    phase: float
    friction: float
    radians: bool = False


PAPER = Case(0.0, 3.0, 1.0, 1.0, 90.0, 1.0)


def cases() -> list[Case]:
    """The paper's cycle, and 40 more over both geometries."""
    ratios, uses = itertools.cycle((0.1, 0.5, 0.9)), itertools.cycle((0.9, 0.2, 0.6, 0.99, 0.02))
    found = [PAPER]
    for phase, friction, flat in itertools.product((5.0, 45.0, 90.0, 135.0, 175.0), (1e-3, 0.3, 1.0, 10.0), (0.0, 0.7)):
        ratio, use = next(ratios), next(uses)
        found.append(Case(flat, 1.0, ratio, use * friction * (1 - ratio), phase, friction))
    return found


def extremes() -> list[Case]:
    """Where plain formulas lose their digits: tiny slip, next to gross sliding, to full unloading, to tangency, to a line."""
    found = []
    for flat, friction in ((0.0, 0.5), (0.7, 0.5)):
        near_sliding = friction * math.sqrt(1 - 0.16) * (1 - 1e-12)
        found += [
            Case(flat, 1.0, 0.0, 1e-9 * friction, 1.0, friction, True),
            Case(flat, 1.0, 0.3, 1e-9 * friction, math.pi / 2, friction, True),
            Case(flat, 1.0, 0.5, 1e-6 * friction, 1.0, friction, True),
            Case(flat, 1.0, 0.4, near_sliding, math.pi / 2, friction, True),
            Case(flat, 1.0, 1 - 1e-9, 1e-10 * friction, math.pi / 2, friction, True),
            Case(flat, 1.0, 1 - 1e-9, 4e-5 * friction, math.pi / 2, friction, True),
            Case(flat, 1.0, 0.3, 0.2 * friction, 1e-9, friction, True),
            Case(flat, 1.0, 0.3, 0.4 * friction, 1e-9, friction, True),
            Case(flat, 1.0, 0.25, 0.25 * friction, 1e-9, friction, True),
            Case(flat, 1.0, 0.3, 0.2 * friction, math.pi - 1e-9, friction, True),
            Case(flat, 1.0, 0.25, 0.25 * friction, math.pi - 1e-9, friction, True),
        ]
    return found


def hertz_load(a: mp.mpf) -> mp.mpf:
    return mp.pi * a * a / 4


def hertz_half_width(p: mp.mpf) -> mp.mpf:
    return mp.sqrt(4 * p / mp.pi)


def flat_load(b: mp.mpf, a: mp.mpf) -> mp.mpf:
    """The law of the paper's section 4.2 with b^2 in place of a^2 (a misprint there): sin(phi0) = b/a."""
    phi = mp.asin(b / a)
    return a * a * ((mp.pi - 2 * phi) / 4 - mp.sin(phi) * mp.cos(phi) / 2)


def flat_half_width(b: mp.mpf, p: mp.mpf) -> mp.mpf:
    """Newton's method for tau, a = b sqrt(1 + tau^2), from where it converges downhill; dP/dtau = b^2 tau arctan(tau)."""
    tau = mp.cbrt(3 * p / b**2) + mp.sqrt(4 * p / (mp.pi * b**2)) + 1
    for _ in range(200):
        step = (((1 + tau**2) * mp.atan(tau) - tau) / 2 - p / b**2) / (tau * mp.atan(tau))
        tau -= step
        if abs(step) < tau * mp.mpf(10) ** (2 - mp.mp.dps):
            break
    return b * mp.sqrt(1 + tau**2)


def mechanics(flat: float) -> tuple[Callable, Callable, Callable, Callable]:
    """load(a), half_width(p), pressure(x, a), area(P, a, P_c, c) = int ln(a(eta)/c) d eta."""
    if flat == 0:
        return (
            hertz_load,
            hertz_half_width,
            lambda x, a: mp.sqrt(a * a - x * x) / 2,
            lambda p, a, front, c: (p * mp.log(p / front) - p + front) / 2,
        )
    b = mp.mpf(flat)

    def pressure(x: mp.mpf, a: mp.mpf) -> mp.mpf:
        # int alpha arccos(b/alpha)/sqrt(alpha^2 - x^2) over alpha from x (> b here) to a, over the root itself.
        root = mp.sqrt(a * a - x * x)
        m = mp.sqrt(a * a - b * b)
        return (root * mp.acos(b / a) - b * mp.atanh(root / m) + x * mp.atanh(b * root / (x * m))) / mp.pi

    def primitive(a: mp.mpf) -> mp.mpf:
        # int P(alpha)/alpha d alpha from b to a
        tau = mp.sqrt(a * a / (b * b) - 1)
        return b * b / 2 * (((1 + tau**2) * mp.atan(tau) - tau) / 2 - tau + mp.atan(tau))

    def area(p: mp.mpf, a: mp.mpf, front: mp.mpf, c: mp.mpf) -> mp.mpf:
        return p * mp.log(a / c) - primitive(a) + primitive(c)

    return (lambda a: flat_load(b, a) if a > b else mp.mpf(0)), (lambda p: flat_half_width(b, p)), pressure, area


def half_width_of(case: Case, load: float) -> mp.mpf:
    """a(P) of a case."""
    return mechanics(case.flat)[1](mp.mpf(load))


class Phase(NamedTuple):
    """A phase of slip: times of begin and end, rate of u or v, load at the front, and when a load P_x is passed by the front."""

    begin: mp.mpf
    end: mp.mpf
    rate: Callable
    front: Callable
    passed: Callable


def phases(case: Case) -> tuple[Callable, list[Phase]]:
    """P(t), and the three phases of slip E-G, I-J, J-M of the steady cycle (0 < phase < 180 degrees, Q0 = 0)."""
    p0, p1, q1, f = (mp.mpf(v) for v in (case.mean, case.amplitude, case.tangential, case.friction))
    phase = mp.mpf(case.phase) * (1 if case.radians else mp.pi / 180)
    z_u, z_v = q1 * mp.expj(-phase) - f * p1, q1 * mp.expj(-phase) + f * p1
    t_e, size_u, size_v = -mp.arg(z_u), abs(z_u), abs(z_v)
    t_g = -mp.arg(z_v) + mp.pi
    while t_g < t_e:
        t_g += 2 * mp.pi
    while t_g > t_e + 2 * mp.pi:
        t_g -= 2 * mp.pi
    t_i, t_m = t_e + mp.pi, t_e + 2 * mp.pi
    t_j = 2 * t_i - t_g
    u_max, v_min = size_u - f * p0, f * p0 - size_v

    def load(t: mp.mpf) -> mp.mpf:
        return p0 + p1 * mp.cos(t)

    def time_of(cosine: mp.mpf, peak: mp.mpf, after: mp.mpf) -> mp.mpf:
        """The time in [after, after + pi] with cos(t - peak) = cosine, `after` being an extremum of it."""
        if not -1 <= cosine <= 1:
            return after if (mp.cos(after - peak) > 0) == (cosine > 0) else after + mp.pi
        return after + (mp.acos(cosine) if mp.cos(after - peak) > 0 else mp.pi - mp.acos(cosine))

    def mirrored(px: mp.mpf) -> mp.mpf:
        cosine = (px - p0) / p1
        bottom = mp.pi * mp.nint(t_g / mp.pi)
        bottom += 0 if mp.cos(bottom) < 0 else (mp.pi if bottom < t_g else -mp.pi)
        return 2 * t_i - (bottom + mp.acos(-min(max(cosine, -1), 1)))

    return load, [
        Phase(
            t_e,
            t_g,
            lambda t: size_v * abs(mp.sin(t - t_g)),
            lambda t: (f * p0 - size_v * mp.cos(t - t_g) - u_max) / (2 * f),
            lambda px: time_of((f * p0 - u_max - 2 * f * px) / size_v, t_g, t_g - mp.pi),
        ),
        Phase(t_i, t_j, lambda t: size_u * abs(mp.sin(t - t_e)), lambda t: load(2 * t_i - t), mirrored),
        Phase(
            t_j,
            t_m,
            lambda t: size_u * abs(mp.sin(t - t_e)),
            lambda t: (v_min + f * p0 - size_u * mp.cos(t - t_e)) / (2 * f),
            lambda px: time_of((v_min + f * p0 - 2 * f * px) / size_u, t_e, t_i),
        ),
    ]


def dissipation(case: Case) -> mp.mpf:
    """Global dissipation of a steady cycle."""
    _, half_width, _, area = mechanics(case.flat)
    load, parts = phases(case)

    def power(part: Phase, t: mp.mpf) -> mp.mpf:
        p, front = load(t), part.front(t)
        return part.rate(t) * area(p, half_width(p), front, half_width(front)) if 0 < front < p else mp.mpf(0)

    total = sum(mp.quad(lambda t, part=part: power(part, t), _graded(part.begin, part.end, case.radians)) for part in parts)
    return mp.mpf(case.friction) * 2 / mp.pi * total


def _graded(begin: mp.mpf, end: mp.mpf, towards_ends: bool) -> list[mp.mpf]:
    """Ends and places in between; for the extremes ever closer to both ends."""
    if not towards_ends:
        return mp.linspace(begin, end, 4)
    steps = [(end - begin) * mp.mpf(10) ** -k / 2 for k in range(0, 14, 2)]
    return [begin, *(begin + step for step in reversed(steps)), *(end - step for step in steps[1:]), end]


def density(case: Case, x: mp.mpf) -> mp.mpf:
    """Dissipation of a steady cycle per unit area at x."""
    load_of, half_width, pressure, _ = mechanics(case.flat)
    load, parts = phases(case)
    edge = load_of(x)
    cosine = (edge - case.mean) / mp.mpf(case.amplitude)
    meets = [sign * mp.acos(cosine) + 2 * mp.pi * k for sign in (1, -1) for k in range(-2, 4)] if abs(cosine) < 1 else []
    total = mp.mpf(0)
    for part in parts:
        inside = [t for t in (*meets, part.passed(edge)) if part.begin < t < part.end]
        inside += [mp.pi * k for k in range(-2, 6) if part.begin < mp.pi * k < part.end]
        marks = [part.begin, *sorted(inside), part.end]
        for begin, end in itertools.pairwise(marks):
            middle = (begin + end) / 2
            if part.front(middle) < edge < load(middle):
                total += mp.quad(lambda t, part=part: _density_rate(part, t, x, load, half_width, pressure), [begin, middle, end])
    return mp.mpf(case.friction) * 2 / mp.pi * total


def _density_rate(part: Phase, t: mp.mpf, x: mp.mpf, load: Callable, half_width: Callable, pressure: Callable) -> mp.mpf:
    a, c = half_width(load(t)), half_width(part.front(t))
    return pressure(x, a) * part.rate(t) * mp.acosh(x / c) if c < x < a else mp.mpf(0)


def record(case: Case) -> dict[str, object]:
    """One entry of the table: the case, its global dissipation, and the pointwise one at three places of the slip zone."""
    mp.mp.dps = DIGITS + 8
    _, half_width, _, _ = mechanics(case.flat)
    _, parts = phases(case)
    inner, outer = half_width(parts[0].front(parts[0].end)), half_width(mp.mpf(case.mean) + mp.mpf(case.amplitude))
    places = [float(inner + (outer - inner) * mp.mpf(part)) for part in ("0.25", "0.6", "0.9")]
    return {
        **case._asdict(),
        "dissipation": mp.nstr(dissipation(case), DIGITS),
        "x": places,
        "density": [mp.nstr(density(case, mp.mpf(x)), DIGITS) for x in places],
    }


def extreme_record(case: Case) -> dict[str, object]:
    """One entry of the second half of the table: the global dissipation only, in many more digits on the way."""
    mp.mp.dps = 3 * DIGITS
    return {**case._asdict(), "dissipation": mp.nstr(dissipation(case), DIGITS)}


def main() -> None:
    with ProcessPoolExecutor() as pool:
        rows = [*pool.map(record, cases()), *pool.map(extreme_record, extremes())]
    FILE.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
