"""What every answer proves of itself: tangential balance and Coulomb's cone at each instant, and in words how it ended."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import freeze

Array = NDArray[np.float64]


def certificates(
    friction: float, load: Array, balance: Array, fields: Mapping[str, NDArray[Any]], asked: Collection[str]
) -> dict[str, Array]:
    """|M(P) - Q| over f max P, and the largest |q| - f p over f max p where both are among the
    `asked`; both (n,) and 0 at best.

    `load` (n,) is P, `balance` (n,) what the pieces of the memory curve carry less what is applied, both per unit thickness.
    """
    tiny = np.finfo(float).tiny
    found = {"tangential_balance": freeze(np.abs(balance) / max(friction * float(np.max(load)), tiny))}
    if "pressure" in asked and "shear" in asked:
        # At the tip of a wedge p is infinite: no q is outside the cone there, and none is a measure of the others.
        bounded = np.isfinite(fields["pressure"])
        limit = friction * np.where(bounded, fields["pressure"], 0.0)
        beyond = np.max(np.abs(np.where(bounded, fields["shear"], 0.0)) - limit, axis=1, initial=0.0)
        found["cone"] = freeze(beyond / max(float(np.max(limit)), tiny))
    return found


def ending(followed: str, period: float | None, steady_from: int | None, cycles: int) -> tuple[str, str]:
    """(termination, message) of a history; `followed` is the message where it has no period.

    >>> ending("the path was followed to its end", 1.0, 1, 2)
    ('steady', 'cycle 2 ends in the state it started from')
    """
    if period is None:
        return "end of path", followed
    if steady_from is None:
        return "end of path", f"no steady cycle among the first {cycles}"
    return "steady", f"cycle {steady_from + 1} ends in the state it started from"
