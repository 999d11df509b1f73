r"""What a contour that is no parabola does to friction: a body's tangential compliance changes in the first power of its slope.

A body lies above y = h(x), its face. Let q be the shear on it, s(x) = -(2/pi) PV int q(xi)/(x - xi) dxi the stress along its
surface by half-plane theory, E' = E/(1 - nu^2). Moved from y = h to y = 0 at first order in the slope,

- the shear condition asks for the traction -(h s)' more: the stress along the surface meets the slope;
- the normal condition asks for (h q)', a local couple, and the displacement is taken at y = h: together they move the surface by
  -4 h q/E' and by nothing else, whatever nu is.

-(h s)' moves the surface by (4/(pi^2 E')) PV int h(t)/(t - x) PV int q(xi)/(t - xi) dxi dt. Poincare and Bertrand's formula
changes the order of the two and leaves 4 h q/E', which the local part takes away. What shear moves the surface by besides is

    du(x) = (4/(pi^2 E')) int K(x, xi) q(xi) dxi,   K = [Phi(x) - Phi(xi)]/(x - xi),   Phi(x) = PV int h(t)/(t - x) dt

Of a parabola Phi is linear, K one number and du a tangential displacement: no figure moves. Of the flat with rounded edges,
|x| < b,

    2 R Phi = (x + b)^2 ln |x + b| - (x - b)^2 ln |x - b|  + a linear part, which is left out

A pressure adds nothing to the gap at this order: its stress at the surface is hydrostatic, and what is local cancels. What pressure
and shear do to each other by h' is odd, and counts in its square by the two mirrors, unless the higher of two peaks is asked for.

Work follows without another solution. At constant P the energy of the shear, least among those that friction holds, is G(Q); its
change is that of its kernel alone, at the known q = f [p(x, P) - p(x, P - Q/f)], and by Masing a cycle between -Q and Q dissipates

    W = 4 (Q G'(Q) - 2 G(Q)),   dG = int int dk q q/2,   dG' = int int dk q m,   m = 1/(pi sqrt(c^2 - x^2)), c = a(P - Q/f)

Source: derived here; Ciavarella (1998) and Jaeger (1998) for q; docs/maps.md has what finite elements say of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import xlogy

from scenes import Elastic, FlatRounded, Hertz, Materials
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import Contact, contact_of

Array = NDArray[np.float64]
_NODES = 24
_ALIKE = Materials(upper=Elastic(young_modulus=2.0, poisson_ratio=0.0), lower=Elastic(young_modulus=2.0, poisson_ratio=0.0))


def potential(x: Array, flat: float) -> Array:
    """Phi (n,) at x (n,) of a flat of half-length `flat` with edges of radius 1, its linear part left out.

    >>> potential(np.array([0.0, 1.0]), 1.0).round(6).tolist()
    [0.0, 1.386294]
    """
    return (xlogy((x + flat) ** 2, np.abs(x + flat)) - xlogy((x - flat) ** 2, np.abs(x - flat))) / 2


def kernel(x: Array, xi: Array, flat: float) -> Array:
    """K (n, m) between points x (n,) and xi (m,): the slope of Phi where they coincide."""
    apart = x[:, None] - xi[None, :]
    there = apart == 0
    slope = xlogy(x + flat, np.abs(x + flat)) - xlogy(x - flat, np.abs(x - flat)) + flat
    quotient = (potential(x, flat)[:, None] - potential(xi, flat)[None, :]) / np.where(there, 1.0, apart)
    return np.where(there, slope[:, None], quotient)


def work_constant(flat: float, ratio: float, nodes: int = _NODES) -> float:
    """k of W = (1 + k a/R) times that of half-planes, for one body whose face is flat with rounded edges, and one half-plane alike.

    P is constant and Q goes to and fro; both bodies have one E'. Of 24 nodes a part the rule leaves 1e-6 up to b/a = 0.99.

    Parameters
    ----------
    flat : b/a, at least 0 (a cylinder) and less than 1
    ratio : half of the range of Q over f P, above 0 and less than 1
    nodes : of the rule in each part

    >>> round(work_constant(0.5, 0.6), 4)
    -0.4603
    """
    # notation: a = R = E* = f = 1, so that E' = 2; stuck P - Q/f, load P
    contact = contact_of(FlatRounded(radius=1.0, flat_half_length=flat) if flat > 0 else Hertz(radius=1.0), _ALIKE)
    load = float(contact.load(1.0))
    stuck, shear = (1 - ratio) * load, ratio * load
    edge = float(contact.half_width(stuck))
    angle, weight = _angles((flat, edge, 1.0), nodes)
    x = np.sin(angle)
    force = (contact.pressure(x, load) - contact.pressure(x, stuck)) * np.cos(angle) * weight
    within, share = _angles((flat / edge, 1.0), nodes)
    punch = share / np.pi @ kernel(edge * np.sin(within), x, flat) @ force
    change = 4 * (2 / np.pi**2) * (shear * punch - force @ kernel(x, x, flat) @ force)
    return float(change) / _half_plane_work(contact, load, stuck)


def share_of(body: Elastic, materials: Materials) -> float:
    """2 E*/E' of the body that is curved, by which its law counts: 1 for like materials, 2 on a rigid half-plane.

    >>> round(share_of(_ALIKE.upper, _ALIKE), 12)
    1.0
    """
    return 2 * composite_modulus(materials) * (1 - body.poisson_ratio**2) / body.young_modulus


def _half_plane_work(contact: Contact, load: float, stuck: float) -> float:
    """W = 4 (Q U - 2 G) of half-planes, f = E* = 1, U(Q) the shift."""
    (whole, whole_sum), (held, held_sum) = (
        (float(contact.log_distance(p)), p * float(contact.log_distance(p)) - float(contact.log_moment(p))) for p in (load, stuck)
    )
    shift = 2 / np.pi * (whole - held)
    twice_energy = 4 / np.pi * ((load - stuck) * whole - (whole_sum - held_sum))
    return float(4 * ((load - stuck) * shift - twice_energy))


def _angles(ends: tuple[float, ...], nodes: int) -> tuple[Array, Array]:
    """Angles and weights (n,) of a rule over sin(angle) from -1 to 1, cut at +-`ends` and dense there (roots, logarithms)."""
    cuts = np.unique(np.arcsin([0.0, *ends]))
    s, weight = np.polynomial.legendre.leggauss(nodes)
    s, weight = (s + 1) / 2, weight / 2
    begin, length = cuts[:-1, None], np.diff(cuts)[:, None]
    angle = (begin + length * s**2 * (3 - 2 * s)).ravel()
    share = (length * 6 * s * (1 - s) * weight).ravel()
    return np.concatenate([-angle[::-1], angle]), np.concatenate([share[::-1], share])
