"""The paper's misprints, each held against the engine: whether it is proven and the numbers that the words of paper.toml name.

`right` and `printed` are the errors of the mended and of the printed reading, as shares of what the engine says.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.paper.cases import Case, Paper, sliding_limit, total
from reports.paper.formulas import Formulas, integral
from reports.paper.tables import EXACT, Found, Rule, proves, rule
from scenes import PolygonLoad

Array = NDArray[np.float64]

_PHASES = ("EG", "IJ", "JM")
MISPRINTS: dict[str, Rule] = {}


def share(found: float, right: float) -> float:
    """Relative error."""
    return abs(found / right - 1)


def _readings(right: float, printed: float, moved: float) -> dict[str, float]:
    """Errors of the mended and the printed reading of what the engine says is `moved`."""
    return {"right": share(right, moved), "printed": share(printed, moved)}


def _proven(errors: dict[str, float]) -> bool:
    return proves(errors["right"], errors["printed"])


# -------------------------------------------------------------------------------------------- loads, friction and tractions
@rule(MISPRINTS, "(2)")
def corrective_load(paper: Paper, friction: float = 0.5, part: float = 0.6) -> Found:
    """Cattaneo and Mindlin's problem, Q = 0.6 f P."""
    case, p = paper.hertz, paper.hertz.load.mean_normal_load
    q = part * friction * p
    scene = case.scene.vary(load=PolygonLoad(initial_loading=((p, 0.0), (p, q))), friction=friction)
    x = np.linspace(0.0, 0.999, 200) * case.length
    shear = semi_analytic.solve(scene, x=x, time=[2.0], fields=("shear",)).shear[0]

    def error(second: float) -> float:
        found = friction * (case.contact.pressure(x, p) - (case.contact.pressure(x, second) if second > 0 else 0.0))
        return float(np.max(np.abs(found - shear)) / np.max(np.abs(shear)))

    errors = {"right": error(p - q / friction), "printed": error(q - p), "sign turned only": error(p - q)}
    return proves(errors["right"], min(errors["printed"], errors["sign turned only"])), errors


@rule(MISPRINTS, "condition of stick")
def stick_condition(paper: Paper) -> Found:
    """When full stick holds: the share of instants at which each reading is wrong."""
    case, times = paper.hertz, paper.hertz.round_times(721)
    times = (times[1:] + times[:-1]) / 2
    solution = case.solve(time=times)
    sticks = solution.contact_half_width - solution.stick_half_width <= EXACT * case.length
    dp, dq = Formulas(case).rates(times)
    printed = float(np.mean((dq / dp < case.friction) != sticks))
    right = float(np.mean(((np.abs(dq / dp) < case.friction) & (dp > 0)) != sticks))
    return right == 0 and printed > 0.01, {"printed": printed, "right": right}


@rule(MISPRINTS, "(9), (10)")
def letters_of_nine(paper: Paper) -> Found:
    """The point is G."""
    case, formulas = paper.hertz, Formulas(paper.hertz)
    b, g = (float(case.width((formulas.level(name, 1) - formulas.level("E", -1)) / (2 * case.friction))) for name in "BG")
    errors = _readings(g, b, case.stick_edge)
    return _proven(errors), errors | {"with B": b, "with G": g, "permanent stick": case.stick_edge}


@rule(MISPRINTS, "3H")
def least_normal_load(paper: Paper) -> Found:
    """Where the normal load is least."""
    case = paper.hertz
    p, q = (float(loads.min()) for loads in case.loads(case.round_times(3601)))
    numbers = {f"P at {letter}": case.events[letter].normal_load / case.unit for letter in "HF"}
    numbers |= {f"Q at {letter}": case.events[letter].tangential_load / case.unit for letter in "HF"}
    holds = abs(numbers["P at F"] - p) < EXACT < numbers["P at H"] - p and abs(numbers["Q at H"] - q) < EXACT
    return holds, numbers | {"least P": p, "least Q": q}


