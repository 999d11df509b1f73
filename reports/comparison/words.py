"""A comparison in sentences and table cells, the same on the page, in the terminal and in a
notebook.

The sentences are in templates/words.txt; here are the numbers that fill them.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, Literal

import numpy as np

from reports.charts.templating import in_template, template
from reports.comparison.laws import (
    Certificate,
    Verdict,
    certificates,
    largest_load_ratio,
    values_of_unsymmetric,
)
from reports.comparison.metrics import JudgedPair, Metric
from reports.comparison.pairs import (
    are_half_planes,
    engine_in_words,
    has_coupled_tractions,
    stated_uncertainty,
)
from reports.comparison.work_of_loads import normal_work
from reports.measured import load_cycles
from reports.units import energy_unit, load_unit, minus, number, signed, units
from scenes import ContactSolution, Scene, TimeSeriesLoad, Wave, sampled_times
from scenes.measured import ReadAs

SUPPORT_WORDS = {
    "fixed": "fixed",
    "rollers": "on rollers along x",
    "guided": "guided along y",
    "half_plane": "joined to the half-plane around it",
    "pulled": "free, with the bulk stress on them",
}


# ------------------------------------------------------------------------------------ what is asked
def part_of_path(scene: Scene) -> str:
    """The part of the load path to which the values of a scene belong, in words: the "last cycle"
    where loads repeat, the "whole record" for a table of loads over time, else the "whole path".

    >>> from scenes import load_scene
    >>> [part_of_path(load_scene(name)) for name in ("hertz-paper", "time-series", "hertz-normal")]
    ['last cycle', 'whole record', 'whole path']
    """
    load_record = scene.load
    # a table first, since its path, with a load segment for each row, is slow to make
    if isinstance(load_record, TimeSeriesLoad):
        return "last cycle" if load_record.repeats else "whole record"
    return "whole path" if load_record.path().period is None else "last cycle"


def text_on_part_of_path(text: str, scene: Scene) -> str:
    """A text on the last cycle, as in the table of metrics, for a given scene: where its loads do
    not repeat, "whole record" or "whole path" replaces "last cycle".

    >>> from scenes import load_scene
    >>> (
    ...     text_on_part_of_path("one value; last cycle", load_scene("time-series")),
    ...     text_on_part_of_path("over the cycle", load_scene("hertz-normal")),
    ... )
    ('one value; whole record', 'over the path')
    """
    if "cycle" not in text:
        return text
    path_in_words = part_of_path(scene)
    if path_in_words == "last cycle":
        return text
    noun = path_in_words.split()[-1]  # "record" or "path"
    text = text.replace("whole last cycle", path_in_words)
    text = text.replace("last cycle", path_in_words)
    return text.replace("the cycle", f"the {noun}")


def question_in_words(scene: Scene) -> str:
    """A sentence on the question of a scene: bodies, material, friction, loads, with units."""
    return in_template(
        "question", scene, *units(scene)[1:], load_unit(scene), bulk_and_tilt_in_words(scene)
    )


def bulk_and_tilt_in_words(scene: Scene) -> str:
    """The bulk stresses, tilt, moment or line of action in the loads of a scene, a sentence each;
    empty without any.

    >>> from scenes import load_scene
    >>> bulk_and_tilt_in_words(
    ...     load_scene("cattaneo-mindlin").vary(
    ...         load={"bulk_stress_lower": (0.0, 50.0, -50.0), "tilt": 0.001}
    ...     )
    ... )
    'The lower body is under a bulk stress from −50 to 50 MPa along x. The upper body is tilted by
    0.001 rad.'
    >>> tilt_over_time = {"tilt": (0.0, 0.001, -0.001)}
    >>> bulk_and_tilt_in_words(load_scene("cattaneo-mindlin").vary(load=tilt_over_time))
    'The upper body is tilted from −0.001 to 0.001 rad.'
    """
    # the template "bulk_and_tilt"; the function that it is given states a load over time in words
    # words for the units of force, length and stress
    return in_template("bulk_and_tilt", scene.load, partial(_load_in_words, scene), *units(scene))


def _load_in_words(
    scene: Scene, name_of_pair: str, index: int, value: Any, preposition: str = "of"
) -> str:
    """A bulk stress, tilt or moment over time in words, with a preposition: "of 50", "of 50 + 20
    cos(t - 30°)", or "from -50 to 50" for a load that is neither a number nor a cosine.

    Parameters
    ----------
    name_of_pair, index
        attribute of a load segment that holds a pair of loads, and 0 or 1 for the load in it:
        "bulk" (stresses of the lower and the upper body) or "tilt_and_moment" (tilt or moment)
    value
        the load as the scene states it: a number, a cosine (`Wave`), or values over time
    preposition
        stands before a number or a cosine
    """
    if isinstance(value, Wave):
        # `number`: as text, to six digits
        return (
            f"{preposition} {number(value.mean)} + {number(value.amplitude)} cos(t −"
            f" {number(value.phase_degrees)}°)".replace("− −", "+ ")
        )
    if isinstance(value, int | float):
        return f"{preposition} {number(value)}"
    path = scene.load.path()
    # the pair of loads over time in each load segment of the cycle that is repeated; of the whole
    # path where none is
    pairs_of_loads = [
        getattr(segment, name_of_pair) for segment in path.cycle or path.initial_loading
    ]
    load_samples = np.concatenate(
        [
            np.ravel(pair_of_loads.loads(sampled_times(pair_of_loads, 65))[index])
            for pair_of_loads in pairs_of_loads
            if pair_of_loads is not None
        ]
    )
    least_value = number(float(f"{load_samples.min():.4g}"))
    largest_value = number(float(f"{load_samples.max():.4g}"))
    return f"from {least_value} to {largest_value}"


def bodies_in_words(scene: Scene) -> str:
    """Both bodies, what holds them, where the load acts and where the gap comes from."""
    return in_template("bodies", scene, units(scene)[1])


def idealisation_in_words(scene: Scene) -> str:
    """A sentence on what theory leaves out for these bodies, so that the difference of the two
    engines holds it beside their errors; empty where theory is exact.
    """
    return (
        ""
        if are_half_planes(scene)
        else in_template("idealisation", scene, has_coupled_tractions(scene))
    )


def unlike_materials_in_words(scene: Scene) -> str:
    """Dundurs' parameters and what they mean for half-plane theory; empty for like materials."""
    if scene.material.alike:
        return ""
    from halfplane_fe.dundurs import dundurs

    return in_template(
        "unlike", dundurs(scene.material), has_coupled_tractions(scene), scene.friction.coefficient
    )


