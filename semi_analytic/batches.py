"""Dissipation and its peak for arrays of ellipses: the two calls that sweeps and the paper's
figures 7 and 10 need.

Arguments are broadcast and taken block by block, so that memory beyond arguments and results is
that of one block. Bad members get a reason. The others are sorted by profile: those that differ by
units only share one contact, that of the same profile in units of its own. A profile of b, R1 and
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
from scenes.arrays import LARGEST_NUMBER, real_numbers
from scenes.frozen import Frozen, validated
from semi_analytic.answer import neglected_coupling
from semi_analytic.body_numbers import checked_effects
from semi_analytic.corrected import curvatures_of, notes_of_batch
from semi_analytic.corrected_batches import CurvatureColumns, EllipseOfLoads, works_of_ellipses
from semi_analytic.corrected_memory import Curvatures
from semi_analytic.elasticity import composite_modulus
from semi_analytic.memory import LAST_DIGITS, PROMISED_ERROR
from semi_analytic.phases import accepts_phase, phase_in_radians
from semi_analytic.profiles import SymmetricContact, contact_of
from semi_analytic.steady_ellipse import (
    LEAST_LOAD_SHARE,
    Ellipses,
    LamTable,
    careful_power_law_kernel,
    dissipation_and_error,
    ellipses_of,
    error_of_works_by_lam,
    groups_by_largest_load,
    quadrature_error,
    quick_power_law_kernel,
    work_density_of,
    works_by_lam,
)

Indices = NDArray[np.intp]

_ELLIPSES_AT_ONCE = 256
# Places of samples between two kinks or events, as fractions of their distance: closer together at
# both. The one in the middle is left where a profile has many corners.
_FRACTIONS_OF_INTERVAL = (1 - np.cos(math.pi * np.arange(1, 6) / 6)) / 2
_MIDDLE_FRACTION = slice(2, 3)
_FEW_CORNERS = 8
# Places of samples beside a kink, as fractions of the smaller part of the slip zone.
_DISTANCES_TO_KINK = 0.03 * np.power(0.1, np.arange(4))
# Neighbouring samples that differ by less than this fraction of the largest W, at a distance of
# more than this fraction of the slip zone, get others in between.
_NEARLY_LEVEL_FRACTION = 0.01
_QUARTER_FRACTIONS = np.array([0.25, 0.5, 0.75])
# Fraction of the slip zone within which two samples are one.
_SAME_POINT_WIDTH_SHARE = 1e-10
# A maximum is located when W may rise by this fraction of it at most: the first with every second
# node of the quadrature, the last with all.
_FIRST_RISE_TOLERANCE = 1e-5
_LAST_RISE_TOLERANCE = 1e-10
# Each round takes a bracket to a fourth where W is smooth, every other one to half at worst.
_MOST_ROUNDS = 40
_EVEN_BRACKET_FRACTIONS = np.array([0.21, 0.47, 0.73])
# From the number of a sample to those of itself and of its neighbours.
_NEIGHBOUR_OFFSETS = np.array([[-1], [0], [1]])
# Of what the rule over punches misses of W of half-planes, what it may leave in the change by
# bodies: 1.4 at most on five profiles with three curvatures, against 200 nodes.
_FACTOR_ON_RULE_ERROR = 4
# A second maximum counts where W falls between the two by this fraction of the larger; samples are
# good to 1e-6.
_LEAST_FALL_SHARE = 1e-3


def maxima_of(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """The two largest maxima over x of the friction work per area and cycle W(x), for each of m
    steady load ellipses, (6, m).

    The rows are:

    1. the largest W(x) pi E*/(2 f^2);
    2. the second largest, NaN where there is one maximum only;
    3. the error of the largest;
    4. |x| of the largest;
    5. |x| of the second largest;
    6. the place of the largest as a fraction, 0 at the permanent stick edge, 1 at the largest
       contact.

    Where nothing slips the largest is 0, and all other rows but its error are NaN. All are NaN
    where a sample of W(x) is.

    W(x) is sampled with half of the quadrature nodes, between the half-widths at which its formula
    changes. A maximum is looked for about every sample above its neighbours. All ellipses have the
    same `contact`, the normal contact P(a) of the profile; 256 are taken at a time. E* is the
    composite modulus, f the friction.
    """
    n_ellipses = len(ellipses.mean_load)
    if n_ellipses > _ELLIPSES_AT_ONCE:
        maxima_of_blocks = [
            maxima_of(
                ellipses.take(
                    slice(first_ellipse_number, first_ellipse_number + _ELLIPSES_AT_ONCE)
                ),
                contact,
            )
            for first_ellipse_number in range(0, n_ellipses, _ELLIPSES_AT_ONCE)
        ]
        return np.concatenate(maxima_of_blocks, axis=1)

    # (m, n) from the edge of permanent stick to the largest contact
    sample_places = _sample_places(ellipses, contact)
    density_at = _density_function(ellipses, contact)
    # W(x) there, and for which ellipses some W(x) is NaN
    samples_of_density, is_unknown = _sampled_density(
        sample_places, partial(density_at, node_stride=2)
    )
    # one for each sample above its neighbours, refined; then the largest of each ellipse, its peak
    local_maxima = _local_maxima(samples_of_density, density_at)
    peaks_of_ellipses = _largest_maximum(
        local_maxima, ellipses, sample_places, is_unknown, density_at
    )
    second_density, second_place = _second_maximum(
        local_maxima, samples_of_density.density, peaks_of_ellipses
    )
    # half-widths of permanent stick and of the largest contact
    stick_edge = sample_places[:, 0]
    largest_half_width = sample_places[:, -1]
    place_fraction = (peaks_of_ellipses.place - stick_edge) / np.where(
        largest_half_width > stick_edge, largest_half_width - stick_edge, 1.0
    )
    return np.stack(
        [
            peaks_of_ellipses.density,
            second_density,
            peaks_of_ellipses.error,
            peaks_of_ellipses.place,
            second_place,
            place_fraction,
        ]
    )


def _density_function(ellipses: Ellipses, contact: SymmetricContact) -> Callable[..., Array]:
    """The friction work per area W(x) pi E*/(2 f^2) of load ellipses as a function of (ellipse
    numbers, x, node_stride=1).

    It takes numbers of ellipses and places x, (k,) each, and gives W(x) of each pair, (k,), by
    every `node_stride`-th quadrature node. `contact` is the normal contact of all. E* is the
    composite modulus, f the friction.
    """

    def density_at(ellipse_numbers: Indices, x: Array, node_stride: int = 1) -> Array:
        """W(x) pi E*/(2 f^2) of the ellipses with these numbers (k,) at their places x (k,), by
        every `node_stride`-th quadrature node.
        """
        density_of_forward_slip, density_of_reverse_slip = work_density_of(
            ellipses.take(ellipse_numbers), contact, x, node_stride
        )
        return density_of_forward_slip + density_of_reverse_slip

    return density_at


class _LocalMaxima(NamedTuple):
    """Local maxima of W(x) of all ellipses, (n,) each.

    Attributes
    ----------
    ellipse_number
        of the ellipse
    sample_number
        of the sample of W that is above its neighbours
    vertex
        top of the parabola through three points (x, W) close about it
    """

    ellipse_number: Indices
    sample_number: Indices
    vertex: _Vertex

    def numbers_by_ascending_density(self) -> Indices:
        """Numbers of the maxima by ascending W."""
        return np.argsort(self.vertex.density, kind="stable")

    def largest_of_ellipses(self, n_ellipses: int) -> Indices:
        """Number of the largest maximum of each ellipse, -1 where there is none: (m,)."""
        maximum_numbers = self.numbers_by_ascending_density()
        largest_maximum = np.full(n_ellipses, -1)
        # the last one of an ellipse stays: its largest
        largest_maximum[self.ellipse_number[maximum_numbers]] = maximum_numbers
        return largest_maximum


def _local_maxima(samples: _Samples, density_at: Callable[..., Array]) -> _LocalMaxima:
    """Every local maximum over x of the friction work per area W(x) of each load ellipse, one for
    each sample of W above its neighbours.

    `samples` holds ellipse, place x and W(x), one ellipse after the other. A sample and its
    neighbours are a bracket. It is narrowed with every second quadrature node first, then with all.
    `density_at`(ellipse numbers, x, node_stride=1) gives W(x) pi E*/(2 f^2), with every
    `node_stride`-th quadrature node. E* is the composite modulus, f the friction.
    """
    # W(x)
    density_at_samples = samples.density
    is_local_maximum = (density_at_samples[1:-1] > density_at_samples[:-2]) & (
        density_at_samples[1:-1] >= density_at_samples[2:]
    )
    sample_numbers = np.flatnonzero(is_local_maximum) + 1
    ellipse_number = samples.ellipse_number[sample_numbers]
    # (3, n): each sample with its neighbours; _NEIGHBOUR_OFFSETS: -1, 0, 1
    samples_of_brackets = sample_numbers + _NEIGHBOUR_OFFSETS
    # (3, n) each, until W may rise by 1e-5 of itself, later by 1e-10
    bracket_places, _ = _narrowed_brackets(
        partial(density_at, node_stride=2),
        ellipse_number,
        samples.x[samples_of_brackets],
        density_at_samples[samples_of_brackets],
        _FIRST_RISE_TOLERANCE,
    )
    # With all nodes from here on.
    densities_of_brackets = np.stack(
        [density_at(ellipse_number, places) for places in bracket_places]
    )
    bracket_places, densities_of_brackets = _narrowed_brackets(
        density_at, ellipse_number, bracket_places, densities_of_brackets, _LAST_RISE_TOLERANCE
    )
    return _LocalMaxima(
        ellipse_number, sample_numbers, _vertex_of_parabola(bracket_places, densities_of_brackets)
    )


class _Peaks(NamedTuple):
    """Largest maximum of the friction work per area W(x) of each ellipse, (m,) each.

    Attributes
    ----------
    density, error
        W(x) pi E*/(2 f^2) there, and its error
    place
        |x| of the maximum
    maximum_number
        which of the local maxima of all ellipses it is, -1 for none
    """

    density: Array
    error: Array
    place: Array
    maximum_number: Indices


def _largest_maximum(
    local_maxima: _LocalMaxima,
    ellipses: Ellipses,
    sample_places: Array,
    is_unknown: NDArray[np.bool_],
    density_at: Callable[..., Array],
) -> _Peaks:
    """The largest maximum over x of the friction work per area W(x) of each load ellipse, with an
    upper bound of its error and its place |x|, (m,) each.

    W comes times pi E*/(2 f^2). It is 0 where nothing slips, NaN where it `is_unknown` (m,) at some
    sample. The error adds how far W may rise between the last three places about the maximum, the
    quadrature error and round-off. Where no maximum was found it is the largest W that may be lost
    in the last digits. E* is the composite modulus, f the friction.

    Parameters
    ----------
    sample_places
        (m, n) places x of the samples, from the half-width c of permanent stick to that of the
        largest contact
    density_at
        W(x) pi E*/(2 f^2) of (ellipse numbers, x, stride of the quadrature nodes)
    local_maxima
        local maxima of all ellipses, each the vertex of a parabola, which holds W, place and how
        far W may rise above it
    """
    n_ellipses = len(ellipses.mean_load)
    # of the largest maximum of each ellipse, -1 where there is none
    maximum_number_of_ellipse = local_maxima.largest_of_ellipses(n_ellipses)
    largest_density = np.where(is_unknown, np.nan, 0.0)
    error_of_density = np.where(
        is_unknown, np.nan, _largest_undetected_density(ellipses, sample_places)
    )
    place_of_maximum = np.full(n_ellipses, np.nan)

    slipping_ellipse_numbers = np.flatnonzero((maximum_number_of_ellipse >= 0) & ~is_unknown)
    maximum_number_of_slipping_ellipse = maximum_number_of_ellipse[slipping_ellipse_numbers]
    vertices = local_maxima.vertex
    largest_density[slipping_ellipse_numbers] = vertices.density[maximum_number_of_slipping_ellipse]
    place_of_maximum[slipping_ellipse_numbers] = vertices.place[maximum_number_of_slipping_ellipse]
    densities_by_stride = np.stack(
        [
            density_at(
                slipping_ellipse_numbers, place_of_maximum[slipping_ellipse_numbers], node_stride
            )
            for node_stride in (1, 2, 4)
        ]
    )
    # from W by all nodes, by every second and by every fourth
    relative_rule_error = quadrature_error(densities_by_stride, densities_by_stride[0])
    relative_error = relative_rule_error + _relative_roundoff(ellipses)[slipping_ellipse_numbers]
    error_of_density[slipping_ellipse_numbers] = (
        vertices.possible_rise[maximum_number_of_slipping_ellipse]
        + vertices.density[maximum_number_of_slipping_ellipse] * relative_error
    )
    return _Peaks(largest_density, error_of_density, place_of_maximum, maximum_number_of_ellipse)


def _relative_roundoff(ellipses: Ellipses) -> Array:
    """Relative round-off of the largest friction work per area W(x) of each load ellipse, (m,).

    It is 1e-12, and more where the load P - P_c carried by the slip zones is small beside the
    largest P = P0 + P1, mean plus amplitude. P_c is the load at the stick edge.
    `slip_zone_load_scale` is the largest P - P_c of an ellipse to a factor of two.
    """
    slip_zone_load = ellipses.slip_zone_load_scale
    # LAST_DIGITS: four round-offs
    share_of_last_digits = (
        LAST_DIGITS
        * (ellipses.mean_load + ellipses.load_amplitude)
        / np.where(slip_zone_load > 0, slip_zone_load, np.inf)
    )
    # PROMISED_ERROR: 1e-12
    return np.asarray(PROMISED_ERROR + 3 * share_of_last_digits)


def _largest_undetected_density(ellipses: Ellipses, places: Array) -> Array:
    """Upper bound of W(x) pi E*/(2 f^2) of each load ellipse, (m,), for those where no maximum of
    it was found: W(x), the friction work per area, may be lost in the last digits then.

    W(x) is at most the product of p, 2 (u + v) and arccosh(|x|/c), which is 2 (u + v) (P - P_c)/(pi
    a). The largest P - P_c is taken, and for a the half-width c of permanent stick where that is
    not 0. u and v are the amplitudes of (Q -+ f P)/f, P_c is the load at the stick edge. `places`
    (m, n) are places x from c to the half-width a of the largest contact. E* is the composite
    modulus.
    """
    stick_edge = places[:, 0]
    largest_half_width = places[:, -1]
    return np.asarray(
        2
        / math.pi
        * (ellipses.forward_amplitude + ellipses.reverse_amplitude)
        * ellipses.largest_slip_zone_load
        / np.where(stick_edge > 0, stick_edge, largest_half_width)
    )


def _second_maximum(
    local_maxima: _LocalMaxima, sampled_density: Array, peaks: _Peaks
) -> tuple[Array, Array]:
    """Second largest maximum over x of the friction work per area W(x), times pi E*/(2 f^2), of
    each load ellipse, and its |x|, (m,) each. NaN where there is one maximum only.

    A maximum counts as another one if W falls enough between it and the largest: by more than 1e-3
    of the largest W, and by more than twice its error. E* is the composite modulus, f the friction.

    Parameters
    ----------
    local_maxima
        all of them: numbers of ellipse and sample, and the vertex of a parabola, with W and place
    sampled_density
        W(x) at all samples of all ellipses, one ellipse after the other
    peaks
        of each ellipse the largest W, its error, and which of the local maxima it is
    """
    n_ellipses = len(peaks.density)
    second_density = np.full(n_ellipses, np.nan)
    second_place = np.full(n_ellipses, np.nan)
    if not len(local_maxima.sample_number):
        return second_density, second_place
    # From the sample of each maximum to that of the largest of its ellipse.
    sample_number_of_largest_maximum = local_maxima.sample_number[
        peaks.maximum_number[local_maxima.ellipse_number]
    ]
    sample_ranges = np.sort(
        np.stack([local_maxima.sample_number, sample_number_of_largest_maximum]), axis=0
    )
    # Every other minimum of `reduceat` is that between two ranges: it is left out.
    least_density_in_range = np.minimum.reduceat(sampled_density, sample_ranges.T.ravel())[::2]
    # _LEAST_FALL_SHARE: 1e-3
    least_fall = np.maximum(_LEAST_FALL_SHARE * peaks.density, 2 * peaks.error)
    # By ascending W: the last maximum of an ellipse overwrites those before.
    maximum_numbers = local_maxima.numbers_by_ascending_density()
    ellipse_number_of_maximum = local_maxima.ellipse_number[maximum_numbers]
    density_of_maximum = local_maxima.vertex.density[maximum_numbers]
    is_not_largest = maximum_numbers != peaks.maximum_number[ellipse_number_of_maximum]
    is_distinct = (
        least_density_in_range[maximum_numbers]
        < density_of_maximum - least_fall[ellipse_number_of_maximum]
    )
    second_maximum_numbers = maximum_numbers[is_not_largest & is_distinct]
    second_density[local_maxima.ellipse_number[second_maximum_numbers]] = (
        local_maxima.vertex.density[second_maximum_numbers]
    )
    second_place[local_maxima.ellipse_number[second_maximum_numbers]] = local_maxima.vertex.place[
        second_maximum_numbers
    ]
    return second_density, second_place


class _Samples(NamedTuple):
    """Samples of the friction work per area W(x), (n,) each. Places ascend within an ellipse, one
    ellipse comes after the other.

    Attributes
    ----------
    ellipse_number
        of the ellipse
    x
        place |x| of the sample
    density
        W(x) pi E*/(2 f^2) there
    """

    ellipse_number: Indices
    x: Array
    density: Array

    def joined_with(self, further_samples: _Samples) -> _Samples:
        """These samples and further ones, ascending within an ellipse, one ellipse after the
        other.
        """
        ellipse_number = np.concatenate([self.ellipse_number, further_samples.ellipse_number])
        x = np.concatenate([self.x, further_samples.x])
        density = np.concatenate([self.density, further_samples.density])
        order_by_ellipse = np.lexsort((x, ellipse_number))
        return _Samples(
            ellipse_number[order_by_ellipse], x[order_by_ellipse], density[order_by_ellipse]
        )


def _sampled_density(
    places: Array, density_at: Callable[[Indices, Array], Array]
) -> tuple[_Samples, NDArray[np.bool_]]:
    """Samples of the friction work per area W(x) of each load ellipse at its `places` (m, n), and
    at more places where W is nearly level. Second: for which ellipses W is NaN at some place, (m,).

    Of equal places one counts. At both ends of the slip zone W is set to 0. `density_at`(ellipse
    numbers, x) gives W(x) pi E*/(2 f^2). E* is the composite modulus, f the friction.
    """
    slip_zone_widths = places[:, -1] - places[:, 0]
    # _SAME_POINT_WIDTH_SHARE: 1e-10
    is_distinct = (
        np.diff(places, axis=1, prepend=-np.inf)
        > _SAME_POINT_WIDTH_SHARE * slip_zone_widths[:, None]
    )
    ellipse_number_of_sample = np.nonzero(is_distinct)[0]
    sample_places = places[is_distinct]
    density_at_samples = density_at(ellipse_number_of_sample, sample_places)
    is_unknown = (
        np.bincount(ellipse_number_of_sample, np.isnan(density_at_samples), len(places)) > 0
    )
    # Nothing is dissipated at the ends of the slip zone: no maximum is there, and ellipses next to
    # each other stay apart.
    first_sample_number = np.flatnonzero(np.diff(ellipse_number_of_sample, prepend=-1))
    last_sample_number = np.append(first_sample_number[1:], len(sample_places)) - 1
    density_at_samples[first_sample_number] = 0.0
    density_at_samples[last_sample_number] = 0.0
    samples = _Samples(ellipse_number_of_sample, sample_places, density_at_samples)

    # Samples are put closer where W is nearly level, lest one of two maxima next to each other is
    # missed: at a quarter, a half and three quarters of each level interval.
    level_interval_numbers = _level_interval_numbers(samples, slip_zone_widths)
    added_places = (
        sample_places[level_interval_numbers]
        + np.diff(sample_places)[level_interval_numbers] * _QUARTER_FRACTIONS[:, None]
    ).ravel()
    ellipse_number_of_added_sample = np.tile(
        ellipse_number_of_sample[level_interval_numbers], len(_QUARTER_FRACTIONS)
    )
    added_samples = _Samples(
        ellipse_number_of_added_sample,
        added_places,
        density_at(ellipse_number_of_added_sample, added_places),
    )
    return samples.joined_with(added_samples), is_unknown


def _level_interval_numbers(samples: _Samples, slip_zone_widths: Array) -> Indices:
    """Numbers (k,) of the intervals between neighbouring samples of W(x) that are wide, and over
    which W(x), the friction work per area, is nearly level without being negligible.

    Nearly level and negligible: a change, or a size, of less than 0.01 of the largest W of the
    ellipse. Wide: more than 0.01 of its slip zone, whose width is in `slip_zone_widths` (m,). An
    interval has the number of the sample at its left. An ellipse has W = 0 at its first and its
    last sample.
    """
    ellipse_number_of_interval = samples.ellipse_number[:-1]
    first_sample_number = np.flatnonzero(np.diff(samples.ellipse_number, prepend=-1))
    largest_densities = np.maximum.reduceat(samples.density, first_sample_number)
    # _NEARLY_LEVEL_FRACTION: 0.01
    negligible_density = (_NEARLY_LEVEL_FRACTION * largest_densities)[ellipse_number_of_interval]
    is_above_negligible_density = (samples.density[:-1] > negligible_density) & (
        samples.density[1:] > negligible_density
    )
    is_level_interval = (
        np.abs(np.diff(samples.density)) < negligible_density
    ) & is_above_negligible_density
    is_wide_interval = (
        np.diff(samples.x) > _NEARLY_LEVEL_FRACTION * slip_zone_widths[ellipse_number_of_interval]
    )
    return np.flatnonzero(is_level_interval & is_wide_interval)


def _sample_places(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """Places |x| at which the friction work per area W(x) of each load ellipse is sampled, (m, n).
    They ascend from the permanent stick edge to the largest contact; some of them are equal.

    They lie at the half-widths at which the formula of W(x) changes, and between these. More lie
    next to the kinks of W(x), which are at the half-width of the least load and at corners of the
    profile. A profile of more than eight corners gets only the middle of each interval, and no
    places next to corners. `contact` gives the half-width of a load, and the loads at which its
    edge is at a corner. The permanent stick edge is the half-width under `permanent_stick_load`.
    """
    permanent_stick_load = ellipses.permanent_stick_load
    largest_load = ellipses.mean_load + ellipses.load_amplitude
    loads = _loads_at_formula_changes(ellipses, contact)
    # (loads, m) ascending
    half_widths = contact.half_width(np.sort(loads, axis=0))
    least_load = np.clip(
        ellipses.mean_load - ellipses.load_amplitude, permanent_stick_load, largest_load
    )
    kink_loads = least_load[None]
    # the middle one of five, which are closer together at both ends
    fractions = _FRACTIONS_OF_INTERVAL[_MIDDLE_FRACTION]
    if len(contact.corner_loads) <= _FEW_CORNERS:
        clipped_corner_loads = np.clip(
            contact.corner_loads[:, None], permanent_stick_load, largest_load
        )
        kink_loads = np.concatenate([kink_loads, clipped_corner_loads])
        fractions = _FRACTIONS_OF_INTERVAL
    places_between_half_widths = (
        half_widths[:-1] + np.diff(half_widths, axis=0) * fractions[:, None, None]
    )
    places_beside_kinks = _places_beside_kinks(
        contact.half_width(kink_loads), half_widths[0], half_widths[-1]
    )
    further_places = [
        places_of_ellipses.reshape(-1, len(largest_load))
        for places_of_ellipses in (places_between_half_widths, *places_beside_kinks)
    ]
    return np.sort(np.concatenate([half_widths, *further_places]), axis=0).T


def _loads_at_formula_changes(ellipses: Ellipses, contact: SymmetricContact) -> Array:
    """Loads at whose half-widths the formula of the friction work per area W(x) changes, for each
    of m load ellipses, (n, m).

    They are those at which slip begins or ends, the least load, and those under which the contact
    reaches a corner of the profile. Loads are moved into the range from permanent stick to the
    largest one.

    P = P0 + P1 cos t. Reverse slip goes from E to G, forward slip from I to E. J is where the stick
    edge passes its place at G again. `slip_start` is t at E, `slip_angle` the angle from E to G.
    """
    least_load = ellipses.mean_load - ellipses.load_amplitude
    largest_load = ellipses.mean_load + ellipses.load_amplitude
    # cos t at E, G, I and J
    event_cosines = (
        ellipses.cosine_of_start,
        np.cos(ellipses.slip_start + ellipses.slip_angle),
        -ellipses.cosine_of_start,
        np.cos(ellipses.slip_start - ellipses.slip_angle),
    )
    event_loads = [ellipses.load_at_cosine(cosine) for cosine in event_cosines]
    clipped_corner_loads = np.clip(
        contact.corner_loads[:, None], ellipses.permanent_stick_load, largest_load
    )
    loads = np.stack(
        [
            ellipses.permanent_stick_load,
            least_load,
            *event_loads,
            *clipped_corner_loads,
            largest_load,
        ]
    )
    return np.clip(loads, ellipses.permanent_stick_load, largest_load)


def _places_beside_kinks(
    kink_half_widths: Array, stick_edge: Array, largest_half_width: Array
) -> tuple[Array, Array]:
    """Places inside and outside each kink of the friction work per area W(x), in four distances
    from it. (4, k, m) each, for k kinks of each of m load ellipses.

    The distances are fractions of the smaller part of the slip zone, from 0.03 to 0.00003 of it.
    The kinks are at `kink_half_widths` (k, m), in the slip zone from the edge of permanent stick to
    that of the largest contact, (m,) each.
    """
    distance_to_kink = (
        np.minimum(kink_half_widths - stick_edge, largest_half_width - kink_half_widths)
        * _DISTANCES_TO_KINK[:, None, None]
    )
    return kink_half_widths - distance_to_kink, kink_half_widths + distance_to_kink


def _narrowed_brackets(
    density_at: Callable[[Indices, Array], Array],
    ellipse_number: Indices,
    bracket_places: Array,
    bracket_densities: Array,
    rise_tolerance: float,
) -> tuple[Array, Array]:
    """Brackets of three places about each of n maxima of the friction work per area W(x): the
    places, and W there, (3, n) each. They are narrowed until W may rise by the fraction
    `rise_tolerance` of itself at most.

    In each of at most 40 rounds three new places are tried, about the vertex of the parabola
    through the bracket. Where the last round did not halve the bracket they divide it evenly, at
    0.21, 0.47 and 0.73.

    Parameters
    ----------
    density_at
        W(x) of ellipses of these numbers (n,) at places (n,)
    ellipse_number
        (n,) number of the ellipse whose maximum it is
    bracket_places, bracket_densities
        (3, n) places, ascending, and W(x) there, to begin with
    """
    bracket_places = bracket_places.copy()
    bracket_densities = bracket_densities.copy()
    wide_bracket_numbers = np.arange(len(ellipse_number))
    narrows_slowly = np.zeros(len(ellipse_number), dtype=bool)
    for _ in range(_MOST_ROUNDS):
        # of the parabola, with a bound of the rise of W above the middle point
        parabola_vertex = _vertex_of_parabola(
            bracket_places[:, wide_bracket_numbers], bracket_densities[:, wide_bracket_numbers]
        )
        is_wide_bracket = parabola_vertex.possible_rise > rise_tolerance * np.abs(
            bracket_densities[1, wide_bracket_numbers]
        )
        wide_bracket_numbers = wide_bracket_numbers[is_wide_bracket]
        if not len(wide_bracket_numbers):
            break
        former_places = bracket_places[:, wide_bracket_numbers]
        former_width = former_places[2] - former_places[0]
        # (3, n): at the vertex and on each side of it
        places_by_parabola = _next_trial_places(
            former_places, parabola_vertex.place[is_wide_bracket]
        )
        even_places = former_places[0] + former_width * _EVEN_BRACKET_FRACTIONS[:, None]
        new_places = np.where(narrows_slowly[wide_bracket_numbers], even_places, places_by_parabola)
        new_densities = [
            density_at(ellipse_number[wide_bracket_numbers], places) for places in new_places
        ]
        # of the six places those about the highest W
        new_bracket, densities_of_new_bracket = _bracket_about_highest(
            np.concatenate([former_places, new_places]),
            np.concatenate([bracket_densities[:, wide_bracket_numbers], new_densities]),
        )
        bracket_places[:, wide_bracket_numbers] = new_bracket
        bracket_densities[:, wide_bracket_numbers] = densities_of_new_bracket
        bracket_width = new_bracket[2] - new_bracket[0]
        narrows_slowly[wide_bracket_numbers] = bracket_width > former_width / 2
    return bracket_places, bracket_densities


def _bracket_about_highest(places: Array, densities: Array) -> tuple[Array, Array]:
    """The place of the highest of six values of the friction work per area W(x), with its
    neighbours, and W(x) there, (3, n) each, for each of n maxima; places ascending.

    `places` and `densities`, W(x) there, (6, n) are in any order. The middle place of a bracket has
    a neighbour on each side: the outermost of the six are never in the middle.
    """
    order_by_place = np.argsort(places, axis=0, kind="stable")
    ascending_places = np.take_along_axis(places, order_by_place, 0)
    densities_in_order = np.take_along_axis(densities, order_by_place, 0)
    row_number_of_highest_density = np.clip(
        np.argmax(densities_in_order, axis=0), 1, len(densities) - 2
    )
    row_numbers_of_bracket = row_number_of_highest_density + _NEIGHBOUR_OFFSETS
    return (
        np.take_along_axis(ascending_places, row_numbers_of_bracket, 0),
        np.take_along_axis(densities_in_order, row_numbers_of_bracket, 0),
    )


def _next_trial_places(bracket_places: Array, vertex_place: Array) -> Array:
    """Three places (3, n) at which the friction work per area W(x) is evaluated next in the search
    for a maximum. One is at `vertex_place` (n,), the vertex of a parabola, and one on each side of
    it.

    `bracket_places` (3, n) are the places about each maximum so far, ascending. The new ones keep
    away from its ends and from its middle place, where W is known.
    """
    left_end, middle_place, right_end = bracket_places
    bracket_width = right_end - left_end
    inner_vertex = np.clip(
        vertex_place, left_end + 0.02 * bracket_width, right_end - 0.02 * bracket_width
    )
    # The error of the vertex is taken as its distance from the middle place; twice that should hold
    # the maximum. An eighth of the width at most takes the bracket to a fourth.
    distance_beside_vertex = np.clip(
        2 * np.abs(inner_vertex - middle_place), 0.003 * bracket_width, 0.125 * bracket_width
    )
    is_vertex_at_middle = np.abs(inner_vertex - middle_place) < 0.1 * distance_beside_vertex
    centre_place = np.where(is_vertex_at_middle, middle_place, inner_vertex)
    left_place = np.maximum(centre_place - distance_beside_vertex, (left_end + centre_place) / 2)
    right_place = np.minimum(centre_place + distance_beside_vertex, (centre_place + right_end) / 2)
    # A vertex that is all but the middle place needs no W of its own: the third place goes beyond.
    vertex_or_outer_place = np.where(
        is_vertex_at_middle, (right_place + right_end) / 2, inner_vertex
    )
    return np.stack([left_place, vertex_or_outer_place, right_place])


class _Vertex(NamedTuple):
    """The vertex of the parabola through three points (x, W), (n,) each; the middle point where the
    parabola bends up.

    Attributes
    ----------
    density, place
        W and x of the vertex
    possible_rise
        how far a concave W may rise above the middle point
    """

    density: Array
    place: Array
    possible_rise: Array


def _vertex_of_parabola(places: Array, densities: Array) -> _Vertex:
    """Vertex of the parabola through three points (x, W(x)) about each of n maxima, and the most
    that W can rise above the middle point. x, ascending, and W(x), the friction work per area, are
    (3, n) each.

    The bound holds for a concave W: it stays below the chords of the points, extended. Where the
    parabola is convex the middle point replaces its vertex.
    """
    distances_of_places = np.diff(places, axis=0)
    first_distance, second_distance = distances_of_places
    first_slope, second_slope = np.diff(densities, axis=0) / np.where(
        distances_of_places > 0, distances_of_places, np.inf
    )
    total_distance = np.where(
        first_distance + second_distance > 0, first_distance + second_distance, np.inf
    )
    half_second_derivative = (second_slope - first_slope) / total_distance
    slope_at_middle = (
        first_slope * second_distance + second_slope * first_distance
    ) / total_distance
    is_concave = half_second_derivative < 0
    distance_to_vertex = np.where(
        is_concave, slope_at_middle / np.where(is_concave, -2 * half_second_derivative, 1.0), 0.0
    )
    return _Vertex(
        density=densities[1] + slope_at_middle * distance_to_vertex / 2,
        place=places[1] + distance_to_vertex,
        possible_rise=np.maximum(
            np.abs(first_slope) * second_distance, np.abs(second_slope) * first_distance
        ),
    )


_LOAD_NAMES = (
    "mean_normal_load",
    "normal_amplitude",
    "mean_tangential_load",
    "tangential_amplitude",
    "phase_radians",
    "friction_coefficient",
)
_MEMBERS_AT_ONCE = 16384
# Fractions of P0 that P - P_c must reach for the quick way to the kernel Lam of W, see
# `steady_ellipse`. There it loses 6e-11 of W by formulas, 1e-12 by the table.
_DEEP_SLIP_LOAD_SHARE = 0.02
_DEEP_SLIP_LOAD_SHARE_ON_TABLE = 0.04
_LEAST_PARAMETER = 1 / LARGEST_NUMBER
_BODY_OF_UNIT_MODULUS = Elastic(young_modulus=2.0, poisson_ratio=0.0)  # against itself E* = 1


class Reason(IntEnum):
    """Why a member of a batch has no value."""

    NONE = 0
    SLIDING = 1
    SEPARATION = 2
    INVALID = 3
    EXTENT = 4
    UNSETTLED = 5
    BODIES = 6


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
        P_T, the normal load whose contact is the permanent stick zone [force per thickness]
    reason
        `Reason` of each member: 0 none, 1 gross sliding, 2 separation, 3 a value that is
        masked, NaN or not admitted (P0 > 0, the rest of the loads >= 0, parameters by the rules
        of the profile; all of them, and P0 over E* and the height unit of the profile, which is
        b^2/R of a flat face, at most 1e100 and where they are scales at least 1e-100), 4 the
        profile ends before the contact does, 5 the quadrature did not converge, 6 the contact of
        the finite bodies, `effects`, would be more than twice as wide as that of half-planes, be
        wider than the profile, or split
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
        place of the peak between the permanent stick edge (0) and the largest contact (1)
    reason, notes
        code of `Reason`, why a member has no value; what holds for all members
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
    """Friction work of one steady cycle [energy per unit thickness] of the loads P = P0 + P1 cos t,
    Q = Q0 + Q1 cos(t - phase), for arrays of loads, profiles and friction; all broadcast.

    Parameters
    ----------
    profile
        any profile, or its keys with numbers or arrays: {"kind": "flat_rounded", "radius": ...,
        "flat_half_length": ...}; the rises of a polynomial are a list of numbers or arrays. A
        profile by a table of heights or by a function has no keys that could be arrays
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
        whose contact is the permanent stick zone. A member whose contact would split, leave the
        profile or be more than twice as wide as on half-planes gets NaN and reason 6

    Returns
    -------
    DissipationBatch
        A member that is inadmissible gets NaN and a reason; the others get their values. Each is
        exact to 1e-11 of (2/E*) f^2 P0^2 or 1e-10 relative, and to `value_error`, from slips of
        1e-9 to gross sliding itself. Q0 decides on gross sliding only. No member depends on the
        others: within its `value_error` it is what a batch of it alone gives. Hertz and power laws
        take some 0.6 us a member, flat and rounded 1.5 us. The other profiles are integrated
        between their corners, with one table of ln a(P), a the contact half-width, for all loads
        within eight octaves: 8 to 14 us, 20 us for profiles of 31 heights. They take 1 ms and more
        where the load of the slip zones stays below 1e-6 of P0. Where the parameters are arrays
        each different polynomial, or ratio R2/R1 of the radii of a compound curvature, costs 1.5 to
        2 ms.

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
    # P0, P1, Q0, Q1, phase [rad] and f
    loads = EllipseLoads(
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase_in_radians(phase_degrees, phase_radians),
        friction_coefficient,
    )
    # of both bodies
    material = _materials_of_both_bodies(material)
    effects = checked_effects(effects)
    # the function that computes five rows of m members: work, its forward and reverse part, its
    # error, and the permanent stick load
    works_of_members = _works_of_members
    reason_if_not_finite = Reason.UNSETTLED
    notes = list(neglected_coupling(material))
    if effects is not None:
        reason_if_not_finite = Reason.BODIES
        works_of_members = partial(_works_with_effects, curvatures_of(effects))
        notes.extend(notes_of_batch(effects))
    # the first four come times pi E*/(2 f^2)
    rows_of_results, reason_codes = _results_of_members(
        profile,
        material,
        loads,
        _ResultFunction(
            works_of_members,
            n_results=5,
            n_normalised=4,
            reason_if_not_finite=reason_if_not_finite,
        ),
    )
    work, forward_work, reverse_work, work_error, permanent_stick_load = rows_of_results
    return DissipationBatch(
        value=work,
        forward=forward_work,
        reverse=reverse_work,
        permanent_stick_load=permanent_stick_load,
        reason=reason_codes,
        value_error=work_error,
        notes=tuple(notes),
    )


