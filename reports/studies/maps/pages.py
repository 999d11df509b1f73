"""Figures, tables and pages of the maps, from the tables of errors and heights in a folder."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from reports.charts.plate import Axis, Curve, Dot, Key, Mark, Panel, Plate, Rule, tick_labels
from reports.charts.templating import markdown_table
from reports.comparison.why import in_percent, percent_of
from reports.folder import MANIFEST, results_folder, usable_folder
from reports.studies.maps.errors import (
    ERROR_LEVELS,
    QUANTITIES,
    QUANTITIES_WITH_HEIGHTS,
    LeastHeight,
    Row,
    Way,
    least_heights_in,
    rows_in,
)
from reports.studies.maps.families import KINDS, Kind, Place
from reports.studies.sweep.page import bar_curve
from scenes import Estimate, InputError

HEADS_OF_HEIGHTS = ("kind", "width/height", *QUANTITIES_WITH_HEIGHTS.values())
PUBLISHED = Path(__file__).parents[2] / "published" / "maps"
# Errors below this are not drawn [%]: less than the uncertainty of finite elements.
_LEAST_DRAWN = 0.03
# Lower end of a panel's axis at most [%], so that 1 % is in it.
_HIGHEST_FOOT = 0.5
_TICKS = (0.1, 1.0, 5.0, 10.0, 100.0)  # [%]
# Of a panel [pixels].
_WIDTH = 310.0
_HEIGHT = 250.0
_CAPTION = (
    "|Error| of half-plane theory. Lines: kernel solve, where it is above its uncertainty; rings:"
    " numbers of the bodies; dots with bars: finite elements and their uncertainty."
)


_NO_TENSION = (
    "The kernels state no edge tension of arcs: terms of the order of a/R in it are not in linear"
    " elasticity."
)


class Tables(NamedTuple):
    """The two tables of a map: errors at its points, and heights from which theory holds."""

    kind: Kind
    rows: list[Row]
    least_heights: list[LeastHeight]


def table_names(kind: Kind) -> tuple[str, str]:
    """Files of errors and of heights of a kind."""
    return f"{kind.name}.csv", f"{kind.name}-heights.csv"


def require_free(folder: Path) -> None:
    """InputError where `folder` holds a file that this program did not write and that a page or
    figure of the maps would replace. It is called before the maps are solved, which takes an hour.
    """
    names = [MANIFEST, "README.md"]
    for kind in KINDS.values():
        names += [f"{kind.name}.md", f"{kind.name}.svg"]
    usable_folder(folder, names)


def stored_maps(folder: Path) -> list[Tables]:
    """The maps of errors of theory that are complete in `folder`. Of these the tables of errors and
    of least heights are there. Half-planes with the bodies' compliance ("kernels") were solved at
    every point where finite elements ("elements") were. A map that was interrupted is not among
    them.

    `KINDS` has the kinds of bodies, with a map each.
    """
    maps = []
    for kind in KINDS.values():
        file_of_errors, file_of_heights = (folder / name for name in table_names(kind))
        if not (file_of_errors.exists() and file_of_heights.exists()):
            continue
        tables = Tables(kind, rows_in(file_of_errors), least_heights_in(file_of_heights))
        solved_places = _errors_by_place(tables.rows, "kernels").keys()
        if solved_places and _errors_by_place(tables.rows, "elements").keys() <= solved_places:
            maps.append(tables)
    return maps


def write(folder: Path) -> None:
    """Write figures and pages of the maps of errors whose tables are in `folder`: all files, or
    none where one fails.

    Raises
    ------
    InputError
        Where there are no tables.
    """
    maps = stored_maps(folder)
    if not maps:
        raise InputError(f"{folder}: no map has its tables here; make them by `halfplane map all`")
    # a temporary folder, whose files move to `folder` at the end
    with results_folder(folder, stale_prefixes=()) as staging_folder:
        for tables in maps:
            name = tables.kind.name
            (staging_folder / f"{name}.svg").write_text(figure(tables).svg(), encoding="utf-8")
            (staging_folder / f"{name}.md").write_text(page(tables), encoding="utf-8")
        (staging_folder / "README.md").write_text(index(maps), encoding="utf-8")


# -------------------------------------------------------------------------------------------- pages
def page(tables: Tables) -> str:
    """The Markdown page of one map of errors: figure, heights from which theory holds, and a table
    of errors by finite elements beside those by half-planes with the bodies' compliance (kernels).

    `tables` has the kind of bodies (with the words for its coordinates), the errors of theory at
    the points of the map, and the least heights.
    """
    # The table on the page: a row for each place (height, width, friction) that finite elements
    # check. It has the errors [%] of those quantities that they give, with their uncertainty
    # (_percent), and those by kernels without it (_value).
    kind = tables.kind
    shown_quantities = _quantities(tables, "elements")
    heads = [kind.height_words, kind.width_words, "f"]
    for quantity in shown_quantities:
        # QUANTITIES: name of a quantity -> its words
        heads += [f"{QUANTITIES[quantity]}, %", "kernels"]
    errors_by_kernels = _errors_by_place(tables.rows, "kernels")
    table_rows = []
    for place, errors_by_elements in _errors_by_place(tables.rows, "elements").items():
        cells = [f"{coordinate:g}" for coordinate in place]
        for quantity in shown_quantities:
            cells.append(_percent(errors_by_elements[quantity]))
            cells.append(_value(errors_by_kernels[place][quantity]))
        table_rows.append(cells)

    # the page; `heights_of`: table of the least heights; _CAPTION, _NO_TENSION: sentences
    lines = [
        f"# {kind.title}",
        f"<!-- written by `halfplane map {kind.name}` -->",
        f"{kind.shape} {kind.height_words} is of the half-width a at the mean load; the cycle is"
        " the paper's. [All maps](README.md).",
        f"![Error of theory over {kind.height_words}]({kind.name}.svg)",
        f"*{_CAPTION}*",
        f"## {kind.height_words} from which theory is within 1, 5, 10 %",
        heights_of([tables]),
        "## Finite elements beside the kernel solve",
        markdown_table(heads, table_rows),
        f"Error = finite elements/theory − 1. [All points]({kind.name}.csv).",
    ]
    if kind.is_curved:
        lines.append(_NO_TENSION)
    return "\n\n".join(lines) + "\n"


def index(maps: Sequence[Tables]) -> str:
    """The Markdown of the first page of the maps: heights from which theory holds for all kinds of
    bodies, and links to their maps.
    """
    lines = [
        "# Maps: where half-plane theory holds",
        "<!-- written by `halfplane map all` -->",
        "Least height/a (of pads R/a) from which half-plane theory is within 1, 5, 10 % of the"
        " kernel solve, at f = 0.3 and 0.9, and above.",
        heights_of(maps),
        "\n".join(
            f"- [{tables.kind.name}]({tables.kind.name}.md): {tables.kind.shape}" for tables in maps
        ),
    ]
    return "\n\n".join(lines) + "\n"


def heights_of(maps: Sequence[Tables]) -> str:
    """Markdown of the designer's table: a row a kind and width, a cell the three heights."""
    return markdown_table(HEADS_OF_HEIGHTS, rows_of_heights(maps))