def sentence_beyond_theory(comparison: JudgedPair) -> str:
    """A sentence on what the difference holds beside errors of the two solutions; empty where the
    reference is exact for the bodies.
    """
    if _are_both_of_project(comparison):
        return idealisation_in_words(comparison.scene)
    if comparison.reference.engine != "semi_analytic" or are_half_planes(comparison.scene):
        return ""
    return in_template("beyond_theory", engine_in_words(comparison.result.engine))


def _are_both_of_project(comparison: JudgedPair) -> bool:
    """Whether reference and result are half-plane theory and finite elements of this program."""
    return {comparison.reference.engine, comparison.result.engine} == {
        "semi_analytic",
        "halfplane_fe",
    }


# -------------------------------------------------------------------------------- values of metrics
# A relative value below this is round-off of a sum over the instants of a cycle; comparison.json
# has every digit.
_ROUNDING = 1e-13


def _number_in_words(
    value: float, *, is_relative: bool = True, plus: bool = True, digits: int = 3
) -> str:
    """A value in words to `digits` significant digits; in per cent if it is relative, with a plus
    sign if `plus`. A value below 1e-13 is round-off, written as 0.

    >>> (
    ...     _number_in_words(-0.00123456),
    ...     _number_in_words(0.5, plus=False),
    ...     _number_in_words(-1.87e-16),
    ...     _number_in_words(float("nan")),
    ...     _number_in_words(0.25, is_relative=False),
    ... )
    ('−0.123 %', '50 %', '0 %', 'not a number', '+0.25')
    """
    if not math.isfinite(value):
        return "not a number" if math.isnan(value) else "infinite"
    size = abs(value)
    if size < _ROUNDING:
        size = 0.0
    if is_relative:
        size *= 100
    # two digits of 100 and more would be a power of ten
    size_in_words = f"{size:.{digits}g}" if digits > 2 or size < 99.5 else f"{size:.0f}"
    sign = ""
    if size and value < 0:
        sign = "−"
    elif size and plus:
        sign = "+"
    unit = " %" if is_relative else ""
    # `minus`: with a real minus sign
    return f"{sign}{minus(size_in_words)}{unit}"


def term_in_words(value: float, metric: Metric, *, plus: bool = False, digits: int = 2) -> str:
    """An amount in the unit of a metric, such as a term of its error budget, as the text of a cell:
    in per cent unless the metric is absolute, with a plus sign if `plus`. An amount below 1e-11 is
    round-off, written as 0.
    """
    shown_value = 0.0 if abs(value) < 1e-11 else value
    return _number_in_words(shown_value, is_relative=not metric.absolute, plus=plus, digits=digits)


def value_in_words(metric: Metric) -> str:
    """The value of a metric in words, in per cent unless it is absolute; a dash without a value."""
    if metric.value is None:
        return "–"
    return _number_in_words(metric.value, is_relative=not metric.absolute, plus=metric.signed)


def unit_in_words(metric: Metric) -> str:
    """The unit of a metric's value, and for an edge its shift in element sizes in brackets."""
    if metric.elements is None:
        return metric.unit
    return f"{metric.unit} ({_number_in_words(metric.elements, is_relative=False)} elements)"


def uncertainty_in_words(metric: Metric) -> str:
    """The uncertainty of a metric in words, "± ..." with two digits; empty where none is known."""
    if metric.uncertainty is None:
        return ""
    uncertainty_in_words = _number_in_words(
        metric.uncertainty, is_relative=not metric.absolute, plus=False, digits=2
    )
    return f"± {uncertainty_in_words}"


def tolerance_in_words(metric: Metric) -> str:
    """The tolerance of a metric in words; a dash where it has none."""
    if metric.tolerance is None:
        return "–"
    return _number_in_words(metric.tolerance, is_relative=not metric.absolute, plus=False)


# Most significant digits of a value that is shown.
_MOST_DIGITS = 8


def with_uncertainty(value: float, uncertainty: float | None) -> str:
    """A text "value ± u", both with the same decimals: one significant digit of the uncertainty u,
    or two where it begins with 1.

    Without u (None) the value has three significant digits. Where u would need more than six
    decimals, it is written with a power of ten, and the value with at most eight digits.

    >>> (
    ...     with_uncertainty(2.8512, 0.0614),
    ...     with_uncertainty(0.5231, 0.0113),
    ...     with_uncertainty(12.0, 35.2),
    ...     with_uncertainty(2.8512, None),
    ...     with_uncertainty(0.0020574905, 9.4e-8),
    ... )
    ('2.85 ± 0.06', '0.523 ± 0.011', '12 ± 35', '2.85', '0.00205749 ± 9e−08')
    """
    if uncertainty is None:
        # `minus`: with a real minus sign
        return minus(f"{value:.3g}")
    if not (math.isfinite(uncertainty) and math.isfinite(value)):
        return f"{minus(f'{value:.3g}')} ± {minus(f'{uncertainty:.2g}')}"
    if uncertainty == 0:
        return f"{minus(f'{value:.3g}')} ± 0"
    exponent = math.floor(math.log10(uncertainty))  # of ten, of the first digit of u
    begins_with_one = round(uncertainty / 10**exponent, 6) < 2
    decimals = max(0, -exponent + begins_with_one)
    if decimals > 6:  # a power of ten is easier to read than many zeros
        significant_digits = 2
        if abs(value) > uncertainty:
            significant_digits = min(
                math.floor(math.log10(abs(value))) + decimals + 1, _MOST_DIGITS
            )
        return f"{minus(f'{value:.{significant_digits}g}')} ± {minus(f'{uncertainty:.1g}')}"
    return f"{minus(f'{value:.{decimals}f}')} ± {uncertainty:.{decimals}f}"


