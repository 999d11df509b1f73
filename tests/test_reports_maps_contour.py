"""The first-order law of a contour that is no parabola: against a solution element by element, its kernel, and finite elements."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from math import asin, pi, sqrt

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad

from reports.maps.advising import parts
from reports.maps.atlas import PUBLISHED
from reports.maps.contour import kernel, potential, share_of, work_constant
from reports.maps.corrections import corrected_dissipation, pad_correction
from reports.maps.laws import leading_constant
from reports.maps.pads import RATIO, work_lines
from reports.maps.readings import read
from reports.maps.trials import left
from scenes import Block, Elastic, FlatRounded, InputError, Materials, Pad, PolygonLoad, Scene, load_scene
from semi_analytic.profiles import contact_of

Array = NDArray[np.float64]
BODY = Elastic(young_modulus=2.0, poisson_ratio=0.0)  # two of them: E* = 1, E' = 2


def element_by_element(flat: float, ratio: float, count: int) -> float:
    """dW/W over a/R, shear constant on elements, by slip instead of energies; the stick zone is kept: its edge is stationary."""
    contact = contact_of(FlatRounded(radius=1.0, flat_half_length=flat), Materials(upper=BODY, lower=BODY))
    load = float(contact.load(1.0))
    edge = float(contact.half_width((1 - ratio) * load))
    cuts, grading = [0.0, flat, edge, 1.0], (1 - np.cos(np.linspace(0, np.pi, count + 1))) / 2
    ends = np.unique(np.concatenate([a + (b - a) * grading for a, b in pairwise(cuts)]))
    ends = np.concatenate([-ends[:0:-1], ends])
    x, width = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
    plain = -(2 / np.pi) * (_log_integral(x[:, None] - ends[:-1]) - _log_integral(x[:, None] - ends[1:]))
    curved = (2 / np.pi**2) * kernel(x, x, flat) * width
    limit, small = contact.pressure(x, load), 1e-3
    works = [_work(plain + size * curved, limit, width, ratio, np.abs(x) < edge) for size in (-small, 0.0, small)]
    return (works[2] - works[0]) / (2 * small) / works[1]


def _log_integral(apart: Array) -> Array:
    return apart * np.log(np.abs(np.where(apart == 0, 1.0, apart))) - apart


def _work(matrix: Array, limit: Array, width: Array, ratio: float, stick: NDArray[np.bool_]) -> float:
    """Friction on slip of one loading, where `stick` has one shift."""
    n, slip = int(stick.sum()), ~stick
    system, rest = np.zeros((n + 1, n + 1)), ratio * (limit @ width) - limit[slip] @ width[slip]
    system[:n, :n], system[:n, n], system[n, :n] = matrix[np.ix_(stick, stick)], -1.0, width[stick]
    found = np.linalg.solve(system, np.append(-matrix[np.ix_(stick, slip)] @ limit[slip], rest))
    shear = limit.copy()
    shear[stick] = found[:n]
    return float((limit * width) @ (found[n] - matrix @ shear))


@pytest.mark.parametrize(
    ("flat", "ratio", "value"), [(0.2, 0.6, -0.2085), (0.5, 0.6, -0.4603), (0.7, 0.6, -0.5593), (0.9, 0.3, -0.5653)]
)
def test_constant_is_that_of_elements(flat: float, ratio: float, value: float) -> None:
    """Elements reach it at order 2; what they miss at 80 a part is 0.04 % at most."""
    found = work_constant(flat, ratio)
    assert found == pytest.approx(value, abs=5e-5)
    apart = [element_by_element(flat, ratio, count) / found - 1 for count in (40, 80)]
    assert abs(apart[1]) < 1e-3
    assert np.log2(apart[0] / apart[1]) == pytest.approx(2.0, abs=0.4)


def test_the_rule_has_converged() -> None:
    for flat in (0.01, 0.5, 0.99):
        for ratio in (0.05, 0.95):
            assert work_constant(flat, ratio) == pytest.approx(work_constant(flat, ratio, 48), rel=1e-6)  # measured 1e-7


def test_a_cylinder_has_no_first_order() -> None:
    assert abs(work_constant(0.0, 0.6)) < 1e-12
    assert abs(work_constant(1e-3, 0.6)) < 5e-3  # and none comes at once


def test_kernel_is_that_of_the_profile() -> None:
    """Differences of K, by Cauchy quadrature of h/((t - x)(t - xi)) over a wide face: beyond it, one number more."""
    flat, reach = 0.5, 1000.0

    def transform(x: float) -> float:
        parts = ((-reach, -flat), (flat, reach))
        total = 0.0
        for begin, end in parts:
            if begin < x < end:
                near = (x - 0.1, x + 0.1)
                total += quad(lambda t: (abs(t) - flat) ** 2 / 2, *near, weight="cauchy", wvar=x)[0]
                pieces = [(begin, near[0]), (near[1], end)]
            else:
                pieces = [(begin, end)]
            for a, b in pieces:
                total += quad(lambda t: (abs(t) - flat) ** 2 / 2 / (t - x), a, b, limit=400, epsabs=1e-9)[0]
        return total

    x, xi = np.array([-0.8, 0.3, 0.7]), np.array([0.2, -0.65])
    direct = np.array([[(transform(a) - transform(b)) / (a - b) for b in xi] for a in x])
    found = kernel(x, xi, flat)
    assert found - found[0, 0] == pytest.approx(direct - direct[0, 0], abs=2e-3)  # what is beyond the reach: x/reach
    assert np.ptp(found) > 0.1


def test_slope_where_points_meet() -> None:
    x = np.array([0.1, 0.5, 0.9])
    step = 1e-6
    slope = (potential(x + step, 0.5) - potential(x - step, 0.5)) / (2 * step)
    assert np.diag(kernel(x, x, 0.5)) == pytest.approx(slope, rel=1e-4)


def steel_load(flat: float, curvature: float) -> float:
    """P at which a = 1 by half-plane theory."""
    return 210e3 / 1.82 * curvature * ((pi - 2 * asin(flat)) / 4 - flat * sqrt(1 - flat**2) / 2)


def pad(flat: float, curvature: float, ratio: float = 0.6) -> Scene:
    """A pad of the map: a = 1 by half-plane theory, P constant, Q between +-ratio f P."""
    load = steel_load(flat, curvature)
    base = load_scene("two-cylinders")
    bodies = base.bodies.vary(
        upper=Pad(width=2 * flat + 1.4 / curvature, height=1 / curvature), lower=load_scene("hertz-paper").bodies.lower
    )
    steel = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    changes = {
        "material": Materials(lower=steel, upper=steel),
        "profile": FlatRounded(radius=1 / curvature, flat_half_length=flat),
        "bodies": bodies,
        "friction": 0.5,
        "load": PolygonLoad(initial_loading=((load, 0.0), (load, 0.5 * ratio * load)), cycle=((load, -0.5 * ratio * load),)),
    }
    return base.vary(**changes)


@lru_cache
def error_of_theory(flat: float, curvature: float) -> float:
    """Dissipation of finite elements over half-plane theory, less 1."""
    import halfplane_fe
    import semi_analytic
    from meshes import MeshSettings

    scene = pad(flat, curvature)
    found = halfplane_fe.solve(scene, MeshSettings(element_size=0.025, edge_element_size=0.005, growth=0.1))
    exact = semi_analytic.solve(scene, x=found.x, time=found.time, fields=("dissipation",))
    return found.dissipation / exact.dissipation - 1


@pytest.mark.slow
def test_finite_elements_keep_to_it() -> None:
    """Twice that of a/R = 0.02 less half of that of 0.04 has no second order: the constant."""
    small, large = (error_of_theory(0.5, curvature) / curvature for curvature in (0.02, 0.04))
    assert 2 * small - large == pytest.approx(work_constant(0.5, 0.6), rel=0.02)  # measured 0.3 %
    # At 0.01, the second order taken from these two; the mesh leaves 1.1e-4 of W, the law is 46e-4.
    second = (large - small) / 0.02 * 0.01**2
    assert error_of_theory(0.5, 0.01) == pytest.approx(0.01 * work_constant(0.5, 0.6) + second, abs=2e-4)


def test_correction_is_the_law_for_the_scene() -> None:
    for ratio in (0.3, 0.8):
        scene = pad(0.5, 0.05, ratio)
        assert pad_correction(scene) == pytest.approx(0.05 * work_constant(0.5, ratio), rel=1e-6)
        assert corrected_dissipation(scene, 2.0) == pytest.approx(2 + 2 * pad_correction(scene), rel=1e-12)


SCENE = pad(0.5, 0.05)
LOAD = (steel_load(0.5, 0.05), 0.3 * steel_load(0.5, 0.05))


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (pad(0.5, 0.2), "the correction holds up to 0.1"),
        (pad(0.1, 0.05), "b/a of 0.2 to 0.9"),
        (SCENE.vary(bodies={"upper": {"width": 3.0, "height": 20.0}}), "the pad is too small"),
        (SCENE.vary(bodies={"lower": Block(width=90.0, height=45.0)}), "a pad with a flat face on a half-plane"),
        (SCENE.vary(material={"lower": {"young_modulus": 1e5}}), "of one material"),
        (SCENE.vary(load=PolygonLoad(initial_loading=(LOAD,), cycle=((0.9 * LOAD[0], 0.0),))), "constant P"),
        (pad(0.5, 0.05, 1.2), "the contact slides"),
        (
            SCENE.vary(
                load=PolygonLoad(initial_loading=(LOAD,), cycle=tuple((LOAD[0], share * LOAD[1]) for share in (0.0, 0.5, -1.0))),
            ),
            "turns twice",
        ),
    ],
)
def test_correction_refuses_what_it_was_not_tried_on(scene: Scene, words: str) -> None:
    with pytest.raises(InputError, match=words):
        pad_correction(scene)


def test_advice_on_a_pad_goes_by_the_first_power() -> None:
    """Far below the smallest radius of the map the law is all: a tenth of a/R, a tenth of the error, of this loop's constant."""
    for curvature, within in ((1e-3, 0.01), (1e-4, 1e-3)):
        for ratio in (0.3, 0.6):
            half_width, found = parts(pad(0.5, curvature, ratio))
            assert half_width == pytest.approx(1.0, rel=1e-6)
            assert len(found) == 1
            assert "first power of a/R" in found[0].how
            assert found[0].values is not None
            error, _ = found[0].values["error.dissipation"]
            assert error == pytest.approx(curvature * work_constant(0.5, ratio), rel=within)


