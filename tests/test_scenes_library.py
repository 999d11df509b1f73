"""The library itself: honest tags, expected numbers with sources that the engine named meets, list
and page.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import case_table
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import halfplane_fe
import layer_truth
import semi_analytic
from meshes import MeshSettings
from reports.comparison import laws
from reports.comparison.laws import certificates
from scene_cases import CASES, scene_of
from scenes import (
    ContactSolution,
    EllipseLoad,
    Expected,
    FlatRounded,
    Hertz,
    PolygonLoad,
    Scene,
    load_scene,
    rig_names,
    scene_names,
    tags,
)

NAMES = scene_names()
RIGS = rig_names()
EVERY = (*NAMES, *CASES)  # of the library and of tests/scenes
FINITE = "finite elements"
THEORY = "half-plane theory"
WANTED = 16
# These run on the coarse mesh in every test run; test_contract.py freezes twelve scenes.
QUICK = ("blocks", "cylinder-roller-frictionless", "layer", "full-stick")


# ---------------------------------------------------------------------------------------- the table
def test_the_library_is_large_enough_and_nothing_stands_twice() -> None:
    assert len(NAMES) >= WANTED
    assert len(set(NAMES)) == len(NAMES)
    scenes = [load_scene(name) for name in (*NAMES, *RIGS)]
    for texts in (
        [scene.title for scene in scenes],
        [scene.vary(name="").model_dump_json() for scene in scenes],
    ):
        assert len(set(texts)) == len(texts)
    assert all(re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name) for name in (*NAMES, *RIGS))


def honest_tags(scene: Scene) -> dict[str, bool]:
    """Tags that the scene's own tables decide."""
    load = scene.load
    kinds = {scene.bodies.lower.kind, scene.bodies.upper.kind}
    path = load.path_of_actuators() if load.is_driven else load.path()
    turns = np.concatenate(
        [
            np.stack(leg.loads(np.linspace(leg.start, leg.end, 9)), axis=1)
            for leg in path.cycle or path.initial_loading
        ]
    )
    wide = np.linalg.svd(turns - turns.mean(axis=0), compute_uv=False)
    periodic = path.period is not None
    pressed = not np.any(turns[:, 1])
    return {
        "hertz": isinstance(scene.profile, Hertz),
        "flat": isinstance(scene.profile, FlatRounded),
        "compound": scene.profile.kind == "compound",
        "wedge": scene.profile.kind == "wedge",
        "half-planes": scene.bodies.half_planes,
        "bodies": not scene.bodies.half_planes,
        "block": "block" in kinds,
        "pad": "pad" in kinds,
        "cylinder": "cylinder" in kinds,
        "unlike": not scene.material.alike,
        "ellipse": isinstance(load, EllipseLoad),
        "polygon": isinstance(load, PolygonLoad),
        "rig": load.is_driven,
        "harmonics": load.kind == "harmonics",
        "time-series": load.kind == "time_series",
        "frictionless": scene.friction.coefficient == 0,
        "normal-only": pressed,
        "constant-load": periodic and float(np.ptp(turns[:, 0])) == 0,
        "line": periodic and float(np.ptp(turns[:, 0])) > 0 and bool(wide[1] < 1e-9 * wide[0]),
        "bulk": load.bulk_stress_lower is not None or load.bulk_stress_upper is not None,
        "tilt": any(
            turning is not None for turning in (load.tilt, load.moment, load.line_of_action)
        ),
    }


@pytest.mark.parametrize("name", [*NAMES, *RIGS])
def test_tags_say_what_the_scene_is_and_every_scene_expects_numbers_with_their_sources(
    name: str,
) -> None:
    scene = load_scene(name)
    assert set(scene.tags) <= set(tags())
    assert len(set(scene.tags)) == len(scene.tags)
    assert {tag: tag in scene.tags for tag in honest_tags(scene)} == honest_tags(scene)
    assert scene.purpose
    assert scene.source
    # Under prescribed displacements theory of bodies is the corrected one, which has tests of its
    # own: test_semi_analytic_rig.py.
    engines = {THEORY} if scene.bodies.half_planes or not scene.load.is_driven else set()
    if not scene.bodies.half_planes:
        engines.add(FINITE)
    assert {number.engine for number in scene.expected} >= engines
    assert len(
        {(number.quantity, number.engine, number.value) for number in scene.expected}
    ) == len(scene.expected)
    assert all(len(number.source) > 10 for number in scene.expected)
    # Something in each scene is somebody else's number, whatever may be frozen beside it.
    assert [number for number in scene.expected if not number.source.startswith("our own")]


