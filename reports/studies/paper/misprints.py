"""The paper's misprints, each held against the engine: whether it is proven and the numbers that
the words of paper.toml name.

`right` and `printed` are the errors of the mended and of the printed reading, as shares of what the
engine gives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.studies.paper.cases import (
    Case,
    Formulas,
    Paper,
    integral,
    sliding_limit,
    sum_over_phases,
)
from reports.studies.paper.tables import AGREEMENT_TOLERANCE, VerdictAndNumbers, is_misprint_proven
from scenes import PolygonLoad
from scenes.array_types import Array

# Phases of slip of the steady cycle, each from event to event: reverse slip, and both parts of
# forward slip.
_PHASES = ("EG", "IJ", "JM")


def prove_misprints(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """All misprints of the paper, tested by computing where one can: key of a misprint -> whether
    it is proven (None: it is found by reading) and its numbers.

    `paper` holds the paper's ellipse of loads on its two profiles, and the peaks of W(x), the
    dissipation per area, on each.
    """
    proof_by_misprint = _misprints_of_cycle(paper.hertz_case) | _misprints_of_slip(paper.hertz_case)
    proof_by_misprint |= _misprints_of_work(paper.hertz_case, float(paper.peaks[0].place))
    proof_by_misprint["(25)"] = _sliding_condition(paper.hertz_case)
    proof_by_misprint["flat-and-rounded law"] = _rounded_law(paper.rounded_case)
    proof_by_misprint["reference [7]"] = (None, {})
    return proof_by_misprint


def _relative_error(value: float, reference: float) -> float:
    """|value/reference - 1|."""
    return abs(value / reference - 1)


def _proof(
    mended_value: float,
    printed_value: float,
    engine_value: float,
    numbers: Mapping[str, float],
    *,
    also_holds: bool = True,
) -> VerdictAndNumbers:
    """Whether a misprint of the paper is proven: the mended formula gives the engine's value (that
    of half-plane theory), the printed formula does not, and a further condition (`also_holds`) is
    met.

    Returns (whether it is proven, numbers by name): the relative errors of the mended formula
    ("right") and of the printed one ("printed"), with `numbers` added.
    """
    mended_error = _relative_error(mended_value, engine_value)
    printed_error = _relative_error(printed_value, engine_value)
    return is_misprint_proven(mended_error, printed_error) and also_holds, {
        "right": mended_error,
        "printed": printed_error,
        **numbers,
    }


# -------------------------------------------------------------------- loads, friction and tractions
def _misprints_of_cycle(case: Case) -> dict[str, VerdictAndNumbers]:
    """Prove the misprints in sections 2 and 3 of the paper, by computing with the text as printed
    and as mended. They concern which loads, events (the letters A to M) and conditions are meant.

    `case` is the paper's ellipse of loads on one profile. Returns name of a misprint -> (whether
    it is proven, numbers).
    """
    return {
        "(2)": _corrective_load(case),
        "condition of stick": _condition_of_stick(case),
        "(9), (10)": _point_of_permanent_stick(case),
        "3H": _event_of_least_load(case),
        "J and K": _order_of_j_and_k(case),
        "mean shear force": _mean_shear_force(case),
        "net displacement": _net_displacement(case),
    }


def _point_of_permanent_stick(case: Case) -> VerdictAndNumbers:
    """Prove that the permanent stick zone of equations (9) and (10) is given by the loads at the
    event G (end of reverse slip), not at B (end of full stick in the first cycle) as printed. The
    equation is P_T = [(Q + f P) at the event - (Q - f P) at E] / (2 f). Returns whether it is
    proven, and half-widths over a0.

    # notation: P_T the normal load whose contact is the permanent stick zone, f friction, E the end
    #           of forward slip, a0 contact half-width at the mean load

    `case` is the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended

    def half_width_for_event(letter: str) -> float:
        """a(P_T)/a0 with the loads at this event."""
        # q_plus_f_p(letter, sign): Q + sign f P at an event
        difference = formulas.q_plus_f_p(letter, 1) - formulas.q_plus_f_p("E", -1)
        return float(case.scaled_half_width(difference / (2 * case.friction)))

    half_width_with_b = half_width_for_event("B")
    half_width_with_g = half_width_for_event("G")
    numbers = {
        "with B": half_width_with_b,
        "with G": half_width_with_g,
        "permanent stick": case.permanent_stick_half_width,
    }
    # values as mended, as printed, and by half-plane theory
    return _proof(half_width_with_g, half_width_with_b, case.permanent_stick_half_width, numbers)


def _order_of_j_and_k(case: Case) -> VerdictAndNumbers:
    """Prove that the event J comes after K in the paper's example. At K the normal load is largest.
    At J the stick edge is where the contact edge was at G, the end of reverse slip. Forward slip
    begins at I, before K. Returns whether it is proven, and angles of the load cycle.

    `case` is the paper's ellipse of loads on one profile. Of its events, `front_load` is the normal
    load whose contact is the stick zone.
    """
    # `time_of`: angle of an event on the ellipse [rad]
    angle_of_j = math.degrees(case.time_of("J") - case.time_of("K"))
    angle_of_i = math.degrees(case.time_of("I") - case.time_of("K"))
    error_at_j = _relative_error(case.events["J"].front_load, case.events["G"].normal_load)
    # AGREEMENT_TOLERANCE: 1e-9
    return (
        error_at_j <= AGREEMENT_TOLERANCE and angle_of_i < 0 < angle_of_j,
        {
            "J after K in degrees": angle_of_j,
            "I after K in degrees": angle_of_i,
            "I before K in degrees": -angle_of_i,
            "stick edge load at J against P_G": error_at_j,
        },
    )


