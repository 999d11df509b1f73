"""What `diff` compares: the values of a run, from its folder or one of its files, or those of a
baseline; and their differences.

Same machine, same answer: half-plane theory repeats itself to the last digit, finite elements too.
The default tolerances leave room for another order of sums (another processor, another BLAS), and
for nothing else.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from reports.comparison.dimensionless import energy_scale
from reports.comparison.laws import OF_UNSYMMETRIC
from reports.comparison.verdicts import Verdict, verdict_on
from reports.folder import replace_text
from scenes import ContactSolution, InputError, Scene
from scenes.errors import first_line
from scenes.files import parsed_json, text_of
from scenes.scene import WORDS

# What this version writes. The numbers 1 and 2 of each are read.
_BASELINE, SOLUTION = "halfplane baseline 2", "halfplane solution 2"
_FORMAT = re.compile(r"halfplane (baseline|comparison|solution) ([1-9]\d*)")
_NEWEST = 2
# The work that a change of the code moves; what the cache of condensed bodies spares would differ
# from one run to the next.
COUNTS = (
    *(
        "degrees of freedom",
        "contact nodes",
        "steps solved",
        "contact iterations",
        "linear solves",
        "factorisations",
    ),
    *("slip quadratures", "quadrature nodes"),
)
_OF_AN_ENGINE = (
    "dissipation",
    "loop_work",
    "permanent_stick_half_width",
    "largest_half_width",
    "largest_pressure",
)
# The first pattern that fits a key counts. Values of other processors: docs/regression.md.
_DEFAULTS: tuple[tuple[str, float], ...] = (
    # rounding decides whether an increment is halved, and the next ones follow
    ("*.counts.*", 0.05),
    ("metric.*", 1e-6),
    ("semi_analytic.*", 1e-9),
    ("*", 1e-6),
)
# Below this share of A f^2 P^2 a dissipation is the rounding of a sum whose truth is 0.
_NOTHING = 1e-6
SAME, DIFFERS, ONLY_A, ONLY_B = "same", "differs", "only in A", "only in B"


@dataclass(frozen=True)
class Findings:
    """The figures of a run or of a baseline."""

    source: str  # where they were read, as the user named it
    scene: Scene  # the question
    # key -> value; None for "no such thing" (a permanent stick zone, say). Discrepancies of a
    # comparison are "metric.<key>", figures of an engine "<engine>.<quantity>" in the scene's
    # units, counts "<engine>.counts.<name>"
    figures: Mapping[str, float | None]
    engines: Mapping[str, Mapping[str, Any]]  # engine -> {"settings": ..., "versions": ...}
    unfinished: tuple[str, ...] = ()  # sentences of engines that did not converge
    # pattern of keys -> largest admitted difference, kept with a baseline
    tolerances: Mapping[str, float] = field(default_factory=dict)


def read_findings(source: str | Path) -> Findings:
    """The findings of a run folder, comparison.json, <engine>.json, solution (.nc) or baseline.

    A folder that holds a comparison is read for that; otherwise for every engine's own answer in
    it.

    Raises
    ------
    InputError
        Where there is nothing, or something else.
    """
    path = Path(source)
    if not path.exists():
        raise InputError(f"{source}: there is no such file or folder")
    if path.suffix == ".nc" and not path.is_dir():
        try:
            return of_solution(ContactSolution.load(path), str(source))
        except (OSError, KeyError, ValueError, TypeError) as reason:
            raise InputError(
                f"{source}: this can't be read as a solution of halfplane: {first_line(reason)}"
            ) from reason
    whole = path / "comparison.json" if path.is_dir() else path
    if whole.exists():
        return of_content(_json(whole, source), str(source))
    contents = [_json(file, file) for file in sorted(path.glob("*.json"))]
    answers = [
        content
        for content in contents
        if str(content.get("format")).startswith("halfplane solution ")
    ]
    if not answers:
        raise InputError(
            f"{source}: this is no folder of a run: it holds no comparison.json and no answer of an"
            " engine"
        )
    parts = [of_content(content, str(source)) for content in answers if content["converged"]]
    if not parts:
        raise InputError(
            f"{source}: it holds only the steps before an engine failed:"
            f" {answers[0].get('message')}"
        )
    if any(_physics(part.scene) != _physics(parts[0].scene) for part in parts):
        raise InputError(
            f"{source}: the engines in this folder answer different scenes; name the file of one of"
            " them"
        )
    figures, engines = (
        {k: v for part in parts for k, v in getattr(part, name).items()}
        for name in ("figures", "engines")
    )
    return Findings(str(source), parts[0].scene, figures, engines)


def of_content(content: Mapping[str, Any], source: str) -> Findings:
    """The findings in what comparison.json, <engine>.json or a baseline hold."""
    stated = content.get("format")
    found = _FORMAT.fullmatch(stated) if isinstance(stated, str) else None
    if found is None:
        kinds = "baseline, comparison, solution"
        raise InputError(
            f"{source}: format is {stated!r}; it is 'halfplane KIND {_NEWEST}', KIND one of {kinds}"
        )
    if int(found[2]) > _NEWEST:
        raise InputError(
            f"{source}: format is {stated!r}, of a later version; update halfplane, or run the"
            " scene again"
        )
    if int(found[2]) < _NEWEST:
        raise InputError(
            f"{source}: format is {stated!r}, of version 0.1; convert it with halfplane 0.3, or run"
            " the scene again"
        )
    try:
        return _read(found[1], content, source)
    except (KeyError, TypeError, ValueError, AttributeError) as reason:
        if isinstance(reason, InputError):
            raise
        raise InputError(
            f"{source}: this says it is a {stated}, but can't be read as one: {first_line(reason)}"
        ) from reason


def _read(kind: str, content: Mapping[str, Any], source: str) -> Findings:
    """Of content of that kind; whatever is missing or no number raises."""
    scene, figures = Scene.model_validate(content["scene"]), dict[str, float | None]()
    answers, tolerances, engines, unfinished = dict[str, Mapping[str, Any]](), {}, {}, []
    if kind == "baseline":
        figures = {str(key): _number(value) for key, value in content["figures"].items()}
        tolerances = {str(key): float(value) for key, value in content["tolerances"].items()}
        engines = {str(key): _made_by(value) for key, value in content["engines"].items()}
    elif kind == "comparison":
        for key, metric in content["metrics"].items():
            figures[f"metric.{key}"] = _number(metric["value"])
            # JSON has no NaN: without this a value that is none and one that is no number would
            # look alike.
            figures |= {} if metric["finite"] else {f"metric.{key}.finite": 0.0}
        same = content["reference"]["engine"] == content["result"]["engine"]
        answers = {
            role if same else _slug(content[role]["engine"]): content[role]
            for role in ("reference", "result")
        }
    else:
        answers = {_slug(content["engine"]): content}
    for name, answer in answers.items():
        keys = (*_OF_AN_ENGINE, *(key for key in OF_UNSYMMETRIC if key in answer))
        figures |= {f"{name}.{key}": _number(answer[key]) for key in keys}
        figures |= {
            f"{name}.counts.{_slug(key)}": _number(answer["counts"][key])
            for key in COUNTS
            if key in answer["counts"]
        }
        engines[name] = _made_by(answer)
        unfinished += [] if answer["converged"] else [f"{name}: {answer['message']}"]
    return Findings(source, scene, figures, engines, tuple(unfinished), tolerances)


def of_solution(solution: ContactSolution, source: str) -> Findings:
    """The findings of one answer."""
    from reports.comparison.json_values import solution_content, strict

    return _read(
        "solution",
        {**strict(solution_content(solution, ())), "scene": solution.scene.model_dump(mode="json")},
        source,
    )


def write_baseline(findings: Findings, path: Path, tolerances: Mapping[str, float]) -> None:
    """Keep `findings` as a baseline, whole or not at all.

    Raises
    ------
    InputError
        Where an engine did not converge, or `path` can't be written to.
    """
    if findings.unfinished:
        raise InputError(
            f"{findings.source}: not converged, so no baseline: {'; '.join(findings.unfinished)}"
        )
    content = {
        "format": _BASELINE,
        "scene": findings.scene.model_dump(mode="json"),
        "engines": findings.engines,
    }
    content |= {"tolerances": dict(tolerances), "figures": findings.figures}
    replace_text(path, json.dumps(content, allow_nan=False, indent=1, ensure_ascii=False) + "\n")


def is_baseline(path: Path) -> bool:
    """Whether a file says that it is a baseline, whole or spoilt."""
    if not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return "halfplane baseline " in file.read(200)


def _json(path: Path, source: str | Path) -> dict[str, Any]:
    try:
        content = parsed_json(text_of(path, "the file"))
    except InputError:
        raise
    except ValueError as reason:
        raise InputError(f"{source}: this can't be read as JSON: {first_line(reason)}") from reason
    if not isinstance(content, dict):
        raise InputError(f"{source}: this is JSON, but neither a run nor a baseline of halfplane")
    return content


def _made_by(content: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    return {name: dict(content[name]) for name in ("settings", "versions")}


def _number(value: Any) -> float | None:
    if value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    raise ValueError(f"{value!r} is not a number")


def _slug(text: str) -> str:
    """A key without blanks, which would have to be quoted on a command line."""
    return re.sub(r"\W+", "_", text)


def _physics(scene: Scene) -> dict[str, Any]:
    """Every number and word of a scene that moves its answer."""
    return _flat(
        {key: value for key, value in scene.model_dump(mode="json").items() if key not in WORDS}
    )


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    """Nested mappings and lists as one mapping.

    >>> _flat({"load": {"cycle": [[1.0, 0.5]]}})
    {'load.cycle[0][0]': 1.0, 'load.cycle[0][1]': 0.5}
    """
    if isinstance(value, Mapping):
        # A file's rows are here; where they once lay is nobody's business.
        entries = [
            (f"{name}.{key}" if name else str(key), entry)
            for key, entry in value.items()
            if key != "file"
        ]
    elif isinstance(value, list):
        entries = [(f"{name}[{number}]", entry) for number, entry in enumerate(value)]
    else:
        return {name: value}
    return {
        key: part for entry_name, entry in entries for key, part in _flat(entry, entry_name).items()
    }


# -------------------------------------------------------------------------------------- differences
@dataclass(frozen=True)
class Row:
    """One figure of two findings."""

    key: str  # of the figure
    # a, b: its values; None for "no such thing"
    a: float | None
    b: float | None
    difference: float | None  # B less A; None where there is nothing to subtract
    kind: str  # "absolute", or "relative": over the larger of |A| and |B|
    tolerance: float  # largest admitted |difference|
    verdict: str  # same, differs, only in A, only in B


@dataclass(frozen=True)
class Difference:
    """Two findings compared: the rows, and what else a reader must know."""

    a: str
    b: str
    scene: str
    rows: tuple[Row, ...]
    notes: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether every figure of what both have is in both and within its tolerance."""
        return all(row.verdict == SAME for row in self.rows)

    def content(self) -> dict[str, Any]:
        """The table for programs; a tolerance that is infinite becomes null there."""
        return {"same": self.same, **asdict(self)}


