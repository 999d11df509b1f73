"""Laws, drawings and pages of the maps, from the tables of their studies."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from reports.maps import fitting, index, pages
from reports.maps.atlas import MAPS, Map
from reports.maps.readings import read
from reports.staging import replace_text
from scenes import InputError

_DIGITS = 6


def write(folder: Path, there: list[Map]) -> None:
    """Laws, drawings and pages of the maps whose tables are in `folder`.

    Raises
    ------
    InputError
        Where there is none.
    """
    if not there:
        raise InputError(f"{folder}: no map has its tables here; make them by `halfplane map all`")
    replace_text(folder / "laws.json", laws_text(folder, there))
    for asked in there:
        for chart in asked.charts:
            for name, svg, _ in pages.drawings(chart, read(folder, chart.study)):
                replace_text(folder / name, svg)
        replace_text(folder / f"{asked.name}.md", pages.page(asked, folder))
    replace_text(folder / "README.md", index.page(folder, there))


def laws_text(folder: Path, there: list[Map]) -> str:
    """laws.json: the laws of every map, and the constants that the corrections take."""
    rows: list[dict[str, Any]] = []
    for asked in there:
        for chart in asked.charts:
            rows += fitting.as_rows(chart.study, fitting.lines(chart, read(folder, chart.study)))
    content = {"laws": rows, "curvatures": fitting.curvatures(rows)}
    return json.dumps(_rounded(content), indent=1) + "\n"


def _rounded(value: Any) -> Any:
    """Six digits, so that a last place that another machine gives otherwise makes no new file."""
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in value.items()}
    return [_rounded(part) for part in value] if isinstance(value, list) else value


def present(folder: Path) -> list[Map]:
    """The maps with what has its table in `folder`; those without any chart are left out."""
    found = []
    for asked in MAPS.values():
        charts = tuple(chart for chart in asked.charts if (folder / f"{chart.study}.csv").exists())
        held_out = tuple(study for study in asked.held_out if (folder / f"{study}.csv").exists())
        if charts:
            found.append(replace(asked, charts=charts, held_out=held_out))
    return found
