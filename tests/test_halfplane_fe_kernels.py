"""Bodies by their remainder kernels against finite elements of the bodies, whose contact solver and
increments are the same: what is compared is the kernels.
"""

from __future__ import annotations

import dataclasses
import functools
from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import FiniteElementSolution, kernel_bodies, remainder
from halfplane_fe.interface import Interface
from halfplane_fe.kernel_bodies import (
    CurvatureJumpKernels,
    FaceKernels,
    KernelPair,
    fitted_kernels,
    kernel_pair,
)
from halfplane_fe.remainder import face_kernels
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, fe_run
from scenes import (
    Block,
    BodyEffects,
    ContactSolution,
    Elastic,
    EllipseLoad,
    InputError,
    Materials,
    Scene,
    load_scene,
)
from scenes.bodies import Face
from semi_analytic.profiles import contact_of
from tolerances import check

LOAD = 90.62286500739786  # a = 1 mm of two steel half-planes, R = 1000 mm
STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
ALUMINIUM = Elastic(young_modulus=70e3, poisson_ratio=0.33)
SOFT = Elastic(young_modulus=20e3, poisson_ratio=0.4)
HALF_PLANE = {"kind": "half_plane"}
Fault = Callable[[FaceKernels], FaceKernels]


def block(width: float, height: float) -> dict[str, object]:
    """Of a block, over the half-width of contact."""
    return {"kind": "block", "width": width, "height": height}


def mindlin(friction: float) -> EllipseLoad:
    """Q = 0.6 f P cos t at constant P."""
    return EllipseLoad(
        mean_normal_load=LOAD,
        normal_amplitude=0.0,
        tangential_amplitude=0.6 * friction * LOAD,
        phase_degrees=90.0,
        initial_loading="straight",
    )


def ellipse(friction: float) -> EllipseLoad:
    """P1/P0 = 1/3, Q1 = f P0/2, 40 degrees."""
    return EllipseLoad(
        mean_normal_load=LOAD,
        normal_amplitude=LOAD / 3,
        tangential_amplitude=friction * LOAD / 2,
        phase_degrees=40.0,
        initial_loading="straight",
    )


def scene_of(
    lower: dict[str, object],
    upper: dict[str, object],
    load: EllipseLoad,
    friction: float,
    upper_material: Elastic = STEEL,
) -> Scene:
    """Bodies over a lower one of steel, on a radius that makes the half-width 1 mm."""
    softer = 1 / upper_material.young_modulus * (1 - upper_material.poisson_ratio**2)
    stiffness_ratio = 2 / (1 + softer * STEEL.young_modulus / (1 - STEEL.poisson_ratio**2))
    return load_scene("hertz-paper").vary(
        bodies={"lower": lower, "upper": upper},
        load=load,
        friction=friction,
        material=Materials(lower=STEEL, upper=upper_material),
        profile={"radius": 1000.0 * stiffness_ratio},
    )


class Difference(NamedTuple):
    """Finite elements over the kernel solve, minus 1."""

    work: float
    pressure: float
    displacement: float
    approach: float


def difference(elements: FiniteElementSolution, kernels: ContactSolution) -> Difference:
    """Of W, p0, the range of U and the largest approach."""
    return Difference(
        elements.dissipation / kernels.dissipation - 1,
        elements.pressure.max() / kernels.pressure.max() - 1,
        np.ptp(elements.tangential_displacement) / np.ptp(kernels.tangential_displacement) - 1,
        elements.normal_approach.max() / kernels.normal_approach.max() - 1,
    )


# ---------------------------------------------------------------------------------- finite elements
UNLIKE = scene_of(block(20.0, 10.0), block(10.0, 6.0), mindlin(0.8), 0.8, ALUMINIUM)
FINE = MeshSettings(growth=0.06)
FLAT = {
    "pair, aspect 3, h 3": (block(9.0, 3.0), block(9.0, 3.0)),
    "pair, aspect 1.5, h 6": (block(9.0, 6.0), block(9.0, 6.0)),
    "pair, aspect 3, h 14": (block(42.0, 14.0), block(42.0, 14.0)),
    "one, aspect 0.8, h 10": (HALF_PLANE, block(8.0, 10.0)),
    "layer, h 4": (block(80.0, 4.0), HALF_PLANE),
}
UNLIKE_BODIES = {
    "pair, aspect 2, h 6": (block(12.0, 6.0), block(12.0, 6.0)),
    "upper, aspect 1.5, h 5": (HALF_PLANE, block(7.5, 5.0)),
}
LOADS = {"cycle .6 .8": (mindlin, 0.8), "ellipse .3": (ellipse, 0.3)}


