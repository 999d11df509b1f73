"""The bodies of a finite-element result: their meshes with named boundaries, and von Mises' stress at chosen instants.

Meshes are lines; stress is a picture that pyvista renders, between axes that are drawn like all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Axis, Bitmap, Block, Mark, Segments
from reports.charts.plate import Cell, Key, Panel, Plate, colour_scale
from reports.comparison.words import SUPPORT_WORDS
from reports.fields import NO_PEAK, Instant, peak
from reports.figures_fields import STATE_KEYS
from reports.rendering import Skin, Window, picture, round_down
from reports.units import load_unit, minus, number, units

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot
    from meshes import BodyMesh

Array = NDArray[np.float64]
BOUNDARIES = ("contact", "free", "sides", "base", "far_field")
# The whole picture's colours span this many decades below the largest stress: it falls as 1/r away from the contact.
_DECADES = 2.5
# Largest displacement of the whole picture over the size of the bodies.
_SHOWN = 0.06


def mesh(bodies: Sequence[BodyMesh], half_width: float, edge: float, *, named: bool = False) -> Plate:
    """The meshes of both bodies, y out of the lower one: whole, at the contact, at its edge.

    Parameters
    ----------
    half_width : a_ref, the unit of both axes [length]; edge : half-width of the largest contact [length]
    named : whether boundaries have colours and stand in the legend
    """
    names, flips = ("lower", "upper"), (1.0, -1.0)
    sides = {
        name: np.asarray(body.mesh.p.T[body.mesh.facets.T]) * (1.0, flip) / half_width
        for name, flip, body in zip(names, flips, bodies, strict=True)
    }
    everything = np.concatenate([lines.reshape(-1, 2) for lines in sides.values()])
    low, high = everything.min(axis=0), everything.max(axis=0)
    edge = edge / half_width if np.isfinite(edge) else 1.0
    views = (
        ("whole", (low + high) / 2, 0.54 * float(max(high - low))),
        ("at the contact", np.zeros(2), 1.35 * max(edge, 1.0)),
        ("at the contact's edge", np.array([edge, 0.0]), 0.06),
    )
    found = {name: [body for body in bodies if name in body.mesh.boundaries] for name in (BOUNDARIES if named else ())}
    boundaries = [
        Segments(_boundary(body, name, flip) / half_width, f"curve side-{name}")
        for name, having in found.items()
        for body, flip in zip(bodies, flips, strict=True)
        if body in having
    ]
    panels = []
    for k, (words, centre, half) in enumerate(views):
        (left, bottom), (right, top) = (centre - half).tolist(), (centre + half).tolist()
        marks: list[Mark] = [Segments(sides[name], f"mesh-{name}", f"mesh-{name}{' again' if k else ''}") for name in names]
        axes = Axis(left, right, "x / a_ref"), Axis(bottom, top, "y / a_ref")
        panels.append(
            Panel(f"mesh-{k}", *axes, [*marks, *([] if k else boundaries)], f"Mesh, {words}", 340.0, 340.0, words, equal=True)
        )
    quality = {f"{name} {key}": value for name, body in zip(names, bodies, strict=True) for key, value in body.quality.items()}
    return Plate(
        "mesh",
        "Mesh",
        "Distances in a_ref. Sides of curved elements are drawn straight.",
        "Finite-element meshes of both bodies: whole, at the contact, and at the edge of the largest contact.",
        tuple(panels),
        {"quantity": list(quality), "value": list(quality.values())},
        (
            Key("mesh-lower", "lower body"),
            Key("mesh-upper", "upper body"),
            *(Key(f"side-{name}", f"{name.replace('_', ' ')}{_held(having, name)}") for name, having in found.items() if having),
        ),
        columns=3,
    )


def _boundary(body: BodyMesh, name: str, flip: float) -> Array:
    """(n, 2, 2) end points of a boundary's sides; the upper body reflected."""
    facets = body.mesh.facets[:, body.mesh.boundaries[name]]
    return np.asarray(body.mesh.p.T[facets.T]) * (1.0, flip)


def _held(bodies: Sequence[BodyMesh], boundary: str) -> str:
    """How the boundary of these bodies is held, in words."""
    if boundary in ("contact", "free"):
        return " (may touch)" if boundary == "contact" else ""
    words = list(dict.fromkeys(SUPPORT_WORDS.get(body.supports.get(boundary, ""), "free") for body in bodies))
    return f" ({words[0]})" if len(words) == 1 else f" (lower {words[0]}, upper {words[1]})"


# --------------------------------------------------------------------------------------------------------------------- stress
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


def stress(
    solution: FiniteElementSolution,
    snapshots: Sequence[Snapshot],
    instants: Sequence[Instant],
    shared: Look,
    name: str = "von_mises",
    pixels: int = 560,
) -> Plate:
    """Von Mises' stress at instants: whole bodies, drawn apart and deformed; and at the contact to true scale, with the mesh.

    Parameters
    ----------
    pixels : width of each picture
    """
    _, length, unit = units(solution.scene)
    peaks = [peak(snapshot) for snapshot in snapshots]
    stacks = [
        stack
        for k, (instant, snapshot) in enumerate(zip(instants, snapshots, strict=True))
        for stack in _at_instant(solution, snapshot, instant.label, shared, f"{name}-{k}", pixels)
    ]
    return Plate(
        name,
        "Von Mises stress",
        "Left: both bodies, drawn apart, displacements exaggerated by the factor stated. Right: the contact to true "
        f"scale, and the state of its points. {NO_PEAK}",
        "Von Mises stress in both bodies at the instants asked for.",
        tuple(stacks),
        {
            "instant": [instant.label for instant in instants],
            "time": [snapshot.time for snapshot in snapshots],
            f"largest nodal value [{unit}]": [one.value for one in peaks],
            "body": [one.body for one in peaks],
            f"x [{length}]": [one.place[0] for one in peaks],
            f"y [{length}]": [one.place[1] for one in peaks],
        },
        STATE_KEYS,
    )