def _works_of_members(members: Members) -> Array:
    """Friction work of one steady cycle of each member of a batch, times pi E*/(2 f^2) [(force per
    thickness)^2], and its permanent stick load P_T [force per thickness]: (5, m).

    The rows are:

    1. the work;
    2. its part by forward slip;
    3. its part by reverse slip;
    4. an upper bound of the error of the work;
    5. P_T.

    The kernel of the work is Lam, the integral of ln(a/a(P_c)) over loads from P_c, that at the
    stick edge, to P; a is the contact half-width. Lam has a closed form for Hertz and power laws, a
    table for flat and rounded faces. Other profiles take a quadrature, with one contact for all
    members whose profiles have one shape, in units of length and load. `members` holds the load
    ellipses, mirrored to Q -> -Q where they go round the other way. It also holds the kind of
    profile and its parameters; of a power law the exponent comes first. E* is the composite
    modulus, f the friction.
    """
    ellipses = members.ellipses
    kind = members.kind
    # rows: work in forward slip, in reverse slip, and the error of their sum
    works_and_error = np.empty((3, len(members.is_mirrored)))
    # _DEEP_SLIP_LOAD_SHARE: 0.02. Lam is taken by its quick formula where the largest P - P_c is
    # above this share of the mean load, and each amplitude of (Q -+ f P)/f above it of the other.
    if kind in ("hertz", "power_law"):
        works_and_error[:2] = works_by_lam(
            ellipses, quick_power_law_kernel, careful_power_law_kernel, _DEEP_SLIP_LOAD_SHARE
        )
        # 1.0: size of ln a
        works_and_error[2] = error_of_works_by_lam(
            ellipses, works_and_error[0] + works_and_error[1], _DEEP_SLIP_LOAD_SHARE, 1.0
        )
        # The kernels are those of ln P. Lam of a profile |x|^n is 1/n of that: a goes as P^(1/n).
        exponent = members.parameters[0] if kind == "power_law" else 2
        works_and_error /= exponent
    elif kind == "flat_rounded":
        # `_UNITS_AND_RATIOS`: units of length and of height, b^2/R of the half-length b of the flat
        # and the radius R of its rounded ends
        _, height_unit, *_ = _UNITS_AND_RATIOS[kind](*members.parameters)
        works_and_error[:] = _works_on_table(ellipses, members.modulus * height_unit)
    else:
        for group in members.shape_groups():
            # forward, reverse and error in units of the shape
            works_in_units = dissipation_and_error(group.ellipses, group.contact)
            works_and_error[:, group.member_numbers] = (
                works_in_units * group.load_unit * group.load_unit
            )
    forward_work_of_ellipses, reverse_work_of_ellipses, work_error = works_and_error
    # A mirrored ellipse has Q -> -Q: its forward slip is the reverse slip of the member.
    forward_work = np.where(members.is_mirrored, reverse_work_of_ellipses, forward_work_of_ellipses)
    reverse_work = np.where(members.is_mirrored, forward_work_of_ellipses, reverse_work_of_ellipses)
    return np.stack(
        [
            forward_work_of_ellipses + reverse_work_of_ellipses,
            forward_work,
            reverse_work,
            work_error,
            ellipses.permanent_stick_load,
        ]
    )


