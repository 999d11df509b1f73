"""A measured record on real bodies: what `halfplane run` takes of it, in seconds, memory and files;
ten records on half-planes: what the finite elements take of them.

The scene is that of `halfplane init --bodies` (a pad on a block) with f = 0.7; its loads are rows
of time, P and Q as a machine would write them: 17 cycles in 2,000 rows, P with noise of 1 % of its
mean and Q of its amplitude, from a fixed seed.

    python benchmarks/long_record.py SCENE.toml [--rows N]
        write the scene, of N rows
    python benchmarks/long_record.py SCENE.toml --run OUT [OPTIONS OF RUN]
        and run it; print what it took
    python benchmarks/long_record.py --ten [like|unlike] [--rows N] [--seed S]
                                     [--against COMMIT] [--times N]
        ten records on half-planes, five random and five as measured, 1,000 rows each: increments,
        CPU of the solve and of its load path, W against exact theory (like bodies) and its
        uncertainty; the same by an earlier commit beside them, each record by both in turn,
        medians of N times
    EARLIER=CHECKOUT make bench SECTIONS=records
        the same of unlike bodies, 150 rows, for docs/performance.md
"""

from __future__ import annotations

import argparse
import io
import json
import os
import re
import statistics
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from reports.cli.scene_files import example

ROOT = Path(__file__).parent.parent
ROWS = 2000
CYCLES = 17
NOISE = 0.01
SEED = 1
# P0, amplitude of P and of Q [N/mm], those of the example.
MEAN = 90.0
NORMAL = 30.0
TANGENTIAL = 30.0
# The ten records: rows, seed, and the largest |Q| over f P.
ROWS_OF_TEN = 1000
SEED_OF_TEN = 48
MOST_OF_LIMIT = 0.85
# Rows of the records whose cost is on the page of performance.
ROWS_ON_PAGE = 150
TIMES = 1
TITLE = "Records of unlike bodies"


def rows_of(count: int) -> np.ndarray:
    """(count, 3) time [s], P and Q [N/mm], Q a quarter of a cycle behind P: the first rows of the
    same record.
    """
    turn = 2 * np.pi * CYCLES / (ROWS - 1) * np.arange(count)
    noise = NOISE * np.random.default_rng(SEED).standard_normal((count, 2))
    normal = MEAN * (1 + noise[:, 0]) + NORMAL * np.cos(turn)
    tangential = TANGENTIAL * (np.sin(turn) + noise[:, 1])
    return np.column_stack([0.01 * np.arange(count), normal, tangential])


def scene_text(count: int) -> str:
    """The scene file: that of `init --bodies`, with f = 0.7 and the record in place of the
    ellipse.
    """
    text = re.sub(r"coefficient = \S+", "coefficient = 0.7", example(bodies=True))
    rows = ",\n".join(f"  [{t:.2f}, {p:.6f}, {q:.6f}]" for t, p, q in rows_of(count))
    load = f'[load]\nkind = "time_series"\nrows = [\n{rows},\n]\n\n'
    start = text.index("[load]")
    end = text.index("# Bodies:")
    return text[:start] + load + text[end:]


def run(scene: Path, out: Path, options: list[str]) -> int:
    """`halfplane run` in a child process, of which CPU seconds and peak memory are the system's own
    figures.
    """
    child = os.fork()
    if not child:
        words = [sys.executable, "-m", "reports", "run", str(scene), "--out", str(out), *options]
        os.execv(sys.executable, words)
    _, status, used = os.wait4(child, 0)
    print(f"exit code       {os.waitstatus_to_exitcode(status)}")
    print(f"CPU             {used.ru_utime + used.ru_stime:.0f} s")
    print(f"peak memory     {used.ru_maxrss / 1e6:.2f} GB")
    for file in sorted(path for path in out.rglob("*") if path.is_file()):
        if file.stat().st_size > 100_000:
            print(f"{file.relative_to(out)!s:40s} {file.stat().st_size / 1e6:9.2f} MB")
    return os.waitstatus_to_exitcode(status)


