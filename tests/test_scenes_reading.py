"""Scene files: what is read, what is refused and in which sentence. Every bad input of the promise stands in one table."""

import json
import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes import InputError, Scene, load_scene, scene_names, scene_schema, scene_text

LIBRARY = ("cattaneo-mindlin", "flat-rounded-paper", "full-stick", "hertz-normal", "hertz-paper", "motor")

PLAIN = """
[material]
young_modulus = 1
poisson_ratio = 0.3

[profile]
kind = "hertz"
radius = 2.0

[friction]
coefficient = 0.5

[load]
kind = "polygon"
initial_loading = [[2.0, 0.0]]
cycle = [[2.0, 0.5], [2.0, -0.5]]
"""

# old text, new text, what the sentence must name
REFUSED = {
    "friction below zero": (
        "coefficient = 0.5",
        "coefficient = -0.1",
        ["friction.coefficient = -0.1", "greater than or equal to 0"],
    ),
    "friction as text": ("coefficient = 0.5", 'coefficient = "0.5"', ["friction.coefficient = '0.5'", "valid number"]),
    "friction as truth": ("coefficient = 0.5", "coefficient = true", ["friction.coefficient = True", "valid number"]),
    "friction as list": ("coefficient = 0.5", "coefficient = [0.5]", ["friction.coefficient = [0.5]", "valid number"]),
    "friction as date": ("coefficient = 0.5", "coefficient = 2020-01-01", ["friction.coefficient = '2020-01-01'", "valid number"]),
    "friction not a number": ("coefficient = 0.5", "coefficient = nan", ["friction.coefficient = nan", "finite"]),
    "friction infinite": ("coefficient = 0.5", "coefficient = inf", ["friction.coefficient = inf", "finite"]),
    "nu at its upper end": ("poisson_ratio = 0.3", "poisson_ratio = 0.5", ["material.poisson_ratio = 0.5", "less than 0.5"]),
    "nu at its lower end": ("poisson_ratio = 0.3", "poisson_ratio = -1", ["material.poisson_ratio = -1", "greater than -1"]),
    "E zero": ("young_modulus = 1", "young_modulus = 0", ["material.young_modulus = 0", "greater than 0"]),
    "radius negative": ("radius = 2.0", "radius = -2.0", ["profile.radius = -2.0", "greater than 0"]),
    "unknown key": ("coefficient = 0.5", "coefficient = 0.5\ncolour = 3", ["unknown key friction.colour = 3", "halfplane schema"]),
    "unknown table": ("[friction]", "[paint]\ncolour = 3\n[friction]", ["unknown key paint", "halfplane schema"]),
    "misspelt key": (
        "coefficient",
        "coeficient",
        ["unknown key friction.coeficient", "did you mean coefficient?", "(also at fault: friction.coefficient)"],
    ),
    "missing key": ("coefficient = 0.5", "", ["the key friction.coefficient is missing", "halfplane schema"]),
    "missing table": ("[friction]\ncoefficient = 0.5", "", ["the key friction is missing"]),
    "missing material": ("[material]", "[material.upper]", ["the key material.lower is missing"]),
    "missing kind": ('kind = "hertz"', "", ["the key profile.kind is missing"]),
    "unknown kind": ('kind = "hertz"', 'kind = "hurtz"', ["profile.kind = 'hurtz'", "'hertz' or 'flat_rounded'"]),
    "unknown kind of load": ('kind = "polygon"', 'kind = "circle"', ["load.kind = 'circle'", "'ellipse' or 'polygon'"]),
    "pad wider than its block": (
        "[friction]",
        '[bodies]\nupper = {kind = "pad", width = 50.0, height = 9.0}\nlower = {kind = "block", width = 20.0, height = 3.0}\n'
        "[friction]",
        ["bodies is refused", "a pad of width 50", "the block that it faces, of width 20", "make the pad narrower"],
    ),
    "pad past its arcs": (
        "[friction]",
        '[bodies.upper]\nkind = "pad"\nwidth = 2000.0\nheight = 9.0\n[friction]',
        ["bodies.upper.width = 2000", "arcs, at 4"],
    ),
    "cylinder of another radius": (
        "[friction]",
        '[bodies.upper]\nkind = "cylinder"\nradius = 50.0\n[friction]',
        ["profile is not that of the cylinders", "radius = 50"],
    ),
    "two pads": (
        "[friction]",
        '[bodies]\nupper = {kind = "pad", width = 5.0, height = 9.0}\nlower = {kind = "pad", width = 5.0, height = 9.0}\n'
        "[friction]",
        ["bodies is refused", "a pad on a pad"],
    ),
    "unknown bodies": ("[friction]", '[bodies.upper]\nkind = "ball"\n[friction]', ["bodies.upper.kind = 'ball'", "'half_plane'"]),
    "no point": ("initial_loading = [[2.0, 0.0]]", "initial_loading = []", ["load.initial_loading = []", "at least 1 item"]),
    "half a point": ("[2.0, 0.5]", "[2.0]", ["load.cycle.0 = [2.0]", "[P, Q]"]),
    "a point of words": ("[2.0, 0.5]", '[2.0, "x"]', ["load.cycle.0.1 = 'x'", "valid number"]),
    "a point twice": ("[2.0, 0.5]", "[2.0, 0.0]", ["load is refused", "[2.0, 0.0] stands twice in a row"]),
    "no cycle": ("[material]", "cycles = 0\n[material]", ["cycles = 0", "greater than or equal to 1"]),
    "tolerance zero": ("[friction]", "[tolerances]\nshear = 0\n[friction]", ["tolerances.shear = 0", "greater than 0"]),
    "material a number": (
        "[material]\nyoung_modulus = 1\npoisson_ratio = 0.3",
        "material = 3",
        ["material = 3", "a table of keys"],
    ),
}


