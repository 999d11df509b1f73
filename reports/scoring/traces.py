"""Findings with a trace of their own in the rows of a result: no theory with the fault is needed.

# notation: p pressure, q shear, f friction coefficient, h spacing, a half-width
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.comparison import Comparison
from reports.scoring.discrepancy import (
    PRESSURE,
    SHEAR,
    Discrepancy,
    Tractions,
    factors_of_tractions,
)
from scenes import STICK
from scenes.array_types import Array

NOISE = "noise"
UNKNOWN = "unknown"
OWN_BODIES = "own_bodies"
_TEMPLATES = Path(__file__).parents[1] / "templates"
WORDS: dict[str, Any] = tomllib.loads((_TEMPLATES / "faults.toml").read_text("utf-8"))
"""Sentences of each fault, of other findings, and quotients of E*/R with a likely cause."""
FAULTS: dict[str, str] = WORDS["faults"]

# Shear over f p, below which a point sticks for certain; step of the slip over the largest one,
# below which a point rests.
_LARGEST_STICK_SHARE_OF_LIMIT = 0.9
_LARGEST_STEP_AT_REST = 1e-3
# Least share of the square of the creep that is proportional to the change of the shear, where a
# penalty makes it (a third of the norm is left); least creep that is stated, over the largest step
# of slip.
_LEAST_PROPORTIONAL_SHARE = 8 / 9
_LEAST_CREEP = 3e-3
# Least ratio of F of the fit by a stiffness: noise alone gives one as large once in 10^11; fewest
# values that show a creep.
_LEAST_F_RATIO = 45.0
_FEWEST_CREEP_STEPS = 20
# Least share on the Coulomb limit of the points that should stick, where nothing sticks; distance
# from the limit, over f p, within which a point lies on it: shear beyond it is another fault.
_LEAST_SHARE_AT_LIMIT = 0.9
_LARGEST_DISTANCE_TO_LIMIT = 0.01
# Standard deviations of the noise by which a point may exceed the Coulomb limit and the contact law
# still be kept.
_DEVIATIONS_BY_NOISE = 5.0
# Standard deviation of the noise of the shear over that of the pressure, at most: few points may
# look like noise by chance. Noise over p_ref below which there is none.
LARGEST_NOISE_RATIO = 5.0
_LEAST_NOISE = 1e-10
# Share of the norm of a difference that means over three nodes leave, at most, where it alternates
# from node to node; standard deviations by which its ratio of von Neumann exceeds that of noise.
_LARGEST_SHARE_LEFT_BY_MEANS = 1 / 3
_FEWEST_DEVIATIONS_FROM_NOISE = 5.0
# Spacings on each side of an edge that a mesh can get wrong: the element with the edge in it, and
# its neighbour.
_SPACINGS_NEAR_EDGE = 2.0
# A traction that leaves the edge as a root has an error of about sqrt(2 h/a) of its peak over the
# element with the edge: shear, at stick edges, up to 1.2 of that on meshes of a/5 to a/24, pressure
# up to 0.36, its edge being found to a part of an element. A soft layer or a short body moves the
# pressure's edge by 0.7 to 1.5 of that.
_LARGEST_ERROR_AT_EDGE = (0.4, 1.0)
# Share of the points in contact that lie near an edge, at most, where "near" still means something.
_LARGEST_SHARE_NEAR_EDGES = 0.6


@dataclass(frozen=True)
class Diagnosis:
    """One finding on a result.

    Attributes
    ----------
    fault
        its key, of `FAULTS` or of the other findings in templates/faults.toml
    sentence
        the cause, and what to do
    evidence
        measured values, in words
    strength
        0 to 1: 1 minus the share of the difference that a result with just this fault leaves
    size
        how large the fault is, in a few words; empty of faults without a size
    """

    fault: str
    sentence: str
    evidence: tuple[str, ...]
    strength: float
    size: str = ""

    @property
    def name(self) -> str:
        """The finding in a few words."""
        return str(WORDS["names"][self.fault])

    @property
    def name_and_size(self) -> str:
        """The name of the finding with its size, as in a headline."""
        return f"{self.name} ({self.size})" if self.size else self.name


def find_outliers(comparison: Comparison) -> list[Diagnosis]:
    """A finding on single values of an external result that stand out of all others, with the first
    one's place; empty where there is none.
    """
    result_cycle = comparison.result_cycle
    # masks (instants, points) of pressure, shear and slip
    values_in_words = [
        f"{name} {getattr(result_cycle, name)[instant, point]:.6g} at instant {instant + 1} of the"
        f" last cycle (time {result_cycle.time[instant]:.6g}), x = {result_cycle.x[point]:.6g}"
        for name, mask in comparison.masks_of_isolated.items()
        for instant, point in np.argwhere(mask)
    ]
    if not values_in_words:
        return []
    # WORDS: templates of sentences; evidence: up to five further outliers
    sentence = WORDS["others"]["outlier"].format(
        count=len(values_in_words), first=values_in_words[0]
    )
    # key and sentence of the finding, evidence, strength from 0 to 1
    return [Diagnosis("outlier", sentence, tuple(values_in_words[1:6]), 1.0)]


def find_full_slip(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """A finding where the result lies on the Coulomb limit |q| = f p at the points that stick in
    the reference: it slips everywhere. `discrepancy` holds the tractions of result and reference.

    # notation: f coefficient of friction, p pressure, q shear
    """
    comparison = discrepancy.comparison
    friction_coefficient = comparison.scene.friction.coefficient
    if not friction_coefficient or not discrepancy.has_shear:
        return
    # fields (instants, points) of both through the last cycle
    result_cycle = comparison.result_cycle
    reference_cycle = comparison.reference_cycle
    has_pressure = result_cycle.pressure > 0.01 * comparison.scales.pressure
    # comparison.is_judged: instants with enough load to be judged
    is_pressed = has_pressure & comparison.is_judged[:, None]
    # points that stick for certain: |q| below 0.9 f p
    largest_certain_stick_shear = (
        _LARGEST_STICK_SHARE_OF_LIMIT * friction_coefficient * reference_cycle.pressure
    )
    is_well_below_limit = np.abs(reference_cycle.shear) < largest_certain_stick_shear
    should_stick = is_pressed & (reference_cycle.state == STICK) & is_well_below_limit
    coulomb_limit = friction_coefficient * result_cycle.pressure
    distance_to_limit = np.abs(np.abs(result_cycle.shear) - coulomb_limit)
    # on the Coulomb limit: to 1 %; at 90 % of the points at least
    is_at_limit = distance_to_limit <= _LARGEST_DISTANCE_TO_LIMIT * coulomb_limit
    n_sticking_points = int(should_stick.sum())
    if not n_sticking_points or is_at_limit[is_pressed].mean() < _LEAST_SHARE_AT_LIMIT:
        return
    share_at_limit = float((should_stick & is_at_limit).sum()) / n_sticking_points
    if share_at_limit < _LEAST_SHARE_AT_LIMIT:
        return

    # stick_edges: left and right edge of the stick zone at each instant
    stick_half_width = float(np.nanmax(np.diff(reference_cycle.stick_edges, axis=1))) / 2
    # the template's `width` is this half-width over a
    sentence = WORDS["others"]["full_slip"].format(
        width=stick_half_width / comparison.scales.half_width
    )
    evidence = (
        f"|q| is f p at {share_at_limit:.0%} of the {n_sticking_points} points and instants at"
        " which the reference sticks"
    )
    # key and sentence of the finding, evidence, strength from 0 to 1
    yield Diagnosis("full_slip", sentence, (evidence,), 1.0)


def find_elastic_slip(discrepancy: Discrepancy, *, shear_sign: float = 1.0) -> Iterator[Diagnosis]:
    """A finding where the slip of points that stick changes (they creep) in proportion to the
    shear, as with a penalty contact of stiffness K: a change dq moves them by dq/K. At least 8/9 of
    the square of the creep, without noise, must be in proportion, and not by chance.

    `shear_sign` is -1 where the file is known to have a shear of the wrong sign. `discrepancy`
    holds the tractions of result and reference.

    # notation: a_ref half-width of contact of the reference, E* composite modulus
    """
    # of slip and shear from instant to instant (k - 1, n), and which are of points that stick
    changes = _changes_in_stick(discrepancy, shear_sign)
    if changes is None:
        return
    creep_fit = _fitted_creep(changes)
    if creep_fit is None or not creep_fit.is_certain:
        return
    # scales.compliance: A = 2/E*; half_width: a_ref; K is stated over E*/a_ref
    scales = discrepancy.comparison.scales
    slip_per_shear = creep_fit.compliance  # 1/K
    relative_stiffness = scales.compliance * scales.half_width / (2 * slip_per_shear)
    evidence = (
        (
            f"{creep_fit.n_steps} steps of points that stick: the slip moves by"
            f" {creep_fit.relative_creep:.2g} of the largest step,"
            f" {creep_fit.share_proportional:.0%} of it in proportion to the shear"
        ),
        f"a tangential stiffness of {relative_stiffness:.2g} E*/a_ref",
    )
    # key and sentence of the finding, evidence, strength from 0 to 1
    yield Diagnosis("elastic_slip", FAULTS["elastic_slip"], evidence, creep_fit.share_proportional)


class _CreepFit(NamedTuple):
    """Changes of the slip of points that stick, fitted as changes of the shear over a stiffness K.

    Attributes
    ----------
    n_steps
        number of changes, over all points and instants
    compliance
        1/K [length/stress]
    share_proportional
        share of the square of the slip's changes, without noise, that is in proportion to the shear
    relative_creep
        root mean square of the slip's changes, without noise, over the largest change of any point
    ratio_of_variances
        of the F test: what the shear explains over what it leaves, per value
    """

    n_steps: int
    compliance: float
    share_proportional: float
    relative_creep: float
    ratio_of_variances: float

    @property
    def is_certain(self) -> bool:
        """Whether the slip changes in proportion to the shear (8/9 of the square), by 0.3 % of the
        largest change at least. It must not be by chance: noise alone gives a ratio of variances of
        45 once in 10^11.
        """
        return (
            self.compliance > 0
            and self.share_proportional >= _LEAST_PROPORTIONAL_SHARE
            and self.relative_creep >= _LEAST_CREEP
            and self.ratio_of_variances >= _LEAST_F_RATIO
        )


def _fitted_creep(changes: _ChangesInStick) -> _CreepFit | None:
    """Fit the changes of the slip of points that stick as changes of the shear over a stiffness, by
    least squares. None for fewer than 20 changes, where slip or shear do not change, and where the
    slip's changes are noise alone. Noise is half the mean squared difference of neighbours.
    """
    is_sticking = changes.is_sticking
    creep = changes.slip_change[is_sticking]
    shear_change = changes.shear_change[is_sticking]
    if len(creep) < _FEWEST_CREEP_STEPS or not shear_change.any() or not creep.any():
        return None
    compliance = float(creep @ shear_change / (shear_change @ shear_change))
    slip_left = changes.slip_change - compliance * changes.shear_change
    mean_square_of_creep = float(np.mean(creep**2))
    mean_square_left = float(np.mean(slip_left[is_sticking] ** 2))
    mean_square_of_noise = 0.0
    is_pair_sticking = is_sticking[:, 1:] & is_sticking[:, :-1]
    if is_pair_sticking.any():
        neighbour_differences = np.diff(slip_left, axis=1)[is_pair_sticking]
        mean_square_of_noise = float(np.mean(neighbour_differences**2)) / 2
    mean_square_of_noise = min(mean_square_of_noise, mean_square_left)
    if mean_square_of_creep <= mean_square_of_noise:
        return None
    square_without_noise = mean_square_of_creep - mean_square_of_noise
    mean_square_explained = mean_square_of_creep - mean_square_left
    return _CreepFit(
        n_steps=len(creep),
        compliance=compliance,
        share_proportional=1 - (mean_square_left - mean_square_of_noise) / square_without_noise,
        relative_creep=float(np.sqrt(square_without_noise)) / changes.largest_slip_change,
        ratio_of_variances=mean_square_explained / max(mean_square_left, 1e-300) * len(creep),
    )


class _ChangesInStick(NamedTuple):
    """Changes of a result from instant to instant.

    Attributes
    ----------
    slip_change, shear_change
        (k - 1, n) change of slip [length] and of shear [stress]
    is_sticking
        (k - 1, n) which of the changes are of points that stick
    largest_slip_change
        largest change of the slip of any point in contact [length]
    """

    slip_change: Array
    shear_change: Array
    is_sticking: NDArray[np.bool_]
    largest_slip_change: float


def _changes_in_stick(discrepancy: Discrepancy, shear_sign: float) -> _ChangesInStick | None:
    """Changes of the result's slip and of its shear (times `shear_sign`) from instant to instant,
    and which of them are of points that stick. None without friction, shear or slip.

    Points that stick from one instant to the next are those with |q| < 0.9 f p at both, in the
    result and in the reference, whose slip rests in the reference. `discrepancy` holds the
    tractions of result and reference.

    # notation: f coefficient of friction, p pressure, q shear
    """
    comparison = discrepancy.comparison
    friction_coefficient = comparison.scene.friction.coefficient
    result_cycle = comparison.result_cycle
    reference_cycle = comparison.reference_cycle
    if not friction_coefficient or not discrepancy.has_shear or len(result_cycle.time) < 2:
        return None
    if not (np.isfinite(result_cycle.slip).all() and np.isfinite(reference_cycle.slip).all()):
        return None
    # judged: an instant with enough load; isolated: a value that stands out of all others
    is_below_limit = comparison.is_judged[:, None] & ~comparison.masks_of_isolated["shear"]
    for cycle in (result_cycle, reference_cycle):
        is_below_limit &= cycle.pressure > 0.01 * comparison.scales.pressure
        is_below_limit &= (
            np.abs(cycle.shear)
            < _LARGEST_STICK_SHARE_OF_LIMIT * friction_coefficient * cycle.pressure
        )
    slip_change = np.diff(result_cycle.slip, axis=0)
    slip_change_of_reference = np.diff(reference_cycle.slip, axis=0)
    shear_change = shear_sign * np.diff(result_cycle.shear, axis=0)
    is_touching = (result_cycle.pressure[1:] > 0) & (result_cycle.pressure[:-1] > 0)
    # largest slip between two instants of points in contact
    largest_slip_change = float(np.max(np.abs(slip_change), where=is_touching, initial=0.0))
    # the slip of the reference changes by less than a thousandth of it
    is_at_rest = np.abs(slip_change_of_reference) <= _LARGEST_STEP_AT_REST * largest_slip_change
    is_sticking = is_below_limit[1:] & is_below_limit[:-1] & is_at_rest
    return _ChangesInStick(slip_change, shear_change, is_sticking, largest_slip_change)


def find_alternating_nodes(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """A finding where pressures alternate from node to node: nodal forces or extrapolated stresses
    of corner and mid-side nodes of quadratic elements.

    The mean (1, 2, 1)/4 over neighbours takes out what alternates. The ratio of von Neumann (half
    the mean square of the change between neighbours, over the mean square) is 2 where all
    alternates. It is 1 for white noise, and scatters by 1/sqrt(n) for n points. `discrepancy` holds
    the tractions of result and reference.

    # notation: p_ref scale of pressure
    """
    # result minus reference over p_ref, (k, n)
    residual = discrepancy.residual(discrepancy.reference_tractions, PRESSURE)
    is_inside = residual.is_in_contact
    are_all_inside = is_inside[:, :-2] & is_inside[:, 1:-1] & is_inside[:, 2:]
    # points of one instant: a mesh errs alike at all instants
    n_points = int(are_all_inside.sum(axis=1).max())
    if not n_points or discrepancy.is_within_tolerance(PRESSURE):
        return
    values = residual.values
    smooth_values = (values[:, :-2] + 2 * values[:, 1:-1] + values[:, 2:])[are_all_inside] / 4
    neighbour_changes = np.diff(values, axis=1)[is_inside[:, 1:] & is_inside[:, :-1]]
    mean_square_of_residual = float(np.mean(values[:, 1:-1][are_all_inside] ** 2))
    ratio_of_neumann = float(np.mean(neighbour_changes**2)) / 2 / mean_square_of_residual
    deviations_from_noise = (ratio_of_neumann - 1) * np.sqrt(n_points)
    share_left = float(np.sqrt(np.mean(smooth_values**2) / mean_square_of_residual))
    # a third of the norm at most, and five standard deviations of noise at least
    if (
        share_left > _LARGEST_SHARE_LEFT_BY_MEANS
        or deviations_from_noise < _FEWEST_DEVIATIONS_FROM_NOISE
    ):
        return
    evidence = (
        f"{n_points} points of an instant have both neighbours in contact; their means over three"
        f" points leave {share_left:.0%} of the difference",
    )
    # key and sentence of the finding, evidence, strength from 0 to 1
    yield Diagnosis("alternating", WORDS["others"]["alternating"], evidence, 1 - share_left)


def find_scatter(discrepancy: Discrepancy) -> Iterator[Diagnosis]:
    """A finding where the difference between result and reference is scatter of the tractions from
    point to point (noise); it states how many points exceed the Coulomb limit |q| = f p.
    `discrepancy` holds the tractions of both.

    # notation: f coefficient of friction, p pressure, p_ref scale of pressure, q shear
    """
    friction_coefficient = discrepancy.comparison.scales.friction
    components = [PRESSURE]
    if discrepancy.has_shear and friction_coefficient > 0:
        components.append(SHEAR)
    # result minus reference, over p_ref or f p_ref
    residuals = [
        discrepancy.residual(discrepancy.reference_tractions, component) for component in components
    ]
    residuals_with_difference = [residual for residual in residuals if residual.mean_square > 0]
    if not residuals_with_difference or not all(
        residual.is_noise for residual in residuals_with_difference
    ):
        return
    # standard deviations, of p/p_ref and of q/(f p_ref)
    noise_by_component = [
        min(residual.mean_square_of_noise, residual.mean_square) ** 0.5 for residual in residuals
    ]
    counts_shear = len(noise_by_component) > 1
    if counts_shear and _shear_alone_scatters(noise_by_component, friction_coefficient):
        return
    square_of_noise = sum(noise**2 for noise in noise_by_component)
    share_of_noise = square_of_noise / sum(residual.mean_square for residual in residuals)
    evidence = [
        f"noise from point to point makes {share_of_noise:.0%} of the square of the discrepancy"
    ]
    noise_in_words = f"{noise_by_component[PRESSURE]:.2g} in p/p_ref"
    if counts_shear:
        noise_in_words += f" and {noise_by_component[SHEAR]:.2g} in q/(f p_ref)"
        evidence.insert(0, _sentence_on_coulomb_limit(discrepancy, square_of_noise**0.5))
    # WORDS: templates of sentences
    sentence = WORDS["others"][NOISE].format(size=noise_in_words)
    # key and sentence of the finding, evidence, strength from 0 to 1
    yield Diagnosis(NOISE, sentence, tuple(evidence), share_of_noise)


def _shear_alone_scatters(noise_by_component: Sequence[float], friction_coefficient: float) -> bool:
    """Whether the noise of the shear is more than five times that of the pressure, which one code
    does not make in one file. `noise_by_component` has both standard deviations, of p/p_ref and of
    q/(f p_ref). Less than 1e-10 of p_ref (`_LEAST_NOISE`) counts as that much.

    # notation: f coefficient of friction, p pressure, p_ref scale of pressure, q shear
    """
    pressure_noise = max(noise_by_component[PRESSURE], _LEAST_NOISE)
    return friction_coefficient * noise_by_component[SHEAR] > LARGEST_NOISE_RATIO * pressure_noise


def _sentence_on_coulomb_limit(discrepancy: Discrepancy, noise: float) -> str:
    """How many points in contact exceed the Coulomb limit |q| = f p, by how much at most, and
    whether noise alone makes as much: five standard deviations. `noise` is the standard deviation
    of the tractions, over p_ref and f p_ref.

    # notation: f coefficient of friction, p pressure, p_ref scale of pressure, q shear
    """
    scales = discrepancy.comparison.scales
    result_cycle = discrepancy.comparison.result_cycle  # at all instants
    # points in contact in the reference
    is_touching = discrepancy.comparison.reference_cycle.pressure > 1e-3 * scales.pressure
    # excess of |q| over the limit f p, in f p_ref
    excess = np.abs(result_cycle.shear) / scales.shear - result_cycle.pressure / scales.pressure
    n_beyond_limit = int(np.sum(excess[is_touching] > 0))
    largest_excess = float(np.max(excess[is_touching]))
    size_in_words = "more than noise alone makes"
    if largest_excess <= _DEVIATIONS_BY_NOISE * noise:
        size_in_words = "no more than noise makes: no fault of the contact law"
    return (
        f"{n_beyond_limit} of {int(is_touching.sum())} points in contact exceed the Coulomb"
        f" limit, by {largest_excess:.2g} of f p_ref at most: {size_in_words}"
    )


def find_long_steps(comparison: Comparison) -> Iterator[Diagnosis]:
    """A finding of load steps that are too long where the tractions show nothing. The dissipation
    of an external result is wrong beside that of the smooth load path. It is less than half as
    wrong beside that of straight lines between the instants.

    A solver that is exact within its steps only cuts the corners of the load path. Its tractions
    are right again soon after a corner, so that they do not show it; the dissipation sums it up.
    """
    values = {metric.key: metric.value for metric in comparison.metrics}
    # relative errors of the dissipation, beside that of the smooth path and of straight lines
    error_on_smooth_path = values.get("dissipation")
    error_on_straight_lines = values.get("dissipation_polygon")
    tolerance = comparison.scene.tolerances.limit("dissipation") or 0.0
    if error_on_smooth_path is None or error_on_straight_lines is None:
        return
    if (
        not abs(error_on_smooth_path) > tolerance
        or not abs(error_on_straight_lines) < abs(error_on_smooth_path) / 2
    ):
        return
    n_steps = len(comparison.result_cycle.time) - 1
    evidence = (
        (
            f"error of the dissipation {error_on_smooth_path:.2g}; against that of the straight"
            f" lines between the {n_steps} steps {error_on_straight_lines:.2g}"
        ),
        "the tractions are within their tolerances",
    )
    # FAULTS: templates of sentences on known faults
    sentence = FAULTS["steps"].format(steps=n_steps)
    # key and sentence of the finding, evidence, strength from 0 to 1
    yield Diagnosis(
        "steps", sentence, evidence, 1 - abs(error_on_straight_lines / error_on_smooth_path)
    )


def points_near_edges(discrepancy: Discrepancy) -> NDArray[np.bool_]:
    """Which of the n surface points of a result lie near an edge of contact or stick at each of k
    instants, (k, n): within two spacings of the points.

    The edges are those of the reference at the instant, and those of its smallest stick zone in the
    cycle: what a mesh gets wrong there stays locked in. `discrepancy` holds the points `x` (n,),
    the tractions of result and reference, and the numbers of the k instants in the last cycle.
    """
    x = discrepancy.x
    reference_cycle = discrepancy.comparison.reference_cycle
    spacing = _wider_spacing(x)
    # x of the edges at each instant, (k, 1) each: left and right, of contact and of stick
    edge_positions = [
        edge
        for edges in (reference_cycle.contact_edges, reference_cycle.stick_edges)
        for edge in edges[discrepancy.instants_of_cycle].T[:, :, None]
    ]
    if np.isfinite(reference_cycle.stick_edges).any():
        # of the smallest stick zone in the cycle
        least_half_width = np.nanmin(np.abs(reference_cycle.stick_edges))
        innermost_edges = (
            np.nanmax(reference_cycle.stick_edges[:, 0]),
            np.nanmin(reference_cycle.stick_edges[:, 1]),
        )
        edge_positions += (
            innermost_edges if discrepancy.unsymmetric else (-least_half_width, least_half_width)
        )
    shape = discrepancy.reference_tractions[PRESSURE].shape
    with np.errstate(invalid="ignore"):
        is_near_each_edge = [
            np.broadcast_to(np.abs(x - edge) <= _SPACINGS_NEAR_EDGE * spacing, shape)
            for edge in edge_positions
        ]
    return np.any(is_near_each_edge, axis=0)


def _wider_spacing(x: Array) -> Array:
    """(n,) the wider of the two spacings beside each point [length]."""
    spacings = np.diff(x)
    return np.maximum(np.append(spacings, spacings[-1]), np.insert(spacings, 0, spacings[0]))


def tractions_of_coarse_mesh(
    discrepancy: Discrepancy,
) -> tuple[Tractions, NDArray[np.bool_]] | None:
    """Tractions that a mesh too coarse at the edges would give, (2, k, n), and which points lie
    near an edge, (k, n). There the reference is changed by the difference of the result, as far as
    the spacing can account for it.

    None where no point, or most points in contact, lie near an edge. An elastic traction falls
    to 0 at the edge of contact as (1 - x/a)^(1/2), and q leaves the stick edge likewise.
    Interpolated on elements of length h its error is of the order of p_ref sqrt(2 h/a) over the
    element with the edge. A larger difference is not the mesh's. `discrepancy` holds the tractions
    of result and reference.

    # notation: a half-width of contact, f coefficient of friction, p_ref scale of pressure, q shear
    """
    is_near_edge = points_near_edges(discrepancy)
    is_in_contact = discrepancy.mask_in_contact(discrepancy.reference_tractions)
    # more than 60 % of the points in contact
    if not is_near_edge.any() or np.mean(is_near_edge[is_in_contact]) > _LARGEST_SHARE_NEAR_EDGES:
        return None
    # (n,) wider spacing beside each point
    spacing = _wider_spacing(discrepancy.x)
    # 0.4 of sqrt(2 h/a) for the pressure, once for the shear, in p_ref and f p_ref
    largest_error = (
        factors_of_tractions(*_LARGEST_ERROR_AT_EDGE)
        * np.sqrt(2 * spacing / discrepancy.half_width)
        * discrepancy.traction_units
    )
    difference = np.clip(
        discrepancy.result_tractions - discrepancy.reference_tractions,
        -largest_error,
        largest_error,
    )
    return discrepancy.reference_tractions + np.where(is_near_edge, difference, 0.0), is_near_edge
