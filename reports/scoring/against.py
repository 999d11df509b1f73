"""The result of another program against a reference: the same comparison, metrics and page as
between the two engines.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from reports.comparison import compare
from reports.comparison.datum import effects_between
from reports.comparison.laws import DERIVED, certificates, names_of_derived_fields
from reports.comparison.metrics import WHOLE_CYCLE
from reports.comparison.pairs import scales_of_reference
from reports.report import Report
from reports.scoring.mapping import Mapping
from reports.scoring.reading import SOLUTION_SUFFIX, read_result
from reports.scoring.solution import (
    reference_by_same_rule,
    solution_of_surface,
    theory_of_whole_path,
)
from reports.scoring.surface import SurfaceResult, surface_result
from scenes import ContactSolution, InputError, Scene, scene_of

Against = Literal["exact", "fe"]


def score(
    x: ArrayLike,
    p: ArrayLike,
    q: ArrayLike | None,
    *,
    scene: Scene | str | Path,
    time: ArrayLike | None = None,
    loads: tuple[ArrayLike, ArrayLike] | None = None,
    slip: ArrayLike | None = None,
    code: str = "",
    mapping: Mapping | None = None,
    against: Against = "exact",
    tolerances: dict[str, float] | None = None,
) -> Report:
    """Score tractions in arrays against a reference that is solved here, half-plane theory at the
    same points and instants. The report states likely causes of the difference.

    Parameters
    ----------
    x
        (n_points,) positions on the surface, 0 in the middle of the contact [length]
    p, q
        (n_steps, n_points), or (n_points,) of a single instant [stress]; p > 0 in compression,
        q along +x on the lower body. q None: the pressure is scored alone
    scene
        the scene whose contact problem the tractions solve, or its name or file
    time
        (n_steps,) times of the scene's load path; left out, the instants are found by `loads`, else
        by the integrals of p and q over x
    loads
        (P, Q), (n_steps,) each [force / thickness]
    slip
        like p [length], upper body relative to lower; without it slip and dissipation are not
        scored
    code
        name of the program that computed the tractions, for the page
    mapping
        units and signs of the arrays; where it states none they are guessed, and the report names
        them in `guesses`
    against
        the reference: "exact" half-plane theory, "fe" finite elements of this program
    tolerances
        key of a metric -> largest |E| that passes, E the difference; infinite: it is not judged

    Raises
    ------
    InputError
        One sentence: wrong shapes, numbers that are not finite, loads that are not the scene's.

    Examples
    --------
    >>> import numpy as np
    >>> import semi_analytic
    >>> from scenes import load_scene
    >>> x = np.linspace(-1.2, 1.2, 241)
    >>> exact = semi_analytic.solve(load_scene("cattaneo-mindlin"), x=x, time=[1.5])
    >>> report = score(
    ...     x,
    ...     1.01 * exact.pressure[0],
    ...     exact.shear[0],
    ...     scene="cattaneo-mindlin",
    ...     time=1.5,
    ...     code="mine",
    ... )
    >>> round(report.metric("peak_pressure").value, 9), report.metric("dissipation").value is None
    (0.01, True)

    # notation: P normal load, p pressure, Q tangential load, q shear
    """
    valid_scene = scene_of(scene)
    fields: dict[str, ArrayLike | None] = {"pressure": p, "shear": q, "slip": slip}
    series = {
        "time": time,
        "normal_load": loads[0] if loads else None,
        "tangential_load": loads[1] if loads else None,
    }
    # the arrays checked, points sorted by x
    result = surface_result(code or "the arrays", code, x, fields, series)
    report = score_surface(
        result, mapping or Mapping(), valid_scene, against=against, tolerances=tolerances
    )
    # with likely causes of the difference
    return report_with_diagnoses(report)


def score_file(
    path: Path,
    mapping: Mapping,
    scene: Scene,
    *,
    against: Against = "exact",
    tolerances: dict[str, float] | None = None,
) -> Report:
    """Score a result in a file: compare it with a reference that is solved here. Likely causes of
    the difference are not looked for.

    A NetCDF file of this program is read as it is. For a file of another program `mapping` states
    names of columns, units and signs. The reference is half-plane theory for `against` = "exact",
    finite elements for "fe". `tolerances` holds the largest difference that passes, by key of the
    metric.
    """
    # a NetCDF file, .nc
    is_of_this_program = path.suffix.lower() == SOLUTION_SUFFIX and path.is_file()
    if is_of_this_program:
        return score_solution(
            # a solution with all fields; no guesses, no theory of the whole path yet
            stored_solution(path, scene),
            (),
            None,
            against=against,
            with_polygon=True,
            tolerances=tolerances,
        )
    states_times = mapping.times is not None or mapping.columns.time is not None
    return score_surface(
        read_result(path, mapping),
        mapping,
        scene,
        against=against,
        sure_of_times=states_times,
        tolerances=tolerances,
    )


def stored_solution(path: Path, scene: Scene) -> ContactSolution:
    """The solution in a NetCDF file that this program wrote. InputError for another file, and for a
    solution of a scene with another material, profile, friction or load.
    """
    try:
        solution = ContactSolution.load(path)
    except (OSError, KeyError, ValueError) as fault:
        raise InputError(
            f"{path}: this is no solution that halfplane wrote ({type(fault).__name__}: {fault})"
        ) from fault
    for key in ("material", "profile", "friction", "load"):
        stored_value = getattr(solution.scene, key)
        scene_value = getattr(scene, key)
        if stored_value != scene_value:
            raise InputError(
                f"{path}: it answers another scene: {key} is {stored_value!r} there and"
                f" {scene_value!r} in {scene.name}"
            )
    return solution


def score_surface(
    result: SurfaceResult,
    mapping: Mapping,
    scene: Scene,
    *,
    against: Against = "exact",
    sure_of_times: bool = True,
    tolerances: dict[str, float] | None = None,
) -> Report:
    """Score tractions on a contact surface that another program computed: compare them with a
    reference that is solved here. Likely causes of the difference are not looked for.

    Units and signs are guessed where `mapping` states none. With `sure_of_times` the result's times
    are those of the scene's load path. Without it the instants may be found by the loads instead.
    `against` is the reference: "exact" half-plane theory, "fe" finite elements. `tolerances` holds
    the largest difference that passes, by key of the metric.
    """
    theory_of_path = theory_of_whole_path(scene)
    # the result as a solution, and sentences on what was guessed
    solution, guesses = solution_of_surface(
        result, mapping, theory_of_path, sure_of_times=sure_of_times
    )
    return score_solution(solution, guesses, theory_of_path, against=against, tolerances=tolerances)


def score_solution(
    solution: ContactSolution,
    guesses: tuple[str, ...],
    theory_of_path: ContactSolution | None,
    *,
    against: Against = "exact",
    with_polygon: bool = False,
    tolerances: dict[str, float] | None = None,
) -> Report:
    """Score a solution: compare it with a reference that is solved here. Likely causes of the
    difference are not looked for.

    Parameters
    ----------
    guesses
        sentences on what was guessed when the solution was read
    theory_of_path
        half-plane theory on the whole load path of the scene; None: it is solved here, if the
        solution comes from another program
    against
        the reference: "exact" half-plane theory, "fe" finite elements
    with_polygon
        whether theory is solved on the straight steps between the instants as well, which shows the
        error of the load steps
    tolerances
        key of a metric -> largest |E| that passes, E the difference

    Raises
    ------
    InputError
        Where no point of the result lies in the reference's contact at any of its instants.

    # notation: a_ref half-width of contact of the reference
    """
    reference = _reference_solution(solution, against)
    _require_points_in_contact(solution, reference)
    theory_on_polygon = None
    # only finite elements of this program state each of their load steps
    if with_polygon and against == "exact" and _states_increments_of_solver(solution):
        from reports.comparison.budget import theory_on_steps

        theory_on_polygon = theory_on_steps(solution)
    # fields of another program that were derived from its other fields
    if theory_of_path is None and names_of_derived_fields(solution):
        theory_of_path = theory_of_whole_path(solution.scene)
    # States, edges and dissipation that another program does not state were found from its
    # tractions by a rule. The metrics are those of the reference by the same rule.
    reference_by_rule = reference
    notes_on_rule: tuple[str, ...] = ()
    if theory_of_path is not None:
        # a_ref, the half-width that lengths are divided by
        half_width = scales_of_reference(theory_of_path).half_width
        reference_by_rule, notes_on_rule = reference_by_same_rule(reference, solution, half_width)
    # Without a rule that both follow the reference stands for itself.
    plain_reference = None if reference_by_rule is reference else reference
    # metrics; plain_reference: the reference with its own states and edges
    comparison = compare(
        reference_by_rule,
        solution,
        polygon_reference=theory_on_polygon,
        scales_from=theory_of_path,
        plain_reference=plain_reference,
        tolerances=tolerances,
        # displacements of finite bodies count from their supports, those of theory do not
        effects=effects_between(reference, solution),
    )
    comparison = replace(
        comparison,
        reference=reference,
        reference_certificates=certificates(reference),
        notes=(*notes_on_rule, *comparison.notes),
    )
    return Report(comparison, guesses=guesses)


def _reference_solution(solution: ContactSolution, against: Against) -> ContactSolution:
    """The reference for a solution: its scene solved by half-plane theory at the same points and
    instants (`against` = "exact"), or by finite elements ("fe"). Where the solution states that it
    has no whole cycle, the reference states so too.
    """
    if against == "fe":
        import halfplane_fe

        reference: ContactSolution = halfplane_fe.solve(solution.scene)
    else:
        import semi_analytic

        reference = semi_analytic.solve(solution.scene, x=solution.x, time=solution.time)
    # name of what is missing -> (number of instants, reason)
    missing_fields = dict(reference.work.skipped)
    if WHOLE_CYCLE in solution.work.skipped:
        missing_fields[WHOLE_CYCLE] = solution.work.skipped[WHOLE_CYCLE]
    return replace(reference, work=replace(reference.work, skipped=missing_fields))


def _states_increments_of_solver(solution: ContactSolution) -> bool:
    """Whether the instants of a solution are the load increments of our finite elements: other
    answers take no steps, or were read from a file of another program.
    """
    return solution.engine == "halfplane_fe" and DERIVED not in solution.settings


def _require_points_in_contact(solution: ContactSolution, reference: ContactSolution) -> None:
    """InputError where no point of a solution with pressure lies in the reference's contact at any
    of its instants: the points lie beside it, or the reference has no contact at these times.
    """
    edges = np.nan_to_num(reference.contact_edges)
    left_edges = np.interp(solution.time, reference.time, edges[:, 0])
    right_edges = np.interp(solution.time, reference.time, edges[:, 1])
    lies_in_contact = (solution.x > left_edges[:, None]) & (solution.x < right_edges[:, None])
    if np.any(lies_in_contact) or not solution.pressure.any():
        return
    source = solution.settings.get("source", solution.engine)
    if np.all(left_edges >= right_edges):
        first_time, last_time = solution.time[[0, -1]]
        raise InputError(
            f"{source}: it has pressure at times {first_time:.6g} to {last_time:.6g}, where the"
            " scene has no contact: state the scene's times of its instants, by a column or by"
            " times of a mapping"
        )
    raise InputError(
        f"{source}: none of its points lies in the contact: they go from x = {solution.x[0]:.6g} to"
        f" {solution.x[-1]:.6g}, the contact from {left_edges.min():.6g} to"
        f" {right_edges.max():.6g}; state its x at the middle of the contact by x_offset of a"
        " mapping, in the scene's length"
    )


def report_with_diagnoses(report: Report) -> Report:
    """`report` with the likely causes of its difference, and where it has any, the steps of the
    evidence for them.
    """
    from reports.scoring.diagnosis import diagnose
    from reports.scoring.evidence import evidence_steps

    diagnoses = diagnose(report.comparison)
    steps = evidence_steps(report.comparison) if diagnoses else ()
    return replace(report, diagnoses=diagnoses, evidence=steps)
