"""Whole load paths by finite elements: laws and energy at every instant, steady state, increments,
events, layer, long records.
"""

from __future__ import annotations

import math
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import halfplane_fe
import halfplane_fe.run
import scene_cases
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings, stepping
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.interface import Interface
from halfplane_fe.run import Pace, run_path, trend
from halfplane_fe.systems import Layer
from halfplane_fe.task import Task
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, fe_run, law_violations, layer_run, stepped_run
from reports.comparison.laws import certificates
from reports.comparison.work_of_loads import bulk_strain
from scene_cases import CASES
from scenes import (
    Block,
    Bodies,
    ConvergenceError,
    Elastic,
    EllipseLoad,
    Hertz,
    InputError,
    Materials,
    PolygonLoad,
    Scene,
    SurfaceState,
    TimeSeriesLoad,
    load_scene,
    scene_names,
)
from scenes.array_types import States
from tolerances import check

STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
ALUMINIUM = Elastic(young_modulus=70e3, poisson_ratio=0.33)
UNLIKE = Materials(upper=ALUMINIUM, lower=STEEL)
BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import long_record  # noqa: E402

sys.path.remove(str(BENCHMARKS))


def scene_of(name):
    """A scene of a file; "..., unlike" with an upper body of aluminium."""
    scene = scene_cases.scene_of(name.removesuffix(", unlike"))
    return scene.vary(material=UNLIKE) if name.endswith("unlike") else scene


# -------------------------------------------------------------- admissible: what needs no reference
NAMED = {
    "equilibrium",
    "tension",
    "penetration",
    "gap_pressure",
    "cone",
    "slip_sign",
    "creep",
    "energy_balance",
}


# One of each kind of load, body and pair of materials; the rest of the library is slow.
AT_ONCE = {
    "hertz-normal",
    "full-stick",
    "cattaneo-mindlin",
    "cattaneo-mindlin, unlike",
    "harmonics",
    "time-series",
    "roller-line-of-action",
    "tilted-flat-pad",
    "thin-blocks",
    "flat-pad-on-block",
}
EVERY = [
    *scene_names(),
    *CASES,
    "hertz-paper, unlike",
    "cattaneo-mindlin, unlike",
    "hertz-normal, unlike",
]


@pytest.mark.parametrize(
    "name",
    [name if name in AT_ONCE else pytest.param(name, marks=pytest.mark.slow) for name in EVERY],
)
def test_every_scene_keeps_the_laws_and_its_energy_at_every_instant(name):
    """The solver's own certificates; the laws from the arrays that a reader sees; work of the loads
    is stored or rubbed away.
    """
    answer = fe_run(scene_of(name))
    record = answer.record
    energy = answer.record.energy
    assert record.converged
    assert set(record.certificates) >= NAMED
    for values in record.certificates.values():
        assert values.shape == answer.time.shape
        check("certificates", float(np.abs(values).max()))
    for violation, size in law_violations(answer).items():
        check("open pressure" if violation == "open pressure" else "certificates", size)
    assert np.all(np.diff(answer.time) > 0)
    assert np.all(answer.contact_edges[1:, 0] < answer.contact_edges[1:, 1])
    mean = lambda values: (values[1:] + values[:-1]) / 2  # noqa: E731
    normal = mean(answer.normal_load) * np.diff(answer.normal_approach)
    external = normal + mean(answer.tangential_load) * np.diff(answer.tangential_displacement)
    if answer.shear_moment is not None:
        strain = bulk_strain(answer, answer.scene.material)
        external -= mean(answer.moment) * np.diff(answer.tilt) + mean(
            answer.shear_moment
        ) * np.diff(strain)
    np.testing.assert_allclose(
        energy["external"][1:], external, atol=1e-12 * np.abs(external).max()
    )
    rest = (
        np.cumsum(external) - np.cumsum(energy["elastic"][1:]) - np.cumsum(energy["interface"][1:])
    )
    check("certificates", float(np.abs(rest).max() / np.abs(np.cumsum(external)).max()))
    assert np.all(energy["dissipation"] >= 0)


def test_stops_when_the_cycle_repeats_and_says_so():
    answer = fe_run(load_scene("cattaneo-mindlin"))
    assert (answer.steady_from, len(answer.cycle_dissipation), answer.record.termination) == (
        1,
        2,
        "steady",
    )
    assert answer.record.message.startswith("revolution 2 ended in the state it started from")
    assert answer.work.skipped["revolutions"][0] == answer.scene.cycles - 2
    start, end = answer.last_cycle[[0, -1]]
    np.testing.assert_allclose(
        answer.shear[end], answer.shear[start], atol=1e-9 * answer.pressure.max()
    )
    path = fe_run(load_scene("hertz-normal"))
    assert (path.steady_from, path.record.termination, len(path.cycle_dissipation)) == (
        None,
        "end of path",
        1,
    )
    assert path.last_cycle.tolist() == list(range(len(path.time)))


