"""A foreign result against a reference: the same comparison, metrics and page as between the two
engines.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from reports.comparison import compare
from reports.comparison.datum import effects_between
from reports.comparison.dimensionless import scales
from reports.comparison.laws import DERIVED, certificates, derived
from reports.comparison.metrics import WHOLE_CYCLE
from reports.report import Report
from reports.scoring.mapping import Mapping
from reports.scoring.reading import OWN, read
from reports.scoring.solution import by_same_rule, contact_solution, whole_path
from reports.scoring.surface import SurfaceResult, surface_result
from scenes import ContactSolution, InputError, Scene, load_scene
from scenes.frozen import validated

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
    """Score tractions on plain arrays against half-plane theory at their own points and instants;
    the report has likely causes of the difference.

    Parameters
    ----------
    x
        (n_points,) places on the surface, 0 in the middle of the contact [length]
    p, q
        (n_steps, n_points), or (n_points,) of a single instant [stress]; p > 0 in compression,
        q along +x on the lower body. q None: the pressure is scored alone
    scene
        the question, or its name or file
    time
        (n_steps,) times of the scene's load path; left out, `loads` tell the instants, else the
        integrals of p and q
    loads
        (P, Q), (n_steps,) each [force / thickness]
    slip
        like p [length], upper over lower; only with it has the result slip and dissipation
    code
        what computed it, for the page
    mapping
        units and signs for certain, which are guessed, and named in `guesses`, without
    against
        "exact" for half-plane theory, "fe" for the project's finite elements
    tolerances
        key of a metric -> largest |E| admitted; infinite: it is not judged

    Raises
    ------
    InputError
        One sentence: shapes, numbers that are none, a history that is not the scene's.

    Examples
    --------
    >>> import numpy as np
    >>> import semi_analytic
    >>> x = np.linspace(-1.2, 1.2, 241)
    >>> exact = semi_analytic.solve(load_scene("cattaneo-mindlin"), x=x, time=[1.5])
    >>> found = score(
    ...     x,
    ...     1.01 * exact.pressure[0],
    ...     exact.shear[0],
    ...     scene="cattaneo-mindlin",
    ...     time=1.5,
    ...     code="mine",
    ... )
    >>> round(found.metric("peak_pressure").value, 9), found.metric("dissipation").value is None
    (0.01, True)
    """
    scene_asked = validated(scene, Scene) if isinstance(scene, Scene) else load_scene(scene)
    fields: dict[str, ArrayLike | None] = {"pressure": p, "shear": q, "slip": slip}
    series = {
        "time": time,
        "normal_load": loads[0] if loads else None,
        "tangential_load": loads[1] if loads else None,
    }
    result = surface_result(code or "the arrays", code, x, fields, series)
    return diagnosed(
        score_surface(
            result, mapping or Mapping(), scene_asked, against=against, tolerances=tolerances
        )
    )


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

    A NetCDF file of this program is read as it is; for any other `mapping` states names of columns,
    units and signs. `against` is "exact" for half-plane theory, "fe" for finite elements;
    `tolerances` are limits by metric.
    """
    if path.suffix.lower() == OWN and path.is_file():
        return score_solution(
            own_solution(path, scene),
            (),
            None,
            against=against,
            polygon=True,
            tolerances=tolerances,
        )
    sure = mapping.times is not None or mapping.columns.time is not None
    return score_surface(
        read(path, mapping),
        mapping,
        scene,
        against=against,
        sure_of_times=sure,
        tolerances=tolerances,
    )


