"""Every number that the project claims, measured now: printed, stored in docs/numbers.json and docs/numbers.md.

    make numbers                              (python benchmarks/claims.py, half an hour)
    make numbers SECTIONS='"Finite*" Time'    (those sections alone; the others stay as they were measured)
    python benchmarks/claims.py --pages       (none: the page from docs/numbers.json)

A claim that misses its limit is printed and written all the same, and the exit code is 1. The page has the ten claims that matter
most, every claim that is missed, and of each section the claim nearest to its limit; docs/numbers.json has all.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from importlib.metadata import version
from typing import Any

from claim import ROOT, Row, chosen, commit, markdown, measure

STORE, PAGE = ROOT / "docs" / "numbers.json", ROOT / "docs" / "numbers.md"
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
    ("friction work of 41 ellipses by theory, against 30 digits", "Half-plane engine: extremes", "worst relative error of W"),
    ("a cycle of 400 instants at 200 points by theory", "Half-plane engine: histories", "solve(hertz-paper), one cycle"),
    (
        "a measured history of 10^6 rows",
        "Half-plane engine: histories",
        "CSV file of 10^6 rows read and solved, dissipation of every step",
    ),
    ("dissipation of 10^6 load ellipses by theory", "Half-plane engine: batches", "batch of 10^6 Hertz ellipses: time"),
    ("dissipation of the paper's cycle by finite elements, against theory", "Finite elements", "hertz-paper, FE: dissipation"),
    (
        "shear of Cattaneo and Mindlin in L2",
        "Finite elements: Cattaneo-Mindlin and the flat face",
        "cattaneo-mindlin, FE: shear, L2 over f ||p||",
    ),
    (
        "time over Kratos' 11 s of another day, for a shear as good (side by side: docs/performance.md)",
        "Finite elements: beside peers",
        "... over Kratos 10.4's 11 s",
    ),
    ("mesh error of the dissipation between real blocks", "Real bodies", "blocks 10 a high and wide, mesh error: dissipation"),
    ("known errors that the stated uncertainty misses", "Error budget", "budget: share not covered by the stated uncertainty"),
    ("a whole run with its page, from nothing", "Time", "cold `halfplane run hertz-paper` with the page"),
)
Stored = dict[str, dict[str, Any]]


def section(title: str) -> Callable[[], Iterator[Row]]:
    """What measures a section; its module is imported only now."""
    module, function = SECTIONS[title].split(".")
    return getattr(import_module(module), function)


def measured(title: str) -> dict[str, Any]:
    """The rows of one section, printed as they come in."""
    rows = []
    for row in section(title)():
        rows.append(row._asdict() | {"measured": float(row.measured)})
        print(f"{'MISSED ' if row.met is False else ''}{row.what}: {row.measured:.3g} {row.unit} (limit {row.limit})", flush=True)
    return {"commit": commit(), "rows": rows}


def rows_of(known: Stored, title: str) -> list[Row]:
    return [Row(**row) for row in known[title]["rows"]]


def summary(known: Stored, title: str) -> tuple[Any, ...]:
    """Of a section: its claims, limits satisfied, and the satisfied claim nearest to its limit (the first where none has one)."""
    rows = rows_of(known, title)
    limited = [row for row in rows if row.limit is not None]
    nearest = max(
        (row for row in limited if row.limit and row.met), key=lambda r: abs(r.measured) / (r.limit or 1), default=rows[0]
    )
    satisfied = f"{sum(bool(row.met) for row in limited)} of {len(limited)}"
    return title, len(rows), satisfied, nearest.what, *nearest.cells[1:3], nearest.how, known[title]["commit"]


def ten_of(known: Stored) -> list[str]:
    """The first table of the page."""
    found = [(words, next(row for row in rows_of(known, title) if row.what == what)) for words, title, what in TEN]
    cells = [(w, f"{abs(r.measured):.2g} {r.unit}", "" if r.limit is None else f"{r.limit:g} {r.unit}") for w, r in found]
    return markdown("what | measured | limit", cells)


def page_of(known: Stored) -> str:
    """docs/numbers.md."""
    sections = [summary(known, title) for title in SECTIONS if title in known]
    missed = [(title, row) for title, *_ in sections for row in rows_of(known, title) if row.met is False]
    shown = missed[: MOST_ROWS - len(TEN) - len(sections)]
    more = f"Missed, {len(missed)} in all" + (f", the first {len(shown)}" if len(shown) < len(missed) else "")
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "scikit-fem", "gmsh"))
    text = [
        "# Numbers",
        "",
        "What the project claims, written by `make numbers` and by nothing else. Errors are relative unless a unit is given; times "
        "are of one run on a machine that others share: the same code has taken half as long again an hour later. "
        f"All {sum(one[1] for one in sections)} rows are in `docs/numbers.json`, by section, each with its limit, "
        "how it was measured and the commit.",
        "",
        f"Python {platform.python_version()}, {packages}; {os.cpu_count()} cores, {platform.machine()}.",
        *("", "## The ten that matter most", "", *ten_of(known)),
        *("", "## Every section, and its claim nearest to the limit", ""),
        *markdown("section | claims | limits satisfied | nearest to its limit | measured | limit | how | commit", sections),
        *("", f"## {more}" if missed else "Every claim that has a limit satisfies it."),
    ]
    if missed:
        text += ["", *markdown("section | claim | measured | limit | met | how", [(title, *row.cells) for title, row in shown])]
    return "\n".join(text) + "\n"


def main(words: list[str]) -> int:
    known = measure(STORE, {title: partial(measured, title) for title in SECTIONS}, words)
    PAGE.write_text(page_of(known), encoding="utf-8")
    asked = chosen(words, SECTIONS)
    missed = sum(row.met is False for title in asked for row in rows_of(known, title))
    print(f"{PAGE.relative_to(ROOT)}: {missed} claims missed in {len(asked)} sections")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
