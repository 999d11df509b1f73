"""Claims of the half-plane engine: errors against 30 digits; costs of histories and batches."""

from __future__ import annotations

import functools
import math
import sys
import tempfile
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import mpmath as mp
import numpy as np
from claim import ROOT, Row, in_turn, kept_json, seconds
from regress_truth import DIGITS, TABLE, Case, ellipse_dissipation, mindlin

import semi_analytic
from scenes import (
    CallableProfile,
    Compound,
    Elastic,
    EllipseLoad,
    EvenPolynomial,
    FlatRounded,
    Friction,
    Hertz,
    Materials,
    PowerLaw,
    Profile,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
    load_scene,
)
from semi_analytic.profiles import Contact, contact_of

sys.path.insert(0, str(ROOT / "tests"))
from semi_analytic import grid as dense_grid


def like(e_star: float, poisson_ratio: float = 0.0) -> Materials:
    """Like bodies with that E*."""
    body = Elastic(young_modulus=2 * e_star * (1 - poisson_ratio**2), poisson_ratio=poisson_ratio)
    return Materials(upper=body, lower=body)


# ----------------------------------------------------------------------------------------------------------------- extremes
def table_of_ellipses(extremes: bool) -> list[dict[str, Any]]:
    """The 41 ellipses of the table of references, or its 22 extremes."""
    return [row for row in kept_json(TABLE) if row["radians"] == extremes]


def profile_of(flat: float) -> Profile:
    """R = 1; a flat of half-length `flat` with rounded edges, or a parabola."""
    return FlatRounded(radius=1.0, flat_half_length=flat) if flat else Hertz(radius=1.0)


def batch(row: dict[str, Any]) -> float:
    """Dissipation of a row of the table, E* = 1."""
    found = semi_analytic.dissipation(
        profile=profile_of(row["flat"]),
        material=like(1.0),
        friction_coefficient=row["friction"],
        mean_normal_load=row["mean"],
        normal_amplitude=row["amplitude"],
        mean_tangential_load=0.0,
        tangential_amplitude=row["tangential"],
        phase=row["phase"] if row["radians"] else math.radians(row["phase"]),
    )
    return float(found.value)


def scene_of(row: dict[str, Any]) -> Scene:
    """A row of the table as a scene with a straight initial loading."""
    load = EllipseLoad(
        mean_normal_load=row["mean"],
        normal_amplitude=row["amplitude"],
        mean_tangential_load=0.0,
        tangential_amplitude=row["tangential"],
        phase_degrees=math.degrees(row["phase"]) if row["radians"] else row["phase"],
        initial_loading="straight",
    )
    return Scene(
        name="row", material=like(1.0), profile=profile_of(row["flat"]), friction=Friction(coefficient=row["friction"]), load=load
    )


def extremes() -> Iterator[Row]:
    """The table of references. What is hard on a formula is on docs/stress.md, every scene of the library in `make regress`."""
    plain, works, densities = table_of_ellipses(extremes=False), [], []
    for row in plain:
        answer = semi_analytic.solve(scene_of(row), x=row["x"], fields=("dissipation", "dissipation_density"))
        exact = np.array(row["density"], dtype=float)
        works.append(abs(answer.dissipation / float(row["dissipation"]) - 1))
        densities.append(float(np.max(np.abs(answer.dissipation_density - exact)) / np.max(exact)))
    how = f"{len(plain)} ellipses, Hertz and flat face, five phases, f from 1e-3 to 10; solve against 30 digits"
    yield Row("worst relative error of W", max(works), 1e-12, how)
    yield Row("worst error of W(x) over max W", max(densities), 1e-9, how)


