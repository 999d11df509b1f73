"""The load path before anything is solved: how near gross sliding, and where, against figures that a hand can check."""

import json
import math
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import semi_analytic
from reports import checking
from reports.checking import check_path, largest_contact, largest_normal_load, remarks, require_admissible
from reports.cli import main
from scenes import (
    Block,
    Bodies,
    EllipseLoad,
    Hertz,
    InputError,
    Materials,
    Pad,
    PolygonLoad,
    PowerLaw,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    load_scene,
    scene_names,
    scene_text,
)

BASE = load_scene("hertz-paper")


def scene(load: EllipseLoad | PolygonLoad, friction: float = 0.5) -> Scene:
    return BASE.vary(load=load, friction=friction)


@pytest.mark.parametrize("name", scene_names())
def test_the_library_is_admissible(name: str) -> None:
    check = check_path(load_scene(name))
    assert not check.reason
    assert check.ratio < 1
    assert check.first_time is None


@pytest.mark.parametrize("name", scene_names())
def test_the_profiles_of_the_library_hold_their_loads(name: str) -> None:
    largest_contact(load_scene(name), name)


@pytest.mark.parametrize(("share", "held"), [(1.001, True), (0.999, False)])
def test_a_table_is_found_too_short_where_theory_finds_it_so(share: float, held: bool) -> None:
    """Rows of a parabola of R = 1000 up to a share of the contact half-width a^2 = 4 P R/(pi E*) at the largest load."""
    load = EllipseLoad(mean_normal_load=90, normal_amplitude=20, mean_tangential_load=0, tangential_amplitude=5, phase_degrees=33)
    modulus = 210e3 / (2 * (1 - 0.3**2))
    end = share * math.sqrt(4 * 110 * 1000 / (math.pi * modulus))
    table = Tabulated.model_validate({"points": [[end * k / 40, (end * k / 40) ** 2 / 2000] for k in range(41)]})
    short = scene(load).vary(profile=table)
    if held:
        largest_contact(short, "mine.toml")
        semi_analytic.solve(short, x=[0.0], fields=())
        return
    with pytest.raises(InputError, match="needs a contact wider than the table"):
        semi_analytic.solve(short, x=[0.0], fields=())
    words = r"^mine\.toml: half-plane theory refuses it: profile: the normal load 110 needs a contact wider than the table"
    with pytest.raises(InputError, match=words):
        largest_contact(short, "mine.toml")


def test_check_ends_with_2_on_a_table_that_is_too_short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = scene_text("hertz-paper")
    table = 'kind = "tabulated"\npoints = [[0.0, 0.0], [0.1, 5e-6], [0.2, 2e-5]]\n'
    file = tmp_path / "mine.toml"
    head, tail = text.split("[profile]\n")
    file.write_text(f"{head}[profile]\n{table}\n[{tail.split('[', 1)[1]}", encoding="utf-8")
    assert main(["check", str(file)]) == 2
    assert "needs a contact wider than the table" in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("sign", [1, -1])
def test_largest_ratio_of_an_ellipse(sign: int) -> None:
    """P = 3 + cos t, Q = +-(1.1 + sin t), f = 1: the tangent from the origin to a circle of radius 1 about (3, 1.1).

    Its angle is atan(1.1/3) + asin(1/sqrt(3^2 + 1.1^2)).
    """
    load = EllipseLoad(
        mean_normal_load=3,
        normal_amplitude=1,
        mean_tangential_load=1.1 * sign,
        tangential_amplitude=1,
        phase_degrees=90.0 * sign,
    )
    check = check_path(scene(load, friction=1.0))
    expected = math.tan(math.atan(1.1 / 3) + math.asin(1 / math.hypot(3, 1.1)))
    assert check.ratio == pytest.approx(expected, rel=1e-12)
    assert check.part == "cycle"
    assert check.tangential_load / check.normal_load == pytest.approx(sign * expected, rel=1e-7)


@pytest.mark.parametrize("sign", [1, -1])
def test_gross_sliding_is_found_where_it_starts(sign: int) -> None:
    """Q grows from 0 to 60 beside P = 100 during the second unit of time; f P = 50 is passed at 1 + 5/6."""
    check = check_path(scene(PolygonLoad(initial_loading=[(100, 0), (100, 60 * sign)])))
    assert check.reason == "gross sliding"
    assert check.first_time == pytest.approx(1 + 5 / 6, abs=1e-9)
    assert check.ratio == pytest.approx(1.2)
    assert (check.time, check.part) == (2.0, "initial loading")


