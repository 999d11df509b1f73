"""Curves through noisy measured rows: parabola, flat with rounded edges, even polynomial, smoothing spline; all convex.

# notation: x0 centre, s = |x - x0|, L the largest s, kappa = h'' >= 0, sigma noise of h

Parabola, polynomial and spline are sums of kappa's with factors that are not negative, so that the contact can't split:

    h(x) = h0 + sum over j of w_j B_j(s),   w_j >= 0,   B_j'' = kappa_j,   B_j(0) = B_j'(0) = 0

    parabola     kappa = 1
    polynomial   1, u, u (u - c)^2 and (u - c)^2 with u = (s/L)^2: their sums are the polynomials without negative values at u >= 0
    spline       hat functions on evenly spaced knots; the squares of the steps of w are added with a weight, which is that of the
                 least expected error by Mallows (1973) from the noise, or by generalised cross-validation without it

The w are found by least squares without negative values (Lawson and Hanson 1974), h0 and x0 with them: a step of x0 is one more
column, h'(s). The flat with rounded edges is fitted by the method of Levenberg and Marquardt in x0, h0, b and 1/R.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Rows that a fit needs: it has up to six numbers, and the noise may have to come from what is left.
_FEWEST = 8
_MOST = 20_000
# A middle that is given may lie beside the rows by this share of their reach: rows of one side need not begin at x = 0.
_BESIDE = 0.1
# Parts of the rows; the first has risen where it lies by more than this share of all heights above the lowest.
_PARTS, _RISEN = 8, 0.05
# Rise of a curve, over that of the rows, below which it is none.
_BENT = 1e-9
# Fits about another middle, by which other rows lie within the extent.
_PASSES = 5
# Places c, in L^2, of the polynomials (u - c)^2; degree of kappa in u.
_TOUCHES, _DEGREE = np.concatenate([np.linspace(0.0, 1.0, 21), np.geomspace(1.1, 10.0, 12)]), 3
# Knots of the spline; rows that it leaves behind; weights that are tried, over that at which rows and steps count alike.
_KNOTS, _PIECES, _WEIGHTS = 31, 61, np.logspace(-9, 3, 19)
# Steps of the centre, and when it stands still, in L.
_CENTRINGS, _STILL = 60, 1e-9
# Half-lengths of the flat, in L, of which the best with its middle at x = 0 begins the search.
_STARTS = tuple(np.linspace(0.02, 0.94, 24).tolist())


class UnfitRowError(ValueError):
    """A fault in a row, counted from 0."""

    def __init__(self, row: int, rule: str) -> None:
        self.row, self.rule = row, rule
        super().__init__(f"row {row + 1}: {rule}")


@dataclass(frozen=True, eq=False)
class _Fit:
    """What a fit found: keys of the profile, centre, offset, curve (n,) at the rows, numbers fitted, weight of the smoothing."""

    keys: dict[str, Any]
    centre: float
    offset: float
    curve: Array
    numbers: float
    weight: float = 0.0


def fitted_keys(
    x: Array,
    h: Array,
    *,
    kind: str,
    noise: float | None = None,
    centre: float | None = None,
    extent: float | None = None,
    weight: float | None = None,
) -> dict[str, Any]:
    """Keys of the profile of this kind that fits rows x, h (n,) best, with `fitted`, what is known of the fit.

    Raises
    ------
    UnfitRowError
        For too few or too many rows, x that does not ascend, rows that do not bend up or lie on one side of the middle in part.
    """
    back = np.flatnonzero(np.diff(x) <= 0)
    if len(back):
        raise UnfitRowError(int(back[0]) + 1, f"x = {x[back[0] + 1]:.6g} does not ascend")
    if len(x) < _FEWEST:
        raise UnfitRowError(len(x) - 1, f"{len(x)} rows within the extent are too few for a fit: at least {_FEWEST} are needed")
    if len(x) > _MOST:
        raise UnfitRowError(_MOST, f"{len(x):,} rows are too many for a fit of at most {_MOST:,}: leave out all but every n-th")
    fixed = 0.0 if centre is None and x[0] >= 0 and _begins_in_the_middle(h) else centre
    start = _middle(x, h) if fixed is None else fixed
    whole, reach, near = (x, h), math.inf if extent is None else extent, np.abs(x - start) <= (extent or math.inf)
    for _ in range(_PASSES):
        x, h = (values[near] for values in whole)
        count = len(x)
        if count < _FEWEST:
            rule = f"{count} rows within the extent are too few for a fit: at least {_FEWEST} are needed"
            raise UnfitRowError(len(near) - 1, rule)
        apart = np.abs(x - start)
        if not x[0] <= start < x[-1] and (fixed is None or np.min(apart) > _BESIDE * np.max(apart)):
            where = f"the middle, x = {start:.6g}, is not among the rows, which go from x = {x[0]:.6g} to {x[-1]:.6g}"
            raise UnfitRowError(0, f"{where}: measure both sides of it, or state centre")
        # In units of the rows, so that nothing depends on theirs.
        length, height = float(np.max(np.abs(x - start))), float(np.ptp(h))
        if not height > 0:
            raise UnfitRowError(len(near) - 1, "the rows are flat from end to end: they must rise somewhere")
        level = None if noise is None else float(np.clip(noise / height, 1e-12, 1e6))  # beyond, its square would be none
        found = _fit((x - start) / length, (h - h[0]) / height, kind, level, fixed is None, weight)
        if found is None or np.ptp(found.curve) < _BENT:  # the latter: rounding of rows on a line
            rule = "the rows do not bend up: h is a gap, which grows to both sides; is its sign turned?"
            raise UnfitRowError(len(near) - 1, rule)
        # Other rows lie within the extent of another middle.
        again = np.abs(whole[0] - (start + length * found.centre)) <= reach
        if np.array_equal(again, near):
            break
        start, near = start + length * found.centre, again
    assert found is not None
    middle = start + length * found.centre
    rest = (h - h[0]) - height * found.curve
    freedom = max(1, count - round(found.numbers))
    estimated = max(math.sqrt(float(rest @ rest) / freedom), 1e-15 * height)
    sides = (middle - x[0], x[-1] - middle)
    return {
        **_with_units(found.keys, length, height),
        "fitted": {
            "kind": kind,
            "noise": estimated if noise is None else noise,
            "noise_stated": noise is not None,
            "centre": middle,
            "centre_fitted": fixed is None,
            "offset": float(h[0]) + height * found.offset,
            "residual": math.sqrt(float(rest @ rest) / count),
            "freedom": freedom,
            "extent": max(sides) if fixed is not None and x[0] >= fixed else min(sides),
            "weight": found.weight,
            "left_out": len(whole[0]) - count,
        },
    }


def resampled(profile: Any, count: int, seed: int = 0) -> list[dict[str, Any]]:
    """Keys of the profiles that the same fit makes of `count` other measurements: the fitted curve, with other noise on each row.

    Parameters
    ----------
    profile : one with `fitted`
    count, seed : how many, and of the random numbers
    """
    fitted = profile.fitted
    x, random = fitted.rows.values[:, 0], np.random.default_rng(seed)
    x = x[np.argsort(np.abs(x - fitted.centre), kind="stable")[: len(x) - fitted.left_out]] if fitted.left_out else x
    # From the middle on, so that rows of both sides are taken for such whatever their noise.
    x = np.sort(x) - fitted.centre
    curve = fitted.offset + profile.height(x)
    given = {"kind": fitted.kind, "noise": fitted.noise, "weight": fitted.weight}
    given["centre"] = None if fitted.centre_fitted else 0.0
    found = []
    for _ in range(count):
        try:
            found.append(fitted_keys(x, curve + fitted.noise * random.standard_normal(len(x)), **given))
        except UnfitRowError:  # noise alone bent the rows down
            continue
    return found


def _begins_in_the_middle(h: Array) -> bool:
    """Whether rows of x >= 0 are those of one side: their first part is hardly higher than their lowest."""
    means = np.array([part.mean() for part in np.array_split(h, _PARTS)])
    return bool(means[0] - means.min() <= _RISEN * np.ptp(means))


def _middle(x: Array, h: Array) -> float:
    """Where the parabola of least squares has its least value; the mean of x where it has none."""
    scale = float(np.ptp(x)) / 2
    # Rows that all but coincide have no parabola, and no warning either.
    _, slope, bend = np.linalg.lstsq(polynomial.polyvander((x - x.mean()) / scale, 2), h - h.mean(), rcond=None)[0]
    return float(x.mean() - scale * slope / (2 * bend)) if bend > 0 else float(x.mean())


def _fit(x: Array, h: Array, kind: str, noise: float | None, centred: bool, weight: float | None) -> _Fit | None:
    """The fit in units in which |x| and the range of h are 1, from the middle x = 0 on; None where the rows do not bend up."""
    if kind == "flat_rounded":
        return _flat_rounded(x, h, centred)
    reach = 1.0 + (0.2 if centred else 0.0)  # the middle moves
    if kind == "smoothing_spline":
        weights = _WEIGHTS if weight is None else np.array([weight])
        return _smoothest(_Hats(np.linspace(0.0, reach, _KNOTS)), x, h, noise, centred, weights)
    basis = _Powers(np.ones((1, 1)) if kind == "hertz" else _bent_polynomials())
    return _nearest(basis, x, h, centred, 0.0)


@dataclass(frozen=True, eq=False)
class _Powers:
    """kappa_j = sum over k of coefficients[j, k] u^k, u = s^2."""

    coefficients: Array

    def __call__(self, s: Array) -> tuple[Array, Array]:
        """B (n, m) and B' (n, m)."""
        k = np.arange(self.coefficients.shape[1])
        powers = s[:, None] ** (2 * k)
        slope = (powers * s[:, None] / (2 * k + 1)) @ self.coefficients.T
        return (powers * s[:, None] ** 2 / ((2 * k + 1) * (2 * k + 2))) @ self.coefficients.T, slope

    def keys(self, w: Array) -> dict[str, Any]:
        bend = w @ self.coefficients
        k = np.arange(len(bend))
        if len(bend) == 1:
            return {"kind": "hertz", "radius": 1 / float(bend[0])}
        return {"kind": "polynomial", "length": 1.0, "rises": tuple((bend / ((2 * k + 1) * (2 * k + 2))).tolist())}


