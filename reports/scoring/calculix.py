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
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reports.scoring.calculix_files import DatFile, DatTable, FrdBlock, FrdFile, read_dat, read_frd
from reports.scoring.mapping import Mapping, converted, stated_times
from reports.scoring.surface import (
    SAME,
    SurfaceResult,
    extent,
    material_above,
    one_plane,
    surface_result,
)
from scenes import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

# Of the blocks that tractions are read from: quantities, and the components that they are.
_Quantity = Literal["pressure", "shear", "slip"]
_COMPONENTS: dict[str, dict[_Quantity, str]] = {
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
    """The mesh of a .frd file, with rows in place of node numbers.

    Attributes
    ----------
    numbers, points
        (n_nodes,) ascending, (n_nodes, 3) [length]
    above
        (n_nodes,) how far the material of each node lies above it, see `material_above`
    """

    def __init__(self, file: FrdFile) -> None:
        self.path, order = file.path, np.argsort(file.nodes)
        self.numbers, self.points = file.nodes[order], file.points[order]
        self._elements = {element.number: element for element in file.elements}
        alike: dict[int, list[tuple[int, ...]]] = {}  # by the count of their nodes
        for element in file.elements:
            alike.setdefault(len(element.nodes), []).append(element.nodes)
        self.above = material_above(
            self.points, [self.rows(np.array(nodes, np.int64)) for nodes in alike.values()]
        )

    def rows(self, nodes: Integers) -> Integers:
        """Rows of node numbers of any shape; InputError for a node without coordinates."""
        at = np.minimum(np.searchsorted(self.numbers, nodes), len(self.numbers) - 1)
        strange = np.asarray(nodes)[self.numbers[at] != nodes]
        if len(strange):
            raise InputError(
                f"{self.path}: node {strange[0]} has a result or an element and no coordinates"
                " (CalculiX numbers the nodes of plane elements again); write *NODE FILE,"
                " OUTPUT=3D in the deck and run it again"
            )
        return np.asarray(at, np.int64)

    def face(self, element: int, face: int) -> tuple[Array, float]:
        """Middle of an element's face (3,), and how far the element's middle lies above it
        [length].
        """
        found = self._elements.get(element)
        corners = _FACES.get(found.kind, {}).get(face) if found else None
        if found is None or corners is None:
            what = f"element {element} " + (
                f"of kind {found.kind} has no face {face}" if found else "is not in it"
            )
            raise InputError(
                f"{self.path}: {what}; it must be of the same run as the .dat file, with *NODE FILE"
                " and *EL FILE"
            )
        rows = self.rows(np.array(found.nodes))
        middle = self.points[rows[list(corners)]].mean(axis=0)
        return middle, float(self.points[rows, 1].mean() - middle[1])

    def scattered(self, block: FrdBlock, name: str) -> Array:
        """(n_nodes,) of a component; 0 where the block has no record."""
        values = np.zeros(len(self.numbers))
        values[self.rows(block.nodes)] = block.column(name)
        return values


def read_results(path: Path, mapping: Mapping) -> SurfaceResult:
    """The tractions in a .frd file, from its CONTACT blocks; where there are none, from its stress
    at the lower body's face.

    Loads are the resultants of the contact pair (*CONTACT PRINT, CF) where a .dat file of the same
    name beside it has them.

    Raises
    ------
    InputError
        File and what is wrong: see `read_frd` and `read_dat`; no contact results and no stress;
        nodes without coordinates.
    """
    file = read_frd(path, ("CONTACT",), instead=("STRESS",))
    if not file.blocks:
        raise InputError(
            f"{path}: no block CONTACT and none STRESS; it has {', '.join(file.names) or 'none'}:"
            " add *CONTACT FILE (DISP and FORC alone are what CalculiX leaves of a run whose first"
            " increment did not converge)"
        )
    mesh, kind = CalculixMesh(file), file.blocks[0].name
    names = _COMPONENTS[kind]
    blocks, notes = _one_block_a_time(
        file, list(names.values()), "stress" if kind == "STRESS" else "contact values"
    )
    if kind == "STRESS":  # p = -SYY and q = SXY: the traction on the lower body's outward normal +y
        height, factor = (
            mesh.points[:, 1] - mapping.y_offset / (mapping.factors.length or 1.0),
            mapping.factors.stress or 1.0,
        )
        face = np.flatnonzero((np.abs(height) <= SAME * extent(mesh.points)) & (mesh.above < 0))
        if not len(face):
            raise InputError(
                f"{path}: no node of a lower body's face at y = {mapping.y_offset:g}; say where it"
                " lies by y_offset of a mapping"
            )
        factors: dict[_Quantity, float] = {"pressure": -factor, "shear": factor}
        notes = [
            (
                "no contact values in the file (*CONTACT FILE): p = -SYY and q = SXY of the lower"
                " body at its face, outward normal +y; stress extrapolated to the nodes is coarser"
                " than the contact values"
            ),
            *notes,
        ]
    else:
        for block in file.blocks:  # whatever is not 0 counts as touched: a NaN would
            if not np.isfinite(block.values).all():
                raise InputError(
                    f"{path}: line {block.line}: block CONTACT holds numbers that are not finite"
                )
        touched = np.unique(
            np.concatenate(
                [mesh.rows(block.nodes[np.any(block.values != 0, axis=1)]) for block in blocks]
            )
        )
        if not len(touched):
            raise InputError(
                f"{path}: every contact value is 0 at every instant: the bodies do not touch in"
                " this result"
            )
        body = _body_of_face(path, mesh.above[touched])
        face, curved = _whole_face(mesh, touched)
        factors = {quantity: _factor(mapping, quantity, body) for quantity in names}
        notes += [
            f"contact values stand at the slave face, that of the {body} body",
            _SLIP_NOTE,
            *curved,
        ]
    if not file.ended:
        notes.append(
            "the file has no end (9999): the run goes on or was stopped, and later instants are"
            " missing"
        )
    rows, depth, planes = one_plane(mesh.points, face)
    fields: dict[str, Array] = {
        q: factors[q] * np.array([mesh.scattered(block, name)[rows] for block in blocks])
        for q, name in names.items()
    }
    beside, times = path.with_suffix(".dat"), np.array([block.time for block in blocks])
    printed = read_dat(beside) if beside.exists() and beside.stat().st_size else None
    return _result(
        path,
        mapping,
        file.version,
        (mesh.points[rows, 0], depth),
        fields,
        times,
        printed,
        [*notes, *planes],
    )


def read_printed(path: Path, mapping: Mapping) -> SurfaceResult:
    """The contact stresses of every time in a .dat file; loads from the resultants of the pair
    where it has them (CF).

    Raises
    ------
    InputError
        File and what is wrong: see `read_dat`; no contact stress in it; no .frd beside it; a node
        or element that is not there.
    """
    printed = read_dat(path)
    stress = {table.time: table for table in printed.tables if table.what == "contact stress"}
    slip = {
        table.time: table
        for table in printed.tables
        if table.what == "relative contact displacement"
    }
    filled = [table for table in stress.values() if len(table.ids)]
    if not filled:
        raise InputError(
            f"{path}: no contact stress is printed in it (*CONTACT PRINT with CSTR in the deck)"
        )
    beside = path.with_suffix(".frd")
    if not beside.exists():
        raise InputError(
            f"{path}: a .dat file states no places, and there is no {beside.name} beside it to take"
            " them from; copy it there"
        )
    mesh = CalculixMesh(read_frd(beside, ()))
    if len({table.ids.shape[1] for table in filled}) > 1:
        raise InputError(
            f"{path}: contact stress of nodes and of element faces in one file; print one contact"
            " pair (mapping's surface)"
        )
    keys = np.unique(np.concatenate([table.ids for table in filled]), axis=0)
    notes = []
    if keys.shape[1] == 1:
        at = mesh.rows(keys[:, 0])
        places, above = mesh.points[at], mesh.above[at]
    else:
        faces = [mesh.face(int(element), int(face)) for element, face in keys]
        places, above = (
            np.array([middle for middle, _ in faces]),
            np.array([height for _, height in faces]),
        )
        notes = [
            "CalculiX prints integration points of faces without place or weight: the plain mean of"
            " each face stands at its middle"
        ]
    body = _body_of_face(path, above)
    rows, _, more = one_plane(places, np.arange(len(keys)))
    notes = [f"contact values stand at the slave face, that of the {body} body", *notes, *more]

    def column(tables: Sequence[DatTable], k: int, quantity: _Quantity) -> Array:
        """(n_times, n_points): the mean of the rows of each node or face; 0 where a table has
        none.
        """
        means = np.zeros((len(tables), len(rows)))
        for mean, table in zip(means, tables, strict=True):
            values = dict[tuple[int, ...], list[float]]()
            for ids, value in zip(
                map(tuple, table.ids.tolist()), table.values[:, k].tolist(), strict=True
            ):
                values.setdefault(ids, []).append(value)
            mean[:] = [np.mean(values.get(tuple(key), 0.0)) for key in keys[rows].tolist()]
        return _factor(mapping, quantity, body) * means

    tables = [*stress.values()]
    fields = {"pressure": column(tables, 0, "pressure"), "shear": column(tables, 1, "shear")}
    if set(slip) >= set(stress):
        fields["slip"] = column([slip[time] for time in stress], 1, "slip")
        notes.append(_SLIP_NOTE)
    depth = float(np.ptp(mesh.points[:, 2]))
    return _result(
        path,
        mapping,
        "CalculiX",
        (places[rows, 0], depth),
        fields,
        np.array([*stress]),
        printed,
        notes,
    )


def _factor(mapping: Mapping, quantity: _Quantity, body: str) -> float:
    """Unit factor and sign: the mapping's sign where it states one, else that of the slave face,
    which is part of `body`.
    """
    one = float(converted(mapping, quantity, np.ones(1))[0])
    stated = quantity == "pressure" or getattr(mapping.signs, quantity) is not None
    return one if stated or body == "upper" else -one


def _one_block_a_time(
    file: FrdFile, wanted: Sequence[str], what: str
) -> tuple[list[FrdBlock], list[str]]:
    """The last block of each time, of which all hold the components `wanted`; frames without one
    and doubles are named.
    """
    for block in file.blocks:
        if missing := [name for name in wanted if name not in block.components]:
            raise InputError(
                f"{file.path}: line {block.line}: block {block.name} has no {missing[0]}; it needs"
                f" {', '.join(wanted)}"
            )
    last = {block.time: block for block in file.blocks}
    notes = []
    if without := [time for time in file.times if time not in last]:
        notes.append(
            f"left out: {len(without)} frames without {what} (first at time {without[0]:.6g});"
            " CalculiX writes such a frame of an increment that did not converge"
        )
    if len(last) < len(file.blocks):
        notes.append(
            f"{len(file.blocks) - len(last)} blocks of {what} share a time with a later one, which"
            " was taken"
        )
    return list(last.values()), notes


def _body_of_face(path: Path, above: Array) -> str:
    """Whose face carries contact values, by how far its material lies `above` each of its places;
    InputError for two faces.
    """
    if np.all(above > 0) == np.all(above < 0):
        raise InputError(
            f"{path}: contact values stand at nodes of both bodies, at nodes of no element, or at"
            " faces that look along x; one contact pair is read, with a face that looks along y"
            " and the elements in the file"
        )
    return "upper" if above[0] > 0 else "lower"


def _whole_face(mesh: CalculixMesh, touched: Integers) -> tuple[Integers, list[str]]:
    """The nodes that ever carry a value and, where the face is flat, the rest of it."""
    height, tolerance = mesh.points[:, 1], SAME * extent(mesh.points)
    if np.ptp(height[touched]) > tolerance:
        return touched, [
            "the slave face is curved: points that never carry a contact value are left out, and x"
            " is that of the slave's nodes"
        ]
    same_side = mesh.above * mesh.above[touched[0]] > 0
    return np.flatnonzero((np.abs(height - height[touched].mean()) <= tolerance) & same_side), []


def _result(
    path: Path,
    mapping: Mapping,
    code: str,
    place: tuple[Array, float],
    fields: dict[str, Array],
    times: Array,
    printed: DatFile | None,
    notes: list[str],
) -> SurfaceResult:
    """Times and loads added; everything checked and sorted. `place`: x of the points, and the depth
    of the mesh.
    """
    x, depth = converted(mapping, "x", place[0]), place[1]
    loads, said = _pair_loads(printed, mapping, times, depth) if printed else ({}, [])
    time = (
        stated_times(str(path), mapping, len(times))
        if mapping.times is not None
        else converted(mapping, "time", times)
    )
    return surface_result(
        str(path), mapping.code or code, x, dict(fields), {"time": time, **loads}, [*notes, *said]
    )


def _pair_loads(
    file: DatFile, mapping: Mapping, times: Array, depth: float
) -> tuple[dict[str, Array], list[str]]:
    """P and Q (n_times,) of the one contact pair, and what was done to them; nothing where a time
    has no resultant.

    They are what the upper body does to the lower; the file states the force on the slave face,
    which is the lower body's where its normal looks up. `depth` is the thickness of the mesh, 0
    where it is a plane one: it counts where the mapping states none.
    """
    pairs = [pair for pair in file.pairs if mapping.surface in (None, pair.slave, pair.master)]
    if len({(pair.slave, pair.master) for pair in pairs}) > 1:
        names = ", ".join(sorted({pair.slave for pair in pairs}))
        raise InputError(
            f"{file.path}: several contact pairs (slave faces {names}); name one by surface of a"
            " mapping"
        )
    # The last of each time, which the two files round differently. CalculiX writes 0 and NaN for
    # node-to-surface pairs, touching or not: no statement on the loads.
    known = [pair for pair in reversed(pairs) if np.isfinite(pair.normal).all()]
    stated = [
        found
        for t in times
        if (
            found := next(
                (one for one in known if np.isclose(one.time, t, rtol=1e-5, atol=0.0)), None
            )
        )
    ]
    if len(stated) < len(times):
        words = (
            f"{file.path.name} states the pair's resultant at {len(stated)} of {len(times)} times:"
            " not used"
        )
        return {}, [words] if pairs else []
    on_lower = np.array([pair.force if pair.normal[1] > 0 else -pair.force for pair in stated])
    of_mesh = depth > 0 and "thickness" not in mapping.model_fields_set
    thickness = depth * (mapping.factors.length or 1.0) if of_mesh else 1.0
    said = (
        f"divided by the {'mesh' if of_mesh else 'mapping'}'s thickness,"
        f" {thickness * mapping.thickness:g}"
    )
    return {
        "normal_load": converted(mapping, "normal_load", -on_lower[:, 1] / thickness),
        "tangential_load": converted(mapping, "tangential_load", on_lower[:, 0] / thickness),
    }, [f"loads are the resultants of the contact pair in {file.path.name}, {said}"]
