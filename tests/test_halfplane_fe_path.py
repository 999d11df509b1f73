"""Where increments end, and which paths have no solution: turning points, regular instants, gross sliding, separation."""

import math
from importlib import import_module

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import halfplane_fe
import semi_analytic
from halfplane_fe import check_admissible
from halfplane_fe.path import stretches, turning_points
from halfplane_fe.scales import largest_load
from meshes import MeshSettings
from problems import fe_run
from reports.checking import check_path
from scenes import (
    Elastic,
    EllipseLoad,
    Friction,
    HarmonicLoad,
    Hertz,
    InadmissibleLoadError,
    Materials,
    PolygonLoad,
    Scene,
    StraightSegment,
    TimeSeriesLoad,
    ellipse_segment,
    load_scene,
    parabola_segment,
)

TURN = 2 * math.pi


def ellipse(phase=90.0, **changed):
    values = {"mean_normal_load": 3, "normal_amplitude": 1, "mean_tangential_load": 0.2, "tangential_amplitude": 1}
    return EllipseLoad(**(values | {"phase_degrees": phase} | changed))


# ------------------------------------------------------------------------------------------------------------ turning points
@given(phase=st.floats(10, 170), friction=st.floats(0.3, 2), start=st.floats(0, TURN))
def test_turning_points_of_an_ellipse(phase, friction, start):
    """P turns at 0 and pi; Q -+ f P, sinusoids too, where their rates vanish: six in a revolution, two half a turn apart each."""
    leg = ellipse_segment(start, start + TURN, (3, 0.2), (1, 0.7), math.radians(phase))
    tangential = 0.7 * np.exp(-1j * math.radians(phase))
    phases = [-np.angle(tangential - sign * friction) for sign in (1, -1)] + [0.0]
    expected = np.sort(start + (np.array([p + half for p in phases for half in (0, math.pi)]) - start) % TURN)
    found = np.array(turning_points(leg, friction))
    apart = np.diff(np.append(expected, expected[0] + TURN))
    if apart.min() > 1e-3 and min(expected[0] - start, start + TURN - expected[-1]) > 1e-3:
        np.testing.assert_allclose(found, expected, atol=1e-11)
    for time in found:
        p, q = leg.rates(time)
        assert min(abs(p), abs(q - friction * p), abs(q + friction * p)) < 1e-9


def test_straight_legs_do_not_turn():
    assert turning_points(StraightSegment(0, 1, (1, 0), (3, -2)), 0.5) == []
    assert turning_points(StraightSegment(0, 1, (2, 0), (2, 1)), 0.5) == []  # P does not change at all
    assert turning_points(StraightSegment(0, 1, (1, 0), (3, 1)), 0.5) == []  # Q - f P does not


def test_parabola_turns_where_its_slope_is_f():
    leg = parabola_segment(0.0, 1.0, (2.0, 1.0), 0.0)  # Q = P - P^2/4: slope 1/2 at P = 1
    assert turning_points(leg, 0.5) == pytest.approx([0.5], abs=1e-12)
    assert turning_points(leg, 2.0) == []


@pytest.mark.parametrize("order", [300, 360, 720, 1000])
def test_every_turn_of_a_high_harmonic_is_found(order):
    """Q = 10 sin t + 30 sin(k t): its rate has a zero next to each of cos(k t), however few samples an ellipse would need."""
    leg = HarmonicLoad(mean_normal_load=90, tangential_harmonics=[(10, 90), *[(0, 0)] * (order - 2), (30, 90)]).path().cycle[0]
    found = np.array(turning_points(leg, 0.5))
    np.testing.assert_allclose(found, (np.arange(2 * order) + 0.5) * math.pi / order, atol=1 / (2 * order**2))


@pytest.mark.parametrize("order", [512, 720])
def test_sliding_between_the_samples_of_a_slow_path_is_refused(order):
    """512 and 720 samples of a turn all fall where sin(k t) is nothing."""
    load = HarmonicLoad(mean_normal_load=90, tangential_harmonics=[*[(0, 0)] * (order - 1), (50, 90)])
    with pytest.raises(InadmissibleLoadError, match="gross sliding"):
        check_admissible(load.path(), 0.5)
    paper = load_scene("hertz-paper")
    scene = paper.vary(load=load, friction=0.5)
    assert check_path(scene).reason == "gross sliding"
    assert check_path(scene).ratio == pytest.approx(50 / 45, rel=1e-9)