def difference(
    a: Findings, b: Findings, tolerances: Mapping[str, float] | None = None
) -> Difference:
    """How far the figures of `b` are from those of `a`.

    Parameters
    ----------
    a, b
        of one scene
    tolerances
        pattern of keys -> tolerance; before those kept with either, which come before the
        defaults

    Raises
    ------
    InputError
        For different scenes, no common engine, or a pattern that fits no key.
    """
    if apart := _apart(_physics(a.scene), _physics(b.scene)):
        named = "; ".join(f"{key} is {ours} and {theirs}" for key, ours, theirs in apart[:6])
        more = f"; and {len(apart) - 6} more" if len(apart) > 6 else ""
        raise InputError(f"{a.source} and {b.source} answer different scenes: {named}{more}")
    # What a figure belongs to, the comparison or an engine, is the first word of its key.
    groups = [{key.partition(".")[0] for key in one.figures} for one in (a, b)]
    keys = [
        key for key in {**a.figures, **b.figures} if key.partition(".")[0] in groups[0] & groups[1]
    ]
    if not keys:
        engines = (" and ".join(one.engines) or "no engine" for one in (a, b))
        raise InputError(
            f"{a.source} and {b.source} have no figure in common: {' and '.join(engines)}"
        )
    for pattern in tolerances or {}:
        if not any(fnmatchcase(key, pattern) for key in keys):
            raise InputError(
                f"--tolerance {pattern}: no figure is called so; there are {', '.join(keys)}"
            )
    patterns = [
        *(tolerances or {}).items(),
        *b.tolerances.items(),
        *a.tolerances.items(),
        *_DEFAULTS,
    ]
    rows = tuple(
        _row(key, a, b, next(value for pattern, value in patterns if fnmatchcase(key, pattern)))
        for key in keys
    )
    notes = [
        f"not compared, for it is only in A: {group}.*" for group in sorted(groups[0] - groups[1])
    ]
    notes += [
        f"not compared, for it is only in B: {group}.*" for group in sorted(groups[1] - groups[0])
    ]
    return Difference(
        a.source, b.source, a.scene.name or b.scene.name, rows, (*notes, *_notes(a, b))
    )


