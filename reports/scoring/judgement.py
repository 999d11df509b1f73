"""The order of evidence: the pressure is explained first, since between like bodies friction does
not touch it; then the shear, given what explains the pressure.

A cause of `causes.CAUSES`, its size fitted, predicts the tractions of a result with just this
fault. It explains the difference where

- it leaves less than a third of it, noise from point to point set aside;
- the gain is more than chance would give (F test);
- the sum of the pressures does not contradict it;
- no other cause does as well: of two that the file does not distinguish neither is named.

Pairs of causes are tried where no single one leaves noise alone.

# notation: p pressure, q shear
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from halfplane_fe.dundurs import dundurs
from reports.scoring.causes import (
    CAUSES,
    COUPLING,
    ODD_PART,
    OFFSET,
    OTHER_TIMES,
    SHEAR_FACTOR,
    SMALL_BODY,
    SOFT_NORMAL,
    Cause,
)
from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy
from reports.scoring.fits import (
    LARGEST_PROBABILITY_BY_CHANCE,
    LARGEST_SHARE_LEFT,
    ROUND_OFF_SQUARE,
    Fit,
    Search,
    explains_difference,
    leaves_clearly_more,
    probability_by_chance,
    share_of_difference_left,
)

# Of the norm of the difference, what a cause leaves where nothing else needs to be looked for
# beside it.
_LARGEST_SHARE_LEFT_IF_COMPLETE = 0.03
# What a cause may leave of the pressure where nothing explains the shear.
_LARGEST_SHARE_LEFT_OF_PRESSURE = 0.1
# Squares of the norm by which a pair must leave less than a single cause.
_LARGEST_SQUARE_RATIO_OF_PAIR = 1 / 4
# Share by which the sum of the pressures must follow a factor of the loads.
_SHARE_OF_FACTOR_IN_SUM = 1 / 3
# Over P, by which nodal forces may differ from it: they add up to P on any mesh, but for noise.
_LARGEST_ERROR_OF_SUM = 0.05
# A fitted factor this near to 1 is the error of a mesh, and no fault; so is a delay of so much of a
# radian, here as a share of a period.
_LEAST_SIZE_OF_FAULT = 0.005
_LEAST_DELAY = _LEAST_SIZE_OF_FAULT / (2 * np.pi)
# Share of the difference that a cause alone must not exceed for pairs with it to be tried.
_LEAST_SHARE_LEFT_WITHOUT_HELP = 0.98
# Values in contact of which neighbours do not tell noise from what two causes at once make.
_FEWEST_VALUES_THAT_SHOW_NOISE = 40
# Faults of the model: bodies of finite size, faces with a soft layer. Their theory takes longest.
_MODEL_FAULTS = (SMALL_BODY, SOFT_NORMAL)
# Of the square of the difference, what a cause leaves that is exact.
_LARGEST_SQUARE_RATIO_IF_EXACT = 1e-6
# Explanations of the pressure that the shear decides between.
_MOST_FITS_OF_PRESSURE = 5
# Dundurs' beta of like bodies, but for round-off.
NEGLIGIBLE_BETA = 1e-9
# What the odd part of the difference may leave of it where bodies couple: 0.09 to 0.53 of the norm
# was measured for nu = 0.45 and 0.2 beside 0.3.
_LARGEST_SHARE_LEFT_BY_ODD_PART = 0.6


@dataclass(frozen=True, eq=False)
class Attribution:
    """The causes to which a discrepancy is attributed.

    Attributes
    ----------
    fit
        the causes that are named; None if none is
    rivals
        other explanations that the file does not distinguish from it
    is_shear_unexplained
        whether the causes explain the pressure alone, and the shear differs for another reason
    """

    fit: Fit | None
    rivals: tuple[Fit, ...] = ()
    is_shear_unexplained: bool = False


@dataclass(frozen=True, eq=False)
class Judgement:
    """Decides which known faults (causes) explain the difference between a result and its
    reference.

    Attributes
    ----------
    discrepancy
        what is to be explained
    search
        the fits of causes to it
    reason_by_cause
        key of a cause -> what in the result excludes it, in words; filled while causes are tried
    """

    discrepancy: Discrepancy
    search: Search
    reason_by_cause: dict[str, str] = field(default_factory=dict)

    @property
    def components(self) -> tuple[int, ...]:
        """Numbers of the tractions that count: pressure, and shear where the file has one."""
        return (PRESSURE, SHEAR) if self.discrepancy.has_shear else (PRESSURE,)

    @property
    def fit_without_causes(self) -> Fit:
        """The fit without any cause, which leaves the whole difference."""
        fit = self.search.best_fit((), self.components)
        assert fit is not None
        return fit

    def attribution(self) -> Attribution:
        """Which known faults (causes) explain the difference of a result from the reference, first
        in the pressure, then in the shear.

        Of several explanations the one that leaves least of the difference is named; of those that
        leave as little but for chance, the one with the fewest causes. Those that the file does not
        distinguish from it are its rivals. An explanation is a fit: causes (with `keys`), their
        fitted sizes (`n_parameters` in number), and the mean square of the difference that it
        leaves.

        # notation: Q tangential load
        """
        pressure_fits = self._fits_of_pressure()
        explanations_of_both: list[Fit] = []
        fits_of_pressure_alone: list[Fit] = []
        # fits with causes of the shear added, else those of the pressure alone
        for pressure_fit in pressure_fits:
            fits_of_both = self._fits_with_shear(pressure_fit)
            explanations_of_both += fits_of_both
            if not fits_of_both:
                fits_of_pressure_alone += self._explanations_of_pressure_alone(pressure_fit)
        # finite bodies in place of a wrong modulus
        if not explanations_of_both:
            explanations_of_both += self._explanations_with_small_body(fits_of_pressure_alone)
        # all sizes fitted to pressure and shear at once
        explanations_of_both += self._joint_fits(pressure_fits, explanations_of_both)
        candidates = explanations_of_both or fits_of_pressure_alone
        if not candidates:
            return Attribution(None)

        # components: pressure, and shear where the file has one
        fit_that_leaves_least = min(candidates, key=lambda fit: fit.mean_square(self.components))
        best_fit = min(candidates, key=lambda fit: self._sort_key(fit, fit_that_leaves_least))
        # A cause that needs a size to do what another does without is no rival: a tilt of a
        # parabola is an offset of just that size, half a cycle late is the other sign of Q.
        rivals = tuple(
            fit
            for fit in candidates
            if fit.keys != best_fit.keys
            and not self._leaves_clearly_more(fit, best_fit)
            and fit.n_parameters <= best_fit.n_parameters
        )
        return Attribution(best_fit, rivals, is_shear_unexplained=not explanations_of_both)

    def _sort_key(self, fit: Fit, least_fit: Fit) -> tuple[bool, int, int, float]:
        """Key to sort fits of causes (known faults) by, the best first: whether the fit leaves
        clearly more of the difference than `least_fit`, its number of causes, number of fitted
        sizes, mean square of the difference that it leaves.
        """
        leaves_clearly_more = self._leaves_clearly_more(fit, least_fit)
        return (
            leaves_clearly_more,
            len(fit.causes),
            fit.n_parameters,
            fit.mean_square(self.components),
        )

    def _explanations_of_pressure_alone(self, pressure_fit: Fit) -> list[Fit]:
        """The fit of the causes (known faults) that explain the pressure, in a list. They are named
        though the shear differs for a reason that is not found. The fit is to pressure and shear,
        at the sizes that the causes have in `pressure_fit`. It is `pressure_fit` itself where the
        shear has no theory.

        Empty without causes. Empty too where they leave more than a tenth of the difference in
        pressure (norm, without noise), and more than noise.
        """
        if not pressure_fit.causes:
            return []
        # tractions predicted with these causes; components: pressure, and shear where the file has
        # one
        fit = self.search.best_fit(
            pressure_fit.causes, self.components, known_sizes=pressure_fit.sizes
        )
        if fit is None:  # with these causes the contact slides: the shear has no theory
            return [pressure_fit]
        # norm of what the causes leave over that of the whole difference, without noise
        share_of_pressure_left = share_of_difference_left(
            pressure_fit, self.fit_without_causes, (PRESSURE,)
        )
        is_explained = (
            share_of_pressure_left <= _LARGEST_SHARE_LEFT_OF_PRESSURE
            or self.is_traction_explained(pressure_fit, PRESSURE)
        )
        return [fit] if is_explained else []

    def _explanations_with_small_body(self, pressure_fits: Sequence[Fit]) -> list[Fit]:
        """Explanations of the difference in pressure and shear by bodies that are too small. They
        are tried in place of a wrong modulus E* where that explains the pressure (among
        `pressure_fits`) but not the shear. Empty where it does not.

        Under a constant P a rigid base that is near changes the pressure as another radius does.

        # notation: P normal load
        """
        # "stiffness": key of a wrong factor of E*
        fits_with_modulus = [fit for fit in pressure_fits if "stiffness" in fit.keys]
        if not fits_with_modulus:
            return []
        # all causes but those that change the width of contact
        causes = (SMALL_BODY, *_without_width_causes(fits_with_modulus[0]))
        explanations = []
        # fits of these causes that explain the pressure, then with causes of the shear added
        for fit_of_pressure in self._explanations([causes], self.fit_without_causes, (PRESSURE,)):
            explanations += self._fits_with_shear(fit_of_pressure)
        return explanations

    def _joint_fits(self, pressure_fits: Sequence[Fit], explanations: Sequence[Fit]) -> list[Fit]:
        """Fits of pressure and shear at once that replace, in the best explanation, the causes of
        the pressure by those of each fit of the pressure; all sizes are fitted again. A cause is a
        known fault, such as a wrong friction coefficient.

        Sizes that were fitted to a noisy pressure alone may be too far off for the shear to decide
        between the explanations. Empty where the best explanation is exact.

        Parameters
        ----------
        pressure_fits
            fits of causes to the pressure, the best first
        explanations
            fits of causes to pressure and shear
        """
        if not explanations or len(pressure_fits) < 2 or not self.discrepancy.has_shear:
            return []
        # mean_square: of the difference that a fit leaves; components: pressure, and shear
        best_explanation = min(explanations, key=lambda fit: fit.mean_square(self.components))
        # exact: it leaves less than a millionth of the mean square of the whole difference
        if best_explanation.mean_square(
            self.components
        ) <= _LARGEST_SQUARE_RATIO_IF_EXACT * self.fit_without_causes.mean_square(self.components):
            return []
        # fits of the pressure whose causes are all in the best explanation
        pressure_fits_of_best = [fit for fit in pressure_fits if fit.keys <= best_explanation.keys]
        if not pressure_fits_of_best:
            return []
        # the causes of the pressure come first in an explanation, then those of the shear
        n_causes_of_pressure = len(pressure_fits_of_best[0].causes)
        joint_fits = []
        for pressure_fit in pressure_fits:
            causes = (*pressure_fit.causes, *best_explanation.causes[n_causes_of_pressure:])
            sizes = (*pressure_fit.sizes, *best_explanation.sizes[n_causes_of_pressure:])
            # no two causes of one group, none twice
            if not _may_occur_together(causes):
                continue
            # least squares from these sizes on
            fit = self.search.refined_fit(causes, sizes, self.components)
            # excluded: by the integrals of pressure and shear, or by sizes that are next to none
            if fit is None or not self._is_not_excluded(
                fit, self.fit_without_causes, self.components
            ):
                continue
            # less than a third of the difference is left, and not by chance
            if explains_difference(fit, self.fit_without_causes, self.components):
                joint_fits.append(fit)
        return joint_fits

    # ------------------------------------------------------------------------------ the pressure
    def _fits_of_pressure(self) -> list[Fit]:
        """Explanations of the difference between the result's pressure and the reference's by one
        or two causes (known faults), the best first: at most five that leave as little. It is the
        fit without a cause where the pressure is right, or where nothing explains it.

        Single causes are tried first, pairs only where no single cause is enough. A pair must do
        better than the best single cause, and need both of its own. Finite bodies and soft layers
        (`_MODEL_FAULTS`) take long to predict: they are tried beside the best of the others.
        """
        fit_without_causes = self.fit_without_causes
        if self.is_traction_explained(
            fit_without_causes, PRESSURE
        ) and self.discrepancy.is_within_tolerance(PRESSURE):
            return [fit_without_causes]
        # CAUSES: all known faults; component: the traction that shows a cause
        causes_of_pressure = [cause for cause in CAUSES if cause.component == PRESSURE]
        quick_causes = [cause for cause in causes_of_pressure if cause not in _MODEL_FAULTS]
        # fits that leave less than a third of the difference, and not by chance
        single_fits = self._explanations_of_pressure([(cause,) for cause in quick_causes])
        # a single cause leaves noise alone
        if self._needs_no_pair(single_fits):
            return self._fits_near_best(single_fits) or [fit_without_causes]
        fits_of_pairs = self._explanations_of_pressure(
            self._pairs_worth_trying(single_fits, quick_causes)
        )
        # A single cause may be refused since few values show no more than chance. A pair must do
        # better than that cause even so.
        best_single_fit = self._best_single_fit(quick_causes)
        if best_single_fit is not None:
            # less of the pressure difference is left, by more than chance
            fits_of_pairs = [
                fit for fit in fits_of_pairs if self._leaves_less(fit, best_single_fit, (PRESSURE,))
            ]
        # neither cause of a pair does as well alone
        fits_of_pairs = [fit for fit in fits_of_pairs if self._needs_both_causes(fit)]
        return self._fits_near_best(fits_of_pairs or single_fits) or [fit_without_causes]

    def _needs_no_pair(self, single_fits: Sequence[Fit]) -> bool:
        """Whether one cause (known fault) of the pressure difference, or none, explains it so well
        that pairs of causes need not be tried: it leaves noise alone. With fewer than 40 values,
        which may look like noise by chance, at most 3 % of the difference (norm) may be left.

        `single_fits` are the fits of one cause, the best first.
        """
        if not single_fits:
            best_fit = self.fit_without_causes
            is_pressure_explained = best_fit.is_noise((PRESSURE,))
        else:
            best_fit = single_fits[0]
            is_pressure_explained = self.is_traction_explained(best_fit, PRESSURE)
        # n_values: number of values in contact; share: norm of what the fit leaves over the norm of
        # the whole difference
        is_nearly_all_explained = (
            share_of_difference_left(best_fit, self.fit_without_causes, (PRESSURE,))
            <= _LARGEST_SHARE_LEFT_IF_COMPLETE
        )
        return is_pressure_explained and (
            is_nearly_all_explained
            or best_fit.n_values((PRESSURE,)) >= _FEWEST_VALUES_THAT_SHOW_NOISE
        )

    def _explanations_of_pressure(self, combinations: Sequence[tuple[Cause, ...]]) -> list[Fit]:
        """Fits of the `combinations` of causes (known faults) that explain the difference in
        pressure, the best first; among them fits of small bodies and soft layers, which take the
        place of the best factor of E*, loads or x.
        """
        fits = self._explanations(combinations, self.fit_without_causes, (PRESSURE,))
        fits += self._explanations(
            self._combinations_with_model_fault(fits), self.fit_without_causes, (PRESSURE,)
        )
        return sorted(fits, key=lambda fit: fit.mean_square((PRESSURE,)))

    def _pairs_worth_trying(
        self, single_fits: Sequence[Fit], quick_causes: Sequence[Cause]
    ) -> list[tuple[Cause, ...]]:
        """Pairs of causes (known faults) that are worth a fit to the difference in pressure, and
        may occur together.

        They are any two of which each alone leaves less of the difference than no cause; the one of
        these that leaves least with any other; and a cause without a size (a sign, a swap) with any
        other, since beside such a cause no other one helps alone.

        Parameters
        ----------
        single_fits
            fits of one cause that explain the pressure
        quick_causes
            causes that are quick to predict
        """
        helpful_causes = [
            cause for cause in quick_causes if self._reduces_pressure_difference(cause)
        ]
        pairs = list(itertools.combinations(helpful_causes, 2))
        if helpful_causes:
            # share of the pressure difference that a cause leaves when fitted alone
            best_cause = min(helpful_causes, key=self._share_left_by_cause)
            pairs += [(best_cause, cause) for cause in quick_causes if cause not in helpful_causes]
        for fit in single_fits:
            if not fit.causes[0].has_size:
                pairs += [(fit.causes[0], cause) for cause in quick_causes if cause.has_size]
        return [pair for pair in dict.fromkeys(pairs) if _may_occur_together(pair)]

    def _reduces_pressure_difference(self, cause: Cause) -> bool:
        """Whether a cause (known fault) alone leaves less than 98 % of the pressure difference, so
        that pairs with it are worth their time. Nodal forces ("coarse_edge") do not where another
        fault is larger: they count wherever they can be fitted.
        """
        if cause.key == "coarse_edge":
            return self.search.best_fit((cause,), (PRESSURE,)) is not None
        return self._share_left_by_cause(cause) < _LEAST_SHARE_LEFT_WITHOUT_HELP

    def _share_left_by_cause(self, cause: Cause) -> float:
        """Share of the difference in pressure (norm, without noise) that one cause (known fault)
        leaves when fitted alone; infinite where theory has no solution with it.
        """
        fit = self.search.best_fit((cause,), (PRESSURE,))
        return (
            np.inf
            if fit is None
            else share_of_difference_left(fit, self.fit_without_causes, (PRESSURE,))
        )

    def _best_single_fit(self, causes: Sequence[Cause]) -> Fit | None:
        """The fit of one cause (known fault) that leaves least of the pressure difference, of the
        `causes` tried, whether or not chance could do as much. None where each leaves a third or
        more.
        """
        possible_fits = []
        for cause in causes:
            # None where theory has no solution with the cause
            fit = self.search.best_fit((cause,), (PRESSURE,))
            # the integral of the pressure excludes the cause
            if fit is None or self._sum_of_pressures_contradicts(fit):
                continue
            if (
                share_of_difference_left(fit, self.fit_without_causes, (PRESSURE,))
                < LARGEST_SHARE_LEFT
            ):
                possible_fits.append(fit)
        # mean square of the difference that a fit leaves
        return min(possible_fits, key=lambda fit: fit.mean_square((PRESSURE,)), default=None)

    def _needs_both_causes(self, pair: Fit) -> bool:
        """Whether a fit of two causes (`pair`) leaves less of the pressure difference than either
        cause alone.
        """
        fits_alone = [self.search.best_fit((cause,), (PRESSURE,)) for cause in pair.causes]
        return all(fit is None or self._leaves_less(pair, fit, (PRESSURE,)) for fit in fits_alone)

    def _combinations_with_model_fault(self, fits: Sequence[Fit]) -> list[tuple[Cause, ...]]:
        """Combinations of causes (known faults) to try next: a fault of the model in place of the
        cause of a wrong width of contact. Such causes are wrong factors of E*, loads or x; faults
        of the model are finite bodies, and faces with a soft layer. Both change the width alike.

        `fits` are the fits tried before. Without any, each fault of the model is tried alone. Empty
        where no fit changes the width, where the best that does leaves less than a millionth of the
        mean square of the whole difference, or where there is no fit and the difference is noise.

        # notation: E* composite modulus
        """
        if not fits:
            is_noise = self.fit_without_causes.is_noise((PRESSURE,))
            return [] if is_noise else [(cause,) for cause in _MODEL_FAULTS]
        # group "size": causes that change the width of contact
        fits_with_other_width = [
            fit for fit in fits if any(cause.group == "size" for cause in fit.causes)
        ]
        if not fits_with_other_width:
            return []
        best_fit = min(fits_with_other_width, key=lambda fit: fit.mean_square((PRESSURE,)))
        # mean square of what the fit leaves, over that of the whole difference
        if best_fit.mean_square(
            (PRESSURE,)
        ) <= _LARGEST_SQUARE_RATIO_IF_EXACT * self.fit_without_causes.mean_square((PRESSURE,)):
            return []
        return [(cause, *_without_width_causes(best_fit)) for cause in _MODEL_FAULTS]

    def _fits_near_best(self, fits: Sequence[Fit]) -> list[Fit]:
        """Of fits with the best first, the few that leave as little of the pressure as that one."""
        near_fits = [
            fit for fit in fits if not self._leaves_clearly_more(fit, fits[0], (PRESSURE,))
        ]
        return near_fits[:_MOST_FITS_OF_PRESSURE]

    def _explanations(
        self,
        combinations: Iterable[tuple[Cause, ...]],
        fit_before: Fit,
        components: tuple[int, ...],
    ) -> list[Fit]:
        """Try combinations of causes (known faults, such as a wrong friction coefficient): the fits
        that explain what `fit_before` leaves of the difference between result and theory.

        A fit explains it if less than a third is left, and not by chance. Fits that the integrals
        of pressure and shear exclude are left out, and those with sizes of next to nothing.

        Parameters
        ----------
        combinations
            of the causes
        fit_before
            fit of fewer causes, or of none
        components
            the tractions that count: pressure, shear or both
        """
        explanations = []
        for causes in combinations:
            # least squares over the sizes of these causes; None without a solution of theory
            fit = self.search.best_fit(causes, components)
            if fit is None or not self._is_not_excluded(fit, fit_before, components):
                continue
            # less than a third of what fit_before leaves, and not by chance
            if explains_difference(fit, fit_before, components):
                explanations.append(fit)
        return explanations

    # ------------------------------------------------------------------ what integrals exclude
    def _is_not_excluded(self, fit: Fit, fit_before: Fit, components: Sequence[int]) -> bool:
        """Whether nothing excludes a fit of causes (known faults): neither the integral of the
        pressure over x, nor that of the shear, nor fitted sizes that are next to none. `fit_before`
        is a fit of fewer causes.
        """
        if self._has_cause_without_change(fit, fit_before, components):
            return False
        # a wrong factor of all shear tractions
        if SHEAR_FACTOR in fit.causes and not self._is_factor_of_shear(fit, fit_before):
            return False
        return not self._sum_of_pressures_contradicts(fit)

    def _has_cause_without_change(
        self, fit: Fit, fit_before: Fit, components: Sequence[int]
    ) -> bool:
        """Whether a cause (known fault) in a fit has a fitted size next to 0, so that it explains
        nothing: the difference may then be the error of a mesh. It has not where, next to 0 as it
        is, it leaves less than 3 % of the difference (norm) that is left without it.

        Next to 0 is below 0.005, and below 0.005/(2 pi) of a period for a delay. The size of a
        factor is its logarithm; that of an offset does not count. `fit_before` is a fit of fewer
        causes.
        """
        for cause, size in zip(fit.causes, fit.sizes, strict=True):
            least_size = _LEAST_DELAY if cause is OTHER_TIMES else _LEAST_SIZE_OF_FAULT
            if not cause.has_size or cause is OFFSET or abs(size) >= least_size:
                continue
            fit_without_cause: Fit | None = fit_before
            if cause not in fit_before.causes:
                other_causes = tuple(other for other in fit.causes if other is not cause)
                fit_without_cause = self.search.best_fit(
                    other_causes, tuple(components), known_sizes=fit_before.sizes
                )
            share_left = share_of_difference_left(fit, fit_without_cause or fit_before, components)
            if share_left > _LARGEST_SHARE_LEFT_IF_COMPLETE:
                return True
        return False

    def _is_factor_of_shear(self, fit: Fit, fit_before: Fit) -> bool:
        """Whether the shear tractions of a result are right but for one constant factor, as a fit
        of likely causes has it.

        Two things are required. Less than a tenth of the difference in shear is left. And the
        integrals of the shear over x follow the fitted factor, to a third of its difference from 1.
        Another coefficient of friction would leave these integrals as they are; another Q would
        move the edges of stick.

        Parameters
        ----------
        fit
            fit of the result with this factor among the causes
        fit_before
            fit with the causes known before, whose difference from the result is the measure

        # notation: Q tangential load
        """
        # _LARGEST_SHARE_LEFT_OF_PRESSURE: a tenth, here of the shear
        if share_of_difference_left(fit, fit_before, (SHEAR,)) > _LARGEST_SHARE_LEFT_OF_PRESSURE:
            return False
        # (k, n) weight of each of k instants and n points in the integrals
        weight_of_points = self.discrepancy.weight
        # integrals of the shear over x, one for each instant
        shear_integrals = np.sum(
            weight_of_points * self.discrepancy.result_tractions[SHEAR], axis=1
        )
        predicted_shear_integrals = np.sum(
            weight_of_points * fit.predicted_tractions[SHEAR], axis=1
        )
        square_of_predicted = float(predicted_shear_integrals @ predicted_shear_integrals)
        if not square_of_predicted:
            return False
        # the size of a factor is its logarithm; the ratio is that of least squares
        factor = float(np.exp(fit.sizes[fit.causes.index(SHEAR_FACTOR)]))
        ratio = float(shear_integrals @ predicted_shear_integrals) / square_of_predicted
        return abs(ratio - 1) <= _SHARE_OF_FACTOR_IN_SUM * abs(factor - 1)

    def _sum_of_pressures_contradicts(self, fit: Fit) -> bool:
        """Whether the sum of the result's pressures over x excludes the causes (known faults) of a
        fit.

        A wrong factor of loads, pressures or x multiplies this sum by a known ratio, which
        `resultant_factor` of the cause computes from its fitted size; None where a cause leaves the
        sum. Such a cause is excluded where the sum remains near P. Nodal forces instead of
        pressures ("coarse_edge") add up to P: they are excluded where the sum is not P. The reason
        is kept in `reason_by_cause`.

        # notation: P normal load
        """
        predicted_ratios = [
            cause.resultant_factor(size)
            for cause, size in zip(fit.causes, fit.sizes, strict=True)
            if cause.resultant_factor is not None
        ]
        if "other_times" in fit.keys:  # P of another instant: the sum has no known value
            return False
        # that sum over P
        measured_ratio = self.discrepancy.resultant_ratio
        reason = f"the sum of the pressures is {measured_ratio:.4g} P"
        # the sum differs from P by more than 5 %
        is_sum_wrong = abs(measured_ratio - 1) > _LARGEST_ERROR_OF_SUM
        if "coarse_edge" in fit.keys and not predicted_ratios and is_sum_wrong:
            self.reason_by_cause["coarse_edge"] = reason
            return True
        # of two ratios the sum shows only the product
        if len(predicted_ratios) != 1 or not np.isfinite(measured_ratio):
            return False
        # the sum follows the predicted ratio by at least a third of its difference from 1
        if abs(measured_ratio - 1) > _SHARE_OF_FACTOR_IN_SUM * abs(predicted_ratios[0] - 1):
            return False
        if len(fit.causes) == 1:
            self.reason_by_cause[fit.causes[0].key] = reason
        return True

    # --------------------------------------------------------------------------------- the shear
    def fit_of_shear_factor(self) -> Fit | None:
        """The fit of a wrong factor of the shear alone; None where it leaves more than noise."""
        fits = self._explanations_of_shear([(SHEAR_FACTOR,)], self.fit_without_causes)
        return fits[0] if fits and self.is_traction_explained(fits[0], SHEAR) else None

    def _fits_with_shear(self, pressure_fit: Fit) -> list[Fit]:
        """Fits of causes (known faults) to pressure and shear, the best first, that begin with a
        fit to the pressure alone; its causes keep the sizes fitted there. Empty where nothing
        explains the shear.

        Tried in turn: no further cause, one of the shear, coupling by unlike bodies, and two of the
        shear; the first that leaves noise alone ends it.
        """
        if not self.discrepancy.has_shear:
            return [pressure_fit] if pressure_fit.causes else []
        # the causes of the pressure alone, now fitted beside the shear
        fit_before = self.search.best_fit(
            pressure_fit.causes, (PRESSURE, SHEAR), known_sizes=pressure_fit.sizes
        )
        if fit_before is None:
            return []
        # noise alone is left, or next to nothing
        if self.is_traction_explained(fit_before, SHEAR):
            return [fit_before] if fit_before.causes else []
        # fits with one cause of the shear added
        explanations = self._explanations_by_shear_causes(fit_before, 1)
        if self._is_shear_explained(explanations):
            return explanations
        if len(fit_before.causes) < 2:
            # unlike materials: the normal pressure moves the faces tangentially
            coupled_fit = self._coupled_fit(explanations[0] if explanations else fit_before)
            if coupled_fit is not None:
                return [coupled_fit]
        # Two causes of the shear are looked for only where the pressure is right without any: where
        # it is wrong and unexplained, the shear, which friction ties to it, says little.
        if not fit_before.causes and self.is_traction_explained(pressure_fit, PRESSURE):
            fits_of_pairs = self._explanations_by_shear_causes(fit_before, 2)
            if explanations:
                fits_of_pairs = [
                    fit
                    for fit in fits_of_pairs
                    if self._leaves_less(fit, explanations[0], (SHEAR,))
                ]
            explanations = fits_of_pairs or explanations
        return explanations

    def _is_shear_explained(self, explanations: Sequence[Fit]) -> bool:
        """Whether the best of them leaves noise alone."""
        return bool(explanations) and self.is_traction_explained(explanations[0], SHEAR)

    def _explanations_by_shear_causes(self, fit_before: Fit, count: int) -> list[Fit]:
        """Fits that explain the difference in shear by `count` causes (known faults) beside those
        of `fit_before`, which explain the pressure; the best first. Empty where that makes more
        than two causes.
        """
        if len(fit_before.causes) + count > 2:
            return []
        # causes of the pressure that may show in the shear alone: other instants, nodal forces
        # CAUSES: all known faults; component: the traction that shows a cause
        possible_causes = [
            cause
            for cause in CAUSES
            # coupling by unlike materials is tried apart from these
            if (cause.component == SHEAR and cause.key != COUPLING.key)
            or cause.key in ("other_times", "coarse_edge")
        ]
        # no two causes of one group may meet
        combinations = [
            (*fit_before.causes, *chosen_causes)
            for chosen_causes in itertools.combinations(possible_causes, count)
        ]
        return self._explanations_of_shear(filter(_may_occur_together, combinations), fit_before)

    def _coupled_fit(self, fit_before: Fit) -> Fit | None:
        """The fit in which unlike materials couple shear and pressure, beside the causes (known
        faults) of `fit_before`. None unless most of the difference in shear that these leave is odd
        in x, as that of a coupling is.

        Where the scene's own materials are unlike, theory is known to lack the coupling, and the
        odd part itself is the explanation.
        """
        if len(fit_before.causes) > 1:
            return None
        # ODD_PART: a stand-in that takes over the odd part of the result's shear
        odd_fit = self.search.best_fit(
            (*fit_before.causes, ODD_PART), self.components, known_sizes=fit_before.sizes
        )
        # most: the norm that is left must be at most 0.6 of that before
        if (
            odd_fit is None
            or share_of_difference_left(odd_fit, fit_before, (SHEAR,))
            > _LARGEST_SHARE_LEFT_BY_ODD_PART
        ):
            return None
        # Dundurs' beta, 0 for like materials; the odd part must not be by chance (1e-6)
        if abs(dundurs(self.discrepancy.comparison.scene.material).beta) > NEGLIGIBLE_BETA:
            return (
                odd_fit
                if probability_by_chance(odd_fit, fit_before, (SHEAR,))
                < LARGEST_PROBABILITY_BY_CHANCE
                else None
            )
        # COUPLING: unlike materials, whose size is Dundurs' beta
        fits = self._explanations_of_shear([(*fit_before.causes, COUPLING)], fit_before)
        return fits[0] if fits else None

    def _explanations_of_shear(
        self, combinations: Iterable[tuple[Cause, ...]], fit_before: Fit
    ) -> list[Fit]:
        """Try `combinations` of causes (known faults): the fits that explain what `fit_before`
        leaves of the difference in shear, the best first.

        A fit counts where its mean square difference of the pressure is at most twice that of
        `fit_before`: causes of the shear hardly touch the pressure. The first causes of each
        combination are those of `fit_before`, and keep their sizes.
        """
        explanations = []
        for causes in combinations:
            fit = self.search.best_fit(causes, (PRESSURE, SHEAR), known_sizes=fit_before.sizes)
            # integrals of pressure and shear, and sizes that are next to none, exclude a fit
            if fit is None or not self._is_not_excluded(fit, fit_before, (SHEAR,)):
                continue
            # ROUND_OFF_SQUARE: 1e-20
            keeps_pressure = (
                fit.mean_square((PRESSURE,))
                <= 2 * fit_before.mean_square((PRESSURE,)) + ROUND_OFF_SQUARE
            )
            # less than a third of the shear difference is left, and not by chance
            if keeps_pressure and explains_difference(fit, fit_before, (SHEAR,)):
                explanations.append(fit)
        return sorted(explanations, key=lambda fit: fit.mean_square((SHEAR,)))

    # -------------------------------------------------------------------------------- comparison
    def is_traction_explained(self, fit: Fit, component: int) -> bool:
        """Whether a fit of causes (known faults) leaves nothing of a traction but noise, or next to
        nothing: 3 % of the difference (norm), and of the traction. `component` is PRESSURE or
        SHEAR. Without a cause it also does where the difference is within the tolerance of the
        scene.

        # notation: f coefficient of friction, p_ref scale of pressure
        """
        if fit.is_noise((component,)):
            if component == PRESSURE:
                return True
            # A shear that scatters too much beside the pressure holds more than noise. Mean squares
            # are over p_ref or f p_ref; largest_noise_ratio: of shear noise to pressure noise.
            pressure_square = max(fit.mean_square((PRESSURE,)), ROUND_OFF_SQUARE)
            if fit.mean_square((SHEAR,)) <= pressure_square * fit.largest_noise_ratio**2:
                return True
        if not fit.causes:
            return self.discrepancy.is_within_tolerance(component)
        # With a factor of units the difference is far larger than the tractions: what is left must
        # be small beside both.
        mean_square_left = fit.mean_square((component,)) - fit.mean_square_of_noise((component,))
        no_tractions = 0 * fit.predicted_tractions
        # the result minus nothing: its traction itself
        mean_square_of_traction = self.discrepancy.residual(no_tractions, component).mean_square
        return (
            share_of_difference_left(fit, self.fit_without_causes, (component,))
            <= _LARGEST_SHARE_LEFT_IF_COMPLETE
            and mean_square_left <= _LARGEST_SHARE_LEFT_IF_COMPLETE**2 * mean_square_of_traction
        )

    def are_tractions_explained(self, fit: Fit) -> bool:
        """Whether a fit leaves nothing of either traction but noise."""
        return all(self.is_traction_explained(fit, component) for component in self.components)

    def _leaves_less(
        self, fit: Fit, simple_fit: Fit, components: Sequence[int] | None = None
    ) -> bool:
        """Whether `fit` leaves less of the difference between result and reference than
        `simple_fit`. Where it has more causes (known faults), they must be called for: less than a
        quarter of the mean square is left, or `simple_fit` leaves more than noise; and not by
        chance.

        Pressure, and shear where the file has one, count where `components` is None.
        """
        compared_components = self.components if components is None else components
        # mean square of the difference that each leaves
        mean_square_of_fit = fit.mean_square(compared_components)
        mean_square_of_simple = simple_fit.mean_square(compared_components)
        if len(fit.causes) <= len(simple_fit.causes):
            return mean_square_of_fit < mean_square_of_simple
        is_large_gain = mean_square_of_fit <= _LARGEST_SQUARE_RATIO_OF_PAIR * mean_square_of_simple
        is_significant = (
            probability_by_chance(fit, simple_fit, compared_components)
            < LARGEST_PROBABILITY_BY_CHANCE
        )
        return is_significant and (is_large_gain or not simple_fit.is_noise(compared_components))

    def _leaves_clearly_more(
        self, fit: Fit, best_fit: Fit, components: Sequence[int] | None = None
    ) -> bool:
        """Whether `fit` leaves so much more of the difference between result and reference than
        `best_fit` that it is no rival of it. Pressure, and shear where the file has one, count
        where `components` is None.
        """
        compared_components = self.components if components is None else components
        # mean squares that the fits leave, and number of values in contact
        return leaves_clearly_more(
            fit.mean_square(compared_components),
            best_fit.mean_square(compared_components),
            best_fit.n_values(compared_components),
            is_noise=best_fit.is_noise(compared_components),
        )


def _without_width_causes(fit: Fit) -> tuple[Cause, ...]:
    """The causes of a fit without those that change the width of contact (group "size")."""
    return tuple(cause for cause in fit.causes if cause.group != "size")


def _may_occur_together(causes: tuple[Cause, ...]) -> bool:
    """Whether causes may occur together: no two of them are of one group, or the same."""
    groups = [cause.group for cause in causes if cause.group]
    keys = [cause.key for cause in causes]
    return len(set(groups)) == len(groups) and len(set(keys)) == len(keys)
