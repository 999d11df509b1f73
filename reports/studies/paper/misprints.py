"""The paper's misprints, each held against the engine: whether it is proven and the numbers that
the words of paper.toml name.

`right` and `printed` are the errors of the mended and of the printed reading, as shares of what the
engine says.
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
from reports.studies.paper.tables import AGREEMENT_TOLERANCE, VerdictAndNumbers, proves
from scenes import PolygonLoad
from scenes.array_types import Array

_PHASES = ("EG", "IJ", "JM")


def prove_misprints(paper: Paper) -> dict[str, VerdictAndNumbers]:
    """Key of a misprint -> whether it is proven (None: by reading) and its numbers."""
    proof_of = _misprints_of_cycle(paper.hertz_case) | _misprints_of_slip(paper.hertz_case)
    proof_of |= work(paper.hertz_case, float(paper.peaks[0].place))
    proof_of["(25)"] = _sliding_condition(paper.hertz_case)
    proof_of["flat-and-rounded law"] = _rounded_law(paper.rounded_case)
    proof_of["reference [7]"] = (None, {})
    return proof_of


def _relative_error(value: float, truth: float) -> float:
    """|value/truth - 1|."""
    return abs(value / truth - 1)


def _proof(
    right: float, printed: float, truth: float, numbers: Mapping[str, float], holds: bool = True
) -> VerdictAndNumbers:
    """Whether the mended and the printed reading of a value that the engine gives as `truth` prove
    a misprint; their errors, and other numbers that the words name.
    """
    errors = {"right": _relative_error(right, truth), "printed": _relative_error(printed, truth)}
    return proves(errors["right"], errors["printed"]) and holds, {**errors, **numbers}


# -------------------------------------------------------------------- loads, friction and tractions
def _misprints_of_cycle(case: Case) -> dict[str, VerdictAndNumbers]:
    """Prove the misprints in sections 2 and 3 of the paper, by computing with each reading: which
    loads, events (the letters A to M) and conditions are meant. Returns, by name of the misprint,
    whether it is proven, and numbers.

    `case` is the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)
    events = case.events
    level_of_e = formulas.q_plus_f_p("E", -1)

    def edge_with(letter: str) -> float:
        """Half-width of permanent stick with the level of Q - f P at this event."""
        return float(
            case.scaled_half_width(
                (formulas.q_plus_f_p(letter, 1) - level_of_e) / (2 * case.friction)
            )
        )

    edge_with_b = edge_with("B")
    edge_with_g = edge_with("G")
    angle_of_j = math.degrees(case.time_of("J") - case.time_of("K"))
    angle_of_i = math.degrees(case.time_of("I") - case.time_of("K"))
    error_of_front = _relative_error(events["J"].front_load, events["G"].normal_load)
    angles_after_k = {
        "J after K in degrees": angle_of_j,
        "I after K in degrees": angle_of_i,
        "I before K in degrees": -angle_of_i,
    }

    def loop_work_halved(name: str) -> float:
        """The closed integral of Q dU, when a load is halved."""
        changes = {name: getattr(case.load, name) / 2}
        return case.with_load(initial_loading="straight", **changes).steady_cycle.loop_work

    work_at_half_mean = loop_work_halved("mean_tangential_load")
    work_at_half_amplitude = loop_work_halved("tangential_amplitude")
    named_numbers = {
        "with B": edge_with_b,
        "with G": edge_with_g,
        "permanent stick": case.stick_edge,
    }
    return {
        "(2)": _corrective_load(case),
        "condition of stick": _condition_of_stick(case),
        "(9), (10)": _proof(edge_with_g, edge_with_b, case.stick_edge, named_numbers),
        "3H": _event_of_least_load(case),
        "J and K": (
            error_of_front <= AGREEMENT_TOLERANCE and angle_of_i < 0 < angle_of_j,
            angles_after_k | {"front at J against P_G": error_of_front},
        ),
        "mean shear force": _proof(
            work_at_half_mean, work_at_half_amplitude, case.steady_cycle.loop_work, {}
        ),
        "net displacement": _net_displacement(case),
    }


