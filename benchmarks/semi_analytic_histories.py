"""What histories cost: the paper's scene, a CSV file of 10^6 rows, every kind of profile; growth, pieces alive, memory.

python benchmarks/semi_analytic_histories.py
"""

from __future__ import annotations

import tempfile
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from claim import Row, table
from clock import seconds

from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    PowerLaw,
    Profile,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
    load_scene,
)
from semi_analytic import solve

POINTS, INSTANTS = 200, 400
ROWS = 1_000_000


def random_rows(scene: Scene, count: int) -> np.ndarray:
    """Admissible rows (count, 3) about the scene's mean load, of every size of swing."""
    rng = np.random.default_rng(0)
    mean, friction = scene.load.mean_normal_load, scene.friction.coefficient
    step = np.arange(1.0, count + 1)
    normal = mean * (1 + 0.5 * np.sin(0.31 * step) * rng.uniform(0.2, 1, count))
    return np.stack([step, normal, 0.9 * friction * normal * np.sin(0.57 * step + rng.normal(size=count))], axis=1)


def profiles(radius: float) -> Iterator[tuple[str, Profile, float]]:
    """Name, profile of about that radius, and the seconds that one scene may take."""
    x = np.linspace(0, 3, 31)
    yield "flat and rounded", FlatRounded(radius=radius, flat_half_length=0.505), 1.0
    yield "compound", Compound(inner_radius=radius, outer_radius=radius / 2, inner_half_length=0.7), 0.3
    yield "wedge", Wedge(tip_radius=radius, tip_half_length=0.7), 0.3
    yield "power law", PowerLaw(exponent=2.7, length=1.0, rise=0.5 / radius), 0.3
    yield "polynomial", EvenPolynomial(length=1.0, rises=(0.5 / radius, 0.1 / radius)), 0.3
    yield "table of 31 rows", Tabulated(points=np.stack([x, (np.cosh(x) - 1) / radius], axis=1)), 1.0
    yield "function", CallableProfile(slope_function=lambda at: np.sinh(at) / radius, extent=3.0), 1.0


def cycle() -> Iterator[Row]:
    scene = load_scene("hertz-paper")
    own = solve(scene)
    start, edge = scene.load.path().cycle_start + 2 * np.pi, float(own.x[-1])
    x, instants = np.linspace(-edge, edge, POINTS), start + np.linspace(0, 2 * np.pi, INSTANTS + 1)
    grid = f"{POINTS} points, {INSTANTS} instants a cycle, all fields"
    yield Row(
        "solve(hertz-paper), its own instants: initial loading and two cycles",
        1e3 * seconds(lambda: solve(scene), 9),
        20,
        grid,
        "ms",
    )
    yield Row("solve(hertz-paper), one cycle", 1e3 * seconds(lambda: solve(scene, x=x, time=instants), 9), 20, grid, "ms")
    for name, profile, limit in profiles(scene.profile.radius):
        other = scene.vary(profile=profile)
        solve(other, x=[0.0], time=[start])  # what a profile imports at its first use is no part of it
        yield Row(f"the paper's loads, {name}", seconds(lambda s=other: solve(s)), limit, f"{grid}, set-up included", "s")


def series() -> Iterator[Row]:
    scene = load_scene("hertz-paper")
    rows = random_rows(scene, ROWS)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rows.csv"
        np.savetxt(file, rows, delimiter=",", header="time,P,Q", comments="")

        def whole() -> None:
            load = TimeSeriesLoad(file=str(file))
            solve(scene.vary(load=load), fields=("dissipation",))

        yield Row("CSV file of 10^6 rows read and solved, dissipation of every step", seconds(whole), 5, "Hertz", "s")
    cost = {}
    for count in (ROWS // 100, ROWS):
        some = scene.vary(load=TimeSeriesLoad(rows=rows[:count]))
        cost[count] = seconds(lambda s=some: solve(s, fields=("dissipation",)), 2) / count
    yield Row("cost of a row among 10^6 over that among 10^4", cost[ROWS] / cost[ROWS // 100], 1.5, "process time", "")
    answer = solve(some, fields=())
    yield Row("pieces of the memory alive at most among 10^6 rows", answer.work.counts["pieces_alive"], 60, "counted", "")
    yield Row("peak memory, last row asked for", _peak(scene, rows), 150, "tracemalloc, 10^5 rows, less the rows", "MB")
    for name, profile, limit in profiles(scene.profile.radius):
        if name in ("compound", "power law", "flat and rounded"):
            some = scene.vary(profile=profile, load=TimeSeriesLoad(rows=rows[:40_000]))
            spent = seconds(lambda s=some: solve(s, fields=("dissipation",)))
            yield Row(f"40,000 rows, {name}", spent, limit + 0.7, "dissipation of every step", "s")


def _peak(scene: Scene, rows: np.ndarray) -> float:
    long = scene.vary(load=TimeSeriesLoad(rows=rows[: ROWS // 10]))
    tracemalloc.start()
    solve(long, fields=("dissipation",), time=[ROWS / 10], x=[0.0])
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return peak


def claims() -> Iterator[Row]:
    """Every figure of this file, some 20 s."""
    yield from cycle()
    yield from series()


if __name__ == "__main__":
    print(table(list(claims())))
