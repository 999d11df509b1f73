"""From a scene to a FiniteElementSolution: scales, bodies, interface, load path, answer."""

from __future__ import annotations

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

from halfplane_fe.answer import PenaltyAudit, answer_arrays, from_datum, penalty_audit, record_of
from halfplane_fe.arrays import Array
from halfplane_fe.condensed_bodies import CACHED
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.dundurs import dundurs
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
from halfplane_fe.resolution import (
    Peak,
    peak_uncertainty,
    resolution_notes,
    tip_halvings,
    uncertainty,
    uncertainty_note,
)
from halfplane_fe.run import MOST_INSTANTS, REPEATS, Pace, PathRun, Progress, run_path
from halfplane_fe.scales import (
    COARSE_CYCLES,
    Scales,
    contact_modulus,
    find_scales,
    needs_shear,
    on_half,
    sheared,
)
from halfplane_fe.settings import SolverSettings
from halfplane_fe.systems import Layer
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

# Counts of work: faces whose N - T and K lack what only the mesh makes of them, and runs repeated
# on the faces as they are.
_CURED, _KEPT = (
    "interfaces without the mesh's part of N - T",
    "runs repeated with the mesh's part of N - T",
)
_NOTE_KEPT = (
    "the contact did not converge on faces without the part of N - T and K that only the mesh"
    " makes: this is the answer of the faces as they are; where edges move its dissipation errs by"
    " the first power of the element"
)

# Share of what kinks between the first and the last start of sliding add to W that counts as
# uncertain.
_BENT = 0.2
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
    bodies : lower and upper BodyMesh, each in its own frame (y out of the body)
    condensed : lower and upper CondensedBody
    states : one InterfaceState per step, scaled
    weights : (n_points,) share of the surface of each contact point, so that pressure times weight
    is a nodal force [length] normals : (2, n_points) of the line half-way between the faces, out of
    the lower body: pressure acts along it scales : what the coarse run found; with E* the units of
    `states`
    penalty : what the layer of the penalty method costs
    largest_pressure_uncertainty : of the largest pressure at the points, see
        `resolution.peak_uncertainty`; NaN where the elements at the edges are like those of the
        coarse run [stress]
    contact_edge_uncertainty, stick_edge_uncertainty : (n_steps, 2) how far each edge may be from
        the true one, by the mesh alone [length]; see `edges`
    """

    bodies: tuple[BodyMesh, BodyMesh]
    condensed: tuple[CondensedBody, CondensedBody]
    states: tuple[InterfaceState, ...]
    weights: Array
    normals: Array
    scales: Scales
    penalty: PenaltyAudit
    largest_pressure_uncertainty: float
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
    scene : the question, or its name in the library, or the path of its file
    mesh, settings : how it is cut and iterated; defaults serve the paper's scenes
    progress : called with (done, total, text) as work goes on
    scales : those of an earlier solution of the same scene, on whatever mesh: spares the coarse
        run, moves no number

    Raises
    ------
    InputError
        For a scene that does not pass its own check.
    InadmissibleLoadError
        If the path has gross sliding or separation, with instant and loads.
    ConvergenceError
        With `partial`, the solution up to the last accepted increment.

    >>> fe = solve("hertz-normal", mesh=MeshSettings.coarse())
    >>> round(float(fe.contact_half_width.max()), 2)  # a = 1 mm by Hertz
    1.0
    """
    # Threads of BLAS gain nothing on matrices of a few hundred rows, and forty-fold time was seen
    # where they share busy cores.
    with threadpool_limits(limits=1, user_api="blas"):
        report = progress or (lambda _done, _total, _text: None)
        mesh, settings = mesh or MeshSettings(), settings or SolverSettings()
        return _solve(scene_of(scene), mesh, settings, report, scales)


