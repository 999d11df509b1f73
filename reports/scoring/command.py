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
from reports.scoring.mapping import load_mapping
from reports.tables import exit_code, show_verdict
from scenes import ConvergenceError, InputError, Scene

if TYPE_CHECKING:
    from reports.comparison import Comparison, Report
    from reports.scoring.against import Against
    from reports.scoring.mapping import Mapping


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
        report = _scored(path, scene, mapping, against, stages)
    except ConvergenceError as failure:
        complain(f"halfplane: {scene.name}: the reference is not converged: {failure}")
        return NOT_CONVERGED
    with stages.stage("report"):
        from reports.page.writing import write

        page = write(report, folder, command=command, seconds=dict(stages.seconds))
    if as_json:
        from reports.comparison.content import as_json as content

        say(content(report, command, stages.seconds))
    else:
        show(report)
        say(str(page))
    return exit_code(report.comparison)


def _scored(path: Path, scene: Scene, mapping: Mapping, against: Against, stages: Stages) -> Report:
    """The report of a file, or of the finest mesh of a folder, with its diagnoses."""
    if path.is_dir():
        with stages.stage("loading"):
            from reports.scoring.study_files import score_folder
        return score_folder(path, mapping, scene, stages, against=against)
    with stages.stage("loading"):
        from reports.scoring.against import diagnosed, score_file
    with stages.stage("reading and scoring"):
        report = score_file(path, mapping, scene, against=against)
    with stages.stage("diagnosis"):
        return diagnosed(report)


def show(report: Report) -> None:
    """Guesses, verdict, diagnoses, and the mesh study where it is one."""
    for sentence in report.guesses:
        say(f"Taken for granted: {sentence}.")
    show_verdict(report)
    for sentence in _lacking(report.comparison):
        say(sentence)
    if report.diagnoses:
        say("Likely faults of the result:")
    for number, one in enumerate(report.diagnoses, 1):
        say(f"{number}. {one.sentence}")
        for evidence in one.evidence:
            say(f"   - {evidence}")
    if report.study is not None:
        show_table("Mesh study", report.study.heads, report.study.rows, right=range(1, len(report.study.heads)))
        for sentence in report.study.sentences:
            say(sentence)


def _lacking(comparison: Comparison) -> Iterable[str]:
    """Headlines without a value, those with one reason in one line."""
    reasons: dict[str, list[str]] = {}
    for metric in comparison.headlines:
        if metric.value is None and metric.note:
            reasons.setdefault(metric.note, []).append(metric.label)
    return [f"Not scored: {', '.join(labels)} ({reason})." for reason, labels in reasons.items()]
