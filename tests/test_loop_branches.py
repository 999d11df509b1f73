"""Measured loops: f and W lie within what is stated, whatever the form of Q or U over time and
wherever rows begin.
"""

import functools

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import semi_analytic
from refusals import refused_for
from reports.scoring import loop_area
from reports.scoring.loop_fitted import fit_rig
from reports.scoring.loop_over_time import fit_over_time
from reports.scoring.loop_theory import cycle_loads, theory_displacement
from reports.scoring.loops import MeasuredLoop, read_loop, score_loop
from reports.scoring.mapping import Mapping, load_mapping
from scenes import InputError, load_scene

FRICTION = 0.55
LOAD = 160.0
SHARE = 0.7
LARGEST = SHARE * FRICTION * LOAD
SCENE = load_scene("cattaneo-mindlin").vary(
    friction=FRICTION,
    load={
        "kind": "polygon",
        "initial_loading": [(LOAD, 0.0), (LOAD, LARGEST)],
        "cycle": [(LOAD, -LARGEST)],
    },
)


NEARLY = FRICTION * LOAD * (1 - 1e-6)
# A loop that comes so near to sliding as a whole: what slides then is added by hand.
GROSS = SCENE.vary(
    load={
        "kind": "polygon",
        "initial_loading": [(LOAD, 0.0), (LOAD, NEARLY)],
        "cycle": [(LOAD, -NEARLY)],
    }
)


def with_cycle(*points):
    """The scene under another polygon, from the last of its points."""
    return SCENE.vary(
        load={"kind": "polygon", "initial_loading": [points[-1]], "cycle": list(points[:-1])}
    )


def under_ellipse(phase, tangential_amplitude):
    return SCENE.vary(
        load={
            "kind": "ellipse",
            "mean_normal_load": LOAD,
            "normal_amplitude": 0.3 * LOAD,
            "tangential_amplitude": tangential_amplitude * FRICTION * LOAD,
            "phase_degrees": phase,
        }
    )


# P varies: with Q, out of phase with it, and while Q stands.
VARYING = {
    "line": with_cycle((0.95 * LOAD, -LARGEST), (LOAD, LARGEST)),
    "60 degrees": under_ellipse(60.0, 0.5),
    "90 degrees": under_ellipse(90.0, 0.6),
    "140 degrees": under_ellipse(140.0, 0.4),
    "Q stands": with_cycle(
        (LOAD, -LARGEST), (1.2 * LOAD, -LARGEST), (1.2 * LOAD, LARGEST), (LOAD, LARGEST)
    ),
}


def steady_cycle(scene, count=4001):
    """Shares of a cycle, U and Q there, and its W, by theory."""
    path = scene.load.path()
    shares = np.linspace(0.0, 1.0, count)
    times = path.cycle_start + path.period * (1 + shares)
    solution = semi_analytic.solve(
        scene, x=0.0, time=times, fields=("tangential_displacement", "dissipation"), cycles="steady"
    )
    return shares, solution.tangential_displacement, solution.tangential_load, solution.dissipation


@functools.cache
def varying_work(name):
    """W of a cycle in which P varies."""
    return steady_cycle(VARYING[name], count=2)[3]


def with_noise(u, q, noise, seed):
    """Rows of U and Q with noise of a share of half their range."""
    random = np.random.default_rng(seed)
    return [
        values + noise * np.ptp(values) / 2 * random.standard_normal(len(values))
        for values in (u, q)
    ]


def rows_of_varying(name, count, start, closed=False, cycles=1):
    """Rows of a scene in which P varies, each solved by theory, at times that are no even steps;
    they begin `start` cycles behind the highest Q.
    """
    path = VARYING[name].load.path()
    instants = np.linspace(0.0, 1.0, 721)
    highest = instants[np.argmax(path.at(path.cycle_start + path.period * (1 + instants))[1])]
    place = start + cycles * np.arange(count + closed) / count
    uneven = place + 0.07 * np.sin(2 * np.pi * place) + 0.02 * np.sin(4 * np.pi * place + 1)
    share, row = np.unique(np.round(np.mod(uneven + highest, 1.0), 12), return_inverse=True)
    solution = semi_analytic.solve(
        VARYING[name],
        x=0.0,
        time=path.cycle_start + path.period * (1 + share),
        fields="tangential_displacement",
        cycles="steady",
    )
    q = solution.tangential_load[row]
    u = solution.tangential_displacement[row]
    u = u + 0.3 * np.ptp(u) / np.ptp(q) * q + 0.2 * np.ptp(u)
    return u, q


