"""What inputs make of an answer, in sentences, rows of tables and JSON; `reports.inputs` has the
numbers.

Two claims stand apart: by how much the inputs move the *difference* of the two models, and by how
much a *measurement* with these inputs is uncertain. Neither is added to the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from reports import validation
from reports.comparison.judged import JudgedPair
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

# A measurement sees a difference of at least this many of its standard uncertainties: 95 %.
_SEEN = 2.0
# A second input is named where it makes at least this share of what the first makes; a third
# likewise of the second.
_NAMED = 0.25
_SYMBOLS = {WORK: "W", PEAK: "the largest pressure"}


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
    """The standard uncertainties that a scene states of its inputs, for JSON: a share of the value,
    or degrees of a phase. None where it states none.
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
    """What uncertain inputs do to the answer of a scene, in sentences: the difference of finite
    bodies and half-planes, what a measurement could see of it, which input matters most, what was
    drawn at random, what is left out.

    Parameters
    ----------
    effects
        values of theory with their uncertainties by the inputs
    comparison
        of finite elements with theory; without it the difference is that of theory corrected by
        responses of the bodies
    """
    sliding = sliding_in_words(effects.sliding)
    if effects.unknown:
        reason_in_words = (
            f"What the inputs make of the answer is not known: {_ended(effects.unknown)}"
        )
        return [*filter(None, [sliding]), reason_in_words]
    all_sentences = [sliding]
    all_sentences += [*_of_difference(effects, comparison), *_of_measurement(effects, comparison)]
    all_sentences += [_matters_most(effects)]
    if effects.draws is not None:
        all_sentences.append(_draws_in_words(effects.draws, scene))
    drawn_values = effects.draws.values if effects.draws is not None else {}
    names_of_drawn = {QUANTITIES_OF_THEORY[key].words for key in drawn_values}
    # values whose second order is large, and that were not taken from draws
    names_of_rough = [
        value.words
        for key, value in (*effects.values.items(), *effects.difference.items())
        if value.uncertainty > 0
        and not value.is_nearly_linear
        and value.words not in names_of_drawn
    ]
    if names_of_rough:
        all_sentences.append(
            f"Rough, by derivatives that are not enough: {', '.join(names_of_rough)}. There the"
            " second order is above a tenth of the uncertainty."
        )
    all_sentences += [f"{note[:1].upper()}{_ended(note[1:])}" for note in effects.notes]
    return [sentence for sentence in all_sentences if sentence]


def sentences_of_report(report: Report) -> list[str]:
    """What uncertain inputs do to the answer of a report, in sentences.

    Empty without stated uncertainties. Beside a result that nobody measured they say which
    differences a measurement could tell from the inputs' uncertainty. Of a result that may be
    measured they say whether it agrees with theory within both uncertainties.
    """
    effects = report.inputs
    comparison = report.comparison
    if effects is None:
        return []
    if not report.validation:
        return sentences(effects, comparison.scene, comparison)
    all_sentences = validation.sentences(report.validation, is_measured=report.is_measured)
    all_sentences = [sliding_in_words(effects.sliding), *all_sentences, _matters_most(effects)]
    return [sentence for sentence in all_sentences if sentence]


def sliding_in_words(sliding: NearSliding | None) -> str:
    """A sentence where two standard uncertainties of the inputs may make the bodies slide as a
    whole; else empty.

    >>> sliding_in_words(NearSliding(0.979, 0.05))
    'Within two standard uncertainties of the inputs |Q| reaches f P, and the bodies slide as a
    whole: the largest |Q|/(f P) is 0.98 ± 0.05.'
    """
    if sliding is None or not sliding.is_in_reach:
        return ""
    return (
        "Within two standard uncertainties of the inputs |Q| reaches f P, and the bodies slide as a"
        f" whole: the largest |Q|/(f P) is {with_uncertainty(sliding.ratio, sliding.uncertainty)}."
    )


def _ended(sentence: str) -> str:
    return f"{sentence.rstrip('.')}."


def _of_difference(effects: InputEffects, comparison: JudgedPair | None) -> Iterator[str]:
    """A sentence on the difference in W between finite bodies and half-planes with the uncertainty
    that the inputs give it, or on why it is not stated.
    """
    if effects.no_difference:
        if comparison is not None:
            yield (
                "How far the inputs move the difference of the two models is not stated:"
                f" {_ended(effects.no_difference)}"
            )
        return
    if WORK not in effects.difference:
        return
    term = effects.difference[WORK]
    relative_difference, source = _difference_of_work(term, comparison)
    amount = with_uncertainty(100 * relative_difference, 100 * term.uncertainty)
    yield f"With these inputs the difference of W{source} is {amount} %."


