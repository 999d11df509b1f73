"""What finite bodies make of half-plane theory, without a contact solved: against finite elements,
and what is said where the numbers of the bodies say nothing.
"""

import math
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import halfplane_fe
import semi_analytic
from command_line import answer_of, halfplane
from meshes import MeshSettings
from reports import advising, advising_by_kernels
from reports.advising import NoAdvice, advise
from reports.advising_by_kernels import KernelAdvice, advise_by_kernels, changes_of
from reports.advising_by_numbers import (
    WORK,
    Advice,
    advice_in_words,
    advise_by_numbers,
    split_difference_of_work,
)
from reports.cli.application import Options
from reports.comparison.laws import Verdict
from reports.studies.maps import commands
from scenes import (
    BodyEffects,
    ContactSolution,
    EllipseLoad,
    Estimate,
    InputError,
    Scene,
    load_scene,
)
from semi_analytic.profiles import contact_of

# Finite elements of the scene `blocks` over half-plane theory, minus 1: `halfplane run blocks`.
PARTS_OF_BLOCKS = ["curvature under P", "curvature under Q"]
OF_BLOCKS = {"dissipation": -0.02732, "peak_pressure": 0.0051015, "half_width": -0.005178}
# The elements place the edge with this uncertainty, 2.5e-4 mm.
OF_EDGE = 2.1e-4


def one_block() -> Scene:
    """The block of `blocks` on a half-plane."""
    return load_scene("blocks").vary(bodies={"upper": {"kind": "half_plane"}}, expected=[])


def test_two_blocks_change_theory_as_finite_elements_do_and_the_parts_add_up() -> None:
    advice = advise_by_numbers(load_scene("blocks"))
    for quantity, of_finite_elements in OF_BLOCKS.items():
        change = advice.changes[quantity].relative_change
        uncertainty = change.uncertainty + (OF_EDGE if quantity == "half_width" else 0.0)
        assert abs(change.value - of_finite_elements) <= uncertainty, quantity
        assert change.uncertainty < 0.1 * abs(change.value), quantity
    total = sum(part.value for part in advice.parts.values())
    assert total == pytest.approx(advice.work.value, rel=1e-12)
    assert list(advice.parts) == [*PARTS_OF_BLOCKS, "both together"]
    assert advice.parts["curvature under P"].value == pytest.approx(-0.0077, abs=2e-4)
    assert advice.parts["curvature under Q"].value == pytest.approx(-0.0200, abs=2e-4)
    assert advice.neglected_part == 0
    assert advice.verdict is Verdict.WITHIN
    assert "−2.73 ± 0.01 %" in advice_in_words(advice)
    first_line, other_changes = repr(advice).splitlines()
    assert first_line == advice_in_words(advice)
    assert "largest pressure +0.5" in other_changes
    assert len(repr(advice.effects).splitlines()) == 6


@cache
def effects_of_blocks() -> BodyEffects:
    return halfplane_fe.body_effects(load_scene("blocks"))


def run_of(scene: Scene, error: float, uncertainty: float) -> Any:
    """Stands for finite elements of a scene beside theory that differ so much in W."""
    work = SimpleNamespace(value=error, uncertainty=uncertainty, absolute=False)
    effects = effects_of_blocks() if scene.name == "blocks" else None
    return SimpleNamespace(scene=scene, effects=effects, metric=lambda key: {WORK: work}[key])


def test_a_difference_is_split_by_what_makes_it_and_its_main_cause_named() -> None:
    error = OF_BLOCKS[WORK]
    why = split_difference_of_work(run_of(load_scene("blocks"), error, 5e-5), None)
    *parts, left, numerical = why.all_parts
    assert [step.cause for step in parts] == [*PARTS_OF_BLOCKS, "both together"]
    assert sum(step.change.value for step in why.all_parts) == pytest.approx(error, rel=1e-12)
    assert (numerical.cause, numerical.change.value) == ("mesh and steps", 0.0)
    assert left.change == why.unexplained_part
    assert why.is_explained
    assert why.main_cause == "curvature under Q"
    assert "curvature under Q −2.00 ±" in why.sentence
    assert why.cause_in_percent == "−2.00 %"


