"""Cases of numerical stress for the half-plane engine."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import mpmath
import numpy as np
from semi_analytic_extremes import TABLE, batch, classes
from stress_case import Case, Trial, ellipse, like, scene_of, to_and_fro

import semi_analytic
from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    PowerLaw,
    Profile,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
    load_scene,
)
from semi_analytic.contact import contact_of
from semi_analytic.friction_work import global_dissipation
from semi_analytic.route import own_route

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


def mindlin(share: mpmath.mpf, friction: float, load: float = 1.0) -> mpmath.mpf:
    """W of a cycle of Q between +-share f P at constant P, E* = 1; finite at share = 1."""
    with mpmath.workdps(60):
        k = mpmath.mpf(share)
        log = (1 - k) * mpmath.log(1 - k) if k < 1 else mpmath.mpf(0)
        return 4 * (mpmath.mpf(friction) * load) ** 2 / mpmath.pi * (log + k - k * k / 2)


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
    units = {"pressure": stress, "shear": stress, "slip": length, "rigid_shift": length, "rigid_approach": length}
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


def unloading(left: float) -> float:
    """P0 - P1 = `left` P0 with Q in proportion to P up to the limit's half: W is that of the open loop's two routes."""
    scene = scene_of(ellipse(1.0, 1 - left, 0.0, 0.2 * left, 90.0), 0.5)
    answer = semi_analytic.solve(scene, x=[0.0])
    certificates = max(float(np.max(values)) for values in answer.record.certificates.values())
    marched = semi_analytic.solve(
        scene, x=[0.0], time=scene.load.path().cycle_start + np.linspace(0, 4 * np.pi, 4001), straight_steps=True
    )
    return certificates if marched.dissipation >= 0 else float("nan")


def tangent(friction: float, beyond: float) -> float:
    """W/(f P0)^2 over what may slip, of a line dQ/dP = f (1 + beyond)."""
    work = semi_analytic.solve(scene_of(ellipse(2, 1, 0.1 * friction, friction * (1 + beyond), 0), friction), x=[0.0]).dissipation
    return work / friction**2 / max(beyond, 2e-16 if beyond else 1e-300) if work else 0.0


def tangent_trials() -> Iterator[Trial]:
    for friction in (1e-6, 1 / 3, 1.0, 100.0):
        for beyond in (-1e-12, -1e-15, 0.0, 2e-16, 1e-15, 1e-12):
            yield f"f = {friction:g}, e = {beyond:g}", partial(tangent, friction, beyond)


def flat_face(part: float) -> float:
    """W of a flat face with b/a = part at the largest load: the formulas of ellipses against the slip areas of its spans."""
    profile = FlatRounded(radius=1.0, flat_half_length=part)
    contact = contact_of(profile, like())
    load = float(contact.load(1.0))
    scene = scene_of(ellipse(0.75 * load, 0.25 * load, 0, 0.2 * load, 70), 0.5, profile)
    answer = semi_analytic.solve(scene, x=[0.0])
    spans = own_route(scene.load.path(), 0.5, scene.cycles, None).history.cycles[-1]
    certificates = max(float(np.max(values)) for values in answer.record.certificates.values())
    return max(abs(float(global_dissipation(contact, 1.0, spans).total) / answer.dissipation - 1), certificates)


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


def wave(count: int, noise: float = 0.0, repeats: bool = False) -> np.ndarray:
    """Rows of a wave of 400 rows a period, with noise, clipped inside the cone."""
    rng, phase = np.random.default_rng(1), 2 * np.pi * np.arange(count) / 400
    normal = 3 + np.cos(phase) + noise * rng.standard_normal(count)
    force = 0.8 * np.cos(phase - 1.2) + noise * rng.standard_normal(count)
    rows = np.column_stack([np.arange(count), normal, np.clip(force, -0.45 * normal, 0.45 * normal)])
    if repeats:
        rows[-1, 1:] = rows[0, 1:]
    return rows


def of_rows(rows: np.ndarray, repeats: bool = False) -> float:
    """Worst mismatch of M(P) = Q and the cone over all rows."""
    scene = scene_of(TimeSeriesLoad(rows=rows, repeats=repeats))
    answer = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",))
    worst = max(float(np.max(values)) for values in answer.record.certificates.values())
    return worst if np.isfinite(answer.dissipation) and answer.dissipation > 0 else float("nan")


def row_trials() -> Iterator[Trial]:
    for count, noise in ((100_001, 0.0), (1_000_001, 0.0), (1_000_001, 0.01)):
        yield f"{count} rows, noise {noise:g}", lambda count=count, noise=noise: of_rows(wave(count, noise))
    held = wave(1_000_001)
    held[1000:300_000, 1:] = held[1000, 1:]
    yield "300,000 rows that repeat the same loads", partial(of_rows, held)
    yield "10^5 rows again and again", lambda: of_rows(wave(100_001, 0.01, True), True)


def from_file(change: Callable[[np.ndarray], None]) -> float:
    """A million rows from a CSV file with a fault in it, through the door that everybody uses."""
    rows = wave(1_000_001)
    change(rows)
    with tempfile.TemporaryDirectory() as folder:
        np.savetxt(Path(folder) / "loads.csv", rows, delimiter=",", fmt="%.9g")
        text = (
            'profile = {kind = "hertz", radius = 100}\nmaterial = {young_modulus = 2, poisson_ratio = 0}\n'
            'friction = {coefficient = 0.5}\nload = {kind = "time_series", file = "loads.csv"}\n'
        )
        (Path(folder) / "scene.toml").write_text(text, encoding="utf-8")
        try:
            scene = load_scene(Path(folder) / "scene.toml")
        except InputError as reason:
            raise InputError(str(reason).replace(f"{folder}/", "")) from reason
    return float(semi_analytic.solve(scene, x=[0.0], fields=("dissipation",)).dissipation)


def bad_row_trials() -> Iterator[Trial]:
    def nan(rows: np.ndarray) -> None:
        rows[500_000, 1] = np.nan

    def unsorted(rows: np.ndarray) -> None:
        rows[[400, 500_000]] = rows[[500_000, 400]]

    def twice(rows: np.ndarray) -> None:
        rows[777] = rows[776]

    for fault in (nan, unsorted, twice):
        yield fault.__name__, partial(from_file, fault)


def spike() -> float:
    rows = wave(1_000_001)
    rows[5000, 2] = 9.0
    return of_rows(rows)


def cases() -> Iterator[Case]:
    """All of them."""

    def case(what: str, tried: str, measure: str, limit: float, trials: Callable[[], Iterator[Trial]], **further: bool) -> Case:
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
        "cone and M(P) = Q, over f P",
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
    yield case("flat face", "b/a = 1e-9 ... 1 - 1e-9", "W by formula against slip areas, and cone", 1e-10, flat_trials)
    yield case(
        "step sizes",
        "1, 2, 10, 100, 1000, 10^4 straight steps a cycle",
        "n² times the error of W (second order)",
        8.0,
        lambda: ((f"{n}", partial(steps, n)) for n in (1, 2, 10, 100, 1000, 10_000)),
    )
    yield case(
        "long histories",
        "10^5 and 10^6 rows, smooth, noisy, with repeats, again and again",
        "cone and M(P) = Q, over f P",
        1e-12,
        row_trials,
    )
    yield case(
        "bad histories",
        "10^6 rows from CSV: a NaN, a row out of order, a time twice",
        "refused",
        0.0,
        bad_row_trials,
        may_refuse=True,
        must_refuse=True,
    )
    yield case("a spike", "one of 10^6 rows slides", "refused", 0.0, lambda: [("spike", spike)], may_refuse=True, must_refuse=True)
