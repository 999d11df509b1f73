"""What the paper states about other loads, other initial loadings and the other profile: the same zones of slip or different ones.

Equations and figures are the paper's; x and half-widths are over a0 = a(P0).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.paper.cases import FRICTIONS, Case, Paper
from reports.paper.tables import Statement, judge, small

Array = NDArray[np.float64]

_ROUNDING = 1e-10


def load_statements(paper: Paper) -> list[Statement]:
    """Every statement about what the zones of slip depend on, in the order of the paper."""
    hertz, rounded = paper.hertz, paper.rounded
    return [
        friction_delays(hertz),
        frictions_of_figure_4b(hertz),
        mean_force(hertz),
        initial_loading(hertz),
        rounded_stick(rounded),
        narrow_bands(hertz, rounded),
    ]


def friction_delays(case: Case) -> Statement:
    """Onset of slip, and return to stick, for the coefficients of figure 4b (about Q0 = 0)."""
    times = {f: case.about_no_shear(f) for f in FRICTIONS}
    order = sorted(times)
    shift = {letter: math.degrees(times[order[-1]].time(letter) - times[order[0]].time(letter)) for letter in ("E", "G", "I")}
    onset = [[times[f].time(letter) for f in order] for letter in ("E", "I")]
    back = [times[f].time("G") for f in order]
    later = all(np.all(np.diff(row) > 0) for row in onset)
    return Statement(
        "friction delays slip",
        "section 4.1, figure 4b",
        "with more friction the changes between stick and slip come later",
        f"from f = {order[0]} to {order[-1]} slip starts later by {shift['E']:.1f}° (E, reverse) and {shift['I']:.1f}° "
        f"(I, forward); full stick returns (G) earlier by {-shift['G']:.1f}°",
        judge(later and bool(np.all(np.diff(back) > 0)), nearly=later),
        {f"shift of {letter} in degrees": value for letter, value in shift.items()},
    )


def frictions_of_figure_4b(case: Case) -> Statement:
    """Whether the example's loads admit the coefficients of figure 4b at all."""
    frictions = np.array(FRICTIONS)
    means = case.load.mean_tangential_load * np.array([[1.0], [0.0]])
    reason = semi_analytic.dissipation(**case.batch(friction_coefficient=frictions, mean_tangential_load=means)).reason
    slides = reason == semi_analytic.Reason.SLIDING
    sliding = ", ".join(f"{f:g}" for f in frictions[slides[0]])
    mean = case.load.mean_tangential_load / case.unit
    return Statement(
        "coefficients of figure 4b",
        "section 4.1, figure 4b",
        "figure 4b has the zones of slip for four f: 1.0, 0.8, 0.6 and 0.4",
        f"with the example's Q0 = {mean:.2g} the loads slide grossly at f = {sliding}; with Q0 = 0 "
        f"{'none does' if not slides[1].any() else 'some do'}, and the extent of slip does not depend on Q0: figure 4b is drawn so",
        judge(not slides[0].any(), nearly=not slides[1].any()),
        {"sliding with Q0": int(slides[0].sum()), "sliding with Q0 = 0": int(slides[1].sum())},
    )


def _zones(case: Case) -> tuple[Array, float]:
    """Stick half-width through the cycle, and W as closed integral of Q dU: the way to it that knows Q0 and the initial loading."""
    solution = case.solve(time=case.round_times(73))
    return solution.stick_half_width / case.length, case.steady.loop_work / case.work_unit


def mean_force(case: Case) -> Statement:
    """Other Q0: zones of slip and dissipation stay."""
    own = _zones(case)
    others = [
        _zones(case.with_load(mean_tangential_load=mean * case.unit, initial_loading="straight")) for mean in (-1.0, 0.0, 0.5)
    ]
    zone = max(float(np.max(np.abs(other[0] - own[0]))) for other in others)
    work = max(abs(other[1] / own[1] - 1) for other in others)
    return Statement(
        "mean shear force",
        "section 3",
        "friction does the same work whatever the mean shear force",
        f"Q0 = −1, 0 and 0.5 instead of 1.1: c moves by at most {small(zone)} a0, W by a share of {small(work)}",
        judge(max(zone, work) <= _ROUNDING),
        {"change of c": zone, "change of W": work},
    )


def initial_loading(case: Case) -> Statement:
    """Other initial loadings: only tractions within the permanent stick zone remember them."""
    own = _zones(case)
    corners = ((1.0, 0.5), (2.0, -0.5))
    polygon = tuple((p * case.unit, q * case.unit) for p, q in corners)
    others = [case.with_load(initial_loading=way) for way in ("straight", polygon)]
    zone = max(float(np.max(np.abs(_zones(other)[0] - own[0]))) for other in others)
    work = max(abs(_zones(other)[1] / own[1] - 1) for other in others)
    outside = np.linspace(case.stick_edge * 1.001, case.outer_edge, 50)
    inside = np.linspace(0, case.stick_edge * 0.999, 50)
    residual = [max(_traction_change(case, other, x) for other in others) for x in (inside, outside)]
    return Statement(
        "initial loading",
        "section 2",
        "of the initial loading only shear tractions within the permanent stick zone are left",
        f"straight and zigzag instead of the parabola: c moves by {small(zone)} a0, W by a share of {small(work)}; "
        f"shear at M differs by up to {residual[0]:.2f} P0/(3 a0) inside a(P_T) and by {small(residual[1])} outside",
        judge(max(zone, work) <= _ROUNDING and residual[1] <= _ROUNDING < residual[0]),
        {"change of c": zone, "change of W": work, "change of q inside": residual[0], "change of q outside": residual[1]},
    )


def _traction_change(case: Case, other: Case, x: Array) -> float:
    shears = [each.solve(time=[each.time("M") + 2 * math.pi], x=x, fields=("shear",)).shear for each in (case, other)]
    return float(np.max(np.abs(shears[1] - shears[0]))) * case.length / case.unit


def rounded_stick(case: Case) -> Statement:
    """Slip of the flat and rounded punch stays in the radii."""
    flat = float(case.width(0.0))
    return Statement(
        "slip in the radii",
        "section 4.2, figure 8",
        "slip cannot leave the rounded edges",
        f"permanent stick reaches to a(P_T)/a0 = {case.stick_edge:.4f}, the flat to b/a0 = {flat:.3f} (it cannot do otherwise: a "
        "≥ b)",
        judge(case.stick_edge > flat),
        {"a(P_T)/a0": case.stick_edge, "b/a0": flat},
    )


def narrow_bands(hertz: Case, rounded: Case) -> Statement:
    """The slip bands are narrower."""
    bands = [case.outer_edge - case.stick_edge for case in (hertz, rounded)]
    return Statement(
        "narrow bands",
        "section 4.2, figure 8",
        "what the flat face does is mainly to confine slip to two bands, one at each edge",
        f"slip reaches over {bands[1]:.4f} a0 at either edge, over {bands[0]:.4f} a0 for Hertz",
        judge(bands[1] < bands[0]),
        {"hertz": bands[0], "flat and rounded": bands[1]},
    )
