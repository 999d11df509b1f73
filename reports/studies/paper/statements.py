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
    sum_over_phases,
)
from reports.studies.paper.tables import (
    AGREEMENT_TOLERANCE,
    VerdictAndNumbers,
    verdict_of_condition,
    verdict_of_number,
)
from scenes import SurfaceState
from scenes.array_types import Array
from semi_analytic.friction_work import slip_times

# Scaled values up to this differ by round-off only.
_ROUNDING_ERROR = 1e-10
# Tolerance of an exponent that is measured between two points.
_EXPONENT_TOLERANCE = 0.01
# x/a0 of the points at which tractions are compared, from the centre to near the largest contact.
_SHEAR_POINTS = (0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.9, 1.0, 1.1)
# What the text gives for its four points: S stick, F forward slip, R reverse slip, O separation.
_STATED_HISTORIES = {0.77: "SRSF", 0.82: "SRORSF", 1.0: "OSFO", 1.13: "OFO"}


def judge_statements(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """All statements of the paper, judged by computing: key of a statement -> (verdict, numbers).
    `paper` holds the paper's two profiles, with their solutions.
    """
    return (
        statements_on_tractions(paper.hertz_case)
        | statements_on_cycle(paper.hertz_case)
        | statements_on_loads(paper)
        | statements_on_work(paper.hertz_case)
        | _statements_on_comparison(paper)
    )


# --------------------------------------------------------------------- tractions of the first cycle
def statements_on_tractions(case: Case) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states of the shear traction in the first cycle, against half-plane
    theory. This concerns its equations (5) in full stick, (6) in forward and (7) in reverse slip,
    full stick just after event E (end of forward slip), and the tractions that the cycle leaves.

    `case` is the paper's ellipse of loads on one profile. Returns name of a statement ->
    (verdict, numbers).
    """
    return {
        "(5)": _shear_in_stick(case),
        "(6)": _shear_in_forward_slip(case),
        "full stick at E": _rest_at_e(case),
        "(7)": _shear_in_reverse_slip(case),
        "residual tractions": _residual_tractions(case),
    }


def _error_of_shear(case: Case, time: float, shear_by_formula: Array) -> float:
    """Relative error of a formula's shear traction at the instant `time`: its largest difference
    from half-plane theory's shear (the engine's), over the largest of the latter.
    `shear_by_formula` (n,) is given at the n points of `_SHEAR_POINTS`.
    """
    engine_shear = case.solve(time=[time], x=_SHEAR_POINTS, fields=("shear",)).shear[0]
    largest_difference = np.max(np.abs(shear_by_formula - engine_shear))
    return float(largest_difference / np.max(np.abs(engine_shear)))


def _shear_in_stick(case: Case) -> VerdictAndNumbers:
    """Check the paper's equation (5), the shear traction of full stick, against the engine, which
    solves the problem by half-plane theory.

    The paper's letters are events of the first cycle: A its start, B the end of full stick, C the
    largest normal load. The verdict is "confirmed" if the equation holds at A, at B and halfway
    from B to C, where the normal load still grows but the edges slip; "refined" if at A and B only.

    `case` is the paper's ellipse of loads on one profile: `unit_length` is the contact half-width
    at the mean load. Returns (verdict, relative errors).
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    # _SHEAR_POINTS: points from the centre to near the largest contact, in that unit
    x = np.array(_SHEAR_POINTS) * case.unit_length

    def error_at_time(time: float) -> float:
        """Relative error of equation (5) at an instant, largest over the points."""
        normal_load = float(formulas.loads(time)[0])
        return _error_of_shear(case, time, formulas.shear_of_full_stick(x, normal_load))

    error_in_stick = max(error_at_time(case.time_of("A")), error_at_time(case.time_of("B")))
    error_in_slip = error_at_time((case.time_of("B") + case.time_of("C")) / 2)
    # AGREEMENT_TOLERANCE: relative error 1e-9
    verdict = verdict_of_condition(
        max(error_in_stick, error_in_slip) <= AGREEMENT_TOLERANCE,
        nearly_holds=error_in_stick <= AGREEMENT_TOLERANCE,
    )
    return verdict, {"error in full stick": error_in_stick, "error in slip": error_in_slip}


def _shear_in_forward_slip(case: Case) -> VerdictAndNumbers:
    """Check the paper's equation (6), the shear traction during the forward slip of the first
    cycle, at four instants: q = q_Y + f (p(P) - p(P_Y)).

    # notation: p(P) the pressure under the normal load P; q_Y the shear of full stick up to the
    #           load P_Y, at which the line of gradient f through the loads meets the path of full
    #           stick (initial loading, and the ellipse up to B)

    The letters are events: slip begins at B, P is largest at C and Q at D, slip ends at E. `case`
    is the paper's ellipse of loads on one profile: `contact` is its normal contact, `unit_length`
    the contact half-width at the mean load. Returns (verdict, largest relative errors), the verdict
    being "confirmed" or "contradicted".
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    # _SHEAR_POINTS: points from the centre to near the largest contact, in that unit
    x = np.array(_SHEAR_POINTS) * case.unit_length
    pressure = case.contact.pressure  # a function of place and normal load
    instants = {
        "B-C": (case.time_of("B") + case.time_of("C")) / 2,
        "C": case.time_of("C"),
        "D": case.time_of("D"),
        "E": case.time_of("E"),
    }
    errors = {}
    for name, time in instants.items():
        normal_load = float(formulas.loads(time)[0])
        load_at_y = formulas.intersection_with_initial_loading(time)
        pressure_since_y = pressure(x, normal_load) - pressure(x, load_at_y)
        shear_by_6 = formulas.shear_of_full_stick(x, load_at_y) + case.friction * pressure_since_y
        # largest difference from half-plane theory's shear over all points, relative
        errors[f"error at {name}"] = _error_of_shear(case, time, shear_by_6)
    # AGREEMENT_TOLERANCE: 1e-9
    largest_error = max(errors.values())
    return verdict_of_condition(largest_error <= AGREEMENT_TOLERANCE), errors | {
        "largest error": largest_error
    }


def _shear_in_reverse_slip(case: Case) -> VerdictAndNumbers:
    """Check the paper's equation (7), the shear traction during reverse slip, at three instants:
    q = q_Z + f (2 p(P_c) - p(P) - p(P_Z)).

    # notation: p(P) the pressure under the normal load P; P_c the load at which the contact is as
    #           wide as the stick zone now is; q_Z the shear of full stick up to the load P_Z, at
    #           which the line of gradient f through the loads at E meets the initial loading

    The letters are events: reverse slip begins at E, P is least at F, reverse slip ends at G.
    `case` is the paper's ellipse of loads on one profile: `contact` is its normal contact,
    `unit_length` the contact half-width at the mean load. Returns (verdict, largest relative
    errors), the verdict being "confirmed" or "contradicted".
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    # _SHEAR_POINTS: points from the centre to near the largest contact, in that unit
    x = np.array(_SHEAR_POINTS) * case.unit_length
    pressure = case.contact.pressure  # a function of place and normal load
    load_at_z = formulas.intersection_with_initial_loading(case.time_of("E"))
    instants = {
        "E-F": (case.time_of("E") + case.time_of("F")) / 2,
        "F": case.time_of("F"),
        "G": case.time_of("G"),
    }
    errors = {}
    for name, time in instants.items():
        normal_load = float(formulas.loads(time)[0])
        stick_edge_load = float(formulas.stick_edge_load("EG", time))  # P_c
        sum_of_pressures = (2 * pressure(x, stick_edge_load) - pressure(x, normal_load)) - pressure(
            x, load_at_z
        )
        shear_by_7 = formulas.shear_of_full_stick(x, load_at_z) + case.friction * sum_of_pressures
        # largest difference from half-plane theory's shear over all points, relative
        errors[f"error at {name}"] = _error_of_shear(case, time, shear_by_7)
    # AGREEMENT_TOLERANCE: 1e-9
    largest_error = max(errors.values())
    return verdict_of_condition(largest_error <= AGREEMENT_TOLERANCE), errors | {
        "largest error": largest_error
    }