# Dissipation of revolution k = 1, 2, ...; where it goes; from how many revolutions on the trend is
# known, and its name.
SERIES = {
    "steady from the second on": (lambda k: np.where(k == 1, 5.0, 1.0), 1.0, 3, "steady"),
    "geometric": (lambda k: 1 + 0.5**k, 1.0, 4, "geometric"),
    "geometric, from below, slowly": (lambda k: 1 - 0.9**k, 1.0, 4, "geometric"),
    "k^-3": (lambda k: 1 + k**-3, 1.0, 4, "algebraic"),
    "k^-2, after a loading of its own": (
        lambda k: np.where(k == 1, 3.0, 1 - k**-2),
        1.0,
        5,
        "algebraic",
    ),
    "k^-1": (lambda k: 1 + 0.3 / k, 1.0, 4, "algebraic"),
    "grows": (lambda k: k, np.nan, 2, "unclear"),
    "swings": (lambda k: 1 + (-0.5) ** k, np.nan, 2, "unclear"),
    "log k": (lambda k: 1 + np.log(k), np.nan, 2, "unclear"),
}


@pytest.mark.parametrize("count", [6, 12, 25])
@pytest.mark.parametrize("name", SERIES)
def test_the_trend_of_a_series_and_what_is_left_of_it(name, count):
    series, limit, known, kind = SERIES[name]
    values = series(np.arange(1.0, count + 1)).tolist()
    forecast = trend(values)
    assert forecast.kind == kind
    if kind == "unclear":
        assert np.isnan(forecast.limit)
        assert forecast.change_to_limit == pytest.approx(count * abs(values[-1] - values[-2]))
    else:
        left = limit - values[-1]
        assert forecast.change_to_limit == pytest.approx(left, rel=0.04, abs=1e-15)
        assert forecast.limit == pytest.approx(limit, abs=0.04 * abs(left) + 1e-15)
    assert trend(values[: known - 1]).kind == "unclear"
    assert np.isnan(trend(values[:1]).change_to_limit)


@pytest.mark.parametrize(
    ("name", "uncertainty", "revolutions"),
    [
        ("steady from the second on", 0.0, 3),  # the third has the dissipation of the second
        ("geometric", 1e-4, 14),  # 2^-14 = 6.1e-5
        ("k^-3", 1.1e-3, 10),  # a thousandth is left after ten
        ("k^-3", np.nan, 13),  # unknown: what is left is 5e-4 of W
        ("grows", 1e-3, 30),
    ],
)
def test_revolutions_go_on_while_the_dissipation_has_more_to_go_than_its_uncertainty(
    monkeypatch, name, uncertainty, revolutions
):
    series = SERIES[name][0]

    def revolve(follower, _legs, _n_increments, title):
        run = follower.run
        if title.startswith("revolution"):
            run.nodal_work = np.array([float(series(np.float64(title.split()[1])))])
        moved = run.states[-1].pressure + 1e-6  # nodal forces that all but repeat
        run.states.append(run.states[-1].changed(pressure=np.where(moved > 1e-5, moved, 1.0)))

    monkeypatch.setattr("halfplane_fe.run._Follower.follow_segments", revolve)
    problem, load = walking(0.7, 0.9)
    outcome = run_path(
        problem,
        load.path(),
        Pace(1.0, 8, np.inf),
        30,
        lambda *_: None,
        uncertainty=lambda _run: uncertainty,
    )
    assert len(outcome.nodal_work_by_cycle) == revolutions
    assert outcome.steady_from == (revolutions - 1 if revolutions < 30 else None)


def walking(low, high):
    """Two nodes on springs: Q moves pressure from one to the other, and the one with less slides
    forward.
    """
    none = np.zeros(2)
    coupling = 6 * np.array([[1.0, -1.0], [1.0, -1.0]])
    faces = Interface(
        np.array([0.0, 1.0]),
        np.ones(2),
        np.array([[0, 0], [1.0, 1.0]]),
        none,
        np.eye(2),
        200 * np.eye(2),
        coupling,
    )
    problem = ContactProblem(faces, np.array([9.6, 0.0]), 0.5, Layer(none, none))
    return problem, PolygonLoad(initial_loading=[(2.0, 0.8), (2.0, low)], cycle=[(2.0, high)])


@pytest.mark.parametrize(
    ("swing", "drift"), [(0.1, 160.0), (0.08, 112.0), (0.05, 40.0), (0.02, 0.0)]
)
def test_a_contact_that_walks_is_said_to_ratchet(swing, drift):
    """p = 1 +- 6 (Q - 0.8), f = 0.5; each node holds back the other by f p, and lets go by turns: U
    gains 2400 (swing - 1/30).
    """
    problem, load = walking(0.8 - swing, 0.8 + swing)
    run = run_path(problem, load.path(), Pace(1.0, 8, np.inf), 6, lambda *_: None)
    assert run.force_change_by_cycle[-1] < 1e-12
    assert run.states[-1].shift - run.states[run.cycle_starts[-1]].shift == pytest.approx(
        drift, abs=1e-9
    )
    assert drift == pytest.approx(max(2400 * (swing - 1 / 30), 0))
    assert run.ratchets == (drift > 0)
    work = run.nodal_work_by_cycle[-1].sum()
    assert work == pytest.approx(
        run.values_of_increments("loop_work")[run.cycle_starts[-1] :].sum(), abs=1e-9
    )
    assert (work > 0) == (drift > 0)


