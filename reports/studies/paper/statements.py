"""What the paper states, each statement against the engine: a verdict and the numbers that the
words of paper.toml name.

Equations and figures are the paper's; x and half-widths are over a0 = a(P0), work over A f^2 P0^2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain, groupby

import numpy as np

import semi_analytic
from reports.charts.templating import STATE_NAMES
from reports.studies.paper.cases import (
    FRICTIONS,
    LETTERS,
    POINTS,
    Case,
    Formulas,
    Paper,
    Sweep,
    total,
)
from reports.studies.paper.tables import EXACT, Found, judge, judge_number
from scenes import SurfaceState
from scenes.array_types import Array
from semi_analytic.friction_work import slip_times

_ROUNDING = 1e-10
_EXPONENT_SLACK = 0.01
# Points from the centre to near the largest contact, at which tractions are compared.
_PLACES = (0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.9, 1.0, 1.1)
# What the text gives for its four points: S stick, F forward slip, R reverse slip, O separation.
_HISTORIES = {0.77: "SRSF", 0.82: "SRORSF", 1.0: "OSFO", 1.13: "OFO"}


def judged(paper: Paper) -> dict[str, Found]:
    """Key of a statement -> its verdict and numbers."""
    return (
        tractions(paper.hertz)
        | course(paper.hertz)
        | loads(paper)
        | work(paper.hertz)
        | _comparisons(paper)
    )


# --------------------------------------------------------------------- tractions of the first cycle
def tractions(case: Case) -> dict[str, Found]:
    """Check what the paper states of the tractions: the shear by its equations (5) to (8) against
    that of the engine, at the events that it calls by letters, and what the first cycle leaves.
    Returns name of a statement -> (verdict, numbers). `case` is the paper's ellipse of loads on one
    profile.
    """
    return {
        "(5)": _shear_in_stick(case),
        "(6)": _shear_in_forward_slip(case),
        "full stick at E": _rest_at_e(case),
        "(7)": _shear_in_reverse_slip(case),
        "residual tractions": _residual_tractions(case),
    }


def _error_of_shear(case: Case, time: float, by_formula: Array) -> float:
    """Largest difference of a shear traction from the engine's at an instant, over the largest
    value of the latter. `by_formula` (n,) are its values at the n points of `_PLACES`.
    """
    shear = case.solve(time=[time], x=_PLACES, fields=("shear",)).shear[0]
    return float(np.max(np.abs(by_formula - shear)) / np.max(np.abs(shear)))


def _shear_in_stick(case: Case) -> Found:
    """Check equation (5), the shear of full stick: it holds up to the event B. Beyond B, where the
    normal load still grows, the edges slip. Returns (verdict, numbers). `case` is the paper's
    ellipse of loads on one profile.
    """
    formulas = Formulas(case)
    x = np.array(_PLACES) * case.length

    def error_at(time: float) -> float:
        """Relative error of equation (5) at an instant."""
        normal_load = float(formulas.loads(time)[0])
        return _error_of_shear(case, time, formulas.stuck(x, normal_load))

    error_in_stick = max(error_at(case.time("A")), error_at(case.time("B")))
    error_in_slip = error_at((case.time("B") + case.time("C")) / 2)
    verdict = judge(max(error_in_stick, error_in_slip) <= EXACT, nearly=error_in_stick <= EXACT)
    return verdict, {"error in full stick": error_in_stick, "error in slip": error_in_slip}


def _shear_in_forward_slip(case: Case) -> Found:
    """Check equation (6), the shear between the events B and E: that of full stick up to the load
    P_Y, then f times the pressure since. At P_Y the line of gradient f through the loads meets the
    initial loading. Returns (verdict, numbers). `case` is the paper's ellipse of loads on one
    profile.
    """
    formulas = Formulas(case)
    x = np.array(_PLACES) * case.length
    pressure = case.contact.pressure
    errors = {}
    for name, time in {
        "B-C": (case.time("B") + case.time("C")) / 2,
        "C": case.time("C"),
        "D": case.time("D"),
        "E": case.time("E"),
    }.items():
        normal_load = float(formulas.loads(time)[0])
        load_at_meeting = formulas.initial_meeting(time)
        shear_by_6 = formulas.stuck(x, load_at_meeting) + case.friction * (
            pressure(x, normal_load) - pressure(x, load_at_meeting)
        )
        errors[f"error at {name}"] = _error_of_shear(case, time, shear_by_6)
    worst_error = max(errors.values())
    return judge(worst_error <= EXACT), errors | {"largest error": worst_error}


def _shear_in_reverse_slip(case: Case) -> Found:
    """Check the paper's equation (7), the shear during reverse slip, at three instants: q = q_0 + f
    (2 p(P_c) - p(P) - p(P_0)).

    # notation: p(P) the pressure under the load P; P_c the load at which the contact is as wide as
    #           the stick zone now is; P_0, q_0 load and shear where the initial loading meets the
    #           cycle; E begin, F turning point of P, G end of reverse slip

    `case` is the paper's ellipse of loads on one profile. Returns (verdict, largest errors).
    """
    formulas = Formulas(case)
    x = np.array(_PLACES) * case.length
    pressure = case.contact.pressure
    load_at_meeting = formulas.initial_meeting(case.time("E"))
    errors = {}
    for name, time in {
        "E-F": (case.time("E") + case.time("F")) / 2,
        "F": case.time("F"),
        "G": case.time("G"),
    }.items():
        normal_load = float(formulas.loads(time)[0])
        stick_edge_load = float(formulas.front("EG", time))
        slipped_pressure = (2 * pressure(x, stick_edge_load) - pressure(x, normal_load)) - pressure(
            x, load_at_meeting
        )
        shear_by_7 = formulas.stuck(x, load_at_meeting) + case.friction * slipped_pressure
        errors[f"error at {name}"] = _error_of_shear(case, time, shear_by_7)
    worst_error = max(errors.values())
    return judge(worst_error <= EXACT), errors | {"largest error": worst_error}


def _rest_at_e(case: Case) -> Found:
    """Statement on the event E, where forward slip ends: it comes to rest everywhere, and reverse
    slip then starts from the edges. `case` is the paper's ellipse of loads on one profile.
    """
    time_of_b = case.time("B")
    time_of_e = case.time("E")
    time_before = 1e-6
    around_e = case.solve(time=[time_of_e - time_before, time_of_e + time_before])
    stick_ratio = (around_e.stick_half_width / around_e.contact_half_width).tolist()
    slip_at_times = case.solve(
        time=[time_of_b, time_of_e - time_before, time_of_e], x=[0.8, 0.85], fields=("slip",)
    ).slip
    speed_before_e = (slip_at_times[2] - slip_at_times[1]) / time_before
    mean_speed = (slip_at_times[2] - slip_at_times[0]) / (time_of_e - time_of_b)
    slowest_ratio = float(np.max(speed_before_e / mean_speed))
    comes_to_rest = (
        stick_ratio[0] < 1 - EXACT and 1 - stick_ratio[1] <= EXACT and slowest_ratio <= 1e-5
    )
    numbers_at_rest = {
        "stick before": stick_ratio[0],
        "slip after": 1 - stick_ratio[1],
        "speed before": slowest_ratio,
    }
    return judge(comes_to_rest), numbers_at_rest


def _residual_tractions(case: Case) -> Found:
    """Check what the paper states of the slip of the first cycle: the slip that stays locked in,
    and the tractions that the initial loading alone would not leave. Returns (verdict, numbers).
    `case` is the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)
    # P_Z and P_T: between their half-widths the slip that E leaves is locked in
    inner_load = formulas.initial_meeting(case.time("E"))
    outer_load = float(formulas.front("EG", case.time("G")))
    bounds_of_locked = case.width([inner_load, outer_load])
    shares = np.linspace(0.01, 0.99, 50)
    places_of_slip = np.concatenate(
        [
            bounds_of_locked[0] * shares,
            bounds_of_locked[0] + (bounds_of_locked[1] - bounds_of_locked[0]) * shares,
        ]
    )
    times = [case.time(letter) for letter in "BGM"]
    slip = case.solve(time=times, x=places_of_slip, fields=("slip",)).slip / (
        case.compliance * case.unit
    )
    locked_slip = np.abs(slip[1] - slip[0])
    later_change = float(np.max(np.abs(slip[2] - slip[1])))
    largest_within = float(np.max(locked_slip[:50]))
    least_locked = float(np.min(locked_slip[50:]))

    # At G: the engine's q without the hooks of reverse slip, and without what loading in stick to
    # P_T would have left.
    largest_half_width = float(case.width(case.events["G"].normal_load))
    places_of_shear = np.array(
        [
            0.0,
            bounds_of_locked[0],
            0.7 * bounds_of_locked[1] + 0.3 * largest_half_width,
            0.1 * bounds_of_locked[1] + 0.9 * largest_half_width,
        ]
    )
    shear = case.solve(time=[case.time("G")], x=places_of_shear, fields=("shear",)).shear[0]
    place_in_units = places_of_shear * case.length
    load_at_g = case.events["G"].normal_load
    pressure_hooks = case.contact.pressure(place_in_units, load_at_g) - case.contact.pressure(
        place_in_units, outer_load
    )
    residual = shear + case.friction * pressure_hooks - formulas.stuck(place_in_units, outer_load)
    scaled_residual = residual * case.length / case.unit
    share_at_centre = float(scaled_residual[0] / scaled_residual[1])
    largest_beyond = float(np.max(np.abs(scaled_residual[2:])))
    holds = max(largest_within, later_change, largest_beyond) <= _ROUNDING < least_locked
    return judge(holds and abs(share_at_centre) <= _ROUNDING, nearly=holds), {
        "a(P_Z)/a0": float(bounds_of_locked[0]),
        "a(P_T)/a0": float(bounds_of_locked[1]),
        "slip within a(P_Z)": largest_within,
        "slip beyond a(P_Z)": least_locked,
        "change in later cycles": later_change,
        "traction at the centre over that at a(P_Z)": share_at_centre,
        "traction beyond a(P_T)": largest_beyond,
    }


