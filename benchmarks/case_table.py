"""The one table of cases: scene, quantity, value, source, tolerance, requirement; reading, writing,
comparing.

A case is a *reference* or a *baseline*, and the two are never mixed. A reference is a closed form,
a value of a paper, 30 digits or another code's result. It states its source, and no command changes
it. A baseline is a value of our own engine at a commit. It says that nothing moved, not that
anything is right; `make cases` makes it again.

Where a case stands:

- `tests/cases/SCENE.jsonl`: a head (scene, its keys where no scene file has them, points), then one
  case a line. `tests/cases/runs.toml` states what each run is, with the tolerance and requirement
  of its cases; a case states its own only where they differ.
- `[[expected]]` of a scene file, in `scenes/library` and `tests/scenes`: references of whole
  cycles, with all their digits. They ship with the program, and `halfplane run` checks them.
"""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "tests" / "cases"
SCENE_FILES = (ROOT / "scenes" / "library", ROOT / "tests" / "scenes")
# The run that an engine named in `[[expected]]` is judged by.
THEORY = "theory"
ELEMENTS = "elements"
_RUN_OF_ENGINE = {"half-plane theory": THEORY, "finite elements": ELEMENTS}
# Sources of numbers in `[[expected]]` that are our own engine's.
OUR_OWN = "our own"
Key = tuple[str, str, str]  # run, quantity, points


@dataclass(frozen=True)
class Case:
    """One quantity of one scene."""

    scene: str
    run: str  # what gives the value: a table of tests/cases/runs.toml
    quantity: str
    at: str  # which points of the scene's head; "" where the quantity needs none
    value: Any  # number, digits as text, word, true or false, None for no such thing, lists of them
    tolerance: float  # largest difference, as a share of the largest number of `value`
    least: float  # absolute difference below which nothing counts: round-off of a value that is 0
    requirement: str  # a requirement of docs/requirements.toml
    commit: str = ""  # of a baseline: the code that gave it
    source: str = ""  # of a reference
    more: Mapping[str, Any] = field(
        default_factory=dict
    )  # other columns, as they stand in the file

    @property
    def is_reference(self) -> bool:
        """Whether somebody else's mathematics gives the value."""
        return not self.commit and not self.source.startswith(OUR_OWN)

    @property
    def key(self) -> Key:
        """What the case is of."""
        return self.run, self.quantity, self.at


@dataclass(frozen=True)
class Sheet:
    """All cases of one scene in tests/cases."""

    scene: str
    keys: Mapping[str, Any] | None  # of a scene that is no file
    points: Mapping[str, Mapping[str, list[float]]]  # name -> {"time": instants, "x": places}
    cases: tuple[Case, ...]

    def baseline(self, run: str, quantity: str, at: str = "") -> Case:
        """The baseline at these points; KeyError where there is none."""
        return self.baselines(run)[run, quantity, at]

    def baselines(self, *runs: str) -> dict[Key, Case]:
        """The baselines of these runs, of all if none is named, by their keys."""
        return {
            case.key: case
            for case in self.cases
            if not case.is_reference and (not runs or case.run in runs)
        }

    def references(self, run: str) -> list[Case]:
        """The references of a run in tests/cases and in the scene's own file."""
        stated = (*self.cases, *expected(self.scene))
        return [case for case in stated if case.is_reference and case.run == run]

    def with_cases(self, cases: Sequence[Case]) -> Sheet:
        """The same sheet with each of `cases` in the place of the one of its key, or behind all."""
        renewed = {case.key: case for case in cases}
        kept = [case if case.is_reference else renewed.pop(case.key, case) for case in self.cases]
        return replace(self, cases=(*kept, *renewed.values()))


# ------------------------------------------------------------------------------ reading and writing
@cache
def runs() -> dict[str, dict[str, Any]]:
    """Run -> what it is, tolerance, least, requirement of its baselines and of its references."""
    return tomllib.loads((FOLDER / "runs.toml").read_text(encoding="utf-8"))


def file_of(scene: str) -> Path:
    """The file with the cases of a scene.

    >>> file_of("power-3.5, ellipse").name
    'power-3.5-ellipse.jsonl'
    """
    return FOLDER / f"{re.sub(r'[^A-Za-z0-9.]+', '-', scene)}.jsonl"


@cache
def scenes() -> tuple[str, ...]:
    """The scenes that have a file of cases, in alphabetical order."""
    heads = (path.open(encoding="utf-8") for path in FOLDER.glob("*.jsonl"))
    names = []
    for file in heads:
        with file:
            names.append(json.loads(file.readline())["scene"])
    return tuple(sorted(names))


def sheet(scene: str) -> Sheet:
    """The cases of a scene; none where it has no file."""
    path = file_of(scene)
    if not path.exists():
        return Sheet(scene, None, {}, ())
    head, *rows = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
    cases = tuple(case_of_row(scene, row) for row in rows)
    return Sheet(head["scene"], head.get("keys"), head["points"], cases)


def case_of_row(scene: str, row: Mapping[str, Any]) -> Case:
    """A case from its line: what the line does not state is that of its run."""
    columns = dict(row)
    run = columns.pop("run")
    kind = runs()[run]
    is_reference = "commit" not in columns
    settings = {
        "at": columns.pop("at", ""),
        "tolerance": columns.pop("tolerance", kind["tolerance"]),
        "least": columns.pop("least", kind["least"]),
        "requirement": columns.pop(
            "requirement", kind["reference_requirement" if is_reference else "requirement"]
        ),
        "commit": columns.pop("commit", ""),
        "source": columns.pop("source", ""),
    }
    return Case(
        scene, run, columns.pop("quantity"), value=columns.pop("value"), more=columns, **settings
    )


