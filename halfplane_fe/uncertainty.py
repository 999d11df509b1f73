"""How far each value may be from the true one, by mesh: one rule from two meshes.

    u = F |v_h - v_H| / |r^p - 1| + round-off

v_h is the value of the run and v_H that of the coarse run. r is the ratio of their element sizes at
the place where the quantity lives, and p the order of its error there. The factor F is one number
for each quantity, fitted to random scenes and held to others (`benchmarks/covered.py values`).
Where there is no second mesh, or one that is hardly finer or coarser, there is no estimate.

Two meshes may agree by chance in what lives at a few nodes: the largest slip and the largest W(x).
Their uncertainty also follows from how these differ from the nodes beside them. W and the largest
pressure have further terms, where the difference alone does not cover them.

# notation: h, H element sizes of the run and of the coarse run; a half-width; A = 2/E*; f
coefficient of friction; U relative tangential displacement
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from halfplane_fe.between_nodes import EdgesByLoad
from halfplane_fe.contact import InterfaceState
from halfplane_fe.edges import contact_edges_of_states
from halfplane_fe.interface import Interface
from halfplane_fe.resolution import SMOOTH_TIP, exponent_at_tip, flanks
from halfplane_fe.run import PathRun
from halfplane_fe.slip_between_nodes import largest_slip_of_cycle
from meshes import MeshSettings, SurfaceGrading
from scenes import Profile, Tolerances
from scenes.array_types import Array, Indices, Mask

# Refinement from the coarse run below which their difference gives no estimate.
_LEAST_REFINEMENT = 1.4
# Round-off error over the largest value: of a compliance that was factorised.
_ROUND_OFF = 1e-11
# Difference of two instants that are the same, over the length of the path.
_SAME_INSTANT = 1e-9


class Place(NamedTuple):
    """A place where the mesh makes an error of a known order.

    Attributes
    ----------
    refinement
        r, size of the coarse run's elements there over that of the run's
    order
        p, exponent: the error falls as the element size to the power p
    """

    refinement: float
    order: float

    def share_left(self) -> float:
        """Error of the run over its difference from the coarse run, 1/|r^p - 1|; infinite where the
        elements are alike.

        With errors C h^p and C H^p, r = H/h the refinement, the difference is C h^p (r^p - 1).

        >>> (
        ...     Place(refinement=4.0, order=0.5).share_left(),
        ...     Place(refinement=0.5, order=1.0).share_left(),
        ... )
        (1.0, 2.0)
        """
        difference_over_error = abs(self.refinement**self.order - 1)
        return 1 / difference_over_error if difference_over_error else math.inf


@dataclass(frozen=True)
class Rule:
    """How the uncertainty of a quantity follows from two meshes.

    Attributes
    ----------
    order
        p
    factor
        F
    """

    order: float
    factor: float

    def uncertainty(self, value: float, difference: float, refinement: float) -> float:
        """Uncertainty of a value from its difference between two meshes; NaN where the element
        sizes of both differ by a factor of less than 1.4.

        With an error of the order p in the element size (`order`), r the refinement, it is the
        factor F (`factor`) times the difference over |r^p - 1|, plus round-off.

        Parameters
        ----------
        value, difference
            size of the value, and its difference from that of the coarse run
        refinement
            element of the coarse run over that of the run

        Examples
        --------
        >>> rule = Rule(order=2.0, factor=1.5)
        >>> round(rule.uncertainty(value=1.0, difference=0.015, refinement=4.0), 9)
        0.0015
        >>> rule.uncertainty(value=1.0, difference=0.0, refinement=1.2)
        nan
        """
        # _LEAST_REFINEMENT: least ratio of the element sizes of both meshes
        if 1 / _LEAST_REFINEMENT < refinement < _LEAST_REFINEMENT:
            return math.nan
        # error of the run: the difference over |r^p - 1|
        error = difference * Place(refinement, self.order).share_left()
        # _ROUND_OFF: relative round-off
        return self.factor * error + _ROUND_OFF * value


# Fitted to scenes that slip, seeds 242, 243, 250 and 251 of benchmarks/covered.py values, both
# presets.
RULES: dict[str, Rule] = {
    # U and the approach are those of all the body. Its elements grow away from the contact, and
    # behind it they differ less from those of the coarse run than at the edges: the error falls by
    # the first power of these. It is 0.3 to 1.6 of |v_h - v_H|/(r - 1).
    "tangential_displacement": Rule(order=1.0, factor=1.75),
    "normal_approach": Rule(order=1.0, factor=3.0),
}
"""By the name of the quantity."""


# The largest slip is that of straight lines between nodes, and from the last ones that touch to the
# edge of contact (`slip_between_nodes`). Its error has two parts that are known from one mesh.
# A share of it is left however wide the slip zone is: the distance of the nodes over the half-width
# times
_SLIP_BY_SPACING = 0.15
# Where the zone is only n nodes wide, slip bends between them: n^-1.5 of its change from node to
# node, times the following. The change is 1/n of the largest slip, about.
_SLIP_BY_CHANGE = 3.0
# Where both are small by chance, the difference of two meshes counts, of order 1.5. Fitted to seeds
# 601 to 603 and 706 of benchmarks/covered.py values.
SLIP_RULE = Rule(order=1.5, factor=0.15)
# W over A f^2 P^2, P the largest load, below which the largest slip has no estimate: of a tabulated
# profile in full stick but for 1e-12 of A f^2 P^2 the mesh saw a thousandth of the slip.
_LEAST_WORK_OF_SLIP = 1e-8
# Error of U and the approach over Q/E* (h/a)^2 and P/E* (h/a)^2, h the element at the edges of a
# contact as small as at the start of the loading: 0.04 to 0.11 where it is the largest of a path.
_BY_SMALL_CONTACT = 0.08


# Shares of how far W(x) stands off the straight line between its neighbours, which is the curvature
# that elements leave, and of how much farther it does so at a node than at those beside it: a
# single node that stands out, as at a kink, is wrong by more. The largest of the peak and the node
# on either side count: W(x) may follow the line at one of them by chance. Seeds 701 to 705 of
# benchmarks/covered.py values, both presets.
_BY_NEIGHBOURS = 0.19
_BY_STANDING_OUT = 0.42
# Least u of the largest W(x), by the difference of two meshes: where a narrow slip zone as a whole
# is wrong, nodes beside each other agree. W of a wedge was 2.4 times as wrong as stated there.
DENSITY_RULE = Rule(order=1.0, factor=0.27)
# Share of the largest W(x) by which it stands off where it is that of a single node: of scenes that
# hardly slip it may be wrong altogether. At most 0.6 of others.
_ALONE = 0.75
# Shares, for p and for q, of the norm of what stands off the line between neighbours that the norm
# of the error is, each the largest of a cycle: 0.14 to 0.39 and 0.10 to 0.43 on seed 205, both
# presets; of q up to 0.53 on seed 232, coarse.
_PRESSURE_BY_NEIGHBOURS = 0.39
_SHEAR_BY_NEIGHBOURS = 0.46
# Instants whose norms are taken together.
_AT_ONCE = 256


def density_uncertainty(x: Array, density: Array) -> float:
    """Uncertainty of the largest friction work per area, W(x): by how far nodes there stand off the
    straight line between their neighbours, which is what every second node alone would give
    [energy / area].

    W(x) has a kink where an edge of contact or stick turns, and its largest value is near one: a
    coarse run alone agrees with it by chance. Two parts are added: a share of how far a node stands
    off, and a share of how much farther it does than the nodes beside it. Each is the largest of
    that node and the two beside it. NaN where the largest value is 0 or at an end node, and where
    it stands alone: its neighbours' line is more than 0.75 of it below.

    Parameters
    ----------
    x
        (n,) nodes in ascending order [length]
    density
        (n,) W(x) [energy / area]

    Examples
    --------
    >>> x = np.arange(7.0)
    >>> round(density_uncertainty(x, np.array([0.0, 3, 4, 5, 4, 3, 0])), 12)
    0.61
    """
    peak_node = int(np.argmax(density))
    if not 0 < peak_node < len(x) - 1 or density[peak_node] <= 0:
        return math.nan
    deviations = np.pad(_deviations_from_neighbours(x, density), 1)  # 0 at the ends
    # _ALONE: share of the largest value by which it stands alone
    if abs(deviations[peak_node]) > _ALONE * density[peak_node]:
        return math.nan
    # how much farther off each node is than the mean of the two beside it
    excess_deviations = np.zeros_like(deviations)
    excess_deviations[1:-1] = deviations[1:-1] - (deviations[:-2] + deviations[2:]) / 2
    around_peak = slice(peak_node - 1, peak_node + 2)
    # _BY_NEIGHBOURS: fitted share; _BY_STANDING_OUT: another
    return float(
        _BY_NEIGHBOURS * np.max(np.abs(deviations[around_peak]))
        + _BY_STANDING_OUT * np.max(np.abs(excess_deviations[around_peak]))
    )


def _deviations_from_neighbours(x: Array, values: Array) -> Array:
    """How far nodal values (..., n) at nodes x (n,) are from the straight line between their two
    neighbours, (..., n - 2): of all nodes but the first and the last.
    """
    # place of each node between its neighbours: 0 at the left one, 1 at the right one
    share = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
    return np.asarray(values[..., 1:-1] - (1 - share) * values[..., :-2] - share * values[..., 2:])


def norm_uncertainties(
    x: Array, pressure: Array, shear: Array, is_counted: Mask, friction: float
) -> dict[str, float]:
    """Relative uncertainties of p and q in the L2 norm over x, "pressure" and "shear": over the
    norm of p, and of f p.

    Each is a fixed share of the norm of how far nodal values stand off the straight line between
    those of their neighbours, at the worst of the instants that count. NaN where none counts.

    Parameters
    ----------
    x
        (n,) nodes in ascending order [length]
    pressure, shear
        (k, n) [stress]
    is_counted
        (k,) instants that count, all of them in contact
    friction
        f; 0 has no error of q
    """
    # Norm of the departure of p or q from the line between its neighbours: of p over the norm of p,
    # of q over the norm of f p. Each entry is the largest of a block of instants.
    shares_of_p = [0.0]
    shares_of_q = [0.0]
    instants = np.flatnonzero(is_counted)
    # Some instants at a time: of a fine mesh with thousands of steps each copy takes gigabytes.
    # _AT_ONCE: number of instants of a block
    for start_of_block in range(0, len(instants), _AT_ONCE):
        instants_of_block = instants[start_of_block : start_of_block + _AT_ONCE]
        norm_of_p = _norm(x, pressure[instants_of_block])
        share_of_p = (
            _norm(x[1:-1], _deviations_from_neighbours(x, pressure[instants_of_block])) / norm_of_p
        )
        shares_of_p.append(float(share_of_p.max()))
        if friction:
            share_of_q = (
                _norm(x[1:-1], _deviations_from_neighbours(x, shear[instants_of_block])) / norm_of_p
            )
            shares_of_q.append(float(share_of_q.max()) / friction)
    if not len(instants):
        return {"pressure": math.nan, "shear": math.nan}
    # _PRESSURE_BY_NEIGHBOURS: fitted shares, of p and of q
    return {
        "pressure": _PRESSURE_BY_NEIGHBOURS * max(shares_of_p),
        "shear": _SHEAR_BY_NEIGHBOURS * max(shares_of_q),
    }


def _norm(x: Array, values: Array) -> Array:
    """L2 norm over x of each of k rows of values (k, n) at nodes x (n,): (k,)."""
    return np.asarray(np.sqrt(np.trapezoid(np.square(values), x, axis=-1)))


def of_small_contacts(load: Array, elements: Array, half_width: Array, modulus: float) -> float:
    """Error of a displacement by contacts a few elements wide, the largest of the path [length].

    Where P begins to grow, the contact is no wider than an element. Two meshes are compared by
    values of whole cycles, none of them that small: their difference does not show it. The error is
    a fitted share of the load over E* times (h/a)^2, which counts as 1 at most; h is the size of
    elements, a the half-width of contact.

    Parameters
    ----------
    load
        (k,) Q, or P [force per thickness]
    elements
        (k,) size of the elements at the edges of contact [length]
    half_width
        (k,) a; 0 out of contact [length]
    modulus
        E* [stress]

    Examples
    --------
    >>> of_small_contacts(np.array([3.0]), np.array([0.1]), np.array([0.2]), modulus=3.0)
    0.02
    """
    is_touching = half_width > 0
    relative_size = np.minimum(elements[is_touching] / half_width[is_touching], 1.0)
    displacements = np.abs(load[is_touching]) / modulus * relative_size**2
    return _BY_SMALL_CONTACT * float(displacements.max(initial=0.0))


@dataclass(frozen=True, eq=False)
class RunValues:
    """Values of one load cycle of a run, or of a path that does not repeat, in which two runs of a
    scene are compared.

    Attributes
    ----------
    since_start
        (k,) instants, counted from the start of the cycle
    tangential_displacement, normal_approach
        (k,) [length]
    largest_slip
        largest range of the slip of any place while it is in contact [length]; 0 where that is
        round-off error of the slip
    slip_to_next_nodes
        change of that range per distance of nodes, the mean over the two nodes inside of the place
        [length]
    largest_dissipation_density
        largest W(x) [energy / area]
    number
        number of the cycle, from 1; 0 of a path that does not repeat
    repeats
        whether the cycle is the last one of the run and ended as it started
    """

    since_start: Array
    tangential_displacement: Array
    normal_approach: Array
    largest_slip: float
    slip_to_next_nodes: float
    largest_dissipation_density: float
    number: int
    repeats: bool

    def is_comparable(self, second_values: RunValues) -> bool:
        """Whether the values of two runs are of the same cycle of the path, by its `number`, or
        both of a cycle that repeats.
        """
        return self.number == second_values.number or (self.repeats and second_values.repeats)

    def difference(self, name: str, second_values: RunValues) -> float:
        """Difference of a quantity between two runs: of a series the largest at the instants that
        both have. `name` is that of an attribute, a number or a series (k,).
        """
        values_of_first = np.asarray(getattr(self, name))
        values_of_second = np.asarray(getattr(second_values, name))
        if values_of_first.ndim:
            # indices of the common instants in either run
            indices_in_first, indices_in_second = _common_instants(
                self.since_start, second_values.since_start
            )
            values_of_first = values_of_first[indices_in_first]
            values_of_second = values_of_second[indices_in_second]
        return float(np.max(np.abs(values_of_first - values_of_second), initial=0.0))


def run_values(
    run: PathRun,
    interface: Interface,
    displacement_unit: float,
    stress_unit: float,
    cycle: int | None = None,
) -> RunValues:
    """Values of a load cycle of a run, or of a path that does not repeat, to be compared with those
    on another mesh. They are instants since its start, tangential displacement U, approach, largest
    slip and largest friction work per area W(x), in the scene's units.

    Parameters
    ----------
    run
        a run along the load path, scaled:

        - `states`: contact states;
        - `cycle_starts`: index of the state at which each cycle starts;
        - `nodal_work_by_cycle`: (n,) friction work of the nodes, one array for each cycle;
        - `steady_from`: number, from 0, of the cycle that ended as it started; None without one.
    interface
        places of the n nodes, and length of face that each stands for, over the unit of length
    displacement_unit, stress_unit
        what displacements and stresses of the run are multiplied by [length], [stress]
    cycle
        number of the cycle, from 1; the last one by default
    """
    # States of the cycle, from its start to that of the next one. `cycle_number` is 0 on a path
    # that does not repeat: then all states.
    cycle_number = cycle or len(run.cycle_starts)
    first_index = run.cycle_starts[cycle_number - 1] if cycle_number else 0
    has_next_cycle = cycle_number < len(run.cycle_starts)
    rows = slice(first_index, run.cycle_starts[cycle_number] + 1 if has_next_cycle else None)
    states = run.states[rows]

    # Largest slip; 0 where it is round-off.
    time = np.array([state.time for state in states])
    slip = np.array([state.slip for state in states])
    is_closed = np.array([state.is_closed for state in states])
    edges_by_load = EdgesByLoad.joined(run.contact_edges).at(rows)
    edges = _contact_edges(interface, states, edges_by_load)
    largest = largest_slip_of_cycle(interface.x, slip, is_closed, edges)
    largest_slip = largest.value
    # _ROUND_OFF: relative round-off
    if largest_slip <= _ROUND_OFF * float(np.max(np.abs(slip))):
        largest_slip = 0.0

    work_of_nodes = np.zeros_like(interface.face_lengths)
    if run.nodal_work_by_cycle:
        work_of_nodes = run.nodal_work_by_cycle[cycle_number - 1]
    return RunValues(
        since_start=time - time[0],
        tangential_displacement=np.array([state.shift for state in states]) * displacement_unit,
        normal_approach=np.array([state.approach for state in states]) * displacement_unit,
        largest_slip=largest_slip * displacement_unit,
        slip_to_next_nodes=largest.change_to_nodes * displacement_unit,
        largest_dissipation_density=float(np.max(work_of_nodes / interface.face_lengths))
        * displacement_unit
        * stress_unit,
        number=cycle_number,
        repeats=run.steady_from is not None and not has_next_cycle,
    )


def _contact_edges(
    interface: Interface, states: Sequence[InterfaceState], edges_by_load: EdgesByLoad
) -> Array:
    """Left and right edge of contact in k states, (k, 2), scaled; NaN without contact.

    Those that a load locates are given. Others follow from the form of pressure and gap at the
    outermost nodes of the interface. States of long runs that have dropped these end at the
    outermost node that touches.
    """
    edges = np.full((len(states), 2), math.nan)
    is_complete = np.array([state.is_complete for state in states])
    edges[is_complete] = contact_edges_of_states(
        interface, [state for state in states if state.is_complete]
    )
    for row in np.flatnonzero(~is_complete).tolist():
        closed_nodes = np.flatnonzero(states[row].is_closed)
        if len(closed_nodes):
            edges[row] = interface.x[closed_nodes[[0, -1]]]
    return np.where(edges_by_load.last_node >= 0, edges_by_load.places, edges)


@dataclass(frozen=True)
class Meshes:
    """What counts of the two meshes on which a quantity is compared.

    Attributes
    ----------
    refinement
        r at the edges of contact: element size of the coarse run over that of the run, there of the
        body with the larger elements
    has_low_order
        whether the run has linear elements or a penalty layer: the difference counts in full then
    """

    refinement: float
    has_low_order: bool


def displacement_uncertainties(
    values: RunValues, coarse_values: RunValues | None, meshes: Meshes, has_shear: bool
) -> dict[str, float]:
    """Uncertainty of tangential displacement and normal approach by their names [length], from the
    difference of two meshes; NaN without an estimate, as where both runs are not of comparable load
    cycles.

    For each name `RULES` has the order of its error in the element size, and a factor.

    Parameters
    ----------
    values
        displacements of the run at the instants of a cycle
    coarse_values
        those of the coarse run; None where the bodies are shared, without a coarse run of this
        scene
    meshes
        the two meshes: `refinement`, element size of the coarse run over that of the run, and
        whether the difference counts in full (`has_low_order`: linear elements, penalty layers)
    has_shear
        whether any shear can arise: then a displacement that is zero at all instants of the run
        has no estimate
    """
    if coarse_values is None or not values.is_comparable(coarse_values):
        return dict.fromkeys(RULES, math.nan)
    estimates: dict[str, float] = {}
    for name, rule in RULES.items():
        largest_value = float(np.max(np.abs(getattr(values, name))))
        if has_shear and largest_value == 0:
            estimates[name] = math.nan
            continue
        difference = values.difference(name, coarse_values)
        estimate = rule.uncertainty(largest_value, difference, meshes.refinement)
        estimates[name] = max(estimate, difference) if meshes.has_low_order else estimate
    return estimates


def slip_uncertainty(
    values: RunValues,
    coarse_values: RunValues | None,
    scaled_work: float,
    relative_spacing: float,
    meshes: Meshes,
) -> float:
    """Uncertainty of the largest slip by the nodes beside it, and by the difference of two meshes
    where both are of comparable load cycles [length]; NaN where next to nothing slips, and for
    errors of low order without such a difference.

    Parameters
    ----------
    values, coarse_values
        of the run and of the coarse run, None without one: largest slip, and mean change of its
        range to the next nodes (`slip_to_next_nodes`)
    scaled_work
        W over A f^2 P^2, A = 2/E*, f the coefficient of friction, P the largest load
    relative_spacing
        distance of the nodes at the edges of contact, over the half-width
    meshes
        the two meshes: `refinement`, element size of the coarse run over that of the run, and
        whether the difference counts in full (`has_low_order`: linear elements, penalty layers)
    """
    # _LEAST_WORK_OF_SLIP: W below which next to nothing slips
    if values.largest_slip == 0 or scaled_work < _LEAST_WORK_OF_SLIP:
        return math.nan
    # share of the slip that is gained from one node to the next: 1/n of a zone of n nodes
    change = values.slip_to_next_nodes
    share_of_change = change / values.largest_slip
    # _SLIP_BY_SPACING, _SLIP_BY_CHANGE: fitted shares
    estimate = (
        _SLIP_BY_SPACING * relative_spacing * values.largest_slip
        + _SLIP_BY_CHANGE * share_of_change**1.5 * change
    )
    if coarse_values is None or not values.is_comparable(coarse_values):
        return math.nan if meshes.has_low_order else estimate
    difference = values.difference("largest_slip", coarse_values)
    estimate += float(
        np.nan_to_num(SLIP_RULE.uncertainty(values.largest_slip, difference, meshes.refinement))
    )
    return max(estimate, difference) if meshes.has_low_order else estimate


def _common_instants(instants: Array, other_instants: Array) -> tuple[Indices, Indices]:
    """Instants that two ascending series have in common: their indices in the first and in the
    second. They agree to 1e-9 of the last instant (of 1 if that is less).
    """
    tolerance = _SAME_INSTANT * max(float(instants[-1]), 1.0)
    next_instants = np.searchsorted(other_instants, instants - tolerance)
    nearest_rows = np.minimum(next_instants, len(other_instants) - 1)
    is_common = np.abs(other_instants[nearest_rows] - instants) <= tolerance
    return np.flatnonzero(is_common), nearest_rows[is_common]


# Shares of the mesh in the uncertainty of W, fitted to seeds 284 to 286, 293, 321, 401 to 405 and
# 701 to 705 of benchmarks/covered.py values, both presets. Of its difference from the coarse run's
# over r^2 - 1,
_OF_DIFFERENCE = 1.2
# and of W (h/a)^2: W is mostly too small, by 0.2 to 1.3 of that.
_OF_WORK = 0.9
# Share of the root of W A f^2 P^2, times (h/a)^2, where nothing is taken off for edges between
# nodes, as their slip zones are narrow: up to 0.5 where both meshes agree by chance.
_OF_UNPLACED_EDGES = 0.1
# Share of the rms of what edges between nodes add to W, where that is taken off (`between_nodes`).
_OF_SCATTER = 0.4
# Share of A f^2 P^2 (h/a)^2 that they add where nothing is known of them, as of bodies whose stick
# edges are not placed: 0.006 to 0.015 where that is the largest term.
_OF_UNKNOWN_EDGES = 0.013
# W over A f^2 P^2 (h/a)^2 up to which all of W may be false: elements dissipate 0.024 to 0.04 where
# nothing slips and nearly all of the contact does.
_FALSE_WORK = 0.05
# Least share of W over the fourth power of the growth of elements away from the edges, the order of
# quadratic elements: on four scenes 1e-6 to 3e-6 at 0.12, 1e-5 to 2.5e-5 at 0.2, 1e-4 to 3.3e-4 at
# 0.4.
_GROWN = 0.009
# Share of W over the square of the elements that resolve the flank of a flat punch, the rounded
# part of its contact: 0.08 at 4.4 elements and 0.09 at 0.9, beyond a flat of 0.94 a; 0.75 of two
# scenes that hardly slip. Compounds and wedges, whose pressure is less steep there, show nothing.
_BY_FLANK = 0.28
# Safety factor of a difference whose order is known (Roache 1994).
_SAFETY = 1.25
# Share of p0 (h/a)^1.5 a/d, d from the peak to the edge, that edges between nodes move it by, where
# p is a root: for x^1.9 0.027, 0.043 and 0.036 at h = a/32, a/160 and a/640; 0.03 to 0.04 in the
# median of random half-planes. Fitted with the next one, by an optimiser, to seeds 284 to 286, 293,
# 321 and 401 to 405 of benchmarks/covered.py values, both presets.
_PEAK_BY_EDGES = 0.054
# Share of how far nodes around the peak stand off the straight line between their neighbours: what
# the elements there leave of a curved pressure, of its kinks and of the rows of a table. Of smooth
# profiles whose peak lies between the large elements of the middle 0.01 to 0.15, and 0.3 of two of
# 55 of seed 288.
_PEAK_BY_NEIGHBOURS = 0.12
# Share of p0 over the fourth power of the growth of elements away from the edges, as of W: 5e-4 of
# x^1.7 at 0.5, of which the other terms cover a part.
_PEAK_GROWN = 0.003
# Share of p0 that eight elements within a rounded tip leave: 1.6e-4 of a sharp wedge on the default
# mesh, 1.3e-4 on a fine one.
_PEAK_WITHIN_TIP = 3e-4
# Share of the scatter of nodes about the peak by which the largest of them may stray: 0.4 to 0.7 of
# blocks near sliding on the default mesh, and of a flat pad on meshes of a/250 and a/320. From row
# to row of a table the pressure on the default mesh was 2 to 4.5 times as wrong as stated without.
_PEAK_BY_SCATTER = 0.6
# Share of the scatter of the peak's own node by which corner and mid-side nodes alternate about the
# pressure. Where they alternate by 1 about a smooth pressure, `scatter_of_nodes` is 16/6, so that
# the share counts 1.07 of it: the error was 1.5 to 1.9 of it in the four Hertz scenes of the
# library whose p0 was 1.04 to 1.5 times as wrong as stated without this term.
_PEAK_BY_ALTERNATION = 0.4
# Nodes on either side of the peak among which the node counts that stands off its neighbours
# farthest.
_BESIDE_PEAK = 2
# Fourth difference of nodes of which one strays by 1 and its neighbours do not.
_OF_ONE_NODE = 6


def uncertainty(
    dissipation: float,
    difference: float,
    coarse_size: float,
    mesh: MeshSettings,
    scatter: float | None,
    has_low_order: bool,
) -> float:
    """Uncertainty of the friction work W of a load cycle by the mesh, over A f^2 P^2; NaN on a mesh
    hardly finer than that of the coarse run.

    Three terms are added up:

    - a share of the difference from the coarse run;
    - a share of W, by the element size or by its growth with the distance from the contact;
    - what edges of contact and stick add that lie between nodes.

    # notation: A = 2/E*, f coefficient of friction, P largest load, r ratio of the element sizes of
    # both meshes, h element size at the edges, a half-width

    Parameters
    ----------
    dissipation, difference
        W, and its difference from that of the coarse run, over A f^2 P^2
    coarse_size
        element size of the coarse run, over the half-width
    mesh
        settings: element size at the edges over the half-width, ratio of the upper body's elements,
        growth of the size with the distance from the contact
    scatter
        rms of what edges between nodes add to W, over A f^2 P^2, where that was subtracted from W;
        0 where nothing was, None where nothing is known of it
    has_low_order
        linear elements or a penalty layer, whose errors are not of order 2: the difference
        counts in full

    Examples
    --------
    >>> round(
    ...     uncertainty(
    ...         0.1, 0.01, 0.1, MeshSettings(edge_element_size=0.01), 1e-5, has_low_order=False
    ...     ),
    ...     12,
    ... )
    0.000134212121
    """
    element_size = mesh.edge_element_size * max(mesh.upper_ratio, 1.0)
    refinement = coarse_size / element_size
    # _LEAST_REFINEMENT: least ratio of the element sizes of both meshes
    if refinement < _LEAST_REFINEMENT:
        return float("nan")

    # Error of the run over that difference, 1/(r^2 - 1) for an error of order 2, times a fitted
    # share (_OF_DIFFERENCE).
    share_of_difference = _OF_DIFFERENCE / (refinement**2 - 1)
    if has_low_order:
        share_of_difference = max(share_of_difference, 1.0)
    # _OF_WORK: fitted share of W by the element size; _GROWN: by the growth of elements
    uncertainty_by_elements = dissipation * max(_OF_WORK * element_size**2, _GROWN * mesh.growth**4)
    # What edges between nodes add, by what is known of it (`scatter`).
    if scatter:
        # _OF_SCATTER: fitted share
        uncertainty_by_edges = _OF_SCATTER * scatter
    # _FALSE_WORK: W over (h/a)^2 up to which it may be false, 0.05
    elif dissipation < _FALSE_WORK * element_size**2:
        uncertainty_by_edges = dissipation  # all of it may be an error of the mesh
    elif scatter == 0:
        # _OF_UNPLACED_EDGES: fitted share of the root of W, times (h/a)^2
        uncertainty_by_edges = _OF_UNPLACED_EDGES * math.sqrt(dissipation) * element_size**2
    else:
        # _OF_UNKNOWN_EDGES: fitted share of (h/a)^2
        uncertainty_by_edges = _OF_UNKNOWN_EDGES * element_size**2
    return difference * share_of_difference + uncertainty_by_elements + uncertainty_by_edges


def share_of_flanks(profile: Profile, half_width: float, element: float) -> float:
    """Uncertainty of the work done on a contact, over that work, by the narrow flanks of a flat
    punch, where the pressure is steep; 0 of other profiles.

    The run and the coarse run may agree there by chance: neither has more than a few elements. The
    uncertainty is a share over the square of the number of elements that a Hertz contact as steep
    at its edge would have from middle to edge; 1 at most.

    Parameters
    ----------
    profile
        of the faces: its kinks are the ends of the flat
    half_width, element
        half-width of the contact, and size of the elements at its edge [length]

    Examples
    --------
    >>> from scenes import FlatRounded
    >>> punch = FlatRounded(radius=1000.0, flat_half_length=0.8)
    >>> round(share_of_flanks(punch, half_width=1.0, element=0.01), 6)
    0.000448
    """
    if profile.kind != "flat_rounded":
        return 0.0
    # _BY_FLANK: fitted share
    shares = [
        _BY_FLANK / flank.equivalent_hertz_elements**2
        for flank in flanks(profile, half_width, element)
    ]
    return min(max(shares, default=0.0), 1.0)


@dataclass(frozen=True)
class Peak:
    """The largest pressure of a run.

    Attributes
    ----------
    value
        [stress]
    change_from_coarse
        its difference from that of the coarse run [stress]
    half_width
        of the contact then [length]
    distance_to_edge
        distance of the peak from the nearer edge of contact [length]
    deviation_from_neighbours
        largest distance of a nodal pressure there from the straight line between its neighbours
        [stress]
    alternation
        by how much the node of the peak itself strays, `scatter_of_nodes` without others [stress]
    scatter
        by how much single nodes there stray, `scatter_of_nodes` [stress]; 0 where it does not count
    """

    value: float
    change_from_coarse: float
    half_width: float
    distance_to_edge: float
    deviation_from_neighbours: float
    alternation: float
    scatter: float = 0.0


def largest_deviation_from_neighbours(x: Array, pressure: Array, node: int) -> float:
    """Largest distance, among a node and the two nodes on either side, of the nodal pressure from
    the straight line between its neighbours [stress].

    >>> largest_deviation_from_neighbours(
    ...     np.arange(9.0), np.array([0.0, 3, 4, 5, 6, 5, 4, 3, 0]), node=4
    ... )
    1.0

    Parameters
    ----------
    x, pressure
        (n,) nodes in ascending order [length], and the pressure there at one instant [stress]
    node
        number of the node
    """
    differences = np.pad(_deviations_from_neighbours(x, pressure), 1)  # 0 at the ends
    differences_around = differences[max(node - _BESIDE_PEAK, 0) : node + _BESIDE_PEAK + 1]
    return float(np.max(np.abs(differences_around)))


def scatter_of_nodes(pressure: Array, node: int, n_beside: int) -> float:
    """Largest deviation of the pressure of a single node from a smooth curve through its neighbours
    [stress], among a node and `n_beside` nodes on either side. It is read off fourth differences,
    which are small of a smooth pressure.

    Near sliding, shear bends the pressure of coupled bodies by the mesh's error, one way at one
    node and the other way at the next. The node of the largest pressure is then the one that
    deviates most. One that deviates by 1 alone has a fourth difference of 6.

    Parameters
    ----------
    pressure
        (n,) of one instant [stress]
    node
        number of the node
    n_beside
        number of nodes on either side whose own deviations count too

    Examples
    --------
    >>> scatter_of_nodes(np.array([5.0, 5, 5, 5, 5, 6, 5, 5, 5, 5, 5]), node=5, n_beside=0)
    1.0
    """
    n_nodes_beside = n_beside + 2  # a fourth difference takes two more
    pressure_around = pressure[max(node - n_nodes_beside, 0) : node + n_nodes_beside + 1]
    fourth_differences = np.diff(pressure_around, n=4)
    return float(np.max(np.abs(fourth_differences), initial=0.0)) / _OF_ONE_NODE


def peak_uncertainty(
    peak: Peak,
    profile: Profile,
    coarse_size: float,
    fine_sizes: SurfaceGrading,
    growth: float,
    *,
    depth: float,
    has_low_order: bool,
) -> float:
    """Uncertainty of the largest pressure p0 of a run, from the difference of two meshes [stress].

    u = 1.25 |p_h - p_H| / |r^m - 1|, p_h of the run, p_H of the coarse run, r the ratio of their
    element sizes, m the order of the error. Five terms are added that this difference does not
    show: the place of the edges of contact, a curved or kinked pressure between the nodes around
    the peak, nodes that stray or alternate there, the growth of elements away from the edges, and a
    rounded tip.

    The order m follows from where the difference is made. With a tip it is made there: m = n - 1
    where the gap rises as |x|^n with n < 2, and 2 where the elements resolve that the tip is
    rounded. Elsewhere it is made by the edges of contact: 2, or 1 in bodies of finite depth. NaN
    where the elements there are nearly as large as those of the coarse run, or nothing touches.

    Parameters
    ----------
    peak
        the largest pressure, its difference from the coarse run, half-width of contact and distance
        to its edge then; how far nodes there stand off the line between their neighbours, and how
        much single nodes stray
    profile
        initial gap of the faces
    coarse_size
        size of the elements of the coarse run [length]
    fine_sizes
        sizes of the run's elements along the surface, at the edges and at a tip of the profile, of
        the body whose elements are larger
    growth
        of their size with the distance from the contact
    depth
        thickness of the thinner body; infinite of half-planes [length]
    has_low_order
        whether the run has linear elements or a penalty layer: the difference counts in full then
    """
    if not (peak.half_width > 0 and peak.distance_to_edge > 0):
        return math.nan  # nothing touches: the first increment failed

    # Where the difference is made: ratio of the element sizes there, and order m of the error.
    gap_exponent = exponent_at_tip(profile, coarse_size)  # n
    share_within_tip = 0.0
    # SMOOTH_TIP: exponent from which on a tip counts as smooth, 1.99
    if gap_exponent >= SMOOTH_TIP:
        place_of_error = Place(
            coarse_size / fine_sizes.edge_size, 1.0 if math.isfinite(depth) else 2.0
        )
    elif exponent_at_tip(profile, fine_sizes.tip_size) < SMOOTH_TIP:
        place_of_error = Place(coarse_size / fine_sizes.tip_size, gap_exponent - 1)
    else:
        place_of_error = Place(coarse_size / fine_sizes.tip_size, 2.0)
        # _PEAK_WITHIN_TIP: fitted share of p0
        share_within_tip = _PEAK_WITHIN_TIP
    # _LEAST_REFINEMENT: least ratio of the element sizes of both meshes
    if 1 / _LEAST_REFINEMENT < place_of_error.refinement < _LEAST_REFINEMENT:
        return math.nan

    # Error of the run over the difference, 1/|r^m - 1|; further terms by edges and growth, over p0.
    error_over_difference = max(place_of_error.share_left(), 1.0 if has_low_order else 0.0)
    relative_size = fine_sizes.edge_size / peak.half_width
    # _PEAK_BY_EDGES: fitted share
    share_by_edges = _PEAK_BY_EDGES * relative_size**1.5 * peak.half_width / peak.distance_to_edge
    share_by_growth = _PEAK_GROWN * growth**4
    # _SAFETY: 1.25; the others are fitted shares
    return (
        _SAFETY * peak.change_from_coarse * error_over_difference
        + _PEAK_BY_NEIGHBOURS * peak.deviation_from_neighbours
        + max(_PEAK_BY_ALTERNATION * peak.alternation, _PEAK_BY_SCATTER * peak.scatter)
        + (share_by_edges + share_by_growth + share_within_tip) * peak.value
    )


def uncertainty_note(
    dissipation: float, uncertainty: float, tolerances: Tolerances, coarse_dissipation: float
) -> Iterator[str]:
    """A sentence where the friction work W is uncertain by more than its tolerance, or by an
    unknown amount. Where the scene has no tolerance, that of the project's own checks counts.

    Parameters
    ----------
    dissipation, uncertainty
        W of the last cycle, and its uncertainty, NaN where unknown [energy / thickness]
    tolerances
        of the scene: relative limits by the name of the value
    coarse_dissipation
        W of the coarse run; NaN without one
    """
    tolerance = tolerances.limit("dissipation") or 0.0
    source = "that of the project's own checks" if tolerances.dissipation is None else "the scene's"
    if np.isnan(dissipation):
        return
    if np.isnan(uncertainty):
        reason = "the coarse run has elements like these"
        if np.isnan(coarse_dissipation):
            reason = "its bodies are shared, without a coarse run of this scene"
        yield f"the dissipation has no uncertainty estimate: {reason}"
    elif uncertainty > tolerance * dissipation and uncertainty > 0:
        share_text = ""
        if dissipation:
            percent = 100 * uncertainty / dissipation
            share_text = f" ({percent:.3g} %; the tolerance, {source}, is {100 * tolerance:.3g} %)"
        yield (
            f"the dissipation is uncertain by {uncertainty:.3g}{share_text}: make edge_element_size"
            " or step_tolerance smaller"
        )
