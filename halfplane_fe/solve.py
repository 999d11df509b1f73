"""From a scene to a FiniteElementSolution: scales, bodies, interface, load path, answer."""

from __future__ import annotations

import math
import platform
import time as clock
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from halfplane_fe.actuators import actuators_of, path_of
from halfplane_fe.answer import PenaltyAudit, answer_arrays, penalty_audit, record_of
from halfplane_fe.answer_of_rig import notes_of_rig, scene_of_loads
from halfplane_fe.condensed_bodies import CACHED
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.dundurs import dundurs
from halfplane_fe.edges import uncertainty_at_jumps
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.interface import (
    Interface,
    bulk_stress_notes,
    check_bulk_stress,
    check_supports,
    condensed_pair,
    couple,
    initial_gap,
    least_depth,
    meshed_pair,
    shapes_alike,
    without_local_difference,
)
from halfplane_fe.mirror import half, unfolded
from halfplane_fe.path import check_admissible
from halfplane_fe.resolution import Revolution, resolution_notes, tip_halvings
from halfplane_fe.run import MOST_INSTANTS, REPEATS, Pace, PathRun, Progress, run_path
from halfplane_fe.scales import (
    COARSE_CYCLES,
    RoomForContact,
    Scales,
    contact_modulus,
    estimate_room,
    find_scales,
    from_datum,
    is_plain_record,
    is_record,
    needs_shear,
    on_half,
    sheared,
)
from halfplane_fe.settings import SolverSettings
from halfplane_fe.systems import Layer
from halfplane_fe.uncertainty import (
    Meshes,
    Peak,
    of_small_contacts,
    peak_uncertainty,
    run_values,
    share_of_flanks,
    share_of_shapes,
    uncertainties,
    uncertainty,
    uncertainty_note,
)
from meshes import BodyMesh, MeshSettings, SurfaceGrading, check
from scenes import (
    ContactSolution,
    ConvergenceError,
    InputError,
    Profile,
    Scene,
    Work,
    freeze,
    scene_of,
)
from scenes.array_types import Array, Mask

# Counts of work: faces whose N - T and K lack what only the mesh makes of them, and runs repeated
# on the faces as they are.
_CURED = "interfaces without the mesh's part of N - T"
_REPEATED = "runs repeated with the mesh's part of N - T"
_NOTE_REPEATED = (
    "the contact did not converge on faces without the part of N - T and K that only the mesh"
    " makes: this is the answer of the faces as they are; where edges move its dissipation errs by"
    " the first power of the element"
)
# for one release: the name meant the active set up to 0.3
_NOTE_RENAMED = (
    "method augmented_lagrangian: since 0.4 the augmented Lagrangian of Simo and Laursen, with"
    " multipliers that are updated; what had this name before is active_set, the default, several"
    " times faster and with the same answer"
)

# Share of what kinks between the first and the last start of sliding add to W that counts as
# uncertain.
_BENT = 0.2
# The same in records, whose increments are longer.
_BENT_IN_RECORDS = 0.3
# Share of the largest P by which the loads of a rig's cycle may end elsewhere than they began
# without a note.
_CLOSED = 1e-9
# Least radius of a half-disc over the side that may touch: tilt can bring the contact far from x =
# 0.
_BEYOND = 1.5


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class FiniteElementSolution(ContactSolution):
    """A ContactSolution that also carries its bodies and interface states.

    `moment` is that of the tractions on the upper body about the point of first contact x = y = 0,
    `tilt` its rotation about it: on flat faces int x p dx; on a pad or cylinder the shear has a
    small part in it, q being at the height of the face. Bulk stress of a block acts on both of its
    ends; `bulk_stress_lower` and `bulk_stress_upper` are the mean of the two, which differ by Q/H
    where they hold Q (base on rollers).

    Attributes
    ----------
    bodies
        lower and upper BodyMesh, each in its own frame (y out of the body)
    condensed
        lower and upper CondensedBody
    states
        one InterfaceState per step, scaled
    weights
        (n_points,) share of the surface of each contact point, so that pressure times weight is
        a nodal force [length]
    normals
        (2, n_points) of the line half-way between the faces, out of the lower body: pressure
        acts along it
    scales
        what the coarse run found; with E* the units of `states`
    penalty
        what the layer of the penalty method costs
    contact_edge_uncertainty, stick_edge_uncertainty
        (n_steps, 2) how far each edge may be from the true one, by the mesh alone [length]; see
        `edges`
    """

    bodies: tuple[BodyMesh, BodyMesh]
    condensed: tuple[CondensedBody, CondensedBody]
    states: tuple[InterfaceState, ...]
    weights: Array
    normals: Array
    scales: Scales
    penalty: PenaltyAudit
    contact_edge_uncertainty: Array
    stick_edge_uncertainty: Array


