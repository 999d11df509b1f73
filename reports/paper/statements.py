"""What the paper states, each statement against the engine: a verdict and the numbers that the words of paper.toml name.

Equations and figures are the paper's; x and half-widths are over a0 = a(P0), work over A f^2 P0^2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.charts.style import STATE_NAMES
from reports.paper.cases import FRICTIONS, POINTS, Case, Paper, total
from reports.paper.formulas import Formulas
from reports.paper.tables import EXACT, Found, Rule, judge, judge_number, rule
from scenes import SurfaceState
from semi_analytic.friction_work import slip_times

Array = NDArray[np.float64]

_ROUNDING = 1e-10
_EXPONENT_SLACK = 0.01
# Points from the centre to near the largest contact, at which tractions are compared.
_PLACES = (0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.9, 1.0, 1.1)
# What the text gives for its four points: S stick, F forward slip, R reverse slip, O separation.
_HISTORIES = {0.77: "SRSF", 0.82: "SRORSF", 1.0: "OSFO", 1.13: "OFO"}
STATEMENTS: dict[str, Rule] = {}


# ------------------------------------------------------------------------------------------ tractions of the first cycle
def _error(case: Case, time: float, found: Array) -> float:
    """Largest difference from the engine's shear traction at an instant over its largest value."""
    shear = case.solve(time=[time], x=_PLACES, fields=("shear",)).shear[0]
    return float(np.max(np.abs(found - shear)) / np.max(np.abs(shear)))


def _halfway(case: Case, first: str, last: str) -> float:
    return (case.time(first) + case.time(last)) / 2


@rule(STATEMENTS, "(5)")
def growing_load(paper: Paper) -> Found:
    """Along O-A-B in full stick, and beyond B, where P still grows but the edges slip."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), np.array(_PLACES) * paper.hertz.length
    stick = max(_error(case, case.time(letter), formulas.stuck(x, case.events[letter].normal_load)) for letter in "AB")
    later = _halfway(case, "B", "C")
    slip = _error(case, later, formulas.stuck(x, float(formulas.loads(later)[0])))
    return judge(max(stick, slip) <= EXACT, nearly=stick <= EXACT), {"error in full stick": stick, "error in slip": slip}


@rule(STATEMENTS, "(6)")
def forward_slip(paper: Paper) -> Found:
    """Equation (6) from B to E."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), np.array(_PLACES) * paper.hertz.length
    errors = {}
    for name, time in {"B-C": _halfway(case, "B", "C"), **{letter: case.time(letter) for letter in "CDE"}}.items():
        load, met = float(formulas.loads(time)[0]), formulas.initial_meeting(time)
        new = case.contact.pressure(x, load) - case.contact.pressure(x, met)
        errors[f"error at {name}"] = _error(case, time, formulas.stuck(x, met) + case.friction * new)
    worst = max(errors.values())
    return judge(worst <= EXACT), errors | {"largest error": worst}


@rule(STATEMENTS, "full stick at E")
def at_once(paper: Paper, before: float = 1e-6) -> Found:
    """Slip slows down to rest at E everywhere; reverse slip then starts from the edges."""
    case, end, start = paper.hertz, paper.hertz.time("E"), paper.hertz.time("B")
    found = case.solve(time=[end - before, end + before])
    ratio = found.stick_half_width / found.contact_half_width
    slip = case.solve(time=[start, end - before, end], x=[0.8, 0.85], fields=("slip",)).slip
    slowest = float(np.max((slip[2] - slip[1]) / before / ((slip[2] - slip[0]) / (end - start))))
    holds = ratio[0] < 1 - EXACT and 1 - ratio[1] <= EXACT and slowest <= 1e-5
    return judge(holds), {"stick before": float(ratio[0]), "slip after": float(1 - ratio[1]), "speed before": slowest}


@rule(STATEMENTS, "(7)")
def reverse_slip(paper: Paper) -> Found:
    """Equations (7) and (8) from E to G."""
    case, formulas, x = paper.hertz, Formulas(paper.hertz), np.array(_PLACES) * paper.hertz.length
    met, errors = formulas.initial_meeting(case.time("E")), {}
    for name, time in {"E-F": _halfway(case, "E", "F"), "F": case.time("F"), "G": case.time("G")}.items():
        loads = (float(formulas.loads(time)[0]), float(formulas.front("EG", time)), met)
        now, turned, first = (case.contact.pressure(x, load) for load in loads)
        errors[f"error at {name}"] = _error(case, time, formulas.stuck(x, met) + case.friction * (2 * turned - now - first))
    worst = max(errors.values())
    return judge(worst <= EXACT), errors | {"largest error": worst}