def test_on_the_brink_is_allowed() -> None:
    assert not check_path(scene(PolygonLoad(initial_loading=[(100, 50), (100, -50)]))).reason


def test_separation() -> None:
    check = check_path(scene(PolygonLoad(initial_loading=[(100, 0), (-20, 0)])))
    assert check.reason == "separation"
    assert check.first_time == pytest.approx(1 + 100 / 120, abs=1e-9)


def test_unloading_to_nothing_is_allowed() -> None:
    assert not check_path(scene(PolygonLoad(initial_loading=[(100, 0)], cycle=[(0, 0)]))).reason


def test_shear_without_friction_is_sliding_and_none_is_not() -> None:
    assert check_path(scene(PolygonLoad(initial_loading=[(100, 1)]), friction=0.0)).reason == "gross sliding"
    assert not check_path(scene(PolygonLoad(initial_loading=[(100, 0)]), friction=0.0)).reason


def test_the_sentence_names_everything() -> None:
    words = r"my\.toml: load: gross sliding from time 1\.83333 on, worst in the initial loading at time 2 with P = 100, Q = 60, "
    with pytest.raises(InputError, match=words):
        require_admissible(scene(PolygonLoad(initial_loading=[(100, 0), (100, 60)])), "my.toml")


@pytest.mark.parametrize(("mean", "hint"), [(-20.0, True), (90.0, False)])
def test_a_initial_loading_that_is_alone_at_fault_is_told(mean: float, hint: bool) -> None:
    """The parabola is tangent to the ellipse, so it leaves zero as steeply as it must; a cycle outside the limit has none."""
    paper = load_scene("hertz-paper")
    tilted = paper.vary(load={"mean_tangential_load": mean})
    with pytest.raises(InputError) as refused:
        require_admissible(tilted, "my.toml")
    assert ('or write load.initial_loading = "straight"' in str(refused.value)) == hint


def test_a_record_in_which_compression_is_negative_is_told_so() -> None:
    rows = [[0.0, -80.0, 0.0], [1.0, -90.0, 20.0], [2.0, -100.0, -20.0], [3.0, -80.0, 0.0]]
    record = scene(PolygonLoad(initial_loading=[(100, 0)])).vary(load=TimeSeriesLoad(rows=rows, repeats=True))
    with pytest.raises(InputError, match=r"my\.toml: load: P is never positive; .* turn its sign if"):
        require_admissible(record, "my.toml")


