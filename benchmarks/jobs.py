"""Claims of whole jobs: the page, a cold run, sweeps, spoilt files, kills.

    python benchmarks/jobs.py [SPOILT FILES A DOOR] [KILLS]     faults alone
                                        (1,000 and 200 by default: half an hour)

The tests do the same with fewer faults (tests/test_fuzz_doors.py, tests/test_faults_processes.py).
Wall times show the machine's other load as much as the job, so the load is stated beside them.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from claims import ROOT, Row, seconds

sys.path.insert(0, str(ROOT / "tests"))


# ------------------------------------------------------------------------------------- page and run
def page() -> Iterator[Row]:
    """What the page adds to a run, and how large it is."""
    from covered import beside_theory

    import halfplane_fe
    from reports import write
    from scenes import load_scene

    code = (
        "import halfplane_fe, semi_analytic, reports.comparison, time\nbegun ="
        " time.process_time()\nimport reports.page.writing\nprint(time.process_time() -"
        " begun)\nimport sys\nassert not {'matplotlib', 'pyvista'} & set(sys.modules)"
    )
    took = float(
        subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True
        ).stdout
    )
    yield Row(
        "importing what writes the page, no drawing library among it",
        took,
        1.0,
        "process time after the engines",
        "s",
    )
    with tempfile.TemporaryDirectory() as folder:
        for name in (
            "hertz-paper",
            "flat-rounded-paper",
            "flat-pad-on-block",
            "motor",
            "time-series",
        ):
            comparison = beside_theory(halfplane_fe.solve(load_scene(name)))
            out = Path(folder) / name
            (took,) = seconds(lambda c=comparison, o=out: write(c, o), times=3)
            yield Row(
                f"{name}: page, tables and NetCDF after a run",
                took,
                3.0,
                "process time, least of three",
                "s",
            )
            size = (out / "report.html").stat().st_size / 1e6
            yield Row(
                f"{name}: size of report.html",
                size,
                8.0,
                "with the slider's data and the tables in it",
                "MB",
            )


def main_job() -> Iterator[Row]:
    """Cold run of the main job, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        command = [
            sys.executable,
            "-m",
            "reports",
            "run",
            "hertz-paper",
            "--out",
            f"{folder}/report",
        ]
        subprocess.run(command, check=True, capture_output=True, cwd=ROOT)
        total = time.perf_counter() - begun
        took: dict[str, Any] = json.loads(
            (Path(folder) / "report" / "comparison.json").read_text()
        )["seconds"]
    yield Row(
        "cold `halfplane run hertz-paper` with the page", total, 30.0, "a process of its own", "s"
    )
    yield Row(
        "... of that the FE model",
        took["finite elements"],
        6.0,
        "mesh, condensation and two revolutions",
        "s",
    )
    how = "on the points and instants of the FE model"
    yield Row("... of that the half-plane engine", took["half-plane theory"], 0.1, how, "s")


# ------------------------------------------------------------------------------------------- sweeps
F = {"name": "f", "key": "friction.coefficient"}
HEIGHT = {"name": "height", "keys": ["bodies.lower.height", "bodies.upper.height"]}
FE: dict[str, Any] = {
    "scene": "blocks",
    "figures": [
        "error.dissipation",
        "error.p0",
        "error.contact_half_width",
        "error.permanent_stick_half_width",
    ],
    "preset": "coarse",
}
EXACT: dict[str, Any] = {
    "scene": "hertz-paper",
    "engines": ["exact"],
    "figures": ["exact.dissipation", "exact.permanent_stick_half_width"],
}


def frictions(count: int) -> dict[str, Any]:
    return F | {"linear": {"start": 0.9, "stop": 2, "count": count}}


def heights(count: int) -> dict[str, Any]:
    return HEIGHT | {"logarithmic": {"start": 4, "stop": 32, "count": count}}


def swept(
    study: dict[str, Any], *axes: dict[str, Any], workers: int = 1
) -> tuple[Any, float, float]:
    """The table of a sweep in a new store, wall seconds of checking and of the work, processes'
    starting included.
    """
    from reports.studies.sweep.running import prepare, solve_waiting_points
    from reports.studies.sweep.store import solved_rows_of
    from reports.studies.sweep.study import study_of

    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        prepared = prepare(
            study_of(study | {"axes": list(axes)}, "benchmark"), Path(folder) / "out"
        )
        checked = time.perf_counter()
        rows = solved_rows_of(solve_waiting_points(prepared, workers=workers))
        return rows, checked - begun, time.perf_counter() - checked


