"""Largest values of half-plane theory through a cycle, found on its own points and instants,
whatever answer they stand beside.

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
from scenes.solution import range_of_slip
from semi_analytic.bulk_and_tilt import one_curve
from semi_analytic.history import histories_kept
from semi_analytic.memory import level
from semi_analytic.profiles import Contact, contact_of
from semi_analytic.solution import solve
from semi_analytic.subsurface import edge_tension

# Places at first between two kinks, of the whole contact together; places in a round around each
# candidate.
_FIRST = 96
# Marks on each side of the place on the path, where straight steps have more than that.
_ABOUT = 12
_AROUND = 11
# Candidates: local maxima of at least this share of the largest.
_MOST_CANDIDATES = 3
_NEARLY = 0.97
# Rounds at most, each six times closer, and the change of the largest value at which two rounds in
# a row end the search. A smooth maximum is met by the vertex of a parabola, with an error of the
# fourth power of the spacing, any other by the places themselves: two rounds that change it by less
# than 1e-12 leave less than 1e-10.
_ROUNDS = 16
_SETTLED = 1e-12
# The same on hundreds of straight steps: with a kink at each there is no square of the spacing.
_SETTLED_ON_STEPS = 1e-9
# Instants that are looked at for the tension at first, and places for which the passing of the edge
# adds instants of a long record.
_INSTANTS = 120
_LONG = 400
# A place at the edge of contact is in it, but for the last digits of its instant.
_AT_EDGE = 1e-10


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


SEARCHED = ("slip", "dissipation_density", "edge_tension")
"""What is looked for over x or time; all else is there at once."""


def extremes(answer: ContactSolution, names: Sequence[str] = SEARCHED) -> Extremes:
    """The largest pressure, slip, friction work per area, half-width and edge tension of half-plane
    theory through the last cycle of an answer, to 1e-9 of themselves.

    The answer's points play no part.

    Parameters
    ----------
    answer
        of half-plane theory to a scene, or to straight steps between its instants; its instants say
        which cycle is the last
    names
        which of the largest values are looked for; the others are NaN where one memory curve (the
        tangential force, or bulk strain, locked in up to each load) is followed

    Returns
    -------
    Extremes
        NaN for the slip, W(x) and tension of an answer without a whole cycle, whose pressure is
        that of its instants

    Raises
    ------
    InputError, InadmissibleLoadError
        For a scene or loads that half-plane theory refuses.

    Examples
    --------
    >>> import math
    >>> few = solve("cattaneo-mindlin", x=[0.3, 0.7], time=[1.0, 2.0, 3.0, 4.0, 5.0])
    >>> found = extremes(few)
    >>> (
    ...     round(found.pressure / (2 * 90.62286500739786 / math.pi), 12),
    ...     round(found.half_width, 12),
    ... )  # a = 1
    (1.0, 1.0)
    """
    with histories_kept():
        return _extremes(answer, tuple(names))


def _extremes(answer: ContactSolution, names: tuple[str, ...]) -> Extremes:
    """The largest values of half-plane theory for the answer's scene through the last cycle;
    `names` are those that are wanted.

    Where one memory curve holds what friction remembers, they are searched for on it. For other
    scenes they are the largest at the default points. A memory curve is the tangential force, or
    the bulk strain, locked in up to each load.
    """
    scene = answer.scene
    contact = _contact(scene)
    if contact is None:
        return _of_default_points(scene)
    rows_of_cycle = answer.last_cycle
    has_cycle = "whole_cycle" not in answer.work.skipped and len(rows_of_cycle) > 1
    if not has_cycle or answer.settings.get("straight_steps"):
        return _Search(answer, contact, has_cycle).extremes(names)
    path = scene.load.path()
    # A path that does not repeat begins unloaded, wherever the first increment of a solver ends.
    start_time = float(path.start if path.period is None else answer.time[rows_of_cycle[0]])
    end_time = float(answer.time[rows_of_cycle[-1]])
    return _of_cycle(scene, start_time, end_time, names)


@lru_cache(maxsize=32)
def _of_cycle(scene: Scene, start: float, end: float, names: tuple[str, ...]) -> Extremes:
    """The largest values between two instants of the scene's own path."""
    contact = _contact(scene)
    assert contact is not None
    ends = solve(scene, x=0.0, time=[start, end], fields=())
    return _Search(ends, contact, has_cycle=True).extremes(names)


