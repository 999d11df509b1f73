"""From a scene to a FiniteElementSolution: scales, bodies, interface, load path, answer."""

from __future__ import annotations

import platform
import time as clock
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args, overload

import numpy as np
from threadpoolctl import threadpool_limits

from halfplane_fe.actuators import actuators_of
from halfplane_fe.answer import PenaltyAudit, answer_arrays, penalty_audit, record_of
from halfplane_fe.answer_notes import CORRECTED_FACES, REPEATED_RUNS, notes_of_answer, work_done
from halfplane_fe.answer_of_rig import notes_of_rig, scene_of_loads
from halfplane_fe.answer_uncertainty import (
    cycle_uncertainty,
    dissipation_uncertainty,
    value_uncertainties,
)
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.dundurs import dundurs
from halfplane_fe.edges import Edges, uncertainty_at_jumps
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.interface import (
    Interface,
    condensed_pair,
    couple,
    initial_gap,
    meshed_pair,
    without_mesh_error,
)
from halfplane_fe.mirror import half_interface, run_at_all_nodes
from halfplane_fe.path import prescribed_path
from halfplane_fe.run import Pace, PathRun, Progress, run_path
from halfplane_fe.scales import (
    Scales,
    find_scales,
    from_datum,
    is_record,
    needs_shear,
    on_half,
    on_half_planes,
)
from halfplane_fe.settings import SolverSettings
from halfplane_fe.solvable import check_loads
from halfplane_fe.systems import Layer
from halfplane_fe.task import Task, surface_grading
from meshes import BodyMesh, MeshSettings, SurfaceGrading
from scenes import (
    ContactSolution,
    ConvergenceError,
    InputError,
    Scene,
    read_only_copy,
    scene_of,
)
from scenes.array_types import Array, Mask

if TYPE_CHECKING:
    from halfplane_fe.kernel_bodies import KernelPair

Bodies = Literal["meshed", "kernel"]

