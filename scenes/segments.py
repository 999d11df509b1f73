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
from scenes.chebyshev import divided_difference
from scenes.errors import NotFoundError

Loads = tuple[Array, Array]
Point = tuple[
    Annotated[float, Field(description="normal load P")],
    Annotated[float, Field(description="tangential load Q")],
]
Waves = tuple[tuple[float, float], ...]
WaveTerms = tuple[tuple[complex, int], ...]

LEAST_LOAD_CHANGE = 1e-290
"""Changes of load below it count as none: their inverse overflows, and smaller numbers lose digits.
"""

# Of the largest coefficient of a series: smaller ones are round-off.
_ROUND_OFF_SHARE = 1e-14
# Of a time: smaller differences are round-off.
_ROUND_OFF_SHARE_OF_TIME = 4.5e-16
# Of the largest sum of a series: what rounding of its coefficients leaves of a load that starts
# from 0.
_ROUND_OFF_SHARE_OF_SUM = 1e-15
# A double root is known to the root of a rounding only. Taking too many does no harm: a segment is
# cut in two.
_DISTANCE_OF_DOUBLE_ROOTS = 1e-5
# Steps of Newton's method with a bracket: some 60 halve the bracket to rounding, and some 60 the
# step between two of these.
_MOST_BRACKETED_STEPS = 4000
# Steps of Newton's method without a bracket: four or five are taken.
_MOST_PLAIN_STEPS = 12
# Of a step squared over the distance of a turning point, what it leaves: a half where the rate goes
# as the distance, and room.
_ERROR_OVER_SQUARED_STEP = 4.0
# Steps without gain after which rounding is reached, where they are shorter than this share of the
# way.
_MOST_IDLE_STEPS = 3
_SHORT_STEP_SHARE = 1e-9


class Combination(NamedTuple):
    """A linear combination c_P P + c_Q Q of the two loads: `normal` is c_P, `tangential` c_Q."""

    normal: float
    tangential: float


NORMAL_LOAD = Combination(1.0, 0.0)
TANGENTIAL_LOAD = Combination(0.0, 1.0)


class Ellipse(NamedTuple):
    """P = P0 + P1 cos(t - origin), Q = Q0 + Q1 cos(t - origin - phase_radians): equations (3) and
    (4) of the paper with omega = 1.

    `mean` is (P0, Q0), `amplitude` (P1, Q1) [force per thickness]; `origin` is a time at which the
    cosine of P is 1. Times are angles in radians: the period is 2 pi.
    """

    mean: Point
    amplitude: Point
    phase_radians: float
    origin: float

    def time_of_largest(self, combination: Combination) -> float:
        """Time [rad] at which a combination c_P P + c_Q Q of the loads on this ellipse is largest,
        as it is again every 2 pi later.

        The ellipse is P = P0 + P1 cos(t - origin), Q = Q0 + Q1 cos(t - origin - phase_radians), and
        its `amplitude` is (P1, Q1). The combination is a constant plus the real part of
        F exp(i (t - origin)), F the sum of the phasors of c_P P and c_Q Q. It is largest where
        t - origin is minus the phase of F.

        Parameters
        ----------
        combination
            (c_P, c_Q), under the names `normal` and `tangential`

        Examples
        --------
        >>> Ellipse((3.0, 0.0), (1.0, 1.0), math.pi / 2, 0.0).time_of_largest(
        ...     TANGENTIAL_LOAD
        ... ) == math.pi / 2
        True
        """
        normal_amplitude, tangential_amplitude = self.amplitude
        direction_of_q = cmath.exp(-1j * self.phase_radians)
        normal_phasor = combination.normal * normal_amplitude
        tangential_phasor = combination.tangential * tangential_amplitude * direction_of_q
        return self.origin - cmath.phase(normal_phasor + tangential_phasor)


@dataclass(eq=False)
class _BracketedSearch:
    """Search for n times by Newton steps, each kept in a bracket between two times: the state of
    the iteration, (n,) each.

    The iteration ends where round-off keeps the error from falling.

    Attributes
    ----------
    time
        the iterates
    earliest_time, latest_time
        the ends of the brackets
    best_time, least_error, n_idle_steps
        the iterate with the least |error| so far, that error, and how many steps since have brought
        no smaller one
    is_converged
        whether `best_time` is the time looked for
    last_step_length
        length of the last step
    begin
        the time from which digits count: steps are short against the distance from it
    """

    time: Array
    earliest_time: Array
    latest_time: Array
    best_time: Array
    least_error: Array
    n_idle_steps: NDArray[np.int64]
    is_converged: NDArray[np.bool_]
    last_step_length: Array
    begin: float

    @classmethod
    def between(cls, begin: float, end: float, first_guess: Array) -> _BracketedSearch:
        """A new search for n times between two times, from first guesses (n,); `begin` may be the
        later one.

        Each time has a bracket, from `earliest_time` to `latest_time`, at first the whole interval.
        The best time so far is the first guess, its error not yet known (infinite); the last step
        counts as long as the bracket.
        """
        earliest_time = np.full(first_guess.shape, min(begin, end))
        latest_time = np.full(first_guess.shape, max(begin, end))
        return cls(
            time=first_guess,
            earliest_time=earliest_time,
            latest_time=latest_time,
            best_time=first_guess.copy(),
            least_error=np.full(first_guess.shape, math.inf),
            n_idle_steps=np.zeros(first_guess.shape, int),
            is_converged=np.zeros(first_guess.shape, bool),
            last_step_length=latest_time - earliest_time,
            begin=begin,
        )

    def update_best_times(self, signed_error: Array) -> None:
        """Replace the best times so far where an iterate has a smaller error, and mark those times
        that have converged.

        Short steps without a smaller error are round-off. After a long one, which halves a bracket,
        steps with a smaller error follow. `signed_error` (n,) are the errors of the iterates,
        positive where a time is too late.
        """
        absolute_error = np.abs(signed_error)
        is_improved = absolute_error < self.least_error
        np.copyto(self.best_time, self.time, where=is_improved)
        np.copyto(self.least_error, absolute_error, where=is_improved)
        self.n_idle_steps = (self.n_idle_steps + 1) * ~is_improved
        # _MOST_IDLE_STEPS, _SHORT_STEP_SHARE: 3 steps, and 1e-9 of the time since `begin`
        has_stalled = (self.n_idle_steps >= _MOST_IDLE_STEPS) & (
            self.last_step_length <= _SHORT_STEP_SHARE * np.abs(self.best_time - self.begin)
        )
        # _ROUND_OFF_SHARE_OF_TIME: 4.5e-16 of the time
        is_round_off = self.last_step_length <= _ROUND_OFF_SHARE_OF_TIME * np.abs(self.best_time)
        # A time that has converged stays so: below round-off a step may be long again.
        self.is_converged |= (self.least_error == 0) | has_stalled | is_round_off

    def take_step(self, signed_error: Array, error_rate: Array) -> None:
        """Shrink the brackets and go to the next iterates, by Newton's step or to the middle of the
        bracket. Newton's step is taken where it stays in the bracket and is at most half as long as
        the last step.

        The bracket of each of n times goes from `earliest_time` to `latest_time`. `signed_error`
        (n,) are the errors of the iterates `time`, positive where a time is too late, and
        `error_rate` (n,) their derivatives in time. Times that have converged stay at `best_time`.
        """
        np.copyto(self.earliest_time, self.time, where=signed_error < 0)
        np.copyto(self.latest_time, self.time, where=signed_error > 0)
        newton_step = np.full(self.time.shape, -math.inf)
        np.divide(-signed_error, error_rate, out=newton_step, where=error_rate > 0)
        newton_time = self.time + newton_step
        takes_newton_time = (
            (self.earliest_time <= newton_time)
            & (newton_time <= self.latest_time)
            & (2 * np.abs(newton_time - self.time) <= self.last_step_length)
        )
        middle_time = (self.earliest_time + self.latest_time) / 2
        next_time = np.where(takes_newton_time, newton_time, middle_time)
        np.copyto(next_time, self.best_time, where=self.is_converged)
        self.last_step_length = np.abs(next_time - self.time)
        self.time = next_time


