"""Cases of numerical stress for the half-plane engine."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial

import mpmath
import numpy as np
import regress_truth
import semi_analytic_reference as reference
from semi_analytic_extremes import TABLE, batch, classes
from stress_case import Case, Found, Trial, broken_by, ellipse, like, mindlin, scene_of, to_and_fro

import semi_analytic
from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    PowerLaw,
    Profile,
    Scene,
    Tabulated,
    Wedge,
)
from semi_analytic.friction_work import global_dissipation
from semi_analytic.history import history_of
from semi_analytic.profiles import contact_of

ENGINE = "Half-plane engine"
_X = np.linspace(0, 4, 61)
PROFILES: dict[str, Callable[[float], Profile]] = {
    "hertz": lambda unit: Hertz(radius=unit),
    "flat_rounded": lambda unit: FlatRounded(radius=unit, flat_half_length=0.7 * unit),
    "power_law": lambda unit: PowerLaw(exponent=1.5, length=unit, rise=0.5 * unit),
    "compound": lambda unit: Compound(inner_radius=unit, outer_radius=0.4 * unit, inner_half_length=0.8 * unit),
    "wedge": lambda unit: Wedge(tip_radius=unit, tip_half_length=0.7 * unit),
    "polynomial": lambda unit: EvenPolynomial(length=unit, rises=(0.5 * unit, 0.1 * unit)),
    "tabulated": lambda unit: Tabulated(points=np.column_stack([unit * _X, unit * (np.cosh(_X) - 1)]).tolist()),
    "callable": lambda unit: CallableProfile(slope_function=lambda x: np.sinh(x / unit), extent=4 * unit),
}
"""Every kind of profile in units of length `unit`."""


def of_mindlin(share: float, friction: float, told: bool = False) -> float:
    """Relative error of W; over what the engine says of it with `told`."""
    scene = scene_of(to_and_fro(share, friction), friction)
    answer = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",))
    exact = mindlin(min(mpmath.mpf(share * friction) / mpmath.mpf(friction), 1), friction)
    error = abs(float(answer.dissipation / exact - 1))
    return error / answer.record.errors["dissipation"] if told else error


def in_units(kind: str, length: float, stress: float) -> float:
    """Worst change of any dimensionless field, over its largest value."""
    x, amounts = np.linspace(-2.6, 2.6, 41), np.array([3.0, 1.0, 0.2, 0.8])
    answers = []
    for l, s in ((1.0, 1.0), (length, stress)):  # noqa: E741
        scene = scene_of(ellipse(*(amounts * l * s), 70.0), 0.5, PROFILES[kind](l), like(s))
        answers.append(semi_analytic.solve(scene, x=x * l))
    one, other = answers
    units = {"pressure": stress, "shear": stress, "slip": length, "tangential_displacement": length, "normal_approach": length}
    units |= {"contact_half_width": length, "stick_half_width": length, "dissipation_density": length * stress}
    errors = [
        float(np.nanmax(np.abs(getattr(other, n) / u - getattr(one, n))) / np.nanmax(np.abs(getattr(one, n))))
        for n, u in units.items()
    ]
    errors.append(abs(other.dissipation / (length**2 * stress) / one.dissipation - 1))
    return max(errors) if np.array_equal(one.state, other.state) else float("nan")


def unit_trials() -> Iterator[Trial]:
    for kind in PROFILES:
        for length, stress in ((1e-12, 1e-12), (1e12, 1e12), (1e-12, 1e12), (1e12, 1e-12)):
            yield f"{kind}, lengths {length:g}, stresses {stress:g}", partial(in_units, kind, length, stress)


def friction_trials() -> Iterator[Trial]:
    for friction in (1e-6, 1e-3, 1.0, 100.0):
        for share in (0.3, 0.9):
            yield f"f = {friction:g}, {share:g} f P", partial(of_mindlin, share, friction)


def in_proportion(friction: float) -> float:
    """W/f^2 of a loop whose Q is in proportion to f, less that of f = 1."""
    works = [
        semi_analytic.solve(scene_of(ellipse(3, 1, 0.4 * f, 1.6 * f, 70), f), x=[0.0], fields=("dissipation",)).dissipation / f**2
        for f in (1.0, friction)
    ]
    return abs(works[1] / works[0] - 1)


def sliding_trials() -> Iterator[Trial]:
    for left in (1e-6, 1e-9, 1e-12, 1e-15, 0.0):
        yield f"1 - {left:g}", partial(of_mindlin, 1 - left, 0.5)


def tiny_trials() -> Iterator[Trial]:
    for power in range(4, 15):
        yield f"1e-{power}", partial(of_mindlin, 10.0**-power, 0.3, True)


def table_trials(name: str) -> Iterator[Trial]:
    table = [row for row in json.loads(TABLE.read_text(encoding="utf-8")) if row["radians"]]
    for k, row in enumerate(classes(table)[name]):
        yield f"{name}, {k}", lambda row=row: abs(batch(row) / float(row["dissipation"]) - 1)


def digits(scene: Scene) -> float:
    """W of the steady ellipse by the one-dimensional integrals in 50 digits, on a profile of `regress_truth.PILES`."""
    with mpmath.workdps(50):
        return float(regress_truth.steady_ellipse(scene, mpmath.mpf(scene.friction.coefficient)))


def unloading(left: float) -> Found:
    """P0 - P1 = `left` P0 with Q in proportion to P up to the limit's half: W against 60 digits; Q dU beside it."""
    scene = scene_of(ellipse(1.0, 1 - left, 0.0, 0.2 * left, 90.0), 0.5)
    answer = semi_analytic.solve(scene, x=[0.0])
    load = scene.load
    row = reference.Case(0.0, 1.0, load.normal_amplitude, load.tangential_amplitude, math.pi / 2, 0.5, True)
    with mpmath.workdps(60):
        exact = float(reference.dissipation(row._replace(phase=mpmath.pi / 2)))
    return Found(
        {"W": abs(answer.dissipation / exact - 1), "cone and M(P) = Q, over f P": broken_by(answer)},
        shown={"∮Q dU": abs(answer.loop_work / exact - 1)},
    )


