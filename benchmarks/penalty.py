"""What the penalty method costs against the exact law, over six decades of its stiffness; and that the exact law knows none.

python benchmarks/penalty.py
"""

from __future__ import annotations

import functools
from collections.abc import Iterator

import numpy as np
from claim import Row, table

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from meshes import MeshSettings
from scenes import Elastic, Materials, load_scene

SCENES = ("cattaneo-mindlin", "hertz-paper")
STIFFNESS = tuple(10.0**k for k in range(7))
MESH = MeshSettings(element_size=1 / 16, edge_element_size=1 / 60)
UNLIKE = Materials(upper=Elastic(young_modulus=70e3, poisson_ratio=0.33), lower=Elastic(young_modulus=210e3, poisson_ratio=0.3))


@functools.cache
def run(name: str, method: str, stiffness: float) -> FiniteElementSolution:
    """Without halving of increments, so that all runs have their regular instants in common."""
    scene = load_scene(name.removesuffix(", unlike"))
    if name.endswith("unlike"):
        scene = scene.vary(material=UNLIKE)
    settings = SolverSettings(
        method=method,  # type: ignore[arg-type]
        normal_stiffness=stiffness,
        tangential_stiffness=stiffness,
        steps_per_cycle=48,
        step_tolerance=np.inf,
    )
    return halfplane_fe.solve(scene, MESH, settings)


def common_steps(one: FiniteElementSolution, other: FiniteElementSolution) -> tuple[np.ndarray, np.ndarray]:
    """Steps of the last cycle at the instants that both answers have."""
    times = np.round(one.time, 9), np.round(other.time, 9)
    shared = np.intersect1d(*times)
    shared = shared[shared >= np.round(other.time[other.last_cycle[0]], 9)]
    return np.searchsorted(times[0], shared), np.searchsorted(times[1], shared)


def ladder(name: str) -> dict[str, np.ndarray]:
    """Each quantity over STIFFNESS; forces over the largest pressure, dissipation relative."""
    exact = run(name, "augmented_lagrangian", 1e3)
    truth = semi_analytic.solve(exact.scene, x=[0.0], time=exact.time, fields=("dissipation",)).dissipation
    largest = exact.pressure.max()
    rows = []
    for stiffness in STIFFNESS:
        soft = run(name, "penalty", stiffness)
        here, there = common_steps(soft, exact)
        audit = soft.penalty
        rows.append(
            {
                "pressure": np.abs(soft.pressure[here] - exact.pressure[there]).max() / largest,
                "shear": np.abs(soft.shear[here] - exact.shear[there]).max() / largest,
                "dissipation": soft.dissipation / exact.dissipation - 1,
                "dissipation against theory": soft.dissipation / truth - 1,
                "penetration over a^2/2R": audit.penetration_share,
                "elastic slip over the largest slip": audit.elastic_slip_share,
                "creep over the largest slip": audit.creep_share,
                "iterations per increment": soft.work.counts["contact iterations"] / soft.work.counts["steps solved"],
            }
        )
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


def penalty() -> Iterator[Row]:
    """The ladder's order, what the default stiffness costs, and the spread of the exact law over six decades."""
    for name in SCENES:
        found = ladder(name)
        stiff = np.log(np.array(STIFFNESS[3:]))
        for key in (
            "pressure",
            "shear",
            "dissipation",
            "penetration over a^2/2R",
            "elastic slip over the largest slip",
            "creep over the largest slip",
        ):
            order = -float(np.polyfit(stiff, np.log(np.abs(found[key][3:])), 1)[0])
            yield Row(f"{name}, penalty: {key}, order in 1/stiffness, less 1", order - 1, 0.05, "stiffness 1e3 to 1e6 E*/h")
        for key, values in found.items():
            if key != "iterations per increment":
                yield Row(f"{name}, penalty: {key}", float(values[3]), None, "default stiffness, 1e3 E*/h")
    for name in (*SCENES, "flat-rounded-paper", "hertz-paper, unlike"):
        answers = [run(name, "augmented_lagrangian", weight) for weight in (1e0, 1e3, 1e6)]
        yield Row(
            f"{name}, augmented Lagrangian: p and q over six decades of its weights, largest difference",
            spread(answers),
            1e-10,
            "over p0",
        )


def spread(answers: list[FiniteElementSolution]) -> float:
    """Largest difference of pressure or shear, over the largest pressure; infinite where the increments differ."""
    first, *others = answers
    if any(other.time.shape != first.time.shape for other in others):
        return float("inf")
    apart = [np.abs(getattr(other, key) - getattr(first, key)).max() for other in others for key in ("pressure", "shear")]
    return float(max(apart) / first.pressure.max())


def main() -> None:
    for name in SCENES:
        found = ladder(name)
        print(f"\n{name}, penalty; pressure, shear and dissipation against the exact law\n")
        print("| | " + " | ".join(f"k = {k:.0e}" for k in STIFFNESS) + " |\n" + "|---" * (len(STIFFNESS) + 1) + "|")
        for key, values in found.items():
            print(f"| {key} | " + " | ".join(f"{value:.2e}" for value in values) + " |")
    print("\n" + table(list(penalty())))


if __name__ == "__main__":
    main()
