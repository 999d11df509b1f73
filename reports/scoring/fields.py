"""Tractions on the contact surface out of field files, VTU, legacy VTK, XDMF and their collections.

They are looked for in this order: pressure and shear by name, at points or at cells of the surface; a vector of contact traction;
the stress, of which p = -sigma_yy and q = sigma_xy are the traction on the lower body's outward normal +y (the upper's normal -y
turns it, and what acts on the lower body turns it again). Of a collection whose files hold different fields, those are read that
hold what is taken, and the others are named.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from meshes import FieldFrame, FieldPart, joined, read_frames
from reports.scoring.mapping import Mapping, Quantity, converted, find_column, listed, stated_times
from reports.scoring.surface import SAME, SurfaceResult, extent, free_face, inside_out, material_above, one_plane, surface_result
from scenes import InputError
from scenes.text_tables import plain

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Where = Literal["point_fields", "cell_fields"]

_VECTORS = ("contact_traction", "contacttractions", "traction", "tractions")
_STRESSES = ("stress", "cauchy_stress", "cauchy_stress_tensor", "stress_tensor", "sigma", "S")
# Where sigma_yy and sigma_xy stand among the components: VTK's order of a symmetric tensor, rows of 3 x 3, Voigt's of the plane.
_YY_XY = {6: (1, 3, "xx, yy, zz, xy, yz, xz"), 9: (4, 1, "rows of 3 x 3"), 3: (1, 2, "xx, yy, xy"), 4: (1, 3, "xx, yy, zz, xy")}
# Kinds of cells by how they begin; what is neither is a solid.
_LINES, _PLANES = ("vertex", "line"), ("triangle", "quad", "polygon")


def read_fields(path: Path, mapping: Mapping) -> SurfaceResult:
    """The tractions of every instant in the file or in what it collects.

    Raises
    ------
    InputError
        File and what is wrong: see `meshes.read_frames`; no tractions under a known name; no surface; a mesh that changes.
    """
    frames = read_frames(path)
    whole = joined(frames[0].parts)
    for k, frame in enumerate(frames[1:], start=2):
        other = joined(frame.parts).points
        if other.shape != whole.points.shape or np.max(np.abs(other - whole.points)) > SAME * extent(whole.points):
            raise InputError(
                f"{path}: the points of instant {k} are not those of the first; give all instants on one undeformed mesh"
            )
    numbers, where, rows, x, components, notes = _source(path, frames[0], mapping)
    taken: dict[str, list[Array]] = {quantity: [] for quantity in components}
    for k, frame in enumerate(frames, start=1):
        try:
            part = joined([frame.parts[number] for number in numbers])
            for quantity, (name, factor) in components.items():
                taken[quantity].append(factor * _component(part, where, name)[rows])
        except (KeyError, IndexError) as reason:
            raise InputError(f"{path}: instant {k} has no field {reason}, which the first one has") from reason
    fields = {quantity: np.array(values) for quantity, values in taken.items()}
    x = converted(mapping, "x", x)
    notes += inside_out(whole.points, whole.cells)
    if "no contact tractions" in notes[0]:
        notes += free_face(x, fields["pressure"], fields["shear"])
    times = [frame.time for frame in frames]
    series = None if None in times else converted(mapping, "time", np.array(times, float))
    if mapping.times is not None:
        series = stated_times(str(path), mapping, len(frames))
    return surface_result(str(path), mapping.code, x, dict(fields), {"time": series}, notes)


_Components = dict[str, tuple[str, float]]
"""Quantity -> the component of a field that it is, and the factor that makes it ours."""


def _source(path: Path, frame: FieldFrame, mapping: Mapping) -> tuple[list[int], Where, Integers, Array, _Components, list[str]]:
    """The first way to tractions that the file offers: parts of an instant, where, rows and x of the surface, components."""
    points = dict(ChainMap(*(part.point_fields for part in frame.parts)))
    cells = dict(ChainMap(*({name: blocks[0] for name, blocks in part.cell_fields.items() if blocks} for part in frame.parts)))
    at_points, at_cells = (
        [n for name, v in fields.items() for n in ([name] if v.ndim == 1 else [f"{name}:{k}" for k in range(v.shape[1])])]
        for fields in (points, cells)
    )
    stated = mapping.columns.pressure or mapping.columns.shear
    if stated is not None:
        where: Where = "cell_fields" if stated not in at_points and stated in at_cells else "point_fields"
        return _named(path, frame, mapping, at_cells if where == "cell_fields" else at_points, where)
    for where, names in (("point_fields", points), ("cell_fields", cells)):
        scalars = [name for name, values in names.items() if values.ndim == 1]
        if find_column(mapping, "pressure", scalars, str(path)) is not None:
            return _named(path, frame, mapping, scalars, where)
    known = [(name, plain(name), values.shape[1]) for name, values in points.items() if values.ndim == 2]
    vector = next((name for name, word, n in known if n >= 2 and word in map(plain, _VECTORS)), None)
    stress = next((name for name, word, n in known if n >= 3 and word in map(plain, _STRESSES)), None)
    name = vector or stress
    if name is None:
        raise InputError(
            f"{path}: neither contact pressure, nor contact traction, nor stress at points among "
            f"{listed([*points, *cells]) or 'no fields'}; name them by columns.pressure and columns.shear of a mapping "
            "(components as 'name:0')"
        )
    numbers, mesh, left_out = _parts_with(path, frame, mapping, [name], "point_fields")
    rows, body, how = _surface_points(path, mesh, mapping)
    factor = mapping.factors.stress or 1.0
    if vector is not None:  # the traction on the lower body is (q, -p), on the upper one (-q, p)
        on_upper = mapping.signs.shear == "on upper" if mapping.signs.shear is not None else body == "upper"
        factor, yy, xy = (-factor if on_upper else factor), 1, 0
        words = f"tractions are the field {name}, taken to act on the {'upper' if on_upper else 'lower'} body"
    else:
        values = mesh.point_fields[name]
        if values.shape[1] not in _YY_XY:
            known_counts = ", ".join(map(str, sorted(_YY_XY)))
            raise InputError(f"{path}: {name} has {values.shape[1]} components, and {known_counts} are understood")
        yy, xy, order = _YY_XY[values.shape[1]]
        if values.shape[1] == 4 and np.any(values[:, 1]) and np.array_equal(values[:, 1], values[:, 2]):
            yy, xy, order = 3, 1, "rows of 2 x 2, since the second and third are equal"
        words = (
            f"no contact tractions in the file: p = -sigma_yy and q = sigma_xy of the {body} body's nodal {name} (components "
            f"{order}), which is extrapolated to the surface and coarser than contact tractions"
        )
    components = {"pressure": (f"{name}:{yy}", -factor), "shear": (f"{name}:{xy}", factor)}
    return numbers, "point_fields", rows, mesh.points[rows, 0], components, [words, *left_out, *how]


def _named(
    path: Path, frame: FieldFrame, mapping: Mapping, names: Sequence[str], where: Where
) -> tuple[list[int], Where, Integers, Array, _Components, list[str]]:
    """Pressure, shear and slip under their names, of points or of cells of the surface."""
    quantities: tuple[Quantity, ...] = ("pressure", "shear", "slip")
    found = {q: find_column(mapping, q, names, str(path), needed=q == "pressure") for q in quantities}
    pressure, shear, slip = found.values()
    needed = [name for name in (pressure, shear, mapping.columns.slip) if name is not None]
    tractions = f"{pressure} and {shear}" if shear else f"{pressure}, without a shear,"
    numbers, mesh, notes = _parts_with(path, frame, mapping, needed, where)
    if slip is not None and not _holds(mesh, slip, where):
        notes.append(f"{slip} is not in all of the files that hold {tractions.rstrip(',')}, and was left out")
        found["slip"] = None
    at = "at points"
    if where == "cell_fields":
        at = "of cells, at their middles"
        rows, x, how = _surface_cells(path, mesh, mapping)
    else:
        rows, _, how = _surface_points(path, mesh, mapping)
        x = mesh.points[rows, 0]
    components: _Components = {
        q: (name, float(converted(mapping, q, np.ones(1))[0])) for q, name in found.items() if name is not None
    }
    return numbers, where, rows, x, components, [f"tractions are the fields {tractions} {at}", *notes, *how]


def _parts_with(
    path: Path, frame: FieldFrame, mapping: Mapping, names: Sequence[str], where: Where
) -> tuple[list[int], FieldPart, list[str]]:
    """The parts that hold all the named fields, and what marks the surface where any part does; as one mesh; the others named."""
    marker = str(mapping.surface or "").partition("=")[0]
    marks = [marker in part.point_fields or marker in part.cell_fields for part in frame.parts]
    lacks = [
        [name for name in names if not _holds(part, name, where)] + [marker] * (any(marks) and not own)
        for part, own in zip(frame.parts, marks, strict=True)
    ]
    said = [f"{part.name} has no {listed(lack)}" for part, lack in zip(frame.parts, lacks, strict=True) if lack]
    numbers = [k for k, lack in enumerate(lacks) if not lack]
    if not numbers:
        raise InputError(f"{path}: no file of it has all that is to be read: {'; '.join(said)}")
    return numbers, joined([frame.parts[k] for k in numbers]), [f"{words}: left out" for words in said]


def _holds(part: FieldPart, name: str, where: Where) -> bool:
    """Whether it has the field that `name` is, or is a component of."""
    fields = getattr(part, where)
    return name in fields or name.rpartition(":")[0] in fields


def _component(part: FieldPart, where: Where, name: str) -> Array:
    """(n,) of all points, or of all cells through the blocks; KeyError where there is no such field."""
    fields = getattr(part, where)
    whole, _, k = (name, "", "") if name in fields else name.rpartition(":")
    if whole not in fields:
        raise KeyError(name)
    blocks = fields[whole] if where == "cell_fields" else (fields[whole],)
    return np.concatenate([block[:, int(k)] if k else block for block in blocks])


# ------------------------------------------------------------------------------------------------- where the surface lies
def _surface_points(path: Path, mesh: FieldPart, mapping: Mapping) -> tuple[Integers, str, list[str]]:
    """Rows of points in one plane, ascending in x, whose face they are ("lower" or "upper"), and how they were found."""
    chosen, notes = _chosen_points(path, mesh, mapping)
    above = material_above(mesh.points, _bulk(mesh))[chosen]
    if np.any(above < 0) and np.any(above > 0):
        chosen, above = chosen[above < 0], above[above < 0]
        notes.append("the surface has points of both bodies: those of the lower one were taken")
    rows, _, more = one_plane(mesh.points, chosen)
    return rows, "upper" if np.any(above > 0) else "lower", [*notes, *more]


def _surface_cells(path: Path, mesh: FieldPart, mapping: Mapping) -> tuple[Integers, Array, list[str]]:
    """Rows, through all blocks, of the cells that are marked, else whose points are all of the surface; x of their middles."""
    if mapping.surface is not None:
        rows = np.flatnonzero(np.concatenate(_mark(path, mesh.cell_fields, mapping)))
    else:
        on_face = np.isin(np.arange(len(mesh.points)), _chosen_points(path, mesh, mapping)[0])
        rows = np.flatnonzero(np.concatenate([np.all(on_face[block], axis=1) for _, block in mesh.cells]))
    if not len(rows):
        raise InputError(
            f"{path}: pressure is a field of cells, and no cell lies in the surface; average it to points "
            "(ParaView: Cell Data to Point Data) or mark the cells of the surface (surface of a mapping)"
        )
    middles = np.concatenate([mesh.points[block].mean(axis=1) for _, block in mesh.cells])
    rows, _, notes = one_plane(middles, rows)
    return rows, middles[rows, 0], notes


def _chosen_points(path: Path, mesh: FieldPart, mapping: Mapping) -> tuple[Integers, list[str]]:
    """What the mapping marks, else the whole of a path, else the face at y = y_offset; and how it was found."""
    if mapping.surface is not None:
        if mapping.surface.partition("=")[0] in mesh.point_fields:
            rows = np.flatnonzero(_mark(path, {name: (values,) for name, values in mesh.point_fields.items()}, mapping)[0])
        else:
            flags = _mark(path, mesh.cell_fields, mapping, others=tuple(mesh.point_fields))
            marked = [block[own].ravel() for (_, block), own in zip(mesh.cells, flags, strict=True)]
            rows = np.unique(np.concatenate([np.empty(0, np.int64), *marked]))
        if not len(rows):
            raise InputError(f"{path}: surface = {mapping.surface!r} marks nothing in it")
        return rows, [f"the surface is what {mapping.surface} marks"]
    height = mesh.points[:, 1] - mapping.y_offset / (mapping.factors.length or 1.0)
    tolerance, bulk = SAME * extent(mesh.points), _bulk(mesh)
    if np.ptp(height) <= tolerance or not bulk:
        return np.arange(len(height)), [f"{mesh.name} is taken for the surface alone, since it has no cells of a body"]
    above = material_above(mesh.points, bulk)
    for body, side in (("lower", above < 0), ("upper", above > 0)):
        if len(rows := np.flatnonzero((np.abs(height) <= tolerance) & side)):
            return rows, [f"the surface is the {body} body's face, found at y = {mapping.y_offset:g}"]
    raise InputError(
        f"{path}: no point of a face at y = {mapping.y_offset:g} (y goes from {mesh.points[:, 1].min():.6g} to "
        f"{mesh.points[:, 1].max():.6g}); say where it lies by y_offset, or what marks it by surface of a mapping"
    )


def _mark(
    path: Path, fields: dict[str, tuple[Array, ...]], mapping: Mapping, others: tuple[str, ...] = ()
) -> list[NDArray[np.bool_]]:
    """For each block what is marked: NAME=VALUE a tag's value; NAME what is not 0 (not -1 where that occurs)."""
    name, equal, value = str(mapping.surface).partition("=")
    fault = f"{path}: surface = {mapping.surface!r}"
    if name not in fields:
        known = listed([*others, *fields]) or "none"
        raise InputError(f"{fault} of the mapping names no field of it ({known}); NAME or NAME=VALUE")
    blocks = fields[name]
    if any(block.ndim != 1 for block in blocks):
        raise InputError(f"{fault}: {name} is a vector and can't mark a surface")
    if equal:
        try:
            return [block == float(value) for block in blocks]
        except ValueError as reason:
            raise InputError(f"{fault}: {value!r} is no number") from reason
    # A set that meshio writes into a VTU is -1 outside and counts from 0 inside.
    none = -1.0 if any(np.any(block == -1) for block in blocks) else 0.0
    return [block != none for block in blocks]


def _bulk(mesh: FieldPart) -> list[Integers]:
    """Cells that fill a body: solids, and in a plane mesh what is no line."""
    deep = np.ptp(mesh.points[:, 2]) > SAME * extent(mesh.points)
    faces = (*_LINES, *_PLANES) if deep else _LINES
    return [block for kind, block in mesh.cells if not kind.startswith(faces)]
