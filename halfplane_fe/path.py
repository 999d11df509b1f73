"""The loads of a path; where its increments end: turning points, regular instants; where it leaves
the admissible region.

The loads are P and Q; where a path has bulk stress or tilt they are five: P, Q, sigma_lower,
sigma_upper, and tilt or moment.
"""

from __future__ import annotations

import itertools
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
    sampled,
)
from scenes.array_types import Array

# Samples a leg, at least, on which a sign change of a rate is looked for; a turning point and its
# twin closer than that are missed together.
_SAMPLES = 721
# Share of the largest load below which a load can't be told from none: the nodal forces are known
# to about so much of it.
_LEAST_LOAD = 1e-12
# Share of f times the largest load within which |Q| is f P.
_ROUNDING_OF_LIMIT = 1e-14
_LITTLE_LOAD = (
    "so little load, 1e-12 of the largest or less, finite elements can't tell from separation; the"
    " half-plane engine can"
)
_UNLOADED = (
    "finite elements need P > 0 after the start, for unloaded bodies have no place; half-plane"
    " theory takes full unloading, P = Q = 0: keep P > 0, or solve the scene by theory alone"
)
_SLIDING = (
    "finite elements need |Q| below f P (half-plane theory takes |Q| = f P too); lower the"
    " tangential load, raise the normal load or friction.coefficient"
)


@dataclass(frozen=True)
class Stretch:
    """A piece of a leg between turning points, with the instants at which regular increments
    end.
    """

    leg: LoadSegment
    start: float
    ends: tuple[float, ...]


def has_bulk_stress(path: LoadPath) -> bool:
    """Whether a body of the path has a bulk stress, be it 0 at times."""
    return path.initial_loading[0].bulk is not None


class _Load(NamedTuple):
    """One load of a leg: a combination of the pair of loads of a segment, or 0 without one."""

    segment: LoadSegment | None
    combination: Combination

    def at(self, time: float) -> float:
        """The load at an instant."""
        if self.segment is None:
            return 0.0
        pair = self.segment.loads(time)
        return sum(
            factor * float(load) for factor, load in zip(self.combination, pair, strict=True)
        )


def _loads(leg: LoadSegment) -> tuple[_Load, ...]:
    """The two or five loads of a leg."""
    normal_load = _Load(leg, NORMAL_LOAD)
    tangential_load = _Load(leg, TANGENTIAL_LOAD)
    if leg.bulk is None and leg.turning is None:
        return normal_load, tangential_load
    return (normal_load, tangential_load, *_imposed(leg))


def _imposed(leg: LoadSegment) -> tuple[_Load, _Load, _Load]:
    """Bulk stress of the lower and of the upper body, and tilt or moment."""
    bulk_lower = _Load(leg.bulk, NORMAL_LOAD)
    bulk_upper = _Load(leg.bulk, TANGENTIAL_LOAD)
    # Of tilt and moment one is 0 throughout.
    tilt_or_moment = _Load(leg.turning, Combination(1.0, 1.0))
    return bulk_lower, bulk_upper, tilt_or_moment


def straight(leg: LoadSegment) -> bool:
    """Whether all loads of a leg are linear in time."""
    return all(load.segment is None or load.segment.is_straight for load in _loads(leg))


def loads_of(leg: LoadSegment, time: float) -> tuple[float, ...]:
    """The two or five loads of a leg at an instant."""
    p, q = leg.loads(time)
    if leg.bulk is None and leg.turning is None:
        return float(p), float(q)
    return (float(p), float(q), *(load.at(time) for load in _imposed(leg)))


def scaled_loads(leg: LoadSegment, time: float, units: tuple[float, ...]) -> tuple[float, ...]:
    """The same, each over its unit; there may be more units than loads."""
    return tuple(load / unit for load, unit in zip(loads_of(leg, time), units, strict=False))


def turns(leg: LoadSegment, normal_weight: float, tangential_weight: float) -> set[float]:
    """Instants inside a leg at which the combination of loads, normal_weight P + tangential_weight
    Q, turns round: by signs of its rate at samples, refined by bracketing.
    """
    times = sampled(leg, _SAMPLES)

    def rate(t: Array | float) -> Array:
        p, q = leg.rates(t)
        return np.asarray(normal_weight * p + tangential_weight * q)

    rates = rate(times)
    rounding = 1e-12 * np.abs(rates).max(initial=0.0)
    rates[np.abs(rates) < rounding] = 0.0
    sign_changes = np.flatnonzero(rates[:-1] * rates[1:] < 0)
    instants = {
        float(scipy.optimize.brentq(lambda t: float(rate(t)), times[k], times[k + 1], xtol=1e-14))
        for k in sign_changes
    }
    is_end_of_rest = (rates[1:-1] == 0) & ((rates[:-2] != 0) | (rates[2:] != 0))
    return instants | {float(times[k]) for k in 1 + np.flatnonzero(is_end_of_rest)}


