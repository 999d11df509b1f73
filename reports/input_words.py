"""Effects of uncertain inputs on the values of a scene, in sentences, rows of tables and JSON;
`reports.inputs` computes the numbers.

Two statements are kept apart: by how much the inputs change the *difference* of the two models, and
how uncertain a *measurement* with these inputs is. Neither is added to the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from reports import validation
from reports.comparison.metrics import JudgedPair
from reports.comparison.words import with_uncertainty
from reports.inputs import (
    PEAK,
    QUANTITIES_OF_THEORY,
    WORK,
    Draws,
    InputEffects,
    NearSliding,
    UncertainValue,
)
from reports.report import Report
from reports.units import energy_unit, load_unit, minus, significant, units
from scenes import Estimate, Scene

# A measurement can show a difference of at least two of its standard uncertainties (95 %).
_FEWEST_SIGMAS_VISIBLE = 2.0
# A second input is named where the change that it makes is at least a quarter of that of the first.
_LEAST_SHARE_OF_NAMED_INPUT = 0.25
_SYMBOL_OR_NAME = {WORK: "W", PEAK: "the largest pressure"}


def stated_in_words(scene: Scene) -> str:
    """A sentence on the standard uncertainties that a scene states of its inputs, and their
    correlations; empty where it states none.

    >>> from scenes import load_scene
    >>> stated_in_words(load_scene("hertz-paper").vary(uncertainty={"friction": "5 %"}))
    'Standard uncertainties of the inputs, as stated: friction 1 ± 5 %; independent of each other.'
    """
    if not scene.inputs:
        return ""
    assert scene.uncertainty is not None
    inputs_in_words = ", ".join(uncertain_input.in_words for uncertain_input in scene.inputs)
    # Coefficient of correlation of each pair of inputs.
    correlated_pairs = [
        f"{first_key} and {second_key} {coefficient:g}"
        for first_key, second_key, coefficient in scene.uncertainty.correlations
    ]
    correlation_in_words = (
        f"correlated: {', '.join(correlated_pairs)}"
        if correlated_pairs
        else "independent of each other"
    )
    return (
        f"Standard uncertainties of the inputs, as stated: {inputs_in_words};"
        f" {correlation_in_words}."
    )


def stated_content(scene: Scene) -> list[dict[str, Any]] | None:
    """The standard uncertainties that a scene states of its inputs, for JSON: relative to the
    value, for a phase in degrees. None where it states none.

    Each of `scene.inputs` has its key, its value, the uncertainty as the scene file states it, and
    as a number.
    """
    rows = [
        {
            "key": uncertain_input.key,
            "value": uncertain_input.value,
            "stated": uncertain_input.stated,
            "standard_uncertainty": uncertain_input.standard_uncertainty,
            "of": "degrees" if uncertain_input.key == "phase_degrees" else "share",
        }
        for uncertain_input in scene.inputs
    ]
    return rows or None


# ------------------------------------------------------------------------------------ in sentences
def sentences(
    effects: InputEffects, scene: Scene, comparison: JudgedPair | None = None
) -> list[str]:
    """The effects of uncertain inputs on the values of a scene, in sentences.

    They state the difference of finite bodies and half-planes, whether a measurement could show it,
    the most important input, the dissipation W by random draws, values that are rough, and notes;
    where none of these is known, the reason.

    Parameters
    ----------
    effects
        `values` of theory and the `difference` of W and of the largest pressure, each by name with
        its uncertainty by the inputs; `draws`: W by random draws, or None; `sliding`: how near the
        loads come to gross sliding; `reason_unknown`: why none of these is known, "" where they are
    scene
        for the units
    comparison
        finite elements compared with theory; without it, or where it has no finite relative
        difference of W, the difference is that of theory corrected by responses of the bodies
    """
    sentence_on_sliding = sliding_in_words(effects.sliding)
    if effects.reason_unknown:
        reason = _with_full_stop(effects.reason_unknown)
        reason_in_words = f"What the inputs make of the answer is not known: {reason}"
        return [*filter(None, [sentence_on_sliding]), reason_in_words]

    # A warning of gross sliding, "" without one; then the other sentences.
    all_sentences = [sentence_on_sliding]
    all_sentences += [
        *_sentence_on_difference(effects, comparison),
        *_sentence_on_measurement(effects, comparison),
    ]
    all_sentences += [_main_input_in_words(effects)]
    if effects.draws is not None:
        all_sentences.append(_draws_in_words(effects.draws, scene))

    # Values whose second-order change by the inputs is large are rough, unless draws give them too.
    drawn_values = effects.draws.values if effects.draws is not None else {}
    # QUANTITIES_OF_THEORY: words for theory's values by name
    words_for_drawn_values = {QUANTITIES_OF_THEORY[name].words for name in drawn_values}
    words_for_rough_values = [
        value.words
        for value in (*effects.values.values(), *effects.difference.values())
        if value.uncertainty > 0
        and not value.is_nearly_linear
        and value.words not in words_for_drawn_values
    ]
    if words_for_rough_values:
        all_sentences.append(
            f"Rough, by derivatives that are not enough: {', '.join(words_for_rough_values)}. There"
            " the second order is above a tenth of the uncertainty."
        )
    all_sentences += [f"{note[:1].upper()}{_with_full_stop(note[1:])}" for note in effects.notes]
    return [sentence for sentence in all_sentences if sentence]


def sentences_of_report(report: Report) -> list[str]:
    """The effects of uncertain inputs on the values of a report, in sentences; empty where the
    scene states no uncertainty.

    For a result that may be measured they state whether it agrees with theory within both
    uncertainties. For any other result they state whether a measurement could show its difference
    from theory.

    `report.inputs` are the uncertainties of theory's values by the inputs, None where none are
    stated. `report.validation` holds values of the result against theory, and `is_measured` says
    whether the result is a measurement.
    """
    effects = report.inputs
    comparison = report.comparison
    if effects is None:
        return []
    if not report.validation:
        return sentences(effects, comparison.scene, comparison)
    all_sentences = validation.sentences(report.validation, is_measured=report.is_measured)
    all_sentences = [
        sliding_in_words(effects.sliding),
        *all_sentences,
        _main_input_in_words(effects),
    ]
    return [sentence for sentence in all_sentences if sentence]


def sliding_in_words(nearness: NearSliding | None) -> str:
    """A sentence that warns where two standard uncertainties of the inputs may make the bodies
    slide as a whole; else empty.

    `nearness.ratio` is the largest |Q|/(f P), `uncertainty` its standard uncertainty, and
    `is_in_reach` whether 1 is within two of them.

    >>> sliding_in_words(NearSliding(0.979, 0.05))
    'Within two standard uncertainties of the inputs |Q| reaches f P, and the bodies slide as a
    whole: the largest |Q|/(f P) is 0.98 ± 0.05.'
    """
    if nearness is None or not nearness.is_in_reach:
        return ""
    return (
        "Within two standard uncertainties of the inputs |Q| reaches f P, and the bodies slide as a"
        " whole: the largest |Q|/(f P) is"
        f" {with_uncertainty(nearness.ratio, nearness.uncertainty)}."
    )


def _with_full_stop(sentence: str) -> str:
    return f"{sentence.rstrip('.')}."


def _sentence_on_difference(effects: InputEffects, comparison: JudgedPair | None) -> Iterator[str]:
    """A sentence on the difference in the dissipation W between finite bodies and half-planes, with
    its uncertainty by the inputs. Where the difference is not known, the sentence states the reason
    if there is a `comparison`, and there is no sentence without one. Nor is there one where W alone
    has no difference.

    Parameters
    ----------
    effects
        `difference` of the models by the name of the value, each with its uncertainty;
        `reason_without_difference`: why there is none, "" where there is one
    comparison
        finite elements compared with theory; None without them. Where it has no finite relative
        difference of W, and where it is None, the difference is that of corrected theory
    """
    if effects.reason_without_difference:
        if comparison is not None:
            yield (
                "How far the inputs move the difference of the two models is not stated:"
                f" {_with_full_stop(effects.reason_without_difference)}"
            )
        return
    # WORK: "dissipation"
    if WORK not in effects.difference:
        return
    uncertain_difference = effects.difference[WORK]
    # Difference of W over W, and a phrase on its source.
    relative_difference, source = _difference_of_work_and_source(uncertain_difference, comparison)
    percent_in_words = with_uncertainty(
        100 * relative_difference, 100 * uncertain_difference.uncertainty
    )
    yield f"With these inputs the difference of W{source} is {percent_in_words} %."


def _difference_of_work_and_source(
    uncertain_difference: UncertainValue, comparison: JudgedPair | None
) -> tuple[float, str]:
    """Relative difference of W between finite bodies and half-planes, and the source of that number
    in words: "" where it is the finite elements, " by corrected theory" where these give no finite
    relative difference.

    `uncertain_difference` is that of corrected theory. `comparison` is that of finite elements with
    theory, None without them; a difference of it is `absolute` where it is not relative.
    """
    # WORK: "dissipation"
    if comparison is not None:
        metric = comparison.metric(WORK)
        if metric.value is not None and not metric.absolute and math.isfinite(metric.value):
            return float(metric.value), ""
    return uncertain_difference.value, " by corrected theory"


def _sentence_on_measurement(effects: InputEffects, comparison: JudgedPair | None) -> Iterator[str]:
    """A sentence on the uncertainty of a measurement of the dissipation W by the scene's inputs,
    and whether such a measurement could tell finite bodies from half-planes. No sentence where it
    is not known.

    Parameters
    ----------
    effects
        `work_uncertainty`: standard uncertainty of W over W by the inputs, NaN where it is not
        known; `difference` of the models by the name of the value
    comparison
        finite elements compared with theory; None without them. Where it has no finite relative
        difference of W, and where it is None, the difference is that of corrected theory
    """
    relative_uncertainty = effects.work_uncertainty
    if not math.isfinite(relative_uncertainty):
        return
    statement = (
        f"A measurement of W with these inputs has ± {significant(100 * relative_uncertainty, 2)} %"
    )
    # WORK: "dissipation"
    if WORK not in effects.difference:
        yield f"{statement}."
        return
    relative_difference, _ = _difference_of_work_and_source(effects.difference[WORK], comparison)
    # Two standard uncertainties: 95 %.
    if abs(relative_difference) >= _FEWEST_SIGMAS_VISIBLE * relative_uncertainty:
        yield f"{statement} and can see it, if it adds less of its own."
    else:
        yield f"{statement} and cannot see it."


def _main_input_in_words(effects: InputEffects) -> str:
    """A sentence that names the input that changes the dissipation W most, and the next one if it
    changes W by at least a quarter of that; for the largest pressure where no input changes W. ""
    where none changes either.

    `effects.values` holds theory's values by name. Each has its `changes` by one standard
    uncertainty of every input, by the key of the input, and the keys of the inputs by the size of
    that change.
    """
    # WORK, PEAK: "dissipation" and "peak_pressure"
    for name_of_value in (WORK, PEAK):
        theory_value = effects.values.get(name_of_value)
        if theory_value is None or not theory_value.keys_by_size_of_change:
            continue
        # Key of an input -> its name.
        input_in_words = {
            uncertain_input.key: uncertain_input.words for uncertain_input in effects.inputs
        }
        first_key, *other_keys = theory_value.keys_by_size_of_change
        size_of_change = {
            input_key: abs(change.value) for input_key, change in theory_value.changes.items()
        }
        name_of_input = input_in_words[first_key]
        statement = f"{name_of_input[:1].upper()}{name_of_input[1:]} matters most"
        if name_of_value != WORK:
            # _SYMBOL_OR_NAME: "the largest pressure"
            statement = f"For {_SYMBOL_OR_NAME[name_of_value]} {name_of_input} matters most"
        # _LEAST_SHARE_OF_NAMED_INPUT: 0.25 of the largest change
        if (
            other_keys
            and size_of_change[other_keys[0]]
            >= _LEAST_SHARE_OF_NAMED_INPUT * size_of_change[first_key]
        ):
            statement += f", then {input_in_words[other_keys[0]]}"
        return f"{statement}."
    return ""


def _draws_in_words(draws: Draws, scene: Scene) -> str:
    """Sentences on the dissipation W by random draws of the inputs: why they were drawn, mean and
    standard deviation of W, and how many draws slide or are impossible.

    `draws.values[WORK]` holds mean, standard deviation and 95 % range of W; `sliding` and
    `impossible` are fractions of the `count` draws. `scene` gives the unit.
    """
    unit = energy_unit(scene)
    # WORK: "dissipation"
    drawn_work = draws.values[WORK]
    mean_in_words = with_uncertainty(drawn_work.mean, drawn_work.uncertainty)
    text = (
        f"{draws.reason[:1].upper()}{draws.reason[1:]}. So W is taken from {draws.count:,} random"
        f" draws of the inputs: {mean_in_words} {unit}. 95 % of them lie from {drawn_work.low:.4g}"
        f" to {drawn_work.high:.4g}."
    )
    if draws.sliding:
        text += (
            f" {significant(100 * draws.sliding, 2)} % of the draws slide as a whole, have no W,"
            " and are in neither mean nor deviation."
        )
    if draws.impossible > 0:
        text += f" {100 * draws.impossible:.2g} % are of inputs that no scene can have."
    return minus(text)


MODELS_ALONE = (
    "Both models have the same inputs, so most of what these do cancels in the difference. What a"
    " measurement is uncertain by is no part of it. Models that agree are not thereby right of a"
    " real contact."
)
"""What must stand beside the two claims."""


# ---------------------------------------------------------------------------------------- in tables
HEADS_OF_THEORY_VALUES = ("Value of theory", "value", "u", "u in %", "most of it")


def rows_of_theory_values(effects: InputEffects, scene: Scene) -> list[tuple[str, ...]]:
    """Rows of the table of half-plane theory's values: name with unit, value, standard uncertainty
    by the inputs of the scene, the same in per cent, and the three inputs that change the value
    most.

    Values from random draws of the inputs come last. `effects.values` holds the values by name,
    each with its `changes` by one standard uncertainty of every input; `effects.draws` is None
    without draws.
    """
    # Key of an input -> its name.
    input_in_words = {
        uncertain_input.key: uncertain_input.words for uncertain_input in effects.inputs
    }
    rows: list[tuple[str, ...]] = []
    for theory_value in effects.values.values():
        unit = _unit_of_value(theory_value, scene)
        changes_in_words = [
            f"{input_in_words[key]} {_in_percent(theory_value.changes[key], theory_value.value)}"
            for key in theory_value.keys_by_size_of_change[:3]
        ]
        rows.append(
            (
                f"{theory_value.words} [{unit}]",
                significant(theory_value.value, 6),
                significant(theory_value.uncertainty, 2),
                significant(100 * theory_value.relative_uncertainty, 2),
                ", ".join(changes_in_words) or "–",
            )
        )
    if effects.draws is not None:
        for name, drawn_value in effects.draws.values.items():
            theory_value = effects.values[name]
            unit = _unit_of_value(theory_value, scene)
            name_with_unit = f"{theory_value.words}, {effects.draws.count:,} draws [{unit}]"
            cells = (significant(drawn_value.mean, 6), significant(drawn_value.uncertainty, 2))
            rows.append(
                (
                    name_with_unit,
                    *cells,
                    significant(100 * drawn_value.relative_uncertainty, 2),
                    "all",
                )
            )
    return rows


HEADS_OF_DIFFERENCE = ("By corrected theory", "%", "u, points", "most of it, points")


def rows_of_difference(effects: InputEffects) -> list[tuple[str, ...]]:
    """Rows of the table of differences between finite bodies and half-planes: name, difference in
    per cent, standard uncertainty by the inputs in percentage points, and the three inputs that
    change the difference most.

    `effects.difference` holds the relative differences by name, each with its `changes` by one
    standard uncertainty of every input.
    """
    # Key of an input -> its name.
    input_in_words = {
        uncertain_input.key: uncertain_input.words for uncertain_input in effects.inputs
    }
    rows: list[tuple[str, ...]] = []
    for difference in effects.difference.values():
        changes_in_words = [
            f"{input_in_words[key]} {significant(100 * abs(difference.changes[key].value), 2)}"
            for key in difference.keys_by_size_of_change[:3]
        ]
        # as many decimals as the uncertainty leaves
        difference_in_words = with_uncertainty(100 * difference.value, 100 * difference.uncertainty)
        percent_in_words = difference_in_words.partition(" ±")[0]
        uncertainty_in_words = significant(100 * difference.uncertainty, 2)
        inputs_in_words = ", ".join(changes_in_words) or "–"
        rows.append((difference.words, percent_in_words, uncertainty_in_words, inputs_in_words))
    return rows


def table_of_inputs(effects: InputEffects) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The table of a scene's uncertain inputs: column heads, and a row for each input.

    A row holds the input, its standard uncertainty as stated, and the change of theory's
    dissipation W by it in per cent. A fourth column holds the change of the difference between
    finite bodies and half-planes, in percentage points, where that is known. The last row holds the
    standard uncertainties by all inputs together.

    `effects.values` and `effects.difference` hold theory's values and the differences by name, each
    with its `changes` by one standard uncertainty of every input.
    """
    heads = ("Input", "as stated", "moves W by %")
    # WORK: "dissipation"
    work = effects.values.get(WORK)
    table: list[tuple[str, ...]] = []
    for uncertain_input in effects.inputs:
        change_in_words = "–"
        if work is not None:
            change_in_words = _signed_ratio_in_words(
                100 * work.changes[uncertain_input.key].value, work.value
            )
        table.append(
            (
                uncertain_input.words.removeprefix("the "),
                f"± {uncertain_input.stated}",
                change_in_words,
            )
        )

    # By all inputs together; `work_uncertainty` is over W, NaN where not known.
    uncertainty_in_words = f"± {significant(100 * effects.work_uncertainty, 2)}"
    table.append(
        ("all inputs", "", uncertainty_in_words if math.isfinite(effects.work_uncertainty) else "–")
    )
    difference = effects.difference.get(WORK)
    if difference is None:
        return heads, table

    # The fourth column.
    changes_in_points = [
        _signed_ratio_in_words(100 * difference.changes[uncertain_input.key].value, 1.0)
        for uncertain_input in effects.inputs
    ]
    changes_in_points.append(f"± {significant(100 * difference.uncertainty, 2)}")
    rows = [(*row, cell) for row, cell in zip(table, changes_in_points, strict=True)]
    return (*heads, "moves the difference by points"), rows


