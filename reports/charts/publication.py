"""Figures as files of publication quality: matplotlib draws the marks of the page's own panels. Nothing is described twice."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.marks import Arrow, Band, Bitmap, Block, Curve, Dot, Group, Mark, Note, Rule, Segments
from reports.charts.plate import LINE, Panel, Plate, arranged, outlines, tick_pairs
from reports.charts.style import pieces, style_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    quiet = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": "halfplane"}}
    with mpl.rc_context(STYLE | {"pdf.fonttype": 42, "svg.fonttype": "none", "font.family": "DejaVu Sans"}):
        figure = figure_of(plate)
        for kind in formats:
            stream = io.BytesIO()
            figure.savefig(stream, format=kind, dpi=_DOTS, metadata=quiet[kind])
            found[kind] = stream.getvalue()
    return found


def pixels_of(plate: Plate) -> NDArray[np.uint8]:
    """The picture of a figure, (height, width, 3), at 108 dots an inch: nine eighths of the page's."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with mpl.rc_context(STYLE | {"font.family": "DejaVu Sans"}):
        figure = figure_of(plate)
        figure.set_dpi(108)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def figure_of(plate: Plate) -> Figure:
    """The figure, everything where `arranged` puts it."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Rectangle

    paper = arranged(plate)
    figure = Figure(figsize=(paper.width * _INCH, paper.height * _INCH))

    def place(x: float, y: float) -> tuple[float, float]:
        return x / paper.width, 1 - y / paper.height

    for key, left, top in paper.keys:
        if key.patch:
            x, y = place(left + 4, top + 12)
            figure.add_artist(Rectangle((x, y), 16 / paper.width, 10 / paper.height, **_area(f"{key.css} patch")))
        else:
            (x0, y0), (x1, _) = place(left, top + 7), place(left + 24, top + 7)
            figure.add_artist(Line2D([x0, x1], [y0, y0], transform=figure.transFigure, **_line(f"curve {key.css}")))
        figure.text(*place(left + 30, top + 11), _words(key.text), **_text("word"))
    for panel, left, top in paper.panels:
        frame = panel.frame
        start, above, end, below = frame.box
        size = (end - start) / paper.width, (below - above) / paper.height
        axes = figure.add_axes((*place(left + start, top + below), *size))
        _axes(axes, panel)
        for mark in panel.marks:
            _draw(axes, mark)
        lines = [*([(panel.title, "title")] if panel.title else []), *((note, "measure") for note in panel.notes)]
        for k, (text, css) in enumerate(reversed(lines)):
            figure.text(*place(left + (start if css == "title" else 24), top + above - 7 - LINE * k), _words(text), **_text(css))
        if panel.y.words and not panel.bare:
            middle = place(left + 12, top + (above + below) / 2)
            figure.text(*middle, _words(panel.y.words), rotation=90, rotation_mode="anchor", ha="center", **_text("name"))
        if panel.x.words and not panel.bare:
            figure.text(*place(left + (start + end) / 2, top + below + 36), _words(panel.x.words), ha="center", **_text("name"))
    return figure


def _axes(axes: Axes, panel: Panel) -> None:
    """Limits, ticks and frame of a panel."""
    scales = panel.frame
    axes.set(xlim=(scales.x.low, scales.x.high), ylim=(scales.y.low, scales.y.high))
    if panel.bare:
        axes.set_axis_off()
        return
    axes.set(xscale="log" if panel.x.log else "linear", yscale="log" if panel.y.log else "linear")
    for spine in axes.spines.values():
        spine.set(color=style_of("axis")["stroke"], linewidth=_POINT)
    axes.tick_params(length=0, pad=5, colors=style_of("tick")["fill"], labelsize=_POINT * 11.5)
    for which, axis, scale in ((axes.xaxis, panel.x, scales.x), (axes.yaxis, panel.y, scales.y)):
        pairs = tick_pairs(axis, scale)
        which.set_ticks([number for number, _ in pairs], labels=[_words(text) for _, text in pairs])
        which.set_ticks([], minor=True)


def _draw(axes: Axes, mark: Mark) -> None:
    """A mark in axes that have their limits already."""
    from matplotlib.patches import PathPatch, Rectangle
    from matplotlib.path import Path

    match mark:
        case Curve():
            x, y = np.asarray(mark.x, dtype=float), np.asarray(mark.y, dtype=float)
            css = f"curve {mark.css}"
            if _area(css)["facecolor"] != "none":
                axes.fill(x, y, **_area(css))
            elif mark.closed:
                axes.plot([*x, x[0]], [*y, y[0]], **_line(css))
            else:
                axes.plot(x, y, **_line(css))
        case Band():
            for x, y in outlines(mark):
                axes.fill(x, y, **_area(f"band {mark.css}"))
        case Segments():
            look, limits = _line(f"curve {mark.css}"), (axes.get_xlim(), axes.get_ylim())
            low, high = mark.ends.min(axis=1), mark.ends.max(axis=1)
            seen = np.all([(high[:, k] >= min(end)) & (low[:, k] <= max(end)) for k, end in enumerate(limits)], axis=0)
            path = Path(mark.ends[seen].reshape(-1, 2), [Path.MOVETO, Path.LINETO] * int(seen.sum()))
            axes.add_patch(PathPatch(path, fill=False, edgecolor=look["color"], linewidth=look["linewidth"]))
        case Dot():
            look = _area(mark.css)
            face, edge, width = mark.fill or look["facecolor"], look["edgecolor"], look["linewidth"]
            style = {"markerfacecolor": face, "markeredgecolor": edge if width else "none", "markeredgewidth": width}
            axes.plot([mark.x], [mark.y], "o", markersize=2 * _POINT * mark.radius, **style)
        case Rule():
            (axes.axvline if mark.upright else axes.axhline)(mark.at, **_line(mark.css))
        case Block():
            look = _area(mark.css) | ({"facecolor": mark.fill} if mark.fill else {})
            (a, b), (c, d) = mark.x, mark.y
            axes.add_patch(Rectangle((a, c), b - a, d - c, **look))
            if mark.hatched:
                axes.add_patch(Rectangle((a, c), b - a, d - c, fill=False, hatch="////", edgecolor="white", linewidth=0))
        case Bitmap():
            colours = [[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in mark.colours]
            pixels = np.array(colours, dtype=np.uint8)[mark.pixels] if colours else mark.pixels
            axes.imshow(pixels, extent=(*axes.get_xlim(), *axes.get_ylim()), aspect="auto", interpolation="nearest")
        case Note():
            shift, ways = (_POINT * mark.shift[0], -_POINT * mark.shift[1]), {"start": "left", "middle": "center", "end": "right"}
            for k, line in enumerate(mark.text.split("\n")):
                axes.annotate(
                    _words(line), (mark.x, mark.y), xytext=(shift[0], shift[1] - _POINT * LINE * k), textcoords="offset points",
                    ha=ways[mark.anchor], annotation_clip=False, **_text(mark.css),
                )  # fmt: skip
        case Arrow():
            look = _line(f"curve {mark.css}")
            style = {
                "arrowstyle": "-|>",
                "color": look["color"],
                "lw": look["linewidth"],
                "mutation_scale": 9,
                "shrinkA": 0,
                "shrinkB": 0,
            }
            axes.annotate("", mark.end, xytext=mark.start, arrowprops=style, annotation_clip=False)
        case Group():
            for one in mark.marks:
                _draw(axes, one)


def _line(css: str) -> dict[str, Any]:
    """The look of a line, as arguments of matplotlib."""
    look = style_of(css)
    width = _POINT * float(look.get("stroke-width", 1))
    dashes = [float(part) * _POINT / width for part in look.get("stroke-dasharray", "none").replace("none", "").split()]
    ends = {"solid_capstyle": "butt", "dash_capstyle": "butt"} if look.get("stroke-linecap") == "butt" or width > 2 else {}
    line: Any = (0, dashes) if dashes else "-"
    return {
        "color": look.get("stroke", "#000000"),
        "linewidth": width,
        "linestyle": line,
        "alpha": float(look.get("opacity", 1)),
    } | ends


def _area(css: str) -> dict[str, Any]:
    """The look of an area, as arguments of matplotlib."""
    look = style_of(css)
    edge = look.get("stroke", "none")
    width = 0.0 if edge == "none" else _POINT * float(look.get("stroke-width", 1))
    return {"facecolor": look.get("fill", "#000000"), "edgecolor": edge, "linewidth": width, "alpha": float(look.get("opacity", 1))}


def _text(css: str) -> dict[str, Any]:
    look: Mapping[str, str] = style_of(css, text=True)
    weight = "bold" if float(look.get("font-weight", 400)) >= 600 else "normal"
    return {"fontsize": _POINT * float(look["font-size"]), "color": look["fill"], "fontweight": weight, "va": "baseline"}


def _words(text: str) -> str:
    """Words of others are no formulas; subscripts are ours."""
    parts = pieces(text)
    plain = [part.replace("\\", r"\\").replace("$", r"\$") if not low else rf"$_{{\mathrm{{{part}}}}}$" for part, low in parts]
    return "".join(plain)