@given(phase=st.floats(10, 170), increments=st.floats(4, 200))
def test_stretches_cut_at_the_turning_points_and_leave_nothing_out(phase, increments):
    leg = ellipse_segment(1.0, 1.0 + TURN, (3, 0.2), (1, 0.7), math.radians(phase))
    pieces = stretches(leg, 0.8, increments)
    ends = [end for piece in pieces for end in piece.ends]
    assert np.all(np.diff(ends) > 0)
    assert ends[-1] == pytest.approx(leg.end, abs=1e-14)
    assert set(turning_points(leg, 0.8)) <= set(ends)
    assert [piece.start for piece in pieces[1:]] == [piece.ends[-1] for piece in pieces[:-1]]
    assert increments <= len(ends) <= increments + 2 * len(pieces)
    assert max(np.diff([leg.start, *ends])) <= TURN / increments * (1 + 1e-9)


def test_answer_has_a_step_at_every_turning_point():
    answer = fe_run(load_scene("hertz-paper"))
    path = answer.scene.load.path()
    for leg in path.legs(2):
        for time in turning_points(leg, 1.0):
            assert np.abs(answer.time - time).min() < 1e-12
    # theirs, in the paper's letters: P at 0 and pi, u at 3 pi/4 (E) and 7 pi/4 (I), v at pi/4 and 5 pi/4 (G)
    turns = turning_points(path.cycle[0], 1.0)
    assert np.allclose(np.sort(np.mod(turns, TURN) / math.pi), [0, 0.25, 0.75, 1, 1.25, 1.75])


@given(phase=st.floats(0, 360), number=st.integers(1, 40))
def test_the_largest_load_is_where_it_turns_round_not_at_a_sample(phase, number):
    """P0 + P_k, of a single harmonic of the normal load with any phase."""
    harmonics = ((0.0, 0.0),) * (number - 1) + ((20.0, phase),)
    load = HarmonicLoad(
        mean_normal_load=90.0, mean_tangential_load=0.0, normal_harmonics=harmonics, tangential_harmonics=((8.0, 0.0),)
    )
    assert largest_load(load_scene("harmonics").vary(load=load)) == pytest.approx(110.0, rel=1e-13)


def test_the_largest_load_may_be_an_end_of_a_leg():
    assert largest_load(load_scene("cattaneo-mindlin")) == 90.62286500739786  # straight legs: no turn inside any


# ------------------------------------------------------------------------------------------------------------- admissibility
ADMISSIBLE = {
    "the paper's": (ellipse(mean_tangential_load=1.1, initial_loading="parabola"), 1.0),
    "short of sliding": (PolygonLoad(initial_loading=[(1, 0), (1, 0.999999)]), 1.0),
    "no friction, no shear": (PolygonLoad(initial_loading=[(1, 0), (3, 0)]), 0.0),
    "unloaded almost": (PolygonLoad(initial_loading=[(1, 0)], cycle=[(1e-6, 0)]), 0.5),
    "down and up": (PolygonLoad(initial_loading=[(2, 0.5), (1, -0.4), (3, 1.4)]), 0.5),
}
REFUSED = {
    "sliding at a corner": (PolygonLoad(initial_loading=[(1, 0), (1, 0.6), (2, 0)]), 0.5, "gross sliding", 2.0, (1.0, 0.6)),
    "exactly f P": (PolygonLoad(initial_loading=[(1, 0), (1, 0.5)]), 0.5, "gross sliding", 2.0, (1.0, 0.5)),
    "sliding backwards": (PolygonLoad(initial_loading=[(1, 0), (1, -0.6)]), 0.5, "gross sliding", 2.0, (1.0, -0.6)),
    "sliding on the initial loading": (PolygonLoad(initial_loading=[(1, 0.7), (2, 0)]), 0.5, "gross sliding", 1.0, (1.0, 0.7)),
    "shear without friction": (PolygonLoad(initial_loading=[(1, 0), (1, 0.1)]), 0.0, "gross sliding", 2.0, (1.0, 0.1)),
    "separation": (PolygonLoad(initial_loading=[(1, 0)], cycle=[(-0.5, 0)]), 0.5, "separation", 2.0, (-0.5, 0.0)),
    "full unloading": (PolygonLoad(initial_loading=[(1, 0)], cycle=[(0, 0)]), 0.5, "separation", 2.0, (0.0, 0.0)),
    "ellipse lifts off": (ellipse(normal_amplitude=4), 5.0, "separation", 3 * math.pi, (-1.0, 0.2)),
    "ellipse slides": (
        ellipse(normal_amplitude=0, tangential_amplitude=1.6),
        0.5,
        "gross sliding",
        math.pi / 2 + TURN,
        (3.0, 1.8),
    ),
}