def _apart(ours: Mapping[str, Any], theirs: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Keys whose values are not the same, with both."""
    pairs = (
        (key, ours.get(key, "absent"), theirs.get(key, "absent")) for key in {**ours, **theirs}
    )
    return [pair for pair in pairs if pair[1] != pair[2]]


def _notes(a: Findings, b: Findings) -> Iterator[str]:
    """What moves figures without being one (settings, versions), and engines that did not
    converge.
    """
    for engine in sorted(a.engines.keys() & b.engines.keys()):
        for key, ours, theirs in _apart(_flat(a.engines[engine]), _flat(b.engines[engine])):
            yield f"{engine}: {key} is {ours} in A and {theirs} in B"
    for letter, findings in (("A", a), ("B", b)):
        yield from (f"{letter} did not converge: {sentence}" for sentence in findings.unfinished)


def patterned_tolerances(words: Sequence[str]) -> dict[str, float]:
    """What --tolerance KEY=VALUE says; InputError for anything else.

    >>> patterned_tolerances(["metric.*=1e-4"])
    {'metric.*': 0.0001}
    """
    found = {}
    for word in words:
        key, _, text = word.rpartition("=")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (key and value >= 0):
            raise InputError(
                f"--tolerance {word}: write KEY=VALUE, VALUE a number not below 0 (inf: not judged)"
            )
        found[key] = value
    return found


def _row(key: str, a: Findings, b: Findings, tolerance: float) -> Row:
    first, second = a.figures.get(key), b.figures.get(key)
    kind = "absolute" if key.startswith("metric.") else "relative"
    if key not in a.figures or key not in b.figures:
        return Row(
            key, first, second, None, kind, tolerance, ONLY_A if key in a.figures else ONLY_B
        )
    if first is None or second is None:
        return Row(key, first, second, None, kind, tolerance, SAME if first is second else DIFFERS)
    engine, _, quantity = key.partition(".")
    size = 1.0 if kind == "absolute" else max(abs(first), abs(second))
    if kind == "relative" and quantity in ("dissipation", "loop_work", "bulk_work"):
        load = (a.figures[f"{engine}.largest_pressure"] or 0.0) * (
            a.figures[f"{engine}.largest_half_width"] or 0.0
        )
        size = max(size, _NOTHING * energy_scale(a.scene, load))
    change = second - first
    apart = change / size if change else 0.0
    return Row(
        key,
        first,
        second,
        apart,
        kind,
        tolerance,
        SAME if verdict_on(apart, tolerance) is Verdict.WITHIN else DIFFERS,
    )