def _condition_of_stick(case: Case) -> VerdictAndNumbers:
    """Prove that the paper's condition of full stick is misprinted: dQ/dP < f as printed, |dQ/dP| <
    f with growing P as mended. Each is compared with the engine at instants of the steady cycle:
    the share of these that it gets wrong. Returns whether it is proven, and the shares.

    `case` is the paper's ellipse of loads on one profile.
    """
    times = case.cycle_times(721)
    times = (times[1:] + times[:-1]) / 2
    solution = case.solve(time=times)
    sticks = (
        solution.contact_half_width - solution.stick_half_width
        <= AGREEMENT_TOLERANCE * case.unit_length
    )
    rate_of_p, rate_of_q = Formulas(case).rates(times)
    slope = rate_of_q / rate_of_p
    printed_condition = slope < case.friction
    right_condition = (np.abs(slope) < case.friction) & (rate_of_p > 0)
    printed_share = float(np.mean(printed_condition != sticks))
    right_share = float(np.mean(right_condition != sticks))
    return (
        right_share == 0 and printed_share > 0.01,
        {"printed": printed_share, "right": right_share},
    )


def _event_of_least_load(case: Case) -> VerdictAndNumbers:
    """Prove that P is least at the event F of the paper's cycle, and Q at H, where the paper has P
    least at H. Returns whether it is proven, and the loads.

    `case` is the paper's ellipse of loads on one profile.
    """
    events = case.events
    loads_of_cycle = case.loads(case.cycle_times(3601))
    least_p = float(loads_of_cycle[0].min())
    least_q = float(loads_of_cycle[1].min())
    loads_at_letters = {
        f"P at {letter}": events[letter].normal_load / case.unit_load for letter in "HF"
    }
    loads_at_letters |= {
        f"Q at {letter}": events[letter].tangential_load / case.unit_load for letter in "HF"
    }
    is_least = (
        abs(loads_at_letters["P at F"] - least_p)
        < AGREEMENT_TOLERANCE
        < loads_at_letters["P at H"] - least_p
        and abs(loads_at_letters["Q at H"] - least_q) < AGREEMENT_TOLERANCE
    )
    return is_least, loads_at_letters | {"least P": least_p, "least Q": least_q}


def _net_displacement(case: Case) -> VerdictAndNumbers:
    """Prove that what is 0 after a revolution is the net slip, and not the dissipation as printed,
    at x = 0.8 a0. Returns whether it is proven, with the net slip over the range of slip, and the
    dissipation in the paper's unit.

    `case` is the paper's ellipse of loads on one profile.
    """
    start = case.time_of("G")
    revolution = start + np.linspace(0, 2 * math.pi, 101)
    slip = case.solve(time=revolution, x=[0.8], fields=("slip",)).slip[:, 0]
    net_slip = abs(Formulas(case).engine_slip(0.8 * case.unit_length, start, start + 2 * math.pi))
    relative_net_slip = net_slip / float(np.ptp(slip))
    dissipation = case.steady_cycle.dissipation / case.unit_work
    return (
        relative_net_slip <= AGREEMENT_TOLERANCE and dissipation > 1e-3,
        {"right": relative_net_slip, "printed": dissipation},
    )


