"""The stage of an animation: axes, words and scales that stay, and the artists that move from frame to frame."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.colors import Normalize, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from reports.charts.publication import STYLE
from reports.charts.style import DIFFERENCE, QUIET, REFERENCE, RESULT, STATE_COLOURS, STATE_NAMES
from reports.units import load_unit, number, signed, units
from scenes import SurfaceState

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution

Array = NDArray[np.float64]
Kind = TypeVar("Kind", bound=Artist)

_SIZE, _DPI = (12.8, 7.2), 100
_PANELS = ((0.066, 0.435, 0.378, 0.4), (0.548, 0.435, 0.378, 0.4))
_MAPS = ("viridis", "RdBu_r")
_SHADES = 96  # of each map in a film of few colours
GAP = "#b9b9b9"
_TICKS = 15  # material lines on each face of a window


@dataclass(frozen=True, eq=False)
class Close:
    """The part of a body that is near the contact.

    Attributes
    ----------
    name : "lower" or "upper"
    points : (n, 2) undeformed [length]
    shape : (n,) height of the untouched face at the node's x [length]: its part of the gap
    shape_shown : how many times the mesh itself shows `shape`: 0 for flat faces, 1 for true ones
    triangles : (m, 3); surface : (k,) nodes that may touch, from left to right; face : (l,) those and the free ones beside them
    """

    name: str
    points: Array
    shape: Array
    shape_shown: int
    triangles: NDArray[np.int64]
    surface: NDArray[np.int64]
    face: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class View:
    """An instant: its step; for each body displacement (n, 2) [length], von Mises' and shear stress (n,) [stress]."""

    step: int
    displacement: tuple[Array, Array]
    von_mises: tuple[Array, Array]
    shear: tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class CloseUps:
    """All instants of a film and what they share.

    Attributes
    ----------
    half_width, half_height : of the window around the contact [length]
    origin : (2,) displacement that the exaggeration counts from: the lower body's under the middle, its mean over the instants
    factor : the exaggeration of displacements and gap
    largest : of von Mises' stress and of |shear stress| within the window, over all instants [stress]
    """

    bodies: tuple[Close, Close]
    views: tuple[View, ...]
    half_width: float
    half_height: float
    origin: Array
    factor: float
    largest: tuple[float, float]


def places(body: Close, displacement: Array, shots: CloseUps) -> Array:
    """Where the nodes are drawn: displacements and gap both times `factor`, so that faces touch where they do."""
    moved = body.points + shots.factor * (displacement - shots.origin)
    moved[:, 1] += (shots.factor - body.shape_shown) * body.shape
    return np.asarray(moved)


@dataclass(frozen=True, eq=False)
class Field:
    """A panel of bodies: for each its coloured triangles, its face, and the short lines that go with the material."""

    skins: tuple[tuple[Triangulation, TriMesh], ...]
    faces: tuple[Line2D, ...]
    ticks: tuple[LineCollection, ...]


@dataclass(frozen=True, eq=False)
class Stage:
    """The figure and all that moves in it."""

    figure: Figure
    fields: tuple[Field, Field]
    pressure: Line2D
    shear: Line2D
    limits: tuple[Line2D, Line2D]
    states: LineCollection
    point: Line2D
    words: Text


def colours() -> NDArray[np.uint8]:
    """(n, 3) colours for films that have few: both maps, greys, and the lines' colours in steps towards white."""
    maps = np.vstack([mpl.colormaps[name](np.linspace(0, 1, _SHADES))[:, :3] for name in _MAPS])
    greys = np.linspace(0, 1, 24)[:, None] * np.ones(3)
    lines = to_rgba_array([REFERENCE, RESULT, DIFFERENCE, QUIET, *(STATE_COLOURS[state] for state in SurfaceState), GAP])[:, :3]
    tints = np.vstack([1 - weight * (1 - lines) for weight in (1.0, 0.75, 0.5, 0.25)])
    return np.round(255 * np.unique(np.vstack([maps, greys, tints]), axis=0)).astype(np.uint8)


