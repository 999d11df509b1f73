"""From a foreign result to a ContactSolution: units and signs that can't be, place on the load
path, states, edges, what it lacks.

Each guess follows from the scales of the scene and is a sentence. What is worked out of a result's
fields (states, edges, dissipation) is worked out of the reference's by the same rule, whose error
drops out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.comparison.isolated import without_spikes
from reports.comparison.laws import DERIVED, names_of_derived_fields
from reports.comparison.metrics import WHOLE_CYCLE, reason_by_missing_field
from reports.scoring.history import History, history_of_result, resultants
from reports.scoring.mapping import Mapping
from reports.scoring.surface import LEAST_TOUCHING_SHARE, SurfaceResult
from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    ContactSolution,
    InputError,
    Record,
    Scene,
    Work,
    read_only_copy,
)
from scenes.array_types import Array
from scenes.solution import last_whole_cycle

Mask = NDArray[np.bool_]

# A value of the result over that of theory may lie between these and be right: a frame near
# unloading, a coarse mesh, a wrong body. They are less than a factor of 1000 apart, so that at most
# one unit factor brings a value between them.
_LEAST_RATIO_TO_THEORY = 0.03
_LARGEST_RATIO_TO_THEORY = 10.0
_UNIT_FACTORS = (1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9)
# Of the half-width: a contact whose middle is farther from x = 0 was measured from elsewhere.
_LARGEST_OFFSET_SHARE = 0.5
_NOT_IN_RESULT = "not in the result"
# Instants of a cycle below which the work of friction by the trapezoidal rule means nothing.
_FEWEST_INSTANTS = 8
# A point slips where |q| is f p minus this share of it, and, where there is a slip, that has moved
# by more than the second share of the largest movement of the instant. f p - |q| at the end of a
# stick zone goes like the root of the distance: one per cent of f p is a ten-thousandth of a.
_SHARE_BELOW_LIMIT = 0.01
_LEAST_SHARE_OF_MOVEMENT = 1e-3
# Outermost points in contact that a parabola of p^2 leaves out, points behind them that it takes at
# most and at least, relative residual above which p^2 is no parabola there, spacings by which its
# zero may differ from that of the straight line. Farther in than the last share of the contact two
# terms of a power series are too few: flat-rounded-paper erred by 0.005 a at 0.11.
_N_POINTS_LEFT_OUT = 3
_MOST_FITTED_POINTS = 12
_FEWEST_FITTED_POINTS = 6
_LARGEST_RELATIVE_RESIDUAL = 0.005
_LARGEST_DIFFERENCE_IN_SPACINGS = 0.4
_LARGEST_DEPTH_SHARE = 0.05
# An instant at which no point of the contact moves faster than this share of the largest rate of
# all is at rest: where slip turns, it is the digits of the slip that tell who moves.
_LEAST_SHARE_OF_SPEED = 0.02
# Error of a stick edge of the reference by the rule, over a_ref, at most: it is larger only where
# slip has just turned and the tractions don't show it yet.
_LARGEST_STICK_ERROR_SHARE = 0.05


def solution_of_surface(
    surface: SurfaceResult, mapping: Mapping, theory: ContactSolution, *, sure_of_times: bool = True
) -> tuple[ContactSolution, tuple[str, ...]]:
    """Turn an external result (`surface`: tractions, and slip, times and loads or None) into a
    solution that can be compared with theory. With it come sentences on what was guessed, and on
    signs that look wrong.

    Nothing is filled in: what the result does not hold is NaN, listed as skipped with a reason, and
    left out of the comparison. States (open, stick, slip) and edges of contact and stick are found
    from its tractions and slip. So is the dissipation, where a whole cycle of at least 8 instants
    has shear and slip.

    Parameters
    ----------
    mapping
        stated units, signs and names of columns; `signs.shear` is the body on which the shear is
        positive along +x, None where it is not stated
    theory
        solution of half-plane theory along the scene's whole load path
    sure_of_times
        whether the result's times are known to be those of the load path

    Raises
    ------
    InputError
        For loads or times of the result that are not on the scene's load path.

    # notation: P normal load, Q tangential load
    """
    scene = theory.scene
    # history: times on the load path, P and Q there, and sentences on how they were found
    surface, history, guesses = _surface_on_path(
        surface, mapping, theory, sure_of_times=sure_of_times
    )
    if history.guess_in_words:
        guesses = (*guesses, history.guess_in_words)
    # the shear fits the path with both signs, and nothing in the file decides
    if history.has_either_sign and mapping.signs.shear is None:
        guesses = (
            *guesses,
            (
                "the shear acts on the lower body: its instants were found from the shear itself,"
                " and the scene's path fits it turned round as well (signs.shear, or columns of P"
                " and Q, say it for certain)"
            ),
        )
    # field -> (number of instants, reason)
    missing_fields = _missing_fields(surface, history.time, _instants_of_cycle(scene, history.time))
    has_dissipation = "dissipation" not in missing_fields
    solution_without_zones = _solution_without_zones(
        surface, mapping, scene, history, missing_fields
    )
    # states, edges and work from its tractions and slip
    solution, method_in_words = _solution_with_zones(
        solution_without_zones, uses_slip=surface.slip is not None, adds_dissipation=has_dissipation
    )
    notes = [*surface.notes, *history.notes, method_in_words]
    if has_dissipation:
        notes.append(
            "its dissipation is the sum of q ds of its own shear and slip over the"
            f" {len(solution.last_cycle)} instants of a cycle"
        )
    if surface.normal_load is None and surface.tangential_load is None:
        notes.append("P and Q are the scene's at its instants")
    elif surface.normal_load is None:
        notes.append("P is the scene's at its instants")
    elif surface.tangential_load is None:
        notes.append("Q is the scene's at its instants")
    solution = replace(solution, record=replace(solution.record, notes=tuple(notes)))
    return solution, (*guesses, *_sentences_on_odd_signs(surface, history.tangential_load, scene))


def _solution_without_zones(
    surface: SurfaceResult,
    mapping: Mapping,
    scene: Scene,
    history: History,
    missing_fields: dict[str, tuple[int, str]],
) -> ContactSolution:
    """An external result as a solution with its tractions, slip, times and loads alone. All points
    are marked as open; edges, and all that follows from them, are NaN.

    A load P or Q that the result lacks is the scene's at its instants (`history`).

    Parameters
    ----------
    surface
        the external result, in the scene's units and signs: `source` is its file, `code` the
        program that computed it, `read_as` how each column was read
    mapping
        stated columns, units and signs of the file, and the size of its elements
    history
        times of the result on the scene's load path, and the scene's P and Q there
    missing_fields
        what the result lacks: name -> (number of instants, reason)

    # notation: P normal load, Q tangential load
    """
    slip = surface.slip
    if slip is None:
        slip = read_only_copy(np.full_like(surface.pressure, np.nan))
    normal_load = history.normal_load if surface.normal_load is None else surface.normal_load
    tangential_load = surface.tangential_load
    if tangential_load is None:
        tangential_load = history.tangential_load
    n_instants = len(history.time)
    # Work: numbers of instants and points, and what is missing
    return ContactSolution(
        engine=surface.code or Path(surface.source).name,
        scene=scene,
        time=read_only_copy(history.time),
        normal_load=read_only_copy(normal_load),
        tangential_load=read_only_copy(tangential_load),
        x=surface.x,
        pressure=surface.pressure,
        shear=surface.shear,
        slip=slip,
        **_fields_not_known_yet(n_instants, len(surface.x)),
        record=Record(
            # converged, how it ended, the same in a sentence, iterations of each instant
            True,
            "end of path",
            f"read from {surface.source}",
            read_only_copy(np.zeros(n_instants), np.int64),
        ),
        work=Work({"instants": n_instants, "points": len(surface.x)}, missing_fields),
        **_bulk_and_tilt_at(scene, history.time),
        settings=_settings_of_result(surface, mapping),
    )


def _fields_not_known_yet(n_instants: int, n_points: int) -> dict[str, Any]:
    """Fields of a solution that its tractions alone do not state, by name: NaN for edges,
    half-widths, displacements and dissipation; every point open; None for the first steady cycle.
    """
    no_edges = read_only_copy(np.full((n_instants, 2), np.nan))
    no_series = read_only_copy(np.full(n_instants, np.nan))
    return {
        **dict.fromkeys(("contact_edges", "stick_edges"), no_edges),
        **dict.fromkeys(("contact_half_width", "stick_half_width"), no_series),
        **dict.fromkeys(("tangential_displacement", "normal_approach"), no_series),
        "state": read_only_copy(np.zeros((n_instants, n_points)), np.int8),
        "dissipation_density": read_only_copy(np.full(n_points, np.nan)),
        "dissipation": np.nan,
        "cycle_dissipation": read_only_copy([np.nan]),
        "permanent_stick_half_width": np.nan,
        "steady_from": None,
    }


def _settings_of_result(surface: SurfaceResult, mapping: Mapping) -> dict[str, Any]:
    """How an external result was read: its file; names of the fields that are derived from others,
    or are the scene's (P and Q where the file has none); how each column was read; and the size of
    its elements, where the mapping states it [length].

    # notation: P normal load, Q tangential load
    """
    names_of_scene = [
        name for name in ("normal_load", "tangential_load") if getattr(surface, name) is None
    ]
    # DERIVED: key for names of fields that are derived from others
    settings: dict[str, Any] = {
        "source": surface.source,
        DERIVED: ["state", "contact_edges", "stick_edges", *names_of_scene],
    }
    if surface.read_as:
        settings["read_as"] = [list(pair) for pair in surface.read_as]
    if mapping.element_size:
        settings["element_size"] = mapping.element_size
    return settings


def _surface_on_path(
    surface: SurfaceResult, mapping: Mapping, theory: ContactSolution, *, sure_of_times: bool
) -> tuple[SurfaceResult, History, tuple[str, ...]]:
    """An external result in the scene's units and signs; the instants of the load path to which it
    belongs; and a sentence for each guess.

    Single values that stand out of all others (outliers) are left out while units and instants are
    found, and put back. `sure_of_times` says that the result's times are those of the load path.
    `mapping` states columns, units and signs of the file; `theory` is half-plane theory of the
    scene's whole path.
    """
    smooth_surface = _surface_without_outliers(surface)
    converted_surface, guesses = _surface_in_scene_units(smooth_surface, mapping, theory)
    history = history_of_result(converted_surface, theory.scene, sure_of_times=sure_of_times)
    if not surface.outliers:
        return converted_surface, history, guesses
    sentences = [outlier.sentence for outlier in surface.outliers]
    restored_surface = _surface_with_outliers(converted_surface, smooth_surface)
    return restored_surface, history, (*sentences, *guesses)


def _surface_without_outliers(surface: SurfaceResult) -> SurfaceResult:
    """An external result with each value of pressure, shear or slip that stands out of all others
    replaced by the mean of its neighbours in x.
    """
    smooth_fields: dict[str, Any] = {
        "pressure": without_spikes(surface.pressure),
        "shear": without_spikes(surface.shear),
    }
    if surface.slip is not None:
        smooth_fields["slip"] = without_spikes(surface.slip)
    return replace(surface, **smooth_fields)


def _surface_with_outliers(
    converted_surface: SurfaceResult, smooth_surface: SurfaceResult
) -> SurfaceResult:
    """An external result in the scene's units with its outliers put back: single values that stand
    out of all others. Each gets the factor and the sign that the rest of its field got.

    Parameters
    ----------
    converted_surface
        the result in the scene's units, without outliers
    smooth_surface
        the same before its conversion; `outliers` have `quantity` (the name of a field), indices
        `instant` and `point`, and the `value` in the file's unit
    """
    restored_fields: dict[str, Any] = {}
    for outlier in smooth_surface.outliers:
        field_before = getattr(smooth_surface, outlier.quantity)
        field_after = getattr(converted_surface, outlier.quantity)
        index_of_largest = np.unravel_index(np.argmax(np.abs(field_before)), field_before.shape)
        factor = 1.0
        if field_before[index_of_largest]:
            factor = float(field_after[index_of_largest] / field_before[index_of_largest])
        values = restored_fields.setdefault(outlier.quantity, field_after.copy())
        values[outlier.instant, outlier.point] = factor * outlier.value
    frozen_fields: dict[str, Any] = {
        name: read_only_copy(values) for name, values in restored_fields.items()
    }
    return replace(converted_surface, **frozen_fields)


def _solution_with_zones(
    solution: ContactSolution, *, uses_slip: bool, adds_dissipation: bool
) -> tuple[ContactSolution, str]:
    """A solution with what follows from its own tractions: states (open, stick, slip), edges of
    contact and stick, permanent stick zone, moments. With it, in words, the rule by which states
    were found.

    Parameters
    ----------
    uses_slip
        whether its slip is used beside its tractions to find which points slip
    adds_dissipation
        whether its dissipation is computed too, as the sum of q ds over its last cycle

    # notation: q shear traction, s slip
    """
    zones = zones_of_tractions(
        solution.x,
        solution.pressure,
        solution.shear,
        solution.slip if uses_slip else None,
        solution.scene.friction.coefficient,
        solution.time,
    )
    # a result without shear holds NaN
    has_shear = not np.isnan(solution.shear).all()
    stick_edges = zones.stick_edges if has_shear else np.full_like(zones.stick_edges, np.nan)
    method_in_words = zones.rule_in_words
    if not has_shear:
        # _IN_CONTACT: words on which points are in contact
        method_in_words = (
            f"{_IN_CONTACT}; without a shear nothing says what slips, and what touches is drawn as"
            " sticking"
        )
    # indices of the instants of the last cycle; none where it is noted as missing (WHOLE_CYCLE)
    instants_of_cycle = (
        solution.last_cycle if WHOLE_CYCLE not in solution.work.skipped else np.arange(0)
    )
    permanent_edges = _permanent_stick_edges(stick_edges[instants_of_cycle])
    changes: dict[str, Any] = {
        "state": read_only_copy(zones.state, np.int8),
        "contact_edges": read_only_copy(zones.contact_edges),
        "stick_edges": read_only_copy(stick_edges),
        "contact_half_width": read_only_copy(np.diff(zones.contact_edges, axis=1)[:, 0] / 2),
        "stick_half_width": read_only_copy(np.diff(stick_edges, axis=1)[:, 0] / 2),
        "permanent_stick_half_width": float(permanent_edges[1] - permanent_edges[0]) / 2,
    }
    # with bulk stress, tilt or unequal sides
    if solution.scene.unsymmetric:
        changes |= _moments(solution)
        if has_shear:
            changes["permanent_stick_edges"] = read_only_copy(permanent_edges)
    if adds_dissipation:
        changes |= _dissipation_of_instants(solution, instants_of_cycle)
    return replace(solution, **changes), method_in_words


def _permanent_stick_edges(stick_edges: Array) -> Array:
    """Left and right end (2,) of the zone that sticks through a whole cycle [length]: the innermost
    ones of the stick zone. NaN where there is no such zone, no instant, or where an end is NaN.
    `stick_edges` (k, 2) are its ends at the k instants of the cycle.
    """
    no_edges = np.full(2, np.nan)
    if not len(stick_edges) or np.isnan(stick_edges).any():
        return no_edges
    left_edge = stick_edges[:, 0].max()
    right_edge = stick_edges[:, 1].min()
    return np.array([left_edge, right_edge]) if right_edge > left_edge else no_edges


def _moments(solution: ContactSolution) -> dict[str, Any]:
    """Moments of the tractions of a solution about x = 0 by the trapezoidal rule, (n_steps,) each
    [force / thickness times length], by the name of the field: of the pressure, and of the shear
    where there is one.
    """
    moments: dict[str, Any] = {
        "moment": read_only_copy(np.trapezoid(solution.x * solution.pressure, solution.x, axis=1))
    }
    if not np.isnan(solution.shear).all():
        moments["shear_moment"] = read_only_copy(
            np.trapezoid(solution.x * solution.shear, solution.x, axis=1)
        )
    return moments


def _dissipation_of_instants(
    solution: ContactSolution, instants: NDArray[np.intp]
) -> dict[str, Any]:
    """Work of friction over the instants (indices) of a cycle, the sum of q ds, by the name of the
    field: at each point, in all, and of the one cycle.

    # notation: q shear traction, s slip
    """
    # work of friction per length at each point, (n,)
    density = friction_work(solution.shear[instants], solution.slip[instants])
    dissipation = float(np.trapezoid(density, solution.x))
    return {
        "dissipation": dissipation,
        "dissipation_density": read_only_copy(density),
        "cycle_dissipation": read_only_copy([dissipation]),
    }


def reference_by_same_rule(
    reference: ContactSolution, result: ContactSolution, half_width: float
) -> tuple[ContactSolution, tuple[str, ...]]:
    """Find states (open, stick, slip), edges of contact and stick, and dissipation of the reference
    solution by the rules by which those of an external result were found. Returns the reference
    with these, and in sentences how far the rules err for it.

    Errors of the rules so drop out of the comparison. The reference stays as it is where the result
    states all of these itself. Its dissipation also stays where its instants are not those of the
    result, or where the result has none. Stick edges are NaN at instants where the rule errs by
    more than 0.05 a_ref, or sees a stick zone wrongly. Where these are half of all instants or
    more, the edges by the rule stay. `half_width` is a_ref, that of the contact at the reference
    load.
    """
    # names of the fields of the result that were derived from its other fields
    if "state" not in names_of_derived_fields(result):
        return reference, ()
    # name of a field that the result lacks -> reason
    missing_fields = reason_by_missing_field(result)
    has_dissipation = (
        np.array_equal(reference.time, result.time) and "dissipation" not in missing_fields
    )
    # states, edges and work from the tractions of the reference; edges are (n_steps, 2)
    reference_by_rule, _ = _solution_with_zones(
        reference, uses_slip="slip" not in missing_fields, adds_dissipation=has_dissipation
    )
    has_judged_stick = _instants_with_judged_stick(reference, reference_by_rule, half_width)
    sentences = [_sentence_on_edges(reference, reference_by_rule, has_judged_stick, half_width)]
    if has_dissipation:
        sentences.append(_sentence_on_dissipation(reference, reference_by_rule))
    judged_edges = np.where(has_judged_stick[:, None], reference_by_rule.stick_edges, np.nan)
    return replace(reference_by_rule, stick_edges=read_only_copy(judged_edges)), tuple(sentences)


def _instants_with_judged_stick(
    reference: ContactSolution, reference_by_rule: ContactSolution, half_width: float
) -> Mask:
    """Whether stick edges are compared at each instant, (n_steps,): where the rule by which those
    of an external result are found gives the reference's own, to 0.05 a_ref. All instants where
    these are no majority.

    Parameters
    ----------
    reference, reference_by_rule
        the reference with its own stick edges (n_steps, 2), NaN without a stick zone; and with
        those by the rule
    half_width
        reference half-width a_ref
    """
    stick_error = reference.stick_edges - reference_by_rule.stick_edges
    has_stick_zone = ~np.isnan(reference.stick_edges[:, 0])
    rule_has_stick_zone = ~np.isnan(reference_by_rule.stick_edges[:, 0])
    largest_errors = np.max(np.abs(np.nan_to_num(stick_error)), axis=1)
    is_judged = has_stick_zone == rule_has_stick_zone
    is_judged &= largest_errors <= _LARGEST_STICK_ERROR_SHARE * half_width
    if 2 * is_judged.sum() <= len(is_judged):
        return np.ones_like(is_judged)
    return is_judged


def _sentence_on_edges(
    reference: ContactSolution,
    reference_by_rule: ContactSolution,
    has_judged_stick: Mask,
    half_width: float,
) -> str:
    """A sentence for the reader of a comparison: by how much the rule for edges errs at the contact
    edge and at the stick edge of the reference, and how many stick edges are not judged.

    Parameters
    ----------
    reference, reference_by_rule
        the reference with its own edges (n_steps, 2), and with those by the rule
    has_judged_stick
        (n_steps,) whether the stick edges of an instant are compared
    half_width
        reference half-width a_ref, by which errors are divided
    """
    contact_error = reference.contact_edges - reference_by_rule.contact_edges
    stick_error = (reference.stick_edges - reference_by_rule.stick_edges)[has_judged_stick]
    largest_contact_error = float(np.nanmax(np.abs(contact_error), initial=0.0)) / half_width
    largest_stick_error = float(np.nanmax(np.abs(stick_error), initial=0.0)) / half_width
    sentence = (
        "States and edges follow from one rule in the result and in the reference; against the"
        f" reference's own it errs by up to {largest_contact_error:.1e} a_ref at the contact edge"
        f" and {largest_stick_error:.1e} a_ref at the stick edge"
    )
    if not has_judged_stick.all():
        sentence += (
            f"; at {int((~has_judged_stick).sum())} of {len(has_judged_stick)} instants it can't"
            " tell the stick edges, which are not judged"
        )
    return f"{sentence}."


def _sentence_on_dissipation(reference: ContactSolution, reference_by_rule: ContactSolution) -> str:
    """A sentence for the reader of a comparison: by which rule dissipation is found, and by how
    many per cent it exceeds the reference's own.

    # notation: q shear traction, s slip
    """
    excess_percent = 0.0
    if reference.dissipation:
        excess_percent = 100 * (reference_by_rule.dissipation / reference.dissipation - 1)
    return (
        "Dissipation is compared by one rule, the sum of q ds over "
        f"{len(reference_by_rule.last_cycle)} instants and {len(reference_by_rule.x)} points; "
        f"of the reference that rule gives {excess_percent:+.2g} % more than its own."
    )


def _bulk_and_tilt_at(scene: Scene, time: Array) -> dict[str, Any]:
    """Bulk stresses of both bodies and tilt that a scene imposes at the times of a result (k,):
    name of the field -> (k,). Empty for a symmetric scene, which can have none of them. A tilt that
    follows from a stated moment is left out: the tractions do not show it.
    """
    # symmetric: no bulk stress, tilt or unequal sides
    if not scene.unsymmetric:
        return {}
    path = scene.load.path()
    imposed_series: dict[str, Any] = {}
    for companion_name, field_names in (
        ("bulk", ("bulk_stress_lower", "bulk_stress_upper")),
        ("tilt_and_moment", ("tilt",)),
    ):
        if companion_name == "tilt_and_moment" and path.moment_is_given:
            continue
        # history of these loads along the path; None where the scene has none of them
        companion = path.companion(companion_name)
        for component, field_name in enumerate(field_names):
            series = np.zeros(len(time))
            if companion is not None:
                series = companion.at(np.maximum(time, path.start))[component]
            imposed_series[field_name] = read_only_copy(series)
    return imposed_series


def _instants_of_cycle(scene: Scene, time: Array) -> int:
    """How many of a result's instants, at times (k,), make up the last whole cycle of the load
    path; 0 where they hold none. Of a path that is not periodic: all, if they go from its start to
    its end.
    """
    path = scene.load.path()
    if path.period is None:
        # of the last load segment
        end = path.initial_loading[-1].end
        tolerance = 1e-6 * (end - path.start)
        is_complete = time[0] <= path.start + tolerance and time[-1] >= end - tolerance
        return len(time) if is_complete else 0
    # indices of the instants of the cycle, and whether one lies at each of its ends
    cycle_indices, is_complete = last_whole_cycle(time, path.period, path.cycle_start)
    return len(cycle_indices) if is_complete else 0


def _missing_fields(
    surface: SurfaceResult, time: Array, instants_of_cycle: int
) -> dict[str, tuple[int, str]]:
    """What an external result (`surface`, with None or NaN for what its file lacks) does not hold:
    name of the field -> (number of instants, reason).

    Parameters
    ----------
    time
        (k,) times of the result's instants
    instants_of_cycle
        how many of them make up the last whole cycle, 0 where they hold none
    """
    missing_names = ("tangential_displacement", "normal_approach", "loop_work")
    # missing from every external result; _NOT_IN_RESULT: "not in the result"
    reason_by_name = dict.fromkeys(missing_names, _NOT_IN_RESULT)
    if surface.slip is None:
        reason_by_name["slip"] = _NOT_IN_RESULT
    if not surface.has_shear:
        reason_by_name["shear"] = _NOT_IN_RESULT
        for name in ("state", "stick_edges"):
            reason_by_name[name] = f"{_NOT_IN_RESULT}; it takes the shear"
    if not instants_of_cycle:
        # WHOLE_CYCLE: name under which a missing last cycle is noted
        reason_by_name[WHOLE_CYCLE] = (
            f"{_NOT_IN_RESULT}, which goes from time {time[0]:.6g} to {time[-1]:.6g}"
        )
    # the work of friction needs all of these
    why_without_work = ""
    if not surface.has_shear:
        why_without_work = "; it takes the shear"
    elif surface.slip is None:
        why_without_work = "; it takes slip"
    elif not instants_of_cycle:
        why_without_work = "; it takes a whole cycle, or a whole path from the unloaded start"
    # the trapezoidal rule needs 8 instants
    elif instants_of_cycle < _FEWEST_INSTANTS:
        why_without_work = (
            f", for a cycle of {instants_of_cycle} instants is too coarse to work it out (less than"
            f" {_FEWEST_INSTANTS})"
        )
    if why_without_work:
        for name in ("dissipation", "dissipation_density"):
            reason_by_name[name] = _NOT_IN_RESULT + why_without_work
    return {name: (len(time), reason) for name, reason in reason_by_name.items()}


def friction_work(shear: Array, slip: Array) -> Array:
    """Friction work per length at n points, (n,): sum of q ds over k instants by the trapezoidal
    rule, from the shear q and the slip s, (k, n) each.

    >>> friction_work(np.array([[0.0], [2.0]]), np.array([[0.0], [3.0]])).tolist()
    [3.0]
    """
    return np.asarray(np.sum((shear[1:] + shear[:-1]) / 2 * np.diff(slip, axis=0), axis=0))


# -------------------------------------------------------------------------- contact, stick and slip
class Zones(NamedTuple):
    """States and edges worked out from tractions.

    Attributes
    ----------
    state
        (n_steps, n_points) open, stick, forward or reverse slip, as int8
    contact_edges, stick_edges
        (n_steps, 2) left and right end [length]
    rule_in_words
        by which they were found
    """

    state: NDArray[np.int8]
    contact_edges: Array
    stick_edges: Array
    rule_in_words: str


_IN_CONTACT = (
    f"in contact is a point with more than {LEAST_TOUCHING_SHARE:g} of the instant's largest"
    " pressure"
)


def zones_of_tractions(
    x: Array,
    pressure: Array,
    shear: Array,
    slip: Array | None,
    friction_coefficient: float,
    time: Array,
) -> Zones:
    """States (open, stick, slip), contact edges and stick edges at every instant, from tractions on
    points, (n_steps, n_points), and from slip where there is one; with the rule in words.

    A point is in contact with more than a thousandth of the instant's largest pressure. In full
    stick the stick edges are the contact edges, in full slip NaN; without a contact both are NaN.
    Near an edge, p and f p - |q| go like the root of the distance from it. So a contact edge lies
    where the straight line of p^2 through the last two points in contact is 0, a stick edge where
    that of (f p - |q|)^2 is, each no farther than the next point. The outermost points show the
    mesh: a parabola of p^2 through those behind them gives the contact edge where it fits.

    # notation: f = `friction_coefficient`, p pressure, q shear
    """
    is_touching = pressure > LEAST_TOUCHING_SHARE * pressure.max(axis=1, keepdims=True)
    # slip_direction: sign of the slip, 1 forward
    is_slipping, slip_direction, rule_in_words = _slipping_points(
        pressure, shear, slip, is_touching, friction_coefficient, time
    )
    # OPEN, STICK, SLIP_FORWARD, SLIP_REVERSE: numbers of the states
    state = np.full(pressure.shape, OPEN, dtype=np.int8)
    state[is_touching] = STICK
    state[is_slipping & (slip_direction > 0)] = SLIP_FORWARD
    state[is_slipping & ~(slip_direction > 0)] = SLIP_REVERSE

    # edges at each instant k, left and right
    is_sticking = is_touching & ~is_slipping
    margin_to_limit = np.maximum(friction_coefficient * pressure - np.abs(shear), 0.0)
    contact_edges = np.empty((len(pressure), 2))
    stick_edges = np.empty((len(pressure), 2))
    for k in range(len(pressure)):
        contact_edges[k] = _ends_of_zone(x, pressure[k] ** 2, is_touching[k], tries_parabola=True)
        stick_edges[k] = _ends_of_zone(x, margin_to_limit[k] ** 2, is_sticking[k])
        # where the outermost points of the contact stick, the stick zone ends with it
        touching_points = np.flatnonzero(is_touching[k])
        if len(touching_points) and is_sticking[k, touching_points[0]]:
            stick_edges[k, 0] = contact_edges[k, 0]
        if len(touching_points) and is_sticking[k, touching_points[-1]]:
            stick_edges[k, 1] = contact_edges[k, 1]
    return Zones(state, contact_edges, stick_edges, rule_in_words)


def _slipping_points(
    pressure: Array,
    shear: Array,
    slip: Array | None,
    is_touching: Mask,
    friction_coefficient: float,
    time: Array,
) -> tuple[Mask, Array, str]:
    """Which points slip at each instant, the sign of their slip (1 forward), both (n_steps,
    n_points), and the rule in words.

    A point slips where |q| reaches the Coulomb limit f p to 1 %. Where its slip displacement is
    known, it must also move with the shear, by more than a thousandth of the largest movement since
    the instant before; without friction, movement alone counts. No point slips at an instant at
    which the fastest is slower than 2 % of the largest speed of all. The first instant has no
    movement before it: there the Coulomb limit alone decides.

    Parameters
    ----------
    pressure, shear, slip
        (n_steps, n_points); slip None where it is not known
    is_touching
        (n_steps, n_points) points in contact
    friction_coefficient
        coefficient f
    time
        (n_steps,) of the instants

    # notation: p pressure, q shear
    """
    is_slipping = is_touching & (
        np.abs(shear) >= (1 - _SHARE_BELOW_LIMIT) * friction_coefficient * pressure
    )
    slip_direction = np.sign(shear)
    # _IN_CONTACT: words on which points are in contact
    rule_in_words = _IN_CONTACT
    sources_in_words = "tractions"
    if friction_coefficient:
        rule_in_words += f"; it slips where |q| is at least {1 - _SHARE_BELOW_LIMIT:g} f p"
    if slip is not None and len(slip) > 1:
        # change of slip since the instant before, (n_steps - 1, n_points)
        movement = np.where(is_touching[1:], np.diff(slip, axis=0), 0.0)
        largest_movement = np.max(np.abs(movement), axis=1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            largest_speed = np.where(
                largest_movement > 0, largest_movement / np.diff(time)[:, None], 0.0
            )
        # at an instant at which no point moves fast, none slips
        is_fast_instant = largest_speed >= _LEAST_SHARE_OF_SPEED * np.max(largest_speed)
        is_moving = (
            np.abs(movement) > _LEAST_SHARE_OF_MOVEMENT * largest_movement
        ) & is_fast_instant
        if friction_coefficient:
            moves_with_shear = is_moving & (np.sign(movement) == slip_direction[1:])
            is_slipping = np.vstack([is_slipping[:1], is_slipping[1:] & moves_with_shear])
            sources_in_words = "tractions and slip"
            rule_in_words += (
                " and its slip has moved with the shear by more than"
                f" {_LEAST_SHARE_OF_MOVEMENT:g} of the instant's largest step, unless no point"
                " moves faster than"
                f" {_LEAST_SHARE_OF_SPEED:g} of the largest rate"
            )
        else:
            is_slipping = np.vstack([is_slipping[:1], is_moving])
            slip_direction = np.vstack([slip_direction[:1], np.sign(movement)])
    elif friction_coefficient:
        rule_in_words += (
            "; for want of slip, a point that just came to rest still counts as slipping"
        )
    rule_in_words = f"states and edges are worked out from its {sources_in_words}: {rule_in_words}"
    return is_slipping, slip_direction, rule_in_words


def _ends_of_zone(
    x: Array, squared_traction: Array, is_in_zone: Mask, *, tries_parabola: bool = False
) -> tuple[float, float]:
    """x of the left and of the right end of a zone of contact or stick on the surface. NaN for a
    zone without any point.

    Each end is where the straight line through the squared traction at the two outermost points is
    0. With `tries_parabola` it is that of a parabola through more points, where this fits.

    Parameters
    ----------
    x, squared_traction
        (n,) points, and a traction squared that is 0 at the ends of the zone [stress^2]
    is_in_zone
        (n,) which points lie in the zone
    """
    points = np.flatnonzero(is_in_zone)
    if not len(points):
        return np.nan, np.nan
    left_end = _end_of_zone(x, squared_traction, points, -1, tries_parabola=tries_parabola)
    right_end = _end_of_zone(x, squared_traction, points, 1, tries_parabola=tries_parabola)
    return left_end, right_end


def _end_of_zone(
    x: Array,
    squared_traction: Array,
    points_of_zone: NDArray[np.intp],
    direction: int,
    *,
    tries_parabola: bool,
) -> float:
    """Where a zone of contact or stick ends: x between two points of the surface, at which the
    squared traction falls to 0, nearly along a straight line or a parabola. Half-way between the
    two where it does not fall outwards; the last point of the surface where the zone reaches it.

    Parameters
    ----------
    x, squared_traction
        (n,) places of the points of the surface, and the squared traction there [stress^2]
    points_of_zone
        indices of those points that lie in the zone, from left to right
    direction
        −1 for the left end, 1 for the right one
    tries_parabola
        whether a parabola through 6 to 12 points is tried too. Its zero counts where it lies within
        0.4 spacings of points from that of the line
    """
    outermost_point = int(points_of_zone[0] if direction < 0 else points_of_zone[-1])
    point_beyond = outermost_point + direction
    point_inside = outermost_point - direction
    if not 0 <= point_beyond < len(x):
        return float(x[outermost_point])
    distance_to_point_beyond = abs(float(x[point_beyond] - x[outermost_point]))
    # a traction that does not fall outwards has no line to 0: the end is half-way to `point_beyond`
    if (
        not 0 <= point_inside < len(x)
        or squared_traction[point_inside] <= squared_traction[outermost_point]
    ):
        return float(x[outermost_point]) + direction * distance_to_point_beyond / 2
    # straight line through the squared traction at the two outermost points of the zone
    spacing = abs(float(x[outermost_point] - x[point_inside]))
    fall_of_outermost_spacing = squared_traction[point_inside] - squared_traction[outermost_point]
    spacings_to_zero = float(squared_traction[outermost_point] / fall_of_outermost_spacing)
    distance_to_zero = min(spacings_to_zero * spacing, distance_to_point_beyond)
    zero_of_line = float(x[outermost_point]) + direction * distance_to_zero

    # parabola through points farther in, behind the outermost three: no deeper than 5 % of the zone
    largest_depth = _LARGEST_DEPTH_SHARE * abs(x[points_of_zone[-1]] - x[points_of_zone[0]])
    # fewer points where a corner of the profile is among them
    for divisor in (1, 2, 4) if tries_parabola else ():
        n_fitted = (
            min(_MOST_FITTED_POINTS, len(points_of_zone) // 2 - _N_POINTS_LEFT_OUT) // divisor
        )
        fitted_points = outermost_point - direction * (_N_POINTS_LEFT_OUT + np.arange(n_fitted))
        if n_fitted < _FEWEST_FITTED_POINTS:
            continue
        if abs(x[outermost_point] - x[fitted_points[-1]]) > largest_depth:
            continue
        # distances inward from the outermost of the fitted points, in spacings
        x_of_first_fitted = x[fitted_points[0]]
        depths = direction * (x_of_first_fitted - x[fitted_points]) / spacing
        # None where the parabola does not fit
        spacings_outward = _root_of_parabola(depths, squared_traction[fitted_points])
        if spacings_outward is None:
            continue
        zero_of_parabola = float(x_of_first_fitted + direction * spacing * spacings_outward)
        if abs(zero_of_parabola - zero_of_line) <= _LARGEST_DIFFERENCE_IN_SPACINGS * spacing:
            return zero_of_parabola
    return zero_of_line


def _root_of_parabola(depth: Array, squared_pressure: Array) -> float | None:
    """Distance outwards from the outermost point to the zero of a parabola fitted to p^2, which
    falls to 0 at an edge of contact.

    The fit is by least squares of relative deviations. None where the parabola does not fall
    outwards, has no zero, or does not fit.

        p^2 = a d^2 + b d + c at depth d, and 0 at d = -2 c/(b + sqrt(b^2 - 4 a c)),

    with coefficients a, b and c of the fit.

    Parameters
    ----------
    depth
        (m,) distance of each point inwards from the outermost one, in any unit of length, which
        the returned distance has too
    squared_pressure
        (m,) p^2 > 0 at these points

    # notation: p pressure
    """
    coefficients = np.polyfit(depth, squared_pressure, 2, w=1 / squared_pressure)
    a, b, c = coefficients
    relative_residual = np.std(np.polyval(coefficients, depth) / squared_pressure)
    discriminant = b**2 - 4 * a * c
    # it fits to half a per cent
    if not (b > 0 and discriminant > 0 and relative_residual < _LARGEST_RELATIVE_RESIDUAL):
        return None
    return float(2 * c / (b + np.sqrt(discriminant)))


# -------------------------------------------------------------------- units and signs that can't be
def theory_of_whole_path(scene: Scene) -> ContactSolution:
    """Half-widths and loads of half-plane theory through the whole path, at the engine's own
    instants.
    """
    import semi_analytic

    return semi_analytic.solve(scene, x=[0.0], fields=())


def _surface_in_scene_units(
    surface: SurfaceResult, mapping: Mapping, theory: ContactSolution
) -> tuple[SurfaceResult, tuple[str, ...]]:
    """An external result in the scene's units and the project's signs, and a sentence for each
    unit, sign or offset that had to be guessed. `theory` is half-plane theory of the scene's whole
    path. What the mapping states is never guessed; `signs.pressure` of it is None where the sign of
    compression is not stated.

    Raises
    ------
    InputError
        For a pressure that is zero everywhere, or nowhere compression by the sign that the mapping
        states.

    # notation: P normal load
    """
    if not np.any(surface.pressure):
        raise InputError(
            f"{surface.source}: the pressure is zero at every point and instant: nothing to score"
        )
    if mapping.signs.pressure is not None and surface.pressure.max() <= 0:
        raise InputError(
            f"{surface.source}: by signs.pressure = {mapping.signs.pressure!r} of the mapping no"
            " point is in compression: state the other sign, or leave it out"
        )
    surface, sentences = _surface_in_compression(surface, mapping)
    # half-width, largest pressure, largest P: each beside a value of theory, for a unit factor
    for compared_value in _compared_values(surface, theory):
        surface, sentence = _surface_in_unit(compared_value, surface, mapping)
        sentences.append(sentence)
    # x counted from the middle of the contact
    surface, sentence = _centred_surface(surface, mapping, theory)
    sentences.append(sentence)
    return surface, tuple(filter(None, sentences))


def _surface_in_compression(
    surface: SurfaceResult, mapping: Mapping
) -> tuple[SurfaceResult, list[str]]:
    """An external result in which compression and pressing loads are positive. Where its pressure,
    or its normal load, is negative throughout the sign is turned, and a sentence says so. The sign
    of the pressure is left where the mapping states it (`signs.pressure`, else None).
    """
    sentences = []
    pressure = surface.pressure
    # LEAST_TOUCHING_SHARE: a thousandth of the largest pressure counts as none
    if mapping.signs.pressure is None and pressure.max() <= LEAST_TOUCHING_SHARE * -pressure.min():
        surface = replace(surface, pressure=read_only_copy(0.0 - pressure))
        sentences.append(
            "the pressure is negative throughout: compression was taken to be negative"
            ' (signs.pressure = "compression negative")'
        )
    normal_load = surface.normal_load
    if normal_load is not None and normal_load.max() <= 1e-9 * -normal_load.min():
        surface = replace(surface, normal_load=read_only_copy(0.0 - normal_load))
        sentences.append(
            "the normal load is negative throughout and was turned: here P > 0 presses"
        )
    return surface, sentences


def _centred_surface(
    surface: SurfaceResult, mapping: Mapping, theory: ContactSolution
) -> tuple[SurfaceResult, str]:
    """An external result with its x shifted so that the centroid of the pressure, at the instant of
    the largest one, lies in the middle of theory's contact (x = 0 without a tilt); and a sentence
    that says so.

    It stays as it is, with an empty sentence, where it is centred to half the half-width, or more
    than twice as wide as theory's contact. So it does where the mapping states an offset other than
    0. `theory` holds half-widths and edges (n_steps, 2) of the contact through the whole path, and
    `tilt`, None for a scene without.
    """
    # with pressure at any instant
    leftmost_pressed_x, rightmost_pressed_x = _ends_of_contact(surface)
    largest_half_width = float(np.nanmax(theory.contact_half_width))
    leftmost_edge = np.nanmin(theory.contact_edges[:, 0])
    rightmost_edge = np.nanmax(theory.contact_edges[:, 1])
    middle_of_theory = float(leftmost_edge + rightmost_edge) / 2 if theory.tilt is not None else 0.0
    is_off_centre = (
        abs((leftmost_pressed_x + rightmost_pressed_x) / 2 - middle_of_theory)
        > _LARGEST_OFFSET_SHARE * largest_half_width
    )
    is_wide = rightmost_pressed_x - leftmost_pressed_x > 4 * largest_half_width
    if mapping.x_offset or not is_off_centre or is_wide:
        return surface, ""
    # the instant of the largest pressure
    pressure_of_instant = surface.pressure[int(np.argmax(surface.pressure.max(axis=1)))]
    normal_load = np.trapezoid(pressure_of_instant, surface.x)
    centroid = float(np.trapezoid(pressure_of_instant * surface.x, surface.x) / normal_load)
    offset = centroid - middle_of_theory
    method_in_words = ", by the centroid" if middle_of_theory else ", the centroid"
    sentence = (
        f"x was counted from {offset:.6g}{method_in_words} of the largest pressure, where the"
        " file has it from 0 (x_offset)"
    )
    return replace(surface, x=read_only_copy(surface.x - offset)), sentence


@dataclass(frozen=True)
class _ComparedValue:
    """A value of the result beside the one that theory has, by which a unit is guessed.

    Attributes
    ----------
    factor_name
        which factor of the mapping has this unit: "length", "stress" or "load"
    field_names
        fields of the result that have this unit
    fields_in_words
        these fields in a sentence
    value_of_result, value_of_theory
        the value in the result, and theory's
    value_in_words
        what both are, in a sentence
    """

    factor_name: str
    field_names: tuple[str, ...]
    fields_in_words: str
    value_of_result: float
    value_of_theory: float
    value_in_words: str

    @property
    def theory_in_words(self) -> str:
        """Theory's value in a sentence; of pressure it is the mean, so the least."""
        if self.factor_name == "stress":
            return f"at least the mean one, {self.value_of_theory:.4g},"
        return f"{self.value_of_theory:.4g}"

    @property
    def unit_factor(self) -> float:
        """Factor of a unit by which the external result is to be multiplied: the first of 1, 1e3,
        1e-3, 1e6, 1e-6, 1e9 and 1e-9 that brings the compared value to 0.03 to 10 times that of
        theory; 1 if none does.
        """
        for factor in (1.0, *_UNIT_FACTORS):
            if (
                _LEAST_RATIO_TO_THEORY
                <= self.value_of_result / self.value_of_theory * factor
                <= _LARGEST_RATIO_TO_THEORY
            ):
                return factor
        return 1.0


