"""What a solution does not hold, and which metrics can't be had without it: they are left out with the reason, never guessed.

An engine that was not asked for a field, and a foreign result that lacks one, say so alike: in `work.skipped`, under the name of
the quantity, with the reason.
"""

from __future__ import annotations

from collections.abc import Mapping

from reports.definitions import name_of
from reports.verdicts import Metric, not_applicable
from scenes import ContactSolution

WHOLE_CYCLE = "whole_cycle"
# Name of what was worked out from other fields of a foreign result -> nothing is checked with it that only repeats how.
DERIVED = "derived"

_WORK = ("dissipation", WHOLE_CYCLE)
_DENSITY = ("dissipation_density", WHOLE_CYCLE)
_THROUGH = ("state", WHOLE_CYCLE)
NEEDS: Mapping[str, tuple[str, ...]] = {
    "pressure": ("pressure",),
    "peak_pressure": ("pressure",),
    "pressure_maximum": ("pressure",),
    "pressure_peak_place": ("pressure",),
    "resultant_normal": ("pressure",),
    "shear": ("shear",),
    "shear_maximum": ("shear",),
    "peak_shear": ("shear",),
    "shear_peak_place": ("shear",),
    "resultant_tangential": ("shear",),
    "tangential_displacement": ("tangential_displacement",),
    "hysteresis": ("tangential_displacement", WHOLE_CYCLE),
    "hysteresis_distance": ("tangential_displacement", WHOLE_CYCLE),
    "dissipation": _WORK,
    "dissipation_polygon": _WORK,
    "dissipation_absolute": _WORK,
    "dissipation_density": _DENSITY,
    "dissipation_density_norm": _DENSITY,
    "dissipation_density_peak": _DENSITY,
    "dissipation_density_peak_place": _DENSITY,
    "permanent_stick": _THROUGH,
    "full_stick_start": _THROUGH,
    "full_stick_end": _THROUGH,
    "slip_reversal": _THROUGH,
    "stick_set": _THROUGH,
    "state": ("state",),
    "slip": ("slip",),
    "slip_maximum": ("slip",),
}
_WORDS = {WHOLE_CYCLE: "whole cycle", "dissipation_density": "pointwise dissipation"}


def missing(solution: ContactSolution) -> dict[str, str]:
    """Quantity -> why the solution does not hold it."""
    known = {quantity for needs in NEEDS.values() for quantity in needs}
    return {name: reason for name, (_, reason) in solution.work.skipped.items() if name in known}


def derived(solution: ContactSolution) -> frozenset[str]:
    """Names of the fields that were worked out from others."""
    return frozenset(solution.settings.get(DERIVED, ()))


def without_missing(metrics: tuple[Metric, ...], *solutions: ContactSolution) -> tuple[Metric, ...]:
    """`metrics`, those that need what one of `solutions` lacks without value, and with the reason."""
    return tuple(_without(metric, solutions) for metric in metrics)


def _without(metric: Metric, solutions: tuple[ContactSolution, ...]) -> Metric:
    for solution in solutions:
        lacking = missing(solution)
        for quantity in NEEDS.get(metric.key, ()):
            if quantity in lacking:
                words = _WORDS.get(quantity, quantity.replace("_", " "))
                return not_applicable(metric.key, f"{words}: {lacking[quantity]} ({name_of(solution.engine)})")
    return metric
