"""Tables that try the theory: derived constants beside fitted ones, corrections on held-out points, mirror images."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from reports.maps.corrections import added_curvatures, correction
from reports.maps.layers import curvature_sum
from reports.maps.quadratic import Curvatures, dissipation_error, ellipse_path
from reports.maps.readings import Readings, read
from reports.maps.tabling import table
from scenes import Block, Bodies, InputError, Scene, load_scene

_SMALL = 0.05  # a/h at which derived constants are taken


def derived_constants(folder: Path) -> list[str]:
    """Constants of (a/h)^2 from the Fourier integrals and sums of layers, beside the fits."""
    laws = json.loads((folder / "laws.json").read_text(encoding="utf-8"))["laws"]
    p, q, cycle = ellipse_path(1 / 3, 1.1 / 3, 1 / 3, np.pi / 2)
    rows = []
    for law in (law for law in laws if law["study"] == "block"):
        base, aspect = law["base"], float(law["aspect"])
        if law["figure"] not in ("error.p0", "error.dissipation") or (base == "fixed" and aspect < 4):
            continue
        width = aspect if base == "rollers" else np.inf
        # notation: N and T, nu = N (a/h)^2, tau = T (a/h)^2
        n, t = (-curvature_sum(base, tangential=way, aspect=width) / 2 for way in (False, True))
        if law["figure"] == "error.p0":
            known = n / 2
        else:
            known = dissipation_error(p, q, 1.0, Curvatures(n * _SMALL**2, t * _SMALL**2), cycle) / _SMALL**2
        fit, doubt = law["sign"] * law["fixed"], law["fixed_doubt"]
        verdict = "in the interval" if abs(fit - known) <= doubt else f"off by {fit - known:+.2g}"
        whose = "walls and rollers, sum over images" if base == "rollers" else "layer without end, integral"
        rows.append(
            [
                law["figure"].removeprefix("error."),
                f"{base}, {aspect:g}",
                f"{fit:.3f} ± {doubt:.3f}",
                f"{known:.3f}",
                verdict,
                whose,
            ]
        )
    head = ["figure", "base, width / height", "fitted constant", "derived", "", "derived for"]
    words = (
        "Finite height enters the surface's Green's function as −(x − ξ)² κ/2 with κ from the known layer solutions; "
        "`reports/maps/layers.py` has the integrals and `reports/maps/quadratic.py` what that does to a cycle. Nothing is "
        "fitted in the column *derived*. A block of finite width with free sides has no such solution; at width/height = 4 the "
        "layer without end is near."
    )
    return ["## Constants that theory predicts", words, table(head, rows)]


def odd_part(folder: Path) -> list[str]:
    """What is left of one block's error beside half of what two equal blocks do: the coupling by the odd part of its kernel."""
    rows = []
    for row in read(folder, "one-block").rows:
        f, aspect, height = (float(row[name]) for name in ("f", "aspect", "height"))
        error, doubt = float(row["error.dissipation"]), float(row["error.dissipation.uncertainty"])
        both = added_curvatures("fixed", aspect, 1 / height)
        p, q, cycle = ellipse_path(1 / 3, 1.1 / 3 * f, f / 3, np.pi / 2)
        even = dissipation_error(p, q, f, Curvatures(both.normal / 2, both.tangential / 2), cycle)
        rest = (error - even) * height**2
        rows.append(
            [
                row["f"],
                row["aspect"],
                f"{height:.3g}",
                f"{100 * error:+.2f} ± {100 * doubt:.2f}",
                f"{100 * even:+.2f}",
                f"{rest:+.2f}",
            ]
        )
    head = ["f", "width / height", "height / a", "error of dissipation, %", "even part, %", "rest times (h/a)²"]
    words = (
        "The even part is half of what two equal blocks do, by the correction's theory (`reports/maps/quadratic.py`); nothing of "
        "it was fitted to these points. The rest is what two equal blocks cancel, the coupling of normal and shear tractions by "
        "the odd part of one block's kernel, and what a series in a/h leaves out."
    )
    return ["## What one block does that two do not", words, table(head, rows)]


def _blocks(base: str, height: float, aspect: float, scene: Scene) -> Scene:
    block = Block(width=height * aspect, height=height, base=base, sides="free" if base == "fixed" else "guided")
    return scene.vary(bodies=Bodies(lower=block, upper=block))


def left(error: float, predicted: float) -> float:
    """Error of a corrected figure: finite elements over corrected theory, less 1."""
    return (1 + error) / (1 + predicted) - 1


