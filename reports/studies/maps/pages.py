"""Laws, drawings and pages of the maps from the tables of their studies; the words are in
maps.toml.
"""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reports.charts.plate import (
    Axis,
    Cell,
    Curve,
    Dot,
    Key,
    Mark,
    Note,
    Panel,
    Plate,
    colour_scale,
    labels,
)
from reports.charts.templating import markdown_table
from reports.comparison.words import with_uncertainty
from reports.folder import MANIFEST, claim, filled
from reports.studies.maps.advice import FIGURES, RATIO, cells, parts_of, percent, total, work_lines
from reports.studies.maps.corrections import (
    Curvatures,
    added_curvatures,
    corrected_dissipation,
    curvature_sum,
    dissipation_error,
    ellipse_path,
    work_constant,
)
from reports.studies.maps.laws import (
    AXES,
    MAPS,
    PAGE_WORDS,
    WORDS,
    Chart,
    Line,
    Map,
    along,
    bound,
    bound_in_words,
    cell_text,
    errors,
    figures,
    leading_constant,
    lines,
    numbers,
    parts,
    place,
    points_of,
    read,
)
from reports.studies.sweep.page import bars, cell_borders, heat_map
from scenes import InputError, load_scene
from scenes.array_types import Array

DESIGNER = Path(__file__).with_name("designer.toml")
_DRAWN = ("error.dissipation", "error.peak_dissipation", "error.p0", "error.contact_half_width")
_TABLED = (*_DRAWN, "error.permanent_stick_half_width", "error.stick_half_width")
_LEVELS = (0.01, 0.05, 0.1)
_PROBE = 0.02  # curvature at which the sensitivity of dissipation is taken
_SMALL = 0.05  # a/h at which derived constants are taken
_LOOKS = 8
_LOOK_OF_LEVEL = {1.0: "white fine", 5.0: "white", 10.0: "white bold"}
# per cent, the colours' ends
_LEAST = 0.02
_MOST = 80.0
_BAR = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
_MARKED = tuple(digit * 10.0**power for power in range(-4, 1) for digit in (1, 2, 5))
_PAPER = (1 / 3, 1.1 / 3, 1 / 3, np.pi / 2)  # the paper's loop: P1, Q0 and Q1 over P0, phase


def require_free(folder: Path) -> None:
    """InputError where `folder` holds a page of somebody else's that `write` would replace: to be
    asked before hours of sweeps.
    """
    claim(folder, (MANIFEST, "README.md", "laws.json", *(f"{name}.md" for name in MAPS)))


def write(folder: Path) -> None:
    """Laws, drawings and pages of the maps whose tables are in `folder`: all, or none after an
    error; InputError without tables.
    """
    maps_present = present(folder)
    if not maps_present:
        raise InputError(f"{folder}: no map has its tables here; make them by `halfplane map all`")
    with filled(folder, fresh=()) as made:
        # Pages read tables and laws from one folder; the tables themselves are not written again.
        for study in {study for asked in maps_present for study in asked.studies}:
            shutil.copyfile(folder / f"{study}.csv", made / f"{study}.csv")
        (made / "laws.json").write_text(laws_text(made, maps_present), encoding="utf-8")
        for asked in maps_present:
            for chart in asked.charts:
                for name, svg, _ in _drawings(chart, read(made, chart.study)):
                    (made / name).write_text(svg, encoding="utf-8")
            (made / f"{asked.name}.md").write_text(page(asked, made), encoding="utf-8")
        (made / "README.md").write_text(index(made, maps_present), encoding="utf-8")
        for table in made.glob("*.csv"):
            table.unlink()


def present(folder: Path) -> list[Map]:
    """The maps whose studies all have their tables in `folder`."""
    return [
        idealisation_map
        for idealisation_map in MAPS.values()
        if all((folder / f"{study}.csv").exists() for study in idealisation_map.studies)
    ]


