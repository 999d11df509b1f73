"""Rigs: loads that follow from prescribed displacements, gross sliding, springs, separation."""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import Mock

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from reports.comparison.laws import expected_numbers
from scenes import (
    Block,
    BodyEffects,
    EllipseLoad,
    Estimate,
    HarmonicLoad,
    InputError,
    PolygonLoad,
    Rig,
    Scene,
    load_scene,
    rig_names,
)
from scenes.body_effects import ZERO_ESTIMATE
from semi_analytic import answer_of_rig, corrected
from semi_analytic.answer_of_rig import rigged_scene
from semi_analytic.corrected_memory import PunchTable, area_of_loop
from semi_analytic.driven import (
    ActuatorRows,
    Compliance,
    DrivenPath,
    actuator_rows,
    follow_actuator,
    loads_of_approach,
)
from semi_analytic.hertz import HertzContact
from semi_analytic.odd_memory import DeclinedError

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import must_fail  # noqa: E402

sys.path.remove(str(BENCHMARKS))

# a^2 = P, A/pi = 1/2: at P = 1 the half-width is 1.
MODULUS = 4 / math.pi
UNIT = 0.5
DATUM = 50.0
FRICTION = 0.4
CONTACT = HertzContact(modulus=MODULUS, radius=1.0, datum_length=DATUM)
# U at Q = f P = f, and the loop of a cycle that just reaches it on both sides.
AT_LIMIT = UNIT * FRICTION * (math.log(2 * DATUM) + 0.5)
LIMIT_LOOP = UNIT * FRICTION**2

EFFECTS = BodyEffects(
    datum_length=1000.0,
    normal_compliance=Estimate(3e-5),
    tangential_compliance=Estimate(-1.5e-5),
    normal_curvature=Estimate(8.5e-8),
    tangential_curvature=Estimate(1.4e-7),
)


def followed_path(
    points: list[tuple[float, float]], spring: float = 0.0, steps: int = 1, friction: float = 0.4
) -> DrivenPath:
    """The path through points (P, U_act) from (0, 0), `steps` straight steps to each."""
    corners = np.array([(0.0, 0.0), *points])
    time = np.linspace(0.0, len(points), steps * len(points) + 1)
    load, displacement = (
        np.interp(time, np.arange(len(corners)), corners[:, column]) for column in (0, 1)
    )
    rows = ActuatorRows(time, load, displacement, (len(time) - 1,))
    table = PunchTable(CONTACT, MODULUS, 1.02 * math.sqrt(max(load)))
    compliance = Compliance(
        unit_compliance=UNIT, datum_length=DATUM, tangential_spring_compliance=spring
    )
    return follow_actuator(table, friction, compliance, rows)


def since(result: DrivenPath, time: float) -> slice:
    """The rows from an instant on."""
    return slice(int(np.argmin(np.abs(result.time - time))), None)


# ----------------------------------------------------------------------------------- closed forms
def check_gross_cycle(spring: float) -> None:
    """W = 4 f P (U_m - U_s) + limit loop, of the contact, whatever the spring."""
    stroke = 3 * AT_LIMIT + spring * FRICTION
    result = followed_path([(1.0, 0.0), (1.0, stroke), (1.0, -stroke), (1.0, stroke)], spring)
    cycle = since(result, 2.0)
    expected = 4 * FRICTION * 2 * AT_LIMIT + LIMIT_LOOP
    assert result.work(cycle) == pytest.approx(expected, rel=1e-9)
    assert np.ptp(result.displacement[cycle]) == pytest.approx(6 * AT_LIMIT, rel=1e-12)


def test_first_loading_follows_cattaneo_and_mindlin() -> None:
    force = np.linspace(0.0, 0.99, 12)[1:] * FRICTION
    stick = np.sqrt(1 - force / FRICTION)
    displacement = UNIT * (
        FRICTION * (math.log(2 * DATUM) + 0.5)
        - (FRICTION - force) * (np.log(2 * DATUM / stick) + 0.5)
    )
    result = followed_path([(1.0, 0.0), *((1.0, float(way)) for way in displacement)])
    assert result.followed_path.tangential_load[2:] == pytest.approx(force, abs=1e-11)


