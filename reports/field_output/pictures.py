"""Pictures of the bodies: their meshes with named boundaries, and von Mises' stress at chosen
instants.

Meshes are lines; stress is a picture that pyvista renders off screen, between axes that are drawn
like all others.
"""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import (
    STATE_KEYS,
    Axis,
    Bitmap,
    Block,
    Cell,
    Key,
    Mark,
    Panel,
    Plate,
    Segments,
    colour_scale,
)
from reports.comparison.words import SUPPORT_WORDS
from reports.field_output.files import NO_PEAK, Instant, peak
from reports.units import load_unit, minus, number, units
from scenes import InputError

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot
    from meshes import BodyMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Window = tuple[float, float, float, float]
"""The part of the plane that a picture shows: left, right, bottom, top [length]."""

BOUNDARIES = ("contact", "free", "sides", "base", "far_field")
# The whole picture's colours span this many decades below the largest stress: it falls as 1/r away
# from the contact.
_DECADES = 2.5
# Largest displacement of the whole picture over the size of the bodies.
_SHOWN = 0.06


@dataclass(frozen=True, eq=False)
class Skin:
    """A mesh to draw: places (n, 2), elements, nodal values (n,) with their limits, and how dark
    the sides of elements are.
    """

    points: Array
    cells: Indices
    values: Array
    limits: tuple[float, float] = (0.0, 1.0)
    colours: str = "viridis"
    edges: float = 0.0

    def grid(self) -> Any:
        """The mesh as pyvista.UnstructuredGrid with its values; elements of order 2 are those of
        VTK.
        """
        import pyvista
        from pyvista import CellType

        kinds = {
            3: CellType.TRIANGLE,
            6: CellType.QUADRATIC_TRIANGLE,
            4: CellType.QUAD,
            9: CellType.BIQUADRATIC_QUAD,
        }
        found = pyvista.UnstructuredGrid(
            {kinds[self.cells.shape[1]]: self.cells},
            np.column_stack([self.points, np.zeros(len(self.points))]),
        )
        found["value"] = self.values
        return found


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))


def picture(skins: Sequence[Skin], window: Window, width: int) -> NDArray[np.uint8]:
    """What `window` shows of the meshes, (height, width, 3) pixels; first drawn first.

    Raises
    ------
    InputError
        Where nothing can be drawn: pyvista or a library that it needs is missing.
    """
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        # else VTK complains that there is no X server
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    try:
        import pyvista
    except (ImportError, OSError) as reason:
        raise InputError(
            f"pictures can't be drawn: {reason}; `halfplane doctor` says what is missing"
        ) from reason

    left, right, bottom, top = window
    height = top - bottom
    pixels = [width, max(round(width * height / (right - left)), 2)]
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=pixels, lighting="none")
    try:
        plotter.set_background("white")
        for k, skin in enumerate(skins):
            depth = 1e-3 * k * height
            mesh = skin.grid().translate((0, 0, depth), inplace=False)
            plotter.add_mesh(
                mesh,
                scalars="value",
                cmap=skin.colours,
                clim=skin.limits,
                show_scalar_bar=False,
                lighting=False,
            )
            if skin.edges:
                lines = mesh.extract_all_edges().translate(
                    (0, 0, 1e-3 * (depth or 1.0)), inplace=False
                )
                plotter.add_mesh(
                    lines, color="black", line_width=1, opacity=skin.edges, lighting=False
                )
        x, y = (left + right) / 2, (bottom + top) / 2
        camera = plotter.camera
        camera.parallel_projection = True
        camera.focal_point, camera.position, camera.up = (
            (x, y, 0.0),
            (x, y, 10 * height),
            (0.0, 1.0, 0.0),
        )
        camera.parallel_scale = height / 2
        plotter.reset_camera_clipping_range()
        return np.asarray(plotter.screenshot(None, return_img=True), dtype=np.uint8)
    finally:
        plotter.close()


def rendered(
    name: str,
    window: Window,
    skins: Sequence[Skin],
    pixels: int,
    over: Sequence[Mark] = (),
    length: str = "",
    title: str = "",
    note: str = "",
    alt: str = "Von Mises stress",
    size: tuple[float, float] = (440.0, 460.0),
) -> Panel:
    """What pyvista draws of the window, widened to a panel of that size, between axes in `length`;
    marks `over` it.
    """
    marks: list[Mark] = []
    axes = Axis(*window[:2], f"x  [{length}]"), Axis(*window[2:], f"y  [{length}]")
    notes = [note] if note else []
    panel = Panel(
        name, *axes, marks, f"{alt}, {title}", *size, title=title, notes=notes, equal=True
    )
    shown = panel.frame
    marks += [
        Bitmap(picture(skins, (shown.x.low, shown.x.high, shown.y.low, shown.y.high), pixels)),
        *over,
    ]
    return panel


