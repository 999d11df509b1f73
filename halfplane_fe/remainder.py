r"""What a body of finite size adds to the compliance of a half-plane: the smooth remainder of its
Green's function, by one linear solve on a coarse mesh.

A force at the point s of the face displaces the body by Flamant's field u_F of a half-plane plus a
remainder u_R. All that is singular is in u_F. With t_F the tractions of u_F on a cut,

    div sigma(u_R) = 0,   u_R = -u_F on supports,   t(u_R) = -t_F on the rest of the outline

Nothing here is large at s: t_F vanishes on the flat face, and sides and base are as far away as the
body is large. So the elements need no refinement at the force, nor at the edges of a contact, and
no contact is solved. At the face u_R gives four kernels, of unit forces: P presses (against y,
which points out of the body), Q pulls along +x,

    k_nn(x, s)  displacement inwards at x by P at s       k_tt(x, s)  along x by Q
    k_tn(x, s)  along x by P                              k_nt(x, s)  outwards by Q

By Betti's theorem k_nn and k_tt are symmetric and k_tn(x, s) = -k_nt(s, x). A body whose mirror
line is x = 0, as all bodies of scenes have, has near x = s = 0

    k_nn = c_n + N (x^2 + s^2)/2 + N_11 x s + N_4 (x^4 + s^4)/24 + N_22 x^2 s^2
           + ...       k_tt likewise
    k_tn = e x - a s + ...

On a curved face the same solve holds, with the half-plane of the force below a horizontal line
through the true place of it. t_F is not 0 on the face then, but bounded: -(F e_r) kappa/pi at the
force on an arc of curvature kappa. The kernels count from Flamant's field on the flat face, so that
what the slope m = dy/dx of the chord from s to x makes of it is added::

    ln r          + ln(1 + m^2)/2           x z/r^2       - m/(1 + m^2)
    z^2/r^2       + m^2/(1 + m^2)           theta         + arctan m

Directions stay those of the frame: x and y, not the tangent.

What c_n and c_t are depends on the datum length L of the half-plane: u_F counts from no movement of
the surface at the distance L from the force, along the force.

`body_effects` takes these numbers of both bodies of a scene and adds them up with the signs of the
relative problem; see `scenes.BodyEffects`.

Source of u_F and t_F: Johnson, Contact Mechanics (1985), sections 2.2 and 2.3, see `far_field`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import skfem

from halfplane_fe.dundurs import dundurs
from halfplane_fe.elasticity import System, assemble, factorise
from halfplane_fe.far_field import (
    curve_elements,
    surface_force_displacement,
    surface_force_traction,
)
from halfplane_fe.path import has_bulk_stress
from halfplane_fe.supports import shapes_alike
from meshes import BodyMesh, MeshSettings, Solid, SurfaceGrading, build
from scenes import (
    Block,
    BodyEffects,
    Elastic,
    Estimate,
    HalfPlane,
    InputError,
    Profile,
    Scene,
    Shape,
    TShape,
    scene_of,
)
from scenes.array_types import Array, Indices

# Gauss points of a facet: Flamant's tractions are smooth over an element, which is shorter than its
# distance from the force.
_POINTS = 9
# The part of the face that the kernels are fitted on, |x| <= r: r over the distance of the nearest
# place where the face or the material below it ends. Terms that the polynomial lacks are then below
# 1e-4 of the numbers.
_REACH = 0.3
# Forces stand at these places over r: what s^4 does is seen too. Forces at x < 0 would repeat them
# as mirror images.
_FORCES = (0.0, 0.5, 1.0)
# Largest degree of the polynomials in x and s together.
_DEGREE = 8
# Elements on 0 <= x <= r, and growth of their size with the distance from there.
_ELEMENTS = 16
_GROWTH = 0.1
# The second mesh, by which the first one's error is judged: elements so many times as large, fitted
# on a part of the face so many times as wide. The difference of the two also has the terms that the
# polynomials lack.
_COARSER = 2.0
_WIDER = 1.25


class RemainderKernels(NamedTuple):
    """Displacement of a body's face by unit forces on it, minus that of a half-plane.

    Attributes
    ----------
    x
        (n,) places on the face, in ascending order [length]
    forces_at
        (m,) places of the forces [length]
    normal, tangential
        (n, m) k_nn and k_tt [1 / stress]
    along_by_pressure, outward_by_shear
        (n, m) k_tn and k_nt [1 / stress]
    unknowns
        degrees of freedom of the linear system, which is factorised once
    """

    x: Array
    forces_at: Array
    normal: Array
    tangential: Array
    along_by_pressure: Array
    outward_by_shear: Array
    unknowns: int

    @property
    def reciprocity_gap(self) -> float:
        """Largest |k_tn(x, s) + k_nt(s, x)| of places s of forces: 0 in exact elasticity
        [1 / stress].
        """
        nodes = np.abs(self.x[:, None] - self.forces_at).argmin(axis=0)
        gap = self.along_by_pressure[nodes] + self.outward_by_shear[nodes].T
        return float(np.abs(gap).max())


def remainder_kernels(
    body: BodyMesh, material: Elastic, forces_at: Array, datum_length: float
) -> RemainderKernels:
    """The kernels of a body, by one factorisation of its stiffness: displacements of its face by
    unit forces on the face, minus those of a half-plane.

    Parameters
    ----------
    body
        a mesh of quadratic elements, with supports that hold it; "contact" is the part of the
        face that is read
    material
        of the body
    forces_at
        (m,) places of the forces on the face [length]; on a curved one the nodes of "contact"
        next to them
    datum_length
        L, distance from a force at which a half-plane's surface counts as unmoved [length]

    Notes
    -----
    Above nu = 1/3 the elements are those of Taylor and Hood, see `elasticity`: the kernels do not
    lock.
    """
    system = assemble(body, material)
    n_dofs = len(system.node)
    held_dofs = system.held
    free_dofs = np.setdiff1d(np.arange(n_dofs), held_dofs)
    x, y = body.mesh.p[:, system.node[system.contact[0]]]
    forces = _SurfaceForces(forces_at, np.zeros(len(forces_at)))
    if y.any():
        force_nodes = np.abs(x[:, None] - forces_at).argmin(axis=0)
        forces = _SurfaceForces(x[force_nodes], y[force_nodes])
    n_forces = len(forces_at)
    forced_loads = np.zeros((n_dofs, 2 * n_forces))
    forced_loads[: 2 * body.mesh.p.shape[1]] = -_tractions(system, forces)
    displacements = np.zeros_like(forced_loads)
    displacements[held_dofs] = -_support_displacements(system, forces, datum_length)
    forced_loads -= system.stiffness[:, held_dofs] @ displacements[held_dofs]
    factorisation = factorise(system.stiffness[free_dofs][:, free_dofs].tocsc())
    displacements[free_dofs] = factorisation.solve(forced_loads[free_dofs])
    displacement_along, displacement_out = displacements[system.contact].reshape(2, -1, 2, n_forces)
    kernels = RemainderKernels(
        x=x,
        forces_at=forces.x,
        normal=displacement_out[:, 1],  # a pull moves the face out as far as a push moves it in
        tangential=displacement_along[:, 0],
        along_by_pressure=-displacement_along[:, 1],
        outward_by_shear=displacement_out[:, 0],
        unknowns=len(free_dofs),
    )
    return _with_slopes(kernels, y, forces.y, material) if y.any() else kernels


class _SurfaceForces(NamedTuple):
    """Places of forces on the face, (m,) each."""

    x: Array
    y: Array


def _of_forces(
    field: Callable[[Array, Array, Array], Array], x: Array, y: Array, forces: _SurfaceForces
) -> Array:
    """(2, n, 2, m) a field of half-planes, each below its force, at points (n,)."""
    if not forces.y.any():
        return field(x, y, forces.x)
    of_each = [
        field(x, y - height, np.array([place]))
        for place, height in zip(forces.x, forces.y, strict=True)
    ]
    return np.concatenate(of_each, axis=-1)


def _with_slopes(
    kernels: RemainderKernels, y: Array, heights: Array, material: Elastic
) -> RemainderKernels:
    """The kernels with Flamant's field on the curved face minus that on the flat one.

    Parameters
    ----------
    y, heights
        (n,), (m,) of the face at the places and at the forces [length]
    """
    distance_to_force = kernels.x[:, None] - kernels.forces_at
    is_at_force = distance_to_force == 0
    chord_slope = (y[:, None] - heights) / np.where(is_at_force, 1.0, distance_to_force)
    face_slope = np.gradient(y, kernels.x, edge_order=2)
    slope = np.where(is_at_force, face_slope[:, None], chord_slope)
    kernels_of_chord = kernels_of_slope(slope, material)
    return kernels._replace(
        normal=kernels.normal + kernels_of_chord.normal,
        tangential=kernels.tangential + kernels_of_chord.tangential,
        along_by_pressure=kernels.along_by_pressure + kernels_of_chord.along_by_pressure,
        outward_by_shear=kernels.outward_by_shear + kernels_of_chord.outward_by_shear,
    )


class KernelsOfSlope(NamedTuple):
    """What the slope of chords makes of Flamant's field, of its shape: k_nn, k_tt, k_tn, k_nt."""

    normal: Array
    tangential: Array
    along_by_pressure: Array
    outward_by_shear: Array


