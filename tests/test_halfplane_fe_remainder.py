"""What finite bodies add to half-planes: against exact layers, against scikit-fem on structured
quadrilaterals, and against the compliance of the product's own contact model.

Each planted fault (a sign, a lost number, a body in the place of the other) is caught by the last
of these.
"""

from __future__ import annotations

import dataclasses
import functools
from collections import Counter

import numpy as np
import pytest
import skfem
from scipy.sparse.linalg import splu
from skfem.models.elasticity import lame_parameters, linear_elasticity

from halfplane_fe import remainder
from halfplane_fe.far_field import surface_force_displacement, surface_force_traction
from halfplane_fe.interface import Interface, condensed_pair, couple, meshed_pair
from halfplane_fe.remainder import (
    BodyNumbers,
    RemainderKernels,
    body_effects,
    body_numbers,
    face_kernels,
    face_series,
)
from layer_remainder import LayerNumbers, between_walls, layer, response
from meshes import MeshSettings, SurfaceGrading
from scenes import Block, Elastic, Estimate, Hertz, InputError, Materials, TShape, load_scene
from tolerances import TOLERANCES, check, check_order

PROFILE = Hertz(radius=1000.0)
NUMBERS = LayerNumbers._fields
LAYER = Block(width=20.0, height=1.0)
FAR_WALLS = Block(width=40.0, height=1.0, base="rollers", sides="guided")
T_SHAPE = TShape(width=4.0, flange_height=1.2, stem_width=2.4, height=2.4)
BETWEEN_WALLS = Block(width=3.0, height=1.0, base="rollers", sides="guided")


def plane(nu):
    """A material with E/(1 - nu^2) = 1."""
    return Elastic(young_modulus=1 - nu**2, poisson_ratio=nu)


@functools.cache
def numbers(shape, nu=0.3):
    return body_numbers("lower", shape, PROFILE, plane(nu), datum_length=1.0)


# ------------------------------------------------------------------------------------ exact answers
EXACT = {
    "layer, fixed": (LAYER, 0.3, layer(0.3)),
    "layer, fixed, nearly incompressible": (LAYER, 0.49, layer(0.49)),
    "between walls, on rollers": (BETWEEN_WALLS, 0.3, between_walls(3.0, 0.3)),
    "on rollers, walls far apart": (FAR_WALLS, 0.3, between_walls(40.0, 0.3)),
    "between walls, nu = 0.1": (BETWEEN_WALLS, 0.1, between_walls(3.0, 0.1)),
}


@pytest.mark.parametrize("case", EXACT)
def test_layers_and_blocks_between_walls_have_their_exact_numbers(case):
    """To a few 1e-5, where 5e-4 of N and 2e-3 of T are asked for; each stated uncertainty covers
    its error.
    """
    shape, nu, exact = EXACT[case]
    of_body = numbers(shape, nu)
    assert of_body.unknowns < 20_000
    for name in NUMBERS:
        value, uncertainty = getattr(of_body, name)
        truth = getattr(exact, name)
        check("body numbers", value / truth - 1)
        assert abs(value - truth) <= uncertainty + 1e-6 * abs(truth), name
        assert uncertainty <= 2e-3 * abs(truth), name


def test_the_error_falls_at_its_order():
    """The largest of all numbers, on meshes of elements four times, twice and once as large."""
    exact = np.array(between_walls(3.0, 0.3))
    sizes = (4.0, 2.0, 1.0)
    errors = []
    for coarser in sizes:
        kernels = face_kernels("lower", BETWEEN_WALLS, PROFILE, plane(0.3), 1.0, coarser)
        series = np.array(face_series(kernels)[: len(exact)])
        errors.append(np.abs(series / exact - 1).max())
    check_order("body numbers", sizes, errors)


@pytest.mark.parametrize("w", [0.05, 1.0, 4.0])
def test_the_exact_layer_is_that_of_the_closed_forms(w):
    """Johnson (1985), section 5.8, normal and tangential loads on a layer fixed to its base."""
    kappa = 3 - 4 * 0.3
    below = 2 * kappa * np.cosh(2 * w) + 1 + kappa**2 + 4 * w**2
    normal, _, tangential = response(w, "fixed", 0.3)
    assert normal == pytest.approx((2 * kappa * np.sinh(2 * w) - 4 * w) / below, rel=1e-9)
    assert tangential == pytest.approx((2 * kappa * np.sinh(2 * w) + 4 * w) / below, rel=1e-9)
    normal, _, tangential = response(w, "rollers", 0.3)
    below = 2 * w + np.sinh(2 * w)
    assert normal == pytest.approx((np.cosh(2 * w) - 1) / below, rel=1e-9)
    assert tangential == pytest.approx((np.cosh(2 * w) + 1) / below, rel=1e-9)


