"""Every metric with its value, its worst instant and its tolerance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports import metrics
from reports.definitions import DEFINITIONS, Definition, name_of
from reports.metrics import Scales
from reports.sampling import Cycle
from scenes import ContactSolution

Array = NDArray[np.float64]

# Instants with less than this share of P_ref are shown and not judged: on its way from or to the unloaded state a contact
# passes through sizes of a few elements and of one, where an error relative to its own traction measures the mesh only.
LIGHT = 0.1


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
    """

    definition: Definition
    value: float | None
    time: float | None = None
    tolerance: float | None = None
    series: Array | None = None
    note: str = ""
    elements: float | None = None
    absolute: bool = False

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
    def accurate(self) -> bool | None:
        """Whether |value| <= tolerance; None without a tolerance or a value. What is not finite is not accurate."""
        if self.tolerance is None or self.value is None:
            return None
        return bool(abs(self.value) <= self.tolerance)


def judge(pair: Pair) -> tuple[Metric, ...]:
    """Every metric, in the order of the table."""
    return (*_through_the_cycle(pair), *_of_the_cycle(pair))


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


def _tolerance(pair: Pair, key: str) -> float | None:
    return getattr(pair.result.scene.tolerances, key, None)


def _worst_metric(pair: Pair, key: str, series: Array, applies: NDArray[np.bool_] | None = None) -> Metric:
    value, time = worst(series, pair.judged if applies is None else applies, pair.found.time)
    return Metric(DEFINITIONS[key], value, time, _tolerance(pair, key), series)


def _through_the_cycle(pair: Pair) -> Iterator[Metric]:
    """The metrics that have a value at every instant."""
    expected, found = pair.expected, pair.found
    yield _worst_metric(pair, "peak_pressure", metrics.peak_pressure(expected, found))
    yield _worst_metric(pair, "pressure", metrics.pressure(expected, found))
    yield _worst_metric(pair, "shear", metrics.shear(expected, found, pair.scales.friction))
    yield _contact_edge(pair)
    yield _stick_edge(pair)
    state = metrics.state_disagreement(expected, found)
    yield Metric(DEFINITIONS["state"], metrics.mean_over_time(state, pair.touching, found.time), series=state)
    shift = metrics.rigid_shift(expected, found, pair.scales.shift)
    moves = bool(np.ptp(expected.rigid_shift) > 1e-12 * pair.scales.shift)
    yield _worst_metric(pair, "rigid_shift", shift, pair.judged & moves)


def _elements(pair: Pair, value: float | None) -> float | None:
    """An edge's shift in local element sizes of the result, which it states as `settings["element_size"]` [length]."""
    size = pair.result.settings.get("element_size")
    return value * pair.scales.half_width / float(size) if size and value is not None else None


def _contact_edge(pair: Pair) -> Metric:
    series = metrics.edge(pair.expected.contact_edges, pair.found.contact_edges, pair.scales.half_width)
    value, time = worst(series, pair.judged, pair.found.time)
    return Metric(
        DEFINITIONS["contact_edge"],
        value,
        time,
        _tolerance(pair, "contact_edge"),
        series,
        elements=_elements(pair, value),
    )


def _stick_edge(pair: Pair) -> Metric:
    """Compared where both have stick edges (in full stick: the contact edges); other instants are counted, not hidden."""
    length = pair.scales.half_width
    series = metrics.edge(pair.expected.stick_edges, pair.found.stick_edges, length)
    theirs, ours = (metrics.stick_status(cycle, length) for cycle in (pair.expected, pair.found))
    value, time = worst(series, pair.judged & (theirs != 0) & (ours != 0), pair.found.time)
    differing, instants = int((theirs != ours)[pair.judged].sum()), int(pair.judged.sum())
    note = f"{differing} of {instants} instants differ in full stick, partial slip or full slip" if differing else ""
    if value is None and differing:
        value, note = float("nan"), f"no instant has a stick edge in both: {note}"
    return Metric(
        DEFINITIONS["stick_edge"],
        value,
        time,
        _tolerance(pair, "stick_edge"),
        series,
        note,
        _elements(pair, value),
    )


def _of_the_cycle(pair: Pair) -> Iterator[Metric]:
    """The metrics that are one figure for the whole cycle."""
    smooth, ours, polygon = pair.reference, pair.result, pair.polygon_reference
    yield _dissipation(pair, "dissipation", smooth.dissipation, ours.dissipation)
    if polygon:
        yield _dissipation(pair, "dissipation_polygon", polygon.dissipation, ours.dissipation)
        yield _dissipation(pair, "dissipation_step", smooth.dissipation, polygon.dissipation)
    if pair.result.scene.load.path().period is None:
        yield Metric(DEFINITIONS["hysteresis"], None, note="the path is not periodic: no loop")
    else:
        yield _dissipation(pair, "hysteresis", metrics.loop_work(pair.expected), metrics.loop_work(pair.found))
    yield _density(pair)
    yield _permanent_stick(pair)


def _dissipation(pair: Pair, key: str, expected: float, found: float) -> Metric:
    value, relative = metrics.dissipation(expected, found, pair.scales.dissipation)
    note = "the reference dissipates nothing, so the value is absolute" if key == "dissipation" and not relative else ""
    return Metric(DEFINITIONS[key], value, tolerance=_tolerance(pair, key), note=note, absolute=not relative)


def _density(pair: Pair) -> Metric:
    scale = pair.scales.dissipation / pair.scales.half_width
    difference = metrics.dissipation_density(pair.expected, pair.found, scale)
    nothing = float(np.max(np.abs(pair.expected.dissipation_density))) <= metrics.NO_DISSIPATION * scale
    value, place = worst(difference, np.ones(len(difference), bool), pair.found.x)
    note = "" if place is None or not value else f"at x = {place / pair.scales.half_width:.4g} a_ref"
    return Metric(DEFINITIONS["dissipation_density"], value, note=note, absolute=nothing)


def _permanent_stick(pair: Pair) -> Metric:
    lacking = [s.engine for s in (pair.reference, pair.result) if np.isnan(s.permanent_stick_half_width)]
    if lacking:
        return Metric(DEFINITIONS["permanent_stick"], None, note=f"none in {' and '.join(name_of(engine) for engine in lacking)}")
    difference = pair.result.permanent_stick_half_width - pair.reference.permanent_stick_half_width
    return Metric(DEFINITIONS["permanent_stick"], difference / pair.scales.half_width)
