"""docs/performance.md: error against CPU time, peers, growth of the cost and start-up, measured
now.

    make bench              (python benchmarks/performance.py [SECTION ...] [--pages], a quarter of
                            an hour)
    EARLIER=CHECKOUT make bench SECTIONS="speed records"
                            (CPU ratios to that checkout; left out without it)

Each section measures, writes what it found to docs/performance/SECTION.json with machine and
versions, draws its figure, and has its part of the page. With names of sections only those are
measured again; with --pages none is, and the page is written from the files. The machine may be
busy: ratios are of one run, times are CPU times unless they say otherwise.
"""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import finite_elements as fe
import half_plane
import jobs
import long_record
import numpy as np
import peers
import speed
from claims import ROOT, chosen, markdown, memory, seconds, stored, with_children, write_json
from finite_elements import COARSE, DEFAULT, FINE, FREE, Setting
from packages import build_wheel
from threadpoolctl import threadpool_limits

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from halfplane_fe.elasticity import condense
from meshes import MeshSettings, SurfaceGrading, half_disc
from reports.charts.plate import Axis, Curve, Dot, Key, Mark, Plate, axis_limits
from reports.charts.plate import Panel as ChartPanel
from scenes import Elastic, Hertz, TimeSeriesLoad, load_scene

PAGE = ROOT / "docs" / "performance.md"
FOLDER = ROOT / "docs" / "performance"
PACKAGES = ("halfplane", "numpy", "scipy", "scikit-fem", "gmsh")
# title, labels of x and y, points of each series
Panel = tuple[str, str, str, dict[str, list[tuple[float, float]]]]
Found = dict[str, Any]


# -------------------------------------------------------------- error against time: finite elements
# Better by more than MARGIN in one of time and error, in the other no worse than by SAME: CPU times
# vary by some ten per cent.
MARGIN = 0.25
SAME = 0.05
# Errors of W and of the loop below which none is better: those of the default mesh are 1e-5 in the
# median (benchmarks/covered.py).
SCATTER = {"work": 3e-5, "loop": 3e-5}
FINER = (
    MeshSettings(element_size=1 / 48, edge_element_size=1 / 320),
    SolverSettings(steps_per_cycle=192, step_tolerance=5e-5),
)
SCENES = ("hertz-paper", "flat-rounded-paper", "cattaneo-mindlin", "blocks")
SLOW = ("unlike-beta-fifth", "cylinder-roller")
EARLIER = os.environ.get("EARLIER", "")  # the folder of a checkout


def series(all_points: bool) -> dict[str, list[Setting]]:
    """What is varied, one thing at a time about the default; the dearest points only for the
    `whole` of it.
    """

    def cut(order: int, coarser: int | None, *counts: int) -> list[Setting]:
        """Meshes of a/n at the edges; of a/`coarser` in the middle, or as fine there as at the
        edges.
        """
        middle = {n: 1 / n if coarser is None else max(1 / coarser, 1 / n) for n in counts}
        return [
            Setting(f"a/{n}", MeshSettings(size, edge_element_size=1 / n, order=order))
            for n, size in middle.items()
        ]

    def turns(count: int, **changes: Any) -> Setting:
        return Setting(f"{count} a turn", solver=SolverSettings(steps_per_cycle=count, **changes))

    def soft(k: float) -> Setting:
        return Setting(
            f"{k:g} E*/h",
            solver=SolverSettings(method="penalty", normal_stiffness=k, tangential_stiffness=k),
        )

    return {
        "named settings": [COARSE, DEFAULT, *([FINE] if all_points else [])],
        "quadratic, graded": cut(2, 24, 10, 20, 40, 80, *((160, 320) if all_points else (240,))),
        "quadratic, uniform": cut(2, None, 10, 20, 40, *((80,) if all_points else ())),
        "linear, graded": cut(1, 24, 20, 40, 80, 160),
        "growth of the bulk": [
            Setting(f"growth {g:g}", replace(MeshSettings(), growth=g)) for g in (0.1, 0.4)
        ],
        "regular increments": [turns(n) for n in (12, 48, 96)],
        "increments, no tolerance": [
            turns(n, step_tolerance=FREE) for n in ((8, 24, 96, 384) if all_points else (8, 24, 96))
        ],
        "penalty, a/160": [soft(k) for k in (10.0, 1e2, 1e3)],
        "contact method": [
            Setting("augmented Lagrangian", solver=SolverSettings(method="augmented_lagrangian"))
        ],
    }


