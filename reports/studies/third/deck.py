"""A scene as an input deck: bodies, gap, supports, instants, loads and stiffnesses, and its text
for CalculiX.

`reports/templates/deck.inp` is the deck, and the routines at the end are what it calls for.
"""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from halfplane_fe.interface import meshed_pair
from halfplane_fe.path import has_bulk_stress, stretches
from halfplane_fe.scales import Scales, find_scales
from halfplane_fe.supports import check_bulk_stress, check_supports, has_tangential_load
from halfplane_fe.task import surface_grading
from meshes import BodyMesh, MeshSettings
from reports.charts.templating import template
from scenes import Block, HalfPlane, InputError, LoadPath, Profile, Scene, Shape, read_only_copy
from scenes.array_types import Array
from scenes.frozen import validated

Indices = NDArray[np.int64]

# The longest line that CalculiX reads.
_LONGEST_LINE = 132

# The touch: the deck's first step brings the faces together by a prescribed approach, since load
# control needs contact. It takes this fraction of the first increment of initial loading.
_TOUCH_FRACTION = 0.25
# Increments of the initial loading, over those of a revolution.
_INITIAL_INCREMENTS = 0.25
# Kind of support -> directions (1 along x, 2 along y) in which nodes of its boundary do not move
# against the rigid plane behind it.
_HELD_DIRECTIONS = {
    "fixed": (1, 2),
    "half_plane": (1, 2),
    "rollers": (2,),
    "guided": (1,),
    "pulled": (),
}


@dataclass(frozen=True)
class DeckSettings:
    """Lengths over the contact half-width a at the largest load; stiffnesses over E*/h, h being the
    surface elements at the edges.

    Attributes
    ----------
    element_size, edge_element_size
        surface elements in the middle, and where the contact and stick edges travel
    far_radius
        radius of the half-disc, held along its arc, that stands for a half-plane; the tractions
        miss those of the half-plane by about the square of its inverse
    growth
        growth of the elements away from the contact
    steps_per_cycle
        output instants of a revolution; its turning points come on top
    cycles
        revolutions at most; the scene's own number where that is less
    normal_stiffness
        pressure per penetration
    stick_stiffness
        shear per elastic slip, where friction would let the faces stick
    """

    element_size: float = 1 / 20
    edge_element_size: float = 1 / 40
    far_radius: float = 50.0
    growth: float = 0.4
    steps_per_cycle: int = 48
    cycles: int = 2
    normal_stiffness: float = 50.0
    stick_stiffness: float = 10.0

    def __post_init__(self) -> None:
        """Refuse settings of an input deck that are out of range: fewer than 4 or more than 10,000
        output instants a cycle (`steps_per_cycle`), no cycle, a stiffness that is not positive.
        Raises InputError.
        """
        if not 4 <= self.steps_per_cycle <= 10_000:
            raise InputError(
                f"--steps-per-cycle {self.steps_per_cycle}: refused for a deck, it lies in [4,"
                " 10000]"
            )
        if self.cycles < 1:
            raise InputError(f"--cycles {self.cycles}: refused for a deck, it is at least 1")
        for name in ("normal_stiffness", "stick_stiffness"):
            if not getattr(self, name) > 0:
                raise InputError(
                    f"deck: {name} = {getattr(self, name)!r} is refused: it is positive,"
                    " in units of E*/h with h the element length"
                )


