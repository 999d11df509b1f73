"""Dissipation of the library's scenes with 30 digits, W(x) and the fields of Hertz scenes: what `regress` stores as references."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import exact_history as history
import mpmath as mp
from exact_legs import LoadSegment, Number, Straight, legs_of, root
from exact_memory import Curve, Run, follow, steady_runs
from semi_analytic_reference import Case, Phase, flat_load, phases

from scenes import Scene

DIGITS = 30
PLACES = (0.25, 0.6, 0.9)


def truth(scene: Scene) -> mp.mpf | None:
    """Dissipation of the last cycle with 30 digits: a closed form, else integrals over time; None where there is no way yet."""
    load, f = scene.load, mp.mpf(scene.friction.coefficient)
    if (closed := _constant_load(scene, f)) is not None:
        return closed
    line = load.kind == "ellipse" and load.phase_degrees in (0.0, 180.0, -180.0)
    if line and _in_proportion(scene):
        return mp.mpf(0)
    if load.kind == "ellipse" and not line and scene.profile.kind in PILES:
        return steady_ellipse(scene, f)
    if scene.profile.kind != "hertz" or load.kind not in LEGS:
        return None
    contact = history.hertz(modulus(scene), mp.mpf(scene.profile.radius))
    return history.dissipation(steady_runs(*LEGS[load.kind](load), f), contact, f, modulus(scene))


def pointwise_truth(scene: Scene) -> dict[str, list]:
    """W(x) at three places of the slip zone of a Hertz scene, 30 digits, by the memory curve in mpmath."""
    f = mp.mpf(scene.friction.coefficient)
    contact = history.hertz(modulus(scene), mp.mpf(scene.profile.radius))
    runs = steady_runs(*LEGS[scene.load.kind](scene.load), f)
    inner = contact.half_width(min(run.front(f, run.end) for run in runs))
    outer = contact.half_width(max(run.leg.loads(t)[0] for run in runs for t in (run.begin, run.end)))
    places = [float(inner + (outer - inner) * mp.mpf(part)) for part in PLACES]
    values = [history.density(runs, contact, f, modulus(scene), mp.mpf(x)) for x in places]
    return {"x": places, "density": [mp.nstr(value, DIGITS) for value in values]}


FIELDS = ("tangential displacement", "stick half-width", "shear at 1", "shear at 2", "shear at 3", "slip at 3")


def field_truth(scene: Scene, time: float, x: Sequence[float]) -> list[str] | None:
    """The `FIELDS` at one time and three points of a Hertz scene, 30 digits; None for rows, and where there is no friction.

    Of the memory curve M: q = int M'/(pi sqrt(a^2 - x^2)), s = (A/pi) int M' arccosh(x/a), U = (A/pi) int M' ln(2 L/a), each over
    the loads that count, on lines in closed form but for s, on arcs over time.
    """
    load, f = scene.load, mp.mpf(scene.friction.coefficient)
    if scene.profile.kind != "hertz" or load.kind not in ("ellipse", "polygon", "harmonics") or not f:
        return None
    curve, front = _state(scene, time, f)
    radius, datum, e_star = mp.mpf(scene.profile.radius), mp.mpf(scene.profile.datum_length), modulus(scene)
    contact = history.hertz(e_star, radius)
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
                part = primitive(high) - primitive(low) if primitive else mp.quad(kernel, [low, high])
                total += piece.slope * part
            else:
                leg, first, last = piece.arc
                ends = [root(leg, (1, 0), load, first, last) for load in (low, high)]
                total += mp.quad(lambda t, leg=leg: leg.rates(t)[1] * kernel(leg.loads(t)[0]), mp.linspace(*ends, 5))
        return total

    def shear(x: mp.mpf) -> mp.mpf:
        def kernel(p: mp.mpf) -> mp.mpf:
            return 1 / (mp.pi * mp.sqrt(half(p) ** 2 - x * x)) if half(p) > x else mp.mpf(0)

        return whole(kernel, contact.load(x), mp.inf, lambda p: contact.pressure(x, half(p)))

    def slip(x: mp.mpf) -> mp.mpf:
        return whole(lambda p: mp.acosh(max(x / half(p), 1)) if p else mp.mpf(0), mp.mpf(0), contact.load(x))

    def distance(p: mp.mpf) -> mp.mpf:
        return p * (mp.log(2 * datum / half(p)) + mp.mpf(1) / 2) if p else mp.mpf(0)

    scale = 2 / (mp.pi * e_star)
    shift = whole(lambda p: mp.log(2 * datum / half(p)), mp.mpf(0), mp.inf, distance)
    points = [mp.mpf(place) for place in x]
    found = [scale * shift, half(front), *(shear(place) for place in points), scale * slip(points[-1])]
    return [mp.nstr(value, DIGITS) for value in found]


class Parabola(NamedTuple):
    """A initial loading Q = alpha P + beta P^2 to (p, q), where its slope is known; P grows with time from 0 to 1."""

    p: mp.mpf
    q: mp.mpf
    slope: mp.mpf
    begin: mp.mpf = mp.mpf(0)
    end: mp.mpf = mp.mpf(1)

    def loads(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        p, q, slope = self[:3] if lib is mp else map(float, self[:3])
        return p * t, (2 * q - slope * p) * t + (slope * p - q) * t * t

    def rates(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        p, q, slope = self[:3] if lib is mp else map(float, self[:3])
        return p, 2 * q - slope * p + 2 * (slope * p - q) * t

    def turns(self, normal: mp.mpf, tangential: mp.mpf) -> list[mp.mpf]:
        """None: all of it is in full stick."""
        return []


def _state(scene: Scene, time: float, f: mp.mpf) -> tuple[Curve, mp.mpf]:
    """The memory curve at a time, and the load at the edge of stick."""
    path, (initial_loading, cycle) = scene.load.path(), LEGS[scene.load.kind](scene.load)
    if scene.load.kind == "ellipse":  # it starts where Q is least
        begin = mp.mpf(path.cycle_start)
        cycle = [cycle[0]._replace(begin=begin, end=begin + 2 * mp.pi)]
        first = cycle[0].loads(begin)
        initial_loading = [Straight((mp.mpf(0), mp.mpf(0)), first)]
        if scene.load.initial_loading == "parabola":
            p_rate, q_rate = cycle[0].rates(begin)
            initial_loading = [Parabola(*first, q_rate / p_rate)]
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


def _straight(points: list[tuple[float, float]], closed: bool = False) -> list[Straight]:
    exact = [(mp.mpf(p), mp.mpf(q)) for p, q in points]
    return [Straight(a, b) for a, b in pairwise([*exact, *exact[:closed]]) if a != b]


def _waves(load: object, normal: list, tangential: list) -> tuple[list[LoadSegment], list[LoadSegment]]:
    return legs_of((load.mean_normal_load, load.mean_tangential_load), normal, tangential)


LEGS: dict[str, Callable] = {
    "harmonics": lambda load: _waves(load, load.normal_harmonics, load.tangential_harmonics),
    "ellipse": lambda load: _waves(load, [(load.normal_amplitude, 0.0)], [(load.tangential_amplitude, load.phase_degrees)]),
    "polygon": lambda load: (
        _straight([(0.0, 0.0), *load.initial_loading]),
        _straight([load.initial_loading[-1], *load.cycle], closed=True) if load.cycle else [],
    ),
    "time_series": lambda load: (_straight(load.series()[:, 1:].tolist()), []),
}
"""Initial loading and cycle of each kind of load, in mpmath."""


def _in_proportion(scene: Scene) -> bool:
    """Whether P and Q rise and fall together along one ray from the origin, in full stick."""
    load, f = scene.load, scene.friction.coefficient
    ratio = load.mean_tangential_load / load.mean_normal_load
    return abs(load.tangential_amplitude - ratio * load.normal_amplitude) < 1e-12 * load.normal_amplitude and abs(ratio) < f


def _constant_load(scene: Scene, f: mp.mpf) -> mp.mpf | None:
    """Hertz, constant P, Q between +-k f P: W = (4 f^2 P^2/(pi E*)) [(1-k) ln(1-k) + k - k^2/2]; nothing where Q stays 0."""
    load = scene.load
    if load.kind == "polygon":
        points = [*load.initial_loading, *load.cycle]
        if all(q == 0 for _, q in points):
            return mp.mpf(0)
        loads, swing = {p for p, _ in points}, max(abs(mp.mpf(q)) for _, q in points)
    elif load.kind == "ellipse" and load.normal_amplitude == 0:
        loads, swing = {load.mean_normal_load}, mp.mpf(load.tangential_amplitude)
    else:
        return None
    if scene.profile.kind != "hertz" or len(loads) != 1:
        return None
    p = mp.mpf(loads.pop())
    k = swing / (f * p)
    return 4 * f**2 * p**2 / (mp.pi * modulus(scene)) * ((1 - k) * mp.log(1 - k) + k - k**2 / 2)


def modulus(scene: Scene) -> mp.mpf:
    """E*."""
    return 1 / sum(
        (1 - mp.mpf(m.poisson_ratio) ** 2) / mp.mpf(m.young_modulus) for m in (scene.material.lower, scene.material.upper)
    )


# Profiles that are Hertz and a rounded flat laid over each other: curvature of the one and of the other, half-length b.
PILES: dict[str, Callable[[object], tuple[mp.mpf, mp.mpf, mp.mpf]]] = {
    "hertz": lambda p: (1 / mp.mpf(p.radius), mp.mpf(0), mp.mpf(1)),
    "flat_rounded": lambda p: (mp.mpf(0), 1 / mp.mpf(p.radius), mp.mpf(p.flat_half_length)),
    "compound": lambda p: (
        1 / mp.mpf(p.inner_radius),
        1 / mp.mpf(p.outer_radius) - 1 / mp.mpf(p.inner_radius),
        mp.mpf(p.inner_half_length),
    ),
    "wedge": lambda p: (1 / mp.mpf(p.tip_radius), -1 / mp.mpf(p.tip_radius), mp.mpf(p.tip_half_length)),
}


def steady_ellipse(scene: Scene, f: mp.mpf) -> mp.mpf:
    """W = (f A/pi) closed-int |u' or v'| Lam dt over the phases of slip."""
    load, e_star = scene.load, modulus(scene)
    round_, rounded, b = PILES[scene.profile.kind](scene.profile)
    degrees = load.phase_degrees if load.phase_degrees > 0 else load.phase_degrees + 180  # Q mirrored
    case = Case(0.0, load.mean_normal_load, load.normal_amplitude, load.tangential_amplitude, degrees, scene.friction.coefficient)
    normal, parts = phases(case)

    def load_of(a: mp.mpf) -> mp.mpf:
        return e_star * (round_ * mp.pi * a * a / 4 + (rounded * flat_load(b, a) if a > b and rounded else 0))

    def area_below(a: mp.mpf) -> mp.mpf:
        """int P(alpha)/alpha d alpha from 0 to a."""
        total = round_ * mp.pi * a * a / 8
        if a > b and rounded:
            tau = mp.sqrt(a * a / (b * b) - 1)
            total += rounded * b * b / 2 * (((1 + tau**2) * mp.atan(tau) - tau) / 2 - tau + mp.atan(tau))
        return e_star * total

    def half_width(p: mp.mpf) -> mp.mpf:
        low, high = mp.mpf(0) if round_ else b, b
        while load_of(high) < p:
            high *= 2
        return mp.findroot(
            lambda a: load_of(a) - p, (low + (high - low) / 1000, high), solver="anderson", tol=mp.mpf(10) ** -60, maxsteps=200
        )

    def power(part: Phase, t: mp.mpf) -> mp.mpf:
        p, front = normal(t), part.front(t)
        if not 0 < front < p:
            return mp.mpf(0)
        a, c = half_width(p), half_width(front)
        return part.rate(t) * (p * mp.log(a / c) - area_below(a) + area_below(c))

    # P(a) is smooth but for the load at which the edge passes b: cut there, for P and for the front.
    corner = load_of(b)
    cosine = (corner - case.mean) / mp.mpf(case.amplitude)
    passes = [sign * mp.acos(cosine) + 2 * mp.pi * k for sign in (1, -1) for k in range(-2, 4)] if abs(cosine) < 1 else []

    def marks(part: Phase) -> list[mp.mpf]:
        inside = [t for t in (*passes, part.passed(corner)) if part.begin < t < part.end]
        return sorted([*mp.linspace(part.begin, part.end, 4), *inside])

    total = sum(mp.quad(lambda t, part=part: power(part, t), marks(part)) for part in parts)
    return f * 2 / (mp.pi * e_star) * total
