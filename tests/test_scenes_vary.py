"""A scene changed or made from Python is checked as a file is, also by each engine; saved scenes
come back.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import reports
import semi_analytic
from refusals import refused_for, require_facts
from reports import score
from reports.advising_by_numbers import advise_by_numbers
from reports.studies.sweep import run
from reports.studies.sweep.study import study_of
from reports.studies.third.deck import build_deck
from scenes import (
    Block,
    Bodies,
    CallableLoad,
    CallableProfile,
    ContactSolution,
    Elastic,
    FlatRounded,
    Friction,
    Hertz,
    InputError,
    Materials,
    PolygonLoad,
    Scene,
    Tabulated,
    TimeSeriesLoad,
    load_scene,
    scene_names,
    scene_text,
)
from scenes.measured import Table

PAPER = load_scene("hertz-paper")
WIDE = Bodies(lower=Block(width=40.0, height=20.0))
STUDY = {"scene": "hertz-paper", "engines": ["exact"], "figures": ["exact.dissipation"]}


SOFT = Elastic(young_modulus=115e3, poisson_ratio=0.32)
# What is changed, and what then stands where.
CHANGED = [
    *(
        ({"friction": given}, "friction.coefficient", 0.6)
        for given in (0.6, np.float64(0.6), {"coefficient": 0.6}, Friction(coefficient=0.6))
    ),
    *(
        ({"load": given | {"phase_degrees": 60}}, "load.phase_degrees", 60.0)
        for given in ({}, {"kind": "ellipse"})
    ),
    *(
        ({"load": given}, "load.initial_loading", ((1.0, 0.0),))
        for given in (
            PolygonLoad(initial_loading=[(1, 0)]),
            {"kind": "polygon", "initial_loading": [[1, 0]]},
        )
    ),
    (
        {"profile": {"kind": "flat_rounded", "radius": 3, "flat_half_length": 1}},
        "profile.flat_half_length",
        1.0,
    ),
    *(
        ({"bodies": given}, "bodies.lower.height", 20.0)
        for given in (WIDE, {"lower": {"kind": "block", "width": 40, "height": 20}})
    ),
    ({"material": {"upper": {"young_modulus": 7e4}}}, "material.upper.young_modulus", 7e4),
    ({"material": {"poisson_ratio": 0.2}}, "material.upper.poisson_ratio", 0.2),
    *(({"material": SOFT}, f"material.{body}.young_modulus", 115e3) for body in ("upper", "lower")),
    ({"cycles": 2}, "cycles", 2),
]


@pytest.mark.parametrize(("changes", "key", "value"), CHANGED)
def test_the_key_is_changed_and_nothing_else(changes: dict[str, Any], key: str, value: Any) -> None:
    changed = PAPER.vary(**changes)
    part_value: Any = changed
    for part in key.split("."):
        part_value = getattr(part_value, part)
    assert part_value == value
    assert changed != PAPER
    assert changed.vary(**{name: getattr(PAPER, name) for name in changes}) == PAPER


def test_a_mapping_keeps_the_keys_that_it_does_not_name_at_every_depth() -> None:
    scene = load_scene("blocks")
    changed = scene.vary(
        bodies={"lower": {"height": 7}}, material={"upper": {"poisson_ratio": 0.2}}
    )
    assert (changed.bodies.lower, changed.bodies.upper) == (
        scene.bodies.lower.vary(height=7),
        scene.bodies.upper,
    )
    assert changed.material == Materials(
        lower=scene.material.lower, upper=scene.material.upper.vary(poisson_ratio=0.2)
    )
    material = scene.vary(material={"young_modulus": 7e4}).material
    assert material.upper == material.lower == scene.material.lower.vary(young_modulus=7e4)


# Of rules that a file breaks too, one of each way that a change is given: a key, a part of a table,
# an unchecked object.
SAID = [
    ({"frictoin": 0.6}, ["unknown key frictoin = 0.6", "did you mean friction?"]),
    ({"load": {"phase": 60}}, ["unknown key load.phase = 60", "did you mean phase_degrees?"]),
    ({"bodies": {"lower": {"height": 3}}}, ["unknown key bodies.lower.height = 3"]),
    ({"material": {"poisson_ratio": 0.7}}, ["material.upper.poisson_ratio = 0.7", "less than 0.5"]),
    ({"material": {"young_modulus": 1, "upper": {}}}, ["unknown key material.young_modulus"]),
    ({"friction": -1}, ["friction = -1 is refused", "greater than or equal to 0"]),
    ({"friction": True}, ["friction is refused", "neither a number nor a table"]),
    ({"friction": float("nan")}, ["friction = nan", "finite"]),
    # the ellipse's is not taken over
    ({"load": {"kind": "polygon"}}, ["load.initial_loading is missing"]),
    ({"load": 3}, ["load = 3", "table of keys"]),
    ({"profile": Hertz.model_construct(radius=-1.0)}, ["profile.radius = -1.0", "greater than 0"]),
    ({"profile": Hertz.model_construct()}, ["profile.radius is missing"]),
    (
        {
            "bodies": Bodies.model_construct(
                lower=Block.model_construct(kind="block", width=-1.0, height=1.0)
            )
        },
        ["bodies.lower.width"],
    ),
]


@pytest.mark.parametrize(("changes", "expected_words"), SAID)
def test_what_a_file_may_not_say_is_refused_in_one_sentence(
    changes: dict[str, Any], expected_words: list[str]
) -> None:
    for change in (lambda: PAPER.vary(**changes), lambda: PAPER.model_copy(update=changes)):
        with pytest.raises(InputError) as refusal:
            change()
        assert str(refusal.value).startswith("vary: ")
        assert "\n" not in str(refusal.value)
        require_facts(str(refusal.value), *expected_words)


@pytest.mark.parametrize(
    "part",
    [
        PAPER.profile,
        PAPER.load,
        PAPER.material,
        PAPER.material.lower,
        PAPER.friction,
        PAPER.tolerances,
        WIDE,
        WIDE.lower,
    ],
    ids=lambda part: type(part).__name__,
)
def test_parts_of_a_scene_are_as_careful(part: Any) -> None:
    for change in (lambda: part.vary(raduis=3), lambda: part.model_copy(update={"raduis": 3})):
        with pytest.raises(InputError, match=r"unknown key (upper\.)?raduis"):
            change()
    with pytest.raises(InputError, match="take vary"):
        part.copy(update={"radius": 3})
    assert part.model_copy() == part == part.vary()


# -------------------------------------------------------------------- past the checks, at each door
def beside(**changes: Any) -> Scene:
    """The paper's scene with parts that nothing checked; None leaves one out."""
    keys = {name: value for name, value in (dict(PAPER) | changes).items() if value is not None}
    return Scene.model_construct(**keys)