def _mean_shear_force(case: Case) -> VerdictAndNumbers:
    """Prove that the shear force on which the dissipation does not depend is the mean Q0, not the
    amplitude Q1 as printed: half of either is tried. Returns whether it is proven, and relative
    changes of the dissipation.

    `case` is the paper's ellipse of loads on one profile. The dissipation is taken as `loop_work`,
    the closed integral of Q dU over the steady cycle, U the tangential displacement.
    """

    def work_with_half_of_load(load_name: str) -> float:
        """Dissipation of a cycle when a load, the mean or the amplitude of Q, is halved."""
        changes = {load_name: getattr(case.load_ellipse, load_name) / 2}
        return case.with_load(initial_loading="straight", **changes).steady_cycle.loop_work

    # values as mended, as printed, and by half-plane theory
    return _proof(
        work_with_half_of_load("mean_tangential_load"),
        work_with_half_of_load("tangential_amplitude"),
        case.steady_cycle.loop_work,
        {},
    )


def _condition_of_stick(case: Case) -> VerdictAndNumbers:
    """Prove that the paper's condition of full stick is misprinted: dQ/dP < f as printed, |dQ/dP| <
    f with growing P as mended. Each is compared with half-plane theory at 720 instants of the
    steady cycle. Returns whether it is proven, and the share of instants at which each is wrong.

    `case` is the paper's ellipse of loads on one profile; `unit_length` is the contact half-width
    at the mean load.
    """
    times = case.cycle_times(721)
    middle_times = (times[1:] + times[:-1]) / 2
    solution = case.solve(time=middle_times)
    slip_zone_width = solution.contact_half_width - solution.stick_half_width
    # AGREEMENT_TOLERANCE: 1e-9
    is_full_stick = slip_zone_width <= AGREEMENT_TOLERANCE * case.unit_length
    # Formulas: the paper's equations; dP/dt and dQ/dt
    rate_of_p, rate_of_q = Formulas(case).rates(middle_times)
    slope = rate_of_q / rate_of_p
    printed_condition = slope < case.friction
    mended_condition = (np.abs(slope) < case.friction) & (rate_of_p > 0)
    printed_share = float(np.mean(printed_condition != is_full_stick))
    mended_share = float(np.mean(mended_condition != is_full_stick))
    return (
        mended_share == 0 and printed_share > 0.01,
        {"printed": printed_share, "right": mended_share},
    )


def _event_of_least_load(case: Case) -> VerdictAndNumbers:
    """Prove that P is least at the event F of the paper's cycle, and Q is least at H. The paper's
    text has P least at H. Returns whether it is proven, and the loads over P0/3 (`unit_load`), a
    third of the mean normal load.

    `case` is the paper's ellipse of loads on one profile.
    """
    events = case.events
    normal_loads, tangential_loads = case.scaled_loads(case.cycle_times(3601))
    least_p = float(normal_loads.min())
    least_q = float(tangential_loads.min())
    numbers = {f"P at {letter}": events[letter].normal_load / case.unit_load for letter in "HF"}
    numbers |= {
        f"Q at {letter}": events[letter].tangential_load / case.unit_load for letter in "HF"
    }
    # AGREEMENT_TOLERANCE: 1e-9
    p_is_least_at_f = abs(numbers["P at F"] - least_p) < AGREEMENT_TOLERANCE
    p_is_least_at_h = numbers["P at H"] - least_p <= AGREEMENT_TOLERANCE
    q_is_least_at_h = abs(numbers["Q at H"] - least_q) < AGREEMENT_TOLERANCE
    is_proven = p_is_least_at_f and not p_is_least_at_h and q_is_least_at_h
    return is_proven, numbers | {"least P": least_p, "least Q": least_q}


def _net_displacement(case: Case) -> VerdictAndNumbers:
    """Prove that what is 0 after a revolution is the net slip, and not the dissipation as printed,
    at x = 0.8 a0. Returns whether it is proven, with the net slip over the range of slip, and the
    dissipation in the paper's unit A f^2 P0^2.

    # notation: a0 contact half-width at the mean normal load P0, A = 2/E*, f friction

    `case` is the paper's ellipse of loads on one profile: `unit_length` is a0, `unit_work` the unit
    of dissipation; `solve` takes places x/a0.
    """
    # a revolution of the loads (2 pi) from the event G, the end of reverse slip
    start_time = case.time_of("G")
    times = start_time + np.linspace(0, 2 * math.pi, 101)
    slip = case.solve(time=times, x=[0.8], fields=("slip",)).slip[:, 0]
    # what the point gains between two times, by half-plane theory (the engine); Formulas: the
    # paper's equations
    net_slip = abs(
        Formulas(case).engine_slip(0.8 * case.unit_length, start_time, start_time + 2 * math.pi)
    )
    relative_net_slip = net_slip / float(np.ptp(slip))
    dissipation = case.steady_cycle.dissipation / case.unit_work
    # AGREEMENT_TOLERANCE: 1e-9
    return (
        relative_net_slip <= AGREEMENT_TOLERANCE and dissipation > 1e-3,
        {"right": relative_net_slip, "printed": dissipation},
    )