def _works_with_effects(curvatures_per_load: Curvatures, members: Members) -> Array:
    """Friction work of one steady cycle of each member of a batch on finite bodies, whose loads add
    `curvatures_per_load` to gap and faces, (5, m).

    The rows are the work, its parts by forward and by reverse slip, the error of the work, and the
    permanent stick load. The first four come times pi E*/(2 f^2).

    The work is that on half-planes, exact, plus the change by the curvatures. One quadrature rule
    gives the works with and without curvatures, so that its error nearly cancels in the change. A
    curvature is a second derivative of the gap, or of the displacement of the faces, per unit of
    load [1/(stress length^2)]. Members are taken in groups whose profiles have one shape. E* is the
    composite modulus, f the friction.
    """
    # on half-planes
    rows_of_results = _works_of_members(members)
    # views: they are changed below
    work, forward_work, reverse_work, work_error, permanent_stick_load = rows_of_results
    for group in members.shape_groups():
        member_numbers = group.member_numbers
        change_by_curvatures = _change_by_curvatures(curvatures_per_load, members, group)
        # what the rule misses of the exact work on half-planes; four times that is allowed for the
        # change
        rule_error = np.abs(change_by_curvatures.half_plane_work - work[member_numbers])
        work[member_numbers] += (
            change_by_curvatures.forward_work + change_by_curvatures.reverse_work
        )
        forward_work[member_numbers] += change_by_curvatures.forward_work
        reverse_work[member_numbers] += change_by_curvatures.reverse_work
        work_error[member_numbers] += _FACTOR_ON_RULE_ERROR * rule_error
        # this load is that of the bodies, not a change
        permanent_stick_load[member_numbers] = change_by_curvatures.permanent_stick_load
    return rows_of_results


