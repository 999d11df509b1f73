"""The frictional memory of a contact: the curve M(eta), an immutable value, and what a load does to
it (Masing rule).

# notation: eta normal load in [0, P]; M(eta) tangential force of the flat punches up to eta, M(0) =
#           0, M(P) = Q, |dM/d eta| <= f; s direction of slip, +1 or -1; P_c load at the front of a
#           slip zone

The curve is a stack of pieces, the last at the top; a piece knows the one below it, so that all
instants of a history share what they have in common. A piece is a parabola M = M_a + (slope + bend
(eta - eta_a)) (eta - eta_a) about an instant `a` of the load path (a straight line mostly), or an
arc: a stretch of a curved leg that was appended in full stick.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple, Protocol, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NORMAL_LOAD, Combination, LoadSegment
from scenes.array_types import Array

_EPS = float(np.finfo(float).eps)
_REPEATS = 1e-12
_OF_SLIP = 1e-4
_LEAST = 2e-14
LAST_DIGITS = 4 * _EPS
"""Share of P by which P_c may be off: measured 1 to 3 last digits on cycles of constant P with d/P
from 1e-4 to 1e-14.
"""

PROMISED = 1e-12
"""Closed forms promise that much, see `errors`; what rounding adds is stated where it is more."""


def repeats_within(share: float) -> float:
    """Share of f P within which a cycle counts as repeated: 1e-12, but no more than 1e-4 of what
    slips (`share` of P).
    """
    return min(_REPEATS, max(_OF_SLIP * share, _LEAST))


def slip_combination(direction: int, friction: float) -> Combination:
    """The combination that grows while the surfaces slip in `direction` (+1 forward, -1 reverse):
    +-Q - f P.
    """
    return Combination(-friction, float(direction))


class Instant(NamedTuple):
    """A point of the load path: segment, the segment's own time, and both loads there."""

    segment: LoadSegment
    time: float
    normal: float
    tangential: float


def instant(segment: LoadSegment, time: float) -> Instant:
    """The point of `leg` at `time`."""
    normal_load, tangential_load = segment.loads(time)
    return Instant(segment, float(time), float(normal_load), float(tangential_load))


def combination_change(
    where: Instant, segment: LoadSegment, combination: Combination, time: ArrayLike
) -> Array:
    """Change of the combination from any earlier instant of the path to `time` on `leg`."""
    if where.segment is segment:
        return segment.change_of(combination, time, where.time)
    begin = instant(segment, segment.start)
    jump = combination.normal * (begin.normal - where.normal) + combination.tangential * (
        begin.tangential - where.tangential
    )
    return segment.change_of(combination, time, segment.start) + jump


class CurvePart(Protocol):
    """What fields ask of the uppermost piece or line of a memory curve: a `Piece`, or the `Knot` of
    a load series.
    """

    @property
    def below(self) -> Self | None:
        """The curve under it."""

    @property
    def top(self) -> float:
        """Eta at the upper end."""

    @property
    def bottom(self) -> float:
        """Eta at the lower end."""

    @property
    def straight_slope(self) -> float:
        """Slope of the straight part: of a parabola at eta = 0; an arc has none."""

    @property
    def bend(self) -> float:
        """Half the second derivative."""

    @property
    def arc(self) -> tuple[float, float] | None:
        """Times at the ends of an arc, else None."""

    def slope_at(self, eta: Array) -> Array:
        """dM/d eta at loads (n,): (n,)."""


class Piece(NamedTuple):
    """The uppermost piece of a memory curve, and by `below` the whole curve.

    Attributes
    ----------
    below
        the curve under this piece, None if this piece starts at eta = 0
    top
        eta at the upper end
    anchor
        the instant of the load path from which the piece is measured
    slope, bend
        dM/d eta at the anchor and half the second derivative; not used for an arc
    arc
        (first, last) times of the anchor's leg at the lower and the upper end of an arc, else
        None
    """

    below: Piece | None
    top: float
    anchor: Instant
    slope: float
    bend: float = 0.0
    arc: tuple[float, float] | None = None

    @property
    def bottom(self) -> float:
        """Eta at the lower end."""
        return self.below.top if self.below is not None else 0.0

    @property
    def straight_slope(self) -> float:
        """Slope of the straight part: of a parabola at eta = 0; an arc has none."""
        return self.slope - 2 * self.bend * self.anchor.normal if self.arc is None else 0.0

    def slope_at(self, eta: Array) -> Array:
        """dM/d eta at loads (n,): of an arc dQ/dP of the path, 0 where both loads turn at once."""
        if self.arc is None:
            return self.slope + 2 * self.bend * (eta - self.anchor.normal)
        normal_rate, tangential_rate = self.anchor.segment.rates(time_of_load_on_arc(self, eta))
        return np.divide(
            tangential_rate, normal_rate, out=np.zeros(eta.shape), where=normal_rate != 0
        )


