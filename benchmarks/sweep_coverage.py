"""Does the cheap uncertainty of a sweep cover the errors between half-planes, where every one of them is known?

python benchmarks/sweep_coverage.py
"""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from claim import Row, table

from reports.sweep.figures import QUANTITIES
from reports.sweep.running import prepare, work
from reports.sweep.study import study_of

# Signed errors of every quantity; the worst instants of three metrics, of which stick edges jump from node to node.
FIGURES = [*(f"error.{name}" for name in QUANTITIES), "pressure", "shear", "stick_edge"]
FRICTIONS = [0.9, 1.0, 1.2, 1.5, 2.0]
PRESETS = ("default", "coarse")


def known_errors(preset: str) -> Iterator[tuple[str, float, float, float]]:
    """(figure, f, error, stated uncertainty) of every figure that has a value."""
    axis = {"name": "f", "key": "friction.coefficient", "values": FRICTIONS}
    asked: dict[str, Any] = {"scene": "hertz-paper", "figures": FIGURES, "uncertainty": "cheap", "preset": preset, "axes": [axis]}
    with tempfile.TemporaryDirectory() as folder:
        done = work(prepare(study_of(asked, "benchmark"), Path(folder) / "out"), workers=1).done()
    for name in FIGURES:
        columns = (done.numbers(key) for key in ("f", name, f"{name}.uncertainty"))
        for friction, error, stated in zip(*columns, strict=True):
            if math.isfinite(error) and math.isfinite(stated):
                yield name, float(friction), float(error), float(stated)


def rows() -> Iterator[Row]:
    """How many are covered, how many there are, and how large the errors are against what is stated."""
    found = [(preset, *one) for preset in PRESETS for one in known_errors(preset)]
    missed = [f"{name} at f = {f:g}, {preset} ({abs(e) / u:.2g})" for preset, name, f, e, u in found if abs(e) > u]
    shares = sorted(abs(error) / stated for *_, error, stated in found)
    how = f"hertz-paper, {len(FIGURES)} figures, {len(FRICTIONS)} frictions, {' and '.join(PRESETS)} mesh"
    yield Row("known errors between half-planes", float(len(found)), None, how)
    yield Row("... covered by the cheap uncertainty", float(len(found) - len(missed)), None, "; ".join(missed) or "all")
    yield Row("... error over uncertainty, median", shares[len(shares) // 2], None, "")
    for tenths in (1, 9):
        yield Row(f"... error over uncertainty, {tenths} of ten below", shares[len(shares) * tenths // 10], None, "")


if __name__ == "__main__":
    os.environ["HALFPLANE_CACHE"] = "off"
    print(table(list(rows())))
