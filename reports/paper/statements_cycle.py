"""What the paper states about stick, slip and separation through its cycle, each against the engine.

Equations and figures are the paper's; x and half-widths are over a0 = a(P0).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from reports.charts.style import STATE_NAMES
from reports.paper.cases import POINTS, Case, Paper
from reports.paper.tables import Statement, judge, judge_number, small
from scenes import SurfaceState
from semi_analytic.friction_work import slip_times

Array = NDArray[np.float64]

_ROUNDING = 1e-10
# What the text gives for the four points; the names of states are those of `STATE_NAMES`.
_HISTORIES = {
    0.77: ("stick", "reverse slip", "stick", "forward slip"),
    0.82: ("stick", "reverse slip", "open", "reverse slip", "stick", "forward slip"),
    1.0: ("open", "stick", "forward slip", "open"),
    1.13: ("open", "forward slip", "open"),
}


def cycle_statements(paper: Paper) -> list[Statement]:
    """Every statement about the course of the cycle, in the order of the paper."""
    hertz = paper.hertz
    return [
        stick_throughout(hertz),
        transient_slip(hertz),
        receding_stick(hertz),
        same_penetration(hertz),
        time_in_slip(hertz),
        slip_speed(hertz),
        permanent_stick(hertz),
        net_displacement(hertz),
        *(point_history(hertz, x) for x in POINTS),
        one_way_slip(hertz),
    ]


def stick_throughout(case: Case) -> Statement:
    """Full stick from G to I."""
    inside = np.linspace(case.time("G"), case.time("I"), 203)[1:-1]
    outside = np.linspace(case.time("I"), case.time("M"), 203)[1:-1]
    held, slid = case.solve(time=inside), case.solve(time=outside)
    deepest = float(np.max(held.contact_half_width - held.stick_half_width)) / case.length
    least = float(np.min(slid.contact_half_width - slid.stick_half_width)) / case.length
    share = (case.time("I") - case.time("G")) / (2 * math.pi)
    return Statement(
        "stick from G to I",
        "section 4.1, figure 4a",
        "from G to I no point of the contact slips",
        f"deepest slip between G and I, {share:.0%} of the cycle: {deepest:.1g} a0; right after I slip has begun ({least:.1e} a0)",
        judge(deepest <= _ROUNDING < least),
        {"deepest slip in G-I": deepest, "least slip in I-M": least, "share of the cycle": share},
    )


def transient_slip(case: Case) -> Statement:
    """The stick zone of the first cycle is the smaller one."""
    first = float(case.width(case.events["E"].front_load))
    return Statement(
        "transient slip",
        "sections 2 and 4.1, figure 4a",
        "slip goes much deeper in the first cycle (B to E) than in the steady state",
        f"stick half-width at E {first:.4f} in the first cycle, {case.stick_edge:.4f} in the steady state",
        judge(first < case.stick_edge),
        {"first cycle": first, "steady": case.stick_edge},
    )


def receding_stick(case: Case) -> Statement:
    """The stick zone shrinks from B to E although the contact grows up to C."""
    stick = case.solve(time=np.linspace(case.time("B"), case.time("E"), 201)).stick_half_width / case.length
    contact = case.width([case.events[letter].normal_load for letter in "BC"])
    smallest_step = float(np.min(-np.diff(stick)))
    return Statement(
        "slip advances from B to E",
        "section 2, figure 3C–E",
        "from B to E the stick zone shrinks without a pause, although the contact grows at first",
        f"c falls in each of 200 steps from {stick[0]:.4f} to {stick[-1]:.4f}, while a first grows from {contact[0]:.4f} to "
        f"{contact[1]:.4f}",
        judge(smallest_step > 0 and contact[1] > contact[0]),
        {"least fall of c in a step": smallest_step, "c at B": float(stick[0]), "c at E": float(stick[-1])},
    )


def same_penetration(case: Case) -> Statement:
    """The stick zone is as small at G as at M."""
    reverse, forward = (float(case.width(case.events[letter].front_load)) for letter in "GM")
    return Statement(
        "slip as deep forward as in reverse",
        "section 4.1, figure 4a",
        "once the cycle is steady, forward and reverse slip reach equally far inwards",
        f"least stick half-width {forward:.6f} in forward slip (M), {reverse:.6f} in reverse slip (G)",
        judge(abs(forward - reverse) <= _ROUNDING),
        {"forward": forward, "reverse": reverse},
    )


def time_in_slip(case: Case) -> Statement:
    """How long the contact slips each way."""
    forward = (case.time("M") - case.time("I")) / (2 * math.pi)
    reverse = (case.time("G") - case.time("E")) / (2 * math.pi)
    return Statement(
        "longer in forward slip",
        "section 4.1",
        "the contact slips forward for a longer part of the cycle than in reverse",
        f"{forward:.1%} of the cycle in forward slip, {reverse:.1%} in reverse slip",
        judge(forward > reverse),
        {"forward": forward, "reverse": reverse},
    )


def slip_speed(case: Case, x: float = POINTS[0]) -> Statement:
    """Mean speed of a particle that is always in contact: over its own time of slip, and over that of the contact."""
    distance, duration = (np.array(pair) for pair in zip(*(_slip_at(case, x, d) for d in (1, -1)), strict=True))
    phases = np.array([case.time("M") - case.time("I"), case.time("G") - case.time("E")])
    own, phase = (float(np.divide(*(distance / time))) for time in (duration, phases))
    verdict = judge(own < 1 - _ROUNDING, nearly=phase < 1 - _ROUNDING)
    return Statement(
        "forward slip is slower",
        "section 4.1",
        "on average a point slips more slowly forward than in reverse",
        f"at x = {x} forward over reverse is {phase:.4f} if each way's distance is spread over the contact's whole phase, but the "
        f"point itself slips {duration[0] / (2 * math.pi):.4f} and {duration[1] / (2 * math.pi):.4f} of the cycle, and while it "
        f"slips the quotient of mean speeds is {own:.6f}",
        verdict,
        {
            "speeds while the point slips": own,
            "speeds over the phases": phase,
            "distance forward": float(distance[0]),
            "distance reverse": float(distance[1]),
        },
    )


def _slip_at(case: Case, x: float, direction: int) -> tuple[float, float]:
    """Distance over A P0/3 and duration of the slip of a point in one direction."""
    spans = [span for part in case.slipping.values() for span in part if span.direction == direction]
    edge_load = np.asarray(case.contact.load(np.array([x * case.length])))
    distance = duration = 0.0
    for span in spans:
        begin, end = (float(time[0]) for time in slip_times(span, edge_load))
        if end > begin:
            slip = case.solve(time=[begin + span.delay, end + span.delay], x=[x], fields=("slip",)).slip[:, 0]
            distance += abs(float(slip[1] - slip[0])) / (case.compliance * case.unit)
            duration += end - begin
    return distance, duration


def permanent_stick(case: Case) -> Statement:
    """Half-width that never slips."""
    return Statement(
        "permanent stick",
        "section 4.1, figure 6",
        "permanent stick ends at about 0.73 a(P0)",
        f"a(P_T)/a0 = {case.stick_edge:.5f}",
        judge_number(case.stick_edge, 0.73, 2),
        {"a(P_T)/a0": case.stick_edge},
    )


def net_displacement(case: Case) -> Statement:
    """A revolution brings every point back."""
    # From G of the first cycle on, so that the engine has marched along every instant: later cycles it only looks up.
    slip = case.solve(time=case.time("G") + np.linspace(0.0, 2 * math.pi, 361), x=POINTS, fields=("slip",)).slip
    net = float(np.max(np.abs(slip[-1] - slip[0])) / np.max(np.ptp(slip, axis=0)))
    return Statement(
        "no net displacement",
        "sections 3 and 4.1, figure 5",
        "after a whole cycle opposite points lie as they lay before",
        f"largest net displacement of the four points over a cycle: {small(net)} of the largest movement",
        judge(net <= _ROUNDING),
        {"net over largest": net},
    )


def point_history(case: Case, x: float) -> Statement:
    """Sequence of stick, slip and separation of a point of figure 5."""
    times = case.round_times(1441)
    states = case.solve(time=(times[1:] + times[:-1]) / 2, x=[x], fields=("state",)).state[:, 0]
    found = sequence(states)
    expected = _as_runs(_HISTORIES[x])
    turns = [expected[k:] + expected[:k] for k in range(len(expected))]
    share = float(np.mean(states == SurfaceState.OPEN))
    return Statement(
        f"history of x = {x}",
        "section 4.1, figure 5",
        f"the point goes through {_in_words(_HISTORIES[x])}",
        f"from M on: {_in_words(found)}; separated for {share:.1%} of the cycle",
        judge(found in turns),
        {"share of separation": share, "runs": len(found)},
    )


def _in_words(states: Sequence[str]) -> str:
    return ", ".join(states).replace("open", "separation")


def sequence(states: Sequence[int] | NDArray[np.int8]) -> list[str]:
    """Names of the runs of a closed cycle.

    >>> sequence([1, 1, 2, 0, 1])
    ['stick', 'forward slip', 'open']
    """
    return _as_runs([STATE_NAMES[SurfaceState(int(state))] for state in states])


def _as_runs(words: Sequence[str]) -> list[str]:
    names = [name for name, _ in groupby(words)]
    return names[:-1] if len(names) > 1 and names[0] == names[-1] else names


def one_way_slip(case: Case) -> Statement:
    """Beyond which half-width no reverse slip rubs."""
    low, high = case.stick_edge, case.outer_edge
    for _ in range(5):
        grid = np.linspace(low, high, 101)
        rubbed = np.flatnonzero(case.density(grid)["EG"] > 0)
        low, high = float(grid[rubbed[-1]]), float(grid[rubbed[-1] + 1])
    edge = (low + high) / 2
    widest = max(float(case.width(case.events[letter].normal_load)) for letter in "EG")
    return Statement(
        "one-way slip",
        "section 4.1",
        "points with x/a(P0) ≥ 0.88 rub in one direction only",
        f"reverse slip dissipates up to x = {edge:.4f}; a at the largest P of the reverse-slip phase E–G is {widest:.4f}",
        judge_number(edge, 0.88, 2),
        {"edge": edge, "largest a in E-G": widest},
    )