def _corrective_load(
    case: Case, friction: float = 0.5, share_of_limit: float = 0.6
) -> VerdictAndNumbers:
    """Prove that equation (2) is misprinted, on Cattaneo and Mindlin's problem: f times a
    difference of two pressures is the engine's shear with the mended corrective load, not with the
    printed one. Returns whether it is proven, and the error of each reading.

    `case` gives profile and normal load; Q is `share_of_limit` times f P.
    """
    normal_load = case.load.mean_normal_load
    tangential_load = share_of_limit * friction * normal_load
    scene = case.scene.vary(
        load=PolygonLoad(initial_loading=((normal_load, 0.0), (normal_load, tangential_load))),
        friction=friction,
    )
    x = np.linspace(0.0, 0.999, 200) * case.unit_length
    shear = semi_analytic.solve(scene, x=x, time=[2.0], fields=("shear",)).shear[0]

    def error(corrective_load: float) -> float:
        """Largest difference of f (p at P − p at that load) from the engine's shear, over the
        latter's largest value.
        """
        pressure = case.contact.pressure(x, normal_load)
        if corrective_load > 0:
            pressure = pressure - case.contact.pressure(x, corrective_load)
        return float(np.max(np.abs(friction * pressure - shear)) / np.max(np.abs(shear)))

    errors = {
        "right": error(normal_load - tangential_load / friction),
        "printed": error(tangential_load - normal_load),
        "sign turned only": error(normal_load - tangential_load),
    }
    return proves(errors["right"], min(errors["printed"], errors["sign turned only"])), errors


def _sliding_condition(case: Case) -> VerdictAndNumbers:
    """Prove that the paper's condition of gross sliding is misprinted, for loads that go round a
    circle in the plane of P and Q. Circles between the printed and the mended limit of P0/P1 slide,
    and the engine's limit is within 1e-10 of the mended one. Returns whether it is proven, and
    numbers.

    `case` is the paper's ellipse of loads on one profile.
    """
    friction = np.array([0.1, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0])
    mended_limit = sliding_limit(friction)
    printed_limit = math.sqrt(2) * (1 + friction) / (2 * friction)
    relative_distance = 1e-10

    def slides(f: Array, ratio: Array) -> NDArray[np.bool_]:
        """Whether the engine says that circles of P0/P1 = `ratio` slide."""
        batch = semi_analytic.dissipation(**case.circle_arguments(f, ratio))
        return np.asarray(batch.reason == semi_analytic.Reason.SLIDING)

    is_not_one = np.abs(friction - 1) > AGREEMENT_TOLERANCE  # at f = 1 both formulas agree
    distance = (mended_limit - printed_limit)[is_not_one]
    ratios_between = printed_limit[is_not_one] + distance * np.linspace(0.01, 0.99, 99)[:, None]
    sliding_share = float(np.mean(slides(friction[is_not_one], ratios_between)))
    slides_below = slides(friction, mended_limit * (1 - relative_distance))
    slides_above = slides(friction, mended_limit * (1 + relative_distance))
    error_of_right = relative_distance if (slides_below & ~slides_above).all() else math.nan
    errors = {
        "right": error_of_right,
        "printed": float(np.min(np.abs(printed_limit / mended_limit - 1)[is_not_one])),
    }
    return sliding_share == 1 and proves(errors["right"], errors["printed"]), errors | {
        "apart at f = 1": _relative_error(float(printed_limit[4]), float(mended_limit[4])),
        "sliding share between": sliding_share,
        "circles between": ratios_between.size,
        "mended limit at f = 0.4": float(mended_limit[1]),
        "printed limit at f = 0.4": float(printed_limit[1]),
    }