def kernels_of_slope(slope: Array, material: Elastic) -> KernelsOfSlope:
    """Flamant's field at the end of a chord of a slope minus that on the flat face."""
    # notation: c = 1/(2 pi G), k = 1 - 2 nu, as in `far_field`
    c = (1 + material.poisson_ratio) / (np.pi * material.young_modulus)
    k = 1 - 2 * material.poisson_ratio
    logarithmic_part = (1 + k) * np.log1p(slope**2) / 2
    depth_part = slope**2 / (1 + slope**2)
    cross_part = slope / (1 + slope**2)
    turned_part = k * np.arctan(slope)
    return KernelsOfSlope(
        normal=-c * (logarithmic_part - depth_part),
        tangential=-c * (logarithmic_part + depth_part),
        along_by_pressure=-c * (cross_part + turned_part),
        outward_by_shear=c * (cross_part - turned_part),
    )


def _tractions(system: System, forces: _SurfaceForces) -> Array:
    """(n_dofs of displacement, 2 m) nodal forces of a half-plane's tractions by m unit forces on
    the face (Flamant's solution) on the outline of the body, columns: m forces along x, then m
    along y. On a flat face there are none; what supports hold takes no part.
    """
    mesh = system.mesh
    free_of_traction = () if forces.y.any() else ("contact", "free")
    loaded_facets = np.concatenate(
        [of_side for name, of_side in mesh.boundaries.items() if name not in free_of_traction]
    )
    # an even number: of an odd one the middle point is the node in the middle, where a force may be
    n_points = _POINTS + 1 if forces.y.any() else _POINTS
    elements = curve_elements(mesh.p, _outline_nodes(mesh, loaded_facets), n_points)
    along_x, along_y = elements.tangents
    normals_by_length = np.stack([along_y.ravel(), -along_x.ravel()])  # outward, times the length
    x, y = elements.places.reshape(2, -1)

    def traction(at_x: Array, at_y: Array, force_at: Array) -> Array:
        return surface_force_traction(at_x, at_y, normals_by_length, force_at)

    tractions = _of_forces(traction, x, y, forces).reshape(2, *along_x.shape, -1)
    work_of_nodes = np.zeros((mesh.p.shape[1], 2, tractions.shape[-1]))
    for nodes, shape_values in zip(elements.nodes.T, elements.shapes, strict=True):
        np.add.at(work_of_nodes, nodes, np.einsum("g,degm->edm", shape_values, tractions))
    return work_of_nodes.reshape(-1, tractions.shape[-1])


