"""How far each value of an answer may be from the true one: the rules of `uncertainty` on the
arrays of a run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from halfplane_fe.answer import (
    creeping_zone,
    is_loaded_in_last_cycle,
    permanent_stick_ends_sharply,
    permanent_stick_zone,
)
from halfplane_fe.between_nodes import StickZone
from halfplane_fe.contact import ContactProblem
from halfplane_fe.edges import left_of_growth
from halfplane_fe.interface import least_depth
from halfplane_fe.resolution import Revolution
from halfplane_fe.run import PathRun
from halfplane_fe.scales import COARSE_CYCLES, contact_modulus, needs_shear
from halfplane_fe.supports import bodies_are_alike
from halfplane_fe.task import Task, surface_grading
from halfplane_fe.uncertainty import (
    DENSITY_RULE,
    Meshes,
    Peak,
    RunValues,
    density_uncertainty,
    displacement_uncertainties,
    largest_deviation_from_neighbours,
    norm_uncertainties,
    of_small_contacts,
    peak_uncertainty,
    run_values,
    scatter_of_nodes,
    share_of_flanks,
    slip_uncertainty,
    uncertainty,
)
from scenes import OPEN, Scene
from scenes.array_types import Array, Indices, Mask

# Share of what kinks between the first and the last start of sliding add to W that counts as
# uncertain.
_BENT = 0.2
# The same in records, whose increments are longer.
_BENT_IN_RECORDS = 0.3
# Share of the bound of `law.step_errors` of bodies of two shapes whose edges are located: of
# blocks, pads and cylinders at constant P less than a tenth is left.
_OF_BOUND = 0.5
# Loads beside P and Q, and the least share of a second direction of their path: less is round-off.
_IMPOSED = ("bulk_stress_lower", "bulk_stress_upper", "tilt")
_IN_PHASE = 1e-6
# Share of its range within which the slip of a node has reached its end.
_SAME_SLIP = 1e-6
# Share of the mean uncertainty of both contact edges that the half-width has: they do not err
# alike. At the largest contact they stand alike in their elements: 0.9 at most of half-planes but
# for one of 538. Seeds 701 to 705 of benchmarks/covered.py values, both presets.
_OF_BOTH_EDGES = 0.95
# The same of real bodies: the pads of the maps differ from kernels by up to 1.2.
_OF_BOTH_EDGES_OF_BODIES = 1.3
# How many times the range of slip that counts as creep the mesh may add to it: 1.3 times on a
# coarse mesh of a block on a half-plane, where next to nothing slipped on finer ones.
_CREEP_OF_MESH = 10.0
# Nodes on either side of the largest pressure among which the largest scatter counts.
_BESIDE_LARGEST_PRESSURE = 4
# Distances of nodes beyond a permanent stick zone that such creep has to reach: a stick edge is
# known to one or two of them.
_CREEP_IN_NODES = 2.5


def cycle_uncertainty(task: Task, run: PathRun) -> float:
    """Uncertainty of the friction work W of the last load cycle, or of a path that does not repeat,
    by mesh and increments. 0 where no shear can arise; NaN without a coarse run of this scene, or
    where its elements are hardly larger.

    It is in the run's scaled unit: `task.work_unit` times it is [energy / thickness]. The part of
    the mesh follows from the difference from the run on the coarse mesh. The part of the increments
    follows from bounds that the run has recorded for each.

    # notation: A = 2/E*, f coefficient of friction, P largest load

    Parameters
    ----------
    task
        the scene, its mesh, and scales with W and element size of the run on the coarse mesh;
        whether errors are of low order (linear elements, penalty layer)
    run
        friction work of the nodes in each cycle, and bounds of the error of each increment.
        `edge_excess_by_cycle`: friction work that the mesh adds in each cycle, since edges of
        contact and stick move from node to node, and its scatter `rms`
    """
    scene = task.scene
    if not needs_shear(scene):
        return 0.0
    friction_unit = task.friction_unit  # A f^2 P^2, scaled

    # W of the run and of the coarse run. With bulk stress or tilt cycles only approach the steady
    # state: the second one of each run is compared (COARSE_CYCLES: 2, most of the coarse run).
    nodal_work_of_cycles = (
        run.nodal_work_by_cycle[:COARSE_CYCLES] if scene.unsymmetric else run.nodal_work_by_cycle
    )
    dissipation = float(nodal_work_of_cycles[-1].sum())
    coarse_dissipation = task.scales.dissipation / task.work_unit

    # rms of W over the places of edges between their nodes, over A f^2 P^2
    edges_are_located = _edges_are_located(task, run)
    edge_scatter = run.edge_excess_by_cycle[-1].rms / friction_unit if edges_are_located else None

    # The part of the mesh is found over A f^2 P^2, and added in the unit of the run.
    step_uncertainty = _uncertainty_by_increments(task, run, edges_are_located=edges_are_located)
    return step_uncertainty + friction_unit * uncertainty(
        dissipation / friction_unit,
        abs(dissipation - coarse_dissipation) / friction_unit,
        task.scales.element_size,
        task.mesh,
        edge_scatter,
        task.has_errors_of_low_order,
    )


def _edges_are_located(task: Task, run: PathRun) -> bool:
    """Whether the edges of contact and stick of the last cycle count as located between the nodes,
    so that what they add to the friction work, as they move from node to node, was subtracted.

    Not so with linear elements or a penalty layer (`task.has_errors_of_low_order`), nor with bulk
    stress, tilt, or a profile that is not its own mirror image (`unsymmetric`). Where no edge of a
    permanent stick zone could be located (`is_unplaced`), this holds of half-planes alone: in other
    bodies slip stops in one node after the other, and such an edge may add work all the same.

    `run.edge_excess_by_cycle` has, for each cycle that was completed, the work that edges add.
    """
    scene = task.scene
    if not run.edge_excess_by_cycle or task.has_errors_of_low_order or scene.unsymmetric:
        return False
    return bool(not run.edge_excess_by_cycle[-1].is_unplaced or scene.bodies.half_planes)


def _uncertainty_by_increments(task: Task, run: PathRun, *, edges_are_located: bool) -> float:
    """Uncertainty of the friction work W of the last load cycle, or of a path that does not repeat,
    by its finite increments, scaled: a share of what bounds their errors, added up.

    Between like bodies whose edges are located, and in records of loads, the bound is the work by
    kinks ("kink_work"): what kinks of pressure and slip add to W of an increment, between the first
    node that starts to slide and the last. A fifth of it counts, in records three tenths. Elsewhere
    the bound is the larger "step_error". That counts in full, or by half where edges are located.

    Parameters
    ----------
    task
        the scene with its bodies; `kinks_bound_step_error` in records of loads of like bodies
    run
        bounds of each increment by name, and index of the increment at which each cycle starts
    edges_are_located
        whether edges of contact and stick are located between the nodes
    """
    first_increment = run.cycle_starts[-1] if run.cycle_starts else 0
    # _BENT_IN_RECORDS: 0.3; _BENT: 0.2; _OF_BOUND: 0.5
    if task.kinks_bound_step_error:
        name_of_bound = "kink_work"
        share_of_bound = _BENT_IN_RECORDS
    elif edges_are_located and bodies_are_alike(task.scene):
        name_of_bound = "kink_work"
        share_of_bound = _BENT
    else:
        name_of_bound = "step_error"
        share_of_bound = _OF_BOUND if edges_are_located else 1.0
    bounds_of_cycle = run.values_of_increments(name_of_bound)[first_increment:]
    return float(share_of_bound * bounds_of_cycle.sum())


def dissipation_uncertainty(task: Task, run: PathRun, arrays: Mapping[str, Any]) -> float:
    """Uncertainty of the friction work W of the last load cycle, or of a path that does not repeat
    [energy / thickness]; NaN where the run failed, or without a coarse run to compare with.

    It adds up the error by mesh and increments, the change of W to its limit over further cycles
    (0 where unknown), and two errors proportional to W. These come from narrow flanks of the
    contact with steep pressure, and from slip that turns round within increments.

    Parameters
    ----------
    task
        the scene, its mesh, and the unit of scaled work [energy / thickness]
    run
        `trend` is how W goes on from cycle to cycle, with the change to its limit
    arrays
        fields and series of the solution by name, in the scene's units
    """
    if run.failure is not None:
        return math.nan
    change_to_limit = float(np.nan_to_num(abs(run.trend.change_to_limit)))
    share_by_flanks = _share_of_flanks(task, run, arrays)
    # (n,) friction work per area, W(x), times the length of face of each node
    work_of_nodes = arrays["dissipation_density"] * np.gradient(arrays["x"])
    work_of_cycle = max(float(work_of_nodes.sum()), 1e-300)
    share_by_turns = float(work_of_nodes @ _shares_of_turns(task.scene, arrays)) / work_of_cycle
    relative_uncertainty = share_by_flanks + share_by_turns
    uncertainty_of_run = (cycle_uncertainty(task, run) + change_to_limit) * task.work_unit
    return float(uncertainty_of_run + arrays["dissipation"] * relative_uncertainty)


def _share_of_flanks(task: Task, run: PathRun, arrays: Mapping[str, Any]) -> float:
    """Relative uncertainty of the friction work W of the last load cycle by narrow flanks of the
    contact, its parts beyond the flat of a rounded flat punch.

    It is a mean over the stored instants under load of that cycle, or of the whole path where it
    does not repeat. Each counts by the work since the stored instant before. 0 of other profiles,
    and where nothing is loaded or no work is done.

    Parameters
    ----------
    task
        the scene; size of the elements at the edges over the contact half-width
        (`element_size`)
    run
        friction work of each increment, and indices of the states that are stored
    arrays
        fields and series of the solution by name
    """
    scene = task.scene
    loaded_rows = np.flatnonzero(_under_load(scene, arrays))
    if scene.profile.kind != "flat_rounded" or not len(loaded_rows):
        return 0.0
    # friction work of the increments since the stored instant before; 0 of the first instant
    works = np.add.reduceat(run.values_of_increments("dissipation"), run.stored_indices[:-1])
    work_at_instants = np.maximum(np.append(0.0, works)[loaded_rows], 0.0)
    if not work_at_instants.any():
        return 0.0
    element_size = task.element_size * task.scales.half_width
    shares = [
        share_of_flanks(scene.profile, half_width, element_size)
        for half_width in arrays["contact_half_width"][loaded_rows].tolist()
    ]
    return float(np.average(shares, weights=work_at_instants))


def _shares_of_turns(scene: Scene, arrays: Mapping[str, Any]) -> Array:
    """Relative uncertainty of the friction work per area, W(x), at the nodes (n,) because slip
    turns round within increments, not at their ends; the mean over forward and reverse slip.

    Where bulk stress or tilt varies out of phase with the loads, nodes turn round one after the
    other. The loads' own turns are ends of increments. A smooth slip that turns at a time t from
    the nearer end of an increment is less there by t^2/2 of its amplitude, t in radians of the
    cycle. This t is at most half of the last increment in which the node slides.

    Zeros where no bulk stress or tilt varies out of phase, and on paths of straight segments.

    Parameters
    ----------
    scene
        load path with its period
    arrays
        fields and series of the solution by name
    """
    path = scene.load.path()
    # rows of the instants of the last cycle
    rows_of_cycle = np.flatnonzero(
        is_loaded_in_last_cycle(scene, arrays["time"], arrays["normal_load"])
    )
    is_curved = any(not segment.is_straight for segment in path.cycle)
    if path.period is None or not is_curved or not _is_out_of_phase(arrays, rows_of_cycle):
        return np.zeros(len(arrays["x"]))

    # For both senses of slip: the increment in which a node first reaches the end of its slip.
    time = arrays["time"][rows_of_cycle]
    slip = arrays["slip"][rows_of_cycle]
    # _SAME_SLIP: 1e-6 of its range, within which slip has reached its end
    tolerance = _SAME_SLIP * np.ptp(slip, axis=0)
    shares = []
    for sense in (1, -1):
        reaches_end = sense * slip >= np.max(sense * slip, axis=0) - tolerance
        last_step = np.maximum(np.argmax(reaches_end, axis=0), 1)
        angles = 2 * np.pi * (time[last_step] - time[last_step - 1]) / path.period
        shares.append(angles**2 / 8)  # (angle/2)^2/2, the angle in radians of the cycle
    return np.mean(shares, axis=0)


def _is_out_of_phase(arrays: Mapping[str, Any], rows_of_cycle: Indices) -> bool:
    """Whether bulk stress or tilt varies in a load cycle, and the path of all loads is no straight
    line: its second singular value is more than round-off.

    `arrays` has the loads by name, (n_steps,) each; `rows_of_cycle` are the steps of the cycle.
    """
    # _IMPOSED: names of both bulk stresses and tilt
    varying_names = [
        name for name in _IMPOSED if name in arrays and np.ptp(arrays[name][rows_of_cycle])
    ]
    if not varying_names:
        return False
    names = ("normal_load", "tangential_load", *varying_names)
    loads = np.stack([arrays[name][rows_of_cycle] / np.max(np.abs(arrays[name])) for name in names])
    loads_from_mean = loads - loads.mean(axis=1, keepdims=True)
    largest_singular_value, second_singular_value, *_ = np.linalg.svd(
        loads_from_mean, compute_uv=False
    )
    # _IN_PHASE: least share of a second direction that is not round-off
    return bool(second_singular_value > _IN_PHASE * largest_singular_value)


def value_uncertainties(
    task: Task, problem: ContactProblem, run: PathRun, arrays: Mapping[str, Any]
) -> dict[str, float]:
    """Uncertainty of each value of a finite-element solution by mesh and increments, by its name;
    NaN where there is no estimate, empty where the run failed. The friction work W and the edges of
    single instants are not among them.

    - Of the last load cycle, or of a path that does not repeat: tangential displacement, normal
      approach, largest slip, largest friction work per area, half-width of permanent stick; in the
      units of these values.
    - Of all stored instants: largest pressure and largest contact half-width, in their units.
    - "pressure" and "shear": relative, in the L2 norm over x, at the worst instant of that cycle.

    Parameters
    ----------
    task
        the scene, its meshes, and the values of the run on the coarse mesh (`scales.values`; None
        where there was none); element sizes at the edges over the contact half-width, of the run
        (`element_size`) and of the coarse run (`scales.element_size`)
    problem, run
        the contact problem (its `interface.coupling` is None of like bodies), and its states along
        the load path
    arrays
        fields and series of the solution by name, in the scene's units; those of the edges have
        their uncertainty in them
    """
    if run.failure is not None:
        return {}
    scene = task.scene

    # Displacements, by the difference from the coarse run in one cycle (`values_of_cycle`); L2
    # norms of the tractions, by neighbouring nodes.
    coarse_values = task.scales.values
    values_of_cycle = _values_beside_coarse_run(task, problem, run)
    estimates = _displacement_uncertainties(task, values_of_cycle, arrays)
    estimates["largest_slip"] = 0.0
    estimates |= _traction_uncertainties(task, arrays)

    # Largest slip and largest friction work per area; 0 without shear.
    estimates["largest_dissipation_density"] = 0.0
    if needs_shear(scene):
        estimates["largest_slip"] = slip_uncertainty(
            values_of_cycle,
            coarse_values,
            _scaled_work(task, arrays),
            task.spacing / task.scales.half_width,
            _meshes(task),
        )
        estimates["largest_dissipation_density"] = _density_uncertainty(
            task, values_of_cycle, arrays
        )

    # Largest pressure and contact half-width of the whole path; permanent stick of the last cycle.
    estimates["largest_pressure"] = _peak_uncertainty(
        task, arrays, is_coupled=problem.interface.coupling is not None
    )
    estimates["largest_half_width"] = _half_width_uncertainty(scene, arrays)
    # by nodes and loads; its ends are moved outwards as those of the solution were
    zone = permanent_stick_zone(run).in_unit(task.scales.half_width)
    estimates["permanent_stick_half_width"] = _permanent_stick_uncertainty(
        scene,
        arrays,
        zone.moved(arrays["permanent_stick_correction"]),
        is_sharp=permanent_stick_ends_sharply(scene, problem),
    )
    return estimates


def _density_uncertainty(
    task: Task, values_of_cycle: RunValues, arrays: Mapping[str, Any]
) -> float:
    """Uncertainty of the largest friction work per area of the last cycle by mesh and increments
    [energy / area]; NaN where neighbouring nodes give no estimate.

    It is the larger one of an estimate by neighbouring nodes and of that by the difference from the
    run on the coarse mesh, plus a share for the turning points of slip.

    Parameters
    ----------
    task
        the scene, and the values of the run on the coarse mesh; whether errors are of low order
    values_of_cycle
        values of the run that are compared with those of the coarse run
    arrays
        fields and series of the solution by name, in the scene's units
    """
    density_error = density_uncertainty(arrays["x"], arrays["dissipation_density"])
    change_from_coarse_run = _density_change_from_coarse_run(values_of_cycle, task.scales.values)
    if not task.has_errors_of_low_order:
        refinement = task.scales.element_size / task.element_size
        # DENSITY_RULE: uncertainty from a difference of two meshes, with an error of order 1
        change_from_coarse_run = DENSITY_RULE.uncertainty(0.0, change_from_coarse_run, refinement)
    # NaN without an estimate by neighbouring nodes, whatever the coarse run
    density_error = max(density_error, float(np.nan_to_num(change_from_coarse_run)))
    node = int(np.argmax(arrays["dissipation_density"]))
    share_by_turns = _shares_of_turns(task.scene, arrays)[node]
    return density_error + float(arrays["dissipation_density"][node] * share_by_turns)


def _half_width_uncertainty(scene: Scene, arrays: Mapping[str, Any]) -> float:
    """Uncertainty of the largest contact half-width by the mesh [length]: a share of the mean
    uncertainty of both edges at the stored instant of the largest contact.

    `arrays` holds half-width and uncertainty of the edges at the stored instants, `scene` whether
    the bodies are half-planes, of which the share is smaller.
    """
    step_of_largest_contact = int(np.argmax(arrays["contact_half_width"]))
    edge_uncertainty = arrays["contact_edge_uncertainty"][step_of_largest_contact]
    share_of_mean = _OF_BOTH_EDGES if scene.bodies.half_planes else _OF_BOTH_EDGES_OF_BODIES
    return share_of_mean * float(np.mean(edge_uncertainty))


def _displacement_uncertainties(
    task: Task, values_of_fine_run: RunValues, arrays: Mapping[str, Any]
) -> dict[str, float]:
    """Uncertainties of tangential displacement and normal approach by the mesh [length], by the
    names of both; NaN where there is no coarse run to compare with.

    They follow from the difference between the fine and the coarse run in one load cycle. To this
    comes the error at instants of the whole path when the contact is only a few elements wide.

    Parameters
    ----------
    task
        the scene; size of the elements at the edges over the half-width, of the run
        (`element_size`) and of the coarse run (`scales.element_size`); values of the coarse run
        (`scales.values`), and E*
    values_of_fine_run
        displacements of the fine run at the instants of the load cycle that is compared
    arrays
        fields and series of the solution by name, in the scene's units
    """
    scales = task.scales
    estimates = displacement_uncertainties(
        values_of_fine_run, scales.values, _meshes(task), needs_shear(task.scene)
    )
    # (n_instants,) of the quadratic elements at the contact edges: two node distances
    element_sizes = 2 * _spacing_at_edges(arrays["x"], arrays["contact_edges"])
    for name, load in (
        ("tangential_displacement", arrays["tangential_load"]),
        ("normal_approach", arrays["normal_load"]),
    ):
        estimates[name] += of_small_contacts(
            load, element_sizes, arrays["contact_half_width"], scales.modulus
        )
    return estimates


def _meshes(task: Task) -> Meshes:
    """The two meshes on which values are compared: of the run and of the coarse run."""
    return Meshes(
        refinement=task.scales.element_size / task.element_size,
        has_low_order=task.has_errors_of_low_order,
    )


def _scaled_work(task: Task, arrays: Mapping[str, Any]) -> float:
    """Friction work W of the last cycle over A f^2 P^2: how much a contact slips in it.

    # notation: A = 2/E*, f coefficient of friction, P largest load
    """
    return float(arrays["dissipation"]) / (task.friction_unit * task.work_unit)


def _traction_uncertainties(task: Task, arrays: Mapping[str, Any]) -> dict[str, float]:
    """Relative uncertainties of pressure and shear in the L2 norm over x, at the worst instant of
    the last load cycle: "pressure" over the norm of p, "shear" over that of f p. Where the path
    does not repeat, all its instants under load count.

    NaN for linear elements and penalty layers (`task.has_errors_of_low_order`), and where no
    instant counts. `arrays` has pressure and shear (n_steps, n) at nodes x (n,).

    # notation: p pressure, f coefficient of friction
    """
    estimates = norm_uncertainties(
        arrays["x"],
        arrays["pressure"],
        arrays["shear"],
        _under_load(task.scene, arrays),
        task.scene.friction.coefficient,
    )
    if task.has_errors_of_low_order:
        # Linear elements and penalty layers have errors that nodes do not show.
        estimates = dict.fromkeys(estimates, math.nan)
    return estimates


def _values_beside_coarse_run(task: Task, problem: ContactProblem, run: PathRun) -> RunValues:
    """Displacements, largest slip and largest friction work per area of the load cycle to compare
    with the coarse run, in the scene's units.

    That is the last cycle of `run`. If either run has not reached a steady cycle, and the coarse
    one ended earlier, it is the cycle at which the coarse one ended. Values of two runs are
    comparable if both are of the same cycle (`number`), or of a steady one.

    `task.scales` has load, half-width and E*, which values of the run are scaled by; `problem` the
    length of face of each node.
    """
    scales = task.scales
    coarse_values = scales.values  # of the run on the coarse mesh that set the scales

    def values_of_cycle(cycle: int | None) -> RunValues:
        """Values of a cycle of the run, by its number from 1; of the last one for None."""
        return run_values(
            run,
            problem.interface,
            displacement_unit=scales.load / scales.modulus,
            stress_unit=scales.load / scales.half_width,
            cycle=cycle,
        )

    values = values_of_cycle(None)
    if coarse_values is None or values.is_comparable(coarse_values):
        return values
    return values_of_cycle(min(values.number, coarse_values.number))


def _under_load(scene: Scene, arrays: Mapping[str, Any]) -> Mask:
    """Which stored instants count for values of the last load cycle, a mask (n_steps,): those under
    load (P > 0) in that cycle, without the instant at its start. Where there are none, as on a path
    that does not repeat, all instants under load.
    """
    is_in_cycle = is_loaded_in_last_cycle(scene, arrays["time"], arrays["normal_load"])
    if is_in_cycle.any():
        return is_in_cycle
    return np.asarray(arrays["normal_load"] > 0)


def _density_change_from_coarse_run(values: RunValues, coarse_values: RunValues | None) -> float:
    """Difference of the largest friction work per area, W(x), from that of the coarse run [energy /
    area]; NaN without a coarse run, or where the values of both are not of comparable load cycles.
    """
    if coarse_values is None or not values.is_comparable(coarse_values):
        return math.nan
    return values.difference("largest_dissipation_density", coarse_values)


def _spacing_at_edges(x: Array, edges: Array) -> Array:
    """Distance of the two nodes around a contact edge at k instants, (k,), the larger of the left
    and the right edge [length]; `edges` (k, 2), nodes at x (n,).
    """
    node_after = np.clip(np.searchsorted(x, edges), 1, len(x) - 1)
    return np.asarray(np.max(x[node_after] - x[node_after - 1], axis=1))


def _permanent_stick_uncertainty(
    scene: Scene, arrays: Mapping[str, Any], zone: StickZone, is_sharp: bool
) -> float:
    """Uncertainty of the permanent stick half-width by the mesh [length], the mean over both ends;
    NaN where nothing sticks through the whole cycle, or the path does not repeat.

    Where slip or creep of nodes locates an end, its uncertainty is known. Elsewhere the zone ends
    at the innermost stick edge of the last cycle. With edges e and their uncertainty u, that edge
    is between the innermost e - u and the innermost e + u. Where loads locate an end between two
    nodes, or these nodes confine it more closely, their uncertainty counts.

    Between unlike bodies, and under bulk stress or tilt, nodes that slip by next to nothing (creep)
    count as stuck. The zone may then reach beyond the stick edges of single instants: such edges
    are moved out to its end. The mesh may add to creep: the uncertainty reaches to the nodes that
    slip up to ten times as far, if that is more than 2.5 node distances.

    Parameters
    ----------
    scene
        load path, with the period of its cycle
    arrays
        fields and series of the solution by name, in the scene's units;
        "permanent_stick_correction" (2,) is what was added to the ends, since growing elements hold
        edges back; "permanent_stick_uncertainty" (2,) is that of ends located by slip or creep,
        else NaN
    zone
        the permanent stick zone by its nodes and by the loads [length]
    is_sharp
        whether any slip at all counts as slip: like bodies without bulk stress and tilt
    """
    if math.isnan(arrays["permanent_stick_half_width"]):
        return math.nan

    is_in_cycle = is_loaded_in_last_cycle(scene, arrays["time"], arrays["normal_load"])
    is_in_cycle &= np.isfinite(arrays["stick_half_width"])
    zone_ends = arrays["permanent_stick_edges"]
    # by the load that locates an end; else by the innermost stick edges or, if closer, its nodes
    end_uncertainty = zone.uncertainty(
        zone_ends,
        _uncertainty_by_innermost_edges(
            arrays["stick_edges"][is_in_cycle],
            arrays["stick_edge_uncertainty"][is_in_cycle],
            zone_ends,
        ),
    )
    if not is_sharp:
        creep_beyond_end = _creep_beyond_ends(scene, arrays, is_in_cycle)
        end_uncertainty = np.maximum(end_uncertainty, creep_beyond_end)

    # Ends by slip, and what the correction for growing elements may leave.
    uncertainty_by_slip = arrays["permanent_stick_uncertainty"]
    end_uncertainty = np.where(
        np.isfinite(uncertainty_by_slip), uncertainty_by_slip, end_uncertainty
    )
    uncertainty_by_growth = left_of_growth(arrays["permanent_stick_correction"])
    return float(np.mean(end_uncertainty + uncertainty_by_growth))


def _uncertainty_by_innermost_edges(
    stick_edges: Array, edge_uncertainty: Array, zone_ends: Array
) -> Array:
    """Uncertainty (2,) of the innermost stick edges of a cycle, left and right [length]. With edges
    e and their uncertainty u, the innermost edge is between the innermost e - u and e + u.

    Parameters
    ----------
    stick_edges, edge_uncertainty
        (k, 2) left and right stick edge at k instants, and their uncertainty
    zone_ends
        (2,) ends of the permanent stick zone: edges inside it are moved out to its end
    """
    # Left edges change sign, so that "farther out" means "larger" at both edges.
    outwards = np.array([-1.0, 1.0])
    outward_edges = np.maximum(stick_edges * outwards, zone_ends * outwards)
    innermost_edge = outward_edges.min(axis=0)
    innermost_inner_bound = (outward_edges - edge_uncertainty).min(axis=0)
    innermost_outer_bound = (outward_edges + edge_uncertainty).min(axis=0)
    return np.asarray(
        np.maximum(innermost_edge - innermost_inner_bound, innermost_outer_bound - innermost_edge)
    )


def _creep_beyond_ends(scene: Scene, arrays: Mapping[str, Any], is_in_cycle: Mask) -> Array:
    """How far beyond each end of the permanent stick zone nodes slip by up to ten times what counts
    as creep, (2,) [length]: the mesh may add as much. 0 up to 2.5 node distances.

    `arrays` are fields and series of the solution by name, `is_in_cycle` (n_steps,) states which
    stored instants are in the last cycle and have a stick zone.
    """
    zone_ends = arrays["permanent_stick_edges"]
    slip = arrays["slip"][is_in_cycle]
    is_closed = arrays["state"][is_in_cycle] != OPEN
    # _CREEP_OF_MESH: factor on the range of slip that counts as creep
    creeping_edges = creeping_zone(scene, arrays["x"], slip, is_closed, _CREEP_OF_MESH)
    creep_beyond_end = np.fmax((creeping_edges - zone_ends) * [-1.0, 1.0], 0.0)
    spacing = _spacing_at_edges(arrays["x"], zone_ends[None])
    # _CREEP_IN_NODES: 2.5 node distances
    reaches_far = creep_beyond_end > _CREEP_IN_NODES * spacing
    return np.where(reaches_far, creep_beyond_end, 0.0)


def _peak_uncertainty(task: Task, arrays: Mapping[str, Any], is_coupled: bool) -> float:
    """Uncertainty of the largest pressure at any stored instant of the load path, by the mesh
    [stress]; NaN without contact, or where the elements are nearly as large as those of the coarse
    run.

    `is_coupled`: the bodies are unlike, so that shear changes the pressure. Then the pressure of
    neighbouring nodes scatters, and the largest scatter counts in place of that of the peak. It
    also counts for tabulated profiles, whose curvature jumps at every row: the pressure is an arch
    from row to row.

    Parameters
    ----------
    task
        the scene, mesh settings (growth of the element size with the distance from the contact,
        element size of the upper body over that of the lower), and scales: half-width, and of the
        coarse run its largest pressure and the size of its elements over the half-width
    arrays
        pressure (n_steps, n), contact edges and half-width by name, in the scene's units
    """
    scales = task.scales
    profile = task.scene.profile
    has_scatter = is_coupled or profile.kind == "tabulated"

    # The largest pressure: instant, node, and values that its error is estimated from.
    pressure = arrays["pressure"]
    step, node = np.unravel_index(np.argmax(pressure), pressure.shape)
    largest_pressure = float(pressure[step, node])
    distances_to_edges = np.abs(arrays["contact_edges"][step] - arrays["x"][node])
    scatter = 0.0
    if has_scatter:
        scatter = scatter_of_nodes(pressure[step], int(node), _BESIDE_LARGEST_PRESSURE)
    peak = Peak(
        value=largest_pressure,
        change_from_coarse=abs(largest_pressure - scales.largest_pressure),
        half_width=float(arrays["contact_half_width"][step]),
        distance_to_edge=float(np.min(distances_to_edges)),
        deviation_from_neighbours=largest_deviation_from_neighbours(
            arrays["x"], pressure[step], int(node)
        ),
        alternation=scatter_of_nodes(pressure[step], int(node), n_beside=0),
        scatter=scatter,
    )
    # `fine_sizes`: of the elements along the face of the body with the coarser ones
    return peak_uncertainty(
        peak,
        profile,
        coarse_size=scales.element_size * scales.half_width,
        fine_sizes=surface_grading(task.mesh, scales, profile, max(task.mesh.upper_ratio, 1.0)),
        growth=task.mesh.growth,
        depth=least_depth(task.scene),
        has_low_order=task.has_errors_of_low_order,
    )


def revolution_of(task: Task, run: PathRun, arrays: Mapping[str, Any]) -> Revolution:
    """Normal loads P, half-widths of contact and of stick at the stored instants of the last load
    cycle, without its start, and its friction work: what the resolution of the mesh is judged by.

    Loads and half-widths are in the scene's units. The work is over A f^2 P^2 with A = 2/E*, f the
    coefficient of friction and P the largest load of the cycle. Where no cycle was begun, it is all
    of the path. `run` has the indices of the stored states, and of those at which cycles start.
    """
    scene = task.scene
    first_step = 1  # row of the stored instants
    if run.cycle_starts:
        first_step = int(np.searchsorted(run.stored_indices, run.cycle_starts[-1])) + 1
    normal_load = arrays["normal_load"][first_step:]
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    work_unit = 2 / modulus * (scene.friction.coefficient * np.max(normal_load)) ** 2  # A f^2 P^2
    return Revolution(
        load=normal_load,
        contact_half_width=arrays["contact_half_width"][first_step:],
        stick_half_width=arrays["stick_half_width"][first_step:],
        dissipation=float(arrays["dissipation"] / work_unit) if work_unit > 0 else 0.0,
        has_shear=needs_shear(scene),
    )