def set_up(solution: FiniteElementSolution, shots: CloseUps) -> Stage:
    """Everything that stays on the figure, and the moving artists with nothing to show yet."""
    scene = solution.scene
    with mpl.rc_context({**STYLE, "font.size": 10.5, "axes.titlesize": 11.0}):
        figure = Figure(figsize=_SIZE, dpi=_DPI)
        figure.text(0.066, 0.955, f"{scene.title or scene.name}: a cycle of the loads", fontsize=15, va="center", weight="bold")
        words = _moving(figure.text(0.066, 0.908, "", fontsize=12, va="center", family="monospace"))
        exaggeration = f"displacements and gap × {number(shots.factor)}"
        stress = units(scene)[2]
        names = (f"von Mises stress [{stress}]; {exaggeration}", f"shear stress τxy [{stress}]; {exaggeration}")
        fields = tuple(_field(figure, solution, shots, k, name) for k, name in enumerate(names))
        figure.text(0.951, 0.908, "colour scales hold for the whole cycle", fontsize=10.5, va="center", ha="right", color=QUIET)
        pressure, shear, limits, states = _tractions(figure.add_axes((0.066, 0.095, 0.57, 0.225)), solution, shots)
        point = _loads(figure.add_axes((0.745, 0.095, 0.181, 0.225)), solution)
    return Stage(figure, (fields[0], fields[1]), pressure, shear, limits, states, point, words)


def draw(stage: Stage, solution: FiniteElementSolution, shots: CloseUps, view: View) -> None:
    """Put the moving artists where `view` has them, and draw them alone."""
    step, friction = view.step, solution.scene.friction.coefficient
    moved = [places(body, displacement, shots) for body, displacement in zip(shots.bodies, view.displacement, strict=True)]
    for field, values in zip(stage.fields, (view.von_mises, view.shear), strict=True):
        _show_field(field, shots, moved, values)
    stage.pressure.set_ydata(solution.pressure[step])
    stage.shear.set_ydata(solution.shear[step])
    for sign, line in zip((1, -1), stage.limits, strict=True):
        line.set_ydata(sign * friction * solution.pressure[step])
    colours = to_rgba_array([STATE_COLOURS[state] for state in SurfaceState])
    stage.states.set_color(colours[solution.state[step]])
    normal, tangential = float(solution.normal_load[step]), float(solution.tangential_load[step])
    stage.point.set_data([normal], [tangential])
    load = load_unit(solution.scene)
    stage.words.set_text(f"t = {solution.time[step]:8.4f}   P = {signed(normal):>6} {load}   Q = {signed(tangential):>6} {load}")
    parts: list[Artist] = [stage.states, *stage.limits, stage.pressure, stage.shear, stage.point, stage.words]
    for field in stage.fields:
        parts += [*(skin for _, skin in field.skins), *field.ticks, *field.faces]
    for part in parts:
        if part.axes is None:
            stage.figure.draw_artist(part)
        else:
            part.axes.draw_artist(part)


def _show_field(field: Field, shots: CloseUps, moved: list[Array], values: tuple[Array, Array]) -> None:
    for k, body in enumerate(shots.bodies):
        net, skin = field.skins[k]
        net.x[:], net.y[:] = moved[k].T
        skin.set_array(values[k])
        face = moved[k][body.face]
        field.faces[k].set_data(*face.T)
        chosen = _material(body.points[body.face, 0], shots.half_width)
        inward = np.array([0.0, (0.07 if body.name == "upper" else -0.07) * shots.half_height])
        field.ticks[k].set_segments([np.stack([place, place + inward]) for place in face[chosen]])


def _material(x: Array, half: float) -> NDArray[np.int64]:
    """The nodes of a face nearest to places at equal distances, each once."""
    wanted = np.linspace(-half, half, _TICKS)
    wanted = wanted[(wanted >= x[0]) & (wanted <= x[-1])]
    return np.unique(np.abs(x - wanted[:, None]).argmin(axis=1))


def _moving(artist: Kind) -> Kind:
    artist.set_animated(True)
    return artist