@dataclass(frozen=True)
class LoadSegment(abc.ABC):
    """A smooth piece of a load path on start <= t <= end; times may have any shape, and results
    have the shape of the times.

    Attributes
    ----------
    bulk
        bulk stresses over the same time: that of the lower body in place of P, of the upper in
        place of Q; None without bulk stress
    tilt_and_moment
        tilt in place of P and moment in place of Q over the same time, one of them 0
        throughout; None where neither is stated
    """

    start: float
    end: float
    bulk: LoadSegment | None = field(default=None, kw_only=True)
    tilt_and_moment: LoadSegment | None = field(default=None, kw_only=True)

    @property
    def is_straight(self) -> bool:
        """Whether P and Q are linear in time."""
        return False

    @property
    def most_turning_points(self) -> int:
        """Upper bound of the number of turning points inside the segment of P, Q or a weighted sum
        of both; 0 of a straight one.
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
        known_turning_points = self._known_turning_points
        if combination not in known_turning_points:
            known_turning_points[combination] = tuple(self._find_turning_points(combination))
        return list(known_turning_points[combination])

    @cached_property
    def _known_turning_points(self) -> dict[Combination, tuple[float, ...]]:
        """Turning points by their combination, as far as they were asked for."""
        return {}

    @abc.abstractmethod
    def _find_turning_points(self, combination: Combination) -> list[float]:
        """`turning_points` of a combination that are not cached yet."""

    def time_of(
        self, combination: Combination, amount: ArrayLike, begin: float, end: float
    ) -> Array:
        """Time, in the shape of `amount`, at which a combination c_P P + c_Q Q of the loads has
        changed by `amount` since `begin`: the inverse function of its change over time.

        Between `begin` and `end` the combination must be monotonic. An amount of 0, or of the
        opposite sign to its change, gives `begin`; one beyond the change up to `end` gives `end`. A
        constant combination gives `begin`. `begin` may be the later time: the returned time has
        most digits near it.

        Parameters
        ----------
        combination
            (c_P, c_Q)
        amount
            changes of the combination [force per thickness], any shape
        begin, end
            two times of the segment

        Raises
        ------
        NotFoundError
            Where Newton's method does not converge, as for loads that are not finite.
        """
        wanted_change = np.asarray(amount, dtype=float)
        total_change = float(self.change_of(combination, end, begin))
        if abs(total_change) < LEAST_LOAD_CHANGE:  # below 1e-290: the combination is constant
            return np.full(wanted_change.shape, begin)
        change_towards_end = wanted_change * math.copysign(1.0, total_change)
        is_before_begin = change_towards_end <= 0
        lies_between = ~(is_before_begin | (change_towards_end >= abs(total_change)))
        time = np.where(is_before_begin, begin, end)
        if np.any(lies_between):
            # Times (n,) of the amounts between 0 and the total change.
            time_inside = self._time_inside(
                combination, wanted_change[lies_between], total_change, begin, end
            )
            time[lies_between] = np.minimum(
                np.maximum(time_inside, min(begin, end)), max(begin, end)
            )
        return time

    def _time_inside(
        self,
        combination: Combination,
        wanted_change: Array,
        total_change: float,
        begin: float,
        end: float,
    ) -> Array:
        """Times (n,) at which a monotonic combination of the loads has changed by given amounts
        since `begin`, by Newton's method safeguarded by bisection.

        Newton's method without a bracket is tried first. Where it fails, each time gets a bracket.

        Parameters
        ----------
        combination
            (c_P, c_Q) of the combination c_P P + c_Q Q
        wanted_change
            (n,) amounts between 0 and the total change [force per thickness]
        total_change
            change of the combination from `begin` to `end`
        begin, end
            two times of the segment; `begin` may be the later one

        Raises
        ------
        NotFoundError
            Where 4000 Newton steps or halvings do not converge.
        """
        # The first guess is exact for a cosine that turns at both ends.
        time = begin + (end - begin) / math.pi * np.arccos(1 - 2 * wanted_change / total_change)
        times_by_plain_newton = self._times_by_plain_newton(
            combination, wanted_change, begin, end, time
        )
        if times_by_plain_newton is not None:  # None: not converged
            return times_by_plain_newton

        # Sign of the combination's rate: times it an error is positive where the time is too late.
        sign_of_rate = math.copysign(1.0, total_change) * math.copysign(1.0, end - begin)
        search = _BracketedSearch.between(begin, end, time)
        for _ in range(_MOST_BRACKETED_STEPS):
            # Change of the combination since `begin`, and its time derivative, at the iterates.
            change_so_far, rate = self._change_and_rate(combination, search.time, begin)
            signed_error = sign_of_rate * (change_so_far - wanted_change)
            search.update_best_times(signed_error)
            if search.is_converged.all():
                return search.best_time
            search.take_step(signed_error, sign_of_rate * rate)
        raise NotFoundError(
            f"no time was found at which the loads have changed as wanted, between {begin:.17g} and"
            f" {end:.17g}"
        )

    def _times_by_plain_newton(
        self, combination: Combination, wanted_change: Array, begin: float, end: float, guess: Array
    ) -> Array | None:
        """Times (n,) at which a monotonic combination of the loads has changed by given amounts
        since `begin`, by Newton's method without a bracket.

        None where it does not converge within 12 steps to times between `begin` and `end`. It takes
        a third of the time of Newton's method with brackets.

        Newton's method converges quadratically: after a step the error is about step^2 over the
        distance to the next turning point. That point is at `begin`, at `end` or beyond. The
        iteration ends where this error is below the round-off of the time.

        Parameters
        ----------
        combination
            (c_P, c_Q) of the combination c_P P + c_Q Q
        wanted_change
            (n,) amounts between 0 and the change up to `end`
        begin, end
            two times of the segment; `begin` may be the later one
        guess
            (n,) first guesses of the times
        """
        time = guess
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # _MOST_PLAIN_STEPS: 12 Newton steps
            for _ in range(_MOST_PLAIN_STEPS):
                # Change of the combination since `begin`, and its time derivative.
                change_so_far, rate = self._change_and_rate(combination, time, begin)
                newton_step = (wanted_change - change_so_far) / rate
                time = time + newton_step
                # _ROUND_OFF_SHARE_OF_TIME: 4.5e-16 of the time
                time_roundoff = _ROUND_OFF_SHARE_OF_TIME * np.abs(time)
                distance_to_turning_point = np.minimum(np.abs(time - begin), np.abs(end - time))
                # Step length whose square over the distance leaves an error below round-off.
                # _ERROR_OVER_SQUARED_STEP: 4, of step^2 over the distance
                longest_final_step = np.sqrt(
                    time_roundoff
                    * np.maximum(
                        distance_to_turning_point / _ERROR_OVER_SQUARED_STEP, time_roundoff
                    )
                )
                if (np.abs(newton_step) <= longest_final_step).all():
                    lies_between = (time - begin) * (end - time) >= 0
                    return time if lies_between.all() else None
        return None

    def slope_and_bend(
        self,
        time: float,  # noqa: ARG002 most segments have none
    ) -> tuple[float, float] | None:
        """Slope dQ/dP and half of d2Q/dP2 at `time` where P is linear in time and Q(P) a line or a
        parabola; None elsewhere.
        """
        return None

    def mirrored_time(
        self,
        combination: Combination,  # noqa: ARG002 most segments have no mirrored time
        time: ArrayLike,  # noqa: ARG002
        near_time: float,  # noqa: ARG002
    ) -> Array | None:
        """The other time, next to `near_time`, at which a combination of the loads has the value
        that it has at `time`, where it is one wave; else None.
        """
        return None

    def shifted(self, delay: float) -> Self:
        """This segment of a load path `delay` later: the same loads at times that are larger by
        `delay`.

        `bulk` (both bulk stresses) and `tilt_and_moment` are segments over the same time, or None;
        they are delayed too.
        """
        bulk, tilt_and_moment = (
            companion and companion.shifted(delay)
            for companion in (self.bulk, self.tilt_and_moment)
        )
        return replace(
            self,
            start=self.start + delay,
            end=self.end + delay,
            bulk=bulk,
            tilt_and_moment=tilt_and_moment,
        )


def _choose(condition: Any, value_if_true: float, value_if_false: float) -> float:
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

    first_point: Point
    last_point: Point

    @property
    def is_straight(self) -> bool:
        return True

    def loads(self, time: ArrayLike) -> Loads:
        """(P, Q) [force per thickness] at `time`, each in its shape, linear between the segment's
        two ends: `first_point` (P, Q) at the time `start`, `last_point` (P, Q) at the time `end`.

        Loads are counted from the nearer end, so that both ends are met to the last digit.
        """
        t = _float_or_array(time)
        is_near_start = t - self.start <= self.end - t
        # `_choose` is `numpy.where` for single numbers.
        choose = _choose if isinstance(t, float) else np.where
        # Below 0 before the last end.
        time_from_nearer_end = t - choose(is_near_start, self.start, self.end)
        signed_share_of_segment = time_from_nearer_end / (self.end - self.start)
        p, q = (
            choose(is_near_start, first_load, last_load)
            + (last_load - first_load) * signed_share_of_segment
            for first_load, last_load in zip(self.first_point, self.last_point, strict=True)
        )
        return p, q

    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        return self.change_of(combination, np.ones(np.shape(time)), 0.0)

    def change_of(self, combination: Combination, time: ArrayLike, time_before: ArrayLike) -> Array:
        """Change of a combination c_P P + c_Q Q of the loads from `time_before` to `time`, on a
        straight line between two points (P, Q).
        """
        share_of_segment = (
            np.asarray(time, dtype=float) - np.asarray(time_before, dtype=float)
        ) / (self.end - self.start)
        normal_change = (self.last_point[0] - self.first_point[0]) * share_of_segment
        tangential_change = (self.last_point[1] - self.first_point[1]) * share_of_segment
        return combination[0] * normal_change + combination[1] * tangential_change

    def companion_of(self, combination: Combination) -> StraightSegment:
        """Segment over the same time with 0 in place of P and c_P P + c_Q Q in place of Q."""
        first_point, last_point = (
            (0.0, combination[0] * p + combination[1] * q)
            for p, q in (self.first_point, self.last_point)
        )
        return StraightSegment(self.start, self.end, first_point, last_point)

    def turning_points(
        self,
        combination: Combination,  # noqa: ARG002 a straight line does not turn
    ) -> list[float]:
        return []

    def _find_turning_points(self, combination: Combination) -> list[float]:
        return self.turning_points(combination)

    def _time_inside(
        self,
        combination: Combination,  # noqa: ARG002 a straight line whatever the combination is
        wanted_change: Array,
        total_change: float,
        begin: float,
        end: float,
    ) -> Array:
        """Times (n,) at which a combination of loads on a straight line has changed by the amounts
        `wanted_change` since `begin`, out of its `total_change` up to `end`.
        """
        return begin + (end - begin) * (wanted_change / total_change)

    def slope_and_bend(
        self,
        time: float,  # noqa: ARG002 the same all along
    ) -> tuple[float, float] | None:
        """Slope dQ/dP of the line, and 0 for d2Q/dP2; None where P is constant."""
        change_of_p = self.last_point[0] - self.first_point[0]
        return (
            ((self.last_point[1] - self.first_point[1]) / change_of_p, 0.0) if change_of_p else None
        )


@dataclass(frozen=True)
class HarmonicSegment(LoadSegment):
    """P = P0 + sum of P_k cos(k t - phi_k), Q likewise, over times t in radians; `normal` and
    `tangential` hold (P_k, phi_k), amplitude and phase lag in radians, of k = 1, 2, ...

    Sums over k are polynomials in z = exp(i t). One harmonic, an ellipse in the P-Q plane, has
    closed forms with the phasor of the combination.
    """

    mean: Point
    normal: Waves
    tangential: Waves

    @cached_property
    def _fourier_coefficients(self) -> NDArray[np.complex128]:
        """Complex Fourier coefficients c_k of P and Q, (2, m + 1): row 0 of P, row 1 of Q, k from 0
        to m, the highest harmonic whose amplitude is not 0 (m = 1 where none is).

        P minus its mean P0 is the real part of sum c_k exp(i k t), with c_0 = 0 and c_k = P_k
        exp(-i phi_k); Q likewise. `normal` holds (P_k, phi_k), amplitude and phase lag [rad], of
        k = 1, 2, ..., and `tangential` those of Q.
        """
        highest_harmonic = max(
            (
                k
                for waves in (self.normal, self.tangential)
                for k, (amplitude, _) in enumerate(waves, 1)
                if amplitude
            ),
            default=1,
        )
        coefficients = np.zeros((2, highest_harmonic + 1), dtype=complex)
        for coefficients_of_load, waves in zip(
            coefficients, (self.normal, self.tangential), strict=True
        ):
            coefficients_of_load[1 : len(waves) + 1] = [
                amplitude * cmath.exp(-1j * phase_lag)
                for amplitude, phase_lag in waves[:highest_harmonic]
            ]
        return coefficients

    @cached_property
    def ellipse(self) -> Ellipse | None:
        """The ellipse that P and Q follow; None where one of them has a higher harmonic."""
        if self._fourier_coefficients.shape[1] > 2:
            return None
        (normal_amplitude, normal_lag), (tangential_amplitude, tangential_lag) = (
            self._first_harmonics
        )
        amplitudes = (normal_amplitude, tangential_amplitude)
        return Ellipse(self.mean, amplitudes, tangential_lag - normal_lag, normal_lag)

    @cached_property
    def _first_harmonics(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """(amplitude, phase lag in radians) of the first harmonic of P and of Q."""
        return self.normal[0] if self.normal else (0.0, 0.0), (
            self.tangential[0] if self.tangential else (0.0, 0.0)
        )

    def amplitude_and_lead(self, combination: Combination) -> tuple[float, float]:
        """(amplitude, lead) of a combination c_P P + c_Q Q of the loads of an ellipse: it is a
        constant plus amplitude cos(t + lead), lead in radians.
        """
        known_amplitudes_and_leads = self._known_amplitudes_and_leads
        if combination not in known_amplitudes_and_leads:
            known_amplitudes_and_leads[combination] = self._find_amplitude_and_lead(combination)
        return known_amplitudes_and_leads[combination]

    @cached_property
    def _known_amplitudes_and_leads(self) -> dict[Combination, tuple[float, float]]:
        """`amplitude_and_lead` by its combination, as far as it was asked for."""
        return {}

    def _find_amplitude_and_lead(self, combination: Combination) -> tuple[float, float]:
        """Amplitude and lead [rad] of a combination c_P P + c_Q Q of the loads of an ellipse, which
        is a constant plus amplitude cos(t + lead).

        They are the absolute value and the angle of the sum of the phasors of c_P P and c_Q Q.
        Where c_P or c_Q is 0, the amplitude has the sign of the other coefficient.

        # notation: lag: P = mean + amplitude cos(t - lag), Q likewise
        """
        # Amplitude and lag [rad] of P, then of Q.
        (normal_amplitude, normal_lag), (tangential_amplitude, tangential_lag) = (
            self._first_harmonics
        )
        normal_coefficient, tangential_coefficient = combination
        # One load alone keeps the last digit of its phase.
        if tangential_coefficient == 0:
            return normal_coefficient * normal_amplitude, -normal_lag
        if normal_coefficient == 0:
            return tangential_coefficient * tangential_amplitude, -tangential_lag
        return cmath.polar(
            normal_coefficient * cmath.rect(normal_amplitude, -normal_lag)
            + tangential_coefficient * cmath.rect(tangential_amplitude, -tangential_lag)
        )

    @property
    def most_turning_points(self) -> int:
        """Upper bound of the number of turning points: twice the highest harmonic in each period; 0
        for constant loads.
        """
        highest_harmonic = (
            self._fourier_coefficients.shape[1] - 1 if np.any(self._fourier_coefficients) else 0
        )
        return 2 * highest_harmonic * math.ceil((self.end - self.start) / (2 * math.pi))

    def loads(self, time: ArrayLike) -> Loads:
        """Loads P and Q [force per thickness] at `time` [rad], each in its shape: mean plus sum of
        harmonics.

        Where both loads have one harmonic at most, `ellipse` is not None, and two cosines are
        enough.
        """
        mean_normal_load, mean_tangential_load = self.mean
        if self.ellipse:
            times = _float_or_array(time)
            # Amplitude and phase lag [rad] of P, then of Q.
            (normal_amplitude, normal_lag), (tangential_amplitude, tangential_lag) = (
                self._first_harmonics
            )
            return (
                mean_normal_load + normal_amplitude * np.cos(times - normal_lag),
                mean_tangential_load + tangential_amplitude * np.cos(times - tangential_lag),
            )
        times = np.atleast_1d(np.asarray(time, dtype=float))
        z = np.exp(1j * times)
        # Fourier coefficients c_k of P and of Q, from the highest k down to 0, for Horner's scheme
        # in z.
        normal_terms, tangential_terms = self._horner_terms_of_loads
        normal_load = mean_normal_load + _wave_sum_at(normal_terms, z, times)
        tangential_load = mean_tangential_load + _wave_sum_at(tangential_terms, z, times)
        shape = np.shape(time)
        return normal_load.reshape(shape), tangential_load.reshape(shape)

    @cached_property
    def _horner_terms_of_loads(self) -> tuple[WaveTerms, WaveTerms]:
        """Terms of P and of Q for Horner's scheme, as of `_horner_terms`."""
        normal_coefficients, tangential_coefficients = self._fourier_coefficients
        return _horner_terms(normal_coefficients), _horner_terms(tangential_coefficients)

    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        """Time derivative of a combination c_P P + c_Q Q of the loads, in the shape of `time`
        [rad].
        """
        if self.ellipse:
            amplitude, lead = self.amplitude_and_lead(combination)
            rate: Array = -amplitude * np.sin(_float_or_array(time) + lead)
            return rate
        _, rate_terms = self._series_of(combination)
        return _wave_sum(rate_terms, np.asarray(time, dtype=float))

    def _series_of(self, combination: Combination) -> tuple[tuple[complex, ...], WaveTerms]:
        """Fourier coefficients c_k of a combination, k from 0 on; the Horner terms of its rate."""
        known_series = self._known_series
        if combination not in known_series:
            coefficients = np.array(combination) @ self._fourier_coefficients
            rate_terms = _horner_terms(self._rate_coefficients(combination))
            known_series[combination] = tuple(coefficients.tolist()), rate_terms
        return known_series[combination]

    @cached_property
    def _known_series(
        self,
    ) -> dict[Combination, tuple[tuple[complex, ...], WaveTerms]]:
        """`_series_of` by its combination, as far as it was asked for."""
        return {}

    def _rate_coefficients(self, combination: Combination) -> NDArray[np.complex128]:
        """Fourier coefficients i k c_k of the rate of a combination, (m + 1,)."""
        return (
            1j
            * np.arange(self._fourier_coefficients.shape[1])
            * (np.array(combination) @ self._fourier_coefficients)
        )

    def change_of(self, combination: Combination, time: ArrayLike, time_before: ArrayLike) -> Array:
        """Change of a combination c_P P + c_Q Q of the loads from `time_before` to `time` [rad],
        without cancellation over short times.

        On an ellipse, where each load has one harmonic, the combination is a constant plus
        amplitude cos(t + lead). It changes by -2 amplitude sin(middle_time + lead)
        sin(half_interval). With several harmonics it is a sum in powers of exp(i t).
        """
        end_time = _float_or_array(time)
        begin_time = _float_or_array(time_before)
        half_interval = (end_time - begin_time) / 2
        if self.ellipse:
            middle_time = (end_time + begin_time) / 2
            amplitude, lead = self.amplitude_and_lead(combination)
            change: Array = -2 * amplitude * np.sin(middle_time + lead) * np.sin(half_interval)
            return change
        # exp(i (t - t_0)/2) and, as the middle argument below, exp(i t_0), t_0 the time before.
        half_rotation = np.exp(1j * np.atleast_1d(half_interval))
        change = self._change_between(combination, _unit_vector(begin_time), half_rotation)
        return change.reshape(np.shape(half_interval))

    def _change_between(
        self,
        combination: Combination,
        z_before: complex | NDArray[np.complex128],
        half_rotation: NDArray[np.complex128],
    ) -> Array:
        """Change (n,) of a combination c_P P + c_Q Q of the loads from time t_0 to t, without
        cancellation over short times.

        But for its mean the combination is the real part of f(z) = sum c_k z^k at z = exp(i t).
        Horner's scheme gives the quotient (f(z) - f(z_0))/(z - z_0). The change is the real part of
        its product with z - z_0 = 2i sin((t - t_0)/2) exp(i (t + t_0)/2).

        Parameters
        ----------
        combination
            (c_P, c_Q)
        z_before
            z_0 = exp(i t_0), one number or (n,)
        half_rotation
            (n,) exp(i (t - t_0)/2)
        """
        # Fourier coefficients c_0 to c_m of the combination.
        coefficients, _ = self._series_of(combination)
        *lower_terms, highest_term = coefficients
        if not lower_terms:
            return np.zeros(half_rotation.shape)
        z_middle = half_rotation * z_before  # exp(i (t + t_0)/2)
        z = half_rotation * z_middle

        # Horner's scheme from the highest harmonic down: `sum_before` is the partial sum at z_0.
        quotient: Any = highest_term
        sum_before: Any = highest_term * z_before + lower_terms[-1]
        for coefficient in reversed(lower_terms[:-1]):
            quotient = quotient * z + sum_before
            sum_before = sum_before * z_before + coefficient
        change: Array = (quotient * z_middle * (2j * half_rotation.imag)).real
        return change

    def _change_and_rate(
        self, combination: Combination, time: Array, time_before: float
    ) -> tuple[Array, Array]:
        """Change of a combination c_P P + c_Q Q of the loads since `time_before`, and its rate by
        time, at `time` (n,) [rad]: (n,) each.
        """
        if self.ellipse:  # one harmonic: closed forms
            return super()._change_and_rate(combination, time, time_before)
        # Several harmonics, in z = exp(i t): exp(i t_0) before, and the rotation over half the
        # time.
        z_before = _unit_vector(time_before)
        half_rotation = np.exp(0.5j * (time - time_before))
        # Terms of the rate for Horner's scheme.
        _, rate_terms = self._series_of(combination)
        change = self._change_between(combination, z_before, half_rotation)
        return change, _wave_sum_at(rate_terms, half_rotation * half_rotation * z_before, time)

    def companion_of(self, combination: Combination) -> HarmonicSegment:
        """Segment over the same time with 0 in place of P and the combination c_P P + c_Q Q of this
        segment's loads in place of Q.

        With (c_P, c_Q) = (x, height) of the line along which the loads act, the combination is the
        moment x P + height Q; the 0 before it stands in the place of the tilt, which then follows
        from the moment.
        """
        coefficients = (np.array(combination) @ self._fourier_coefficients)[1:]
        amplitudes_and_lags = tuple(
            (abs(coefficient), -cmath.phase(coefficient)) for coefficient in coefficients.tolist()
        )
        mean = combination[0] * self.mean[0] + combination[1] * self.mean[1]
        return HarmonicSegment(self.start, self.end, (0.0, mean), (), amplitudes_and_lags)

    def _find_turning_points(self, combination: Combination) -> list[float]:
        """Turning points of a combination c_P P + c_Q Q of the loads: times inside the segment at
        which its rate is zero, ascending [rad]; none for a constant combination.

        >>> segment = HarmonicSegment(0.0, 2 * math.pi, (3.0, 0.0), ((1.0, 0.0), (1.0, 0.0)), ())
        >>> [
        ...     round(time / math.pi, 4) for time in segment.turning_points(NORMAL_LOAD)
        ... ]  # sin t (1 + 4 cos t) = 0
        [0.5804, 1.0, 1.4196]
        """
        # Upper bounds of the amplitudes of the combination's harmonics, k = 0, 1, ...
        # `_fourier_coefficients` (2, m + 1): those of P and of Q.
        largest_amplitudes = np.abs(combination) @ np.abs(self._fourier_coefficients)
        # An ellipse: each load has one harmonic.
        if self.ellipse:
            return self._turning_points_of_ellipse(combination, largest_amplitudes[1])
        angles = self._angles_without_rate(combination, largest_amplitudes)

        # An angle is a time but for whole periods: all its times along the segment.
        period = 2 * math.pi
        first_times = angles + period * np.floor((self.start - angles) / period)
        n_periods = math.ceil((self.end - self.start) / period) + 2
        times = first_times[:, None] + period * np.arange(n_periods)
        return _refined_turning_points(self, combination, times.ravel())

    def _turning_points_of_ellipse(
        self, combination: Combination, largest_amplitude: float
    ) -> list[float]:
        """Turning points of a combination of loads that have one harmonic: amplitude cos(t + lead)
        turns where t + lead is a multiple of pi. Times inside the segment, ascending [rad].

        None where the amplitude is 0 but for round-off, 1e-14 of `largest_amplitude`, the sum of
        the absolute terms that it is made of.
        """
        amplitude, lead = self.amplitude_and_lead(combination)
        # _ROUND_OFF_SHARE: 1e-14 of the sum
        if abs(amplitude) <= _ROUND_OFF_SHARE * largest_amplitude:
            return []
        first_multiple = math.ceil((self.start + lead) / math.pi)
        last_multiple = math.floor((self.end + lead) / math.pi)
        turning_times = [
            multiple * math.pi - lead for multiple in range(first_multiple, last_multiple + 1)
        ]
        return [time for time in turning_times if self.start < time < self.end]

    def _angles_without_rate(self, combination: Combination, largest_amplitudes: Array) -> Array:
        """Angles [rad] in a period at which the rate of a combination of loads with several
        harmonics is zero, but for round-off; empty for a constant combination.

        Of harmonics up to the m-th, z^m times the rate is a polynomial in z = exp(i t). The angles
        are those of its roots on the unit circle. `largest_amplitudes` (m + 1,) are upper bounds of
        the amplitudes of the combination's harmonics, k = 0, 1, ...
        """
        # Fourier coefficients i k c_k of the rate, those at round-off set to 0.
        rate_coefficients = self._rate_coefficients(combination)
        largest_rate = float(np.arange(len(largest_amplitudes)) @ largest_amplitudes)
        rate_coefficients[np.abs(rate_coefficients) <= _ROUND_OFF_SHARE * largest_rate] = 0
        # LEAST_LOAD_CHANGE: 1e-290; smaller rates count as 0
        if largest_rate < LEAST_LOAD_CHANGE or not np.any(rate_coefficients):
            return np.zeros(0)

        # z^m times twice the rate, with c_-k the conjugate of c_k: a polynomial of degree 2 m.
        highest_harmonic = int(np.flatnonzero(rate_coefficients)[-1])
        coefficients_of_negative_k = np.conj(rate_coefficients[highest_harmonic:0:-1])
        roots = polynomial.polyroots(
            np.concatenate([coefficients_of_negative_k, rate_coefficients[: highest_harmonic + 1]])
        )
        # _DISTANCE_OF_DOUBLE_ROOTS: 1e-5, by which round-off parts a double root
        return np.angle(roots[np.abs(np.abs(roots) - 1) < _DISTANCE_OF_DOUBLE_ROOTS])

    def _time_inside(
        self,
        combination: Combination,
        wanted_change: Array,
        total_change: float,
        begin: float,
        end: float,
    ) -> Array:
        """Times (n,) [rad] at which a monotonic combination of the loads has changed by given
        amounts since `begin`: on an ellipse in closed form by the arc cosine, else by Newton's
        method.

        The ellipse's combination, amplitude cos(t + lead) plus a constant, is monotonic while
        t + lead is between two multiples of pi. These are n_half_turns pi and the next.

        Parameters
        ----------
        combination
            (c_P, c_Q) of the combination c_P P + c_Q Q
        wanted_change
            (n,) amounts between 0 and the total change
        total_change
            change of the combination from `begin` to `end`
        begin, end
            two times of the segment; `begin` may be the later one
        """
        if not self.ellipse:
            return super()._time_inside(combination, wanted_change, total_change, begin, end)
        amplitude, lead = self.amplitude_and_lead(combination)
        n_half_turns = math.floor(((begin + end) / 2 + lead) / math.pi)
        # t + lead = n_half_turns pi + arccos(cosine); cos(t + lead) rises over odd half turns.
        sign = -1.0 if n_half_turns % 2 else 1.0
        cosine = sign * (math.cos(begin + lead) + wanted_change / amplitude)
        time = n_half_turns * math.pi - lead + np.arccos(np.minimum(np.maximum(cosine, -1), 1))

        # The arc cosine loses digits near an extreme: one Newton step restores them.
        rate_at_time = self.rate_of(combination, time)
        is_off_extreme = np.abs(rate_at_time) > 1e-6 * abs(amplitude)
        remaining_change = wanted_change - self.change_of(combination, time, begin)
        return time + np.where(
            is_off_extreme, remaining_change / np.where(is_off_extreme, rate_at_time, 1.0), 0.0
        )

    def mirrored_time(
        self, combination: Combination, time: ArrayLike, near_time: float
    ) -> Array | None:
        """Time [rad] at which a combination c_P P + c_Q Q of the loads of an ellipse has the same
        value as at `time`, on the other side of an extreme: of all such times the one next to
        `near_time`. None for loads of several harmonics.

        The combination is amplitude cos(t + lead) plus a constant, which is symmetric about its
        extremes.
        """
        if not self.ellipse:
            return None
        _, lead = self.amplitude_and_lead(combination)
        mirrored_time = -2 * lead - np.asarray(time, dtype=float)
        return mirrored_time + 2 * math.pi * np.round((near_time - mirrored_time) / (2 * math.pi))

    def shifted(self, delay: float) -> Self:
        """The same load history, `delay` [rad] later: the phase lag of the k-th harmonic grows by k
        times the delay.

        `normal` and `tangential` hold (amplitude, phase lag [rad]) of the harmonics k = 1, 2, ...
        of P and of Q. Start and end grow by the delay itself. Segments of bulk stress and of tilt
        that this one carries are delayed too.
        """
        delay_angle = math.remainder(delay, 2 * math.pi)
        # `delay` without its whole periods; where only round-off is left the phases stay.
        if abs(delay_angle) <= 1e-15 * abs(delay):
            return super().shifted(delay)

        def delayed_waves(waves: Waves) -> Waves:
            """(amplitude, phase lag) of k = 1, 2, ..., each lag grown by k times the delay."""
            lag_changes = [
                math.remainder(k * delay_angle, 2 * math.pi) for k in range(1, len(waves) + 1)
            ]
            return tuple(
                (amplitude, lag + lag_change)
                for (amplitude, lag), lag_change in zip(waves, lag_changes, strict=True)
            )

        return replace(
            super().shifted(delay),
            normal=delayed_waves(self.normal),
            tangential=delayed_waves(self.tangential),
        )


