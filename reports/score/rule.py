"""What was worked out of a foreign result's fields is worked out of the reference's by the same rule, whose error drops out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.missing import derived, missing
from reports.score.solution import friction_work, permanent_stick
from reports.score.zones import Zones, zones
from scenes import ContactSolution, freeze

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Fields:
    x: Array
    pressure: Array
    shear: Array
    slip: Array | None


def by_same_rule(reference: ContactSolution, result: ContactSolution, length: float) -> tuple[ContactSolution, tuple[str, ...]]:
    """`reference` with states, edges and dissipation by the rules that gave `result` its own, and how far the rules are off.

    The metrics then are about the result and not about the rules. A result that states everything itself leaves the reference
    as it is; so does, of the dissipation, a reference on other instants than the result's.
    """
    if "state" not in derived(result):
        return reference, ()
    slip = None if "slip" in missing(result) else reference.slip
    found = zones(_Fields(reference.x, reference.pressure, reference.shear, slip), reference.scene.friction.coefficient)
    words = [_edges_in_words(reference, found, length)]
    known: dict[str, Any] = {
        "state": freeze(found.state, np.int8),
        "contact_edges": freeze(found.contact_edges),
        "stick_edges": freeze(found.stick_edges),
        "contact_half_width": freeze(np.diff(found.contact_edges, axis=1)[:, 0] / 2),
        "stick_half_width": freeze(np.diff(found.stick_edges, axis=1)[:, 0] / 2),
        "permanent_stick_half_width": permanent_stick(found.stick_edges[reference.last_cycle]),
    }
    same = len(reference.time) == len(result.time) and np.array_equal(reference.time, result.time)
    if same and "dissipation" not in missing(result):
        work, sentence = _dissipation(reference)
        known |= work
        words.append(sentence)
    return replace(reference, **known), tuple(words)


def _edges_in_words(reference: ContactSolution, found: Zones, length: float) -> str:
    off = [float(np.nanmax(np.abs(own - ruled), initial=0.0)) / length for own, ruled in _pairs(reference, found)]
    return (
        "States and edges are told by one rule in the result and in the reference; against the reference's own it errs by up to "
        f"{off[0]:.1e} a_ref at the contact edge and {off[1]:.1e} a_ref at the stick edge."
    )


def _pairs(reference: ContactSolution, found: Zones) -> tuple[tuple[Array, Array], ...]:
    return (reference.contact_edges, found.contact_edges), (reference.stick_edges, found.stick_edges)


def _dissipation(reference: ContactSolution) -> tuple[Mapping[str, Any], str]:
    """The reference's dissipation as the sum of q ds of its own fields on these instants, and how much that misses."""
    steps = reference.last_cycle
    density = friction_work(reference.shear[steps], reference.slip[steps])
    work = float(np.trapezoid(density, reference.x))
    known = {"dissipation": work, "dissipation_density": freeze(density), "cycle_dissipation": freeze([work])}
    share = 100 * (work / reference.dissipation - 1) if reference.dissipation else 0.0
    return known, (
        f"Dissipation is compared by one rule, the sum of q ds over {len(steps)} instants and {len(reference.x)} points of both; "
        f"of the reference that rule gives {share:+.2g} % more than its own."
    )
