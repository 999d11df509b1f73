"""What each fault is called, what to do about it, and the figures that speak for it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reports.scoring.diagnosis_discrepancy import Discrepancy
from reports.scoring.diagnosis_hypothesis import Hypothesis

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
    "coupling": "Pressure moves the faces along x as {beta:.2g} of Dundurs' beta would: the bodies are not alike, in material "
    "(then not the scene's) or in shape (a narrow pad on a wide block); half-plane theory of like bodies has none of it.",
    "coarse_edge": "The mesh is too coarse at the edges of contact and stick: the discrepancy stays within two elements of them; "
    "make the elements there smaller than {spacing:.2g} a_ref.",
}

_NO_COUPLING = 1e-9
_OWN_COUPLING = (
    "Pressure moves the faces along x as {beta:.2g} of Dundurs' beta would, and the scene's own materials have {own:.2g}, which "
    "half-plane theory leaves out: as far as these agree it is the idealisation and no fault of the result; --against fe has it in."
)
# Quotients of E*/R that have a likely cause: (factor, within, cause).
LIKELY = (
    (0.5, 0.03, "one half: two deformable bodies where one is rigid, or a diameter given for a radius"),
    (2.0, 0.03, "two: one of the bodies rigid, or a radius halved"),
)


def sentence_of(one: Hypothesis, poisson_ratio: float | None = None, own_beta: float = 0.0) -> str:
    """What the result most likely suffers from, and what to do; `own_beta` is Dundurs' beta of the scene's materials."""
    figures = dict(one.figures)
    if one.fault == "coupling" and abs(own_beta) > _NO_COUPLING:
        return _OWN_COUPLING.format(own=own_beta, **figures)
    if one.fault == "stiffness":
        return FAULTS[one.fault].format(likely=_likely(figures["factor"], poisson_ratio), **figures)
    return FAULTS[one.fault].format(**figures)


def _likely(factor: float, poisson_ratio: float | None) -> str:
    if poisson_ratio is not None and abs(factor / (1 - poisson_ratio**2) - 1) < 0.2 * poisson_ratio**2:
        return f"it is near 1 - nu^2 = {1 - poisson_ratio**2:.3g}: plane stress"
    causes = [cause for value, within, cause in LIKELY if abs(factor / value - 1) < within]
    return causes[0] if causes else "contact widths go as the square root of its inverse for a Hertz contact"


def evidence_of(what: Discrepancy, one: Hypothesis, explained: float, number: int) -> Iterator[str]:
    """The measured figures that speak for a fault."""
    behind = "what the faults above leave of the discrepancy" if number else "the discrepancy"
    yield f"a result with just this fault explains {explained:.1%} of the square of {behind} in p/p_ref and q/(f p_ref)"
    (before, after), (p_before, q_before) = (_sizes(what, one), what.errors())
    yield f"pressure is off by {p_before:.2g} of its norm, shear by {q_before:.2g} of f times that at the worst instant"
    yield f"with the fault taken out, by {before:.2g} and {after:.2g}"
    if one.fault in ("full_stick", "frictionless", "friction", "elastic_slip", "swapped"):
        yield f"median of |q|/(f p) found where the reference slips: {_ratio(what):.3g}; there it should be 1"
    if what.missing:
        yield f"{what.missing:.1%} of the tractions are no numbers and were left out"


def _sizes(what: Discrepancy, one: Hypothesis) -> tuple[float, float]:
    return one.mended(what).errors()


def _ratio(what: Discrepancy) -> float:
    """Median of |q|/(f p) found, at the points where the reference is at the limit of friction."""
    f = what.comparison.scales.friction
    p, q = what.expected
    inside = (p > 1e-3 * what.comparison.scales.pressure) & (np.abs(q) > 0.999 * f * p) & (what.found[0] > 0)
    return float(np.median(np.abs(what.found[1][inside]) / (f * what.found[0][inside]))) if inside.any() else float("nan")
