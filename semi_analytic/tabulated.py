"""Normal contact of a tabulated profile: its curvature is constant between knots, so that P and dP/da are sums of rounded tips.

# notation: b_j knots, kappa_j = h'' between b_j and b_(j+1), u = sqrt(a - b_j)

    dP/da = E* a [kappa_0 pi/2 + sum over b_j < a of (kappa_j - kappa_(j-1)) arccos(b_j/a)]

The sums are taken once, at the nodes of Chebyshev series in u behind each knot; up to the second knot all is in closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, NotFoundError, Tabulated
from scenes.chebyshev import NODES, clenshaw, series
from semi_analytic.flat_law import inverse_load_function, load_function
from semi_analytic.pile import Pile

Array = NDArray[np.float64]

_CHUNK = 2_000_000
_STEPS = 50
# Share of a half-width below which Newton's next step would be its square: less than rounding.
_ROOT_OF_ROUNDING = 1e-9
# Of the largest dP/da: what rounding may leave below 0 where the profile is straight.
_FALL = 1e-12


@dataclass(frozen=True, eq=False)
class Laws:
    """P and dP/da on pieces [low, high] (n,) of u behind the knots `begin` (n,): coefficients (DEGREE + 1, n).

    `edges` (n,) are the half-widths and `loads` (n,) the normal loads at which the pieces begin.
    """

    begin: Array
    low: Array
    high: Array
    edges: Array
    loads: Array
    load: Array
    rate: Array


@dataclass(frozen=True, eq=False)
class TabulatedContact(Pile):
    """Two half-planes pressed together by a profile of piecewise constant curvature. Methods as in `Contact`.

    Attributes
    ----------
    knots : (n + 1,) from 0 up
    curvature : (n,) h'' between them
    """

    knots: Array
    curvature: Array

    @property
    def least(self) -> float:
        """Half-length of the flat, if the profile starts with one."""
        return float(self._bent[0][0])

    @property
    def breaks(self) -> tuple[float, ...]:
        """The knots at which the curvature changes."""
        return tuple(self._bent[0][1:-1].tolist())

    @cached_property
    def _bent(self) -> tuple[Array, Array]:
        """Knots from the least half-width on, and the curvature between them, times E*."""
        first = int(np.flatnonzero(self.curvature > 0)[0])
        return self.knots[first:], self.modulus * self.curvature[first:]

    def _first_rate(self, half: Array) -> Array:
        """dP/da up to the second knot: Hertz, or beside a flat."""
        b, bend = self._bent[0][0], self._bent[1][0]
        tau = np.sqrt(np.maximum((half - b) * (half + b), 0.0))
        return bend * half * (np.arctan2(tau, b) if b > 0 else np.pi / 2)

    def _first_load(self, half: Array) -> Array:
        b, bend = self._bent[0][0], self._bent[1][0]
        if b == 0:
            return bend * np.pi / 4 * half * half
        return bend * b * b / 2 * load_function(np.sqrt(np.maximum((half - b) * (half + b), 0.0)) / b)

    def _first_half(self, load: Array) -> Array:
        b, bend = self._bent[0][0], self._bent[1][0]
        if b == 0:
            return np.sqrt(4 * load / (np.pi * bend))
        return b * np.sqrt(1 + np.square(inverse_load_function(2 * load / (bend * b * b))))

    def _sums(self, begin: Array, u: Array) -> tuple[Array, Array]:
        """P and dP/da at begin + u^2, (n, nodes), by the sums over the knots."""
        knots, bend = self._bent
        half = begin[:, None] + u * u
        load, rate = np.zeros(half.shape), np.zeros(half.shape)
        jumps = np.diff(bend, prepend=0.0)
        for k in range(0, len(begin), max(_CHUNK // (half.shape[1] * len(jumps)), 1)):
            here = slice(k, k + max(_CHUNK // (half.shape[1] * len(jumps)), 1))
            reached = int(np.searchsorted(knots[:-1], half[here].max()))
            a, b = half[here, :, None], knots[:reached]
            # a - b is known without cancellation.
            above = np.maximum((begin[here, None, None] - b) + np.square(u[here, :, None]), 0.0)
            tau = np.sqrt(above * (a + b))
            angle = np.arctan2(tau, b)
            inside = above > 0
            # a^2 arccos(b/a) - b tau is twice the load of a flat with rounded edges; with b = 0 Hertz.
            rate[here] = np.sum(np.where(inside, jumps[:reached] * angle, 0.0), axis=-1) * half[here]
            load[here] = np.sum(np.where(inside, jumps[:reached] * (a * a * angle - b * tau), 0.0), axis=-1) / 2
        return load, rate

    def splits_at(self) -> float | None:
        """The least half-width at which dP/da < 0: pressed further, the contact would part in two. None where there is none."""
        laws = self._laws
        if not len(laws.begin):
            return None  # all in closed form, and rising
        # Of every piece the ends too: where P' falls behind a knot it is least at the next one.
        t = np.concatenate([[-1.0], NODES, [1.0]])
        half = laws.begin[:, None] + np.square(laws.low[:, None] + (laws.high - laws.low)[:, None] * (1 + t) / 2)
        rate = self.stiffness(half)
        falls = rate < -_FALL * np.max(rate)
        return float(np.min(half[falls])) if np.any(falls) else None

    @cached_property
    def _laws(self) -> Laws:
        """Series behind every knot from the second on; none where there are no more than two."""
        knots, _ = self._bent
        pieces: list[tuple[float, float, float]] = []
        for before, begin, end in zip(knots[:-2].tolist(), knots[1:-1].tolist(), knots[2:].tolist(), strict=True):
            # Behind a short interval the series is in octaves: what the knot before leaves is singular at u^2 = before - begin.
            whole, step = (end - begin) ** 0.5, (begin - before) ** 0.5
            marks = [0.0, *(step * 2.0**k for k in range(math.ceil(math.log2(whole / step)))), whole]
            if len(marks) > 2 and whole - marks[-2] < 0.1 * (marks[-2] - marks[-3]):
                del marks[-2]
            pieces += [(begin, low, high) for low, high in pairwise(marks)]
        at, low, high = (np.array([piece[k] for piece in pieces]) for k in range(3))
        load, rate = self._sums(at, low[:, None] + (high - low)[:, None] * (1 + NODES) / 2)
        loads, _ = self._sums(at, low[:, None])
        return Laws(at, low, high, at + low * low, loads[:, 0], series(load).T.copy(), series(rate).T.copy())

    def _by_series(self, half: Array, rate: bool) -> Array:
        laws = self._laws
        first = self._first_rate(half) if rate else self._first_load(half)
        if not len(laws.begin):
            return first
        number = np.maximum(np.searchsorted(laws.edges, half, side="right") - 1, 0)
        u = np.sqrt(np.maximum(half - laws.begin[number], 0.0))
        return np.where(half < laws.edges[0], first, self._on(number, u, rate))

    def _on(self, number: NDArray[np.intp], u: Array, rate: bool) -> Array:
        laws = self._laws
        low, high = laws.low[number], laws.high[number]
        t = np.minimum((2 * u - low - high) / (high - low), 1.0)
        return clenshaw(laws.rate if rate else laws.load, number, t)

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]."""
        return self._by_series(np.abs(np.asarray(half_width, dtype=float)), False)

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da [stress]."""
        return self._by_series(np.abs(np.asarray(half_width, dtype=float)), True)

    @cached_property
    def _most(self) -> float:
        return float(self.load(self.knots[-1]))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length]; behind the second knot by Newton's method.

        Raises
        ------
        InputError
            For a load that needs a contact wider than the table.
        """
        p = np.asarray(load, dtype=float)
        most = float(np.max(p, initial=0.0))
        if most > self._most:
            raise InputError(
                f"profile: the normal load {most:.6g} needs a contact wider than the table, whose last x = {self.knots[-1]:.6g} "
                f"carries {self._most:.6g}"
            )
        laws = self._laws
        half = np.asarray(self._first_half(np.minimum(p, laws.loads[0]) if len(laws.loads) else p))
        later = np.flatnonzero(p.ravel() >= laws.loads[0]) if len(laws.loads) else np.empty(0, dtype=int)
        if len(later):
            result = half.ravel()
            result[later] = self._later_half(p.ravel()[later])
            half = result.reshape(p.shape)
        return half

    def _later_half(self, load: Array) -> Array:
        laws = self._laws
        number = np.searchsorted(laws.loads, load, side="right") - 1
        ends = np.append(laws.loads[1:], self._most)
        low, high = laws.low[number] ** 2, laws.high[number] ** 2
        square = low + (high - low) * (load - laws.loads[number]) / (ends - laws.loads)[number]
        begin = laws.begin[number]
        # P is nearly linear in a - b = u^2, whose last digit counts from a.
        for _ in range(_STEPS):
            root = np.sqrt(square)
            step = (load - self._on(number, root, False)) / self._on(number, root, True)
            square = np.clip(square + step, low, high)
            if np.all(np.abs(step) <= _ROOT_OF_ROUNDING * (begin + square)):
                return begin + square
        raise NotFoundError(f"no half-width was found for the normal load {float(load[np.argmax(np.abs(step))]):.17g}")


def tabulated_contact(modulus: float, profile: Tabulated) -> TabulatedContact:
    """The mechanics of a profile given as rows.

    Raises
    ------
    InputError
        For rows under which the contact would split, with the row and what to do.
    """
    spline = profile.spline()
    contact = TabulatedContact(modulus, profile.datum_length, spline.x, spline.curvature)
    half = contact.splits_at()
    if half is None:
        return contact
    row, step = profile.row_before(half), profile.step_of_heights()
    x, h = profile.points.values[row].tolist()
    cause, cure = "the curve through the rows bends down there", "smooth the rows until it does not"
    if step is not None:
        cause = f"h is written in steps of {step:.6g}, and the curve through such rows goes up by stairs"
        cure = "write h with more digits, leave rows out until each rises by many steps, or give a formula that fits them"
    where = f"{profile.place(row)}, x = {x:.6g} and h = {h:.6g}"
    raise InputError(f"{where}: the contact would split near a half-width of {half:.6g}: {cause}; {cure}")
