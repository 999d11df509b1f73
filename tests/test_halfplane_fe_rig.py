"""Finite elements under a prescribed displacement: their own U gives their own Q back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from halfplane_fe.answer_of_rig import scene_of_loads
from halfplane_fe.run import PathRun
from halfplane_fe.settings import Method
from meshes import MeshSettings
from reports.comparison.laws import certificates, expected_numbers
from scenes import (
    STICK,
    Block,
    EllipseLoad,
    HalfPlane,
    InputError,
    Pad,
    PolygonLoad,
    Rig,
    Scene,
    TShape,
    load_scene,
    rig_names,
)
from semi_analytic.answer_of_rig import RiggedScene, rigged_scene
from semi_analytic.driven import ActuatorRows, DrivenPath

MESH = MeshSettings.coarse()
SPRING = 4e-5
T_SHAPE = {
    "lower": HalfPlane(),
    "upper": TShape(width=20.0, flange_height=6.0, stem_width=12.0, height=18.0),
}
LOADS = [(60.0, 0.0), (90.0, 0.0), (90.0, 20.0), (75.0, 5.0), (90.0, -25.0), (100.0, 0.0)]


def rubbing(name: str) -> Scene:
    """A scene of the library with f = 0.5, whose loads will be others."""
    return load_scene(name).vary(friction=0.5, cycles=1, expected=(), tolerances={})


UNLIKE = {
    "lower": {"young_modulus": 210e3, "poisson_ratio": 0.3},
    "upper": {"young_modulus": 70e3, "poisson_ratio": 0.33},
}
BASES = {
    **{
        name: rubbing(name)
        for name in ("blocks", "pad-on-block", "two-cylinders", "flat-pad-on-block")
    },
    "T": rubbing("blocks").vary(bodies=T_SHAPE),
    "unlike": rubbing("blocks").vary(material=UNLIKE),
}
# Bodies, method, whether the approach is prescribed too.
ROUND_TRIPS = [
    ("blocks", "active_set", True),
    ("blocks", "penalty", False),
    ("blocks", "augmented_lagrangian", False),
    ("unlike", "active_set", False),
]
SLOW_TRIPS = [
    ("blocks", "active_set", False),
    ("blocks", "penalty", True),
    ("blocks", "augmented_lagrangian", True),
    ("unlike", "augmented_lagrangian", False),
    *(
        (name, "active_set", approach)
        for name in ("pad-on-block", "two-cylinders", "flat-pad-on-block", "T")
        for approach in (False, True)
    ),
]


@pytest.mark.parametrize(
    ("bodies", "method", "approach"),
    [*ROUND_TRIPS, *(pytest.param(*trip, marks=pytest.mark.slow) for trip in SLOW_TRIPS)],
)
def test_their_own_displacements_give_their_loads_back(
    bodies: str, method: Method, approach: bool
) -> None:
    """To 1e-9: U and P at the end of each increment, or U and the approach. Increments are half as
    long: W moves by their error.
    """
    base = BASES[bodies]
    path = base.load.path()
    unit = float(path.at(path.cycle_start)[0]) / 90.0
    loads = tuple((unit * normal, unit * tangential) for normal, tangential in LOADS)
    settings = SolverSettings(method=method, steps_per_cycle=4)
    of_loads = PolygonLoad(initial_loading=loads)
    given = halfplane_fe.solve(base.vary(load=of_loads), MESH, settings)
    force = given.tangential_load
    second = given.tangential_displacement + SPRING * force
    first = given.normal_load
    rig = Rig(tangential_stiffness=1 / SPRING)
    if approach:
        first = given.normal_approach + SPRING * given.normal_load
        rig = Rig(tangential_stiffness=1 / SPRING, normal_stiffness=1 / SPRING)
    points = tuple(zip(first.tolist(), second.tolist(), strict=True))
    driven = PolygonLoad(
        initial_loading=points[1:],
        times=tuple(given.time.tolist()),
        tangential_displacement=True,
        approach=approach,
    )
    again = halfplane_fe.solve(base.vary(load=driven, rig=rig), MESH, settings, scales=given.scales)
    at_rows = [int(np.argmin(np.abs(again.time - time))) for time in given.time]
    largest = float(np.max(np.abs(force)))
    assert again.normal_load[at_rows] == pytest.approx(
        given.normal_load, abs=1e-9 * float(np.max(given.normal_load))
    )
    assert again.tangential_load[at_rows] == pytest.approx(force, abs=1e-9 * largest)
    of_steps = 1e-6 if bodies == "blocks" else 1e-5
    assert again.dissipation == pytest.approx(given.dissipation, rel=of_steps)
    assert np.max(again.record.certificates["equilibrium"]) < 1e-11
    moved = again.tangential_displacement + SPRING * again.tangential_load
    prescribed = np.interp(again.time, given.time, second)
    assert moved == pytest.approx(prescribed, abs=1e-9 * float(np.ptp(second)))


def test_the_approach_of_an_ellipse_is_met() -> None:
    """Measured on the coarse mesh: P to 6e-4 of theory's, W to 5e-3."""
    load = EllipseLoad(
        approach={"mean": 4e-3, "amplitude": 1.5e-3},
        tangential_displacement={"amplitude": 8e-4, "phase_degrees": 60.0},
    )
    scene = load_scene("rig-compliant").vary(
        load=load, rig={"tangential_stiffness": None}, expected=()
    )
    found = halfplane_fe.solve(scene, MESH)
    to_datum = 2 / (math.pi * MODULUS) * math.log(50.0 / scene.profile.datum_length)
    pressed = found.normal_approach + to_datum * found.normal_load
    cycle = found.last_cycle
    expected = 4e-3 + 1.5e-3 * np.cos(found.time[cycle])
    assert pressed[cycle] == pytest.approx(expected, abs=1e-12)
    theory = semi_analytic.solve(scene, x=[0.0], fields="dissipation")
    load_of_theory = np.interp(found.time[cycle], theory.time, theory.normal_load)
    assert found.normal_load[cycle] == pytest.approx(load_of_theory, rel=1e-3)
    assert abs(found.dissipation - theory.dissipation) < found.dissipation_uncertainty