@rule(STATEMENTS, "residual tractions")
def residual_tractions(paper: Paper) -> Found:
    """What the slip of the transient leaves: the locked-in slip, and the tractions that the initial loading alone has not."""
    case, formulas = paper.hertz, Formulas(paper.hertz)
    inner, outer = formulas.initial_meeting(case.time("E")), float(formulas.front("EG", case.time("G")))
    bounds, shares = case.width([inner, outer]), np.linspace(0.01, 0.99, 50)
    x = np.concatenate([bounds[0] * shares, bounds[0] + (bounds[1] - bounds[0]) * shares])
    times = [case.time(letter) for letter in "BGM"]
    slip = case.solve(time=times, x=x, fields=("slip",)).slip / (case.compliance * case.unit)
    locked, later = np.abs(slip[1] - slip[0]), float(np.max(np.abs(slip[2] - slip[1])))
    within, between = float(np.max(locked[:50])), float(np.min(locked[50:]))

    # At G: the engine's q without the hooks of reverse slip, and without what loading in stick to P_T would have left.
    widest = float(case.width(case.events["G"].normal_load))
    x = np.array([0.0, bounds[0], 0.7 * bounds[1] + 0.3 * widest, 0.1 * bounds[1] + 0.9 * widest])
    shear = case.solve(time=[case.time("G")], x=x, fields=("shear",)).shear[0]
    place = x * case.length
    hooks = case.contact.pressure(place, case.events["G"].normal_load) - case.contact.pressure(place, outer)
    new = (shear + case.friction * hooks - formulas.stuck(place, outer)) * case.length / case.unit
    share, beyond = float(new[0] / new[1]), float(np.max(np.abs(new[2:])))
    holds = max(within, later, beyond) <= _ROUNDING < between
    return judge(holds and abs(share) <= _ROUNDING, nearly=holds), {
        "a(P_Z)/a0": float(bounds[0]),
        "a(P_T)/a0": float(bounds[1]),
        "slip within a(P_Z)": within,
        "slip beyond a(P_Z)": between,
        "change in later cycles": later,
        "traction at the centre over that at a(P_Z)": share,
        "traction beyond a(P_T)": beyond,
    }


# ------------------------------------------------------------------------------------------ stick, slip and separation
@rule(STATEMENTS, "stick from G to I")
def stick_throughout(paper: Paper) -> Found:
    """No slip from G to I, and slip right after I."""
    case, times = paper.hertz, {letter: paper.hertz.time(letter) for letter in "GIM"}
    zones = (case.solve(time=np.linspace(times[a], times[b], 203)[1:-1]) for a, b in ("GI", "IM"))
    held, slid = ((zone.contact_half_width - zone.stick_half_width) / case.length for zone in zones)
    deepest, least = float(held.max()), float(slid.min())
    share = (times["I"] - times["G"]) / (2 * math.pi)
    numbers = {"deepest slip in G-I": deepest, "least slip in I-M": least, "share of the cycle": share}
    return judge(deepest <= _ROUNDING < least), numbers


@rule(STATEMENTS, "transient slip")
def transient_slip(paper: Paper) -> Found:
    """The stick zone of the first cycle is the smaller one."""
    first, steady = float(paper.hertz.width(paper.hertz.events["E"].front_load)), paper.hertz.stick_edge
    return judge(first < steady), {"first cycle": first, "steady": steady}


@rule(STATEMENTS, "slip advances from B to E")
def receding_stick(paper: Paper) -> Found:
    """The stick zone shrinks from B to E although the contact grows up to C."""
    case = paper.hertz
    stick = case.solve(time=np.linspace(case.time("B"), case.time("E"), 201)).stick_half_width / case.length
    contact = case.width([case.events[letter].normal_load for letter in "BC"])
    least = float(np.min(-np.diff(stick)))
    ends = {"c at B": float(stick[0]), "c at E": float(stick[-1]), "a at B": float(contact[0]), "a at C": float(contact[1])}
    return judge(least > 0 and contact[1] > contact[0]), {"least fall of c in a step": least} | ends


