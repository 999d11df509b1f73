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

from scenes import OPEN, ContactSolution, InputError, Scene, TimeSeriesLoad, read_only_copy
from scenes.array_types import Array

_FIELD_NAMES = ("pressure", "shear", "slip")
_EDGE_NAMES = ("contact_edges", "stick_edges")
_SERIES_NAMES = ("normal_load", "tangential_load", "tangential_displacement", "normal_approach")
# Only of scenes with bulk stress, tilt or an unsymmetric profile.
NAMES_OF_BULK_SERIES = ("bulk_stress_lower", "bulk_stress_upper", "tilt", "moment", "shear_moment")

# Instants closer than this share of a period are the same.
_FRACTION_TOLERANCE = 1e-9
# Points closer than this share of the range of x are the same.
_POINT_TOLERANCE = 1e-12
# A pressure below this share of the largest counts as zero.
_LEAST_PRESSURE_SHARE = 1e-12
_N_EVENTS = 6  # instants that the page names


@dataclass(frozen=True, eq=False)
class Cycle:
    """The last whole cycle of a solution (the whole path, where it is not periodic), both ends
    included.
    """

    time: Array  # (k,), the solution's own times
    # (k,), 0 at the start of a cycle of the load path and 1 at its end; up to 2 where the instants
    # start within a cycle of the load path and end in the next one
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
    # name of a field -> estimated largest error of its interpolation, over its largest value;
    # empty where nothing was interpolated
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
    def series_names(self) -> tuple[str, ...]:
        """Names of the loads, displacements, ... that this cycle holds, (k,) each."""
        return (*_SERIES_NAMES, *_names_of_bulk_series(self))


def _names_of_bulk_series(source: ContactSolution | Cycle) -> tuple[str, ...]:
    """Names of the series on bulk stress, tilt and moment that a solution or a cycle states."""
    return tuple(name for name in NAMES_OF_BULK_SERIES if getattr(source, name) is not None)


# --------------------------------------------------------------------- the last cycle of a solution


def last_cycle(solution: ContactSolution) -> Cycle:
    """Fields, edges and loads of the last whole cycle of `solution`. Of all its instants where it
    states, in `work.skipped`, that it holds no whole cycle. InputError where it should hold one and
    does not.

    `fraction` of the returned cycle (k,) is the place of each instant in the period of the load
    path: 0 where a period starts, 1 where it ends.
    """
    if "whole_cycle" in solution.work.skipped:
        return _cycle_of_all_instants(solution)
    indices = solution.last_cycle  # of the instants of the last whole cycle, both ends included
    if len(indices) < 2:
        raise InputError(
            f"{solution.engine}: the solution holds no whole cycle (its times run from"
            f" {solution.time[0]:.6g} to {solution.time[-1]:.6g}); solve at least one revolution"
        )
    time = solution.time[indices]
    fraction_since_start = (time - time[0]) / (time[-1] - time[0])
    # instants are placed in the period of the load path, which may start earlier
    fraction = fraction_since_start + _fraction_at_start(solution, time[0])
    return _cycle_at_instants(solution, indices, fraction, is_whole=True)


def _fraction_at_start(solution: ContactSolution, time: float) -> float:
    """Fraction of the load path's period, 0 to 1, that is over at `time`; 0 without a period."""
    path = solution.scene.load.path()
    if path.period is None:
        return 0.0
    lag = float(np.mod((time - path.cycle_start) / path.period, 1.0))
    starts_together = min(lag, 1 - lag) < _FRACTION_TOLERANCE
    return 0.0 if starts_together else lag


def _cycle_of_all_instants(solution: ContactSolution) -> Cycle:
    """Every instant of a solution that holds no whole cycle. `fraction` is the time itself."""
    indices = np.arange(len(solution.time))
    return _cycle_at_instants(solution, indices, solution.time, is_whole=False)


