"""A measured record on real bodies: what `halfplane run` takes of it, in seconds, memory and files.

The scene is that of `halfplane init --bodies` (a pad on a block) with f = 0.7; its loads are rows
of time, P and Q as a machine would write them: 17 cycles in 2,000 rows, P with noise of 1 % of its
mean and Q of its amplitude, from a fixed seed.

    python benchmarks/long_record.py SCENE.toml [--rows N]
        write the scene, of N rows
    python benchmarks/long_record.py SCENE.toml --run OUT [OPTIONS OF RUN]
        and run it; print what it took
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path

import numpy as np

from reports.cli.scene_files import example

ROWS = 2000
CYCLES = 17
NOISE = 0.01
SEED = 1
# P0, amplitude of P and of Q [N/mm], those of the example.
MEAN = 90.0
NORMAL = 30.0
TANGENTIAL = 30.0


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


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", type=Path)
    parser.add_argument("--rows", type=int, default=ROWS)
    parser.add_argument("--run", type=Path, metavar="OUT")
    arguments, options = parser.parse_known_args()
    arguments.scene.write_text(scene_text(arguments.rows), encoding="utf-8")
    sys.exit(run(arguments.scene, arguments.run, options) if arguments.run else 0)
