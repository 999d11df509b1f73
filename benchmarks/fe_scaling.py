"""How the FE model's cost grows with contact nodes, bulk and steps; what condensing by elimination is worth; the large case.

    python benchmarks/fe_scaling.py

CPU times of one thread, all within one run; a fitted exponent is the least-squares slope of log(time) over log(size). No condensed
body is read from the store.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from claim import Row, table
from threadpoolctl import threadpool_limits

import halfplane_fe
from halfplane_fe import SolverSettings
from halfplane_fe.elasticity import assemble, condense, factorise
from meshes import BodyMesh, MeshSettings, SurfaceGrading, half_disc, solid
from scenes import Block, Elastic, Hertz, load_scene

STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
STEEPEST = 2.2


class PathClock:
    """A `progress` that notes the CPU time at which the load path begins."""

    def __init__(self) -> None:
        self.began: float | None = None

    def __call__(self, done: int, total: int | None, text: str) -> None:
        if text == "initial loading" and self.began is None:
            self.began = time.process_time()


def path_cost(mesh: MeshSettings, steps: int) -> tuple[float, int, int]:
    """CPU seconds of hertz-paper's load path, contact nodes, increments; increments are never halved."""
    clock = PathClock()
    solver = SolverSettings(steps_per_cycle=steps, step_tolerance=float("inf"))
    answer = halfplane_fe.solve(load_scene("hertz-paper"), mesh, solver, clock)
    return time.process_time() - (clock.began or 0.0), len(answer.x), answer.work.counts["steps solved"]


def exponent(sizes: list[float], costs: list[float]) -> float:
    """Slope of log(cost) over log(size)."""
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def body(edge: int, growth: float) -> BodyMesh:
    """A half-disc of a/`edge` elements on 0.4 < |x| < 1.1, as the paper's cycle asks for."""
    return half_disc("lower", SurfaceGrading(0.4, 1.1, 1 / 24, 1 / edge, 10.0), growth)


def condensation_cost(edge: int, growth: float) -> tuple[float, int, int]:
    """CPU seconds of condensing, contact nodes, degrees of freedom."""
    mesh = body(edge, growth)
    start = time.process_time()
    found = condense(mesh, STEEL, 1.0)
    return time.process_time() - start, len(found.x), int(found.diagnostics["degrees_of_freedom"])


def growth_in_size() -> Iterator[Row]:
    """Fitted exponents in contact nodes, bulk degrees of freedom and steps."""
    nodes = [path_cost(MeshSettings(edge_element_size=1 / n), 96) for n in (80, 160, 320, 480)]
    seconds, count, increments = (list(column) for column in zip(*nodes, strict=True))
    each = [s / n for s, n in zip(seconds, increments, strict=True)]
    how = ", ".join(f"{n} nodes {1e3 * s:.2f} ms" for n, s in zip(count, each, strict=True))
    yield Row("cost of an increment, exponent in contact nodes", exponent(count, each), STEEPEST, how)
    how = ", ".join(f"{n} nodes {i} increments {s:.2f} s" for n, i, s in zip(count, increments, seconds, strict=True))
    yield Row(
        "cost of two revolutions, exponent in contact nodes", exponent(count, seconds), STEEPEST, f"{how}: every touch is met"
    )
    steps = [path_cost(MeshSettings(edge_element_size=1 / 40), n) for n in (200, 400, 800, 1600)]
    seconds, _, increments = (list(column) for column in zip(*steps, strict=True))
    how = ", ".join(f"{i} increments {s:.2f} s" for i, s in zip(increments, seconds, strict=True))
    yield Row("cost of two revolutions, exponent in increments", exponent(increments, seconds), STEEPEST, how)
    for what, cases, which in (
        ("contact nodes", [(n, 0.2) for n in (80, 160, 320, 480)], 1),
        ("bulk degrees of freedom", [(80, g) for g in (0.2, 0.1, 0.05, 0.03)], 2),
    ):
        costs = [condensation_cost(*case) for case in cases]
        how = ", ".join(f"{cost[which]} {cost[0]:.2f} s" for cost in costs)
        found = exponent([cost[which] for cost in costs], [cost[0] for cost in costs])
        yield Row(f"condensation, exponent in {what}", found, STEEPEST, how)


