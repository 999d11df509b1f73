r"""What a finite height adds to the curvature of a surface: known solutions of layers, by Fourier integrals.

The surface of a layer of height h answers a line force P with the displacement (1 - nu^2)/E (2/pi) int L(k h) cos(k x)/k dk P. The
half-plane is L = 1; the rest is smooth, and its curvature at the force is kappa = -(2/(pi E')) S P/h^2, with

    S = int_0^inf (L(w) - 1) w dw          (E' = E/(1 - nu^2))

Smooth walls at x = +-B/2 make a row of images: S is then a sum over w = 2 pi m h/B (normal), or over the odd halves of it
(tangential, images of alternate sense), less what the same sum does to L = 1: -1/12 and +1/24 of (2 pi h/B)^2, by zeta(-1).
Source: Johnson, Contact Mechanics (1985), section 5.8; Meijers (1968); the curvature and the sums derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad

Array = NDArray[np.float64]
Base = Literal["fixed", "rollers"]
_FAR = 40.0  # L - 1 decays like w^2 exp(-2 w)


def response(base: Base, tangential: bool, poisson_ratio: float) -> Callable[[Array], Array]:
    """L(w) of a layer that is fixed to its base or slides on it, for normal or tangential forces."""
    kappa = 3 - 4 * poisson_ratio
    sense = 1.0 if tangential else -1.0

    def fixed(w: Array) -> Array:
        low = 2 * kappa * np.sinh(2 * w) + sense * 4 * w
        return np.asarray(low / (2 * kappa * np.cosh(2 * w) + 1 + kappa**2 + 4 * w**2))

    def sliding(w: Array) -> Array:
        high = 2 * np.cosh(w) ** 2 if tangential else 2 * np.sinh(w) ** 2
        return np.asarray(high / (2 * w + np.sinh(2 * w)))

    return fixed if base == "fixed" else sliding


def curvature_sum(base: Base, *, tangential: bool = False, poisson_ratio: float = 0.3, aspect: float = np.inf) -> float:
    """S of a layer, or of a block between smooth walls whose width is `aspect` times its height.

    >>> round(-curvature_sum("fixed") / 4, 4)
    0.358
    """
    layer = response(base, tangential, poisson_ratio)
    if np.isinf(aspect):
        return float(quad(lambda w: (layer(np.array(w)) - 1) * w, 1e-12, _FAR, limit=200)[0])
    step = 2 * np.pi / aspect
    number = np.arange(1, int(_FAR / step) + 2)
    w: Array = np.asarray((number - 0.5 if tangential else number) * step, dtype=np.float64)
    images = step**2 / 24 if tangential else -(step**2) / 12
    return float(np.sum((layer(w) - 1) * w * step)) + float(images)
