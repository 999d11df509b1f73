"""Settings of a mesh, element sizes along the face (grading), and the meshed body.

Also element sizes around the contact side, and the number of nodes of a mesh before it is made.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal

import numpy as np
import skfem
from numpy.typing import ArrayLike

from scenes import InputError
from scenes.array_types import Array

Cells = Literal["triangles", "quadrilaterals"]


@dataclass(frozen=True)
class MeshSettings:
    """How a body is meshed. Lengths are over the contact half-width a at the largest load, which a
    run on a coarse mesh finds.

    Attributes
    ----------
    element_size
        size of the surface elements where p and q are smooth
    edge_element_size
        size of the surface elements where the edges of contact and stick travel
    upper_ratio
        size of the upper body's surface elements over that of the lower one's; 1 for matching sides
    far_radius
        radius L of the half-disc that stands for a half-plane
    growth
        growth of the element size with the distance from the contact
    order
        1 or 2, polynomial order of elements and geometry
    cells
        "triangles" or "quadrilaterals"

    Examples
    --------
    >>> MeshSettings(edge_element_size=1 / 320).far_radius  # finer edges, half-discs of 10 a
    10.0
    """

    LEAST_SIZE: ClassVar[float] = 1e-4  # of both element sizes

    element_size: float = 1 / 24
    edge_element_size: float = 1 / 160
    upper_ratio: float = 1.0
    far_radius: float = 10.0
    growth: float = 0.2
    order: int = 2
    cells: Cells = "triangles"

    def __post_init__(self) -> None:
        """Refuse settings of a mesh outside their ranges. LEAST_SIZE is the least size of elements,
        1e-4 of the contact half-width.

        Raises
        ------
        InputError
            With the allowed range, for the first of these outside it: element sizes (over the
            contact half-width), upper over lower element size, radius of the half-disc (over the
            half-width), growth of the size per distance, polynomial order, form of the elements.
        """
        for name in ("element_size", "edge_element_size"):
            size_over_half_width = getattr(self, name)
            if not self.LEAST_SIZE <= size_over_half_width <= 0.25:
                raise InputError(
                    f"mesh: {name} = {size_over_half_width!r} is refused: it lies in"
                    f" [{self.LEAST_SIZE:g}, 0.25], in half-widths"
                )
        if self.edge_element_size > self.element_size:
            raise InputError(
                f"mesh: edge_element_size = {self.edge_element_size!r} is refused: "
                f"it is at most element_size = {self.element_size!r}"
            )
        if not 0.05 <= self.upper_ratio <= 20:
            raise InputError(
                f"mesh: upper_ratio = {self.upper_ratio!r} is refused: it lies in [0.05, 20]"
            )
        if not 2 <= self.far_radius <= 1000:
            raise InputError(
                f"mesh: far_radius = {self.far_radius!r} is refused: it lies in [2, 1000], in"
                " half-widths"
            )
        if not 0.02 <= self.growth <= 1:
            raise InputError(f"mesh: growth = {self.growth!r} is refused: it lies in [0.02, 1]")
        if self.order not in (1, 2):
            raise InputError(f"mesh: order = {self.order!r} is refused: it is 1 or 2")
        if self.cells not in ("triangles", "quadrilaterals"):
            raise InputError(
                f"mesh: cells = {self.cells!r} is refused: they are triangles or quadrilaterals"
            )

    @classmethod
    def coarse(cls) -> MeshSettings:
        """Settings of a coarse mesh, for a first look: a fifth of a second; shear of partial slip
        to about 1 % in L2 (benchmarks/finite_elements.py).
        """
        return cls(element_size=1 / 8, edge_element_size=1 / 32, far_radius=6.0, growth=0.5)

    @classmethod
    def fine(cls) -> MeshSettings:
        """Settings of a fine mesh, for a number to rely on: twenty seconds; dissipation of the
        paper's cycle to 1e-4 (benchmarks/finite_elements.py).
        """
        return cls(edge_element_size=1 / 640, growth=0.12)

    @classmethod
    def preset(cls, name: str) -> MeshSettings:
        """The settings of that name: "default", "coarse" or "fine".

        >>> MeshSettings.preset("coarse") == MeshSettings.coarse()
        True
        """
        return {"default": cls(), "coarse": cls.coarse(), "fine": cls.fine()}[name]


@dataclass(frozen=True)
class SurfaceGrading:
    """Sizes of the surface elements of a body [length]: `edge_size` on inner <= |x| <= outer, where
    contact and stick edges travel; on |x| < inner they grow inwards up to `size`.

    Attributes
    ----------
    inner, outer
        |x| at which the fine zone of the edges begins and ends; nodes beyond `outer` never touch
    size, edge_size
        of the elements inside and in that zone
    radius
        of the half-disc; infinite for a body with a size of its own
    halvings
        how often the element next to x = 0 is halved, on each side, towards a tip of the profile
    growth
        of the size per distance from `inner`, inwards; infinite for elements of one `size` inside
    """

    inner: float
    outer: float
    size: float
    edge_size: float
    radius: float = math.inf
    halvings: int = 0
    growth: float = math.inf

    def growing_elements(self) -> Array:
        """Lengths (n,) of the elements inside `inner` that are smaller than `size`, outwards from
        the middle; none for infinite growth. They take at most what one element of `size` leaves.
        """
        lengths: list[float] = []
        distance = 0.0  # from `inner` to the outer end of the next element
        while True:
            length = self.edge_size + self.growth * (distance + self.edge_size)
            if length >= self.size or distance + length + self.size > self.inner:
                return np.array(lengths[::-1])
            lengths.append(length)
            distance += length

    @property
    def end_of_middle(self) -> float:
        """|x| up to which elements have about one `size`, and from which on they shrink outwards to
        `edge_size` [length]; 0 where the zone of the edges begins at x = 0.
        """
        return self.inner - float(self.growing_elements().sum())

    @property
    def size_at_middle(self) -> float:
        """Size of the elements at x = 0 [length], before they are halved towards a tip."""
        if self.inner > 0:
            return self.end_of_middle / max(round(self.end_of_middle / self.size), 1)
        return self.outer / max(round(self.outer / self.edge_size), 1)

    @property
    def tip_size(self) -> float:
        """Size of the elements at x = 0 after they are halved towards a tip of the profile
        [length].
        """
        return self.size_at_middle / 2**self.halvings

    def grading_for_gmsh(self, cells: Cells) -> SurfaceGrading:
        """Sizes at which gmsh draws the surface elements: these for triangles, twice these for
        quadrilaterals, since gmsh cuts each of its elements in four at the end.
        """
        if cells == "triangles":
            return self
        return replace(self, size=2 * self.size, edge_size=2 * self.edge_size)


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """One meshed body in its own frame: x along the surface, first contact at the origin, y out of
    the body.

    Attributes
    ----------
    name
        for headings and files
    mesh
        skfem mesh with the boundary "contact", those that are supported, and "free"
    grading
        sizes of the surface elements, as requested
    quality
        name -> measure, see `mesh_quality`
    supports
        boundary -> "half_plane" (follows the displacement of the half-plane around it),
        "fixed", "rollers" (moves along x only), "guided" (along y only) or "pulled" (free ends
        that a bulk stress acts on; those of a body on rollers hold Q)
    """

    name: str
    mesh: skfem.Mesh
    grading: SurfaceGrading
    quality: Mapping[str, float]
    supports: Mapping[str, str] = field(default_factory=lambda: {"far_field": "half_plane"})


# Nodes on the contact: their compliance is a full matrix of (2 n)^2 numbers, 2 GB at the limit.
# Nodes of a body: about 10 kB each while it is assembled and factorised.
MOST_CONTACT_NODES = 8_000
MOST_NODES = 500_000
# Growth of the elements inside the body with the distance from a tip.
_TIP_GROWTH = 0.5
# A body that ends somewhere has less of what is coarse; a radius for it, over the contact's.
_FAR_RADIUS = 1000.0


def number_of_contact_nodes(grading: SurfaceGrading, order: int) -> int:
    """Number of surface nodes that may touch, on |x| <= outer, to a few nodes. `order` is that of
    the elements, 1 or 2.

    The `grading` has elements of about one `size` up to |x| = `inner`, which grow to it from
    `edge_size`, and of `edge_size` from there to `outer`; those next to x = 0 are halved `halvings`
    times.
    """
    n_elements_of_half = (
        grading.end_of_middle / grading.size
        + len(grading.growing_elements())
        + (grading.outer - grading.inner) / grading.edge_size
        + grading.halvings
    )
    return round(2 * n_elements_of_half) * order + 1


def number_of_body_nodes(grading: SurfaceGrading, growth: float, order: int) -> int:
    """Estimate, within a factor of two, of the number of nodes in the mesh of a half-disc.

    Triangles have size h at the surface, and h + g d at distance d from it. Their number is the
    area over that of an equilateral triangle of the size there; with dA = (pi d + L) dd::

        triangles = (4/sqrt 3) int_0^R (pi d + L) / (h + g d)^2 dd

    # notation: L length of surface with elements of one size h; g growth of the size per distance
    d from the surface, dA area at that distance; R radius of the half-disc, r = g R/h

    The zones at the contact edges and between them are summed. A mesh has half as many corners as
    triangles.

    Parameters
    ----------
    grading
        sizes of the surface elements at the contact edges (`edge_size`, |x| from `inner` to
        `outer`) and between (`size`); radius of the half-disc, of which a thousand times `outer`
        counts at most
    growth
        g
    order
        1 or 2: a triangle of order 2 has mid-side nodes, four times as many nodes in all
    """
    n_triangles = 0.0
    g = growth
    for surface_length, h in (
        (2 * (grading.outer - grading.inner), grading.edge_size),
        (2 * grading.inner, grading.size),
    ):
        if surface_length > 0:
            # _FAR_RADIUS: a thousand times `outer`, for bodies that are no half-discs
            r = g * min(grading.radius, _FAR_RADIUS * grading.outer) / h
            # the terms pi d and L of the integrand
            integral_around_ends = math.pi / g**2 * (math.log1p(r) - r / (1 + r))
            integral_below_surface = surface_length / (g * h) * r / (1 + r)
            n_triangles += 4 / math.sqrt(3) * (integral_around_ends + integral_below_surface)
    return round(n_triangles * order**2 / 2)


def require_few_nodes(name: str, grading: SurfaceGrading, growth: float, order: int) -> None:
    """Refuse a mesh with too many nodes for memory, before it is made: more than 8,000 on the
    contact, or more than 500,000 in the body.

    Parameters
    ----------
    name
        "lower" or "upper", the body's name in the message
    grading
        sizes of the surface elements
    growth
        growth of the element size per distance from the contact
    order
        1 or 2, polynomial order of the elements

    Raises
    ------
    InputError
        With the number of nodes and its limit: of those on the contact, or of all in the body.
    """
    advice = "make element_size and edge_element_size larger"
    n_contact_nodes = number_of_contact_nodes(grading, order)
    if n_contact_nodes > MOST_CONTACT_NODES:
        raise InputError(
            f"mesh: the {name} body would have some {n_contact_nodes:,}"
            f" nodes on its contact, and the limit is {MOST_CONTACT_NODES:,}; {advice}"
        )
    n_nodes = number_of_body_nodes(grading, growth, order)
    if n_nodes > MOST_NODES:
        raise InputError(
            f"mesh: the {name} body would have about {n_nodes:,} nodes, and the limit is"
            f" {MOST_NODES:,}; {advice}, or growth"
        )


# Elements around a sharp corner over the one in it. At a corner of a free side with a fixed base
# the displacement goes as r^0.71 (nu = 0.3), and elements of size h there leave an error of h^1.42
# in the tangential displacement: 0.42 % of that of a block 8 a wide and 10 a high without grading,
# 0.017 % with 16, 0.005 % with 64, for a sixth more nodes. At the re-entrant corner of a step it
# goes as r^0.54.
_CORNER_REFINEMENT = 64


def lengths_to_twelve_digits(values: ArrayLike) -> Array:
    """Lengths to twelve digits, any shape: on the last digit gmsh makes another mesh, and the
    answer would depend on the units.
    """
    return np.vectorize(lambda value: float(f"{value:.12g}"), otypes=[float])(values)


def scaled_grading(grading: SurfaceGrading, factor: float) -> SurfaceGrading:
    """The grading with all its lengths times a factor, to twelve digits."""
    values = np.array(
        [grading.inner, grading.outer, grading.size, grading.edge_size, grading.radius]
    )
    inner, outer, size, edge_size, radius = lengths_to_twelve_digits(values * factor).tolist()
    return replace(grading, inner=inner, outer=outer, size=size, edge_size=edge_size, radius=radius)


def surface_points(grading: SurfaceGrading) -> Array:
    """Abscissae x (n,) of the ends of the surface elements on half a contact side, from 0 to
    `grading.outer` [length].

    Elements are `grading.edge_size` long from `grading.inner` on, where edges of contact and stick
    travel. From there inwards they grow to about `grading.size`, by `grading.growth` per distance.
    Where sizes jump by a factor of seven, the shear of unlike bodies is wrong by a tenth of f p.
    Where the profile has a tip at x = 0, the first is halved `grading.halvings` times.

    >>> surface_points(SurfaceGrading(inner=1.0, outer=2.0, size=1.0, edge_size=0.5, halvings=2))
    array([0.  , 0.25, 0.5 , 1.  , 1.5 , 2.  ])
    """
    middle_points = np.linspace(
        0,
        grading.end_of_middle,
        max(round(grading.end_of_middle / grading.size), 1) + 1 if grading.inner > 0 else 1,
    )
    growing_points = grading.end_of_middle + np.cumsum(grading.growing_elements())
    outer_points = np.linspace(
        grading.inner,
        grading.outer,
        max(round((grading.outer - grading.inner) / grading.edge_size), 1) + 1,
    )
    # the last of the inner points is the first of the outer ones
    inner_points = np.concatenate([middle_points, growing_points])
    points = np.concatenate([inner_points[:-1], outer_points])
    points_towards_tip = points[1] / 2.0 ** np.arange(grading.halvings, 0, -1)
    return np.concatenate([points[:1], points_towards_tip, points[1:]])


def size_formula(
    grading: SurfaceGrading, growth: float, sharp_corners: Sequence[tuple[float, float]] = ()
) -> str:
    """Formula in x and y for the element size inside a body (half x >= 0), as text for gmsh's field
    MathEval.

    The size is that of the nearest surface elements plus `growth` times the distance to them. It is
    smaller around a tip of the profile and around sharp corners. gmsh evaluates a text four times
    faster than it calls Python.

    Parameters
    ----------
    grading
        sizes of the surface elements: `edge_size` from |x| = `inner` to `outer`, `size` inside, and
        `tip_size` at x = 0 where elements are halved there (`halvings`)
    growth
        of the element size per distance
    sharp_corners
        (x, y) of corners of the body with infinite strain; y < 0: below the contact side
    """
    # Around the fine zone inner <= x <= outer, where edges of contact and stick travel, and the
    # middle of the contact.
    fine_zone_begin = grading.inner
    fine_zone_end = grading.outer
    formula = (
        f"{grading.edge_size!r} + {growth!r} * Sqrt(Max(Max(x - {fine_zone_end!r},"
        f" {fine_zone_begin!r} - x), 0)^2 + y^2)"
    )
    if fine_zone_begin > 0:
        formula = (
            f"Min({formula}, {grading.size!r} + {growth!r} * Sqrt(Max(x - {fine_zone_begin!r}, 0)^2"
            " + y^2))"
        )
    if grading.halvings:
        # The elements of the surface are as long as they are far from the tip: a growth of 0.5 at
        # least inside the body.
        formula = (
            f"Min({formula}, {grading.tip_size!r} + {max(growth, _TIP_GROWTH)!r} * Sqrt(x^2 + y^2))"
        )

    # Around sharp corners, with elements of a 64th of the surrounding size in them.
    for corner_x, corner_y in sharp_corners:
        depth = -corner_y
        size_without_corner = grading.edge_size + growth * math.hypot(
            max(corner_x - fine_zone_end, 0.0), corner_y
        )
        # No larger than the corner's distances from the axis and from the contact side.
        surrounding_size = min(size_without_corner, corner_x, depth)
        corner_size = float(lengths_to_twelve_digits(surrounding_size / _CORNER_REFINEMENT))
        formula = (
            f"Min({formula}, {corner_size!r} + {corner_growth(growth)!r}"
            f" * Sqrt((x - {corner_x!r})^2 + (y + {depth!r})^2))"
        )
    return formula


def corner_growth(growth: float) -> float:
    """Growth of the element size with the distance from a sharp corner: twice the `growth` from the
    contact, but no more than 0.4; and at least that growth.

    >>> corner_growth(0.12), corner_growth(0.2), corner_growth(0.5)
    (0.24, 0.4, 0.5)
    """
    return max(growth, min(2 * growth, 0.4))
