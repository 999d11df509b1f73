"""The last cycle of a solution, on the points and instants of another, and the events of a cycle.

A NaN in a solution means "no such thing at this instant" only where it is said so; any other NaN
comes from the data and goes on to the verdict, where it fails.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import OPEN, ContactSolution, InputError, Scene, TimeSeriesLoad, freeze
from scenes.array_types import Array

_FIELDS = ("pressure", "shear", "slip")
_EDGES = ("contact_edges", "stick_edges")
_SERIES = ("normal_load", "tangential_load", "tangential_displacement", "normal_approach")
# Only of scenes with bulk stress, tilt or an unsymmetric profile.
OF_BULK = ("bulk_stress_lower", "bulk_stress_upper", "tilt", "moment", "shear_moment")

# Of a period: instants closer than this are one.
_SAME_FRACTION = 1e-9
# Of the range of x: points closer than this are one.
_SAME_POINT = 1e-12
# Of the largest pressure: less is none.
_NO_PRESSURE = 1e-12
# As many instants as the page names.
_EVENTS = 6


@dataclass(frozen=True, eq=False)
class Cycle:
    """The last whole cycle of a solution (the whole path, where it is not periodic), both ends
    included.
    """

    time: Array  # (k,), the solution's own times
    # (k,), 0 at the start of the path's cycle and 1 at its end; up to 2 where the instants start
    # elsewhere
    fraction: Array
    x: Array  # (n,) [length]
    # pressure, shear, slip, state: (k, n)
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    # contact_edges, stick_edges: (k, 2)
    contact_edges: Array
    stick_edges: Array
    # normal_load, tangential_load, tangential_displacement, normal_approach: (k,)
    normal_load: Array
    tangential_load: Array
    tangential_displacement: Array
    normal_approach: Array
    dissipation_density: Array  # (n,)
    # estimated largest error of the re-sampling, over the field's largest value; empty where
    # nothing was interpolated
    interpolation_errors: Mapping[str, float] = field(default_factory=dict)
    # False for the instants of a result that holds no whole cycle; `fraction` is then the time
    # itself
    is_whole: bool = True
    # bulk_stress_lower, bulk_stress_upper, tilt, moment, shear_moment: (k,), or None, as in the
    # solution
    bulk_stress_lower: Array | None = None
    bulk_stress_upper: Array | None = None
    tilt: Array | None = None
    moment: Array | None = None
    shear_moment: Array | None = None

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series over time that it has."""
        return (*_SERIES, *_stated_of_bulk(self))


def _stated_of_bulk(source: ContactSolution | Cycle) -> tuple[str, ...]:
    """Names of the series on bulk stress, tilt and moment that a solution or a cycle states."""
    return tuple(name for name in OF_BULK if getattr(source, name) is not None)


# --------------------------------------------------------------------- the last cycle of a solution


def last_cycle(solution: ContactSolution) -> Cycle:
    """Fields, edges and loads of the last whole cycle of `solution`, or of all its instants where
    it states that it holds no whole cycle. InputError where it should hold one and does not.
    """
    if "whole_cycle" in solution.work.skipped:
        return _all_instants(solution)
    steps = solution.last_cycle
    if len(steps) < 2:
        raise InputError(
            f"{solution.engine}: the solution holds no whole cycle (its times run from"
            f" {solution.time[0]:.6g} to {solution.time[-1]:.6g}); solve at least one revolution"
        )
    time = solution.time[steps]
    fraction = (time - time[0]) / (time[-1] - time[0])
    start = _start_of_cycle(solution, time[0])
    return _cycle_of_steps(solution, steps, fraction + start, is_whole=True)


def _start_of_cycle(solution: ContactSolution, time: float) -> float:
    """Share of a period by which a cycle that starts at `time` is behind one of the load path."""
    path = solution.scene.load.path()
    if path.period is None:
        return 0.0
    lag = float(np.mod((time - path.cycle_start) / path.period, 1.0))
    starts_together = min(lag, 1 - lag) < _SAME_FRACTION
    return 0.0 if starts_together else lag


def _all_instants(solution: ContactSolution) -> Cycle:
    """Every instant of `solution`, `fraction` being the time."""
    steps = np.arange(len(solution.time))
    return _cycle_of_steps(solution, steps, solution.time, is_whole=False)


