"""What a page says first, and what it shows besides its laws: derived constants, corrected points, other signs and loops."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reports.maps import pads, trials
from reports.maps.atlas import WORDS, Chart, Map, place
from reports.maps.fitting import Line, along, lines
from reports.maps.limits import bound, words
from reports.maps.readings import Readings, read

# Where each map is read off for its first paragraph: the small parameter of the designer's question.
_SAMPLE = {"block": 0.25, "one-block": 0.25, "cylinder": 0.125, "pad": 0.125, "unlike": 0.06}
_SAID = {
    "block": "At height 4 a",
    "one-block": "At height 4 a",
    "cylinder": "At R = 8 a",
    "pad": "At R = 8 a",
    "unlike": "At β = 0.06, titanium on steel,",
}
_FIGURES = ("error.dissipation", "error.p0")


def reading_at(line: Line, s: float) -> tuple[float, float] | None:
    """Error and uncertainty at s, by straight lines between the points over log s; None outside them."""
    inside = line.s.min() * (1 - 1e-9) <= s <= line.s.max() * (1 + 1e-9)
    return along(line, s) if inside else None


def percent(error: float, doubt: float) -> str:
    """Error with its uncertainty.

    >>> percent(-0.4814, 0.0021), percent(0.00012, 0.0004)
    ('−48.1 ± 0.2 %', '+0.012 ± 0.04 % (not resolved)')
    """
    digits = max(0, min(3, 1 - int(np.floor(np.log10(100 * doubt))) - 1)) if doubt > 0 else 3
    text = f"{100 * error:+.{max(digits, 3 if abs(error) < 1e-3 else 1)}f} ± {100 * doubt:.1g} %".replace("-", "−")
    return text + (" (not resolved)" if abs(error) <= doubt else "")


def answer(asked: Map, folder: Path) -> str:
    """The first paragraph: errors at the designer's place, and from where on theory holds within 5 %."""
    if asked.name == "loop":
        return trials.worst_loops(read(folder, "loop"))
    if asked.name == "limits":
        return trials.own_limits({chart.study: read(folder, chart.study) for chart in asked.charts})
    return " ".join(_of_chart(chart, read(folder, chart.study)) for chart in asked.charts)


def _of_chart(chart: Chart, readings: Readings) -> str:
    found = [line for line in lines(chart, readings) if line.figure in _FIGURES]
    said = []
    for figure in _FIGURES:
        chosen = [line for line in found if line.figure == figure]
        ends = []
        for line in chosen:
            read_off = reading_at(line, _SAMPLE[chart.study])
            ends.append((f"{percent(*read_off)}" if read_off else "outside the study") + f" ({place(line.at)})")
        said.append(f"{WORDS[figure]} is off by {', '.join(ends)}")
    holds = [
        f"{words(bound(line, 0.05), chart.inverse)} ({place(line.at)})" for line in found if line.figure == "error.dissipation"
    ]
    return f"{_SAID[chart.study]} {'; '.join(said)}. Dissipation is within 5 % if {chart.within} {', '.join(holds)}."


def more(asked: Map, folder: Path) -> list[str]:
    """Parts of a page after its laws."""
    if asked.name == "block" and asked.held_out:
        return [*trials.derived_constants(folder), *trials.corrected_blocks(folder)]
    if asked.name == "curvature" and asked.held_out:
        return [*pads.derived_constants(folder), *pads.corrected_pads(folder)]
    if asked.name == "one-block":
        return trials.odd_part(folder)
    if asked.name == "loop":
        return trials.corrected_loops(folder)
    if asked.name == "unlike":
        return trials.signs_and_groups(folder)
    return []