def _rest_at_e(case: Case) -> VerdictAndNumbers:
    """Check the paper's statement on the event E, at which the forward slip of the first cycle
    ends: all points come to rest, and reverse slip then starts from the edges.

    Just before E a part of the contact must slip, just after E almost none. Two points of the slip
    zone (x/a0 = 0.8 and 0.85, a0 the contact half-width at the mean load) must be slow just before
    E, compared with their mean speed since slip began at B.

    `case` is the paper's ellipse of loads on one profile; `case.solve` is its half-plane solution
    at instants [rad] and at places x/a0. Returns (verdict, numbers), the verdict being "confirmed"
    or "contradicted".
    """
    time_of_b = case.time_of("B")
    time_of_e = case.time_of("E")
    time_step = 1e-6

    # the stick zone just before and just after E, as a fraction of the contact
    solution_around_e = case.solve(time=[time_of_e - time_step, time_of_e + time_step])
    stick_ratio_before, stick_ratio_after = (
        solution_around_e.stick_half_width / solution_around_e.contact_half_width
    ).tolist()

    # speed of slip at both points, (2,) each
    slip_at_b, slip_before_e, slip_at_e = case.solve(
        time=[time_of_b, time_of_e - time_step, time_of_e], x=[0.8, 0.85], fields=("slip",)
    ).slip
    speed_before_e = (slip_at_e - slip_before_e) / time_step
    mean_speed = (slip_at_e - slip_at_b) / (time_of_e - time_of_b)
    largest_speed_ratio = float(np.max(speed_before_e / mean_speed))

    # AGREEMENT_TOLERANCE: 1e-9
    comes_to_rest = (
        stick_ratio_before < 1 - AGREEMENT_TOLERANCE
        and 1 - stick_ratio_after <= AGREEMENT_TOLERANCE
        and largest_speed_ratio <= 1e-5
    )
    numbers = {
        "stick before": stick_ratio_before,
        "slip after": 1 - stick_ratio_after,
        "speed before": largest_speed_ratio,
    }
    return verdict_of_condition(comes_to_rest), numbers


def _residual_tractions(case: Case) -> VerdictAndNumbers:
    """Check what the paper states of the slip of the first cycle: that slip stays locked in between
    the half-widths a(P_Z) and a(P_T), and residual tractions with it.

    # notation: P_Z the load at which the line of gradient f through the loads at E (end of forward
    #           slip) meets the initial loading; P_T the load whose half-width is that of the
    #           permanent stick zone; B begin of forward slip, G end of reverse slip, M end of the
    #           second forward slip

    The verdict is "confirmed" if both are as stated, "refined" if the slip is, but tractions remain
    at the centre too. `case` is the paper's ellipse of loads on one profile; half-widths and places
    are over a0, the contact half-width at the mean load. Returns (verdict, numbers).
    """
    # Formulas(case): the paper's equations, with their misprints mended
    load_at_z = Formulas(case).intersection_with_initial_loading(case.time_of("E"))
    # the load whose contact is the stick zone, where reverse slip E-G ends
    load_at_t = float(Formulas(case).stick_edge_load("EG", case.time_of("G")))
    half_width_z, half_width_t = case.scaled_half_width([load_at_z, load_at_t])

    # slip gained from B to G: largest within a(P_Z), least from there to a(P_T); change from G to M
    slip_numbers = _slip_of_first_cycle(case, half_width_z, half_width_t)

    # residual traction at the centre, at a(P_Z), and at two points between a(P_T) and the contact
    # edge of G
    half_width_g = case.half_width_at("G")
    x = np.array(
        [
            0.0,
            half_width_z,
            0.7 * half_width_t + 0.3 * half_width_g,
            0.1 * half_width_t + 0.9 * half_width_g,
        ]
    )
    traction = _residual_traction_at_g(case, x, load_at_t)
    centre_over_z = float(traction[0] / traction[1])
    largest_beyond_t = float(np.max(np.abs(traction[2:])))

    # what the statement says is zero; _ROUNDING_ERROR: 1e-10
    largest_of_zeros = max(
        slip_numbers["slip within a(P_Z)"],
        slip_numbers["change in later cycles"],
        largest_beyond_t,
    )
    slip_is_as_stated = largest_of_zeros <= _ROUNDING_ERROR < slip_numbers["slip beyond a(P_Z)"]
    centre_is_without_traction = abs(centre_over_z) <= _ROUNDING_ERROR
    return verdict_of_condition(
        slip_is_as_stated and centre_is_without_traction, nearly_holds=slip_is_as_stated
    ), {
        "a(P_Z)/a0": float(half_width_z),
        "a(P_T)/a0": float(half_width_t),
        **slip_numbers,
        "traction at the centre over that at a(P_Z)": centre_over_z,
        "traction beyond a(P_T)": largest_beyond_t,
    }


