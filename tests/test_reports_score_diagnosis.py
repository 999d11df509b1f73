"""Each diagnosis on a result that has just that fault, two faults at once, right results, and results that lack half of it all."""

from __future__ import annotations

import importlib
import re
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import semi_analytic
from meshes import MeshSettings
from reports import compare
from reports.comparison import Comparison
from reports.scoring.diagnosis import UNKNOWN, Diagnosis, diagnose
from reports.scoring.diagnosis_discrepancy import discrepancy
from reports.scoring.diagnosis_model import Flaws, Grid, NotSettledError, grid, march
from reports.scoring.diagnosis_theory import stiffer, with_friction
from reports.scoring.diagnosis_words import FAULTS
from scenes import Materials, load_scene
from semi_analytic.elasticity import coupling_constant

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
SCENES = ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper")
FILE = ("shear_sign", "pressure_sign", "swapped", "frictionless", "units", "traction_factor", "pressure_factor")
ALTERED = (*FILE, "offset", "not_steady", "other_times")
ASKED = ("stiffness", "half_model", "loads", "friction", "full_stick")
MODELLED = ("memoryless", "steps", "elastic_slip", "soft_normal", "small_body", "coupling", "coarse_edge")


@pytest.fixture(scope="module")
def table() -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCHMARKS))
        yield importlib.import_module("diagnosis")


def planted(table: ModuleType, key: str, scene: str, severity: float | None = None) -> Comparison:
    (fault,) = (fault for fault in table.FAULTS if fault.key == key)
    return fault.plant(load_scene(scene), fault.severities[0] if severity is None else severity)


def keys(found: tuple[Diagnosis, ...]) -> list[str]:
    return [one.fault for one in found]


def slow(*values: object) -> object:
    return pytest.param(*values, marks=pytest.mark.slow)


def test_every_fault_of_the_set_has_words_and_is_planted(table: ModuleType) -> None:
    assert {fault.key for fault in table.FAULTS} == set(FAULTS) == {*ALTERED, *ASKED, *MODELLED}


@pytest.mark.parametrize("key", [*ALTERED, *ASKED])
@pytest.mark.parametrize("scene", ["cattaneo-mindlin", slow("hertz-paper"), slow("flat-rounded-paper")])
def test_a_fault_of_file_or_question_is_named_first(table: ModuleType, key: str, scene: str) -> None:
    first = diagnose(planted(table, key, scene))[0]
    assert first.fault == key
    assert first.strength > 0.97  # 0.99 or more was measured everywhere but for the shear of bonded faces on the flat one
    assert first.evidence
    assert "{" not in first.sentence


@pytest.mark.parametrize("key", ["shear_sign", "friction"])
def test_and_on_the_papers_cycle(table: ModuleType, key: str) -> None:
    assert keys(diagnose(planted(table, key, "hertz-paper")))[0] == key


@pytest.mark.slow
@pytest.mark.parametrize("key", MODELLED)
@pytest.mark.parametrize("scene", SCENES)
def test_a_fault_of_the_model_is_named_first(table: ModuleType, key: str, scene: str) -> None:
    """Finite elements with the fault in them, not arrays made up."""
    assert keys(diagnose(planted(table, key, scene)))[0] == key


@pytest.mark.parametrize("key", ["elastic_slip", "steps"])
def test_and_on_cattaneo_and_mindlin_at_once(table: ModuleType, key: str) -> None:
    assert keys(diagnose(planted(table, key, "cattaneo-mindlin")))[0] == key


@pytest.mark.parametrize(("key", "severity"), [("steps", 48.0), ("elastic_slip", 240.0), ("coarse_edge", 1 / 12)])
def test_a_mild_fault_of_the_model_is_named_where_it_is_alone(table: ModuleType, key: str, severity: float) -> None:
    """Steps and thin layers whose traces lie within one coarse element of the model; errors of a mesh that stay locked in."""
    assert keys(diagnose(planted(table, key, "hertz-paper", severity)))[0] == key