def _field(figure: Figure, solution: FiniteElementSolution, shots: CloseUps, which: int, title: str) -> Field:
    """A panel with its colour bar; the same scale over the whole film."""
    axes = figure.add_axes(_PANELS[which])
    axes.set_xlim(-shots.half_width, shots.half_width)
    axes.set_ylim(-shots.half_height, shots.half_height)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_facecolor(GAP)
    axes.set_title(title)
    length = units(solution.scene)[1]
    axes.set_xlabel(f"x [{length}]", labelpad=1)
    if which == 0:
        axes.set_ylabel(f"y [{length}]", labelpad=1)
    else:
        axes.set_yticklabels([])
    largest = shots.largest[which]
    norm = Normalize(-largest if which else 0.0, largest)
    skins, faces, ticks = [], [], []
    for body in shots.bodies:
        # Copied, for its places are overwritten in every frame.
        net = Triangulation(body.points[:, 0].copy(), body.points[:, 1].copy(), body.triangles)
        skin = _moving(TriMesh(net, norm=norm, cmap=_MAPS[which]))
        axes.add_collection(skin, autolim=False)
        skins.append((net, skin))
        faces.append(_moving(axes.plot([], [], color="black", lw=1.1)[0]))
        ticks.append(_moving(LineCollection([], colors="black", lw=1.0)))
        axes.add_collection(ticks[-1], autolim=False)
    figure.colorbar(ScalarMappable(norm, _MAPS[which]), cax=axes.inset_axes((1.015, 0.0, 0.025, 1.0)))
    return Field(tuple(skins), tuple(faces), tuple(ticks))


def _tractions(
    axes: Axes, solution: FiniteElementSolution, shots: CloseUps
) -> tuple[Line2D, Line2D, tuple[Line2D, Line2D], LineCollection]:
    """Pressure and shear over x, the friction limits, and a strip of states below."""
    _, length, stress = units(solution.scene)
    x, steps = solution.x, [view.step for view in shots.views]
    top = float(solution.pressure[steps].max()) or 1.0
    low = min(-solution.scene.friction.coefficient, -0.2) * top
    strip = low - 0.13 * (top - low)
    axes.set_xlim(-shots.half_width, shots.half_width)
    axes.set_ylim(low - 0.2 * (top - low), 1.06 * top)
    axes.set_xlabel(f"x [{length}]", labelpad=1)
    axes.set_ylabel(f"traction [{stress}]")
    states = _moving(LineCollection(_pieces(x, strip), lw=9, capstyle="butt", antialiaseds=False))
    axes.add_collection(states, autolim=False)
    limits = tuple(_moving(axes.plot(x, np.zeros_like(x), color=QUIET, lw=0.9, ls="--")[0]) for _ in range(2))
    pressure = _moving(axes.plot(x, np.zeros_like(x), color=REFERENCE, lw=2.6)[0])
    shear = _moving(axes.plot(x, np.zeros_like(x), color=RESULT, lw=1.8)[0])
    handles = [
        Line2D([], [], color=REFERENCE, lw=2.6, label="pressure p"),
        Line2D([], [], color=RESULT, lw=1.8, label="shear q on the lower body"),
        Line2D([], [], color=QUIET, lw=0.9, ls="--", label="± f p"),
        *(Patch(facecolor=STATE_COLOURS[state], edgecolor="#888888", label=STATE_NAMES[state]) for state in SurfaceState),
    ]
    row = {"bbox_to_anchor": (-0.01, 1.0), "ncols": 7, "fontsize": 9.5, "columnspacing": 1.0, "handlelength": 1.5}
    axes.legend(handles=handles, loc="lower left", **row)
    return pressure, shear, (limits[0], limits[1]), states


def _pieces(x: Array, height: float) -> list[Array]:
    """A piece of a horizontal line around each x, from middle to middle."""
    middles = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    return [np.array([[a, height], [b, height]]) for a, b in itertools.pairwise(middles)]


def _loads(axes: Axes, solution: FiniteElementSolution) -> Line2D:
    """The cycle in the plane of the loads with the friction cone; the point that moves along it."""
    scene = solution.scene
    normal, tangential = solution.normal_load, solution.tangential_load
    cycle, friction = solution.last_cycle, scene.friction.coefficient
    top = 1.1 * float(normal.max())
    reach = 1.3 * max(float(np.abs(tangential).max()), 0.1 * top)
    for sign in (1, -1) if friction else ():
        axes.plot([0, top], [0, sign * friction * top], color=QUIET, lw=0.9, ls="--")
    axes.plot(normal[: cycle[0] + 1], tangential[: cycle[0] + 1], color="#bbbbbb", lw=1.0)
    axes.plot(normal[cycle], tangential[cycle], color=DIFFERENCE, lw=1.6)
    axes.set_xlim(0, top)
    axes.set_ylim(-reach, reach)
    unit = load_unit(scene)
    axes.set_xlabel(f"P [{unit}]", labelpad=1)
    axes.set_ylabel(f"Q [{unit}]")
    axes.set_title("loads; dashed: |Q| = f P", loc="right", fontsize=10.0)
    return _moving(axes.plot([], [], "o", color=RESULT, ms=9, mec="white", mew=1.2)[0])
