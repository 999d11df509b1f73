"""How large the fourth order of finite bodies, N_4 and T_4, is beside their curvatures N and T, and
which fraction of the changes of a value by the bodies stays uncertain: what `corrected` and
`reports.advising_by_numbers` state.

With r = |N_4 a^2/N| the order after the fourth is taken as 0.02 r + 0.1 r^2 of the change by N and
N_4; likewise for T. The next order of tilt and bulk strain is not known; it is taken as the larger
r times 0.6 of their change. Tilt and strain are not solved together with the curvatures; that is
taken as half the product of both changes. 3e-5 of a value is uncertain in any case.

Fitted to 133 random bodies under six load cycles (benchmarks/bound.py, seeds 49 to 51): of those
that are not declined 98 % are covered, the uncertainty being 3.9 times the error.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from scenes import BodyEffects, Estimate
from scenes.body_effects import ZERO_ESTIMATE
from semi_analytic.body_numbers import NEXT_ORDER
from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES

# Factors of r and of r^2: the order after the fourth. Fitted with the next two numbers, see above.
_FACTORS_OF_SIXTH_ORDER = (0.02, 0.1)
_NEXT_ORDER_OF_TILT_AND_STRAIN = 0.6
_FACTOR_ON_PRODUCT = 0.5
LEAST_UNCERTAIN_FRACTION = 3e-5
"""Relative uncertainty of a value that the bodies change, whatever they are."""

CURVATURES = {
    "curvature under P": (
        "normal_curvature",
        "tangential_curvature_under_pressure",
        "normal_fourth",
        "normal_mixed",
    ),
    "curvature under Q": (
        "tangential_curvature",
        "normal_curvature_under_shear",
        "tangential_fourth",
        "tangential_mixed",
    ),
}
"""The numbers of `BodyEffects` that are even in x, by the load that they follow.

Each tuple holds, in this order: the curvature N or T; the curvature that the same load causes in
the other displacement, of bodies without a mirror line; N_4 or T_4; N_22 or T_22.
"""


def ratio_of_next_order(effects: BodyEffects, half_width: float) -> float:
    """The larger of |N_4 a^2/N| and |T_4 a^2/T|, fourth order over curvature; a is `half_width`.
    0 for a curvature that is 0.
    """
    return max(
        _ratio_to_curvature(effects, name_of_curvature, half_width)
        for name_of_curvature, *_ in CURVATURES.values()
    )


def uncertain_fraction_of_curvatures(effects: BodyEffects, half_width: float) -> dict[str, float]:
    """Relative uncertainty of the change of a value by the curvatures of finite bodies: a fraction
    for those under P and a fraction for those under Q, by the names "curvature under P" and
    "curvature under Q".

    A curvature is not one of the profile but a term of the bodies' elastic response: N per P is
    that of the gap, T per Q that of the tangential displacement. N and N_4 are `normal_curvature`
    and `normal_fourth` of `effects`, T and T_4 `tangential_curvature` and `tangential_fourth`.

    The uncertainty is the relative one of the curvature itself, plus the order after the fourth,
    0.02 r + 0.1 r^2 with r = |N_4 a^2/N|, or |T_4 a^2/T|. a is the `half_width` of contact
    [length]. The two factors are fitted to 133 random bodies. 0 for a curvature that is 0.

    CURVATURES lists for each name the attributes of `effects`, the leading curvature first.

    >>> effects = BodyEffects(
    ...     datum_length=1.0, normal_curvature=Estimate(1.0, 0.001), normal_fourth=Estimate(-0.5)
    ... )
    >>> {
    ...     name: round(fraction, 6)
    ...     for name, fraction in uncertain_fraction_of_curvatures(effects, 1.0).items()
    ... }
    {'curvature under P': 0.036, 'curvature under Q': 0.0}
    """
    return {
        name_of_group: _uncertain_fraction_of_curvature(effects, name_of_curvature, half_width)
        for name_of_group, (name_of_curvature, *_) in CURVATURES.items()
    }


def uncertain_fraction_of_tilt_and_strain(change_by_curvatures: float, ratio: float) -> float:
    """Relative uncertainty of the change of the dissipation by tilt and bulk strain: their next
    order, and their product with the curvatures.

    `change_by_curvatures` is the relative change of the dissipation by the curvatures. `ratio` is
    that of the fourth order to the curvatures, the larger of |N_4 a^2/N| and |T_4 a^2/T|.
    """
    return _NEXT_ORDER_OF_TILT_AND_STRAIN * ratio + _FACTOR_ON_PRODUCT * abs(change_by_curvatures)


def with_one_group_alone(effects: BodyEffects, name_of_group: str) -> BodyEffects:
    """The `effects` of finite bodies with the curvatures under one load alone: those of all other
    groups, tilt and bulk strain are set to 0.

    `name_of_group` is "curvature under P" or "curvature under Q", a key of `CURVATURES`.
    """
    effects_set_to_zero: dict[str, Any] = dict.fromkeys(TILT_AND_STRAIN_NAMES, ZERO_ESTIMATE)
    for group, names_of_curvatures in CURVATURES.items():
        if group != name_of_group:
            effects_set_to_zero |= dict.fromkeys(names_of_curvatures, ZERO_ESTIMATE)
    return replace(effects, **effects_set_to_zero)


def without_next_order(effects: BodyEffects) -> BodyEffects:
    """The `effects` with the numbers of fourth order set to 0."""
    effects_set_to_zero: dict[str, Any] = dict.fromkeys(NEXT_ORDER, ZERO_ESTIMATE)
    return replace(effects, **effects_set_to_zero)


def has_next_order(effects: BodyEffects) -> bool:
    """Whether any number of fourth order is not 0."""
    return any(getattr(effects, name).value for name in NEXT_ORDER)


def _uncertain_fraction_of_curvature(
    effects: BodyEffects, name_of_curvature: str, half_width: float
) -> float:
    """Relative uncertainty of the change of a value by one curvature of finite bodies, N or T; 0
    where the curvature is 0.

    It is that of the curvature itself plus that by the order after the fourth, 0.02 r + 0.1 r^2.
    r is |N_4 a^2/N| or |T_4 a^2/T|, a the `half_width` of contact. The attribute of `effects` with
    the `name_of_curvature` is N or T.
    """
    curvature: Estimate = getattr(effects, name_of_curvature)
    if not curvature.value:
        return 0.0
    linear_factor, square_factor = _FACTORS_OF_SIXTH_ORDER
    ratio = _ratio_to_curvature(effects, name_of_curvature, half_width)
    uncertainty_of_curvature = curvature.uncertainty / abs(curvature.value)
    return uncertainty_of_curvature + linear_factor * ratio + square_factor * ratio**2


def _ratio_to_curvature(effects: BodyEffects, name_of_curvature: str, half_width: float) -> float:
    """|N_4 a^2/N| or |T_4 a^2/T|, fourth order over curvature; 0 where the curvature is 0.

    The attribute of `effects` with the `name_of_curvature` is N or T; a is the `half_width`.
    """
    curvature: Estimate = getattr(effects, name_of_curvature)
    if not curvature.value:
        return 0.0
    fourth_order: Estimate = getattr(effects, name_of_curvature.replace("curvature", "fourth"))
    return abs(fourth_order.value / curvature.value) * half_width**2
