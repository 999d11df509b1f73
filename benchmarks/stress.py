"""Numerical stress: what both engines do at the ends of what a scene may ask, written to docs/stress.md.

    make stress                                    (python benchmarks/stress.py, ten minutes)
    python benchmarks/stress.py "flat face" ...    (only cases whose names hold one of these; the others stay as found)

What was found is kept in stress.json, case by case with its day; the page is written from that.

A case is a list of trials. A trial gives an error, to be at most the limit, or is refused by InputError or ConvergenceError;
anything else, a warning included, breaks the case.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import stress_fe
import stress_half_plane
import stress_histories
import stress_slivers
from claim import Row
from stress_case import Case, Found

from scenes import ConvergenceError, InputError

PAGE = Path(__file__).parent.parent / "docs" / "stress.md"
KEPT = Path(__file__).with_suffix(".json")


@dataclass(frozen=True)
class Outcome:
    """What became of a case: worst errors of the trials that were answered, what was told, who refused, what broke."""

    case: Case
    worst: Mapping[str, float]
    shown: Mapping[str, float]
    right: int
    told: tuple[str, ...]
    refused: tuple[str, ...]
    broken: tuple[str, ...]
    seconds: float
    day: str = ""

    @property
    def answered(self) -> bool:
        """Whether any trial was."""
        return bool(self.worst)

    @property
    def verdict(self) -> str:
        """Every trial accounted for."""
        if self.broken:
            return "**broken**: " + "; ".join(self.broken)
        words = [f"right ({self.right})" if self.told else "right"] if self.right else []
        words += [f"told: {sentence}" for sentence in self.told]
        return "; ".join([*words, *(f"refused: “{sentence}”" for sentence in self.refused)])


class _Tally:
    """What the trials of a case have come to so far."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.worst: dict[str, float] = {}
        self.shown: dict[str, float] = {}
        self.right = 0
        self.told: list[str] = []
        self.refused: list[str] = []
        self.broken: list[str] = []

    def count(self, name: str, found: float | Found) -> None:
        """One trial that was answered: right, off and told, or wrong and silent."""
        result = found if isinstance(found, Found) else Found({"": float(found)})
        for target, source in ((self.worst, result.errors), (self.shown, result.shown)):
            for key, value in source.items():
                target[key] = float(np.maximum(target.get(key, 0.0), value))
        off = {key: value for key, value in result.errors.items() if not value <= self.case.limit}
        figures = ", ".join(f"{key} {value:.1e}".strip() for key, value in {**off, **(result.shown if "W" in off else {})}.items())
        if not off:
            self.right += 1
        elif self.case.may_tell and result.notes and np.isfinite([v for k, v in off.items() if k != "W"]).all():
            self.told.append(f"{name}: {figures}, with the note “{'” and “'.join(result.notes)}”")
        else:
            self.broken.append(f"{name}: wrong, silent: {figures}" if self.case.may_tell else f"{name}: {figures}")


def outcome(case: Case) -> Outcome:
    """Every trial of a case, warnings being errors."""
    tally = _Tally(case)
    started = time.perf_counter()
    for name, trial in case.trials():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                found = trial()
        except (InputError, ConvergenceError) as reason:
            tally.refused.append(f"{reason}".splitlines()[0])
            if not case.may_refuse:
                tally.broken.append(f"{name}: refused, {reason}")
        except Exception as reason:  # noqa: BLE001 - a traceback is what is looked for: it is counted and shown
            tally.broken.append(f"{name}: {type(reason).__name__}: {reason}")
        else:
            tally.count(name, found)
    if case.must_refuse and tally.worst:
        tally.broken.append("a trial was answered")
    refused = tuple(dict.fromkeys(tally.refused))
    seconds = time.perf_counter() - started
    today = datetime.now(UTC).date().isoformat()
    return Outcome(case, tally.worst, tally.shown, tally.right, tuple(tally.told), refused, tuple(tally.broken), seconds, today)


