"""Work and precision of the FE model: what mesh size, order, grading, increments and method cost and what they buy.

    python benchmarks/fe_precision.py

The truth is the half-plane engine. The error of the dissipation is split in two by a third figure, the exact dissipation of the
polygon that the FE model's own increments are: FE against it is the mesh's part, it against the ellipse the increments' part. Times
are CPU times and hold everything from the coarse run to the answer; no condensation is read from the store. The sweep is printed,
and drawn into out/fe_precision.png; the rows hold the figures that were promised.
"""

from __future__ import annotations

import functools
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from claim import Row, table

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from meshes import MeshSettings
from reports.charts.publication import canvas, label_axes
from reports.charts.style import COLOURS
from scenes import load_scene

FIGURE = Path(__file__).parent.parent / "out" / "fe_precision.png"


@dataclass(frozen=True)
class Setting:
    """One point of the sweep: how the bodies are cut and the path is followed."""

    text: str
    mesh: MeshSettings
    solver: SolverSettings = field(default_factory=SolverSettings)


COARSE = Setting("coarse", MeshSettings.coarse())
DEFAULT = Setting("default", MeshSettings())
FINE = Setting("fine", MeshSettings.fine(), SolverSettings(steps_per_cycle=192))


@dataclass(frozen=True)
class Measured:
    """What one run cost and how far it is off, dissipations relative; where theory has no answer, all of an error is the mesh's.

    Attributes
    ----------
    seconds : CPU time
    error, mesh_part, increment_part : of the dissipation; the first is the sum of the others to first order
    shear : rms over the instants of the last cycle of the L2 error of q over f ||p||; None where theory has no answer
    loop_mesh_part, loop_corners : of the closed integral of Q dU over the instants of the last cycle, against that of theory at
        these instants, and of that against the loop without corners
    """

    seconds: float
    error: float
    mesh_part: float
    increment_part: float
    shear: float | None
    loop_mesh_part: float
    loop_corners: float
    nodes: int
    increments: int


@functools.cache
def measure(name: str, setting: Setting, truth: float | None = None) -> Measured:
    """Run the FE model once on a scene of the library and compare with theory; `truth` is the dissipation where theory has none."""
    scene = load_scene(name)
    start = time.process_time()
    answer = halfplane_fe.solve(scene, setting.mesh, setting.solver)
    seconds = time.process_time() - start
    counts = {"nodes": len(answer.x), "increments": answer.work.counts["steps solved"]}
    if truth is not None:
        error = answer.dissipation / truth - 1
        return Measured(seconds, error, error, 0.0, None, answer.loop_work / truth - 1, 0.0, **counts)
    return Measured(seconds, *_beside_theory(answer), **counts)


