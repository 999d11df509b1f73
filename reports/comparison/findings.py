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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from reports.comparison.laws import NAMES_OF_UNSYMMETRIC_VALUES, Verdict, verdict_on
from reports.comparison.pairs import energy_scale
from reports.folder import replace_text
from scenes import ContactSolution, InputError, Scene
from scenes.errors import first_line
from scenes.files import parsed_json, text_of
from scenes.scene import WORDS

# What this version writes, and the only version that it reads: files of version 1 are refused.
_FORMAT_OF_BASELINE = "halfplane baseline 2"
FORMAT_OF_SOLUTION = "halfplane solution 2"
_FORMAT = re.compile(r"halfplane (baseline|comparison|solution) ([1-9]\d*)")
_NEWEST_VERSION = 2
# The work that a change of the code moves; what the cache of condensed bodies spares would differ
# from one run to the next.
NAMES_OF_COUNTS = (
    "degrees of freedom",
    "contact nodes",
    "steps solved",
    "contact iterations",
    "linear solves",
    "factorisations",
    "slip quadratures",
    "quadrature nodes",
)
_KEYS_OF_SOLUTION = (
    "dissipation",
    "loop_work",
    "permanent_stick_half_width",
    "largest_half_width",
    "largest_pressure",
)
# The first pattern that fits a key counts. Values of other processors: docs/regression.md.
_DEFAULT_TOLERANCES: tuple[tuple[str, float], ...] = (
    # rounding decides whether an increment is halved, and the next ones follow
    ("*.counts.*", 0.05),
    ("metric.*", 1e-6),
    ("semi_analytic.*", 1e-9),
    ("*", 1e-6),
)
# Below this share of A f^2 P^2 a dissipation is the rounding of a sum whose truth is 0.
_LEAST_SHARE_OF_ENERGY = 1e-6
# Verdicts on a value of two runs.
SAME = "same"
DIFFERS = "differs"
ONLY_A = "only in A"
ONLY_B = "only in B"


@dataclass(frozen=True)
class ValuesOfRun:
    """The values of a run or of a baseline."""

    source: str  # folder or file that they were read from, as the user named it
    scene: Scene
    # key -> value; None for "no such thing" (a permanent stick zone, say). Discrepancies of a
    # comparison are "metric.<key>", values of an engine "<engine>.<quantity>" in the scene's
    # units, counts "<engine>.counts.<name>"
    values_by_key: Mapping[str, float | None]
    engines: Mapping[str, Mapping[str, Any]]  # engine -> {"settings": ..., "versions": ...}
    unfinished: tuple[str, ...] = ()  # sentences of engines that did not converge
    # pattern of keys -> largest admitted difference, kept with a baseline
    tolerances: Mapping[str, float] = field(default_factory=dict)


def read_run_values(source: str | Path) -> ValuesOfRun:
    """The values of a run, for comparison with another one: from a run folder, comparison.json,
    <engine>.json, a solution (.nc) or a baseline.

    Of a folder comparison.json is read; without it the solution of every engine (<engine>.json).

    Raises
    ------
    InputError
        Where `source` does not exist, or cannot be read as one of these.
    """
    path = Path(source)
    if not path.exists():
        raise InputError(f"{source}: there is no such file or folder")
    if path.suffix == ".nc" and not path.is_dir():
        try:
            return run_values_of_solution(ContactSolution.load(path), str(source))
        except (OSError, KeyError, ValueError, TypeError) as reason:
            raise InputError(
                f"{source}: this can't be read as a solution of halfplane: {first_line(reason)}"
            ) from reason
    file = path / "comparison.json" if path.is_dir() else path
    if file.exists():
        return run_values_of_content(_json_object(file, source), str(source))
    return _run_values_in_folder(path, source)


