"""One kind of row for every benchmark (what, measured, limit, how), and what all of them share: timing, files, tables, fits."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[1]
os.environ.setdefault("HALFPLANE_CACHE", "off")  # every run condenses its bodies itself


@dataclass(frozen=True)
class Row:
    """One claim: what, the value measured, the limit of its size (None: shown only), and how it was found."""

    what: str
    measured: float
    limit: float | None
    how: str
    unit: str = ""

    @property
    def kept(self) -> bool | None:
        """Whether the limit is satisfied."""
        return None if self.limit is None else bool(abs(self.measured) <= self.limit)

    @property
    def cells(self) -> tuple[str, ...]:
        """Claim, measured, limit, whether it is satisfied, how."""
        limit = "" if self.limit is None else f"{self.limit:g} {self.unit}".strip()
        words = {None: "", True: "yes", False: "**no**"}[self.kept]
        return (self.what, f"{self.measured:.3g} {self.unit}".strip(), limit, words, self.how)


def commit() -> str:
    """The commit that is measured, with a plus sign where files were changed since."""
    found = subprocess.run(["git", "describe", "--always", "--dirty=+"], capture_output=True, text=True, cwd=ROOT, check=False)
    return found.stdout.strip()


# --------------------------------------------------------------------------------------------------------------------- files
def markdown(head: str, cells: Iterable[Sequence[object]]) -> list[str]:
    """Lines of a table; the head as "a | b | c".

    >>> markdown("a | b", [(1, "x|y")])
    ['| a | b |', '|---|---|', '| 1 | x\\\\|y |']
    """
    lines = [f"| {head} |", "|---" * (head.count(" | ") + 1) + "|"]
    return lines + ["| " + " | ".join(str(cell).replace("|", r"\|") for cell in row) + " |" for row in cells]


def table(rows: Iterable[Row]) -> str:
    """The rows as a Markdown table."""
    return "\n".join(markdown("claim | measured | limit | met | how", (row.cells for row in rows)))


def kept_json(file: Path) -> dict[str, Any]:
    """What a file of results has."""
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def write_json(file: Path, content: Any) -> None:
    file.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


# --------------------------------------------------------------------------------------------------------------------- times
def seconds(work: Callable[[], Any], times: int = 1) -> float:
    """Least process time of a few runs, after one to warm up where there are several."""
    return in_turn(work, times=times, warm=times > 1)[0]


def in_turn(*works: Callable[[], Any], times: int = 5, warm: bool = True) -> list[float]:
    """Least process time of each of several works, in turn, so that what else the machine does falls on all alike."""
    for work in works if warm else ():
        work()
    found = np.full((times, len(works)), np.inf)
    for turn in found:
        for k, work in enumerate(works):
            begun = time.process_time()
            work()
            turn[k] = time.process_time() - begun
    return np.min(found, axis=0).tolist()


def with_children(work: Callable[[], Any]) -> tuple[float, Any]:
    """Process time of a work, that of finished child processes included, and its answer."""

    def spent() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return time.process_time() + used.ru_utime + used.ru_stime

    begun = spent()
    answer = work()
    return spent() - begun, answer


def cold(statement: str) -> tuple[float, float, list[float]]:
    """A statement in a process of its own in benchmarks/: CPU seconds, peak memory [GiB], the numbers that it has in `found`."""
    code = f"found = []; {statement}; from claim import memory; print(*found, memory())"
    command = [sys.executable, "-c", code]
    spent, done = with_children(
        lambda: subprocess.run(command, check=True, capture_output=True, text=True, cwd=Path(__file__).parent)
    )
    *found, peak = map(float, done.stdout.split())
    return spent, peak * 1e6 / 2**30, found


def memory() -> float:
    """Peak of this process in MB; ru_maxrss starts from its parent's."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM"))) * 1024 / 1e6


# ---------------------------------------------------------------------------------------------------------------------- fits
def slope(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Slope of log(value) over log(size), least squares: an order of convergence (negative) or an exponent of a cost.

    >>> round(slope([1, 2, 4], [3.0, 12.0, 48.0]), 9)
    2.0
    """
    return float(np.polyfit(np.log(sizes), np.log(np.abs(values)), 1)[0])


def rms(values: Any) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
