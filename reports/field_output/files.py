"""Fields in both bodies and on the contact line at chosen instants, on disk: VTU files, the PVD
collection, the record.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.comparison.cycles import events, index_of_first_row, last_cycle
from reports.field_output.fatigue import principal
from scenes import ContactSolution, InputError
from scenes.array_types import Array

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot
    from meshes import BodyMesh

Indices = NDArray[np.int64]
Report = Callable[[int, int | None, str], None]
_NAME_OF_COLLECTION = "fields.pvd"
# Snapshots that are computed at once: the bodies are factorised once for all of them, and each
# takes about a megabyte.
_SNAPSHOTS_AT_ONCE = 64
# Stated beside every largest stress.
NO_PEAK = (
    "The largest stresses are values at nodes, not peaks between them. The tension at the edges of"
    " contact lies between nodes: it comes from the tractions, and its uncertainty is stated."
)


@dataclass(frozen=True)
class Instant:
    """An instant of the load path whose fields are shown or written."""

    time: float
    # what happens there, or that it was asked for; in a film its number, as in "3 of 24"
    label: str


def instant_of(text: str, option: str, start: float, end: float) -> float:
    """Time of the load path that was given on the command line as a number, `text`.

    InputError, naming the `option`, where it is no number, or lies outside the path, whose times go
    from `start` to `end`. The word "events", which the option takes too, does not come here: the
    message names it.
    """
    try:
        time = float(text)
    except ValueError:
        raise InputError(
            f"{option} {text}: give times of the path, or events for the instants of the page"
        ) from None
    if not start - 1e-9 <= time <= end + 1e-9:
        raise InputError(
            f"{option} {text}: the instant lies outside the path, which goes from time {start:.6g}"
            f" to {end:.6g}"
        )
    return time


def instants_of(
    texts: Sequence[str], solution: ContactSolution, option: str
) -> tuple[Instant, ...]:
    """Instants of a solution that the user asked for on the command line, in order of time, each
    with a label: the event there, or that this time was asked for.

    Parameters
    ----------
    texts
        each a time, or the word "events". That stands for at most six instants of the last cycle
        that the page shows (largest P, ...), except those without load
    option
        name of the option, for messages

    Raises
    ------
    InputError
        For another word, and for a time outside of the solved path. The path ends with the load
        cycle after which the solution repeats.
    """
    label_by_time: dict[float, str] = {}
    for text in texts:
        if text == "events":
            # instants and loads of the cycle; no event lies before the first row of a load record
            cycle = last_cycle(solution)
            for event in events(
                cycle,
                solution.scene.friction.coefficient,
                index_of_first_row(cycle, solution.scene),
            ):
                if cycle.normal_load[event.index] > 0:
                    label_by_time[float(cycle.time[event.index])] = event.label
        else:
            time = instant_of(text, option, float(solution.time[0]), float(solution.time[-1]))
            label_by_time.setdefault(time, f"asked for {text}")
    return tuple(Instant(time, label_by_time[time]) for time in sorted(label_by_time))


def require_series(every: int | None, frames: int | None) -> None:
    """InputError where the options --every (each n-th stored instant) and --frames (number of
    instants) are given both, or make no series of instants.
    """
    if every is not None and frames is not None:
        raise InputError(
            "--every and --frames: both say how many instants of the cycle there are; leave one of"
            " the two out"
        )
    if every is not None and every < 1:
        raise InputError(f"--every {every}: every how many stored steps, so 1 at least")
    if frames is not None and frames < 2:
        raise InputError(f"--frames {frames}: a series has 2 instants at least")


def series_of(
    solution: ContactSolution, every: int | None, frames: int | None
) -> tuple[tuple[Instant, ...], list[str]]:
    """Stored instants of a solution for a film, in order of time, and notes for the user: of the
    last whole cycle, or of the whole path where it does not repeat.

    One of `every` and `frames` is None. The end of a cycle that repeats is left out, since it is
    its start. The label of an instant is its number, as in "3 of 24".

    Parameters
    ----------
    every
        n to take each n-th stored instant of the cycle
    frames
        number of times at equal distances, for each of which the nearest stored instant is taken.
        Where the cycle has fewer instants there are fewer, with a note
    """
    require_series(every, frames)
    repeats = solution.scene.load.path().period is not None
    indices = solution.last_cycle  # of the stored instants
    start = solution.time[indices[0]]
    end = solution.time[indices[-1]]
    if repeats:
        indices = indices[:-1]

    # choose
    notes = []
    if frames is not None:
        frame_times = np.linspace(start, end, frames, endpoint=not repeats)
        distances = np.abs(solution.time[indices] - frame_times[:, None])
        indices = np.unique(indices[distances.argmin(axis=1)])
        if len(indices) < frames:
            notes.append(
                f"{len(indices)} instants instead of {frames}: the cycle has no more stored steps"
                " that far apart; --steps-per-cycle gives more"
            )
    else:
        indices = indices[::every]

    instants = tuple(
        Instant(float(solution.time[index]), f"{number} of {len(indices)}")
        for number, index in enumerate(indices, start=1)
    )
    return instants, notes


def snapshots_of(
    solution: FiniteElementSolution, instants: Sequence[Instant]
) -> Generator[Snapshot, None, None]:
    """Fields of both bodies at each of the `instants`, one after the other. They are computed for
    64 instants at once (`_SNAPSHOTS_AT_ONCE`), which bounds the memory.
    """
    import halfplane_fe

    for first_index in range(0, len(instants), _SNAPSHOTS_AT_ONCE):
        yield from halfplane_fe.fields(
            solution,
            [instant.time for instant in instants[first_index : first_index + _SNAPSHOTS_AT_ONCE]],
        )


def with_bodies(solution: ContactSolution, option: str) -> FiniteElementSolution:
    """`solution` as a finite-element one, which has bodies; InputError, naming the `option`, where
    it has none.
    """
    import halfplane_fe

    if not isinstance(solution, halfplane_fe.FiniteElementSolution):
        raise InputError(
            f"{option}: {solution.engine} has no bodies to write; leave the option out"
        )
    return solution


class _Part(NamedTuple):
    """Fields of a body or of the contact line at one instant, for one VTU file."""

    name: str  # name of the body, or "contact"
    points: Array  # (n_points, 2) places in the undeformed body [length]
    cells: Indices  # (n_cells, nodes per cell) points of each element
    # name of a field -> its values at the points, (n_points,) or (n_points, components)
    values_by_name: dict[str, NDArray[Any]]


def write_fields(
    solution: FiniteElementSolution,
    snapshots: Iterable[Snapshot],
    folder: Path,
    report: Report = lambda *_: None,
    total: int | None = None,
) -> list[str]:
    """Write the fields of both bodies and of the contact line at each snapshot as VTU files, and a
    PVD file that lists them with their times. Returns the names of the files, the PVD file first.

    Stress has VTK's order of a symmetric tensor: xx, yy, zz, xy, yz, xz. The contact line has
    tractions, slip and state at its points, and the displacement of the lower body, by which a
    viewer can deform it.

    Parameters
    ----------
    solution
        has the tractions, slip and state of the contact line at all stored instants, and the meshes
        of both bodies, the lower one first
    snapshots
        fields of both bodies, the lower one first, at an instant each: name, points, cells (nodes
        of each element), displacement and stress at the nodes
    folder
        made if it does not exist
    report
        called with (number of snapshots written, total, text)
    total
        number of snapshots; None where it is not known
    """
    import meshes

    folder.mkdir(exist_ok=True)
    nodes_of_line = contact_line(solution.bodies[0])
    entries = []
    for snapshot_number, snapshot in enumerate(snapshots):
        report(snapshot_number, total, f"time {snapshot.time:.6g}")
        parts = [_part_of_body(body) for body in snapshot.bodies]
        parts.append(_part_of_contact_line(solution, snapshot, nodes_of_line))
        # a file each, with an entry of the collection
        for part_number, part in enumerate(parts):
            file_name = f"{part.name}_{snapshot_number:03d}.vtu"
            meshes.write_vtu(folder / file_name, part.points, part.cells, part.values_by_name)
            entries.append(meshes.PvdEntry(snapshot.time, part_number, part.name, file_name))
    # _NAME_OF_COLLECTION: "fields.pvd"
    meshes.write_pvd(folder / _NAME_OF_COLLECTION, entries)
    return [_NAME_OF_COLLECTION, *(entry.file for entry in entries)]


def _part_of_body(body: BodyFields) -> _Part:
    """Displacement, stress tensor and von Mises' stress at the nodes of a body at one instant, for
    a VTU file. The tensor is (n_points, 6) in the order of VTK: xx, yy, zz, xy, yz, xz [stress].
    """
    s_xx, s_yy, s_xy, s_zz = body.stress.T
    zero_shear = np.zeros_like(s_xx)  # yz and xz: none in plane strain
    tensor = np.column_stack([s_xx, s_yy, s_zz, s_xy, zero_shear, zero_shear])
    nodal_values = {
        "displacement": body.displacement,
        "stress": tensor,
        "von_mises": body.von_mises,
    }
    return _Part(body.name, body.points, body.cells, nodal_values)


def _part_of_contact_line(
    solution: FiniteElementSolution, snapshot: Snapshot, nodes_of_line: Indices
) -> _Part:
    """Pressure, shear, slip and state of the contact line at the instant of a snapshot, for a VTU
    file, with the displacement of the lower body there.

    The points of the line are the nodes `nodes_of_line` (n,) of the lower body, from left to right;
    its cells are pairs of neighbours. Of the solution the stored instant is taken whose time is
    nearest to that of the snapshot.
    """
    cells_of_line = np.column_stack(
        [np.arange(len(nodes_of_line) - 1), np.arange(1, len(nodes_of_line))]
    )
    instant_index = int(np.argmin(np.abs(solution.time - snapshot.time)))
    lower_fields = snapshot.bodies[0]
    values_on_line = {
        "pressure": solution.pressure[instant_index],
        "shear": solution.shear[instant_index],
        "slip": solution.slip[instant_index],
        "state": solution.state[instant_index].astype(np.int32),
        "displacement": lower_fields.displacement[nodes_of_line],
    }
    return _Part("contact", lower_fields.points[nodes_of_line], cells_of_line, values_on_line)


def contact_line(body_mesh: BodyMesh, boundaries: Sequence[str] = ("contact",)) -> Indices:
    """Nodes of a body's contact face, or of the named `boundaries`, from left to right, as indices
    into the points of the body's fields. Nodes in the middle of element sides are among them.

    `body_mesh.mesh`, of scikit-fem, has places of nodes `p` (2, n), corner nodes of all element
    sides `facets` (2, k), and indices of the facets on each boundary.
    """
    skfem_mesh = body_mesh.mesh
    # indices of the facets on these boundaries
    facet_indices = np.concatenate(
        [skfem_mesh.boundaries[name] for name in boundaries if name in skfem_mesh.boundaries]
    )
    # corners come first among the nodes, then the middle of each facet, in the order of the facets
    n_corners = int(skfem_mesh.facets.max()) + 1
    has_middle_nodes = skfem_mesh.p.shape[1] > n_corners
    nodes = skfem_mesh.facets[:, facet_indices].ravel()
    if has_middle_nodes:
        nodes = np.concatenate([nodes, n_corners + facet_indices])
    nodes = np.unique(nodes)
    return np.asarray(nodes[np.argsort(skfem_mesh.p[0, nodes])], dtype=np.int64)


def peak(
    snapshot: Snapshot, stress_of: Callable[[BodyFields], Array] = lambda body: body.von_mises
) -> dict[str, Any]:
    """The largest nodal value of a stress in both bodies [stress], with the name of its body and
    its place in the undeformed body [length], by name. It depends on the mesh: at an edge of
    contact the stress may be infinite.

    `snapshot.bodies` are the fields of both bodies at an instant. `stress_of` returns the stress at
    each node of a body, (n_nodes,): von Mises' stress by default.
    """
    body = max(snapshot.bodies, key=lambda body: float(stress_of(body).max()))
    values = stress_of(body)
    node = int(np.argmax(values))
    x = float(body.points[node, 0])
    y = float(body.points[node, 1]) + 0.0  # -0.0 becomes 0.0
    return {"value": float(values[node]), "body": body.name, "x": x, "y": y, "place": [x, y]}


def tension(body: BodyFields) -> Array:
    """Largest principal stress at each node, (n,) [stress]: on the face, beside the contact, the
    one that opens cracks.
    """
    return np.asarray(principal(body.stress)[:, 0])


def edge_tension(snapshot: Snapshot) -> dict[str, Any] | None:
    """The largest tension along the faces of both bodies at the edges of contact, at one instant:
    its value and uncertainty [stress], its body and its place x [length], by name. None out of
    contact, and where the tension of one body is not known.

    Of a body in `snapshot`, `edges` has x of the left and right edge of contact, NaN out of
    contact. `edge_tension` has the stress along the face there, NaN where it is not known.
    """
    if not all(np.isfinite(body.edge_tension).all() for body in snapshot.bodies):
        return None
    tensions: list[dict[str, Any]] = []
    for body in snapshot.bodies:
        values_at_edges = zip(
            body.edge_tension, body.edge_tension_uncertainty, body.edges, strict=True
        )
        tensions += [
            {
                "value": float(value),
                "uncertainty": float(uncertainty),
                "body": body.name,
                "x": float(x),
            }
            for value, uncertainty, x in values_at_edges
            if np.isfinite(x)
        ]
    return max(tensions, key=lambda tension: tension["value"], default=None)


def stated(instant: Instant, snapshot: Snapshot) -> dict[str, Any]:
    """Values at an instant whose fields of both bodies were written (`snapshot`), by name, for
    fields.json and the terminal. They are time, loads [force / thickness], largest nodal stresses
    [stress], and the largest tension at the edges of contact [stress].

    `instant` is that which was asked for; the time of the snapshot is the nearest one that is
    stored.
    """
    # `tension`: function of a body, its largest tensile stress at each node
    return {
        "asked": instant.time,
        "label": instant.label,
        "time": snapshot.time,
        "normal_load": snapshot.normal_load,
        "tangential_load": snapshot.tangential_load,
        "largest_nodal_von_mises": peak(snapshot),
        "largest_nodal_tension": peak(snapshot, tension),
        "tension_at_edge": edge_tension(snapshot),
    }


def record(solution: FiniteElementSolution, **command_content: Any) -> dict[str, Any]:
    """The content of fields.json, the file beside written fields: meaning of the fields, supports
    and mesh quality of both bodies, settings, scene and convergence of the solution.
    `command_content` holds further entries, those of the command.
    """
    scene = solution.scene
    # NO_PEAK: a sentence, that nodal values are not peaks
    return {
        "format": "halfplane fields 1",
        "units": scene.units,
        "largest nodal stresses": NO_PEAK,
        **command_content,
        "point data": {
            "displacement": (
                "of each body; the upper one's with its movement as a whole; on the contact line"
                " the lower one's"
            ),
            "stress": (
                "xx, yy, zz, xy, yz, xz: beside the contact from the tractions, further away"
                " carried to each node from its elements and averaged there"
            ),
            "von_mises": "of that stress",
            "pressure": "on the contact line, positive in compression",
            "shear": "on the contact line, positive along x on the lower body",
            "slip": (
                "on the contact line, upper over lower body; goes on as relative displacement while"
                " a point is open"
            ),
            "state": "on the contact line: 0 open, 1 stick, 2 forward slip, 3 reverse slip",
        },
        "gap": (
            "in the shape of the faces"
            if scene.bodies.faces_are_true
            else "not in the files: both faces are flat, and the profile is the gap between them"
        ),
        "bodies": {
            name: {"supports": dict(body.supports), "quality": dict(body.quality)}
            for name, body in zip(("lower", "upper"), solution.bodies, strict=True)
        },
        "record": {
            "converged": solution.record.converged,
            "message": solution.record.message,
            "notes": solution.record.notes,
        },
        "settings": solution.settings,
        "versions": solution.versions,
        "scene": scene.model_dump(mode="json"),
    }