class _ChangeOfWorks(NamedTuple):
    """What curvatures that the loads give to gap and faces change for k load ellipses, (k,) each.
    Works are times pi E*/(2 f^2) [(force per thickness)^2], by one quadrature rule over the
    punches.

    Attributes
    ----------
    forward_work, reverse_work
        change of the work of forward and of reverse slip
    half_plane_work
        work without curvatures by the same rule
    permanent_stick_load
        normal load whose contact is as wide as the permanent stick zone, with curvatures
    """

    forward_work: Array
    reverse_work: Array
    half_plane_work: Array
    permanent_stick_load: Array


def _change_by_curvatures(
    curvatures_per_load: Curvatures, members: Members, group: ShapeGroup
) -> _ChangeOfWorks:
    """Change of the friction work by curvatures, for a group of members whose profiles have one
    shape and one contact, in units of length and load. With it the work on half-planes and the
    permanent stick load on the bodies.

    `members` holds the loads of all members as given, E* as `modulus`, and a contact for all, or
    None where profiles vary; `group` holds the numbers of its members. A curvature is a second
    derivative of the gap, or of the displacement of the faces, per unit of load [1/(stress
    length^2)].
    """
    # columns (k, 1), also where one unit serves all
    column_of_ones = np.ones((len(group.member_numbers), 1))
    squared_length_units = np.reshape(np.square(group.length_unit), (-1, 1)) * column_of_ones
    scaled_loads = _loads_in_units(members, group)
    # Of profiles that vary the contact has E* = 1 in its own units, of one profile its own E*.
    contact_modulus = members.modulus if members.contact is not None else 1.0
    columns_of_curvatures = CurvatureColumns.from_curvatures(
        curvatures_per_load, members.modulus / contact_modulus * squared_length_units
    )
    columns_of_no_curvatures = CurvatureColumns.from_curvatures(Curvatures(), column_of_ones)
    # forward and reverse work of each ellipse, and half-width of permanent stick
    works_of_half_planes = works_of_ellipses(
        scaled_loads, columns_of_no_curvatures, group.contact, contact_modulus
    )
    works_of_bodies = works_of_ellipses(
        scaled_loads, columns_of_curvatures, group.contact, contact_modulus
    )
    # Works of ellipses are times pi E*/2, without 1/f^2.
    work_unit = np.square(group.load_unit / members.loads.friction[group.member_numbers])
    return _ChangeOfWorks(
        forward_work=work_unit * (works_of_bodies.forward_work - works_of_half_planes.forward_work),
        reverse_work=work_unit * (works_of_bodies.reverse_work - works_of_half_planes.reverse_work),
        half_plane_work=work_unit
        * (works_of_half_planes.forward_work + works_of_half_planes.reverse_work),
        permanent_stick_load=group.load_unit
        * group.contact.load(works_of_bodies.permanent_stick_half_width),
    )


