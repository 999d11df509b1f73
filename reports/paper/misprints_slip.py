"""The paper's misprints about slip, work and cross-references, each held against the engine."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from reports.paper.cases import Case, Paper, total
from reports.paper.formulas import Formulas, integral, share
from reports.paper.tables import EXACT, Misprint, proves, small
from scenes import Hertz
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]

_PHASES = ("EG", "IJ", "JM")


def slip_misprints(paper: Paper) -> list[Misprint]:
    """Misprints of slip and work, in the order of the paper, cross-references last."""
    peak = float(paper.peaks[0].place)
    return [
        rate_of_the_front(paper.hertz),
        gap_for_slope(paper.hertz),
        second_root(paper.hertz),
        stick_displacement(paper.hertz),
        product_for_argument(paper.hertz),
        argument_of_arccosh(paper.hertz, peak),
        sign_and_multiplier(paper.hertz, peak),
        name_of_the_front(paper.hertz),
        not_per_area(paper.hertz),
        equation_before_23(paper.hertz),
        net_displacement(paper.hertz),
        earlier_article(),
    ]


def rate_of_the_front(case: Case, x: float = 1.05) -> Misprint:
    """Equation (14), I-J: C times dP, at a point in contact from I to J."""
    formulas, place = Formulas(case), x * case.length

    def rate(t: Array, of: Array) -> Array:
        reached = formulas.multiplier("IJ", t) * formulas.reach(place, formulas.front("IJ", t))
        return np.asarray(case.compliance * case.friction / math.pi * reached * of)

    right = printed = 0.0
    for t, weights in formulas.windows("IJ", place):
        right += integral(rate(t, formulas.front_rate("IJ", t)), weights)
        printed += integral(rate(t, formulas.rates(t)[0]), weights)
    t, weights = graded(case.time("K"), case.time("J"))
    moved = formulas.moved(place, case.time("I"), case.time("J"))
    after = integral(rate(t, formulas.rates(t)[0]), weights) / moved
    errors = {"right": share(right, moved), "printed": share(printed, moved)}
    before = printed / moved - after
    return Misprint(
        "(14), I–J",
        "section 3, equation (14)",
        "C = (1/f) (dQ/dP)(P_Y) − 1",
        "C = [(1/f) (dQ/dP)(P_Y) − 1] dP_Y/dP, as in (18)",
        f"slip of x = {x} a0 from I to J by (13), (15), over the engine's: as printed {before:+.1%} up to K, where dP changes its "
        f"sign, and {after:+.1%} after K; with dP_Y/dP the error is {small(errors['right'])}",
        proves(errors["right"], errors["printed"]) and before * after < 0,
        errors | {"printed I-K": before, "printed K-J": after},
    )


def gap_for_slope(case: Case, x: float = 0.8) -> Misprint:
    """Equation (15): what h_o is. Slip from J to M, and how it grows with all lengths and loads at the same stresses."""
    readings = {name: _by_15(case, x, name) for name in ("slope", "gap of the increment", "gap of the punch")}
    larger = _ten_times(case)
    powers = {name: math.log10(_by_15(larger, x, name) / value) for name, value in readings.items()}
    moved, grown = (Formulas(each).moved(x * each.length, each.time("J"), each.time("M")) for each in (case, larger))
    errors = {name: share(value, moved) for name, value in readings.items()}
    power = math.log10(grown / moved)
    gaps = ("gap of the increment", "gap of the punch")
    return Misprint(
        "(15)",
        "section 3, equation (15)",
        "h_o: the gap before loading",
        "h_o: the slope of the gap that an increment of load on a flat punch of half-width c opens, 1/√(x² − c²)",
        f"lengths and loads times ten: the slip of x = {x} a0 from J to M grows as the power {power:.4f} of length. So does (15) "
        f"with the slope ({powers['slope']:.4f}), but not with the gap beside that flat punch ({powers[gaps[0]]:.4f}) nor with the "
        f"roller's gap x²/(2R) ({powers[gaps[1]]:.4f}). Error of the slip: {small(errors['slope'])} with the slope, "
        f"{errors[gaps[0]]:.0%} and {errors[gaps[1]]:.0%} with the gaps in millimetres",
        proves(errors["slope"], min(errors[name] for name in gaps)) and abs(powers["slope"] - power) <= EXACT,
        {"right": errors["slope"], "printed": min(errors[name] for name in gaps), "power of the slip": power}
        | {f"power with the {name}": value for name, value in powers.items()},
    )


def _by_15(case: Case, x: float, reading: str) -> float:
    """Slip of x from J to M by equation (15) with a reading of h_o, integrated over x from the stick edge c."""
    profile = case.scene.profile
    if not isinstance(profile, Hertz):
        raise TypeError("the gap x^2/(2R) is that of Hertz")
    formulas, place = Formulas(case), x * case.length
    whole = 0.0
    for t, weights in formulas.windows("JM", place):
        front = formulas.front("JM", t)
        c, slope = np.asarray(case.contact.half_width(front)), formulas.reach(place, front)
        integrals = {
            "slope": slope,
            "gap of the increment": place * slope - np.sqrt(np.maximum(place**2 - c**2, 0.0)),
            "gap of the punch": (place**3 - c**3) / (6 * profile.radius),
        }
        whole += integral(formulas.driving("JM", t) * integrals[reading], weights)
    return case.compliance * case.friction / math.pi * whole


def second_root(case: Case, x: float = 1.0) -> Misprint:
    """Equation (16), second line: a point out of contact from E to F."""
    formulas, place = Formulas(case), x * case.length
    begin, end = case.time("E"), case.time("F")
    t, weights = graded(begin, end)
    p, dp = formulas.loads(t)[0], formulas.rates(t)[0]
    front = formulas.front("EG", t)
    # int_a^x dx / sqrt(x^2 - c^2), as printed
    printed_root = formulas.reach(place, front) - formulas.reach(case.contact.half_width(p), front)
    factor = case.compliance * case.friction / math.pi
    printed = factor * (2 * formulas.front_rate("EG", t) * formulas.reach(place, front) - dp * printed_root)
    moved = formulas.moved(place, begin, end)
    right = integral(formulas.slip_rate("EG", place, t), weights)
    errors = {"right": share(right, moved), "printed": share(integral(printed, weights), moved)}
    return Misprint(
        "(16), second line",
        "section 3",
        "second integral over √(x² − c²)",
        "√(x² − a²), as in (18) and (19)",
        f"movement of x = {x} a0 from E to F, out of contact: printed off the engine's by {errors['printed']:.1%}, mended by "
        f"{small(errors['right'])}",
        proves(errors["right"], errors["printed"]),
        errors,
    )


def stick_displacement(case: Case, x: float = 1.1) -> Misprint:
    """Equation (17): a point out of contact from G to H, in full stick, at two coefficients of friction."""
    ratios, worst = {}, 0.0
    for friction in (1.0, 0.6):
        other = case.about_no_shear(friction)
        formulas, place = Formulas(other), x * other.length
        t, weights = graded(other.time("G"), other.time("H"))
        moved = formulas.moved(place, other.time("G"), other.time("H"))
        sum_ = integral(formulas.rates(t)[1] * formulas.reach(place, formulas.loads(t)[0]), weights)
        worst = max(worst, share(other.compliance / math.pi * sum_, moved))
        ratios[friction] = friction * 2 * other.compliance / math.pi * sum_ / moved
    wrong = min(abs(ratio - 1) for ratio in ratios.values())
    return Misprint(
        "(17)",
        "section 3",
        "f ΔP (1+κ)/(πμ) dQ/dP",
        "ΔQ (1+κ)/(2πμ): no f, and 2πμ",
        f"movement of x = {x} a0 from G to H, out of contact: the printed factor is {ratios[1.0]:.4f} times the engine's at f = 1 "
        f"and {ratios[0.6]:.4f} times at f = 0.6 (2 f); mended off by {small(worst)}",
        proves(worst, wrong) and all(abs(ratio / (2 * f) - 1) <= EXACT for f, ratio in ratios.items()),
        {"right": worst, "printed": wrong} | {f"factor at f = {f}": ratio for f, ratio in ratios.items()},
    )


def product_for_argument(case: Case, x: float = 1.05) -> Misprint:
    """Equation (18): dQ/dP times P_Y, in two units of load, at a point in contact from I to J."""
    formulas, place, units = Formulas(case), x * case.length, {"N/mm": 1.0, "P0/3": case.unit}
    moved = formulas.moved(place, case.time("I"), case.time("J"))
    right, printed = 0.0, dict.fromkeys(units, 0.0)
    for t, weights in formulas.windows("IJ", place):
        load, slope = formulas.front("IJ", t), case.friction * (formulas.multiplier("IJ", t) + 1)
        rest = case.compliance / math.pi * formulas.front_rate("IJ", t) * formulas.reach(place, load) / moved
        right += integral((slope - case.friction) * rest, weights)
        for name, unit in units.items():
            printed[name] += integral((slope * load / unit - case.friction) * rest, weights)
    errors = {"right": share(right, 1.0), "printed": min(abs(ratio - 1) for ratio in printed.values())}
    return Misprint(
        "(18)",
        "section 3, equation (18)",
        "(dQ/dP) P_Y − f, a product",
        "(dQ/dP)(P_Y) − f: the slope dQ/dP at the point Y",
        f"slip of x = {x} a0 from I to J: as a product {printed['N/mm']:.1f} times the engine's with loads in N/mm and "
        f"{printed['P0/3']:.2f} times in units of P0/3, for a load is subtracted from a number; with the slope at Y the error is "
        f"{small(errors['right'])}",
        proves(errors["right"], errors["printed"]),
        errors | {f"printed in {name}": ratio for name, ratio in printed.items()},
    )


def _root(case: Case, x: float, p: Array) -> Array:
    """f^2/(pi R) sqrt(a^2 - x^2) of equation (24)."""
    profile = case.scene.profile
    if not isinstance(profile, Hertz):
        raise TypeError("equation (24) is about Hertz")
    under = np.maximum(np.square(case.contact.half_width(p)) - x * x, 0.0)
    return np.asarray(case.friction**2 / (math.pi * profile.radius) * np.sqrt(under))


def _density(case: Case, x: float) -> float:
    """The engine's W(x), x in scene units."""
    return float(case.solve(x=[x / case.length], fields=("dissipation_density",)).dissipation_density[0])


