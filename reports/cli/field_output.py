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
    """What --fatigue needs; None where nothing of it is asked for."""
    from reports.field_output.fatigue import Criteria

    given = Criteria(options.fatemi_socie, options.findley, options.critical_distance)
    given.require_valid()
    return given if options.fatigue or given != Criteria() else None


@at_work
def fields(job: Job) -> Answer:
    """Finite elements, and displacement, stress and tractions of both bodies on disk."""
    from reports.comparison.json_values import strict
    from reports.field_output import fatigue, files
    from reports.folder import filled

    scene, stages, options = job.scene, job.stages, job.options
    files.require_series(options.every, options.frames)
    criteria, options = _criteria(options), replace(options, at=named(options))
    require_times(options.at, "--at", scene)
    if options.pictures and options.at:
        require_drawing(stages)
    load_engines(stages)
    solution = files.with_bodies(solve_finite_elements(job), "fields")
    chosen = files.instants_of(options.at, solution, "--at")
    series, notes = (
        files.series_of(solution, options.every, options.frames) if _series(options) else ((), [])
    )
    instants = sorted(
        {one.time: one for one in (*series, *chosen)}.values(), key=lambda one: one.time
    )
    rows: list[dict[str, Any]] = []
    stills: list[tuple[Instant, Snapshot]] = []

    def passing() -> Generator[Snapshot, None, None]:
        """Snapshots on their way to disk: what is stated of each is noted, those of named instants
        are kept for stills.
        """
        wanted = {one.time for one in chosen}
        for instant, snapshot in zip(instants, files.snapshots_of(solution, instants), strict=True):
            rows.append(files.stated(instant, snapshot))
            if instant.time in wanted:
                stills.append((instant, snapshot))
            yield snapshot

    with filled(job.folder, fresh=("fields/", "pictures/")) as staging:
        with stages.stage("files for ParaView", "instants") as report:
            names = files.write_fields(
                solution, passing(), staging / "fields", report, len(instants)
            )
        written = [f"fields/{name}" for name in names]
        drawn = (
            _draw(solution, stills, staging / "pictures", stages)
            if options.pictures and stills
            else []
        )
        measured = {}
        if criteria is not None:
            with stages.stage("measures of fatigue"):
                places = fatigue.survey(solution, criteria)
            places.to_csv(staging / "fields" / "fatigue.csv", index=False, float_format="%.9g")
            written.append("fields/fatigue.csv")
            measured = {"fatigue": fatigue.largest(places)}
        content = files.record(
            solution,
            command=options.command("fields", job.source, job.folder),
            instants=rows,
            notes=notes,
            files=written,
            pictures=drawn,
            seconds=dict(stages.seconds),
            **measured,
        )
        text = json.dumps(strict(content), allow_nan=False, indent=1)
        (staging / "fields" / "fields.json").write_text(text + "\n", encoding="utf-8")
    whole, file = (
        ["fields/fields.json", *written, *drawn],
        str(job.folder / "fields" / "fields.pvd"),
    )
    more = {"passed": True, "files": whole, "file": file, "seconds": stages.seconds}
    result = {
        key: content[key] for key in ("instants", "largest nodal stresses", "notes", *measured)
    } | more
    return Answer(
        WITHIN,
        _shown(scene, rows, whole, notes, measured.get("fatigue", ()), file),
        lambda: result,
        scene.name,
    )


def _shown(
    scene: Scene,
    instants: Sequence[dict[str, Any]],
    files: Sequence[str],
    notes: Sequence[str],
    measures: Sequence[dict[str, Any]],
    file: str,
) -> Iterator[Part]:
    """The instants with their largest nodal stress, the largest of all where they are many, and
    what was written.
    """
    from reports.comparison.words import with_uncertainty
    from reports.field_output.files import NO_PEAK
    from reports.units import load_unit, minus, number, units

    _, length, stress = units(scene)
    load, many, rows = load_unit(scene), len(instants) > _ROWS, []
    for one in (
        [max(instants, key=lambda one: one["largest_nodal_von_mises"]["value"])]
        if many
        else instants
    ):
        peak, edge = one["largest_nodal_von_mises"], one["tension_at_edge"]
        nodal, at_edge = f"{number(peak['value'])} at {_place(peak)}, {peak['body']}", "–"
        if edge is not None:
            at_edge = (
                f"{with_uncertainty(edge['value'], edge['uncertainty'])} at {_rounded(edge['x'])},"
                f" {edge['body']}"
            )
        rows.append(
            (
                one["label"],
                *(number(one[key]) for key in ("time", "normal_load", "tangential_load")),
                nodal,
                at_edge,
            )
        )
    heads = (
        "instant",
        "time",
        f"P [{load}]",
        f"Q [{load}]",
        f"nodal von Mises [{stress}]",
        f"tension at the edge [{stress}]",
    )
    yield Sheet(scene.title or scene.name, heads, rows, (1, 2, 3))
    yield (
        f"places x, y in {length}, on the undeformed bodies; tension: the largest stress along a"
        " face at an edge of contact"
    )
    yield NO_PEAK
    if many:
        yield (
            f"shown: of {len(instants)} instants the one with the largest stress; all are in"
            " fields/fields.json"
        )
    yield from notes
    counts = {kind: sum(name.endswith(kind) for name in files) for kind in (".vtu", ".svg")}
    yield (
        f"written: {counts['.vtu']} VTU files, {counts['.svg']} pictures, and what they are in"
        " fields/fields.json"
    )
    if measures:
        # The largest value of each measure by both engines, in the body in which finite elements
        # have it.
        found = []
        for words in dict.fromkeys(row["measure"] for row in measures):
            most = max(
                (row for row in measures if row["measure"] == words),
                key=lambda row: row["finite_elements"]["value"],
            )
            theory, elements = most["theory"]["value"], most["finite_elements"]["value"]
            unit = "–" if words == "Fatemi-Socie" else stress
            apart = f"{100 * (elements / theory - 1):+.2f} %" if theory else "–"
            place = f"{_place(most['finite_elements'])}, {most['body']}"
            found.append(
                (f"{words} [{unit}]", f"{theory:.4g}", f"{elements:.4g}", minus(apart), place)
            )
        of = (
            "largest through the last cycle",
            "theory",
            "finite elements",
            "difference",
            f"at (x, y) [{length}]",
        )
        yield Sheet("Measures of fatigue", of, found, (1, 2, 3))
        yield (
            "linear elastic stress of contact and bulk stress, planes that contain z; places beside"
            " the contact: fatigue.csv"
        )
    yield file


def _place(of: dict[str, Any]) -> str:
    return f"({_rounded(of['x'])}, {_rounded(of['y'])})"


def _rounded(place: float) -> str:
    from reports.units import number

    return number(float(f"{place:.3g}"))


def _draw(
    solution: FiniteElementSolution,
    stills: Sequence[tuple[Instant, Snapshot]],
    folder: Path,
    stages: Stages,
) -> list[str]:
    """Pictures of the mesh and of each snapshot; returns their names."""
    with stages.stage("pictures", "pictures") as report:
        import numpy as np

        from reports.comparison.dimensionless import scales as reference_scales
        from reports.field_output.pictures import mesh, scales_of, stress

        folder.mkdir()
        edge = float(np.nanmax(solution.contact_edges))
        names = [
            _write_picture(
                mesh(solution.bodies, reference_scales(solution).half_width, edge, named=True),
                folder,
            )
        ]
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