def _rounded_law(case: Case) -> VerdictAndNumbers:
    """Prove that the paper's contact law of the flat and rounded profile (section 4.2) is
    misprinted: its left side is over b^2, not over a^2 as printed. P is the integral of the
    engine's pressure; the paper's (1 + kappa)/mu is 2 A. Returns whether it is proven, and both
    sides.

    `case` is the paper's ellipse of loads on this profile.
    """
    load = case.load.mean_normal_load
    profile = case.scene.profile.model_dump()
    flat_half_length = profile["flat_half_length"]
    radius = profile["radius"]
    # x = a sin(angle), in two parts: the pressure's root at the edge becomes smooth, its singular
    # slope at x = b lies at an end.
    angle_of_corner = math.asin(flat_half_length / case.unit_length)

    def load_per_angle(angle: Array) -> Array:
        """Pressure times dx/d(angle), x = a sin(angle)."""
        x = case.unit_length * np.sin(angle)
        return case.contact.pressure(x, load) * case.unit_length * np.cos(angle)

    carried_load = 2 * (
        integral(load_per_angle, 0.0, angle_of_corner)
        + integral(load_per_angle, angle_of_corner, math.pi / 2)
    )
    first_term = (math.pi - 2 * angle_of_corner) / (4 * math.sin(angle_of_corner) ** 2)
    right_side = first_term - 1 / math.tan(angle_of_corner) / 2

    def left_side_over(length: float) -> float:
        """Left side of the law, with the square of this length as divisor."""
        return carried_load * radius * 2 * case.compliance / (4 * length**2)

    left_side_over_a = left_side_over(case.unit_length)
    left_side_over_b = left_side_over(flat_half_length)
    sides = {
        "left side over a²": left_side_over_a,
        "left side over b²": left_side_over_b,
        "right side": right_side,
        "b/a": flat_half_length / case.unit_length,
    }
    return _proof(left_side_over_b, left_side_over_a, right_side, sides)


# --------------------------------------------------------------------------------------------- slip
def _misprints_of_slip(case: Case) -> dict[str, VerdictAndNumbers]:
    """Prove that equations (14) to (19) are misprinted: slip and movement between two events of the
    cycle (the paper's letters), at points in and out of contact, by the printed and the mended
    formula. Returns, by name of the misprint, whether it is proven, and numbers.

    `case` is the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)
    time_of = {letter: case.time_of(letter) for letter in "GIJM"}
    proofs_in_contact = _slip_in_contact(case)

    # After J: P_K is a front; as a constant load it leaves what the open surface does.
    x_of_edge = case.unit_length
    phase = time_of["J"], (time_of["J"] + time_of["M"]) / 2
    slip_factor = case.compliance * case.friction / math.pi

    def open_surface(time: Array) -> Array:
        """Rate of slip that is left where P_K is a constant load."""
        load, _ = formulas.loads(time)
        load_rate, _ = formulas.rates(time)
        return slip_factor * load_rate * formulas.arccosh_ratio(x_of_edge, load)

    slip_mended = integral(lambda time: formulas.slip_rate("JM", x_of_edge, time), *phase)
    outer_value = integral(open_surface, *phase)
    named_numbers = {
        "front at M": float(formulas.stick_edge_load("JM", time_of["M"])) / case.unit_load,
        "load at K": case.events["K"].normal_load / case.unit_load,
    }

    # (12) is a closed integral; (15) is what becomes (23).
    x_in_contact = 0.8 * case.unit_length
    slip_by_15 = formulas.integral_while_slipping(
        "JM", x_in_contact, lambda time: formulas.slip_rate("JM", x_in_contact, time)
    )
    forward_slip = formulas.engine_slip(x_in_contact, time_of["I"], time_of["M"])
    net_slip = formulas.engine_slip(x_in_contact, time_of["G"], time_of["G"] + 2 * math.pi)
    return {
        "(14), I–J": proofs_in_contact["(14), I–J"],
        "(15)": _gap_for_slope(case),
        "(16), second line": _slip_out_of_contact(case),
        "(17)": _stick_displacement(case),
        "(18)": proofs_in_contact["(18)"],
        "P_K in (19)": _proof(
            slip_mended, outer_value, formulas.engine_slip(x_of_edge, *phase), named_numbers
        ),
        "reference before (23)": _proof(
            slip_by_15, net_slip, forward_slip, {"net over the slip": abs(net_slip / forward_slip)}
        ),
    }


def _slip_in_contact(case: Case) -> dict[str, VerdictAndNumbers]:
    """Prove that equations (14) and (18) are misprinted: slip of a point in contact from the event
    I to J. C is (dQ/dP)/f - 1, P_Y the load whose half-width is that of the stick zone.

    Equation (14) is computed with C dP as printed and with C dP_Y; (18) with dQ/dP times P_Y as
    printed and with dQ/dP at P_Y. Returns, by name, whether each is proven, and numbers. `case` is
    the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)
    factor = case.compliance * case.friction / math.pi
    x = 1.05 * case.unit_length
    moved_distance = formulas.engine_slip(x, case.time_of("I"), case.time_of("J"))

    def rate_by_14(time: Array) -> Array:
        """Rate of slip by equation (14) as printed, C dP."""
        load_rate, _ = formulas.rates(time)
        reach = formulas.arccosh_ratio(x, formulas.stick_edge_load("IJ", time))
        return factor * formulas.multiplier_c("IJ", time) * reach * load_rate

    def slip_by_18(unit: float | None) -> float:
        """Slip with dQ/dP multiplied by the load P_Y in some unit; None: not multiplied."""

        def rate(time: Array) -> Array:
            load = formulas.stick_edge_load("IJ", time)
            slope = case.friction * (formulas.multiplier_c("IJ", time) + 1)
            if unit:
                slope = slope * load / unit
            multiplier = slope / case.friction - 1
            front_rate = formulas.stick_edge_load_rate("IJ", time)
            return multiplier * factor * front_rate * formulas.arccosh_ratio(x, load)

        return formulas.integral_while_slipping("IJ", x, rate)

    slip_right = slip_by_18(None)
    printed_value = formulas.integral_while_slipping("IJ", x, rate_by_14)
    ratio_after = integral(rate_by_14, case.time_of("K"), case.time_of("J")) / moved_distance
    ratios_of_halves = {
        "printed I-K": printed_value / moved_distance - ratio_after,
        "printed K-J": ratio_after,
    }
    ratios_with_unit = {
        "printed in N/mm": slip_by_18(1.0) / moved_distance,
        "printed in P0/3": slip_by_18(case.unit_load) / moved_distance,
    }
    nearest_ratio = min(ratios_with_unit.values(), key=lambda ratio: abs(ratio - 1))
    have_other_signs = ratios_of_halves["printed I-K"] * ratio_after < 0
    return {
        "(14), I–J": _proof(
            slip_right, printed_value, moved_distance, ratios_of_halves, have_other_signs
        ),
        "(18)": _proof(
            slip_right, nearest_ratio * moved_distance, moved_distance, ratios_with_unit
        ),
    }