def _beside_theory(answer: FiniteElementSolution) -> tuple[float, float, float, float, float, float]:
    """The errors of `Measured`, in its order."""
    scene = answer.scene
    truth = semi_analytic.solve(scene).dissipation
    stepped = semi_analytic.solve(
        scene, x=[0.0], time=answer.time, straight_steps=True, fields=("dissipation", "tangential_displacement")
    )
    polygon = stepped.dissipation
    loop = np.trapezoid(answer.tangential_load[answer.last_cycle], stepped.tangential_displacement[answer.last_cycle])
    cycle = answer.last_cycle[:: max(1, len(answer.last_cycle) // 60)]
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time[: cycle[-1] + 1], fields=("pressure", "shear"))
    off = np.trapezoid((answer.shear[cycle] - exact.shear[cycle]) ** 2, answer.x, axis=1)
    size = np.trapezoid(exact.pressure[cycle] ** 2, answer.x, axis=1) * scene.friction.coefficient**2
    return (
        answer.dissipation / truth - 1,
        answer.dissipation / polygon - 1,
        polygon / truth - 1,
        float(np.sqrt(np.mean(off / size))),
        float(answer.loop_work - loop) / truth,
        float(loop / truth - 1),
    )


def sizes(order: int, cut: tuple[int, ...], coarser: int | None, growth: float = MeshSettings().growth) -> list[Setting]:
    """Meshes of a/n at the edges for n in `cut`; of a/`coarser` in the middle, or as fine there as at the edges."""
    found = []
    for n in cut:
        middle = 1 / n if coarser is None else max(1 / coarser, 1 / n)
        mesh = MeshSettings(element_size=middle, edge_element_size=1 / n, order=order, growth=growth)
        found.append(Setting(f"a/{n}", mesh))
    return found


def sweep() -> dict[str, list[Setting]]:
    """Every series of the table and of the figure."""
    free = float("inf")
    return {
        "named settings": [COARSE, DEFAULT, FINE],
        "quadratic, graded": sizes(2, (10, 20, 40, 80, 160, 320), 24),
        "quadratic, uniform": sizes(2, (10, 20, 40, 80, 160), None),
        "linear, graded": sizes(1, (20, 40, 80, 160, 320), 24),
        "linear, slow growth": sizes(1, (20, 40, 80, 160, 320), 24, growth=0.05),
        "increments, a/160": [
            Setting(f"{n} a turn", MeshSettings(), SolverSettings(steps_per_cycle=n, step_tolerance=free)) for n in (8, 24, 96, 384)
        ],
        "penalty, a/160": [
            Setting(
                f"{k:g} E*/h",
                MeshSettings(),
                SolverSettings(method="penalty", normal_stiffness=k, tangential_stiffness=k),
            )
            for k in (1.0, 10.0, 1e2, 1e3)
        ],
    }


@functools.cache
def measured_sweep() -> dict[str, list[tuple[Setting, Measured]]]:
    """The sweep on the paper's cycle of Hertz contact; about a minute and a half."""
    return {name: [(setting, measure("hertz-paper", setting)) for setting in series] for name, series in sweep().items()}


def precision() -> Iterator[Row]:
    """The promised figures of error against time, and the error in its two parts."""
    for name, setting, within, seconds in (
        ("hertz-paper", DEFAULT, 5e-4, 5.0),
        ("flat-rounded-paper", DEFAULT, 1e-3, 10.0),
        ("hertz-paper", FINE, 1e-4, 60.0),
    ):
        size = f"a/{1 / setting.mesh.edge_element_size:.0f}"
        found = measure(name, setting)
        how = f"h = {size} at the edges, {found.nodes} contact nodes, {found.increments} increments"
        what = f"{name}, FE, {size}"
        yield Row(f"{what}: dissipation", found.error, within, how)
        yield Row(f"{what}: ... of that by the mesh", found.mesh_part, None, "against the exact polygon of its own increments")
        yield Row(f"{what}: ... of that by the increments", found.increment_part, None, "that polygon against the ellipse")
        yield Row(f"{what}: CPU time, set-up included", found.seconds, seconds, "mesh, condensation, revolutions", "s")


def sweep_table() -> str:
    """The sweep in columns."""
    lines = [f"{'':12s}{'CPU s':>8s}{'W':>10s}{'by mesh':>10s}{'by steps':>10s}{'q, L2':>10s}{'nodes':>7s}{'steps':>7s}"]
    for name, series in measured_sweep().items():
        lines.append(name)
        for setting, m in series:
            errors = "".join(f"{value:10.1e}" for value in (m.error, m.mesh_part, m.increment_part, m.shear))
            lines.append(f"{setting.text:>12s}{m.seconds:8.2f}{errors}{m.nodes:7d}{m.increments:7d}")
    return "\n".join(lines)


# The penalty's errors change sign, and the named settings differ in several ways at once: points, no line.
_POINTS = ("named settings", "penalty, a/160")


def draw(path: Path) -> None:
    """Error over CPU time, log-log: dissipation on the left, shear on the right."""
    marks = ("*", "o", "s", "^", "P", "D", "v")
    with canvas(9.6, 5.0) as figure:
        axes = figure.subplots(1, 2, sharex=True)
        for (name, series), colour, mark in zip(
            measured_sweep().items(), ("#333333", *COLOURS[:5], COLOURS[6]), marks, strict=True
        ):
            seconds = [m.seconds for _, m in series]
            look = {"color": colour, "marker": mark, "ms": 11 if mark == "*" else 5, "mec": "white", "mew": 0.5, "label": name}
            for one, values in zip(axes, ([abs(m.error) for _, m in series], [m.shear for _, m in series]), strict=True):
                one.loglog(seconds, values, ls="none" if name in _POINTS else "-", zorder=3 if mark == "*" else 2, **look)
        for one, what, title in (
            (axes[0], "|W / W exact - 1|", "Dissipation of a cycle, hertz-paper"),
            (axes[1], "L2 of q over f ||p||, rms of the cycle", "Shear traction, hertz-paper"),
        ):
            label_axes(one, "CPU time, set-up included [s]", what, title)
            one.set_xticks([0.5, 1, 2, 5, 10, 20, 50], ["0.5", "1", "2", "5", "10", "20", "50"])
            one.minorticks_off()
        handles, names = axes[0].get_legend_handles_labels()
        figure.legend(handles, names, loc="lower center", ncols=4, frameon=False)
        figure.tight_layout(rect=(0, 0.11, 1, 1))
        path.parent.mkdir(exist_ok=True)
        figure.savefig(path, dpi=150)


def main() -> None:
    os.environ["HALFPLANE_CACHE"] = "off"  # every run condenses its bodies itself
    print(sweep_table(), flush=True)
    draw(FIGURE)
    print(table(list(precision())))


if __name__ == "__main__":
    main()