def argument_of_arccosh(case: Case, x: float) -> Misprint:
    """Equations (23), (24): arccosh(x/C) with the multiplier C of (14), in millimetres and in metres, at the peak of W(x)."""
    formulas, density = Formulas(case), _density(case, x)
    right, real, whole = 0.0, 0.0, 0.0
    printed = {1.0: 0.0, 1e-3: 0.0}
    for phase in _PHASES:
        for t, weights in formulas.windows(phase, x):
            rate = _root(case, x, formulas.loads(t)[0]) * np.abs(formulas.driving(phase, t))
            right += integral(rate * formulas.reach(x, formulas.front(phase, t)), weights)
            multiplier = np.abs(formulas.multiplier(phase, t))
            for unit in printed:
                argument = unit * x / multiplier
                printed[unit] += integral(rate * np.arccosh(np.maximum(argument, 1.0)), weights)
            real += integral(x / multiplier >= 1, weights)
            whole += float(np.sum(weights))
    errors = {"right": share(right, density), "printed": share(printed[1.0], density)}
    return Misprint(
        "(23), (24), arccosh",
        "section 4.1",
        "arccosh(x/C), C also being the multiplier (14)",
        "arccosh(x/c), c the stick half-width",
        f"W at its peak: with c off the engine's by {small(errors['right'])}; with |C| the arccosh is real for {real / whole:.0%} "
        f"of the time of slip, and that part sums to {printed[1.0] / density:.0%} of W in millimetres, "
        f"{printed[1e-3] / density:.0%} in metres",
        proves(errors["right"], errors["printed"]),
        errors | {"share of time with a real arccosh": real / whole, "in metres": printed[1e-3] / density},
    )