def _slip_out_of_contact(case: Case) -> VerdictAndNumbers:
    """Prove that the second line of equation (16) is misprinted: movement of a point out of contact
    from event E to F. As printed it has int_a^x dx / sqrt(x^2 - c^2), as mended a root of x^2 -
    a^2. Returns whether it is proven, and numbers.

    `case` is the paper's ellipse of loads on one profile.
    """
    formulas = Formulas(case)
    factor = case.compliance * case.friction / math.pi
    x = case.unit_length
    phase = (case.time_of("E"), case.time_of("F"))

    def rate_by_16(time: Array) -> Array:
        """Rate of slip by equation (16) as printed."""
        load, _ = formulas.loads(time)
        load_rate, _ = formulas.rates(time)
        front = formulas.stick_edge_load("EG", time)
        reach_of_x = formulas.arccosh_ratio(x, front)
        reach_from_edge = reach_of_x - formulas.arccosh_ratio(case.contact.half_width(load), front)
        front_rate = formulas.stick_edge_load_rate("EG", time)
        return factor * (2 * front_rate * reach_of_x - load_rate * reach_from_edge)

    slip_mended = integral(lambda time: formulas.slip_rate("EG", x, time), *phase)
    return _proof(slip_mended, integral(rate_by_16, *phase), formulas.engine_slip(x, *phase), {})