@dataclass(frozen=True, eq=False)
class DeckBody:
    """One body in the common frame, y out of the lower one; numbers as in the deck, from
    `first_node` and `first_element` on.

    Attributes
    ----------
    name
        "LOWER" or "UPPER"
    nodes
        (n, 2) places [length]
    elements
        (m, 4) node numbers, anticlockwise
    contact_faces
        (k, 2) element number and face 1-4, from the nodes (1, 2), (2, 3), (3, 4), (4, 1)
    contact_nodes
        (k + 1,) node numbers by ascending x
    held
        direction 1 or 2 -> node numbers that move as the rigid plane does
    ends
        of the left and of the right end of a block that bulk stress pulls, (k, 2) element number
        and face 1-4; empty for other bodies
    """

    name: str
    first_node: int
    first_element: int
    nodes: Array
    elements: Indices
    contact_faces: Indices
    contact_nodes: Indices
    held: Mapping[int, Indices]
    ends: tuple[Indices, ...] = ()

    def areas(self) -> Array:
        """(m,) areas of the elements, positive where they go round anticlockwise [length^2]."""
        return _areas(self.nodes.T, self.elements.T - self.first_node)


@dataclass(frozen=True, eq=False)
class Deck:
    """Everything that an input deck states.

    Attributes
    ----------
    scene, settings, scales
        the question, how it is cut, and the size of its contact
    lower, upper
        the bodies; the upper one is held by a rigid plane whose motion is that of the node
        `reference_node`
    time
        (n + 1,) instants of the scene's path, the unloaded one first; deck times are counted
        from that one
    normal_load, tangential_load
        (n + 1,) [force per thickness]
    touch_time, touch_approach
        duration of the first step, and how far the upper plane comes down in it [time, length]
    bulk_stress
        of the lower and of the upper body, (n + 1,) [stress]; None for none
    tilt, moment
        (n + 1,) turn of the upper body about x = y = 0, or the moment of the pressure, where
        either is given
    """

    scene: Scene
    settings: DeckSettings
    scales: Scales
    lower: DeckBody
    upper: DeckBody
    time: Array
    normal_load: Array
    tangential_load: Array
    touch_time: float
    touch_approach: float
    bulk_stress: tuple[Array | None, Array | None] = (None, None)
    tilt: Array | None = None
    moment: Array | None = None

    @property
    def strain_node(self) -> int:
        """Number of the node whose movements along x and y are the bulk strains of half-planes,
        lower and upper, times a.
        """
        return self.reference_node + 1

    @property
    def tilt_node(self) -> int:
        """Number of the node whose movement along x is the tilt of the upper body times a."""
        return self.reference_node + 2

    def strain(self, body_number: int) -> Array | None:
        """Bulk strain sigma/E' over time, (n + 1,), of the lower (0) or the upper (1) body, where
        it is a half-plane with a bulk stress sigma; else None. E' = E/(1 - nu^2).
        """
        stress = self.bulk_stress[body_number]
        body_name = ("lower", "upper")[body_number]
        if stress is None or not stress.any():
            return None
        if not isinstance(getattr(self.scene.bodies, body_name), HalfPlane):
            return None
        material = getattr(self.scene.material, body_name)
        return np.asarray(stress * (1 - material.poisson_ratio**2) / material.young_modulus)

    def end_stresses(self, body_number: int) -> tuple[Array, Array] | None:
        """Stress along x over time, (n + 1,) each, on the left and on the right end of a block that
        bulk stress pulls. It is the lower (0) or the upper (1) body; tension is positive.

        The base of a lower block on rollers carries no Q: each end then carries Q/2 too, which
        pulls the left end and presses the right one where Q > 0. None for bodies whose ends are not
        pulled, and where the stress is 0 throughout.

        `bulk_stress` holds that of the lower and of the upper body, (n + 1,) or None;
        `tangential_load` (n + 1,) is Q per thickness. A deck body's `ends` are the element sides at
        the ends of a pulled block.
        """
        deck_body = (self.lower, self.upper)[body_number]
        body = (self.scene.bodies.lower, self.scene.bodies.upper)[body_number]
        if not deck_body.ends or not isinstance(body, Block):
            return None
        mean_stress = self.bulk_stress[body_number]
        if mean_stress is None:
            mean_stress = np.zeros(len(self.time))
        stress_by_half_of_q = np.zeros(len(self.time))
        if body.base == "rollers" and body_number == 0:
            stress_by_half_of_q = self.tangential_load / (2 * body.height)
        if not (mean_stress.any() or stress_by_half_of_q.any()):
            return None
        return mean_stress + stress_by_half_of_q, mean_stress - stress_by_half_of_q

    @property
    def reference_node(self) -> int:
        """Number of the node that the upper rigid plane moves with."""
        return self.upper.first_node + len(self.upper.nodes)

    @property
    def node_count(self) -> int:
        """Number of nodes of both meshes. The nodes that move the rigid plane, bulk strain and tilt
        are not counted: they belong to no element.
        """
        return len(self.lower.nodes) + len(self.upper.nodes)

    @property
    def element_size(self) -> float:
        """Surface elements at the edges [length]."""
        return self.settings.edge_element_size * self.scales.half_width

    @property
    def stiffness(self) -> float:
        """Pressure per penetration [stress per length]."""
        return self.settings.normal_stiffness * self.scales.modulus / self.element_size

    @property
    def stick_slope(self) -> float:
        """Shear per elastic slip [stress per length]."""
        return self.settings.stick_stiffness * self.scales.modulus / self.element_size

    @property
    def mean_pressure(self) -> float:
        """P/(2 a) at the largest load [stress]."""
        return self.scales.load / (2 * self.scales.half_width)

    @property
    def deck_time(self) -> Array:
        """(n + 1,) total time of the deck at the instants."""
        return np.asarray(self.time - self.time[0])

    @property
    def increments(self) -> Array:
        """Durations of the deck's load increments between instants, (n,); the first one minus that
        of the first step, which brings the faces together.
        """
        durations = np.diff(self.deck_time)
        durations[0] -= self.touch_time
        return np.asarray(durations)


