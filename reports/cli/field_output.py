"""`halfplane fields`: both bodies at chosen instants or over the last cycle, as files for ParaView
and pictures.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import WITHIN, Answer, Options
from reports.cli.solving import (
    Job,
    at_work,
    load_engines,
    require_drawing,
    require_times,
    solve_finite_elements,
)
from reports.console import Part, Sheet, Stages

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution, Snapshot
    from reports.charts.plate import Plate
    from reports.field_output.fatigue import Criteria
    from reports.field_output.files import Instant
    from scenes import Scene

# A series of more instants than this is shown by the one with the largest stress.
_ROWS = 12


def named(options: Options) -> tuple[str, ...]:
    """Words of --at; the events where neither a series nor times are given."""
    return options.at or (() if _series(options) else ("events",))


def _series(options: Options) -> bool:
    """Whether files for ParaView are wanted over the whole cycle."""
    return options.every is not None or options.frames is not None


def _criteria(options: Options) -> Criteria | None:
    """The fatigue measures that the options ask for, with their constants; None where they ask for
    none.
    """
    from reports.field_output.fatigue import Criteria

    criteria = Criteria(options.fatemi_socie, options.findley, options.critical_distance)
    criteria.require_valid()
    return criteria if options.fatigue or criteria != Criteria() else None


@at_work
def fields(job: Job) -> Answer:
    """The command `fields`: solve by finite elements, then write displacement, stress and tractions
    of both bodies to files, with pictures and fatigue measures on request.
    """
    from reports.field_output import files

    scene = job.scene
    stages = job.stages
    options = replace(job.options, at=named(job.options))
    job = replace(job, options=options)
    files.require_series(options.every, options.frames)
    criteria = _criteria(options)
    require_times(options.at, "--at", scene)
    if options.pictures and options.at:
        require_drawing(stages)
    load_engines(stages)
    solution = files.with_bodies(solve_finite_elements(job), "fields")
    request = _request(job, solution, criteria)
    content, snapshots_drawn = _write_files(job, solution, request)
    # What was solved is saved before anything is drawn.
    if options.pictures and snapshots_drawn:
        content = _with_pictures(job, solution, content, snapshots_drawn)
    names_of_files = ["fields/fields.json", *content["files"], *content["pictures"]]
    collection = str(job.folder / "fields" / "fields.pvd")
    measures = content.get("fatigue", ())
    copied_keys = ["instants", "largest nodal stresses", "notes"]
    if criteria is not None:
        copied_keys.append("fatigue")
    json_answer = {
        **{key: content[key] for key in copied_keys},
        "passed": True,
        "files": names_of_files,
        "file": collection,
        "seconds": stages.seconds,
    }
    parts = _parts(scene, content["instants"], names_of_files, request.notes, measures, collection)
    return Answer(WITHIN, parts, lambda: json_answer, scene.name)


@dataclass(frozen=True)
class _Request:
    """What is to be written of a solution.

    Attributes
    ----------
    instants
        those whose fields are written, in the order of time
    times_drawn
        times of those of which pictures are drawn, named by --at
    notes
        sentences on the choice of instants
    criteria
        fatigue measures with their constants; None for none
    """

    instants: Sequence[Instant]
    times_drawn: frozenset[float]
    notes: list[str]
    criteria: Criteria | None


def _request(job: Job, solution: FiniteElementSolution, criteria: Criteria | None) -> _Request:
    """What the options of `fields` ask for: instants over the last cycle (--every, --frames) and
    those named by --at, each once.
    """
    from reports.field_output import files

    options = job.options
    named_instants = files.instants_of(options.at, solution, "--at")
    series: Sequence[Instant] = ()
    notes: list[str] = []
    if _series(options):
        series, notes = files.series_of(solution, options.every, options.frames)
    # one that is in the series too has the label that --at gives it
    instant_by_time = {instant.time: instant for instant in (*series, *named_instants)}
    instants = [instant_by_time[time] for time in sorted(instant_by_time)]
    times_drawn = frozenset(instant.time for instant in named_instants)
    return _Request(instants, times_drawn, notes, criteria)


def _json_text(content: dict[str, Any]) -> str:
    """The text of fields.json."""
    from reports.comparison.json_values import strict

    return json.dumps(strict(content), allow_nan=False, indent=1) + "\n"


def _write_files(
    job: Job, solution: FiniteElementSolution, request: _Request
) -> tuple[dict[str, Any], list[tuple[Instant, Snapshot]]]:
    """Write the fields at the requested instants as files for ParaView, a table of fatigue measures
    if there are any, and fields.json.

    Returns the content of fields.json, and each instant that pictures are drawn of, with
    displacement and stress of both bodies there.
    """
    from reports.field_output import fatigue, files
    from reports.folder import filled

    stages = job.stages
    stated_values: list[dict[str, Any]] = []
    snapshots_drawn: list[tuple[Instant, Snapshot]] = []

    def noted_snapshots() -> Generator[Snapshot, None, None]:
        """Displacement and stress at each instant, one by one, as they are written. Values that
        are stated of each are collected, and those that are drawn are kept.
        """
        snapshots = files.snapshots_of(solution, request.instants)
        for instant, snapshot in zip(request.instants, snapshots, strict=True):
            stated_values.append(files.stated(instant, snapshot))
            if instant.time in request.times_drawn:
                snapshots_drawn.append((instant, snapshot))
            yield snapshot

    with filled(job.folder, fresh=("fields/", "pictures/")) as staging:
        folder = staging / "fields"
        with stages.stage("files for ParaView", "instants") as report:
            names = files.write_fields(
                solution, noted_snapshots(), folder, report, len(request.instants)
            )
        written_names = [f"fields/{name}" for name in names]
        measures: dict[str, Any] = {}
        if request.criteria is not None:
            with stages.stage("measures of fatigue"):
                places = fatigue.survey(solution, request.criteria)
            places.to_csv(folder / "fatigue.csv", index=False, float_format="%.9g")
            written_names.append("fields/fatigue.csv")
            measures = {"fatigue": fatigue.largest(places)}
        content = files.record(
            solution,
            command=job.options.command("fields", job.source, job.folder),
            instants=stated_values,
            notes=request.notes,
            files=written_names,
            pictures=[],
            seconds=dict(stages.seconds),
            **measures,
        )
        (folder / "fields.json").write_text(_json_text(content), encoding="utf-8")
    return content, snapshots_drawn


def _with_pictures(
    job: Job,
    solution: FiniteElementSolution,
    content: dict[str, Any],
    snapshots: Sequence[tuple[Instant, Snapshot]],
) -> dict[str, Any]:
    """Draw pictures of the instants with their `snapshots`, and name them in fields.json; returns
    its new content.
    """
    from reports.folder import filled, replace_text

    with filled(job.folder, fresh=("pictures/",)) as staging:
        pictures = _draw(solution, snapshots, staging / "pictures", job.stages)
    content = content | {"pictures": pictures, "seconds": dict(job.stages.seconds)}
    replace_text(job.folder / "fields" / "fields.json", _json_text(content))
    return content


def _parts(
    scene: Scene,
    instants: Sequence[dict[str, Any]],
    files: Sequence[str],
    notes: Sequence[str],
    measures: Sequence[dict[str, Any]],
    pvd_file: str,
) -> Iterator[Part]:
    """What the terminal shows of field output: a row for each instant with its largest nodal stress
    (of many instants the worst alone), notes, fatigue measures, what was written.

    Parameters
    ----------
    instants
        stated values of each instant, as in fields.json
    files
        names of the files that were written
    measures
        largest value of each fatigue measure in each body; empty without any
    pvd_file
        path of the collection that ParaView opens
    """
    from reports.field_output.files import NO_PEAK
    from reports.units import load_unit, units

    _, unit_of_length, unit_of_stress = units(scene)
    unit_of_load = load_unit(scene)
    instants_listed = instants
    if len(instants) > _ROWS:
        instants_listed = [max(instants, key=lambda row: row["largest_nodal_von_mises"]["value"])]
    rows_of_instants = [_row_of_instant(instant) for instant in instants_listed]
    heads_of_instants = (
        "instant",
        "time",
        f"P [{unit_of_load}]",
        f"Q [{unit_of_load}]",
        f"nodal von Mises [{unit_of_stress}]",
        f"tension at the edge [{unit_of_stress}]",
    )
    yield Sheet(scene.title or scene.name, heads_of_instants, rows_of_instants, (1, 2, 3))
    yield (
        f"places x, y in {unit_of_length}, on the undeformed bodies; tension: the largest stress"
        " along a face at an edge of contact"
    )
    yield NO_PEAK
    if len(instants_listed) < len(instants):
        yield (
            f"shown: of {len(instants)} instants the one with the largest stress; all are in"
            " fields/fields.json"
        )
    yield from notes
    n_vtu_files = sum(name.endswith(".vtu") for name in files)
    n_pictures = sum(name.endswith(".svg") for name in files)
    yield (
        f"written: {n_vtu_files} VTU files, {n_pictures} pictures, and what they are in"
        " fields/fields.json"
    )
    if measures:
        heads_of_measures = (
            "largest through the last cycle",
            "theory",
            "finite elements",
            "difference",
            f"at (x, y) [{unit_of_length}]",
        )
        rows_of_measures = _largest_measures(measures, unit_of_stress)
        yield Sheet("Measures of fatigue", heads_of_measures, rows_of_measures, (1, 2, 3))
        yield (
            "linear elastic stress of contact and bulk stress, planes that contain z; places beside"
            " the contact: fatigue.csv"
        )
    yield pvd_file


def _largest_measures(
    measures: Sequence[dict[str, Any]], unit_of_stress: str
) -> list[tuple[str, ...]]:
    """Rows of a table of fatigue measures: name, largest value by theory, largest value by finite
    elements, their difference, and its place. Each measure is that of the body in which it is
    larger by finite elements.

    `measures` holds the largest values of each measure in each body.
    """
    from reports.units import minus

    rows: list[tuple[str, ...]] = []
    for name in dict.fromkeys(row["measure"] for row in measures):
        rows_of_measure = [row for row in measures if row["measure"] == name]
        largest_row = max(rows_of_measure, key=lambda row: row["finite_elements"]["value"])
        value_of_theory = largest_row["theory"]["value"]
        value_of_elements = largest_row["finite_elements"]["value"]
        unit = "–" if name == "Fatemi-Socie" else unit_of_stress
        difference = (
            f"{100 * (value_of_elements / value_of_theory - 1):+.2f} %" if value_of_theory else "–"
        )
        place_in_words = f"{_place(largest_row['finite_elements'])}, {largest_row['body']}"
        rows.append(
            (
                f"{name} [{unit}]",
                f"{value_of_theory:.4g}",
                f"{value_of_elements:.4g}",
                minus(difference),
                place_in_words,
            )
        )
    return rows


def _place(value_at: dict[str, Any]) -> str:
    """The place x, y of a value, in words."""
    return f"({_rounded(value_at['x'])}, {_rounded(value_at['y'])})"


def _row_of_instant(instant: dict[str, Any]) -> tuple[str, ...]:
    """Cells of a written instant: label, time, P, Q, largest nodal stress and tension at the edge
    of contact, both with their places.
    """
    from reports.comparison.words import with_uncertainty
    from reports.units import number

    peak = instant["largest_nodal_von_mises"]
    peak_in_words = f"{number(peak['value'])} at {_place(peak)}, {peak['body']}"
    tension = instant["tension_at_edge"]
    tension_in_words = "–"
    if tension is not None:
        amount = with_uncertainty(tension["value"], tension["uncertainty"])
        tension_in_words = f"{amount} at {_rounded(tension['x'])}, {tension['body']}"
    time_and_loads = [number(instant[key]) for key in ("time", "normal_load", "tangential_load")]
    return (instant["label"], *time_and_loads, peak_in_words, tension_in_words)


def _rounded(place: float) -> str:
    from reports.units import number

    return number(float(f"{place:.3g}"))


def _draw(
    solution: FiniteElementSolution,
    stills: Sequence[tuple[Instant, Snapshot]],
    folder: Path,
    stages: Stages,
) -> list[str]:
    """Draw the mesh, and the von Mises stress of each snapshot, as SVG files in the new `folder`;
    returns the names of the files. `stills` are the instants with their fields.
    """
    with stages.stage("pictures", "pictures") as report:
        import numpy as np

        from reports.comparison.dimensionless import scales as reference_scales
        from reports.field_output.pictures import mesh, scales_of, stress

        folder.mkdir()
        contact_edge = float(np.nanmax(solution.contact_edges))
        half_width = reference_scales(solution).half_width
        picture_of_mesh = mesh(solution.bodies, half_width, contact_edge, named=True)
        names = [_write_picture(picture_of_mesh, folder)]
        scales = scales_of([snapshot for _, snapshot in stills])
        for number, (instant, snapshot) in enumerate(stills):
            report(number + 1, len(stills) + 1, f"time {snapshot.time:.6g}")
            plate = stress(solution, [snapshot], [instant], scales, f"von_mises_{number:03d}", 1000)
            names.append(_write_picture(plate, folder))
    return names


def _write_picture(plate: Plate, folder: Path) -> str:
    """Write a figure as SVG that stands alone; returns its name below the folder of the run."""
    (folder / f"{plate.name}.svg").write_text(plate.svg(), encoding="utf-8")
    return f"pictures/{plate.name}.svg"