def _gap_for_slope(case: Case) -> VerdictAndNumbers:
    """Prove that h_o in the paper's equation (15), printed as a gap, must be the slope of a gap.

    Equation (15) gives the slip of a point by an integral over the loads, with h_o in the
    integrand: the slip of each load increment on the flat punch that sticks, of half-width c. Three
    readings of h_o are tried: the slope 1/sqrt(x^2 - c^2) of the gap that an increment of load
    opens beside that punch; this gap itself; and the roller's gap x^2/(2 R). The slip is taken
    from the event J to M, the second part of forward slip, at x = 0.8 a0; a0 is the contact
    half-width at the mean load.

    With the slope the slip is the engine's. It also grows as the engine's does where all lengths
    and loads are ten times as large, at the same stresses. With either gap it does neither.

    Returns whether it is proven, and numbers by name: "right" is the error with the slope,
    "printed" the lesser one of both gaps; the others are errors and powers of the length by which
    the slip grows. `case` is the paper's ellipse of loads on one profile.
    """
    case_as_is = case
    case_ten_times = case.scaled_ten_times()
    slip_as_is = _slip_after_j(case_as_is)
    power_of_slip = math.log10(_slip_after_j(case_ten_times) / slip_as_is)
    errors = {}
    powers = {}
    for reading in ("slope", "gap of the increment", "gap of the punch"):
        slip_by_equation = _by_15(case_as_is, 0.8 * case_as_is.unit_length, reading)
        slip_by_equation_ten_times = _by_15(
            case_ten_times, 0.8 * case_ten_times.unit_length, reading
        )
        errors[reading] = _relative_error(slip_by_equation, slip_as_is)
        powers[reading] = math.log10(slip_by_equation_ten_times / slip_by_equation)
    error_of_slope = errors.pop("slope")
    least_error_of_gaps = min(errors.values())
    numbers = {
        "right": error_of_slope,
        "printed": least_error_of_gaps,
        "power of the slip": power_of_slip,
    }
    numbers |= {f"power with the {reading}": value for reading, value in powers.items()}
    numbers |= {f"error with the {reading}": error for reading, error in errors.items()}
    grows_alike = abs(powers["slope"] - power_of_slip) <= AGREEMENT_TOLERANCE
    return proves(error_of_slope, least_error_of_gaps) and grows_alike, numbers


def _slip_after_j(case: Case) -> float:
    """The engine's slip from the event J to M at the point 0.8 a0."""
    return Formulas(case).engine_slip(0.8 * case.unit_length, case.time_of("J"), case.time_of("M"))


def _by_15(case: Case, x: float, reading: str) -> float:
    """Slip of the point x [length] between the events J and M by the paper's equation (15), with
    one `reading` of its h_o: the slope, the gap of the load increment, or the gap of the punch.
    `case` is the paper's ellipse of loads on a parabola.
    """
    formulas = Formulas(case)
    radius = case.scene.profile.model_dump()["radius"]

    def rate(time: Array) -> Array:
        front = formulas.stick_edge_load("JM", time)
        stick_half_width = np.asarray(case.contact.half_width(front))
        slope = formulas.arccosh_ratio(x, front)
        integrals = {
            "slope": slope,
            "gap of the increment": x * slope
            - np.sqrt(np.maximum(x**2 - stick_half_width**2, 0.0)),
            "gap of the punch": (x**3 - stick_half_width**3) / (6 * radius),
        }
        return formulas.multiplied_load_rate("JM", time) * integrals[reading]

    return (
        case.compliance * case.friction / math.pi * formulas.integral_while_slipping("JM", x, rate)
    )


