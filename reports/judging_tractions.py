"""The metrics of pressure and shear, with their worst instants and places."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reports import metrics_tractions as metrics
from reports.metrics import over
from reports.verdicts import Array, Metric, Pair, not_applicable, place_of, worst_metric

# Below this, in f p_ref, the shear of an instant is rounding and has no peak.
NO_SHEAR = 1e-9


def tractions(pair: Pair) -> Iterator[Metric]:
    """Every metric of pressure and shear."""
    expected, found, friction = pair.expected, pair.found, pair.scales.friction
    yield worst_metric(pair, "peak_pressure", metrics.peak_pressure(expected, found))
    yield worst_metric(pair, "pressure", metrics.pressure(expected, found))
    yield worst_metric(pair, "shear", metrics.shear(expected, found, friction))
    yield _placed(pair, "pressure_maximum", metrics.pressure_maximum(expected, found))
    yield _placed(pair, "shear_maximum", metrics.shear_maximum(expected, found, friction))
    yield worst_metric(pair, "peak_shear", metrics.peak_shear(expected, found, friction))
    yield _pressure_peak_place(pair)
    yield _shear_peak_place(pair)
    yield from _resultants(pair)


def _placed(pair: Pair, key: str, found: tuple[Array, Array]) -> Metric:
    series, places = found
    return place_of(pair, worst_metric(pair, key, series), places)


def _pressure_peak_place(pair: Pair) -> Metric:
    series = metrics.pressure_peak_place(pair.expected, pair.found, pair.scales.half_width)
    return _to_a_point(pair, worst_metric(pair, "pressure_peak_place", series), pair.found.pressure)


def _shear_peak_place(pair: Pair) -> Metric:
    series = metrics.shear_peak_place(pair.expected, pair.found, pair.scales.half_width)
    # Asked the other way round, a NaN would count as no shear and hide.
    sheared = pair.judged & ~(np.abs(pair.expected.shear).max(axis=1) <= NO_SHEAR * pair.scales.shear)
    if not sheared.any():
        return not_applicable("shear_peak_place", "the reference carries no shear")
    return _to_a_point(pair, worst_metric(pair, "shear_peak_place", series, sheared), np.abs(pair.found.shear))


def _to_a_point(pair: Pair, metric: Metric, field: Array) -> Metric:
    """`metric` with the place of the result's peak at its instant, and the local spacing of the points as its uncertainty."""
    return place_of(pair, metric, pair.found.x[np.argmax(field, axis=1)]).with_spacing(pair)


def _resultants(pair: Pair) -> Iterator[Metric]:
    """With the result's own weights nothing of the reference enters; by the trapezoidal rule the rule's own error is taken off."""
    weights, normals = (getattr(pair.result, name, None) for name in ("weights", "normals"))
    normal, tangential = metrics.resultants(pair.found, weights, normals)
    missing = normal - pair.found.normal_load, tangential - pair.found.tangential_load
    note = ""
    if weights is None:
        of_rule = metrics.resultants(pair.expected, None, None)
        missing = missing[0] - of_rule[0] + pair.expected.normal_load, missing[1] - of_rule[1] + pair.expected.tangential_load
        note = "the result states no weights, so by the trapezoidal rule, less what that misses of the reference"
    for key, series in zip(("resultant_normal", "resultant_tangential"), missing, strict=True):
        yield worst_metric(pair, key, over(series, pair.found.normal_load), note=note)
