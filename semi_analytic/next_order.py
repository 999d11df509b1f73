"""How large the next order of finite bodies is, N_4 and T_4 beside N and T, and what the orders
after it leave of the changes that the bodies make: what `corrected` and
`reports.advising_by_numbers` state.

With r = |N_4 a^2/N| the order after the next is 0.02 r + 0.1 r^2 of what N and its next order
change, likewise of T; the next order of tilt and bulk strain, which is not known, 0.6 of the larger
r of their change; and their product with the curvatures, which are not solved together, half of
both changes. 3e-5 of W is uncertain in any case.

Fitted to 133 random bodies under six load cycles (benchmarks/bound.py, seeds 49 to 51): of those
that are not declined 98 % are covered, at 3.9 times what is left.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from scenes import BodyEffects, Estimate
from scenes.body_effects import ZERO
from semi_analytic.body_numbers import NEXT_ORDER
from semi_analytic.odd_memory import ODD_NUMBERS

_AFTER_NEXT = (0.02, 0.1)
_NEXT_ORDER_OF_TILT_AND_STRAIN = 0.6
_PRODUCT = 0.5
LEAST_UNCERTAIN_FRACTION = 3e-5
"""Of a value that the bodies change: it is uncertain by this share whatever they are."""

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
"""The even numbers of `BodyEffects` by the load that they follow: the curvature that leads, that of
bodies without a mirror line, the next order.
"""


def ratio_of_next_order(effects: BodyEffects, half_width: float) -> float:
    """The larger of |N_4 a^2/N| and |T_4 a^2/T|, a being a half-width."""
    return max(_ratio(effects, curvature, half_width) for curvature, *_ in CURVATURES.values())


def uncertain_fraction_of_curvatures(effects: BodyEffects, half_width: float) -> dict[str, float]:
    """What is uncertain of the change that each curvature of finite bodies makes, as a share of
    that change, by the curvature in words.

    It is the error of the curvature's number, and what the order after the next may add;
    `half_width` is that of the contact [length].

    >>> effects = BodyEffects(
    ...     datum_length=1.0, normal_curvature=Estimate(1.0, 0.001), normal_fourth=Estimate(-0.5)
    ... )
    >>> {
    ...     name: round(left, 6)
    ...     for name, left in uncertain_fraction_of_curvatures(effects, 1.0).items()
    ... }
    {'curvature under P': 0.036, 'curvature under Q': 0.0}
    """
    return {
        words: _uncertain_fraction_of_curvature(effects, curvature, half_width)
        for words, (curvature, *_) in CURVATURES.items()
    }


def uncertain_fraction_of_tilt_and_strain(of_curvatures: float, ratio: float) -> float:
    """Of what tilt and bulk strain change of the dissipation, in its ratio, what is uncertain
    beside a change `of_curvatures`; `ratio` is that of `ratio_of_next_order`.
    """
    return _NEXT_ORDER_OF_TILT_AND_STRAIN * ratio + _PRODUCT * abs(of_curvatures)


def with_these_alone(effects: BodyEffects, words: str) -> BodyEffects:
    """The effects with nothing odd, and with one group of `CURVATURES` alone."""
    other_effects: dict[str, Any] = dict.fromkeys(ODD_NUMBERS, ZERO)
    for other_words, names in CURVATURES.items():
        if other_words != words:
            other_effects |= dict.fromkeys(names, ZERO)
    return replace(effects, **other_effects)


def without_next_order(effects: BodyEffects) -> BodyEffects:
    """The effects to the curvatures alone."""
    next_order: dict[str, Any] = dict.fromkeys(NEXT_ORDER, ZERO)
    return replace(effects, **next_order)


def has_next_order(effects: BodyEffects) -> bool:
    """Whether a number of the next order is not 0."""
    return any(getattr(effects, name).value for name in NEXT_ORDER)


def _uncertain_fraction_of_curvature(
    effects: BodyEffects, curvature: str, half_width: float
) -> float:
    estimate: Estimate = getattr(effects, curvature)
    if not estimate.value:
        return 0.0
    linear, square = _AFTER_NEXT
    ratio = _ratio(effects, curvature, half_width)
    return estimate.uncertainty / abs(estimate.value) + linear * ratio + square * ratio**2


def _ratio(effects: BodyEffects, curvature: str, half_width: float) -> float:
    """|N_4 a^2/N| of one curvature; 0 where there is none."""
    leading_estimate: Estimate = getattr(effects, curvature)
    if not leading_estimate.value:
        return 0.0
    fourth: Estimate = getattr(effects, curvature.replace("curvature", "fourth"))
    return abs(fourth.value / leading_estimate.value) * half_width**2