def _outline_nodes(mesh: skfem.Mesh, facets: Indices) -> Indices:
    """(e, 3) nodes of facets of the outline of a quadratic mesh, with the body on their left."""
    start_vertices, end_vertices = mesh.facets[:, facets]
    inner_points = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1)
    edge_vectors = mesh.p[:, end_vertices] - mesh.p[:, start_vertices]
    inward_vectors = inner_points - mesh.p[:, start_vertices]
    is_body_on_right = edge_vectors[0] * inward_vectors[1] - edge_vectors[1] * inward_vectors[0] < 0
    first_node = np.where(is_body_on_right, end_vertices, start_vertices)
    last_node = np.where(is_body_on_right, start_vertices, end_vertices)
    return np.stack([first_node, mesh.nvertices + facets, last_node], axis=1).astype(np.int64)


def _support_displacements(system: System, forces: _SurfaceForces, datum_length: float) -> Array:
    """Displacements of the supports by unit forces on the surface of a half-plane (Flamant),
    (n_held, 2 m) [1 / stress]: of each held degree of freedom, by the m forces along x and the m
    forces along y.

    `datum_length` is the distance from a force at which the half-plane's surface counts as unmoved
    [length].
    """
    material = system.material

    def displacement(at_x: Array, at_y: Array, force_at: Array) -> Array:
        return surface_force_displacement(
            at_x, at_y, force_at, material.young_modulus, material.poisson_ratio, datum_length
        )

    x, y = system.mesh.p[:, system.node[system.held]]
    component = system.held % 2
    of_held = _of_forces(displacement, x, y, forces)[component, np.arange(len(x))]
    return of_held.reshape(len(x), -1)