def _cycle_at_instants(
    solution: ContactSolution, indices: NDArray[np.intp], fraction: Array, *, is_whole: bool
) -> Cycle:
    """Fields, edges and loads of a solution at the instants of one cycle.

    Parameters
    ----------
    indices
        (k,) indices of the instants in the solution
    fraction
        (k,) fraction of the load path's period that is over at each instant; the time itself where
        the instants are no whole cycle
    is_whole
        whether the instants are a whole cycle
    """

    def array_at_instants(name: str) -> Any:
        """The named array of the solution at the instants, read-only."""
        array = getattr(solution, name)
        # Arrays of a path that is one cycle are not copied: those of a long record take tens of
        # megabytes each.
        if len(indices) == len(array):
            return array
        return read_only_copy(array[indices], array.dtype)

    # fields (k, n), edges (k, 2), loads and displacements (k,), bulk stress and tilt where stated
    names = (*_FIELD_NAMES, "state", *_EDGE_NAMES, *_SERIES_NAMES, *_names_of_bulk_series(solution))
    array_by_name: dict[str, Any] = {name: array_at_instants(name) for name in names}
    return Cycle(
        time=read_only_copy(solution.time[indices]),
        fraction=read_only_copy(fraction),
        is_whole=is_whole,
        x=solution.x,
        dissipation_density=solution.dissipation_density,
        **array_by_name,
    )


# ------------------------------------------------------------ on the points and instants of another


def cycle_interpolated_by_time(reference: ContactSolution, target_cycle: Cycle) -> Cycle:
    """All instants of a reference solution, interpolated to the times and points of
    `target_cycle`, which holds the instants of a result without a whole cycle.

    Instants are matched by their times: a target time after the end of the reference is moved back
    by whole periods, into the last cycle of the reference. In both cycles `fraction` is the time
    itself. Times within 1e-9 of a period are the same.
    """
    reference_cycle = _cycle_of_all_instants(reference)
    if np.array_equal(reference_cycle.time, target_cycle.time):
        return interpolated_cycle(reference_cycle, target_cycle, reference.engine)

    period = reference.scene.load.path().period
    time_in_path = target_cycle.time
    if period is not None:
        time_after_end = np.maximum(target_cycle.time - reference_cycle.time[-1], 0.0)
        periods_after_end = np.ceil(time_after_end / period - _FRACTION_TOLERANCE)
        time_in_path = target_cycle.time - period * periods_after_end
    sampled_cycle = interpolated_cycle(
        reference_cycle,
        replace(target_cycle, fraction=read_only_copy(time_in_path)),
        reference.engine,
    )
    return replace(sampled_cycle, time=target_cycle.time, fraction=target_cycle.time)


def interpolated_cycle(cycle: Cycle, target_cycle: Cycle, engine: str) -> Cycle:
    """A cycle of one solution interpolated to the points and instants of another solution's cycle,
    `target_cycle`; the values of `cycle` itself where both have the same points and instants.

    Instants are matched by the fraction of the load period, since two engines may have needed
    different numbers of revolutions. Interpolation is linear in x and in time; the state (stick,
    slip, open) is that of the nearest point and instant. Instants within 1e-9 of a period are the
    same, and points within 1e-12 of the range of x.

    `interpolation_errors` of the returned cycle are estimated by leaving out every second sample.
    At a square-root edge, where interpolation converges slowest, the error exceeded the estimate
    for at most one in a hundred of 320 spacings. `engine` names `cycle` in messages.

    Raises
    ------
    InputError
        Where `target_cycle` has points beyond an end of `cycle` at which there is still pressure.
    """
    # `fraction` (k,): place of each instant in the period of the load path, from 0 to 1. Above 1
    # the target starts within a period and ends in the next one.
    starts_later = target_cycle.fraction[-1] > cycle.fraction[-1] + _FRACTION_TOLERANCE
    if starts_later and cycle.is_whole and target_cycle.is_whole:
        return _interpolated_for_later_start(cycle, target_cycle, engine)

    # name of a field -> estimated error of its interpolation, over its largest value
    error_by_field: dict[str, float] = {}
    if not _are_same_places(cycle.fraction, target_cycle.fraction, _FRACTION_TOLERANCE):
        cycle, error_by_field = _interpolate_to_instants(cycle, target_cycle)
    if not _are_same_places(
        cycle.x, target_cycle.x, _POINT_TOLERANCE * float(np.ptp(target_cycle.x))
    ):
        _refuse_points_beyond(cycle, target_cycle.x, engine)
        cycle, error_in_x_by_field = _interpolate_to_points(cycle, target_cycle.x)
        for name, error in error_in_x_by_field.items():
            error_by_field[name] = error_by_field.get(name, 0.0) + error
    return replace(cycle, interpolation_errors=error_by_field)


def _are_same_places(places: Array, other_places: Array, tolerance: float) -> bool:
    """Whether two sets of points or instants are the same to `tolerance`."""
    return len(places) == len(other_places) and np.allclose(
        places, other_places, rtol=0, atol=tolerance
    )