def _slip_of_first_cycle(case: Case, half_width_z: float, half_width_t: float) -> dict[str, float]:
    """Slip that points gain in the first cycle, from the begin of slip (event B) to the end of
    reverse slip (G). The numbers are its largest size at 0 < x < `half_width_z`, its least from
    there to `half_width_t`, and the largest change of slip from G to the end of the second forward
    slip (M).

    `half_width_z` is a(P_Z), up to which no slip stays, and `half_width_t` is a(P_T), that of the
    permanent stick zone. Both are over a0, the contact half-width at the mean normal load P0. The
    slips are over A P0/3 (`case.unit_slip`), with A = 2/E*. `case` is the paper's ellipse of loads
    on one profile.
    """
    # 50 points within a(P_Z), and 50 between a(P_Z) and a(P_T)
    fractions = np.linspace(0.01, 0.99, 50)
    x_within = half_width_z * fractions
    x_beyond = half_width_z + (half_width_t - half_width_z) * fractions
    slip_at_b, slip_at_g, slip_at_m = (
        case.solve(
            time=[case.time_of(letter) for letter in "BGM"],
            x=np.concatenate([x_within, x_beyond]),
            fields=("slip",),
        ).slip
        / case.unit_slip
    )
    locked_slip = np.abs(slip_at_g - slip_at_b)
    return {
        "slip within a(P_Z)": float(np.max(locked_slip[:50])),
        "slip beyond a(P_Z)": float(np.min(locked_slip[50:])),
        "change in later cycles": float(np.max(np.abs(slip_at_m - slip_at_g))),
    }


def _residual_traction_at_g(case: Case, x: Array, load_at_t: float) -> Array:
    """Residual shear traction at the event G (end of reverse slip) at points `x` (n,) over a0,
    times a0/(P0/3): half-plane theory's q + f (p(P_G) - p(P_T)) - q_T, (n,).

    Two known parts are taken off: the traction of reverse slip, and q_T, what loading in full stick
    up to P_T (`load_at_t`) alone leaves.

    # notation: a0 contact half-width at the mean load P0; p(P) pressure under the normal load P;
    #           P_G the load at G; P_T that whose contact is the permanent stick zone; f friction

    `case` is the paper's ellipse of loads on one profile: `unit_length` is a0, `unit_load` P0/3.
    """
    shear = case.solve(time=[case.time_of("G")], x=x, fields=("shear",)).shear[0]
    places = x * case.unit_length
    load_at_g = case.events["G"].normal_load
    pressure_since_t = case.contact.pressure(places, load_at_g) - case.contact.pressure(
        places, load_at_t
    )
    # q_T; Formulas: the paper's equations
    shear_of_stick = Formulas(case).shear_of_full_stick(places, load_at_t)
    residual = shear + case.friction * pressure_since_t - shear_of_stick
    return np.asarray(residual * case.unit_length / case.unit_load)