def condensation_ways() -> Iterator[Row]:
    """Elimination with the contact nodes last against one sparse solve for each unit force, and against no condensation."""
    # A block on a fixed base, so that there is no arc and only the algebra differs.
    block, grading = Block(width=20.0, height=10.0), SurfaceGrading(0.4, 1.1, 1 / 24, 1 / 160)
    mesh = solid("lower", block, Hertz(radius=1000.0), grading, 0.2)
    start = time.process_time()
    found = condense(mesh, STEEL, 1.0)
    eliminated = time.process_time() - start
    start = time.process_time()
    compliance, factor_and_solve = compliance_by_unit_forces(mesh)
    solved = time.process_time() - start
    difference = float(np.abs(compliance - found.compliance).max() / np.abs(found.compliance).max())
    dof = int(found.diagnostics["degrees_of_freedom"])
    how = f"{len(found.x)} contact nodes, {dof} dof: {eliminated:.2f} s against {solved:.2f} s"
    yield Row(
        "elimination with the contact nodes last: times faster than a solve for each unit force", solved / eliminated, None, how
    )
    yield Row("... the two compliances differ by", difference, 1e-9, "over the largest entry; both symmetric parts")
    answer = halfplane_fe.solve(load_scene("hertz-paper"))
    iterations = answer.work.counts["contact iterations"]
    own = eliminated + answer.work.seconds["load path"]
    how = f"{iterations} contact iterations, each a sparse factorisation and solve of both bodies ({2 * factor_and_solve:.2f} s)"
    yield Row(
        "condensed: times faster than without condensation", 2 * iterations * factor_and_solve / own, None, how + ", reckoned"
    )


def compliance_by_unit_forces(mesh: BodyMesh) -> tuple[np.ndarray, float]:
    """The compliance of a body on fixed supports by unit forces; and the CPU time of a factorisation with one solve."""
    # The parts of the model's own assembly, so that only the algebra differs.
    system = assemble(mesh, STEEL)
    rows = system.stiffness[system.free]
    start = time.process_time()
    factors = factorise(rows[:, system.free].tocsc())
    factors.solve(np.ones(len(system.free)))
    once = time.process_time() - start
    n = system.contact.size
    place = np.full(system.stiffness.shape[0], -1)
    place[system.free] = np.arange(len(system.free))
    contact = place[system.contact.ravel()]
    compliance = np.empty((n, n))
    for first in range(0, n, 64):
        columns = np.arange(first, min(first + 64, n))
        right = np.zeros((len(system.free), len(columns)))
        right[contact[columns], np.arange(len(columns))] += 1.0
        compliance[:, columns] = factors.solve(right)[contact]
    return ((compliance + compliance.T) / 2).reshape(2, n // 2, 2, n // 2), once


def large_case() -> tuple[int, int, float, float]:
    """Contact nodes, increments, CPU seconds and peak memory [GiB] of this process: 1,000 nodes, 400 steps, two revolutions."""
    answer = halfplane_fe.solve(
        load_scene("hertz-paper"), MeshSettings(edge_element_size=1 / 320), SolverSettings(steps_per_cycle=400)
    )
    # VmHWM is of this very process; ru_maxrss starts from its parent's.
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    peak = int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM"))) / 2**20
    return len(answer.x), answer.work.counts["steps solved"], time.process_time(), peak


def large() -> Iterator[Row]:
    """The large case in a process of its own, so that the peak of memory is its own too."""
    text = subprocess.run([sys.executable, __file__, "--large"], check=True, capture_output=True, text=True).stdout
    nodes, increments, seconds, peak = text.split()
    how = f"{nodes} contact nodes a side, 400 regular steps a cycle, {increments} increments in two cycles, imports included"
    yield Row("hertz-paper, large: CPU time", float(seconds), 120.0, how, "s")
    yield Row("hertz-paper, large: peak memory", float(peak), 2.0, how, "GiB")


def scaling() -> Iterator[Row]:
    """All rows of this page."""
    with threadpool_limits(limits=1, user_api="blas"):
        yield from large()
        yield from condensation_ways()
        yield from growth_in_size()


def main() -> None:
    os.environ["HALFPLANE_CACHE"] = "off"  # every run condenses its bodies itself
    if "--large" in sys.argv:
        print(*large_case())
        return
    print(table(list(scaling())))


if __name__ == "__main__":
    main()