def laws_text(folder: Path, there: list[Map]) -> str:
    """laws.json: the laws of every map, and the constants that the corrections take; six digits,
    which every machine gives.
    """
    charts = [chart for idealisation_map in there for chart in idealisation_map.charts]
    found_lines = [
        (chart.study, line) for chart in charts for line in lines(chart, read(folder, chart.study))
    ]
    laws = [
        {"study": study, "figure": line.figure, **line.at, **asdict(line.law)}
        for study, line in found_lines
        if line.law
    ]

    def rounded(row: Mapping[str, Any]) -> dict[str, Any]:
        return {
            key: float(f"{value:.6g}") if isinstance(value, float) else value
            for key, value in row.items()
        }

    return (
        json.dumps(
            {
                "laws": [rounded(law) for law in laws],
                "curvatures": [rounded(row) for row in _curvatures(laws)],
            },
            indent=1,
        )
        + "\n"
    )


def _curvatures(laws: list[dict[str, Any]]) -> Iterator[dict[str, float]]:
    """N and T of two equal blocks, sides free and base fixed, from the laws of p0 and dissipation
    under the paper's loop.

    p0 moves by N/2 (a/h)^2; dissipation by (w_n N + w_t T) (a/h)^2, the sensitivities w from
    `theory`.
    """
    p, q, cycle = ellipse_path(*_PAPER)

    def sensitivity(normal: float, tangential: float) -> float:
        up, down = (
            dissipation_error(p, q, 1.0, Curvatures(way * normal, way * tangential), cycle)
            for way in (_PROBE, -_PROBE)
        )
        return (up - down) / (2 * _PROBE)

    by_normal = sensitivity(1.0, 0.0)
    by_tangential = sensitivity(0.0, 1.0)
    chosen = {
        (row["figure"], row["aspect"]): row
        for row in laws
        if row["study"] == "block" and row["base"] == "fixed"
    }
    for (figure, aspect), pressure in chosen.items():
        work = chosen.get(("error.dissipation", aspect))
        if figure == "error.p0" and work is not None:
            normal = 2 * pressure["sign"] * pressure["fixed"]
            doubt = 2 * pressure["fixed_doubt"]
            yield {
                "aspect": float(aspect),
                "normal": normal,
                "normal_doubt": doubt,
                "tangential": (work["sign"] * work["fixed"] - by_normal * normal) / by_tangential,
                "tangential_doubt": (
                    (abs(work["fixed_doubt"]) + abs(doubt * by_normal)) / abs(by_tangential)
                ),
            }


# -------------------------------------------------------------------------------------------- pages
def _drawings(chart: Chart, table: pd.DataFrame) -> Iterator[tuple[str, str, str]]:
    """(file name, SVG, caption) of a chart."""
    shown = [name for name in _DRAWN if name in figures(table)]
    if chart.up:
        svg = _heat(
            chart,
            table,
            shown if chart.expected else [name for name in shown if name in _DRAWN[:2]],
        ).svg()
        yield f"{chart.study}-map.svg", svg, PAGE_WORDS["map"]
    if chart.expected is not None or not chart.up:
        caption = PAGE_WORDS["discrepancy" if chart.expected is None else "law"]
        yield (
            f"{chart.study}-law.svg",
            _slopes(chart, list(lines(chart, table, shown)), shown).svg(),
            caption,
        )


def page(asked: Map, folder: Path) -> str:
    """Markdown of a map from the tables in `folder`."""
    page_lines = [f"# {asked.title}", f"<!-- written by `halfplane map {asked.name}` -->"]
    page_lines.append(f"**{asked.question}** {_answer(asked, folder)}")
    for chart in asked.charts:
        table = read(folder, chart.study)
        found_lines = list(lines(chart, table, _TABLED))
        page_lines += [f"## {chart.study}"] * (len(asked.charts) > 1)
        page_lines += [
            f"![{caption}]({name})\n\n*{caption}*" for name, _, caption in _drawings(chart, table)
        ]
        if chart.expected is not None:
            page_lines += [
                *_within(chart, found_lines),
                *_laws(chart, [line for line in found_lines if line.figure in _DRAWN]),
            ]
    for section in _TRIALS.get(asked.name, ()):
        page_lines += section(folder)
    costs = [(study, numbers(read(folder, study), "seconds")) for study in asked.studies]
    rows = [
        [
            f"[{study}]({study}.csv)",
            str(len(s)),
            f"{np.nanmedian(s):.1f}",
            f"{np.nansum(s) / 60:.1f}",
        ]
        for study, s in costs
    ]
    head = ["study", "points", "median seconds of a point", "minutes in all"]
    page_lines += [
        "## How it was made",
        PAGE_WORDS["cost"].format(name=asked.name),
        markdown_table(head, rows),
    ]
    return "\n\n".join(page_lines) + "\n"