def point(text: str, errors: dict[str, float], exact_law: dict[str, float]) -> Found:
    """Size of the error, and of what a penalty layer adds to it."""

    def size(*parts: str) -> float:
        exact = sum(exact_law[part] for part in parts)
        total = sum(errors[part] for part in parts)
        return abs(exact) + abs(total - exact)

    work = size("error")
    loop = size("loop", "corners")
    return {
        "text": text,
        "seconds": errors["seconds"],
        "work": work,
        "shear": errors.get("shear"),
        "loop": loop,
    }


def precision() -> Found:
    """Every series on four scenes; on blocks the truth is the model itself, finer in everything."""
    # the first run of a process also reads what the later ones find
    fe.measure("hertz-paper", DEFAULT)
    fe.measure("hertz-paper", COARSE)
    scenes = {}
    for name in SCENES:
        reference = (
            halfplane_fe.solve(load_scene(name), *FINER).dissipation if name == "blocks" else None
        )
        fe.measure.cache_clear()
        exact_law = fe.measure(name, DEFAULT, reference)
        errors = {}
        for title, settings in series(name == "hertz-paper").items():
            runs = [(setting, fe.measure(name, setting, reference)) for setting in settings]
            errors[title] = [
                point(setting.text, m, exact_law if setting.solver.method == "penalty" else m)
                for setting, m in runs
            ]
        scenes[name] = {"series": errors, "reference": reference}
    return scenes


def precision_panels(scenes: Found) -> list[Panel]:
    figures = [(name, "dissipation", "work", "error of W") for name in scenes]
    figures += [
        (name, "shear", "shear", "L2 of q over f ||p||, rms") for name in scenes if name != "blocks"
    ]
    panels = []
    for name, title, key, label in figures:
        curves = {}
        for title_of_series, points in scenes[name]["series"].items():
            curves[title_of_series] = [(point["seconds"], point[key]) for point in points]
        panels.append((f"{name}: {title}", "CPU time [s]", label, curves))
    return panels


def better(scene: Found, default: Found, measures: Sequence[str]) -> list[str]:
    """Settings that are neither slower nor less exact than the default in any of `measures`, and in
    time or one of them better.
    """
    keys = [key for key in ("seconds", *measures) if default[key] is not None]

    def size(setting: Found, key: str) -> float:
        """Time or error, no smaller than what scatters."""
        return max(setting[key], SCATTER.get(key, 0.0))

    rivals = []
    for name, points in scene["series"].items():
        for setting in points:
            if setting is default:
                continue
            ratios = {key: size(setting, key) / size(default, key) for key in keys}
            if max(ratios.values()) <= 1 + SAME and min(ratios.values()) < 1 - MARGIN:
                rivals.append(f"{name}, {setting['text']} ({ratios['seconds']:.2f})")
    return rivals


def precision_page(scenes: Found) -> list[str]:
    """Errors of the defaults, and which settings would be better."""
    cells = []
    for name, scene in scenes.items():
        default = next(
            point for point in scene["series"]["named settings"] if point["text"] == "default"
        )
        measures = [key for key in ("work", "shear", "loop") if default[key] is not None]
        in_all = better(scene, default, measures)
        in_w = [setting for setting in better(scene, default, ["work"]) if setting not in in_all]
        shear = "–" if default["shear"] is None else f"{default['shear']:.1e}"
        rivals = "; ".join(in_all)
        if in_w:
            rivals += f"{'; ' if rivals else ''}in W alone: {'; '.join(in_w)}"
        cells.append(
            (
                name,
                f"{default['seconds']:.1f}",
                f"{default['work']:.1e}",
                shear,
                rivals or "none",
            )
        )
    return [
        (
            "Errors on half-planes are against theory, on blocks against a finer model. Better: by"
            f" {MARGIN:.0%} in time or an error, and no worse (by {SAME:.0%}) in the others; errors"
            f" of W below {SCATTER['work']:.0e} are equal. In brackets: share of time."
        ),
        "",
        *markdown("scene | time [s] | error of W | of q | better", cells),
    ]


