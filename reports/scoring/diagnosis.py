"""Likely causes of the difference between a result and its reference, from the pattern of the difference.

Each fault of a closed set is a hypothesis that predicts tractions (`hypotheses` says how they are weighed against each other). The
one that leaves least unexplained is named first; it is then mended, and the rest looked at again, so that two faults at once are
both found.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from reports.comparison import Comparison
from reports.measured import noise_of
from reports.scoring.flaws import model_faults
from reports.scoring.hypotheses import (
    Discrepancy,
    Hypothesis,
    coarse_edge,
    discrepancy,
    file_faults,
    question_faults,
    unlike_bodies,
)

# A hypothesis that explains less is no pattern: a fault of the set, fitted, leaves far less behind.
LEAST_EXPLAINED = 0.5
# What explains this much is exact but for rounding and the points taken.
CLEAR = 0.999
# Faults looked for behind each other: behind two, what is left is the rounding of the first two fits.
ROUNDS = 3
# A rival this much weaker than the winner is not worth a line.
LEAST_STRENGTH = 0.05
# Behind a fault that was mended, tolerances that the rest must exceed to be looked at: a fit is not exact.
REST = 2.0
UNKNOWN, NOISE = "unknown", "noise"
# Standard deviations of the noise by which a point may exceed the Coulomb limit and the contact law still be kept.
BY_NOISE = 5.0
MODEL = {"coarse_edge", "coupling", "small_body", "soft_normal", "elastic_slip", "steps"}
# What a hypothesis must explain more than a plainer one, for each figure fitted: of two that explain all, the plainer is named.
# Flaws that move edges of contact lean on a fitted stiffness; a coarse edge and an odd part take what they find, point by point.
COST = 0.01
FITTED = {"coarse_edge": 10, "coupling": 5, "small_body": 3, "soft_normal": 2} | dict.fromkeys(
    ("traction_factor", "pressure_factor", "offset", "stiffness", "loads", "friction", "other_times", "elastic_slip"), 1
)
FAULTS = {
    "shear_sign": "The shear has the wrong sign: give it as it acts on the lower body along +x, or turn it in the mapping.",
    "pressure_sign": "The pressure has the wrong sign: it is positive in compression here.",
    "swapped": "Pressure and shear are swapped: exchange the two columns.",
    "frictionless": "There is no shear: the contact has no friction, or the tangential load was not applied.",
    "units": "The tractions are {factor:g} times what they should be, on the right widths: a factor of units.",
    "traction_factor": "The tractions are {factor:.4g} times what they should be, on the right widths: a thickness, a unit or a "
    "share of the surface counted twice; no elastic contact carries other loads on the same width.",
    "pressure_factor": "The pressure alone is {factor:.4g} times what it should be, on the right widths with the right shear: a "
    "unit or an area of that one column; another load or modulus would change widths and shear with it.",
    "offset": "The contact is {distance:.3g} a_ref off along x: the origin of x is not the centre of the profile.",
    "stiffness": "The bodies are {factor:.3g} times as stiff for their curvature as the scene's: check E, nu, plane strain against"
    " plane stress, and the radius ({likely}).",
    "loads": "Loads {factor:.3g} times those of the scene: check thickness, amplitudes and what a load was shared out over.",
    "half_model": "Loads {factor:.3g} times those of the scene: half of a symmetric model carries half of the loads, and the other "
    "half was forgotten or counted twice.",
    "friction": "The coefficient of friction is {factor:.3g} times the scene's.",
    "full_stick": "Friction is not active: the faces are bonded, or rough; nothing slips, and shear exceeds f p at the edges.",
    "memoryless": "The history is dropped: each instant is that of a first loading, without the slip locked in before; keep the "
    "state of friction from step to step.",
    "not_steady": "The cycle is not steady yet: this is the first revolution, and it was compared with the steady one; run more of "
    "them and compare the last, or, if the first is meant, state its times on the scene's path (times of a mapping).",
    "steps": "The steps are too long: {steps:.0f} a cycle cut the corners of the load path; take more, and let some end on the"
    " turning points.",
    "other_times": "The tractions are those of other instants, {delay:.3g} of a period late: check the times or the phases of the "
    "loads.",
    "elastic_slip": "Elastic slip of a soft tangential penalty: faces that should stick creep by q/k, "
    "k = {stiffness:.3g} E*/a_ref; "
    "make the tangential stiffness larger (the slip tolerance smaller), or use Lagrange multipliers.",
    "soft_normal": "A soft normal penalty: the faces sink into each other by p/k, k = {stiffness:.3g} E*/a_ref, so the contact is "
    "too wide and its peak too low; make the normal stiffness larger, or use Lagrange multipliers.",
    "small_body": "The bodies are too small, or held too near: their far field bends the faces like curvatures of {normal:.2g} P/E*"
    " and shears them by {shear:.2g} Q/E* over a_ref^2; make them larger, or compare with finite bodies.",
    "coupling": "The difference is odd in x: pressure moves the faces along x. The bodies are not alike, in material (then not the "
    "scene's) or in shape (a narrow pad on a wide block), or one of them tilts; half-plane theory of like bodies has none of it.",
    "bulk_sign": "The bulk stress has the other sign: tension along x is positive, and what counts is ε = σ/E′ of the lower body − "
    "that of the upper one.",
    "bulk_left_out": "The bulk stress was left out: pull the body as the scene says, in step with the loads.",
    "tilt_sign": "The upper body is turned the other way: a tilt opens the gap at x > 0, and M = ∫x p dx.",
    "tilt_left_out": "The tilt was left out: the faces approach each other without a turn, or the load acts along x = 0.",
    "coarse_edge": "The mesh is too coarse at the edges of contact and stick: the discrepancy stays within two elements of them; "
    "make the elements there smaller than {spacing:.2g} a_ref.",
}

_SCATTER = (
    "The tractions scatter from point to point, with a standard deviation of {size}: noise of a measurement, of extrapolated nodal "
    "values or of printed digits; average neighbouring points, or write more digits."
)
_NO_COUPLING = 1e-9
_OWN_COUPLING = (
    "The difference is odd in x, as the scene's own materials make it, which have {own:.2g} of Dundurs' beta: half-plane theory "
    "leaves that out. As far as it goes it is the idealisation and no fault of the result; --against fe has it in."
)
# Quotients of E*/R that have a likely cause: (factor, within, cause).
LIKELY = (
    (0.5, 0.03, "one half: two deformable bodies where one is rigid, or a diameter given for a radius"),
    (2.0, 0.03, "two: one of the bodies rigid, or a radius halved"),
)


@dataclass(frozen=True)
class Diagnosis:
    """One fault that a result may suffer from."""

    fault: str  # its key, of `FAULTS`, or "unknown"
    sentence: str  # the likely cause, and what to do
    evidence: tuple[str, ...]  # measured figures, in words
    strength: float  # 0 to 1: share of the squared discrepancy that it explains, less where a rival explains it better


def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """Likely causes of the discrepancy of `comparison`, the strongest first.

    Empty where its tractions and its dissipation are within the scene's tolerances, or where it has no number to judge; a
    single "noise" or "unknown" where they are not, and no fault of the set explains half of it.
    """
    whole = discrepancy(comparison)
    if whole is None:
        return ()
    if whole.within():
        return tuple(_by_work(comparison))
    found: list[Diagnosis] = []
    untried: set[str] = set()
    rest = whole
    for number in range(ROUNDS):
        taken = {one.fault for one in found}
        ranked = _ranked(rest, taken, untried)
        best, winner = ranked[0]
        if best < LEAST_EXPLAINED:
            break
        for explained, one in ranked if number == 0 else ranked[:1]:  # rivals are weaker by what the two leave unexplained
            rival = 1.0 if one is winner else min((1 - best) / max(1 - explained, 1e-12), 1.0)
            strength = max(explained, 0.0) * rival * 0.9**number
            if explained >= LEAST_EXPLAINED and strength >= LEAST_STRENGTH and one.fault not in taken:
                found.append(Diagnosis(one.fault, sentence_of(one, rest), tuple(_evidence(rest, one, explained, number)), strength))
        rest = winner.mended(rest)
        if rest.within(REST):
            break
    pressure, shear = whole.errors()
    size = f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times that, at the worst instant"
    unknown = "The discrepancy fits no known pattern: look at where and when it is largest."
    known = sorted(found, key=lambda one: -one.strength) or list(scatter(whole))
    first, *others = known or [Diagnosis(UNKNOWN, unknown, (size,), 0.0)]
    if whole.unsymmetric:
        words = "with bulk stress, tilt or unequal sides not looked for: no memory, unlike bodies, soft penalties, bodies too small"
        first = replace(first, evidence=(*first.evidence, words))
    if untried:
        names = ", ".join(sorted(untried)).replace("_", " ")
        words = f"not all was tried: a model with this fault does not settle ({names})"
        first = replace(first, evidence=(*first.evidence, words))
    return (first, *others)


def scatter(what: Discrepancy) -> Iterator[Diagnosis]:
    """Tractions that scatter from point to point, where that is most of the discrepancy; how many exceed the Coulomb limit."""
    scales, inside = what.comparison.scales, (what.expected[0] > 1e-3 * what.comparison.scales.pressure) & (what.weight > 0)
    pairs = [(what.found[0] - what.expected[0], scales.pressure), (what.found[1] - what.expected[1], scales.shear)]
    pairs = pairs[: 1 + (what.sheared and scales.friction > 0)]
    sigma = [noise_of((off / scale)[inside]) for off, scale in pairs]
    whole = sum(float(np.mean((off / scale)[inside] ** 2)) for off, scale in pairs)
    share = sum(one**2 for one in sigma) / whole if whole else 0.0
    if share < LEAST_EXPLAINED:
        return
    evidence = [f"noise from point to point makes {min(share, 1.0):.0%} of the square of the discrepancy"]
    if len(pairs) > 1:
        every, touching = what.comparison.found, what.comparison.expected.pressure > 1e-3 * scales.pressure  # at all instants
        beyond = (np.abs(every.shear) / scales.shear - every.pressure / scales.pressure)[touching]
        count, most, limit = int(np.sum(beyond > 0)), float(np.max(beyond)), BY_NOISE * sum(one**2 for one in sigma) ** 0.5
        kept = "no more than noise makes: no fault of the contact law" if most <= limit else "more than noise alone makes"
        evidence.insert(
            0, f"{count} of {len(beyond)} points in contact exceed the Coulomb limit, by {most:.2g} of f p_ref at most: {kept}"
        )
    words = f"{sigma[0]:.2g} in p/p_ref" + (f" and {sigma[1]:.2g} in q/(f p_ref)" if len(sigma) > 1 else "")
    yield Diagnosis(NOISE, _SCATTER.format(size=words), tuple(evidence), min(share, 1.0))


def _ranked(what: Discrepancy, taken: set[str], untried: set[str]) -> list[tuple[float, Hypothesis]]:
    """The best hypothesis of every fault with the share it explains, the best first.

    Faults of the model are looked for only where nothing plainer explains it all, for no fit of them is as good. Behind one of them
    an odd rest is what its fit left.
    """
    tried = [*file_faults(what), *question_faults(what), coarse_edge(what)]
    if not taken & MODEL:
        tried += unlike_bodies(what)
    if max(what.explained(one.predicted) for one in tried) < CLEAR and not what.unsymmetric:
        stiffness = next((one for one in tried if one.fault == "stiffness"), None)
        tried += model_faults(what, stiffness, untried)
    best: dict[str, tuple[float, Hypothesis]] = {}
    for one in tried:
        explained = what.explained(one.predicted) - COST * FITTED.get(one.fault, 0)
        if one.fault not in best or explained > best[one.fault][0]:
            best[one.fault] = explained, one
    return sorted(best.values(), key=lambda pair: -pair[0])


def sentence_of(one: Hypothesis, what: Discrepancy) -> str:
    """The likely cause, and what to do."""
    from halfplane_fe.dundurs import dundurs

    material, figures = what.comparison.scene.material, dict(one.figures)
    if one.fault == "coupling" and abs(own := dundurs(material).beta) > _NO_COUPLING:
        return _OWN_COUPLING.format(own=own, **figures)
    likely = ""
    if one.fault == "stiffness":
        factor, nu = figures["factor"], material.upper.poisson_ratio
        causes = [cause for value, within, cause in LIKELY if abs(factor / value - 1) < within]
        if material.alike and abs(factor / (1 - nu**2) - 1) < 0.2 * nu**2:
            causes = [f"it is near 1 - nu^2 = {1 - nu**2:.3g}: plane stress"]
        likely = (*causes, "contact widths go as the square root of its inverse for a Hertz contact")[0]
    return FAULTS[one.fault].format(likely=likely, **figures)


def _evidence(what: Discrepancy, one: Hypothesis, explained: float, number: int) -> Iterator[str]:
    """The measured figures that speak for a fault."""
    behind = "what the faults above leave of the discrepancy" if number else "the discrepancy"
    yield f"a result with just this fault explains {explained:.1%} of the square of {behind} in p/p_ref and q/(f p_ref)"
    (before, after), (p_before, q_before) = one.mended(what).errors(), what.errors()
    yield f"error of the pressure {p_before:.2g} of its norm, of the shear {q_before:.2g} of f times that, at the worst instant"
    yield f"with the fault taken out, by {before:.2g} and {after:.2g}"
    if one.fault in ("full_stick", "frictionless", "friction", "elastic_slip", "swapped"):
        scales = what.comparison.scales
        (p, q), (p_found, q_found) = what.expected, what.found
        inside = (p > 1e-3 * scales.pressure) & (np.abs(q) > 0.999 * scales.friction * p) & (p_found > 0)
        ratio = np.median(np.abs(q_found[inside]) / (scales.friction * p_found[inside])) if inside.any() else np.nan
        yield f"median of |q|/(f p) found where the reference slips: {ratio:.3g}; there it should be 1"
    if what.missing:
        yield f"{what.missing:.1%} of the tractions are no numbers and were left out"


def _by_work(comparison: Comparison) -> Iterator[Diagnosis]:
    """Steps too long where the tractions show nothing: the dissipation is off, and that of the polygon of the instants is not.

    Exact steps cut corners of the path alone, and tractions at their ends are right as soon as the corner is left behind.
    """
    values = {one.key: one.value for one in comparison.metrics}
    off, less = values.get("dissipation"), values.get("dissipation_polygon")
    limit = comparison.scene.tolerances.limit("dissipation") or 0.0
    if off is None or less is None or not abs(off) > limit or not abs(less) < abs(off) / 2:
        return
    steps = len(comparison.found.time) - 1
    evidence = (
        f"error of the dissipation {off:.2g}; against that of the straight lines between the {steps} steps {less:.2g}",
        "the tractions are within their tolerances",
    )
    yield Diagnosis("steps", FAULTS["steps"].format(steps=steps), evidence, 1 - abs(less / off))
