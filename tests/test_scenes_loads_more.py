"""Load histories by harmonics, time series and Python functions: geometry, reading, and what is refused."""

import math
import time

import numpy as np
import pytest
from pydantic import ValidationError

from scenes import (
    NORMAL_LOAD,
    CallableLoad,
    ChebyshevSegment,
    HarmonicLoad,
    HarmonicSegment,
    InputError,
    Scene,
    TimeSeriesLoad,
    ellipse_segment,
    load_scene,
    sampled,
)

HEAD = """
[material]
young_modulus = 210e3
poisson_ratio = 0.3
[friction]
coefficient = 0.5
[profile]
kind = "hertz"
radius = 100.0
[load]
"""
HARMONICS = HarmonicLoad(
    mean_normal_load=3.0,
    mean_tangential_load=0.2,
    normal_harmonics=[(1.0, 10.0), (0.5, -40.0)],
    tangential_harmonics=[(0.3, 80.0), (0.0, 0.0), (0.2, 5.0)],
)
FUNCTIONS = CallableLoad(
    normal_load=lambda t: 3 + math.cos(t) ** 3, tangential_load=lambda t: np.sin(np.sin(t)), duration=2 * math.pi, repeats=True
)
LEGS = [HARMONICS.path().cycle[0], HARMONICS.path().cycle[0].shifted(1.3), *FUNCTIONS.path().cycle[:2]]


def scene_file(folder, load):
    path = folder / "case.toml"
    path.write_text(HEAD + load, encoding="utf-8")
    return path


def test_harmonics_are_what_they_say():
    p, q = HARMONICS.path().at(0.7)
    assert p == pytest.approx(3 + math.cos(0.7 - math.radians(10)) + 0.5 * math.cos(1.4 + math.radians(40)))
    assert q == pytest.approx(0.2 + 0.3 * math.cos(0.7 - math.radians(80)) + 0.2 * math.cos(2.1 - math.radians(5)))
    assert isinstance(HARMONICS.path().cycle[0], HarmonicSegment)
    assert HARMONICS.path().period == pytest.approx(2 * math.pi)


def high(order, amplitude=30.0, mean=90.0):
    """Q = 10 sin t + amplitude sin(order t) under a constant P."""
    waves = [(10.0, 90.0), *[(0.0, 0.0)] * (order - 2), (amplitude, 90.0)]
    return HarmonicLoad(mean_normal_load=mean, tangential_harmonics=waves)


@pytest.mark.parametrize("order", [2, 40, 700])
def test_high_harmonics_are_what_they_say_however_many_times_are_asked_for(order):
    """So many times and waves that they are worked out in parts, each time to the same last digit as alone."""
    chance = np.random.default_rng(order)
    waves = [(float(a), float(phase)) for a, phase in chance.uniform((0, -180), (1, 180), (order, 2))]
    leg = HarmonicLoad(mean_normal_load=3.0 * order, normal_harmonics=waves, tangential_harmonics=waves[:1]).path().cycle[0]
    t = chance.uniform(0, 2 * math.pi, (3, 1000))
    p, q = leg.loads(t)
    k, a, phase = np.arange(1, order + 1), *np.array(waves).T
    np.testing.assert_allclose(
        p[1, ::50], [3.0 * order + math.fsum(a * np.cos(k * x - np.radians(phase))) for x in t[1, ::50]], rtol=1e-14
    )
    np.testing.assert_allclose(q, waves[0][0] * np.cos(t - math.radians(waves[0][1])), atol=1e-14)
    alone = [(leg.loads(x)[0], leg.rates(x)[0]) for x in t[1, ::50]]
    np.testing.assert_array_equal(alone, np.transpose([p[1, ::50], leg.rates(t)[0][1, ::50]]))
    change = leg.change_of(NORMAL_LOAD, t, t[::-1])
    np.testing.assert_allclose(change, p - p[::-1], atol=1e-11)
    assert change[0, 3] == leg.change_of(NORMAL_LOAD, t[0, 3], t[2, 3])