def _interpolated_for_later_start(cycle: Cycle, target_cycle: Cycle, engine: str) -> Cycle:
    """A cycle interpolated to the points and instants of another solution's cycle, `target_cycle`,
    that starts later in the period of the load path: its last instants, of fraction above 1, lie in
    the next period.

    Those instants are moved one period back. All are then interpolated in the order of time, and
    the values are put back into the order of `target_cycle`. `engine` names `cycle` in messages.
    `fraction` (k,) is the place of an instant in the period: 0 at its start, 1 at its end.
    """
    is_in_next_period = target_cycle.fraction > 1 + _FRACTION_TOLERANCE
    fraction_in_period = target_cycle.fraction - np.where(is_in_next_period, 1.0, 0.0)
    indices_by_time = np.argsort(fraction_in_period, kind="stable")
    target_in_order = replace(
        target_cycle,
        fraction=read_only_copy(fraction_in_period[indices_by_time]),
        time=read_only_copy(target_cycle.time[indices_by_time]),
    )
    sampled_cycle = interpolated_cycle(cycle, target_in_order, engine)

    # the inverse of the sorting: index, in the order of time, of each instant of the target
    indices_in_order = np.argsort(indices_by_time, kind="stable")
    array_by_name: dict[str, Any] = {}
    # fields (k, n), states (k, n), edges (k, 2), loads and displacements (k,)
    for name in (*_FIELD_NAMES, "state", *_EDGE_NAMES, *sampled_cycle.series_names):
        array = getattr(sampled_cycle, name)
        array_by_name[name] = read_only_copy(array[indices_in_order], array.dtype)
    return replace(
        sampled_cycle, time=target_cycle.time, fraction=target_cycle.fraction, **array_by_name
    )


def _refuse_points_beyond(cycle: Cycle, x: Array, engine: str) -> None:
    """InputError, naming `engine`, where `x` (ascending) has points beyond the first or last point
    of `cycle`, and there is still pressure at that point at some instant: nothing is known beyond
    it. Pressures up to 1e-12 of the largest count as zero. `cycle.pressure` is (k instants, n
    points).
    """
    pressure_at_ends = np.max(cycle.pressure[:, [0, -1]], axis=0)
    least_pressure = _LEAST_PRESSURE_SHARE * np.max(cycle.pressure)
    is_loaded_at_left_end, is_loaded_at_right_end = pressure_at_ends > least_pressure
    has_points_beyond_left_end = x[0] < cycle.x[0]
    has_points_beyond_right_end = x[-1] > cycle.x[-1]
    if (is_loaded_at_left_end and has_points_beyond_left_end) or (
        is_loaded_at_right_end and has_points_beyond_right_end
    ):
        raise InputError(
            f"{engine}: its points end at x = {cycle.x[0]:.6g} and {cycle.x[-1]:.6g} where it"
            " still carries pressure, short of the points that it is compared at; give it"
            " points out to the largest contact"
        )


def _interpolate_to_instants(cycle: Cycle, target_cycle: Cycle) -> tuple[Cycle, dict[str, float]]:
    """Interpolate a cycle to the instants of another solution's cycle, `target_cycle`.

    Returns the interpolated cycle, and an estimate of the interpolation error of each field (k, n)
    and edge (k, 2), over its largest value. Interpolation is linear in `fraction` (k,), the place
    of an instant in the period of the load path, 0 at its start and 1 at its end; states (stick,
    slip, open) are those of the nearest instant.
    """
    sampled_values: dict[str, Any] = {}
    # pressure, shear and slip; edges of contact and stick; loads and displacements
    for name in (*_FIELD_NAMES, *_EDGE_NAMES, *cycle.series_names):
        sampled_values[name] = read_only_copy(
            _interpolate_linearly(target_cycle.fraction, cycle.fraction, getattr(cycle, name))
        )
    nearest_indices = _nearest_indices(target_cycle.fraction, cycle.fraction)
    sampled_cycle = replace(
        cycle,
        time=target_cycle.time,
        fraction=target_cycle.fraction,
        state=read_only_copy(cycle.state[nearest_indices], np.int8),
        **sampled_values,
    )
    given_values = {name: getattr(cycle, name) for name in (*_FIELD_NAMES, *_EDGE_NAMES)}
    return sampled_cycle, _interpolation_errors(cycle.fraction, given_values)