def build_deck(
    scene: Scene, settings: DeckSettings | None = None, scales: Scales | None = None
) -> Deck:
    """All that an input deck for the finite-element program CalculiX states of a scene: meshes of
    both bodies, supports, instants, loads, and the first step, which brings the faces together.

    Parameters
    ----------
    settings
        element sizes, growth of the elements and `far_radius` (of the half-disc that stands for a
        half-plane), all over the contact half-width; increments, stiffnesses; defaults if None
    scales
        length and load scales of the contact, from an earlier solution; from a coarse solve if None

    Raises
    ------
    InputError
        For a scene that does not pass its own check, for bodies that can't be meshed, held or
        pulled, and for an upper block on rollers under bulk stress and Q.
    """
    scene = validated(scene, Scene)
    settings = settings or DeckSettings()
    _require_support_of_loads(scene)
    scales = scales or find_scales(scene, Counter())
    lower_body, upper_body = _meshed_bodies(scene, settings, scales)

    # instants and loads; the touch takes a fraction of the first increment (_TOUCH_FRACTION: 0.25)
    path = scene.load.path()
    time = _instants(scene, settings)
    normal_load, tangential_load = path.at(time)
    load_of_touch = _TOUCH_FRACTION * float(normal_load[1])
    return Deck(
        scene=scene,
        settings=settings,
        scales=scales,
        lower=lower_body,
        upper=upper_body,
        time=read_only_copy(time),
        normal_load=read_only_copy(normal_load),
        tangential_load=read_only_copy(tangential_load),
        touch_time=float(_TOUCH_FRACTION * (time[1] - time[0])),
        touch_approach=_approach(scene, settings, scales, load_of_touch),
        **_bulk_and_tilt(path, time),
    )


def _require_support_of_loads(scene: Scene) -> None:
    """InputError for bodies that the loads push off their supports, for bulk stress that can't act,
    and for an upper block on rollers under bulk stress and a tangential load Q.
    """
    check_supports(scene)
    check_bulk_stress(scene)
    on_rollers = getattr(scene.bodies.upper, "base", "") == "rollers"
    if has_bulk_stress(scene.load.path()) and on_rollers and has_tangential_load(scene):
        raise InputError(
            "bodies.upper.base: a deck holds Q by the rigid plane above, which rollers let go: take"
            " base = 'fixed'"
        )