def _solve(
    scene: Scene,
    mesh: MeshSettings,
    settings: SolverSettings,
    report: Progress,
    known: Scales | None,
) -> FiniteElementSolution:
    watch = _Watch()
    _check_loads(scene)
    report(0, None, "coarse run")
    coarse_work: Counter[str] = Counter()
    scales = known or find_scales(scene, coarse_work)
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
    made = couple(*condensed)
    cured = without_local_difference(made, scene)
    # Increments of coupled bodies are dear; where nothing couples, short ones also place the edges,
    # which are fitted there.
    expected = (
        float(np.nan_to_num(scales.dissipation)) * scales.modulus / scales.load**2
        if made.coupling is not None
        else 0.0
    )
    pace = Pace(
        scales.load,
        settings.steps_per_cycle,
        settings.step_tolerance,
        scales.half_width,
        scales.modulus,
        expected,
    )
    doubt = partial(_uncertainty, scene, mesh, settings, scales)
    for faces in (made,) if cured is None else (cured, made):
        problem = _contact_problem(scene, mesh, settings, scales, faces, work)
        solved = (
            _contact_problem(scene, mesh, settings, scales, half(faces), work)
            if on_half(scene, faces)
            else problem
        )
        run = run_path(solved, scene.load.path(), pace, scene.cycles, report, uncertainty=doubt)
        if not isinstance(run.failure, ConvergenceError):
            break
    if faces is not made:
        work[_CURED] += 1
    elif cured is not None:
        work[_KEPT] += 1
    if solved is not problem:
        run, solved = unfolded(run, faces), problem  # what the half has kept goes
    if datum > scene.profile.datum_length:
        run = from_datum(scene, run, scene.profile.datum_length / datum)
    watch.lap("load path")
    answer = _solution(scene, mesh, settings, scales, condensed, problem, run, watch)
    if run.failure is not None:
        raise type(run.failure)(str(run.failure), answer) from run.failure
    _check_room(answer, run)
    return answer


def require_solvable(scene: Scene, mesh: MeshSettings | None = None) -> None:
    """All that `solve` refuses before it makes a mesh of its own: half-planes by their loads, real
    bodies by the coarse run too.

    Raises
    ------
    InputError
        For a load path, supports or a face too narrow for the contact that `solve` refuses.
    ConvergenceError
        Where the coarse run does not converge.
    """
    _check_loads(scene)
    if scene.bodies.half_planes:
        return  # there is room for every contact
    settings = mesh or MeshSettings()
    with threadpool_limits(limits=1, user_api="blas"):
        scales = find_scales(scene, Counter())
    for name, shape, ratio in (
        ("lower", scene.bodies.lower, 1.0),
        ("upper", scene.bodies.upper, settings.upper_ratio),
    ):
        check(
            name,
            shape,
            scene.profile,
            surface_grading(settings, scales, scene.profile, ratio),
            settings,
        )


def _check_loads(scene: Scene) -> None:
    check_bulk_stress(scene)
    if scene.bodies.faces_are_true and not scene.profile.symmetric:
        raise InputError(
            "profile: symmetric = false goes with half-planes and blocks: pads and cylinders are"
            " meshed mirror-symmetric"
        )
    check_admissible(scene.load.path(), scene.friction.coefficient)
    check_supports(scene, sheared(scene))