def _run_values_in_folder(folder: Path, source: str | Path) -> ValuesOfRun:
    """The values of every converged solution of an engine (*.json) in a run folder that holds no
    comparison. InputError where there is no solution, where none converged, where one is damaged,
    or where they answer different scenes. `source` is the folder as the user named it.

    The values are one mapping, with keys such as "semi_analytic.dissipation"; beside it stand
    settings and versions of the engines.
    """
    contents = [_json_object(file, file) for file in sorted(folder.glob("*.json"))]
    solutions = [
        content
        for content in contents
        if str(content.get("format")).startswith("halfplane solution ")
    ]
    if not solutions:
        raise InputError(
            f"{source}: this is no folder of a run: it holds no comparison.json and no answer of an"
            " engine"
        )
    values_of_engines = [
        run_values_of_content(content, str(source))
        for content in solutions
        if content.get("converged", True)  # a file without it is damaged, and refused as such
    ]
    if not values_of_engines:
        raise InputError(
            f"{source}: it holds only the steps before an engine failed:"
            f" {solutions[0].get('message')}"
        )
    # entries of the scenes that a solution depends on
    physical_contents = [_physical_content(run_values.scene) for run_values in values_of_engines]
    if any(content != physical_contents[0] for content in physical_contents):
        raise InputError(
            f"{source}: the engines in this folder answer different scenes; name the file of one of"
            " them"
        )
    values_by_key: dict[str, float | None] = {}
    engines: dict[str, Mapping[str, Any]] = {}
    for run_values in values_of_engines:
        values_by_key |= run_values.values_by_key
        engines |= run_values.engines
    return ValuesOfRun(str(source), values_of_engines[0].scene, values_by_key, engines)


def run_values_of_content(content: Mapping[str, Any], source: str) -> ValuesOfRun:
    """The values in the content of comparison.json, <engine>.json or a baseline. InputError, naming
    `source`, where "format" names another kind of file or another version, or an entry is absent or
    of the wrong kind.

    "format" is "halfplane KIND VERSION". Version 2 is read; 1 is that of halfplane 0.1.
    """
    format_name = content.get("format")
    # _FORMAT: pattern of "halfplane KIND VERSION"
    match = _FORMAT.fullmatch(format_name) if isinstance(format_name, str) else None
    if match is None:
        kinds = "baseline, comparison, solution"
        raise InputError(
            f"{source}: format is {format_name!r}; it is 'halfplane KIND {_NEWEST_VERSION}', KIND"
            f" one of {kinds}"
        )
    kind = match[1]  # baseline, comparison or solution
    version = int(match[2])
    if version > _NEWEST_VERSION:
        raise InputError(
            f"{source}: format is {format_name!r}, of a later version; update halfplane, or run the"
            " scene again"
        )
    if version < _NEWEST_VERSION:
        raise InputError(
            f"{source}: format is {format_name!r}, of version 0.1; convert it with halfplane 0.3,"
            " or run the scene again"
        )
    try:
        return _run_values_of_kind(kind, content, source)
    except (KeyError, TypeError, ValueError, AttributeError) as reason:
        if isinstance(reason, InputError):
            raise
        raise InputError(
            f"{source}: this says it is a {format_name}, but can't be read as one:"
            f" {first_line(reason)}"
        ) from reason


def _run_values_of_kind(kind: str, content: Mapping[str, Any], source: str) -> ValuesOfRun:
    """The values of a run in the content of a JSON file of this kind ("baseline", "comparison" or
    "solution"), with the engines that made them. A key of a value is "metric.dissipation" or
    "semi_analytic.counts.steps_solved", for example.

    Settings and versions are those of each engine. Sentences name the engines that did not
    converge. `source` is the file or folder as the user named it.

    An absent entry, or one of the wrong kind, raises KeyError, TypeError, ValueError or
    AttributeError.
    """
    scene = Scene.model_validate(content["scene"])
    if kind == "baseline":
        return _values_of_baseline(content, scene, source)
    # name of an engine, or its role ("reference", "result") -> content of its solution
    contents_by_name: dict[str, Mapping[str, Any]] = {}
    values_by_key: dict[str, float | None] = {}
    if kind == "comparison":
        values_by_key |= _values_of_metrics(content["metrics"])
        has_same_engine = content["reference"]["engine"] == content["result"]["engine"]
        for role in ("reference", "result"):
            name = role if has_same_engine else _key_without_blanks(content[role]["engine"])
            contents_by_name[name] = content[role]
    else:
        contents_by_name[_key_without_blanks(content["engine"])] = content
    engines: dict[str, Mapping[str, Any]] = {}
    failures: list[str] = []
    for name, content_of_solution in contents_by_name.items():
        values_by_key |= _values_of_solution(name, content_of_solution)
        engines[name] = _settings_and_versions(content_of_solution)
        if not content_of_solution["converged"]:
            failures.append(f"{name}: {content_of_solution['message']}")
    return ValuesOfRun(source, scene, values_by_key, engines, tuple(failures))