def _cycle_of_steps(
    solution: ContactSolution, steps: NDArray[np.intp], fraction: Array, *, is_whole: bool
) -> Cycle:
    """Fields, edges and loads of a solution at the instants of one cycle.

    Parameters
    ----------
    steps
        (k,) indices of the instants in the solution
    fraction
        (k,) share of the period that is over at each; the time where they are no whole cycle
    is_whole
        whether they are a whole cycle
    """

    def array_at_steps(name: str) -> Any:
        """The named array of the solution at these instants, read-only."""
        # Those of a path that is one cycle are not copied: of a long record they take tens of
        # megabytes each.
        values = getattr(solution, name)
        return values if len(steps) == len(values) else freeze(values[steps], values.dtype)

    names = (*_FIELDS, "state", *_EDGES, *_SERIES, *_stated_of_bulk(solution))
    values: dict[str, Any] = {name: array_at_steps(name) for name in names}
    return Cycle(
        time=freeze(solution.time[steps]),
        fraction=freeze(fraction),
        is_whole=is_whole,
        x=solution.x,
        dissipation_density=solution.dissipation_density,
        **values,
    )


# ------------------------------------------------------------ on the points and instants of another


def sample_instants(reference: ContactSolution, like: Cycle) -> Cycle:
    """The reference solution interpolated to the times and points of a result that holds no whole
    cycle (`like`). For times after the reference's end its last cycle is taken again.
    """
    whole_reference = _all_instants(reference)
    if np.array_equal(whole_reference.time, like.time):
        return sample(whole_reference, like, reference.engine)

    period = reference.scene.load.path().period
    time_in_path = like.time
    if period is not None:
        time_after_end = np.maximum(like.time - whole_reference.time[-1], 0.0)
        periods_after_end = np.ceil(time_after_end / period - _SAME_FRACTION)
        time_in_path = like.time - period * periods_after_end
    sampled_cycle = sample(
        whole_reference, replace(like, fraction=freeze(time_in_path)), reference.engine
    )
    return replace(sampled_cycle, time=like.time, fraction=like.time)


def sample(cycle: Cycle, like: Cycle, engine: str) -> Cycle:
    """A cycle of one solution interpolated to the points and instants of another solution's cycle,
    `like`; the same cycle where these are the same already.

    Instants are matched by the fraction of the cycle, since two engines may have needed different
    numbers of revolutions. Linear in x and in time; the state is that of the nearest point and
    instant. `interpolation` of the answer states the error of that, estimated by leaving out every
    second sample: of 320 spacings at a square-root edge, where it converges slowest, one in a
    hundred at most errs by more. `engine` names the cycle in messages.

    Raises
    ------
    InputError
        Where `like` asks for points at which `cycle` still carries pressure beyond its own range.
    """
    starts_elsewhere = like.fraction[-1] > cycle.fraction[-1] + _SAME_FRACTION
    if starts_elsewhere and cycle.is_whole and like.is_whole:
        return _sample_from_elsewhere(cycle, like, engine)

    error_by_field: dict[str, float] = {}
    if not _are_same_places(cycle.fraction, like.fraction, _SAME_FRACTION):
        cycle, error_by_field = _at_instants(cycle, like)
    if not _are_same_places(cycle.x, like.x, _SAME_POINT * float(np.ptp(like.x))):
        _refuse_points_beyond(cycle, like.x, engine)
        cycle, error_in_x = _at_points(cycle, like.x)
        for name, value in error_in_x.items():
            error_by_field[name] = error_by_field.get(name, 0.0) + value
    return replace(cycle, interpolation_errors=error_by_field)


def _are_same_places(places: Array, other_places: Array, tolerance: float) -> bool:
    """Whether two sets of points or instants are the same to `tolerance`."""
    return len(places) == len(other_places) and np.allclose(
        places, other_places, rtol=0, atol=tolerance
    )


def _sample_from_elsewhere(cycle: Cycle, like: Cycle, engine: str) -> Cycle:
    """A cycle interpolated to the points and instants of another solution's cycle, `like`, that
    starts later in the load path's cycle and so ends in the next one.

    Instants in the next cycle are moved one period back, all are interpolated in the order of time,
    and the results are put back into the order of `like`.

    Parameters
    ----------
    cycle
        the cycle that is interpolated
    like
        the cycle whose points and instants it is put on
    engine
        name of the engine of `cycle`, for messages
    """
    is_in_next_cycle = like.fraction > 1 + _SAME_FRACTION
    fraction_in_cycle = like.fraction - np.where(is_in_next_cycle, 1.0, 0.0)
    indices_by_time = np.argsort(fraction_in_cycle, kind="stable")
    like_in_order = replace(
        like,
        fraction=freeze(fraction_in_cycle[indices_by_time]),
        time=freeze(like.time[indices_by_time]),
    )
    sampled_cycle = sample(cycle, like_in_order, engine)

    # the inverse of the sorting
    places_in_like = np.argsort(indices_by_time, kind="stable")
    over_time: dict[str, Any] = {}
    for name in (*_FIELDS, "state", *_EDGES, *sampled_cycle.series):
        values = getattr(sampled_cycle, name)
        over_time[name] = freeze(values[places_in_like], values.dtype)
    return replace(sampled_cycle, time=like.time, fraction=like.fraction, **over_time)


