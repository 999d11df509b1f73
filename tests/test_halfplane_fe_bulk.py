"""Bulk stress, tilt and moment in finite elements: exact rows, invariances, the energy balance,
blocks against bars, refusals.

# notation: E* = 1 of two like bodies with E = 2 and nu = 0, R = 1, so that a stress of 2 eps in the
lower body is the strain eps.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import (
    FiniteElementSolution,
    SolverSettings,
    body_fields,
    edge_tension,
    fields,
    stress,
)
from halfplane_fe.contact import ContactProblem
from halfplane_fe.elasticity import assemble, condense, displacement_by_unit_stress
from meshes import BodyMesh, MeshSettings, SurfaceGrading, half_disc, solid
from scenes import (
    Block,
    Bodies,
    Cylinder,
    Elastic,
    EllipseLoad,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    Pad,
    PolygonLoad,
    Scene,
    Tabulated,
    load_scene,
)

UNIT = Elastic(young_modulus=2.0, poisson_ratio=0.0)
STEEL = Elastic(young_modulus=2.0, poisson_ratio=0.3)
SOFT = Elastic(young_modulus=1.0, poisson_ratio=0.2)
UNLIKE = Materials(upper=SOFT, lower=STEEL)
ROUGH = MeshSettings(element_size=1 / 8, edge_element_size=1 / 16, far_radius=6.0, growth=0.5)
FEW = MeshSettings(element_size=1 / 6, edge_element_size=1 / 8, far_radius=6.0, growth=0.5)
# None halved for its step error, and 17 a cycle: rounding would choose other increments of a
# reflected load.
REGULAR = SolverSettings(steps_per_cycle=17, step_tolerance=np.inf)
ROLLERS = Block(width=16.0, height=4.0, base="rollers")
FIXED = Block(width=16.0, height=4.0)
A0 = 1.9544100476  # a(P = 3)


def scene(
    load: Any, friction: float = 1.0, cycles: int = 3, material: Any = UNIT, **parts: Any
) -> Scene:
    profile = parts.pop("profile", Hertz(radius=1.0))
    coefficient = {"coefficient": friction}
    return Scene(
        name="bulk",
        profile=profile,
        material=material,
        friction=coefficient,
        load=load,
        cycles=cycles,
        **parts,
    )


def ellipse(
    p: tuple[float, float], q: tuple[float, float], phase: float, **further: Any
) -> EllipseLoad:
    names = ("mean_normal_load", "normal_amplitude", "mean_tangential_load", "tangential_amplitude")
    return EllipseLoad(**dict(zip(names, (*p, *q), strict=True)), phase_degrees=phase, **further)


def wave(mean: float, amplitude: float, phase: float = 0.0) -> dict[str, float]:
    return {"mean": mean, "amplitude": amplitude, "phase_degrees": phase}


@functools.cache
def solved(
    question: Scene, mesh: MeshSettings = FEW, settings: SolverSettings = REGULAR
) -> halfplane_fe.FiniteElementSolution:
    return halfplane_fe.solve(question, mesh, settings)


# ----------------------------------------------------------------------------- exact values, E* = 1


TILTED_FLAT = FlatRounded(radius=1.0, flat_half_length=0.5)
ROWS = {
    "1": scene(PolygonLoad(initial_loading=[(3, 0), (3, 1.8)], bulk_stress_lower=[0, 0.4])),
    "2": scene(
        PolygonLoad(
            initial_loading=[(3, 0), (3, 1.8)], cycle=[(3, -1.8)], bulk_stress_lower=[0, 0.6, -0.6]
        )
    ),
    "2, upper": scene(
        PolygonLoad(
            initial_loading=[(3, 0), (3, 1.8)], cycle=[(3, -1.8)], bulk_stress_upper=[0, -0.6, 0.6]
        )
    ),
    "4": scene(PolygonLoad(initial_loading=[(3, 0), (3, 0.9)], bulk_stress_lower=[0, 2.0])),
    "5": scene(
        ellipse((3, 1), (1.1, 1), 90, tilt=wave(0.3, 0.1), bulk_stress_lower=wave(0.22, 0.2, 90))
    ),
    "6": scene(
        ellipse((3, 0.6), (0.2, 1.4), 0, tilt=wave(0.1, 0.08), bulk_stress_lower=wave(0.2, 0.3))
    ),
    "7": scene(ellipse((3, 1), (1.1, 1), 90, bulk_stress_lower=wave(0, 0.5, 90)), cycles=6),
    "8": scene(ellipse((3, 1), (1.1, 1), 90, tilt=wave(0, 0.06, 90)), cycles=6),
    "9": scene(PolygonLoad(initial_loading=[(1, 0)], tilt=[0.2]), profile=TILTED_FLAT),
    "9, moment": scene(
        PolygonLoad(initial_loading=[(1, 0)], moment=[-0.3444188480137]), profile=TILTED_FLAT
    ),
}
WORK = {
    "2": 0.9368781396315213,
    "2, upper": 0.9368781396315213,
    "5": 0.32380811606118304,
    "6": 0.25922505566470,
    "7": 0.38684,
    "8": 0.25985,
}
STICK = {
    "1": (0.2 - 1.2360774475, 0.2 + 1.2360774475),
    "4": (-0.7063363748151722, 1.4493185287005215),
}
PERMANENT = {
    "5": (-0.158578644 - 1.420945461, -0.158578644 + 1.420945461),
    "6": (-0.704713575642 * A0, 0.755879911039 * A0),
    "7": (-0.62681 * A0, 0.80026 * A0),
    "8": (-0.72632 * A0, 0.72632 * A0),
}
CONTACT = dict.fromkeys(("9", "9, moment"), (-1.7331629996, 1.2194927292))
# On elements of a/16, and of a/160 (the default): error of W, of edges over an element, of contact,
# moment or tilt over 1.
LIMITS = {"rough": (6e-3, 1.0, 5e-3, 6e-4), "default": (1e-3, 1.0, 3e-4, 3e-5)}


@pytest.mark.parametrize("mesh", ["rough", pytest.param("default", marks=pytest.mark.slow)])
@pytest.mark.parametrize("row", ROWS)
def test_exact_rows(row: str, mesh: str) -> None:
    answer = (
        solved(ROWS[row], ROUGH, SolverSettings())
        if mesh == "rough"
        else halfplane_fe.solve(ROWS[row])
    )
    work, edge, contact, turned = LIMITS[mesh]
    element = answer.settings["element_size"]
    assert answer.moment is not None
    assert answer.tilt is not None
    assert answer.permanent_stick_edges is not None
    if row in WORK:
        assert answer.dissipation == pytest.approx(WORK[row], rel=work)
    # in phase the second cycle repeats: the loop with the moment of shear, -m_q d(eps), to rounding
    if row in ("2", "6"):
        assert answer.steady_from is not None
        assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-12)
    if row in STICK:
        np.testing.assert_allclose(answer.stick_edges[-1], STICK[row], atol=edge * element)
    if row in PERMANENT:
        np.testing.assert_allclose(
            answer.permanent_stick_edges, PERMANENT[row], atol=edge * element
        )
        assert answer.permanent_stick_half_width == pytest.approx(
            np.diff(answer.permanent_stick_edges)[0] / 2, rel=1e-12
        )
    if row in CONTACT:
        np.testing.assert_allclose(answer.contact_edges[-1], CONTACT[row], atol=contact)
        np.testing.assert_allclose(
            [answer.moment[-1], answer.tilt[-1]], [-0.3444188480137, 0.2], atol=turned
        )


def test_out_of_phase_the_loop_has_the_area_of_the_work_too() -> None:
    """The curve of the loads adds work of p in bulk stress and tilt, none of q: with the shear in
    it the loop is 1.5e-3 too large. Measured 6e-7, by which the last cycle is not quite steady.
    """
    answer = solved(scene(MIXED).vary(cycles=4))
    assert answer.steady_from is not None
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=5e-6)


# -------------------------------------------------------------------------------------- invariances


def numbers(
    answer: halfplane_fe.FiniteElementSolution, side: int = 1, turned: int = 1
) -> dict[str, np.ndarray]:
    """An answer, reflected in x = 0 for side = -1, its shear turned round for turned = -1."""
    sign = side * turned
    assert answer.permanent_stick_edges is not None
    assert answer.tilt is not None
    edges = {name: getattr(answer, name)[-1] * side for name in ("contact_edges", "stick_edges")}
    edges["permanent"] = answer.permanent_stick_edges * side
    return {
        "W": np.array(answer.cycle_dissipation),
        "p": answer.pressure[-1, ::side],
        "q": answer.shear[-1, ::side] * sign,
        "W(x)": answer.dissipation_density[::side],
        "U": answer.tangential_displacement[-1:] * sign,
        "delta": answer.normal_approach[-1:],
        **{name: np.sort(values) for name, values in edges.items()},
    }


def turned_keys(load: EllipseLoad, keys: tuple[str, ...]) -> EllipseLoad:
    """The load with the signs of these keys turned round; of Q and of waves by mean and half a
    turn.
    """
    changes: dict[str, Any] = {}
    for key in keys:
        if key == "Q":
            changes |= {
                "mean_tangential_load": -load.mean_tangential_load,
                "phase_degrees": load.phase_degrees - 180,
            }
        elif (value := getattr(load, key)) is not None:
            changes[key] = wave(-value.mean, value.amplitude, value.phase_degrees - 180)
    return load.model_copy(update={}).__class__.model_validate(load.model_dump() | changes)


BASE = {"p": (3, 0.6), "q": (0.2, 1.2), "phase": 60}
MIXED = ellipse(**BASE, bulk_stress_lower=wave(0.2, 0.3, 100), tilt=wave(0.1, 0.08, 30))
MOMENT = ellipse(**BASE, bulk_stress_upper=wave(0.2, 0.3, 100), moment=wave(0.3, 0.2, 30))
# x -> -x turns Q and the tilt, a stress is a stress from either side
MIRROR = ("Q", "tilt", "moment")
HELD = wave(0.4, 0.6, 20)
SLOW = pytest.mark.slow
LOWER = scene(ellipse(**BASE, bulk_stress_lower=wave(0.2, 0.3, 20)))
HALVES = ellipse(
    **BASE, bulk_stress_lower=wave(0.1, 0.15, 20), bulk_stress_upper=wave(-0.1, 0.15, -160)
)


def unequal(load: Any, left: float, right: float) -> Scene:
    """A parabola of one radius on either side."""
    x = np.linspace(-4, 4, 81)
    h = x**2 / (2 * np.where(x < 0, left, right))
    return scene(load, profile=Tabulated(points=np.stack([x, h], axis=1).tolist(), symmetric=False))


def same_strain(size: dict[str, float]) -> Scene:
    return scene(ellipse(**BASE, bulk_stress_lower=size, bulk_stress_upper=size))


# Two scenes, the side and the sense of shear that the second one has turned round, and how near
# they come.
SAME: dict[str, tuple[Scene, Scene, int, int, float]] = {
    "reflected": (scene(MIXED), scene(turned_keys(MIXED, MIRROR)), -1, 1, 1e-7),
    "reflected, unlike": (
        scene(MIXED, material=UNLIKE),
        scene(turned_keys(MIXED, MIRROR), material=UNLIKE),
        -1,
        1,
        1e-7,
    ),
    "reflected, moment": (scene(MOMENT), scene(turned_keys(MOMENT, MIRROR)), -1, 1, 1e-7),
    # Friction has no preferred side: Q and all bulk stress turned, nothing else.
    "shear turned": (
        scene(MIXED),
        scene(turned_keys(MIXED, ("Q", "bulk_stress_lower"))),
        1,
        -1,
        1e-7,
    ),
    # Half a turn of the whole picture: lower and upper body change places, x is -x, P, Q and the
    # stresses are what they were.
    "upside down": (
        scene(ellipse(**BASE, bulk_stress_lower=HELD), material=UNLIKE, bodies=Bodies(lower=FIXED)),
        scene(
            ellipse(**BASE, bulk_stress_upper=HELD),
            material=Materials(upper=STEEL, lower=SOFT),
            bodies=Bodies(upper=FIXED),
        ),
        -1,
        -1,
        1e-8,
    ),
    "unequal sides": (
        unequal(ellipse((2, 0.4), (0.1, 0.8), 60), 1, 2),
        unequal(turned_keys(ellipse((2, 0.4), (0.1, 0.8), 60), ("Q",)), 2, 1),
        -1,
        1,
        1e-7,
    ),
    # Only the difference of strains counts; a stress that turns ends an increment there, in both
    # bodies too.
    "of the upper body": (
        LOWER,
        scene(ellipse(**BASE, bulk_stress_upper=wave(-0.2, 0.3, -160))),
        1,
        1,
        1e-9,
    ),
    "half in each": (LOWER, scene(HALVES), 1, 1, 1e-9),
    "one strain in both": (same_strain(wave(0.4, 0.3, 20)), same_strain(wave(0, 0)), 1, 1, 1e-3),
}
AT_ONCE = ("reflected", "shear turned", "upside down")


@pytest.mark.parametrize(
    "name", [name if name in AT_ONCE else pytest.param(name, marks=SLOW) for name in SAME]
)
def test_two_scenes_that_are_one_have_one_answer(name: str) -> None:
    first, second, side, sense, room = SAME[name]
    first_numbers = numbers(solved(first))
    second_numbers = numbers(solved(second), side, sense)
    for field, values in first_numbers.items():
        np.testing.assert_allclose(
            second_numbers[field],
            values,
            rtol=room,
            atol=room * max(np.abs(values).max(), 1),
            err_msg=field,
        )
    if first is LOWER or "unequal" in name:  # and the change is one that counts
        plain = solved(same_strain(wave(0, 0))).dissipation
        assert abs(first_numbers["W"][-1] / plain - 1) > 0.1


# ------------------------------------------------------------------------------------------- energy


TURNING = {"bulk_stress_lower": wave(0.2, 0.3), "tilt": wave(0.1, 0.08, 40)}
PADS = {
    "profile": Hertz(radius=12.0),
    "bodies": Bodies(lower=FIXED, upper=Pad(width=9.0, height=5.0)),
}
BALANCED = {
    "half-planes": ((3, 0.6), (0.2, 1.4), TURNING, UNIT, {}),
    "unlike, moment": (
        (3, 0.6),
        (0.2, 1.4),
        TURNING | {"tilt": None, "moment": wave(0.3, 0.2)},
        UNLIKE,
        {},
    ),
    "specimen on rollers": (
        (3, 0.6),
        (0.2, 1.4),
        TURNING,
        STEEL,
        {"bodies": Bodies(lower=ROLLERS)},
    ),
    "two of them, unlike": (
        (3, 0.6),
        (0.2, 1.4),
        TURNING,
        UNLIKE,
        {"bodies": Bodies(lower=ROLLERS, upper=ROLLERS)},
    ),
    "fixed block": ((3, 0.6), (0.2, 1.4), TURNING, STEEL, {"bodies": Bodies(lower=FIXED)}),
    "pad, line of action": (
        (0.3, 0.1),
        (0.02, 0.1),
        {"bulk_stress_lower": wave(0.02, 0.03), "line_of_action": {"x": 0.1, "height": 0.3}},
        STEEL,
        PADS,
    ),
}


@pytest.mark.parametrize("name", BALANCED)
def test_energy_balances_to_rounding_and_every_law_is_kept(name: str) -> None:
    """Of each increment; the closed integral of Q dU - m_q d(eps) is W where nothing couples p to
    slip.
    """
    p, q, further, material, parts = BALANCED[name]
    answer = solved(scene(ellipse(p, q, 25, **further), material=material, cycles=2, **parts))
    assert float(answer.record.certificates["energy_balance"].max()) < 1e-13
    assert max(float(values.max()) for values in answer.record.certificates.values()) < 1e-9
    assert answer.dissipation > 0
    assert any("jumps by Q/H" in note for note in answer.record.notes) == (
        "rollers" in name or "two" in name
    )
    assert any("its fixed base holds back a part" in note for note in answer.record.notes) == (
        "fixed" in name or "pad" in name
    )


def test_the_tilt_under_a_moment_is_found_without_newtons_iteration_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Pressure and shear in turn, the tilt by the moment of the pressure: the fallback where
    Newton's iteration finds no set.
    """
    question = scene(
        PolygonLoad(
            initial_loading=[(3, 0), (3, 1.2)], moment=[-0.3, -0.3], bulk_stress_lower=[0, 0.2]
        )
    )
    newton = solved(question)
    active_set = ContactProblem._solve_by_active_set

    def none(self: ContactProblem, states: np.ndarray, *rest: Any) -> Any:
        return (None, 1, 0) if self.has_shear else active_set(self, states, *rest)

    monkeypatch.setattr(ContactProblem, "_solve_by_active_set", none)
    halves = halfplane_fe.solve(question, FEW, REGULAR)
    assert halves.work.counts["alternating solves"] > 0
    for name in ("tilt", "contact_edges", "tangential_displacement"):
        np.testing.assert_allclose(
            getattr(halves, name), getattr(newton, name), rtol=0, atol=1e-9, err_msg=name
        )
    assert np.abs(newton.tilt).max() > 0.05


