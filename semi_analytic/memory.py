"""The frictional memory of a contact: the curve M(eta), an immutable value, and how the loads
change it (Masing rule).

# notation: eta normal load in [0, P]; M(eta) tangential force of the flat punches up to eta, M(0) =
#           0, M(P) = Q, |dM/d eta| <= f; s direction of slip, +1 or -1; P_c load at the stick edge

A contact at the load P is a superposition of flat punches, one for each load eta from 0 to P. The
curve is made of pieces one above the other in eta. A `Piece` holds the one below it, so that all
instants of a history share what they have in common. On a piece M is a parabola, mostly a straight
line, M = M_a + (slope + bend (eta - eta_a)) (eta - eta_a), about its anchor: the instant a of the
load path at which it was made. Or it is an arc: the path Q(P) of a curved load segment that was
passed in full stick.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple, Protocol, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import NORMAL_LOAD, TANGENTIAL_LOAD, Combination, LoadSegment
from scenes.array_types import Array

_EPS = float(np.finfo(float).eps)
# Changes of M(eta) over f P with which a cycle counts as repeated: the largest, that over the share
# of P that the slip zones carry, and the least, which is round-off.
_LARGEST_CHANGE = 1e-12
_CHANGE_OVER_SLIP_ZONE_SHARE = 1e-4
_LEAST_CHANGE = 2e-14
LAST_DIGITS = 4 * _EPS
"""Error of P_c over P, at most: measured 1 to 3 last digits on cycles of constant P with (P -
P_c)/P from 1e-4 to 1e-14. P_c is the load at the stick edge.
"""

PROMISED_ERROR = 1e-12
"""Relative error that closed forms promise; what rounding adds is stated where it is more."""


def repeat_tolerance(slip_zone_share: float) -> float:
    """Largest change of M(eta) over f P with which a cycle counts as repeated: 1e-4 of the share
    (P - P_c)/P that the slip zones carry, `slip_zone_share`, within 2e-14 and 1e-12.
    """
    change = max(_CHANGE_OVER_SLIP_ZONE_SHARE * slip_zone_share, _LEAST_CHANGE)
    return min(_LARGEST_CHANGE, change)


def slip_combination(direction: int, friction: float) -> Combination:
    """The combination s Q - f P of the loads, which grows while the surfaces slip in the
    `direction` s: +1 forward, -1 in reverse.
    """
    return Combination(-friction, float(direction))


class Instant(NamedTuple):
    """A point of the load path.

    Attributes
    ----------
    segment, time
        load segment, and time in it
    normal_load, tangential_load
        P and Q there [force per thickness]
    """

    segment: LoadSegment
    time: float
    normal_load: float
    tangential_load: float


def instant(segment: LoadSegment, time: float) -> Instant:
    """The point of the load path at a `time` of a load segment."""
    normal_load, tangential_load = segment.loads(time)
    return Instant(segment, float(time), float(normal_load), float(tangential_load))


def combination_change(
    earlier_instant: Instant, segment: LoadSegment, combination: Combination, time: ArrayLike
) -> Array:
    """Change of a weighted sum c_P P + c_Q Q of the loads between two instants of the load path
    [force per thickness]. They may lie on two segments of it.

    `change_of` gives such a change between two times of one segment, without cancellation.

    Parameters
    ----------
    earlier_instant
        first instant: its segment, P as `normal_load` and Q as `tangential_load`
    segment, time
        segment of the second instant, and times on it, any shape
    combination
        the factors c_P as `normal` and c_Q as `tangential`
    """
    if earlier_instant.segment is segment:
        return segment.change_of(combination, time, earlier_instant.time)
    # P and Q at the start of the later segment
    begin_instant = instant(segment, segment.start)
    change_before_segment = combination.normal * (
        begin_instant.normal_load - earlier_instant.normal_load
    )
    change_before_segment += combination.tangential * (
        begin_instant.tangential_load - earlier_instant.tangential_load
    )
    return segment.change_of(combination, time, segment.start) + change_before_segment


class CurvePart(Protocol):
    """A piece of a memory curve M(eta) as fields use it: a `Piece`, or a straight `Line` of a load
    series. All pieces below come with it.
    """

    @property
    def curve_below(self) -> Self | None:
        """The curve under this piece, None if the piece starts at eta = 0."""

    @property
    def top_load(self) -> float:
        """Load eta at the upper end."""

    @property
    def bottom_load(self) -> float:
        """Load eta at the lower end."""

    @property
    def straight_slope(self) -> float:
        """dM/d eta of a line; of a parabola, extended to eta = 0; 0 for an arc."""

    @property
    def bend(self) -> float:
        """Half of d2M/d eta2 [thickness per force]."""

    @property
    def arc_times(self) -> tuple[float, float] | None:
        """Times at the lower and the upper end of an arc, else None."""

    def slope_at(self, eta: Array) -> Array:
        """dM/d eta at loads (n,): (n,)."""


class Piece(NamedTuple):
    """The uppermost piece of a memory curve M(eta). Each piece holds the one below it as
    `curve_below`, so that it stands for the whole curve.

    Attributes
    ----------
    curve_below
        the curve under this piece, None if this piece starts at eta = 0
    top_load
        eta at the upper end
    anchor
        the instant of the load path at which the piece was made; M and eta are measured from there
    slope, bend
        dM/d eta at the anchor, and half of d2M/d eta2; not used for an arc
    arc_times
        (first, last) times on the anchor's load segment at the lower and the upper end of an arc,
        else None
    """

    curve_below: Piece | None
    top_load: float
    anchor: Instant
    slope: float
    bend: float = 0.0
    arc_times: tuple[float, float] | None = None

    @property
    def bottom_load(self) -> float:
        """Load eta at the lower end."""
        return self.curve_below.top_load if self.curve_below is not None else 0.0

    @property
    def straight_slope(self) -> float:
        """dM/d eta of a line; of a parabola, extended to eta = 0; 0 for an arc."""
        return (
            self.slope - 2 * self.bend * self.anchor.normal_load if self.arc_times is None else 0.0
        )

    def slope_at(self, eta: Array) -> Array:
        """Slope dM/d eta of this piece of the memory curve at loads eta (n,): (n,).

        M(eta) is the tangential force of the flat punches up to the load eta. `slope` is the slope
        at the `anchor`, the instant (P as `normal_load`) from which the piece is measured; `bend`
        is half of d2M/d eta2. A piece with `arc_times` is an arc, a part of the load path itself:
        its slope is dQ/dP there, taken as 0 where both loads turn at once.
        """
        if self.arc_times is None:
            return self.slope + 2 * self.bend * (eta - self.anchor.normal_load)
        # dP/dt and dQ/dt of the path at which it had P = eta
        normal_rate, tangential_rate = self.anchor.segment.rates(time_of_load_on_arc(self, eta))
        return np.divide(
            tangential_rate, normal_rate, out=np.zeros(eta.shape), where=normal_rate != 0
        )


Curve: TypeAlias = Piece | None
"""A memory curve: its uppermost piece, which holds those below; None for bodies out of contact."""


_Part = TypeVar("_Part", bound=CurvePart)


def pieces(curve: _Part | None) -> Iterator[_Part]:
    """The pieces of a memory curve, from the largest load eta downwards."""
    while curve is not None:
        yield curve
        curve = curve.curve_below


def force_on_piece(piece: Piece, eta: ArrayLike) -> Array:
    """Tangential force M(eta) of the flat punches up to loads eta on one piece of the memory curve,
    any shape [force per thickness].

    The piece is a line or parabola about its anchor, the instant of the load path at which it was
    made. `slope` is dM/d eta there, `bend` half of d2M/d eta2. Or it is an arc, the path Q(P) of a
    load segment.
    """
    load_from_anchor = np.asarray(eta, dtype=float) - piece.anchor.normal_load
    if piece.arc_times is None:
        return (
            piece.anchor.tangential_load
            + (piece.slope + piece.bend * load_from_anchor) * load_from_anchor
        )
    return piece.anchor.tangential_load + piece.anchor.segment.change_of(
        TANGENTIAL_LOAD, time_of_load_on_arc(piece, eta), piece.anchor.time
    )


def _times_of_arc(piece: Piece) -> tuple[float, float]:
    """Times at both ends of a piece's arc as it was made, before unloading shortened it: start and
    end on the load segment of its anchor.
    """
    assert piece.arc_times is not None  # for the type checker: only called for arcs
    return piece.arc_times[0], piece.anchor.time


def time_of_load_on_arc(piece: Piece, load: ArrayLike) -> Array:
    """Time on the load segment of an arc, a curved piece of the memory curve, at which P was
    `load`; shape of `load`.
    """
    begin, end = _times_of_arc(piece)
    return piece.anchor.segment.time_of(
        NORMAL_LOAD, np.asarray(load, dtype=float) - piece.bottom_load, begin, end
    )


def force_up_to(curve: Curve, eta: ArrayLike) -> Array:
    """Tangential force M(eta) that the flat punches up to the load eta carry by a memory curve, at
    loads eta in [0, P], any shape [force per thickness].

    `pieces` yields the pieces of the curve, each from its `bottom_load` to its `top_load` in eta,
    without the bottom itself; `force_on_piece` gives M on one of them.

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(
    ...     0.0, 1.0, (0.0, 0.0), (2.0, 1.0)
    ... )  # in full stick M(eta) is Q at P = eta
    >>> force_up_to(load_in_stick(None, segment, 0.0, instant(segment, 1.0)), [0.5, 2.0]).tolist()
    [0.25, 1.0]
    """
    loads = np.asarray(eta, dtype=float)
    forces = np.zeros(loads.shape)
    for piece in pieces(curve):
        is_on_piece = (loads <= piece.top_load) & (loads > piece.bottom_load)
        if np.any(is_on_piece):
            forces[is_on_piece] = force_on_piece(piece, loads[is_on_piece])
    return forces


def unload_to(curve: Curve, load: float) -> Curve:
    """The memory curve M(eta) after unloading to P = `load` without slip: what lies up to that
    load; None where nothing is left, the curve itself where it ends below the load.

    M(eta) is the tangential force of the flat punches up to the load eta. A curve is given by its
    uppermost piece, which goes from the load `bottom_load` to `top_load`; `curve_below` is the
    rest. An arc, a curved part of the load path, also stores the times of its ends on the path;
    `time_of_load_on_arc` gives the time at which P was a load of it.

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (0.0, 0.0), (2.0, 1.0))
    >>> remaining_curve = unload_to(load_in_stick(None, segment, 0.0, instant(segment, 1.0)), 0.5)
    >>> remaining_curve.top_load, float(force_up_to(remaining_curve, 0.5))
    (0.5, 0.25)
    """
    while curve is not None and curve.bottom_load >= load:
        curve = curve.curve_below
    if curve is None or curve.top_load <= load:
        return curve
    if curve.arc_times is None:
        return curve._replace(top_load=load)
    arc_begin_time, _ = curve.arc_times
    return curve._replace(
        top_load=load, arc_times=(arc_begin_time, float(time_of_load_on_arc(curve, load)))
    )


def load_in_stick(
    curve: Curve, segment: LoadSegment, begin_time: float, end_instant: Instant
) -> Piece:
    """The memory curve after loading in full stick: the path of P and Q becomes its uppermost
    piece, M = Q at eta = P.

    M(eta) is the tangential force of the flat punches up to the load eta. The path goes from the
    time `begin_time` of a load segment to the instant `end_instant`. `curve` is the memory before,
    None if out of contact. A piece holds the curve below, its top load and the instant from which
    it is measured.

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (0.0, 0.0), (2.0, 1.0))
    >>> piece = load_in_stick(None, segment, 0.0, Instant(segment, 1.0, 2.0, 1.0))
    >>> piece.top_load, piece.slope, force_up_to(piece, [1.0]).tolist()
    (2.0, 0.5, [0.5])
    """
    # dQ/dP and half of d2Q/dP2 of the path; None where Q(P) is no straight line or parabola
    slope_and_bend = segment.slope_and_bend(end_instant.time)
    if slope_and_bend is None:
        return Piece(
            curve,
            end_instant.normal_load,
            end_instant,
            slope=0.0,
            arc_times=(begin_time, end_instant.time),
        )
    slope, bend = slope_and_bend
    return Piece(curve, end_instant.normal_load, end_instant, slope, bend)


def slip_to(
    curve: Curve, direction: int, friction: float, end_instant: Instant, slip_zone_load: float
) -> Curve:
    """The memory curve M(eta) after slip in one direction up to the instant `end_instant`: from the
    load P_c at the stick edge up to P it is a line at the Coulomb limit, slope +-f.

    M(eta) is the tangential force of the flat punches up to the load eta; below P_c it does not
    change. f is `friction`, `direction` +1 or -1; `end_instant` holds P and Q as `normal_load` and
    `tangential_load`. `slip_zone_load` is P - P_c [force per thickness]; where it is 0 no line is
    added. Masing rule: after a reversal of Q at constant P, P - P_c = dQ/(2 f), half as much as in
    first loading by the same dQ.

    >>> from scenes import StraightSegment
    >>> forward_piece = Piece(
    ...     None,
    ...     1.0,
    ...     Instant(StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.5)), 1.0, 1.0, 0.5),
    ...     0.5,
    ... )  # M = f eta
    >>> reverse_segment = StraightSegment(1.0, 2.0, (1.0, 0.5), (1.0, 0.3))
    >>> slip_zone_load = float(load_of_slip_zone(forward_piece, -1, 0.5, reverse_segment, 2.0))
    >>> reversed_curve = slip_to(
    ...     forward_piece, -1, 0.5, instant(reverse_segment, 2.0), slip_zone_load
    ... )
    >>> forces = force_up_to(reversed_curve, [0.4, 0.8, 1.0])
    >>> round(slip_zone_load, 12), forces.round(12).tolist()
    (0.2, [0.2, 0.4, 0.3])
    """
    # keep the curve up to P_c
    if curve is not None:
        # its part up to P_c, None if nothing sticks
        curve = unload_to(curve, min(end_instant.normal_load - slip_zone_load, curve.top_load))
    # no slip zone: nothing to add
    if end_instant.normal_load <= (curve.top_load if curve is not None else 0.0):
        return curve
    # curve below, top load, the instant through which the line goes, and slope
    return Piece(curve, end_instant.normal_load, end_instant, direction * friction)


def is_at_coulomb_limit(piece: Piece, direction: int, friction: float) -> bool:
    """Whether a piece of the memory curve is at the Coulomb limit in the `direction` s of slip: its
    `slope` dM/d eta is s f, so that the shear there is s f times the pressure.

    f is `friction`, M(eta) the tangential force of the flat punches up to the load eta. In slip in
    this direction the stick edge passes the piece at once. Only a straight piece can be at the
    limit: `bend` (half of d2M/d eta2) is 0, and it is no arc, a curved part of the load path
    (`arc_times` is None).

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
    return piece.arc_times is None and piece.bend == 0 and piece.slope == direction * friction


