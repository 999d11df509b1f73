"""`solve`: from a scene to a ContactSolution, by the first of these methods that its scene admits.

Prescribed displacements: `answer_of_rig`. Finite bodies, `effects`: `corrected`. One memory curve:
`answer_by_memory`, exact. The steady cycle alone, by one memory curve or with loads in phase:
`answer_by_memory` and `answer_in_phase`, exact. All else: `answer_on_grids`. The question and the
record are made in `answer`.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from weakref import WeakSet

import numpy as np
from numpy.typing import ArrayLike

from scenes import BodyEffects, ContactSolution, InputError, Scene, scene_of
from semi_analytic.answer import (
    FIELDS,
    STEADY_FIELDS,
    Cycles,
    Findings,
    Question,
    checked_fields,
    checked_numbers,
    solution_of,
)
from semi_analytic.answer_by_memory import findings_by_memory
from semi_analytic.bulk_and_tilt import one_curve, path_loads_and_contact, steady_curve

# The C library of Linux gives every array of more than 128 kB fresh memory, page by page, which
# takes a fifth of the time of all fields; once a larger block was freed it uses memory again for
# arrays up to the size of that. No page of this block is ever touched.
_REUSED_ARRAYS = 24 * 2**20  # bytes
with suppress(MemoryError):
    bytes(_REUSED_ARRAYS)

answers_at_default_points: WeakSet[ContactSolution] = WeakSet()
"""Answers with all fields at the points and instants that theory takes by itself, as long as they
exist.
"""


def solve(
    scene: Scene | str | Path,
    x: ArrayLike | None = None,
    time: ArrayLike | None = None,
    *,
    cycles: Cycles = "all",
    fields: str | Iterable[str] = FIELDS,
    straight_steps: bool = False,
    effects: BodyEffects | None = None,
) -> ContactSolution:
    """Half-plane solution of a scene, exact to round-off at every point and instant asked for:
    loads, edges of contact and of stick, tractions, slip and friction work.

    Bulk stress and tilt are exact where the memory of friction is one curve, the tangential force
    locked in up to each load (`bulk_and_tilt.one_curve`); elsewhere they are solved on grids. With
    them the loop is that of Q over the tangential displacement U minus that of the moment of the
    shear, m_q, over the bulk strain. Edges need not be symmetric then.

    Parameters
    ----------
    scene
        a scene, or the name of one in the library, or a scene file
    x
        (n_points,) contact points, or one [length]; 200 across the largest contact and a little
        beyond if None
    time
        (n_instants,) instants, sorted or not, or one; about 400 a cycle, all events among them, if
        None
    cycles
        "all": the initial loading and every cycle up to the first steady one. "steady": the steady
        cycle alone. Where bulk stress and tilt are constant in it, fields that do not depend on
        the initial loading are then found without grids. No effect where `time` is given
    fields
        a name out of `FIELDS`, or several; the others come back as NaN (state: open) and are
        counted in `work.skipped`. Without "loop_work" the closed integral of Q dU is evaluated
        only where the error of the dissipation needs it
    straight_steps
        follow straight lines between the given times (ascending) instead of the scene's path:
        the polygon that a step-by-step solver saw, so that its step error can be told apart
    effects
        what finite bodies add to half-planes, `halfplane_fe.body_effects(scene)`: theory then
        takes the curvatures that follow the loads and both compliances of the bodies. Tilt
        and bulk strain of the bodies are in the dissipation of a parabola's cycles, to the
        second order, or left out; a note says which, and how large they are. Numbers that are
        all 0 give the solution of half-planes

    Returns
    -------
    ContactSolution
        Its dissipations are those of the last whole cycle within `time`; where `time` holds
        none, or is not given, those of the steady cycle (of cycle number `scene.cycles` if none
        is steady before). Cycles after the steady one are looked up, not solved.

        A measured path of more than 1,000 rows is answered at every row where no `time` is given,
        at about 400 of them with pointwise fields. A million rows take some seconds, and memory
        for the rows asked for. W(x), the friction work per area, at 200 points takes five seconds
        for a parabola, and minutes for a tabulated profile. Leave "dissipation_density" out
        of `fields` where it is not wanted.

    Raises
    ------
    InputError
        - for a scene that does not pass its own check;
        - for an unknown field, and for a time outside the path;
        - for a profile that this engine does not know;
        - for bulk stress or tilt under which an increment on grids does not converge.
    InadmissibleLoadError
        For gross sliding or separation anywhere in the path, with the instant and the loads.

    Examples
    --------
    >>> import math
    >>> solution = solve("hertz-normal", x=0.0, time=1.0, fields="pressure")
    >>> round(
    ...     solution.pressure.item() / (2 * 90.62286500739786 / math.pi), 12
    ... )  # 2 P/(pi a) with a = 1
    1.0
    """
    if effects is not None:
        from semi_analytic.body_numbers import (  # noqa: PLC0415 - for finite bodies alone
            checked_effects,
        )

        effects = checked_effects(effects)
    question = Question(
        scene=scene_of(scene),
        fields=checked_fields(fields, cycles),
        x=checked_numbers(x, "x"),
        time=checked_numbers(time, "time"),
        cycles=cycles,
        straight_steps=straight_steps,
        effects=effects,
    )
    solution = solution_of(question, _findings(question))
    if question.is_default:
        answers_at_default_points.add(solution)
    return solution


def _findings(question: Question) -> Findings:
    """Values, stated errors and notes of half-plane theory for a question, by the first of these
    methods that is valid for its scene:

    1. prescribed displacements of a rig;
    2. finite bodies, `effects` of the question;
    3. one memory curve, of scenes without bulk stress, tilt or unequal sides;
    4. one memory curve, of other scenes (`one_curve`);
    5. the steady cycle without grids, if the question wants it alone, and only STEADY_FIELDS, those
       that do not depend on how the steady cycle was reached;
    6. a numerical solution on grids.

    A memory curve is the tangential force, or the bulk strain, locked in up to each load.

    The question holds the scene, the names of the wanted `fields`, and `effects`, what finite
    bodies add (None: nothing). With `straight_steps` it wants straight steps in place of the
    scene's own path. `wants_last_cycle_alone`: no times are given, and `cycles` is "steady".

    Raises
    ------
    InputError
        For straight steps without one memory curve.
    """
    scene = question.scene
    # a displacement is prescribed
    if scene.load.is_driven:
        from semi_analytic.answer_of_rig import findings_of_rig  # noqa: PLC0415 - rigs

        return findings_of_rig(question)
    if question.effects is not None:
        from semi_analytic.corrected import findings_with_effects  # noqa: PLC0415 - finite bodies

        return findings_with_effects(question)
    # neither bulk stress nor tilt, nor unequal sides
    if not scene.unsymmetric:
        return findings_by_memory(question, None)
    # tilted contact and path with one memory curve, None if there is no such curve
    contact_and_path = one_curve(scene)
    if contact_and_path is not None:
        return findings_by_memory(question, contact_and_path)
    if question.straight_steps:
        raise InputError(
            "straight_steps: without one memory curve half-plane theory takes the scene's own path;"
            " leave it out"
        )
    if question.wants_last_cycle_alone and question.fields <= STEADY_FIELDS:
        # None where this cycle cannot be solved without grids
        findings_of_cycle = _findings_of_steady_cycle(question)
        if findings_of_cycle is not None:
            return findings_of_cycle
    return _findings_on_grids(question)


def _findings_on_grids(question: Question) -> Findings:
    """Values, stated errors and notes for a question by a numerical solution on grids of points in
    the contact, for scenes without a single memory curve.

    A memory curve is the tangential force, or the bulk strain, locked in up to each load.

    If the path reaches a steady cycle, its friction work is taken from a method without grids
    where one holds. `path_on_grids.steady_from` is the index of the first steady cycle, None
    without one. WORK_FIELDS are the fields of friction work.
    """
    from semi_analytic.answer_on_grids import (  # noqa: PLC0415 - for other memories alone
        WORK_FIELDS,
        GridAnswer,
    )

    # the load path followed on grids, at its points x
    grid_answer = GridAnswer(question)
    fields_of_work = question.fields & (WORK_FIELDS | {"loop_work"})
    # friction work without grids, None where there is none
    findings_without_grids = None
    if grid_answer.path_on_grids.steady_from is not None and fields_of_work:
        findings_without_grids = _findings_of_steady_cycle(
            replace(question, fields=fields_of_work, x=grid_answer.x, time=None, cycles="steady")
        )
    return grid_answer.findings(findings_without_grids)


def _findings_of_steady_cycle(question: Question) -> Findings | None:
    """Values, stated errors and notes for the steady cycle of a question, without following its
    initial loading; None where neither one memory curve holds in the cycle nor loads are in phase.

    A memory curve is the tangential force, or the bulk strain, locked in up to each load. Values
    that depend on how the steady cycle was reached, like the moment of the shear, are NaN.
    `skipped` states what was not computed.
    """
    scene = question.scene
    # contact and loads of the cycle, None without one curve
    cycle_with_one_curve = steady_curve(scene)
    if cycle_with_one_curve is not None:
        method_name = "one memory curve"
        findings = findings_by_memory(question, cycle_with_one_curve)
    else:
        from semi_analytic.answer_in_phase import findings_in_phase  # noqa: PLC0415
        from semi_analytic.loops_in_phase import strokes_in_phase  # noqa: PLC0415

        # the forward and the reverse stroke, where loads are in phase; else None
        strokes = strokes_in_phase(scene)
        if strokes is None:
            return None
        method_name = "quadratures of loads in phase"
        findings = findings_in_phase(question, strokes)
    note = (
        f"the steady cycle by {method_name}; the initial loading has another memory and was not"
        " followed: the number of cycles until then and the moment of the shear are not known,"
        ' `cycles="all"` finds them on grids'
    )
    n_loading_segments = len(scene.load.path().initial_loading)
    unknown_values = np.full(len(findings.time), np.nan)
    return replace(
        findings,
        values={**findings.values, "shear_moment": unknown_values},
        termination="steady",
        message="the steady cycle alone: it does not depend on the initial loading",
        notes=(*findings.notes, note),
        skipped={
            **findings.skipped,
            "initial loading": (n_loading_segments, "the steady cycle does not depend on it"),
        },
    )


def require_followable(scene: Scene) -> None:
    """Check that half-plane theory can solve a scene with bulk stress, tilt or unequal sides,
    without solving it: returns nothing, or raises.

    Raises
    ------
    InputError
        For a profile that theory does not know with bulk stress, tilt or unequal sides, and for a
        contact that leaves the profile.
    """
    if one_curve(scene) is None:
        from semi_analytic.grid import contact_edges_along  # noqa: PLC0415 - other memories

        contact_edges_along(*path_loads_and_contact(scene))  # for its InputError