@pytest.mark.parametrize(
    "leg", [*LEGS, high(300).path().cycle[0], ellipse_segment(0.3, 7.0, (3, 1), (1, 1), 0.4)], ids=lambda leg: type(leg).__name__
)
def test_a_leg_turns_round_no_more_often_than_it_says_and_samples_show_it(leg):
    for normal, tangential in ((1, 0), (0, 1), (-0.5, 1), (0.5, 1)):
        dense, seen = (
            np.count_nonzero(np.diff(np.sign(normal * p + tangential * q)) != 0)
            for p, q in (leg.rates(np.linspace(leg.start, leg.end, 100_001)[1:-1]), leg.rates(sampled(leg, 25)[1:-1]))
        )
        assert dense <= leg.most_turns
        assert seen == dense or leg.most_turns < 30


def test_functions_are_followed_to_rounding():
    path = FUNCTIONS.path()
    t = np.linspace(0, 2 * math.pi, 501)
    p, q = path.at(t)
    np.testing.assert_allclose(p, 3 + np.cos(t) ** 3, atol=1e-13)
    np.testing.assert_allclose(q, np.sin(np.sin(t)), atol=1e-13)
    assert all(isinstance(leg, ChebyshevSegment) for leg in path.cycle)
    np.testing.assert_allclose(path.at(7.0), path.at(7.0 - 2 * math.pi), atol=1e-13)


def test_a_initial_loading_leads_to_the_functions_unless_they_start_unloaded():
    assert len(FUNCTIONS.path().initial_loading) == 1
    once = CallableLoad(normal_load=lambda t: t, tangential_load=lambda t: 0.1 * t**2, duration=2.0)
    assert once.path().start == 0.0
    assert once.path().period is None
    bent = CallableLoad(normal_load=lambda t: 2 + t, tangential_load=lambda t: 0 * t, duration=2.0, initial_loading=[(1.0, 0.3)])
    assert [float(v) for v in bent.path().at(-1.0)] == pytest.approx([1.0, 0.3])


def test_a_corner_becomes_an_edge_between_legs():
    load = CallableLoad(normal_load=lambda t: 2 + 0 * t, tangential_load=lambda t: np.abs(t - 1 / 3), duration=1.0)
    ends = [leg.end for leg in load.path().initial_loading]
    assert min(abs(end - 1 / 3) for end in ends) < 1e-12
    assert len(ends) < 12


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"tangential_load": lambda t: np.sign(t - 0.5)}, "tangential_load jumps|tangential_load is too rough"),
        ({"normal_load": lambda t: 1 / (t - 0.5 + 0j).real}, "normal_load is not finite at time 0.5"),
        ({"tangential_load": lambda t: t, "repeats": True}, "tangential_load jumps from 1 to .* at time 1"),
        ({"normal_load": 3.0}, "only be built in Python"),
        ({"duration": 0.0}, "greater than 0"),
    ],
)
def test_functions_that_will_not_do_are_refused(given, why):
    whole = {"normal_load": lambda t: 2 + 0 * t, "tangential_load": lambda t: 0 * t, "duration": 1.0} | given
    with np.errstate(all="ignore"), pytest.raises(ValidationError, match=why):
        CallableLoad(**whole)


def test_a_scene_with_functions_cannot_be_written():
    scene = load_scene("hertz-paper").vary(load=FUNCTIONS)
    with pytest.raises(InputError, match="can't be written, hashed or sent elsewhere: it holds a Python function"):
        scene.model_dump_json()


@pytest.mark.parametrize("load", [HARMONICS, TimeSeriesLoad(rows=[[0, 1, 0.1], [1, 2, 0.5]])], ids=lambda load: load.kind)
def test_loads_survive_json_and_have_words(load):
    scene = load_scene("hertz-paper").vary(load=load)
    assert Scene.model_validate_json(scene.model_dump_json()) == scene
    assert load.in_words("N/mm").startswith("the loads ")
    assert "N/mm" in FUNCTIONS.in_words("N/mm")