Curve: TypeAlias = Piece | None
"""A memory curve: its uppermost piece, or None for bodies out of contact."""


_Part = TypeVar("_Part", bound=CurvePart)


def pieces(curve: _Part | None) -> Iterator[_Part]:
    """The pieces of a curve from the top down."""
    while curve is not None:
        yield curve
        curve = curve.below


def force_on_piece(piece: Piece, eta: ArrayLike) -> Array:
    """M(eta) on one piece."""
    step = np.asarray(eta, dtype=float) - piece.anchor.normal
    if piece.arc is None:
        return piece.anchor.tangential + (piece.slope + piece.bend * step) * step
    return piece.anchor.tangential + piece.anchor.segment.change_of(
        Combination(0.0, 1.0), time_of_load_on_arc(piece, eta), piece.anchor.time
    )


def _whole_arc(piece: Piece) -> tuple[float, float]:
    """The arc as it was appended, before anything was cut off its top."""
    assert piece.arc is not None  # for the type checker: only called for arcs
    return piece.arc[0], piece.anchor.time


def time_of_load_on_arc(piece: Piece, front: ArrayLike) -> Array:
    """Time of an arc's leg at which its load is `front`, shape of `front`."""
    begin, end = _whole_arc(piece)
    return piece.anchor.segment.time_of(
        NORMAL_LOAD, np.asarray(front, dtype=float) - piece.bottom, begin, end
    )


def force_up_to(curve: Curve, eta: ArrayLike) -> Array:
    """Tangential force M(eta) that a memory curve carries up to loads eta in [0, P], any shape
    [force per thickness].

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(
    ...     0.0, 1.0, (0.0, 0.0), (2.0, 1.0)
    ... )  # full stick: M runs along the path of loads
    >>> force_up_to(load_in_stick(None, segment, 0.0, instant(segment, 1.0)), [0.5, 2.0]).tolist()
    [0.25, 1.0]
    """
    loads = np.asarray(eta, dtype=float)
    forces = np.zeros(loads.shape)
    for piece in pieces(curve):
        is_on_piece = (loads <= piece.top) & (loads > piece.bottom)
        if np.any(is_on_piece):
            forces[is_on_piece] = force_on_piece(piece, loads[is_on_piece])
    return forces


def unload_to(curve: Curve, load: float) -> Curve:
    """The memory curve M(eta), the tangential force of the flat punches up to the load eta, without
    its part above `load`: what unloading along the curve itself leaves. None where nothing is left.

    A curve is its uppermost piece, from `bottom` to `top`, on the curve `below`. A piece with an
    arc follows a curved segment of the load path up to a time, and is cut where its load is `load`.

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (0.0, 0.0), (2.0, 1.0))
    >>> remaining = unload_to(load_in_stick(None, segment, 0.0, instant(segment, 1.0)), 0.5)
    >>> remaining.top, float(force_up_to(remaining, 0.5))
    (0.5, 0.25)
    """
    while curve is not None and curve.bottom >= load:
        curve = curve.below
    if curve is None or curve.top <= load:
        return curve
    if curve.arc is None:
        return curve._replace(top=load)
    arc_segment, _ = curve.arc
    return curve._replace(top=load, arc=(arc_segment, float(time_of_load_on_arc(curve, load))))


def load_in_stick(curve: Curve, segment: LoadSegment, begin: float, end: Instant) -> Piece:
    """The memory curve M(eta) after loading in full stick: the path of P and Q itself, from the
    time `begin` to `end` on a load segment `leg`, becomes its uppermost piece. M(eta) is the
    tangential force of the flat punches up to the load eta.

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (0.0, 0.0), (2.0, 1.0))
    >>> piece = load_in_stick(None, segment, 0.0, Instant(segment, 1.0, 2.0, 1.0))
    >>> piece.top, piece.slope, force_up_to(piece, [1.0]).tolist()
    (2.0, 0.5, [0.5])
    """
    slope_and_bend = segment.slope_and_bend(end.time)
    if slope_and_bend is None:
        return Piece(curve, end.normal, end, 0.0, 0.0, (begin, end.time))
    slope, bend = slope_and_bend  # else an arc, whose slope is that of the path
    return Piece(curve, end.normal, end, slope, bend)


