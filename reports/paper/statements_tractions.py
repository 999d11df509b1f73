"""What the paper states about shear tractions in its first cycle, equations (5) to (7), and what the transient leaves behind.

Tractions are compared at points from the centre to near the largest contact; x and half-widths are over a0 = a(P0).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reports.paper.cases import Case, Paper
from reports.paper.formulas import Formulas
from reports.paper.tables import EXACT, Statement, judge, small

Array = NDArray[np.float64]

_PLACES = (0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.9, 1.0, 1.1)
_ROUNDING = 1e-10


def traction_statements(paper: Paper) -> list[Statement]:
    """Every statement about tractions of the first cycle, in the order of the paper."""
    hertz = paper.hertz
    return [growing_load(hertz), forward_slip(hertz), at_once(hertz), reverse_slip(hertz), residual_tractions(hertz)]


def _error(case: Case, time: float, found: Array) -> float:
    """Largest difference from the engine's shear traction at an instant over its largest value."""
    shear = case.solve(time=[time], x=_PLACES, fields=("shear",)).shear[0]
    return float(np.max(np.abs(found - shear)) / np.max(np.abs(shear)))


def _halfway(case: Case, first: str, last: str) -> float:
    return (case.time(first) + case.time(last)) / 2


def growing_load(case: Case) -> Statement:
    """Equation (5) along O-A-B in full stick, and beyond B, where P still grows but the edges slip."""
    formulas, x = Formulas(case), np.array(_PLACES) * case.length
    stick = max(_error(case, case.time(letter), formulas.stuck(x, case.events[letter].normal_load)) for letter in "AB")
    later = _halfway(case, "B", "C")
    slip = _error(case, later, formulas.stuck(x, float(formulas.loads(later)[0])))
    return Statement(
        "(5)",
        "section 2, equation (5)",
        "while P grows, a stretch of the path adds ∫ p′(x, P) (dQ/dP) dP to the shear traction",
        f"at A and B equation (5) differs from the engine's q by {small(stick)} of its largest value; halfway from B to C, where P "
        f"still grows but the edges slip, by {slip:.0%}: it needs |dQ/dP| ≤ f as well",
        judge(max(stick, slip) <= EXACT, nearly=stick <= EXACT),
        {"error in full stick": stick, "error in slip": slip},
    )


def forward_slip(case: Case) -> Statement:
    """Equation (6) from B to E."""
    formulas, x = Formulas(case), np.array(_PLACES) * case.length
    errors = {}
    for name, time in {"B-C": _halfway(case, "B", "C"), **{letter: case.time(letter) for letter in "CDE"}}.items():
        load, met = float(formulas.loads(time)[0]), formulas.initial_meeting(time)
        new = case.contact.pressure(x, load) - case.contact.pressure(x, met)
        errors[f"error at {name}"] = _error(case, time, formulas.stuck(x, met) + case.friction * new)
    worst = max(errors.values())
    return Statement(
        "(6)",
        "section 2, equation (6), figure 3C–E",
        "in forward slip of the first cycle q = ∫₀^{P_Y} p′ (dQ/dP) dP + f (p(x, P) − p(x, P_Y)), Y where the line of gradient f "
        "meets the path of full stick",
        f"halfway from B to C, at C, D and E it differs from the engine's q by at most {small(worst)} of its largest value",
        judge(worst <= EXACT),
        errors,
    )


def at_once(case: Case, before: float = 1e-6) -> Statement:
    """Slip slows down to rest at E everywhere; reverse slip then starts from the edges."""
    end, start = case.time("E"), case.time("B")
    found = case.solve(time=[end - before, end + before])
    ratio = found.stick_half_width / found.contact_half_width
    x = [0.8, 0.85]
    slip = case.solve(time=[start, end - before, end], x=x, fields=("slip",)).slip
    slowest = float(np.max((slip[2] - slip[1]) / before / ((slip[2] - slip[0]) / (end - start))))
    return Statement(
        "full stick at E",
        "section 2",
        "at E the whole contact sticks for an instant, then reverse slip starts",
        f"{before:.0e} rad before E the stick zone is {ratio[0]:.3f} of the contact; as long after E all but a share of "
        f"{small(1 - ratio[1])} sticks. In between x = {x[0]} and {x[1]} slip at {small(slowest)} of their mean speed since B",
        judge(ratio[0] < 1 - EXACT and 1 - ratio[1] <= EXACT and slowest <= 1e-5),
        {"stick before": float(ratio[0]), "slip after": float(1 - ratio[1]), "speed before": slowest},
    )


