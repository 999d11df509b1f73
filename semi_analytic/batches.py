"""Dissipation and its peak for arrays of ellipses: the two calls that sweeps and the paper's
figures 7 and 10 need.

Arguments are broadcast and taken block by block, so that memory beyond arguments and results is
that of one block. Bad members get a reason. The others are sorted by profile: those that differ by
units only share one contact, that of the same profile in units of its own; a profile of b, R1 and
R2, say, is that of 1, 1 and R2/R1 in the units b and E* b^2/R1.

The maxima of W(x), in the letters and angles of `steady_ellipse`: where slip goes on at the least
load, W has a kink at a(P_min). With d the distance from it, W goes as d ln|d|: the slope is minus
infinity on both sides. A first maximum, the shoulder, may therefore lie just inside a(P_min) and a
second one further out. At the corners of a profile W may have a kink too. At the edges of contact
at E and G it has two derivatives (it goes as d^(5/2)), at those of I and J more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import (
    BodyEffects,
    Compound,
    Elastic,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    PowerLaw,
    Profile,
    Wedge,
)
from scenes.array_types import Array
from scenes.arrays import LARGEST, real_numbers
from scenes.frozen import Frozen, validated
from semi_analytic.answer import neglected_coupling
from semi_analytic.body_numbers import checked_effects
from semi_analytic.corrected import curvatures_of, notes_of_batch
from semi_analytic.corrected_batches import BendColumns, EllipseOfLoads, works_of_ellipses
from semi_analytic.corrected_memory import Curvatures
from semi_analytic.elasticity import composite_modulus
from semi_analytic.memory import LAST_DIGITS, PROMISED
from semi_analytic.phases import accepts_phase, phase_in_radians
from semi_analytic.profiles import SymmetricContact, contact_of
from semi_analytic.steady_ellipse import (
    LEAST_LOAD,
    Ellipses,
    LamTable,
    by_largest_load,
    careful_bracket,
    density_of,
    dissipation_and_error,
    ellipses_of,
    lam_error,
    quadrature_error,
    quick_bracket,
    works_by_lam,
)

Indices = NDArray[np.intp]

_MEMBERS = 256
# Samples between two kinks or events, closer together at both, and what is left of them where a
# profile has many corners; samples beside the kinks, as shares of the smaller part of the slip
# zone.
_INSIDE = (1 - np.cos(math.pi * np.arange(1, 6) / 6)) / 2
_FEW = 8
_FEW_INSIDE = slice(2, 3)
_BESIDE_KINK = 0.03 * np.power(0.1, np.arange(4))
# Samples that differ by less than this share of the largest, at more than this share of the slip
# zone, get others in between.
_LEVEL = 0.01
_CLOSER = np.array([0.25, 0.5, 0.75])
# Share of the slip zone within which two samples are one.
_ALIKE = 1e-10
# A maximum is found when W may rise by this share of it only; by every second node of the rule at
# first.
_NEARLY = 1e-5
_KNOWN = 1e-10
# Each round takes a bracket to a fourth where W is smooth, every other one to half at worst.
_ROUNDS = 40
_EVENLY = np.array([0.21, 0.47, 0.73])
_THREE = np.array([[-1], [0], [1]])
# Of what the rule over punches misses of W of half-planes, what it may leave in the change by
# bodies: 1.4 at most on five profiles with three curvatures, against 200 nodes.
_OF_RULE = 4
# A second maximum counts where W falls between the two by this share of the larger; samples are
# good to 1e-6.
_DISTINCT = 1e-3


def maxima_of(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """The two largest maxima over x of the friction work per area W(x), for each of m steady
    `ellipses` of loads, (6, m); `contact` is the normal contact P(a) of the profile.

    Rows: the largest W(x) pi E*/(2 f^2), the second largest, the error of the largest, their |x|,
    and that of the largest as a fraction, 0 at the permanent stick edge, 1 at the largest contact.
    The largest is 0, and the other rows but its error NaN, where nothing slips. The second one is
    NaN where there is one maximum only. All are NaN where a sample of W(x) is.

    Between the half-widths at which the law of W(x) changes it is sampled with half of the
    quadrature nodes. A maximum is looked for about every sample above its neighbours.
    """
    if len(ellipses.mean_load) > _MEMBERS:
        block_starts = range(0, len(ellipses.mean_load), _MEMBERS)
        maxima_of_blocks = [
            maxima_of(ellipses.take(slice(k, k + _MEMBERS)), contact) for k in block_starts
        ]
        return np.concatenate(maxima_of_blocks, axis=1)

    def density(ellipse_numbers: Indices, x: Array, node_stride: int = 1) -> Array:
        forward, reverse = density_of(ellipses.take(ellipse_numbers), contact, x, node_stride)
        return forward + reverse

    points = _points_of_search(ellipses, contact)
    samples, is_unknown = _samples(points, partial(density, node_stride=2))
    maxima = _local_maxima(samples, density)
    peaks = _largest_of(maxima, ellipses, points, is_unknown, density)
    second_work, second_place = _second_of(maxima, samples.work, peaks)
    stick_edge = points[:, 0]
    largest_half_width = points[:, -1]
    place_fraction = (peaks.place - stick_edge) / np.where(
        largest_half_width > stick_edge, largest_half_width - stick_edge, 1.0
    )
    return np.stack(
        [peaks.work, second_work, peaks.error, peaks.place, second_place, place_fraction]
    )


class _LocalMaxima(NamedTuple):
    """Local maxima of W(x) of all ellipses, (n,) each.

    Attributes
    ----------
    ellipse
        number of the ellipse
    sample
        number of the sample of W that is above its neighbours
    vertex
        top of the parabola through three points close about it
    """

    ellipse: Indices
    sample: Indices
    vertex: _Vertex

    def by_work(self) -> Indices:
        """Numbers of the maxima by ascending W."""
        return np.argsort(self.vertex.work, kind="stable")

    def largest_of_ellipses(self, n_ellipses: int) -> Indices:
        """Number of the largest maximum of each ellipse, -1 where there is none: (m,)."""
        numbers = self.by_work()
        largest = np.full(n_ellipses, -1)
        largest[self.ellipse[numbers]] = numbers
        return largest


def _local_maxima(samples: _Samples, density: Callable[..., Array]) -> _LocalMaxima:
    """Every local maximum of W(x), looked for about each sample above its neighbours: first with
    half of the quadrature nodes, then with all.

    `density`(ellipse numbers, x, node_stride=1) gives W.
    """
    work = samples.work
    is_local_maximum = (work[1:-1] > work[:-2]) & (work[1:-1] >= work[2:])
    sample_numbers = np.flatnonzero(is_local_maximum) + 1
    ellipse = samples.member[sample_numbers]
    three_x, _ = _closer(
        partial(density, node_stride=2),
        ellipse,
        samples.x[sample_numbers + _THREE],
        work[sample_numbers + _THREE],
        _NEARLY,
    )
    three_works = np.stack([density(ellipse, row) for row in three_x])
    three_x, three_works = _closer(density, ellipse, three_x, three_works, _KNOWN)
    return _LocalMaxima(ellipse, sample_numbers, _parabola(three_x, three_works))


class _Peaks(NamedTuple):
    """Largest maximum of W(x) of each ellipse, (m,) each: W pi E*/(2 f^2), its error, |x|, and
    which of the local maxima it is, -1 for none.
    """

    work: Array
    error: Array
    place: Array
    number: Indices


def _largest_of(
    maxima: _LocalMaxima,
    ellipses: Ellipses,
    points: Array,
    is_unknown: NDArray[np.bool_],
    density: Callable[..., Array],
) -> _Peaks:
    """The largest maximum of W(x) of each ellipse with its error: 0 where nothing slips, NaN where
    W `is_unknown` (m,) at some sample.

    The error adds what the maximum may rise between its points, what the quadrature leaves out, and
    round-off. Where d = P - P_c, the load of the slip zone, is small the last digits of P_x, the
    load at which the edge of contact is at x, count for more.

    Parameters
    ----------
    points
        (m, n) from the permanent stick edge to the largest contact
    density
        W of (ellipse numbers, x, stride of the quadrature nodes)
    """
    stick_edge = points[:, 0]
    largest_half_width = points[:, -1]
    deepest_load = ellipses.deepest_slip
    relative_error = (
        LAST_DIGITS
        * (ellipses.mean_load + ellipses.load_amplitude)
        / np.where(deepest_load > 0, deepest_load, np.inf)
    )
    relative_error = PROMISED + 3 * relative_error
    # W(x) that is lost in the last digits is at most the product of p, 2 (u + v) and
    # arccosh(|x|/c), which is 2 (u + v) d/(pi a).
    error_without_slip = (
        2
        / math.pi
        * (ellipses.u + ellipses.v)
        * deepest_load
        / np.where(stick_edge > 0, stick_edge, largest_half_width)
    )
    n_ellipses = len(ellipses.mean_load)
    number_of_largest = maxima.largest_of_ellipses(n_ellipses)
    largest_work = np.where(is_unknown, np.nan, 0.0)
    error_of_largest = np.where(is_unknown, np.nan, error_without_slip)
    place_of_largest = np.full(n_ellipses, np.nan)
    slipping_ellipses = np.flatnonzero((number_of_largest >= 0) & ~is_unknown)
    peak_numbers = number_of_largest[slipping_ellipses]
    vertex = maxima.vertex
    largest_work[slipping_ellipses] = vertex.work[peak_numbers]
    place_of_largest[slipping_ellipses] = vertex.place[peak_numbers]
    works_by_rules = np.stack(
        [
            density(slipping_ellipses, place_of_largest[slipping_ellipses], node_stride)
            for node_stride in (1, 2, 4)
        ]
    )
    rule_error = quadrature_error(works_by_rules, works_by_rules[0])
    relative_rule_error = rule_error + relative_error[slipping_ellipses]
    error_of_largest[slipping_ellipses] = (
        vertex.rise[peak_numbers] + vertex.work[peak_numbers] * relative_rule_error
    )
    return _Peaks(largest_work, error_of_largest, place_of_largest, number_of_largest)


def _second_of(maxima: _LocalMaxima, sampled_work: Array, peaks: _Peaks) -> tuple[Array, Array]:
    """W pi E*/(2 f^2) and |x| of the second largest maximum of W(x) of each ellipse, (m,) each; NaN
    where there is one maximum only.

    It counts where W falls between it and the largest one by a share of that, and not by the last
    digits only. `sampled_work` is W at all samples.
    """
    n_ellipses = len(peaks.work)
    second_work = np.full(n_ellipses, np.nan)
    second_place = np.full(n_ellipses, np.nan)
    if not len(maxima.sample):
        return second_work, second_place
    ends_of_gaps = np.sort(
        np.stack([maxima.sample, maxima.sample[peaks.number[maxima.ellipse]]]), axis=0
    )
    least_between = np.minimum.reduceat(sampled_work, ends_of_gaps.T.ravel())[::2]
    least_fall = np.maximum(_DISTINCT * peaks.work, 2 * peaks.error)
    numbers = maxima.by_work()
    ellipse = maxima.ellipse[numbers]
    work = maxima.vertex.work[numbers]
    is_second = numbers != peaks.number[ellipse]
    is_distinct = least_between[numbers] < work - least_fall[ellipse]
    second_numbers = numbers[is_second & is_distinct]
    # By ascending W: the last one of an ellipse stays.
    second_work[maxima.ellipse[second_numbers]] = maxima.vertex.work[second_numbers]
    second_place[maxima.ellipse[second_numbers]] = maxima.vertex.place[second_numbers]
    return second_work, second_place


class _Samples(NamedTuple):
    """Points of members, one member after the other, ascending, and W there, (n,) each."""

    member: Indices
    x: Array
    work: Array


def _samples(
    points: Array, density: Callable[[Indices, Array], Array]
) -> tuple[_Samples, NDArray[np.bool_]]:
    """Samples of the friction work W(x) of each ellipse at its `points` (m, n), and at more points
    where W is nearly level; and for which ellipses W is not known at some point, (m,).

    Of equal points one counts. At both ends of the slip zone W is set to 0. `density`(ellipse
    numbers, x) gives W.
    """
    widths_of_zones = points[:, -1] - points[:, 0]
    is_new = np.diff(points, axis=1, prepend=-np.inf) > _ALIKE * widths_of_zones[:, None]
    ellipse_of_point = np.nonzero(is_new)[0]
    x = points[is_new]
    work = density(ellipse_of_point, x)
    is_unknown = np.bincount(ellipse_of_point, np.isnan(work), len(points)) > 0
    # Nothing is dissipated at the ends of the slip zone: no maximum is there, and members next to
    # each other stay apart.
    first_numbers = np.flatnonzero(np.diff(ellipse_of_point, prepend=-1))
    last_numbers = np.append(first_numbers[1:], len(x)) - 1
    work[first_numbers] = 0.0
    work[last_numbers] = 0.0
    # Samples are put closer where W is nearly level, lest one of two maxima next to each other is
    # missed.
    level_scale = (_LEVEL * np.maximum.reduceat(work, first_numbers))[ellipse_of_point[:-1]]
    is_high = (work[:-1] > level_scale) & (work[1:] > level_scale)
    is_level = (np.abs(np.diff(work)) < level_scale) & is_high
    is_wide = np.diff(x) > _LEVEL * widths_of_zones[ellipse_of_point[:-1]]
    level_gaps = np.flatnonzero(is_level & is_wide)
    new_x = (x[level_gaps] + np.diff(x)[level_gaps] * _CLOSER[:, None]).ravel()
    ellipse_of_new_point = np.tile(ellipse_of_point[level_gaps], len(_CLOSER))
    work = np.concatenate([work, density(ellipse_of_new_point, new_x)])
    ellipse_of_point = np.concatenate([ellipse_of_point, ellipse_of_new_point])
    x = np.concatenate([x, new_x])
    order_by_ellipse = np.lexsort((x, ellipse_of_point))
    return _Samples(
        ellipse_of_point[order_by_ellipse], x[order_by_ellipse], work[order_by_ellipse]
    ), is_unknown


def _points_of_search(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """Points at which W(x) of each ellipse is sampled, from the permanent stick edge to the largest
    contact, ascending, some of them equal: (m, n).

    They lie between the half-widths at which the law of W(x) changes: contact or stick edge at an
    event of the cycle, corners of the profile. More lie next to the kinks of W(x).
    """
    least_load = ellipses.mean_load - ellipses.load_amplitude
    largest_load = ellipses.mean_load + ellipses.load_amplitude
    event_cosines = (
        ellipses.cosine_of_start,
        np.cos(ellipses.slip_start + ellipses.slip_angle),
        -ellipses.cosine_of_start,
        np.cos(ellipses.slip_start - ellipses.slip_angle),
    )
    event_loads = [ellipses.load(cosine) for cosine in event_cosines]
    corners = np.clip(contact.break_loads[:, None], ellipses.permanent_stick_load, largest_load)
    loads = np.stack(
        [ellipses.permanent_stick_load, least_load, *event_loads, *corners, largest_load]
    )
    loads = np.clip(loads, ellipses.permanent_stick_load, largest_load)
    clipped_least_load = loads[1:2]
    half_widths = contact.half_width(np.sort(loads, axis=0))
    few_corners = len(corners) <= _FEW
    shares_of_intervals = _INSIDE if few_corners else _INSIDE[_FEW_INSIDE]
    inner_points = (
        half_widths[:-1] + np.diff(half_widths, axis=0) * shares_of_intervals[:, None, None]
    )
    kink_loads = clipped_least_load
    if few_corners:
        kink_loads = np.concatenate([clipped_least_load, corners])
    kink_half_widths = contact.half_width(kink_loads)
    distance_to_kink = (
        np.minimum(kink_half_widths - half_widths[0], half_widths[-1] - kink_half_widths)
        * _BESIDE_KINK[:, None, None]
    )
    rows_of_points = [
        points_of_ellipses.reshape(-1, len(least_load))
        for points_of_ellipses in (
            inner_points,
            kink_half_widths - distance_to_kink,
            kink_half_widths + distance_to_kink,
        )
    ]
    return np.sort(np.concatenate([half_widths, *rows_of_points]), axis=0).T


def _closer(
    density: Callable[[Indices, Array], Array],
    ellipse_of_maximum: Indices,
    three_places: Array,
    works_at_three: Array,
    known_share: float,
) -> tuple[Array, Array]:
    """Narrow brackets of three points about maxima of W(x), until W may rise by `known_share` of
    itself at most: the places and W there, (3, n).

    Round by round a parabola through the three points says where the next ones go. Where that does
    not halve the bracket, the next ones divide it evenly.

    Parameters
    ----------
    density
        W at places (n,) of ellipses of these numbers (n,)
    ellipse_of_maximum
        (n,) number of the ellipse whose maximum it is
    three_places, works_at_three
        (3, n) places and W to begin with
    """
    three_places = three_places.copy()
    works_at_three = works_at_three.copy()
    open_numbers = np.arange(len(ellipse_of_maximum))
    is_slow = np.zeros(len(ellipse_of_maximum), dtype=bool)
    for _ in range(_ROUNDS):
        vertex = _parabola(three_places[:, open_numbers], works_at_three[:, open_numbers])
        is_rough = vertex.rise > known_share * np.abs(works_at_three[1, open_numbers])
        open_numbers = open_numbers[is_rough]
        if not len(open_numbers):
            break
        bracket_places = three_places[:, open_numbers]
        bracket_width = bracket_places[2] - bracket_places[0]
        places_by_parabola = _next_points(bracket_places, vertex.place[is_rough])
        even_places = bracket_places[0] + bracket_width * _EVENLY[:, None]
        new_places = np.where(is_slow[open_numbers], even_places, places_by_parabola)
        new_works = [density(ellipse_of_maximum[open_numbers], row) for row in new_places]
        places = np.concatenate([bracket_places, new_places])
        works = np.concatenate([works_at_three[:, open_numbers], new_works])
        ascending = np.argsort(places, axis=0, kind="stable")
        places = np.take_along_axis(places, ascending, 0)
        works = np.take_along_axis(works, ascending, 0)
        numbers_of_three = np.clip(np.argmax(works, axis=0), 1, len(works) - 2) + _THREE
        three_places[:, open_numbers] = np.take_along_axis(places, numbers_of_three, 0)
        works_at_three[:, open_numbers] = np.take_along_axis(works, numbers_of_three, 0)
        is_slow[open_numbers] = (
            three_places[2, open_numbers] - three_places[0, open_numbers] > bracket_width / 2
        )
    return three_places, works_at_three


def _next_points(bracket: Array, vertex_place: Array) -> Array:
    """Three points (3, n) at which a maximum is looked for next, about the vertex of a parabola at
    `vertex_place` (n,), within brackets of three places (3, n).

    They keep away from the ends of the bracket and from its middle place, where W is known.
    """
    left_end, middle_place, right_end = bracket
    bracket_width = right_end - left_end
    vertex_place = np.clip(
        vertex_place, left_end + 0.02 * bracket_width, right_end - 0.02 * bracket_width
    )
    half_step = np.clip(
        2 * np.abs(vertex_place - middle_place), 0.003 * bracket_width, 0.125 * bracket_width
    )
    is_middle = np.abs(vertex_place - middle_place) < 0.1 * half_step
    centre_place = np.where(is_middle, middle_place, vertex_place)
    left_point = np.maximum(centre_place - half_step, (left_end + centre_place) / 2)
    right_point = np.minimum(centre_place + half_step, (centre_place + right_end) / 2)
    # A vertex that is all but the middle point needs no work of its own: the third point goes
    # beyond.
    trial_point = np.where(is_middle, (right_point + right_end) / 2, vertex_place)
    return np.stack([left_point, trial_point, right_point])


class _Vertex(NamedTuple):
    """The vertex of the parabola through three points, the middle one where it bends up, (n,) each:
    W and place of it; how far a concave W may rise above the middle point.
    """

    work: Array
    place: Array
    rise: Array


def _parabola(x: Array, work: Array) -> _Vertex:
    """Top of the parabola through three points (x, W) of each of n maxima, (3, n) each, and the
    most that W can rise above the middle point.

    A concave W stays below the chords of the points, drawn on. Where the parabola bends up the
    middle point stands for its top.
    """
    lengths = np.diff(x, axis=0)
    length_before, length_after = lengths
    slope_before, slope_after = np.diff(work, axis=0) / np.where(lengths > 0, lengths, np.inf)
    length_of_both = np.where(
        length_before + length_after > 0, length_before + length_after, np.inf
    )
    bend = (slope_after - slope_before) / length_of_both
    slope = (slope_before * length_after + slope_after * length_before) / length_of_both
    shift = np.where(bend < 0, slope / np.where(bend < 0, -2 * bend, 1.0), 0.0)
    return _Vertex(
        work=work[1] + slope * shift / 2,
        place=x[1] + shift,
        rise=np.maximum(np.abs(slope_before) * length_after, np.abs(slope_after) * length_before),
    )


_LOADS = (
    "mean_normal_load",
    "normal_amplitude",
    "mean_tangential_load",
    "tangential_amplitude",
    "phase_radians",
    "friction_coefficient",
)
_BLOCK = 16384
# Shares of P0 that P - P_c must reach for the quick way to Lam, which there loses 6e-11 of W by
# formulas, 1e-12 by the table.
_DEEP = 0.02
_DEEP_ON_TABLE = 0.04
_LEAST = 1 / LARGEST
_HALF = Elastic(young_modulus=2.0, poisson_ratio=0.0)  # against itself E* = 1


class Reason(IntEnum):
    """Why a member of a batch has no value."""

    NONE = 0
    SLIDING = 1
    SEPARATION = 2
    INVALID = 3
    EXTENT = 4
    UNSETTLED = 5


@dataclass(frozen=True, eq=False)
class DissipationBatch:
    """Friction work of one steady cycle of each member, arrays of the broadcast shape [energy per
    unit thickness].

    Attributes
    ----------
    value
        forward and reverse slip together; NaN where `reason` is not 0
    forward, reverse
        the two parts
    permanent_stick_load
        P_T [force per thickness]
    reason
        `Reason` of each member: 0 none, 1 gross sliding, 2 separation, 3 a value that is
        masked, NaN or not admitted (P0 > 0, the rest of the loads >= 0, parameters by the rules
        of the profile; all of them, and P0 over E* and the height unit of the profile, which is
        b^2/R of a flat face, at most 1e100 and where they are scales at least 1e-100), 4 the
        profile ends before the contact does, 5 the quadrature did not converge
    value_error
        error of `value` from above [energy per unit thickness]: by quadrature and by round-off;
        NaN where `reason` is not 0
    notes
        what holds for all members and must not be missed: the coupling of unlike materials,
        which is neglected
    """

    value: Array
    forward: Array
    reverse: Array
    permanent_stick_load: Array
    reason: NDArray[np.int8]
    value_error: Array
    notes: tuple[str, ...] = field(default=(), kw_only=True)


@dataclass(frozen=True, eq=False)
class PeakBatch:
    """Largest pointwise friction work of one steady cycle of each member, arrays of the broadcast
    shape.

    Attributes
    ----------
    value
        max W(x) [energy per area], the largest of all maxima; NaN where `reason` is not 0, 0
        where nothing slips
    place
        |x| of the peak [length]; NaN where nothing slips
    fraction
        the same between the permanent stick edge (0) and the largest contact (1)
    reason, notes
        as in `DissipationBatch`
    second_value, second_place
        the second largest maximum of W(x), where W falls by more than 1e-3 of the peak between
        the two; NaN where there is one maximum only
    value_error
        error of `value` from above [energy per area]: by quadrature, by round-off and by the
        search
    """

    value: Array
    place: Array
    fraction: Array
    reason: NDArray[np.int8]
    second_value: Array
    second_place: Array
    value_error: Array
    notes: tuple[str, ...] = field(default=(), kw_only=True)


@accepts_phase
def dissipation(
    *,
    profile: Profile | Mapping[str, Any],
    material: Materials | Elastic,
    friction_coefficient: ArrayLike,
    mean_normal_load: ArrayLike,
    normal_amplitude: ArrayLike,
    tangential_amplitude: ArrayLike,
    phase_degrees: ArrayLike | None = None,
    phase_radians: ArrayLike | None = None,
    mean_tangential_load: ArrayLike = 0.0,
    effects: BodyEffects | None = None,
) -> DissipationBatch:
    """Friction work of one steady cycle of the loads P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase),
    for arrays of loads, profiles and friction; every argument broadcasts.

    Parameters
    ----------
    profile
        any profile, or its keys with numbers or arrays: {"kind": "flat_rounded", "radius": ...,
        "flat_half_length": ...}; the rises of a polynomial are a list of numbers or arrays. Tables
        and functions have no keys that could be arrays
    material
        of the two bodies, or one for both
    friction_coefficient
        f
    mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude
        P0, P1, Q0, Q1 [force per unit thickness]
    phase_degrees, phase_radians
        lag of Q behind P, any sense, in degrees or in radians; 90 degrees where neither is given
    effects
        what finite bodies add to half-planes, curvatures and compliances that follow the loads, for
        all members. Some 0.3 ms a member; `permanent_stick_load` then is the load of half-planes
        whose contact is the permanent stick zone. A member whose contact would split or leave the
        profile gets NaN

    Returns
    -------
    DissipationBatch
        A member that is inadmissible gets NaN and a reason; the others get their values. Each is
        exact to 1e-11 of A f^2 P0^2 or 1e-10 relative, and to `value_error`, from slips of 1e-9 to
        gross sliding itself. Q0 decides on gross sliding only. No member depends on the others: it
        is what a batch of it alone gives. Hertz and power laws take some 0.6 us a member, flat and
        rounded 1.5 us. The other profiles are integrated from corner to corner with one table of ln
        a(P) for all loads within eight octaves: 8 to 14 us, 20 us for tables of 31 rows, and 1 ms
        and more where P - P_c stays below 1e-6 of P0. Where the parameters are arrays each
        different polynomial or R2/R1 costs 1.5 to 2 ms.

    Raises
    ------
    InputError
        For a mapping of a kind whose parameters cannot vary, for shapes that do not broadcast, and
        for values that are no real numbers: complex ones, truth values, texts.

    Examples
    --------
    >>> from scenes import Elastic, Hertz
    >>> steel = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    >>> batch = dissipation(
    ...     profile=Hertz(radius=1.0),
    ...     material=Materials(upper=steel, lower=steel),
    ...     friction_coefficient=1.0,
    ...     mean_normal_load=3.0,
    ...     normal_amplitude=1.0,
    ...     mean_tangential_load=1.1,
    ...     tangential_amplitude=[1.0, 5.0],
    ... )
    >>> [round(value, 12) for value in batch.value.tolist()], batch.reason.tolist()
    ([0.260168505754, nan], [0, 1])
    """
    loads = EllipseLoads(
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase_in_radians(phase_degrees, phase_radians),
        friction_coefficient,
    )
    material = _of_both(material)
    effects = checked_effects(effects)
    works_of = _works_of
    notes = list(neglected_coupling(material))
    if effects is not None:
        works_of = partial(_works_with_effects, curvatures_of(effects))
        notes.extend(notes_of_batch(effects))
    columns, reason = _columns(profile, material, loads, works_of, n_results=5, n_scaled=4)
    value, forward, reverse, error, stick = columns
    return DissipationBatch(value, forward, reverse, stick, reason, error, notes=tuple(notes))


def _works_of(members: Members) -> Array:
    """Friction work of the members of an array of load ellipses times pi E*/(2 f^2): sum, forward
    and reverse part, error; and the permanent stick load P_T, (5, m).

    The method follows the profile: a closed kernel for Hertz and power laws, a table for flat and
    rounded faces, else quadrature with one contact for each shape. Ellipses that were mirrored have
    forward and reverse slip exchanged.
    """
    ellipses = members.ellipses
    kind = members.kind
    forward, reverse, error = works = np.empty((3, len(members.mirrored)))
    if kind in ("hertz", "power_law"):
        works[:2] = works_by_lam(ellipses, quick_bracket, careful_bracket, _DEEP)
        works[2] = lam_error(ellipses, works[0] + works[1], _DEEP, 1.0)
        works /= members.parameters[0] if kind == "power_law" else 2
    elif kind == "flat_rounded":
        _, height, *_ = _UNITS[kind](*members.parameters)
        works[:] = _works_on_table(ellipses, members.modulus * height)
    else:
        for shape_group in members.groups():
            works_of_group = dissipation_and_error(shape_group.ellipses, shape_group.contact)
            works[:, shape_group.members] = (
                works_of_group * shape_group.load_unit * shape_group.load_unit
            )
    forward_of_members = np.where(members.mirrored, reverse, forward)
    reverse_of_members = np.where(members.mirrored, forward, reverse)
    return np.stack(
        [
            forward + reverse,
            forward_of_members,
            reverse_of_members,
            error,
            ellipses.permanent_stick_load,
        ]
    )


def _works_with_effects(curvatures: Curvatures, members: Members) -> Array:
    """Friction work of the members of an array of load ellipses, with the curvatures that finite
    bodies add: sum, forward and reverse part, error, and permanent stick load, (5, m).

    It is exact half-plane theory plus what the bodies change. One quadrature rule gives the works
    with and without them, so that its error hardly counts. Works are times pi E*/(2 f^2).
    """
    works = _works_of(members)
    for shape_group in members.groups():
        columns_of_loads = LoadArrays(
            *(column[shape_group.members, None] for column in members.loads)
        )
        ones = np.ones((len(shape_group.members), 1))
        loads = EllipseOfLoads(
            mean_normal=columns_of_loads.mean,
            normal_amplitude=columns_of_loads.amplitude,
            mean_tangential=columns_of_loads.force,
            tangential_amplitude=columns_of_loads.tangential,
            phase=columns_of_loads.phase,
            friction=columns_of_loads.friction,
        ).over(np.reshape(shape_group.load_unit, (-1, 1)) * ones)
        # Of profiles that vary the contact has E* = 1 in its own units, of one profile its own E*.
        modulus = members.modulus if members.contact is not None else 1.0
        squared_length_unit = np.reshape(np.square(shape_group.length_unit), (-1, 1)) * ones
        curvatures_of_bodies = BendColumns.of(
            curvatures, members.modulus / modulus * squared_length_unit
        )
        no_curvatures = BendColumns.of(Curvatures(), ones)
        works_of_half_planes = works_of_ellipses(loads, no_curvatures, shape_group.contact, modulus)
        works_of_bodies = works_of_ellipses(
            loads, curvatures_of_bodies, shape_group.contact, modulus
        )
        work_unit = np.square(shape_group.load_unit / members.loads.friction[shape_group.members])
        forward_change = work_unit * (works_of_bodies.forward - works_of_half_planes.forward)
        reverse_change = work_unit * (works_of_bodies.reverse - works_of_half_planes.reverse)
        works_by_rule = work_unit * (works_of_half_planes.forward + works_of_half_planes.reverse)
        rule_error = np.abs(works_by_rule - works[0, shape_group.members])
        works[0, shape_group.members] += forward_change + reverse_change
        works[1, shape_group.members] += forward_change
        works[2, shape_group.members] += reverse_change
        works[3, shape_group.members] += _OF_RULE * rule_error
        works[4, shape_group.members] = shape_group.load_unit * shape_group.contact.load(
            works_of_bodies.stick
        )
    return works


@accepts_phase
def peak_dissipation(
    *,
    profile: Profile | Mapping[str, Any],
    material: Materials | Elastic,
    friction_coefficient: ArrayLike,
    mean_normal_load: ArrayLike,
    normal_amplitude: ArrayLike,
    tangential_amplitude: ArrayLike,
    phase_degrees: ArrayLike | None = None,
    phase_radians: ArrayLike | None = None,
    mean_tangential_load: ArrayLike = 0.0,
) -> PeakBatch:
    """Largest friction work per area W(x) in one steady cycle of P = P0 + P1 cos t, Q = Q0 + Q1
    cos(t - phase), and where it is, for arrays of loads, profiles and friction.

    W(x) may have two maxima: the shoulder, just inside the contact half-width a(P_min) of the least
    load, and one further out. Each piece between the kinks of W(x) is searched, which are at
    a(P_min) and at the corners of the profile. The value is good to some 1e-10 of itself, or to
    `value_error` of the result where slip is tiny. A member takes 3 ms for Hertz, 10 to 15 ms for
    power laws, flat and rounded, 20 ms for polynomials, wedges and compound curvatures, 0.1 s for
    tables of 31 rows.

    Parameters
    ----------
    profile, material
        one profile, or its keys with numbers or arrays; of the two bodies, or one for both
    friction_coefficient
        f
    mean_normal_load, normal_amplitude, mean_tangential_load, tangential_amplitude
        P0, P1, Q0, Q1 [force per unit thickness]
    phase_degrees, phase_radians
        lag of Q behind P, in degrees or in radians; 90 degrees where neither is given

    Examples
    --------

    >>> from scenes import Elastic, Hertz
    >>> steel = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    >>> batch = peak_dissipation(
    ...     profile=Hertz(radius=1.0),
    ...     material=Materials(upper=steel, lower=steel),
    ...     friction_coefficient=1.0,
    ...     mean_normal_load=3.0,
    ...     normal_amplitude=1.0,
    ...     tangential_amplitude=1.0,
    ... )
    >>> round(float(batch.fraction), 3)  # the paper: "just over 60 %"
    0.595
    """
    loads = EllipseLoads(
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase_in_radians(phase_degrees, phase_radians),
        friction_coefficient,
    )
    material = _of_both(material)
    columns, reason = _columns(profile, material, loads, _maxima_of, n_results=6, n_scaled=3)
    value, second_value, error, place, second_place, fraction = columns
    notes = tuple(neglected_coupling(material))
    return PeakBatch(value, place, fraction, reason, second_value, second_place, error, notes=notes)


def _maxima_of(members: Members) -> Array:
    """Both maxima of W(x) and the error of the first, their places, and the first place over the
    half-width, (6, m).
    """
    maxima = np.empty((6, len(members.mirrored)))
    for group in members.groups():
        of_group = maxima_of(group.ellipses, group.contact)
        of_group[:3] *= group.load_unit / group.length_unit * group.load_unit
        of_group[3:5] *= group.length_unit
        maxima[:, group.members] = of_group
    return maxima


def _works_on_table(ellipses: Ellipses, unit: Array) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2), and the error of their sum,
    (3, m), of steady ellipses on flat and rounded faces, by tables of the kernel.

    Loads are taken over `unit` = E* b^2/R (m,), b half-length of the flat, R radius of the edges:
    one table serves all such faces.
    """
    ellipses = ellipses.over(unit)
    works = np.empty((3, len(unit)))
    for numbers_of_table, first_load, last_load in by_largest_load(ellipses):
        table = _table(first_load, last_load)
        ellipses_of_table = ellipses.take(numbers_of_table)
        forward, reverse = works_by_lam(
            ellipses_of_table, table.quick, table.careful, _DEEP_ON_TABLE, LEAST_LOAD
        )
        works[0, numbers_of_table] = forward
        works[1, numbers_of_table] = reverse
        works[2, numbers_of_table] = lam_error(
            ellipses_of_table, forward + reverse, _DEEP_ON_TABLE, table.largest
        )
    return works * unit * unit


