"""Frames into films: GIF by Pillow with one palette for all frames, MP4 by ffmpeg where it is installed."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from scenes import InputError

if TYPE_CHECKING:
    from PIL.Image import Image

Frame = NDArray[np.uint8]

RATE = 12  # frames a second
LARGEST_GIF = 8_000_000  # bytes; what mail and web pages take
# Times that a film is made smaller: at the last it has 1/300 of its width.
_SHRINKINGS = 20
_COLOURS = 255  # one of the 256 is left to Pillow for "as in the frame before"


@dataclass(frozen=True)
class Film:
    """What was written: names of files, frames a second, (width, height) in pixels of the GIF, sentences for the user."""

    files: list[str]
    rate: int
    size: tuple[int, int]
    notes: list[str]


def write_film(frames: Iterable[Frame], colours: NDArray[np.uint8], folder: Path, name: str) -> Film:
    """Write name.gif, and name.mp4 where imageio and its ffmpeg are installed; frames are (height, width, 3), all of one size.

    `colours`, at most 255 of them (n, 3), are those of the GIF.

    A GIF above `LARGEST_GIF` bytes is written once more at three quarters of the size, and so on; that is told.
    """
    reason, movie = _ffmpeg()
    notes = [reason] if reason else []
    files = [f"{name}.gif"]
    pictures: list[Image] = []
    if movie is None:
        pictures += _indexed(frames, colours)
    else:
        files.append(f"{name}.mp4")
        with _movie(movie, folder / files[1]) as add:
            pictures += _indexed(_each(frames, add), colours)
    size = pictures[0].size
    scaled = pictures
    for power in range(1, _SHRINKINGS + 1):
        if _write_gif(scaled, folder / files[0]) <= LARGEST_GIF:
            break
        scaled = _smaller(pictures, 0.75**power)
    else:
        raise InputError(f"{files[0]}: {len(pictures)} frames take more than 8 MB at every size; --frames: ask for fewer")
    if scaled[0].size != size:
        now, full = (f"{width} x {height}" for width, height in (scaled[0].size, size))
        notes.append(f"{files[0]}: {now} pixels instead of {full}, to stay below 8 MB")
    return Film(files, RATE, scaled[0].size, notes)


def _ffmpeg() -> tuple[str, Any]:
    """Why there is no MP4, and the writer of films; one of the two is empty."""
    try:
        import imageio
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError) as reason:
        return f"no MP4: {reason}; pip install halfplane[animation] brings what it needs", None
    return "", imageio


@contextmanager
def _movie(imageio: Any, path: Path) -> Generator[Any, None, None]:
    """An open MP4 that frames are added to: H.264 in the form that every browser plays."""
    writer = imageio.get_writer(path, format="FFMPEG", mode="I", fps=RATE, codec="libx264", quality=None, pixelformat="yuv420p",
                                ffmpeg_log_level="error", output_params=["-crf", "20", "-movflags", "+faststart"])  # fmt: skip
    try:
        yield writer.append_data
    finally:
        writer.close()


def _each(frames: Iterable[Frame], add: Any) -> Iterator[Frame]:
    for frame in frames:
        add(frame)
        yield frame


def _indexed(frames: Iterable[Frame], colours: NDArray[np.uint8]) -> Iterator[Image]:
    """Frames in the same few colours: without dithering, so that what does not change costs nothing."""
    from PIL import Image

    if len(colours) > _COLOURS:
        raise ValueError(f"{len(colours)} colours; a GIF has room for {_COLOURS} here")
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours.ravel().tolist())
    white = np.flatnonzero((colours == 255).all(axis=1))
    for frame in frames:
        places = np.array(Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE))
        if white.size:
            places[(frame == 255).all(axis=2)] = white[0]  # Pillow takes the nearest colour of a coarse box: white became grey
        picture = Image.fromarray(places)
        picture.putpalette(palette.getpalette() or [])
        yield picture


def _smaller(pictures: list[Image], scale: float) -> list[Image]:
    from PIL import Image

    size = tuple(max(round(scale * side), 1) for side in pictures[0].size)
    return [
        picture.convert("RGB").resize(size, Image.Resampling.LANCZOS).quantize(palette=pictures[0], dither=Image.Dither.NONE)  # type: ignore[arg-type]
        for picture in pictures
    ]


def _write_gif(pictures: list[Image], path: Path) -> int:
    """Write a GIF that repeats for ever; its size in bytes."""
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=round(1000 / RATE), loop=0, optimize=False)
    return path.stat().st_size
