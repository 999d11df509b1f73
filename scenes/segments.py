"""Load segments: the smooth pieces of a load history P(t), Q(t), by straight lines, harmonics or
Chebyshev series of time.

Bulk stresses and tilt or moment, where a load has them, are pairs of numbers over the same time:
segments that P and Q carry along.

# notation: c_P P + c_Q Q a linear combination of the two loads, given as the pair (c_P, c_Q)

The ellipse of the paper is a `HarmonicSegment` of one wave, its parabola a `ChebyshevSegment` of
degree 2. Every segment gives the change of a combination between two times free of cancellation,
its rate, its turning points, and the time at which it has changed by an amount. Geometry of the
path only: what the path does to the contact is computed by the engines.
"""

from __future__ import annotations

import abc
import cmath
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from scenes.array_types import Array
from scenes.chebyshev import difference
from scenes.errors import NotFoundError

Loads = tuple[Array, Array]
Point = tuple[
    Annotated[float, Field(description="normal load P")],
    Annotated[float, Field(description="tangential load Q")],
]
Waves = tuple[tuple[float, float], ...]
WaveTerms = tuple[tuple[complex, int], ...]

LEAST = 1e-290
"""Changes of load below it are none: their inverse, and soon the numbers themselves, are not known
to rounding any more.
"""

_ROUNDING = 1e-14
_ROUNDING_OF_TIME = 4.5e-16
# Of the largest sum of a series: what rounding of its coefficients leaves of a load that starts
# from 0.
_ROUNDING_OF_SUM = 1e-15
# A double root is known to the root of a rounding only. Taking too many does no harm: a segment is
# cut in two.
_DISTANCE_OF_DOUBLE_ROOTS = 1e-5
# Steps of Newton's method with a bracket: some 60 halve the bracket to rounding, and some 60 the
# step between two of these.
_MOST_STEPS = 4000
# Steps of Newton's method without a bracket: four or five are taken.
_MOST_PLAIN_STEPS = 12
# Of a step squared over the distance of a turning point, what it leaves: a half where the rate goes
# as the distance, and room.
_ERROR_OF_STEP = 4.0
# Steps without gain after which rounding is reached, where they are shorter than this share of the
# way.
_MOST_IDLE_STEPS = 3
_SHORT_STEP = 1e-9


class Combination(NamedTuple):
    """c_P P + c_Q Q of the two loads."""

    normal: float
    tangential: float


NORMAL_LOAD = Combination(1.0, 0.0)
TANGENTIAL_LOAD = Combination(0.0, 1.0)


class Ellipse(NamedTuple):
    """P = P0 + P1 cos(t - origin), Q = Q0 + Q1 cos(t - origin - phase_radians): equations (3) and
    (4) of the paper with omega = 1.
    """

    mean: Point
    amplitude: Point
    phase_radians: float
    origin: float

    def largest_at(self, combination: Combination) -> float:
        """A time at which a combination c_P P + c_Q Q of the loads of this ellipse is largest: the
        angle of the sum of both phasors.

        >>> Ellipse((3.0, 0.0), (1.0, 1.0), math.pi / 2, 0.0).largest_at(
        ...     TANGENTIAL_LOAD
        ... ) == math.pi / 2
        True
        """
        phasor = combination.normal * self.amplitude[0] + combination.tangential * self.amplitude[
            1
        ] * cmath.exp(-1j * self.phase_radians)
        return self.origin - cmath.phase(phasor)