def slip_to(curve: Curve, direction: int, friction: float, end: Instant, slipped: float) -> Curve:
    """The memory curve M(eta) after slip in one direction up to the instant `end`: its upper part
    becomes a line at the Coulomb limit, slope +-f.

    M(eta) is the tangential force of the flat punches up to the load eta. `slipped` is P - P_c, P_c
    the load at the stick edge, which lies in the uppermost piece of `curve`. The Masing rule: after
    a reversal at constant P the stick edge returns at half the speed, P - P_c = dQ/(2 f), and below
    it the curve is what it was.

    >>> from scenes import StraightSegment
    >>> forward = Piece(
    ...     None,
    ...     1.0,
    ...     Instant(StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.5)), 1.0, 1.0, 0.5),
    ...     0.5,
    ... )  # M = f eta
    >>> back = StraightSegment(1.0, 2.0, (1.0, 0.5), (1.0, 0.3))
    >>> slipped = float(slipped_load(forward, -1, 0.5, back, 2.0))
    >>> (
    ...     round(slipped, 12),
    ...     force_up_to(slip_to(forward, -1, 0.5, instant(back, 2.0), slipped), [0.4, 0.8, 1.0])
    ...     .round(12)
    ...     .tolist(),
    ... )
    (0.2, [0.2, 0.4, 0.3])
    """
    if curve is not None:
        curve = unload_to(curve, min(end.normal - slipped, curve.top))
    if end.normal <= (curve.top if curve is not None else 0.0):
        return curve
    return Piece(curve, end.normal, end, direction * friction)


def is_at_coulomb_limit(piece: Piece, direction: int, friction: float) -> bool:
    """Whether the piece is at the Coulomb limit dM/d eta = +-f, |q| = f p, in `direction` already:
    a front passes it at once.

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (0.0, 0.0), (2.0, 1.0))
    >>> piece = load_in_stick(None, segment, 0.0, instant(segment, 1.0))  # Q/P = 0.5
    >>> (
    ...     is_at_coulomb_limit(piece, 1, 0.5),
    ...     is_at_coulomb_limit(piece, -1, 0.5),
    ...     is_at_coulomb_limit(piece, 1, 0.6),
    ... )
    (True, False, False)
    """
    return piece.arc is None and piece.bend == 0 and piece.slope == direction * friction


def slip_combination_on_piece(
    piece: Piece, direction: int, friction: float, eta: ArrayLike
) -> Array:
    """Rise of the level s M(eta) - f eta from the piece's anchor to `eta`; at the lower end a front
    leaves the piece.
    """
    if piece.arc is not None:
        return piece.anchor.segment.change_of(
            slip_combination(direction, friction),
            time_of_load_on_arc(piece, eta),
            piece.anchor.time,
        )
    step = np.asarray(eta, dtype=float) - piece.anchor.normal
    return (direction * (piece.slope + piece.bend * step) - friction) * step


def slipped_load(
    piece: Piece, direction: int, friction: float, segment: LoadSegment, time: ArrayLike
) -> Array:
    """Load P - P_c of the slip zones at `time` on a load segment, while the stick edge is inside
    one piece of the memory curve M(eta), without cancellation [force per thickness].

    M(eta) is the tangential force of the flat punches up to the load eta. The stick edge is where s
    M(eta) - f eta equals the path's s Q - f P, s the direction of slip. On a line through the
    anchor `a` of the piece that gives P - P_c = s [(Q - Q_a) - slope (P - P_a)] / (f - s slope).

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.3))
    >>> pressed = Piece(None, 1.0, instant(segment, 0.0), 0.0)  # P = 1, Q = 0
    >>> round(float(slipped_load(pressed, 1, 0.5, segment, 1.0)), 12)  # Q/f
    0.6
    """
    if piece.arc is not None:
        return _slipped_on_arc(piece, direction, friction, segment, time)
    if piece.bend == 0:
        force_lag = combination_change(piece.anchor, segment, Combination(-piece.slope, 1.0), time)
        return direction * force_lag / (friction - direction * piece.slope)
    level_rise = combination_change(
        piece.anchor, segment, slip_combination(direction, friction), time
    )
    steepness = friction - direction * piece.slope
    signed_bend = direction * piece.bend
    distance_back = (
        2
        * level_rise
        / (steepness + np.sqrt(np.maximum(steepness**2 + 4 * signed_bend * level_rise, 0.0)))
    )
    return combination_change(piece.anchor, segment, NORMAL_LOAD, time) + distance_back


