"""The cycle as frames: deformed bodies at the contact with von Mises' and the shear stress, tractions and the P-Q point beneath."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.typing import NDArray

from reports import animation_stage
from reports.animation_stage import Close, CloseUps, View
from reports.fields import contact_line
from reports.rendering import round_down, triangles

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot

Array = NDArray[np.float64]
Report = Callable[[int, int | None, str], None]

# Half the width of the window over the largest contact half-width, and its height over its width.
_WIDTH, _FLATNESS = 1.7, 0.585
# Largest exaggerated motion over the window's half-width.
_SHOWN = 0.16


def close_ups(solution: FiniteElementSolution, snapshots: Iterable[Snapshot]) -> CloseUps:
    """Cut every snapshot down to the contact, and choose what is fixed over the film: window, exaggeration, colour scales."""
    half = _WIDTH * float(np.nanmax(solution.contact_half_width))
    bodies: tuple[Close, Close] | None = None
    kept: list[NDArray[np.int64]] = []
    views = []
    for snapshot in snapshots:
        if bodies is None:
            kept = [_near(body, 1.25 * half) for body in snapshot.bodies]
            first, second = (_close(solution, k, body, kept[k]) for k, body in enumerate(snapshot.bodies))
            bodies = (first, second)
        views.append(_view(solution, snapshot, kept))
    if bodies is None:
        raise ValueError("an animation needs an instant at least")
    middle = bodies[0].surface[np.argmin(np.abs(bodies[0].points[bodies[0].surface, 0]))]
    origin = np.mean([view.displacement[0][middle] for view in views], axis=0)
    factor = _exaggeration(bodies, views, origin, half)
    largest = tuple(
        max(float(np.abs(getattr(view, name)[k]).max()) for view in views for k in (0, 1)) or 1.0 for name in ("von_mises", "shear")
    )
    return CloseUps(bodies, tuple(views), half, _FLATNESS * half, origin, factor, (largest[0], largest[1]))


def frames_of(
    solution: FiniteElementSolution, shots: CloseUps, report: Report = lambda _done, _total, _text: None
) -> Iterator[NDArray[np.uint8]]:
    """Pictures (720, 1280, 3) of every instant; axes, words and scales are drawn once, and only what moves anew."""

    stage = animation_stage.set_up(solution, shots)
    canvas = FigureCanvasAgg(stage.figure)
    canvas.draw()
    still = canvas.copy_from_bbox(stage.figure.bbox)
    for number, view in enumerate(shots.views):
        report(number, len(shots.views), f"time {solution.time[view.step]:.6g}")
        canvas.restore_region(still)
        animation_stage.draw(stage, solution, shots, view)
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()
    report(len(shots.views), len(shots.views), f"{len(shots.views)} frames")


def _near(body: BodyFields, half: float) -> NDArray[np.int64]:
    """Nodes of the elements that reach into the square of half-width `half` around the contact."""
    inside = np.abs(body.points).max(axis=1) < half
    return np.unique(body.cells[inside[body.cells].any(axis=1)])


def _close(solution: FiniteElementSolution, part: int, body: BodyFields, kept: NDArray[np.int64]) -> Close:
    """The kept nodes of a body, its elements among them as triangles, its contact face."""
    inside = np.isin(body.cells, kept).all(axis=1)
    surface = contact_line(solution.bodies[part])
    face = contact_line(solution.bodies[part], ("contact", "free"))
    points = body.points[kept]
    scene = solution.scene
    if scene.bodies.faces_are_true:
        shape = np.interp(points[:, 0], *body.points[face].T)
    else:
        shape = np.asarray(scene.profile.height(points[:, 0])) if body.name == "upper" else np.zeros(len(points))
    return Close(
        body.name,
        points,
        shape,
        int(scene.bodies.faces_are_true),
        np.searchsorted(kept, triangles(body.cells[inside])),
        np.searchsorted(kept, surface[np.isin(surface, kept)]),
        np.searchsorted(kept, face[np.isin(face, kept)]),
    )


def _view(solution: FiniteElementSolution, snapshot: Snapshot, kept: list[NDArray[np.int64]]) -> View:
    lower, upper = snapshot.bodies
    return View(
        int(np.argmin(np.abs(solution.time - snapshot.time))),
        (lower.displacement[kept[0]], upper.displacement[kept[1]]),
        (lower.von_mises[kept[0]], upper.von_mises[kept[1]]),
        (lower.stress[kept[0], 2], upper.stress[kept[1], 2]),
    )


def _exaggeration(bodies: tuple[Close, Close], views: list[View], origin: Array, half: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that moves no node of a face, and opens no gap, by more than is to be seen."""
    most = 0.0
    for view in views:
        for body, displacement in zip(bodies, view.displacement, strict=True):
            moved = displacement[body.surface] - origin
            moved[:, 1] += body.shape[body.surface]
            most = max(most, float(np.abs(moved).max()))
    return max(round_down(_SHOWN * half / most), 1.0) if most else 1.0