@rule(MISPRINTS, "J and K")
def order_of_letters(paper: Paper) -> Found:
    """J is named before K."""
    case = paper.hertz
    j, i = (math.degrees(case.time(letter) - case.time("K")) for letter in "JI")
    front = share(case.events["J"].front_load, case.events["G"].normal_load)
    degrees = {"J after K in degrees": j, "I after K in degrees": i, "I before K in degrees": -i}
    return front <= EXACT and i < 0 < j, degrees | {"front at J against P_G": front}


@rule(MISPRINTS, "mean shear force")
def mean_force(paper: Paper) -> Found:
    """Which of Q0 and Q1 does not matter: the change of the closed integral of Q dU when each is halved."""
    case, load, changes = paper.hertz, paper.hertz.load, {}
    for reading, name in (("right", "mean_tangential_load"), ("printed", "tangential_amplitude")):
        other = case.with_load(initial_loading="straight", **{name: getattr(load, name) / 2})
        changes[reading] = share(other.steady.loop_work, case.steady.loop_work)
    return _proven(changes), changes


@rule(MISPRINTS, "(25)")
def sliding_condition(paper: Paper) -> Found:
    """Circles between the two formulas slide; the engine's limit is within a share of 1e-10 of the mended one."""
    friction = np.array([0.1, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0])
    right, printed, bracket = sliding_limit(friction), math.sqrt(2) * (1 + friction) / (2 * friction), 1e-10

    def slides(f: Array, ratio: Array) -> NDArray[np.bool_]:
        return np.asarray(semi_analytic.dissipation(**paper.hertz.circles(f, ratio)).reason == semi_analytic.Reason.SLIDING)

    apart = np.abs(friction - 1) > EXACT
    between = printed[apart] + (right - printed)[apart] * np.linspace(0.01, 0.99, 99)[:, None]
    sliding = float(np.mean(slides(friction[apart], between)))
    met = slides(friction, right * (1 - bracket)) & ~slides(friction, right * (1 + bracket))
    errors = {"right": bracket if met.all() else math.nan, "printed": float(np.min(np.abs(printed / right - 1)[apart]))}
    return sliding == 1 and _proven(errors), errors | {
        "apart at f = 1": share(float(printed[4]), float(right[4])),
        "sliding share between": sliding,
        "circles between": between.size,
        "mended limit at f = 0.4": float(right[1]),
        "printed limit at f = 0.4": float(printed[1]),
    }


@rule(MISPRINTS, "flat-and-rounded law")
def flat_and_rounded_law(paper: Paper) -> Found:
    """The contact law of section 4.2, from the pressure that the engine computes; (1 + kappa)/mu = 2 A."""
    case, load, profile = paper.rounded, paper.rounded.load.mean_normal_load, paper.rounded.scene.profile.model_dump()
    flat, radius = profile["flat_half_length"], profile["radius"]
    # x = a sin(angle), in two parts: the pressure's root at the edge becomes smooth, its singular slope at x = b lies at an end.
    corner = math.asin(flat / case.length)

    def pressure(angle: Array) -> Array:
        return case.contact.pressure(case.length * np.sin(angle), load) * case.length * np.cos(angle)

    carried = 2 * (integral(pressure, 0.0, corner) + integral(pressure, corner, math.pi / 2))
    right_side = (math.pi - 2 * corner) / (4 * math.sin(corner) ** 2) - 1 / math.tan(corner) / 2
    a, b = (carried * radius * 2 * case.compliance / (4 * length**2) for length in (case.length, flat))
    errors = _readings(b, a, right_side)
    sides = {"left side over a²": a, "left side over b²": b, "right side": right_side, "b/a": flat / case.length}
    return _proven(errors), errors | sides


