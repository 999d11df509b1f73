"""The picture of a published scene: tractions at the largest load, and the loop or the half-widths. Few points, small file."""

from __future__ import annotations

import numpy as np

from reports.charts.marks import Axis, Curve
from reports.charts.plate import Key, Panel, Plate
from reports.charts.scale import limits
from reports.comparison import Comparison
from reports.comparison.metrics import name_of
from reports.figures_cycle import sheared_shift
from reports.figures_fields import sides


def picture(comparison: Comparison) -> str:
    """Two panels as an SVG document: the same data gives the same text."""
    cycles, moves = sides(comparison), bool(np.ptp(comparison.expected.tangential_displacement) > 1e-9 * comparison.scales.shift)
    panels = (_tractions(comparison), _loop(comparison) if moves else _half_widths(comparison))
    keys = tuple(Key(f"{who} {css}", f"{css}, {name_of(s.engine)}") for who, _, s in cycles for css in "pq")
    title = comparison.scene.title or comparison.scene.name
    return Plate(comparison.scene.name, title, "", f"Both engines on {comparison.scene.name}", panels, {}, keys).svg() + "\n"


def _tractions(comparison: Comparison) -> Panel:
    """p and q where P is largest, and of these instants where |Q| is."""
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    largest = expected.normal_load >= expected.normal_load.max() * (1 - 1e-9)
    k = int(np.argmax(np.where(largest, np.abs(expected.tangential_load), -1.0)))
    x = found.x / scales.half_width
    edges = np.concatenate([expected.contact_edges[k], found.contact_edges[k]])
    reach = min(1.12 * float(np.nanmax(np.abs(edges))) / scales.half_width, float(np.abs(x).max()))
    near = np.abs(x) <= reach
    curves = []
    for who, cycle, _ in sides(comparison):
        for css, y in (("p", cycle.pressure[k, near] / scales.pressure), ("q", cycle.shear[k, near] / scales.shear)):
            kept = _corners(x[near], y)
            curves.append(Curve(x[near][kept], y[kept], f"{who} {css}"))
    up = Axis(*limits(*(curve.y for curve in curves), zero=True), "p/p_ref,  q/(f p_ref)")
    return Panel("tractions", Axis(-reach, reach, "x / a_ref"), up, curves, "Tractions over x")


def _loop(comparison: Comparison) -> Panel:
    """Q over the shift less its mean slope: each loop about its own middle, for finite bodies are stiffer than half-planes."""
    scales, curves = comparison.scales, []
    for who, cycle, _ in sides(comparison):
        u, q = sheared_shift(cycle) / scales.shift, cycle.tangential_load / (scales.friction * scales.normal_load)
        kept = _corners(u / (np.ptp(u) or 1.0), q / (np.ptp(q) or 1.0))
        curves.append(Curve(u[kept], q[kept], f"{who} p"))
    across = Axis(*limits(*(curve.x for curve in curves)), "(U − mean slope · Q) / (A f P_ref)")
    return Panel("loop", across, Axis(*limits(*(curve.y for curve in curves)), "Q/(f P_ref)"), curves, "Load over shift")


def _half_widths(comparison: Comparison) -> Panel:
    """Contact half-width over P."""
    curves = []
    for who, cycle, _ in sides(comparison):
        order = np.argsort(cycle.normal_load, kind="stable")
        x = cycle.normal_load[order] / comparison.scales.normal_load
        y = np.ptp(cycle.contact_edges, axis=1)[order] / 2 / comparison.scales.half_width
        kept = _corners(x / (np.ptp(x) or 1.0), y / (float(np.nanmax(y, initial=0.0)) or 1.0))
        curves.append(Curve(x[kept], y[kept], f"{who} p"))
    across = Axis(*limits(*(curve.x for curve in curves), zero=True), "P/P_ref")
    return Panel(
        "half-widths", across, Axis(*limits(*(curve.y for curve in curves)), "contact half-width / a_ref"), curves, "Half-width"
    )


def _corners(x: np.ndarray, y: np.ndarray, off: float = 1e-3) -> list[int]:
    """Indices of the points that a line needs so that none of the others is `off` from it (Douglas and Peucker 1973).

    >>> _corners(np.arange(5.0), np.array([0.0, 0.0, 1.0, 0.0, 0.0]))
    [0, 1, 2, 3, 4]
    """
    points = np.column_stack([x, y])
    kept, open_parts = {0, len(points) - 1}, [(0, len(points) - 1)]
    while open_parts:
        a, b = open_parts.pop()
        if b - a < 2:
            continue
        along = points[b] - points[a]
        apart, size = points[a + 1 : b] - points[a], float(np.hypot(*along))
        away = np.abs(along[0] * apart[:, 1] - along[1] * apart[:, 0]) / size if size else np.hypot(apart[:, 0], apart[:, 1])
        k = int(np.nanargmax(np.nan_to_num(away, nan=np.inf))) + a + 1
        if not away[k - a - 1] <= off:
            kept.add(k)
            open_parts += [(a, k), (k, b)]
    return sorted(kept)