def _difference_of_work(term: UncertainValue, comparison: JudgedPair | None) -> tuple[float, str]:
    """E of W, and what it is by where that is not the finite elements."""
    if comparison is not None:
        metric = comparison.metric(WORK)
        if metric.value is not None and not metric.absolute and math.isfinite(metric.value):
            return float(metric.value), ""
    return term.value, " by corrected theory"


def _of_measurement(effects: InputEffects, comparison: JudgedPair | None) -> Iterator[str]:
    """A sentence on the uncertainty that the scene's uncertain inputs give to a measurement of W,
    and whether such a measurement could tell finite bodies from half-planes.
    """
    relative_uncertainty = effects.work_uncertainty
    if not math.isfinite(relative_uncertainty):
        return
    amount = (
        f"A measurement of W with these inputs has ± {significant(100 * relative_uncertainty, 2)} %"
    )
    if WORK not in effects.difference:
        yield f"{amount}."
        return
    relative_difference, _ = _difference_of_work(effects.difference[WORK], comparison)
    if abs(relative_difference) >= _SEEN * relative_uncertainty:
        yield f"{amount} and can see it, if it adds less of its own."
    else:
        yield f"{amount} and cannot see it."


def _matters_most(effects: InputEffects) -> str:
    """A sentence on which input changes W most, and which comes next; of the largest pressure where
    nothing is dissipated.
    """
    for key in (WORK, PEAK):
        value = effects.values.get(key)
        if value is None or not value.ranking:
            continue
        input_in_words = {
            uncertain_input.key: uncertain_input.words for uncertain_input in effects.inputs
        }
        first_key, *other_keys = value.ranking
        sizes = {name: abs(change.value) for name, change in value.changes.items()}
        first_words = (
            f"{input_in_words[first_key][:1].upper()}{input_in_words[first_key][1:]} matters most"
        )
        if key != WORK:
            first_words = f"For {_SYMBOLS[key]} {input_in_words[first_key]} matters most"
        if other_keys and sizes[other_keys[0]] >= _NAMED * sizes[first_key]:
            first_words += f", then {input_in_words[other_keys[0]]}"
        return f"{first_words}."
    return ""