# ------------------------------------------------------------------------------------------------------- work and precision
NODES, STEPS, ELEMENTS = (4, 8, 16, 32), (50, 100, 200, 400, 800, 1600, 3200), (20, 40, 80, 160)
FLOOR = 1e-17  # errors of exactly 0 are drawn here
SLIDING = 0.5 * math.sqrt(1 - 0.16) * (1 - 1e-6)
CASES = {
    "hertz-paper": Case(0.0, 3.0, 1.0, 1.0, 90.0, 1.0),
    "flat face, the paper's loads": Case(0.7, 3.0, 1.0, 1.0, 90.0, 1.0),
    "Cattaneo-Mindlin": Case(0.0, 1.0, 0.0, 0.6 * 0.5, math.pi / 2, 0.5, True),
    "1e-6 from gross sliding": Case(0.0, 1.0, 0.4, SLIDING, math.pi / 2, 0.5, True),
    "slip of 1e-6 of f P": Case(0.0, 1.0, 0.3, 1e-6 * 0.5, math.pi / 2, 0.5, True),
}
"""E* = 1, R = 1."""


class Point(NamedTuple):
    """One value of one method: its size (nodes a phase, steps, elements), relative error and seconds."""

    size: int
    error: float
    seconds: float


@functools.cache
def contact_with(flat: float) -> Contact:
    """Normal contact of E* = 1, R = 1 and a flat of half-length `flat`."""
    return contact_of(profile_of(flat), like(1.0))


def plain_gauss(case: Case, nodes: int) -> float:
    """W = (f A/pi) int |u' or v'| Lam(P, P_c) dt by Gauss' rule on each phase, P - P_c without cancellation (theory, section 4)."""
    # notation: U, V phasors of u = Q - f P and v = Q + f P; E max u, G min v, I min u, J where the stick edge passes G, M = E
    phase, f = (case.phase if case.radians else math.radians(case.phase)), case.friction
    phasor = case.tangential * np.exp(-1j * phase)
    u, v = phasor - f * case.amplitude, phasor + f * case.amplitude
    e = -float(np.angle(u))
    g = e + (math.pi - float(np.angle(v)) - e) % (2 * math.pi)
    i, m = e + math.pi, e + 2 * math.pi
    j = 2 * i - g
    node, weight = np.polynomial.legendre.leggauss(nodes)
    total = 0.0
    for begin, end, size, turn, slipped in (
        (e, g, abs(v), g, lambda t: abs(u) * np.sin((t - e) / 2) ** 2 / f),
        (i, j, abs(u), e, lambda t: -2 * case.amplitude * np.sin(i) * np.sin(t - i)),
        (j, m, abs(u), e, lambda t: abs(v) * np.sin((t - g) / 2) ** 2 / f),
    ):
        t = (begin + end) / 2 + (end - begin) / 2 * node
        area = contact_with(case.flat).dissipation_kernel(case.mean + case.amplitude * np.cos(t), slipped(t))
        total += (end - begin) / 2 * float(np.sum(weight * size * np.abs(np.sin(t - turn)) * area))
    return 2 * f / math.pi * total


def loads(case: Case, steps: int) -> list[tuple[float, float]]:
    """(P, Q) at the ends of equal steps of one revolution, blind to the turning points."""
    phase = case.phase if case.radians else math.radians(case.phase)
    t = 2 * np.pi * (np.arange(1, steps + 1) - 0.123) / steps
    p, q = case.mean + case.amplitude * np.cos(t), case.tangential * np.cos(t - phase)
    return list(zip(p.tolist(), q.tolist(), strict=True))


def straight_steps(case: Case, steps: int) -> float:
    """The memory curve of the theory, stepped along a polygon."""
    cycle = loads(case, steps)
    rows = [(float(k), *pair) for k, pair in enumerate([cycle[-1], *cycle])]
    series = scene_of(case._asdict()).vary(load=TimeSeriesLoad(rows=rows, repeats=True))
    return semi_analytic.solve(series, x=[0.0], cycles="steady", fields=("dissipation",)).dissipation