# ----------------------------------------------------------------------------- headline and verdict
def headline_sentence(comparison: JudgedPair) -> str:
    """The comparison in one sentence: how wrong half-plane theory is for these bodies, or how far
    the two solutions agree.

    Every number is result/reference − 1. A number that is less than twice its uncertainty is called
    not resolved. For an external result outside its tolerances the sentence names the metrics that
    are outside.

    A metric of `comparison` has a value, its uncertainty (None: not known), and `absolute`: whether
    the value is no share of the reference, whose own amount is 0.
    """
    if _has_failed(comparison):
        return _sentence_of_failure(comparison)
    dissipation = comparison.metric("dissipation")
    # keys of the metrics that the sentence names
    keys = ("largest_pressure", "largest_half_width")
    if dissipation.value is not None and not dissipation.absolute:
        keys = ("dissipation", "largest_pressure")
    metrics = [
        metric
        for metric in map(comparison.metric, keys)
        if metric.value is not None and math.isfinite(metric.value)
    ]
    # "agree": theory and finite elements of half-planes; "theory": finite elements of real bodies;
    # "external": any other pair, such as the result of another program
    kind_of_sentence = "external"
    if _are_both_of_project(comparison) and are_half_planes(comparison.scene):
        kind_of_sentence = "agree"
    elif _are_both_of_project(comparison) and comparison.result.engine == "halfplane_fe":
        kind_of_sentence = "theory"
    if kind_of_sentence == "agree":
        # theory is exact for half-planes: any difference is an error, and its sign has no meaning
        claims = [_claim_of_agreement(metric) for metric in metrics]
    else:
        # (more, less, none, equal or not resolved; name; per cent in words)
        claims = [_claim_of_difference(metric) for metric in metrics]
    # errors of W that both solutions state themselves, where no metric has an uncertainty
    stated_errors = None
    if all(metric.uncertainty is None for metric in metrics):
        stated_errors = _stated_errors(comparison)
    # the template "headline", filled with these values
    return in_template(
        "headline",
        comparison,
        _names_of_engines(comparison),
        kind_of_sentence,
        claims,
        stated_errors,
    )


# Most metrics outside their tolerance that the headline names.
_MOST_METRICS_NAMED = 2
# A relative error of W below this is not told.
_NEGLIGIBLE_ERROR = 1e-6


def _has_failed(comparison: JudgedPair) -> bool:
    """Whether an external result was judged and is outside a tolerance or violates a law of
    contact.
    """
    if _are_both_of_project(comparison) or comparison.verdict is None:
        return False
    return not comparison.accurate or bool(_violated_checks(comparison))


def _metrics_not_passed(comparison: JudgedPair) -> list[Metric]:
    """The metrics that are not within their tolerance: first those outside it, then those that are
    undecided because their uncertainty is too large.
    """
    return [
        metric
        for verdict in (Verdict.OUTSIDE, Verdict.UNDECIDED)
        for metric in comparison.metrics
        if metric.verdict is verdict
    ]


def _sentence_of_failure(comparison: JudgedPair) -> str:
    """The sentence on an external result that fails: the metrics outside their tolerance, the one
    with the largest |value|/tolerance first.

    Where no metric is outside, it names those that are undecided (their uncertainty reaches across
    the tolerance). Where none is undecided, it names the laws of contact that are violated. At most
    two metrics are named.
    """

    def multiple_of_tolerance(metric: Metric) -> float:
        """|value|/tolerance"""
        return abs(metric.value or 0.0) / (metric.tolerance or 1.0)

    # outside before undecided: the first metric has the worst verdict
    metrics_not_passed = _metrics_not_passed(comparison)
    worst_metrics = [
        metric for metric in metrics_not_passed if metric.verdict is metrics_not_passed[0].verdict
    ]
    worst_metrics.sort(key=multiple_of_tolerance, reverse=True)
    # A metric without a tolerance of its own (`judged_by` is the key of another) is close to the
    # metric that lends it the tolerance: both in one sentence would repeat it.
    metrics_with_own_tolerance = [metric for metric in worst_metrics if not metric.judged_by]
    named_metrics = (metrics_with_own_tolerance or worst_metrics)[:_MOST_METRICS_NAMED]
    # the template "failure", filled with names of engines, verdict, counts, texts and laws
    return in_template(
        "failure",
        comparison,
        _names_of_engines(comparison),
        comparison.verdict,
        len(worst_metrics),
        _count_of_judged_metrics(comparison),
        [_texts_of_metric(metric) for metric in named_metrics],
        [check for _, check in _violated_checks(comparison)],
    )


def _violated_checks(comparison: JudgedPair) -> list[tuple[str, Certificate]]:
    """(name of the engine, check) for every check of a law of contact that the reference or the
    result does not pass, as its `holds` states.
    """
    checked_solutions = (
        (comparison.reference, comparison.reference_certificates),
        (comparison.result, comparison.result_certificates),
    )
    return [
        (engine_in_words(solution.engine), check)
        for solution, checks in checked_solutions
        for check in checks
        if not check.holds
    ]


def _count_of_judged_metrics(comparison: JudgedPair) -> int:
    """Number of metrics with a tolerance and a value."""
    return sum(
        metric.tolerance is not None and metric.value is not None for metric in comparison.metrics
    )


def _names_of_engines(comparison: JudgedPair) -> tuple[str, str]:
    """Names of the engines of the reference and of the result."""
    return engine_in_words(comparison.reference.engine), engine_in_words(comparison.result.engine)


def _stated_errors(comparison: JudgedPair) -> list[tuple[str, str]]:
    """The relative error of the dissipation W that result and reference state themselves, in words:
    (name of the engine, per cent) for each. An error below 1e-6 is left out, and any of W = 0.
    """
    errors_in_words = []
    for solution in (comparison.result, comparison.reference):
        uncertainty = _stated_uncertainty_of_work(solution)
        if uncertainty and solution.dissipation:
            percent = 100 * uncertainty / abs(solution.dissipation)
            errors_in_words.append((engine_in_words(solution.engine), f"{percent:.2g}"))
    return errors_in_words