def _slipped_on_arc(
    piece: Piece, direction: int, friction: float, segment: LoadSegment, time: ArrayLike
) -> Array:
    """Load P - P_c of the slip zones at `time` on a load segment, while the stick edge is inside a
    curved piece of the memory curve, made by loading in full stick.

    The memory curve M(eta) is the tangential force of the flat punches up to the load eta. On the
    segment that made the piece the time at which the edge's load was reached is a mirror image;
    else it is searched for along the arc.
    """
    arc_begin, arc_end = _whole_arc(piece)
    slip_level = slip_combination(direction, friction)
    arc_segment = piece.anchor.segment
    if arc_segment is segment:
        mirrored_time = segment.mirrored(slip_level, time, (arc_begin + arc_end) / 2)
        if mirrored_time is not None:
            return segment.change_of(NORMAL_LOAD, time, mirrored_time)
    level_rise = combination_change(piece.anchor, segment, slip_level, time)
    # Back from the end of the arc, where the path may have turned: counted from its begin, rounding
    # would leave half the digits.
    time_at_stick_edge = arc_segment.time_of(slip_level, level_rise, arc_end, arc_begin)
    return combination_change(piece.anchor, segment, NORMAL_LOAD, time) - arc_segment.change_of(
        NORMAL_LOAD, time_at_stick_edge, arc_end
    )


def is_same_memory(
    curve: Curve, other_curve: Curve, friction: float, tolerance: float = 1e-12
) -> bool:
    """Whether two memory curves M(eta) are the same state of friction: within `tolerance` f P of
    each other.

    M(eta) is the tangential force of the flat punches up to the load eta. The curves are compared
    at their knots and at three loads between any two; f is `friction`.

    >>> is_same_memory(None, None, 0.5)
    True
    """
    if curve is None or other_curve is None:
        return curve is other_curve
    largest_load = max(curve.top, other_curve.top)
    if abs(curve.top - other_curve.top) > tolerance * largest_load:
        return False
    least_top = min(curve.top, other_curve.top)
    knot_loads = {0.0, least_top}
    for piece in (*pieces(curve), *pieces(other_curve)):
        knot_loads.add(min(piece.top, least_top))
    sorted_knots = np.array(sorted(knot_loads))
    points_between = [
        sorted_knots[:-1] + np.diff(sorted_knots) * share for share in (0.25, 0.5, 0.75, 1.0)
    ]
    loads = np.unique(np.concatenate(points_between))
    difference = np.abs(force_up_to(curve, loads) - force_up_to(other_curve, loads))
    return bool(np.all(difference <= tolerance * friction * least_top))


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The memory curves of many instants side by side.

    Each is `actives[which]` up to the load `load - slipped`, and from there a line of slope
    `direction` f.

    Attributes
    ----------
    time
        (n,) times, of the spans' legs where the path was followed by spans
    load, force
        (n,) P and Q
    slipped
        (n,) P - P_c
    direction
        (n,) +1, -1 or 0
    piece_number
        (n,) number of the uppermost piece among `actives`
    uppermost_pieces
        the different pieces (None: the front is at P_c = 0)
    friction
        f
    """

    time: Array
    load: Array
    force: Array
    slipped: Array
    direction: NDArray[np.int64]
    piece_number: NDArray[np.intp]
    uppermost_pieces: tuple[CurvePart | None, ...]
    friction: float

    @cached_property
    def groups(self) -> tuple[tuple[CurvePart, NDArray[np.intp]], ...]:
        """Pieces of memory curves that are the uppermost sticking one at some instants, each with
        the numbers of these instants.

        A memory curve M(eta) is the tangential force of the flat punches up to the load eta.
        Instants without one, where the contact slips throughout, are left out.
        """
        order_by_piece = np.argsort(self.piece_number, kind="stable")
        numbers, starts = np.unique(self.piece_number[order_by_piece], return_index=True)
        pieces_with_instants = []
        for piece_number, (start, end) in zip(
            numbers.tolist(), pairwise([*starts.tolist(), len(order_by_piece)]), strict=True
        ):
            piece = self.uppermost_pieces[piece_number]
            if piece is not None:
                pieces_with_instants.append((piece, order_by_piece[start:end]))
        return tuple(pieces_with_instants)
