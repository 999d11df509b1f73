"""Work against precision: the dissipation of a cycle by quadrature, by steps along the memory curve, by a discretised half-plane.

    OPENBLAS_NUM_THREADS=1 python benchmarks/semi_analytic_precision.py     the table, and out/precision_half_plane.svg
    ... --references                                                        evaluate the 30-digit references anew (some minutes)

Times are process times of one figure at a time, one thread; ratios within one run count. Gauss' rule has no order to extrapolate
by: what 32 nodes do not reach is not reached. Equal steps and elements are blind to the turning points, so that single errors may
be small by chance: the order is that of all sizes.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import discretised_half_plane as peer
import mpmath as mp
import numpy as np
from claim import Row, table
from semi_analytic_reference import DIGITS, Case, dissipation, half_width_of

import semi_analytic
from scenes import Elastic, EllipseLoad, FlatRounded, Friction, Hertz, Materials, Scene, TimeSeriesLoad
from semi_analytic.profiles import Contact, contact_of

FILE = Path(__file__).with_suffix(".json")
OUT = Path(__file__).parent.parent / "out"
NODES = (4, 8, 16, 32)
STEPS = (50, 100, 200, 400, 800, 1600, 3200)
ELEMENTS = (20, 40, 80, 160)
TARGETS = (1e-3, 1e-6, 1e-12)
YEAR = 3e7
FLOOR = 1e-17  # errors of exactly 0 are drawn here

# E* = 1, R = 1; of each the name that the table and the figure give it.
CASES = {
    "hertz-paper": Case(0.0, 3.0, 1.0, 1.0, 90.0, 1.0),
    "flat face, the paper's loads": Case(0.7, 3.0, 1.0, 1.0, 90.0, 1.0),
    "1e-6 from gross sliding": Case(0.0, 1.0, 0.4, 0.5 * math.sqrt(1 - 0.16) * (1 - 1e-6), math.pi / 2, 0.5, True),
    "P1/P0 = 1 - 1e-6": Case(0.0, 1.0, 1 - 1e-6, 1e-4, math.pi / 2, 0.5, True),
    "slip of 1e-6 of f P": Case(0.0, 1.0, 0.3, 1e-6 * 0.5, math.pi / 2, 0.5, True),
}


class Point(NamedTuple):
    """One figure of one method: its size (nodes a phase, steps, elements), relative error and seconds."""

    size: int
    error: float
    seconds: float


def timed(work: Callable[[], float], least: float = 0.02) -> tuple[float, float]:
    """The figure, and the process time of making it once, after one to warm up, averaged over at least `least` seconds."""
    value, count, begun = work(), 0, time.process_time()
    while (spent := time.process_time() - begun) < least or not count:
        work()
        count += 1
    return value, spent / count


def scene_of(case: Case) -> Scene:
    """The case with a straight initial loading."""
    steel = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    load = EllipseLoad(
        mean_normal_load=case.mean,
        normal_amplitude=case.amplitude,
        mean_tangential_load=0.0,
        tangential_amplitude=case.tangential,
        phase_degrees=math.degrees(case.phase) if case.radians else case.phase,
        initial_loading="straight",
    )
    return Scene(
        name="precision",
        material=Materials(upper=steel, lower=steel),
        profile=FlatRounded(radius=1.0, flat_half_length=case.flat) if case.flat else Hertz(radius=1.0),
        friction=Friction(coefficient=case.friction),
        load=load,
    )


def plain_gauss(case: Case, contact: Contact, nodes: int) -> float:
    """W = (f A/pi) int |u' or v'| Lam(P, P_c) dt by Gauss' rule on each phase, P - P_c without cancellation (theory, section 4)."""
    # notation: U, V phasors of u = Q - f P and v = Q + f P; E max u, G min v, I min u, J where the front passes G, M = E
    phase, f = (case.phase if case.radians else math.radians(case.phase)), case.friction
    wave = case.tangential * np.exp(-1j * phase)
    u, v = wave - f * case.amplitude, wave + f * case.amplitude
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
        area = contact.dissipation_kernel(case.mean + case.amplitude * np.cos(t), slipped(t))
        total += (end - begin) / 2 * float(np.sum(weight * size * np.abs(np.sin(t - turn)) * area))
    return 2 * f / math.pi * total


def loads(case: Case, steps: int) -> list[tuple[float, float]]:
    """(P, Q) at the ends of equal steps of one revolution, blind to the turning points."""
    phase = case.phase if case.radians else math.radians(case.phase)
    t = 2 * np.pi * (np.arange(1, steps + 1) - 0.123) / steps
    p, q = case.mean + case.amplitude * np.cos(t), case.tangential * np.cos(t - phase)
    return list(zip(p.tolist(), q.tolist(), strict=True))


def straight_steps(case: Case, scene: Scene, steps: int) -> float:
    """The memory curve of the theory, stepped along a polygon."""
    cycle = loads(case, steps)
    rows = [(float(k), *pair) for k, pair in enumerate([cycle[-1], *cycle])]
    series = scene.vary(load=TimeSeriesLoad(rows=rows, repeats=True))
    return semi_analytic.solve(series, x=[0.0], cycles="steady", fields=("dissipation",)).dissipation


