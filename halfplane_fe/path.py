"""Loads of a load path; instants at which its increments end, which are turning points and regular
ones; refusal of paths with separation or gross sliding.

A segment of the path lies between two vertices or is a whole curve. The loads are P and Q; where a
path has bulk stress or tilt they are five: P, Q, sigma_lower, sigma_upper, and tilt or moment.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from scenes import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    Combination,
    InadmissibleLoadError,
    InputError,
    LoadedInstant,
    LoadPath,
    LoadSegment,
    Scene,
    sampled_times,
)
from scenes.array_types import Array

# Samples of a segment, at least, between which a rate is looked at for changes of sign. Two turning
# points between neighbouring samples are both missed.
_N_SAMPLES = 721
# Share of the largest load below which a load is as good as none: the nodal forces are known to
# about so much of it.
_LEAST_LOAD_RATIO = 1e-12
# Share of f times the largest load within which |Q| is f P.
_ROUNDING_OF_LIMIT = 1e-14
# Secant steps before a zero is bracketed instead, some more than are needed; and the scaled gap,
# force, load or rate that counts as zero: further steps would follow round-off.
_MOST_SECANTS = 16
_ZERO_ROUND_OFF = 1e-15
_ADVICE_ON_LITTLE_LOAD = (
    "so little load, 1e-12 of the largest or less, finite elements can't tell from separation; the"
    " half-plane engine can"
)
_ADVICE_ON_UNLOADING = (
    "finite elements need P > 0 after the start, for unloaded bodies have no place; half-plane"
    " theory takes full unloading, P = Q = 0: keep P > 0, or solve the scene by theory alone"
)
_ADVICE_ON_SLIDING = (
    "finite elements need |Q| below f P (half-plane theory takes |Q| = f P too); lower the"
    " tangential load, raise the normal load or friction.coefficient"
)


@dataclass(frozen=True)
class Stretch:
    """Part of a segment of the load path between turning points, from the instant `start` on, with
    the instants at which its regular increments end.
    """

    segment: LoadSegment
    start: float
    ends: tuple[float, ...]


def prescribed_path(scene: Scene) -> LoadPath:
    """Load path of a scene: of P and Q, or of the movements that actuators prescribe in the place
    of one or both.
    """
    return scene.load.path_of_actuators() if scene.load.is_driven else scene.load.path()


def has_bulk_stress(path: LoadPath) -> bool:
    """Whether a load path has a bulk stress, a uniform stress along x in a body; it may be 0 at
    times.
    """
    return path.initial_loading[0].bulk is not None


class _LoadAlongSegment(NamedTuple):
    """One load along a segment of the path: a linear combination of the two loads that a segment
    stores, with two factors; 0 without a segment. Bulk stresses and tilt are stored in segments of
    their own.
    """

    segment: LoadSegment | None
    combination: Combination

    def value_at(self, time: float) -> float:
        """The load at an instant, a linear combination of the two loads that its segment stores; 0
        without a segment.
        """
        if self.segment is None:
            return 0.0
        stored_loads = self.segment.loads(time)
        return sum(
            factor * float(load)
            for factor, load in zip(self.combination, stored_loads, strict=True)
        )


def _loads_of_segment(segment: LoadSegment) -> tuple[_LoadAlongSegment, ...]:
    """Loads along a segment of the load path, each as a linear combination of two stored loads: P
    and Q. With bulk stress or tilt there are five: also the bulk stresses of both bodies, and tilt
    or moment.
    """
    normal_load = _LoadAlongSegment(segment, NORMAL_LOAD)
    tangential_load = _LoadAlongSegment(segment, TANGENTIAL_LOAD)
    if segment.bulk is None and segment.tilt_and_moment is None:
        return normal_load, tangential_load
    return (normal_load, tangential_load, *_bulk_and_tilt_loads(segment))


def _bulk_and_tilt_loads(
    segment: LoadSegment,
) -> tuple[_LoadAlongSegment, _LoadAlongSegment, _LoadAlongSegment]:
    """Bulk stress of the lower and of the upper body, and tilt or moment, along a segment of the
    load path. Each is a linear combination of two loads that a segment of its own stores.
    """
    stress_of_lower_body = _LoadAlongSegment(segment.bulk, NORMAL_LOAD)
    stress_of_upper_body = _LoadAlongSegment(segment.bulk, TANGENTIAL_LOAD)
    # Of tilt and moment one is 0 throughout.
    tilt_or_moment = _LoadAlongSegment(segment.tilt_and_moment, Combination(1.0, 1.0))
    return stress_of_lower_body, stress_of_upper_body, tilt_or_moment


def is_straight(segment: LoadSegment) -> bool:
    """Whether all loads of a segment of the load path are linear in time."""
    return all(
        load.segment is None or load.segment.is_straight for load in _loads_of_segment(segment)
    )


def loads_of(segment: LoadSegment, time: float) -> tuple[float, ...]:
    """The loads of a segment of the load path at an instant: P and Q. Where it has bulk stress or
    tilt there are five: also the bulk stresses of lower and upper body, and tilt or moment.
    """
    p, q = segment.loads(time)
    if segment.bulk is None and segment.tilt_and_moment is None:
        return float(p), float(q)
    return (float(p), float(q), *(load.value_at(time) for load in _bulk_and_tilt_loads(segment)))


def scaled_loads(segment: LoadSegment, time: float, units: tuple[float, ...]) -> tuple[float, ...]:
    """Loads of a segment of the load path at an instant, each over its unit: P and Q; with bulk
    stress or tilt also the bulk stresses of both bodies, and tilt or moment. There may be more
    units than loads.
    """
    return tuple(load / unit for load, unit in zip(loads_of(segment, time), units, strict=False))


def turning_points_of_combination(
    segment: LoadSegment, normal_weight: float, tangential_weight: float
) -> set[float]:
    """Turning points of the combination w_P P + w_Q Q of the loads inside one segment of a load
    path: instants at which its rate of change is zero and changes sign.

    Changes of sign between samples are located by secants. Where the combination is constant for
    a while, the start and the end of that time count.

    Parameters
    ----------
    segment
        segment of the load path: `rates` are dP/dt and dQ/dt at instants; P and Q may be another
        pair of loads, such as the two bulk stresses
    normal_weight, tangential_weight
        w_P and w_Q
    """
    # Rates at 721 samples of the segment or more; below 1e-12 of the largest they count as zero.
    times = sampled_times(segment, _N_SAMPLES)

    def rate(t: Array | float) -> Array:
        """Rate of the combination at instants t: w_P dP/dt + w_Q dQ/dt."""
        rate_of_p, rate_of_q = segment.rates(t)
        return np.asarray(normal_weight * rate_of_p + tangential_weight * rate_of_q)

    rates_at_samples = rate(times)
    largest_rate = np.abs(rates_at_samples).max(initial=0.0)
    rates_at_samples[np.abs(rates_at_samples) < 1e-12 * largest_rate] = 0.0

    # Instants at which the rate changes its sign.
    sign_changes = np.flatnonzero(rates_at_samples[:-1] * rates_at_samples[1:] < 0)

    def scaled_rate(time: float) -> float:
        """Rate at an instant, over the largest rate along the segment."""
        return float(rate(time) / largest_rate)

    instants = set()
    for sample in sign_changes.tolist():
        # share of the time between two samples after which a linear rate is zero
        share_to_zero = float(
            rates_at_samples[sample] / (rates_at_samples[sample] - rates_at_samples[sample + 1])
        )
        begin, end = times[sample : sample + 2].tolist()
        instants.add(
            time_of_zero(
                scaled_rate, begin, end, share_to_zero, rates_at_samples[sample] / largest_rate
            )
        )

    # Starts and ends of times without change.
    is_end_of_constancy = (rates_at_samples[1:-1] == 0) & (
        (rates_at_samples[:-2] != 0) | (rates_at_samples[2:] != 0)
    )
    return instants | {float(times[sample]) for sample in 1 + np.flatnonzero(is_end_of_constancy)}


def time_of_zero(
    function: Callable[[float], float],
    begin: float,
    end: float,
    first_fraction: float,
    value_at_begin: float,
) -> float:
    """Instant between `begin` and `end` at which a nearly linear function of time is zero: a gap, a
    force, a load or a rate, scaled. `end` where the function does not change sign.

    By secants; by a bracketing method where these leave the range or do not converge.

    Parameters
    ----------
    function
        of the time
    begin, end
        first and last instant of the search
    first_fraction
        share of the time between both at which the first secant starts
    value_at_begin
        of the function
    """
    time_before = begin
    value_before = value_at_begin
    time = begin + first_fraction * (end - begin)
    value = function(time)

    # Secants: at most 16; a value up to 1e-15 counts as zero.
    for _ in range(_MOST_SECANTS):
        if abs(value) <= _ZERO_ROUND_OFF:
            return time
        if value == value_before and time_before > begin:
            return time  # only round-off is left
        if value == value_before:
            break  # flat from the first instant on: no secant
        time_change = -value * (time - time_before) / (value - value_before)
        if abs(time_change) <= 4e-16 * abs(time):  # twice the spacing of floating-point numbers
            return time
        time_before = time
        value_before = value
        time += time_change
        if not begin <= time <= end:
            break
        value = function(time)

    # Bracketing.
    if not value_at_begin * function(end) < 0:
        return end
    # scipy.optimize is loaded here: a tenth of a second, which few solves need
    return float(scipy.optimize.brentq(function, begin, end, xtol=1e-15, rtol=8.9e-16))


def turning_points(segment: LoadSegment, friction: float) -> list[float]:
    """Instants inside one segment of a load path at which P, Q - f P, Q + f P, a bulk stress, tilt
    or moment turns round, ascending. There increments end, since slip starts or ends.

    `friction` is f. Instants closer than round-off to one another, 1e-9 of the segment's duration,
    count once; those as close to an end of the segment do not count.
    """
    # Turning points of P, Q - f P and Q + f P, by the weights of P and Q.
    all_times = turning_points_of_combination(segment, 1.0, 0.0)
    all_times |= turning_points_of_combination(segment, -friction, 1.0)
    all_times |= turning_points_of_combination(segment, friction, 1.0)
    if segment.bulk is not None or segment.tilt_and_moment is not None:
        # Each of these loads is a linear combination of a pair of loads that is stored like P and
        # Q, as a segment of its own; None where it is 0.
        for stress_or_tilt in _bulk_and_tilt_loads(segment):  # bulk stresses, and tilt or moment
            if stress_or_tilt.segment is not None:
                all_times |= turning_points_of_combination(
                    stress_or_tilt.segment, *stress_or_tilt.combination
                )

    least_distance = 1e-9 * (segment.end - segment.start)
    separate_times: list[float] = []
    for time in sorted(all_times):
        time_before = separate_times[-1] if separate_times else segment.start
        if min(time - time_before, segment.end - time) > least_distance:
            separate_times.append(time)
    return separate_times


def stretches(segment: LoadSegment, friction: float, n_increments: float) -> list[Stretch]:
    """Cut one segment of a load path at its turning points into stretches, and each of these into
    increments of equal duration.

    Parameters
    ----------
    segment
        segment of the load path
    friction
        coefficient f: Q - f P and Q + f P have turning points too
    n_increments
        of the whole segment; a stretch has a number in proportion to its duration, rounded up, and
        two at least

    Returns
    -------
    list of Stretch
        Each with the segment, its start, and the instants at which its increments end.
    """
    stretches_of_segment = []
    cut_times = [segment.start, *turning_points(segment, friction), segment.end]
    for start, end in itertools.pairwise(cut_times):
        unrounded_number = n_increments * (end - start) / (segment.end - segment.start)
        n_increments_of_stretch = max(2, int(np.ceil(unrounded_number)))
        ends_of_increments = np.linspace(start, end, n_increments_of_stretch + 1)[1:]
        stretches_of_segment.append(Stretch(segment, start, tuple(ends_of_increments)))
    return stretches_of_segment


# Gauss points and weights on an increment: the rest of an ellipse's area is below round-off from 24
# increments a revolution on.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def areas_between_path_and_chords(segment: LoadSegment, times: Array) -> Array | None:
    """Areas that a curved load path encloses with its chords in m increments, in the plane of each
    pair of k loads. (k, k, m) [unit of one load times that of the other].

    An area is the integral of F_i dF_j along the path minus that along the chord. It changes sign
    when i and j are exchanged, since the integral of d(F_i F_j) is equal along both. Integrated
    over time by eight Gauss points an increment. None of a straight path.

    # notation: F_i the i-th load (P, Q; with bulk stress or tilt also these)

    Parameters
    ----------
    segment
        segment of the load path
    times
        (m + 1,) ends of the increments
    """
    if is_straight(segment):
        return None
    # Each load is a linear combination of a pair of loads that a segment stores; it is 0 where that
    # segment is None.
    loads = _loads_of_segment(segment)

    # Gauss points and weights of the increments, (m, 8).
    start = times[:-1, None]
    end = times[1:, None]
    half_duration = (end - start) / 2
    # _POINTS: eight Gauss points from -1 to 1; _WEIGHTS: their weights
    instants = (start + end) / 2 + half_duration * _POINTS
    weights = _WEIGHTS * (end - start) / 2

    # `change_of` is the change of a load between two instants, `rate_of` its rate at instants.
    areas = np.zeros((len(loads), len(loads), len(start)))
    for i, load_i in enumerate(loads):
        if load_i.segment is None:
            continue
        change_since_start = load_i.segment.change_of(load_i.combination, instants, start)
        change_over_increment = load_i.segment.change_of(load_i.combination, end, start)
        # Counted from the mean of both ends, the chord's integral is zero.
        change_from_mean = change_since_start - change_over_increment / 2
        for j, load_j in enumerate(loads[:i]):
            if load_j.segment is None:
                continue
            rate_of_load_j = load_j.segment.rate_of(load_j.combination, instants)
            areas[i, j] = (weights * change_from_mean * rate_of_load_j).sum(axis=1)
            areas[j, i] = -areas[i, j]
    return areas


def check_admissible(path: LoadPath, friction: float, *, is_driven: bool = False) -> None:
    """Refuse a load path on which the bodies separate or slide as a whole, which the finite
    elements do not follow.

    Separation is P <= 1e-12 of the largest |P| of a segment, after the start of the path. Gross
    sliding is |Q| >= f P, but for Q = 0. Both are worst at turning points of P, Q - f P or Q + f P,
    so that looking there is exact, to 1e-14 of f times that load.

    Parameters
    ----------
    path
        loads over time
    friction
        coefficient f
    is_driven
        whether movements of actuators stand in the place of the loads: then gross sliding is
        allowed, and separation is looked for in the approach

    Raises
    ------
    InadmissibleLoadError
        At the worst instant of the first segment at fault.
    InputError
        For separation of a driven path.
    """
    for segment in path.segments(1):  # initial loading and one cycle
        # Loads where they may be worst: at turning points and ends.
        times = np.array([segment.start, *turning_points(segment, friction), segment.end])
        normal_load, tangential_load = segment.loads(times)
        is_after_start = times > path.start
        largest_load = float(np.abs(normal_load).max())

        # _LEAST_LOAD_RATIO: 1e-12
        is_separated = is_after_start & (normal_load <= _LEAST_LOAD_RATIO * largest_load)
        if is_separated.any():
            worst_index = int(np.argmin(np.where(is_separated, normal_load, np.inf)))
            worst_instant = LoadedInstant(
                times[worst_index], normal_load[worst_index], tangential_load[worst_index]
            )
            raise _separation_error(worst_instant, largest_load, friction, is_driven)
        if is_driven:
            continue

        force_beyond_limit = np.abs(tangential_load) - friction * normal_load
        # _ROUNDING_OF_LIMIT: 1e-14
        is_sliding = (
            is_after_start
            & (force_beyond_limit >= -_ROUNDING_OF_LIMIT * friction * largest_load)
            & (tangential_load != 0)
        )
        if is_sliding.any():
            worst_index = int(np.argmax(np.where(is_sliding, force_beyond_limit, -np.inf)))
            worst_instant = LoadedInstant(
                times[worst_index], normal_load[worst_index], tangential_load[worst_index]
            )
            # _ADVICE_ON_SLIDING: a sentence on what to change
            raise InadmissibleLoadError(
                "gross sliding", worst_instant, friction=friction, rule=_ADVICE_ON_SLIDING
            )


def _separation_error(
    worst_instant: LoadedInstant, largest_load: float, friction: float, is_driven: bool
) -> InadmissibleLoadError | InputError:
    """Error to raise for a load path on which the bodies separate, with time, loads and advice: an
    InputError where actuators drive the path, else an InadmissibleLoadError.

    `worst_instant` has the least normal load (or approach, where actuators drive the path);
    `largest_load` is the largest |P| of that segment. The advice depends on whether there is a
    little load left (P > 0), or none at all: up to 1e-14 of the largest the bodies are unloaded.
    """
    normal_load = worst_instant.normal_load
    if is_driven:
        return InputError(
            f"load: the bodies part at time {worst_instant.time:.6g}, where P or the approach is"
            f" {normal_load:.6g}; finite elements follow bodies that touch: keep it above 0, or"
            " take half-plane theory"
        )
    # _ADVICE_ON_LITTLE_LOAD, _ADVICE_ON_UNLOADING: sentences on what to change
    advice = _ADVICE_ON_LITTLE_LOAD if normal_load > 0 else ""
    largest_force = max(abs(normal_load), abs(worst_instant.tangential_load))
    # _ROUNDING_OF_LIMIT: 1e-14
    if largest_force <= _ROUNDING_OF_LIMIT * largest_load:
        advice = _ADVICE_ON_UNLOADING
    return InadmissibleLoadError("separation", worst_instant, friction=friction, rule=advice)
