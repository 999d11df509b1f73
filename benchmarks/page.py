"""The page: what it adds to a run, and how large it is. python benchmarks/page.py prints the rows alone."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from beside_theory import beside_theory
from claim import Row, table
from clock import seconds

import halfplane_fe
from reports import Comparison, write
from scenes import load_scene

SCENES = ("hertz-paper", "flat-rounded-paper", "flat-pad-on-block", "motor", "time-series")
# What is promised.
MOST_SECONDS, MOST_MEGABYTES = 3.0, 8.0
_DRAWN = ("matplotlib", "pyvista", "typst")


def compared(name: str) -> Comparison:
    """Both engines on a scene with their defaults, as `halfplane run` compares them."""
    return beside_theory(halfplane_fe.solve(load_scene(name)))


def imports() -> float:
    """Process time of importing what writes the page, in a process of its own that has the engines already."""
    code = (
        "import halfplane_fe, semi_analytic, reports.comparison, time\n"
        "begun = time.process_time()\nimport reports.page.writing\nprint(time.process_time() - begun)\n"
        f"import sys\nheavy = [name for name in {_DRAWN} if name in sys.modules]\nassert not heavy, heavy"
    )
    return float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout)


def rows() -> Iterator[Row]:
    """Time and size of the page of each scene."""
    yield Row("importing what writes the page, no drawing library among it", imports(), 1.0, "process time after the engines", "s")
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES:
            comparison, out = compared(name), Path(folder) / name
            took = seconds(lambda comparison=comparison, out=out: write(comparison, out), times=3)
            yield Row(f"{name}: page, tables and NetCDF after a run", took, MOST_SECONDS, "process time, least of three", "s")
            size = (out / "report.html").stat().st_size / 1e6
            yield Row(f"{name}: size of report.html", size, MOST_MEGABYTES, "with the slider's data and the tables in it", "MB")


if __name__ == "__main__":
    print(table(list(rows())))