def _contact(scene: Scene) -> Contact | None:
    """The normal contact where the memory of friction is one curve; None where it is not."""
    if not scene.unsymmetric:
        return contact_of(scene.profile, scene.material)
    family = one_curve(scene)
    return None if family is None else family.contact


class _Search:
    """The maxima of one answer's theory over its last cycle."""

    def __init__(self, answer: ContactSolution, contact: Contact, has_cycle: bool) -> None:
        """Collect the instants and places between which a value of half-plane theory is smooth, for
        the search of its largest value over the last cycle of an `answer`.

        In time: turning points of the loads. In space: corners of the profile, the middle, and the
        edges of contact at these instants. `has_cycle` is whether the answer has a last cycle.
        """
        self.scene = answer.scene
        self.contact = contact
        self.answer = answer
        self.has_cycle = has_cycle
        self.steps = (
            answer.time[answer.last_cycle] if answer.settings.get("straight_steps") else answer.time
        )
        self.on_straight_steps = bool(answer.settings.get("straight_steps"))
        self.monotonic = (
            []
            if self.on_straight_steps
            else _monotonic_parts(self.scene, self.steps[0], self.steps[-1])
        )
        self.turns = self._turning_times()
        turning_loads = np.asarray(self.scene.load.path().at(self.turns)[0])
        self.largest_load_time = float(self.turns[np.argmax(turning_loads)])
        edges_at_turns = solve(self.scene, x=0.0, time=self.turns, fields=()).contact_edges
        self.edges = edges_at_turns[np.argmax(turning_loads)]
        touching_edges = edges_at_turns[turning_loads > 0]
        corners = [side * mark for mark in contact.breaks for side in (-1.0, 1.0)]
        middle_places = [] if self.scene.unsymmetric else [0.0]
        places_of_kinks = np.array(
            [*touching_edges.ravel(), *corners, *middle_places, float(np.mean(self.edges))]
        )
        kinks_in_contact = places_of_kinks[
            (places_of_kinks >= self.edges[0]) & (places_of_kinks <= self.edges[1])
        ]
        if not self.scene.unsymmetric:
            kinks_in_contact = kinks_in_contact[
                kinks_in_contact >= 0
            ]  # the other side is its mirror image
        self.marks = np.unique(kinks_in_contact)

    def extremes(self, names: tuple[str, ...]) -> Extremes:
        """Every largest value of the last cycle that `names` asks for, as one record; NaN for what
        is not asked for, or needs a whole cycle where there is none.

        Pressure and half-width are always found: both are largest at the largest load.
        """
        pressure, pressure_place, half_width = self.pressure()
        slip = slip_place = density = density_place = tension = uncertainty = math.nan
        if self.has_cycle and "slip" in names:
            slip, slip_place = self.slip()
        if self.has_cycle and "dissipation_density" in names:
            density, density_place = self.dissipation_density()
        if self.has_cycle and "edge_tension" in names:
            tension, uncertainty = self.edge_tension()
        return Extremes(
            pressure=pressure,
            pressure_place=pressure_place,
            half_width=half_width,
            slip=slip,
            slip_place=slip_place,
            dissipation_density=density,
            dissipation_density_place=density_place,
            edge_tension=tension,
            edge_tension_uncertainty=uncertainty,
        )

    def _turning_times(self) -> Array:
        """Instants between which the slip of a point in contact moves one way."""
        if not self.has_cycle or self.on_straight_steps:
            return self.steps
        times = [self.steps[0], self.steps[-1]]
        friction = self.scene.friction.coefficient
        for leg, begin, end in self.monotonic:
            times += [begin, end]
            for slip_level in (level(1, friction), level(-1, friction)):
                times += [time for time in leg.turning_points(slip_level) if begin < time < end]
        return np.unique(times)

    def _solved(self, x: Array, time: Array, fields: tuple[str, ...]) -> ContactSolution:
        if self.on_straight_steps:
            return solve(self.scene, x=x, time=self.answer.time, fields=fields, straight_steps=True)
        return solve(self.scene, x=x, time=time, fields=fields)

    def pressure(self) -> tuple[float, float, float]:
        """Largest pressure, its place and the half-width at the largest load."""
        time = np.array([self.largest_load_time])

        def values(x: Array) -> Array:
            return np.asarray(solve(self.scene, x=x, time=time, fields=("pressure",)).pressure[0])

        largest_pressure, place = _largest(values, self.marks)
        return largest_pressure, place, float(np.diff(self.edges)[0]) / 2

    def slip(self) -> tuple[float, float]:
        """Largest range of the slip of a point while it is in contact, and the place of that point
        [length]; 0 without friction.

        The range at a point is exact: between the turning points of the loads, and until the edge
        passes the point, slip moves one way.
        """
        if not self.scene.friction.coefficient:
            return 0.0, 0.0

        def slip_ranges(x: Array) -> Array:
            """Range of the slip over the cycle at each place x, (n,), while it is in contact.

            It is taken at the turning points of the loads and at the instants at which an edge of
            contact passes one of the places.
            """
            time = np.unique(np.concatenate([self.turns, self._passings(x)]))
            answer = self._solved(x, time, ("slip",))
            cycle_rows = (
                answer.last_cycle if self.on_straight_steps else np.arange(len(answer.time))
            )
            edges = answer.contact_edges[cycle_rows]
            edge_tolerance = _AT_EDGE * float(np.diff(self.edges)[0])
            within_edges = (x >= edges[:, :1] - edge_tolerance) & (
                x <= edges[:, 1:] + edge_tolerance
            )
            is_in_contact = within_edges & (answer.normal_load[cycle_rows] > 0)[:, None]
            return range_of_slip(answer.slip[cycle_rows], is_in_contact)

        return self._largest_about("slip_place", slip_ranges)

    def _passings(self, x: Array) -> Array:
        """Instants at which an edge of contact passes one of the places (n,); none of a long record
        at many places.

        On each part of the load path on which P goes one way, the edge passes x when P is the load
        at which the edge is at x.
        """
        if self.on_straight_steps or (
            len(self.monotonic) > _LONG and len(x) > _MOST_CANDIDATES * _AROUND
        ):
            return np.empty(0)
        edge_load = np.asarray(self.contact.load(x if self.scene.unsymmetric else np.abs(x)))
        times = []
        for segment, begin_time, end_time in self.monotonic:
            load_at_begin, load_at_end = (
                float(segment.loads(time)[0]) for time in (begin_time, end_time)
            )
            passed_loads = edge_load[
                (edge_load > min(load_at_begin, load_at_end))
                & (edge_load < max(load_at_begin, load_at_end))
            ]
            if len(passed_loads):
                times.append(
                    segment.time_of(NORMAL_LOAD, passed_loads - load_at_begin, begin_time, end_time)
                )
        return np.concatenate(times) if times else np.empty(0)

    def dissipation_density(self) -> tuple[float, float]:
        """Largest W(x), and its place."""
        ends = self.steps[[0, -1]]

        def values(x: Array) -> Array:
            return np.asarray(self._solved(x, ends, ("dissipation_density",)).dissipation_density)

        return self._largest_about("dissipation_density_place", values)

    def _largest_about(self, name: str, values: Callable[[Array], Array]) -> tuple[float, float]:
        """Largest value of a function of x over the contact, and its place, searched for between
        all kinks.

        On hundreds of straight steps each edge is a kink. Then only those about the place `name` of
        the largest value on the path that the steps follow are searched.
        """
        if not self.on_straight_steps or len(self.marks) <= _FIRST:
            return _largest(values, self.marks)
        start, end = self.steps[[0, -1]].tolist()
        extremes_on_path = _of_cycle(self.scene, start, end, SEARCHED)
        nearest_mark = int(np.abs(self.marks - getattr(extremes_on_path, name)).argmin())
        marks_about = self.marks[max(nearest_mark - _ABOUT, 0) : nearest_mark + _ABOUT + 1]
        return _largest(values, marks_about, settled_share=_SETTLED_ON_STEPS)

    def edge_tension(self) -> tuple[float, float]:
        """Largest stress along a face at an edge of contact over the cycle, 0 at least, and its
        uncertainty [stress].

        It is searched for over time, between the turning points of the loads.
        """
        if self.scene.unsymmetric:
            return _largest_tension(self.scene, _between(self.turns, _INSTANTS))
        largest_uncertainty = 0.0

        def values(time: Array) -> Array:
            nonlocal largest_uncertainty
            tension, errors = edge_tension(self.scene, time)
            largest_uncertainty = max(largest_uncertainty, float(errors.max()))
            return np.asarray(tension.max(axis=(1, 2)))

        largest_tension, _ = _largest(
            values, self.turns if self.monotonic else self.steps, _INSTANTS
        )
        return max(largest_tension, 0.0), largest_uncertainty