def sweeps() -> Iterator[Row]:
    """Of half-plane theory all but the solving, over the points; 200 FE points on two processes
    against one.
    """

    def load() -> str:
        return (
            f"load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores when it ended"
        )

    rows, checking, working = swept(EXACT, frictions(1000))
    count = len(rows)
    solving = float(rows["seconds"].sum())
    how = (
        f"{count} points: checking {checking:.1f} s, work {working:.1f} s, of it solving"
        f" {solving:.1f} s; {load()}"
    )
    yield Row(
        "theory alone: overhead a point",
        1e3 * (checking + working - solving) / count,
        20.0,
        how,
        "ms",
    )
    took = {}
    at_once = {}
    for workers in (1, 2):
        rows, _, took[workers] = swept(FE, heights(10), frictions(20), workers=workers)
        at_once[workers] = float(rows["seconds"].sum()) / took[workers]
    how = (
        f"{len(rows)} points of blocks, {took[1]:.0f} s and {took[2]:.0f} s, starting of processes"
        f" included; {load()}"
    )
    # As a loss, so that the limit is one that is not to be exceeded: at least 1.8 times is at most
    # 1/1.8 of the time.
    yield Row("FE sweep on 2 processes: share of the time on 1", took[2] / took[1], 1 / 1.8, how)
    yield Row("... times faster", took[1] / took[2], None, how)
    how = (
        "seconds of all points over the time that passed; what is missing the sweep leaves idle;"
        f" with 1 process {at_once[1]:.2f}"
    )
    yield Row("... points being solved at once, of 2", at_once[2], None, how)
    yield Row("... the study of 200 FE points on 2 processes took", took[2], 1800.0, how, "s")


# ------------------------------------------------------------------------------------------- faults
def doors(files: int) -> Iterator[Row]:
    """Spoilt files at every door; a broken door is one that answers with anything but a result or
    an InputError.
    """
    from fuzzing import APART, DOORS, attempt

    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        for name, door in DOORS.items():
            (Path(scratch) / name).mkdir()
            seeds = door.seeds(Path(scratch) / name)
            for number in range(0, files, 10 if name in APART else 1):
                try:
                    answer = attempt(door, seeds[number % len(seeds)], number, Path(scratch))[1]
                # counted and shown: this is what is looked for
                except Exception as fault:  # noqa: BLE001
                    print(f"{name} {number}: {type(fault).__name__}: {fault}", file=sys.stderr)
                    answer = "broken"
                counts[answer if answer in {"read", "broken"} else "refused"] += 1
    how = (
        f"{files} spoilt files for each of {len(DOORS)} kinds of input file, a tenth of these for"
        " VTU, VTK and PVD"
    )
    yield Row(
        "spoilt files that end in anything but a result or a sentence", counts["broken"], 0, how
    )
    yield Row("spoilt files refused in one sentence", counts["refused"], None, how)
    yield Row("spoilt files that still make sense, read", counts["read"], None, how)


def kills(number: int) -> Iterator[Row]:
    """SIGKILL at random moments of three jobs; after each every file is whole or absent, in the end
    the numbers are the same.
    """
    from faulty import JOBS, survive, undisturbed

    held = 0
    tried = 0
    with tempfile.TemporaryDirectory() as scratch:
        for k, job in enumerate(JOBS):
            share = number // len(JOBS) + (k < number % len(JOBS))
            truth, took = undisturbed(Path(scratch) / f"truth of {job}", job)
            (Path(scratch) / job).mkdir()
            tried += share
            try:
                held += survive(Path(scratch) / job, job, share, 10, took, truth)  # 10: the seed
            except AssertionError as fault:
                print(f"{job}: {fault}", file=sys.stderr)
            print(f"{job}: {held} of {tried} kills held", file=sys.stderr, flush=True)
    how = (
        f"{tried} kills in {', '.join(JOBS)}; every file whole or absent after each, numbers of the"
        " next whole run bit for bit"
    )
    yield Row("SIGKILL at random moments, not survived", tried - held, 0, how)
    yield Row("SIGKILL at random moments, survived", held, None, how)


def faults(files: int = 100, number: int = 12) -> Iterator[Row]:
    """For `make numbers`: fewer of both."""
    yield from doors(files)
    yield from kills(number)


if __name__ == "__main__":
    spoilt_files = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000
    kill_count = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    rows = list(faults(spoilt_files, kill_count))
    for row in rows:
        print(" | ".join(row.cells))
    sys.exit(any(row.met is False for row in rows))