# ------------------------------------------------------------------------------ what P does besides
def check_sliding_under_falling_load() -> None:
    """Q follows f P, and the bodies slide on in the direction of Q while U rests."""
    result = followed_path([(1.0, 0.0), (1.0, 2 * AT_LIMIT), (0.25, 2 * AT_LIMIT)], steps=10)
    falling = since(result, 2.0)
    load = result.followed_path.normal_load[falling]
    assert result.followed_path.tangential_load[falling] == pytest.approx(
        FRICTION * load, rel=1e-12
    )
    assert np.all(result.slide_distance[falling] > 0)


def check_nothing_is_remembered_through_separation() -> None:
    """Bodies that were sheared, parted and pressed together again carry no shear."""
    result = followed_path(
        [(1.0, 0.0), (1.0, 0.8 * AT_LIMIT), (0.0, 0.8 * AT_LIMIT), (0.0, -1.0), (1.0, -1.0)]
    )
    assert result.followed_path.tangential_load[-1] == pytest.approx(0.0, abs=1e-12)
    again = followed_path([(1.0, 0.0), (1.0, 0.3 * AT_LIMIT)])
    after = followed_path([(1.0, 0.5), (0.0, 0.0), (1.0, 0.0), (1.0, 0.3 * AT_LIMIT)])
    expected = again.followed_path.tangential_load[-1]
    assert after.followed_path.tangential_load[-1] == pytest.approx(expected, abs=1e-12)


def check_energy_from_rest_to_rest() -> None:
    """W is all work of P and Q, since no elastic energy is left in bodies that parted."""
    points = [(1.0, 0.0), (0.7, 3 * AT_LIMIT), (1.2, 2 * AT_LIMIT), (0.5, -AT_LIMIT), (0.0, 0.0)]
    result = followed_path(points, steps=100)
    load = result.followed_path.normal_load
    half_width = np.sqrt(load)
    approach = UNIT * load * (np.log(2 * DATUM / np.where(load > 0, half_width, 1.0)) + 0.5)
    mean = (load[1:] + load[:-1]) / 2
    work_of_loads = float(np.sum(mean * np.diff(approach))) + result.loop_work(slice(0, None))
    assert result.work(slice(0, None)) == pytest.approx(work_of_loads, rel=1e-4)
    # At contact there is no energy, and none is left: the elastic work of P alone closes.
    assert abs(float(np.sum(mean * np.diff(approach)))) < 1e-3 * work_of_loads


def test_error_of_the_steps_falls_with_their_square_where_the_normal_load_varies() -> None:
    def work(steps: int) -> float:
        points = [(1.0, 0.0), (1.3, 0.8 * AT_LIMIT), (0.8, -0.5 * AT_LIMIT), (1.2, 0.0)]
        return followed_path(points, steps=steps).work(slice(0, None))

    coarse, middle, fine = (work(steps) for steps in (5, 10, 20))
    assert (coarse - middle) / (middle - fine) == pytest.approx(4.0, abs=0.8)


