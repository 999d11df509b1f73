"""Tables of flat pads: the law of their contour beside what was fitted, and what its correction leaves on points apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reports.maps.atlas import MAPS
from reports.maps.contour import work_constant
from reports.maps.fitting import Line, lines
from reports.maps.laws import leading_constant
from reports.maps.readings import read
from reports.maps.tabling import table
from reports.maps.trials import left

RATIO, SHEAR = 0.6, 0.3  # of the study `pad`: Q over f P, and over P


def work_lines(folder: Path) -> list[Line]:
    """The lines of dissipation in the study `pad`."""
    chart = next(chart for chart in MAPS["curvature"].charts if chart.study == "pad")
    return [line for line in lines(chart, read(folder, "pad")) if line.figure == "error.dissipation"]


def derived_constants(folder: Path) -> list[str]:
    """The first-order constant of dissipation by the contour's law beside the fitted one."""
    rows = []
    for line in work_lines(folder):
        known = work_constant(float(line.at["flat"]), RATIO)
        fit, doubt = leading_constant(line.s, line.error, line.uncertainty, line.order)
        verdict = "in the interval" if abs(fit - known) <= doubt else f"off by {fit - known:+.2g}"
        rows.append([line.at["flat"], f"{fit:.3f} ± {doubt:.3f}", f"{known:.4f}", verdict])
    words = (
        "A face that is no parabola changes the tangential compliance of its body by a kernel that follows from the face's Hilbert "
        "transform; `reports/maps/contour.py` derives it and what it does to W. Nothing is fitted in the column *derived*. "
        "Fitted is error/(a/R) = k + k₁ a/R + k₂ (a/R)² + k₃ (a/R)³ through all points: the second term is 1.5 to 6 a/R of the "
        "first, of which the exponential of the laws above is a poor image."
    )
    head = ["b / a", "fitted constant of a/R", "derived", ""]
    return ["## The constant of dissipation that theory predicts", words, table(head, rows)]


def corrected_pads(folder: Path) -> list[str]:
    """What the correction leaves on pads, curvatures and loads that no law was made from."""
    rows, shares = [], []
    for row in read(folder, "pad-held-out").rows:
        flat, curvature, ratio = (float(row[name]) for name in ("flat", "curvature", "ratio"))
        error, doubt = float(row["error.dissipation"]), float(row["error.dissipation.uncertainty"])
        predicted = work_constant(flat, ratio) * curvature
        rest = left(error, predicted)
        shares.append(1 - abs(rest) / abs(error))
        cells = (f"{100 * error:+.2f}", f"{100 * doubt:.2f}", f"{100 * predicted:+.2f}", f"{100 * rest:+.2f}")
        rows.append([row["flat"], row["curvature"], row["ratio"], *cells, "resolved" if abs(rest) > doubt else "not resolved"])
    words = (
        "`reports.maps.corrections.corrected_dissipation(scene, value)` corrects half-plane theory's dissipation of such a pad by "
        "the first power alone. On these pads, to which nothing was fitted, it removes "
        f"{100 * min(shares):.0f} to {100 * max(shares):.0f} % of the error of dissipation, "
        f"{100 * float(np.median(shares)):.0f} % in the median."
    )
    head = [
        "b / a",
        "a / R",
        "Q / (f P)",
        "error of theory, %",
        "uncertainty, %",
        "predicted, %",
        "left after correction, %",
        "what is left",
    ]
    return ["## Correction on pads that nothing was fitted to", words, table(head, rows)]