_NOTE_OF_KERNELS = (
    "bodies: half-planes with the remainder kernels of the bodies; contact solver, increments and"
    " elements are those of the finite elements: a comparison with these checks the kernels alone"
)
# Share of the largest P by which the loads of a rig's cycle may end elsewhere than they began
# without a note.
_ROUNDING_OF_LOADS = 1e-9


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
    condensed_bodies
        lower and upper CondensedBody
    states
        one InterfaceState per step, scaled
    face_lengths
        (n_points,) length of face that each contact point stands for, so that pressure times this
        length is a nodal force [length]
    face_normals
        (2, n_points) of the line half-way between the faces, out of the lower body: pressure
        acts along it
    scales
        length and load scales by the run on a coarse mesh; with E* the units of `states`
    penalty
        errors by the layer of the penalty method: overlap of the faces, elastic slip and creep
    contact_edge_uncertainty, stick_edge_uncertainty
        (n_steps, 2) how far each edge may be from the true one, by the mesh alone [length]; see
        `edges`
    """

    bodies: tuple[BodyMesh, BodyMesh]
    condensed_bodies: tuple[CondensedBody, CondensedBody]
    states: tuple[InterfaceState, ...]
    face_lengths: Array
    face_normals: Array
    scales: Scales
    penalty: PenaltyAudit
    contact_edge_uncertainty: Array
    stick_edge_uncertainty: Array


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class KernelSolution(ContactSolution):
    """A ContactSolution of half-planes with the remainder kernels of the bodies, which it carries;
    see `kernel_bodies`.
    """

    kernels: KernelPair


@overload
def solve(
    scene: Scene | str | Path,
    mesh: MeshSettings | None = None,
    settings: SolverSettings | None = None,
    progress: Progress | None = None,
    *,
    scales: Scales | None = None,
    bodies: Literal["meshed"] = "meshed",
) -> FiniteElementSolution: ...


@overload
def solve(
    scene: Scene | str | Path,
    mesh: MeshSettings | None = None,
    settings: SolverSettings | None = None,
    progress: Progress | None = None,
    *,
    scales: Scales | None = None,
    bodies: Literal["kernel"],
) -> KernelSolution: ...


def solve(
    scene: Scene | str | Path,
    mesh: MeshSettings | None = None,
    settings: SolverSettings | None = None,
    progress: Progress | None = None,
    *,
    scales: Scales | None = None,
    bodies: Bodies = "meshed",
) -> ContactSolution:
    """Solve a frictional contact by finite elements along its load path: pressure, shear, slip,
    edges and friction work, at the nodes of the mesh and at the instants of the increments.

    Both bodies are meshed and condensed to their contact nodes, coupled there, and followed
    increment by increment until a cycle repeats.

    Parameters
    ----------
    scene
        bodies, materials, profile, friction and loads; or the name of a scene of the library, or
        the path of a scene file
    mesh, settings
        of the meshes, and of the contact solver and its increments; defaults serve the paper's
        scenes
    progress
        called with (done, total, text) as work goes on
    scales
        of an earlier solution of the same scene, on any mesh: spares the run on a coarse mesh,
        changes no number
    bodies
        "meshed"; or "kernel": half-planes plus the smooth compliance that the size of each body
        adds, from a coarse mesh of it. The result is then a KernelSolution, without fields inside
        the bodies

    Raises
    ------
    InputError
        For a scene that finite elements do not take; with "kernel" for faces other than flats, arcs
        and flats between arcs, for rollers with free sides, and for bulk stress.
    InadmissibleLoadError
        If the path has gross sliding or separation, with instant and loads.
    ConvergenceError
        Where an increment does not converge, or the contact reaches the end of its mesh. Its
        `partial` is the solution up to there.

    Examples
    --------
    >>> fe = solve("hertz-normal", mesh=MeshSettings.coarse())
    >>> round(float(fe.contact_half_width.max()), 2)  # a = 1 mm by Hertz
    1.0
    """
    # Threads of BLAS gain nothing on matrices of a few hundred rows, and take forty times as long
    # where they share busy cores.
    with threadpool_limits(limits=1, user_api="blas"):
        # without `progress` nothing is reported
        report = progress or (lambda _n_done, _n_parts, _text: None)
        if bodies not in get_args(Bodies):
            raise InputError(f"bodies = {bodies!r} is refused: it is 'meshed' or 'kernel'")
        return _solve(
            scene_of(scene),
            mesh or MeshSettings(),
            settings or SolverSettings(),
            report,
            scales,
            by_kernels=bodies == "kernel",
        )


def _without_meshes(answer: FiniteElementSolution, kernels: KernelPair) -> KernelSolution:
    """The answer of a solve by kernels as a KernelSolution: without its meshes, which are those of
    half-planes and not of the bodies. `kernels` are what the finite size of each body adds to the
    displacement of its face.
    """
    names = [attribute.name for attribute in fields(ContactSolution)]
    return KernelSolution(**{name: getattr(answer, name) for name in names}, kernels=kernels)


def _solve(
    scene: Scene,
    mesh: MeshSettings,
    settings: SolverSettings,
    report: Progress,
    known_scales: Scales | None,
    *,
    by_kernels: bool,
) -> ContactSolution:
    """Solve a scene in its stages: scales by a run on a coarse mesh, meshes, condensed compliances,
    coupling of both bodies, load path, and the solution with uncertainties and notes.

    Where the load path is not followed to its end, the error that is raised carries the solution up
    to there.

    Parameters
    ----------
    scene
        bodies, materials, profile, friction and loads; `load.is_driven` where actuators prescribe
        movements in the place of loads
    mesh, settings
        of the meshes, and of the contact solver
    report
        called with (done, total, text) as work proceeds
    known_scales
        scales of an earlier solution, which spare the run on a coarse mesh
    by_kernels
        half-planes plus the smooth compliance that the size of each body adds, instead of meshed
        bodies
    """
    stopwatch = _Stopwatch()
    check_loads(scene)
    if by_kernels:
        from halfplane_fe.kernel_bodies import (  # noqa: PLC0415 - for bodies by kernels alone
            check_kernels,
        )

        check_kernels(scene)

    # Scales: half-width and edges of the contact, by a run on a coarse mesh.
    report(0, None, "coarse run")
    coarse_counts: Counter[str] = Counter()
    scales = known_scales or find_scales(scene, coarse_counts)
    task = Task(scene, mesh, settings, scales)
    stopwatch.end_stage("coarse run")

    # Meshes and compliance of both bodies, with the datum length from which displacements count;
    # then the contact states along the load path.
    work_counts: Counter[str] = Counter(
        {f"coarse {name}": count for name, count in coarse_counts.items()}
    )
    report(0, None, "meshing and condensing the bodies")
    coupled_bodies = _bodies_of_contact(task, work_counts, stopwatch, by_kernels=by_kernels)
    problem, run = _solve_path(
        task, coupled_bodies.compliances, coupled_bodies.datum_length, work_counts, report
    )

    # The solution in the scene's units; up to where the path was followed if it failed.
    answer = _answer_of_run(task, coupled_bodies, problem, run, stopwatch)
    if run.failure is not None:
        raise type(run.failure)(str(run.failure), answer) from run.failure
    # ConvergenceError, with the solution, where the contact reaches the end of the meshed side
    _require_room(answer, run, scales)
    return answer


class _BodiesOfContact(NamedTuple):
    """Both bodies of a contact, meshed and condensed to their contact nodes.

    Attributes
    ----------
    condensed_bodies
        lower and upper body: meshes and compliances
    compliances
        compliance of both faces together, as meshed and without the error of the mesh
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    kernels
        what the finite size of each body adds to the displacement of its face, in a solve by
        kernels; else None
    """

    condensed_bodies: tuple[CondensedBody, CondensedBody]
    compliances: _FaceCompliances
    datum_length: float
    kernels: KernelPair | None


def _bodies_of_contact(
    task: Task, work_counts: Counter[str], stopwatch: _Stopwatch, *, by_kernels: bool
) -> _BodiesOfContact:
    """Mesh both bodies, condense each to its contact nodes, and couple them to one compliance of
    the faces.

    Parameters
    ----------
    task
        the scene, its mesh settings, and the scales by a run on a coarse mesh: `scales.reach` is
        the outermost |x| that the contact reaches [length]
    work_counts
        counts what was done
    stopwatch
        takes the time of the stages: mesh, condensation, kernels
    by_kernels
        half-planes plus the smooth compliance that the size of each body adds, instead of meshed
        bodies
    """
    scene = task.scene
    # Nearer to a load than the datum length a half-plane's surface is pressed in, beyond it the
    # surface rises. A datum inside the contact makes a compliance that is not positive definite.
    datum_outside_contact = max(scene.profile.datum_length, task.scales.reach)
    meshed_scene = on_half_planes(scene, datum_outside_contact) if by_kernels else scene
    # `grading` returns the element sizes along a face
    grading = partial(surface_grading, task.mesh, task.scales, scene.profile)
    bodies = meshed_pair(meshed_scene, task.mesh, grading)
    stopwatch.end_stage("mesh")
    condensed_bodies = condensed_pair(meshed_scene, bodies, datum_outside_contact, work_counts)
    stopwatch.end_stage("condensation")

    # Contact compliance of both: as meshed, and without the mesh error between nearby nodes.
    meshed_interface = couple(*condensed_bodies)
    compliances = _FaceCompliances(
        meshed_interface, without_mesh_error(meshed_interface, meshed_scene)
    )
    if not by_kernels:
        return _BodiesOfContact(condensed_bodies, compliances, datum_outside_contact, kernels=None)

    # What the finite size of each body adds to the displacement of its face.
    from halfplane_fe.kernel_bodies import (  # noqa: PLC0415 - for bodies by kernels alone
        kernel_pair,
    )

    largest_x = float(np.abs(meshed_interface.x).max())
    kernels = kernel_pair(scene, largest_x, datum_outside_contact, work_counts)
    compliances = compliances.with_kernels(kernels)
    stopwatch.end_stage("kernels")
    return _BodiesOfContact(condensed_bodies, compliances, datum_outside_contact, kernels)


def _answer_of_run(
    task: Task,
    coupled_bodies: _BodiesOfContact,
    problem: ContactProblem,
    run: PathRun,
    stopwatch: _Stopwatch,
) -> ContactSolution:
    """Solution from the contact states along the load path: approach and displacement from the
    datum of the scene, the loads in the place of actuators' movements, and the uncertainty of
    kernels.

    Parameters
    ----------
    task
        the scene, its mesh settings, solver settings, and the scales of its variables
    coupled_bodies
        both condensed bodies, their datum length (distance from a force at which a half-plane's
        surface counts as unmoved), and their kernels in a solve by kernels, else None
    problem, run
        the contact problem and its states along the path, scaled; the run may have failed
    stopwatch
        holds the time of the stages before; takes that of the load path
    """
    scene = task.scene
    scales = task.scales
    is_driven = scene.load.is_driven  # actuators prescribe movements in the place of loads
    notes_on_rig = notes_of_rig(scene, problem, run, scales) if is_driven else ()
    if coupled_bodies.datum_length > scene.profile.datum_length:
        run = from_datum(scene, run, scene.profile.datum_length / coupled_bodies.datum_length)
    stopwatch.end_stage("load path")
    if is_driven:
        task = replace(task, scene=scene_of_loads(scene, run, scales.load))
    answer = _solution(task, coupled_bodies.condensed_bodies, problem, run, stopwatch.seconds)
    if coupled_bodies.kernels is not None:
        answer = _with_error_of_kernels(answer, coupled_bodies.kernels)
    if is_driven:
        answer = _with_closed_cycle(answer, notes_on_rig)
    return (
        answer
        if coupled_bodies.kernels is None
        else _without_meshes(answer, coupled_bodies.kernels)
    )


def _with_error_of_kernels(
    answer: FiniteElementSolution, kernels: KernelPair
) -> FiniteElementSolution:
    """The answer with the uncertainty of its kernels added to that of the friction work W, a note
    that it is by kernels, and "kernel" in its settings. `kernels` are what the finite size of each
    body adds to the displacement of its face.
    """
    # by the difference of the kernels of two meshes; `scales.modulus` is E*
    relative_error = kernels.relative_work_error(answer.x, answer.scales.modulus)
    # _NOTE_OF_KERNELS: a sentence on where the bodies' compliances come from
    record_with_note = replace(answer.record, notes=(*answer.record.notes, _NOTE_OF_KERNELS))
    return replace(
        answer,
        record=record_with_note,
        dissipation_uncertainty=answer.dissipation_uncertainty
        + relative_error * answer.dissipation,
        settings={**answer.settings, "bodies": "kernel"},
    )


def _with_closed_cycle(
    answer: FiniteElementSolution, further_notes: tuple[str, ...]
) -> FiniteElementSolution:
    """Close the load cycle of a solution with actuators, where P and Q are results: at the end of
    the last cycle they are set to their values at its start. A scene's cycle of loads has to close.

    The scene of `answer` states these loads: the last cycle alone is its cycle, cycles before it
    are initial loading. So the friction work of one cycle stays, and it counts as steady from the
    first cycle on if it was steady. Where the loads differ by more than round-off (1e-9 of the
    largest P), a note states by how much. It and `further_notes` are added to the notes of the
    solution. A path without a period, which has no cycle, keeps its loads.
    """
    # P and Q (n_steps,); answer.last_cycle: indices of the steps of the last cycle
    load_histories = {
        "normal_load": answer.normal_load.copy(),
        "tangential_load": answer.tangential_load.copy(),
    }
    if answer.scene.load.path().period is not None:
        first_step, *_, last_step = answer.last_cycle
        load_difference = max(
            abs(float(load_history[last_step] - load_history[first_step]))
            for load_history in load_histories.values()
        )
        share_of_load = load_difference / float(np.max(answer.normal_load))
        if share_of_load > _ROUNDING_OF_LOADS:
            further_notes = (
                *further_notes,
                f"rig: P and Q at the end of the cycle differ by {share_of_load:.1g} of the largest"
                " P from those at its start, which its last instant states",
            )
        for load_history in load_histories.values():
            load_history[last_step] = load_history[first_step]

    record_with_notes = replace(answer.record, notes=(*answer.record.notes, *further_notes))
    return replace(
        answer,
        record=record_with_notes,
        normal_load=read_only_copy(load_histories["normal_load"]),
        tangential_load=read_only_copy(load_histories["tangential_load"]),
        cycle_dissipation=read_only_copy(answer.cycle_dissipation[-1:]),
        steady_from=None if answer.steady_from is None else 0,
    )


class _FaceCompliances(NamedTuple):
    """Contact compliance of both bodies, as their meshes give it, and without the error that the
    mesh adds between nearby nodes: `corrected_interface`, None where that error cannot be
    separated.
    """

    interface_as_meshed: Interface
    corrected_interface: Interface | None

    def with_kernels(self, kernels: KernelPair) -> _FaceCompliances:
        """Contact compliances of half-planes, as meshed and without the mesh's error, with the
        compliance that the finite size of the bodies adds to both.
        """
        corrected_interface = (
            None
            if self.corrected_interface is None
            else kernels.interface_of_bodies(self.corrected_interface)
        )
        return _FaceCompliances(
            kernels.interface_of_bodies(self.interface_as_meshed), corrected_interface
        )


def _solve_path(
    task: Task,
    compliances: _FaceCompliances,
    datum_length: float,
    work_counts: Counter[str],
    report: Progress,
) -> tuple[ContactProblem, PathRun]:
    """Follow the load path of a scene on its meshed bodies; returned are the contact problem on the
    whole faces and the run along the path, which may have failed.

    The compliance of the faces is tried first without the error that the mesh adds between nearby
    nodes. Where that error cannot be separated, or the contact does not converge without it, the
    compliance is taken as meshed. Faces that are their own mirror image are solved on one half.

    Parameters
    ----------
    task
        the scene, its mesh settings, solver settings, and the scales of its variables: half-width,
        largest load P, modulus E*, and friction work of a cycle on a coarse mesh
    compliances
        contact compliance of the bodies, as meshed (`interface_as_meshed`) and without the mesh's
        error (`corrected_interface`, None where that cannot be separated); its `coupling` is None
        of like bodies
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    work_counts
        counts what was done
    report
        called with (done, total, text) as work proceeds
    """
    scene = task.scene
    pace = _pace_of_path(task, compliances)
    # Try the corrected compliance, then that as meshed.
    candidates = (
        (compliances.interface_as_meshed,)
        if compliances.corrected_interface is None
        else (compliances.corrected_interface, compliances.interface_as_meshed)
    )
    for interface in candidates:
        problem = _contact_problem(task, interface, datum_length, work_counts)
        is_half = on_half(scene, interface)
        solved_problem = (
            _contact_problem(task, half_interface(interface), datum_length, work_counts)
            if is_half
            else problem
        )
        # `prescribed_path`: load path, with movements of actuators in the place of loads
        run = run_path(
            solved_problem,
            prescribed_path(scene),
            pace,
            scene.cycles,
            report,
            uncertainty=partial(cycle_uncertainty, task),
        )
        if not isinstance(run.failure, ConvergenceError):
            break

    if interface is compliances.corrected_interface:
        # CORRECTED_FACES: name of the count of runs without the mesh's error
        work_counts[CORRECTED_FACES] += 1
    elif compliances.corrected_interface is not None:
        # REPEATED_RUNS: name of the count of runs repeated with it
        work_counts[REPEATED_RUNS] += 1
    return problem, run_at_all_nodes(run, interface) if is_half else run


def _pace_of_path(task: Task, compliances: _FaceCompliances) -> Pace:
    """Units of the loads, and how finely the load path is divided into increments.

    The tolerated step error of the first revolution is a share of the expected friction work. That
    work is stated for coupled bodies, whose increments are costly, and for records of measured
    loads, which have many. Elsewhere it is stated as 0: a small least work takes its place, and
    increments are shorter. So the fitted edges are more accurate.

    Parameters
    ----------
    task
        the scene, its solver settings, the unit of friction work (`work_unit`), and its scales:
        half-width, largest load P, modulus E*, and friction work of a cycle on a coarse mesh (NaN
        where unknown); whether kinks of pressure and slip bound the step error (records of loads)
    compliances
        compliance of both faces; its `coupling` is None of like bodies
    """
    expected_dissipation = 0.0
    if compliances.interface_as_meshed.coupling is not None or is_record(task.scene):
        expected_dissipation = float(np.nan_to_num(task.scales.dissipation)) / task.work_unit
    return Pace(
        load_unit=task.scales.load,
        steps_per_cycle=task.settings.steps_per_cycle,
        step_tolerance=task.settings.step_tolerance,
        length_unit=task.scales.half_width,
        stress_unit=task.scales.modulus,
        expected_dissipation=expected_dissipation,
        kinks_bound_error=task.kinks_bound_step_error,
    )


class _Stopwatch:
    """Wall-clock time of each stage of a solution [s]."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = clock.perf_counter()

    def end_stage(self, stage: str) -> None:
        """End a stage of the solution: store under its name the time since the stage before it
        ended [s].
        """
        now = clock.perf_counter()
        self.seconds[stage] = now - self._last
        self._last = now