@pytest.mark.parametrize(
    ("error", "uncertainty"),
    [
        pytest.param(-0.05, 5e-5, id="something else makes half of it"),
        pytest.param(-0.02732, 0.02, id="not resolved"),
        pytest.param(0.02732, 5e-5, id="the other way"),
        pytest.param(-0.02732, math.nan, id="uncertainty unknown"),
    ],
)
def test_no_main_cause_is_named_where_the_parts_do_not_explain_the_difference(
    error: float, uncertainty: float
) -> None:
    why = split_difference_of_work(run_of(load_scene("blocks"), error, uncertainty), None)
    assert why.main_cause == ""
    assert len(why.all_parts) == 5


def test_what_the_numbers_do_not_cover_is_not_split_and_says_why() -> None:
    profile = {"kind": "polynomial", "length": 1.0, "rises": [5e-3, 1e-4]}
    pad = load_scene("pad-on-block").vary(profile=profile, expected=[])
    run = run_of(pad, -0.1, 1e-3)
    run.result = SimpleNamespace(settings={"mesh": asdict(MeshSettings())})
    why = split_difference_of_work(run, None)
    assert why.all_parts == []
    assert "the face of this pad is none" in why.sentence
    assert why.content()["main_cause"] is None


def test_reasons_do_not_name_an_argument_of_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wedge of |x|^1.3 on a layer as thick as its contact is wide."""
    profile = {"kind": "power_law", "exponent": 1.3, "length": 1.0, "rise": 1e-3}
    layer = {"kind": "block", "width": 20.0, "height": 1.0}
    scene = load_scene("hertz-paper").vary(
        profile=profile, bodies={"lower": layer, "upper": {"kind": "half_plane"}}, expected=[]
    )
    reasons: list[str] = []

    def keep_reason(_scene: Scene, _limit: float, reason: str) -> None:
        reasons.append(reason)

    monkeypatch.setattr(advising, "advise_by_kernels", keep_reason)
    advise(scene)
    run = run_of(scene, -0.1, 1e-3)
    run.result = SimpleNamespace(settings={"mesh": asdict(MeshSettings())})
    reasons.append(split_difference_of_work(run, None).reason_not_split)
    assert all(reason.startswith("the normal curvature is negative") for reason in reasons)
    assert len(reasons) == 2


def unlike_blocks() -> Scene:
    """Of the library's, the upper one of aluminium: Dundurs' beta is 0.12."""
    steel = {"young_modulus": 210e3, "poisson_ratio": 0.3}
    aluminium = {"young_modulus": 70e3, "poisson_ratio": 0.33}
    return load_scene("blocks").vary(material={"lower": steel, "upper": aluminium})


def leaning_block() -> Scene:
    """Eight half-widths wide and ten high: tilt and bulk strain make 12 % of W."""
    bodies = {
        "lower": {"kind": "half_plane"},
        "upper": {"kind": "block", "width": 8.0, "height": 10.0},
    }
    mean_load = 90.62286500739786  # half-width 1 mm
    load = EllipseLoad(
        mean_normal_load=mean_load,
        normal_amplitude=mean_load / 3,
        tangential_amplitude=0.4 * mean_load,
        phase_degrees=40.0,
        initial_loading="straight",
    )
    return load_scene("hertz-paper").vary(bodies=bodies, load=load, friction=0.8)


def test_coupling_of_unlike_bodies_and_what_kernels_find_are_parts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Finite elements stand for 0.95 of theory's W between half-planes, 0.90 between kernels."""
    scene = unlike_blocks()
    work = semi_analytic.solve(scene, fields=WORK).dissipation

    def solve(
        asked_for: Scene, mesh: MeshSettings, settings: Any, bodies: str = "meshed"
    ) -> SimpleNamespace:
        assert mesh.edge_element_size == 2 * MeshSettings().edge_element_size
        assert asked_for.bodies.half_planes == (bodies == "meshed")
        share = 0.95 if bodies == "meshed" else 0.90
        return SimpleNamespace(dissipation=share * work, dissipation_uncertainty=1e-3 * work)

    monkeypatch.setattr(halfplane_fe, "solve", solve)
    run = run_of(scene, -0.103, 5e-4)
    run.result = SimpleNamespace(settings={"mesh": asdict(MeshSettings())})
    why = split_difference_of_work(run, None)
    assert list(why.parts) == ["coupling", "finite bodies"]
    assert why.parts["coupling"] == pytest.approx((-0.05, 1e-3))
    assert why.parts["finite bodies"] == pytest.approx((-0.05, 2e-3))
    assert why.unexplained_part == pytest.approx((-0.003, 3.5e-3))


