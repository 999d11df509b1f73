"""Pictures of von Mises' stress in both bodies at an instant: whole, drawn apart and deformed; at the contact, to true scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from reports.drawing import STATE_COLOURS, STATE_NAMES, canvas
from reports.panels import PIXELS, around, at_contact, boundary_lines, panels, show, title_of
from reports.rendering import Skin, picture
from reports.units import load_unit, number, units
from scenes import Scene, SurfaceState

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot

Array = NDArray[np.float64]

# The whole picture's colours span this many decades below the largest stress: it falls as 1/r away from the contact.
_DECADES = 2.5
# Largest displacement of the whole picture over the size of the bodies.
_SHOWN = 0.06


@dataclass(frozen=True)
class Look:
    """What all pictures of a run share: the largest stress of the colour scales, the factor on displacements of whole bodies."""

    largest: float
    factor: float


def look(snapshots: Sequence[Snapshot]) -> Look:
    """Scales that suit every snapshot of a run; without any load 1 and 1."""
    bodies = [body for snapshot in snapshots for body in snapshot.bodies]
    size = max(float(np.ptp(body.points, axis=0).max()) for body in bodies)
    moved = max(float(np.linalg.norm(body.displacement, axis=1).max()) for body in bodies)
    largest = max(float(body.von_mises.max()) for body in bodies)
    return Look(largest or 1.0, round_down(_SHOWN * size / moved) if moved else 1.0)


def stress_picture(solution: FiniteElementSolution, snapshot: Snapshot, label: str, shared: Look) -> Figure:
    """Von Mises' stress at an instant: whole bodies, drawn apart and deformed; and at the contact to true scale, with the mesh.

    Parameters
    ----------
    label : what happens at the instant
    """
    scene, largest = solution.scene, shared.largest
    with canvas(14.0, 7.9) as figure:
        moved, outlines = _drawn_apart(solution, snapshot, shared.factor)
        windows = (around([*moved, *outlines], 0.04), at_contact(1.75 * float(np.nanmax(solution.contact_half_width))))
        whole, zoom = panels(figure, windows, bottom=0.19, right=0.92, between=0.33)
        floor = largest * 10**-_DECADES
        skins = [
            Skin(
                points, body.cells, values=np.log10(np.maximum(body.von_mises, floor)), limits=(np.log10(floor), np.log10(largest))
            )
            for points, body in zip(moved, snapshot.bodies, strict=True)
        ]
        show(
            whole,
            picture(skins, windows[0], PIXELS),
            windows[0],
            scene,
            f"whole, displacements × {number(shared.factor)}, drawn apart",
        )
        whole.add_collection(LineCollection(outlines, colors="#555555", lw=0.8))
        whole.set_ylabel("")
        whole.set_yticks([])
        close = [
            Skin(_true_places(body, scene), body.cells, values=body.von_mises, limits=(0.0, largest), edges=0.22)
            for body in snapshot.bodies
        ]
        show(zoom, picture(close, windows[1], PIXELS), windows[1], scene, "at the contact, to true scale, with the mesh")
        _state_strip(zoom, solution, snapshot)
        _colour_bars((whole, zoom), floor, largest, units(scene)[2])
        figure.suptitle(
            f"{title_of(scene)}: von Mises stress at t = {number(snapshot.time)} ({label})\n"
            f"P = {number(snapshot.normal_load)} {load_unit(scene)}, Q = {number(snapshot.tangential_load)} {load_unit(scene)}",
            x=0.055,
            ha="left",
            fontsize=12,
        )
    return figure


def _drawn_apart(solution: FiniteElementSolution, snapshot: Snapshot, factor: float) -> tuple[list[Array], list[Array]]:
    """Deformed places of both bodies moved apart, and the undeformed outlines there.

    Magnified displacements let the bodies overlap where the gap is not magnified with them; hence apart.
    """
    size = max(float(np.ptp(body.points, axis=0).max()) for body in snapshot.bodies)
    moved, outlines = [], []
    for mesh, body in zip(solution.bodies, snapshot.bodies, strict=True):
        side = 1.0 if body.name == "lower" else -1.0
        apart = np.array([0.0, -side * (0.03 + _SHOWN) * size / 2])
        moved.append(body.points + factor * body.displacement + apart)
        outlines += [chain + apart for chains in boundary_lines(mesh, body, side).values() for chain in chains]
    return moved, outlines


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))


def _true_places(body: BodyFields, scene: Scene) -> Array:
    """Deformed places; the upper one of two flat faces raised by the profile, which is the gap between them."""
    places = body.points + body.displacement
    if body.name == "upper" and not scene.bodies.faces_are_true:
        places = places + np.column_stack([np.zeros(len(places)), scene.profile.height(body.points[:, 0])])
    return np.asarray(places)


def _state_strip(axes: Axes, solution: FiniteElementSolution, snapshot: Snapshot) -> None:
    """A strip along the top of the zoom that says where the surface sticks and slips."""
    step = int(np.argmin(np.abs(solution.time - snapshot.time)))
    window = axes.get_xlim()
    inside = (solution.x >= window[0]) & (solution.x <= window[1])
    x, states = solution.x[inside], solution.state[step][inside]
    middles = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    strip = axes.inset_axes((0.0, -0.15, 1.0, 0.03), facecolor=STATE_COLOURS[SurfaceState.OPEN])
    for state, colour in STATE_COLOURS.items():
        for k in np.flatnonzero(states == state):
            strip.axvspan(middles[k], middles[k + 1], color=colour, lw=0)
    strip.set_xlim(*window)
    strip.set_yticks([])
    strip.set_xticks([])
    for spine in strip.spines.values():
        spine.set_visible(True)
        spine.set_color("#888888")
    handles = [Patch(facecolor=STATE_COLOURS[state], edgecolor="#888888", label=STATE_NAMES[state]) for state in SurfaceState]
    strip.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.0, -0.1), ncols=4, fontsize=9, borderaxespad=0.2)
    strip.set_ylabel("surface", rotation=0, ha="right", va="center", fontsize=9)


def _colour_bars(panels: tuple[Axes, Axes], floor: float, largest: float, stress: str) -> None:
    """Beside each panel: logarithmic for the whole bodies, linear at the contact."""
    for axes, norm, extend in ((panels[0], LogNorm(floor, largest), "min"), (panels[1], Normalize(0, largest), "neither")):
        place = axes.inset_axes((1.02, 0.0, 0.03, 1.0))
        bar = axes.figure.colorbar(ScalarMappable(norm, mpl.colormaps["viridis"]), cax=place, extend=extend)
        bar.set_label(f"von Mises stress [{stress}]" + (", logarithmic" if extend == "min" else ""))