@dataclass(frozen=True, eq=False)
class _Hats:
    """kappa_j = 1 at its knot, 0 at the others, straight between; the knots are evenly spaced from 0 on."""

    knots: Array

    def __call__(self, s: Array) -> tuple[Array, Array]:
        step = float(self.knots[1])
        # Sums of (s - t)^3 and (s - t)^2 above knots t: the primitives of a corner of kappa.
        above = np.maximum(s[:, None] - np.append(self.knots, self.knots[-1] + step), 0.0)
        corner, bend = above**3 / (6 * step), above**2 / (2 * step)
        heights, slopes = (np.diff(np.diff(each, axis=1, prepend=0.0), axis=1) for each in (corner, bend))
        # The first hat falls from the middle on.
        first = s[:, None]
        heights = np.hstack([first**2 / 2 - corner[:, :1] + corner[:, 1:2], heights[:, 1:]])
        slopes = np.hstack([first - bend[:, :1] + bend[:, 1:2], slopes[:, 1:]])
        return heights, slopes

    def keys(self, w: Array) -> dict[str, Any]:
        x = np.linspace(0.0, self.knots[-1], _PIECES)
        return {"kind": "tabulated", "points": np.column_stack([x, self(x)[0] @ w])}


def _bent_polynomials() -> Array:
    """Coefficients (m, 4) of polynomials in u that are nowhere negative for u >= 0 and span all such."""
    rows = [np.eye(_DEGREE + 1)[0], np.eye(_DEGREE + 1)[1]]
    for c in _TOUCHES.tolist():
        square = np.array([c * c, -2 * c, 1.0])
        rows += [np.append(square, 0.0), np.append(0.0, square)]
    return np.array([row / np.abs(row).max() for row in rows])