@lru_cache(maxsize=32)
def _table(first_load: int, last_load: int) -> LamTable:
    return LamTable(_contact("flat_rounded", ()), first_load, last_load)


# ------------------------------------------------------------------------ members and their reasons
class EllipseLoads(NamedTuple):
    """Loads of a batch and its friction, numbers or arrays (m,): P0, P1, Q0, Q1, phase, f."""

    mean: ArrayLike
    amplitude: ArrayLike
    force: ArrayLike
    tangential: ArrayLike
    phase: ArrayLike
    friction: ArrayLike


class LoadArrays(NamedTuple):
    """The same as arrays (m,)."""

    mean: Array
    amplitude: Array
    force: Array
    tangential: Array
    phase: Array
    friction: Array


class Group(NamedTuple):
    """Members (k,) whose profiles differ by units only: the contact in these units with E* = 1,
    their loops, the units of load and of length, (k,) or one.
    """

    members: Indices
    contact: SymmetricContact
    ellipses: Ellipses
    load_unit: Array | float
    length_unit: Array | float


@dataclass(frozen=True, eq=False)
class Members:
    """The good members of some of a batch.

    Attributes
    ----------
    kind
        of their profiles
    parameters
        (m,) each, in the order of `_KEYS`; none for a table or a function
    contact
        of a profile that is given as such; None where its parameters may vary
    modulus
        E*
    ellipses
        their loops
    mirrored
        (m,) whether Q goes round the other way
    loads
        as they were given, (m,) each
    """

    kind: str
    parameters: list[Array]
    contact: SymmetricContact | None
    modulus: float
    ellipses: Ellipses
    mirrored: NDArray[np.bool_]
    loads: LoadArrays

    def groups(self) -> Iterator[Group]:
        """Members by their profiles."""
        if self.contact is not None:
            everybody = np.arange(len(self.mirrored))
            yield Group(everybody, self.contact, self.ellipses, 1.0, 1.0)
            return
        for members, shape, length, height in _by_shape(self.kind, self.parameters):
            load_unit = self.modulus * height
            loops = self.ellipses.take(members).over(load_unit)
            yield Group(members, _contact(self.kind, shape), loops, load_unit, length)