# ----------------------------------------------------------------------- stick, slip and separation
def course(case: Case) -> dict[str, Found]:
    """Check what the paper states of stick, slip and separation through the cycle, between events
    that it calls by the letters A to M. Returns name of a statement -> (verdict, numbers). `case`
    is the paper's ellipse of loads on one profile.
    """
    revolution = 2 * math.pi
    time_of = {letter: case.time(letter) for letter in LETTERS}
    depth_of_hold = _slip_depth(case, time_of["G"], time_of["I"])
    depth_of_forward_slip = _slip_depth(case, time_of["I"], time_of["M"])
    numbers_of_stick = {
        "deepest slip in G-I": float(depth_of_hold.max()),
        "least slip in I-M": float(depth_of_forward_slip.min()),
        "share of the cycle": (time_of["I"] - time_of["G"]) / revolution,
    }
    front_of_first_cycle = float(case.width(case.events["E"].front_load))
    front_in_reverse = float(case.width(case.events["G"].front_load))
    front_forward = float(case.width(case.events["M"].front_load))
    shares_of_cycle = {
        "forward": (time_of["M"] - time_of["I"]) / revolution,
        "reverse": (time_of["G"] - time_of["E"]) / revolution,
    }
    # From G of the first cycle on: the engine marches along it, later ones it looks up.
    slip = case.solve(
        time=time_of["G"] + np.linspace(0.0, revolution, 361), x=POINTS, fields=("slip",)
    ).slip
    relative_net_slip = float(np.max(np.abs(slip[-1] - slip[0])) / np.max(np.ptp(slip, axis=0)))
    return {
        "stick from G to I": (
            judge(depth_of_hold.max() <= _ROUNDING < depth_of_forward_slip.min()),
            numbers_of_stick,
        ),
        "transient slip": (
            judge(front_of_first_cycle < case.stick_edge),
            {"first cycle": front_of_first_cycle, "steady": case.stick_edge},
        ),
        "slip advances from B to E": _advance_of_slip(case, time_of["B"], time_of["E"]),
        "slip as deep forward as in reverse": (
            judge(abs(front_forward - front_in_reverse) <= _ROUNDING),
            {"forward": front_forward, "reverse": front_in_reverse},
        ),
        "longer in forward slip": (
            judge(shares_of_cycle["forward"] > shares_of_cycle["reverse"]),
            shares_of_cycle,
        ),
        "forward slip is slower": slip_speed(case),
        "permanent stick": (judge_number(case.stick_edge, 0.73, 2), {"a(P_T)/a0": case.stick_edge}),
        "no net displacement": (
            judge(relative_net_slip <= _ROUNDING),
            {"net over largest": relative_net_slip},
        ),
        **{f"history of x = {x}": _point_history(case, x) for x in POINTS},
        "one-way slip": one_way_slip(case),
    }