def solve(
    scene: Scene | str | Path,
    mesh: MeshSettings | None = None,
    settings: SolverSettings | None = None,
    progress: Progress | None = None,
    *,
    scales: Scales | None = None,
) -> FiniteElementSolution:
    """Solve a scene by finite elements, on the mesh's own points and the stepping's own instants.

    Parameters
    ----------
    scene
        the question, or its name in the library, or the path of its file
    mesh, settings
        how it is cut and iterated; defaults serve the paper's scenes
    progress
        called with (done, total, text) as work goes on
    scales
        those of an earlier solution of the same scene, on whatever mesh: spares the coarse run,
        moves no number

    Raises
    ------
    InputError
        For a scene that does not pass its own check.
    InadmissibleLoadError
        If the path has gross sliding or separation, with instant and loads.
    ConvergenceError
        With `partial`, the solution up to the last accepted increment.

    Examples
    --------
    >>> fe = solve("hertz-normal", mesh=MeshSettings.coarse())
    >>> round(float(fe.contact_half_width.max()), 2)  # a = 1 mm by Hertz
    1.0
    """
    # Threads of BLAS gain nothing on matrices of a few hundred rows, and forty-fold time was seen
    # where they share busy cores.
    with threadpool_limits(limits=1, user_api="blas"):
        report = progress or (lambda _step, _of_steps, _text: None)
        return _solve(
            scene_of(scene), mesh or MeshSettings(), settings or SolverSettings(), report, scales
        )


@dataclass(frozen=True)
class _Task:
    """What is to be solved: the question, how it is meshed and iterated, and its scales."""

    scene: Scene
    mesh: MeshSettings
    settings: SolverSettings
    scales: Scales

    @property
    def has_plain_errors(self) -> bool:
        """Whether linear elements or a penalty layer make errors that are not of order 2."""
        return self.mesh.order == 1 or self.settings.method == "penalty"

    @property
    def steps_by_kinks(self) -> bool:
        """Whether what kinks in increments add stands for the whole error of the steps: in records
        of like bodies, without bulk stress, tilt or layer.
        """
        return is_plain_record(self.scene) and not self.has_plain_errors

    @property
    def element(self) -> float:
        """Size at the edges of contact and stick, of the coarser side, over the half-width."""
        return self.mesh.edge_element_size * max(self.mesh.upper_ratio, 1.0)

    @property
    def work_unit(self) -> float:
        """What dissipation is scaled by [energy / thickness]."""
        return self.scales.load**2 / self.scales.modulus

    @property
    def friction_unit(self) -> float:
        """A f^2 P^2 over `work_unit`, P the largest load."""
        return 2 * self.scene.friction.coefficient**2


def _solve(
    scene: Scene,
    mesh: MeshSettings,
    settings: SolverSettings,
    report: Progress,
    known_scales: Scales | None,
) -> FiniteElementSolution:
    watch = _Watch()
    _check_loads(scene)
    report(0, None, "coarse run")
    coarse_work: Counter[str] = Counter()
    scales = known_scales or find_scales(scene, coarse_work)
    task = _Task(scene, mesh, settings, scales)
    watch.lap("coarse run")
    report(0, None, "meshing and condensing the bodies")
    work: Counter[str] = Counter({f"coarse {name}": count for name, count in coarse_work.items()})
    bodies = meshed_pair(scene, mesh, partial(surface_grading, mesh, scales, scene.profile))
    watch.lap("mesh")
    # A datum inside the contact would lift the faces towards the load: no compliance that can be
    # factorised.
    datum = max(scene.profile.datum_length, scales.reach)
    condensed = condensed_pair(scene, bodies, datum, work)
    watch.lap("condensation")
    problem, run = _solve_path(task, couple(*condensed), datum, work, report)
    notes_on_rig = notes_of_rig(scene, problem, run, scales) if scene.load.is_driven else ()
    if datum > scene.profile.datum_length:
        run = from_datum(scene, run, scene.profile.datum_length / datum)
    watch.lap("load path")
    if scene.load.is_driven:
        task = replace(task, scene=scene_of_loads(scene, run, scales.load))
    answer = _solution(task, condensed, problem, run, watch.seconds)
    if scene.load.is_driven:
        answer = _of_last_cycle(answer, notes_on_rig)
    if run.failure is not None:
        raise type(run.failure)(str(run.failure), answer) from run.failure
    _check_room(answer, run)
    return answer