def test_loads_of_a_cycle_that_is_not_quite_steady_close_with_a_note() -> None:
    load = EllipseLoad(
        mean_normal_load=80.0,
        normal_amplitude=20.0,
        tangential_displacement={"mean": 2e-4, "amplitude": 8e-4, "phase_degrees": 60.0},
    )
    scene = load_scene("rig-compliant").vary(load=load, material=UNLIKE, expected=())
    found = halfplane_fe.solve(scene, MESH, SolverSettings(step_tolerance=math.inf))
    assert any("differ by" in note for note in found.record.notes)
    assert all(law.holds for law in certificates(found))


# ---------------------------------------------------------------------------------- gross sliding
MODULUS = 210e3 / (2 * (1 - 0.3**2))  # E* of steel on steel


@pytest.mark.parametrize(
    ("mesh", "method", "tolerance"),
    [
        (MESH, "active_set", 3e-3),
        *(
            pytest.param(None, method, 1e-3, marks=pytest.mark.slow)
            for method in ("active_set", "penalty", "augmented_lagrangian")
        ),
    ],
)
def test_bodies_slide_as_a_whole_by_every_method(
    mesh: MeshSettings | None, method: Method, tolerance: float
) -> None:
    """Of the library's scene: W, its density, the closed integral and slip agree, and nothing
    sticks while the bodies slide. Measured on the default mesh by the active set: 4.4e-6.
    """
    scene = load_scene("rig-gross-slip")
    settings = SolverSettings(method=method, steps_per_cycle=4)
    solution = halfplane_fe.solve(scene, mesh, settings)
    exact = scene.expected[0].value
    assert abs(solution.dissipation - exact) < solution.dissipation_uncertainty < tolerance * exact
    assert solution.cycle_dissipation[-1] == solution.dissipation
    assert solution.dissipation_density @ solution.face_lengths == pytest.approx(
        solution.dissipation, rel=1e-9
    )
    assert solution.loop_work == pytest.approx(solution.dissipation, rel=1e-8)
    cycle = solution.last_cycle
    time = solution.time[cycle]
    middle = np.argmin(np.abs(solution.x))
    slip = solution.slip[cycle, middle]
    way = float(np.sum(np.abs(np.diff(slip))))
    stroke = 4 * abs(scene.load.cycle[0][1])
    assert way == pytest.approx(stroke - 4 * stroke / 12, rel=1e-3)
    to_datum = 2 / (math.pi * MODULUS) * math.log(50.0 / scene.profile.datum_length)
    moved = solution.tangential_displacement + to_datum * solution.tangential_load
    assert np.ptp(moved[cycle]) == pytest.approx(stroke / 2, rel=1e-9)
    slides = np.isnan(solution.stick_half_width[cycle])
    force = np.abs(solution.tangential_load[cycle])
    assert force[slides] == pytest.approx(np.full(np.sum(slides), force.max()), rel=1e-8)
    assert 0.2 < np.mean(slides[(time > time[0]) & (time < time[-1])]) < 0.95
    assert not np.any(solution.state[cycle][slides] == STICK)
    assert math.isnan(solution.permanent_stick_half_width)


