"""What a user waits for, beside another checkout: CPU seconds, modules loaded and peak memory.

    EARLIER=CHECKOUT make bench SECTIONS=speed        (writes the table into docs/performance.md)
    python benchmarks/speed.py CHECKOUT [ROW ...]     (prints it, or the rows whose names begin so)

Each row is a program. Both checkouts run it in turn, a process each, several times; the table has
the medians and their ratio. The machine may be busy: of times only the ratio counts. The number of
modules is exact.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

from claims import ROOT, markdown

TIMES = 3
TITLE = "Beside an earlier version"


_SHOWN_CELLS = 4  # on the page: of goals and modules the terminal has the columns


class Row(NamedTuple):
    """What is measured.

    Attributes
    ----------
    name
        of the row
    goal
        of its time, or of its memory, over that of version 0.3
    program
        Python; the time counts from where it sets `begun`, from the start of the process where it
        does not
    repeats
        how often the program repeats what it times
    memory
        whether the row is about the peak of memory, not about time
    """

    name: str
    goal: float
    program: str
    repeats: int = 1
    memory: bool = False


# The time of the process so far counts interpreter and imports: `begun` is 0 unless it is set.
# The peak is that of /proc: `ru_maxrss` of a child holds what its parent had when it began.
_BEFORE = "import json, sys, time\nbegun = 0.0\n"
_AFTER = """
found = {"seconds": time.process_time() - begun, "modules": len(sys.modules)}
with open("/proc/self/status") as status:
    (peak_in_kib,) = (line.split()[1] for line in status if line.startswith("VmHWM"))
print("\\n" + json.dumps(found | {"memory": int(peak_in_kib) / 1024}))
"""
# The arguments of the process, not of the function: streams and garbage are those of a command.
_COMMAND = "sys.argv[1:] = {words!r}\nfrom reports.cli import main\nmain()"
_SOLVED = """
import halfplane_fe, semi_analytic
from reports import compare, write
from reports.comparison.budget import theory_on_steps
fe = halfplane_fe.solve("hertz-paper")
theory = semi_analytic.solve("hertz-paper", x=fe.x, time=fe.time)
polygon = theory_on_steps(fe)
"""
_THEORY = """
import semi_analytic
from scenes import TimeSeriesLoad, load_scene
scene = load_scene({scene!r})
{change}
def solve():
    semi_analytic.solve(scene{options})
solve()
begun = time.process_time()
for _ in range({repeats}):
    solve()
"""
_ROWS_OF_TABLE = """
import numpy as np
path = scene.load.path()
times = np.linspace(path.start, path.cycle_start + path.period, 1001)
rows = np.column_stack([times, *path.at(times)[:2]]).tolist()
scene = scene.vary(load=TimeSeriesLoad(rows=rows))
"""

# A package loads what a name needs where it is first used.
_ENGINES = "import semi_analytic, halfplane_fe\nsemi_analytic.solve, halfplane_fe.solve"
_DOVETAIL = ROOT / "tests" / "scenes" / "dovetail-in-phase.toml"


def _theory(scene: str, options: str = "", change: str = "", repeats: int = 5) -> str:
    return _THEORY.format(scene=scene, options=options, change=change, repeats=repeats)


ROWS = (
    Row("`halfplane run hertz-paper`", 0.46, _COMMAND.format(words=["run", "hertz-paper"])),
    Row("import of both engines", 0.52, _ENGINES),
    Row(
        "writing result.nc",
        0.08,
        "import semi_analytic\nanswer = semi_analytic.solve('hertz-paper')\n"
        "begun = time.process_time()\nanswer.save('result.nc')",
    ),
    Row(
        "comparison",
        0.19,
        f"{_SOLVED}begun = time.process_time()\ncompare(theory, fe, polygon_reference=polygon)",
    ),
    Row(
        "page and its files",
        0.47,
        f"{_SOLVED}comparison = compare(theory, fe, polygon_reference=polygon)\n"
        "fe.save('result.nc')\nbegun = time.process_time()\nwrite(comparison, 'page')",
    ),
    Row(
        "theory, hertz-paper: W alone",
        0.44,
        _theory("hertz-paper", ", x=0.0, fields='dissipation'", repeats=20),
        20,
    ),
    Row("theory, hertz-paper: all fields", 0.54, _theory("hertz-paper"), 5),
    Row("theory, harmonics: all fields", 0.33, _theory("harmonics"), 5),
    Row(
        "theory, a table of 1,001 rows: all fields",
        0.47,
        _theory("hertz-paper", change=_ROWS_OF_TABLE),
        5,
    ),
    Row("`halfplane --help`", 1.0, _COMMAND.format(words=["--help"])),
    Row("`halfplane check hertz-paper`", 0.6, _COMMAND.format(words=["check", "hertz-paper"])),
    Row(
        "finite elements, dovetail-in-phase: peak memory",
        0.51,
        f"import halfplane_fe\nhalfplane_fe.solve({str(_DOVETAIL)!r})",
        memory=True,
    ),
)


def run(program: str, checkout: Path) -> dict[str, float]:
    """CPU seconds, modules and peak memory [MB] of a program in a process of its own."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = str(checkout)
    # What a first run compiles is there for the next ones, of which the median is one.
    environment["PYTHONPYCACHEPREFIX"] = str(ROOT / ".cache" / "compiled")
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.run(
            [sys.executable, "-c", _BEFORE + program + _AFTER],
            check=True,
            capture_output=True,
            text=True,
            cwd=folder,
            env=environment,
        )
    measured: dict[str, float] = json.loads(process.stdout.splitlines()[-1])
    return measured