def _monotonic_parts(
    scene: Scene, start: float, end: float
) -> list[tuple[LoadSegment, float, float]]:
    """Parts of a load path from `start` to `end` on which the normal load P goes one way: segment
    of the path, begin and end time of each.

    `start` may lie anywhere in a cycle. Parts of next to no duration are left out.
    """
    path = scene.load.path()
    segments = list(path.initial_loading)
    if path.period is not None:
        first_cycle = math.floor((start - path.cycle_start) / path.period + _AT_EDGE)
        last_cycle = math.ceil((end - path.cycle_start) / path.period - _AT_EDGE)
        for number in range(max(first_cycle, 0), last_cycle):
            segments += path.cycle_legs(number)
    least_duration = _AT_EDGE * (end - start)
    parts = []
    for segment in segments:
        part_begin = max(segment.start, start)
        part_end = min(segment.end, end)
        turns = [
            time
            for time in sorted(segment.turning_points(NORMAL_LOAD))
            if part_begin < time < part_end
        ]
        if part_end - part_begin > least_duration:
            parts += [
                (segment, begin_time, end_time)
                for begin_time, end_time in pairwise([part_begin, *turns, part_end])
            ]
    return parts


def _largest(
    values: Callable[[Array], Array],
    marks: Array,
    first_count: int = _FIRST,
    settled_share: float = _SETTLED,
) -> tuple[float, float]:
    """Largest value of a function and its place, over the range of `marks`, between which the
    function is smooth.

    Places are taken closer and closer around the largest values. Two rounds in a row that raise the
    largest by less than `settled_share` of itself end the search. `first_count` places are taken at
    first.

    >>> top, place = _largest(lambda x: 1 - (x - 0.3) ** 2, np.array([0.0, 1.0]))
    >>> round(top, 12), round(place, 5)
    (1.0, 0.3)
    """
    if len(marks) == 1:
        return float(values(marks)[0]), float(marks[0])
    first_places = _between(marks, first_count)
    first_values = values(first_places)
    number_of_largest = int(np.argmax(first_values))
    largest_value = float(first_values[number_of_largest])
    place = float(first_places[number_of_largest])
    peaks = _peaks(first_places, first_values)
    quiet_rounds = 0
    for _ in range(_ROUNDS):
        if not np.isfinite(largest_value) or quiet_rounds == 2:
            break
        places_by_peak = [peak.places_around() for peak in peaks]
        all_places = np.unique(np.concatenate(places_by_peak))
        new_values = values(all_places)
        number_of_largest = int(np.argmax(new_values))
        value_change = float(new_values[number_of_largest]) - largest_value
        if value_change > 0:
            largest_value = float(new_values[number_of_largest])
            place = float(all_places[number_of_largest])
        quiet_rounds = quiet_rounds + 1 if value_change <= settled_share * abs(largest_value) else 0
        peaks = [
            peak.closer(places, new_values[np.searchsorted(all_places, places)])
            for peak, places in zip(peaks, places_by_peak, strict=True)
        ]
    return largest_value, place