def _unit_of_value(uncertain_value: UncertainValue, scene: Scene) -> str:
    """The unit of a value of theory, in the units of the scene."""
    _, unit_of_length, unit_of_stress = units(scene)
    return {
        "energy": energy_unit(scene),
        "stress": unit_of_stress,
        "length": unit_of_length,
        "load": load_unit(scene),
        "ratio": "1",
    }[uncertain_value.unit]


def _signed_ratio_in_words(change: float, value: float) -> str:
    """A change of a value over the value, in words with a sign; a dash where there is none."""
    if not value or not math.isfinite(change):
        return "–"
    share = change / value
    return f"{'+' if share > 0 else ''}{significant(share, 2)}" if share else "0"


def _in_percent(change: Estimate, value: float) -> str:
    """Size of a change of a value, in per cent of the value."""
    share = abs(change.value / value) if value else math.nan
    return f"{significant(100 * share, 2)} %"


# ------------------------------------------------------------------------------------------ as JSON
def content_of_report(report: Report) -> dict[str, Any] | None:
    """The JSON content on the uncertain inputs of a report; None where the scene states no
    uncertainty. Numbers may be NaN or infinite.

    `report.inputs` are the uncertainties of theory's values by the inputs, `report.validation`
    values of the result against theory.
    """
    content_of_inputs = content(report.inputs, report.comparison.scene, report.comparison)
    if content_of_inputs is None:
        return None
    measurements = {entry.words: entry.content() for entry in report.validation}
    return {
        **content_of_inputs,
        "sentences": sentences_of_report(report),
        "validation": measurements or None,
    }