def _of_last_cycle(answer: FiniteElementSolution, notes: tuple[str, ...]) -> FiniteElementSolution:
    """The answer to a scene that states the loads of the last cycle alone, with further notes.

    The loads of a cycle that is not quite steady do not close, and those of the scene do: the last
    instant states the loads of the first.
    """
    loads = {
        "normal_load": answer.normal_load.copy(),
        "tangential_load": answer.tangential_load.copy(),
    }
    if answer.scene.load.path().period is not None:
        first, *_, last = answer.last_cycle
        gap = max(abs(float(load[last] - load[first])) for load in loads.values())
        share = gap / float(np.max(answer.normal_load))
        if share > _CLOSED:
            notes = (
                *notes,
                f"rig: P and Q at the end of the cycle differ by {share:.1g} of the largest P from"
                " those at its begin, which its last instant states",
            )
        for load in loads.values():
            load[last] = load[first]
    record = replace(answer.record, notes=(*answer.record.notes, *notes))
    return replace(
        answer,
        record=record,
        normal_load=freeze(loads["normal_load"]),
        tangential_load=freeze(loads["tangential_load"]),
        cycle_dissipation=freeze(answer.cycle_dissipation[-1:]),
        steady_from=None if answer.steady_from is None else 0,
    )


def _solve_path(
    task: _Task, true_faces: Interface, datum: float, work: Counter[str], report: Progress
) -> tuple[ContactProblem, PathRun]:
    """Follow the load path on faces without the mesh's part of N - T; on the faces as they are
    where there is none, or where the contact does not converge without it.
    """
    scene = task.scene
    # Increments of coupled bodies are dear, and a record has many; elsewhere short ones also place
    # the edges, which are fitted there.
    expected = 0.0
    if true_faces.coupling is not None or is_record(scene):
        expected = float(np.nan_to_num(task.scales.dissipation)) / task.work_unit
    pace = Pace(
        load=task.scales.load,
        steps_per_cycle=task.settings.steps_per_cycle,
        step_tolerance=task.settings.step_tolerance,
        half_width=task.scales.half_width,
        modulus=task.scales.modulus,
        dissipation=expected,
        of_kinks=task.steps_by_kinks,
    )
    cured_faces = without_local_difference(true_faces, scene)
    for faces in (true_faces,) if cured_faces is None else (cured_faces, true_faces):
        problem = _contact_problem(task, faces, datum, work)
        halved = on_half(scene, faces)
        solved = _contact_problem(task, half(faces), datum, work) if halved else problem
        run = run_path(
            solved,
            path_of(scene),
            pace,
            scene.cycles,
            report,
            uncertainty=partial(_uncertainty, task),
        )
        if not isinstance(run.failure, ConvergenceError):
            break
    if faces is cured_faces:
        work[_CURED] += 1
    elif cured_faces is not None:
        work[_REPEATED] += 1
    return problem, unfolded(run, faces) if halved else run


def require_solvable(scene: Scene, mesh: MeshSettings | None = None) -> RoomForContact | None:
    """What `solve` refuses before it makes a mesh of its own: half-planes by their loads, real
    bodies by an estimate of the contact too.

    Returns
    -------
    RoomForContact or None
        The estimate; None for half-planes, which have room for every contact.

    Raises
    ------
    InputError
        For a load path, supports or a face too narrow for the contact that `solve` refuses.
    ConvergenceError
        Where its coarse run does not converge.
    """
    _check_loads(scene)
    if scene.bodies.half_planes:
        return None
    settings = mesh or MeshSettings()
    with threadpool_limits(limits=1, user_api="blas"):
        estimate = estimate_room(scene, Counter())
    for name, shape, ratio in (
        ("lower", scene.bodies.lower, 1.0),
        ("upper", scene.bodies.upper, settings.upper_ratio),
    ):
        check(
            name,
            shape,
            scene.profile,
            surface_grading(settings, estimate.scales, scene.profile, ratio),
            settings,
        )
    return estimate


