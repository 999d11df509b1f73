"""Tractions on the contact surface out of field files, VTU, legacy VTK, XDMF and their collections.

They are looked for in this order: pressure and shear by name, at points or at cells of the surface; a vector of contact traction;
the stress, of which p = -sigma_yy and q = sigma_xy are the traction on the lower body's outward normal +y. Of a collection whose
files hold different fields, those are read that hold what is taken, and the others are named.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from meshes import FieldFrame, FieldPart, joined, read_frames
from reports.scoring.field_surface import FieldSurface, surface_cells, surface_points
from reports.scoring.inside_out import inside_out
from reports.scoring.mapping import Mapping, converted, find_column, listed, plain, stated_times
from reports.scoring.resultants import free_face
from reports.scoring.surface import SurfaceResult
from reports.scoring.surface_nodes import SAME, extent
from reports.scoring.tidying import surface_result
from scenes import InputError, Scene

Array = NDArray[np.float64]

_VECTORS = ("contact_traction", "contacttractions", "traction", "tractions")
_STRESSES = ("stress", "cauchy_stress", "cauchy_stress_tensor", "stress_tensor", "sigma", "S")
# Where sigma_yy and sigma_xy stand among the components: VTK's order of a symmetric tensor, rows of 3 x 3, Voigt's of the plane.
_YY_XY = {6: (1, 3, "xx, yy, zz, xy, yz, xz"), 9: (4, 1, "rows of 3 x 3"), 3: (1, 2, "xx, yy, xy"), 4: (1, 3, "xx, yy, zz, xy")}

_Where = Literal["point_fields", "cell_fields"]
# From one instant to pressure, shear and slip (or None) at the surface's points.
_Take = Callable[[FieldPart], tuple[Array, Array, Array | None]]


@dataclass(frozen=True, eq=False)
class _Parts:
    """Those parts of an instant that hold what is taken: their numbers, themselves as one mesh, and which were left out."""

    numbers: tuple[int, ...]
    mesh: FieldPart
    notes: tuple[str, ...]

    def of(self, frame: FieldFrame) -> FieldPart:
        """The same parts at another instant."""
        return joined([frame.parts[number] for number in self.numbers])


@dataclass(frozen=True, eq=False)
class _Source:
    """Where the tractions are taken from: which parts of an instant, the surface on them, how, and what to say of it."""

    parts: _Parts
    surface: FieldSurface
    take: _Take
    notes: tuple[str, ...]
    of_stress: bool = False


def read(path: Path, mapping: Mapping, scene: Scene) -> SurfaceResult:  # noqa: ARG001 (the readers' common signature)
    """The tractions of every instant in the file or in what it collects.

    Raises
    ------
    InputError
        File and what is wrong: see `meshes.read_frames`; no tractions under a known name; no surface; a mesh that changes.
    """
    frames = read_frames(path)
    source = _source(path, frames[0], mapping)
    whole = joined(frames[0].parts)
    for k, frame in enumerate(frames[1:], start=2):
        _same_mesh(path, whole, joined(frame.parts), k)
    taken = [_taken(path, source, frame, k) for k, frame in enumerate(frames, start=1)]
    pressure, shear = (np.array([fields[k] for fields in taken]) for k in (0, 1))
    slip = None if taken[0][2] is None else np.array([fields[2] for fields in taken])
    x = converted(mapping, "x", source.surface.x)
    fields = {"pressure": pressure, "shear": shear, "slip": slip}
    notes = [*source.notes, *source.parts.notes, *source.surface.notes, *inside_out(whole.points, whole.cells)]
    if source.of_stress:
        notes += free_face(x, pressure, shear)
    return surface_result(str(path), mapping.code, x, dict(fields), {"time": _times(path, mapping, frames)}, notes)


def _taken(path: Path, source: _Source, frame: FieldFrame, k: int) -> tuple[Array, Array, Array | None]:
    try:
        return source.take(source.parts.of(frame))
    except (KeyError, IndexError) as reason:
        raise InputError(f"{path}: instant {k} has no field {reason}, which the first one has") from reason


def _same_mesh(path: Path, first: FieldPart, other: FieldPart, k: int) -> None:
    if first.points.shape != other.points.shape or np.max(np.abs(first.points - other.points)) > SAME * extent(first.points):
        raise InputError(f"{path}: the points of instant {k} are not those of the first; give all instants on one undeformed mesh")


def _times(path: Path, mapping: Mapping, frames: list[FieldFrame]) -> Array | None:
    if mapping.times is not None:
        return stated_times(str(path), mapping, len(frames))
    times = [frame.time for frame in frames]
    return None if None in times else converted(mapping, "time", np.array(times, float))


def _source(path: Path, frame: FieldFrame, mapping: Mapping) -> _Source:
    """The first of the ways to tractions that the file offers."""
    fields, cells = _all(part.point_fields for part in frame.parts), _all(_of_cells(part) for part in frame.parts)
    at_points, at_cells = _components(fields), _components(cells)
    stated = mapping.columns.pressure or mapping.columns.shear
    if stated is not None and stated not in at_points and stated in at_cells:
        return _at_cells(path, frame, mapping, at_cells)
    if stated is not None or find_column(mapping, "pressure", _scalars(fields), str(path)) is not None:
        names = at_points if stated is not None else _scalars(fields)
        return _at_points(path, frame, mapping, names)
    if find_column(mapping, "pressure", [n for n in at_cells if ":" not in n], str(path)) is not None:
        return _at_cells(path, frame, mapping, at_cells)
    if (name := _known(fields, _VECTORS, 2)) is not None:
        return _vector(path, frame, mapping, name)
    if (name := _known(fields, _STRESSES, 3)) is not None:
        return _stress(path, frame, mapping, name)
    found = listed([*fields, *cells]) or "no fields"
    raise InputError(
        f"{path}: neither contact pressure, nor contact traction, nor stress at points among {found}; "
        "name them by columns.pressure and columns.shear of a mapping (components as 'name:0')"
    )


def _all(fields: Iterable[dict[str, Array]]) -> dict[str, Array]:
    """What any of them holds; of a name that several hold, the first."""
    return dict(ChainMap(*fields))


def _of_cells(part: FieldPart) -> dict[str, Array]:
    """Fields of cells, each by its first block."""
    return {name: blocks[0] for name, blocks in part.cell_fields.items() if blocks}


def _parts_with(path: Path, frame: FieldFrame, mapping: Mapping, names: Sequence[str], where: _Where = "point_fields") -> _Parts:
    """The parts that hold all the named fields (or components), and what marks the surface where any part does."""
    marker = "" if mapping.surface is None else mapping.surface.partition("=")[0]
    marks = any(_marks(part, marker) for part in frame.parts)
    lacks = [
        [name for name in names if not _holds(part, name, where)] + [marker] * (marks and not _marks(part, marker))
        for part in frame.parts
    ]
    said = [f"{part.name} has no {listed(lack)}" for part, lack in zip(frame.parts, lacks, strict=True) if lack]
    numbers = tuple(k for k, lack in enumerate(lacks) if not lack)
    if not numbers:
        raise InputError(f"{path}: no file of it has all that is to be read: {'; '.join(said)}")
    return _Parts(numbers, joined([frame.parts[k] for k in numbers]), tuple(f"{words}: left out" for words in said))


def _holds(part: FieldPart, name: str, where: _Where) -> bool:
    """Whether it has the field that `name` is, or is a component of."""
    fields = getattr(part, where)
    return name in fields or name.rpartition(":")[0] in fields


def _marks(part: FieldPart, marker: str) -> bool:
    return marker in part.point_fields or marker in part.cell_fields


def _components(fields: dict[str, Array]) -> list[str]:
    """Names of all scalars: those of vectors are name:0, name:1, ..."""
    return [n for name, v in fields.items() for n in ([name] if v.ndim == 1 else [f"{name}:{k}" for k in range(v.shape[1])])]


def _scalars(fields: dict[str, Array]) -> list[str]:
    return [name for name, values in fields.items() if values.ndim == 1]


def _known(fields: dict[str, Array], names: tuple[str, ...], least: int) -> str | None:
    """One of at least so many components that goes by one of the names."""
    known = {plain(name) for name in names}
    return next((n for n, v in fields.items() if v.ndim == 2 and v.shape[1] >= least and plain(n) in known), None)


def _component(fields: dict[str, Array], name: str) -> Array:
    if name in fields:
        return fields[name]
    whole, _, k = name.rpartition(":")
    if whole not in fields:
        raise KeyError(name)
    return np.asarray(fields[whole][:, int(k)])


def _named(path: Path, frame: FieldFrame, mapping: Mapping, names: list[str], where: _Where) -> tuple[_Parts, str, str, str | None]:
    """The parts that have the tractions, and the names of pressure, shear and slip (None where those parts have none)."""
    pressure, shear = (str(find_column(mapping, what, names, str(path), needed=True)) for what in ("pressure", "shear"))
    slip = find_column(mapping, "slip", names, str(path))
    stated = [] if mapping.columns.slip is None else [mapping.columns.slip]
    parts = _parts_with(path, frame, mapping, (pressure, shear, *stated), where)
    if slip is not None and not _holds(parts.mesh, slip, where):
        words = f"{slip} is not in all of the files that hold {pressure} and {shear}, and was left out"
        return replace(parts, notes=(*parts.notes, words)), pressure, shear, None
    return parts, pressure, shear, slip


def _at_points(path: Path, frame: FieldFrame, mapping: Mapping, names: list[str]) -> _Source:
    parts, pressure, shear, slip = _named(path, frame, mapping, names, "point_fields")
    surface = surface_points(path, parts.mesh, mapping)

    def take(now: FieldPart) -> tuple[Array, Array, Array | None]:
        own = now.point_fields
        return (
            converted(mapping, "pressure", _component(own, pressure)[surface.rows]),
            converted(mapping, "shear", _component(own, shear)[surface.rows]),
            None if slip is None else converted(mapping, "slip", _component(own, slip)[surface.rows]),
        )

    return _Source(parts, surface, take, (f"tractions are the fields {pressure} and {shear} at points",))


def _at_cells(path: Path, frame: FieldFrame, mapping: Mapping, names: list[str]) -> _Source:
    parts, pressure, shear, slip = _named(path, frame, mapping, names, "cell_fields")
    surface = surface_cells(path, parts.mesh, mapping)

    def whole(now: FieldPart, name: str) -> Array:
        return np.concatenate([_component({n: b[k] for n, b in now.cell_fields.items()}, name) for k in range(len(now.cells))])

    def take(now: FieldPart) -> tuple[Array, Array, Array | None]:
        return (
            converted(mapping, "pressure", whole(now, pressure)[surface.rows]),
            converted(mapping, "shear", whole(now, shear)[surface.rows]),
            None if slip is None else converted(mapping, "slip", whole(now, slip)[surface.rows]),
        )

    return _Source(parts, surface, take, (f"tractions are the fields {pressure} and {shear} of cells, at their middles",))


def _vector(path: Path, frame: FieldFrame, mapping: Mapping, name: str) -> _Source:
    """The traction t on the lower body is (q, -p); on the upper one (-q, p)."""
    parts = _parts_with(path, frame, mapping, (name,))
    surface = surface_points(path, parts.mesh, mapping)
    on_upper = mapping.signs.shear == "on upper" if mapping.signs.shear is not None else surface.body == "upper"
    factor = (-1.0 if on_upper else 1.0) * (mapping.factors.stress or 1.0)

    def take(now: FieldPart) -> tuple[Array, Array, Array | None]:
        traction = now.point_fields[name][surface.rows]
        return -factor * traction[:, 1], factor * traction[:, 0], None

    words = f"tractions are the field {name}, taken to act on the {'upper' if on_upper else 'lower'} body"
    return _Source(parts, surface, take, (words,))


def _stress(path: Path, frame: FieldFrame, mapping: Mapping, name: str) -> _Source:
    """Of either body: the upper's outward normal -y turns its traction, and what acts on the lower turns it again."""
    parts = _parts_with(path, frame, mapping, (name,))
    surface = surface_points(path, parts.mesh, mapping)
    values = parts.mesh.point_fields[name]
    if values.shape[1] not in _YY_XY:
        raise InputError(
            f"{path}: {name} has {values.shape[1]} components, and {', '.join(map(str, sorted(_YY_XY)))} are understood"
        )
    yy, xy, order = _YY_XY[values.shape[1]]
    if values.shape[1] == 4 and np.any(values[:, 1]) and np.array_equal(values[:, 1], values[:, 2]):
        yy, xy, order = 3, 1, "rows of 2 x 2, since the second and third are equal"
    factor = mapping.factors.stress or 1.0

    def take(now: FieldPart) -> tuple[Array, Array, Array | None]:
        stress = now.point_fields[name][surface.rows]
        return -factor * stress[:, yy], factor * stress[:, xy], None

    notes = (
        f"no contact tractions in the file: p = -sigma_yy and q = sigma_xy of the {surface.body} body's nodal {name} (components "
        f"{order}), which is extrapolated to the surface and coarser than contact tractions",
    )
    return _Source(parts, surface, take, notes, of_stress=True)
