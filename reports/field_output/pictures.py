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
from typing import TYPE_CHECKING, Any, NamedTuple

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
from scenes.array_types import Array

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot
    from meshes import BodyMesh

Indices = NDArray[np.int64]
Window = tuple[float, float, float, float]
"""The part of the plane that a picture shows: left, right, bottom, top [length]."""

# Boundaries of a meshed body, by their names in the mesh.
BOUNDARIES = ("contact", "free", "sides", "base", "far_field")
# Decades below the largest stress that the colours of whole bodies span: stress falls as 1/r away
# from the contact.
_DECADES_OF_COLOURS = 2.5
# Largest displacement in the picture of whole bodies, over the size of the bodies.
_SHOWN_DISPLACEMENT = 0.06


@dataclass(frozen=True, eq=False)
class Skin:
    """A mesh to draw, coloured by a value at its nodes."""

    points: Array  # (n, 2)
    cells: Indices  # (n_cells, nodes per cell)
    values: Array  # (n,)
    limits: tuple[float, float] = (0.0, 1.0)  # values at the ends of the scale of colours
    colours: str = "viridis"  # name of a scale of colours of pyvista
    opacity_of_lines: float = 0.0  # of the lines between elements; 0: no lines

    def grid(self) -> Any:
        """The mesh with its nodal values as a grid of pyvista, to be rendered. Its elements have 3,
        4, 6 or 9 nodes in the order of VTK. `points` (n, 2) are the nodes, `cells` the nodes of
        each element, (n_cells, nodes per cell).
        """
        import pyvista
        from pyvista import CellType

        cell_types = {
            3: CellType.TRIANGLE,
            6: CellType.QUADRATIC_TRIANGLE,
            4: CellType.QUAD,
            9: CellType.BIQUADRATIC_QUAD,
        }
        nodes_per_cell = self.cells.shape[1]
        points_in_space = np.column_stack([self.points, np.zeros(len(self.points))])
        grid = pyvista.UnstructuredGrid({cell_types[nodes_per_cell]: self.cells}, points_in_space)
        grid["value"] = self.values
        return grid


class PanelWords(NamedTuple):
    """Texts of a rendered panel."""

    length_unit: str = ""
    title: str = ""
    note: str = ""
    alt: str = "Von Mises stress"  # description for readers who can't see the picture


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power_of_ten = 10.0 ** np.floor(np.log10(value))
    return float(
        max(
            leading_digit * power_of_ten
            for leading_digit in (1, 2, 5)
            if leading_digit * power_of_ten <= value * (1 + 1e-9)
        )
    )


def picture(skins: Sequence[Skin], window: Window, width: int) -> NDArray[np.uint8]:
    """A picture of meshes in the `window` (left, right, bottom, top) [length], rendered off-screen.
    Returns its pixels (height, width, 3).

    Parameters
    ----------
    skins
        the meshes, each with a value at its nodes, the scale of colours of these values, the
        values at its ends (`limits`), and how opaque the lines between elements are (0: none); a
        mesh is drawn over those before it
    width
        of the picture [pixels]

    Raises
    ------
    InputError
        Where nothing can be drawn: pyvista or a library that it needs is missing.
    """
    pyvista = _pyvista_without_screen()

    # a square pixel; colours without light and shadow
    left_x, right_x, bottom_y, top_y = window
    window_height = top_y - bottom_y
    pixel_height = max(round(width * window_height / (right_x - left_x)), 2)
    plotter: Any = pyvista.Plotter(
        off_screen=True, window_size=[width, pixel_height], lighting="none"
    )
    try:
        plotter.set_background("white")
        for skin_number, skin in enumerate(skins):
            _add_skin(plotter, skin, skin_number, window_height)
        _look_straight_at(plotter, window)
        return np.asarray(plotter.screenshot(None, return_img=True), dtype=np.uint8)
    finally:
        plotter.close()