def slip_combination_on_piece(
    piece: Piece, direction: int, friction: float, eta: ArrayLike
) -> Array:
    """Change of s M(eta) - f eta on a piece of the memory curve, from its anchor to loads eta, any
    shape [force per thickness].

    s is the `direction` of slip, f `friction`, M(eta) the tangential force of the flat punches up
    to the load eta.

    `anchor` is the instant of the load path at which the piece was made. There dM/d eta is `slope`,
    `bend` half of d2M/d eta2. An arc, with `arc_times`, is a curved part of the load path, passed
    in full stick; there M and eta are Q and P of the path, and `change_of` gives the change of s Q
    - f P. The stick edge is at eta when the path's s Q - f P has changed as much since the anchor.
    """
    if piece.arc_times is not None:
        return piece.anchor.segment.change_of(
            slip_combination(direction, friction),
            time_of_load_on_arc(piece, eta),
            piece.anchor.time,
        )
    load_from_anchor = np.asarray(eta, dtype=float) - piece.anchor.normal_load
    return (direction * (piece.slope + piece.bend * load_from_anchor) - friction) * load_from_anchor


def load_of_slip_zone(
    piece: Piece, direction: int, friction: float, segment: LoadSegment, time: ArrayLike
) -> Array:
    """Load P - P_c of the slip zones, while the stick edge is inside one piece of the memory curve
    M(eta), at `time` (any shape) on a load segment [force per thickness].

    M(eta) is the tangential force of the flat punches up to the load eta, P_c the load at the stick
    edge. There s M(P_c) - f P_c = s Q - f P, s the `direction` of slip, f `friction`.
    `combination_change` gives the change of a weighted sum of P and Q since an instant,
    `slip_combination` that of s Q - f P. With the changes dP, dQ since the piece's anchor, P - P_c
    is computed without subtracting P_c from P. The anchor is the instant at which the piece was
    made; slope is dM/d eta there, bend half of d2M/d eta2, y the load from P_c to the anchor's P:

        line      P - P_c = s (dQ - slope dP)/(f - s slope)
        parabola  P - P_c = dP + y,    (f - s slope) y + s bend y^2 = s dQ - f dP

    >>> from scenes import StraightSegment
    >>> segment = StraightSegment(0.0, 1.0, (1.0, 0.0), (1.0, 0.3))
    >>> pressed_piece = Piece(None, 1.0, instant(segment, 0.0), 0.0)  # P = 1, Q = 0
    >>> round(float(load_of_slip_zone(pressed_piece, 1, 0.5, segment, 1.0)), 12)  # Q/f
    0.6
    """
    # an arc: a curved part of the load path, passed in full stick
    if piece.arc_times is not None:
        return _load_of_slip_zone_on_arc(piece, direction, friction, segment, time)
    # f - s slope: how far the slope is from the Coulomb limit
    coulomb_margin = friction - direction * piece.slope
    if piece.bend == 0:
        # dQ - slope dP since the anchor
        force_beyond_line = combination_change(
            piece.anchor, segment, Combination(-piece.slope, 1.0), time
        )
        return direction * force_beyond_line / coulomb_margin
    # s dQ - f dP since the anchor
    slip_combination_change = combination_change(
        piece.anchor, segment, slip_combination(direction, friction), time
    )
    signed_bend = direction * piece.bend
    discriminant = coulomb_margin**2 + 4 * signed_bend * slip_combination_change
    root_of_discriminant = np.sqrt(np.maximum(discriminant, 0.0))
    load_from_edge_to_anchor = 2 * slip_combination_change / (coulomb_margin + root_of_discriminant)
    return combination_change(piece.anchor, segment, NORMAL_LOAD, time) + load_from_edge_to_anchor


