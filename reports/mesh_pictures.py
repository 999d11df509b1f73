"""The picture of the meshes: whole and at the contact, boundaries in colours and named."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from reports.drawing import BODY_COLOURS, QUIET, SUPPORT_WORDS, canvas
from reports.panels import PIXELS, around, at_contact, boundary_lines, panels, show, title_of
from reports.rendering import Skin, picture

if TYPE_CHECKING:
    from halfplane_fe import BodyFields, FiniteElementSolution
    from meshes import BodyMesh

BOUNDARY_COLOURS = {"contact": "#D55E00", "free": "#009E73", "sides": "#CC79A7", "base": "#0072B2", "far_field": "#5B2A86"}


def mesh_picture(solution: FiniteElementSolution, bodies: tuple[BodyFields, BodyFields]) -> Figure:
    """Both meshes, whole and at the contact, with the boundaries in colours and named."""
    skins = [Skin(body.points, body.cells, BODY_COLOURS[body.name], edges=0.45) for body in bodies]
    reach = solution.bodies[0].grading.outer
    windows = (around([body.points for body in bodies], 0.04), at_contact(1.6 * reach))
    lines = {
        body.name: boundary_lines(mesh, body, 1.0 if body.name == "lower" else -1.0)
        for mesh, body in zip(solution.bodies, bodies, strict=True)
    }
    with canvas(13.0, 7.6) as figure:
        whole, zoom = panels(figure, windows, bottom=0.2)
        for axes, window, title in ((whole, windows[0], "whole bodies"), (zoom, windows[1], "at the contact")):
            show(axes, picture(skins, window, PIXELS), window, solution.scene, title)
            for name in ("lower", "upper"):
                for boundary, chains in lines[name].items():
                    axes.add_collection(LineCollection(chains, colors=BOUNDARY_COLOURS[boundary], lw=2.2, capstyle="butt"))
        figure.suptitle(f"{title_of(solution.scene)}: finite-element meshes", x=0.055, ha="left", fontsize=12)
        figure.legend(
            handles=_boundary_legend(solution.bodies, list(lines["lower"] | lines["upper"])),
            loc="lower left",
            bbox_to_anchor=(0.05, 0.04),
            ncols=4,
            fontsize=9,
        )
        figure.text(0.057, 0.022, _mesh_words(solution.bodies), fontsize=9, color=QUIET)
    return figure


def _boundary_legend(bodies: Sequence[BodyMesh], names: Sequence[str]) -> list[Any]:
    """A line for each boundary with what holds it, and a patch for each body."""
    handles: list[Any] = [Patch(color=colour, label=f"{name} body") for name, colour in BODY_COLOURS.items()]
    handles += [
        Line2D([], [], color=BOUNDARY_COLOURS[name], lw=2.5, label=f"{name.replace('_', ' ')}{_held(bodies, name)}")
        for name in names
    ]
    return handles


def _held(bodies: Sequence[BodyMesh], boundary: str) -> str:
    """How each body's boundary is held, in words."""
    if boundary == "contact":
        return " (may touch)"
    words = [SUPPORT_WORDS.get(body.supports.get(boundary, ""), "free") for body in bodies if boundary in body.mesh.boundaries]
    if boundary == "free" or not words:
        return ""
    if len(set(words)) == 1:
        return f" ({words[0]})"
    return f" (lower {words[0]}, upper {words[1]})"


def _mesh_words(bodies: Sequence[BodyMesh]) -> str:
    """Counts and quality of both meshes in a line."""
    return "   ".join(
        f"{name}: {body.quality['elements']:.0f} elements, least angle {body.quality['least_angle']:.1f}°, "
        f"area error {body.quality['area_error']:.1e}."
        for name, body in zip(("lower", "upper"), bodies, strict=True)
    )