def _slip_depth(case: Case, start_time: float, end_time: float) -> Array:
    """Width of the slip zone at each edge, (a - c)/a0, at 201 instants between two times: the
    contact's half-width a less that of the stick zone, c, over a0 = a(P0).
    """
    zone = case.solve(time=np.linspace(start_time, end_time, 203)[1:-1])
    return np.asarray((zone.contact_half_width - zone.stick_half_width) / case.length)


def _advance_of_slip(case: Case, start_time: float, end_time: float) -> Found:
    """Statement that the stick zone shrinks from B to E (times `start_time` and `end_time`), while
    the contact grows from B to C. `case` is the paper's ellipse of loads on one profile.
    """
    stick_half_widths = (
        case.solve(time=np.linspace(start_time, end_time, 201)).stick_half_width / case.length
    )
    contact_half_widths = case.width([case.events[letter].normal_load for letter in "BC"])
    least_fall = float(np.min(-np.diff(stick_half_widths)))
    return judge(least_fall > 0 and contact_half_widths[1] > contact_half_widths[0]), {
        "least fall of c in a step": least_fall,
        "c at B": float(stick_half_widths[0]),
        "c at E": float(stick_half_widths[-1]),
        "a at B": float(contact_half_widths[0]),
        "a at C": float(contact_half_widths[1]),
    }