def _corrective_load(
    case: Case, friction: float = 0.5, share_of_limit: float = 0.6
) -> VerdictAndNumbers:
    """Prove that equation (2) is misprinted, on Cattaneo and Mindlin's problem of constant P: the
    shear is q = f [p(x, P) - p(x, corrective load)].

    The corrective load is P - Q/f as mended, Q - P as printed; the printed one with its sign
    turned, P - Q, is tried too. Returns whether it is proven, and the relative error of q with
    each.

    `case` gives profile and normal load: `contact` is the normal contact of its profile, with the
    pressure p(x, P), and `unit_length` the contact half-width at this load. Q is `share_of_limit`
    times f P, with `friction` f.
    """
    # half-plane theory's shear (of the engine) after P is applied first, then Q with P constant (at
    # time 2)
    normal_load = case.load_ellipse.mean_normal_load
    tangential_load = share_of_limit * friction * normal_load
    scene = case.scene.vary(
        load=PolygonLoad(initial_loading=((normal_load, 0.0), (normal_load, tangential_load))),
        friction=friction,
    )
    x = np.linspace(0.0, 0.999, 200) * case.unit_length
    engine_shear = semi_analytic.solve(scene, x=x, time=[2.0], fields=("shear",)).shear[0]

    def error_with_load(corrective_load: float) -> float:
        """Largest difference of equation (2) from half-plane theory's shear, over the largest of
        the latter. A negative corrective load has no pressure.
        """
        pressure_difference = case.contact.pressure(x, normal_load)
        if corrective_load > 0:
            pressure_difference = pressure_difference - case.contact.pressure(x, corrective_load)
        largest_difference = np.max(np.abs(friction * pressure_difference - engine_shear))
        return float(largest_difference / np.max(np.abs(engine_shear)))

    mended_error = error_with_load(normal_load - tangential_load / friction)
    printed_error = error_with_load(tangential_load - normal_load)
    error_with_turned_sign = error_with_load(normal_load - tangential_load)
    # proven if the mended error is at most 1e-9 and both others above 1e-3
    return is_misprint_proven(mended_error, min(printed_error, error_with_turned_sign)), {
        "right": mended_error,
        "printed": printed_error,
        "sign turned only": error_with_turned_sign,
    }


def _sliding_condition(case: Case) -> VerdictAndNumbers:
    """Prove that equation (25), the condition of gross sliding for loads that go round a circle in
    the plane of P and Q, is misprinted. It is P0/P1 below sqrt(2) (1 + f)/(2 f) as printed, below
    sqrt(1 + f^2)/f as mended. Circles between both limits slide, and the limit of half-plane theory
    is within 1e-10 of the mended one. Returns whether it is proven, and numbers.

    # notation: P0 mean normal load, P1 radius of the circle, f coefficient of friction

    `case` gives profile and material of the circles.
    """
    # limits of P0/P1 by both formulas, for each coefficient of friction
    frictions = np.array([0.1, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0])
    mended_limit = sliding_limit(frictions)
    printed_limit = math.sqrt(2) * (1 + frictions) / (2 * frictions)

    # share of the circles between both limits that slide: 99 for each coefficient of friction
    # AGREEMENT_TOLERANCE: 1e-9
    limits_differ = np.abs(frictions - 1) > AGREEMENT_TOLERANCE  # they are equal at f = 1
    difference_of_limits = (mended_limit - printed_limit)[limits_differ]
    fractions = np.linspace(0.01, 0.99, 99)[:, None]
    ratios_between_limits = printed_limit[limits_differ] + difference_of_limits * fractions
    is_sliding = _circles_that_slide(case, frictions[limits_differ], ratios_between_limits)
    sliding_share = float(np.mean(is_sliding))

    # whether circles slide just below the mended limit and not just above it
    margin = 1e-10
    slides_below = _circles_that_slide(case, frictions, mended_limit * (1 - margin))
    slides_above = _circles_that_slide(case, frictions, mended_limit * (1 + margin))
    mended_error = margin if (slides_below & ~slides_above).all() else math.nan
    printed_error = float(np.min(np.abs(printed_limit / mended_limit - 1)[limits_differ]))
    # proven if the mended error is at most 1e-9 and the printed one above 1e-3
    return sliding_share == 1 and is_misprint_proven(mended_error, printed_error), {
        "right": mended_error,
        "printed": printed_error,
        # at frictions[4] = 1 and frictions[1] = 0.4
        "apart at f = 1": _relative_error(float(printed_limit[4]), float(mended_limit[4])),
        "sliding share between": sliding_share,
        "circles between": ratios_between_limits.size,
        "mended limit at f = 0.4": float(mended_limit[1]),
        "printed limit at f = 0.4": float(printed_limit[1]),
    }


def _circles_that_slide(case: Case, frictions: Array, load_ratios: Array) -> NDArray[np.bool_]:
    """Whether loads that go round circles in the plane of P and Q slide as a whole by half-plane
    theory. `frictions` are coefficients of friction, `load_ratios` are mean normal load over the
    circle's radius, in shapes that go together; `case` gives profile and material.

    # notation: P normal load, Q tangential load
    """
    batch = semi_analytic.dissipation(**case.circle_arguments(frictions, load_ratios))
    # `reason`: why a circle has no dissipation of a cycle
    return np.asarray(batch.reason == semi_analytic.Reason.SLIDING)


def _rounded_law(case: Case) -> VerdictAndNumbers:
    """Prove that the paper's contact law of the flat and rounded profile (section 4.2) is
    misprinted: its left side is P R (1 + kappa)/(4 mu b^2), not over a^2 as printed. P is the
    integral of half-plane theory's pressure; (1 + kappa)/mu is 2 A, the compliance of the
    half-planes. Returns whether it is proven, and both sides.

    # notation: a half-width of contact, b of the flat, R radius of the edges; mu shear modulus,
    #           kappa = 3 - 4 nu in plane strain, nu Poisson's ratio; the right side is
    #           (pi - 2 t)/(4 sin^2 t) - cot(t)/2, with sin t = b/a

    `case` is the paper's ellipse of loads on this profile: `unit_length` is the half-width a at the
    mean normal load, at which the law is tested; `contact` has the pressure p(x, P).
    """
    mean_load = case.load_ellipse.mean_normal_load
    profile = case.scene.profile.model_dump()  # the profile's parameters by name
    flat_half_length = profile["flat_half_length"]
    radius = profile["radius"]

    # P, the integral of p over x = a sin(angle), in two parts: the pressure's root at the edge
    # becomes smooth, its singular slope at x = b lies at an end.
    angle_of_flat_end = math.asin(flat_half_length / case.unit_length)

    def load_per_angle(angle: Array) -> Array:
        """Pressure times dx/d(angle), x = a sin(angle)."""
        x = case.unit_length * np.sin(angle)
        return case.contact.pressure(x, mean_load) * case.unit_length * np.cos(angle)

    normal_load = 2 * (
        integral(load_per_angle, 0.0, angle_of_flat_end)
        + integral(load_per_angle, angle_of_flat_end, math.pi / 2)
    )

    # both sides of the law
    first_term = (math.pi - 2 * angle_of_flat_end) / (4 * math.sin(angle_of_flat_end) ** 2)
    right_side = first_term - 1 / math.tan(angle_of_flat_end) / 2

    def left_side_with_divisor(length: float) -> float:
        """Left side of the law, with the square of this length (a or b) as divisor."""
        return normal_load * radius * 2 * case.compliance / (4 * length**2)

    left_side_over_a = left_side_with_divisor(case.unit_length)
    left_side_over_b = left_side_with_divisor(flat_half_length)
    numbers = {
        "left side over a²": left_side_over_a,
        "left side over b²": left_side_over_b,
        "right side": right_side,
        "b/a": flat_half_length / case.unit_length,
    }
    # values as mended, as printed, and of the right side
    return _proof(left_side_over_b, left_side_over_a, right_side, numbers)