@rule(STATEMENTS, "slip as deep forward as in reverse")
def same_penetration(paper: Paper) -> Found:
    """The stick zone is as small at G as at M."""
    reverse, forward = (float(paper.hertz.width(paper.hertz.events[letter].front_load)) for letter in "GM")
    return judge(abs(forward - reverse) <= _ROUNDING), {"forward": forward, "reverse": reverse}


@rule(STATEMENTS, "longer in forward slip")
def time_in_slip(paper: Paper) -> Found:
    """How long the contact slips each way."""
    forward, reverse = ((paper.hertz.time(b) - paper.hertz.time(a)) / (2 * math.pi) for a, b in ("IM", "EG"))
    return judge(forward > reverse), {"forward": forward, "reverse": reverse}


@rule(STATEMENTS, "forward slip is slower")
def slip_speed(paper: Paper, x: float = POINTS[0]) -> Found:
    """Mean speed of a particle that is always in contact: over its own time of slip, and over that of the contact."""
    case = paper.hertz
    distance, duration = (np.array(pair) for pair in zip(*(_slip_at(case, x, d) for d in (1, -1)), strict=True))
    phases = np.array([case.time("M") - case.time("I"), case.time("G") - case.time("E")])
    own, phase = (float(np.divide(*(distance / time))) for time in (duration, phases))
    times = duration / (2 * math.pi)
    return judge(own < 1 - _ROUNDING, nearly=phase < 1 - _ROUNDING), {
        "speeds while the point slips": own,
        "speeds over the phases": phase,
        "distance forward": float(distance[0]),
        "distance reverse": float(distance[1]),
        "time forward": float(times[0]),
        "time reverse": float(times[1]),
    }


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


@rule(STATEMENTS, "permanent stick")
def permanent_stick(paper: Paper) -> Found:
    """Half-width that never slips."""
    return judge_number(paper.hertz.stick_edge, 0.73, 2), {"a(P_T)/a0": paper.hertz.stick_edge}


@rule(STATEMENTS, "no net displacement")
def net_displacement(paper: Paper) -> Found:
    """A revolution brings every point back. From G of the first cycle on: the engine marches along it, later ones it looks up."""
    case = paper.hertz
    slip = case.solve(time=case.time("G") + np.linspace(0.0, 2 * math.pi, 361), x=POINTS, fields=("slip",)).slip
    net = float(np.max(np.abs(slip[-1] - slip[0])) / np.max(np.ptp(slip, axis=0)))
    return judge(net <= _ROUNDING), {"net over largest": net}


def point_history(paper: Paper, x: float) -> Found:
    """Sequence of stick, slip and separation of a point of figure 5."""
    times = paper.hertz.round_times(1441)
    states = paper.hertz.solve(time=(times[1:] + times[:-1]) / 2, x=[x], fields=("state",)).state[:, 0]
    found = sequence(states)
    stated = [name for name, _ in groupby(_HISTORIES[x])]
    stated = stated[:-1] if stated[0] == stated[-1] else stated
    letters = [{"stick": "S", "forward slip": "F", "reverse slip": "R", "open": "O"}[name] for name in found]
    turns = [stated[k:] + stated[:k] for k in range(len(stated))]
    words = ", ".join(found).replace("open", "separation")
    share = float(np.mean(states == SurfaceState.OPEN))
    return judge(letters in turns), {"share of separation": share, "runs": len(found), "history": words}


def sequence(states: Sequence[int] | NDArray[np.int8]) -> list[str]:
    """Names of the runs of a closed cycle.

    >>> sequence([1, 1, 2, 0, 1])
    ['stick', 'forward slip', 'open']
    """
    names = [STATE_NAMES[SurfaceState(int(state))] for state, _ in groupby(states)]
    return names[:-1] if len(names) > 1 and names[0] == names[-1] else names


STATEMENTS |= {f"history of x = {x}": partial(point_history, x=x) for x in POINTS}


@rule(STATEMENTS, "one-way slip")
def one_way_slip(paper: Paper) -> Found:
    """Beyond which half-width no reverse slip rubs."""
    case, low, high = paper.hertz, paper.hertz.stick_edge, paper.hertz.outer_edge
    for _ in range(5):
        grid = np.linspace(low, high, 101)
        rubbed = np.flatnonzero(case.density(grid)["EG"] > 0)
        low, high = float(grid[rubbed[-1]]), float(grid[rubbed[-1] + 1])
    edge, widest = (low + high) / 2, max(float(case.width(case.events[letter].normal_load)) for letter in "EG")
    return judge_number(edge, 0.88, 2), {"edge": edge, "largest a in E-G": widest}


