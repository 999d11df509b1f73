"""`halfplane fields`: both bodies at chosen instants or over the last cycle, as files for ParaView
and pictures.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from reports.cli.application import EXIT_WITHIN, Answer, Options
from reports.cli.solving import (
    Job,
    load_engines,
    require_drawing,
    require_times,
    solve_finite_elements,
    solving_command,
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


def words_of_at(options: Options) -> tuple[str, ...]:
    """The words after --at; "events" where neither a series nor times are given."""
    if options.at or _has_series(options):
        return options.at
    return ("events",)


def _has_series(options: Options) -> bool:
    """Whether the options ask for a series of instants over the last cycle."""
    return options.every is not None or options.frames is not None


def _criteria(options: Options) -> Criteria | None:
    """The fatigue measures that the options ask for, with their constants; None where they ask for
    none.
    """
    from reports.field_output.fatigue import Criteria

    criteria = Criteria(options.fatemi_socie, options.findley, options.critical_distance)
    criteria.require_valid()
    return criteria if options.fatigue or criteria != Criteria() else None


@solving_command
def fields(job: Job) -> Answer:
    """The command `fields`: solve by finite elements, then write displacement, stress and tractions
    of both bodies to files for ParaView, with pictures and fatigue measures.

    A job has the scene, the options of the command line, the output folder, and the stages whose
    progress is shown. Options: `at` are instants, `every` and `frames` ask for a series of instants
    over the last cycle, `pictures` for drawings at the instants of `at`.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    from reports.field_output import files as field_files

    scene = job.scene
    stages = job.stages
    options = replace(job.options, at=words_of_at(job.options))
    job = replace(job, options=options)
    field_files.require_series(options.every, options.frames)  # InputError for values out of range
    criteria = _criteria(options)  # fatigue measures with their constants; None for none
    require_times(options.at, "--at", scene)
    if options.pictures and options.at:
        require_drawing(stages)
    load_engines(stages)
    # InputError, naming the command, for a solution without meshed bodies
    solution = field_files.with_bodies(solve_finite_elements(job), "fields")
    # which instants are written and drawn
    request = _request(job, solution, criteria)
    # content of fields.json; instants to draw, with displacement and stress of both bodies
    content, drawn_snapshots = _write_files(job, solution, request)
    # What was solved is saved before anything is drawn.
    if options.pictures and drawn_snapshots:
        content = _with_pictures(job, solution, content, drawn_snapshots)
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
    return Answer(EXIT_WITHIN, parts, lambda: json_answer, scene.name)


