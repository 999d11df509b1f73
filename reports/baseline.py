"""What a run found, as named figures: read from its folder or one of its files, kept as a baseline. JSON, no pickle."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from reports.staging import made, remove_left_behind, replace_file
from scenes import ContactSolution, InputError, Scene
from scenes.errors import present_names
from scenes.files import parsed_json, text_of
from scenes.scene import WORDS

BASELINE, COMPARISON, SOLUTION = "halfplane baseline 1", "halfplane comparison 1", "halfplane solution 1"
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
OF_AN_ENGINE = ("dissipation", "loop_work", "permanent_stick_half_width", "largest_half_width", "largest_pressure")


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


def read(source: str | Path) -> Findings:
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
    """The findings in what comparison.json (of this format or the one before), <engine>.json or a baseline hold."""
    from reports.comparison.content import FORMAT

    readers = {BASELINE: _of_baseline, COMPARISON: _of_comparison, FORMAT: _of_comparison, SOLUTION: _of_answers}
    kind = content.get("format")
    if kind not in readers:
        raise InputError(f"{source}: format is {kind!r}; it is one of {', '.join(map(repr, readers))}")
    try:
        return readers[kind](content, source)
    except (KeyError, TypeError, ValueError, AttributeError) as reason:
        if isinstance(reason, InputError):
            raise
        raise InputError(f"{source}: this says it is a {kind}, but can't be read as one: {_first_line(reason)}") from reason


def of_solution(solution: ContactSolution, source: str) -> Findings:
    """The findings of one answer."""
    from reports.summary import solution_content, strict

    content = strict(solution_content(solution, ()))
    return _of_answers({**content, "scene": solution.scene.model_dump(mode="json")}, source)


def write(findings: Findings, path: Path, tolerances: Mapping[str, float]) -> None:
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


def replace_text(path: Path, text: str) -> None:
    """Write a file in one go: a reader sees the old one or the new one; InputError where that is not possible."""
    try:
        remove_left_behind(path.parent)
        with made(path.parent):
            replace_file(path, text.encode())
    except OSError as reason:
        raise InputError(f"{path}: the file can't be written: {reason.strerror or reason}; name another place") from reason


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
    answers = [content for path in sorted(folder.glob("*.json")) if (content := _json(path, path)).get("format") == SOLUTION]
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
    figures = {f"{name}.{key}": _number(content[key]) for key in OF_AN_ENGINE}
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
        raise InputError(f"{source}: this can't be read as JSON: {_first_line(reason)}") from reason
    if not isinstance(content, dict):
        raise InputError(f"{source}: this is JSON, but neither a run nor a baseline of halfplane")
    return content


def _solution(path: Path, source: str | Path) -> ContactSolution:
    try:
        return ContactSolution.load(path)
    except (OSError, KeyError, ValueError, TypeError) as reason:
        raise InputError(f"{source}: this can't be read as a solution of halfplane: {_first_line(reason)}") from reason


def _first_line(reason: Exception) -> str:
    return str(reason).splitlines()[0] if str(reason) else type(reason).__name__