def _draws_in_words(draws: Draws, scene: Scene) -> str:
    """Sentences on the work W of random draws of the inputs: why they were drawn, mean and
    deviation, how many slide or are impossible.
    """
    unit = energy_unit(scene)
    work = draws.values[WORK]
    mean_in_words = with_uncertainty(work.mean, work.uncertainty)
    text = (
        f"{draws.reason[:1].upper()}{draws.reason[1:]}. So W is taken from {draws.count:,} random"
        f" draws of the inputs: {mean_in_words} {unit}. 95 % of them lie from {work.low:.4g} to"
        f" {work.high:.4g}."
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
HEADS = ("Value of theory", "value", "u", "u in %", "most of it")


def rows(effects: InputEffects, scene: Scene) -> list[tuple[str, ...]]:
    """Rows of the table of half-plane theory's values: each value, its standard uncertainty by the
    scene's inputs, that in per cent, and the three inputs that make most of it. Values from random
    draws of the inputs come last.
    """
    input_in_words = {
        uncertain_input.key: uncertain_input.words for uncertain_input in effects.inputs
    }
    table: list[tuple[str, ...]] = []
    for value in effects.values.values():
        unit = _unit(value, scene)
        relative_uncertainty = value.relative
        shares = [
            f"{input_in_words[key]} {_in_percent(value.changes[key], value.value)}"
            for key in value.ranking[:3]
        ]
        table.append(
            (
                f"{value.words} [{unit}]",
                significant(value.value, 6),
                significant(value.uncertainty, 2),
                significant(100 * relative_uncertainty, 2),
                ", ".join(shares) or "–",
            )
        )
    if effects.draws is not None:
        for key, drawn_value in effects.draws.values.items():
            value = effects.values[key]
            name = f"{value.words}, {effects.draws.count:,} draws [{_unit(value, scene)}]"
            cells = (significant(drawn_value.mean, 6), significant(drawn_value.uncertainty, 2))
            table.append((name, *cells, significant(100 * drawn_value.relative, 2), "all"))
    return table


HEADS_OF_DIFFERENCE = ("By corrected theory", "%", "u, points", "most of it, points")


def rows_of_difference(effects: InputEffects) -> list[tuple[str, ...]]:
    """Rows of the table of differences between finite bodies and half-planes: size in per cent,
    uncertainty by the scene's inputs in points of per cent, and the three inputs that make most of
    it.
    """
    input_in_words = {
        uncertain_input.key: uncertain_input.words for uncertain_input in effects.inputs
    }
    table: list[tuple[str, ...]] = []
    for value in effects.difference.values():
        shares_of_inputs = [
            f"{input_in_words[key]} {significant(100 * abs(value.changes[key].value), 2)}"
            for key in value.ranking[:3]
        ]
        size_with_uncertainty = with_uncertainty(100 * value.value, 100 * value.uncertainty)
        size_in_words = size_with_uncertainty.partition(" ±")[0]
        points_of_uncertainty = significant(100 * value.uncertainty, 2)
        table.append(
            (value.words, size_in_words, points_of_uncertainty, ", ".join(shares_of_inputs) or "–")
        )
    return table


def table_of_inputs(effects: InputEffects) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The table of a scene's uncertain inputs: heads, and a row for each with its standard
    uncertainty and what that changes of theory's W in per cent. Where it is known, also what it
    changes, in points of per cent, of the difference between finite bodies and half-planes.

    The last row holds the sums, correlations counted.
    """
    heads = ("Input", "as stated", "moves W by %")
    work = effects.values.get(WORK)
    table: list[tuple[str, ...]] = []
    for uncertain_input in effects.inputs:
        change_in_words = "–"
        if work is not None:
            change_in_words = _signed(100 * work.changes[uncertain_input.key].value, work.value)
        table.append(
            (
                uncertain_input.words.removeprefix("the "),
                f"± {uncertain_input.stated}",
                change_in_words,
            )
        )
    uncertainty_in_words = f"± {significant(100 * effects.work_uncertainty, 2)}"
    table.append(
        ("all inputs", "", uncertainty_in_words if math.isfinite(effects.work_uncertainty) else "–")
    )
    difference = effects.difference.get(WORK)
    if difference is None:
        return heads, table
    points = [
        _signed(100 * difference.changes[uncertain_input.key].value, 1.0)
        for uncertain_input in effects.inputs
    ]
    points.append(f"± {significant(100 * difference.uncertainty, 2)}")
    rows = [(*row, cell) for row, cell in zip(table, points, strict=True)]
    return (*heads, "moves the difference by points"), rows


def _unit(value: UncertainValue, scene: Scene) -> str:
    """The unit of a value of theory, in the units of the scene."""
    _, unit_of_length, unit_of_stress = units(scene)
    return {
        "energy": energy_unit(scene),
        "stress": unit_of_stress,
        "length": unit_of_length,
        "load": load_unit(scene),
        "ratio": "1",
    }[value.unit]


def _signed(change: float, value: float) -> str:
    """A change of a value, as a share of it."""
    if not value or not math.isfinite(change):
        return "–"
    share = change / value
    return f"{'+' if share > 0 else ''}{significant(share, 2)}" if share else "0"


def _in_percent(change: Estimate, value: float) -> str:
    share = abs(change.value / value) if value else math.nan
    return f"{significant(100 * share, 2)} %"


# ------------------------------------------------------------------------------------------ as JSON
def content_of_report(report: Report) -> dict[str, Any] | None:
    """All of it by names; None where no uncertainty is stated. Numbers may be not finite."""
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
    """The JSON content on uncertain inputs: what the scene states, sentences, the values of theory
    and the difference of the models with their uncertainties by the inputs, random draws, how near
    the loads come to sliding. None where the scene states no uncertainty of its inputs.
    """
    if effects is None:
        return None
    draws = None
    if effects.draws is not None:
        values_of_draws = {
            key: drawn_value._asdict() for key, drawn_value in effects.draws.values.items()
        }
        draws = vars(effects.draws) | {"values": values_of_draws}
    return {
        "stated": stated_content(scene),
        "correlations": [list(entry) for entry in effects.correlations],
        "sentences": sentences(effects, scene, comparison),
        "values": {key: _content(value) for key, value in effects.values.items()},
        "difference": {key: _content(value) for key, value in effects.difference.items()},
        "no_difference": effects.no_difference or None,
        "draws": draws,
        "sliding": sliding_content(effects.sliding),
        "notes": list(effects.notes),
        "unknown": effects.unknown or None,
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


def _content(value: UncertainValue) -> dict[str, Any]:
    """The JSON content of one value with its standard uncertainty by the inputs: how much one
    standard uncertainty of each input changes it, and the keys of the inputs, those that change it
    most first.
    """
    changes = {
        key: {"value": change.value, "error": change.uncertainty}
        for key, change in value.changes.items()
    }
    return {
        "value": value.value,
        "standard_uncertainty": value.uncertainty,
        "relative": None if value.unit == "share" else value.relative,
        "changes": changes,
        "second_order": value.second_order,
        "nearly_linear": value.is_nearly_linear,
        "ranking": value.ranking,
    }