@dataclass(frozen=True)
class _Request:
    """What is to be written of a solution.

    Attributes
    ----------
    instants
        those whose fields are written, in the order of time
    times_drawn
        times of those of which pictures are drawn, given as --at
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
    """What the options of `fields` ask for: the instants of a series over the last cycle (--every,
    --frames) and those of --at, each once, in order of time; those of --at are drawn. `criteria`
    are the fatigue measures that the options ask for, or None.
    """
    from reports.field_output import files as field_files

    options = job.options
    instants_of_at_option = field_files.instants_of(options.at, solution, "--at")
    instants_of_series: Sequence[Instant] = ()
    notes: list[str] = []
    if _has_series(options):
        # notes: sentences on the choice of instants
        instants_of_series, notes = field_files.series_of(solution, options.every, options.frames)
    # an instant that is in both has the label that --at gives it
    instant_at_time = {instant.time: instant for instant in instants_of_series}
    instant_at_time |= {instant.time: instant for instant in instants_of_at_option}
    instants = [instant_at_time[time] for time in sorted(instant_at_time)]
    times_drawn = frozenset(instant.time for instant in instants_of_at_option)
    return _Request(instants, times_drawn, notes, criteria)


def _json_text(content: dict[str, Any]) -> str:
    """The text of fields.json."""
    from reports.comparison.json_values import strict_json_values

    return json.dumps(strict_json_values(content), allow_nan=False, indent=1) + "\n"


class _WrittenFields(NamedTuple):
    """What was written for ParaView, and what is needed of it afterwards."""

    file_names: list[str]  # in the job's folder
    values_of_instants: list[dict[str, Any]]  # values of each instant, for fields.json
    # each instant that pictures are drawn of, with displacement and stress of both bodies
    drawn_snapshots: list[tuple[Instant, Snapshot]]


def _write_files(
    job: Job, solution: FiniteElementSolution, request: _Request
) -> tuple[dict[str, Any], list[tuple[Instant, Snapshot]]]:
    """Write the fields at the requested instants as files for ParaView, a table of fatigue measures
    if the request has criteria, and fields.json.

    Returns the content of fields.json; and a pair for each instant that pictures are drawn of, with
    its snapshot: displacement and stress of both bodies at that instant.

    `request` holds the instants, the times of those to draw, notes on their choice, and criteria:
    fatigue measures with their constants, or None.
    """
    from reports.field_output import files as field_files
    from reports.folder import results_folder

    # a temporary folder, whose files move to the job's folder at the end; earlier files of these
    # names are removed
    with results_folder(job.folder, stale_prefixes=("fields/", "pictures/")) as staging:
        folder = staging / "fields"
        written = _write_bodies(job, solution, request, folder)
        file_names = written.file_names
        fatigue_content: dict[str, Any] = {}
        if request.criteria is not None:
            with job.stages.stage("measures of fatigue"):
                largest_measures = _write_fatigue(solution, request.criteria, folder)
            file_names.append("fields/fatigue.csv")
            fatigue_content = {"fatigue": largest_measures}
        content = field_files.record(
            solution,
            command=job.options.command("fields", job.source, job.folder),
            instants=written.values_of_instants,
            notes=request.notes,
            files=file_names,
            pictures=[],
            seconds=dict(job.stages.seconds),
            **fatigue_content,
        )
        (folder / "fields.json").write_text(_json_text(content), encoding="utf-8")
    return content, written.drawn_snapshots


def _write_bodies(
    job: Job, solution: FiniteElementSolution, request: _Request, folder: Path
) -> _WrittenFields:
    """Write the fields of both bodies and of the contact line at the requested instants to a
    folder, as files for ParaView; timed as a stage of the job.

    `request` holds the instants, and the times of those to draw.
    """
    from reports.field_output import files as field_files

    values_of_instants: list[dict[str, Any]] = []
    drawn_snapshots: list[tuple[Instant, Snapshot]] = []

    def noted_snapshots() -> Generator[Snapshot, None, None]:
        """The snapshots, one by one, as they are written: few fit into memory at once. The values
        that fields.json states of each are collected, and the snapshots to draw are kept.
        """
        snapshots = field_files.snapshots_of(solution, request.instants)
        for instant, snapshot in zip(request.instants, snapshots, strict=True):
            values_of_instants.append(field_files.stated(instant, snapshot))
            if instant.time in request.times_drawn:
                drawn_snapshots.append((instant, snapshot))
            yield snapshot

    with job.stages.stage("files for ParaView", "instants") as show_progress:
        vtu_names = field_files.write_fields(
            solution, noted_snapshots(), folder, show_progress, len(request.instants)
        )
    file_names = [f"fields/{name}" for name in vtu_names]
    return _WrittenFields(file_names, values_of_instants, drawn_snapshots)


def _write_fatigue(
    solution: FiniteElementSolution, criteria: Criteria, folder: Path
) -> list[dict[str, Any]]:
    """Write fatigue measures at places beside the contact, by both engines, to fatigue.csv in the
    folder. Returns the largest value of each measure in each body, with its place.
    """
    from reports.field_output import fatigue

    table_of_places = fatigue.survey(solution, criteria)
    table_of_places.to_csv(folder / "fatigue.csv", index=False, float_format="%.9g")
    return fatigue.largest(table_of_places)


def _with_pictures(
    job: Job,
    solution: FiniteElementSolution,
    content: dict[str, Any],
    snapshots: Sequence[tuple[Instant, Snapshot]],
) -> dict[str, Any]:
    """Draw pictures of the instants with their `snapshots` (displacement and stress of both
    bodies), and name them in fields.json. `content` is that of fields.json; returns the new one.
    """
    from reports.folder import replace_text, results_folder

    # a temporary folder, whose files move to the job's folder at the end
    with results_folder(job.folder, stale_prefixes=("pictures/",)) as staging:
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
    """What the terminal shows of field output: a row for each instant with its largest nodal von
    Mises stress (of many instants the one with the largest), notes, fatigue measures, what was
    written.

    Parameters
    ----------
    instants
        values of each instant, as in fields.json: time, loads, largest nodal stresses, tension
    files
        names of the files that were written
    measures
        as in fields.json: an entry for each fatigue measure and body with its largest value by
        both engines; empty where none was requested
    pvd_file
        path of the collection that ParaView opens
    """
    yield from _instants_shown(scene, instants)
    yield from notes
    n_vtu_files = sum(name.endswith(".vtu") for name in files)
    n_pictures = sum(name.endswith(".svg") for name in files)
    yield (
        f"written: {n_vtu_files} VTU files, {n_pictures} pictures, and what they are in"
        " fields/fields.json"
    )
    if measures:
        yield from _measures_shown(scene, measures)
    yield pvd_file


def _instants_shown(scene: Scene, instants: Sequence[dict[str, Any]]) -> Iterator[Part]:
    """What the terminal shows of the instants whose fields were written: a table with loads and
    stresses of each, of more than 12 instants the one with the largest stress; and lines that
    explain it. `instants` are the values of each as in fields.json.
    """
    from reports.field_output.files import NO_PEAK
    from reports.units import load_unit, units

    _, unit_of_length, unit_of_stress = units(scene)
    unit_of_load = load_unit(scene)
    instants_listed = instants
    if len(instants) > _ROWS:
        instants_listed = [max(instants, key=_largest_stress)]
    heads = (
        "instant",
        "time",
        f"P [{unit_of_load}]",
        f"Q [{unit_of_load}]",
        f"nodal von Mises [{unit_of_stress}]",
        f"tension at the edge [{unit_of_stress}]",
    )
    rows = [_row_of_instant(instant) for instant in instants_listed]
    # Sheet: title, heads, rows, and the columns that are flush right
    yield Sheet(scene.title or scene.name, heads, rows, (1, 2, 3))
    yield (
        f"places x, y in {unit_of_length}, on the undeformed bodies; tension: the largest stress"
        " along a face at an edge of contact"
    )
    yield NO_PEAK  # a sentence: stresses are values at nodes
    if len(instants_listed) < len(instants):
        yield (
            f"shown: of {len(instants)} instants the one with the largest stress; all are in"
            " fields/fields.json"
        )


def _measures_shown(scene: Scene, measures: Sequence[dict[str, Any]]) -> Iterator[Part]:
    """What the terminal shows of fatigue measures: a table with the largest value of each in each
    body by both engines, and a line that explains it. `measures` are these values as in
    fields.json.
    """
    from reports.units import units

    _, unit_of_length, unit_of_stress = units(scene)
    heads = (
        "largest through the last cycle",
        "theory",
        "finite elements",
        "difference",
        f"at (x, y) [{unit_of_length}]",
    )
    rows = _largest_measures(measures, unit_of_stress)
    # Sheet: title, heads, rows, and the columns that are flush right
    yield Sheet("Measures of fatigue", heads, rows, (1, 2, 3))
    yield (
        "linear elastic stress of contact and bulk stress, planes that contain z; places beside"
        " the contact: fatigue.csv"
    )


def _largest_measures(
    measures: Sequence[dict[str, Any]], unit_of_stress: str
) -> list[tuple[str, ...]]:
    """Rows of a table of fatigue measures: name and unit, largest value by theory, largest value by
    finite elements (FE), their difference FE/theory - 1, and the place of the value by FE.

    `measures` holds an entry for each measure and body, with the value and its place x, y by both
    engines. Of the two bodies the row states that with the larger value by FE.
    """
    from reports.units import minus

    rows: list[tuple[str, ...]] = []
    for name in dict.fromkeys(entry["measure"] for entry in measures):
        entries_of_bodies = [entry for entry in measures if entry["measure"] == name]
        largest_entry = max(entries_of_bodies, key=lambda entry: entry["finite_elements"]["value"])
        value_of_theory = largest_entry["theory"]["value"]
        value_of_elements = largest_entry["finite_elements"]["value"]
        unit = "–" if name == "Fatemi-Socie" else unit_of_stress  # a strain
        difference = "–"
        if value_of_theory:
            difference = f"{100 * (value_of_elements / value_of_theory - 1):+.2f} %"
        place_in_words = f"{_place(largest_entry['finite_elements'])}, {largest_entry['body']}"
        # `minus`: with a real minus sign
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


def _place(value_with_place: dict[str, Any]) -> str:
    """The place x, y of a value, in words."""
    return f"({_rounded(value_with_place['x'])}, {_rounded(value_with_place['y'])})"


def _largest_stress(instant: dict[str, Any]) -> float:
    """Largest nodal von Mises stress at an instant [stress]."""
    return float(instant["largest_nodal_von_mises"]["value"])


def _row_of_instant(instant: dict[str, Any]) -> tuple[str, ...]:
    """Cells of a row on an instant: label, time, P, Q, largest nodal von Mises stress, and tension
    at the edge of contact, both with their places. `instant` holds its values as in fields.json.
    """
    from reports.comparison.words import with_uncertainty
    from reports.units import number

    peak = instant["largest_nodal_von_mises"]
    # `number`: as text, to six digits
    peak_in_words = f"{number(peak['value'])} at {_place(peak)}, {peak['body']}"
    tension = instant["tension_at_edge"]
    tension_in_words = "–"
    if tension is not None:
        amount = with_uncertainty(tension["value"], tension["uncertainty"])
        tension_in_words = f"{amount} at {_rounded(tension['x'])}, {tension['body']}"
    time_and_loads = [number(instant[key]) for key in ("time", "normal_load", "tangential_load")]
    return (instant["label"], *time_and_loads, peak_in_words, tension_in_words)


def _rounded(place: float) -> str:
    """A coordinate to three significant digits."""
    from reports.units import number

    return number(float(f"{place:.3g}"))


def _draw(
    solution: FiniteElementSolution,
    instants_and_snapshots: Sequence[tuple[Instant, Snapshot]],
    folder: Path,
    stages: Stages,
) -> list[str]:
    """Draw the mesh, and the von Mises stress at each instant, as SVG files in the new `folder`.
    Returns the names of the files below the folder of the run. A snapshot is displacement and
    stress of both bodies at its instant. `stages` shows the progress.
    """
    with stages.stage("pictures", "pictures") as show_progress:
        import numpy as np

        from reports.comparison.pairs import scales_of_reference
        from reports.field_output import pictures as drawing

        folder.mkdir()
        contact_edge = float(np.nanmax(solution.contact_edges))  # outermost of all instants
        half_width = scales_of_reference(solution).half_width  # at the reference load
        figure = drawing.mesh(solution.bodies, half_width, contact_edge, with_boundaries=True)
        names = [_write_picture(figure, folder)]
        # all figures have the same scales of stress and displacement
        scales_of_figures = drawing.scales_of([snapshot for _, snapshot in instants_and_snapshots])
        n_figures = 1 + len(instants_and_snapshots)
        for picture_number, (instant, snapshot) in enumerate(instants_and_snapshots):
            show_progress(picture_number + 1, n_figures, f"time {snapshot.time:.6g}")
            name = f"von_mises_{picture_number:03d}"
            figure = drawing.stress(
                solution, [snapshot], [instant], scales_of_figures, name, pixels=1000
            )
            names.append(_write_picture(figure, folder))
    return names


def _write_picture(figure: Plate, folder: Path) -> str:
    """Write a figure as an SVG file; returns its name below the folder of the run."""
    (folder / f"{figure.name}.svg").write_text(figure.svg(), encoding="utf-8")
    return f"pictures/{figure.name}.svg"