CYCLE = steady_cycle(SCENE)
RIG = 0.3 * np.ptp(CYCLE[1]) / np.ptp(CYCLE[2])


def rows_of(control, form, count, cycles=1, start=0.0, closed=True):
    """Rows of U and Q of a rig that moves its Q or its U by a sine or a triangle; share 0 is the
    highest Q.
    """
    _, shift, load, _ = CYCLE
    share = np.mod(start + cycles * np.arange(count + closed) / count, 1.0)
    wave = np.cos(2 * np.pi * share) if form == "sine" else 4 * np.abs(share - 0.5) - 1
    driving, driven_by = (load, shift) if control == "Q" else (shift, load)
    middle = (driving.max() + driving.min()) / 2
    amplitude = np.ptp(driving) / 2
    driven = middle + amplitude * wave
    half = len(driving) // 2
    falling = CubicSpline(driving[half::-1], driven_by[half::-1])(driven)
    rising = CubicSpline(driving[half:], driven_by[half:])(driven)
    answer = np.where(share < 0.5, falling, rising)
    u, q = (answer, driven) if control == "Q" else (driven, answer)
    u = u + RIG * q + 0.1 * np.ptp(shift)
    return u, q


def loop_of(u, q, **options):
    return MeasuredLoop("loop.csv", u, q, np.arange(len(u), dtype=float), **options)


def holds(score):
    """Whether f and W lie within what is stated."""
    measured = score.loops[0]
    return score.is_scene_friction_within, abs(
        measured.area - CYCLE[3]
    ) <= measured.area_uncertainty


EXACT = [
    ("Q", "sine", 40, 1, 0.0, False),
    ("Q", "triangle", 40, 1, 0.13, False),
    ("Q", "triangle", 100, 1, 0.0, True),
    ("Q", "triangle", 601, 4.3, 0.4, True),
    ("U", "sine", 40, 1, 0.75, True),
    ("U", "triangle", 40, 1, 0.31, True),
    ("U", "triangle", 240, 1, 0.5, False),
    ("U", "sine", 600, 5, 0.6, False),
]


@pytest.mark.parametrize(("control", "form", "count", "cycles", "start", "closed"), EXACT)
def test_an_exact_loop_gives_f_and_its_area_within_what_is_stated(
    control, form, count, cycles, start, closed
):
    u, q = rows_of(control, form, count, cycles, start, closed)
    score = score_loop(loop_of(u, q), SCENE)
    assert holds(score) == (True, True)
    assert score.friction == pytest.approx(FRICTION, rel=2e-6)
    assert score.lowest_friction < FRICTION < score.highest_friction
    assert score.highest_friction - score.lowest_friction < 1e-4 * FRICTION
    assert score.compliance == pytest.approx(RIG, rel=1e-5)
    assert score.loops[1].area == pytest.approx(CYCLE[3], rel=1e-4)
    assert score.n_cycles == pytest.approx(cycles, abs=0.05)
    assert score.loops[0].slope == pytest.approx(score.loops[1].slope, rel=1e-2)
    # A polygon within the loop: its error is of the order of the square of the step, and what is
    # stated is no more than needed.
    assert 0 < score.loops[0].area_uncertainty < 20 * CYCLE[3] * (cycles / count) ** 2


NOISY = [
    ("Q", "sine", 240, 1, 0.2),
    ("Q", "triangle", 600, 5, 0.0),
    ("U", "sine", 600, 1, 0.5),
    ("U", "triangle", 40, 1, 0.9),
]


def test_noise_is_covered_by_the_intervals():
    scores = [
        score_loop(loop_of(*with_noise(*rows_of(*case), 0.01, seed)), SCENE)
        for seed, case in enumerate(NOISY)
    ]
    inside = np.array([holds(score) for score in scores])
    assert inside.sum(axis=0).min() >= len(NOISY) - 1
    for score, (_, _, count, _, _) in zip(scores, NOISY, strict=True):
        assert score.highest_friction - score.lowest_friction > 0.01 * FRICTION
        assert score.loops[0].by_noise > 0.001 * CYCLE[3]
        assert count < 100 or score.noise == pytest.approx(
            0.01 * np.ptp(score.displacement) / 2, rel=0.2
        )


