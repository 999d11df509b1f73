"""Tractions on the contact surface of what CalculiX wrote: .frd with *CONTACT FILE, else its stress; .dat with *CONTACT PRINT.

CalculiX stores contact results at the slave face. CPRESS is positive in compression. CSHEAR1 and CSLIP1 count along the projection
of the x axis on the face, both as slave relative to master: measured on decks with either body as slave, where the tractions add up
to the load (tests/data/README.md). So with the lower body as slave our shear and slip (upper over lower) have the other sign, and
with the upper body as slave the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reports.scoring.calculix_dat import DatFile, PairForce, read_dat
from reports.scoring.calculix_frd import FrdBlock, FrdFile, read_frd
from reports.scoring.calculix_mesh import CalculixMesh
from reports.scoring.mapping import Mapping, converted, stated_times
from reports.scoring.resultants import free_face, tension, unbalanced
from reports.scoring.surface import SurfaceResult
from reports.scoring.surface_nodes import SAME, Plane, body_of, extent, material_above, one_plane
from reports.scoring.tidying import surface_result
from scenes import InputError, Scene

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_WANTED = ("COPEN", "CSLIP1", "CPRESS", "CSHEAR1")
_STRESSES = ("SYY", "SXY")
SLIP_NOTE = "CalculiX' slip holds the elastic slip of its stick stiffness and is 0 at points that are open"


def read(path: Path, mapping: Mapping, scene: Scene) -> SurfaceResult:  # noqa: ARG001 (the readers' common signature)
    """The tractions in a .frd file, from its CONTACT blocks; where there are none, from its stress at the lower body's face.

    Loads are the resultants of the contact pair (*CONTACT PRINT, CF) where a .dat file of the same name beside it has them.

    Raises
    ------
    InputError
        File and what is wrong: see `read_frd` and `read_dat`; no contact results and no stress; nodes without coordinates.
    """
    file = read_frd(path, ("CONTACT",), instead=("STRESS",))
    if not file.blocks or file.blocks[0].name == "STRESS":
        return _from_stress(path, mapping, file)
    mesh = CalculixMesh.of(file)
    blocks, notes = _one_block_a_time(file, _WANTED, "contact values")
    _refuse_not_finite(file)
    slave = _slave(path, mesh, blocks)
    notes += [f"contact values stand at the slave face, that of the {slave.body} body", SLIP_NOTE, *slave.plane.notes, *slave.notes]
    notes += mesh.inside_out()
    columns = {name: np.array([_scattered(mesh, block, name)[slave.plane.rows] for block in blocks]) for name in _WANTED[1:]}
    notes += tension(columns["CPRESS"])
    fields = {
        "pressure": converted(mapping, "pressure", columns["CPRESS"]),
        "shear": columns["CSHEAR1"] * sign_and_factor(mapping, "shear", slave.body),
        "slip": columns["CSLIP1"] * sign_and_factor(mapping, "slip", slave.body),
    }
    return _result(path, mapping, file, slave.plane, fields, np.array([block.time for block in blocks]), notes)


def sign_and_factor(mapping: Mapping, quantity: Literal["shear", "slip"], body: str) -> float:
    """Unit factor and sign: the mapping's sign where it states one, else that of the slave face, which is part of `body`."""
    one = float(converted(mapping, quantity, np.ones(1))[0])
    stated = getattr(mapping.signs, quantity) is not None
    return one if stated or body == "upper" else -one


@dataclass(frozen=True, eq=False)
class _Slave:
    """The slave face: its points in one plane, which body it belongs to, and what was done to find it."""

    plane: Plane
    body: str
    notes: tuple[str, ...]


