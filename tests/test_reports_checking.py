"""The load path before anything is solved: how near gross sliding, and where, against figures that a hand can check."""

import math
from pathlib import Path

import pytest

import semi_analytic
from reports.checking import check_path, require_admissible, require_profile_wide_enough
from reports.cli import main
from scenes import EllipseLoad, InputError, PolygonLoad, Scene, Tabulated, TimeSeriesLoad, load_scene, scene_names, scene_text

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
    require_profile_wide_enough(load_scene(name), name)


@pytest.mark.parametrize(("share", "held"), [(1.001, True), (0.999, False)])
def test_a_table_is_found_too_short_where_theory_finds_it_so(share: float, held: bool) -> None:
    """Rows of a parabola of R = 1000 up to a share of the contact half-width a^2 = 4 P R/(pi E*) at the largest load."""
    load = EllipseLoad(mean_normal_load=90, normal_amplitude=20, mean_tangential_load=0, tangential_amplitude=5, phase_degrees=33)
    modulus = 210e3 / (2 * (1 - 0.3**2))
    end = share * math.sqrt(4 * 110 * 1000 / (math.pi * modulus))
    table = Tabulated.model_validate({"points": [[end * k / 40, (end * k / 40) ** 2 / 2000] for k in range(41)]})
    short = scene(load).vary(profile=table)
    if held:
        require_profile_wide_enough(short, "mine.toml")
        semi_analytic.solve(short, x=[0.0], fields=())
        return
    with pytest.raises(InputError, match="needs a contact wider than the table"):
        semi_analytic.solve(short, x=[0.0], fields=())
    words = r"^mine\.toml: half-plane theory refuses it: profile: the normal load 110 needs a contact wider than the table"
    with pytest.raises(InputError, match=words):
        require_profile_wide_enough(short, "mine.toml")


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
    check = check_path(scene(PolygonLoad(way_in=[(100, 0), (100, 60 * sign)])))
    assert check.reason == "gross sliding"
    assert check.first_time == pytest.approx(1 + 5 / 6, abs=1e-9)
    assert check.ratio == pytest.approx(1.2)
    assert (check.time, check.part) == (2.0, "way in")


def test_on_the_brink_is_allowed() -> None:
    assert not check_path(scene(PolygonLoad(way_in=[(100, 50), (100, -50)]))).reason


def test_separation() -> None:
    check = check_path(scene(PolygonLoad(way_in=[(100, 0), (-20, 0)])))
    assert check.reason == "separation"
    assert check.first_time == pytest.approx(1 + 100 / 120, abs=1e-9)


def test_unloading_to_nothing_is_allowed() -> None:
    assert not check_path(scene(PolygonLoad(way_in=[(100, 0)], cycle=[(0, 0)]))).reason


def test_shear_without_friction_is_sliding_and_none_is_not() -> None:
    assert check_path(scene(PolygonLoad(way_in=[(100, 1)]), friction=0.0)).reason == "gross sliding"
    assert not check_path(scene(PolygonLoad(way_in=[(100, 0)]), friction=0.0)).reason


def test_the_sentence_names_everything() -> None:
    words = r"my\.toml: load: gross sliding from time 1\.83333 on, worst in the way in at time 2 with P = 100, Q = 60, f = 0\.5"
    with pytest.raises(InputError, match=words):
        require_admissible(scene(PolygonLoad(way_in=[(100, 0), (100, 60)])), "my.toml")


@pytest.mark.parametrize(("mean", "hint"), [(-20.0, True), (90.0, False)])
def test_a_way_in_that_is_alone_at_fault_is_told(mean: float, hint: bool) -> None:
    """The parabola is tangent to the ellipse, so it leaves zero as steeply as it must; a cycle outside the cone has no way in."""
    paper = load_scene("hertz-paper")
    tilted = paper.vary(load={"mean_tangential_load": mean})
    with pytest.raises(InputError) as refused:
        require_admissible(tilted, "my.toml")
    assert ('or write load.way_in = "straight"' in str(refused.value)) == hint


def test_a_record_in_which_compression_is_negative_is_told_so() -> None:
    rows = [[0.0, -80.0, 0.0], [1.0, -90.0, 20.0], [2.0, -100.0, -20.0], [3.0, -80.0, 0.0]]
    record = scene(PolygonLoad(way_in=[(100, 0)])).vary(load=TimeSeriesLoad(rows=rows, repeats=True))
    with pytest.raises(InputError, match=r"my\.toml: load: P is never positive; .* turn its sign if"):
        require_admissible(record, "my.toml")
