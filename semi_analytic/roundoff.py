"""What the last digits of the loads cost where next to nothing slips: the front of slip P_c is known to a digit of P.

# notation: P_c load at the front of slip; d = P - P_c the load that has slipped, W ~ d^3 and s ~ d^(3/2) where d is small
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
_REPEATS, _OF_SLIP, _LEAST = 1e-12, 1e-4, 2e-14
LAST_DIGITS = 4 * _EPS
"""Share of P by which P_c may be off: measured 1 to 3 last digits on cycles of constant P with d/P from 1e-4 to 1e-14."""

PROMISED = 1e-12
"""Closed forms promise that much, see `errors`; what rounding adds is told where it is more."""


def repeats_within(share: float) -> float:
    """Share of f P within which a cycle counts as repeated: 1e-12, but no more than 1e-4 of what slips (`share` of P)."""
    return min(_REPEATS, max(_OF_SLIP * share, _LEAST))


def rounding_of_slip(share: float) -> float:
    """Relative error of d = `share` P by the last digits of P; 0 where that is below what closed forms promise, or nothing slips.

    Three times as much counts for W, eight times for the slip s: one and a half by its power of d, the rest by the digits of
    kernels that cancel. Measured: up to 4.5 times, on a short flat face.
    """
    error = LAST_DIGITS / share if share > 0 else 0.0
    return error if 8 * error > PROMISED else 0.0


def rounding_of_shift(friction: float, moments: Array, shifts: Array) -> float:
    """Relative error of the tangential displacement by the last digits of a sum of f int ln(2 L/a) d eta = f `moments`
    that cancels, (n,) each.

    `shifts` in the same unit, int M' ln(2 L/a) d eta; 0 where the error is below what closed forms promise, or nothing shifts.
    """
    largest = float(np.max(np.abs(shifts)))
    error = 2 * LAST_DIGITS * friction * float(np.max(np.abs(moments))) / largest if largest > 0 else 0.0
    return error if error > PROMISED else 0.0
