"""Fields in both bodies and on the contact line at chosen instants, on disk: VTU files, the PVD collection, the record."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.comparison.cycles import events, last_cycle
from scenes import ContactSolution, InputError

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot
    from meshes import BodyMesh

Report = Callable[[int, int | None, str], None]
COLLECTION = "fields.pvd"
# Beside every largest stress: on the unsafe side. Measured against theory's 2 f p0 sqrt(Q/(f P)), see docs/bodies.md.
NO_PEAK = (
    "These are nodal stresses, not peaks: at the trailing edge of the contact the true tension is higher. On the default mesh "
    "nodes give about 93 % of it at Q = 0.6 f P and about 85 % at 0.1 f P; on a coarser mesh they give less."
)


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


def write_fields(
    solution: FiniteElementSolution,
    snapshots: Iterable[Snapshot],
    folder: Path,
    report: Report = lambda _done, _total, _text: None,
    total: int | None = None,
) -> list[str]:
    """Write lower_000.vtu, upper_000.vtu, contact_000.vtu and so on, the collection; return the names, its own first."""
    import meshes

    folder.mkdir(exist_ok=True)
    line = contact_line(solution.bodies[0])
    entries = []
    for number, snapshot in enumerate(snapshots):
        report(number, total, f"time {snapshot.time:.6g}")
        lower = snapshot.bodies[0]
        parts = [(body.name, body.points, body.cells, _point_data(body)) for body in snapshot.bodies]
        parts.append(("contact", lower.points[line], _chain(len(line)), _surface_data(solution, snapshot, line)))
        for part, (name, points, cells, data) in enumerate(parts):
            file = f"{name}_{number:03d}.vtu"
            meshes.write_vtu(folder / file, points, cells, data)
            entries.append(meshes.PvdEntry(snapshot.time, part, name, file))
    meshes.write_pvd(folder / COLLECTION, entries)
    return [COLLECTION, *(entry.file for entry in entries)]


def contact_line(mesh: BodyMesh, boundaries: Sequence[str] = ("contact",)) -> NDArray[np.int64]:
    """Nodes of a body's contact face from left to right, mid-side nodes among them; indices into the points of its fields."""
    skfem_mesh = mesh.mesh
    facets = np.concatenate([skfem_mesh.boundaries[name] for name in boundaries if name in skfem_mesh.boundaries])
    n_corners = int(skfem_mesh.facets.max()) + 1
    has_middles = skfem_mesh.p.shape[1] > n_corners
    nodes = np.unique(np.concatenate([skfem_mesh.facets[:, facets].ravel(), *([n_corners + facets] if has_middles else [])]))
    return np.asarray(nodes[np.argsort(skfem_mesh.p[0, nodes])], dtype=np.int64)


def _chain(count: int) -> NDArray[np.int64]:
    """Lines between `count` points in their order."""
    return np.column_stack([np.arange(count - 1), np.arange(1, count)])


def _surface_data(solution: FiniteElementSolution, snapshot: Snapshot, line: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    """What the VTU of the contact line holds: the answer at its points x, and the lower body's displacement to warp it by."""
    step = int(np.argmin(np.abs(solution.time - snapshot.time)))
    return {
        "pressure": solution.pressure[step],
        "shear": solution.shear[step],
        "slip": solution.slip[step],
        "state": solution.state[step].astype(np.int32),
        "displacement": snapshot.bodies[0].displacement[line],
    }


def _point_data(body: BodyFields) -> dict[str, NDArray[np.float64]]:
    """What a VTU file holds; the stress as VTK's symmetric tensor xx, yy, zz, xy, yz, xz."""
    xx, yy, xy, zz = body.stress.T
    tensor = np.column_stack([xx, yy, zz, xy, np.zeros_like(xx), np.zeros_like(xx)])
    return {"displacement": body.displacement, "stress": tensor, "von_mises": body.von_mises}


@dataclass(frozen=True)
class Peak:
    """The largest nodal value of a stress in a snapshot [stress], its body and undeformed place [length]; see `NO_PEAK`."""

    value: float
    body: str
    place: tuple[float, float]


def peak(snapshot: Snapshot, of: Callable[[BodyFields], NDArray[np.float64]] = lambda body: body.von_mises) -> Peak:
    """Where `of` a body, a value at each of its nodes, is largest: von Mises' stress, or `tension`."""
    values = [of(body) for body in snapshot.bodies]
    which = int(np.argmax([value.max() for value in values]))
    body, node = snapshot.bodies[which], int(np.argmax(values[which]))
    return Peak(float(values[which][node]), body.name, (float(body.points[node, 0]), float(body.points[node, 1]) + 0.0))


def tension(body: BodyFields) -> NDArray[np.float64]:
    """Largest principal stress at each node, (n,) [stress]: on the face, beside the contact, the one that opens cracks."""
    xx, yy, xy, zz = body.stress.T
    return np.maximum((xx + yy) / 2 + np.hypot((xx - yy) / 2, xy), zz)


@dataclass(frozen=True)
class Seen:
    """An instant that was written: what was asked for, the stored time taken, its loads [force/length], its largest stresses.

    `von_mises` and `tension` are the largest nodal values of von Mises' stress and of the principal stresses.
    """

    instant: Instant
    time: float
    normal_load: float
    tangential_load: float
    von_mises: Peak
    tension: Peak


def seen(instant: Instant, snapshot: Snapshot) -> Seen:
    """What is told of a snapshot once it is on disk."""
    loads = snapshot.normal_load, snapshot.tangential_load
    return Seen(instant, snapshot.time, *loads, peak(snapshot), peak(snapshot, tension))


def _placed(found: Peak) -> dict[str, float | str]:
    return {"value": found.value, "body": found.body, "x": found.place[0], "y": found.place[1]}


def record(
    solution: FiniteElementSolution,
    instants: Sequence[Seen],
    files: Sequence[str],
    pictures: Sequence[str],
    command: str,
    seconds: Mapping[str, float],
    animation: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
) -> dict[str, Any]:
    """What was written and from what, for fields.json."""
    return {
        "format": "halfplane fields 1",
        "command": command,
        "units": solution.scene.units,
        "instants": [
            {
                "asked": one.instant.time,
                "label": one.instant.label,
                "time": one.time,
                "normal_load": one.normal_load,
                "tangential_load": one.tangential_load,
                "largest_nodal_von_mises": _placed(one.von_mises),
                "largest_nodal_tension": _placed(one.tension),
            }
            for one in instants
        ],
        "largest nodal stresses": NO_PEAK,
        "notes": list(notes),
        "files": list(files),
        "pictures": list(pictures),
        "animation": None if animation is None else dict(animation),
        "point data": {
            "displacement": "of each body; the upper one's with its movement as a whole; on the contact line the lower one's",
            "stress": "xx, yy, zz, xy, yz, xz, carried to each node from its elements and averaged there",
            "von_mises": "of that stress",
            "pressure": "on the contact line, positive in compression",
            "shear": "on the contact line, positive along x on the lower body",
            "slip": "on the contact line, upper over lower body; goes on as relative displacement while a point is open",
            "state": "on the contact line: 0 open, 1 stick, 2 forward slip, 3 reverse slip",
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
