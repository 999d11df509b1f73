"""A folder of results, one a mesh: the report of the finest with the study over all of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

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
    levels = []
    reports = []
    errors: dict[str, InputError] = {}
    for path in files:
        with stages.stage(path.name):
            try:
                report = score_file(path, mapping, scene, against=against, tolerances=tolerances)
                # a mesh of the study: name, size of its elements and where that is from,
                # comparison
                level = Level(
                    path.name, *element_size(path, mapping, report.comparison), report.comparison
                )
            except InputError as fault:
                errors[path.name] = fault
                continue
            reports.append(report)
            levels.append(level)
    if not levels:
        further_faults = ""
        if len(errors) > 1:
            further_faults = (
                f" ({len(errors) - 1} other files of the folder can't be scored either)"
            )
        raise InputError(f"{next(iter(errors.values()))}{further_faults}")
    unscored_files = tuple(
        UnscoredFile(name, str(fault).replace(str(folder / name), name))
        for name, fault in errors.items()
    )
    notes = (*notes_on_files, *(file.sentence for file in unscored_files))
    if errors and len(levels) == 1:  # a result, and no study
        (report,) = reports
        comparison_with_notes = replace(report.comparison, notes=(*notes, *report.comparison.notes))
        with stages.stage("diagnosis"):
            return report_with_diagnoses(
                replace(report, comparison=comparison_with_notes, unscored=unscored_files)
            )
    mesh_study = study_of_levels(levels, notes)
    with stages.stage("diagnosis"):
        comparison_of_finest = mesh_study.levels[0].comparison
        finest_report = next(
            report for report in reports if report.comparison is comparison_of_finest
        )
        return report_with_diagnoses(
            replace(finest_report, study=mesh_study, unscored=unscored_files)
        )