def _check_loads(scene: Scene) -> None:
    check_bulk_stress(scene)
    if scene.bodies.faces_are_true and not scene.profile.symmetric:
        raise InputError(
            "profile: symmetric = false goes with half-planes and blocks: pads and cylinders are"
            " meshed mirror-symmetric"
        )
    is_driven = scene.load.is_driven
    check_admissible(path_of(scene), scene.friction.coefficient, is_driven=is_driven)
    check_supports(scene, sheared(scene))


class _Watch:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = clock.perf_counter()

    def lap(self, stage: str) -> None:
        """End a stage."""
        now = clock.perf_counter()
        self.seconds[stage] = now - self._last
        self._last = now


def surface_grading(
    mesh: MeshSettings, scales: Scales, profile: Profile, ratio: float = 1.0
) -> SurfaceGrading:
    """Fine from just inside the innermost edge of any revolution to just outside the largest
    contact; sizes times `ratio`.

    Finer still at x = 0 where the profile has a tip, see `tip_halvings`.
    """
    # notation: a, the contact half-width at the largest load. The coarse run knows edges to a few
    # hundredths of it.
    a = scales.half_width
    inner = scales.inner - 0.06 * a
    outer = scales.reach + 0.06 * a + 2 * mesh.edge_element_size * a
    grading = SurfaceGrading(
        inner=inner if inner > 4 * mesh.element_size * a else 0.0,
        outer=outer,
        size=mesh.element_size * a * ratio,
        edge_size=mesh.edge_element_size * a * ratio,
        radius=max(mesh.far_radius * a, _BEYOND * outer),
    )
    return replace(grading, halvings=tip_halvings(profile, grading.innermost))


def _contact_problem(
    task: _Task, faces: Interface, datum: float, work: Counter[str]
) -> ContactProblem:
    """The contact problem of these faces, scaled, of half-planes with a datum length."""
    scene = task.scene
    scales = task.scales
    settings = task.settings
    interface = faces.scaled(scales.half_width, 1 / scales.modulus)
    # A stiffness of k E*/h per area is, node by node and scaled, k w/h: that of the layer, the
    # penalty, or the weight of the trial tractions.
    weights = interface.weights
    normal, tangential = settings.stiffnesses
    normal_stiffness = normal * weights / task.mesh.edge_element_size
    tangential_stiffness = tangential * weights / task.mesh.edge_element_size
    augmentation: tuple[Array | float, Array | float]
    if settings.method == "penalty":
        layer = Layer(1 / normal_stiffness, 1 / tangential_stiffness)
        augmentation = (1.0, 1.0)
    else:
        layer = Layer(np.zeros_like(weights), np.zeros_like(weights))
        augmentation = (normal_stiffness, tangential_stiffness)
    height = initial_gap(scene, faces) * scales.modulus / scales.load
    return ContactProblem(
        interface,
        height,
        scene.friction.coefficient,
        layer,
        tangential=needs_shear(scene),
        max_iterations=settings.max_iterations,
        augmentation=augmentation,
        moment_given=path_of(scene).moment_given,
        work=work,
        method=settings.method,
        actuators=actuators_of(scene, datum),
    )


def _check_room(answer: FiniteElementSolution, run: PathRun) -> None:
    """The contact must end before the last node that may touch."""
    if any(state.closed[0] or state.closed[-1] for state in run.states):
        raise ConvergenceError(
            f"the contact reached the end of the meshed side at |x| = {answer.x[-1]:.6g}: the"
            f" coarse run took it for smaller, {answer.scales.reach:.6g}",
            answer,
        )