RIGID = Elastic.model_construct(young_modulus=210e3, poisson_ratio=0.7)
NAN = TimeSeriesLoad.model_construct(rows=Table(np.array([[0.0, 1.0, 0.0], [1.0, np.nan, 0.0]])))
LOAD = PAPER.load.model_construct(**(dict(PAPER.load) | {"tangential_amplitude": -1.0}))
# By what the refusal says.
UNCHECKED = {
    "poisson_ratio = 0.7": beside(material=Materials.model_construct(upper=RIGID, lower=RIGID)),
    "load.tangential_amplitude": beside(load=LOAD),
    "friction is missing": beside(friction=None),
}
DOORS: dict[str, Callable[[Any], object]] = {
    "semi_analytic.solve": semi_analytic.solve,
    "semi_analytic.events": semi_analytic.events,
    "halfplane_fe.solve": halfplane_fe.solve,
    "reports.score": lambda scene: score([0.0, 0.1], [1.0, 1.0], [0.0, 0.0], scene=scene),
    "export": build_deck,
    "advise": advise_by_numbers,
}
LOADS = {
    "friction_coefficient": 0.5,
    "mean_normal_load": 3.0,
    "normal_amplitude": 1.0,
    "tangential_amplitude": 1.0,
}
BATCHES = (semi_analytic.dissipation, semi_analytic.peak_dissipation)


