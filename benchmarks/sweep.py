"""What a sweep costs beyond its points, what a second process is worth, and whether the cheap uncertainty covers known errors.

Wall times show the machine's other load as much as the sweep, so the load is stated beside them. Each store is a new one.
"""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
from claim import Row

from reports.sweep.running import prepare, work
from reports.sweep.solving import QUANTITIES
from reports.sweep.store import done
from reports.sweep.study import study_of

F = {"name": "f", "key": "friction.coefficient"}
HEIGHT = {
    "name": "height",
    "keys": ["bodies.lower.height", "bodies.upper.height"],
    "logarithmic": {"start": 4, "stop": 32, "count": 10},
}
FE: dict[str, Any] = {
    "scene": "blocks",
    "figures": ["error.dissipation", "error.p0", "error.contact_half_width", "error.permanent_stick_half_width"],
    "preset": "coarse",
    "axes": [HEIGHT, F | {"linear": {"start": 0.9, "stop": 2, "count": 20}}],
}
EXACT: dict[str, Any] = {
    "scene": "hertz-paper",
    "engines": ["exact"],
    "figures": ["exact.dissipation", "exact.permanent_stick_half_width"],
    "axes": [F | {"linear": {"start": 0.9, "stop": 2, "count": 1000}}],
}
# Signed errors of every quantity; the worst instants of three metrics, of which stick edges jump from node to node.
KNOWN = [*(f"error.{name}" for name in QUANTITIES), "pressure", "shear", "stick_edge"]
FRICTIONS, PRESETS = [0.9, 1.0, 1.2, 1.5, 2.0], ("default", "coarse")


def timed(asked: dict[str, Any], workers: int = 1) -> tuple[pd.DataFrame, float, float]:
    """The table, wall seconds of checking and of the work, processes' starting included."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        prepared = prepare(study_of(asked, "benchmark"), Path(folder) / "out")
        checked = time.perf_counter()
        found = done(work(prepared, workers=workers))
        return found, checked - begun, time.perf_counter() - checked


def rows() -> Iterator[Row]:
    """Of half-plane theory all but the solving, over the points; 200 FE points on two processes against one."""
    found, checking, working = timed(EXACT)
    count, solving = len(found), float(found["seconds"].sum())
    how = f"{count} points: checking {checking:.1f} s, work {working:.1f} s, of it solving {solving:.1f} s; {load()}"
    yield Row("theory alone: overhead a point", 1e3 * (checking + working - solving) / count, 20.0, how, "ms")
    seconds, at_once = {}, {}
    for workers in (1, 2):
        found, _, seconds[workers] = timed(FE, workers)
        assert len(found) == 200
        at_once[workers] = float(found["seconds"].sum()) / seconds[workers]
    how = f"200 points of blocks, {seconds[1]:.0f} s and {seconds[2]:.0f} s, starting of processes included; {load()}"
    # As a loss, so that the limit is one that is not to be exceeded: at least 1.8 times is at most 1/1.8 of the time.
    yield Row("FE sweep on 2 processes: share of the time on 1", seconds[2] / seconds[1], 1 / 1.8, how)
    yield Row("... times faster", seconds[1] / seconds[2], None, how)
    how = f"seconds of all points over the time that passed; what is missing the sweep leaves idle; with 1 process {at_once[1]:.2f}"
    yield Row("... points being solved at once, of 2", at_once[2], None, how)
    yield Row("... the study of 200 FE points on 2 processes took", seconds[2], 1800.0, how, "s")


def load() -> str:
    return f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores when it ended"


def coverage() -> Iterator[Row]:
    """Errors between half-planes, where every one is known: how many there are, how many the cheap uncertainty covers."""
    known = []
    for preset in PRESETS:
        asked = {
            "scene": "hertz-paper",
            "figures": KNOWN,
            "uncertainty": "cheap",
            "preset": preset,
            "axes": [F | {"values": FRICTIONS}],
        }
        finished = timed(asked)[0]
        for name in KNOWN:
            columns = (finished[key].tolist() for key in ("f", name, f"{name}.uncertainty"))
            known += [
                (f"{name} at f = {f:g}, {preset}", abs(e) / u) for f, e, u in zip(*columns, strict=True) if math.isfinite(e + u)
            ]
    missed = [f"{where} ({share:.2g})" for where, share in known if share > 1]
    shares = sorted(share for _, share in known)
    how = f"hertz-paper, {len(KNOWN)} figures, {len(FRICTIONS)} frictions, {' and '.join(PRESETS)} mesh"
    yield Row("known errors between half-planes", float(len(known)), None, how)
    yield Row("... covered by the cheap uncertainty", float(len(known) - len(missed)), None, "; ".join(missed) or "all")
    yield Row("... error over uncertainty, median", shares[len(shares) // 2], None, "")
    for tenths in (1, 9):
        yield Row(f"... error over uncertainty, {tenths} of ten below", shares[len(shares) * tenths // 10], None, "")
