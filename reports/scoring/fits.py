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
from reports.scoring.traces import NOISIER
from reports.scoring.variants import Predictions, Variant
from scenes import InputError
from scenes.array_types import Array

# Of the norm of the difference, what a cause may leave.
MOST_LEFT = 1 / 3
# Probability that chance alone gives the gain of a fit: some thirty causes and forty pairs are
# tried for one file, and one file in a thousand may be named by chance.
CHANCE = 1e-6
_WITHOUT_SIZE = 1e-2
# Of the round-off of one traction over its scale, squared: less is no difference.
ROUND_OFF = 1e-20
# Difference of the sums of squares, over the variance of the noise, below which two causes are not
# told apart: four standard deviations. Without noise: the ratio of both sums.
_APART = 16.0
_APART_EXACT = 4.0
# Calls of one search by Levenberg and Marquardt; a size is found in ten to twenty.
_MOST_CALLS = 40
# Starts from which a size that the shear shows is searched.
_SEARCHES_OF_SHEAR = 2
# Of a size, to which it is found: mistakes of a table are larger; and to which it is found first.
_CLOSE = 1e-6
_ROUGH = 1e-2
# Of the norm of the difference, noise and all: a first search that leaves more is not refined.
_HOPELESS = 0.8
# Of the sizes at which the search for a cause alone starts, every third one beside another cause;
# all of them where they are few.
_STRIDE = 3
_FEW_STARTS = 3
# Of the difference, where a prediction has no solution.
_NO_SOLUTION = 1e20