def ten_records(count: int, seed: int) -> list[tuple[str, float, np.ndarray]]:
    """Name, f, and (count, 3) rows of time, P and Q: five records of smoothed random loads, then
    five of cycles of P and Q with noise.
    """
    generator = np.random.default_rng(seed)
    records = []
    for number in range(10):
        friction = float(generator.uniform(0.2, 1.0))
        if number < 5:
            name = f"random {number + 1}"
            smoothed_over = int(generator.integers(3, 13))
            window = np.ones(smoothed_over) / np.sqrt(smoothed_over)
            noise = generator.standard_normal((2, count + smoothed_over - 1))
            smooth = [np.convolve(series, window, mode="valid") for series in noise]
            normal = MEAN * (1 + 0.25 * np.tanh(smooth[0]))
            tangential = friction * MEAN * 0.5 * smooth[1]
        else:
            name = f"as measured {number - 4}"
            swing = generator.uniform([0.05, 0.15], [0.4, 0.5])
            phase = generator.uniform(0, 2 * np.pi)
            turn = 2 * np.pi / generator.uniform(40, 150) * np.arange(count)
            noise = generator.uniform(0.002, 0.02) * generator.standard_normal((2, count))
            normal = MEAN * (1 + swing[0] * np.cos(turn) + noise[0])
            tangential = friction * MEAN * (swing[1] * np.sin(turn + phase) + noise[1])
        limit = MOST_OF_LIMIT * friction * normal
        rows = np.column_stack(
            [0.01 * np.arange(count), normal, np.clip(tangential, -limit, limit)]
        )
        records.append((name, friction, rows))
    return records


def solved(number: int, unlike: bool, count: int, seed: int) -> dict[str, Any]:
    """What one of the ten records takes in this process, by the packages that it imports."""
    import halfplane_fe
    import semi_analytic
    from scenes import load_scene

    name, friction, rows = ten_records(count, seed)[number]
    load = {"kind": "time_series", "rows": rows.tolist()}
    scene = load_scene("hertz-paper").vary(
        friction={"coefficient": friction}, tolerances={}, load=load
    )
    if unlike:
        aluminium = {"young_modulus": 70e3, "poisson_ratio": 0.33}
        steel = {"young_modulus": 210e3, "poisson_ratio": 0.3}
        scene = scene.vary(material={"upper": aluminium, "lower": steel})
    path_clock = _PathClock()
    begun = time.process_time()
    answer = halfplane_fe.solve(scene, progress=path_clock)
    seconds = time.process_time() - begun
    work = answer.work.counts
    truth = float("nan") if unlike else semi_analytic.solve(scene).dissipation
    return {
        "name": name,
        "increments": work["steps solved"],
        "landed": work.get("touch increments", 0) + work.get("release increments", 0),
        "halved": work.get("increments halved, step error", 0),
        "seconds": seconds,
        "path": path_clock.seconds,
        "work": answer.dissipation,
        "uncertainty": answer.dissipation_uncertainty,
        "truth": truth,
    }


class _PathClock:
    """CPU seconds of the load path of a record, by what the solver reports at its first and at its
    last row.
    """

    def __init__(self) -> None:
        self.begin = 0.0
        self.seconds = float("nan")

    def __call__(self, done: int, _total: int | None, text: str) -> None:
        """Take the time of a report."""
        if not text.startswith("initial loading"):
            return
        now = time.process_time()
        if not done:
            self.begin = now
        self.seconds = now - self.begin


@contextmanager
def packages_of(commit: str | None) -> Iterator[Path]:
    """The folder with the packages of a commit, or of this tree."""
    if commit is None:
        yield ROOT
        return
    command = ["git", "-C", str(ROOT), "archive", commit]
    archive = subprocess.run(command, check=True, capture_output=True).stdout
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(folder, filter="data")
        yield Path(folder)


def solved_by(tree: Path, number: int, options: argparse.Namespace) -> dict[str, Any]:
    """`solved` in a process of its own, by the packages of a folder, which condense the bodies
    afresh.
    """
    words = [sys.executable, str(Path(__file__).resolve()), "--ten", options.ten]
    words += ["--number", str(number), "--rows", str(options.rows), "--seed", str(options.seed)]
    # Version 0.3 stored condensed bodies; what a first run compiles is there for the next ones.
    places = {"HALFPLANE_CACHE": "off", "PYTHONPYCACHEPREFIX": str(ROOT / ".cache" / "compiled")}
    printed = subprocess.run(
        words,
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | places | {"PYTHONPATH": str(tree)},
        cwd=tree,
    ).stdout
    answer: dict[str, Any] = json.loads(printed)
    return answer


def solved_in_turn(
    trees: Sequence[Path], number: int, options: argparse.Namespace
) -> list[dict[str, Any]]:
    """A record by the packages of each folder in turn, several times: medians of their CPU."""
    runs: list[list[dict[str, Any]]] = [[] for _ in trees]
    for _ in range(options.times):
        for tree, runs_of_tree in zip(trees, runs, strict=True):
            runs_of_tree.append(solved_by(tree, number, options))
    medians = []
    for runs_of_tree in runs:
        seconds = statistics.median(run["seconds"] for run in runs_of_tree)
        path_seconds = statistics.median(run["path"] for run in runs_of_tree)
        medians.append(runs_of_tree[0] | {"seconds": seconds, "path": path_seconds})
    return medians


RATIOS = ("increments", "seconds", "path an increment")