def _solution(
    task: _Task,
    condensed: tuple[CondensedBody, CondensedBody],
    problem: ContactProblem,
    run: PathRun,
    seconds: Mapping[str, float],
) -> FiniteElementSolution:
    """The answer of a run, in the scene's units."""
    scene = task.scene
    scales = task.scales
    arrays = answer_arrays(scene, problem, run, scales)
    dissipation_uncertainty = float("nan")
    if run.failure is None:
        left_by_trend = float(np.nan_to_num(abs(run.trend.left)))
        dissipation_uncertainty = (_uncertainty(task, run) + left_by_trend) * task.work_unit
        revolution = _revolution(task, run, arrays)
        share_of_mesh = share_of_flanks(
            scene.profile, revolution.least_contact(), task.element * scales.half_width
        ) + share_of_shapes(scene, revolution.load, task.element)
        dissipation_uncertainty += arrays["dissipation"] * share_of_mesh
    uncertainties_of_values = _uncertainties(task, problem, run, arrays)
    # After that of permanent stick, which ends where no edge jumps to.
    arrays["stick_edge_uncertainty"] = freeze(
        np.maximum(
            arrays["stick_edge_uncertainty"],
            uncertainty_at_jumps(
                arrays["stick_edges"],
                np.asarray(run.stored),
                spacing=task.element * scales.half_width / task.mesh.order,
            ),
        )
    )
    states = tuple(run.states[index] for index in run.stored)
    audit = penalty_audit(scene, problem, states, arrays, scales)
    largest_tangential_load = float(np.abs(arrays["tangential_load"]).max())
    notes = [
        *bulk_stress_notes(scene, condensed, largest_tangential_load),
        *_notes(task, run, arrays),
        *uncertainty_note(
            arrays["dissipation"],
            dissipation_uncertainty,
            scene.tolerances,
            scales.dissipation,
        ),
    ]
    if task.settings.method == "augmented_lagrangian":
        notes.append(_NOTE_RENAMED)
    if problem.work[_REPEATED] and run.failure is None:
        notes.insert(0, _NOTE_REPEATED)
    grading = condensed[0].body.grading
    if not scene.unsymmetric:
        del arrays["permanent_stick_edges"]  # an attribute of unsymmetric scenes alone
    return FiniteElementSolution(
        engine="halfplane_fe",
        scene=scene,
        record=record_of(run, scales, audit, notes),
        dissipation_uncertainty=dissipation_uncertainty,
        uncertainties=uncertainties_of_values,
        work=_work(scene, problem, run, condensed, seconds),
        settings={
            "mesh": asdict(task.mesh),
            "solver": asdict(task.settings.with_stiffnesses()),
            "scales": scales.content(),
            "dundurs": dundurs(scene.material)._asdict(),
            "element_size": grading.edge_size,
            "penalty": {} if audit.note() is None else asdict(audit),
            "surface": {field.name: getattr(grading, field.name) for field in fields(grading)},
        },
        versions=versions(),
        bodies=(condensed[0].body, condensed[1].body),
        condensed=condensed,
        states=states,
        weights=freeze(problem.interface.weights * scales.half_width),
        normals=problem.interface.normals,
        scales=scales,
        penalty=audit,
        **arrays,
    )


def _uncertainty(task: _Task, run: PathRun) -> float:
    """Of the last revolution's dissipation by mesh and steps, scaled: 0 where no shear can
    arise.
    """
    scene = task.scene
    if not needs_shear(scene):
        return 0.0
    first = run.cycle_starts[-1] if run.cycle_starts else 0
    unit = task.friction_unit
    # With bulk stress or tilt a cycle is compared with the coarse run's of the same number: they
    # only approach the steady state.
    compared = run.cycle_density[:COARSE_CYCLES] if scene.unsymmetric else run.cycle_density
    dissipation = float(compared[-1].sum())
    of_coarse_run = task.scales.dissipation / task.work_unit
    scatter = None
    if run.excess and not task.has_plain_errors and not scene.unsymmetric:
        scatter = run.excess[-1].scatter / unit
    # Unlike bodies: the increments of the nodes that start to slide bend the pressure too, and
    # their bound counts in full.
    if task.steps_by_kinks:
        of_steps = _BENT_IN_RECORDS * run.column("bent")[first:].sum()
    elif scatter is not None and shapes_alike(scene):
        of_steps = _BENT * run.column("bent")[first:].sum()
    else:
        of_steps = run.column("step_error")[first:].sum()
    return float(of_steps) + unit * uncertainty(
        dissipation / unit,
        abs(dissipation - of_coarse_run) / unit,
        task.scales.element,
        task.mesh,
        scatter,
        task.has_plain_errors,
    )


