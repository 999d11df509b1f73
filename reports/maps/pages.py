"""The page of a map: markdown with its answer, figures, the designer's table, laws, what is left after correction, and its cost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from reports.maps import answers
from reports.maps.atlas import MAPS, WORDS, Chart, Map, place
from reports.maps.fitting import Line, lines
from reports.maps.limits import bound, words
from reports.maps.pictures import heat, slopes
from reports.maps.readings import Readings, read
from reports.maps.tabling import table

_POWERS = {1.0: "", 2.0: "²"}
_LEVELS = (0.01, 0.05, 0.1)
_DRAWN = ("error.dissipation", "error.peak_dissipation", "error.p0", "error.contact_half_width")
_TABLED = (*_DRAWN, "error.permanent_stick_half_width", "error.stick_half_width")


def figures_of(readings: Readings, wanted: Sequence[str] = _DRAWN) -> list[str]:
    """Those of `wanted` that a table has."""
    return [name for name in wanted if name in readings.figures]


def drawings(chart: Chart, readings: Readings) -> Iterator[tuple[str, str, str]]:
    """(file name, SVG, caption) of a chart."""
    if chart.up:
        caption = "Error of half-plane theory over both axes; lines at 1, 5 and 10 %; hatched: not resolved, |error| ≤ uncertainty."
        yield (
            f"{chart.study}-map.svg",
            heat(chart, readings, figures_of(readings, _DRAWN if chart.expected else _DRAWN[:2])).svg(),
            caption,
        )
    if chart.expected is not None or not chart.up:
        found = list(lines(chart, readings))
        caption = (
            "Error over the small parameter, bars: uncertainty, hollow: not resolved; lines: the law with its next term, over its "
            "range; dotted: the predicted slope."
        )
        if chart.expected is None:
            caption = "Discrepancy of the two engines over what is moved."
        yield f"{chart.study}-law.svg", slopes(chart, found, figures_of(readings)).svg(), caption


def page(asked: Map, folder: Path) -> str:
    """Markdown of a map from the tables in `folder`."""
    parts = [f"# {asked.title}", f"<!-- written by `halfplane map {asked.name}` -->"]
    parts += [f"**{asked.question}** {answers.answer(asked, folder)}"]
    if missing := sorted(set(MAPS[asked.name].studies) - set(asked.studies)):
        parts.append(f"**Not run yet: {', '.join(missing)}.**")
    for chart in asked.charts:
        readings = read(folder, chart.study)
        found = [line for line in lines(chart, readings) if line.figure in _TABLED]
        if len(MAPS[asked.name].charts) > 1:
            parts.append(f"## {chart.study}")
        for name, _, caption in drawings(chart, readings):
            parts.append(f"![{caption}]({name})\n\n*{caption}*")
        if chart.expected is not None:
            parts += _within(chart, found) + _laws(chart, [line for line in found if line.figure in _DRAWN])
    parts += answers.more(asked, folder)
    parts += _cost(asked, folder)
    return "\n\n".join(parts) + "\n"


def _within(chart: Chart, found: Sequence[Line]) -> list[str]:
    rows = []
    for line in found:
        cells = [words(bound(line, level), chart.inverse) for level in _LEVELS]
        rows.append([WORDS[line.figure], place(line.at), *cells])
    head = ["figure", "where", *(f"within {100 * level:g} % if {chart.within}" for level in _LEVELS)]
    note = (
        'Read off the points with |error| + uncertainty, rounded to the safe side; "all tried": the whole range of the study; '
        "*: extrapolated by the law; "
        '"none tried": the uncertainty alone exceeds the level, or the error does at every point.'
    )
    return ["## Within 1, 5 and 10 %" if not chart.study.startswith("limits") else "", table(head, rows), note]


def _laws(chart: Chart, found: Sequence[Line]) -> list[str]:
    rows = []
    for line in found:
        law = line.law
        if law is None:
            few = int(np.sum(np.abs(line.error) > line.uncertainty))
            rows.append(
                [WORDS[line.figure], place(line.at), f"no law: {few} resolved points of one sign, five needed", "", "", "", ""]
            )
            continue
        verdict = "agrees with" if law.agrees() else "**differs from**"
        rows.append(
            [
                WORDS[line.figure],
                place(line.at),
                f"{law.order:.2f} ± {law.order_doubt:.2f}",
                f"{verdict} {law.expected:g}",
                f"{law.sign * law.fixed:.3g} ± {law.fixed_doubt:.2g}",
                f"{law.smallest:.3g} to {law.largest:.3g} ({law.points})",
                "no asymptotic range found" if law.bent else f"{law.misfit:.2g}",
            ]
        )
    head = [
        "figure",
        "where",
        "exponent",
        "theory",
        f"constant at exponent {chart.expected:g}",
        f"range of {chart.small} (points)",
        "χ²",
    ]
    prediction = f"Predicted exponent {chart.expected:g}: {chart.prediction}."
    how = (
        f"Fits of log |error| = log C + n log s + d s{_POWERS[chart.step]}, weighted; intervals 95 %, of independent errors and "
        "of one that all points share. An interval wider than ±0.3 decides little."
    )
    return ["### Laws", prediction, table(head, rows), how]


def _cost(asked: Map, folder: Path) -> list[str]:
    rows = []
    for study in asked.studies:
        readings = read(folder, study)
        seconds = readings.numbers("seconds")
        rows.append(
            [f"[{study}]({study}.csv)", str(len(readings.rows)), f"{np.nanmedian(seconds):.1f}", f"{np.nansum(seconds) / 60:.1f}"]
        )
    head = ["study", "points", "median seconds of a point", "minutes in all"]
    how = (
        f"`halfplane map {asked.name}` runs what has no result yet and writes this page; `--remake` starts afresh. Times are by "
        "the clock of one process on a busy machine, uncertainty runs included. Uncertainty: two meshes, theory on the polygon of "
        "the steps, and a farther far field (docs/sweeps.md)."
    )
    return ["## How it was made", how, table(head, rows)]