# ------------------------------------------------------------------------------------------------------------ slip and work
@rule(MISPRINTS, "(14), I–J")
def rate_of_the_front(paper: Paper) -> Found:
    """Equation (14), I-J: C times dP, at a point in contact from I to J."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), 1.05 * paper.hertz.length

    def slope(t: Array) -> Array:
        reached = formulas.multiplier("IJ", t) * formulas.reach(x, formulas.front("IJ", t))
        return case.compliance * case.friction / math.pi * reached

    def as_printed(t: Array) -> Array:
        return slope(t) * formulas.rates(t)[0]

    moved = formulas.moved(x, case.time("I"), case.time("J"))
    right = formulas.rubbing("IJ", x, lambda t: slope(t) * formulas.front_rate("IJ", t))
    printed = formulas.rubbing("IJ", x, as_printed)
    after = integral(as_printed, case.time("K"), case.time("J")) / moved
    errors, before = _readings(right, printed, moved), printed / moved - after
    return _proven(errors) and before * after < 0, errors | {"printed I-K": before, "printed K-J": after}


@rule(MISPRINTS, "(15)")
def gap_for_slope(paper: Paper) -> Found:
    """What h_o is: slip from J to M at 0.8 a0, and how it grows with all lengths and loads at the same stresses."""
    names, sizes = ("slope", "gap of the increment", "gap of the punch"), (paper.hertz, paper.hertz.ten_times())
    moved, grown = (Formulas(each).moved(0.8 * each.length, each.time("J"), each.time("M")) for each in sizes)
    slips = {name: [_by_15(each, 0.8 * each.length, name) for each in sizes] for name in names}
    errors = {name: share(pair[0], moved) for name, pair in slips.items()}
    powers = {f"power with the {name}": math.log10(pair[1] / pair[0]) for name, pair in slips.items()}
    power, printed = math.log10(grown / moved), min(errors[name] for name in names[1:])
    numbers = {"right": errors["slope"], "printed": printed, "power of the slip": power}
    numbers |= powers | {f"error with the {name}": errors[name] for name in names[1:]}
    return proves(errors["slope"], printed) and abs(powers["power with the slope"] - power) <= EXACT, numbers


def _by_15(case: Case, x: float, reading: str) -> float:
    """Slip of x from J to M by equation (15) with a reading of h_o, integrated over x from the stick edge c; Hertz."""
    formulas, radius = Formulas(case), case.scene.profile.model_dump()["radius"]

    def rate(t: Array) -> Array:
        front = formulas.front("JM", t)
        c, slope = np.asarray(case.contact.half_width(front)), formulas.reach(x, front)
        integrals = {
            "slope": slope,
            "gap of the increment": x * slope - np.sqrt(np.maximum(x**2 - c**2, 0.0)),
            "gap of the punch": (x**3 - c**3) / (6 * radius),
        }
        return formulas.driving("JM", t) * integrals[reading]

    return case.compliance * case.friction / math.pi * formulas.rubbing("JM", x, rate)


@rule(MISPRINTS, "(16), second line")
def second_root(paper: Paper) -> Found:
    """A point out of contact from E to F; as printed: int_a^x dx / sqrt(x^2 - c^2)."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), paper.hertz.length
    begin, end = case.time("E"), case.time("F")

    def printed(t: Array) -> Array:
        front, inside = formulas.front("EG", t), formulas.reach(x, formulas.front("EG", t))
        root = inside - formulas.reach(case.contact.half_width(formulas.loads(t)[0]), front)
        whole = 2 * formulas.front_rate("EG", t) * inside - formulas.rates(t)[0] * root
        return case.compliance * case.friction / math.pi * whole

    right = integral(lambda t: formulas.slip_rate("EG", x, t), begin, end)
    errors = _readings(right, integral(printed, begin, end), formulas.moved(x, begin, end))
    return _proven(errors), errors


@rule(MISPRINTS, "(17)")
def stick_displacement(paper: Paper) -> Found:
    """A point out of contact from G to H, in full stick, at two coefficients of friction."""
    ratios, worst = {}, 0.0
    for f in (1.0, 0.6):
        case = paper.hertz.about_no_shear(f)
        formulas, x = Formulas(case), 1.1 * case.length
        g, h = case.time("G"), case.time("H")
        moved = formulas.moved(x, g, h)
        sheared = integral(lambda t, of=formulas, at=x: of.rates(t)[1] * of.reach(at, of.loads(t)[0]), g, h)  # type: ignore[misc]
        worst = max(worst, share(case.compliance / math.pi * sheared, moved))
        ratios[f] = f * 2 * case.compliance / math.pi * sheared / moved
    errors = {"right": worst, "printed": min(abs(ratio - 1) for ratio in ratios.values())}
    doubled = all(abs(ratio / (2 * f) - 1) <= EXACT for f, ratio in ratios.items())
    return _proven(errors) and doubled, errors | {f"factor at f = {f}": ratio for f, ratio in ratios.items()}