def index(folder: Path, there: list[Map]) -> str:
    """Markdown of reports/published/maps/README.md: the designer's question answered from the
    tables, and what is where.
    """
    _, parts_found = parts_of(load_scene(DESIGNER), folder)
    known_parts = [part for part in parts_found if part.values is not None]
    error, doubt = total(known_parts, "error.dissipation")
    missing = (
        ""
        if len(known_parts) == len(parts_found)
        else f" (without {len(parts_found) - len(known_parts)} departures that no map here has)"
    )
    says = "no" if abs(error) + doubt > 0.05 else "not known" if missing else "yes"
    pressure = percent(*total(known_parts, "error.p0"))
    question = PAGE_WORDS["question"].format(
        says=says, dissipation=percent(error, doubt), missing=missing, pressure=pressure
    )
    head = ["departure", *(WORDS[figure] for figure in FIGURES), "where from"]
    page_lines = [
        "# Where the half-plane holds, and by how much it fails",
        "<!-- written by `halfplane map all` -->",
        question,
    ]
    page_lines += [
        markdown_table(head, [[part.what, *cells(part), part.how] for part in parts_found]),
        PAGE_WORDS["index"],
    ]
    for asked in there:
        points = sum(len(read(folder, study)) for study in asked.studies)
        page_lines += [
            f"## [{asked.title}]({asked.name}.md)",
            f"*{asked.question}* {_answer(asked, folder)} ({points} points.)",
        ]
    return "\n\n".join(page_lines) + "\n"


def _answer(asked: Map, folder: Path) -> str:
    """The first paragraph: errors at the designer's place, and from where on theory holds within 5
    %.
    """
    tables = {chart.study: read(folder, chart.study) for chart in asked.charts}
    if asked.name == "loop":
        return _worst_loops(tables["loop"])
    if asked.name == "limits":
        return PAGE_WORDS["limits"].format(
            said="; ".join(_mesh_refinement(study, table) for study, table in tables.items())
        )
    return " ".join(_read_off(chart, tables[chart.study]) for chart in asked.charts)


def _read_off(chart: Chart, table: pd.DataFrame) -> str:
    found_lines = list(lines(chart, table, FIGURES[:2]))
    words_by_figure: dict[str, list[str]] = {WORDS[figure]: [] for figure in FIGURES[:2]}
    for line in found_lines:
        value = reading_at(line, chart.sample["s"])
        words_by_figure[WORDS[line.figure]].append(
            f"{percent(*value) if value else 'outside the study'} ({place(line.at)})"
        )
    works = [line for line in found_lines if line.figure == "error.dissipation"]
    holds = ", ".join(
        f"{bound_in_words(bound(line, 0.05), chart.inverse)} ({place(line.at)})" for line in works
    )
    off = "; ".join(
        f"{words}: error of {', '.join(ends)}" for words, ends in words_by_figure.items()
    )
    return f"{chart.sample['words']} {off}. Dissipation is within 5 % if {chart.within} {holds}."


def reading_at(line: Line, s: float) -> tuple[float, float] | None:
    """Error and uncertainty at s between the points of a line; None outside them."""
    is_inside = line.s.min() * (1 - 1e-9) <= s <= line.s.max() * (1 + 1e-9)
    return along(line, s) if is_inside else None