# ----------------------------------------------------------------------- stick, slip and separation
def statements_on_cycle(case: Case) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states of stick, slip and separation through the cycle, between events
    that it calls by the letters A to M. Returns name of a statement -> (verdict, numbers).

    B: begin of slip in the first cycle; from E to G reverse slip, from G to I full stick, from I to
    M forward slip. `case` is the paper's ellipse of loads on one profile; its half-widths, and the
    points x of figure 5 (`POINTS`), are over a0, the contact half-width at the mean load.
    """
    revolution = 2 * math.pi  # period of the loads
    # LETTERS: A to M
    time_by_letter = {letter: case.time_of(letter) for letter in LETTERS}

    # width of the slip zone at many instants of the phases G-I and I-M, over a0
    slip_width_in_stick = _slip_zone_width(case, time_by_letter["G"], time_by_letter["I"])
    slip_width_in_slip = _slip_zone_width(case, time_by_letter["I"], time_by_letter["M"])
    numbers_of_stick = {
        "deepest slip in G-I": float(slip_width_in_stick.max()),
        "least slip in I-M": float(slip_width_in_slip.min()),
        "share of the cycle": (time_by_letter["I"] - time_by_letter["G"]) / revolution,
    }

    # least half-widths of the stick zone: where slip ends; `front_load` is the normal load whose
    # contact is the stick zone
    stick_edge_at_e, stick_edge_at_g, stick_edge_at_m = (
        float(case.scaled_half_width(case.events[letter].front_load)) for letter in "EGM"
    )
    forward_duration = (time_by_letter["M"] - time_by_letter["I"]) / revolution
    reverse_duration = (time_by_letter["G"] - time_by_letter["E"]) / revolution

    # Each statement with its verdict and numbers. _ROUNDING_ERROR: 1e-10. A number that the paper
    # prints (0.73, to 2 decimals) is confirmed if half-plane theory's rounds to it.
    return {
        "stick from G to I": (
            verdict_of_condition(
                slip_width_in_stick.max() <= _ROUNDING_ERROR < slip_width_in_slip.min()
            ),
            numbers_of_stick,
        ),
        "transient slip": (
            verdict_of_condition(stick_edge_at_e < case.permanent_stick_half_width),
            {"first cycle": stick_edge_at_e, "steady": case.permanent_stick_half_width},
        ),
        "slip advances from B to E": _advance_of_slip(
            case, time_by_letter["B"], time_by_letter["E"]
        ),
        "slip as deep forward as in reverse": (
            verdict_of_condition(abs(stick_edge_at_m - stick_edge_at_g) <= _ROUNDING_ERROR),
            {"forward": stick_edge_at_m, "reverse": stick_edge_at_g},
        ),
        "longer in forward slip": (
            verdict_of_condition(forward_duration > reverse_duration),
            {"forward": forward_duration, "reverse": reverse_duration},
        ),
        "forward slip is slower": slip_speed(case),
        "permanent stick": (
            verdict_of_number(case.permanent_stick_half_width, 0.73, 2),
            {"a(P_T)/a0": case.permanent_stick_half_width},
        ),
        "no net displacement": _net_slip_of_cycle(case),
        **{f"history of x = {x}": _point_history(case, x) for x in POINTS},
        "one-way slip": one_way_slip(case),
    }


def _net_slip_of_cycle(case: Case) -> VerdictAndNumbers:
    """Check the paper's statement that a cycle leaves no net slip at the four points of figure 5.
    The net slip is divided by the largest range of slip. `case` is the paper's ellipse of loads on
    one profile. Returns (verdict, numbers), the verdict being "confirmed" or "contradicted".
    """
    # One period from event G (end of reverse slip) of the first cycle on: half-plane theory
    # computes it instant by instant, and takes later cycles from it.
    times = case.time_of("G") + np.linspace(0.0, 2 * math.pi, 361)
    # POINTS: x over the contact half-width at the mean load; slip (361, 4)
    slip = case.solve(time=times, x=POINTS, fields=("slip",)).slip
    # _ROUNDING_ERROR: 1e-10
    relative_net_slip = float(np.max(np.abs(slip[-1] - slip[0])) / np.max(np.ptp(slip, axis=0)))
    return verdict_of_condition(relative_net_slip <= _ROUNDING_ERROR), {
        "net over largest": relative_net_slip
    }


def _slip_zone_width(case: Case, start_time: float, end_time: float) -> Array:
    """Width of the slip zone at each edge, (a - c)/a0, (201,) at instants between two times: the
    contact's half-width a minus that of the stick zone, c, over a0 = a(P0).
    """
    solution = case.solve(time=np.linspace(start_time, end_time, 203)[1:-1])
    slip_zone_width = solution.contact_half_width - solution.stick_half_width
    return np.asarray(slip_zone_width / case.unit_length)


def _advance_of_slip(case: Case, start_time: float, end_time: float) -> VerdictAndNumbers:
    """Check the paper's statement that the stick zone shrinks all the way from the event B to E
    (times `start_time` and `end_time`), although the contact grows from B to C. B is the begin of
    slip, C the largest normal load, E the end of forward slip.

    Half-widths are over a0, the contact half-width at the mean load: c of the stick zone, a of the
    contact. `case` is the paper's ellipse of loads on one profile. Returns (verdict, numbers), the
    verdict being "confirmed" or "contradicted".
    """
    times = np.linspace(start_time, end_time, 201)
    stick_half_widths = case.solve(time=times).stick_half_width / case.unit_length
    least_fall = float(np.min(-np.diff(stick_half_widths)))  # between neighbouring instants
    contact_half_width_at_b = case.half_width_at("B")
    contact_half_width_at_c = case.half_width_at("C")
    return verdict_of_condition(
        least_fall > 0 and contact_half_width_at_c > contact_half_width_at_b
    ), {
        "least fall of c in a step": least_fall,
        "c at B": float(stick_half_widths[0]),
        "c at E": float(stick_half_widths[-1]),
        "a at B": contact_half_width_at_b,
        "a at C": contact_half_width_at_c,
    }


def slip_speed(case: Case, x: float = POINTS[0]) -> VerdictAndNumbers:
    """Check the paper's statement that forward slip is slower than reverse slip, at a point that is
    always in contact.

    The ratio of mean speeds, forward over reverse, is taken twice: over the time in which the point
    itself slips, and over the whole phase in which any point does. The paper's letters are events
    of the steady cycle: reverse slip begins at E and ends at G, forward slip begins at I and ends
    at M. Distances of slip are over A P0/3, with A = 2/E* and the mean load P0; the durations that
    are returned are over the period 2 pi.

    `x` is over the half-width a0 at the mean load (`case.unit_length`). The verdict is "confirmed"
    if the statement holds for the point itself, "refined" if for the whole phases only. Returns
    (verdict, numbers). `case` is the paper's ellipse of loads on one profile.
    """
    distance, duration = _distances_and_durations_of_slip(case, x)
    duration_of_phase = {
        "forward": case.time_of("M") - case.time_of("I"),
        "reverse": case.time_of("G") - case.time_of("E"),
    }

    def speed_ratio(durations: dict[str, float]) -> float:
        """Mean speed of forward slip over that of reverse slip."""
        forward_speed = distance["forward"] / durations["forward"]
        return forward_speed / (distance["reverse"] / durations["reverse"])

    ratio_in_slip = speed_ratio(duration)
    ratio_over_phases = speed_ratio(duration_of_phase)
    numbers = {
        "speeds while the point slips": ratio_in_slip,
        "speeds over the phases": ratio_over_phases,
        "distance forward": distance["forward"],
        "distance reverse": distance["reverse"],
        "time forward": duration["forward"] / (2 * math.pi),
        "time reverse": duration["reverse"] / (2 * math.pi),
    }
    # _ROUNDING_ERROR: 1e-10
    verdict = verdict_of_condition(
        ratio_in_slip < 1 - _ROUNDING_ERROR, nearly_holds=ratio_over_phases < 1 - _ROUNDING_ERROR
    )
    return verdict, numbers


def _distances_and_durations_of_slip(
    case: Case, x: float
) -> tuple[dict[str, float], dict[str, float]]:
    """How far, over A P0/3, and how long [rad] a point slips in a steady cycle: two dictionaries
    with the keys "forward" and "reverse". A = 2/E*, and P0 is the mean normal load.

    `case` is the paper's ellipse of loads on one profile; `x` is over the half-width at the mean
    load, a place that is always in contact.
    """
    # P at which the edge of contact is at the point
    edge_load = np.asarray(case.contact.load(np.array([x * case.unit_length])))
    distance = {"forward": 0.0, "reverse": 0.0}
    duration = {"forward": 0.0, "reverse": 0.0}
    # slip_spans: by phase of the cycle, spans of time with slip in one direction (+1 or −1)
    for span in chain.from_iterable(case.slip_spans.values()):
        # when the point begins and ends to slip within the span; no later end if it never does
        start_time, end_time = (float(time[0]) for time in slip_times(span, edge_load))
        if end_time > start_time:
            direction = "forward" if span.direction > 0 else "reverse"
            # Times of a span are its load segment's own; on the load path they are later by the
            # delay, whole cycles.
            times_on_path = [start_time + span.delay, end_time + span.delay]
            slip_at_ends = case.solve(time=times_on_path, x=[x], fields=("slip",)).slip[:, 0]
            distance[direction] += abs(float(slip_at_ends[1] - slip_at_ends[0])) / case.unit_slip
            duration[direction] += end_time - start_time
    return distance, duration


def _point_history(case: Case, x: float) -> VerdictAndNumbers:
    """Check the sequence of stick, slip and separation that the paper states for a point of figure
    5, at `x` over the half-width a0 at the mean load. The cycle may begin anywhere in the sequence.

    `case` is the paper's ellipse of loads on one profile. Returns (verdict, numbers), the verdict
    being "confirmed" or "contradicted"; of the numbers, "runs" is how many states follow each other
    in a cycle.
    """
    # states of the point at 1440 instants of the steady cycle, and each once for the time it lasts
    times = case.cycle_times(1441)
    middle_times = (times[1:] + times[:-1]) / 2
    states = case.solve(time=middle_times, x=[x], fields=("state",)).state[:, 0]
    # STATE_NAMES: words of a state, such as "stick"
    state_names = _sequence([STATE_NAMES[SurfaceState(int(state))] for state in states])
    letter_by_state = {"stick": "S", "forward slip": "F", "reverse slip": "R", "open": "O"}
    letters = [letter_by_state[name] for name in state_names]

    # what the paper states for x, in these letters, from each possible begin
    # _STATED_HISTORIES: x/a0 of a point -> its letters in the paper
    stated_letters = _sequence(_STATED_HISTORIES[x])
    stated_sequences = [
        stated_letters[start:] + stated_letters[:start] for start in range(len(stated_letters))
    ]
    numbers = {
        "share of separation": float(np.mean(states == SurfaceState.OPEN)),
        "runs": len(state_names),
        "history": ", ".join(state_names).replace("open", "separation"),
    }
    return verdict_of_condition(letters in stated_sequences), numbers


def _sequence(states: Sequence[str]) -> list[str]:
    """States of a closed cycle without repetition: each once for the time that it lasts.

    >>> _sequence("SSFOS")
    ['S', 'F', 'O']
    """
    names = [name for name, _ in groupby(states)]
    return names[:-1] if len(names) > 1 and names[0] == names[-1] else names


def one_way_slip(case: Case) -> VerdictAndNumbers:
    """Check the paper's statement on where slip is in one direction only: the x/a0, printed as
    0.88, beyond which reverse slip does no work. a0 is the contact half-width at the mean load.

    Five times, the interval of the slip zone in which this place lies is divided by 100. The
    numbers also have the larger contact half-width over a0 at the events E and G, between which
    reverse slip lasts. `case` is the paper's ellipse of loads on one profile. Returns (verdict,
    numbers).
    """
    # the slip zone of the steady cycle, over a0
    lower_bound = case.permanent_stick_half_width
    upper_bound = case.largest_half_width
    for _ in range(5):
        x = np.linspace(lower_bound, upper_bound, 101)
        # the last of these points at which reverse slip (from E to G) does work per area
        last_index = np.flatnonzero(case.density_of_phases(x)["EG"] > 0)[-1]
        lower_bound = float(x[last_index])
        upper_bound = float(x[last_index + 1])
    end_of_reverse_work = (lower_bound + upper_bound) / 2
    largest_half_width_in_reverse_slip = max(case.half_width_at("E"), case.half_width_at("G"))
    # confirmed if the place rounds to the printed 0.88 at 2 decimals, refined if within 2 % of it
    return verdict_of_number(end_of_reverse_work, 0.88, 2), {
        "edge": end_of_reverse_work,
        "largest a in E-G": largest_half_width_in_reverse_slip,
    }


# ------------------------------------------------------------------- other loads, the other profile
def statements_on_loads(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states on the influence of friction, mean shear force, initial loading
    and profile on slip and dissipation. Returns name of a statement -> (verdict, numbers).

    `paper` holds the paper's ellipse of loads on its two profiles: the parabola (`hertz_case`) and
    the flat and rounded one (`rounded_case`).
    """
    case = paper.hertz_case
    return {
        "friction delays slip": friction_delays_slip(case),
        "coefficients of figure 4b": sliding_coefficients(case),
        "mean shear force": no_effect_of_mean_shear(case),
        "initial loading": forgotten_loading(case),
        **bands_of_slip(case, paper.rounded_case),
    }