def discretised(case: Case, elements: int) -> float:
    """The naive peer; its increments are as short as its elements, five of them for two elements."""
    half = 1.02 * float(half_width_of(case, case.mean + case.amplitude))
    on = peer.grid(half, elements, 1.0)
    gap = peer.flat_rounded_gap(1.0, case.flat) if case.flat else peer.hertz_gap(1.0)
    cycle = loads(case, 5 * elements // 2)
    initial_loading = [(part * cycle[-1][0], part * cycle[-1][1]) for part in np.linspace(0, 1, 11)[1:].tolist()]
    return peer.dissipation(on, gap, initial_loading, cycle, case.friction)[0]


def product(case: Case, scene: Scene) -> float:
    """The engine's own rule."""
    return float(
        semi_analytic.dissipation(
            profile=scene.profile,
            material=scene.material,
            friction_coefficient=case.friction,
            mean_normal_load=case.mean,
            normal_amplitude=case.amplitude,
            mean_tangential_load=0.0,
            tangential_amplitude=case.tangential,
            phase=case.phase if case.radians else math.radians(case.phase),
        ).value
    )


def study(name: str) -> dict[str, list[Point]]:
    """Every method on one of the cases."""
    return methods_on(CASES[name], mp.mpf(json.loads(FILE.read_text(encoding="utf-8"))[name]))


def methods_on(case: Case, exact: mp.mpf) -> dict[str, list[Point]]:
    """Every method on a case whose dissipation is `exact`."""
    scene = scene_of(case)
    contact = contact_of(scene.profile, scene.material)

    def points(sizes: tuple[int, ...], work: Callable[[int], float]) -> list[Point]:
        found = []
        for size in sizes:
            try:
                value, seconds = timed(lambda size=size: work(size))
            except peer.NotSolvedError:
                continue  # a grid that slides altogether has no answer; the table shows one row less
            found.append(Point(size, max(float(abs(value / exact - 1)), FLOOR), seconds))
        return found

    return {
        "plain Gauss": points(NODES, lambda nodes: plain_gauss(case, contact, nodes)),
        "the engine's rule": points((1,), lambda _: product(case, scene)),
        "straight steps": points(STEPS, lambda steps: straight_steps(case, scene, steps)),
        "discretised": points(ELEMENTS, lambda elements: discretised(case, elements)),
    }


def order(points: list[Point]) -> float:
    """Observed order: slope of log error against log size, least squares."""
    size, error = (np.log([getattr(point, key) for point in points]) for key in ("size", "error"))
    return -float(np.polyfit(size, error, 1)[0])


def seconds_for(points: list[Point], target: float) -> tuple[float, str]:
    """Time that an error takes: measured where reached, else from the order and from how the time grew with the last doubling."""
    if reached := [point.seconds for point in points if point.error <= target]:
        return min(reached), "measured"
    if len(points) < 2 or points[-1].size in NODES or (rate := order(points)) < 0.5:
        return math.inf, "not reached"
    before, last = points[-2:]
    growth = max(math.log(last.seconds / before.seconds) / math.log(last.size / before.size), 1.0)
    seconds = last.seconds * (last.error / target) ** (growth / rate)
    return (math.inf, "more than a year") if seconds > YEAR else (seconds, "extrapolated")


SIZES = {"plain Gauss": "nodes a phase", "straight steps": "steps a revolution", "discretised": "elements"}


def rows(found: dict[str, dict[str, list[Point]]] | None = None) -> Iterator[Row]:
    """The claims: what the engine's rule leaves, the orders of the others, the time that each needs."""
    found = found or {name: study(name) for name in CASES}
    for name, methods in found.items():
        (own,) = methods["the engine's rule"]
        yield Row(f"{name}: the engine's rule, relative error", own.error, 1e-12, f"{own.seconds * 1e3:.2g} ms")
        for method, unit in SIZES.items():
            points = methods[method]
            if not points:
                yield Row(f"{name}: {method}", math.nan, None, "no answer on any grid")
                continue
            last = points[-1]
            yield Row(f"{name}: {method}, relative error", last.error, None, f"{last.size} {unit}, {last.seconds * 1e3:.2g} ms")
            if method != "plain Gauss":
                yield Row(f"{name}: {method}, observed order", order(points), None, f"{points[0].size} to {last.size} {unit}")
        for target in TARGETS:
            for method, points in methods.items():
                seconds, how = seconds_for(points, target)
                yield Row(f"{name}: {method}, time to {target:g}", seconds, None, how, "s")


def references() -> None:
    """Store the references."""
    mp.mp.dps = 2 * DIGITS
    found = {}
    for name, case in CASES.items():
        found[name] = mp.nstr(dissipation(case), DIGITS)
        print(name, found[name], flush=True)
    FILE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--references", action="store_true", help="evaluate the 30-digit references anew")
    if arguments.parse_args().references:
        references()
    found = {name: study(name) for name in CASES}
    print(table(list(rows(found))))
    from performance_half_plane import draw, plain

    OUT.mkdir(exist_ok=True)
    draw(plain(found), OUT)


if __name__ == "__main__":
    main()
