"""Page, JSON and table of a measured loop: the rows, the loops of theory and finite elements, and
what the best fit leaves.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

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
    axis_limits,
    figure_with_texts,
    write_tables,
)
from reports.charts.templating import script, template
from reports.comparison.words import question_in_words
from reports.folder import results_folder
from reports.scoring.loops import SHARES_OF_CYCLE, LoopScore, means_of_parts
from reports.units import energy_unit, load_unit, minus, units
from scenes.array_types import Array

_WIDTH = 900.0  # of both figures [pixels]


def content(score: LoopScore) -> dict[str, Any]:
    """The entries of loop.json for a measured loop of Q over U. They state whether the scene's
    friction coefficient f lies in the interval of the loop's f, that interval, and the rig's
    compliance; and area, slope and distance from the rows of each loop, measured or computed.

    Of `score`: `scale` is the file's Q over the scene's, `n_cycles` the number of cycles that the
    rows cover, `noise` the standard deviation of U, and `notes` what was assumed or left out.

    # notation: Q tangential load, U relative tangential displacement
    """
    return {
        "kind": "loop",
        "passed": score.is_scene_friction_within,
        "sentence": score.sentence,
        "friction": {
            "value": score.friction,
            "low": score.lowest_friction,
            "high": score.highest_friction,
            "scene": score.scene.friction.coefficient,
        },
        "rig_compliance": {"value": score.compliance, "fitted": score.is_compliance_fitted},
        "scale": score.scale,
        "cycles": score.n_cycles,
        "noise": score.noise,
        "metrics": {
            loop_row.name: {key: value for key, value in vars(loop_row).items() if key != "name"}
            for loop_row in score.loops
        },
        "read_as": score.read_as,
        "notes": list(score.notes),
        "scene": score.scene.model_dump(mode="json"),
    }


def table_of_loops(score: LoopScore) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Column heads, and a row of text cells for the measured loop and each computed one: name, f,
    area W, W over the measured one minus 1, slope, and distance from the measured rows (– where a
    loop has none).

    # notation: f coefficient of friction
    """
    unit_of_length, unit_of_stress = units(score.scene)[1:]
    area_head = f"area W [{energy_unit(score.scene)}]"
    distance_head = f"mean rows − loop, rms [{unit_of_length}]"
    slope_head = f"slope dU/dQ [1/{unit_of_stress}]"
    heads = ("loop", "f", area_head, "W/measured − 1", slope_head, distance_head)
    # the measured loop is the first of the rows of the table
    measured_loop = score.loops[0]
    table_rows: list[tuple[str, ...]] = []
    for loop_row in score.loops:
        area_cell = f"{loop_row.area:.5g}"
        if loop_row.area_uncertainty:
            area_cell += f" ± {loop_row.area_uncertainty:.2g}"
        difference_cell = "–"
        if loop_row is not measured_loop:
            difference_cell = minus(f"{100 * (loop_row.area / measured_loop.area - 1):+.2g} %")
        friction_cell = "–" if loop_row.friction is None else f"{loop_row.friction:.4g}"
        distance_cell = f"{loop_row.distance:.3g}" if math.isfinite(loop_row.distance) else "–"
        slope_cell = f"{loop_row.slope:.5g}"
        table_rows.append(
            (loop_row.name, friction_cell, area_cell, difference_cell, slope_cell, distance_cell)
        )
    return heads, table_rows


class _Means(NamedTuple):
    """Means of neighbouring rows, which are drawn as dots, (k,) each.

    Attributes
    ----------
    row_counts
        number of rows of which a mean is taken
    share_of_cycle
        share of the cycle that is over
    displacement, load
        U and Q
    residual
        U minus U of the best fit
    """

    row_counts: Array
    share_of_cycle: Array
    displacement: Array
    load: Array
    residual: Array


def _figures(score: LoopScore) -> tuple[Plate, ...]:
    """Two figures of a measured loop: the loop itself, and the residuals of its best fit. Dots are
    means of rows in equal parts of the cycle; the CSV files hold every row.

    # notation: Q tangential load, U relative tangential displacement
    """
    # U and Q of theory's loop at SHARES_OF_CYCLE of the cycle
    best_fit = score.curves[0]
    residuals = score.displacement - np.interp(
        score.share_of_cycle, SHARES_OF_CYCLE, best_fit.displacement
    )
    means = _Means(
        *means_of_parts(
            score.share_of_cycle, score.share_of_cycle, score.displacement, score.load, residuals
        )
    )
    # fewest and most rows of a mean, and number of means
    caption_numbers: dict[str, Any] = {
        "fewest": f"{means.row_counts.min():.0f}",
        "most": f"{means.row_counts.max():.0f}",
        "parts": len(means.row_counts),
    }
    return (
        _figure_of_loop(score, means, caption_numbers),
        _figure_of_residuals(score, means, residuals, caption_numbers),
    )


