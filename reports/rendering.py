"""Plane meshes drawn by pyvista, off screen, into arrays of colours; words and axes are put around them elsewhere."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import InputError

Array = NDArray[np.float64]

# Elements of an element with mid-side nodes, and its sides as chains of nodes, by the number of nodes; VTK's order.
_PARTS = {
    3: [[0, 1, 2]],
    6: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    4: [[0, 1, 2, 3]],
    9: [[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]],
}
_OUTLINE = {3: [0, 1, 2, 0], 6: [0, 3, 1, 4, 2, 5, 0], 4: [0, 1, 2, 3, 0], 9: [0, 4, 1, 5, 2, 6, 3, 7, 0]}


@dataclass(frozen=True)
class Window:
    """The part of the plane that a picture shows [length]."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """From left to right [length]."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """From bottom to top [length]."""
        return self.top - self.bottom


@dataclass(frozen=True, eq=False)
class Skin:
    """A mesh to draw: places (n, 2), elements, and either nodal values (n,) with their limits or one colour."""

    points: Array
    cells: NDArray[np.int64]
    colour: str = "#d9d9d9"
    values: Array | None = None
    limits: tuple[float, float] = (0.0, 1.0)
    edges: float = 0.0


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `value`."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)))


def surface(skin: Skin) -> Any:
    """The mesh as pyvista.PolyData of plain triangles or quadrilaterals: those of order 2 cut at their mid-side nodes."""
    import pyvista

    parts = np.vstack([skin.cells[:, part] for part in _PARTS[skin.cells.shape[1]]])
    return pyvista.PolyData(_in_space(skin.points), faces=np.column_stack([np.full(len(parts), parts.shape[1]), parts]).ravel())


def triangles(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """The elements as plain triangles (n, 3): cut at mid-side nodes, quadrilaterals across.

    >>> triangles(np.array([[7, 8, 9, 10]])).tolist()
    [[7, 8, 9], [7, 9, 10]]
    """
    parts = np.vstack([cells[:, part] for part in _PARTS[cells.shape[1]]])
    return parts if parts.shape[1] == 3 else np.vstack([parts[:, [0, 1, 2]], parts[:, [0, 2, 3]]])


def sides(skin: Skin) -> Any:
    """The sides of the elements as pyvista.PolyData of lines, through the mid-side nodes."""
    import pyvista

    loop = _OUTLINE[skin.cells.shape[1]]
    pairs = np.vstack([skin.cells[:, [a, b]] for a, b in itertools.pairwise(loop)])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    lines = np.column_stack([np.full(len(pairs), 2), pairs]).ravel()
    return pyvista.PolyData(_in_space(skin.points), lines=lines)


def picture(skins: Sequence[Skin], window: Window, width: int) -> NDArray[np.uint8]:
    """What `window` shows of the meshes, (height, width, 3); first drawn first.

    Parameters
    ----------
    width : in pixels

    Raises
    ------
    InputError
        Where nothing can be drawn: pyvista or a library that it needs is missing.
    """
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")  # else VTK complains that there is no X server
    try:
        import pyvista
    except (ImportError, OSError) as reason:
        raise InputError(f"pictures can't be drawn: {reason}; `halfplane doctor` says what is missing") from reason

    size = [width, max(round(width * window.height / window.width), 2)]
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=size, lighting="none")
    try:
        plotter.set_background("white")
        for depth, skin in enumerate(skins):
            _add(plotter, skin, 1e-3 * depth * window.height)
        _look_at(plotter, window)
        return np.asarray(plotter.screenshot(None, return_img=True), dtype=np.uint8)
    finally:
        plotter.close()


def _add(plotter: Any, skin: Skin, depth: float) -> None:
    mesh = surface(skin).translate((0, 0, depth))
    if skin.values is None:
        plotter.add_mesh(mesh, color=skin.colour, lighting=False, show_scalar_bar=False)
    else:
        mesh["value"] = skin.values
        options = {"cmap": "viridis", "clim": skin.limits, "show_scalar_bar": False, "lighting": False}
        plotter.add_mesh(mesh, scalars="value", **options)
    if skin.edges:
        lines = sides(skin).translate((0, 0, depth + 1e-3 * abs(depth or 1.0)))
        plotter.add_mesh(lines, color="black", line_width=1, opacity=skin.edges, lighting=False)


def _look_at(plotter: Any, window: Window) -> None:
    x, y = (window.left + window.right) / 2, (window.bottom + window.top) / 2
    camera = plotter.camera
    camera.parallel_projection = True
    camera.focal_point, camera.position, camera.up = (x, y, 0.0), (x, y, 10 * window.height), (0.0, 1.0, 0.0)
    camera.parallel_scale = window.height / 2
    plotter.reset_camera_clipping_range()


def _in_space(points: Array) -> Array:
    return np.column_stack([points, np.zeros(len(points))])