class _Watch:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = clock.perf_counter()

    def lap(self, stage: str) -> None:
        now = clock.perf_counter()
        self.seconds[stage], self._last = now - self._last, now


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
    scene: Scene,
    mesh: MeshSettings,
    settings: SolverSettings,
    scales: Scales,
    faces: Interface,
    work: Counter[str],
) -> ContactProblem:
    interface = faces.scaled(scales.half_width, 1 / scales.modulus)
    # A stiffness of k E*/h per area is, node by node and scaled, k w/h: that of the layer, or the
    # weight of the trial tractions.
    stiffness = settings.normal_stiffness, settings.tangential_stiffness
    nodal = [k * interface.weights / mesh.edge_element_size for k in stiffness]
    penalty = settings.method == "penalty"
    layer = Layer(*((1 / k if penalty else np.zeros_like(k)) for k in nodal))
    height = initial_gap(scene, faces) * scales.modulus / scales.load
    return ContactProblem(
        interface,
        height,
        scene.friction.coefficient,
        layer,
        needs_shear(scene),
        settings.max_iterations,
        (1.0, 1.0) if penalty else (nodal[0], nodal[1]),
        scene.load.path().moment_given,
        work,
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
    scene: Scene,
    mesh: MeshSettings,
    settings: SolverSettings,
    scales: Scales,
    condensed: tuple[CondensedBody, CondensedBody],
    problem: ContactProblem,
    run: PathRun,
    watch: _Watch,
) -> FiniteElementSolution:
    arrays = answer_arrays(scene, problem, run, scales)
    uncertain = (
        float("nan")
        if run.failure is not None
        else _uncertainty(scene, mesh, settings, scales, run)
    )
    uncertain = (
        (uncertain + float(np.nan_to_num(abs(run.trend.left)))) * scales.load**2 / scales.modulus
    )
    states = tuple(run.states[index] for index in run.stored)
    audit = penalty_audit(scene, problem, states, arrays, scales)
    own: dict[str, Any] = {
        "bodies": (condensed[0].body, condensed[1].body),
        "condensed": condensed,
        "states": states,
        "weights": freeze(problem.interface.weights * scales.half_width),
        "normals": problem.interface.normals,
        "scales": scales,
        "penalty": audit,
        "largest_pressure_uncertainty": _peak_uncertainty(scene, mesh, settings, scales, arrays),
    }
    grading = condensed[0].body.grading
    tolerance = scene.tolerances.limit("dissipation") or 0.0
    of_mesh = _notes(scene, mesh, scales, run, arrays)
    of_bodies = bulk_stress_notes(scene, condensed, float(np.abs(arrays["tangential_load"]).max()))
    notes = (
        *([_NOTE_KEPT] if problem.work[_KEPT] and run.failure is None else []),
        *of_bodies,
        *of_mesh,
        *uncertainty_note(arrays["dissipation"], uncertain, tolerance, scales.dissipation),
    )
    return FiniteElementSolution(
        engine="halfplane_fe",
        scene=scene,
        record=record_of(run, scales, audit, notes),
        dissipation_uncertainty=uncertain,
        work=_work(scene, problem, run, condensed, watch.seconds),
        settings={
            "mesh": asdict(mesh),
            "solver": asdict(settings),
            "scales": asdict(scales),
            "dundurs": dundurs(scene.material)._asdict(),
            "element_size": grading.edge_size,
            "penalty": {} if audit.note() is None else asdict(audit),
            "surface": {f.name: getattr(grading, f.name) for f in fields(grading)},
        },
        versions=versions(),
        **arrays,
        **own,
    )


def _uncertainty(
    scene: Scene, mesh: MeshSettings, settings: SolverSettings, scales: Scales, run: PathRun
) -> float:
    """Of the last revolution's dissipation by mesh and steps, scaled: 0 where no shear can
    arise.
    """
    if not needs_shear(scene):
        return 0.0
    first, excess = (run.cycle_starts[-1], run.excess[-1]) if run.cycle_starts else (0, None)
    plain = mesh.order == 1 or settings.method == "penalty"
    coarse = scales.dissipation * scales.modulus / scales.load**2
    unit = 2 * scene.friction.coefficient**2  # A f^2 P^2
    # With bulk stress or tilt a cycle is compared with the coarse run's of the same number: they
    # only approach the steady state.
    found = float(
        (run.cycle_density[:COARSE_CYCLES] if scene.unsymmetric else run.cycle_density)[-1].sum()
    )
    scatter = None if excess is None or plain or scene.unsymmetric else excess.scatter / unit
    # Unlike bodies: the increments of the nodes that start to slide bend the pressure too, and
    # their bound counts whole.
    steps = (
        _BENT * run.column("bent")[first:].sum()
        if scatter is not None and shapes_alike(scene)
        else run.column("step_error")[first:].sum()
    )
    return float(steps) + unit * uncertainty(
        found / unit, abs(found - coarse) / unit, scales.element, mesh, scatter, plain
    )


def _peak_uncertainty(
    scene: Scene,
    mesh: MeshSettings,
    settings: SolverSettings,
    scales: Scales,
    arrays: Mapping[str, Any],
) -> float:
    """Of the largest pressure by the mesh [stress]; elements of the coarser side. NaN without
    contact.
    """
    pressure = arrays["pressure"]
    step, node = np.unravel_index(np.argmax(pressure), pressure.shape)
    value = float(pressure[step, node])
    to_edges = np.abs(arrays["contact_edges"][step] - arrays["x"][node])
    half_width = float(arrays["contact_half_width"][step])
    peak = Peak(value, abs(value - scales.largest_pressure), half_width, float(np.min(to_edges)))
    fine = surface_grading(mesh, scales, scene.profile, max(mesh.upper_ratio, 1.0))
    plain = mesh.order == 1 or settings.method == "penalty"
    coarse = scales.element * scales.half_width
    return peak_uncertainty(
        peak, scene.profile, coarse, fine, mesh, depth=least_depth(scene), plain=plain
    )


