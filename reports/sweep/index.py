"""The table of a sweep: one row for each point with a result, done or failed, rebuilt from the results at any time."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.table import harmless
from reports.sweep.store import Planned, Store

STATUS = ("number", "status", "seconds", "reason", "notes", "address")


@dataclass(frozen=True)
class Table:
    """The index as rows.

    Attributes
    ----------
    columns : names: number, the axes, the figures and their uncertainties, then status, seconds, reason, notes, address
    axes : names of the columns that are coordinates
    figures : names of the columns that are figures
    rows : one mapping for each point with a result, in the order of the study; None where there is no value
    waiting : points without a result
    """

    columns: tuple[str, ...]
    axes: tuple[str, ...]
    figures: tuple[str, ...]
    rows: tuple[Mapping[str, Any], ...]
    waiting: int = 0

    def done(self) -> Table:
        """The rows with figures alone."""
        rows = tuple(row for row in self.rows if row["status"] == "done")
        return Table(self.columns, self.axes, self.figures, rows, self.waiting)

    def notes(self) -> list[tuple[str, int]]:
        """What is noted on points, and on how many of them; the most frequent first."""
        return Counter(row["notes"] for row in self.rows if row["notes"]).most_common()

    def numbers(self, column: str) -> NDArray[np.float64]:
        """A column (n_rows,), NaN where there is no value; KeyError for an unknown one, ValueError for one of words."""
        if column not in self.columns:
            raise KeyError(f"{column!r} is none of {', '.join(self.columns)}")
        return np.array([np.nan if row[column] is None else float(row[column]) for row in self.rows])


class Reader:
    """Results read once and kept, so that a table of thousands of points is made anew without reading them all again."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._known: dict[str, dict[str, Any]] = {}

    def result(self, address: str) -> dict[str, Any] | None:
        """The result of an address, None where there is none yet."""
        if address not in self._known:
            found = self._store.read(address)
            if found is None:
                return None
            self._known[address] = found
        return self._known[address]

    def keep(self, result: dict[str, Any]) -> None:
        """A result that is known without reading."""
        self._known[str(result["address"])] = result

    def table(self, points: tuple[Planned, ...]) -> Table:
        """The table of `points`."""
        stored = self._store.addresses()
        pairs = [(point, self.result(point.address)) for point in points if point.address in stored]
        found = [(point, result) for point, result in pairs if result is not None]
        figures = tuple(dict.fromkeys(name for _, result in found for name in result["figures"]))
        axes = tuple(points[0].coordinates) if points else ()
        columns = ("number", *axes, *figures, *STATUS[1:])
        rows = tuple(_row(point, result, figures) for point, result in found)
        return Table(columns, axes, figures, rows, len(points) - len(rows))


def _row(point: Planned, result: Mapping[str, Any], figures: tuple[str, ...]) -> dict[str, Any]:
    values = {name: result["figures"].get(name) for name in figures}
    record, notes = result.get("record", {}), result.get("notes", {})  # the first stores have neither
    return {
        "number": point.number,
        **point.coordinates,
        **values,
        **{name: result[name] for name in ("status", "seconds", "reason")},
        "notes": "; ".join([*record.get("notes", ()), *_why(notes)]),
        "address": point.address,
    }


def _why(notes: Mapping[str, str]) -> list[str]:
    """What is noted on single figures, and under no name on all."""
    return [f"{name}: {note}" if name else note for name, note in notes.items()]


def read_index(folder: str | Path) -> Table:
    """The table of the sweep stored in `folder`, made from its results: right whether index.csv is there or not.

    Raises
    ------
    InputError
        Where the folder holds no sweep.
    """
    store = Store(Path(folder))
    _, points = store.read_plan()
    return Reader(store).table(points)


def write_index(store: Store, table: Table) -> None:
    """index.csv in one go."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(harmless, table.columns))
    writer.writerows([_cell(row[name]) for name in table.columns] for row in table.rows)
    store.write_text(store.folder / "index.csv", text.getvalue())


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    return harmless(value) if isinstance(value, str) else value


def write_parquet(store: Store, table: Table) -> bool:
    """index.parquet in one go; False where pyarrow is not installed."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return False
    columns = {name: [row[name] for row in table.rows] for name in table.columns}
    content = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), content)
    store.write_bytes(store.folder / "index.parquet", content.getvalue())
    return True
