"""What an elastic layer adds to a half-plane, and a layer between smooth walls, exactly: neither
finite elements nor the closed forms of the layer.

A pressure cos kx or a shear sin kx on the face y = 0 of a layer of thickness t displaces it by

    u_x = U(y) sin kx,   u_y = V(y) cos kx

with four functions e^{ky} and y e^{ky}, e^{-ky} and y e^{-ky} that satisfy Navier's equations. Two
conditions at the face and two at the base make a system of 4 x 4 for each k. Of a half-plane
k E'/2 times the displacement is 1 for pressure and shear, and k E'/2 times that across is (1 - 2
nu)/(2 - 2 nu). What exceeds these numbers decays like exp(-2 k t), and integrals over k give the
remainder and its derivatives at x = 0. Walls are a row of images, a sum over k in place of the
integral: of equal forces for P, of forces of alternating sign for Q. For the parts of the sums that
do not decay

    sum cos(n u)/n = -ln u,                sum cos((n + 1/2) u)/(n + 1/2) = -ln(u/4)
    sum 1 = -1/2, sum n = -1/12,           sum 1 = 0, sum (n + 1/2) = 1/24
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad

# w = k t beyond which what is left is below 1e-15.
_END = 25.0


class LayerNumbers(NamedTuple):
    """c_n, c_t, N, T, e and a as in `halfplane_fe.remainder`, for E' = 1, thickness 1 and a datum
    at 1.
    """

    normal_compliance: float
    tangential_compliance: float
    normal_curvature: float
    tangential_curvature: float
    strain_under_pressure: float
    slope_under_shear: float


class Response(NamedTuple):
    """k E'/2 times displacements of the face: inwards and along x by pressure; along x by shear."""

    normal: float
    across: float
    tangential: float


def response(w: float, base: str, nu: float) -> Response:
    """Of a layer of thickness 1 at the wave number w, its base "fixed" or on "rollers"."""
    kappa = 3 - 4 * nu
    # E' = E/(1 - nu^2) = 1
    shear_modulus = (1 - nu) / 2
    lame = 2 * shear_modulus * nu / (1 - 2 * nu)

    def fields(sense: int, y: float) -> np.ndarray:
        """(2, 4): U, V, pull and shear at y of the two functions that grow (sense 1) or decay."""
        # about the end where they are largest, so that no exponential exceeds 1
        depth = y if sense > 0 else -(y + 1)
        size = math.exp(w * depth)
        plain = np.array([-1.0, sense]) * size
        plain_slope = w * sense * plain
        # U = -y e, V = (y - kappa/w) e, mirrored for the functions that decay
        linear = np.array([-depth, sense * (depth - kappa / w)]) * size
        linear_slope = np.array([-(1 + w * depth) * sense, 1 + w * (depth - kappa / w)]) * size
        columns = []
        for (U, V), (dU, dV) in ((plain, plain_slope), (linear, linear_slope)):
            pull = lame * (w * U + dV) + 2 * shear_modulus * dV
            shear = shear_modulus * (dU - w * V)
            columns.append([U, V, pull, shear])
        return np.array(columns)

    at_face, at_base = (np.concatenate([fields(1, y), fields(-1, y)]).T for y in (0.0, -1.0))
    rows_of_base = [0, 1] if base == "fixed" else [1, 3]
    system = np.vstack([at_face[[2, 3]], at_base[rows_of_base]])
    by_pressure, by_shear = np.linalg.solve(system, np.array([[-1.0, 0, 0, 0], [0, 1.0, 0, 0]]).T).T
    along_x, outward = at_face[:2] @ by_pressure
    return Response(-outward * w / 2, along_x * w / 2, float(at_face[0] @ by_shear) * w / 2)


def of_half_plane(nu: float) -> Response:
    """The same at the surface of a half-plane: it is drawn together under pressure."""
    return Response(1.0, -(1 - 2 * nu) / (2 * (1 - nu)), 1.0)


def layer(nu: float) -> LayerNumbers:
    """A layer without ends, its base fixed."""
    limit = of_half_plane(nu)

    def integral(integrand: Callable[[float], float]) -> float:
        return quad(integrand, 1e-9, _END, limit=400, epsabs=1e-12, epsrel=1e-12)[0]

    def excess(w: float) -> np.ndarray:
        return np.array(response(w, "fixed", nu)) - limit

    def compliance(component: int) -> float:
        # 1/w is (1 - e^-w)/w, whose integral with cos wx is -ln x, and e^-w/w
        return 2 / math.pi * integral(lambda w: (excess(w)[component] + math.exp(-w)) / w)

    slope = 2 / math.pi * integral(lambda w: excess(w)[1])
    return LayerNumbers(
        normal_compliance=compliance(0),
        tangential_compliance=compliance(2),
        normal_curvature=-2 / math.pi * integral(lambda w: w * excess(w)[0]),
        tangential_curvature=-2 / math.pi * integral(lambda w: w * excess(w)[2]),
        strain_under_pressure=slope,
        slope_under_shear=slope,  # k_tn depends on x - s alone
    )


def between_walls(width: float, nu: float) -> LayerNumbers:
    """A layer of thickness 1 on rollers between smooth walls."""
    limit = np.array(of_half_plane(nu))
    step = 2 * math.pi / width
    count = int(_END / step) + 2

    def excesses(numbers: np.ndarray) -> np.ndarray:
        return np.array([response(step * n, "rollers", nu) for n in numbers]) - limit

    n = np.arange(1.0, count)
    half = np.arange(count) + 0.5
    of_pressure = excesses(n)
    of_shear = excesses(half)
    # P/width alone: strain in depth only
    confined = (1 - 2 * nu) / (1 - nu) ** 2 / width
    return LayerNumbers(
        normal_compliance=2 / math.pi * (np.sum(of_pressure[:, 0] / n) - math.log(step)) + confined,
        tangential_compliance=2 / math.pi * (np.sum(of_shear[:, 2] / half) - math.log(step / 4)),
        normal_curvature=-2 / math.pi * step**2 * (np.sum(of_pressure[:, 0] * n) - 1 / 12),
        tangential_curvature=-2 / math.pi * step**2 * (np.sum(of_shear[:, 2] * half) + 1 / 24),
        strain_under_pressure=2 / math.pi * step * (np.sum(of_pressure[:, 1]) - limit[1] / 2),
        slope_under_shear=2 / math.pi * step * np.sum(of_shear[:, 1]),
    )
