"""The maps of the idealisation error: their points, the heights from which theory holds, and the
published pages.
"""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import semi_analytic
from reports.folder import replace_text
from reports.studies.maps import errors, pages
from reports.studies.maps.errors import (
    ERROR_LEVELS,
    QUANTITIES,
    LeastHeight,
    Row,
    Way,
    compute_missing_rows,
    least_heights_in,
    least_heights_of,
    points_of,
    row_at_place,
    rows_in,
    table_of,
    table_of_heights,
)
from reports.studies.maps.families import KINDS, Kind, Place
from reports.studies.maps.pages import PUBLISHED, Tables
from scenes import EllipseLoad, Estimate, FlatRounded, InputError

MAPS = {tables.kind.name: tables for tables in pages.stored_maps(PUBLISHED)}
# By which the largest pressure at nodes of finite elements strays next to the end of a flat; see
# `smooth_largest_pressure` in test_halfplane_fe_kernels.
LEFT_OF_FLAT_PAD = 6e-3
# Half-widths of flat pads by kernels and by elements differ by so much of what both state, at most:
# 1.08 at one of 36 places.
HALF_WIDTH_OF_FLAT_PAD = 1.1
# By which the edge tension moves from the mesh of the maps to that of the finite elements, of which
# the kernels are not the cause: finite elements on the mesh of the maps move as much.
MESH_OF_TENSION = 6e-3


def silent(*_: Any) -> None:
    """No report."""


def of_square_law(kind: Kind, place: Place, way: Way) -> Row:
    """Errors (2/h)^2 of every quantity, f times as large."""
    error = -place.friction * (2 / place.height) ** 2
    return Row(way, place, dict.fromkeys(QUANTITIES, Estimate(error, 1e-5)))


# ------------------------------------------------------------------------------------ kinds of body
@pytest.mark.parametrize("name", KINDS)
def test_half_width_at_the_mean_load_is_1_and_the_height_is_that_of_the_body(name: str) -> None:
    kind = KINDS[name]
    place = Place(kind.heights[1], kind.widths[0], 0.3)
    scene = kind.scene(place)
    assert isinstance(scene.load, EllipseLoad)
    answer = semi_analytic.solve(scene, fields=())
    at_mean_load = np.interp(
        scene.load.mean_normal_load,
        *(
            values[answer.last_cycle[:9]]
            for values in (answer.normal_load, answer.contact_half_width)
        ),
    )
    assert at_mean_load == pytest.approx(1.0, abs=0.01)
    assert scene.load.tangential_amplitude < 0.3 * scene.load.mean_normal_load
    body = scene.bodies.upper if kind.is_curved else scene.bodies.lower
    assert getattr(body, "flange_height", getattr(body, "height", None)) == place.height
    if kind.is_curved:
        assert scene.profile.radius == place.height
    assert isinstance(scene.profile, FlatRounded) is kind.is_flat_pad