def _contact_problem(
    task: Task, unscaled_interface: Interface, datum_length: float, work_counts: Counter[str]
) -> ContactProblem:
    """Scaled contact problem of two meshed bodies: compliance, initial gap, friction, and the
    stiffnesses by which the solver decides about the states of nodes.

    Lengths are over the contact half-width, forces over the largest load, compliances over 1/E*.
    The penalty method puts the stiffnesses into an elastic layer between the faces. Other methods
    have no layer: the stiffnesses (`trial_weights`) turn gap and slip into trial tractions, whose
    sign and size decide on contact and stick.

    Parameters
    ----------
    task
        the scene, its mesh settings, solver settings (`stiffnesses`: two factors on E* over the
        size of the elements at edges), and the scales of its variables
    unscaled_interface
        contact compliance of the bodies in the scene's units
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    work_counts
        counters of the solution
    """
    scene = task.scene
    scales = task.scales
    settings = task.settings
    scaled_interface = unscaled_interface.scaled(scales.half_width, 1 / scales.modulus)
    layer, trial_weights = _layer_and_trial_weights(task, scaled_interface.face_lengths)
    # displacements are over P/E*
    scaled_gap = initial_gap(scene, unscaled_interface) * scales.modulus / scales.load
    return ContactProblem(
        scaled_interface,
        scaled_gap,
        scene.friction.coefficient,
        layer,
        has_shear=needs_shear(scene),
        max_iterations=settings.max_iterations,
        trial_weights=trial_weights,
        has_given_moment=prescribed_path(scene).moment_is_given,
        work_counts=work_counts,
        method=settings.method,
        actuators=actuators_of(scene, datum_length),
    )


