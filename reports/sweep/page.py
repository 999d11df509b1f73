"""How far a sweep is, seen from outside, also while it runs; and its page: the state, a figure of each quantity, the table."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from reports.charts.templating import script, template
from reports.sweep.figures import unit_of
from reports.sweep.pictures import draw, plain, plain_figures
from reports.sweep.store import Store
from reports.sweep.study import study_of
from reports.units import number

_ROWS = 250  # more rows than that are in index.csv alone
_LATEST = 40  # results that the rate is taken from
_ENGINES = {"fe": "finite elements", "exact": "half-plane theory"}
_UNCERTAINTY = {
    "none": "No uncertainty was requested for these values.",
    "cheap": "Uncertainty, estimated (docs/sweeps.md): from a mesh twice as coarse, theory on the polygon of the steps and, "
    "for half-planes, a far field twice as far.",
    "budget": "Uncertainty and idealisation error: from the error budget of each point.",
}


def state_of(store: Store) -> Mapping[str, Any]:
    """What the store holds now, as `halfplane sweep status --json` prints it, with the table under "table".

    A point is running while a living sweep has it; `seconds_left` is None where no sweep is at work or no rate is known.
    """
    study, points = store.read_plan()
    table = store.table(points)
    failures = [{"point": row["number"], "reason": row["reason"]} for row in table.rows if row["status"] != "done"]
    addresses = {row["address"] for row in table.rows}
    running = len(store.running() & {point.address for point in points} - addresses)
    times = []
    for address in addresses:
        with suppress(FileNotFoundError):  # set aside meanwhile
            times.append(store.path(address).stat().st_mtime)
    times = sorted(times)[-_LATEST:]
    rate = (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 and times[-1] > times[0] else None
    counts = {"done": len(table.rows) - len(failures), "failed": len(failures), "running": running}
    return {
        "title": study.get("title", ""),
        "points": counts | {"waiting": table.waiting - running, "total": len(points)},
        "seconds_left": table.waiting / rate if running and rate else None,
        "damaged": store.damaged(),
        "failures": failures,
        "notes": [{"note": note, "points": count} for note, count in table.notes()],
        "table": table,
    }


def write_page(store: Store) -> Path:
    """Write DIR/sweep.html, and DIR/index.csv that it leads to; returns the path of the page."""
    state = state_of(store)
    table = state["table"]
    study = study_of(store.read_plan()[0], str(store.folder / "sweep.json"))
    columns = [name for name in table.columns if name not in ("address", "reason", "notes")]
    name = study.scene.title or study.scene.name
    exact = "Theory is exact to rounding at the points and instants at which it is evaluated."
    program, digest = script()
    page = template("sweep.html").render(
        title=study.title or f"Sweep of {name}",
        purpose=study.purpose,
        scene=name,
        engines=" and ".join(_ENGINES[engine] for engine in study.engines),
        uncertainty=_UNCERTAINTY[study.uncertainty] if "fe" in study.engines else exact,
        state=state,
        words=[(plain(figure), unit_of(figure)) for figure in plain_figures(table)],
        pictures=draw(table, study.axes, study.scene),
        script=program,
        script_hash=digest,
        columns=columns,
        rows=[[_cell(row[column]) for column in columns] for row in table.rows[:_ROWS]],
        more=max(0, len(table.rows) - _ROWS),
    )
    store.write_table(table)
    store.write_text(store.folder / "sweep.html", page)
    return store.folder / "sweep.html"


def _cell(value: Any) -> str:
    return "none" if value is None else number(value) if isinstance(value, float) else str(value)