def own_solution(path: Path, scene: Scene) -> ContactSolution:
    """The solution in a NetCDF file of this program. InputError for another file, and for one that
    answers another scene.
    """
    try:
        solution = ContactSolution.load(path)
    except (OSError, KeyError, ValueError) as reason:
        raise InputError(
            f"{path}: this is no solution that halfplane wrote ({type(reason).__name__}: {reason})"
        ) from reason
    for part in ("material", "profile", "friction", "load"):
        solved_part = getattr(solution.scene, part)
        scene_part = getattr(scene, part)
        if solved_part != scene_part:
            raise InputError(
                f"{path}: it answers another scene: {part} is {solved_part!r} there and"
                f" {scene_part!r} in {scene.name}"
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
    """Score a result that another program computed, as a reader of files returned it: compare it
    with a reference that is solved here. Likely causes of the difference are not looked for.

    Units and signs are guessed where `mapping` states none. `sure_of_times` says that the result's
    times are those of the scene's load path; else they may be given up for the loads.
    """
    path_solution = whole_path(scene)
    solution, guesses = contact_solution(
        result, mapping, path_solution, sure_of_times=sure_of_times
    )
    return score_solution(solution, guesses, path_solution, against=against, tolerances=tolerances)


def score_solution(
    solution: ContactSolution,
    guesses: tuple[str, ...],
    theory_of_path: ContactSolution | None,
    *,
    against: Against = "exact",
    polygon: bool = False,
    tolerances: dict[str, float] | None = None,
) -> Report:
    """Score a solution: compare it with a reference that is solved here. Likely causes of the
    difference are not looked for.

    Parameters
    ----------
    guesses
        sentences on what was guessed when the solution was read
    theory_of_path
        theory on the whole path of the scene; with None it is solved where the solution comes from
        another program
    against
        "exact" for half-plane theory as reference, "fe" for finite elements
    polygon
        whether theory is solved on the straight steps between the instants as well, which shows the
        error of the load steps

    Raises
    ------
    InputError
        Where no point of the result lies in the reference's contact at any of its instants.
    """
    reference = _reference_for(solution, against)
    _refuse_beside(solution, reference)
    theory_on_polygon = None
    if polygon and against == "exact" and _states_increments_of_solver(solution):
        from reports.comparison.budget import theory_on_steps

        theory_on_polygon = theory_on_steps(solution)
    if theory_of_path is None and derived(solution):
        theory_of_path = whole_path(solution.scene)
    reference_by_rule = reference
    sentences: tuple[str, ...] = ()
    if theory_of_path is not None:
        half_width = scales(theory_of_path).half_width
        reference_by_rule, sentences = by_same_rule(reference, solution, half_width)
    # Without a rule that both follow the reference stands for itself.
    plain_reference = None if reference_by_rule is reference else reference
    comparison = compare(
        reference_by_rule,
        solution,
        polygon_reference=theory_on_polygon,
        scales_from=theory_of_path,
        plain_reference=plain_reference,
        tolerances=tolerances,
        effects=effects_between(reference, solution),
    )
    comparison = replace(
        comparison,
        reference=reference,
        reference_certificates=certificates(reference),
        notes=(*sentences, *comparison.notes),
    )
    return Report(comparison, guesses=guesses)


def _reference_for(solution: ContactSolution, against: Against) -> ContactSolution:
    """The scene of a solution solved by half-plane theory at the same points and instants
    ("exact"), or by the finite elements ("fe"). Where the solution has no whole cycle, the
    reference states that it lacks one too.
    """
    if against == "fe":
        import halfplane_fe

        reference: ContactSolution = halfplane_fe.solve(solution.scene)
    else:
        import semi_analytic

        reference = semi_analytic.solve(solution.scene, x=solution.x, time=solution.time)
    skipped = dict(reference.work.skipped)
    if WHOLE_CYCLE in solution.work.skipped:
        skipped[WHOLE_CYCLE] = solution.work.skipped[WHOLE_CYCLE]
    return replace(reference, work=replace(reference.work, skipped=skipped))


def _states_increments_of_solver(solution: ContactSolution) -> bool:
    """Whether the instants of a solution are the load increments of our finite elements: other
    answers take no steps, or were read from a file of another program.
    """
    return solution.engine == "halfplane_fe" and DERIVED not in solution.settings


def _refuse_beside(solution: ContactSolution, reference: ContactSolution) -> None:
    """InputError where no point of a result can be judged: all lie outside the reference's contact,
    or its instants have none.
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


def diagnosed(report: Report) -> Report:
    """`report` with the likely faults of its result, and what its rows show where it has any."""
    from reports.scoring.diagnosis import diagnose
    from reports.scoring.evidence import evidence

    diagnoses = diagnose(report.comparison)
    steps = evidence(report.comparison) if diagnoses else ()
    return replace(report, diagnoses=diagnoses, evidence=steps)