# ------------------------------------------------------------ error against time: half-plane theory
METHODS = {
    "the engine's rule": ("engine's rule", "the engine's rule (default)"),
    "straight steps": ("straight steps", "memory curve, 50 to 3200 straight steps"),
    "discretised": ("naive", "naive discretised half-plane, 20 to 160 elements"),
}
TABULATED = ("the engine's rule", "discretised")  # straight steps are in the figure


def theory_panels(cases: Found) -> list[Panel]:
    panels = []
    for title, methods in cases.items():
        curves = {}
        for key, (_, words) in METHODS.items():
            curves[words] = [(point["seconds"], point["error"]) for point in methods[key]]
        panels.append((title, "CPU time of one W [s]", "error of W", curves))
    return panels


def theory_page(cases: Found) -> list[str]:
    cells = []
    for title, methods in cases.items():
        row = [title]
        for key in TABULATED:
            best = min(methods[key], key=lambda point: point["error"], default=None)
            if best is None:
                row += ["no answer", ""]
            else:
                row += [f"{best['error']:.0e}", f"{1e3 * best['seconds']:.3g}"]
        cells.append(tuple(row))
    return [
        (
            "One W of a steady cycle against 30 digits; naive: discretised half-plane,"
            " `semi_analytic/grid.py`."
        ),
        "",
        *markdown(f"case | {' | '.join(f'{METHODS[key][0]} | ms' for key in TABULATED)}", cells),
    ]


# ------------------------------------------------------------------------------------------- growth
MOST = 2.2  # the steepest exponent that is promised
STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
Cost = tuple[float, float, float]  # a count, CPU seconds, another count


def history_of(rows: int) -> Cost:
    scene = load_scene("hertz-paper")
    scene = scene.vary(load=TimeSeriesLoad(rows=half_plane.random_rows(scene, rows)))
    return rows, *seconds(lambda: semi_analytic.solve(scene, fields=("dissipation",))), 1


def batch_of(members: int) -> Cost:
    ellipses = half_plane.random_ellipses(members)
    return (
        members,
        *seconds(lambda: semi_analytic.dissipation(profile=Hertz(radius=1.0), **ellipses)),
        1,
    )


def sweep_of(points: int, exact: bool) -> Cost:
    """A study of a scene: friction by theory; by finite elements blocks of several heights, coarse
    meshes. One process.
    """
    study = (jobs.EXACT, jobs.frictions(points)) if exact else (jobs.FE, jobs.heights(points))
    return points, with_children(lambda: jobs.swept(*study))[0], 1


def path_cost(edge: int, steps: int = 96) -> Cost:
    """Contact nodes, CPU seconds of hertz-paper's load path, increments; increments are never
    halved.
    """
    began: list[float] = []

    def clock(step: int, _total: int | None, text: str) -> None:
        if not step and text.startswith("initial loading"):
            began.append(time.process_time())

    solver = SolverSettings(steps_per_cycle=steps, step_tolerance=FREE)
    answer = halfplane_fe.solve(
        load_scene("hertz-paper"), MeshSettings(edge_element_size=1 / edge), solver, clock
    )
    return len(answer.x), time.process_time() - began[-1], answer.work.counts["steps solved"]


def condensation_cost(edge: int, growth: float = 0.2) -> Cost:
    """Contact nodes, CPU seconds of condensing, degrees of freedom of a half-disc as the paper's
    cycle asks for.
    """
    mesh = half_disc("lower", SurfaceGrading(0.4, 1.1, 1 / 24, 1 / edge, 10.0), growth)
    begun = time.process_time()
    condensed = condense(mesh, STEEL, 1.0)
    return (
        len(condensed.x),
        time.process_time() - begun,
        int(condensed.diagnostics["degrees_of_freedom"]),
    )


class Kind(NamedTuple):
    """A cost: what measures it, which count its size is, and what is asked for."""

    task: Callable[[int], Cost]
    by: int
    sizes: tuple[int, ...]
    unit: str
    what: str


