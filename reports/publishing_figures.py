"""The picture of a published scene: tractions at the largest load, and the loop or the half-widths. Few points, small file."""

from __future__ import annotations

import io
import re

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from reports.comparison import Comparison
from reports.definitions import name_of
from reports.drawing import BANDS, STYLE, THIN, canvas, label_axes, legend_above
from reports.figures_cycle import sides

# Texts stay texts (no outlines of letters in the file); points nearer than this to the line through their neighbours go [px].
_LEAN = {**STYLE, "svg.fonttype": "none", "path.simplify_threshold": 0.25, "font.family": "sans-serif"}

# Of the two sides of a comparison: broad and pale the reference, thin and dark the result.
_STYLES = {"r": BANDS, "f": THIN}


def picture(comparison: Comparison) -> str:
    """Two panels as an SVG document: the same data gives the same text; coordinates to a hundredth of a point."""
    with canvas(9.6, 3.5) as figure:
        left, right = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.08, right=0.985, top=0.8, bottom=0.14, wspace=0.25)
        _tractions(comparison, left)
        if _moves(comparison):
            _loop(comparison, right)
        else:
            _half_widths(comparison, right)
        for axes in (left, right):
            legend_above(axes, columns=2)
    text = io.StringIO()
    with mpl.rc_context(_LEAN):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    # Inside quotes stand coordinates, outside them the words and numbers that are read.
    return re.sub(r'"[^"]*"', lambda quoted: re.sub(r"-?\d+\.\d{3,}", _shorter, quoted[0]), text.getvalue())


def _shorter(found: re.Match[str]) -> str:
    return f"{float(found[0]):.2f}".rstrip("0").rstrip(".")


def _tractions(comparison: Comparison, axes: Axes) -> None:
    """p and q where P is largest, and of these instants where |Q| is."""
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    largest = expected.normal_load >= expected.normal_load.max() * (1 - 1e-9)
    k = int(np.argmax(np.where(largest, np.abs(expected.tangential_load), -1.0)))
    x = found.x / scales.half_width
    edges = np.concatenate([expected.contact_edges[k], found.contact_edges[k]])
    reach = min(1.12 * float(np.nanmax(np.abs(edges))) / scales.half_width, float(np.abs(x).max()))
    near = np.abs(x) <= reach
    for who, cycle, solution in sides(comparison):
        name, styles = name_of(solution.engine), _STYLES[who]
        axes.plot(x[near], cycle.pressure[k, near] / scales.pressure, label=f"p, {name}", **styles[0])
        axes.plot(x[near], cycle.shear[k, near] / scales.shear, label=f"q, {name}", **styles[1])
    axes.set_xlim(-reach, reach)
    label_axes(axes, "x / a_ref", "p/p_ref,  q/(f p_ref)")


def _moves(comparison: Comparison) -> bool:
    """Whether the upper body is shifted at all."""
    return bool(np.ptp(comparison.expected.tangential_displacement) > 1e-9 * comparison.scales.shift)


def _loop(comparison: Comparison, axes: Axes) -> None:
    """Q over the shift less its mean slope: each loop about its own middle, for finite bodies are stiffer than half-planes."""
    scales = comparison.scales
    for who, cycle, solution in sides(comparison):
        load = cycle.tangential_load - cycle.tangential_load.mean()
        shift = cycle.tangential_displacement - cycle.tangential_displacement.mean()
        slope = float(load @ shift) / float(load @ load) if load @ load > 0 else 0.0
        axes.plot(
            (shift - slope * load) / scales.shift,
            cycle.tangential_load / _size(comparison),
            label=name_of(solution.engine),
            **_STYLES[who][0],
        )
    label_axes(axes, "(U − mean slope · Q) / (A f P_ref)", "Q/(f P_ref)")


def _size(comparison: Comparison) -> float:
    return comparison.scales.friction * comparison.scales.normal_load


def _half_widths(comparison: Comparison, axes: Axes) -> None:
    """Contact half-width over P."""
    for who, cycle, solution in sides(comparison):
        half = (cycle.contact_edges[:, 1] - cycle.contact_edges[:, 0]) / 2
        order = np.argsort(cycle.normal_load, kind="stable")
        axes.plot(
            cycle.normal_load[order] / comparison.scales.normal_load,
            half[order] / comparison.scales.half_width,
            label=name_of(solution.engine),
            **_STYLES[who][0],
        )
    label_axes(axes, "P/P_ref", "contact half-width / a_ref")