@functools.cache
def by_kernels(scene: Scene) -> ContactSolution:
    """On the mesh of `fe_run`."""
    return halfplane_fe.solve(scene, COARSE, FEW_STEPS, bodies="kernel")


def test_unequal_blocks_of_unlike_materials_on_a_coarse_mesh() -> None:
    """All kernels at once: W of half-planes is 12 % larger."""
    kernels = by_kernels(UNLIKE)
    of_blocks = difference(fe_run(UNLIKE), kernels)
    for quantity, value in zip(Difference._fields, of_blocks, strict=True):
        check(f"kernels, coarse mesh: {quantity}", value)
    assert any("remainder kernels" in note for note in kernels.record.notes)
    assert kernels.settings["bodies"] == "kernel"
    assert kernels.work.counts["kernel solves"] == 4


@pytest.mark.slow
@pytest.mark.parametrize("history", LOADS)
@pytest.mark.parametrize("bodies", FLAT)
def test_flat_bodies_of_like_materials(bodies: str, history: str) -> None:
    load, friction = LOADS[history]
    scene = scene_of(*FLAT[bodies], load(friction), friction)
    elements = halfplane_fe.solve(scene, FINE)
    kernels = halfplane_fe.solve(scene, FINE, bodies="kernel")
    of_bodies = difference(elements, kernels)
    for quantity, value in zip(Difference._fields, of_bodies, strict=True):
        check(f"kernels: {quantity}", value)
    tension_of_elements, tension_of_kernels = (
        halfplane_fe.largest_edge_tension(solution) for solution in (elements, kernels)
    )
    assert tension_of_elements is not None
    assert tension_of_kernels is not None
    left = tension_of_elements.value - tension_of_kernels.value
    check("kernels: edge tension", left / tension_of_elements.value)
    assert abs(left) <= tension_of_kernels.uncertainty + tension_of_elements.uncertainty
    assert abs(of_bodies.work) * elements.dissipation <= kernels.dissipation_uncertainty


# Radius 10 half-widths, or 20 of each of two cylinders.
ARCS = {
    "cylinder on block": (block(20.0, 10.0), {"kind": "cylinder", "radius": 10.0}),
    "cylinder on half-plane": (HALF_PLANE, {"kind": "cylinder", "radius": 10.0}),
    "cylinder below": ({"kind": "cylinder", "radius": 10.0}, block(20.0, 10.0)),
    "pad": (HALF_PLANE, {"kind": "pad", "width": 12.0, "height": 12.0}),
    "two cylinders": ({"kind": "cylinder", "radius": 20.0}, {"kind": "cylinder", "radius": 20.0}),
}


def arcs_of(bodies: str, history: str) -> Scene:
    """A scene of `ARCS`, a/R = 0.1 at the mean load."""
    lower, upper = ARCS[bodies]
    load, friction = LOADS[history]
    radius = 10.0
    of_load = load(friction)
    heavier = 1000.0 / radius
    return load_scene("hertz-paper").vary(
        bodies={"lower": lower, "upper": upper},
        profile={"radius": radius},
        friction=friction,
        load=EllipseLoad(
            mean_normal_load=heavier * of_load.mean_normal_load,
            normal_amplitude=heavier * of_load.normal_amplitude,
            tangential_amplitude=heavier * of_load.tangential_amplitude,
            phase_degrees=of_load.phase_degrees,
            initial_loading="straight",
        ),
    )


@pytest.mark.slow
@pytest.mark.parametrize("history", LOADS)
@pytest.mark.parametrize("bodies", ARCS)
def test_arcs(bodies: str, history: str) -> None:
    """Theory errs by 0.04 to 8 % of W."""
    scene = arcs_of(bodies, history)
    kernels = halfplane_fe.solve(scene, FINE, bodies="kernel")
    of_arcs = difference(halfplane_fe.solve(scene, FINE), kernels)
    for quantity, value in zip(Difference._fields, of_arcs, strict=True):
        check(f"kernels, arcs: {quantity}", value)


