"""The cycle as a film: deformed bodies at the contact with von Mises' and the shear stress, tractions and the P-Q point beneath.

Every frame is a figure of the chart engine; GIF by Pillow with one palette for all frames, MP4 by imageio-ffmpeg's if it is there.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import STATE_KEYS, Axis, Cell, Curve, Dot, Key, Mark, Panel, Plate, Rule, Segments, colour_scale, limits
from reports.charts.publication import pixels_of
from reports.field_output.files import contact_line
from reports.field_output.pictures import Skin, gap_share, outermost, rendered, round_down, state_blocks
from reports.units import load_unit, minus, number, units
from scenes import InputError

if TYPE_CHECKING:
    from PIL.Image import Image

    from halfplane_fe import BodyFields, FiniteElementSolution, Snapshot

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Frame = NDArray[np.uint8]

RATE = 12  # frames a second
# Half the width of the window over the largest contact half-width; largest exaggerated motion over half the window's width.
_WIDTH, _SHOWN = 1.7, 0.16
_SIZE, _PIXELS = (480.0, 330.0), 440  # of a panel of stress, in units of a drawing, and of what is rendered in it
_TICKS = 15  # material lines on each face of a window


@dataclass(frozen=True, eq=False)
class Close:
    """A body near the contact at an instant.

    Attributes
    ----------
    points, displacement : (n, 2) [length]
    shape : (n,) height of the untouched face at the node's x: its part of the gap [length]
    in_mesh : whether the mesh itself has that shape
    cells : elements; face : nodes that may touch and the free ones beside them, from left to right
    stresses : von Mises' and the shear stress, (n,) each [stress]
    """

    points: Array
    displacement: Array
    shape: Array
    in_mesh: bool
    cells: Indices
    face: Indices
    stresses: tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class Views:
    """All instants, and what holds for the whole film: half-width of the window, exaggeration and its origin, colour scales."""

    steps: Indices
    bodies: tuple[tuple[Close, ...], ...]
    half_width: float
    origin: Array
    factor: float
    largest: tuple[float, float]

    def places(self, body: Close) -> Array:
        """Where the nodes are drawn: displacements and gap both times `factor`, so that faces touch where they do."""
        moved = body.points + self.factor * (body.displacement - self.origin)
        moved[:, 1] += (self.factor - body.in_mesh) * body.shape
        return np.asarray(moved)


def views_of(solution: FiniteElementSolution, snapshots: Iterable[Snapshot]) -> Views:
    """Cut every snapshot down to the contact, and choose what holds for the whole film."""
    half = _WIDTH * outermost(solution)
    steps, bodies = [], []
    for snapshot in snapshots:
        steps.append(int(np.argmin(np.abs(solution.time - snapshot.time))))
        bodies.append(tuple(_close(solution, k, body, 1.25 * half) for k, body in enumerate(snapshot.bodies)))
    everything = [body for pair in bodies for body in pair]
    lower = bodies[0][0]
    middle = lower.face[np.argmin(np.abs(lower.points[lower.face, 0]))]
    origin = np.mean([pair[0].displacement[middle] for pair in bodies], axis=0)
    # The largest of 1, 2, 5 times a power of ten that moves no node of a face, and opens no gap, by more than is to be seen.
    most = 0.0
    for body in everything:
        face = body.face[np.abs(body.points[body.face, 0]) < half]
        moved = body.displacement[face] - origin + np.outer(body.shape[face], (0.0, 1.0))
        most = max(most, float(np.abs(moved).max()))
    factor = max(round_down(_SHOWN * half / most), 1.0) if most else 1.0
    largest = [max(float(np.abs(body.stresses[k]).max()) for body in everything) or 1.0 for k in (0, 1)]
    return Views(np.array(steps), tuple(bodies), half, origin, factor, (largest[0], largest[1]))


def _close(solution: FiniteElementSolution, part: int, body: BodyFields, half: float) -> Close:
    """The elements of a body that reach into the square of half-width `half` around the contact."""
    inside = (np.abs(body.points).max(axis=1) < half)[body.cells].any(axis=1)
    kept = np.unique(body.cells[inside])
    face = contact_line(solution.bodies[part], ("contact", "free"))
    points, true = body.points[kept], solution.scene.bodies.faces_are_true
    shape = np.interp(points[:, 0], *body.points[face].T) if true else gap_share(solution, body)[kept]
    cells, nodes = np.searchsorted(kept, body.cells[inside]), np.searchsorted(kept, face[np.isin(face, kept)])
    return Close(points, body.displacement[kept], shape, true, cells, nodes, (body.von_mises[kept], body.stress[kept, 2]))


def frames_of(
    solution: FiniteElementSolution, views: Views, report: Callable[[int, int | None, str], None] = lambda _d, _t, _w: None
) -> Iterator[Frame]:
    """Pictures (height, width, 3) of every instant, all of one size, with an even number of pixels each way."""
    for k, step in enumerate(views.steps):
        report(k, len(views.steps), f"time {solution.time[step]:.6g}")
        frame = pixels_of(_figure(solution, views, k))
        yield frame[: len(frame) // 2 * 2, : frame.shape[1] // 2 * 2]
    report(len(views.steps), len(views.steps), f"{len(views.steps)} frames")


def _figure(solution: FiniteElementSolution, views: Views, k: int) -> Plate:
    """The frame of instant `k`: both stresses with their colours, the tractions, and the point in the plane of the loads."""
    scene, step, half = solution.scene, int(views.steps[k]), views.half_width
    _, length, stress = units(scene)
    load = load_unit(scene)
    normal, tangential = (float(series[step]) for series in (solution.normal_load, solution.tangential_load))
    now = minus(f"t = {solution.time[step]:.4f}   P = {normal:.4g} {load}   Q = {tangential:.4g} {load}")
    names = ("von Mises stress", "shear stress τxy")
    titles = (f"{scene.name}: displacements and gap × {number(views.factor)}", now)
    cells: list[Panel | Cell] = []
    for which, (name, title) in enumerate(zip(names, titles, strict=True)):
        high = views.largest[which]
        low, colours = (-high, "RdBu_r") if which else (0.0, "viridis")
        skins, over = [], list[Mark]()
        for side, body in zip((-1, 1), views.bodies[k], strict=True):
            places = views.places(body)
            skins.append(Skin(places, body.cells, body.stresses[which], (low, high), colours))
            face = places[body.face]
            wanted = np.linspace(-half, half, _TICKS)
            ticks = face[np.unique(np.abs(body.points[body.face, 0] - wanted[:, None]).argmin(axis=1))]
            over.append(Curve(face[:, 0], face[:, 1], ""))
            over.append(Segments(np.stack([ticks, ticks + np.array([0.0, 0.04 * side * half])], axis=1), ""))
        window = (-half, half, -0.5 * half, 0.5 * half)
        panel = rendered(f"film-{which}", window, skins, _PIXELS, over, length, title, alt=name, size=_SIZE)
        colours_of = colour_scale(f"film-{which}-colours", low, high, f"{name}  [{stress}]", colours, width=_SIZE[0])
        cells.append(Cell((panel, colours_of), None))
    keys = (Key("r p", "pressure p"), Key("f p", "shear q on the lower body"), Key("cone", "± f p"), *STATE_KEYS)
    panels = (*cells, _tractions(solution, views, step), _loads(solution, step))
    return Plate("frame", scene.title or scene.name, "", "", panels, {}, keys)


def _tractions(solution: FiniteElementSolution, views: Views, step: int) -> Panel:
    """Pressure and shear over x between the friction limits, and a strip of states below; one scale for the whole film."""
    _, length, stress = units(solution.scene)
    friction, half = solution.scene.friction.coefficient, views.half_width
    top = float(solution.pressure[views.steps].max()) or 1.0
    low = min(-friction, -0.2) * top
    marks: list[Mark] = [*state_blocks(solution, step, half, low - 0.2 * (top - low), low - 0.08 * (top - low)), Rule(0.0, "zero")]
    marks += [Curve(solution.x, sign * friction * solution.pressure[step], "cone") for sign in (1, -1) if friction]
    marks += [Curve(solution.x, solution.pressure[step], "r p"), Curve(solution.x, solution.shear[step], "f p")]
    axes = Axis(-half, half, f"x  [{length}]"), Axis(low - 0.24 * (top - low), 1.06 * top, f"traction  [{stress}]")
    return Panel("film-tractions", *axes, marks, "Tractions", _SIZE[0], 270.0)


def _loads(solution: FiniteElementSolution, step: int) -> Panel:
    """The cycle in the plane of the loads with the Coulomb limit, and the point that moves along it."""
    normal, tangential, cycle = solution.normal_load, solution.tangential_load, solution.last_cycle
    friction, unit = solution.scene.friction.coefficient, load_unit(solution.scene)
    top = 1.1 * float(normal.max())
    marks: list[Mark] = [Curve([0, top], [0, sign * friction * top], "cone") for sign in (1, -1) if friction]
    marks.append(Curve(normal[: cycle[0] + 1], tangential[: cycle[0] + 1], "faint"))
    marks += [Curve(normal[cycle], tangential[cycle], "d p"), Dot(float(normal[step]), float(tangential[step]), "event", 5.0)]
    axes = Axis(0.0, top, f"P  [{unit}]"), Axis(*limits(tangential, zero=True, least=0.2 * top), f"Q  [{unit}]")
    return Panel("film-loads", *axes, marks, "Loads", _SIZE[0], 270.0, "loads; dotted: |Q| = f P")


@dataclass(frozen=True)
class Film:
    """What was written: names of files, (width, height) in pixels of the GIF, sentences for the user."""

    files: list[str]
    size: tuple[int, int]
    notes: list[str]


@contextmanager
def _movie(ffmpeg: str, file: Path, width: int, height: int) -> Iterator[IO[bytes]]:
    """Takes the bytes of each frame: H.264 in the form that every browser plays. InputError where ffmpeg says that it failed."""
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(RATE), "-i", "-"]
    coded = ["-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]
    words, said = [ffmpeg, "-v", "error", "-y", *raw, *coded, str(file)], b""
    process = subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
    assert process.stdin is not None
    broken = True
    try:
        with suppress(BrokenPipeError):  # ffmpeg ended first, and says why
            yield process.stdin
            broken = False
        said = process.communicate()[1]
    finally:
        if process.returncode is None:
            process.kill()
            process.communicate()
    if process.returncode or said or broken:
        why = (said.decode(errors="replace").strip().splitlines() or [f"exit code {process.returncode}"])[-1]
        raise InputError(f"{file.name}: ffmpeg could not write the film: {why}")


def write_film(frames: Iterable[Frame], folder: Path, name: str) -> Film:
    """Write name.gif, and name.mp4 where imageio-ffmpeg is installed; frames are (height, width, 3), all of one size."""
    from PIL.Image import Dither, Quantize
    from PIL.Image import fromarray as picture_of

    files, notes, ffmpeg = [f"{name}.gif"], [], None
    try:
        import imageio_ffmpeg

        ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
        files.append(f"{name}.mp4")
    except (ImportError, RuntimeError) as reason:
        notes.append(f"no MP4: {reason}; pip install halfplane[animation] brings what it needs")
    rest = iter(frames)
    pictures: list[Image] = []
    first = next(rest)
    palette = picture_of(first).quantize(255, Quantize.MAXCOVERAGE)  # every colour: both scales and the legend stand in each frame
    height, width, _ = first.shape
    with _movie(ffmpeg, folder / files[1], width, height) if ffmpeg else nullcontext() as movie:
        for frame in chain([first], rest):
            pictures.append(picture_of(frame).quantize(palette=palette, dither=Dither.NONE))  # so that what stays costs nothing
            if movie is not None:
                movie.write(frame.tobytes())
    more = pictures[1:]
    pictures[0].save(folder / files[0], save_all=True, append_images=more, duration=round(1000 / RATE), loop=0, optimize=False)
    return Film(files, pictures[0].size, notes)