# ---------------------------------------------------------------------------------------- other loads, the other profile
@rule(STATEMENTS, "friction delays slip")
def friction_delays(paper: Paper) -> Found:
    """Onset of slip, and return to stick, for the coefficients of figure 4b (about Q0 = 0)."""
    cases = [paper.hertz.about_no_shear(f) for f in sorted(FRICTIONS)]
    times = {letter: np.array([case.time(letter) for case in cases]) for letter in "EGI"}
    later = {letter: bool(np.all(np.diff(row) > 0)) for letter, row in times.items()}
    shift = {f"shift of {letter} in degrees": math.degrees(row[-1] - row[0]) for letter, row in times.items()}
    onset = later["E"] and later["I"]
    return judge(onset and later["G"], nearly=onset), shift | {"G earlier in degrees": -shift["shift of G in degrees"]}


@rule(STATEMENTS, "coefficients of figure 4b")
def frictions_of_figure_4b(paper: Paper) -> Found:
    """Whether the example's loads admit the coefficients of figure 4b at all."""
    case, frictions, mean = paper.hertz, np.array(FRICTIONS), paper.hertz.load.mean_tangential_load
    arguments = case.batch(friction_coefficient=frictions, mean_tangential_load=mean * np.array([[1.0], [0.0]]))
    slides = semi_analytic.dissipation(**arguments).reason == semi_analytic.Reason.SLIDING
    numbers = {"sliding with Q0": int(slides[0].sum()), "sliding with Q0 = 0": int(slides[1].sum()), "Q0": mean / case.unit}
    words = {"which slide": ", ".join(f"{f:g}" for f in frictions[slides[0]])}
    return judge(not slides[0].any(), nearly=not slides[1].any()), numbers | words


def _changes(case: Case, others: Sequence[Case]) -> dict[str, float]:
    """Largest change of the stick half-width through the cycle, and of W as closed integral of Q dU: that way to it knows Q0."""

    def zones(of: Case) -> Array:
        return of.solve(time=of.round_times(73)).stick_half_width / of.length

    zone = max(float(np.max(np.abs(zones(other) - zones(case)))) for other in others)
    work = max(abs(other.steady.loop_work / case.steady.loop_work - 1) for other in others)
    return {"change of c": zone, "change of W": work}


@rule(STATEMENTS, "mean shear force")
def mean_force(paper: Paper) -> Found:
    """Other Q0: zones of slip and dissipation stay."""
    case, means = paper.hertz, (-1.0, 0.0, 0.5)
    others = [case.with_load(mean_tangential_load=mean * case.unit, initial_loading="straight") for mean in means]
    changes = _changes(case, others)
    return judge(max(changes.values()) <= _ROUNDING), changes


@rule(STATEMENTS, "initial loading")
def initial_loading(paper: Paper) -> Found:
    """Other initial loadings: only tractions within the permanent stick zone remember them."""
    case = paper.hertz
    polygon = tuple((p * case.unit, q * case.unit) for p, q in ((1.0, 0.5), (2.0, -0.5)))
    others = [case.with_load(initial_loading=way) for way in ("straight", polygon)]
    changes = _changes(case, others)
    outside = np.linspace(case.stick_edge * 1.001, case.outer_edge, 50)
    inside = np.linspace(0, case.stick_edge * 0.999, 50)

    def shear(of: Case, x: Array) -> Array:
        return of.solve(time=[of.time("M") + 2 * math.pi], x=x, fields=("shear",)).shear * case.length / case.unit

    within, beyond = (max(float(np.max(np.abs(shear(o, x) - shear(case, x)))) for o in others) for x in (inside, outside))
    holds = max(changes.values()) <= _ROUNDING and beyond <= _ROUNDING < within
    return judge(holds), changes | {"change of q inside": within, "change of q outside": beyond}