# -------------------------------------------------------- second route: structured quadrilaterals
def graded(start, end, count, ratio):
    """Points from `start` to `end`, each element `ratio` times as long as the next one."""
    lengths = ratio ** np.arange(count, 0.0, -1.0)
    return start + (end - start) * np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()


def quadrilateral_kernels(shape, material, x_of_forces, reach):
    """The kernels by scikit-fem's own elasticity, boundary integrals and quadratic quadrilaterals,
    graded to the corners of the base.
    """
    E, nu = material.young_modulus, material.poisson_ratio
    across = [graded(reach, shape.width / 2, 28, 1.15)]
    down = [graded(reach, shape.height, 28, 1.15)]
    step = getattr(shape, "step", None)
    if step is not None:  # small elements on either side of the re-entrant corner
        across = [
            graded(reach, step.half_width, 24, 1.2)[:-1],
            graded(shape.width / 2, step.half_width, 14, 1.3)[::-1],
        ]
        middle = (step.depth + shape.height) / 2
        down = [
            graded(reach, step.depth, 24, 1.2)[:-1],
            graded(middle, step.depth, 12, 1.3)[:0:-1],
            graded(middle, shape.height, 12, 1.3),
        ]
    right = np.concatenate([np.linspace(0.0, reach, 9)[:-1], *across])
    depths = np.concatenate([np.linspace(0.0, reach, 7)[:-1], *down])
    mesh = skfem.MeshQuad.init_tensor(np.concatenate([-right[:0:-1], right]), -depths[::-1])
    if step is not None:
        x, y = mesh.p[:, mesh.t].mean(axis=1)
        beside_stem = (np.abs(x) > step.half_width) & (y < -step.depth)
        mesh = mesh.remove_elements(np.flatnonzero(beside_stem))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()), intorder=4)
    stiffness = linear_elasticity(*lame_parameters(E, nu)).assemble(basis).tocsr()
    at_base = np.isclose(basis.doflocs[1], -shape.height)
    at_sides = np.isclose(np.abs(basis.doflocs[0]), shape.width / 2)
    along_y = np.isin(np.arange(basis.N), basis.get_dofs(elements=True).all(["u^2"]))
    rolls = getattr(shape, "base", "fixed") == "rollers"
    guided = getattr(shape, "sides", "free") == "guided"
    held = at_base & (along_y | (not rolls))
    held |= at_sides & ~along_y & guided
    outline = mesh.facets_satisfying(lambda x: x[1] < -1e-9 * shape.height, boundaries_only=True)
    facets = skfem.FacetBasis(mesh, basis.elem, facets=outline, intorder=12)
    at_face = np.isclose(basis.doflocs[1], 0.0) & (np.abs(basis.doflocs[0]) <= reach * (1 + 1e-9))
    face = [np.flatnonzero(at_face & (along_y == component)) for component in (False, True)]
    face = [dofs[np.argsort(basis.doflocs[0, dofs])] for dofs in face]
    factors = splu(stiffness[~held][:, ~held].tocsc(), permc_spec="MMD_AT_PLUS_A")
    answers = np.empty((2, 2, len(face[0]), len(x_of_forces)))  # along x and outward, by Q and by P
    for number, place in enumerate(x_of_forces):
        at = np.array([place])
        for load, (component, sign) in enumerate(((0, 1.0), (1, -1.0))):

            @skfem.LinearForm
            def tractions(v, w, at=at, component=component, sign=sign):
                traction = surface_force_traction(
                    w.x[0].ravel(), w.x[1].ravel(), w.n.reshape(2, -1), at
                )[:, :, component, 0].reshape(w.x.shape)
                return -sign * (traction[0] * v[0] + traction[1] * v[1])

            x, y = basis.doflocs[:, held]
            flamant = surface_force_displacement(x, y, at, E, nu, 1.0)[:, :, component, 0]
            solution = np.zeros(basis.N)
            solution[held] = -sign * np.where(along_y[held], flamant[1], flamant[0])
            rest = tractions.assemble(facets) - stiffness @ solution
            solution[~held] = factors.solve(rest[~held])
            answers[:, load, :, number] = solution[face[0]], solution[face[1]]
    return RemainderKernels(
        x=basis.doflocs[0, face[0]],
        x_of_forces=np.asarray(x_of_forces),
        inward_displacement_by_pressure=-answers[1, 1],
        x_displacement_by_shear=answers[0, 0],
        x_displacement_by_pressure=answers[0, 1],
        outward_displacement_by_shear=answers[1, 0],
        unknowns=int(np.count_nonzero(~held)),
    )


