"""The published table of a study: read, written, and cut along its axes."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.table import harmless
from scenes import InputError

if TYPE_CHECKING:
    from reports.sweep.index import Table

Array = NDArray[np.float64]
_LEFT_OUT = ("address", "notes", "number", "reason")
_DIGITS = 7


@dataclass(frozen=True)
class Readings:
    """Rows of a study, text by column; numbers are taken out by `numbers`."""

    study: str
    columns: tuple[str, ...]
    rows: tuple[Mapping[str, str], ...]

    def numbers(self, column: str) -> Array:
        """A column (n,), NaN where there is none."""
        return np.array([float(row[column]) if row[column] else np.nan for row in self.rows])

    def errors(self, figure: str) -> tuple[Array, Array]:
        """A figure (n,) and its uncertainty (n,), NaN where there is none.

        An error of -1 to the last digit is none either: the finite elements stick throughout, and theory's figure is rounding.
        """
        doubt = f"{figure}.uncertainty"
        known = doubt in self.columns
        error = self.numbers(figure)
        error[error == -1.0] = np.nan
        return error, self.numbers(doubt) if known else np.full(len(self.rows), np.nan)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of its errors."""
        return tuple(name for name in self.columns if name.startswith("error.") and not name.endswith(".uncertainty"))

    def parts(self, columns: Sequence[str]) -> Iterator[tuple[dict[str, str], Readings]]:
        """The rows for each set of values of `columns`, in the order of the study."""
        named = [name for name in columns if name]
        keys = dict.fromkeys(tuple(row[name] for name in named) for row in self.rows)
        for key in keys:
            rows = tuple(row for row in self.rows if tuple(row[name] for name in named) == key)
            yield dict(zip(named, key, strict=True)), Readings(self.study, self.columns, rows)


def read(folder: Path, study: str) -> Readings:
    """The table of a study in `folder`.

    Raises
    ------
    InputError
        Where it isn't there.
    """
    path = folder / f"{study}.csv"
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as reason:
        raise InputError(f"{path}: the table of the study can't be read: {reason.strerror}; make it by `make maps`") from reason
    rows = tuple(csv.DictReader(io.StringIO(text)))
    if not rows:
        raise InputError(f"{path}: the table has no rows; make it anew by `make maps`")
    return Readings(study, tuple(rows[0]), tuple(row for row in rows if row["status"] == "done"))


def as_csv(table: Table) -> str:
    """The index of a sweep as it is published: without addresses, seven digits."""
    columns = [name for name in table.columns if name not in _LEFT_OUT]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(row[name]) for name in columns] for row in table.rows)
    return text.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.{_DIGITS}g}" if isinstance(value, float) else harmless(str(value))
