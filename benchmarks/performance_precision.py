"""Error against CPU time of the finite elements on four scenes, and whether the defaults lie on the front.

The error of a dissipation may be small by chance, the mesh's part, the increments' and the penalty layer's being of opposite signs;
so the sizes of the parts are added, and the shear traction is the second measure. The third is the hysteresis loop, which few
increments cut the corners of where they cost W nothing. On blocks there is no exact answer: the truth is the model itself, finer
in everything.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import fe_precision
from fe_precision import COARSE, DEFAULT, FINE, Measured, Setting, sizes

import halfplane_fe
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.charts.publication import canvas, label_axes
from scenes import load_scene

TITLE = "Error against time: finite elements"
FREE = float("inf")
# Better by more than MARGIN in one of time and error, in the other no worse than by SAME: CPU times vary by some ten per cent.
MARGIN, SAME = 0.25, 0.05
REFERENCE = Setting(
    "reference",
    MeshSettings(element_size=1 / 48, edge_element_size=1 / 320),
    SolverSettings(steps_per_cycle=192, step_tolerance=5e-5),
)
SCENES = ("hertz-paper", "flat-rounded-paper", "cattaneo-mindlin", "blocks")
WHAT = {"seconds": "time", "work": "error of W", "shear": "error of q", "loop": "error of the loop"}
MARKS = ("*", "o", "s", "^", "P", "D", "v", "X")
POINTS_ONLY = ("named settings", "penalty, a/160", "increments, no tolerance")


@dataclass(frozen=True)
class Point:
    """One run: what it was, CPU seconds, error of W (sizes of the mesh's, the increments' and the layer's part added), rms of q's,
    error of the closed integral of Q dU (sizes of the mesh's and the layer's part and of the corners cut added).
    """

    text: str
    seconds: float
    work: float
    shear: float | None
    loop: float


def series(whole: bool) -> dict[str, list[Setting]]:
    """What is varied, one thing at a time about the default; the dearest points only for the `whole` of it."""
    default = MeshSettings()

    def penalty(stiffness: float) -> SolverSettings:
        return SolverSettings(method="penalty", normal_stiffness=stiffness, tangential_stiffness=stiffness)

    def turns(count: int, tolerance: float = SolverSettings().step_tolerance) -> Setting:
        return Setting(f"{count} a turn", default, SolverSettings(steps_per_cycle=count, step_tolerance=tolerance))

    return {
        "named settings": [COARSE, DEFAULT, *([FINE] if whole else [])],
        "quadratic, graded": sizes(2, (10, 20, 40, 80, 160, 320) if whole else (10, 20, 40, 80, 240), 24),
        "quadratic, uniform": sizes(2, (10, 20, 40, 80) if whole else (10, 20, 40), None),
        "linear, graded": sizes(1, (20, 40, 80, 160), 24),
        "growth of the bulk": [Setting(f"growth {g:g}", replace(default, growth=g)) for g in (0.1, 0.4)],
        "regular increments": [turns(n) for n in (24, 48, 192)],
        "increments, no tolerance": [turns(n, FREE) for n in ((8, 24, 96, 384) if whole else (8, 24, 96))],
        "penalty, a/160": [Setting(f"{k:g} E*/h", default, penalty(k)) for k in (10.0, 1e2, 1e3)],
    }


def point(text: str, found: Measured, exact_law: Measured | None) -> Point:
    """Sizes of the parts added; with `exact_law` on the same mesh beside it, what the layer adds is a part too."""
    base = exact_law or found
    work = abs(base.mesh_part) + abs(found.mesh_part - base.mesh_part) + abs(found.increment_part)
    layer = abs(found.loop_mesh_part - base.loop_mesh_part)
    return Point(text, found.seconds, work, found.shear, abs(base.loop_mesh_part) + layer + abs(found.loop_corners))


def finite_elements(name: str) -> dict[str, Any]:
    """Every series on a scene."""
    truth = None
    if name == "blocks":
        truth = halfplane_fe.solve(load_scene(name), REFERENCE.mesh, REFERENCE.solver).dissipation
    fe_precision.measure.cache_clear()
    exact_law = fe_precision.measure(name, DEFAULT, truth)
    found: dict[str, list[dict[str, Any]]] = {}
    for title, settings in series(name == "hertz-paper").items():
        found[title] = []
        for setting in settings:
            one = exact_law if setting == DEFAULT else fe_precision.measure(name, setting, truth)
            found[title].append(asdict(point(setting.text, one, exact_law if setting.solver.method == "penalty" else None)))
    print(f"    {name}: {sum(len(points) for points in found.values())} runs", flush=True)
    return {"series": found, "reference": truth}


def every(found: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every point with the series that it is of."""
    for name, points in found["series"].items():
        for point in points:
            yield name, point


def better(found: dict[str, Any], default: dict[str, Any], measures: Sequence[str]) -> list[str]:
    """Settings that are neither slower nor less exact than the default in any of `measures`, and in time or one of them better
    by the margin."""
    rivals = []
    for name, point in every(found):
        if point is default:
            continue
        ratios = {key: point[key] / default[key] for key in ("seconds", *measures) if point[key] is not None}
        if max(ratios.values()) <= 1 + SAME and min(ratios.values()) < 1 - MARGIN:
            said = ", ".join(f"{ratio:.2f} of the {WHAT[key]}" for key, ratio in ratios.items())
            rivals.append(f"{name}, {point['text']} ({said})")
    return rivals


def measure() -> dict[str, Any]:
    """Every scene."""
    fe_precision.measure("hertz-paper", COARSE)  # the first run of a process also reads what the later ones find
    return {name: finite_elements(name) for name in SCENES}


def draw(scenes: dict[str, Any], folder: Path) -> None:
    """Error over time, a panel a scene and measure."""
    panels = [(name, "work") for name in scenes] + [(name, "shear") for name in scenes if name != "blocks"]
    with canvas(11.0, 6.4) as figure:
        axes = figure.subplots(2, 4)
        for place, (name, key) in zip((0, 1, 2, 3, 4, 5, 6), panels, strict=True):
            one = axes.flat[place]
            for number, (title, points) in enumerate(scenes[name]["series"].items()):
                star = title == "named settings"
                one.loglog(
                    [point["seconds"] for point in points],
                    [point[key] for point in points],
                    ls="none" if title in POINTS_ONLY else "-",
                    marker=MARKS[number],
                    ms=11 if star else 5,
                    color="#111111"
                    if star
                    else ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8a8a8a")[number - 1],
                    mec="white",
                    mew=0.5,
                    lw=1.1,
                    zorder=3 if star else 2,
                    label="coarse, default, fine" if star else title,
                )
            what = {"work": "error of W", "shear": "L2 of q over f ||p||, rms"}[key]
            label_axes(one, "CPU time [s]", what, f"{name}: {'dissipation' if key == 'work' else 'shear'}")
            _plain_ticks(one)
        last = axes.flat[7]
        last.axis("off")
        last.legend(*axes.flat[0].get_legend_handles_labels(), loc="center", frameon=False, fontsize=9)
        figure.tight_layout()
        figure.savefig(folder / "precision_fe.svg", metadata={"Date": None})


def _plain_ticks(axes: Any) -> None:
    low, high = axes.get_xlim()
    ticks = [value for value in (0.2, 0.5, 1, 2, 5, 10, 20, 50, 100) if low <= value <= high]
    axes.set_xticks(ticks, [f"{value:g}" for value in ticks])
    axes.minorticks_off()


def page(found: dict[str, Any]) -> list[str]:
    """Figures, whether the defaults lie on the front, and what each costs and buys."""
    lines = [
        "![Error of the finite elements over CPU time, four scenes](performance/precision_fe.svg)",
        "",
        "Error of W on half-planes: the mesh's part (against the exact answer to the polygon of its own increments) and the "
        "increments' part (that polygon against the path), their sizes added, for the signed sum may vanish by chance; with the "
        "penalty method what its layer adds to the exact law on the same mesh is a part as well. So is that of the loop: the "
        "mesh's part against theory at the same instants, and the corners that straight lines between these cut. On blocks theory "
        "has no exact answer: the error is that against the same model at a/320 (a/48 in the middle) with twice the increments "
        "and a tenth of the step tolerance.",
        "",
    ]
    lines += [
        f"A setting is better than the default where it is neither slower nor less exact in W, in q or in the hysteresis loop "
        f"(by {SAME:.0%}), and in time or one of them better by {MARGIN:.0%}. What would be better if one of them alone counted is "
        "named as well.",
        "",
    ]
    for name, scene in found.items():
        lines += _verdict(name, scene)
    lines += ["", "What each default costs and buys, default over alternative (time; error of W; of q; of the loop):", ""]
    lines += _alternatives(found)
    return lines


def _default(scene: dict[str, Any]) -> dict[str, Any]:
    return next(point for point in scene["series"]["named settings"] if point["text"] == "default")


def _verdict(name: str, scene: dict[str, Any]) -> list[str]:
    default = _default(scene)
    measures = [key for key in ("work", "shear", "loop") if default[key] is not None]
    rivals = better(scene, default, measures)
    errors = ", ".join(f"{default[key]:.1e}" for key in measures)
    words = f"**not on the front**: better is {'; '.join(rivals)}" if rivals else "on the front"
    lines = [f"- {name}: default {default['seconds']:.1f} s; {', '.join(WHAT[key] for key in measures)}: {errors}; {words}."]
    for key in measures:
        alone = [rival for rival in better(scene, default, [key]) if rival not in rivals]
        lines += [f"  - were the {WHAT[key]} all that counts: {'; '.join(alone)}."] if alone else []
    return lines


ALTERNATIVES: tuple[tuple[str, str, str], ...] = (
    ("a/160 at the edges", "quadratic, graded", "a/80"),
    ("a/160 at the edges", "quadratic, graded", "a/240 or a/320"),
    ("graded, a/24 in the middle", "quadratic, uniform", "a/40"),
    ("quadratic elements", "linear, graded", "a/160"),
    ("growth 0.2 of the bulk", "growth of the bulk", "growth 0.1"),
    ("growth 0.2 of the bulk", "growth of the bulk", "growth 0.4"),
    ("96 increments a revolution", "regular increments", "48 a turn"),
    ("96 increments a revolution", "regular increments", "192 a turn"),
    ("increments halved to a tolerance", "increments, no tolerance", "96 a turn"),
    ("the exact law", "penalty, a/160", "1000 E*/h"),
)


def _alternatives(scenes: dict[str, Any]) -> list[str]:
    names = list(scenes)
    lines = [f"| default | instead | {' | '.join(names)} |", "|---" * (len(names) + 2) + "|"]
    for what, group, text in ALTERNATIVES:
        cells = []
        for scene in scenes.values():
            default = _default(scene)
            other = next(point for point in scene["series"][group] if point["text"] in text.split(" or "))
            ratios = [f"{default[key] / other[key]:.2g}" for key in WHAT if other[key] is not None]
            cells.append("; ".join(ratios))
        lines.append(f"| {what} | {group}: {text} | {' | '.join(cells)} |")
    return lines