def _between(marks: Array, count: int) -> Array:
    """The marks and about `count` places between them, equally spaced from each to the next, at
    least one.

    >>> _between(np.array([0.0, 1.0, 3.0]), 4).tolist()
    [0.0, 0.5, 1.0, 2.0, 3.0]
    """
    if len(marks) == 1:
        return marks
    steps = max(count // (len(marks) - 1), 2)
    return np.unique([np.linspace(begin, end, steps + 1) for begin, end in pairwise(marks)])


class _Peak(NamedTuple):
    """A local maximum between its neighbours: three places, ascending, and their values, (3,) each;
    at the rim the maximum is its own neighbour.
    """

    places: Array
    values: Array

    def vertex(self) -> float:
        """Place at which the parabola through three points of a function is largest; the middle
        place where it has no top.

        >>> _Peak(np.array([0.0, 1.0, 3.0]), np.array([0.0, 3.0, 3.0])).vertex()  # x (4 - x)
        2.0
        """
        first_place, middle_place, last_place = self.places.tolist()
        if not first_place < middle_place < last_place or not np.isfinite(self.values).all():
            return middle_place
        rise, fall = (np.diff(self.values) / np.diff(self.places)).tolist()
        if not rise > fall:
            return middle_place
        # the slope falls from `rise` to `fall` between the middles of both intervals
        vertex = (first_place + middle_place) / 2 + rise / (rise - fall) * (
            last_place - first_place
        ) / 2
        return min(max(vertex, first_place), last_place)

    def places_around(self) -> Array:
        """Equally spaced places between the neighbours, and that of the vertex."""
        between = np.linspace(self.places[0], self.places[-1], _AROUND + 2)[1:-1]
        return np.unique(np.append(between, self.vertex()))

    def closer(self, places: Array, values: Array) -> _Peak:
        """The largest of the values at some places between the neighbours, and its neighbours."""
        all_places = np.concatenate([self.places[:1], places, self.places[-1:]])
        all_values = np.concatenate([self.values[:1], values, self.values[-1:]])
        best_place = int(np.argmax(values)) + 1
        three_places = slice(best_place - 1, best_place + 2)
        return _Peak(all_places[three_places], all_values[three_places])


def _peaks(places: Array, values: Array) -> list[_Peak]:
    """The local maxima that are nearly the largest value."""
    rim = np.array([-np.inf])
    rises = values >= np.concatenate([rim, values[:-1]])
    falls = values >= np.concatenate([values[1:], rim])
    peaks = np.flatnonzero(rises & falls & (values >= _NEARLY * np.max(values)))
    highest_peaks = peaks[np.argsort(-values[peaks], kind="stable")][:_MOST_CANDIDATES]
    last_place = len(places) - 1
    neighbours = [np.clip([k - 1, k, k + 1], 0, last_place) for k in highest_peaks.tolist()]
    return [_Peak(places[three_places], values[three_places]) for three_places in neighbours]


# ------------------------------------------------------------------------------ no one memory curve
@lru_cache(maxsize=8)
def _of_default_points(scene: Scene) -> Extremes:
    """The largest pressure, slip, W(x), half-width and edge tension of a scene at the points and
    instants that half-plane theory takes where none are given.

    For scenes without a single memory curve, for which the search has no smooth function. A memory
    curve is the tangential force, or the bulk strain, locked in up to each load.
    """
    answer = solve(scene)
    rows = answer.last_cycle
    pressure = answer.pressure[rows].max(axis=0)
    edges = answer.contact_edges[rows]
    slip_range = range_of_slip(answer.slip[rows], answer.state[rows] != OPEN)
    density = answer.dissipation_density
    tension, uncertainty = _largest_tension(answer, answer.time[rows])
    return Extremes(
        pressure=float(pressure.max()),
        pressure_place=float(answer.x[np.argmax(pressure)]),
        half_width=float(np.nanmax(np.diff(edges, axis=1), initial=0.0)) / 2,
        slip=float(slip_range.max()),
        slip_place=float(answer.x[np.argmax(slip_range)]),
        dissipation_density=float(density.max()),
        dissipation_density_place=float(answer.x[np.argmax(density)]),
        edge_tension=tension,
        edge_tension_uncertainty=uncertainty,
        sampled=(
            "bulk stress and tilt leave no one memory curve, so the largest values of theory are"
            f" those at {len(answer.x)} points and {len(rows)} instants"
        ),
    )


def _largest_tension(source: ContactSolution | Scene, time: Array) -> tuple[float, float]:
    """The largest tension at an edge of contact at some instants, and its uncertainty [stress]."""
    values, uncertainties = edge_tension(source, time)
    place_of_largest = np.unravel_index(np.argmax(values), values.shape)
    return float(max(values[place_of_largest], 0.0)), float(uncertainties[place_of_largest])