KINDS = {
    "path": Kind(path_cost, 0, (40, 80, 160, 320), "contact nodes", "two revolutions"),
    "steps": Kind(
        lambda n: path_cost(40, n),
        2,
        (200, 400, 800, 1600),
        "increments",
        "two revolutions, a/40",
    ),
    "condensation": Kind(condensation_cost, 0, (40, 80, 160, 320), "contact nodes", "condensation"),
    "bulk": Kind(
        lambda n: condensation_cost(80, 1 / n),
        2,
        (5, 10, 20, 33),
        "bulk unknowns",
        "condensation",
    ),
    "history": Kind(
        history_of,
        0,
        (1_000, 10_000, 100_000, 1_000_000),
        "rows",
        "theory, history",
    ),
    "batch": Kind(
        batch_of, 0, (1_000, 10_000, 100_000, 1_000_000), "batch members", "theory, batch"
    ),
    "theory points": Kind(
        partial(sweep_of, exact=True), 0, (25, 50, 100), "sweep points", "theory, singly"
    ),
    "FE points": Kind(
        partial(sweep_of, exact=False), 0, (2, 4, 8), "sweep points", "finite elements, coarse"
    ),
}


def one_cost(name: str, size: int) -> dict[str, float]:
    """Cost of a point in this process, and its peak of memory [MB] beyond what the imports take."""
    imported = memory()
    with threadpool_limits(limits=1, user_api="blas"):
        counts = KINDS[name].task(size)
    each = counts[1] / counts[2] if name == "path" else counts[1]  # an increment of the path
    return {
        "size": counts[KINDS[name].by],
        "seconds": counts[1],
        "each": each,
        "memory": memory() - imported,
        "imports": imported,
    }


def growth() -> Found:
    """All kinds, each point in a process of its own; wall seconds by stage."""
    points: dict[str, list[dict[str, float]]] = {}
    for name, kind in KINDS.items():
        commands = [[sys.executable, __file__, "--one", name, str(size)] for size in kind.sizes]
        points[name] = [
            json.loads(subprocess.run(c, check=True, capture_output=True, text=True).stdout)
            for c in commands
        ]
        print(f"    {name}: exponent {exponent(points[name]):.2f}", flush=True)
    scenes = ("hertz-paper", "blocks", "cattaneo-mindlin", *SLOW)
    return {
        "growth": points,
        "stages": {
            name: dict(halfplane_fe.solve(load_scene(name)).work.seconds) for name in scenes
        },
    }


def exponent(points: list[dict[str, float]], key: str = "seconds") -> float:
    """Slope of log(cost) over log(size), least squares."""
    return float(
        np.polyfit(
            np.log([p["size"] for p in points]), np.log([max(p[key], 1e-9) for p in points]), 1
        )[0]
    )


def growth_panels(stored_points: Found) -> list[Panel]:
    def lines(key: str) -> dict[str, list[tuple[float, float]]]:
        curves = {}
        for name, points in stored_points["growth"].items():
            label = f"{KINDS[name].what}, by {KINDS[name].unit}"
            curves[label] = [(point["size"], max(point[key], 1e-4)) for point in points]
        return curves

    x = "size, in its own unit"
    return [
        ("CPU time", x, "CPU time [s]", lines("seconds")),
        ("Peak memory", x, "peak memory beyond imports [MB]", lines("memory")),
    ]


def growth_page(stored_points: Found) -> list[str]:
    def steepest(points: list[dict[str, float]], key: str = "seconds") -> float:
        return max(exponent(points, key), exponent(points[-2:], key))

    cells = []
    steep = []
    for name, points in stored_points["growth"].items():
        kind = KINDS[name]
        dearest = points[-1]
        size = f"{dearest['size']:.0f} {kind.unit}"
        spent = f"{dearest['seconds']:.3g}"
        cells.append((kind.what, size, spent, f"{steepest(points):.2f}"))
        if name == "path":
            each = f"{dearest['each']:.2g}"
            cells.append(("an increment", size, each, f"{steepest(points, 'each'):.2f}"))
        if steepest(points) > MOST:
            steep.append(name)
    share_of_path = [
        seconds_of["load path"] / sum(seconds_of.values())
        for seconds_of in stored_points["stages"].values()
    ]
    judgement = f"No exponent is above {MOST:g}."
    if steep:
        judgement = f"Steeper than {MOST:g}, as is promised: {', '.join(steep)}."
    return [
        (
            "hertz-paper, the largest size. Exponent: of time over size, the larger of all sizes"
            f" and of the last two. {judgement} The load path takes"
            f" {min(share_of_path):.0%} to {max(share_of_path):.0%} of a run."
        ),
        "",
        *markdown("cost of | size | time [s] | exponent", cells),
    ]


