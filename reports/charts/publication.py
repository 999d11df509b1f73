"""Figures as files of publication quality: the SVG document of a figure, and that document as PDF or PNG, by matplotlib."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from pathlib import Path as File
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import DOWN, Plate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
# A unit of a drawing is a pixel of a style sheet: 1/96 inch, 3/4 of a printer's point.
_INCH, _POINT, _DOTS = 1 / 96, 0.75, 200
# Also of figures that are no plates, in benchmarks and the manual.
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "svg.hashsalt": "halfplane",  # the same data gives the same file
}
_FONTS: dict[Any, Any] = {"font.family": "DejaVu Sans", "pdf.fonttype": 42}
_CODES = {"M": 1, "L": 2, "Z": 79}  # of matplotlib's paths


def write_plots(plates: Iterable[Plate], folder: File, formats: Sequence[str]) -> list[str]:
    """Write each figure in each of `formats`, of "pdf", "svg" and "png"; returns the names of the files, in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    for plate in plates:
        for kind, content in drawn(plate, formats).items():
            names.append(f"{plate.name}.{kind}")
            (folder / names[-1]).write_bytes(content)
    return names


def drawn(plate: Plate, formats: Sequence[str]) -> dict[str, bytes]:
    """Format -> the file of a figure; the same figure gives the same bytes."""
    import matplotlib as mpl

    found = {}
    quiet = {"pdf": {"CreationDate": None}, "png": {"Software": "halfplane"}}
    with mpl.rc_context(_FONTS):
        for kind in formats:
            if kind == "svg":
                found[kind] = plate.svg().encode()
            else:
                stream = io.BytesIO()
                figure_of(plate).savefig(stream, format=kind, dpi=_DOTS, metadata=quiet[kind])
                found[kind] = stream.getvalue()
    return found


def figure_of(plate: Plate) -> Figure:
    """The SVG document of a figure, drawn in one pair of axes whose units are those of the document."""
    from matplotlib.figure import Figure

    document = ET.fromstring(plate.svg())
    width, height = (float(document.attrib[side]) for side in ("width", "height"))
    figure = Figure(figsize=(width * _INCH, height * _INCH))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()
    clips = {one.attrib["id"]: one[0] for one in document.iter() if _name(one) == "clipPath"}
    _Painter(axes, clips).draw(document, np.zeros(2), {})
    return figure


def _name(element: ET.Element) -> str:
    return element.tag.rpartition("}")[2]


class _Painter:
    """Draws the elements of `Plate.svg` in axes, one over the other; `clips` are the rectangles of clips by their name."""

    def __init__(self, axes: Axes, clips: Mapping[str, ET.Element]) -> None:
        self.axes, self.clips, self.order = axes, clips, count()

    def draw(self, element: ET.Element, at: Array, above: Mapping[str, Any]) -> None:
        """An element with all in it; `at` is where its own document begins, `above` the look that it inherits."""
        from matplotlib.patches import PathPatch, Rectangle
        from matplotlib.path import Path

        look = dict(above) | {name: element.attrib[name] for name in ("fill", "stroke") if name in element.attrib}
        look |= {name: value for name, _, value in (one.partition(":") for one in element.get("style", "").split(";")) if name}

        def numbers(*names: str, of: ET.Element = element) -> Array:
            return np.array([float(of.get(name, 0.0)) for name in names])

        place, size = at + numbers("x", "y"), numbers("width", "height")
        match _name(element):
            case "svg":
                for inside in element:
                    self.draw(inside, place, look)
                return
            case "g":
                if clip := element.get("clip-path"):
                    area = self.clips[clip.removeprefix("url(#").removesuffix(")")]
                    corner, sides = at + numbers("x", "y", of=area), numbers("width", "height", of=area)
                    look["clip"] = Rectangle((corner[0], corner[1]), sides[0], sides[1], transform=self.axes.transData)
                for inside in element:
                    self.draw(inside, at, look)
                return
            case "text":
                self.write(element, place + numbers("dx", "dy"), look)
                return
            case "image":
                from PIL import Image

                picture = Image.open(io.BytesIO(base64.b64decode(element.attrib["href"].partition(",")[2]))).convert("RGB")
                extent = (place[0], place[0] + size[0], place[1] + size[1], place[1])
                self.axes.imshow(picture, extent=extent, aspect="auto", interpolation="nearest", zorder=next(self.order))
                return
            case "path":
                letters = re.findall("[MLZ]", element.attrib["d"])
                places = re.sub("[MLZ]", " ", element.attrib["d"].replace("Z", "Z0 0")).split()
                path = Path(np.array(places, dtype=float).reshape(-1, 2) + at, [_CODES[letter] for letter in letters])
            case "line":
                path = Path(numbers("x1", "y1", "x2", "y2").reshape(2, 2) + at)
            case "rect":
                path = Path(place + size * np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]), closed=True)
            case "circle":
                path = Path.unit_circle()
                path = Path(at + numbers("cx", "cy") + numbers("r") * np.asarray(path.vertices), path.codes)
            case _:  # a title, the area of a clip
                return
        width = _POINT * float(look.get("stroke-width", 1))
        dashes = [float(part) * _POINT / width for part in look.get("stroke-dasharray", "none").replace("none", "").split()]
        patch = PathPatch(
            path,
            facecolor=look.get("fill", "#000000"),
            edgecolor=look.get("stroke", "none"),
            linewidth=width,
            linestyle=(0, dashes) if dashes else "-",
            capstyle=look.get("stroke-linecap", "butt"),
            joinstyle=look.get("stroke-linejoin", "miter"),
            alpha=float(look.get("opacity", 1)),
            zorder=next(self.order),
        )
        self.axes.add_artist(patch)
        patch.set_clip_path(look.get("clip"))

    def write(self, element: ET.Element, place: Array, look: Mapping[str, Any]) -> None:
        """A text: words of others are no formulas, subscripts are ours."""
        parts = [(element.text or "", False)]
        for part in element:
            parts += [(part.text or "", part.get("dy") == DOWN), (part.tail or "", False)]
        plain = [(words.replace("\\", r"\\").replace("$", r"\$"), low) for words, low in parts if words]
        x, y = place.tolist()
        self.axes.text(
            x,
            y,
            "".join(rf"$_{{\mathrm{{{words}}}}}$" if low else words for words, low in plain),
            ha={"start": "left", "middle": "center", "end": "right"}[element.get("text-anchor", "start")],
            rotation=90 if "transform" in element.attrib else 0,
            rotation_mode="anchor",
            fontsize=_POINT * float(look["font-size"]),
            color=look.get("fill", "#000000"),
            fontweight="bold" if float(look.get("font-weight", 400)) >= 600 else "normal",
            zorder=next(self.order),
        )