UNLIKE = Materials.model_construct(upper=RIGID, lower=RIGID)
STUDY_OF = study_of(
    STUDY | {"axes": [{"name": "f", "key": "friction", "values": [0.8, 0.9]}]}, "here"
)
OF_NO_SCENE = {
    7: "a Scene is needed, not 7; load_scene reads one",
    "hertz-papr": "no such scene or file; did you mean hertz-paper",
}
# A call with a folder, and what the refusal says: of scenes at each door, of tables, batches and
# sweeps.
CALLS: list[tuple[Callable[[Path], object], str]] = [
    *(
        (lambda _, enter=enter, scene=scene: enter(scene), f"^Scene 'hertz-paper': .*{said}")
        for enter in DOORS.values()
        for said, scene in UNCHECKED.items()
    ),
    (lambda _: semi_analytic.solve(beside(load=NAN)), "is not all finite numbers"),
    *(
        (
            lambda _, call=call: call(profile=PAPER.profile, material=UNLIKE, **LOADS),
            r"upper\.poisson_ratio = 0\.7",
        )
        for call in BATCHES
    ),
    *(
        (
            lambda _, call=call: call(
                profile=Hertz.model_construct(radius=-1.0), material=PAPER.material, **LOADS
            ),
            r"radius = -1\.0",
        )
        for call in BATCHES
    ),
    (
        lambda out: run(
            STUDY_OF.model_construct(**dict(STUDY_OF) | {"scene": beside(load=LOAD)}),
            out,
            workers=1,
        ),
        r"scene\.load\.tangential_amplitude = -1\.0",
    ),
    *(
        (lambda _, enter=enter, scene=scene: enter(scene), said)
        for enter in (semi_analytic.solve, halfplane_fe.solve)
        for scene, said in OF_NO_SCENE.items()
    ),
    (lambda _: semi_analytic.events("hertz-paper"), "a Scene is needed, not 'hertz-paper'"),
]


# Public functions of a solution, of a scene and of a comparison.
OF_SOLUTION: tuple[Callable[[Any], object], ...] = (
    semi_analytic.extremes,
    semi_analytic.hysteresis,
    semi_analytic.compliance,
    halfplane_fe.largest_edge_tension,
    lambda solution: halfplane_fe.edge_tension(solution, [1]),
    lambda solution: halfplane_fe.fields(solution, [1.0]),
    lambda solution: halfplane_fe.stress(solution, [0.0], [0.0], [1.0]),
    lambda solution: reports.compare(solution, solution),
)
OF_SCENE: tuple[Callable[[Any], object], ...] = (
    semi_analytic.eccentricity,
    semi_analytic.events,
    semi_analytic.solve,
    lambda scene: semi_analytic.change_by_tilt_and_strain(scene, effects=None),
    lambda scene: semi_analytic.fretting_map(scene, [1.0]),
    halfplane_fe.body_effects,
    halfplane_fe.require_solvable,
    halfplane_fe.solve,
    reports.input_effects,
)
OF_COMPARISON: tuple[Callable[[Any], object], ...] = (
    lambda comparison: reports.figure(comparison, "hysteresis"),
    lambda comparison: reports.write(comparison, "nowhere"),
)


@pytest.mark.parametrize("solution_function", OF_SOLUTION)
def test_what_is_no_solution_is_refused_in_one_sentence(
    solution_function: Callable[[Any], object],
) -> None:
    others = {"a Scene": PAPER, "'hertz-paper'": "hertz-paper", "None": None, "{}": {}}
    for words, other in others.items():
        with pytest.raises(InputError, match=f"ContactSolution is needed, not {words};.*return"):
            solution_function(other)


@pytest.mark.parametrize("scene_function", OF_SCENE)
def test_a_solution_is_refused_where_a_scene_is_needed(
    scene_function: Callable[[Any], object],
) -> None:
    solution = semi_analytic.solve(PAPER, x=[0.0], time=[2.0], fields=())
    with pytest.raises(InputError, match="a Scene is needed, not a ContactSolution; load_scene"):
        scene_function(solution)


@pytest.mark.parametrize(
    ("path_function", "needed"),
    [
        (load_scene, "load_scene: the name of a scene or the path of its file"),
        (lambda path: run(path, "nowhere"), "load_study: a Study or the path of its file"),
        (ContactSolution.load, "ContactSolution.load: the path of a file"),
        (lambda path: score([0.0], [1.0], None, scene=path), "a Scene"),
    ],
)
def test_what_is_no_path_is_refused_in_one_sentence(
    path_function: Callable[[Any], object], needed: str
) -> None:
    for words, other in {"7": 7, "None": None, "{}": {}}.items():
        with pytest.raises(InputError, match=f"^{needed} is needed, not {words}"):
            path_function(other)


