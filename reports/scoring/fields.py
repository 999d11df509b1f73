"""Tractions on the contact surface out of field files, VTU, legacy VTK and their collection PVD.

They are looked for in this order: pressure and shear by name; a vector of contact traction; the
stress, of which p = -sigma_yy and q = sigma_xy are the traction on the lower body's outward normal
+y (the upper's normal -y turns it, and what acts on the lower body turns it again). Of a collection
whose files hold different fields, those that hold what is taken are read, the others named.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping as Fields
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.scoring.field_files import FieldFrame, FieldPart, joined_mesh, read_frames
from reports.scoring.mapping import (
    ColumnQuantity,
    Mapping,
    converted_values,
    name_of_column,
    names_in_words,
    stated_times,
)
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
from scenes.column_names import normalised_name

Integers = NDArray[np.int64]
_FieldNames = dict[ColumnQuantity, str]
"""Quantity -> name of the field at points that holds it, or "name:k" for a component of one.
"""

# In a sentence on the fields: "upper" or "lower" is written for it.
_BODY = "<loaded>"
_NAMES_OF_VECTORS = ("contact_traction", "contacttractions", "traction", "tractions")
_NAMES_OF_STRESSES = (
    "stress",
    "cauchy_stress",
    "cauchy_stress_tensor",
    "stress_tensor",
    "sigma",
    "S",
)
# Where sigma_yy and sigma_xy stand among the components: VTK's order of a symmetric tensor, rows of
# 3 x 3, Voigt's of the plane.
_PLACES_OF_YY_AND_XY = {
    6: (1, 3, "xx, yy, zz, xy, yz, xz"),
    9: (4, 1, "rows of 3 x 3"),
    3: (1, 2, "xx, yy, xy"),
    4: (1, 3, "xx, yy, zz, xy"),
}


def read_fields(path: Path, mapping: Mapping) -> SurfaceResult:
    """Tractions on the contact surface at every instant of a field file, or of the files that it
    collects; `mapping` states names, units and signs.

    Raises
    ------
    InputError
        File and what is wrong: can't be read, broken, too large; no instant; no tractions under a
        known name; no surface; a mesh that changes.
    """
    # frames: instants, with a mesh and its fields for each body
    frames = read_frames(path)
    _require_one_mesh(path, frames)
    source = _find_tractions(path, frames[0], mapping)
    # the parts of an instant that hold all fields, joined as one mesh
    part_numbers, mesh, notes_on_parts = _parts_with_fields(
        path, frames[0], mapping, source.names_of_tractions
    )
    field_names, notes_on_slip = _fields_to_read(source, mesh, mapping)
    # `body`: whose face the surface is, "lower" or "upper"
    surface_points, body, notes_on_surface = _surface_points(path, mesh, mapping)

    # values at the surface, at every instant, in the scene's unit and sign
    loaded_body = _loaded_body(source, mapping, body)
    factors = _factors_of_fields(source, mapping, loaded_body)
    values = _values_on_surface(path, frames, part_numbers, field_names, surface_points)
    fields: dict[str, ArrayLike | None] = {
        quantity: np.array(
            [factors[quantity] * values_of_instant for values_of_instant in values_at_instants]
        )
        for quantity, values_at_instants in values.items()
    }
    x = converted_values(mapping, "x", mesh.points[surface_points, 0])
    times = _times_of(path, frames, mapping)
    notes = [source.in_words(loaded_body), *notes_on_parts, *notes_on_slip, *notes_on_surface]
    return surface_result(str(path), mapping.code, x, fields, {"time": times}, notes)


def _fields_to_read(
    source: _TractionSource, mesh: FieldPart, mapping: Mapping
) -> tuple[_FieldNames, list[str]]:
    """Names of the fields that are read, by quantity, and notes on a slip that is left out: where
    not all parts of the `mesh` hold it, or where the mapping names it beside a traction vector or a
    stress.
    """
    field_names = dict(source.field_names)
    notes = []
    if "slip" in field_names and not _has_field(mesh, field_names["slip"]):
        notes.append(
            f"{field_names['slip']} is not in all of the files that hold"
            f" {' and '.join(source.names_of_tractions)}, and was left out"
        )
        del field_names["slip"]
    if source.kind != "fields" and mapping.columns.slip is not None:
        notes.append(
            f"columns.slip = {mapping.columns.slip!r} is not read beside a {source.kind}: state"
            " columns.pressure and columns.shear too"
        )
    return field_names, notes


class _TractionSource(NamedTuple):
    """Which fields of a field file hold the tractions.

    Attributes
    ----------
    kind
        "fields" for pressure and shear by name, "vector" for a contact traction, "stress" for a
        stress tensor
    field_names
        quantity -> name of the field at points that holds it, or "name:k" for a component of one
    sentence
        on these fields, for the reader of a report; `_BODY` in it stands for the body that the
        tractions act on
    """

    kind: str
    field_names: _FieldNames
    sentence: str

    def in_words(self, loaded_body: str) -> str:
        """The sentence on the fields, with the body that the tractions act on."""
        return self.sentence.replace(_BODY, loaded_body)

    @property
    def names_of_tractions(self) -> list[str]:
        """Names of the fields that hold pressure and shear."""
        return [name for quantity, name in self.field_names.items() if quantity != "slip"]


def _loaded_body(source: _TractionSource, mapping: Mapping, body: str) -> str:
    """The body, "upper" or "lower", that the tractions of a field file act on. It is the one that
    the mapping states for a traction vector; else `body`, of whose face the points are.
    """
    if source.kind == "vector" and mapping.signs.shear:
        return "upper" if mapping.signs.shear == "on upper" else "lower"
    return body


def _factors_of_fields(
    source: _TractionSource, mapping: Mapping, loaded_body: str
) -> dict[ColumnQuantity, float]:
    """By quantity, the factor that turns a value of a field file into the scene's unit with this
    program's sign. Fields that are named have the mapping's units and signs.

    Components of a vector or a stress get the signs of the body, "upper" or "lower", that they act
    on: the traction on the lower body is (q, -p), that on the upper one is turned, (-q, p). p =
    -sigma_yy and q = sigma_xy of the stress of either body.

    # notation: p pressure, q shear
    """
    if source.kind == "fields":
        return {
            quantity: float(converted_values(mapping, quantity, np.ones(1))[0])
            for quantity in source.field_names
        }
    factor = mapping.factors.stress or 1.0
    if source.kind == "vector" and loaded_body == "upper":
        factor = -factor
    return {"pressure": -factor, "shear": factor}


def _values_on_surface(
    path: Path,
    frames: Sequence[FieldFrame],
    part_numbers: Sequence[int],
    field_names: _FieldNames,
    surface_points: Integers,
) -> dict[ColumnQuantity, list[Array]]:
    """Quantity -> its values at the n points of the contact surface, (n,) at each instant, as
    they stand in the file.

    InputError where an instant has not all the fields of the first one.

    Parameters
    ----------
    path
        the file, for messages
    frames
        the instants of the file
    part_numbers
        which of the files of an instant are read
    field_names
        names of the fields to read
    surface_points
        (n,) numbers of the points on the surface, in the mesh of those files
    """
    values: dict[ColumnQuantity, list[Array]] = {quantity: [] for quantity in field_names}
    for instant_number, frame in enumerate(frames, start=1):
        try:
            mesh = joined_mesh([frame.parts[part_number] for part_number in part_numbers])
            for quantity, name in field_names.items():
                values[quantity].append(_field_values(mesh, name)[surface_points])
        except (KeyError, IndexError) as reason:
            raise InputError(
                f"{path}: instant {instant_number} has no field {reason}, which the first one has"
            ) from reason
    return values


def _require_one_mesh(path: Path, frames: Sequence[FieldFrame]) -> None:
    """InputError where the points of any instant (`frames`) of a field file are not those of the
    first instant, to a millionth of the mesh's longest side.
    """
    # the parts of an instant, such as bodies, as one mesh
    first_points = joined_mesh(frames[0].parts).points
    tolerance = SAME_PLACE_SHARE * longest_side(first_points)
    for instant_number, frame in enumerate(frames[1:], start=2):
        points = joined_mesh(frame.parts).points
        has_same_shape = points.shape == first_points.shape
        if not has_same_shape or np.max(np.abs(points - first_points)) > tolerance:
            raise InputError(
                f"{path}: the points of instant {instant_number} are not those of the first; give"
                " all instants on one undeformed mesh"
            )


def _times_of(path: Path, frames: Sequence[FieldFrame], mapping: Mapping) -> Array | None:
    """Times of the instants of a field file, (k,): those that the mapping states, else the file's
    own; None where neither has all.
    """
    if mapping.times is not None:
        return stated_times(str(path), mapping, len(frames))
    times = [frame.time for frame in frames]
    return None if None in times else converted_values(mapping, "time", np.array(times, float))


def _find_tractions(path: Path, frame: FieldFrame, mapping: Mapping) -> _TractionSource:
    """Find out which fields of a field file hold the tractions, from its first instant (`frame`):
    `parts`, one for each file or body, have fields at points and at cells by name.

    Three kinds are looked for in this order: "fields" for pressure and shear, a traction "vector",
    a "stress" tensor. Returned are the kind, the names of the fields, and a sentence on them.
    InputError where the file holds none. `mapping` states columns, units and signs of the file.
    """
    # values at points, (n,) or (n, components)
    fields = dict(ChainMap(*(part.point_fields for part in frame.parts)))
    names_of_scalars = [name for name, values in fields.items() if values.ndim == 1]
    # vectors and tensors, (n, components)
    tensor_fields = {name: values for name, values in fields.items() if values.ndim == 2}
    # columns of the mapping, None where it states none
    mapping_states_names = bool(mapping.columns.pressure or mapping.columns.shear)
    if (
        mapping_states_names
        or name_of_column(mapping, "pressure", names_of_scalars, str(path)) is not None
    ):
        names = list(names_of_scalars)
        if mapping_states_names:
            # components of vectors and tensors, such as "traction:0"
            for name, values in tensor_fields.items():
                names += [f"{name}:{number}" for number in range(values.shape[1])]
        return _find_named_tractions(path, names, mapping)
    source = _traction_vector(tensor_fields) or _stress_tensor(path, tensor_fields)
    if source is not None:
        return source
    cell_fields = dict(ChainMap(*(part.cell_fields for part in frame.parts)))
    cell_hint = ""
    if cell_fields:
        cell_hint = (
            f" (values of cells, {names_in_words([*cell_fields])}, are not read: average them to"
            " points)"
        )
    raise InputError(
        f"{path}: neither contact pressure, nor contact traction, nor stress at points among"
        f" {names_in_words([*fields]) or 'no fields'}{cell_hint}; name them by columns.pressure and"
        " columns.shear of a mapping (components as 'name:0')"
    )


def _traction_vector(tensor_fields: Fields[str, Array]) -> _TractionSource | None:
    """The field that holds the vector of contact traction under a known name; None where there is
    none. `tensor_fields` are values at points by name, (n, components); two components or more
    make a vector, of which the first is along x and the second along y.
    """
    # spellings of one name compare equal
    known_names = [normalised_name(known_name) for known_name in _NAMES_OF_VECTORS]
    for name, values in tensor_fields.items():
        if values.shape[1] >= 2 and normalised_name(name) in known_names:
            field_names: _FieldNames = {"pressure": f"{name}:1", "shear": f"{name}:0"}
            sentence = f"tractions are the field {name}, taken to act on the {_BODY} body"
            return _TractionSource("vector", field_names, sentence)
    return None


def _stress_tensor(path: Path, tensor_fields: Fields[str, Array]) -> _TractionSource | None:
    """The field that holds the stress tensor under a known name; None where there is none.
    `tensor_fields` are values at points by name, (n, components); InputError, with the file `path`,
    where no order is known for so many components.
    """
    # spellings of one name compare equal
    known_names = [normalised_name(known_name) for known_name in _NAMES_OF_STRESSES]
    for name, values in tensor_fields.items():
        if values.shape[1] >= 3 and normalised_name(name) in known_names:
            # indices among the components, and the order of all in words
            place_of_yy, place_of_xy, order_in_words = _places_of_yy_and_xy(path, name, values)
            field_names: _FieldNames = {
                "pressure": f"{name}:{place_of_yy}",
                "shear": f"{name}:{place_of_xy}",
            }
            sentence = (
                "no contact tractions in the file: p = -sigma_yy and q = sigma_xy of the"
                f" {_BODY} body's nodal {name} (components {order_in_words}), which is extrapolated"
                " to the surface and coarser than contact tractions"
            )
            return _TractionSource("stress", field_names, sentence)
    return None


def _find_named_tractions(path: Path, names: Sequence[str], mapping: Mapping) -> _TractionSource:
    """Find out which of the fields `names` of a field file are pressure, shear and slip: by the
    mapping, or by names that are known for them. InputError where none is the pressure.

    Returned are the kind, "fields", the names of the fields by quantity, and a sentence on them.
    """
    quantities: tuple[ColumnQuantity, ...] = ("pressure", "shear", "slip")
    field_names: _FieldNames = {}
    for quantity in quantities:
        is_needed = quantity == "pressure"
        name = name_of_column(mapping, quantity, names, str(path), is_needed=is_needed)
        if name is not None:
            field_names[quantity] = name
    sentence = f"tractions are the fields {field_names['pressure']}"
    sentence += f" and {field_names['shear']}" if "shear" in field_names else ", without a shear"
    return _TractionSource("fields", field_names, sentence)


def _places_of_yy_and_xy(path: Path, name: str, values: Array) -> tuple[int, int, str]:
    """Places of sigma_yy and sigma_xy among the components of the stress field `name`, counted from
    0, and the order of the components in words.

    `values` (n, components) are those at the points. InputError where no order is known for so many
    components.
    """
    # known orders by the number of components: 3, 4, 6 or 9
    n_components = values.shape[1]
    if n_components not in _PLACES_OF_YY_AND_XY:
        raise InputError(
            f"{path}: {name} has {n_components} components, and"
            f" {', '.join(map(str, sorted(_PLACES_OF_YY_AND_XY)))} are"
            " understood"
        )
    if n_components == 4 and np.any(values[:, 1]) and np.array_equal(values[:, 1], values[:, 2]):
        return 3, 1, "rows of 2 x 2, since the second and third are equal"
    return _PLACES_OF_YY_AND_XY[n_components]


def _parts_with_fields(
    path: Path, frame: FieldFrame, mapping: Mapping, names_of_tractions: list[str]
) -> tuple[list[int], FieldPart, list[str]]:
    """Of the parts of one instant (`frame`), one for each file, those that hold all fields that are
    to be read: their numbers, all of them joined as one mesh, and a note on each part left out.

    To be read are the fields `names_of_tractions`, the slip that `mapping` names, and the field by
    which it marks the contact surface, where any part has that. InputError where no part holds all.
    `mapping.surface` is NAME or NAME=VALUE of that field.
    """
    needed_names = list(names_of_tractions)
    if isinstance(mapping.columns.slip, str):
        needed_names.append(mapping.columns.slip)
    marking_field = str(mapping.surface or "").partition("=")[0]
    has_marking_field = [
        marking_field in part.point_fields or marking_field in part.cell_fields
        for part in frame.parts
    ]
    part_numbers = []
    faults_of_parts = []
    for part_number, part in enumerate(frame.parts):
        missing_names = [name for name in needed_names if not _has_field(part, name)]
        if any(has_marking_field) and not has_marking_field[part_number]:
            missing_names.append(marking_field)
        if missing_names:
            faults_of_parts.append(f"{part.name} has no {names_in_words(missing_names)}")
        else:
            part_numbers.append(part_number)
    if not part_numbers:
        raise InputError(
            f"{path}: no file of it has all that is to be read: {'; '.join(faults_of_parts)}"
        )
    mesh = joined_mesh([frame.parts[part_number] for part_number in part_numbers])
    return part_numbers, mesh, [f"{fault}: left out" for fault in faults_of_parts]


def _has_field(part: FieldPart, name: str) -> bool:
    """Whether a part has the field `name` at points, or the field of a component "field:k"."""
    return name in part.point_fields or name.rpartition(":")[0] in part.point_fields


def _field_values(part: FieldPart, name: str) -> Array:
    """Values (n,) at all points of the field `name`, or of a component, "field:k"; KeyError where
    there is no such field.
    """
    if name in part.point_fields:
        return part.point_fields[name]
    field, _, k = name.rpartition(":")
    if field not in part.point_fields:
        raise KeyError(name)
    return part.point_fields[field][:, int(k)]


# --------------------------------------------------------------------------- where the surface lies
def _surface_points(
    path: Path, mesh: FieldPart, mapping: Mapping
) -> tuple[Integers, str, list[str]]:
    """Numbers of the mesh points on the contact surface, ascending in x; the body whose face this
    is, "lower" or "upper"; and notes on how they were found.

    They are the points that the mapping marks, else all points of a mesh that is flat or has no
    cells of a body, else those of a body's face at y = y_offset. Of points of both bodies those of
    the lower one count. InputError where no face lies there.
    """
    bulk_cells = _bulk_cells(mesh)
    # how far the middles of its cells lie above a point: negative at the face of the lower body,
    # NaN without cells
    material_height = height_of_material(mesh.points, bulk_cells)
    tolerance = SAME_PLACE_SHARE * longest_side(mesh.points)
    if mapping.surface is not None:
        surface_points = _marked_points(path, mesh, mapping.surface)
        notes = [f"the surface is what {mapping.surface} marks"]
    elif np.ptp(_heights_above_face(mesh, mapping)) <= tolerance or not bulk_cells:
        surface_points = np.arange(len(mesh.points))
        notes = [f"{mesh.name} is taken for the surface alone, since it has no cells of a body"]
    else:
        surface_points, body = _points_of_face(path, mesh, mapping, material_height)
        notes = [f"the surface is the {body} body's face, found at y = {mapping.y_offset:g}"]
    material_height_at_surface = material_height[surface_points]
    if np.any(material_height_at_surface < 0) and np.any(material_height_at_surface > 0):
        surface_points = surface_points[material_height_at_surface < 0]
        notes.append("the surface has points of both bodies: those of the lower one were taken")
    points_in_plane, _, plane_notes = one_plane(mesh.points, surface_points)
    body = "upper" if np.any(material_height[points_in_plane] > 0) else "lower"
    return points_in_plane, body, [*notes, *plane_notes]


def _heights_above_face(mesh: FieldPart, mapping: Mapping) -> Array:
    """Heights (n,) of the mesh points above the lower body's face, in the file's unit of length.
    The face lies at y = `mapping.y_offset` [the scene's length].
    """
    return mesh.points[:, 1] - mapping.y_offset / (mapping.factors.length or 1.0)


def _points_of_face(
    path: Path, mesh: FieldPart, mapping: Mapping, material_height: Array
) -> tuple[Integers, str]:
    """Numbers of the mesh points on the face of a body at y = `mapping.y_offset`, and the body,
    "lower" or "upper". Where both bodies have a face there, it is the lower one's. InputError, with
    the file `path`, where no face lies there.

    `material_height` (n,) states how far the middles of its cells lie above each point: negative at
    the face of the lower body, NaN without cells.
    """
    tolerance = SAME_PLACE_SHARE * longest_side(mesh.points)
    is_on_face = np.abs(_heights_above_face(mesh, mapping)) <= tolerance
    points_by_body = {
        "lower": np.flatnonzero(is_on_face & (material_height < 0)),
        "upper": np.flatnonzero(is_on_face & (material_height > 0)),
    }
    for body, point_numbers in points_by_body.items():
        if len(point_numbers):
            return point_numbers, body
    raise InputError(
        f"{path}: no point of a face at y = {mapping.y_offset:g} (y goes from"
        f" {mesh.points[:, 1].min():.6g} to {mesh.points[:, 1].max():.6g}); say where it lies"
        " by y_offset, or what marks it by surface of a mapping"
    )


def _marked_points(path: Path, mesh: FieldPart, surface: str) -> Integers:
    """Numbers of the mesh points that a field of the file marks as the contact surface; a field of
    cells marks all points of its cells. InputError where it marks none, is a vector, or is not
    there.

    `surface` is NAME, for where the field is not 0, or NAME=VALUE. In a set that meshio wrote into
    a VTU unmarked points have -1: where -1 occurs, it stands in place of 0.
    """
    name, equal_sign, value_in_words = surface.partition("=")
    message_start = f"{path}: surface = {surface!r}"
    blocks, points_of_blocks = _marking_blocks(mesh, name, message_start)
    if any(block.ndim != 1 for block in blocks):
        raise InputError(f"{message_start}: {name} is a vector and can't mark a surface")
    try:
        marking_value = float(value_in_words) if equal_sign else None
    except ValueError as reason:
        raise InputError(f"{message_start}: {value_in_words!r} is no number") from reason
    value_outside = -1.0 if any(np.any(block == -1) for block in blocks) else 0.0
    marked_points = []
    for points_of_block, block in zip(points_of_blocks, blocks, strict=True):
        is_marked = block != value_outside if marking_value is None else block == marking_value
        marked_points.append(points_of_block[is_marked].ravel())
    point_numbers = np.unique(np.concatenate(marked_points))
    if not len(point_numbers):
        raise InputError(f"{message_start} marks nothing in it")
    return point_numbers


def _marking_blocks(
    mesh: FieldPart, name: str, message_start: str
) -> tuple[tuple[Array, ...], list[Integers]]:
    """Values of the field `name` of a mesh in blocks, and for each block the numbers of the points
    that its values belong to. A field at points is one block, with a point for each value; a field
    of cells has a block for each kind of cell, with the points of a cell for each value.

    InputError, beginning with `message_start`, where the mesh has no such field.
    """
    if name in mesh.point_fields:
        return (mesh.point_fields[name],), [np.arange(len(mesh.points))]
    if name in mesh.cell_fields:
        return mesh.cell_fields[name], [cells for _, cells in mesh.cells]
    raise InputError(
        f"{message_start} of the mapping names no field of it"
        f" ({names_in_words([*mesh.point_fields, *mesh.cell_fields]) or 'none'}); NAME or"
        " NAME=VALUE"
    )


def _bulk_cells(mesh: FieldPart) -> list[Integers]:
    """Cells that fill a body: solids, and in a plane mesh what is no line."""
    is_deep = np.ptp(mesh.points[:, 2]) > SAME_PLACE_SHARE * longest_side(mesh.points)
    face_dimension = 2 if is_deep else 1
    return [block for dimension, block in mesh.cells if dimension > face_dimension]
