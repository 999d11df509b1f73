r"""Half-plane theory with the next term of a finite body: its surface Green's function has a quadratic part more.

A finite body answers a line force on its surface as the half-plane does, and besides by a function that is smooth at the force.
Between two bodies that mirror each other its even part alone is felt, in the leading order -(x - \xi)^2/2 times kappa_n of the
normal and kappa_t of the tangential force. What follows is exact for such a kernel (Hertz parabola, mirror-symmetric tractions):

- normal: the gap's curvature is 1/R + kappa_n P instead of 1/R, so a^2 = p/(1 + nu p) with p = P/P0, nu = kappa_n P0 R, lengths
  over a(P0) of half-planes; peak pressure and half-width move by +nu/2 and -nu/2 at first order;
- tangential: shear is a pile of flat punches of half-widths alpha with the density m(alpha). In stick m - 2 tau Q alpha does not
  change (tau = kappa_t P0 R, Q over P0), for this part alone takes the curvature kappa_t Q away; in slip m is +-f that of pressure;
- tangential displacement U = (A P0/pi) int m [log(1/alpha) + tau alpha^2/2] d alpha, work of a closed cycle = closed int Q dU.

Source: memory curve of half-plane theory (docs/numbers.md checks it), Johnson (1985) section 5.8 for layers; derived here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_CELLS = 600
_STEPS = 400
_NOTHING = 1e-9


@dataclass(frozen=True)
class Curvatures:
    """nu and tau: what finite bodies add to the relative curvature under P0, normal and tangential, as shares of 1/R."""

    normal: float
    tangential: float

    def pressure_error(self, load: float = 1.0) -> float:
        """Peak pressure over that of half-planes, less 1, at P = `load` P0.

        >>> round(Curvatures(0.02, 0.0).pressure_error(), 6)
        0.00995
        """
        return float(np.sqrt(1 + self.normal * load)) - 1

    def half_width_error(self, load: float = 1.0) -> float:
        """Half-width over that of half-planes, less 1, at P = `load` P0."""
        return 1 / float(np.sqrt(1 + self.normal * load)) - 1


def dissipation(normal_load: Array, tangential_load: Array, friction: float, added: Curvatures, last: int) -> float:
    """Friction work of the last `last` steps, a closed cycle, over A P0^2/pi.

    Parameters
    ----------
    normal_load, tangential_load : path from rest (n,), over P0; straight between its points
    friction : coefficient
    added : what the bodies add; (0, 0) for half-planes
    last : steps of the closed cycle at the end
    """
    shift = _shifts(normal_load, tangential_load, friction, added)[-last - 1 :]
    q = tangential_load[-last - 1 :]
    return float(np.sum((q[1:] + q[:-1]) / 2 * np.diff(shift)))


def dissipation_error(normal_load: Array, tangential_load: Array, friction: float, added: Curvatures, last: int) -> float:
    """Friction work over that of half-planes on the same path and steps, less 1; NaN where these dissipate nothing."""
    path = (normal_load, tangential_load, friction)
    plain = dissipation(*path, Curvatures(0.0, 0.0), last)
    # Full stick leaves rounding, of the order of 1e-16.
    return dissipation(*path, added, last) / plain - 1 if plain > _NOTHING * friction**2 else float("nan")


def _shifts(normal_load: Array, tangential_load: Array, friction: float, added: Curvatures) -> Array:
    """Tangential displacement (n,) over A P0/pi, its constant part left out: it does no work in a cycle."""
    # notation: g = alpha^2 of the cells' borders, M = force of the punches up to alpha, frozen = M less that of the curvature tau Q
    nu, tau = added.normal, added.tangential
    square = normal_load / (1 + nu * normal_load)
    g = np.linspace(0.0, float(np.max(square)), _CELLS + 1)
    kernel = _kernel(g, tau)
    frozen, before, shifts = np.zeros_like(g), 0.0, np.empty(len(normal_load))
    for number, (p, q, here) in enumerate(zip(normal_load, tangential_load, square, strict=True)):
        # What friction can carry outside alpha.
        bound = friction * (1 + nu * p) * np.clip(here - g, 0.0, None)
        carried = frozen + tau * q * np.minimum(g, min(before, here))
        if here > before:
            start = np.interp(before, g, frozen) + tau * q * before
            carried = np.where(g > before, start + (q - start) * np.clip((g - before) / (here - before), 0, 1), carried)
        carried = np.where(g >= here, q, carried)
        carried = np.minimum(np.maximum(carried, q - bound), q + bound)
        shifts[number] = np.diff(carried) @ kernel
        frozen, before = carried - tau * q * np.minimum(g, here), float(here)
    return shifts


def _kernel(g: Array, tau: float) -> Array:
    """Mean of log(1/alpha) + tau alpha^2/2 over cells of alpha^2."""
    whole = np.where(g > 0, g * (1 - np.log(np.where(g > 0, g, 1.0))), 0.0) / 2
    return np.diff(whole) / np.diff(g) + tau * (g[1:] + g[:-1]) / 4


def ellipse_path(normal_amplitude: float, mean: float, amplitude: float, phase: float, cycles: int = 2) -> tuple[Array, Array, int]:
    """P/P0 and Q/P0 of an ellipse from rest, straight to where Q is least; loads over P0, phase in radians.

    Returns
    -------
    P (n,), Q (n,), steps of a cycle
    """
    t = phase + np.pi + np.linspace(0.0, 2 * np.pi * cycles, _STEPS * cycles + 1)
    p, q = 1 + normal_amplitude * np.cos(t), mean + amplitude * np.cos(t - phase)
    way = np.linspace(0.0, 1.0, 100)[1:-1]
    return np.concatenate([way * p[0], p]), np.concatenate([way * q[0], q]), _STEPS
