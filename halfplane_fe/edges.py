"""Contact and stick edges of many instants at once, from nodal answers.

Contact edges, and stick edges that slip takes inwards, are located by the load between two nodes:
`between_nodes.Edge`. Where it locates none, contact edges follow from the form of pressure and gap.
At stick edges the square of what the shear lacks of the Coulomb limit goes to zero as the distance.
Where that is not seen, stick edges follow from the states of the nodes.

Arrays are (k, n): k instants, n nodes at ascending x. Edges and their uncertainties are (k, 2),
left and right.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.between_nodes import JUMP, EdgesByLoad
from halfplane_fe.contact import InterfaceState, nodal_values
from halfplane_fe.interface import Interface
from halfplane_fe.law import force_to_limit
from scenes.array_types import Array, Indices, Mask

# Share of the distance of two nodes by which a contact edge by its form is uncertain: the shape
# functions of quadratic elements have no square root. Random half-planes, seed 230 of
# benchmarks/covered.py values, both presets: 0.31 at most with twenty nodes and more in contact,
_SHARE = 0.27
# and by this share of the distance from the zero of p^2 with fewer.
_BY_ZERO = 0.68
# Fitted stick edges: a share that is left,
_FITTED_SHARE = 0.13
# and how far the squares stand off the straight line, as a distance of its zero. Where an older
# stick edge or a kink of the profile is near, they do: two fits may agree there by chance.
_BY_MISFIT = 6.0
# Distances of nodes by which an edge by the states of the nodes may differ from the fitted one
# without telling anything: beyond half of one a node is on the wrong side of the fitted edge. Of
# seeds 241 and 250, default preset, that is where the fit errs most.
_BY_STATES = 0.45
# Nodes that the second estimate of the contact edge takes, counted from the last closed one.
_EXTRAPOLATED = 5
# Nodes of a slip zone below which it may be none at all.
_UNRESOLVED = 4
# Nodes that the slip zone may be wide where all of the contact seems to stick: an element, of
# quadratic ones.
_UNSEEN = 2.0
# Nodes inside the stick zone that the two fits take, counted from its last one, which the
# singularity spoils.
_FITTED = (7, 4)
# Elements that grow away from the edges make the bodies too stiff: each edge is as far in as at a
# load that is smaller by this share of the third power of the growth. Regressions of random
# half-planes and of Hertz' contact: 0.0065 to 0.0076 at a growth of 0.2, 0.35 and 0.5,
_LOAD_LACKED = 0.0068
# and this share of the distance of two nodes over the same power farther in: 0.15 to 0.16 of each
# kind of profile on both presets.
_NODES_LACKED = 0.155
# Both are put right, and this share of them is left.
_LEFT_OF_LACKED = 0.05
# The same of cylinders and layers thinner than three half-widths: 0.1 to 0.5, benchmarks/covered.py
# bodies, seed 286, coarse.
_LEFT_OF_THIN = 0.5
# Shares of the distance of two nodes by which edges are uncertain beside that, by growths. The
# correction is right at the growths that it was fitted at, of the default and the coarse mesh.
# Between them it lacks up to a half: meshes of a/40 that grow by 0.4 hold all their edges back by
# 0.003 to 0.014, each by another share; those of 0.2 by 0.002 at most, those of 0.5 by 0.006.
_GROWTHS = (0.2, 0.4, 0.5)
_BY_GROWTHS = (0.0, 0.016, 0.005)
# Loads at which the width of the contact is read for that, from none to the largest.
_WIDTHS = 40
# Distances of nodes that a stick edge moves in one increment above which it jumps where slip starts
# or ends in this increment (elsewhere `JUMP`),
_JUMP_AT_START = 2.0
# and the share of one up to which an edge is known well enough not to have jumped inwards.
_ON_ITS_WAY = 0.2
# Elements by which two fits of a stick edge may differ.
_AGREE = 0.1


class Edges(NamedTuple):
    """One end on the left and one on the right, of the contact or of its stick zone, at k instants.

    Attributes
    ----------
    places
        (k, 2); NaN where there is no zone [length]
    uncertainty
        (k, 2) how far each may be from the true one, by the mesh [length]
    """

    places: Array
    uncertainty: Array


class NodalAnswer(NamedTuple):
    """What is known at n nodes and k instants, from which edges are read.

    Attributes
    ----------
    x
        (n,) nodes in ascending order [length]
    pressure, shear
        (k, n) [stress]
    gap
        (k, n) of the open nodes [length]
    is_closed
        (k, n) whether a node touches
    is_stuck, is_stuck_by_law
        (k, n) whether it sticks, as it is reported and by the law alone
    stick_may_be_anywhere
        whether the stick zone need not hold the middle of the contact, as under bulk stress or
        tilt
    """

    x: Array
    pressure: Array
    shear: Array
    gap: Array
    is_closed: Mask
    is_stuck: Mask
    is_stuck_by_law: Mask
    stick_may_be_anywhere: bool


class StickEdges(NamedTuple):
    """Ends of the stick zone of k instants.

    Attributes
    ----------
    places
        (k, 2) left and right; NaN where nothing sticks [length]
    misfit
        (k, 2) of the fit of each, `_FittedLines.misfit`; 0 where it is not fitted [length]
    by_states
        (k, 2) the same ends by the states of the nodes alone
    """

    places: Array
    misfit: Array
    by_states: Array


def contact_with_uncertainty(answer: NodalAnswer, edges_by_load: EdgesByLoad) -> Edges:
    """Left and right edge of contact at k instants, and the uncertainty of each, by the load that
    moves them, or else by the form of pressure and gap at the outermost nodes; all is scaled, with
    stresses over E*.

    Parameters
    ----------
    answer
        places of the n nodes; pressure, gap and whether they touch, (k, n)
    edges_by_load
        edges that a load locates between two nodes (`last_node` (k, 2) is -1 where none does), with
        their uncertainty
    """
    edges_by_form = contact_edges(answer.x, answer.pressure, answer.gap, answer.is_closed, 1.0)
    is_located = edges_by_load.last_node >= 0
    return Edges(
        places=np.where(is_located, edges_by_load.places, edges_by_form),
        uncertainty=np.where(
            is_located, edges_by_load.uncertainty, _contact_uncertainty(answer, edges_by_form)
        ),
    )


def stick_with_uncertainty(
    answer: NodalAnswer,
    friction: float,
    contact: Edges,
    sticks_in_full: Mask,
    edges_by_load: EdgesByLoad,
) -> Edges:
    """Left and right end of the stick zone at k instants, and the uncertainty of each: by the load
    that takes it inwards, or else by the distance of q from the Coulomb limit, where that is
    smooth, or else by the states of the nodes.

    Parameters
    ----------
    answer
        places of the n nodes; pressure, shear and states of each, (k, n)
    friction
        f
    contact
        ends of the contact, with their uncertainty
    sticks_in_full
        (k,) instants at which the whole contact is known to stick
    edges_by_load
        edges that a load locates beyond the last node that sticks (`last_node` (k, 2), -1 where
        none does); they count where the reported states end the stick zone at the same nodes
    """
    fitted_edges = fitted_stick_edges(answer, contact.places, friction)
    uncertainty = _stick_uncertainty(answer, contact, fitted_edges, sticks_in_full)

    # Half-way between the last node that sticks and the next one outwards: the end by states.
    next_node = edges_by_load.last_node + np.array([-1, 1])
    is_same = (edges_by_load.last_node >= 0) & (
        fitted_edges.by_states == (answer.x[edges_by_load.last_node] + answer.x[next_node]) / 2
    )
    return Edges(
        places=np.where(is_same, edges_by_load.places, fitted_edges.places),
        uncertainty=np.where(is_same, edges_by_load.uncertainty, uncertainty),
    )


def contact_edges_of_states(interface: Interface, states: Sequence[InterfaceState]) -> Array:
    """Left and right edge of contact in k complete states, (k, 2), by the form of pressure and gap
    at the outermost nodes of the `interface`; scaled; NaN without contact. Nodal forces over
    lengths of face are pressures.
    """
    _, pressure, _, gap = nodal_values(np.stack([state.values for state in states]))
    is_closed = np.stack([state.is_closed for state in states])
    return contact_edges(interface.x, pressure / interface.face_lengths, gap, is_closed, 1.0)


def contact_edges(x: Array, pressure: Array, gap: Array, is_closed: Mask, modulus: float) -> Array:
    r"""Left and right edge of contact at k instants, (k, 2), from the form that every smooth edge
    has; NaN without contact.

    With d the distance from the edge and one unknown factor beta, p = (E*/2) beta sqrt(d) inside, g
    = (2/3) beta d^(3/2) outside; the last closed and the first open node give beta and the edge.
    With t the distance of the open node from the edge, over the distance s of both nodes, that is
    t^3 + c t = c, c = (3 E* g/(4 p s))^2. The outermost node itself where no open node follows.

    # notation: p pressure of the last closed node, g gap of the first open one

    Parameters
    ----------
    x
        (n,) nodes in ascending order [length]
    pressure, gap, is_closed
        (k, n); pressure of the closed nodes [stress], gap of the open ones [length], both >= 0
    modulus
        E* [stress]
    """
    edges = np.empty((len(is_closed), 2))
    # Each side is read outwards: the left one (column 0, sign -1) reflected, so that its x grow.
    for side in _sides(x):
        side_pressure, side_gap, is_in_contact = side.outwards(pressure, gap, is_closed)
        last_node = _outermost_in_contact(is_in_contact)  # (k,) outermost node that touches
        next_node = np.minimum(last_node + 1, len(x) - 1)
        distance = side.x[next_node] - side.x[last_node]
        # (k,), of each instant at its own node
        pressure_of_last_node = _value_at_node(side_pressure, last_node)
        gap_of_next_node = _value_at_node(side_gap, next_node)

        # t, by the real root of the cubic
        has_form = (distance > 0) & (pressure_of_last_node > 0) & (gap_of_next_node > 0)
        ratio = gap_of_next_node[has_form] / (pressure_of_last_node * distance)[has_form]
        c = (3 * modulus / 4 * ratio) ** 2
        t = np.where(pressure_of_last_node > 0, 0.0, 1.0)
        t[has_form] = 2 * np.sqrt(c / 3) * np.sinh(np.arcsinh(1.5 * np.sqrt(3 / c)) / 3)
        edges[:, side.column] = side.sign * (side.x[last_node] + distance * (1 - t))
    edges[~is_closed.any(axis=1)] = np.nan
    return edges


def _contact_uncertainty(answer: NodalAnswer, contact: Array) -> Array:
    """How far each contact edge by the form of pressure and gap may be from the true one, by the
    mesh, (k, 2) [length].

    A share of the distance of the nodes around it, and in part how far the edge is from another
    estimate: the zero of a straight line through the squares of the pressure at the five nodes
    before the last (`_EXTRAPOLATED`). Where no more than five touch, the width of the contact.

    Parameters
    ----------
    answer
        places of the n nodes; pressure, and whether they touch, (k, n)
    contact
        (k, 2) the edges [length]
    """
    width = contact[:, 1:] - contact[:, :1]
    uncertainty = np.repeat(width, 2, axis=1)
    # instants at which more than five nodes touch
    rows = np.flatnonzero(np.count_nonzero(answer.is_closed, axis=1) > _EXTRAPOLATED)
    # Each side is read outwards: the left one (column 0, sign -1) reflected, so that its x grow.
    for side in _sides(answer.x):
        side_pressure, is_in_contact = side.outwards(answer.pressure[rows], answer.is_closed[rows])
        last_node = _outermost_in_contact(is_in_contact)  # outermost node that touches
        edge_by_form = side.sign * contact[rows, side.column]
        # no zero counts as farther away than the innermost of the five nodes
        farthest_zero = side.x[last_node - _EXTRAPOLATED]
        zero_place = _lines_through_squares(side.x, side_pressure, last_node, _EXTRAPOLATED).zero
        zero_place = np.where(np.isnan(zero_place), farthest_zero, zero_place)
        distance_to_zero = np.minimum(
            np.abs(zero_place - edge_by_form), np.abs(farthest_zero - edge_by_form)
        )
        spacing = _larger_spacing(side.x, last_node)  # the larger distance from a neighbour
        # _SHARE, _BY_ZERO: fitted factors
        uncertainty[rows, side.column] = _SHARE * spacing + _BY_ZERO * distance_to_zero
    return uncertainty


def stick_edges(
    x: Array,
    is_sticking: Mask,
    is_closed: Mask,
    contact: Array,
    stick_may_be_anywhere: bool = False,
) -> Array:
    """Left and right end of the stick zone at k instants by the states of the nodes, (k, 2)
    [length]. The contact edge where all nodes stick on its side of the middle. Both are NaN where
    on one side at least nodes touch but none is in the stick zone.

    The edge lies half-way between the last node of the stick zone and the first one of the slip
    zone. On its side of the middle of the contact it is where the fewest nodes are misplaced, that
    is, slide inside it or stick beyond it. A node that has just come to touch sticks at the rim of
    the slip zone, and a single one may slide at the rim of a contact that sticks.

    Parameters
    ----------
    x
        (n,) nodes in ascending order [length]
    is_sticking
        (k, n) nodes that stick at k instants, in the order of `x`
    is_closed
        (k, n) whether a node touches
    contact
        (k, 2) ends of the contact
    stick_may_be_anywhere
        whether the stick zone may lie anywhere in the contact, without its middle (bulk stress,
        tilt): then the middle of the sticking nodes parts the sides
    """
    edges = np.empty((len(is_closed), 2))
    a_side_has_no_stick = np.zeros(len(is_closed), dtype=bool)
    # Each side is read outwards: the left one (column 0, sign -1) reflected, so that its x grow.
    for side in _sides(x):
        is_stuck, is_in_contact = side.outwards(is_sticking, is_closed)
        # (k, n) closed nodes on this side of the middle of the contact, or of the sticking nodes
        nodes_of_side = _closed_nodes_of_side(
            side, is_in_contact, is_stuck if stick_may_be_anywhere else None
        )
        # last node of the stick zone, and numbers of nodes of that zone and of the side, (k,)
        last_node, n_sticking_nodes, n_nodes_of_side = _last_sticking(is_stuck, nodes_of_side)
        a_side_has_no_stick |= (n_sticking_nodes == 0) & (n_nodes_of_side > 0)
        next_node = np.minimum(last_node + 1, len(x) - 1)
        edge_between_nodes = side.sign * (side.x[last_node] + side.x[next_node]) / 2
        sticks_to_contact_edge = n_sticking_nodes == n_nodes_of_side
        edges[:, side.column] = np.where(
            sticks_to_contact_edge, contact[:, side.column], edge_between_nodes
        )
    edges[a_side_has_no_stick] = np.nan
    return edges


def fitted_stick_edges(answer: NodalAnswer, contact: Array, friction: float) -> StickEdges:
    """Stick edges at k instants, from the nodal tractions: the places at which the shear q reaches
    the Coulomb limit f p.

    Inside the stick zone f p -+ q falls as the root of the distance from its edge. So a straight
    line is fitted to the square at seven nodes, and its zero is the edge. Where a line through four
    of them disagrees, the edge is that by the stick states of the nodes.

    Parameters
    ----------
    answer
        places x of the n nodes; pressure, shear, whether they touch (`is_closed`) and stick, (k, n)
    contact
        (k, 2) x of the two contact edges
    friction
        f

    Returns
    -------
    StickEdges
        Edges (k, 2), NaN where nothing sticks; misfit [length], 0 where there is no fit: root mean
        square distance of the squares from the line, over its slope; the edges by states.
    """
    edges_by_states = stick_edges(
        answer.x, answer.is_stuck, answer.is_closed, contact, answer.stick_may_be_anywhere
    )
    stick_edge_places = edges_by_states.copy()
    misfit = np.zeros_like(stick_edge_places)
    # Each side is read outwards: the left one (column 0, sign -1) reflected, so that its x grow.
    for side in _sides(answer.x):
        # Instants with a slip zone on this side, and more than seven nodes of the stick zone.
        is_stuck, is_in_contact = side.outwards(answer.is_stuck, answer.is_closed)
        is_in_half = _closed_nodes_of_side(
            side, is_in_contact, is_stuck if answer.stick_may_be_anywhere else None
        )
        last_node, n_sticking_nodes, n_nodes_in_half = _last_sticking(is_stuck, is_in_half)
        has_slip_zone = np.isfinite(stick_edge_places[:, side.column]) & (
            n_sticking_nodes < n_nodes_in_half
        )
        # _FITTED: numbers of nodes of two fits, seven and four
        rows = np.flatnonzero(has_slip_zone & (n_sticking_nodes > _FITTED[0]))
        if not len(rows):
            continue

        # f p - s q, s the sense of slip beyond the edge; its square falls to zero there.
        pressure, shear = side.outwards(answer.pressure[rows], answer.shear[rows])
        sense_beyond_edge = np.sign(_value_at_node(shear, last_node[rows] + 1))[:, None]
        traction_to_coulomb_limit = force_to_limit(pressure, shear, sense_beyond_edge, friction)
        fit = _fitted_stick_edge(side.x, traction_to_coulomb_limit, last_node[rows])
        # nothing sticks beyond the contact: a fit gone wrong
        is_accepted = fit.agrees & (fit.edge <= side.sign * contact[rows, side.column])
        stick_edge_places[rows[is_accepted], side.column] = side.sign * fit.edge[is_accepted]
        misfit[rows[is_accepted], side.column] = fit.misfit[is_accepted]
    return StickEdges(stick_edge_places, misfit, edges_by_states)


def _stick_uncertainty(
    answer: NodalAnswer, contact: Edges, fitted_edges: StickEdges, sticks_in_full: Mask
) -> Array:
    """How far each stick edge may be from the true one, by the mesh, (k, 2) [length]; NaN where
    nothing sticks.

    - An edge by the states of the nodes: the distance of the nodes around it, and how far it moves
      if creeping nodes count as sliding. Where the slip zone has up to four nodes it may be none at
      all: then at least the distance to the contact edge, plus the uncertainty of that.
    - A fitted edge: a share of the node distance, a multiple of the misfit, and how much farther it
      is from an edge by states than about half a node distance.
    - Where all of the contact sticks: a slip zone narrower than an element of two nodes may be
      there unseen, unless there can be none.

    Parameters
    ----------
    answer
        places of the n nodes; whether they touch, whether they stick as reported, and by the law of
        friction alone (creeping nodes slide there), (k, n)
    contact
        contact edges (k, 2), with their uncertainty
    fitted_edges
        stick edges (k, 2), fitted where that is possible; misfit of each fit, 0 of others; and the
        edges by the states of the nodes alone
    sticks_in_full
        (k,) instants at which the whole contact is known to stick
    """
    edges = fitted_edges.places
    spacing = _spacing_around(answer.x, edges)
    distance_from_states = _distance_from_states(answer, contact.places, fitted_edges)

    # Edges by states, where a slip zone of up to four nodes (`_UNRESOLVED`) may be none at all.
    uncertainty_by_states = spacing + distance_from_states
    uncertainty_of_narrow_slip_zone = np.abs(contact.places - edges) + contact.uncertainty
    is_narrow = _nodes_beyond_edges(answer, edges) <= _UNRESOLVED
    uncertainty_of_unfitted_edge = np.where(
        is_narrow,
        np.maximum(uncertainty_by_states, uncertainty_of_narrow_slip_zone),
        uncertainty_by_states,
    )

    # Fitted edges; up to about half a node distance from the edge by states is usual.
    # _BY_STATES: usual distance of a fitted edge from that by states, over the spacing;
    # _FITTED_SHARE, _BY_MISFIT: fitted factors
    distance_beyond_usual = np.maximum(distance_from_states - _BY_STATES * spacing, 0.0)
    uncertainty_of_fitted_edge = (
        _FITTED_SHARE * spacing + _BY_MISFIT * fitted_edges.misfit + distance_beyond_usual
    )
    uncertainty = np.where(
        edges == fitted_edges.by_states, uncertainty_of_unfitted_edge, uncertainty_of_fitted_edge
    )

    # Where all of the contact sticks: an unseen slip zone of two nodes (`_UNSEEN`).
    is_full_stick = edges == contact.places
    uncertainty_in_full_stick = np.where(
        sticks_in_full[:, None],
        contact.uncertainty,
        np.maximum(uncertainty_of_unfitted_edge, _UNSEEN * spacing),
    )
    return np.where(is_full_stick, uncertainty_in_full_stick, uncertainty)


def _distance_from_states(
    answer: NodalAnswer, contact_edges: Array, fitted_edges: StickEdges
) -> Array:
    """Distance of each stick edge from the edges by the states of the nodes, (k, 2) [length]: as
    reported, and by the law of friction, where creeping nodes slide; the larger one.

    Parameters
    ----------
    answer
        places of the n nodes; whether they touch, and whether they stick by the law, (k, n)
    contact_edges
        (k, 2) ends of the contact
    fitted_edges
        stick edges (k, 2), fitted where that is possible, and those by the states as reported
    """
    edges_by_law = stick_edges(
        answer.x,
        answer.is_stuck_by_law,
        answer.is_closed,
        contact_edges,
        answer.stick_may_be_anywhere,
    )
    return np.fmax(
        np.abs(fitted_edges.by_states - fitted_edges.places),
        np.abs(edges_by_law - fitted_edges.places),
    )


def _spacing_around(x: Array, edges: Array) -> Array:
    """Distance of the nodes around each edge, (k, 2) [length]: that at the nearer one of the two
    nodes beside it. `x` (n,) are the nodes in ascending order, `edges` (k, 2) may be NaN.
    """
    next_node = np.clip(np.searchsorted(x, edges), 1, len(x) - 1)  # NaN comes last
    previous_node = next_node - 1
    before_is_nearer = np.abs(x[previous_node] - edges) <= np.abs(x[next_node] - edges)
    return _larger_spacing(x, np.where(before_is_nearer, previous_node, next_node))


def _nodes_beyond_edges(answer: NodalAnswer, edges: Array) -> Indices:
    """Number (k, 2) of touching nodes beyond each stick edge, on its side of the middle.

    `answer` has the places of the n nodes, and whether they touch and stick, (k, n); `edges` (k, 2)
    are the left and right edge at k instants.
    """
    n_nodes_beyond_edge = np.empty(edges.shape, dtype=np.int64)
    # Each side is read outwards: the left one (column 0, sign -1) reflected, so that its x grow.
    for side in _sides(answer.x):
        is_in_contact, is_stuck = side.outwards(answer.is_closed, answer.is_stuck)
        is_in_half = _closed_nodes_of_side(
            side, is_in_contact, is_stuck if answer.stick_may_be_anywhere else None
        )
        is_beyond_edge = side.x > side.sign * edges[:, [side.column]]
        n_nodes_beyond_edge[:, side.column] = np.count_nonzero(is_in_half & is_beyond_edge, axis=1)
    return n_nodes_beyond_edge


def held_back_by_growth(
    places: Array, contact: ContactsOfLoads, growth: float, spacing: Array
) -> Array:
    """Correction along x of edges of contact or stick, left and right, (..., 2) [length]: how much
    farther out they are in truth than on elements whose size grows with the distance from the
    contact. 0 where nothing is pressed.

    Such elements make a body too stiff. A body that is too stiff by a share d of E* has the contact
    of a load P (1 - d), and all edges of stick too are those of loads that are smaller by d. An
    edge of the stick zone is where the edge of contact was under some smaller load L: both lie too
    far inside by d L da/dL. Here d is the third power of the growth times a fitted share
    (`_LOAD_LACKED`). To this comes a share of the distance of two nodes (`_NODES_LACKED`) times
    that power.

    # notation: a half-width of contact

    Parameters
    ----------
    places
        edges of contact or stick [length]
    contact
        half-width of contact by the load: `way_by_load` is P da/dP at given half-widths
    growth
        of the elements' size with the distance from the contact
    spacing
        (..., 2) distance of the nodes around each edge [length]
    """
    outwards = np.array([-1.0, 1.0])
    distance_by_stiffness = _LOAD_LACKED * np.sign(places) * contact.way_by_load(np.abs(places))
    return np.asarray(growth**3 * (distance_by_stiffness + outwards * _NODES_LACKED * spacing))


def uncertainty_by_growth(growth: float, spacing: Array) -> Array:
    """By how much edges are uncertain since elements grow away from them, by the `growth` of their
    size and the distance of the nodes around each edge, `spacing` [length]: nothing on meshes that
    grow slowly, a few thousandths of that distance on the coarse mesh, more between the two.

    >>> uncertainty_by_growth(0.3, np.array([0.01])).round(7).tolist()
    [8e-05]
    """
    return np.asarray(np.interp(growth, _GROWTHS, _BY_GROWTHS) * spacing)


def left_of_growth(put_right: Array, is_thick: bool = True) -> Array:
    """By how much edges may still be wrong after a correction for elements that grow away from
    them and hold them back [length]: by a small share of it, a larger one in thin or curved bodies.

    Parameters
    ----------
    put_right
        the correction, what was added to them, left and right [length]
    is_thick
        whether the bodies are half-planes or thick ones with flat faces
    """
    # _LEFT_OF_LACKED: share of the correction that may be wrong; _LEFT_OF_THIN: the same of thin
    # bodies
    share_left = _LEFT_OF_LACKED if is_thick else _LEFT_OF_THIN
    return np.asarray(share_left * np.abs(put_right))


class ContactsOfLoads(NamedTuple):
    """Half-widths of contact and loads P at k instants.

    Attributes
    ----------
    half_width
        (k,) a [length]
    load
        (k,) P; 0 where nothing is pressed [force per thickness]
    """

    half_width: Array
    load: Array

    def way_by_load(self, half_width: Array) -> Array:
        """P da/dP at any half-widths, the way of an edge by a relative change of the load: between
        those at the instants [length]. Zeros where no instant is loaded.

        `self.half_width` and `self.load` (k,) are a and P at the instants. The slope is read from
        P at 41 equally spaced half-widths from 0 to the largest.

        Examples
        --------
        >>> a = np.linspace(0.0, 1.0, 200)
        >>> hertz = ContactsOfLoads(half_width=a, load=a**2)
        >>> hertz.way_by_load(np.array([0.3, 0.8])).round(3).tolist()
        [0.15, 0.4]
        """
        is_pressed = self.load > 0
        if not is_pressed.any():
            return np.zeros_like(half_width)
        order_of_widths = np.argsort(self.half_width[is_pressed])
        known_half_widths = np.append(0.0, self.half_width[is_pressed][order_of_widths])
        known_loads = np.append(0.0, self.load[is_pressed][order_of_widths])
        even_half_widths = np.linspace(0.0, known_half_widths[-1], _WIDTHS + 1)
        even_loads = np.interp(even_half_widths, known_half_widths, known_loads)
        slope = np.gradient(even_loads, even_half_widths)  # dP/da
        way = np.divide(even_loads, slope, out=np.zeros_like(slope), where=slope > 0)
        return np.asarray(np.interp(half_width, even_half_widths, way))


def uncertainty_at_jumps(
    edges: Edges,
    contact: Array,
    step_index: Indices,
    spacing: float,
    first_of_cycle: int | None = None,
    is_turn: Mask | None = None,
) -> Array:
    """Uncertainty (k, 2) of stick edges at k instants, because the mesh may see a jump of an edge
    one increment too early or too late [length]: the length of the jump at the instants before and
    after it, else 0.

    Where a slip zone reaches an older edge of stick, the edge jumps inwards. Where slip ends, it
    jumps outwards. At an instant before or after the jump the true edge may be that of the other
    side of it. An edge may also go far inwards in one increment without a jump. That is assumed at
    an instant at which the edge is known well, unless slip starts in this increment. Moves up to
    six nodes are no jumps, or up to two where slip starts or ends. Where a stick zone vanishes or
    appears, its edges move to or from its middle.

    An increment ends where the loads turn round. Slip that ends from that instant on ends neither
    earlier nor later: such a jump is not uncertain.

    Parameters
    ----------
    edges
        of stick, left and right, (k, 2), with their uncertainty; NaN where nothing sticks
    contact
        (k, 2) edges of contact, where those of stick are while nothing slips [length]
    step_index
        (k,) index of the instants in the run: of instants between which others were dropped nothing
        is known
    spacing
        of the nodes at the edges of contact [length]
    first_of_cycle
        row of the first instant of the last cycle, which repeats: it follows the last instant too.
        None of a path without cycles
    is_turn
        (k,) instants at which the loads may turn round: increments end at all turning points of the
        loads and at vertices. None counts as nowhere
    """
    if is_turn is None:
        is_turn = np.zeros(len(step_index), dtype=bool)
    # A cycle is closed by one more row: its first instant again.
    if first_of_cycle is not None:
        rows = np.append(np.arange(len(step_index)), first_of_cycle)
        uncertainty_with_closing_row = uncertainty_at_jumps(
            Edges(edges.places[rows], edges.uncertainty[rows]),
            contact[rows],
            np.append(step_index, step_index[-1] + 1),
            spacing,
            is_turn=is_turn[rows],
        )
        return uncertainty_with_closing_row[:-1]

    uncertainty = np.zeros(edges.places.shape)
    is_next_increment = np.diff(step_index) == 1
    middle = _middle_of_zone(edges.places)  # (k,)
    # _ON_ITS_WAY: share of the spacing up to which an edge is known well
    is_on_its_way = edges.uncertainty < _ON_ITS_WAY * spacing
    for column, outwards in enumerate((-1, 1)):  # left and right edges
        # Moves from instant to instant, (k - 1,), positive outwards; those that are jumps.
        places = np.where(np.isnan(edges.places[:, column]), middle, edges.places[:, column])
        moves = outwards * np.where(is_next_increment, np.diff(places), 0.0)
        has_slip_zone = edges.places[:-1, column] != contact[:-1, column]
        slip_starts = (moves < 0) & ~has_slip_zone
        slip_ends = (moves > 0) & has_slip_zone
        # _JUMP_AT_START: fewest nodes of a jump where slip starts or ends; JUMP: elsewhere
        least_jump = np.where(slip_starts | slip_ends, _JUMP_AT_START, JUMP) * spacing
        is_jump = (np.abs(moves) > least_jump) & ~(slip_ends & is_turn[:-1])
        jumps = np.where(is_jump, np.abs(moves), 0.0)

        # The instant before each move, then the one after it.
        for rows_beside in (slice(None, -1), slice(1, None)):
            is_uncertain = (moves > 0) | slip_starts | ~is_on_its_way[rows_beside, column]
            uncertainty[rows_beside, column] = np.maximum(
                uncertainty[rows_beside, column], np.where(is_uncertain, jumps, 0.0)
            )
    return uncertainty


def _middle_of_zone(edges: Array) -> Array:
    """Middle of the stick zone at k instants, (k,), from its edges (k, 2), NaN where there is no
    zone: then that of the nearest instant before, or else after it, that has one.
    """
    middle = edges.mean(axis=1)
    rows_with_zone = np.flatnonzero(np.isfinite(middle))
    if not len(rows_with_zone):
        return middle
    nearest_position = np.searchsorted(rows_with_zone, np.arange(len(middle)), side="right") - 1
    return np.asarray(middle[rows_with_zone[np.maximum(nearest_position, 0)]])


class _Side(NamedTuple):
    """One side of the contact, read outwards; the left one is reflected.

    Attributes
    ----------
    column
        0 of the left, 1 of the right
    sign
        of x outwards
    x
        (n,) nodes outwards [length]
    """

    column: int
    sign: float
    x: Array

    def outwards(self, *rows: NDArray) -> tuple[NDArray, ...]:
        """Rows (k, n) of values at the nodes, in the order in which this side is read outwards: the
        left one (`column` 0) from right to left.
        """
        return rows if self.column == 1 else tuple(row[:, ::-1] for row in rows)


def _sides(x: Array) -> tuple[_Side, _Side]:
    """The left and the right side of a contact with nodes at x (n,), each read outwards; x of the
    left one is reflected.
    """
    return _Side(0, -1.0, -x[::-1]), _Side(1, 1.0, x)


def _value_at_node(rows: NDArray, index: Indices) -> NDArray:
    """Of each of k rows (k, n) the value at its own node, (k,); `index` (k,) are the nodes."""
    return rows[np.arange(len(rows)), index]


def _outermost_in_contact(in_contact: Mask) -> Indices:
    """Outermost node of each row that is in contact, (k,); `in_contact` (k, n), read outwards."""
    return np.asarray(in_contact.shape[1] - 1 - np.argmax(in_contact[:, ::-1], axis=1))


def _closed_nodes_of_side(side: _Side, is_closed: Mask, is_stuck: Mask | None = None) -> Mask:
    """Closed nodes on one side of the place that parts left and right, a mask (k, n); a node at
    that place belongs to the right side.

    The place is half-way between the first and the last closed node. Where `is_stuck` is given and
    nodes stick, it is the middle one of the sticking nodes.

    Parameters
    ----------
    side
        left or right: x (n,) of the nodes, and all rows, are read outwards, those of the left side
        reflected; `sign` is that of x outwards
    is_closed, is_stuck
        (k, n) nodes that touch, and that stick, at k instants
    """
    is_right = side.sign > 0
    first_x = side.x[np.argmax(is_closed, axis=1)]  # of the first and the last closed node
    last_x = side.x[_outermost_in_contact(is_closed)]
    parting_x = ((first_x + last_x) / 2)[:, None]
    if is_stuck is not None:
        sticks_in_contact = is_stuck & is_closed
        rank = np.cumsum(sticks_in_contact, axis=1)  # number of sticking nodes up to each
        n_sticking_nodes = rank[:, -1:]
        # Counted from the left for both sides, so that both have the same middle node.
        middle_rank = (n_sticking_nodes + 1) // 2 if is_right else n_sticking_nodes // 2 + 1
        middle_node = np.argmax(sticks_in_contact & (rank == middle_rank), axis=1)
        parting_x = np.where(n_sticking_nodes > 0, side.x[middle_node][:, None], parting_x)
    return np.asarray(is_closed & ((side.x >= parting_x) if is_right else (side.x > parting_x)))


def _last_sticking(is_stuck: Mask, is_in_half: Mask) -> tuple[Indices, Indices, Indices]:
    """Last node of the stick zone on a side of the middle, how many nodes the zone has there, and
    how many the side, (k,) each.

    Its end is where the fewest nodes are on the wrong side of it, the farthest out where it is a
    tie. Where the zone has no nodes the last of them is without meaning. `is_stuck` (k, n) are the
    nodes that stick, `is_in_half` (k, n) those in contact on the side.
    """
    n_sticking_up_to_node = np.cumsum(is_stuck & is_in_half, axis=1, dtype=np.int32)
    n_nodes_up_to_node = np.cumsum(is_in_half, axis=1, dtype=np.int32)
    # Sliding nodes up to this one, and sticking ones behind it, but for a number that is the same
    # for all.
    n_misplaced = np.where(
        is_in_half, n_nodes_up_to_node - 2 * n_sticking_up_to_node, is_in_half.shape[1] + 1
    )
    last_node: Indices = is_in_half.shape[1] - 1 - np.argmin(n_misplaced[:, ::-1], axis=1)
    n_sticking_nodes: Indices = np.where(
        _value_at_node(n_misplaced, last_node) <= 0,
        _value_at_node(n_nodes_up_to_node, last_node),
        0,
    )
    return last_node, n_sticking_nodes, n_nodes_up_to_node[:, -1].astype(np.int64)


def _larger_spacing(x: Array, node: Indices) -> Array:
    """The larger distance of nodes from their neighbours; x (n,) ascending, `node` of any shape."""
    distances = np.concatenate([[0.0], np.diff(x), [0.0]])
    return np.maximum(distances[node], distances[node + 1])


class _FittedLines(NamedTuple):
    """Zeros and misfits of straight lines that were fitted to the squares of nodal values, one line
    for each of k instants.

    Attributes
    ----------
    zero
        (k,) place x at which each line is zero; NaN where it does not fall outwards [length]
    misfit
        (k,) root mean square distance of the squares from each line, over its slope [length]
    """

    zero: Array
    misfit: Array


def _lines_through_squares(
    outward_x: Array, values: Array, last_node: Indices, count: int
) -> _FittedLines:
    """Straight lines fitted to the squares of `values` (k, n) at `count` nodes before the last, one
    for each of k instants: the place where each is zero, and its misfit, both as lengths. The
    misfit is the root mean square distance of the squares from the line, over its slope. Both are
    NaN where a line does not fall outwards.

    `outward_x` (n,) are the nodes, read outwards, `last_node` (k,) the last one at each instant.
    """
    nodes = last_node[:, None] - np.arange(1, count + 1)
    distance = outward_x[nodes] - outward_x[last_node][:, None]
    squares = np.take_along_axis(values, nodes, axis=1) ** 2
    mean_distance = distance.mean(axis=1, keepdims=True)
    mean_square = squares.mean(axis=1, keepdims=True)
    distance_from_mean = distance - mean_distance
    slope = (distance_from_mean * squares).sum(axis=1) / (distance_from_mean**2).sum(axis=1)
    falling_slope = np.where(slope < 0, slope, np.nan)
    zero_point = outward_x[last_node] + mean_distance[:, 0] - mean_square[:, 0] / falling_slope
    residual = squares - mean_square - slope[:, None] * distance_from_mean
    misfit = np.sqrt(np.mean(residual**2, axis=1)) / -falling_slope
    return _FittedLines(zero_point, misfit)


class _StickFit(NamedTuple):
    """Edges of the stick zone on one side at k instants, from the shear inside it.

    Attributes
    ----------
    edge, misfit
        (k,) zero of the straight line, and its misfit [length]
    agrees
        (k,) whether this zero counts as an edge. It does not where the squares do not fall towards
        the edge, or where the zero is not near the last node. Nor does it where a line through four
        of the nodes has another zero: an older stick edge is near
    """

    edge: Array
    misfit: Array
    agrees: Mask


def _fitted_stick_edge(outward_x: Array, stress_to_limit: Array, last_node: Indices) -> _StickFit:
    """Edge of the stick zone on one side at k instants: the zero of a straight line through the
    squares of f p -+ q at seven nodes, since this falls to zero as the square root of the distance.

    Also the misfit of the line, as a length, and whether its zero is accepted. Two conditions hold
    then. A line through four of these nodes has its zero within a tenth of an element. The zero is
    no farther than an element from the last node.

    Parameters
    ----------
    outward_x
        (n,) nodes, read outwards: of the left side x with the opposite sign
    stress_to_limit
        (k, n) what the shear in the sense of the slip beyond the edge lacks of f p [stress]
    last_node
        (k,) last node of the stick zone by its states, at least seven nodes before it
    """
    # distance of two nodes: an element of order 2
    element_size = outward_x[last_node] - outward_x[last_node - 2]
    # _FITTED: numbers of nodes of two fits, seven and four
    line, line_of_fewer = (
        _lines_through_squares(outward_x, stress_to_limit, last_node, count) for count in _FITTED
    )
    agrees = np.abs(line.zero - line_of_fewer.zero) <= _AGREE * element_size
    is_near = np.abs(line.zero - outward_x[last_node]) <= element_size
    return _StickFit(line.zero, line.misfit, agrees & is_near)
