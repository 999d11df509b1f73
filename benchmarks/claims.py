"""Every number that the project claims, measured now: printed, kept in docs/numbers.json, written to docs/numbers.md and README.

    make numbers                              (python benchmarks/claims.py, half an hour)
    make numbers SECTIONS='"Finite*" Time'    (those sections alone; the others stay as they were measured)

A row is a claim with its target; a claim that misses its target is printed and written all the same, and the exit code is 1.
Each section is kept as soon as it is measured, with the commit that it was measured on.
"""

from __future__ import annotations

import json
import os
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from fnmatch import fnmatch
from importlib.metadata import version
from typing import Any

import blame
import budget
import engines
import far_field
import faults
import fe_edges
import fe_orders
import fe_peers
import fe_precision
import fe_scaling
import map_laws
import mpmath
import must_fail
import page
import penalty
import real_bodies
import scoring
import semi_analytic_batch
import semi_analytic_extremes
import semi_analytic_histories
import semi_analytic_precision
import stress
import sweep
from claim import ROOT, Row, commit, table
from regress_truth import DIGITS

STORE, PAGE, README = ROOT / "docs" / "numbers.json", ROOT / "docs" / "numbers.md", ROOT / "README.md"
MARKS = "<!-- ten numbers: written by make numbers -->", "<!-- end of the ten numbers -->"
# The ten that matter most, as (section, row, what README says of it).
TEN = (
    (
        "Half-plane engine: extremes",
        "worst relative error of W",
        "friction work of 41 ellipses by theory, against 30 digits",
    ),
    ("Half-plane engine: histories", "solve(hertz-paper), one cycle", "a cycle of 400 instants at 200 points by theory"),
    (
        "Half-plane engine: histories",
        "CSV file of 10^6 rows read and solved, dissipation of every step",
        "a measured history of 10^6 rows",
    ),
    ("Half-plane engine: batches", "batch of 10^6 Hertz ellipses: time", "dissipation of 10^6 load ellipses by theory"),
    ("Finite elements", "hertz-paper, FE: Dissipation", "dissipation of the paper's cycle by finite elements, against theory"),
    (
        "Finite elements: Cattaneo-Mindlin and the flat face",
        "cattaneo-mindlin, FE: shear, L2 over f ||p||",
        "shear of Cattaneo and Mindlin in L2",
    ),
    (
        "Finite elements: beside peers",
        "... over Kratos 10.4's 11 s",
        "time over Kratos' 11 s of another day, for a shear as good (side by side: docs/performance.md)",
    ),
    ("Real bodies", "blocks 10 a high and wide, mesh error: dissipation", "mesh error of the dissipation between real blocks"),
    (
        "Error budget",
        "budget: share not covered by the stated uncertainty",
        "known errors that the stated uncertainty misses",
    ),
    ("Time", "cold `halfplane run hertz-paper` with the page", "a whole run with its page, from nothing"),
)


def sections() -> dict[str, Callable[[], Iterator[Row]]]:
    """Every heading of the page with what measures its rows."""
    return {
        "Half-plane engine": engines.half_plane_engine,
        "Half-plane engine: extremes": semi_analytic_extremes.rows,
        "Half-plane engine: work and precision": semi_analytic_precision.rows,
        "Half-plane engine: histories": semi_analytic_histories.claims,
        "Half-plane engine: batches": semi_analytic_batch.rows,
        "Finite elements": engines.finite_elements,
        "Finite elements: Cattaneo-Mindlin and the flat face": engines.cattaneo_mindlin,
        "Finite elements: far field": far_field.far_field,
        "Finite elements: orders": fe_orders.orders,
        "Finite elements: work and precision": fe_precision.precision,
        "Finite elements: beside peers": fe_peers.peers,
        "Finite elements: growth of the cost": fe_scaling.scaling,
        "Finite elements: edges and increments": fe_edges.rows,
        "Finite elements: penalty and exact law": penalty.penalty,
        "Finite elements: planted faults": must_fail.must_fail,
        "Real bodies": real_bodies.rows,
        "Numerical stress": stress.rows,
        "Faults and bad input": faults.rows,
        "Error budget": budget.rows,
        "Error budget: planted faults": blame.rows,
        "Other people's results: diagnosis of planted faults": scoring.confusion,
        "Other people's results: the examples": scoring.example_rows,
        "Other people's results: rules and readers": scoring.rule_rows,
        "Maps of the idealisation": map_laws.rows,
        "The report": page.rows,
        "Sweeps": sweep.rows,
        "Sweeps: cheap uncertainty": sweep.coverage,
        "Time": engines.times,
    }


def kept_sections() -> dict[str, dict[str, Any]]:
    """What was measured before: title -> rows and the commit they belong to."""
    return json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}


def measure(title: str, section: Callable[[], Iterator[Row]]) -> dict[str, Any]:
    """The rows of one section, printed as they come in."""
    print(f"==> {title}", flush=True)
    rows = []
    for row in section():
        rows.append(row)
        missed = "MISSED " if row.kept is False else ""
        print(f"{missed}{row.what}: {row.measured:.3g} {row.unit} (limit {row.limit})", flush=True)
    return {"commit": commit(), "rows": [asdict(row) | {"measured": float(row.measured)} for row in rows]}


def page_of(kept: dict[str, dict[str, Any]]) -> str:
    """docs/numbers.md."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "scikit-fem", "gmsh"))
    text = [
        "# Numbers",
        "",
        "Every figure that the project claims, written by `make numbers` and by nothing else. Errors are relative unless a unit "
        "is given; times are of one run on a machine that others share: the same code has taken half as long again an hour later.",
        "",
        f"Python {platform.python_version()}, {packages}; {os.cpu_count()} cores, {platform.machine()}.",
    ]
    for title in filter(kept.__contains__, sections()):
        rows = [Row(**row) for row in kept[title]["rows"]]
        text += ["", f"## {title}", "", table(rows), "", f"Measured on {kept[title]['commit']}."]
    return "\n".join(text) + "\n"


def ten_of(kept: dict[str, dict[str, Any]]) -> str:
    """The table in README."""
    lines = ["| what | measured | limit |", "|---|---|---|"]
    for title, what, words in TEN:
        row = next(Row(**row) for row in kept[title]["rows"] if row["what"] == what)
        lines.append(
            f"| {words} | {abs(row.measured):.2g} {row.unit} | {'' if row.limit is None else f'{row.limit:g} {row.unit}'} |"
        )
    return "\n".join(lines)


def write(kept: dict[str, dict[str, Any]]) -> None:
    """The store, the page, the ten numbers of README."""
    STORE.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(page_of(kept), encoding="utf-8")
    before, _, rest = README.read_text("utf-8").partition(MARKS[0])
    README.write_text(f"{before}{MARKS[0]}\n\n{ten_of(kept)}\n\n{MARKS[1]}{rest.partition(MARKS[1])[2]}", encoding="utf-8")


def main(patterns: list[str]) -> int:
    mpmath.mp.dps = DIGITS + 10
    os.environ["HALFPLANE_CACHE"] = "off"  # every run condenses its bodies itself
    asked = [title for title in sections() if not patterns or any(fnmatch(title, pattern) for pattern in patterns)]
    if not asked:
        print(f"no section is called {' or '.join(patterns)}; there are: {', '.join(sections())}", file=sys.stderr)
        return 2
    kept = kept_sections()
    for title in asked:
        kept[title] = measure(title, sections()[title])
        write(kept)
    missed = sum(Row(**row).kept is False for title in asked for row in kept[title]["rows"])
    print(f"{PAGE.relative_to(ROOT)}: {missed} claims missed in {len(asked)} sections")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
