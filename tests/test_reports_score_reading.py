"""Tables of text as results: every convention gives the same fields, every fault one sentence."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
import pytest

from reports.scoring.mapping import Mapping, load_mapping
from reports.scoring.reading import read
from scenes import InputError, load_scene
from score_results import exact, rows, written

SCENE = load_scene("hertz-paper")


def _long():
    return rows(exact())


def _shuffled():
    return _long().sample(frac=1, random_state=1)


def _renamed():
    names = {"time": "Step Time", "x": "COORD1 [mm]", "pressure": "CPRESS", "shear": "CSHEAR1", "slip": "CSLIP1"}
    return _long().rename(columns=names)


def _framed():
    table = _long().drop(columns=["time"])
    table.insert(0, "Frame", np.repeat(np.arange(len(exact().time)), len(exact().x)))
    return table


def _by_loads():
    return _long().drop(columns=["time"])


LAYOUTS = {"long": _long, "shuffled": _shuffled, "renamed": _renamed, "framed": _framed, "by loads": _by_loads}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_of_rows_gives_the_same_fields(layout, tmp_path):
    found = read(written(LAYOUTS[layout](), tmp_path / "result.csv"), Mapping(), SCENE)
    np.testing.assert_array_equal(found.x, exact().x)
    for name in ("pressure", "shear", "slip"):
        np.testing.assert_array_equal(getattr(found, name), getattr(exact(), name))
    if layout not in ("framed", "by loads"):
        np.testing.assert_array_equal(found.time, exact().time)
    np.testing.assert_array_equal(found.normal_load, exact().normal_load)


def test_sorting_is_named(tmp_path):
    assert any("sorted" in note for note in read(written(_shuffled(), tmp_path / "r.csv"), Mapping(), SCENE).notes)
    assert not any("sorted" in note for note in read(written(_long(), tmp_path / "s.csv"), Mapping(), SCENE).notes)


@pytest.mark.parametrize("separator", [",", ";", "\t", "   "])
def test_separators(separator, tmp_path):
    lines = [separator.join(map(str, line)) for line in [list(_long().columns), *_long().to_numpy().tolist()]]
    path = tmp_path / "result.txt"
    path.write_text("# from somewhere\n\n" + "\n".join(lines) + "\n", encoding="utf-8")
    np.testing.assert_array_equal(read(path, Mapping(), SCENE).shear, exact().shear)


def test_a_decimal_comma_goes_with_semicolons(tmp_path):
    path = written(_long(), tmp_path / "result.csv", sep=";", decimal=",")
    np.testing.assert_array_equal(read(path, Mapping(), SCENE).pressure, exact().pressure)


def _wide(tag, *, own_places=False):
    columns = [] if own_places else [("X", exact().x)]
    for k, time in enumerate(exact().time):
        columns += [("X", exact().x)] if own_places else []
        end = tag.format(frame=k, time=float(time))
        columns += [(f"CPRESS{end}", exact().pressure[k]), (f"CSHEAR1{end}", exact().shear[k])]
    return columns


def _write_wide(columns, path):
    lines = [",".join(name for name, _ in columns)]
    lines += [",".join(repr(float(values[i])) for _, values in columns) for i in range(len(exact().x))]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("tag", ["", " Frame {frame}", "_{frame}", " t={time!r}", " (Step Time = {time!r})"])
def test_frames_beside_each_other(tag, tmp_path):
    found = read(_write_wide(_wide(tag), tmp_path / "paths.csv"), Mapping(), SCENE)
    np.testing.assert_array_equal(found.pressure, exact().pressure)
    np.testing.assert_array_equal(found.shear, exact().shear)
    assert any("25 frames" in note for note in found.notes)
    if "time" in tag:
        np.testing.assert_array_equal(found.time, exact().time)
    else:
        assert found.time is None


def test_frames_with_places_of_their_own(tmp_path):
    found = read(_write_wide(_wide("", own_places=True), tmp_path / "paths.csv"), Mapping(), SCENE)
    np.testing.assert_array_equal(found.x, exact().x)


def test_the_mapping_states_the_times_of_frames(tmp_path):
    path = _write_wide(_wide(""), tmp_path / "paths.csv")
    np.testing.assert_array_equal(read(path, Mapping(times=tuple(exact().time)), SCENE).time, exact().time)
    with pytest.raises(InputError, match="states 2 times and the file has 25 frames"):
        read(path, Mapping(times=(0.0, 1.0)), SCENE)


def test_places_that_move_a_little_are_averaged_and_named(tmp_path):
    table = _long()
    table["x"] += np.repeat(1e-3 * np.sin(np.arange(25)), len(exact().x))
    found = read(written(table, tmp_path / "r.csv"), Mapping(), SCENE)
    assert any("its mean was taken" in note for note in found.notes)
    np.testing.assert_allclose(found.x, exact().x, atol=1e-3)


def _broken(change):
    table = _long().astype(object)
    changed = change(table)
    return table if changed is None else changed


def _set(row, name, value):
    return lambda table: table.__setitem__(name, [value if k == row else old for k, old in enumerate(table[name])])


FAULTS = {
    "missing shear": (lambda t: t.drop(columns="shear"), "no column for shear (looked for shear, q, CSHEAR1"),
    "missing x": (lambda t: t.drop(columns="x"), "no column for x"),
    "word in a cell": (_set(7, "pressure", "n/a"), "line 9: pressure = 'n/a' is not a finite number"),
    "NaN": (_set(7, "shear", "nan"), "line 9: shear = 'nan' is not a finite number"),
    "a point twice": (_set(8, "x", float(exact().x[7])), "stands there twice in one instant"),
    "a ragged instant": (lambda t: t.drop(index=3), "every instant needs the same points"),
    "P within an instant": (_set(5, "P", 1.0), "normal_load goes from"),
    "places of another mesh": (_set(5, "x", -1.19), "the points are not the same at every instant"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_one_sentence_that_names_the_file(fault, tmp_path):
    change, words = FAULTS[fault]
    path = written(_broken(change), tmp_path / "result.csv")
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        read(path, Mapping(), SCENE)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file is empty"),
        ("# only a remark\n", "the file is empty"),
        ("x,pressure,shear\n", "no row of numbers"),
        ("0,1,2\n1,2,3\n", "line 1: the first line must name the columns"),
        ("x,pressure,shear\n0,1\n", "line 2: 3 numbers (x, pressure, shear) are needed"),
        ("x,pressure,shear\n0,1,0\n1,1,0\n", "2 points are no surface"),
        ("x,pressure,CPRESS,shear\n0,1,1,0\n", "frame 1 has no shear, or no pressure"),
        ("x,p_1,q_1,p_2\n0,1,0,1\n1,1,0,1\n2,1,0,1\n", "frame 2 has no shear, or no pressure"),
    ],
)
def test_texts_that_are_no_table(text, words, tmp_path):
    path = tmp_path / "result.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(words)):
        read(path, Mapping(), SCENE)


def test_files_that_no_reader_takes(tmp_path):
    (tmp_path / "a.odb").write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match=r"no reader for '\.odb'; it reads \.csv"):
        read(tmp_path / "a.odb", Mapping(), SCENE)
    with pytest.raises(InputError, match="there is no such file"):
        read(tmp_path / "b.csv", Mapping(), SCENE)


def _mapping(tmp_path, text):
    path = tmp_path / "mapping.toml"
    path.write_text(text, encoding="utf-8")
    return load_mapping(path)


def test_the_mapping_scales_turns_and_shifts(tmp_path):
    table = _long().drop(columns=["P", "Q"])
    table["x"] = (table["x"] + 7) / 1e3
    table["pressure"] *= -1e6
    table["shear"] *= -1e6
    table["slip"] *= -1e-3
    mapping = _mapping(
        tmp_path,
        'code = "mine 1"\nx_offset = 7.0\n[factors]\nlength = 1000\nstress = 1e-6\n[signs]\n'
        'pressure = "compression negative"\nshear = "on upper"\nslip = "lower over upper"\n',
    )
    found = read(written(table, tmp_path / "r.csv"), mapping, SCENE)
    np.testing.assert_allclose(found.x, exact().x, atol=1e-13)
    for name in ("pressure", "shear", "slip"):
        np.testing.assert_allclose(getattr(found, name), getattr(exact(), name), rtol=1e-13, atol=1e-18)
    assert found.code == "mine 1"


def test_thickness_divides_the_loads(tmp_path):
    table = _long()
    table[["P", "Q"]] *= 25.0
    found = read(written(table, tmp_path / "r.csv"), Mapping(thickness=25.0), SCENE)
    np.testing.assert_allclose(found.normal_load, exact().normal_load, rtol=1e-14)


def test_the_example_mapping_is_one_and_changes_nothing(tmp_path):
    from importlib import resources

    text = (resources.files("reports") / "templates" / "mapping.toml").read_text("utf-8")
    assert _mapping(tmp_path, text) == Mapping()
    every = re.sub(r"(?m)^# ([\w\"].*=.*|\[element_sizes\])$", r"\1", text)
    assert _mapping(tmp_path, every).columns.pressure == "CPRESS"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("colums = 1\n", "unknown key colums = 1; did you mean columns?"),
        ('[signs]\npressure = "up"\n', "signs.pressure = 'up' is refused"),
        ("thickness = -1\n", "thickness = -1 is refused"),
        ("x = [\n", "not valid TOML"),
    ],
)
def test_faults_of_a_mapping(text, words, tmp_path):
    with pytest.raises(InputError, match=re.escape(words)):
        _mapping(tmp_path, text)
    with pytest.raises(InputError, match="the mapping file can't be read"):
        load_mapping(tmp_path / "none.toml")


def test_a_column_that_the_mapping_names_must_be_there(tmp_path):
    path = written(_long(), tmp_path / "r.csv")
    with pytest.raises(InputError, match=re.escape("columns.pressure = 'presure', which is not there; did you mean 'pressure'?")):
        read(path, Mapping.model_validate({"columns": {"pressure": "presure"}}), SCENE)


def test_two_columns_for_one_quantity_are_asked_about(tmp_path):
    table = _long().assign(CSHEAR=0.0)
    table = pd.DataFrame(table).rename(columns={"shear": "cshear"})
    with pytest.raises(InputError, match=r"could each be shear; say which by columns\.shear"):
        read(written(table, tmp_path / "r.csv"), Mapping(), SCENE)