def _uncertainties(
    task: _Task, problem: ContactProblem, run: PathRun, arrays: Mapping[str, Any]
) -> dict[str, float]:
    """By the mesh, of all but W and the edges of each instant; empty where the run failed."""
    if run.failure is not None:
        return {}
    scales = task.scales
    element = task.element
    values = run_values(
        run,
        problem.interface.weights,
        displacement_unit=scales.load / scales.modulus,
        stress_unit=scales.load / scales.half_width,
    )
    half_width = float(np.max(arrays["contact_half_width"]))
    stick = float(np.nan_to_num(arrays["permanent_stick_half_width"]))
    slip_width = max(half_width - stick, element * scales.half_width)
    meshes = Meshes(
        refinement=scales.element / element,
        coarse=scales.element * scales.half_width / slip_width,
        plain=task.has_plain_errors,
    )
    step = int(np.argmax(arrays["contact_half_width"]))
    sheared = needs_shear(task.scene)
    work = float(arrays["dissipation"]) / (task.friction_unit * task.work_unit) if sheared else 0.0
    by_meshes = uncertainties(values, scales.values, meshes, sheared, work)
    elements = 2 * _spacing_at_edges(arrays["x"], arrays["contact_edges"])
    for name, load in (
        ("tangential_displacement", arrays["tangential_load"]),
        ("normal_approach", arrays["normal_load"]),
    ):
        by_meshes[name] += of_small_contacts(
            load, elements, arrays["contact_half_width"], scales.modulus
        )
    return by_meshes | {
        "largest_pressure": _peak_uncertainty(task, arrays),
        "largest_half_width": float(np.mean(arrays["contact_edge_uncertainty"][step])),
        "permanent_stick_half_width": _of_permanent_stick(task.scene, arrays),
    }


def _spacing_at_edges(x: Array, edges: Array) -> Array:
    """(k,) distance of the nodes around contact edges (k, 2), the larger of both sides [length]."""
    following = np.clip(np.searchsorted(x, edges), 1, len(x) - 1)
    return np.asarray(np.max(x[following] - x[following - 1], axis=1))


def _of_permanent_stick(scene: Scene, arrays: Mapping[str, Any]) -> float:
    """Uncertainty of the permanent stick half-width [length]: of the stick edges that bound it.

    The zone ends at the innermost edge of the last cycle. With edges e +- u, that edge is between
    the innermost e - u and the innermost e + u. Between coupled bodies, and under bulk stress or
    tilt, the zone may reach beyond the edges of single instants, since what only creeps counts as
    stuck: these edges count as the end of the zone. NaN where nothing sticks all the time, and
    where the path does not repeat.
    """
    if math.isnan(arrays["permanent_stick_half_width"]):
        return math.nan
    in_cycle = _in_last_cycle(scene, arrays)
    outwards = np.array([-1.0, 1.0])
    in_cycle &= np.isfinite(arrays["stick_half_width"])
    ends = arrays["permanent_stick_edges"] * outwards
    edges = np.maximum(arrays["stick_edges"][in_cycle] * outwards, ends)
    edge_uncertainty = arrays["stick_edge_uncertainty"][in_cycle]
    innermost = edges.min(axis=0)
    nearest = (edges - edge_uncertainty).min(axis=0)
    farthest = (edges + edge_uncertainty).min(axis=0)
    return float(np.mean(np.maximum(innermost - nearest, farthest - innermost)))


def _in_last_cycle(scene: Scene, arrays: Mapping[str, Any]) -> Mask:
    """(n_steps,) stored instants of the last cycle under load; none where the path does not
    repeat.
    """
    period = scene.load.path().period or 0.0
    time = arrays["time"]
    in_cycle = time > time[-1] - period * (1 - 1e-9)
    return np.asarray(in_cycle & (arrays["normal_load"] > 0))