@pytest.mark.parametrize(
    "shape",
    [
        Block(width=1.0, height=1.0),
        pytest.param(Block(width=3.0, height=1.0), marks=pytest.mark.slow),
        pytest.param(Block(width=1.6, height=2.0), marks=pytest.mark.slow),
        BETWEEN_WALLS,
        pytest.param(T_SHAPE, marks=pytest.mark.slow),
    ],
    ids=["square", "wide", "high", "between walls", "T-shape"],
)
def test_structured_quadrilaterals_of_scikit_fem_give_the_same_numbers(shape):
    reach = 0.3 * min(shape.face_half_width, shape.least_depth)
    second = face_series(
        quadrilateral_kernels(shape, plane(0.3), reach * np.array([0.0, 0.5, 1.0]), reach)
    )
    of_body = numbers(shape)
    for name in NUMBERS:
        value, uncertainty = getattr(of_body, name)
        other = getattr(second, name)
        check("body numbers, second route", value / other - 1)
        assert abs(value - other) <= uncertainty + 2e-4 * abs(value), name


# ------------------------------------------------- signs: the interface of the contact model itself
STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
SOFTER = Elastic(young_modulus=120e3, poisson_ratio=0.2)
UNEQUAL = load_scene("blocks").vary(
    material=Materials(lower=STEEL, upper=SOFTER),
    bodies={
        "lower": Block(width=20.0, height=10.0),
        "upper": Block(width=10.0, height=12.0),
    },
)
ONE_BLOCK = UNEQUAL.vary(bodies={"lower": {"kind": "half_plane"}})
# Side that may touch, and what of it carries the loads.
_HALF_WIDTH = 2.0
_LOADED = 0.5


def interface_of(scene) -> Interface:
    """The two bodies as the contact model sees them, meshed for a contact of half-width 2."""
    datum = scene.profile.datum_length

    def grading(ratio):
        size = ratio * _HALF_WIDTH / 24
        return SurfaceGrading(0.0, _HALF_WIDTH, size, size, radius=30.0)

    bodies = meshed_pair(scene, MeshSettings(growth=0.1), grading)
    return couple(*condensed_pair(scene, bodies, datum, Counter()))


@functools.cache
def added_by_interface(scene) -> dict[str, float]:
    """What P = 1 and Q = 1, spread over |x| < 0.5 without moment, do to gap and slip of the bodies
    beyond what they do to half-planes of these materials: polynomials at the nodes.

    gap = ... + N p - K^T q and slip = ... + K p - T q are the interface's own signs.
    """
    bodies = interface_of(scene)
    half_planes = interface_of(
        scene.vary(bodies={"lower": {"kind": "half_plane"}, "upper": {"kind": "half_plane"}})
    )
    loads = np.where(np.abs(bodies.x) < _LOADED, bodies.face_lengths, 0.0)
    loads /= loads.sum()
    normal = (bodies.normal_compliance - half_planes.normal_compliance) @ loads
    tangential = (bodies.tangential_compliance - half_planes.tangential_compliance) @ loads
    coupling = bodies.coupling
    if half_planes.coupling is not None:
        coupling = coupling - half_planes.coupling
    gap_by_shear = -coupling.T @ loads
    slip_by_pressure = coupling @ loads

    def series(values):
        return np.polynomial.Polynomial.fit(bodies.x, values, 8).convert().coef

    second_moment = float(loads @ bodies.x**2)
    of_gap = series(normal)
    of_slip = series(tangential)
    return {
        "normal_compliance": of_gap[0] - of_gap[2] * second_moment,
        "normal_curvature": 2 * of_gap[2],
        "tangential_compliance": of_slip[0] - of_slip[2] * second_moment,
        "tangential_curvature": 2 * of_slip[2],
        "tilt_under_shear": series(gap_by_shear)[1],
        "strain_under_pressure": -series(slip_by_pressure)[1],
    }


def wrong_numbers(scene) -> set[str]:
    """The numbers of `body_effects` that the interface of the contact model does not have."""
    effects = body_effects(scene)
    limit = TOLERANCES["interface, curvature"].limit
    wrong = set()
    for name, value in added_by_interface(scene).items():
        if not abs(getattr(effects, name).value / value - 1) <= limit:
            wrong.add(name)
    return wrong