def slip_speed(case: Case, x: float = POINTS[0]) -> Found:
    """Check the paper's statement that forward slip is slower than reverse slip, at a point that is
    always in contact.

    The ratio of mean speeds, forward over reverse, is taken twice: over the time in which the point
    itself slips, and over the whole phase in which any point does. The paper's letters are events
    of the steady cycle: reverse slip begins at E and ends at G, forward slip begins at I and ends
    at M. Distances are over A P0/3, with A = 2/E* and the mean load P0; times over a cycle of 2 pi.

    `x` is in half-widths at the mean load. Returns (verdict, numbers). `case` is the paper's
    ellipse of loads on one profile.
    """
    edge_load = np.asarray(case.contact.load(np.array([x * case.length])))
    # of both: forward, reverse
    distance = np.zeros(2)
    duration = np.zeros(2)
    unit_of_slip = case.compliance * case.unit
    for span in chain.from_iterable(case.slipping.values()):
        start_time, end_time = (float(time[0]) for time in slip_times(span, edge_load))
        if end_time > start_time:
            index_of_direction = 0 if span.direction > 0 else 1
            # Times of a span are its load segment's own; on the load path they are later by the
            # delay, whole cycles.
            times_on_path = [start_time + span.delay, end_time + span.delay]
            slip = case.solve(time=times_on_path, x=[x], fields=("slip",)).slip[:, 0]
            distance[index_of_direction] += abs(float(slip[1] - slip[0])) / unit_of_slip
            duration[index_of_direction] += end_time - start_time
    duration_of_phases = np.array(
        [case.time("M") - case.time("I"), case.time("G") - case.time("E")]
    )
    ratio_in_slip = float(np.divide(*(distance / duration)))
    ratio_over_phases = float(np.divide(*(distance / duration_of_phases)))
    numbers = {
        "speeds while the point slips": ratio_in_slip,
        "speeds over the phases": ratio_over_phases,
        "distance forward": float(distance[0]),
        "distance reverse": float(distance[1]),
        "time forward": float(duration[0] / (2 * math.pi)),
        "time reverse": float(duration[1] / (2 * math.pi)),
    }
    verdict = judge(ratio_in_slip < 1 - _ROUNDING, nearly=ratio_over_phases < 1 - _ROUNDING)
    return verdict, numbers


def _point_history(case: Case, x: float) -> Found:
    """Check the paper's statement on the sequence of stick, slip and separation of a point of
    figure 5, at `x` half-widths. Returns (verdict, numbers). `case` is the paper's ellipse of loads
    on one profile.
    """
    times = case.round_times(1441)
    states = case.solve(time=(times[1:] + times[:-1]) / 2, x=[x], fields=("state",)).state[:, 0]
    names = _sequence([STATE_NAMES[SurfaceState(int(state))] for state in states])
    stated_sequence = _sequence(_HISTORIES[x])
    letter_of = {"stick": "S", "forward slip": "F", "reverse slip": "R", "open": "O"}
    letters = [letter_of[name] for name in names]
    # the cycle may begin anywhere
    stated_turns = [stated_sequence[k:] + stated_sequence[:k] for k in range(len(stated_sequence))]
    numbers = {
        "share of separation": float(np.mean(states == SurfaceState.OPEN)),
        "runs": len(names),
        "history": ", ".join(names).replace("open", "separation"),
    }
    return judge(letters in stated_turns), numbers


def _sequence(states: Sequence[str]) -> list[str]:
    """The runs of a closed cycle.

    >>> _sequence("SSFOS")
    ['S', 'F', 'O']
    """
    names = [name for name, _ in groupby(states)]
    return names[:-1] if len(names) > 1 and names[0] == names[-1] else names