def test_an_interval_is_as_wide_as_the_digits_of_the_rows_leave_open():
    u, q = rows_of("Q", "sine", 240)
    step = 0.01 * np.ptp(u)
    exact = score_loop(loop_of(u, q), SCENE)
    rounded = score_loop(loop_of(np.round(u / step) * step, q, resolution=(step, 0.0)), SCENE)
    stated = score_loop(loop_of(u, q, resolution=(step, 0.0)), SCENE)
    assert rounded.is_scene_friction_within
    assert stated.highest_friction - stated.lowest_friction > 100 * (
        exact.highest_friction - exact.lowest_friction
    )
    assert stated.noise == pytest.approx(step / np.sqrt(12))


@pytest.mark.parametrize(
    ("name", "count", "start", "closed"),
    [
        ("line", 240, 0.0, True),
        ("line", 40, 0.0, False),
        ("90 degrees", 40, 0.5, False),
        ("Q stands", 40, 0.0, False),
        *(
            pytest.param(name, (40, 100, 241)[k % 3], k / 12, k % 2 == 0, marks=pytest.mark.slow)
            for name in VARYING
            for k in range(12)
        ),
    ],
)
def test_where_p_varies_rows_begin_anywhere_and_take_any_time(name, count, start, closed):
    score = score_loop(loop_of(*rows_of_varying(name, count, start, closed)), VARYING[name])
    assert score.n_cycles == pytest.approx(1.0, abs=1.6 / count + 0.01)
    assert score.friction == pytest.approx(FRICTION, rel=1e-5)
    assert score.lowest_friction < FRICTION < score.highest_friction
    # Where Q stands at its turning points, their Q is known to a row less exactly.
    assert (
        score.highest_friction - score.lowest_friction
        < (1e-3 if name == "Q stands" else 1e-4) * FRICTION
    )
    work = varying_work(name)
    assert score.loops[1].area == pytest.approx(work, rel=1e-4)
    measured = score.loops[0]
    assert abs(measured.area - work) <= measured.area_uncertainty
    assert measured.by_distance < 30 * work / count**2
    assert measured.by_noise < 1e-3 * work


def covered_of_varying(name, start, seed):
    """Whether f and W lie within what is stated, of 240 rows of a cycle with noise of 0.5 %."""
    score = score_loop(
        loop_of(*with_noise(*rows_of_varying(name, 240, start), 0.005, seed)), VARYING[name]
    )
    measured = score.loops[0]
    assert score.noise == pytest.approx(0.005 * np.ptp(score.displacement) / 2, rel=0.25)
    return score.is_scene_friction_within, abs(
        measured.area - varying_work(name)
    ) <= measured.area_uncertainty


def test_where_p_varies_noise_is_covered():
    assert covered_of_varying("90 degrees", 0.2, seed=2) == (True, True)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["line", "90 degrees"])
def test_where_p_varies_noise_is_covered_in_nine_of_ten(name):
    covered = np.array([covered_of_varying(name, seed / 20, seed) for seed in range(20)])
    assert covered.sum(axis=0).min() >= 17


@pytest.mark.slow
def test_of_two_minima_the_lower_one_is_taken():
    """With these rows a loop that hardly slips, in a stiffer rig, has the lower sum of squares
    before the turning points of Q are fitted.
    """
    rows = loop_of(*with_noise(*rows_of_varying("90 degrees", 240, 0.2), 0.005, 56))
    assert score_loop(rows, VARYING["90 degrees"]).friction < 1.5 * FRICTION


