"""Claims of the half-plane engine: errors against 30 digits; costs of histories and batches; error
against time.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
from claims import ROOT, Row, seconds, stored
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

sys.path.insert(0, str(ROOT / "tests"))
from semi_analytic import grid as dense_grid
from semi_analytic.profiles import contact_of
from semi_analytic.steady_ellipse import ellipses_of, works_over_time


def like(e_star: float, poisson_ratio: float = 0.0) -> Materials:
    """Like bodies with that E*."""
    body = Elastic(young_modulus=2 * e_star * (1 - poisson_ratio**2), poisson_ratio=poisson_ratio)
    return Materials(upper=body, lower=body)


# ---------------------------------------------------------------------- ellipses known to 30 digits
def table_of_ellipses(extremes: bool) -> list[dict[str, Any]]:
    """The 41 ellipses of the table of references, or its 22 extremes."""
    return [row for row in stored(TABLE) if row["radians"] == extremes]


def profile_of(flat: float) -> Profile:
    """R = 1; a flat of half-length `flat` with rounded edges, or a parabola."""
    return FlatRounded(radius=1.0, flat_half_length=flat) if flat else Hertz(radius=1.0)


def loads_of(row: dict[str, Any]) -> dict[str, float]:
    """The loads of a row of the table but its phase."""
    return {
        "mean_normal_load": row["mean"],
        "normal_amplitude": row["amplitude"],
        "mean_tangential_load": 0.0,
        "tangential_amplitude": row["tangential"],
    }


def batch(row: dict[str, Any]) -> float:
    """Dissipation of a row of the table by the batch, E* = 1."""
    loads = loads_of(row)
    loads |= {
        "profile": profile_of(row["flat"]),
        "material": like(1.0),
        "friction_coefficient": row["friction"],
        "phase_radians" if row["radians"] else "phase_degrees": row["phase"],
    }
    return float(semi_analytic.dissipation(**loads).value)


def scene_of(row: dict[str, Any]) -> Scene:
    """A row of the table as a scene with a straight initial loading."""
    phase = math.degrees(row["phase"]) if row["radians"] else row["phase"]
    load = EllipseLoad(**loads_of(row), phase_degrees=phase, initial_loading="straight")
    friction = Friction(coefficient=row["friction"])
    return Scene(
        name="row",
        material=like(1.0),
        profile=profile_of(row["flat"]),
        friction=friction,
        load=load,
    )


def extremes() -> Iterator[Row]:
    """The table of references. What is hard on a formula is on docs/stress.md, every scene of the
    library in `make regress`.
    """
    plain = table_of_ellipses(extremes=False)
    works = []
    densities = []
    for row in plain:
        answer = semi_analytic.solve(
            scene_of(row), x=row["x"], fields=("dissipation", "dissipation_density")
        )
        exact = np.array(row["density"], dtype=float)
        works.append(abs(answer.dissipation / float(row["dissipation"]) - 1))
        densities.append(float(np.max(np.abs(answer.dissipation_density - exact)) / np.max(exact)))
    how = (
        f"{len(plain)} ellipses, Hertz and flat face, five phases, f from 1e-3 to 10; solve against"
        " 30 digits"
    )
    yield Row("worst relative error of W", max(works), 1e-12, how)
    yield Row("worst error of W(x) over max W", max(densities), 1e-9, how)


# ------------------------------------------------------------------------------- error against time
FLOOR = 1e-17  # errors of exactly 0 are drawn here
SLIDING = 0.5 * math.sqrt(1 - 0.16) * (1 - 1e-6)
# E* = 1, R = 1.
CASES = {
    "hertz-paper": Case(0.0, 3.0, 1.0, 1.0, 90.0, 1.0),
    "flat and rounded, b/a = 0.7": Case(0.7, 3.0, 1.0, 1.0, 90.0, 1.0),
    "Cattaneo-Mindlin": Case(0.0, 1.0, 0.0, 0.6 * 0.5, math.pi / 2, 0.5, True),
    "1e-6 from gross sliding": Case(0.0, 1.0, 0.4, SLIDING, math.pi / 2, 0.5, True),
    "slip of 1e-6 of f P": Case(0.0, 1.0, 0.3, 1e-6 * 0.5, math.pi / 2, 0.5, True),
}


def cycle_of(case: Case, steps: int) -> np.ndarray:
    """(steps, 2) P and Q at the ends of equal steps of one revolution, blind to the turning
    points.
    """
    phase = case.phase if case.radians else math.radians(case.phase)
    t = 2 * np.pi * (np.arange(1, steps + 1) - 0.123) / steps
    return np.column_stack(
        [case.mean + case.amplitude * np.cos(t), case.tangential * np.cos(t - phase)]
    )


def straight_steps(case: Case, steps: int) -> float:
    """The memory curve of the theory, stepped along a polygon."""
    cycle = cycle_of(case, steps)
    rows = np.column_stack([np.arange(steps + 1.0), np.vstack([cycle[-1:], cycle])])
    series = scene_of(case._asdict()).vary(load=TimeSeriesLoad(rows=rows, repeats=True))
    return semi_analytic.solve(
        series, x=[0.0], cycles="steady", fields=("dissipation",)
    ).dissipation


def discretised(case: Case, elements: int) -> float:
    """The naive peer; its increments are as short as its elements, five of them for two
    elements.
    """
    half = 1.15 * float(case.contact().half_width(mp.mpf(case.mean + case.amplitude)))
    cycle = cycle_of(case, 5 * elements // 2)
    path = np.concatenate([np.linspace(0, 1, 11)[1:, None] * cycle[-1], cycle, cycle]).T
    answer = dense_grid.follow_instants(
        scene_of(case._asdict()).profile.height, (-half, half), elements, case.friction, *path
    )
    return float(answer.cycle_work(len(cycle))[-1])


METHODS: dict[str, tuple[tuple[int, ...], Callable[[Case, int], float]]] = {
    "the engine's rule": ((1,), lambda case, _: batch(case._asdict())),
    "straight steps": ((50, 100, 200, 400, 800, 1600, 3200), straight_steps),
    "discretised": ((20, 40, 80, 160), discretised),
}


def study(case: Case) -> dict[str, list[dict[str, float]]]:
    """Size, relative error against 30 digits and seconds of every method on a case."""
    with mp.workdps(2 * DIGITS):
        exact = (
            ellipse_dissipation(case)
            if case.amplitude
            else mindlin(mp.mpf("0.6"), mp.mpf(case.friction) * case.mean)
        )
    points: dict[str, list[dict[str, float]]] = {method: [] for method in METHODS}
    for method, (sizes, work) in METHODS.items():
        for size in sizes:
            try:
                value = work(case, size)
                count = 0
                begun = time.process_time()
            except ArithmeticError:
                # a grid that slides altogether has no answer; the table shows one row less
                continue
            while (spent := time.process_time() - begun) < 0.02 or not count:
                work(case, size)
                count += 1
            error = max(float(abs(value / exact - 1)), FLOOR)
            points[method].append({"size": size, "error": error, "seconds": spent / count})
    return points


# ---------------------------------------------------------------------------------------- histories
_X = np.linspace(0, 4, 61)
# Every kind of profile in units of length `u`.
PROFILES: dict[str, Callable[[float], Profile]] = {
    "Hertz": lambda u: Hertz(radius=u),
    "flat and rounded": lambda u: FlatRounded(radius=u, flat_half_length=0.7 * u),
    "power law": lambda u: PowerLaw(exponent=1.5, length=u, rise=0.5 * u),
    "compound": lambda u: Compound(inner_radius=u, outer_radius=0.4 * u, inner_half_length=0.8 * u),
    "wedge": lambda u: Wedge(tip_radius=u, tip_half_length=0.7 * u),
    "polynomial": lambda u: EvenPolynomial(length=u, rises=(0.5 * u, 0.1 * u)),
    "table of 61 rows": lambda u: Tabulated(
        points=np.column_stack([u * _X, u * (np.cosh(_X) - 1)]).tolist()
    ),
    "function": lambda u: CallableProfile(slope_function=lambda x: np.sinh(x / u), extent=4 * u),
}
# Seconds that a scene may take, where they are not 0.3.
LIMITS = {"flat and rounded": 1.0, "table of 61 rows": 1.0, "function": 1.0}
ROWS = 1_000_000
W_ALONE = ("dissipation",)


def random_rows(scene: Scene, count: int) -> np.ndarray:
    """Admissible rows (count, 3) about the scene's mean load, of every size of swing."""
    rng = np.random.default_rng(0)
    mean = scene.load.mean_normal_load
    friction = scene.friction.coefficient
    step = np.arange(1.0, count + 1)
    normal = mean * (1 + 0.5 * np.sin(0.31 * step) * rng.uniform(0.2, 1, count))
    return np.stack(
        [step, normal, 0.9 * friction * normal * np.sin(0.57 * step + rng.normal(size=count))],
        axis=1,
    )


