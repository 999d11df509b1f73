"""The table of verdicts: every metric with its tolerance, its worst instant and its definition."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports import metrics
from reports.metrics import Scales
from reports.sampling import Cycle
from scenes import ContactSolution

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Metric:
    """One discrepancy.

    Attributes
    ----------
    key, label, unit : "shear", "Shear traction", "f ||p||": what the value is a share of
    value : the worst of the last cycle, signed where a sign has a meaning; None where there is nothing to compare;
        not finite where the data is not
    tolerance : largest admitted |value|; None where the scene states none
    time : instant of the worst value; None for a figure of the whole cycle
    series : (k,) values at the instants of the last cycle (NaN: nothing to compare), or None
    definition, note : what exactly was computed; what a reader must not miss
    elements : value in local element sizes of the result, where it states one
    """

    key: str
    label: str
    unit: str
    value: float | None
    time: float | None
    definition: str
    tolerance: float | None = None
    series: Array | None = None
    note: str = ""
    elements: float | None = None

    @property
    def accurate(self) -> bool | None:
        """Whether |value| <= tolerance; None without a tolerance or a value. What is not finite is not accurate."""
        if self.tolerance is None or self.value is None:
            return None
        return bool(abs(self.value) <= self.tolerance)


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


def through_the_cycle(expected: Cycle, found: Cycle, scales: Scales, result: ContactSolution) -> tuple[Metric, ...]:
    """The metrics that have a value at every instant, each with the worst one."""
    tolerances, time = result.scene.tolerances, found.time
    touching = (expected.pressure != 0).any(axis=1) | (found.pressure != 0).any(axis=1)
    peak = metrics.peak_pressure(expected, found)
    pressure = metrics.pressure(expected, found)
    shear = metrics.shear(expected, found, scales.friction)
    state = metrics.state_disagreement(expected, found)
    return (
        Metric(
            "peak_pressure",
            "Peak pressure",
            "of the reference's peak",
            *worst(peak, touching, time),
            "largest p less largest p_ref, over largest p_ref; both over the same points",
            tolerances.peak_pressure,
            peak,
        ),
        Metric(
            "pressure",
            "Pressure, L2",
            "of ‖p‖",
            *worst(pressure, touching, time),
            "L2 norm over x of p less p_ref, over the norm of p_ref",
            tolerances.pressure,
            pressure,
        ),
        Metric(
            "shear",
            "Shear traction, L2",
            "of f ‖p‖",
            *worst(shear, touching, time),
            "L2 norm over x of q less q_ref, over f times the norm of p_ref",
            tolerances.shear,
            shear,
        ),
        _edge_metric("contact_edge", "Contact edge", expected, found, scales, result, touching),
        _edge_metric("stick_edge", "Stick edge", expected, found, scales, result, touching),
        Metric(
            "state",
            "Stick/slip map",
            "of the length in contact",
            metrics.mean_over_time(state, touching, time),
            None,
            "share of the length in contact whose state (open, stick, forward or reverse slip) differs, mean over the cycle",
            series=state,
        ),
        _shift_metric(expected, found, scales, touching),
    )


def _edge_metric(
    key: str,
    label: str,
    expected: Cycle,
    found: Cycle,
    scales: Scales,
    result: ContactSolution,
    touching: NDArray[np.bool_],
) -> Metric:
    """The worse edge, in a_ref and in elements; stick edges only where both have them."""
    edges = "contact_edges" if key == "contact_edge" else "stick_edges"
    series = metrics.edge(getattr(expected, edges), getattr(found, edges), scales.half_width)
    applies, note, differing = touching, "", 0
    if key == "stick_edge":
        theirs, ours = (metrics.stick_status(cycle, scales.half_width) for cycle in (expected, found))
        applies = touching & (theirs != 0) & (ours != 0)
        differing = int((theirs != ours).sum())
        note = f"{differing} of {len(theirs)} instants differ in full stick, partial slip or full slip" if differing else ""
    value, time = worst(series, applies, found.time)
    if value is None and differing:
        value, note = float("nan"), f"no instant has a stick edge in both: {note}"
    size = result.settings.get("element_size")
    return Metric(
        key,
        label,
        "of a_ref",
        value,
        time,
        "outward shift of the worse edge" + (", where both have one" if key == "stick_edge" else ""),
        getattr(result.scene.tolerances, key),
        series,
        note,
        value * scales.half_width / float(size) if value is not None and size else None,
    )


def _shift_metric(expected: Cycle, found: Cycle, scales: Scales, touching: NDArray[np.bool_]) -> Metric:
    series = metrics.rigid_shift(expected, found, scales.shift)
    moves = bool(np.ptp(expected.rigid_shift) > 1e-12 * scales.shift)
    return Metric(
        "rigid_shift",
        "Rigid shift",
        "of the reference's stroke",
        *worst(series, touching & moves, found.time),
        "U less U_ref over the range of U_ref in the cycle",
        series=series,
        note="" if moves else "the reference does not move",
    )


def of_the_cycle(
    reference: ContactSolution,
    result: ContactSolution,
    polygon_reference: ContactSolution | None,
    expected: Cycle,
    found: Cycle,
    scales: Scales,
) -> tuple[Metric, ...]:
    """The metrics that are one figure for the whole cycle."""
    tolerance, scale = result.scene.tolerances.dissipation, scales.dissipation
    against: list[tuple[str, str, ContactSolution, ContactSolution, float | None, str]] = [
        ("dissipation", "Dissipation", reference, result, tolerance, "W less W_ref, both of the last cycle")
    ]
    if polygon_reference:
        against += [
            (
                "dissipation_polygon",
                "Dissipation, on the polygon of the steps",
                polygon_reference,
                result,
                None,
                "W less the reference's W on the straight steps between the instants: all errors but the steps'",
            ),
            (
                "dissipation_step",
                "Dissipation, the steps alone",
                reference,
                polygon_reference,
                None,
                "the reference's W on the straight steps less its W on the smooth path: the error of the steps",
            ),
        ]
    return (
        *(
            _dissipation_metric(key, label, of.dissipation, to.dissipation, scale, limit, what)
            for key, label, of, to, limit, what in against
        ),
        _loop_metric(reference, expected, found, scale),
        _density_metric(expected, found, scales),
        _permanent_stick_metric(reference, result, scales),
    )


def _dissipation_metric(
    key: str, label: str, expected: float, found: float, scale: float, tolerance: float | None, definition: str
) -> Metric:
    value, relative = metrics.dissipation(expected, found, scale)
    return Metric(
        key,
        label,
        "of W_ref" if relative else "of A f² P²",
        value,
        None,
        definition,
        tolerance,
        note="" if relative else "the reference dissipates nothing, so the value is absolute",
    )


def _loop_metric(reference: ContactSolution, expected: Cycle, found: Cycle, scale: float) -> Metric:
    closed = reference.scene.load.path().period is not None
    value, relative = metrics.dissipation(metrics.loop_work(expected), metrics.loop_work(found), scale)
    return Metric(
        "hysteresis",
        "Hysteresis loop area",
        "of the reference's" if relative else "of A f² P²",
        value if closed else None,
        None,
        "closed integral of Q dU less that of the reference, both by the trapezoidal rule over the same instants",
        note="" if closed else "the path is not periodic: no loop",
    )


def _density_metric(expected: Cycle, found: Cycle, scales: Scales) -> Metric:
    density_scale = scales.dissipation / scales.half_width
    difference = metrics.dissipation_density(expected, found, density_scale)
    zero = float(np.max(np.abs(expected.dissipation_density))) <= metrics.NO_DISSIPATION * density_scale
    value, _ = worst(difference, np.ones(len(difference), bool), found.x)
    return Metric(
        "dissipation_density",
        "Pointwise dissipation",
        "of A f² P²/a_ref" if zero else "of largest w_ref",
        value,
        None,
        "w(x) less w_ref(x) at the worst point, over the largest w_ref",
    )


def _permanent_stick_metric(reference: ContactSolution, result: ContactSolution, scales: Scales) -> Metric:
    theirs, ours = reference.permanent_stick_half_width, result.permanent_stick_half_width
    lacking = [s.engine for s in (reference, result) if np.isnan(s.permanent_stick_half_width)]
    return Metric(
        "permanent_stick",
        "Permanent stick half-width",
        "of a_ref",
        None if lacking else (ours - theirs) / scales.half_width,
        None,
        "half-width that sticks through the whole cycle less the reference's",
        note=f"none in {' and '.join(lacking)}" if lacking else "",
    )