@pytest.mark.parametrize("name", ADMISSIBLE)
def test_admissible_paths_pass(name):
    load, friction = ADMISSIBLE[name]
    check_admissible(load.path(), friction)


@pytest.mark.parametrize("name", REFUSED)
def test_inadmissible_paths_are_named_with_instant_and_loads(name):
    load, friction, reason, time, loads = REFUSED[name]
    with pytest.raises(InadmissibleLoadError, match=reason) as caught:
        check_admissible(load.path(), friction)
    found = caught.value
    assert found.time == pytest.approx(time, abs=1e-9)
    assert (found.normal_load, found.tangential_load) == pytest.approx(loads, abs=1e-9)
    assert f"at time {found.time:.6g} with P = {found.normal_load:.6g}, Q = {found.tangential_load:.6g}" in str(found)
    assert "\n" not in str(found)


@given(st.lists(st.tuples(st.floats(-0.2, 2), st.floats(-1, 1)), min_size=1, max_size=6, unique=True), st.floats(0.1, 1))
def test_a_polygon_is_admissible_when_its_corners_are(corners, friction):
    """Straight lines in a convex region: nothing happens between the corners."""
    assume((0.0, 0.0) not in corners)
    load = PolygonLoad(initial_loading=corners)
    inside = all(p > 1e-9 and abs(q) < friction * p * (1 - 1e-9) for p, q in corners)
    outside = any(p < -1e-9 or abs(q) > friction * max(p, 0) * (1 + 1e-9) + 1e-9 for p, q in corners)
    if inside:
        check_admissible(load.path(), friction)
    elif outside:
        with pytest.raises(InadmissibleLoadError):
            check_admissible(load.path(), friction)


@pytest.mark.parametrize(
    ("friction", "force", "length"), [(1e-15, 1, 1), (1e-12, 1e6, 1e-3), (1e-6, 1, 1e3), (0.3, 1e-6, 1), (1.0, 1, 1), (1e3, 1, 1)]
)
def test_both_engines_admit_the_same_loads_at_the_limit(friction, force, length):
    """'Just' is relative to f P: Q = f P (1 - 1e-9) is solved, to the same tangential displacement, f P (1 + 1e-9) refused."""
    steel = Elastic(young_modulus=210e3 * force / length**2, poisson_ratio=0.3)
    profile, largest = Hertz(radius=1000 * length), 100 * force / length

    def scene(share):
        load = PolygonLoad(initial_loading=[(largest, 0), (largest, share * friction * largest)])
        return Scene(
            name="limit",
            material=Materials(upper=steel, lower=steel),
            profile=profile,
            friction=Friction(coefficient=friction),
            load=load,
            cycles=1,
        )

    coarse = MeshSettings(element_size=1 / 4, edge_element_size=1 / 8, far_radius=6.0, growth=0.5)
    exact = semi_analytic.solve(scene(1 - 1e-9), x=[0.0], fields=("tangential_displacement",))
    fe = halfplane_fe.solve(scene(1 - 1e-9), mesh=coarse)
    assert not check_path(scene(1 - 1e-9)).reason
    assert fe.tangential_displacement[-1] == pytest.approx(exact.tangential_displacement[-1], rel=1e-3)
    for share in (1 + 1e-9, -1 - 1e-9, 1.001):
        assert check_path(scene(share)).reason == "gross sliding"
        with pytest.raises(InadmissibleLoadError, match="gross sliding"):
            semi_analytic.solve(scene(share), x=[0.0], fields=())
        with pytest.raises(InadmissibleLoadError, match="gross sliding"):
            halfplane_fe.solve(scene(share), mesh=coarse)


def test_rows_of_a_long_series_slide_by_the_same_limit():
    """1,001 rows up to Q = 1.001 f P, f = 1e-15."""
    paper = load_scene("hertz-paper")
    rows = [(k, 50.0, 1.001e-15 * 50 * k / 1001) for k in range(1, 1002)]
    scene = paper.model_copy(update={"load": TimeSeriesLoad(rows=[(0, 0, 0), *rows]), "friction": Friction(coefficient=1e-15)})
    with pytest.raises(InadmissibleLoadError, match="gross sliding"):
        semi_analytic.solve(scene, fields=())


def test_solve_refuses_before_any_work(monkeypatch):
    monkeypatch.setattr(import_module("halfplane_fe.solve"), "find_scales", lambda scene: pytest.fail("work was done"))
    scene = load_scene("cattaneo-mindlin").vary(load=REFUSED["sliding at a corner"][0])
    with pytest.raises(InadmissibleLoadError, match="gross sliding"):
        halfplane_fe.solve(scene)
