"""Laws of a published table: one for each figure and each line of its chart, and the constants that the corrections take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.maps.atlas import Chart
from reports.maps.laws import Law, fit_law
from reports.maps.quadratic import Curvatures, dissipation_error, ellipse_path
from reports.maps.readings import Readings

Array = NDArray[np.float64]
_SHARE = 0.1  # of an error, its uncertainty where none was asked for
_PROBE = 0.02  # curvature at which the sensitivity of dissipation is taken


@dataclass(frozen=True)
class Line:
    """The points of a chart along its small parameter, other axes fixed at `at`, their law, and the exponent of its first term."""

    figure: str
    at: Mapping[str, str]
    s: Array
    error: Array
    uncertainty: Array
    law: Law | None
    order: float = 2.0

    @property
    def known(self) -> NDArray[np.bool_]:
        """Points that have an error and an uncertainty."""
        return np.isfinite(self.error) & np.isfinite(self.uncertainty)


def small_parameter(chart: Chart, readings: Readings) -> Array:
    """s (n,) of the rows."""
    across = readings.numbers(chart.across)
    return 1 / across if chart.inverse else np.abs(across)


def lines(chart: Chart, readings: Readings) -> Iterator[Line]:
    """Every line of every figure."""
    for figure in readings.figures:
        for at, part in readings.parts((chart.panels, chart.up)):
            s = small_parameter(chart, part)
            error, doubt = part.errors(figure)
            law = None
            order = chart.order(figure)
            if order is not None:
                unsure = doubt if np.isfinite(doubt).any() else _SHARE * np.abs(error)
                law = fit_law(s, error, unsure, order, chart.step)
            yield Line(figure, at, s, error, doubt, law, order or 2.0)


def along(line: Line, s: float) -> tuple[float, float]:
    """Error and uncertainty at s: error/s^n, n the line's order, is interpolated over log s and kept beyond the ends.

    Below the smallest point the law goes on; of its uncertainty nothing is gained.
    """
    order = np.argsort(line.s[line.known])
    at, *columns = (column[line.known][order] for column in (line.s, line.error, line.uncertainty))
    error, doubt = (float(np.interp(np.log(s), np.log(at), column / at**line.order)) for column in columns)
    return error * s**line.order, doubt * max(s, float(at[0])) ** line.order


def as_rows(study: str, found: Iterator[Line]) -> Iterator[dict[str, Any]]:
    """Laws as rows for laws.json."""
    for line in found:
        if line.law is not None:
            yield {"study": study, "figure": line.figure, **line.at, **asdict(line.law)}


def curvatures(laws: list[dict[str, Any]]) -> list[dict[str, float]]:
    """N and T of two equal blocks, sides free and base fixed, from the laws of p0 and dissipation under the paper's cycle.

    p0 moves by N/2 (a/h)^2; dissipation by (w_n N + w_t T) (a/h)^2, the sensitivities w from `quadratic`.
    """
    p, q, cycle = ellipse_path(1 / 3, 1.1 / 3, 1 / 3, np.pi / 2)
    ways = (Curvatures(_PROBE, 0.0), Curvatures(0.0, _PROBE))
    up = [dissipation_error(p, q, 1.0, way, cycle) for way in ways]
    down = [dissipation_error(p, q, 1.0, Curvatures(-w.normal, -w.tangential), cycle) for w in ways]
    by_normal, by_tangential = ((u - d) / (2 * _PROBE) for u, d in zip(up, down, strict=True))
    chosen = {(row["figure"], row["aspect"]): row for row in laws if row["study"] == "block" and row["base"] == "fixed"}
    found = []
    for (figure, aspect), pressure in chosen.items():
        work = chosen.get(("error.dissipation", aspect))
        if figure != "error.p0" or work is None:
            continue
        normal = 2 * pressure["sign"] * pressure["fixed"]
        tangential = (work["sign"] * work["fixed"] - by_normal * normal) / by_tangential
        doubt = abs(work["fixed_doubt"] / by_tangential) + abs(2 * pressure["fixed_doubt"] * by_normal / by_tangential)
        found.append(
            {
                "aspect": float(aspect),
                "normal": normal,
                "normal_doubt": 2 * pressure["fixed_doubt"],
                "tangential": tangential,
                "tangential_doubt": doubt,
            }
        )
    return found
