"""The paper's misprints, each held against the engine: whether it is proven and the numbers that
the words of paper.toml name.

`right` and `printed` are the errors of the mended and of the printed reading, as shares of what the
engine says.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.studies.paper.cases import Case, Formulas, Paper, integral, sliding_limit, total
from reports.studies.paper.tables import EXACT, Found, proves
from scenes import PolygonLoad

Array = NDArray[np.float64]

_PHASES = ("EG", "IJ", "JM")


def proofs(paper: Paper) -> dict[str, Found]:
    """Key of a misprint -> whether it is proven (None: by reading) and its numbers."""
    found = (
        _cycle(paper.hertz) | _slip(paper.hertz) | work(paper.hertz, float(paper.peaks[0].place))
    )
    return found | {
        "(25)": _sliding_condition(paper.hertz),
        "flat-and-rounded law": _rounded_law(paper.rounded),
        "reference [7]": (None, {}),
    }


def _share(found: float, right: float) -> float:
    """Relative error."""
    return abs(found / right - 1)


def _proof(
    right: float, printed: float, moved: float, more: Mapping[str, float], holds: bool = True
) -> Found:
    """Whether the mended and the printed reading of what the engine says is `moved` prove a
    misprint, with their errors.
    """
    errors = {"right": _share(right, moved), "printed": _share(printed, moved)}
    return proves(errors["right"], errors["printed"]) and holds, {**errors, **more}


# -------------------------------------------------------------------- loads, friction and tractions
def _cycle(case: Case) -> dict[str, Found]:
    """Sections 2 and 3: which loads, letters and conditions are meant."""
    formulas, events = Formulas(case), case.events
    # Stick, at instants of the steady cycle: the share at which each reading is wrong.
    times = case.round_times(721)
    times = (times[1:] + times[:-1]) / 2
    solution = case.solve(time=times)
    sticks = solution.contact_half_width - solution.stick_half_width <= EXACT * case.length
    dp, dq = formulas.rates(times)
    printed = float(np.mean((dq / dp < case.friction) != sticks))
    right = float(np.mean(((np.abs(dq / dp) < case.friction) & (dp > 0)) != sticks))

    b, g = (
        float(case.width((formulas.level(name, 1) - formulas.level("E", -1)) / (2 * case.friction)))
        for name in "BG"
    )
    p, q = (float(loads.min()) for loads in case.loads(case.round_times(3601)))
    at = {f"P at {letter}": events[letter].normal_load / case.unit for letter in "HF"}
    at |= {f"Q at {letter}": events[letter].tangential_load / case.unit for letter in "HF"}
    least = abs(at["P at F"] - p) < EXACT < at["P at H"] - p and abs(at["Q at H"] - q) < EXACT
    j, i = (math.degrees(case.time(letter) - case.time("K")) for letter in "JI")
    front = _share(events["J"].front_load, events["G"].normal_load)
    degrees = {"J after K in degrees": j, "I after K in degrees": i, "I before K in degrees": -i}

    def halved(name: str) -> float:
        """The closed integral of Q dU, when a load is halved."""
        changes = {name: getattr(case.load, name) / 2}
        return case.with_load(initial_loading="straight", **changes).steady.loop_work

    mean, amplitude = halved("mean_tangential_load"), halved("tangential_amplitude")
    start = case.time("G")
    movement = case.solve(
        time=start + np.linspace(0, 2 * math.pi, 101), x=[0.8], fields=("slip",)
    ).slip[:, 0]
    net = abs(formulas.moved(0.8 * case.length, start, start + 2 * math.pi)) / float(
        np.ptp(movement)
    )
    whole = case.steady.dissipation / case.work_unit
    named = {"with B": b, "with G": g, "permanent stick": case.stick_edge}
    return {
        "(2)": _corrective_load(case),
        "condition of stick": (right == 0 and printed > 0.01, {"printed": printed, "right": right}),
        "(9), (10)": _proof(g, b, case.stick_edge, named),
        "3H": (least, at | {"least P": p, "least Q": q}),
        "J and K": (front <= EXACT and i < 0 < j, degrees | {"front at J against P_G": front}),
        "mean shear force": _proof(mean, amplitude, case.steady.loop_work, {}),
        "net displacement": (net <= EXACT and whole > 1e-3, {"right": net, "printed": whole}),
    }


def _corrective_load(case: Case, friction: float = 0.5, part: float = 0.6) -> Found:
    """Cattaneo and Mindlin's problem, Q = 0.6 f P."""
    p = case.load.mean_normal_load
    q = part * friction * p
    scene = case.scene.vary(load=PolygonLoad(initial_loading=((p, 0.0), (p, q))), friction=friction)
    x = np.linspace(0.0, 0.999, 200) * case.length
    shear = semi_analytic.solve(scene, x=x, time=[2.0], fields=("shear",)).shear[0]

    def error(second: float) -> float:
        found = friction * (
            case.contact.pressure(x, p) - (case.contact.pressure(x, second) if second > 0 else 0.0)
        )
        return float(np.max(np.abs(found - shear)) / np.max(np.abs(shear)))

    errors = {
        "right": error(p - q / friction),
        "printed": error(q - p),
        "sign turned only": error(p - q),
    }
    return proves(errors["right"], min(errors["printed"], errors["sign turned only"])), errors