def content(
    effects: InputEffects | None, scene: Scene, comparison: JudgedPair | None = None
) -> dict[str, Any] | None:
    """The JSON content on the uncertain inputs of a scene; None where `effects` is None, that is
    where the scene states no uncertainty of them.

    It holds the stated uncertainties, sentences, random draws, and how near the loads come to
    sliding. The values of theory and the difference of the models have their uncertainties by the
    inputs. `comparison` is that of finite elements with theory, None where there is none.
    """
    if effects is None:
        return None
    draws = None
    if effects.draws is not None:
        values_of_draws = {
            name: drawn_value._asdict() for name, drawn_value in effects.draws.values.items()
        }
        draws = vars(effects.draws) | {"values": values_of_draws}
    return {
        "stated": stated_content(scene),
        "correlations": [list(entry) for entry in effects.correlations],
        "sentences": sentences(effects, scene, comparison),
        "values": {
            name: _content_of_value(uncertain_value)
            for name, uncertain_value in effects.values.items()
        },
        "difference": {
            name: _content_of_value(uncertain_value)
            for name, uncertain_value in effects.difference.items()
        },
        "no_difference": effects.reason_without_difference or None,
        "draws": draws,
        "sliding": sliding_content(effects.sliding),
        "notes": list(effects.notes),
        "unknown": effects.reason_unknown or None,
    }