def _one_block_a_time(file: FrdFile, wanted: tuple[str, ...], what: str) -> tuple[list[FrdBlock], list[str]]:
    """The last block of each time, of which all hold the components `wanted`; frames without one and doubles are named."""
    for block in file.blocks:
        if missing := [name for name in wanted if name not in block.components]:
            raise InputError(
                f"{file.path}: line {block.line}: block {block.name} has no {missing[0]}; it needs {', '.join(wanted)}"
            )
    last = {block.time: block for block in file.blocks}
    notes = []
    if without := [time for time in file.times if time not in last]:
        notes.append(
            f"left out: {len(without)} frames without {what} (first at time {without[0]:.6g}); CalculiX writes "
            "such a frame of an increment that did not converge"
        )
    if len(last) < len(file.blocks):
        notes.append(f"{len(file.blocks) - len(last)} blocks of {what} share a time with a later one, which was taken")
    return list(last.values()), notes


def _refuse_not_finite(file: FrdFile) -> None:
    """Whatever is not 0 in a block counts as touched: a NaN would."""
    for block in file.blocks:
        if not np.isfinite(block.values).all():
            raise InputError(f"{file.path}: line {block.line}: block {block.name} holds numbers that are not finite")


def _slave(path: Path, mesh: CalculixMesh, blocks: list[FrdBlock]) -> _Slave:
    touched = np.unique(np.concatenate([mesh.rows(block.nodes[np.any(block.values != 0, axis=1)]) for block in blocks]))
    if not len(touched):
        raise InputError(f"{path}: every contact value is 0 at every instant: the bodies do not touch in this result")
    body = body_of_face(path, material_above(mesh.points, mesh.cells)[touched])
    rows, notes = _whole_face(mesh, touched)
    return _Slave(one_plane(mesh.points, rows), body, notes)


def body_of_face(path: Path, above: Array) -> Literal["lower", "upper"]:
    """Whose face carries contact values, by how far its material lies `above` each of its places; InputError for two faces."""
    if np.all(above > 0) == np.all(above < 0):
        raise InputError(
            f"{path}: contact values stand at nodes of both bodies, at nodes of no element, or at faces that look along x; one "
            "contact pair is read, with a face that looks along y and the elements in the file"
        )
    return "upper" if above[0] > 0 else "lower"


def _whole_face(mesh: CalculixMesh, touched: Integers) -> tuple[Integers, tuple[str, ...]]:
    """The nodes that ever carry a value and, where the face is flat, the rest of it."""
    height, tolerance = mesh.points[:, 1], SAME * extent(mesh.points)
    if np.ptp(height[touched]) > tolerance:
        return touched, (
            "the slave face is curved: points that never carry a contact value are left out, and x is that of the slave's nodes",
        )
    body = body_of(len(height), mesh.cells)
    level = height[touched].mean()
    flat = np.flatnonzero((np.abs(height - level) <= tolerance) & (body == body[touched[0]]))
    return flat, ()


def _scattered(mesh: CalculixMesh, block: FrdBlock, name: str) -> Array:
    """(n_nodes,) of the mesh; 0 where the block has no record."""
    values = np.zeros(len(mesh.numbers))
    values[mesh.rows(block.nodes)] = block.column(name)
    return values


def _from_stress(path: Path, mapping: Mapping, file: FrdFile) -> SurfaceResult:
    """p = -SYY and q = SXY at the lower body's face: the traction on its outward normal +y."""
    if not file.blocks:
        raise InputError(
            f"{path}: no block CONTACT and none STRESS; it has {', '.join(file.names) or 'none'}: add *CONTACT FILE "
            "(DISP and FORC alone are what CalculiX leaves of a run whose first increment did not converge)"
        )
    mesh = CalculixMesh.of(file)
    points = mesh.points
    height = points[:, 1] - mapping.y_offset / (mapping.factors.length or 1.0)
    near = np.abs(height) <= SAME * extent(points)
    rows = np.flatnonzero(near & (material_above(points, mesh.cells) < 0))
    if not len(rows):
        raise InputError(
            f"{path}: no node of a lower body's face at y = {mapping.y_offset:g}; say where it lies by y_offset of a mapping"
        )
    plane = one_plane(points, rows)
    blocks, left_out = _one_block_a_time(file, _STRESSES, "stress")
    stress = {name: np.array([_scattered(mesh, block, name)[plane.rows] for block in blocks]) for name in _STRESSES}
    factor = mapping.factors.stress or 1.0
    notes = [
        "no contact values in the file (*CONTACT FILE): p = -SYY and q = SXY of the lower body at its face, outward normal +y; "
        "stress extrapolated to the nodes is coarser than the contact values",
        *plane.notes,
        *left_out,
        *mesh.inside_out(),
    ]
    fields = {"pressure": -factor * stress["SYY"], "shear": factor * stress["SXY"]}
    notes += free_face(plane.x, fields["pressure"], fields["shear"])
    return _result(path, mapping, file, plane, fields, np.array([block.time for block in blocks]), notes)