# --------------------------------------------------------------------------------------------- slip
def _misprints_of_slip(case: Case) -> dict[str, VerdictAndNumbers]:
    """Prove that equations (14) to (19) are misprinted. Slip and movement between two events of the
    cycle (the paper's letters) are computed by the printed and the mended formula, in and out of
    contact.

    `case` is the paper's ellipse of loads on one profile. Returns name of a misprint -> (whether it
    is proven, numbers).
    """
    return {
        "(14), I–J": _multiplier_in_contact(case),
        "(15)": _gap_for_slope(case),
        "(16), second line": _slip_out_of_contact(case),
        "(17)": _stick_displacement(case),
        "(18)": _slope_as_product(case),
        "P_K in (19)": _load_at_k(case),
        "reference before (23)": _closed_integral(case),
    }


def _load_at_k(case: Case) -> VerdictAndNumbers:
    """Prove that P_K of equation (19), the slip after the event J, is the load at the moving stick
    edge, not the normal load at the event K. With a constant P_K the term of the stick edge is
    zero. The slip is that of the point x = a0, from J halfway to M, the end of forward slip.
    Returns whether it is proven, and numbers.

    # notation: a0 contact half-width at the mean normal load P0, A = 2/E* (the compliance), f
    #           friction, a contact half-width

    `case` is the paper's ellipse of loads on one profile: `unit_length` is a0, `unit_load` P0/3.
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    x = case.unit_length
    time_of_j = case.time_of("J")
    time_of_m = case.time_of("M")
    middle_time = (time_of_j + time_of_m) / 2
    slip_factor = case.compliance * case.friction / math.pi  # A f/pi

    def rate_as_printed(time: Array) -> Array:
        """ds/dt of the slip s where P_K is a constant load: (A f/pi) dP/dt arccosh(x/a)."""
        normal_load, _ = formulas.loads(time)  # P and Q
        normal_load_rate, _ = formulas.rates(time)
        return slip_factor * normal_load_rate * formulas.arccosh_ratio(x, normal_load)

    def rate_as_mended(time: Array) -> Array:
        """ds/dt of the slip s with the moving stick edge."""
        return formulas.slip_rate("JM", x, time)

    # the stick edge load is the normal load whose contact is the stick zone
    numbers = {
        "stick edge load at M": float(formulas.stick_edge_load("JM", time_of_m)) / case.unit_load,
        "load at K": case.events["K"].normal_load / case.unit_load,
    }
    # slip as mended, as printed, and by half-plane theory
    return _proof(
        integral(rate_as_mended, time_of_j, middle_time),
        integral(rate_as_printed, time_of_j, middle_time),
        formulas.engine_slip(x, time_of_j, middle_time),
        numbers,
    )


def _closed_integral(case: Case) -> VerdictAndNumbers:
    """Prove that it is equation (15) which becomes (23), not (12) as printed. (15) gives the
    forward slip at x = 0.8 a0, whereas (12) is the slip of a whole cycle, which is zero. The
    forward slip of this point lies between the events J and M; of any point, between I and M.
    Returns whether it is proven, and the net slip over the forward slip.

    `case` is the paper's ellipse of loads on one profile; `unit_length` is a0, the contact
    half-width at the mean load.
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    x = 0.8 * case.unit_length
    time_of_g = case.time_of("G")

    def slip_rate(time: Array) -> Array:
        """ds/dt of the slip s by the mended equations, from J to M."""
        return formulas.slip_rate("JM", x, time)

    # the time integral while the point slips; and half-plane theory's (the engine's) slip between
    # two times, of the forward phase and of a whole revolution of the loads from G on
    slip_by_15 = formulas.integral_while_slipping("JM", x, slip_rate)
    forward_slip = formulas.engine_slip(x, case.time_of("I"), case.time_of("M"))
    net_slip = formulas.engine_slip(x, time_of_g, time_of_g + 2 * math.pi)
    numbers = {"net over the slip": abs(net_slip / forward_slip)}
    # slip as mended, as printed, and by half-plane theory
    return _proof(slip_by_15, net_slip, forward_slip, numbers)