def _of_both(material: Materials | Elastic) -> Materials:
    return Materials(upper=material, lower=material) if isinstance(material, Elastic) else material


def _columns(
    profile: Profile | Mapping[str, Any],
    material: Materials,
    loads: EllipseLoads,
    results_of: Callable[[Members], Array],
    n_results: int,
    n_scaled: int,
) -> tuple[list[Array], NDArray[np.int8]]:
    """Compute `n_results` values for each member of a batch of load ellipses, block by block, and
    the code of the reason where a member has none, 0 else.

    All arrays have the broadcast shape of the inputs and are read-only; values without result are
    NaN.

    Parameters
    ----------
    profile, material, loads
        of all members; keys of the profile and loads may be arrays that broadcast
    results_of
        results (n_results, m) of m members with admissible loads; a member whose first result is
        not finite did not settle
    n_scaled
        how many results, from the first on, are given over 2 f^2/(pi E*)

    Raises
    ------
    InputError
        For a profile or material that does not pass its own check, for keys that are no profile's,
        for what is no number, and for shapes that do not broadcast.
    """
    material = validated(material, Materials)
    profile = validated(profile, Frozen) if isinstance(profile, Frozen) else profile
    kind, parameters = _parameters_of(profile)
    arguments = [real_numbers(value, name) for name, value in zip(_LOADS, loads, strict=True)]
    arguments += [real_numbers(value, f"profile: {name}") for name, value in parameters.items()]
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arguments))
    except ValueError as reason:
        raise InputError(f"the arrays of a batch must broadcast: {reason}") from reason
    batch = _Batch(kind, material, profile)
    n_members = math.prod(shape)
    columns = np.full((n_results, n_members), np.nan)
    reasons = np.zeros(n_members, dtype=np.int8)
    for first_member in range(0, n_members, _BLOCK):
        member_beyond = min(first_member + _BLOCK, n_members)
        arrays_of_block = [_part(array, shape, first_member, member_beyond) for array in arguments]
        reasons_of_block, places_in_block, members, friction = batch.members_of(
            LoadArrays(*arrays_of_block[: len(loads)]), arrays_of_block[len(loads) :]
        )
        if len(places_in_block):
            results_of_block = results_of(members)
            results_of_block[:n_scaled] *= 2 / (math.pi * batch.modulus) * friction**2
            columns[:, first_member + places_in_block] = results_of_block
            unsettled_places = places_in_block[~np.isfinite(results_of_block[0])]
            reasons_of_block[unsettled_places] = Reason.UNSETTLED
        reasons[first_member:member_beyond] = reasons_of_block
    columns.flags.writeable = False
    reasons.flags.writeable = False
    return [column.reshape(shape) for column in columns], reasons.reshape(shape)


