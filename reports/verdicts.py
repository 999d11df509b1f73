"""Whether an error lies within its tolerance; a metric with its value, worst instant and tolerance; the two cycles it is of."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.definition import Definition
from reports.definitions import DEFINITIONS
from reports.metrics import Scales, spacing_at
from reports.sampling import Cycle
from scenes import ContactSolution

Array = NDArray[np.float64]

# Instants with less than this share of P_ref are shown and not judged: on its way from or to the unloaded state a contact
# passes through sizes of a few elements and of one, where an error relative to its own traction measures the mesh only.
LIGHT = 0.1


class Verdict(StrEnum):
    """What an error and its uncertainty say of a tolerance."""

    WITHIN = "within"
    OUTSIDE = "outside"
    UNDECIDED = "undecided"


def verdict_on(error: float, tolerance: float, uncertainty: float | None = None) -> Verdict:
    """Whether `error` lies within `tolerance`, both in one unit.

    Within if |E| + u <= tolerance, outside if |E| - u > tolerance, else undecided. Where no uncertainty u is known, |E| alone
    decides. An error that is not finite is outside; an uncertainty that is not finite decides nothing.

    >>> print(verdict_on(-0.016, 0.05), verdict_on(-0.016, 0.05, 0.75), verdict_on(0.9, 0.05, 0.75))
    within undecided outside
    """
    if not math.isfinite(error):
        return Verdict.OUTSIDE
    doubt = 0.0 if uncertainty is None else uncertainty
    if abs(error) + doubt <= tolerance:
        return Verdict.WITHIN
    return Verdict.OUTSIDE if abs(error) - doubt > tolerance else Verdict.UNDECIDED


@dataclass(frozen=True, eq=False)
class Pair:
    """Reference and result, the one put on the other's points and instants: see `Comparison` for the names."""

    reference: ContactSolution
    result: ContactSolution
    polygon_reference: ContactSolution | None
    scales: Scales
    expected: Cycle
    found: Cycle

    @property
    def touching(self) -> NDArray[np.bool_]:
        """(k,) instants at which either carries pressure (a NaN counts as pressure: it must not hide)."""
        return (self.expected.pressure != 0).any(axis=1) | (self.found.pressure != 0).any(axis=1)

    @property
    def judged(self) -> NDArray[np.bool_]:
        """(k,) instants that a verdict is taken from."""
        return self.touching & (self.expected.normal_load >= LIGHT * self.scales.normal_load)


@dataclass(frozen=True, eq=False)
class Metric:
    """One discrepancy.

    Attributes
    ----------
    definition : its words
    value : of the last cycle, the worst where there is one at every instant; None where there is nothing to compare;
        not finite where the data is not
    time : instant of the worst value; None for a figure of the whole cycle
    tolerance : largest admitted |value|; None where the scene states none
    series : (k,) values at the instants of the last cycle (NaN: nothing to compare), or None
    note : what a reader must not miss
    elements : value in local element sizes of the result, where it states one
    absolute : whether the value is in the definition's absolute unit, the reference's own figure being 0
    place : where on the surface the worst value is, x/a_ref; None for what has no place
    uncertainty : how far the error budget, else the result's own statement or the spacing of points or instants, leaves the
        value open, in its unit; None where nobody states it
    spacings : value in local spacings of the result's points
    unmatched : whether a value that is not finite means an event without a counterpart, and not data that is no number
    """

    definition: Definition
    value: float | None
    time: float | None = None
    tolerance: float | None = None
    series: Array | None = None
    note: str = ""
    elements: float | None = None
    absolute: bool = False
    place: float | None = None
    uncertainty: float | None = None
    spacings: float | None = None
    unmatched: bool = False

    @property
    def key(self) -> str:
        """Name for programs."""
        return self.definition.key

    @property
    def label(self) -> str:
        """Name for people."""
        return self.definition.label

    @property
    def unit(self) -> str:
        """What the value is a share of, or its unit."""
        return self.definition.absolute_unit if self.absolute else self.definition.unit

    @property
    def verdict(self) -> Verdict | None:
        """`verdict_on` value, tolerance and uncertainty; None without a tolerance or a value. What is not finite is outside,
        tolerance or none, unless the only reason is that something has no counterpart.
        """
        if self.value is None:
            return None
        if self.tolerance is None:
            return None if np.isfinite(self.value) or self.unmatched else Verdict.OUTSIDE
        return verdict_on(self.value, self.tolerance, self.uncertainty)

    @property
    def accurate(self) -> bool | None:
        """Whether the verdict is "within": undecided counts as outside; None where there is no verdict."""
        return None if self.verdict is None else self.verdict is Verdict.WITHIN

    def with_spacing(self, pair: Pair) -> Metric:
        """This metric of a place that is known to a point: the local spacing of the points, in a_ref, as its uncertainty."""
        if self.place is None:
            return self
        length = pair.scales.half_width
        return replace(self, uncertainty=spacing_at(pair.found.x, self.place * length) / length)


def worst(series: Array, applies: NDArray[np.bool_], time: Array) -> tuple[float | None, float | None]:
    """The value of largest size and its instant among those that apply; a NaN among these is the worst there is.

    >>> worst(np.array([1.0, -3.0, 9.0]), np.array([True, True, False]), np.array([0.0, 0.5, 1.0]))
    (-3.0, 0.5)
    """
    if not applies.any():
        return None, None
    size = np.where(applies, np.where(np.isnan(series), np.inf, np.abs(series)), -1.0)
    place = int(np.argmax(size))
    return float(series[place]), float(time[place])


def tolerance_for(pair: Pair, key: str) -> float | None:
    """What the scene admits of a metric; None where it says nothing."""
    return getattr(pair.result.scene.tolerances, key, None)


def worst_metric(pair: Pair, key: str, series: Array, applies: NDArray[np.bool_] | None = None, **known: Any) -> Metric:
    """The metric of `series` (k,) at the worst of the instants that are judged, or that `applies` names."""
    value, time = worst(series, pair.judged if applies is None else applies, pair.found.time)
    return Metric(DEFINITIONS[key], value, time, tolerance_for(pair, key), series, **known)


def place_of(pair: Pair, metric: Metric, places: Array) -> Metric:
    """`metric` with the place of its worst value, of `places` (k,) [length], in a_ref."""
    if metric.time is None:
        return metric
    return replace(metric, place=float(places[pair.found.time == metric.time][0]) / pair.scales.half_width)


def not_applicable(key: str, why: str) -> Metric:
    """A metric that has nothing to compare, with the reason in words."""
    return Metric(DEFINITIONS[key], None, note=why)