def rows_of_heights(maps: Sequence[Tables]) -> list[list[str]]:
    """Rows of the designer's table: kind of bodies, width, and for each quantity the least heights
    from which theory is within 1, 5 and 10 %. `maps` are the tables of each kind of bodies.
    """
    rows = []
    for tables in maps:
        width_in_words = f"{tables.kind.width_words} " if tables.kind.is_flat_pad else ""
        for width in tables.kind.widths:
            cells = [tables.kind.name, f"{width_in_words}{width:g}"]
            # QUANTITIES_WITH_HEIGHTS: "dissipation", "peak_pressure" and "edge_tension"
            cells += [_heights(tables, width, quantity) for quantity in QUANTITIES_WITH_HEIGHTS]
            rows.append(cells)
    return rows


def _heights(tables: Tables, width: float, quantity: str) -> str:
    """The least heights from which theory holds for a quantity and a width of bodies, at all levels
    of error (1, 5 and 10 %), as text; "–" where there are none.
    """
    heights = {
        least_height.level: least_height.height
        for least_height in tables.least_heights
        if least_height.width == width and least_height.quantity == quantity
    }
    if not heights:
        return "–"
    return "; ".join(_height(tables.kind, heights[level]) for level in ERROR_LEVELS)


def _height(kind: Kind, height: float) -> str:
    """A least height as text, rounded up to a tenth. Where theory holds at all heights of the map
    (0) it is "≤" the lowest of them, where at none (infinite) ">" the highest.
    """
    if height == 0:
        return f"≤{kind.heights[0]:g}"
    if math.isinf(height):
        return f">{kind.heights[-1]:g}"
    return f"{math.ceil(10 * height) / 10:g}"


