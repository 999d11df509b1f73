"""How CPU time and peak memory grow with everything that a user can make large; profiles of what dominates.

Each point is a process of its own, so that its peak of memory is its own: `performance_growth.py KIND SIZE` prints one as JSON. A
fitted exponent is the least-squares slope of log(cost) over log(size).
"""

from __future__ import annotations

import cProfile
import json
import os
import pstats
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fe_scaling
import sweep
from semi_analytic_histories import random_rows
from semi_analytic_speed import random_ellipses
from threadpoolctl import threadpool_limits

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.charts.publication import canvas, label_axes
from reports.charts.style import COLOURS
from reports.sweep.running import prepare, work
from reports.sweep.study import study_of
from scenes import Hertz, TimeSeriesLoad, load_scene

TITLE = "Growth of the cost"
RUNS = 1
MOST = 2.2  # the steepest exponent that is promised
Cost = tuple[float, float, int]  # size as counted, CPU seconds, how many times the thing was done


def path_of(edge: int) -> Cost:
    """Two revolutions of hertz-paper, which have the more touches the finer the mesh; and each of their increments."""
    seconds, nodes, steps = fe_scaling.path_cost(MeshSettings(edge_element_size=1 / edge), 96)
    return nodes, seconds, steps


def steps_of(count: int) -> Cost:
    """Two revolutions of hertz-paper, by increments."""
    seconds, _, steps = fe_scaling.path_cost(MeshSettings(edge_element_size=1 / 40), count)
    return steps, seconds, 1


def condensation_of(edge: int) -> Cost:
    """Condensation, by contact nodes."""
    seconds, nodes, _ = fe_scaling.condensation_cost(edge, 0.2)
    return nodes, seconds, 1


def bulk_of(inverse: int) -> Cost:
    """Condensation, by degrees of freedom of the bulk; the contact nodes stay as they are."""
    seconds, _, dof = fe_scaling.condensation_cost(80, 1 / inverse)
    return dof, seconds, 1


def history_of(rows: int) -> Cost:
    """W of every step of a history of random rows."""
    scene = load_scene("hertz-paper")
    scene = scene.vary(load=TimeSeriesLoad(rows=random_rows(scene, rows)))
    return rows, _spent(lambda: semi_analytic.solve(scene, fields=("dissipation",))), 1


def batch_of(members: int) -> Cost:
    """W of a batch of random ellipses."""
    ellipses = random_ellipses(members)
    return members, _spent(lambda: semi_analytic.dissipation(profile=Hertz(radius=1.0), **ellipses)), 1


def theory_points_of(points: int) -> Cost:
    """A sweep of half-plane theory, its points solved one by one."""
    axis = {"name": "f", "key": "friction.coefficient", "linear": {"start": 0.9, "stop": 2, "count": points}}
    return points, _swept(sweep.EXACT | {"axes": [axis]}), 1


def fe_points_of(points: int) -> Cost:
    """A sweep of the finite elements over blocks of several heights, coarse meshes, one process."""
    axis = {
        "name": "height",
        "keys": ["bodies.lower.height", "bodies.upper.height"],
        "logarithmic": {"start": 4, "stop": 32, "count": points},
    }
    return points, _swept(sweep.FE | {"axes": [axis]}), 1


def _swept(asked: dict[str, Any]) -> float:
    study = study_of(asked, "benchmark")
    with tempfile.TemporaryDirectory() as folder:
        return _spent(lambda: work(prepare(study, Path(folder) / "out"), workers=1))


def _spent(task: Callable[[], Any]) -> float:
    """CPU seconds, those of finished child processes included."""
    before = _cpu()
    task()
    return _cpu() - before


def _cpu() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


KINDS: dict[str, tuple[Callable[[int], Cost], tuple[int, ...], str, str]] = {
    "path": (path_of, (40, 80, 160, 320), "contact nodes", "two revolutions, every touch met"),
    "steps": (steps_of, (200, 400, 800, 1600), "increments", "two revolutions on a/40"),
    "condensation": (condensation_of, (40, 80, 160, 320), "contact nodes", "condensation of a body"),
    "bulk": (bulk_of, (5, 10, 20, 33), "bulk degrees of freedom", "condensation of a body"),
    "history": (history_of, (1_000, 10_000, 100_000, 1_000_000), "rows of a history", "theory, W of every step"),
    "batch": (batch_of, (1_000, 10_000, 100_000, 1_000_000), "members of a batch", "theory, W of each"),
    "theory points": (theory_points_of, (25, 50, 100), "points of a sweep", "theory, one by one"),
    "FE points": (fe_points_of, (2, 4, 8), "points of a sweep", "finite elements, coarse"),
}