def corrected_blocks(folder: Path) -> list[str]:
    """What the correction leaves on held-out blocks."""
    readings, scene, rows = read(folder, "block-held-out"), load_scene("blocks"), []
    shares = []
    for row in readings.rows:
        error, doubt = float(row["error.dissipation"]), float(row["error.dissipation.uncertainty"])
        try:
            found = correction(_blocks(row["base"], float(row["height"]), float(row["aspect"]), scene))
        except InputError as refused:
            rows.append(
                [row["base"], row["aspect"], row["height"], f"{100 * error:+.2f}", f"{100 * doubt:.2f}", "refused", str(refused)]
            )
            continue
        rest = left(error, found.dissipation)
        shares.append(1 - abs(rest) / abs(error))
        verdict = "resolved" if abs(rest) > doubt else "not resolved"
        rows.append(
            [row["base"], row["aspect"], row["height"], f"{100 * error:+.2f}", f"{100 * doubt:.2f}", f"{100 * rest:+.2f}", verdict]
        )
    head = [
        "base",
        "width / height",
        "height / a",
        "error of theory, %",
        "uncertainty, %",
        "left after correction, %",
        "what is left",
    ]
    words = (
        "`reports.maps.corrections.corrected_dissipation(scene, value)` corrects half-plane theory's dissipation of two "
        f"equal blocks under any Hertz loop. On these points, to which nothing was fitted, it removes {100 * min(shares):.0f} to "
        f"{100 * max(shares):.0f} % of the error of dissipation, {100 * float(np.median(shares)):.0f} % in the median."
    )
    return ["## Correction on points that nothing was fitted to", words, table(head, rows)]


def loop_scene(amplitude: float, margin: float, phase: float) -> Scene:
    """A loop of the study `loop`, on its blocks."""
    base = load_scene("blocks")
    p0 = base.load.mean_normal_load  # type: ignore[union-attr]
    lean = amplitude * abs(np.cos(np.radians(phase)))
    load = base.load.vary(
        normal_amplitude=amplitude * p0,
        mean_tangential_load=0.0,
        tangential_amplitude=0.5 * p0 * float(np.sqrt(lean**2 - amplitude**2 + (1 - margin) ** 2) - lean),
        phase_degrees=phase,
        initial_loading="straight",
    )
    return _blocks("fixed", 8.0, 2.0, base.vary(load=load, friction=0.5))


def worst_loops(readings: Readings) -> str:
    """Where the same blocks hurt most and least."""
    error, doubt = readings.errors("error.dissipation")
    pressure, _ = readings.errors("error.p0")
    seen = np.flatnonzero(np.abs(error) > doubt)
    worst, least = seen[np.argmax(np.abs(error[seen]))], seen[np.argmin(np.abs(error[seen]))]

    def loop(number: int) -> str:
        row = readings.rows[number]
        return f"P1/P0 = {row['amplitude']}, phase {row['phase']}°, {row['margin']} from sliding"

    stuck, unresolved = int(np.isnan(error).sum()), int(np.sum(np.abs(error) <= doubt))
    span = f"{100 * pressure.min():+.3f} to {100 * pressure.max():+.3f} %"
    return (
        "The same two blocks, 8 a high and 16 a wide, put half-plane theory's dissipation off by "
        f"{100 * error[worst]:+.1f} ± {100 * doubt[worst]:.1f} % at worst ({loop(worst)}) and by {100 * error[least]:+.2f} ± "
        f"{100 * doubt[least]:.2f} % at best of the resolved points ({loop(least)}), while p0 at the mean load is off by {span} "
        f"under all of them. Of {len(readings.rows)} points {stuck} stick throughout and {unresolved} are not resolved."
    )