# ------------------------------------------------------------- published: approach under a load
class Pressed(NamedTuple):
    """Young's modulus and Poisson's ratio of a body, and where its displacement is prescribed."""

    young_modulus: float
    poisson_ratio: float
    distance: float
    is_cylinder: bool

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E."""
        return (1 - self.poisson_ratio**2) / self.young_modulus

    def approach(self, load: float, half_width: float) -> float:
        """Johnson (1985), Contact Mechanics, section 5.6: of a cylinder its axis to the contact, of
        a half-plane a point in the depth d.
        """
        if self.is_cylinder:
            bracket = 2 * math.log(4 * self.distance / half_width) - 1
        else:
            ratio = self.poisson_ratio / (1 - self.poisson_ratio)
            bracket = 2 * math.log(2 * self.distance / half_width) - ratio
        return load * self.compliance / math.pi * bracket

    @property
    def datum_length(self) -> float:
        """L of the same approach of a half-plane, as docs/displacement-control.md states it."""
        if self.is_cylinder:
            return 2 * self.distance / math.e
        return self.distance * math.exp(-1 / (2 * (1 - self.poisson_ratio)))


PRESSED = {
    # Abaqus Benchmarks Guide, "The Hertz contact problem": cut displaced by 10.16 mm.
    "cylinders": ((Pressed(206e3, 0.3, 254.0, True), Pressed(206e3, 0.3, 254.0, True)), 127.0),
    # Ansys Mechanical APDL Verification Manual, VM191: E/(1 - nu^2) is 32 GPa in both.
    "unlike": ((Pressed(30e3, 0.25, 10.0, True), Pressed(29120.0, 0.3, 13.0, True)), 130 / 23),
    "roller": ((Pressed(210e3, 0.3, 50.0, True), Pressed(210e3, 0.3, 80.0, False)), 50.0),
}


@pytest.mark.parametrize(("bodies", "radius"), PRESSED.values(), ids=PRESSED)
def test_the_load_of_an_approach_is_that_of_published_formulas(
    bodies: tuple[Pressed, Pressed], radius: float
) -> None:
    modulus = 1 / sum(body.compliance for body in bodies)
    half_width = np.array([0.02, 0.1, 0.17]) * radius
    load = math.pi * modulus * half_width**2 / (4 * radius)
    approach = np.array(
        [
            sum(body.approach(*pair) for body in bodies)
            for pair in zip(load.tolist(), half_width.tolist(), strict=True)
        ]
    )
    shares = [body.compliance * modulus for body in bodies]
    lengths = [body.datum_length for body in bodies]
    datum_length = math.exp(float(np.dot(shares, np.log(lengths))))
    contact = HertzContact(modulus=modulus, radius=radius, datum_length=datum_length)
    compliance = Compliance(unit_compliance=2 / (math.pi * modulus), datum_length=datum_length)
    found = loads_of_approach(contact, modulus, compliance, approach)
    assert found == pytest.approx(load, rel=1e-9)


# ----------------------------------------------------------------------------------- planted faults
# The faults of benchmarks/must_fail.py by name, and the checks that see each.
CHECKS = {
    "slide not counted": [lambda: check_gross_cycle(0.0), check_energy_from_rest_to_rest],
    "spring left in the loop": [lambda: check_gross_cycle(3.0)],
    "sliding limit of the wrong sign": [check_sliding_under_falling_load],
    "memory kept through separation": [check_nothing_is_remembered_through_separation],
}


def test_every_planted_fault_has_a_check() -> None:
    assert set(CHECKS) == set(must_fail.FAULTS_OF_RIGS)


@pytest.mark.parametrize("name", CHECKS)
def test_planted_faults_are_seen(name: str) -> None:
    for check in CHECKS[name]:
        check()
        with must_fail.FAULTS_OF_RIGS[name](), pytest.raises(AssertionError):
            check()


# ------------------------------------------------------------------------------- the round trip


MODULUS_OF_STEEL = 210e3 / (2 * (1 - 0.3**2))


# ------------------------------------------------------------------------------------- whole scenes
def rig_scene(load: PolygonLoad | dict[str, object] | None = None, **rig: float) -> Scene:
    """Cattaneo-Mindlin's scene with a displacement prescribed."""
    base = load_scene("cattaneo-mindlin").vary(expected=(), tolerances={})
    if load is None:
        load = PolygonLoad(
            initial_loading=((90.0, 0.0),),
            cycle=((90.0, 0.0008), (70.0, -0.0003)),
            tangential_displacement=True,
        )
    return base.vary(load=load, rig=Rig(**{"datum_length": 50.0, **rig}))


def test_half_plane_theory_has_the_same_work_under_the_loads_that_were_found() -> None:
    fields = ("dissipation", "tangential_displacement")
    solution = semi_analytic.solve(rig_scene(), x=[0.0], fields=fields)
    exact = semi_analytic.solve(solution.scene, x=[0.0], time=solution.time, fields=fields)
    displacement = exact.tangential_displacement
    assert solution.tangential_displacement == pytest.approx(
        displacement, abs=1e-3 * np.ptp(displacement)
    )
    error = solution.record.errors["dissipation"]
    assert 0 < error < 1e-3
    assert solution.dissipation == pytest.approx(exact.dissipation, rel=error)
    assert any("gross sliding: none" in note for note in solution.record.notes)


PRESSED_ELLIPSE = EllipseLoad(
    approach={"mean": 4e-3, "amplitude": 1.5e-3},
    tangential_displacement={"amplitude": 8e-4, "phase_degrees": 60.0},
)
PRESSED_HARMONICS = HarmonicLoad(
    approach={"mean": 4e-3, "harmonics": [(1.5e-3, 0.0)]},
    tangential_displacement={"harmonics": [(8e-4, 60.0)]},
)


