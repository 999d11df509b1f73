"""Errors of half-plane theory at the points of a map, each as bodies/theory - 1, three ways: by the
numbers of the bodies (corrected theory), by their kernels, and by finite elements, which check
both.

The tables of the maps hold a row a point and a way of solving the bodies. Least heights are those
from which the kernel solve is within 1, 5 and 10 % of theory, found by a root finder on |error| =
level.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq

import halfplane_fe
from meshes import MeshSettings
from reports.advising_by_kernels import changes_of
from reports.advising_by_numbers import Change, advise_by_numbers
from reports.charts.templating import table_text
from reports.folder import replace_text
from reports.studies.maps.families import KINDS, Kind, Place
from scenes import Estimate, InputError, Scene

# By what the bodies of a scene are solved.
Way = Literal["numbers", "kernels", "elements"]
ProgressReport = Callable[[int, int, str], None]
QUANTITIES = {
    "dissipation": "dissipation W",
    "peak_pressure": "largest pressure p0",
    "half_width": "largest half-width a",
    "edge_tension": "largest edge tension",
}
"""Errors of a row, and their words."""
QUANTITIES_WITH_HEIGHTS = {
    "dissipation": "W",
    "peak_pressure": "p0",
    "edge_tension": "edge tension",
}
"""Errors that heights are looked for of, and their short words."""
ERROR_LEVELS = (0.01, 0.05, 0.1)
"""Errors of theory up to which the heights are looked for."""
MESH_OF_MAPS = MeshSettings(element_size=1 / 16, edge_element_size=1 / 64)
"""Of the kernel solve: beside the default mesh, which the finite elements have, W within 3e-4, the
edge tension within 6e-3.
"""
# Largest uncertainty of the error of the edge tension: twice what it is where the right instant is
# taken.
_LARGEST_UNCERTAINTY = 0.02
# Error of the logarithm of a height: less than the digits that are shown.
_LOG_HEIGHT_TOLERANCE = 5e-3
# Of an error that is not known.
_UNKNOWN = Estimate(math.nan, math.nan)


class Row(NamedTuple):
    """The errors of half-plane theory at a point of a map, where the bodies are solved in one way;
    NaN of what this way does not give.
    """

    way: Way
    place: Place
    errors: dict[str, Estimate]


def row_at_place(kind: Kind, place: Place, way: Way) -> Row:
    """The errors of half-plane theory (bodies/theory − 1) at one point of a map of errors, which is
    a scene of finite bodies: of dissipation, largest pressure, half-width and edge tension.

    Parameters
    ----------
    kind
        the kind of bodies, with their scene at each point of the map
    place
        height, width and friction coefficient of the point
    way
        by what the bodies are solved: "numbers", theory corrected by their elastic responses;
        "kernels", finite elements of half-planes with the bodies' compliance added; "elements",
        finite elements of the bodies themselves

    Raises
    ------
    InputError, ConvergenceError
        Where that way does not answer.

    Returns
    -------
    Row
        way, place, and quantity -> error with its uncertainty, NaN where it is not known
    """
    scene = kind.scene(place)
    # changes: quantity -> what the bodies change of theory's value
    if way == "numbers":
        advice = advise_by_numbers(scene)
        # where only the size of a change is known no error is stated
        # _errors: error of each quantity, NaN where there is no change for it
        return Row(way, place, _errors({} if advice.reason_for_size_alone else advice.changes))
    if way == "kernels":
        return Row(way, place, _errors(_changes_by_kernels(scene)))
    return Row(way, place, _errors(changes_of(halfplane_fe.solve(scene))))


def _changes_by_kernels(scene: Scene) -> Mapping[str, Change]:
    """What the bodies of a scene change of theory's values, by finite elements of half-planes with
    the bodies' compliance added (kernels).

    They are solved on the mesh of the maps, or on the default one where the mesh of the maps leaves
    the edge tension uncertain by more than 0.02. There the largest tension comes from a single
    instant, which few nodes resolve.
    """
    changes = changes_of(halfplane_fe.solve(scene, MESH_OF_MAPS, bodies="kernel"))
    tension = changes.get("edge_tension")
    if tension is None or tension.relative_change.uncertainty <= _LARGEST_UNCERTAINTY:
        return changes
    return changes_of(halfplane_fe.solve(scene, bodies="kernel"))


def _errors(changes: Mapping[str, Change]) -> dict[str, Estimate]:
    """The error of theory in every quantity of a map (bodies/theory − 1), with its uncertainty,
    from the changes that are known; NaN for the other quantities.
    """
    return {
        quantity: changes[quantity].relative_change if quantity in changes else _UNKNOWN
        for quantity in QUANTITIES
    }


# ------------------------------------------------------------------------------------------- tables
_KEY_COLUMNS = ("way", "height", "width", "friction")


def points_of(kind: Kind) -> list[tuple[Place, Way]]:
    """The points of a map (height, width, friction) and the way by which the bodies are solved at
    each. "kernels" are half-planes with the bodies' compliance added, at every height. "numbers" is
    theory corrected by elastic responses, at every height of bodies with flat faces. "elements" are
    finite elements of the bodies, at a few heights that check the others.
    """
    places_and_ways: list[tuple[Place, Way]] = []
    for place in kind.places(kind.heights):
        places_and_ways.append((place, "kernels"))
        if not kind.is_curved:
            places_and_ways.append((place, "numbers"))
    places_and_ways += [(place, "elements") for place in kind.places(kind.checked_heights)]
    return places_and_ways


def table_of(rows: Sequence[Row]) -> str:
    """The rows of a map as CSV text, six digits: way of solving the bodies, coordinates, then the
    error of theory in each quantity with its uncertainty.
    """
    columns: dict[str, list[str]] = {"way": [row.way for row in rows]}
    # _KEY_COLUMNS: "way", "height", "width", "friction"
    for coordinate in _KEY_COLUMNS[1:]:
        columns[coordinate] = [f"{getattr(row.place, coordinate):g}" for row in rows]
    # QUANTITIES: dissipation, peak pressure, half-width, edge tension
    for quantity in QUANTITIES:
        for field_name in Estimate._fields:  # value, uncertainty
            name = quantity if field_name == "value" else f"{quantity}_{field_name}"
            columns[name] = [_digits(getattr(row.errors[quantity], field_name)) for row in rows]
    return table_text(columns)


def _digits(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.6g}"


def rows_in(table: Path) -> list[Row]:
    """The rows of a map's table, a CSV file: for each point and each way of solving the bodies, the
    errors of half-plane theory. An empty list where the file is not there.

    Raises
    ------
    InputError
        For a file that is no such table.
    """
    if not table.exists():
        return []
    try:
        records = pd.read_csv(table).to_dict("records")
        return [_row_of_record(record) for record in records]
    except (OSError, ValueError, KeyError) as reason:
        raise InputError(f"{table}: this is no table of a map: {reason}") from reason


def _row_of_record(record: dict[str, Any]) -> Row:
    """A row of a map, the errors of theory at a point, from a record of its CSV file. KeyError or
    ValueError for a record of another table.
    """
    errors = {
        quantity: Estimate(float(record[quantity]), float(record[f"{quantity}_uncertainty"]))
        for quantity in QUANTITIES
    }
    place = Place(*(float(record[coordinate]) for coordinate in _KEY_COLUMNS[1:]))
    return Row(record["way"], place, errors)


def compute_missing_rows(kind: Kind, table: Path, report: ProgressReport) -> bool:
    """Compute the rows that the table of a map of errors still lacks, and write the table after
    each. Returns whether any row was computed.

    A row has the errors of half-plane theory at a place of the map (height, width, friction), where
    the bodies are solved in one way: "numbers", "kernels" or "elements".

    Parameters
    ----------
    kind
        the kind of bodies
    table
        the CSV file
    report
        called with (number of the row, how many, text)
    """
    rows = {(row.place, row.way): row for row in rows_in(table)}
    # all points (place, way) of the map, in the order of the table
    places_and_ways = points_of(kind)
    missing_places_and_ways = [
        place_and_way for place_and_way in places_and_ways if place_and_way not in rows
    ]
    for number, (place, way) in enumerate(missing_places_and_ways, start=1):
        report(number, len(missing_places_and_ways), f"{kind.title}, {way}")
        rows[place, way] = row_at_place(kind, place, way)
        rows_so_far = [
            rows[place_and_way] for place_and_way in places_and_ways if place_and_way in rows
        ]
        replace_text(table, table_of(rows_so_far))
    return bool(missing_places_and_ways)


# ------------------------------------------------------------------------------------ least heights
class LeastHeight(NamedTuple):
    """From which height on the error of theory in a quantity is at most a level, for bodies of one
    width.

    Attributes
    ----------
    height
        over a, the larger of all frictions: 0 where theory is within it at every height of the
        map, infinite where at none
    """

    width: float
    quantity: str
    level: float
    height: float


def least_heights_of(kind: Kind, rows: Sequence[Row], report: ProgressReport) -> list[LeastHeight]:
    """The least heights of bodies from which on half-plane theory is within 1, 5 and 10 %, for
    every width and quantity of a map. Each is the largest of those for the map's friction
    coefficients. Theory is compared with half-planes to which the bodies' compliance is added
    (kernels). Heights are over the half-width of contact.

    Parameters
    ----------
    kind
        the kind of bodies: the widths and friction coefficients of the map, and whether the faces
        are arcs, which have no edge tension
    rows
        errors of theory at the points of the map; a row's `place` is height, width, friction, its
        `way` that of solving the bodies
    report
        called with (number, how many, text)
    """
    # QUANTITIES_WITH_HEIGHTS: "dissipation", "peak_pressure" and "edge_tension"
    quantities = list(QUANTITIES_WITH_HEIGHTS)
    if kind.is_curved:
        quantities.remove("edge_tension")
    # ERROR_LEVELS: 0.01, 0.05 and 0.1
    combinations = [
        (width, quantity, level)
        for width in kind.widths
        for quantity in quantities
        for level in ERROR_LEVELS
    ]
    # for each combination the largest of all friction coefficients
    least_heights = []
    for number, (width, quantity, level) in enumerate(combinations, start=1):
        report(number, len(combinations), f"{kind.title}: heights")
        heights = []
        for friction in kind.frictions:
            rows_of_line = [
                row for row in rows if row.way == "kernels" and row.place[1:] == (width, friction)
            ]
            heights.append(_least_height(kind, rows_of_line, quantity, level))
        least_heights.append(LeastHeight(width, quantity, level, max(heights)))
    return least_heights


def _least_height(kind: Kind, rows_of_line: Sequence[Row], quantity: str, level: float) -> float:
    """The least height of a body, over a, from which on |error| of a quantity by half-plane theory
    stays below `level`.

    It lies between the last point above the level and the next one, and is found by Brent's method
    in the logarithms of height and error. Each trial solves half-planes with the compliance of the
    body added. 0 where all points are below, infinite where the highest body is still above. A
    point whose error is not known (NaN) counts as above; the height is then that of the next one.

    Parameters
    ----------
    kind
        kind of bodies of the map
    rows_of_line
        errors of theory at points of the map that differ in height alone, ascending; a row's
        `place` has the height over the half-width of contact
    quantity
        name of the quantity whose error is meant
    level
        largest |error| that is allowed, 0.05 for 5 %
    """
    # points above the level, and the last of them
    error_sizes = np.array([abs(row.errors[quantity].value) for row in rows_of_line])
    indices_above = np.flatnonzero(~(error_sizes <= level))
    if not len(indices_above):
        return 0.0
    last_above = int(indices_above[-1])
    if last_above + 1 == len(rows_of_line):
        return math.inf

    # the last row above the level and the first one below it
    rows_at_ends = rows_of_line[last_above : last_above + 2]
    if math.isnan(error_sizes[last_above]):
        return rows_at_ends[1].place.height
    log_heights = [math.log(row.place.height) for row in rows_at_ends]
    row_by_log_height = dict(zip(log_heights, rows_at_ends, strict=True))  # known already

    def log_excess(log_height: float) -> float:
        """Logarithm of |error|/level; an error below 1e-9 counts as that."""
        row = row_by_log_height.get(log_height)
        if row is None:
            place = rows_at_ends[0].place._replace(height=math.exp(log_height))
            row = _row_by_kernels(kind.name, place)
        error = row.errors[quantity].value
        return math.log(max(abs(error), 1e-9) / level)

    # _LOG_HEIGHT_TOLERANCE: 5e-3
    return math.exp(brentq(log_excess, *log_heights, xtol=_LOG_HEIGHT_TOLERANCE))


@lru_cache(maxsize=256)
def _row_by_kernels(name: str, place: Place) -> Row:
    return row_at_place(KINDS[name], place, "kernels")


def table_of_heights(least_heights: Sequence[LeastHeight]) -> str:
    """Least heights from which theory holds, as CSV text: width, quantity, level of error,
    height.
    """
    columns: dict[str, list[str]] = {
        name: [_cell(getattr(row, name)) for row in least_heights] for name in LeastHeight._fields
    }
    return table_text(columns)


def _cell(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def least_heights_in(table: Path) -> list[LeastHeight]:
    """The least heights from which theory holds, as stored in a CSV file (`table`); none where the
    file is not there. InputError for a file that is no such table.
    """
    if not table.exists():
        return []
    try:
        records = pd.read_csv(table).to_dict("records")
        return [LeastHeight(**record) for record in records]
    except (OSError, ValueError, TypeError) as reason:
        raise InputError(f"{table}: this is no table of heights: {reason}") from reason