class _Batch:
    """What all members of a batch share: kind of profile, E*, the contact and the largest load of
    a profile whose parameters do not vary.
    """

    def __init__(
        self, kind: str, material: Materials, profile: Profile | Mapping[str, Any]
    ) -> None:
        """What all members of a batch of load ellipses share: E*, and the normal contact of one
        `profile` with the largest load that it carries.

        Of a profile given as keys with arrays each member has its own contact, made later. `kind`
        is that of the profile.
        """
        self.kind = kind
        self.modulus = composite_modulus(material)
        self.contact: SymmetricContact | None = None
        self.largest_load = math.inf
        if not isinstance(profile, Mapping):
            self.contact = contact_of(profile, material)
            if self.contact.extent < math.inf:
                load_at_end = float(self.contact.load(self.contact.extent))
                self.largest_load = load_at_end * (1 - 1e-12)

    def members_of(
        self, loads: LoadArrays, parameters: list[Array]
    ) -> tuple[NDArray[np.int8], Indices, Members, Array]:
        """Sort out the members of a block of load ellipses that can have a result, from `loads` and
        `parameters` of the profile, (m,) each.

        Returns
        -------
        reason
            (m,) why a member has none, a code of `Reason`
        numbers
            (k,) of the members that can have one
        members
            these members with their ellipses
        friction
            (k,) their f
        """
        is_invalid = self._invalid(loads, parameters)
        if np.any(is_invalid):
            loads = LoadArrays(*(np.where(is_invalid, 1.0, column) for column in loads))
            parameters = [np.where(is_invalid, 1.0, column) for column in parameters]
        # Without friction only Q = 0 is admissible, and nothing is dissipated: any positive
        # coefficient gives that.
        friction = np.where(loads.friction > 0, loads.friction, 1.0)
        with np.errstate(over="ignore", invalid="ignore"):
            # Q1/f beyond all bounds slides.
            ellipses = ellipses_of(
                loads.mean, loads.amplitude, loads.tangential, loads.phase, friction
            )
        is_mirrored = np.tan(loads.phase / 2) < 0
        mean_force = np.where(is_mirrored, -loads.force, loads.force)
        reason_codes = _reasons(ellipses, mean_force, loads.tangential, loads.friction)
        is_too_large = loads.mean + loads.amplitude > self.largest_load
        reason_codes[(reason_codes == Reason.NONE) & is_too_large] = Reason.EXTENT
        reason_codes[is_invalid] = Reason.INVALID
        good_numbers = np.flatnonzero(reason_codes == Reason.NONE)
        if 0 < len(good_numbers) < len(reason_codes):
            ellipses = ellipses.take(good_numbers)
            is_mirrored = is_mirrored[good_numbers]
            friction = friction[good_numbers]
            parameters = [column[good_numbers] for column in parameters]
            loads = LoadArrays(*(column[good_numbers] for column in loads))
        members = Members(
            self.kind,
            parameters,
            self.contact,
            self.modulus,
            ellipses,
            is_mirrored,
            loads._replace(friction=friction),
        )
        return reason_codes, good_numbers, members, friction

    def _invalid(self, loads: LoadArrays, parameters: list[Array]) -> NDArray[np.bool_]:
        """Members (m,) whose numbers are none that can be used."""
        is_invalid = _invalid(loads)
        if self.contact is None:
            is_invalid |= _invalid_shapes(self.kind, parameters)
        if self.kind in _UNITS:
            is_invalid |= _beyond_units(self.kind, parameters, self.modulus, loads.mean)
        return is_invalid