def friction_delays_slip(case: Case) -> VerdictAndNumbers:
    """Check the paper's statement on friction: the larger the coefficient of friction, the later
    slip begins (reverse slip at event E, forward slip at I), and the later reverse slip ends (G).

    The shifts are from the least to the largest coefficient of friction, in degrees of the cycle.
    The verdict is "confirmed" if all three are later, "refined" if slip begins later but does not
    end later. `case` is the paper's ellipse of loads on one profile. Returns (verdict, shifts).
    """
    # FRICTIONS: coefficients of the paper's figure 4b; the mean shear force is set to zero
    cases = [case.with_zero_mean_shear(f) for f in sorted(FRICTIONS)]
    # letter of an event -> its times [rad], from the least coefficient to the largest
    times_by_letter = {
        letter: np.array([case_of_friction.time_of(letter) for case_of_friction in cases])
        for letter in "EGI"
    }
    is_later = {
        letter: bool(np.all(np.diff(times) > 0)) for letter, times in times_by_letter.items()
    }
    shifts = {
        f"shift of {letter} in degrees": math.degrees(times[-1] - times[0])
        for letter, times in times_by_letter.items()
    }
    shifts["G earlier in degrees"] = -shifts["shift of G in degrees"]
    is_onset_later = is_later["E"] and is_later["I"]
    return verdict_of_condition(
        is_onset_later and is_later["G"], nearly_holds=is_onset_later
    ), shifts


def sliding_coefficients(case: Case) -> VerdictAndNumbers:
    """Check whether the whole contact slides (gross sliding) at the coefficients of friction of the
    paper's figure 4b: with the mean shear force Q0 of the cycle, and with Q0 = 0.

    "Confirmed" if at no coefficient the contact slides with Q0; "refined" if at none with Q0 = 0.
    `case` is the paper's load cycle, an ellipse of P and Q, on one of its profiles; `unit_load` is
    a third of the mean normal load. Returns (verdict, numbers).
    """
    frictions = np.array(FRICTIONS)  # those of figure 4b, (n,)
    mean_shear = case.load_ellipse.mean_tangential_load
    # loads, profile and material of the case, with these coefficients and mean shear forces
    arguments = case.batch_arguments(
        friction_coefficient=frictions, mean_tangential_load=mean_shear * np.array([[1.0], [0.0]])
    )
    # Why a cycle has no dissipation, (2, n): with and without mean shear force along rows,
    # coefficients along columns.
    reasons = semi_analytic.dissipation(**arguments).reason
    slides_with_mean_shear, slides_without_mean_shear = reasons == semi_analytic.Reason.SLIDING
    numbers = {
        "sliding with Q0": int(slides_with_mean_shear.sum()),
        "sliding with Q0 = 0": int(slides_without_mean_shear.sum()),
        "Q0": mean_shear / case.unit_load,
        "which slide": ", ".join(f"{f:g}" for f in frictions[slides_with_mean_shear]),
    }
    verdict = verdict_of_condition(
        not slides_with_mean_shear.any(), nearly_holds=not slides_without_mean_shear.any()
    )
    return verdict, numbers