@dataclass(frozen=True, eq=False)
class _SlipFromIToJ:
    """Slip of the point x = 1.05 a0 from the event I to J, the first part of forward slip, while it
    is in contact. By equation (15) it is the time integral of (A f/pi) C arccosh(x/c) dP_Y/dt.

    # notation: a0 contact half-width at the mean load, A = 2/E*, f friction, c half-width of the
    #           stick zone, P_Y the load whose contact half-width is c, C = (dQ/dP)/f - 1 the
    #           multiplier of equation (14), at the loads P_Y
    """

    case: Case

    @property
    def formulas(self) -> Formulas:
        """The paper's mended equations."""
        return Formulas(self.case)

    @property
    def x(self) -> float:
        """The point [length]."""
        return 1.05 * self.case.unit_length

    @property
    def factor(self) -> float:
        """A f/pi."""
        return self.case.compliance * self.case.friction / math.pi

    @property
    def by_engine(self) -> float:
        """Slip [length] of half-plane theory, to which the equations are compared."""
        return self.formulas.engine_slip(self.x, self.case.time_of("I"), self.case.time_of("J"))

    def with_slope_times(self, load_unit: float | None) -> float:
        """Slip [length] of the point `x` from the event I to J, the first part of forward slip, by
        equation (18): the time integral of (A f/pi) [(dQ/dP)/f - 1] arccosh(x/c) dP_Y/dt.

        As printed the slope dQ/dP is multiplied by P_Y, taken in units of `load_unit`; if this is
        None it is not, as mended.

        # notation: c half-width of the stick zone, P_Y the load whose contact half-width is c, f
        #           friction, A = 2/E*, `factor` A f/pi
        """

        def slip_rate(time: Array) -> Array:
            """ds/dt of the slip s at the point x by the paper's equation (18)."""
            load_at_y = self.formulas.stick_edge_load("IJ", time)  # P_Y
            # dQ/dP from the multiplier (dQ/dP)/f - 1
            slope = self.case.friction * (self.formulas.multiplier_c("IJ", time) + 1)
            slope_as_read = slope
            if load_unit:
                slope_as_read = slope * load_at_y / load_unit
            multiplier = slope_as_read / self.case.friction - 1
            load_rate = self.formulas.stick_edge_load_rate("IJ", time)  # dP_Y/dt
            arccosh_ratio = self.formulas.arccosh_ratio(self.x, load_at_y)  # arccosh(x/c)
            return multiplier * self.factor * load_rate * arccosh_ratio

        return self.formulas.integral_while_slipping("IJ", self.x, slip_rate)

    def rate_as_printed(self, time: Array) -> Array:
        """ds/dt of the slip s by equation (14) as printed, (A f/pi) C arccosh(x/c) dP/dt; as mended
        it has dP_Y/dt instead. The multiplier C is (dQ/dP)/f - 1; c is the half-width of the stick
        zone, and P_Y the load whose contact half-width is c.
        """
        load_rate, _ = self.formulas.rates(time)
        stick_edge_load = self.formulas.stick_edge_load("IJ", time)
        arccosh_ratio = self.formulas.arccosh_ratio(self.x, stick_edge_load)
        return self.factor * self.formulas.multiplier_c("IJ", time) * arccosh_ratio * load_rate


def _multiplier_in_contact(case: Case) -> VerdictAndNumbers:
    """Prove that equation (14) is misprinted between the events I and J, the first part of forward
    slip: slip is by C dP_Y, not by C dP as printed. P_Y is the load at the stick edge,
    C = (dQ/dP)/f - 1.

    P is largest at K, between I and J, so that the printed slip has different signs before and
    after. Returns whether it is proven, and the printed slip before and after K over half-plane
    theory's slip (the engine's) from I to J. `case` is the paper's ellipse of loads on one profile.
    """
    # the slip of one point (`slip.x`) from I to J [length], by theory and by the equations
    slip = _SlipFromIToJ(case)
    engine_slip = slip.by_engine
    printed_slip = slip.formulas.integral_while_slipping("IJ", slip.x, slip.rate_as_printed)
    slip_after_k = integral(slip.rate_as_printed, case.time_of("K"), case.time_of("J"))
    ratio_after_k = slip_after_k / engine_slip
    ratio_before_k = printed_slip / engine_slip - ratio_after_k
    # mended slip (the slope dQ/dP is not multiplied by a load), printed one, theory's
    return _proof(
        slip.with_slope_times(None),
        printed_slip,
        engine_slip,
        {"printed I-K": ratio_before_k, "printed K-J": ratio_after_k},
        also_holds=ratio_before_k * ratio_after_k < 0,
    )


def _slope_as_product(case: Case) -> VerdictAndNumbers:
    """Prove that equation (18) is misprinted: it needs the slope dQ/dP at the load P_Y of the stick
    edge, not dQ/dP times P_Y as printed. The product depends on the unit of load; two are tried,
    and the better one must be wrong. Returns whether it is proven, and the slip in either unit over
    that of half-plane theory (the engine).

    `case` is the paper's ellipse of loads on one profile; `unit_load` is P0/3, a third of the mean
    normal load.
    """
    # the slip of one point in the first part of forward slip [length], by theory and by (18)
    slip = _SlipFromIToJ(case)
    engine_slip = slip.by_engine
    printed_ratios = {
        "printed in N/mm": slip.with_slope_times(1.0) / engine_slip,
        "printed in P0/3": slip.with_slope_times(case.unit_load) / engine_slip,
    }
    nearest_ratio = min(printed_ratios.values(), key=lambda ratio: abs(ratio - 1))
    # mended slip (the slope is not multiplied by a load), printed one, theory's
    return _proof(
        slip.with_slope_times(None), nearest_ratio * engine_slip, engine_slip, printed_ratios
    )


