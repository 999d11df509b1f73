"""What the paper states about the work of friction, each against the engine.

Work is over A f^2 P0^2 (and a0), x over a0 = a(P0); the sweeps are those of figures 7 and 10.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.paper.cases import Case, Paper, total
from reports.paper.tables import Statement, judge, judge_number

Array = NDArray[np.float64]

_EXPONENT_SLACK = 0.01


def work_statements(paper: Paper) -> list[Statement]:
    """Every statement about dissipation, in the order of the paper."""
    return [
        forward_work(paper.hertz),
        both_ends(paper.hertz),
        inner_slope(paper.hertz),
        outer_slope(paper.hertz),
        outer_root(paper.hertz),
        peak_place(paper, 0),
        most_before_sliding(paper, "work"),
        most_before_sliding(paper, "peak"),
        work_falls_faster(paper),
        best_designs(paper),
        peak_place(paper, 1),
        peak_near_sliding(paper),
        five_times(paper),
        weaker_dependence(paper),
        eight_times(paper),
        figure_of_merit(paper),
    ]


def forward_work(case: Case) -> Statement:
    """Share of the phases in the work of a cycle."""
    batch = semi_analytic.dissipation(**case.batch())
    share = float(batch.forward / batch.value)
    return Statement(
        "most work in forward slip",
        "section 4.1, figure 6",
        "nearly all the work is done in forward slip (I–J and J–M), very little in reverse slip (E–G)",
        f"{share:.1%} of the work in forward slip, {1 - share:.1%} in reverse slip",
        judge(share > 0.75, nearly=share > 0.5),
        {"share of forward slip": share},
    )


def both_ends(case: Case) -> Statement:
    """W(x) is zero where the contact always sticks and at the largest contact."""
    inner, outer = case.stick_edge, case.outer_edge
    x = inner + (outer - inner) * np.array([-0.5, -1e-9, 0.5, 1 - 1e-9])
    values = total(case.density(x))
    largest = float(max(values[[0, 1, 3]]) / values[2])
    return Statement(
        "no work at the ends",
        "section 3",
        "W(x) is zero in the permanent stick zone and vanishes smoothly at the edges of the largest contact",
        f"W within the permanent stick zone {max(values[:2]):.1g}, a share of 1e-9 of the slip zone inside the outer edge "
        f"{values[3] / values[2]:.1e} of mid-zone",
        judge(float(max(values[:2])) == 0 and largest < 1e-6),
        {"largest at the ends over mid-zone": largest},
    )


def _exponent(case: Case, outer: bool) -> float:
    """d ln W / d ln(distance) close to an end of the slip zone."""
    inner, last = case.stick_edge, case.outer_edge
    distance = (last - inner) * np.array([1e-6, 1e-5])
    values = total(case.density(last - distance if outer else inner + distance))
    return float(np.diff(np.log(values))[0] / np.diff(np.log(distance))[0])


def inner_slope(case: Case) -> Statement:
    """Zero slope at the stick edge."""
    power = _exponent(case, outer=False)
    return Statement(
        "slope at the stick edge",
        "section 4.1, figure 6",
        "W(x) starts with zero slope at the edge of permanent stick",
        f"W grows as distance to the power {power:.4f}",
        judge(power > 1 + _EXPONENT_SLACK),
        {"exponent": power},
    )


def outer_slope(case: Case) -> Statement:
    """Finite slope at the outer edge."""
    power = _exponent(case, outer=True)
    return Statement(
        "slope at the outer edge",
        "section 4.1, figure 6",
        "W(x) meets the outer edge with a finite slope",
        f"W falls as distance to the power {power:.4f}",
        judge(abs(power - 1) <= _EXPONENT_SLACK),
        {"exponent": power},
    )


def outer_root(case: Case) -> Statement:
    """Not a square root."""
    power = _exponent(case, outer=True)
    return Statement(
        "root at the outer edge",
        "section 4.1, figure 6",
        "near the outer edge W(x) goes roughly like a square root",
        f"the exponent is {power:.4f}, not 1/2: pressure and slip distance each vanish like the root of the distance",
        judge(abs(power - 0.5) <= _EXPONENT_SLACK, nearly=abs(power - 0.5) <= 0.1),
        {"exponent": power},
    )


def peak_place(paper: Paper, number: int) -> Statement:
    """Where the peak lies between stick edge and outer edge."""
    place = float(paper.peaks[number].fraction)
    where, words = (
        (
            "sections 4.1 and 5, figure 6",
            "counted from the edge of permanent stick, the peak of W(x) lies a little beyond 60 % of the slip zone",
        ),
        (
            "sections 4.2 and 5, figure 9",
            "the peak of W(x) lies about 60 % of the way from stick edge to contact edge (section 5: a little more)",
        ),
    )[number]
    return Statement(
        f"place of the peak, {('Hertz', 'flat and rounded')[number]}",
        where,
        words,
        f"{place:.4f} of the way, at x = {float(paper.peaks[number].place) / (paper.hertz, paper.rounded)[number].length:.4f}",
        judge(0.6 < place < 0.65, nearly=abs(place - 0.6) < 0.02),
        {"fraction": place},
    )


def peak_near_sliding(paper: Paper) -> Statement:
    """The peak close to gross sliding."""
    places = {name: sweep.place[0, [0, -1]] for name, sweep in zip(("Hertz", "flat and rounded"), paper.sweeps, strict=True)}
    ratio = paper.sweeps[0].ratio[0, -1]
    return Statement(
        "place of the peak, all loads",
        "section 5",
        "with either geometry the peak lies a little beyond 60 % of the way",
        "it moves with P0/P1 (f = 1): "
        + "; ".join(
            f"{name} {near:.3f} at the sliding limit, {far:.3f} at P0/P1 = {ratio:g}" for name, (near, far) in places.items()
        ),
        judge(
            all(0.6 < place < 0.65 for pair in places.values() for place in pair),
            nearly=all(0.55 < place < 0.7 for pair in places.values() for place in pair),
        ),
        {f"{name}, {end}": float(value) for name, pair in places.items() for end, value in zip(("near", "far"), pair, strict=True)},
    )


def most_before_sliding(paper: Paper, what: str) -> Statement:
    """Dissipation or its peak falls all the way from the sliding limit."""
    curves = [getattr(sweep, what) for sweep in paper.sweeps]
    steepest = max(float(np.max(np.diff(curve, axis=1))) for curve in curves)
    name = {"work": "global dissipation", "peak": "peak"}[what]
    words = {
        "work": "at each f a cycle dissipates most just before gross sliding",
        "peak": "the peak of W(x), too, is largest just before gross sliding",
    }[what]
    count = sum(curve.shape[0] for curve in curves)
    return Statement(
        f"{name} before sliding",
        f"section 4.1, figure 7{'a' if what == 'work' else 'b'}",
        words,
        f"it falls in every step of P0/P1 from the sliding limit to 6 on all {count} curves (both profiles, four f)",
        judge(steepest < 0),
        {"largest step": steepest},
    )


def _slopes(paper: Paper, what: str, number: int = 0) -> Array:
    """d ln / d ln P0 between neighbours of a sweep at constant a(P0)."""
    sweep = paper.sweeps[number]
    return np.asarray(np.diff(np.log(getattr(sweep, what)), axis=1) / np.diff(np.log(sweep.ratio), axis=1))


def work_falls_faster(paper: Paper) -> Statement:
    """Global dissipation against its peak as P0 grows, at constant a(P0) and at constant R (a then grows like sqrt(P0))."""
    work, peak = _slopes(paper, "work"), _slopes(paper, "peak")
    same_radius = peak - 0.5
    gap = float(np.min(np.minimum(peak, same_radius) - work))
    factors = [float(curve[0, 0] / curve[0, -1]) for curve in (paper.sweeps[0].work, paper.sweeps[0].peak)]
    return Statement(
        "work falls faster than its peak",
        "section 4.1, figure 7",
        "as P0 grows, the work of the whole contact falls much faster than the peak of W(x)",
        f"from the sliding limit to P0/P1 = 6 at f = 1 the work falls {factors[0]:.2f}-fold, the peak {factors[1]:.2f}-fold (at "
        f"constant a(P0)); at constant R too the work falls faster in every step of every f (exponents at least {gap:.2f} apart)",
        judge(gap > 0),
        {"fall of work": factors[0], "fall of peak": factors[1], "least gap of exponents": gap},
    )


def best_designs(paper: Paper) -> Statement:
    """Work over peak is largest at the sliding limit."""
    ratios = [sweep.work / sweep.peak for sweep in paper.sweeps]
    best = {int(place) for ratio in ratios for place in np.argmax(ratio, axis=1)}
    return Statement(
        "best designs close to sliding",
        "section 4.1",
        "work over peak is largest close to gross sliding, so the best designs lie there",
        f"W/(a0 max W(x)) at f = 1: {ratios[0][0, 0]:.3f} at the sliding limit, {ratios[0][0, -1]:.3f} at P0/P1 = 6; largest at "
        "the limit on all curves",
        judge(best == {0}),
        {"near": float(ratios[0][0, 0]), "far": float(ratios[0][0, -1])},
    )


def _quotients(paper: Paper) -> tuple[float, float]:
    """Flat and rounded over Hertz at equal loads, f, material and a0: global dissipation, peak."""
    works = [case.steady.dissipation / case.work_unit for case in (paper.hertz, paper.rounded)]
    peaks = [
        float(peak.value) * case.length / case.work_unit
        for case, peak in zip((paper.hertz, paper.rounded), paper.peaks, strict=True)
    ]
    return works[1] / works[0], peaks[1] / peaks[0]


def five_times(paper: Paper) -> Statement:
    """Global dissipation of the two profiles."""
    work = _quotients(paper)[0]
    sweeps = paper.sweeps[1].work / paper.sweeps[0].work
    return Statement(
        "five times the energy",
        "section 4.2, figure 10a",
        "in the scale of figure 10a the flat and rounded punch absorbs about five times the energy",
        f"at equal loads, f and material W contains neither a nor R: the flat and rounded punch absorbs {work:.3f} of Hertz "
        f"({sweeps.min():.2f} to {sweeps.max():.2f} over the figure), so 'five' says something about the scales of two plots",
        judge_number(work, 5, 0, slack=0.2),
        {"quotient of work": work},
    )


def eight_times(paper: Paper) -> Statement:
    """Peaks of the two profiles."""
    peak = _quotients(paper)[1]
    sweeps = paper.sweeps[1].peak / paper.sweeps[0].peak
    return Statement(
        "eight times the peak",
        "section 4.2, figure 10b",
        "its peak is mostly of the order of eight times that of Hertz",
        f"at equal a(P0) the peaks are as {peak:.3f} ({sweeps.min():.2f} to {sweeps.max():.2f} over the figure); "
        "in no one scale are work and peak five and eight times those of Hertz",
        judge_number(peak, 8, 0, slack=0.2),
        {"quotient of peaks": peak},
    )


def weaker_dependence(paper: Paper) -> Statement:
    """Spread of the peak over the figure, and its exponent in P1 at constant P0."""
    spread = [sweep.peak[:, 0] / sweep.peak[:, -1] for sweep in paper.sweeps]
    # At constant P0 the peak goes as (P1/P0)^2 times what the sweep has at constant P1.
    exponents = [2 - _slopes(paper, "peak", number) for number in (0, 1)]
    share = float(np.mean(exponents[1] < exponents[0]))
    ratio, place = paper.sweeps[1].ratio[-1], paper.sweeps[1].place[-1]
    last = int(np.argmax(np.abs(np.diff(place))))
    return Statement(
        "weaker dependence of the peak",
        "section 4.2, figure 10b",
        "its peak depends less on P1/P0 = Q1/P0 than that of Hertz",
        f"from the sliding limit to P0/P1 = 6 at f = 1 the peak falls {spread[1][0]:.2f}-fold, {spread[0][0]:.2f}-fold for Hertz; "
        f"its exponent in P1/P0 is the smaller one in {share:.0%} of the figure. At f = {paper.sweeps[1].frictions[-1]:g} W(x) has "
        f"two maxima: up to P0/P1 = {ratio[last]:.2f} the largest is the shoulder just inside the least contact half-width, "
        f"{place[0]:.2f} to {place[last]:.2f} of the way from the stick edge, and the outer one, at {place[last + 1]:.2f}, from "
        f"{ratio[last + 1]:.2f} on. Where both are equal the curve has a corner and no jump",
        judge(bool(np.all(spread[1] < spread[0])) and share == 1),
        {
            "fall, hertz": float(spread[0][0]),
            "fall, flat and rounded": float(spread[1][0]),
            "share of smaller exponents": share,
            "last shoulder": float(ratio[last]),
        },
    )


def figure_of_merit(paper: Paper) -> Statement:
    """Work over peak of the two profiles."""
    work, peak = _quotients(paper)
    merit = work / peak
    return Statement(
        "figure of merit",
        "section 4.2",
        "judged by work over peak, Hertz does better than this flat and rounded punch",
        f"W/(a0 max W(x)) of the flat and rounded punch is {merit:.3f} of Hertz; 'five' over 'eight' would be {5 / 8:.3f}",
        judge(merit < 1),
        {"quotient of merits": merit, "five over eight": 5 / 8},
    )