@pytest.mark.slow
def test_a_slide_goes_on_while_the_normal_load_changes() -> None:
    """Beside theory, on a path along which P falls and grows while the bodies slide."""
    points = [(90.0, 0.0), (90.0, 3e-3), (30.0, 3e-3), (80.0, 2.5e-3), (100.0, 6e-3)]
    load = PolygonLoad(
        initial_loading=(*points, (100.0, -3e-3), (40.0, -3.5e-3)), tangential_displacement=True
    )
    scene = load_scene("rig-gross-slip").vary(load=load, expected=())
    solution = halfplane_fe.solve(scene)
    theory = semi_analytic.solve(scene, x=[0.0], fields="dissipation")
    assert abs(solution.dissipation - theory.dissipation) < solution.dissipation_uncertainty
    assert solution.dissipation == pytest.approx(theory.dissipation, rel=1e-4)


def test_bodies_that_part_are_refused() -> None:
    load = PolygonLoad(
        initial_loading=((90.0, 0.0), (0.0, 1e-4), (90.0, 0.0)), tangential_displacement=True
    )
    with pytest.raises(InputError, match="the bodies part at time 2"):
        halfplane_fe.solve(load_scene("rig-gross-slip").vary(load=load), MESH)


# --------------------------------------------------------------- theory beside the finite elements
MEAN = 90.62286500739786
BLOCKS = {name: Block(width=20.0, height=10.0) for name in ("lower", "upper")}
FLAT_BLOCKS = {name: Block(width=18.0, height=6.0) for name in ("lower", "upper")}
ONE_BLOCK = {"lower": HalfPlane(), "upper": Block(width=24.0, height=20.0)}
LAYER = {"lower": HalfPlane(), "upper": Block(width=80.0, height=8.0)}
HALF_PLANES = {"lower": HalfPlane(), "upper": HalfPlane()}
PAPER = load_scene("hertz-paper").load
CATTANEO = PolygonLoad(
    initial_loading=((MEAN, 0.0),), cycle=((MEAN, 0.3 * MEAN), (MEAN, -0.3 * MEAN))
)
TRIANGLE = PolygonLoad(
    initial_loading=((MEAN, 0.0),),
    cycle=((1.2 * MEAN, 0.2 * MEAN), (0.8 * MEAN, 0.1 * MEAN), (MEAN, -0.25 * MEAN)),
)
OUT_OF_PHASE = EllipseLoad(
    mean_normal_load=MEAN,
    normal_amplitude=MEAN / 3,
    tangential_amplitude=0.4 * MEAN / 2,
    phase_degrees=40.0,
)