def test_a_loop_that_begins_while_Q_stands_closes_where_U_comes_back():
    """A rectangle of U over Q, 20 rows a side, from the middle of its upper side on."""
    side = np.arange(20) / 20
    u = np.roll(np.concatenate([side, 1 + 0 * side, 1 - side, 0 * side]), -10)
    q = np.roll(np.concatenate([1 + 0 * side, 1 - side, 0 * side, side]), -10)
    phase = np.concatenate([np.full(10, 0.5), 0.5 + (1 - q[10:30]) / 2, np.full(20, 1.0)])
    phase = np.concatenate([phase, 1 + q[50:70] / 2, np.full(10, 1.5)])
    area = loop_area.polygon_area(u, q, phase, 0.0, 0.0)
    assert area.value == pytest.approx(1.0, abs=1e-12)
    assert area.uncertainty < 0.01


def test_a_path_with_more_turning_points_is_placed_over_time():
    """A small wave within the large one: time says on which of its sides a row lies."""
    points = [(LOAD, -LARGEST), (1.1 * LOAD, 0.2 * LARGEST), (LOAD, -0.2 * LARGEST)]
    scene = with_cycle(*points, (LOAD, LARGEST))
    shares, shift, load, work = steady_cycle(scene)
    places = np.mod(0.13 + 3 * np.arange(721) / 720, 1.0)
    u, q = (np.interp(places, shares, values) for values in (shift, load))
    score = score_loop(loop_of(u, q), scene)
    assert score.friction == pytest.approx(FRICTION, rel=1e-3)
    assert score.loops[0].area == pytest.approx(work, rel=1e-2)
    assert any("follow the scene's Q over time" in sentence for sentence in score.notes)


@pytest.mark.parametrize(("rig_compliance", "n_fitted"), [(RIG, 2), (None, 3)])
def test_noise_of_a_loop_over_time_counts_the_fitted_parameters(rig_compliance, n_fitted):
    """Its parameters are f, U0, and C where it is not stated."""
    points = [(LOAD, -LARGEST), (1.1 * LOAD, 0.2 * LARGEST), (LOAD, -0.2 * LARGEST)]
    scene = with_cycle(*points, (LOAD, LARGEST))
    shares, shift, load, _ = steady_cycle(scene)
    places = np.mod(3 * np.arange(31) / 30, 1.0)
    u, q = (np.interp(places, shares, values) for values in (shift, load))
    rows = loop_of(*with_noise(u + RIG * q, q, 0.02, 8))
    fit = fit_over_time(rows, scene, rig_compliance)
    sum_of_squares, _, _ = fit_rig(
        rows,
        theory_displacement(scene, fit.friction / fit.load_scale),
        fit.share_of_cycle,
        fit.load_scale * cycle_loads(scene)[1],
        fit.load_scale,
        rig_compliance,
    )
    noise = (sum_of_squares / (len(rows.load) - n_fitted)) ** 0.5
    assert fit.displacement_noise == pytest.approx(noise, rel=1e-9)


def part_of(u, q, begin, end):
    return u[begin:end], q[begin:end]


def no_loop_of(name):
    """Rows that are no loop."""
    u, q = rows_of("Q", "sine", 100)
    return {
        "60 of 100 rows": part_of(u, q, 0, 60),
        "45 of 100 rows": part_of(u, q, 10, 55),
        "five rows a cycle": rows_of("Q", "sine", 100, cycles=20),
        "U stands still": (0 * u, q),
        "Q stands still": (u, 0 * q),
    }[name]


NO_LOOPS = {
    "60 of 100 rows": "of a cycle: a loop needs a whole one",
    "45 of 100 rows": "of a cycle: a loop needs a whole one",
    "five rows a cycle": "rows a cycle|of its amplitude only",
    "U stands still": "U is the same in every row",
    "Q stands still": "Q is the same in every row",
}


@pytest.mark.parametrize("name", NO_LOOPS)
def test_what_is_no_loop_is_refused(name):
    with pytest.raises(InputError, match=NO_LOOPS[name]):
        score_loop(loop_of(*no_loop_of(name)), SCENE)