def _layer_and_trial_weights(
    task: Task, face_lengths: Array
) -> tuple[Layer, tuple[Array | float, Array | float]]:
    """Compliance of the elastic layer between the faces, and the two weights that turn gap and slip
    of the nodes into trial tractions; scaled.

    The penalty method has the layer, and trial weights 1. Other methods have a layer of compliance
    0, and weights (n,) for gap and slip. A stiffness of k E*/h per area, h the length of an element
    at the edges of contact, is k w/h of a node with the area w.

    Parameters
    ----------
    task
        its solver settings hold the method and the two factors k (`stiffnesses`); its mesh settings
        h over the half-width
    face_lengths
        (n,) areas w of the nodes over the half-width
    """
    normal_factor, tangential_factor = task.settings.stiffnesses
    normal_stiffness = normal_factor * face_lengths / task.mesh.edge_element_size
    tangential_stiffness = tangential_factor * face_lengths / task.mesh.edge_element_size
    if task.settings.method == "penalty":
        return Layer(1 / normal_stiffness, 1 / tangential_stiffness), (1.0, 1.0)
    no_layer = Layer(np.zeros_like(face_lengths), np.zeros_like(face_lengths))
    return no_layer, (normal_stiffness, tangential_stiffness)


def _require_room(answer: ContactSolution, run: PathRun, scales: Scales) -> None:
    """Raise ConvergenceError, with the answer, where its contact reaches the last node that may
    touch, on the left or on the right, at any instant of the `run`. `scales.reach` is how far the
    run on a coarse mesh expected the contact to reach [length].
    """
    if any(state.is_closed[0] or state.is_closed[-1] for state in run.states):
        raise ConvergenceError(
            f"the contact reached the end of the meshed side at |x| = {answer.x[-1]:.6g}: the"
            f" coarse run took it for smaller, {scales.reach:.6g}",
            answer,
        )


