"""The discrepancy of a result: what is to be explained, and how much of it is noise.

# notation: p pressure, q shear, f friction coefficient, p_ref, a_ref scales of the comparison
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

import halfplane_fe
import semi_analytic
from reports.comparison import Comparison
from reports.comparison.measures import norm, over, shares
from reports.comparison.pairs import are_half_planes
from reports.comparison.verdicts import Verdict, verdict_on
from scenes import InputError, Scene
from scenes.array_types import Array

Tractions = Array
"""(2, k, n): pressure and shear at instants and points [stress]."""

Mask = NDArray[np.bool_]

PRESSURE = 0
SHEAR = 1
TRACTIONS = ("pressure", "shear")  # their names, by these numbers
# A steady cycle has some five turning points and ends of full stick; two instants to each tell
# faults apart. Each instant costs time in every solve of theory.
_MOST_INSTANTS = 10
# Instants from which on neighbours in time tell noise from what is smooth; ratio of von Neumann
# below which few pairs tell nothing.
_FEWEST_INSTANTS = 3
_LEAST_RATIO = 0.3
# Of p_ref, above which a point counts as loaded.
_LOADED = 1e-3


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """What is to be explained: some instants of the last cycle, all points.

    Attributes
    ----------
    comparison
        the result beside its reference
    rows
        (k,) the instants taken, of the last cycle's
    reference_tractions, result_tractions
        tractions of the reference, and of the result; where this has no number, the reference's
    weight
        (k, n) of the squares, 0 where the result has no number; they add up to 1
    missing
        share of the result's tractions that are no numbers
    exact
        whether `reference_tractions` are half-plane theory of the scene
    sheared
        whether the file has a shear
    has_bodies
        whether `reference_tractions` are half-plane theory with the numbers of the scene's own
        finite bodies, which the reference does not have
    """

    comparison: Comparison
    rows: NDArray[np.intp]
    reference_tractions: Tractions
    result_tractions: Tractions
    weight: Array
    missing: float
    exact: bool
    sheared: bool = True
    has_bodies: bool = False

    @property
    def scene(self) -> Scene:
        """The question that `reference_tractions` answer."""
        return self.comparison.scene

    @property
    def x(self) -> Array:
        """(n,) [length]."""
        return self.comparison.result_cycle.x

    @property
    def time(self) -> Array:
        """(k,) of the load path."""
        return self.comparison.result_cycle.time[self.rows]

    @property
    def fraction(self) -> Array:
        """(k,) of the cycle of the load path, from its start."""
        return fraction_of_cycle(self.comparison)[self.rows]

    @property
    def on_cycle(self) -> bool:
        """Whether the path repeats, and every instant lies on its cycle."""
        path = self.scene.load.path()
        return path.period is not None and bool(
            self.comparison.result_cycle.time[0] >= path.cycle_start
        )

    @property
    def normal_load(self) -> Array:
        """(k,) P of the reference [force / thickness]."""
        return self.comparison.reference_cycle.normal_load[self.rows]

    @property
    def loaded(self) -> Mask:
        """(k,) instants with more than a hundredth of the largest P."""
        return self.normal_load > 0.01 * self.comparison.scales.normal_load

    @property
    def half_width(self) -> float:
        """a_ref [length]."""
        return self.comparison.scales.half_width

    @cached_property
    def resultant_ratio(self) -> float:
        """Integral of the result's pressure over x, divided by the load P: about 1 where the result
        is in equilibrium. It is the median over the loaded instants; NaN where there is none.

        It is compared with P and with the same integral over the reference's pressure, and the
        ratio nearer to 1 counts: nodal forces over element lengths add up to P on any mesh,
        pressures at points to the integral of theory's. Where the points end within the contact of
        the reference, and not within that of the result, only P counts.
        """
        if not self.loaded.any():
            return float("nan")
        sums = np.trapezoid(self.result_tractions[PRESSURE], self.x, axis=1)[self.loaded]
        sums_of_reference = np.trapezoid(self.reference_tractions[PRESSURE], self.x, axis=1)
        ratio_to_load = float(np.median(sums / self.normal_load[self.loaded]))
        reference_is_cut_off = self._ends_in_contact(self.reference_tractions)
        if reference_is_cut_off and not self._ends_in_contact(self.result_tractions):
            return ratio_to_load
        ratio_to_reference = float(np.sum(sums) / np.sum(sums_of_reference[self.loaded]))
        return min((ratio_to_load, ratio_to_reference), key=lambda ratio: abs(ratio - 1))

    def _ends_in_contact(self, tractions: Tractions) -> bool:
        """Whether the first or the last point carries pressure."""
        ends = np.abs(tractions[PRESSURE][:, [0, -1]])
        return bool(np.any(ends > _LOADED * self.comparison.scales.pressure))

    @property
    def elements(self) -> float:
        """Spacings of the points over a_ref, the median in and beside the contact."""
        inner_x = self.x[np.abs(self.x) <= 1.5 * self.half_width]
        spacing = float(np.median(np.diff(inner_x if len(inner_x) > 1 else self.x)))
        return self.half_width / spacing

    @property
    def unsymmetric(self) -> bool:
        """Whether bulk stress, tilt or unequal sides make tractions that are not even in x."""
        return self.comparison.has_bulk_stress or self.comparison.may_tilt

    @property
    def units(self) -> Array:
        """(2, 1, 1): p_ref and f p_ref."""
        return pair(self.comparison.scales.pressure, self.comparison.scales.shear)

    def in_contact(self, predicted: Tractions) -> Mask:
        """(k, n) points with a pressure in the result or in the prediction, and with numbers."""
        limit = _LOADED * self.comparison.scales.pressure
        is_loaded = (np.abs(self.result_tractions[PRESSURE]) > limit) | (
            np.abs(predicted[PRESSURE]) > limit
        )
        return is_loaded & (self.weight > 0)

    def residual(self, predicted: Tractions, channel: int) -> Residual:
        """Difference of the result's pressure (channel 0) or shear (1) from a prediction, over its
        unit.
        """
        scaled_difference = (self.result_tractions[channel] - predicted[channel]) / self.units[
            channel
        ]
        return Residual(scaled_difference, self.weight, self.in_contact(predicted))

    def residuals(self, predicted: Tractions) -> tuple[Residual, Residual]:
        """What a prediction leaves of the result's pressure, and of its shear."""
        return self.residual(predicted, PRESSURE), self.residual(predicted, SHEAR)

    def errors(self) -> tuple[float, float]:
        """||p - p_ref||/||p_ref|| and ||q - q_ref||/(f ||p_ref||) at the worst of the instants."""
        friction = self.comparison.scales.friction
        sizes = norm(self.x, self.reference_tractions[0]) * pair(1, friction)[:, :, 0]
        relative_errors = over(
            norm(self.x, self.result_tractions - self.reference_tractions), sizes
        )
        p, q = np.nanmax(relative_errors, axis=1, initial=0.0).tolist()
        return p, q

    def is_within(self, channel: int) -> bool:
        """Whether the error of the pressure or of the shear is within its tolerance."""
        key = TRACTIONS[channel]
        limit = self.comparison.scene.tolerances.limit(key) or 0.0
        return verdict_on(self.errors()[channel], limit) is Verdict.WITHIN

    @property
    def within(self) -> bool:
        """Whether both errors are within their tolerances."""
        return self.is_within(PRESSURE) and self.is_within(SHEAR)