def _claim_of_agreement(metric: Metric) -> tuple[str, str, str]:
    """How far two solutions agree in a metric for which theory is exact, as ("agreement", name, per
    cent in words): size of the difference plus its uncertainty. A missing value or uncertainty
    counts as 0.
    """
    difference = abs(metric.value or 0.0) + (metric.uncertainty or 0.0)
    return (
        "agreement",
        _label_in_sentence(metric),
        _number_in_words(difference, plus=False, digits=2),
    )


def _claim_of_difference(metric: Metric) -> tuple[str, str, str]:
    """The difference in a metric as (kind, name, difference in per cent in words). Kinds: the
    result has "more" or "less" than the reference, has "none" (exactly −100 %), or is "equal". The
    last two have no per cent ("").

    The kind is "open" (not resolved) where the uncertainty exceeds half of the difference. A metric
    without a value counts as 0. Its value is result/reference − 1.
    """
    difference = metric.value or 0.0
    uncertainty = metric.uncertainty
    uncertainty_in_percent = None if uncertainty is None else 100 * uncertainty
    label = _label_in_sentence(metric)
    if uncertainty is not None and uncertainty > abs(difference) / 2:
        return "open", label, with_uncertainty(100 * difference, uncertainty_in_percent)
    if uncertainty is None and abs(difference) < 1e-12:  # round-off error
        return "equal", label, ""
    if difference == -1:
        return "none", label, ""
    kind = "more" if difference > 0 else "less"
    return kind, label, with_uncertainty(100 * abs(difference), uncertainty_in_percent)


def _label_in_sentence(metric: Metric) -> str:
    """The label of a metric for the middle of a sentence, with a small first letter."""
    return metric.label[:1].lower() + metric.label[1:]


def _texts_of_metric(metric: Metric) -> dict[str, str]:
    """Texts of a metric for the templates of sentences: name, value, "open" (value, and its
    uncertainty where that is known), unit, tolerance.
    """
    value = value_in_words(metric)
    value_and_uncertainty = f"{value} {uncertainty_in_words(metric)}".strip()
    return {
        "name": _label_in_sentence(metric),
        "value": value,
        "open": value_and_uncertainty,
        "unit": unit_in_words(metric),
        "tolerance": tolerance_in_words(metric),
    }


def verdict_in_sentences(comparison: JudgedPair) -> str:
    """The verdict in sentences: the metrics outside their tolerance and those undecided, or that
    all are within; whether the laws of contact hold; the metrics that could not be scored.

    `comparison` holds the metrics, each with value and verdict (None: not judged), and masks (k, n)
    of the isolated values of the result: single tractions or slips that no neighbour supports.
    """
    violated_laws = [f"{check.label} in {name}" for name, check in _violated_checks(comparison)]
    metrics_by_verdict: dict[Verdict, list[dict[str, str]]] = {kind: [] for kind in Verdict}
    for metric in comparison.metrics:
        if metric.verdict is not None:
            metrics_by_verdict[metric.verdict].append(_texts_of_metric(metric))
    dissipation = comparison.metric("dissipation")
    dissipation_in_words = None if dissipation.value is None else value_in_words(dissipation)
    has_no_shear = np.isnan(comparison.result.shear).all()
    n_isolated_values = sum(int(mask.sum()) for mask in comparison.masks_of_isolated.values())
    # the template "verdict", filled with these values
    sentences = in_template(
        "verdict",
        _names_of_engines(comparison),
        metrics_by_verdict,
        _count_of_judged_metrics(comparison),
        dissipation_in_words,
        violated_laws,
        has_no_shear,
        n_isolated_values,
    )
    return f"{sentences} {sentence_on_unscored(comparison)}".strip()


def verdict_in_short(comparison: JudgedPair) -> str:
    """The verdict with names of metrics only: those outside, those undecided, or that all are
    within. The long verdict, with numbers, where no metric is judged, a law of contact is violated,
    or the result has isolated values: single tractions or slips that no neighbour supports.
    """
    has_isolated_values = any(mask.any() for mask in comparison.masks_of_isolated.values())
    first_words = verdict_in_few_words(comparison)  # "Within tolerance."; "" where none is judged
    # admissible: both solutions obey every law of contact that was checked
    if not first_words or has_isolated_values or not comparison.admissible:
        return f"{first_words} {verdict_in_sentences(comparison)}".strip()
    # Without the first words "Undecided.": the next sentence starts with that word.
    sentences = [] if verdict_for_colour(comparison) == "undecided" else [first_words]
    for kind, kind_in_words in ((Verdict.OUTSIDE, "Outside"), (Verdict.UNDECIDED, "Undecided")):
        names = [
            _label_in_sentence(metric) for metric in comparison.metrics if metric.verdict is kind
        ]
        if names:
            sentences.append(f"{kind_in_words}: {'; '.join(names)}.")
    sentences += ["Both answers obey the laws of contact.", sentence_on_unscored(comparison)]
    return " ".join(filter(None, sentences))


def sentence_on_unscored(comparison: JudgedPair) -> str:
    """A sentence on metrics without a value because a solution lacks what they need: those with a
    tolerance, then others of the first table.
    """
    names = [_label_in_sentence(metric) for metric in comparison.unscored]
    headlines = [
        _label_in_sentence(metric)
        for metric in comparison.headlines
        if metric.lacks_field and metric.tolerance is None
    ]
    return in_template("not_scored", names, headlines)


def labels_judged_by_size(comparison: JudgedPair) -> list[str]:
    """Names of the metrics that are judged by |E| alone, since their uncertainty is not known."""
    return [
        _label_in_sentence(metric)
        for metric in comparison.metrics
        if metric.tolerance is not None and metric.value is not None and metric.uncertainty is None
    ]


def sentence_on_judging(comparison: JudgedPair, *, has_budget: bool) -> str:
    """A sentence on how the verdicts were reached: by |E| and its uncertainty, or by |E| alone
    where no uncertainty is known. Empty where no metric is judged. E is the value of a metric;
    `has_budget` states whether an error budget was measured.
    """
    is_judged = any(
        metric.tolerance is not None and metric.value is not None for metric in comparison.metrics
    )
    if not is_judged:
        return ""
    # `in_template`: the text of that name in a template, filled with these values
    return in_template(
        "how_judged",
        labels_judged_by_size(comparison),
        has_budget,
        _are_both_of_project(comparison),
    )


