"""What a wrong result most likely suffers from, from the pattern of its discrepancy.

Each fault of a closed set is a hypothesis that predicts tractions (`diagnosis_discrepancy` says how they are weighed against each
other). The one that leaves least unexplained is named first; it is then mended, and the rest looked at again, so that two faults
at once are both found.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from reports.comparison import Comparison
from reports.scoring.diagnosis_arrays import array_faults
from reports.scoring.diagnosis_discrepancy import Discrepancy, discrepancy
from reports.scoring.diagnosis_edges import coarse_edge
from reports.scoring.diagnosis_flaws import flaw_faults
from reports.scoring.diagnosis_hypothesis import Hypothesis
from reports.scoring.diagnosis_theory import theory_faults
from reports.scoring.diagnosis_words import FAULTS, evidence_of, sentence_of

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
UNKNOWN = "unknown"
# What a hypothesis must explain more than a plainer one, for each figure fitted: of two that explain all, the plainer is named. The
# flaws that move edges of contact lean on a fitted stiffness or offset besides; a coarse edge takes what it finds, point by point.
COST = 0.01
FITTED = {"coarse_edge": 10, "small_body": 3, "soft_normal": 2, "coupling": 2} | dict.fromkeys(
    ("traction_factor", "pressure_factor", "offset", "stiffness", "loads", "friction", "other_times", "elastic_slip"), 1
)


@dataclass(frozen=True)
class Diagnosis:
    """One fault that a result may suffer from.

    Attributes
    ----------
    fault : its key, of `diagnosis_words.FAULTS`, or "unknown"
    sentence : what the result most likely suffers from, and what to do
    evidence : measured figures, in words
    strength : 0 to 1: share of the squared discrepancy that the fault explains, less where a rival explains it better
    """

    fault: str
    sentence: str
    evidence: tuple[str, ...]
    strength: float


def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """What the result of `comparison` suffers from, the strongest first.

    Empty where its tractions and its dissipation are within the scene's tolerances, or where it has no number to judge; a
    single "unknown" where they are not, and no fault of the set explains half of it.
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
        ranked = _ranked(rest, untried)
        if not ranked or ranked[0][0] < LEAST_EXPLAINED:
            break
        taken = {one.fault for one in found}
        found += [one for one in _named(rest, ranked, number) if one.fault not in taken]
        rest = ranked[0][1].mended(rest)
        if rest.within(REST):
            break
    first, *others = sorted(found, key=lambda one: -one.strength) or [_unknown(whole)]
    return (_with_untried(first, untried), *others)


def _with_untried(one: Diagnosis, untried: set[str]) -> Diagnosis:
    if not untried:
        return one
    names = ", ".join(sorted(untried)).replace("_", " ")
    return replace(one, evidence=(*one.evidence, f"not all was tried: a model with this fault does not settle ({names})"))


def _ranked(what: Discrepancy, untried: set[str]) -> list[tuple[float, Hypothesis]]:
    """The best hypothesis of every fault with the share it explains, the best first."""
    best: dict[str, tuple[float, Hypothesis]] = {}
    for one in _hypotheses(what, untried):
        explained = what.explained(one.predicted) - COST * FITTED.get(one.fault, 0)
        if one.fault not in best or explained > best[one.fault][0]:
            best[one.fault] = explained, one
    return sorted(best.values(), key=lambda pair: -pair[0])


def _hypotheses(what: Discrepancy, untried: set[str]) -> Iterator[Hypothesis]:
    """Every hypothesis; flaws of the model only where nothing plainer explains it all, for no fit of them is as good."""
    theory = list(theory_faults(what))
    plain = [*array_faults(what), *theory, *coarse_edge(what)]
    yield from plain
    if max(what.explained(one.predicted) for one in plain) < CLEAR:
        by_fault = {one.fault: one for one in theory}
        yield from flaw_faults(what, by_fault.get("stiffness"), by_fault.get("offset"), untried)


def _named(what: Discrepancy, ranked: list[tuple[float, Hypothesis]], number: int) -> Iterator[Diagnosis]:
    """The winner of a round and, in the first, its rivals: weaker by the quotient of what the two leave unexplained."""
    best = ranked[0][0]
    for explained, one in ranked if number == 0 else ranked[:1]:
        rival = 1.0 if one is ranked[0][1] else (1 - best) / max(1 - explained, 1e-12)
        strength = max(explained, 0.0) * min(rival, 1.0) * 0.9**number
        if explained >= LEAST_EXPLAINED and strength >= LEAST_STRENGTH:
            sentence, evidence = (
                sentence_of(one, _poisson_ratio(what), _own_beta(what)),
                tuple(evidence_of(what, one, explained, number)),
            )
            yield Diagnosis(one.fault, sentence, evidence, strength)


def _by_work(comparison: Comparison) -> Iterator[Diagnosis]:
    """Steps too long where the tractions show nothing: the dissipation is off, and that of the polygon of the instants is not.

    Exact steps cut corners of the path alone, and tractions at their ends are right as soon as the corner is left behind.
    """
    values = {one.key: one.value for one in comparison.metrics}
    off, less = values.get("dissipation"), values.get("dissipation_polygon")
    if (
        off is None
        or less is None
        or not abs(off) > (comparison.scene.tolerances.limit("dissipation") or 0.0)
        or not abs(less) < abs(off) / 2
    ):
        return
    steps = len(comparison.found.time) - 1
    evidence = (
        f"dissipation is off by {off:.2g}, against that of the straight lines between the {steps} steps by {less:.2g}",
        "the tractions are within their tolerances",
    )
    yield Diagnosis("steps", FAULTS["steps"].format(steps=steps), evidence, 1 - abs(less / off))


def _own_beta(what: Discrepancy) -> float:
    """Dundurs' beta of the scene's own materials."""
    from halfplane_fe.dundurs import dundurs

    return dundurs(what.comparison.scene.material).beta


def _poisson_ratio(what: Discrepancy) -> float | None:
    """nu where both bodies have the same."""
    material = what.comparison.scene.material
    return material.upper.poisson_ratio if material.alike else None


def _unknown(what: Discrepancy) -> Diagnosis:
    pressure, shear = what.errors()
    return Diagnosis(
        UNKNOWN,
        "The discrepancy fits no known pattern: look at where and when it is largest.",
        (f"pressure is off by {pressure:.2g} of its norm and shear by {shear:.2g} of f times that at the worst instant",),
        0.0,
    )