def _mesh_refinement(study: str, table: pd.DataFrame) -> str:
    """How far apart the engines are over a mesh refinement, and where least."""
    error = np.abs(errors(table, "error.dissipation")[0])
    name = table.columns[0]
    span = f"{100 * error.max():.2g} to {100 * error.min():.2g} %"
    return (
        f"{study.removeprefix('limits-')}: {span}, least at {name} ="
        f" {table[name].iloc[int(np.argmin(error))]}"
    )


def _worst_loops(table: pd.DataFrame) -> str:
    """Where the same blocks hurt most and least."""
    error, doubt = errors(table, "error.dissipation")
    pressure = errors(table, "error.p0")[0]
    size = np.where(np.abs(error) > doubt, np.abs(error), np.nan)
    ends = {"worst": int(np.nanargmax(size)), "least": int(np.nanargmin(size))}
    errors_in_words = {
        name: with_uncertainty(100 * error[k], 100 * doubt[k]) for name, k in ends.items()
    }
    for name, k in ends.items():
        row = table.iloc[k]
        errors_in_words[f"{name} loop"] = (
            f"P1/P0 = {row['amplitude']}, phase {row['phase']}°, {row['margin']} from sliding"
        )
    counts = {
        "points": len(table),
        "stuck": int(np.isnan(error).sum()),
        "unresolved": int(np.sum(np.abs(error) <= doubt)),
    }
    return str(
        PAGE_WORDS["loop"].format(
            **errors_in_words,
            **counts,
            p0=f"{100 * pressure.min():+.3f} to {100 * pressure.max():+.3f}",
        )
    )


def _section(name: str, rows: Iterable[Sequence[str]], **values: float) -> list[str]:
    """A part of a page: its title, words with their numbers, and table."""
    words = PAGE_WORDS[name]
    return [
        f"## {words['title']}",
        words["text"].format(**values),
        markdown_table(words["head"], rows),
    ]


def _within(chart: Chart, found: Sequence[Line]) -> list[str]:
    rows = [
        [
            WORDS[line.figure],
            place(line.at),
            *(bound_in_words(bound(line, level), chart.inverse) for level in _LEVELS),
        ]
        for line in found
    ]
    head = [
        "figure",
        "where",
        *(f"within {100 * level:g} % if {chart.within}" for level in _LEVELS),
    ]
    return [
        "## Within 1, 5 and 10 %" if not chart.study.startswith("limits") else "",
        markdown_table(head, rows),
        PAGE_WORDS["within"],
    ]


def _laws(chart: Chart, found: Sequence[Line]) -> list[str]:
    rows = []
    for line in found:
        law = line.law
        row = [WORDS[line.figure], place(line.at)]
        if law is None:
            few = int(np.sum(np.abs(line.error) > line.uncertainty))
            rows.append(
                [*row, f"no law: {few} resolved points of one sign, five needed", "", "", "", ""]
            )
            continue
        row += [f"{law.order:.2f} ± {law.order_doubt:.2f}"]
        row += [f"{'agrees with' if law.agrees() else '**differs from**'} {law.expected:g}"]
        row += [f"{law.sign * law.fixed:.3g} ± {law.fixed_doubt:.2g}"]
        row += [f"{law.smallest:.3g} to {law.largest:.3g} ({law.points})"]
        rows.append([*row, "no asymptotic range found" if law.bent else f"{law.misfit:.2g}"])
    constant = f"constant at exponent {chart.expected:g}"
    span = f"range of {chart.small} (points)"
    head = ["figure", "where", "exponent", "theory", constant, span, "χ²"]
    prediction = f"Predicted exponent {chart.expected:g}: {chart.prediction}."
    straight_exponents = [
        _straight_exponent(line) for line in found if line.figure == "error.dissipation"
    ]
    fits = PAGE_WORDS["fits"].format(power="²" if chart.step == 2 else "")
    if straight_exponents and np.isfinite(straight_exponents).all():
        fits += PAGE_WORDS["straight"].format(
            low=min(straight_exponents), high=max(straight_exponents)
        )
    return ["### Laws", prediction, markdown_table(head, rows), fits]


