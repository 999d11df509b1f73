"""The asymptotic law of an error: constant and exponent from a weighted fit of logarithms, with intervals that are meant to hold.

    |e| = C s^n,    s -> 0

The fit is of log |e| = log C + n log s + d s^2. The last term stands for the next one of a series in s^2 (or of one in s: then it
is d s): without it the exponent of points that reach to large s is off by more than its interval. The range is found, not chosen:
the largest s are left out until what is left shows no more curvature in the logarithms than that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import t as student

Array = NDArray[np.float64]
FEWEST = 5  # points of a fit: three unknowns and two degrees of freedom
_BEND = 2.0  # standard deviations of curvature before a range counts as not asymptotic


@dataclass(frozen=True)
class Law:
    """|e| = constant s^order where s is at most `largest`.

    Attributes
    ----------
    order, order_doubt : exponent and half its 95 % interval
    constant, constant_doubt : at the fitted exponent
    expected : exponent that theory predicts
    fixed, fixed_doubt : constant at the expected exponent, on the same points
    next_term : d, at the expected exponent: the law holds to a share d s^step
    step : exponent by which the series goes on
    sign : of the error
    smallest, largest : of s in the fit
    points : in the fit; `left_out`: resolved points at larger s that are not asymptotic
    misfit : reduced chi squared; above 1 the intervals are widened by its root
    bent : curvature of the logarithms is significant even in the fewest points: no asymptotic range was found
    """

    order: float
    order_doubt: float
    constant: float
    constant_doubt: float
    expected: float
    fixed: float
    fixed_doubt: float
    next_term: float
    step: float
    sign: int
    smallest: float
    largest: float
    points: int
    left_out: int
    misfit: float
    bent: bool

    def agrees(self) -> bool:
        """Whether the expected exponent is in the interval of the fitted one."""
        return abs(self.order - self.expected) <= self.order_doubt

    def value(self, s: float) -> float:
        """The error by the law at the expected exponent and its next term, with its sign."""
        return self.sign * self.fixed * s**self.expected * math.exp(self.next_term * s**self.step)


def fit_law(s: ArrayLike, error: ArrayLike, uncertainty: ArrayLike, expected: float, step: float = 2.0) -> Law | None:
    """The law of errors (n,) at s (n,), each with its uncertainty (n,); None where fewer than five points can be had.

    `expected` is the exponent that theory predicts, `step` that by which its series goes on.
    A point takes part where |error| > uncertainty and where it has the sign of the point with the smallest s among these.
    Intervals have two parts, in quadrature: independent errors of standard deviation u, widened by the root of the misfit where
    that is above 1; and an error that all points share, as points cut alike do: what the fit moves by when all errors move by +-u.

    >>> law = fit_law([0.1, 0.2, 0.3, 0.4, 0.5], [0.02, 0.08, 0.18, 0.32, 0.5], [1e-4] * 5, expected=2)
    >>> round(law.order, 6), round(law.constant, 6)
    (2.0, 2.0)
    """
    x, e, u = (np.asarray(column, dtype=float) for column in (s, error, uncertainty))
    resolved = np.isfinite(e) & np.isfinite(u) & (np.abs(e) > u) & (x > 0)
    if not resolved.any():
        return None
    sign = int(np.sign(e[resolved][np.argmin(x[resolved])]))
    order = np.argsort(x[resolved])
    keep = sign * e[resolved][order] > 0
    # From the first change of sign on, the error is no longer that of the leading term.
    turned = len(keep) if keep.all() else int(np.argmin(keep))
    x, e, u = (column[resolved][order][:turned] for column in (x, np.abs(e), u))
    if len(x) < FEWEST:
        return None
    total = len(x)
    while len(x) > FEWEST and _bent(x, e, u, step):
        x, e, u = x[:-1], e[:-1], u[:-1]
    return _fitted(x, e, u, (expected, step), sign, total - len(x))


def leading_constant(s: ArrayLike, error: ArrayLike, uncertainty: ArrayLike, order: float) -> tuple[float, float]:
    """k of error = s^order (k + k1 s + k2 s^2 + k3 s^3) by all points (n,), and half its 95 % interval (parts as in `fit_law`).

    For a series in s whose second term soon counts: of that, the exponential that `fit_law` takes is a poor image.

    >>> s = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    >>> round(leading_constant(s, -s * (2 + 3 * s), 1e-4 * s, 1.0)[0], 6)
    -2.0
    """
    x, e, u = (np.asarray(column, dtype=float) for column in (s, error, uncertainty))
    sign = float(np.sign(e[np.argmin(x)]))

    def series(x: Array, e: Array, u: Array) -> tuple[Array, Array, float]:
        return _solve(e / x**order, [x**power for power in range(4)], x**order / u)

    found, doubt, _ = _with_doubt(x, sign * e, u, series, 4)
    return sign * float(found[0]), float(doubt[0])


def _solve(target: Array, columns: Sequence[Array], weight: Array) -> tuple[Array, Array, float]:
    """Coefficients of the columns, their covariance and the reduced chi squared."""
    design = np.stack(columns, axis=1) * weight[:, None]
    covariance: Array = np.asarray(np.linalg.inv(design.T @ design), dtype=np.float64)
    found = covariance @ (design.T @ (weight * target))
    rest = weight * target - design @ found
    return found, covariance, float(rest @ rest) / max(len(target) - len(columns), 1)


def _free(x: Array, e: Array, u: Array, step: float) -> tuple[Array, Array, float]:
    """log C, n, d."""
    return _solve(np.log(e), [np.ones_like(x), np.log(x), x**step], e / u)


def _held(x: Array, e: Array, u: Array, expected: float, step: float) -> tuple[Array, Array, float]:
    """log C, d at a given exponent."""
    return _solve(np.log(e) - expected * np.log(x), [np.ones_like(x), x**step], e / u)


def _bent(x: Array, e: Array, u: Array, step: float) -> bool:
    if len(x) < FEWEST:
        return False
    found, covariance, _ = _solve(np.log(e), [np.ones_like(x), np.log(x), x**step, np.log(x) ** 2], e / u)
    return bool(abs(found[3]) > _BEND * math.sqrt(covariance[3, 3]))


def _fitted(x: Array, e: Array, u: Array, series: tuple[float, float], sign: int, left_out: int) -> Law:
    expected, step = series
    found, doubt, misfit = _with_doubt(x, e, u, partial(_free, step=step), 3)
    held, held_doubt, _ = _with_doubt(x, e, u, partial(_held, expected=expected, step=step), 2)
    return Law(
        order=float(found[1]),
        order_doubt=float(doubt[1]),
        constant=math.exp(found[0]),
        constant_doubt=math.exp(found[0]) * math.expm1(doubt[0]),
        expected=expected,
        fixed=math.exp(held[0]),
        fixed_doubt=math.exp(held[0]) * math.expm1(held_doubt[0]),
        next_term=float(held[1]),
        step=step,
        sign=sign,
        smallest=float(x[0]),
        largest=float(x[-1]),
        points=len(x),
        left_out=left_out,
        misfit=misfit,
        bent=_bent(x, e, u, step),
    )


def _with_doubt(
    x: Array, e: Array, u: Array, fit: Callable[[Array, Array, Array], tuple[Array, Array, float]], unknowns: int
) -> tuple[Array, Array, float]:
    """Coefficients of a fit, half their 95 % intervals, and its misfit; see `fit_law`."""
    found, covariance, misfit = fit(x, e, u)
    widen = float(student.ppf(0.975, len(x) - unknowns)) * math.sqrt(max(1.0, misfit))
    # Weights e/u stay those of the errors as measured; a shift through 0 leaves a twentieth.
    moved = [np.maximum(e + way * u, 0.05 * e) for way in (-1.0, 1.0)]
    shared = np.max([np.abs(fit(x, there, u * there / e)[0] - found) for there in moved], axis=0)
    doubt: Array = np.asarray(np.hypot(widen * np.sqrt(np.diag(covariance)), shared), dtype=np.float64)
    return found, doubt, misfit