# ------------------------------------------------------------------------------------------- bodies


GRADING = SurfaceGrading(inner=0.0, outer=1.0, size=0.25, edge_size=0.25, radius=4.0)


def block(base: str, width: float, height: float, outer: float = 1.0) -> BodyMesh:
    grading = replace(GRADING, outer=outer, size=outer / 8, edge_size=outer / 8)
    body = solid(
        "lower", Block(width=width, height=height, base=base), Hertz(radius=1.0), grading, 0.4
    )
    return replace(body, supports={**body.supports, "sides": "pulled"})


def test_a_half_plane_under_stress_moves_as_a_uniform_field_exactly() -> None:
    """(x, -nu/(1 - nu) y)/E' at the contact; and the elements hold it: no force is left on any node
    off the arc.
    """
    body = half_disc("lower", GRADING, 0.5)
    system = assemble(body, STEEL)
    condensed_body = condense(body, STEEL, 4.0)
    np.testing.assert_allclose(
        condensed_body.displacement_by_stress,
        [condensed_body.x * 0.91 / 2, 0 * condensed_body.x],
        atol=1e-15,
    )
    places = system.basis.doflocs
    x_dofs = np.isin(np.arange(system.basis.N), system.basis.get_dofs(elements=True).all(["u^1"]))
    along, outward = displacement_by_unit_stress(STEEL, *places)
    np.testing.assert_allclose(outward, -0.3 / 0.7 * 0.91 / 2 * places[1], atol=1e-15)
    forces = system.stiffness @ np.where(x_dofs, along, outward)
    off = np.setdiff1d(np.arange(len(forces)), system.reaction_dofs.ravel())
    assert np.abs(forces[off]).max() < 1e-13
    right = system.reaction_dofs[0][places[0, system.reaction_dofs[0]] > 0]
    # stress 1 over the depth, but for half a node on the axis
    assert forces[right].sum() == pytest.approx(4.0, abs=0.3)