def _meshed_bodies(
    scene: Scene, settings: DeckSettings, scales: Scales
) -> tuple[DeckBody, DeckBody]:
    """The lower and the upper body of an input deck, meshed with linear quadrilaterals, finest
    where edges of contact and stick travel. Numbers of the upper body's nodes and elements follow
    those of the lower one.

    `settings` has element sizes and `far_radius` over the contact half-width, `scales` has that
    half-width and the loads.
    """
    mesh_settings = MeshSettings(
        element_size=settings.element_size,
        edge_element_size=settings.edge_element_size,
        far_radius=settings.far_radius,
        growth=settings.growth,
        order=1,
        cells="quadrilaterals",
    )
    lower_mesh, upper_mesh = meshed_pair(
        scene, mesh_settings, partial(surface_grading, mesh_settings, scales, scene.profile)
    )
    lower_body = _body("LOWER", lower_mesh, lower_mesh.mesh.p, 1, 1)
    # a curved face is meshed as it is; between flat faces the profile is the gap
    gap_profile = None if scene.bodies.faces_are_true else scene.profile
    upper_body = _body(
        "UPPER",
        upper_mesh,
        _places_of_upper_body(upper_mesh, gap_profile),
        len(lower_body.nodes) + 1,
        len(lower_body.elements) + 1,
    )
    return lower_body, upper_body


def _bulk_and_tilt(path: LoadPath, time: Array) -> dict[str, Any]:
    """Bulk stresses of the lower and the upper body, and tilt or moment of the upper body, at the
    instants of an input deck, (n + 1,) each, by name; only those that the load path has.

    `path.companion(name)` is the history that runs beside P and Q: "bulk", stresses of the lower
    and the upper body, or "tilt_and_moment"; None where the path has none. Its `at` gives both
    values at times.
    """
    histories: dict[str, Any] = {}
    if (bulk := path.companion("bulk")) is not None:
        histories["bulk_stress"] = tuple(read_only_copy(stress) for stress in bulk.at(time))
    if (tilt_and_moment := path.companion("tilt_and_moment")) is not None:
        tilt, moment = tilt_and_moment.at(time)
        if path.moment_is_given:
            histories["moment"] = read_only_copy(moment)
        else:
            histories["tilt"] = read_only_copy(tilt)
    return histories


def _instants(scene: Scene, settings: DeckSettings) -> Array:
    """Times of an input deck, (n + 1,): the unloaded instant, then the end of every load increment.
    Turning points of the path are ends of increments. Between two turning points all increments of
    a segment are of equal duration.

    `settings` has the number of increments of a cycle (`steps_per_cycle`) and of cycles. A load
    path has an initial loading, then cycles if it has a period; each consists of segments.
    """
    path = scene.load.path()
    steps_per_cycle = settings.steps_per_cycle
    n_cycles = min(settings.cycles, scene.cycles) if path.period is not None else 0

    # the load segments of the initial loading and of each cycle, with their number of increments;
    # _INITIAL_INCREMENTS: 0.25 of those of a cycle
    initial_increments = max(_INITIAL_INCREMENTS * steps_per_cycle, 4.0)
    parts_of_path = [(path.initial_loading, initial_increments)]
    parts_of_path += [
        (path.segments_of_cycle(cycle_number), float(steps_per_cycle))
        for cycle_number in range(n_cycles)
    ]

    # increments in proportion to duration
    instants = [path.start]
    for segments, increments_of_part in parts_of_path:
        duration = segments[-1].end - segments[0].start
        for segment in segments:
            increments_of_segment = increments_of_part * (segment.end - segment.start) / duration
            # a stretch lies between turning points; its `ends` are those of its increments
            for stretch in stretches(segment, scene.friction.coefficient, increments_of_segment):
                instants.extend(stretch.ends)
    return np.array(instants)