def sign_and_multiplier(case: Case, x: float) -> Misprint:
    """Equations (23), (24): the leading minus and C dP throughout, at the peak of W(x)."""
    formulas = Formulas(case)
    density = _density(case, x)
    printed, right = dict.fromkeys(_PHASES, 0.0), dict.fromkeys(_PHASES, 0.0)
    for phase in _PHASES:
        for t, weights in formulas.windows(phase, x):
            rest = _root(case, x, formulas.loads(t)[0]) * formulas.reach(x, formulas.front(phase, t))
            printed[phase] -= integral(rest * formulas.multiplier(phase, t) * formulas.rates(t)[0], weights) / density
            right[phase] += integral(rest * np.abs(formulas.driving(phase, t)), weights) / density
    errors = {"right": share(sum(right.values()), 1.0), "printed": share(sum(printed.values()), 1.0)}
    return Misprint(
        "(23), (24), sign",
        "section 4.1",
        "a leading minus, and C dP throughout",
        "|C dP|, with dP_Y in I–J",
        f"W at its peak: as printed (c for C in the arccosh) I–J gives {printed['IJ']:+.1%} and J–M {printed['JM']:+.1%} of W; "
        f"mended {right['IJ']:.1%} and {right['JM']:.1%}, the sum off the engine's by {small(errors['right'])}",
        proves(errors["right"], errors["printed"]) and printed["JM"] < 0 < right["JM"],
        errors | {f"printed {phase}": value for phase, value in printed.items()},
    )