def test_a_specimen_on_rollers_stretches_uniformly_and_thins() -> None:
    condensed_body = condense(block("rollers", 16.0, 3.0), STEEL, 1.0)
    np.testing.assert_allclose(
        condensed_body.displacement_by_stress,
        displacement_by_unit_stress(STEEL, condensed_body.x, 0 * condensed_body.x + 3.0),
        atol=1e-10,
    )


# ------------------------------------------------------------------------------------------- fields


def test_stress_has_the_bulk_stress_in_it() -> None:
    """Two loads that differ by one strain in both bodies have the same tractions, and stresses that
    differ by the stress alone.
    """
    base = {"p": (3, 0.6), "q": (0.2, 1.2), "phase": 60}
    pulled, none = (
        solved(
            scene(
                ellipse(
                    **base,
                    **dict.fromkeys(("bulk_stress_lower", "bulk_stress_upper"), wave(size, 0.0)),
                ),
                material=STEEL,
            )
        )
        for size in (0.4, 0.0)
    )
    instant = [pulled.time[-1]]
    for body in (0, 1):
        pulled_body, plain_body = (
            fields(answer, instant)[0].bodies[body] for answer in (pulled, none)
        )
        np.testing.assert_allclose(
            pulled_body.stress - plain_body.stress,
            np.tile([0.4, 0, 0, 0.12], (len(pulled_body.stress), 1)),
            atol=1e-6,
        )
        np.testing.assert_allclose(
            pulled_body.edge_tension - plain_body.edge_tension, 0.4, atol=1e-6
        )
    tension, without = (
        edge_tension(answer, [len(answer.time) - 1])[0] for answer in (pulled, none)
    )
    np.testing.assert_allclose(tension - without, 0.4, atol=1e-6)
    deep = [stress(answer, [0.3], [-1.0], instant)[0, 0] for answer in (pulled, none)]
    np.testing.assert_allclose(deep[0] - deep[1], [0.4, 0, 0, 0.12], atol=1e-6)