def _slip_out_of_contact(case: Case) -> VerdictAndNumbers:
    """Prove that the second line of equation (16) is misprinted. It gives the movement of the point
    x = a0, out of contact, from the event E (begin of reverse slip) to F (least normal load). As
    printed it has int_a^x dx' / sqrt(x'^2 - c^2), as mended a root of x'^2 - a^2. Returns whether
    it is proven, and the relative error of each.

    # notation: a, c half-widths of contact and stick zone, P_c the normal load whose contact
    #           half-width is c, a0 contact half-width at the mean load

    `case` is the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    slip_factor = case.compliance * case.friction / math.pi  # A f/pi, with A = 2/E*
    x = case.unit_length  # a0
    time_of_e = case.time_of("E")
    time_of_f = case.time_of("F")

    def rate_as_printed(time: Array) -> Array:
        """Rate of movement of the point x by the paper's equation (16) as printed. It is (A f/pi)
        [2 dP_c/dt int_c^x − dP/dt int_a^x], with the same root in both integrals. Here a and c are
        the half-widths of contact and stick zone; slip is reverse, from event E to G.
        """
        normal_load, _ = formulas.loads(time)  # P and Q
        normal_load_rate, _ = formulas.rates(time)  # dP/dt and dQ/dt
        stick_edge_load = formulas.stick_edge_load("EG", time)  # P_c, with half-width c
        # int_c^x and int_a^x of dx' / sqrt(x'^2 - c^2)
        integral_from_c = formulas.arccosh_ratio(x, stick_edge_load)  # arccosh(x/c)
        half_width = case.contact.half_width(normal_load)
        integral_from_a = integral_from_c - formulas.arccosh_ratio(half_width, stick_edge_load)
        stick_edge_load_rate = formulas.stick_edge_load_rate("EG", time)
        sum_of_terms = (
            2 * stick_edge_load_rate * integral_from_c - normal_load_rate * integral_from_a
        )
        return slip_factor * sum_of_terms  # A f/pi

    def rate_as_mended(time: Array) -> Array:
        """Rate of movement by equation (16) as mended."""
        return formulas.slip_rate("EG", x, time)

    # movement as mended, as printed, and by half-plane theory
    return _proof(
        integral(rate_as_mended, time_of_e, time_of_f),
        integral(rate_as_printed, time_of_e, time_of_f),
        formulas.engine_slip(x, time_of_e, time_of_f),  # movement between these times
        {},
    )


def _gap_for_slope(case: Case) -> VerdictAndNumbers:
    """Prove that h_o in the paper's equation (15), printed as a gap, must be the slope of a gap.

    Equation (15) gives the slip of a point by an integral over the loads, with h_o in the
    integrand. The integrand is the slip by each load increment on the flat punch that sticks, of
    half-width c. Three readings of h_o are tried: the slope 1/sqrt(x^2 - c^2) of the gap that an
    increment of load opens beside that punch; this gap itself; and the gap x^2/(2 R) of the roller,
    here called "gap of the punch". The slip is taken from the event J to M, the second part of
    forward slip, at x = 0.8 a0; a0 is the contact half-width at the mean load.

    With the slope the slip is that of half-plane theory (the engine). It also grows as that does
    where all lengths and loads are ten times as large, at the same stresses. With either gap it
    does neither.

    Returns whether it is proven, and numbers by name. "right" is the error with the slope,
    "printed" the lesser one of both gaps. The others are errors, and exponents n of the slip, which
    grows as length^n. `case` is the paper's ellipse of loads on one profile; `unit_length` is a0.
    """
    # half-plane theory's slip of that point between these events, and its exponent
    large_case = case.scaled_ten_times()
    engine_slip = _slip_after_j(case)
    exponent_of_engine = math.log10(_slip_after_j(large_case) / engine_slip)

    # slip by equation (15) with each reading of h_o: relative error, and exponent
    errors = {}
    exponents = {}
    for reading in ("slope", "gap of the increment", "gap of the punch"):
        slip_by_15 = _slip_by_15(case, 0.8 * case.unit_length, reading)
        slip_of_large_case = _slip_by_15(large_case, 0.8 * large_case.unit_length, reading)
        errors[reading] = _relative_error(slip_by_15, engine_slip)
        exponents[reading] = math.log10(slip_of_large_case / slip_by_15)

    error_of_slope = errors.pop("slope")
    least_error_of_gaps = min(errors.values())
    numbers = {
        "right": error_of_slope,
        "printed": least_error_of_gaps,
        "power of the slip": exponent_of_engine,
    }
    numbers |= {f"power with the {reading}": exponent for reading, exponent in exponents.items()}
    numbers |= {f"error with the {reading}": error for reading, error in errors.items()}
    # AGREEMENT_TOLERANCE: 1e-9
    grows_alike = abs(exponents["slope"] - exponent_of_engine) <= AGREEMENT_TOLERANCE
    # the errors prove it if that of the slope is at most 1e-9, that of both gaps above 1e-3
    return is_misprint_proven(error_of_slope, least_error_of_gaps) and grows_alike, numbers


def _slip_after_j(case: Case) -> float:
    """Half-plane theory's slip [length] from the event J to M at the point x = 0.8 a0."""
    x = 0.8 * case.unit_length
    return Formulas(case).engine_slip(x, case.time_of("J"), case.time_of("M"))


def _slip_by_15(case: Case, x: float, reading: str) -> float:
    """Slip [length] of the point x [length] between the events J and M (second part of forward
    slip) by the paper's equation (15): the time integral of (A f/pi) h_o C dP/dt.

    # notation: A = 2/E*, f friction, c half-width of the stick zone; C the multiplier of the
    #           paper's equation (14), (dQ/dP)/f - 1

    `reading` is what h_o is, the integral from c to x of one of three functions of x': "slope",
    1/sqrt(x'^2 - c^2); "gap of the increment", arccosh(x'/c); "gap of the punch", x'^2/(2 R).
    `case` is the paper's ellipse of loads on a parabola of radius R.
    """
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    radius = case.scene.profile.model_dump()["radius"]

    def scaled_slip_rate(time: Array) -> Array:
        """ds/dt of the slip s at the point x over A f/pi: h_o C dP/dt by the paper's equation (15),
        with h_o, an integral from c to x, as `reading` has it. The multiplier C is (dQ/dP)/f - 1; c
        is the half-width of the stick zone. Forward slip is in its second part, from event J to M.
        """
        # the normal load whose contact half-width is c
        stick_edge_load = formulas.stick_edge_load("JM", time)
        stick_half_width = np.asarray(case.contact.half_width(stick_edge_load))
        arccosh_ratio = formulas.arccosh_ratio(x, stick_edge_load)  # arccosh(x/c)
        integrals = {
            "slope": arccosh_ratio,
            "gap of the increment": x * arccosh_ratio
            - np.sqrt(np.maximum(x**2 - stick_half_width**2, 0.0)),
            "gap of the punch": (x**3 - stick_half_width**3) / (6 * radius),
        }
        # C dP/dt times h_o
        return formulas.multiplied_load_rate("JM", time) * integrals[reading]

    slip_factor = case.compliance * case.friction / math.pi  # A f/pi
    return slip_factor * formulas.integral_while_slipping("JM", x, scaled_slip_rate)


