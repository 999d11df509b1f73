"""An answer of the finite elements beside half-plane theory, on its own points and instants, as `halfplane run` compares them."""

from __future__ import annotations

import semi_analytic
from reports import Comparison, compare
from scenes import ContactSolution


def beside_theory(result: ContactSolution) -> Comparison:
    """The comparison, with theory on the polygon of the result's own increments."""
    reference, polygon = (
        semi_analytic.solve(result.scene, x=result.x, time=result.time, straight_steps=straight) for straight in (False, True)
    )
    return compare(reference, result, polygon_reference=polygon)
