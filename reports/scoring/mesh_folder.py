"""A folder of results, one a mesh: the report of the finest with the study over all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from reports.console import Stages
from reports.report import Report
from reports.scoring.against import Against, report_with_diagnoses, score_file
from reports.scoring.mapping import Mapping
from reports.scoring.study import Level, UnscoredFile, element_size, result_files, study_of_levels
from scenes import InputError, Scene


def score_folder(
    folder: Path,
    mapping: Mapping,
    scene: Scene,
    stages: Stages,
    *,
    against: Against = "exact",
    tolerances: dict[str, float] | None = None,
) -> Report:
    """Score all files of a folder as results of one problem on different meshes. Returns the report
    of the finest mesh, with a study of how each metric converges over all meshes. Files that can't
    be scored are named in its notes. Where only one of several files can be scored, the report is
    of that one, without a study.

    `against` is the reference: "exact" for half-plane theory, "fe" for finite elements. `mapping`
    states columns, units and signs of the files. `stages` shows progress by named stages;
    `tolerances` replace those of the scene, by key of a metric.

    Raises
    ------
    InputError
        Where no file can be scored, with the reason for the first; where the folder holds a single
        result; where two are of one mesh.
    """
    # files of the folder that may be results, and notes on those left out
    files, notes_on_files = result_files(folder)
    scored_files = []
    errors: dict[str, InputError] = {}
    for path in files:
        with stages.stage(path.name):
            try:
                report_of_file = score_file(
                    path, mapping, scene, against=against, tolerances=tolerances
                )
                scored_files.append(_scored_file(path, mapping, report_of_file))
            except InputError as fault:
                errors[path.name] = fault
    if not scored_files:
        raise _error_of_all_files(errors)
    unscored_files = tuple(
        UnscoredFile(name, str(fault).replace(str(folder / name), name))
        for name, fault in errors.items()
    )
    notes = (*notes_on_files, *(file.sentence for file in unscored_files))
    if errors and len(scored_files) == 1:  # a result, and no study
        report = _report_with_notes(scored_files[0].report, notes)
    else:
        report = _report_with_study(scored_files, notes)
    with stages.stage("diagnosis"):
        return report_with_diagnoses(replace(report, unscored=unscored_files))


class _ScoredFile(NamedTuple):
    """The report on one file of a folder, and its mesh in the study of all files."""

    report: Report
    level: Level


def _scored_file(path: Path, mapping: Mapping, report: Report) -> _ScoredFile:
    """The `report` on the file at `path` with its mesh: the file's name, the size of the elements
    and where that is from, and the comparison. InputError where fewer than two points touch.
    """
    size_and_source = element_size(path, mapping, report.comparison)
    return _ScoredFile(report, Level(path.name, *size_and_source, report.comparison))


def _error_of_all_files(errors: dict[str, InputError]) -> InputError:
    """The error to raise where no file of a folder can be scored: that of the first one, and how
    many others there are. `errors` are by the name of the file, at least one.
    """
    further_faults = ""
    if len(errors) > 1:
        further_faults = f" ({len(errors) - 1} other files of the folder can't be scored either)"
    return InputError(f"{next(iter(errors.values()))}{further_faults}")


def _report_with_notes(report: Report, notes: tuple[str, ...]) -> Report:
    """The report with further notes, before those of its comparison."""
    comparison = replace(report.comparison, notes=(*notes, *report.comparison.notes))
    return replace(report, comparison=comparison)


def _report_with_study(scored_files: Sequence[_ScoredFile], notes: tuple[str, ...]) -> Report:
    """The report of the finest mesh, with the study of how each metric converges over all meshes.
    `notes` on the files of the folder go into the study.
    """
    mesh_study = study_of_levels([scored_file.level for scored_file in scored_files], notes)
    comparison_of_finest = mesh_study.levels[0].comparison
    finest_report = next(
        scored_file.report
        for scored_file in scored_files
        if scored_file.report.comparison is comparison_of_finest
    )
    return replace(finest_report, study=mesh_study)