@rule(STATEMENTS, "slip in the radii")
def rounded_stick(paper: Paper) -> Found:
    """Slip of the flat and rounded punch stays in the radii."""
    stick, flat = paper.rounded.stick_edge, float(paper.rounded.width(0.0))
    return judge(stick > flat), {"a(P_T)/a0": stick, "b/a0": flat}


@rule(STATEMENTS, "narrow bands")
def narrow_bands(paper: Paper) -> Found:
    """The slip bands are narrower."""
    hertz, rounded = (case.outer_edge - case.stick_edge for case in (paper.hertz, paper.rounded))
    return judge(rounded < hertz), {"hertz": hertz, "flat and rounded": rounded}


# ------------------------------------------------------------------------------------------------------ work of friction
@rule(STATEMENTS, "most work in forward slip")
def forward_work(paper: Paper) -> Found:
    """Share of the phases in the work of a cycle."""
    batch = semi_analytic.dissipation(**paper.hertz.batch())
    share = float(batch.forward / batch.value)
    return judge(share > 0.75, nearly=share > 0.5), {"share of forward slip": share, "share of reverse slip": 1 - share}


@rule(STATEMENTS, "no work at the ends")
def both_ends(paper: Paper) -> Found:
    """W(x) is zero where the contact always sticks and at the largest contact."""
    inner, outer = paper.hertz.stick_edge, paper.hertz.outer_edge
    values = total(paper.hertz.density(inner + (outer - inner) * np.array([-0.5, -1e-9, 0.5, 1 - 1e-9])))
    stuck, last, middle = float(max(values[:2])), float(values[3]), float(values[2])
    largest = max(stuck, last) / middle
    return judge(stuck == 0 and largest < 1e-6), {
        "largest at the ends over mid-zone": largest,
        "in the stick zone": stuck,
        "at the outer edge over mid-zone": last / middle,
    }


def _exponent(case: Case, outer: bool) -> float:
    """d ln W / d ln(distance) close to an end of the slip zone."""
    inner, last = case.stick_edge, case.outer_edge
    distance = (last - inner) * np.array([1e-6, 1e-5])
    values = total(case.density(last - distance if outer else inner + distance))
    return float(np.diff(np.log(values))[0] / np.diff(np.log(distance))[0])


@rule(STATEMENTS, "slope at the stick edge")
def inner_slope(paper: Paper) -> Found:
    """Zero slope: a power above 1."""
    power = _exponent(paper.hertz, outer=False)
    return judge(power > 1 + _EXPONENT_SLACK), {"exponent": power}


@rule(STATEMENTS, "slope at the outer edge")
def outer_slope(paper: Paper) -> Found:
    """Finite slope: the power 1."""
    power = _exponent(paper.hertz, outer=True)
    return judge(abs(power - 1) <= _EXPONENT_SLACK), {"exponent": power}


@rule(STATEMENTS, "root at the outer edge")
def outer_root(paper: Paper) -> Found:
    """A square root: the power 1/2."""
    power = _exponent(paper.hertz, outer=True)
    return judge(abs(power - 0.5) <= _EXPONENT_SLACK, nearly=abs(power - 0.5) <= 0.1), {"exponent": power}


def peak_place(paper: Paper, number: int) -> Found:
    """Where the peak lies between stick edge and outer edge."""
    peak, length = paper.peaks[number], (paper.hertz, paper.rounded)[number].length
    place = float(peak.fraction)
    return judge(0.6 < place < 0.65, nearly=abs(place - 0.6) < 0.02), {"fraction": place, "x/a0": float(peak.place) / length}


STATEMENTS |= {f"place of the peak, {name}": partial(peak_place, number=k) for k, name in enumerate(("Hertz", "flat and rounded"))}


@rule(STATEMENTS, "place of the peak, all loads")
def peak_near_sliding(paper: Paper) -> Found:
    """The peak close to gross sliding and far from it."""
    numbers = {
        f"{name}, {end}": float(sweep.place[0, k])
        for name, sweep in zip(("Hertz", "flat and rounded"), paper.sweeps, strict=True)
        for end, k in (("near", 0), ("far", -1))
    }
    places = numbers.values()
    return judge(all(0.6 < place < 0.65 for place in places), nearly=all(0.55 < place < 0.7 for place in places)), numbers


def most_before_sliding(paper: Paper, what: str) -> Found:
    """Dissipation or its peak falls all the way from the sliding limit."""
    steepest = max(float(np.max(np.diff(getattr(sweep, what), axis=1))) for sweep in paper.sweeps)
    return judge(steepest < 0), {"largest step": steepest}


