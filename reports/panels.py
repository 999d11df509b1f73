"""What pictures of bodies share: two panels with axes and scale bars around what pyvista drew, boundaries as lines, the file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.drawing import literal
from reports.rendering import Window
from reports.units import number, units
from scenes import Scene

if TYPE_CHECKING:
    from halfplane_fe import BodyFields
    from meshes import BodyMesh

Array = NDArray[np.float64]

PIXELS = 1000
# Height of a window over that of what it shows: the scale bar stands below.
_BAR_ROOM = 1.14


def save(figure: Figure, path: Path) -> None:
    """Write a picture as PNG."""
    literal(figure).savefig(path, format="png", dpi=140, metadata={"Software": "halfplane"})


def title_of(scene: Scene) -> str:
    """The scene's title, else its name."""
    return scene.title or scene.name


def panels(
    figure: Figure, windows: Sequence[Window], bottom: float, right: float = 0.985, between: float = 0.16
) -> tuple[Axes, Axes]:
    """Two axes side by side, whole and zoom."""
    whole, zoom = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.055, right=right, top=0.87, bottom=bottom, wspace=between)
    for axes, window in zip((whole, zoom), windows, strict=True):
        axes.set_xlim(window.left, window.right)
        axes.set_ylim(window.bottom, window.top)
        axes.set_aspect("equal")
    return whole, zoom


def around(parts: Sequence[Array], margin: float) -> Window:
    """The square window that holds all `parts`, (n, 2) each, with a margin, and room for the scale bar below them."""
    low, high = np.min([part.min(axis=0) for part in parts], axis=0), np.max([part.max(axis=0) for part in parts], axis=0)
    centre, size = (low + high) / 2, (high - low) * (1 + 2 * margin)
    half = max(size[0], _BAR_ROOM * size[1]) / 2
    centre[1] -= (_BAR_ROOM - 1) * size[1] / 2
    return Window(centre[0] - half, centre[0] + half, centre[1] - half, centre[1] + half)


def at_contact(half: float) -> Window:
    """The square window around the origin of half-width `half` [length]."""
    return Window(-half, half, -half, half)


def show(axes: Axes, image: NDArray[np.uint8], window: Window, scene: Scene, title: str) -> None:
    """A rendered picture in its axes, with ticks, a scale bar and a title."""
    length = units(scene)[1]
    axes.imshow(image, extent=(window.left, window.right, window.bottom, window.top), interpolation="antialiased")
    axes.grid(visible=False)
    axes.set_title(title, fontsize=10.5)
    axes.set_xlabel(f"x [{length}]")
    axes.set_ylabel(f"y [{length}]")
    _scale_bar(axes, window, length)


def _scale_bar(axes: Axes, window: Window, length: str) -> None:
    """A bar of a round length, about a fifth of the window wide, in the lower left corner."""
    about = window.width / 5
    power = 10 ** np.floor(np.log10(about))
    size = max(step * power for step in (1, 2, 5) if step * power <= about)
    left, low = window.left + 0.04 * window.width, window.bottom + 0.035 * window.height
    box = {"boxstyle": "square,pad=0.25", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}
    axes.plot([left, left + size], [low, low], color="white", lw=6, solid_capstyle="butt")
    axes.plot([left, left + size], [low, low], color="black", lw=3.2, solid_capstyle="butt")
    axes.text(left, low + 0.025 * window.height, f"{number(float(size))} {length}", fontsize=9.5, va="bottom", bbox=box)


def boundary_lines(mesh: BodyMesh, body: BodyFields, side: float) -> dict[str, list[Array]]:
    """Boundary -> (2 or 3, 2) places of the nodes along each of its element sides; the upper body reflected."""
    flip = np.array([1.0, side])
    skfem_mesh = mesh.mesh
    n_corners = int(skfem_mesh.facets.max()) + 1
    found = {}
    for name, facets in skfem_mesh.boundaries.items():
        first, last = skfem_mesh.facets[:, facets]
        chain = [first, last] if body.cells.shape[1] in (3, 4) else [first, n_corners + facets, last]
        found[name] = list(np.stack([skfem_mesh.p.T[nodes] for nodes in chain], axis=1) * flip)
    return found