def tangent(friction: float, beyond: float) -> float:
    """W/(f P0)^2 over what may slip, of a line dQ/dP = f (1 + beyond)."""
    work = semi_analytic.solve(scene_of(ellipse(2, 1, 0.1 * friction, friction * (1 + beyond), 0), friction), x=[0.0]).dissipation
    return work / friction**2 / max(beyond, 2e-16 if beyond else 1e-300) if work else 0.0


def tangent_trials() -> Iterator[Trial]:
    for friction in (1e-6, 1 / 3, 1.0, 100.0):
        for beyond in (-1e-12, -1e-15, 0.0, 2e-16, 1e-15, 1e-12):
            yield f"f = {friction:g}, e = {beyond:g}", partial(tangent, friction, beyond)


def flat_face(part: float) -> Found:
    """A flat face with b/a = part at the largest load: W by formula, by slip areas and by Q dU, against 50 digits."""
    profile = FlatRounded(radius=1.0, flat_half_length=part)
    contact = contact_of(profile, like())
    load = float(contact.load(1.0))
    scene = scene_of(ellipse(0.75 * load, 0.25 * load, 0, 0.2 * load, 70), 0.5, profile)
    answer = semi_analytic.solve(scene, x=[0.0])
    spans = history_of(scene.load.path(), 0.5, scene.cycles).cycles[-1]
    exact, areas = digits(scene), float(global_dissipation(contact, 1.0, spans).total)
    works = {"W": answer.dissipation, "slip areas": areas, "∮Q dU": answer.loop_work}
    off = {name: abs(work / exact - 1) for name, work in works.items()}
    return Found({**off, "cone": broken_by(answer)})


def flat_trials() -> Iterator[Trial]:
    for part in (1e-9, 1e-6, 1e-3, 0.9, 0.999, 1 - 1e-6, 1 - 1e-9):
        yield f"b/a = {part:g}", partial(flat_face, part)


def steps(count: int) -> float:
    """n^2 (W/W_exact - 1) of the polygon of n steps a cycle; 1 for 1 and 2 steps, which have next to no loop."""
    scene = scene_of(ellipse(3, 1, 0.2, 0.8, 70))
    exact = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",)).dissipation
    start = scene.load.path().cycle_start
    times = start + 2 * np.pi * np.arange(3 * count + 1) / count
    rough = semi_analytic.solve(scene, x=[0.0], time=times, fields=("dissipation",), straight_steps=True).dissipation
    return count**2 * abs(rough / exact - 1)


def cases() -> Iterator[Case]:
    """All of them."""

    def case(what: str, tried: str, measure: str, limit: float, trials: Callable[[], Iterable[Trial]], **further: bool) -> Case:
        return Case(ENGINE, what, tried, measure, limit, trials, **further)

    yield case(
        "units",
        "lengths and stresses times 1e-12 and 1e12, eight kinds of profile",
        "any field over its largest value, any state",
        1e-12,
        unit_trials,
    )
    yield case("friction", "f = 1e-6, 1e-3, 1, 100; Q to 0.3 and 0.9 f P", "W against the closed form", 1e-12, friction_trials)
    yield case(
        "friction, ellipse",
        "f = 1e-6 to 100, Q in proportion",
        "W/f² against that of f = 1",
        1e-12,
        lambda: ((f"{f:g}", partial(in_proportion, f)) for f in (1e-6, 1e-3, 100.0)),
    )
    yield case("near gross sliding", "1e-6 to 1e-15 of f P left, and none", "W against the closed form", 1e-12, sliding_trials)
    yield case(
        "next to no slip", "Q to 1e-4 ... 1e-14 of f P, a polygon", "error of W over the error that is told", 1.0, tiny_trials
    )
    for name in (
        "slip of 1e-9 to 1e-6 of f P",
        "1 - 1e-12 of gross sliding",
        "P1/P0 = 1 - 1e-9",
        "within 1e-9 of phase 0 or pi",
        "the same at tangency, dQ/dP = +-f",
    ):
        yield case(f"ellipses: {name}", "stored table, batch", "W against 30 digits", 1e-10, partial(table_trials, name))
    yield case(
        "next to no load",
        "P_min/P0 = 1e-3, 1e-6, 1e-9, 1e-12",
        "W against 60 digits; cone; in brackets the second route, whose rounding is told",
        1e-12,
        lambda: ((f"{left:g}", partial(unloading, left)) for left in (1e-3, 1e-6, 1e-9, 1e-12)),
    )
    yield case(
        "tangency within rounding",
        "dQ/dP = f (1 + e), e = -1e-12 ... 1e-12, f from 1e-6 to 100",
        "W over e f² P², 0 for e ≤ 0",
        1.0,
        tangent_trials,
    )
    yield case(
        "flat face", "b/a = 1e-9 ... 1 - 1e-9", "W, slip areas and closed integral against 50 digits; cone", 1e-10, flat_trials
    )
    yield case(
        "step sizes",
        "1, 2, 10, 100, 1000, 10^4 straight steps a cycle",
        "n² times the error of W (second order)",
        8.0,
        lambda: ((f"{n}", partial(steps, n)) for n in (1, 2, 10, 100, 1000, 10_000)),
    )
