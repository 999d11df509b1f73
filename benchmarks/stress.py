"""Numerical stress: what both engines do at the ends of what a scene may ask, written to docs/stress.md.

    make stress            (python benchmarks/stress.py, some minutes)

A case is a list of trials. A trial gives an error, to be at most the limit, or is refused by InputError or ConvergenceError;
anything else, a warning included, breaks the case.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import stress_fe
import stress_half_plane
from claim import Row
from stress_case import Case

from scenes import ConvergenceError, InputError

PAGE = Path(__file__).parent.parent / "docs" / "stress.md"


@dataclass(frozen=True)
class Outcome:
    """What became of a case: worst error of the trials that were answered, sentences of those refused, what broke."""

    case: Case
    worst: float
    answered: int
    refused: tuple[str, ...]
    broken: tuple[str, ...]
    seconds: float

    @property
    def verdict(self) -> str:
        """In a word or two."""
        if self.broken:
            return "**broken**: " + "; ".join(self.broken)
        words = ["right"] if self.answered else []
        return ", ".join([*words, *(f"refused: “{sentence}”" for sentence in self.refused)])


def outcome(case: Case) -> Outcome:
    """Every trial of a case, warnings being errors."""
    worst, answered, refused, broken = 0.0, 0, [], []
    started = time.perf_counter()
    for name, trial in case.trials():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                error = float(trial())
        except (InputError, ConvergenceError) as reason:
            refused.append(f"{reason}".splitlines()[0])
            if not case.may_refuse:
                broken.append(f"{name}: refused, {reason}")
        except Exception as reason:  # noqa: BLE001 - a traceback is what is looked for: it is counted and shown
            broken.append(f"{name}: {type(reason).__name__}: {reason}")
        else:
            answered += 1
            worst = float(np.maximum(worst, error))
            if not error <= case.limit:
                broken.append(f"{name}: {error:.2g}")
    if case.must_refuse and answered:
        broken.append(f"{answered} trials were answered")
    return Outcome(case, worst, answered, tuple(dict.fromkeys(refused)), tuple(broken), time.perf_counter() - started)


def cases() -> Iterator[Case]:
    """Both engines' cases."""
    yield from stress_half_plane.cases()
    yield from stress_fe.cases()


def rows() -> Iterator[Row]:
    """One claim a case: its worst error, or the number of trials that went wrong where all of them shall be refused."""
    for case in cases():
        found = outcome(case)
        failed = float(len(found.broken))
        what = f"{case.engine}: {case.what}"
        if case.must_refuse or found.broken:
            yield Row(f"{what}, trials that broke", failed, 0.0, found.verdict.replace("|", "\\|"))
        else:
            yield Row(f"{what}: {case.measure}", found.worst, case.limit, case.tried.replace("|", "\\|"))


def page(found: list[Outcome]) -> str:
    """The table of docs/stress.md."""
    lines = [
        "# Numerical stress",
        "",
        "Written by `make stress` and by nothing else. Each case ends in a right answer or in a refusal of one sentence (quoted); "
        "warnings count as errors. Errors are the worst of the trials that were answered, against closed forms, 30-digit "
        "arithmetic, the other engine, or the same scene in other clothes, as the column says. The finite elements run on swift "
        "meshes (`MeshSettings.swift()`) unless the case says otherwise.",
        "",
    ]
    for engine in dict.fromkeys(one.case.engine for one in found):
        lines += [f"## {engine}", "", "| case | tried | measure | worst | limit | verdict |", "|---|---|---|---|---|---|"]
        for one in (one for one in found if one.case.engine == engine):
            worst, limit = (f"{one.worst:.1e}", f"{one.case.limit:.0e}") if one.answered else ("", "")
            cells = (one.case.what, one.case.tried, one.case.measure, worst, limit, one.verdict)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines.append("")
    lines += [
        "## Tested elsewhere",
        "",
        "| what | where |",
        "|---|---|",
        *(f"| {what} | {where} |" for what, where in ELSEWHERE.items()),
    ]
    return "\n".join(lines) + "\n"


ELSEWHERE = {
    "41 ellipses and their extremes against 30 digits, inverses over 16 decades, routes to W, units of batches": (
        "`benchmarks/semi_analytic_extremes.py`, `tests/test_semi_analytic_batch.py`, `tests/test_semi_analytic_normal_contact.py`"
    ),
    "nearly incompressible bodies, linear elements refused": "`tests/test_halfplane_fe_locking.py`",
    "penalty stiffness, weights of the exact law, six decades": "`benchmarks/penalty.py`, `tests/test_halfplane_fe_penalty.py`",
    "far radius and grading, orders of convergence": "`benchmarks/far_field.py`, `benchmarks/fe_orders.py`",
    "300 random ellipses by finite elements, up to 0.999 of gross sliding": "`tests/test_halfplane_fe_random.py`",
    "random scenes of every profile and load through the half-plane engine": "`tests/test_semi_analytic_random.py`",
    "planted faults in either engine": (
        "`tests/test_semi_analytic_mutations.py`, `tests/test_halfplane_fe_mutations.py`, `tests/test_halfplane_fe_must_fail.py`"
    ),
    "rounding of tiny slip told, notes of what the mesh does not see": (
        "`tests/test_semi_analytic_stress.py`, `tests/test_halfplane_fe_stress.py`"
    ),
}


def main() -> int:
    found = []
    for case in cases():
        found.append(outcome(case))
        print(f"{found[-1].seconds:6.1f} s  {case.engine}: {case.what}: {found[-1].worst:.2g}  {found[-1].verdict}", flush=True)
    PAGE.write_text(page(found), encoding="utf-8")
    broken = sum(bool(one.broken) for one in found)
    print(f"docs/stress.md: {len(found)} cases, {broken} broken, {sum(one.seconds for one in found):.0f} s")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