# ----------------------------------------------------------------------- rows of no steady loop
def unsteady(name):
    """Rows of four cycles that no steady loop of theory has."""
    u, q = rows_of("U", "sine", 241, cycles=4)
    cycle = 4 * np.arange(len(u)) / (len(u) - 1)
    if name == "walks":
        return u + 0.1 * np.ptp(u) * cycle, q
    if name == "hardens":
        # elastic and plastic, with hardening: two straight lines a branch
        passed = np.abs(np.mod(cycle, 1.0) - 0.5) * 4
        passed = np.where(np.mod(cycle, 1.0) < 0.5, 2 - passed, passed)
        force = np.where(passed < 0.6, passed, 0.6 + 0.2 * (passed - 0.6)) - 0.44
        sign = np.where(np.mod(cycle, 1.0) < 0.5, -1, 1)
        return sign * (passed - 1) * np.ptp(u) / 2, sign * force * np.ptp(q)
    if name == "waves":
        return u + 0.02 * np.ptp(u) * np.sin(6 * np.pi * cycle), q
    size = {
        "grows": 1 + 0.06 * cycle,
        "shrinks": 1 - 0.06 * cycle,
        "every second cycle": 1 + 0.1 * np.cos(np.pi * cycle),
    }[name]
    return size * u, size * q


UNSTEADY = {
    "grows": "its cycles grow: Q of one cycle",
    "shrinks": "its cycles shrink: Q of one cycle",
    "every second cycle": "its period is another",
    "walks": r"U moves on by \+7.* % of its range in each cycle",
    "hardens": "its Q rises by .* % of its range while the contact slides as a whole",
    "waves": "their form is not that of theory",
}


@pytest.mark.parametrize("name", UNSTEADY)
def test_rows_of_no_steady_loop_are_refused_with_the_reason(name):
    with pytest.raises(InputError, match=UNSTEADY[name]):
        score_loop(loop_of(*with_noise(*unsteady(name), 0.002, seed=1)), SCENE)


@pytest.mark.parametrize("change", [0.05, -0.04])
def test_cycles_that_grow_in_noise_are_not_cut_until_they_seem_alike(change):
    """Cycles that grow to the end have no run-in, however few are left in the end."""
    u, q = rows_of("Q", "sine", 140, cycles=7)
    size = 1 + change * 7 * np.arange(len(u)) / (len(u) - 1)
    word = "grow" if change > 0 else "shrink"
    with pytest.raises(InputError, match=f"its cycles {word}, and its noise is too large to tell"):
        score_loop(loop_of(*with_noise(size * u, size * q, 0.05, seed=5)), SCENE)


def test_cycles_that_grow_in_noise_are_refused_by_u_and_q_together():
    """Neither U nor Q of so few rows is enough."""
    u, q = rows_of("U", "triangle", 90, cycles=2.9)
    size = 1 + 0.2 * np.arange(len(u)) / (len(u) - 1)
    with pytest.raises(InputError, match=r"its cycles grow, by .* U and Q together show it"):
        score_loop(loop_of(*with_noise(size * u, size * q, 0.05, seed=8)), SCENE)
    score = score_loop(loop_of(*with_noise(u, q, 0.05, seed=8)), SCENE)
    assert score.is_scene_friction_within


def test_a_run_in_that_fades_in_noise_is_held_by_the_interval():
    """Half a per cent of f may be missing behind a run-in: too little to be seen."""
    u, q = rows_of("U", "sine", 120, cycles=4.4, start=0.2)
    cycle = 4.4 * np.arange(len(u)) / (len(u) - 1)
    rising = q * (1 - 0.4 * np.exp(-cycle / 0.5))
    rows = with_noise(u + RIG * (rising - q), rising, 0.005, seed=6)
    score = score_loop(loop_of(*rows), SCENE)
    assert any("are left out: run-in" in note for note in score.notes)
    assert any("the interval of f holds it" in note for note in score.notes)
    assert score.is_scene_friction_within