def _nearest(basis: _Powers | _Hats, x: Array, h: Array, centred: bool, weight: float, start: float = 0.0) -> _Fit | None:
    """The best w, h0 and, if it is to be fitted, x0, by steps of x0 that are found with the others."""
    from scipy.optimize import nnls

    centre, w = start, np.zeros(0)
    size = basis(np.zeros(1))[0].shape[1]
    penalty = math.sqrt(weight) * np.diff(np.eye(size), axis=0) if weight else np.zeros((0, size))
    for _ in range(_CENTRINGS if centred else 1):
        s = np.abs(x - centre)
        heights, slopes = basis(s)
        free = [np.ones(len(x))]
        if centred and len(w):
            free.append(-np.sign(x - centre) * (slopes @ w))
        ortho = np.linalg.qr(np.column_stack(free))[0]
        design = heights - ortho @ (ortho.T @ heights)
        aim = h - ortho @ (ortho.T @ h)
        # As many rows as columns are enough.
        small = np.column_stack([design, aim])
        small = np.asarray(np.linalg.qr(small, mode="r")) if len(x) > size + 1 else small
        left, right = small[:, :-1], small[:, -1]
        try:
            new = nnls(np.vstack([left, penalty]), np.append(right, np.zeros(len(penalty))), maxiter=50 * size)[0]
        except RuntimeError:  # too many iterations: nothing is known of this one
            return None
        known = np.linalg.lstsq(np.column_stack(free), h - heights @ new, rcond=None)[0]
        moved = float(np.clip(known[1], -0.1, 0.1)) if len(known) > 1 else 0.0
        first, w = not len(w), new
        if not np.any(w > 0):
            return None
        centre += moved
        if not first and abs(moved) < _STILL:
            break
    heights = basis(np.abs(x - centre))[0]
    offset = float(np.mean(h - heights @ w))
    numbers = 1 + centred + np.count_nonzero(w)
    return _Fit(basis.keys(w), centre, offset, offset + heights @ w, float(numbers), weight) if abs(centre) < 1 else None