@dataclass(frozen=True, eq=False)
class Residual:
    """Found minus predicted of one traction, over its unit.

    Attributes
    ----------
    values
        (k, n)
    weight
        (k, n) of the squares
    is_inside
        (k, n), the points in contact
    """

    values: Array
    weight: Array
    is_inside: Mask

    @property
    def count(self) -> int:
        """Points in contact, over all instants."""
        return int(self.is_inside.sum())

    @property
    def square(self) -> float:
        """Weighted mean of the squares in contact; infinite where the prediction holds a NaN."""
        weight = np.where(self.is_inside, self.weight, 0.0)
        total = float(weight.sum())
        if not total:
            return 0.0
        value = float(np.sum(weight * np.where(self.is_inside, self.values, 0.0) ** 2)) / total
        return value if np.isfinite(value) else float("inf")

    @cached_property
    def noise(self) -> float:
        """Mean square of what neighbours do not share: half the squared difference of both.

        Neighbours in x and, of three instants and more, in time: the smaller of the two. Of white
        noise it is its variance; of anything smooth over points or instants it is far less.
        """
        return min(self._differences(axis)[0] for axis in self._axes)

    @property
    def _axes(self) -> tuple[int, ...]:
        return (1, 0) if len(self.values) >= _FEWEST_INSTANTS else (1,)

    def _differences(self, axis: int) -> tuple[float, int]:
        """How much a residual changes from one value to the next: half the weighted mean square of
        the difference of neighbours that are both in contact, and the number of such pairs. Without
        a pair: the mean square of the values, and 0.

        `axis` 0 takes neighbours in time, 1 neighbours in x.
        """
        is_inside = np.moveaxis(self.is_inside, axis, -1)
        weight = np.moveaxis(self.weight, axis, -1)
        both_inside = is_inside[..., 1:] & is_inside[..., :-1]
        if not both_inside.any():
            return self.square, 0
        steps = np.diff(np.moveaxis(self.values, axis, -1))
        weight = np.where(both_inside, weight[..., 1:] + weight[..., :-1], 0.0)
        half_squares = np.where(both_inside, steps, 0.0) ** 2 / 2
        return float(np.sum(weight * half_squares) / weight.sum()), int(both_inside.sum())

    @property
    def is_noise(self) -> bool:
        """Whether nothing in a residual (result minus prediction at instants and points) is smooth,
        by the ratio of von Neumann: half the mean squared difference of neighbours over the mean
        square, 1 for white noise.

        The ratio scatters by sqrt(1/n) for n pairs; three of these deviations are allowed for.
        """
        if not self.is_inside.any():
            return False
        for axis in self._axes:
            noise, pairs = self._differences(axis)
            lowest_ratio = max(1 - 3 / np.sqrt(max(pairs, 1)), _LEAST_RATIO)
            if noise < lowest_ratio * self.square:
                return False
        return True


