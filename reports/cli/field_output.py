"""`halfplane fields`: both bodies at chosen instants or over the last cycle, as files for ParaView, pictures and a film."""

from __future__ import annotations

import json
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from reports.cli.answers import answer
from reports.cli.options import FiniteElements, SceneName, flag, several
from reports.cli.process import WITHIN
from reports.cli.solving import at_work, load_engines, require_drawing, require_times, solve_finite_elements
from reports.console import Stages, say, show_table

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution, Snapshot
    from reports.fields import Instant, Seen
    from scenes import ContactSolution, Scene

# Snapshots that are computed at once: the bodies are factorised once for all of them, and each takes about a megabyte.
_AT_ONCE = 64
# Frames of a film without a series: five seconds at twelve a second.
FRAMES = 60
# A series of more instants than this is shown by the one with the largest stress.
_ROWS = 12


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class FieldsOptions(FiniteElements):
    """Which instants are written, and what is drawn of them."""

    at: Annotated[tuple[str, ...], several('Times of the path, or "events" of the last cycle, the default without a series.')] = ()
    every: Annotated[int | None, Parameter(help="A series over the last cycle: every Nth stored step.")] = None
    frames: Annotated[int | None, Parameter(help="A series over the last cycle: N instants evenly in time.")] = None
    animate: Annotated[
        bool, flag("The cycle as GIF and MP4: the instants of the series, 60 without one. MP4: halfplane[animation].")
    ] = False
    pictures: Annotated[bool, Parameter(help="Draw the meshes and the von Mises stress at the instants of --at as PNG.")] = True

    @property
    def series(self) -> bool:
        """Whether files for ParaView are wanted over the whole cycle."""
        return self.every is not None or self.frames is not None

    @property
    def named(self) -> tuple[str, ...]:
        """Words of --at; the events where neither a series nor times are asked for."""
        return self.at or (() if self.series else ("events",))


_FIELDS = FieldsOptions()


def fields(scene: SceneName, *, options: FieldsOptions = _FIELDS) -> int:
    """Finite elements, and displacement, stress and tractions of both bodies on disk."""
    from reports import fields as files
    from reports.comparison.content import strict
    from reports.folder import filled

    require_series(options.every, options.frames)
    options, source = replace(options, at=options.named), scene

    def work(scene: Scene, folder: Path, stages: Stages) -> int:
        require_times(options.at, "--at", scene)
        if options.pictures and options.at:
            require_drawing(stages)
        load_engines(stages)
        solution = files.with_bodies(solve_finite_elements(scene, options, stages), "fields")
        named = files.instants_of(options.at, solution, "--at")
        series = series_of(solution, options.every, options.frames) if options.series else ()
        notes = [shortfall(options.frames, len(series))] if series else []
        instants = tuple(sorted({one.time: one for one in (*series, *named)}.values(), key=lambda one: one.time))
        told: list[Seen] = []
        stills: list[tuple[Instant, Snapshot]] = []

        def passing() -> Generator[Snapshot, None, None]:
            """Snapshots on their way to disk: what is stated of each is noted, those of named instants are kept for stills."""
            wanted = {one.time for one in named}
            for instant, snapshot in zip(instants, snapshots_of(solution, instants), strict=True):
                told.append(files.seen(instant, snapshot))
                if instant.time in wanted:
                    stills.append((instant, snapshot))
                yield snapshot

        with filled(folder, fresh=("fields/", "pictures/", "animation/")) as staging:
            with stages.stage("files for ParaView", "instants") as report:
                names = files.write_fields(solution, passing(), staging / "fields", report, len(instants))
            written = [f"fields/{name}" for name in names]
            drawn = _draw(solution, stills, staging / "pictures", stages) if options.pictures and stills else []
            film = _animate(solution, series, staging / "animation", stages, notes) if options.animate else None
            notes = [note for note in notes if note]
            command = options.command("fields", source, folder)
            content = files.record(solution, told, written, drawn, command, stages.seconds, film, notes)
            text = json.dumps(strict(content), allow_nan=False, indent=1)
            (staging / "fields" / "fields.json").write_text(text + "\n", encoding="utf-8")
        films = [f"animation/{name}" for name in film["files"]] if film else []
        whole, file = ["fields/fields.json", *written, *drawn, *films], str(folder / "fields" / "fields.pvd")
        if options.json:
            shown = {"passed": True, "instants": [_content(one) for one in told], "largest nodal stresses": files.NO_PEAK}
            more = {"notes": notes, "files": whole, "file": file, "seconds": stages.seconds}
            return answer("fields", WITHIN, shown | more, scene.name)
        _show(scene, told, whole, notes)
        say(file)
        return WITHIN

    return at_work("fields", source, options, work)


def _content(one: Seen) -> dict[str, Any]:
    """An instant for programs: its loads and largest nodal stresses."""
    largest = {
        f"largest_nodal_{name}": {"value": found.value, "body": found.body, "place": list(found.place)}
        for name, found in (("von_mises", one.von_mises), ("tension", one.tension))
    }
    loads = {"time": one.time, "normal_load": one.normal_load, "tangential_load": one.tangential_load}
    return {"label": one.instant.label, **loads, **largest}


