"""Nearly incompressible bodies: errors against half-plane theory do not grow with nu; linear elements are refused."""

import functools

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import elasticity
from halfplane_fe.elasticity import condense, split_lame
from meshes import MeshSettings, SurfaceGrading, half_disc
from problems import COARSE, FEW_STEPS, fe_run, hertz_pressure, mindlin_dissipation
from scenes import Elastic, InputError, Materials, load_scene
from tolerances import check

RATIOS = (0.45, 0.499, 0.4999)


def scene_at(poisson_ratio):
    """Cattaneo and Mindlin's cycle with the E* of the library's scene."""
    scene = load_scene("cattaneo-mindlin")
    plane = scene.material.lower.young_modulus / (1 - scene.material.lower.poisson_ratio**2)
    body = Elastic(young_modulus=plane * (1 - poisson_ratio**2), poisson_ratio=poisson_ratio)
    return scene.vary(material=Materials(lower=body, upper=body))


@functools.cache
def errors_at(poisson_ratio):
    """Dissipation, and pressure at the end in L2 and in the worst of its inner nodes."""
    scene = scene_at(poisson_ratio)
    answer = halfplane_fe.solve(scene, COARSE, FEW_STEPS)
    body, f = scene.material.lower, scene.friction.coefficient
    modulus = body.young_modulus / (1 - body.poisson_ratio**2) / 2
    load, amplitude = scene.load.cycle[0]
    exact = hertz_pressure(answer.x, load, scene.profile.radius, modulus)
    off, weights = answer.pressure[-1] - exact, answer.condensed[0].weights
    inner = np.abs(answer.x) < 0.5 * answer.contact_half_width[-1]
    return {
        "dissipation": abs(answer.dissipation / mindlin_dissipation(load, amplitude, f, modulus) - 1),
        "pressure": np.sqrt(weights @ off**2 / (weights @ exact**2)),
        "rocking": np.abs(off[inner]).max() / exact.max(),
    }


@pytest.mark.parametrize("poisson_ratio", RATIOS)
@pytest.mark.parametrize("quantity", ["dissipation", "pressure", "rocking"])
def test_error_does_not_grow_with_nu(poisson_ratio, quantity):
    check(f"incompressible {quantity}", errors_at(poisson_ratio)[quantity])


def test_plain_elements_would_fail_that_test(monkeypatch):
    monkeypatch.setattr(elasticity, "PLAIN_LAMBDA", np.inf)
    with pytest.raises(AssertionError, match="incompressible rocking"):
        check("incompressible rocking", errors_at.__wrapped__(0.4999)["rocking"])


def test_linear_elements_are_refused_in_a_sentence():
    with pytest.raises(InputError, match=r"order = 1 with a Poisson ratio of 0\.499 is refused: linear elements lock above 0\.45"):
        halfplane_fe.solve(scene_at(0.499), MeshSettings(order=1), FEW_STEPS)
    body = half_disc("body", SurfaceGrading(0.0, 1.2, 1 / 8, 1 / 8, 6.0), 0.4, 1)
    assert condense(body, Elastic(young_modulus=1.0, poisson_ratio=0.45), 1.0).order == 1


def test_lambda_is_split_above_a_third_only_and_continuously():
    for nu, order in ((0.3, 2), (1 / 3, 2), (-0.4, 2), (0.0, 2), (0.45, 1)):
        assert split_lame(Elastic(young_modulus=1.0, poisson_ratio=nu), order)[1] == 0
    plain, rest, shear_modulus = split_lame(Elastic(young_modulus=1.0, poisson_ratio=0.49), 2)
    assert plain == pytest.approx(2 * shear_modulus)
    assert plain + rest == pytest.approx(0.49 / (1.49 * 0.02))
    body = half_disc("body", SurfaceGrading(0.0, 1.2, 1 / 8, 1 / 8, 6.0), 0.4, 2)
    below, above = (condense(body, Elastic(young_modulus=1.0, poisson_ratio=1 / 3 + d), 1.0).compliance for d in (-1e-6, 1e-5))
    np.testing.assert_allclose(above, below, atol=1e-4 * np.abs(below).max())


def test_stress_in_an_incompressible_body():
    """On the axis against the closed form, which knows no nu but in s_zz: the mean stress is that of r."""
    scene = load_scene("hertz-normal")
    body = Elastic(young_modulus=scene.material.lower.young_modulus * (1 - 0.4999**2) / 0.91, poisson_ratio=0.4999)
    answer = fe_run(scene.vary(material=Materials(lower=body, upper=body)))
    (snapshot,) = halfplane_fe.fields(answer, [1.0])
    p0, a = answer.pressure[-1].max(), answer.contact_half_width[-1]
    lower = snapshot.bodies[0]
    axis = np.flatnonzero((np.abs(lower.points[:, 0]) < 1e-9) & (np.abs(lower.points[:, 1]) < 2 * a) & (lower.points[:, 1] != 0))
    z = -lower.points[axis, 1] / a
    m = np.sqrt(1 + z**2)
    xx, yy = -p0 * ((1 + 2 * z**2) / m - 2 * z), -p0 / m
    exact = np.stack([xx, yy, 0 * z, 0.4999 * (xx + yy)], axis=1)
    check("incompressible stress", float(np.abs(lower.stress[axis] - exact).max() / p0))