# -------------------------------------------------------------------------- met by the engine named
# By half-plane theory: test_semi_analytic_fields.py, one solution of each scene for the laws and
# for these numbers.
@pytest.mark.parametrize("name", NAMES)
def test_published_figures_of_the_finite_elements_meet_what_is_expected(name: str) -> None:
    """Those of the default settings, which test_reports_published holds to the code."""
    known = case_table.sheet(name)
    for case in case_table.expected(name):
        if case.run == case_table.ELEMENTS:
            published = known.baseline(case_table.ELEMENTS, case.quantity)
            assert case_table.agrees(case, published.value), case


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in EVERY],
)
def test_finite_elements_on_a_coarse_mesh_come_near(name: str) -> None:
    """Elements of a/8 and a/32: pressure and half-width to 4 %, dissipation to 15 % (worst: 13.2 %,
    flat-pad-on-block).

    One number states a larger tolerance of its own: the published roller's stress on linear
    elements of 1.5 mm.
    """
    scene = scene_of(name)
    solution = halfplane_fe.solve(scene, mesh=MeshSettings.coarse())
    assert solution.record.converged
    assert not [check.label for check in certificates(solution) if not check.holds]
    for finding in laws.expected_numbers(scene, [solution]):
        limit = (
            0.15
            if finding.expected.quantity == "dissipation"
            else max(0.04, finding.expected.tolerance)
        )
        assert abs(finding.difference) <= limit, finding


@pytest.mark.slow
@pytest.mark.parametrize("name", EVERY)
def test_finite_elements_meet_what_is_expected_of_them(name: str) -> None:
    scene = scene_of(name)
    findings = list(laws.expected_numbers(scene, [halfplane_fe.solve(scene)]))
    assert not [finding for finding in findings if not finding.is_met]


# ---------------------------------------------------------- sources that are neither of the engines
def value_of(name: str, quantity: str) -> float:
    """The expected number of the finite elements."""
    return next(
        number.value
        for number in scene_of(name).expected
        if (number.engine, number.quantity) == (FINITE, quantity)
    )


def modulus(scene: Scene) -> float:
    return 1 / sum(
        (1 - body.poisson_ratio**2) / body.young_modulus
        for body in (scene.material.lower, scene.material.upper)
    )


def periodic(
    e_star: float, radius: float, distance: float, half_width: float, terms: int = 120
) -> tuple[float, float]:
    """Load and peak pressure of one of a row of parabolas.

    h'(x) = (2/(E* W)) PV int p cot(pi (x - s)/W) ds; with t = tan(pi x/W) the kernel is 1/(t - tau)
    for an even p, and p = sum c_k sin(k theta), t = tan(pi a/W) cos(theta), gives PV int p d tau/(t
    - tau) = pi sum c_k cos(k theta).
    """
    reach = math.tan(math.pi * half_width / distance)
    theta = (2 * np.arange(terms) + 1) * np.pi / (2 * terms)
    slope = e_star / 2 * distance / math.pi * np.arctan(reach * np.cos(theta)) / radius
    k = np.arange(1, terms)
    c = 2 / terms * np.cos(np.outer(k, theta)) @ slope
    nodes, weights = np.polynomial.legendre.leggauss(200)
    angle = (nodes + 1) * np.pi / 2
    weights = weights * np.pi / 2
    along = distance / math.pi * reach * np.sin(angle) / (1 + (reach * np.cos(angle)) ** 2)
    return float(weights @ (np.sin(np.outer(angle, k)) @ c * along)), float(
        np.sin(k * np.pi / 2) @ c
    )


def test_numbers_of_the_row_of_contacts() -> None:
    """Contacts far from each other are those of Hertz."""
    assert periodic(1.0, 1.0, 1e4, 1.0) == pytest.approx((math.pi / 4, 0.5), rel=1e-6)
    scene = scene_of("row-of-contacts")
    e_star = modulus(scene)
    load = scene.load.initial_loading[0][0]
    distance = scene.bodies.lower.width
    half_width = brentq(
        lambda a: periodic(e_star, scene.profile.radius, distance, a)[0] - load,
        0.5,
        1.3,
        xtol=1e-14,
    )
    assert value_of("row-of-contacts", "largest_half_width") == pytest.approx(half_width, rel=1e-10)
    peak = periodic(e_star, scene.profile.radius, distance, half_width)[1]
    assert value_of("row-of-contacts", "largest_pressure") == pytest.approx(peak, rel=1e-10)


