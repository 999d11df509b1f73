"""What was worked out of a foreign result's fields is worked out of the reference's by the same rule, whose error drops out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.comparison.laws import derived
from reports.comparison.metrics import missing
from reports.scoring.solution import friction_work, permanent_stick
from reports.scoring.zones import Zones, zones
from scenes import ContactSolution, freeze

Array = NDArray[np.float64]

# Over a_ref; the rule errs by more only where slip has just turned and the tractions don't show it yet: see the notes of `zones`.
UNTOLD = 0.05


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
    fields = _Fields(reference.x, reference.pressure, reference.shear, slip)
    found = zones(fields, reference.scene.friction.coefficient, reference.time)
    told = _told(reference.stick_edges, found.stick_edges, length)
    words = [_edges_in_words(reference, found, told, length)]
    known: dict[str, Any] = {
        "state": freeze(found.state, np.int8),
        "contact_edges": freeze(found.contact_edges),
        "stick_edges": freeze(np.where(told[:, None], found.stick_edges, np.nan)),
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


def _told(own: Array, ruled: Array, length: float) -> NDArray[np.bool_]:
    """(n_steps,) instants at which the rule finds the reference's own stick edges; all, where those are the fewer."""
    lacking = np.isnan(own[:, 0]) != np.isnan(ruled[:, 0])
    off = np.max(np.abs(np.nan_to_num(own - ruled)), axis=1) > UNTOLD * length
    told = ~(lacking | off)
    return told if 2 * told.sum() > len(told) else np.ones_like(told)


def _edges_in_words(reference: ContactSolution, found: Zones, told: NDArray[np.bool_], length: float) -> str:
    pairs = (reference.contact_edges, found.contact_edges), (reference.stick_edges[told], found.stick_edges[told])
    contact, stick = (float(np.nanmax(np.abs(own - ruled), initial=0.0)) / length for own, ruled in pairs)
    where = (
        ""
        if told.all()
        else f"; at {int((~told).sum())} of {len(told)} instants it can't tell the stick edges, which are not judged"
    )
    return (
        "States and edges are told by one rule in the result and in the reference; against the reference's own it errs by up to "
        f"{contact:.1e} a_ref at the contact edge and {stick:.1e} a_ref at the stick edge{where}."
    )


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
