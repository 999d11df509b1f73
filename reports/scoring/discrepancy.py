"""The discrepancy of a result, its difference from the reference: what is to be explained, and how
much of it is noise.

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
from reports.comparison.cycles import Cycle
from reports.comparison.laws import Verdict, verdict_on
from reports.comparison.measures import l2_norm, quotient, trapezoidal_weights
from reports.comparison.pairs import are_half_planes
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
_FEWEST_INSTANTS_FOR_TIME = 3
_LEAST_RATIO_OF_NOISE = 0.3
# Of p_ref, above which a point counts as loaded.
_LEAST_LOADED_SHARE = 1e-3


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """Tractions of a result and of its reference: k instants of the last cycle, all n points of the
    result.

    Attributes
    ----------
    comparison
        the result beside its reference
    instants_of_cycle
        (k,) indices of the instants among those of the last cycle
    reference_tractions, result_tractions
        tractions of the reference, and of the result; where this has no number, or an outlier,
        the reference's
    weight
        (k, n) of a squared difference in sums, 0 where the result has no number or an outlier; adds
        up to 1
    missing_share
        share of the points and instants at which the result or the reference has no number
    outlier_share
        share of those at which both have numbers, and that of the result is an outlier
    is_half_plane_theory
        whether `reference_tractions` are half-plane theory of the scene
    has_shear
        whether the result states a shear
    has_bodies
        whether `reference_tractions` are half-plane theory with the numbers of the scene's own
        finite bodies, which the reference does not have
    """

    comparison: Comparison
    instants_of_cycle: NDArray[np.intp]
    reference_tractions: Tractions
    result_tractions: Tractions
    weight: Array
    missing_share: float
    outlier_share: float
    is_half_plane_theory: bool
    has_shear: bool = True
    has_bodies: bool = False

    @property
    def scene(self) -> Scene:
        """The scene of the comparison: geometry, material, friction and loads."""
        return self.comparison.scene

    @property
    def x(self) -> Array:
        """(n,) points of the result [length]."""
        return self.comparison.result_cycle.x

    @property
    def time(self) -> Array:
        """(k,) times of the instants on the load path."""
        return self.comparison.result_cycle.time[self.instants_of_cycle]

    @property
    def cycle_fraction(self) -> Array:
        """(k,) share of a period at each instant, from the start of the load path's cycle."""
        return fraction_of_cycle(self.comparison)[self.instants_of_cycle]

    @property
    def is_on_cycle(self) -> bool:
        """Whether the path repeats, and every instant lies on its cycle."""
        path = self.scene.load.path()
        return path.period is not None and bool(
            self.comparison.result_cycle.time[0] >= path.cycle_start
        )

    @property
    def normal_load(self) -> Array:
        """(k,) P of the reference at the instants [force / thickness]."""
        return self.comparison.reference_cycle.normal_load[self.instants_of_cycle]

    @property
    def is_loaded(self) -> Mask:
        """(k,) whether an instant has more than a hundredth of the reference load P_ref."""
        return self.normal_load > 0.01 * self.comparison.scales.normal_load

    @property
    def half_width(self) -> float:
        """a_ref [length]."""
        return self.comparison.scales.half_width

    @cached_property
    def resultant_ratio(self) -> float:
        """Integral of the result's pressure over x, divided by what it should be: about 1 where the
        result is in equilibrium. NaN where no instant is loaded by more than a hundredth of the
        reference load.

        Of two ratios the one nearer to 1 counts: to P, as the median over the loaded instants; and
        to the same integral of the reference's pressure, both summed over these instants. Nodal
        forces over element lengths add up to P on any mesh, pressures at points to the integral of
        theory's. Where the points end within the contact of the reference, and not within that of
        the result, only P counts.

        # notation: P normal load
        """
        if not self.is_loaded.any():
            return float("nan")
        result_pressure = self.result_tractions[PRESSURE][self.is_loaded]
        reference_pressure = self.reference_tractions[PRESSURE][self.is_loaded]
        result_integrals = np.trapezoid(result_pressure, self.x, axis=1)
        reference_integrals = np.trapezoid(reference_pressure, self.x, axis=1)
        ratio_to_load = float(np.median(result_integrals / self.normal_load[self.is_loaded]))
        # whether the first or the last point carries pressure of the reference
        reference_is_cut_off = self._ends_in_contact(self.reference_tractions)
        if reference_is_cut_off and not self._ends_in_contact(self.result_tractions):
            return ratio_to_load
        ratio_to_reference = float(np.sum(result_integrals) / np.sum(reference_integrals))
        return min((ratio_to_load, ratio_to_reference), key=lambda ratio: abs(ratio - 1))

    def _ends_in_contact(self, tractions: Tractions) -> bool:
        """Whether the first or the last point carries pressure."""
        pressure_at_ends = np.abs(tractions[PRESSURE][:, [0, -1]])
        return bool(
            np.any(pressure_at_ends > _LEAST_LOADED_SHARE * self.comparison.scales.pressure)
        )

    @property
    def elements_per_half_width(self) -> float:
        """a_ref over the spacing of the points, which is the median in and beside the contact."""
        inner_x = self.x[np.abs(self.x) <= 1.5 * self.half_width]
        spacing = float(np.median(np.diff(inner_x if len(inner_x) > 1 else self.x)))
        return self.half_width / spacing

    @property
    def unsymmetric(self) -> bool:
        """Whether bulk stress, tilt or unequal sides make tractions that are not even in x."""
        return self.comparison.has_bulk_stress or self.comparison.may_tilt

    @property
    def traction_units(self) -> Array:
        """(2, 1, 1): p_ref and f p_ref, what pressure and shear are divided by [stress]."""
        return factors_of_tractions(self.comparison.scales.pressure, self.comparison.scales.shear)

    def mask_in_contact(self, predicted: Tractions) -> Mask:
        """(k, n) whether a point has a pressure in the result or in the `predicted` tractions
        (2, k, n), and numbers in the result.
        """
        least_pressure = _LEAST_LOADED_SHARE * self.comparison.scales.pressure
        has_result_pressure = np.abs(self.result_tractions[PRESSURE]) > least_pressure
        has_predicted_pressure = np.abs(predicted[PRESSURE]) > least_pressure
        return (has_result_pressure | has_predicted_pressure) & (self.weight > 0)

    def residual(self, predicted: Tractions, component: int) -> Residual:
        """Difference of the result's pressure (component 0) or shear (1) from a prediction, over
        its unit, p_ref or f p_ref.
        """
        difference = self.result_tractions[component] - predicted[component]
        scaled_difference = difference / self.traction_units[component]
        return Residual(scaled_difference, self.weight, self.mask_in_contact(predicted))

    def residuals(self, predicted: Tractions) -> tuple[Residual, Residual]:
        """Differences of the result's pressure and of its shear from a prediction."""
        return self.residual(predicted, PRESSURE), self.residual(predicted, SHEAR)

    def relative_errors(self) -> tuple[float, float]:
        """Relative errors of a result's pressure p and shear q at the worst of the instants: ||p -
        p_0||/||p_0|| and ||q - q_0||/(f ||p_0||). The reference has p_0 and q_0; norms are roots of
        integrals of squares over x.

        # notation: f coefficient of friction
        """
        friction_coefficient = self.comparison.scales.friction
        pressure_norm = l2_norm(self.x, self.reference_tractions[PRESSURE])
        # ||p_0|| and f ||p_0|| at each of the k instants, (2, k)
        norms_of_reference = pressure_norm * factors_of_tractions(1, friction_coefficient)[:, :, 0]
        norms_of_difference = l2_norm(self.x, self.result_tractions - self.reference_tractions)
        relative_errors = quotient(norms_of_difference, norms_of_reference)
        pressure_error, shear_error = np.nanmax(relative_errors, axis=1, initial=0.0).tolist()
        return pressure_error, shear_error

    def is_within_tolerance(self, component: int) -> bool:
        """Whether the error of the pressure or of the shear is within its tolerance; without one,
        whether there is none.
        """
        key = TRACTIONS[component]
        limit = self.comparison.scene.tolerances.limit(key) or 0.0
        return verdict_on(self.relative_errors()[component], limit) is Verdict.WITHIN

    @property
    def is_within_tolerances(self) -> bool:
        """Whether the errors of pressure and of shear are both within their tolerances."""
        return self.is_within_tolerance(PRESSURE) and self.is_within_tolerance(SHEAR)