def driven_as(found: FiniteElementSolution, contact: RiggedScene) -> DrivenPath:
    """Theory under the displacements and normal loads that finite elements found; its Q is theirs,
    to 2e-3 of the range in the last cycle.
    """
    cycle = found.last_cycle
    ends = (int(cycle[0]), int(cycle[-1]))
    rows = ActuatorRows(found.time, found.normal_load, found.tangential_displacement, ends)
    driven = contact.driven_path_of_rows(rows)
    force = np.interp(found.time, driven.time, driven.followed_path.tangential_load)[cycle]
    expected = found.tangential_load[cycle]
    assert np.max(np.abs(force - expected)) < 2e-3 * np.ptp(expected)
    return driven


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bodies", "load", "friction"),
    [
        (BLOCKS, PAPER, 1.0),
        (BLOCKS, CATTANEO, 0.5),
        (FLAT_BLOCKS, PAPER, 1.0),
        (FLAT_BLOCKS, CATTANEO, 0.5),
        (FLAT_BLOCKS, OUT_OF_PHASE, 0.8),
        (ONE_BLOCK, OUT_OF_PHASE, 0.8),
        (LAYER, TRIANGLE, 0.5),
        (HALF_PLANES, PAPER, 1.0),
        (HALF_PLANES, TRIANGLE, 0.5),
    ],
)
def test_theory_finds_the_loads_of_the_finite_elements_by_their_displacements(
    bodies: Mapping[str, Any], load: Any, friction: float
) -> None:
    """Measured, at most: Q 2.2e-4 of its range, W 2.1e-3. Goals: 2e-3 and 5e-3."""
    scene = load_scene("hertz-paper").vary(
        bodies=bodies, load=load, friction=friction, expected=(), tolerances={}
    )
    found = halfplane_fe.solve(scene, settings=SolverSettings(steps_per_cycle=96))
    half_planes = bodies is HALF_PLANES
    rig = Rig(datum_length=scene.profile.datum_length) if half_planes else Rig()
    effects = None if half_planes else halfplane_fe.body_effects(scene)
    prescribed = PolygonLoad(initial_loading=((MEAN, 1e-3),), tangential_displacement=True)
    contact = rigged_scene(scene.vary(load=prescribed, rig=rig), effects)
    driven = driven_as(found, contact)
    work = driven.work(slice(driven.end_rows[0], driven.end_rows[1] + 1))
    assert work == pytest.approx(found.dissipation, rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_theory_finds_the_loads_of_a_body_that_tilts(friction: float) -> None:
    """The T of docs: alpha_Q P0/(a0/R) = -0.38. Measured: Q 2.1e-4 and 1.2e-3 of its range; without
    the moment of the tilt 1e-2.
    """
    load = OUT_OF_PHASE.vary(tangential_amplitude=friction * MEAN / 2)
    scene = load_scene("hertz-paper").vary(
        bodies=T_SHAPE, load=load, friction=friction, expected=(), tolerances={}
    )
    found = halfplane_fe.solve(scene, settings=SolverSettings(steps_per_cycle=96))
    prescribed = PolygonLoad(initial_loading=((MEAN, 1e-3),), tangential_displacement=True)
    effects = halfplane_fe.body_effects(scene)
    contact = rigged_scene(scene.vary(load=prescribed, rig=Rig()), effects)
    driven_as(found, contact)
    cycle = found.last_cycle
    theory = semi_analytic.solve(
        scene,
        x=[0.0],
        time=found.time,
        fields=("tangential_displacement", "normal_approach"),
        effects=effects,
    )
    for name in ("tangential_displacement", "normal_approach"):
        of_elements = getattr(found, name)[cycle]
        difference = of_elements - getattr(theory, name)[cycle]
        assert np.ptp(difference) < 3e-3 * np.ptp(of_elements)


def swinging(amplitude: float, phase: float) -> EllipseLoad:
    """P of 90 -+ 30 N/mm, and a displacement of this amplitude."""
    return EllipseLoad(
        mean_normal_load=90.0,
        normal_amplitude=30.0,
        tangential_displacement={"amplitude": amplitude, "phase_degrees": phase},
    )


# Load, friction, and how far W of theory may be off. Measured: -3.3e-4, 8e-5, 3e-7, -2.3e-3 and
# -9.1e-3; without what grids add the first is 1.9e-2 too large. What tilt and strain leave of the
# last two is stated by the rule of advice: 9.1e-3 and 2.2e-2.
OF_A_BODY_THAT_TILTS = [
    (swinging(1.9e-3, 90.0), 0.8, 2e-3),
    (swinging(1e-3, 90.0), 0.3, 2e-3),
    (swinging(1.5e-3, 60.0), 0.5, 2e-3),
    (swinging(2e-3, 60.0), 0.3, 0.025),
    (
        PolygonLoad(
            initial_loading=((90.0, 0.0),),
            cycle=((90.0, 3.5e-3), (90.0, -3.5e-3)),
            tangential_displacement=True,
        ),
        0.5,
        0.025,
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("load", "friction", "allowed"), OF_A_BODY_THAT_TILTS)
def test_theory_has_the_dissipation_of_a_body_that_tilts(
    load: PolygonLoad | EllipseLoad, friction: float, allowed: float
) -> None:
    scene = load_scene("hertz-paper").vary(
        bodies=T_SHAPE, load=load, friction=friction, expected=(), tolerances={}
    )
    effects = halfplane_fe.body_effects(scene)
    theory = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",), effects=effects)
    found = halfplane_fe.solve(scene)
    stated = theory.record.errors["dissipation"]
    error = abs(theory.dissipation / found.dissipation - 1)
    assert error < allowed
    assert stated < 0.025
    assert error <= stated + found.dissipation_uncertainty / found.dissipation


# ----------------------------------------------------------------------------- rigs of the library
@pytest.mark.slow
@pytest.mark.parametrize("name", rig_names())
def test_finite_elements_meet_what_rigs_of_the_library_expect(name: str) -> None:
    """Measured: W to 3.1e-5 of the closed form, 1.6e-4 of corrected theory, whose own error is
    1.3e-4. All four are taken.
    """
    scene = load_scene(name)
    solution = halfplane_fe.solve(scene)
    findings = list(expected_numbers(scene, [solution]))
    assert findings
    assert all(finding.is_met for finding in findings)
    expected = findings[0].expected.value
    allowed = solution.dissipation_uncertainty
    if not scene.bodies.half_planes:
        effects = halfplane_fe.body_effects(scene)
        theory = semi_analytic.solve(scene, x=[0.0], fields="dissipation", effects=effects)
        assert theory.dissipation == pytest.approx(expected, rel=1e-6)
        allowed += theory.record.errors["dissipation"] * expected
    assert abs(solution.dissipation - expected) < allowed


def test_an_increment_ends_where_a_stroke_of_slip_does() -> None:
    """Where it does not, 24 increments and 48 differ by 2e-3 in W."""
    load = EllipseLoad(
        mean_normal_load=90.0,
        normal_amplitude=30.0,
        tangential_displacement={"amplitude": 1.5e-3, "phase_degrees": 60.0},
    )
    scene = load_scene("rig-compliant").vary(load=load, expected=())
    works = [
        halfplane_fe.solve(scene, MESH, SolverSettings(steps_per_cycle=steps)).dissipation
        for steps in (24, 48)
    ]
    assert works[0] == pytest.approx(works[1], rel=1e-5)


# ------------------------------------------- published: approach of a cylinder and of a half-plane
MATERIAL = {"young_modulus": 206e3, "poisson_ratio": 0.3}
COMPLIANCE = (1 - 0.3**2) / (math.pi * 206e3)
RADIUS = 254.0


@pytest.mark.slow
def test_a_cylinder_is_compressed_as_johnson_states() -> None:
    """Johnson (1985), section 5.6: from the axis to the contact, on a cut that stays plane and is
    free to slide, as in the Hertz problem of the Abaqus Benchmarks Guide. P of its approach;
    measured: 3.7e-5.
    """
    half_width = 0.05 * RADIUS
    load = half_width**2 / (8 * COMPLIANCE * RADIUS)
    pad = Pad(width=1.8 * RADIUS, height=RADIUS, base="rollers")
    scene = load_scene("hertz-normal").vary(
        material=MATERIAL,
        profile={"kind": "hertz", "radius": RADIUS},
        bodies={"lower": HalfPlane(), "upper": pad},
        friction=0.3,
        expected=(),
        tolerances={},
    )
    datum = scene.profile.datum_length
    of_half_plane = load * COMPLIANCE * (2 * math.log(2 * datum / half_width) + 1)
    of_cylinder = load * COMPLIANCE * (2 * math.log(4 * RADIUS / half_width) - 1)
    pressed = PolygonLoad(
        initial_loading=((of_half_plane + of_cylinder, 0.0),),
        tangential_displacement=True,
        approach=True,
    )
    found = halfplane_fe.solve(scene.vary(load=pressed))
    assert found.normal_load[-1] == pytest.approx(load, rel=2e-4)


@pytest.mark.slow
def test_a_half_plane_is_compressed_as_johnson_states() -> None:
    """The same section, from the contact to a point in the depth d; the rest falls with (a/d)^2.
    Measured at d = 10 a: 1.1e-3.
    """
    found = halfplane_fe.solve("hertz-normal")
    load = float(found.normal_load[-1])
    half_width = float(found.contact_half_width[-1])
    material = found.scene.material.lower
    compliance = (1 - material.poisson_ratio**2) / (math.pi * material.young_modulus)
    lower = halfplane_fe.fields(found, [float(found.time[-1])])[0].bodies[0]
    on_axis = np.flatnonzero(np.abs(lower.points[:, 0]) < 1e-9)
    depth = -lower.points[on_axis, 1]
    sunk = -lower.displacement[on_axis, 1]
    compression = sunk[np.argmin(depth)] - sunk
    far = np.argmax(depth)
    assert depth[far] > 9 * half_width
    johnson = load * compliance * (2 * math.log(2 * depth[far] / half_width) - 0.3 / 0.7)
    assert compression[far] == pytest.approx(johnson, rel=0.2 * (half_width / depth[far]) ** 2)


@pytest.mark.slow
def test_half_planes_move_along_their_faces_as_johnson_states() -> None:
    """Johnson (1985), section 2.3: under a tangential line load Q the surface at r moves by 2 Q
    (1 - nu^2)/(pi E) [ln(d/r) + 1/(2 - 2 nu)] more than a point in the depth d. So a rig that holds
    points in that depth prescribes U at a datum length d exp(1/(2 - 2 nu)); their movement is read
    off the elements. Measured at d = 10 a: 2.6e-4.
    """
    depth = 10.0
    prescribed = 4e-4
    datum = depth * math.exp(1 / (2 - 2 * 0.3))
    load = PolygonLoad(
        initial_loading=((90.0, 0.0), (90.0, prescribed)), tangential_displacement=True
    )
    scene = load_scene("rig-gross-slip").vary(load=load, rig={"datum_length": datum}, expected=())
    found = halfplane_fe.solve(scene)
    assert 0.3 < found.tangential_load[-1] / 45.0 < 0.9
    lower = halfplane_fe.fields(found, [float(found.time[-1])])[0].bodies[0]
    on_axis = np.flatnonzero(np.abs(lower.points[:, 0]) < 1e-9)
    depths = -lower.points[on_axis, 1]
    order = np.argsort(depths)
    moved = lower.displacement[on_axis, 0][order]
    at_depth = np.interp(depth, depths[order], moved)
    # Both bodies move alike, and the middle of the contact sticks.
    assert 2 * (moved[0] - at_depth) == pytest.approx(prescribed, rel=5e-4)


def test_a_cycle_that_was_not_completed_is_no_cycle_of_the_loads_found() -> None:
    """A revolution that failed in its second increment was taken for the cycle, and refused."""
    states = [
        SimpleNamespace(time=float(time), normal_load=90.0, tangential_load=tangential_load)
        for time, tangential_load in enumerate((0.0, 10.0, 20.0, 10.0, 20.0))
    ]
    one_cycle = PathRun(states[:4], cycle_starts=[1], force_change_by_cycle=[0.1])
    scene = load_scene(rig_names()[0])
    load = scene_of_loads(scene, one_cycle, 1.0).load
    assert (load.initial_loading, load.cycle) == (((90.0, 10.0),), ((90.0, 20.0),))
    second_failed = PathRun(states, cycle_starts=[1, 3], force_change_by_cycle=[0.1])
    load = scene_of_loads(scene, second_failed, 1.0).load
    assert load.cycle == ()
    assert [force for _, force in load.initial_loading] == [10.0, 20.0, 10.0, 20.0]