def sliding_content(sliding: NearSliding | None) -> dict[str, Any] | None:
    """How near the loads come to gross sliding; None where it is not known."""
    if sliding is None:
        return None
    return {
        "largest_ratio": sliding.ratio,
        "standard_uncertainty": sliding.uncertainty,
        "in_reach": sliding.is_in_reach,
    }


def _content_of_value(uncertain_value: UncertainValue) -> dict[str, Any]:
    """The JSON content of one value with its standard uncertainty by the inputs: the change of the
    value by one standard uncertainty of each input, and the keys of the inputs in the order of the
    size of that change.

    "second_order" is the root of the summed squares of the second-order changes; where it is small,
    the value is "nearly_linear". A value with the unit "share" is a relative difference already.
    """
    changes = {
        key: {"value": change.value, "error": change.uncertainty}
        for key, change in uncertain_value.changes.items()
    }
    return {
        "value": uncertain_value.value,
        "standard_uncertainty": uncertain_value.uncertainty,
        "relative": None
        if uncertain_value.unit == "share"
        else uncertain_value.relative_uncertainty,
        "changes": changes,
        "second_order": uncertain_value.second_order,
        "nearly_linear": uncertain_value.is_nearly_linear,
        "ranking": uncertain_value.keys_by_size_of_change,
    }