def _solution(
    task: Task,
    condensed_bodies: tuple[CondensedBody, CondensedBody],
    problem: ContactProblem,
    run: PathRun,
    seconds: Mapping[str, float],
) -> FiniteElementSolution:
    """Solution in the scene's units from the contact states along a load path: tractions, slip,
    edges, friction work, their uncertainties, notes for the reader, and the effort.

    Parameters
    ----------
    task
        the scene, its mesh settings, solver settings, and the scales of its variables
    condensed_bodies
        compliance of the lower and upper body, condensed to the nodes of their faces
    problem, run
        the contact problem and its states along the path, scaled
    seconds
        name of a stage -> its time [s]
    """
    scene = task.scene
    scales = task.scales

    # Arrays and numbers of the solution by name; uncertainty of friction work and other values.
    arrays = answer_arrays(task, problem, run)
    work_uncertainty = dissipation_uncertainty(task, run, arrays)
    uncertainties_of_values = value_uncertainties(task, problem, run, arrays)
    # After the uncertainty of the permanent stick zone, taken above, which must not contain the
    # jumps of stick edges: no edge jumps to its end.
    arrays["stick_edge_uncertainty"] = _stick_uncertainty_with_jumps(task, problem, run, arrays)

    # States at the stored instants, error of a penalty layer, and notes for the reader.
    contact_states = tuple(run.states[index] for index in run.stored_indices)
    audit = penalty_audit(scene, problem, contact_states, arrays, scales)
    notes = notes_of_answer(task, condensed_bodies, problem, run, arrays, work_uncertainty)

    # Arrays that the uncertainties alone needed are no attributes of the solution.
    for name_of_array in ("permanent_stick_uncertainty", "permanent_stick_correction"):
        del arrays[name_of_array]
    if not scene.unsymmetric:
        del arrays["permanent_stick_edges"]  # an attribute of unsymmetric scenes alone
    lower_body, upper_body = condensed_bodies
    return FiniteElementSolution(
        engine="halfplane_fe",
        scene=scene,
        record=record_of(run, scales, audit, notes),
        dissipation_uncertainty=work_uncertainty,
        uncertainties=uncertainties_of_values,
        work=work_done(scene, problem, run, condensed_bodies, seconds),
        settings=_settings_of_solution(task, lower_body.body.grading, audit),
        versions=versions(),
        bodies=(lower_body.body, upper_body.body),
        condensed_bodies=condensed_bodies,
        states=contact_states,
        face_lengths=read_only_copy(problem.interface.face_lengths * scales.half_width),
        face_normals=problem.interface.face_normals,
        scales=scales,
        penalty=audit,
        **arrays,
    )


