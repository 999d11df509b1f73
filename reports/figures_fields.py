"""Figures over x: tractions, the stick/slip map, pointwise dissipation, the mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from reports.comparison import Comparison
from reports.definitions import name_of
from reports.drawing import (
    BANDS,
    DIFFERENCE,
    QUIET,
    REFERENCE,
    RESULT,
    STATE_COLOURS,
    STATE_NAMES,
    THIN,
    Drawing,
    Table,
    canvas,
    label_axes,
    legend_above,
)
from reports.instants import Event
from scenes import SurfaceState

Array = NDArray[np.float64]
_X = "x / a_ref"


def tractions(comparison: Comparison, chosen: Sequence[Event]) -> Drawing:
    """p and q of both engines at the chosen instants, the difference beneath."""
    columns = 3
    rows = -(-len(chosen) // columns)
    with canvas(10.5, 3.9 * rows + 0.3) as figure:
        outer = figure.add_gridspec(
            rows, columns, left=0.06, right=0.99, bottom=0.24 / rows, top=1 - 0.07 / rows, wspace=0.16, hspace=0.28
        )
        top: Axes | None = None
        below: Axes | None = None
        for place, event in enumerate(chosen):
            inner = outer[place // columns, place % columns].subgridspec(2, 1, height_ratios=(2.2, 1), hspace=0.09)
            top = figure.add_subplot(inner[0], sharex=top, sharey=top)
            below = figure.add_subplot(inner[1], sharex=top, sharey=below)
            _traction_panel(comparison, place + 1, event, top, below, first=place % columns == 0)
        figure.legend(handles=[line for axes in (top, below) if axes for line in axes.lines], loc="lower center", ncols=6)
    return Drawing(
        "tractions",
        "Pressure and shear traction",
        "Tractions in p_ref and f p_ref at instants of the last cycle; beneath each, result less reference in per cent "
        "of the same scales.",
        "Six panels of pressure and shear over x for both engines, each with the difference beneath.",
        figure,
        _traction_table(comparison, chosen),
    )


def _traction_panel(comparison: Comparison, number: int, event: Event, top: Axes, below: Axes, *, first: bool) -> None:
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    k, x = event.index, comparison.found.x / scales.half_width
    p0, p1 = expected.pressure[k] / scales.pressure, found.pressure[k] / scales.pressure
    q0, q1 = expected.shear[k] / scales.shear, found.shear[k] / scales.shear
    theirs, ours = name_of(comparison.reference.engine), name_of(comparison.result.engine)
    top.plot(x, p0, label=f"p, {theirs}", **BANDS[0])
    top.plot(x, q0, label=f"q, {theirs}", **BANDS[1])
    top.plot(x, p1, label=f"p, {ours}", **THIN[0])
    top.plot(x, q1, label=f"q, {ours}", **THIN[1])
    below.plot(x, 100 * (p1 - p0), "-", color=DIFFERENCE, lw=1.0, label="difference of p")
    below.plot(x, 100 * (q1 - q0), "--", color=DIFFERENCE, lw=1.0, label="difference of q")
    reach = 1.08 * np.nanmax(np.abs(expected.contact_edges)) / scales.half_width
    top.set_xlim(-reach, reach)
    top.tick_params(labelbottom=False, labelleft=first)
    below.tick_params(labelleft=first)
    label_axes(top, "", "p/p_ref,  q/(f p_ref)" if first else "", f"{number}  {event.label}, at {found.fraction[k]:.3f}")
    label_axes(below, _X, "difference, %" if first else "")


def _traction_table(comparison: Comparison, chosen: Sequence[Event]) -> Table:
    expected, found, scales = comparison.expected, comparison.found, comparison.scales
    rows = [event.index for event in chosen]
    points = len(found.x)
    return {
        "time": np.repeat(found.time[rows], points),
        "x": np.tile(found.x, len(rows)),
        "x/a_ref": np.tile(found.x / scales.half_width, len(rows)),
        "p_reference/p_ref": (expected.pressure[rows] / scales.pressure).ravel(),
        "p_result/p_ref": (found.pressure[rows] / scales.pressure).ravel(),
        "q_reference/(f p_ref)": (expected.shear[rows] / scales.shear).ravel(),
        "q_result/(f p_ref)": (found.shear[rows] / scales.shear).ravel(),
    }


def state_map(comparison: Comparison, time: Array, time_label: str) -> Drawing:
    """Open, stick, forward and reverse slip over x and time, for both engines and where they differ."""
    expected, found, length = comparison.expected, comparison.found, comparison.scales.half_width
    reach = 1.12 * np.nanmax(np.abs(expected.contact_edges))
    inside = np.flatnonzero(np.abs(found.x) <= reach)
    x_edges, t_edges = _cell_edges(found.x[inside] / length), _cell_edges(time)
    colours = ListedColormap([STATE_COLOURS[state] for state in SurfaceState])
    norm = BoundaryNorm(np.arange(-0.5, 4.5), 4)
    differs = (expected.state != found.state)[:, inside]
    codes = ", ".join(f"{int(state)} {name}" for state, name in STATE_NAMES.items())
    with canvas(10.5, 4.3) as figure:
        left, middle, right = figure.subplots(1, 3, sharex=True, sharey=True)
        figure.subplots_adjust(left=0.065, right=0.99, top=0.93, bottom=0.2, wspace=0.08)
        for axes, cycle, engine in ((left, expected, comparison.reference), (middle, found, comparison.result)):
            axes.pcolormesh(x_edges, t_edges, cycle.state[:, inside], cmap=colours, norm=norm, rasterized=True)
            label_axes(axes, _X, "", name_of(engine.engine))
        right.pcolormesh(x_edges, t_edges, differs, cmap=ListedColormap(["#ffffff", "#111111"]), vmin=0, vmax=1, rasterized=True)
        label_axes(right, _X, "", "where they differ (black)")
        left.set_ylabel(time_label)
        for axes in (left, middle, right):
            axes.grid(visible=False)
            axes.set_ylim(t_edges[0], t_edges[-1])
        patches = [Patch(fc=STATE_COLOURS[s], ec=QUIET, lw=0.5, label=STATE_NAMES[s]) for s in SurfaceState]
        figure.legend(handles=patches, loc="lower center", ncols=4)
    return Drawing(
        "state_map",
        "Stick and slip over x and time",
        "State of each surface point at each instant of the last cycle; time runs upwards.",
        "Two maps of open, stick, forward slip and reverse slip over x and time, one for each engine, and a third of "
        "their difference.",
        figure,
        {
            "time": np.repeat(found.time, len(inside)),
            "x": np.tile(found.x[inside], len(time)),
            f"state_reference ({codes})": expected.state[:, inside].ravel(),
            f"state_result ({codes})": found.state[:, inside].ravel(),
        },
    )


def _cell_edges(centres: Array) -> Array:
    """Edges of the cells around ascending `centres`, one more than these."""
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]])


def dissipation_density(comparison: Comparison) -> Drawing | None:
    """w(x) of the last cycle, both engines, the difference beneath; None where nothing is dissipated anywhere."""
    if not (np.any(comparison.expected.dissipation_density) or np.any(comparison.found.dissipation_density)):
        return None
    scales, x = comparison.scales, comparison.found.x / comparison.scales.half_width
    unit = scales.dissipation / scales.half_width
    theirs, ours = comparison.expected.dissipation_density / unit, comparison.found.dissipation_density / unit
    with canvas(10.5, 4.2) as figure:
        top, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.4, 1))
        figure.subplots_adjust(left=0.085, right=0.985, top=0.92, bottom=0.12, hspace=0.17)
        top.plot(x, theirs, label=name_of(comparison.reference.engine), **BANDS[0])
        top.plot(x, ours, label=name_of(comparison.result.engine), **THIN[0])
        legend_above(top)
        below.plot(x, ours - theirs, color=DIFFERENCE, lw=1.0)
        reach = 1.12 * np.nanmax(np.abs(comparison.expected.contact_edges)) / scales.half_width
        top.set_xlim(-reach, reach)
        label_axes(top, "", "w / (A f² P_ref²/a_ref)")
        label_axes(below, _X, "difference")
    return Drawing(
        "dissipation_density",
        "Dissipation, point by point",
        "Friction work per unit area in the last cycle.",
        "Dissipation density over x for both engines with the difference beneath.",
        figure,
        {
            "x": comparison.found.x,
            "x/a_ref": x,
            "w_reference/(A f^2 P_ref^2/a_ref)": theirs,
            "w_result/(A f^2 P_ref^2/a_ref)": ours,
        },
    )


def mesh(comparison: Comparison, bodies: Sequence[Any]) -> Drawing:
    """The meshes of the result's bodies, each in its own frame (y out of the body): whole, and at the contact."""
    half_width = comparison.scales.half_width
    with canvas(10.5, 5.0) as figure:
        whole, zoom = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.06, right=0.99, top=0.93, bottom=0.1, wspace=0.12)
        for axes, title in ((whole, "whole"), (zoom, "at the contact")):
            for body, colour, side in zip(bodies, (REFERENCE, RESULT), (1.0, -1.0), strict=True):
                axes.add_collection(
                    LineCollection(list(_sides(body.mesh) * (1.0, side) / half_width), colors=colour, lw=0.25, rasterized=True)
                )
            label_axes(axes, _X, "y / a_ref", title)
            axes.set_aspect("equal")
            axes.grid(visible=False)
        whole.autoscale_view()
        zoom.set_xlim(-1.6, 1.6)
        zoom.set_ylim(-1.6, 1.6)
    quality = {
        f"{name} {key}": value for name, body in zip(("lower", "upper"), bodies, strict=True) for key, value in body.quality.items()
    }
    return Drawing(
        "mesh",
        "Mesh",
        "Lower body blue, upper body orange; distances in a_ref.",
        "Finite-element meshes of both bodies, whole and at the contact.",
        figure,
        {"quantity": list(quality), "value": list(quality.values())},
    )


def _sides(mesh: Any) -> Array:
    """(n_sides, 2, 2) end points of the sides of a mesh's elements, each side once."""
    return np.asarray(mesh.p.T[mesh.facets.T])