# ----------------------------------------------------------------------------------------- start-up
COMMANDS = {
    "a bare interpreter": ["-c", "pass"],
    "`halfplane --help`": ["-m", "reports", "--help"],
    "`import semi_analytic`": ["-c", "import semi_analytic"],
    "`import halfplane_fe`": ["-c", "import halfplane_fe"],
}


def start() -> Found:
    """CPU times in turn, after one to warm up; size of the wheel and of the environment in
    bytes.
    """

    def child(arguments: list[str]) -> float:
        return with_children(
            lambda: subprocess.run(
                [sys.executable, *arguments], check=True, capture_output=True, cwd=ROOT
            )
        )[0]

    def size(folder: Path) -> int:
        return sum(
            512 * file.lstat().st_blocks
            for file in folder.rglob("*")
            if file.is_file() and not file.is_symlink()
        )

    times = {}
    for name, arguments in COMMANDS.items():
        child(arguments)  # the first also reads what the later ones find
        times[name] = [child(arguments) for _ in range(5)]
    with tempfile.TemporaryDirectory() as folder:
        wheel = build_wheel(Path(folder)).stat().st_size
    packages = Path(sys.prefix) / "lib" / f"python3.{sys.version_info.minor}" / "site-packages"
    largest = sorted(
        ((size(one), one.name) for one in packages.iterdir() if one.is_dir()), reverse=True
    )[:8]
    environment = {
        "environment": size(Path(sys.prefix)),
        "largest": {name: count for count, name in largest},
    }
    return {"seconds": times, "wheel": wheel} | environment


def start_page(stored_times: Found) -> list[str]:
    """Sizes, and the time until the command answers."""
    seconds = statistics.median(stored_times["seconds"]["`halfplane --help`"])
    return [
        (
            f"`halfplane --help` {seconds:.2f} s, the wheel {stored_times['wheel'] / 1e6:.2f} MB,"
            f" the environment of `make` {stored_times['environment'] / 1e9:.2f} GB."
        ),
    ]


# ----------------------------------------------------------------------------------------- the page
class Section(NamedTuple):
    """Its heading, what measures it (for JSON), its part of the page, and its figure: name, panels,
    words for who can't see it.
    """

    title: str
    measure: Callable[[], Found]
    page: Callable[[Found], list[str]]
    figure: tuple[str, Callable[[Found], list[Panel]], str] | None = None


SECTIONS = {
    "precision": Section(
        "Finite elements",
        precision,
        precision_page,
        (
            "precision_fe",
            precision_panels,
            "Errors",
        ),
    ),
    "half-plane": Section(
        "Half-plane theory",
        lambda: {title: half_plane.study(case) for title, case in half_plane.CASES.items()},
        theory_page,
        (
            "precision_half_plane",
            theory_panels,
            "Errors",
        ),
    ),
    "peers": Section(
        peers.TITLE,
        peers.measure,
        peers.page,
        ("peers", peers.panels, "Errors"),
    ),
    "growth": Section(
        "Growth",
        growth,
        growth_page,
        ("growth", growth_panels, "Growth"),
    ),
    "start": Section("Start-up and size", start, start_page),
    "records": Section(
        long_record.TITLE, lambda: long_record.unlike_beside(Path(EARLIER)), long_record.page
    ),
    "speed": Section(speed.TITLE, lambda: speed.measure(Path(EARLIER)), speed.page),
}
# Sections that are measured beside an earlier version.
BESIDE = ("records", "speed")
# Series whose points differ in several ways at once, or whose errors change sign: no line through
# them.
POINTS_ONLY = ("named settings", "penalty, a/160", "increments, no tolerance", "contact method")