def _approach(scene: Scene, settings: DeckSettings, scales: Scales, load: float) -> float:
    """Rough approach [length] of the bodies under the load P (`load`, per thickness). It is that of
    a line load on half-planes, 2 P ln(1 + 4 L/a)/(pi E*), with the depth L of the shallower body.

    A rough value is enough. It is the displacement of the input deck's first step, which makes the
    faces meet, and no instant of the answer belongs to that step.

    `scales` has the half-width a of contact at the largest load, and E* (`modulus`);
    `settings.far_radius` is the radius over a of the half-disc that stands for a half-plane.
    """

    def depth(body: Shape) -> float:
        """Depth of a body [length]; of a half-plane, radius of the half-disc."""
        if isinstance(body, HalfPlane):
            return settings.far_radius * scales.half_width
        return body.least_depth

    depth_of_shallower_body = min(depth(scene.bodies.lower), depth(scene.bodies.upper))
    return float(
        2
        * load
        * np.log1p(4 * depth_of_shallower_body / scales.half_width)
        / (np.pi * scales.modulus)
    )


def _areas(places: Array, cells: Indices) -> Array:
    """(m,) areas of cells (4, m) on places (2, n), positive where they go round anticlockwise."""
    x, y = places[:, cells]
    return np.asarray((x * (np.roll(y, -1, 0) - np.roll(y, 1, 0))).sum(0) / 2)


def _body(
    name: str, mesh: BodyMesh, places: Array, first_node: int, first_element: int
) -> DeckBody:
    """One body of an input deck: its nodes, its elements (nodes anticlockwise), the element sides
    that may touch, the nodes that are held in each direction, and the ends that bulk stress pulls.

    Parameters
    ----------
    name
        "LOWER" or "UPPER"
    mesh
        the meshed body: `mesh.mesh` has its elements (t), element sides on boundaries (facets by
        the name of the boundary, such as "contact"); `mesh.supports` is how a boundary is held
    places
        (2, n) coordinates of the mesh's nodes in the deck [length]
    first_node, first_element
        numbers from which its nodes and elements are counted
    """
    # node indices of quadrilaterals, (4, m), anticlockwise
    cells = mesh.mesh.t.copy()
    is_clockwise = _areas(places, cells) < 0  # of negative area
    cells[:, is_clockwise] = cells[:, is_clockwise][[0, 3, 2, 1]]

    # name of a boundary -> both nodes of each facet on it, (2, k)
    nodes_by_boundary = {
        boundary: mesh.mesh.facets[:, facet_indices]
        for boundary, facet_indices in mesh.mesh.boundaries.items()
    }
    # the left and the right end of a block that bulk stress pulls; both are the boundary "sides"
    pulled_ends: tuple[Indices, ...] = ()
    if mesh.supports.get("sides") == "pulled":
        facets_of_ends = nodes_by_boundary["sides"]
        is_right = places[0, facets_of_ends].mean(axis=0) > 0
        pulled_ends = (
            _sides_on_facets(cells, facets_of_ends[:, ~is_right], first_element),
            _sides_on_facets(cells, facets_of_ends[:, is_right], first_element),
        )

    # nodes that may touch, from left to right; nodes that supports hold, by direction x (1), y (2)
    contact_nodes = np.unique(nodes_by_boundary["contact"])
    held_nodes = _held_nodes(mesh, nodes_by_boundary)
    nodes_in_order_of_x = contact_nodes[np.argsort(places[0, contact_nodes])]
    return DeckBody(
        name=name,
        first_node=first_node,
        first_element=first_element,
        nodes=read_only_copy(places.T),
        elements=read_only_copy(cells.T + first_node, np.int64),
        contact_faces=_sides_on_facets(cells, nodes_by_boundary["contact"], first_element),
        contact_nodes=read_only_copy(nodes_in_order_of_x + first_node, np.int64),
        held={
            direction: read_only_copy(np.unique(np.concatenate(nodes)) + first_node, np.int64)
            for direction, nodes in held_nodes.items()
            if nodes
        },
        ends=pulled_ends,
    )


