"""What `halfplane score` does once its options are read: read, score, write, show, and choose the exit code."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from reports import jobs
from reports.application import NOT_CONVERGED, WITHIN
from reports.console import Stages, complain, say, show_table
from reports.folder import claim, default_folder
from reports.score.mapping import load_mapping
from reports.tables import exit_code, show_metrics
from scenes import ConvergenceError, InputError, Scene

if TYPE_CHECKING:
    from reports.comparison import Comparison
    from reports.score.mapping import Mapping
    from reports.score.scoring import Against


def score(
    result: str | None,
    source: str | None,
    mapping_file: Path | None,
    against: Against,
    out: Path | None,
    *,
    quiet: bool = False,
    as_json: bool = False,
    example: bool = False,
) -> int:
    """A file, or each file of a folder, against the reference."""
    if example:
        say((resources.files("reports") / "templates" / "mapping.toml").read_text("utf-8").rstrip())
        return WITHIN
    if result is None:
        raise InputError("score: name the result to score, a file or a folder of files")
    if source is None:
        raise InputError(f"{result}: --scene is missing: name the scene that it answers; `halfplane scenes` lists the library")
    path, stages = Path(result), Stages(quiet)
    scene, mapping = jobs.read(source), load_mapping(mapping_file)
    if not path.exists():
        raise InputError(f"{result}: there is no such file or folder")
    folder = claim(out or default_folder(f"score-{path.resolve().stem}"))
    more = [*(["--mapping", str(mapping_file)] if mapping_file else []), *(["--against", against] if against != "exact" else [])]
    command = shlex.join(["halfplane", "score", result, "--scene", source, *more, "--out", str(folder)])
    try:
        comparison = _scored(path, scene, mapping, against, stages)
    except ConvergenceError as failure:
        complain(f"halfplane: {scene.name}: the reference is not converged: {failure}")
        return NOT_CONVERGED
    with stages.stage("report"):
        from reports.writing import write

        page = write(comparison, folder, command=command, seconds=dict(stages.seconds))
    if as_json:
        from reports.summary import as_json as content

        say(content(comparison, command, stages.seconds))
    else:
        show(comparison)
        say(str(page))
    return exit_code(comparison)


def _scored(path: Path, scene: Scene, mapping: Mapping, against: Against, stages: Stages) -> Comparison:
    """The comparison of a file, or of the finest mesh of a folder, with its diagnoses."""
    if path.is_dir():
        with stages.stage("loading"):
            from reports.score.study_files import score_folder
        return score_folder(path, mapping, scene, stages, against=against)
    with stages.stage("loading"):
        from reports.score.scoring import diagnosed, score_file
    with stages.stage("reading and scoring"):
        comparison = score_file(path, mapping, scene, against=against)
    with stages.stage("diagnosis"):
        return diagnosed(comparison)


def show(comparison: Comparison) -> None:
    """Guesses, verdict, diagnoses, and the mesh study where it is one."""
    from reports.wording import how_judged, lead, verdict

    for sentence in comparison.guesses:
        say(f"Taken for granted: {sentence}.")
    scene = comparison.scene
    there = [metric for metric in comparison.headlines if metric.value is not None]
    show_metrics(f"{comparison.result.engine} on {scene.title or scene.name}", there)
    for sentence in _lacking(comparison):
        say(sentence)
    say(f"{lead(comparison)} {verdict(comparison)}")
    say(how_judged(comparison))
    if comparison.diagnoses:
        say("What it most likely suffers from:")
    for number, one in enumerate(comparison.diagnoses, 1):
        say(f"{number}. {one.sentence}")
        for evidence in one.evidence:
            say(f"   - {evidence}")
    if comparison.study is not None:
        heads = comparison.study.heads
        show_table("Mesh study", heads, comparison.study.rows, right=range(1, len(heads)))
        for sentence in comparison.study.sentences:
            say(sentence)


def _lacking(comparison: Comparison) -> Iterable[str]:
    """Headlines without a value, those with one reason in one line."""
    reasons: dict[str, list[str]] = {}
    for metric in comparison.headlines:
        if metric.value is None and metric.note:
            reasons.setdefault(metric.note, []).append(metric.label)
    return [f"Not scored: {', '.join(labels)} ({reason})." for reason, labels in reasons.items()]