def _peak_uncertainty(task: _Task, arrays: Mapping[str, Any]) -> float:
    """Of the largest pressure by the mesh [stress]; elements of the coarser side. NaN without
    contact.
    """
    mesh = task.mesh
    scales = task.scales
    pressure = arrays["pressure"]
    step, node = np.unravel_index(np.argmax(pressure), pressure.shape)
    value = float(pressure[step, node])
    distances = np.abs(arrays["contact_edges"][step] - arrays["x"][node])
    peak = Peak(
        value=value,
        difference=abs(value - scales.largest_pressure),
        half_width=float(arrays["contact_half_width"][step]),
        to_edge=float(np.min(distances)),
    )
    profile = task.scene.profile
    return peak_uncertainty(
        peak,
        profile,
        coarse=scales.element * scales.half_width,
        fine=surface_grading(mesh, scales, profile, max(mesh.upper_ratio, 1.0)),
        mesh=mesh,
        depth=least_depth(task.scene),
        plain=task.has_plain_errors,
    )


def _notes(task: _Task, run: PathRun, arrays: Mapping[str, Any]) -> tuple[str, ...]:
    """What the mesh does not resolve in the last revolution, and what of the path is left."""
    if run.failure is not None:
        return ()
    element = task.element * task.scales.half_width
    revolution = _revolution(task, run, arrays)
    of_mesh = resolution_notes(task.scene.profile, revolution, element, task.mesh)
    of_run = (*_drift_notes(run, task.scales), *_thinned_notes(run))
    return (*of_run, *_creep_notes(task.scene, arrays), *of_mesh)


def _revolution(task: _Task, run: PathRun, arrays: Mapping[str, Any]) -> Revolution:
    """What the last revolution of a run asks of the mesh."""
    scene = task.scene
    first = 1
    if run.cycle_starts:
        first = int(np.searchsorted(run.stored, run.cycle_starts[-1])) + 1
    load = arrays["normal_load"][first:]
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    unit = 2 / modulus * (scene.friction.coefficient * np.max(load)) ** 2  # A f^2 P^2
    return Revolution(
        load=load,
        contact=arrays["contact_half_width"][first:],
        stick=arrays["stick_half_width"][first:],
        dissipation=float(arrays["dissipation"] / unit) if unit > 0 else 0.0,
        sheared=needs_shear(scene),
    )


def _creep_notes(scene: Scene, arrays: Mapping[str, Any]) -> Iterator[str]:
    """That the permanent stick zone reaches beyond stick edges of single instants, by more than
    these are uncertain.
    """
    ends = arrays["permanent_stick_edges"]
    if np.isnan(ends).any():
        return
    in_cycle = _in_last_cycle(scene, arrays)
    outwards = np.array([-1.0, 1.0])
    edges = arrays["stick_edges"][in_cycle] * outwards
    farthest = edges + arrays["stick_edge_uncertainty"][in_cycle]
    reaches_ends = np.all(farthest >= ends * outwards, axis=1)  # False where nothing sticks
    n_narrower = int(np.sum(~reaches_ends))
    if not n_narrower:
        return
    x = arrays["x"]
    slip_range = np.ptp(arrays["slip"][in_cycle], axis=0)
    creep = slip_range[(x > ends[0]) & (x < ends[1])].max(initial=0.0)
    share = creep / max(float(slip_range.max()), 1e-300)
    yield (
        f"the permanent stick zone, {ends[0]:.6g} to {ends[1]:.6g}, reaches beyond the stick edges"
        f" of {n_narrower} of {len(edges)} instants: what slips between them slips by {share:.1e}"
        " of the largest slip at most, and counts as stuck"
    )


def _thinned_notes(run: PathRun) -> Iterator[str]:
    """That not every increment is in the answer, and what is of all of them nevertheless."""
    dropped = len(run.states) - len(run.stored)
    if dropped:
        yield (
            f"{dropped} of {len(run.states)} instants of this long path are left out of the answer,"
            f" its files and figures (at most {MOST_INSTANTS} are kept, the rows of the record"
            " first); the worst instants of metrics are those of the kept ones, W, W(x), the"
            " closed integral of Q dU, the permanent stick zone and the checks are of all of them"
        )