def _sides_on_facets(cells: Indices, facets: Indices, first_element: int) -> Indices:
    """Numbers of the element and of its side, 1 to 4, for each side of an element that lies on a
    boundary, (k, 2). It lies there where its two nodes, in either order, are those of a facet.

    Parameters
    ----------
    cells
        (4, m) nodes of the elements; side 1 goes from the first node to the second, and so on
    facets
        (2, k) both nodes of each facet on the boundary
    first_element
        number of the first element
    """
    # each pair of nodes becomes one number, its key: (4, m) and (k,)
    key_factors = [int(cells.max()) + 1, 1]
    nodes_of_sides = np.sort(np.stack([cells, np.roll(cells, -1, axis=0)], axis=-1), axis=-1)
    keys_of_sides = nodes_of_sides @ key_factors
    keys_of_facets = np.sort(facets.T) @ key_factors
    element_numbers, side_numbers = np.nonzero(np.isin(keys_of_sides, keys_of_facets).T)
    return read_only_copy(
        np.stack([element_numbers + first_element, side_numbers + 1], axis=1), np.int64
    )


def _held_nodes(
    mesh: BodyMesh, nodes_by_boundary: Mapping[str, Indices]
) -> dict[int, list[Indices]]:
    """Nodes whose displacement along x (1) or y (2) is prescribed by the supports of a body:
    direction -> one array of nodes for each support.

    `nodes_by_boundary` holds both nodes of each of the k facets (element sides) on a boundary, (2,
    k), by the boundary's name. `mesh.supports` is how each supported boundary is held: "rollers"
    let it move along x, "guided" along y. `mesh.mesh.p` (2, n) has the places of the nodes.
    """
    held_nodes: dict[int, list[Indices]] = {1: [], 2: []}
    for boundary, support in mesh.supports.items():
        nodes = np.unique(nodes_by_boundary[boundary])
        # _HELD_DIRECTIONS: kind of support -> directions in which it holds
        for direction in _HELD_DIRECTIONS[support]:
            held_nodes[direction].append(nodes)
        if support == "rollers" and "guided" not in mesh.supports.values():
            # Nothing else keeps the body from moving along x; without a tangential load this node
            # carries no force.
            node_in_middle = nodes[[np.argmin(np.abs(mesh.mesh.p[0, nodes]))]]
            held_nodes[1].append(node_in_middle)
    return held_nodes


def _places_of_upper_body(mesh: BodyMesh, profile: Profile | None) -> Array:
    """Places (2, n) [length] of the nodes of an upper body in the frame of the input deck, y out of
    the lower body; the mesh has the body upside down.

    Between flat faces the gap h(x) of `profile` is cut into the upper body: each node is raised by
    h (1 - y/y_max), so that the far side stays plane. Surface elements that may touch end at |x| =
    c; beyond it h goes on as h(c) + h'(c) c tanh((|x| - c)/c), bounded on a body of any width.
    `profile` is None where the mesh has the curved face itself.

    `mesh.mesh.p` (2, n) has the places in the mesh, `mesh.grading.outer` is c.
    """
    x = mesh.mesh.p[0]
    y = -mesh.mesh.p[1]
    if profile is None:
        return np.stack([x, y])

    # gap and its slope at x = c or x = -c, by the sign of the node's x
    c = mesh.grading.outer
    small_step = 1e-4 * c
    sign_of_x = np.where(x < 0, -1.0, 1.0)
    distance = np.abs(x)
    gap_before_c = np.asarray(profile.height(sign_of_x * (c - small_step)))
    gap_at_c = np.asarray(profile.height(sign_of_x * c))
    slope_at_c = (gap_at_c - gap_before_c) / small_step

    # the gap at each node
    gap = np.asarray(profile.height(sign_of_x * np.minimum(distance, c)))
    gap = gap + slope_at_c * c * np.tanh(np.maximum(distance - c, 0.0) / c)
    return np.stack([x, y + gap * (1 - y / y.max())])