def _stick_displacement(hertz: Case) -> VerdictAndNumbers:
    """Prove that equation (17), the displacement of a point out of contact in full stick, has a
    factor 2 f too much. Between the events G (end of reverse slip) and H the formula without and
    with it is compared with the engine's displacement, at two coefficients of friction. Returns
    whether it is proven, and the errors of both.

    `hertz` is the paper's ellipse of loads on a parabola.
    """

    def ratio_to_engine(friction: float) -> float:
        """A/pi int dQ arccosh(x/a) over the engine's movement."""
        case = hertz.with_zero_mean_shear(friction)
        formulas = Formulas(case)
        x = 1.1 * case.unit_length
        time_of_g = case.time_of("G")
        time_of_h = case.time_of("H")

        def rate(time: Array) -> Array:
            """dQ/dt arccosh(x/a)."""
            load, _ = formulas.loads(time)
            _, tangential_rate = formulas.rates(time)
            return tangential_rate * formulas.arccosh_ratio(x, load)

        sheared_distance = integral(rate, time_of_g, time_of_h)
        return (
            case.compliance
            / math.pi
            * sheared_distance
            / formulas.engine_slip(x, time_of_g, time_of_h)
        )

    ratios = {friction: ratio_to_engine(friction) for friction in (1.0, 0.6)}
    errors = {
        "right": max(abs(ratio - 1) for ratio in ratios.values()),
        "printed": min(abs(2 * friction * ratio - 1) for friction, ratio in ratios.items()),
    }
    return proves(errors["right"], errors["printed"]), errors | {
        f"factor at f = {friction}": 2 * friction * ratio for friction, ratio in ratios.items()
    }


# --------------------------------------------------------------------------------------------- work
@dataclass(frozen=True, eq=False)
class _PartsOfWork:
    """W(x), the friction work per area of a cycle under a parabola, by readings of the paper's
    equations (23) and (24): the part of each phase of slip, over the W(x) of the engine.
    """

    formulas: Formulas
    x: float  # [length]
    density: float  # W(x) of the engine

    def root(self, time: Array) -> Array:
        """f^2/(pi R) sqrt(a^2 - x^2) over W(x): the factor that every reading has."""
        case = self.formulas.case
        radius = case.scene.profile.model_dump()["radius"]
        half_width = case.contact.half_width(self.formulas.loads(time)[0])
        square = np.maximum(np.square(half_width) - self.x * self.x, 0.0)
        return case.friction**2 / (math.pi * radius) * np.sqrt(square) / self.density

    def mended(self, phase: str) -> float:
        """The mended part: with arccosh(x/c), c the half-width of the stick zone, and |C dP|."""

        def rate(time: Array) -> Array:
            reach_ratio = self.formulas.arccosh_ratio(
                self.x, self.formulas.stick_edge_load(phase, time)
            )
            return (
                self.root(time)
                * np.abs(self.formulas.multiplied_load_rate(phase, time))
                * reach_ratio
            )

        return self.formulas.integral_while_slipping(phase, self.x, rate)

    def with_c_as_multiplier(self, phase: str, unit: float) -> float:
        """The part with arccosh(x/C), C being the multiplier (dQ/dP)/f ± 1 of equation (14), not a
        half-width. C has no unit, so that the result depends on the unit of length.
        """

        def rate(time: Array) -> Array:
            ratio = unit * self.x / np.abs(self.formulas.multiplier_c(phase, time))
            reach_ratio = np.arccosh(np.maximum(ratio, 1.0))
            return (
                self.root(time)
                * np.abs(self.formulas.multiplied_load_rate(phase, time))
                * reach_ratio
            )

        return self.formulas.integral_while_slipping(phase, self.x, rate)

    def real_time(self, phase: str) -> float:
        """How long x/C is at least 1 while x slips, so that its arccosh is a real number."""
        return self.formulas.integral_while_slipping(
            phase, self.x, lambda time: self.x >= np.abs(self.formulas.multiplier_c(phase, time))
        )

    def with_minus(self, phase: str) -> float:
        """The part with the printed minus before it, and C dP with its sign in every phase."""

        def rate(time: Array) -> Array:
            load_rate, _ = self.formulas.rates(time)
            reach_ratio = self.formulas.arccosh_ratio(
                self.x, self.formulas.stick_edge_load(phase, time)
            )
            return (
                -self.root(time) * reach_ratio * self.formulas.multiplier_c(phase, time) * load_rate
            )

        return self.formulas.integral_while_slipping(phase, self.x, rate)