@dataclass(frozen=True)
class ChebyshevSegment(LoadSegment):
    """P and Q as Chebyshev series of u in [-1, 1], u growing with time from start to end."""

    normal: tuple[float, ...]
    tangential: tuple[float, ...]

    @property
    def most_turning_points(self) -> int:
        return max(len(self.normal), len(self.tangential), 2) - 2

    def _series_variable(self, time: ArrayLike) -> Any:
        """Variable u of the series at `time`: -1 at the start, 1 at the end of the segment."""
        t = _float_or_array(time)
        return ((t - self.start) - (self.end - t)) / (self.end - self.start)

    @cached_property
    def _series(self) -> Array:
        """Chebyshev coefficients of P and Q, (2, m), zeros behind the shorter series."""
        coefficients = np.zeros((2, max(len(self.normal), len(self.tangential), 2)))
        coefficients[0, : len(self.normal)] = self.normal
        coefficients[1, : len(self.tangential)] = self.tangential
        return coefficients

    @cached_property
    def _starts_from_zero(self) -> tuple[bool, bool]:
        """Whether P, and Q, start from 0."""
        p_is_zero_at_start, q_is_zero_at_start = np.abs(
            chebyshev.chebval(-1.0, self._series.T)
        ) <= _ROUND_OFF_SHARE_OF_SUM * np.sum(np.abs(self._series), axis=1)
        return bool(p_is_zero_at_start), bool(q_is_zero_at_start)

    def loads(self, time: ArrayLike) -> Loads:
        """Loads P and Q [force per thickness] at `time`, each in its shape, by Chebyshev series of
        the variable u, -1 at the segment's start and 1 at its end.

        A load that starts from 0 is computed as its change since the start: small loads there keep
        their digits.
        """
        p_and_q: list[Array] = []
        # First P, as the combination 1 P + 0 Q, then Q.
        for combination, coefficients, starts_from_zero in zip(
            (NORMAL_LOAD, TANGENTIAL_LOAD), self._series, self._starts_from_zero, strict=True
        ):
            if starts_from_zero:
                p_and_q.append(self.change_of(combination, time, self.start))
            else:
                u = self._series_variable(time)
                p_and_q.append(np.asarray(chebyshev.chebval(u, coefficients)))
        normal_load, tangential_load = p_and_q
        return normal_load, tangential_load

    def rate_of(self, combination: Combination, time: ArrayLike) -> Array:
        """Time derivative of a combination c_P P + c_Q Q of the loads, in the shape of `time`."""
        # coefficients of the derivative by u, the variable of the series; du/dt is the last factor
        _, derivative_series = self._series_of(combination)
        return np.asarray(
            chebyshev.chebval(self._series_variable(time), derivative_series)
            * (2 / (self.end - self.start))
        )

    def _series_of(self, combination: Combination) -> tuple[Array, Array]:
        """Chebyshev coefficients of a combination c_P P + c_Q Q, and of its derivative by u."""
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
        """Change of a combination c_P P + c_Q Q of the loads from `time_before` to `time`, without
        cancellation over short times.
        """
        t = _float_or_array(time)
        t0 = _float_or_array(time_before)
        # Chebyshev coefficients of the combination.
        series, _ = self._series_of(combination)
        # u: variable of the series, -1 at the segment's start and 1 at its end. The change is the
        # difference quotient of the series by u, times the change of u.
        change_of_u = 2 * (t - t0) / (self.end - self.start)
        change: Array = np.multiply(
            divided_difference(series, self._series_variable(t), self._series_variable(t0)),
            change_of_u,
        )
        return change

    def companion_of(self, combination: Combination) -> ChebyshevSegment:
        """Segment over the same time with 0 in place of P and c_P P + c_Q Q in place of Q."""
        return ChebyshevSegment(
            self.start, self.end, (0.0,), tuple((np.array(combination) @ self._series).tolist())
        )

    def _find_turning_points(self, combination: Combination) -> list[float]:
        """Turning points of a combination c_P P + c_Q Q of the loads: times inside the segment at
        which its rate is zero, ascending; none where the rate is constant.

        They are the real roots of the Chebyshev series of the rate in u from -1 to 1, refined by
        Newton steps. u grows linearly with time from -1 at the segment's start to 1 at its end.

        >>> segment = ChebyshevSegment(
        ...     0.0, 4.0, (3.0, 0.0, 1.0), (0.0, 1.0)
        ... )  # P = 2 + 2 (t/2 - 1)^2
        >>> segment.turning_points(NORMAL_LOAD)
        [2.0]
        """
        # The derivative by u is the rate but for a constant factor.
        _, rate_series = self._series_of(combination)
        # `_series` (2, m): Chebyshev coefficients of P and of Q.
        largest_coefficient = float(np.abs(combination) @ np.max(np.abs(self._series), axis=1))
        # _ROUND_OFF_SHARE: 1e-14 of the largest term
        significant_degrees = np.flatnonzero(
            np.abs(rate_series) > _ROUND_OFF_SHARE * largest_coefficient
        )
        if not len(significant_degrees) or significant_degrees[-1] == 0:
            return []
        roots = chebyshev.chebroots(rate_series[: significant_degrees[-1] + 1])
        # Within 1e-5, the distance that round-off leaves between the roots of a double one.
        is_real = np.abs(roots.imag) < _DISTANCE_OF_DOUBLE_ROOTS
        is_inside = np.abs(roots.real) < 1 + _DISTANCE_OF_DOUBLE_ROOTS
        u = np.clip(roots.real[is_real & is_inside], -1, 1)
        times = (self.start + self.end) / 2 + (self.end - self.start) / 2 * u
        return _refined_turning_points(self, combination, times)

    @property
    def is_straight(self) -> bool:
        return not np.any(self._series[:, 2:])

    def slope_and_bend(self, time: float) -> tuple[float, float] | None:
        """Slope dQ/dP and half of d2Q/dP2 at `time` where P is linear in time and Q(P) a line or a
        parabola; None elsewhere.
        """
        # Chebyshev coefficients of P, then of Q: the mean, the linear one, those of higher degree.
        (_, linear_p, *higher_p), (_, linear_q, *higher_q) = self._series.tolist()
        if not linear_p or any(higher_p) or any(higher_q[1:]):
            return None
        quadratic_q = higher_q[0] if higher_q else 0.0
        # `_series_variable`: u, -1 at the segment's start and 1 at its end
        return (
            linear_q + 4 * quadratic_q * float(self._series_variable(time))
        ) / linear_p, 2 * quadratic_q / linear_p**2


