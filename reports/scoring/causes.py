"""The causes that `score` can name, one object each: what it changes in a `Variant` of theory, and
from which sizes its search starts.

# notation: P, Q loads, p pressure, q shear, f friction coefficient, a half-width, E* modulus
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy
from reports.scoring.variants import Variant, wrong_loads
from scenes import InputError

# Half-widths over which the points of a file lie where its nodes may be too coarse to show more
# than nodal forces.
_FINE_ELEMENTS = 12.0
# Largest share of what blocks of `BLOCK_HEIGHT` add: blocks of height 1.8 a_ref, no higher than the
# contact is wide.
_LARGEST_SHARE_OF_BLOCKS = 8.0
# Dundurs' constants that are tried first: 0.5 is the largest of all.
_BETAS = (-0.15, 0.15)
_LARGEST_BETA = 0.5
# Compliance of a layer that is tried first [a_ref/E*].
_COMPLIANCES_OF_LAYER = (0.02, 0.1)
# Delays of a revolution that are tried first.
_DELAYS = tuple((np.arange(16) - 7.5) / 16)
# Logarithms of f that are tried first; those at which next to nothing slips: a mesh keeps the
# infinite shear of bonded faces finite, as a large f does.
_LOGS_OF_FRICTION = tuple(np.log([0.4, 0.6, 0.8, 1.25, 1.7, 3.0]))
_LOGS_OF_FRICTION_WITHOUT_SLIP = tuple(np.log([15.0, 50.0, 300.0]))
_LARGEST_LOG_OF_FRICTION = 7.0
# A factor counts as the power of ten that it is near to: a mesh does not move a resultant by more.
# A factor of a hundred or more is one of units even farther off.
_NEARNESS_TO_POWER = 0.02
_NEARNESS_TO_POWER_OF_UNITS = 0.25
# Logarithm of the largest factor of units.
_LARGEST_LOG_OF_UNITS = 25.0
# Longest cycle, in steps, whose steps may be too long as a solver takes them whose law holds at
# their ends.
_MOST_STEPS_OF_CYCLE = 64
# A moment of the pressures tells a factor to this; a search must not start at no change at all.
_LEAST_START = 0.02


@dataclass(frozen=True)
class Cause:
    """A fault that a result may have.

    Attributes
    ----------
    key
        of its sentence in templates/faults.toml
    changed_variant
        the variant with the fault of this size in it
    start_sizes
        sizes at which its search starts; none where the file can't have it. A fault without a size
        has the one size 1
    component
        0 where the pressure shows it, 1 where the shear alone does
    group
        causes of one group are not told apart where two of them meet
    has_size
        whether its size is fitted
    resultant_factor
        the factor by which it changes the sum of the pressures; None where it leaves it
    largest_size
        size that no search goes beyond
    """

    key: str
    changed_variant: Callable[[Variant, float], Variant]
    start_sizes: Callable[[Discrepancy], Sequence[float]]
    component: int = PRESSURE
    group: str = ""
    has_size: bool = True
    resultant_factor: Callable[[float], float] | None = None
    largest_size: float = 3.5


def _compared_load_width_and_centre(discrepancy: Discrepancy) -> tuple[float, float, float]:
    """How the pressure of the result compares with the reference's, over all points and instants:
    the ratio of the sums, the ratio of the widths (standard deviations in x), and the distance
    between the centroids, result minus reference [length]. 1, 1, 0 where either has no pressure.
    """
    # of the result, then of the reference: sum, centroid, standard deviation in x
    moments = []
    for tractions in (discrepancy.result_tractions, discrepancy.reference_tractions):
        pressure = tractions[PRESSURE]
        # weight (k, n): of each instant and point in the sums
        weighted_pressure = discrepancy.weight * np.maximum(pressure, 0.0)
        sum_of_pressure = float(weighted_pressure.sum())
        if not sum_of_pressure:
            return 1.0, 1.0, 0.0
        centre = float(np.sum(weighted_pressure * discrepancy.x)) / sum_of_pressure
        second_moment = np.sum(weighted_pressure * (discrepancy.x - centre) ** 2) / sum_of_pressure
        moments.append((sum_of_pressure, centre, float(np.sqrt(second_moment))))
    sum_of_result, centre_of_result, width_of_result = moments[0]
    sum_of_reference, centre_of_reference, width_of_reference = moments[1]
    width_ratio = 1.0
    if width_of_result and width_of_reference:
        width_ratio = width_of_result / width_of_reference
    distance = centre_of_result - centre_of_reference
    return sum_of_result / sum_of_reference, width_ratio, distance


def _size_away_from_zero(value: float) -> float:
    """A size to start a search from: `value`, or 0.02 with its sign where it is smaller."""
    return value if abs(value) > _LEAST_START else float(np.copysign(_LEAST_START, value))


def _start_sizes_of_stiffness(discrepancy: Discrepancy) -> Sequence[float]:
    """Size from which the search for a wrong factor of E* starts, in a tuple: its logarithm by the
    ratio of the widths of contact, which go as 1/sqrt(E*).
    """
    _, width_ratio, _ = _compared_load_width_and_centre(discrepancy)
    return (_size_away_from_zero(-2 * np.log(width_ratio)),)


def _start_sizes_of_factor(discrepancy: Discrepancy) -> Sequence[float]:
    """Logarithm of the ratio of the pressure sums, result to reference, in a tuple."""
    ratio, _, _ = _compared_load_width_and_centre(discrepancy)
    return (_size_away_from_zero(np.log(ratio)),)


def _start_sizes_of_units(discrepancy: Discrepancy) -> Sequence[float]:
    """The power of ten that the sum of the pressures is near to."""
    ratio, _, _ = _compared_load_width_and_centre(discrepancy)
    power_of_ten = nearest_power_of_ten(ratio)
    return () if power_of_ten is None else (float(np.log(power_of_ten)),)


def nearest_power_of_ten(factor: float) -> float | None:
    """The power of ten that a factor is near to, within 2 %, or 25 % for a hundred and more; None
    where it is near to none, or to 1.
    """
    if factor <= 0:
        return None
    order = round(np.log10(factor))
    nearness = _NEARNESS_TO_POWER_OF_UNITS if abs(order) >= 2 else _NEARNESS_TO_POWER
    if order == 0 or abs(factor / 10.0**order - 1) >= nearness:
        return None
    return float(10.0**order)


def _start_sizes_of_pressure_alone(discrepancy: Discrepancy) -> Sequence[float]:
    """Under a wrong factor of the pressure the shear is right."""
    is_shear_right = (
        discrepancy.is_within_tolerance(SHEAR)
        or discrepancy.residual(discrepancy.reference_tractions, SHEAR).is_noise
    )
    return _start_sizes_of_factor(discrepancy) if is_shear_right and _has_shear(discrepancy) else ()


def _start_sizes_of_shear_alone(discrepancy: Discrepancy) -> Sequence[float]:
    """Size at which to start the search for a wrong factor of a result's shear, in a tuple: the
    logarithm of the ratio of the sums of the shear over x, result to reference.

    The ratio is that of least squares over the instants. Empty where it is not positive, and
    without a shear.
    """
    if not _has_shear(discrepancy):
        return ()
    weight = discrepancy.weight
    # a sum for each instant; weight (k, n) of each instant and point in the sums
    result_sums = np.sum(weight * discrepancy.result_tractions[SHEAR], axis=1)
    reference_sums = np.sum(weight * discrepancy.reference_tractions[SHEAR], axis=1)
    square_of_reference = float(reference_sums @ reference_sums)
    if not square_of_reference:
        return ()
    ratio = float(result_sums @ reference_sums) / square_of_reference
    # no search starts at no change at all
    return (_size_away_from_zero(np.log(ratio)),) if ratio > 0 else ()


def _start_sizes_of_stretch(discrepancy: Discrepancy) -> Sequence[float]:
    """Sizes at which the search for a stretch of x starts: logarithms of the ratio of widths, and
    of that of the sums, which a coarse mesh leaves alone.
    """
    _, width_ratio, _ = _compared_load_width_and_centre(discrepancy)
    starts = [_size_away_from_zero(np.log(width_ratio))]
    if discrepancy.resultant_ratio > 0:
        starts.append(_size_away_from_zero(np.log(discrepancy.resultant_ratio)))
    return starts


def _start_sizes_of_offset(discrepancy: Discrepancy) -> Sequence[float]:
    """Distance between the centroids of the pressures, result minus reference, over a_ref, at most
    2; in a tuple. 0.02 in place of 0.
    """
    _, _, shift = _compared_load_width_and_centre(discrepancy)
    limit = 2 * discrepancy.half_width
    return (float(np.clip(shift, -limit, limit)) / discrepancy.half_width or _LEAST_START,)


def _has_shear(discrepancy: Discrepancy) -> bool:
    """Whether the file and the scene have a shear."""
    return bool(
        discrepancy.has_shear
        and discrepancy.scene.friction.coefficient
        and np.any(discrepancy.reference_tractions[SHEAR])
    )


def _start_sizes_where_shear(*starts: float) -> Callable[[Discrepancy], Sequence[float]]:
    """The function that gives `starts` where file and scene have a shear, else no size."""
    return lambda discrepancy: starts if _has_shear(discrepancy) else ()


def _start_sizes_of_delay(discrepancy: Discrepancy) -> Sequence[float]:
    return _DELAYS if discrepancy.is_on_cycle and len(discrepancy.instants_of_cycle) >= 4 else ()


def _start_sizes_on_cycle(discrepancy: Discrepancy) -> Sequence[float]:
    return (1.0,) if _has_shear(discrepancy) and discrepancy.is_on_cycle else ()


def _start_sizes_of_short_steps(discrepancy: Discrepancy) -> Sequence[float]:
    """The size 1 where the result's steps may be too long: a symmetric scene on a cycle of at most
    64 steps, with shear; else none.
    """
    is_short = len(discrepancy.comparison.result_cycle.time) - 1 <= _MOST_STEPS_OF_CYCLE
    return (
        (1.0,)
        if _start_sizes_on_cycle(discrepancy) and is_short and not discrepancy.unsymmetric
        else ()
    )


def _start_sizes_of_mesh(discrepancy: Discrepancy) -> Sequence[float]:
    return (1.0,) if discrepancy.elements_per_half_width < _FINE_ELEMENTS else ()


def _start_sizes_of_body(discrepancy: Discrepancy) -> Sequence[float]:
    return () if discrepancy.unsymmetric else (0.5,)


def _start_sizes_of_layer(discrepancy: Discrepancy) -> Sequence[float]:
    """Sizes at which the search for a soft layer starts: none where the contact is not wider than
    theory's.
    """
    _, width_ratio, _ = _compared_load_width_and_centre(discrepancy)
    return _COMPLIANCES_OF_LAYER if width_ratio > 1 and not discrepancy.unsymmetric else ()


def _start_sizes_of_coupling(discrepancy: Discrepancy) -> Sequence[float]:
    """Dundurs' constants from which the search for unlike materials starts; none without a shear,
    for an unsymmetric scene, and for prescribed displacements.
    """
    has_shear = discrepancy.has_shear and bool(discrepancy.scene.friction.coefficient)
    is_plain = not discrepancy.unsymmetric and not discrepancy.scene.load.is_driven
    may_be_coupled = has_shear and is_plain
    return _BETAS if may_be_coupled and bool(np.any(discrepancy.result_tractions[SHEAR])) else ()


def _start_sizes_of_wrong_load(key: str) -> Callable[[Discrepancy], Sequence[float]]:
    """The function that gives the size at which the search for one fault of the loads starts. `key`
    is the name of the fault, such as "tilt_left_out".

    The size of a fault is how large it is, for instance a delay. A fault of the loads is there or
    not: its size is 1. No size is given where the scene cannot have it.
    """

    def start_sizes(discrepancy: Discrepancy) -> Sequence[float]:
        """(1,), or () where the loads of the scene cannot have this fault. The discrepancy holds
        the tractions of a result and of its reference, and the scene.
        """
        # wrong_loads: what each fault changes in the loads of the scene, by the fault's name
        with contextlib.suppress(InputError):
            return (1.0,) if key in wrong_loads(discrepancy.scene) else ()
        return ()

    return start_sizes


def _variant_with_tractions_times(variant: Variant, log_factor: float) -> Variant:
    """The variant with pressure and shear of the file multiplied by exp(log_factor)."""
    k = float(np.exp(log_factor))
    return replace(
        variant,
        pressure_factor=k * variant.pressure_factor,
        shear_factor=k * variant.shear_factor,
    )


def _variant_with_loads_times(variant: Variant, log_factor: float) -> Variant:
    """Loads k times too large: bodies 1/k times as stiff, and every traction times k."""
    scaled_tractions = _variant_with_tractions_times(variant, log_factor)
    return replace(
        scaled_tractions, modulus_factor=variant.modulus_factor * float(np.exp(-log_factor))
    )


def _factor_of_log(size: float) -> float:
    return float(np.exp(size))


STIFFNESS = Cause(
    "stiffness",
    lambda variant, m: replace(variant, modulus_factor=variant.modulus_factor * float(np.exp(m))),
    _start_sizes_of_stiffness,
    group="size",
)
LOADS = Cause(
    "loads",
    _variant_with_loads_times,
    _start_sizes_of_factor,
    group="size",
    resultant_factor=_factor_of_log,
)
TRACTION_FACTOR = Cause(
    "traction_factor",
    _variant_with_tractions_times,
    _start_sizes_of_factor,
    group="size",
    resultant_factor=_factor_of_log,
    largest_size=_LARGEST_LOG_OF_UNITS,
)
UNITS = Cause(
    "units",
    _variant_with_tractions_times,
    _start_sizes_of_units,
    has_size=False,
    resultant_factor=_factor_of_log,
    largest_size=_LARGEST_LOG_OF_UNITS,
)
PRESSURE_FACTOR = Cause(
    "pressure_factor",
    lambda variant, k: replace(variant, pressure_factor=float(np.exp(k)) * variant.pressure_factor),
    _start_sizes_of_pressure_alone,
    group="size",
    resultant_factor=_factor_of_log,
)
X_SCALE = Cause(
    "x_scale",
    lambda variant, k: replace(variant, x_stretch=float(np.exp(k))),
    _start_sizes_of_stretch,
    group="size",
    resultant_factor=_factor_of_log,
)
OFFSET = Cause("offset", lambda variant, d: replace(variant, x_offset=d), _start_sizes_of_offset)
PRESSURE_SIGN = Cause(
    "pressure_sign",
    lambda variant, _: replace(variant, pressure_factor=-variant.pressure_factor),
    lambda _: (1.0,),
    has_size=False,
)
SWAPPED = Cause(
    "swapped",
    lambda variant, _: replace(variant, is_swapped=True),
    _start_sizes_where_shear(1.0),
    has_size=False,
)
COARSE_MESH = Cause(
    "coarse_edge",
    lambda variant, _: replace(variant, has_nodal_forces=True),
    _start_sizes_of_mesh,
    has_size=False,
)
SMALL_BODY = Cause(
    "small_body",
    lambda variant, share: replace(variant, share_of_block_curvatures=share),
    _start_sizes_of_body,
    group="size",
    largest_size=_LARGEST_SHARE_OF_BLOCKS,
)
SOFT_NORMAL = Cause(
    "soft_normal",
    lambda variant, compliance: replace(variant, relative_layer_compliance=compliance),
    _start_sizes_of_layer,
    group="size",
)
COUPLING = Cause(
    "coupling",
    lambda variant, beta: replace(variant, dundurs_beta=beta),
    _start_sizes_of_coupling,
    component=SHEAR,
    largest_size=_LARGEST_BETA,
)
ODD_PART = Cause(
    "coupling",
    lambda variant, _: replace(variant, takes_odd_part=True),
    lambda discrepancy: (1.0,) if _start_sizes_of_coupling(discrepancy) else (),
    component=SHEAR,
    has_size=False,
)
OTHER_TIMES = Cause(
    "other_times",
    lambda variant, delay: replace(variant, delay=delay),
    _start_sizes_of_delay,
    group="history",
)
SHEAR_SIGN = Cause(
    "shear_sign",
    lambda variant, _: replace(variant, shear_factor=-variant.shear_factor),
    _start_sizes_where_shear(1.0),
    component=SHEAR,
    has_size=False,
)
SHEAR_FACTOR = Cause(
    "shear_factor",
    lambda variant, k: replace(variant, shear_factor=float(np.exp(k)) * variant.shear_factor),
    _start_sizes_of_shear_alone,
    component=SHEAR,
    group="friction",
)
FRICTIONLESS = Cause(
    "frictionless",
    lambda variant, _: replace(variant, shear_factor=0.0),
    _start_sizes_where_shear(1.0),
    component=SHEAR,
    group="history",
    has_size=False,
)
FRICTION = Cause(
    "friction",
    lambda variant, k: replace(variant, friction_factor=variant.friction_factor * float(np.exp(k))),
    _start_sizes_where_shear(*_LOGS_OF_FRICTION),
    component=SHEAR,
    group="friction",
    largest_size=_LARGEST_LOG_OF_FRICTION,
)
FULL_STICK = Cause(
    "full_stick",
    lambda variant, k: replace(variant, friction_factor=float(np.exp(k))),
    _start_sizes_where_shear(*_LOGS_OF_FRICTION_WITHOUT_SLIP),
    component=SHEAR,
    group="friction",
    has_size=False,
    largest_size=_LARGEST_LOG_OF_FRICTION,
)


def _cause_by_history(
    key: str, history_fault: str, start_sizes: Callable[[Discrepancy], Sequence[float]]
) -> Cause:
    """The cause (known fault of a result) that the history of friction is treated wrongly, in one
    way.

    Parameters
    ----------
    key
        of its sentence in templates/faults.toml
    history_fault
        what theory does to the history of friction to predict it, such as "no memory"
    start_sizes
        sizes from which a search for it starts; none where the file can't have it
    """
    # component: the traction that shows it; group: causes of which only one is named
    return Cause(
        key,
        lambda variant, _: replace(variant, history_fault=history_fault),
        start_sizes,
        component=SHEAR,
        group="history",
        has_size=False,
    )


def _cause_by_load(key: str) -> Cause:
    """The cause (known fault of a result) that a bulk stress or tilt has the wrong sign or is left
    out: `key` "tilt_sign", "tilt_left_out", "bulk_sign" or "bulk_left_out".
    """
    return Cause(
        key,
        lambda variant, _: replace(variant, wrong_load=key),
        _start_sizes_of_wrong_load(key),
        component=PRESSURE if key.startswith("tilt") else SHEAR,
        has_size=False,
    )


def _start_sizes_of_lost_memory(discrepancy: Discrepancy) -> Sequence[float]:
    return (1.0,) if _has_shear(discrepancy) and not discrepancy.unsymmetric else ()


CAUSES = (
    PRESSURE_SIGN,
    SWAPPED,
    UNITS,
    STIFFNESS,
    LOADS,
    TRACTION_FACTOR,
    PRESSURE_FACTOR,
    X_SCALE,
    OFFSET,
    COARSE_MESH,
    SMALL_BODY,
    SOFT_NORMAL,
    OTHER_TIMES,
    _cause_by_load("tilt_sign"),
    _cause_by_load("tilt_left_out"),
    SHEAR_SIGN,
    SHEAR_FACTOR,
    FRICTIONLESS,
    FRICTION,
    FULL_STICK,
    _cause_by_history("memoryless", "no memory", _start_sizes_of_lost_memory),
    _cause_by_history("not_steady", "first revolution", _start_sizes_on_cycle),
    _cause_by_history("steps", "straight steps", _start_sizes_on_cycle),
    _cause_by_history("steps", "end of steps", _start_sizes_of_short_steps),
    _cause_by_load("bulk_sign"),
    _cause_by_load("bulk_left_out"),
    COUPLING,
    ODD_PART,
)