def name_of_the_front(case: Case, x: float = 1.0) -> Misprint:
    """Equation (19): P_K is a front, not the load at K."""
    formulas, place = Formulas(case), x * case.length
    begin, end = case.time("J"), case.time("J") + 0.5 * (case.time("M") - case.time("J"))
    t, weights = graded(begin, end)
    moved = formulas.moved(place, begin, end)
    right = integral(formulas.slip_rate("JM", place, t), weights)
    outside = case.compliance * case.friction / math.pi * formulas.rates(t)[0] * formulas.reach(place, formulas.loads(t)[0])
    errors = {"right": share(right, moved), "printed": share(integral(outside, weights), moved)}
    front = float(formulas.front("JM", case.time("M"))) / case.unit
    at_k = case.events["K"].normal_load / case.unit
    return Misprint(
        "P_K in (19)",
        "section 3",
        "P_K",
        "a moving front, not the load at point K",
        f"with the front P_c = (v_min − u)/(2f), {front:.3f} at M, the slip of x = {x} a0 after J is off the engine's by "
        f"{small(errors['right'])}; the load at K is {at_k:.3g} and constant: no slip at all",
        proves(errors["right"], errors["printed"]),
        errors | {"front at M": front, "load at K": at_k},
    )


def not_per_area(case: Case) -> Misprint:
    """Equation (11): ten times all lengths and loads, the same stresses."""
    larger = _ten_times(case)
    powers = {name: math.log10(_work(larger, name) / _work(case, name)) for name in ("density", "dissipation")}
    whole = share(_integral_of_density(case), 1.0)
    return Misprint(
        "(11)",
        "section 3",
        "(11) is called a rate of work per unit area",
        "(11) is an integral over x: work of the whole contact, per unit thickness",
        f"lengths and loads times ten: W(x) grows as the power {powers['density']:.6f} of length, its integral (11) as "
        f"{powers['dissipation']:.6f}, which is a power per thickness; the integral meets the global figure to {small(whole)}",
        whole <= EXACT and abs(powers["density"] - 1) <= EXACT and abs(powers["dissipation"] - 2) <= EXACT,
        {"power of W(x)": powers["density"], "power of (11)": powers["dissipation"], "right": whole},
    )