def _stick_displacement(hertz_case: Case) -> VerdictAndNumbers:
    """Prove that equation (17), the displacement of a point out of contact in full stick, has a
    factor 2 f too much. As mended it is dU = (A/pi) arccosh(x/a) dQ, a the contact half-width, A =
    2/E*.

    Both are compared with half-plane theory's displacement (the engine's) at x = 1.1 a0 between the
    events G (end of reverse slip) and H (least Q), at two coefficients of friction. Returns whether
    it is proven, and the relative errors of both.

    `hertz_case` is the paper's ellipse of loads on a parabola; `unit_length` is a0, the contact
    half-width at the mean load.
    """

    def mended_over_engine(friction: float) -> float:
        """Displacement of the point x = 1.1 a0, out of contact in full stick, from event G to H by
        the paper's mended equation (17), over that of half-plane theory. a0 is the contact
        half-width at the mean load.
        """
        # the same loads with this friction and no mean shear force
        case = hertz_case.with_zero_mean_shear(friction)
        formulas = Formulas(case)  # the paper's equations, with their misprints mended
        x = 1.1 * case.unit_length
        time_of_g = case.time_of("G")
        time_of_h = case.time_of("H")

        def integrand(time: Array) -> Array:
            """dQ/dt arccosh(x/a), a the contact half-width."""
            normal_load, _ = formulas.loads(time)
            _, tangential_rate = formulas.rates(time)
            return tangential_rate * formulas.arccosh_ratio(x, normal_load)

        integral_of_17 = integral(integrand, time_of_g, time_of_h)
        engine_displacement = formulas.engine_slip(x, time_of_g, time_of_h)  # between these times
        return case.compliance / math.pi * integral_of_17 / engine_displacement

    ratios = {friction: mended_over_engine(friction) for friction in (1.0, 0.6)}
    printed_ratios = {friction: 2 * friction * ratio for friction, ratio in ratios.items()}
    mended_error = max(abs(ratio - 1) for ratio in ratios.values())
    printed_error = min(abs(ratio - 1) for ratio in printed_ratios.values())
    # proven if the mended error is at most 1e-9 and the printed one above 1e-3
    return is_misprint_proven(mended_error, printed_error), {
        "right": mended_error,
        "printed": printed_error,
        **{f"factor at f = {friction}": ratio for friction, ratio in printed_ratios.items()},
    }


# --------------------------------------------------------------------------------------------- work
@dataclass(frozen=True, eq=False)
class _PartsOfWork:
    """W(x), the friction work per area of a cycle under a parabola, by readings of the paper's
    equations (23) and (24). They give the part of each phase of slip, over the W(x) of half-plane
    theory (the engine).

    Every reading is a time integral of f^2/(pi R) sqrt(a^2 - x^2) arccosh(...) C dP/dt, while the
    point slips.

    # notation: a, c half-widths of contact and stick zone, R radius, C the multiplier (dQ/dP)/f ± 1
    #           of the paper's equation (14)
    """

    formulas: Formulas
    x: float  # [length]
    engine_density: float  # W(x) of the engine

    def root_factor(self, time: Array) -> Array:
        """f^2/(pi R) sqrt(a^2 - x^2) over half-plane theory's W(x): the factor that every reading
        has.
        """
        case = self.formulas.case
        radius = case.scene.profile.model_dump()["radius"]
        normal_load, _ = self.formulas.loads(time)
        half_width = case.contact.half_width(normal_load)
        difference_of_squares = np.maximum(np.square(half_width) - self.x * self.x, 0.0)
        factor_of_root = case.friction**2 / (math.pi * radius)
        return factor_of_root * np.sqrt(difference_of_squares) / self.engine_density

    def mended(self, phase: str) -> float:
        """Part of W(x), the work per area, in a phase of slip ("EG", "IJ" or "JM") by the mended
        equations, over half-plane theory's W(x) at the point `x`: with arccosh(x/c) and |C dP|,
        where C dP is C dP_Y from I to J.

        # notation: c half-width of the stick zone, P_Y the load whose contact half-width is c, C
        #           multiplier of the paper's equation (14)
        """

        def integrand(time: Array) -> Array:
            """Integrand over time: `root_factor` is what all readings of the equation share."""
            stick_edge_load = self.formulas.stick_edge_load(phase, time)
            arccosh_ratio = self.formulas.arccosh_ratio(self.x, stick_edge_load)
            load_rate = np.abs(self.formulas.multiplied_load_rate(phase, time))
            return self.root_factor(time) * load_rate * arccosh_ratio

        return self.formulas.integral_while_slipping(phase, self.x, integrand)

    def with_multiplier_as_c(self, phase: str, length_unit: float) -> float:
        """Part of W(x), the work per area, in a phase of slip ("EG", "IJ" or "JM"), with the
        printed arccosh(x/C), over half-plane theory's W(x) at the point `x`. C, the multiplier of
        the paper's equation (14), has no unit, so that the part depends on the unit of length.

        `length_unit` is the scene's unit of length in the unit that is tried: 1 to take x in the
        scene's own unit.
        """

        def integrand(time: Array) -> Array:
            """Integrand over time: `root_factor` is what all readings of the equation share."""
            ratio = length_unit * self.x / np.abs(self.formulas.multiplier_c(phase, time))
            arccosh_ratio = np.arccosh(np.maximum(ratio, 1.0))
            load_rate = np.abs(self.formulas.multiplied_load_rate(phase, time))  # |C dP/dt|
            return self.root_factor(time) * load_rate * arccosh_ratio

        return self.formulas.integral_while_slipping(phase, self.x, integrand)

    def time_with_real_arccosh(self, phase: str) -> float:
        """How long x/|C| is at least 1 while x slips, so that its arccosh is a real number."""
        return self.formulas.integral_while_slipping(
            phase, self.x, lambda time: self.x >= np.abs(self.formulas.multiplier_c(phase, time))
        )

    def with_printed_sign(self, phase: str) -> float:
        """Part of W(x), the work per area, in a phase of slip ("EG", "IJ" or "JM"), with the
        printed minus and C dP with its sign. It is over half-plane theory's W(x) at the point `x`.
        The arccosh is the mended one, arccosh(x/c).

        # notation: c half-width of the stick zone, C multiplier of the paper's equation (14)
        """

        def integrand(time: Array) -> Array:
            """Integrand over time: `root_factor` is what all readings of the equation share."""
            load_rate, _ = self.formulas.rates(time)  # dP/dt
            # the normal load whose contact half-width is c
            stick_edge_load = self.formulas.stick_edge_load(phase, time)
            arccosh_ratio = self.formulas.arccosh_ratio(self.x, stick_edge_load)  # arccosh(x/c)
            multiplier = self.formulas.multiplier_c(phase, time)
            return -self.root_factor(time) * arccosh_ratio * multiplier * load_rate

        return self.formulas.integral_while_slipping(phase, self.x, integrand)