def _load_of_slip_zone_on_arc(
    arc: Piece, direction: int, friction: float, segment: LoadSegment, time: ArrayLike
) -> Array:
    """Load P - P_c of the slip zones, while the stick edge is inside an arc of the memory curve, at
    `time` (any shape) on a load segment [force per thickness].

    The memory curve is the tangential force of the flat punches up to each load. An arc of it is a
    path of P and Q that was passed in full stick. P_c is the load P of the arc at the time at which
    s Q - f P was what it is now. s is the `direction` of slip, f `friction`. If P and Q are a
    single wave on one segment, that time is the mirror image of `time` about the extreme of s Q - f
    P. Else it is found by iteration along the arc. A segment's `change_of` is the change of a
    weighted sum of P and Q between two times, `time_of` its inverse.
    """
    # times on the load segment of the piece's `anchor`, the instant at the end of the arc
    arc_begin_time, arc_end_time = _times_of_arc(arc)
    s_q_minus_f_p = slip_combination(direction, friction)
    arc_segment = arc.anchor.segment
    if arc_segment is segment:
        # None where P and Q are no single wave
        mirrored_time = segment.mirrored_time(
            s_q_minus_f_p, time, (arc_begin_time + arc_end_time) / 2
        )
        if mirrored_time is not None:
            return segment.change_of(NORMAL_LOAD, time, mirrored_time)
    slip_combination_change = combination_change(arc.anchor, segment, s_q_minus_f_p, time)
    # Back from the end of the arc, where the path may have turned: counted from its start,
    # round-off would leave half the digits.
    time_at_stick_edge = arc_segment.time_of(
        s_q_minus_f_p, slip_combination_change, arc_end_time, arc_begin_time
    )
    # P now minus P at the anchor
    load_change_since_anchor = combination_change(arc.anchor, segment, NORMAL_LOAD, time)
    # minus the change of P from the anchor to P_c
    return load_change_since_anchor - arc_segment.change_of(
        NORMAL_LOAD, time_at_stick_edge, arc_end_time
    )


