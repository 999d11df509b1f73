"""Why a result differs from its reference: causes that are shown, or the statement that none was
found.

The order of evidence. The pressure is explained first, since between like bodies friction does not
touch it; then the shear, given what explains the pressure. Each cause of `causes.CAUSES`, fitted by
least squares, predicts the tractions of a result with just this fault. It is a cause where

- it leaves less than a third of the difference, noise from point to point set aside;
- the gain is more than chance would give (F test);
- the sum of the pressures does not contradict it;
- no other cause does as well: of two that the file does not tell apart neither is named.

Pairs of causes are tried where no single one leaves noise alone. Otherwise the finding is "cause
not found", with what is excluded.

# notation: p pressure, q shear; mean squares: R of what a fit leaves, D of the difference, N of the
noise
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from halfplane_fe.dundurs import dundurs
from reports.comparison import Comparison
from reports.scoring.causes import (
    CAUSES,
    COUPLING,
    ODD_PART,
    SMALL_BODY,
    SOFT_NORMAL,
    Cause,
    Predictions,
    Variant,
    round_power,
)
from reports.scoring.discrepancy import (
    PRESSURE,
    SHEAR,
    Discrepancy,
    Residual,
    Tractions,
    discrepancy,
)
from reports.scoring.traces import (
    FAULTS,
    OWN_BODIES,
    UNKNOWN,
    WORDS,
    Diagnosis,
    coarse_edge,
    elastic_slip,
    full_slip,
    long_steps_by_work,
    outliers,
    scatter,
)
from scenes import InputError
from scenes.array_types import Array

# Of the norm of the difference, what a cause may leave; and what it leaves where nothing else needs
# to be looked for beside it.
_MOST_LEFT = 1 / 3
_COMPLETE = 0.03
# What a cause may leave of the pressure where nothing explains the shear.
_ALONE = 0.1
# Probability that chance alone gives the gain of a fit: some thirty causes and forty pairs are
# tried for one file, and one file in a thousand may be named by chance.
_CHANCE = 1e-6
_WITHOUT_SIZE = 1e-2
# Squares of the norm by which a pair must leave less than a single cause.
_PAIR_GAIN = 1 / 4
# Difference of the sums of squares, over the variance of the noise, below which two causes are not
# told apart: four standard deviations. Without noise: the ratio of both sums.
_APART = 16.0
_APART_EXACT = 4.0
# Share by which the sum of the pressures must follow a factor of the loads.
_UNMOVED = 1 / 3
# Over P, by which nodal forces may differ from it: they add up to P on any mesh, but for noise.
_SAME_RESULTANT = 0.05
# A fitted factor this near to 1 is the error of a mesh, and no fault.
_LEAST_SIZE = 0.005
# Calls of one search by Levenberg and Marquardt; a size is found in ten to twenty.
_MOST_CALLS = 40
# Of a size, to which it is found: mistakes of a table are larger; and to which it is found first.
_CLOSE = 1e-6
_ROUGH = 1e-2
# Of the norm of the difference, noise and all: a first search that leaves more is not refined.
_HOPELESS = 0.8
# Of the sizes at which the search for a cause alone starts, every third one beside another cause.
_STRIDE = 3
# Of the difference, where a prediction has no solution.
_NO_SOLUTION = 1e20
# Share of the difference that a cause alone must not exceed for pairs with it to be tried.
_NO_HELP = 0.98
# Values in contact of which neighbours do not tell noise from what two causes at once make.
_FEW_VALUES = 40
# Causes whose theory takes longest.
_OF_MODEL = (SMALL_BODY, SOFT_NORMAL)
# Of the square of the difference, what a cause leaves that is exact.
_EXACT = 1e-6
# Explanations of the pressure that the shear decides between.
_MOST_OF_PRESSURE = 5
_HALF = 0.03
# Elements over the half-width that an engineer should take.
_ENOUGH_ELEMENTS = 10
# Dundurs' beta of like bodies, but for round-off.
_NO_COUPLING = 1e-9
# What the odd part of the difference may leave of it where bodies couple: 0.09 to 0.53 of the norm
# was measured for nu = 0.45 and 0.2 beside 0.3.
_MOST_LEFT_OF_ODD = 0.6
# Standard deviation of the noise of the shear over that of the pressure, at most: few points may
# look like noise by chance.
_NOISIER = 5.0
# Of the round-off of one traction over its scale, squared: less is no difference.
_ROUND_OFF = 1e-20


# ------------------------------------------------------------------------------------------ fits
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
        """Of the causes."""
        return frozenset(cause.key for cause in self.causes)

    @property
    def parameters(self) -> int:
        """Sizes that were fitted; an odd part takes half of the values as it finds them."""
        sizes = sum(cause.sized for cause in self.causes)
        return sizes + (self.count((SHEAR,)) // 2 if ODD_PART in self.causes else 0)

    def square(self, channels: Sequence[int]) -> float:
        """R over some channels, the sum of their means."""
        return sum(self.residuals[channel].square for channel in channels)

    def noise(self, channels: Sequence[int]) -> float:
        """N over some channels; that of the shear is of the size of that of the pressure, both over
        the largest pressure.
        """
        most = (np.inf, max(self.square((PRESSURE,)), _ROUND_OFF) * self.noisier**2)
        return sum(
            min(self.residuals[channel].noise, self.square((channel,)), most[channel])
            for channel in channels
        )

    def is_noise(self, channels: Sequence[int]) -> bool:
        """Whether it leaves nothing smooth."""
        parts = [self.residuals[channel] for channel in channels]
        return all(part.is_noise or part.square <= _ROUND_OFF for part in parts)

    def count(self, channels: Sequence[int]) -> int:
        """Values in contact."""
        return sum(self.residuals[channel].count for channel in channels)


@dataclass(frozen=True, eq=False)
class Search:
    """Fits of causes to a discrepancy, each done once."""

    what: Discrepancy
    predictions: Predictions
    done: dict[object, Fit | None] = field(default_factory=dict)

    def fit(
        self,
        causes: tuple[Cause, ...],
        channels: tuple[int, ...],
        known: tuple[float, ...] = (),
    ) -> Fit | None:
        """The sizes that leave least in these channels; None where the file can't have the causes,
        or theory has no solution for them.

        `known` are the sizes of the first causes, found before, which are kept.
        """
        key = tuple(CAUSES.index(cause) for cause in causes), channels, known
        if key not in self.done:
            self.done[key] = self._fitted(causes, channels, known)
        return self.done[key]

    def _fitted(
        self, causes: tuple[Cause, ...], channels: tuple[int, ...], known: tuple[float, ...]
    ) -> Fit | None:
        searched = causes[len(known) :]
        starts: list[tuple[float, ...]] = [(size,) for size in known]
        starts += [self._starts(cause, searched, channels) for cause in searched]
        if not all(starts):
            return None
        trials = list(itertools.product(*starts))
        squares = [float(np.sum(self._left(causes, sizes, channels) ** 2)) for sizes in trials]
        sizes = trials[int(np.argmin(squares))]
        if min(squares) >= _NO_SOLUTION**2:
            return None
        fitted = [
            place for place, cause in enumerate(causes) if cause.sized and place >= len(known)
        ]
        if fitted:
            sizes = self._searched(causes, sizes, fitted, channels, _ROUGH)
            rough = float(np.sum(self._left(causes, sizes, channels) ** 2))
            without = self._left((), (), channels)
            if rough <= _HOPELESS**2 * float(np.sum(without**2)):
                sizes = self._searched(causes, sizes, fitted, channels, _CLOSE)
        return self._made(causes, sizes, channels)

    def refined(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Fit | None:
        """All sizes fitted at once, from these on."""
        fitted = [place for place, cause in enumerate(causes) if cause.sized]
        if fitted:
            sizes = self._searched(causes, sizes, fitted, channels, _CLOSE)
        return self._made(causes, sizes, channels)

    def _starts(
        self, cause: Cause, searched: tuple[Cause, ...], channels: tuple[int, ...]
    ) -> tuple[float, ...]:
        """Sizes at which a search starts: beside another cause, the size fitted alone as well."""
        starts = tuple(cause.starts(self.what))
        if len(searched) == 1 or not starts or not cause.sized:
            return starts
        alone = self.fit((cause,), channels)
        if alone is None:
            return starts[:1]
        if SHEAR in channels:
            return (*starts[::_STRIDE], alone.sizes[0])
        return (alone.sizes[0],) if len(starts) > 1 else (*starts, alone.sizes[0])

    def _searched(
        self,
        causes: tuple[Cause, ...],
        sizes: tuple[float, ...],
        fitted: Sequence[int],
        channels: tuple[int, ...],
        tolerance: float,
    ) -> tuple[float, ...]:
        """Least squares from these sizes on, to so much of a size."""
        from scipy.optimize import least_squares

        def completed(values: Array) -> tuple[float, ...]:
            trial = list(sizes)
            for place, value in zip(fitted, values, strict=True):
                trial[place] = float(value)
            return tuple(trial)

        found = least_squares(
            lambda values: self._left(causes, completed(values), channels),
            [sizes[place] for place in fitted],
            method="lm",
            diff_step=1e-5,
            xtol=tolerance,
            ftol=tolerance,
            x_scale=np.full(len(fitted), 0.1),
            max_nfev=_MOST_CALLS,
        )
        return completed(found.x)

    def _left(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Array:
        """Weighted residuals, flat; large where there is no solution."""
        size = self.what.weight.size
        try:
            predicted = self._predicted(causes, sizes, channels)
        except InputError:  # gross sliding, separation, a size that means nothing
            return np.full(size * len(channels), _NO_SOLUTION)
        weight = np.sqrt(self.what.weight)
        parts = [
            weight * (self.what.found[channel] - predicted[channel]) / self.what.units[channel]
            for channel in channels
        ]
        return np.nan_to_num(np.concatenate([part.ravel() for part in parts]), nan=_NO_SOLUTION)

    def _predicted(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Tractions:
        variant = Variant()
        for cause, size in zip(causes, sizes, strict=True):
            if abs(size) > cause.largest:
                raise InputError("beyond the range of the search")
            variant = cause.change(variant, size)
        return self.predictions.of(variant, sheared=SHEAR in channels)

    def _made(
        self, causes: tuple[Cause, ...], sizes: tuple[float, ...], channels: tuple[int, ...]
    ) -> Fit | None:
        try:
            predicted = self._predicted(causes, sizes, channels)
        except InputError:
            return None
        friction = self.what.comparison.scales.friction
        noisier = _NOISIER / friction if friction else np.inf
        return Fit(causes, sizes, predicted, self.what.residuals(predicted), noisier)


# ------------------------------------------------------------------------------------- judgement
def _share_left(fit: Fit, before: Fit, channels: Sequence[int]) -> float:
    """Norm of what a fit leaves over that of the difference before it, the noise set aside."""
    noise = fit.noise(channels)
    difference = before.square(channels) - noise
    if difference <= 0:
        return 1.0
    return float(np.sqrt((fit.square(channels) - noise) / difference))


def _by_chance(fit: Fit, before: Fit, channels: Sequence[int]) -> float:
    """Probability that noise alone lets a fit gain so much.

    Of sizes that were fitted by the F test. A prediction without a size leaves the share e of the
    squares of n values by chance with a probability of about e^(n/2); there are some ten of them,
    so that it is counted a hundredfold less severely.
    """
    from scipy.stats import f as f_distribution

    parameters = fit.parameters - before.parameters
    count = fit.count(channels)
    gain = before.square(channels) - fit.square(channels)
    if gain <= 0:
        return 1.0
    left = max(fit.square(channels), 1e-300)
    if parameters < 1:
        return float((left / before.square(channels)) ** (count / 2)) * _WITHOUT_SIZE
    freedom = count - fit.parameters
    if freedom < 1:
        return 1.0
    return float(f_distribution.sf(gain / parameters / (left / freedom), parameters, freedom))


def _explains(
    fit: Fit | None,
    before: Fit,
    channels: Sequence[int],
) -> bool:
    """Whether a fit leaves less than a third of the difference, and not by chance."""
    return (
        fit is not None
        and _share_left(fit, before, channels) < _MOST_LEFT
        and _by_chance(fit, before, channels) < _CHANCE
    )


@dataclass(frozen=True, eq=False)
class Verdict:
    """What explains a discrepancy.

    Attributes
    ----------
    fit
        the causes that are named; None if none is
    rivals
        other explanations that the file does not tell apart from it
    unexplained
        whether part of the difference has no cause yet
    """

    fit: Fit | None
    rivals: tuple[Fit, ...] = ()
    unexplained: bool = False


@dataclass(frozen=True, eq=False)
class Judge:
    """The order of evidence, on one discrepancy."""

    what: Discrepancy
    search: Search
    excluded: dict[str, str] = field(default_factory=dict)

    @property
    def channels(self) -> tuple[int, ...]:
        """Pressure, and shear where the file has one."""
        return (PRESSURE, SHEAR) if self.what.sheared else (PRESSURE,)

    @property
    def without(self) -> Fit:
        """No cause."""
        nothing = self.search.fit((), self.channels)
        assert nothing is not None
        return nothing

    def verdict(self) -> Verdict:
        """Pressure first, then shear; of several explanations the one that leaves least."""
        of_pressure = self._of_pressure()
        whole: list[Fit] = []
        partly: list[Fit] = []
        for start in of_pressure:
            explained, rest = self._with_shear(start)
            whole += explained
            if rest is not None:
                partly.append(rest)
        stiffer = [fit for fit in partly if "stiffness" in fit.keys]
        if not whole and stiffer:
            # Under a constant P a base that is near moves the pressure as another radius does.
            others = tuple(cause for cause in stiffer[0].causes if cause.group != "size")
            for start in self._explanations([(SMALL_BODY, *others)], self.without, (PRESSURE,)):
                whole += self._with_shear(start)[0]
        whole += self._jointly(of_pressure, whole)
        candidates = whole or [fit for fit in partly if fit.causes]
        if not candidates:
            return Verdict(None, unexplained=True)
        # A cause that needs a size to do what another does without is no rival: a tilt of a
        # parabola is an offset of just that size, half a cycle late is the other sign of Q.
        least = min(candidates, key=lambda fit: fit.square(self.channels))
        best = min(candidates, key=lambda fit: self._rank(fit, least))
        rivals = tuple(
            fit
            for fit in candidates
            if fit.keys != best.keys
            and not self._told_apart(fit, best)
            and fit.parameters <= best.parameters
        )
        pressure_left = not self.is_right(best, PRESSURE) and not whole
        return Verdict(best, rivals, unexplained=not whole or pressure_left)

    def _jointly(self, of_pressure: Sequence[Fit], whole: Sequence[Fit]) -> list[Fit]:
        """The best explanation, and the same with each other explanation of the pressure in it,
        their sizes fitted to both tractions at once.

        Sizes that a noisy pressure has given may be too far off for the shear to decide fairly.
        """
        if not whole or len(of_pressure) < 2 or not self.what.sheared:
            return []
        best = min(whole, key=lambda fit: fit.square(self.channels))
        if best.square(self.channels) <= _EXACT * self.without.square(self.channels):
            return []
        of_best = [start for start in of_pressure if start.keys <= best.keys]
        if not of_best:
            return []
        count = len(of_best[0].causes)
        fits = []
        for start in of_pressure:
            causes = (*start.causes, *best.causes[count:])
            sizes = (*start.sizes, *best.sizes[count:])
            if _may_meet(causes):
                fits.append(self.search.refined(causes, sizes, self.channels))
        return [
            fit
            for fit in fits
            if fit is not None
            and not self._contradicted(fit)
            and not _is_no_change(fit)
            and _explains(fit, self.without, self.channels)
        ]

    def _rank(self, fit: Fit, least: Fit) -> tuple[bool, int, int, float]:
        """For sorting: what does as well as the best first, of these the fewest causes, then the
        fewest sizes.
        """
        told_apart = self._told_apart(fit, least)
        return told_apart, len(fit.causes), fit.parameters, fit.square(self.channels)

    # ------------------------------------------------------------------------------ the pressure
    def _of_pressure(self) -> list[Fit]:
        """Explanations of the pressure, the best first; no cause where it is right, or where
        nothing explains it.
        """
        channels = (PRESSURE,)
        without = self.without
        if self.is_right(without, PRESSURE) and self.what.is_within(PRESSURE):
            return [without]
        causes = [cause for cause in CAUSES if cause.channel == PRESSURE]
        quick = [cause for cause in causes if cause not in _OF_MODEL]
        singles = self._explanations([(cause,) for cause in quick], without, channels)
        singles += self._explanations(self._of_model(singles), without, channels)
        singles.sort(key=lambda fit: fit.square(channels))
        if singles and self.is_right(singles[0], PRESSURE):
            return self._near(singles, channels)
        few = without.count(channels) < _FEW_VALUES
        if not singles and without.is_noise(channels) and not few:
            return [without]
        helpful = [cause for cause in quick if self._helps(cause)]
        choices = _pairs(helpful)
        # Behind a sign, a swap or a unit no other cause helps alone.
        for fit in singles:
            if not fit.causes[0].sized:
                choices += [(fit.causes[0], cause) for cause in quick if cause.sized]
        choices = [both for both in dict.fromkeys(choices) if _may_meet(both)]
        pairs = self._explanations(choices, without, channels)
        pairs += self._explanations(self._of_model(pairs), without, channels)
        # Few values may not show more than chance, and a pair is no way around that.
        alone = [fit for fit in map(self._alone, quick) if fit is not None]
        alone = [fit for fit in alone if _share_left(fit, without, channels) < _MOST_LEFT]
        if alone:
            least = min(alone, key=lambda fit: fit.square(channels))
            pairs = [fit for fit in pairs if self._better(fit, least, channels)]
        found = sorted(pairs or singles, key=lambda fit: fit.square(channels))
        return self._near(found, channels) or [without]

    def _helps(self, cause: Cause) -> bool:
        """Whether a cause alone leaves less of the pressure than none, so that pairs with it are
        worth their time; nodal forces do not where another fault is larger.
        """
        fit = self.search.fit((cause,), (PRESSURE,))
        if fit is None or cause.key == "coarse_edge":
            return fit is not None
        return _share_left(fit, self.without, (PRESSURE,)) < _NO_HELP

    def _alone(self, cause: Cause) -> Fit | None:
        """Of one cause to the pressure."""
        fit = self.search.fit((cause,), (PRESSURE,))
        return None if fit is None or self._contradicted(fit) else fit

    def _of_model(self, fits: Sequence[Fit]) -> list[tuple[Cause, ...]]:
        """Bodies too small, or faces that sink into each other, in place of the factor of E*, loads
        or x that does best: both change widths as these do. None where that is exact.
        """
        sized = [fit for fit in fits if any(cause.group == "size" for cause in fit.causes)]
        if not sized and len(fits) == 0:
            noise = self.without.is_noise((PRESSURE,))
            return [] if noise else [(cause,) for cause in _OF_MODEL]
        if not sized:
            return []
        best = min(sized, key=lambda fit: fit.square((PRESSURE,)))
        if best.square((PRESSURE,)) <= _EXACT * self.without.square((PRESSURE,)):
            return []
        others = tuple(cause for cause in best.causes if cause.group != "size")
        return [(cause, *others) for cause in _OF_MODEL]

    def _near(self, fits: list[Fit], channels: Sequence[int]) -> list[Fit]:
        """Those that the pressure does not tell apart from the best."""
        return [fit for fit in fits if not self._told_apart(fit, fits[0], channels)][
            :_MOST_OF_PRESSURE
        ]

    def _explanations(
        self,
        choices: Iterable[tuple[Cause, ...]],
        before: Fit,
        channels: tuple[int, ...],
    ) -> list[Fit]:
        """Fits that explain what `before` leaves in these channels."""
        explanations = []
        for causes in choices:
            fit = self.search.fit(causes, channels)
            if fit is None or self._contradicted(fit) or _is_no_change(fit):
                continue
            if _explains(fit, before, channels):
                explanations.append(fit)
        return explanations

    def _contradicted(self, fit: Fit) -> bool:
        """Whether the sum of the pressures speaks against a factor of loads, traction or x."""
        factors = [
            cause.resultant(size)
            for cause, size in zip(fit.causes, fit.sizes, strict=True)
            if cause.resultant is not None
        ]
        if "other_times" in fit.keys:  # where P is another one
            return False
        ratio = self.what.resultant_ratio
        if "coarse_edge" in fit.keys and not factors and abs(ratio - 1) > _SAME_RESULTANT:
            self.excluded["coarse_edge"] = f"the sum of the pressures is {ratio:.4g} P"
            return True
        if len(factors) != 1 or not np.isfinite(ratio):
            return False
        if abs(ratio - 1) > _UNMOVED * abs(factors[0] - 1):
            return False
        if len(fit.causes) == 1:
            words = f"the sum of the pressures is {ratio:.4g} P"
            self.excluded[fit.causes[0].key] = words
        return True

    # --------------------------------------------------------------------------------- the shear
    def _with_shear(self, start: Fit) -> tuple[list[Fit], Fit | None]:
        """Explanations of pressure and shear that begin with `start`; and `start` itself where it
        explains the pressure and the shear still has a difference without a cause.

        The sizes that the pressure has given are kept.
        """
        if not self.what.sheared:
            return ([start] if start.causes else []), None
        channels = (PRESSURE, SHEAR)
        before = self.search.fit(start.causes, channels, known=start.sizes)
        if before is None:
            return [], start
        if self.is_right(before, SHEAR):
            return ([before] if before.causes else []), None
        of_shear = [
            cause
            for cause in CAUSES
            if (cause.channel == SHEAR and cause.key != COUPLING.key)
            or cause.key in ("other_times", "coarse_edge")
        ]
        found: list[Fit] = []
        # Friction follows the pressure: where that has no cause, no pair is looked for.
        most = 2 - len(start.causes)
        if not start.causes and not self.is_right(start, PRESSURE):
            most = 1
        for count in range(1, most + 1):
            choices = [
                (*start.causes, *chosen) for chosen in itertools.combinations(of_shear, count)
            ]
            fits = self._explanations_of_shear(filter(_may_meet, choices), before)
            if found:
                fits = [fit for fit in fits if self._better(fit, found[0], (SHEAR,))]
            found = sorted(fits or found, key=lambda fit: fit.square((SHEAR,)))
            if found and self.is_right(found[0], SHEAR):
                break
            if count == 1 and len(start.causes) < 2:
                coupled = self._coupled(found[0] if found else before)
                if coupled is not None:
                    return [coupled], None
        if found:
            return found, None
        left = _share_left(start, self.without, (PRESSURE,))
        return [], before if start.causes and left <= _ALONE else None

    def _coupled(self, before: Fit) -> Fit | None:
        """Unlike bodies beside the causes of `before`, where most of what these leave is odd in x.

        Theory is known to lack what the scene's own materials make: there the odd part is enough.
        """
        if len(before.causes) > 1:
            return None
        odd = self.search.fit((*before.causes, ODD_PART), self.channels, known=before.sizes)
        if odd is None or _share_left(odd, before, (SHEAR,)) > _MOST_LEFT_OF_ODD:
            return None
        if abs(dundurs(self.what.comparison.scene.material).beta) > _NO_COUPLING:
            return odd if _by_chance(odd, before, (SHEAR,)) < _CHANCE else None
        fits = self._explanations_of_shear([(*before.causes, COUPLING)], before)
        return fits[0] if fits else None

    def _explanations_of_shear(
        self, choices: Iterable[tuple[Cause, ...]], before: Fit
    ) -> list[Fit]:
        """Fits that explain the shear that `before` leaves, and leave no more of the pressure."""
        explanations = []
        for causes in choices:
            fit = self.search.fit(causes, (PRESSURE, SHEAR), known=before.sizes)
            if fit is None or _is_no_change(fit) or self._contradicted(fit):
                continue
            keeps = fit.square((PRESSURE,)) <= 2 * before.square((PRESSURE,)) + _ROUND_OFF
            if keeps and _explains(fit, before, (SHEAR,)):
                explanations.append(fit)
        return explanations

    # -------------------------------------------------------------------------------- comparison
    def is_right(self, fit: Fit, channel: int) -> bool:
        """Whether a fit leaves nothing of a traction but noise, or what its tolerance allows."""
        if fit.is_noise((channel,)):
            if channel == PRESSURE:
                return True
            if fit.square((SHEAR,)) <= max(fit.square((PRESSURE,)), _ROUND_OFF) * fit.noisier**2:
                return True
        if not fit.causes:
            return self.what.is_within(channel)
        # Behind a factor of units the difference is far larger than the tractions.
        left = fit.square((channel,)) - fit.noise((channel,))
        size = self.what.residual(0 * fit.predicted, channel).square
        return (
            _share_left(fit, self.without, (channel,)) <= _COMPLETE and left <= _COMPLETE**2 * size
        )

    def _better(self, fit: Fit, than: Fit, channels: Sequence[int] | None = None) -> bool:
        """Whether more causes leave so much less that they are called for."""
        over = self.channels if channels is None else channels
        if len(fit.causes) <= len(than.causes):
            return fit.square(over) < than.square(over)
        gain = fit.square(over) <= _PAIR_GAIN * than.square(over)
        significant = _by_chance(fit, than, over) < _CHANCE
        return significant and (gain or not than.is_noise(over))

    def _told_apart(self, fit: Fit, best: Fit, channels: Sequence[int] | None = None) -> bool:
        """Whether `fit` leaves so much more than `best` that it is out."""
        over = self.channels if channels is None else channels
        least = max(best.square(over), _ROUND_OFF)
        if best.is_noise(over):
            variances = (fit.square(over) - least) / least * best.count(over)
            return variances > _APART
        return fit.square(over) > _APART_EXACT * least


def _pairs(causes: Sequence[Cause]) -> list[tuple[Cause, ...]]:
    return [both for both in itertools.combinations(causes, 2) if _may_meet(both)]


def _may_meet(causes: tuple[Cause, ...]) -> bool:
    """Whether no two of them are of one group, or the same."""
    groups = [cause.group for cause in causes if cause.group]
    keys = [cause.key for cause in causes]
    return len(set(groups)) == len(groups) and len(set(keys)) == len(keys)


def _is_no_change(fit: Fit) -> bool:
    """Whether a fitted size is none: what is left then is the error of a mesh."""
    return any(
        cause.sized and abs(size) < _LEAST_SIZE
        for cause, size in zip(fit.causes, fit.sizes, strict=True)
        if cause.key not in ("other_times", "offset")
    )


# -------------------------------------------------------------------------------------- findings
def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """Findings on the difference, causes first; none for a result within tolerance."""
    what = discrepancy(comparison)
    if what is None:
        return ()
    cells = outliers(comparison)
    traces = [*full_slip(what), *elastic_slip(what)]
    if what.within:
        named = (*cells, *traces) or tuple(long_steps_by_work(comparison))
        if named or comparison.verdict == "within":
            return named
    judge = Judge(what, Search(what, Predictions(what)))
    verdict = judge.verdict()
    causes = list(_named(judge, verdict, is_traced=bool(traces)))
    if not causes and not traces:
        causes = [*_own_bodies(judge), *_mesh_at_edges(judge), *scatter(what)][:1]
    if not causes and not traces and not cells and not what.within:
        causes = [_not_found(judge, verdict)]
    return (*cells, *traces, *causes)


def _named(judge: Judge, verdict: Verdict, *, is_traced: bool) -> Iterator[Diagnosis]:
    """The causes of the verdict that no rival lacks."""
    fit = verdict.fit
    if fit is None:
        return
    shared = fit.keys.intersection(*(rival.keys for rival in verdict.rivals))
    for place, cause in enumerate(fit.causes):
        # What has a trace of its own in the shear needs no second explanation of it.
        if cause.key not in shared or (is_traced and cause.channel == SHEAR):
            continue
        before = _without_cause(judge, fit, cause)
        # a layer's effect on the shear is not predicted
        channels = (PRESSURE,) if cause is SOFT_NORMAL else judge.channels
        left = _share_left(fit, before, channels)
        yield Diagnosis(
            _label(cause, fit.sizes[place]),
            _sentence(judge.what, cause, fit.sizes[place], fit),
            tuple(_evidence(judge, fit, left)),
            strength=1 - min(left, 1.0),
        )


def _without_cause(judge: Judge, fit: Fit, cause: Cause) -> Fit:
    """The fit of the other causes alone."""
    others = tuple(one for one in fit.causes if one is not cause)
    return judge.search.fit(others, judge.channels) or judge.without


def _label(cause: Cause, size: float) -> str:
    """The key of the sentence: round factors have their own."""
    factor = float(np.exp(size))
    if cause.key == "loads" and min(abs(factor / 2 - 1), abs(2 * factor - 1)) < _HALF:
        return "half_model"
    if cause.key == "traction_factor" and round_power(factor) is not None:
        return "units"
    return cause.key


def _sentence(what: Discrepancy, cause: Cause, size: float, fit: Fit) -> str:
    """The cause, and what to do."""
    factor = float(np.exp(size))
    figures = {
        "factor": factor,
        "distance": size,
        "delay": size,
        "steps": float(len(what.comparison.found.time) - 1),
        "height": _height(size),
        "spacing": 1 / what.elements,
        "likely": "",
    }
    if cause.key == COUPLING.key:
        return coupling_sentence(what)
    if cause.key == "coarse_edge":
        return _of_mesh(what, alone=len(fit.causes) == 1)
    label = _label(cause, size)
    if label == "units" and cause.sized:
        figures["factor"] = round_power(factor) or factor
    if cause.key == "stiffness":
        return FAULTS[label].format(**figures | {"likely": _likely_stiffness(what, factor)})
    return FAULTS[label].format(**figures)


def _height(share: float) -> float:
    """Height of two equal blocks [a_ref] with this share of the curvatures of `causes._BLOCK`."""
    from reports.scoring.causes import _BLOCK

    return _BLOCK / max(abs(share), 1e-12) ** 0.5


def _of_mesh(what: Discrepancy, *, alone: bool) -> str:
    """The sentence of a mesh whose nodal forces are all that it shows."""
    carrying = int(np.max(np.sum(what.found[0] > 1e-3 * np.max(what.found[0]), axis=1)))
    sentence = WORDS["others"]["coarse_mesh"].format(
        elements=what.elements,
        carrying=carrying,
        wanted=what.half_width / _ENOUGH_ELEMENTS,
        enough=_ENOUGH_ELEMENTS,
    )
    return f"{sentence} {WORDS['others']['coarse_mesh_alone']}" if alone else str(sentence)


def _likely_stiffness(what: Discrepancy, factor: float) -> str:
    """What a factor of E*/R is likely to be, in words."""
    material = what.comparison.scene.material
    nu = material.upper.poisson_ratio
    if material.alike and abs(factor / (1 - nu**2) - 1) < 0.2 * nu**2:
        return f"it is near 1 - nu^2 = {1 - nu**2:.3g}: plane stress"
    for quotient in WORDS["stiffness"]:
        if abs(factor / quotient["factor"] - 1) < quotient["within"]:
            return str(quotient["cause"])
    return "contact widths go as the square root of its inverse for a Hertz contact"


def _evidence(judge: Judge, fit: Fit, left: float) -> Iterator[str]:
    """Measured values that speak for a cause, in the order of evidence."""
    what = judge.what
    ratio = what.resultant_ratio
    if np.isfinite(ratio):
        yield f"the sum of the pressures is {ratio:.4g} P"
    noise = fit.noise(judge.channels) ** 0.5
    yield (
        f"{fit.count((PRESSURE,))} values in contact; noise from point to point {noise:.2g} of the"
        " scales"
    )
    of_which = " of the pressure" if SOFT_NORMAL in fit.causes else ""
    yield f"a result with just this fault leaves {max(left, 0.0):.1%} of the difference{of_which}"
    pressure, shear = what.errors()
    after = replace(what, expected=fit.predicted).errors()
    yield (
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        " that, at the worst instant; with the fault taken out, "
        f"{after[0]:.2g} and {after[1]:.2g}"
    )
    if what.missing:
        yield f"{what.missing:.1%} of the tractions are no numbers and were left out"
    if what.unsymmetric:
        yield (
            "with bulk stress, tilt or unequal sides not looked for: no memory, unlike bodies, soft"
            " penalties, bodies too small"
        )


def coupling_sentence(what: Discrepancy) -> str:
    """What a difference that is odd in x means: a fault of the result, unless its scene has unlike
    materials and the reference does not have their coupling.
    """
    beta = dundurs(what.comparison.scene.material).beta
    if abs(beta) <= _NO_COUPLING:
        return FAULTS["coupling"]
    in_reference = what.comparison.reference.engine == "halfplane_fe"
    key = "coupling_of_reference" if in_reference else "own_coupling"
    return str(WORDS["others"][key].format(own=beta))


def _own_bodies(judge: Judge) -> Iterator[Diagnosis]:
    """The idealisation: theory with the numbers of the scene's own bodies leaves less than a third
    of what half-plane theory leaves.
    """
    what = judge.what
    if not what.has_bodies:
        return
    reference = what.comparison.expected
    half_planes = np.array([reference.pressure[what.rows], reference.shear[what.rows]])
    half_planes = np.where(np.isfinite(half_planes), half_planes, what.expected)
    before = Fit((), (), half_planes, what.residuals(half_planes))
    left = _share_left(judge.without, before, judge.channels)
    if left < _MOST_LEFT:
        evidence = tuple(_evidence(judge, judge.without, left))
        yield Diagnosis(OWN_BODIES, WORDS["others"][OWN_BODIES], evidence, 1 - left)


def _mesh_at_edges(judge: Judge) -> Iterator[Diagnosis]:
    """A difference that lies within two elements of the edges."""
    from scipy.stats import f as f_distribution

    what = judge.what
    edges = coarse_edge(what)
    if edges is None or judge.is_right(judge.without, PRESSURE):
        return  # a mesh that errs at stick edges errs at the edges of contact as well
    predicted, is_near = edges
    fit = Fit((), (), predicted, what.residuals(predicted))
    left = _share_left(fit, judge.without, judge.channels)
    values = np.array([judge.without.residuals[channel].values for channel in judge.channels])
    contact = judge.without.residuals[PRESSURE].inside
    near = values[:, contact & is_near].ravel()
    far = values[:, contact & ~is_near].ravel()
    ratio = np.mean(near**2) / max(float(np.mean(far**2)), _ROUND_OFF)
    chance = float(f_distribution.sf(ratio, len(near), len(far)))
    if left > _MOST_LEFT or ratio < _MOST_LEFT**-2 or chance > _CHANCE:
        return
    sentence = FAULTS["coarse_edge"].format(spacing=1 / what.elements)
    yield Diagnosis("coarse_edge", sentence, tuple(_evidence(judge, fit, left)), 1 - left)


def _not_found(judge: Judge, verdict: Verdict) -> Diagnosis:
    """What is excluded, and by what."""
    what = judge.what
    pressure, shear = what.errors()
    lines = [
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        " that, at the worst instant"
    ]
    if verdict.fit is not None and verdict.rivals:
        choices = [verdict.fit, *verdict.rivals]
        words = " or ".join(" with ".join(sorted(fit.keys)) for fit in choices)
        lines.insert(0, f"the file does not tell these apart: {words}")
    if judge.excluded:
        words = "; ".join(
            f"{WORDS['names'][key]}: {reason}" for key, reason in judge.excluded.items()
        )
        lines.append(f"excluded: {words}")
    lines += _left_by_each(judge)
    return Diagnosis(UNKNOWN, WORDS["others"][UNKNOWN], tuple(lines), 0.0)


def _left_by_each(judge: Judge) -> Iterator[str]:
    """What each cause that was tried alone leaves, the least first."""
    least: dict[str, float] = {}
    for fit in judge.search.done.values():
        if fit is None or len(fit.causes) != 1:
            continue
        (cause,) = fit.causes
        left = _share_left(fit, judge.without, (cause.channel,))
        if left < 1:
            least[cause.key] = min(left, least.get(cause.key, 1.0))
    ranked = sorted(least.items(), key=lambda item: item[1])
    words = ", ".join(f"{WORDS['names'][key]} {left:.0%}" for key, left in ranked)
    if words:
        yield f"each alone leaves of the difference (pressure, or shear): {words}; all others all"
