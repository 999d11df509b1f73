"""Regression of the half-plane engine by itself, without FE: every scene of the library, in seconds.

    make regress                             (python benchmarks/regress.py)
    make regress ACCEPT="hertz-paper ..."    take the new values of the named scenes for frozen ones
    make regress REFERENCES=1                evaluate the 30-digit references anew (some minutes)

Dissipation has a reference in every scene, W(x) at three places of the slip zone in the Hertz scenes POINTWISE.

Two columns, kept apart: *accurate* is the difference from a closed form or a stored 30-digit value, of somebody else's making;
*frozen* is the difference from our own value of last time. A change of either is shown as old, new and difference, and is accepted
by name only. Exit code 1 where something changed or is not accurate.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import exact_history as history
import mpmath as mp
from exact_legs import Leg, Straight, legs_of
from exact_memory import steady_runs
from semi_analytic_reference import Case, Phase, flat_load, phases

import semi_analytic
from scenes import Scene, load_scene, scene_names

FILE = Path(__file__).with_suffix(".json")
DIGITS = 30
# Relative; the frozen values were made by this very code, so only rounding may differ (another order of sums, another library).
ACCURATE, SAME = 1e-12, 1e-13
DENSE = 1e-11  # of the largest of W(x)
POINTWISE = ("cattaneo-mindlin", "harmonics", "near-sliding", "time-series", "tiny-slip")
PLACES = (0.25, 0.6, 0.9)
QUANTITIES = ("dissipation", "permanent_stick_half_width", "largest_half_width", "largest_pressure", "stroke")


@dataclass(frozen=True)
class Line:
    """One quantity of one scene: value now, frozen value, and the reference where there is one.

    `scale` is what the error is relative to, None for the value itself.
    """

    scene: str
    quantity: str
    value: float
    frozen: float | None
    reference: str | None
    scale: float | None = None

    @property
    def drift(self) -> float | None:
        """Relative difference from the frozen value."""
        return None if self.frozen is None else self._off(self.frozen)

    @property
    def error(self) -> float | None:
        """Relative difference from the reference."""
        return None if self.reference is None else self._off(mp.mpf(self.reference))

    def _off(self, other: float | mp.mpf) -> float:
        return float(abs(self.value - other)) / self.scale if self.scale else _apart(self.value, other)

    @property
    def good(self) -> bool:
        limit = DENSE if self.scale else ACCURATE
        return (self.error is None or self.error <= limit) and self.drift is not None and self.drift <= SAME


def _apart(value: float, other: float | mp.mpf) -> float:
    if math.isnan(value) and mp.isnan(other):
        return 0.0
    return float(abs(value - other) / max(abs(value), abs(other))) if value != other else 0.0


def measure(scene: Scene) -> dict[str, float]:
    """The quantities of a scene by the engine."""
    answer = semi_analytic.solve(scene, x=[0.0, 1e-3, 1.0])
    full = semi_analytic.solve(scene)
    return {
        "dissipation": answer.dissipation,
        "permanent_stick_half_width": answer.permanent_stick_half_width,
        "largest_half_width": float(full.contact_half_width.max()),
        "largest_pressure": float(answer.pressure.max()),
        "stroke": float(full.rigid_shift.max() - full.rigid_shift.min()),
    }


def truth(scene: Scene) -> mp.mpf | None:
    """Dissipation of the last cycle with 30 digits: a closed form, else integrals over time; None where there is no way yet."""
    load, f = scene.load, mp.mpf(scene.friction.coefficient)
    if (closed := _constant_load(scene, f)) is not None:
        return closed
    if load.kind == "ellipse" and load.phase_degrees in (0.0, 180.0, -180.0):
        return mp.mpf(0) if _in_proportion(scene) else None
    if load.kind == "ellipse" and scene.profile.kind in PILES:
        return _steady_ellipse(scene, f)
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


def _straight(points: list[tuple[float, float]], closed: bool = False) -> list[Straight]:
    exact = [(mp.mpf(p), mp.mpf(q)) for p, q in points]
    return [Straight(a, b) for a, b in pairwise([*exact, *exact[:closed]]) if a != b]


def _waves(load: object, normal: list, tangential: list) -> tuple[list[Leg], list[Leg]]:
    return legs_of((load.mean_normal_load, load.mean_tangential_load), normal, tangential)


LEGS: dict[str, Callable] = {
    "harmonics": lambda load: _waves(load, load.normal_harmonics, load.tangential_harmonics),
    "ellipse": lambda load: _waves(load, [(load.normal_amplitude, 0.0)], [(load.tangential_amplitude, load.phase_degrees)]),
    "polygon": lambda load: (_straight([(0.0, 0.0), *load.way_in, *load.cycle[:1]]), _straight(list(load.cycle), closed=True)),
    "time_series": lambda load: (_straight(load.series()[:, 1:].tolist()), []),
}
"""Way in and cycle of each kind of load, in mpmath."""


def _in_proportion(scene: Scene) -> bool:
    """Whether P and Q rise and fall together along one ray from the origin, in full stick."""
    load, f = scene.load, scene.friction.coefficient
    ratio = load.mean_tangential_load / load.mean_normal_load
    return abs(load.tangential_amplitude - ratio * load.normal_amplitude) < 1e-12 * load.normal_amplitude and abs(ratio) < f


def _constant_load(scene: Scene, f: mp.mpf) -> mp.mpf | None:
    """Hertz, constant P, Q between +-k f P: W = (4 f^2 P^2/(pi E*)) [(1-k) ln(1-k) + k - k^2/2]; nothing where Q stays 0."""
    load = scene.load
    if load.kind == "polygon":
        points = [*load.way_in, *load.cycle]
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


def _steady_ellipse(scene: Scene, f: mp.mpf) -> mp.mpf:
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


def references(names: Sequence[str], stored: dict[str, dict]) -> None:
    """Evaluate the 30-digit references of the named scenes and store each."""
    mp.mp.dps = DIGITS + 10
    for name in names:
        scene = load_scene(name)
        value = truth(scene)
        print(f"{name}: {'none' if value is None else mp.nstr(value, 15)}", flush=True)
        kept = stored.setdefault(name, {})
        kept.update({} if value is None else {"reference": mp.nstr(value, DIGITS)})
        kept.update(pointwise_truth(scene) if name in POINTWISE else {})
        write(stored)


def write(stored: dict[str, dict]) -> None:
    """The table, sorted by scene."""
    FILE.write_text(json.dumps(dict(sorted(stored.items())), indent=1) + "\n", encoding="utf-8")


def lines(stored: dict[str, dict]) -> list[Line]:
    """Every quantity of every scene, beside what is stored."""
    found = []
    for name in scene_names():
        scene, kept = load_scene(name), stored.get(name, {})
        values, frozen = measure(scene), kept.get("frozen", {})
        for quantity in QUANTITIES:
            reference = kept.get("reference") if quantity == "dissipation" else None
            found.append(Line(name, quantity, values[quantity], frozen.get(quantity), reference))
        if "x" in kept:
            density = semi_analytic.solve(scene, x=kept["x"], fields=("dissipation_density",)).dissipation_density.tolist()
            largest = max(float(value) for value in kept["density"])
            for part, value, reference in zip(PLACES, density, kept["density"], strict=True):
                quantity = f"density at {part}"
                found.append(Line(name, quantity, value, frozen.get(quantity), reference, largest))
    return found


def show(found: list[Line]) -> None:
    """Print the table; a changed value as old, new and difference."""
    print(f"{'scene':24} {'quantity':28} {'value':>24}  {'accurate':>9}  {'frozen':>9}")
    for line in found:
        error = "-" if line.error is None else f"{line.error:.1e}"
        drift = "new" if line.drift is None else f"{line.drift:.1e}"
        print(f"{line.scene:24} {line.quantity:28} {line.value:24.17g}  {error:>9}  {drift:>9}  {'' if line.good else '<<'}")
        if line.drift is not None and line.drift > SAME:
            print(f"    old {line.frozen!r}, new {line.value!r}, difference {line.value - (line.frozen or 0.0):.3g}")


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    arguments.add_argument(
        "--accept", nargs="*", default=[], metavar="SCENE", help="scenes whose new values become the frozen ones"
    )
    arguments.add_argument(
        "--references", nargs="*", metavar="SCENE", help="evaluate the 30-digit references anew, of all scenes or of those named"
    )
    asked = arguments.parse_args()
    if unknown := {*asked.accept, *(asked.references or ())} - set(scene_names()):
        print(f"regress: no such scene: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    stored = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    if asked.references is not None:
        references(asked.references or scene_names(), stored)
    mp.mp.dps = DIGITS + 10
    found = lines(stored)
    for name in asked.accept:
        stored.setdefault(name, {})["frozen"] = {line.quantity: line.value for line in found if line.scene == name}
    if asked.accept:
        write(stored)
        found = lines(stored)
    show(found)
    bad = [line for line in found if not line.good]
    print(f"{len(found)} values of {len(scene_names())} scenes, {len(bad)} changed or not accurate")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