FLAT_PADS = {"half-plane": HALF_PLANE, "block": block(20.0, 10.0)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("below", "flat", "history"),
    [
        ("half-plane", 0.8, "cycle .6 .8"),
        ("half-plane", 0.8, "ellipse .3"),
        ("block", 0.5, "cycle .6 .8"),
    ],
)
def test_flat_pads(below: str, flat: float, history: str) -> None:
    """Edges of radius 10 half-widths at the mean load: theory errs by up to 8 % of W."""
    upper = {"kind": "pad", "width": 2 * flat + 16.0, "height": 12.0}
    load, friction = LOADS[history]
    scene = load_scene("flat-rounded-paper").vary(
        bodies={"lower": FLAT_PADS[below], "upper": upper},
        profile={"radius": 10.0, "flat_half_length": flat},
        friction=friction,
        expected=[],
    )
    of_load = load(friction)
    heavier = float(contact_of(scene.profile, scene.material).load(1.0)) / LOAD
    scene = scene.vary(
        load=EllipseLoad(
            mean_normal_load=heavier * of_load.mean_normal_load,
            normal_amplitude=heavier * of_load.normal_amplitude,
            tangential_amplitude=heavier * of_load.tangential_amplitude,
            phase_degrees=of_load.phase_degrees,
            initial_loading="straight",
        )
    )
    # next to b the pressure is steep
    mesh = MeshSettings(element_size=1 / 32, edge_element_size=1 / 320, growth=0.1)
    kernels = halfplane_fe.solve(scene, mesh, bodies="kernel")
    elements = halfplane_fe.solve(scene, mesh)
    of_fits = smooth_largest_pressure(elements) / smooth_largest_pressure(kernels) - 1
    of_pads = difference(elements, kernels)._replace(pressure=of_fits)
    for quantity, value in zip(Difference._fields, of_pads, strict=True):
        check(f"kernels, flat pads: {quantity}", value)


def smooth_largest_pressure(solution: ContactSolution) -> float:
    """The largest pressure by polynomials of degree 4 through the nodes within 0.03 half-widths of
    the highest one: next to the flat single nodes of the finite elements stray by 0.6 %, and by
    0.4 % between meshes.
    """
    span = 0.03
    places = np.linspace(-span / 2, span / 2, 201)
    largest = 0.0
    for pressure in solution.pressure[solution.last_cycle]:
        highest = int(np.argmax(pressure))
        if pressure[highest] < 0.98 * solution.pressure.max():
            continue
        distance = solution.x - solution.x[highest]
        is_near = np.abs(distance) < span
        polynomial = np.polyfit(distance[is_near], pressure[is_near], 4)
        largest = max(largest, float(np.polyval(polynomial, places).max()))
    return largest


def test_kernels_of_a_jump_of_curvature_have_their_limit_at_the_force() -> None:
    jump_kernels = CurvatureJumpKernels(0.5, 10.0, STEEL)
    x = np.array([-0.8, 0.2, 0.7])
    at_force = jump_kernels.kernels_at(x, x)
    beside = jump_kernels.kernels_at(x, x + 1e-6)
    for kernel, kernel_beside in zip(at_force, beside, strict=True):
        np.testing.assert_allclose(np.diag(kernel), np.diag(kernel_beside), rtol=1e-4, atol=1e-12)


