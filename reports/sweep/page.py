"""The page of a sweep: one self-contained file with the state, a figure of each quantity and the table, also while it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from reports.charts.templating import script, template
from reports.sweep.figures import unit_of
from reports.sweep.pictures import draw, plain, plain_figures
from reports.sweep.progress import state_of
from reports.sweep.store import Store
from reports.sweep.study import Study, study_of
from reports.units import number

# More rows than that are in index.csv alone.
_ROWS = 250


def write_page(store: Store) -> Path:
    """Write DIR/sweep.html; returns its path.

    Raises
    ------
    InputError
        Where the folder holds no sweep, or can't be written to.
    """
    state, table = state_of(store)
    raw, _ = store.read_plan()
    study = study_of(raw, str(store.folder / "sweep.json"))
    columns = [name for name in table.columns if name not in ("address", "reason", "notes")]
    names = plain_figures(table)
    program, digest = script()
    page = template("sweep.html").render(
        title=study.title or f"Sweep of {study.scene.title or study.scene.name}",
        purpose=study.purpose,
        scene=study.scene.title or study.scene.name,
        engines=" and ".join({"fe": "finite elements", "exact": "half-plane theory"}[engine] for engine in study.engines),
        state=state,
        words=[(plain(name), unit_of(name)) for name in names],
        pictures=draw(table, study.axes, study.scene),
        script=program,
        script_hash=digest,
        columns=columns,
        rows=[[_cell(row[name]) for name in columns] for row in table.rows[:_ROWS]],
        more=max(0, len(table.rows) - _ROWS),
        uncertainty=_uncertainty(study),
    )
    path = store.folder / "sweep.html"
    store.write_text(path, page)
    return path


def _cell(value: Any) -> str:
    if value is None:
        return "none"
    return number(value) if isinstance(value, float) else str(value)


def _uncertainty(study: Study) -> str:
    if "fe" not in study.engines:
        return "Theory is exact to rounding at the points and instants at which it is evaluated."
    return {
        "none": "No uncertainty was asked for: no digit here is known to be right.",
        "cheap": "Uncertainty, estimated (docs/sweeps.md): from a mesh twice as coarse, theory on the polygon of the steps and, "
        "for half-planes, a far field twice as far.",
        "budget": "Uncertainty and idealisation error: from the error budget of each point.",
    }[study.uncertainty]
