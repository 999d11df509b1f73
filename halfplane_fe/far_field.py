r"""Flamant far field: half-planes under point forces on their surface, the piece of half-plane
theory inside the FE model.

The arc of the half-disc carries the tractions t of the very nodal forces f on the contact, each at
its own place. So the multipoles of every order are there. With w(f) the displacement of the
half-plane, t(f) its tractions on the arc and B the work of these on the nodes of the arc, half-disc
and surroundings together have the energy

    min over u  { 1/2 u K u - f (u_contact + B^T u_arc) }  +  1/2 int t(f) w(f) ds  =  - 1/2 f C f

whose C is symmetric, and right but for the energy of what the elements cannot follow of w within
the half-disc. Prescribing w(f) at the nodes of the arc instead leaves a C that is symmetric only up
to the mesh of the arc.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from scenes import Elastic
from scenes.array_types import Array, Indices

# Gauss points of an element of the arc: to rounding on elements no longer than their distance from
# a force.
_N_GAUSS_POINTS = 9


def surface_force_displacement(
    x: Array,
    y: Array,
    x_of_forces: Array,
    young_modulus: float,
    poisson_ratio: float,
    datum_length: float,
) -> Array:
    r"""Displacement at points of the half-plane y <= 0 by unit forces on its surface (Flamant), in
    plane strain.

    With r the distance, z = -y, theta = atan2(x, z), G the shear modulus and c = 1/(2 pi G):

        force along x:  u_x = -c [2 (1-nu) ln(r/L) + z^2/r^2]
                        u_z =  c [x z/r^2 + (1-2 nu) theta]
        force along z:  u_x =  c [x z/r^2 - (1-2 nu) theta]
                        u_z = -c [2 (1-nu) ln(r/L) - z^2/r^2]

    so that the surface at distance L (`datum_length`) from the force does not move along the force.
    Here x is counted from the force. With w = z + i x, ln r + i theta = ln w and (z^2 - i x z)/r^2
    = z/w.

    Parameters
    ----------
    x, y
        (n,) points, y <= 0, none at a force [length]
    x_of_forces
        (m,) places of the forces on the surface [length]
    young_modulus, poisson_ratio
        E [stress] and nu of the half-plane
    datum_length
        L, distance from a force at which the surface counts as unmoved [length]

    Returns
    -------
    (2, n, 2, m)
        Displacement component (x, y), point, force component (x, y), place [length per force per
        thickness].

    Notes
    -----
    Source: Johnson, Contact Mechanics (1985), sections 2.2 and 2.3, in Cartesian form.

    Examples
    --------
    >>> at, x_of_forces = np.array([1.0]), np.zeros(1)
    >>> u = surface_force_displacement(at, np.zeros(1), x_of_forces, 2.0, 0.0, datum_length=2.0)
    >>> u[1, 0, 1, 0].round(12).tolist()  # at r = L/2: (2/(pi E)) ln 2
    0.220635600153
    """
    # Here k = 1 - 2 nu.
    shear_modulus = young_modulus / (2 * (1 + poisson_ratio))
    c = 1 / (2 * np.pi * shear_modulus)
    k = 1 - 2 * poisson_ratio
    w = -y[:, None] + 1j * (x[:, None] - x_of_forces)
    ln_w = np.log(w)
    z_over_w = -y[:, None] / w
    logarithm = (1 + k) * (ln_w.real - np.log(datum_length))
    k_theta = k * ln_w.imag
    z_squared_over_r_squared = z_over_w.real
    x_z_over_r_squared = -z_over_w.imag
    displacement_by_force_x = np.stack(
        [-c * (logarithm + z_squared_over_r_squared), -c * (x_z_over_r_squared + k_theta)]
    )
    # A force along +y is a force along -z, and u_y = -u_z.
    displacement_by_force_y = np.stack(
        [-c * (x_z_over_r_squared - k_theta), -c * (logarithm - z_squared_over_r_squared)]
    )
    return np.stack([displacement_by_force_x, displacement_by_force_y], axis=2)


def surface_force_traction(x: Array, y: Array, normal: Array, x_of_forces: Array) -> Array:
    r"""Tractions on a cut through the half-plane y <= 0 by unit forces on its surface (Flamant).

    A force F causes a radial stress alone, -(2/pi) (F . e_r)/r, with e_r the unit vector from the
    force to the point and r its distance.

    Parameters
    ----------
    x, y
        (n,) points of the cut, none at a force [length]
    normal
        (2, n) unit normal out of the part that the tractions act on. If it is multiplied by a
        length, the result is a force
    x_of_forces
        (m,) places of the forces on the surface [length]

    Returns
    -------
    (2, n, 2, m)
        Traction component (x, y), point, force component (x, y), place, by a unit force per
        thickness [1/length].

    Examples
    --------
    >>> depth, normal = np.array([-1.0]), np.array([[0.0], [-1.0]])
    >>> below = surface_force_traction(np.zeros(1), depth, normal, np.zeros(1))
    >>> round(float(below[1, 0, 1, 0]) * np.pi, 12)  # a pull of 1 is held by 2/(pi r) below it
    -2.0
    """
    # Radius vector from each force to each point, and its product with the normal.
    x_from_force = x[:, None] - x_of_forces
    y_from_force = np.broadcast_to(y[:, None], x_from_force.shape)
    radius_vector = np.stack([x_from_force, y_from_force])  # (2, n, m)
    radius_along_normal = x_from_force * normal[0][:, None] + y_from_force * normal[1][:, None]
    factor = -2 / np.pi * radius_along_normal / (x_from_force**2 + y_from_force**2) ** 2
    # i component of the traction, j of the force, n point, m place of the force
    return np.einsum("inm,jnm,nm->injm", radius_vector, radius_vector, factor)


class LineElements(NamedTuple):
    """Line elements with their Gauss quadrature: e elements with k nodes and g Gauss points each.

    Attributes
    ----------
    nodes
        (e, k) numbers of the nodes
    shapes
        (k, g) shape functions at the Gauss points
    places
        (2, e, g) x and y of the Gauss points [length]
    weighted_tangents
        (2, e, g) unit tangent times the length of line that a Gauss point stands for [length]
    """

    nodes: Indices
    shapes: Array
    places: Array
    weighted_tangents: Array


def line_elements(line: Array, order: int, n_gauss_points: int) -> LineElements:
    """Line elements of order 1 or 2 through the nodes of a line (2, n) in their order, with
    `n_gauss_points` on each: their nodes, shape functions, places, and tangents times weights.
    """
    nodes = np.arange(0, line.shape[1] - order, order)[:, None] + np.arange(order + 1)
    return curve_elements(line, nodes, n_gauss_points)


def curve_elements(places_of_nodes: Array, nodes: Indices, n_gauss_points: int) -> LineElements:
    """Line elements of order 1 or 2 along a curve: shape functions, places, and tangents times the
    quadrature weight, at Gauss points.

    Parameters
    ----------
    places_of_nodes
        (2, n) x and y of all nodes [length]
    nodes
        (e, k) numbers of the nodes of each of e elements, k = 2 or 3, in order along the curve
    n_gauss_points
        number of Gauss points on each element
    """
    # Shape functions (k, g) and their slopes in the coordinate -1 to 1 of an element.
    gauss_points, weights = np.polynomial.legendre.leggauss(n_gauss_points)
    if nodes.shape[1] == 2:
        half_slopes = np.full_like(gauss_points, 0.5)
        shape_functions = np.array([(1 - gauss_points) / 2, (1 + gauss_points) / 2])
        shape_slopes = np.array([-half_slopes, half_slopes])
    else:
        shape_functions = np.array(
            [
                gauss_points * (gauss_points - 1) / 2,
                1 - gauss_points**2,
                gauss_points * (gauss_points + 1) / 2,
            ]
        )
        shape_slopes = np.array([gauss_points - 0.5, -2 * gauss_points, gauss_points + 0.5])
    return LineElements(
        nodes=nodes,
        shapes=shape_functions,
        places=places_of_nodes[:, nodes] @ shape_functions,
        weighted_tangents=places_of_nodes[:, nodes] @ shape_slopes * weights,
    )


def arc_forces(
    arc: Array, order: int, x_of_forces: Array, material: Elastic, datum_length: float
) -> tuple[Array, Array, Array]:
    """Consistent nodal forces on the arc of a half-disc by the half-plane around it, under unit
    forces on the contact nodes: Flamant's tractions times the shape functions, integrated along
    the arc.

    Parameters
    ----------
    arc
        (2, k) places of the nodes of the arc, by ascending x [length]
    order
        1 or 2, of the elements of the arc
    x_of_forces
        (m,) x of the contact nodes [length]
    material, datum_length
        of the half-plane; distance from a force at which its surface has no displacement [length]

    Returns
    -------
    nodal_forces
        (2 k, 2 m) forces on the nodes of the arc, along x, then along y, by forces on the contact
        nodes along x, then along y
    traction_forces, displacements
        (2 g, 2 m) of the half-plane at the g Gauss points of the arc, along x, then along y, by
        the same forces. Tractions are multiplied by the length of arc of their Gauss point:
        traction_forces^T displacements is their work in the half-plane's own displacement
    """
    # Gauss points of the arc, nine an element, and the outward normal there.
    elements = line_elements(arc, order, _N_GAUSS_POINTS)
    x, y = elements.places.reshape(2, -1)
    tangent_x, tangent_y = elements.weighted_tangents
    # outward, times the length of arc of each Gauss point
    normals_by_length = np.stack([tangent_y.ravel(), -tangent_x.ravel()])

    # Tractions by unit forces, and their consistent nodal forces. In subscripts of einsum d is the
    # direction, e element, g Gauss point, m force.
    traction_forces = surface_force_traction(x, y, normals_by_length, x_of_forces).reshape(
        2, *tangent_x.shape, -1
    )
    nodal_forces = np.zeros((2, arc.shape[1], traction_forces.shape[-1]))
    for nodes, shape_values in zip(elements.nodes.T, elements.shapes, strict=True):
        nodal_forces[:, nodes] += np.einsum("g,degm->dem", shape_values, traction_forces)

    displacements = surface_force_displacement(
        x, y, x_of_forces, material.young_modulus, material.poisson_ratio, datum_length
    )
    n_components = 2 * len(x)
    return (
        nodal_forces.reshape(2 * arc.shape[1], -1),
        traction_forces.reshape(n_components, -1),
        displacements.reshape(n_components, -1),
    )