def test_a_cylinder_on_a_block_on_a_coarse_mesh() -> None:
    scene = arcs_of("cylinder on block", "cycle .6 .8")
    of_arcs = difference(fe_run(scene), by_kernels(scene))
    for quantity, value in zip(Difference._fields, of_arcs, strict=True):
        check(f"kernels, coarse mesh: {quantity}", value)


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["slope of the chord", "normal", "gap along y"])
def test_a_planted_fault_of_arcs_is_seen(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    right = kernel_bodies._on_middle_line

    def with_flat_normal(pair: Interface, *faces: Face) -> Interface:
        turned = right(pair, *faces)
        return dataclasses.replace(pair, gap=turned.gap)

    def with_gap_along_y(pair: Interface, *faces: Face) -> Interface:
        turned = right(pair, *faces)
        return dataclasses.replace(turned, gap=turned.gap / turned.face_normals[1])

    if fault == "slope of the chord":
        monkeypatch.setattr(remainder, "_with_chord_slopes", lambda kernels, *_: kernels)
    else:
        faults = {"normal": with_flat_normal, "gap along y": with_gap_along_y}
        monkeypatch.setattr(kernel_bodies, "_on_middle_line", faults[fault])
    scene = arcs_of("cylinder on block", "cycle .6 .8")
    of_arcs = difference(fe_run(scene), by_kernels.__wrapped__(scene))
    assert abs(of_arcs.work) > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("history", LOADS)
@pytest.mark.parametrize("bodies", UNLIKE_BODIES)
@pytest.mark.parametrize("material", [ALUMINIUM, SOFT], ids=["aluminium", "soft"])
def test_bodies_of_unlike_materials(material: Elastic, bodies: str, history: str) -> None:
    """Dundurs' beta is 0.12."""
    load, friction = LOADS[history]
    scene = scene_of(*UNLIKE_BODIES[bodies], load(friction), friction, material)
    elements = halfplane_fe.solve(scene, FINE)
    kernels = halfplane_fe.solve(scene, FINE, bodies="kernel")
    of_bodies = difference(elements, kernels)
    check("kernels, unlike materials: work", of_bodies.work)
    check("kernels, unlike materials: pressure", of_bodies.pressure)
    assert abs(of_bodies.work) * elements.dissipation <= kernels.dissipation_uncertainty


# ---------------------------------------------------------------------------------- planted faults
def without_tangential_kernel(kernels: FaceKernels) -> FaceKernels:
    return dataclasses.replace(kernels, tangential_coefficients=0 * kernels.tangential_coefficients)


def without_normal_kernel(kernels: FaceKernels) -> FaceKernels:
    return dataclasses.replace(kernels, normal_coefficients=0 * kernels.normal_coefficients)


def with_coupling_turned(kernels: FaceKernels) -> FaceKernels:
    return dataclasses.replace(kernels, coupling_coefficients=-kernels.coupling_coefficients)


def with_places_exchanged(kernels: FaceKernels) -> FaceKernels:
    """Where the force is and where the face moves."""
    return dataclasses.replace(kernels, coupling_coefficients=kernels.coupling_coefficients.T)


FAULTS = {
    with_coupling_turned: {"tilt_under_shear", "strain_under_pressure"},
    without_tangential_kernel: {"tangential_compliance", "tangential_curvature"},
    without_normal_kernel: {"normal_compliance", "normal_curvature"},
    with_places_exchanged: {"tilt_under_shear", "strain_under_pressure"},
}


@functools.cache
def kernels_of_unlike() -> KernelPair:
    return kernel_pair(UNLIKE, 1.3, UNLIKE.profile.datum_length, Counter())


@functools.cache
def numbers_of_unlike() -> BodyEffects:
    return halfplane_fe.body_effects(UNLIKE)


def wrong_sums(pair: KernelPair) -> set[str]:
    """What of the sums over both bodies does not begin with the numbers of `body_effects`, whose
    signs are those of the contact model (test_halfplane_fe_remainder).
    """
    x = np.linspace(-0.5, 0.5, 11)
    normal, tangential, coupling = pair.added_compliances(x, "fine")

    def series(values: np.ndarray) -> np.ndarray:
        return np.polynomial.polynomial.polyfit(x, values, 6)

    middle = len(x) // 2
    of_gap = series(normal[:, middle])
    of_slip = series(tangential[:, middle])
    of_sums = {
        "normal_compliance": of_gap[0],
        "normal_curvature": 2 * of_gap[2],
        "tangential_compliance": of_slip[0],
        "tangential_curvature": 2 * of_slip[2],
        "tilt_under_shear": -series(coupling[middle])[1],  # gap = ... - K^T q
        "strain_under_pressure": -series(coupling[:, middle])[1],
    }
    numbers = numbers_of_unlike()
    return {
        name
        for name, value in of_sums.items()
        if not abs(value / getattr(numbers, name).value - 1) <= 2e-3
    }


def test_the_sums_of_both_bodies_begin_with_their_numbers() -> None:
    assert wrong_sums(kernels_of_unlike()) == set()


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_planted_fault_is_seen_in_the_sums(fault: Fault) -> None:
    bodies = {}
    for name in ("lower", "upper"):
        body = getattr(kernels_of_unlike(), name)
        bodies[name] = dataclasses.replace(body, fine=fault(body.fine))
    assert wrong_sums(KernelPair(**bodies)) == FAULTS[fault]


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_planted_fault_moves_the_answer(fault: Fault, monkeypatch: pytest.MonkeyPatch) -> None:
    right = fitted_kernels

    def with_fault(*arguments: Any) -> FaceKernels:
        return fault(right(*arguments))

    monkeypatch.setattr(kernel_bodies, "fitted_kernels", with_fault)
    of_blocks = difference(fe_run(UNLIKE), by_kernels.__wrapped__(UNLIKE))
    assert max(abs(of_blocks.work), abs(of_blocks.approach)) > 5e-3


# ------------------------------------------------------------------------------------------ the fit
def test_the_fit_is_the_kernels_of_the_mesh() -> None:
    """At every node and force, also of a body as high as three halves of the side that may
    touch.
    """
    profile = load_scene("hertz-paper").profile
    kernels = face_kernels("lower", Block(width=4.0, height=2.0), profile, STEEL, 1000.0)
    fitted = fitted_kernels(kernels)
    of_fit = np.polynomial.chebyshev.chebgrid2d(
        kernels.x / fitted.reach,
        kernels.x_of_forces / fitted.reach,
        fitted.coupling_coefficients,
    )
    largest = np.abs(kernels.x_displacement_by_pressure).max()
    np.testing.assert_allclose(of_fit, kernels.x_displacement_by_pressure, atol=2e-3 * largest)


# -------------------------------------------------------------------------------------- what is not
def quartic_pad() -> Scene:
    """A pad that is a parabola and x^4."""
    profile = {"kind": "polynomial", "length": 1.0, "rises": [5e-3, 1e-4]}
    return load_scene("pad-on-block").vary(profile=profile, expected=[])


def test_what_kernels_do_not_cover_is_refused() -> None:
    with pytest.raises(InputError, match=r"bodies\.upper: .* the face of this pad is none"):
        halfplane_fe.solve(quartic_pad(), bodies="kernel")
    leaning = load_scene("pad-on-block").vary(load={"tilt": 1e-5})
    with pytest.raises(InputError, match="load: kernels of curved faces take P and Q alone"):
        halfplane_fe.solve(leaning, bodies="kernel")


def test_other_words_for_the_bodies_are_refused() -> None:
    with pytest.raises(InputError, match="bodies = 'meshes' is refused: it is 'meshed' or"):
        halfplane_fe.solve("blocks", bodies="meshes")  # type: ignore[call-overload]


def test_there_are_no_fields_inside_bodies_that_are_not_meshed() -> None:
    with pytest.raises(InputError, match="the answer has no meshes"):
        halfplane_fe.fields(by_kernels(UNLIKE), [1.0])
    cylinder = by_kernels(arcs_of("cylinder on block", "cycle .6 .8"))
    with pytest.raises(InputError, match="the answer has no meshes"):
        halfplane_fe.edge_tension(cylinder, [1])
    assert halfplane_fe.largest_edge_tension(cylinder) is None


def tension_beside_elements() -> float:
    """Largest difference of the edge tension at two instants, over the largest tension of the
    finite elements.
    """
    kernels = by_kernels(UNLIKE)
    elements = fe_run(UNLIKE)
    largest = halfplane_fe.largest_edge_tension(elements)
    assert largest is not None
    by_solution = []
    for solution in (kernels, elements):
        steps = [int(np.argmax(solution.tangential_load)), int(np.argmin(solution.tangential_load))]
        by_solution.append(halfplane_fe.edge_tension(solution, steps)[0])
    return float(np.abs(by_solution[0] - by_solution[1]).max()) / largest.value


def test_what_flat_bodies_add_to_the_edge_tension_is_that_of_their_meshes() -> None:
    check("kernels, coarse mesh: edge tension", tension_beside_elements())


@pytest.mark.parametrize(
    "fault", [without_tangential_kernel, with_coupling_turned], ids=lambda fault: fault.__name__
)
def test_a_planted_fault_is_seen_in_the_edge_tension(
    fault: Fault, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = FaceKernels.strain

    def of_wrong(kernels: FaceKernels, *arguments: Any) -> Any:
        return right(fault(kernels), *arguments)

    monkeypatch.setattr(FaceKernels, "strain", of_wrong)
    assert tension_beside_elements() > 0.02