def _stick_uncertainty_with_jumps(
    task: Task, problem: ContactProblem, run: PathRun, arrays: Mapping[str, Any]
) -> Array:
    """Uncertainty (k, 2) of the left and right stick edge at the k stored instants of a run
    [length]; where an edge jumps, at least the length of the jump. Read-only.

    Parameters
    ----------
    task
        the scene, and the distance of the nodes at the edges (`spacing`)
    problem
        the contact problem; its `interface.coupling` is None of like materials
    run
        states with their loads, and which of them are stored
    arrays
        edges of stick and contact and the uncertainty of the former by name, (k, 2) each
    """
    uncertainty_by_jumps = uncertainty_at_jumps(
        Edges(arrays["stick_edges"], arrays["stick_edge_uncertainty"]),
        arrays["contact_edges"],
        run.stored_indices,
        spacing=task.spacing,
        first_of_cycle=_first_of_last_cycle(run),
        is_turn=_turns_of_slip(task.scene, problem, run)[run.stored_indices],
    )
    return read_only_copy(np.maximum(arrays["stick_edge_uncertainty"], uncertainty_by_jumps))


def _settings_of_solution(
    task: Task, grading: SurfaceGrading, audit: PenaltyAudit
) -> dict[str, Any]:
    """Settings with which a scene was solved, by name, as they are stored with the solution: mesh,
    solver, scales, Dundurs constants, element sizes, and the error of a penalty layer.

    Parameters
    ----------
    task
        the scene, its mesh settings, solver settings, and the scales of its variables
    grading
        element sizes along the face of the lower body
    audit
        overlap of the faces, elastic slip and creep by a penalty layer; its note is None without
        one
    """
    return {
        "mesh": asdict(task.mesh),
        "solver": asdict(task.settings.with_stiffnesses()),
        "scales": task.scales.content(),
        "dundurs": dundurs(task.scene.material)._asdict(),
        "element_size": grading.edge_size,
        "penalty": {} if audit.note() is None else asdict(audit),
        "surface": {field.name: getattr(grading, field.name) for field in fields(grading)},
    }


