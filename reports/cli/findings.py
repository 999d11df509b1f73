"""What `diff` compares: the values of a run, from its folder or one of its files, or those of a baseline; and their differences.

Same machine, same answer: half-plane theory repeats itself to the last digit, finite elements too. The default tolerances leave
room for another order of sums (another processor, another BLAS), and for nothing else.
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

from reports.comparison.metrics import Verdict, energy_scale, verdict_on
from reports.staging import replace_text
from scenes import ContactSolution, InputError, Scene
from scenes.errors import first_line, present_names
from scenes.files import parsed_json, text_of
from scenes.scene import WORDS

# What this version writes. The numbers 1 and 2 of each are read.
BASELINE, SOLUTION = "halfplane baseline 2", "halfplane solution 2"
_FORMAT = re.compile(r"halfplane (baseline|comparison|solution) ([1-9]\d*)")
_NEWEST = 2
# The work that a change of the code moves; what a store of condensed bodies spares would differ from one run to the next.
COUNTS = (
    "degrees of freedom",
    "contact nodes",
    "steps solved",
    "contact iterations",
    "linear solves",
    "factorisations",
    "slip quadratures",
    "quadrature nodes",
)
# Of scenes with bulk stress, tilt or unequal sides.
OF_BULK = ("bulk_work", "permanent_stick_left", "permanent_stick_right")
OF_AN_ENGINE = ("dissipation", "loop_work", "permanent_stick_half_width", "largest_half_width", "largest_pressure")
# The first pattern that fits a key counts. Values of other processors: docs/regression.md.
DEFAULTS: tuple[tuple[str, float], ...] = (
    ("*.counts.*", 0.05),  # rounding decides whether an increment is halved, and the next ones follow
    ("metric.*", 1e-6),
    ("semi_analytic.*", 1e-9),
    ("*", 1e-6),
)
# Of two mirrored peaks rounding says which is the larger: the place of a peak is compared without its sign.
MIRRORED = "metric.*_place"
# Below this share of A f^2 P^2 a dissipation is the rounding of a sum whose truth is 0.
NOTHING = 1e-6
SAME, DIFFERS, ONLY_A, ONLY_B = "same", "differs", "only in A", "only in B"


@dataclass(frozen=True)
class Findings:
    """The figures of a run or of a baseline.

    Attributes
    ----------
    source : where they were read, as the user named it
    scene : the question
    figures : key -> value; None for "no such thing" (a permanent stick zone, say). Discrepancies of a comparison are
        "metric.<key>", figures of an engine "<engine>.<quantity>" in the scene's units, counts "<engine>.counts.<name>"
    engines : engine -> {"settings": ..., "versions": ...}
    unfinished : sentences of engines that did not converge
    tolerances : pattern of keys -> largest admitted difference, kept with a baseline
    """

    source: str
    scene: Scene
    figures: Mapping[str, float | None]
    engines: Mapping[str, Mapping[str, Any]]
    unfinished: tuple[str, ...] = ()
    tolerances: Mapping[str, float] = field(default_factory=dict)


def read_findings(source: str | Path) -> Findings:
    """The findings of a run folder, comparison.json, <engine>.json, solution (.nc) or baseline.

    A folder that holds a comparison is read for that; otherwise for every engine's own answer in it.

    Raises
    ------
    InputError
        Where there is nothing, or something else.
    """
    path = Path(source)
    if not path.exists():
        raise InputError(f"{source}: there is no such file or folder")
    if path.is_dir():
        return _of_folder(path, str(source))
    if path.suffix == ".nc":
        return of_solution(_solution(path, source), str(source))
    return of_content(_json(path, source), str(source))


def of_content(content: Mapping[str, Any], source: str) -> Findings:
    """The findings in what comparison.json, <engine>.json or a baseline hold."""
    readers = {"baseline": _of_baseline, "comparison": _of_comparison, "solution": _of_answers}
    stated = content.get("format")
    found = _FORMAT.fullmatch(stated) if isinstance(stated, str) else None
    if found is None:
        raise InputError(f"{source}: format is {stated!r}; it is 'halfplane KIND {_NEWEST}', KIND one of {', '.join(readers)}")
    if int(found[2]) > _NEWEST:
        raise InputError(f"{source}: format is {stated!r}, of a later version; update halfplane, or run the scene again")
    try:
        return readers[found[1]](content, source)
    except (KeyError, TypeError, ValueError, AttributeError) as reason:
        if isinstance(reason, InputError):
            raise
        raise InputError(f"{source}: this says it is a {stated}, but can't be read as one: {first_line(reason)}") from reason


def of_solution(solution: ContactSolution, source: str) -> Findings:
    """The findings of one answer."""
    from reports.comparison.content import solution_content, strict

    content = strict(solution_content(solution, ()))
    return _of_answers({**content, "scene": solution.scene.model_dump(mode="json")}, source)


def write_baseline(findings: Findings, path: Path, tolerances: Mapping[str, float]) -> None:
    """Keep `findings` as a baseline, whole or not at all.

    Raises
    ------
    InputError
        Where an engine did not converge, or `path` can't be written to.
    """
    if findings.unfinished:
        raise InputError(f"{findings.source}: not converged, so no baseline: {'; '.join(findings.unfinished)}")
    content = {
        "format": BASELINE,
        "scene": findings.scene.model_dump(mode="json"),
        "engines": findings.engines,
        "tolerances": dict(tolerances),
        "figures": findings.figures,
    }
    replace_text(path, json.dumps(content, allow_nan=False, indent=1, ensure_ascii=False) + "\n")


def physics(scene: Scene) -> dict[str, Any]:
    """Every number and word of a scene that moves its answer, flat: "load.kind", "load.cycle[0][1]".

    >>> from scenes import load_scene
    >>> physics(load_scene("cattaneo-mindlin"))["load.cycle[0][0]"]
    90.62286500739786
    """
    content = {key: value for key, value in scene.model_dump(mode="json").items() if key not in WORDS}
    return flat(content)


def flat(value: Any, name: str = "") -> dict[str, Any]:
    """Nested mappings and lists as one mapping.

    >>> flat({"load": {"cycle": [[1.0, 0.5]]}})
    {'load.cycle[0][0]': 1.0, 'load.cycle[0][1]': 0.5}
    """
    if isinstance(value, Mapping):
        # A file's rows are here; where they once lay is nobody's business.
        entries = [(f"{name}.{key}" if name else str(key), entry) for key, entry in value.items() if key != "file"]
    elif isinstance(value, list):
        entries = [(f"{name}[{number}]", entry) for number, entry in enumerate(value)]
    else:
        return {name: value}
    return {key: part for entry_name, entry in entries for key, part in flat(entry, entry_name).items()}


def _of_folder(folder: Path, source: str) -> Findings:
    if (folder / "comparison.json").exists():
        return of_content(_json(folder / "comparison.json", source), source)
    answers = [
        content
        for path in sorted(folder.glob("*.json"))
        if str((content := _json(path, path)).get("format")).startswith("halfplane solution ")
    ]
    finished = [content for content in answers if content["converged"]]
    if not answers:
        raise InputError(f"{source}: this is no folder of a run: it holds no comparison.json and no answer of an engine")
    if not finished:
        raise InputError(f"{source}: it holds only the steps before an engine failed: {answers[0].get('message')}")
    parts = [of_content(content, source) for content in finished]
    if any(physics(part.scene) != physics(parts[0].scene) for part in parts):
        raise InputError(f"{source}: the engines in this folder answer different scenes; name the file of one of them")
    return Findings(
        source,
        parts[0].scene,
        {key: value for part in parts for key, value in part.figures.items()},
        {key: value for part in parts for key, value in part.engines.items()},
    )


def _of_baseline(content: Mapping[str, Any], source: str) -> Findings:
    return Findings(
        source,
        Scene.model_validate(present_names(content["scene"])),
        {str(key): _number(value) for key, value in content["figures"].items()},
        {str(key): {"settings": dict(v["settings"]), "versions": dict(v["versions"])} for key, v in content["engines"].items()},
        tolerances={str(key): float(value) for key, value in content["tolerances"].items()},
    )


def _of_comparison(content: Mapping[str, Any], source: str) -> Findings:
    metrics = {f"metric.{key}": _number(metric["value"]) for key, metric in content["metrics"].items()}
    # JSON has no NaN: without this a value that is none and one that is no number would look alike.
    metrics |= {f"metric.{key}.finite": 0.0 for key, metric in content["metrics"].items() if not metric["finite"]}
    answers = {role: content[role] for role in ("reference", "result")}
    same = answers["reference"]["engine"] == answers["result"]["engine"]
    parts = [_of_answers({**answer, "scene": content["scene"]}, source, role if same else "") for role, answer in answers.items()]
    return Findings(
        source,
        parts[0].scene,
        metrics | {key: value for part in parts for key, value in part.figures.items()},
        {name: engine for part in parts for name, engine in part.engines.items()},
        tuple(sentence for part in parts for sentence in part.unfinished),
    )


def _of_answers(content: Mapping[str, Any], source: str, name: str = "") -> Findings:
    name = name or _slug(content["engine"])
    figures = {f"{name}.{key}": _number(content[key]) for key in (*OF_AN_ENGINE, *(key for key in OF_BULK if key in content))}
    figures |= {f"{name}.counts.{_slug(key)}": _number(content["counts"][key]) for key in COUNTS if key in content["counts"]}
    return Findings(
        source,
        Scene.model_validate(present_names(content["scene"])),
        figures,
        {name: {"settings": dict(content["settings"]), "versions": dict(content["versions"])}},
        () if content["converged"] else (f"{name}: {content['message']}",),
    )


def _number(value: Any) -> float | None:
    if value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    raise ValueError(f"{value!r} is not a number")


def _slug(text: str) -> str:
    """A key without blanks, which would have to be quoted on a command line.

    >>> _slug("contact iterations")
    'contact_iterations'
    """
    return re.sub(r"\W+", "_", text)


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


def _solution(path: Path, source: str | Path) -> ContactSolution:
    try:
        return ContactSolution.load(path)
    except (OSError, KeyError, ValueError, TypeError) as reason:
        raise InputError(f"{source}: this can't be read as a solution of halfplane: {first_line(reason)}") from reason


# -------------------------------------------------------------------------------------------------------------- differences
@dataclass(frozen=True)
class Row:
    """One figure of two findings.

    Attributes
    ----------
    key : of the figure
    a, b : its values; None for "no such thing"
    difference : B less A; None where there is nothing to subtract
    kind : "absolute", or "relative": over the larger of |A| and |B|
    tolerance : largest admitted |difference|
    verdict : same, differs, only in A, only in B
    """

    key: str
    a: float | None
    b: float | None
    difference: float | None
    kind: str
    tolerance: float
    verdict: str


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


def difference(a: Findings, b: Findings, tolerances: Mapping[str, float] | None = None) -> Difference:
    """How far the figures of `b` are from those of `a`.

    Parameters
    ----------
    a, b : of one scene
    tolerances : pattern of keys -> tolerance; before those kept with either, which come before the defaults

    Raises
    ------
    InputError
        For different scenes, no common engine, or a pattern that fits no key.
    """
    _refuse_other_scene(a, b)
    shared = _groups(a) & _groups(b)
    keys = [key for key in {**a.figures, **b.figures} if _group(key) in shared]
    if not keys:
        raise InputError(f"{a.source} and {b.source} have no figure in common: {_engines(a)} and {_engines(b)}")
    for pattern in tolerances or {}:
        if not any(fnmatchcase(key, pattern) for key in keys):
            raise InputError(f"--tolerance {pattern}: no figure is called so; there are {', '.join(keys)}")
    patterns = [*(tolerances or {}).items(), *b.tolerances.items(), *a.tolerances.items(), *DEFAULTS]
    rows = tuple(_row(key, a, b, next(value for pattern, value in patterns if fnmatchcase(key, pattern))) for key in keys)
    return Difference(a.source, b.source, a.scene.name or b.scene.name, rows, tuple(_notes(a, b)))


def tolerances_of(words: Sequence[str]) -> dict[str, float]:
    """What --tolerance KEY=VALUE says; InputError for anything else.

    >>> tolerances_of(["metric.*=1e-4"])
    {'metric.*': 0.0001}
    """
    found = {}
    for word in words:
        key, equals, text = word.rpartition("=")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (equals and key and value >= 0):
            raise InputError(f"--tolerance {word}: write KEY=VALUE, VALUE a number not below 0 (inf: not judged)")
        found[key] = value
    return found


def _refuse_other_scene(a: Findings, b: Findings) -> None:
    ours, theirs = physics(a.scene), physics(b.scene)
    apart = [key for key in {**ours, **theirs} if ours.get(key) != theirs.get(key)]
    if apart:
        named = "; ".join(f"{key} is {ours.get(key, 'absent')} and {theirs.get(key, 'absent')}" for key in apart[:6])
        more = f"; and {len(apart) - 6} more" if len(apart) > 6 else ""
        raise InputError(f"{a.source} and {b.source} answer different scenes: {named}{more}")


def _group(key: str) -> str:
    """What a figure belongs to: the comparison, or an engine."""
    return key.partition(".")[0]


def _groups(findings: Findings) -> set[str]:
    return {_group(key) for key in findings.figures}


def _engines(findings: Findings) -> str:
    return " and ".join(findings.engines) or "no engine"


def _row(key: str, a: Findings, b: Findings, tolerance: float) -> Row:
    first, second = a.figures.get(key), b.figures.get(key)
    kind = "absolute" if key.startswith("metric.") else "relative"
    if key not in a.figures or key not in b.figures:
        return Row(key, first, second, None, kind, tolerance, ONLY_A if key in a.figures else ONLY_B)
    if first is None or second is None:
        return Row(key, first, second, None, kind, tolerance, SAME if first is second else DIFFERS)
    size = 1.0 if kind == "absolute" else max(abs(first), abs(second), _floor(key, a))
    change = abs(second) - abs(first) if fnmatchcase(key, MIRRORED) else second - first
    apart = change / size if change else 0.0
    return Row(key, first, second, apart, kind, tolerance, SAME if verdict_on(apart, tolerance) is Verdict.WITHIN else DIFFERS)


def _floor(key: str, findings: Findings) -> float:
    """What a dissipation is at least taken relative to [energy / thickness]; 0 for all else."""
    engine, _, quantity = key.partition(".")
    if quantity not in ("dissipation", "loop_work", "bulk_work"):
        return 0.0
    load = (findings.figures[f"{engine}.largest_pressure"] or 0.0) * (findings.figures[f"{engine}.largest_half_width"] or 0.0)
    return NOTHING * energy_scale(findings.scene, load)


def _notes(a: Findings, b: Findings) -> Iterator[str]:
    """What is not compared, what moves figures without being one (settings, versions), engines that did not converge."""
    for letter, more, less in (("A", a, b), ("B", b, a)):
        for group in sorted(_groups(more) - _groups(less)):
            yield f"not compared, for it is only in {letter}: {group}.*"
    for engine in sorted(a.engines.keys() & b.engines.keys()):
        ours, theirs = flat(a.engines[engine]), flat(b.engines[engine])
        for key in {**ours, **theirs}:
            if ours.get(key) != theirs.get(key):
                yield f"{engine}: {key} is {ours.get(key, 'absent')} in A and {theirs.get(key, 'absent')} in B"
    for letter, findings in (("A", a), ("B", b)):
        yield from (f"{letter} did not converge: {sentence}" for sentence in findings.unfinished)


def is_baseline(path: Path) -> bool:
    """Whether a file says that it is a baseline, whole or spoilt."""
    if not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return "halfplane baseline " in file.read(200)
