"""How fast the discrepancies of a mesh study fall: their distances from the value at size zero over the element size."""

from __future__ import annotations

import numpy as np

from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.figures_cycle import LINES
from reports.scoring.study import Study, StudyRow

# Below this share of the largest distance a curve is rounding.
LEAST = 1e-6


def distances(study: Study) -> Plate | None:
    """|E(h) - E(0)| of every headline metric that goes to a value, log-log; None for two meshes or where none does."""
    shown = [line for line in study.lines if line.metric.definition.headline and line.found.kind == "monotone"]
    shown = [line for line in shown if line.found.value is not None and max(_heights(line)) > 0]
    if len(study.levels) < 3 or not shown:
        return None
    sizes = np.array([level.size for level in study.levels])
    top = max(max(_heights(line)) for line in shown)
    low = max(min(min(_heights(line)) for line in shown), LEAST * top)
    axes = (
        Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), "element size at the contact", log=True),
        Axis(low / 3, 3 * top, "distance from the value at h = 0", log=True),
    )
    area = frame(*axes, width=900.0, height=340.0)
    slopes = (top * (sizes / sizes[-1]) ** order for order in (1, 2))
    lines = [marks.curve(area, sizes, slope, f"slope order-{k}", f"order {k}") for k, slope in enumerate(slopes, 1)]
    styles = [LINES[k % len(LINES)] for k in range(len(shown))]
    for line, css in zip(shown, styles, strict=True):
        lines.append(marks.curve(area, sizes, np.array(_heights(line)), css, line.metric.label))
        lines += [
            marks.dot(area, float(h), float(d), f"{css} knot", 3.2) for h, d in zip(sizes, _heights(line), strict=True) if d > 0
        ]
    keys = [Key(css, line.metric.label) for line, css in zip(shown, styles, strict=True)]
    return Plate(
        "study",
        "How fast it converges",
        "Each metric on each mesh, its distance from what the meshes extrapolate to; a metric that only scatters, or is exact, "
        "is left out.",
        "Distances from the extrapolated values over the element size, both logarithmic, with lines of order one and two.",
        (panel(area, *axes, lines, "Mesh study, both axes logarithmic", clip="study"),),
        {
            "metric": [line.metric.label for line in shown for _ in sizes],
            "size": [float(size) for _ in shown for size in sizes],
            "distance": [height for line in shown for height in _heights(line)],
        },
        (*keys, Key("slope order-1", "order 1"), Key("slope order-2", "order 2")),
        columns=1,
    )


def _heights(line: StudyRow) -> list[float]:
    """|E(h) - E(0)| on each mesh."""
    return [abs(value - float(line.found.value or 0.0)) for value in line.values]