def ratios(before: dict[str, Any], now: dict[str, Any]) -> list[float]:
    """How many times less a record takes now: increments, CPU, and CPU of the path an increment."""
    path_before = before["path"] / before["increments"]
    path_now = now["path"] / now["increments"]
    return [
        before["increments"] / now["increments"],
        before["seconds"] / now["seconds"],
        path_before / path_now,
    ]


def print_ten(options: argparse.Namespace) -> None:
    """The table of the ten records."""
    print(f"{options.ten} bodies, {options.rows} rows, seed {options.seed}")
    head = "increments landed halved  CPU [s] path [ms]  W/theory - 1     u/W"
    beside = f"   {options.against}: {head}  inc.  CPU  path  W/W - 1" if options.against else ""
    print(f"{'record':14s} {head}{beside}", flush=True)
    ratios_of_records = []
    with packages_of(None) as here, packages_of(options.against) as there:
        trees = (here, there) if options.against else (here,)
        for number in range(10):
            now, *earlier = solved_in_turn(trees, number, options)
            line = f"{now['name']:14s} {_columns(now)}"
            for before in earlier:
                ratios_of_record = ratios(before, now)
                ratios_of_records.append(ratios_of_record)
                words = " ".join(f"{ratio:5.2f}" for ratio in ratios_of_record)
                line += f"   {_columns(before)} {words} {now['work'] / before['work'] - 1:+9.1e}"
            print(line, flush=True)
    if ratios_of_records:
        means = np.exp(np.log(ratios_of_records).mean(axis=0))
        words = ", ".join(
            f"{mean:.2f} times less {name}" for mean, name in zip(means, RATIOS, strict=True)
        )
        print(f"geometric means: {words}")


def unlike_beside(earlier: Path) -> dict[str, Any]:
    """The ten records of unlike bodies by this tree and by another one, for the page."""
    options = argparse.Namespace(ten="unlike", rows=ROWS_ON_PAGE, seed=SEED_OF_TEN, times=TIMES)
    # not above: the other tree's programs run this file with its own, older packages
    from speed import commit_of

    commit = commit_of(earlier)
    records = {}
    for number in range(10):
        now, before = solved_in_turn((ROOT, earlier.resolve()), number, options)
        stored_values = ("increments", "seconds", "path", "work")
        records[now["name"]] = {
            "this": {name: now[name] for name in stored_values},
            "other": {name: before[name] for name in stored_values},
        }
        print(f"    {now['name']:14s} {np.round(ratios(before, now), 2).tolist()}", flush=True)
    return {"other": commit, "rows": ROWS_ON_PAGE, "seed": SEED_OF_TEN, "records": records}


def page(measured: dict[str, Any]) -> list[str]:
    """The part of docs/performance.md."""
    records = measured["records"].values()
    ratios_of_records = [ratios(record["other"], record["this"]) for record in records]
    fewer, less, less_an_increment = np.exp(np.log(ratios_of_records).mean(axis=0))
    return [
        (
            f"Ten records of {measured['rows']} rows beside {measured['other']}: CPU an increment"
            f" {less_an_increment:.2f} times less, increments {fewer:.2f}, CPU in all {less:.2f}."
        )
    ]


def _columns(row: dict[str, Any]) -> str:
    error = row["work"] / row["truth"] - 1
    uncertainty = row["uncertainty"] / row["work"]
    milliseconds = 1e3 * row["path"] / row["increments"]
    return (
        f"{row['increments']:10d} {row['landed']:6d} {row['halved']:6d} {row['seconds']:8.1f}"
        f" {milliseconds:9.3f} {error:+13.1e} {uncertainty:7.1e}"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", type=Path, nargs="?")
    parser.add_argument("--rows", type=int)
    parser.add_argument("--run", type=Path, metavar="OUT")
    parser.add_argument("--ten", nargs="?", const="like", choices=("like", "unlike"))
    parser.add_argument("--seed", type=int, default=SEED_OF_TEN)
    parser.add_argument("--against", metavar="COMMIT")
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--number", type=int, help=argparse.SUPPRESS)
    arguments, options = parser.parse_known_args()
    if arguments.ten:
        arguments.rows = arguments.rows or ROWS_OF_TEN
        if arguments.number is None:
            print_ten(arguments)
        else:
            unlike = arguments.ten == "unlike"
            answer = solved(arguments.number, unlike, arguments.rows, arguments.seed)
            print(json.dumps(answer))
        sys.exit(0)
    if arguments.scene is None:
        parser.error("name a scene file to write, or ask for --ten")
    arguments.scene.write_text(scene_text(arguments.rows or ROWS), encoding="utf-8")
    sys.exit(run(arguments.scene, arguments.run, options) if arguments.run else 0)