def is_same_memory(
    curve: Curve, other_curve: Curve, friction: float, tolerance: float = 1e-12
) -> bool:
    """Whether two memory curves M(eta) agree, M within `tolerance` times f P and their largest load
    within `tolerance` times P: then loads that follow have the same tractions and slip after both.

    M(eta) is the tangential force of the flat punches up to the load eta; f is `friction`. `pieces`
    yields the pieces of a curve, `force_up_to` gives M at loads eta. The curves are compared at the
    ends of their pieces and at three loads in between. None, out of contact, agrees with None only.

    >>> is_same_memory(None, None, 0.5)
    True
    """
    if curve is None or other_curve is None:
        return curve is other_curve
    # the largest eta of a curve is P at its instant
    largest_load = max(curve.top_load, other_curve.top_load)
    if abs(curve.top_load - other_curve.top_load) > tolerance * largest_load:
        return False
    smaller_top_load = min(curve.top_load, other_curve.top_load)
    piece_end_loads = {0.0, smaller_top_load}
    for piece in (*pieces(curve), *pieces(other_curve)):
        piece_end_loads.add(min(piece.top_load, smaller_top_load))
    sorted_end_loads = np.array(sorted(piece_end_loads))
    compared_loads = [
        sorted_end_loads[:-1] + np.diff(sorted_end_loads) * fraction
        for fraction in (0.25, 0.5, 0.75, 1.0)
    ]
    eta = np.unique(np.concatenate(compared_loads))
    force_difference = np.abs(force_up_to(curve, eta) - force_up_to(other_curve, eta))
    return bool(np.all(force_difference <= tolerance * friction * smaller_top_load))


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The memory curves M(eta) of n instants, side by side.

    The curve of an instant goes up to P_c, the load at the stick edge, on its sticking piece and
    those below. From P_c to P it is a line of slope `direction` f, where the contact slips.

    Attributes
    ----------
    time
        (n,) times, on the load segments of the spans where the path was followed by spans
    load, force
        (n,) P and Q [force per thickness]
    slip_zone_load
        (n,) P - P_c [force per thickness]
    direction
        (n,) of slip: +1 forward, -1 in reverse, 0 none
    piece_number
        (n,) index into `sticking_pieces`
    sticking_pieces
        the different pieces in which stick edges are; None for P_c = 0, slip throughout
    friction
        coefficient f
    """

    time: Array
    load: Array
    force: Array
    slip_zone_load: Array
    direction: NDArray[np.int64]
    piece_number: NDArray[np.intp]
    sticking_pieces: tuple[CurvePart | None, ...]
    friction: float

    @cached_property
    def pieces_with_instants(self) -> tuple[tuple[CurvePart, NDArray[np.intp]], ...]:
        """Each piece of the memory curve M(eta) that holds a stick edge at some instants, with the
        indices of these instants, ascending.

        M(eta) is the tangential force of the flat punches up to the load eta. Instants at which the
        whole contact slips are left out. `piece_number` (n,) is the index of each instant's
        piece in `sticking_pieces`, which has None for slip of the whole contact.
        """
        order_by_piece = np.argsort(self.piece_number, kind="stable")
        piece_numbers, first_position_of_piece = np.unique(
            self.piece_number[order_by_piece], return_index=True
        )
        pieces_and_instants = []
        for piece_number, (start_position, end_position) in zip(
            piece_numbers.tolist(),
            pairwise([*first_position_of_piece.tolist(), len(order_by_piece)]),
            strict=True,
        ):
            piece = self.sticking_pieces[piece_number]
            if piece is not None:
                pieces_and_instants.append((piece, order_by_piece[start_position:end_position]))
        return tuple(pieces_and_instants)