STATEMENTS["global dissipation before sliding"] = partial(most_before_sliding, what="work")
STATEMENTS["peak before sliding"] = partial(most_before_sliding, what="peak")


def _slopes(paper: Paper, what: str, number: int = 0) -> Array:
    """d ln / d ln P0 between neighbours of a sweep at constant a(P0)."""
    sweep = paper.sweeps[number]
    return np.asarray(np.diff(np.log(getattr(sweep, what)), axis=1) / np.diff(np.log(sweep.ratio), axis=1))


@rule(STATEMENTS, "work falls faster than its peak")
def work_falls_faster(paper: Paper) -> Found:
    """Global dissipation against its peak as P0 grows, at constant a(P0) and at constant R (a then grows like sqrt(P0))."""
    work, peak = _slopes(paper, "work"), _slopes(paper, "peak")
    gap = float(np.min(np.minimum(peak, peak - 0.5) - work))
    falls = {f"fall of {what}": float(np.divide(*getattr(paper.sweeps[0], what)[0, [0, -1]])) for what in ("work", "peak")}
    return judge(gap > 0), falls | {"least gap of exponents": gap}


@rule(STATEMENTS, "best designs close to sliding")
def best_designs(paper: Paper) -> Found:
    """Work over peak is largest at the sliding limit."""
    ratios = [sweep.work / sweep.peak for sweep in paper.sweeps]
    best = {int(place) for ratio in ratios for place in np.argmax(ratio, axis=1)}
    return judge(best == {0}), {"near": float(ratios[0][0, 0]), "far": float(ratios[0][0, -1])}


def _quotients(paper: Paper, what: str) -> tuple[float, dict[str, float]]:
    """Flat and rounded over Hertz at equal loads, f, material and a0; its range over the figure."""
    pairs = zip((paper.hertz, paper.rounded), paper.peaks, strict=True)
    each = [
        (float(peak.value) * case.length if what == "peak" else case.steady.dissipation) / case.work_unit for case, peak in pairs
    ]
    whole = getattr(paper.sweeps[1], what) / getattr(paper.sweeps[0], what)
    return each[1] / each[0], {"least": float(whole.min()), "largest": float(whole.max())}


@rule(STATEMENTS, "five times the energy")
def five_times(paper: Paper) -> Found:
    """Global dissipation of the two profiles."""
    work, span = _quotients(paper, "work")
    return judge_number(work, 5, 0, slack=0.2), {"quotient of work": work} | span


@rule(STATEMENTS, "eight times the peak")
def eight_times(paper: Paper) -> Found:
    """Peaks of the two profiles."""
    peak, span = _quotients(paper, "peak")
    return judge_number(peak, 8, 0, slack=0.2), {"quotient of peaks": peak} | span


@rule(STATEMENTS, "weaker dependence of the peak")
def weaker_dependence(paper: Paper) -> Found:
    """Spread of the peak over the figure, and its exponent in P1 at constant P0."""
    spread = [sweep.peak[:, 0] / sweep.peak[:, -1] for sweep in paper.sweeps]
    # At constant P0 the peak goes as (P1/P0)^2 times what the sweep has at constant P1.
    exponents = [2 - _slopes(paper, "peak", number) for number in (0, 1)]
    share = float(np.mean(exponents[1] < exponents[0]))
    ratio, place = paper.sweeps[1].ratio[-1], paper.sweeps[1].place[-1]
    last = int(np.argmax(np.abs(np.diff(place))))
    return judge(bool(np.all(spread[1] < spread[0])) and share == 1), {
        "fall, hertz": float(spread[0][0]),
        "fall, flat and rounded": float(spread[1][0]),
        "share of smaller exponents": share,
        "last shoulder": float(ratio[last]),
        "first outer one": float(ratio[last + 1]),
        "first place": float(place[0]),
        "last place": float(place[last]),
        "place of the outer one": float(place[last + 1]),
    }


@rule(STATEMENTS, "figure of merit")
def figure_of_merit(paper: Paper) -> Found:
    """Work over peak of the two profiles."""
    merit = _quotients(paper, "work")[0] / _quotients(paper, "peak")[0]
    return judge(merit < 1), {"quotient of merits": merit, "five over eight": 5 / 8}