def _result(
    path: Path, mapping: Mapping, file: FrdFile, plane: Plane, fields: dict[str, Array], times: Array, notes: list[str]
) -> SurfaceResult:
    """Times and loads added; everything checked and sorted."""
    series = {"time": times_in(path, mapping, times)}
    loads, said = _loads(path, mapping, times, plane.depth)
    series |= loads
    notes = [*notes, *said]
    if not file.ended:
        notes.append("the file has no end (9999): the run goes on or was stopped, and later instants are missing")
    x = converted(mapping, "x", plane.x)
    notes = [*notes, *unbalanced(x, fields["pressure"], series.get("normal_load"))]
    return surface_result(str(path), mapping.code or file.version, x, dict(fields), dict(series), notes)


def times_in(path: Path, mapping: Mapping, times: Array) -> Array:
    """Times of the scene's load path: the mapping's, else the file's."""
    return stated_times(str(path), mapping, len(times)) if mapping.times is not None else converted(mapping, "time", times)


def _loads(path: Path, mapping: Mapping, times: Array, depth: float) -> tuple[dict[str, Array], list[str]]:
    """P and Q from the .dat file beside it, where there is one."""
    beside = path.with_suffix(".dat")
    if not beside.exists() or not beside.stat().st_size:
        return {}, []
    return pair_loads(read_dat(beside), mapping, times, depth)


def pair_loads(file: DatFile, mapping: Mapping, times: Array, depth: float) -> tuple[dict[str, Array], list[str]]:
    """P and Q (n_times,) of the one contact pair, and what was done to them; nothing where a time has no resultant.

    They are what the upper body does to the lower; the file states the force on the slave face, which is the lower body's where its
    normal looks up. `depth` is the thickness of the mesh, 0 where it is a plane one: it counts where the mapping states none.
    """
    pairs = [pair for pair in file.pairs if mapping.surface in (None, pair.slave, pair.master)]
    if len({(pair.slave, pair.master) for pair in pairs}) > 1:
        names = ", ".join(sorted({pair.slave for pair in pairs}))
        raise InputError(f"{file.path}: several contact pairs (slave faces {names}); name one by surface of a mapping")
    found = [_at(pairs, time) for time in times]
    # CalculiX writes 0 and NaN for node-to-surface pairs, touching or not: no statement on the loads.
    stated = [pair for pair in found if pair is not None and np.isfinite(pair.normal).all()]
    on_lower = np.array([pair.force if pair.normal[1] > 0 else -pair.force for pair in stated])
    if len(stated) < len(times):
        return {}, [
            f"{file.path.name} states the pair's resultant at {len(stated)} of {len(times)} times: not used"
        ] if pairs else []
    of_mesh = depth > 0 and "thickness" not in mapping.model_fields_set
    thickness = depth * (mapping.factors.length or 1.0) if of_mesh else 1.0
    normal, tangential = (-on_lower[:, 1] / thickness, on_lower[:, 0] / thickness)
    said = f"divided by the {'mesh' if of_mesh else 'mapping'}'s thickness, {thickness * mapping.thickness:g}"
    return {
        "normal_load": converted(mapping, "normal_load", normal),
        "tangential_load": converted(mapping, "tangential_load", tangential),
    }, [f"loads are the resultants of the contact pair in {file.path.name}, {said}"]


def _at(pairs: list[PairForce], time: float) -> PairForce | None:
    """The last of that time; the two files round it differently."""
    return next((pair for pair in reversed(pairs) if np.isclose(pair.time, time, rtol=1e-5, atol=0.0)), None)