def _compared_values(surface: SurfaceResult, theory: ContactSolution) -> tuple[_ComparedValue, ...]:
    """Half-width, largest pressure and largest normal load of an external result (`surface`), each
    beside a value of theory: from their ratios the unit of its lengths, stresses and loads is
    guessed.

    Beside the largest pressure stands theory's mean pressure: units differ by far more than these
    two do, and the mean needs no field. A result that states no P has the load 0. `theory` holds
    half-widths of contact and P through the scene's whole path.

    # notation: P normal load
    """
    # leftmost and rightmost x with pressure at any instant
    left_end, right_end = _ends_of_contact(surface)
    half_width_of_theory = float(np.nanmax(theory.contact_half_width))
    largest_load_of_theory = float(np.max(theory.normal_load))
    mean_pressure_of_theory = largest_load_of_theory / (2 * half_width_of_theory)
    largest_load = 0.0 if surface.normal_load is None else float(np.max(surface.normal_load))
    # factor_name: the factor of the mapping that has this unit; field_names: fields in this unit
    return (
        _ComparedValue(
            factor_name="length",
            field_names=("x", "slip"),
            fields_in_words="x",
            value_of_result=(right_end - left_end) / 2,
            value_of_theory=half_width_of_theory,
            value_in_words="the contact's half-width is",
        ),
        _ComparedValue(
            factor_name="stress",
            field_names=("pressure", "shear"),
            fields_in_words="pressure and shear",
            value_of_result=float(surface.pressure.max()),
            value_of_theory=mean_pressure_of_theory,
            value_in_words="the largest pressure is",
        ),
        _ComparedValue(
            factor_name="load",
            field_names=("normal_load", "tangential_load"),
            fields_in_words="P and Q",
            value_of_result=largest_load,
            value_of_theory=largest_load_of_theory,
            value_in_words="the largest P is",
        ),
    )