def draw(name: str, panels: Sequence[Panel]) -> None:
    """Panels of points over logarithmic axes, one legend for all."""
    drawn = []
    keys = dict[str, Key]()
    for number, (title, x, y, lines) in enumerate(panels):
        marks: list[Mark] = []
        for label, points in lines.items():
            look = list(keys).index(label) if label in keys else len(keys)
            keys.setdefault(label, Key(f"c{look}", label))
            marks += [
                Dot(across, up, f"p{look}", 3.0 if look else 5.0, label) for across, up in points
            ]
            if label not in POINTS_ONLY:
                marks.append(Curve(*np.transpose(points), f"c{look} fine", label))
        all_points = [point for points in lines.values() for point in points]
        x_ends = axis_limits(np.log([point[0] for point in all_points]))
        y_ends = axis_limits(np.log([point[1] for point in all_points]))
        axes = [
            Axis(*np.exp(end).tolist(), words, log=True)
            for end, words in zip((x_ends, y_ends), (x, y), strict=True)
        ]
        drawn.append(ChartPanel(f"{name}-{number}", *axes, marks, title, 400.0, 320.0, title))
    plate = Plate(
        name,
        "",
        "",
        "Measured values over logarithmic axes",
        tuple(drawn),
        {},
        tuple(keys.values()),
        min(len(panels), 3),
    )
    (FOLDER / f"{name}.svg").write_text(plate.svg(), encoding="utf-8")


def measured(name: str) -> dict[str, Any]:
    """A section measured, with machine, versions, and how busy the machine is."""
    file = Path("/proc/cpuinfo")
    cpu = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    stored_values: dict[str, Any] = {
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "processor": next(
            (line.split(":", 1)[1].strip() for line in cpu if line.startswith("model name")),
            platform.machine(),
        ),
        "cores": os.cpu_count(),
        "load before": round(os.getloadavg()[0], 1),
        "versions": (
            {"python": platform.python_version()} | {name: version(name) for name in PACKAGES}
        ),
    }
    begun = time.perf_counter()
    spent = time.process_time()
    measured_values = SECTIONS[name].measure()
    took = {
        "wall": round(time.perf_counter() - begun),
        "process": round(time.process_time() - spent),
    }
    return {
        "made": stored_values | {"load after": round(os.getloadavg()[0], 1), "seconds": took},
        "found": measured_values,
    }


def _measured_ones() -> dict[str, Section]:
    """All but those beside an earlier version where no such checkout was ever named."""
    return {
        name: section
        for name, section in SECTIONS.items()
        if name not in BESIDE or (FOLDER / f"{name}.json").exists()
    }


def page_text() -> str:
    """The page, from the files of the sections."""
    lines = [
        "# Performance",
        "",
        (
            "Written by `make bench`. CPU times vary"
            " by ten per cent and more: ratios of one run count."
        ),
    ]
    for name, section in _measured_ones().items():
        origin, measured_values = stored(FOLDER / f"{name}.json").values()
        words = f"*[{name}.json](performance/{name}.json), {origin['date']}.*"
        figure = (
            ["", f"![{section.figure[2]}](performance/{section.figure[0]}.svg)"]
            if section.figure
            else []
        )
        lines += ["", f"## {section.title}", "", words, *figure, "", *section.page(measured_values)]
    return "\n".join(lines) + "\n"


def main(words: list[str]) -> None:
    if words[:1] == ["--one"]:
        print(json.dumps(one_cost(words[1], int(words[2]))))
        return
    for name in chosen(words, SECTIONS):
        if name in BESIDE and not EARLIER:
            print(f"==> {name}: left out, EARLIER names no checkout")
            continue
        print(f"==> {name}", flush=True)
        write_json(FOLDER / f"{name}.json", measured(name))
    for name, section in _measured_ones().items():
        if section.figure:
            draw(section.figure[0], section.figure[1](stored(FOLDER / f"{name}.json")["found"]))
    PAGE.write_text(page_text(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main(sys.argv[1:])
