"""A measured loop as the reference: f from synthetic loops with noise, rigs, forms of Q; the page, JSON, faults of a file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reports.cli import main
from reports.scoring import loops
from reports.scoring.loops import MeasuredLoop, read_loop, score_loop
from reports.scoring.mapping import Mapping
from scenes import InputError, load_scene
from semi_analytic import solve

CONSTANT, PAPER = load_scene("cattaneo-mindlin"), load_scene("hertz-paper")
LOAD = CONSTANT.load.cycle[0][0]
# Q to 0.95 of gross sliding, where the loop is wide.
WIDE = CONSTANT.vary(load={"initial_loading": [(LOAD, 0.0)], "cycle": [(LOAD, 0.475 * LOAD), (LOAD, -0.475 * LOAD)]})


def rows_of(scene, friction, count=4000, cycles=20.0, noise=0.0, rig=0.3, seed=0, start=0.2):
    """U and Q as a rig with `rig` times the compliance of the contact would write them; noise is a share of the amplitudes."""
    path, random = scene.load.path(), np.random.default_rng(seed)
    places = np.linspace(0, 1, 1441)
    times = path.cycle_start + path.period * (1 + places)
    shift = solve(scene.vary(friction=friction), x=0.0, time=times, fields="tangential_displacement").tangential_displacement
    force = path.at(times)[1]
    rig *= np.ptp(shift) / np.ptp(force)
    share = np.mod(start + np.linspace(0, cycles, count), 1.0)
    u, q = (np.interp(share, places, values) for values in (shift + rig * force + 0.01, force))
    u, q = (values + noise * np.ptp(values) / 2 * random.standard_normal(count) for values in (u, q))
    return u, q, rig


def loop_of(u, q, time=None):
    return MeasuredLoop("loop.csv", u, q, np.arange(len(u), dtype=float) if time is None else time, ())


@pytest.mark.parametrize(("scene", "friction"), [(CONSTANT, 0.42), (CONSTANT, 0.5), (PAPER, 0.9), (PAPER, 1.4)])
def test_an_exact_loop_gives_its_friction_its_rig_and_its_area(scene, friction):
    u, q, rig = rows_of(scene, friction)
    found = score_loop(loop_of(u, q), scene)
    assert found.friction == pytest.approx(friction, rel=1e-4)
    assert found.compliance == pytest.approx(rig, rel=1e-4)
    assert found.cycles == pytest.approx(20.0, rel=1e-6)
    measured, best = found.rows[:2]
    work = solve(scene.vary(friction=friction), x=0.0, fields="dissipation").dissipation
    assert best.area == pytest.approx(work, rel=1e-3)
    assert measured.area == pytest.approx(work, rel=1e-2)
    assert measured.slope == pytest.approx(best.slope, rel=1e-4)  # 4,000 rows, 721 instants
    assert best.distance < 1e-4 * np.ptp(u)


def test_friction_to_one_per_cent_at_two_per_cent_noise_within_its_interval():
    """20,000 rows of 100 cycles: what a rig writes in minutes."""
    errors, inside = [], 0
    for seed in range(4):
        u, q, _ = rows_of(WIDE, 0.5, 20_000, 100.0, 0.02, seed=seed)
        found = score_loop(loop_of(u, q), WIDE)
        errors.append(found.friction / 0.5 - 1)
        inside += found.low <= 0.5 <= found.high
        assert found.noise == pytest.approx(0.02 * np.ptp(u) / 2, rel=0.2)
        assert abs(found.rows[0].area - found.rows[1].area) < 2 * found.rows[0].area_uncertainty
        assert (found.high - found.low) / 2 < 0.01 * 0.5
    assert np.max(np.abs(errors)) < 0.01
    assert inside >= 3


def test_a_given_rig_and_the_files_own_size_of_the_load():
    u, q, rig = rows_of(WIDE, 0.5)
    given = score_loop(loop_of(u, q), WIDE, rig_compliance=rig)
    assert (given.compliance, given.compliance_fitted) == (rig, False)
    assert given.friction == pytest.approx(0.5, rel=1e-4)
    wrong = score_loop(loop_of(u, q), WIDE, rig_compliance=2 * rig)
    assert wrong.rows[1].distance > 100 * given.rows[1].distance
    # U and Q twice as large with twice the f are the same loop, twice as large.
    twice = score_loop(loop_of(2 * u, 2 * q), WIDE)
    assert (twice.scale, twice.friction) == (pytest.approx(2.0, rel=1e-6), pytest.approx(1.0, rel=1e-4))
    assert any("2 times that of the scene" in sentence for sentence in twice.said)
    assert twice.rows[1].area == pytest.approx(4 * given.rows[1].area, rel=1e-3)


def test_at_constant_normal_load_the_form_of_q_over_time_does_not_matter():
    sine = WIDE.vary(
        load={"kind": "ellipse", "mean_normal_load": LOAD, "tangential_amplitude": 0.475 * LOAD, "phase_degrees": 90.0}
    )
    u, q, _ = rows_of(sine, 0.5)
    found = score_loop(loop_of(u, q), WIDE)
    assert found.friction == pytest.approx(0.5, rel=1e-3)
    assert any("a sine's Q" in sentence for sentence in found.said)


def test_uneven_times_are_used():
    u, q, _ = rows_of(PAPER, 0.9)
    chosen = np.sort(np.random.default_rng(2).choice(len(u), 1500, replace=False))
    found = score_loop(loop_of(u[chosen], q[chosen], 0.01 * (chosen - chosen[0])), PAPER)
    assert found.friction == pytest.approx(0.9, rel=1e-3)
    with pytest.raises(InputError, match="of its amplitude only"):
        score_loop(loop_of(u[chosen[::9]], q[chosen[::9]]), PAPER)


def test_a_loop_that_hardly_opens_has_no_upper_limit():
    u, q, _ = rows_of(CONSTANT, 5.0, 400, 4.0, 0.02)
    found = score_loop(loop_of(u, q), CONSTANT)
    assert found.high is None
    assert "no upper limit" in found.sentence
    assert found.low < 5.0


@pytest.mark.slow
def test_finite_elements_lie_beside_theory():
    u, q, _ = rows_of(CONSTANT, 0.5)
    found = score_loop(loop_of(u, q), CONSTANT, against="fe")
    rows = {row.name: row for row in found.rows}
    assert rows["finite elements, best f"].area == pytest.approx(rows["theory, best f"].area, rel=3e-3)
    assert rows["finite elements, best f"].slope == pytest.approx(rows["theory, best f"].slope, rel=1e-3)


def written(path: Path, u, q, head="U,Q", **more):
    np.savetxt(path, np.column_stack([u, q]), delimiter=",", header=head, comments="", fmt="%.9g", **more)


def test_the_command_writes_a_page_and_its_json(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    u, q, _ = rows_of(WIDE, 0.5, 2000, 10.0, 0.02)
    written(tmp_path / "loop.csv", u, q, "U [mm],Q [N/mm]")
    WIDE.save("rig.toml")
    words = ["score", "loop.csv", "--as", "loop", "--scene", "rig.toml", "--quiet"]
    assert main(words) == 0
    shown = capsys.readouterr().out
    assert "lies within this interval" in shown
    page = Path("out/score-loop/report.html").read_text(encoding="utf-8")
    assert "The loop is best fitted by f = 0.5" in page or "f = 0.49" in page
    assert "halfplane score loop.csv" in page
    assert "--as loop" in page
    kept = json.loads(Path("out/score-loop/loop.json").read_text(encoding="utf-8"))
    assert main([*words, "--json", "--rig-compliance", "1e-5"]) in (0, 1)
    result = json.loads(capsys.readouterr().out)["result"]
    assert result["rig_compliance"] == {"value": 1e-5, "fitted": False}
    assert {"metrics", "friction", "sentence", "page", "scene"} <= result.keys()
    assert kept["friction"]["low"] < kept["friction"]["value"] < kept["friction"]["high"]
    assert Path("out/score-loop/figures/loop.csv").is_file()
    # Another f than the file's is outside its interval.
    WIDE.vary(friction=0.6).save("other.toml")
    assert main(["score", "loop.csv", "--as", "loop", "--scene", "other.toml", "--quiet"]) == 1


FAULTS = {
    "no U": ("a,Q", lambda u, q: (u, q), (), "no column for the relative displacement"),
    "no Q": ("U,b", lambda u, q: (u, q), (), "no column for tangential_load"),
    "two Q": ("Q,Ft [N/mm]", lambda u, q: (u, q), (), "no column for the relative displacement"),
    "other unit": ("U [um],Q", lambda u, q: (u, q), (), "the column 'U [um]' is in um, and the scene in mm: state factors.length"),
    "too few": ("U,Q", lambda u, q: (u[:20], q[:20]), (), "20 rows are too few for a loop"),
    "no cycle": ("U,Q", lambda u, q: (u[:110], q[:110]), (), "its "),
    "flat": ("U,Q", lambda u, q: (0 * u, q), (), "U is the same in every row"),
    "noise": ("U,Q", lambda u, q: (u, np.random.default_rng(0).standard_normal(len(q))), (), "of its amplitude only"),
    "NaN": ("U,Q", lambda u, q: (np.where(np.arange(len(u)) == 7, np.nan, u), q), (), "loop.csv, line 9: U = "),
    "time": ("time,U,Q", lambda u, q: (np.r_[0.0, 2.0, 1.0 + np.arange(2, len(u))], u, q), (), ""),
    "rig": ("U,Q", lambda u, q: (u, q), ("--rig-compliance", "nan"), "--rig-compliance nan is refused"),
    "tolerance": ("U,Q", lambda u, q: (u, q), ("--tolerance", "5%"), "a loop has none"),
    "no loop": ("U,Q", lambda u, q: (u, q), ("--scene", "flight"), "its loads do not repeat"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_one_sentence(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    head, change, words, sentence = FAULTS[name]
    u, q, _ = rows_of(CONSTANT, 0.5, 400, 2.0)
    columns = np.column_stack(change(u, q))
    if name == "time":
        columns[1, 0] = 3.5
        sentence = "line 4: time = 3 does not ascend"
    np.savetxt("loop.csv", columns, delimiter=",", header=head, comments="", fmt="%.9g")
    scene = () if "--scene" in words else ("--scene", "cattaneo-mindlin")
    assert main(["score", "loop.csv", "--as", "loop", "--quiet", *scene, *words]) == 2
    shown = capsys.readouterr()
    assert sentence in shown.err
    assert len(shown.err.splitlines()) == 1
    assert not Path("out").exists()


@settings(max_examples=14, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["swap", "quantise", "cut", "shuffle", "scale", "sign", "spike"]))
def test_a_spoilt_file_is_a_score_or_one_sentence(seed, fault):
    random = np.random.default_rng(seed)
    u, q, _ = rows_of(CONSTANT, 0.5, 200, 2.0)
    match fault:
        case "swap":
            u, q = q, u
        case "quantise":
            u = np.round(u, int(random.integers(1, 6)))
        case "cut":
            left = random.integers(1, 200)
            u, q = u[:left], q[:left]
        case "shuffle":
            q = random.permutation(q)
        case "scale":
            u, q = u * 10.0 ** random.integers(-8, 9), q * 10.0 ** random.integers(-8, 9)
        case "sign":
            u = -u
        case "spike":
            q[random.integers(0, 200)] = 1e9
    try:
        found = score_loop(loop_of(u, q), CONSTANT)
    except InputError as refused:
        rule = str(refused)
        found = None
    if found is None:
        assert rule.startswith("loop.csv: ")
        return
    assert found.low <= found.friction
    assert found.high is None or found.friction <= found.high
    assert np.isfinite([row.area for row in found.rows]).all()


def test_the_reader_takes_a_mapping(tmp_path):
    u, q, _ = rows_of(CONSTANT, 0.5, 200, 2.0)
    written(tmp_path / "loop.csv", 1e3 * u, 10 * q, "LVDT [um],Ft [N]")
    mapping = Mapping.model_validate(
        {"columns": {"slip": "LVDT [um]", "tangential_load": "Ft [N]"}, "factors": {"length": 1e-3, "load": 1.0}, "thickness": 10.0}
    )
    found = read_loop(tmp_path / "loop.csv", mapping, CONSTANT)
    np.testing.assert_allclose(found.shift, u, rtol=1e-7)
    np.testing.assert_allclose(found.load, q, rtol=1e-7)
    assert loops.content(score_loop(found, CONSTANT))["kind"] == "loop"