def no_effect_of_mean_shear(case: Case) -> VerdictAndNumbers:
    """Check the paper's statement that neither stick zone nor dissipation depends on the mean shear
    force, with three other mean forces. Returns (verdict, largest changes). `case` is the paper's
    ellipse of loads on one profile; `unit_load` is a third of its mean normal load.
    """
    changed_cases = [
        case.with_load(mean_tangential_load=force * case.unit_load, initial_loading="straight")
        for force in (-1.0, 0.0, 0.5)
    ]
    # The largest of c, the stick half-width, and of W, the dissipation; _ROUNDING_ERROR: 1e-10
    changes = _changes(case, changed_cases)
    return verdict_of_condition(max(changes.values()) <= _ROUNDING_ERROR), changes


def forgotten_loading(case: Case) -> VerdictAndNumbers:
    """Check the paper's statement that the steady cycle forgets the initial loading but for the
    shear inside the permanent stick zone. It is compared with two other initial loadings: a
    straight line, and one with two vertices.

    # notation: c half-width of the stick zone, W dissipation of a cycle, q shear traction, a0
    #           contact half-width at the mean normal load P0

    `case` is the paper's ellipse of loads on one profile: `unit_load` is P0/3, `unit_length` a0,
    and its half-widths are over a0. Returns (verdict, largest changes of c, W and q), the verdict
    being "confirmed" or "contradicted".
    """
    # P and Q at the vertices
    vertices = tuple(
        (normal_load * case.unit_load, tangential_load * case.unit_load)
        for normal_load, tangential_load in ((1.0, 0.5), (2.0, -0.5))
    )
    changed_cases = [
        case.with_load(initial_loading=initial_loading)
        for initial_loading in ("straight", vertices)
    ]
    changes = _changes(case, changed_cases)  # the largest, of c and of W

    def shear(chosen_case: Case, x: Array) -> Array:
        """Shear traction over P0/(3 a0) at `x` over a0, a cycle after event M, the end of forward
        slip.
        """
        time = [chosen_case.time_of("M") + 2 * math.pi]
        solution = chosen_case.solve(time=time, x=x, fields=("shear",))
        return np.asarray(solution.shear * case.unit_length / case.unit_load)

    def change_of_shear(x: Array) -> float:
        """Largest change of the shear traction that a changed initial loading makes at `x`."""
        return max(
            float(np.max(np.abs(shear(changed_case, x) - shear(case, x))))
            for changed_case in changed_cases
        )

    # inside and outside the permanent stick zone
    change_inside = change_of_shear(np.linspace(0, case.permanent_stick_half_width * 0.999, 50))
    change_outside = change_of_shear(
        np.linspace(case.permanent_stick_half_width * 1.001, case.largest_half_width, 50)
    )

    # _ROUNDING_ERROR: 1e-10
    is_forgotten = max(changes.values()) <= _ROUNDING_ERROR and change_outside <= _ROUNDING_ERROR
    shear_changes = {"change of q inside": change_inside, "change of q outside": change_outside}
    return verdict_of_condition(
        is_forgotten and change_inside > _ROUNDING_ERROR
    ), changes | shear_changes


def bands_of_slip(hertz_case: Case, rounded_case: Case) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states of the flat and rounded profile beside the parabola: it slips on
    its rounded edges alone, and in narrower bands at the edges of contact.

    `hertz_case` and `rounded_case` are the paper's ellipse of loads on the parabola and on the flat
    and rounded profile. All widths are over a0, the contact half-width at the mean load. Returns
    name of a statement -> (verdict "confirmed" or "contradicted", numbers).
    """
    # without load the contact is as wide as the flat
    flat_half_width = float(rounded_case.scaled_half_width(0.0))
    hertz_band_width = hertz_case.largest_half_width - hertz_case.permanent_stick_half_width
    rounded_band_width = rounded_case.largest_half_width - rounded_case.permanent_stick_half_width
    return {
        "slip in the radii": (
            verdict_of_condition(rounded_case.permanent_stick_half_width > flat_half_width),
            {"a(P_T)/a0": rounded_case.permanent_stick_half_width, "b/a0": flat_half_width},
        ),
        "narrow bands": (
            verdict_of_condition(rounded_band_width < hertz_band_width),
            {"hertz": hertz_band_width, "flat and rounded": rounded_band_width},
        ),
    }


def _changes(case: Case, changed_cases: Sequence[Case]) -> dict[str, float]:
    """Largest differences of the steady cycle between a case and its variants (`changed_cases`).
    They are those of the stick half-width c, over the contact half-width a0 at the mean load, and
    of the dissipation W, relative.

    W is taken as the closed integral of Q dU (`loop_work`), U the tangential displacement: its
    integrand depends on the mean shear force. `case` is the paper's ellipse of loads on one
    profile; `unit_length` is a0.
    """

    def stick_half_widths_of(chosen_case: Case) -> Array:
        """c/a0 at 73 instants of the steady cycle, (73,)."""
        times = chosen_case.cycle_times(73)
        return chosen_case.solve(time=times).stick_half_width / chosen_case.unit_length

    stick_half_widths = stick_half_widths_of(case)
    dissipation = case.steady_cycle.loop_work
    stick_changes = []
    dissipation_changes = []
    for changed_case in changed_cases:
        difference = stick_half_widths_of(changed_case) - stick_half_widths
        stick_changes.append(float(np.max(np.abs(difference))))
        dissipation_changes.append(abs(changed_case.steady_cycle.loop_work / dissipation - 1))
    return {"change of c": max(stick_changes), "change of W": max(dissipation_changes)}


# --------------------------------------------------------------------------------- work of friction
def statements_on_work(case: Case) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states of the dissipation: which share of it forward slip does, and
    W(x), the dissipation per area in a cycle, at both ends of the slip zone. Returns name of a
    statement -> (verdict, numbers).

    `case` is the paper's ellipse of loads on one profile; half-widths and places are over the
    contact half-width at the mean load.
    """
    # dissipation of a steady cycle: all of it (`value`), and that of forward slip
    batch = semi_analytic.dissipation(**case.batch_arguments())
    forward_share = float(batch.forward / batch.value)
    shares = {"share of forward slip": forward_share, "share of reverse slip": 1 - forward_share}

    # W(x) at four points, by their distance from the stick edge over the width of the slip zone:
    # two in the stick zone, two in the slip zone
    stick_edge = case.permanent_stick_half_width
    contact_edge = case.largest_half_width
    zone_width = contact_edge - stick_edge
    fractions = np.array([-0.5, -1e-9, 0.5, 1 - 1e-9])
    densities = sum_over_phases(
        case.density_of_phases(stick_edge + zone_width * fractions)
    ).tolist()
    density_in_stick = max(densities[:2])
    density_in_middle = densities[2]
    density_at_edge = densities[3]  # of contact
    end_ratio = max(density_in_stick, density_at_edge) / density_in_middle
    numbers_at_ends = {
        "largest at the ends over mid-zone": end_ratio,
        "in the stick zone": density_in_stick,
        "at the outer edge over mid-zone": density_at_edge / density_in_middle,
    }

    def exponent(origin: float, sense: float) -> float:
        """The power of the distance from an end of the slip zone (`origin`) with which W(x) grows:
        d ln W / d ln(distance), close to it. `sense` is 1 to the right of the end, −1 to the left.
        """
        distance = zone_width * np.array([1e-6, 1e-5])
        density = sum_over_phases(case.density_of_phases(origin + sense * distance))
        return float(np.diff(np.log(density))[0] / np.diff(np.log(distance))[0])

    exponent_at_stick = exponent(stick_edge, 1.0)
    exponent_at_edge = exponent(contact_edge, -1.0)

    # A verdict is "confirmed" if its condition holds, "refined" if the second one (`nearly_holds`)
    # does.
    # _EXPONENT_TOLERANCE: 0.01
    return {
        "most work in forward slip": (
            verdict_of_condition(forward_share > 0.75, nearly_holds=forward_share > 0.5),
            shares,
        ),
        "no work at the ends": (
            verdict_of_condition(density_in_stick == 0 and end_ratio < 1e-6),
            numbers_at_ends,
        ),
        "slope at the stick edge": (
            verdict_of_condition(exponent_at_stick > 1 + _EXPONENT_TOLERANCE),
            {"exponent": exponent_at_stick},
        ),
        "slope at the outer edge": (
            verdict_of_condition(abs(exponent_at_edge - 1) <= _EXPONENT_TOLERANCE),
            {"exponent": exponent_at_edge},
        ),
        "root at the outer edge": (
            verdict_of_condition(
                abs(exponent_at_edge - 0.5) <= _EXPONENT_TOLERANCE,
                nearly_holds=abs(exponent_at_edge - 0.5) <= 0.1,
            ),
            {"exponent": exponent_at_edge},
        ),
    }