@pytest.mark.parametrize("comparison_function", OF_COMPARISON)
def test_a_solution_is_refused_where_a_comparison_is_needed(
    comparison_function: Callable[[Any], object],
) -> None:
    solution = semi_analytic.solve(PAPER, x=[0.0], time=[2.0], fields=())
    with pytest.raises(InputError, match="a Comparison is needed, not a ContactSolution; compare"):
        comparison_function(solution)


@pytest.mark.parametrize(("call", "words"), CALLS)
def test_no_door_takes_what_went_past_the_checks(
    call: Callable[[Path], object], words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=words):
        call(tmp_path / "out")
    assert not (tmp_path / "out").exists()


# -------------------------------------------------------------------------------------- short forms
def test_a_name_a_path_and_a_scene_have_one_answer(tmp_path: Path) -> None:
    PAPER.save(tmp_path / "mine.toml")
    same = semi_analytic.solve(PAPER, x=[0.5], time=[9.0], fields=["shear"])
    for source in (str(tmp_path / "mine.toml"), tmp_path / "mine.toml", "hertz-paper"):
        assert (
            semi_analytic.solve(source, x=0.5, time=9.0, fields="shear").shear.item()
            == same.shear.item()
            != 0.0
        )


def test_friction_as_a_number_stands_for_its_table(tmp_path: Path) -> None:
    """In a file, and in the constructor."""
    head, _, rest = scene_text("hertz-paper").partition("[friction]\n")
    (tmp_path / "mine.toml").write_text(
        f"friction = 0.6\n{head}{rest.partition(chr(10) * 2)[2]}", "utf-8"
    )
    assert load_scene(tmp_path / "mine.toml").vary(name=PAPER.name) == PAPER.vary(
        friction={"coefficient": 0.6}
    )
    assert Scene(**dict(PAPER) | {"friction": 1}) == PAPER


# -------------------------------------------------------------------------------------------- saved
@pytest.mark.parametrize("name", scene_names())
def test_a_saved_scene_is_read_back_as_it_was(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    # A scene with a CSV file takes its rows along.
    expected = scene.vary(load={"file": None}) if isinstance(scene.load, TimeSeriesLoad) else scene
    for suffix in (".toml", ".json"):
        scene.save(tmp_path / f"mine{suffix}")
        assert load_scene(tmp_path / f"mine{suffix}") == expected
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.json", "mine.toml"]


def test_any_words_survive_and_what_can_not_be_saved_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    words = "".join(map(chr, [*range(1, 0x250), 0x2028, 0x1F600])) + "'''\"\"\"\\ # = [a.b]"
    scene = PAPER.vary(
        title=words,
        purpose="\n".join(words),
        profile=Tabulated(points=[[0, 0], [1, 0.1], [2, 1e-1 / 3 * 9]]),
    )
    scene.save(path)
    assert load_scene(path) == scene
    before = path.read_bytes()
    rows = np.column_stack(
        [np.arange(40_000.0), np.full(40_000, 90.0), np.sin(np.arange(40_000.0))]
    )
    long = PAPER.vary(load=TimeSeriesLoad(rows=rows))
    with refused_for("1.05 MB", "save it as .json"):
        long.save(path)
    with refused_for("Python function"):
        PAPER.vary(profile=CallableProfile(height_function=lambda x: x**2 / 2000, extent=3.0)).save(
            path
        )
    assert path.read_bytes() == before
    long.save(tmp_path / "mine.json")
    assert load_scene(tmp_path / "mine.json") == long
    for bad, rule in (
        (tmp_path / "mine.yaml", "ends in .toml or .json"),
        (tmp_path / "no" / "a.toml", "can't be written"),
    ):
        with refused_for(rule):
            PAPER.save(bad)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.json", "mine.toml"]


def test_a_scene_of_functions_is_checked_again_and_stays_itself() -> None:
    profile = CallableProfile(slope_function=lambda x: x / 1000, extent=3.0)
    load = CallableLoad(
        normal_load=lambda t: 90 + 30 * np.cos(t),
        tangential_load=lambda t: 20 * np.sin(t),
        duration=2 * np.pi,
    )
    scene = PAPER.vary(profile=profile, load=load, friction=0.9)
    assert (scene.profile, scene.load) == (profile, load)
    assert hash(scene.profile) == hash(profile)
    assert scene == PAPER.vary(friction=0.9).vary(profile=profile).vary(load=load)
    assert scene.vary(profile=FlatRounded(radius=1.0, flat_half_length=1.0)) != scene
    with refused_for("can't be written", "Python function"):
        scene.model_dump_json()