def mesh(
    bodies: Sequence[BodyMesh], half_width: float, edge: float, *, named: bool = False
) -> Plate:
    """The meshes of both bodies, y out of the lower one: whole, at the contact, at its edge.

    Parameters
    ----------
    half_width
        a_ref, the unit of both axes [length]
    edge
        half-width of the largest contact [length]
    named
        whether boundaries have colours and stand in the legend
    """
    pairs = list(zip(("lower", "upper"), (1.0, -1.0), bodies, strict=True))
    sides = {
        name: np.asarray(body.mesh.p.T[body.mesh.facets.T]) * (1.0, flip) / half_width
        for name, flip, body in pairs
    }
    everything = np.concatenate([lines.reshape(-1, 2) for lines in sides.values()])
    low, high = everything.min(axis=0), everything.max(axis=0)
    edge = edge / half_width if np.isfinite(edge) else 1.0
    views = (
        ("whole", (low + high) / 2, 0.54 * float(max(high - low))),
        ("at the contact", np.zeros(2), 1.35 * max(edge, 1.0)),
        ("at the contact's edge", np.array([edge, 0.0]), 0.06),
    )
    keys = [Key("mesh-lower", "lower body"), Key("mesh-upper", "upper body")]
    boundaries: list[Mark] = []
    for name in BOUNDARIES if named else ():
        having = [(flip, body) for _, flip, body in pairs if name in body.mesh.boundaries]
        boundaries += [
            Segments(_boundary(body, name, flip) / half_width, f"curve side-{name}")
            for flip, body in having
        ]
        if having:
            keys.append(
                Key(
                    f"side-{name}",
                    f"{name.replace('_', ' ')}{_held([body for _, body in having], name)}",
                )
            )
    panels = []
    for k, (words, centre, half) in enumerate(views):
        (left, bottom), (right, top) = (centre - half).tolist(), (centre + half).tolist()
        marks: list[Mark] = [
            Segments(sides[name], f"mesh-{name}", f"mesh-{name}{' again' if k else ''}")
            for name in sides
        ]
        axes = Axis(left, right, "x / a_ref"), Axis(bottom, top, "y / a_ref")
        marks += [] if k else boundaries
        panels.append(
            Panel(f"mesh-{k}", *axes, marks, f"Mesh, {words}", 340.0, 340.0, words, equal=True)
        )
    quality = {
        f"{name} {key}": value for name, _, body in pairs for key, value in body.quality.items()
    }
    return Plate(
        "mesh",
        "Mesh",
        "Distances in a_ref. Sides of curved elements are drawn straight.",
        "Finite-element meshes of both bodies: whole, at the contact, and at the edge of the"
        " largest contact.",
        tuple(panels),
        {"quantity": list(quality), "value": list(quality.values())},
        tuple(keys),
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
    words = list(
        dict.fromkeys(SUPPORT_WORDS.get(body.supports.get(boundary, ""), "free") for body in bodies)
    )
    return f" ({words[0]})" if len(words) == 1 else f" (lower {words[0]}, upper {words[1]})"


def scales_of(snapshots: Sequence[Snapshot]) -> tuple[float, float]:
    """What all pictures of a run share: largest von Mises stress, and factor on the displacements
    of whole bodies.
    """
    bodies = [body for snapshot in snapshots for body in snapshot.bodies]
    size = max(float(np.ptp(body.points, axis=0).max()) for body in bodies)
    moved = max(float(np.linalg.norm(body.displacement, axis=1).max()) for body in bodies)
    largest = max(float(body.von_mises.max()) for body in bodies)
    return largest or 1.0, round_down(_SHOWN * size / moved) if moved else 1.0


def stress(
    solution: FiniteElementSolution,
    snapshots: Sequence[Snapshot],
    instants: Sequence[Instant],
    scales: tuple[float, float],
    name: str = "von_mises",
    pixels: int = 560,
) -> Plate:
    """Von Mises' stress at instants: whole bodies, drawn apart and deformed; and at the contact to
    true scale, with the mesh.

    Parameters
    ----------
    scales
        of the run, from `scales_of`
    pixels
        width of each picture
    """
    _, length, unit = units(solution.scene)
    peaks = [peak(snapshot) for snapshot in snapshots]
    cells: list[Cell] = []
    for k, (instant, snapshot) in enumerate(zip(instants, snapshots, strict=True)):
        cells.append(_whole(solution, snapshot, instant.label, scales, f"{name}-{k}-whole", pixels))
        cells.append(_at_the_contact(solution, snapshot, scales[0], f"{name}-{k}", pixels))
    return Plate(
        name,
        "Von Mises stress",
        "Left: both bodies, drawn apart, displacements exaggerated by the factor stated. Right:"
        f" the contact to true scale, and the state of its points. {NO_PEAK}",
        "Von Mises stress in both bodies at the instants asked for.",
        tuple(cells),
        {
            "instant": [instant.label for instant in instants],
            "time": [snapshot.time for snapshot in snapshots],
            f"largest nodal value [{unit}]": [one["value"] for one in peaks],
            "body": [one["body"] for one in peaks],
            f"x [{length}]": [one["x"] for one in peaks],
            f"y [{length}]": [one["y"] for one in peaks],
        },
        STATE_KEYS,
    )


def _whole(
    solution: FiniteElementSolution,
    snapshot: Snapshot,
    label: str,
    scales: tuple[float, float],
    name: str,
    pixels: int,
) -> Cell:
    """Both bodies, with the outlines of the undeformed ones; the colours beneath."""
    (largest, factor), (_, length, unit) = scales, units(solution.scene)
    floor = largest * 10**-_DECADES
    limits = float(np.log10(floor)), float(np.log10(largest))
    size = max(float(np.ptp(body.points, axis=0).max()) for body in snapshot.bodies)
    skins, ends = [], []
    for body_mesh, body in zip(solution.bodies, snapshot.bodies, strict=True):
        # Magnified displacements let the bodies overlap where the gap is not magnified with them;
        # hence apart.
        side = 1.0 if body.name == "lower" else -1.0
        apart = np.array([0.0, -side * (0.03 + _SHOWN) * size / 2])
        values = np.log10(np.maximum(body.von_mises, floor))
        skins.append(
            Skin(body.points + factor * body.displacement + apart, body.cells, values, limits)
        )
        ends += [
            _boundary(body_mesh, boundary, side) + apart for boundary in body_mesh.mesh.boundaries
        ]
    points = np.concatenate(
        [*(skin.points for skin in skins), *(lines.reshape(-1, 2) for lines in ends)]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    (left, bottom), (right, top) = (
        (low - 0.04 * (high - low)).tolist(),
        (high + 0.04 * (high - low)).tolist(),
    )
    loads = (
        f"P = {number(snapshot.normal_load)}, Q = {number(snapshot.tangential_load)}"
        f" {load_unit(solution.scene)}"
    )
    note = f"{loads}; displacements × {number(factor)}, drawn apart"
    over, title = (
        [Segments(np.concatenate(ends), "curve undeformed")],
        f"t = {number(snapshot.time)}, {label}",
    )
    panel = rendered(name, (left, right, bottom, top), skins, pixels, over, length, title, note)
    words = f"von Mises stress  [{unit}], logarithmic"
    return Cell(
        (panel, colour_scale(f"{name}-colours", floor, largest, words, log=True, width=440.0)), None
    )


def outermost(solution: FiniteElementSolution) -> float:
    """Half-width of the largest contact; of one that tilt moves, the largest |x| of its edges
    [length].
    """
    return float(
        np.nanmax(
            solution.contact_half_width if solution.tilt is None else np.abs(solution.contact_edges)
        )
    )


def _at_the_contact(
    solution: FiniteElementSolution, snapshot: Snapshot, largest: float, name: str, pixels: int
) -> Cell:
    """The contact to true scale with the mesh, the state of its points and the colours beneath."""
    _, length, unit = units(solution.scene)
    half, found = 1.75 * outermost(solution), peak(snapshot)
    skins = []
    for body in snapshot.bodies:
        places = body.points + body.displacement + np.outer(gap_share(solution, body), (0.0, 1.0))
        skins.append(Skin(places, body.cells, body.von_mises, (0.0, largest), edges=0.22))
    note = minus(f"largest nodal value {found['value']:.4g} {unit}, {found['body']} body")
    window, title = (-half, half, -half, half), "at the contact, to true scale"
    panel = rendered(f"{name}-contact", window, skins, pixels, (), length, title, note)
    step = int(np.argmin(np.abs(solution.time - snapshot.time)))
    marks = [
        *state_blocks(solution, step, half, 0.0, 1.0),
        Block((-half, half), (0.0, 1.0), "outline"),
    ]
    axes, room = (Axis(-half, half, ""), Axis(0.0, 1.0, "")), (72.0, 2.0, 20.0, 2.0)
    strip = Panel(
        f"{name}-states",
        *axes,
        marks,
        "Open, stick and slip along the contact",
        440.0,
        20.0,
        bare=True,
        room=room,
    )
    colours = colour_scale(
        f"{name}-contact-colours", 0.0, largest, f"von Mises stress  [{unit}]", width=440.0
    )
    return Cell((panel, strip, colours), None)


def gap_share(solution: FiniteElementSolution, body: BodyFields) -> Array:
    """(n,) rise of the nodes of flat faces whose gap is the profile: h(x) on the upper body, else 0
    [length].
    """
    if body.name == "lower" or solution.scene.bodies.faces_are_true:
        return np.zeros(len(body.points))
    return np.asarray(solution.scene.profile.height(body.points[:, 0]))


def state_blocks(
    solution: FiniteElementSolution, step: int, half: float, low: float, high: float
) -> list[Block]:
    """A strip from `low` to `high` with the states of the points |x| <= half at a step; neighbours
    of one state are one block.
    """
    inside = np.abs(solution.x) <= half
    x, states = solution.x[inside], solution.state[step][inside]
    middles = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    turns = [0, *(np.flatnonzero(np.diff(states)) + 1).tolist(), len(states)]
    return [
        Block((float(middles[a]), float(middles[b])), (low, high), f"state-{states[a]}")
        for a, b in itertools.pairwise(turns)
    ]
