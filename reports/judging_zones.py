"""The metrics of contact, stick and slip, with their worst instants and places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from reports import metrics_zones as metrics
from reports.definitions import DEFINITIONS, name_of
from reports.metrics import mean_over_time, spacing_at, worst_point
from reports.metrics_instants import Changes, full_stick, reversals
from reports.verdicts import Metric, Pair, not_applicable, place_of, tolerance_for, worst, worst_metric

SIDES = ("left", "right")
OF_FRICTION = (
    "stick_edge_left",
    "stick_edge_right",
    "stick_set",
    "full_stick_start",
    "full_stick_end",
    "slip_reversal",
    "slip",
    "slip_maximum",
)


def zones(pair: Pair) -> Iterator[Metric]:
    """Every metric of contact, stick and slip."""
    yield _contact_edge(pair)
    yield _stick_edge(pair)
    state = metrics.state_disagreement(pair.expected, pair.found)
    yield Metric(DEFINITIONS["state"], mean_over_time(state, pair.touching, pair.found.time), series=state)
    yield from (_edge_of_side(pair, "contact", side) for side in SIDES)
    yield _permanent_stick(pair)
    if not pair.result.scene.friction.coefficient:
        yield from (not_applicable(key, "frictionless: nothing sticks and nothing resists slip") for key in OF_FRICTION)
        return
    yield from (_edge_of_side(pair, "stick", side) for side in SIDES)
    yield _stick_set(pair)
    yield from _instants(pair)
    yield from _slip(pair)


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
        tolerance_for(pair, "contact_edge"),
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
        tolerance_for(pair, "stick_edge"),
        series,
        note,
        _elements(pair, value),
    )


def _edge_of_side(pair: Pair, kind: str, side: str) -> Metric:
    """One edge by itself, also in local spacings, with the uncertainty that the result states."""
    length, column = pair.scales.half_width, SIDES.index(side)
    expected, found = (getattr(cycle, f"{kind}_edges") for cycle in (pair.expected, pair.found))
    series = metrics.edge_of_side(expected, found, column, length)
    applies = pair.judged
    if kind == "stick":
        applies = applies & np.all([metrics.stick_status(cycle, length) != 0 for cycle in (pair.expected, pair.found)], axis=0)
        if not applies.any():
            return not_applicable(f"stick_edge_{side}", "no instant has a stick edge in both")
    metric = place_of(pair, worst_metric(pair, f"{kind}_edge_{side}", series, applies), found[:, column])
    if metric.place is None or metric.value is None or not np.isfinite(metric.place):
        return metric
    spacing = spacing_at(pair.found.x, metric.place * length)
    stated = getattr(pair.result, f"{kind}_edge_uncertainty", None)
    at = pair.found.time == metric.time
    return replace(
        metric,
        spacings=metric.value * length / spacing,
        uncertainty=None if stated is None else float(stated[pair.result.last_cycle][at, column][0]) / length,
    )


def _stick_set(pair: Pair) -> Metric:
    value = metrics.stick_set(pair.expected, pair.found)
    return not_applicable("stick_set", "nothing sticks in either") if np.isnan(value) else Metric(DEFINITIONS["stick_set"], value)


def _instants(pair: Pair) -> Iterator[Metric]:
    periodic = pair.result.scene.load.path().period is not None
    start, end = full_stick(pair.expected, pair.found, pair.scales.half_width, periodic)
    yield _change(pair, "full_stick_start", start, "the reference does not come into full stick")
    yield _change(pair, "full_stick_end", end, "the reference does not come out of full stick")
    yield _change(pair, "slip_reversal", reversals(pair.expected, pair.found, periodic), "slip does not reverse in either")


def _change(pair: Pair, key: str, change: Changes, none: str) -> Metric:
    """The worst of the differences of instants; those without a counterpart are counted in the note."""
    counts = ((change.missing, "the reference's", "result"), (change.extra, "the result's", "reference"))
    notes = [f"{count} of {whose} without a counterpart in the {other}" for count, whose, other in counts if count]
    if not len(change.late):
        return not_applicable(key, "; ".join([none, *notes]))
    everywhere = np.ones(len(change.late), dtype=bool)
    value, time = worst(change.late, everywhere, pair.found.time[change.index])
    step = float(np.max(np.diff(pair.found.fraction), initial=0.0))
    return Metric(
        DEFINITIONS[key], value, time, note="; ".join(notes), uncertainty=step, unmatched=bool(change.missing + change.extra)
    )


def _slip(pair: Pair) -> Iterator[Metric]:
    """Where both are in contact: apart from there it is a displacement and nothing slips."""
    scale = pair.scales.compliance * pair.scales.shear * pair.scales.half_width / 2
    difference, lengths, relative = metrics.slip(pair.expected, pair.found, scale)
    applies = pair.judged & (lengths.sum(axis=1) > 0)
    if not applies.any():
        yield from (not_applicable(key, "no instant has points in contact in both") for key in ("slip", "slip_maximum"))
        return
    yield worst_metric(pair, "slip", metrics.slip_norm(difference, lengths), applies, absolute=not relative)
    series, places = worst_point(np.where(lengths > 0, difference, 0.0), pair.found.x)
    yield place_of(pair, worst_metric(pair, "slip_maximum", series, applies, absolute=not relative), places)


def _permanent_stick(pair: Pair) -> Metric:
    lacking = [s.engine for s in (pair.reference, pair.result) if np.isnan(s.permanent_stick_half_width)]
    if lacking:
        return Metric(DEFINITIONS["permanent_stick"], None, note=f"none in {' and '.join(name_of(engine) for engine in lacking)}")
    difference = pair.result.permanent_stick_half_width - pair.reference.permanent_stick_half_width
    return Metric(DEFINITIONS["permanent_stick"], difference / pair.scales.half_width)
