"""The baselines of the table of cases made again, beside what they were and the references.

    make cases                                (python benchmarks/cases.py: all but the published)
    make cases RUNS="regress coarse"          those runs alone
    make cases SCENES="blocks layer"          those scenes alone
    make cases ACCEPT="blocks:dissipation layer"  take these new values for baselines
    make regress                                  (... regress: half-plane theory, in seconds)
    make regress REFERENCES="blocks"              evaluate the references of these scenes again

Nothing moves unless it is named: a scene, or a scene and a quantity. The published baselines, of
default settings, are made with their pages by `make publish`. No command writes `[[expected]]` of a
scene file. Exit code 1 where a value left its baseline or misses a reference.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import case_table
import regress
from case_table import Case, Key, Sheet

from reports.page.writing import code_commit
from scenes import load_scene

ROOT = Path(__file__).parents[1]
sys.path += [str(ROOT / "tests"), str(ROOT / "tests" / "contract")]
import contract_values  # noqa: E402


class Line(NamedTuple):
    """One quantity of one scene: value now, baseline and reference where there are any, and what
    else a baseline of the quantity states, such as whether a metric is accurate.
    """

    scene: str
    key: Key
    value: Any
    baseline: Case | None
    references: tuple[Case, ...]
    more: Mapping[str, Any]

    @property
    def quantity(self) -> str:
        """Quantity and points."""
        _, quantity, at = self.key
        return f"{quantity} at {at}" if at else quantity

    @property
    def drift(self) -> float | None:
        """Difference from the baseline, as a share of its largest number."""
        if self.baseline is None:
            return None
        return case_table.difference(self.baseline, self.value).share

    @property
    def error(self) -> float | None:
        """The largest difference from a reference, as a share of its largest number."""
        shares = [case_table.difference(case, self.value).share for case in self.references]
        return max(shares, default=None)

    @property
    def good(self) -> bool:
        """Whether the baseline and every reference are met."""
        if self.baseline is None or not case_table.agrees(self.baseline, self.value):
            return False
        if {**self.baseline.more, **self.more} != self.baseline.more:
            return False
        return all(case_table.agrees(case, self.value) for case in self.references)


# ---------------------------------------------------------------------------------------- the runs
Measured: TypeAlias = tuple[dict[Key, Any], dict[Key, Mapping[str, Any]]]
"""Values of a run, and what else a baseline of some of them states."""


def of_regress(scene: str, known: Sheet) -> Measured:
    """Half-plane theory at a few instants and places."""
    return regress.measure(load_scene(scene), dict(known.points)), {}


def of_contract(scene: str, known: Sheet) -> Measured:
    """Half-plane theory on a grid of instants and places."""
    return contract_values.half_plane(contract_values.scene_of(scene), dict(known.points)), {}


def of_coarse(scene: str, known: Sheet) -> Measured:
    """Finite elements on the coarse mesh, and their comparison with theory."""
    values: dict[Key, Any] = {}
    more: dict[Key, Mapping[str, Any]] = {}
    if known.baselines(contract_values.COARSE):
        answer = contract_values.finite_elements(scene)
        values |= contract_values.coarse_values(answer)
    if known.baselines(contract_values.COMPARED):
        with tempfile.TemporaryDirectory() as folder:
            metrics = contract_values.comparison_metrics(scene, Path(folder) / scene)
        for name, metric in metrics.items():
            key = (contract_values.COMPARED, name, "")
            values[key] = metric["value"]
            more[key] = {column: metric[column] for column in ("unit", "accurate")}
    return values, more


# Run -> scenes, what measures one of them.
RUNS: dict[str, tuple[tuple[str, ...], Callable[[str, Sheet], Measured]]] = {
    "regress": (regress.NAMES, of_regress),
    "contract": (contract_values.scenes_of(case_table.THEORY), of_contract),
    "coarse": (contract_values.scenes_of(contract_values.COARSE), of_coarse),
}


def lines(run: str, names: Sequence[str] = ()) -> Iterator[Line]:
    """Every value that a run gives now, beside what the table has; of all its scenes or those
    named.
    """
    scenes, measure = RUNS[run]
    for name in scenes:
        if not names or name in names:
            known = with_points(run, case_table.sheet(name))
            baselines = known.baselines()
            values, more = measure(name, known)
            for key, value in values.items():
                references = tuple(case for case in known.references(key[0]) if case.key == key)
                yield Line(name, key, value, baselines.get(key), references, more.get(key, {}))


def with_points(run: str, known: Sheet) -> Sheet:
    """The sheet; of a scene that is new to the quick run with points to look at."""
    if run == "regress" and regress.INSTANT not in known.points:
        points = regress.points_of(load_scene(known.scene))
        return replace(known, points={**known.points, **points})
    return known


# ------------------------------------------------------------------------------------------- moving
def accept(run: str, line: Line) -> None:
    """Take the value of a line for the baseline of its quantity."""
    known = with_points(run, case_table.sheet(line.scene))
    commit = code_commit("*.py")
    if line.baseline is not None:
        more = {**line.baseline.more, **line.more}
        renewed = replace(line.baseline, value=line.value, commit=commit, more=more)
    else:
        by, quantity, at = line.key
        row = {"run": by, "quantity": quantity, "at": at, "value": line.value, "commit": commit}
        renewed = case_table.case_of_row(line.scene, row)
    case_table.write(known.with_cases([renewed]))


def is_named(line: Line, named: Sequence[str]) -> bool:
    """Whether the line is one that was asked for: SCENE, or SCENE:QUANTITY."""
    _, quantity, _ = line.key
    return line.scene in named or f"{line.scene}:{quantity}" in named


def renew_references(names: Sequence[str]) -> None:
    """Evaluate the references of the named scenes again; write those of the table that differ."""
    for name in names:
        known = with_points("regress", case_table.sheet(name))
        changed, differences, work = regress.references(known)
        if changed != known:
            case_table.write(changed)
        print(
            f"{name}: dissipation {work}, for `[[expected]]` of the scene; references that are"
            f" stored and these differ by at most {differences:.1e}"
            + ("; others were written" if changed != known else ""),
            flush=True,
        )


# -------------------------------------------------------------------------------------- the command
def show(lines: Sequence[Line]) -> None:
    """Old, new and reference side by side; of a list where it is furthest from the old one."""
    head = ("scene", "quantity", "old", "new", "reference")
    print(
        f"{head[0]:24} {head[1]:36} {head[2]:>24} {head[3]:>24} {head[4]:>24}     drift     error"
    )
    for line in lines:
        old, new, exact = side_by_side(line)
        drift = "new" if line.drift is None else f"{line.drift:.1e}"
        error = "-" if line.error is None else f"{line.error:.1e}"
        mark = "" if line.good else " <<"
        print(
            f"{line.scene:24} {line.quantity:36} {old:>24} {new:>24} {exact:>24}"
            f" {drift:>9} {error:>9}{mark}"
        )


def side_by_side(line: Line) -> tuple[str, str, str]:
    """Baseline, value and reference of a line, each as one number."""
    old = "none"
    place = 0
    if line.baseline is not None:
        difference = case_table.difference(line.baseline, line.value)
        old = str(difference.stated)
        place = difference.place
    new = _entry(line.value, place)
    exact = _entry(line.references[0].value, place) if line.references else "none"
    return old[:24], new[:24], exact[:24]


def _entry(value: Any, place: int) -> str:
    """One number or word of a value; "none" behind its end."""
    value_entries = case_table.entries(value)
    return str(value_entries[place]) if place < len(value_entries) else "none"


def main(words: Sequence[str]) -> int:
    """Measure, print, and write what is named."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    arguments.add_argument("runs", nargs="*", metavar="RUN", help=f"of {', '.join(RUNS)}: all")
    arguments.add_argument("--scenes", nargs="*", default=[], metavar="SCENE")
    arguments.add_argument(
        "--accept",
        nargs="*",
        default=[],
        metavar="SCENE[:QUANTITY]",
        help="new values that become baselines",
    )
    arguments.add_argument(
        "--references", nargs="*", default=[], metavar="SCENE", help="evaluate these again"
    )
    options = arguments.parse_args(words)
    runs = options.runs or list(RUNS)
    known = {name for run in runs if run in RUNS for name in RUNS[run][0]}
    named = {
        word.partition(":")[0] for word in (*options.scenes, *options.accept, *options.references)
    }
    unknown = [*sorted(set(runs) - set(RUNS)), *sorted(named - known)]
    if unknown:
        print(f"cases: no such run or scene: {', '.join(unknown)}", file=sys.stderr)
        return 2
    renew_references(options.references)
    found = []
    for run in runs:
        for line in lines(run, options.scenes):
            if is_named(line, options.accept) and not line.good:
                accept(run, line)
            found.append(line)
    bad = [line for line in found if not line.good]
    show([line for line in found if line.references or not line.good])
    print(f"{len(found)} values, {len(bad)} moved or not accurate")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