def discretised(case: Case, elements: int) -> float:
    """The naive peer; its increments are as short as its elements, five of them for two elements."""
    half = 1.15 * float(case.contact().half_width(mp.mpf(case.mean + case.amplitude)))
    cycle = np.array(loads(case, 5 * elements // 2))
    path = np.concatenate([np.linspace(0, 1, 11)[1:, None] * cycle[-1], cycle, cycle]).T
    found = dense_grid.solve(scene_of(case._asdict()).profile.height, (-half, half), elements, case.friction, *path)
    return float(found.cycle_work(len(cycle))[-1])


METHODS: dict[str, tuple[tuple[int, ...], Callable[[Case, int], float]]] = {
    "plain Gauss": (NODES, plain_gauss),
    "the engine's rule": ((1,), lambda case, _: batch(case._asdict())),
    "straight steps": (STEPS, straight_steps),
    "discretised": (ELEMENTS, discretised),
}


def study(name: str) -> dict[str, list[Point]]:
    """Every method on one of the cases, against 30 digits."""
    case = CASES[name]
    with mp.workdps(2 * DIGITS):
        f = mp.mpf(case.friction)
        exact = ellipse_dissipation(case) if case.amplitude else mindlin(mp.mpf("0.6"), f * case.mean)
    found: dict[str, list[Point]] = {}
    for method, (sizes, work) in METHODS.items():
        found[method] = []
        for size in sizes:
            try:
                value, count, begun = work(case, size), 0, time.process_time()
            except ArithmeticError:
                continue  # a grid that slides altogether has no answer; the table shows one row less
            while (spent := time.process_time() - begun) < 0.02 or not count:
                work(case, size)
                count += 1
            found[method].append(Point(size, max(float(abs(value / exact - 1)), FLOOR), spent / count))
    return found


# ---------------------------------------------------------------------------------------------------------------- histories
ROWS = 1_000_000


def random_rows(scene: Scene, count: int) -> np.ndarray:
    """Admissible rows (count, 3) about the scene's mean load, of every size of swing."""
    rng = np.random.default_rng(0)
    mean, friction = scene.load.mean_normal_load, scene.friction.coefficient
    step = np.arange(1.0, count + 1)
    normal = mean * (1 + 0.5 * np.sin(0.31 * step) * rng.uniform(0.2, 1, count))
    return np.stack([step, normal, 0.9 * friction * normal * np.sin(0.57 * step + rng.normal(size=count))], axis=1)


def profiles(radius: float) -> dict[str, tuple[Profile, float]]:
    """Profiles of about that radius, and the seconds that one scene may take."""
    x = np.linspace(0, 3, 31)
    return {
        "flat and rounded": (FlatRounded(radius=radius, flat_half_length=0.505), 1.0),
        "compound": (Compound(inner_radius=radius, outer_radius=radius / 2, inner_half_length=0.7), 0.3),
        "wedge": (Wedge(tip_radius=radius, tip_half_length=0.7), 0.3),
        "power law": (PowerLaw(exponent=2.7, length=1.0, rise=0.5 / radius), 0.3),
        "polynomial": (EvenPolynomial(length=1.0, rises=(0.5 / radius, 0.1 / radius)), 0.3),
        "table of 31 rows": (Tabulated(points=np.stack([x, (np.cosh(x) - 1) / radius], axis=1)), 1.0),
        "function": (CallableProfile(slope_function=lambda at: np.sinh(at) / radius, extent=3.0), 1.0),
    }


def histories() -> Iterator[Row]:
    """The paper's scene on every profile, a CSV file of 10^6 rows, growth, pieces alive, memory; some 20 s."""
    solve, scene, grid = semi_analytic.solve, load_scene("hertz-paper"), "200 points, 400 instants a cycle, all fields"
    start, edge = scene.load.path().cycle_start + 2 * np.pi, float(solve(scene).x[-1])
    x, instants = np.linspace(-edge, edge, 200), start + np.linspace(0, 2 * np.pi, 401)
    took = 1e3 * seconds(lambda: solve(scene), 9)
    yield Row("solve(hertz-paper), its own instants: initial loading and two cycles", took, 20, grid, "ms")
    yield Row("solve(hertz-paper), one cycle", 1e3 * seconds(lambda: solve(scene, x=x, time=instants), 9), 20, grid, "ms")
    for name, (profile, limit) in profiles(scene.profile.radius).items():
        other = scene.vary(profile=profile)
        solve(other, x=[0.0], time=[start])  # what a profile imports at its first use is no part of it
        yield Row(f"the paper's loads, {name}", seconds(lambda s=other: solve(s)), limit, f"{grid}, set-up included", "s")
    rows = random_rows(scene, ROWS)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rows.csv"
        np.savetxt(file, rows, delimiter=",", header="time,P,Q", comments="")
        took = seconds(lambda: solve(scene.vary(load=TimeSeriesLoad(file=str(file))), fields=("dissipation",)))
        yield Row("CSV file of 10^6 rows read and solved, dissipation of every step", took, 5, "Hertz", "s")
    some, long = (scene.vary(load=TimeSeriesLoad(rows=rows[:count])) for count in (ROWS // 100, ROWS))
    few, all_rows = (seconds(lambda s=one: solve(s, fields=("dissipation",)), 2) for one in (some, long))
    yield Row("cost of a row among 10^6 over that among 10^4", all_rows / few / 100, 1.5, "process time")
    alive = solve(long, fields=()).work.counts["pieces_alive"]
    yield Row("pieces of the memory alive at most among 10^6 rows", alive, 60, "counted")
    tenth = scene.vary(load=TimeSeriesLoad(rows=rows[: ROWS // 10]))
    tracemalloc.start()
    solve(tenth, fields=("dissipation",), time=[ROWS / 10], x=[0.0])
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    yield Row("peak memory, last row asked for", peak, 150, "tracemalloc, 10^5 rows, less the rows", "MB")
    for name in ("flat and rounded", "compound", "power law"):
        profile, limit = profiles(scene.profile.radius)[name]
        some = scene.vary(profile=profile, load=TimeSeriesLoad(rows=rows[:40_000]))
        took = seconds(lambda s=some: solve(s, fields=("dissipation",)))
        yield Row(f"40,000 rows, {name}", took, limit + 0.7, "dissipation of every step", "s")


# ------------------------------------------------------------------------------------------------------------------ batches
MEMBERS, SAMPLE = 1_000_000, 200
FUNCTIONS = ("sin", "cos", "tan", "arctan", "arctan2", "hypot", "arcsinh", "sqrt", "cbrt", "log", "log1p", "exp")
Call = tuple[str, tuple[int, ...]]


def random_ellipses(count: int, seed: int = 0) -> dict[str, Any]:
    """P1/P0 in 0.01-0.9, phase in 0-pi, f log-uniform in 0.05-2, Q1 up to gross sliding, all uniform."""
    rng = np.random.default_rng(seed)
    ratio, phase = rng.uniform(0.01, 0.9, count), rng.uniform(0, np.pi, count)
    friction = np.exp(rng.uniform(np.log(0.05), np.log(2), count))
    cosine = np.abs(np.cos(phase))
    limit = -ratio * cosine + np.sqrt(1 - ratio**2 * (1 - cosine**2))
    return {
        "material": like(1.0),
        "friction_coefficient": friction,
        "mean_normal_load": 1.0,
        "normal_amplitude": ratio,
        "tangential_amplitude": rng.uniform(0, 1, count) * limit * friction,
        "phase": phase,
    }


def calls_of(work: Callable[[], Any]) -> list[Call]:
    """Transcendental calls and roots that `work` makes, each with the shape of its result."""
    found: list[Call] = []
    own = {name: getattr(np, name) for name in FUNCTIONS}

    def counting(name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **keys: Any) -> Any:
            result = own[name](*arguments, **keys)
            found.append((name, np.shape(result)))
            return result

        return call

    try:
        for name in FUNCTIONS:
            setattr(np, name, counting(name))
        work()
    finally:
        for name in FUNCTIONS:
            setattr(np, name, own[name])
    return found


def bare(calls: list[Call]) -> Callable[[], None]:
    """The calls alone, on arrays of the same sizes that are there already."""
    sizes = [(getattr(np, name), name in ("arctan2", "hypot"), math.prod(shape)) for name, shape in calls]
    largest = max(size for *_, size in sizes)
    one, out = np.full(largest, 0.7), np.empty(largest)

    def run() -> None:
        for function, of_two, size in sizes:
            function(*((one[:size],) * (1 + of_two)), out=out[:size])

    return run


def batches() -> Iterator[Row]:
    """A million random Hertz ellipses in one call: rate against bare numpy on the same calls, error against 30 digits, memory.

    Two accounts of the calls: by the formulas of theory section 4 (a sine and a cosine at each node), and as the batch makes them
    (one tangent instead, for which numpy has vector code).
    """
    members, count = random_ellipses(MEMBERS), MEMBERS // 10
    hertz, flat = Hertz(radius=1.0), FlatRounded(radius=1.0, flat_half_length=0.7)

    def part(which: Any) -> dict[str, Any]:
        return {name: value[which] if isinstance(value, np.ndarray) else value for name, value in members.items()}

    few = part(slice(count))
    calls = calls_of(lambda: semi_analytic.dissipation(profile=hertz, **few))
    formulas = [(name, s) for call, s in calls for name in (("sin", "cos") if call == "tan" and len(s) == 2 else (call,))]
    works = [lambda p=profile: semi_analytic.dissipation(profile=p, **few) for profile in (hertz, flat)]
    own, by_formulas, took, flat_took = in_turn(bare(calls), bare(formulas), *works)
    numbers = Counter({name: sum(math.prod(shape) for call, shape in calls if call == name) for name in FUNCTIONS})
    counted = ", ".join(f"{numbers[name] / count:.1f} {name}" for name in FUNCTIONS if numbers[name])
    whole = seconds(lambda: semi_analytic.dissipation(profile=hertz, **members))
    yield Row("batch of 10^6 Hertz ellipses: time", whole, None, f"{MEMBERS / whole / 1e6:.2f} million a second, one core", "s")
    how = "at the batch's own nodes, 10^5 members"
    yield Row("the same over bare numpy: sin, cos and log of the formulas", took / by_formulas, 2.0, how)
    yield Row("the same over bare numpy: the calls as the batch makes them", took / own, None, f"a member: {counted}")
    how = f"{count / flat_took / 1e6:.2f} million a second"
    yield Row("batch of flat-and-rounded ellipses over Hertz", flat_took / took, 5.0, how)
    peaks = []
    for some in (few, members):
        tracemalloc.start()
        found = semi_analytic.dissipation(profile=hertz, **some)
        peaks.append(
            (tracemalloc.get_traced_memory()[1] - sum(getattr(value, "nbytes", 0) for value in vars(found).values())) / 1e6
        )
        tracemalloc.stop()
    yield Row("peak memory beyond arguments and results, 10^5 members", peaks[0], None, "tracemalloc", "MB")
    yield Row("growth of that from 10^5 to 10^6 members", peaks[1] - peaks[0], 0.5, f"{peaks[1]:.2f} MB", "MB")
    chosen = part(np.sort(np.random.default_rng(1).choice(MEMBERS, SAMPLE, replace=False)))
    keys = ("normal_amplitude", "tangential_amplitude", "phase", "friction_coefficient")
    for name, profile, b, size in (("Hertz", hertz, 0.0, SAMPLE), ("flat-and-rounded", flat, 0.7, SAMPLE // 10)):
        values, errors = semi_analytic.dissipation(profile=profile, **chosen).value[:size], []
        for value, *row in zip(values.tolist(), *(chosen[key][:size].tolist() for key in keys), strict=True):
            with mp.workdps(DIGITS):
                exact = ellipse_dissipation(Case(b, 1.0, *row, True))
                errors.append((float(abs(value - exact)) / (2 * row[3] ** 2), float(abs(value / exact - 1))))
        worst, relative = np.max(errors, axis=0).tolist()
        yield Row(f"{name}: worst error of {size} random members, in A f^2 P0^2", worst, 1e-11, "against 30 digits")
        yield Row(f"{name}: the same, relative", relative, None, "against 30 digits")