def _part(array: Array, shape: tuple[int, ...], first_member: int, member_beyond: int) -> Array:
    """Members `first_member` to `member_beyond` of the array broadcast to `shape`, without the
    others.
    """
    if array.size == 1:
        return np.full(member_beyond - first_member, array.item())
    if array.shape == shape and array.flags.c_contiguous:
        return array.reshape(-1)[first_member:member_beyond]
    return np.broadcast_to(array, shape).flat[first_member:member_beyond]


def _invalid(loads: LoadArrays) -> NDArray[np.bool_]:
    """Members (m,) with values that are NaN or too large to be squared, or negative where they must
    not be.
    """
    admitted = np.logical_and.reduce([np.abs(values) <= LARGEST for values in loads])
    is_negative = (loads.amplitude < 0) | (loads.tangential < 0) | (loads.friction < 0)
    return np.asarray(~admitted | (loads.mean < 1 / LARGEST) | is_negative)


def _beyond_units(
    kind: str, parameters: list[Array], modulus: float, mean: Array
) -> NDArray[np.bool_]:
    """Members (m,) whose P0 in units of E* and the profile's own height is no number that can be
    squared.
    """
    with np.errstate(all="ignore"):
        _, height, *_ = _UNITS[kind](*parameters)
        load = mean / modulus / height
    return ~((load >= 1 / LARGEST) & (load <= LARGEST))


