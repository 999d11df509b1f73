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
from reports.scoring.causes_in_words import (
    key_of_sentence,
    sentence_on_cause,
    sentence_on_few_points,
    size_in_words,
)
from reports.scoring.discrepancy import PRESSURE, TRACTIONS, Discrepancy, discrepancy_of
from reports.scoring.fits import (
    LARGEST_PROBABILITY_BY_CHANCE,
    LARGEST_SHARE_LEFT,
    ROUND_OFF_SQUARE,
    Fit,
    Search,
    explains_difference,
    probability_by_chance,
    share_of_difference_left,
)
from reports.scoring.judgement import Attribution, Judgement
from reports.scoring.other_problems import other_problems
from reports.scoring.traces import (
    FAULTS,
    OWN_BODIES,
    UNKNOWN,
    WORDS,
    Diagnosis,
    find_alternating_nodes,
    find_elastic_slip,
    find_full_slip,
    find_long_steps,
    find_outliers,
    find_scatter,
    points_near_edges,
    tractions_of_coarse_mesh,
)
from reports.scoring.variants import Predictions

_TRACTION_UNIT_WORDS = ("p_ref", "f p_ref")


def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """Findings on why an external result differs from the reference. Empty without a contact.

    Looked for in turn: single outliers; traces, signs of one fault in a few rows, such as creep in
    stick; known faults, fitted to all tractions; other problems, such as adhesion; bodies, mesh and
    scatter. Where nothing is found for tractions outside their tolerances, one finding says so.

    Where the tractions are within their tolerances, outliers and traces are looked for first, then
    load steps that are too long. If nothing is found and the whole comparison is within tolerance,
    a shear beyond the Coulomb limit comes last, and no known fault is fitted.
    """
    # tractions of both at instants of the last cycle; None where neither has a contact
    discrepancy = discrepancy_of(comparison)
    if discrepancy is None:
        return ()
    outlier_findings = find_outliers(comparison)
    trace_findings = [
        *find_full_slip(discrepancy),
        *find_elastic_slip(discrepancy),
        *find_alternating_nodes(discrepancy),
    ]
    if discrepancy.is_within_tolerances:
        findings = (*outlier_findings, *trace_findings) or tuple(find_long_steps(comparison))
        if findings or comparison.verdict == "within":
            return findings or tuple(_finding_beyond_coulomb_limit(discrepancy))

    # known faults, fitted to all tractions: the fit that explains the difference best, and its
    # rivals
    judgement = Judgement(discrepancy, Search(discrepancy, Predictions(discrepancy)))
    attribution = judgement.attribution()
    has_trace = bool(trace_findings)
    findings_of_fit = list(_findings_of_fit(judgement, attribution, has_trace=has_trace))
    # SHEAR_SIGN: the cause that the shear has the wrong sign
    sign_findings = [finding for finding in findings_of_fit if finding.fault == SHEAR_SIGN.key]
    # shear of the wrong sign hides creep in stick: look again with its sign turned
    if sign_findings and not has_trace:
        hidden_trace_findings = list(find_elastic_slip(discrepancy, shear_sign=-1.0))
        if hidden_trace_findings:
            findings_on_pressure = _findings_of_fit(judgement, attribution, has_trace=True)
            findings_of_fit = [*findings_on_pressure, *sign_findings, *hidden_trace_findings]

    # problems that the suite does not solve; then bodies, mesh and scatter
    is_all_explained = attribution.fit is not None and judgement.are_tractions_explained(
        attribution.fit
    )
    if not has_trace and not is_all_explained:
        findings_of_fit = list(other_problems(discrepancy, attribution.fit)) or findings_of_fit
    if not has_trace and not findings_of_fit:
        findings_of_fit = [
            *_finding_of_scene_bodies(judgement),
            *_finding_of_mesh_at_edges(judgement),
            *find_scatter(discrepancy),
        ][:1]
    findings = (*outlier_findings, *trace_findings, *findings_of_fit)
    if not findings and not discrepancy.is_within_tolerances:
        return (_finding_of_no_cause(judgement, attribution),)
    return findings


