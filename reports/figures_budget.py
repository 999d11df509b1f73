"""Figures of the error budget and of mesh studies: what every metric is made of, and how fast it converges."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from reports.charts.marks import Axis, Block, Curve, Dot, Mark, Note, Rule
from reports.charts.plate import Key, Panel, Plate
from reports.comparison.budget import ROUNDING, Budget, ErrorBudget
from reports.comparison.convergence import Ladder, extrapolate
from reports.comparison.words import value_of
from reports.figures_cycle import LINES
from reports.units import minus

if TYPE_CHECKING:
    from reports.scoring.study import Study

_ROW = 44.0
# A row that is this many times as long as the middle one is cut off, so that the others can be read.
_CUT = 3.0


def bars(budget: ErrorBudget) -> Plate | None:
    """The terms of every metric that has a tolerance as a stack over it; None where no metric has one.

    What adds to the metric lies right of zero, what takes from it left: the two stacks together are E. Where the scene states no
    tolerance at all, the metrics of the first table in per cent.
    """
    judged = [one for one in budget.budgets if one.metric.tolerance]
    shown = judged or [one for one in budget.budgets if one.metric.definition.headline]
    if not shown:
        return None
    rest = "unexplained" if shown[0].half_planes else "idealisation"
    names = [*(term.name for term in shown[0].terms), rest]
    unit = "of the tolerance" if judged else "%"

    def over(one: Budget, value: float | None) -> float:
        return (value or 0.0) / ((one.metric.tolerance or 1.0) if judged else 0.01)

    stacks = []
    for one in shown:
        parts = (over(one, part) for part in (*(term.value for term in one.terms), one.rest))
        stacks.append([part if math.isfinite(part) else 0.0 for part in parts])
    reaches = [
        max(
            sum(s for s in shares if s > 0),
            -sum(s for s in shares if s < 0),
            abs(over(one, one.total)) + over(one, one.uncertainty),
        )
        for one, shares in zip(shown, stacks, strict=True)
    ]
    middle = float(np.median(reaches))
    wide = 1.08 * max(1.05 if judged else 0.0, min(max(reaches), _CUT * middle) or 1.0)
    marks: list[Mark] = [Rule(side, "limit", upright=True) for side in (-1.0, 1.0) if judged]
    marks.append(Rule(0.0, "zero", upright=True))
    for row, (one, shares) in enumerate(zip(shown, stacks, strict=True)):
        low = float(len(shown) - row - 1)
        ends = {True: 0.0, False: 0.0}
        for k, (share, name) in enumerate(zip(shares, names, strict=True)):
            if share:
                start = ends[share > 0]
                ends[share > 0] = start + share
                label = f"{name}: {share:+.3g} {unit}".replace("-", "−")
                marks.append(Block((start, start + share), (low + 0.14, low + 0.5), f"term-{k} edge", label))
        marks += _mark_of_total(low, over(one, one.total), over(one, one.uncertainty), wide)
        beyond = ", cut off" if reaches[row] > wide else ""
        known = "" if one.metric.absolute or one.uncertainty is None else minus(f" ± {100 * one.uncertainty:.2g} %")
        words = f"{one.metric.label}: {value_of(one.metric)}{known}{beyond}"
        marks.append(Note(-wide, low + 0.7, words, "tick over", shift=(6.0, 0.0)))
    panel = Panel(
        "budget",
        Axis(-wide, wide, "share of the tolerance" if judged else "per cent", count=8),
        Axis(0.0, float(len(shown)), "", count=0),
        marks,
        "Error budget as stacked bars",
        900.0,
        _ROW * len(shown) + 60,
        css="broad",
    )
    return Plate(
        "budget",
        "What every discrepancy is made of",
        ("Each term over the metric's tolerance (thin lines: ±1)" if judged else "Each term in per cent")
        + "; the black mark is the whole discrepancy E with its uncertainty. A row much longer than the others is cut off.",
        "Stacked bars: the terms of the error of every metric, over its tolerance.",
        (panel,),
        {
            "metric": [one.metric.key for one in shown],
            "tolerance": [math.nan if one.metric.tolerance is None else one.metric.tolerance for one in shown],
            "E": [one.total for one in shown],
            **{name: [_or_nan(one.terms[k].value) for one in shown] for k, name in enumerate(names[:-1])},
            rest: [one.rest for one in shown],
            "u": [_or_nan(one.uncertainty) for one in shown],
        },
        tuple(Key(f"term-{k}", name, patch=True) for k, name in enumerate(names)),
        columns=1,
    )


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


def _mark_of_total(low: float, total: float, doubt: float, wide: float) -> Iterator[Mark]:
    """E as an upright mark with its uncertainty across it; a head at the edge where it goes on beyond."""
    middle = low + 0.32
    if abs(total) <= wide:
        yield Curve([total, total], [low + 0.06, low + 0.58], "total")
    left, right = max(total - doubt, -wide), min(total + doubt, wide)
    if right > left:
        yield Curve([left, right], [middle, middle], "whisker")
    for side, end in ((-1, total - doubt), (1, total + doubt)):
        if side * end > wide:
            tip, back = side * 0.998 * wide, side * 0.985 * wide
            yield Curve([back, tip, back], [middle - 0.1, middle, middle + 0.1], "whisker")


def ladders(budget: ErrorBudget) -> Plate | None:
    """|phi(h) - phi(0)| of the headline metrics over the element size; None for two meshes or where no metric converges."""
    rungs = [rung for rung in budget.ladders.mesh if not rung.failure]
    curves = {}
    for one in budget.budgets:
        values = [(rung.size, rung.values.get(one.metric.key)) for rung in rungs]
        points = [(size, float(value)) for size, value in values if value is not None and math.isfinite(value)]
        if one.metric.definition.headline and len(points) >= 3:
            found = extrapolate(Ladder(tuple(size for size, _ in points), tuple(value for _, value in points), 2.0, ROUNDING))
            if found.kind == "monotone" and found.value is not None:
                curves[one.metric.label] = [(size, abs(value - found.value)) for size, value in points if value != found.value]
    words = "element size, over that of the run", "distance from the value at size zero"
    caption = (
        "Each metric on coarser meshes, its distance from what the ladder extrapolates to; a metric that only scatters is left out."
    )
    return _convergence("ladders", "Mesh ladders", caption, words, curves, [rung.size for rung in rungs])


def distances(study: Study) -> Plate | None:
    """|E(h) - E(0)| of each headline metric that goes to a value, over the element size; None for two meshes or where none does."""
    sizes, curves = [level.size for level in study.levels], {}
    for line in study.lines:
        if line.metric.definition.headline and line.found.kind == "monotone" and (limit := line.found.value) is not None:
            pairs = zip(sizes, line.values, strict=True)
            curves[line.metric.label] = [(size, abs(value - limit)) for size, value in pairs]
    words = "element size at the contact", "distance from the value at h = 0"
    caption = "Each metric on each mesh, its distance from what the meshes extrapolate to, but those that scatter or are exact."
    return _convergence("study", "How fast it converges", caption, words, curves, sizes)


def _convergence(
    name: str,
    title: str,
    caption: str,
    words: tuple[str, str],
    found: Mapping[str, list[tuple[float, float]]],
    used: Sequence[float],
) -> Plate | None:
    """Distances over the element size, both logarithmic, beside lines of order 1 and 2."""
    curves = {label: points for label, points in found.items() if any(height > 0 for _, height in points)}
    if len(used) < 3 or not curves:
        return None
    sizes = np.array(sorted(used))
    heights = [height for points in curves.values() for _, height in points if height > 0]
    top = max(heights)
    marks: list[Mark] = [
        Curve(sizes, top * (sizes / sizes[-1]) ** order, f"slope order-{order}", f"order {order}") for order in (1, 2)
    ]
    keys = []
    for (label, points), css in zip(curves.items(), LINES * 3, strict=False):
        h, height = np.array(points).T
        marks.append(Curve(h, height, css, label))
        marks += [Dot(float(a), float(b), f"{css} knot", 3.2) for a, b in points if b > 0]
        keys.append(Key(css, label))
    panel = Panel(
        name,
        Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), words[0], log=True),
        # Below a millionth of the largest distance a curve is round-off.
        Axis(max(min(heights), 1e-6 * top) / 3, 3 * top, words[1], log=True),
        marks,
        f"{title}, both axes logarithmic",
        900.0,
        360.0,
        css="broad",
    )
    return Plate(
        name,
        title,
        caption,
        "Distances from the extrapolated values over the element size, both logarithmic, with lines of order one and two.",
        (panel,),
        {
            "metric": [label for label, points in curves.items() for _ in points],
            "size": [size for points in curves.values() for size, _ in points],
            "distance": [height for points in curves.values() for _, height in points],
        },
        (*keys, Key("slope order-1", "order 1"), Key("slope order-2", "order 2")),
        columns=1,
    )
