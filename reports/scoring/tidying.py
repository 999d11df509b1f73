"""From rows of numbers to fields on one line of points, and the refusal of what is none: NaN, points twice, ragged instants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.scoring.surface import SurfaceResult
from scenes import InputError, freeze
from scenes.measured import LARGEST

Array = NDArray[np.float64]

# Deformed places of one point may differ from instant to instant by this share of the spacing; beyond it they are no one point.
SAME_PLACE = 0.1


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
    x : (n_points,), or (n_steps, n_points) where every instant has its own places
    fields : pressure, shear, and slip or None, (n_steps, n_points) or (n_points,) of a single instant
    series : time, normal_load, tangential_load, (n_steps,) each or None

    Raises
    ------
    InputError
        One sentence: a shape that does not fit, a number that is none, a point that stands there twice.
    """
    grids = {name: np.atleast_2d(np.array(v, dtype=float)) for name, v in fields.items() if v is not None}
    lines = {name: np.atleast_1d(np.array(v, dtype=float)) for name, v in series.items() if v is not None}
    places = np.array(x, dtype=float)
    said = list(notes)
    shape = grids["pressure"].shape
    for name, values in (*grids.items(), *lines.items()):
        _check(source, name, values, shape if values.ndim == 2 else shape[:1])
    _check(source, "x", places, shape[1:] if places.ndim == 1 else shape)
    if places.ndim == 2:
        places, sentence = _one_line(source, places)
        said += [sentence] if sentence else []
    order = np.argsort(places, kind="stable")
    if np.any(np.diff(order) < 0):
        said.append("the points were not in the order of x and were sorted")
    places = places[order]
    _refuse_twice(source, places)
    found = SurfaceResult(source, code, freeze(places), grids["pressure"], grids["shear"], notes=tuple(said))
    sorted_grids = {name: freeze(values[:, order]) for name, values in grids.items()}
    return replace(found, **sorted_grids, **{name: freeze(values) for name, values in lines.items()})  # type: ignore[arg-type]


def _check(source: str, name: str, values: Array, shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise InputError(
            f"{source}: {name} has the shape {values.shape} where {shape} is needed: pressure is (instants, points), "
            f"x one figure a point, time and loads one an instant"
        )
    bad = np.argwhere(~(np.abs(values) <= LARGEST))
    if len(bad):
        where = "instant {}, point {}".format(*(bad[0] + 1)) if values.ndim == 2 else f"entry {bad[0][0] + 1}"
        raise InputError(f"{source}: {name} is no finite number at {where} ({len(bad)} such in all); mend or leave out these rows")


def _one_line(source: str, places: Array) -> tuple[Array, str]:
    """The mean place of each point, and a sentence where it moves from instant to instant."""
    for row in places:
        _refuse_twice(source, np.sort(row))
    middle = places.mean(axis=0)
    moved = float(np.max(np.abs(places - middle)))
    if moved <= 1e-9 * float(np.ptp(middle)):
        return places[0], ""
    spacing = float(np.median(np.diff(np.sort(middle))))
    if moved > SAME_PLACE * spacing:
        row, column = np.unravel_index(np.argmax(np.abs(places - middle)), places.shape)
        raise InputError(
            f"{source}: the points are not the same at every instant: point {column + 1} has x = {places[row, column]:.6g} at "
            f"instant {row + 1} and {middle[column]:.6g} in the mean, {moved / spacing:.2g} spacings off; give undeformed places"
        )
    return middle, f"x moves from instant to instant by at most {moved / spacing:.1g} of the points' spacing; its mean was taken"


def _refuse_twice(source: str, x: Array) -> None:
    if len(x) < 3:
        raise InputError(f"{source}: {len(x)} points are no surface: three at least are needed")
    close = np.flatnonzero(np.diff(x) <= 1e-12 * np.ptp(x))
    if len(close):
        raise InputError(
            f"{source}: the point x = {x[close[0]]:.9g} stands there twice in one instant ({len(close)} such in all); "
            "leave one out, or name a column that tells the instants apart (columns.time or columns.frame of a mapping)"
        )
