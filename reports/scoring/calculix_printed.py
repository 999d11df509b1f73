"""Tractions on the contact surface of CalculiX' printed file .dat (*CONTACT PRINT); places come from the .frd file beside it.

Node-to-surface pairs are printed node by node. Surface-to-surface pairs are printed at integration points of slave faces without
place or weight: of them the plain mean of each face stands at its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reports.scoring.calculix_dat import DatTable, read_dat
from reports.scoring.calculix_frd import read_frd
from reports.scoring.calculix_mesh import CalculixMesh
from reports.scoring.calculix_surface import SLIP_NOTE, body_of_face, pair_loads, sign_and_factor, times_in
from reports.scoring.mapping import Mapping, converted
from reports.scoring.resultants import tension, unbalanced
from reports.scoring.surface import SurfaceResult
from reports.scoring.surface_nodes import material_above, one_plane
from reports.scoring.tidying import surface_result
from scenes import InputError, Scene

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_STRESS, _SLIP = "contact stress", "relative contact displacement"


@dataclass(frozen=True, eq=False)
class _Places:
    """Nodes or faces that carry contact values, ascending in x, and the body whose face they are."""

    keys: tuple[tuple[int, ...], ...]
    x: Array
    body: str
    depth: float
    notes: tuple[str, ...]


def read(path: Path, mapping: Mapping, scene: Scene) -> SurfaceResult:  # noqa: ARG001 (the readers' common signature)
    """The contact stresses of every time in the file; loads from the resultants of the pair where it has them (CF).

    Raises
    ------
    InputError
        File and what is wrong: see `read_dat`; no contact stress in it; no .frd beside it; a node or element that is not there.
    """
    printed = read_dat(path)
    stress, slip = ({table.time: table for table in printed.tables if table.what == name} for name in (_STRESS, _SLIP))
    if not any(len(table.ids) for table in stress.values()):
        raise InputError(f"{path}: no contact stress is printed in it (*CONTACT PRINT with CSTR in the deck)")
    places = _places(path, list(stress.values()))
    values = [_filled(places, table) for table in stress.values()]
    fields: dict[str, Array] = {
        "pressure": converted(mapping, "pressure", np.array([v[:, 0] for v in values])),
        "shear": np.array([v[:, 1] for v in values]) * sign_and_factor(mapping, "shear", places.body),
    }
    notes = [f"contact values stand at the slave face, that of the {places.body} body", *places.notes, *tension(fields["pressure"])]
    if set(slip) >= set(stress):
        moved = np.array([_filled(places, slip[time])[:, 1] for time in stress])
        fields["slip"] = moved * sign_and_factor(mapping, "slip", places.body)
        notes.append(SLIP_NOTE)
    times = np.array(list(stress))
    series = {"time": times_in(path, mapping, times)}
    loads, said = pair_loads(printed, mapping, times, places.depth)
    series |= loads
    notes += said
    x = converted(mapping, "x", places.x)
    notes += unbalanced(x, fields["pressure"], series.get("normal_load"))
    return surface_result(str(path), mapping.code or "CalculiX", x, dict(fields), dict(series), notes)


def _places(path: Path, tables: Sequence[DatTable]) -> _Places:
    beside = path.with_suffix(".frd")
    if not beside.exists():
        raise InputError(
            f"{path}: a .dat file states no places, and there is no {beside.name} beside it to take them from; copy it there"
        )
    mesh = CalculixMesh.of(read_frd(beside, ()))
    kinds = {table.ids.shape[1] for table in tables if len(table.ids)}
    if len(kinds) > 1:
        raise InputError(
            f"{path}: contact stress of nodes and of element faces in one file; print one contact pair (mapping's surface)"
        )
    keys = np.unique(np.concatenate([table.ids for table in tables if len(table.ids)]), axis=0)
    found = _nodes(path, mesh, keys[:, 0]) if kinds == {1} else _faces(path, mesh, keys)
    return replace(found, notes=(*found.notes, *mesh.inside_out()))


def _nodes(path: Path, mesh: CalculixMesh, nodes: Integers) -> _Places:
    rows = mesh.rows(nodes)
    plane = one_plane(mesh.points, rows)
    body = body_of_face(path, material_above(mesh.points, mesh.cells)[rows])
    return _Places(tuple((int(mesh.numbers[row]),) for row in plane.rows), plane.x, body, _depth(mesh), plane.notes)


def _faces(path: Path, mesh: CalculixMesh, keys: Integers) -> _Places:
    found = [mesh.face(int(element), int(face)) for element, face in keys]
    middles = np.array([middle for middle, _, _ in found])
    plane = one_plane(middles, np.arange(len(keys)))
    body = body_of_face(path, np.array([above for _, _, above in found]))
    note = "CalculiX prints integration points of faces without place or weight: the plain mean of each face stands at its middle"
    own = tuple((int(keys[k, 0]), int(keys[k, 1])) for k in plane.rows)
    return _Places(own, plane.x, body, _depth(mesh), (note, *plane.notes))


def _depth(mesh: CalculixMesh) -> float:
    return float(np.ptp(mesh.points[:, 2]))


def _filled(places: _Places, table: DatTable) -> Array:
    """(n_points, 3) of a table: the mean of the rows of each node or face; 0 where it has none."""
    at = {key: k for k, key in enumerate(places.keys)}
    rows = np.array([at.get(tuple(ids), -1) for ids in table.ids.tolist()], np.int64)
    total, count = np.zeros((len(at), table.values.shape[1])), np.zeros(len(at))
    np.add.at(total, rows[rows >= 0], table.values[rows >= 0])
    np.add.at(count, rows[rows >= 0], 1.0)
    return np.asarray(total / np.maximum(count, 1.0)[:, None])