def _interpolate_to_points(cycle: Cycle, x: Array) -> tuple[Cycle, dict[str, float]]:
    """Interpolate a cycle to the surface points `x`.

    Returns the interpolated cycle, and an estimate of the interpolation error of each field and of
    the pointwise dissipation, over its largest value. Interpolation is linear in x; states (stick,
    slip, open) are those of the nearest point, and open beyond the range of the cycle's points.
    """
    # Pressure, shear and slip with points along the first axis, (n_points, k instants), since the
    # interpolation is along that; the pointwise dissipation is (n_points,).
    given_values: dict[str, Array] = {
        name: getattr(cycle, name).T for name in (*_FIELD_NAMES, "dissipation_density")
    }
    sampled_values: dict[str, Any] = {}
    for name, values in given_values.items():
        sampled_values[name] = read_only_copy(_interpolate_linearly(x, cycle.x, values).T)
    is_beyond_range = (x < cycle.x[0]) | (x > cycle.x[-1])
    nearest_indices = _nearest_indices(x, cycle.x)
    states_at_points = np.where(is_beyond_range, OPEN, cycle.state[:, nearest_indices])
    sampled_cycle = replace(
        cycle, x=x, state=read_only_copy(states_at_points, np.int8), **sampled_values
    )
    return sampled_cycle, _interpolation_errors(cycle.x, given_values)


def _nearest_indices(places: Array, samples: Array) -> NDArray[np.intp]:
    """(k,) index of the nearest of `samples` (n,) to each of `places` (k,)."""
    return np.asarray(np.abs(samples[:, None] - places).argmin(axis=0))


def _interpolation_errors(
    samples: Array, values_at_samples: Mapping[str, Array]
) -> dict[str, float]:
    """Estimated error of linear interpolation between `samples`, for each named array, over its
    largest |value|.
    """
    return {
        name: _interpolation_error(samples, values) for name, values in values_at_samples.items()
    }


def _interpolate_linearly(places: Array, samples: Array, values: Array) -> Array:
    """Linear interpolation of values along their first axis; constant beyond the samples.

    Parameters
    ----------
    places
        (k,) points or instants to interpolate to
    samples
        (n,) points or instants of the values, ascending
    values
        (n, ...) values at the samples

    Returns
    -------
    Array
        (k, ...) values at the places. NaN where a neighbouring sample has NaN, except at a place
        that coincides with the other sample
    """
    index_of_upper_sample = np.clip(
        np.searchsorted(samples, places, side="right"), 1, len(samples) - 1
    )
    index_of_lower_sample = index_of_upper_sample - 1
    spacing = samples[index_of_upper_sample] - samples[index_of_lower_sample]
    # of the sample above, with as many axes as the values
    weight = np.clip((places - samples[index_of_lower_sample]) / spacing, 0.0, 1.0)
    weight = weight.reshape(-1, *(1,) * (values.ndim - 1))
    lower_value = values[index_of_lower_sample]
    upper_value = values[index_of_upper_sample]
    interpolated_values = (1 - weight) * lower_value + weight * upper_value
    # A weight of exactly 0 or 1 must not let a NaN of the other sample in.
    interpolated_values = np.where(weight == 1, upper_value, interpolated_values)
    return np.where(weight == 0, lower_value, interpolated_values)


def _interpolation_error(samples: Array, values: Array) -> float:
    """Estimate the error of linear interpolation between samples: every second sample is left out
    and interpolated from the others. Returns the largest difference over the largest |value|; 0 for
    fewer than four samples, or where all values are 0. A NaN is left out.

    The even and the odd samples are left out in turn, since the error at a square-root edge depends
    on the place of the edge between two samples.

    Parameters
    ----------
    samples
        (n,) points or instants, ascending
    values
        (n, ...) values at the samples
    """
    largest_value = float(np.nanmax(np.abs(values), initial=0.0))
    if len(samples) < 4 or largest_value == 0.0:
        return 0.0
    worst_error = 0.0
    for first_index in (1, 2):
        omitted_indices = np.arange(first_index, len(samples) - 1, 2)
        remaining_indices = np.delete(np.arange(len(samples)), omitted_indices)
        interpolated_values = _interpolate_linearly(
            samples[omitted_indices], samples[remaining_indices], values[remaining_indices]
        )
        difference = np.abs(interpolated_values - values[omitted_indices])
        worst_error = max(worst_error, float(np.nanmax(difference, initial=0.0)))
    return worst_error / largest_value


# ------------------------------------------------------------------------------------------- events