@rule(MISPRINTS, "(18)")
def product_for_argument(paper: Paper) -> Found:
    """dQ/dP times P_Y, in two units of load, at a point in contact from I to J."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), 1.05 * paper.hertz.length
    moved = formulas.moved(x, case.time("I"), case.time("J"))

    def slip(unit: float | None) -> float:
        """The slip over the engine's; without a unit the slope is not multiplied."""

        def rate(t: Array) -> Array:
            load, slope = formulas.front("IJ", t), case.friction * (formulas.multiplier("IJ", t) + 1)
            product = slope * load / unit if unit else slope
            rest = case.compliance / math.pi * formulas.front_rate("IJ", t) * formulas.reach(x, load) / moved
            return (product - case.friction) * rest

        return formulas.rubbing("IJ", x, rate)

    printed = {"printed in N/mm": slip(1.0), "printed in P0/3": slip(case.unit)}
    errors = {"right": share(slip(None), 1.0), "printed": min(abs(ratio - 1) for ratio in printed.values())}
    return _proven(errors), errors | printed


def _root(case: Case, x: float, t: Array) -> Array:
    """f^2/(pi R) sqrt(a^2 - x^2) of equation (24), Hertz."""
    under = np.maximum(np.square(case.contact.half_width(Formulas(case).loads(t)[0])) - x * x, 0.0)
    return case.friction**2 / (math.pi * case.scene.profile.model_dump()["radius"]) * np.sqrt(under)


def _peak(paper: Paper) -> tuple[float, float]:
    """Place of the peak of W(x) and the engine's W there, Hertz."""
    x = float(paper.peaks[0].place)
    solution = paper.hertz.solve(x=[x / paper.hertz.length], fields=("dissipation_density",))
    return x, float(solution.dissipation_density[0])


@rule(MISPRINTS, "(23), (24), arccosh")
def argument_of_arccosh(paper: Paper) -> Found:
    """arccosh(x/C) with the multiplier C of (14), in millimetres and in metres, at the peak of W(x)."""
    case, formulas, (x, density) = paper.hertz, Formulas(paper.hertz), _peak(paper)

    def work(phase: str, unit: float | None) -> float:
        """W of a phase over all W; without a unit of length as mended."""

        def rate(t: Array) -> Array:
            if unit is None:
                reached = formulas.reach(x, formulas.front(phase, t))
            else:
                reached = np.arccosh(np.maximum(unit * x / np.abs(formulas.multiplier(phase, t)), 1.0))
            return _root(case, x, t) * np.abs(formulas.driving(phase, t)) * reached / density

        return formulas.rubbing(phase, x, rate)

    def real_time(phase: str) -> float:
        return formulas.rubbing(phase, x, lambda t: x >= np.abs(formulas.multiplier(phase, t)))

    right, millimetres, metres = (sum(work(phase, unit) for phase in _PHASES) for unit in (None, 1.0, 1e-3))
    real = sum(real_time(phase) for phase in _PHASES)
    whole = sum(formulas.rubbing(phase, x, np.ones_like) for phase in _PHASES)
    errors = _readings(right, millimetres, 1.0)
    shares = {"share of time with a real arccosh": real / whole, "in millimetres": millimetres, "in metres": metres}
    return _proven(errors), errors | shares