def _refuse_points_beyond(cycle: Cycle, x: Array, engine: str) -> None:
    """InputError, naming `engine`, where `x` has points beyond an end of `cycle` at which it still
    carries pressure: nothing is known there.
    """
    pressure_at_ends = np.max(cycle.pressure[:, [0, -1]], axis=0)
    carries_left, carries_right = pressure_at_ends > _NO_PRESSURE * np.max(cycle.pressure)
    beyond_left = x[0] < cycle.x[0]
    beyond_right = x[-1] > cycle.x[-1]
    if (carries_left and beyond_left) or (carries_right and beyond_right):
        raise InputError(
            f"{engine}: its points end at x = {cycle.x[0]:.6g} and {cycle.x[-1]:.6g} where it"
            " still carries pressure, short of the points that it is compared at; give it"
            " points out to the largest contact"
        )


def _at_instants(cycle: Cycle, like: Cycle) -> tuple[Cycle, dict[str, float]]:
    """Interpolate a cycle to the instants of another solution's cycle, `like`. Returned with it: an
    estimate of the interpolation error of each field and edge, over its largest value.

    Interpolation is linear in the fraction of the cycle; states are those of the nearest instant.
    """
    sampled_values: dict[str, Any] = {}
    for name in (*_FIELDS, *_EDGES, *cycle.series):
        sampled_values[name] = freeze(_linear(like.fraction, cycle.fraction, getattr(cycle, name)))
    nearest_instants = _nearest(like.fraction, cycle.fraction)
    sampled_cycle = replace(
        cycle,
        time=like.time,
        fraction=like.fraction,
        state=freeze(cycle.state[nearest_instants], np.int8),
        **sampled_values,
    )
    given_values = {name: getattr(cycle, name) for name in (*_FIELDS, *_EDGES)}
    return sampled_cycle, _errors(cycle.fraction, given_values)


def _at_points(cycle: Cycle, x: Array) -> tuple[Cycle, dict[str, float]]:
    """Interpolate a cycle to the surface points `x`. Returned with it: an estimate of the
    interpolation error of each field and of the pointwise dissipation, over its largest value.

    Interpolation is linear in x; states are those of the nearest point, and open beyond the range
    of the cycle's points.
    """
    # points first, as `_linear` takes them: (n_points, k), the pointwise dissipation (n_points,)
    given_values: dict[str, Array] = {
        name: getattr(cycle, name).T for name in (*_FIELDS, "dissipation_density")
    }
    sampled_values: dict[str, Any] = {}
    for name, values in given_values.items():
        sampled_values[name] = freeze(_linear(x, cycle.x, values).T)
    is_beyond = (x < cycle.x[0]) | (x > cycle.x[-1])
    nearest_points = _nearest(x, cycle.x)
    state = np.where(is_beyond, OPEN, cycle.state[:, nearest_points])
    sampled_cycle = replace(cycle, x=x, state=freeze(state, np.int8), **sampled_values)
    return sampled_cycle, _errors(cycle.x, given_values)


def _nearest(places: Array, samples: Array) -> NDArray[np.intp]:
    """Index of the sample that is nearest to each place."""
    return np.asarray(np.abs(samples[:, None] - places).argmin(axis=0))


def _errors(samples: Array, values_at_samples: Mapping[str, Array]) -> dict[str, float]:
    """`_halving` of each of the values, by name."""
    return {name: _halving(samples, values) for name, values in values_at_samples.items()}


def _linear(places: Array, samples: Array, values: Array) -> Array:
    """Linear interpolation of values with any number of further axes; constant beyond the samples.

    Parameters
    ----------
    places
        (k,) where values are wanted
    samples
        (n,) where they are given, ascending
    values
        (n, ...)

    Returns
    -------
    Array
        (k, ...); a NaN of a sample spoils no place that lies at another sample
    """
    sample_above = np.clip(np.searchsorted(samples, places, side="right"), 1, len(samples) - 1)
    sample_below = sample_above - 1
    spacing = samples[sample_above] - samples[sample_below]
    weight = np.clip((places - samples[sample_below]) / spacing, 0.0, 1.0)
    weight = weight.reshape(-1, *(1,) * (values.ndim - 1))
    value_below = values[sample_below]
    value_above = values[sample_above]
    interpolated = (1 - weight) * value_below + weight * value_above
    # A weight of exactly 0 or 1 must not let a NaN of the other end in.
    interpolated = np.where(weight == 1, value_above, interpolated)
    return np.where(weight == 0, value_below, interpolated)


