"""Profiles as questions: heights, what scene files say of them, tables beside scene files, what is refused and how."""

import json

import numpy as np
import pytest
from pydantic import ValidationError

from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    PowerLaw,
    Scene,
    Tabulated,
    Wedge,
    load_scene,
    scene_schema,
)

HEAD = """
[material]
young_modulus = 210e3
poisson_ratio = 0.3
[friction]
coefficient = 0.5
[load]
kind = "polygon"
initial_loading = [[90.0, 0.0]]
[profile]
"""
PROFILES = [
    Hertz(radius=2.0),
    FlatRounded(radius=2.0, flat_half_length=0.5),
    PowerLaw(exponent=1.7, length=2.0, rise=0.5),
    Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=0.5),
    Wedge(tip_radius=2.0, tip_half_length=0.5),
    EvenPolynomial(length=2.0, rises=(0.5, 0.2)),
    Tabulated(points=[[0, 0], [1, 0.3], [2, 1.3]]),
    CallableProfile(slope_function=np.sinh, extent=3.0),
]


def scene_file(folder, profile):
    path = folder / "case.toml"
    path.write_text(HEAD + profile, encoding="utf-8")
    return path


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.kind)
def test_heights_are_symmetric_rising_and_start_at_zero(profile):
    x = np.linspace(0, 4, 401)
    height = profile.height(x)
    assert height[0] == 0
    assert np.all(np.diff(height) >= -1e-15)
    np.testing.assert_array_equal(profile.height(-x), height)
    assert np.ndim(profile.height(1.0)) == 0
    assert profile.height(np.ones((2, 3))).shape == (2, 3)
    assert profile.datum_length > 0
    if not isinstance(profile, (Hertz, FlatRounded)):
        assert "mm" in profile.in_words("mm")


@pytest.mark.parametrize("profile", PROFILES[:-1], ids=lambda profile: profile.kind)
def test_profiles_survive_json(profile):
    scene = load_scene("hertz-paper").vary(profile=profile)
    again = Scene.model_validate_json(scene.model_dump_json())
    assert again == scene
    np.testing.assert_array_equal(again.profile.height([0.3, 1.9]), profile.height([0.3, 1.9]))


def test_every_kind_is_in_the_schema():
    text = json.dumps(scene_schema())
    for profile in PROFILES:
        assert f'"{profile.kind}"' in text


@pytest.mark.parametrize(
    ("profile", "why"),
    [
        ('kind = "power_law"\nexponent = 0.9\nlength = 1.0\nrise = 1.0', r"profile\.exponent = 0\.9 .*greater than or equal to 1"),
        ('kind = "compound"\ninner_radius = 1.0\nouter_radius = -1.0\ninner_half_length = 1.0', r"profile\.outer_radius"),
        ('kind = "wedge"\ntip_radius = 1.0', r"profile\.tip_half_length is missing"),
        ('kind = "polynomial"\nlength = 1.0\nrises = [0.5, -1.0]', r"falls at x = "),
        ('kind = "polynomial"\nlength = 1.0\nrises = [0.0]', r"one of them must be positive"),
        ('kind = "tabulated"', r"profile\.points is missing"),
        ('kind = "callable"\nextent = 1.0\nheight_function = "x*x"', r"only be built in Python"),
    ],
)
def test_faults_in_files_are_sentences(tmp_path, profile, why):
    with pytest.raises(InputError, match=why) as fault:
        load_scene(scene_file(tmp_path, profile))
    assert "case.toml" in str(fault.value)


def test_a_table_lies_beside_the_scene_file(tmp_path, monkeypatch):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "trace.csv").write_text("# profilometer\nx, h\n0, 0\n1, 0.5\n\n2, 2.0\n", encoding="utf-8")
    path = scene_file(tmp_path, 'kind = "tabulated"\nfile = "deep/trace.csv"')
    monkeypatch.chdir("/")
    profile = load_scene(path).profile
    np.testing.assert_allclose(profile.height([0.5, 1.5, 3.0]), [0.125, 1.125, 4.0])
    # The rows go with the scene: nothing is read again.
    (tmp_path / "deep" / "trace.csv").unlink()
    scene = load_scene("hertz-paper").vary(profile=profile)
    assert Scene.model_validate_json(scene.model_dump_json()).profile == profile


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", r"trace\.csv: the file is empty"),
        ("x,h\n", r"trace\.csv: no row of numbers"),
        ("a,b\n0,0\n", r"trace\.csv, line 1: the columns are x, h, not 'a,b'"),
        ("x,h\n0,0\n1,oops\n2,3\n", r"trace\.csv, line 3: h = 'oops' is not a finite number"),
        ("x,h\n0,0\n1,nan\n2,3\n", r"trace\.csv, line 3: h = 'nan' is not a finite number"),
        ("0,0\n1,1\n\n2\n", r"trace\.csv, line 4: 2 numbers \(x, h\) are needed, not '2'"),
        ("x,h\n0,0\n2,1\n1,2\n", r"trace\.csv, line 4: x = 1 does not ascend"),
        ("x,h\n# a remark\n0,0\n1,2\n2,1\n", r"trace\.csv, line 5: h = 1 falls: the profile must rise"),
        ("x,h\n0,0\n1,0\n2,0\n", r"trace\.csv, line 4: the profile is flat from end to end"),
        ("x,h\n1,0\n2,1\n3,2\n", r"a row with x = 0"),
        ("x,h\n-2,4\n-1,1\n0,0\n1,1.5\n2,4\n", r"trace\.csv, line 5: the profile is not symmetric"),
        ("x,h\n-1,1\n0,0\n1,1\n2,4\n", r"trace\.csv, line 5: x = 2 has no partner on the other side"),
    ],
)
def test_faults_in_tables_name_file_line_and_rule(tmp_path, text, why):
    (tmp_path / "trace.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=why):
        load_scene(scene_file(tmp_path, 'kind = "tabulated"\nfile = "trace.csv"'))


def test_a_missing_table_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nothing\.csv: the file can't be read: No such file"):
        load_scene(scene_file(tmp_path, 'kind = "tabulated"\nfile = "nothing.csv"'))


def test_rows_given_from_python_are_counted():
    with pytest.raises(ValidationError, match=r"points, row 3: h = 0\.1 falls"):
        Tabulated(points=[[0, 0], [1, 1], [2, 0.1]])


def test_the_two_sides_are_averaged():
    rows = [[-2, 4.001], [-1, 1.0], [0, 0.0], [1, 1.001], [2, 4.0]]
    profile = Tabulated(points=rows)
    np.testing.assert_allclose(profile.height([1.0, 2.0]), [1.0005, 4.0005])


@pytest.mark.parametrize("count", [6, 25])
def test_the_spline_rises_and_bends_where_the_rows_do(count):
    rng = np.random.default_rng(3)
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, count))])
    convex = np.concatenate([[0.0], np.cumsum(np.cumsum(rng.uniform(0, 1, count)) * np.diff(x))])
    spline = Tabulated(points=np.stack([x, convex], axis=1)).spline()
    assert np.all(spline.curvature >= -1e-12 * np.max(spline.curvature))
    rising = np.concatenate([[0.0], np.cumsum(rng.uniform(0, 1, count) ** 4)])
    profile = Tabulated(points=np.stack([x, rising], axis=1))
    assert np.all(profile.spline().slope >= 0)
    np.testing.assert_allclose(profile.height(x), rising, atol=1e-14 * rising[-1])