def verdict_in_few_words(comparison: JudgedPair) -> str:
    """The verdict in a few words; empty where no metric is judged.

    Where theory is an idealisation (real bodies, half-planes of unlike materials) an exceeded
    tolerance is a finding if both solutions obey every law. In an external result it may be a
    mistake as well.
    """
    return in_template(
        "lead", comparison, sentence_beyond_theory(comparison), _are_both_of_project(comparison)
    )


def sentence_on_work(comparison: JudgedPair) -> str:
    """A sentence on the dissipation W of the result and its uncertainty by mesh and steps, also in
    per cent of W; empty where the uncertainty is not known.
    """
    solution = comparison.result
    if math.isnan(solution.dissipation_uncertainty):
        return ""
    share_in_words = ""
    if solution.dissipation:
        relative_uncertainty = solution.dissipation_uncertainty / solution.dissipation
        share_in_words = _number_in_words(relative_uncertainty, plus=False)
    # `in_template`: the text of that name in a template, filled with these values
    return in_template(
        "uncertain_work",
        engine_in_words(solution.engine),
        solution,
        share_in_words,
        energy_unit(comparison.scene),
        part_of_path(comparison.scene),
    )


def verdict_for_colour(comparison: JudgedPair) -> Verdict | None:
    """The verdict that sets the colour on the page; None where no metric is judged.

    It is that of the comparison, with two exceptions. It is "outside" where a law of contact is
    violated (not `admissible`). It is "undecided" where no value is outside or undecided, and a
    metric with a tolerance has no value (`unscored`).
    """
    if not comparison.admissible:
        return Verdict.OUTSIDE
    if comparison.unscored and comparison.verdict in (Verdict.WITHIN, None):
        return Verdict.UNDECIDED
    return comparison.verdict


def as_sentence(text: str) -> str:
    """`text` with a capital first letter and a full stop; "" for an empty text.

    >>> as_sentence("to compare"), as_sentence("Why?"), as_sentence("")
    ('To compare.', 'Why?', '')
    """
    full_stop = "." if text and not text.endswith((".", "!", "?")) else ""
    return text[:1].upper() + text[1:] + full_stop


def reading_in_words(name: str, read_as: ReadAs) -> str:
    """How a file was read, as sentences: its layout, then each column with its unit and factor.

    >>> reading_in_words("loop.csv", (("decimal sign", "comma"),))
    'loop.csv, as it was read: Decimal sign: comma.'
    """
    sentences = [as_sentence(": ".join(pair)) for pair in read_as]
    return " ".join([f"{name}, as it was read:", *sentences])


def notebook_html(comparison: JudgedPair, *, has_budget: bool) -> str:
    """A comparison as an HTML fragment for a notebook: headline, table of the values of both
    solutions, verdict, and how the verdict was reached. `has_budget`: whether an error budget was
    measured.
    """
    heads, rows = cells_of_first_table(comparison)  # of text
    sentences = (
        verdict_in_few_words(comparison),
        verdict_in_sentences(comparison),
        sentence_on_judging(comparison, has_budget=has_budget),
    )
    texts = {
        "headline": headline_sentence(comparison),
        "heads": heads,
        "rows": rows,
        "last": " ".join(sentences),
    }
    scene = comparison.scene
    return template("notebook.html").render(texts, title=scene.title or scene.name)


# ------------------------------------------------------------------------------------------- tables
def factor_and_unit_shown(scene: Scene, quantity: str) -> tuple[float, str]:
    """(factor, unit) in which a quantity is shown: slip in µm where lengths are in mm, all others
    in units of the scene. A number of the scene times the factor is in that unit.

    `quantity` is "stress", "moment", "energy", "energy density" or "slip"; any other is a length.
    Energies are per unit thickness.
    """
    unit_of_force, unit_of_length, unit_of_stress = units(scene)
    if quantity == "slip" and unit_of_length == "mm":
        return 1e3, "µm"
    unit_of_quantity = {
        "stress": unit_of_stress,
        "moment": unit_of_force,
        "energy": energy_unit(scene),
        "energy density": f"{unit_of_force}·{unit_of_length}/{unit_of_length}²",
    }
    return 1.0, unit_of_quantity.get(quantity, unit_of_length)


def first_table(comparison: JudgedPair) -> tuple[tuple[str, ...], list[dict[str, str]]]:
    """The table of the values of both solutions of a comparison: column heads, and a row for each
    metric, as texts by key. For an external result that fails, the failing metrics come first.

    Keys of a row: key, label, short (label), reference, result, place (of the result's value),
    difference, verdict, tolerance, note.
    """
    solution_names = [
        {"semi_analytic": "theory"}.get(solution.engine, engine_in_words(solution.engine))
        for solution in (comparison.reference, comparison.result)
    ]
    rows = [
        _row_of_first_table(metric, comparison.scene)
        for metric in _metrics_of_first_table(comparison)
    ]
    return ("", *solution_names, "difference", "verdict"), rows


def _row_of_first_table(metric: Metric, scene: Scene) -> dict[str, str]:
    """The row of a metric in the first table, as texts by key; "–" or "" for what it does not have.

    A metric with a quantity of its own, such as the largest pressure, is a `headline`: it has
    `amounts` in reference and result, and `stated`, their uncertainties by the solutions
    themselves. `place` is that of the result's amount, x over the half-width at the reference load.
    """
    label = metric.label
    short_label = metric.short or metric.label
    factor = 1.0  # from units of the scene to the unit shown
    # a quantity with a unit; the other metrics are shares
    if metric.headline:
        factor, unit = factor_and_unit_shown(scene, metric.quantity)
        label = f"{label} [{unit}]"
        short_label = f"{short_label} [{unit}]"
    reference_amount, result_amount = metric.amounts or (math.nan, math.nan)
    stated_of_reference, stated_of_result = metric.stated
    place_in_words = ""
    if metric.place is not None and metric.value is not None:
        # `signed`: as text, to four digits
        place_in_words = f"x = {signed(float(f'{metric.place:.2g}'))} a"
    return {
        "key": metric.key,
        "label": label,
        "short": short_label,
        "reference": _value_with_stated_uncertainty(reference_amount, stated_of_reference, factor),
        "result": _value_with_stated_uncertainty(result_amount, stated_of_result, factor),
        "place": place_in_words,
        "difference": _difference_in_words(metric),
        "verdict": metric.verdict or "–",
        "tolerance": tolerance_in_words(metric),
        "note": metric.note,
    }


