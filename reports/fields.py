"""Fields in both bodies at chosen instants, on disk: VTU for each body and instant, the PVD collection over them, the record."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.instants import events
from reports.sampling import last_cycle
from scenes import ContactSolution, InputError

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot

Report = Callable[[int, int | None, str], None]
COLLECTION = "fields.pvd"


@dataclass(frozen=True)
class Instant:
    """A time that was asked for, and why."""

    time: float
    label: str


def instant_of(word: str, option: str, start: float, end: float) -> float:
    """A time from the command line; InputError for what is none, or lies outside the path."""
    try:
        time = float(word)
    except ValueError:
        raise InputError(f"{option} {word}: give times of the path, or events for the instants of the page") from None
    if not start - 1e-9 <= time <= end + 1e-9:
        raise InputError(f"{option} {word}: the instant lies outside the path, which goes from time {start:.6g} to {end:.6g}")
    return time


def instants_of(words: Sequence[str], solution: ContactSolution, option: str) -> tuple[Instant, ...]:
    """Instants meant on the command line, in order of time: numbers are times, "events" the loaded ones of the page's figures.

    Raises
    ------
    InputError
        For a word that is neither, and a time outside what was solved (no more revolutions than the answer needs to repeat).
    """
    found: dict[float, str] = {}
    for word in words:
        if word == "events":
            cycle = last_cycle(solution)
            chosen = [e for e in events(cycle, solution.scene.friction.coefficient) if cycle.normal_load[e.index] > 0]
            found |= {float(cycle.time[event.index]): event.label for event in chosen}
        else:
            time = instant_of(word, option, float(solution.time[0]), float(solution.time[-1]))
            found.setdefault(time, f"asked for {word}")
    return tuple(Instant(time, found[time]) for time in sorted(found))


def with_bodies(solution: ContactSolution, option: str) -> FiniteElementSolution:
    """`solution` as one that has bodies; InputError where it has none."""
    import halfplane_fe

    if not isinstance(solution, halfplane_fe.FiniteElementSolution):
        raise InputError(f"{option}: {solution.engine} has no bodies to write; leave the option out")
    return solution


def write_fields(snapshots: Sequence[Snapshot], folder: Path, report: Report = lambda _done, _total, _text: None) -> list[str]:
    """Write lower_000.vtu, upper_000.vtu and so on, and the collection over them; return the names, the collection's first."""
    import meshes

    folder.mkdir(exist_ok=True)
    entries = []
    for number, snapshot in enumerate(snapshots):
        report(number, len(snapshots), f"time {snapshot.time:.6g}")
        for part, body in enumerate(snapshot.bodies):
            file = f"{body.name}_{number:03d}.vtu"
            meshes.write_vtu(folder / file, body.points, body.cells, _point_data(body))
            entries.append(meshes.PvdEntry(snapshot.time, part, body.name, file))
    meshes.write_pvd(folder / COLLECTION, entries)
    return [COLLECTION, *(entry.file for entry in entries)]


def _point_data(body: BodyFields) -> dict[str, NDArray[np.float64]]:
    """What a VTU file holds; the stress as VTK's symmetric tensor xx, yy, zz, xy, yz, xz."""
    xx, yy, xy, zz = body.stress.T
    tensor = np.column_stack([xx, yy, zz, xy, np.zeros_like(xx), np.zeros_like(xx)])
    return {"displacement": body.displacement, "stress": tensor, "von_mises": body.von_mises}


@dataclass(frozen=True)
class Peak:
    """The largest von Mises stress of a snapshot: its value [stress], the body and the undeformed place [length]."""

    value: float
    body: str
    place: tuple[float, float]


def peak(snapshot: Snapshot) -> Peak:
    """Where von Mises' stress is largest."""
    body = max(snapshot.bodies, key=lambda body: float(body.von_mises.max()))
    node = int(np.argmax(body.von_mises))
    return Peak(float(body.von_mises[node]), body.name, (float(body.points[node, 0]), float(body.points[node, 1]) + 0.0))


def record(
    solution: FiniteElementSolution,
    asked: Sequence[Instant],
    snapshots: Sequence[Snapshot],
    files: Sequence[str],
    pictures: Sequence[str],
    command: str,
    seconds: Mapping[str, float],
) -> dict[str, Any]:
    """What was written and from what, for fields.json."""
    return {
        "format": "halfplane fields 1",
        "command": command,
        "units": solution.scene.units,
        "instants": [
            {
                "asked": instant.time,
                "label": instant.label,
                "time": snapshot.time,
                "normal_load": snapshot.normal_load,
                "tangential_load": snapshot.tangential_load,
                "largest_von_mises": {"value": found.value, "body": found.body, "x": found.place[0], "y": found.place[1]},
            }
            for instant, snapshot in zip(asked, snapshots, strict=True)
            for found in [peak(snapshot)]
        ],
        "files": list(files),
        "pictures": list(pictures),
        "point data": {
            "displacement": "of each body; the upper one's with its rigid shift and approach",
            "stress": "xx, yy, zz, xy, yz, xz, averaged over the elements of a node",
            "von_mises": "of that stress",
        },
        "gap": "in the shape of the faces"
        if solution.scene.bodies.faces_are_true
        else "not in the files: both faces are flat, and the profile is the gap between them",
        "bodies": {
            name: {"supports": dict(body.supports), "quality": dict(body.quality)}
            for name, body in zip(("lower", "upper"), solution.bodies, strict=True)
        },
        "record": {"converged": solution.record.converged, "message": solution.record.message, "notes": solution.record.notes},
        "settings": solution.settings,
        "versions": solution.versions,
        "seconds": dict(seconds),
        "scene": solution.scene.model_dump(mode="json"),
    }