def memory() -> float:
    """Peak of this process in MB; ru_maxrss starts from its parent's."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM"))) * 1024 / 1e6


def one(kind: str, size: int) -> dict[str, float]:
    """Least cost of the runs of a point, and the peak of memory beyond what the imports take."""
    imported, task = memory(), KINDS[kind][0]
    with threadpool_limits(limits=1, user_api="blas"):
        found = [task(size) for _ in range(RUNS)]
    seconds = [seconds for _, seconds, _ in found]
    return {
        "size": found[0][0],
        "seconds": min(seconds),
        "most seconds": max(seconds),
        "each": min(seconds) / found[0][2],
        "memory": memory() - imported,
        "imports": imported,
    }


def exponent(points: list[dict[str, float]], key: str = "seconds") -> float:
    """Slope of log(cost) over log(size)."""
    return fe_scaling.exponent([point["size"] for point in points], [max(point[key], 1e-9) for point in points])


def profile(work: Callable[[], Any], count: int = 8) -> dict[str, Any]:
    """Shares of the time in functions themselves, calls below them left out; the profiler's own cost falls on many small ones."""
    profiler = cProfile.Profile()
    profiler.runcall(work)
    stats = pstats.Stats(profiler)
    total = sum(entry[2] for entry in stats.stats.values())  # type: ignore[attr-defined]
    rows = sorted(stats.stats.items(), key=lambda item: -item[1][2])[:count]  # type: ignore[attr-defined]
    named = [(_place(*place), calls, own / total) for place, (_, calls, own, _, _) in rows]
    return {"seconds": total, "functions": named}


def _place(file: str, line: int, name: str) -> str:
    """Function with the package or project file that it is from."""
    parts = Path(file).parts
    for top in ("site-packages", "halfplane_fe", "semi_analytic", "meshes", "scenes", "reports"):
        if top in parts:
            found = "/".join(parts[parts.index(top) + (top == "site-packages") :])
            return f"{name} ({found})"
    return name if file == "~" else f"{name} ({Path(file).name})"


def profiles() -> dict[str, Any]:
    """What dominates in the jobs that people wait for."""
    paper, rows = load_scene("hertz-paper"), load_scene("hertz-paper")
    rows = rows.vary(load=TimeSeriesLoad(rows=random_rows(rows, 100_000)))
    found = {
        "hertz-paper, finite elements, default": lambda: halfplane_fe.solve(paper),
        "blocks, finite elements, coarse": lambda: halfplane_fe.solve(load_scene("blocks"), MeshSettings.coarse()),
        "hertz-paper, theory": lambda: semi_analytic.solve(paper),
        "10^5 rows, theory, W of every step": lambda: semi_analytic.solve(rows, fields=("dissipation",)),
    }
    return {name: profile(work) for name, work in found.items()}


def stages() -> dict[str, dict[str, float]]:
    """Seconds by stage of the finite elements, as the solution states them (wall time of each)."""
    found = {}
    for name, mesh in (("hertz-paper", MeshSettings()), ("blocks", MeshSettings()), ("cattaneo-mindlin", MeshSettings())):
        found[name] = dict(halfplane_fe.solve(load_scene(name), mesh, SolverSettings()).work.seconds)
    return found


def measure() -> dict[str, Any]:
    """All kinds, each point in a process of its own; then profiles."""
    found: dict[str, list[dict[str, float]]] = {}
    for kind, (_, sizes, _, _) in KINDS.items():
        found[kind] = []
        for size in sizes:
            command = [sys.executable, __file__, kind, str(size)]
            found[kind].append(json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))
        print(f"    {kind}: exponent {exponent(found[kind]):.2f}", flush=True)
    return {"growth": found, "profiles": profiles(), "stages": stages()}