# Condensations, and whether a tangential problem is solved.
COUNTED = {
    "hertz-normal": (1, False),
    "hertz-normal, unlike": (2, True),
    "full-stick": (1, True),
    "hertz-paper": (1, True),
}


@pytest.mark.parametrize("name", COUNTED)
def test_work_counts(name):
    answer = fe_run(scene_of(name))
    counts = answer.work.counts
    skipped = answer.work.skipped
    condensations, tangential = COUNTED[name]
    assert counts["condensations"] == condensations
    assert ("condensations" in skipped, "tangential problem" in skipped) == (
        condensations == 1,
        not tangential,
    )
    assert (counts["steps solved"], counts["contact nodes"]) == (
        len(answer.time) - 1,
        len(answer.x),
    )
    # No answer has an instant of the coarse run: it locates no stick edges between its nodes.
    n_without_edges, reason = skipped["stick edges between nodes, coarse run"]
    assert n_without_edges > 0
    assert reason == "no answer reads them at its instants"
    # The first counts rejected steps. Of like bodies, events landed on, most increments are one
    # linear solve.
    assert counts["contact iterations"] >= answer.record.iterations.sum() >= counts["steps solved"]
    assert condensations == 2 or answer.record.iterations.sum() <= 1.8 * counts["steps solved"]
    assert all(reason for _, reason in skipped.values())
    assert name != "full-stick" or ("slip iterations" in skipped and counts["slip iterations"] == 0)


# --------------------------------------------------------------------------- units, initial loading


FEWER = MeshSettings(element_size=1 / 6, edge_element_size=1 / 10, far_radius=6.0, growth=0.5)
LONGER = 1e9
STIFFER = 1e12
FACTORS = {
    **dict.fromkeys(
        ("x", "slip", "contact_edges", "normal_approach", "tangential_displacement"), LONGER
    ),
    **dict.fromkeys(("pressure", "shear"), STIFFER),
    **{
        "time": 1.0,
        "state": 1,
        "dissipation_density": STIFFER * LONGER,
        "dissipation": STIFFER * LONGER**2,
    },
}


def test_units_do_not_matter():
    plain = load_scene("hertz-paper")
    settings = SolverSettings(steps_per_cycle=24)
    amounts = (
        "mean_normal_load",
        "normal_amplitude",
        "mean_tangential_load",
        "tangential_amplitude",
    )
    material = Elastic(young_modulus=210e3 * STIFFER, poisson_ratio=0.3)
    changed = plain.vary(
        material=Materials(upper=material, lower=material),
        profile=Hertz(radius=1000.0 * LONGER),
        load=plain.load.vary(
            **{name: getattr(plain.load, name) * STIFFER * LONGER for name in amounts}
        ),
    )
    plain_answer, scaled_answer = (fe_run(scene, FEWER, settings) for scene in (plain, changed))
    for field, factor in FACTORS.items():
        plain_values = np.asarray(getattr(plain_answer, field))
        scaled_values = np.asarray(getattr(scaled_answer, field)) / factor
        np.testing.assert_allclose(
            scaled_values,
            plain_values,
            rtol=0,
            atol=1e-9 * np.abs(plain_values).max(),
            err_msg=field,
        )


def test_the_initial_loading_is_forgotten():
    answers = [
        fe_run(load_scene("hertz-paper").vary(load={"initial_loading": way}))
        for way in ("parabola", "straight")
    ]
    check("initial loading", answers[0].dissipation / answers[1].dissipation - 1)


def test_progress_is_told():
    reports = []
    halfplane_fe.solve(
        load_scene("hertz-normal"),
        COARSE,
        FEW_STEPS,
        progress=lambda *report: reports.append(report),
    )
    assert [text for _, _, text in reports][:2] == [
        "coarse run",
        "meshing and condensing the bodies",
    ]
    counts = [
        (counts, total) for counts, total, text in reports if text.startswith("initial loading")
    ]
    assert counts[-1][0] == counts[-1][1]


# ----------------------------------------------------------------------------- energy of increments


@pytest.mark.parametrize("method", ["active_set", "augmented_lagrangian", "penalty"])
def test_balance_is_closed_at_every_step_and_the_layer_has_its_share(method):
    """External work = elastic energy, that of the layer in it, + trapezoidal work of the interface;
    without the layer it fails.
    """
    answer = stepped_run(method, 24)
    energy = answer.record.energy
    rest = energy["external"] - energy["elastic"] - energy["interface"]
    largest_work = np.abs(np.cumsum(energy["external"])).max()
    check("certificates", float(np.abs(rest).max() / largest_work))
    assert ("layer" in energy) == (method == "penalty")
    if method == "penalty":
        audit = answer.penalty
        weights = answer.condensed_bodies[0].face_lengths
        stored = (
            (
                answer.pressure**2 / audit.normal_stiffness
                + answer.shear**2 / audit.tangential_stiffness
            )
            @ weights
            / 2
        )
        np.testing.assert_allclose(np.cumsum(energy["layer"]), stored, atol=1e-12 * stored.max())
        assert np.abs(rest + energy["layer"]).max() > 1e-5 * largest_work