def histories() -> Iterator[Row]:
    """The paper's scene on every profile, a CSV file of 10^6 rows, growth, pieces alive, memory;
    some 20 s.
    """
    solve = semi_analytic.solve
    scene = load_scene("hertz-paper")
    grid = "200 points, 400 instants a cycle, all fields"
    start = scene.load.path().cycle_start + 2 * np.pi
    edge = float(solve(scene).x[-1])
    x = np.linspace(-edge, edge, 200)
    instants = start + np.linspace(0, 2 * np.pi, 401)
    seconds_of_own_points, seconds_of_given_points = seconds(
        lambda: solve(scene), lambda: solve(scene, x=x, time=instants), times=9
    )
    yield Row(
        "solve(hertz-paper), its own instants: initial loading and two cycles",
        1e3 * seconds_of_own_points,
        20,
        grid,
        "ms",
    )
    yield Row("solve(hertz-paper), one cycle", 1e3 * seconds_of_given_points, 20, grid, "ms")
    unit = scene_of(CASES["hertz-paper"]._asdict())
    how = f"{grid}, set-up included"
    for name, profile in PROFILES.items():
        other = unit.vary(profile=profile(1.0))
        # what a profile imports at its first use is no part of it
        solve(other, x=[0.0], time=[start])
        yield Row(
            f"the paper's loads, {name}",
            seconds(lambda s=other: solve(s))[0],
            LIMITS.get(name, 0.3),
            how,
            "s",
        )
    rows = random_rows(scene, ROWS)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rows.csv"
        np.savetxt(file, rows, delimiter=",", header="time,P,Q", comments="")
        (took,) = seconds(
            lambda: solve(scene.vary(load=TimeSeriesLoad(file=str(file))), fields=W_ALONE)
        )
        yield Row(
            "CSV file of 10^6 rows read and solved, dissipation of every step",
            took,
            5,
            "Hertz",
            "s",
        )
    some, long = (
        scene.vary(load=TimeSeriesLoad(rows=rows[:count])) for count in (ROWS // 100, ROWS)
    )
    seconds_of_few, all_rows = seconds(
        lambda: solve(some, fields=W_ALONE), lambda: solve(long, fields=W_ALONE), times=2
    )
    yield Row(
        "cost of a row among 10^6 over that among 10^4",
        all_rows / seconds_of_few / 100,
        1.5,
        "process time",
    )
    alive = solve(long, fields=()).work.counts["pieces_alive"]
    yield Row("pieces of the memory alive at most among 10^6 rows", alive, 60, "counted")
    tenth = scene.vary(load=TimeSeriesLoad(rows=rows[: ROWS // 10]))
    peak, _ = traced(lambda: solve(tenth, fields=W_ALONE, time=[ROWS / 10], x=[0.0]))
    yield Row(
        "peak memory, last row asked for", peak, 150, "tracemalloc, 10^5 rows, less the rows", "MB"
    )
    for name in ("flat and rounded", "compound", "power law"):
        some = unit.vary(
            profile=PROFILES[name](1.0), load=TimeSeriesLoad(rows=random_rows(unit, 40_000))
        )
        (took,) = seconds(lambda s=some: solve(s, fields=W_ALONE))
        yield Row(
            f"40,000 rows, {name}",
            took,
            LIMITS.get(name, 0.3) + 0.7,
            "dissipation of every step",
            "s",
        )


def traced(work: Callable[[], Any]) -> tuple[float, Any]:
    """Peak of the memory of a work [MB], and its answer."""
    tracemalloc.start()
    answer = work()
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return peak, answer


# ------------------------------------------------------------------------------------------ batches
MEMBERS = 1_000_000


def random_ellipses(count: int, seed: int = 0) -> dict[str, Any]:
    """P1/P0 in 0.01-0.9, phase in 0-pi, f log-uniform in 0.05-2, Q1 up to gross sliding, all
    uniform.
    """
    rng = np.random.default_rng(seed)
    ratio = rng.uniform(0.01, 0.9, count)
    phase = rng.uniform(0, np.pi, count)
    friction = np.exp(rng.uniform(np.log(0.05), np.log(2), count))
    cosine = np.abs(np.cos(phase))
    limit = -ratio * cosine + np.sqrt(1 - ratio**2 * (1 - cosine**2))
    return {
        "material": like(1.0),
        "friction_coefficient": friction,
        "mean_normal_load": 1.0,
        "normal_amplitude": ratio,
        "tangential_amplitude": rng.uniform(0, 1, count) * limit * friction,
        "phase_radians": phase,
    }


def batches() -> Iterator[Row]:
    """A million random Hertz ellipses in one call: rate and memory."""
    members = random_ellipses(MEMBERS)
    few_ellipses = {
        name: value[: MEMBERS // 10] if isinstance(value, np.ndarray) else value
        for name, value in members.items()
    }

    def works(loops: dict[str, Any], flat: float = 0.0) -> Any:
        return semi_analytic.dissipation(profile=profile_of(flat), **loops)

    (seconds_of_batch,) = seconds(lambda: works(members))
    took, flat_took = seconds(
        lambda: works(few_ellipses), lambda: works(few_ellipses, 0.7), times=5
    )
    yield Row(
        "batch of 10^6 Hertz ellipses: time",
        seconds_of_batch,
        None,
        f"{MEMBERS / seconds_of_batch / 1e6:.2f} million a second, one core",
        "s",
    )
    how = f"{len(few_ellipses['phase_radians']) / flat_took / 1e6:.2f} million a second"
    yield Row("batch of flat-and-rounded ellipses over Hertz", flat_took / took, 5.0, how)
    for name, profile in PROFILES.items():
        some = random_ellipses(20_000, seed=1)
        last = random_ellipses(250, seed=2)
        semi_analytic.dissipation(profile=profile(1.0), **some)
        (took,) = seconds(
            lambda some=some, profile=profile: semi_analytic.dissipation(
                profile=profile(1.0), **some
            )
        )
        ratio, force, phase, friction = (
            last[key]
            for key in (
                "normal_amplitude",
                "tangential_amplitude",
                "phase_radians",
                "friction_coefficient",
            )
        )
        loops = ellipses_of(np.ones(len(ratio)), ratio, force, phase, friction)
        exact = (
            2
            / math.pi
            * np.sum(works_over_time(loops, contact_of(profile(1.0), like(1.0))), axis=0)
        )
        off = (
            np.abs(
                semi_analytic.dissipation(profile=profile(1.0), **last).value / friction**2 - exact
            )
            / 2
        )
        how = (
            f"over A f^2 P0^2, worst of {len(off)} against the graded rule; {20_000 / took:.2g}"
            " members a second"
        )
        yield Row(f"batch, {name}: error of W", float(np.max(off)), 1e-10, how)
    peaks = []
    for some in (few_ellipses, members):
        peak, works_found = traced(lambda some=some: works(some))
        peaks.append(
            peak - sum(getattr(value, "nbytes", 0) for value in vars(works_found).values()) / 1e6
        )
    yield Row(
        "peak memory beyond arguments and results, 10^5 members",
        peaks[0],
        None,
        "tracemalloc",
        "MB",
    )
    yield Row(
        "growth of that from 10^5 to 10^6 members",
        peaks[1] - peaks[0],
        0.5,
        f"{peaks[1]:.2f} MB",
        "MB",
    )
