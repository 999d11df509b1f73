"""A sketch of a scene as a small SVG drawing: bodies to scale and Q over P inside the friction cone. Plain text, no fonts."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from reports.drawing import BODY_COLOURS, QUIET, RESULT
from reports.sketches import Silhouette, loop, silhouettes
from reports.units import load_unit, number
from scenes import Scene

Array = NDArray[np.float64]

_WIDTH, _HEIGHT, _EDGE = 460, 200, 10
_BODIES, _LOADS = 210.0, 190.0
_LINE = "#333333"


def svg(scene: Scene) -> str:
    """The drawing; the same scene gives the same text."""
    words = f"{scene.title or scene.name}: bodies, and tangential over normal load"
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" height="{_HEIGHT}" '
            f'font-family="sans-serif" font-size="10" role="img">',
            f"<title>{_escaped(words)}</title>",
            f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="white"/>',
            *_bodies(scene),
            *_loads(scene),
            "</svg>\n",
        ]
    )


def _bodies(scene: Scene) -> Iterator[str]:
    both = silhouettes(scene)
    points = np.vstack([body.outline for body in both])
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array([_BODIES - 2 * _EDGE, _HEIGHT - 2 * _EDGE - 14])
    scale = float((room / (high - low)).min())
    middle = np.array([_BODIES / 2, (_HEIGHT - 14) / 2])

    def place(line: Array) -> Array:
        return middle + scale * (line - (low + high) / 2) * [1, -1]

    for body, name in zip(both, ("lower", "upper"), strict=True):
        yield from _body(body, place, BODY_COLOURS[name])
    flat = "" if scene.bodies.faces_are_true else ", gap exaggerated"
    size = "" if scene.bodies.half_planes else "to scale"
    yield _text(_BODIES / 2, _HEIGHT - 6, (size + flat).removeprefix(", "), anchor="middle", colour=QUIET)


def _body(body: Silhouette, place: Callable[[Array], Array], colour: str) -> Iterator[str]:
    """Filled; the cut edges of a half-plane have no line, walls on rollers a broad one."""
    edge = "none" if body.half_plane else _LINE
    yield f'<polygon points="{_points(place(body.outline))}" fill="{colour}" stroke="{edge}"/>'
    if body.half_plane:
        yield f'<polyline points="{_points(place(body.face))}" fill="none" stroke="{_LINE}"/>'
    if body.guided:
        corners = place(body.outline[[0, len(body.face) - 1, len(body.face), len(body.face) + 1]])
        for first, last in ((corners[0], corners[3]), (corners[1], corners[2])):
            line = _points(np.array([first, last]))
            yield f'<polyline points="{line}" fill="none" stroke="{_LINE}" stroke-width="4" stroke-dasharray="2 4"/>'


def _loads(scene: Scene) -> Iterator[str]:
    path = loop(scene)
    most = float(path.points[:, 0].max())
    friction = scene.friction.coefficient
    high = max(1.15 * float(np.abs(path.points[:, 1]).max()), 0.25 * friction * most) or 1.0
    left, right, top, bottom = _WIDTH - _LOADS, _WIDTH - 2.5 * _EDGE, 1.5 * _EDGE, _HEIGHT - 3.0 * _EDGE

    def place(points: Array) -> Array:
        across = left + (right - left) * points[:, 0] / (1.08 * most)
        return np.column_stack([across, (top + bottom) / 2 - (bottom - top) / 2 * points[:, 1] / high])

    if friction:
        reach = min(1.08 * most, high / friction)
        cone = place(np.array([[reach, friction * reach], [0, 0], [reach, -friction * reach]]))
        yield f'<polyline points="{_points(cone)}" fill="none" stroke="{QUIET}" stroke-dasharray="1 3"/>'
    axes = place(np.array([[0, 0], [1.08 * most, 0], [0, -high], [0, high]]))
    for pair in (axes[:2], axes[2:]):
        yield f'<polyline points="{_points(pair)}" fill="none" stroke="{QUIET}" stroke-width="0.7"/>'
    yield f'<polyline points="{_points(place(path.initial_loading))}" fill="none" stroke="{RESULT}" stroke-dasharray="4 3"/>'
    yield f'<polyline points="{_points(place(path.cycle))}" fill="none" stroke="{RESULT}" stroke-width="1.8"/>'
    yield from _words(scene, path.points, right, bottom)


def _words(scene: Scene, points: Array, right: float, bottom: float) -> Iterator[str]:
    most, swing = float(points[:, 0].max()), points[:, 1]
    unit = load_unit(scene)
    yield _text(right + 6, (1.5 * _EDGE + bottom) / 2 + 4, "P")
    yield _text(_WIDTH - _LOADS + 5, 1.5 * _EDGE + 4, "Q")
    low, high = (number(float(f"{value:.3g}")) for value in (swing.min(), swing.max()))
    text = (
        f"P up to {number(float(f'{most:.3g}'))}, Q {low} to {high} {unit}"
        if np.ptp(swing)
        else f"P up to {number(float(f'{most:.3g}'))} {unit}"
    )
    yield _text((_WIDTH - _LOADS + right) / 2, _HEIGHT - 6, text, anchor="middle", colour=QUIET)


def _text(x: float, y: float, words: str, anchor: str = "start", colour: str = _LINE) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">{_escaped(words)}</text>'


def _points(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _escaped(words: str) -> str:
    return words.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
