"""A measured value against theory or finite elements, with the uncertainty of both (ASME V&V 20).

With S the computed and D the measured value the comparison error and its standard uncertainty are::

    E = S - D,    u_val = sqrt(u_num^2 + u_input^2 + u_D^2)

u_num is that of the numbers themselves, u_input what the stated uncertainties of the inputs make of
S (`reports.inputs`), u_D that of the measurement. The model errs by E, known to within u_val. Where
\\|E\\| is above two of them the error of the model is *resolved*, else it is *hidden*: no less than
nothing, and no more than E and two of them.

A difference of two models at the same inputs has no u_D, and its inputs are common to both: that is
no matter of this module.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.comparison.metrics import JudgedPair
from reports.comparison.words import with_uncertainty
from reports.inputs import PEAK, WORK, InputEffects
from reports.units import significant

if TYPE_CHECKING:
    from reports.scoring.loops import LoopScore
    from reports.scoring.mapping import Measured

RESOLVED = "resolved"
HIDDEN = "hidden"
# Standard uncertainties that an error must exceed: 95 % of a normal distribution.
_COVERAGE_FACTOR = 2.0
_SIGMAS_OF_95_PERCENT = 1.96
# Relative error of the area of a loop of theory by its number of instants.
_RELATIVE_ERROR_OF_AREA = 1e-5
# Metric of an external result -> value whose uncertainty by the inputs is known, and its name.
_INPUT_KEY_AND_WORDS_BY_METRIC = {
    "dissipation": (WORK, "W"),
    "largest_pressure": (PEAK, "the largest pressure"),
    "largest_half_width": ("half_width", "the largest half-width"),
}


@dataclass(frozen=True)
class AgainstMeasurement:
    """A computed value beside a measured one.

    Attributes
    ----------
    words
        what it is, in a sentence
    model
        whose the computed value is
    computed_value, measured_value
        S and D, in one unit
    u_numerical, u_inputs, u_measurement
        u_num, u_input, u_D, in the same unit
    unstated_uncertainties
        what counts as 0 because nobody stated it, in words
    """

    words: str
    model: str
    computed_value: float
    measured_value: float
    u_numerical: float
    u_inputs: float
    u_measurement: float
    unstated_uncertainties: tuple[str, ...] = ()

    @property
    def error(self) -> float:
        """E = S - D."""
        return self.computed_value - self.measured_value

    @property
    def uncertainty(self) -> float:
        """u_val."""
        return math.hypot(self.u_numerical, self.u_inputs, self.u_measurement)

    @property
    def verdict(self) -> str:
        """Whether the error of the model is resolved or hidden.

        >>> AgainstMeasurement("W", "theory", 1.09, 1.0, 0.0, 0.03, 0.04).verdict
        'hidden'
        >>> AgainstMeasurement("W", "theory", 1.11, 1.0, 0.0, 0.03, 0.04).verdict
        'resolved'
        """
        return RESOLVED if abs(self.error) > _COVERAGE_FACTOR * self.uncertainty else HIDDEN

    @property
    def sentence(self) -> str:
        """The difference E = computed − measured value with its uncertainty u_val, in per cent of
        the measured value, what u_val is made of, and the verdict.

        u_val (`uncertainty`) is the root of the summed squares of the standard uncertainties by
        numerics, inputs and measurement. The verdict is "resolved" where the difference exceeds
        twice u_val, else "hidden". `words` and `model` are the names of the value and of the
        computation; `unstated_uncertainties` are those that count as 0.
        """
        percent_per_unit = 100 / abs(self.measured_value) if self.measured_value else math.nan
        amount = with_uncertainty(
            percent_per_unit * self.error, percent_per_unit * self.uncertainty
        )
        parts_of_uncertainty = [
            f"{name} {significant(percent_per_unit * part, 2)} %"
            for name, part in (
                ("numerical", self.u_numerical),
                ("inputs", self.u_inputs),
                ("measurement", self.u_measurement),
            )
        ]
        sentence = (
            f"E of {self.words}, {self.model} minus measured, is {amount} % (u_val of"
            f" {', '.join(parts_of_uncertainty)}): {self.verdict}."
        )
        if self.unstated_uncertainties:
            sentence += f" Not stated, and so taken as 0: {', '.join(self.unstated_uncertainties)}."
        return sentence

    def content(self) -> dict[str, Any]:
        """The comparison with a measurement for JSON: the value by the model, the measured value,
        and `error`, computed minus measured value; the standard uncertainties by numerics, inputs
        and measurement, and that of all three, u_val; the verdict, "resolved" or "hidden".

        `unstated_uncertainties` are those that count as 0, in words.
        """
        return {
            "model": self.model,
            "computed": self.computed_value,
            "measured": self.measured_value,
            "error": self.error,
            "u_num": self.u_numerical,
            "u_input": self.u_inputs,
            "u_D": self.u_measurement,
            "u_val": self.uncertainty,
            "verdict": self.verdict,
            "not_stated": list(self.unstated_uncertainties),
        }


def result_against_theory(
    comparison: JudgedPair, effects: InputEffects | None, measured_uncertainties: Measured
) -> tuple[AgainstMeasurement, ...]:
    """Compare the values of an external result, taken as a measurement, with those of half-plane
    theory: dissipation W, peak pressure and half-width, where both have them.

    Parameters
    ----------
    comparison
        of the result with theory: `metric(key)` is the relative difference of a value (`absolute`
        where it is not relative)
    effects
        uncertainties of theory's values by the scene's inputs, with `reason_unknown` where they are
        not known; None where none are stated. In both cases nothing is compared
    measured_uncertainties
        relative standard uncertainties of the result, as the mapping file states them; those that
        it does not state count as 0

    Returns
    -------
    tuple of AgainstMeasurement
        For each value the computed and the measured one, with the uncertainties by inputs and
        measurement; theory has no numerical one.
    """
    if effects is None or effects.reason_unknown:
        return ()
    entries = []
    # Key of the value in the comparison, its key in theory's values, and its name.
    for key, (name, words) in _INPUT_KEY_AND_WORDS_BY_METRIC.items():
        metric = comparison.metric(key)
        theory_value = effects.values.get(name)
        is_known = metric.value is not None and not metric.absolute and math.isfinite(metric.value)
        if not is_known or theory_value is None or not theory_value.value:
            continue

        # Standard uncertainty over the value, by the inputs; and that of the result, None where not
        # stated.
        # WORK: "dissipation"; of W the uncertainty may come from random draws
        u_by_inputs = (
            effects.work_uncertainty if name == WORK else theory_value.relative_uncertainty
        )
        measured_value = theory_value.value * (1 + float(metric.value or 0.0))
        u_of_result = measured_uncertainties.relative_uncertainty(key)
        entries.append(
            AgainstMeasurement(
                words=words,
                model="theory",
                computed_value=theory_value.value,
                measured_value=measured_value,
                u_numerical=0.0,
                u_inputs=u_by_inputs * theory_value.value,
                u_measurement=(u_of_result or 0.0) * measured_value,
                unstated_uncertainties=("u_D of the result",) if u_of_result is None else (),
            )
        )
    return tuple(entries)


def loop_area_against_models(
    score: LoopScore, effects: InputEffects | None, measured_uncertainties: Measured
) -> tuple[AgainstMeasurement, ...]:
    """Compare the area W of a measured loop of the tangential load Q over the displacement U with
    the areas that theory and finite elements compute with the scene's friction coefficient.

    Parameters
    ----------
    score
        `loops`: the measured loop first, then the loops computed beside it, each with its area
        [energy / thickness]
    effects
        `work_uncertainty`: standard uncertainty of theory's W over W by the scene's inputs, NaN
        where it is not known; None where no uncertainties are stated. In both cases nothing is
        compared
    measured_uncertainties
        relative standard uncertainties of the measurement, as the mapping file states them

    Returns
    -------
    tuple of AgainstMeasurement
        For each model the computed and the measured area, with the uncertainties of both.
    """
    from reports.scoring.loops import WITH_SCENE_FRICTION

    if effects is None or not math.isfinite(effects.work_uncertainty):
        return ()
    measured_loop = score.loops[0]
    # Standard uncertainties of the area by the distance of its points, whose bound is taken as a
    # uniform distribution, and by their scatter, which is stated for 95 %.
    u_by_distance = measured_loop.by_distance / math.sqrt(3)
    # _SIGMAS_OF_95_PERCENT: 1.96 standard deviations
    u_by_scatter = measured_loop.by_noise / _SIGMAS_OF_95_PERCENT
    u_of_rows = math.hypot(u_by_distance, u_by_scatter)
    u_of_rig = measured_uncertainties.relative_uncertainty("dissipation")
    u_of_area = math.hypot(u_of_rows, (u_of_rig or 0.0) * measured_loop.area)
    entries = []
    # loops with the scene's friction; the others have the fitted one, and agree by design
    for computed_loop in score.loops[1:]:
        model, _, friction_in_words = computed_loop.name.partition(", ")
        # WITH_SCENE_FRICTION: words for loops with the scene's friction
        if friction_in_words != WITH_SCENE_FRICTION:
            continue
        unstated_uncertainties = (
            [] if u_of_rig is not None else ["u_D of all but the rows' scatter"]
        )
        # _RELATIVE_ERROR_OF_AREA: 1e-5, by the instants of a loop of theory
        u_of_numerics = _RELATIVE_ERROR_OF_AREA * computed_loop.area
        if model != "theory":
            u_of_numerics = 0.0
            unstated_uncertainties.append(f"u_num of the {model}")
        entries.append(
            AgainstMeasurement(
                words="W",
                model=model,
                computed_value=computed_loop.area,
                measured_value=measured_loop.area,
                u_numerical=u_of_numerics,
                u_inputs=effects.work_uncertainty * computed_loop.area,
                u_measurement=u_of_area,
                unstated_uncertainties=tuple(unstated_uncertainties),
            )
        )
    return tuple(entries)


IF_MEASURED = (
    "If the result is measured, its error against theory stands against the uncertainty of both"
    " (ASME V&V 20)."
)
OF_A_MODEL = (
    "If it is of another code with the same inputs, these are common to both: u_input is no part of"
    " the difference."
)


def sentences(entries: Sequence[AgainstMeasurement], *, is_measured: bool) -> list[str]:
    """Sentences on computed beside measured values; with a reservation where the result may be no
    measurement.
    """
    sentences_of_entries = [entry.sentence for entry in entries]
    if not sentences_of_entries or is_measured:
        return sentences_of_entries
    return [IF_MEASURED, *sentences_of_entries, OF_A_MODEL]