def _straight_exponent(line: Line) -> float:
    """The exponent of a straight line through all resolved points, log e over log s, without the
    next term of the series.
    """
    is_used = line.known & (np.abs(line.error) > line.uncertainty)
    s, error, doubt = (column[is_used] for column in (line.s, np.abs(line.error), line.uncertainty))
    return (
        float(np.polyfit(np.log(s), np.log(error), 1, w=error / doubt)[0])
        if len(s) > 1
        else float("nan")
    )


# ----------------------------------------------------------------------------------------- drawings
def _heat(chart: Chart, table: pd.DataFrame, shown: Sequence[str]) -> Plate:
    """A row for each error, a column for each panel; |error| in per cent, hatched where it is not
    resolved.
    """
    columns = list(parts(table, (chart.panels,)))
    all_errors = 100 * np.abs(np.concatenate([errors(table, figure)[0] for figure in shown]))
    least_error = max(_LEAST, float(np.nanmin(all_errors)))
    largest_error = min(_MOST, float(np.nanmax(all_errors)))
    bar = colour_scale(
        "heat-colours",
        (least_error, largest_error),
        "|error of half-plane theory|, %",
        log=True,
        tick_values=_BAR,
        width=340.0,
    )
    panels = []
    for number, figure in enumerate(shown):
        for k, (at, part) in enumerate(columns):
            words_of_place = ", ".join(
                f"{AXES.get(name, name)} = {value}" for name, value in at.items()
            )
            title = f"{WORDS[figure]}{'; ' + words_of_place if words_of_place else ''}"
            panel = _cells(
                chart, part, figure, f"heat-{number}-{k}", title, (least_error, largest_error)
            )
            panels.append(
                Cell((panel, bar) if number == len(shown) - 1 and k == 0 else (panel,), None)
            )
    return Plate(
        "map", "", "", "Errors over both axes of a map", tuple(panels), {}, (), len(columns)
    )


def _cells(
    chart: Chart, part: pd.DataFrame, figure: str, name: str, title: str, ends: tuple[float, float]
) -> Panel:
    """Colours are of cells, lines of the values at their middles; both axes go by factors but for
    angles and what may be 0.
    """
    error, doubt = errors(part, figure)
    size = 100 * np.abs(error)
    is_hidden = ~(np.abs(error) > doubt)
    axes = list[Axis]()
    places = list[Array]()
    steps = list[Array]()
    for column in (chart.across, chart.up):
        place = numbers(part, column)
        values = np.unique(place)
        log = column != "phase" and bool(place.min() > 0)
        borders = cell_borders(values, log=log)
        ticks = tuple(
            (value, f"{float(f'{value:.3g}'):g}")
            for value in values[:: 1 if len(values) <= 6 else 2].tolist()
        )
        axes.append(
            Axis(float(borders[0]), float(borders[-1]), AXES.get(column, column), log, ticks=ticks)
        )
        places.append(place)
        steps.append(values)
    names = [
        f"{value:.3g} %" + (", not resolved" if dim else "")
        for value, dim in zip(size, is_hidden, strict=True)
    ]
    share = np.log(np.clip(size, *ends) / ends[0]) / np.log(ends[1] / ends[0])
    marks = heat_map((axes[0], axes[1]), (places[0], places[1]), share, names, is_hidden)
    if min(map(len, steps)) > 1:
        grid = np.full((len(steps[1]), len(steps[0])), np.nan)
        grid[np.searchsorted(steps[1], places[1]), np.searchsorted(steps[0], places[0])] = size
        marks += _level_lines(axes, steps, grid)
    return Panel(name, axes[0], axes[1], marks, title, 340.0, 270.0, title)