def draw(found: dict[str, Any], folder: Path) -> None:
    """Time and memory over size, a panel a kind."""
    marks = "os^DvP*Xh"
    with canvas(9.6, 4.6) as figure:
        axes = figure.subplots(1, 2)
        for number, (kind, points) in enumerate(found["growth"].items()):
            _, _, unit, what = KINDS[kind]
            look = {"color": COLOURS[number % len(COLOURS)], "marker": marks[number], "ms": 5, "lw": 1.2}
            size = [point["size"] for point in points]
            axes[0].loglog(size, [point["seconds"] for point in points], label=f"{what}, by {unit}", **look)
            axes[1].loglog(size, [max(point["memory"], 0.1) for point in points], **look)
        label_axes(axes[0], "size, in its own unit", "CPU time [s]", "CPU time")
        label_axes(axes[1], "size, in its own unit", "peak memory beyond imports [MB]", "Peak memory")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="lower center", ncols=2, frameon=False, fontsize=8)
        figure.tight_layout(rect=(0, 0.25, 1, 1))
        figure.savefig(folder / "growth.svg", metadata={"Date": None})


def page(found: dict[str, Any]) -> list[str]:
    """Exponents, memory, profiles."""
    lines = [
        "![CPU time and peak memory over size](performance/growth.svg)",
        "",
        f"Each point in a process of its own, {RUNS} run. The exponent is the slope of log(time) over log(size), over "
        "all sizes, small ones with what a process does once, and between the two largest; "
        "memory is the peak of the process beyond what its imports take. hertz-paper but where another scene is named.",
        "",
        "| cost of | by | sizes | CPU time [s] | exponent: all; last two | peak memory [MB] |",
        "|---|---|---|---|---|---|",
    ]
    for kind, points in found["growth"].items():
        _, _, unit, what = KINDS[kind]
        cells = (
            ", ".join(f"{point['size']:,.0f}" for point in points),
            ", ".join(f"{point['seconds']:.3g}" for point in points),
            f"{exponent(points):.2f}; {exponent(points[-2:]):.2f}",
            ", ".join(f"{point['memory']:.0f}" for point in points),
        )
        lines.append(f"| {what} | {unit} | {' | '.join(cells)} |")
        if kind == "path":
            each = ", ".join(f"{1e3 * point['each']:.2f} ms" for point in points)
            lines.append(
                f"| one increment of them | {unit} | {cells[0]} | {each} | "
                f"{exponent(points, 'each'):.2f}; {exponent(points[-2:], 'each'):.2f} | |"
            )
    steep = [kind for kind, points in found["growth"].items() if max(exponent(points), exponent(points[-2:])) > MOST]
    lines += ["", f"No exponent is above {MOST:g}." if not steep else f"Steeper than {MOST:g}, as is promised: {', '.join(steep)}."]
    lines += [
        "Histories of up to 1,000 rows are followed leg by leg with all events, longer ones row by row: hence the dearer first "
        "point. The large case (1,000 contact nodes a side, 400 steps) has its time and memory on the page of numbers.",
        "",
        "### What dominates",
        "",
        "Wall seconds by stage, default mesh, nothing from the store:",
        "",
        *_stage_table(found["stages"]),
    ]
    for name, one_profile in found["profiles"].items():
        lines += ["", f"{name}: {one_profile['seconds']:.2f} s under cProfile, shares of functions themselves:", ""]
        lines += ["| function | calls | share |", "|---|---|---|"]
        lines += [f"| `{place}` | {calls:,} | {share:.0%} |" for place, calls, share in one_profile["functions"]]
    return lines


def _stage_table(stages_of: dict[str, dict[str, float]]) -> list[str]:
    names = list(next(iter(stages_of.values())))
    lines = [f"| scene | {' | '.join(names)} |", "|---" * (len(names) + 1) + "|"]
    return lines + [f"| {scene} | {' | '.join(f'{seconds[name]:.2f}' for name in names)} |" for scene, seconds in stages_of.items()]


if __name__ == "__main__":
    os.environ["HALFPLANE_CACHE"] = "off"
    print(json.dumps(one(sys.argv[1], int(sys.argv[2]))))
