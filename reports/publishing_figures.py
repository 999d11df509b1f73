"""The picture of a published scene, of the page's own panels: tractions at the largest load, and the loop or the half-widths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reports.charts.plate import Key, Plate
from reports.comparison import Comparison
from reports.comparison.cycles import events
from reports.comparison.metrics import name_of
from reports.figures_cycle import half_widths, hysteresis
from reports.figures_fields import X, sides, traction_panels


def picture(comparison: Comparison) -> str:
    """Two panels as an SVG document: the same data gives the same text."""
    expected, scene = comparison.expected, comparison.scene
    # Where P is largest, and of these instants where |Q| is.
    largest = expected.normal_load >= expected.normal_load.max() * (1 - 1e-9)
    k = int(np.argmax(np.where(largest, np.abs(expected.tangential_load), -1.0)))
    tractions, _ = traction_panels(comparison, k, [k], "tractions", (440.0, 330.0), f"t = {expected.time[k]:.4g}")
    tractions = replace(tractions, x=replace(tractions.x, words=X), room=None)
    moves = np.ptp(expected.tangential_displacement) > 1e-9 * comparison.scales.shift
    loop = hysteresis(comparison, events(comparison.found, scene.friction.coefficient)) if moves else None
    beside = loop.panels[1] if loop else half_widths(comparison, comparison.found.time, "time").panels[0]
    keys = tuple(Key(f"{who} {css}", f"{css}, {name_of(s.engine)}") for who, _, s in sides(comparison) for css in "pq")
    title = scene.title or scene.name
    return Plate(scene.name, title, "", f"Both engines on {scene.name}", (tractions, beside), {}, keys).svg() + "\n"