@dataclass(frozen=True)
class LoadPath:
    """The initial loading from (0, 0), then a cycle that repeats for ever (or nothing more, where
    `cycle` is empty).
    """

    initial_loading: tuple[LoadSegment, ...]
    cycle: tuple[LoadSegment, ...]
    moment_is_given: bool = False
    """Whether the segments' `tilt_and_moment` states the moment, from which the tilt follows, and
    not the tilt.
    """

    @property
    def has_bulk_or_tilt(self) -> bool:
        """Whether segments carry bulk stresses, tilt or moment along with P and Q."""
        return any(
            segment.bulk is not None or segment.tilt_and_moment is not None
            for segment in (*self.initial_loading, *self.cycle)
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

    def segments(self, cycles: int) -> Iterator[LoadSegment]:
        """The segments of the initial loading, then those of the first `cycles` cycles, each at its
        own time.
        """
        yield from self.initial_loading
        for number in range(cycles):
            yield from self.segments_of_cycle(number)

    def segments_of_cycle(self, number: int) -> tuple[LoadSegment, ...]:
        """The load segments of cycle `number`, counted from 0, at its own time."""
        delay = number * (self.period or 0.0)
        return tuple(segment.shifted(delay) for segment in self.cycle)

    def companion(self, name: str) -> LoadPath | None:
        """The load path of what all segments carry under `name`: "bulk", both bulk stresses in
        place of P and Q, or "tilt_and_moment". None where one of them carries nothing.
        """
        initial_companions = [getattr(segment, name) for segment in self.initial_loading]
        cycle_companions = [getattr(segment, name) for segment in self.cycle]
        return (
            None
            if None in (*initial_companions, *cycle_companions)
            else LoadPath(tuple(initial_companions), tuple(cycle_companions))
        )

    def at(self, time: ArrayLike) -> Loads:
        """Loads P and Q [force per thickness] at any times of the path, each in the shape of
        `time`; a time after the first cycle is taken back into it by whole periods.

        The path is `initial_loading`, then `cycle`: load segments with their `start` and `end`
        times. `period` is the duration of the cycle, None for a path that does not repeat.

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

        segments = (*self.initial_loading, *self.cycle)
        if np.any(path_time < segments[0].start) or np.any(path_time > segments[-1].end):
            raise ValueError(
                f"time outside the load path, which runs from {segments[0].start} to"
                f" {segments[-1].end}"
            )

        # Each time belongs to the first segment that does not end before it.
        end_times = np.array([segment.end for segment in segments])
        segment_indices = np.minimum(
            np.searchsorted(end_times, path_time, side="left"), len(segments) - 1
        )
        loads = np.empty((2, *path_time.shape))
        for k in np.unique(segment_indices):
            loads[:, segment_indices == k] = segments[k].loads(path_time[segment_indices == k])
        normal_load, tangential_load = loads.reshape(2, *np.shape(time))
        return normal_load, tangential_load


def _horner_terms(coefficients: NDArray[np.complex128]) -> WaveTerms:
    """Terms of the sum of c_k exp(i k t) for Horner's scheme, from the highest k down to 0: pairs
    (c_k, difference of k from the term before; of the first term from m, which is not used).

    Terms with c_k = 0 are left out, but for k = 0. `coefficients` (m + 1,) are c_0 to c_m.
    """
    terms = []
    k_above = len(coefficients) - 1
    # Of a thousand harmonics only one may be present: the absent ones cost nothing.
    present_harmonics = [*(np.flatnonzero(coefficients[1:])[::-1] + 1).tolist(), 0]
    for k in present_harmonics:
        terms.append((complex(coefficients[k]), k_above - k))
        k_above = k
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
    """Real part of the sum of c_k exp(i k t), (n,), at `time` t (n,) [rad], by Horner's scheme in
    z = exp(i t), (n,).

    `terms` are pairs from the highest k down to 0: (c_k, difference of k from the term before).
    """
    (highest, _), *lower_terms = terms
    if not lower_terms:
        return np.full(z.shape, highest.real)
    partial_sum: Any = highest
    for coefficient, decrease_of_k in lower_terms:
        factor_between_terms = z if decrease_of_k == 1 else np.exp(1j * decrease_of_k * time)
        partial_sum = partial_sum * factor_between_terms + coefficient
    sums: Array = partial_sum.real
    return sums


def _refined_turning_points(
    segment: LoadSegment, combination: Combination, guessed_times: Array
) -> list[float]:
    """Turning points of a combination c_P P + c_Q Q of the loads, refined from guesses (n,) by two
    Newton steps on its rate: times inside the segment, ascending.

    The derivative of the rate is a difference quotient over a millionth of the segment. A Newton
    step longer than 1e-5 of half the segment is not taken. Round-off parts a double zero of the
    rate by up to that distance.

    Parameters
    ----------
    segment
        of a load path, from its time `start` to its time `end`
    combination
        (c_P, c_Q)
    guessed_times
        (n,) approximate zeros of the rate
    """
    times = guessed_times
    time_increment = 1e-6 * (segment.end - segment.start)
    # _DISTANCE_OF_DOUBLE_ROOTS: 1e-5, by which round-off parts a double root
    longest_step = _DISTANCE_OF_DOUBLE_ROOTS * (segment.end - segment.start) / 2
    for _ in range(2):
        # Rate of the combination at the times, and an increment later.
        rate, rate_after = segment.rate_of(combination, np.stack([times, times + time_increment]))
        # An infinite increment where the rate is constant: no Newton step.
        rate_increment = np.where(rate_after != rate, rate_after - rate, np.inf)
        newton_step = rate * time_increment / rate_increment
        times = times - np.where(np.abs(newton_step) < longest_step, newton_step, 0.0)
    return sorted(time for time in times.tolist() if segment.start < time < segment.end)


def straight_segments(rows: Iterable[Sequence[float]]) -> tuple[StraightSegment, ...]:
    """Straight segments of a load path from each of the `rows` (time, P, Q) to the next.

    The segments are one fewer than the rows; each holds (P, Q) at its ends as `first_point` and
    `last_point`.

    >>> [
    ...     segment.last_point
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
    """Segment of a load path on a parabola in the P-Q plane from (0, 0) at the time `start` to
    `last_point` (P, Q) at the time `end`.

    P is linear in time, and Q = alpha P + beta P^2 has the slope dQ/dP = `end_slope` at the end.
    The segment holds P and Q as Chebyshev series. Below, its method `slope_and_bend` gives dQ/dP
    and beta.

    >>> segment = parabola_segment(0.0, 2.0, (1.0, 0.5), 0.0)
    >>> [float(load) for load in segment.loads(1.0)], segment.slope_and_bend(2.0)
    ([0.5, 0.375], (0.0, -0.5))
    """
    # notation: w from 0 at the start to 1 at the end, u = 2 w - 1 the variable of the series
    p, q = last_point
    linear_coefficient = 2 * q - end_slope * p  # Q = linear_coefficient w + square_coefficient w^2
    square_coefficient = end_slope * p - q
    normal_series = (p / 2, p / 2)
    tangential_series = (
        linear_coefficient / 2 + 3 * square_coefficient / 8,
        (linear_coefficient + square_coefficient) / 2,
        square_coefficient / 8,
    )
    return ChebyshevSegment(start, end, normal_series, tangential_series)


def sampled_times(segment: LoadSegment, least_count: int) -> Array:
    """Evenly spaced times (n,) along a load segment, dense enough to resolve its turning points.

    A segment without possible turning points, such as a straight one, gets its two ends. Others get
    `least_count`, or more: eight intervals for each possible turning point.

    `most_turning_points` of the segment is an upper bound of the number of turning points of P and
    Q inside it. Below, the arguments of a segment are its start time, its end time and its loads.

    >>> (
    ...     len(sampled_times(StraightSegment(0.0, 1.0, (0.0, 0.0), (3.0, 1.0)), 25)),
    ...     len(sampled_times(ellipse_segment(0.0, 6.28, (3, 1), (1, 1), 0.5), 25)),
    ... )
    (2, 25)
    """
    n_times = (
        max(least_count, 8 * segment.most_turning_points + 1) if segment.most_turning_points else 2
    )
    return np.linspace(segment.start, segment.end, n_times)


# Of the largest P of a segment: a load below this share of it is zero.
_ZERO_LOAD = 1e-12


def largest_ratio(segments: Iterable[LoadSegment]) -> float:
    """Largest |Q|/P along load segments; infinite where P is negative, or zero while Q is not; 0
    where both are zero.

    Dinkelbach's iteration: where Q - r P or -Q - r P is largest, |Q|/P exceeds r, unless r is the
    largest ratio itself. These combinations are largest at ends and turning points of a segment.

    # notation: r ratio reached so far; Combination(c_P, c_Q): c_P P + c_Q Q
    >>> largest_ratio([StraightSegment(0.0, 1.0, (1.0, 0.0), (2.0, -1.0))])
    0.5
    """
    # `turning_points`: times inside a segment at which a combination stops growing or falling.
    ratio = 0.0
    for segment in segments:
        # NORMAL_LOAD: P alone, as a combination
        times_of_extreme_p = [segment.start, segment.end, *segment.turning_points(NORMAL_LOAD)]
        while True:
            turning_times_for_positive_q = segment.turning_points(Combination(-ratio, 1.0))
            turning_times_for_negative_q = segment.turning_points(Combination(ratio, 1.0))
            candidate_times = np.array(
                [*times_of_extreme_p, *turning_times_for_positive_q, *turning_times_for_negative_q]
            )
            largest_candidate = largest_ratio_of(*segment.loads(candidate_times))
            if not largest_candidate > ratio * (1 + 1e-15):
                break
            ratio = largest_candidate
            if math.isinf(ratio):
                return ratio
    return ratio


def largest_ratio_of(normal_load: Array, tangential_load: Array) -> float:
    """Largest |Q|/P of n instants, P and Q (n,) each [force per thickness]: 0 where both are zero,
    infinite where P is negative, or zero while Q is not.

    Loads below 1e-12 of the largest |P| count as zero.
    """
    # _ZERO_LOAD: 1e-12 of the largest |P|
    negligible_load = _ZERO_LOAD * np.max(np.abs(normal_load))
    shear_force = np.abs(tangential_load)
    shear_force = np.where(shear_force <= negligible_load, 0.0, shear_force)
    if np.any(normal_load < -negligible_load):
        return math.inf
    is_pressed = normal_load > negligible_load
    if np.any(shear_force[~is_pressed] > 0):
        return math.inf
    return float(np.max(shear_force[is_pressed] / normal_load[is_pressed], initial=0.0))
