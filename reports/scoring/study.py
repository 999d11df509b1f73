"""`halfplane score FOLDER`: one result on several meshes, the order at which each discrepancy
falls, what no mesh removes.

# notation: h element size at the contact, E discrepancy of the finest mesh, E_0 extrapolated to h =
0; E - E_0 is the mesh's part
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from reports.comparison import Comparison
from reports.comparison.budget import Extrapolation, Refinement, extrapolate
from reports.comparison.metrics import Metric
from reports.comparison.words import term_in_words
from reports.scoring.field_files import collected_files
from reports.scoring.mapping import Mapping
from reports.scoring.reading import READER_BY_SUFFIX, SOLUTION_SUFFIX
from scenes import InputError

# "h=0.05", "h0.05", "mesh_0.025mm", "size-0.1": a figure after such a word in the name of a file.
_SIZE_IN_NAME = re.compile(
    r"(?:^|[_\-. ])(?:h|size|mesh|element|el|le)[_\-= ]?(\d+(?:\.\d+)?(?:e-?\d+)?)", re.IGNORECASE
)
# Ratio of element sizes below which two files are of the same mesh.
_LEAST_SIZE_RATIO = 1.02
_RELATIVE_ROUND_OFF = 1e-12


@dataclass(frozen=True)
class UnscoredFile:
    """A file of a folder of results that could not be scored.

    Attributes
    ----------
    name
        of the file, as it lies in the folder
    reason
        why, naming the file
    """

    name: str
    reason: str

    @property
    def sentence(self) -> str:
        """The sentence for a reader."""
        return f"Not scored: {self.reason}."


@dataclass(frozen=True, eq=False)
class Level:
    """A result on one mesh of a study.

    Attributes
    ----------
    name
        of the file
    size
        of the elements at the contact [length]
    source_of_size
        where it is from, in words
    comparison
        of the result with the reference
    """

    name: str
    size: float
    source_of_size: str
    comparison: Comparison


@dataclass(frozen=True, eq=False)
class StudyRow:
    """One metric over the meshes of a study.

    Attributes
    ----------
    metric
        as it is on the finest mesh
    values
        on each mesh, the finest first, at the instant at which the finest is worst; a mesh with
        other instants has its own worst value
    extrapolation
        order, kind, and value at element size zero with its uncertainty
    """

    metric: Metric
    values: tuple[float, ...]
    extrapolation: Extrapolation

    @property
    def error_of_finest_mesh(self) -> float | None:
        """Value on the finest mesh minus the one at size zero; None where no value was
        extrapolated.
        """
        limit = self.extrapolation.value
        if limit is None or self.extrapolation.kind in ("oscillating", "diverging"):
            return None
        return self.values[0] - float(limit)


@dataclass(frozen=True, eq=False)
class MeshStudy:
    """The meshes, the finest first, and every metric that has a value on all of them."""

    levels: tuple[Level, ...]
    metric_rows: tuple[StudyRow, ...]
    notes: tuple[str, ...] = ()

    def row_of_metric(self, key: str) -> StudyRow:
        """The row of a metric; KeyError for one that has none."""
        return {row.metric.key: row for row in self.metric_rows}[key]

    @property
    def heads(self) -> tuple[str, ...]:
        """Heads of the table."""
        sizes = (f"h = {level.size:.4g}" for level in self.levels)
        return ("metric", *sizes, "order", "at h = 0", "± u", "the mesh's part")

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Cells of the table: a row for each metric that is a headline."""
        return [_cells_of_row(row) for row in self.metric_rows if row.metric.headline]

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences below the table of a mesh study: the element size h of each mesh and where it
        is from, what the limit at h = 0, with its uncertainty u, does not cover, and the notes of
        the study.
        """
        sizes = ", ".join(
            f"{level.name}: {level.size:.4g} ({level.source_of_size})" for level in self.levels
        )
        return (
            f"Element sizes at the contact, in the scene's length: {sizes}.",
            (
                "What is left at h = 0 is no error of the mesh: instants too far apart, a penalty"
                " in the contact law, the size of the bodies, or the idealisation itself; files say"
                " nothing of which. u covers it about 19 times of 20."
            ),
            *self.notes,
        )

    def content(self) -> dict[str, Any]:
        """A mesh study for JSON: the meshes with their element sizes, and of each metric the
        values, order, limit at size zero and uncertainty.
        """
        return {
            "levels": [
                {"name": level.name, "element_size": level.size, "from": level.source_of_size}
                for level in self.levels
            ],
            "metrics": {
                row.metric.key: {
                    "values": row.values,
                    # order of convergence, how the values change with size, limit, and the rule
                    # in words
                    "order": row.extrapolation.order,
                    "kind": row.extrapolation.kind,
                    "at_zero": row.extrapolation.value,
                    "uncertainty": row.extrapolation.uncertainty,
                    "mesh": row.error_of_finest_mesh,
                    "rule": row.extrapolation.rule,
                }
                for row in self.metric_rows
            },
            "notes": self.notes,
        }


def study_of_levels(levels: Sequence[Level], notes: Sequence[str] = ()) -> MeshStudy:
    """A mesh study: the order of convergence and the limit at element size zero of each metric that
    has a value on all meshes, from results of one problem on meshes of different size.

    Two meshes show no order: second order is assumed, and a note says so.

    Parameters
    ----------
    levels
        for each mesh the name of the file, the element size h at the contact, where h is from in
        words, and the comparison of the result with the reference; unsorted
    notes
        sentences that come first in the notes of the study

    Raises
    ------
    InputError
        For fewer than two meshes, or two whose sizes are within 2 % of each other.
    """
    levels_by_size = tuple(sorted(levels, key=lambda level: level.size))
    if len(levels_by_size) < 2:
        raise InputError(
            "a mesh study takes two meshes at least; name the file itself to score one"
        )
    for fine_level, coarse_level in itertools.pairwise(levels_by_size):
        if coarse_level.size < _LEAST_SIZE_RATIO * fine_level.size:
            raise InputError(
                f"{fine_level.name} and {coarse_level.name} have the same element size,"
                f" {fine_level.size:.4g} and {coarse_level.size:.4g}"
                f" ({fine_level.source_of_size}): state sizes under [element_sizes] of a mapping,"
                " or leave one out"
            )
    # a row for each metric: its value on each mesh, the finest first, and the limit at h = 0
    rows = (
        _row_of_metric(metric, levels_by_size) for metric in levels_by_size[0].comparison.metrics
    )
    all_notes = list(notes)
    if len(levels_by_size) == 2:
        all_notes.append(
            "Two meshes show no order: second order is assumed, with three times the uncertainty."
        )
    known_rows = tuple(row for row in rows if row is not None)
    return MeshStudy(levels_by_size, known_rows, tuple(all_notes))


def _row_of_metric(metric: Metric, levels: Sequence[Level]) -> StudyRow | None:
    """One metric of a comparison over the meshes of a study (`levels`, the finest first), with its
    extrapolation to element size zero. None where a mesh has no value.

    Its values are those at the instant at which the finest mesh has its worst value. A mesh with
    other instants has the value at its own worst instant.
    """
    values = []
    times_of_finest = levels[0].comparison.result_cycle.time
    for level in levels:
        metric_of_level = level.comparison.metric(metric.key)
        time = level.comparison.result_cycle.time
        has_same_times = len(time) == len(times_of_finest) and np.allclose(time, times_of_finest)
        value = metric_of_level.value
        # values at each instant, None for a metric of the whole cycle; metric.time: time of the
        # worst one
        series = metric_of_level.series
        if series is not None and metric.time is not None and has_same_times:
            value = series[int(np.argmin(np.abs(times_of_finest - metric.time)))]
        if value is None or not math.isfinite(value):
            return None
        values.append(float(value))
    # Refinement: sizes of the elements, values on these meshes, difference of equal values
    refinement = Refinement(
        tuple(level.size for level in levels), tuple(values), rounding=_RELATIVE_ROUND_OFF
    )
    # extrapolate: order of convergence, limit at size zero and its uncertainty
    return StudyRow(metric, tuple(values), extrapolate(refinement))


def _cells_of_row(row: StudyRow) -> tuple[str, ...]:
    """The cells of one row of the table of a mesh study: metric, value of each mesh, order of
    convergence, limit at element size zero, its uncertainty, error of the finest mesh; – where
    there is none.
    """
    extrapolation = row.extrapolation
    is_signed = row.metric.signed

    def cell_of(value: float | None, has_plus: bool = is_signed) -> str:
        """A value in the unit of the metric, with a plus sign if `has_plus`; – for None."""
        return "–" if value is None else term_in_words(value, row.metric, plus=has_plus, digits=3)

    # where no order was observed: how the values change, such as "oscillating"
    order_cell = (
        f"{extrapolation.order:.2f}" if extrapolation.order is not None else extrapolation.kind
    )
    limit = None if row.error_of_finest_mesh is None else extrapolation.value
    return (
        row.metric.label,
        *map(cell_of, row.values),
        order_cell,
        cell_of(limit),
        cell_of(extrapolation.uncertainty, has_plus=False),
        cell_of(row.error_of_finest_mesh),
    )


def element_size(path: Path, mapping: Mapping, comparison: Comparison) -> tuple[float, str]:
    """Element size of a result's mesh at the contact [length] and where it is from, in words: the
    mapping (`element_sizes`, by file name), the file's name, or the median spacing of the points in
    contact. InputError where fewer than two points touch.
    """
    if path.name in mapping.element_sizes:
        return mapping.element_sizes[path.name], "from the mapping"
    # such as "mesh_0.025mm" or "h=0.05"
    if size_in_name := _SIZE_IN_NAME.search(path.stem):
        return float(size_in_name[1]), "from the file's name"
    x = comparison.result.x
    largest_edge = float(np.nanmax(np.abs(comparison.result_cycle.contact_edges)))
    points_in_contact = x[np.abs(x) <= largest_edge]
    if len(points_in_contact) < 2:
        raise InputError(
            f"{path}: fewer than two points touch: state its element size under [element_sizes] of"
            " a mapping"
        )
    return float(np.median(np.diff(points_in_contact))), "median spacing of the points in contact"


def result_files(folder: Path) -> tuple[tuple[Path, ...], tuple[str, ...]]:
    """Result files in a folder that a reader takes, one for each stem (the first suffix in the
    order of the readers); and notes on what was left out. Files that a collection (.pvd) names are
    read through it.

    Raises
    ------
    InputError
        Where there is none, or a collection can't be read.
    """
    known_suffixes = [*READER_BY_SUFFIX, SOLUTION_SUFFIX]
    files = sorted(
        path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")
    )
    # files that a .pvd collection names
    paths_in_collections = {part.resolve() for path in files for part in collected_files(path)}
    uncollected_files = [path for path in files if path.resolve() not in paths_in_collections]

    readable_files = [path for path in uncollected_files if path.suffix.lower() in known_suffixes]
    # of files with one stem the last one counts: that whose suffix comes first among the known ones
    file_by_stem = {
        path.stem: path
        for path in sorted(readable_files, key=lambda p: -known_suffixes.index(p.suffix.lower()))
    }
    names_left_out = [path.name for path in uncollected_files if path not in file_by_stem.values()]
    if not file_by_stem:
        raise InputError(
            f"{folder}: no result is in this folder; a result ends in {', '.join(known_suffixes)}"
        )
    notes = [f"Left out of the folder: {', '.join(names_left_out)}."] if names_left_out else []
    if len(uncollected_files) < len(files):
        n_collected = len(files) - len(uncollected_files)
        notes.append(f"Read through the collections that name them: {n_collected} files.")
    return tuple(sorted(file_by_stem.values())), tuple(notes)