def refusal(path):
    """The one sentence with which `path` is refused."""
    with pytest.raises(InputError) as caught:
        load_scene(path)
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert "Traceback" not in sentence
    return sentence


@pytest.mark.parametrize("fault", REFUSED)
def test_every_fault_is_one_sentence_naming_file_key_value_and_rule(fault, tmp_path):
    old, new, named = REFUSED[fault]
    assert PLAIN.count(old) >= 1
    file = tmp_path / "mine.toml"
    file.write_text(PLAIN.replace(old, new, 1), encoding="utf-8")
    sentence = refusal(file)
    assert sentence.startswith(f"{file}: ")
    for part in named:
        assert part in sentence, sentence


@pytest.mark.parametrize("fault", sorted(set(REFUSED) - {"friction as date"}))
def test_json_files_are_refused_in_the_same_words(fault, tmp_path):
    old, new, named = REFUSED[fault]
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(tomllib.loads(PLAIN.replace(old, new, 1))), encoding="utf-8")
    sentence = refusal(file)
    assert all(part in sentence for part in named), sentence


@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [
        ("empty.toml", "", "is empty"),
        ("blank.json", " \n", "is empty"),
        ("broken.toml", "[material", "not valid TOML"),
        ("broken.json", '{"material": ', "not valid JSON"),
        ("list.json", "[1, 2]", "a table of keys, not a list"),
        ("nothing.json", "null", "a table of keys"),
        ("scene.yaml", PLAIN, "ends in .toml or .json, not in '.yaml'"),
        ("scene.TOML", PLAIN, "ends in .toml or .json, not in '.TOML'"),
        ("deep.json", "[" * 100_000, "not valid JSON"),
        ("deep.toml", "a = " + "[" * 100_000, "not valid TOML"),
        ("long.json", '{"cycles": ' + "1" * 5000 + "}", "not valid JSON"),
    ],
)
def test_files_that_hold_no_scene(name, text, rule, tmp_path):
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    sentence = refusal(file)
    assert sentence.startswith(f"{file}: ")
    assert rule in sentence


def test_unreadable_files(tmp_path):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    folder = tmp_path / "folder.toml"
    folder.mkdir()
    assert "it is not UTF-8 text" in refusal(binary)
    assert "can't be read: Is a directory" in refusal(folder)
    assert "can't be read: No such file or directory" in refusal(tmp_path / "nowhere" / "mine.toml")


