"""What a sweep costs beyond its points, and what a second process is worth.

    python benchmarks/sweep.py

Wall times: they tell of the machine's other load as much as of the sweep, so the load is stated beside
them. Each store is a new one.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from claim import Row, table

from reports.sweep.index import Table
from reports.sweep.running import prepare, work
from reports.sweep.study import Study, study_of

FE: dict[str, Any] = {
    "scene": "blocks",
    "figures": ["error.dissipation", "error.p0", "error.contact_half_width", "error.permanent_stick_half_width"],
    "preset": "coarse",
    "axes": [
        {
            "name": "height",
            "keys": ["bodies.lower.height", "bodies.upper.height"],
            "logarithmic": {"start": 4, "stop": 32, "count": 10},
        },
        {"name": "f", "key": "friction.coefficient", "linear": {"start": 0.9, "stop": 2, "count": 20}},
    ],
}
EXACT: dict[str, Any] = {
    "scene": "hertz-paper",
    "engines": ["exact"],
    "figures": ["exact.dissipation", "exact.permanent_stick_half_width"],
    "axes": [{"name": "f", "key": "friction.coefficient", "linear": {"start": 0.9, "stop": 2, "count": 1000}}],
}


def timed(asked: Study, workers: int) -> tuple[Table, float, float]:
    """The table, wall seconds of checking and of the work, processes' starting included."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        prepared = prepare(asked, Path(folder) / "out")
        checked = time.perf_counter()
        found = work(prepared, workers=workers)
        return found, checked - begun, time.perf_counter() - checked


def load() -> str:
    return f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores when it ended"


def throughput() -> Iterator[Row]:
    """A study of 200 FE points on two processes against one."""
    seconds, at_once = {}, {}
    for workers in (1, 2):
        found, _, seconds[workers] = timed(study_of(FE, "benchmark"), workers)
        assert len(found.done().rows) == 200
        at_once[workers] = float(found.numbers("seconds").sum()) / seconds[workers]
    how = f"200 points of blocks, {seconds[1]:.0f} s and {seconds[2]:.0f} s, starting of processes included; {load()}"
    # As a loss, so that the limit is one that is not to be exceeded: at least 1.8 times is at most 1/1.8 of the time.
    yield Row("FE sweep on 2 processes: share of the time on 1", seconds[2] / seconds[1], 1 / 1.8, how)
    yield Row("... times faster", seconds[1] / seconds[2], None, how)
    idle = "seconds of all points over the time that passed; what is missing the sweep itself leaves idle"
    how = f"{idle}; with 1 process {at_once[1]:.2f}"
    yield Row("... points being solved at once, of 2", at_once[2], None, how)
    yield Row("... the study of 200 FE points on 2 processes took", seconds[2], 1800.0, how, "s")


def overhead() -> Iterator[Row]:
    """Of half-plane theory alone: all but the solving, over the points."""
    for what, figures in (("solved one by one", EXACT["figures"]), ("in one call", ["exact.dissipation"])):
        found, checking, working = timed(study_of(EXACT | {"figures": figures}, "benchmark"), 1)
        count, solving = len(found.done().rows), float(found.numbers("seconds").sum())
        how = f"{count} points {what}: checking {checking:.1f} s, work {working:.1f} s, of it solving {solving:.1f} s; {load()}"
        yield Row(f"theory alone, {what}: overhead a point", 1e3 * (checking + working - solving) / count, 20.0, how, "ms")


def rows() -> Iterator[Row]:
    """All rows of this page."""
    yield from overhead()
    yield from throughput()


if __name__ == "__main__":
    os.environ["HALFPLANE_CACHE"] = "off"
    print(table(list(rows())))