def _sliding_condition(case: Case) -> Found:
    """Circles between the two formulas slide; the engine's limit is within a share of 1e-10 of the
    mended one.
    """
    friction = np.array([0.1, 0.4, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0])
    right, printed, bracket = (
        sliding_limit(friction),
        math.sqrt(2) * (1 + friction) / (2 * friction),
        1e-10,
    )

    def slides(f: Array, ratio: Array) -> NDArray[np.bool_]:
        return np.asarray(
            semi_analytic.dissipation(**case.circles(f, ratio)).reason
            == semi_analytic.Reason.SLIDING
        )

    apart = np.abs(friction - 1) > EXACT
    between = printed[apart] + (right - printed)[apart] * np.linspace(0.01, 0.99, 99)[:, None]
    sliding = float(np.mean(slides(friction[apart], between)))
    met = slides(friction, right * (1 - bracket)) & ~slides(friction, right * (1 + bracket))
    errors = {
        "right": bracket if met.all() else math.nan,
        "printed": float(np.min(np.abs(printed / right - 1)[apart])),
    }
    return sliding == 1 and proves(errors["right"], errors["printed"]), errors | {
        "apart at f = 1": _share(float(printed[4]), float(right[4])),
        "sliding share between": sliding,
        "circles between": between.size,
        "mended limit at f = 0.4": float(right[1]),
        "printed limit at f = 0.4": float(printed[1]),
    }


def _rounded_law(case: Case) -> Found:
    """The contact law of section 4.2, from the pressure that the engine computes; (1 + kappa)/mu =
    2 A.
    """
    load, profile = case.load.mean_normal_load, case.scene.profile.model_dump()
    flat, radius = profile["flat_half_length"], profile["radius"]
    # x = a sin(angle), in two parts: the pressure's root at the edge becomes smooth, its singular
    # slope at x = b lies at an end.
    corner = math.asin(flat / case.length)

    def pressure(angle: Array) -> Array:
        return (
            case.contact.pressure(case.length * np.sin(angle), load) * case.length * np.cos(angle)
        )

    carried = 2 * (integral(pressure, 0.0, corner) + integral(pressure, corner, math.pi / 2))
    right_side = (math.pi - 2 * corner) / (4 * math.sin(corner) ** 2) - 1 / math.tan(corner) / 2
    a, b = (
        carried * radius * 2 * case.compliance / (4 * length**2) for length in (case.length, flat)
    )
    sides = {
        "left side over a²": a,
        "left side over b²": b,
        "right side": right_side,
        "b/a": flat / case.length,
    }
    return _proof(b, a, right_side, sides)


