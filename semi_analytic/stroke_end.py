"""What the smooth end of a stroke leaves of shear where tilt or bulk strain goes on changing.

Near the end of a stroke the level N = f P - s Q has a minimum, N = N''/2 t^2, while a_s = f alpha -
s eps goes on changing. One side of the slip zone c < |x| < a then comes to rest before the other:
rates of slip and of f p - s q >= 0 are a linear complementarity problem, with |x| < c in stick.
With x over a and v = (A/pi) N'' t/(a a_s') it has one parameter, c/a::

    int G(x, xi) rho(xi) d xi - v arccosh(|x|/c) + sgn(x) sqrt(x^2 - c^2) = rate of slip >= 0
    rho >= 0, and rho = 0 where it slips

G = ln |(1 - w w')/(w - w')|, w = sgn(x) e^(-arccosh(|x|/c)): the influence outside of a stretch
that sticks. Points come to rest one after the other, from the edge -a to -c and from c to a, and
stay at rest. In that order, with G = L L^T over panels, each joins at v_k = y_k/z_k (y = L^-1 of
the root, z = L^-1 of arccosh) and all solutions are one formula, rho(v) = L^-T z (v - v_k)_+. What
is left at the end, beyond what the same theory without a_s' leaves, is its integral over v; the
even part in x is::

    r = (pi/A)^2 a (a_s'^2/N'') R(x; c/a),  R = the even part of L^-T (y^2/z)/2

and as a force of memory T(c') = 2 int_c'^a r x/sqrt(x^2 - c'^2) dx.

# notation: A = 2/E*, a contact half-width, c stick half-width; s sense of slip, alpha tilt, eps
#           strain of the lower face minus that of the upper one
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from scenes.array_types import Array


class LeftOver(NamedTuple):
    """T over (pi/A)^2 a^2 a_s'^2/N'' at punches c', with panels of c' about them.

    Attributes
    ----------
    half_width
        c'/a, (n,) ascending from c/a to 1
    width
        of the panels, (n,)
    force
        T, (n,)
    """

    half_width: Array
    width: Array
    force: Array


@lru_cache(maxsize=256)
def left_over(stick_ratio: float, panels: int) -> LeftOver:
    """Tangential force that the smooth end of a slip stroke leaves where tilt or bulk strain still
    changes: its odd memory, over half-widths c' of flat punches from the stick edge to the edge.

    One side of the slip zone comes to rest before the other. The even part of the shear left there
    is integrated as int r x/sqrt(x^2 - c'^2) dx.

    Parameters
    ----------
    stick_ratio
        c/a, stick over contact half-width, above 0 and below 1
    panels
        number of panels of the slip zone on each side, finer at both ends
    """
    angles = np.linspace(0.0, np.pi, panels + 1)
    borders = stick_ratio + (1 - stick_ratio) * (1 - np.cos(angles)) / 2
    inner_border = borders[:-1]
    outer_border = borders[1:]
    # in the order in which panels come to rest
    panel_begin = np.concatenate([-outer_border[::-1], inner_border])
    panel_end = np.concatenate([-inner_border[::-1], outer_border])
    density = _density(stick_ratio, panel_begin, panel_end)
    even_density = (density[panels:] + density[:panels][::-1]) / 2
    panel_middles = (inner_border + outer_border) / 2
    upper_root = np.sqrt(np.maximum(outer_border**2 - panel_middles[:, None] ** 2, 0.0))
    lower_root = np.sqrt(np.maximum(inner_border**2 - panel_middles[:, None] ** 2, 0.0))
    return LeftOver(
        panel_middles, outer_border - inner_border, 2 * (upper_root - lower_root) @ even_density
    )


def _density(stick_ratio: float, panel_begin: Array, panel_end: Array) -> Array:
    """Density of the force that a stroke of slip leaves, on panels (n,) of the slip zone in the
    order in which they come to rest.

        L^-T (y^2/z)/2,    y = L^-1 sgn(x) sqrt(x^2 - c^2),    z = L^-1 arccosh(|x|/c)

    L is the Cholesky factor of the influence ln|(1 - w w')/(w - w')| of shear outside of a stretch
    |x| < c that sticks, integrated over panels; w = sgn(x) exp(-arccosh(|x|/c)) is the image of x.
    Panels go from `panel_begin` to `panel_end`, over the half-width of contact; `stick_ratio` is c
    over it.
    """
    panel_x = (panel_begin + panel_end) / 2
    width = panel_end - panel_begin
    arccosh_of_x = np.arccosh(np.abs(panel_x) / stick_ratio)
    signed_root = np.sign(panel_x) * np.sqrt(panel_x**2 - stick_ratio**2)
    image_of_x = np.sign(panel_x) * np.exp(-arccosh_of_x)
    # ln |w - w'| - ln |x - xi| is smooth; dw/dx on the diagonal
    image_distance = np.abs(image_of_x[:, None] - image_of_x)
    distance = np.abs(panel_x[:, None] - panel_x)
    np.fill_diagonal(image_distance, np.abs(image_of_x / signed_root))
    np.fill_diagonal(distance, 1.0)
    smooth_part = np.log1p(-np.outer(image_of_x, image_of_x)) - np.log(image_distance / distance)
    log_integrals = _log_primitive(panel_x[:, None] - panel_begin) - _log_primitive(
        panel_x[:, None] - panel_end
    )
    influence = (smooth_part * width - log_integrals) * width[:, None]
    cholesky_factor = scipy.linalg.cholesky((influence + influence.T) / 2, lower=True)
    solved_root = scipy.linalg.solve_triangular(cholesky_factor, signed_root * width, lower=True)
    solved_arc = scipy.linalg.solve_triangular(cholesky_factor, arccosh_of_x * width, lower=True)
    return np.asarray(
        scipy.linalg.solve_triangular(
            cholesky_factor, solved_root**2 / solved_arc / 2, lower=True, trans="T"
        )
    )


def _log_primitive(distance: Array) -> Array:
    """Primitive of ln |t|."""
    return np.asarray(distance * np.log(np.abs(distance)) - distance)
