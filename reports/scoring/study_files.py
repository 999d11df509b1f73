"""`halfplane score FOLDER`: every result in a folder as one mesh of a study."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from meshes import collected_files
from reports.comparison import Report
from reports.console import Stages
from reports.scoring.against import OWN, Against, diagnosed, score_file
from reports.scoring.mapping import Mapping
from reports.scoring.reading import READERS
from reports.scoring.study import Level, element_size, study
from scenes import InputError, Scene

_WORDS = re.compile(r"[^\s,;]+")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?|[-+]?(?:nan|inf)", re.IGNORECASE)


@dataclass(frozen=True)
class Found:
    """The results of a folder, and what in it was left out, in sentences."""

    files: tuple[Path, ...]
    notes: tuple[str, ...]


def results_in(folder: Path) -> Found:
    """The files that a reader takes, one for each stem (the first suffix in the order of the readers).

    What a collection names is read through it, and a .txt without a table is no result.

    Raises
    ------
    InputError
        Where there is none, or a collection can't be read.
    """
    known = [*READERS, OWN]
    files = sorted(path for path in folder.iterdir() if path.is_file() and not path.name.startswith("."))
    parts = {part.resolve() for path in files for part in collected_files(path)}
    alone = [path for path in files if path.resolve() not in parts]
    results = [path for path in alone if path.suffix.lower() in known and (path.suffix.lower() != ".txt" or _has_table(path))]
    taken: dict[str, Path] = {}
    for path in sorted(results, key=lambda p: known.index(p.suffix.lower())):
        taken.setdefault(path.stem, path)
    left = [path.name for path in alone if path not in taken.values()]
    if not taken:
        raise InputError(f"{folder}: no result is in this folder; a result ends in {', '.join(known)}")
    notes = [f"Left out of the folder: {', '.join(left)}."] if left else []
    if len(alone) < len(files):
        notes.append(f"Read through the collections that name them: {len(files) - len(alone)} files.")
    return Found(tuple(sorted(taken.values())), tuple(notes))


def _has_table(path: Path) -> bool:
    """Whether some line of a text holds three numbers and nothing else: a place and two tractions."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    return any(len(words) > 2 and all(map(_NUMBER.fullmatch, words)) for words in map(_WORDS.findall, lines))


def score_folder(
    folder: Path,
    mapping: Mapping,
    scene: Scene,
    stages: Stages,
    *,
    against: Against = "exact",
    tolerances: dict[str, float] | None = None,
) -> Report:
    """The report of the finest mesh, with the study over all of them."""
    found, levels, reports = results_in(folder), [], []
    for path in found.files:
        with stages.stage(path.name):
            report = score_file(path, mapping, scene, against=against, tolerances=tolerances)
            reports.append(report)
            levels.append(Level(path.name, *element_size(path, mapping, report.comparison), report.comparison))
    known = study(levels, found.notes)
    with stages.stage("diagnosis"):
        finest = next(report for report in reports if report.comparison is known.levels[0].comparison)
        return diagnosed(replace(finest, study=known))