def test_of_arcs_what_kernels_find_is_one_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels stand for 0.94 of theory's W."""
    scene = load_scene("pad-on-block")
    work = semi_analytic.solve(scene, fields=WORK).dissipation

    def solve(asked_for: Scene, *_: Any, bodies: str) -> SimpleNamespace:
        assert (asked_for, bodies) == (scene, "kernel")
        return SimpleNamespace(dissipation=0.94 * work, dissipation_uncertainty=1e-3 * work)

    monkeypatch.setattr(halfplane_fe, "solve", solve)
    run = run_of(scene, -0.0598, 5e-4)
    run.result = SimpleNamespace(settings={"mesh": asdict(MeshSettings())})
    why = split_difference_of_work(run, None)
    assert why.parts == {"finite bodies": pytest.approx((-0.06, 1e-3))}
    assert why.unexplained_part == pytest.approx((2e-4, 1.5e-3))


def test_parts_whose_errors_have_no_estimate_are_not_shown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As on a mesh of a few nodes: their sizes, and even their signs, say nothing."""
    scene = load_scene("pad-on-block")

    def solve(*_: Any, **__: Any) -> SimpleNamespace:
        return SimpleNamespace(dissipation=1.0, dissipation_uncertainty=math.nan)

    monkeypatch.setattr(halfplane_fe, "solve", solve)
    run = run_of(scene, -0.06, 5e-3)
    run.result = SimpleNamespace(settings={"mesh": asdict(MeshSettings())})
    why = split_difference_of_work(run, None)
    assert why.all_parts == []
    assert "finite bodies has no estimate; a finer mesh splits it" in why.sentence


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "cause"),
    [(unlike_blocks(), "finite bodies"), (leaning_block(), "tilt and bulk strain")],
    ids=["unlike", "declined"],
)
def test_what_kernels_find_explains_finite_elements(scene: Scene, cause: str) -> None:
    """Also where the numbers of the bodies give no more than a size: the rest is in higher
    orders.
    """
    elements = halfplane_fe.solve(scene)
    work = semi_analytic.solve(scene, fields=WORK).dissipation
    run = run_of(scene, elements.dissipation / work - 1, elements.dissipation_uncertainty / work)
    run.result = elements
    why = split_difference_of_work(run, None)
    assert why.main_cause == cause
    assert abs(why.unexplained_part.value) < 1e-3
    assert why.is_explained


def test_of_unlike_bodies_a_size_is_stated_and_the_kernel_solve_is_named() -> None:
    advice = advise_by_numbers(unlike_blocks())
    assert advice.reason_for_size_alone.startswith("the materials are unlike")
    assert advice.work.value == pytest.approx(-0.0534, abs=1e-4)  # by the curvatures alone
    assert 0.02 < advice.work.uncertainty < 0.1
    assert advice.verdict is Verdict.UNDECIDED
    assert math.isnan(advice.changes["peak_pressure"].relative_change.value)
    assert 'solve(scene, bodies="kernel")' in advice_in_words(advice)
    assert "coupling of pressure and shear" in advice_in_words(advice)
    # however wide the limit is, a size is never enough to use theory
    assert advise_by_numbers(unlike_blocks(), limit=0.9).verdict is Verdict.UNDECIDED


@pytest.mark.slow
def test_the_kernel_solve_of_unlike_bodies_is_within_the_size_that_is_stated() -> None:
    scene = unlike_blocks()
    work = halfplane_fe.solve(scene, bodies="kernel").dissipation
    advice = advise_by_numbers(scene)
    left = work / advice.changes[WORK].theory_value - 1 - advice.work.value
    assert 0.1 * advice.work.uncertainty < abs(left) < advice.work.uncertainty


def test_where_nothing_is_dissipated_no_error_is_stated() -> None:
    scene = load_scene("blocks").vary(expected=[], load={"tangential_amplitude": 0.0})
    with pytest.raises(InputError, match="dissipates nothing"):
        advise_by_numbers(scene)


def test_bulk_strain_and_tilt_of_one_block_are_a_part_of_the_change() -> None:
    advice = advise_by_numbers(one_block())
    part = advice.parts["tilt and bulk strain"]
    # In closed form to second order: 0.0819 (a/h)^2.
    assert part.value == pytest.approx(8.19e-4, abs=part.uncertainty)
    assert part.uncertainty < 4e-4
    assert advice.neglected_part == 0
    total = sum(of_cause.value for of_cause in advice.parts.values())
    assert advice.work.value == pytest.approx(total, rel=1e-12)
    assert advice.changes["dissipation"].relative_change == advice.work
    stick = advice.changes["permanent_stick"].relative_change
    assert 0 < stick.uncertainty < 0.02
    assert stick.value < 0  # the stick zone moves within a cycle
    assert "tilt and bulk strain +0.08" in advice_in_words(advice)


@pytest.mark.slow
def test_a_t_shape_tilts_and_strains_and_is_told_as_finite_elements_have_it() -> None:
    t_shape = {
        "kind": "t_shape",
        "width": 20.0,
        "flange_height": 6.0,
        "stem_width": 12.0,
        "height": 18.0,
    }
    bodies = {"lower": t_shape, "upper": {"kind": "half_plane"}}
    advice = advise_by_numbers(load_scene("blocks").vary(bodies=bodies, expected=[]))
    # `halfplane run`, growth of the mesh 0.1
    assert abs(advice.work.value + 0.09258) < advice.work.uncertainty < 0.007
    assert abs(advice.parts["tilt and bulk strain"].value) > 0.05


def test_where_grids_take_no_profile_tilt_and_bulk_strain_are_left_out_and_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(*_: Any) -> None:
        raise InputError("no such profile")

    monkeypatch.setattr(semi_analytic, "change_by_tilt_and_strain", refused)
    advice = advise_by_numbers(one_block())
    assert advice.work.uncertainty >= advice.neglected_part > 0
    assert "tilt and bulk strain" not in advice.parts
    assert "tilt and bulk strain are left out" in advice_in_words(advice)


def answer(folder: Path, *words: str) -> tuple[int, dict[str, Any]]:
    return answer_of(halfplane(folder, *words, "--json"), *words)


def test_the_command_ends_with_1_above_the_limit_and_names_the_way_out(
    tmp_path: Path,
) -> None:
    code, advice = answer(tmp_path, "advise", "blocks", "--limit", "1%")
    assert (code, advice["by"], advice["verdict"]) == (1, "corrected theory", "outside")
    assert "--corrected" in advice["sentence"]
    assert advice["effects"]["normal_curvature"][0] > 0


# Finite elements of the scene over half-plane theory, minus 1: `halfplane run`.
BY_KERNELS = {"pad-on-block": ("curved", -0.0598), "unlike-beta-fifth": ("unlike", -0.0614)}


@pytest.mark.parametrize("name", BY_KERNELS)
def test_what_the_numbers_do_not_cover_is_said_and_solved_by_kernels(
    name: str, tmp_path: Path
) -> None:
    words, of_finite_elements = BY_KERNELS[name]
    code, advice = answer(tmp_path, "advise", name)
    assert (code, advice["by"], advice["verdict"]) == (1, "kernel solve", "outside")
    assert words in advice["declined"]
    assert words in advice["sentence"]
    change = advice["changes"]["dissipation"]
    assert abs(change["change"] - of_finite_elements) <= change["uncertainty"] < 1e-3
    assert ("edge_tension" in advice["changes"]) is (name == "unlike-beta-fifth")


def test_advice_from_python_is_that_of_the_command() -> None:
    """By kernels where the numbers decline; where neither takes the scene it is not known."""
    by_kernels = advise("unlike-beta-fifth")
    assert isinstance(by_kernels, KernelAdvice)
    assert repr(by_kernels).startswith("Half-plane theory is expected to err by −6.1")
    assert isinstance(advise("blocks"), Advice)
    with pytest.raises(NoAdvice, match="Not known: neither the numbers of the bodies"):
        advise(without_kernels())


def without_kernels() -> Scene:
    """A pad of which neither the numbers nor the kernels are known."""
    profile = {"kind": "polynomial", "length": 1.0, "rises": [5e-3, 1e-4]}
    return load_scene("pad-on-block").vary(profile=profile, expected=[])


def test_where_the_numbers_give_a_size_alone_kernels_give_the_change(tmp_path: Path) -> None:
    leaning_block().save(tmp_path / "leaning.toml")
    code, advice = answer(tmp_path, "advise", "leaning.toml", "--limit", "90%")
    assert (code, advice["by"], advice["verdict"]) == (0, "kernel solve", "within")
    assert advice["declined"].startswith("tilt and bulk strain make more than 5 %")
    assert advice["changes"]["dissipation"]["uncertainty"] < 2e-3


def test_where_kernels_fail_the_size_stays_and_the_reason_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: Any) -> None:
        raise InputError("no kernels today")

    monkeypatch.setattr(advising, "advise_by_kernels", fails)
    leaning_block().save(tmp_path / "leaning.toml")
    advised = commands.advise(str(tmp_path / "leaning.toml"), Options(limit="90%"))
    assert advised.content is not None
    content = advised.content()
    assert (advised.code, content["by"], content["verdict"]) == (
        1,
        "corrected theory",
        Verdict.UNDECIDED,
    )
    assert content["declined"].endswith("; no kernels today")
    assert "The kernel solve does not take this scene: no kernels today" in list(advised.parts)


def test_what_neither_covers_is_not_known_and_said(tmp_path: Path) -> None:
    without_kernels().save(tmp_path / "quartic.toml")
    code, advice = answer(tmp_path, "advise", "quartic.toml")
    assert (code, advice["by"], advice["verdict"]) == (1, None, None)
    assert advice["sentence"].startswith("Not known: neither the numbers of the bodies")
    assert "the face of this pad is none" in advice["sentence"]


def coarse_kernels(scene: Scene) -> ContactSolution:
    return halfplane_fe.solve(scene, MeshSettings.coarse(), bodies="kernel")


def test_changes_of_a_solution_are_over_the_values_of_theory() -> None:
    """Largest values, not those at points; of a half-plane pair theory is met."""
    solution = coarse_kernels(load_scene("hertz-paper"))
    changes = changes_of(solution)
    assert list(changes) == [
        "dissipation",
        "peak_pressure",
        "half_width",
        "permanent_stick",
        "edge_tension",
    ]
    for quantity, (_, theory, change) in changes.items():
        assert abs(change.value) <= change.uncertainty + 2e-4, quantity
        assert theory > 0
    without_shear = load_scene("blocks").vary(expected=[], load={"tangential_amplitude": 0.0})
    with pytest.raises(InputError, match="theory dissipates nothing"):
        advise_by_kernels(without_shear, 0.05, "")


def test_what_kernels_leave_of_the_pressure_of_a_flat_pad_is_counted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    of_solution = changes_of(coarse_kernels(load_scene("pad-on-block")))
    before = of_solution["peak_pressure"].relative_change
    monkeypatch.setattr(halfplane_fe, "solve", lambda *_, **__: None)
    monkeypatch.setattr(advising_by_kernels, "changes_of", lambda *_: dict(of_solution))
    round_pad = load_scene("pad-on-block")
    profile = {"kind": "flat_rounded", "radius": 80.0, "flat_half_length": 0.5}
    flat_pad = round_pad.vary(profile=profile, expected=[])
    for scene, left in ((round_pad, 3e-4), (flat_pad, 1e-3)):
        after = advise_by_kernels(scene, 0.05, "").changes["peak_pressure"].relative_change
        assert after.value == before.value
        added = after.uncertainty - before.uncertainty
        assert added == pytest.approx(left * (1 + before.value), rel=1e-9)


# Two round faces and a flat one, none of the scenes that anything was fixed on.
UNSEEN: dict[str, dict[str, Any]] = {
    "cylinder on a low block": {
        "profile": {"radius": 12.0},
        "bodies": {
            "lower": {"kind": "block", "width": 30.0, "height": 6.0},
            "upper": {"kind": "cylinder", "radius": 12.0},
        },
    },
    "pad on an unlike half-plane": {
        "profile": {"radius": 15.0},
        "material": {"lower": {"young_modulus": 70e3, "poisson_ratio": 0.33}},
        "bodies": {"upper": {"kind": "pad", "width": 18.0, "height": 9.0}},
    },
    "flat pad": {
        "profile": {"kind": "flat_rounded", "radius": 9.0, "flat_half_length": 0.6},
        "bodies": {"upper": {"kind": "pad", "width": 12.0, "height": 8.0}},
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("name", UNSEEN)
def test_finite_elements_are_within_what_advice_by_kernels_states(name: str) -> None:
    scene = load_scene("hertz-paper").vary(expected=[], friction=0.5, **UNSEEN[name])
    mean_load = float(contact_of(scene.profile, scene.material).load(1.0))
    load = EllipseLoad(
        mean_normal_load=mean_load,
        normal_amplitude=0.2 * mean_load,
        tangential_amplitude=0.2 * mean_load,
        phase_degrees=60.0,
        initial_loading="straight",
    )
    scene = scene.vary(load=load)
    finer = MeshSettings(element_size=1 / 32, edge_element_size=1 / 160, growth=0.1)
    by_elements = changes_of(halfplane_fe.solve(scene, finer))
    by_kernels = advise_by_kernels(scene, 0.05, "").changes
    for quantity, (_, _, change) in by_kernels.items():
        truth = by_elements[quantity].relative_change
        assert abs(truth.value - change.value) <= change.uncertainty, quantity
    assert abs(by_kernels["dissipation"].relative_change.value) > 1e-3


def test_corrected_theory_is_solved_from_the_command_line_and_judged_by_its_own_laws(
    tmp_path: Path,
) -> None:
    code, corrected = answer(tmp_path, "exact", "blocks", "--corrected")
    assert (code, corrected["expected"], corrected["admissible"]) == (0, [], True)
    code_of_theory, theory = answer(tmp_path, "exact", "blocks")
    assert code_of_theory == 0
    change = corrected["dissipation"] / theory["dissipation"] - 1
    assert change == pytest.approx(-0.02733, abs=1e-4)


def test_where_tilt_makes_much_of_the_change_its_size_alone_is_given() -> None:
    effects = replace(effects_of_blocks(), tilt_under_shear=Estimate(8e-6))
    advice = advise_by_numbers(load_scene("blocks"), effects=effects)
    assert abs(advice.parts["tilt and bulk strain"].value) > 0.05
    assert advice.reason_for_size_alone.startswith("tilt and bulk strain make more than 5 %")
    assert advice.verdict is not Verdict.WITHIN
    assert "no more than its size" in advice_in_words(advice)
    assert not advise_by_numbers(
        load_scene("blocks"), effects=effects_of_blocks()
    ).reason_for_size_alone
