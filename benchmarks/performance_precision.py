"""Error against CPU time of the finite elements on four scenes, and whether the defaults lie on the front.

The error of a dissipation may be small by chance, the mesh's part and the increments' being of opposite signs; so on half-planes
the sizes of the two are added, and the shear traction is the second measure. On blocks there is no exact answer: the truth is the
model itself, finer in everything.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import fe_precision
from fe_precision import DEFAULT, FINE, SWIFT, Setting, sizes

import halfplane_fe
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.drawing import canvas, label_axes
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
MARKS = ("*", "o", "s", "^", "P", "D", "v", "X")
POINTS_ONLY = ("named settings", "penalty, a/160", "increments, no tolerance")


@dataclass(frozen=True)
class Point:
    """One run: what it was, CPU seconds, |mesh's part| + |increments' part| of the error of W (|error| on blocks), rms of q's."""

    text: str
    seconds: float
    work: float
    shear: float | None


def series(whole: bool) -> dict[str, list[Setting]]:
    """What is varied, one thing at a time about the default; the dearest points only for the `whole` of it."""
    default = MeshSettings()

    def penalty(stiffness: float) -> SolverSettings:
        return SolverSettings(method="penalty", normal_stiffness=stiffness, tangential_stiffness=stiffness)

    def turns(count: int, tolerance: float = SolverSettings().step_tolerance) -> Setting:
        return Setting(f"{count} a turn", default, SolverSettings(steps_per_cycle=count, step_tolerance=tolerance))

    return {
        "named settings": [SWIFT, DEFAULT, *([FINE] if whole else [])],
        "quadratic, graded": sizes(2, (10, 20, 40, 80, 160, 320) if whole else (10, 20, 40, 80, 240), 24),
        "quadratic, uniform": sizes(2, (10, 20, 40, 80) if whole else (10, 20, 40), None),
        "linear, graded": sizes(1, (20, 40, 80, 160), 24),
        "growth of the bulk": [Setting(f"growth {g:g}", replace(default, growth=g)) for g in (0.1, 0.4)],
        "regular increments": [turns(n) for n in (24, 48, 192)],
        "increments, no tolerance": [turns(n, FREE) for n in ((8, 24, 96, 384) if whole else (8, 24, 96))],
        "penalty, a/160": [Setting(f"{k:g} E*/h", default, penalty(k)) for k in (10.0, 1e2, 1e3)],
    }


def run(name: str, setting: Setting, truth: float | None) -> Point:
    """One point; `truth` is the dissipation where theory has none."""
    if truth is None:
        found = fe_precision.measure(name, setting)
        return Point(setting.text, found.seconds, abs(found.mesh_part) + abs(found.increment_part), found.shear)
    begun = time.process_time()
    answer = halfplane_fe.solve(load_scene(name), setting.mesh, setting.solver)
    seconds = time.process_time() - begun
    return Point(setting.text, seconds, abs(answer.dissipation / truth - 1), None)


def finite_elements(name: str) -> dict[str, Any]:
    """Every series on a scene."""
    truth = None
    if name == "blocks":
        truth = halfplane_fe.solve(load_scene(name), REFERENCE.mesh, REFERENCE.solver).dissipation
    fe_precision.measure.cache_clear()
    found = {key: [asdict(run(name, setting, truth)) for setting in some] for key, some in series(name == "hertz-paper").items()}
    print(f"    {name}: {sum(len(points) for points in found.values())} runs", flush=True)
    return {"series": found, "reference": truth}


def every(found: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every point with the series that it is of."""
    for name, points in found["series"].items():
        for point in points:
            yield name, point


def better(found: dict[str, Any], default: dict[str, Any], key: str) -> list[str]:
    """Settings that are neither slower nor less exact than the default in `key`, and in one of the two better by the margin."""
    rivals = []
    for name, point in every(found):
        if point is default or point[key] is None:
            continue
        ratios = point["seconds"] / default["seconds"], point[key] / default[key]
        if max(ratios) <= 1 + SAME and min(ratios) < 1 - MARGIN:
            rivals.append(f"{name}, {point['text']} ({ratios[0]:.2f} of the time, {ratios[1]:.2f} of the error)")
    return rivals


def measure() -> dict[str, Any]:
    """Every scene."""
    fe_precision.measure("hertz-paper", SWIFT)  # the first run of a process also reads what the later ones find
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
                    label="swift, default, fine" if star else title,
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
        "increments' part (that polygon against the path), their sizes added, for the signed sum may vanish by chance. On blocks "
        "theory has no exact answer: the error is that against the same model at a/320 (a/36 in the middle) with twice the "
        "increments and half the step tolerance.",
        "",
    ]
    lines += [
        f"A setting is better than the default where it is neither slower nor less exact (by {SAME:.0%}) and in one of the "
        f"two better by {MARGIN:.0%}. The error of W of the penalty method changes its sign with the stiffness: one at which it is "
        "small is found by chance and is another one for another mesh; increments of no tolerance suffice where Q moves at "
        "constant P.",
        "",
    ]
    for name, scene in found.items():
        lines += _verdict(name, scene)
    lines += ["", "What each default costs and buys, default over alternative (time; error of W; error of q):", ""]
    lines += _alternatives(found)
    return lines


def _default(scene: dict[str, Any]) -> dict[str, Any]:
    return next(point for point in scene["series"]["named settings"] if point["text"] == "default")


def _verdict(name: str, scene: dict[str, Any]) -> list[str]:
    default = _default(scene)
    words = []
    for key, what in (("work", "W"), ("shear", "q")):
        if default[key] is None:
            continue
        rivals = better(scene, default, key)
        words.append(
            f"{what} {default[key]:.1e}, "
            + ("on the front" if not rivals else f"**not on the front**: better is {'; '.join(rivals)}")
        )
    return [f"- {name}: default {default['seconds']:.1f} s; {'; '.join(words)}."]


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
            ratios = [f"{default[key] / other[key]:.2g}" for key in ("seconds", "work", "shear") if other[key] is not None]
            cells.append("; ".join(ratios))
        lines.append(f"| {what} | {group}: {text} | {' | '.join(cells)} |")
    return lines