def _drift_notes(run: PathRun, scales: Scales) -> Iterator[str]:
    """Shakedown that is only approached, and what the dissipation has left to go; ratcheting."""
    if not run.cycle_change:
        return
    works = [float(density.sum()) for density in run.cycle_density]
    last_work = works[-1]
    work_unit = scales.load**2 / scales.modulus
    trend = run.trend
    drift = ""
    if len(works) > 1 and last_work > 0:
        drift = f"; W changed by {1 - works[-2] / last_work:+.1e}"
    if run.steady_from is None:
        yield (
            f"no revolution repeats: the last of {len(works)} ends {run.cycle_change[-1]:.1e} of"
            f" the largest nodal force away from its start (up to {REPEATS:g} counts as the"
            f" same){drift}; give the scene more cycles"
        )
    if np.isfinite(trend.limit) and trend.left and last_work > 0:
        yield (
            f"shakedown: W of the revolutions tends to {trend.limit * work_unit:.6g}"
            f" ({trend.kind} trend). That of revolution {len(works)} still differs from it by"
            f" {abs(trend.left) / last_work:.1e} of W, which is in the uncertainty"
        )
    elif run.steady_from is not None and trend.left and last_work > 0:
        yield (
            f"shakedown: revolution {len(works)} repeats to {run.cycle_change[-1]:.1e} of the"
            f" largest nodal force{drift}; no trend is clear, uncertainty"
            f" {trend.left / last_work:.1e}"
        )
    if run.ratchets:
        shift_of_cycle = run.states[-1].shift - run.states[run.cycle_starts[-1]].shift
        moved = shift_of_cycle * scales.load / scales.modulus
        yield (
            f"ratcheting: each revolution moves the upper body by {moved:.3g} along x; the closed"
            " integral of Q dU holds the work of the mean Q on that way"
        )


def _work(
    scene: Scene,
    problem: ContactProblem,
    run: PathRun,
    condensed: tuple[CondensedBody, CondensedBody],
    seconds: Mapping[str, float],
) -> Work:
    """What was done, and what was not and why."""
    lower, upper = condensed
    one_mesh = lower.body is upper.body
    counts = {
        "bodies meshed": 1 if one_mesh else 2,
        "condensations": problem.work["condensations"],
        "degrees of freedom": int(lower.diagnostics["degrees_of_freedom"]),
        "contact nodes": len(lower.x),
        "steps solved": len(run.iterations),
        "sparse factorisations": problem.work["sparse factorisations"],
        **{name: int(count) for name, count in sorted(problem.work.items())},
    }
    skipped: dict[str, tuple[int, str]] = {}
    if one_mesh:
        skipped["meshes"] = (1, "both bodies have one shape: meshed once, reflected")
    if lower is upper:
        skipped["condensations"] = (
            1,
            "the bodies are alike: the upper one is the lower one reflected",
        )
    cached = problem.work[CACHED]
    if cached:
        skipped["condensations, cached"] = (
            cached,
            "this process condensed the body before: taken from the cache",
        )
    if on_half(scene, problem.interface):
        skipped["contact nodes"] = (
            len(problem.interface.x) // 2,
            "p is even in x, q even or odd: solved on one half",
        )
    if not problem.tangential:
        skipped["tangential problem"] = (len(run.iterations), "no shear can arise")
    if not problem.work[_CURED]:
        reason = (
            "an end of a face or a base is within ten nodes: W is of first order in the element"
        )
        if problem.work[_REPEATED]:
            reason = "the contact did not converge without it"
        skipped["the mesh's part of N - T"] = (1, reason)
    if problem.tangential and not problem.work["slip iterations"]:
        skipped["slip iterations"] = (len(run.iterations), "no node left stick")
    if run.steady_from is not None and run.steady_from + 1 < scene.cycles:
        skipped["revolutions"] = (
            scene.cycles - run.steady_from - 1,
            "the revolution before ended as it started",
        )
    dropped = len(run.states) - len(run.stored)
    if dropped:
        skipped["instants"] = (
            dropped,
            f"stored at {len(run.stored)} instants: more would take gigabytes",
        )
    return Work(counts, skipped, dict(seconds))


def versions() -> dict[str, str]:
    """Versions of everything that the numbers depend on."""
    packages = ("halfplane", "numpy", "scipy", "scikit-fem", "gmsh", "meshio")
    return {"python": platform.python_version()} | {name: _version(name) for name in packages}


_version = cache(version)  # each is read from a file