def test_a_series_starts_from_nothing():
    load = TimeSeriesLoad(rows=[[5, 2, 1], [6, 3, 1], [8, 2, 1]])
    assert load.path().start == 3.5
    assert load.series()[0].tolist() == [3.5, 0, 0]
    assert TimeSeriesLoad(rows=[[5, 0, 0], [6, 3, 1]]).path().start == 5
    cycle = TimeSeriesLoad(rows=[[5, 2, 1], [6, 3, 1], [8, 2, 1]], repeats=True).path()
    assert (cycle.cycle_start, cycle.period) == (5.0, 3.0)
    # A row that repeats the loads of the one before is a pause, not a fault.
    assert len(TimeSeriesLoad(rows=[[0, 2, 1], [1, 2, 1], [2, 2, 0]]).path().initial_loading) == 3


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("time,P,Q\n0,1,0\n1,nan,0\n", r"loads\.csv, line 3: P = 'nan' is not a finite number"),
        ("time,P,Q\n0,1,0\n1,2,0\n1,3,0\n", r"loads\.csv, line 4: time = 1 stands there twice"),
        ("time,P,Q\n0,1,0\n2,2,0\n# late\n1,3,0\n", r"loads\.csv, line 5: time = 1 comes after a later one"),
        ("time,P,Q\n0,1\n", r"loads\.csv, line 2: 3 numbers \(time, P, Q\) are needed"),
        ("t,P,Q\n0,1,2\n", r"loads\.csv, line 1: the columns are time, P, Q"),
        ("time,P,Q\n0,1,0\n", r"loads\.csv, line 2: one row is no history"),
        ("time,P,Q\n0,1,inf\n1,1,0\n", r"loads\.csv, line 2: Q = 'inf' is not a finite number"),
        ("time\tP\tQ\n0\t1\t0\n", r"line 1: the columns are time, P, Q, .*; commas between the columns, points in the numbers"),
        ("time,P,Q\n0,0,1,5,-0,3\n", r"line 2: 3 numbers .* are needed, .*; commas between the columns, points in the numbers"),
    ],
)
def test_faults_in_series_name_file_line_and_rule(tmp_path, text, why):
    (tmp_path / "loads.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=why):
        load_scene(scene_file(tmp_path, 'kind = "time_series"\nfile = "loads.csv"'))


@pytest.mark.parametrize("head", ["time,P,Q\n", ""])
def test_a_mark_of_byte_order_is_no_fault_of_a_table(tmp_path, head):
    """Spreadsheets save "CSV UTF-8" with one; scene files may have it too."""
    (tmp_path / "loads.csv").write_text(head + "0,1,0\n1,2,0.5\n", encoding="utf-8-sig")
    scene = load_scene(scene_file(tmp_path, 'kind = "time_series"\nfile = "loads.csv"'))
    assert scene.load.rows.values.tolist() == [[0, 1, 0], [1, 2, 0.5]]
    (tmp_path / "loads.csv").write_text(head + "0,1,0\n1,2,0.5\n1,2,0.4\n", encoding="utf-8-sig")
    with pytest.raises(InputError, match=rf"loads\.csv, line {3 + bool(head)}: time = 1 stands there twice"):
        load_scene(scene_file(tmp_path, 'kind = "time_series"\nfile = "loads.csv"'))


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([[0, 1, 0], [1, 2, 0]], "must end with the loads of its first row"),
        ([[0, 0, 0], [1, 2, 0], [2, 0, 0]], "can't start unloaded"),
        ([[0, 1, math.nan], [1, 1, 0]], r"row 1: \[0\.0, 1\.0, nan\] is not all finite numbers"),
        ([[0, 1], [1, 1]], "three numbers"),
    ],
)
def test_rows_that_are_no_cycle_are_refused(rows, why):
    with pytest.raises(ValidationError, match=why):
        TimeSeriesLoad(rows=rows, repeats=True)


def test_a_hundred_thousand_rows_are_read_at_once(tmp_path):
    """The reader goes line by line only where there is a fault to name."""
    count = 100_000
    t = np.arange(count) * 1e-3
    np.savetxt(tmp_path / "loads.csv", np.stack([t, 2 + np.cos(t), 0.3 * np.sin(t)], axis=1), delimiter=",")
    begin = time.perf_counter()
    scene = load_scene(scene_file(tmp_path, 'kind = "time_series"\nfile = "loads.csv"'))
    assert len(scene.load.rows) == count
    assert time.perf_counter() - begin < 5  # measured 0.06 s: a guard against a reader in Python, not a benchmark


def test_the_library_series_is_packaged_beside_its_scene():
    load = load_scene("time-series").load
    assert load.file == "time-series.csv"
    assert len(load.rows) == 40
