"""Is an answer admissible: does it obey the laws of contact, whoever is right? Needs no reference.

Two sources: what can be read off the fields of any ContactSolution (tension, cone, loads), and what only the engine
could see while it solved (equilibrium in its own weights, penetration, energy balance), which it wrote in its record.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenes import SLIP_FORWARD, SLIP_REVERSE, ContactSolution

Array = NDArray[np.float64]

# Algebra in double precision over some hundred steps leaves 1e-12 to 1e-10; a law that is broken shows above 1e-6.
LIMIT = 1e-9
# Of a foreign result: what a file of four printed digits leaves of a law that its code kept to rounding.
PRINTED = 1e-3
# Name of what was worked out from other fields of a foreign result -> nothing is checked with it that only repeats how.
DERIVED = "derived"


@dataclass(frozen=True, eq=False)
class Certificate:
    """One law, checked at every instant of the whole path.

    Attributes
    ----------
    name, source : what was checked, and "fields" or "record"
    series : (n_steps,), dimensionless violation, 0 is perfect
    value, time : its largest value and when
    limit : largest admitted value
    """

    name: str
    source: str
    series: Array
    value: float
    time: float
    limit: float = LIMIT

    @property
    def label(self) -> str:
        """Name and source: the same law may be seen in both."""
        return f"{self.name} ({self.source})"

    @property
    def holds(self) -> bool:
        """Whether the law is obeyed; a NaN does not hold."""
        return bool(self.value <= self.limit)


def derived(solution: ContactSolution) -> frozenset[str]:
    """Names of the fields that were worked out from others."""
    return frozenset(solution.settings.get(DERIVED, ()))


def certificates(solution: ContactSolution) -> tuple[Certificate, ...]:
    """Every certificate of `solution`: from its fields first, then from its record.

    Of a foreign result none that rests on a field worked out from the law itself, and the others to `PRINTED`.
    """
    from_fields = {"tension": _tension(solution)}
    if not np.isnan(solution.shear).all():
        from_fields["cone"] = _cone(solution)
    if "state" not in derived(solution):
        from_fields["slip"] = _slip(solution)
    if "normal_load" not in derived(solution):
        from_fields["loads"] = _loads(solution)
    limit = PRINTED if derived(solution) else LIMIT
    return tuple(
        _certificate(name, source, np.abs(np.asarray(series, dtype=float)), solution.time, limit)
        for source, found in (("fields", from_fields), ("record", solution.record.certificates))
        for name, series in found.items()
    )


def _certificate(name: str, source: str, series: Array, time: Array, limit: float) -> Certificate:
    worst = int(np.argmax(np.where(np.isnan(series), np.inf, series)))
    return Certificate(name.replace("_", " "), source, series, float(series[worst]), float(time[worst]), limit)


def _tension(solution: ContactSolution) -> Array:
    """max(-p) over the largest pressure of the path, (n_steps,)."""
    return np.maximum(-solution.pressure.min(axis=1), 0.0) / _largest_pressure(solution)


def _cone(solution: ContactSolution) -> Array:
    """max(|q| - f p) over f times the largest pressure (over the pressure itself where f = 0), (n_steps,)."""
    friction = solution.scene.friction.coefficient
    outside = np.max(np.abs(solution.shear) - friction * solution.pressure, axis=1)
    return np.maximum(outside, 0.0) / ((friction or 1.0) * _largest_pressure(solution))


def _slip(solution: ContactSolution) -> Array:
    """max|q -+ f p| of the points in forward (reverse) slip, over the same as the cone, (n_steps,): slip costs f p, against it."""
    friction = solution.scene.friction.coefficient
    sign = (solution.state == SLIP_FORWARD) * 1.0 - (solution.state == SLIP_REVERSE)
    short = np.max(np.abs(sign * solution.shear - friction * solution.pressure), axis=1, where=sign != 0, initial=0.0)
    return np.asarray(short / ((friction or 1.0) * _largest_pressure(solution)))


def _loads(solution: ContactSolution) -> Array:
    """Largest of |P - P(t)| and |Q - Q(t)| over the largest P, P(t) and Q(t) being the scene's, (n_steps,)."""
    normal, tangential = solution.scene.load.path().at(solution.time)
    off = np.maximum(np.abs(solution.normal_load - normal), np.abs(solution.tangential_load - tangential))
    return np.asarray(off / np.max(normal))


def _largest_pressure(solution: ContactSolution) -> float:
    return float(np.max(solution.pressure)) or 1.0