def _metrics_of_first_table(comparison: JudgedPair) -> list[Metric]:
    """The metrics of the first table, those with amounts of both solutions. For an external result
    that fails, all metrics that are not within tolerance come first.
    """
    if not _has_failed(comparison):
        return list(comparison.headlines)
    failing_metrics = _metrics_not_passed(comparison)
    return failing_metrics + [
        metric for metric in comparison.headlines if metric not in failing_metrics
    ]


# A relative uncertainty below this changes none of eight digits: the value is shown as exact.
_EXACT_SHARE = 1e-8


def _value_with_stated_uncertainty(value: float, uncertainty: float | None, factor: float) -> str:
    """A value times a factor in words, with the `uncertainty` that its solution states; "no
    estimate" where that is NaN.

    The value has five digits where it is exact (uncertainty at most 1e-8 of it) or its solution
    states nothing (None). A dash stands for a value that is NaN. The factor is that of units, such
    as 1000 from mm to µm.

    >>> (
    ...     _value_with_stated_uncertainty(66.6168, 0.0753, 1.0),
    ...     _value_with_stated_uncertainty(1.6725e-4, math.nan, 1e3),
    ...     _value_with_stated_uncertainty(66.6168, 0.0, 1.0),
    ...     _value_with_stated_uncertainty(0.0020574905, 9.4e-8, 1.0),
    ... )
    ('66.62 ± 0.08', '0.16725, no estimate', '66.617', '0.00205749 ± 9e−08')
    """
    if math.isnan(value):
        return "–"
    # `minus`: with a real minus sign
    plain_text = minus(f"{factor * value:.5g}")
    if uncertainty is None or uncertainty <= _EXACT_SHARE * abs(value):
        return plain_text
    if math.isnan(uncertainty):
        return f"{plain_text}, no estimate"
    return with_uncertainty(factor * value, factor * uncertainty)