def test_flaws_of_the_model_are_not_looked_for_where_theory_explains_all(
    table: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []
    monkeypatch.setattr("reports.scoring.diagnosis.flaw_faults", lambda *given: asked.append(given) or ())
    assert keys(diagnose(planted(table, "friction", "cattaneo-mindlin"))) == ["friction"]
    assert not asked
    diagnose(planted(table, "steps", "cattaneo-mindlin"))
    assert asked


def test_a_fault_whose_model_does_not_settle_is_told(table: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    def march(*_given: object, **_options: object) -> None:
        raise NotSettledError

    wrong = planted(table, "elastic_slip", "cattaneo-mindlin")
    assert "not all was tried" not in " ".join(diagnose(wrong)[0].evidence)
    monkeypatch.setattr("reports.scoring.diagnosis_flaws.march", march)
    assert diagnose(wrong)[0].evidence[-1] == (
        "not all was tried: a model with this fault does not settle (coupling, elastic slip, small body, soft normal, steps)"
    )


@pytest.mark.parametrize(
    ("key", "severity", "name"),
    [
        ("stiffness", 0.91, "plane stress"),
        ("friction", 1.1, "friction is"),
        ("loads", 1.3, "Loads"),
        ("units", 1e6, "units"),
        ("pressure_factor", 1.01, "pressure alone"),
        ("offset", 0.03, "off along x"),
        ("other_times", 0.05, "late"),
    ],
)
def test_the_figure_planted_is_the_figure_found(table: ModuleType, key: str, severity: float, name: str) -> None:
    first = diagnose(planted(table, key, "cattaneo-mindlin", severity))[0]
    assert first.fault == key
    assert name in first.sentence
    figure = float(re.findall(r"-?[0-9][0-9.]*(?:e[+-]?[0-9]+)?", first.sentence)[0])
    assert figure == pytest.approx(severity, rel=5e-3)


@pytest.mark.parametrize("scene", SCENES)
def test_a_right_result_suffers_from_nothing(table: ModuleType, scene: str) -> None:
    true = table.truth(scene)
    assert diagnose(compare(true, true)) == ()


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_nor_do_finite_elements_on_their_default_mesh(table: ModuleType, scene: str) -> None:
    assert diagnose(table.solved(load_scene(scene), MeshSettings())) == ()


@pytest.mark.parametrize(
    ("scene", "first", "second"),
    [
        ("cattaneo-mindlin", "shear_sign", "stiffness"),
        ("cattaneo-mindlin", "stiffness", "friction"),
        slow("cattaneo-mindlin", "units", "friction"),
        slow("hertz-paper", "shear_sign", "friction"),
        slow("hertz-paper", "swapped", "offset"),
        slow("flat-rounded-paper", "units", "stiffness"),
    ],
)
def test_of_two_faults_at_once_both_are_among_the_first_three(table: ModuleType, scene: str, first: str, second: str) -> None:
    true, result = table.truth(scene), load_scene(scene)
    factor = {"stiffness": 0.8, "friction": 1.2}
    asked = result
    for key in {first, second} & set(factor):
        change = stiffer if key == "stiffness" else lambda scene, k: with_friction(scene, k * scene.friction.coefficient)
        asked = change(asked, factor[key])
    x = true.x - (0.03 if second == "offset" else 0.0)
    found = replace(semi_analytic.solve(asked, x=x, time=true.time), scene=result, x=true.x)
    if first == "shear_sign":
        found = replace(found, shear=-found.shear)
    if first == "swapped":
        found = replace(found, pressure=found.shear, shear=found.pressure)
    if first == "units":
        found = replace(found, pressure=1e-3 * found.pressure, shear=1e-3 * found.shear)
    named = diagnose(compare(true, found))
    assert {first, second} <= set(keys(named)[:3])
    if first == "units":  # taken away as the round factor that it is, so that the other one is found as large as it was made
        other = next(one for one in named if one.fault == second)
        assert f" {factor[second]:.3g} times " in other.sentence


def test_noise_is_no_known_pattern(table: ModuleType) -> None:
    true = table.truth("cattaneo-mindlin")
    noise = np.random.default_rng(1).normal(scale=0.1 * true.pressure.max(), size=true.pressure.shape)
    (only,) = diagnose(compare(true, replace(true, pressure=true.pressure + noise, shear=true.shear - noise[::-1])))
    assert only.fault == UNKNOWN
    assert only.strength == 0.0
    assert "no known pattern" in only.sentence


def test_a_result_of_tractions_alone_with_holes_is_judged_all_the_same(table: ModuleType) -> None:
    true = table.truth("cattaneo-mindlin")
    nothing = {
        name: np.full_like(getattr(true, name), np.nan)
        for name in ("slip", "contact_edges", "stick_edges", "tangential_displacement")
    }
    shear = -true.shear
    shear[::3, 5:40] = np.nan
    bare = replace(true, shear=shear, dissipation=float("nan"), dissipation_density=np.full_like(true.x, np.nan), **nothing)
    first = diagnose(compare(true, bare))[0]
    assert first.fault == "shear_sign"
    assert any("no numbers" in line for line in first.evidence)
    assert diagnose(compare(true, replace(true, shear=np.full_like(shear, np.nan)))) == ()


def test_two_instants_are_enough_for_a_sign(table: ModuleType) -> None:
    scene, true = load_scene("cattaneo-mindlin"), table.truth("cattaneo-mindlin")
    path = scene.load.path()
    few = semi_analytic.solve(scene, x=true.x, time=path.cycle_start + path.period * np.array([0.0, 0.5, 1.0]))
    assert keys(diagnose(compare(few, replace(few, shear=-few.shear))))[0] == "shear_sign"


def test_a_frictionless_scene_has_no_fault_of_friction(table: ModuleType) -> None:
    scene = load_scene("hertz-normal")
    x = np.linspace(-1.3, 1.3, 81) * float(semi_analytic.solve(scene).contact_half_width.max())
    true = semi_analytic.solve(scene, x=x)
    wide = replace(semi_analytic.solve(stiffer(scene, 0.5), x=true.x, time=true.time), scene=scene)
    found = diagnose(compare(true, wide))
    assert found[0].fault == "stiffness"
    assert not {"friction", "full_stick", "memoryless", "elastic_slip"} & set(keys(found))


def test_the_work_alone_tells_steps_too_long_where_tractions_hide_them(table: ModuleType) -> None:
    scene = load_scene("hertz-paper")
    time = table.times(scene, 16)
    true, polygon = (semi_analytic.solve(scene, x=[0.0], time=time, straight_steps=straight) for straight in (False, True))
    half = 1.3 * float(true.contact_half_width.max())
    x = np.linspace(-half, half, 61)
    true, polygon = (semi_analytic.solve(scene, x=x, time=time, straight_steps=straight) for straight in (False, True))
    (only,) = diagnose(compare(true, replace(polygon, pressure=true.pressure, shear=true.shear), polygon_reference=polygon))
    assert only.fault == "steps"
    assert "16 a cycle" in only.sentence


# ------------------------------------------------------------------------------------------------- what the hypotheses stand on
def test_what_a_hypothesis_explains_is_a_share(table: ModuleType) -> None:
    what = discrepancy(planted(table, "shear_sign", "cattaneo-mindlin"))
    assert what is not None
    assert what.explained(what.expected) == 0.0
    assert what.explained(what.found) == 1.0
    assert what.explained((what.expected[0], 0 * what.expected[1])) == pytest.approx(0.75)  # half of a difference of two
    rest = what.beyond(what.found, None)
    assert rest.apart(rest.expected) == 0.0


def hertz_grid(mirrored: bool, count: int = 120) -> Grid:
    """E* = f = 1 and P = pi/2: h = x^2 gives a = 1, p = 1 at the centre."""
    ends = np.linspace(0, 1.4, count + 1) if mirrored else np.linspace(-1.4, 1.4, 2 * count + 1)
    return grid(ends, lambda x: np.square(x) / 2, 1.0, 1.0)


@pytest.mark.parametrize("mirrored", [True, False])
def test_the_model_without_a_flaw_is_hertz_and_cattaneo(mirrored: bool) -> None:
    """R = 1: P = pi/4 for a = 1, p = sqrt(1 - x^2)/2; c = sqrt(1 - Q/(f P)), q = p(x; a) - p(x; c)."""
    on = hertz_grid(mirrored)
    load = np.pi / 4
    (p,), (q,) = march(on, Flaws(), np.array([[load, 0.64 * load]]))
    exact = np.sqrt(np.maximum(1 - on.x**2, 0)) / 2
    assert np.abs(p - exact).max() < 0.02  # 0.011, at the edge
    assert np.abs(q - (exact - np.sqrt(np.maximum(0.36 - on.x**2, 0)) / 2)).max() < 0.02


def test_the_model_slides_or_says_so() -> None:
    with pytest.raises(NotSettledError, match="slides"):
        march(hertz_grid(True), Flaws(), np.array([[1.0, 1.5]]))


@pytest.mark.parametrize("scene", ["cattaneo-mindlin", slow("hertz-paper"), slow("flat-rounded-paper")])
@pytest.mark.parametrize("poisson_ratio", [0.45, 0.2])
@pytest.mark.slow
def test_dundurs_beta_of_unlike_bodies_is_recovered_with_its_sign(table: ModuleType, scene: str, poisson_ratio: float) -> None:
    comparison = planted(table, "coupling", scene, poisson_ratio)
    first = diagnose(comparison)[0]
    assert first.fault == "coupling"
    material = comparison.scene.material
    beta = coupling_constant(Materials(upper=material.upper, lower=material.lower))
    stated = float(first.sentence.split("along x as ")[1].split(" of Dundurs")[0])
    assert stated == pytest.approx(beta, rel=0.12)