def one_way_slip(case: Case) -> Found:
    """Check of the paper's statement on where slip is in one direction only: the |x|/a0, printed as
    0.88, beyond which reverse slip does no work. It is found by halving the zone of slip down.
    `case` is the paper's ellipse of loads on one profile.
    """
    inner_edge = case.stick_edge
    outer_edge = case.outer_edge
    for _ in range(5):
        trial_edges = np.linspace(inner_edge, outer_edge, 101)
        last_rubbed = np.flatnonzero(case.density(trial_edges)["EG"] > 0)[-1]
        inner_edge = float(trial_edges[last_rubbed])
        outer_edge = float(trial_edges[last_rubbed + 1])
    edge = (inner_edge + outer_edge) / 2
    largest_half_width = max(float(case.width(case.events[letter].normal_load)) for letter in "EG")
    return judge_number(edge, 0.88, 2), {"edge": edge, "largest a in E-G": largest_half_width}


# ------------------------------------------------------------------- other loads, the other profile
def loads(paper: Paper) -> dict[str, Found]:
    """Statements on what the zones of slip and the dissipation depend on: friction, mean shear
    force, initial loading, profile. Name of a statement -> (verdict, numbers). `paper` holds the
    paper's two profiles, with their solutions.
    """
    case = paper.hertz
    return {
        "friction delays slip": friction_delays_slip(case),
        "coefficients of figure 4b": sliding_coefficients(case),
        "mean shear force": no_effect_of_mean_shear(case),
        "initial loading": forgotten_loading(case),
        **bands_of_slip(case, paper.rounded),
    }


def friction_delays_slip(case: Case) -> Found:
    """Check the paper's statement on friction: the more there is, the later slip begins at the
    events E and I, and the later the slip of unloading ends, at G. Returns (verdict, numbers).
    `case` is the paper's ellipse of loads on one profile.
    """
    cases = [case.about_no_shear(f) for f in sorted(FRICTIONS)]
    times = {
        letter: np.array([case_of_friction.time(letter) for case_of_friction in cases])
        for letter in "EGI"
    }
    is_later = {
        letter: bool(np.all(np.diff(times_by_friction) > 0))
        for letter, times_by_friction in times.items()
    }
    shifts = {
        f"shift of {letter} in degrees": math.degrees(times_by_friction[-1] - times_by_friction[0])
        for letter, times_by_friction in times.items()
    }
    shifts["G earlier in degrees"] = -shifts["shift of G in degrees"]
    is_onset_later = is_later["E"] and is_later["I"]
    return judge(is_onset_later and is_later["G"], nearly=is_onset_later), shifts


def sliding_coefficients(case: Case) -> Found:
    """Check whether the contact slides as a whole at the coefficients of friction of the paper's
    figure 4b, with the mean shear force of the cycle and without any. Returns (verdict, numbers).
    `case` is the paper's ellipse of loads on one profile.
    """
    frictions = np.array(FRICTIONS)
    mean_shear = case.load.mean_tangential_load
    arguments = case.batch(
        friction_coefficient=frictions, mean_tangential_load=mean_shear * np.array([[1.0], [0.0]])
    )
    reasons = semi_analytic.dissipation(**arguments).reason
    slides_with_mean, slides_without = reasons == semi_analytic.Reason.SLIDING
    numbers = {
        "sliding with Q0": int(slides_with_mean.sum()),
        "sliding with Q0 = 0": int(slides_without.sum()),
        "Q0": mean_shear / case.unit,
        "which slide": ", ".join(f"{f:g}" for f in frictions[slides_with_mean]),
    }
    return judge(not slides_with_mean.any(), nearly=not slides_without.any()), numbers


def no_effect_of_mean_shear(case: Case) -> Found:
    """Check the paper's statement that neither stick zone nor dissipation depends on the mean shear
    force, with three other mean forces. Returns (verdict, numbers). `case` is the paper's ellipse
    of loads on one profile.
    """
    cases = [
        case.with_load(mean_tangential_load=force * case.unit, initial_loading="straight")
        for force in (-1.0, 0.0, 0.5)
    ]
    changes = _changes(case, cases)
    return judge(max(changes.values()) <= _ROUNDING), changes