def _smoothest(basis: _Hats, x: Array, h: Array, noise: float | None, centred: bool, weights: Array) -> _Fit | None:
    """The spline with the weight of the least expected error."""
    best, least, start = None, math.inf, 0.0
    for weight in weights.tolist():
        found = _nearest(basis, x, h, centred, weight, start)
        if found is None:
            continue
        heights = basis(np.abs(x - found.centre))[0]
        heights = heights - heights.mean(axis=0)
        steps = np.diff(np.eye(heights.shape[1]), axis=0)
        square = heights.T @ heights
        numbers = 1 + centred + float(np.trace(np.linalg.solve(square + weight * steps.T @ steps, square)))
        rest = float(np.sum((h - found.curve) ** 2))
        count = len(x)
        error = rest / noise**2 + 2 * numbers if noise else rest / max(count - numbers, 1e-3) ** 2
        if error < least:
            best, least = _Fit(found.keys, found.centre, found.offset, found.curve, min(numbers, count - 1.0), weight), error
    return best


def _flat_rounded(x: Array, h: Array, centred: bool) -> _Fit | None:
    from scipy.optimize import least_squares

    def curve(z: Array) -> Array:
        return z[1] + z[3] * np.maximum(np.abs(x - z[0]) - z[2], 0.0) ** 2 / 2

    def rows(z: Array) -> Array:
        return np.column_stack([np.ones(len(x)), np.maximum(np.abs(x - z[0]) - z[2], 0.0) ** 2 / 2])

    def jacobian(z: Array) -> Array:
        beyond = np.maximum(np.abs(x - z[0]) - z[2], 0.0)
        centre = -z[3] * beyond * np.sign(x - z[0]) if centred else np.zeros(len(x))
        return np.column_stack([centre, np.ones(len(x)), -z[3] * beyond, beyond**2 / 2])

    starts = []
    for half in _STARTS:
        z = np.array([0.0, 0.0, half, 0.0])
        z[[1, 3]] = np.linalg.lstsq(rows(z), h, rcond=None)[0]
        if z[3] > 0:
            starts.append((float(np.sum((curve(z) - h) ** 2)), half, z))
    if not starts:
        return None
    bounds = ([-0.5, -np.inf, 1e-9, 1e-12], [0.5, np.inf, 0.98, np.inf])
    best = least_squares(lambda z: curve(z) - h, min(starts)[2], jacobian, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    if not best.x[3] > 1e-9:
        return None
    centre, offset, half, bend = best.x.tolist()
    keys = {"kind": "flat_rounded", "radius": 1 / bend, "flat_half_length": half}
    return _Fit(keys, centre, offset, curve(best.x), 3.0 + centred)


def _with_units(keys: dict[str, Any], length: float, height: float) -> dict[str, Any]:
    """The keys of a profile in the units of the rows."""
    found = dict(keys)
    match keys["kind"]:
        case "hertz" | "flat_rounded":
            found["radius"] = keys["radius"] * length**2 / height
            if "flat_half_length" in keys:
                found["flat_half_length"] = keys["flat_half_length"] * length
        case "polynomial":
            found |= {"length": length, "rises": tuple(height * rise for rise in keys["rises"])}
        case _:
            found["points"] = keys["points"] * [length, height]
    return found