def row_of_case(case: Case) -> dict[str, Any]:
    """The line of a case: what is that of its run is left out."""
    kind = runs()[case.run]
    row: dict[str, Any] = {"run": case.run, "quantity": case.quantity}
    if case.at:
        row["at"] = case.at
    row["value"] = case.value
    usual = kind["reference_requirement" if case.is_reference else "requirement"]
    stated = {
        "tolerance": (case.tolerance, kind["tolerance"]),
        "least": (case.least, kind["least"]),
        "requirement": (case.requirement, usual),
        "commit": (case.commit, ""),
        "source": (case.source, ""),
    }
    row |= {name: value for name, (value, default) in stated.items() if value != default}
    return row | dict(case.more)


def write(cases: Sheet) -> None:
    """Write the file of a scene."""
    head: dict[str, Any] = {"scene": cases.scene}
    if cases.keys is not None:
        head["keys"] = dict(cases.keys)
    head["points"] = {name: dict(points) for name, points in cases.points.items()}
    lines = [head, *map(row_of_case, cases.cases)]
    text = "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines)
    file_of(cases.scene).write_text(text, encoding="utf-8")
    scenes.cache_clear()


@cache
def expected(scene: str) -> tuple[Case, ...]:
    """What the scene's own file expects, values with all their digits; none of a scene that is no
    file.
    """
    paths = (folder / f"{scene}.toml" for folder in SCENE_FILES)
    path = next((path for path in paths if path.exists()), None)
    if path is None:
        return ()
    content = tomllib.loads(path.read_text(encoding="utf-8"), parse_float=str)
    cases = []
    for table in content.get("expected", ()):
        run = _RUN_OF_ENGINE[table.get("engine", "half-plane theory")]
        row = {"run": run, "quantity": table["quantity"], "value": table["value"]}
        row |= {"tolerance": float(table["tolerance"]), "source": table["source"]}
        cases.append(case_of_row(scene, row))
    return tuple(cases)


# ---------------------------------------------------------------------------------------- comparing
class Difference(NamedTuple):
    """Where a value is furthest from that of its case."""

    absolute: float  # infinite where shape, words or what is None differ
    share: float  # of the largest number of the case
    stated: Any  # the entry of the case
    found: Any  # the entry in its place
    place: int  # of both among the entries


def difference(case: Case, value: Any) -> Difference:
    """The largest difference of `value` from the case; digits of a text count as those of a
    float.
    """
    stated = entries(case.value)
    entries_of_value = entries(value)
    if len(stated) != len(entries_of_value):
        lengths = f"{len(stated)} values", f"{len(entries_of_value)} values"
        return Difference(math.inf, math.inf, *lengths, 0)
    if not stated:
        return Difference(0.0, 0.0, "no value", "no value", 0)
    size = max((abs(float(entry)) for entry in stated if _is_finite(entry)), default=0.0)
    worst = Difference(0.0, 0.0, stated[0], entries_of_value[0], 0)
    for place, (before, after) in enumerate(zip(stated, entries_of_value, strict=True)):
        if _is_number(before) and _is_number(after):
            distance = _apart(float(before), float(after))
        else:
            distance = 0.0 if before == after else math.inf
        if distance > worst.absolute:
            worst = Difference(
                distance, distance / size if size else distance, before, after, place
            )
    return worst


def _apart(before: float, after: float) -> float:
    """|after - before|; infinite where one is infinite and the other is not."""
    if before == after:
        return 0.0
    return abs(after - before) if math.isfinite(before) and math.isfinite(after) else math.inf


def agrees(case: Case, value: Any) -> bool:
    """Whether a value is that of the case, within its tolerance."""
    deviation = difference(case, value)
    return deviation.share <= case.tolerance or deviation.absolute <= case.least


def moved(baselines: Mapping[Key, Case], now: Mapping[Any, Any]) -> list[str]:
    """A line for each baseline that `now` lacks or has another value of.

    Parameters
    ----------
    now : (run, quantity, at) -> value
    """
    lines = []
    for key, case in baselines.items():
        name = " at ".join(filter(None, (case.quantity, case.at)))
        if key not in now:
            lines.append(f"{case.run}: {name}: missing")
        elif not agrees(case, now[key]):
            deviation = difference(case, now[key])
            lines.append(
                f"{case.run}: {name}: {deviation.found!r}, baseline {deviation.stated!r}; differs"
                f" by {deviation.share:.1e} of the largest, allowed {case.tolerance:.1e}"
            )
    return lines


def entries(value: Any) -> list[Any]:
    """The numbers and words of a value, in their order."""
    if isinstance(value, list | tuple):
        return [entry for part in value for entry in entries(part)]
    return [value]


def _is_number(entry: Any) -> bool:
    if isinstance(entry, bool) or entry is None:
        return False
    try:
        float(entry)
    except ValueError:
        return False
    return True


def _is_finite(entry: Any) -> bool:
    return _is_number(entry) and math.isfinite(float(entry))


def plain(values: Any) -> Any:
    """Arrays as lists, every NaN as None."""
    if isinstance(values, dict):
        return {name: plain(value) for name, value in values.items()}
    if isinstance(values, np.ndarray | np.generic):
        return plain(values.tolist())
    if isinstance(values, list | tuple):
        return [plain(value) for value in values]
    return None if isinstance(values, float) and math.isnan(values) else values