def turning_points(leg: LoadSegment, friction: float) -> list[float]:
    """Instants inside a leg at which P, Q - f P, Q + f P, a bulk stress, tilt or moment turn round,
    ascending.
    """
    all_times = turns(leg, 1.0, 0.0) | turns(leg, -friction, 1.0) | turns(leg, friction, 1.0)
    if leg.bulk is not None or leg.turning is not None:
        for segment, combination in _imposed(leg):
            if segment is not None:
                all_times |= turns(segment, *combination)
    rounding = 1e-9 * (leg.end - leg.start)
    separate_times: list[float] = []
    for time in sorted(all_times):
        time_before = separate_times[-1] if separate_times else leg.start
        if min(time - time_before, leg.end - time) > rounding:
            separate_times.append(time)
    return separate_times


def stretches(leg: LoadSegment, friction: float, increments: float) -> list[Stretch]:
    """A leg cut at its turning points, each piece into equal increments, `increments` of them in
    all (rounded up).
    """
    pieces = []
    cuts = [leg.start, *turning_points(leg, friction), leg.end]
    for start, end in itertools.pairwise(cuts):
        share_of_increments = increments * (end - start) / (leg.end - leg.start)
        n_increments = max(2, int(np.ceil(share_of_increments)))
        pieces.append(Stretch(leg, start, tuple(np.linspace(start, end, n_increments + 1)[1:])))
    return pieces


# Gauss points and weights on an increment: the rest of an ellipse's area is below round-off from 24
# increments a revolution on.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def enclosed(leg: LoadSegment, times: Array) -> Array | None:
    """Areas that a curved leg encloses with its chords between m + 1 times, by pairs of its k
    loads, (k, k, m): the integral of load i d load j along the leg minus that along the chords;
    None of a straight leg.

    It is skew: the integral of d(i j) is equal along both.
    """
    if straight(leg):
        return None
    loads = _loads(leg)
    start = times[:-1, None]
    end = times[1:, None]
    half_duration = (end - start) / 2
    instants = (start + end) / 2 + half_duration * _POINTS
    weights = _WEIGHTS * (end - start) / 2
    areas = np.zeros((len(loads), len(loads), len(start)))
    for i, load in enumerate(loads):
        if load.segment is None:
            continue
        change_since_start = load.segment.change_of(load.combination, instants, start)
        whole_change = load.segment.change_of(load.combination, end, start)
        change_from_middle = change_since_start - whole_change / 2
        for j, earlier_load in enumerate(loads[:i]):
            if earlier_load.segment is None:
                continue
            rate = earlier_load.segment.rate_of(earlier_load.combination, instants)
            areas[i, j] = (weights * change_from_middle * rate).sum(axis=1)
            areas[j, i] = -areas[i, j]
    return areas


def check_admissible(path: LoadPath, friction: float, *, is_driven: bool = False) -> None:
    """Refuse a path with separation or gross sliding (|Q| >= f P, with Q = 0 allowed), f =
    `friction`.

    Where the path `is_driven`, movements of actuators stand in the place of the loads: separation
    alone is seen beforehand, and gross sliding is allowed.

    Separation is P <= 0 after the start, or so little load that it can't be told from none. Both
    extremes are met at turning points, so looking there is exact: to 1e-14 of f times the largest
    load, in any unit and for any f. The half-plane engine admits |Q| = f P itself; here nothing
    sticks then, and the tangential displacement has no value.

    Raises
    ------
    InadmissibleLoadError
        At the worst instant of the first leg at fault.
    InputError
        For separation of a driven path.
    """
    for leg in path.legs(1):
        times = np.array([leg.start, *turning_points(leg, friction), leg.end])
        normal_load, tangential_load = leg.loads(times)
        is_on_path = times > path.start
        largest_load = float(np.abs(normal_load).max())
        is_separated = is_on_path & (normal_load <= _LEAST_LOAD * largest_load)
        if is_separated.any():
            worst_instant = int(np.argmin(np.where(is_separated, normal_load, np.inf)))
            if is_driven:
                raise InputError(
                    f"load: the bodies part at time {times[worst_instant]:.6g}, where P or the"
                    f" approach is {normal_load[worst_instant]:.6g}; finite elements follow bodies"
                    " that touch: keep it above 0, or take half-plane theory"
                )
            advice = _LITTLE_LOAD if normal_load[worst_instant] > 0 else ""
            if (
                max(abs(normal_load[worst_instant]), abs(tangential_load[worst_instant]))
                <= _ROUNDING_OF_LIMIT * largest_load
            ):
                advice = _UNLOADED
            raise InadmissibleLoadError(
                "separation",
                LoadedInstant(
                    times[worst_instant], normal_load[worst_instant], tangential_load[worst_instant]
                ),
                friction=friction,
                rule=advice,
            )
        if is_driven:
            continue
        excess_force = np.abs(tangential_load) - friction * normal_load
        is_sliding = (
            is_on_path
            & (excess_force >= -_ROUNDING_OF_LIMIT * friction * largest_load)
            & (tangential_load != 0)
        )
        if is_sliding.any():
            worst_instant = int(np.argmax(np.where(is_sliding, excess_force, -np.inf)))
            raise InadmissibleLoadError(
                "gross sliding",
                LoadedInstant(
                    times[worst_instant], normal_load[worst_instant], tangential_load[worst_instant]
                ),
                friction=friction,
                rule=_SLIDING,
            )