def commit_of(checkout: Path) -> str:
    """The short name of the commit that a checkout is at."""
    process = subprocess.run(
        ["git", "-C", str(checkout), "rev-parse", "--short", "HEAD"],
        check=True,
        capture_output=True,
        text=True,
    )
    return process.stdout.strip()


def measure(earlier: Path, beginnings: tuple[str, ...] = (), times: int = TIMES) -> dict[str, Any]:
    """Medians of both checkouts, of rows whose names begin with one of `beginnings`."""
    commit = commit_of(earlier)
    checkouts = {"other": earlier.resolve(), "this": ROOT}
    rows: dict[str, Any] = {}
    for row in ROWS:
        if beginnings and not row.name.strip("`").startswith(beginnings):
            continue
        runs: dict[str, list[dict[str, float]]] = {name: [] for name in checkouts}
        for _ in range(times):
            for name, checkout in checkouts.items():
                runs[name].append(run(row.program, checkout))
        rows[row.name] = {name: _medians(each, row.repeats) for name, each in runs.items()}
        print("    " + " | ".join(cells(row, rows[row.name])), flush=True)
    return {"other": commit, "times": times, "rows": rows}


def _medians(runs: list[dict[str, float]], repeats: int) -> dict[str, float]:
    medians = {}
    for name in runs[0]:
        medians[name] = statistics.median(each[name] for each in runs)
    return medians | {"seconds": medians["seconds"] / repeats}


def cells(row: Row, measured: dict[str, dict[str, float]]) -> tuple[str, ...]:
    """The cells of a row of the table."""
    other = measured["other"]
    this = measured["this"]
    if row.memory:
        amounts = [f"{one['memory']:.0f} MB" for one in (other, this)]
        ratio = this["memory"] / other["memory"]
    else:
        amounts = [f"{1e3 * one['seconds']:,.3g} ms" for one in (other, this)]
        ratio = this["seconds"] / other["seconds"]
    modules = [f"{one['modules']:.0f}" for one in (other, this)]
    return (row.name, *amounts, f"{ratio:.2f}", f"{row.goal:.2f}", *modules)


def page(measured: dict[str, Any]) -> list[str]:
    """The part of docs/performance.md."""
    other = measured["other"]
    rows = [cells(row, measured["rows"][row.name]) for row in ROWS if row.name in measured["rows"]]
    shown = [row[:_SHOWN_CELLS] for row in rows]
    return [
        (
            f"CPU of this version and of commit {other}, a process each, in turn, medians of"
            f" {measured['times']}."
        ),
        "",
        *markdown(f"what | {other} | now | ratio", shown),
    ]


if __name__ == "__main__":
    print("\n".join(page(measure(Path(sys.argv[1]), tuple(sys.argv[2:])))))