_PROFILE_NAMES = ("Hertz", "flat and rounded")


def _statements_on_comparison(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states on the peak of the dissipation per area W(x), on the influence of
    P0/P1 and f, and on the flat and rounded contact. This is compared with Hertz' contact at equal
    loads, f, material and a0. Returns name of a statement -> (verdict, numbers).
    """
    return (
        _places_of_peaks(paper)
        | _falls_towards_far_loads(paper)
        | _flat_over_hertz(paper)
        | {"weaker dependence of the peak": _dependence_of_the_peak(paper)}
    )


def _places_of_peaks(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states on where W(x), the dissipation per area, has its peak: a little
    beyond 60 % of the way from the stick edge to the contact edge.

    The last statement takes the sweeps of loads, at the largest coefficient of friction: "near" is
    the load nearest to gross sliding, "far" the farthest.

    For each of both profiles, `paper.peaks` are those of the paper's own cycle, with `place`
    [length] and `fraction` of the way. Its `sweeps` have a `peak_fraction` with coefficients of
    friction along rows and mean loads along columns. Returns name of a statement -> (verdict,
    numbers).
    """
    # the paper's own cycle; "confirmed" if the condition holds, "refined" if it nearly holds
    statements: dict[str, VerdictAndNumbers] = {}
    cases = (paper.hertz_case, paper.rounded_case)
    # _PROFILE_NAMES: "Hertz" and "flat and rounded"
    for profile_name, case, peak in zip(_PROFILE_NAMES, cases, paper.peaks, strict=True):
        fraction = float(peak.fraction)
        numbers = {"fraction": fraction, "x/a0": float(peak.place) / case.unit_length}
        verdict = verdict_of_condition(
            0.6 < fraction < 0.65, nearly_holds=abs(fraction - 0.6) < 0.02
        )
        statements[f"place of the peak, {profile_name}"] = (verdict, numbers)

    # the loads nearest to and farthest from gross sliding
    fractions = {}
    for profile_name, sweep in zip(_PROFILE_NAMES, paper.sweeps, strict=True):
        fractions[f"{profile_name}, near"] = float(sweep.peak_fraction[0, 0])
        fractions[f"{profile_name}, far"] = float(sweep.peak_fraction[0, -1])
    is_as_stated = all(0.6 < fraction < 0.65 for fraction in fractions.values())
    is_nearly_as_stated = all(0.55 < fraction < 0.7 for fraction in fractions.values())
    statements["place of the peak, all loads"] = (
        verdict_of_condition(is_as_stated, is_nearly_as_stated),
        fractions,
    )
    return statements


def _exponents(sweep: Sweep, quantity: str) -> Array:
    """Exponent n with which a quantity of a sweep of loads, a cycle's "work" of friction or the
    "peak" of the work per area, goes as P0^n, at constant amplitude P1 and half-width a(P0).

    (m, k - 1) for a sweep of (m, k) loads, coefficients of friction along rows, `load_ratio` P0/P1
    along columns: n between neighbouring values of P0.
    """
    log_quantity = np.log(getattr(sweep, quantity))
    log_load = np.log(sweep.load_ratio)
    return np.asarray(np.diff(log_quantity, axis=1) / np.diff(log_load, axis=1))


def _falls_towards_far_loads(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """Check what the paper states on how the dissipation W of a cycle, its peak and their quotient
    (the figure of merit) change from loads near gross sliding to loads far from it. The peak is
    that of W(x), the dissipation per area.

    `paper.sweeps` are those of the parabola and of the flat and rounded profile: `work` W and
    `peak`, at constant amplitude P1 and contact half-width a0 = a(P0). They have coefficients of
    friction along rows, mean loads P0/P1 along columns; the first column is nearest to sliding.
    Returns name of a statement -> (verdict "confirmed" or "contradicted", numbers).
    """
    # W and the peak: the largest rise from a load to the next, negative if they always fall; and
    # by what factor they fall over all loads, at the largest coefficient of friction
    hertz_sweep = paper.sweeps[0]
    largest_rise = {}
    falls = {}
    for quantity in ("work", "peak"):
        rises_of_sweeps = [np.diff(getattr(sweep, quantity), axis=1) for sweep in paper.sweeps]
        largest_rise[quantity] = max(float(np.max(rises)) for rises in rises_of_sweeps)
        values_at_first_friction = getattr(hertz_sweep, quantity)[0]
        falls[f"fall of {quantity}"] = float(
            values_at_first_friction[0] / values_at_first_friction[-1]
        )

    # Exponents n of P0^n, between neighbouring loads. At constant radius, not constant a0: the peak
    # goes as 1/a0, and a0 grows like sqrt(P0).
    peak_exponents = _exponents(hertz_sweep, "peak") - 0.5
    least_difference = float(np.min(peak_exponents - _exponents(hertz_sweep, "work")))

    # at which loads the figure of merit is largest
    merits = [sweep.work / sweep.peak for sweep in paper.sweeps]
    best_columns = {int(column) for merit in merits for column in np.argmax(merit, axis=1)}
    return {
        "global dissipation before sliding": (
            verdict_of_condition(largest_rise["work"] < 0),
            {"largest step": largest_rise["work"]},
        ),
        "peak before sliding": (
            verdict_of_condition(largest_rise["peak"] < 0),
            {"largest step": largest_rise["peak"]},
        ),
        "work falls faster than its peak": (
            verdict_of_condition(least_difference > 0),
            falls | {"least gap of exponents": least_difference},
        ),
        "best designs close to sliding": (
            verdict_of_condition(best_columns == {0}),
            {"near": float(merits[0][0, 0]), "far": float(merits[0][0, -1])},
        ),
    }


def _flat_over_hertz(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """Check the factors that the paper states between the flat and rounded contact and the Hertz
    contact. They are five for the dissipation W, and eight for the peak of W(x), the dissipation
    per area. Returns name of a statement -> (verdict, numbers).

    # notation: A = 2/E*, f friction, P0 mean normal load, a0 contact half-width at P0

    `paper` holds for both profiles: the case, which is the paper's cycle, its peak, and a sweep
    over many P0 and f, whose quotients are given as least and largest.
    """
    hertz_sweep, rounded_sweep = paper.sweeps
    hertz_peak, rounded_peak = paper.peaks

    def scaled_work(case: Case) -> float:
        """W over A f^2 P0^2, the unit of work."""
        return case.steady_cycle.dissipation / case.unit_work

    def scaled_peak(case: Case, peak_of_cycle: semi_analytic.PeakBatch) -> float:
        """Peak of W(x) over A f^2 P0^2/a0."""
        return float(peak_of_cycle.value) * case.unit_length / case.unit_work

    quotient_of_works = scaled_work(paper.rounded_case) / scaled_work(paper.hertz_case)
    quotient_of_peaks = scaled_peak(paper.rounded_case, rounded_peak) / scaled_peak(
        paper.hertz_case, hertz_peak
    )
    # "confirmed" if a quotient rounds to the paper's, "refined" if within 20 % (`slack`); _span:
    # least and largest of an array
    return {
        "five times the energy": (
            verdict_of_number(quotient_of_works, 5, 0, slack=0.2),
            {"quotient of work": quotient_of_works} | _span(rounded_sweep.work / hertz_sweep.work),
        ),
        "eight times the peak": (
            verdict_of_number(quotient_of_peaks, 8, 0, slack=0.2),
            {"quotient of peaks": quotient_of_peaks} | _span(rounded_sweep.peak / hertz_sweep.peak),
        ),
        # the merit is work over peak
        "figure of merit": (
            verdict_of_condition(quotient_of_works < quotient_of_peaks),
            {
                "quotient of merits": quotient_of_works / quotient_of_peaks,
                "five over eight": 5 / 8,
            },
        ),
    }


def _span(quotients: Array) -> dict[str, float]:
    """Least and largest value of an array."""
    return {"least": float(quotients.min()), "largest": float(quotients.max())}


def _dependence_of_the_peak(paper: Paper) -> VerdictAndNumbers:
    """Check the paper's statement that the largest W(x), the dissipation per area, of the flat and
    rounded contact falls less with the mean normal load P0 than that of the Hertz contact.

    At the least coefficient of friction W(x) has two maxima, and the largest jumps from the inner
    to the outer one as P0 grows. The numbers show the loads P0/P1 around the jump, and the places
    of the peak: 0 at the stick edge, 1 at the contact edge.

    `paper` holds sweeps of both profiles over P0 in units of the amplitude P1, each (m, k):
    friction along rows, P0/P1 along columns. Of each, `peak` is the largest W(x) at constant P1,
    and `peak_fraction` its place. Returns (verdict, numbers), the verdict being "confirmed" or
    "contradicted".
    """
    hertz_sweep, rounded_sweep = paper.sweeps
    # By what factor the peak falls from the least P0 to the largest, (m,).
    # At constant P0 the peak goes as (P1/P0)^2 times what the sweep has at constant P1.
    hertz_falls = hertz_sweep.peak[:, 0] / hertz_sweep.peak[:, -1]
    rounded_falls = rounded_sweep.peak[:, 0] / rounded_sweep.peak[:, -1]
    # exponents n of P0^n, (m, k - 1); they are negative: the larger one is that of the weaker fall
    falls_less = _exponents(rounded_sweep, "peak") > _exponents(hertz_sweep, "peak")
    share_of_weaker_falls = float(np.mean(falls_less))

    # the jump of the peak's place, in the last row: the least coefficient of friction
    load_ratios = rounded_sweep.load_ratio[-1]
    peak_fractions = rounded_sweep.peak_fraction[-1]
    column_before_jump = int(np.argmax(np.abs(np.diff(peak_fractions))))
    numbers = {
        "fall, hertz": float(hertz_falls[0]),
        "fall, flat and rounded": float(rounded_falls[0]),
        "share of smaller exponents": share_of_weaker_falls,
        "last shoulder": float(load_ratios[column_before_jump]),
        "first outer one": float(load_ratios[column_before_jump + 1]),
        "first place": float(peak_fractions[0]),
        "last place": float(peak_fractions[column_before_jump]),
        "place of the outer one": float(peak_fractions[column_before_jump + 1]),
    }
    is_true = bool(np.all(rounded_falls < hertz_falls)) and share_of_weaker_falls == 1
    return verdict_of_condition(is_true), numbers
