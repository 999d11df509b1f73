"""The one form that every foreign result is read into, and the surface of a foreign mesh: one
plane, one body.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, freeze
from scenes.arrays import LARGEST

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Of the largest pressure; below it a point counts as open.
TOUCHES = 1e-3
# Deformed places of one point may differ from instant to instant by this share of the spacing;
# beyond it they are no one point.
_SAME_PLACE = 0.1
# Places that differ by less than this share of the mesh's extent are one: text files carry six
# digits.
SAME = 1e-6


# A spike is so many times as large as its neighbours in x and in time, and so many times as large
# as
# all other values of its field: a traction may be singular at an edge, but not at one point of one
# instant alone.
_OVER_NEIGHBOURS, _OVER_ALL = 5.0, 3.0
# Points with a value at the instant of a spike: of a contact of fewer a mesh knows no form.
_FEWEST_BESIDE = 6


def spikes(values: Array) -> Mask:
    """Where single values of a field stand out of all others: (n_steps, n_points) -> mask.

    >>> field = np.full((1, 9), 2.0)
    >>> field[0, 4] = 900.0
    >>> np.flatnonzero(spikes(field)[0]).tolist()
    [4]
    """
    size = np.abs(np.nan_to_num(values))
    padded = np.pad(size, 1)
    left, right = padded[1:-1, :-2], padded[1:-1, 2:]
    before, after = padded[:-2, 1:-1], padded[2:, 1:-1]
    beside = np.maximum.reduce([left, right, before, after])
    lonely = (size > 0) & (size > _OVER_NEIGHBOURS * beside)
    lonely &= np.sum(size > 0, axis=1, keepdims=True) > _FEWEST_BESIDE
    others = float(np.max(size, where=~lonely, initial=0.0))
    return np.asarray(lonely & (size > _OVER_ALL * others))


def without_spikes(values: Array) -> Array:
    """`values`, (n_steps, n_points), with the mean of both neighbours in x in place of a spike."""
    mask = spikes(values)
    if not mask.any():
        return values
    mended = values.copy()
    for row, column in np.argwhere(mask):
        beside = [
            k for k in (column - 1, column + 1) if 0 <= k < values.shape[1] and not mask[row, k]
        ]
        mended[row, column] = np.mean(values[row, beside]) if beside else 0.0
    return freeze(mended)


@dataclass(frozen=True)
class Outlier:
    """A spike of a result: its field, the indices of its instant and point, its value, where it
    stands in the file.

    `figure` is the value as the file has it, in the file's unit and sign.
    """

    quantity: str  # "pressure", "shear" or "slip"
    instant: int
    point: int
    value: float
    place: str
    figure: float

    @property
    def sentence(self) -> str:
        """Row, column and value, and what was done."""
        return (
            f"{self.place}: {self.quantity} {self.figure:.9g} stands out of all values around it;"
            " it is scored as it is, and left out where units, instants and causes are looked for:"
            " mend this cell"
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

    @property
    def sheared(self) -> bool:
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
    """A `SurfaceResult` of arrays as they came: points sorted, shapes and numbers checked.

    Parameters
    ----------
    x
        (n_points,), or (n_steps, n_points) where every instant has its own places
    fields
        pressure, and shear and slip or None, (n_steps, n_points) or (n_points,) of a single
        instant
    series
        time, normal_load, tangential_load, (n_steps,) each or None

    Raises
    ------
    InputError
        One sentence: a shape that does not fit, a number that is none, a point that stands there
        twice.
    """
    grids = {
        name: np.atleast_2d(np.array(v, dtype=float)) for name, v in fields.items() if v is not None
    }
    lines = {
        name: np.atleast_1d(np.array(v, dtype=float)) for name, v in series.items() if v is not None
    }
    places, said = np.array(x, dtype=float), list(notes)
    shape = grids["pressure"].shape
    wanted = (
        dict.fromkeys(grids, shape)
        | dict.fromkeys(lines, shape[:1])
        | {"x": shape[1:] if places.ndim == 1 else shape}
    )
    for name, values in (*grids.items(), *lines.items(), ("x", places)):
        if values.shape != wanted[name]:
            raise InputError(
                f"{source}: {name} has the shape {values.shape} where {wanted[name]} is needed:"
                " pressure is (instants, points), x one figure a point, time and loads one an"
                " instant"
            )
        bad = np.argwhere(~(np.abs(values) <= LARGEST))
        if len(bad):
            where = (
                "instant {}, point {}".format(*(bad[0] + 1))
                if values.ndim == 2
                else f"entry {bad[0][0] + 1}"
            )
            raise InputError(
                f"{source}: {name} is no finite number at {where} ({len(bad)} such in all); mend or"
                " leave out these rows"
            )
    for row in np.atleast_2d(np.sort(places)):
        if len(row) < 3:
            raise InputError(
                f"{source}: {len(row)} points are no surface: three at least are needed"
            )
        close = np.flatnonzero(np.diff(row) <= 1e-12 * np.ptp(row))
        if len(close):
            raise InputError(
                f"{source}: the point x = {row[close[0]]:.9g} stands there twice in one instant"
                f" ({len(close)} such in all); leave one out, or name a column that tells the"
                " instants apart (columns.time or columns.frame of a mapping)"
            )
    if places.ndim == 2:
        places, sentence = _one_line(source, places)
        said += [sentence] if sentence else []
    order = np.argsort(places, kind="stable")
    if np.any(np.diff(order) < 0):
        said.append("the points were not in the order of x and were sorted")
    known = {"shear": freeze(np.full(shape, np.nan))} | {
        name: freeze(values[:, order]) for name, values in grids.items()
    }
    known |= {name: freeze(values) for name, values in lines.items()}
    outliers = tuple(
        Outlier(
            quantity=name,
            instant=int(k),
            point=int(i),
            value=float(known[name][k, i]),
            place=f"instant {k + 1}, x = {places[order][i]:.6g}",
            figure=float(known[name][k, i]),
        )
        for name in ("pressure", "shear", "slip")
        if name in known
        for k, i in np.argwhere(spikes(known[name]))
    )
    return SurfaceResult(
        source, code, freeze(places[order]), notes=tuple(said), outliers=outliers, **known
    )


def _one_line(source: str, places: Array) -> tuple[Array, str]:
    """The mean place of each point, and a sentence where it moves from instant to instant."""
    middle = places.mean(axis=0)
    moved = float(np.max(np.abs(places - middle)))
    if moved <= 1e-9 * float(np.ptp(middle)):
        return places[0], ""
    spacing = float(np.median(np.diff(np.sort(middle))))
    if moved > _SAME_PLACE * spacing:
        row, column = np.unravel_index(np.argmax(np.abs(places - middle)), places.shape)
        raise InputError(
            f"{source}: the points are not the same at every instant: point {column + 1} has x ="
            f" {places[row, column]:.6g} at instant {row + 1} and {middle[column]:.6g} in the mean,"
            f" {moved / spacing:.2g} spacings off; give undeformed places"
        )
    return (
        middle,
        (
            f"x moves from instant to instant by at most {moved / spacing:.1g} of the points'"
            " spacing; its mean was taken"
        ),
    )


# ---------------------------------------------------------------------------- the surface of a mesh
def extent(points: Array) -> float:
    """The longest side of the box around the points [length]."""
    return float(np.max(np.ptp(points, axis=0))) if len(points) else 0.0


def one_plane(points: Array, chosen: Integers) -> tuple[Integers, float, list[str]]:
    """Of the `chosen` rows of `points` (n, 3) those of the plane z = const that holds most of them,
    ascending in x.

    Also the depth from the first to the last plane [length], 0 for a plane model, and a sentence
    where there are several.

    >>> thick = np.array([[1.0, 0, 0], [0.0, 0, 0], [0.0, 0, 1.0], [1.0, 0, 1.0]])
    >>> rows, depth, notes = one_plane(thick, np.arange(4))
    >>> rows.tolist(), depth, notes
    ([1, 0], 1.0, ['the model is 1 thick: the tractions are those of its plane z = 0, one of 2'])
    """
    depth = points[chosen, 2]
    order = np.argsort(depth, kind="stable")
    plane = np.empty(len(chosen), np.int64)
    plane[order] = np.concatenate([[0], np.cumsum(np.diff(depth[order]) > SAME * extent(points))])
    taken = int(np.argmax(np.bincount(plane)))  # the lowest where several hold as many
    rows = chosen[plane == taken]
    rows = rows[np.argsort(points[rows, 0], kind="stable")]
    if not plane.any():
        return rows, 0.0, []
    place, thickness = float(depth[plane == taken].min()), float(np.ptp(depth))
    words = (
        f"the model is {thickness:.6g} thick: the tractions are those of its plane z = {place:.6g},"
        f" one of {plane.max() + 1}"
    )
    return rows, thickness, [words]


def material_above(points: Array, cells: Iterable[Integers]) -> Array:
    """(n_points,): how far the middles of a point's cells lie above it in the mean [length]; NaN
    for a point that is in no cell.

    Negative at the top face of the lower body, positive at the bottom face of the upper one.
    `cells` are blocks of rows of points.
    """
    total, count = np.zeros(len(points)), np.zeros(len(points))
    for block in cells:
        np.add.at(total, block, points[block, 1].mean(axis=1)[:, None] - points[block, 1])
        np.add.at(count, block, 1.0)
    return np.divide(total, count, out=np.full(len(points), np.nan), where=count > 0)