@pytest.mark.parametrize("load", [PRESSED_ELLIPSE, PRESSED_HARMONICS], ids=["ellipse", "harmonics"])
def test_the_approach_of_an_ellipse_and_of_harmonics_is_met(
    load: EllipseLoad | HarmonicLoad,
) -> None:
    spring = 1e-5
    scene = rig_scene(load, normal_stiffness=1 / spring)
    fields = ("normal_approach", "tangential_displacement")
    solution = semi_analytic.solve(scene, x=[0.0], fields=fields)
    cycle = solution.last_cycle
    time = solution.time[cycle]
    force = solution.normal_load[cycle]
    # Answers count from the profile's datum length, the rig from 50 mm.
    to_datum = 2 / (math.pi * MODULUS_OF_STEEL) * math.log(50.0 / scene.profile.datum_length)
    pressed = solution.normal_approach[cycle] + (to_datum + spring) * force
    assert pressed == pytest.approx(4e-3 + 1.5e-3 * np.cos(time), abs=1e-12)
    moved = solution.tangential_displacement[cycle] + to_datum * solution.tangential_load[cycle]
    assert moved == pytest.approx(8e-4 * np.cos(time - math.pi / 3), abs=1e-12)
    assert np.ptp(force) > 0.3 * np.max(force)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"approach": {"mean": 4e-3}}, "state that too"),
        ({}, "mean_normal_load is missing"),
        (
            {"approach": {"mean": 4e-3}, "tangential_displacement": {}, "mean_normal_load": 90.0},
            "leave these out",
        ),
        ({"approach": {"mean": -1.0}, "tangential_displacement": {}}, "above 0|greater than 0"),
    ],
)
@pytest.mark.parametrize("kind", ["ellipse", "harmonics"])
def test_an_approach_beside_other_normal_keys_is_refused(
    kind: str, keys: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        rig_scene({"kind": kind, **keys})


def test_an_answer_states_how_far_the_bodies_slide() -> None:
    load = PolygonLoad(
        initial_loading=((90.0, 0.0),),
        cycle=((90.0, 0.01), (90.0, -0.01)),
        tangential_displacement=True,
    )
    solution = semi_analytic.solve(rig_scene(load, tangential_stiffness=2e4), time=[4.0, 5.0, 6.0])
    assert solution.tangential_load[1:] == pytest.approx([45.0, -45.0], rel=1e-12)
    sliding = [note for note in solution.record.notes if note.startswith("gross sliding: in")]
    assert len(sliding) == 1
    assert solution.loop_work == pytest.approx(solution.dissipation, rel=1e-3)
    assert math.isnan(solution.permanent_stick_half_width)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rig": {"datum_length": 0.4}}, "longer rig.datum_length"),
        ({"rig": Rig()}, "needs bodies"),
        ({"rig": {"normal_stiffness": 1.0}}, "goes with load.approach"),
        ({"load": {"tangential_displacement": False}}, "rig goes with"),
        ({"load": {"tilt": 1e-3}}, "tilt does not go with tangential_displacement"),
        ({"load": {"tangential_displacement": False, "approach": True}}, "approach goes with"),
        ({"load": {"times": (0.0, 1.0)}}, "are needed"),
    ],
)
def test_what_has_no_answer_is_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        semi_analytic.solve(rig_scene().vary(**change))


def test_loads_of_a_driven_scene_are_not_read() -> None:
    scene = rig_scene()
    with pytest.raises(InputError, match="P and Q follow from the displacement"):
        scene.load.path()
    with pytest.raises(InputError, match="P and Q follow from the displacement"):
        scene.smallest_friction  # noqa: B018


def test_rows_have_turning_points_and_the_instants_of_contact() -> None:
    load = PolygonLoad(
        initial_loading=((2.0, 0.0),), cycle=((2.0, 1.0), (-1.0, 0.0)), tangential_displacement=True
    )
    rows = actuator_rows(load.path_of_actuators(), 1)
    for time in (0.0, 1.0, 2.0, 2.0 + 2 / 3, 3.0 + 1 / 3, 4.0):
        assert np.min(np.abs(rows.time - time)) < 1e-12
    assert rows.load_or_approach.min() == 0.0


