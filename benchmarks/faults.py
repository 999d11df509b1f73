"""Faults survived and inputs refused: every door against spoilt files, every job against SIGKILL at random moments.

    python benchmarks/faults.py [SPOILT FILES A DOOR] [KILLS]     (1,000 and 200 by default: half an hour)

The tests do the same with fewer (tests/test_fuzz_doors.py, tests/test_faults_processes.py).
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
os.environ.setdefault("HALFPLANE_CACHE", "off")

from claim import Row, table

FILES, KILLS = 1_000, 200
_SEED = 10


def doors(files: int) -> Iterator[Row]:
    """Spoilt files at every door; a broken door is one that answers with anything but a result or an InputError."""
    from fuzzing import DOORS, attempt

    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        for name, door in DOORS.items():
            (Path(scratch) / name).mkdir()
            seeds = door.seeds(Path(scratch) / name)
            for number in range(files):
                try:
                    answer = attempt(door, seeds[number % len(seeds)], number, Path(scratch))[1]
                except Exception as fault:  # noqa: BLE001 (counted and shown: this is what is looked for)
                    print(f"{name} {number}: {type(fault).__name__}: {fault}", file=sys.stderr)
                    answer = "broken"
                counts[answer if answer in {"read", "broken"} else "refused"] += 1
    how = f"{files} spoilt files for each of {len(DOORS)} kinds of input file"
    yield Row("spoilt files that end in anything but a result or a sentence", counts["broken"], 0, how)
    yield Row("spoilt files refused in one sentence", counts["refused"], None, how)
    yield Row("spoilt files that still make sense, read", counts["read"], None, how)


def kills(number: int) -> Iterator[Row]:
    """SIGKILL at random moments of three jobs; after each every file is whole or absent, in the end the numbers are the same."""
    from faulty import JOBS, survive, undisturbed

    held, tried = 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        for k, job in enumerate(JOBS):
            share = number // len(JOBS) + (k < number % len(JOBS))
            truth, seconds = undisturbed(Path(scratch) / f"truth of {job}", job)
            (Path(scratch) / job).mkdir()
            tried += share
            try:
                held += survive(Path(scratch) / job, job, share, _SEED, seconds, truth)
            except AssertionError as fault:
                print(f"{job}: {fault}", file=sys.stderr)
            print(f"{job}: {held} of {tried} kills held", file=sys.stderr, flush=True)
    how = f"{tried} kills in {', '.join(JOBS)}; every file whole or absent after each, numbers of the next whole run bit for bit"
    yield Row("SIGKILL at random moments, not survived", tried - held, 0, how)
    yield Row("SIGKILL at random moments, survived", held, None, how)


def rows(files: int = 100, number: int = 12) -> Iterator[Row]:
    """For `make numbers`: fewer of both."""
    yield from doors(files)
    yield from kills(number)


if __name__ == "__main__":
    asked = [int(word) for word in sys.argv[1:]] or [FILES, KILLS]
    found = [*doors(asked[0]), *kills(asked[1])]
    print(table(found))
    sys.exit(any(row.kept is False for row in found))