def test_stress_in_a_specimen_jumps_by_the_shear_force_over_its_height() -> None:
    """Far from the contact sigma -+ Q/2H, uniform over the height."""
    long = Block(width=60.0, height=4.0, base="rollers")
    load = PolygonLoad(initial_loading=[(3, 0), (3, 1.8)], bulk_stress_lower=[0, 0.4])
    answer = solved(scene(load, material=STEEL, bodies=Bodies(lower=long)))
    (snapshot,) = fields(answer, [answer.time[-1]])
    lower = snapshot.bodies[0]
    for side in (-1, 1):
        far = np.abs(lower.points[:, 0] - side * 20) < 4
        assert far.sum() > 4
        np.testing.assert_allclose(lower.stress[far, 0], 0.4 - side * 1.8 / 8, atol=6e-3)
    tension = edge_tension(answer, [len(answer.time) - 1])[0]
    np.testing.assert_allclose(tension[0, 0], lower.edge_tension, rtol=1e-2)
    assert any("jumps by Q/H, 0.45" in note for note in answer.record.notes)


def test_bulk_stress_counts_once_in_the_tension_of_a_specimen() -> None:
    """What it changes at both edges is what theory says of a half-plane: 0.45 and 0.47."""
    high = Bodies(lower=Block(width=60.0, height=12.0, base="rollers"))
    of_specimen = []
    of_theory = []
    for bulk_stress in (0.0, 0.4):
        load = PolygonLoad(initial_loading=[(3, 0), (3, 1.8)], bulk_stress_lower=[0, bulk_stress])
        specimen = scene(load, material=STEEL, bodies=high)
        answer = solved(specimen)
        of_specimen.append(edge_tension(answer, [len(answer.time) - 1])[0][0, 0])
        of_theory.append(semi_analytic.edge_tension(specimen, answer.time[-1])[0][0, 0])
    np.testing.assert_allclose(np.diff(of_specimen, axis=0), np.diff(of_theory, axis=0), atol=0.02)