def forgotten_loading(case: Case) -> Found:
    """Check the paper's statement that the steady cycle forgets the initial loading but for the
    shear inside the permanent stick zone, with two other initial loadings. Returns (verdict,
    numbers). `case` is the paper's ellipse of loads on one profile.
    """
    corners = tuple((p * case.unit, q * case.unit) for p, q in ((1.0, 0.5), (2.0, -0.5)))
    cases = [case.with_load(initial_loading=loading) for loading in ("straight", corners)]
    changes = _changes(case, cases)

    def shear(chosen_case: Case, x: Array) -> Array:
        """Shear a cycle after the end M of forward slip, over the unit of load and length."""
        time = [chosen_case.time("M") + 2 * math.pi]
        solution = chosen_case.solve(time=time, x=x, fields=("shear",))
        return np.asarray(solution.shear * case.length / case.unit)

    def change_of_shear(x: Array) -> float:
        return max(
            float(np.max(np.abs(shear(loading_case, x) - shear(case, x)))) for loading_case in cases
        )

    change_inside = change_of_shear(np.linspace(0, case.stick_edge * 0.999, 50))
    change_outside = change_of_shear(np.linspace(case.stick_edge * 1.001, case.outer_edge, 50))
    is_forgotten = max(changes.values()) <= _ROUNDING and change_outside <= _ROUNDING
    changes_of_shear = {"change of q inside": change_inside, "change of q outside": change_outside}
    return judge(is_forgotten and change_inside > _ROUNDING), changes | changes_of_shear


def bands_of_slip(hertz: Case, rounded: Case) -> dict[str, Found]:
    """Check what the paper states of the flat and rounded profile beside the parabola (`hertz`): it
    slips on its rounded edges alone, and in narrower bands. Returns name of a statement ->
    (verdict, numbers).
    """
    flat_half_width = float(rounded.width(0.0))
    width_of_hertz = hertz.outer_edge - hertz.stick_edge
    width_of_rounded = rounded.outer_edge - rounded.stick_edge
    return {
        "slip in the radii": (
            judge(rounded.stick_edge > flat_half_width),
            {"a(P_T)/a0": rounded.stick_edge, "b/a0": flat_half_width},
        ),
        "narrow bands": (
            judge(width_of_rounded < width_of_hertz),
            {"hertz": width_of_hertz, "flat and rounded": width_of_rounded},
        ),
    }


def _changes(case: Case, changed_cases: Sequence[Case]) -> dict[str, float]:
    """Largest changes that some variants of a case (`changed_cases`) make: of the stick half-width
    through the cycle, and of the dissipation W, taken as the closed integral of Q dU, which depends
    on the mean shear force. `case` is the paper's ellipse of loads on one profile.
    """

    def stick_half_widths_of(chosen_case: Case) -> Array:
        return (
            chosen_case.solve(time=chosen_case.round_times(73)).stick_half_width
            / chosen_case.length
        )

    stick_of_case = stick_half_widths_of(case)
    work_of_case = case.steady.loop_work
    zone_changes = []
    work_changes = []
    for changed_case in changed_cases:
        zone_changes.append(
            float(np.max(np.abs(stick_half_widths_of(changed_case) - stick_of_case)))
        )
        work_changes.append(abs(changed_case.steady.loop_work / work_of_case - 1))
    return {"change of c": max(zone_changes), "change of W": max(work_changes)}


