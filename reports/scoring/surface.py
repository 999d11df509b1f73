"""The one form that every foreign result is read into, and the surface of a foreign mesh: one
plane, one body.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.comparison.isolated import spike_mask
from scenes import InputError, read_only_copy
from scenes.array_types import Array
from scenes.arrays import LARGEST_NUMBER
from scenes.measured import ReadAs

Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Pressure, over the largest one, below which a point counts as open.
LEAST_TOUCHING_SHARE = 1e-3
# The deformed x of one point may differ from instant to instant by this share of the spacing;
# beyond it these are different points.
_LARGEST_MOVEMENT_IN_SPACINGS = 0.1
# Coordinates that differ by less than this share of the mesh's extent are equal: text files carry
# six digits.
SAME_PLACE_SHARE = 1e-6


@dataclass(frozen=True)
class Outlier:
    """A spike of a result: its field, the indices of its instant and point, its value, where it
    stands in the file.

    `number_in_file` is the value as the file has it, in the file's unit and sign.
    """

    quantity: str  # "pressure", "shear" or "slip"
    instant: int
    point: int
    value: float
    place: str
    number_in_file: float

    @property
    def sentence(self) -> str:
        """Row, column and value, and what was done."""
        return (
            f"{self.place}: {self.quantity} {self.number_in_file:.9g} stands out of all values"
            " around it; it is scored as it is, and left out where units, instants and causes are"
            " looked for: mend this cell"
        )


@dataclass(frozen=True, eq=False)
class SurfaceResult:
    """Tractions on the contact surface as another code computed them, in the scene's units and in
    our signs.

    Of (n_steps, n_points) instants and points; None is what the file does not state.
    """

    source: str  # where it was read, for the page and for sentences
    code: str  # what computed it, such as "CalculiX 2.20"; "" where nobody says
    x: Array  # contact points of the lower body, ascending [length]
    pressure: Array  # positive in compression [stress]
    shear: Array  # along +x on the lower body [stress]; NaN everywhere where the file has none
    slip: Array | None = None  # upper over lower [length]
    time: Array | None = None  # of the scene's load path
    normal_load: Array | None = None  # per unit thickness
    tangential_load: Array | None = None
    # what a reader must not miss: factors guessed, signs turned, frames left out
    notes: tuple[str, ...] = ()
    outliers: tuple[Outlier, ...] = ()
    # how a text table was read: its layout, then what became of each column
    read_as: ReadAs = ()

    @property
    def has_shear(self) -> bool:
        """Whether the file has a shear."""
        return not bool(np.isnan(self.shear).all())


def surface_result(
    source: str,
    code: str,
    x: ArrayLike,
    fields: dict[str, ArrayLike | None],
    series: dict[str, ArrayLike | None],
    notes: Sequence[str] = (),
) -> SurfaceResult:
    """Tractions on a contact surface as another program computed them, in the common form of all
    readers (`SurfaceResult`), from arrays as they came: points sorted by x, shapes and numbers
    checked, spikes named as outliers. Fields and series that are None stay so, a shear becomes NaN.

    Parameters
    ----------
    source
        name of the file, for messages
    code
        name of the program that computed it
    notes
        sentences that come first in its notes
    x
        (n_points,), or (n_steps, n_points) where points move from instant to instant
    fields
        pressure, and shear and slip or None, (n_steps, n_points) or (n_points,) of a single
        instant
    series
        time, normal_load, tangential_load, (n_steps,) each or None

    Raises
    ------
    InputError
        One sentence: a shape that does not fit, a number that is none, a point that is given
        twice.
    """
    field_arrays = {
        name: np.atleast_2d(np.array(values, dtype=float))
        for name, values in fields.items()
        if values is not None
    }
    series_arrays = {
        name: np.atleast_1d(np.array(values, dtype=float))
        for name, values in series.items()
        if values is not None
    }
    x_of_points = np.array(x, dtype=float)
    all_notes = list(notes)
    _require_shapes_and_numbers(source, x_of_points, field_arrays, series_arrays)
    _require_distinct_points(source, x_of_points)
    if x_of_points.ndim == 2:
        x_of_points, sentence = _mean_x_of_points(source, x_of_points)
        if sentence:
            all_notes.append(sentence)
    # sort the points
    indices_by_x = np.argsort(x_of_points, kind="stable")
    if np.any(np.diff(indices_by_x) < 0):
        all_notes.append("the points were not in the order of x and were sorted")
    arrays = {"shear": read_only_copy(np.full(field_arrays["pressure"].shape, np.nan))}
    arrays |= {
        name: read_only_copy(values[:, indices_by_x]) for name, values in field_arrays.items()
    }
    arrays |= {name: read_only_copy(values) for name, values in series_arrays.items()}
    sorted_x = read_only_copy(x_of_points[indices_by_x])
    # values that are far larger than all others
    outliers = tuple(_outliers(arrays, sorted_x))
    return SurfaceResult(
        source=source,
        code=code,
        x=sorted_x,
        notes=tuple(all_notes),
        outliers=outliers,
        read_as=(),
        **arrays,
    )


def _require_shapes_and_numbers(
    source: str, x: Array, field_arrays: dict[str, Array], series_arrays: dict[str, Array]
) -> None:
    """InputError, naming `source`, where an array of an external result does not have the shape of
    its kind, or holds a number that is not finite.

    Fields have the shape of the pressure, (n_steps, n_points). Series are (n_steps,), and `x` is
    (n_points,), or (n_steps, n_points) where points move.
    """
    shape = field_arrays["pressure"].shape
    n_steps, n_points = shape
    needed_shapes: dict[str, tuple[int, ...]] = dict.fromkeys(field_arrays, shape)
    needed_shapes |= dict.fromkeys(series_arrays, (n_steps,))
    needed_shapes["x"] = (n_points,) if x.ndim == 1 else shape
    for name, values in (*field_arrays.items(), *series_arrays.items(), ("x", x)):
        if values.shape != needed_shapes[name]:
            raise InputError(
                f"{source}: {name} has the shape {values.shape} where {needed_shapes[name]} is"
                " needed: pressure is (instants, points), x one figure a point, time and loads one"
                " an instant"
            )
        _refuse_no_numbers(source, name, values)  # NaN, infinity


def _refuse_no_numbers(source: str, name: str, values: Array) -> None:
    """InputError where a value of an external result is not finite, or too large to be squared.
    `values` are (instants, points) or (entries,); `name` and `source` are for the message.
    """
    bad_places = np.argwhere(~(np.abs(values) <= LARGEST_NUMBER))
    if not len(bad_places):
        return
    position = bad_places[0] + 1
    place = (
        f"instant {position[0]}, point {position[1]}"
        if values.ndim == 2
        else f"entry {position[0]}"
    )
    raise InputError(
        f"{source}: {name} is no finite number at {place} ({len(bad_places)} such in all); mend or"
        " leave out these rows"
    )


def _outliers(arrays: dict[str, Array], x: Array) -> Iterator[Outlier]:
    """The spikes of an external result, single values that are far larger than all others: for each
    its field, the indices of its instant and point, its value and its place.

    `arrays` holds pressure, shear and slip by name, (n_steps, n_points); `x` the points.
    """
    for name in ("pressure", "shear", "slip"):
        if name not in arrays:
            continue
        for instant, point in np.argwhere(spike_mask(arrays[name])):
            value = float(arrays[name][instant, point])
            place = f"instant {instant + 1}, x = {x[point]:.6g}"
            yield Outlier(name, int(instant), int(point), value, place, number_in_file=value)


def _mean_x_of_points(source: str, x: Array) -> tuple[Array, str]:
    """The mean x of each point of an external result, (n_points,), from its x at every instant
    (n_steps, n_points). With it comes a sentence where points move from instant to instant, else
    "". InputError where one moves by more than a tenth of the median spacing.
    """
    mean_x = x.mean(axis=0)
    movement = np.abs(x - mean_x)
    largest_movement = float(np.max(movement))
    if largest_movement <= 1e-9 * float(np.ptp(mean_x)):
        return x[0], ""
    spacing = float(np.median(np.diff(np.sort(mean_x))))
    movement_in_spacings = largest_movement / spacing
    if largest_movement > _LARGEST_MOVEMENT_IN_SPACINGS * spacing:
        instant, point = np.unravel_index(np.argmax(movement), x.shape)
        raise InputError(
            f"{source}: the points are not the same at every instant: point {point + 1} has x ="
            f" {x[instant, point]:.6g} at instant {instant + 1} and {mean_x[point]:.6g} in the"
            f" mean, {movement_in_spacings:.2g} spacings off; give undeformed places"
        )
    sentence = (
        f"x moves from instant to instant by at most {movement_in_spacings:.1g} of the points'"
        " spacing; its mean was taken"
    )
    return mean_x, sentence


def _require_distinct_points(source: str, x: Array) -> None:
    """InputError, naming `source`, for fewer than three points, or a point that is given twice
    in one instant; `x` of the points is (n_points,) or (n_steps, n_points).
    """
    for x_of_instant in np.atleast_2d(np.sort(x)):
        if len(x_of_instant) < 3:
            raise InputError(
                f"{source}: {len(x_of_instant)} points are no surface: three at least are needed"
            )
        spacings = np.diff(x_of_instant)
        doubled_points = np.flatnonzero(spacings <= 1e-12 * np.ptp(x_of_instant))
        if len(doubled_points):
            raise InputError(
                f"{source}: the point x = {x_of_instant[doubled_points[0]]:.9g} stands there twice"
                f" in one instant ({len(doubled_points)} such in all); leave one out, or name a"
                " column that tells the instants apart (columns.time or columns.frame of a"
                " mapping)"
            )


# ---------------------------------------------------------------------------- the surface of a mesh
def longest_side(points: Array) -> float:
    """The longest side of the box around the points [length]."""
    return float(np.max(np.ptp(points, axis=0))) if len(points) else 0.0


def one_plane(points: Array, chosen_rows: Integers) -> tuple[Integers, float, list[str]]:
    """Rows of those chosen nodes of a mesh that lie in the plane z = const with the most of them,
    ascending in x. `chosen_rows` are rows of `points` (n, 3), the coordinates of all nodes. With
    them come the distance from the first to the last plane [length], 0 for a plane model; and a
    list with a note on several planes.

    >>> thick = np.array([[1.0, 0, 0], [0.0, 0, 0], [0.0, 0, 1.0], [1.0, 0, 1.0]])
    >>> rows, depth, notes = one_plane(thick, np.arange(4))
    >>> rows.tolist(), depth, notes
    ([1, 0], 1.0, ['the model is 1 thick: the tractions are those of its plane z = 0, one of 2'])
    """
    z_of_rows = points[chosen_rows, 2]
    order_of_z = np.argsort(z_of_rows, kind="stable")
    # planes are a millionth of the mesh's longest side apart at least
    plane_number = np.empty(len(chosen_rows), np.int64)
    plane_number[order_of_z] = np.concatenate(
        [[0], np.cumsum(np.diff(z_of_rows[order_of_z]) > SAME_PLACE_SHARE * longest_side(points))]
    )
    # the lowest plane where several hold as many points
    fullest_plane = int(np.argmax(np.bincount(plane_number)))
    is_in_plane = plane_number == fullest_plane
    rows = chosen_rows[is_in_plane]
    rows = rows[np.argsort(points[rows, 0], kind="stable")]
    if not plane_number.any():
        return rows, 0.0, []
    z_of_plane = float(z_of_rows[is_in_plane].min())
    thickness = float(np.ptp(z_of_rows))
    note = (
        f"the model is {thickness:.6g} thick: the tractions are those of its plane z ="
        f" {z_of_plane:.6g}, one of {plane_number.max() + 1}"
    )
    return rows, thickness, [note]


def height_of_material(points: Array, cells: Iterable[Integers]) -> Array:
    """How far the middles of a point's cells lie above it along y, in the mean, (n_points,)
    [length]; NaN for a point that is in no cell.

    Negative at the top face of the lower body, positive at the bottom face of the upper one.
    `cells` are blocks of cells of one kind, (n_cells, n_nodes) rows of `points` each.
    """
    sum_of_heights = np.zeros(len(points))
    n_cells_at_points = np.zeros(len(points))
    for block in cells:
        y_of_nodes = points[block, 1]
        y_of_middles = y_of_nodes.mean(axis=1)[:, None]
        np.add.at(sum_of_heights, block, y_of_middles - y_of_nodes)
        np.add.at(n_cells_at_points, block, 1.0)
    mean_heights = np.full(len(points), np.nan)
    return np.divide(
        sum_of_heights, n_cells_at_points, out=mean_heights, where=n_cells_at_points > 0
    )