# ----------------------------------------------------------------------------- tables and distances
def test_heights_are_where_the_error_is_the_level(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the larger friction, and the ends of the map where there is no such height."""
    monkeypatch.setattr(errors, "row_at_place", of_square_law)
    errors._row_by_kernels.cache_clear()
    kind = KINDS["block"]
    rows = [of_square_law(kind, place, "kernels") for place in kind.places(kind.heights)]
    least_heights = least_heights_of(kind, rows, silent)
    errors._row_by_kernels.cache_clear()
    assert len(least_heights) == len(kind.widths) * 3 * len(ERROR_LEVELS)
    for distance in least_heights:
        height = 2 * math.sqrt(0.9 / distance.level)
        expected = height if height > kind.heights[0] else 0.0
        assert distance.height == pytest.approx(expected, rel=5e-3)
    never = [row._replace(errors=dict.fromkeys(QUANTITIES, Estimate(0.5, 0.0))) for row in rows]
    assert {distance.height for distance in least_heights_of(kind, never, silent)} == {math.inf}
    unknown = dict.fromkeys(QUANTITIES, Estimate(math.nan, math.nan))
    small = dict.fromkeys(QUANTITIES, Estimate(1e-3, 0.0))
    lowest_unknown = [
        row._replace(errors=unknown if row.place.height == kind.heights[0] else small)
        for row in rows
    ]
    least_heights = least_heights_of(kind, lowest_unknown, silent)
    assert {distance.height for distance in least_heights} == {kind.heights[1]}
    assert {distance.quantity for distance in least_heights_of(KINDS["pad"], [], silent)} == {
        "dissipation",
        "peak_pressure",
    }


def test_tables_come_back_and_what_they_hold_is_not_computed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kind = KINDS["pair"]
    table = tmp_path / "pair.csv"
    points = points_of(kind)
    known = [of_square_law(kind, place, way) for place, way in points]
    half = len(known) // 2
    unknown = dict.fromkeys(QUANTITIES, Estimate(math.nan, math.nan))
    known[0] = known[0]._replace(errors=unknown)
    replace_text(table, table_of(known[:half]))
    asked = []

    def counted(kind: Kind, place: Place, way: Way) -> Row:
        asked.append((place, way))
        return of_square_law(kind, place, way)

    monkeypatch.setattr(errors, "row_at_place", counted)
    assert compute_missing_rows(kind, table, silent)
    assert asked == points[half:]
    assert not compute_missing_rows(kind, table, silent)
    rows = rows_in(table)
    assert math.isnan(rows[0].errors["edge_tension"].value)
    for row, before in zip(rows[1:], known[1:], strict=True):
        assert row[:2] == before[:2]
        for quantity in QUANTITIES:
            assert row.errors[quantity] == pytest.approx(before.errors[quantity], rel=1e-5)
    least_heights = [
        LeastHeight(2.0, "dissipation", 0.01, math.inf),
        LeastHeight(1.0, "x", 0.1, 5.25),
    ]
    replace_text(tmp_path / "heights.csv", table_of_heights(least_heights))
    assert least_heights_in(tmp_path / "heights.csv") == least_heights


def test_a_table_that_is_none_is_refused(tmp_path: Path) -> None:
    table = tmp_path / "pair.csv"
    table.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="no table of a map"):
        rows_in(table)
    with pytest.raises(InputError, match="no table of heights"):
        least_heights_in(table)
    with pytest.raises(InputError, match="no map has its tables here"):
        pages.write(tmp_path / "nowhere")


def test_a_map_without_its_kernel_solves_is_left_out(tmp_path: Path) -> None:
    """An interrupted one stopped the pages of all others."""
    for name in ("block", "pair"):
        for table in pages.table_names(KINDS[name]):
            shutil.copy(PUBLISHED / table, tmp_path / table)
    rows = (tmp_path / "pair.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    kept = [row for row in rows if not row.startswith("kernels,")]
    replace_text(tmp_path / "pair.csv", "".join(kept))
    pages.write(tmp_path)
    assert (tmp_path / "block.md").exists()
    assert not (tmp_path / "pair.md").exists()


# ----------------------------------------------------------------------------------- published maps
@pytest.mark.parametrize("name", KINDS)
def test_pages_and_figures_are_those_of_the_tables(name: str) -> None:
    tables = MAPS[name]
    assert [(row.place, row.way) for row in tables.rows] == points_of(tables.kind)
    assert (PUBLISHED / f"{name}.md").read_text(encoding="utf-8") == pages.page(tables)
    assert (PUBLISHED / f"{name}.svg").read_text(encoding="utf-8") == pages.figure(tables).svg()


def test_the_first_page_is_that_of_the_tables_and_all_is_small() -> None:
    first_page = (PUBLISHED / "README.md").read_text(encoding="utf-8")
    assert first_page == pages.index(list(MAPS.values()))
    assert sum(path.stat().st_size for path in PUBLISHED.iterdir()) < 5e5


def beside(tables: Tables, way: Way) -> list[tuple[str, Place, Estimate, Estimate]]:
    """Errors by a way and by kernels, by quantity and place."""
    by_kernels = {row.place: row.errors for row in tables.rows if row.way == "kernels"}
    return [
        (quantity, row.place, row.errors[quantity], by_kernels[row.place][quantity])
        for row in tables.rows
        if row.way == way
        for quantity in QUANTITIES
        if not math.isnan(row.errors[quantity].value + by_kernels[row.place][quantity].value)
    ]


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("way", ["numbers", "elements"])
def test_the_ways_agree_within_what_they_state(name: str, way: Way) -> None:
    compared = beside(MAPS[name], way)
    assert bool(compared) is not (way == "numbers" and KINDS[name].is_curved)
    for quantity, place, other, by_kernels in compared:
        allowed = other.uncertainty + by_kernels.uncertainty
        if KINDS[name].is_flat_pad and quantity == "peak_pressure":
            allowed += LEFT_OF_FLAT_PAD
        if KINDS[name].is_flat_pad and quantity == "half_width":
            allowed *= HALF_WIDTH_OF_FLAT_PAD
        if quantity == "edge_tension":
            allowed += MESH_OF_TENSION * (1 + other.value)
        assert abs(other.value - by_kernels.value) <= allowed, (quantity, place)


@pytest.mark.parametrize("name", KINDS)
def test_heights_lie_between_the_points_that_they_part(name: str) -> None:
    tables = MAPS[name]
    for width, quantity, level, height in tables.least_heights:
        for row in tables.rows:
            if row.way == "kernels" and row.place.width == width and row.place.height > height:
                assert abs(row.errors[quantity].value) <= level


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_points_are_computed_again(name: str) -> None:
    tables = MAPS[name]
    place = tables.kind.places(tables.kind.checked_heights)[1]
    for row in tables.rows:
        if row.place != place:
            continue
        again = row_at_place(tables.kind, place, row.way)
        for quantity, stored in row.errors.items():
            fresh = again.errors[quantity]
            assert math.isnan(stored.value) == math.isnan(fresh.value)
            if not math.isnan(stored.value):
                assert fresh.value == pytest.approx(stored.value, abs=0.05 * stored.uncertainty)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_a_height_is_that_of_the_kernel_solve(name: str) -> None:
    tables = MAPS[name]
    found = next(row for row in tables.least_heights if 0 < row.height < math.inf)
    sizes = [
        abs(
            row_at_place(tables.kind, Place(found.height, found.width, friction), "kernels")
            .errors[found.quantity]
            .value
        )
        for friction in tables.kind.frictions
    ]
    assert max(sizes) == pytest.approx(found.level, rel=0.02)