# --------------------------------------------------------------------------------- the deck as text
def deck_text(deck: Deck, command: str = "", versions: Mapping[str, str] | None = None) -> str:
    """The text of the input file for the finite-element program CalculiX, with comments wrapped to
    the longest line that it reads. Empty lines are left out.

    The template deck.inp is filled in with the deck (meshes, supports, instants, loads), and with
    functions that write its data lines. Its first comment has the `command` line that wrote the
    file and the `versions` of packages.
    """
    packages = ", ".join(f"{name} {version}" for name, version in (versions or {}).items())
    functions = (amplitudes, equations_of, lines_of_zero_displacements, number, one_line, rows)
    function_by_name = {function.__name__: function for function in functions}
    unwrapped_text = template("deck.inp").render(
        deck=deck, command=command, versions=packages, **function_by_name
    )

    # a comment begins with **; _LONGEST_LINE: 132 characters
    lines: list[str] = []
    for line in unwrapped_text.split("\n"):
        if line.startswith("**"):
            comment_lines = textwrap.wrap(
                line[2:].strip(), _LONGEST_LINE - 7, break_on_hyphens=False
            )
            lines += [f"** {comment_line}" for comment_line in comment_lines]
        elif line:
            lines.append(line)
    return "\n".join(lines) + "\n"


def one_line(text: str) -> str:
    """A text of the user on one line: a further line could begin a card of the input deck."""
    return " ".join(text.split())


def number(value: float) -> str:
    """A number as text of thirteen digits and twenty characters at most, which is what CalculiX
    reads; always with a decimal point.

    >>> number(0.1), number(-1234.5), number(1e-20), number(2)
    ('0.1', '-1234.5', '1.e-20', '2.')
    """
    mantissa, _, exponent = f"{value:.13g}".partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.") + (f"e{exponent}" if exponent else "")


def rows(values: ArrayLike, per_line: int) -> str:
    """Data lines of an array of any shape, with `per_line` integers or numbers each."""
    flat_values = np.ravel(values)
    number_texts = [
        str(v) if flat_values.dtype.kind == "i" else number(v) for v in flat_values.tolist()
    ]
    return "\n".join(
        ", ".join(number_texts[k : k + per_line]) for k in range(0, len(number_texts), per_line)
    )


def amplitudes(deck: Deck) -> dict[str, Array]:
    """Histories of an input deck, which it calls amplitudes: name -> (n + 1, 2), total time and
    value. They are of a load, an end stress, a strain, the tilt or the moment.

    Strains and tilt are displacements of extra nodes in the deck. They are multiplied by a, the
    half-width of contact at the largest load. The moment, the force on such a node, is divided by
    a.
    """
    half_width = deck.scales.half_width
    histories = {"NORMAL_LOAD": deck.normal_load, "TANGENTIAL_LOAD": deck.tangential_load}
    for body_number, name in enumerate(("LOWER", "UPPER")):
        # bulk strain of a half-plane; None for other bodies
        strain = deck.strain(body_number)
        if strain is not None:
            histories[f"{name}_STRAIN"] = strain * half_width
        # on both ends of a block that bulk stress pulls; None for other bodies
        stresses_of_ends = deck.end_stresses(body_number)
        if stresses_of_ends is not None:
            left_stress, right_stress = stresses_of_ends
            histories[f"{name}_LEFT_END"] = left_stress
            histories[f"{name}_RIGHT_END"] = right_stress
    if deck.tilt is not None:
        histories["TILT"] = deck.tilt * half_width
    if deck.moment is not None:
        histories["MOMENT"] = deck.moment / half_width
    # `deck_time`: total time in the deck
    return {
        name: np.stack([deck.deck_time, history], axis=1) for name, history in histories.items()
    }