def _values_of_baseline(content: Mapping[str, Any], scene: Scene, source: str) -> ValuesOfRun:
    """The values in the content of a baseline, with the settings and versions of its engines and
    its tolerances: pattern of keys -> largest admitted difference.
    """
    values_by_key = {str(key): _number_or_none(value) for key, value in content["figures"].items()}
    tolerances = {str(key): float(value) for key, value in content["tolerances"].items()}
    engines = {str(key): _settings_and_versions(value) for key, value in content["engines"].items()}
    return ValuesOfRun(source, scene, values_by_key, engines, tolerances=tolerances)


def _values_of_metrics(metrics: Mapping[str, Any]) -> dict[str, float | None]:
    """The values of the metrics in comparison.json by keys such as "metric.dissipation". A value
    that is not finite has a second entry, "metric.dissipation.finite": JSON has no NaN, so that NaN
    and "no value" would look alike.
    """
    values_by_key: dict[str, float | None] = {}
    for key, metric in metrics.items():
        values_by_key[f"metric.{key}"] = _number_or_none(metric["value"])
        if not metric["finite"]:
            values_by_key[f"metric.{key}.finite"] = 0.0
    return values_by_key


def _values_of_solution(
    name: str, content_of_solution: Mapping[str, Any]
) -> dict[str, float | None]:
    """The values of one solution by keys that begin with `name`, that of its engine or its role:
    dissipation, largest pressure, ...; those of bulk stress and tilt where the file has them; and
    counts of the work, such as "steps solved", which only a change of the code can move.

    `content_of_solution` is the content of its JSON file.
    """
    keys = (
        *_KEYS_OF_SOLUTION,
        *(key for key in NAMES_OF_UNSYMMETRIC_VALUES if key in content_of_solution),
    )
    values_by_key = {f"{name}.{key}": _number_or_none(content_of_solution[key]) for key in keys}
    work_counts = content_of_solution["counts"]
    return values_by_key | {
        f"{name}.counts.{_key_without_blanks(key)}": _number_or_none(work_counts[key])
        for key in NAMES_OF_COUNTS
        if key in work_counts
    }


def run_values_of_solution(solution: ContactSolution, source: str) -> ValuesOfRun:
    """The values of one solution; `source` names it in messages."""
    from reports.comparison.json_values import solution_content, strict_json_values

    content = strict_json_values(solution_content(solution, ()))
    content["scene"] = solution.scene.model_dump(mode="json")
    return _run_values_of_kind("solution", content, source)


def write_baseline(run_values: ValuesOfRun, path: Path, tolerances: Mapping[str, float]) -> None:
    """Write the values of a run to `path` as a baseline that later runs are compared with. The file
    is written completely or not at all.

    Parameters
    ----------
    run_values
        `values_by_key` (key -> value), settings of the `engines`, `scene`, `source` (the name for
        messages), and `unfinished`: a sentence for each engine that did not converge
    tolerances
        pattern of keys -> largest admitted difference, stored in the baseline

    Raises
    ------
    InputError
        Where an engine did not converge, or `path` can't be written to.
    """
    if run_values.unfinished:
        reasons = "; ".join(run_values.unfinished)
        raise InputError(f"{run_values.source}: not converged, so no baseline: {reasons}")
    content = {
        "format": _FORMAT_OF_BASELINE,
        "scene": run_values.scene.model_dump(mode="json"),
        "engines": run_values.engines,
    }
    content |= {"tolerances": dict(tolerances), "figures": run_values.values_by_key}
    replace_text(path, json.dumps(content, allow_nan=False, indent=1, ensure_ascii=False) + "\n")


