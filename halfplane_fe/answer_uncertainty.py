"""How far each value of an answer may be from the true one: the rules of `uncertainty` on the
arrays of a run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from halfplane_fe.answer import creeping_zone, edges_are_sharp, in_last_cycle, zone_by_nodes
from halfplane_fe.between_nodes import StickZone
from halfplane_fe.contact import ContactProblem
from halfplane_fe.interface import least_depth
from halfplane_fe.resolution import Revolution
from halfplane_fe.run import PathRun
from halfplane_fe.scales import COARSE_CYCLES, contact_modulus, needs_shear
from halfplane_fe.supports import shapes_alike
from halfplane_fe.task import Task, surface_grading
from halfplane_fe.uncertainty import (
    DENSITY_RULE,
    Meshes,
    Peak,
    RunValues,
    density_uncertainty,
    displacement_uncertainties,
    largest_off_neighbours,
    norm_uncertainties,
    of_small_contacts,
    peak_uncertainty,
    run_values,
    scatter_of_nodes,
    share_of_flanks,
    share_of_shapes,
    slip_uncertainty,
    uncertainty,
)
from scenes import OPEN, Scene
from scenes.array_types import Array, Mask

# Share of what kinks between the first and the last start of sliding add to W that counts as
# uncertain.
_BENT = 0.2
# The same in records, whose increments are longer.
_BENT_IN_RECORDS = 0.3
# Share of the mean uncertainty of both contact edges that the half-width has: they do not err
# alike. Fitted to seeds 250 and 251 of benchmarks/covered.py values, both presets.
_OF_BOTH_EDGES = 0.95
# How many times the range of slip that counts as creep the mesh may add to it: 1.3 times on a
# coarse mesh of a block on a half-plane, where next to nothing slipped on finer ones.
_CREEP_OF_MESH = 10.0
# Distances of nodes beyond a permanent stick zone that such creep has to reach: a stick edge is
# known to one or two of them.
_CREEP_IN_NODES = 2.5


def cycle_uncertainty(task: Task, run: PathRun) -> float:
    """Uncertainty of the friction work of the last cycle by mesh and increments, in the run's unit
    of work; 0 where no shear can arise.
    """
    scene = task.scene
    if not needs_shear(scene):
        return 0.0
    first_increment = run.cycle_starts[-1] if run.cycle_starts else 0
    friction_unit = task.friction_unit
    # With bulk stress or tilt a cycle is compared with the coarse run's of the same number: they
    # only approach the steady state.
    densities_compared = (
        run.cycle_density[:COARSE_CYCLES] if scene.unsymmetric else run.cycle_density
    )
    dissipation = float(densities_compared[-1].sum())
    coarse_dissipation = task.scales.dissipation / task.work_unit
    edges_are_known = bool(run.excess) and not task.has_plain_errors and not scene.unsymmetric
    # Slip of real bodies ends node by node: an edge without a place may stand all the same.
    if edges_are_known and run.excess[-1].is_unplaced:
        edges_are_known = scene.bodies.half_planes
    edge_scatter = run.excess[-1].scatter / friction_unit if edges_are_known else 0.0
    # Unlike bodies: the increments of the nodes that start to slide bend the pressure too, and
    # their bound counts in full.
    if task.steps_by_kinks:
        step_uncertainty = _BENT_IN_RECORDS * run.column("bent")[first_increment:].sum()
    elif edges_are_known and shapes_alike(scene):
        step_uncertainty = _BENT * run.column("bent")[first_increment:].sum()
    else:
        step_uncertainty = run.column("step_error")[first_increment:].sum()
    return float(step_uncertainty) + friction_unit * uncertainty(
        dissipation / friction_unit,
        abs(dissipation - coarse_dissipation) / friction_unit,
        task.scales.element,
        task.mesh,
        edge_scatter,
        task.has_plain_errors,
    )


def dissipation_uncertainty(task: Task, run: PathRun, arrays: Mapping[str, Any]) -> float:
    """Uncertainty of the dissipation W [energy / thickness]: by mesh and increments, by cycles that
    still change, by flanks and shapes that the mesh only approaches; NaN where the run failed.
    """
    if run.failure is not None:
        return math.nan
    left_by_trend = float(np.nan_to_num(abs(run.trend.left)))
    revolution = revolution_of(task, run, arrays)
    element = task.element * task.scales.half_width
    share_of_mesh = share_of_flanks(
        task.scene.profile, revolution.least_contact(), element
    ) + share_of_shapes(task.scene, revolution.load, task.element)
    energy_of_cycle = (cycle_uncertainty(task, run) + left_by_trend) * task.work_unit
    return float(energy_of_cycle + arrays["dissipation"] * share_of_mesh)


def value_uncertainties(
    task: Task, problem: ContactProblem, run: PathRun, arrays: Mapping[str, Any]
) -> dict[str, float]:
    """By the name of a value, how far it may be from the true one by the mesh, in its own unit; NaN
    where there is no estimate, empty where the run failed.

    The values are those of the last cycle, but for the dissipation W and the contact and stick
    edges of each instant; and the L2 norms of p and q. `arrays` are those of the answer.
    """
    if run.failure is not None:
        return {}
    scene = task.scene
    coarse_values = task.scales.values
    values = _values_beside_coarse_run(task, problem, run)
    estimates = _displacement_uncertainties(task, values, arrays)
    estimates["largest_slip"] = 0.0
    estimates |= _norms_of_tractions(task, arrays)
    estimates["largest_dissipation_density"] = 0.0
    if needs_shear(scene):
        estimates["largest_slip"] = slip_uncertainty(
            values, coarse_values, _scaled_work(task, arrays), plain=task.has_plain_errors
        )
        density_error = density_uncertainty(arrays["x"], arrays["dissipation_density"])
        from_coarse_run = _from_coarse_run(values, coarse_values)
        if not task.has_plain_errors:
            refinement = task.scales.element / task.element
            from_coarse_run = DENSITY_RULE.uncertainty(0.0, from_coarse_run, refinement)
        # without an estimate by its neighbours there is none
        density_error = max(density_error, float(np.nan_to_num(from_coarse_run)))
        estimates["largest_dissipation_density"] = density_error
    estimates["largest_pressure"] = _peak_uncertainty(
        task, arrays, is_coupled=problem.interface.coupling is not None
    )
    step_of_largest_contact = int(np.argmax(arrays["contact_half_width"]))
    edge_uncertainty = arrays["contact_edge_uncertainty"][step_of_largest_contact]
    estimates["largest_half_width"] = _OF_BOTH_EDGES * float(np.mean(edge_uncertainty))
    estimates["permanent_stick_half_width"] = _of_permanent_stick(
        scene,
        arrays,
        zone_by_nodes(run).in_unit(task.scales.half_width),
        is_sharp=edges_are_sharp(scene, problem),
    )
    return estimates


def _displacement_uncertainties(
    task: Task, values: RunValues, arrays: Mapping[str, Any]
) -> dict[str, float]:
    """Uncertainties of tangential displacement and normal approach by the mesh [length], from their
    difference between the fine and the coarse run, and by contacts that are a few elements wide.
    """
    scales = task.scales
    meshes = Meshes(refinement=scales.element / task.element, plain=task.has_plain_errors)
    estimates = displacement_uncertainties(values, scales.values, meshes, needs_shear(task.scene))
    elements_at_edges = 2 * _spacing_at_edges(arrays["x"], arrays["contact_edges"])
    for displacement, load in (
        ("tangential_displacement", arrays["tangential_load"]),
        ("normal_approach", arrays["normal_load"]),
    ):
        estimates[displacement] += of_small_contacts(
            load, elements_at_edges, arrays["contact_half_width"], scales.modulus
        )
    return estimates


def _scaled_work(task: Task, arrays: Mapping[str, Any]) -> float:
    """W over A f^2 P^2, P the largest load: how much a contact with friction slips in a cycle."""
    return float(arrays["dissipation"]) / (task.friction_unit * task.work_unit)


def _norms_of_tractions(task: Task, arrays: Mapping[str, Any]) -> dict[str, float]:
    """Uncertainties of p and q in L2 over x, over the norms of p and f p, the largest of the last
    cycle: "pressure" and "shear"; NaN without an estimate.
    """
    estimates = norm_uncertainties(
        arrays["x"],
        arrays["pressure"],
        arrays["shear"],
        _under_load(task.scene, arrays),
        task.scene.friction.coefficient,
    )
    if task.has_plain_errors:
        # Linear elements and penalty layers have errors that nodes do not show.
        estimates = dict.fromkeys(estimates, math.nan)
    return estimates


def _values_beside_coarse_run(task: Task, problem: ContactProblem, run: PathRun) -> RunValues:
    """Values of the last cycle; where the coarse run made fewer cycles, and either run did not
    repeat, those of its last one: unlike bodies only approach their steady state.
    """
    scales = task.scales
    coarse_values = scales.values

    def values_of_cycle(cycle: int | None) -> RunValues:
        return run_values(
            run,
            problem.interface.weights,
            displacement_unit=scales.load / scales.modulus,
            stress_unit=scales.load / scales.half_width,
            cycle=cycle,
        )

    values = values_of_cycle(None)
    if coarse_values is None or values.is_comparable(coarse_values):
        return values
    return values_of_cycle(min(values.number, coarse_values.number))


def _under_load(scene: Scene, arrays: Mapping[str, Any]) -> Mask:
    """(n_steps,) instants of the last cycle under load, of the whole path where none repeats."""
    in_cycle = in_last_cycle(scene, arrays["time"], arrays["normal_load"])
    if in_cycle.any():
        return in_cycle
    return np.asarray(arrays["normal_load"] > 0)


def _from_coarse_run(values: RunValues, coarse_values: RunValues | None) -> float:
    """How far the largest W(x) is from that of the coarse run [energy / area]; NaN without one."""
    if coarse_values is None or not values.is_comparable(coarse_values):
        return math.nan
    return values.difference("largest_dissipation_density", coarse_values)


def _spacing_at_edges(x: Array, edges: Array) -> Array:
    """(k,) distance of the nodes around contact edges (k, 2), the larger of both sides [length]."""
    node_after = np.clip(np.searchsorted(x, edges), 1, len(x) - 1)
    return np.asarray(np.max(x[node_after] - x[node_after - 1], axis=1))


def _of_permanent_stick(
    scene: Scene, arrays: Mapping[str, Any], zone: StickZone, is_sharp: bool
) -> float:
    """Uncertainty of the permanent stick half-width [length]: of the stick edges that bound it, and
    of the `zone` by the nodes beside them.

    The zone ends at the innermost edge of the last cycle. With edges e +- u, that edge is between
    the innermost e - u and the innermost e + u. Between coupled bodies, and under bulk stress or
    tilt, the zone may reach beyond the edges of single instants, since what only creeps counts as
    stuck: these edges count as the end of the zone, and so may nodes that slip ten times as far,
    where they are more than those around the edge. NaN where nothing sticks all the time, and where
    the path does not repeat.
    """
    if math.isnan(arrays["permanent_stick_half_width"]):
        return math.nan
    in_cycle = in_last_cycle(scene, arrays["time"], arrays["normal_load"])
    outwards = np.array([-1.0, 1.0])
    in_cycle &= np.isfinite(arrays["stick_half_width"])
    ends = arrays["permanent_stick_edges"] * outwards
    edges = np.maximum(arrays["stick_edges"][in_cycle] * outwards, ends)
    edge_uncertainty = arrays["stick_edge_uncertainty"][in_cycle]
    innermost = edges.min(axis=0)
    innermost_nearest = (edges - edge_uncertainty).min(axis=0)
    innermost_farthest = (edges + edge_uncertainty).min(axis=0)
    by_stick_zones = np.maximum(innermost - innermost_nearest, innermost_farthest - innermost)
    places = arrays["permanent_stick_edges"]
    by_nodes = zone.uncertainty(places, by_stick_zones)
    if not is_sharp:
        slip = arrays["slip"][in_cycle]
        is_closed = arrays["state"][in_cycle] != OPEN
        creeping_edges = creeping_zone(scene, arrays["x"], slip, is_closed, _CREEP_OF_MESH)
        beyond = np.fmax((creeping_edges - places) * outwards, 0.0)
        is_creep = beyond > _CREEP_IN_NODES * _spacing_at_edges(arrays["x"], places[None])
        by_nodes = np.maximum(by_nodes, np.where(is_creep, beyond, 0.0))
    return float(np.mean(by_nodes))


def _peak_uncertainty(task: Task, arrays: Mapping[str, Any], is_coupled: bool) -> float:
    """Uncertainty of the largest pressure of the path by the mesh [stress], from the elements of
    the body with the coarser ones; NaN without contact.
    """
    scales = task.scales
    pressure = arrays["pressure"]
    step, node = np.unravel_index(np.argmax(pressure), pressure.shape)
    largest_pressure = float(pressure[step, node])
    distances_to_edges = np.abs(arrays["contact_edges"][step] - arrays["x"][node])
    peak = Peak(
        value=largest_pressure,
        difference=abs(largest_pressure - scales.largest_pressure),
        half_width=float(arrays["contact_half_width"][step]),
        to_edge=float(np.min(distances_to_edges)),
        stands_off=largest_off_neighbours(arrays["x"], pressure[step], int(node)),
        scatter=scatter_of_nodes(pressure[step], int(node)) if is_coupled else 0.0,
    )
    profile = task.scene.profile
    return peak_uncertainty(
        peak,
        profile,
        coarse=scales.element * scales.half_width,
        fine=surface_grading(task.mesh, scales, profile, max(task.mesh.upper_ratio, 1.0)),
        growth=task.mesh.growth,
        depth=least_depth(task.scene),
        plain=task.has_plain_errors,
    )


def revolution_of(task: Task, run: PathRun, arrays: Mapping[str, Any]) -> Revolution:
    """Loads, half-widths of contact and of stick at the instants of the last cycle, and its work
    over A f^2 P^2, A = 2/E* and P its largest load: what the mesh is judged by.
    """
    scene = task.scene
    first_step = 1
    if run.cycle_starts:
        first_step = int(np.searchsorted(run.stored, run.cycle_starts[-1])) + 1
    load = arrays["normal_load"][first_step:]
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    unit = 2 / modulus * (scene.friction.coefficient * np.max(load)) ** 2  # A f^2 P^2
    return Revolution(
        load=load,
        contact=arrays["contact_half_width"][first_step:],
        stick=arrays["stick_half_width"][first_step:],
        dissipation=float(arrays["dissipation"] / unit) if unit > 0 else 0.0,
        sheared=needs_shear(scene),
    )
