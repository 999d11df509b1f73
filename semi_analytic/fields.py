"""Ciavarella-Jaeger superposition: shear traction q, slip s and relative tangential displacement U from memory curves.

# notation: M'(eta) slope of the memory curve, A = 2/E*, P_x load at which a = |x|

q(x) = int M' dp(x, eta),  s(x) = (A/pi) int M' arccosh(|x|/a) d eta,  U = (A/pi) int M' ln(2 L/a) d eta: one sum over the pieces
of the curve with three kernels, for many instants and points at once. What instants have in common, the pieces under the
uppermost, is summed once.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from semi_analytic.arcs import Arc, Kernel
from semi_analytic.memory import Curve, Piece, Snapshot, front_time, pieces
from semi_analytic.profiles import Contact
from semi_analytic.quadrature import gauss

Array = NDArray[np.float64]

# Share of a load up to which a line of the memory is short: differences of slips keep 1e-15 of the whole, over its power 3/2.
_SHORT = 0.01


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
        """Over a whole curve: shape (k,).

        >>> from scenes.segments import straight_segments
        >>> from semi_analytic.hertz import HertzContact
        >>> from semi_analytic.history import march
        >>> contact = HertzContact(modulus=np.pi, radius=1.0, datum_length=1.0)  # p(0, P) = sqrt(P)
        >>> stuck = march(None, straight_segments([(0.0, 0.0, 0.0), (1.0, 4.0, 1.0)]), 0.5, 0.0)[1]
        >>> Integrals(contact, np.zeros(1), "shear").whole(stuck).round(12).tolist()  # M' = 1/4: q = p/4
        [0.5]
        >>> Integrals(contact, np.zeros(1), "shift").whole(stuck).round(12).tolist()  # U pi/A = (P/4) [ln(2 L/a) + 1/2], a = 4/pi
        [0.951582705289]
        """
        self._remember([curve])
        return self._known[id(curve)][1] if curve is not None else np.zeros(len(self.x))

    def over(self, snapshot: Snapshot) -> Array:
        """Over the curves of a snapshot: shape (n, k).

        At constant P this is the traction of Cattaneo and Mindlin, q = f [p(x, P) - p(x, P - Q/f)].

        >>> from scenes.segments import straight_segments
        >>> from semi_analytic.hertz import HertzContact
        >>> from semi_analytic.history import march, take
        >>> contact = HertzContact(modulus=np.pi, radius=1.0, datum_length=1.0)  # p(0, P) = sqrt(P)
        >>> loading, slip = march(None, straight_segments([(0.0, 0.0, 0.0), (1.0, 4.0, 0.0), (2.0, 4.0, 1.5)]), 0.5, 0.0)[0]
        >>> shear = Integrals(contact, np.zeros(1), "shear").over(take([(slip, np.array([2.0]))]))
        >>> shear.round(12).tolist()  # 0.5 (sqrt 4 - sqrt 1)
        [[0.5]]
        """
        front, slopes, bottoms = snapshot.load - snapshot.slipped, np.zeros(len(snapshot.load)), np.zeros(len(snapshot.load))
        groups = list(snapshot.groups())
        for piece, here in groups:
            slopes[here], bottoms[here] = _slope(piece), piece.bottom
        slip_line = np.asarray(snapshot.direction * snapshot.friction, dtype=float)
        total = self._line(slip_line, front, snapshot.load) + self._line(slopes, bottoms, front)
        self._remember([piece.below for piece, _ in groups])
        curved = self._curved([(piece, front[here]) for piece, here in groups])
        for (piece, here), arc in zip(groups, curved, strict=True):
            total[here] += self.whole(piece.below) + arc
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
        slopes, bottoms, tops = (
            np.array(part) for part in zip(*((_slope(p), p.bottom, p.top) for p in unknown.values()), strict=True)
        )
        curved = self._curved([(piece, np.array([piece.top])) for piece in unknown.values()])
        lines = self._line(slopes, bottoms, tops)
        own = {id(piece): line + np.ravel(arc) for piece, line, arc in zip(unknown.values(), lines, curved, strict=True)}
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

    def _line(self, slope: Array, bottom: Array, top: Array) -> Array:
        """Slope times int K d eta from the loads `bottom` to `top` (n,): shape (n, k); 0 for lines of no slope or no length.

        A short line is integrated by itself: of a difference of two long ones little more than round-off would be left.
        """
        total = np.zeros((len(top), len(self.x)))
        there = np.flatnonzero((slope != 0) & (top != bottom))
        short = np.zeros(len(there), dtype=bool)
        if self.kernel == "slip" and not self.contact.closed_form:
            length = top[there] - bottom[there]
            # Not across a corner of the profile, or close behind one: there a(P) is not smooth.
            below, above = (np.searchsorted(self.contact.break_loads, ends) for ends in (bottom[there] - length, top[there]))
            short = (length < _SHORT * top[there]) & (below == above)
        for here, between in ((there[~short], self._difference), (there[short], self._by_itself)):
            if len(here):
                total[here] = slope[here, None] * between(bottom[here], top[here])
        return total

    def _difference(self, bottom: Array, top: Array) -> Array:
        different, fold = np.unique(np.concatenate([bottom, top]), return_inverse=True)
        moments = self.moment(0, different)
        return np.asarray(moments[fold[len(bottom) :]] - moments[fold[: len(bottom)]])

    def _by_itself(self, bottom: Array, top: Array) -> Array:
        """int arccosh(|x|/a) d eta, eta = end - v^2, v = e sinh(s): sqrt(P_x - eta) becomes smooth, e^2 = P_x - end >= 0."""
        contact, edge = self.contact, self.contact.load(self.x)
        end = np.minimum(top[:, None], edge)
        width = np.sqrt(np.maximum(end - bottom[:, None], 0.0))
        result = np.zeros(end.shape)
        beyond = np.sqrt(np.maximum(edge - end, 0.0))
        near = beyond < 0.5 * width
        for some, count in ((~near, 12), (near, 32)):
            row, point = np.nonzero((width > 0) & some)
            e = np.maximum(beyond[row, point], 1e-4 * width[row, point])
            node, weight = gauss(count)
            reach = np.arcsinh(width[row, point] / e)[:, None]
            v, root = e[:, None] * np.sinh(reach * node), e[:, None] * np.cosh(reach * node)
            excess = np.square(v) + np.square(beyond[row, point])[:, None]
            ratio = contact.arccosh_ratio(self.x[point, None], excess, contact.advance(end[row, point, None] - np.square(v)))
            result[row, point] = np.sum(weight * reach * 2 * v * root * ratio, axis=1)
        return result

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
            piece = fronts[numbers[0]][0]
            if key not in self._arcs:
                self._arcs[key] = piece, Arc(self.contact, self.kernel, piece, self.x)
            loads = [fronts[number][1] for number in numbers]
            times = front_time(piece, np.concatenate(loads))
            values = np.split(self._arcs[key][1].up_to(times), np.cumsum([len(part) for part in loads])[:-1])
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
        return (contact.slip_integral, contact.slip_integral_moment)[order](self.x, column)


def _slope(piece: Piece) -> float:
    """Slope of the straight part: of a parabola at eta = 0; an arc has none."""
    return piece.slope - 2 * piece.bend * piece.anchor.normal if piece.arc is None else 0.0
