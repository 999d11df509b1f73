"""What a reader must know of an answer: sentences on mesh and path, and counts of work done and
skipped.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from halfplane_fe.answer import is_loaded_in_last_cycle
from halfplane_fe.answer_uncertainty import revolution_of
from halfplane_fe.condensed_bodies import CACHED
from halfplane_fe.contact import ContactProblem
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.interface import bulk_stress_notes
from halfplane_fe.resolution import resolution_notes
from halfplane_fe.run import LARGEST_CHANGE_OF_REPEAT, MOST_COMPLETE_STATES, PathRun
from halfplane_fe.scales import UNPLACED_EDGES, Scales, on_half
from halfplane_fe.task import Task
from halfplane_fe.uncertainty import uncertainty_note
from scenes import Scene, Work

# Counts of work: faces whose N - T and K lack what only the mesh makes of them, and runs repeated
# on the faces as they are.
CORRECTED_FACES = "interfaces without the mesh's part of N - T"
REPEATED_RUNS = "runs repeated with the mesh's part of N - T"
_NOTE_REPEATED = (
    "the contact did not converge on faces without the part of N - T and K that only the mesh"
    " makes. This is the answer of the faces as they are: where edges move, its dissipation errs by"
    " the first power of the element"
)
# for one release: the name meant the active set up to 0.3
_NOTE_RENAMED = (
    "method augmented_lagrangian: since 0.3.1 the augmented Lagrangian of Simo and Laursen, with"
    " multipliers that are updated. What had this name before is active_set, the default: the same"
    " answer, several times faster"
)


def notes_of_answer(
    task: Task,
    condensed_bodies: tuple[CondensedBody, CondensedBody],
    problem: ContactProblem,
    run: PathRun,
    arrays: Mapping[str, Any],
    dissipation_uncertainty: float,
) -> list[str]:
    """Sentences for the reader of a finite-element solution on what limits it: bulk stress, drift
    from cycle to cycle, creep, resolution of the mesh, uncertainty of the friction work W.

    Of a run that failed there are fewer: none on its cycles, creep and resolution.

    Parameters
    ----------
    task
        the scene, its mesh settings, solver settings, and the scales of its variables;
        `element_size` is that of the elements at the edges over the contact half-width
    condensed_bodies
        compliance of the lower and upper body, condensed to the nodes of their faces
    problem, run
        the contact problem with its counts of work, and its states along the load path; `failure`
        is what stopped the run, or None
    arrays
        fields and series of the solution by name, in the scene's units
    dissipation_uncertainty
        of the friction work W of the last cycle [energy / thickness]
    """
    scene = task.scene
    scales = task.scales
    notes = []
    # Runs repeated on the compliance as meshed, as the corrected one did not converge.
    # REPEATED_RUNS: name of the count of runs repeated on faces as they are meshed
    if problem.work_counts[REPEATED_RUNS] and run.failure is None:
        notes.append(_NOTE_REPEATED)
    largest_tangential_load = float(np.abs(arrays["tangential_load"]).max())
    notes += bulk_stress_notes(scene, condensed_bodies, largest_tangential_load)

    # Of a run that reached its end: drift of its cycles, instants left out, creep, resolution.
    if run.failure is None:
        notes += _drift_notes(run, scales)
        notes += _thinned_notes(run)
        notes += _creep_notes(scene, arrays)
        element_size = task.element_size * scales.half_width
        revolution = revolution_of(task, run, arrays)
        notes += resolution_notes(scene.profile, revolution, element_size, task.mesh)

    # Uncertainty of W against the tolerances of the scene; `scales.dissipation` is W on a coarse
    # mesh.
    notes += uncertainty_note(
        arrays["dissipation"], dissipation_uncertainty, scene.tolerances, scales.dissipation
    )
    if task.settings.method == "augmented_lagrangian":
        # sentence that this name had another meaning in earlier versions
        notes.append(_NOTE_RENAMED)
    return notes


def _creep_notes(scene: Scene, arrays: Mapping[str, Any]) -> Iterator[str]:
    """A sentence where the permanent stick zone of the last cycle is wider than the stick zone of
    some instant, by more than that instant's edges are uncertain.

    Nodes that slip by next to nothing (creep) count as permanently stuck. So an instant at which
    they slip has a narrower stick zone.

    Parameters
    ----------
    scene
        load path, with the period of its cycle
    arrays
        fields and series of the solution by name, in the scene's units
    """
    zone_ends = arrays["permanent_stick_edges"]  # (2,) x of its left and right end
    if np.isnan(zone_ends).any():
        return
    is_in_cycle = is_loaded_in_last_cycle(
        scene, arrays["time"], arrays["normal_load"]
    )  # (n_steps,)

    # Instants whose stick zone does not reach the ends of the permanent one. Left edges change
    # sign, so that "farther out" means "larger" at both edges.
    outwards = np.array([-1.0, 1.0])
    outward_edges = arrays["stick_edges"][is_in_cycle] * outwards
    farthest_edges = outward_edges + arrays["stick_edge_uncertainty"][is_in_cycle]
    # NaN edges of instants at which nothing sticks compare as False.
    reaches_ends = np.all(farthest_edges >= zone_ends * outwards, axis=1)
    n_narrower = int(np.sum(~reaches_ends))
    if not n_narrower:
        return

    # Range of slip of the nodes in the permanent stick zone.
    x = arrays["x"]
    slip_range = np.ptp(arrays["slip"][is_in_cycle], axis=0)
    largest_creep = slip_range[(x > zone_ends[0]) & (x < zone_ends[1])].max(initial=0.0)
    text_between_edges = "No node between them slips"
    if largest_creep:
        creep_share = largest_creep / float(slip_range.max())
        text_between_edges = (
            "What slips between them counts as stuck: it slips by"
            f" {creep_share:.1e} of the largest slip at most"
        )
    yield (
        f"the permanent stick zone, {zone_ends[0]:.6g} to {zone_ends[1]:.6g}, reaches beyond the"
        f" stick edges of {n_narrower} of {len(outward_edges)} instants. {text_between_edges}"
    )


def _thinned_notes(run: PathRun) -> Iterator[str]:
    """A sentence where a run along a long path was thinned out: how many instants the solution
    leaves out, and which of its values still rest on all of them.

    `run.states` are those at all instants, `run.stored_indices` the indices of those that keep
    pressure, shear and gap.
    """
    n_dropped = len(run.states) - len(run.stored_indices)
    if n_dropped:
        # MOST_COMPLETE_STATES: 4000
        yield (
            f"{n_dropped} of {len(run.states)} instants of this long path are left out of the"
            f" answer, its files and figures (at most {MOST_COMPLETE_STATES} are kept, the rows of"
            " the record first). The worst instant of a metric is one that was kept. W, W(x), the"
            " closed integral of Q dU, the permanent stick zone and the checks are of all of them"
        )


def _drift_notes(run: PathRun, scales: Scales) -> Iterator[str]:
    """Sentences on how the revolutions of a periodic load path differ from one another: no steady
    cycle, slow shakedown of the friction work W, ratcheting (U grows without end). None where no
    revolution was completed.

    `run` has W of each revolution, its trend over the revolutions, and how far each ends from the
    state that it began with; `scales` turn its scaled values into the scene's units.

    - `run.steady_from`: number of the first revolution that repeats; None where none does.
    - `run.ratchets`: whether each revolution moves the upper body by the same distance along x.
    """
    if not run.force_change_by_cycle:
        return
    works = [float(work.sum()) for work in run.nodal_work_by_cycle]  # W of each revolution, scaled
    last_work = works[-1]
    last_change = run.force_change_by_cycle[-1]  # over the largest nodal force
    work_unit = scales.load**2 / scales.modulus
    trend_of_work = run.trend  # limit that W tends to, and what is left of the way there
    change_to_limit = trend_of_work.change_to_limit
    drift_text = ""
    if len(works) > 1 and last_work > 0:
        drift_text = f"; W changed by {1 - works[-2] / last_work:+.1e}"

    # No steady cycle.
    if run.steady_from is None:
        # LARGEST_CHANGE_OF_REPEAT: 5e-4
        yield (
            f"no revolution repeats: the last of {len(works)} ends {last_change:.1e} of the largest"
            f" nodal force away from its start (up to {LARGEST_CHANGE_OF_REPEAT:g} counts as the"
            f" same){drift_text}; give the scene more cycles"
        )

    # Shakedown: towards a known limit, or without a clear trend.
    if np.isfinite(trend_of_work.limit) and change_to_limit and last_work > 0:
        yield (
            f"shakedown: W of the revolutions tends to {trend_of_work.limit * work_unit:.6g}"
            f" ({trend_of_work.kind} trend). That of revolution {len(works)} still differs from it"
            f" by {abs(change_to_limit) / last_work:.1e} of W, which is in the uncertainty"
        )
    elif run.steady_from is not None and change_to_limit and last_work > 0:
        yield (
            f"shakedown: revolution {len(works)} repeats to {last_change:.1e} of the largest nodal"
            f" force{drift_text}; no trend is clear, uncertainty"
            f" {change_to_limit / last_work:.1e}"
        )

    if run.ratchets:
        # change of the tangential displacement U over the last revolution, scaled
        shift_of_cycle = run.states[-1].shift - run.states[run.cycle_starts[-1]].shift
        distance = shift_of_cycle * scales.load / scales.modulus
        yield (
            f"ratcheting: each revolution moves the upper body by {distance:.3g} along x; the"
            " closed integral of Q dU holds the work of the mean Q on that way"
        )


def work_done(
    scene: Scene,
    problem: ContactProblem,
    run: PathRun,
    condensed_bodies: tuple[CondensedBody, CondensedBody],
    seconds: Mapping[str, float],
) -> Work:
    """Computing effort of a finite-element solution: counts of what was computed, counts and
    reasons of what was not needed, and seconds of each stage.

    Parameters
    ----------
    scene
        the contact, whose path may have more cycles than were computed
    problem, run
        the contact problem, with its counters, and its states along the load path
    condensed_bodies
        compliance of the lower and upper body, condensed to the nodes of their faces, with their
        meshes; where both have one shape, their mesh is one and the same
    seconds
        name of a stage -> its time [s]
    """
    lower_body, upper_body = condensed_bodies
    is_one_mesh = lower_body.body is upper_body.body
    counts = {
        "bodies meshed": 1 if is_one_mesh else 2,
        "condensations": problem.work_counts["condensations"],
        "degrees of freedom": int(lower_body.diagnostics["degrees_of_freedom"]),
        "contact nodes": len(lower_body.x),
        "steps solved": len(run.iterations),
        "sparse factorisations": problem.work_counts["sparse factorisations"],
        **{name: int(count) for name, count in sorted(problem.work_counts.items())},
    }
    # name of the work -> (how often it was skipped, why)
    skipped_work = _skipped_at_bodies(scene, problem, run, condensed_bodies)
    skipped_work |= _skipped_along_path(scene, problem, run)
    return Work(counts, skipped_work, dict(seconds))


def _skipped_at_bodies(
    scene: Scene,
    problem: ContactProblem,
    run: PathRun,
    condensed_bodies: tuple[CondensedBody, CondensedBody],
) -> dict[str, tuple[int, str]]:
    """Work that symmetry and the cache of condensed bodies saved, and the correction of the faces
    where it was not made: name of the work -> (how often it was skipped, why).

    The correction takes out of N - T and K what only the mesh puts there: N, T and K are the
    compliances of the face, normal, tangential and coupled.

    Parameters
    ----------
    scene
        the contact: bodies and loads
    problem
        the contact problem; its `work_counts` hold, under names that are module constants, how
        often a body came from the cache, the corrected faces were used, and a run was repeated
        without correction
    run
        its states along the load path, with the number of iterations of each increment
    condensed_bodies
        lower and upper body; one and the same where they are alike
    """
    lower_body, upper_body = condensed_bodies
    is_one_mesh = lower_body.body is upper_body.body
    skipped_work: dict[str, tuple[int, str]] = {}
    if is_one_mesh:
        skipped_work["meshes"] = (1, "both bodies have one shape: meshed once, reflected")
    if lower_body is upper_body:
        skipped_work["condensations"] = (
            1,
            "the bodies are alike: the upper one is the lower one reflected",
        )
    # CACHED: name of the count of bodies taken from the cache
    n_cached = problem.work_counts[CACHED]
    if n_cached:
        skipped_work["condensations, cached"] = (
            n_cached,
            "this process condensed the body before: taken from the cache",
        )
    if on_half(scene, problem.interface):
        skipped_work["contact nodes"] = (
            len(problem.interface.x) // 2,
            "p is even in x, q even or odd: solved on one half",
        )
    if not problem.has_shear:
        skipped_work["tangential problem"] = (len(run.iterations), "no shear can arise")
    # CORRECTED_FACES: name of the count of runs on faces without the mesh's error
    if not problem.work_counts[CORRECTED_FACES]:
        reason = (
            "an end of a face or a base is within ten nodes: W is of first order in the element"
        )
        # REPEATED_RUNS: name of the count of runs repeated on faces as they are meshed
        if problem.work_counts[REPEATED_RUNS]:
            reason = "the contact did not converge without it"
        skipped_work["the mesh's part of N - T"] = (1, reason)
    return skipped_work


def _skipped_along_path(
    scene: Scene, problem: ContactProblem, run: PathRun
) -> dict[str, tuple[int, str]]:
    """Work that the load path did not need: name of the work -> (how often it was skipped, why).

    Parameters
    ----------
    scene
        `cycles` is the largest number of load cycles
    problem
        the contact problem: whether it has shear, and counts of its work
    run
        number of iterations of each increment; number of the revolution that ended as it started
        (`steady_from`, None without one); states of all instants, and indices of those stored
    """
    skipped_work: dict[str, tuple[int, str]] = {}
    if problem.has_shear and not problem.work_counts["slip iterations"]:
        skipped_work["slip iterations"] = (len(run.iterations), "no node left stick")
    if run.steady_from is not None and run.steady_from + 1 < scene.cycles:
        skipped_work["revolutions"] = (
            scene.cycles - run.steady_from - 1,
            "the revolution before ended as it started",
        )
    n_dropped = len(run.states) - len(run.stored_indices)
    if n_dropped:
        skipped_work["instants"] = (
            n_dropped,
            f"stored at {len(run.stored_indices)} instants: more would take gigabytes",
        )
    # UNPLACED_EDGES: name of the count of instants, in the work of the coarse run
    n_without_edges = problem.work_counts[f"coarse {UNPLACED_EDGES}"]
    if n_without_edges:
        skipped_work["stick edges between nodes, coarse run"] = (
            n_without_edges,
            "no answer reads them at its instants",
        )
    return skipped_work
