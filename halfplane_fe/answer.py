"""From scaled interface states to the arrays and the record of a ContactSolution, in the scene's
units.

Normal approach and tangential displacement of half-planes are counted from the datum of the scene;
no traction depends on it. What the layer of the penalty method costs is read off those arrays:
overlap of the faces, elastic slip, creep of nodes that stick.

# notation: L distance from a force at which the surface counts as unmoved; P, Q loads; 1/E* = sum
of (1 - nu^2)/E
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from halfplane_fe.between_nodes import NO_ZONE, EdgesByLoad, StickZone
from halfplane_fe.contact import ContactProblem, InterfaceState, nodal_values
from halfplane_fe.edges import (
    ContactsOfLoads,
    Edges,
    NodalAnswer,
    contact_with_uncertainty,
    held_back_by_growth,
    left_of_growth,
    stick_edges,
    stick_with_uncertainty,
    uncertainty_by_growth,
)
from halfplane_fe.interface import least_depth
from halfplane_fe.law import slip_sign
from halfplane_fe.reported_states import reported_states
from halfplane_fe.run import PathRun
from halfplane_fe.scales import Scales
from halfplane_fe.stick_by_slip import ends_by_slip
from halfplane_fe.task import Task
from scenes import OPEN, STICK, Interrupted, Record, Scene, read_only_copy
from scenes.array_types import Array, Mask, States

# Instants whose edges are found together: a few, so that the arrays of a long run stay small.
_INSTANTS_PER_BLOCK = 256
# Range of slip of a node in the last cycle, over the largest, up to which it belongs to the
# permanent stick zone that a path with bulk stress or tilt approaches. Slip grows as the distance d
# from the stick edge to the power 3/2, so this costs d = 3e-4^(2/3), half a hundredth of the slip
# zone.
_LARGEST_CREEP = 3e-4
# The same of coupled bodies, 1e-3^(3/2): it costs a thousandth of the slip zone, and is above the
# 2e-5 that nodes which single increments label as slip were seen to move (flat pad of the library).
_LARGEST_CREEP_OF_COUPLED = 3e-5
# Distances of nodes beyond the intersection of all stick zones, of like bodies, as far as which the
# edges of single instants give the end of the permanent stick zone better than creep.
_NODES_OF_CREEP = 2.0
# Half-widths of contact from which on a body is thick.
_THICK = 3.0


def answer_arrays(task: Task, problem: ContactProblem, run: PathRun) -> dict[str, Any]:
    """Arrays and numbers of a finite-element solution by name, in the scene's units: loads,
    displacements, tractions, slip, node states and edges at the stored instants of a run; friction
    work of each load cycle, and at the nodes in the last one.

    Also the zone that sticks through the whole last cycle ("permanent_stick…"), and the closed
    integral of Q dU round that cycle, with the work of shear in the slip by bulk stress
    ("loop_work"). "steady_from" is the index of the first cycle that ended as it started (from 0;
    None without one).

    Parameters
    ----------
    task
        the scene, its mesh, and the scales of its variables: contact half-width, largest load P
        and modulus E*
    problem
        the contact problem, in scaled variables; used are the places of its n nodes and the length
        of face that each stands for
    run
        the contact states along the load path, and which of them are stored; friction work of the
        nodes in each load cycle; index of the state at the start of each cycle
    """
    scene = task.scene
    scales = task.scales
    contact_states = [run.states[index] for index in run.stored_indices]  # n_stored of them
    series = _series_of_loads_and_motion(contact_states, scales)
    work_unit = scales.load * (scales.load / scales.modulus)
    x = problem.interface.x * scales.half_width

    # Edges of contact and stick, and ends of the permanent stick zone. `surface_states` (n_states,
    # n): open, stick or slip of the nodes at all instants, stored or not. `end_correction` (2,):
    # what was added to the ends, as growing elements make the zones too small.
    surface_states = reported_states(problem, run.states, run.cycle_starts)
    edges, permanent_stick, end_correction = _edges_corrected_for_growth(
        task, _edges_of_run(scene, problem, run, surface_states), x, series["normal_load"]
    )
    arrays = {
        **series,
        "x": read_only_copy(x),
        **_nodal_arrays(problem, contact_states, scales),
        "state": read_only_copy(surface_states[run.stored_indices], np.int8),
        **{name: read_only_copy(values) for name, values in edges.items()},
        "contact_half_width": read_only_copy(np.diff(edges["contact_edges"])[:, 0] / 2),
        "stick_half_width": read_only_copy(np.diff(edges["stick_edges"])[:, 0] / 2),
        **_arrays_of_friction_work(
            run, problem.interface.face_lengths * scales.half_width, work_unit
        ),
        "permanent_stick_half_width": float(np.diff(permanent_stick.places)[0]) / 2,
        "permanent_stick_edges": read_only_copy(permanent_stick.places),
        "permanent_stick_uncertainty": read_only_copy(permanent_stick.uncertainty),
        "permanent_stick_correction": read_only_copy(end_correction),
        "steady_from": run.steady_from,
        "loop_work": _loop_work(scene, run) * work_unit,
    }
    # without bulk stress, tilt and unsymmetric profile
    if not scene.unsymmetric:
        return arrays
    return arrays | _arrays_of_stress_and_tilt(problem, contact_states, scales)


def _series_of_loads_and_motion(
    contact_states: Sequence[InterfaceState], scales: Scales
) -> dict[str, Array]:
    """Read-only series at k instants by name, (k,) each, in the scene's units: time, loads P and Q,
    and relative displacements of the bodies, tangential (U) and normal (approach).

    `contact_states` hold them scaled: by the largest load P and by P/E*, of which `scales` has P
    and E*.
    """
    displacement_unit = scales.load / scales.modulus
    loads = np.array([(state.normal_load, state.tangential_load) for state in contact_states])
    # `shift`: relative tangential displacement U of the bodies
    motion = np.array([(state.shift, state.approach) for state in contact_states])
    return {
        "time": read_only_copy([state.time for state in contact_states]),
        "normal_load": read_only_copy(loads[:, 0] * scales.load),
        "tangential_load": read_only_copy(loads[:, 1] * scales.load),
        "tangential_displacement": read_only_copy(motion[:, 0] * displacement_unit),
        "normal_approach": read_only_copy(motion[:, 1] * displacement_unit),
    }


def _arrays_of_friction_work(
    run: PathRun, face_lengths: Array, work_unit: float
) -> dict[str, Array | float]:
    """Friction work of a run by name, in the scene's units: of the last load cycle ("dissipation",
    NaN where no cycle was completed), of each cycle, and per area at the nodes in the last one
    ("dissipation_density").

    Parameters
    ----------
    run
        `nodal_work_by_cycle` holds the friction work of the n nodes in each cycle, scaled
    face_lengths
        (n,) length of face of each node [length]
    work_unit
        unit of scaled work [energy / thickness]
    """
    # (n_cycles, n) friction work of each node in each load cycle
    nodal_work_of_cycles = (
        np.array(run.nodal_work_by_cycle).reshape(-1, len(face_lengths)) * work_unit
    )
    has_cycle = len(nodal_work_of_cycles) > 0
    work_per_area = (
        nodal_work_of_cycles[-1] / face_lengths if has_cycle else np.zeros_like(face_lengths)
    )
    return {
        "dissipation_density": read_only_copy(work_per_area),
        "dissipation": float(nodal_work_of_cycles[-1].sum()) if has_cycle else float("nan"),
        "cycle_dissipation": read_only_copy(nodal_work_of_cycles.sum(axis=1)),
    }


def _edges_corrected_for_growth(
    task: Task,
    edges_and_permanent_stick: tuple[dict[str, Array], Edges],
    x: Array,
    normal_load: Array,
) -> tuple[dict[str, Array], Edges, Array]:
    """Edges of contact and stick and ends of the permanent stick zone, in the scene's units, moved
    outwards by what the growth of the elements holds them back.

    Elements whose size grows with the distance from the contact (`mesh.growth`) make a body too
    stiff, so that its edges lie too far inside.

    Parameters
    ----------
    task
        its scene and mesh settings; `scales.half_width` is the unit of length; `spacing` is the
        distance of the nodes at the edges [length]
    edges_and_permanent_stick
        both over the half-width. First a dictionary with edges of contact and stick at k instants,
        and their uncertainty. Then the ends of the permanent stick zone
    x
        (n,) nodes in ascending order [length]
    normal_load
        (k,) at the stored instants [force per thickness]

    Returns
    -------
    edges
        name -> contact or stick edges, or their uncertainty, (k, 2) each [length]
    permanent_stick
        ends (2,) of the permanent stick zone, and their uncertainty where slip locates them
        [length]
    end_correction
        (2,) what was added to these ends [length]
    """
    # In the scene's units. `half_width_by_load`: half-width of contact by the normal load.
    scaled_edges, scaled_permanent_stick = edges_and_permanent_stick
    half_width = task.scales.half_width
    edges = {name: values * half_width for name, values in scaled_edges.items()}
    half_width_by_load = ContactsOfLoads(np.diff(edges["contact_edges"])[:, 0] / 2, normal_load)
    growth = task.mesh.growth

    # Edges of contact and stick are moved; what may be left of their error makes them uncertain.
    is_pressed = (normal_load > 0)[:, None]
    for edge_name in ("contact_edge", "stick_edge"):
        places = edges[f"{edge_name}s"]
        spacing = _spacing_at(x, places, task.spacing)
        distance_to_move = held_back_by_growth(places, half_width_by_load, growth, spacing)
        correction = np.where(is_pressed, distance_to_move, 0.0)
        edges[f"{edge_name}s"] = places + correction
        edges[f"{edge_name}_uncertainty"] = np.hypot(
            edges[f"{edge_name}_uncertainty"], uncertainty_by_growth(growth, spacing)
        ) + left_of_growth(correction, _is_thick(task))

    # Likewise the ends of the permanent stick zone.
    ends = scaled_permanent_stick.places * half_width
    spacing = _spacing_at(x, ends, task.spacing)
    end_correction = held_back_by_growth(ends, half_width_by_load, growth, spacing)
    permanent_stick = Edges(
        places=ends + end_correction,
        uncertainty=scaled_permanent_stick.uncertainty * half_width,
    )
    return edges, permanent_stick, end_correction


def _spacing_at(x: Array, places: Array, largest_spacing: float) -> Array:
    """Distance of the two nodes around each place, at most `largest_spacing` [length]: of the nodes
    at x (n,) ascending, at places of any shape.
    """
    next_node = np.clip(np.searchsorted(x, places), 1, len(x) - 1)
    return np.minimum(x[next_node] - x[next_node - 1], largest_spacing)


def _is_thick(task: Task) -> bool:
    """Whether elements that grow with the distance from the contact shift its edges as they do on
    half-planes: on these, and on bodies with flat faces that are three half-widths thick or more.
    """
    bodies = task.scene.bodies
    has_cylinder = "cylinder" in {bodies.lower.kind, bodies.upper.kind}
    return not has_cylinder and least_depth(task.scene) >= _THICK * task.scales.half_width


def _edges_of_run(
    scene: Scene, problem: ContactProblem, run: PathRun, surface_states: States
) -> tuple[dict[str, Array], Edges]:
    """Left and right edges of contact and stick at the stored instants of a run, and ends of its
    permanent stick zone; scaled.

    The permanent stick zone sticks all through the last cycle. Its ends are sharp between like
    bodies without bulk stress and tilt. There the loads at the turning points of slip locate them,
    and no stick edge of the last cycle lies inside them. Elsewhere nodes next to an end slip by
    next to nothing in a cycle (creep).

    Parameters
    ----------
    scene
        bodies, materials, friction and load path; `unsymmetric` with bulk stress, tilt, or a
        profile that is not its own mirror image
    problem
        the contact problem; its `interface.coupling` (slip by pressure) is None of like bodies
    run
        contact states after all increments, and which k of them are stored in the solution;
        `contact_edges` and `stick_edges`: edges that the loads locate between two nodes, in batches
    surface_states
        (n_steps, n) open, stick or slip of the nodes after all increments

    Returns
    -------
    edges
        name -> contact or stick edges at the stored instants, or their uncertainty, (k, 2) each
    permanent_stick
        ends (2,) of the permanent stick zone, NaN without one; their uncertainty where slip or
        creep of the nodes locates them, else NaN
    """
    stored = run.stored_indices
    contact_states = [run.states[index] for index in stored]
    # EdgesByLoad: x between two nodes by the loads at which these touch or slide
    edges = _edges_in_blocks(
        problem,
        contact_states,
        surface_states[stored],
        _has_no_slip_zone(scene, problem, run)[stored],
        EdgesByLoad.joined(run.contact_edges).at(stored),
        EdgesByLoad.joined(run.stick_edges).at(stored),
        scene,
    )

    # Ends of the permanent stick zone: by slip or creep of the nodes (with an uncertainty), else by
    # the stick zones of single instants.
    ends = _permanent_stick(scene, problem, run, surface_states, edges["stick_edges"])
    if not permanent_stick_ends_sharply(scene, problem):
        return edges, ends
    # the zone by its nodes and by the loads at the turning points of slip: the ends lie within it
    zone = permanent_stick_zone(run)
    time = np.array([state.time for state in contact_states])
    normal_load = np.array([state.normal_load for state in contact_states])
    is_in_cycle = is_loaded_in_last_cycle(scene, time, normal_load)
    confined_ends, is_by_slip = _confined_ends(
        ends, zone, edges["contact_edges"][is_in_cycle], half_planes=scene.bodies.half_planes
    )
    _move_stick_edges_outwards(edges, confined_ends, zone, time, is_in_cycle)
    return edges, Edges(confined_ends.places, np.where(is_by_slip, ends.uncertainty, np.nan))


def _has_no_slip_zone(scene: Scene, problem: ContactProblem, run: PathRun) -> Mask:
    """Instants at which all of the contact sticks, (n_steps,): between half-planes by the loads,
    between other bodies of like materials by the shear at both edges; else unknown, False.

    Parameters
    ----------
    scene
        bodies, materials and friction; `unsymmetric` with bulk stress, tilt, or a profile that is
        not its own mirror image
    problem
        the contact problem; its `interface.coupling` (slip by pressure) is None of like bodies
    run
        contact states after all increments; `sticks_in_full` holds what the shear at the edges
        shows
    """
    loads = np.array([(state.normal_load, state.tangential_load) for state in run.states])
    if scene.bodies.half_planes and problem.interface.coupling is None and not scene.unsymmetric:
        return _sticks_in_full_by_loads(loads, scene.friction.coefficient)
    if scene.material.alike:
        return np.concatenate(run.sticks_in_full)
    return np.zeros(len(loads), dtype=bool)


def _confined_ends(
    ends: Edges, zone: StickZone, contact_edges: Array, *, half_planes: bool
) -> tuple[Edges, Mask]:
    """Ends (2,) of a permanent stick zone that ends sharply, with their uncertainty, and which of
    them slip or creep locates, (2,).

    Each end is that by slip or creep where there is one, and else the end by single instants,
    confined by the loads at the turning points of slip. The zone is not beyond the contact at any
    instant of the last cycle.

    Parameters
    ----------
    ends
        places by slip or creep, with an uncertainty; of others by single instants, with NaN
    zone
        the zone by its nodes and by the loads: `places_by_load` (2,), NaN where no load locates an
        end
    contact_edges
        (k, 2) edges of contact in the last cycle
    half_planes
        whether both bodies are half-planes, of which the places by loads are more accurate; of thin
        layers those by slip are, up to 40 times
    """
    is_by_slip = np.isfinite(ends.uncertainty)
    # an end by the loads, else the given one if it lies between the two nodes around that end
    confined_places = zone.confine(ends.places)
    if half_planes:
        is_by_slip &= confined_places != zone.places_by_load
    uncertainty = np.where(
        is_by_slip, ends.uncertainty, zone.uncertainty(confined_places, np.full(2, np.inf))
    )
    places = _within_contacts(np.where(is_by_slip, ends.places, confined_places), contact_edges)
    return Edges(places, uncertainty), is_by_slip


def _nodal_arrays(
    problem: ContactProblem, contact_states: Sequence[InterfaceState], scales: Scales
) -> dict[str, Array]:
    """Pressure and shear [stress] and slip [length] of the nodes at some instants, each
    (n_instants, n), read-only; slip has the elastic slip of a penalty layer in it.

    Parameters
    ----------
    problem
        the contact problem: length of face of each node, and compliance of the layer; scaled
    contact_states
        nodal forces and slip at the instants; scaled
    scales
        units of the scaled values: contact half-width, largest load P and modulus E*
    """
    face_lengths = problem.interface.face_lengths * scales.half_width
    slip = np.stack([state.slip for state in contact_states])
    pressure = np.stack([state.pressure for state in contact_states])
    shear = np.stack([state.shear for state in contact_states])
    if problem.layer.tangential_compliance.any():
        slip += problem.layer.tangential_compliance * shear
    # In place: of a fine mesh with thousands of steps each copy is half a gigabyte and more.
    np.multiply(pressure, scales.load / face_lengths, out=pressure)
    np.multiply(shear, scales.load / face_lengths, out=shear)
    np.multiply(slip, scales.load / scales.modulus, out=slip)
    for values in (pressure, shear, slip):
        values.flags.writeable = False
    return {"pressure": pressure, "shear": shear, "slip": slip}


def _loop_work(scene: Scene, run: PathRun) -> float:
    """Closed integral of Q dU over the last load cycle, scaled; NaN where the path does not repeat
    or no cycle is steady. The work of shear in the slip that bulk stress causes is added.

    `run` holds that work of each increment ("loop_work"), and the index of the state at the start
    of each cycle.
    """
    if scene.load.path().period is None or run.steady_from is None:
        return float("nan")
    return float(run.values_of_increments("loop_work")[run.cycle_starts[-1] :].sum())


def _arrays_of_stress_and_tilt(
    problem: ContactProblem, contact_states: Sequence[InterfaceState], scales: Scales
) -> dict[str, Array]:
    """Read-only series that only scenes with bulk stress or tilt have, (n_instants,) each: bulk
    stresses of both bodies, tilt, and the moments of pressure and of shear about x = 0.

    `problem` has places and contact compliance of the n nodes. `contact_states` hold the nodal
    forces p and q in units of the largest load P (`scales.load`); `scales` also has half-width and
    E*.
    """
    stress_unit = scales.load / scales.half_width
    moment_unit = scales.load * scales.half_width
    p_of_nodes = np.stack([state.pressure for state in contact_states])
    q_of_nodes = np.stack([state.shear for state in contact_states])
    moment = problem.interface.moment(p_of_nodes, q_of_nodes)
    shear_moment = q_of_nodes @ problem.interface.x
    stress_of_lower_body, stress_of_upper_body, tilt = np.array(
        [state.stresses_and_tilt for state in contact_states]
    ).T
    return {
        "bulk_stress_lower": read_only_copy(stress_of_lower_body * stress_unit),
        "bulk_stress_upper": read_only_copy(stress_of_upper_body * stress_unit),
        "tilt": read_only_copy(tilt * stress_unit / scales.modulus),
        "moment": read_only_copy(moment * moment_unit),
        "shear_moment": read_only_copy(shear_moment * moment_unit),
    }


def permanent_stick_ends_sharply(scene: Scene, problem: ContactProblem) -> bool:
    """Whether any slip at all counts as slip, so that the permanent stick zone ends sharply.

    Not so between coupled bodies (unlike materials), and not under bulk stress or tilt: there nodes
    that slip by next to nothing in a cycle (creep) count as stuck.
    """
    return not scene.unsymmetric and problem.interface.coupling is None


def _sticks_in_full_by_loads(loads: Array, friction: float) -> Mask:
    """Instants at which half-planes of like materials stick in full by the loads, whatever the
    history, (n,): since the instant before, P has grown, and |dQ| <= f dP.

    `loads` is (n, 2) of P and Q, `friction` is f.
    Source: Barber, Davies, Hills (2011).
    """
    rise_of_p, rise_of_q = np.diff(loads, axis=0, prepend=loads[:1]).T
    return np.asarray((rise_of_p > 0) & (np.abs(rise_of_q) <= friction * rise_of_p))


def _edges_in_blocks(
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    surface_states: States,
    has_no_slip_zone: Mask,
    contact_by_load: EdgesByLoad,
    stick_by_load: EdgesByLoad,
    scene: Scene,
) -> dict[str, Array]:
    """Left and right edge of the contact and of the stick zone at k instants, and the uncertainty
    of each: four arrays by name, (k, 2), scaled.

    They are found for a few hundred instants at a time, which bounds the memory.

    Parameters
    ----------
    problem
        the contact problem: places of the nodes, friction
    contact_states
        (k,) nodal forces, slip and gap of the contact at each instant
    surface_states
        (k, n) open, stick or slip of the nodes
    has_no_slip_zone
        (k,) instants at which the whole contact sticks by the loads, or by the shear at its edges
    contact_by_load, stick_by_load
        edges of these instants that the loads locate between two nodes; `at` picks instants
    scene
        `unsymmetric` with bulk stress, tilt, or a profile that is not its own mirror image
    """
    edges_of_blocks = []  # of 256 instants each: edges by name
    for first_step in range(0, len(contact_states), _INSTANTS_PER_BLOCK):
        block = slice(first_step, first_step + _INSTANTS_PER_BLOCK)
        edges_of_blocks.append(
            _edges_at_instants(
                problem,
                contact_states[block],
                surface_states[block],
                has_no_slip_zone[block],
                contact_by_load.at(block),
                stick_by_load.at(block),
                scene,
            )
        )
    edges: dict[str, Array] = {}
    for name in edges_of_blocks[0]:
        edges[name] = np.concatenate([block_edges[name] for block_edges in edges_of_blocks])
    return edges


def _edges_at_instants(
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    surface_states: States,
    has_no_slip_zone: Mask,
    contact_by_load: EdgesByLoad,
    stick_by_load: EdgesByLoad,
    scene: Scene,
) -> dict[str, Array]:
    """Left and right edge of the contact and of the stick zone, between the nodes of the mesh, and
    the uncertainty of each: four arrays by name, (n_steps, 2), scaled.

    The loads at which nodes touch or slide locate them, where they can. Elsewhere the tractions
    near them do. Without normal load they are the outermost nodes that touch, or 0 where none does,
    with the uncertainty 0.

    Parameters
    ----------
    problem
        the contact problem: places of the nodes, length of face of each, friction
    contact_states
        nodal forces, slip and gap of the contact at the instants
    surface_states
        (n_steps, n) open, stick or slip of the nodes, where a node that has hardly moved counts as
        stick
    has_no_slip_zone
        (n_steps,) instants at which the whole contact sticks by the loads, or by the shear at its
        edges
    contact_by_load, stick_by_load
        edges of these instants that the loads locate between two nodes
    scene
        `unsymmetric` with bulk stress, tilt, or a profile that is not its own mirror image
    """
    # the stick zone need not be around x = 0 in unsymmetric scenes
    fields_of_nodes = _fields_of_nodes(problem, contact_states, surface_states, scene.unsymmetric)

    # Places of both edges, and the uncertainty of each, (n_steps, 2).
    contact = contact_with_uncertainty(fields_of_nodes, contact_by_load)
    stick = stick_with_uncertainty(
        fields_of_nodes, problem.friction, contact, has_no_slip_zone, stick_by_load
    )

    # Instants without normal load.
    for instant in np.flatnonzero([not state.normal_load > 0 for state in contact_states]):
        closed_nodes = fields_of_nodes.x[fields_of_nodes.is_closed[instant]]
        outermost_nodes = (
            (closed_nodes.min(), closed_nodes.max()) if len(closed_nodes) else (0.0, 0.0)
        )
        for edges in (contact, stick):
            edges.places[instant] = outermost_nodes
            edges.uncertainty[instant] = 0.0
    return {
        "contact_edges": contact.places,
        "stick_edges": stick.places,
        "contact_edge_uncertainty": contact.uncertainty,
        "stick_edge_uncertainty": stick.uncertainty,
    }


def _fields_of_nodes(
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    surface_states: States,
    stick_may_be_anywhere: bool,
) -> NodalAnswer:
    """Tractions, gap and states of the n nodes at some instants, from which edges of contact and
    stick are found; (n_steps, n) each, scaled.

    Parameters
    ----------
    problem
        the contact problem: places of the nodes, length of face of each
    contact_states
        nodal forces and gap of the contact at the instants, and the states of the nodes as the law
        of friction left them
    surface_states
        (n_steps, n) open, stick or slip of the nodes, where a node that has hardly moved counts as
        stick
    stick_may_be_anywhere
        whether the stick zone may be beside x = 0
    """
    face_lengths = problem.interface.face_lengths
    _, normal_force, tangential_force, gap = nodal_values(
        np.stack([state.values for state in contact_states])
    )
    states_by_law = np.stack([state.node_states for state in contact_states])
    return NodalAnswer(
        x=problem.interface.x,
        pressure=normal_force / face_lengths,
        shear=tangential_force / face_lengths,
        # Open nodes carry nothing: the layer does not count in their gap.
        gap=gap,
        is_closed=states_by_law != OPEN,
        is_stuck=surface_states == STICK,
        is_stuck_by_law=states_by_law == STICK,
        stick_may_be_anywhere=stick_may_be_anywhere,
    )


def is_loaded_in_last_cycle(scene: Scene, time: Array, normal_load: Array) -> Mask:
    """Which of n ascending instants are in the last cycle of the load path and under load, (n,).
    The start of the cycle does not count; where the path does not repeat, no instant does.

    `time` and `normal_load` are (n,), of the instants; `scene` has the path with its period.
    """
    period = scene.load.path().period or 0.0
    is_late = time > time[-1] - period * (1 - 1e-9)
    return np.asarray(is_late & (normal_load > 0))


def _permanent_stick(
    scene: Scene,
    problem: ContactProblem,
    run: PathRun,
    surface_states: States,
    stored_stick_edges: Array,
) -> Edges:
    """Ends (2,) of the permanent stick zone, which sticks through the whole last cycle, scaled; NaN
    if there is none.

    An end is located by the slip of the nodes beyond it. Where slip does not locate it, it is the
    end of the intersection of the stick zones at all instants of the cycle. Ends that slip or creep
    locates have an uncertainty, others NaN.

    A path that does not repeat starts unloaded, where nothing touches, so that it has no such zone.
    Nodes that creep, that is, slip by next to nothing in the cycle, belong to the zone too:

    - With bulk stress or tilt, where the steady state is only approached, and slip near the zone
      grows less from cycle to cycle.
    - Between coupled bodies (unlike materials), where single increments label nodes as slipping
      that move next to nothing.
    - Between others where creep reaches more than two node distances beyond that intersection.

    Parameters
    ----------
    scene
        load path, friction and bodies
    problem
        the contact problem of the nodes, with their places x
    run
        contact states after all increments, and which k of them are stored in the solution
    surface_states
        (n_steps, n) open, stick or slip of the nodes after all increments
    stored_stick_edges
        (k, 2) stick edges of the stored instants, scaled
    """
    places_without_zone = np.full(2, np.nan)
    ends_without_zone = Edges(places_without_zone, places_without_zone)
    time = np.array([state.time for state in run.states])
    normal_load = np.array([state.normal_load for state in run.states])
    is_in_cycle = is_loaded_in_last_cycle(scene, time, normal_load)
    if not is_in_cycle.any():  # no cycle, or the very first increment failed
        return ends_without_zone

    x = problem.interface.x
    common_zone = _common_stick_zone(scene, x, run, surface_states, stored_stick_edges, is_in_cycle)
    permanent_zone = common_zone if common_zone[0] < common_zone[1] else places_without_zone

    # Ends (2,) of the zone of nodes that at most creep, and ends by the slip of nodes beyond it.
    creeping_edges, slip_ends = _creeping_and_slip_ends(scene, x, run, surface_states, is_in_cycle)

    # Nodes that only creep belong to the zone.
    if not permanent_stick_ends_sharply(scene, problem):
        left_end = np.fmin(permanent_zone[0], creeping_edges[0])
        right_end = np.fmax(permanent_zone[1], creeping_edges[1])
        permanent_zone = np.array([left_end, right_end])
    elif np.isfinite(permanent_zone).all():
        slip_ends = _with_creeping_ends(x, slip_ends, creeping_edges, permanent_zone)
    places = np.where(np.isfinite(slip_ends.places), slip_ends.places, permanent_zone)
    return Edges(places, slip_ends.uncertainty)


def _creeping_and_slip_ends(
    scene: Scene, x: Array, run: PathRun, surface_states: States, is_in_cycle: Mask
) -> tuple[Array, Edges]:
    """Ends of two zones by the slip of their nodes in the last cycle, scaled: of the nodes that
    stay closed and slip by next to nothing (creep), (2,), NaN without one; and of the permanent
    stick zone, located by how far the nodes beyond it slip.

    Parameters
    ----------
    scene
        `unsymmetric` with bulk stress, tilt, or a profile that is not its own mirror image: the
        zone may then be beside x = 0
    x
        (n,) places of the nodes
    run
        contact states after all increments, with the slip of the nodes
    surface_states
        (n_steps, n) open, stick or slip of the nodes after all increments
    is_in_cycle
        (n_steps,) instants of the last cycle
    """
    is_closed = surface_states[is_in_cycle] != OPEN
    slip = np.array([run.states[k].slip for k in np.flatnonzero(is_in_cycle)])
    creeping_edges = creeping_zone(scene, x, slip, is_closed)
    # range of the slip (n,), of nodes that stay closed
    slip_range = np.where(is_closed.all(axis=0), np.ptp(slip, axis=0), np.nan)
    return creeping_edges, ends_by_slip(x, slip_range, creeping_edges)


def _common_stick_zone(
    scene: Scene,
    x: Array,
    run: PathRun,
    surface_states: States,
    stored_stick_edges: Array,
    is_in_cycle: Mask,
) -> Array:
    """Left and right end (2,) of the intersection of all stick zones of the last cycle, scaled; the
    left one is further right where nothing is common. NaN where nothing sticks at some instant.

    Instants that the solution leaves out have no fitted edges: theirs are half-way between nodes.

    Parameters
    ----------
    scene
        `unsymmetric` with bulk stress, tilt, or a profile that is not its own mirror image: the
        stick zone may then be beside x = 0
    x
        (n,) places of the nodes
    run
        `stored_indices` (k,) are the instants that are stored in the solution
    surface_states
        (n_steps, n) open, stick or slip of the nodes after all increments
    stored_stick_edges
        (k, 2) stick edges of the stored instants
    is_in_cycle
        (n_steps,) instants of the last cycle
    """
    dropped_steps = np.setdiff1d(np.flatnonzero(is_in_cycle), run.stored_indices)
    states_of_dropped = surface_states[dropped_steps]
    zones_of_dropped = _zones_by_nodes(
        x,
        states_of_dropped == STICK,
        states_of_dropped != OPEN,
        stick_may_be_anywhere=scene.unsymmetric,
    )
    left_edges, right_edges = np.concatenate(
        [stored_stick_edges[is_in_cycle[run.stored_indices]], zones_of_dropped]
    ).T
    return np.array([left_edges.max(), right_edges.min()])


def _with_creeping_ends(
    x: Array, slip_ends: Edges, creeping_edges: Array, common_zone: Array
) -> Edges:
    """Ends (2,) of the permanent stick zone by slip, completed by creep.

    Where slip does not locate an end, and nodes that slip by next to nothing (creep) reach far
    beyond the intersection of all stick zones, it is half-way between the last of them and the next
    node. The intersection is too narrow there: an increment labels nodes that creep as slipping.

    Parameters
    ----------
    x
        (n,) nodes in ascending order
    slip_ends
        ends that slip locates, NaN of others
    creeping_edges, common_zone
        (2,) ends of the zone whose nodes at most creep, and of the intersection of all stick zones

    Returns
    -------
    Edges
        Places of the ends, and their uncertainty: of those by creep the distance of the nodes.
    """
    node_after = np.clip(np.searchsorted(x, creeping_edges), 1, len(x) - 1)
    spacing = x[node_after] - x[node_after - 1]
    creep_beyond_zone = (creeping_edges - common_zone) * [-1.0, 1.0]
    # _NODES_OF_CREEP: far is more than two node distances
    is_by_creep = np.isnan(slip_ends.uncertainty) & (creep_beyond_zone > _NODES_OF_CREEP * spacing)
    return Edges(
        np.where(is_by_creep, creeping_edges, slip_ends.places),
        np.where(is_by_creep, spacing, slip_ends.uncertainty),
    )


def _within_contacts(ends: Array, contact_edges: Array) -> Array:
    """Ends (2,) of the permanent stick zone, not beyond the contact at any instant: moved to the
    innermost of its edges (k, 2) where they are.
    """
    if not len(contact_edges):
        return ends
    return np.clip(ends, contact_edges[:, 0].max(), contact_edges[:, 1].min())


def permanent_stick_zone(run: PathRun) -> StickZone:
    """Ends of the permanent stick zone in the last load cycle, by its nodes and by the loads at the
    turning points of slip, scaled; `NO_ZONE` (all NaN) where the run failed or no cycle was
    completed. Each cycle of the run stores it, with the friction work that its mesh adds.
    """
    has_last_cycle = run.failure is None and bool(run.edge_excess_by_cycle)
    return run.edge_excess_by_cycle[-1].stick_zone if has_last_cycle else NO_ZONE


def _move_stick_edges_outwards(
    edges: dict[str, Array], permanent_edges: Edges, zone: StickZone, time: Array, is_in_cycle: Mask
) -> None:
    """Move the stick edges (k, 2) of the last cycle, in place, so that none lies inside the
    permanent stick zone.

    At the turning points of slip the stick zone is smallest: its edges become the ends of the
    permanent zone, where slip or the loads locate these. At other instants the edges are moved
    outwards to these ends if they lie inside. Right after a turning point all of the contact
    sticks, though nodes may still be at the Coulomb limit. Such an instant has its stick edges at
    the contact edges, and does not count as a turning point.

    Parameters
    ----------
    edges
        name -> edges of contact and stick, and their uncertainty, (k, 2) each; scaled
    permanent_edges
        ends (2,) of the permanent stick zone (`places`), and their `uncertainty`
    zone
        the permanent stick zone by its nodes and by the loads: `places_by_load` (2,), NaN where no
        load locates an end; `turn_times`, instants at which slip turns at the left and right end
    time, is_in_cycle
        (k,) instants, and whether they are in the last cycle
    """
    stick_edges = edges["stick_edges"]
    uncertainty_of_stick_edges = edges["stick_edge_uncertainty"]
    is_located = np.isfinite(zone.places_by_load) & np.isfinite(permanent_edges.uncertainty)
    # Column 0: left edges, of which the outermost is the smallest x; column 1: right ones.
    for column, outermost_place in enumerate((np.fmin, np.fmax)):
        if is_located[column]:
            has_slip_zone = stick_edges[:, column] != edges["contact_edges"][:, column]
            is_turn = is_in_cycle & has_slip_zone & np.isin(time, zone.turn_times[column])
            stick_edges[is_turn, column] = permanent_edges.places[column]
            uncertainty_of_stick_edges[is_turn, column] = permanent_edges.uncertainty[column]
        has_stick_zone = is_in_cycle & np.isfinite(stick_edges[:, column])
        stick_edges[has_stick_zone, column] = outermost_place(
            stick_edges[has_stick_zone, column], permanent_edges.places[column]
        )


def creeping_zone(
    scene: Scene, x: Array, slip: Array, is_closed: Mask, range_factor: float = 1.0
) -> Array:
    """Ends (2,) of the zone whose nodes stay closed all through a cycle and slip by next to nothing
    (creep), scaled; NaN if no node does.

    A node creeps if the range of its slip over the cycle is at most a small part of the largest
    range of any node: 3e-4 under bulk stress or tilt, else 3e-5, times `range_factor`.

    Parameters
    ----------
    scene
        `unsymmetric` with bulk stress, tilt, or a profile that is not its own mirror image: the
        zone may then be beside x = 0
    x
        (n,) places of the nodes
    slip, is_closed
        (m, n) slip of the nodes, and whether they touch, at the m instants of the cycle
    range_factor
        of that small part: larger than 1 counts more nodes as creeping
    """
    # _LARGEST_CREEP: largest range of slip that counts as creep, over the largest of all nodes
    largest_creep = _LARGEST_CREEP if scene.unsymmetric else _LARGEST_CREEP_OF_COUPLED
    is_creeping = _is_creeping(slip, is_closed, range_factor * largest_creep)
    if not is_creeping.any():
        return np.full(2, np.nan)
    is_ever_closed = np.any(is_closed, axis=0)
    # (1, 2): one "instant", at which nodes that creep count as sticking
    zones = _zones_by_nodes(x, is_creeping[None], is_ever_closed[None], scene.unsymmetric)
    return np.asarray(zones[0])


def _zones_by_nodes(
    x: Array, is_stuck: Mask, is_closed: Mask, stick_may_be_anywhere: bool
) -> Array:
    """Left and right edge (m, 2) of the stick zone at m instants, half-way between the nodes that
    stick and those that do not; on a side of the middle where all stick the outermost closed node.
    Both are NaN where on one side at least nodes touch and none sticks.

    Parameters
    ----------
    x
        (n,) places of the nodes
    is_stuck, is_closed
        (m, n) whether each node sticks, and touches
    stick_may_be_anywhere
        whether the stick zone may be beside x = 0
    """
    first_node = np.argmax(is_closed, axis=1)
    last_node = len(x) - 1 - np.argmax(is_closed[:, ::-1], axis=1)
    outermost_places = np.stack([x[first_node], x[last_node]], axis=1)
    return stick_edges(
        x, is_stuck, is_closed, outermost_places, stick_may_be_anywhere=stick_may_be_anywhere
    )


def _is_creeping(slip: Array, is_closed: Mask, share: float) -> Mask:
    """Which of n nodes are closed at all m instants and have a range of slip of at most a `share`
    of the largest range of any node, (n,). `slip` and `is_closed` are (m, n).
    """
    slip_range = np.ptp(slip, axis=0)
    return np.all(is_closed, axis=0) & (slip_range <= share * slip_range.max())


@dataclass(frozen=True)
class PenaltyAudit:
    """Error of the elastic layer that the penalty method puts between the faces: overlap, elastic
    slip and creep. Without a layer (the law met exactly) the stiffnesses are infinite and the rest
    is zero or rounding.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness
        pressure per overlap, shear per elastic slip [stress/length]
    penetration
        largest overlap of the two faces on the path [length]
    penetration_share
        this overlap over the rise h(a) - h(0) of the profile at the largest contact (a^2/2R for
        Hertz)
    elastic_slip
        largest elastic slip of the layer [length]
    elastic_slip_share
        elastic slip over the largest slip of the last cycle; NaN where nothing slips
    creep
        largest range, over the last cycle, of the relative displacement of a node that sticks
        all through it [length]
    creep_share
        creep over the largest slip of the last cycle; NaN where nothing slips
    """

    normal_stiffness: float
    tangential_stiffness: float
    penetration: float
    penetration_share: float
    elastic_slip: float
    elastic_slip_share: float
    creep: float
    creep_share: float

    def note(self) -> str | None:
        """A sentence on the error of a penalty layer, the springs that stand for the contact
        conditions: overlap of the faces (`penetration`), elastic slip, creep; None where there is
        no layer, so that both stiffnesses are infinite.
        """
        if np.isinf(self.normal_stiffness) and np.isinf(self.tangential_stiffness):
            return None
        stiffness_text = (
            f"{self.normal_stiffness:.3g} normal and {self.tangential_stiffness:.3g} tangential"
            " [stress/length]"
        )
        overlap_text = (
            f"{self.penetration:.2g} [length], {self.penetration_share:.1e} of the profile's rise"
            " over the contact"
        )
        slip_text = f"{self.elastic_slip:.2g}, {self.elastic_slip_share:.1e} of the largest slip"
        return (
            f"penalty layer, stiffness {stiffness_text}: the faces overlap by up to"
            f" {overlap_text}; elastic slip up to {slip_text}; nodes that stick through the whole"
            f" cycle creep by up to {self.creep:.2g}, {self.creep_share:.1e} of it"
        )


class _LayerDeflection(NamedTuple):
    """Stiffness of a layer [stress/length], infinite without one, and its largest deflection
    [length].
    """

    stiffness: float
    deflection: float

    @classmethod
    def by_tractions(cls, compliance: Array, tractions: Array) -> _LayerDeflection:
        """Stiffness and largest deflection of a layer, by its compliance (n,) at the n nodes, one
        and the same everywhere [length/stress], and its tractions (n_steps, n) [stress]. Infinite
        and 0 where the compliance is 0: no layer.
        """
        largest_compliance = float(compliance.max())
        if not largest_compliance:
            return cls(np.inf, 0.0)
        deflection = float(np.max(compliance * np.abs(tractions), initial=0.0))
        return cls(1 / largest_compliance, deflection)


def penalty_audit(
    scene: Scene,
    problem: ContactProblem,
    contact_states: Sequence[InterfaceState],
    arrays: Mapping[str, Any],
    scales: Scales,
) -> PenaltyAudit:
    """Error of a penalty method, whose springs break the contact conditions: overlap of the faces,
    elastic slip, and creep, the relative displacement of nodes that stick through the last cycle.

    Overlap is compared with the rise of the profile over the largest contact, elastic slip and
    creep with the largest slip of the last cycle: NaN where nothing slips. Where the path does not
    repeat, all of it is the cycle.

    Parameters
    ----------
    scene
        profile of the faces, and load path with its period
    problem
        the contact problem, with the compliance of its layer of springs at each node, and the
        length of face that each stands for; scaled
    contact_states
        contact states at the stored instants, with open, stick or slip of the nodes
    arrays
        fields and series of the solution by name, in the scene's units
    scales
        half-width and modulus that lengths and compliances are scaled by
    """
    # Overlap and elastic slip: deflections of the springs under pressure and shear, with their
    # stiffnesses. The factor turns the scaled compliance of a node into length per stress.
    compliance_factor = problem.interface.face_lengths * scales.half_width / scales.modulus
    normal_deflection = _LayerDeflection.by_tractions(
        problem.layer.normal_compliance * compliance_factor, arrays["pressure"]
    )
    tangential_deflection = _LayerDeflection.by_tractions(
        problem.layer.tangential_compliance * compliance_factor, arrays["shear"]
    )
    largest_half_width = float(np.nanmax(arrays["contact_half_width"]))
    # rise of the profile from x = 0 to the largest half-width of contact
    profile_rise = float(np.ptp(scene.profile.height(np.array([0.0, largest_half_width]))))

    largest_creep, largest_slip = _largest_creep_and_slip(scene, contact_states, arrays)

    def ratio_or_nan(part: float, reference: float) -> float:
        """Part over the reference; NaN where that is 0."""
        return part / reference if reference else float("nan")

    return PenaltyAudit(
        normal_stiffness=normal_deflection.stiffness,
        tangential_stiffness=tangential_deflection.stiffness,
        penetration=normal_deflection.deflection,
        penetration_share=ratio_or_nan(normal_deflection.deflection, profile_rise),
        elastic_slip=tangential_deflection.deflection,
        elastic_slip_share=ratio_or_nan(tangential_deflection.deflection, largest_slip),
        creep=largest_creep,
        creep_share=ratio_or_nan(largest_creep, largest_slip),
    )


def _largest_creep_and_slip(
    scene: Scene, contact_states: Sequence[InterfaceState], arrays: Mapping[str, Any]
) -> tuple[float, float]:
    """Largest range, over the last cycle, of the relative displacement of nodes that stick all
    through it (creep), and of nodes that slip [length]; 0 where there are none.

    Stick and slip are those of the friction law: the states of the solution count a node that has
    hardly moved as sticking. Where the path does not repeat, all of it is the cycle.

    Parameters
    ----------
    scene
        load path with its period
    contact_states
        contact states at the k stored instants, with open, stick or slip of the n nodes by the law
    arrays
        "time" (k,) and "slip" (k, n) of the solution, in the scene's units
    """
    period = scene.load.path().period
    time = arrays["time"]
    is_in_cycle = np.ones(len(time), dtype=bool)
    if period is not None:
        is_in_cycle = time > time[-1] - period * (1 + 1e-9)
    states_by_law = np.stack([state.node_states for state in contact_states])[is_in_cycle]
    slip_range = np.ptp(arrays["slip"][is_in_cycle], axis=0)
    is_always_stuck = np.all(states_by_law[1:] == STICK, axis=0)
    has_slipped = np.any(slip_sign(states_by_law) != 0, axis=0)
    largest_creep = float(np.max(slip_range[is_always_stuck], initial=0.0))
    largest_slip = float(np.max(slip_range[has_slipped], initial=0.0))
    return largest_creep, largest_slip


def record_of(
    run: PathRun, scales: Scales, audit: PenaltyAudit, notes: Iterable[str] = ()
) -> Record:
    """Record of a run for the reader of its solution: whether it converged and how it ended, and at
    each stored instant the iterations, energies [energy / thickness] and admissibility checks.

    The checks are scaled violations of the conditions of contact and of the energy balance. Several
    increments may lie between two stored instants. Their energies and iterations are summed, of
    their checks the largest counts. The first stored instant is the unloaded state.

    Parameters
    ----------
    run
        what the increments along the load path report, scaled: works and checks by name, (n_steps,)
        each; iterations; indices of the states that are stored; `failure`, the error that stopped
        it, or None
    scales
        load P and modulus E*, with which works are P^2/E*
    audit
        the error of a penalty layer, in a sentence if there is a layer
    notes
        further sentences for the reader
    """
    note_of_layer = audit.note()  # None without a layer
    # Energies and works; that of the layer only where there is one.
    # _ENERGY_NAMES: names of the energies, works and step error among the values of an increment
    energy_names = [name for name in _ENERGY_NAMES if note_of_layer is not None or name != "layer"]
    energies = {name: run.values_of_increments(name) for name in energy_names}

    checks = _checks_of_increments(run)
    # Energy balance: external work = change of elastic energy + work at the interface. Its
    # imbalance is over the largest sum of external work since the start of the path.
    imbalance = np.abs(energies["external"] - energies["elastic"] - energies["interface"])
    largest_accumulated_work = np.max(np.abs(np.cumsum(energies["external"])), initial=1e-300)
    checks["energy_balance"] = imbalance / largest_accumulated_work
    work_unit = scales.load**2 / scales.modulus
    return Record(
        converged=run.failure is None,
        termination=_termination(run),
        message=_message(run),
        iterations=read_only_copy(_at_stored_instants(run, np.add, run.iterations), np.int64),
        certificates={
            name: _at_stored_instants(run, np.maximum, values) for name, values in checks.items()
        },
        energy={
            name: _at_stored_instants(run, np.add, values * work_unit)
            for name, values in energies.items()
        },
        notes=tuple(notes) if note_of_layer is None else (note_of_layer, *notes),
    )


def _at_stored_instants(run: PathRun, reduction: np.ufunc, values: ArrayLike) -> Array:
    """Values of the increments of a run, reduced to its stored instants: sum (`reduction` np.add)
    or maximum (np.maximum) of those since the stored instant before, (n_stored,). 0 of the first
    one, the unloaded state. Read-only.

    `values` has an entry for each increment; `run.stored_indices` are the indices of the stored
    states.
    """
    values_at_instants = np.asarray(values)
    if len(values_at_instants):
        # an increment that starts at a stored instant is the first one after it
        values_at_instants = reduction.reduceat(values_at_instants, run.stored_indices[:-1])
    return read_only_copy(np.concatenate([[0.0], values_at_instants]))


def _checks_of_increments(run: PathRun) -> dict[str, Array]:
    """Admissibility checks of the increments of a run by name, (n_steps,) each: all that the
    increments report but for energies and works.

    "loop_work" and "kink_work" are works too, but for other uses: of Q dU, and of kinks in an
    increment.
    """
    reported_names = list(run.increment_records[0]) if run.increment_records else []
    # _ENERGY_NAMES: names of the other energies and works
    names_of_works = (*_ENERGY_NAMES, "layer", "loop_work", "kink_work")
    return {
        name: run.values_of_increments(name)
        for name in reported_names
        if name not in names_of_works
    }


_ENERGY_NAMES = [
    "external",
    "external_end_of_step",
    "curve",
    "elastic",
    "interface",
    "end_of_step",
    "step_error",
    "layer",
    "dissipation",
]


def _termination(run: PathRun) -> str:
    """How a run along the load path ended: "interrupted" or "not converged" where it failed, else
    "ratcheting", "steady" (a revolution repeated the one before) or "end of path".
    """
    if run.failure is not None:
        return "interrupted" if isinstance(run.failure, Interrupted) else "not converged"
    if run.ratchets:
        return "ratcheting"
    return "end of path" if run.steady_from is None else "steady"


def _message(run: PathRun) -> str:
    """A sentence on how a run along the load path ended: failed, in a steady cycle, at the end of
    the path, or ratcheting.

    `run.iterations` has an entry for each increment, `run.force_change_by_cycle` the largest change
    of a nodal force over each revolution; `run.steady_from` is the index of the first revolution
    that repeats.
    """
    if run.failure is not None:
        return str(run.failure)
    n_increments = len(run.iterations)
    drift_text = ""
    if run.ratchets:
        drift_text = "; the upper body goes further by the same distance in each: ratcheting"
    if run.steady_from is None:
        return (
            f"the path ended after {n_increments} increments without a revolution that"
            f" repeats{drift_text}"
        )
    return (
        f"revolution {run.steady_from + 1} ended in the state it started from, to"
        f" {run.force_change_by_cycle[-1]:.1e} of the largest nodal force, after {n_increments}"
        f" increments{drift_text}"
    )