def is_baseline(path: Path) -> bool:
    """Whether a file names the format of a baseline near its start, even if it is damaged."""
    if not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return "halfplane baseline " in file.read(200)


def _json_object(path: Path, source: str | Path) -> dict[str, Any]:
    """The JSON object in a file; InputError for anything else."""
    try:
        content = parsed_json(text_of(path, "the file"))
    except InputError:
        raise
    except ValueError as reason:
        raise InputError(f"{source}: this can't be read as JSON: {first_line(reason)}") from reason
    if not isinstance(content, dict):
        raise InputError(f"{source}: this is JSON, but neither a run nor a baseline of halfplane")
    return content


def _settings_and_versions(content: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Settings and versions with which a solution was computed."""
    return {name: dict(content[name]) for name in ("settings", "versions")}


def _number_or_none(value: Any) -> float | None:
    """A number of JSON, or None; ValueError for anything else."""
    if value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    raise ValueError(f"{value!r} is not a number")


def _key_without_blanks(text: str) -> str:
    """A key without blanks, which would have to be quoted on a command line: each run of other
    characters becomes "_".
    """
    return re.sub(r"\W+", "_", text)


def _physical_content(scene: Scene) -> dict[str, Any]:
    """Every entry of a scene that its solution depends on, by its path in the scene file."""
    content = scene.model_dump(mode="json")
    return _with_dotted_names({key: value for key, value in content.items() if key not in WORDS})


def _with_dotted_names(value: Any, name: str = "") -> dict[str, Any]:
    """Flatten nested mappings and lists into one mapping: names are joined by dots, places in a
    list stand in brackets. Keys called "file" are left out. `name` is that of `value` itself, ""
    for the outermost.

    >>> _with_dotted_names({"load": {"cycle": [[1.0, 0.5]]}})
    {'load.cycle[0][0]': 1.0, 'load.cycle[0][1]': 0.5}
    """
    if isinstance(value, Mapping):
        # The rows of a file are part of `value`; the path of the file does not change a solution.
        entries = [
            (f"{name}.{key}" if name else str(key), entry)
            for key, entry in value.items()
            if key != "file"
        ]
    elif isinstance(value, list):
        entries = [(f"{name}[{index}]", entry) for index, entry in enumerate(value)]
    else:
        return {name: value}
    flat_values: dict[str, Any] = {}
    for entry_name, entry in entries:
        flat_values |= _with_dotted_names(entry, entry_name)
    return flat_values


# -------------------------------------------------------------------------------------- differences
@dataclass(frozen=True)
class ValueRow:
    """One value of two runs A and B."""

    key: str
    # a, b: the values of A and B; None for "no such thing"
    a: float | None
    b: float | None
    difference: float | None  # B minus A; None where one has no value
    kind: str  # "absolute", or "relative": over the larger of |A| and |B|
    tolerance: float  # largest admitted |difference|
    verdict: str  # same, differs, only in A, only in B


@dataclass(frozen=True)
class Difference:
    """Two runs A and B compared: the rows, and notes that a reader must not miss."""

    a: str  # folder or file of A
    b: str  # folder or file of B
    scene: str  # name of the scene
    rows: tuple[ValueRow, ...]
    notes: tuple[str, ...]

    @property
    def are_same(self) -> bool:
        """Whether the verdict of every row is "same"."""
        return all(row.verdict == SAME for row in self.rows)

    def content(self) -> dict[str, Any]:
        """The table as a mapping for JSON, where an infinite tolerance becomes null."""
        return {"same": self.are_same, **asdict(self)}


def difference_of_runs(
    a: ValuesOfRun, b: ValuesOfRun, tolerances: Mapping[str, float] | None = None
) -> Difference:
    """The differences of the values of a run `b` from those of a run `a`.

    There is a row for each value of an engine that both runs used, and of a comparison if both
    hold one. Notes name the other engines, and settings and versions that differ.

    Parameters
    ----------
    a, b
        two runs of one scene: `values_by_key` ("ENGINE.QUANTITY" or "metric.KEY" -> value),
        `engines`, `source` (name for messages), and the `tolerances` of a baseline
    tolerances
        pattern of keys, with wildcards -> tolerance. They have priority over those stored in a
        baseline, which have priority over the defaults (1e-9 to 0.05, by kind of value)

    Raises
    ------
    InputError
        For different scenes, no common engine, or a pattern that fits no key.
    """
    _refuse_different_scenes(a, b)
    # a group is an engine, or "metric" for the comparison: the first word of a key
    groups_of_a = set(map(_group_of_key, a.values_by_key))
    groups_of_b = set(map(_group_of_key, b.values_by_key))
    common_groups = groups_of_a & groups_of_b
    keys = [
        key for key in {**a.values_by_key, **b.values_by_key} if _group_of_key(key) in common_groups
    ]
    if not keys:
        engines_of_a = " and ".join(a.engines) or "no engine"
        engines_of_b = " and ".join(b.engines) or "no engine"
        raise InputError(
            f"{a.source} and {b.source} have no figure in common: {engines_of_a} and {engines_of_b}"
        )
    _refuse_unused_patterns(tolerances or {}, keys)
    rows = [
        _row_of_key(key, a, b, tolerance=_tolerance_of_key(key, a, b, tolerances or {}))
        for key in keys
    ]
    notes = []
    for letter, groups in (("A", groups_of_a), ("B", groups_of_b)):
        unmatched_groups = sorted(groups - common_groups)
        notes += [
            f"not compared, for it is only in {letter}: {group}.*" for group in unmatched_groups
        ]
    name = a.scene.name or b.scene.name
    return Difference(a.source, b.source, name, tuple(rows), (*notes, *_notes_on_runs(a, b)))


def _refuse_unused_patterns(patterns: Iterable[str], keys: Sequence[str]) -> None:
    """InputError for a pattern of --tolerance that fits none of the keys that are compared."""
    for pattern in patterns:
        if not any(fnmatchcase(key, pattern) for key in keys):
            raise InputError(
                f"--tolerance {pattern}: no figure is called so; there are {', '.join(keys)}"
            )


def _tolerance_of_key(
    key: str, a: ValuesOfRun, b: ValuesOfRun, tolerances: Mapping[str, float]
) -> float:
    """The tolerance of the value of that key. The first pattern that fits the key counts: of
    `tolerances`, then of those stored in the runs, if they are baselines, then of the defaults.

    `a` and `b` are the two runs.
    """
    # _DEFAULT_TOLERANCES: (pattern, tolerance), for values that no other pattern fits
    patterns_and_tolerances = (
        *tolerances.items(),
        *b.tolerances.items(),
        *a.tolerances.items(),
        *_DEFAULT_TOLERANCES,
    )
    return next(
        tolerance for pattern, tolerance in patterns_and_tolerances if fnmatchcase(key, pattern)
    )


def _group_of_key(key: str) -> str:
    """The first word of a key: "metric" for values of a comparison, else the engine."""
    return key.partition(".")[0]


def _refuse_different_scenes(a: ValuesOfRun, b: ValuesOfRun) -> None:
    """InputError where the scenes of two runs differ, with the first six keys that differ."""
    differences = _differing_keys(_physical_content(a.scene), _physical_content(b.scene))
    if not differences:
        return
    sentences = [f"{key} is {of_a} and {of_b}" for key, of_a, of_b in differences[:6]]
    if len(differences) > 6:
        sentences.append(f"and {len(differences) - 6} more")
    raise InputError(f"{a.source} and {b.source} answer different scenes: {'; '.join(sentences)}")


def _differing_keys(of_a: Mapping[str, Any], of_b: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """(key, value in A, value in B) for every key whose values are not the same."""
    pairs = [(key, of_a.get(key, "absent"), of_b.get(key, "absent")) for key in {**of_a, **of_b}]
    return [(key, value_a, value_b) for key, value_a, value_b in pairs if value_a != value_b]


def _notes_on_runs(a: ValuesOfRun, b: ValuesOfRun) -> Iterator[str]:
    """Sentences on settings and versions in which two runs `a` and `b` differ, and on engines that
    did not converge. `engines`: name -> its settings and versions; `unfinished`: a sentence for
    each engine that did not converge.
    """
    for engine in sorted(a.engines.keys() & b.engines.keys()):
        settings_of_a = _with_dotted_names(a.engines[engine])
        settings_of_b = _with_dotted_names(b.engines[engine])
        for key, value_in_a, value_in_b in _differing_keys(settings_of_a, settings_of_b):
            yield f"{engine}: {key} is {value_in_a} in A and {value_in_b} in B"
    for letter, run_values in (("A", a), ("B", b)):
        yield from (f"{letter} did not converge: {sentence}" for sentence in run_values.unfinished)


def patterned_tolerances(texts: Sequence[str]) -> dict[str, float]:
    """Pattern of keys -> tolerance, from the texts after --tolerance, KEY=VALUE each; InputError
    for anything else.

    >>> patterned_tolerances(["metric.*=1e-4"])
    {'metric.*': 0.0001}
    """
    tolerances = {}
    for text in texts:
        pattern, _, tolerance_as_text = text.rpartition("=")
        try:
            tolerance = float(tolerance_as_text)
        except ValueError:
            tolerance = math.nan
        if not (pattern and tolerance >= 0):
            raise InputError(
                f"--tolerance {text}: write KEY=VALUE, VALUE a number not below 0 (inf: not judged)"
            )
        tolerances[pattern] = tolerance
    return tolerances


def _row_of_key(key: str, a: ValuesOfRun, b: ValuesOfRun, tolerance: float) -> ValueRow:
    """Compare the value of one key in two runs `a` and `b`: both values, the difference b − a, and
    whether that is within the tolerance.

    The difference is divided by the larger of the two absolute values, of energies at least by a
    small share of a typical energy; a metric is relative already, and is not divided. A key that
    one run lacks has the verdict "only in A" or "only in B". Values that are None ("no such thing")
    in both are the same. `values_by_key` maps a key such as "metric.dissipation" to its value.
    """
    value_of_a = a.values_by_key.get(key)
    value_of_b = b.values_by_key.get(key)
    kind = "absolute" if key.startswith("metric.") else "relative"
    if key not in a.values_by_key or key not in b.values_by_key:
        verdict = ONLY_A if key in a.values_by_key else ONLY_B
        return ValueRow(key, value_of_a, value_of_b, None, kind, tolerance, verdict)
    if value_of_a is None or value_of_b is None:
        verdict = SAME if value_of_a is value_of_b else DIFFERS
        return ValueRow(key, value_of_a, value_of_b, None, kind, tolerance, verdict)
    scale = 1.0
    if kind == "relative":
        scale = max(abs(value_of_a), abs(value_of_b), _least_scale(key, a))
    change = value_of_b - value_of_a
    difference = change / scale if change else 0.0
    verdict = SAME if verdict_on(difference, tolerance) is Verdict.WITHIN else DIFFERS
    return ValueRow(key, value_of_a, value_of_b, difference, kind, tolerance, verdict)


def _least_scale(key: str, run_values: ValuesOfRun) -> float:
    """The smallest number that a difference is divided by: for energies 1e-6 of A f^2 P^2, P being
    largest pressure times largest half-width; 0 for other values, and where these two are unknown.
    A key is "ENGINE.QUANTITY".
    """
    engine, _, quantity = key.partition(".")
    if quantity not in ("dissipation", "loop_work", "bulk_work"):
        return 0.0
    pressure = run_values.values_by_key.get(f"{engine}.largest_pressure") or 0.0
    half_width = run_values.values_by_key.get(f"{engine}.largest_half_width") or 0.0
    return _LEAST_SHARE_OF_ENERGY * energy_scale(run_values.scene, pressure * half_width)