# ------------------------------------------------------------------------------ numbers of one body
@dataclass(frozen=True)
class BodyNumbers:
    """What one body adds, in its own frame: x along the face, y outward, first contact at the
    origin; formulas: the module.

    Attributes
    ----------
    normal_compliance, tangential_compliance
        c_n, c_t [1 / stress]
    normal_curvature, tangential_curvature
        N, T [1 / (stress length^2)]
    strain_under_pressure
        e, strain of the face along x by P = 1 [1 / (stress length)]
    slope_under_shear
        a, slope of the outward displacement by Q = 1 [1 / (stress length)]
    normal_fourth, tangential_fourth
        N_4, T_4 [1 / (stress length^4)]
    normal_mixed, tangential_mixed
        N_22, T_22 [1 / (stress length^4)]
    unknowns, factorisations
        of the linear systems that were solved
    """

    normal_compliance: Estimate
    tangential_compliance: Estimate
    normal_curvature: Estimate
    tangential_curvature: Estimate
    strain_under_pressure: Estimate
    slope_under_shear: Estimate
    normal_fourth: Estimate
    tangential_fourth: Estimate
    normal_mixed: Estimate
    tangential_mixed: Estimate
    unknowns: int
    factorisations: int


class FaceSeries(NamedTuple):
    """The first coefficients of the kernels at x = s = 0, as in `BodyNumbers`, without errors."""

    normal_compliance: float
    tangential_compliance: float
    normal_curvature: float
    tangential_curvature: float
    strain_under_pressure: float
    slope_under_shear: float
    normal_fourth: float
    tangential_fourth: float
    normal_mixed: float
    tangential_mixed: float


_ZERO = Estimate(0.0)
OF_HALF_PLANE = BodyNumbers(
    **dict.fromkeys(FaceSeries._fields, _ZERO), unknowns=0, factorisations=0
)


def face_series(kernels: RemainderKernels, degree: int = _DEGREE) -> FaceSeries:
    """Least-squares fit of polynomials in x and s to the kernels of a body whose mirror line is x =
    0.

    k_nn and k_tt consist of x^i s^j + x^j s^i with even i + j: they are symmetric in x and s, and
    in the mirror line. k_tn and -k_nt, places exchanged, are one polynomial with odd i + j.
    """
    reach = float(np.abs(kernels.x).max())
    x, s = np.meshgrid(kernels.x / reach, kernels.forces_at / reach, indexing="ij")
    even_powers = [(i, j) for i, j in even_exponents(degree) if i <= j]
    even_terms = np.stack([(x**i * s**j + x**j * s**i).ravel() for i, j in even_powers], axis=1)
    kernels_of_one_load = np.stack([kernels.normal.ravel(), kernels.tangential.ravel()], axis=1)
    coefficients = np.linalg.lstsq(even_terms, kernels_of_one_load, rcond=None)[0]
    compliance = 2 * coefficients[even_powers.index((0, 0))]
    curvature = 2 * coefficients[even_powers.index((0, 2))] / reach**2
    fourth_order = 24 * coefficients[even_powers.index((0, 4))] / reach**4
    mixed = 2 * coefficients[even_powers.index((2, 2))] / reach**4

    odd_powers = odd_exponents(degree)
    by_pressure = np.stack([(x**i * s**j).ravel() for i, j in odd_powers], axis=1)
    by_shear = np.stack([(s**i * x**j).ravel() for i, j in odd_powers], axis=1)
    cross_kernels = np.concatenate(
        [kernels.along_by_pressure.ravel(), -kernels.outward_by_shear.ravel()]
    )
    slopes = (
        np.linalg.lstsq(np.concatenate([by_pressure, by_shear]), cross_kernels, rcond=None)[0]
        / reach
    )
    return FaceSeries(
        normal_compliance=float(compliance[0]),
        tangential_compliance=float(compliance[1]),
        normal_curvature=float(curvature[0]),
        tangential_curvature=float(curvature[1]),
        strain_under_pressure=float(slopes[odd_powers.index((1, 0))]),
        slope_under_shear=-float(slopes[odd_powers.index((0, 1))]),
        normal_fourth=float(fourth_order[0]),
        tangential_fourth=float(fourth_order[1]),
        normal_mixed=float(mixed[0]),
        tangential_mixed=float(mixed[1]),
    )


