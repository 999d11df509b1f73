"""What a finite body, or a face that is no parabola, adds to half-plane theory. Derivations: docs/maps.md."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import xlogy

from scenes import Elastic, FlatRounded, Hertz, Materials
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import Contact, contact_of

Array = NDArray[np.float64]
Base = Literal["fixed", "rollers"]
_FAR = 40.0  # L - 1 of a layer decays like w^2 exp(-2 w)
_CELLS, _STEPS = 600, 400  # of the memory curve and of an ellipse: W of half-planes is then met to 2e-4
_NOTHING = 1e-9  # full stick leaves round-off of the order of 1e-16
_NODES = 24  # a part of the rule for contours: 1e-6 up to b/a = 0.99


# ----------------------------------------------------------------------------------------------------------------- layers
def response(base: Base, tangential: bool, poisson_ratio: float) -> Callable[[Array], Array]:
    """L(w) of a layer that is fixed to its base or slides on it, for normal or tangential forces (Johnson 1985, section 5.8)."""
    kappa, sense = 3 - 4 * poisson_ratio, 1.0 if tangential else -1.0

    def fixed(w: Array) -> Array:
        low = 2 * kappa * np.sinh(2 * w) + sense * 4 * w
        return np.asarray(low / (2 * kappa * np.cosh(2 * w) + 1 + kappa**2 + 4 * w**2))

    def sliding(w: Array) -> Array:
        return np.asarray((np.cosh(2 * w) + sense) / (2 * w + np.sinh(2 * w)))

    return fixed if base == "fixed" else sliding


def curvature_sum(base: Base, *, tangential: bool = False, poisson_ratio: float = 0.3, aspect: float = np.inf) -> float:
    """S = int (L(w) - 1) w dw of a layer, or its sum for a block between smooth walls whose width is `aspect` times its height.

    >>> round(-curvature_sum("fixed") / 4, 4)
    0.358
    """
    layer = response(base, tangential, poisson_ratio)
    if np.isinf(aspect):
        return float(quad(lambda w: (layer(np.array(w)) - 1) * w, 1e-12, _FAR, limit=200)[0])
    # Walls are a row of images; zeta(-1) is what the same sum does to L = 1.
    step = 2 * np.pi / aspect
    w: Array = step * (np.arange(1.0, int(_FAR / step) + 2) - (0.5 if tangential else 0.0))
    return float(np.sum((layer(w) - 1) * w * step)) + (step**2 / 24 if tangential else -(step**2) / 12)


# ------------------------------------------------------------------------------------- half-planes with a quadratic part more
@dataclass(frozen=True)
class Curvatures:
    """nu and tau: what finite bodies add to the relative curvature under P0, normal and tangential, as shares of 1/R."""

    normal: float
    tangential: float

    def pressure_error(self) -> float:
        """Peak pressure over that of half-planes, minus 1, at P0.

        >>> round(Curvatures(0.02, 0.0).pressure_error(), 6)
        0.00995
        """
        return float(np.sqrt(1 + self.normal)) - 1

    def half_width_error(self) -> float:
        """Half-width over that of half-planes, minus 1, at P0."""
        return 1 / float(np.sqrt(1 + self.normal)) - 1


def dissipation(normal_load: Array, tangential_load: Array, friction: float, added: Curvatures, last: int) -> float:
    """Friction work of the last `last` steps, a closed cycle, over A P0^2/pi.

    Parameters
    ----------
    normal_load, tangential_load : path from rest (n,), over P0; straight between its points
    friction : coefficient
    added : what the bodies add; (0, 0) for half-planes
    last : steps of the closed cycle at the end
    """
    shift, q = _shifts(normal_load, tangential_load, friction, added)[-last - 1 :], tangential_load[-last - 1 :]
    return float(np.sum((q[1:] + q[:-1]) / 2 * np.diff(shift)))


def dissipation_error(normal_load: Array, tangential_load: Array, friction: float, added: Curvatures, last: int) -> float:
    """Friction work over that of half-planes on the same path and steps, less 1; NaN where these dissipate nothing."""
    path = (normal_load, tangential_load, friction)
    plain = dissipation(*path, Curvatures(0.0, 0.0), last)
    return dissipation(*path, added, last) / plain - 1 if plain > _NOTHING * friction**2 else float("nan")


def _shifts(normal_load: Array, tangential_load: Array, friction: float, added: Curvatures) -> Array:
    """Tangential displacement (n,) over A P0/pi, its constant part left out: it does no work in a cycle."""
    # notation: g = alpha^2 of the cells' borders, M = force of the punches up to alpha, frozen = M less that of the curvature tau Q
    nu, tau = added.normal, added.tangential
    square = normal_load / (1 + nu * normal_load)
    g = np.linspace(0.0, float(np.max(square)), _CELLS + 1)
    # Mean of log(1/alpha) + tau alpha^2/2 over each cell.
    mean = np.diff((g - xlogy(g, g)) / 2) / np.diff(g) + tau * (g[1:] + g[:-1]) / 4
    weights = -np.diff(mean, prepend=0.0, append=0.0)  # of M at the borders instead of m in the cells
    frozen, before, shifts = np.zeros_like(g), 0.0, np.empty(len(normal_load))
    for number, (p, q, here) in enumerate(zip(normal_load, tangential_load, square, strict=True)):
        edge = int(np.searchsorted(g, here))
        carried = np.full_like(g, q)
        carried[:edge] = frozen[:edge] + tau * q * np.minimum(g[:edge], before)
        if here > before:
            first, start = int(np.searchsorted(g, before, side="right")), float(np.interp(before, g, frozen)) + tau * q * before
            carried[first:edge] = start + (q - start) * (g[first:edge] - before) / (here - before)
        # What friction can carry outside alpha.
        bound = friction * (1 + nu * p) * (here - g[:edge])
        np.clip(carried[:edge], q - bound, q + bound, out=carried[:edge])
        shifts[number] = carried @ weights
        frozen, before = carried - tau * q * np.minimum(g, here), float(here)
    return shifts


def ellipse_path(normal_amplitude: float, mean: float, amplitude: float, phase: float) -> tuple[Array, Array, int]:
    """P/P0 (n,) and Q/P0 (n,) of two turns of an ellipse from rest, straight to where Q is least, and the steps of a turn.

    Loads are over P0, the phase in rad.
    """
    t = phase + np.pi + np.linspace(0.0, 4 * np.pi, 2 * _STEPS + 1)
    p, q = 1 + normal_amplitude * np.cos(t), mean + amplitude * np.cos(t - phase)
    way = np.linspace(0.0, 1.0, 100)[1:-1]
    return np.concatenate([way * p[0], p]), np.concatenate([way * q[0], q]), _STEPS


# ---------------------------------------------------------------------------------------------- contours that are no parabola
def potential(x: Array, flat: float) -> Array:
    """Phi (n,) at x (n,) of a flat of half-length `flat` with edges of radius 1, its linear part left out.

    >>> potential(np.array([0.0, 1.0]), 1.0).round(6).tolist()
    [0.0, 1.386294]
    """
    return (xlogy((x + flat) ** 2, np.abs(x + flat)) - xlogy((x - flat) ** 2, np.abs(x - flat))) / 2


def kernel(x: Array, xi: Array, flat: float) -> Array:
    """K (n, m) between points x (n,) and xi (m,): the slope of Phi where they coincide."""
    apart = x[:, None] - xi[None, :]
    slope = xlogy(x + flat, np.abs(x + flat)) - xlogy(x - flat, np.abs(x - flat)) + flat
    quotient = (potential(x, flat)[:, None] - potential(xi, flat)[None, :]) / np.where(apart == 0, 1.0, apart)
    return np.where(apart == 0, slope[:, None], quotient)


def work_constant(flat: float, ratio: float, nodes: int = _NODES) -> float:
    """k of W = (1 + k a/R) times that of half-planes, for one body whose face is flat with rounded edges, and one half-plane alike.

    P is constant and Q goes to and fro; both bodies have one E'.

    Parameters
    ----------
    flat : b/a, at least 0 (a cylinder) and less than 1
    ratio : half of the range of Q over f P, above 0 and less than 1
    nodes : of the rule in each part

    >>> round(work_constant(0.5, 0.6), 4)
    -0.4603
    """
    # notation: a = R = E* = f = 1, so that E' = 2; stuck P - Q/f, load P; dG = int int dk q q/2, dG' = int int dk q m
    alike = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    profile = FlatRounded(radius=1.0, flat_half_length=flat) if flat > 0 else Hertz(radius=1.0)
    contact = contact_of(profile, Materials(upper=alike, lower=alike))
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


def _half_plane_work(contact: Contact, load: float, stuck: float) -> float:
    """W = 4 (Q U - 2 G) of half-planes, f = E* = 1, U(Q) the shift."""
    whole, held = (float(contact.log_distance(p)) for p in (load, stuck))
    sums = [p * log - float(contact.log_moment(p)) for p, log in ((load, whole), (stuck, held))]
    shift, twice_energy = 2 / np.pi * (whole - held), 4 / np.pi * ((load - stuck) * whole - (sums[0] - sums[1]))
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


def share_of(body: Elastic, materials: Materials) -> float:
    """2 E*/E' of the body that is curved, by which its law counts: 1 for like materials, 2 on a rigid half-plane.

    >>> steel = Elastic(young_modulus=210e3, poisson_ratio=0.3)
    >>> round(share_of(steel, Materials(upper=steel, lower=steel)), 12)
    1.0
    """
    return 2 * composite_modulus(materials) * (1 - body.poisson_ratio**2) / body.young_modulus