def _first_of_last_cycle(run: PathRun) -> int | None:
    """Row, among the stored instants of a run, of the first one of its last cycle; None where it is
    not stored, and without cycles. `run.cycle_starts` are indices of the states at which cycles
    start.
    """
    if not run.cycle_starts:
        return None
    index = run.cycle_starts[-1] + 1  # the cycle starts at the end of the increment before
    row = int(np.searchsorted(run.stored_indices, index))
    is_stored = row < len(run.stored_indices) and run.stored_indices[row] == index
    return row if is_stored else None


def _turns_of_slip(scene: Scene, problem: ContactProblem, run: PathRun) -> Mask:
    """At which states of a run slip ends because the loads turn round there, (n_states,), not
    earlier or later.

    Increments end at the turning points of P, Q - f P and Q + f P. Slip ends there between
    half-planes of like materials, without bulk stress and tilt. Of other bodies it does where every
    load that varies turns round: the loads then retrace the last increment.

    Parameters
    ----------
    scene
        bodies; whether there is bulk stress or tilt (`unsymmetric`)
    problem
        its `interface.coupling` is None of like materials
    run
        states with their loads; indices of those at the turning points and vertices of the path
        (`ends_of_stretches`), and of those at which cycles start
    """
    is_turn = np.zeros(len(run.states), dtype=bool)
    is_turn[run.ends_of_stretches] = True
    if scene.bodies.half_planes and problem.interface.coupling is None and not scene.unsymmetric:
        return is_turn

    changes_of_loads = np.diff(np.array([state.loads for state in run.states]), axis=0)
    # Where cycles repeat, the first increment of the last one follows the last increment.
    first_of_cycle = run.cycle_starts[-1] if run.cycle_starts else 0
    changes_after = np.append(
        changes_of_loads[1:], changes_of_loads[first_of_cycle : first_of_cycle + 1], axis=0
    )
    turns_round = np.all(changes_of_loads * changes_after <= 0, axis=1)
    turns_round &= np.any(changes_of_loads * changes_after < 0, axis=1)
    is_turn[1:] &= turns_round
    return is_turn


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that the numbers depend on, by name."""
    packages = ("halfplane", "numpy", "scipy", "scikit-fem", "gmsh", "meshio")
    return {"python": platform.python_version()} | {name: _version(name) for name in packages}


_version = cache(version)  # each is read from a file