@pytest.mark.parametrize(("repeats", "block"), [(False, 7), (True, 7), (True, 100)])
def test_a_record_is_judged_as_the_legs_between_its_rows(repeats: bool, block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of random loads, some outside the cone, some with P < 0: worst ratio, first instant and largest P of the legs."""
    monkeypatch.setattr(checking, "_BLOCK", block)
    chance = np.random.default_rng(16)
    for trial in range(60):
        normal = 100 + 60 * chance.standard_normal(30)
        rows = np.stack([np.cumsum(chance.uniform(0.1, 1, 30)), normal, 0.1 * normal * chance.standard_normal(30)], axis=1)
        rows[:, 1] = np.abs(rows[:, 1]) if trial % 2 else rows[:, 1]
        rows[-1, 1:] = rows[0, 1:]
        friction = BASE.friction.model_copy(update={"coefficient": 0.3})
        record = BASE.model_copy(update={"load": TimeSeriesLoad(rows=rows, repeats=repeats), "friction": friction})
        path, found = record.load.path(), check_path(record)
        legs = [*path.initial_loading, *path.cycle]
        p, q = (np.array([leg.loads([leg.start, leg.end])[k] for leg in legs]) for k in (0, 1))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(p < 0, np.inf, np.where(q == 0, 0.0, np.abs(q) / (0.3 * p)))
        worst = int(np.argmax(ratio.max(axis=1)))
        assert found.ratio == ratio.max()
        assert legs[worst].start <= found.time <= legs[worst].end
        assert found.part == ("cycle" if repeats and worst else "initial loading")
        outside = np.flatnonzero(ratio.max(axis=1) > 1 + 1e-12)
        assert (found.first_time is None) == (len(outside) == 0)
        if len(outside):
            assert legs[outside[0]].start <= found.first_time <= legs[outside[0]].end
        assert largest_normal_load(record) == p.max()


def test_a_long_record_is_checked_without_a_leg_for_each_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """1.9e6 rows took 1 GB and minutes as legs of Python; block by block 0.2 GB and 3 s, most of it the reading."""
    count = 200_000
    time = np.arange(count) / 100
    load = TimeSeriesLoad(rows=np.stack([time, 90 + 20 * np.cos(time), 10 * np.sin(time)], axis=1))
    monkeypatch.setattr(TimeSeriesLoad, "path", lambda _: pytest.fail("a leg for each row"))
    record = scene(PolygonLoad(initial_loading=[(100, 0)])).model_copy(update={"load": load})
    tracemalloc.start()
    try:
        require_admissible(record, "my.toml")
        assert largest_normal_load(record) == pytest.approx(110.0)
        assert tracemalloc.get_traced_memory()[1] < 150 * count  # bytes; legs alone are 450 a row
    finally:
        tracemalloc.stop()


def test_python_and_the_command_line_refuse_sliding_on_the_initial_loading_alike() -> None:
    """Q/P = 1.9/3 from P = Q = 0 on, f = 0.5: the instant alone, at which both are 0, says nothing."""
    load = EllipseLoad(mean_normal_load=3, mean_tangential_load=2, normal_amplitude=1, tangential_amplitude=0.1)
    rule = "|Q| exceeds f P, so the bodies slide as a whole and have no equilibrium under load control; lower the tangential load"
    with pytest.raises(InputError) as theory:
        semi_analytic.solve(scene(load))
    assert "gross sliding from time 1.5708 on, at time 4.71239 with P = 3, Q = 1.9, f = 0.5: " + rule in str(theory.value)
    with pytest.raises(InputError) as command:
        require_admissible(scene(load), "my.toml")
    assert "gross sliding from time 1.5708 on, worst in the cycle" in str(command.value)
    assert rule in str(command.value)


# ------------------------------------------------------------------------------------------------------- the largest contact
def steel(modulus: float = 210e3) -> Materials:
    return Materials.model_validate({"young_modulus": modulus, "poisson_ratio": 0.3})


def pressed(load: float, **changes: object) -> Scene:
    return BASE.model_copy(update={"load": PolygonLoad(initial_loading=[(load, 0.0), (load, 0.1 * load)]), **changes})


def test_numbers_of_the_largest_contact_are_those_of_hertz() -> None:
    """a = sqrt(4 P R/(pi E*)), p0 = E* a/(2 R)."""
    bodies = Bodies(lower=Block(width=20.0, height=8.0), upper=Pad(width=12.0, height=6.0))
    found = largest_contact(pressed(80.0, bodies=bodies), "mine")
    modulus = 210e3 / (2 * (1 - 0.3**2))
    half = math.sqrt(4 * 80 * 1000 / (math.pi * modulus))
    assert found.normal_load == 80
    assert found.half_width == pytest.approx(half, rel=1e-14)
    assert found.peak_pressure == pytest.approx(modulus * half / 2000, rel=1e-12)
    assert found.strain == pytest.approx(half / 2000, rel=1e-12)
    assert found.edge_slope == pytest.approx(half / 1000, rel=1e-8)
    sizes = {"lower width/a": 20, "lower height/a": 8, "upper width/a": 12, "upper height/a": 6}
    assert found.ratios == pytest.approx({"a/R": half / 1000} | {name: size / half for name, size in sizes.items()})


def test_the_peak_under_a_flat_with_rounded_edges_is_found_beside_its_corner() -> None:
    """Against 20,001 points; b/a is that of the corner."""
    scene = load_scene("flat-rounded-paper")
    found = largest_contact(scene, "mine")
    x = found.half_width * np.linspace(0, 1, 20_001)
    contact = semi_analytic.profiles.contact_of(scene.profile, scene.material)
    assert found.peak_pressure == pytest.approx(float(np.max(contact.pressure(x, found.normal_load))), rel=1e-5)
    assert found.ratios["b/a"] == pytest.approx(scene.profile.flat_half_length / found.half_width)


def test_the_peak_of_a_sharp_wedge_is_infinite_and_null_for_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wedge = pressed(80.0, profile=PowerLaw(exponent=1.0, length=1.0, rise=0.01))
    assert math.isinf(largest_contact(wedge, "mine").peak_pressure)
    (tmp_path / "wedge.json").write_text(wedge.model_dump_json(), encoding="utf-8")
    assert main(["check", str(tmp_path / "wedge.json")]) == 0
    assert "the peak pressure p0 = infinite at the tip" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "wedge.json"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["largest_contact"]["peak_pressure"] is None


def test_check_says_how_large_the_contact_gets(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "blocks"]) == 0
    said = capsys.readouterr().out
    found = largest_contact(load_scene("blocks"), "blocks")
    for words in (
        f"a = {found.half_width:.4g} mm",
        f"p0 = {found.peak_pressure:.4g} MPa",
        "a/R = ",
        "upper height/a = ",
        "p0/E* = ",
    ):
        assert words in said
    assert main(["check", "blocks", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)["result"]
    assert answer["largest_contact"] == {**vars(found), "ratios": found.ratios}
    assert answer["remarks"] == []


REMARKED = {
    "E in GPa": (
        {"material": steel(210.0)},
        ["young_modulus = 210 MPa is as soft as", "steel has 210000 MPa. Is E in GPa?"],
    ),
    "E in Pa": ({"material": steel(210e9)}, ["young_modulus = 2.1e+11 MPa is stiffer than diamond"]),
    "rubber": ({"material": Materials.model_validate({"young_modulus": 5.0, "poisson_ratio": 0.49})}, []),
    "steel": ({}, []),
    "E in psi": ({"material": steel(30e6), "units": "lbf, in, psi"}, []),
    "units of one's own": ({"material": steel(1.0), "units": "F, L, S"}, []),
    "a small roller": ({"profile": Hertz(radius=0.01)}, ["p0/E* = 0.149", "slope at the edge 0.297", "Are the loads N per mm"]),
}


@pytest.mark.parametrize("case", REMARKED)
def test_what_looks_like_a_slip_of_units_is_remarked_and_not_refused(case: str) -> None:
    changes, words = REMARKED[case]
    scene = pressed(8e-5 if case in ("rubber", "units of one's own") else 80.0, **changes)
    said = remarks(scene, largest_contact(scene, "mine"))
    assert len(said) == bool(words), said
    assert all(word in said[0] for word in words)


def test_of_the_library_only_a_steep_face_and_a_rigid_body_are_remarked_on() -> None:
    found = {name: remarks(load_scene(name), largest_contact(load_scene(name), name)) for name in scene_names()}
    assert [name for name, said in found.items() if said] == ["large-pad-steep", "layer"]


BLOCK = Block(width=20.0, height=8.0)
REFUSED = {
    "a pad narrower than its contact": (
        pressed(8.0, bodies=Bodies(lower=BLOCK, upper=Pad(width=0.1, height=8.0))),
        "the contact at the largest load reaches past the end of the narrower face, at |x| = 0.05",
    ),
    "a pad as deep as it is high": (
        pressed(8.0, profile=Hertz(radius=6.0), bodies=Bodies(lower=BLOCK, upper=Pad(width=11.0, height=3.0))),
        "bodies.upper.height = 3 is refused: the pad's face goes as deep at its sides",
    ),
    "rollers and nothing else": (
        pressed(8.0, bodies=Bodies(lower=BLOCK, upper=Block(width=20.0, height=8.0, base="rollers"))),
        "bodies.upper: nothing holds the block against the tangential load",
    ),
    "rows that end in the contact": (
        pressed(80.0, profile=Tabulated(points=[[0, 0], [0.1, 5e-6], [0.2, 2e-5]])),
        "needs a contact wider than the table",
    ),
    "rows in steps": (
        pressed(80.0, profile=Tabulated(points=[[0.03 * k, round(9e-4 * k * k / 2000, 5)] for k in range(101)])),
        "the contact would split near a half-width of",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_check_refuses_what_run_refuses_in_the_same_sentence(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And run does before it solves anything."""
    scene, words = REFUSED[case]
    file = tmp_path / "mine.json"
    file.write_text(scene.model_dump_json(), encoding="utf-8")
    said = {}
    for command in (["check", str(file)], ["run", str(file), "--quiet", "--out", str(tmp_path / "out")]):
        assert main(command) == 2
        said[command[0]] = capsys.readouterr().err.splitlines()[-1]
    assert words in said["check"]
    assert said["check"] == said["run"]
    if "rows" in case:
        monkeypatch.setattr("halfplane_fe.solve", lambda *_, **__: pytest.fail("finite elements were solved first"))
        assert main(["run", str(file), "--quiet", "--out", str(tmp_path / "out")]) == 2


def test_a_record_too_long_for_finite_elements_is_checked_without_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    time = np.arange(10_001.0)
    np.savetxt(tmp_path / "rows.csv", np.stack([time, 80 + 8 * np.cos(time), 8 * np.sin(time)], axis=1), delimiter=",")
    scene = json.loads(BASE.model_dump_json()) | {"load": {"kind": "time_series", "file": "rows.csv"}}
    (tmp_path / "mine.json").write_text(json.dumps(scene), encoding="utf-8")
    assert main(["check", str(tmp_path / "mine.json")]) == 0
    assert "Remark: The record has 10001 rows, and finite elements take at least two increments a row" in capsys.readouterr().out
