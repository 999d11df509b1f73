"""Shear that the smooth end of a stroke of slip leaves where tilt or bulk strain still changes.

Near the end of a stroke the level N = f P - s Q has a minimum, N = N''/2 t^2, while a_s = f alpha -
s eps still changes. One side of the slip zone c < |x| < a then comes to rest before the other:
rates of slip and of f p - s q >= 0 are a linear complementarity problem, with |x| < c in stick.
With x over a and v = (A/pi) N'' t/(a a_s') it has one parameter, c/a::

    int G(x, xi) rho(xi) d xi - v arccosh(|x|/c) + sgn(x) sqrt(x^2 - c^2) = rate of slip >= 0
    rho >= 0, and rho = 0 where it slips

G = ln |(1 - w_i w_j)/(w_i - w_j)|, w = sgn(x) e^(-arccosh(|x|/c)): the influence of shear outside
of a stick zone. Points come to rest one after the other, from the edge -a to -c and from c to a,
and stay at rest. In that order, with G = L L^T over panels, each joins at v_k = y_k/z_k (y = L^-1
of the root, z = L^-1 of arccosh) and all solutions are one formula, rho(v) = L^-T z (v - v_k)_+.
What is left at the end, beyond what the same theory without a_s' leaves, is its integral over v;
the even part in x is::

    r = (pi/A)^2 a (a_s'^2/N'') R(x; c/a),  R = the even part of L^-T (y^2/z)/2

and as a force of memory T(b) = 2 int_b^a r x/sqrt(x^2 - b^2) dx.

# notation: A = 2/E*, a contact half-width, c stick half-width; s direction of slip, alpha tilt, eps
#           strain of the lower face minus that of the upper one
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from scenes.array_types import Array


class LoadsLeft(NamedTuple):
    """Tangential load of flat punches that the smooth end of a slip stroke leaves behind, by panels
    of punch half-width b.

    Attributes
    ----------
    punch_half_width
        b/a at the middles of the panels, (n,) ascending from c/a to 1
    panel_width
        of the panels over a, (n,)
    load_left
        T(b) over (pi/A)^2 a^2 a_s'^2/N'', (n,)
    """

    punch_half_width: Array
    panel_width: Array
    load_left: Array


@lru_cache(maxsize=256)
def loads_left_at_stroke_end(stick_ratio: float, n_panels: int) -> LoadsLeft:
    """Tangential load T that the smooth end of a slip stroke leaves on flat punches of half-widths
    b, from the edge of stick to that of contact. A stroke is half a cycle, with slip in one
    direction.

    Where tilt or bulk strain still changes, one side of the slip zone comes to rest before the
    other, and shear r(x) is left. Its even part carries the load T(b) = 2 int_b^a r
    x/sqrt(x^2 - b^2) dx, over (pi/A)^2 a^2 a_s'^2/N''. a is the contact half-width, A = 2/E*.
    N = f P - s Q has a minimum at the end of the stroke, N'' its second derivative; a_s' is the
    rate of f alpha - s eps, alpha the tilt, eps the bulk strain. s is the direction of slip.

    Parameters
    ----------
    stick_ratio
        c/a, stick over contact half-width, above 0 and below 1
    n_panels
        number of panels of the slip zone on each side, finer at both ends
    """
    # borders of the panels at x > 0, as x/a
    angles = np.linspace(0.0, np.pi, n_panels + 1)
    borders = stick_ratio + (1 - stick_ratio) * (1 - np.cos(angles)) / 2
    inner_border = borders[:-1]
    outer_border = borders[1:]
    # in the order in which panels come to rest
    panel_begin = np.concatenate([-outer_border[::-1], inner_border])
    panel_end = np.concatenate([-inner_border[::-1], outer_border])
    # on all panels; the even part is the mean of both sides
    shear_on_panels = _shear_left(stick_ratio, panel_begin, panel_end)
    even_shear = (shear_on_panels[n_panels:] + shear_on_panels[:n_panels][::-1]) / 2
    panel_middles = (inner_border + outer_border) / 2
    # int x/sqrt(x^2 - b^2) dx over each panel is a difference of roots sqrt(x^2 - b^2), 0 where
    # |x| < b; rows: b at the middle of each panel.
    root_at_outer_border = np.sqrt(np.maximum(outer_border**2 - panel_middles[:, None] ** 2, 0.0))
    root_at_inner_border = np.sqrt(np.maximum(inner_border**2 - panel_middles[:, None] ** 2, 0.0))
    return LoadsLeft(
        panel_middles,
        outer_border - inner_border,
        2 * (root_at_outer_border - root_at_inner_border) @ even_shear,
    )


def _shear_left(stick_ratio: float, panel_begin: Array, panel_end: Array) -> Array:
    """Shear that the smooth end of a slip stroke leaves on each of n panels, ranges of x in the
    slip zone, (n,), divided by (pi/A)^2 a a_s'^2/N''.

    A stroke is half a cycle, with slip in one direction. Its end is smooth where the loads turn
    without a jump of their rates. While tilt or bulk strain still changes, one panel after the
    other comes to rest, in the order given. On a panel at rest f p - s q grows, at the rate that
    keeps its slip rate 0. Elimination in this order (Cholesky) gives the instant y/z at which each
    panel stops, and the integral of these rates up to the end, which is the shear left:

        L^-T (y^2/z)/2,    y = L^-1 sgn(x) sqrt(x^2 - c^2),    z = L^-1 arccosh(|x|/c)

    L is the Cholesky factor of the influence matrix ln|(1 - w_i w_j)/(w_i - w_j)| of shear outside
    of a stick zone |x| < c, integrated over panels. w = sgn(x) exp(-arccosh(|x|/c)) is the image of
    x. Panels go from `panel_begin` to `panel_end`, over the contact half-width a; `stick_ratio` is
    c/a.

    # notation: A = 2/E*, s direction of slip, N'' second derivative of f P - s Q at the end of the
    #           stroke, a_s' rate of f alpha - s eps, alpha tilt, eps bulk strain
    """
    panel_x = (panel_begin + panel_end) / 2
    panel_width = panel_end - panel_begin
    arccosh_of_x = np.arccosh(np.abs(panel_x) / stick_ratio)
    signed_root = np.sign(panel_x) * np.sqrt(panel_x**2 - stick_ratio**2)
    image_of_x = np.sign(panel_x) * np.exp(-arccosh_of_x)
    # ln |w_i - w_j| - ln |x_i - x_j| is smooth, on the diagonal ln |dw/dx|; ln |x_i - x_j| is
    # integrated in closed form.
    image_distance = np.abs(image_of_x[:, None] - image_of_x)
    distance = np.abs(panel_x[:, None] - panel_x)
    np.fill_diagonal(image_distance, np.abs(image_of_x / signed_root))
    np.fill_diagonal(distance, 1.0)
    smooth_part = np.log1p(-np.outer(image_of_x, image_of_x)) - np.log(image_distance / distance)
    log_integrals = _log_primitive(panel_x[:, None] - panel_begin) - _log_primitive(
        panel_x[:, None] - panel_end
    )
    influence_matrix = (smooth_part * panel_width - log_integrals) * panel_width[:, None]
    cholesky_factor = scipy.linalg.cholesky((influence_matrix + influence_matrix.T) / 2, lower=True)
    y = scipy.linalg.solve_triangular(cholesky_factor, signed_root * panel_width, lower=True)
    z = scipy.linalg.solve_triangular(cholesky_factor, arccosh_of_x * panel_width, lower=True)
    return np.asarray(
        scipy.linalg.solve_triangular(cholesky_factor, y**2 / z / 2, lower=True, trans="T")
    )


def _log_primitive(distance: Array) -> Array:
    """Primitive t ln|t| - t of ln|t| at t = `distance`, which is not 0; shape of `distance`."""
    return np.asarray(distance * np.log(np.abs(distance)) - distance)
