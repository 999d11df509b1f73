"""The numbers of `BodyEffects`: which there are, and their check at the door."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from scenes import BodyEffects, Estimate, InputError
from scenes.arrays import LARGEST_NUMBER
from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES

NEXT_ORDER = ("normal_fourth", "tangential_fourth", "normal_mixed", "tangential_mixed")
"""Those of the order after the curvatures."""

NUMBERS = (
    "normal_compliance",
    "tangential_compliance",
    "normal_curvature",
    "tangential_curvature",
    "normal_curvature_under_shear",
    "tangential_curvature_under_pressure",
    *TILT_AND_STRAIN_NAMES,
    *NEXT_ORDER,
)
"""The numbers of `BodyEffects` that half-planes do not have."""


def checked_effects(effects: BodyEffects | None) -> BodyEffects | None:
    """The numbers by which finite bodies differ from half-planes, checked; None where all of them
    are 0, so that the bodies are half-planes. `NUMBERS` lists the attributes of `BodyEffects` that
    half-planes do not have, each an `Estimate` with a `value`.

    Raises
    ------
    InputError
        For what is no `BodyEffects` of finite numbers, up to LARGEST_NUMBER = 1e100, or has no
        datum length above 0.
    """
    if effects is None:
        return None
    if not isinstance(effects, BodyEffects):
        raise InputError(
            f"effects: a BodyEffects is needed, as halfplane_fe.body_effects(scene) makes it, not"
            f" {type(effects).__name__}"
        )
    # every attribute that is an Estimate
    for field in fields(effects):
        estimate = getattr(effects, field.name)
        if not isinstance(estimate, Estimate):
            continue
        value_as_array = np.asarray(estimate.value)
        is_real_number = value_as_array.ndim == 0 and np.issubdtype(value_as_array.dtype, np.number)
        if not (is_real_number and abs(float(value_as_array.real)) <= LARGEST_NUMBER):
            raise InputError(
                f"effects.{field.name}: a finite number is needed, not {estimate.value!r}"
            )
    if not 0 < effects.datum_length <= LARGEST_NUMBER:
        raise InputError(
            f"effects.datum_length: a length above 0 is needed, not {effects.datum_length!r}"
        )
    if all(getattr(effects, name).value == 0 for name in NUMBERS):
        return None
    return effects