def _constraints(deck: Deck, body: DeckBody) -> Iterator[list[tuple[int, int, float]]]:
    """The linear constraints on the held nodes of a body, one for each node and direction: terms
    (node, direction, factor) whose displacements times factors add up to 0.

    A node of the upper body moves with the rigid plane that carries P and Q (node
    `deck.reference_node`), and turns with it (node `deck.tilt_node`, whose displacement is tilt
    times a). A node on the arc of a half-plane moves by the bulk strain (node `deck.strain_node`,
    strain times a; direction 1 for the lower body, 2 for the upper). A constraint with one term
    means that the node does not move.

    # notation: a contact half-width at the largest load (`deck.scales.half_width`); direction 1
    #           along x, 2 along y; u displacement, eps bulk strain, nu Poisson's ratio, alpha tilt

    `body.held` has the numbers of the held nodes by direction, `body.nodes` (n, 2) the places of
    all nodes, numbered from `body.first_node` on.
    """
    half_width = deck.scales.half_width
    is_upper = body is deck.upper
    material = deck.scene.material.upper if is_upper else deck.scene.material.lower
    poisson_ratio = material.poisson_ratio
    has_strain = deck.strain(int(is_upper)) is not None
    can_tilt = is_upper and (deck.tilt is not None or deck.moment is not None)

    for direction, held_nodes in sorted(body.held.items()):
        for node in held_nodes.tolist():
            x, y = body.nodes[node - body.first_node].tolist()
            terms = [(node, direction, 1.0)]
            if is_upper:
                terms.append((deck.reference_node, direction, -1.0))
            if has_strain:
                # A uniform stress along x in plane strain: u_x = eps x, u_y = -nu/(1 - nu) eps y.
                minus_displacement_per_strain = -x
                if direction == 2:
                    minus_displacement_per_strain = poisson_ratio / (1 - poisson_ratio) * y
                factor = minus_displacement_per_strain / half_width
                terms.append((deck.strain_node, int(is_upper) + 1, factor))
            if can_tilt:
                # A tilt that opens the gap at x > 0: u_x = -alpha y, u_y = alpha x.
                minus_displacement_per_tilt = y if direction == 1 else -x
                terms.append((deck.tilt_node, 1, minus_displacement_per_tilt / half_width))
            yield [term for term in terms if term[2]]  # those with a factor


def equations_of(deck: Deck, body: DeckBody) -> Iterator[str]:
    """Data lines of the equations that tie held nodes of a body to others, such as the one that
    carries P and Q: one text for each direction.
    """
    equation_terms = (terms for terms in _constraints(deck, body) if len(terms) > 1)
    for _, equations in groupby(equation_terms, lambda terms: terms[0][1]):
        yield "\n".join(map(_data_lines, equations))


def _data_lines(terms: Sequence[tuple[int, int, float]]) -> str:
    """The data lines of one equation: the number of its terms, then node, direction, factor of
    each.
    """
    cells = [f"{node}, {direction}, {number(factor)}" for node, direction, factor in terms]
    return f"{len(terms)}\n{', '.join(cells)}"


def lines_of_zero_displacements(deck: Deck) -> list[str]:
    """Lines "node, direction" of an input deck for displacements that are 0. They are for held
    nodes of the lower body, and for those directions of the extra nodes for bulk strain and tilt
    that stand for nothing. Direction 1 is along x, 2 along y.
    """
    lines = []
    # constraints of held nodes, as terms (node, direction, factor) that add up to 0
    for terms in _constraints(deck, deck.lower):
        if len(terms) == 1:
            node, direction, _ = terms[0]
            lines.append(f"{node}, {direction}")

    # The node for strain has direction 1 for the lower body (0), 2 for the upper body (1). It is in
    # the deck where one of them has a strain.
    bodies_without_strain = [number for number in (0, 1) if deck.strain(number) is None]
    if len(bodies_without_strain) == 1:
        lines.append(f"{deck.strain_node}, {bodies_without_strain[0] + 1}")
    if deck.tilt is not None or deck.moment is not None:
        lines.append(f"{deck.tilt_node}, 2")
    return lines