# ----------------------------------------------------------------------------------------- refusals


def refused(
    words: str, load: dict[str, Any], force: float = 0.1, **parts: Any
) -> tuple[Scene, str]:
    loading = [(0.3, 0), (0.3, force)] if force else [(0.3, 0)]
    return (
        scene(
            PolygonLoad(initial_loading=loading, **load),
            profile=parts.pop("profile", Hertz(radius=30.0)),
            **parts,
        ),
        words,
    )


LOWER_PULLED = {"bulk_stress_lower": [0.0, 0.4]}
SIDES = [[x, x**2 / 60 if x < 0 else x**2 / 90] for x in np.linspace(-6, 6, 61).tolist()]
REFUSED = {
    "cylinder": refused(
        "nothing pulls the ends of the lower body, a cylinder",
        LOWER_PULLED,
        bodies=Bodies(lower=Cylinder(radius=30.0)),
    ),
    "pad": refused(
        "of the upper body, a pad; half-planes take",
        {"bulk_stress_upper": [0.0, 0.4]},
        bodies=Bodies(upper=Pad(width=6.0, height=9.0)),
    ),
    "guided": refused(
        "a block with guided sides; half-planes take",
        LOWER_PULLED,
        bodies=Bodies(lower=Block(width=30.0, height=9.0, sides="guided")),
    ),
    "slides off": refused(
        "nothing holds the block against",
        {},
        bodies=Bodies(lower=Block(width=30.0, height=9.0, base="rollers")),
    ),
    "a line of action beside the faces": refused(
        "its line of action meets the faces beside",
        {"line_of_action": {"x": 9.0}},
        force=0,
        profile=Hertz(radius=1.0),
        bodies=Bodies(lower=Block(width=16.0, height=9.0)),
    ),
    "unequal sides of a pad": refused(
        "symmetric = false goes with half-planes and blocks",
        {},
        force=0,
        profile=Tabulated(points=SIDES, symmetric=False),
        bodies=Bodies(upper=Pad(width=8.0, height=9.0)),
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_pulled_is_refused_in_a_sentence(name: str) -> None:
    question, sentence = REFUSED[name]
    with pytest.raises(InputError, match=sentence):
        halfplane_fe.solve(question, ROUGH)


def out_of_phase() -> Scene:
    """Constant P, near sliding; bulk stress whose phase is not that of Q."""
    wave = {"mean": 0.0, "amplitude": 20.0, "phase_degrees": 90.0}
    load = {
        "normal_amplitude": 0.0,
        "mean_normal_load": 90.6,
        "mean_tangential_load": 0.0,
        "tangential_amplitude": 6.1,
        "phase_degrees": 33.0,
        "initial_loading": "straight",
        "bulk_stress_lower": wave,
    }
    return load_scene("hertz-paper").vary(friction=0.07, load=load)


def test_slip_that_ends_within_an_increment_hardly_changes_displacement_and_work() -> None:
    """Lost slip of 5e-4 of W moved U by 5e-5 of its range, and W by 1.1e-3."""
    answer, on_short_increments = (
        halfplane_fe.solve(
            out_of_phase(), MeshSettings.coarse(), SolverSettings(step_tolerance=tolerance)
        )
        for tolerance in (5e-4, 1e-5)
    )
    ranges = [np.ptp(run.tangential_displacement) for run in (answer, on_short_increments)]
    assert ranges[0] == pytest.approx(ranges[1], rel=1e-6)
    assert answer.dissipation == pytest.approx(on_short_increments.dissipation, rel=6e-4)


def test_near_sliding_what_a_few_nodes_lose_is_not_lost_by_all() -> None:
    """At 0.997 of the Coulomb limit nodes at one edge stopped within an increment, and held back
    the whole contact: W was 1e-4 too small on the coarse mesh, 6e-4 on the default one.
    """
    scene = out_of_phase()
    load = scene.load.model_dump(mode="json", exclude_none=True)
    load |= {"tangential_amplitude": 0.997 * 0.062 * 90.6, "phase_degrees": 52.1}
    load["bulk_stress_lower"] |= {"amplitude": 6.79}
    scene = scene.vary(friction=0.062, load=load)
    work, work_of_short_increments = (
        halfplane_fe.solve(
            scene, MeshSettings.coarse(), SolverSettings(step_tolerance=tolerance)
        ).dissipation
        for tolerance in (5e-4, 1.5e-5)
    )
    assert work == pytest.approx(work_of_short_increments, rel=5e-6)


def test_a_largest_tension_after_slip_has_turned_is_uncertain_by_how_far_it_exceeds_one_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bulk stress rises on after the slip at the edge has turned round in a zone of no node: then
    the value before counts, uncertain by how far the tension is larger afterwards.
    """
    answer = halfplane_fe.solve(out_of_phase(), MeshSettings.coarse())
    largest = halfplane_fe.largest_edge_tension(answer)
    steps = body_fields._steps_of_large_tension(answer)
    values, _ = halfplane_fe.edge_tension(answer, steps)
    highest = np.reshape(values, (len(steps), -1)).max(axis=1)
    may_slip_unseen = highest > largest.value - 0.05
    assert 0 < np.count_nonzero(may_slip_unseen) < len(steps)
    uncertainties = np.where(may_slip_unseen, 50.0, 0.01)
    monkeypatch.setattr(
        body_fields._Candidates,
        "uncertainty_by_tractions",
        lambda _candidates, number, _change: np.full(2, uncertainties[number]),
    )
    uncertain = halfplane_fe.largest_edge_tension(answer)
    before = highest[~may_slip_unseen].max()
    assert uncertain.value == before
    assert uncertain.uncertainty == pytest.approx(0.01 + highest.max() - before)


@functools.cache
def bronze_pad_on_steel() -> FiniteElementSolution:
    """A flat pad with rounded edges on a block, inches and psi, on the default mesh."""
    polygon = {
        "kind": "polygon",
        "initial_loading": [[3000.0, 0.0]],
        "cycle": [[4000.0, 500.0], [2500.0, -300.0]],
    }
    bronze = {"young_modulus": 16e6, "poisson_ratio": 0.34}
    steel = {"young_modulus": 30e6, "poisson_ratio": 0.29}
    scene = load_scene("flat-pad-on-block").vary(
        material={"upper": bronze, "lower": steel},
        profile={"kind": "flat_rounded", "flat_half_length": 0.08, "radius": 2.0},
        friction=0.25,
        load=polygon,
        bodies={
            "lower": {"kind": "block", "width": 2.0, "height": 1.0},
            "upper": {"kind": "pad", "width": 0.6, "height": 0.5},
        },
    )
    return halfplane_fe.solve(scene)


def test_the_largest_tension_of_unlike_bodies_is_that_at_the_turn_of_the_loads() -> None:
    """Just after the turn the new slip zone is narrower than an element. There the tension was
    22448 +- 1064, at the turn it is 22420 +- 172.
    """
    answer = bronze_pad_on_steel()
    largest = halfplane_fe.largest_edge_tension(answer)
    turn = int(np.searchsorted(answer.time, largest.time))
    assert (answer.normal_load[turn], answer.tangential_load[turn]) == (4000.0, 500.0)
    values, uncertainties = halfplane_fe.edge_tension(answer, [turn])
    assert largest.value == pytest.approx(values.max(), rel=1e-4)
    assert largest.uncertainty > 0.9 * uncertainties.flat[np.argmax(values)]
    assert largest.uncertainty < 0.02 * largest.value


def test_the_shear_of_unlike_bodies_has_no_spike_where_surface_elements_grow() -> None:
    """Where sizes jumped by seven at the zone of the edges, a node stood 0.15 f p beside its
    neighbours; it is 0.016.
    """
    answer = bronze_pad_on_steel()
    row = int(np.searchsorted(answer.time, 1.0))  # the end of the initial loading
    in_stick = np.abs(answer.x) < 0.09
    shear = answer.shear[row, in_stick]
    beside_neighbours = np.abs(shear[1:-1] - (shear[:-2] + shear[2:]) / 2)
    coulomb_limit = 0.25 * 2 * 3000.0 / (math.pi * answer.contact_half_width.max())
    assert beside_neighbours.max() < 0.05 * coulomb_limit
