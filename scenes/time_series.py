"""Measured loads: columns of time, P and Q, straight lines between the rows."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, model_validator

from scenes.loads import LoadPath
from scenes.segments import StraightSegment
from scenes.tables import FromFile, RowError, Table


class TimeSeriesLoad(FromFile):
    """Rows of time, P and Q joined by straight lines; before the first row a straight line from (0, 0), unless it is (0, 0) itself.

    With `repeats` the rows are one cycle, which must end with the loads that it starts with.

    >>> load = TimeSeriesLoad(rows=[[0, 2, 0], [1, 2, 1], [3, 2, 0]])
    >>> [float(v) for v in load.path().at(2.0)], load.path().start
    ([2.0, 0.5], -1.5)
    """

    table, columns = "rows", ("time", "P", "Q")

    kind: Literal["time_series"] = "time_series"
    file: str | None = Field(None, description="CSV file of the columns time, P, Q; path relative to the scene file")
    rows: Table = Field(description="the rows themselves, [time, P, Q] each, in place of a file")
    repeats: bool = Field(False, description="whether the rows are one cycle that repeats for ever")

    @model_validator(mode="after")
    def _check(self, info: ValidationInfo) -> Self:
        try:
            _check_rows(self.rows.values, self.repeats)
        except RowError as fault:
            raise ValueError(f"{self.place_of(fault, info)}: {fault.rule}") from fault
        return self

    def series(self) -> NDArray[np.float64]:
        """The rows (n, 3), from (0, 0) on: the way in is the first step."""
        rows = self.rows.values
        if not np.any(rows[0, 1:]):
            return rows
        duration = (rows[-1, 0] - rows[0, 0]) / (len(rows) - 1)
        return np.concatenate([[[rows[0, 0] - duration, 0.0, 0.0]], rows])

    def path(self) -> LoadPath:
        """The legs of this history, one a row: for long series the engines have a way of their own."""
        rows = self.series().tolist()
        legs = tuple(
            StraightSegment(before[0], after[0], (before[1], before[2]), (after[1], after[2])) for before, after in pairwise(rows)
        )
        if not self.repeats:
            return LoadPath(legs, ())
        return LoadPath(legs[:1], legs[1:])

    def in_words(self, unit: str) -> str:
        """The loads as the end of a sentence."""
        low, high = np.min(self.rows.values, axis=0), np.max(self.rows.values, axis=0)
        again = ", again and again" if self.repeats else ""
        return (
            f"the loads follow {len(self.rows)} rows of a record, P from {low[1]:.6g} to {high[1]:.6g} and Q from {low[2]:.6g} to "
            f"{high[2]:.6g} {unit}{again}"
        )


def _check_rows(rows: NDArray[np.float64], repeats: bool) -> None:
    if rows.shape[1] != 3:
        raise RowError(0, f"three numbers (time, P, Q) are needed, not {rows.shape[1]}")
    if len(rows) < 2:
        raise RowError(0, "one row is no history: two at least are needed")
    step = np.diff(rows[:, 0])
    back = np.flatnonzero(step <= 0)
    if len(back):
        row = int(back[0]) + 1
        rule = "stands there twice" if step[row - 1] == 0 else "comes after a later one"
        raise RowError(row, f"time = {rows[row, 0]:.12g} {rule}: the times must ascend")
    if repeats and not np.any(rows[0, 1:]):
        raise RowError(0, "a cycle that repeats can't start unloaded: its first row is where the way in ends")
    if repeats and np.any(rows[0, 1:] != rows[-1, 1:]):
        raise RowError(len(rows) - 1, "a cycle that repeats must end with the loads of its first row")