@dataclass(frozen=True)
class LoadSegment(abc.ABC):
    """A smooth piece of a load path on start <= t <= end; times may have any shape, and results
    have the shape of the times.

    Attributes
    ----------
    bulk
        over the same time, with the stresses of the lower and of the upper body in place of P
        and Q; None for none
    turning
        likewise with tilt and moment, one of which is 0 throughout; None where neither is
        stated
    """

    start: float
    end: float
    bulk: LoadSegment | None = field(default=None, kw_only=True)
    turning: LoadSegment | None = field(default=None, kw_only=True)

    @property
    def is_straight(self) -> bool:
        """Whether P and Q are linear in time."""
        return False

    @property
    def most_turns(self) -> int:
        """Upper bound of the number of turning points of P, Q or a sum of both inside the
        segment.
        """
        return 0

    @property
    def ellipse(self) -> Ellipse | None:
        """The ellipse that the segment follows; None if it follows none."""
        return None

    @abc.abstractmethod
    def loads(self, time: ArrayLike) -> Loads:
        """(P, Q) [force per thickness] at `time`."""

    def rates(self, time: ArrayLike) -> Loads:
        """(dP/dt, dQ/dt) at `time`."""
        return self.rate_of(NORMAL_LOAD, time), self.rate_of(TANGENTIAL_LOAD, time)

    @abc.abstractmethod
    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        """Time derivative of a combination."""

    @abc.abstractmethod
    def change_of(self, combination: Combination, time: ArrayLike, time_before: ArrayLike) -> Array:
        """Change of a combination c_P P + c_Q Q of the loads from `time_before` to `time`, without
        loss of digits over short times, nor near the extremes of a single wave.

        >>> float(
        ...     ellipse_segment(0.0, 7.0, (3.0, 1.0), (1.0, 1.0), math.pi / 2).change_of(
        ...         NORMAL_LOAD, math.pi, 0.0
        ...     )
        ... )
        -2.0
        """

    def _change_and_rate(
        self, combination: Combination, time: Array, time_before: float
    ) -> tuple[Array, Array]:
        """`change_of` and `rate_of` at once, (n,) each."""
        change = self.change_of(combination, time, time_before)
        return change, self.rate_of(combination, time)

    @abc.abstractmethod
    def companion_of(self, combination: Combination) -> LoadSegment:
        """A segment over the same time with 0 in place of P and a combination in place of Q."""

    def turning_points(self, combination: Combination) -> list[float]:
        """Turning points of a combination c_P P + c_Q Q of the loads: times inside the segment at
        which it stops growing or falling, ascending. They are found once and cached.
        """
        known_turns = self._known_turns
        if combination not in known_turns:
            known_turns[combination] = tuple(self._found_turns(combination))
        return list(known_turns[combination])

    @cached_property
    def _known_turns(self) -> dict[Combination, tuple[float, ...]]:
        """Turning points by their combination, as far as they were asked for."""
        return {}

    @abc.abstractmethod
    def _found_turns(self, combination: Combination) -> list[float]:
        """`turning_points`, not remembered yet."""

    def time_of(
        self, combination: Combination, amount: ArrayLike, begin: float, end: float
    ) -> Array:
        """Time at which a combination c_P P + c_Q Q of the loads has changed by `amount` since
        `begin`: the inverse of its change, in the shape of `amount`.

        Between `begin` and `end` the combination must not turn. Amounts outside its change give the
        nearer end. `begin` may be the later time: the result has most digits near it.

        Raises
        ------
        NotFoundError
            Where Newton's method finds no time, as of loads that are not finite.
        """
        change = np.asarray(amount, dtype=float)
        total_change = float(self.change_of(combination, end, begin))
        if abs(total_change) < LEAST:
            return np.full(change.shape, begin)
        growth = change * math.copysign(1.0, total_change)
        is_before = growth <= 0
        is_inside = ~(is_before | (growth >= abs(total_change)))
        time = np.where(is_before, begin, end)
        if np.any(is_inside):
            time_inside = self._time_inside(
                combination, change[is_inside], total_change, begin, end
            )
            time[is_inside] = np.minimum(np.maximum(time_inside, min(begin, end)), max(begin, end))
        return time

    def _time_inside(
        self, combination: Combination, change: Array, total_change: float, begin: float, end: float
    ) -> Array:
        """Times (n,) at which a monotonic combination of the loads has changed by given amounts
        since `begin`, by safeguarded Newton steps.

        Where a step leaves the bracket, or is no shorter than half the last one, the bracket is
        halved. The steps end where round-off stops them from gaining.

        Parameters
        ----------
        combination
            c_P, c_Q of c_P P + c_Q Q
        change
            (n,) amounts between 0 and the total change
        total_change
            change of the combination from `begin` to `end`

        Raises
        ------
        NotFoundError
            Where the steps do not end.
        """
        # The first guess is exact for a cosine that turns at both ends.
        time = begin + (end - begin) / math.pi * np.arccos(1 - 2 * change / total_change)
        by_plain_steps = self._by_plain_newton(combination, change, begin, end, time)
        if by_plain_steps is not None:
            return by_plain_steps
        direction = math.copysign(1.0, total_change) * math.copysign(1.0, end - begin)
        earliest_time = np.full(change.shape, min(begin, end))
        latest_time = np.full(change.shape, max(begin, end))
        best_time = time.copy()
        least_fault = np.full(change.shape, math.inf)
        steps_without_gain = np.zeros(change.shape, int)
        is_done = np.zeros(change.shape, bool)
        last_step = latest_time - earliest_time
        for _ in range(_MOST_STEPS):
            change_so_far, rate = self._change_and_rate(combination, time, begin)
            fault = direction * (change_so_far - change)
            size = np.abs(fault)
            is_better = size < least_fault
            np.copyto(best_time, time, where=is_better)
            np.copyto(least_fault, size, where=is_better)
            steps_without_gain = (steps_without_gain + 1) * ~is_better
            # Steps that gain no more are round-off where they are short: a long one is half a
            # bracket, and others follow.
            gains_no_more = (steps_without_gain >= _MOST_IDLE_STEPS) & (
                last_step <= _SHORT_STEP * np.abs(best_time - begin)
            )
            is_round_off = last_step <= _ROUNDING_OF_TIME * np.abs(best_time)
            # A time that is found stays so: below round-off a step may be long again.
            is_done |= (least_fault == 0) | gains_no_more | is_round_off
            if is_done.all():
                return best_time
            np.copyto(earliest_time, time, where=fault < 0)
            np.copyto(latest_time, time, where=fault > 0)
            slope = direction * rate
            step = np.full(change.shape, -math.inf)
            np.divide(-fault, slope, out=step, where=slope > 0)
            newton_time = time + step
            takes_newton_time = (
                (earliest_time <= newton_time)
                & (newton_time <= latest_time)
                & (2 * np.abs(newton_time - time) <= last_step)
            )
            next_time = np.where(takes_newton_time, newton_time, (earliest_time + latest_time) / 2)
            np.copyto(next_time, best_time, where=is_done)
            last_step = np.abs(next_time - time)
            time = next_time
        raise NotFoundError(
            f"no time was found at which the loads have changed as wanted, between {begin:.17g} and"
            f" {end:.17g}"
        )

    def _by_plain_newton(
        self, combination: Combination, change: Array, begin: float, end: float, guess: Array
    ) -> Array | None:
        """Times (n,) at which a monotonic combination of the loads has changed by given amounts
        since `begin`, by Newton steps without a safeguard: a third of the cost. None where these
        do not converge between `begin` and `end`.

        The error after a step is its square over the distance to the next turning point, which is
        at `begin`, at `end` or beyond. A step is the last where that error is below round-off.

        Parameters
        ----------
        combination
            c_P, c_Q of c_P P + c_Q Q
        change
            (n,) amounts between 0 and the change up to `end`
        guess
            (n,) first guesses of the times
        """
        time = guess
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for _ in range(_MOST_PLAIN_STEPS):
                change_so_far, rate = self._change_and_rate(combination, time, begin)
                step = (change - change_so_far) / rate
                time = time + step
                rounding = _ROUNDING_OF_TIME * np.abs(time)
                distance = np.minimum(np.abs(time - begin), np.abs(end - time))
                longest_last_step = np.sqrt(
                    rounding * np.maximum(distance / _ERROR_OF_STEP, rounding)
                )
                if (np.abs(step) <= longest_last_step).all():
                    is_between = (time - begin) * (end - time) >= 0
                    return time if is_between.all() else None
        return None

    def slope_and_bend(
        self,
        time: float,  # noqa: ARG002 most segments have none
    ) -> tuple[float, float] | None:
        """Slope dQ/dP and half of d2Q/dP2 at `time` where P is linear in time and Q(P) a line or a
        parabola; None elsewhere.
        """
        return None

    def mirrored(
        self,
        combination: Combination,  # noqa: ARG002 most segments have no mirrored time
        time: ArrayLike,  # noqa: ARG002
        near: float,  # noqa: ARG002
    ) -> Array | None:
        """The other time, next to `near`, at which a combination of one wave has the value that it
        has at `time`; else None.
        """
        return None

    def shifted(self, delay: float) -> Self:
        """The same segment, `delay` later."""
        bulk, turning = (part and part.shifted(delay) for part in (self.bulk, self.turning))
        return replace(
            self, start=self.start + delay, end=self.end + delay, bulk=bulk, turning=turning
        )


