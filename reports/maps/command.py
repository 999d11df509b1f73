"""What `halfplane map` does: sweep the studies of a map, publish tables, laws, drawings and pages."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

from reports.application import NOT_CONVERGED, WITHIN
from reports.baseline import replace_text
from reports.console import say
from reports.maps import fitting, index, pages
from reports.maps.atlas import MAPS, PUBLISHED, STUDIES, Map, map_named
from reports.maps.readings import as_csv, read
from scenes import InputError

_DIGITS = 6


def make(
    name: str,
    out: Path | None,
    stores: Path,
    workers: int | None,
    *,
    remake: bool,
    pages_only: bool,
    quiet: bool,
    as_json: bool = False,
) -> int:
    """Run the studies of a map, or of all, and write tables and pages into `out`; 3 where a point failed.

    Raises
    ------
    InputError
        Where `out` is left out in an installed copy, whose tables `halfplane advise` reads.
    """
    from reports.sweep import command, read_index
    from reports.sweep.progress import state_of
    from reports.sweep.store import Store

    if out is None and not (PUBLISHED / "README.md").exists():
        raise InputError("the published maps are those of a checkout, and this is an installed copy: name a folder by --out")
    folder, code, states = out or PUBLISHED, WITHIN, {}
    wanted = list(MAPS.values()) if name == "all" else [map_named(name)]
    folder.mkdir(parents=True, exist_ok=True)
    for asked in wanted if not pages_only else ():
        for study in asked.studies:
            store = stores / study
            if remake and store.exists():
                shutil.rmtree(store)
            source = str(STUDIES / f"{study}.toml")
            code = max(code, command.sweep(source, store, "processes", "", workers, True, quiet, tell=not as_json))
            replace_text(folder / f"{study}.csv", as_csv(read_index(store)))
            if code > NOT_CONVERGED:
                return code
            states[study] = state_of(Store(store))[0]
    write(folder, present(folder))
    page = folder / "README.md"
    if as_json:
        from reports.machine import maps_json

        say(maps_json(states, code, page))
    else:
        say(str(page))
    return code


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
