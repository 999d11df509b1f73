"""Two half-planes on a grid of constant tractions, with the flaws of a model switched on one by one.

What a flaw does is taken as the difference between this model with it and without, on one grid, so that the grid itself
drops out to first order. It is for telling patterns apart, not for figures: those are the engines'.

# notation: h element lengths; p, q tractions (n,); g initial gap; delta approach; U shift; s slip, upper over lower; f friction
#           K_ij = 2/(pi E*) int ln|x_i - t| dt over element j: faces move by -K p into the bodies, s = U + K q where alike

    gap:   g - delta - (K_n - C_n) p - beta S q >= 0,  p >= 0
    slip:  s = U + (K_t - C_t) q - beta S p,  |q| <= f p,  q s' >= 0
    C = I/k, a layer: a penalty lets faces sink by p/k and creep by q/k
    K + b (x_i - x_j)^2 h_j, a body that ends: the far field of a resultant, to its lowest order that is no rigid motion
    S_ij = (1/E*) sgn(x_i - x_j) h_j, bodies that are not alike: pressure draws the faces along x, beta being Dundurs' constant
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reports.scoring.diagnosis_discrepancy import Array, Tractions

Flags = NDArray[np.bool_]

_MOST = 60
_TINY = 1e-10
# Pressure and shear of unlike bodies in turn, at most so often: each round leaves less than beta^2 of the error.
_COUPLED = 4
_SETTLED = 1e-6
# Loads closer than this share of the largest are one load, solved once: those of one revolution and the next differ by rounding.
_SAME_LOAD = 1e-9


class NotSettledError(ArithmeticError):
    """The active sets of an increment did not settle, or the whole contact slides."""


@dataclass(frozen=True)
class Flaws:
    """What is wrong with a model; all 0 is nothing.

    Attributes
    ----------
    normal_layer, shear_layer : 1/k [length/stress]
    normal_bend, shear_bend : b [1/(stress length)]
    coupling : Dundurs' beta, positive where the upper body is the more compliant in compression: (1 - 2 nu)/G is larger
    steepness : factor of the gap, and so of E* in the tractions
    offset : of the gap along x [length]
    """

    normal_layer: float = 0.0
    shear_layer: float = 0.0
    normal_bend: float = 0.0
    shear_bend: float = 0.0
    coupling: float = 0.0
    steepness: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class Grid:
    """Elements of two bodies.

    Attributes
    ----------
    x, lengths : (n,), centres and lengths [length]
    influence, squares, signs : (n, n), K, (x_i - x_j)^2 h_j and sgn(x_i - x_j) h_j; the mirror image, if any, added
    shares : (n,), of a traction in its resultant
    height : initial gap of any x [length]
    friction, modulus : f and E*
    pressed : pressures found so far by flaws and load
    """

    x: Array
    lengths: Array
    influence: Array
    squares: Array
    signs: Array
    shares: Array
    height: Callable[[Array], Array]
    friction: float
    modulus: float
    pressed: dict[tuple[float, ...], Array] = field(default_factory=dict)


def grid(ends: Array, height: Callable[[Array], Array], friction: float, modulus: float) -> Grid:
    """Elements between the ascending `ends` (n + 1,); where these start at 0, p and q are even and the mirror image is taken along.

    An even q goes with like bodies only: no coupling on such a grid.
    """
    x, lengths = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
    mirrored = ends[0] == 0
    images = (x, -x) if mirrored else (x,)

    def primitive(s: Array) -> Array:
        return s * np.log(np.abs(s)) - s

    apart = [x[:, None] - image for image in images]
    influence = sum(primitive(d + lengths / 2) - primitive(d - lengths / 2) for d in apart)
    return Grid(
        x,
        lengths,
        2 / (np.pi * modulus) * np.asarray(influence),
        np.asarray(sum(np.square(d) for d in apart)) * lengths,
        np.asarray(sum(np.sign(d) for d in apart)) * lengths,
        lengths * len(images),
        height,
        friction,
        modulus,
    )


def march(on: Grid, flaws: Flaws, loads: Array) -> Tractions:
    """p and q at the end of every increment, (k, n) each; `loads` (k, 2) are P and Q there, from the unloaded state.

    Each increment is one implicit step, as finite-element codes take it: the law holds at its end.

    Raises
    ------
    NotSettledError
        Where an increment has no solution or its active sets do not settle.
    """
    influence = _influence(on, flaws.shear_bend, flaws.shear_layer)
    drawn = -flaws.coupling / on.modulus * on.signs
    p = q = np.zeros(len(on.x))
    pressures, shears = [], []
    unit = _SAME_LOAD * float(np.abs(loads).max())
    for normal, tangential in unit * np.round(loads / unit):
        old_p, old_q = p, q
        for turn in range(_COUPLED if flaws.coupling else 1):
            last = p
            p = _pressure(on, flaws, float(normal), drawn @ q, p > 0)
            if turn and np.abs(p - last).max() <= _SETTLED * np.abs(p).max():
                break
            q = _shear(on, influence, (old_q, drawn @ (p - old_p)), on.friction * p, float(tangential))
        pressures.append(p)
        shears.append(q)
    return np.array(pressures), np.array(shears)


def _influence(on: Grid, bend: float, layer: float) -> Array:
    return np.asarray(on.influence + bend * on.squares - layer * np.eye(len(on.x)))


def _bordered(influence: Array, shares: Array, free: Flags, known: Array, total: float) -> Array:
    """t on the free elements with K t + constant = -known there and shares t = total."""
    count = int(free.sum())
    matrix = np.zeros((count + 1, count + 1))
    matrix[:-1, :-1] = influence[np.ix_(free, free)]
    matrix[:-1, -1] = np.abs(influence).max()
    matrix[-1, :-1] = shares[free]
    solution = np.linalg.solve(matrix, np.append(-known, total))
    solution[-1] *= matrix[0, -1]
    return solution


def _pressure(on: Grid, flaws: Flaws, load: float, lifted: Array, start: Flags) -> Array:
    """No tension, no penetration, the gap `lifted` by the shear; `start`: elements that touched last, where any did.

    Kept for each load where nothing is lifted, since p then has no memory.
    """
    key = (flaws.normal_bend, flaws.normal_layer, flaws.steepness, flaws.offset, load)
    if not flaws.coupling and key in on.pressed:
        return on.pressed[key]
    influence = _influence(on, flaws.normal_bend, flaws.normal_layer)
    gap = flaws.steepness * np.asarray(on.height(on.x - flaws.offset)) + lifted
    pressure, touching = np.zeros(len(on.x)), start if start.any() else np.ones(len(on.x), dtype=bool)
    for _ in range(_MOST if load > 0 else 0):
        solution = _bordered(influence, on.shares, touching, -gap[touching], load)
        pressure = np.zeros(len(on.x))
        pressure[touching] = solution[:-1]
        opening = gap - influence @ pressure - solution[-1]
        new = np.where(touching, pressure > -_TINY * np.abs(pressure).max(), opening < -_TINY * np.ptp(gap))
        if np.array_equal(new, touching):
            break
        touching = new
    else:
        if load > 0:
            raise NotSettledError("normal contact")
    found = np.maximum(pressure, 0.0)
    if not flaws.coupling:
        on.pressed[key] = found
    return found


def _shear(on: Grid, influence: Array, old: tuple[Array, Array], limit: Array, load: float) -> Array:
    """q at the end of an increment: sticking elements do not move, slipping ones are at the limit, against the slip."""
    before, drawn = old
    touching, slipping = limit > 0, np.zeros(len(limit))
    for _ in range(_MOST):
        stick = touching & (slipping == 0)
        traction = slipping * limit
        if not stick.any():
            if touching.any():
                raise NotSettledError("the whole contact slides")
            return traction
        off = influence[stick] @ (traction - before) + drawn[stick]
        solution = _bordered(influence, on.shares, stick, off, load - float(on.shares @ traction))
        traction[stick] = solution[:-1]
        slip = influence @ (traction - before) + drawn + solution[-1]
        over = stick & (np.abs(traction) > limit * (1 + _TINY))
        back = (slipping != 0) & (slip * slipping < -_TINY * np.abs(slip).max())
        if not (over | back).any():
            return traction
        slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
    raise NotSettledError("friction")