def gross_rows(rows_of_branch, cycles=3):
    """Rows of a loop that slides at f P by a third of its range of U, and its W by hand."""
    path = GROSS.load.path()
    half = np.linspace(0.0, 0.5, rows_of_branch, endpoint=False)
    times = path.cycle_start + path.period * (1 + half)
    solution = semi_analytic.solve(
        GROSS,
        x=0.0,
        time=times,
        fields=("tangential_displacement", "dissipation"),
        cycles="steady",
    )
    u = solution.tangential_displacement + RIG * solution.tangential_load
    q = solution.tangential_load
    slide = abs(2 * u[0]) / 3
    steps = np.linspace(0.0, 1.0, rows_of_branch // 2, endpoint=False)
    u = np.concatenate([u + slide / 2, -u[0] + slide / 2 - slide * steps])
    q = np.concatenate([q, np.full(len(steps), -q[0])])
    u, q = np.concatenate([u, -u]), np.concatenate([q, -q])
    return np.tile(u, cycles), np.tile(q, cycles), solution.dissipation + 2 * slide * q[0]


@pytest.mark.parametrize(("rows_of_branch", "noise"), [(40, 0.002), (14, 0.0)])
def test_a_loop_that_slides_as_a_whole_has_f_from_its_plateaus(rows_of_branch, noise):
    u, q, work = gross_rows(rows_of_branch)
    score = score_loop(loop_of(*with_noise(u, q, noise, seed=2)), GROSS)
    assert score.lowest_friction <= NEARLY / LOAD <= score.highest_friction
    assert score.friction == pytest.approx(NEARLY / LOAD, rel=1e-8 + noise)
    assert abs(score.loops[0].area - work) <= score.loops[0].area_uncertainty
    assert score.loops[1].area == pytest.approx(work, rel=1e-4 + noise)
    assert any("The contact slides as a whole" in note for note in score.notes)
    assert [row.name for row in score.loops] == [
        "measured",
        "theory, best f",
        "theory, the scene's f",
    ]


def test_plateaus_of_few_digits_leave_f_open_by_a_step():
    """All rows of a plateau at Q = 88 N/mm say 90, in steps of 5: their number helps nothing."""
    u, q, _ = gross_rows(14)
    rounded = MeasuredLoop("rig", u, 5 * np.round(q / 5), 1.0 * np.arange(len(u)), (), (0.0, 5.0))
    score = score_loop(rounded, GROSS)
    assert score.friction == pytest.approx(90 / LOAD, rel=5e-3)
    assert score.lowest_friction <= FRICTION <= score.highest_friction
    assert score.highest_friction - score.lowest_friction < 3 * 5 / LOAD


def test_a_small_drift_of_u_is_taken_out_and_said():
    u, q = with_noise(*rows_of("Q", "sine", 240, cycles=4, start=0.2), 0.001, seed=3)
    drifting = u + 0.02 * np.ptp(u) * np.linspace(0.0, 1.0, len(u))
    score = score_loop(loop_of(drifting, q), SCENE)
    assert holds(score) == (True, True)
    assert score.friction == pytest.approx(FRICTION, rel=0.02)
    assert any(note.startswith("U drifts by +0.5 %") for note in score.notes)


def test_a_run_in_is_left_out_and_said():
    u, q = with_noise(*rows_of("Q", "sine", 240, cycles=4, start=0.2), 0.001, seed=3)
    ramp = np.linspace(0.0, 1.0, 12, endpoint=False)
    u, q = np.concatenate([u[0] * ramp**2, u]), np.concatenate([q[0] * ramp, q])
    score = score_loop(loop_of(u, q), SCENE)
    assert holds(score) == (True, True)
    assert score.friction == pytest.approx(FRICTION, rel=0.02)
    assert any("may be of the initial loading" in note for note in score.notes)


@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_half_cycles_are_left_out_until_f_no_longer_rises(noise):
    """f comes up from 0.6 of its last value, by a factor of e in half a cycle."""
    u, q = rows_of("U", "sine", 320, cycles=8, start=0.2)
    cycle = 8 * np.arange(len(u)) / (len(u) - 1)
    rising = q * (1 - 0.4 * np.exp(-cycle / 0.5))
    score = score_loop(loop_of(*with_noise(u + RIG * (rising - q), rising, noise, seed=4)), SCENE)
    assert score.is_scene_friction_within
    assert score.friction == pytest.approx(FRICTION, rel=0.02)
    assert any("are left out: run-in" in note for note in score.notes)


def test_neighbours_on_one_side_of_the_fit_widen_the_interval():
    """A wave of U that no loop has: too small to be refused, too large for the scatter."""
    u, q = with_noise(*rows_of("Q", "sine", 240, cycles=4), 0.0001, seed=3)
    wave = 0.0002 * np.ptp(u) * np.sin(2 * np.pi * 7.3 * np.arange(len(u)) / len(u))
    plain = score_loop(loop_of(u, q), SCENE)
    waving = score_loop(loop_of(u + wave, q), SCENE)
    assert waving.highest_friction - waving.lowest_friction > 3 * (
        plain.highest_friction - plain.lowest_friction
    )
    assert any("Neighbouring rows lie on the same side" in note for note in waving.notes)
    assert not any("Neighbouring rows" in note for note in plain.notes)


# ---------------------------------------------------------------------------------- tables of loops
def written(path, head, first, second, tail=""):
    rows = [f"{a:.7g},{b:.7g}{tail}" for a, b in zip(first.tolist(), second.tolist(), strict=True)]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


def test_forces_over_a_stated_thickness_are_loads(tmp_path):
    u, q = rows_of("Q", "triangle", 100)
    written(tmp_path / "loop.csv", ["Displacement (µm),Tangential force (N)"], 1e3 * u, 12 * q)
    loop = read_loop(tmp_path / "loop.csv", Mapping(thickness=12.0), SCENE)
    np.testing.assert_allclose(loop.load, q, rtol=1e-6, atol=1e-6 * LARGEST)
    read = dict(loop.read_as)
    assert read["relative displacement U"] == (
        "'Displacement (µm)', µm (in its heading), times 0.001"
    )
    assert read["tangential load Q"] == (
        "'Tangential force (N)', N (in its heading), times 1, over the thickness 12"
    )
    assert read["time"] == "no column: rows follow each other evenly"
    assert score_loop(loop, SCENE).is_scene_friction_within
    with refused_for("factors.load", "thickness"):
        read_loop(tmp_path / "loop.csv", Mapping(), SCENE)
    written(tmp_path / "loop.csv", ["Displacement (µm),Tangential force (N/mm)"], 1e3 * u, q)
    with refused_for("N/mm", "a force per length", "thickness"):
        read_loop(tmp_path / "loop.csv", Mapping(thickness=12.0), SCENE)


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("U (furlongs),Q [N/mm]", r"'U \(furlongs\)' is in furlongs, .*: state factors.length"),
        ("U [mm],Q [volts]", r"'Q \[volts\]' is in volts, .*: state factors.load"),
        ("U [mm],Force N", r"'Force N' is in N, .*: state factors.load .* the thickness"),
    ],
)
def test_a_unit_that_cannot_be_used_is_asked_for(tmp_path, head, words):
    u, q = rows_of("Q", "triangle", 100)
    written(tmp_path / "loop.csv", [head], u, q)
    columns = {"slip": 1, "tangential_load": 2}
    with pytest.raises(InputError, match=words):
        read_loop(tmp_path / "loop.csv", Mapping(columns=columns), SCENE)
    stated = Mapping(columns=columns, factors={"length": 1.0, "load": 0.5})
    loop = read_loop(tmp_path / "loop.csv", stated, SCENE)
    assert dict(loop.read_as)["tangential load Q"].endswith(
        "times 0.5 (factors.load of the mapping)"
    )


def test_two_columns_without_names_are_taken_by_number(tmp_path):
    u, q = rows_of("Q", "triangle", 100)
    written(tmp_path / "loop.csv", [], u, q)
    with refused_for("numbers only", "columns.slip = 1"):
        read_loop(tmp_path / "loop.csv", Mapping(), SCENE)
    (tmp_path / "map.toml").write_text("[columns]\nslip = 1\n", encoding="utf-8")
    mapping = load_mapping(tmp_path / "map.toml")
    loop = read_loop(tmp_path / "loop.csv", mapping, SCENE)
    np.testing.assert_allclose(loop.displacement, u, rtol=1e-6, atol=1e-6 * np.ptp(u))
    np.testing.assert_allclose(loop.load, q, rtol=1e-6, atol=1e-6 * LARGEST)
    with refused_for("columns.slip = 3", "2 columns"):
        read_loop(tmp_path / "loop.csv", Mapping.model_validate({"columns": {"slip": 3}}), SCENE)
    with refused_for("'column 1'", "for U and for Q"):
        read_loop(
            tmp_path / "loop.csv",
            Mapping.model_validate({"columns": {"slip": 1, "tangential_load": 1}}),
            SCENE,
        )
