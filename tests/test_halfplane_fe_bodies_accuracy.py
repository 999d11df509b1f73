"""Real bodies against something else than half-plane theory, and in the limit in which they become half-planes."""

import functools

import numpy as np
import pytest

import halfplane_fe
import layer_truth
import semi_analytic
from meshes import MeshSettings
from problems import COARSE
from scenes import Block, Bodies, Cylinder, Elastic, Hertz, Materials, Pad, PolygonLoad, load_scene
from tolerances import check, check_order

HALF_PLANES = Bodies()


def pressed(bodies, materials, radius, load):
    """Pressed once without friction."""
    like = load_scene("hertz-normal")
    changes = {
        "material": materials,
        "profile": Hertz(radius=radius),
        "friction": 0.0,
        "load": PolygonLoad(initial_loading=((load, 0.0),)),
        "bodies": bodies,
    }
    return like.vary(**changes)


def layer(thickness, stiffness=1e6, nu=0.3):
    soft, stiff = Elastic(young_modulus=1.0, poisson_ratio=nu), Elastic(young_modulus=stiffness, poisson_ratio=0.3)
    load = layer_truth.load_on(layer_truth.Layer(1.0, nu, thickness, 100.0), 1.0)
    bodies = Bodies(lower=Block(width=10.0, height=thickness), upper=Block(width=10.0, height=4.0))
    return pressed(bodies, Materials(lower=soft, upper=stiff), 100.0, load)


def layer_error(answer, thickness, nu=0.3):
    """Half-width, and L2 of the pressure."""
    truth = layer_truth.pressure(layer_truth.Layer(1.0, nu, thickness, 100.0), 1.0, answer.x)
    difference = answer.pressure[-1] - truth
    return answer.contact_half_width[-1] - 1.0, np.sqrt(np.trapezoid(difference**2, answer.x) / np.trapezoid(truth**2, answer.x))


class TestLayer:
    """Nobody's half-plane: an elastic layer bonded to a rigid base."""

    def test_truth_has_both_limits(self):
        """Hertz for a thick layer, p = M u/t for a thin one: P = 2 M a^3/(3 R t), M = E (1-nu)/((1+nu)(1-2 nu))."""
        thick = layer_truth.Layer(1.0, 0.3, 1e3, 100.0)
        assert layer_truth.load_on(thick, 1.0) == pytest.approx(np.pi / (4 * 100 * 0.91), rel=1e-6, abs=0)
        oedometric = 0.7 / (1.3 * 0.4)
        one, half = (
            layer_truth.load_on(layer_truth.Layer(1.0, 0.3, t, 100.0), 1.0) * 3 * 100 * t / (2 * oedometric) for t in (0.2, 0.1)
        )
        assert 1.02 < half < one < 1.08
        assert 2 * half - one == pytest.approx(1.0, abs=2e-3)  # what is left goes with t

    @pytest.mark.parametrize("thickness", [1.0, 0.3])
    def test_pressure_is_that_of_fourier_integrals(self, thickness):
        answer = halfplane_fe.solve(layer(thickness), COARSE)
        edge, pressure = layer_error(answer, thickness)
        check("layer, half-width", edge)
        check("layer, pressure", pressure)

    def test_that_test_sees_half_planes(self):
        answer = halfplane_fe.solve(layer(1.0).vary(bodies=HALF_PLANES), COARSE)
        assert layer_error(answer, 1.0)[1] > 0.1

    @pytest.mark.slow
    @pytest.mark.parametrize("nu", [0.0, 0.49, 0.4999])
    def test_nothing_locks(self, nu):
        soft = layer(0.5, nu=nu)
        wide = Bodies(lower=Block(width=20.0, height=0.5), upper=Block(width=20.0, height=4.0))
        answer = halfplane_fe.solve(soft.vary(bodies=wide))
        assert layer_error(answer, 0.5, nu)[1] < 1e-3

    def test_a_stiffer_punch_is_nearer_to_a_rigid_one(self):
        peaks = [halfplane_fe.solve(layer(1.0, stiffness), COARSE).pressure[-1].max() for stiffness in (1e2, 1e3, 1e6)]
        check_order("stiff punch", [1e-2, 1e-3], [peaks[2] - peaks[0], peaks[2] - peaks[1]])