@pytest.mark.parametrize("scene", [UNEQUAL, ONE_BLOCK], ids=["unequal blocks", "upper block"])
def test_the_interface_of_the_contact_model_has_these_numbers(scene):
    """Sizes and signs of c_n, c_t, N, T, alpha_Q and e_P."""
    effects = body_effects(scene)
    for name, value in added_by_interface(scene).items():
        kind = "curvature" if "curvature" in name else "others"
        check(f"interface, {kind}", getattr(effects, name).value / value - 1)


# ---------------------------------------------------------------------------------- planted faults
COMBINED = remainder.effects_of_both_bodies
NUMBERS_ONCE = functools.cache(remainder.body_numbers)


def strain_of_the_upper_body_turned(lower, upper, scene):
    turned = dataclasses.replace(
        upper, strain_under_pressure=Estimate(-upper.strain_under_pressure.value)
    )
    return COMBINED(lower, turned, scene)


def tangential_compliance_dropped(lower, upper, scene):
    return dataclasses.replace(COMBINED(lower, upper, scene), tangential_compliance=Estimate(0.0))


def bodies_exchanged(lower, upper, scene):
    return COMBINED(upper, lower, scene)


def mirror_of_the_upper_body_forgotten(lower, upper, scene):
    """Slope and strain of the upper body as if its y axis pointed as the lower one's, and its loads
    did not turn round.
    """
    turned = dataclasses.replace(
        upper,
        strain_under_pressure=Estimate(-upper.strain_under_pressure.value),
        slope_under_shear=Estimate(-upper.slope_under_shear.value),
    )
    return COMBINED(lower, turned, scene)


FAULTS = {
    strain_of_the_upper_body_turned: {"strain_under_pressure"},
    tangential_compliance_dropped: {"tangential_compliance"},
    bodies_exchanged: {"strain_under_pressure", "tilt_under_shear"},
    mirror_of_the_upper_body_forgotten: {"strain_under_pressure", "tilt_under_shear"},
}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_fault_in_the_sum_of_both_bodies_is_caught(fault, monkeypatch):
    monkeypatch.setattr(remainder, "body_numbers", NUMBERS_ONCE)
    assert wrong_numbers(UNEQUAL) == set()
    monkeypatch.setattr(remainder, "effects_of_both_bodies", fault)
    assert wrong_numbers(UNEQUAL) == FAULTS[fault]


def test_the_material_of_the_other_body_is_caught(monkeypatch):
    right = remainder.body_numbers

    def with_the_other_material(name, shape, profile, material, datum_length):
        other = SOFTER if material == STEEL else STEEL
        return right(name, shape, profile, other, datum_length)

    monkeypatch.setattr(remainder, "body_numbers", with_the_other_material)
    assert {"normal_curvature", "tangential_curvature"} <= wrong_numbers(UNEQUAL)


def test_tractions_left_out_are_caught(monkeypatch):
    """The load of the remainder on the free sides."""
    right = remainder._forces_of_tractions
    monkeypatch.setattr(remainder, "_forces_of_tractions", lambda *args: 0 * right(*args))
    assert {"normal_curvature", "tangential_compliance"} <= wrong_numbers(UNEQUAL)


# ------------------------------------------------------------------------------------- scenes' door


def test_numbers_follow_units_and_datum():
    """Lengths times 1000 and stresses over 10; another datum moves c_n and c_t by (2/pi E') ln."""
    one = numbers(Block(width=1.0, height=1.0))
    large = body_numbers(
        "lower",
        Block(width=1000.0, height=1000.0),
        PROFILE,
        Elastic(young_modulus=0.091, poisson_ratio=0.3),
        datum_length=2000.0,
    )
    powers = {"curvature": -2, "under": -1, "fourth": -4, "mixed": -4, "compliance": 0}
    moved = 2 / np.pi * np.log(2.0)
    for field in dataclasses.fields(BodyNumbers):
        value = getattr(one, field.name)
        if not isinstance(value, Estimate):
            continue
        power = next(power for part, power in powers.items() if part in field.name)
        expected = value.value - (moved if power == 0 else 0.0)
        scaled = 10 * 1000.0**power * expected
        assert getattr(large, field.name).value == pytest.approx(scaled, rel=1e-7), field.name


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        ("two-cylinders", r"bodies\.lower: body effects are known for flat faces"),
        ("pad-on-block", r"bodies\.upper: .* that of a pad is curved"),
        (
            load_scene("blocks").vary(bodies={"lower": {"base": "rollers"}}),
            r"bodies\.lower: a body on rollers with free sides",
        ),
    ],
    ids=["cylinders", "pad", "rollers with free sides"],
)
def test_what_is_not_covered_is_refused_in_a_sentence(scene, words):
    with pytest.raises(InputError, match=words):
        body_effects(scene)