def cases() -> Iterator[Case]:
    """Both engines' cases."""
    yield from stress_half_plane.cases()
    yield from stress_histories.cases()
    yield from stress_fe.cases()
    yield from stress_slivers.cases()


def rows() -> Iterator[Row]:
    """One claim a case: its worst error, or the number of trials that went wrong where some are told or all shall be refused."""
    for case in cases():
        found = outcome(case)
        failed = float(len(found.broken))
        what = f"{case.engine}: {case.what}"
        if case.must_refuse or found.broken or found.told:
            yield Row(f"{what}, trials that broke", failed, 0.0, found.verdict.replace("|", "\\|"))
        else:
            yield Row(f"{what}: {case.measure}", max(found.worst.values()), case.limit, case.tried.replace("|", "\\|"))


_HEAD = (
    "Written by `make stress` and by nothing else. Each case ends in a right answer, in one whose own notes say that it is off, or "
    "in a refusal of one sentence (quoted); what is off by more than the limit and says nothing of it is broken, and so is a "
    "warning. The column “worst” has the worst of all trials that were answered, those with notes among them. The finite "
    "elements run on coarse meshes (`MeshSettings.coarse()`) unless the case says otherwise: p is off in L2 over ‖p‖, q over f ‖p‖, "  # noqa: E501
    "at the worst of sixteen instants of the last revolution with more than 0.3 of the largest load, W over W; for W the error in "
    "A f² P² stands beside it, P being the largest load. Their limit is 5 % for each: a few times what a coarse mesh promises of "
    "the shear."
)


def _figures(values: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {value:.1e}".strip() for name, value in values.items())


def page(found: list[Outcome]) -> str:
    """The table of docs/stress.md."""
    lines = ["# Numerical stress tests", "", _HEAD, ""]
    for engine in dict.fromkeys(one.case.engine for one in found):
        lines += [f"## {engine}", "", "| case | tried | measure | worst | limit | verdict | run |", "|---|---|---|---|---|---|---|"]
        for one in (one for one in found if one.case.engine == engine):
            limit = f"{one.case.limit:.0e}" if one.answered else ""
            worst = _figures(one.worst) + (f" ({_figures(one.shown)})" if one.shown else "")
            cells = (one.case.what, one.case.tried, one.case.measure, worst, limit, one.verdict, one.day)
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


def kept() -> dict[str, dict[str, Any]]:
    """What was found before, by engine and case."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def keep(found: Outcome) -> None:
    """Put one outcome beside the others."""
    own = {f.name: getattr(found, f.name) for f in fields(Outcome) if f.name != "case"}
    text = json.dumps(kept() | {_name(found.case): own}, indent=1, ensure_ascii=False)
    KEPT.write_text(text + "\n", encoding="utf-8")


def _name(case: Case) -> str:
    return f"{case.engine}: {case.what}"


def main() -> int:
    """Run the cases that are asked for, all where none is; write the page."""
    for case in cases():
        if sys.argv[1:] and not any(words in _name(case) for words in sys.argv[1:]):
            continue
        found = outcome(case)
        keep(found)
        print(f"{found.seconds:6.1f} s  {_name(case)}: {_figures(found.worst)}  {found.verdict}", flush=True)
    before = kept()
    all_found = [Outcome(case=case, **before[_name(case)]) for case in cases() if _name(case) in before]
    missing = [_name(case) for case in cases() if _name(case) not in before]
    PAGE.write_text(page(all_found), encoding="utf-8")
    broken = sum(bool(one.broken) for one in all_found)
    print(f"docs/stress.md: {len(all_found)} cases, {broken} broken, {sum(one.seconds for one in all_found):.0f} s")
    if missing:
        print(f"not run yet: {'; '.join(missing)}")
    return 1 if broken or missing else 0


if __name__ == "__main__":
    sys.exit(main())
