"""Tractions on the contact surface out of field files, VTU, legacy VTK, XDMF and their collections.

They are looked for in this order: pressure and shear by name, at points or at cells of the surface; a vector of contact traction;
the stress, of which p = -sigma_yy and q = sigma_xy are the traction on the lower body's outward normal +y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from meshes import FieldFrame, read_frames
from reports.score.field_surface import FieldSurface, surface_cells, surface_points
from reports.score.inside_out import inside_out
from reports.score.mapping import Mapping, converted, find_column, listed, plain, stated_times
from reports.score.resultants import free_face
from reports.score.surface import SurfaceResult
from reports.score.surface_nodes import SAME, extent
from reports.score.tidying import surface_result
from scenes import InputError, Scene

Array = NDArray[np.float64]

_VECTORS = ("contact_traction", "contacttractions", "traction", "tractions")
_STRESSES = ("stress", "cauchy_stress", "cauchy_stress_tensor", "stress_tensor", "sigma", "S")
# Where sigma_yy and sigma_xy stand among the components: VTK's order of a symmetric tensor, rows of 3 x 3, Voigt's of the plane.
_YY_XY = {6: (1, 3, "xx, yy, zz, xy, yz, xz"), 9: (4, 1, "rows of 3 x 3"), 3: (1, 2, "xx, yy, xy"), 4: (1, 3, "xx, yy, zz, xy")}

# From one instant to pressure, shear and slip (or None) at the surface's points.
_Take = Callable[[FieldFrame], tuple[Array, Array, Array | None]]


@dataclass(frozen=True, eq=False)
class _Source:
    """Where the tractions are taken from: the surface, how, and what to say of it."""

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
    for k, frame in enumerate(frames[1:], start=2):
        _same_mesh(path, frames[0], frame, k)
    taken = [_taken(path, source, frame, k) for k, frame in enumerate(frames, start=1)]
    pressure, shear = (np.array([fields[k] for fields in taken]) for k in (0, 1))
    slip = None if taken[0][2] is None else np.array([fields[2] for fields in taken])
    x = converted(mapping, "x", source.surface.x)
    fields = {"pressure": pressure, "shear": shear, "slip": slip}
    notes = [*source.notes, *source.surface.notes, *inside_out(frames[0].points, frames[0].cells)]
    if source.of_stress:
        notes += free_face(x, pressure, shear)
    return surface_result(str(path), mapping.code, x, dict(fields), {"time": _times(path, mapping, frames)}, notes)


def _taken(path: Path, source: _Source, frame: FieldFrame, k: int) -> tuple[Array, Array, Array | None]:
    try:
        return source.take(frame)
    except (KeyError, IndexError) as reason:
        raise InputError(f"{path}: instant {k} has no field {reason}, which the first one has") from reason


def _same_mesh(path: Path, first: FieldFrame, other: FieldFrame, k: int) -> None:
    if first.points.shape != other.points.shape or np.max(np.abs(first.points - other.points)) > SAME * extent(first.points):
        raise InputError(f"{path}: the points of instant {k} are not those of the first; give all instants on one undeformed mesh")


def _times(path: Path, mapping: Mapping, frames: list[FieldFrame]) -> Array | None:
    if mapping.times is not None:
        return stated_times(str(path), mapping, len(frames))
    times = [frame.time for frame in frames]
    return None if None in times else converted(mapping, "time", np.array(times, float))


def _source(path: Path, frame: FieldFrame, mapping: Mapping) -> _Source:
    """The first of the ways to tractions that the file offers."""
    at_points = _components(frame.point_fields)
    at_cells = _components({name: of[0] for name, of in frame.cell_fields.items() if of})
    stated = mapping.columns.pressure or mapping.columns.shear
    if stated is not None and stated not in at_points and stated in at_cells:
        return _at_cells(path, frame, mapping, at_cells)
    if stated is not None or find_column(mapping, "pressure", _scalars(frame.point_fields), str(path)) is not None:
        names = at_points if stated is not None else _scalars(frame.point_fields)
        return _at_points(path, frame, mapping, names)
    if find_column(mapping, "pressure", [n for n in at_cells if ":" not in n], str(path)) is not None:
        return _at_cells(path, frame, mapping, at_cells)
    if (name := _known(frame, _VECTORS, 2)) is not None:
        return _vector(path, frame, mapping, name)
    if (name := _known(frame, _STRESSES, 3)) is not None:
        return _stress(path, frame, mapping, name)
    found = [*frame.point_fields, *frame.cell_fields]
    raise InputError(
        f"{path}: neither contact pressure, nor contact traction, nor stress at points among {listed(found) or 'no fields'}; "
        "name them by columns.pressure and columns.shear of a mapping (components as 'name:0')"
    )


def _components(fields: dict[str, Array]) -> list[str]:
    """Names of all scalars: those of vectors are name:0, name:1, ..."""
    return [n for name, v in fields.items() for n in ([name] if v.ndim == 1 else [f"{name}:{k}" for k in range(v.shape[1])])]


def _scalars(fields: dict[str, Array]) -> list[str]:
    return [name for name, values in fields.items() if values.ndim == 1]


def _known(frame: FieldFrame, names: tuple[str, ...], least: int) -> str | None:
    """A field at points of at least so many components that goes by one of the names."""
    known = {plain(name) for name in names}
    return next((n for n, v in frame.point_fields.items() if v.ndim == 2 and v.shape[1] >= least and plain(n) in known), None)


def _component(fields: dict[str, Array], name: str) -> Array:
    if name in fields:
        return fields[name]
    whole, _, k = name.rpartition(":")
    if whole not in fields:
        raise KeyError(name)
    return np.asarray(fields[whole][:, int(k)])


def _named(path: Path, mapping: Mapping, names: list[str]) -> tuple[str, str, str | None]:
    """Names of pressure, shear and slip (or None)."""
    pressure = find_column(mapping, "pressure", names, str(path), needed=True)
    shear = find_column(mapping, "shear", names, str(path), needed=True)
    return str(pressure), str(shear), find_column(mapping, "slip", names, str(path))


def _at_points(path: Path, frame: FieldFrame, mapping: Mapping, names: list[str]) -> _Source:
    pressure, shear, slip = _named(path, mapping, names)
    surface = surface_points(path, frame, mapping)

    def take(now: FieldFrame) -> tuple[Array, Array, Array | None]:
        own = now.point_fields
        return (
            converted(mapping, "pressure", _component(own, pressure)[surface.rows]),
            converted(mapping, "shear", _component(own, shear)[surface.rows]),
            None if slip is None else converted(mapping, "slip", _component(own, slip)[surface.rows]),
        )

    return _Source(surface, take, (f"tractions are the fields {pressure} and {shear} at points",))


def _at_cells(path: Path, frame: FieldFrame, mapping: Mapping, names: list[str]) -> _Source:
    pressure, shear, slip = _named(path, mapping, names)
    surface = surface_cells(path, frame, mapping)

    def whole(now: FieldFrame, name: str) -> Array:
        return np.concatenate([_component({n: b[k] for n, b in now.cell_fields.items()}, name) for k in range(len(now.cells))])

    def take(now: FieldFrame) -> tuple[Array, Array, Array | None]:
        return (
            converted(mapping, "pressure", whole(now, pressure)[surface.rows]),
            converted(mapping, "shear", whole(now, shear)[surface.rows]),
            None if slip is None else converted(mapping, "slip", whole(now, slip)[surface.rows]),
        )

    return _Source(surface, take, (f"tractions are the fields {pressure} and {shear} of cells, at their middles",))


def _vector(path: Path, frame: FieldFrame, mapping: Mapping, name: str) -> _Source:
    """The traction t on the lower body is (q, -p); on the upper one (-q, p)."""
    surface = surface_points(path, frame, mapping)
    on_upper = mapping.signs.shear == "on upper" if mapping.signs.shear is not None else surface.body == "upper"
    factor = (-1.0 if on_upper else 1.0) * (mapping.factors.stress or 1.0)

    def take(now: FieldFrame) -> tuple[Array, Array, Array | None]:
        traction = now.point_fields[name][surface.rows]
        return -factor * traction[:, 1], factor * traction[:, 0], None

    return _Source(surface, take, (f"tractions are the field {name}, taken to act on the {'upper' if on_upper else 'lower'} body",))


def _stress(path: Path, frame: FieldFrame, mapping: Mapping, name: str) -> _Source:
    """Of either body: the upper's outward normal -y turns its traction, and what acts on the lower turns it again."""
    surface = surface_points(path, frame, mapping)
    values = frame.point_fields[name]
    if values.shape[1] not in _YY_XY:
        raise InputError(
            f"{path}: {name} has {values.shape[1]} components, and {', '.join(map(str, sorted(_YY_XY)))} are understood"
        )
    yy, xy, order = _YY_XY[values.shape[1]]
    if values.shape[1] == 4 and np.any(values[:, 1]) and np.array_equal(values[:, 1], values[:, 2]):
        yy, xy, order = 3, 1, "rows of 2 x 2, since the second and third are equal"
    factor = mapping.factors.stress or 1.0

    def take(now: FieldFrame) -> tuple[Array, Array, Array | None]:
        stress = now.point_fields[name][surface.rows]
        return -factor * stress[:, yy], factor * stress[:, xy], None

    notes = (
        f"no contact tractions in the file: p = -sigma_yy and q = sigma_xy of the {surface.body} body's nodal {name} (components "
        f"{order}), which is extrapolated to the surface and coarser than contact tractions",
    )
    return _Source(surface, take, notes, of_stress=True)