@dataclass(frozen=True, eq=False)
class Residual:
    """Pressure or shear of a result minus that of a prediction, over p_ref or f p_ref, at k
    instants and n points.

    Attributes
    ----------
    values
        (k, n) the difference
    weight
        (k, n) of its square in sums
    is_in_contact
        (k, n) whether a point is in contact
    """

    values: Array
    weight: Array
    is_in_contact: Mask

    @property
    def n_values(self) -> int:
        """Number of values in contact, over all instants."""
        return int(self.is_in_contact.sum())

    @property
    def mean_square(self) -> float:
        """Weighted mean square of the values in contact; infinite where the prediction holds a
        NaN, 0 without a contact.
        """
        weight = np.where(self.is_in_contact, self.weight, 0.0)
        sum_of_weights = float(weight.sum())
        if not sum_of_weights:
            return 0.0
        squares = np.where(self.is_in_contact, self.values, 0.0) ** 2
        mean_square = float(np.sum(weight * squares)) / sum_of_weights
        return mean_square if np.isfinite(mean_square) else float("inf")

    @cached_property
    def mean_square_of_noise(self) -> float:
        """Mean square of the noise in the residual (k instants, n points), a result minus a
        prediction: half the mean squared difference of neighbours.

        It is taken of neighbours in x and, of three instants and more, in time: the smaller one
        counts. White noise has its variance; values that are smooth over points or instants have
        far less.
        """
        # [0]: the mean square, without the number of pairs; _axes: 1 in x, 0 in time
        return min(self._noise_along(axis)[0] for axis in self._axes)

    @property
    def _axes(self) -> tuple[int, ...]:
        """Axes of the values along which neighbours are compared: 1 in x, 0 in time."""
        return (1, 0) if len(self.values) >= _FEWEST_INSTANTS_FOR_TIME else (1,)

    def _noise_along(self, axis: int) -> tuple[float, int]:
        """Noise of a residual (k instants, n points): half the weighted mean square of the
        difference of neighbours that are both in contact, and the number of such pairs. Without a
        pair: the mean square of the residual, and 0.

        `axis` 0 takes neighbours in time, 1 neighbours in x.
        """
        # (k, n) whether a point is in contact, with the neighbours along the last axis
        is_inside = np.moveaxis(self.is_in_contact, axis, -1)
        weight = np.moveaxis(self.weight, axis, -1)
        is_pair_inside = is_inside[..., 1:] & is_inside[..., :-1]
        if not is_pair_inside.any():
            return self.mean_square, 0
        changes = np.diff(np.moveaxis(self.values, axis, -1))
        pair_weight = np.where(is_pair_inside, weight[..., 1:] + weight[..., :-1], 0.0)
        half_squares = np.where(is_pair_inside, changes, 0.0) ** 2 / 2
        noise = float(np.sum(pair_weight * half_squares) / pair_weight.sum())
        return noise, int(is_pair_inside.sum())

    @property
    def is_noise(self) -> bool:
        """Whether nothing in a residual (result minus prediction at instants and points) is smooth
        along x, and over time where there are at least three instants. False without a value in
        contact.

        It goes by the ratio of von Neumann: half the mean squared difference of neighbours over the
        mean square, 1 for white noise. The ratio scatters by sqrt(1/n) for n pairs; three of these
        deviations are allowed for, down to a ratio of 0.3.
        """
        if not self.is_in_contact.any():
            return False
        # 1 in x, 0 in time
        for axis in self._axes:
            # half the mean squared difference of neighbours
            noise, n_pairs = self._noise_along(axis)
            lowest_ratio = max(1 - 3 / np.sqrt(max(n_pairs, 1)), _LEAST_RATIO_OF_NOISE)
            if noise < lowest_ratio * self.mean_square:
                return False
        return True


