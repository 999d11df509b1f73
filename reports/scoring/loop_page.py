"""Page, JSON and table of a measured loop: the rows, the loops of theory and finite elements, and
what the best fit leaves.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from reports.charts.plate import (
    Axis,
    Curve,
    Dot,
    Key,
    Mark,
    Panel,
    Plate,
    Rule,
    limits,
    worded,
    write_tables,
)
from reports.charts.templating import script, template
from reports.comparison.words import question
from reports.folder import filled
from reports.scoring.loops import SHARES, LoopScore, means_of_parts
from reports.units import energy_unit, load_unit, minus, units
from scenes.array_types import Array


def content(found: LoopScore) -> dict[str, Any]:
    """A loop score for JSON."""
    return {
        "kind": "loop",
        "passed": found.agrees,
        "sentence": found.sentence,
        "friction": {
            "value": found.friction,
            "low": found.low,
            "high": found.high,
            "scene": found.scene.friction.coefficient,
        },
        "rig_compliance": {"value": found.compliance, "fitted": found.compliance_fitted},
        "scale": found.scale,
        "cycles": found.cycles,
        "noise": found.noise,
        "metrics": {
            row.name: {name: value for name, value in vars(row).items() if name != "name"}
            for row in found.rows
        },
        "read_as": found.read_as,
        "notes": list(found.said),
        "scene": found.scene.model_dump(mode="json"),
    }


def table(found: LoopScore) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heads and rows: each loop, and how far it is from the measured one."""
    length, stress = units(found.scene)[1:]
    area = f"area W [{energy_unit(found.scene)}]"
    distance = f"mean rows − loop, rms [{length}]"
    heads = ("loop", "f", area, "W/measured − 1", f"slope dU/dQ [1/{stress}]", distance)
    measured = found.rows[0]
    rows: list[tuple[str, ...]] = []
    for row in found.rows:
        apart = "–" if row is measured else minus(f"{100 * (row.area / measured.area - 1):+.2g} %")
        spread = f" ± {row.area_uncertainty:.2g}" if row.area_uncertainty else ""
        friction = "–" if row.friction is None else f"{row.friction:.4g}"
        distance = f"{row.distance:.3g}" if math.isfinite(row.distance) else "–"
        rows.append(
            (row.name, friction, f"{row.area:.5g}{spread}", apart, f"{row.slope:.5g}", distance)
        )
    return heads, rows


def _plates(found: LoopScore) -> tuple[Plate, ...]:
    """The loop, U less the straight line through it, so that it opens; and rows minus the best
    fit.
    """
    length = units(found.scene)[1]
    load = load_unit(found.scene)
    line = found.rows[1].slope
    base = float(np.mean(found.shift - line * found.load))
    rest = found.shift - np.interp(found.tau, SHARES, found.curves[0][1])
    count, share, shifts, loads, means = means_of_parts(
        found.tau, found.tau, found.shift, found.load, rest
    )
    opened = shifts - line * loads - base
    curves = [
        Curve(q, u - line * q - base, f"line-{k}", name)
        for k, (name, u, q) in enumerate(found.curves, 1)
    ]
    keys = [Key(curve.css, curve.label) for curve in curves]

    def panel(
        name: str,
        words: str,
        height: float,
        across: Axis,
        up: Axis,
        dots: tuple[Array, Array],
        lines: Sequence[Mark],
    ) -> Panel:
        marks = [
            Dot(x, y, "p0", 2.2) for x, y in zip(*(values.tolist() for values in dots), strict=True)
        ]
        return Panel(name, across, up, [*marks, *lines], words, 900.0, height, css="broad")

    axes = (
        Axis(*limits(loads, curves[0].x), f"Q  [{load}]"),
        Axis(*limits(opened, *(c.y for c in curves)), f"U − slope Q  [{length}]"),
    )
    below = (
        Axis(0.0, 1.0, "share of the cycle"),
        Axis(*limits(means), f"mean rows − best fit  [{length}]"),
    )
    loop = panel(
        "loop", "Loop of displacement over tangential load", 380.0, *axes, (loads, opened), curves
    )
    residuals = panel(
        "loop-rest",
        "Residuals of the best fit over the cycle",
        260.0,
        *below,
        (share, means),
        [Rule(0.0, "zero")],
    )
    words: dict[str, Any] = {
        "fewest": f"{count.min():.0f}",
        "most": f"{count.max():.0f}",
        "parts": len(count),
        "columns": 1,
    }
    columns = {"tau": found.tau, f"Q [{load}]": found.load, f"U [{length}]": found.shift}
    noise: dict[str, Any] = {"noise": f"{found.noise:.3g}", "length": length}
    return (
        worded("loop", [loop], columns, keys, slope=f"{line:.4g}", **words),
        worded(
            "loop_residuals",
            [residuals],
            {"tau": found.tau, f"U - fit [{length}]": rest},
            **noise,
            **words,
        ),
    )


def write(
    found: LoopScore,
    out: str | Path,
    command: str,
    further: dict[str, Any] | None = None,
    sentences: Sequence[str] = (),
) -> Path:
    """The page, loop.json and the CSV of each figure; returns the path of the page.

    Parameters
    ----------
    further
        entries of loop.json beside those of the score
    sentences
        what the page says below its first one
    """
    from reports.comparison.json_values import strict

    program, digest = script()
    drawings = _plates(found)
    heads, rows = table(found)
    with filled(out) as folder:
        write_tables(drawings, folder)
        whole = strict(content(found) | (further or {})) | {"command": command}
        (folder / "loop.json").write_text(
            json.dumps(whole, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
        )
        page = template("loop.html").render(
            title=f"Measured loop: {Path(found.source).name}",
            scene=found.scene,
            question=question(found.scene),
            found=found,
            sentences=sentences,
            source_name=Path(found.source).name,
            stress=units(found.scene)[2],
            heads=heads,
            rows=rows,
            drawings=drawings,
            command=command,
            script=program,
            script_hash=digest,
        )
        (folder / "report.html").write_text(page, encoding="utf-8")
    return Path(out) / "report.html"