def _chosen(condition: Any, value_if_true: float, value_if_false: float) -> float:
    """`numpy.where` of one number, five times as fast."""
    return value_if_true if condition else value_if_false


def _float_or_array(time: Any) -> Any:
    """Times as they are if there is one, a float: arithmetic with arrays of no dimension takes
    three times as long.
    """
    return time if isinstance(time, float) else np.asarray(time, dtype=float)


@dataclass(frozen=True)
class StraightSegment(LoadSegment):
    """P and Q linear in time between two points of the P-Q plane."""

    first: Point
    last: Point

    @property
    def is_straight(self) -> bool:
        return True

    def loads(self, time: ArrayLike) -> Loads:
        # From the nearer end, so that both ends are met to the last digit.
        t = _float_or_array(time)
        near_start = t - self.start <= self.end - t
        nearer = _chosen if isinstance(t, float) else np.where
        part = (t - nearer(near_start, self.start, self.end)) / (self.end - self.start)
        p, q = (
            nearer(near_start, first_load, last_load) + (last_load - first_load) * part
            for first_load, last_load in zip(self.first, self.last, strict=True)
        )
        return p, q

    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        return self.change_of(combination, np.ones(np.shape(time)), 0.0)

    def change_of(self, combination: Combination, time: ArrayLike, time_before: ArrayLike) -> Array:
        part = (np.asarray(time, dtype=float) - np.asarray(time_before, dtype=float)) / (
            self.end - self.start
        )
        return combination[0] * ((self.last[0] - self.first[0]) * part) + combination[1] * (
            (self.last[1] - self.first[1]) * part
        )

    def companion_of(self, combination: Combination) -> StraightSegment:
        first_point, last_point = (
            (0.0, combination[0] * p + combination[1] * q) for p, q in (self.first, self.last)
        )
        return StraightSegment(self.start, self.end, first_point, last_point)

    def turning_points(
        self,
        combination: Combination,  # noqa: ARG002 a straight line does not turn
    ) -> list[float]:
        return []

    def _found_turns(self, combination: Combination) -> list[float]:
        return self.turning_points(combination)

    def _time_inside(
        self,
        combination: Combination,  # noqa: ARG002 a straight line whatever the combination is
        change: Array,
        total: float,
        begin: float,
        end: float,
    ) -> Array:
        return begin + (end - begin) * (change / total)

    def slope_and_bend(
        self,
        time: float,  # noqa: ARG002 the same all along
    ) -> tuple[float, float] | None:
        rise = self.last[0] - self.first[0]
        return ((self.last[1] - self.first[1]) / rise, 0.0) if rise else None


