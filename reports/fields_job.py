"""The job of `halfplane fields`: from an answer to files for ParaView, still pictures and an animation. Heavy packages inside."""

from __future__ import annotations

import json
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports import fields as files
from reports.console import Stages
from reports.fields import Instant, Seen, seen
from reports.folder import filled
from reports.series import FRAMES, Wish, series_of, shortfall
from reports.summary import strict
from scenes import ContactSolution

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution, Snapshot

# Snapshots that are worked out at once: the bodies are factorised once for all of them, and each takes about a megabyte.
_AT_ONCE = 64


@dataclass(frozen=True)
class FieldsReport:
    """What `fields` leaves: instants written, names of the files, sentences for the user, wall times."""

    instants: Sequence[Seen]
    files: Sequence[str]
    notes: Sequence[str]
    seconds: Mapping[str, float]


def fields(solution: ContactSolution, out: Path, wish: Wish, stages: Stages, *, command: str = "") -> FieldsReport:
    """Displacement and stress of both bodies on disk, for ParaView and as pictures; with `animate` the cycle as a film."""
    answer = files.with_bodies(solution, "fields")
    named = files.instants_of(wish.named, answer, "--at")
    series = series_of(answer, wish.every, wish.frames) if wish.series else ()
    notes = [shortfall(wish.frames, len(series))] if series else []
    instants = tuple(sorted({one.time: one for one in (*series, *named)}.values(), key=lambda one: one.time))
    with filled(out, fresh=("fields/", "pictures/", "animation/")) as folder:
        told: list[Seen] = []
        stills: list[tuple[Instant, Snapshot]] = []
        with stages.stage("files for ParaView", "instants") as report:
            snapshots = _passing(answer, instants, {one.time for one in named}, told, stills)
            names = files.write_fields(answer, snapshots, folder / "fields", report, len(instants))
        written = [f"fields/{name}" for name in names]
        drawn = _draw(answer, stills, folder / "pictures", stages) if wish.pictures and stills else []
        film = _animate(answer, series, folder / "animation", stages, notes) if wish.animate else None
        notes = [note for note in notes if note]
        content = files.record(answer, told, written, drawn, command, stages.seconds, film, notes)
        (folder / "fields" / "fields.json").write_text(
            json.dumps(strict(content), allow_nan=False, indent=1) + "\n", encoding="utf-8"
        )
    shown = [f"animation/{name}" for name in film["files"]] if film else []
    return FieldsReport(told, ("fields/fields.json", *written, *drawn, *shown), notes, stages.seconds)


def snapshots_of(solution: FiniteElementSolution, instants: Sequence[Instant]) -> Generator[Snapshot, None, None]:
    """Snapshots at `instants`, so many at once as memory is for."""
    import halfplane_fe

    for first in range(0, len(instants), _AT_ONCE):
        yield from halfplane_fe.fields(solution, [instant.time for instant in instants[first : first + _AT_ONCE]])


def _passing(
    solution: FiniteElementSolution,
    instants: Sequence[Instant],
    named: set[float],
    told: list[Seen],
    stills: list[tuple[Instant, Snapshot]],
) -> Generator[Snapshot, None, None]:
    """Snapshots on their way to disk: what is told of each is noted, those of named instants are kept for stills."""
    for instant, snapshot in zip(instants, snapshots_of(solution, instants), strict=True):
        told.append(seen(instant, snapshot))
        if instant.time in named:
            stills.append((instant, snapshot))
        yield snapshot


def _draw(solution: FiniteElementSolution, stills: Sequence[tuple[Instant, Snapshot]], folder: Path, stages: Stages) -> list[str]:
    """Pictures of the mesh and of each snapshot; returns their names."""
    with stages.stage("pictures", "pictures") as report:
        from reports.mesh_pictures import mesh_picture
        from reports.panels import save
        from reports.stress_pictures import look, stress_picture

        folder.mkdir()
        save(mesh_picture(solution, stills[0][1].bodies), folder / "mesh.png")
        names, shared = ["mesh.png"], look([snapshot for _, snapshot in stills])
        for number, (instant, snapshot) in enumerate(stills):
            report(number + 1, len(stills) + 1, f"time {snapshot.time:.6g}")
            names.append(f"von_mises_{number:03d}.png")
            save(stress_picture(solution, snapshot, instant.label, shared), folder / names[-1])
    return [f"pictures/{name}" for name in names]


def _animate(
    solution: FiniteElementSolution, series: Sequence[Instant], folder: Path, stages: Stages, notes: list[str]
) -> dict[str, Any]:
    """The cycle as GIF, and as MP4 where ffmpeg is at hand; returns what fields.json says of it."""
    from reports.animation import close_ups, frames_of
    from reports.animation_stage import colours
    from reports.film import write_film

    instants = series or series_of(solution, None, FRAMES)
    if not series:
        notes.append(shortfall(FRAMES, len(instants)))
    with stages.stage("fields of the animation"):
        views = close_ups(solution, snapshots_of(solution, instants))
    with stages.stage("animation", "frames") as report:
        folder.mkdir()
        film = write_film(frames_of(solution, views, report), colours(), folder, "cycle")
    notes += film.notes
    return {
        "files": film.files,
        "frames": len(instants),
        "frames_per_second": film.rate,
        "size": film.size,
        "exaggeration": views.factor,
        "exaggerated": "displacements and the gap between the bodies; tractions and stresses are not",
        "times": [instant.time for instant in instants],
    }
