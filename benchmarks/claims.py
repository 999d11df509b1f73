"""Every number that the project claims, measured now: printed, stored in docs/numbers.json and
docs/numbers.md.

    make numbers                              (python benchmarks/claims.py, half an hour)
    make numbers SECTIONS='"Finite*" Time'    (those sections alone; the others stay as they were
                                              measured)
    python benchmarks/claims.py --pages       (none: the page from docs/numbers.json)

A claim that misses its limit is printed and written all the same, and the exit code is 1. The page
has the ten claims that matter most and every claim that is missed; docs/numbers.json has all.

What every benchmark shares is here too: the row (what, measured, limit, how), the runner, times,
files, tables.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatch
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from halfplane_fe.condensed_bodies import BODY_CACHE
from reports.page.writing import code_commit

ROOT = Path(__file__).parents[1]
BODY_CACHE.bound_bytes = 0  # every run condenses its bodies itself
STORE = ROOT / "docs" / "numbers.json"
PAGE = ROOT / "docs" / "numbers.md"
MOST_ROWS = 60
# Heading -> module and function that yields its rows.
SECTIONS = {
    "Half-plane engine: extremes": "half_plane.extremes",
    "Half-plane engine: histories": "half_plane.histories",
    "Half-plane engine: batches": "half_plane.batches",
    "Finite elements": "finite_elements.against_theory",
    "Finite elements: Cattaneo-Mindlin and the flat face": "finite_elements.mindlin",
    "Finite elements: work and precision": "finite_elements.precision",
    "Finite elements: beside peers": "finite_elements.peers",
    "Finite elements: growth of the cost": "finite_elements.growth",
    "Real bodies": "finite_elements.real_bodies",
    "Uncertainty of the inputs": "known_inputs.of_blocks",
    "Faults and bad input": "jobs.faults",
    "Error budget": "covered.budgets",
    "Other people's results: diagnosis of planted faults": "scoring.confusion",
    "Other people's results: rules and readers": "scoring.rules",
    "The report": "jobs.page",
    "Sweeps": "jobs.sweeps",
    "Sweeps: cheap uncertainty": "covered.cheap",
    "Time": "jobs.main_job",
}
# The ten that matter most: words, section, row.
TEN = (
    (
        "friction work of 41 ellipses by theory, against 30 digits",
        "Half-plane engine: extremes",
        "worst relative error of W",
    ),
    (
        "a cycle of 400 instants at 200 points by theory",
        "Half-plane engine: histories",
        "solve(hertz-paper), one cycle",
    ),
    (
        "a measured history of 10^6 rows",
        "Half-plane engine: histories",
        "CSV file of 10^6 rows read and solved, dissipation of every step",
    ),
    (
        "dissipation of 10^6 load ellipses by theory",
        "Half-plane engine: batches",
        "batch of 10^6 Hertz ellipses: time",
    ),
    (
        "dissipation of the paper's cycle by finite elements, against theory",
        "Finite elements",
        "hertz-paper, FE: dissipation",
    ),
    (
        "shear of Cattaneo and Mindlin in L2",
        "Finite elements: Cattaneo-Mindlin and the flat face",
        "cattaneo-mindlin, FE: shear, L2 over f ||p||",
    ),
    (
        "time over Kratos', both in one run, for a shear as good (docs/performance.md)",
        "Finite elements: beside peers",
        "... time over Kratos's, side by side",
    ),
    (
        "mesh error of the dissipation between real blocks",
        "Real bodies",
        "blocks 10 a high and wide, mesh error: dissipation",
    ),
    (
        "known errors that the stated uncertainty misses",
        "Error budget",
        "budget: share not covered by the stated uncertainty",
    ),
    (
        "a whole run with its page, from nothing",
        "Time",
        "cold `halfplane run hertz-paper` with the page",
    ),
)
Stored = dict[str, dict[str, Any]]


class Row(NamedTuple):
    """One claim: what, the value measured, the limit of its size (None: shown only), and how it was
    found.
    """

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
    """The names that the words ask for, whole, in part or by pattern; all where there is no word,
    none for --pages.

    >>> (
    ...     chosen(["Finite"], ["Finite", "Finite, again"]),
    ...     chosen(["again"], ["Finite", "Finite, again"]),
    ... )
    (['Finite'], ['Finite, again'])
    """
    names = list(names)
    names_found = [
        n
        for n in names
        if not words
        or any(n == word if word in names else fnmatch(n, f"*{word}*") for word in words)
    ]
    if not names_found and list(words) != ["--pages"]:
        print(
            f"nothing is called {' or '.join(words)}; there are: {'; '.join(names)}",
            file=sys.stderr,
        )
        raise SystemExit(2)
    return names_found


def measure(
    store: Path, cases: Mapping[str, Callable[[], Any]], words: Sequence[str]
) -> dict[str, Any]:
    """Measure the cases asked for, each stored as soon as it is measured; all that is stored, in
    the order of the cases.
    """
    for name in chosen(words, cases):
        print(f"==> {name}", flush=True)
        begun = time.perf_counter()
        rows = cases[name]()
        write_json(store, stored(store) | {name: rows})
        print(f"    {time.perf_counter() - begun:.0f} s", flush=True)
    known = stored(store)
    return {name: known[name] for name in cases if name in known}


def commit() -> str:
    """The commit that is measured, with a plus sign where the code was changed since; a section
    that has just been stored is no change of the code.
    """
    return code_commit("*.py").replace(", with changes", "+")


# -------------------------------------------------------------------------------------------- files
def markdown(head: str, cells: Iterable[Sequence[object]]) -> list[str]:
    """Lines of a table; the head as "a | b | c".

    A row that is a text, or has not as many cells as the head, is a `ValueError`: a text would
    become a row of its letters.

    >>> markdown("a | b", [(1, "x|y")])
    ['| a | b |', '|---|---|', '| 1 | x\\\\|y |']
    """
    columns = head.count(" | ") + 1
    lines = [f"| {head} |", "|---" * columns + "|"]
    for row in cells:
        if isinstance(row, str) or len(row) != columns:
            raise ValueError(f"a row of {columns} cells ({head}) is not {row!r}")
        words = [str(cell).replace("|", r"\|") for cell in row]
        lines.append(f"| {' | '.join(words)} |")
    return lines


def stored(file: Path) -> dict[str, Any]:
    """What a file of results holds."""
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def write_json(file: Path, content: Any) -> None:
    file.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


# -------------------------------------------------------------------------------------------- times
def seconds(*works: Callable[[], Any], times: int = 1) -> list[float]:
    """Least process time of each work, in turn, so that what else the machine does falls on all
    alike; several times: warm.
    """
    times_spent = np.full((times, len(works)), np.inf)
    for turn in range(-1 if times > 1 else 0, times):
        for k, work in enumerate(works):
            begun = time.process_time()
            work()
            if turn >= 0:
                times_spent[turn, k] = time.process_time() - begun
    return np.min(times_spent, axis=0).tolist()


def with_children(work: Callable[[], Any]) -> tuple[float, Any]:
    """Process time of a work, that of finished child processes included, and its answer."""

    def spent() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return time.process_time() + used.ru_utime + used.ru_stime

    begun = spent()
    answer = work()
    return spent() - begun, answer


def cold(statement: str) -> tuple[float, float, list[float]]:
    """A statement in a process of its own in benchmarks/: CPU seconds, peak memory [GiB], the
    numbers that it has in `found`.
    """
    code = f"found = []; {statement}; from claims import memory; print(*found, memory())"
    command = [sys.executable, "-c", code]
    folder = Path(__file__).parent
    spent, process = with_children(
        lambda: subprocess.run(command, check=True, capture_output=True, text=True, cwd=folder)
    )
    *numbers, peak = map(float, process.stdout.split())
    return spent, peak * 1e6 / 2**30, numbers


def memory() -> float:
    """Peak of this process in MB; ru_maxrss starts from its parent's."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return (
        int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")))
        * 1024
        / 1e6
    )


