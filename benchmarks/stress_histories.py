"""Cases of numerical stress for long histories through the half-plane engine."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import mpmath
import numpy as np
from stress_case import Case, Trial, broken_by, mindlin, scene_of

import semi_analytic
from scenes import InputError, PolygonLoad, TimeSeriesLoad, load_scene

ENGINE = "Half-plane engine"


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
    answer = semi_analytic.solve(scene_of(TimeSeriesLoad(rows=rows, repeats=repeats)), x=[0.0], fields=("dissipation",))
    return broken_by(answer) if np.isfinite(answer.dissipation) and answer.dissipation > 0 else float("nan")


def work_of(rows: np.ndarray, repeats: bool = False) -> float:
    """W of a whole series, or of its steady cycle."""
    load = TimeSeriesLoad(rows=rows, repeats=repeats)
    return float(semi_analytic.solve(scene_of(load), x=[0.0], fields=("dissipation",)).dissipation)


def over_and_over(period: np.ndarray, count: int) -> np.ndarray:
    """`count` periods of rows (m, 2) of P and Q, and the first row again."""
    loads = np.concatenate([np.tile(period, (count, 1)), period[:1]])
    return np.column_stack([np.arange(len(loads)), loads])


def cycles_of_mindlin(count: int) -> float:
    """What `count` cycles of 400 rows at constant P dissipate beyond the second, over the closed form."""
    period = np.column_stack([np.ones(400), 0.3 * np.cos(2 * np.pi * np.arange(400) / 400)])
    more = work_of(over_and_over(period, count)) - work_of(over_and_over(period, 2))
    return abs(float(more / ((count - 2) * mindlin(mpmath.mpf(0.3) / mpmath.mpf(0.5), 0.5))) - 1)


def cycles_of_noise(count: int) -> float:
    """The same of a noisy loop in which P varies, over W of a polygon of 400 corners."""
    period = wave(400, 0.01)[:, 1:]
    corners = tuple(map(tuple, period.tolist()))
    cycle = semi_analytic.solve(
        scene_of(PolygonLoad(initial_loading=corners[:1], cycle=corners[1:])), x=[0.0], fields=("dissipation",)
    )
    more = work_of(over_and_over(period, count)) - work_of(over_and_over(period, 2))
    return abs(more / ((count - 2) * cycle.dissipation) - 1)


def row_trials() -> Iterator[Trial]:
    for count, noise in ((100_001, 0.0), (1_000_001, 0.0), (1_000_001, 0.01)):
        yield f"{count} rows, noise {noise:g}", lambda count=count, noise=noise: of_rows(wave(count, noise))
    held = wave(1_000_001)
    held[1000:300_000, 1:] = held[1000, 1:]
    yield "300,000 rows that repeat the same loads", partial(of_rows, held)
    yield "10^5 rows again and again", lambda: of_rows(wave(100_001, 0.01, True), True)


def known_row_trials() -> Iterator[Trial]:
    for count in (250, 2500):
        yield f"{400 * count} rows at constant P", partial(cycles_of_mindlin, count)
        yield f"{400 * count} rows of a noisy loop", partial(cycles_of_noise, count)


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
    yield Case(
        ENGINE,
        "long histories",
        "10^5 and 10^6 rows, smooth, noisy, with repeats, again and again",
        "cone and M(P) = Q, over f P",
        1e-12,
        row_trials,
    )
    yield Case(
        ENGINE,
        "long histories, W",
        "10^5 and 10^6 rows: 250 and 2500 cycles at constant P, and of a noisy loop",
        "W of all but two cycles against the closed form, or a polygon's",
        1e-10,
        known_row_trials,
    )
    yield Case(
        ENGINE,
        "bad histories",
        "10^6 rows from CSV: a NaN, a row out of order, a time twice",
        "refused",
        0.0,
        bad_row_trials,
        may_refuse=True,
        must_refuse=True,
    )
    yield Case(
        ENGINE, "a spike", "one of 10^6 rows slides", "refused", 0.0, lambda: [("spike", spike)], may_refuse=True, must_refuse=True
    )