def _at_instant(
    solution: FiniteElementSolution, snapshot: Snapshot, label: str, shared: Look, name: str, pixels: int
) -> tuple[Cell, Cell]:
    """The two pictures, each with its colours beneath."""
    scene, largest, floor = solution.scene, shared.largest, shared.largest * 10**-_DECADES
    _, length, unit = units(scene)
    size = max(float(np.ptp(body.points, axis=0).max()) for body in snapshot.bodies)
    moved, ends = [], []
    for mesh_of, body in zip(solution.bodies, snapshot.bodies, strict=True):
        # Magnified displacements let the bodies overlap where the gap is not magnified with them; hence apart.
        side = 1.0 if body.name == "lower" else -1.0
        apart = np.array([0.0, -side * (0.03 + _SHOWN) * size / 2])
        moved.append(body.points + shared.factor * body.displacement + apart)
        ends.append(np.concatenate([_boundary(mesh_of, boundary, side) for boundary in mesh_of.mesh.boundaries]) + apart)
    points = np.concatenate([*moved, *(lines.reshape(-1, 2) for lines in ends)])
    low, high = points.min(axis=0), points.max(axis=0)
    (left, bottom), (right, top) = (low - 0.04 * (high - low)).tolist(), (high + 0.04 * (high - low)).tolist()
    loads = f"P = {number(snapshot.normal_load)}, Q = {number(snapshot.tangential_load)} {load_unit(scene)}"
    whole = _rendered(
        f"{name}-whole", (left, right, bottom, top), length, f"t = {number(snapshot.time)}, {label}",
        f"{loads}; displacements × {number(shared.factor)}, drawn apart",
        [Skin(p, b.cells, values=np.log10(np.maximum(b.von_mises, floor)), limits=(np.log10(floor), np.log10(largest)))
         for p, b in zip(moved, snapshot.bodies, strict=True)],
        pixels, [Segments(np.concatenate(ends), "curve undeformed")],
    )  # fmt: skip
    half = 1.75 * float(np.nanmax(solution.contact_half_width))
    found = peak(snapshot)
    zoom = _rendered(
        f"{name}-contact", (-half, half, -half, half), length, "at the contact, to true scale",
        minus(f"largest nodal value {found.value:.4g} {unit}, {found.body} body"),
        [Skin(_true_places(b, scene), b.cells, values=b.von_mises, limits=(0.0, largest), edges=0.22) for b in snapshot.bodies],
        pixels, [],
    )  # fmt: skip
    step = int(np.argmin(np.abs(solution.time - snapshot.time)))
    inside = np.abs(solution.x) <= half
    x, states = solution.x[inside], solution.state[step][inside]
    middles = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    turns = [0, *(np.flatnonzero(np.diff(states)) + 1).tolist(), len(states)]
    blocks = [Block((float(middles[a]), float(middles[b])), (0.0, 1.0), f"state-{states[a]}") for a, b in pairwise(turns)]
    strip = Panel(
        f"{name}-states", Axis(-half, half, ""), Axis(0.0, 1.0, ""), [*blocks, Block((-half, half), (0.0, 1.0), "outline")],
        "Open, stick and slip along the contact", 440.0, 20.0, bare=True, room=(72.0, 2.0, 20.0, 2.0),
    )  # fmt: skip
    words = f"von Mises stress  [{unit}]"
    return (
        Cell((whole, colour_scale(f"{name}-whole-colours", floor, largest, f"{words}, logarithmic", log=True, width=440.0)), None),
        Cell((zoom, strip, colour_scale(f"{name}-contact-colours", 0.0, largest, words, width=440.0)), None),
    )


def _rendered(
    name: str, window: tuple[float, float, float, float], length: str, title: str, note: str, skins: Sequence[Skin], pixels: int,
    over: Sequence[Mark],
) -> Panel:  # fmt: skip
    """What pyvista draws of the window (left, right, bottom, top; widened to the panel), with axes."""
    marks: list[Mark] = []
    axes = Axis(*window[:2], f"x  [{length}]"), Axis(*window[2:], f"y  [{length}]")
    panel = Panel(name, *axes, marks, f"Von Mises stress, {title}", 440.0, 460.0, title, [note], equal=True)
    shown = panel.frame
    image = picture(skins, Window(shown.x.low, shown.x.high, shown.y.low, shown.y.high), pixels)
    marks += [Bitmap(image), *over]
    return panel


def _true_places(body: BodyFields, scene: Any) -> Array:
    """Deformed places; the upper one of two flat faces raised by the profile, which is the gap between them."""
    places = body.points + body.displacement
    if body.name == "upper" and not scene.bodies.faces_are_true:
        places = places + np.column_stack([np.zeros(len(places)), scene.profile.height(body.points[:, 0])])
    return np.asarray(places)