# ------------------------------------------------------------------------------------------ numbers
def section(title: str) -> Callable[[], Iterator[Row]]:
    """What measures a section; its module is imported only now."""
    module, function = SECTIONS[title].split(".")
    return getattr(import_module(module), function)


def measured(title: str) -> dict[str, Any]:
    """The rows of one section, printed as they come in."""
    rows = []
    for row in section(title)():
        rows.append(row._asdict() | {"measured": float(row.measured)})
        print(
            f"{'MISSED ' if row.met is False else ''}{row.what}: {row.measured:.3g} {row.unit}"
            f" (limit {row.limit})",
            flush=True,
        )
    return {"commit": commit(), "rows": rows}


def rows_of(known: Stored, title: str) -> list[Row]:
    return [Row(**row) for row in known[title]["rows"]]


def ten_of(known: Stored) -> list[str]:
    """The first table of the page."""
    rows = [
        (words, next(row for row in rows_of(known, title) if row.what == claim))
        for words, title, claim in TEN
    ]
    cells = [
        (w, f"{abs(r.measured):.2g} {r.unit}", "" if r.limit is None else f"{r.limit:g} {r.unit}")
        for w, r in rows
    ]
    return markdown("what | measured | limit", cells)


def page_of(known: Stored) -> str:
    """docs/numbers.md."""
    claims = [(title, row) for title in SECTIONS if title in known for row in rows_of(known, title)]
    missed = [(title, row) for title, row in claims if row.met is False]
    missed_shown = missed[: MOST_ROWS - len(TEN)]
    heading = f"Missed, {len(missed)} in all" + (
        f", the first {len(missed_shown)}" if len(missed_shown) < len(missed) else ""
    )
    packages = ", ".join(
        f"{name} {version(name)}" for name in ("numpy", "scipy", "scikit-fem", "gmsh")
    )
    text = [
        "# Numbers",
        "",
        (
            "What the project claims, written by `make numbers`. Errors are relative unless a unit"
            " is given; times are of one run on a shared machine: the same code has taken half as"
            f" long again an hour later. [numbers.json](numbers.json) has all {len(claims)} rows,"
            f" with limit, way of measuring, and commit."
        ),
        "",
        (
            f"Python {platform.python_version()}, {packages}; {os.cpu_count()} cores,"
            f" {platform.machine()}."
        ),
        *("", "## The ten that matter most", "", *ten_of(known)),
        *("", f"## {heading}" if missed else "Every claim that has a limit satisfies it."),
    ]
    if missed:
        text += [
            "",
            *markdown(
                "section | claim | measured | limit | met | how",
                [(title, *row.cells) for title, row in missed_shown],
            ),
        ]
    return "\n".join(text) + "\n"


def main(words: list[str]) -> int:
    known = measure(STORE, {title: partial(measured, title) for title in SECTIONS}, words)
    PAGE.write_text(page_of(known), encoding="utf-8")
    sections = chosen(words, SECTIONS)
    missed = sum(row.met is False for title in sections for row in rows_of(known, title))
    print(f"{PAGE.relative_to(ROOT)}: {missed} claims missed in {len(sections)} sections")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