def _show(scene: Scene, instants: Sequence[Seen], written: Sequence[str], notes: Sequence[str]) -> None:
    """The instants with their largest nodal stress, the largest of all where they are many, and what was written."""
    from reports.fields import NO_PEAK
    from reports.units import load_unit, number, units

    _, length, stress = units(scene)
    load, many, rows = load_unit(scene), len(instants) > _ROWS, []
    for one in [max(instants, key=lambda one: one.von_mises.value)] if many else instants:
        largest = [
            f"{number(found.value)} at ({', '.join(number(float(f'{place:.3g}')) for place in found.place)}), {found.body}"
            for found in (one.von_mises, one.tension)
        ]
        rows.append((one.instant.label, *map(number, (one.time, one.normal_load, one.tangential_load)), *largest))
    heads = ("instant", "time", f"P [{load}]", f"Q [{load}]", f"nodal von Mises [{stress}]", f"nodal tension, no peak [{stress}]")
    show_table(scene.title or scene.name, heads, rows, right=(1, 2, 3))
    say(f"places (x, y) in {length}, on the undeformed bodies; tension is the largest principal stress")
    say(NO_PEAK)
    if many:
        say(f"shown: of {len(instants)} instants the one with the largest stress; all are in fields/fields.json")
    for note in notes:
        say(note)
    counts = {kind: sum(name.endswith(kind) for name in written) for kind in (".vtu", ".png")}
    films = [name for name in written if name.startswith("animation/")]
    film = f", {' and '.join(films)}" if films else ""
    say(f"written: {counts['.vtu']} VTU files, {counts['.png']} pictures{film}, and what they are in fields/fields.json")


def snapshots_of(solution: FiniteElementSolution, instants: Sequence[Instant]) -> Generator[Snapshot, None, None]:
    """Snapshots at `instants`, so many at once as memory is for."""
    import halfplane_fe

    for first in range(0, len(instants), _AT_ONCE):
        yield from halfplane_fe.fields(solution, [instant.time for instant in instants[first : first + _AT_ONCE]])


def _draw(solution: FiniteElementSolution, stills: Sequence[tuple[Instant, Snapshot]], folder: Path, stages: Stages) -> list[str]:
    """Pictures of the mesh and of each snapshot; returns their names."""
    with stages.stage("pictures", "pictures") as report:
        import numpy as np

        from reports.charts.publication import write_plots
        from reports.figures_mesh import look, mesh, stress

        edge = float(np.nanmax(solution.contact_half_width))
        names, shared = (
            write_plots([mesh(solution.bodies, edge, edge, named=True)], folder, ("png",)),
            look([snapshot for _, snapshot in stills]),
        )
        for number, (instant, snapshot) in enumerate(stills):
            report(number + 1, len(stills) + 1, f"time {snapshot.time:.6g}")
            plate = stress(solution, [snapshot], [instant], shared, f"von_mises_{number:03d}", 1000)
            names += write_plots([plate], folder, ("png",))
    return [f"pictures/{name}" for name in names]


def _animate(
    solution: FiniteElementSolution, series: Sequence[Instant], folder: Path, stages: Stages, notes: list[str]
) -> dict[str, Any]:
    """The cycle as GIF, and as MP4 where ffmpeg is at hand; returns what fields.json holds of it."""
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


def require_series(every: int | None, frames: int | None) -> None:
    """InputError for both at once, and for counts that make no series."""
    from scenes import InputError

    if every is not None and frames is not None:
        raise InputError("--every and --frames: both say how many instants of the cycle there are; leave one of the two out")
    if every is not None and every < 1:
        raise InputError(f"--every {every}: every how many stored steps, so 1 at least")
    if frames is not None and frames < 2:
        raise InputError(f"--frames {frames}: a series has 2 instants at least")


def series_of(solution: ContactSolution, every: int | None, frames: int | None) -> tuple[Instant, ...]:
    """Stored instants of the last whole cycle (the whole path, where it does not repeat), in order of time.

    Parameters
    ----------
    every : each so-manieth stored step of the cycle
    frames : the stored steps nearest to so many times at equal distances; fewer where the cycle has fewer steps

    The end of a cycle that repeats is left out, since it is its start.
    """
    import numpy as np

    from reports.fields import Instant

    require_series(every, frames)
    steps, repeats = solution.last_cycle, solution.scene.load.path().period is not None
    if repeats:
        steps = steps[:-1]
    if frames is not None:
        first, last = solution.time[steps[0]], solution.time[solution.last_cycle[-1]]
        wanted = np.linspace(first, last, frames, endpoint=not repeats)
        steps = np.unique(steps[np.abs(solution.time[steps] - wanted[:, None]).argmin(axis=1)])
    elif every is not None:
        steps = steps[::every]
    return tuple(Instant(float(solution.time[step]), f"{number + 1} of {len(steps)}") for number, step in enumerate(steps))


def shortfall(frames: int | None, found: int) -> str:
    """A sentence where a series has fewer instants than were asked for; empty otherwise."""
    if frames is None or found >= frames:
        return ""
    return f"{found} instants instead of {frames}: the cycle has no more stored steps that far apart; --steps-per-cycle gives more"