# --------------------------------------------------------------------------------- work of friction
def work(case: Case) -> dict[str, Found]:
    """Check what the paper states of the dissipation: the phases' shares, and W(x) at the ends of
    the slip zone. Returns name of a statement -> (verdict, numbers). `case` is the paper's ellipse
    of loads on one profile.
    """
    batch = semi_analytic.dissipation(**case.batch())
    inner_edge = case.stick_edge
    outer_edge = case.outer_edge
    forward_share = float(batch.forward / batch.value)
    shares = {"share of forward slip": forward_share, "share of reverse slip": 1 - forward_share}
    shares_of_zone = np.array([-0.5, -1e-9, 0.5, 1 - 1e-9])
    places = inner_edge + (outer_edge - inner_edge) * shares_of_zone
    values = total(case.density(places)).tolist()
    work_of_stuck = max(values[:2])
    value_in_middle = values[2]
    value_at_edge = values[3]
    numbers_at_ends = {
        "largest at the ends over mid-zone": max(work_of_stuck, value_at_edge) / value_in_middle,
        "in the stick zone": work_of_stuck,
    }

    def exponent(origin: float, sense: float) -> float:
        """The power of the distance from an end of the slip zone (`origin`) with which W(x) grows:
        d ln W / d ln(distance), close to it. `sense` is 1 to the right of the end, −1 to the left.
        """
        distance = (outer_edge - inner_edge) * np.array([1e-6, 1e-5])
        density = total(case.density(origin + sense * distance))
        return float(np.diff(np.log(density))[0] / np.diff(np.log(distance))[0])

    exponent_at_stick = exponent(inner_edge, 1.0)
    exponent_at_edge = exponent(outer_edge, -1.0)
    return {
        "most work in forward slip": (
            judge(forward_share > 0.75, nearly=forward_share > 0.5),
            shares,
        ),
        "no work at the ends": (
            judge(
                work_of_stuck == 0 and max(work_of_stuck, value_at_edge) / value_in_middle < 1e-6
            ),
            numbers_at_ends | {"at the outer edge over mid-zone": value_at_edge / value_in_middle},
        ),
        "slope at the stick edge": (
            judge(exponent_at_stick > 1 + _EXPONENT_SLACK),
            {"exponent": exponent_at_stick},
        ),
        "slope at the outer edge": (
            judge(abs(exponent_at_edge - 1) <= _EXPONENT_SLACK),
            {"exponent": exponent_at_edge},
        ),
        "root at the outer edge": (
            judge(
                abs(exponent_at_edge - 0.5) <= _EXPONENT_SLACK,
                nearly=abs(exponent_at_edge - 0.5) <= 0.1,
            ),
            {"exponent": exponent_at_edge},
        ),
    }


_NAMES = ("Hertz", "flat and rounded")


def _comparisons(paper: Paper) -> dict[str, Found]:
    """Peaks, the sweeps over P0/P1 and f, and the flat and rounded contact beside Hertz at equal
    loads, f, material and a0.
    """
    return (
        _places_of_peaks(paper)
        | _falls_towards_far_loads(paper)
        | _flat_over_hertz(paper)
        | {"weaker dependence of the peak": _dependence_of_the_peak(paper)}
    )


def _places_of_peaks(paper: Paper) -> dict[str, Found]:
    """Statements on where the pointwise dissipation is largest, as a fraction of the way from the
    stick edge to the contact edge. `paper` holds the paper's two profiles, with their solutions.
    """
    statements: dict[str, Found] = {}
    cases = (paper.hertz, paper.rounded)
    for name, case, peak in zip(_NAMES, cases, paper.peaks, strict=True):
        fraction = float(peak.fraction)
        numbers = {"fraction": fraction, "x/a0": float(peak.place) / case.length}
        verdict = judge(0.6 < fraction < 0.65, nearly=abs(fraction - 0.6) < 0.02)
        statements[f"place of the peak, {name}"] = (verdict, numbers)
    fractions_at_ends = {}
    for name, sweep in zip(_NAMES, paper.sweeps, strict=True):
        fractions_at_ends[f"{name}, near"] = float(sweep.place[0, 0])
        fractions_at_ends[f"{name}, far"] = float(sweep.place[0, -1])
    as_stated = all(0.6 < fraction < 0.65 for fraction in fractions_at_ends.values())
    nearly_as_stated = all(0.55 < fraction < 0.7 for fraction in fractions_at_ends.values())
    statements["place of the peak, all loads"] = (
        judge(as_stated, nearly_as_stated),
        fractions_at_ends,
    )
    return statements


def _exponents(sweep: Sweep, quantity: str) -> Array:
    """Exponent n of a quantity that goes as P0^n, P0 the mean normal load, between neighbouring
    values of P0: (m, k - 1) for a sweep of (m, k) loads at constant half-width a(P0).
    """
    growth = np.diff(np.log(getattr(sweep, quantity)), axis=1)
    return np.asarray(growth / np.diff(np.log(sweep.ratio), axis=1))


