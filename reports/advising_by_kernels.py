"""How wrong half-plane theory is where theory corrected by elastic responses of the bodies has no
answer: by finite elements of half-planes with the compliance of the bodies added as kernels
(`halfplane_fe.solve(scene, bodies="kernel")`), in some seconds.

That is for pads and cylinders, whose faces are curved; for unlike materials, half-planes among
them; and where tilt and bulk strain are large. Contact solver, increments and elements are those of
the finite elements: it is no check of them.

The uncertainty of a change is what the solve states for the value, over theory's, and what the
kernels leave of finite elements of the bodies, by `benchmarks/curved.py`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from reports.advising_by_numbers import WORK, Change
from reports.comparison.laws import Verdict, verdict_on
from reports.comparison.pairs import has_coupled_tractions
from reports.comparison.why import in_percent
from scenes import ContactSolution, Estimate, FlatRounded, InputError, Scene

# Relative error of values by kernels, against finite elements of the bodies. The largest pressure
# of flat pads has more: it lies next to the end of the flat, where no polynomial follows it.
_RELATIVE_ERROR_OF_KERNELS = 3e-4
_RELATIVE_ERROR_AT_FLANK = 1e-3


@dataclass(frozen=True)
class KernelAdvice:
    """What is expected of finite elements of the bodies of a scene, over half-plane theory.

    Attributes
    ----------
    changes
        quantity -> its change; "dissipation" is the first. The edge tension is among them for flat
        faces alone
    reason_for_kernels
        why theory corrected by responses of the bodies does not answer
    limit
        of |change of the dissipation| up to which theory may be used
    """

    scene: Scene
    changes: dict[str, Change]
    reason_for_kernels: str
    limit: float

    def __repr__(self) -> str:
        """The sentence that `halfplane advise` begins with."""
        return advice_in_words(self)

    @property
    def work(self) -> Estimate:
        """Change of the dissipation."""
        return self.changes[WORK].relative_change

    @property
    def verdict(self) -> Verdict:
        """Of the change of the dissipation on the limit."""
        return verdict_on(self.work.value, self.limit, self.work.uncertainty)


def advise_by_kernels(scene: Scene, limit: float, reason_for_kernels: str) -> KernelAdvice:
    """How far half-plane theory is wrong for the finite bodies of a scene, by finite elements of
    half-planes to which the compliance of the bodies is added as kernels.

    Parameters
    ----------
    scene
        with finite bodies
    limit
        |change of the dissipation| up to which theory may be used
    reason_for_kernels
        why theory corrected by responses of the bodies does not answer; for the sentence

    Raises
    ------
    InputError
        For bodies whose compliance is not known; where theory dissipates nothing.
    InadmissibleLoadError
        For loads with gross sliding or separation.
    ConvergenceError
        Where the finite elements do not converge.
    """
    import halfplane_fe

    theory = _dissipating_theory(scene)  # before anything is solved
    # Quantity -> its name, theory's value, and the relative change with its uncertainty.
    changes = changes_of(halfplane_fe.solve(scene, bodies="kernel"), theory)
    for quantity, change in changes.items():
        estimate = change.relative_change  # solution/theory - 1
        # Kernels err by 3e-4, by 1e-3 in the pressure at the rounded flank of a flat pad.
        error_of_kernels = (
            _RELATIVE_ERROR_AT_FLANK
            if _is_at_flank(scene, quantity)
            else _RELATIVE_ERROR_OF_KERNELS
        )

        # The error is relative to the value of the solution, the uncertainty to that of theory.
        ratio_to_theory = 1 + estimate.value
        uncertainty = estimate.uncertainty + error_of_kernels * ratio_to_theory
        # Estimate: a value with its uncertainty
        changes[quantity] = change._replace(relative_change=Estimate(estimate.value, uncertainty))
    return KernelAdvice(scene, changes, reason_for_kernels, limit)


def _is_at_flank(scene: Scene, quantity: str) -> bool:
    """Whether a quantity is the largest pressure of a pad with a flat, which lies at its rounded
    flank.
    """
    has_flat = scene.bodies.faces_are_true and isinstance(scene.profile, FlatRounded)
    return quantity == "peak_pressure" and has_flat


def changes_of(
    solution: ContactSolution, theory: ContactSolution | None = None
) -> dict[str, Change]:
    """How much the values of a solution of real bodies differ from those of half-plane theory: for
    each quantity its name, theory's value, and the change solution/theory - 1. The uncertainty of
    the change is what the solution states, over theory's value. Both are NaN where theory has no
    value, or 0.

    The solution is by finite elements, or by half-planes with the compliance of the bodies added
    (kernels). Theory is solved where it is not given.

    Raises
    ------
    InputError
        Where theory is not given and dissipates nothing, so that no relative change exists.
    """
    import halfplane_fe
    import semi_analytic

    scene = solution.scene
    theory = theory or _dissipating_theory(scene)
    # Largest values of theory over all places and instants of the last cycle.
    largest_values_of_theory = semi_analytic.extremes(theory, names=("edge_tension",))
    stated_uncertainties = solution.uncertainties  # by name of the solution's value
    last_cycle = solution.last_cycle
    largest_half_width = np.nanmax(solution.contact_half_width[last_cycle])

    # Each change from theory's value, the solution's value and its uncertainty. WORK: "dissipation"
    changes = {
        WORK: _change_from_theory(
            "dissipation",
            theory.dissipation,
            solution.dissipation,
            solution.dissipation_uncertainty,
        ),
        "peak_pressure": _change_from_theory(
            "largest pressure",
            largest_values_of_theory.pressure,
            solution.pressure[last_cycle].max(),
            stated_uncertainties["largest_pressure"],
        ),
        "half_width": _change_from_theory(
            "largest contact half-width",
            largest_values_of_theory.half_width,
            largest_half_width,
            stated_uncertainties["largest_half_width"],
        ),
        "permanent_stick": _change_from_theory(
            "permanent stick half-width",
            theory.permanent_stick_half_width,
            solution.permanent_stick_half_width,
            stated_uncertainties["permanent_stick_half_width"],
        ),
    }

    # The largest edge tension, None for a solution in which it is not known.
    tension = halfplane_fe.largest_edge_tension(solution)
    if tension is not None:
        changes["edge_tension"] = _change_from_theory(
            "largest edge tension",
            largest_values_of_theory.edge_tension,
            tension.value,
            tension.uncertainty,
        )
    return changes


def _dissipating_theory(scene: Scene) -> ContactSolution:
    """Half-plane theory of a scene; InputError where it dissipates nothing."""
    import semi_analytic

    theory = semi_analytic.solve(scene, fields=WORK)
    if not theory.dissipation:
        raise InputError(
            f"{scene.name}: half-plane theory dissipates nothing: no error is relative to it"
        )
    return theory


def _change_from_theory(words: str, theory: float, value: float, uncertainty: float) -> Change:
    """The change value/theory - 1 of the quantity called `words`, with its uncertainty; NaN where
    theory has no value. `uncertainty` is that of `value`.
    """
    if not theory or not math.isfinite(theory):
        return Change(words, theory, Estimate(math.nan, math.nan))
    return Change(words, theory, Estimate(float(value / theory - 1), float(uncertainty / theory)))


def _reason_in_few_words(advice: KernelAdvice) -> str:
    """Why theory corrected by responses of the bodies does not answer, in a few words."""
    if advice.scene.bodies.faces_are_true:
        return "their faces are curved"
    if has_coupled_tractions(advice.scene):
        return "their materials are unlike"
    return advice.reason_for_kernels


def advice_in_words(advice: KernelAdvice) -> str:
    """The advice in sentences: by how much half-plane theory is expected to err in the dissipation,
    whether that is within the limit, and what to do.

    `advice.work` is the relative change of the dissipation with its uncertainty, `verdict` that on
    the `limit` of its size.
    """
    change = advice.work
    first_sentence = (
        f"Half-plane theory is expected to err by {in_percent(change.value)}"
        f" ± {in_percent(change.uncertainty).lstrip('+')} % in the dissipation"
        " (finite elements/theory − 1), by the kernel solve of the bodies:"
        f" {_reason_in_few_words(advice)}."
    )

    # `Verdict`: within the limit, outside, or undecided by its uncertainty.
    limit_in_words = f"the limit of {100 * advice.limit:g} %"
    if advice.verdict is Verdict.WITHIN:
        return f"{first_sentence} That is within {limit_in_words}: theory may be used."
    if advice.verdict is Verdict.UNDECIDED:
        return (
            f"{first_sentence} Whether it is within {limit_in_words} is undecided: solve it"
            " (`halfplane run`)."
        )
    return f"{first_sentence} It is outside {limit_in_words}: solve the scene (`halfplane run`)."
