"""What a mesh is asked to be and what it is: settings, grading, the meshed body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import skfem

from scenes import InputError
from scenes.errors import present_name

Cells = Literal["triangles", "quadrilaterals"]


@dataclass(frozen=True)
class MeshSettings:
    """How a body is cut; lengths over the contact half-width a at the largest load, found by the FE side's own coarse run.

    Attributes
    ----------
    element_size : surface elements where p and q are smooth
    edge_element_size : surface elements where the contact and stick edges travel
    upper_ratio : surface elements of the upper body over those of the lower; 1 for matching sides
    far_radius : radius L of the half-disc that stands for a half-plane
    growth : growth of the element size with the distance from the contact
    order : 1 or 2, of elements and geometry
    cells : "triangles" or "quadrilaterals"
    """

    element_size: float = 1 / 24
    edge_element_size: float = 1 / 160
    upper_ratio: float = 1.0
    far_radius: float = 10.0
    growth: float = 0.2
    order: int = 2
    cells: Cells = "triangles"

    def __post_init__(self) -> None:
        for name in ("element_size", "edge_element_size"):
            if not 1e-4 <= getattr(self, name) <= 0.25:
                raise InputError(f"mesh: {name} = {getattr(self, name)!r} is refused: it lies in [0.0001, 0.25], in half-widths")
        if self.edge_element_size > self.element_size:
            raise InputError(
                f"mesh: edge_element_size = {self.edge_element_size!r} is refused: "
                f"it is at most element_size = {self.element_size!r}"
            )
        if not 0.05 <= self.upper_ratio <= 20:
            raise InputError(f"mesh: upper_ratio = {self.upper_ratio!r} is refused: it lies in [0.05, 20]")
        if not 2 <= self.far_radius <= 1000:
            raise InputError(f"mesh: far_radius = {self.far_radius!r} is refused: it lies in [2, 1000], in half-widths")
        if not 0.02 <= self.growth <= 1:
            raise InputError(f"mesh: growth = {self.growth!r} is refused: it lies in [0.02, 1]")
        if self.order not in (1, 2):
            raise InputError(f"mesh: order = {self.order!r} is refused: it is 1 or 2")
        if self.cells not in ("triangles", "quadrilaterals"):
            raise InputError(f"mesh: cells = {self.cells!r} is refused: they are triangles or quadrilaterals")

    @classmethod
    def coarse(cls) -> MeshSettings:
        """For a first look: a fifth of a second; shear of partial slip to about 1 % in L2 (benchmarks/fe_peers.py)."""
        return cls(element_size=1 / 8, edge_element_size=1 / 32, far_radius=6.0, growth=0.5)

    @classmethod
    def swift(cls) -> MeshSettings:
        """The old name of `coarse`."""
        present_name("swift")
        return cls.coarse()

    @classmethod
    def fine(cls) -> MeshSettings:
        """For a figure to rely on: some twenty seconds; dissipation of the paper's cycle to 1e-4 (benchmarks/fe_precision.py)."""
        return cls(edge_element_size=1 / 640, growth=0.12)


@dataclass(frozen=True)
class SurfaceGrading:
    """Where the surface is fine: elements of `edge_size` on inner <= |x| <= outer, of `size` on |x| < inner [length].

    `outer` bounds the nodes that may touch; `radius` is that of the half-disc, infinite for a body with a size of its own.
    """

    inner: float
    outer: float
    size: float
    edge_size: float
    radius: float = math.inf

    def drawn_for(self, cells: Cells) -> SurfaceGrading:
        """What is drawn before elements are cut: for quadrilaterals twice the size, which cutting in four halves again."""
        return self if cells == "triangles" else replace(self, size=2 * self.size, edge_size=2 * self.edge_size)


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """One meshed body in its own frame: x along the surface, first contact at the origin, y out of the body.

    Attributes
    ----------
    name : for headings and files
    mesh : skfem mesh with the boundary "contact", those that are supported, and "free"
    grading : the surface as it was asked for
    quality : figure by name; see `mesh_quality`
    supports : boundary -> "half_plane" (follows the displacement of the half-plane around it), "fixed", "rollers" (moves along x
        only) or "guided" (along y only)
    """

    name: str
    mesh: skfem.Mesh
    grading: SurfaceGrading
    quality: Mapping[str, float]
    supports: Mapping[str, str] = field(default_factory=lambda: {"far_field": "half_plane"})
