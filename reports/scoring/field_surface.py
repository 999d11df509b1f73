"""Where the contact surface lies in a field file: what the mapping marks, else the whole of a path, else the lower body's face."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from meshes import FieldPart
from reports.scoring.mapping import Mapping, listed
from reports.scoring.surface_nodes import SAME, extent, material_above, one_plane
from scenes import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

# Kinds by how they begin; what is neither is a solid.
_LINES, _PLANES = ("vertex", "line"), ("triangle", "quad", "polygon")


@dataclass(frozen=True, eq=False)
class FieldSurface:
    """Points or cells of the surface in one plane, ascending in x.

    Attributes
    ----------
    rows : (n_points,), which points of the file, or which of its cells counted through all blocks
    x : (n_points,) [length]
    body : whose face it is
    notes : how it was found
    """

    rows: Integers
    x: Array
    body: Literal["lower", "upper"]
    notes: tuple[str, ...]


def surface_points(path: Path, mesh: FieldPart, mapping: Mapping) -> FieldSurface:
    """Points of the surface; InputError where there are none, or of both bodies."""
    chosen, notes = _chosen_points(path, mesh, mapping)
    chosen, body, more = _one_body(mesh, chosen)
    plane = one_plane(mesh.points, chosen)
    return FieldSurface(plane.rows, plane.x, body, (*notes, *more, *plane.notes))


def surface_cells(path: Path, mesh: FieldPart, mapping: Mapping) -> FieldSurface:
    """Cells all of whose points are points of the surface, or that the mapping marks; each stands at its middle."""
    marked = _mark(path, mesh.cell_fields, mapping) if mapping.surface is not None else None
    if marked is not None:
        rows = np.flatnonzero(np.concatenate(marked))
        on_face = np.ones(len(mesh.points), bool)
    else:
        on_face = np.zeros(len(mesh.points), bool)
        on_face[_chosen_points(path, mesh, mapping)[0]] = True
        rows = np.flatnonzero(np.concatenate([np.all(on_face[block], axis=1) for _, block in mesh.cells]))
    if not len(rows):
        raise InputError(
            f"{path}: pressure is a field of cells, and no cell lies in the surface; average it to points "
            "(ParaView: Cell Data to Point Data) or mark the cells of the surface (surface of a mapping)"
        )
    middles = np.concatenate([mesh.points[block].mean(axis=1) for _, block in mesh.cells])
    plane = one_plane(middles, rows)
    return FieldSurface(plane.rows, plane.x, "lower", plane.notes)


def _chosen_points(path: Path, mesh: FieldPart, mapping: Mapping) -> tuple[Integers, tuple[str, ...]]:
    """Rows of points, and how they were found."""
    if mapping.surface is not None:
        return _marked_points(path, mesh, mapping), (f"the surface is what {mapping.surface} marks",)
    height = mesh.points[:, 1] - mapping.y_offset / (mapping.factors.length or 1.0)
    tolerance = SAME * extent(mesh.points)
    if np.ptp(height) <= tolerance or not _bulk(mesh):
        return np.arange(len(height)), (f"{mesh.name} is taken for the surface alone, since it has no cells of a body",)
    at_face = np.abs(height) <= tolerance
    above = material_above(mesh.points, _bulk(mesh))
    for side, note in ((above < 0, "the surface is the lower body's face"), (above > 0, "the surface is the upper body's face")):
        if len(rows := np.flatnonzero(at_face & side)):
            return rows, (f"{note}, found at y = {mapping.y_offset:g}",)
    raise InputError(
        f"{path}: no point of a face at y = {mapping.y_offset:g} (y goes from {mesh.points[:, 1].min():.6g} to "
        f"{mesh.points[:, 1].max():.6g}); say where it lies by y_offset, or what marks it by surface of a mapping"
    )


def _marked_points(path: Path, mesh: FieldPart, mapping: Mapping) -> Integers:
    """Points that the mapping's marker marks, or points of the cells it marks."""
    name = str(mapping.surface).partition("=")[0]
    if name in mesh.point_fields:
        marked = _mark(path, {key: (values,) for key, values in mesh.point_fields.items()}, mapping)[0]
        rows = np.flatnonzero(marked)
    else:
        flags = _mark(path, mesh.cell_fields, mapping, others=tuple(mesh.point_fields))
        parts = [block[own].ravel() for (_, block), own in zip(mesh.cells, flags, strict=True)]
        rows = np.unique(np.concatenate([np.empty(0, np.int64), *parts]))
    if not len(rows):
        raise InputError(f"{path}: surface = {mapping.surface!r} marks nothing in it")
    return rows


def _mark(path: Path, fields: dict[str, tuple[Array, ...]], mapping: Mapping, others: tuple[str, ...] = ()) -> list[Flags]:
    """For each block what is marked: NAME=VALUE a tag's value; NAME what is not 0 (not -1 where that occurs)."""
    name, equal, value = str(mapping.surface).partition("=")
    if name not in fields:
        known = listed([*others, *fields]) or "none"
        raise InputError(f"{path}: surface = {mapping.surface!r} of the mapping names no field of it ({known}); NAME or NAME=VALUE")
    blocks = fields[name]
    if any(block.ndim != 1 for block in blocks):
        raise InputError(f"{path}: surface = {mapping.surface!r}: {name} is a vector and can't mark a surface")
    if equal:
        try:
            tag = float(value)
        except ValueError as reason:
            raise InputError(f"{path}: surface = {mapping.surface!r}: {value!r} is no number") from reason
        return [block == tag for block in blocks]
    # A set that meshio writes into a VTU is -1 outside and counts from 0 inside.
    none = -1.0 if any(np.any(block == -1) for block in blocks) else 0.0
    return [block != none for block in blocks]


def _bulk(mesh: FieldPart) -> list[Integers]:
    """Cells that fill a body: solids, and in a plane mesh what is no line."""
    deep = np.ptp(mesh.points[:, 2]) > SAME * extent(mesh.points)
    faces = (*_LINES, *_PLANES) if deep else _LINES
    return [block for kind, block in mesh.cells if not kind.startswith(faces)]


def _one_body(mesh: FieldPart, chosen: Integers) -> tuple[Integers, Literal["lower", "upper"], tuple[str, ...]]:
    """Where points of both bodies were chosen: those of the lower one."""
    above = material_above(mesh.points, _bulk(mesh))[chosen]
    if np.any(above < 0) and np.any(above > 0):
        return chosen[above < 0], "lower", ("the surface has points of both bodies: those of the lower one were taken",)
    return chosen, "upper" if np.any(above > 0) else "lower", ()