@rule(MISPRINTS, "(23), (24), sign")
def sign_and_multiplier(paper: Paper) -> Found:
    """The leading minus and C dP throughout, at the peak of W(x)."""
    case, formulas, (x, density) = paper.hertz, Formulas(paper.hertz), _peak(paper)
    printed, mended = {}, {}
    for phase in _PHASES:

        def rest(t: Array, of: str = phase) -> Array:
            return _root(case, x, t) * formulas.reach(x, formulas.front(of, t)) / density

        def minus(t: Array, of: str = phase) -> Array:
            return -rest(t, of) * formulas.multiplier(of, t) * formulas.rates(t)[0]

        def size(t: Array, of: str = phase) -> Array:
            return rest(t, of) * np.abs(formulas.driving(of, t))

        printed[f"printed {phase}"], mended[f"mended {phase}"] = (formulas.rubbing(phase, x, way) for way in (minus, size))
    errors = _readings(sum(mended.values()), sum(printed.values()), 1.0)
    return _proven(errors) and printed["printed JM"] < 0 < mended["mended JM"], errors | printed | mended


@rule(MISPRINTS, "P_K in (19)")
def name_of_the_front(paper: Paper) -> Found:
    """P_K is a front, not the load at K."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), paper.hertz.length
    begin, end = case.time("J"), (case.time("J") + case.time("M")) / 2
    right = integral(lambda t: formulas.slip_rate("JM", x, t), begin, end)
    outside = integral(lambda t: formulas.rates(t)[0] * formulas.reach(x, formulas.loads(t)[0]), begin, end)
    errors = _readings(right, case.compliance * case.friction / math.pi * outside, formulas.moved(x, begin, end))
    front = float(formulas.front("JM", case.time("M"))) / case.unit
    return _proven(errors), errors | {"front at M": front, "load at K": case.events["K"].normal_load / case.unit}


@rule(MISPRINTS, "(11)")
def not_per_area(paper: Paper) -> Found:
    """Ten times all lengths and loads, the same stresses; the integral of W(x) in parts between the edges at events."""
    case, fields = paper.hertz, ("dissipation_density", "dissipation")
    small, large = (each.solve(x=[1.0], fields=fields, steady=True) for each in (case, case.ten_times()))
    density = math.log10(large.dissipation_density[0] / small.dissipation_density[0])
    work = math.log10(large.dissipation / small.dissipation)
    edges = (float(case.width(case.events[letter].normal_load)) for letter in "FGHIJ")
    marks = sorted({case.stick_edge, case.outer_edge, *edges})
    halves = (integral(lambda x: total(case.density(x)), begin, end) for begin, end in pairwise(marks))
    whole = share(2 * sum(halves) * case.work_unit, case.steady.dissipation)
    holds = whole <= EXACT and abs(density - 1) <= EXACT and abs(work - 2) <= EXACT
    return holds, {"power of W(x)": density, "power of (11)": work, "right": whole}


@rule(MISPRINTS, "reference before (23)")
def equation_before_23(paper: Paper) -> Found:
    """Which equation becomes (23)."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), 0.8 * paper.hertz.length
    slipped = formulas.rubbing("JM", x, lambda t: formulas.slip_rate("JM", x, t))
    moved = formulas.moved(x, case.time("I"), case.time("M"))
    net = formulas.moved(x, case.time("G"), case.time("G") + 2 * math.pi) / moved
    errors = {"right": share(slipped, moved), "printed": share(net, 1.0)}
    return _proven(errors), errors | {"net over the slip": abs(net)}


@rule(MISPRINTS, "net displacement")
def net_displacement(paper: Paper) -> Found:
    """Which equation says that there is no net displacement."""
    case, start = paper.hertz, paper.hertz.time("G")
    movement = case.solve(time=start + np.linspace(0, 2 * math.pi, 101), x=[0.8], fields=("slip",)).slip[:, 0]
    net = abs(Formulas(case).moved(0.8 * case.length, start, start + 2 * math.pi)) / float(np.ptp(movement))
    work = case.steady.dissipation / case.work_unit
    return net <= EXACT and work > 1e-3, {"right": net, "printed": work}


@rule(MISPRINTS, "reference [7]")
def earlier_article(_: Paper) -> Found:
    """Which article is meant: nothing to evaluate."""
    return None, {}