def test_file_that_may_not_be_read(tmp_path, monkeypatch):
    # By a planted error: root, who runs many CIs, may read everything.
    file = tmp_path / "mine.toml"
    file.write_text(PLAIN, encoding="utf-8")

    def denied(*args, **kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_text", denied)
    assert refusal(file) == f"{file}: the scene file can't be read: Permission denied"


def test_unknown_scene_names_the_nearest_or_all():
    assert "did you mean hertz-paper?" in refusal("hertz-papr")
    far = refusal("zzz")
    assert all(name in far for name in scene_names())
    with pytest.raises(InputError, match="no such scene"):
        scene_text("zzz")


def test_the_key_of_a_second_fault_is_named(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(PLAIN.replace("radius = 2.0", "radius = -1").replace("0.5\n", "-0.5\n", 1), encoding="utf-8")
    assert refusal(file).endswith("(also at fault: friction.coefficient)")


def test_toml_and_json_are_one_scene(tmp_path):
    as_toml, as_json = tmp_path / "mine.toml", tmp_path / "mine.json"
    as_toml.write_text(PLAIN, encoding="utf-8")
    as_json.write_text(json.dumps(tomllib.loads(PLAIN)), encoding="utf-8")
    scene = load_scene(as_toml)
    assert scene == load_scene(str(as_json))
    assert scene.name == "mine"  # the file's stem
    assert scene.friction.coefficient == 0.5
    assert scene.material.alike
    assert scene.material.lower.young_modulus == 1.0  # a whole number is a number
    assert scene.load.cycle == ((2.0, 0.5), (2.0, -0.5))


def test_byte_order_mark_is_no_fault(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(PLAIN, encoding="utf-8-sig")
    assert load_scene(file).profile.radius == 2.0


def test_two_materials_and_all_options(tmp_path):
    text = PLAIN.replace(
        "[material]\nyoung_modulus = 1\npoisson_ratio = 0.3",
        "[material.upper]\nyoung_modulus = 3.0\npoisson_ratio = 0.1\n[material.lower]\nyoung_modulus = 1.0\npoisson_ratio = -0.2",
    )
    text = 'name = "other"\ncycles = 2\n' + text + "\n[tolerances]\nshear = 0.5\n"
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    scene = load_scene(file)
    assert not scene.material.alike
    assert (scene.material.upper.young_modulus, scene.material.lower.poisson_ratio) == (3.0, -0.2)
    assert (scene.name, scene.cycles, scene.tolerances.shear) == ("other", 2, 0.5)


def test_scene_is_frozen_and_survives_json():
    scene = load_scene("hertz-paper")
    with pytest.raises(Exception, match="frozen"):
        scene.cycles = 3
    assert Scene.model_validate_json(scene.model_dump_json()) == scene


def test_library_is_complete_and_every_scene_says_what_it_is():
    assert set(LIBRARY) <= set(scene_names())
    assert scene_names() == tuple(sorted(scene_names()))
    for name in scene_names():
        scene = load_scene(name)
        assert scene.name == name
        assert all((scene.title, scene.purpose, scene.source))
        assert tomllib.loads(scene_text(name))["load"]["kind"] == scene.load.kind


def test_library_numbers():
    """Loads in the paper's proportion 3 : 1.1 : 1 : 1 that press the contact to a half-width of 1 mm."""
    scene = load_scene("hertz-paper")
    load, steel = scene.load, scene.material.lower
    modulus = steel.young_modulus / (2 * (1 - steel.poisson_ratio**2))
    assert 4 * load.mean_normal_load * scene.profile.radius / (math.pi * modulus) == pytest.approx(1.0, rel=1e-14)
    ratios = [
        value / load.mean_normal_load * 3 for value in (load.mean_tangential_load, load.normal_amplitude, load.tangential_amplitude)
    ]
    assert ratios == pytest.approx([1.1, 1.0, 1.0], rel=1e-14)
    assert (load.phase_degrees, load.initial_loading, scene.friction.coefficient) == (90.0, "parabola", 1.0)
    mindlin = load_scene("cattaneo-mindlin")
    (p, q), (_, back) = mindlin.load.cycle
    assert q == pytest.approx(0.6 * mindlin.friction.coefficient * p, rel=1e-14)
    assert back == -q


def test_schema_lists_the_keys_and_their_rules():
    schema = scene_schema()
    json.dumps(schema)
    assert schema["additionalProperties"] is False
    assert set(schema["required"]) == {"material", "profile", "friction", "load"}
    assert schema["$defs"]["Friction"]["properties"]["coefficient"]["minimum"] == 0
    ratio = schema["$defs"]["Elastic"]["properties"]["poisson_ratio"]
    assert (ratio["exclusiveMinimum"], ratio["exclusiveMaximum"]) == (-1, 0.5)
    assert {"EllipseLoad", "PolygonLoad", "Hertz", "FlatRounded"} <= set(schema["$defs"])


SIMPLE = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
TREES = st.recursive(SIMPLE, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3))


@given(
    place=st.lists(
        st.sampled_from(["material", "profile", "friction", "load", "kind", "cycle", "initial_loading", "coefficient"]), max_size=2
    ),
    value=TREES,
)
def test_whatever_stands_in_a_file_is_a_scene_or_a_sentence(place, value, tmp_path_factory):
    data = tomllib.loads(PLAIN)
    table = data
    for key in place[:-1]:
        table = table[key] if isinstance(table.get(key), dict) else table
    table[place[-1] if place else "extra"] = value
    file = tmp_path_factory.getbasetemp() / "any.json"
    file.write_text(json.dumps(data), encoding="utf-8")
    try:
        answer = load_scene(file)
    except InputError as sentence:
        answer = str(sentence)
    assert isinstance(answer, Scene) or answer.startswith(f"{file}: ")