def _halving(samples: Array, values: Array) -> float:
    """Estimate the error of linear interpolation between samples: every second one is left out and
    interpolated from the others; the largest difference is returned, over the largest |value|.

    Both halves of the samples are left out in turn, since the error at a square-root edge depends
    on where in an interval it lies.

    Parameters
    ----------
    samples
        (n,) places or instants, ascending
    values
        (n, ...) at the samples
    """
    largest_value = float(np.nanmax(np.abs(values), initial=0.0))
    if len(samples) < 4 or largest_value == 0.0:
        return 0.0
    worst_error = 0.0
    for first_row_left_out in (1, 2):
        rows_left_out = np.arange(first_row_left_out, len(samples) - 1, 2)
        rows_kept = np.delete(np.arange(len(samples)), rows_left_out)
        interpolated_values = _linear(samples[rows_left_out], samples[rows_kept], values[rows_kept])
        difference = np.abs(interpolated_values - values[rows_left_out])
        worst_error = max(worst_error, float(np.nanmax(difference, initial=0.0)))
    return worst_error / largest_value


# ------------------------------------------------------------------------------------------- events


@dataclass(frozen=True)
class Event:
    """An instant of the last cycle: its index in the cycle and what happens there."""

    index: int
    label: str


def events(cycle: Cycle, friction: float, first_index: int = 0) -> tuple[Event, ...]:
    """Six instants of a cycle to be shown, in the order of time, none before the index
    `first_index`: extremes of P, Q, Q − f P and Q + f P, then those furthest from all chosen.

    All where there are fewer. Without bulk stress and tilt Q − f P is largest where forward slip
    ends, Q + f P least where reverse slip ends.
    """
    labels = _extremes(cycle, friction, first_index)
    if not labels:
        labels[first_index] = "the only instant" if len(cycle.time) == 1 else "between"
    for _ in range(min(_EVENTS, len(cycle.time) - 1) - len(labels)):
        distance = _distance_in_time(cycle, labels)
        distance[:first_index] = 0.0
        farthest_row = int(np.argmax(distance))
        # instants may share one time, where a result was placed on the path by its loads
        if distance[farthest_row] <= 0:
            break
        labels[farthest_row] = "between"
    return tuple(Event(index, labels[index]) for index in sorted(labels))


def first_row(cycle: Cycle, scene: Scene) -> int:
    """Index of the first instant of a cycle that lies on the rows of a record of loads: the path
    before it leads from no load to the first row. 0 of other loads.
    """
    if not isinstance(scene.load, TimeSeriesLoad):
        return 0
    time = float(scene.load.used_rows().values[0][0])
    return min(int(np.searchsorted(cycle.time, time)), len(cycle.time) - 1)


def _extremes(cycle: Cycle, friction: float, first_index: int) -> dict[int, str]:
    """Instants of a cycle at which P, Q, Q − f P or Q + f P is largest or least, with a label for
    each: index -> label. Of several equal instants the first counts; instants before `first_index`,
    and quantities that are constant, are left out.
    """
    normal_load = cycle.normal_load[first_index:]
    tangential_load = cycle.tangential_load[first_index:]
    # With bulk stress or tilt each edge has a law of its own, and slip ends elsewhere.
    ends_slip = cycle.tilt is None and cycle.shear_moment is None
    label_of_largest = "forward slip ends" if ends_slip else "Q − f P largest"
    label_of_least = "reverse slip ends" if ends_slip else "Q + f P least"
    quantities = {
        "P largest": normal_load,
        "P least": -normal_load,
        "Q largest": tangential_load,
        "Q least": -tangential_load,
        label_of_largest: tangential_load - friction * normal_load,
        label_of_least: -tangential_load - friction * normal_load,
    }
    scale = float(np.max(np.abs(normal_load)))
    labels: dict[int, str] = {}
    for label, quantity in quantities.items():
        if np.ptp(quantity) > 1e-9 * scale:
            # The first instant, to rounding: the end of a cycle repeats its start.
            is_largest = quantity >= np.max(quantity) - 1e-12 * scale
            labels.setdefault(first_index + int(np.flatnonzero(is_largest)[0]), label)
    return labels


def _distance_in_time(cycle: Cycle, instants: Iterable[int]) -> Array:
    """Distance of each instant to the nearest of `instants`, as a fraction of the cycle, (k,)."""
    distance = np.abs(cycle.fraction[:, None] - cycle.fraction[list(instants)])
    if cycle.is_whole:  # its end is its start
        distance = np.minimum(distance, 1 - distance)
    return np.asarray(distance.min(axis=1))