def even_exponents(degree: int) -> list[tuple[int, int]]:
    """(i, j) of x^i s^j with even sums i + j up to the degree."""
    return _exponents(range(0, degree + 1, 2))


def odd_exponents(degree: int) -> list[tuple[int, int]]:
    """The same with odd sums."""
    return _exponents(range(1, degree, 2))


def _exponents(totals: Iterable[int]) -> list[tuple[int, int]]:
    """(i, j) of x^i s^j with each of the sums i + j."""
    exponents = []
    for total in totals:
        exponents += [(i, total - i) for i in range(total + 1)]
    return exponents


def face_kernels(
    name: str,
    shape: Solid,
    profile: Profile,
    material: Elastic,
    datum_length: float,
    coarser: float = 1.0,
) -> RemainderKernels:
    """The kernels of a body of a scene on the part of its face that is fitted: displacements by
    unit forces on the face, minus those of a half-plane.

    Parameters
    ----------
    name
        "lower" or "upper"
    shape, profile, material
        the body, the profile of its face, its elastic constants
    datum_length
        distance from a force at which a half-plane's surface counts as unmoved [length]
    coarser
        how many times as large the elements are as those of the numbers; the part of the face
        is wider too
    """
    reach = _REACH * nearest_end(shape)
    if coarser > 1:
        reach *= _WIDER
    size = coarser * reach / _ELEMENTS
    grading = SurfaceGrading(inner=0.0, outer=reach, size=size, edge_size=size)
    body = build(name, shape, profile, grading, MeshSettings(growth=coarser * _GROWTH))
    return remainder_kernels(body, material, reach * np.array(_FORCES), datum_length)


def body_numbers(
    name: str, shape: Solid, profile: Profile, material: Elastic, datum_length: float
) -> BodyNumbers:
    """What a body of a scene adds to a half-plane: compliances, curvatures, slope and strain, each
    with the difference from a coarser mesh as its uncertainty.

    e and a, the strain by P and the slope by Q, are one kernel read by two solutions, of which the
    larger |k_tn(x, s) + k_nt(s, x)| over the fitted half-length is added to theirs. `name` is lower
    or upper; `datum_length` the distance at which a half-plane's surface counts as unmoved
    [length].
    """
    kernels = face_kernels(name, shape, profile, material, datum_length)
    coarse_kernels = face_kernels(name, shape, profile, material, datum_length, _COARSER)
    values = face_series(kernels)
    coarse_values = face_series(coarse_kernels)
    reciprocity_error = kernels.reciprocity_gap / float(np.abs(kernels.x).max())
    estimates = {}
    for number in FaceSeries._fields:
        value = getattr(values, number)
        uncertainty = abs(value - getattr(coarse_values, number))
        if number in ("strain_under_pressure", "slope_under_shear"):
            uncertainty += reciprocity_error
        estimates[number] = Estimate(value, uncertainty)
    return BodyNumbers(
        **estimates, unknowns=kernels.unknowns + coarse_kernels.unknowns, factorisations=2
    )


def nearest_end(shape: Solid) -> float:
    """Distance from the middle of the face to the nearest place where the body ends [length]."""
    return min(shape.face_half_width, shape.least_depth)


# ----------------------------------------------------------------------------- both bodies together
def body_effects(scene: Scene | str | Path) -> BodyEffects:
    """What the finite bodies of a scene add to half-plane theory, by linear solves without contact.

    Of each body but half-planes: two linear systems, about a second. Loads, friction and profile of
    the scene don't matter, but for the datum length.

    Returns
    -------
    BodyEffects
        Sums and differences over both bodies, with the signs that are stated there; zero for
        half-planes. Each uncertainty is that of the meshes.

    Raises
    ------
    InputError
        For bodies that are not covered: curved faces (pads, cylinders), rollers with free sides,
        which hold no Q, and blocks whose ends a bulk stress pulls.

    Examples
    --------
    >>> from scenes import load_scene
    >>> effects = body_effects(load_scene("blocks"))
    >>> effects.factorisations, effects.strain_under_pressure.value  # two equal blocks
    (2, 0.0)
    """
    scene = scene_of(scene)
    lower = _numbers_in(scene, "lower")
    upper = lower if shapes_alike(scene) else _numbers_in(scene, "upper")
    return combined(lower, upper, scene)


