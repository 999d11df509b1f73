"""Largest values of half-plane theory through a cycle, searched for over all places and instants,
not only over those of an answer.

The pressure and the contact are largest at the largest load P, since p(x, P) and a(P) grow with P.
At a point x the slip s moves one way between turning points of P, Q - f P and -Q - f P, and until
the edge of contact passes x: the range of s is exact with these instants, and the largest one is
looked for over x alone. So is the largest friction work W(x). The tension at the edges of contact
is looked for over time.

A maximum is looked for between kinks, on places that are taken closer and closer around the largest
values. Where bulk stress and tilt leave no one memory curve, the largest values are those at the
points and instants that `solve` takes by itself, and `Extremes.sampled` states it.

# notation: s slip, W(x) friction work per unit area, a half-width, f friction
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from scenes import NORMAL_LOAD, OPEN, ContactSolution, LoadSegment, Scene
from scenes.array_types import Array
from scenes.solution import range_of_slip, require_solution
from semi_analytic.bulk_and_tilt import one_curve
from semi_analytic.history import histories_kept
from semi_analytic.memory import slip_combination
from semi_analytic.profiles import Contact, contact_of
from semi_analytic.solution import answers_at_default_points, solve
from semi_analytic.subsurface import edge_tension

# Places that are tried at first, over the whole contact together.
_PLACES_AT_FIRST = 96
# Where straight steps have more kinks than that: kinks on each side of the place of the maximum on
# the curved path.
_KINKS_ON_EACH_SIDE = 12
# Places that a round of the search tries around each candidate.
_PLACES_IN_ROUND = 11
# Candidates: local maxima of at least this share of the largest.
_MOST_CANDIDATES = 3
_LEAST_CANDIDATE_SHARE = 0.97
# Rounds at most, each six times closer, and the changes of the largest value in two rounds in a row
# at which the search ends, the former and the latter. A smooth maximum is met by the vertex of a
# parabola, with an error of the fourth power of the spacing, any other by the places themselves,
# which leave a fifth of the former change: less than 1e-10.
_MOST_SEARCH_ROUNDS = 16
_NEARLY_CONVERGED_CHANGE_SHARE = 1e-10
_CONVERGED_CHANGE_SHARE = 1e-12
# The same on hundreds of straight steps: with a kink at each there is no square of the spacing.
_CONVERGED_CHANGE_SHARE_ON_STEPS = 1e-9
# Instants at which the tension is looked at first.
_INSTANTS_AT_FIRST = 120
# Parts of a load path, between turning points of P, beyond which it is a long path.
_PARTS_OF_LONG_PATH = 400
# A place at the edge of contact counts as in contact, since its instant is rounded: share of the
# contact width. Also the share of a time, or of a distance of kinks, below which it is round-off.
_EDGE_TOLERANCE_SHARE = 1e-10


@dataclass(frozen=True)
class Extremes:
    """Largest values of half-plane theory through the last cycle (the whole path, where it does not
    repeat).

    Attributes
    ----------
    pressure, pressure_place
        largest pressure [stress], infinite at a sharp tip, and its place [length]
    half_width
        largest half distance of the contact edges [length]
    slip, slip_place
        largest range of the slip of a point while it is in contact, and its place [length]
    dissipation_density, dissipation_density_place
        largest W(x) [energy / area], and its place [length]
    edge_tension, edge_tension_uncertainty
        largest stress along a face at an edge of contact [stress], 0 where all are negative
    sampled
        why the values are no more than the largest at the points and instants that `solve`
        takes by itself; empty where they are exact
    """

    pressure: float
    pressure_place: float
    half_width: float
    slip: float
    slip_place: float
    dissipation_density: float
    dissipation_density_place: float
    edge_tension: float
    edge_tension_uncertainty: float
    sampled: str = ""


SEARCHED_VALUES = ("slip", "dissipation_density", "edge_tension")
"""What is searched for over x or time; pressure and half-width are largest at the largest load."""


def extremes(answer: ContactSolution, names: Sequence[str] = SEARCHED_VALUES) -> Extremes:
    """Largest values through the last cycle of an answer of half-plane theory, to 1e-9 of each:
    pressure, slip, friction work per area, half-width, and tension at the edges of contact.

    They are found over all places x and instants of the cycle, not only the answer's own points.
    Where bulk stress and tilt leave no one memory curve they are the largest at a set of points and
    instants, to the accuracy of these.

    Parameters
    ----------
    answer
        of half-plane theory, for the load path of its scene or for straight steps between its
        instants; its instants tell which cycle is the last
    names
        which of `SEARCHED_VALUES` are searched for. The others are NaN where the friction history
        is one memory curve: the tangential force, or bulk strain, locked in up to each load.

    Returns
    -------
    Extremes
        NaN for slip, friction work per area W(x) and tension if the answer has no whole cycle; its
        pressure is then the largest at its instants

    Raises
    ------
    InputError, InadmissibleLoadError
        For a scene or loads that half-plane theory refuses.

    Examples
    --------
    >>> import math
    >>> answer = solve("cattaneo-mindlin", x=[0.3, 0.7], time=[1.0, 2.0, 3.0, 4.0, 5.0])
    >>> largest = extremes(answer)
    >>> (
    ...     round(largest.pressure / (2 * 90.62286500739786 / math.pi), 12),
    ...     round(largest.half_width, 12),
    ... )  # a = 1
    (1.0, 1.0)
    """
    require_solution(answer, "extremes")
    # a path that is asked for again is not followed again
    with histories_kept():
        return _extremes(answer, tuple(names))


def _extremes(solution: ContactSolution, names: tuple[str, ...]) -> Extremes:
    """Largest values of half-plane theory through the last cycle of a solution; `names` are those
    of "slip", "dissipation_density" and "edge_tension" to search for.

    Where one memory curve is the whole friction history, the maxima are searched for over x and
    time. For other scenes they are the largest at the default points and instants. A memory curve
    is the tangential force, or the bulk strain, locked in up to each load.
    """
    scene = solution.scene
    # None without one memory curve
    contact = _contact_of_one_curve(scene)
    if contact is None:
        if solution in answers_at_default_points:  # it is not solved again
            return _extremes_at_points_of(solution)
        return _extremes_at_default_points(scene)
    # numbers of the instants of the last cycle; "whole_cycle" is skipped where there is none
    cycle_rows = solution.last_cycle
    has_cycle = "whole_cycle" not in solution.work.skipped and len(cycle_rows) > 1
    if not has_cycle or solution.settings.get("straight_steps"):
        return _Search(solution, contact, has_cycle).extremes(names)
    load_path = scene.load.path()
    # A path that does not repeat begins unloaded, wherever the first increment of a solver ends.
    start_time = float(
        load_path.start if load_path.period is None else solution.time[cycle_rows[0]]
    )
    end_time = float(solution.time[cycle_rows[-1]])
    # of the scene's own path, and cached
    return _extremes_of_cycle(scene, start_time, end_time, names)


@lru_cache(maxsize=32)
def _extremes_of_cycle(scene: Scene, start: float, end: float, names: tuple[str, ...]) -> Extremes:
    """Largest values of half-plane theory between the times `start` and `end` of the scene's own
    load path; those of `SEARCHED_VALUES` that are in `names` are searched for.
    """
    contact = _contact_of_one_curve(scene)
    assert contact is not None
    solution_at_ends = solve(scene, x=0.0, time=[start, end], fields=())
    return _Search(solution_at_ends, contact, has_cycle=True).extremes(names)


def _contact_of_one_curve(scene: Scene) -> Contact | None:
    """The normal contact of a scene whose friction history is one memory curve, the tangential
    force, or the bulk strain, locked in up to each load; None where it is not.
    """
    if not scene.unsymmetric:
        return contact_of(scene.profile, scene.material)
    contact_and_loads = one_curve(scene)
    return None if contact_and_loads is None else contact_and_loads.contact


class _Search:
    """Search for the maxima of half-plane theory over the last cycle of one solution.

    Attributes
    ----------
    instants
        (n,) instants of the solution, ascending; on straight steps those of its last cycle
    monotonic_parts
        load segment, begin and end time of each part of the path on which P goes one way; none on
        straight steps
    turning_times
        instants, ascending, between which the slip of a point in contact goes one way
    largest_load_time, widest_edges
        time of the largest P, and both edges of contact then, (2,) [length]
    kinks
        places within these edges, ascending, between which values are smooth functions of x
    """

    def __init__(self, solution: ContactSolution, contact: Contact, has_cycle: bool) -> None:
        """Find the instants and places between which slip, friction work and pressure of a solution
        are smooth.

        Parameters
        ----------
        solution
            half-plane solution; on straight steps its own instants define the path, in place of
            that of the scene
        contact
            normal contact of the scene
        has_cycle
            whether the solution has a whole last cycle
        """
        self.scene = solution.scene
        self.contact = contact
        self.solution = solution
        self.has_cycle = has_cycle
        self.on_straight_steps = bool(solution.settings.get("straight_steps"))
        self.instants = solution.time
        self.monotonic_parts: list[tuple[LoadSegment, float, float]] = []
        if self.on_straight_steps:
            self.instants = solution.time[solution.last_cycle]
        else:
            self.monotonic_parts = _monotonic_parts(self.scene, self.instants[0], self.instants[-1])
        self.turning_times = self._find_turning_times()

        turning_loads = np.asarray(self.scene.load.path().at(self.turning_times)[0])
        index_of_largest_load = np.argmax(turning_loads)
        self.largest_load_time = float(self.turning_times[index_of_largest_load])
        # (n, 2) left and right edge of contact
        edges_at_turns = solve(self.scene, x=0.0, time=self.turning_times, fields=()).contact_edges
        self.widest_edges = edges_at_turns[index_of_largest_load]
        self.kinks = self._find_kinks(edges_at_turns[turning_loads > 0])

    def _find_kinks(self, edges_at_turns: Array) -> Array:
        """Places between which values are smooth functions of x, ascending, within the contact at
        the largest load (`widest_edges`). Of a symmetric scene only the right half is searched.

        They are edges of contact at the turning points of the loads, corners of the profile, the
        middle of the profile and of the contact. `edges_at_turns` (n, 2) are the left and right
        edges [length]. An `unsymmetric` scene has bulk stress, tilt or unequal sides.
        """
        corners = [
            sign * corner for corner in self.contact.corner_half_widths for sign in (-1.0, 1.0)
        ]
        middle_of_profile = [] if self.scene.unsymmetric else [0.0]
        middle_of_contact = float(np.mean(self.widest_edges))
        places = np.array(
            [*edges_at_turns.ravel(), *corners, *middle_of_profile, middle_of_contact]
        )
        left_edge, right_edge = self.widest_edges
        kinks = places[(places >= left_edge) & (places <= right_edge)]
        if not self.scene.unsymmetric:  # the other side is its mirror image
            kinks = kinks[kinks >= 0]
        return np.unique(kinks)

    def extremes(self, names: tuple[str, ...]) -> Extremes:
        """Largest pressure and half-width over the last cycle, and those of slip, friction work per
        area and edge tension that are in `names`, as one record.

        NaN stands for what is not in `names`, or needs a whole cycle where there is none.
        """
        pressure, pressure_place, half_width = self.largest_pressure_and_half_width()
        slip = slip_place = work_per_area = work_place = math.nan
        tension = tension_uncertainty = math.nan
        if self.has_cycle and "slip" in names:
            slip, slip_place = self.largest_slip_range()
        if self.has_cycle and "dissipation_density" in names:
            work_per_area, work_place = self.largest_work_density()
        if self.has_cycle and "edge_tension" in names:
            tension, tension_uncertainty = self.largest_edge_tension()
        return Extremes(
            pressure=pressure,
            pressure_place=pressure_place,
            half_width=half_width,
            slip=slip,
            slip_place=slip_place,
            dissipation_density=work_per_area,
            dissipation_density_place=work_place,
            edge_tension=tension,
            edge_tension_uncertainty=tension_uncertainty,
        )

    def _find_turning_times(self) -> Array:
        """Instants between which the slip of a point in contact moves one way, ascending: turning
        points of P, Q - f P and -Q - f P.

        On straight steps, or without a cycle, they are all instants of the solution. On each of the
        `monotonic_parts`, (load segment, begin and end time), P goes one way.
        """
        if not self.has_cycle or self.on_straight_steps:
            return self.instants
        turning_times = [self.instants[0], self.instants[-1]]
        friction = self.scene.friction.coefficient
        for segment, begin, end in self.monotonic_parts:
            turning_times += [begin, end]
            # Q - f P and -Q - f P
            for combination in (slip_combination(1, friction), slip_combination(-1, friction)):
                turning_times += [
                    time for time in segment.turning_points(combination) if begin < time < end
                ]
        return np.unique(turning_times)

    def _solution_at(self, x: Array, time: Array, fields: tuple[str, ...]) -> ContactSolution:
        """Answer of half-plane theory at places x (n,) and instants `time` (m,); on straight steps
        at the instants of the search's own solution, since they define the path.
        """
        if self.on_straight_steps:
            return solve(
                self.scene, x=x, time=self.solution.time, fields=fields, straight_steps=True
            )
        return solve(self.scene, x=x, time=time, fields=fields)

    def largest_pressure_and_half_width(self) -> tuple[float, float, float]:
        """Largest pressure [stress], its place and the half-width [length], all at the time of the
        largest load. The pressure is searched for over x, between the `kinks` of the contact;
        `widest_edges` (2,) are the edges of contact then.
        """
        time = np.array([self.largest_load_time])

        def pressures(x: Array) -> Array:
            """Pressure at places x (n,) at the time of the largest load, (n,) [stress]."""
            return np.asarray(solve(self.scene, x=x, time=time, fields=("pressure",)).pressure[0])

        largest_pressure, place = _largest_value_and_place(pressures, self.kinks)
        return largest_pressure, place, float(np.diff(self.widest_edges)[0]) / 2

    def largest_slip_range(self) -> tuple[float, float]:
        """Largest range of slip (largest minus smallest over the cycle) of a point while it is in
        contact, and the place of that point [length each]; 0 without friction.

        The range at a point is exact: slip moves one way between the turning points of the loads,
        and until an edge of contact passes the point. On straight steps between the solution's own
        instants the slip is taken at these.
        """
        if not self.scene.friction.coefficient:
            return 0.0, 0.0

        def slip_ranges(x: Array) -> Array:
            """Range of slip over the cycle [length] at each place x, (n,), while it is in contact.

            Slip is taken at the turning points of the loads and at the instants at which an edge of
            contact passes one of the places.
            """
            time = np.unique(np.concatenate([self.turning_times, self._times_of_passing_edge(x)]))
            solution_at_x = self._solution_at(x, time, ("slip",))
            # numbers of the instants of the last cycle
            cycle_rows = (
                solution_at_x.last_cycle
                if self.on_straight_steps
                else np.arange(len(solution_at_x.time))
            )
            contact_edges = solution_at_x.contact_edges[cycle_rows]
            # 1e-10 of the contact width at the largest load
            edge_tolerance = _EDGE_TOLERANCE_SHARE * float(np.diff(self.widest_edges)[0])
            is_within_edges = (x >= contact_edges[:, :1] - edge_tolerance) & (
                x <= contact_edges[:, 1:] + edge_tolerance
            )
            is_in_contact = is_within_edges & (solution_at_x.normal_load[cycle_rows] > 0)[:, None]
            # `range_of_slip`: largest minus smallest while in contact
            return range_of_slip(solution_at_x.slip[cycle_rows], is_in_contact)

        return self._largest_over_contact("slip_place", slip_ranges)

    def _times_of_passing_edge(self, x: Array) -> Array:
        """Instants at which an edge of contact passes one of the places x (n,).

        On each part of the load path on which P goes one way, the edge passes x when P is the load
        at which the edge is at x. There are none on straight steps, whose instants are fixed. In
        the first round over a long measured path they are left out, as they would be too many: more
        than 400 parts, more than 33 places.
        """
        is_first_round = len(x) > _MOST_CANDIDATES * _PLACES_IN_ROUND
        is_long_path = len(self.monotonic_parts) > _PARTS_OF_LONG_PATH
        if self.on_straight_steps or (is_long_path and is_first_round):
            return np.empty(0)
        # load at which an edge of contact is at x; of a symmetric contact a function of |x|
        load_with_edge_at_x = np.asarray(
            self.contact.load(x if self.scene.unsymmetric else np.abs(x))
        )
        times_by_part = []
        for segment, begin_time, end_time in self.monotonic_parts:
            load_at_begin, load_at_end = (
                float(segment.loads(time)[0]) for time in (begin_time, end_time)
            )
            # the edge passes x once on this part
            passed_loads = load_with_edge_at_x[
                (load_with_edge_at_x > min(load_at_begin, load_at_end))
                & (load_with_edge_at_x < max(load_at_begin, load_at_end))
            ]
            if len(passed_loads):
                times_by_part.append(
                    segment.time_of(NORMAL_LOAD, passed_loads - load_at_begin, begin_time, end_time)
                )
        return np.concatenate(times_by_part) if times_by_part else np.empty(0)

    def largest_work_density(self) -> tuple[float, float]:
        """Largest friction work per area over the cycle W(x) [energy / area], and its place."""
        ends_of_cycle = self.instants[[0, -1]]

        def works_per_area(x: Array) -> Array:
            """Friction work per area of the cycle at places x (n,), (n,) [energy / area]."""
            solution_at_x = self._solution_at(x, ends_of_cycle, ("dissipation_density",))
            return np.asarray(solution_at_x.dissipation_density)

        return self._largest_over_contact("dissipation_density_place", works_per_area)

    def _largest_over_contact(
        self, place_name: str, values_at: Callable[[Array], Array]
    ) -> tuple[float, float]:
        """Largest value of the function `values_at` of x over the contact, and its place, searched
        for between its kinks.

        Kinks are places between which the function is smooth. On straight steps the edge at each
        instant is a kink. Where these are hundreds, the maximum on the curved path, which the steps
        approximate, is found first; its place is the attribute `place_name` of `Extremes`. Only the
        kinks nearest to it are searched, to 1e-9 of the value.
        """
        # _PLACES_AT_FIRST: 96
        if not self.on_straight_steps or len(self.kinks) <= _PLACES_AT_FIRST:
            return _largest_value_and_place(values_at, self.kinks)
        start, end = self.instants[[0, -1]].tolist()
        place_on_path = getattr(
            _extremes_of_cycle(self.scene, start, end, SEARCHED_VALUES), place_name
        )
        nearest_kink = int(np.abs(self.kinks - place_on_path).argmin())
        # twelve kinks on each side
        first_kink = max(nearest_kink - _KINKS_ON_EACH_SIDE, 0)
        kinks_nearby = self.kinks[first_kink : nearest_kink + _KINKS_ON_EACH_SIDE + 1]
        return _largest_value_and_place(
            values_at, kinks_nearby, converged_share=_CONVERGED_CHANGE_SHARE_ON_STEPS
        )

    def largest_edge_tension(self) -> tuple[float, float]:
        """Largest tension over the cycle: stress along a face at an edge of contact, tensile
        positive, 0 where all are compressive; and its uncertainty [stress each].

        It is searched for over time, between the turning points of the loads; on straight steps
        between all their instants. With bulk stress, tilt or unequal sides (`unsymmetric`) it is
        the largest at about 120 instants.
        """
        # _INSTANTS_AT_FIRST: 120
        if self.scene.unsymmetric:
            return _largest_tension(
                self.scene, _places_between_kinks(self.turning_times, _INSTANTS_AT_FIRST)
            )
        largest_uncertainty = 0.0

        def tensions(time: Array) -> Array:
            """Largest tension of both edges and both faces at each instant, (n,) [stress]."""
            nonlocal largest_uncertainty
            # (n, 2, 2) by body and edge
            tension, uncertainties = edge_tension(self.scene, time)
            largest_uncertainty = max(largest_uncertainty, float(uncertainties.max()))
            return np.asarray(tension.max(axis=(1, 2)))

        # instants between which the tension is smooth
        kink_times = self.turning_times if self.monotonic_parts else self.instants
        largest_tension, _ = _largest_value_and_place(tensions, kink_times, _INSTANTS_AT_FIRST)
        return max(largest_tension, 0.0), largest_uncertainty


def _monotonic_parts(
    scene: Scene, start: float, end: float
) -> list[tuple[LoadSegment, float, float]]:
    """Parts of a load path between the times `start` and `end` on which the normal load P rises or
    falls throughout: load segment, begin and end time of each.

    `start` may lie anywhere in a cycle. Without a period the path has one pass. Segments of which
    only round-off lies in between are left out.
    """
    path = scene.load.path()
    # the initial loading, and the cycles between both times; 1e-10 of a period is round-off
    segments = list(path.initial_loading)
    if path.period is not None:
        first_cycle = math.floor((start - path.cycle_start) / path.period + _EDGE_TOLERANCE_SHARE)
        last_cycle = math.ceil((end - path.cycle_start) / path.period - _EDGE_TOLERANCE_SHARE)
        for cycle_number in range(max(first_cycle, 0), last_cycle):
            segments += path.segments_of_cycle(cycle_number)

    # cut at the turning points of P
    least_duration = _EDGE_TOLERANCE_SHARE * (end - start)
    monotonic_parts = []
    for segment in segments:
        # what lies between `start` and `end`
        segment_begin = max(segment.start, start)
        segment_end = min(segment.end, end)
        turning_times = [
            time
            for time in sorted(segment.turning_points(NORMAL_LOAD))
            if segment_begin < time < segment_end
        ]
        if segment_end - segment_begin > least_duration:
            monotonic_parts += [
                (segment, begin_time, end_time)
                for begin_time, end_time in pairwise([segment_begin, *turning_times, segment_end])
            ]
    return monotonic_parts


def _largest_value_and_place(
    values_at: Callable[[Array], Array],
    kinks: Array,
    n_first_places: int = _PLACES_AT_FIRST,
    converged_share: float = _CONVERGED_CHANGE_SHARE,
) -> tuple[float, float]:
    """Largest value of a function of place or time, and where it is, over the range of `kinks`
    (n,), ascending, between which the function is smooth. A single kink is the place.

    About `n_first_places` places are tried at first. In each round closer ones follow around the
    three largest local maxima: eleven places, and the vertex of the parabola through a maximum and
    its neighbours. The search ends after 16 rounds at most, and at a value that is not finite,
    which is returned.

    Parameters
    ----------
    values_at
        the function, of places (m,); its values are (m,)
    converged_share
        the search has converged if a round raises the largest value by less than this share of
        itself, and the round before by less than 1e-10

    Examples
    --------
    >>> top, place = _largest_value_and_place(lambda x: 1 - (x - 0.3) ** 2, np.array([0.0, 1.0]))
    >>> round(top, 12), round(place, 5)
    (1.0, 0.3)
    """
    kinks = _distinct(kinks)
    if len(kinks) == 1:
        return float(values_at(kinks)[0]), float(kinks[0])
    first_places = _places_between_kinks(kinks, n_first_places)
    first_values = values_at(first_places)
    index_of_largest_value = int(np.argmax(first_values))
    largest_value = float(first_values[index_of_largest_value])
    place_of_largest_value = float(first_places[index_of_largest_value])
    # three at most, each with its two neighbours
    local_maxima = _local_maxima(first_places, first_values)
    nearly_converged_share = max(converged_share, _NEARLY_CONVERGED_CHANGE_SHARE)
    is_nearly_converged = False

    for _ in range(_MOST_SEARCH_ROUNDS):
        if not np.isfinite(largest_value):
            break
        places_by_maximum = [maximum.places_around() for maximum in local_maxima]
        round_places = np.unique(np.concatenate(places_by_maximum))
        round_values = values_at(round_places)
        index_of_largest_value = int(np.argmax(round_values))
        value_rise = float(round_values[index_of_largest_value]) - largest_value
        if value_rise > 0:
            largest_value = float(round_values[index_of_largest_value])
            place_of_largest_value = float(round_places[index_of_largest_value])
        if is_nearly_converged and value_rise <= converged_share * abs(largest_value):
            break
        is_nearly_converged = value_rise <= nearly_converged_share * abs(largest_value)
        local_maxima = [
            maximum.narrowed(places, round_values[np.searchsorted(round_places, places)])
            for maximum, places in zip(local_maxima, places_by_maximum, strict=True)
        ]
    return largest_value, place_of_largest_value


def _distinct(kinks: Array) -> Array:
    """Kinks (n,), ascending, without those that are the kink before them but for round-off: nearer
    than 1e-10 of their range. Between two such kinks all values are equal but for round-off, and
    their local maxima would take the place of a real one.

    >>> _distinct(np.array([0.0, 0.3, 0.3 + 1e-16, 1.0])).tolist()
    [0.0, 0.3, 1.0]
    """
    least_distance = _EDGE_TOLERANCE_SHARE * (kinks[-1] - kinks[0])
    is_distinct = np.append(True, np.diff(kinks) > least_distance)
    return kinks[is_distinct]


def _places_between_kinks(kinks: Array, n_places: int) -> Array:
    """The kinks (n,), ascending, and about `n_places` places between them, equally spaced from each
    kink to the next, one at least; a single kink alone.

    >>> _places_between_kinks(np.array([0.0, 1.0, 3.0]), 4).tolist()
    [0.0, 0.5, 1.0, 2.0, 3.0]
    """
    if len(kinks) == 1:
        return kinks
    n_intervals = max(n_places // (len(kinks) - 1), 2)
    return np.unique([np.linspace(begin, end, n_intervals + 1) for begin, end in pairwise(kinks)])


class _LocalMaximum(NamedTuple):
    """A local maximum and its neighbours; at an end of the range it is its own neighbour.

    Attributes
    ----------
    places, values
        (3,) the places, ascending, and the values there: neighbour, maximum, neighbour
    """

    places: Array
    values: Array

    def vertex(self) -> float:
        """Place at which the parabola through the three values is largest; the middle place where
        the parabola has no maximum. `places` and `values` (3,) are of the maximum and its
        neighbours.

        >>> _LocalMaximum(
        ...     np.array([0.0, 1.0, 3.0]), np.array([0.0, 3.0, 3.0])
        ... ).vertex()  # x (4 - x)
        2.0
        """
        first_place, middle_place, last_place = self.places.tolist()
        if not first_place < middle_place < last_place or not np.isfinite(self.values).all():
            return middle_place
        first_slope, last_slope = (np.diff(self.values) / np.diff(self.places)).tolist()
        if not first_slope > last_slope:
            return middle_place
        # The slope goes from the first to the last between the middles of both intervals.
        vertex_place = (first_place + middle_place) / 2 + first_slope / (
            first_slope - last_slope
        ) * (last_place - first_place) / 2
        return min(max(vertex_place, first_place), last_place)

    def places_around(self) -> Array:
        """Equally spaced places between the neighbours, and that of the vertex."""
        evenly_spaced_places = np.linspace(self.places[0], self.places[-1], _PLACES_IN_ROUND + 2)[
            1:-1
        ]
        return np.unique(np.append(evenly_spaced_places, self.vertex()))

    def narrowed(self, places: Array, values: Array) -> _LocalMaximum:
        """The local maximum among `values` at `places` between the neighbours, (n,) each, with its
        neighbours among these and the former ones.
        """
        all_places = np.concatenate([self.places[:1], places, self.places[-1:]])
        all_values = np.concatenate([self.values[:1], values, self.values[-1:]])
        index_of_largest_value = int(np.argmax(values)) + 1
        maximum_and_neighbours = slice(index_of_largest_value - 1, index_of_largest_value + 2)
        return _LocalMaximum(all_places[maximum_and_neighbours], all_values[maximum_and_neighbours])


def _local_maxima(places: Array, values: Array) -> list[_LocalMaximum]:
    """The highest local maxima of values at places, (n,) each, places ascending: three at most, of
    at least 97 % of the largest value. Each has its two neighbours.
    """
    below_all_values = np.array([-np.inf])
    is_above_value_before = values >= np.concatenate([below_all_values, values[:-1]])
    is_above_value_behind = values >= np.concatenate([values[1:], below_all_values])
    is_nearly_largest = values >= _LEAST_CANDIDATE_SHARE * np.max(values)
    indices_of_maxima = np.flatnonzero(
        is_above_value_before & is_above_value_behind & is_nearly_largest
    )
    indices_of_highest = indices_of_maxima[np.argsort(-values[indices_of_maxima], kind="stable")][
        :_MOST_CANDIDATES
    ]
    last_index = len(places) - 1
    indices_with_neighbours = [
        np.clip([k - 1, k, k + 1], 0, last_index) for k in indices_of_highest.tolist()
    ]
    return [
        _LocalMaximum(places[maximum_and_neighbours], values[maximum_and_neighbours])
        for maximum_and_neighbours in indices_with_neighbours
    ]


# ------------------------------------------------------------------------------ no one memory curve
@lru_cache(maxsize=8)
def _extremes_at_default_points(scene: Scene) -> Extremes:
    """The largest pressure, slip, friction work per area, half-width and edge tension of a scene at
    the points and instants that half-plane theory takes where none are given.
    """
    return _extremes_at_points_of(solve(scene))


def _extremes_at_points_of(solution: ContactSolution) -> Extremes:
    """The largest pressure, slip, friction work per area, half-width and edge tension of a
    half-plane solution with all fields, at its own points and the instants of its last cycle.

    It serves scenes whose friction history is not one memory curve (tangential force, or bulk
    strain, locked in up to each load): without it there is no smooth function to be searched. Slip
    counts while a point is in contact.
    """
    # numbers of the instants of the last cycle
    cycle_rows = solution.last_cycle
    largest_pressures = solution.pressure[cycle_rows].max(axis=0)
    contact_widths = np.diff(solution.contact_edges[cycle_rows], axis=1)
    # `range_of_slip`: largest minus smallest slip of each point
    slip_ranges = range_of_slip(solution.slip[cycle_rows], solution.state[cycle_rows] != OPEN)
    works_per_area = solution.dissipation_density
    tension, tension_uncertainty = _largest_tension(solution, solution.time[cycle_rows])
    return Extremes(
        pressure=float(largest_pressures.max()),
        pressure_place=float(solution.x[np.argmax(largest_pressures)]),
        half_width=float(np.nanmax(contact_widths, initial=0.0)) / 2,
        slip=float(slip_ranges.max()),
        slip_place=float(solution.x[np.argmax(slip_ranges)]),
        dissipation_density=float(works_per_area.max()),
        dissipation_density_place=float(solution.x[np.argmax(works_per_area)]),
        edge_tension=tension,
        edge_tension_uncertainty=tension_uncertainty,
        sampled=(
            "bulk stress and tilt leave no one memory curve, so the largest values of theory are"
            f" those at {len(solution.x)} points and {len(cycle_rows)} instants"
        ),
    )


def _largest_tension(source: ContactSolution | Scene, time: Array) -> tuple[float, float]:
    """The largest tension at an edge of contact at instants (n,), 0 where all are compressive, and
    its uncertainty [stress each].
    """
    # at instants, both edges and both faces
    tensions, uncertainties = edge_tension(source, time)
    index_of_largest = np.unravel_index(np.argmax(tensions), tensions.shape)
    return float(max(tensions[index_of_largest], 0.0)), float(uncertainties[index_of_largest])
