"""Contact and stick edges of many instants at once, from nodal answers; states as a reader sees
them.

Arrays are (k, n): k instants, n nodes at ascending x. Edges and their uncertainties are (k, 2),
left and right.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.arrays import Array, Indices, Mask, States
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.law import slip_sign
from scenes import STICK

# Share of the distance of two nodes by which an edge between them is uncertain whatever the fit
# says: the shape functions of quadratic elements know no square root. Measured on hertz-paper,
# cattaneo-mindlin and flat-rounded-paper: 0.26 at most.
_SHARE = 0.3
# The same of a fitted stick edge, whose straight line is a chord: on elements of a/60 that costs
# flat-rounded-paper so much.
_FITTED_SHARE = 0.5
# Nodes that the second estimate of the contact edge takes, counted from the last closed one.
_EXTRAPOLATED = 5
# Outermost closed nodes whose pressure is the mesh's own, and nodes behind them that the square of
# the pressure is fitted to: at most, at least. Root mean square of the relative residual above
# which a corner of the profile is among them.
_RIM, _SQUARES, _FEWEST, _ROUGH = 3, 12, 6, 0.005
# Elements by which that zero may differ from the edge by its form, which errs by an eighth of one.
_NEAR = 0.2
# Nodes of a slip zone below which it may be none at all.
_UNRESOLVED = 4
# Nodes that the slip zone may be wide where the whole contact is seen to stick: an element, of
# quadratic ones.
_UNSEEN = 2.0
# Nodes inside the stick zone that the two fits take, counted from its last one, which the
# singularity spoils.
_FITTED = (7, 4)
# Elements by which two fits of a stick edge may differ.
_AGREE = 0.1

# A sliding node that has come less far, since it last stuck or turned round, than this share of the
# farthest one of its sense counts as sticking: at the turning points of the load whole regions come
# back to the cone at once, and creep there by the mesh's error. Slip grows as the distance from the
# stick edge to the power 3/2, so the share costs half a hundredth of the slip zone.
_MOVED = 3e-4
# The same of a node that the load does not drive, and that slips less than this share of the
# largest slip per change of load in the revolution. What the mesh makes is 1e-5 to 4e-4 of that,
# without the cure of N - T up to 9e-3.
_CREEP = 1e-2
# Increments that are looked at together.
_AT_ONCE = 512
# Slip of an increment, over the largest of all, below which it is rounding.
_ROUNDING = 1e-9


def reported_states(
    problem: ContactProblem, states: Sequence[InterfaceState], cycle_starts: Sequence[int]
) -> States:
    """(n_steps, n) states as the user sees them: of coupled bodies those of the law, of others what
    `visible_states` shows.

    The creep of the mesh can be told from slip only where half-plane theory of like bodies holds.
    Between unlike bodies, or bodies of two shapes, pressing alone makes nodes slip, and slowly so
    near the edge of stick.

    Parameters
    ----------
    problem : whose interface is coupled, or not
    states, cycle_starts : as of `visible_states`
    """
    if problem.interface.coupling is not None:
        return law_states(states)
    return visible_states(states, cycle_starts, problem.friction, problem.interface.imposed)


def law_states(states: Sequence[InterfaceState]) -> States:
    """(n_steps, n) states by the law, but for rounding: a node on the Coulomb limit that has not
    moved sticks.

    Parameters
    ----------
    states : of the whole path; nothing has moved at the first of them
    """
    reported = np.stack([state.state for state in states])
    starts = range(0, len(states) - 1, _AT_ONCE)

    def slip_of_increments(start: int) -> Array:
        """(k, n) of the next `_AT_ONCE` increments at most: slip of all of a long record would take
        gigabytes.
        """
        return np.diff([state.slip for state in states[start : start + _AT_ONCE + 1]], axis=0)

    largest = max((float(np.abs(slip_of_increments(start)).max()) for start in starts), default=0.0)
    moved = np.zeros(reported.shape, dtype=bool)
    for start in starts:
        slip = slip_of_increments(start)
        after = slice(start + 1, start + 1 + len(slip))
        moved[after] = slip_sign(reported[after]) * slip > _ROUNDING * largest
    reported[(slip_sign(reported) != 0) & ~moved] = STICK
    return reported


def visible_states(
    states: Sequence[InterfaceState],
    cycle_starts: Sequence[int],
    friction: float,
    imposed: Array | None = None,
) -> States:
    """(n_steps, n) states as the user sees them: the law's, but a node that only creeps by the
    error of the mesh sticks.

    The load drives forward slip where dQ > f dP and reverse slip where -dQ > f dP: like half-planes
    slip there alone, each node of the slip zone, however slowly. At a distance from the middle of
    the stick zone bulk strain and tilt add their part to dQ and dP: in full stick both tractions
    are [d(P, Q)/pi - d(tilt, strain) (x - m)/A] over one and the same root, A = 2 in scaled
    variables. What the load does not drive has to be fast to count as slip.

    Parameters
    ----------
    states : of the whole path
    cycle_starts : index of the state at which each revolution starts; what comes before them is the
    initial loading friction : coefficient f
    imposed : (2, n, 3) gap and slip by a unit of the bulk stresses and of the tilt; None without
        any
    """
    seen, rise, senses, slips = (
        np.stack([state.state for state in states]),
        np.diff([state.loads for state in states], axis=0),
        [],
        [],
    )
    size, change = len(states[0].state), np.maximum(np.abs(rise).sum(axis=1), 1e-300)
    # Some hundred instants at a time: arrays of all of a long record would take gigabytes.
    blocks = [
        slice(first, min(first + _AT_ONCE, len(rise))) for first in range(0, len(rise), _AT_ONCE)
    ]

    def moved(steps: slice) -> tuple[Indices, Array]:
        """Sense of slip by the law, and slip of the increments, (k, n) each."""
        values = np.stack(
            [state.values[3 : 3 + size] for state in states[steps.start : steps.stop + 1]]
        )
        return slip_sign(seen[steps.start + 1 : steps.stop + 1]), np.diff(values, axis=0)

    for steps in blocks:
        sign, slip = moved(steps)
        # slip of the nodes that slide, and of all, in each increment
        senses.append(np.abs(slip * sign).max(axis=1))
        slips.append(float(np.abs(slip).max()))
    revolution = np.searchsorted(
        np.asarray(cycle_starts, dtype=int), np.arange(len(rise)), side="right"
    )
    speed = np.concatenate([*senses, [0.0]])[: len(rise)] / change
    fastest = np.array(
        [speed[revolution == number].max(initial=0.0) for number in range(len(cycle_starts) + 1)]
    )
    run, rounding = np.zeros(size), _ROUNDING * max(slips, default=0.0)
    for steps in blocks:
        sign, slip = moved(steps)
        slip[np.abs(slip) <= rounding] = 0.0
        runs = slip.copy()
        for step in range(len(runs)):  # slip in one direction without a stop, open or closed
            runs[step] += np.where(run * runs[step] > 0, run, 0.0)
            run = runs[step]
        normal, along = rise[steps, 0, None], rise[steps, 1, None]
        if imposed is not None:
            offsets = np.diff(
                [state.imposed for state in states[steps.start : steps.stop + 1]], axis=0
            )
            sticks = seen[steps.start + 1 : steps.stop + 1] == STICK
            ends = np.stack([np.argmax(sticks, axis=1), _last(sticks)], axis=1)
            gap, shift = (offsets @ part.T for part in imposed)
            gap, shift = (
                part - np.take_along_axis(part, ends, axis=1).mean(axis=1, keepdims=True)
                for part in (gap, shift)
            )
            held = sticks.any(axis=1, keepdims=True)
            normal, along = normal - np.pi / 2 * gap * held, along + np.pi / 2 * shift * held
        driven = sign * along > friction * normal
        slides = driven | (
            np.abs(slip) > (_CREEP * fastest[revolution[steps]] * change[steps])[:, None]
        )
        view = seen[steps.start + 1 : steps.stop + 1]
        for sense in (1, -1):
            moved_on = np.where(sign == sense, sense * runs, 0.0)
            view[
                (sign == sense)
                & ~(slides & (moved_on > _MOVED * moved_on.max(axis=1, keepdims=True)))
            ] = STICK
    view = seen[:1]
    view[slip_sign(view) != 0] = STICK  # of the first nothing has moved
    return seen


def contact_edges(x: Array, pressure: Array, gap: Array, closed: Mask, modulus: float) -> Array:
    r"""Ends of the contact, from the form that every smooth edge has; NaN without contact.

    With d the distance from the edge and one unknown factor beta, p = (E*/2) beta sqrt(d) inside, g
    = (2/3) beta d^(3/2) outside; the last closed and the first open node give beta and the edge.
    With t the share of the open node in their distance s that is t^3 + c t = c, c = (3 E* g/(4 p
    s))^2. The outermost node itself where no open node follows.

    Parameters
    ----------
    x : (n,) nodes in ascending order [length]
    pressure, gap, closed : (k, n); pressure of the closed nodes [stress], gap of the open ones
    [length], both >= 0 modulus : E* [stress]
    """
    edges = np.empty((len(closed), 2))
    for side, sign, x_out, (p, g, inside) in _sides(x, pressure, gap, closed):
        last = _last(inside)
        following = np.minimum(last + 1, len(x) - 1)
        span, at_last, beyond = x_out[following] - x_out[last], _pick(p, last), _pick(g, following)
        plain = (span > 0) & (at_last > 0) & (beyond > 0)
        c = (3 * modulus * beyond[plain] / (4 * at_last[plain] * span[plain])) ** 2
        share = np.where(at_last > 0, 0.0, 1.0)
        share[plain] = 2 * np.sqrt(c / 3) * np.sinh(np.arcsinh(1.5 * np.sqrt(3 / c)) / 3)
        edges[:, side] = sign * (x_out[last] + span * (1 - share))
    edges[~closed.any(axis=1)] = np.nan
    return edges


def fitted_contact_edges(x: Array, pressure: Array, closed: Mask, edges: Array) -> Array:
    """Ends of the contact where the square of the pressure goes to zero, or `edges` where it has no
    smooth form.

    Towards a smooth edge p^2 is a power series in the distance. A parabola through the nodes behind
    the outermost three, which are the mesh's own, has its zero there: hertz-paper's edges err by
    1e-4 of a in the median, those of `contact_edges` by 3e-4. With a corner of the profile among
    those nodes half and a quarter of them are taken; a zero far from `edges` is none.

    Parameters
    ----------
    x, pressure, closed : as of `contact_edges`
    edges : (k, 2) by `contact_edges`
    """
    found, n_half = edges.copy(), np.count_nonzero(closed, axis=1) // 2 - _RIM
    for side, sign, x_out, (p, inside) in _sides(x, pressure, closed):
        last, form = _last(inside), sign * edges[:, side]
        element = 2 * _spacing(x_out, last)
        left = np.ones(len(closed), dtype=bool)
        for share in (1, 2, 4):
            count = np.minimum(_SQUARES, n_half) // share
            row = np.flatnonzero(left & (count >= _FEWEST))
            nodes = last[row, None] - _RIM - np.arange(_SQUARES)
            counts = np.arange(_SQUARES) < count[row, None]
            nodes = np.where(counts, nodes, last[row, None])
            square = np.take_along_axis(p[row], nodes, axis=1) ** 2
            first = x_out[last[row] - _RIM]
            away = (first[:, None] - x_out[nodes]) / element[row, None]
            weight = np.where(counts & (square > 0), 1 / np.where(square > 0, square, 1.0), 0.0)
            matrix = np.stack([weight, weight * away, weight * away**2], axis=2)
            c, b, a = (np.linalg.pinv(matrix) @ (weight * square)[:, :, None])[:, :, 0].T
            rough = np.sqrt(
                np.mean(
                    (
                        ((c[:, None] + b[:, None] * away + a[:, None] * away**2) * weight - 1)
                        * counts
                    )
                    ** 2,
                    axis=1,
                )
            )
            under = b**2 - 4 * a * c
            zero = (
                first
                + 2
                * c
                / np.where((under > 0) & (b > 0), b + np.sqrt(np.maximum(under, 0.0)), np.nan)
                * element[row]
            )
            good = (rough < _ROUGH) & (np.abs(zero - form[row]) <= _NEAR * element[row])
            found[row[good], side], left[row[good]] = sign * zero[good], False
    return found


def contact_uncertainty(
    x: Array, pressure: Array, closed: Mask, contact: Array, form: Array | None = None
) -> Array:
    """How far each contact edge may be from the true one, by the mesh.

    A share of the distance of the nodes around it, and how far the edge is from another estimate:
    the zero of a straight line through the squares of the pressure at the five nodes before the
    last. With fewer nodes than that, the whole contact. Of a fitted edge the other estimate is that
    of `contact_edges`.

    Parameters
    ----------
    x, pressure, closed : as of `contact_edges`
    contact : (k, 2) ends of the contact
    form : the same by `contact_edges`, where they are fitted
    """
    form = contact if form is None else form
    found = np.repeat(contact[:, 1:] - contact[:, :1], 2, axis=1)
    many = np.flatnonzero(np.count_nonzero(closed, axis=1) > _EXTRAPOLATED)
    for side, sign, x_out, (p, inside) in _sides(x, pressure[many], closed[many]):
        last = _last(inside)
        edge, farthest = sign * contact[many, side], x_out[last - _EXTRAPOLATED]
        zero = _zero_of_squares(x_out, p, last, _EXTRAPOLATED)
        other = np.where(np.isnan(zero), farthest, zero)
        apart = np.where(
            edge == sign * form[many, side],
            np.minimum(np.abs(other - edge), np.abs(farthest - edge)),
            0.0,
        )
        found[many, side] = (
            _SHARE * _spacing(x_out, last) + apart + np.abs(edge - sign * form[many, side])
        )
    return found


def stick_edges(
    x: Array,
    stick: Mask,
    closed: Mask,
    contact: Array,
    limit: Array | None = None,
    shear: Array | None = None,
    anywhere: bool = False,
) -> Array:
    """Ends of the stick zone; the contact edges where the whole contact sticks, NaN where nothing
    does.

    By node status the edge lies half-way between the last node of the stick zone and the first one
    of the slip zone: on each side of the middle of the contact where the fewest nodes are on the
    wrong side of it (a node that has just come to touch sticks at the rim of the slip zone, and a
    single one may slide at the rim of a contact that sticks). Where `limit` (f p) and `shear` are
    given, the edge is fitted where it can be: towards it the shear inside falls off the limit as
    the square root of the distance.

    Parameters
    ----------
    x, closed, contact : as of `contact_uncertainty`
    stick : (k, n) nodes that stick
    limit, shear : (k, n) f p and q [stress]
    anywhere : whether the stick zone need not hold the middle of the contact (bulk stress, tilt):
        then its own middle is the middle
    """
    edges, nothing = np.empty((len(closed), 2)), np.zeros(len(closed), dtype=bool)
    tractions = () if limit is None or shear is None else (limit, shear)
    for side, sign, x_out, (sticks, inside, *limit_and_shear) in _sides(
        x, stick, closed, *tractions
    ):
        half, end = (
            _half(x_out, inside, sign, sticks if anywhere else None),
            sign * contact[:, side],
        )
        last, n_stick, n_half = _last_sticking(sticks, half)
        nothing |= (n_stick == 0) & (n_half > 0)
        found = (x_out[last] + x_out[np.minimum(last + 1, len(x) - 1)]) / 2
        row = np.flatnonzero((n_stick > _FITTED[0]) & (n_stick < n_half))
        if limit_and_shear and len(row):
            top, q = (values[row] for values in limit_and_shear)
            fitted, good = _fitted_stick_edge(
                x_out, top - np.sign(_pick(q, last[row] + 1))[:, None] * q, last[row]
            )
            good &= fitted <= end[row]  # nothing sticks beyond the contact: a fit gone wrong
            found[row[good]] = fitted[good]
        edges[:, side] = sign * np.where(n_stick == n_half, end, found)
    edges[nothing] = np.nan
    return edges


def stick_uncertainty(
    x: Array,
    seen: tuple[Mask, Mask],
    closed: Mask,
    contact: Array,
    edges: Array,
    of_contact: Array,
    anywhere: bool = False,
) -> Array:
    """How far each stick edge may be from the true one, by the mesh; NaN where nothing sticks.

    The distance of the nodes around the edge (a share of it where the edge is fitted), and how far
    the edge is from where it would be by another reading of the states: node status for a fitted
    one, and creeping nodes counted as sliding. A slip zone of a few nodes may be none at all:
    there, at least the distance to the contact edge, and its uncertainty. Where the whole contact
    sticks, a slip zone narrower than an element of two nodes may be there unseen.

    Parameters
    ----------
    x, closed : as of `contact_uncertainty`
    seen : (k, n) nodes that stick, as the reader sees them and by the law alone
    contact, edges : contact and stick edges as answered
    of_contact : uncertainty of the contact edges
    anywhere : as of `stick_edges`
    """
    by_status, by_law = (
        stick_edges(x, sticking, closed, contact, anywhere=anywhere) for sticking in seen
    )
    apart = np.fmax(np.abs(by_status - edges), np.abs(by_law - edges))
    after = np.clip(np.searchsorted(x, edges), 1, len(x) - 1)  # NaN comes last
    spacing = _spacing(
        x, np.where(np.abs(x[after - 1] - edges) <= np.abs(x[after] - edges), after - 1, after)
    )
    beyond = np.empty(edges.shape, dtype=np.int64)
    for side, sign, x_out, (inside, sticks) in _sides(x, closed, seen[0]):
        half = _half(x_out, inside, sign, sticks if anywhere else None)
        beyond[:, side] = np.count_nonzero(half & (x_out > sign * edges[:, [side]]), axis=1)
    narrow = np.where(beyond <= _UNRESOLVED, np.abs(contact - edges) + of_contact, 0.0)
    share = np.where(edges == by_status, 1.0, _FITTED_SHARE)
    unseen = np.where(edges == contact, _UNSEEN * spacing, 0.0)
    return np.maximum(np.maximum(share * spacing + apart, narrow), unseen)


Side = tuple[int, float, Array, tuple[NDArray, ...]]


def _sides(x: Array, *rows: NDArray) -> Iterator[Side]:
    """Left and right side, the left one reflected: column, sign, x outwards (n,), and the rows
    likewise.
    """
    yield 0, -1.0, -x[::-1], tuple(row[:, ::-1] for row in rows)
    yield 1, 1.0, x, rows


def _pick(rows: NDArray, index: Indices) -> NDArray:
    """(k,) of each row the value at its own node."""
    return rows[np.arange(len(rows)), index]


def _last(inside: Mask) -> Indices:
    """(k,) the outermost node of each row that is `inside`."""
    return np.asarray(inside.shape[1] - 1 - np.argmax(inside[:, ::-1], axis=1))


def _half(x_out: Array, closed: Mask, sign: float, stick: Mask | None = None) -> Mask:
    """(k, n) closed nodes outwards of the middle of the contact; one in the middle belongs to the
    right side.

    Where `stick` is given, of the middle one of the sticking nodes, if there are any.
    """
    middle = ((x_out[np.argmax(closed, axis=1)] + x_out[_last(closed)]) / 2)[:, None]
    if stick is not None:
        there, rank = stick & closed, np.cumsum(stick & closed, axis=1)
        # Counted from the left whichever side looks, so that both have one middle.
        number = (rank[:, -1:] + 1) // 2 if sign > 0 else rank[:, -1:] // 2 + 1
        middle = np.where(
            rank[:, -1:] > 0, x_out[np.argmax(there & (rank == number), axis=1)][:, None], middle
        )
    return np.asarray(closed & ((x_out >= middle) if sign > 0 else (x_out > middle)))


def _last_sticking(stick: Mask, half: Mask) -> tuple[Indices, Indices, Indices]:
    """(k,) last node of the stick zone on a side, how many nodes the zone has there, and how many
    the side.

    Its end is where the fewest nodes are on the wrong side of it, the farthest out where it is a
    tie. Without nodes the last of them says nothing.
    """
    sticking, rank = (np.cumsum(nodes, axis=1, dtype=np.int32) for nodes in (stick & half, half))
    # Sliding nodes up to this one, and sticking ones behind it.
    wrong = np.where(half, rank - 2 * sticking, half.shape[1] + 1)
    last: Indices = half.shape[1] - 1 - np.argmin(wrong[:, ::-1], axis=1)
    n_stick: Indices = np.where(_pick(wrong, last) <= 0, _pick(rank, last), 0)
    return last, n_stick, rank[:, -1].astype(np.int64)


def _spacing(x: Array, node: Indices) -> Array:
    """The larger distance of nodes from their neighbours."""
    apart = np.concatenate([[0.0], np.diff(x), [0.0]])
    return np.maximum(apart[node], apart[node + 1])


def _zero_of_squares(x_out: Array, values: Array, last: Indices, count: int) -> Array:
    """(k,) zero of the straight line through the squares of `values` at `count` nodes before the
    last; NaN unless it falls.
    """
    nodes = last[:, None] - np.arange(1, count + 1)
    away, squares = (
        x_out[nodes] - x_out[last][:, None],
        np.take_along_axis(values, nodes, axis=1) ** 2,
    )
    mean, height = away.mean(axis=1, keepdims=True), squares.mean(axis=1)
    slope = ((away - mean) * squares).sum(axis=1) / ((away - mean) ** 2).sum(axis=1)
    return x_out[last] + mean[:, 0] - height / np.where(slope < 0, slope, np.nan)


def _fitted_stick_edge(x_out: Array, room: Array, last: Indices) -> tuple[Array, Mask]:
    """(k,) edge of the stick zone from the shear inside it: f p -+ q falls to zero as the square
    root of the distance.

    Parameters
    ----------
    room : (k, n) f p minus the shear in the direction of the slip beyond the edge [stress]
    last : (k,) last node of the stick zone by its status, at least seven nodes before it

    Returns
    -------
    The zero of a straight line through the squares of `room` at seven nodes; and whether it is one:
    False where they do not fall towards the edge, where the line through the next four says
    something else (an older stick edge is near), or where the zero is not near the last node.
    """
    element = x_out[last] - x_out[last - 2]
    found, other = (_zero_of_squares(x_out, room, last, count) for count in _FITTED)
    return found, (np.abs(found - other) <= _AGREE * element) & (
        np.abs(found - x_out[last]) <= element
    )
