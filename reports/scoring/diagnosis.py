"""Why a result differs from its reference: causes that are shown, or the statement that none was
found, with what is excluded.

# notation: p pressure, q shear
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from reports.comparison import Comparison
from reports.scoring.causes import SHEAR_SIGN, SOFT_NORMAL, Cause
from reports.scoring.causes_in_words import key_of_sentence, sentence_of, size_of
from reports.scoring.discrepancy import PRESSURE, TRACTIONS, Discrepancy, discrepancy_of
from reports.scoring.fits import (
    CHANCE,
    MOST_LEFT,
    ROUND_OFF,
    Fit,
    Search,
    by_chance,
    explains,
    share_left,
)
from reports.scoring.judgement import Judgement, Verdict
from reports.scoring.other_problems import other_problems
from reports.scoring.traces import (
    FAULTS,
    OWN_BODIES,
    UNKNOWN,
    WORDS,
    Diagnosis,
    alternating_nodes,
    coarse_edge,
    elastic_slip,
    full_slip,
    long_steps_by_work,
    near_edges,
    outliers,
    scatter,
)
from reports.scoring.variants import Predictions

_UNITS = ("p_ref", "f p_ref")


def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """Findings on why an external result differs from the reference, likely causes first; none for
    a result within tolerance.

    Looked for in turn: single outliers; traces such as creep in stick; known faults that explain
    the tractions; other problems, such as adhesion; bodies, mesh and scatter.
    """
    discrepancy = discrepancy_of(comparison)
    if discrepancy is None:
        return ()
    outlying_values = outliers(comparison)
    traces = [
        *full_slip(discrepancy),
        *elastic_slip(discrepancy),
        *alternating_nodes(discrepancy),
    ]
    if discrepancy.within:
        named_causes = (*outlying_values, *traces) or tuple(long_steps_by_work(comparison))
        if named_causes or comparison.verdict == "within":
            return named_causes or tuple(_of_cone(discrepancy))
    judgement = Judgement(discrepancy, Search(discrepancy, Predictions(discrepancy)))
    verdict = judgement.verdict()
    causes = list(_findings_of_causes(judgement, verdict, is_traced=bool(traces)))
    turned_causes = [cause for cause in causes if cause.fault == SHEAR_SIGN.key]
    # shear of the wrong sign hides creep in stick: look again with the right one
    if turned_causes and not traces:
        traces_of_turned = list(elastic_slip(discrepancy, shear_sign=-1.0))
        if traces_of_turned:
            causes_of_pressure = _findings_of_causes(judgement, verdict, is_traced=True)
            causes = [*causes_of_pressure, *turned_causes, *traces_of_turned]
    if not traces and not (verdict.fit is not None and judgement.is_whole(verdict.fit)):
        causes = list(other_problems(discrepancy, verdict.fit)) or causes
    if not causes and not traces:
        causes = [*_own_bodies(judgement), *_mesh_at_edges(judgement), *scatter(discrepancy)][:1]
    if not causes and not traces and not outlying_values and not discrepancy.within:
        causes = [_not_found(judgement, verdict)]
    return (*outlying_values, *traces, *causes)


def _of_cone(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """A factor of the shear, of a result within every tolerance whose shear exceeds f p."""
    checks = discrepancy.comparison.result_certificates
    if not discrepancy.sheared or all(check.holds for check in checks if check.name == "cone"):
        return
    judgement = Judgement(discrepancy, Search(discrepancy, Predictions(discrepancy)))
    fit = judgement.of_cone()
    if fit is not None:
        yield from _findings_of_causes(judgement, Verdict(fit), is_traced=False)


def _findings_of_causes(
    judgement: Judgement, verdict: Verdict, *, is_traced: bool
) -> Iterator[Diagnosis]:
    """The findings (sentence, evidence, strength) on the known faults that explain the difference
    of a result best. Where the file does not tell several explanations apart, only faults that all
    of them share are named.

    Parameters
    ----------
    judgement
        the difference and the fits of faults to it
    verdict
        the faults that explain it best, and their rivals
    is_traced
        whether a trace in the shear was found, such as creep in stick; faults of the shear alone
        are then left out
    """
    fit = verdict.fit
    if fit is None:
        return
    shared_keys = fit.keys.intersection(*(rival.keys for rival in verdict.rivals))
    for index, cause in enumerate(fit.causes):
        if cause.key not in shared_keys:
            continue
        fit_before = _without_cause(judgement, fit, cause)
        # What has a trace of its own in the shear needs no second explanation of it.
        if is_traced and not explains(fit, fit_before, (PRESSURE,)):
            continue
        # a layer's effect on the shear is not predicted
        channels = (PRESSURE,) if cause is SOFT_NORMAL else judgement.channels
        share_left_by_cause = share_left(fit, fit_before, channels)
        share_left_by_all = share_left(fit, judgement.no_cause, channels)
        evidence = list(_evidence(judgement, fit, share_left_by_all))
        if verdict.is_shear_left:
            evidence.append("it explains the pressure; the shear differs for a reason not found")
        yield Diagnosis(
            key_of_sentence(cause, fit.sizes[index]),
            sentence_of(judgement.discrepancy, cause, fit.sizes[index], fit),
            tuple(evidence),
            strength=1 - min(share_left_by_cause, 1.0),
            size=size_of(cause, fit.sizes[index]),
        )


def _without_cause(judgement: Judgement, fit: Fit, cause: Cause) -> Fit:
    """The fit of the other causes alone."""
    other_causes = tuple(next_cause for next_cause in fit.causes if next_cause is not cause)
    return judgement.search.fit(other_causes, judgement.channels) or judgement.no_cause


def _evidence(judgement: Judgement, fit: Fit, share_left: float) -> Iterator[str]:
    """Sentences with measured values that speak for a cause: sum of the pressures, noise, what the
    fit leaves, errors before and after. `fit` is the fit of that cause to the difference in
    `judgement`, `share_left` the share of the difference that it leaves.
    """
    discrepancy = judgement.discrepancy
    ratio = discrepancy.resultant_ratio
    if np.isfinite(ratio):
        yield f"the sum of the pressures is {ratio:.4g} P"
    noise = fit.noise(judgement.channels) ** 0.5
    yield (
        f"{fit.count((PRESSURE,))} values in contact; noise from point to point {noise:.2g} of the"
        " scales"
    )
    part_in_words = " of the pressure" if SOFT_NORMAL in fit.causes else ""
    subject_in_words = "a result with just this fault leaves"
    faults_in_words = "the fault"
    if len(fit.causes) > 1:
        subject_in_words = "both causes together leave"
        faults_in_words = "both"
    yield f"{subject_in_words} {max(share_left, 0.0):.1%} of the difference{part_in_words}"
    pressure, shear = discrepancy.errors()
    errors_after = replace(discrepancy, reference_tractions=fit.predicted).errors()
    yield (
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        f" that, at the worst instant; with {faults_in_words} taken out, "
        f"{errors_after[0]:.2g} and {errors_after[1]:.2g}"
    )
    if discrepancy.missing:
        yield f"{discrepancy.missing:.1%} of the tractions are no numbers and were left out"
    if discrepancy.unsymmetric:
        yield (
            "with bulk stress, tilt or unequal sides not looked for: no memory, unlike bodies, soft"
            " penalties, bodies too small"
        )


def _own_bodies(judgement: Judgement) -> Iterator[Diagnosis]:
    """The finding that the difference is the idealisation itself: half-plane theory corrected by
    what the scene's own bodies add leaves less than a third of the difference that half-plane
    theory leaves. Nothing otherwise. `judgement` holds the difference and the fits of known faults
    to it.
    """
    discrepancy = judgement.discrepancy
    if not discrepancy.has_bodies:
        return
    reference = discrepancy.comparison.reference_cycle
    half_planes = np.array(
        [reference.pressure[discrepancy.rows], reference.shear[discrepancy.rows]]
    )
    half_planes = np.where(np.isfinite(half_planes), half_planes, discrepancy.reference_tractions)
    fit_before = Fit((), (), half_planes, discrepancy.residuals(half_planes))
    share_left_by_bodies = share_left(judgement.no_cause, fit_before, judgement.channels)
    if share_left_by_bodies < MOST_LEFT:
        evidence = tuple(_evidence(judgement, judgement.no_cause, share_left_by_bodies))
        yield Diagnosis(OWN_BODIES, WORDS["others"][OWN_BODIES], evidence, 1 - share_left_by_bodies)


def _mesh_at_edges(judgement: Judgement) -> Iterator[Diagnosis]:
    """The finding that the mesh is too coarse at the edges: where the squared difference within two
    elements of an edge of contact or stick is far larger than elsewhere. Nothing otherwise.
    `judgement` holds the difference and the fits of known faults to it.
    """
    from scipy.stats import f as f_distribution

    discrepancy = judgement.discrepancy
    prediction = coarse_edge(discrepancy)
    if prediction is None or judgement.is_right(judgement.no_cause, PRESSURE):
        return  # a mesh that errs at stick edges errs at the edges of contact as well
    predicted_values, is_near = prediction
    fit = Fit((), (), predicted_values, discrepancy.residuals(predicted_values))
    share_left_by_mesh = share_left(fit, judgement.no_cause, judgement.channels)
    residuals_of_channels = np.array(
        [judgement.no_cause.residuals[channel].values for channel in judgement.channels]
    )
    is_in_contact = judgement.no_cause.residuals[PRESSURE].is_inside
    values_near = residuals_of_channels[:, is_in_contact & is_near].ravel()
    values_far = residuals_of_channels[:, is_in_contact & ~is_near].ravel()
    ratio_of_squares = np.mean(values_near**2) / max(float(np.mean(values_far**2)), ROUND_OFF)
    chance = float(f_distribution.sf(ratio_of_squares, len(values_near), len(values_far)))
    if share_left_by_mesh > MOST_LEFT or ratio_of_squares < MOST_LEFT**-2 or chance > CHANCE:
        return
    sentence = FAULTS["coarse_edge"].format(spacing=1 / discrepancy.elements)
    yield Diagnosis(
        "coarse_edge",
        sentence,
        tuple(_evidence(judgement, fit, share_left_by_mesh)),
        1 - share_left_by_mesh,
    )


def _not_found(judgement: Judgement, verdict: Verdict) -> Diagnosis:
    """The finding that no cause was found, with its evidence: errors, causes that the file does not
    tell apart, and those that are excluded, with the reasons. `judgement` holds the causes that
    were tried, `verdict` the best explanations.
    """
    discrepancy = judgement.discrepancy
    pressure, shear = discrepancy.errors()
    evidence_lines = [
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        " that, at the worst instant"
    ]
    if verdict.fit is not None and verdict.rivals:
        choices = [verdict.fit, *verdict.rivals]
        names_in_words = " or ".join(_names_of(fit) for fit in choices)
        evidence_lines.insert(0, f"the file does not tell these apart: {names_in_words}")
    if judgement.reason_by_cause:
        names_in_words = "; ".join(
            f"{WORDS['names'][key]}: {reason}" for key, reason in judgement.reason_by_cause.items()
        )
        evidence_lines.append(f"excluded: {names_in_words}")
    evidence_lines += _left_by_each(judgement)
    evidence_lines += _where_it_lies(discrepancy)
    return Diagnosis(UNKNOWN, WORDS["others"][UNKNOWN], tuple(evidence_lines), 0.0)


def _where_it_lies(discrepancy: Discrepancy) -> Iterator[str]:
    """Sentences on the place and the instant of the largest difference in contact, and on how much
    of its square lies beside edges, where more of it does than of the points. `discrepancy` holds
    the tractions of result and reference.
    """
    is_in_contact = discrepancy.in_contact(discrepancy.reference_tractions)
    difference = discrepancy.result_tractions - discrepancy.reference_tractions
    scaled_difference = np.where(is_in_contact, difference / discrepancy.units, 0.0)
    if not scaled_difference.any():
        return
    index_of_largest = np.unravel_index(
        np.argmax(np.abs(scaled_difference)), scaled_difference.shape
    )
    channel, instant, point = map(int, index_of_largest)
    position = discrepancy.x[point] / discrepancy.half_width
    yield (
        f"largest: the {TRACTIONS[channel]} at x = {position:.2g} a_ref, t ="
        f" {discrepancy.time[instant]:.4g}, by {scaled_difference[channel, instant, point]:+.2g}"
        f" {_UNITS[channel]}"
    )
    is_near_edge = near_edges(discrepancy)
    squares = discrepancy.weight * np.sum(scaled_difference**2, axis=0)
    share_near = float(squares[is_near_edge].sum() / squares.sum())
    share_of_points = float(np.mean(is_near_edge[is_in_contact]))
    if share_near > share_of_points:
        yield (
            f"{share_near:.0%} of its square lies within two spacings of an edge of contact or"
            f" stick, which {share_of_points:.0%} of the points in contact do"
        )


def _names_of(fit: Fit) -> str:
    """Its causes in a few words."""
    return " with ".join(str(WORDS["names"][key]) for key in sorted(fit.keys))


def _left_by_each(judgement: Judgement) -> Iterator[str]:
    """A sentence with each known fault that was fitted alone to the difference (in `judgement`):
    the share of the difference that it leaves unexplained, smallest first. Faults that explain no
    more than chance would are left out.
    """
    least_left: dict[str, float] = {}
    for fit in judgement.search.fit_by_question.values():
        if fit is None or len(fit.causes) != 1:
            continue
        (cause,) = fit.causes
        share = share_left(fit, judgement.no_cause, (cause.channel,))
        if share < 1 and by_chance(fit, judgement.no_cause, (cause.channel,)) < CHANCE:
            least_left[cause.key] = min(share, least_left.get(cause.key, 1.0))
    causes_by_share = sorted(least_left.items(), key=lambda item: item[1])
    shares_in_words = ", ".join(
        f"{WORDS['names'][key]} {share:.0%}" for key, share in causes_by_share
    )
    if shares_in_words:
        yield (
            f"each alone leaves of the difference (pressure, or shear): {shares_in_words}; all"
            " others all"
        )