def without_beta(upper_stiff: bool, curvature: float) -> Scene:
    """Moduli that differ by two, and beta = 0: G2/G1 = (1 - 2 nu2)/(1 - 2 nu1) = 1/2."""
    stiff = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    soft = Elastic(young_modulus=210e3 * 1.4 / 2.6, poisson_ratio=0.4)
    materials = Materials(upper=stiff if upper_stiff else soft, lower=soft if upper_stiff else stiff)
    base = pad(0.5, curvature)
    load = float(contact_of(base.profile, materials).load(1.0))
    return base.vary(
        material=materials, load=PolygonLoad(initial_loading=((load, 0.0), (load, 0.3 * load)), cycle=((load, -0.3 * load),))
    )


@pytest.mark.parametrize(("upper_stiff", "share"), [(True, 0.7369), (False, 1.2631)])
def test_the_curved_bodys_modulus_alone_counts(upper_stiff: bool, share: float) -> None:
    scene = without_beta(upper_stiff, 1e-3)
    assert share_of(scene.material.upper, scene.material) == pytest.approx(share, abs=1e-4)
    _, found = parts(scene)
    assert [part.what[:9] for part in found] == ["true arcs"]
    assert found[0].values is not None
    assert found[0].values["error.dissipation"][0] == pytest.approx(1e-3 * share * work_constant(0.5, 0.6), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("upper_stiff", [True, False])
def test_finite_elements_count_the_curved_bodys_modulus(upper_stiff: bool) -> None:
    """Measured: W -1.472 and -2.519 % (advised -1.473 and -2.525 ± 0.01), p0 +0.246 and +0.440 % (+0.23 and +0.40 ± 0.04)."""
    import halfplane_fe
    import semi_analytic
    from meshes import MeshSettings

    scene = without_beta(upper_stiff, 0.04)
    fe = halfplane_fe.solve(scene, MeshSettings(element_size=0.025, edge_element_size=0.005, growth=0.1))
    exact = semi_analytic.solve(scene, x=fe.x, time=fe.time, fields=("dissipation", "pressure"))
    _, found = parts(scene)
    assert found[0].values is not None
    for figure, measured in (
        ("error.dissipation", fe.dissipation / exact.dissipation - 1),
        ("error.p0", fe.pressure.max() / exact.pressure.max() - 1),
    ):
        error, doubt = found[0].values[figure]
        assert abs(measured - error) <= doubt


def test_advice_says_where_the_loop_is_another() -> None:
    _, found = parts(SCENE.vary(load=PolygonLoad(initial_loading=(LOAD,), cycle=((0.9 * LOAD[0], 0.0),))))
    assert found[0].extrapolated
    assert "which this loop is not" in found[0].how


def test_correction_and_advice_on_held_out_points() -> None:
    """Finite elements on pads and loops that no map is made of: advice holds within its uncertainty, the first power takes most."""
    for row in read(PUBLISHED, "pad-held-out").rows:
        flat, curvature, ratio = (float(row[name]) for name in ("flat", "curvature", "ratio"))
        error, doubt = float(row["error.dissipation"]), float(row["error.dissipation.uncertainty"])
        _, found = parts(pad(flat, curvature, ratio))
        assert found[0].values is not None
        for figure in ("error.dissipation", "error.p0", "error.contact_half_width"):
            advised, unsure = found[0].values[figure]
            assert abs(advised - float(row[figure])) <= unsure + float(row[f"{figure}.uncertainty"]), figure
        assert abs(left(error, pad_correction(pad(flat, curvature, ratio)))) <= 0.25 * abs(error) + doubt


def test_derived_constants_are_those_of_the_map() -> None:
    for line in work_lines(PUBLISHED):
        assert line.law is not None
        known = work_constant(float(line.at["flat"]), RATIO)
        assert line.law.agrees()
        found, doubt = leading_constant(line.s, line.error, line.uncertainty, line.order)
        assert abs(found - known) <= doubt
        assert doubt < 0.07 * abs(known)  # measured: 6, 3 and 2 %