# ---------------------------------------------------------- increments: halved, landed, thrown away


MODEST = MeshSettings(element_size=1 / 8, edge_element_size=1 / 16, growth=0.5)


def unlike(name: str) -> Scene:
    return load_scene(name).vary(material=UNLIKE)


def test_rates_serve_the_energies_of_their_increments_from_a_small_cache(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A few increments at a time need few sets; with the energies of a stretch at its end the sets
    of its first increments would be gone, and solved for again.
    """
    settings = SolverSettings(steps_per_cycle=64)
    scene = unlike("hertz-paper").vary(cycles=1)
    kept = halfplane_fe.solve(scene, MODEST, settings)
    monkeypatch.setattr(halfplane_fe.contact, "_MOST_RATE_BYTES", 0)
    monkeypatch.setattr(halfplane_fe.contact, "_FEWEST_CACHED_SETS", 16)
    monkeypatch.setattr(halfplane_fe.run, "_INCREMENTS_PER_BATCH", 4)
    few = halfplane_fe.solve(scene, MODEST, settings, scales=kept.scales)
    monkeypatch.setattr(halfplane_fe.run, "_INCREMENTS_PER_BATCH", 10**9)
    at_end = halfplane_fe.solve(scene, MODEST, settings, scales=kept.scales)
    assert few.work.counts["rates"] < 1.2 * kept.work.counts["rates"]
    assert at_end.work.counts["rates"] > 1.3 * few.work.counts["rates"]
    assert few.dissipation == pytest.approx(kept.dissipation, rel=1e-12)


@cache
def record_of_turns(turns: int, **changes: object) -> FiniteElementSolution:
    """A record of half-planes, like ones by default: so many equal turns of P and Q, in eight rows
    each.
    """
    phase = 2 * np.pi * np.arange(8 * turns + 1) / 8
    rows = [0.01 * np.arange(len(phase)), 90 + 18 * np.cos(phase), 32 * np.sin(phase)]
    load = TimeSeriesLoad(rows=np.column_stack(rows).tolist())
    scene = load_scene("hertz-paper").vary(load=load, friction=0.6, tolerances={}, **changes)
    return halfplane_fe.solve(scene, MeshSettings.coarse())


def test_a_further_turn_of_a_record_takes_its_events_and_regular_increments() -> None:
    first = record_of_turns(1).work.counts
    longer = record_of_turns(4).work.counts
    landed = sum(
        longer[f"{event} increments"] - first[f"{event} increments"]
        for event in ("touch", "release")
    )
    regular = 3 * 8 * 3
    assert longer["steps solved"] - first["steps solved"] < 1.1 * (landed + regular)


def test_increments_of_unlike_bodies_begin_where_their_prediction_has_led() -> None:
    """A node that has just touched is expected to slide as its neighbour, and what follows a second
    prediction to have the states of the first: 1.5 linear solves an increment, 1.64 without the
    former, 1.9 without both.
    """
    counts = record_of_turns(1, material=UNLIKE).work.counts
    assert counts["touch increments"] + counts["release increments"] > 100
    assert counts["linear solves"] < 1.6 * counts["steps solved"]


def test_increments_of_records_are_halved_for_what_kinks_add_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bound of the step error would halve a hundred increments of these; the dissipation is the
    same to rounding, within its uncertainty.
    """
    halved = "increments halved, step error"
    answer = record_of_turns(1)
    assert answer.work.counts.get(halved, 0) < 10
    assert answer.record.energy["step_error"].sum() > 1e-3 * answer.dissipation
    exact = semi_analytic.solve(answer.scene).dissipation
    assert abs(answer.dissipation - exact) < answer.dissipation_uncertainty < 0.01 * exact
    monkeypatch.setattr(Task, "kinks_bound_step_error", property(lambda _: False))
    by_bound = halfplane_fe.solve(answer.scene, MeshSettings.coarse(), scales=answer.scales)
    assert by_bound.work.counts[halved] > 50
    assert by_bound.dissipation == pytest.approx(answer.dissipation, rel=1e-6)


def test_an_increment_that_fails_once_is_halved_and_leaves_no_trace(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Failures planted at whole increments: the answer at the regular instants is the one without
    them.
    """
    # constant P: the answer does not depend on the increments
    scene = load_scene("cattaneo-mindlin")
    settings = SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    plain = halfplane_fe.solve(scene, MODEST, settings)
    solve = ContactProblem.equilibrium
    failed = set()

    def failing(
        self: ContactProblem,
        history: InterfaceState,
        time: float,
        loads: tuple[float, float],
        expected: States | None = None,
    ) -> object:
        if time in {1.25, 2.5, 3.75} and time not in failed:
            failed.add(time)
            raise ConvergenceError("planted")
        return solve(self, history, time, loads, expected)

    monkeypatch.setattr(ContactProblem, "equilibrium", failing)
    halved = halfplane_fe.solve(scene, MODEST, settings)
    assert len(failed) == 3
    assert halved.dissipation == pytest.approx(plain.dissipation, rel=1e-10)
    np.testing.assert_allclose(halved.shear[-1], plain.shear[-1], atol=1e-9 * plain.pressure.max())


def test_a_node_at_its_event_is_what_it_was_in_the_increment_that_led_there() -> None:
    """One that let go has slid for all of the increment, or stuck, whatever it slipped before; one
    that touches was open.
    """
    closed = SurfaceState.STICK
    opened = SurfaceState.OPEN
    rest = InterfaceState(0.0, (0.0, 0.0), np.zeros(3 + 4 * 4), np.zeros(4, dtype=np.int8))
    history = rest.changed(slip=[1.0, 1.0, 1.0, 1.0], node_states=[closed, closed, closed, opened])
    solved = history.changed(
        slip=[1.0, 1.5, 0.5, 2.0], node_states=[opened, opened, opened, closed]
    )
    expected = [
        SurfaceState.STICK,
        SurfaceState.SLIP_FORWARD,
        SurfaceState.SLIP_REVERSE,
        SurfaceState.OPEN,
    ]
    assert stepping.states_up_to_event(history, solved).tolist() == expected
    far = solved.changed(gap=np.ones(4))
    assert stepping.states_up_to_event(history, far).tolist() == far.node_states.tolist()


@pytest.mark.parametrize("stiffer", [0.0, 1e-5])
def test_each_node_touches_at_an_instant_of_its_own(stiffer: float) -> None:
    """A node that closes does so without a gap or without a force: 5e-12 at most. The two sides of
    bodies that are hardly unlike touch so soon after each other that the second node, still open by
    1e-8 to 1e-5, must not be taken for met with the first.
    """
    lower = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    load = PolygonLoad(initial_loading=[(30, 0), (60, 6), (90, -9)])
    upper = lower.model_copy(update={"young_modulus": 210e3 * (1 + stiffer)})
    scene = load_scene("hertz-paper").model_copy(
        update={"material": Materials(upper=upper, lower=lower), "load": load}
    )
    coarse = MeshSettings(element_size=1 / 4, edge_element_size=1 / 8, far_radius=6.0, growth=0.5)
    states = halfplane_fe.solve(
        scene, coarse, SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    ).states
    closing = [
        np.minimum(before.gap, np.abs(after.pressure) + np.abs(after.gap))[
            ~before.is_closed & after.is_closed
        ]
        for before, after in pairwise(states)
    ]
    assert sum(len(part) for part in closing) >= 25
    assert max(float(part.max(initial=0.0)) for part in closing) < 1e-9


@pytest.mark.parametrize(("height", "limit"), [(0.4, 8e-4), (1.0, 4e-4)])
def test_increments_of_layers_end_where_slip_ends_and_lose_none_of_it(
    height: float, limit: float
) -> None:
    """Slip of layers does not end where Q - f P or Q + f P turns round. Increments over its end
    lost it, and W of these was 2e-3 and 1.4e-3 too small, however small the step tolerance.
    """
    layer = Block(width=16.0, height=height)
    layers = load_scene("hertz-paper").vary(bodies=Bodies(lower=layer, upper=layer), cycles=2)
    mesh = MeshSettings(element_size=1 / 8, edge_element_size=1 / 32, far_radius=6.0, growth=0.5)
    usual = halfplane_fe.solve(layers, mesh)
    fine_steps = SolverSettings(steps_per_cycle=384, step_tolerance=1e-5)
    fine = halfplane_fe.solve(layers, mesh, fine_steps)
    assert usual.work.counts["increments ended where slip ends"] <= 40
    assert usual.dissipation == pytest.approx(fine.dissipation, rel=limit)


def test_slip_of_half_planes_ends_where_their_loads_turn_round() -> None:
    answer = halfplane_fe.solve(load_scene("hertz-paper"), MODEST)
    assert "increments ended where slip ends" not in answer.work.counts


def test_what_events_leave_of_a_force_does_not_stay_missing_from_the_load() -> None:
    """Of coupled bodies an event is met to 1e-9: the next increment solves for it, whether or not a
    node changes its state.
    """
    time = np.linspace(0.0, 1.0, 25)
    rows = np.column_stack(
        [
            time,
            500 + 40 * np.sin(2 * np.pi * time),
            60 * (np.sin(2 * np.pi * time - 0.7) + np.sin(0.7)),
        ]
    )
    scene = load_scene("pad-on-block").vary(
        load={"kind": "time_series", "rows": rows.tolist(), "repeats": False}
    )
    checks = halfplane_fe.solve(scene, MeshSettings.coarse()).record.certificates
    assert (
        max(float(np.max(np.abs(checks[law]))) for law in ("equilibrium", "energy_balance")) < 1e-12
    )


NEWTON = ContactProblem._solve_by_active_set


def no_newton(self: ContactProblem, states: np.ndarray, *rest: object) -> object:
    """Newton's iteration for the normal problem alone."""
    return (None, 1, 0) if self.has_shear else NEWTON(self, states, *rest)


def test_the_convex_halves_give_newtons_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """With Newton's iteration switched off the alternating one has to find every state, of like and
    of unlike bodies.
    """
    settings = SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    for scene, limit in (
        (load_scene("cattaneo-mindlin"), 1e-10),
        (unlike("cattaneo-mindlin"), 1e-9),
    ):
        newton = halfplane_fe.solve(scene, MODEST, settings)
        with monkeypatch.context() as patch:
            patch.setattr(ContactProblem, "_solve_by_active_set", no_newton)
            halves = halfplane_fe.solve(scene, MODEST, settings)
        assert halves.work.counts["alternating solves"] > 0
        assert halves.dissipation == pytest.approx(newton.dissipation, rel=limit)
        assert max(float(values.max()) for values in halves.record.certificates.values()) < 1e-9


def test_near_gross_sliding_no_node_is_forced_to_stick_beyond_the_cone() -> None:
    """Unlike bodies, f = 0.039, initial loading and cycle at 0.999 of gross sliding: a false
    convergence here once left q > f p.
    """
    soft = Elastic(young_modulus=2e4, poisson_ratio=0.1)
    hard = Elastic(young_modulus=2.1e5, poisson_ratio=0.3)
    load = EllipseLoad(
        mean_normal_load=100, normal_amplitude=11, tangential_amplitude=3.85, phase_degrees=-87
    )
    scene = load_scene("hertz-paper").vary(
        material=Materials(upper=soft, lower=hard), friction=0.039, load=load
    )
    answer = halfplane_fe.solve(scene, MODEST, SolverSettings(steps_per_cycle=32))
    assert answer.record.certificates["cone"].max() < 1e-9
    assert answer.record.certificates["slip_sign"].max() < 1e-9


def test_halving_that_never_arrives_ends_with_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every trial is to be halved: the same instant was tried for ever."""
    calls = []

    def stuck(*arguments: object) -> stepping.NotConverged:
        calls.append(arguments)
        assert len(calls) < 100_000, "a loop without end"
        return stepping.NotConverged(0.0)

    monkeypatch.setattr(stepping, "_attempted_increment", stuck)
    with pytest.raises(
        ConvergenceError, match="was not reached: nodes touch and let go without end"
    ):
        halfplane_fe.solve(load_scene("cattaneo-mindlin"), MODEST)


def test_solve_raises_and_keeps_the_steps_solved_so_far(monkeypatch):
    """Sets of nodes that never agree from some instant on: what was solved is kept, and says
    that.
    """
    active_set = ContactProblem._solve_by_active_set

    def gives_up(self, history, time, loads, states):
        return (None, 2, 3) if time > 3 else active_set(self, history, time, loads, states)

    scene = load_scene("hertz-paper")
    scales = halfplane_fe.solve(scene, COARSE, SolverSettings(steps_per_cycle=8)).scales
    monkeypatch.setattr(ContactProblem, "_solve_by_active_set", gives_up)
    monkeypatch.setattr(
        ContactProblem, "_alternate_pressure_and_shear", lambda self, *rest: (None, 1, 1)
    )
    with pytest.raises(
        ConvergenceError, match=r"after \d+ iterations at time .* normal load .* tangential load"
    ) as caught:
        halfplane_fe.solve(
            scene, COARSE, SolverSettings(steps_per_cycle=8, step_tolerance=np.inf), scales=scales
        )
    partial = caught.value.partial
    assert partial is not None
    assert (partial.record.converged, partial.record.termination) == (False, "not converged")
    assert partial.record.message == str(caught.value)
    path = scene.load.path()
    assert path.start < partial.time[-1] < path.cycle_start + path.period
    assert partial.pressure.shape == (len(partial.time), len(partial.x))
    assert partial.pressure[-1].max() > 0
    assert np.all(np.diff(partial.time) > 0)


BAD = (
    {"method": "mortar"},
    {"normal_stiffness": 0.0},
    {"tangential_stiffness": float("nan")},
    {"steps_per_cycle": 3},
    {"max_iterations": 1},
    {"step_tolerance": 0.0},
)


@pytest.mark.parametrize("settings", BAD, ids=str)
def test_settings_refuse_bad_values(settings):
    ((key, value),) = settings.items()
    with pytest.raises(InputError, match=f"{key} = {value!r} is refused"):
        SolverSettings(**settings)


# ---------------------------------------------------------------------- penalty layer and exact law


def test_active_set_is_independent_of_the_weights_over_six_decades():
    """To the last bit: where the law is met the projection of (p - r g, q + r ds) is (p, q) for any
    r.
    """
    plain = layer_run("hertz-paper", "active_set", 1e3)
    for weight in (1.0, 1e6):
        answer = layer_run("hertz-paper", "active_set", weight)
        for field in ("time", "pressure", "shear", "slip", "state"):
            np.testing.assert_array_equal(
                getattr(answer, field), getattr(plain, field), err_msg=f"{field}, {weight:g}"
            )
        assert answer.work.counts["contact iterations"] == plain.work.counts["contact iterations"]
    audit = plain.penalty
    assert np.isinf([audit.normal_stiffness, audit.tangential_stiffness]).all()
    assert (audit.penetration, audit.elastic_slip, plain.settings["penalty"]) == (0.0, 0.0, {})
    check("certificates", audit.creep_share)  # rounding of slips that do not change
    assert not any("layer" in note for note in plain.record.notes)


def test_audit_of_the_layer_is_what_the_bodies_do_and_is_in_the_record():
    """From the compliance of the bodies alone: they overlap where they touch, and move against each
    other where they stick.
    """
    answer = layer_run("hertz-paper", "penalty", 1e2)
    audit = answer.penalty
    weights = answer.condensed_bodies[0].face_lengths
    unit = answer.scales.load / answer.scales.modulus
    layer = answer.pressure / audit.normal_stiffness
    assert audit.normal_stiffness == pytest.approx(
        1e2 * answer.scales.modulus / answer.settings["element_size"]
    )
    assert audit.penetration == pytest.approx(layer.max())
    lower, upper = (body.compliance[1, :, 1, :] for body in answer.condensed_bodies)
    last = len(answer.time) - 1
    closed = answer.states[last].is_closed
    gap = (
        answer.scene.profile.height(answer.x)
        - answer.normal_approach[last]
        + (lower + upper) @ (answer.pressure[last] * weights)
    )
    np.testing.assert_allclose(gap[closed], -layer[last][closed], atol=1e-10 * unit)
    depth = answer.contact_half_width.max() ** 2 / (2 * answer.scene.profile.radius)
    assert audit.penetration_share == pytest.approx(audit.penetration / depth)
    stuck = np.abs(answer.x) < 0.5 * answer.permanent_stick_half_width
    assert (
        0.2 * audit.creep
        < np.ptp(answer.slip[answer.last_cycle][:, stuck], axis=0).max()
        <= audit.creep
    )
    note = answer.record.notes[0]
    assert note.startswith("penalty layer, stiffness ")
    assert f"overlap by up to {audit.penetration:.2g} [length]" in note
    assert f"creep by up to {audit.creep:.2g}" in note
    assert answer.settings["penalty"]["creep"] == audit.creep
    assert all(check.holds for check in certificates(answer))
    pressed = fe_run(load_scene("hertz-normal"), COARSE, SolverSettings(method="penalty")).penalty
    assert pressed.penetration > pressed.elastic_slip == 0
    assert np.isnan([pressed.elastic_slip_share, pressed.creep_share]).all()


# ----------------------------------------------------------- records longer than an answer can hold


@cache
def solved(rows: int, most: int, repeats: bool = False) -> FiniteElementSolution:
    """The first `rows` of the record, kept at `most` instants; as a cycle, with its first row again
    at the end.
    """
    record = long_record.rows_of(rows)
    if repeats:
        record = np.vstack([record, [record[-1, 0] + 0.01, *record[0, 1:]]])
    load = TimeSeriesLoad(rows=record.tolist(), repeats=repeats)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(halfplane_fe.run, "MOST_COMPLETE_STATES", most)
        return halfplane_fe.solve(long_scene().vary(load=load, cycles=2), COARSE)


@cache
def long_scene() -> Scene:
    """The example with a block and a pad, f = 0.7."""
    bodies = {
        "lower": {"kind": "block", "width": 40.0, "height": 20.0},
        "upper": {"kind": "pad", "width": 20.0, "height": 15.0},
    }
    return load_scene("hertz-paper").vary(
        bodies=bodies, friction={"coefficient": 0.7}, tolerances={}
    )


MORE = (
    pytest.param(120, 200, False, marks=pytest.mark.slow),
    pytest.param(11, 16, True, marks=pytest.mark.slow),
)


@pytest.mark.parametrize(("rows", "most", "repeats"), [(30, 12, False), *MORE])
def test_instants_that_are_left_out_cost_nothing_but_themselves(
    rows: int, most: int, repeats: bool
) -> None:
    """Each instant is as in the whole answer; what is of the whole path is that of the whole answer
    to rounding, and it is said. Edges are corrected by how the half-width grows with the load.
    Fewer instants tell that less well: edges differ by less than a fifth of their uncertainty.
    """
    thinned = solved(rows, most, repeats)
    complete = solved(rows, 10**9, repeats)
    assert len(thinned.time) == len(thinned.states) <= most < len(complete.time)
    assert thinned.thinned > complete.thinned
    instants = np.searchsorted(complete.time, thinned.time)
    for name in (
        "time",
        "normal_load",
        "pressure",
        "shear",
        "slip",
        "state",
    ):
        np.testing.assert_array_equal(
            getattr(thinned, name), getattr(complete, name)[instants], err_msg=name
        )
    for name in ("contact_edge", "stick_edge"):
        difference = getattr(thinned, f"{name}s") - getattr(complete, f"{name}s")[instants]
        uncertainty = getattr(complete, f"{name}_uncertainty")[instants]
        assert np.all((np.abs(difference) < 0.2 * uncertainty) | np.isnan(difference)), name
    assert thinned.steady_from == complete.steady_from
    for name in (
        "dissipation",
        "dissipation_density",
        "cycle_dissipation",
        "loop_work",
    ):
        assert getattr(thinned, name) == pytest.approx(
            getattr(complete, name), rel=1e-14, nan_ok=True
        ), name
    if math.isfinite(complete.permanent_stick_half_width):
        uncertainty = complete.uncertainties["permanent_stick_half_width"]
        difference = thinned.permanent_stick_half_width - complete.permanent_stick_half_width
        assert abs(difference) < 0.2 * uncertainty
    else:
        assert math.isnan(thinned.permanent_stick_half_width)
    for name, energy in complete.record.energy.items():
        assert thinned.record.energy[name].sum() == pytest.approx(
            energy.sum(), rel=1e-10, abs=1e-13
        ), name
    assert all(
        thinned.record.certificates[name].max() == worst.max()
        for name, worst in complete.record.certificates.items()
    )
    assert (thinned.record.iterations.sum(), thinned.work.counts) == (
        complete.record.iterations.sum(),
        complete.work.counts,
    )
    missing = len(complete.time) - len(thinned.time)
    assert any(
        note.startswith(f"{missing} of {len(complete.time)} instants")
        for note in thinned.record.notes
    )
    assert thinned.work.skipped["instants"][0] == missing
    if repeats:  # a cycle keeps its start and its end
        assert (
            thinned.time[thinned.last_cycle[[0, -1]]].tolist()
            == complete.time[complete.last_cycle[[0, -1]]].tolist()
        )
    elif rows < most:  # every row stays
        assert np.isin(long_record.rows_of(rows)[:, 0], thinned.time).all()
    else:
        # evenly many of them, no more than nine rows of 0.01 s between two, which must not count as
        # straight lines
        assert len(thinned.time) >= 6
        assert np.diff(thinned.time).max() < 0.1
        exact = semi_analytic.solve(thinned.scene, x=thinned.x, time=thinned.time)
        on_kept = semi_analytic.solve(
            thinned.scene, x=thinned.x, time=thinned.time, straight_steps=True
        )
        assert exact.dissipation == pytest.approx(
            semi_analytic.solve(thinned.scene).dissipation, rel=1e-12
        )
        assert on_kept.dissipation < 0.995 * exact.dissipation


# Loads over 90 N/mm and f; measured: 1.3e-5 and 5e-5. Without the area of a curve by shares 1.0e-3
# and 9e-5, without kinks between the first and the last start 1.5e-4 in the second, with nodes that
# have just touched among those that start 9e-5.
@pytest.mark.parametrize(
    ("profile", "friction", "loads", "increments", "most"),
    [
        (
            {"kind": "flat_rounded", "radius": 1000.0, "flat_half_length": 1.6322},
            0.102626,
            (0.627, 0.36, 0.0149, 147.74),
            24,
            1e-4,
        ),
        (
            {"kind": "hertz", "radius": 1000.0},
            0.927802,
            (0.32043, 0.27012, 0.4069, 142.858),
            12,
            7e-5,
        ),
    ],
    ids=["hardly slips", "slips"],
)
def test_few_increments_have_the_dissipation_of_many(profile, friction, loads, increments, most):
    swing, mean, amplitude, phase = loads
    load = ellipse_of(90.0, swing, mean, amplitude, phase, friction)
    scene = load_scene("hertz-paper").vary(profile=profile, friction=friction, load=load)
    mesh = MeshSettings(element_size=1 / 24, edge_element_size=1 / 40, growth=0.5)
    reference = halfplane_fe.solve(
        scene, mesh, SolverSettings(steps_per_cycle=384, step_tolerance=np.inf)
    )
    answer = halfplane_fe.solve(
        scene,
        mesh,
        SolverSettings(steps_per_cycle=increments, step_tolerance=np.inf),
        scales=reference.scales,
    )
    assert answer.dissipation == pytest.approx(reference.dissipation, rel=most)


def ellipse_of(normal, swing, mean, amplitude, phase, friction):
    """An ellipse by shares of the mean normal load: of P, and of Q over f."""
    return {
        "kind": "ellipse",
        "mean_normal_load": normal,
        "normal_amplitude": swing * normal,
        "mean_tangential_load": mean * friction * normal,
        "tangential_amplitude": amplitude * friction * normal,
        "phase_degrees": phase,
        "initial_loading": "straight",
    }


@pytest.mark.parametrize(
    ("closed_after", "is_missed"), [((True, True, False), False), ((True, False, False), True)]
)
def test_an_increment_goes_too_far_where_another_node_lets_go(closed_after, is_missed):
    """Of unlike bodies, in a regular increment: all nodes stay as they are."""
    before = np.array([True, True, False])
    after = np.array(closed_after)
    start, solved = (
        SimpleNamespace(
            is_closed=closed, gap=np.where(closed, 0.0, 0.1), pressure=np.where(closed, 1.0, 0.0)
        )
        for closed in (before, after)
    )
    unlike = SimpleNamespace(interface=SimpleNamespace(coupling=np.zeros((3, 3))))
    assert stepping._misses_event(unlike, start, solved, "regular") is is_missed