def _pyvista_without_screen() -> Any:
    """The module pyvista, set to render where there is no screen. InputError where it or a library
    that it needs is missing.
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
    return pyvista


def _add_skin(plotter: Any, skin: Skin, skin_number: int, window_height: float) -> None:
    """Add a coloured mesh to a pyvista `plotter`, and the lines between its elements where they are
    not fully transparent. Meshes of a higher `skin_number` lie nearer to the camera, by a
    thousandth of the height of the picture [length].

    `skin` is the mesh with a value at each node, which gives the colour. `window_height` is the
    height of the picture [length].
    """
    z_of_skin = 1e-3 * skin_number * window_height
    mesh = skin.grid().translate((0, 0, z_of_skin), inplace=False)
    plotter.add_mesh(
        mesh,
        scalars="value",
        cmap=skin.colours,
        clim=skin.limits,
        show_scalar_bar=False,
        lighting=False,
    )
    if skin.opacity_of_lines:
        z_of_lines = 1e-4 * window_height  # above their skin, below the next
        lines = mesh.extract_all_edges().translate((0, 0, z_of_lines), inplace=False)
        plotter.add_mesh(
            lines,
            color="black",
            line_width=1,
            opacity=skin.opacity_of_lines,
            lighting=False,
        )


def _look_straight_at(plotter: Any, window: Window) -> None:
    """Point the camera of a pyvista `plotter` along −z at the middle of a window (left, right,
    bottom, top) [length], without perspective, so that its height fills the picture.
    """
    left_x, right_x, bottom_y, top_y = window
    window_height = top_y - bottom_y
    x = (left_x + right_x) / 2
    y = (bottom_y + top_y) / 2
    camera = plotter.camera
    camera.parallel_projection = True
    camera.focal_point = (x, y, 0.0)
    camera.position = (x, y, 10 * window_height)
    camera.up = (0.0, 1.0, 0.0)
    camera.parallel_scale = window_height / 2
    plotter.reset_camera_clipping_range()


def rendered(
    name: str,
    window: Window,
    skins: Sequence[Skin],
    pixels: int,
    words: PanelWords,
    marks_over: Sequence[Mark] = (),
    size: tuple[float, float] = (440.0, 460.0),
) -> Panel:
    """A panel that shows meshes as a rendered picture with axes, and marks over the picture.

    Parameters
    ----------
    name
        of the panel, used once on a page
    window
        left, right, bottom and top of the part of the plane that is shown [length]. It is widened
        to the shape of the panel, since a unit has the same length along both axes
    skins
        the meshes with the values that colour them
    pixels
        width of the picture [pixels]
    words
        unit of length, title, note and description
    marks_over
        marks that are drawn over the picture
    size
        width and height of the panel [units of the drawing]
    """
    left_x, right_x, bottom_y, top_y = window
    x_axis = Axis(left_x, right_x, f"x  [{words.length_unit}]")
    y_axis = Axis(bottom_y, top_y, f"y  [{words.length_unit}]")
    marks: list[Mark] = []  # filled below, once the panel has set its scales
    width, height = size
    panel = Panel(
        name,
        x_axis,
        y_axis,
        marks,
        f"{words.alt}, {words.title}",
        width,
        height,
        title=words.title,
        notes=[words.note] if words.note else [],
        has_equal_scales=True,
    )
    # the part of the plane that the panel shows, with its equal scales
    x_scale = panel.frame.x
    y_scale = panel.frame.y
    drawn_window = (x_scale.low, x_scale.high, y_scale.low, y_scale.high)
    marks.append(Bitmap(picture(skins, drawn_window, pixels)))
    marks += marks_over
    return panel


class _View(NamedTuple):
    """A square part of the plane that a panel of the mesh shows, lengths over a_ref."""

    words: str  # title of the panel
    centre: Array  # (2,) x and y
    half_size: float  # half of the side of the square


def mesh(
    bodies: Sequence[BodyMesh],
    half_width: float,
    contact_edge: float,
    *,
    with_boundaries: bool = False,
) -> Plate:
    """A figure of the finite-element meshes of both bodies in three panels: whole bodies, the
    contact, and an edge of the contact. y points out of the lower body. The figure's table has
    measures of the quality of both meshes.

    Parameters
    ----------
    bodies
        the lower and the upper body, each meshed in its own frame with y out of the body:
        `mesh` has the places of its nodes `p` (2, n) and both nodes of each element side, `facets`
        (2, k); `quality` has measures of the mesh by name
    half_width
        a_ref, the unit of both axes [length]
    contact_edge
        x of the edge of the largest contact [length]; a_ref is taken where it is NaN
    with_boundaries
        whether boundaries, such as contact and base, are drawn in colours and explained in the
        legend
    """
    # the legend, and the boundaries
    # Key: an entry of the legend, its look and text
    legend_entries = [Key("mesh-lower", "lower body"), Key("mesh-upper", "upper body")]
    boundaries: list[Mark] = []
    if with_boundaries:
        boundaries, entries_of_boundaries = _marks_of_boundaries(bodies, half_width)
        legend_entries += entries_of_boundaries

    # a panel for each view; the boundaries are drawn on the first
    sides_by_body = _sides_of_elements(bodies, half_width)
    contact_edge_over_a = contact_edge / half_width if np.isfinite(contact_edge) else 1.0
    views = _views_of_mesh(list(sides_by_body.values()), contact_edge_over_a)
    panels = [
        _panel_of_mesh(view, view_number, sides_by_body, boundaries if view_number == 0 else ())
        for view_number, view in enumerate(views)
    ]
    quality = {
        f"{body_name} {quantity}": value
        for body_name, body in zip(("lower", "upper"), bodies, strict=True)
        for quantity, value in body.quality.items()
    }
    # Plate: name, title, caption, description, panels, CSV table and legend
    return Plate(
        "mesh",
        "Mesh",
        "Distances in a_ref. Sides of curved elements are drawn straight.",
        "Finite-element meshes of both bodies: whole, at the contact, and at the edge of the"
        " largest contact.",
        tuple(panels),
        {"quantity": list(quality), "value": list(quality.values())},
        tuple(legend_entries),
        n_columns=3,
    )


def _sides_of_elements(bodies: Sequence[BodyMesh], half_width: float) -> dict[str, Array]:
    """Ends of the element sides of the lower and the upper body over a_ref, (n, 2, 2), by "lower"
    and "upper", in one frame: the upper body is turned over. `half_width` is a_ref [length].
    """
    sides_by_body: dict[str, Array] = {}
    signs_of_y = (1.0, -1.0)
    for body_name, sign_of_y, body in zip(("lower", "upper"), signs_of_y, bodies, strict=True):
        ends_of_sides = np.asarray(body.mesh.p.T[body.mesh.facets.T])
        sides_by_body[body_name] = ends_of_sides * (1.0, sign_of_y) / half_width
    return sides_by_body


def _views_of_mesh(sides: Sequence[Array], contact_edge_over_a: float) -> tuple[_View, ...]:
    """The three parts of the plane that the figure of the mesh shows: whole bodies, the contact,
    and its right edge, at x/a_ref = `contact_edge_over_a`. `sides` are the ends of the element
    sides of each body over a_ref, (n, 2, 2).
    """
    points = np.concatenate([sides_of_body.reshape(-1, 2) for sides_of_body in sides])
    least_corner = points.min(axis=0)
    largest_corner = points.max(axis=0)
    return (
        _View(
            "whole",
            (least_corner + largest_corner) / 2,
            0.54 * float(max(largest_corner - least_corner)),
        ),
        _View("at the contact", np.zeros(2), 1.35 * max(contact_edge_over_a, 1.0)),
        _View("at the contact's edge", np.array([contact_edge_over_a, 0.0]), 0.06),
    )


def _panel_of_mesh(
    view: _View,
    view_number: int,
    sides_by_body: dict[str, Array],
    boundaries: Sequence[Mark],
) -> Panel:
    """A panel with the element sides of both bodies in one view, and the marks of `boundaries` over
    them. `sides_by_body`: name of the body -> ends of its element sides over a_ref, (n, 2, 2). A
    page holds these lines once, in the view of number 0; further views refer to them.

    `view` is the part of the plane that is shown.
    """
    left_x, bottom_y = (view.centre - view.half_size).tolist()
    right_x, top_y = (view.centre + view.half_size).tolist()
    is_repeated = view_number > 0
    # Segments: lines, their look and name, whether the page has them already
    marks: list[Mark] = [
        Segments(sides_of_body, f"mesh-{body_name}", f"mesh-{body_name}", is_repeated)
        for body_name, sides_of_body in sides_by_body.items()
    ]
    marks += boundaries
    # Panel: name, both axes, marks, description, width, height and title
    return Panel(
        f"mesh-{view_number}",
        Axis(left_x, right_x, "x / a_ref"),
        Axis(bottom_y, top_y, "y / a_ref"),
        marks,
        f"Mesh, {view.words}",
        340.0,
        340.0,
        view.words,
        has_equal_scales=True,
    )


def _sides_of_boundary(body: BodyMesh, name: str, sign_of_y: float) -> Array:
    """End points of the n element sides of a named boundary, (n, 2, 2) [length]; `sign_of_y` is −1
    to reflect a body at its face.
    """
    facets = body.mesh.facets[:, body.mesh.boundaries[name]]
    return np.asarray(body.mesh.p.T[facets.T]) * (1.0, sign_of_y)


def _support_in_words(bodies: Sequence[BodyMesh], boundary: str) -> str:
    """How one boundary of both bodies is supported, in brackets; "" for a free boundary. A body's
    `supports` has the kind of support by the name of the boundary.
    """
    if boundary == "contact":
        return " (may touch)"
    if boundary == "free":
        return ""
    # SUPPORT_WORDS: kind of support -> its words
    supports_in_words = [
        SUPPORT_WORDS.get(body.supports.get(boundary, ""), "free") for body in bodies
    ]
    if len(set(supports_in_words)) == 1:
        return f" ({supports_in_words[0]})"
    return f" (lower {supports_in_words[0]}, upper {supports_in_words[1]})"


def _marks_of_boundaries(
    bodies: Sequence[BodyMesh], half_width: float
) -> tuple[list[Mark], list[Key]]:
    """Marks for the boundaries of two meshed bodies (lower, upper), such as contact and base, and
    their entries in the legend, which name the supports. Each boundary has a colour; places are
    over a_ref = `half_width` [length].
    """
    # BOUNDARIES: their names in a mesh; the upper body is turned over
    marks: list[Mark] = []
    legend_entries = []
    for boundary in BOUNDARIES:
        bodies_with_boundary = []
        for sign_of_y, body in zip((1.0, -1.0), bodies, strict=True):
            if boundary in body.mesh.boundaries:
                sides_of_body = _sides_of_boundary(body, boundary, sign_of_y) / half_width
                # Segments: lines and their look in the style sheet
                marks.append(Segments(sides_of_body, f"curve side-{boundary}"))
                bodies_with_boundary.append(body)
        if bodies_with_boundary:
            support = _support_in_words(bodies_with_boundary, boundary)
            # Key: an entry of the legend, its look and text
            legend_entries.append(Key(f"side-{boundary}", f"{boundary.replace('_', ' ')}{support}"))
    return marks, legend_entries


def scales_of(snapshots: Sequence[Snapshot]) -> tuple[float, float]:
    """Two numbers that all pictures of a run share. They are the largest nodal von Mises stress
    [stress], at the end of the scale of colours, and the factor by which displacements are
    magnified in pictures of whole bodies.

    The factor is 1, 2 or 5 times a power of ten, with which the largest displacement is at most
    0.06 of the size of the bodies (`_SHOWN_DISPLACEMENT`); 1 where nothing moves. `snapshots` are
    the fields of both bodies, at an instant each.
    """
    bodies = [body for snapshot in snapshots for body in snapshot.bodies]
    largest_extent = max(float(np.ptp(body.points, axis=0).max()) for body in bodies)
    largest_displacement = max(
        float(np.linalg.norm(body.displacement, axis=1).max()) for body in bodies
    )
    largest_stress = max(float(body.von_mises.max()) for body in bodies)
    magnification = 1.0
    if largest_displacement:
        magnification = round_down(_SHOWN_DISPLACEMENT * largest_extent / largest_displacement)
    return largest_stress or 1.0, magnification


def stress(
    solution: FiniteElementSolution,
    snapshots: Sequence[Snapshot],
    instants: Sequence[Instant],
    stress_and_magnification: tuple[float, float],
    name: str = "von_mises",
    pixels: int = 560,
) -> Plate:
    """A figure of von Mises' stress at some instants: both bodies, drawn apart and deformed; and
    the contact without magnification, with its mesh. Its table has the largest nodal stress of each
    instant.

    Parameters
    ----------
    snapshots
        displacement and stress of both bodies at each of the `instants`, which have a time and a
        label
    stress_and_magnification
        largest stress of the scale of colours [stress], and factor by which displacements are
        magnified in pictures of whole bodies
    name
        of the figure, and begin of the names of its panels
    pixels
        width of each picture [pixels]
    """
    largest_stress, _ = stress_and_magnification
    # two cells of the figure, which are panels one under the other, for each instant
    cells: list[Cell] = []
    for instant_number, (instant, snapshot) in enumerate(zip(instants, snapshots, strict=True)):
        panel_name = f"{name}-{instant_number}-whole"
        cells.append(
            _panels_of_whole_bodies(
                solution, snapshot, instant.label, stress_and_magnification, panel_name, pixels
            )
        )
        cells.append(
            _panels_of_contact(
                solution, snapshot, largest_stress, f"{name}-{instant_number}", pixels
            )
        )
    # NO_PEAK: a sentence, that nodal values are not peaks; STATE_KEYS: legend of open, stick and
    # slip
    # Plate: name, title, caption, description, panels, CSV table and legend
    return Plate(
        name,
        "Von Mises stress",
        "Left: both bodies, drawn apart, displacements exaggerated by the factor stated. Right:"
        f" the contact to true scale, and the state of its points. {NO_PEAK}",
        "Von Mises stress in both bodies at the instants asked for.",
        tuple(cells),
        _table_of_largest_stresses(solution, snapshots, instants),
        STATE_KEYS,
    )


def _table_of_largest_stresses(
    solution: FiniteElementSolution, snapshots: Sequence[Snapshot], instants: Sequence[Instant]
) -> dict[str, list[Any]]:
    """Columns for a CSV, a row for each instant: label, time, and the largest nodal von Mises
    stress of both bodies with its body and its place x, y in the undeformed body. `snapshots` are
    the fields at the `instants`; the scene of the solution has the units.
    """
    _, length_unit, stress_unit = units(solution.scene)
    peaks = [peak(snapshot) for snapshot in snapshots]
    return {
        "instant": [instant.label for instant in instants],
        "time": [snapshot.time for snapshot in snapshots],
        f"largest nodal value [{stress_unit}]": [
            peak_of_instant["value"] for peak_of_instant in peaks
        ],
        "body": [peak_of_instant["body"] for peak_of_instant in peaks],
        f"x [{length_unit}]": [peak_of_instant["x"] for peak_of_instant in peaks],
        f"y [{length_unit}]": [peak_of_instant["y"] for peak_of_instant in peaks],
    }


class _DrawnBodies(NamedTuple):
    """Both bodies as a picture shows them: deformed, drawn apart and coloured by stress."""

    skins: list[Skin]  # the coloured mesh of each body
    outlines: Array  # (n, 2, 2) ends of the sides of all boundaries, undeformed [length]


def _panels_of_whole_bodies(
    solution: FiniteElementSolution,
    snapshot: Snapshot,
    label: str,
    stress_and_magnification: tuple[float, float],
    name: str,
    pixels: int,
) -> Cell:
    """Panels of both whole bodies at one instant: coloured by von Mises' stress on a logarithmic
    scale, deformed, with the outlines of the undeformed bodies; below them the scale of colours.

    Parameters
    ----------
    solution
        has the meshes of both bodies, in the order of those in `snapshot`
    snapshot
        fields of both bodies at the instant: name, points and cells (nodes of each element),
        displacement and von Mises' stress at the nodes
    label
        name of the instant
    stress_and_magnification
        largest stress of the scale of colours [stress], and factor by which displacements are
        magnified
    name
        of the panel, and begin of the name of that of the colours
    pixels
        width of the picture [pixels]
    """
    # ends of the scale of colours; _DECADES_OF_COLOURS: 2.5
    largest_stress, magnification = stress_and_magnification
    _, length_unit, stress_unit = units(solution.scene)
    ends_of_colours = (largest_stress * 10**-_DECADES_OF_COLOURS, largest_stress)

    # the panel with its words, and the colours
    drawn_bodies = _bodies_drawn_apart(
        solution.bodies, snapshot.bodies, ends_of_colours, magnification
    )
    loads_in_words = (
        f"P = {number(snapshot.normal_load)}, Q = {number(snapshot.tangential_load)}"
        f" {load_unit(solution.scene)}"
    )
    note = f"{loads_in_words}; displacements × {number(magnification)}, drawn apart"
    # PanelWords: unit of length, title and note
    panel_words = PanelWords(length_unit, f"t = {number(snapshot.time)}, {label}", note)
    # Segments: lines and their look in the style sheet
    undeformed_outlines = Segments(drawn_bodies.outlines, "curve undeformed")
    panel = rendered(
        name,
        _window_around(drawn_bodies),
        drawn_bodies.skins,
        pixels,
        panel_words,
        [undeformed_outlines],
    )
    colours = colour_scale(
        f"{name}-colours",
        ends_of_colours,
        f"von Mises stress  [{stress_unit}], logarithmic",
        log=True,
        width=440.0,
    )
    # Cell: panels one under the other; None: a click on them shows no instant
    return Cell((panel, colours), None)


def _bodies_drawn_apart(
    body_meshes: Sequence[BodyMesh],
    bodies: Sequence[BodyFields],
    ends_of_colours: tuple[float, float],
    magnification: float,
) -> _DrawnBodies:
    """Both bodies with magnified displacements, coloured by the logarithm of von Mises' stress, and
    the outlines of the undeformed bodies. They are drawn apart: else they would overlap, since the
    gap is not magnified.

    Parameters
    ----------
    body_meshes, bodies
        meshes of the bodies, and their fields at one instant in the same order
    ends_of_colours
        least and largest stress of the scale of colours [stress]
    magnification
        factor by which displacements are magnified
    """
    least_stress, largest_stress = ends_of_colours
    ends_of_log_stress = (float(np.log10(least_stress)), float(np.log10(largest_stress)))
    # each is moved by half of the distance; _SHOWN_DISPLACEMENT: 0.06
    largest_extent = max(float(np.ptp(body.points, axis=0).max()) for body in bodies)
    half_distance = (0.03 + _SHOWN_DISPLACEMENT) * largest_extent / 2
    skins = []
    outlines = []  # (n, 2, 2) ends of the sides of each boundary
    for body_mesh, body in zip(body_meshes, bodies, strict=True):
        outward_sign = 1.0 if body.name == "lower" else -1.0
        offset = np.array([0.0, -outward_sign * half_distance])
        log_stress = np.log10(np.maximum(body.von_mises, least_stress))
        deformed_points = body.points + magnification * body.displacement + offset
        # Skin: nodes, elements, values at the nodes, ends of the scale of colours
        skins.append(Skin(deformed_points, body.cells, log_stress, ends_of_log_stress))
        outlines += [
            _sides_of_boundary(body_mesh, boundary, outward_sign) + offset
            for boundary in body_mesh.mesh.boundaries
        ]
    return _DrawnBodies(skins, np.concatenate(outlines))


def _window_around(drawn_bodies: _DrawnBodies) -> Window:
    """Left, right, bottom and top of the part of the plane [length] that holds the deformed bodies
    and the outlines, with a margin of 4 % of its width and height.

    `drawn_bodies` holds both deformed meshes, and outlines (n, 2, 2) [length].
    """
    points = np.concatenate(
        [*(skin.points for skin in drawn_bodies.skins), drawn_bodies.outlines.reshape(-1, 2)]
    )
    least_corner = points.min(axis=0)
    largest_corner = points.max(axis=0)
    margin = 0.04 * (largest_corner - least_corner)
    left_x, bottom_y = (least_corner - margin).tolist()
    right_x, top_y = (largest_corner + margin).tolist()
    return left_x, right_x, bottom_y, top_y


def outermost(solution: FiniteElementSolution) -> float:
    """Half-width of the largest contact of a solution [length]; of a contact that tilt moves, the
    largest |x| of its edges.
    """
    if solution.tilt is None:
        return float(np.nanmax(solution.contact_half_width))
    return float(np.nanmax(np.abs(solution.contact_edges)))


def _panels_of_contact(
    solution: FiniteElementSolution,
    snapshot: Snapshot,
    largest_stress: float,
    name: str,
    pixels: int,
) -> Cell:
    """Panels of the contact at one instant, without magnification. Both bodies are coloured by von
    Mises' stress, with their mesh. Below them are the states of the contact points, and the scale
    of colours.

    Parameters
    ----------
    solution
        has the states of the contact points at all stored instants
    snapshot
        fields of both bodies at the instant: name, points and cells (nodes of each element),
        displacement and von Mises' stress at the nodes
    largest_stress
        at the end of the scale of colours [stress]
    name
        begin of the names of the panels
    pixels
        width of the picture [pixels]
    """
    _, length_unit, stress_unit = units(solution.scene)
    half_size = 1.75 * outermost(solution)  # of the square that is shown
    largest_nodal_stress = peak(snapshot)  # value and body
    note = minus(
        f"largest nodal value {largest_nodal_stress['value']:.4g} {stress_unit},"
        f" {largest_nodal_stress['body']} body"
    )
    # PanelWords: unit of length, title and note
    panel_words = PanelWords(length_unit, "at the contact, to true scale", note)
    window = (-half_size, half_size, -half_size, half_size)
    skins = _skins_at_true_scale(solution, snapshot.bodies, largest_stress)
    panel = rendered(f"{name}-contact", window, skins, pixels, panel_words)
    instant_index = int(np.argmin(np.abs(solution.time - snapshot.time)))
    strip = _strip_of_states(solution, instant_index, half_size, f"{name}-states")
    colours = colour_scale(
        f"{name}-contact-colours",
        (0.0, largest_stress),
        f"von Mises stress  [{stress_unit}]",
        width=440.0,
    )
    # Cell: panels one under the other; None: a click on them shows no instant
    return Cell((panel, strip, colours), None)


def _skins_at_true_scale(
    solution: FiniteElementSolution, bodies: Sequence[BodyFields], largest_stress: float
) -> list[Skin]:
    """Coloured meshes of both deformed bodies, without magnification, from their fields at one
    instant. Colours go from 0 to `largest_stress` [stress]. Faces that are flat in the mesh are
    moved apart by the gap, which is drawn as well.
    """
    skins = []
    for body in bodies:
        lift_by_gap = np.outer(rise_by_gap(solution, body), (0.0, 1.0))
        deformed_points = body.points + body.displacement + lift_by_gap
        limits = (0.0, largest_stress)
        # Skin: nodes, elements, values at the nodes, ends of the scale of colours
        skins.append(
            Skin(deformed_points, body.cells, body.von_mises, limits, opacity_of_lines=0.22)
        )
    return skins


def _strip_of_states(
    solution: FiniteElementSolution, instant_index: int, half_size: float, name: str
) -> Panel:
    """A narrow panel that shows by colour where the contact is open, sticks and slips at one stored
    instant, for |x| up to `half_size` [length]. It has no axes; `name` is that of the panel.

    The instant is that of `instant_index` among the stored ones.
    """
    marks = [
        *state_blocks(solution, instant_index, half_size, 0.0, 1.0),
        Block((-half_size, half_size), (0.0, 1.0), "outline"),
    ]
    # Panel: name, both axes, marks, description, width and height
    return Panel(
        name,
        Axis(-half_size, half_size, ""),
        Axis(0.0, 1.0, ""),
        marks,
        "Open, stick and slip along the contact",
        440.0,
        20.0,
        without_axes=True,
        room=(72.0, 2.0, 20.0, 2.0),
    )


def rise_by_gap(solution: FiniteElementSolution, body: BodyFields) -> Array:
    """By how much each node of a body is raised in pictures, (n,) [length]. On the upper body,
    whose face is flat in the mesh, it is the gap h(x) of the scene's profile. It is 0 on the lower
    body, and where the faces have their true shape in the mesh.
    """
    if body.name == "lower" or solution.scene.bodies.faces_are_true:
        return np.zeros(len(body.points))
    return np.asarray(solution.scene.profile.height(body.points[:, 0]))


def state_blocks(
    solution: FiniteElementSolution,
    instant_index: int,
    largest_x: float,
    lower_y: float,
    upper_y: float,
) -> list[Block]:
    """Rectangles that show the state (open, stick, slip) of the contact points along x at one
    stored instant, that of `instant_index`, for |x| up to `largest_x` [length]. Neighbouring
    points of one state share a rectangle. In y all rectangles go from `lower_y` to `upper_y`.

    The solution's `x` are the contact points (n,), ascending; `state` (n_instants, n) is a number
    from 0 to 3 each.
    """
    is_drawn = np.abs(solution.x) <= largest_x
    drawn_x = solution.x[is_drawn]
    states = solution.state[instant_index][is_drawn]
    # a rectangle ends in the middle between two points of different state
    borders = np.concatenate([drawn_x[:1], (drawn_x[1:] + drawn_x[:-1]) / 2, drawn_x[-1:]])
    # index of the first point of each rectangle, and the end of all
    first_indices = [0, *(np.flatnonzero(np.diff(states)) + 1).tolist(), len(states)]
    return [
        Block(
            (float(borders[first_index]), float(borders[next_first_index])),
            (lower_y, upper_y),
            f"state-{states[first_index]}",
        )
        for first_index, next_first_index in itertools.pairwise(first_indices)
    ]