def _percent(error: Estimate) -> str:
    return "–" if math.isnan(error.value) else percent_of(error).removesuffix(" %")


def _value(error: Estimate) -> str:
    return "–" if math.isnan(error.value) else in_percent(error.value)


def _errors_by_place(rows: Sequence[Row], way: Way) -> dict[Place, dict[str, Estimate]]:
    """The errors of theory at each point of a map at which the bodies are solved in one way."""
    return {row.place: row.errors for row in rows if row.way == way}


def _quantities(tables: Tables, way: Way) -> list[str]:
    """The quantities whose errors are known at any point of a map by one way of solving the
    bodies.
    """
    errors_at_points = _errors_by_place(tables.rows, way).values()
    return [
        quantity
        for quantity in QUANTITIES
        if not all(math.isnan(errors[quantity].value) for errors in errors_at_points)
    ]


# ------------------------------------------------------------------------------------------ figures
def figure(tables: Tables) -> Plate:
    """The figure of a map of errors of half-plane theory. It has a panel for each quantity, with
    |error| in per cent over the height of the bodies, and a line for each width and friction
    coefficient f.

    `tables` has the kind of bodies (with the widths and frictions of the map, and the words for its
    coordinates), and the errors at its points.
    """
    kind = tables.kind
    # (width, friction) -> number of the colour, and class of the line in the style sheet
    line_looks: dict[tuple[float, float], tuple[int, str]] = {}
    legend_keys = []
    for colour_number, width in enumerate(kind.widths):
        for friction, line_style in zip(kind.frictions, ("", " dash"), strict=False):
            line_looks[width, friction] = (colour_number, line_style)
            line_in_words = f"{kind.width_words} {width:g}, f = {friction:g}"
            # Key: an entry of the legend, its look and text
            legend_keys.append(Key(f"c{colour_number}{line_style}", line_in_words))
    panels = [_panel(tables, quantity, line_looks) for quantity in _quantities(tables, "kernels")]
    # _CAPTION: the sentences below the figure
    # Plate: name, title, caption, description, panels, CSV table, legend, panels in a row
    return Plate(
        kind.name, kind.title, _CAPTION, _CAPTION, tuple(panels), {}, tuple(legend_keys), 2
    )