def cells_of_first_table(
    comparison: JudgedPair,
    label: Literal["label", "short"] = "label",
    *,
    with_empty_rows: bool = True,
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The table of the values of reference and result, such as dissipation and largest pressure, as
    column heads and rows of cells: label, both values, difference, verdict.

    `label` chooses long or short labels. Rows for which neither solution has a value are left out
    unless `with_empty_rows`.
    """
    # a row: texts by key, such as "label", "reference" (its value in words)
    heads, rows = first_table(comparison)
    rows_of_cells = []
    for row in rows:
        if is_empty_row(row) and not with_empty_rows:
            continue
        shown_keys = (label, "reference", "result", "difference", "verdict")
        rows_of_cells.append(tuple(row[key] for key in shown_keys))
    return heads, rows_of_cells


def is_empty_row(row: Mapping[str, str]) -> bool:
    """Whether a row of the first table has neither a value of a solution nor a difference."""
    return row["reference"] == row["result"] == row["difference"] == "–"


def sentences_on_missing_values(comparison: JudgedPair) -> str:
    """Sentences that name the rows of the first table in which a value is missing: those for which
    neither solution has one, then those for which one solution has none. Each row has its reason
    where that is known. Empty where no value is missing.
    """
    labels_without_values = []
    labels_with_one_value = []
    # a row: texts by key; a dash where there is no number; "short": label with unit in brackets
    _, rows = first_table(comparison)
    for row in rows:
        reason = f" ({row['note']})" if row["note"] else ""
        label_with_reason = row["short"].partition(" [")[0] + reason
        if is_empty_row(row):
            labels_without_values.append(label_with_reason)
        elif "–" in (row["reference"], row["result"]) and row["difference"] == "–":
            labels_with_one_value.append(label_with_reason)
    sentences = []
    if labels_without_values:
        sentences.append(f"Without a value in either: {'; '.join(labels_without_values)}.")
    if labels_with_one_value:
        sentences.append(f"Not compared: {'; '.join(labels_with_one_value)}.")
    return " ".join(sentences)


def _difference_in_words(metric: Metric) -> str:
    """A metric's difference (result − reference) in words with its uncertainty: in per cent of the
    reference's value, or of the half-width a for lengths of the stick zone; in the metric's unit
    where it is absolute. A dash without a value. A value below 1e-13 is written as 0.

    `metric.headline`: whether the metric has an amount in each solution, with a unit of its own.
    """
    if metric.value is None:
        return "–"
    # a metric without amounts states the unit of the difference itself
    if not metric.headline:
        return " ".join(
            filter(
                None, [value_in_words(metric), uncertainty_in_words(metric), unit_in_words(metric)]
            )
        )
    if not math.isfinite(metric.value) or metric.absolute:
        return f"{value_in_words(metric)} {uncertainty_in_words(metric)}".strip()
    percent = 0.0 if abs(metric.value) < _ROUNDING else 100 * metric.value
    uncertainty_in_percent = None if metric.uncertainty is None else 100 * metric.uncertainty
    difference_in_words = with_uncertainty(percent, uncertainty_in_percent)
    if not re.search("[1-9]", difference_in_words.partition("±")[0]):
        difference_in_words = difference_in_words.removeprefix("−")  # of a zero no sign is known
    elif percent > 0:
        difference_in_words = f"+{difference_in_words}"
    return f"{difference_in_words} %{' of a' if metric.unit == 'of a_ref' else ''}"


def summary_text(comparison: JudgedPair) -> str:
    """A comparison as plain text: headline; table of the values of both solutions with columns of
    equal width; verdict.
    """
    heads, table_rows = cells_of_first_table(comparison)  # of text
    column_widths = [max(map(len, column)) for column in zip(heads, *table_rows, strict=True)]
    table_lines = []
    for row in (heads, *table_rows):
        padded_cells = [cell.ljust(width) for cell, width in zip(row, column_widths, strict=True)]
        table_lines.append("  ".join(padded_cells).rstrip())
    head_line, *row_lines = table_lines
    rule = "-" * len(head_line)
    parts = [
        headline_sentence(comparison),
        "",
        head_line,
        rule,
        *row_lines,
        "",
        verdict_in_sentences(comparison),
    ]
    return "\n".join(parts)


def summary_in_five_lines(comparison: JudgedPair, kind: str) -> str:
    """A comparison in five lines, for an interactive session: engines and scene, headline,
    dissipation and largest pressure of both, verdict. `kind` is the name of the object's class,
    such as "Comparison".
    """
    name = comparison.scene.name or comparison.scene.title or "a scene"
    lines = [
        f"{kind} of {comparison.result.engine} with {comparison.reference.engine} on {name!r}",
        f"  {headline_sentence(comparison)}",
    ]
    # a row: label, both values, difference, verdict; `heads` names the columns
    heads, rows = cells_of_first_table(comparison)
    for metric, cells in zip(_metrics_of_first_table(comparison), rows, strict=True):
        if metric.key in ("dissipation", "largest_pressure"):
            label, *values = cells
            heads_and_values = zip(heads[1:], values, strict=True)
            lines.append(f"  {label}: " + ", ".join(map(" ".join, heads_and_values)))
    return "\n".join([*lines, f"  {verdict_in_sentences(comparison)}"])


def summary_csv(comparison: JudgedPair) -> str:
    """The first table of a comparison as CSV, a row for each of its metrics: key, name, unit, value
    of reference and result in that unit with every digit, then the metric's error and its
    uncertainty, and its verdict.

    The error is a share, not in per cent, except where the metric is absolute. A cell is empty
    where there is no number. `headlines` are the metrics with amounts in both solutions.
    """
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(
        ("key", "quantity", "unit", "reference", "result", "error", "uncertainty", "verdict")
    )
    for metric in comparison.headlines:
        factor, unit = factor_and_unit_shown(comparison.scene, metric.quantity)
        shown_amounts = [factor * amount for amount in metric.amounts or (math.nan, math.nan)]
        numbers = [
            "" if number is None or math.isnan(number) else float(number)
            for number in (*shown_amounts, metric.value, metric.uncertainty)
        ]
        writer.writerow((metric.key, metric.label, unit, *numbers, metric.verdict or ""))
    return table.getvalue()


# Signs that LaTeX takes for a command, or that its default fonts lack -> how LaTeX writes them.
_LATEX_OF_SIGN = {
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "±": r"$\pm$",
    "−": r"$-$",
    "·": r"$\cdot$",
    "µ": r"$\mu$",
    "²": r"$^2$",
    "–": "--",
}


def summary_latex(comparison: JudgedPair) -> str:
    """The table of the values of both solutions as a LaTeX `tabular`, with a column for their
    difference and one for the verdict. It needs the LaTeX package booktabs.
    """
    heads, rows = cells_of_first_table(comparison)
    # signs such as & and ±, and the commands by which LaTeX writes them
    command_by_sign = str.maketrans(_LATEX_OF_SIGN)
    latex_rows = [
        " & ".join(cell.translate(command_by_sign) for cell in row) for row in (heads, *rows)
    ]
    heads_row, *value_rows = [rf"{row} \\" for row in latex_rows]
    latex_lines = [
        rf"\begin{{tabular}}{{l{'r' * (len(heads) - 2)}l}}",
        r"\toprule",
        heads_row,
        r"\midrule",
        *value_rows,
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(latex_lines) + "\n"


# ---------------------------------------------------------------------------------- of one solution
def first_summary_rows(solution: ContactSolution) -> list[tuple[str, str]]:
    """The first rows (label with unit, value) of the summary of a solution: engine, termination,
    numbers of instants and points, last loads, largest pressure and half-widths, dissipation.

    Behind a value stands the uncertainty that the solution states of it.
    """
    scene = solution.scene
    _, unit_of_length, unit_of_stress = units(scene)
    last_loads = (
        f"P {solution.normal_load[-1]:.6g}, Q {solution.tangential_load[-1]:.6g} {load_unit(scene)}"
    )
    # values as texts, each with its uncertainty
    half_width_in_words = f"{np.nanmax(solution.contact_half_width):.8g}"
    half_width_in_words += _stated_uncertainty(solution, "largest_half_width")
    dissipation_in_words = _digits_or_none(solution.dissipation) + _uncertainty_of_work(solution)
    return [
        ("engine", engine_in_words(solution.engine)),
        ("how it ended", solution.record.message),
        ("instants, surface points", f"{len(solution.time)}, {len(solution.x)}"),
        ("last instant", f"time {solution.time[-1]:.6g}, {last_loads}"),
        (
            f"largest pressure at the points [{unit_of_stress}]",
            f"{np.max(solution.pressure):.8g}{_stated_uncertainty(solution, 'largest_pressure')}",
        ),
        (f"largest contact half-width [{unit_of_length}]", half_width_in_words),
        *_rows_of_permanent_stick(solution),
        (f"dissipation of the {part_of_path(scene)} [{energy_unit(scene)}]", dissipation_in_words),
    ]


def _rows_of_permanent_stick(solution: ContactSolution) -> Iterator[tuple[str, str]]:
    """Rows (label with unit, value) on the zone that sticks through the whole last cycle of a
    solution: its half-width with the uncertainty that the solution states, "none" without such a
    zone; and both its ends where the contact is unsymmetric.
    """
    _, unit_of_length, _ = units(solution.scene)
    stick_half_width = _digits_or_none(solution.permanent_stick_half_width)
    if math.isfinite(solution.permanent_stick_half_width):
        stick_half_width += _stated_uncertainty(solution, "permanent_stick_half_width")
    yield f"permanent stick half-width [{unit_of_length}]", stick_half_width
    # only an unsymmetric contact has two different ends
    values_of_ends = values_of_unsymmetric(solution)
    if values_of_ends:
        ends = [values_of_ends[f"permanent_stick_{side}"] for side in ("left", "right")]
        yield f"ends of permanent stick [{unit_of_length}]", ", ".join(map(_digits_or_none, ends))


def _uncertainty_of_work(solution: ContactSolution) -> str:
    """The uncertainty that a solution states of its dissipation W, also in per cent, and where it
    comes from, as text to put behind W; empty where it states none, or a relative one below 1e-6.
    """
    work = solution.dissipation
    uncertainty = _stated_uncertainty_of_work(solution)
    if not uncertainty:
        return ""
    is_by_elements = solution.engine == "halfplane_fe"
    source = "by mesh and steps" if is_by_elements else "by its own estimate"
    share_in_words = f" ({uncertainty / abs(work):.2%})" if work else ""
    return f" ± {uncertainty:.2g}{share_in_words}, {source}"


def _stated_uncertainty_of_work(solution: ContactSolution) -> float:
    """Uncertainty that a solution states of its dissipation W [energy per thickness]; 0 where it
    states none, or a relative one below 1e-6.
    """
    work = solution.dissipation
    uncertainty = stated_uncertainty(solution, work, "dissipation", "dissipation")
    if uncertainty is None or not math.isfinite(uncertainty):
        return 0.0
    return uncertainty if uncertainty > _NEGLIGIBLE_ERROR * abs(work) else 0.0


def _stated_uncertainty(solution: ContactSolution, name: str) -> str:
    """The uncertainty that a solution states of the value `name`, as text to put behind the value;
    empty where it states none.
    """
    if name not in solution.uncertainties:
        return ""
    uncertainty = solution.uncertainties[name]
    return f" ± {uncertainty:.2g}" if math.isfinite(uncertainty) else ", no estimate of its error"


def row_of_sliding(solution: ContactSolution) -> tuple[str, str]:
    """A row (label, value): how near the loads of a solution come to gross sliding, as the largest
    |Q|/(f P).
    """
    label = f"largest |Q|/(f P) of the {part_of_path(solution.scene)}, 1 where all slides"
    return label, f"{largest_load_ratio(solution):.4g}"


def summary_rows(
    solution: ContactSolution, *, loads_are_found: bool = False
) -> list[tuple[str, str]]:
    """Rows (label with unit, value) of the summary of a solution: engine, size, largest pressure,
    half-widths and dissipation first; then how the dissipation changes from cycle to cycle, the
    work of the loads, load cycles of measured loads, laws of contact, notes, and what was skipped.

    `loads_are_found`: whether the solver determined the loads, from a prescribed displacement. Then
    a row states how near they come to gross sliding. `solution.loop_work` is the closed integral of
    Q dU, NaN where no cycle closes; `dissipation_drift` the relative change of the dissipation from
    the cycle before.
    """
    rows = first_summary_rows(solution)
    if loads_are_found and solution.scene.friction.coefficient:
        rows.append(row_of_sliding(solution))
    if solution.dissipation_drift and np.isfinite(solution.dissipation_drift):
        drift = f"{solution.dissipation_drift:+.2e} of it"
        rows.append(("dissipation, change from the cycle before", drift))
    if np.isfinite(solution.loop_work):
        rows += _rows_of_loop_work(solution)
    rows += _rows_of_load_cycles(solution)
    rows.append(("laws of contact", _laws_in_words(solution)))
    rows += [("note", note) for note in solution.record.notes]
    # The counts of the engine's work are in its file and on the page.
    return rows + [
        (f"skipped: {name.replace('_', ' ')}", f"{count}: {reason}")
        for name, (count, reason) in solution.work.skipped.items()
    ]


def _rows_of_load_cycles(solution: ContactSolution) -> Iterator[tuple[str, str]]:
    """Rows (label with unit, value) on the load cycles in a table of measured loads: their number,
    the friction work W divided by their number, and W of the last whole cycle where there is one.

    No rows for other loads, for results of other programs, and where the solution does not hold the
    work of each instant.
    """
    # load cycles by rainflow count of Q: `counted` their number, `per_cycle` W divided by it,
    # `last_whole` the last whole one; None in the cases without rows
    cycles = load_cycles(solution)
    if not cycles:
        return
    unit = energy_unit(solution.scene)
    yield "load cycles, by rainflow of Q", f"{cycles.counted:g}"
    yield f"dissipation over their number [{unit}]", f"{cycles.per_cycle:.8g}"
    last_cycle = cycles.last_whole
    if last_cycle is not None:
        times_in_words = f"time {last_cycle.start:.6g} to {last_cycle.end:.6g}"
        label = f"dissipation of the last whole cycle, {times_in_words} [{unit}]"
        yield label, f"{last_cycle.dissipation:.8g}"


def _laws_in_words(solution: ContactSolution) -> str:
    """In words: that all laws of contact hold, or which are violated, by how much and when."""
    # of each law: its name, the largest violation, its instant, whether it is within the limit
    checks = certificates(solution)
    violated_laws = [
        f"{check.label} ({check.value:.1e} at time {check.time:.4g})"
        for check in checks
        if not check.holds
    ]
    if violated_laws:
        return f"violated: {', '.join(violated_laws)}"
    return f"all {len(checks)} hold"


def _rows_of_loop_work(solution: ContactSolution) -> Iterator[tuple[str, str]]:
    """Rows (label with unit, value) of the work that the loads of a solution do in a closed cycle:
    of the tangential load Q and the bulk stress together (`loop_work`), of the bulk stress alone,
    of the normal load P. The last two only where there is such work.

    In the labels U is the tangential displacement, V the approach, m_q the moment of the shear, M
    that of the pressure.
    """
    unit = energy_unit(solution.scene)
    bulk_work = values_of_unsymmetric(solution).get("bulk_work")
    integrand = "(Q dU - m_q d(eps)), eps the bulk strain" if bulk_work else "Q dU"
    yield f"closed integral of {integrand} [{unit}]", f"{solution.loop_work:.10g}"
    if bulk_work:
        yield f"of it by bulk stress [{unit}]", f"{bulk_work:.10g}"
    work_of_p = normal_work(solution)
    if work_of_p is not None:
        integrand_of_p = "P dV" if solution.tilt is None else "P dV - M d(tilt)"
        label = f"closed integral of {integrand_of_p}, V the approach [{unit}]"
        yield label, f"{work_of_p:.10g}"


def _digits_or_none(value: float) -> str:
    """A value with ten digits; "none" where it is NaN."""
    return "none" if np.isnan(value) else f"{value:.10g}"