def reverse_slip(case: Case) -> Statement:
    """Equations (7) and (8) from E to G."""
    formulas, x = Formulas(case), np.array(_PLACES) * case.length
    met = formulas.initial_meeting(case.time("E"))
    errors = {}
    for name, time in {"E-F": _halfway(case, "E", "F"), "F": case.time("F"), "G": case.time("G")}.items():
        loads = (float(formulas.loads(time)[0]), float(formulas.front("EG", time)), met)
        now, turned, first = (case.contact.pressure(x, load) for load in loads)
        errors[f"error at {name}"] = _error(case, time, formulas.stuck(x, met) + case.friction * (2 * turned - now - first))
    worst = max(errors.values())
    return Statement(
        "(7)",
        "section 2, equations (7) and (8), figure 3F, G",
        "in the reverse slip that follows q = ∫₀^{P_Z} p′ (dQ/dP) dP + f (2 p(x, P_S) − p(x, P) − p(x, P_Z)), Z belonging to E",
        f"halfway from E to F, at F and at G it differs from the engine's q by at most {small(worst)} of its largest value",
        judge(worst <= EXACT),
        errors,
    )


def residual_tractions(case: Case) -> Statement:
    """What the slip of the transient leaves: the locked-in slip, and the tractions that the initial loading alone has not."""
    formulas = Formulas(case)
    inner, outer = formulas.initial_meeting(case.time("E")), float(formulas.front("EG", case.time("G")))
    bounds = case.width([inner, outer])
    ring = bounds[0] + (bounds[1] - bounds[0]) * np.linspace(0.01, 0.99, 50)
    core = bounds[0] * np.linspace(0.01, 0.99, 50)
    times = [case.time(letter) for letter in "BGM"]
    slip = case.solve(time=times, x=np.concatenate([core, ring]), fields=("slip",)).slip / (case.compliance * case.unit)
    locked, later = np.abs(slip[1] - slip[0]), float(np.max(np.abs(slip[2] - slip[1])))
    within, between = float(np.max(locked[:50])), float(np.min(locked[50:]))

    # At G: the engine's q without the hooks of reverse slip, and without what loading in stick to P_T would have left.
    widest = float(case.width(case.events["G"].normal_load))
    x = np.array([0.0, bounds[0], 0.7 * bounds[1] + 0.3 * widest, 0.1 * bounds[1] + 0.9 * widest])
    shear = case.solve(time=[case.time("G")], x=x, fields=("shear",)).shear[0]
    place = x * case.length
    hooks = case.contact.pressure(place, case.events["G"].normal_load) - case.contact.pressure(place, outer)
    new = (shear + case.friction * hooks - formulas.stuck(place, outer)) * case.length / case.unit
    share, beyond = float(new[0] / new[1]), float(np.max(np.abs(new[2:])))
    holds = max(within, later, beyond) <= _ROUNDING < between
    return Statement(
        "residual tractions",
        "section 2",
        "the transient leaves new residual tractions between a(P_Z) and a(P_T)",
        f"the slip that the transient locks in lies there: {small(within)} A P0/3 up to a(P_Z) = {bounds[0]:.4f} a0, at least "
        f"{between:.1e} from there to a(P_T) = {bounds[1]:.4f} a0, changed by {small(later)} in later cycles. The tractions that "
        f"go with it reach further in: at the centre {share:.2f} of those at a(P_Z), beyond a(P_T) {small(beyond)} P0/(3 a0)",
        judge(holds and abs(share) <= _ROUNDING, nearly=holds),
        {
            "a(P_Z)/a0": float(bounds[0]),
            "a(P_T)/a0": float(bounds[1]),
            "slip within a(P_Z)": within,
            "slip beyond a(P_Z)": between,
            "change in later cycles": later,
            "traction at the centre over that at a(P_Z)": share,
            "traction beyond a(P_T)": beyond,
        },
    )
