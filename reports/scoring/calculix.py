"""Tractions on the contact surface of what CalculiX wrote: .frd with *CONTACT FILE, else its
stress; .dat with *CONTACT PRINT.

CalculiX stores contact results at the slave face. CPRESS is positive in compression. CSHEAR1 and
CSLIP1 count along the projection of the x axis on the face, both as slave relative to master:
measured on decks with either body as slave, where the tractions add up to the load
(tests/data/README.md). So with the lower body as slave our shear and slip (upper over lower) have
the other sign, and with the upper body as slave the same. The forms of the files are read in
`calculix_files`.

A .dat file has no places: they come from the .frd file beside it. Node-to-surface pairs are printed
node by node; surface-to-surface pairs at integration points of slave faces without place or weight:
the mean of each face stands at its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.scoring.calculix_files import (
    DatFile,
    DatTable,
    FrdBlock,
    FrdFile,
    PairForce,
    read_dat,
    read_frd,
)
from reports.scoring.mapping import Mapping, converted_values, stated_times
from reports.scoring.surface import (
    SAME_PLACE_SHARE,
    SurfaceResult,
    height_of_material,
    longest_side,
    one_plane,
    surface_result,
)
from scenes import InputError
from scenes.array_types import Array

Integers = NDArray[np.int64]

# Of the blocks that tractions are read from: quantities, and the components that they are.
_Quantity = Literal["pressure", "shear", "slip"]
_COMPONENT_BY_QUANTITY: dict[str, dict[_Quantity, str]] = {
    "CONTACT": {"pressure": "CPRESS", "shear": "CSHEAR1", "slip": "CSLIP1"},
    "STRESS": {"pressure": "SYY", "shear": "SXY"},
}
_SLIP_NOTE = (
    "CalculiX' slip holds the elastic slip of its stick stiffness and is 0 at points that are open"
)
_Faces = dict[int, tuple[int, ...]]
# Corners (from 0) of the faces of bricks, wedges, tetrahedra, and of plane elements: CalculiX
# counts their edges as faces 3 to 6.
_BRICK: _Faces = {
    1: (0, 1, 2, 3),
    2: (4, 5, 6, 7),
    3: (0, 1, 5, 4),
    4: (1, 2, 6, 5),
    5: (2, 3, 7, 6),
    6: (3, 0, 4, 7),
}
_WEDGE: _Faces = {1: (0, 1, 2), 2: (3, 4, 5), 3: (0, 1, 4, 3), 4: (1, 2, 5, 4), 5: (2, 0, 3, 5)}
_TETRAHEDRON: _Faces = {1: (0, 1, 2), 2: (0, 1, 3), 3: (1, 2, 3), 4: (0, 2, 3)}
_TRIANGLE: _Faces = {3: (0, 1), 4: (1, 2), 5: (2, 0)}
_QUADRANGLE: _Faces = {3: (0, 1), 4: (1, 2), 5: (2, 3), 6: (3, 0)}
# By the kinds of the .frd form, linear and quadratic.
_FACES: dict[int, _Faces] = {
    **dict.fromkeys((1, 4), _BRICK),
    **dict.fromkeys((2, 5), _WEDGE),
    **dict.fromkeys((3, 6), _TETRAHEDRON),
    **dict.fromkeys((7, 8), _TRIANGLE),
    **dict.fromkeys((9, 10), _QUADRANGLE),
}


class CalculixMesh:
    """The mesh of a .frd file. Its nodes are rows of arrays, in the order of their numbers.

    Attributes
    ----------
    path
        the file
    numbers, points
        (n_nodes,) CalculiX's numbers of the nodes, ascending, and (n_nodes, 3) their coordinates
        [length]
    material_heights
        (n_nodes,) how far the middles of the elements of each node lie above it along y, in the
        mean [length]; negative at the top face of the lower body; NaN for a node of no element
    """

    def __init__(self, file: FrdFile) -> None:
        """Sort the nodes of a .frd file by their numbers, and find how high the material of each
        node lies above it. `file` holds numbers and coordinates of the nodes, and the elements with
        their nodes.
        """
        order = np.argsort(file.nodes)
        self.path = file.path
        self.numbers = file.nodes[order]
        self.points = file.points[order]
        self._elements = {element.number: element for element in file.elements}
        # the nodes of each element, in one array for all elements with as many nodes
        nodes_by_count: dict[int, list[tuple[int, ...]]] = {}
        for element in file.elements:
            nodes_by_count.setdefault(len(element.nodes), []).append(element.nodes)
        # rows of the sorted nodes, (n_elements, n_nodes) for each number of nodes
        rows = [self.rows_of_nodes(np.array(nodes, np.int64)) for nodes in nodes_by_count.values()]
        self.material_heights = height_of_material(self.points, rows)

    def rows_of_nodes(self, nodes: Integers) -> Integers:
        """Rows, in the arrays of the mesh, of nodes with CalculiX's numbers `nodes`, in any shape;
        InputError for a node without coordinates.
        """
        rows = np.minimum(np.searchsorted(self.numbers, nodes), len(self.numbers) - 1)
        unknown_nodes = np.asarray(nodes)[self.numbers[rows] != nodes]
        if len(unknown_nodes):
            raise InputError(
                f"{self.path}: node {unknown_nodes[0]} has a result or an element and no"
                " coordinates (CalculiX numbers the nodes of plane elements again); write *NODE"
                " FILE, OUTPUT=3D in the deck and run it again"
            )
        return np.asarray(rows, np.int64)

    def face_middle(self, element_number: int, face_number: int) -> tuple[Array, float]:
        """Middle (3,) of a face of an element [length], and how far the middle of the element lies
        above it along y [length]. Element and face have CalculiX's numbers; InputError where the
        mesh has no such element or face.
        """
        # kind: number of its shape; nodes: CalculiX's numbers
        element = self._elements.get(element_number)
        fault = ""
        corners: tuple[int, ...] = ()
        if element is None:
            fault = "is not in it"
        else:
            # places of the face's corner nodes among the nodes of the element
            corners = _FACES.get(element.kind, {}).get(face_number, ())
            if not corners:
                fault = f"of kind {element.kind} has no face {face_number}"
        if element is None or fault:
            raise InputError(
                f"{self.path}: element {element_number} {fault}; it must be of the same run as the"
                " .dat file, with *NODE FILE and *EL FILE"
            )
        node_rows = self.rows_of_nodes(np.array(element.nodes))
        middle_of_face = self.points[node_rows[list(corners)]].mean(axis=0)
        y_of_element_middle = self.points[node_rows, 1].mean()
        return middle_of_face, float(y_of_element_middle - middle_of_face[1])

    def values_at_nodes(self, block: FrdBlock, name: str) -> Array:
        """Values (n_nodes,) of the component called `name` in a block of results; 0 at nodes that
        the block does not hold.
        """
        values = np.zeros(len(self.numbers))
        values[self.rows_of_nodes(block.nodes)] = block.column(name)
        return values


def read_results(path: Path, mapping: Mapping) -> SurfaceResult:
    """Contact tractions in a .frd file of CalculiX at every time, from its CONTACT blocks; where
    there are none, from its stress at the lower body's face.

    Loads are the resultants of the contact pair (*CONTACT PRINT, CF) where a .dat file of the same
    name beside it has them. `mapping` states columns, units and signs of the file.

    Raises
    ------
    InputError
        File and what is wrong: broken off, not in CalculiX's format, larger than half a GB; no
        contact results and no stress; nodes without coordinates.
    """
    # nodes, elements, and result blocks: values at nodes at one time
    file = read_frd(path, ("CONTACT",), substitutes=("STRESS",))
    if not file.blocks:
        raise InputError(
            f"{path}: no block CONTACT and none STRESS; it has {', '.join(file.names) or 'none'}:"
            " add *CONTACT FILE (DISP and FORC alone are what CalculiX leaves of a run whose first"
            " increment did not converge)"
        )
    mesh = CalculixMesh(file)
    has_stress_only = file.blocks[0].name == "STRESS"
    components = list(_COMPONENT_BY_QUANTITY[file.blocks[0].name].values())
    noun = "stress" if has_stress_only else "contact values"
    last_blocks, notes = _one_block_a_time(file, components, noun)
    if has_stress_only:
        face = _face_by_stress(mesh, mapping)
        notes = [*face.notes, *notes]
    else:
        _require_finite_values(file)
        face = _face_by_contact(mesh, last_blocks, mapping)
        notes += face.notes
    if not file.has_end_mark:
        notes.append(
            "the file has no end (9999): the run goes on or was stopped, and later instants are"
            " missing"
        )

    surface_values, plane_notes = _values_on_surface(mesh, last_blocks, face)
    printed_file = _printed_file_beside(path)
    return _surface_result_of(
        path, mapping, file.version, surface_values, printed_file, [*notes, *plane_notes]
    )


def _values_on_surface(
    mesh: CalculixMesh, blocks: Sequence[FrdBlock], face: _Face
) -> tuple[_SurfaceValues, list[str]]:
    """Tractions (and slip, from contact values) at the nodes of a contact face, in the scene's
    units and signs, at the times of the result blocks; and notes. Of a mesh with depth the nodes of
    one plane z = const are taken, in the order of x.

    `blocks` hold values at nodes, a block for each time. `face` states its nodes and the factor of
    each quantity.
    """
    rows_in_plane, extent_along_z, plane_notes = one_plane(mesh.points, face.rows)
    fields: dict[str, Array] = {}
    for quantity, component in _COMPONENT_BY_QUANTITY[blocks[0].name].items():
        values = np.array(
            [mesh.values_at_nodes(block, component)[rows_in_plane] for block in blocks]
        )
        fields[quantity] = face.factors[quantity] * values
    times = np.array([block.time for block in blocks])
    return _SurfaceValues(mesh.points[rows_in_plane, 0], extent_along_z, fields, times), plane_notes


def _require_finite_values(file: FrdFile) -> None:
    """InputError where a CONTACT block of a .frd file holds a number that is not finite. Nodes with
    a value that is not 0 count as touching, and so would those with a NaN.
    """
    for block in file.blocks:
        if not np.isfinite(block.values).all():
            raise InputError(
                f"{file.path}: line {block.line}: block CONTACT holds numbers that are not finite"
            )


def _printed_file_beside(path: Path) -> DatFile | None:
    """The printed tables and resultants of the .dat file of the same name beside a .frd file; None
    where there is no such file, or an empty one.
    """
    printed_path = path.with_suffix(".dat")
    if printed_path.exists() and printed_path.stat().st_size:
        return read_dat(printed_path)
    return None


class _Face(NamedTuple):
    """The face of a body on which contact tractions stand.

    Attributes
    ----------
    rows
        rows of its nodes in the arrays of the mesh
    factors
        by quantity (pressure, shear, slip), factor from the file's values to the scene's unit and
        this program's sign
    notes
        sentences for the reader of the result: which face it is, and what is coarse or left out
    """

    rows: Integers
    factors: dict[_Quantity, float]
    notes: list[str]


def _face_by_stress(mesh: CalculixMesh, mapping: Mapping) -> _Face:
    """The lower body's face, where a file has stress and no contact values. Its record holds the
    rows of its nodes in the mesh; by quantity, the factors that turn SYY and SXY into pressure and
    shear in the scene's units, p = -SYY and q = SXY (outward normal +y); and a note on it.

    The face lies at y = `mapping.y_offset` [the scene's length]. InputError where no node does.

    # notation: p pressure, q shear
    """
    y_of_face = mapping.y_offset / (mapping.factors.length or 1.0)  # in the file's unit
    height_above_face = mesh.points[:, 1] - y_of_face
    # within a millionth of the mesh's longest side; material_heights: negative at the top face of
    # the lower body
    is_on_face = (np.abs(height_above_face) <= SAME_PLACE_SHARE * longest_side(mesh.points)) & (
        mesh.material_heights < 0
    )
    if not is_on_face.any():
        raise InputError(
            f"{mesh.path}: no node of a lower body's face at y = {mapping.y_offset:g}; say where it"
            " lies by y_offset of a mapping"
        )
    stress_factor = mapping.factors.stress or 1.0
    factors_by_quantity: dict[_Quantity, float] = {
        "pressure": -stress_factor,
        "shear": stress_factor,
    }
    note = (
        "no contact values in the file (*CONTACT FILE): p = -SYY and q = SXY of the lower body at"
        " its face, outward normal +y; stress extrapolated to the nodes is coarser than the contact"
        " values"
    )
    return _Face(np.flatnonzero(is_on_face), factors_by_quantity, [note])


def _face_by_contact(mesh: CalculixMesh, blocks: Sequence[FrdBlock], mapping: Mapping) -> _Face:
    """The slave face of a result of CalculiX, by its contact values. Its record holds the rows of
    its nodes in the mesh; by quantity, the factors that turn the values of `blocks` into pressure,
    shear and slip in the scene's units with this program's signs; and notes.

    `blocks` hold the numbers of nodes and their values, a block for each time. `mapping` states
    units and signs of the file. InputError where nothing touches at any time.
    """
    # nodes that have a contact value at some time
    rows_of_blocks = [
        mesh.rows_of_nodes(block.nodes[np.any(block.values != 0, axis=1)]) for block in blocks
    ]
    touching_rows = np.unique(np.concatenate(rows_of_blocks))
    if not len(touching_rows):
        raise InputError(
            f"{mesh.path}: every contact value is 0 at every instant: the bodies do not touch in"
            " this result"
        )
    # material_heights: how far the material lies above each node
    body = _body_of_face(mesh.path, mesh.material_heights[touching_rows])
    face_rows, face_notes = _nodes_of_face(mesh, touching_rows)
    # quantities: pressure, shear, slip
    factors = {
        quantity: _factor_with_sign(mapping, quantity, body)
        for quantity in _COMPONENT_BY_QUANTITY["CONTACT"]
    }
    note = f"contact values stand at the slave face, that of the {body} body"
    # _SLIP_NOTE: that the slip holds the elastic slip of the stick stiffness
    return _Face(face_rows, factors, [note, _SLIP_NOTE, *face_notes])


def read_printed(path: Path, mapping: Mapping) -> SurfaceResult:
    """Contact tractions at every time in a .dat file of CalculiX, at the nodes or the middles of
    element faces of the .frd file beside it. Loads are the resultants of the contact pair where the
    file has them (CF). `mapping` states columns, units and signs of the file.

    Raises
    ------
    InputError
        File and what is wrong: broken off, not in CalculiX's format, larger than half a GB; no
        contact stress in it; no .frd beside it; a node or element that is not there.
    """
    printed_file = read_dat(path)
    tables = _contact_tables(printed_file)
    mesh = _mesh_beside(path)
    printed_points = _printed_points(mesh, tables)
    notes = list(printed_points.notes)

    # (n_times, n_points); columns of a table: pressure and shear, or opening and slip
    values_by_quantity: dict[_Quantity, Array] = {
        "pressure": _values_at_points(tables.stress, 0, printed_points.ids),
        "shear": _values_at_points(tables.stress, 1, printed_points.ids),
    }
    if tables.slip:
        values_by_quantity["slip"] = _values_at_points(tables.slip, 1, printed_points.ids)
        # that the slip holds the elastic slip of the stick stiffness
        notes.append(_SLIP_NOTE)
    fields: dict[str, Array] = {
        quantity: _factor_with_sign(mapping, quantity, printed_points.body) * values
        for quantity, values in values_by_quantity.items()
    }
    extent_along_z = float(np.ptp(mesh.points[:, 2]))
    times = np.array([table.time for table in tables.stress])
    surface_values = _SurfaceValues(printed_points.x, extent_along_z, fields, times)
    return _surface_result_of(path, mapping, "CalculiX", surface_values, printed_file, notes)


class _ContactTables(NamedTuple):
    """Tables of contact values that CalculiX printed into a .dat file.

    Attributes
    ----------
    path
        the file
    stress
        the last table of pressure and shear of each time
    slip
        the tables of opening and slip at the same times; none where some time has no such table
    """

    path: Path
    stress: list[DatTable]
    slip: list[DatTable]

    @property
    def all_ids(self) -> Integers:
        """Numbers of what any row of contact stress belongs to, each once: (n, 1) nodes, or (n, 2)
        elements and their faces. InputError where the file holds both.
        """
        ids_of_tables = [table.ids for table in self.stress if len(table.ids)]
        if len({ids.shape[1] for ids in ids_of_tables}) > 1:
            raise InputError(
                f"{self.path}: contact stress of nodes and of element faces in one file; print one"
                " contact pair (mapping's surface)"
            )
        return np.unique(np.concatenate(ids_of_tables), axis=0)


def _contact_tables(file: DatFile) -> _ContactTables:
    """The tables of contact stress in a .dat file, one for each time, and those of slip where there
    is one for each of these times. InputError where no contact stress is printed.
    """
    stress_table_by_time = {
        table.time: table for table in file.tables if table.quantity == "contact stress"
    }
    slip_table_by_time = {
        table.time: table
        for table in file.tables
        if table.quantity == "relative contact displacement"
    }
    if not any(len(table.ids) for table in stress_table_by_time.values()):
        raise InputError(
            f"{file.path}: no contact stress is printed in it (*CONTACT PRINT with CSTR in the"
            " deck)"
        )
    slip_tables = []
    if set(slip_table_by_time) >= set(stress_table_by_time):
        slip_tables = [slip_table_by_time[time] for time in stress_table_by_time]
    return _ContactTables(file.path, list(stress_table_by_time.values()), slip_tables)


def _mesh_beside(path: Path) -> CalculixMesh:
    """The mesh in the .frd file of the same name beside a .dat file; InputError where there is
    none.
    """
    mesh_path = path.with_suffix(".frd")
    if not mesh_path.exists():
        raise InputError(
            f"{path}: a .dat file states no places, and there is no {mesh_path.name} beside it to"
            " take them from; copy it there"
        )
    return CalculixMesh(read_frd(mesh_path, ()))


class _PrintedPoints(NamedTuple):
    """Points of one plane z = const at which CalculiX printed contact values, ascending in x.

    Attributes
    ----------
    x
        (n_points,) [length of the file]
    ids
        for each point the number of its node, or those of its element and element face
    body
        the body whose face it is, "upper" or "lower"
    notes
        sentences for the reader of the result: which face it is, and what stands at its points
    """

    x: Array
    ids: list[tuple[int, ...]]
    body: str
    notes: list[str]


def _printed_points(mesh: CalculixMesh, tables: _ContactTables) -> _PrintedPoints:
    """Where the rows of printed contact stress lie: at nodes of the mesh, or at the middles of its
    element faces. Points of one plane z = const are kept, in the order of x. InputError where the
    mesh lacks a node or an element, or the points are of both bodies.
    """
    all_ids = tables.all_ids
    # coordinates (n, 3), and how far the material lies above each point
    all_points, material_heights = _points_of_ids(mesh, all_ids)
    body = _body_of_face(tables.path, material_heights)
    rows, _, plane_notes = one_plane(all_points, np.arange(len(all_ids)))
    notes = [f"contact values stand at the slave face, that of the {body} body"]
    if all_ids.shape[1] > 1:
        notes.append(
            "CalculiX prints integration points of faces without place or weight: the plain mean of"
            " each face stands at its middle"
        )
    ids_of_points = [tuple(numbers) for numbers in all_ids[rows].tolist()]
    return _PrintedPoints(all_points[rows, 0], ids_of_points, body, [*notes, *plane_notes])


def _values_at_points(
    tables: Sequence[DatTable], column: int, ids_of_points: Sequence[tuple[int, ...]]
) -> Array:
    """One column of printed tables at the points of a contact face, (n_times, n_points), in the
    unit and with the sign of the file; 0 at points without a row. Each point is named by the number
    of its node, or by the numbers of its element and face.
    """
    return np.array([_means_at_points(table, column, ids_of_points) for table in tables])


def _factor_with_sign(mapping: Mapping, quantity: _Quantity, body: str) -> float:
    """Factor with sign from values of a CalculiX file to the scene's unit and this program's sign.
    The sign is the mapping's where it states one. Else that of shear and slip follows from the
    slave face: they are turned where `body`, of which it is part, is "lower", not where it is
    "upper".
    """
    factor = float(converted_values(mapping, quantity, np.ones(1))[0])
    has_sign = quantity == "pressure" or getattr(mapping.signs, quantity) is not None
    if has_sign or body == "upper":
        return factor
    return -factor


def _means_at_points(
    table: DatTable, column: int, ids_of_points: Sequence[tuple[int, ...]]
) -> list[float]:
    """One column of a printed table at each point of a contact surface: the mean of the rows that
    belong to its node or element face, 0 where there are none.

    Parameters
    ----------
    table
        `ids` (n_rows, 1 or 2), number of the node, or of element and element face; `values`
        (n_rows, k)
    column
        index of the column among the table's values
    ids_of_points
        for each point the number of its node, or those of its element and element face
    """
    values_by_id: dict[tuple[int, ...], list[float]] = {}
    for numbers, value in zip(table.ids.tolist(), table.values[:, column].tolist(), strict=True):
        values_by_id.setdefault(tuple(numbers), []).append(value)
    return [float(np.mean(values_by_id.get(numbers, 0.0))) for numbers in ids_of_points]


def _points_of_ids(mesh: CalculixMesh, ids: Integers) -> tuple[Array, Array]:
    """The points (n, 3) of nodes, or the middles of element faces, and how far the material lies
    above each along y, (n,); both [length of the file].

    Parameters
    ----------
    ids
        (n, 1) numbers of nodes; or (n, 2) numbers of elements and of their faces
    """
    if ids.shape[1] == 1:
        node_rows = mesh.rows_of_nodes(ids[:, 0])
        return mesh.points[node_rows], mesh.material_heights[node_rows]
    middles_and_heights = [mesh.face_middle(int(element), int(face)) for element, face in ids]
    middles = np.array([middle for middle, _ in middles_and_heights])
    return middles, np.array([height for _, height in middles_and_heights])


def _one_block_a_time(
    file: FrdFile, components: Sequence[str], noun: str
) -> tuple[list[FrdBlock], list[str]]:
    """The last result block of each time in a .frd file; and notes on times that have no block, and
    on blocks that a later one of the same time replaced.

    Parameters
    ----------
    file
        `blocks`, each with a name, a time and names of components; `times` of all frames
    components
        names that each block must have; InputError where a block lacks one
    noun
        what the blocks hold, for the notes
    """
    for block in file.blocks:
        missing_names = [name for name in components if name not in block.components]
        if missing_names:
            raise InputError(
                f"{file.path}: line {block.line}: block {block.name} has no {missing_names[0]}; it"
                f" needs {', '.join(components)}"
            )
    last_block_by_time = {block.time: block for block in file.blocks}
    notes = []
    empty_times = [time for time in file.times if time not in last_block_by_time]
    if empty_times:
        notes.append(
            f"left out: {len(empty_times)} frames without {noun} (first at time"
            f" {empty_times[0]:.6g}); CalculiX writes such a frame of an increment that did not"
            " converge"
        )
    n_replaced = len(file.blocks) - len(last_block_by_time)
    if n_replaced:
        notes.append(
            f"{n_replaced} blocks of {noun} share a time with a later one, which was taken"
        )
    return list(last_block_by_time.values()), notes


def _body_of_face(path: Path, material_heights: Array) -> str:
    """The body whose face carries contact values, "upper" or "lower": that with its material above
    or below all points of the face. `material_heights` (n,) are how far the material lies above
    each point along y. InputError where the points are of both bodies or of no element (NaN), or
    the face looks along x.
    """
    if np.all(material_heights > 0) == np.all(material_heights < 0):
        raise InputError(
            f"{path}: contact values stand at nodes of both bodies, at nodes of no element, or at"
            " faces that look along x; one contact pair is read, with a face that looks along y"
            " and the elements in the file"
        )
    return "upper" if material_heights[0] > 0 else "lower"


def _nodes_of_face(mesh: CalculixMesh, touching_rows: Integers) -> tuple[Integers, list[str]]:
    """Rows, in the arrays of the mesh, of the nodes of the slave face, and notes. Of a flat face
    these are all nodes at its y; of a curved one those that touch at some time, `touching_rows`.

    `mesh.material_heights` are how far the material of each node lies above it: their sign tells
    the bodies apart.
    """
    y_of_nodes = mesh.points[:, 1]
    # a millionth of the mesh's longest side
    tolerance = SAME_PLACE_SHARE * longest_side(mesh.points)
    if np.ptp(y_of_nodes[touching_rows]) > tolerance:
        return touching_rows, [
            "the slave face is curved: points that never carry a contact value are left out, and x"
            " is that of the slave's nodes"
        ]
    is_of_same_body = mesh.material_heights * mesh.material_heights[touching_rows[0]] > 0
    is_at_height = np.abs(y_of_nodes - y_of_nodes[touching_rows].mean()) <= tolerance
    return np.flatnonzero(is_at_height & is_of_same_body), []


class _SurfaceValues(NamedTuple):
    """Values at the points of a contact surface, at the times of the file.

    Attributes
    ----------
    x
        (n_points,) in the file's unit of length
    extent_along_z
        extent of the mesh along z in that unit, 0 for a plane mesh
    fields
        pressure, shear and slip, (n_times, n_points) each, in the scene's units and signs
    times
        (n_times,) as the file states them
    """

    x: Array
    extent_along_z: float
    fields: dict[str, Array]
    times: Array


def _surface_result_of(
    path: Path,
    mapping: Mapping,
    code: str,
    surface_values: _SurfaceValues,
    printed_file: DatFile | None,
    notes: list[str],
) -> SurfaceResult:
    """The result of another program in the scene's units, checked and sorted by x, from the values
    on its contact surface.

    Loads are those of the printed .dat file, where there is one. Times are those of the mapping
    where it states them, else those of the file.

    Parameters
    ----------
    code
        name of the program that wrote the file, used where the mapping names none
    surface_values
        x, tractions and slip at the points of the surface, at all times
    printed_file
        the .dat file with the loads; None without one
    notes
        sentences on how the files were read

    # notation: P normal load, Q tangential load
    """
    series: dict[str, ArrayLike | None] = {}
    load_notes: list[str] = []
    if printed_file is not None:
        # P and Q per thickness, at the times of the surface values
        loads, load_notes = _pair_loads(
            printed_file, mapping, surface_values.times, surface_values.extent_along_z
        )
        series |= loads
    if mapping.times is not None:
        series["time"] = stated_times(str(path), mapping, len(surface_values.times))
    else:
        series["time"] = converted_values(mapping, "time", surface_values.times)
    x = converted_values(mapping, "x", surface_values.x)
    return surface_result(
        str(path),
        mapping.code or code,
        x,
        dict(surface_values.fields),
        series,
        [*notes, *load_notes],
    )


def _forces_of_one_pair(file: DatFile, mapping: Mapping) -> list[PairForce]:
    """The resultants of one contact pair in a .dat file, in the order of the file: each with the
    names of both faces, its time, the force (3,) on the slave face and that face's mean normal
    (3,). InputError where there are several contact pairs, of which the mapping names none.
    """
    pair_forces = [
        pair_force
        for pair_force in file.pairs
        if mapping.surface in (None, pair_force.slave, pair_force.master)
    ]
    if len({(pair_force.slave, pair_force.master) for pair_force in pair_forces}) > 1:
        names = ", ".join(sorted({pair_force.slave for pair_force in pair_forces}))
        raise InputError(
            f"{file.path}: several contact pairs (slave faces {names}); name one by surface of a"
            " mapping"
        )
    return pair_forces


def _forces_on_lower_body(pair_forces: Sequence[PairForce], times: Array) -> list[Array]:
    """Force (3,) of a contact pair on the lower body at each of the times for which a .dat file
    states it. The slave face is the lower body's where its normal points up.

    The last force of each time counts. Both files round the time, so that it may differ by 1e-5.
    CalculiX writes 0 and NaN for node-to-surface pairs, touching or not: they state no load.
    """
    finite_forces = [
        pair_force for pair_force in reversed(pair_forces) if np.isfinite(pair_force.normal).all()
    ]
    forces_on_lower = []
    for time in times:
        for pair_force in finite_forces:
            if np.isclose(pair_force.time, time, rtol=1e-5, atol=0.0):
                slave_is_lower = pair_force.normal[1] > 0
                forces_on_lower.append(pair_force.force if slave_is_lower else -pair_force.force)
                break
    return forces_on_lower


def _pair_loads(
    file: DatFile, mapping: Mapping, times: Array, extent_along_z: float
) -> tuple[dict[str, Array], list[str]]:
    """Loads P and Q by name, (n_times,) each [force/thickness], from the total force on the one
    contact pair in a .dat file; and notes. No loads where the file lacks the force of some time;
    InputError for several contact pairs of which the mapping names none.

    P and Q are the force of the upper body on the lower one, P positive in compression.
    `extent_along_z` is the extent of the mesh along z, 0 for a plane mesh; it is the thickness
    where the mapping states none.
    """
    pair_forces = _forces_of_one_pair(file, mapping)
    forces_on_lower = _forces_on_lower_body(pair_forces, times)
    if len(forces_on_lower) < len(times):
        note = (
            f"{file.path.name} states the pair's resultant at {len(forces_on_lower)} of"
            f" {len(times)} times: not used"
        )
        return {}, [note] if pair_forces else []

    force_on_lower = np.array(forces_on_lower)
    thickness_source = "mapping"
    mesh_thickness = 1.0  # `converted_values` divides by the thickness of the mapping
    if extent_along_z > 0 and "thickness" not in mapping.model_fields_set:
        thickness_source = "mesh"
        mesh_thickness = extent_along_z * (mapping.factors.length or 1.0)
    loads = {
        "normal_load": converted_values(
            mapping, "normal_load", -force_on_lower[:, 1] / mesh_thickness
        ),
        "tangential_load": converted_values(
            mapping, "tangential_load", force_on_lower[:, 0] / mesh_thickness
        ),
    }
    note = (
        f"loads are the resultants of the contact pair in {file.path.name}, divided by the"
        f" {thickness_source}'s thickness, {mesh_thickness * mapping.thickness:g}"
    )
    return loads, [note]
