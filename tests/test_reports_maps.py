"""The maps of the idealisation error: laws, theory, corrections, the published pages, and the
advice read off them.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from math import asin, pi, sqrt
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from meshes import MeshSettings
from reports.studies.maps import Law, fit_law, pages
from reports.studies.maps.advice import FIGURES, Part, between, parts_of, total, work_lines
from reports.studies.maps.corrections import (
    Curvatures,
    corrected_dissipation,
    correction,
    dissipation,
    ellipse_path,
    pad_correction,
    share_of,
    work_constant,
)
from reports.studies.maps.laws import (
    MAPS,
    PUBLISHED,
    STUDIES,
    Line,
    bound,
    errors,
    figures,
    lines,
    read,
)
from reports.studies.sweep import load_study
from scene_cases import scene_of
from scenes import (
    Block,
    Bodies,
    Elastic,
    EllipseLoad,
    FlatRounded,
    InputError,
    Materials,
    Pad,
    PolygonLoad,
    Scene,
    ShoulderedPad,
    TShape,
    load_scene,
)
from scenes.array_types import Array
from semi_analytic.profiles import contact_of

THERE = {table.name: table for table in pages.present(PUBLISHED)}
PAPER = ellipse_path(1 / 3, 1.1 / 3, 1 / 3, np.pi / 2)
NOTHING = Curvatures(0.0, 0.0)


# --------------------------------------------------------------------------------------------- laws
S = np.geomspace(0.02, 0.3, 9)


def fitted(error: Array, uncertainty: Any, expected: float, s: Array = S) -> Law:
    law = fit_law(s, error, uncertainty * np.ones_like(s), expected)
    assert law is not None
    return law


def drawn(seed: int, shared: float = 0.0) -> Array:
    """Errors 3 s^2 (1 - 0.8 s^2), independent errors of 5e-4 and a shared one of `shared` times
    1e-3.
    """
    return 3 * S**2 * (1 - 0.8 * S**2) + 1e-3 * (
        0.5 * np.random.default_rng(seed).standard_normal(len(S)) + shared
    )


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
def test_order_and_constant_are_recovered(order: float) -> None:
    law = fitted(-3 * S**order, 1e-6, order)
    assert (law.sign, law.agrees()) == (-1, True)
    assert [law.order, law.fixed] == pytest.approx([order, 3], abs=1e-3)


def test_intervals_hold_the_truth_and_not_a_wrong_order() -> None:
    """Independent errors of u/2 and a shared one of up to u: the truth is in nearly every
    interval.
    """
    laws = [
        fitted(drawn(seed, np.random.default_rng(1000 + seed).uniform(-0.7, 0.7)), 1e-3, 2.0)
        for seed in range(200)
    ]
    held = [
        sum(law.agrees() for law in laws),
        sum(abs(law.fixed - 3) <= law.fixed_doubt for law in laws),
    ]
    assert min(held) >= 190  # measured: 200 and 199
    assert not any(fitted(drawn(1), 1e-3, wrong).agrees() for wrong in (1.0, 3.0))


def test_which_points_take_part() -> None:
    """Resolved ones, up to the end of the asymptotic range and to the first change of sign; five at
    least.
    """
    assert fitted(3 * S**2, np.where(S < 0.05, 1.0, 1e-5), 2.0).smallest > 0.05
    s = np.geomspace(0.01, 1.0, 12)
    error = 2 * s**2 / (1 + (2 * s) ** 4) ** 0.5
    law = fitted(error, 1e-3 * error, 2.0, s)
    assert law.left_out > 0
    assert law.largest < 0.7
    assert law.order == pytest.approx(2.0, abs=max(law.order_doubt, 0.02))
    turning = 2 * S**2 * (1 - (S / 0.2) ** 4)
    law = fitted(turning, 1e-4 * np.abs(turning), 2.0)
    assert law.largest < 0.2
    assert law.points + law.left_out == np.sum(S < 0.2)
    assert fit_law(S[:4], 3 * S[:4] ** 2, 1e-6 * np.ones(4), 2.0) is None
    assert fit_law(S, 1e-4 * S**2, np.full(9, 1e-3), 2.0) is None


def test_a_bound_counts_the_uncertainty() -> None:
    line, doubtful = (
        Line("error.dissipation", {}, S, 3 * S**2, share * 3 * S**2, None) for share in (0.0, 0.5)
    )
    assert bound(line, 0.03).s == pytest.approx(0.1, rel=1e-6)
    assert bound(doubtful, 0.03).s == pytest.approx(0.1 / np.sqrt(1.5), rel=1e-6)
    assert bound(line, 1.0).how == "all"
    assert bound(line, 1e-6).s is None


# ------------------------------------------------------------------------------------------- theory
def test_without_bodies_it_is_half_plane_theory() -> None:
    """Measured 2e-4: chords of the loop, cells of the memory."""
    scene = scene_of("phase-45")
    load = scene.load
    material = scene.material
    assert isinstance(load, EllipseLoad)
    p0 = load.mean_normal_load
    amplitudes = (
        load.normal_amplitude / p0,
        load.mean_tangential_load / p0,
        load.tangential_amplitude / p0,
    )
    p, q, cycle = ellipse_path(*amplitudes, load.phase_radians)
    compliance = sum(
        (1 - m.poisson_ratio**2) / m.young_modulus for m in (material.lower, material.upper)
    )
    exact = (
        semi_analytic.solve(scene, fields=("dissipation",)).dissipation
        * np.pi
        / (2 * compliance * p0**2)
    )
    assert dissipation(p, q, scene.friction.coefficient, NOTHING, cycle) == pytest.approx(
        exact, rel=1e-3
    )


@pytest.mark.parametrize(
    ("flat", "ratio", "value"),
    [(0.2, 0.6, -0.2085), (0.5, 0.6, -0.4603), (0.7, 0.6, -0.5593), (0.9, 0.3, -0.5653)],
)
def test_constant_of_a_contour_is_that_of_elements(flat: float, ratio: float, value: float) -> None:
    """Shear constant on elements, by slip instead of energies, reached these at order 2; with 80 of
    them 0.1 % is left.
    """
    assert work_constant(flat, ratio) == pytest.approx(value, abs=5e-5)


def test_the_rule_of_a_contour_has_converged_and_a_cylinder_has_no_first_order() -> None:
    for flat in (0.01, 0.5, 0.99):
        for ratio in (0.05, 0.95):
            # measured 1e-7
            assert work_constant(flat, ratio) == pytest.approx(
                work_constant(flat, ratio, 48), rel=1e-6
            )
    assert abs(work_constant(0.0, 0.6)) < 1e-12
    assert abs(work_constant(1e-3, 0.6)) < 5e-3  # and none comes at once


# -------------------------------------------------------------------------------------- corrections
def blocks(base: str, height: float, aspect: float) -> Scene:
    """The scene `blocks` at another size."""
    block = Block(
        width=height * aspect,
        height=height,
        base=base,
        sides="free" if base == "fixed" else "guided",
    )
    return load_scene("blocks").vary(bodies=Bodies(lower=block, upper=block))


def pad(flat: float, curvature: float, ratio: float = 0.6) -> Scene:
    """A pad of the map: a = 1 by half-plane theory, P constant, Q between +-ratio f P."""
    load = steel_load(flat, curvature)
    steel = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    base = load_scene("two-cylinders")
    upper = Pad(width=2 * flat + 1.4 / curvature, height=1 / curvature)
    changes = {
        "material": Materials(lower=steel, upper=steel),
        "profile": FlatRounded(radius=1 / curvature, flat_half_length=flat),
        "bodies": base.bodies.vary(upper=upper, lower=load_scene("hertz-paper").bodies.lower),
        "friction": 0.5,
        "load": polygon(
            (load, 0.0), (load, 0.5 * ratio * load), cycle=((load, -0.5 * ratio * load),)
        ),
    }
    return base.vary(**changes)


def steel_load(flat: float, curvature: float) -> float:
    """P at which a = 1 by half-plane theory."""
    return 210e3 / 1.82 * curvature * ((pi - 2 * asin(flat)) / 4 - flat * sqrt(1 - flat**2) / 2)


def polygon(*way: tuple[float, float], cycle: tuple[tuple[float, float], ...]) -> PolygonLoad:
    return PolygonLoad(initial_loading=way, cycle=cycle)


SCENE = pad(0.5, 0.05)
LOAD = (steel_load(0.5, 0.05), 0.3 * steel_load(0.5, 0.05))
MOVING = SCENE.vary(load=polygon(LOAD, cycle=((0.9 * LOAD[0], 0.0),)))
TURNING = SCENE.vary(
    load=polygon(LOAD, cycle=tuple((LOAD[0], share * LOAD[1]) for share in (0.0, 0.5, -1.0)))
)
REFUSED = {
    "a half-plane": (load_scene("hertz-paper"), "two equal blocks"),
    "other bodies": (load_scene("pad-on-block"), "two equal blocks"),
    "low blocks": (blocks("fixed", 3.0, 2.0), "height = 2.6 half-widths"),
    "narrow blocks": (blocks("fixed", 8.0, 0.5), "width/height = 0.5"),
    "a large a/R": (pad(0.5, 0.2), "the correction holds up to 0.1"),
    "a small flat": (pad(0.1, 0.05), "b/a of 0.2 to 0.9"),
    "a small pad": (
        SCENE.vary(bodies={"upper": {"width": 3.0, "height": 20.0}}),
        "the pad is too small",
    ),
    "a pad on a block": (
        SCENE.vary(bodies={"lower": Block(width=90.0, height=45.0)}),
        "a pad with a flat face on a half-plane",
    ),
    "unlike materials": (SCENE.vary(material={"lower": {"young_modulus": 1e5}}), "of one material"),
    "P that moves": (MOVING, "constant P"),
    "sliding": (pad(0.5, 0.05, 1.2), "the contact slides"),
    "more turns": (TURNING, "turns twice"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_corrections_refuse_what_they_were_not_tried_on(case: str) -> None:
    scene, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        corrected_dissipation(scene, 1.0)


def test_corrections_multiply_and_are_the_law_for_the_scene() -> None:
    scene = blocks("rollers", 8.0, 2.0)
    assert corrected_dissipation(scene, 2.0) == pytest.approx(
        2 * (1 + correction(scene).dissipation), rel=1e-12
    )
    for ratio in (0.3, 0.8):
        scene = pad(0.5, 0.05, ratio)
        assert pad_correction(scene) == pytest.approx(0.05 * work_constant(0.5, ratio), rel=1e-6)
        assert corrected_dissipation(scene, 2.0) == pytest.approx(
            2 + 2 * pad_correction(scene), rel=1e-12
        )


# ----------------------------------------------------------------------------------- published maps
@pytest.mark.parametrize("name", list(MAPS))
def test_studies_are_studies_and_pages_and_tables_are_current_and_whole(name: str) -> None:
    for study in MAPS[name].studies:
        assert load_study(STUDIES / f"{study}.toml").purpose
    text = (PUBLISHED / f"{name}.md").read_text(encoding="utf-8")
    assert text == pages.page(THERE[name], PUBLISHED)
    for chart in THERE[name].charts:
        for file in (f"{chart.study}-map.svg", f"{chart.study}-law.svg"):
            assert (file in text) == (PUBLISHED / file).exists()
    for study in THERE[name].studies:
        table = read(PUBLISHED, study)
        for figure in figures(table):
            error, doubt = errors(table, figure)
            assert np.nanmax(np.abs(error)) < 1
            assert (doubt[np.isfinite(doubt)] >= 0).all()


def test_first_page_and_laws_are_current_and_all_is_small() -> None:
    rows = list(THERE.values())
    assert (PUBLISHED / "README.md").read_text(encoding="utf-8") == pages.index(PUBLISHED, rows)
    stored, fresh = (
        json.loads(text)
        for text in ((PUBLISHED / "laws.json").read_text(), pages.laws_text(PUBLISHED, rows))
    )
    for kind, tolerance in (("laws", 1e-4), ("curvatures", 1e-4)):
        for present, fresh_row in zip(stored[kind], fresh[kind], strict=True):
            keys = [key for key, value in fresh_row.items() if isinstance(value, float)]
            numbers = {key: fresh_row[key] for key in keys}
            assert {key: present[key] for key in keys} == pytest.approx(numbers, rel=tolerance)
            assert {**present, **numbers} == fresh_row
    assert sum(path.stat().st_size for path in PUBLISHED.iterdir()) < 3e6


def tabled(name: str, title: str) -> list[dict[str, str]]:
    """A table of a published page, which is current by the test above."""
    text = (PUBLISHED / f"{name}.md").read_text(encoding="utf-8").partition(f"## {title}\n")[2]
    lines = text.split("\n\n")[1].splitlines()
    head, _, *rows = (re.split(r" *\| *", line)[1:-1] for line in lines)
    return [dict(zip(head, row, strict=True)) for row in rows]


def test_derived_constants_are_those_of_finite_elements() -> None:
    """Nothing is fitted in the sums over images, of blocks between smooth walls, and in the law of
    a pad's contour.

    Measured: 0.2 % of the constant of p0, 2 % of that of dissipation; of pads the intervals are 6,
    3 and 2 %.
    """
    blocks_and_layers = tabled("block", "Constants that theory predicts")
    walls = [row for row in blocks_and_layers if row["base, width / height"].startswith("rollers")]
    pads = tabled("curvature", "The constant of dissipation that theory predicts")
    assert (len(walls), len(pads)) == (6, len(list(work_lines(PUBLISHED))))
    assert {row[""] for row in (*walls, *pads)} == {"in the interval"}
    for row, line in zip(pads, work_lines(PUBLISHED), strict=True):
        assert line.law is not None
        assert line.law.agrees()
        assert float(row["fitted constant of a/R"].partition("± ")[2]) < 0.07 * abs(
            float(row["derived"])
        )


def test_corrections_on_points_that_nothing_was_fitted_to() -> None:
    """Blocks: measured 0.46 % left of 17, 5 % of the errors in the median. Loops: 0.24 % left of
    8.1, 0.03 in the median.
    """
    held_out = tabled("block", "Correction on points that nothing was fitted to")
    rows = [row for row in held_out if row["left after correction, %"] != "refused"]
    error = np.abs([float(row["error of theory, %"]) for row in rows])
    rest = np.abs([float(row["left after correction, %"]) for row in rows])
    assert rest.max() < 0.6
    assert np.median(rest / error) < 0.08
    assert (rest / error).max() < 0.15  # what advice counts with
    rows = tabled("loop", "The correction under loops that nothing was fitted to")
    rows_with_slip = [row for row in rows if row["error of theory, %"] != "sticks throughout"]
    assert len(rows_with_slip) > 30
    left = []
    for row in rows_with_slip:
        left.append(abs(float(row["left after correction, %"])))
        allowed = max(
            3 * float(row["uncertainty, %"]), 0.035 * abs(float(row["error of theory, %"])), 0.05
        )
        assert left[-1] < allowed + 0.02  # 0.02: digits
    assert np.median(left) < 0.05


# ------------------------------------------------------------------------------------------- advice
def advised(scene: Scene) -> tuple[list[Part], dict[str, tuple[float, float]]]:
    """The departures of a scene, and what the first does."""
    _, parts = parts_of(scene)
    assert parts[0].values is not None
    return list(parts), dict(parts[0].values)


def test_readings_between_points_and_lines() -> None:
    chart = MAPS["block"].charts[0]
    pressures = [
        line for line in lines(chart, read(PUBLISHED, "block")) if line.figure == "error.p0"
    ]
    for line in pressures:
        assert pages.reading_at(line, float(line.s[3])) == pytest.approx(
            (line.error[3], line.uncertainty[3]), rel=1e-9
        )
        assert pages.reading_at(line, 2.0) is None
    fixed = [line for line in pressures if line.at["base"] == "fixed"]
    error, doubt, outside = between(fixed, 0.1, {"aspect": 1.4})
    assert not outside
    assert 0.0036 < error < 0.0063
    assert doubt > 0
    assert between(fixed, 0.9, {"aspect": 9.0})[2] == [
        "width/height = 9 is outside 1 to 4, taken at 4",
        "s = 0.9 is beyond 0.333",
    ]


def test_advice_agrees_with_finite_elements() -> None:
    """The published run of the scene `blocks` found -2.77 % of dissipation and +0.511 % of peak
    pressure.
    """
    _, values = advised(load_scene("blocks"))
    for figure, truth in (("error.dissipation", -0.0277), ("error.p0", 0.00511)):
        assert abs(values[figure][0] - truth) <= values[figure][1]


def test_advice_on_pads() -> None:
    """Far below the smallest radius of the map the first power is all, of this loop's constant;
    another loop is extrapolated.
    """
    for curvature, within in ((1e-3, 0.01), (1e-4, 1e-3)):
        for ratio in (0.3, 0.6):
            parts, values = advised(pad(0.5, curvature, ratio))
            assert len(parts) == 1
            assert "first power of a/R" in parts[0].how
            assert values["error.dissipation"][0] == pytest.approx(
                curvature * work_constant(0.5, ratio), rel=within
            )
    parts, _ = advised(MOVING)
    assert parts[0].extrapolated
    assert "which this loop is not" in parts[0].how


def without_beta(upper_stiff: bool, curvature: float) -> Scene:
    """Moduli that differ by two, and beta = 0: G2/G1 = (1 - 2 nu2)/(1 - 2 nu1) = 1/2."""
    stiff = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    soft = Elastic(young_modulus=210e3 * 1.4 / 2.6, poisson_ratio=0.4)
    materials = Materials(
        upper=stiff if upper_stiff else soft, lower=soft if upper_stiff else stiff
    )
    base = pad(0.5, curvature)
    load = float(contact_of(base.profile, materials).load(1.0))
    return base.vary(
        material=materials,
        load=polygon((load, 0.0), (load, 0.3 * load), cycle=((load, -0.3 * load),)),
    )


@pytest.mark.parametrize(("upper_stiff", "share"), [(True, 0.7369), (False, 1.2631)])
def test_the_curved_bodys_modulus_alone_counts(upper_stiff: bool, share: float) -> None:
    scene = without_beta(upper_stiff, 1e-3)
    assert share_of(scene.material.upper, scene.material) == pytest.approx(share, abs=1e-4)
    parts, values = advised(scene)
    assert [part.what[:9] for part in parts] == ["true arcs"]
    assert values["error.dissipation"][0] == pytest.approx(
        1e-3 * share * work_constant(0.5, 0.6), rel=0.01
    )


def test_correction_and_advice_on_held_out_pads() -> None:
    """Finite elements on pads and loops that no map is made of: advice holds within its
    uncertainty, the first power takes most.
    """
    for row in read(PUBLISHED, "pad-held-out").to_dict("records"):
        scene = pad(float(row["flat"]), float(row["curvature"]), float(row["ratio"]))
        error = float(row["error.dissipation"])
        doubt = float(row["error.dissipation.uncertainty"])
        _, values = advised(scene)
        for figure in FIGURES:
            stated, unsure = values[figure]
            assert abs(stated - float(row[figure])) <= unsure + float(
                row[f"{figure}.uncertainty"]
            ), figure
        assert abs(pages.left(error, pad_correction(scene))) <= 0.25 * abs(error) + doubt


@pytest.mark.parametrize(
    "shape",
    [
        TShape(width=20.0, flange_height=6.0, stem_width=12.0, height=18.0),
        ShoulderedPad(width=20.0, shoulder_depth=6.0, shoulder_width=30.0, height=18.0),
    ],
    ids=lambda shape: shape.kind,
)
def test_bodies_with_a_step_are_said_to_be_in_no_map(shape: TShape | ShoulderedPad) -> None:
    stepped = load_scene("blocks").vary(bodies={"lower": {"kind": "half_plane"}, "upper": shape})
    of_size = parts_of(stepped)[1][0]
    assert of_size.what == f"the upper body, a {shape.kind}"
    assert of_size.values is None
    assert "no map" in of_size.how


# ------------------------------------------------------------ slow: finite elements beside the maps
def measured(scene: Scene, settings: MeshSettings) -> dict[str, float]:
    """Errors of half-plane theory, by finite elements."""
    fe = halfplane_fe.solve(scene, settings)
    exact = semi_analytic.solve(scene, x=fe.x, time=fe.time, fields=("dissipation", "pressure"))
    errors = {
        "error.dissipation": fe.dissipation / exact.dissipation - 1,
        "error.p0": fe.pressure.max() / exact.pressure.max() - 1,
    }
    return {name: float(value) for name, value in errors.items()}


FINE = MeshSettings(element_size=0.025, edge_element_size=0.005, growth=0.1)
# Measured: W -8.8 % (advised -8.1 +- 0.9), p0 +1.73 (+1.8 +- 0.2) of the designer's scene: block,
# arc and unlike materials at once, in no map. Pads: W -1.472 and -2.519 (-1.473 and -2.525 +-
# 0.01), p0 +0.246 and +0.440 (+0.23 and +0.40 +- 0.04).
ADVISED = {
    "the designer's scene": (
        load_scene(pages.DESIGNER),
        MeshSettings(element_size=1 / 16, edge_element_size=1 / 80, growth=0.3),
    ),
    "a stiff pad": (without_beta(True, 0.04), FINE),
    "a soft pad": (without_beta(False, 0.04), FINE),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", ADVISED)
def test_advice_holds_in_a_run(case: str) -> None:
    scene, mesh = ADVISED[case]
    twice = replace(
        mesh, element_size=2 * mesh.element_size, edge_element_size=2 * mesh.edge_element_size
    )
    _, parts = parts_of(scene)
    fine = measured(scene, mesh)
    coarse = measured(scene, twice)
    # The mesh's own part is taken out at order 2: p0 of the soft pad is +0.544, +0.468, +0.441 % as
    # sizes are halved.
    for figure, truth in fine.items():
        error, doubt = total(parts, figure)
        assert abs(truth + (truth - coarse[figure]) / 3 - error) <= doubt, figure
