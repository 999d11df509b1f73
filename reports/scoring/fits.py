"""Fits of causes to a discrepancy: sizes by least squares, what they leave, and whether chance
alone would gain as much.

# notation: p pressure, q shear; mean squares: R of what a fit leaves, D of the difference, N of the
noise
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from reports.scoring.causes import CAUSES, ODD_PART, Cause
from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, Residual, Tractions
from reports.scoring.traces import LARGEST_NOISE_RATIO
from reports.scoring.variants import Predictions, Variant
from scenes import InputError
from scenes.array_types import Array

# Of the norm of the difference, what a cause may leave.
LARGEST_SHARE_LEFT = 1 / 3
# Probability that chance alone gives the gain of a fit: some thirty causes and forty pairs are
# tried for one file, and one file in a thousand may be named by chance.
LARGEST_PROBABILITY_BY_CHANCE = 1e-6
# Of the probability for a cause without a size, see `probability_of_gain`.
_FACTOR_WITHOUT_SIZE = 1e-2
# Of the round-off of one traction over its scale, squared: less is no difference.
ROUND_OFF_SQUARE = 1e-20
# Difference of the sums of squares, over the variance of the noise, below which two causes are not
# told apart: four standard deviations. Without noise: the ratio of both sums.
_LEAST_DIFFERENCE_APART = 16.0
_LEAST_RATIO_APART = 4.0
# Calls of one search by Levenberg and Marquardt; a size is found in ten to twenty.
_MOST_CALLS = 40
# Starts from which a size that the shear shows is searched.
_SEARCHES_OF_SHEAR = 2
# Of a size, to which it is found: mistakes of a table are larger; and to which it is found first.
_FINE_TOLERANCE = 1e-6
_ROUGH_TOLERANCE = 1e-2
# Of the norm of the difference, noise and all: a first search that leaves more is not refined.
_SHARE_LEFT_WITHOUT_HOPE = 0.8
# Of the sizes at which the search for a cause alone starts, every third one beside another cause;
# all of them where they are few.
_STRIDE_OF_STARTS = 3
_MOST_STARTS_TAKEN_WHOLE = 3
# Of the difference, where a prediction has no solution.
_RESIDUAL_WITHOUT_SOLUTION = 1e20


@dataclass(frozen=True, eq=False)
class Fit:
    """Causes (known faults of a result, such as a wrong friction coefficient), fitted together to
    its difference from the reference.

    Attributes
    ----------
    causes, sizes
        the faults, and the size of each
    predicted_tractions
        tractions of a result with just these faults
    residuals
        differences of the result's pressure and shear from them
    largest_noise_ratio
        largest ratio that the noise of the shear has to that of the pressure, each over its scale
    """

    causes: tuple[Cause, ...]
    sizes: tuple[float, ...]
    predicted_tractions: Tractions
    residuals: tuple[Residual, Residual]
    largest_noise_ratio: float = np.inf

    @property
    def keys(self) -> frozenset[str]:
        """Keys of the causes that are fitted."""
        return frozenset(cause.key for cause in self.causes)

    @property
    def n_parameters(self) -> int:
        """Number of fitted sizes; an odd part takes half of the shear values as they are, so that
        each of these counts too.
        """
        n_sizes = sum(cause.has_size for cause in self.causes)
        return n_sizes + (self.n_values((SHEAR,)) // 2 if ODD_PART in self.causes else 0)

    def mean_square(self, components: Sequence[int]) -> float:
        """Mean square of the residuals, over p_ref or f p_ref; the sum of the `components`
        (pressure, shear).
        """
        return sum(self.residuals[component].mean_square for component in components)

    def mean_square_of_noise(self, components: Sequence[int]) -> float:
        """Mean square of the noise in the residuals, result minus prediction over p_ref or f p_ref:
        the sum of the `components` (pressure, shear).

        More than the mean square of the residual is no noise. Noise of the shear is of the size of
        that of the pressure: it counts up to `largest_noise_ratio` times the pressure's residual.

        # notation: f coefficient of friction, p_ref scale of pressure
        """
        pressure_square = max(self.mean_square((PRESSURE,)), ROUND_OFF_SQUARE)
        largest_square_of_noise = (np.inf, pressure_square * self.largest_noise_ratio**2)
        return sum(
            min(
                self.residuals[component].mean_square_of_noise,
                self.mean_square((component,)),
                largest_square_of_noise[component],
            )
            for component in components
        )

    def is_noise(self, components: Sequence[int]) -> bool:
        """Whether the fit leaves nothing but noise or round-off in each of these components
        (pressure, shear).
        """
        residuals = [self.residuals[component] for component in components]
        return all(
            residual.is_noise or residual.mean_square <= ROUND_OFF_SQUARE for residual in residuals
        )

    def n_values(self, components: Sequence[int]) -> int:
        """Number of values in contact, over all instants of these `components` (pressure,
        shear)."""
        return sum(self.residuals[component].n_values for component in components)


@dataclass(frozen=True, eq=False)
class Search:
    """Fits of causes to a discrepancy, each done once.

    Attributes
    ----------
    discrepancy
        the difference that is fitted
    predictions
        tractions of theory with faults in it
    fit_by_key
        the fits done: numbers of the causes, components and known sizes -> fit, see `best_fit`
    """

    discrepancy: Discrepancy
    predictions: Predictions
    fit_by_key: dict[object, Fit | None] = field(default_factory=dict)

    def best_fit(
        self,
        causes: tuple[Cause, ...],
        components: tuple[int, ...],
        known_sizes: tuple[float, ...] = (),
    ) -> Fit | None:
        """The fit of causes (known faults of a result) to its difference from the reference, with
        the residuals that they leave. A fit that was done before is taken from the cache.

        None where the result can't have one of the causes, or theory has no solution for them.

        Parameters
        ----------
        causes
            the faults whose sizes are fitted
        components
            the tractions that are fitted: pressure, shear or both
        known_sizes
            sizes of the first causes, which are kept
        """
        # CAUSES: all known faults, whose numbers stand in the key; fit_by_key: the fits made so far
        key = tuple(CAUSES.index(cause) for cause in causes), components, known_sizes
        if key not in self.fit_by_key:
            self.fit_by_key[key] = self._new_fit(causes, components, known_sizes)
        return self.fit_by_key[key]

    def _new_fit(
        self, causes: tuple[Cause, ...], components: tuple[int, ...], known_sizes: tuple[float, ...]
    ) -> Fit | None:
        """Fit causes (known faults of a result) to its difference from the reference: each
        combination of starting sizes is tried, and the best ones are refined by least squares. The
        first causes keep their `known_sizes`. None where theory has no solution for any
        combination, or the result can't have one of the causes.

        `components` are the tractions that are fitted: pressure, shear or both.
        """
        searched_causes = causes[len(known_sizes) :]
        starts_of_causes: list[tuple[float, ...]] = [(size,) for size in known_sizes]
        starts_of_causes += [
            self._start_sizes(cause, searched_causes, components) for cause in searched_causes
        ]
        if not all(starts_of_causes):
            return None
        # combinations of sizes, the one that leaves least first
        starts = self._solvable_starts(causes, starts_of_causes, components)
        if not starts:
            return None
        sizes = starts[0]
        fitted_indices = [
            index
            for index, cause in enumerate(causes)
            if cause.has_size and index >= len(known_sizes)
        ]
        if fitted_indices:
            # A point shows an edge of slip only when it passes: a search may stop early.
            n_searches = _SEARCHES_OF_SHEAR if SHEAR in components else 1
            sizes = self._refined_sizes(causes, starts[:n_searches], fitted_indices, components)
        return self._fit_with_sizes(causes, sizes, components)

    def _solvable_starts(
        self,
        causes: tuple[Cause, ...],
        starts_of_causes: Sequence[tuple[float, ...]],
        components: tuple[int, ...],
    ) -> list[tuple[float, ...]]:
        """Combinations of starting sizes of causes (known faults) for which theory has a solution,
        in the order of the sum of squares that they leave. `starts_of_causes` has for each cause
        the sizes to start from; `components` are the tractions that are fitted: pressure, shear or
        both.
        """
        combinations = list(itertools.product(*starts_of_causes))
        sums_of_squares = [
            self._sum_of_squares(causes, combination, components) for combination in combinations
        ]
        # a residual of 1e20 stands for no solution
        return [
            combinations[combination_number]
            for combination_number in np.argsort(sums_of_squares, kind="stable")
            if sums_of_squares[combination_number] < _RESIDUAL_WITHOUT_SOLUTION**2
        ]

    def _refined_sizes(
        self,
        causes: tuple[Cause, ...],
        starts: Sequence[tuple[float, ...]],
        fitted_indices: list[int],
        components: tuple[int, ...],
    ) -> tuple[float, ...]:
        """Sizes of causes (known faults) by least squares: roughly (to 1e-2) from each of `starts`,
        then finely (to 1e-6) from the best. A rough fit that leaves more than 0.8 of the norm of
        the difference is not refined.

        `fitted_indices` are those of the causes whose sizes are fitted; `components` are the
        tractions that are fitted: pressure, shear or both.
        """
        rough_sizes = [
            self._least_squares(causes, start, fitted_indices, components, _ROUGH_TOLERANCE)
            for start in starts
        ]
        sizes = min(
            rough_sizes,
            key=lambda trial_sizes: self._sum_of_squares(causes, trial_sizes, components),
        )
        sum_without_causes = self._sum_of_squares((), (), components)
        largest_sum = _SHARE_LEFT_WITHOUT_HOPE**2 * sum_without_causes
        if self._sum_of_squares(causes, sizes, components) <= largest_sum:
            sizes = self._least_squares(causes, sizes, fitted_indices, components, _FINE_TOLERANCE)
        return sizes

    def refined_fit(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], components: tuple[int, ...]
    ) -> Fit | None:
        """The fit of causes (known faults) with all sizes fitted at once, by least squares from
        `sizes` on. None where theory has no solution. `components` are the tractions that are
        fitted: pressure, shear or both.
        """
        fitted_indices = [index for index, cause in enumerate(causes) if cause.has_size]
        if fitted_indices:
            sizes = self._least_squares(causes, sizes, fitted_indices, components, _FINE_TOLERANCE)
        return self._fit_with_sizes(causes, sizes, components)

    def _start_sizes(
        self, cause: Cause, searched_causes: tuple[Cause, ...], components: tuple[int, ...]
    ) -> tuple[float, ...]:
        """Sizes of a cause (a known fault) from which a search starts; empty where the result can't
        have this fault.

        `searched_causes` are all causes of the search, this one included. Where there are several,
        the size that this one has when fitted alone is among the starts; few of its other starts
        remain. `components` are the tractions that are fitted: pressure, shear or both.
        """
        starts = tuple(cause.start_sizes(self.discrepancy))
        if len(searched_causes) == 1 or not starts or not cause.has_size:
            return starts
        fit_alone = self.best_fit((cause,), components)
        if fit_alone is None:
            return starts[:1]
        # beside other causes: the size found alone, with every third of the other starts for the
        # shear; for the pressure with the other starts only where these are three at most
        if SHEAR in components:
            return (*starts[::_STRIDE_OF_STARTS], fit_alone.sizes[0])
        return (
            (fit_alone.sizes[0],)
            if len(starts) > _MOST_STARTS_TAKEN_WHOLE
            else (*starts, fit_alone.sizes[0])
        )

    def _least_squares(
        self,
        causes: tuple[Cause, ...],
        sizes: tuple[float, ...],
        fitted_indices: Sequence[int],
        components: tuple[int, ...],
        tolerance: float,
    ) -> tuple[float, ...]:
        """Sizes of causes (known faults) whose predicted tractions are closest to the result's, by
        least squares; only those at `fitted_indices` differ from `sizes`, where the search starts.

        `components` are the tractions that count: pressure, shear or both. The search ends where a
        step changes sizes or squares by less than the share `tolerance`.

        # notation: f coefficient of friction, p_ref scale of pressure
        """
        from scipy.optimize import least_squares

        def all_sizes(fitted_sizes: Array) -> tuple[float, ...]:
            """Sizes of all causes, those at `fitted_indices` replaced."""
            sizes_with_fitted = list(sizes)
            for index, size in zip(fitted_indices, fitted_sizes, strict=True):
                sizes_with_fitted[index] = float(size)
            return tuple(sizes_with_fitted)

        # residuals: of pressure and shear over p_ref and f p_ref, at all points and instants
        # sizes change by steps of 1e-5 for derivatives, about 0.1 in the search
        solution = least_squares(
            lambda fitted_sizes: self._weighted_residuals(
                causes, all_sizes(fitted_sizes), components
            ),
            [sizes[index] for index in fitted_indices],
            method="lm",
            diff_step=1e-5,
            xtol=tolerance,
            ftol=tolerance,
            x_scale=np.full(len(fitted_indices), 0.1),
            # 40 calls at most
            max_nfev=_MOST_CALLS,
        )
        return all_sizes(solution.x)

    def _sum_of_squares(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], components: tuple[int, ...]
    ) -> float:
        """Sum of the squared and weighted differences between the result and the tractions that
        theory predicts with these faults (`causes`) of these sizes, over p_ref or f p_ref.
        """
        return float(np.sum(self._weighted_residuals(causes, sizes, components) ** 2))

    def _weighted_residuals(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], components: tuple[int, ...]
    ) -> Array:
        """Differences of the result from the tractions that theory predicts with these `causes`
        (known faults) of these sizes. They are over p_ref or f p_ref, times the root of their
        weight; 1e20 where theory has no solution.

        All k instants and n points of each of the `components` (pressure, shear) stand in one row.

        # notation: f coefficient of friction, p_ref scale of pressure
        """
        discrepancy = self.discrepancy
        try:
            predicted_tractions = self._predicted_tractions(causes, sizes, components)
        except InputError:  # gross sliding, separation, a size that means nothing
            n_values = discrepancy.weight.size * len(components)
            return np.full(n_values, _RESIDUAL_WITHOUT_SOLUTION)
        root_of_weight = np.sqrt(discrepancy.weight)
        residuals_of_components = []
        for component in components:
            difference = discrepancy.result_tractions[component] - predicted_tractions[component]
            # traction_units: p_ref for the pressure, f p_ref for the shear
            residual = root_of_weight * difference / discrepancy.traction_units[component]
            residuals_of_components.append(residual.ravel())
        return np.nan_to_num(
            np.concatenate(residuals_of_components), nan=_RESIDUAL_WITHOUT_SOLUTION
        )

    def _predicted_tractions(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], components: tuple[int, ...]
    ) -> Tractions:
        """Tractions (2, k, n) that a result with these faults (`causes`) of these sizes would have.
        The shear is that of the reference where it is not among `components`.

        InputError where theory has no solution, or a size is beyond the `largest_size` of its
        cause.
        """
        # the scene's theory without a fault; each cause puts its fault into it
        variant = Variant()
        for cause, size in zip(causes, sizes, strict=True):
            if abs(size) > cause.largest_size:
                raise InputError("beyond the range of the search")
            variant = cause.changed_variant(variant, size)
        return self.predictions.tractions_of(variant, with_shear=SHEAR in components)

    def _fit_with_sizes(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], components: tuple[int, ...]
    ) -> Fit | None:
        """The fit of causes (known faults) with given sizes: the tractions that they predict, and
        the residuals that they leave. None where theory has no solution for them. The shear is
        predicted only where it is among `components`.

        # notation: f coefficient of friction
        """
        try:
            predicted_tractions = self._predicted_tractions(causes, sizes, components)
        except InputError:
            return None
        # largest ratio of shear noise to pressure noise, each over its scale: 5/f
        friction_coefficient = self.discrepancy.comparison.scales.friction
        return Fit(
            causes,
            sizes,
            predicted_tractions,
            residuals=self.discrepancy.residuals(predicted_tractions),
            largest_noise_ratio=LARGEST_NOISE_RATIO / friction_coefficient
            if friction_coefficient
            else np.inf,
        )


def share_of_difference_left(fit: Fit, fit_before: Fit, components: Sequence[int]) -> float:
    """Share of the difference between result and reference that a fit of known faults leaves: norm
    of its residuals over that of `fit_before`, the noise taken from both; 1 where there is no
    difference. `components` are the tractions that count: pressure, shear or both.
    """
    return share_of_norm(
        fit.mean_square(components),
        fit_before.mean_square(components),
        fit.mean_square_of_noise(components),
    )


def share_of_norm(square_left: float, square_before: float, square_of_noise: float) -> float:
    """Ratio of the norm of a difference after a fit to that before it, from their mean squares
    `square_left` and `square_before`, the noise taken from both; 1 where there is no difference.

    >>> share_of_norm(2.0, 5.0, 1.0)
    0.5
    """
    square_before_without_noise = square_before - square_of_noise
    if square_before_without_noise <= 0:
        return 1.0
    square_left_without_noise = max(square_left - square_of_noise, 0.0)
    return float(np.sqrt(square_left_without_noise / square_before_without_noise))


def probability_by_chance(fit: Fit, fit_before: Fit, components: Sequence[int]) -> float:
    """Probability that noise alone lets a fit of known faults leave so much less of the difference
    between result and reference than `fit_before`, by the F test. `components` are the tractions
    that count: pressure, shear or both.
    """
    return probability_of_gain(
        fit.mean_square(components),
        fit_before.mean_square(components),
        fit.n_values(components),
        n_parameters=fit.n_parameters,
        n_parameters_before=fit_before.n_parameters,
    )


def probability_of_gain(
    square_left: float,
    square_before: float,
    n_values: int,
    *,
    n_parameters: int,
    n_parameters_before: int = 0,
) -> float:
    """Probability that noise alone brings the mean square of n values from `square_before` down to
    `square_left` when a cause (a known fault of a result) is fitted to them: the F test. 1 where it
    does not fall, or where there are no more values than parameters.

    Parameters
    ----------
    square_left, square_before
        mean squares of the difference with the cause, and before it
    n_values
        number of values that are fitted
    n_parameters, n_parameters_before
        number of fitted parameters with the cause, and before it

    Notes
    -----
    A cause without a parameter leaves the share e of the squares of n values by chance with a
    probability of about e^(n/2). There are some ten such causes, so that it counts as a hundredth
    of that.
    """
    from scipy.stats import f as f_distribution

    gain = square_before - square_left
    if gain <= 0:
        return 1.0
    square_left = max(square_left, 1e-300)
    n_added = n_parameters - n_parameters_before
    if n_added < 1:
        return float((square_left / square_before) ** (n_values / 2)) * _FACTOR_WITHOUT_SIZE
    degrees_of_freedom = n_values - n_parameters
    if degrees_of_freedom < 1:
        return 1.0
    ratio_of_variances = gain / n_added / (square_left / degrees_of_freedom)
    return float(f_distribution.sf(ratio_of_variances, n_added, degrees_of_freedom))


def leaves_clearly_more(
    square_left: float, least_square: float, n_values: int, *, is_noise: bool
) -> bool:
    """Whether a fit, which leaves the mean square `square_left` of n values, is no rival of the
    best one, which leaves `least_square`: it leaves four times as much.

    `is_noise` is whether the best one leaves noise alone. Then chance sets how far both may differ:
    the sums of squares by 16 variances of the noise.
    """
    # a mean square below 1e-20 is round-off
    least_square = max(least_square, ROUND_OFF_SQUARE)
    if is_noise:
        return (square_left - least_square) / least_square * n_values > _LEAST_DIFFERENCE_APART
    return square_left > _LEAST_RATIO_APART * least_square


def explains_difference(fit: Fit, fit_before: Fit, components: Sequence[int]) -> bool:
    """Whether a fit of known faults explains the difference that `fit_before` leaves in the
    tractions `components` (pressure, shear): less than a third of its norm is left, and not by
    chance.
    """
    return (
        share_of_difference_left(fit, fit_before, components) < LARGEST_SHARE_LEFT
        and probability_by_chance(fit, fit_before, components) < LARGEST_PROBABILITY_BY_CHANCE
    )