def _finding_beyond_coulomb_limit(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """The finding of a wrong factor of the shear, for a result within every tolerance whose shear
    exceeds the Coulomb limit f p. Nothing otherwise. `discrepancy` holds the tractions of result
    and reference.

    # notation: f coefficient of friction, p pressure
    """
    # checks of the laws of contact on the result; "cone": the Coulomb limit
    checks = discrepancy.comparison.result_certificates
    if not discrepancy.has_shear or all(check.holds for check in checks if check.name == "cone"):
        return
    judgement = Judgement(discrepancy, Search(discrepancy, Predictions(discrepancy)))
    # None where a factor of the shear leaves more than noise
    fit = judgement.fit_of_shear_factor()
    if fit is not None:
        yield from _findings_of_fit(judgement, Attribution(fit), has_trace=False)


def _findings_of_fit(
    judgement: Judgement, attribution: Attribution, *, has_trace: bool
) -> Iterator[Diagnosis]:
    """Findings (sentence, evidence, strength) on the causes, known faults of a result, that explain
    its difference from the reference best.

    Where rivals explain it as well, only causes that are common to all of them are named. The
    strength of a finding is 1 minus the ratio of two norms: of what the fit leaves of the
    difference, and of what it leaves without the cause.

    Parameters
    ----------
    judgement
        the difference and the fits of causes to it; `components` are the tractions that count,
        pressure, and shear where the file has one
    attribution
        the fit that explains the difference best, and its rivals: fits that do as well
    has_trace
        whether a trace in the shear was found, such as creep in stick; causes that show in the
        shear alone are then left out
    """
    fit = attribution.fit
    if fit is None:
        return
    keys_common_to_rivals = fit.keys.intersection(*(rival.keys for rival in attribution.rivals))
    for cause, size in zip(fit.causes, fit.sizes, strict=True):
        if cause.key not in keys_common_to_rivals:
            continue
        # the best fit of the other causes alone
        fit_without_cause = _fit_without_cause(judgement, fit, cause)
        # What has a trace of its own in the shear needs no second explanation of it.
        if has_trace and not explains_difference(fit, fit_without_cause, (PRESSURE,)):
            continue
        # a layer's effect on the shear is not predicted
        components = (PRESSURE,) if cause is SOFT_NORMAL else judgement.components
        # norm of what the fit leaves, over that without the cause; then over the whole difference
        share_left_by_cause = share_of_difference_left(fit, fit_without_cause, components)
        share_left_by_fit = share_of_difference_left(fit, judgement.fit_without_causes, components)
        evidence_sentences = list(_sentences_of_evidence(judgement, fit, share_left_by_fit))
        if attribution.is_shear_unexplained:
            evidence_sentences.append(
                "it explains the pressure; the shear differs for a reason not found"
            )
        # key and sentence of the finding, evidence, strength, size in words
        yield Diagnosis(
            key_of_sentence(cause, size),
            sentence_on_cause(judgement.discrepancy, cause, size, fit),
            tuple(evidence_sentences),
            strength=1 - min(share_left_by_cause, 1.0),
            size=size_in_words(cause, size),
        )


def _fit_without_cause(judgement: Judgement, fit: Fit, cause: Cause) -> Fit:
    """The fit of all causes of `fit` but this one."""
    other_causes = tuple(other_cause for other_cause in fit.causes if other_cause is not cause)
    return (
        judgement.search.best_fit(other_causes, judgement.components)
        or judgement.fit_without_causes
    )


def _sentences_of_evidence(
    judgement: Judgement, fit: Fit, share_left_by_fit: float
) -> Iterator[str]:
    """Measured values, in sentences, that support a finding: sum of the pressures, noise, share of
    the difference that is left, errors of pressure and shear before and after.

    `judgement` holds the difference of the result from the reference, `fit` the causes fitted to
    it; `share_left_by_fit` is the share of the difference that this fit leaves.

    # notation: f coefficient of friction, P normal load, p_ref scale of pressure
    """
    discrepancy = judgement.discrepancy
    # integral of the pressure over P
    resultant_ratio = discrepancy.resultant_ratio
    if np.isfinite(resultant_ratio):
        yield f"the sum of the pressures is {resultant_ratio:.4g} P"
    # root mean square, of pressure over p_ref and of shear over f p_ref
    noise = fit.mean_square_of_noise(judgement.components) ** 0.5
    yield (
        f"{fit.n_values((PRESSURE,))} values in contact; noise from point to point {noise:.2g} of"
        " the scales"
    )
    # SOFT_NORMAL: the cause that a soft layer covers the faces; its effect on the shear is not
    # predicted
    component_in_words = " of the pressure" if SOFT_NORMAL in fit.causes else ""
    subject_in_words = "a result with just this fault leaves"
    causes_in_words = "the fault"
    if len(fit.causes) > 1:
        subject_in_words = "both causes together leave"
        causes_in_words = "both"
    percentage_in_words = f"{max(share_left_by_fit, 0.0):.1%}"
    yield f"{subject_in_words} {percentage_in_words} of the difference{component_in_words}"
    # over the norm of the reference's pressure, and f times that, at the worst instant
    error_of_pressure, error_of_shear = discrepancy.relative_errors()
    # with the fitted tractions in place of the reference's
    discrepancy_after = replace(discrepancy, reference_tractions=fit.predicted_tractions)
    error_of_pressure_after, error_of_shear_after = discrepancy_after.relative_errors()
    yield (
        f"error of the pressure {error_of_pressure:.2g} of its norm, of the shear"
        f" {error_of_shear:.2g} of f times that, at the worst instant; with"
        f" {causes_in_words} taken out, "
        f"{error_of_pressure_after:.2g} and {error_of_shear_after:.2g}"
    )
    if discrepancy.missing_share:
        yield f"{discrepancy.missing_share:.1%} of the tractions are no numbers and were left out"
    if discrepancy.outlier_share:
        yield (
            f"{100 * discrepancy.outlier_share:.2g} % of the tractions were left out, at single"
            " values that no neighbour supports"
        )
    if discrepancy.unsymmetric:
        yield (
            "with bulk stress, tilt or unequal sides not looked for: no memory, unlike bodies, soft"
            " penalties, bodies too small"
        )


def _finding_of_scene_bodies(judgement: Judgement) -> Iterator[Diagnosis]:
    """The finding that the difference is the idealisation itself: half-plane theory corrected for
    the scene's finite bodies leaves less than a third of the difference that half-plane theory
    leaves (norm). Nothing otherwise, and for bodies that are half-planes. `judgement` holds the
    difference and the fits of causes to it.
    """
    discrepancy = judgement.discrepancy
    # whether its reference_tractions are theory corrected for the bodies, in place of plain theory
    if not discrepancy.has_bodies:
        return
    # plain half-plane theory at the instants compared
    reference_cycle = discrepancy.comparison.reference_cycle
    theory_tractions = np.array(
        [
            reference_cycle.pressure[discrepancy.instants_of_cycle],
            reference_cycle.shear[discrepancy.instants_of_cycle],
        ]
    )
    theory_tractions = np.where(
        np.isfinite(theory_tractions), theory_tractions, discrepancy.reference_tractions
    )
    # no cause is fitted here: what is left is the difference from half-plane theory
    fit_of_theory = Fit((), (), theory_tractions, discrepancy.residuals(theory_tractions))
    fit_with_bodies = judgement.fit_without_causes  # its reference has the bodies in it
    share_left_by_bodies = share_of_difference_left(
        fit_with_bodies, fit_of_theory, judgement.components
    )
    if share_left_by_bodies < LARGEST_SHARE_LEFT:
        # key and sentence of the finding, evidence, strength
        yield Diagnosis(
            OWN_BODIES,
            WORDS["others"][OWN_BODIES],
            tuple(_sentences_of_evidence(judgement, fit_with_bodies, share_left_by_bodies)),
            strength=1 - share_left_by_bodies,
        )


def _finding_of_mesh_at_edges(judgement: Judgement) -> Iterator[Diagnosis]:
    """The finding that the mesh is too coarse at the edges. The mean squared difference within two
    elements of an edge of contact or stick is at least nine times that elsewhere in contact. And
    a coarse mesh leaves at most a third of the difference. Nothing otherwise. `judgement` holds
    the difference and the fits of causes to it.

    # notation: a_ref half-width of contact of the reference, f coefficient of friction, p pressure,
    #           p_ref scale of pressure, q shear
    """
    from scipy.stats import f as f_distribution

    discrepancy = judgement.discrepancy
    # tractions of such a mesh (2, k, n), and which points lie near an edge
    prediction = tractions_of_coarse_mesh(discrepancy)
    if prediction is None or judgement.is_traction_explained(
        judgement.fit_without_causes, PRESSURE
    ):
        return  # a mesh that errs at stick edges errs at the edges of contact as well
    predicted_tractions, is_near_edge = prediction
    # no cause is fitted here: what is left is the difference of the result from these tractions
    fit_of_coarse_mesh = Fit(
        (), (), predicted_tractions, discrepancy.residuals(predicted_tractions)
    )
    share_left_by_mesh = share_of_difference_left(
        fit_of_coarse_mesh, judgement.fit_without_causes, judgement.components
    )
    # result minus reference: of p over p_ref, of q over f p_ref, (k, n) each
    residuals = judgement.fit_without_causes.residuals
    differences = np.array([residuals[component].values for component in judgement.components])
    is_in_contact = residuals[PRESSURE].is_in_contact
    differences_near_edges = differences[:, is_in_contact & is_near_edge].ravel()
    differences_elsewhere = differences[:, is_in_contact & ~is_near_edge].ravel()
    mean_square_elsewhere = max(float(np.mean(differences_elsewhere**2)), ROUND_OFF_SQUARE)
    ratio_of_squares = np.mean(differences_near_edges**2) / mean_square_elsewhere
    # probability that chance alone gives such a ratio, by the F test
    probability_by_chance = float(
        f_distribution.sf(ratio_of_squares, len(differences_near_edges), len(differences_elsewhere))
    )
    # at most a third is left, a ratio of nine, a probability of 1e-6
    if (
        share_left_by_mesh > LARGEST_SHARE_LEFT
        or ratio_of_squares < LARGEST_SHARE_LEFT**-2
        or probability_by_chance > LARGEST_PROBABILITY_BY_CHANCE
    ):
        return
    # key and sentence of the finding, evidence, strength
    yield Diagnosis(
        "coarse_edge",
        # template of the sentence; spacing of the points over a_ref
        FAULTS["coarse_edge"].format(spacing=1 / discrepancy.elements_per_half_width),
        tuple(_sentences_of_evidence(judgement, fit_of_coarse_mesh, share_left_by_mesh)),
        strength=1 - share_left_by_mesh,
    )


def _finding_of_no_cause(judgement: Judgement, attribution: Attribution) -> Diagnosis:
    """The finding that no cause was found, with its evidence: errors; causes that explain the
    result equally well; causes that are excluded, with the reasons; a mesh with few points; and the
    place of the largest difference.

    `judgement` holds the causes that were tried, `attribution` the best explanation and its rivals.
    """
    discrepancy = judgement.discrepancy
    pressure_error, shear_error = discrepancy.relative_errors()
    sentences = [
        f"error of the pressure {pressure_error:.2g} of its norm, of the shear {shear_error:.2g} of"
        " f times that, at the worst instant"
    ]
    if attribution.fit is not None and attribution.rivals:
        rivals_in_words = " or ".join(
            _names_of_causes(fit) for fit in (attribution.fit, *attribution.rivals)
        )
        sentences.insert(0, f"the file does not tell these apart: {rivals_in_words}")
    # key of a cause -> what in the result excludes it
    if judgement.reason_by_cause:
        exclusions_in_words = "; ".join(
            # WORDS: names and sentences of findings, by key
            f"{WORDS['names'][key]}: {reason}"
            for key, reason in judgement.reason_by_cause.items()
        )
        sentences.append(f"excluded: {exclusions_in_words}")
    sentences += sentence_on_few_points(discrepancy)
    # what each cause alone leaves of the difference
    sentences += _shares_left_by_single_causes(judgement)
    sentences += _place_of_largest_difference(discrepancy)
    # key and sentence of the finding, evidence, strength
    return Diagnosis(UNKNOWN, WORDS["others"][UNKNOWN], tuple(sentences), strength=0.0)


def _place_of_largest_difference(discrepancy: Discrepancy) -> Iterator[str]:
    """Sentences on where and when the tractions of result and reference differ most in contact, and
    on the share of the squared difference beside edges, where that is more than the share of the
    points there. Nothing without a difference.

    Differences are over p_ref (pressure) and f p_ref (shear). Their squares are weighted by length
    and time.

    # notation: a_ref half-width of contact of the reference, f coefficient of friction, p_ref scale
    #           of pressure
    """
    # whether a point has pressure in the result or in the reference, (k, n)
    is_in_contact = discrepancy.mask_in_contact(discrepancy.reference_tractions)
    difference = discrepancy.result_tractions - discrepancy.reference_tractions
    scaled_difference = np.where(is_in_contact, difference / discrepancy.traction_units, 0.0)
    if not scaled_difference.any():
        return
    index_of_largest = np.unravel_index(
        np.argmax(np.abs(scaled_difference)), scaled_difference.shape
    )
    component, instant, point = map(int, index_of_largest)
    position = discrepancy.x[point] / discrepancy.half_width
    # component 0 is the pressure, 1 the shear; TRACTIONS are their names
    yield (
        f"largest: the {TRACTIONS[component]} at x = {position:.2g} a_ref, t ="
        f" {discrepancy.time[instant]:.4g}, by {scaled_difference[component, instant, point]:+.2g}"
        f" {_TRACTION_UNIT_WORDS[component]}"
    )
    # within two spacings of an edge of contact or stick
    is_near_edge = points_near_edges(discrepancy)
    # weight (k, n): of length and time in sums
    squares = discrepancy.weight * np.sum(scaled_difference**2, axis=0)
    share_of_square = float(squares[is_near_edge].sum() / squares.sum())
    share_of_points = float(np.mean(is_near_edge[is_in_contact]))
    if share_of_square > share_of_points:
        yield (
            f"{share_of_square:.0%} of its square lies within two spacings of an edge of contact or"
            f" stick, which {share_of_points:.0%} of the points in contact do"
        )


def _names_of_causes(fit: Fit) -> str:
    """The causes of a fit, named in a few words."""
    return " with ".join(str(WORDS["names"][key]) for key in sorted(fit.keys))


def _shares_left_by_single_causes(judgement: Judgement) -> Iterator[str]:
    """A sentence with each cause (known fault) that was fitted alone to the difference: the share
    of the difference that it leaves unexplained, smallest first. Causes that explain no more than
    chance would are left out. Nothing where all are. `judgement` holds the difference and all fits
    made to it.
    """
    least_share_by_key: dict[str, float] = {}
    # fit_by_key: every fit that was made, by its causes
    for fit in judgement.search.fit_by_key.values():
        if fit is None or len(fit.causes) != 1:
            continue
        (cause,) = fit.causes
        # component: pressure where that shows the cause, else shear
        share = share_of_difference_left(fit, judgement.fit_without_causes, (cause.component,))
        chance = probability_by_chance(fit, judgement.fit_without_causes, (cause.component,))
        if share < 1 and chance < LARGEST_PROBABILITY_BY_CHANCE:
            least_share_by_key[cause.key] = min(share, least_share_by_key.get(cause.key, 1.0))
    # WORDS: names of causes, by key
    keys_by_share = sorted(least_share_by_key, key=least_share_by_key.__getitem__)
    shares_in_words = ", ".join(
        f"{WORDS['names'][key]} {least_share_by_key[key]:.0%}" for key in keys_by_share
    )
    if shares_in_words:
        yield (
            f"each alone leaves of the difference (pressure, or shear): {shares_in_words}; all"
            " others all"
        )