@pytest.mark.parametrize(("steps_per_cycle", "steps"), [(200, 29), (20, 3), (4, 1)])
def test_all_intervals_between_turning_points_have_equally_many_steps(
    steps_per_cycle: int, steps: int
) -> None:
    """The steps of a cycle over the seven turning points, rounded up: no other least number."""
    load = PolygonLoad(
        initial_loading=((2.0, 0.0),), cycle=((2.0, 1.0), (-1.0, 0.0)), tangential_displacement=True
    )
    rows = actuator_rows(load.path_of_actuators(), 1, steps_per_cycle=steps_per_cycle)
    turning_times = [0.0, 1.0, 2.0, 2.0 + 2 / 3, 3.0, 3.0 + 1 / 3, 4.0]
    assert rows.time == pytest.approx(
        np.append(
            [
                np.linspace(begin, end, steps, endpoint=False)
                for begin, end in itertools.pairwise(turning_times)
            ],
            4.0,
        )
    )


# ------------------------------------------------------------------------- tilt and bulk strain
TILTED = BodyEffects(
    datum_length=1000.0,
    tangential_compliance=Estimate(2e-5),
    tangential_curvature=Estimate(1.4e-7),
    tangential_fourth=Estimate(-1e-8),
    tilt_under_shear=Estimate(-1e-6),
    strain_under_pressure=Estimate(-1.5e-7),
)


DRIVEN_WAVE = EllipseLoad(
    mean_normal_load=90.0,
    normal_amplitude=30.0,
    tangential_displacement={"amplitude": 1.5e-3, "phase_degrees": 60.0},
)


def tilting(load: Any, rig: Rig) -> Scene:
    """A block on a half-plane, whose effects are stated beside it."""
    return load_scene("cattaneo-mindlin").vary(
        expected=(),
        tolerances={},
        bodies={"upper": Block(width=24.0, height=20.0)},
        load=load,
        rig=rig,
    )


def test_the_moment_is_in_the_movements_under_given_loads() -> None:
    """U - R alpha_Q^2 P Q and the approach - R (alpha_Q Q)^2/2: together no work in a cycle."""
    scene = tilting(load_scene("hertz-paper").load, Rig()).vary(friction=1.0)
    fields = ("tangential_displacement", "normal_approach")
    tilted = semi_analytic.solve(scene, x=[0.0], effects=TILTED, fields=fields)
    level = replace(TILTED, tilt_under_shear=ZERO_ESTIMATE)
    straight = semi_analytic.solve(scene, x=[0.0], effects=level, fields=fields)
    load = tilted.normal_load
    force = tilted.tangential_load
    moved = tilted.tangential_displacement - straight.tangential_displacement
    pressed = tilted.normal_approach - straight.normal_approach
    assert moved == pytest.approx(-1e-9 * load * force, abs=1e-12)
    assert pressed == pytest.approx(-0.5e-9 * force**2, abs=1e-12)
    cycle = tilted.last_cycle
    work = area_of_loop(force[cycle], moved[cycle]) + area_of_loop(load[cycle], pressed[cycle])
    assert abs(work) < 1e-3 * abs(area_of_loop(force[cycle], moved[cycle]))


