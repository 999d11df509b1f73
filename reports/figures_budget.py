"""Figures of the error budget: what every metric is made of, and the ladders that this was measured by."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from reports.budget import ROUNDING, Budget, ErrorBudget
from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.charts.scale import limits
from reports.convergence import Ladder, extrapolate
from reports.drawing import Table
from reports.figures_cycle import LINES

_ROW = 40.0


def bars(budget: ErrorBudget) -> Plate | None:
    """The terms of every metric that has a tolerance as a stack over it; None where no metric has one.

    What adds to the metric lies right of zero, what takes from it left: the two stacks less each other are E.
    """
    shown = [one for one in budget.budgets if one.metric.tolerance]
    if not shown:
        return None
    names = [term.name for term in shown[0].terms]
    rest = "unexplained" if shown[0].half_planes else "idealisation"
    stacks = [_shares(one) for one in shown]
    ends = [end for shares in stacks for end in (sum(s for s in shares if s > 0), sum(s for s in shares if s < 0))]
    marks_of_e = [(one.total + side * (one.uncertainty or 0.0)) / _tolerance(one) for one in shown for side in (-1, 1)]
    axes = (
        Axis(*limits([*ends, *marks_of_e, -1.0, 1.0]), "share of the tolerance", count=8),
        Axis(0.0, float(len(shown)), "", count=0),
    )
    area = frame(*axes, width=900.0, height=_ROW * len(shown) + 60)
    lines = [marks.vertical(area, side, "limit") for side in (-1.0, 1.0)] + [marks.vertical(area, 0.0, "zero")]
    for row, (one, shares) in enumerate(zip(shown, stacks, strict=True)):
        lines += _stack(area, len(shown) - row - 1, one, shares, [*names, rest])
    return Plate(
        "budget",
        "What every discrepancy is made of",
        "Each term over the metric's tolerance (thin lines: ±1); the black mark is the whole discrepancy E with its uncertainty.",
        "Stacked bars: the terms of the error of every metric, over its tolerance.",
        (panel(area, axes[0], axes[1], lines, "Error budget as stacked bars", clip="budget", css="broad bars"),),
        _bar_table(shown, names, rest),
        tuple(Key(f"term-{k}", name, patch=True) for k, name in enumerate([*names, rest])),
        columns=1,
    )


def _bar_table(shown: list[Budget], names: list[str], rest: str) -> Table:
    """What the bars show, not over the tolerance."""
    terms = {name: [_or_nan(one.terms[k].value) for one in shown] for k, name in enumerate(names)}
    return {
        "metric": [one.metric.key for one in shown],
        "tolerance": [one.metric.tolerance for one in shown],
        "E": [one.total for one in shown],
        **terms,
        rest: [one.rest for one in shown],
        "u": [_or_nan(one.uncertainty) for one in shown],
    }


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def _tolerance(one: Budget) -> float:
    return one.metric.tolerance or 1.0


def _shares(one: Budget) -> list[float]:
    """Every term and the rest over the tolerance; 0 for what is not known or not finite."""
    parts = [*(term.value or 0.0 for term in one.terms), one.rest]
    return [part / _tolerance(one) if math.isfinite(part) else 0.0 for part in parts]


def _stack(area: marks.Frame, row: int, one: Budget, shares: list[float], names: list[str]) -> Iterator[str]:
    """Name, bars and the mark of E of one metric, in the row counted from below."""
    yield marks.words(area.x.start + 6, float(area.y.place(row + 0.97)) + 13, one.metric.label, class_="tick over")
    ends = {True: 0.0, False: 0.0}
    for k, (share, name) in enumerate(zip(shares, names, strict=True)):
        if share:
            start = ends[share > 0]
            ends[share > 0] = start + share
            label = f"{name}: {share:+.3g} of the tolerance".replace("-", "−")
            yield marks.block(area, (start, start + share), (row + 0.16, row + 0.56), f"term-{k}", data_label=label)
    total, doubt = one.total / _tolerance(one), (one.uncertainty or 0.0) / _tolerance(one)
    across, up = area.x.place([total - doubt, total, total + doubt]), area.y.place([row + 0.08, row + 0.36, row + 0.64])
    yield marks.element("path", d=marks.path_of([across[1]] * 2, [up[0], up[2]]), class_="total")
    yield marks.element("path", d=marks.path_of([across[0], across[2]], [up[1]] * 2), class_="whisker")


def ladders(budget: ErrorBudget) -> Plate | None:
    """|phi(h) - phi(0)| of the headline metrics over the element size, both logarithmic, beside lines of order 1 and 2."""
    rungs = [rung for rung in budget.ladders.mesh if not rung.failure]
    found = {one.metric.label: _distances(one, budget) for one in budget.budgets if one.metric.definition.headline}
    curves = {label: points for label, points in found.items() if points}
    if len(rungs) < 3 or not curves:
        return None
    sizes = np.array([rung.size for rung in rungs])
    heights = np.array([height for points in curves.values() for _, height in points])
    top = float(heights.max())
    low = max(float(heights.min()), 1e-6 * top)
    axes = (
        Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), "element size, over that of the run", log=True),
        Axis(low / 3, 3 * top, "distance from the value at size zero", log=True),
    )
    area = frame(*axes, width=900.0, height=360.0)
    lines = [
        marks.curve(area, sizes, top * (sizes / sizes[-1]) ** order, f"slope order-{order}", f"order {order}") for order in (1, 2)
    ]
    for (label, points), css in zip(curves.items(), LINES * 3, strict=False):
        h, height = np.array(points).T
        lines.append(marks.curve(area, h, height, css, label))
        lines += [marks.dot(area, float(a), float(b), f"{css} knot", 3.2) for a, b in points]
    keys = [Key(css, label) for (label, _), css in zip(curves.items(), LINES * 3, strict=False)]
    return Plate(
        "ladders",
        "Mesh ladders",
        "Each metric on coarser meshes, its distance from what the ladder extrapolates to; a metric that only "
        "scatters is left out.",
        "Distances from the extrapolated values over the element size, both logarithmic, with lines of order one and two.",
        (panel(area, *axes, lines, "Mesh ladders, both axes logarithmic", clip="ladders"),),
        {
            "metric": [label for label, points in curves.items() for _ in points],
            "size": [size for points in curves.values() for size, _ in points],
            "distance": [height for points in curves.values() for _, height in points],
        },
        (*keys, Key("slope order-1", "order 1"), Key("slope order-2", "order 2")),
        columns=1,
    )


def _distances(one: Budget, budget: ErrorBudget) -> list[tuple[float, float]]:
    """(size, |phi - phi_0|) of every rung; none where the ladder has no value at size zero that it goes to."""
    points = [
        (rung.size, float(value))
        for rung in budget.ladders.mesh
        if not rung.failure and (value := rung.values.get(one.metric.key)) is not None and math.isfinite(value)
    ]
    if len(points) < 3:
        return []
    sizes, values = zip(*points, strict=True)
    found = extrapolate(Ladder(sizes, values, 2.0, ROUNDING))
    if found.kind != "monotone" or found.value is None:
        return []
    return [(size, abs(value - found.value)) for size, value in points if value != found.value]