def fraction_of_cycle(comparison: Comparison) -> Array:
    """(k,) share of a period at each instant, from the start of the path's cycle.

    From 0 to 1, or from somewhere between to one period later. Of instants that are no whole
    cycle each counts from the start of its own revolution. The time itself where nothing repeats.
    """
    path = comparison.scene.load.path()
    result_cycle = comparison.result_cycle
    if path.period is None or result_cycle.is_whole:
        return result_cycle.fraction
    return np.asarray(np.mod((result_cycle.time - path.cycle_start) / path.period, 1.0))


def pair(of_pressure: float, of_shear: float) -> Array:
    """(2, 1, 1): a factor for each of the tractions."""
    return np.array([of_pressure, of_shear], dtype=float)[:, None, None]


def discrepancy_of(comparison: Comparison) -> Discrepancy | None:
    """The tractions of result and reference that a diagnosis of likely faults compares: at most ten
    instants of the last cycle, evenly chosen, with a weight for each point and instant.

    A value that is missing or stands out alone is replaced by the reference's, with weight 0. Where
    the reference is half-plane theory and the scene has finite bodies, theory with their elastic
    responses takes its place. None where the result has no instant with a contact, or not one
    number.
    """
    # instants loaded enough to be judged; without any, those at which either has pressure
    is_usable = comparison.is_judged if comparison.is_judged.any() else comparison.is_in_contact
    usable_instants = np.flatnonzero(is_usable)
    if not len(usable_instants):
        return None
    n_instants = min(len(usable_instants), _MOST_INSTANTS)
    places = np.linspace(0, len(usable_instants) - 1, n_instants).round().astype(int)
    rows = usable_instants[np.unique(places)]
    reference_cycle = comparison.reference_cycle
    result_cycle = comparison.result_cycle
    reference_tractions = np.array([reference_cycle.pressure[rows], reference_cycle.shear[rows]])
    result_tractions = np.array([result_cycle.pressure[rows], result_cycle.shear[rows]])
    has_shear = not np.isnan(result_tractions[SHEAR]).all()
    if not has_shear:  # a file without shear: it counts for nothing
        result_tractions[SHEAR] = np.nan_to_num(reference_tractions[SHEAR])
    is_known = np.isfinite(reference_tractions).all(axis=0)
    is_known &= np.isfinite(result_tractions).all(axis=0)
    isolated = comparison.isolated
    is_known &= ~(isolated["pressure"] | isolated["shear"])[rows]
    if not is_known.any():
        return None
    tractions_with_bodies = _with_bodies(comparison, rows)
    if tractions_with_bodies is not None:
        reference_tractions = tractions_with_bodies
        result_tractions = np.where(is_known, result_tractions, reference_tractions)
    weight = is_known * shares(result_cycle.time[rows])[:, None] * shares(result_cycle.x)
    reference_tractions = np.nan_to_num(reference_tractions)
    return Discrepancy(
        comparison,
        rows,
        reference_tractions,
        np.where(is_known, result_tractions, reference_tractions),
        weight / weight.sum(),
        missing=float(1 - is_known.mean()),
        exact=comparison.reference.engine == "semi_analytic" and tractions_with_bodies is None,
        sheared=has_shear,
        has_bodies=tractions_with_bodies is not None,
    )


def _with_bodies(comparison: Comparison, rows: NDArray[np.intp]) -> Tractions | None:
    """Tractions of theory with what the scene's finite bodies add, at the points and the instants
    `rows` of the result. None where the reference has them in it, or where they are not covered.
    """
    scene = comparison.scene
    if comparison.reference.engine != "semi_analytic" or are_half_planes(scene):
        return None
    try:
        solution = semi_analytic.solve(
            scene,
            x=comparison.result_cycle.x,
            time=comparison.result_cycle.time[rows],
            fields=("pressure", "shear"),
            effects=halfplane_fe.body_effects(scene),
        )
    except InputError:  # curved faces, free sides: `body_effects` says which are covered
        return None
    return np.array([solution.pressure, solution.shear])
