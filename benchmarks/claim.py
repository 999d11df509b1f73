"""What every benchmark shares: one kind of row (what, measured, limit, how), one runner, times, files, tables."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).parents[1]
os.environ.setdefault("HALFPLANE_CACHE", "off")  # every run condenses its bodies itself


class Row(NamedTuple):
    """One claim: what, the value measured, the limit of its size (None: shown only), and how it was found."""

    what: str
    measured: float
    limit: float | None
    how: str
    unit: str = ""

    @property
    def met(self) -> bool | None:
        """Whether the limit is satisfied."""
        return None if self.limit is None else bool(abs(self.measured) <= self.limit)

    @property
    def cells(self) -> tuple[str, ...]:
        """Claim, measured, limit, whether it is satisfied, how."""
        limit = "" if self.limit is None else f"{self.limit:g} {self.unit}".strip()
        words = {None: "", True: "yes", False: "**no**"}[self.met]
        return (self.what, f"{self.measured:.3g} {self.unit}".strip(), limit, words, self.how)


def chosen(words: Sequence[str], names: Iterable[str]) -> list[str]:
    """The names that the words ask for, whole, in part or by pattern; all where there is no word, none for --pages.

    >>> chosen(["Finite"], ["Finite", "Finite, again"]), chosen(["again"], ["Finite", "Finite, again"])
    (['Finite'], ['Finite, again'])
    """
    names = list(names)
    found = [n for n in names if not words or any(n == word if word in names else fnmatch(n, f"*{word}*") for word in words)]
    if not found and list(words) != ["--pages"]:
        print(f"nothing is called {' or '.join(words)}; there are: {'; '.join(names)}", file=sys.stderr)
        raise SystemExit(2)
    return found


def measure(store: Path, cases: Mapping[str, Callable[[], Any]], words: Sequence[str]) -> dict[str, Any]:
    """Measure the cases asked for, each stored as soon as it is measured; all that is stored, in the order of the cases."""
    for name in chosen(words, cases):
        print(f"==> {name}", flush=True)
        begun = time.perf_counter()
        found = cases[name]()
        write_json(store, stored(store) | {name: found})
        print(f"    {time.perf_counter() - begun:.0f} s", flush=True)
    there = stored(store)
    return {name: there[name] for name in cases if name in there}


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


def stored(file: Path) -> dict[str, Any]:
    """What a file of results holds."""
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def write_json(file: Path, content: Any) -> None:
    file.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


# --------------------------------------------------------------------------------------------------------------------- times
def seconds(*works: Callable[[], Any], times: int = 1) -> list[float]:
    """Least process time of each work, in turn, so that what else the machine does falls on all alike; several times: warm."""
    found = np.full((times, len(works)), np.inf)
    for turn in range(-1 if times > 1 else 0, times):
        for k, work in enumerate(works):
            begun = time.process_time()
            work()
            if turn >= 0:
                found[turn, k] = time.process_time() - begun
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
    folder = Path(__file__).parent
    spent, done = with_children(lambda: subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder))
    *found, peak = map(float, done.stdout.split())
    return spent, peak * 1e6 / 2**30, found


def memory() -> float:
    """Peak of this process in MB; ru_maxrss starts from its parent's."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM"))) * 1024 / 1e6