def _reasons(
    ellipses: Ellipses, mean_tangential_load: Array, tangential_amplitude: Array, friction: Array
) -> NDArray[np.int8]:
    """Reason why each of m load ellipses is inadmissible: separation, gross sliding, or none; codes
    of `Reason`, (m,).

    |Q| = f P is admitted, to round-off. The largest Q - f P and -Q - f P follow from the amplitudes
    u, v of (Q -+ f P)/f.

    Parameters
    ----------
    mean_tangential_load
        (m,) Q0, with its sign turned where the ellipse was mirrored [force per thickness]
    tangential_amplitude, friction
        (m,) Q1 and f
    """
    limit = friction * ellipses.mean_load
    round_off = 4e-16 * (
        np.abs(mean_tangential_load)
        + tangential_amplitude
        + limit
        + friction * ellipses.load_amplitude
    )
    # The greatest Q - f P and -Q - f P; without friction u and v are those of another coefficient.
    slides = (
        np.maximum(
            friction * ellipses.u + mean_tangential_load,
            friction * ellipses.v - mean_tangential_load,
        )
        > limit + round_off
    )
    slides |= (friction == 0) & (tangential_amplitude > 0)
    reasons = np.full(len(limit), Reason.NONE, dtype=np.int8)
    reasons[slides] = Reason.SLIDING
    reasons[ellipses.load_amplitude > ellipses.mean_load] = Reason.SEPARATION
    return reasons