@dataclass(frozen=True)
class HarmonicSegment(LoadSegment):
    """P = P0 + sum of P_k cos(k t - phi_k), Q likewise; `normal`, `tangential` hold (amplitude,
    phase in radians) of k = 1, 2, ...

    Sums over k are polynomials in z = exp(i t). One wave, an ellipse, has closed forms with the
    phasor of the combination.
    """

    mean: Point
    normal: Waves
    tangential: Waves

    @cached_property
    def _coefficients(self) -> NDArray[np.complex128]:
        """Complex coefficients c_k of both loads, (2, m + 1): P - P0 and Q - Q0 are the real part
        of sum c_k exp(i k t); m is the highest harmonic with an amplitude.
        """
        order = max(
            (
                k
                for waves in (self.normal, self.tangential)
                for k, (size, _) in enumerate(waves, 1)
                if size
            ),
            default=1,
        )
        coefficients = np.zeros((2, order + 1), dtype=complex)
        for row, waves in zip(coefficients, (self.normal, self.tangential), strict=True):
            row[1 : len(waves) + 1] = [
                size * cmath.exp(-1j * phase) for size, phase in waves[:order]
            ]
        return coefficients

    @cached_property
    def ellipse(self) -> Ellipse | None:
        if self._coefficients.shape[1] > 2:
            return None
        (p, origin), (q, lag) = self._first
        return Ellipse(self.mean, (p, q), lag - origin, origin)

    @cached_property
    def _first(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """(amplitude, phase) of the first wave of P and of Q."""
        return self.normal[0] if self.normal else (0.0, 0.0), (
            self.tangential[0] if self.tangential else (0.0, 0.0)
        )

    def wave(self, combination: Combination) -> tuple[float, float]:
        """(size, lead) of one wave: the combination is a constant + size cos(t + lead)."""
        known_waves = self._known_waves
        if combination not in known_waves:
            known_waves[combination] = self._sum_of_waves(combination)
        return known_waves[combination]

    @cached_property
    def _known_waves(self) -> dict[Combination, tuple[float, float]]:
        """`wave` by its combination, as far as it was asked for."""
        return {}

    def _sum_of_waves(self, combination: Combination) -> tuple[float, float]:
        """Size and lead of a combination c_P P + c_Q Q of the loads where each has one harmonic:
        it is a constant plus size cos(t + lead). Sum of the two phasors.
        """
        # One load alone keeps the last digit of its phase.
        (normal_amplitude, normal_lag), (tangential_amplitude, tangential_lag) = self._first
        if combination[0] == 0 or combination[1] == 0:
            return (
                (combination[0] * normal_amplitude, -normal_lag)
                if combination[1] == 0
                else (combination[1] * tangential_amplitude, -tangential_lag)
            )
        return cmath.polar(
            combination[0] * cmath.rect(normal_amplitude, -normal_lag)
            + combination[1] * cmath.rect(tangential_amplitude, -tangential_lag)
        )

    @property
    def most_turns(self) -> int:
        order = self._coefficients.shape[1] - 1 if np.any(self._coefficients) else 0
        return 2 * order * math.ceil((self.end - self.start) / (2 * math.pi))

    def loads(self, time: ArrayLike) -> Loads:
        """Loads P and Q at any times, each in the shape of `time`: mean plus sum of harmonics; of
        an ellipse, with one harmonic each, by cosines.
        """
        mean_normal, mean_tangential = self.mean
        if self.ellipse:
            times = _float_or_array(time)
            (normal_amplitude, normal_lag), (tangential_amplitude, tangential_lag) = self._first
            return (
                mean_normal + normal_amplitude * np.cos(times - normal_lag),
                mean_tangential + tangential_amplitude * np.cos(times - tangential_lag),
            )
        times = np.atleast_1d(np.asarray(time, dtype=float))
        unit_rotation = np.exp(1j * times)
        normal_terms, tangential_terms = self._wave_terms
        normal_load = mean_normal + _wave_sum_at(normal_terms, unit_rotation, times)
        tangential_load = mean_tangential + _wave_sum_at(tangential_terms, unit_rotation, times)
        shape = np.shape(time)
        return normal_load.reshape(shape), tangential_load.reshape(shape)

    @cached_property
    def _wave_terms(self) -> tuple[WaveTerms, WaveTerms]:
        """The terms of P and of Q."""
        of_normal, of_tangential = self._coefficients
        return _terms(of_normal), _terms(of_tangential)

    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        if self.ellipse:
            size, lead = self.wave(combination)
            rate: Array = -size * np.sin(_float_or_array(time) + lead)
            return rate
        _, rate_terms = self._series_of(combination)
        return _wave_sum(rate_terms, np.asarray(time, dtype=float))

    def _series_of(self, combination: Combination) -> tuple[tuple[complex, ...], WaveTerms]:
        """Coefficients c_k of a combination, k from 0 on, and the terms of its rate."""
        known_series = self._known_series
        if combination not in known_series:
            coefficients = np.array(combination) @ self._coefficients
            rate_terms = _terms(self._rate(combination))
            known_series[combination] = tuple(coefficients.tolist()), rate_terms
        return known_series[combination]

    @cached_property
    def _known_series(
        self,
    ) -> dict[Combination, tuple[tuple[complex, ...], WaveTerms]]:
        """`_series_of` by its combination, as far as it was asked for."""
        return {}

    def _rate(self, combination: Combination) -> NDArray[np.complex128]:
        """(m + 1,) coefficients of the rate."""
        return (
            1j
            * np.arange(self._coefficients.shape[1])
            * (np.array(combination) @ self._coefficients)
        )

    def change_of(self, combination: Combination, time: ArrayLike, time_before: ArrayLike) -> Array:
        """Change of a combination c_P P + c_Q Q of the loads from `time_before` to `time`, without
        loss of digits over short times: by sines of half the time between.

        Of one wave size cos(t + lead) it is -2 size sin(middle + lead) sin(half step).
        """
        end_time = _float_or_array(time)
        begin_time = _float_or_array(time_before)
        half_step = (end_time - begin_time) / 2
        if self.ellipse:
            middle = (end_time + begin_time) / 2
            size, lead = self.wave(combination)
            change: Array = -2 * size * np.sin(middle + lead) * np.sin(half_step)
            return change
        half_turn = np.exp(1j * np.atleast_1d(half_step))
        change = self._change_between(combination, _unit_vector(begin_time), half_turn)
        return change.reshape(np.shape(half_step))

    def _change_between(
        self,
        combination: Combination,
        z_before: complex | NDArray[np.complex128],
        half_turn: NDArray[np.complex128],
    ) -> Array:
        """Change (n,) of a combination c_P P + c_Q Q of the loads from time t_0 to t, as the change
        of a polynomial f in z = exp(i t), without loss of digits over short times.

        Horner's scheme gives (f(z) - f(z_0))/(z - z_0), which is multiplied by z - z_0 =
        2i sin((t - t_0)/2) exp(i (t + t_0)/2).

        Parameters
        ----------
        z_before
            z_0 = exp(i t_0), one number or (n,)
        half_turn
            (n,) exp(i (t - t_0)/2)
        """
        coefficients, _ = self._series_of(combination)
        *lower_terms, highest_term = coefficients
        if not lower_terms:
            return np.zeros(half_turn.shape)
        centre = half_turn * z_before
        z = half_turn * centre
        quotient: Any = highest_term
        value: Any = highest_term * z_before + lower_terms[-1]
        for coefficient in reversed(lower_terms[:-1]):
            quotient = quotient * z + value
            value = value * z_before + coefficient
        change: Array = (quotient * centre * (2j * half_turn.imag)).real
        return change

    def _change_and_rate(
        self, combination: Combination, time: Array, time_before: float
    ) -> tuple[Array, Array]:
        if self.ellipse:
            return super()._change_and_rate(combination, time, time_before)
        z_before = _unit_vector(time_before)
        half_turn = np.exp(0.5j * (time - time_before))
        _, rate_terms = self._series_of(combination)
        change = self._change_between(combination, z_before, half_turn)
        return change, _wave_sum_at(rate_terms, half_turn * half_turn * z_before, time)

    def companion_of(self, combination: Combination) -> HarmonicSegment:
        """A segment over the same time whose first load is 0, and whose second is a combination
        c_P P + c_Q Q of this segment's loads: a moment that follows from P and Q, for one.
        """
        waves = tuple(
            (abs(coefficient), -cmath.phase(coefficient))
            for coefficient in (np.array(combination) @ self._coefficients)[1:].tolist()
        )
        return HarmonicSegment(
            self.start,
            self.end,
            (0.0, combination[0] * self.mean[0] + combination[1] * self.mean[1]),
            (),
            waves,
        )

    def _found_turns(self, combination: Combination) -> list[float]:
        """Turning points of a combination c_P P + c_Q Q of the loads: times inside the segment at
        which it has an extreme, ascending.

        One wave has them where its argument is a multiple of pi. Of several waves the rate is a
        polynomial in z = exp(i time), whose roots on the unit circle are improved by Newton steps.

        >>> segment = HarmonicSegment(0.0, 2 * math.pi, (3.0, 0.0), ((1.0, 0.0), (1.0, 0.0)), ())
        >>> [
        ...     round(time / math.pi, 4) for time in segment.turning_points(NORMAL_LOAD)
        ... ]  # sin t (1 + 4 cos t) = 0
        [0.5804, 1.0, 1.4196]
        """
        size = np.abs(combination) @ np.abs(self._coefficients)
        if self.ellipse:
            height, lead = self.wave(combination)
            if abs(height) <= _ROUNDING * size[1]:  # constant but for rounding
                return []
            first_multiple = math.ceil((self.start + lead) / math.pi)
            last_multiple = math.floor((self.end + lead) / math.pi)
            extremes = [k * math.pi - lead for k in range(first_multiple, last_multiple + 1)]
            return [time for time in extremes if self.start < time < self.end]
        rates = self._rate(combination)
        rate_size = float(np.arange(len(size)) @ size)
        rates[np.abs(rates) <= _ROUNDING * rate_size] = 0
        if rate_size < LEAST or not np.any(rates):
            return []
        order = int(np.flatnonzero(rates)[-1])
        roots = polynomial.polyroots(
            np.concatenate([np.conj(rates[order:0:-1]), rates[: order + 1]])
        )
        angles = np.angle(roots[np.abs(np.abs(roots) - 1) < _DISTANCE_OF_DOUBLE_ROOTS])
        period = 2 * math.pi
        first_times = angles + period * np.floor((self.start - angles) / period)
        n_periods = math.ceil((self.end - self.start) / period) + 2
        times = first_times[:, None] + period * np.arange(n_periods)
        return _sharpened(self, combination, times.ravel())

    def _time_inside(
        self,
        combination: Combination,
        change: Array,
        total_change: float,
        begin: float,
        end: float,
    ) -> Array:
        """Times (n,) at which a monotonic combination of the loads has changed by given amounts
        since `begin`: of an ellipse in closed form by the arc cosine, else by Newton steps.

        Parameters
        ----------
        combination
            c_P, c_Q of c_P P + c_Q Q
        change
            (n,) amounts between 0 and the total change
        total_change
            change of the combination from `begin` to `end`
        """
        if not self.ellipse:
            return super()._time_inside(combination, change, total_change, begin, end)
        # The arc cosine loses digits near an extreme: one Newton step with the change gains them.
        size, lead = self.wave(combination)
        half_turn = math.floor(((begin + end) / 2 + lead) / math.pi)
        sign = -1.0 if half_turn % 2 else 1.0
        cosine = sign * (math.cos(begin + lead) + change / size)
        time = half_turn * math.pi - lead + np.arccos(np.minimum(np.maximum(cosine, -1), 1))
        rate_at_time = self.rate_of(combination, time)
        is_steep = np.abs(rate_at_time) > 1e-6 * abs(size)
        change_error = change - self.change_of(combination, time, begin)
        return time + np.where(is_steep, change_error / np.where(is_steep, rate_at_time, 1.0), 0.0)

    def mirrored(self, combination: Combination, time: ArrayLike, near: float) -> Array | None:
        if not self.ellipse:
            return None
        twin = -2 * self.wave(combination)[1] - np.asarray(time, dtype=float)
        return twin + 2 * math.pi * np.round((near - twin) / (2 * math.pi))

    def shifted(self, delay: float) -> Self:
        """The same loads, `delay` later in time: the phase of the k-th harmonic grows by k times
        the delay.
        """
        delay_angle = math.remainder(delay, 2 * math.pi)
        # By whole revolutions, but for round-off, the phases stay.
        if abs(delay_angle) <= 1e-15 * abs(delay):
            return super().shifted(delay)

        def later(waves: Waves) -> Waves:
            """Harmonics whose phases grow by k times the delay."""
            phase_changes = [
                math.remainder(k * delay_angle, 2 * math.pi) for k in range(1, len(waves) + 1)
            ]
            return tuple(
                (size, phase + turn)
                for (size, phase), turn in zip(waves, phase_changes, strict=True)
            )

        return replace(
            super().shifted(delay), normal=later(self.normal), tangential=later(self.tangential)
        )


@dataclass(frozen=True)
class ChebyshevSegment(LoadSegment):
    """P and Q as Chebyshev series of u in [-1, 1], u growing with time from start to end."""

    normal: tuple[float, ...]
    tangential: tuple[float, ...]

    @property
    def most_turns(self) -> int:
        return max(len(self.normal), len(self.tangential), 2) - 2

    def _unit(self, time: ArrayLike) -> Any:
        t = _float_or_array(time)
        return ((t - self.start) - (self.end - t)) / (self.end - self.start)

    @cached_property
    def _series(self) -> Array:
        """(2, m) coefficients of both loads."""
        coefficients = np.zeros((2, max(len(self.normal), len(self.tangential), 2)))
        coefficients[0, : len(self.normal)] = self.normal
        coefficients[1, : len(self.tangential)] = self.tangential
        return coefficients

    @cached_property
    def _from_zero(self) -> tuple[bool, bool]:
        """Whether P, and Q, start from 0."""
        p, q = np.abs(chebyshev.chebval(-1.0, self._series.T)) <= _ROUNDING_OF_SUM * np.sum(
            np.abs(self._series), axis=1
        )
        return bool(p), bool(q)

    def loads(self, time: ArrayLike) -> Loads:
        """Loads P and Q at any times, each in the shape of `time`.

        A load that starts from 0 is computed as its change since the start, which keeps its digits
        near there.
        """
        normal_load, tangential_load = (
            (
                self.change_of(combination, time, self.start)
                if from_zero
                else np.asarray(chebyshev.chebval(self._unit(time), series))
            )
            for combination, series, from_zero in zip(
                (NORMAL_LOAD, TANGENTIAL_LOAD), self._series, self._from_zero, strict=True
            )
        )
        return normal_load, tangential_load

    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        _, slope = self._series_of(combination)
        return np.asarray(
            chebyshev.chebval(self._unit(time), slope) * (2 / (self.end - self.start))
        )

    def _series_of(self, combination: Combination) -> tuple[Array, Array]:
        """Series of a combination, and that of its derivative by u."""
        known_series = self._known_series
        if combination not in known_series:
            series = np.array(combination) @ self._series
            known_series[combination] = series, np.asarray(chebyshev.chebder(series))
        return known_series[combination]

    @cached_property
    def _known_series(self) -> dict[Combination, tuple[Array, Array]]:
        """`_series_of` by its combination, as far as it was asked for."""
        return {}

    def change_of(self, combination: Combination, time: ArrayLike, time_before: ArrayLike) -> Array:
        t = _float_or_array(time)
        t0 = _float_or_array(time_before)
        series, _ = self._series_of(combination)
        step = 2 * (t - t0) / (self.end - self.start)
        change: Array = np.multiply(difference(series, self._unit(t), self._unit(t0)), step)
        return change

    def companion_of(self, combination: Combination) -> ChebyshevSegment:
        return ChebyshevSegment(
            self.start, self.end, (0.0,), tuple((np.array(combination) @ self._series).tolist())
        )

    def _found_turns(self, combination: Combination) -> list[float]:
        """Turning points of a combination c_P P + c_Q Q of the loads: times inside the segment at
        which its rate is zero, ascending, as roots of a Chebyshev series.

        >>> segment = ChebyshevSegment(
        ...     0.0, 4.0, (3.0, 0.0, 1.0), (0.0, 1.0)
        ... )  # P = 2 + 2 (t/2 - 1)^2
        >>> segment.turning_points(NORMAL_LOAD)
        [2.0]
        """
        _, rate_series = self._series_of(combination)
        series_size = float(np.abs(combination) @ np.max(np.abs(self._series), axis=1))
        significant_orders = np.flatnonzero(np.abs(rate_series) > _ROUNDING * series_size)
        if not len(significant_orders) or significant_orders[-1] == 0:
            return []
        rate_series = rate_series[: significant_orders[-1] + 1]
        roots = chebyshev.chebroots(rate_series)
        places_of_turns = np.clip(
            roots.real[
                (np.abs(roots.imag) < _DISTANCE_OF_DOUBLE_ROOTS)
                & (np.abs(roots.real) < 1 + _DISTANCE_OF_DOUBLE_ROOTS)
            ],
            -1,
            1,
        )
        return _sharpened(
            self,
            combination,
            (self.start + self.end) / 2 + (self.end - self.start) / 2 * places_of_turns,
        )

    @property
    def is_straight(self) -> bool:
        return not np.any(self._series[:, 2:])

    def slope_and_bend(self, time: float) -> tuple[float, float] | None:
        (_, rise, *curving), (_, first, *higher) = self._series.tolist()
        if not rise or any(curving) or any(higher[1:]):
            return None
        second_coefficient = higher[0] if higher else 0.0
        return (
            first + 4 * second_coefficient * float(self._unit(time))
        ) / rise, 2 * second_coefficient / rise**2


@dataclass(frozen=True)
class LoadPath:
    """The initial loading from (0, 0), then a cycle that repeats for ever (or nothing more, where
    `cycle` is empty).
    """

    initial_loading: tuple[LoadSegment, ...]
    cycle: tuple[LoadSegment, ...]
    moment_given: bool = False
    """Whether the segments' `turning` states the moment, from which the tilt follows, and not the
    tilt.
    """

    @property
    def has_bulk_or_tilt(self) -> bool:
        """Whether segments carry bulk stresses, tilt or moment along with P and Q."""
        return any(
            leg.bulk is not None or leg.turning is not None
            for leg in (*self.initial_loading, *self.cycle)
        )

    @property
    def start(self) -> float:
        """Time of the unloaded state."""
        return self.initial_loading[0].start

    @property
    def cycle_start(self) -> float:
        """Time at which the initial loading ends and the first cycle starts."""
        return self.initial_loading[-1].end

    @property
    def period(self) -> float | None:
        """Duration of a cycle; None for a path that is not periodic."""
        return self.cycle[-1].end - self.cycle[0].start if self.cycle else None

    def legs(self, cycles: int) -> Iterator[LoadSegment]:
        """The initial loading, then `cycles` revolutions."""
        yield from self.initial_loading
        for number in range(cycles):
            yield from self.cycle_legs(number)

    def cycle_legs(self, number: int) -> tuple[LoadSegment, ...]:
        """The legs of revolution `number`, counted from 0."""
        return tuple(leg.shifted(number * (self.period or 0.0)) for leg in self.cycle)

    def companion(self, name: str) -> LoadPath | None:
        """What all segments carry as `bulk` or `turning`, as a path of its own; None where one of
        them carries nothing.
        """
        loading = [getattr(leg, name) for leg in self.initial_loading]
        cycle = [getattr(leg, name) for leg in self.cycle]
        return None if None in (*loading, *cycle) else LoadPath(tuple(loading), tuple(cycle))

    def at(self, time: ArrayLike) -> Loads:
        """Loads P and Q at any times, each in the shape of `time`; after the first cycle those of
        its repetitions.

        Raises
        ------
        ValueError
            For times outside the path.
        """
        path_time = np.atleast_1d(np.asarray(time, dtype=float))
        if self.period is not None:
            is_after_cycle = path_time > self.cycle_start + self.period
            path_time = np.where(
                is_after_cycle,
                self.cycle_start + np.mod(path_time - self.cycle_start, self.period),
                path_time,
            )
        legs = (*self.initial_loading, *self.cycle)
        if np.any(path_time < legs[0].start) or np.any(path_time > legs[-1].end):
            raise ValueError(
                f"time outside the load path, which runs from {legs[0].start} to {legs[-1].end}"
            )
        ends_of_legs = np.array([leg.end for leg in legs])
        number_of_leg = np.minimum(
            np.searchsorted(ends_of_legs, path_time, side="left"), len(legs) - 1
        )
        loads = np.empty((2, *path_time.shape))
        for k in np.unique(number_of_leg):
            loads[:, number_of_leg == k] = legs[k].loads(path_time[number_of_leg == k])
        normal_load, tangential_load = loads.reshape(2, *np.shape(time))
        return normal_load, tangential_load


def _terms(coefficients: NDArray[np.complex128]) -> WaveTerms:
    """Prepare a sum of c_k exp(i k t) for Horner's scheme: its terms from the highest k down, each
    as c_k and by how much k is below that of the term before.

    `coefficients` (m + 1,) are c_0, c_1, ...
    """
    terms = []
    order_above = len(coefficients) - 1
    # Waves without an amplitude are passed over: one of a thousand harmonics may be all there is.
    for k in [*(np.flatnonzero(coefficients[1:])[::-1] + 1).tolist(), 0]:
        terms.append((complex(coefficients[k]), order_above - k))
        order_above = k
    return tuple(terms)


def _unit_vector(time: float | Array) -> Any:
    """exp(i t) of one time, a number without a shape, or of times (n,)."""
    return cmath.exp(1j * time) if isinstance(time, float) else np.exp(1j * np.atleast_1d(time))


def _wave_sum(terms: WaveTerms, time: Array) -> Array:
    """Re[sum c_k exp(i k t)], shape of t."""
    # Never a number without a shape: the last digit of its products is another one.
    t = np.atleast_1d(time)
    return np.reshape(_wave_sum_at(terms, np.exp(1j * t), t), np.shape(time))


def _wave_sum_at(terms: WaveTerms, z: NDArray[np.complex128], time: Array) -> Array:
    """Real part of sum c_k z^k at n times t, (n,), with z = exp(i t), by Horner's scheme.

    `terms` are (c_k, step in k from the term before), from the highest k down; `z` and `time` are
    (n,).
    """
    (highest, _), *lower_terms = terms
    if not lower_terms:
        return np.full(z.shape, highest.real)
    value: Any = highest
    for coefficient, step in lower_terms:
        power = z if step == 1 else np.exp(1j * step * time)
        value = value * power + coefficient
    sums: Array = value.real
    return sums


def _sharpened(segment: LoadSegment, combination: Combination, guessed_times: Array) -> list[float]:
    """Improve guessed turning points of a combination c_P P + c_Q Q of the loads by two Newton
    steps, each taken if it is small: times inside the segment, ascending.
    """
    times = guessed_times
    step = 1e-6 * (segment.end - segment.start)
    longest_step = _DISTANCE_OF_DOUBLE_ROOTS * (segment.end - segment.start) / 2
    for _ in range(2):
        rate, rate_after = segment.rate_of(combination, np.stack([times, times + step]))
        newton_step = rate * step / np.where(rate_after != rate, rate_after - rate, np.inf)
        times = times - np.where(np.abs(newton_step) < longest_step, newton_step, 0.0)
    return sorted(time for time in times.tolist() if segment.start < time < segment.end)


def straight_segments(rows: Iterable[Sequence[float]]) -> tuple[StraightSegment, ...]:
    """Straight segments of a load path from each of the `rows` (time, P, Q) to the next.

    >>> [
    ...     segment.last
    ...     for segment in straight_segments([(0.0, 0.0, 0.0), (1.0, 2.0, 0.5), (3.0, 2.0, 0.0)])
    ... ]
    [(2.0, 0.5), (2.0, 0.0)]
    """
    return tuple(
        StraightSegment(start, end, (p, q), (p_end, q_end))
        for (start, p, q), (end, p_end, q_end) in pairwise(rows)
    )


def ellipse_segment(
    start: float, end: float, mean: Point, amplitude: Point, phase_radians: float
) -> HarmonicSegment:
    """P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase_radians)."""
    normal_waves = ((amplitude[0], 0.0),)
    tangential_waves = ((amplitude[1], phase_radians),)
    return HarmonicSegment(start, end, mean, normal_waves, tangential_waves)


def parabola_segment(
    start: float, end: float, last_point: Point, end_slope: float
) -> ChebyshevSegment:
    """Segment of a load path on a parabola in the P-Q plane from (0, 0) to `last_point` (P, Q): P
    is linear in time, and Q = alpha P + beta P^2 has the slope dQ/dP = `end_slope` at the end.

    `start` and `end` are times.

    >>> segment = parabola_segment(0.0, 2.0, (1.0, 0.5), 0.0)
    >>> [float(load) for load in segment.loads(1.0)], segment.slope_and_bend(2.0)
    ([0.5, 0.375], (0.0, -0.5))
    """
    # notation: w from 0 at the start to 1 at the end, u = 2 w - 1 the variable of the series
    p, q = last_point
    linear_part = 2 * q - end_slope * p  # Q = linear_part w + square_part w^2
    square_part = end_slope * p - q
    normal_series = (p / 2, p / 2)
    tangential_series = (
        linear_part / 2 + 3 * square_part / 8,
        (linear_part + square_part) / 2,
        square_part / 8,
    )
    return ChebyshevSegment(start, end, normal_series, tangential_series)


def sampled(segment: LoadSegment, least_count: int) -> Array:
    """Times along a segment of a load path that are dense enough to see its turning points: the two
    ends of a straight one, else `least_count`, or eight for each turning point if that is more.

    >>> (
    ...     len(sampled(StraightSegment(0.0, 1.0, (0.0, 0.0), (3.0, 1.0)), 25)),
    ...     len(sampled(ellipse_segment(0.0, 6.28, (3, 1), (1, 1), 0.5), 25)),
    ... )
    (2, 25)
    """
    count = max(least_count, 8 * segment.most_turns + 1) if segment.most_turns else 2
    return np.linspace(segment.start, segment.end, count)


# Of the largest P of a segment: a load below this share of it is zero.
_ZERO_LOAD = 1e-12


def largest_ratio(legs: Iterable[LoadSegment]) -> float:
    """Largest |Q|/P along segments of a load path; infinite where P is negative, or zero while Q is
    not.

    Dinkelbach's iteration: where Q - r P or -Q - r P is largest, |Q|/P exceeds r, unless r is the
    largest ratio itself. These combinations are largest at ends and turning points.

    # notation: r ratio reached so far

    >>> largest_ratio([StraightSegment(0.0, 1.0, (1.0, 0.0), (2.0, -1.0))])
    0.5
    """
    ratio = 0.0
    for leg in legs:
        fixed_times = [leg.start, leg.end, *leg.turning_points(NORMAL_LOAD)]
        while True:
            forward = leg.turning_points(Combination(-ratio, 1.0))
            reverse = leg.turning_points(Combination(ratio, 1.0))
            ratio_at_times = largest_ratio_of(
                *leg.loads(np.array([*fixed_times, *forward, *reverse]))
            )
            if not ratio_at_times > ratio * (1 + 1e-15):
                break
            ratio = ratio_at_times
            if math.isinf(ratio):
                return ratio
    return ratio


def largest_ratio_of(normal_load: Array, tangential_load: Array) -> float:
    """Largest |Q|/P of n instants, P and Q (n,): 0 where both are zero, infinite where P is
    negative, or zero while Q is not. Loads below 1e-12 of the largest P count as zero.
    """
    negligible_load = _ZERO_LOAD * np.max(np.abs(normal_load))
    shear_force = np.abs(tangential_load)
    shear_force = np.where(shear_force <= negligible_load, 0.0, shear_force)
    if np.any(normal_load < -negligible_load):
        return math.inf
    is_pressed = normal_load > negligible_load
    if np.any(shear_force[~is_pressed] > 0):
        return math.inf
    return float(np.max(shear_force[is_pressed] / normal_load[is_pressed], initial=0.0))
