"""Bodies meshed by gmsh: blocks, pads, cylinders, T-shapes and shouldered pads, graded to the
contact, mirror-symmetric, the face where it truly is.

The half-disc stands for a half-plane. `build` goes from a shape to its mesh.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TypeAlias

import gmsh
import numpy as np
from numpy.typing import NDArray

from meshes.bodies import (
    BodyMesh,
    Cells,
    MeshSettings,
    SurfaceGrading,
    lengths_to_twelve_digits,
    require_few_nodes,
    scaled_grading,
    size_formula,
    surface_points,
)
from meshes.mirrored import mesh_quality, mirrored_mesh
from scenes import (
    Block,
    Cylinder,
    HalfPlane,
    InputError,
    Pad,
    Profile,
    Shape,
    ShoulderedPad,
    TShape,
)
from scenes.array_types import Array
from scenes.bodies import Face, face_of


def half_disc(
    name: str,
    grading: SurfaceGrading,
    growth: float = 0.2,
    order: int = 2,
    cells: Cells = "triangles",
) -> BodyMesh:
    """Mesh by gmsh of a half-disc y <= 0, which stands for a half-plane in the finite elements.

    One quarter is meshed and reflected in x = 0, so that a symmetric contact stays symmetric in
    rounding too. Boundaries: "contact" (|x| <= grading.outer), "free" (the rest of y = 0),
    "far_field" (the arc).

    Parameters
    ----------
    name
        "lower" or "upper", of the body
    grading
        sizes of the surface elements, and the radius of the half-disc [length]
    growth
        growth of the element size per distance from the contact
    order, cells
        1 or 2, of elements and geometry; triangles or quadrilaterals

    Returns
    -------
    BodyMesh
        MeshTri2 of six-node triangles with curved arc for order 2, MeshTri of three-node ones for
        order 1; MeshQuad2 of nine-node quadrilaterals, MeshQuad.
    """
    # gmsh draws in units of the half-width of the fine part of the contact face; quadrilaterals at
    # twice their size, as it halves these at the end
    length_unit = grading.outer
    unit_grading = scaled_grading(grading, 1 / length_unit).grading_for_gmsh(cells)
    formula_of_size = size_formula(unit_grading, growth)
    unit_mesh = mirrored_mesh(lambda: _draw_quarter(unit_grading), formula_of_size, order, cells)
    mesh = unit_mesh.scaled(float(length_unit))
    exact_area = np.pi * grading.radius**2 / 2
    return BodyMesh(name, mesh, grading, mesh_quality(mesh, exact_area))


def _draw_quarter(grading: SurfaceGrading) -> dict[str, list[int]]:
    """Draw the quarter x >= 0, y <= 0 of a disc into gmsh's current model, with one line for each
    element on the contact.

    `grading` has the sizes of the surface elements and the radius, in gmsh's unit of length.
    Returns boundary name -> tags of its curves; the axis x = 0 has no name.
    """
    # gmsh returns a tag, a number, for each point and curve. `surface_points`: abscissae of the
    # ends of the surface elements.
    geometry = gmsh.model.geo
    surface_point_tags = [geometry.addPoint(float(x), 0, 0) for x in surface_points(grading)]
    face_end_tag = geometry.addPoint(grading.radius, 0, 0)
    bottom_tag = geometry.addPoint(0, -grading.radius, 0)
    contact_line_tags = [
        geometry.addLine(first_tag, second_tag)
        for first_tag, second_tag in itertools.pairwise(surface_point_tags)
    ]
    free_line_tag = geometry.addLine(surface_point_tags[-1], face_end_tag)
    arc_tag = geometry.addCircleArc(face_end_tag, surface_point_tags[0], bottom_tag)
    axis_line_tag = geometry.addLine(bottom_tag, surface_point_tags[0])
    geometry.addPlaneSurface(
        [geometry.addCurveLoop([*contact_line_tags, free_line_tag, arc_tag, axis_line_tag])]
    )
    for line_tag in contact_line_tags:
        geometry.mesh.setTransfiniteCurve(line_tag, 2)  # two nodes: one element on each line
    return {"contact": contact_line_tags, "free": [free_line_tag], "far_field": [arc_tag]}


Indices = NDArray[np.int64]
Solid: TypeAlias = Block | Pad | Cylinder | TShape | ShoulderedPad
"""A body that ends somewhere."""


def solid(
    name: str,
    shape: Solid,
    profile: Profile,
    grading: SurfaceGrading,
    growth: float = 0.2,
    order: int = 2,
    cells: Cells = "triangles",
) -> BodyMesh:
    """Mesh of a block, pad, cylinder, T-shape or shouldered pad in its own frame: first contact at
    the origin, y out of the body.

    Elements are small at the contact and where the strain is infinite: in the corner of a free side
    with a fixed base, and in the re-entrant corner of a step. Boundaries: "contact" (|x| <=
    grading.outer), "free" (the rest of the face), "sides" (with those of a step; none for a
    cylinder), "base".

    Parameters
    ----------
    name
        "lower" or "upper", the body's name in messages
    shape, profile
        the body, and the profile of its face
    grading
        sizes of the surface elements [length]
    growth
        growth of the element size per distance from the contact
    order, cells
        1 or 2, of elements and geometry; triangles or quadrilaterals

    Raises
    ------
    InputError
        Where the face does not reach past the places that may touch, or a pad's face goes below its
        base.
    """
    check_face(name, shape, profile, grading)
    face = face_of(shape, profile)  # with its depth below its highest point, at any x

    # gmsh draws in units of the half-width of the fine part of the contact face; quadrilaterals at
    # twice their size, as it halves these at the end
    length_unit = grading.outer
    unit_grading = scaled_grading(grading, 1 / length_unit).grading_for_gmsh(cells)
    outline = _Outline(shape, face, length_unit)
    formula_of_size = size_formula(unit_grading, growth, outline.sharp_corners)
    # `outline.points_on_true_face` moves mid-side nodes from chords onto the profile
    unit_mesh = mirrored_mesh(
        lambda: outline.draw(unit_grading, growth),
        formula_of_size,
        order,
        cells,
        outline.points_on_true_face,
    )

    # The quality compares the area of the mesh with that of the cross-section.
    mesh = unit_mesh.scaled(float(length_unit))
    return BodyMesh(
        name, mesh, grading, mesh_quality(mesh, _cross_section_area(shape, face)), _supports(shape)
    )


def check_face(name: str, shape: Solid, profile: Profile, grading: SurfaceGrading) -> None:
    """Refuse a body whose face is too short for the contact, and a pad whose curved face cuts
    through its base or shoulder.

    Parameters
    ----------
    name
        "lower" or "upper", the body's name in the message
    shape, profile
        the body, and the profile of its face
    grading
        of the contact face, whose nodes up to |x| = `grading.outer` may touch

    Raises
    ------
    InputError
        With what to change: a wider or higher body, or less load.
    """
    half_width = shape.face_half_width
    if grading.outer >= half_width:
        raise InputError(
            f"bodies.{name}: the contact reaches |x| = {grading.outer:.6g}, past the end of the"
            f" {shape.kind}'s face at {half_width:.6g}: make the {shape.kind} wider, or the load"
            " less"
        )
    if isinstance(shape, Pad | ShoulderedPad):
        key = "height" if isinstance(shape, Pad) else "shoulder_depth"
        depth_of_sides = getattr(shape, key)
        if not float(face_of(shape, profile).depth(np.array(half_width))) < depth_of_sides:
            raise InputError(
                f"bodies.{name}.{key} = {depth_of_sides:g} is refused: the pad's face goes as deep"
                " at its sides; make it higher"
            )


def _supports(shape: Solid) -> Mapping[str, str]:
    """Supports of a body, boundary ("base", "sides") -> kind: "fixed", "rollers" (moves along x
    only) or "guided" (along y only). A block or pad states them; every other shape has a fixed
    base.
    """
    if isinstance(shape, Block | Pad):
        return {"base": shape.base} | ({"sides": "guided"} if shape.sides == "guided" else {})
    return {"base": "fixed"}


def _cross_section_area(shape: Solid, face: Face) -> float:
    """Cross-section of a body [length^2], the reference for the area of its mesh.

    The material between the profiled face and the tangent at its highest point is missing from the
    rectangle (two rectangles of a body with a step). Its area is integrated by 20 Gauss points on
    each of 64 intervals of x > 0, and doubled. A cylinder is a half-disc.

    Parameters
    ----------
    shape
        the body: width of its face, height, and depth and half-width of a step
    face
        `depth` of the face below its highest point, at places x; `arc` is (x where an arc begins,
        its radius), None without one
    """
    if isinstance(shape, Cylinder):
        return np.pi * shape.radius**2 / 2
    gauss_points, weights = np.polynomial.legendre.leggauss(20)
    # Where the face is flat up to an arc, nothing is missing above the flat.
    flat_half_length = min(face.arc[0], shape.width / 2) if face.arc is not None else 0.0
    interval_ends = np.linspace(flat_half_length, shape.width / 2, 65)
    half_interval = (interval_ends[1] - interval_ends[0]) / 2
    depths = face.depth(interval_ends[:-1, None] + half_interval * (1 + gauss_points))  # (64, 20)
    area = shape.width * shape.height
    if isinstance(shape, TShape | ShoulderedPad):
        step = shape.step
        area = shape.width * step.depth + 2 * step.half_width * (shape.height - step.depth)
    return float(area - 2 * half_interval * np.sum(depths @ weights))


class _Outline:
    """Outline of the half x >= 0 of a body, in units of the half-width of the fine part of its
    contact face, as gmsh draws it.
    """

    def __init__(self, shape: Solid, face: Face, length_unit: float) -> None:
        """Sizes of a body over a `length_unit`, to twelve digits: half-width and height, drop of
        its face at the end, lower end of its sides, corners of a step. Also whether the strain is
        infinite in the corner of its sides and base.

        Parameters
        ----------
        shape
            block, pad, cylinder, T-shape or shouldered pad
        face
            depth of the body's face below its highest point, as a function of x
        length_unit
            half-width of the fine part of the contact face [length]
        """
        self._face = face
        self._length_unit = length_unit
        scaled_half_width = shape.face_half_width / length_unit
        scaled_height = (
            shape.radius if isinstance(shape, Cylinder) else shape.height
        ) / length_unit
        # The drop is that at the unrounded half-width. At the end of an arc of 90 degrees it
        # changes with the root of the half-width, and rounding this would cost half of the digits.
        unrounded_face_drop = float(self._unrounded_depth(np.array(scaled_half_width)))
        self._half_width, self._height, self._face_drop = lengths_to_twelve_digits(
            [scaled_half_width, scaled_height, unrounded_face_drop]
        ).tolist()

        # Lower end of the sides, (x, y), and corners of a step between face and sides.
        self._side_end = (self._half_width, -self._height)
        supports = _supports(shape)
        self._has_sharp_base_corner = supports["base"] == "fixed" and "sides" not in supports
        self._step_corners: list[tuple[float, float]] = []  # from the face downwards
        if isinstance(shape, TShape | ShoulderedPad):
            step_depth, half_width_below_step = lengths_to_twelve_digits(
                np.array(shape.step) / length_unit
            ).tolist()
            self._step_corners = [
                (self._half_width, -step_depth),
                (half_width_below_step, -step_depth),
            ]
            self._side_end = (half_width_below_step, -self._height)

    @property
    def sharp_corners(self) -> list[tuple[float, float]]:
        """Corners (x, y) of the outline in which the strain is infinite: of a free side, or face,
        and a fixed base, and the re-entrant corner of a step.
        """
        corners = [self._side_end] if self._has_sharp_base_corner else []
        return corners + sorted(self._step_corners)[:1]

    def _rounded_depth(self, x: Array) -> Array:
        """Depth of the face at x, to the twelve digits that are drawn; any shape."""
        return lengths_to_twelve_digits(self._unrounded_depth(x))

    def _unrounded_depth(self, x: Array) -> Array:
        """Depth of the face at x below its highest point; any shape."""
        return np.asarray(self._face.depth(np.asarray(x) * self._length_unit)) / self._length_unit

    def draw(self, grading: SurfaceGrading, growth: float) -> dict[str, list[int]]:
        """Draw the half x >= 0 of the body into gmsh's current model: contact, the rest of the
        face, side, base and axis.

        Parameters
        ----------
        grading
            sizes of the surface elements, in this outline's unit of length
        growth
            growth of the element size per distance from the contact

        Returns
        -------
        dict
            Boundary name ("contact", "free", "base", and "sides" if there are any) -> gmsh tags of
            its curves.

        Notes
        -----
        The outline has, in the same unit, `_height`; `_face_drop`, the depth of the face at its
        end; `_step_corners`, (x, y) of the corners of a step from the face downwards; and
        `_side_end`, the lower end of the side.
        """
        # gmsh numbers points and curves by tags. `edge_size`: of an element at the contact's end.
        geometry = gmsh.model.geo
        surface_x = surface_points(grading)
        contact_line_tags, first_point_tag, contact_end_tag = self._draw_contact(surface_x)
        free_curve_tags, face_end_tag = self._draw_rest_of_face(
            float(surface_x[-1]), contact_end_tag, grading.edge_size, growth
        )
        axis_end_tag = geometry.addPoint(0, -self._height, 0)
        side_line_tags, side_end_tag = self._draw_sides(face_end_tag)
        base_line_tag = geometry.addLine(side_end_tag, axis_end_tag)
        axis_line_tag = geometry.addLine(axis_end_tag, first_point_tag)
        outline_tags = [
            *contact_line_tags,
            *free_curve_tags,
            *side_line_tags,
            base_line_tag,
            axis_line_tag,
        ]
        geometry.addPlaneSurface([geometry.addCurveLoop(outline_tags)])
        return {"contact": contact_line_tags, "free": free_curve_tags, "base": [base_line_tag]} | (
            {"sides": side_line_tags} if side_line_tags else {}
        )

    def _draw_contact(self, surface_x: Array) -> tuple[list[int], int, int]:
        """Draw the part of the face that may touch into gmsh's current model, between points at
        ascending x: one line for each surface element, since it has two nodes.

        Returned are gmsh's tags (a tag is the number of a point or curve) of the lines, and of the
        first and the last point.
        """
        geometry = gmsh.model.geo
        point_tags = [
            geometry.addPoint(float(x), -float(y), 0)
            for x, y in zip(surface_x, self._rounded_depth(surface_x), strict=True)
        ]
        line_tags = [
            geometry.addLine(first_tag, second_tag)
            for first_tag, second_tag in itertools.pairwise(point_tags)
        ]
        for line_tag in line_tags:
            geometry.mesh.setTransfiniteCurve(line_tag, 2)
        return line_tags, point_tags[0], point_tags[-1]

    def _draw_sides(self, face_end_tag: int) -> tuple[list[int], int]:
        """Draw the side of the body into gmsh's current model: from the point at the end of the
        face down to the base, by the corners of a step, if there is one.

        Returned are gmsh's tags of the lines, and of the last point. A half-cylinder has no sides:
        its face goes down to the base.
        """
        line_tags: list[int] = []
        last_tag = face_end_tag
        if self._face_drop < self._height * (1 - 1e-9):
            for x, y in (*self._step_corners, self._side_end):
                corner_tag = gmsh.model.geo.addPoint(x, y, 0)
                line_tags.append(gmsh.model.geo.addLine(last_tag, corner_tag))
                last_tag = corner_tag
        return line_tags, last_tag

    def _draw_rest_of_face(
        self, start_x: float, first_point_tag: int, size: float, growth: float
    ) -> tuple[list[int], int]:
        """Draw the free part of the face, between contact and side, into gmsh's current model: one
        circular arc, one straight line, or a polygon along the profile.

        Parameters
        ----------
        start_x
            x where the contact ends and the free part begins
        first_point_tag
            gmsh tag of the point at `start_x`
        size, growth
            size of the first element, and its growth per distance

        Returns
        -------
        curve_tags, last_point_tag
            gmsh tags of the curves, and of the point at the end of the face.

        Notes
        -----
        In the outline's unit of length the face ends at x = `_half_width`, `_face_drop` below its
        highest point. `_face.arc` is (x where an arc begins, its radius), None without one;
        `_rounded_depth` the depth of the face at x, to twelve digits.
        """
        geometry = gmsh.model.geo
        face_end_x = self._half_width

        # One arc, where the contact ends on it.
        if self._face.arc is not None:
            arc_begin_x, radius = lengths_to_twelve_digits(
                np.array(self._face.arc) / self._length_unit
            ).tolist()
            if start_x >= arc_begin_x:
                last_point_tag = geometry.addPoint(face_end_x, -self._face_drop, 0)
                centre_tag = geometry.addPoint(arc_begin_x, -radius, 0)
                return [
                    geometry.addCircleArc(first_point_tag, centre_tag, last_point_tag)
                ], last_point_tag

        # Else one line of a flat face, or a polygon.
        face_x = np.array([face_end_x])
        if not self._face.is_flat:
            face_x = self._graded_abscissae(start_x, face_end_x, size, growth)
        face_point_tags = [first_point_tag] + [
            geometry.addPoint(float(x), -float(y), 0)
            for x, y in zip(face_x, self._rounded_depth(face_x), strict=True)
        ]
        line_tags = [
            geometry.addLine(line_begin_tag, line_end_tag)
            for line_begin_tag, line_end_tag in itertools.pairwise(face_point_tags)
        ]
        return line_tags, face_point_tags[-1]

    def _graded_abscissae(self, start: float, end: float, size: float, growth: float) -> Array:
        """Abscissae x (n,) of points on the face beyond `start`, the last one at `end`: as far
        apart as elements there are large, `size` plus `growth` times the distance from the start.
        """
        abscissae = [start]
        while abscissae[-1] < end:
            distance_from_start = float(
                np.hypot(abscissae[-1] - start, self._rounded_depth(np.array(abscissae[-1])))
            )
            abscissae.append(abscissae[-1] + size + growth * distance_from_start)
        return start + (np.array(abscissae[1:]) - start) * (end - start) / (abscissae[-1] - start)

    def points_on_true_face(self, points: Array, named_nodes: dict[str, Indices]) -> Array:
        """Points (n, 2) of the nodes, those on the face moved in y onto its true profile: gmsh puts
        mid-side nodes on the chord between two corners.

        `named_nodes` maps the name of a boundary to the numbers of its nodes. Beside the contact
        nothing is moved where gmsh has drawn the face as an arc. `_face.arc` is (x where an arc
        begins, its radius), None without one; points are in the outline's unit of length.
        """
        true_points = points.copy()
        nodes = named_nodes["contact"]
        if self._face.arc is None or points[nodes, 0].max() < self._face.arc[0] / self._length_unit:
            nodes = np.union1d(nodes, named_nodes["free"])
        true_points[nodes, 1] = -self._unrounded_depth(points[nodes, 0])
        return true_points


def check(
    name: str, shape: Shape, profile: Profile, grading: SurfaceGrading, mesh: MeshSettings
) -> None:
    """Refuse a mesh of one body that could not be made, without making it.

    Parameters
    ----------
    name
        "lower" or "upper", the body's name in the message
    shape, profile
        half-plane or other body, and the profile of its face
    grading
        sizes of the surface elements, and the |x| up to which nodes may touch [length]
    mesh
        settings of the mesh: growth of the element size per distance, and order of the elements

    Raises
    ------
    InputError
        For a mesh too large for memory, a face shorter than the contact, or a pad whose face goes
        below its base or shoulder.
    """
    require_few_nodes(name, grading, mesh.growth, mesh.order)
    if not isinstance(shape, HalfPlane):
        check_face(name, shape, profile, grading)


def build(
    name: str, shape: Shape, profile: Profile, grading: SurfaceGrading, mesh: MeshSettings
) -> BodyMesh:
    """Mesh one of the two bodies of a scene with gmsh: a half-disc for a half-plane, its own
    outline for every other shape.

    Parameters
    ----------
    name
        "lower" or "upper", as the scene calls it
    shape
        half-plane, block, pad, cylinder, T-shape or shouldered pad
    profile
        the initial gap, which is the face of a pad
    grading
        sizes of the surface elements, and the |x| up to which nodes may touch [length]
    mesh
        settings of the mesh: growth of the element size per distance, order and form of its
        elements

    Raises
    ------
    InputError
        Where the mesh would be too large for memory, with the limit; where a solid's face is
        shorter than the contact.
    """
    check(name, shape, profile, grading, mesh)
    if isinstance(shape, HalfPlane):
        return half_disc(name, grading, mesh.growth, mesh.order, mesh.cells)
    return solid(name, shape, profile, grading, mesh.growth, mesh.order, mesh.cells)