def _level_lines(axes: Sequence[Axis], steps: Sequence[Array], size: Array) -> Iterator[Mark]:
    """Lines at 1, 5 and 10 %, between points by the logarithm, as errors go by powers; none near a
    point without a value.
    """
    from matplotlib.figure import Figure

    def scaled(points: Array) -> list[Array]:
        """x and y of points (n, 2) between which lines are straight."""
        return [
            np.exp(column) if axis.log else column
            for axis, column in zip(axes, points.T, strict=True)
        ]

    height = np.ma.masked_invalid(np.log10(np.maximum(size, 1e-4)))
    across, up = (
        np.log(values) if axis.log else values for axis, values in zip(axes, steps, strict=True)
    )
    for level, css in _LOOK_OF_LEVEL.items():
        if height.min() < np.log10(level) < height.max():
            pieces = (
                Figure().subplots().contour(across, up, height, levels=[np.log10(level)]).allsegs[0]
            )
            for points in pieces:
                x, y = scaled(points)
                yield Curve(x, y, css)
            longest_piece = max(pieces, key=len)
            x, y = scaled(longest_piece[len(longest_piece) // 2 - 1 :][:2].mean(axis=0)[None])
            yield Note(float(x[0]), float(y[0]), f"{level:g} %", "tick over", "middle", (0.0, -3.0))


def _slopes(chart: Chart, found: Sequence[Line], shown: Sequence[str]) -> Plate:
    """A panel for each error; |error| over the small parameter, hollow where unresolved, laws, the
    predicted slope.
    """
    panels = []
    keys = dict[str, Key]()
    for number, figure in enumerate(shown):
        lines_of_figure = [line for line in found if line.figure == figure]
        marks = [mark for k, line in enumerate(lines_of_figure) for mark in _points(line, k)]
        keys |= {
            place(line.at, "points"): Key(f"c{k % _LOOKS}", place(line.at, "points"))
            for k, line in enumerate(lines_of_figure)
        }
        s, size = (
            np.concatenate([column(line) for line in lines_of_figure])
            for column in (lambda one: one.s, lambda one: np.abs(one.error))
        )
        known_sizes = size[np.isfinite(size) & (size > 0)]
        if (order := chart.order(figure)) is not None:
            ends = np.array([s.min(), s.max()])
            words_of_others = "".join(
                f"; {WORDS[name]}: {power:g}" for name, power in chart.others.items()
            )
            label = f"slope {chart.expected:g}, predicted{words_of_others}"
            marks.append(
                Curve(
                    ends,
                    60 * float(known_sizes.max()) * (ends / ends[1]) ** order,
                    "slope order-2",
                    label,
                )
            )
            keys[label] = Key("slope order-2", label)
        marks_shown = [mark for mark in _MARKED if s.min() * 0.9 <= mark <= s.max() * 1.1]
        ticks = tuple(zip(marks_shown, labels(marks_shown), strict=True))
        x_axis = Axis(
            0.9 * float(s.min()), 1.1 * float(s.max()), chart.small, log=True, ticks=ticks
        )
        up = Axis(
            max(50 * float(known_sizes.min()), 1e-6),
            150 * float(known_sizes.max()),
            "|error|, %",
            log=True,
        )
        panels.append(
            Panel(f"slopes-{number}", x_axis, up, marks, WORDS[figure], 460.0, 340.0, WORDS[figure])
        )
    return Plate(
        "law",
        "",
        "",
        "Errors over the small parameter",
        tuple(panels),
        {},
        tuple(keys.values()),
        min(2, len(shown)),
    )


def _points(line: Line, number: int) -> Iterator[Mark]:
    look = f"c{number % _LOOKS}"
    size = 100 * np.abs(line.error)
    doubt = np.nan_to_num(100 * line.uncertainty)
    yield bars(line.s, np.maximum(size - doubt, 1e-3 * size), size + doubt, look)
    for s, value, is_hidden in zip(line.s, size, size <= doubt, strict=True):
        if np.isfinite(value):
            yield Dot(
                float(s),
                float(value),
                f"{look} hollow" if is_hidden else f"p{number % _LOOKS}",
                2.8,
            )
    if line.law is not None:
        s = np.geomspace(line.law.smallest, line.law.largest, 40)
        yield Curve(
            s,
            [100 * abs(line.law.value(float(here))) for here in s],
            f"{look} fine",
            place(line.at, "points"),
        )


# ------------------------------------------------------------------ theory and corrections on trial
def left(error: float, predicted: float) -> float:
    """Error of a corrected value: finite elements over corrected theory, less 1."""
    return (1 + error) / (1 + predicted) - 1


def _percent(*values: float) -> list[str]:
    """Errors in per cent with their signs."""
    return [f"{100 * value:+.2f}" for value in values]


def _work(row: Mapping[str, str]) -> tuple[float, float]:
    """Error of dissipation and its uncertainty in a row of a table."""
    return float(row["error.dissipation"]), float(row["error.dissipation.uncertainty"])


def _known(folder: Path, study: str, *named: str) -> list[dict[str, Any]]:
    """The stored laws of a study, of some errors."""
    laws = json.loads((folder / "laws.json").read_text(encoding="utf-8"))["laws"]
    return [law for law in laws if law["study"] == study and law["figure"] in named]


def _beside(fit: float, doubt: float, known: float) -> str:
    return "in the interval" if abs(fit - known) <= doubt else f"differs by {fit - known:+.2g}"


def _derived_blocks(folder: Path) -> list[str]:
    """Constants of (a/h)^2 from the Fourier integrals and sums of layers, beside the fits."""
    p, q, cycle = ellipse_path(*_PAPER)
    rows = []
    for law in _known(folder, "block", *FIGURES[:2]):
        base = law["base"]
        aspect = float(law["aspect"])
        if base == "fixed" and aspect < 4:
            continue
        # notation: N and T, nu = N (a/h)^2, tau = T (a/h)^2
        width = aspect if base == "rollers" else np.inf
        n, t = (-curvature_sum(base, tangential=way, aspect=width) / 2 for way in (False, True))
        known_exponent = n / 2
        if law["figure"] == "error.dissipation":
            known_exponent = (
                dissipation_error(p, q, 1.0, Curvatures(n * _SMALL**2, t * _SMALL**2), cycle)
                / _SMALL**2
            )
        fit = law["sign"] * law["fixed"]
        doubt = law["fixed_doubt"]
        whose = (
            "walls and rollers, sum over images"
            if base == "rollers"
            else "layer without end, integral"
        )
        row = [
            law["figure"].removeprefix("error."),
            f"{base}, {aspect:g}",
            f"{fit:.3f} ± {doubt:.3f}",
            f"{known_exponent:.3f}",
        ]
        rows.append([*row, _beside(fit, doubt, known_exponent), whose])
    return _section("derived_blocks", rows)


def _derived_pads(folder: Path) -> list[str]:
    """The first-order constant of dissipation by the contour's law beside the fitted one."""
    rows = []
    for line in work_lines(folder):
        known_constant = work_constant(float(line.at["flat"]), RATIO)
        fit, doubt = leading_constant(line.s, line.error, line.uncertainty, line.order)
        rows.append(
            [
                line.at["flat"],
                f"{fit:.3f} ± {doubt:.3f}",
                f"{known_constant:.4f}",
                _beside(fit, doubt, known_constant),
            ]
        )
    return _section("derived_pads", rows)


def _odd_part(folder: Path) -> list[str]:
    """What is left of one block's error beside half of what two equal blocks do: the coupling by
    the odd part of its kernel.
    """
    rows = []
    for row in read(folder, "one-block").to_dict("records"):
        f = float(row["f"])
        aspect = float(row["aspect"])
        height = float(row["height"])
        error, doubt = _work(row)
        both = added_curvatures("fixed", aspect, 1 / height)
        p, q, cycle = ellipse_path(_PAPER[0], _PAPER[1] * f, _PAPER[2] * f, _PAPER[3])
        even = dissipation_error(p, q, f, Curvatures(both.normal / 2, both.tangential / 2), cycle)
        cells = [
            row["f"],
            row["aspect"],
            f"{height:.3g}",
            with_uncertainty(100 * error, 100 * doubt),
            *_percent(even),
        ]
        rows.append([*cells, f"{(error - even) * height**2:+.2f}"])
    return _section("odd_part", rows)


def _tried(folder: Path, name: str, study: str, *columns: str) -> list[str]:
    """A correction of dissipation on points that nothing was fitted to: the error of theory, that
    predicted, and what is left.
    """
    table = read(folder, study)
    points = points_of(study)
    rows = []
    sizes = []
    scenes = {
        tuple(map(cell_text, point.coordinates.values())): point.question.scene for point in points
    }
    for row, error, doubt in zip(
        table.to_dict("records"), *errors(table, "error.dissipation"), strict=True
    ):
        cells = [row[column] for column in columns]
        scene = scenes[tuple(row[column] for column in points[0].coordinates)]
        if np.isnan(error):
            rows.append([*cells, "sticks throughout", "", "", "", ""])
            continue
        cells += [*_percent(error), f"{100 * doubt:.1g}"]
        try:
            predicted_error = corrected_dissipation(scene, 1.0) - 1
        except InputError as refused:
            rows.append([*cells, "", "refused", str(refused)])
            continue
        rest = left(error, predicted_error)
        sizes.append((abs(error), abs(rest)))
        rows.append(
            [
                *cells,
                *_percent(predicted_error, rest),
                "resolved" if abs(rest) > doubt else "not resolved",
            ]
        )
    errors_before, errors_after = 100 * np.array(sizes).T
    removed = 100 * (1 - errors_after / errors_before)
    spans = {
        "least": removed.min(),
        "most": removed.max(),
        "before": errors_before.max(),
        "after": errors_after.max(),
    }
    medians = {
        "median": np.median(removed),
        "median before": np.median(errors_before),
        "median after": np.median(errors_after),
    }
    return _section(name, rows, **spans, **medians)


def _growth(folder: Path) -> list[str]:
    """The constant of beta^2, and times f^2."""
    rows = []
    for law in _known(folder, "unlike", *FIGURES[:2]):
        value = law["sign"] * law["fixed"]
        doubt = law["fixed_doubt"]
        square = float(law["f"]) ** 2
        cells = [f"{value * by:.3g} ± {doubt * by:.2g}" for by in (1.0, square)]
        rows.append([law["figure"].removeprefix("error."), law["f"], *cells])
    return _section("growth", rows)


def _other_sign(folder: Path) -> list[str]:
    """Other signs of beta and other alpha, beside the laws: their constant and next term
    interpolated over log f.
    """
    laws = sorted(_known(folder, "unlike", "error.dissipation"), key=lambda law: float(law["f"]))
    fs = np.array([float(law["f"]) for law in laws])
    rows = []
    for row in read(folder, "unlike-held-out").to_dict("records"):
        error, doubt = _work(row)
        f = float(row["f"])
        square = float(row["beta"]) ** 2
        sentence = "none"
        if len(fs) > 1 and fs[0] <= f <= fs[-1]:
            columns = (
                [law["sign"] * law["fixed"] for law in laws],
                [law["next_term"] for law in laws],
            )
            constant, following = (
                float(np.interp(np.log(f), np.log(fs), column)) for column in columns
            )
            sentence = f"{100 * constant * square * math.exp(following * square):+.2f}"
        rows.append(
            [
                row["beta"],
                row["poisson"],
                row["f"],
                with_uncertainty(100 * error, 100 * doubt),
                sentence,
            ]
        )
    return _section("other_sign", rows)


# Map -> its tables after the laws.
_TRIALS: dict[str, tuple[Callable[[Path], list[str]], ...]] = {
    "block": (
        _derived_blocks,
        lambda folder: _tried(
            folder, "corrected_blocks", "block-held-out", "base", "aspect", "height"
        ),
    ),
    "curvature": (
        _derived_pads,
        lambda folder: _tried(
            folder, "corrected_pads", "pad-held-out", "flat", "curvature", "ratio"
        ),
    ),
    "one-block": (_odd_part,),
    "loop": (
        lambda folder: _tried(folder, "corrected_loops", "loop", "amplitude", "margin", "phase"),
    ),
    "unlike": (_growth, _other_sign),
}