# --------------------------------------------------------------------------------------------- slip
def _slip(case: Case) -> dict[str, Found]:
    """Equations (14) to (19): slip and movement between two letters, at points in and out of
    contact.
    """
    formulas, factor = Formulas(case), case.compliance * case.friction / math.pi
    loads, rates, reach, front = formulas.loads, formulas.rates, formulas.reach, formulas.front
    t = {letter: case.time(letter) for letter in "EFGIJKM"}

    # In contact from I to J: C dP or C dP_Y, and dQ/dP times or at P_Y.
    x = 1.05 * case.length
    moved = formulas.moved(x, t["I"], t["J"])

    def by_14(time: Array) -> Array:
        return (
            factor * formulas.multiplier("IJ", time) * reach(x, front("IJ", time)) * rates(time)[0]
        )

    def by_18(unit: float | None) -> float:
        """Slip with dQ/dP multiplied by the load P_Y in some unit; None: not multiplied."""

        def rate(time: Array) -> Array:
            load, slope = front("IJ", time), case.friction * (formulas.multiplier("IJ", time) + 1)
            product = slope * load / unit if unit else slope
            return (
                (product / case.friction - 1)
                * factor
                * formulas.front_rate("IJ", time)
                * reach(x, load)
            )

        return formulas.rubbing("IJ", x, rate)

    right, printed, after = (
        by_18(None),
        formulas.rubbing("IJ", x, by_14),
        integral(by_14, t["K"], t["J"]) / moved,
    )
    halves = {"printed I-K": printed / moved - after, "printed K-J": after}
    products = {"printed in N/mm": by_18(1.0) / moved, "printed in P0/3": by_18(case.unit) / moved}
    nearest = min(products.values(), key=lambda ratio: abs(ratio - 1)) * moved

    # Out of contact from E to F; as printed: int_a^x dx / sqrt(x^2 - c^2).
    x1, phase = case.length, (t["E"], t["F"])

    def by_16(time: Array) -> Array:
        inside = reach(x1, front("EG", time))
        root = inside - reach(case.contact.half_width(loads(time)[0]), front("EG", time))
        return factor * (2 * formulas.front_rate("EG", time) * inside - rates(time)[0] * root)

    mended = integral(lambda time: formulas.slip_rate("EG", x1, time), *phase)
    second = _proof(mended, integral(by_16, *phase), formulas.moved(x1, *phase), {})

    # After J: P_K is a front; as a constant load it leaves what the open surface does.
    phase = t["J"], (t["J"] + t["M"]) / 2
    mended = integral(lambda time: formulas.slip_rate("JM", x1, time), *phase)
    outside = integral(lambda time: factor * rates(time)[0] * reach(x1, loads(time)[0]), *phase)
    named = {
        "front at M": float(front("JM", t["M"])) / case.unit,
        "load at K": case.events["K"].normal_load / case.unit,
    }

    # (12) is a closed integral; (15) is what becomes (23).
    x2 = 0.8 * case.length
    slipped, forward = (
        formulas.rubbing("JM", x2, lambda time: formulas.slip_rate("JM", x2, time)),
        formulas.moved(x2, t["I"], t["M"]),
    )
    net = formulas.moved(x2, t["G"], t["G"] + 2 * math.pi)
    return {
        "(14), I–J": _proof(right, printed, moved, halves, halves["printed I-K"] * after < 0),
        "(15)": _gap_for_slope(case),
        "(16), second line": second,
        "(17)": _stick_displacement(case),
        "(18)": _proof(right, nearest, moved, products),
        "P_K in (19)": _proof(mended, outside, formulas.moved(x1, *phase), named),
        "reference before (23)": _proof(
            slipped, net, forward, {"net over the slip": abs(net / forward)}
        ),
    }


def _gap_for_slope(case: Case) -> Found:
    """What h_o is: slip from J to M at 0.8 a0, and how it grows with all lengths and loads at the
    same stresses.
    """
    names, sizes = ("slope", "gap of the increment", "gap of the punch"), (case, case.ten_times())
    moved, grown = (
        Formulas(each).moved(0.8 * each.length, each.time("J"), each.time("M")) for each in sizes
    )
    slips = {name: [_by_15(each, 0.8 * each.length, name) for each in sizes] for name in names}
    errors = {name: _share(pair[0], moved) for name, pair in slips.items()}
    powers = {
        f"power with the {name}": math.log10(pair[1] / pair[0]) for name, pair in slips.items()
    }
    power, printed = math.log10(grown / moved), min(errors[name] for name in names[1:])
    numbers = {"right": errors["slope"], "printed": printed, "power of the slip": power}
    numbers |= powers | {f"error with the {name}": errors[name] for name in names[1:]}
    return (
        proves(errors["slope"], printed) and abs(powers["power with the slope"] - power) <= EXACT,
        numbers,
    )


def _by_15(case: Case, x: float, reading: str) -> float:
    """Slip of x from J to M by equation (15) with a reading of h_o, integrated over x from the
    stick edge c; Hertz.
    """
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