def _panel(
    tables: Tables, quantity: str, line_looks: dict[tuple[float, float], tuple[int, str]]
) -> Panel:
    """A panel of a map of errors of half-plane theory: |error| of one quantity in per cent over the
    height of the bodies, both logarithmic. It has a line for each width and friction in
    `line_looks`, which gives the number of its colour and its style.

    `tables` has the kind of bodies, and the errors at the points of its map. The `place` of a point
    is its height, width and friction.
    """
    kind = tables.kind
    x_axis = Axis(
        0.9 * kind.heights[0],
        1.1 * kind.heights[-1],
        kind.height_words,
        log=True,
        ticks=tuple(zip(kind.heights, tick_labels(kind.heights), strict=True)),
    )
    # rules across the panel at 1, 5 and 10 % (ERROR_LEVELS), and the lines of the map
    marks: list[Mark] = [Rule(100 * level, "slope order-2") for level in ERROR_LEVELS]
    for (width, friction), (colour_number, line_style) in line_looks.items():
        rows_of_line = [row for row in tables.rows if row.place[1:] == (width, friction)]
        marks += _marks_of_line(rows_of_line, quantity, colour_number, line_style)
    # QUANTITIES: name of a quantity -> its words; _WIDTH, _HEIGHT: of a panel [pixels]
    title = QUANTITIES[quantity]
    y_axis = _error_axis(tables.rows, quantity)
    return Panel(quantity, x_axis, y_axis, marks, title, _WIDTH, _HEIGHT, title)


def _error_axis(rows: Sequence[Row], quantity: str) -> Axis:
    """The axis of |error| of a quantity in per cent, logarithmic, for the errors at the points of a
    map (`rows`). It goes from two thirds of the least error, between 0.03 and 0.5, to 1.5 times the
    largest one, at least 15.
    """
    errors_in_percent = [100 * abs(row.errors[quantity].value) for row in rows]
    largest_error = float(np.nanmax(errors_in_percent))
    lower_end = float(np.clip(np.nanmin(errors_in_percent) / 1.5, _LEAST_DRAWN, _HIGHEST_FOOT))
    upper_end = max(1.5 * largest_error, 15.0)
    ticks = [tick for tick in _TICKS if lower_end <= tick <= upper_end]
    return Axis(
        lower_end,
        upper_end,
        "|error|, %",
        log=True,
        ticks=tuple(zip(ticks, tick_labels(ticks), strict=True)),
    )


def _marks_of_line(
    rows_of_line: Sequence[Row], quantity: str, colour_number: int, line_style: str
) -> Iterator[Mark]:
    """The marks for one width and friction of a map: |error of theory| in per cent over the height.
    Errors by kernels (half-planes with the bodies' compliance) are a line, those by corrected
    theory rings, those by finite elements dots with bars. Errors below their uncertainty are left
    out of the line, and errors below 0.03 % (`_LEAST_DRAWN`) are not drawn.

    Parameters
    ----------
    rows_of_line
        errors of theory at the points of the line: a row's `way` of solving the bodies is
        "kernels", "numbers" (corrected theory) or "elements" (finite elements)
    quantity
        name of the quantity
    colour_number
        number of the colour in the style sheet
    line_style
        class of the line in the style sheet, " dash" or "" for a solid one
    """
    # the line
    rows_by_kernels = [row for row in rows_of_line if row.way == "kernels"]
    heights = np.array([row.place.height for row in rows_by_kernels])
    # in per cent
    errors = np.array([100 * abs(row.errors[quantity].value) for row in rows_by_kernels])
    uncertainties = np.array([100 * row.errors[quantity].uncertainty for row in rows_by_kernels])
    is_hidden = (errors < _LEAST_DRAWN) | (errors <= uncertainties)
    yield Curve(heights, np.where(is_hidden, np.nan, errors), f"c{colour_number}{line_style}")

    # rings and dots
    for row in rows_of_line:
        error = row.errors[quantity]
        error_in_percent = 100 * abs(error.value)
        if row.way == "kernels" or not error_in_percent >= _LEAST_DRAWN:
            continue
        if row.way == "numbers":
            # Dot: x, y, look in the style sheet, radius
            yield Dot(row.place.height, error_in_percent, f"c{colour_number} hollow", 2.6)
            continue
        uncertainty = 100 * error.uncertainty
        ends_of_bar = (
            np.array([max(error_in_percent - uncertainty, _LEAST_DRAWN)]),
            np.array([error_in_percent + uncertainty]),
        )
        yield bar_curve(np.array([row.place.height]), *ends_of_bar, f"c{colour_number}")
        yield Dot(row.place.height, error_in_percent, f"p{colour_number}", 3.4)