def _numbers_in(scene: Scene, name: Literal["lower", "upper"]) -> BodyNumbers:
    """Those of one body of the scene; zeros of a half-plane."""
    shape = getattr(scene.bodies, name)
    if isinstance(shape, HalfPlane):
        return OF_HALF_PLANE
    require_flat(name, shape, scene)
    material = getattr(scene.material, name)
    return body_numbers(name, shape, scene.profile, material, scene.profile.datum_length)


def require_flat(name: str, shape: Shape, scene: Scene) -> None:
    """InputError for a body, or loads on it, for which the effects of finite bodies are not
    derived.

    They are for flat faces that hold a tangential load, without bulk stress. `name` is lower or
    upper.
    """
    if not isinstance(shape, Block | TShape):
        raise InputError(
            f"bodies.{name}: body effects are known for flat faces, and that of a {shape.kind} is"
            " curved; take a block or a t_shape, or solve the scene with finite elements,"
            " `halfplane fe`; in Python, for arcs and flats between them, also"
            ' `solve(scene, bodies="kernel")`'
        )
    if isinstance(shape, Block) and shape.base == "rollers" and shape.sides == "free":
        raise InputError(
            f"bodies.{name}: a body on rollers with free sides holds no tangential load, and its"
            " effects are not known; take base = 'fixed' or sides = 'guided'"
        )
    if not scene.load.is_driven and has_bulk_stress(scene.load.path()):
        raise InputError(
            f"load.bulk_stress_{name}: body effects are known for P and Q, not for the bulk stress"
            " of a body; solve the scene with finite elements"
        )


def combined(lower: BodyNumbers, upper: BodyNumbers, scene: Scene) -> BodyEffects:
    """Numbers of both bodies in the relative problem: compliances and curvatures add up; of the
    strains e and the slopes a the differences count, e_P = e_l - e_u of the `lower` less the
    `upper` body and alpha_Q = a_u - a_l.

    P presses both bodies alike; Q pulls the lower one along +x and the upper one along -x, and the
    upper body's y axis points the other way. So the two strains along x by P have one sign in the
    common frame and their difference is a slip, and so it is with the slopes by Q. Where `upper` is
    `lower` itself one body stands for both, and these differences are 0. Of the `scene` datum
    length and elastic constants count.
    """
    effects = BodyEffects(
        datum_length=scene.profile.datum_length,
        normal_compliance=_sum(lower.normal_compliance, upper.normal_compliance),
        tangential_compliance=_sum(lower.tangential_compliance, upper.tangential_compliance),
        normal_curvature=_sum(lower.normal_curvature, upper.normal_curvature),
        tangential_curvature=_sum(lower.tangential_curvature, upper.tangential_curvature),
        tilt_under_shear=_difference(upper.slope_under_shear, lower.slope_under_shear),
        strain_under_pressure=_difference(lower.strain_under_pressure, upper.strain_under_pressure),
        normal_fourth=_sum(lower.normal_fourth, upper.normal_fourth),
        tangential_fourth=_sum(lower.tangential_fourth, upper.tangential_fourth),
        normal_mixed=_sum(lower.normal_mixed, upper.normal_mixed),
        tangential_mixed=_sum(lower.tangential_mixed, upper.tangential_mixed),
        dundurs_beta=dundurs(scene.material).beta,
        unknowns=lower.unknowns + upper.unknowns,
        factorisations=lower.factorisations + upper.factorisations,
    )
    if upper is not lower:
        return effects
    # One body stands for both: its errors cancel from the differences, and it was solved once.
    return replace(
        effects,
        tilt_under_shear=_ZERO,
        strain_under_pressure=_ZERO,
        unknowns=lower.unknowns,
        factorisations=lower.factorisations,
    )


def _sum(first: Estimate, second: Estimate) -> Estimate:
    """Errors may have one sign: they add up."""
    return Estimate(first.value + second.value, first.uncertainty + second.uncertainty)


def _difference(first: Estimate, second: Estimate) -> Estimate:
    """Errors may have opposite signs: they add up."""
    return Estimate(first.value - second.value, first.uncertainty + second.uncertainty)