def _surface_in_unit(
    compared_value: _ComparedValue, surface: SurfaceResult, mapping: Mapping
) -> tuple[SurfaceResult, str]:
    """Guess the unit of one kind of field of an external result (lengths, stresses or loads) from
    its size beside theory's: the result with these fields multiplied by the factor that this
    suggests, and a sentence that says so.

    As it is, with an empty sentence, where the mapping states the factor or none is needed.

    Parameters
    ----------
    compared_value
        names of the fields of this unit; a value of the result, such as its largest pressure, and
        theory's; `unit_factor`, a power of 1000 that brings the two together, 1 where none is
        needed; and words on each
    mapping
        stated factors of lengths, stresses and loads, `factor_name` of them this one; None where
        not stated
    """
    fields = {name: getattr(surface, name) for name in compared_value.field_names}
    present_fields = {name: values for name, values in fields.items() if values is not None}
    is_stated = getattr(mapping.factors, compared_value.factor_name) is not None
    factor = compared_value.unit_factor
    if is_stated or not present_fields or not compared_value.value_of_result or factor == 1.0:
        return surface, ""
    scaled_fields: dict[str, Any] = {
        name: read_only_copy(values * factor) for name, values in present_fields.items()
    }
    sentence = (
        f"{compared_value.fields_in_words} multiplied by {factor:g}, for"
        f" {compared_value.value_in_words} {compared_value.value_of_result:.4g} and theory has"
        f" {compared_value.theory_in_words} (factors.{compared_value.factor_name} = {factor:g} says"
        " it for certain)"
    )
    return replace(surface, **scaled_fields), sentence