def mindlin(bodies, radius=1000.0):
    """P constant, Q between +-0.6 f P; a = 1 if the bodies were half-planes."""
    like = load_scene("cattaneo-mindlin")
    compliance = sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (like.material.lower, like.material.upper))
    normal = np.pi / (4 * radius * compliance)
    tangential = 0.6 * normal * like.friction.coefficient
    load = PolygonLoad(initial_loading=((normal, 0.0), (normal, tangential)), cycle=((normal, -tangential),))
    return like.vary(bodies=bodies, profile=Hertz(radius=radius), load=load)


@functools.cache
def idealisation(kind, size, mesh):
    """Peak pressure and dissipation, FE over half-plane theory less 1."""
    bodies, radius = {
        "half-planes": lambda: (HALF_PLANES, 1000.0),
        "blocks": lambda: (Bodies(lower=Block(width=size, height=size), upper=Block(width=size, height=size)), 1000.0),
        "cylinders": lambda: (Bodies(lower=Cylinder(radius=size), upper=Cylinder(radius=size)), size / 2),
        "pad on block": lambda: (Bodies(lower=Block(width=size, height=size), upper=Pad(width=size, height=size)), size),
    }[kind]()
    answer = halfplane_fe.solve(mindlin(bodies, radius), mesh)
    theory = semi_analytic.solve(mindlin(bodies, radius), x=answer.x, time=answer.time)
    largest = int(np.argmax(answer.normal_load))
    return np.array([answer.pressure[largest].max() / theory.pressure[largest].max(), answer.dissipation / theory.dissipation]) - 1


SLOW_KINDS = [pytest.param(kind, marks=pytest.mark.slow) for kind in ("cylinders", "pad on block")]


@pytest.mark.parametrize("kind", ["blocks", *SLOW_KINDS])
def test_growing_bodies_become_half_planes_at_second_order(kind):
    """What the mesh alone does is the same on every rung and on half-planes, and is taken out."""
    sizes = (8.0, 16.0, 32.0)
    mesh = COARSE if kind == "blocks" else MeshSettings()
    errors = np.abs([idealisation(kind, size, mesh) - idealisation("half-planes", 0.0, mesh) for size in sizes])
    for column, name in enumerate(("peak pressure", "dissipation")):
        check_order(f"idealisation, {name}", [1 / size for size in sizes], errors[:, column])


@pytest.mark.slow
def test_far_end_of_the_ladder_is_half_plane_theory():
    block = Block(width=320.0, height=320.0)
    pad = Pad(width=320.0, height=320.0)
    for bodies, radius in ((Bodies(lower=block, upper=block), 1000.0), (Bodies(lower=block, upper=pad), 400.0)):
        scene = mindlin(bodies, radius)
        answer = halfplane_fe.solve(scene)
        theory = semi_analytic.solve(scene, x=answer.x, time=answer.time)
        assert abs(answer.dissipation / theory.dissipation - 1) < 5e-4
        assert abs(answer.pressure.max() / theory.pressure.max() - 1) < 5e-4


@pytest.mark.slow
def test_which_body_is_the_stiff_one_does_not_matter():
    """A million times stiffer above or below: the same, turned by half a turn."""
    block = Block(width=10.0, height=10.0)
    scene = mindlin(Bodies(lower=block, upper=block))
    soft = scene.material.lower
    stiff = soft.vary(young_modulus=1e6 * soft.young_modulus)
    found = [
        halfplane_fe.solve(scene.vary(material=Materials(lower=lower, upper=upper)), MeshSettings(1 / 8, 1 / 24))
        for lower, upper in ((stiff, soft), (soft, stiff))
    ]
    assert found[0].dissipation == pytest.approx(found[1].dissipation, rel=1e-9, abs=0)
    np.testing.assert_allclose(found[0].pressure[-1], found[1].pressure[-1, ::-1], rtol=1e-8, atol=1e-9 * found[0].pressure.max())
