"""From memory curves to tractions, slips and rigid shifts, for many instants and points at once.

# notation: M'(eta) slope of the memory curve, A = 2/E*, P_x load at which a = |x|

q(x) = int M' dp(x, eta),  s(x) = (A/pi) int M' arccosh(|x|/a) d eta,  U = (A/pi) int M' ln(2 L/a) d eta: one sum over the
pieces of the curve with three kernels. What instants have in common, the pieces under the uppermost, is summed once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import EllipseLeg
from semi_analytic.arcs import arc_log, arc_shear, arc_slip
from semi_analytic.contact import Contact
from semi_analytic.history import Span
from semi_analytic.memory import Curve, Piece, front_time, pieces

Array = NDArray[np.float64]
Kernel = Literal["shear", "slip", "shift"]


@dataclass(frozen=True, eq=False)
class Integrals:
    """int M'(eta) K(x, eta) d eta over memory curves at |x| = `x` (k,), with what is shared remembered.

    Attributes
    ----------
    contact : normal contact of the profile
    x : (k,) distances from the centre >= 0
    kernel : "shear" (K = dp/d eta), "slip" (K = arccosh(|x|/a) outside, 0 inside) or "shift" (K = ln(2 L/a); x plays no part)
    """

    contact: Contact
    x: Array
    kernel: Kernel
    _known: dict[int, tuple[Piece, Array]] = field(default_factory=dict)

    def whole(self, curve: Curve) -> Array:
        """Over a whole curve: shape (k,)."""
        todo, total = [], np.zeros(len(self.x))
        for piece in pieces(curve):
            if id(piece) in self._known:
                total = self._known[id(piece)][1]
                break
            todo.append(piece)
        for piece in reversed(todo):
            total = total + self._part(piece, np.array([piece.top]), None)[0]
            self._known[id(piece)] = (piece, total)
        return total

    def at(self, span: Span, time: ArrayLike) -> Array:
        """At times (n,) of a span's leg: shape (n, k)."""
        t = np.atleast_1d(np.asarray(time, dtype=float))
        load = span.leg.loads(t)[0]
        slipped = span.slipped(t)
        total = np.zeros((len(t), len(self.x)))
        if span.active is not None:
            total += self.whole(span.base) + self._part(span.active, load - slipped, slipped)
        if span.direction:
            limit = span.direction * span.friction
            total += limit * (self._moment(0, load) - self._moment(0, load - slipped))
        return total

    def _part(self, piece: Piece, reach: Array, slipped: Array | None) -> Array:
        """Over one piece from its lower end to the loads `reach` (n,): shape (n, k)."""
        if piece.arc is not None:
            return self._arc_part(piece, reach, slipped)
        bottom = np.array([piece.bottom])
        total = (piece.slope - 2 * piece.bend * piece.anchor.normal) * (self._moment(0, reach) - self._moment(0, bottom))
        if piece.bend:
            total += 2 * piece.bend * (self._moment(1, reach) - self._moment(1, bottom))
        return total

    def _arc_part(self, piece: Piece, reach: Array, slipped: Array | None) -> Array:
        leg = piece.anchor.leg
        assert isinstance(leg, EllipseLeg)
        assert piece.arc is not None
        last = np.array([piece.arc[1]]) if slipped is None else front_time(piece, 0.0, reach)
        slope = leg.amplitude[1] * np.cos(leg.phase) / leg.amplitude[0]
        total = slope * (self._moment(0, reach) - self._moment(0, np.array([piece.bottom])))
        if self.kernel == "shear":
            return total + arc_shear(self.contact, leg, piece.arc[0], last, self.x)
        if self.kernel == "slip":
            return total + arc_slip(self.contact, leg, piece.arc[0], last, self.x)
        return total + arc_log(self.contact, leg, piece.arc[0], last)[:, None]

    def _moment(self, order: int, load: Array) -> Array:
        """int_0^load eta^order K d eta: shape (n, k)."""
        contact, column = self.contact, load[:, None]
        if self.kernel == "shift":
            function: Callable[[ArrayLike], Array] = (contact.log_distance, contact.log_moment)[order]
            return np.broadcast_to(function(column), (len(load), len(self.x)))
        if self.kernel == "shear":
            return (contact.pressure, contact.pressure_moment)[order](self.x, column)
        return (contact.spread, contact.spread_moment)[order](self.x, column)