def _ends_of_contact(surface: SurfaceResult) -> tuple[float, float]:
    """Leftmost and rightmost x of the points that are in contact at any instant."""
    is_touching = (surface.pressure > LEAST_TOUCHING_SHARE * surface.pressure.max()).any(axis=0)
    x_in_contact = surface.x[is_touching]
    return float(x_in_contact[0]), float(x_in_contact[-1])


def _sentences_on_odd_signs(
    surface: SurfaceResult, tangential_load: Array, scene: Scene
) -> Iterator[str]:
    """Sentences about signs of a result that look wrong though they are scored as they are:
    tension, shear against Q, slip against the shear. `surface` is the result: tractions and slip
    (k, n), the slip None where it is not stated. `tangential_load` (k,) is Q of the scene at its k
    instants.

    # notation: Q tangential load
    """
    # tension of more than a thousandth of the largest pressure
    if surface.pressure.min() < -LEAST_TOUCHING_SHARE * surface.pressure.max():
        instant, point = np.unravel_index(np.argmin(surface.pressure), surface.pressure.shape)
        least_pressure = surface.pressure[instant, point]
        yield (
            f"the pressure is tension at some points, down to {least_pressure:.4g} at"
            f" x = {surface.x[point]:.4g} of instant {instant + 1}; it is scored as it is"
        )
    # integral of the shear over x at each instant
    _, resultant_shear = resultants(surface)
    largest_product = float(np.linalg.norm(resultant_shear) * np.linalg.norm(tangential_load))
    if float(resultant_shear @ tangential_load) < -0.5 * largest_product:
        yield (
            "the shear is opposite to Q in the mean: it looks like the shear on the upper body; it"
            ' is scored as it is (signs.shear = "on upper" turns it)'
        )

    # work of friction from one instant to the next
    if surface.slip is not None and scene.friction.coefficient and len(surface.slip) > 1:
        mean_shear = (surface.shear[1:] + surface.shear[:-1]) / 2
        work_by_interval = mean_shear * np.diff(surface.slip, axis=0)
        if float(np.sum(work_by_interval)) < -0.5 * float(np.sum(np.abs(work_by_interval))):
            yield (
                "the slip goes against the shear, so that friction would feed energy in: it looks"
                ' like lower over upper; it is scored as it is (signs.slip = "lower over upper"'
                " turns it)"
            )