def _loads_in_units(members: Members, group: ShapeGroup) -> EllipseOfLoads:
    """Loads of the members of a group in the unit of load of each, as columns (k, 1): mean and
    amplitude of P and of Q, with phase and coefficient of friction.

    `members` has the loads of all members as given, the group the numbers of its own.
    """
    loads_of_group = LoadArrays(
        *(load_array[group.member_numbers, None] for load_array in members.loads)
    )
    load_units = np.reshape(group.load_unit, (-1, 1)) * np.ones((len(group.member_numbers), 1))
    return EllipseOfLoads(
        mean_normal=loads_of_group.mean_normal,
        normal_amplitude=loads_of_group.normal_amplitude,
        mean_tangential=loads_of_group.mean_tangential,
        tangential_amplitude=loads_of_group.tangential_amplitude,
        phase=loads_of_group.phase,
        friction=loads_of_group.friction,
    ).divided_by(load_units)


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
    """Largest friction work per area W(x) [energy per area] in one steady cycle, and where it is,
    for arrays of loads, profiles and friction.

    Loads are P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase).

    W(x) may have two maxima: the shoulder, just inside the contact half-width a(P_min) of the least
    load, and one further out. W(x) is searched between its kinks, which are at a(P_min) and at the
    corners of the profile. The value is good to some 1e-10 of itself, or to its `value_error` where
    slip is tiny. A member takes 3 ms for Hertz, 10 to 15 ms for power laws, flat and rounded. It
    takes 20 ms for polynomials, wedges and compound curvatures, 0.1 s for profiles of 31 heights. A
    member without a value has NaN and a reason.

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
    # P0, P1, Q0, Q1, phase [rad] and f
    loads = EllipseLoads(
        mean_normal_load,
        normal_amplitude,
        mean_tangential_load,
        tangential_amplitude,
        phase_in_radians(phase_degrees, phase_radians),
        friction_coefficient,
    )
    # of both bodies
    material = _materials_of_both_bodies(material)
    # six rows; the first three, W(x), come times pi E*/(2 f^2)
    rows_of_results, reason_codes = _results_of_members(
        profile, material, loads, _ResultFunction(_maxima_of_members, n_results=6, n_normalised=3)
    )
    largest_density, second_density, density_error, place, second_place, place_fraction = (
        rows_of_results
    )
    return PeakBatch(
        value=largest_density,
        place=place,
        fraction=place_fraction,
        reason=reason_codes,
        second_value=second_density,
        second_place=second_place,
        value_error=density_error,
        notes=tuple(neglected_coupling(material)),
    )


def _maxima_of_members(members: Members) -> Array:
    """The two largest maxima over x of the friction work per area W(x) of each member of a batch,
    (6, m), in units of the scene. The rows are those of `maxima_of`.

    Groups by the shape of the profile have one contact each, in units of length and load.
    """
    maxima = np.empty((6, len(members.is_mirrored)))
    for group in members.shape_groups():
        maxima_in_units = maxima_of(group.ellipses, group.contact)
        # W(x) pi E*/(2 f^2) has the unit load^2/length, both |x| that of length.
        maxima_in_units[:3] *= group.load_unit / group.length_unit * group.load_unit
        maxima_in_units[3:5] *= group.length_unit
        maxima[:, group.member_numbers] = maxima_in_units
    return maxima


def _works_on_table(ellipses: Ellipses, load_unit: Array) -> Array:
    """Friction work of forward and of reverse slip times pi E*/(2 f^2) [(force per thickness)^2],
    and the error of their sum, (3, m). They are those of steady load ellipses on flat and rounded
    faces.

    The kernel of the work, the integral of ln(a/a(P_c)) over the loads from P_c, that at the stick
    edge, to P, is read from tables. They hold loads divided by `load_unit` = E* b^2/R (m,): so one
    table serves all such faces. b is the half-length of the flat, R the radius of its rounded ends.
    The table has a quick and a careful kernel, and its largest ln a. a is the contact half-width.
    E* is the composite modulus, f the friction.
    """
    scaled_ellipses = ellipses.divided_by(load_unit)
    works_and_error = np.empty((3, len(load_unit)))
    # loads of a group lie between two powers of two, these octaves
    for ellipse_numbers, first_octave, last_octave in groups_by_largest_load(scaled_ellipses):
        table = _kernel_table(first_octave, last_octave)
        ellipses_of_table = scaled_ellipses.take(ellipse_numbers)
        quick_kernel = table.quick_kernel  # to round-off of P - P_c
        careful_kernel = table.careful_kernel  # to round-off of itself
        largest_log_half_width = table.largest_log_half_width
        forward_work, reverse_work = works_by_lam(
            ellipses_of_table,
            quick_kernel,
            careful_kernel,
            _DEEP_SLIP_LOAD_SHARE_ON_TABLE,
            LEAST_LOAD_SHARE,
        )
        works_and_error[0, ellipse_numbers] = forward_work
        works_and_error[1, ellipse_numbers] = reverse_work
        # _DEEP_SLIP_LOAD_SHARE_ON_TABLE: 0.04 of the mean load; LEAST_LOAD_SHARE: 2^-48 of it
        works_and_error[2, ellipse_numbers] = error_of_works_by_lam(
            ellipses_of_table,
            forward_work + reverse_work,
            _DEEP_SLIP_LOAD_SHARE_ON_TABLE,
            largest_log_half_width,
        )
    return works_and_error * load_unit * load_unit


@lru_cache(maxsize=32)
def _kernel_table(first_octave: int, last_octave: int) -> LamTable:
    """Table of the kernel Lam of the friction work on a flat and rounded face. Loads are over E*
    b^2/R, from 2^first_octave to 2^(last_octave + 1). Lam is the integral of ln(a/a(P_c)) over the
    loads from P_c to P; P_c is the load at the stick edge.
    """
    return LamTable(_contact_in_own_units("flat_rounded", ()), first_octave, last_octave)


# ------------------------------------------------------------------------ members and their reasons
class EllipseLoads(NamedTuple):
    """Loads of a batch and its friction as a caller gives them, numbers or arrays of any shapes
    that broadcast: P0, P1, Q0, Q1, phase [rad], f.
    """

    mean_normal: ArrayLike
    normal_amplitude: ArrayLike
    mean_tangential: ArrayLike
    tangential_amplitude: ArrayLike
    phase: ArrayLike
    friction: ArrayLike


class LoadArrays(NamedTuple):
    """Loads of a batch and its friction as arrays (m,): P0, P1, Q0, Q1, phase [rad], f."""

    mean_normal: Array
    normal_amplitude: Array
    mean_tangential: Array
    tangential_amplitude: Array
    phase: Array
    friction: Array


class ShapeGroup(NamedTuple):
    """Members of a batch whose profiles differ by units of length and load only.

    Attributes
    ----------
    member_numbers
        (k,) their numbers in the batch
    contact
        normal contact in units of length and load of each member, with E* = 1; of one profile for
        all members its contact in units of the scene
    ellipses
        their load ellipses in units of load
    load_unit, length_unit
        these units, (k,) each; 1 where one profile serves all members
    """

    member_numbers: Indices
    contact: SymmetricContact
    ellipses: Ellipses
    load_unit: Array | float
    length_unit: Array | float


@dataclass(frozen=True, eq=False)
class Members:
    """Members of a batch with admissible loads and profiles, m of them.

    Attributes
    ----------
    kind
        of their profiles
    parameters
        (m,) each, in the order of `_PARAMETERS_OF_KIND`; none for a table or a function
    contact
        of a profile that is given as such; None where its parameters may vary
    modulus
        E*
    ellipses
        their load ellipses, those that go round the other way mirrored, Q -> -Q
    is_mirrored
        (m,) whether that was done
    loads
        as they were given, (m,) each
    """

    kind: str
    parameters: list[Array]
    contact: SymmetricContact | None
    modulus: float
    ellipses: Ellipses
    is_mirrored: NDArray[np.bool_]
    loads: LoadArrays

    def shape_groups(self) -> Iterator[ShapeGroup]:
        """The members of a batch in groups whose profiles have one shape, and differ by their units
        of length and height alone: so one normal contact serves a group.

        Each group has the numbers of its members, their contact, and their load ellipses over the
        unit of load of each. Where all members have one profile (`contact` is not None) they are
        one group, in the units of the scene. Else profiles have one shape if the ratios of their
        `parameters` are equal.
        """
        if self.contact is not None:
            all_member_numbers = np.arange(len(self.is_mirrored))
            yield ShapeGroup(
                all_member_numbers, self.contact, self.ellipses, load_unit=1.0, length_unit=1.0
            )
            return
        # of each group: numbers of its members, their common ratios of parameters, and their units
        # of length and height
        for member_numbers, ratios, length_unit, height_unit in _members_by_shape(
            self.kind, self.parameters
        ):
            # E* times the unit of height
            load_unit = self.modulus * height_unit
            scaled_ellipses = self.ellipses.take(member_numbers).divided_by(load_unit)
            yield ShapeGroup(
                member_numbers,
                _contact_in_own_units(self.kind, ratios),
                scaled_ellipses,
                load_unit,
                length_unit,
            )


def _materials_of_both_bodies(material: Materials | Elastic) -> Materials:
    return Materials(upper=material, lower=material) if isinstance(material, Elastic) else material


class _ResultFunction(NamedTuple):
    """The function that computes the results of the members of a batch, and what these are.

    Attributes
    ----------
    compute
        results (n, m) of m members with admissible loads
    n_results
        n
    n_normalised
        how many results, from the first on, come times pi E*/(2 f^2), E* the composite modulus, f
        the friction
    reason_if_not_finite
        why the first result of a member is not finite
    """

    compute: Callable[[Members], Array]
    n_results: int
    n_normalised: int
    reason_if_not_finite: Reason = Reason.UNSETTLED


def _results_of_members(
    profile: Profile | Mapping[str, Any],
    material: Materials,
    loads: EllipseLoads,
    result_function: _ResultFunction,
) -> tuple[list[Array], NDArray[np.int8]]:
    """Results of each member of a batch of steady load ellipses, such as its friction work; and the
    code of the `Reason` why a member has none, 0 else.

    All arrays have the broadcast shape of the inputs and are read-only. A member without results
    has NaN. Keys of the profile and loads may be arrays that broadcast.

    `result_function` computes `n_results` rows of results. The first `n_normalised` of them come
    times pi E*/(2 f^2), which is undone here.

    Raises
    ------
    InputError
        For a profile or material that does not pass its own check, for keys that are no profile's,
        for what is no number, and for shapes that do not broadcast.
    """
    material = validated(material, Materials)
    profile = validated(profile, Frozen) if isinstance(profile, Frozen) else profile
    arguments = _BatchArguments.checked(profile, loads)
    # composite modulus E*; the contact, where one profile serves all members
    batch = _Batch(arguments.kind, material, profile)
    n_members = math.prod(arguments.shape)
    rows_of_results = np.full((result_function.n_results, n_members), np.nan)
    reason_codes = np.zeros(n_members, dtype=np.int8)
    # in blocks of 16,384 members (_MEMBERS_AT_ONCE)
    for first_member_number in range(0, n_members, _MEMBERS_AT_ONCE):
        block = slice(first_member_number, min(first_member_number + _MEMBERS_AT_ONCE, n_members))
        rows_of_results[:, block], reason_codes[block] = _results_of_block(
            batch, *arguments.of_block(block), result_function
        )
    rows_of_results.flags.writeable = False
    reason_codes.flags.writeable = False
    return (
        [row.reshape(arguments.shape) for row in rows_of_results],
        reason_codes.reshape(arguments.shape),
    )


def _results_of_block(
    batch: _Batch, loads: LoadArrays, parameters: list[Array], result_function: _ResultFunction
) -> tuple[Array, NDArray[np.int8]]:
    """Results, such as friction work, of m members of a batch, (n, m), NaN for a member without;
    and the code of the `Reason` why it has none, 0 else, (m,).

    `loads` and `parameters` of the profile are (m,) each. `result_function` computes n =
    `n_results` rows of results of admissible members. The first `n_normalised` rows come times
    pi E*/(2 f^2), E* the `modulus`.
    """
    # why members are left out, numbers of the others in the block, and these members
    reason_codes, admissible_member_numbers, members = batch.members_of(loads, parameters)
    rows_of_results = np.full((result_function.n_results, len(reason_codes)), np.nan)
    if len(admissible_member_numbers):
        results_of_admissible_members = result_function.compute(members)
        results_of_admissible_members[: result_function.n_normalised] *= (
            2 / (math.pi * batch.modulus) * members.loads.friction**2
        )
        rows_of_results[:, admissible_member_numbers] = results_of_admissible_members
        member_numbers_without_result = admissible_member_numbers[
            ~np.isfinite(results_of_admissible_members[0])
        ]
        reason_codes[member_numbers_without_result] = result_function.reason_if_not_finite
    return rows_of_results, reason_codes


class _BatchArguments(NamedTuple):
    """Arguments of a batch that broadcast to one shape.

    Attributes
    ----------
    kind
        of the profile
    loads, parameters
        P0, P1, Q0, Q1, phase [rad] and f; parameters of the profile, none where they do not vary:
        arrays, or numbers as arrays without dimension
    shape
        of the batch
    """

    kind: str
    loads: list[Array]
    parameters: list[Array]
    shape: tuple[int, ...]

    @classmethod
    def checked(cls, profile: Profile | Mapping[str, Any], loads: EllipseLoads) -> _BatchArguments:
        """The loads, and the keys of the profile that may be arrays, as arrays of real numbers.

        Raises
        ------
        InputError
            For keys that are no profile's, for what is no number, for shapes that do not broadcast.
        """
        kind, parameters = _parameters_of(profile)
        load_arrays = [
            real_numbers(value, name) for name, value in zip(_LOAD_NAMES, loads, strict=True)
        ]
        parameter_arrays = [
            real_numbers(value, f"profile: {name}") for name, value in parameters.items()
        ]
        try:
            shape = np.broadcast_shapes(
                *(array.shape for array in (*load_arrays, *parameter_arrays))
            )
        except ValueError as mismatch:
            raise InputError(f"the arrays of a batch must broadcast: {mismatch}") from mismatch
        return cls(kind, load_arrays, parameter_arrays, shape)

    def of_block(self, block: slice) -> tuple[LoadArrays, list[Array]]:
        """Loads and parameters of the m members of a block of the batch, (m,) each."""
        load_arrays = [_values_of_block(array, self.shape, block) for array in self.loads]
        parameter_arrays = [_values_of_block(array, self.shape, block) for array in self.parameters]
        return LoadArrays(*load_arrays), parameter_arrays


class _Batch:
    """What all members of a batch share: kind of profile, E*, the contact and the largest load of
    a profile whose parameters do not vary.
    """

    def __init__(
        self, kind: str, material: Materials, profile: Profile | Mapping[str, Any]
    ) -> None:
        """What all members of a batch of load ellipses share: E* of the `material`, and the normal
        contact of a single `profile` with the largest load that it carries.

        `extent` of the contact is the half-width where the profile ends. A profile given as keys
        with arrays has no contact yet: each member gets its own later. `kind` is that of the
        profile. E* is the composite modulus.
        """
        self.kind = kind
        self.modulus = composite_modulus(material)
        self.contact: SymmetricContact | None = None
        self.largest_load = math.inf
        # a profile itself, not its keys
        if not isinstance(profile, Mapping):
            self.contact = contact_of(profile, material)
            profile_half_length = self.contact.extent
            if profile_half_length < math.inf:
                load_at_end = float(self.contact.load(profile_half_length))
                # By so much that round-off takes no edge of contact beyond the end.
                self.largest_load = load_at_end * (1 - 1e-12)

    def members_of(
        self, loads: LoadArrays, parameters: list[Array]
    ) -> tuple[NDArray[np.int8], Indices, Members]:
        """The members of a block of a batch whose loads and profile are admissible, with their
        steady load ellipses; and why the others are not.

        `loads` and `parameters` of the profile are (m,) each. Loads are P0, P1, Q0, Q1 and the
        phase of P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), and f.

        Returns
        -------
        reason
            (m,) why a member has no result, a code of `Reason`
        numbers
            (k,) of the admissible members
        members
            these members with their load ellipses
        """
        is_invalid = self._is_invalid(loads, parameters)
        if np.any(is_invalid):
            # Some valid values in their place: these members are left out below.
            loads = LoadArrays(*(np.where(is_invalid, 1.0, column) for column in loads))
            parameters = [np.where(is_invalid, 1.0, column) for column in parameters]
        # Without friction only Q = 0 is admissible, and nothing is dissipated: any positive
        # coefficient gives that.
        friction = np.where(loads.friction > 0, loads.friction, 1.0)
        with np.errstate(over="ignore", invalid="ignore"):
            # angles and loads of the steady cycle; where Q1/f overflows the contact slides as a
            # whole
            ellipses = ellipses_of(
                loads.mean_normal,
                loads.normal_amplitude,
                loads.tangential_amplitude,
                loads.phase,
                friction,
            )
        # the mirrored loop, Q -> -Q, goes round the other way
        is_mirrored = np.tan(loads.phase / 2) < 0
        reason_codes = self._reasons(loads, ellipses, is_mirrored)
        reason_codes[is_invalid] = Reason.INVALID

        # keep the admissible members
        admissible_member_numbers = np.flatnonzero(reason_codes == Reason.NONE)
        if len(admissible_member_numbers) < len(reason_codes):
            ellipses = ellipses.take(admissible_member_numbers)
            is_mirrored = is_mirrored[admissible_member_numbers]
            friction = friction[admissible_member_numbers]
            parameters = [column[admissible_member_numbers] for column in parameters]
            loads = LoadArrays(*(column[admissible_member_numbers] for column in loads))
        members = Members(
            self.kind,
            parameters,
            self.contact,
            self.modulus,
            ellipses,
            is_mirrored,
            loads._replace(friction=friction),
        )
        return reason_codes, admissible_member_numbers, members

    def _reasons(
        self, loads: LoadArrays, ellipses: Ellipses, is_mirrored: NDArray[np.bool_]
    ) -> NDArray[np.int8]:
        """Why the loads of each of m members are inadmissible, (m,): separation, gross sliding, or
        EXTENT, a contact wider than the profile; else 0. Codes of `Reason`.

        `ellipses` are the steady load ellipses of these loads, with Q -> -Q where `is_mirrored`
        (m,). `largest_load` is what the profile carries up to its end.
        """
        mean_tangential_load = np.where(is_mirrored, -loads.mean_tangential, loads.mean_tangential)
        reason_codes = _reasons_of_loads(
            ellipses, mean_tangential_load, loads.tangential_amplitude, loads.friction
        )
        is_load_too_large = loads.mean_normal + loads.normal_amplitude > self.largest_load
        reason_codes[(reason_codes == Reason.NONE) & is_load_too_large] = Reason.EXTENT
        return reason_codes

    def _is_invalid(self, loads: LoadArrays, parameters: list[Array]) -> NDArray[np.bool_]:
        """Whether a member has loads or parameters of its profile that are not admitted, (m,)."""
        is_invalid = _has_invalid_loads(loads)
        if self.contact is None:
            is_invalid |= _is_invalid_shape(self.kind, parameters)
        if self.kind in _UNITS_AND_RATIOS:
            is_invalid |= _is_beyond_units(self.kind, parameters, self.modulus, loads.mean_normal)
        return is_invalid


def _values_of_block(array: Array, batch_shape: tuple[int, ...], block: slice) -> Array:
    """Values of the members of a block, from `block.start` to `block.stop` - 1, of an array that
    broadcasts to `batch_shape`; the others are not made.
    """
    if array.size == 1:
        return np.full(block.stop - block.start, array.item())
    if array.shape == batch_shape and array.flags.c_contiguous:
        return array.reshape(-1)[block]
    return np.broadcast_to(array, batch_shape).flat[block]


def _has_invalid_loads(loads: LoadArrays) -> NDArray[np.bool_]:
    """Whether loads or f of a member of a batch are not admitted, (m,): NaN, too large to be
    squared, negative where they must not be, or a P0 too small to be squared. LARGEST_NUMBER is
    1e100.
    """
    is_in_range = np.logical_and.reduce([np.abs(values) <= LARGEST_NUMBER for values in loads])
    is_negative = (
        (loads.normal_amplitude < 0) | (loads.tangential_amplitude < 0) | (loads.friction < 0)
    )
    return np.asarray(~is_in_range | (loads.mean_normal < 1 / LARGEST_NUMBER) | is_negative)


def _is_beyond_units(
    kind: str, parameters: list[Array], modulus: float, mean_normal_load: Array
) -> NDArray[np.bool_]:
    """Whether P0 in the profile's own unit of load is too small or too large to be squared, or NaN,
    for each member of a batch, (m,).

    P0 is `mean_normal_load`. The unit is E* = `modulus` times the unit of height.
    `_UNITS_AND_RATIOS` gives the units of length and height of the profile first. LARGEST_NUMBER is
    1e100.
    """
    with np.errstate(all="ignore"):
        _, height_unit, *_ = _UNITS_AND_RATIOS[kind](*parameters)
        scaled_load = mean_normal_load / modulus / height_unit
    return ~((scaled_load >= 1 / LARGEST_NUMBER) & (scaled_load <= LARGEST_NUMBER))


def _reasons_of_loads(
    ellipses: Ellipses, mean_tangential_load: Array, tangential_amplitude: Array, friction: Array
) -> NDArray[np.int8]:
    """Why each of m load ellipses is inadmissible: separation (P1 > P0), gross sliding (|Q| > f P
    at some instant), or none; codes of `Reason`, (m,).

    |Q| = f P is admitted, to round-off. Where both hold the code is that of separation. The largest
    Q - f P is Q0 - f P0 + f u, the largest -Q - f P is -Q0 - f P0 + f v. Here u and v
    (`forward_amplitude`, `reverse_amplitude`) are the amplitudes of (Q - f P)/f and (Q + f P)/f. P0
    and P1 are mean and amplitude of P.

    Parameters
    ----------
    mean_tangential_load
        (m,) Q0, -Q0 where the ellipse was mirrored [force per thickness]
    tangential_amplitude, friction
        (m,) Q1 and f
    """
    coulomb_limit_at_mean = friction * ellipses.mean_load
    # 4e-16 of the loads, about two round-offs
    largest_roundoff = 4e-16 * (
        np.abs(mean_tangential_load)
        + tangential_amplitude
        + coulomb_limit_at_mean
        + friction * ellipses.load_amplitude
    )
    is_sliding = (
        np.maximum(
            friction * ellipses.forward_amplitude + mean_tangential_load,
            friction * ellipses.reverse_amplitude - mean_tangential_load,
        )
        > coulomb_limit_at_mean + largest_roundoff
    )
    # Without friction u and v are those of another coefficient.
    is_sliding |= (friction == 0) & (tangential_amplitude > 0)
    reason_codes = np.full(len(coulomb_limit_at_mean), Reason.NONE, dtype=np.int8)
    reason_codes[is_sliding] = Reason.SLIDING
    reason_codes[ellipses.load_amplitude > ellipses.mean_load] = Reason.SEPARATION
    return reason_codes


# ------------------------------------------------------------------- profiles whose parameters vary
_PARAMETERS_OF_KIND = {
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


# From the parameters of a profile: its units of length and of height, then the ratios of parameters
# that determine its shape.
_UNITS_AND_RATIOS: dict[str, Callable[..., tuple[Array, ...]]] = {
    "hertz": lambda radius: (np.sqrt(radius), np.ones_like(radius)),
    "flat_rounded": lambda radius, b: (b, b * b / radius),
    "power_law": lambda exponent, length, rise: (length, rise, exponent),
    "compound": lambda inner, outer, b: (b, b * b / inner, outer / inner),
    "wedge": lambda radius, b: (b, b * b / radius),
    "polynomial": _units_of_polynomial,
}
# The profile in its own units, from the ratios that determine its shape.
_PROFILE_OF_RATIOS: dict[str, Callable[..., Profile]] = {
    "hertz": lambda: Hertz(radius=1.0),
    "flat_rounded": lambda: FlatRounded(radius=1.0, flat_half_length=1.0),
    "power_law": lambda exponent: PowerLaw(exponent=exponent, length=1.0, rise=1.0),
    "compound": lambda ratio: Compound(inner_radius=1.0, outer_radius=ratio, inner_half_length=1.0),
    "wedge": lambda: Wedge(tip_radius=1.0, tip_half_length=1.0),
    "polynomial": lambda *rises: EvenPolynomial(length=1.0, rises=rises),
}


def _parameters_of(profile: Profile | Mapping[str, Any]) -> tuple[str, dict[str, ArrayLike]]:
    """The kind of a profile and its parameters by name, numbers or arrays, none for a table or a
    function.

    The profile may be a mapping of keys to arrays, one value for each member of a batch. The
    `rises` of a polynomial, its coefficients, become "rise 1", "rise 2" and so on. All other
    parameters keep their names. Their order is that of `_PARAMETERS_OF_KIND`, which lists them for
    each kind.

    Raises
    ------
    InputError
        For a kind whose parameters cannot vary, for a key too many or too few.
    """
    if not isinstance(profile, Mapping):
        parameter_names = [
            name for name in _PARAMETERS_OF_KIND.get(profile.kind, ()) if name != "rises"
        ]
        parameters = {name: getattr(profile, name) for name in parameter_names}
        rises = profile.rises if isinstance(profile, EvenPolynomial) else ()
        return profile.kind, parameters | _rises_by_name(rises)
    # A profile that was fitted to rows has a key `fitted` in its dump, which is no parameter.
    kind = profile.get("kind")
    parameters = {name: value for name, value in profile.items() if name not in ("kind", "fitted")}
    if kind not in _PARAMETERS_OF_KIND:
        raise InputError(
            f"profile: a mapping for a batch has one of the kinds {', '.join(_PARAMETERS_OF_KIND)},"
            f" not {kind!r}; give the profile itself"
        )
    if set(parameters) != set(_PARAMETERS_OF_KIND[kind]):
        raise InputError(
            f"profile: {kind} comes with all its keys, {', '.join(_PARAMETERS_OF_KIND[kind])}, not"
            f" {', '.join(parameters) or 'none'}"
        )
    parameters = {name: parameters[name] for name in _PARAMETERS_OF_KIND[kind]}
    if kind != "polynomial":
        return kind, parameters
    rises = parameters.pop("rises")
    if not isinstance(rises, list | tuple) or not len(rises):
        raise InputError(
            "profile: rises is a list of numbers or arrays, one for each of the powers 2, 4, 6, ..."
        )
    return kind, parameters | _rises_by_name(rises)


def _rises_by_name(rises: Sequence[ArrayLike]) -> dict[str, ArrayLike]:
    """The rises of a polynomial by name: "rise 1", "rise 2" and so on."""
    return {f"rise {number}": rise for number, rise in enumerate(rises, 1)}


def _members_by_shape(
    kind: str, parameters: list[Array]
) -> Iterator[tuple[Indices, tuple[float, ...], Array, Array]]:
    """Groups of members of a batch whose profiles differ only by a unit of length and one of
    height, so that one contact serves them.

    Yields the numbers of the members (k,), the ratios of parameters that they have in common, and
    their units of length and height, (k,) each. `parameters` are (n,) each, in the order of
    `_PARAMETERS_OF_KIND` for this `kind` of profile; `_UNITS_AND_RATIOS` turns them into the units
    and the ratios.
    """
    with np.errstate(all="ignore"):
        length_unit, height_unit, *shape_ratios = _UNITS_AND_RATIOS[kind](*parameters)
    if all(np.all(ratio_of_members == ratio_of_members[0]) for ratio_of_members in shape_ratios):
        all_member_numbers = np.arange(len(length_unit))
        yield (
            all_member_numbers,
            tuple(float(ratio_of_members[0]) for ratio_of_members in shape_ratios),
            length_unit,
            height_unit,
        )
        return
    different_ratios, group_number_of_member = np.unique(
        np.stack(shape_ratios, axis=1), axis=0, return_inverse=True
    )
    group_number_of_member = group_number_of_member.reshape(-1)
    order_by_group = np.argsort(group_number_of_member, kind="stable")
    group_ends = np.cumsum(np.bincount(group_number_of_member, minlength=len(different_ratios)))
    member_numbers_of_groups = np.split(order_by_group, group_ends[:-1])
    for common_ratios, member_numbers in zip(
        different_ratios.tolist(), member_numbers_of_groups, strict=True
    ):
        yield (
            member_numbers,
            tuple(common_ratios),
            length_unit[member_numbers],
            height_unit[member_numbers],
        )


@lru_cache(maxsize=512)
def _contact_in_own_units(kind: str, ratios: tuple[float, ...]) -> SymmetricContact:
    """The normal contact of a profile in units of its own, with E* = 1, from its `kind` and the
    `ratios` of its parameters.
    """
    return contact_of(
        _PROFILE_OF_RATIOS[kind](*ratios),
        Materials(upper=_BODY_OF_UNIT_MODULUS, lower=_BODY_OF_UNIT_MODULUS),
    )


def _is_invalid_shape(kind: str, parameters: list[Array]) -> NDArray[np.bool_]:
    """Whether the profile of each member of a batch is not admitted, (m,): parameters outside their
    range, or shapes under which the contact would split. `parameters` (m,) each are in the fixed
    order of the `kind` of profile. LARGEST_NUMBER is 1e100, _LEAST_PARAMETER 1e-100.
    """
    least_values = (_LEAST_PARAMETER,) * len(parameters)
    if kind == "power_law":
        least_values = (1.0, _LEAST_PARAMETER, _LEAST_PARAMETER)
    elif kind == "polynomial":
        least_values = (_LEAST_PARAMETER, *[-LARGEST_NUMBER] * (len(parameters) - 1))
    is_in_range = [
        (parameter >= least_value) & (parameter <= LARGEST_NUMBER)
        for parameter, least_value in zip(parameters, least_values, strict=True)
    ]
    is_invalid = ~np.logical_and.reduce(is_in_range)
    member_numbers_in_range = np.flatnonzero(~is_invalid)
    if kind in ("polynomial", "compound") and len(member_numbers_in_range):
        # The profile and its contact have rules of their own: both are made once for each shape, in
        # units of its own; InputError if a rule is broken. The numbers of a shape count the members
        # in range alone.
        for numbers_of_shape_in_range, shape_ratios, _, _ in _members_by_shape(
            kind, [parameter[member_numbers_in_range] for parameter in parameters]
        ):
            try:
                _contact_in_own_units(kind, shape_ratios)
            except InputError:
                is_invalid[member_numbers_in_range[numbers_of_shape_in_range]] = True
    return is_invalid