# ------------------------------------------------------------------- profiles whose parameters vary
_KEYS = {
    "hertz": ("radius",),
    "flat_rounded": ("radius", "flat_half_length"),
    "power_law": ("exponent", "length", "rise"),
    "compound": ("inner_radius", "outer_radius", "inner_half_length"),
    "wedge": ("tip_radius", "tip_half_length"),
    "polynomial": ("length", "rises"),
}


def _units_of_polynomial(length: Array, *rises: Array) -> tuple[Array, ...]:
    largest_rise = np.max(np.abs(rises), axis=0)
    return length, largest_rise, *(rise / largest_rise for rise in rises)


# Units of length and of height of profiles with these parameters, and the shape that they leave.
_UNITS: dict[str, Callable[..., tuple[Array, ...]]] = {
    "hertz": lambda radius: (np.sqrt(radius), np.ones_like(radius)),
    "flat_rounded": lambda radius, b: (b, b * b / radius),
    "power_law": lambda exponent, length, rise: (length, rise, exponent),
    "compound": lambda inner, outer, b: (b, b * b / inner, outer / inner),
    "wedge": lambda radius, b: (b, b * b / radius),
    "polynomial": _units_of_polynomial,
}
# The profiles of these shapes.
_PROFILES: dict[str, Callable[..., Profile]] = {
    "hertz": lambda: Hertz(radius=1.0),
    "flat_rounded": lambda: FlatRounded(radius=1.0, flat_half_length=1.0),
    "power_law": lambda exponent: PowerLaw(exponent=exponent, length=1.0, rise=1.0),
    "compound": lambda ratio: Compound(inner_radius=1.0, outer_radius=ratio, inner_half_length=1.0),
    "wedge": lambda: Wedge(tip_radius=1.0, tip_half_length=1.0),
    "polynomial": lambda *rises: EvenPolynomial(length=1.0, rises=rises),
}


