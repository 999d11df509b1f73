"""`halfplane fields`: both bodies at chosen instants or over the last cycle, as files for ParaView
and pictures.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
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
    from reports.comparison.json_values import strict
    from reports.field_output import fatigue, files
    from reports.folder import filled, replace_text

    scene = job.scene
    stages = job.stages
    options = replace(job.options, at=named(job.options))
    files.require_series(options.every, options.frames)
    criteria = _criteria(options)
    require_times(options.at, "--at", scene)
    if options.pictures and options.at:
        require_drawing(stages)
    load_engines(stages)
    solution = files.with_bodies(solve_finite_elements(job), "fields")
    chosen_instants = files.instants_of(options.at, solution, "--at")
    series: Sequence[Instant] = ()
    notes: list[str] = []
    if _series(options):
        series, notes = files.series_of(solution, options.every, options.frames)
    instant_by_time = {instant.time: instant for instant in (*series, *chosen_instants)}
    instants = [instant_by_time[time] for time in sorted(instant_by_time)]
    stated_values: list[dict[str, Any]] = []
    snapshots_drawn: list[tuple[Instant, Snapshot]] = []

    def as_json(content: dict[str, Any]) -> str:
        return json.dumps(strict(content), allow_nan=False, indent=1) + "\n"

    def noted_snapshots() -> Generator[Snapshot, None, None]:
        """The snapshots one by one, as they are written: the values stated of each are collected,
        and those of the instants named by --at are kept for pictures.
        """
        times_of_stills = {instant.time for instant in chosen_instants}
        for instant, snapshot in zip(instants, files.snapshots_of(solution, instants), strict=True):
            stated_values.append(files.stated(instant, snapshot))
            if instant.time in times_of_stills:
                snapshots_drawn.append((instant, snapshot))
            yield snapshot

    with filled(job.folder, fresh=("fields/", "pictures/")) as staging:
        with stages.stage("files for ParaView", "instants") as report:
            names = files.write_fields(
                solution, noted_snapshots(), staging / "fields", report, len(instants)
            )
        written_names = [f"fields/{name}" for name in names]
        measures: dict[str, Any] = {}
        if criteria is not None:
            with stages.stage("measures of fatigue"):
                places = fatigue.survey(solution, criteria)
            places.to_csv(staging / "fields" / "fatigue.csv", index=False, float_format="%.9g")
            written_names.append("fields/fatigue.csv")
            measures = {"fatigue": fatigue.largest(places)}
        content = files.record(
            solution,
            command=options.command("fields", job.source, job.folder),
            instants=stated_values,
            notes=notes,
            files=written_names,
            pictures=[],
            seconds=dict(stages.seconds),
            **measures,
        )
        (staging / "fields" / "fields.json").write_text(as_json(content), encoding="utf-8")
    # What was solved is saved before anything is drawn.
    pictures: list[str] = []
    if options.pictures and snapshots_drawn:
        with filled(job.folder, fresh=("pictures/",)) as staging:
            pictures = _draw(solution, snapshots_drawn, staging / "pictures", stages)
        content |= {"pictures": pictures, "seconds": dict(stages.seconds)}
        replace_text(job.folder / "fields" / "fields.json", as_json(content))
    names_of_files = ["fields/fields.json", *written_names, *pictures]
    pvd = str(job.folder / "fields" / "fields.pvd")
    copied_keys = ("instants", "largest nodal stresses", "notes", *measures)
    json_answer = {
        **{key: content[key] for key in copied_keys},
        "passed": True,
        "files": names_of_files,
        "file": pvd,
        "seconds": stages.seconds,
    }
    parts = _parts(scene, stated_values, names_of_files, notes, measures.get("fatigue", ()), pvd)
    return Answer(WITHIN, parts, lambda: json_answer, scene.name)


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