@dataclass(frozen=True)
class Event:
    """An instant of the last cycle: its index in the cycle and what happens there."""

    index: int
    label: str


def events(cycle: Cycle, friction_coefficient: float, first_index: int = 0) -> tuple[Event, ...]:
    """At most six instants of a cycle for the page to show, in the order of time, none before the
    index `first_index`. `friction_coefficient` is the coefficient f.

    First come the largest and the least P and Q, the largest Q − f P and the least Q + f P; of
    loads that are constant the first instant. Then the instant with the largest distance in time
    from all chosen ones is added, until there are six, or all instants but one are chosen: the end
    of a cycle repeats its start. Without bulk stress and tilt forward slip ends at the largest
    Q − f P, reverse slip at the least Q + f P.
    """
    # index of the instant in the cycle -> what happens there, such as "P largest"
    label_by_index = _labels_of_extremes(cycle, friction_coefficient, first_index)
    if not label_by_index:
        label_by_index[first_index] = "the only instant" if len(cycle.time) == 1 else "between"
    for _ in range(min(_N_EVENTS, len(cycle.time) - 1) - len(label_by_index)):
        # (k,) time from each instant to the nearest chosen one
        distance_in_time = _distance_in_time(cycle, label_by_index)
        distance_in_time[:first_index] = 0.0
        farthest_index = int(np.argmax(distance_in_time))
        # instants may share one time, where a result was placed on the path by its loads
        if distance_in_time[farthest_index] <= 0:
            break
        label_by_index[farthest_index] = "between"
    return tuple(Event(index, label_by_index[index]) for index in sorted(label_by_index))


def index_of_first_row(cycle: Cycle, scene: Scene) -> int:
    """Index of the first instant of a cycle that lies on the rows of a table of loads over time:
    the path before it leads from no load to the first row. 0 for loads of another kind.
    """
    if not isinstance(scene.load, TimeSeriesLoad):
        return 0
    time = float(scene.load.used_rows().values[0][0])
    return min(int(np.searchsorted(cycle.time, time)), len(cycle.time) - 1)


def _labels_of_extremes(
    cycle: Cycle, friction_coefficient: float, first_index: int
) -> dict[int, str]:
    """Instants of a cycle at which P or Q is largest or least, Q − f P is largest, or Q + f P is
    least: index -> label.

    Where several instants have the extreme value the first counts; an instant that is extreme in
    two quantities keeps the first label. Left out: instants before `first_index`, and quantities
    that are constant. `friction_coefficient` is the coefficient f. Tilt and moment of the shear of
    `cycle` are None in a scene without bulk stress and tilt.
    """
    normal_load = cycle.normal_load[first_index:]
    tangential_load = cycle.tangential_load[first_index:]
    # With bulk stress or tilt slip ends at other instants, another one for each contact edge.
    slip_ends_there = cycle.tilt is None and cycle.shear_moment is None
    label_of_end_of_forward_slip = "forward slip ends" if slip_ends_there else "Q − f P largest"
    label_of_end_of_reverse_slip = "reverse slip ends" if slip_ends_there else "Q + f P least"
    # label -> a sum of loads that is largest at the instant to be labelled
    quantities = {
        "P largest": normal_load,
        "P least": -normal_load,
        "Q largest": tangential_load,
        "Q least": -tangential_load,
        label_of_end_of_forward_slip: tangential_load - friction_coefficient * normal_load,
        label_of_end_of_reverse_slip: -tangential_load - friction_coefficient * normal_load,
    }
    largest_load = float(np.max(np.abs(normal_load)))
    label_by_index: dict[int, str] = {}
    for label, quantity in quantities.items():
        if np.ptp(quantity) > 1e-9 * largest_load:
            # The first instant, to rounding: the end of a cycle repeats its start.
            is_largest_value = quantity >= np.max(quantity) - 1e-12 * largest_load
            label_by_index.setdefault(first_index + int(np.flatnonzero(is_largest_value)[0]), label)
    return label_by_index


def _distance_in_time(cycle: Cycle, indices: Iterable[int]) -> Array:
    """(k,) time between each instant of a cycle and the nearest of the instants with these
    `indices`, as a fraction of the cycle; in units of time where the cycle is not whole.
    """
    distance = np.abs(cycle.fraction[:, None] - cycle.fraction[list(indices)])
    if cycle.is_whole:  # its end is its start
        distance = np.minimum(distance, 1 - distance)
    return np.asarray(distance.min(axis=1))