def _parameters_of(profile: Profile | Mapping[str, Any]) -> tuple[str, dict[str, ArrayLike]]:
    """The kind of a profile and its parameters by name, numbers or arrays; those of a polynomial's
    `rises` one by one; none of a table or a function.

    The profile may be a mapping of keys to arrays, one value for each member of a batch.

    Raises
    ------
    InputError
        For a kind whose parameters cannot vary, for a key too many or too few.
    """
    if not isinstance(profile, Mapping):
        names = [name for name in _KEYS.get(profile.kind, ()) if name != "rises"]
        numbers = {name: getattr(profile, name) for name in names}
        rises = profile.rises if isinstance(profile, EvenPolynomial) else ()
        return profile.kind, numbers | _numbered(rises)
    # A profile that was fitted to rows has a key `fitted` in its dump, which is no parameter.
    kind = profile.get("kind")
    values = {name: value for name, value in profile.items() if name not in ("kind", "fitted")}
    if kind not in _KEYS:
        raise InputError(
            f"profile: a mapping for a batch has one of the kinds {', '.join(_KEYS)}, not {kind!r};"
            " give the profile itself"
        )
    if set(values) != set(_KEYS[kind]):
        raise InputError(
            f"profile: {kind} comes with all its keys, {', '.join(_KEYS[kind])}, not"
            f" {', '.join(values) or 'none'}"
        )
    values = {name: values[name] for name in _KEYS[kind]}
    if kind != "polynomial":
        return kind, values
    rises = values.pop("rises")
    if not isinstance(rises, list | tuple) or not len(rises):
        raise InputError(
            "profile: rises is a list of numbers or arrays, one for each of the powers 2, 4, 6, ..."
        )
    return kind, values | _numbered(rises)


def _numbered(rises: Sequence[ArrayLike]) -> dict[str, ArrayLike]:
    """The rises of a polynomial by a name each."""
    return {f"rise {number}": rise for number, rise in enumerate(rises, 1)}


def _by_shape(
    kind: str, parameters: list[Array]
) -> Iterator[tuple[Indices, tuple[float, ...], Array, Array]]:
    """Groups of members of a batch whose profiles differ only by a unit of length and one of
    height, so that one contact serves them.

    Yields the numbers of the members (k,), the ratios of parameters that they have in common, and
    their units of length and height, (k,) each. `parameters` are (n,) each, by the `kind` of
    profile.
    """
    with np.errstate(all="ignore"):
        length_unit, height_unit, *ratios = _UNITS[kind](*parameters)
    if all(np.all(values == values[0]) for values in ratios):
        all_members = np.arange(len(length_unit))
        yield all_members, tuple(float(values[0]) for values in ratios), length_unit, height_unit
        return
    unlike_ratios, shape_of_member = np.unique(
        np.stack(ratios, axis=1), axis=0, return_inverse=True
    )
    shape_number = shape_of_member.reshape(-1)
    order_by_shape = np.argsort(shape_number, kind="stable")
    ends_of_shapes = np.cumsum(np.bincount(shape_number, minlength=len(unlike_ratios)))
    for unlike_shape, members in zip(
        unlike_ratios.tolist(), np.split(order_by_shape, ends_of_shapes[:-1]), strict=True
    ):
        yield members, tuple(unlike_shape), length_unit[members], height_unit[members]


@lru_cache(maxsize=512)
def _contact(kind: str, shape: tuple[float, ...]) -> SymmetricContact:
    """The contact of a profile in units of its own, with E* = 1."""
    return contact_of(_PROFILES[kind](*shape), Materials(upper=_HALF, lower=_HALF))


def _invalid_shapes(kind: str, parameters: list[Array]) -> NDArray[np.bool_]:
    """Members (m,) of a batch whose profile parameters are not admitted: numbers outside their
    range, or shapes under which the contact would split. True where invalid.
    """
    bounds = (_LEAST,) * len(parameters)
    if kind == "power_law":
        bounds = (1.0, _LEAST, _LEAST)
    elif kind == "polynomial":
        bounds = (_LEAST, *[-LARGEST] * (len(parameters) - 1))
    is_in_range = [
        (values >= bound) & (values <= LARGEST)
        for values, bound in zip(parameters, bounds, strict=True)
    ]
    is_invalid = ~np.logical_and.reduce(is_in_range)
    valid_numbers = np.flatnonzero(~is_invalid)
    if kind in ("polynomial", "compound") and len(valid_numbers):
        # By the rules of the profile, and by those of one contact.
        for numbers_of_shape, shape, _, _ in _by_shape(
            kind, [values[valid_numbers] for values in parameters]
        ):
            try:
                _contact(kind, shape)
            except InputError:
                is_invalid[valid_numbers[numbers_of_shape]] = True
    return is_invalid