def _ten_times(case: Case) -> Case:
    """The case with all lengths and loads times ten: the same stresses."""
    scene, load = case.scene, case.load
    return Case(scene.vary(profile={"radius": 10 * scene.profile.model_dump()["radius"]})).with_load(
        mean_normal_load=10 * load.mean_normal_load,
        normal_amplitude=10 * load.normal_amplitude,
        mean_tangential_load=10 * load.mean_tangential_load,
        tangential_amplitude=10 * load.tangential_amplitude,
    )


def _work(case: Case, name: str) -> float:
    solution = case.solve(x=[1.0], fields=("dissipation_density", "dissipation"), steady=True)
    return float(solution.dissipation if name == "dissipation" else solution.dissipation_density[0])


def _integral_of_density(case: Case) -> float:
    """Integral of W(x) over the contact as a share of the engine's global figure: in parts between the edges at events."""
    loads = [case.events[letter].normal_load for letter in "FGHIJ"]
    marks = sorted({case.stick_edge, case.outer_edge, *(float(case.width(load)) for load in loads)})
    whole = 0.0
    for begin, end in pairwise(marks):
        x, weights = graded(begin, end)
        whole += 2 * integral(total(case.density(x)), weights)
    return whole * case.work_unit / case.steady.dissipation


def equation_before_23(case: Case, x: float = 0.8) -> Misprint:
    """Section 4.1: which equation becomes (23)."""
    formulas, place = Formulas(case), x * case.length
    slipped = moved = 0.0
    for t, weights in formulas.windows("JM", place):
        slipped += integral(formulas.slip_rate("JM", place, t), weights)
        moved += formulas.moved(place, case.time("I"), case.time("M"))
    net = formulas.moved(place, case.time("G"), case.time("G") + 2 * math.pi) / moved
    errors = {"right": share(slipped, moved), "printed": share(net, 1.0)}
    return Misprint(
        "reference before (23)",
        "section 4.1",
        "(12) is said to become (23)",
        "(15), with (16) to (19)",
        f"(15) gives the forward slip of x = {x} a0 to {small(errors['right'])}; (12) is a closed integral that is zero there "
        f"({small(abs(net))} of that slip)",
        proves(errors["right"], errors["printed"]),
        errors,
    )


def net_displacement(case: Case, x: float = 0.8) -> Misprint:
    """Section 4.1: which equation says that there is no net displacement."""
    formulas = Formulas(case)
    start = case.time("G")
    movement = case.solve(time=start + np.linspace(0, 2 * math.pi, 101), x=[x], fields=("slip",)).slip[:, 0]
    net = abs(formulas.moved(x * case.length, start, start + 2 * math.pi)) / float(np.ptp(movement))
    work = case.steady.dissipation / case.work_unit
    return Misprint(
        "net displacement",
        "section 4.1",
        "(11) is cited for the displacement that a cycle leaves, zero",
        "(12)",
        f"over a cycle (11) sums to W = {work:.5f} A f² P0², which is not zero; (12) to {small(net)} of the movement of x = {x} a0",
        net <= EXACT and work > 1e-3,
        {"right": net, "printed": work},
    )


def earlier_article() -> Misprint:
    """Sections 2: which article is meant; nothing to evaluate."""
    return Misprint(
        "reference [7]",
        "section 2",
        "[7] is cited, twice, for the procedure",
        "[11], Barber, Davies and Hills 2011",
        "by reading, not by number: [7] in the list of references is Ciavarella 1998, who is not among the authors and takes P as "
        "constant; the procedure under periodic P and Q is that of [11]",
        None,
        {},
    )