def work(case: Case, x: float) -> dict[str, VerdictAndNumbers]:
    """Prove that equations (11), (23) and (24) on the dissipation are misprinted, at the place x
    [length] of the peak of W(x), for a parabola. Returns, by name of the misprint, whether it is
    proven, and numbers.

    `case` is the paper's ellipse of loads.
    """
    formulas = Formulas(case)
    solution = case.solve(x=[x / case.unit_length], fields=("dissipation_density",))
    parts_of_work = _PartsOfWork(formulas, x, float(solution.dissipation_density[0]))
    mended_parts = {f"mended {phase}": parts_of_work.mended(phase) for phase in _PHASES}
    printed_parts = {f"printed {phase}": parts_of_work.with_minus(phase) for phase in _PHASES}
    sum_in_millimetres = sum(parts_of_work.with_c_as_multiplier(phase, 1.0) for phase in _PHASES)
    sum_in_metres = sum(parts_of_work.with_c_as_multiplier(phase, 1e-3) for phase in _PHASES)
    rubbing_time = sum(
        formulas.integral_while_slipping(phase, x, np.ones_like) for phase in _PHASES
    )
    parts = {
        "share of time with a real arccosh": sum(map(parts_of_work.real_time, _PHASES))
        / rubbing_time,
        "in millimetres": sum_in_millimetres,
        "in metres": sum_in_metres,
    }

    sign_differs = printed_parts["printed JM"] < 0 < mended_parts["mended JM"]
    mended_sum = sum(mended_parts.values())
    printed_sum = sum(printed_parts.values())
    return {
        "(23), (24), arccosh": _proof(mended_sum, sum_in_millimetres, 1.0, parts),
        "(23), (24), sign": _proof(
            mended_sum, printed_sum, 1.0, printed_parts | mended_parts, sign_differs
        ),
        "(11)": _integral_over_face(case),
    }


def _integral_over_face(case: Case) -> VerdictAndNumbers:
    """Prove what equation (11) is: the integral of W(x) over the face, not a work per area. It
    grows with the square of all lengths and loads at the same stresses, and W(x) with their first
    power. Returns whether it is proven, and numbers.

    `case` is the paper's ellipse of loads on one profile.
    """
    fields = ("dissipation_density", "dissipation")
    solution_as_is = case.solve(x=[1.0], fields=fields, steady=True)
    solution_ten_times = case.scaled_ten_times().solve(x=[1.0], fields=fields, steady=True)
    power_of_density = math.log10(
        solution_ten_times.dissipation_density[0] / solution_as_is.dissipation_density[0]
    )
    power_of_work = math.log10(solution_ten_times.dissipation / solution_as_is.dissipation)
    # The integral in parts between the edges at events.
    edges = (case.half_width_at(letter) for letter in "FGHIJ")
    places_of_edges = sorted({case.stick_edge, case.outer_edge, *edges})
    parts_of_work = (
        integral(lambda x: sum_over_phases(case.density_of_phases(x)), begin, end)
        for begin, end in pairwise(places_of_edges)
    )
    error = _relative_error(2 * sum(parts_of_work) * case.unit_work, case.steady_cycle.dissipation)
    powers_hold = (
        abs(power_of_density - 1) <= AGREEMENT_TOLERANCE
        and abs(power_of_work - 2) <= AGREEMENT_TOLERANCE
    )
    return (
        error <= AGREEMENT_TOLERANCE and powers_hold,
        {"power of W(x)": power_of_density, "power of (11)": power_of_work, "right": error},
    )