def fraction_of_cycle(comparison: Comparison) -> Array:
    """(k,) share of a period at each instant of a result's last cycle, from the start of the load
    path's cycle.

    It runs from 0 to 1; for a cycle that begins later on the path, from there to one period later.
    Instants that are no whole cycle are each counted from the start of their revolution. On a path
    without a period it is the time itself.
    """
    path = comparison.scene.load.path()
    result_cycle = comparison.result_cycle
    # is_whole: the instants make up a whole cycle
    if path.period is None or result_cycle.is_whole:
        # (k,) as the result's cycle has it
        return result_cycle.fraction
    return np.asarray(np.mod((result_cycle.time - path.cycle_start) / path.period, 1.0))


def factors_of_tractions(pressure_factor: float, shear_factor: float) -> Array:
    """(2, 1, 1): one number for the pressure and one for the shear, to multiply tractions (2, k, n)
    by.
    """
    return np.array([pressure_factor, shear_factor], dtype=float)[:, None, None]


def discrepancy_of(comparison: Comparison) -> Discrepancy | None:
    """The tractions of result and reference that a diagnosis of likely faults compares: at most ten
    instants of the last cycle, evenly chosen, with a weight for each point and instant.

    A value that is no number, or an outlier at a single point, is replaced by the reference's, with
    weight 0. Where the reference is half-plane theory and the scene has finite bodies, theory with
    their elastic responses takes its place. None where no instant has a contact in result or
    reference, or where no value counts.
    """
    instants = _instants_to_compare(comparison)
    if not len(instants):
        return None

    # tractions of both at these instants, and which of them count
    result_cycle = comparison.result_cycle
    reference_tractions = _tractions_at(comparison.reference_cycle, instants)
    result_tractions = _tractions_at(result_cycle, instants)
    has_shear = not np.isnan(result_tractions[SHEAR]).all()
    if not has_shear:  # a file without shear: it counts for nothing
        result_tractions[SHEAR] = np.nan_to_num(reference_tractions[SHEAR])
    is_known = np.isfinite(reference_tractions).all(axis=0)
    is_known &= np.isfinite(result_tractions).all(axis=0)
    # masks_of_isolated: values that stand out of all others
    masks_of_isolated = comparison.masks_of_isolated
    is_outlier = (masks_of_isolated["pressure"] | masks_of_isolated["shear"])[instants]
    is_counted = is_known & ~is_outlier
    if not is_counted.any():
        return None

    # theory with the responses of the scene's finite bodies, None where it has none
    tractions_with_bodies = _theory_with_bodies(comparison, instants)
    has_bodies = tractions_with_bodies is not None
    if tractions_with_bodies is not None:
        reference_tractions = tractions_with_bodies
    reference_tractions = np.nan_to_num(reference_tractions)
    # weights of the trapezoidal rule in time and x, 0 for values that do not count
    weight = (
        is_counted
        * trapezoidal_weights(result_cycle.time[instants])[:, None]
        * trapezoidal_weights(result_cycle.x)
    )
    return Discrepancy(
        comparison,
        instants,
        reference_tractions,
        np.where(is_counted, result_tractions, reference_tractions),
        weight / weight.sum(),
        missing_share=float(1 - is_known.mean()),
        outlier_share=float((is_known & is_outlier).mean()),
        is_half_plane_theory=comparison.reference.engine == "semi_analytic" and not has_bodies,
        has_shear=has_shear,
        has_bodies=has_bodies,
    )


