"""The metrics of rigid motion, hysteresis, dissipation and energy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reports import metrics_work as metrics
from reports.definitions import DEFINITIONS
from reports.units import signed
from reports.verdicts import Metric, Pair, not_applicable, tolerance_for, worst, worst_metric


def work(pair: Pair) -> Iterator[Metric]:
    """Every metric of rigid motion, hysteresis, dissipation and energy."""
    yield from _shifts(pair)
    smooth, ours, polygon = pair.reference, pair.result, pair.polygon_reference
    yield _dissipation(pair, "dissipation", smooth.dissipation, ours.dissipation)
    if polygon:
        yield _dissipation(pair, "dissipation_polygon", polygon.dissipation, ours.dissipation)
        yield _dissipation(pair, "dissipation_step", smooth.dissipation, polygon.dissipation)
    absolute = (ours.dissipation - smooth.dissipation) / pair.scales.dissipation
    yield Metric(DEFINITIONS["dissipation_absolute"], absolute)
    if pair.result.scene.load.path().period is None:
        yield not_applicable("hysteresis", "the path is not periodic: no loop")
    else:
        yield _dissipation(pair, "hysteresis", metrics.loop_work(pair.expected), metrics.loop_work(pair.found))
    yield from _density(pair)
    yield _energy_balance(pair)


def _shifts(pair: Pair) -> Iterator[Metric]:
    # Asked the other way round, a NaN would count as standing still and hide.
    moves = pair.judged & (not bool(np.ptp(pair.expected.tangential_displacement) <= 1e-12 * pair.scales.shift))
    for key, difference in (
        ("tangential_displacement", metrics.tangential_displacement),
        ("hysteresis_distance", metrics.loop_distance),
    ):
        note = "" if moves.any() else "the reference does not move sideways"
        yield worst_metric(pair, key, difference(pair.expected, pair.found, pair.scales.shift), moves, note=note)


def _dissipation(pair: Pair, key: str, expected: float, found: float) -> Metric:
    value, relative = metrics.dissipation(expected, found, pair.scales.dissipation)
    note = "the reference dissipates nothing, so the value is absolute" if key == "dissipation" and not relative else ""
    return Metric(DEFINITIONS[key], value, tolerance=tolerance_for(pair, key), note=note, absolute=not relative)


def _density(pair: Pair) -> Iterator[Metric]:
    """Pointwise dissipation: worst point, norm, peak and its place; absolute where the reference does no work."""
    length = pair.scales.half_width
    scale = pair.scales.dissipation / length
    expected, found = pair.expected, pair.found
    nothing = not metrics.dissipates(expected, scale)
    difference = metrics.dissipation_density(expected, found, scale)
    value, place = worst(difference, np.ones(len(difference), bool), found.x)
    note = "" if place is None or not value else f"at x = {signed(place / length)} a_ref"
    at = None if place is None else place / length
    yield Metric(DEFINITIONS["dissipation_density"], value, note=note, absolute=nothing, place=at)
    in_the_mean = metrics.density_norm(expected, found, scale, length)
    yield Metric(DEFINITIONS["dissipation_density_norm"], in_the_mean, absolute=nothing)
    yield Metric(DEFINITIONS["dissipation_density_peak"], metrics.density_peak(expected, found, scale), absolute=nothing)
    if nothing:
        yield not_applicable("dissipation_density_peak_place", "the reference dissipates nothing")
        return
    place = float(found.x[np.argmax(found.dissipation_density)]) / length
    shift = metrics.density_peak_place(expected, found, length)
    yield Metric(DEFINITIONS["dissipation_density_peak_place"], shift, place=place).with_spacing(pair)


def _energy_balance(pair: Pair) -> Metric:
    """From the record of the result, which alone knows what its bodies store."""
    balance = pair.result.record.certificates.get("energy_balance")
    if balance is None:
        return not_applicable("energy_balance", "the result records none")
    series = np.asarray(balance, dtype=float)[pair.result.last_cycle]
    return worst_metric(pair, "energy_balance", series, np.ones(len(series), bool))