@pytest.mark.parametrize(
    ("load", "tolerance"),
    [
        (
            PolygonLoad(
                initial_loading=((90.0, 0.0),),
                cycle=((90.0, 1.5e-3), (90.0, -1.5e-3)),
                tangential_displacement=True,
            ),
            1e-5,
        ),
        pytest.param(
            EllipseLoad(
                mean_normal_load=90.0,
                normal_amplitude=30.0,
                tangential_displacement={"amplitude": 1.5e-3, "phase_degrees": 60.0},
            ),
            1e-3,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_tilt_and_strain_add_to_the_work_what_they_do_under_the_loads_found(
    load: PolygonLoad | EllipseLoad, tolerance: float
) -> None:
    scene = tilting(load, Rig())
    solution = semi_analytic.solve(scene, x=[0.0], effects=TILTED, fields="loop_work")
    force = solution.tangential_load[solution.last_cycle]
    time = solution.time[solution.last_cycle]
    if isinstance(load, PolygonLoad):
        largest = float(np.max(force))
        points = ((90.0, largest), (90.0, -largest))
        of_loads: PolygonLoad | HarmonicLoad = PolygonLoad(
            initial_loading=((90.0, 0.0),), cycle=points
        )
    else:
        angle = np.linspace(0.0, 2 * np.pi, 65)[:-1]
        normal = solution.normal_load[solution.last_cycle]
        waves = []
        for values in (normal, force):
            series = np.fft.rfft(np.interp(time[0] + angle, time, values)) / 64
            waves.append([(2 * abs(w), -math.degrees(np.angle(w))) for w in series[1:20]])
        of_loads = HarmonicLoad(
            mean_normal_load=90.0,
            normal_harmonics=tuple(waves[0][:1]),
            mean_tangential_load=float(np.mean(np.interp(time[0] + angle, time, force))),
            tangential_harmonics=tuple(waves[1]),
        )
    given = semi_analytic.solve(
        scene.vary(load=of_loads, rig=Rig()), x=[0.0], effects=TILTED, fields="dissipation"
    )
    assert solution.dissipation == pytest.approx(given.dissipation, rel=tolerance)
    without = replace(TILTED, tilt_under_shear=ZERO_ESTIMATE, strain_under_pressure=ZERO_ESTIMATE)
    even = semi_analytic.solve(given.scene, x=[0.0], effects=without, fields="dissipation")
    assert abs(even.dissipation / given.dissipation - 1) > 3 * tolerance
    assert math.isnan(solution.loop_work)
    assert any("change U of a parabola by the moment" in note for note in solution.record.notes)


def test_where_the_bodies_slide_tilt_is_left_out_of_the_work_and_said() -> None:
    load = PolygonLoad(
        initial_loading=((90.0, 0.0),),
        cycle=((90.0, 6e-3), (90.0, -6e-3)),
        tangential_displacement=True,
    )
    fields = ("dissipation",)
    scene = tilting(load, Rig())
    solution = semi_analytic.solve(scene, x=[0.0], effects=TILTED, fields=fields)
    left_out = [note for note in solution.record.notes if "left out" in note]
    assert len(left_out) == 2
    assert all("the bodies slide as a whole" in note for note in left_out)
    assert math.isnan(solution.record.errors["dissipation"])  # by how much is not known


def test_where_one_side_slips_alone_grids_add_what_tilt_makes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of the work without it, with the grids' uncertainty; and said."""
    scene = tilting(DRIVEN_WAVE, Rig())
    declined = Mock(side_effect=DeclinedError("one side slips alone"))
    monkeypatch.setattr(answer_of_rig, "second_order_answer_of_rig", declined)
    by_grids = Mock(return_value=Estimate(0.1, 0.02))
    monkeypatch.setattr(corrected, "change_by_tilt_and_strain", by_grids)
    fields = ("dissipation",)
    tilted = semi_analytic.solve(scene, x=[0.0], effects=TILTED, fields=fields)
    by_grids.side_effect = InputError("no grid takes it")
    without = semi_analytic.solve(scene, x=[0.0], effects=TILTED, fields=fields)
    assert tilted.dissipation == pytest.approx(1.1 * without.dissipation, rel=1e-3)
    assert 0.02 / 1.1 < tilted.record.errors["dissipation"] < 0.03
    assert math.isnan(without.record.errors["dissipation"])
    assert any("on grids" in note for note in tilted.record.notes)
    assert any("one side slips alone" in note for note in without.record.notes)
    loads = by_grids.call_args.args[0].load
    assert isinstance(loads, HarmonicLoad)


# ----------------------------------------------------------------------------- rigs of the library
@pytest.mark.parametrize("name", rig_names())
def test_theory_meets_what_rigs_of_the_library_expect(name: str) -> None:
    """Of bodies to the goal of the finite elements, 5e-3; slides are counted or there are none."""
    scene = load_scene(name)
    effects = None if scene.bodies.half_planes else halfplane_fe.body_effects(scene)
    fields = ("dissipation",)
    solution = semi_analytic.solve(scene, x=[0.0], fields=fields, effects=effects)
    findings = list(expected_numbers(scene, [solution]))
    if effects is None:
        assert len(findings) >= 2
        assert all(finding.is_met for finding in findings)
    else:
        expected = [entry.value for entry in scene.expected if entry.quantity == "dissipation"]
        assert solution.dissipation == pytest.approx(expected[0], rel=5e-3)
    slides = [note for note in solution.record.notes if "slide as a whole by" in note]
    assert len(slides) == ("gross-sliding" in scene.tags)


# --------------------------------------------------------------------------------- fretting map
def test_a_map_has_the_closed_form_on_either_side_of_gross_sliding() -> None:
    """Partial below U_s, gross above it, and W of `solve` in both."""
    load = PolygonLoad(
        initial_loading=((90.0, 0.0),),
        cycle=((90.0, 1e-3), (90.0, -1e-3)),
        tangential_displacement=True,
    )
    scene = rig_scene(load)
    at_limit = 2 / (math.pi * MODULUS_OF_STEEL) * 45.0 * (math.log(2 * 50.0 / 0.99655750) + 0.5)
    factors = np.array([0.5, 0.999, 1.001, 3.0]) * at_limit / 1e-3
    found = semi_analytic.fretting_map(scene, factors[:, None], [1.0, 4.0])
    assert found.regime[:, 0].tolist() == [0, 0, 2, 2]
    assert found.regime[:, 1].tolist() == [0, 0, 0, 0]
    slide = 4 * (factors[3] * 1e-3 - at_limit)
    assert found.slide[3, 0] == pytest.approx(slide, rel=1e-6)
    assert found.largest_tangential_load[2:, 0] == pytest.approx([45.0, 45.0], rel=1e-12)
    driven_load = {"cycle": ((90.0, 3 * at_limit), (90.0, -3 * at_limit))}
    whole = semi_analytic.solve(scene.vary(load=driven_load), x=[0.0], fields="dissipation")
    assert found.dissipation[3, 0] == pytest.approx(whole.dissipation, rel=1e-9)


def test_a_first_stroke_beyond_the_others_is_the_mixed_regime() -> None:
    load = PolygonLoad(
        initial_loading=((90.0, 0.0), (90.0, 5e-3), (90.0, 0.0)),
        cycle=((90.0, 4e-4),),
        tangential_displacement=True,
    )
    found = semi_analytic.fretting_map(rig_scene(load), [0.1, 1.0])
    assert found.regime.tolist() == [0, 1]
    assert found.slide.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("scene", "stroke", "words"),
    [
        (load_scene("cattaneo-mindlin"), 1.0, "states loads"),
        (rig_scene(), 0.0, "factors are above 0"),
        (rig_scene().vary(load={"cycle": ()}), 1.0, "does not repeat"),
    ],
)
def test_a_map_of_something_else_is_refused(scene: Scene, stroke: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        semi_analytic.fretting_map(scene, stroke)


def test_the_cone_is_met_where_bodies_slide_while_the_normal_load_grows() -> None:
    """The curvature of the faces follows Q, and all of the contact slides nevertheless."""
    scene = load_scene("blocks").vary(
        expected=(),
        tolerances={},
        friction=0.1,
        load={
            "kind": "time_series",
            "rows": [[0, 30, -1e-4], [1, 60, -8e-4], [2, 40, -4e-4], [3, 90, 4e-4]],
            "tangential_displacement": True,
        },
    )
    solution = semi_analytic.solve(scene, effects=EFFECTS)
    assert np.max(solution.record.certificates["cone"]) < 1e-9
    assert np.max(solution.record.certificates["tangential_balance"]) < 1e-9
    slid = np.isnan(solution.stick_half_width) & (solution.normal_load > 0)
    assert 20 < np.count_nonzero(slid) < len(slid) - 20
    area = np.trapezoid(solution.dissipation_density, solution.x)
    assert area == pytest.approx(solution.dissipation, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [4.8e-4, 3.3e-3])
def test_the_stated_error_covers_that_of_the_steps(amplitude: float) -> None:
    """Partial slip, and slides that end between two turning points of the path."""
    load = EllipseLoad(
        mean_normal_load=90.0,
        normal_amplitude=45.0,
        tangential_displacement={"amplitude": amplitude, "phase_degrees": 60.0},
    )
    scene = load_scene("cattaneo-mindlin").vary(
        expected=(), tolerances={}, load=load, rig={"datum_length": 50.0}
    )
    solution = semi_analytic.solve(scene, x=[0.0], fields="dissipation")
    fine = rigged_scene(scene, None).follow(2, 12)
    work = fine.work(slice(fine.end_rows[1], fine.end_rows[2] + 1))
    error = solution.record.errors["dissipation"]
    assert error < 2e-3
    assert solution.dissipation == pytest.approx(work, rel=error)