def _stick_displacement(hertz: Case) -> Found:
    """A point out of contact from G to H, in full stick, at two coefficients of friction."""

    def ratio(f: float) -> float:
        """A/pi int dQ arccosh(x/a) over the engine's movement."""
        case = hertz.about_no_shear(f)
        formulas, x, g, h = Formulas(case), 1.1 * case.length, case.time("G"), case.time("H")
        sheared = integral(
            lambda t: formulas.rates(t)[1] * formulas.reach(x, formulas.loads(t)[0]), g, h
        )
        return case.compliance / math.pi * sheared / formulas.moved(x, g, h)

    ratios = {f: ratio(f) for f in (1.0, 0.6)}
    errors = {
        "right": max(abs(r - 1) for r in ratios.values()),
        "printed": min(abs(2 * f * r - 1) for f, r in ratios.items()),
    }
    return proves(errors["right"], errors["printed"]), errors | {
        f"factor at f = {f}": 2 * f * r for f, r in ratios.items()
    }


# --------------------------------------------------------------------------------------------- work
def work(case: Case, x: float) -> dict[str, Found]:
    """Equations (11), (23) and (24), at the place x of the peak of W(x); Hertz."""
    formulas, density = (
        Formulas(case),
        case.solve(x=[x / case.length], fields=("dissipation_density",)).dissipation_density[0],
    )
    radius = case.scene.profile.model_dump()["radius"]

    def root(t: Array) -> Array:
        """f^2/(pi R) sqrt(a^2 - x^2) over W."""
        under = np.maximum(np.square(case.contact.half_width(formulas.loads(t)[0])) - x * x, 0.0)
        return case.friction**2 / (math.pi * radius) * np.sqrt(under) / density

    def argument(phase: str, unit: float) -> float:
        """Part of W with the multiplier C of (14) for c in the arccosh, lengths in a unit."""

        def rate(t: Array) -> Array:
            reached = np.arccosh(np.maximum(unit * x / np.abs(formulas.multiplier(phase, t)), 1.0))
            return root(t) * np.abs(formulas.driving(phase, t)) * reached

        return formulas.rubbing(phase, x, rate)

    def real_time(phase: str) -> float:
        return formulas.rubbing(phase, x, lambda t: x >= np.abs(formulas.multiplier(phase, t)))

    def mended(phase: str) -> float:
        return formulas.rubbing(
            phase,
            x,
            lambda t: (
                root(t)
                * np.abs(formulas.driving(phase, t))
                * formulas.reach(x, formulas.front(phase, t))
            ),
        )

    def with_minus(phase: str) -> float:
        """Part of W with the leading minus and C dP throughout."""

        def rate(t: Array) -> Array:
            return (
                -root(t)
                * formulas.reach(x, formulas.front(phase, t))
                * formulas.multiplier(phase, t)
                * formulas.rates(t)[0]
            )

        return formulas.rubbing(phase, x, rate)

    right, signed = (
        {f"{name} {phase}": of(phase) for phase in _PHASES}
        for name, of in (("mended", mended), ("printed", with_minus))
    )
    millimetres, metres = (sum(argument(phase, unit) for phase in _PHASES) for unit in (1.0, 1e-3))
    real = sum(map(real_time, _PHASES)) / sum(
        formulas.rubbing(phase, x, np.ones_like) for phase in _PHASES
    )
    parts = {
        "share of time with a real arccosh": real,
        "in millimetres": millimetres,
        "in metres": metres,
    }

    # Ten times all lengths and loads, the same stresses; the integral of W(x) in parts between the
    # edges at events.
    fields = ("dissipation_density", "dissipation")
    small, large = (
        each.solve(x=[1.0], fields=fields, steady=True) for each in (case, case.ten_times())
    )
    powers = [
        math.log10(large.dissipation_density[0] / small.dissipation_density[0]),
        math.log10(large.dissipation / small.dissipation),
    ]
    edges = (float(case.width(case.events[letter].normal_load)) for letter in "FGHIJ")
    marks = sorted({case.stick_edge, case.outer_edge, *edges})
    halves = (
        integral(lambda x: total(case.density(x)), begin, end) for begin, end in pairwise(marks)
    )
    whole = _share(2 * sum(halves) * case.work_unit, case.steady.dissipation)
    holds = whole <= EXACT and abs(powers[0] - 1) <= EXACT and abs(powers[1] - 2) <= EXACT
    negative = signed["printed JM"] < 0 < right["mended JM"]
    return {
        "(23), (24), arccosh": _proof(sum(right.values()), millimetres, 1.0, parts),
        "(23), (24), sign": _proof(
            sum(right.values()), sum(signed.values()), 1.0, signed | right, negative
        ),
        "(11)": (holds, {"power of W(x)": powers[0], "power of (11)": powers[1], "right": whole}),
    }