def _notes(
    scene: Scene, mesh: MeshSettings, scales: Scales, run: PathRun, arrays: Mapping[str, Any]
) -> tuple[str, ...]:
    """What the mesh does not resolve in the last revolution, and what of the path is left."""
    if run.failure is not None:
        return ()
    first = int(np.searchsorted(run.stored, run.cycle_starts[-1])) + 1 if run.cycle_starts else 1
    load, contact, stick = (
        arrays[name][first:] for name in ("normal_load", "contact_half_width", "stick_half_width")
    )
    unit = (
        2
        / contact_modulus(scene.material.lower, scene.material.upper)
        * (scene.friction.coefficient * np.max(load)) ** 2
    )
    work = float(arrays["dissipation"] / unit) if unit > 0 else 0.0
    coarser = mesh.edge_element_size * scales.half_width * max(mesh.upper_ratio, 1.0)
    of_mesh = resolution_notes(
        scene, load, contact, stick, coarser, mesh.order, work, needs_shear(scene)
    )
    return (*_drift_notes(run, scales), *_thinned_notes(run), *of_mesh)


def _thinned_notes(run: PathRun) -> Iterator[str]:
    """That not every increment is in the answer, and what is of all of them nevertheless."""
    if dropped := len(run.states) - len(run.stored):
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
    drift, unit, found = "", scales.load**2 / scales.modulus, run.trend
    if len(works) > 1 and works[-1] > 0:
        drift = (
            f"; its dissipation differs by {1 - works[-2] / works[-1]:+.1e} of itself from that of"
            " the one before"
        )
    if run.steady_from is None:
        yield (
            f"no revolution repeats: the last of {len(works)} ends {run.cycle_change[-1]:.1e} of"
            f" the largest nodal force away from its start (up to {REPEATS:g} counts as the"
            f" same){drift}; give the scene more cycles"
        )
    if np.isfinite(found.limit) and found.left and works[-1] > 0:
        yield (
            f"shakedown: the dissipation of the revolutions goes to {found.limit * unit:.6g},"
            f" {found.left / works[-1]:+.1e} of itself from that of revolution {len(works)}"
            f" ({found.kind} trend); this is in its uncertainty"
        )
    elif run.steady_from is not None and found.left and works[-1] > 0:
        yield (
            f"shakedown: revolution {len(works)} repeats but for {run.cycle_change[-1]:.1e} of the"
            f" largest nodal force{drift}; {found.left / works[-1]:.1e} of it count as uncertain,"
            " for no trend is clear yet"
        )
    if run.ratchets:
        before, after = (run.states[index].shift for index in (run.cycle_starts[-1], -1))
        yield (
            "ratcheting: each revolution moves the upper body by"
            f" {(after - before) * scales.load / scales.modulus:.3g} along x; the closed integral"
            " of Q dU holds the work of the mean Q on that way"
        )


def _work(
    scene: Scene,
    problem: ContactProblem,
    run: PathRun,
    condensed: tuple[CondensedBody, CondensedBody],
    seconds: Mapping[str, float],
) -> Work:
    like = condensed[0] is condensed[1]
    counts = {
        "bodies meshed": 1 if condensed[0].body is condensed[1].body else 2,
        "condensations": problem.work["condensations"],
        "degrees of freedom": int(condensed[0].diagnostics["degrees_of_freedom"]),
        "contact nodes": len(condensed[0].x),
        "steps solved": len(run.iterations),
        "sparse factorisations": problem.work["sparse factorisations"],
        **{name: int(count) for name, count in sorted(problem.work.items())},
    }
    skipped = {}
    if condensed[0].body is condensed[1].body:
        skipped["meshes"] = (1, "both bodies have one shape: meshed once, reflected")
    if like:
        skipped["condensations"] = (
            1,
            "the bodies are alike: the upper one is the lower one reflected",
        )
    if cached := problem.work[CACHED]:
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
        skipped["the mesh's part of N - T"] = (
            1,
            (
                "the contact did not converge without it"
                if problem.work[_KEPT]
                else (
                    "an end of a face or a base is within ten nodes: W is of first order in the"
                    " element"
                )
            ),
        )
    if problem.tangential and not problem.work["slip iterations"]:
        skipped["slip iterations"] = (len(run.iterations), "no node left stick")
    if run.steady_from is not None and run.steady_from + 1 < scene.cycles:
        skipped["revolutions"] = (
            scene.cycles - run.steady_from - 1,
            "the revolution before ended as it started",
        )
    if dropped := len(run.states) - len(run.stored):
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