def corrected_loops(folder: Path) -> list[str]:
    """The correction of blocks, fitted under the paper's loop alone, under all the others."""
    readings, rows, before, after = read(folder, "loop"), [], [], []
    error, doubt = readings.errors("error.dissipation")
    for row, here, unsure in zip(readings.rows, error, doubt, strict=True):
        if np.isnan(here):
            rows.append([row["amplitude"], row["margin"], row["phase"], "sticks throughout", "", "", ""])
            continue
        found = correction(loop_scene(float(row["amplitude"]), float(row["margin"]), float(row["phase"])))
        rest = left(here, found.dissipation)
        before.append(abs(here))
        after.append(abs(rest))
        rows.append(
            [
                row["amplitude"],
                row["margin"],
                row["phase"],
                f"{100 * here:+.2f}",
                f"{100 * unsure:.2f}",
                f"{100 * found.dissipation:+.2f}",
                f"{100 * rest:+.2f}",
            ]
        )
    words = (
        "The correction's constants come from the paper's loop alone; none of these loops was seen by any fit. The largest error "
        f"of dissipation falls from {100 * max(before):.1f} to {100 * max(after):.2g} %, "
        f"the median from {100 * float(np.median(before)):.2f} to {100 * float(np.median(after)):.1g} %."
    )
    head = [
        "P1/P0",
        "distance from sliding",
        "phase",
        "error of theory, %",
        "uncertainty, %",
        "predicted, %",
        "left after correction, %",
    ]
    return ["## The correction under loops that nothing was fitted to", words, table(head, rows)]


def own_limits(readings: Mapping[str, Readings]) -> str:
    """How far apart the engines are at the far end of each ladder."""
    said = []
    for study, found in readings.items():
        error, _ = found.errors("error.dissipation")
        last = int(np.argmin(np.abs(error)))
        name = found.columns[0]
        spread = f"{100 * np.abs(error).max():.2g} to {100 * np.abs(error).min():.2g} %"
        said.append(f"{study.removeprefix('limits-')}: {spread}, least at {name} = {found.rows[last][name]}")
    return (
        "Between half-planes, where both answer one question, dissipation differs by (over the whole ladder) "
        + "; ".join(said)
        + "."
    )


def signs_and_groups(folder: Path) -> list[str]:
    """Evenness in beta, alpha alone, and the constant times f^2."""
    laws = json.loads((folder / "laws.json").read_text(encoding="utf-8"))["laws"]
    rows = []
    for law in laws:
        if law["study"] == "unlike" and law["figure"] in ("error.dissipation", "error.p0"):
            f = float(law["f"])
            value, doubt = law["sign"] * law["fixed"], law["fixed_doubt"]
            rows.append(
                [
                    law["figure"].removeprefix("error."),
                    law["f"],
                    f"{value:.3g} ± {doubt:.2g}",
                    f"{value * f**2:.3g} ± {doubt * f**2:.2g}",
                ]
            )
    head = ["figure", "f", "constant of β²", "the same times f²"]
    words = (
        "If the shear that pressing makes took part in the cycle, the errors would go with (β/f)² and the last column would be one "
        "number. With P constant it does not: the constant of β² is what hardly moves. Loops that move P are not in this map."
    )
    parts = ["## Growth with 1/f", words, table(head, rows)]
    return [*parts, *_held_out_unlike(folder, laws)] if (folder / "unlike-held-out.csv").exists() else parts


def _held_out_unlike(folder: Path, laws: list[dict[str, Any]]) -> list[str]:
    """Other signs of beta and other alpha, beside the laws."""
    held, rows = read(folder, "unlike-held-out"), []
    chosen = [law for law in laws if law["study"] == "unlike" and law["figure"] == "error.dissipation"]
    for row in held.rows:
        error, doubt = float(row["error.dissipation"]), float(row["error.dissipation.uncertainty"])
        predicted = _between(chosen, float(row["f"]), abs(float(row["beta"])))
        rows.append(
            [
                row["beta"],
                row["poisson"],
                row["f"],
                f"{100 * error:+.2f} ± {100 * doubt:.2f}",
                "none" if predicted is None else f"{100 * predicted:+.2f}",
            ]
        )
    head = ["β", "ν (sets α)", "f", "error of dissipation, %", "by the laws, %"]
    words = (
        "Points that no law was fitted to: the other sign of β, other α at the same β (ν = 0: α = 2 β; ν = 0.3: α = 3.5 β), "
        "other f. Between half-planes the tractions depend on β and E* alone, and are even in it."
    )
    return ["## The other sign, another alpha", words, table(head, rows)]


def _between(laws: list[dict[str, float]], f: float, beta: float) -> float | None:
    """The laws' value at f, constant and next term interpolated over log f."""
    if len(laws) < 2:
        return None
    order = sorted(laws, key=lambda law: float(law["f"]))
    fs = [float(law["f"]) for law in order]
    if not fs[0] <= f <= fs[-1]:
        return None
    constant = np.interp(np.log(f), np.log(fs), [law["sign"] * law["fixed"] for law in order])
    following = np.interp(np.log(f), np.log(fs), [law["next_term"] for law in order])
    return float(constant * beta**2 * np.exp(following * beta**2))
