"""The mistakes of a first scene: what is said of each names the cure."""

from pathlib import Path

import pytest

import semi_analytic
from meshes import MeshSettings
from reports.sweep.points import expand
from reports.sweep.study import load_study, study_of
from scenes import ContactSolution, InputError, load_scene, scene_text

DOCS = Path(__file__).parents[1] / "docs"
PLAIN = scene_text("hertz-paper").split("[[expected]]")[0]


def refused(folder: Path, old: str, new: str) -> str:
    assert old in PLAIN
    file = folder / "mine.toml"
    file.write_text(PLAIN.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        load_scene(file)
    assert str(refusal.value).startswith(f"{file}: ")
    return str(refusal.value)


@pytest.mark.parametrize(
    ("old", "new", "cure"),
    [
        ("phase_degrees", "phase", "did you mean phase_degrees?"),  # it was "base"
        ("radius", "radius_mm", "did you mean radius?"),
        ("coefficient = 1.0", "coefficient = 1,0", "in 'coefficient = 1,0'; write a decimal point, not a comma"),
        ('kind = "ellipse"', 'kind = "ellipse', "in 'kind = \"ellipse"),
        ("title", 'units = "N, mm, GPa"\ntitle', "N/mm^2 is MPa, not GPa"),
        ("title", 'units = "N, m, MPa"\ntitle', "N/m^2 is Pa, not MPa"),
        ("title", 'units = "mm, N, MPa"\ntitle', "force, length and stress in this order"),
        ("title", 'units = "N mm MPa"\ntitle', "with commas between"),
    ],
)
def test_the_sentence_names_the_cure(old: str, new: str, cure: str, tmp_path: Path) -> None:
    assert cure in refused(tmp_path, old, new)


@pytest.mark.parametrize(
    ("key", "limit"),
    [
        ("bulk", "bulk stress in a body is not modelled"),
        ("bulk_stress", "bulk stress in a body is not modelled"),
        ("bulk_stress_lower", "bulk stress in a body is not modelled"),
        ("moment", "the bodies carry no moment and do not tilt"),
        ("tilt", "the bodies carry no moment and do not tilt"),
        ("wear", "wear is not modelled"),
        ("wear_coefficient", "wear is not modelled"),
        ("plasticity", "linear elastic, without plasticity"),
        ("yield_stress", "linear elastic, without plasticity"),
        ("temperature", "temperature is not modelled"),
        ("static_coefficient", "friction has one coefficient"),
        ("density", "quasi-static"),
        ("thickness", "per unit thickness"),
    ],
)
def test_what_no_scene_can_state_is_answered_by_the_limit(key: str, limit: str, tmp_path: Path) -> None:
    """It was "did you mean" something unrelated: title for tilt, the coefficient of friction for that of wear."""
    for table in ("[load]", "[friction]", "[profile]"):
        sentence = refused(tmp_path, table, f"{table}\n{key} = 0.5")
        assert f"unknown key {table[1:-1]}.{key} = 0.5; " in sentence
        assert limit in sentence
        assert "docs/theory.md, 'What is neglected'" in sentence
        assert "did you mean" not in sentence
    assert limit in refused(tmp_path, "title", f"{key} = 0.5\ntitle")
    assert "\n## What is neglected\n" in (DOCS / "theory.md").read_text(encoding="utf-8")


def test_an_axis_of_a_sweep_is_answered_by_the_limit_too() -> None:
    axes = [{"name": "s", "key": "bulk.lower", "values": [1.0, 2.0]}]
    with pytest.raises(InputError, match="the scene has no bulk; bulk stress in a body is not modelled"):
        expand(study_of({"scene": "hertz-paper", "axes": axes}, "here"))


@pytest.mark.parametrize("units", ["N, mm, MPa", "N, m, Pa", "kN, mm, GPa", "lbf, in, psi", "kip, in, ksi", "SI", "N, furlong, Pa"])
def test_consistent_units_and_unknown_words_are_taken(units: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(f'units = "{units}"\n{PLAIN}', encoding="utf-8")
    assert load_scene(file).units == units


def test_a_table_of_another_country_is_told_apart(tmp_path: Path) -> None:
    (tmp_path / "loads.csv").write_text("time;P;Q\n0;0,5;0\n", encoding="utf-8")
    head, _, _ = PLAIN.partition("[load]")
    (tmp_path / "mine.toml").write_text(f'{head}[load]\nkind = "time_series"\nfile = "loads.csv"\n', encoding="utf-8")
    with pytest.raises(InputError, match="commas between the columns, points in the numbers"):
        load_scene(tmp_path / "mine.toml")


def test_a_folder_is_called_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="this is a folder; name the scene file in it"):
        load_scene(tmp_path)


def test_a_scene_is_no_study(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(PLAIN, encoding="utf-8")
    with pytest.raises(InputError, match="this is a scene; a study is a file beside it"):
        load_study(file)


def test_names_of_the_version_before_are_read_with_a_warning(tmp_path):
    """A scene key, a preset, fields and a saved answer of 0.1: read, with one DeprecationWarning that gives the new name."""
    scene = load_scene("hertz-paper")
    with pytest.warns(DeprecationWarning, match="way_in is now called initial_loading"):
        assert scene.vary(load={"way_in": [[50.0, 0.0]]}).load.initial_loading == ((50.0, 0.0),)
    with pytest.warns(DeprecationWarning, match="swift is now called coarse"):
        assert MeshSettings.swift() == MeshSettings.coarse()
    with pytest.warns(DeprecationWarning, match="rigid_shift is now called tangential_displacement"):
        answer = semi_analytic.solve(scene, x=[0.0], time=[4.0], fields=("rigid_shift",))
    with pytest.warns(DeprecationWarning, match="rigid_shift is now called"):
        assert answer.rigid_shift == answer.tangential_displacement != 0
    names = {"tangential_displacement": "rigid_shift", "normal_approach": "rigid_approach"}
    answer.to_dataset().rename(names).to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    with pytest.warns(DeprecationWarning, match="is now called"):
        again = ContactSolution.load(tmp_path / "old.nc")
    assert again.tangential_displacement == answer.tangential_displacement