@dataclass(frozen=True, eq=False)
class Fit:
    """Causes, fitted together.

    Attributes
    ----------
    causes, sizes
        one size each
    predicted
        tractions of a result with just these faults
    residuals
        what they leave of pressure and shear
    noisier
        most that the noise of the shear is of that of the pressure, each over its scale
    """

    causes: tuple[Cause, ...]
    sizes: tuple[float, ...]
    predicted: Tractions
    residuals: tuple[Residual, Residual]
    noisier: float = np.inf

    @property
    def keys(self) -> frozenset[str]:
        """Keys of the causes that are fitted."""
        return frozenset(cause.key for cause in self.causes)

    @property
    def parameters(self) -> int:
        """Sizes that were fitted; an odd part takes half of the values as it finds them."""
        sizes = sum(cause.has_size for cause in self.causes)
        return sizes + (self.count((SHEAR,)) // 2 if ODD_PART in self.causes else 0)

    def square(self, channels: Sequence[int]) -> float:
        """R over some channels, the sum of their means."""
        return sum(self.residuals[channel].square for channel in channels)

    def noise(self, channels: Sequence[int]) -> float:
        """N over some channels; that of the shear is of the size of that of the pressure, both over
        the largest pressure.
        """
        largest_noise = (np.inf, max(self.square((PRESSURE,)), ROUND_OFF) * self.noisier**2)
        return sum(
            min(self.residuals[channel].noise, self.square((channel,)), largest_noise[channel])
            for channel in channels
        )

    def is_noise(self, channels: Sequence[int]) -> bool:
        """Whether it leaves nothing smooth."""
        parts = [self.residuals[channel] for channel in channels]
        return all(part.is_noise or part.square <= ROUND_OFF for part in parts)

    def count(self, channels: Sequence[int]) -> int:
        """Values in contact."""
        return sum(self.residuals[channel].count for channel in channels)


@dataclass(frozen=True, eq=False)
class Search:
    """Fits of causes to a discrepancy, each done once."""

    discrepancy: Discrepancy
    predictions: Predictions
    fit_by_question: dict[object, Fit | None] = field(default_factory=dict)

    def fit(
        self,
        causes: tuple[Cause, ...],
        channels: tuple[int, ...],
        known_sizes: tuple[float, ...] = (),
    ) -> Fit | None:
        """Fit the sizes of some causes (known faults) to the difference in these channels
        (pressure, shear), each fit done once.

        `known_sizes` are sizes of the first causes, found before and kept. None where the file
        can't have the causes, or theory has no solution for them.
        """
        key = tuple(CAUSES.index(cause) for cause in causes), channels, known_sizes
        if key not in self.fit_by_question:
            self.fit_by_question[key] = self._fitted(causes, channels, known_sizes)
        return self.fit_by_question[key]

    def _fitted(
        self, causes: tuple[Cause, ...], channels: tuple[int, ...], known_sizes: tuple[float, ...]
    ) -> Fit | None:
        """Fit the sizes of some causes (known faults of a result, such as a wrong friction
        coefficient) to its difference from the reference. Each combination of starting sizes is
        tried, and the best are refined by least squares. None where theory has no solution for any.

        Parameters
        ----------
        channels
            the tractions that are fitted: pressure, shear or both
        known_sizes
            sizes of the first causes, which are kept
        """
        searched_causes = causes[len(known_sizes) :]
        starts_of_causes: list[tuple[float, ...]] = [(size,) for size in known_sizes]
        starts_of_causes += [
            self._starts(cause, searched_causes, channels) for cause in searched_causes
        ]
        if not all(starts_of_causes):
            return None
        trial_sizes = list(itertools.product(*starts_of_causes))
        squares = [self._square(causes, sizes, channels) for sizes in trial_sizes]
        trials_by_square = np.argsort(squares, kind="stable")
        if squares[trials_by_square[0]] >= _NO_SOLUTION**2:
            return None
        sizes = trial_sizes[trials_by_square[0]]
        fitted_indices = [
            index
            for index, cause in enumerate(causes)
            if cause.has_size and index >= len(known_sizes)
        ]
        if fitted_indices:
            # Few points know of an edge of slip only when it passes them: a search may stop early.
            count = _SEARCHES_OF_SHEAR if SHEAR in channels else 1
            rough_fits = [
                self._least_squares(causes, trial_sizes[trial], fitted_indices, channels, _ROUGH)
                for trial in trials_by_square[:count]
                if squares[trial] < _NO_SOLUTION**2
            ]
            sizes = min(rough_fits, key=lambda trial: self._square(causes, trial, channels))
            square_without = self._square((), (), channels)
            if self._square(causes, sizes, channels) <= _HOPELESS**2 * square_without:
                sizes = self._least_squares(causes, sizes, fitted_indices, channels, _CLOSE)
        return self._fit_of(causes, sizes, channels)

    def refined(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Fit | None:
        """All sizes fitted at once, from these on."""
        fitted_places = [place for place, cause in enumerate(causes) if cause.has_size]
        if fitted_places:
            sizes = self._least_squares(causes, sizes, fitted_places, channels, _CLOSE)
        return self._fit_of(causes, sizes, channels)

    def _starts(
        self, cause: Cause, searched_causes: tuple[Cause, ...], channels: tuple[int, ...]
    ) -> tuple[float, ...]:
        """Sizes of a cause (a known fault) from which a search starts. Where it is searched beside
        other causes (`searched_causes`), the size that it has when fitted alone is among them.
        `channels` are the tractions that are fitted. Empty where the result can't have this fault.
        """
        starts = tuple(cause.starts(self.discrepancy))
        if len(searched_causes) == 1 or not starts or not cause.has_size:
            return starts
        fit_alone = self.fit((cause,), channels)
        if fit_alone is None:
            return starts[:1]
        if SHEAR in channels:
            return (*starts[::_STRIDE], fit_alone.sizes[0])
        return (fit_alone.sizes[0],) if len(starts) > _FEW_STARTS else (*starts, fit_alone.sizes[0])

    def _least_squares(
        self,
        causes: tuple[Cause, ...],
        sizes: tuple[float, ...],
        fitted_indices: Sequence[int],
        channels: tuple[int, ...],
        tolerance: float,
    ) -> tuple[float, ...]:
        """Sizes of the causes that leave the least squares in the tractions `channels`, from
        `sizes` on; only the sizes at `fitted_indices` change. `tolerance` is that of the search.
        """
        from scipy.optimize import least_squares

        def all_sizes(values: Array) -> tuple[float, ...]:
            trial = list(sizes)
            for index, value in zip(fitted_indices, values, strict=True):
                trial[index] = float(value)
            return tuple(trial)

        solution = least_squares(
            lambda values: self._residuals(causes, all_sizes(values), channels),
            [sizes[index] for index in fitted_indices],
            method="lm",
            diff_step=1e-5,
            xtol=tolerance,
            ftol=tolerance,
            x_scale=np.full(len(fitted_indices), 0.1),
            max_nfev=_MOST_CALLS,
        )
        return all_sizes(solution.x)

    def _square(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> float:
        """Sum of the squares of the weighted residuals."""
        return float(np.sum(self._residuals(causes, sizes, channels) ** 2))

    def _residuals(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Array:
        """Differences between the result and what a result with these faults (`causes`) of these
        sizes would be, in the tractions `channels`, weighted and in one row, (n,). Large numbers
        where theory has no solution.
        """
        size = self.discrepancy.weight.size
        try:
            predicted_values = self._predicted(causes, sizes, channels)
        except InputError:  # gross sliding, separation, a size that means nothing
            return np.full(size * len(channels), _NO_SOLUTION)
        weight = np.sqrt(self.discrepancy.weight)
        parts = [
            weight
            * (self.discrepancy.result_tractions[channel] - predicted_values[channel])
            / self.discrepancy.units[channel]
            for channel in channels
        ]
        return np.nan_to_num(np.concatenate([part.ravel() for part in parts]), nan=_NO_SOLUTION)

    def _predicted(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Tractions:
        """Tractions that a result with these faults (`causes`) of these sizes would have; the shear
        only where it is among `channels`. InputError for a size beyond the range of the search.
        """
        variant = Variant()
        for cause, size in zip(causes, sizes, strict=True):
            if abs(size) > cause.largest_size:
                raise InputError("beyond the range of the search")
            variant = cause.change(variant, size)
        return self.predictions.of(variant, sheared=SHEAR in channels)

    def _fit_of(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Fit | None:
        """The fit of causes (known faults) with given sizes: the tractions that they predict, and
        the residuals that they leave. None where theory has no solution for them. The shear is
        predicted only where it is among `channels`.
        """
        try:
            predicted_values = self._predicted(causes, sizes, channels)
        except InputError:
            return None
        friction = self.discrepancy.comparison.scales.friction
        noisier = NOISIER / friction if friction else np.inf
        return Fit(
            causes, sizes, predicted_values, self.discrepancy.residuals(predicted_values), noisier
        )


def share_left(fit: Fit, fit_before: Fit, channels: Sequence[int]) -> float:
    """Norm of what a fit leaves over that of the difference before it, the noise set aside."""
    return share_of_norm(fit.square(channels), fit_before.square(channels), fit.noise(channels))


def share_of_norm(square_left: float, square_before: float, square_of_noise: float) -> float:
    """Share that is left of a difference, as a ratio of roots: mean squares `square_left` of
    `square_before`, with the mean square of the noise taken from both; 1 where there is no
    difference.
    """
    difference = square_before - square_of_noise
    if difference <= 0:
        return 1.0
    return float(np.sqrt(max(square_left - square_of_noise, 0.0) / difference))


def by_chance(fit: Fit, fit_before: Fit, channels: Sequence[int]) -> float:
    """Probability that noise alone lets a fit gain so much."""
    return gain_by_chance(
        fit.square(channels),
        fit_before.square(channels),
        fit.count(channels),
        sizes=fit.parameters,
        sizes_before=fit_before.parameters,
    )


def gain_by_chance(
    square_left: float, square_before: float, count: int, *, sizes: int, sizes_before: int = 0
) -> float:
    """Probability that noise alone brings the mean square of `count` values from `square_before`
    down to `square_left` when a cause is fitted to them.

    Parameters
    ----------
    sizes, sizes_before
        number of fitted parameters with the cause, and before it

    Notes
    -----
    The F test. A cause without a parameter leaves the share e of the squares of n values by chance
    with a probability of about e^(n/2); there are some ten of them, so that it is counted a
    hundredfold less severely.
    """
    from scipy.stats import f as f_distribution

    gain = square_before - square_left
    if gain <= 0:
        return 1.0
    square_left = max(square_left, 1e-300)
    n_fitted = sizes - sizes_before
    if n_fitted < 1:
        return float((square_left / square_before) ** (count / 2)) * _WITHOUT_SIZE
    degrees_of_freedom = count - sizes
    if degrees_of_freedom < 1:
        return 1.0
    return float(
        f_distribution.sf(
            gain / n_fitted / (square_left / degrees_of_freedom), n_fitted, degrees_of_freedom
        )
    )


def are_apart(left: float, least: float, count: int, *, is_noise: bool) -> bool:
    """Whether one fit leaves so much more than another that it is out.

    `is_noise`: whether the other one leaves noise alone, which tells how far both may differ by
    chance.
    """
    least = max(least, ROUND_OFF)
    if is_noise:
        return (left - least) / least * count > _APART
    return left > _APART_EXACT * least


def explains(
    fit: Fit | None,
    fit_before: Fit,
    channels: Sequence[int],
) -> bool:
    """Whether a fit leaves less than a third of the difference, and not by chance."""
    return (
        fit is not None
        and share_left(fit, fit_before, channels) < MOST_LEFT
        and by_chance(fit, fit_before, channels) < CHANCE
    )