def _figure_of_loop(score: LoopScore, means: _Means, caption_numbers: dict[str, Any]) -> Plate:
    """The figure of U − slope Q over Q, for the rows of a measured loop and the computed loops. The
    slope dU/dQ is that of the best fit, so that a thin loop opens.

    Parameters
    ----------
    score
        the measured rows; `loops`, a table row for each loop, of which the first is the measured
        one and the second the best fit; `curves`, U and Q of the computed loops
    means
        means of U and Q over neighbouring rows, (k,) each, drawn as dots
    caption_numbers
        how many rows a mean is of, and how many means there are

    # notation: Q tangential load, U relative tangential displacement
    """
    _, unit_of_length, _ = units(score.scene)
    unit_of_load = load_unit(score.scene)
    best_fit = score.loops[1]
    slope = best_fit.slope
    offset_of_all_rows = float(np.mean(score.displacement - slope * score.load))
    dot_heights = means.displacement - slope * means.load - offset_of_all_rows
    drawn_curves = [
        Curve(
            curve.load,
            curve.displacement - slope * curve.load - offset_of_all_rows,
            f"line-{number}",  # its style in the page
            curve.name,
        )
        for number, curve in enumerate(score.curves, 1)
    ]
    # key, axes with their limits, marks, title, width and height in pixels
    panel = Panel(
        "loop",
        Axis(*axis_limits(means.load, drawn_curves[0].x), f"Q  [{unit_of_load}]"),
        Axis(
            *axis_limits(dot_heights, *(curve.y for curve in drawn_curves)),
            f"U − slope Q  [{unit_of_length}]",
        ),
        [*_dots(means.load, dot_heights), *drawn_curves],
        "Loop of displacement over tangential load",
        _WIDTH,
        380.0,
        css="broad",
    )
    # columns of the CSV file
    columns = {
        "tau": score.share_of_cycle,
        f"Q [{unit_of_load}]": score.load,
        f"U [{unit_of_length}]": score.displacement,
    }
    legend_keys = [Key(curve.css, curve.label) for curve in drawn_curves]
    # with caption and texts from templates, the CSV columns and a legend
    return figure_with_texts(
        "loop", [panel], columns, legend_keys, n_columns=1, slope=f"{slope:.4g}", **caption_numbers
    )


def _figure_of_residuals(
    score: LoopScore, means: _Means, residuals: Array, caption_numbers: dict[str, Any]
) -> Plate:
    """The figure of U of a measured loop minus U of its best fit, against time as a share of the
    cycle. Means of neighbouring rows are drawn; the residual of every row is in the file to
    download.

    Parameters
    ----------
    means
        means over neighbouring rows: share of the cycle and residual, (k,) each
    residuals
        (n,) U of the rows minus U of the best fit [length]
    caption_numbers
        how many rows a mean is of, and how many means there are

    # notation: U relative tangential displacement
    """
    _, unit_of_length, _ = units(score.scene)
    # key, axes with their limits, marks, title, width and height in pixels
    panel = Panel(
        "loop-rest",
        Axis(0.0, 1.0, "share of the cycle"),
        Axis(*axis_limits(means.residual), f"mean rows − best fit  [{unit_of_length}]"),
        [*_dots(means.share_of_cycle, means.residual), Rule(0.0, "zero")],
        "Residuals of the best fit over the cycle",
        _WIDTH,
        260.0,
        css="broad",
    )
    # with caption and texts from templates
    return figure_with_texts(
        "loop_residuals",
        [panel],
        # columns of the CSV file
        {"tau": score.share_of_cycle, f"U - fit [{unit_of_length}]": residuals},
        n_columns=1,
        noise=f"{score.noise:.3g}",
        length=unit_of_length,
        **caption_numbers,
    )


def _dots(x: Array, y: Array) -> list[Mark]:
    """A dot at each of the places (x, y), (k,)."""
    return [Dot(*place, "p0", 2.2) for place in zip(x.tolist(), y.tolist(), strict=True)]


def write(
    score: LoopScore,
    out: str | Path,
    command: str,
    further_entries: dict[str, Any] | None = None,
    sentences: Sequence[str] = (),
) -> Path:
    """Write the page report.html of a measured loop, loop.json and the CSV of each figure into the
    folder `out`; return the path of the page. `command` is the command line that page and JSON
    state.

    Parameters
    ----------
    further_entries
        entries of loop.json beside those of the score
    sentences
        what the page states below its first sentence
    """
    from reports.comparison.json_values import strict_json_values

    # JavaScript of the page, and its hash for the page's security policy
    page_script, script_hash = script()
    # figures, each with its caption and the columns of its CSV file
    plates = _figures(score)
    table_heads, table_rows = table_of_loops(score)
    # the files move to `out` only when all of them are written
    with results_folder(out) as new_folder:
        write_tables(plates, new_folder)
        json_content = strict_json_values(content(score) | (further_entries or {})) | {
            "command": command
        }
        (new_folder / "loop.json").write_text(
            json.dumps(json_content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
        )
        page_text = template("loop.html").render(
            title=f"Measured loop: {Path(score.source).name}",
            scene=score.scene,
            question=question_in_words(score.scene),
            score=score,
            sentences=sentences,
            source_name=Path(score.source).name,
            stress=units(score.scene)[2],
            heads=table_heads,
            rows=table_rows,
            drawings=plates,
            command=command,
            script=page_script,
            script_hash=script_hash,
        )
        (new_folder / "report.html").write_text(page_text, encoding="utf-8")
    return Path(out) / "report.html"
