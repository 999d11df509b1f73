"""The order of evidence: the pressure is explained first, since between like bodies friction does
not touch it; then the shear, given what explains the pressure.

A cause of `causes.CAUSES`, its size fitted, predicts the tractions of a result with just this
fault. It explains the difference where

- it leaves less than a third of it, noise from point to point set aside;
- the gain is more than chance would give (F test);
- the sum of the pressures does not contradict it;
- no other cause does as well: of two that the file does not tell apart neither is named.

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
    SMALL_BODY,
    SOFT_NORMAL,
    Cause,
)
from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy
from reports.scoring.fits import (
    CHANCE,
    MOST_LEFT,
    ROUND_OFF,
    Fit,
    Search,
    are_apart,
    by_chance,
    explains,
    share_left,
)

# Of the norm of the difference, what a cause leaves where nothing else needs to be looked for
# beside it.
_COMPLETE = 0.03
# What a cause may leave of the pressure where nothing explains the shear.
_ALONE = 0.1
# Squares of the norm by which a pair must leave less than a single cause.
_PAIR_GAIN = 1 / 4
# Share by which the sum of the pressures must follow a factor of the loads.
_UNMOVED = 1 / 3
# Over P, by which nodal forces may differ from it: they add up to P on any mesh, but for noise.
_SAME_RESULTANT = 0.05
# A fitted factor this near to 1 is the error of a mesh, and no fault.
_LEAST_SIZE = 0.005
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
# Dundurs' beta of like bodies, but for round-off.
NO_COUPLING = 1e-9
# What the odd part of the difference may leave of it where bodies couple: 0.09 to 0.53 of the norm
# was measured for nu = 0.45 and 0.2 beside 0.3.
_MOST_LEFT_OF_ODD = 0.6


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
            and not _is_no_change(fit, self.without, self.channels)
            and explains(fit, self.without, self.channels)
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
        alone = [fit for fit in alone if share_left(fit, without, channels) < MOST_LEFT]
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
        return share_left(fit, self.without, (PRESSURE,)) < _NO_HELP

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
            if fit is None or self._contradicted(fit) or _is_no_change(fit, before, channels):
                continue
            if explains(fit, before, channels):
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
        left = share_left(start, self.without, (PRESSURE,))
        return [], before if start.causes and left <= _ALONE else None

    def _coupled(self, before: Fit) -> Fit | None:
        """Unlike bodies beside the causes of `before`, where most of what these leave is odd in x.

        Theory is known to lack what the scene's own materials make: there the odd part is enough.
        """
        if len(before.causes) > 1:
            return None
        odd = self.search.fit((*before.causes, ODD_PART), self.channels, known=before.sizes)
        if odd is None or share_left(odd, before, (SHEAR,)) > _MOST_LEFT_OF_ODD:
            return None
        if abs(dundurs(self.what.comparison.scene.material).beta) > NO_COUPLING:
            return odd if by_chance(odd, before, (SHEAR,)) < CHANCE else None
        fits = self._explanations_of_shear([(*before.causes, COUPLING)], before)
        return fits[0] if fits else None

    def _explanations_of_shear(
        self, choices: Iterable[tuple[Cause, ...]], before: Fit
    ) -> list[Fit]:
        """Fits that explain the shear that `before` leaves, and leave no more of the pressure."""
        explanations = []
        for causes in choices:
            fit = self.search.fit(causes, (PRESSURE, SHEAR), known=before.sizes)
            if fit is None or _is_no_change(fit, before, (SHEAR,)) or self._contradicted(fit):
                continue
            keeps = fit.square((PRESSURE,)) <= 2 * before.square((PRESSURE,)) + ROUND_OFF
            if keeps and explains(fit, before, (SHEAR,)):
                explanations.append(fit)
        return explanations

    # -------------------------------------------------------------------------------- comparison
    def is_right(self, fit: Fit, channel: int) -> bool:
        """Whether a fit leaves nothing of a traction but noise, or what its tolerance allows."""
        if fit.is_noise((channel,)):
            if channel == PRESSURE:
                return True
            if fit.square((SHEAR,)) <= max(fit.square((PRESSURE,)), ROUND_OFF) * fit.noisier**2:
                return True
        if not fit.causes:
            return self.what.is_within(channel)
        # Behind a factor of units the difference is far larger than the tractions.
        left = fit.square((channel,)) - fit.noise((channel,))
        size = self.what.residual(0 * fit.predicted, channel).square
        return (
            share_left(fit, self.without, (channel,)) <= _COMPLETE and left <= _COMPLETE**2 * size
        )

    def is_whole(self, fit: Fit) -> bool:
        """Whether a fit leaves nothing of either traction but noise."""
        return all(self.is_right(fit, channel) for channel in self.channels)

    def _better(self, fit: Fit, than: Fit, channels: Sequence[int] | None = None) -> bool:
        """Whether more causes leave so much less that they are called for."""
        over = self.channels if channels is None else channels
        if len(fit.causes) <= len(than.causes):
            return fit.square(over) < than.square(over)
        gain = fit.square(over) <= _PAIR_GAIN * than.square(over)
        significant = by_chance(fit, than, over) < CHANCE
        return significant and (gain or not than.is_noise(over))

    def _told_apart(self, fit: Fit, best: Fit, channels: Sequence[int] | None = None) -> bool:
        """Whether `fit` leaves so much more than `best` that it is out."""
        over = self.channels if channels is None else channels
        return are_apart(
            fit.square(over), best.square(over), best.count(over), is_noise=best.is_noise(over)
        )


def _pairs(causes: Sequence[Cause]) -> list[tuple[Cause, ...]]:
    return [both for both in itertools.combinations(causes, 2) if _may_meet(both)]


def _may_meet(causes: tuple[Cause, ...]) -> bool:
    """Whether no two of them are of one group, or the same."""
    groups = [cause.group for cause in causes if cause.group]
    keys = [cause.key for cause in causes]
    return len(set(groups)) == len(groups) and len(set(keys)) == len(keys)


def _is_no_change(fit: Fit, before: Fit, channels: Sequence[int]) -> bool:
    """Whether a fitted size is next to none: what is left then is the error of a mesh, unless the
    fit leaves nothing of the difference.
    """
    is_small = any(
        cause.sized and abs(size) < _LEAST_SIZE
        for cause, size in zip(fit.causes, fit.sizes, strict=True)
        if cause.key not in ("other_times", "offset")
    )
    return is_small and share_left(fit, before, channels) > _COMPLETE
