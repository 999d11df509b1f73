"""Standard uncertainties of a scene's inputs: what is read, what is refused, and the scene with its
inputs moved.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import answer_of, halfplane
from refusals import refused_for
from scenes import (
    Bodies,
    Cylinder,
    DrivenWave,
    DrivenWaveSum,
    EllipseLoad,
    HarmonicLoad,
    InputError,
    PolygonLoad,
    Scene,
    TimeSeriesLoad,
    load_scene,
    scene_text,
)
from scenes.loads import DrivenApproach

PAPER = scene_text("blocks").split("[[expected]]")[0]
STATED = """
friction = "5 %"
normal_load = "2 percent"
tangential_load = "2%"
phase_degrees = "0.05 rad"
profile.radius = "10 mm"
material.young_modulus = "2.1 GPa"
bodies.lower.height = "100 um"
correlations = [["normal_load", "tangential_load", 0.5]]
"""


def written(folder: Path, keys: str) -> Scene:
    path = folder / "scene.toml"
    path.write_text(f"{PAPER}\n[uncertainty]\n{keys}\n", encoding="utf-8")
    return load_scene(path)


def test_shares_and_amounts_are_read_in_the_units_of_the_scene(tmp_path: Path) -> None:
    scene = written(tmp_path, STATED)
    shares = {entry.key: entry.standard_uncertainty for entry in scene.inputs}
    assert shares == pytest.approx(
        {
            "friction": 0.05,
            "normal_load": 0.02,
            "tangential_load": 0.02,
            "phase_degrees": math.degrees(0.05),
            "profile.radius": 0.01,
            "material.young_modulus": 0.01,
            "bodies.lower.height": 0.01,
        },
        rel=1e-12,
    )
    scene.save(tmp_path / "saved.toml")
    assert load_scene(tmp_path / "saved.toml") == scene.vary(name=scene.name)
    matrix = scene.uncertainty.correlation_matrix() if scene.uncertainty else np.empty(0)
    assert matrix[1, 2] == matrix[2, 1] == 0.5
    assert np.trace(matrix) == len(shares)


# keys, what the sentence must name
REFUSED = {
    "a share without its sign": ("friction = 0.05", 'uncertainty.friction|0.05 is a bare|"5 %"'),
    "a number as text": ('friction = "5"', "uncertainty.friction|'5' has no unit"),
    "another unit": ('friction = "0.05 mm"', "uncertainty.friction|not in per cent"),
    "a unit of another kind": ('profile.radius = "1 kg"', "profile.radius = '1 kg'|no unit of le"),
    "a misspelt key": ('frition = "5 %"', "uncertainty.frition|did you mean friction?"),
    "what the profile lacks": (
        'profile.flat_half_length = "1 %"',
        "uncertainty.profile.flat_half_length|'hertz' has no flat_half_length",
    ),
    "what the body lacks": ('bodies.lower.radius = "1 %"', "kind 'block' has no radius"),
    "what the rig lacks": ('rig.normal_stiffness = "1 %"', "rig has no normal_stiffness"),
    "a share of the phase": ('phase_degrees = "5 %"', "uncertainty.phase_degrees|no share"),
    "zero": ("phase_degrees = 0.0", "uncertainty.phase_degrees = 0.0|greater than 0"),
    "below zero": ('friction = "-5 %"', "uncertainty.friction|'-5 %' is not above 0"),
    "above half": ('friction = "60 %"', "uncertainty.friction|at most 50 %"),
    "an amount above half": ('profile.radius = "2 m"', "profile.radius|at most 50 %"),
    "no approach here": ('approach = "1 %"', "uncertainty.approach|state normal_load"),
    "one material": ('material.upper.poisson_ratio = "1 %"', "state it without upper and lower"),
    "a correlation of nothing": (
        'correlations = [["friction", "normal_load", 0.5]]',
        "correlations|'friction' has no standard uncertainty",
    ),
    "a correlation above 1": (
        'friction = "5 %"\nnormal_load = "1 %"\ncorrelations = [["friction", "normal_load", 1.5]]',
        "uncertainty.correlations|1.5|between -1 and 1",
    ),
    "a correlation twice": (
        'friction = "5 %"\nnormal_load = "1 %"\n'
        'correlations = [["friction", "normal_load", 0.5], ["normal_load", "friction", 0.5]]',
        "correlations|two entries",
    ),
    "impossible correlations": (
        'friction = "5 %"\nnormal_load = "1 %"\ntangential_load = "1 %"\n'
        'correlations = [["friction", "normal_load", 0.9], ["friction", "tangential_load", 0.9],'
        ' ["normal_load", "tangential_load", -0.9]]',
        "correlations|negative eigenvalue",
    ),
}


@pytest.mark.parametrize(("keys", "facts"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused(keys: str, facts: str, tmp_path: Path) -> None:
    with refused_for("scene.toml", *facts.split("|")):
        written(tmp_path, keys)


OTHER_SCENES: dict[str, tuple[str, dict[str, Any], str]] = {
    "a polygon has no phase": ("cattaneo-mindlin", {"phase_degrees": 3.0}, "polygon"),
    "two materials": ("unlike-beta-fifth", {"material": {"young_modulus": "1 %"}}, "upper and low"),
    "cylinders": ("two-cylinders", {"profile": {"radius": "1 %"}}, "radius of the bodies"),
    "frictionless": ("cylinder-roller-frictionless", {"friction": "1 %"}, "frictionless"),
    "U in the place of Q": ("rig-blocks", {"tangential_load": "1 %"}, "tangential_displacement"),
}


@pytest.mark.parametrize(("name", "keys", "fact"), OTHER_SCENES.values(), ids=OTHER_SCENES)
def test_what_the_scene_does_not_have(name: str, keys: dict[str, Any], fact: str) -> None:
    with refused_for("uncertainty.", fact):
        load_scene(name).vary(uncertainty=keys)


def test_amounts_need_units_that_are_known() -> None:
    scene = load_scene("hertz-paper").vary(units="SI")
    with refused_for("uncertainty.profile.radius", "'SI'", '"1 %"'):
        scene.vary(uncertainty={"profile": {"radius": "1 mm"}})
    assert (
        scene.vary(uncertainty={"profile": {"radius": "1 %"}}).inputs[0].standard_uncertainty
        == 0.01
    )


# ------------------------------------------------------------------------------------ moved inputs
BOTH = {"normal_load": 0.1, "tangential_load": -0.2}


@pytest.mark.parametrize("name", ["blocks", "cattaneo-mindlin", "harmonics", "time-series"])
def test_moved_loads_are_scaled_all_along_the_path(name: str) -> None:
    """The path of the moved scene is the path with both loads scaled, at instants of its own."""
    scene = load_scene(name)
    path = scene.load.path()
    legs = (*path.initial_loading, *path.cycle)
    time = np.linspace(legs[0].start, legs[-1].end, 41)
    normal, tangential = path.at(time)
    moved_normal, moved_tangential = scene.moved(BOTH).load.path().at(time)
    assert moved_normal == pytest.approx(1.1 * normal, rel=1e-12, abs=1e-12)
    assert moved_tangential == pytest.approx(0.8 * tangential, rel=1e-12, abs=1e-12)


def test_a_moved_phase_delays_every_harmonic_alike() -> None:
    scene = load_scene("harmonics")
    before = scene.load.path()
    after = scene.moved({"phase_degrees": 6.0}).load.path()
    time = np.linspace(0.5, 6.0, 13)
    delay = math.radians(6.0)
    assert after.at(time + delay)[1] == pytest.approx(before.at(time)[1], abs=1e-9)
    turned = load_scene("hertz-paper").vary(load={"phase_degrees": 179.0})
    assert turned.moved({"phase_degrees": 3.0}).load.phase_degrees == -178.0


def test_a_reduced_record_keeps_the_rows_that_it_goes_through() -> None:
    """Were the threshold asked again of scaled rows, others would be left out."""
    rows = [[0, 2, 0], [1, 2, 0.11], [2, 2, 0.005], [3, 2, 1], [4, 2, -1]]
    load = TimeSeriesLoad(rows=rows, reduce="turning_points", threshold={"Q": 0.1})
    scene = load_scene("cattaneo-mindlin").vary(load=load, expected=())
    moved = scene.moved({"tangential_load": -0.2})
    assert isinstance(moved.load, TimeSeriesLoad)
    assert moved.load.kept_rows() == pytest.approx(load.kept_rows() * [1, 1, 0.8])


def test_a_moved_cylinder_moves_the_profile_with_it() -> None:
    scene = load_scene("two-cylinders")
    moved = scene.moved({"bodies.lower.radius": 0.1})
    radii = [body.radius for body in (moved.bodies.lower, moved.bodies.upper)]
    assert isinstance(moved.bodies, Bodies)
    assert isinstance(moved.bodies.lower, Cylinder)
    assert 1 / moved.profile.radius == pytest.approx(sum(1 / radius for radius in radii))
    assert moved.material == scene.material


def test_displacements_are_moved_in_the_place_of_loads() -> None:
    scene = load_scene("rig-blocks").vary(uncertainty={"tangential_displacement": "1 %"})
    before = scene.load.path_of_actuators()
    after = scene.moved({"tangential_displacement": 0.1, "friction": 0.05})
    time = before.cycle[0].end
    assert after.load.path_of_actuators().at(time)[1] == pytest.approx(1.1 * before.at(time)[1])
    assert after.friction.coefficient == pytest.approx(1.05 * scene.friction.coefficient)
    assert after.uncertainty is None


WAVES = {
    "ellipse": EllipseLoad(
        approach=DrivenApproach(mean=0.01, amplitude=0.002),
        tangential_displacement=DrivenWave(amplitude=0.001),
    ),
    "harmonics": HarmonicLoad(
        approach=DrivenWaveSum(mean=0.01, harmonics=((0.002, 0.0),)),
        tangential_displacement=DrivenWaveSum(harmonics=((0.001, 90.0),)),
    ),
}


@pytest.mark.parametrize("load", WAVES.values(), ids=WAVES)
def test_a_moved_approach_is_scaled_in_the_place_of_p(load: EllipseLoad | HarmonicLoad) -> None:
    scene = load_scene("rig-blocks").vary(load=load, uncertainty={"approach": "2 %"}, expected=())
    before = scene.load.path_of_actuators()
    after = scene.moved({"approach": 0.1}).load.path_of_actuators()
    time = before.cycle_start + 1.0
    assert after.at(time)[0] == pytest.approx(1.1 * before.at(time)[0])
    assert after.at(time)[1] == pytest.approx(before.at(time)[1])


def test_uncertainties_are_left_out_where_the_scene_has_the_inputs_no_more() -> None:
    scene = load_scene("blocks").vary(uncertainty={"friction": "5 %", "phase_degrees": 3.0})
    polygon = PolygonLoad(initial_loading=((90.0, 0.0),))
    assert scene.vary(load=polygon).uncertainty is None
    assert scene.vary(friction=0.98).uncertainty == scene.uncertainty
    with refused_for("uncertainty.phase_degrees", "polygon"):
        scene.vary(load=polygon, uncertainty=scene.uncertainty)


def test_an_impossible_move_is_refused() -> None:
    with pytest.raises(InputError, match="mean_normal_load"):
        load_scene("blocks").moved({"normal_load": -1.5})
    assert isinstance(load_scene("cattaneo-mindlin").moved({"friction": 0.0}).load, PolygonLoad)


def test_check_states_what_was_read(tmp_path: Path) -> None:
    written(tmp_path, STATED)
    words = ("check", "scene.toml", "--json")
    _, answer = answer_of(halfplane(tmp_path, *words), *words)
    rows = {row["key"]: row for row in answer["uncertainty_of_inputs"]}
    assert rows["friction"]["standard_uncertainty"] == 0.05
    assert rows["phase_degrees"]["of"] == "degrees"
    assert any("friction 1 ± 5 %" in note and "0.5" in note for note in answer["notes"])