def test_numbers_of_the_thin_blocks() -> None:
    """Two like layers sink alike: one of half the modulus on which the parabola is rigid."""
    scene = scene_of("thin-blocks")
    steel = scene.material.lower
    layer = layer_truth.Layer(
        steel.young_modulus / 2,
        steel.poisson_ratio,
        scene.bodies.lower.height,
        scene.profile.radius,
    )
    load = scene.load.mean_normal_load + scene.load.normal_amplitude
    half_width = layer_truth.half_width_under(layer, load, 0.94)
    assert value_of("thin-blocks", "largest_half_width") == pytest.approx(half_width, rel=1e-9)
    peak = float(layer_truth.coefficients(layer, half_width) @ (-1.0) ** np.arange(24))
    assert value_of("thin-blocks", "largest_pressure") == pytest.approx(peak, rel=1e-9)


@pytest.mark.parametrize("name", ["large-pad", "large-pad-steep"])
def test_numbers_of_the_large_pads(name: str) -> None:
    """P = E* int_0^a x h'/sqrt(a^2 - x^2) dx with the slope of an arc, x/sqrt(R^2 - x^2), by
    quadrature over x = a sin t.
    """
    scene = scene_of(name)
    radius = scene.profile.radius
    load = scene.load.initial_loading[0][0]
    a = value_of(name, "largest_half_width")
    carried = (
        modulus(scene)
        * quad(
            lambda t: (a * math.sin(t)) ** 2 / math.sqrt(radius**2 - (a * math.sin(t)) ** 2),
            0,
            math.pi / 2,
        )[0]
    )
    assert carried == pytest.approx(load, rel=1e-10)


def test_beta_of_the_unlike_half_planes() -> None:
    from halfplane_fe.dundurs import dundurs

    for name, beta in (("unlike-beta-tenth", 0.1), ("unlike-beta-fifth", 0.2)):
        assert abs(dundurs(scene_of(name).material).beta) == pytest.approx(beta, rel=1e-12)


# ------------------------------------------------------------------------ the check is able to fail
@pytest.fixture(scope="module")
def mindlin() -> ContactSolution:
    return semi_analytic.solve(scene_of("cattaneo-mindlin"))


# W of a zero is over A f^2 P^2
SCALE = 2 / modulus(scene_of("cattaneo-mindlin")) * (0.5 * 90.62286500739786) ** 2
NONE = (
    "permanent_stick_half_width",
    "stick_share",
    "stick_centre",
    "moment",
    "lower_face_displacement",
)
# What is expected, of what the answer holds or as a number; the difference that is found, NaN for
# no such thing.
PLANTED: dict[str, tuple[str, Callable[[float], float], Callable[[float], float]]] = {
    "right": ("dissipation", lambda work: work, lambda _: 0.0),
    "off": ("dissipation", lambda work: work * (1 + 2e-6), lambda _: -2e-6),
    "zero work": ("dissipation", lambda _: 0.0, lambda work: work / SCALE),
    "zero half-width": ("largest_half_width", lambda _: 0.0, lambda _: 1.0),
} | {f"no {quantity}": (quantity, lambda _: 0.5, lambda _: math.nan) for quantity in NONE}


@pytest.mark.parametrize("name", PLANTED)
def test_what_is_right_is_met_and_what_is_off_or_not_there_is_missed(
    name: str, mindlin: ContactSolution
) -> None:
    quantity, value, difference = PLANTED[name]
    work = mindlin.dissipation
    planted = Expected(quantity=quantity, value=value(work), tolerance=1e-6, source="planted")
    answer = replace(mindlin, permanent_stick_half_width=math.nan)
    (finding,) = laws.expected_numbers(answer.scene.vary(expected=(planted,)), [answer])
    assert finding.is_met is (name == "right")
    assert finding.difference == pytest.approx(difference(work), rel=1e-3, abs=1e-12, nan_ok=True)
    row = laws.expected_rows([finding])[0]
    assert (row[-1] == "no", row[3] == "none") == (not finding.is_met, "no " in name)


def test_a_moment_expected_to_be_zero_is_judged_over_the_load_times_the_half_width(
    mindlin: ContactSolution,
) -> None:
    """In the scene's units a half-width of one tells nothing of a moment."""
    scale = float(mindlin.normal_load.max() * mindlin.contact_half_width.max())
    answer = replace(mindlin, moment=np.full(len(mindlin.time), 1e-3 * scale))
    planted = Expected(quantity="moment", value=0.0, tolerance=1e-6, source="planted")
    (finding,) = laws.expected_numbers(answer.scene.vary(expected=(planted,)), [answer])
    assert finding.difference == pytest.approx(1e-3)