def _instants_to_compare(comparison: Comparison) -> NDArray[np.intp]:
    """Indices of at most ten instants of the last cycle, evenly chosen among those that are loaded
    enough to be judged. Without any, among those at which result or reference has pressure.
    """
    is_usable = comparison.is_judged if comparison.is_judged.any() else comparison.is_in_contact
    usable_instants = np.flatnonzero(is_usable)
    if not len(usable_instants):
        return usable_instants
    n_instants = min(len(usable_instants), _MOST_INSTANTS)
    even_indices = np.linspace(0, len(usable_instants) - 1, n_instants).round().astype(int)
    return usable_instants[np.unique(even_indices)]


def _tractions_at(cycle: Cycle, instants: NDArray[np.intp]) -> Tractions:
    """Pressure and shear (2, k, n) of a solution at k instants of its last cycle, by their indices,
    and at its n points.
    """
    return np.array([cycle.pressure[instants], cycle.shear[instants]])


def _theory_with_bodies(comparison: Comparison, instants: NDArray[np.intp]) -> Tractions | None:
    """Tractions (2, k, n) of half-plane theory corrected for the scene's finite bodies, at the
    result's n points and its k instants of the numbers `instants`.

    None where the bodies are half-planes, where the reference is no half-plane theory, and where
    theory has no correction for bodies of this shape.
    """
    scene = comparison.scene
    # engine "semi_analytic": half-plane theory
    if comparison.reference.engine != "semi_analytic" or are_half_planes(scene):
        return None
    try:
        solution = semi_analytic.solve(
            scene,
            x=comparison.result_cycle.x,
            time=comparison.result_cycle.time[instants],
            fields=("pressure", "shear"),
            # compliances and curvatures that finite bodies add to half-planes
            effects=halfplane_fe.body_effects(scene),
        )
    except InputError:  # curved faces, free sides: `body_effects` says which are covered
        return None
    return np.array([solution.pressure, solution.shear])