def _misprints_of_work(case: Case, x: float) -> dict[str, VerdictAndNumbers]:
    """Prove that equations (11), (23) and (24) on the dissipation are misprinted, at the place x
    [length] of the peak of W(x), the dissipation per area, for a parabola. Returns name of a
    misprint -> (whether it is proven, numbers).

    (23) and (24) have arccosh(x/C), where C is also the multiplier of equation (14), and a minus
    before the integral. As mended they have arccosh(x/c), c the half-width of the stick zone, and
    no minus. All values are over half-plane theory's W(x). `case` is the paper's ellipse of loads.
    """
    # parts of W(x) by phases of slip (_PHASES: reverse slip EG, forward slip IJ and JM), mended and
    # with the printed sign; `case.unit_length` is the contact half-width at the mean load
    formulas = Formulas(case)  # the paper's equations, with their misprints mended
    solution = case.solve(x=[x / case.unit_length], fields=("dissipation_density",))
    parts_of_work = _PartsOfWork(formulas, x, float(solution.dissipation_density[0]))
    mended_parts = {f"mended {phase}": parts_of_work.mended(phase) for phase in _PHASES}
    printed_parts = {
        f"printed {phase}": parts_of_work.with_printed_sign(phase) for phase in _PHASES
    }

    # W(x) with the printed arccosh, in two units of length: the scene's is the millimetre
    sum_in_millimetres = sum(parts_of_work.with_multiplier_as_c(phase, 1.0) for phase in _PHASES)
    sum_in_metres = sum(parts_of_work.with_multiplier_as_c(phase, 1e-3) for phase in _PHASES)
    # how long the point slips, and how long the printed arccosh is a real number
    slip_time = sum(formulas.integral_while_slipping(phase, x, np.ones_like) for phase in _PHASES)
    time_with_real_arccosh = sum(map(parts_of_work.time_with_real_arccosh, _PHASES))
    numbers_of_arccosh = {
        "share of time with a real arccosh": time_with_real_arccosh / slip_time,
        "in millimetres": sum_in_millimetres,
        "in metres": sum_in_metres,
    }

    mended_sum = sum(mended_parts.values())
    printed_sum = sum(printed_parts.values())
    # half-plane theory's value is 1
    return {
        "(23), (24), arccosh": _proof(mended_sum, sum_in_millimetres, 1.0, numbers_of_arccosh),
        "(23), (24), sign": _proof(
            mended_sum,
            printed_sum,
            1.0,
            printed_parts | mended_parts,
            also_holds=printed_parts["printed JM"] < 0 < mended_parts["mended JM"],
        ),
        "(11)": _integral_over_face(case),
    }


def _integral_over_face(case: Case) -> VerdictAndNumbers:
    """Prove what equation (11) is: the integral of W(x), the dissipation per area, over the contact
    face, and not a work per area. It grows with the square of all lengths and loads at the same
    stresses, and W(x) with their first power. Returns whether it is proven, and numbers.

    `case` is the paper's ellipse of loads on one profile; its half-widths and places x are over the
    contact half-width at the mean load, and `unit_work` is the unit of dissipation.
    """
    # powers of ten by which both grow when all lengths and loads are ten times as large
    fields = ("dissipation_density", "dissipation")
    solution = case.solve(x=[1.0], fields=fields, steady=True)
    large_solution = case.scaled_ten_times().solve(x=[1.0], fields=fields, steady=True)
    power_of_density = math.log10(
        large_solution.dissipation_density[0] / solution.dissipation_density[0]
    )
    power_of_work = math.log10(large_solution.dissipation / solution.dissipation)

    # The integral of W(x), in parts: W(x) has corners at the edges of the slip zone, and at the
    # contact half-widths of the events F to J.
    corners = sorted(
        {
            case.permanent_stick_half_width,
            case.largest_half_width,
            *map(case.half_width_at, "FGHIJ"),
        }
    )
    parts_of_work = (
        integral(lambda x: sum_over_phases(case.density_of_phases(x)), begin, end)
        for begin, end in pairwise(corners)
    )
    # twice: W(x) is even, and the integral is over x > 0
    dissipation_by_integral = 2 * sum(parts_of_work) * case.unit_work
    error_of_integral = _relative_error(dissipation_by_integral, case.steady_cycle.dissipation)

    # AGREEMENT_TOLERANCE: 1e-9
    powers_hold = (
        abs(power_of_density - 1) <= AGREEMENT_TOLERANCE
        and abs(power_of_work - 2) <= AGREEMENT_TOLERANCE
    )
    return (
        error_of_integral <= AGREEMENT_TOLERANCE and powers_hold,
        {
            "power of W(x)": power_of_density,
            "power of (11)": power_of_work,
            "right": error_of_integral,
        },
    )