def _falls_towards_far_loads(paper: Paper) -> dict[str, Found]:
    """Check what the paper states of the work, its peak over x and their quotient, from loads near
    gross sliding to loads far from it. Returns name of a statement -> (verdict, numbers). `paper`
    holds the paper's two profiles, with their solutions.
    """
    hertz = paper.sweeps[0]
    largest_rise = {}
    falls = {}
    for quantity in ("work", "peak"):
        rises_of_sweeps = [np.diff(getattr(sweep, quantity), axis=1) for sweep in paper.sweeps]
        largest_rise[quantity] = max(float(np.max(rises)) for rises in rises_of_sweeps)
        near_and_far = getattr(hertz, quantity)[0, [0, -1]]
        falls[f"fall of {quantity}"] = float(near_and_far[0] / near_and_far[1])
    # At constant R, a grows like sqrt(P0).
    exponents_of_peak = _exponents(hertz, "peak") - 0.5
    least_gap = float(np.min(exponents_of_peak - _exponents(hertz, "work")))
    merits = [sweep.work / sweep.peak for sweep in paper.sweeps]
    best_columns = {int(column) for merit in merits for column in np.argmax(merit, axis=1)}
    return {
        "global dissipation before sliding": (
            judge(largest_rise["work"] < 0),
            {"largest step": largest_rise["work"]},
        ),
        "peak before sliding": (
            judge(largest_rise["peak"] < 0),
            {"largest step": largest_rise["peak"]},
        ),
        "work falls faster than its peak": (
            judge(least_gap > 0),
            falls | {"least gap of exponents": least_gap},
        ),
        "best designs close to sliding": (
            judge(best_columns == {0}),
            {"near": float(merits[0][0, 0]), "far": float(merits[0][0, -1])},
        ),
    }


def _flat_over_hertz(paper: Paper) -> dict[str, Found]:
    """Check what the paper states of the flat and rounded contact beside the Hertz contact: how
    many times its dissipation W, and the peak of W(x) over x, are those of Hertz. Returns name of a
    statement -> (verdict, numbers). `paper` holds the paper's two profiles, with their solutions.
    """
    hertz_sweep, rounded_sweep = paper.sweeps
    cases = (paper.hertz, paper.rounded)
    works = [case.steady.dissipation / case.work_unit for case in cases]
    peaks = [
        float(peak.value) * case.length / case.work_unit
        for case, peak in zip(cases, paper.peaks, strict=True)
    ]
    quotient_of_works = works[1] / works[0]
    quotient_of_peaks = peaks[1] / peaks[0]
    return {
        "five times the energy": (
            judge_number(quotient_of_works, 5, 0, slack=0.2),
            {"quotient of work": quotient_of_works} | _span(rounded_sweep.work / hertz_sweep.work),
        ),
        "eight times the peak": (
            judge_number(quotient_of_peaks, 8, 0, slack=0.2),
            {"quotient of peaks": quotient_of_peaks} | _span(rounded_sweep.peak / hertz_sweep.peak),
        ),
        "figure of merit": (
            judge(quotient_of_works < quotient_of_peaks),
            {
                "quotient of merits": quotient_of_works / quotient_of_peaks,
                "five over eight": 5 / 8,
            },
        ),
    }


def _span(quotients: Array) -> dict[str, float]:
    """Least and largest."""
    return {"least": float(quotients.min()), "largest": float(quotients.max())}


def _dependence_of_the_peak(paper: Paper) -> Found:
    """Judge the paper's statement that the largest W(x) of the flat and rounded contact falls less
    with the mean normal load P0 than that of the Hertz contact.

    The numbers returned with the verdict also show where along x that largest value lies: it jumps
    from the inner to the outer shoulder of W(x) as P0 grows. `paper` holds sweeps of both profiles
    over P0 in units of the amplitude P1, each (m, k): friction along rows, P0/P1 along columns.
    """
    hertz_sweep, rounded_sweep = paper.sweeps
    # At constant P0 the peak goes as (P1/P0)^2 times what the sweep has at constant P1.
    fall_of_hertz = hertz_sweep.peak[:, 0] / hertz_sweep.peak[:, -1]
    fall_of_rounded = rounded_sweep.peak[:, 0] / rounded_sweep.peak[:, -1]
    # the exponents are negative: the larger one is that of the weaker fall
    falls_less = _exponents(rounded_sweep, "peak") > _exponents(hertz_sweep, "peak")
    share_that_falls_less = float(np.mean(falls_less))
    ratio = rounded_sweep.ratio[-1]
    place = rounded_sweep.place[-1]
    column_before_jump = int(np.argmax(np.abs(np.diff(place))))
    numbers = {
        "fall, hertz": float(fall_of_hertz[0]),
        "fall, flat and rounded": float(fall_of_rounded[0]),
        "share of smaller exponents": share_that_falls_less,
        "last shoulder": float(ratio[column_before_jump]),
        "first outer one": float(ratio[column_before_jump + 1]),
        "first place": float(place[0]),
        "last place": float(place[column_before_jump]),
        "place of the outer one": float(place[column_before_jump + 1]),
    }
    is_true = bool(np.all(fall_of_rounded < fall_of_hertz)) and share_that_falls_less == 1
    return judge(is_true), numbers
