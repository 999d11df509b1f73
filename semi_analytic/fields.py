"""From memory curves to tractions, slips and tangential displacements, for many instants and points at once.

# notation: M'(eta) slope of the memory curve, A = 2/E*, P_x load at which a = |x|

q(x) = int M' dp(x, eta),  s(x) = (A/pi) int M' arccosh(|x|/a) d eta,  U = (A/pi) int M' ln(2 L/a) d eta: one sum over the pieces
of the curve with three kernels. What instants have in common, the pieces under the uppermost, is summed once.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from semi_analytic.arcs import Arc, Kernel
from semi_analytic.memory import Curve, Piece, Snapshot, front_time, pieces
from semi_analytic.profiles import Contact

Array = NDArray[np.float64]


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
    _arcs: dict[tuple[int, float, float], tuple[Piece, Arc]] = field(default_factory=dict)

    def whole(self, curve: Curve) -> Array:
        """Over a whole curve: shape (k,)."""
        self._remember([curve])
        return self._known[id(curve)][1] if curve is not None else np.zeros(len(self.x))

    def over(self, snapshot: Snapshot) -> Array:
        """Over the curves of a snapshot: shape (n, k)."""
        front = snapshot.load - snapshot.slipped
        at_front = self.moment(0, front)
        total = np.zeros(at_front.shape)
        slid = np.flatnonzero(snapshot.slipped)
        if len(slid):
            line = np.asarray(snapshot.direction[slid] * snapshot.friction, dtype=float)[:, None]
            total[slid] = _rise(line, self.moment(0, snapshot.load[slid]), at_front[slid])
        groups = list(snapshot.groups())
        self._remember([piece.below for piece, _ in groups])
        bottoms = self.moment(0, np.array([piece.bottom for piece, _ in groups]))
        curved = self._curved([(piece, front[here]) for piece, here in groups])
        for (piece, here), bottom, arc in zip(groups, bottoms, curved, strict=True):
            total[here] += self.whole(piece.below) + _rise(_slope(piece), at_front[here], bottom) + arc
        return total

    def _remember(self, curves: list[Curve]) -> None:
        """Sum the curves that are not known yet, each from the first known piece up."""
        unknown: dict[int, Piece] = {}
        for curve in curves:
            for piece in pieces(curve):
                if id(piece) in self._known or id(piece) in unknown:
                    break
                unknown[id(piece)] = piece
        if not unknown:
            return
        tops = self.moment(0, np.array([piece.top for piece in unknown.values()]))
        bottoms = self.moment(0, np.array([piece.bottom for piece in unknown.values()]))
        curved = self._curved([(piece, np.array([piece.top])) for piece in unknown.values()])
        own = {}
        for piece, top, bottom, arc in zip(unknown.values(), tops, bottoms, curved, strict=True):
            own[id(piece)] = _rise(_slope(piece), top, bottom) + (arc[0] if isinstance(arc, np.ndarray) else arc)
        for piece in unknown.values():
            self._add_up(piece, own)

    def _add_up(self, curve: Piece, own: dict[int, Array]) -> None:
        """Running sums from the lowest piece that is not known yet to the top of the curve."""
        chain = []
        for piece in pieces(curve):
            if id(piece) in self._known:
                break
            chain.append(piece)
        for piece in reversed(chain):
            below = self._known[id(piece.below)][1] if piece.below is not None else np.zeros(len(self.x))
            self._known[id(piece)] = (piece, below + own[id(piece)])

    def _curved(self, fronts: list[tuple[Piece, Array]]) -> list[Array | float]:
        """What each piece from its lower end to the loads of its front (n,) has beyond its straight part: shape (n, k), or 0.

        Pieces that are cut from one arc are integrated together.
        """
        found: list[Array | float] = [0.0] * len(fronts)
        alike: dict[tuple[int, float, float], list[int]] = {}
        for number, (piece, front) in enumerate(fronts):
            if piece.arc is not None:
                alike.setdefault((id(piece.anchor.leg), piece.arc[0], piece.anchor.time), []).append(number)
            elif piece.bend:
                found[number] = 2 * piece.bend * (self.moment(1, front) - self.moment(1, np.array([piece.bottom])))
        for key, numbers in alike.items():
            if key not in self._arcs:
                piece = fronts[numbers[0]][0]
                self._arcs[key] = piece, Arc(self.contact, self.kernel, piece, self.x)
            times = [front_time(*fronts[number]) for number in numbers]
            values = np.split(self._arcs[key][1].up_to(np.concatenate(times)), np.cumsum([len(part) for part in times])[:-1])
            for number, value in zip(numbers, values, strict=True):
                found[number] = value
        return found

    @property
    def arc_error(self) -> float:
        """Largest estimated error of the arcs that were integrated."""
        return max((arc.error for _, arc in self._arcs.values()), default=0.0)

    def moment(self, order: int, load: Array) -> Array:
        """int_0^load eta^order K d eta: shape (n, k) from (n,)."""
        contact, column = self.contact, load[:, None]
        if self.kernel == "shift":
            function = (contact.log_distance, contact.log_moment)[order]
            return np.broadcast_to(function(column), (len(load), len(self.x)))
        if self.kernel == "shear":
            # All moments are taken as differences between two loads.
            return (contact.pressure_rise, contact.pressure_moment)[order](self.x, column)
        return (contact.spread, contact.spread_moment)[order](self.x, column)


def _rise(slope: float | Array, top: Array, bottom: Array) -> Array:
    """Slope times rise; 0 where either is, also where the kernel is infinite: no load at the tip of a wedge."""
    moved = (top != bottom) & (slope != 0)
    return slope * np.subtract(top, bottom, out=np.zeros(moved.shape), where=moved)


def _slope(piece: Piece) -> float:
    """Slope of the straight part: of a parabola at eta = 0; an arc has none."""
    return piece.slope - 2 * piece.bend * piece.anchor.normal if piece.arc is None else 0.0
