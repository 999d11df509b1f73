"""The meshes of both bodies: whole, around the contact, and at an edge of the contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.charts import marks
from reports.charts.panel import Axis, equal, panel
from reports.charts.plate import Key, Plate
from reports.comparison import Comparison

Array = NDArray[np.float64]
# Coordinates in the file are whole numbers of a_ref over this.
_GRAIN = 5000


def mesh(comparison: Comparison, bodies: Sequence[Any]) -> Plate:
    """The meshes of the result's bodies, y out of the lower body."""
    half_width = comparison.scales.half_width
    sides = [_sides(body.mesh) * (1.0, side) / half_width for body, side in zip(bodies, (1.0, -1.0), strict=True)]
    low, high = np.concatenate(sides).min(axis=(0, 1)), np.concatenate(sides).max(axis=(0, 1))
    edge = float(np.nanmax(comparison.found.contact_edges)) / half_width
    half = 0.54 * float(max(high - low))
    views = (
        ("whole", (low + high) / 2, half),
        ("at the contact", np.zeros(2), 1.35 * max(edge, 1.0)),
        ("at the contact's edge", np.array([edge, 0.0]), 0.06),
    )
    paths = {name: _path(lines) for name, lines in zip(("lower", "upper"), sides, strict=True)}
    quality = {
        f"{name} {key}": value for name, body in zip(("lower", "upper"), bodies, strict=True) for key, value in body.quality.items()
    }
    return Plate(
        "mesh",
        "Mesh",
        "Distances in a_ref. Sides of curved elements are drawn straight.",
        "Finite-element meshes of both bodies: whole, at the contact, and at the edge of the largest contact.",
        tuple(_view(number, *view, paths) for number, view in enumerate(views)),
        {"quantity": list(quality), "value": list(quality.values())},
        (Key("mesh-lower", "lower body"), Key("mesh-upper", "upper body")),
        columns=3,
    )


def _view(number: int, words: str, centre: Array, half: float, paths: dict[str, str]) -> str:
    """One window; the first holds the lines, the others use them again."""
    across, up = (float(c) for c in centre)
    axes = Axis(across - half, across + half, "x / a_ref"), Axis(up - half, up + half, "y / a_ref")
    area = equal(*axes, 340.0, 340.0, top=26.0)
    shown = Axis(area.x.low, area.x.high, "x / a_ref"), Axis(area.y.low, area.y.high, "y / a_ref")
    zoom = (area.x.end - area.x.start) / (area.x.high - area.x.low) / _GRAIN
    x, y = float(area.x.place(0.0)), float(area.y.place(0.0))
    lines = [
        marks.element(
            "path",
            d=d,
            id=f"mesh-{name}",
            class_=f"mesh-{name}",
            transform=f"translate({x:.3f} {y:.3f}) scale({zoom:.7g} {-zoom:.7g})",
        )
        if number == 0
        else marks.element("use", href=f"#mesh-{name}", transform=_again(x, y, zoom, paths["first"]))
        for name, d in paths.items()
        if name != "first"
    ]
    if number == 0:
        paths["first"] = f"{x:.3f} {y:.3f} {zoom:.7g}"
    heading = marks.words(area.x.start, 17, words, class_="title")
    return panel(area, *shown, lines, f"Mesh, {words}", clip=f"mesh-{number}", extra=heading)


def _again(x: float, y: float, zoom: float, first: str) -> str:
    """What turns the places of the first window into those of another."""
    x0, y0, zoom0 = (float(part) for part in first.split())
    factor = zoom / zoom0
    return f"translate({x - factor * x0:.4f} {y - factor * y0:.4f}) scale({factor:.7g})"


def _path(sides: Array) -> str:
    """All sides as one path in whole numbers."""
    whole = np.rint(sides * _GRAIN).astype(int)
    moves = (whole[:, 1] - whole[:, 0]).tolist()
    return "".join(f"M{x} {y}l{dx} {dy}" for (x, y), (dx, dy) in zip(whole[:, 0].tolist(), moves, strict=True))


def _sides(mesh: Any) -> Array:
    """(n_sides, 2, 2) end points of the sides of a mesh's elements, each side once."""
    return np.asarray(mesh.p.T[mesh.facets.T])
