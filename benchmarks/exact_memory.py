"""The memory curve of the theory in mpmath, followed leg by leg: where it slips, on what. Part of `exact_history.py`.

# notation: eta normal load of a flat punch, M(eta) the memory curve; d = +1 forward slip, -1 reverse;
#           level of a load: d Q - f P, grows in slip; level of the curve: d M(eta) - f eta, falls with eta; equal at the front P_c
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import mpmath as mp
from exact_legs import LoadSegment, Straight, root, same

_SAMPLES = 200


class Piece(NamedTuple):
    """A piece of the memory curve up to the load `top`: a line through (p, q), or a leg's arc that was appended in full stick."""

    top: mp.mpf
    p: mp.mpf
    q: mp.mpf
    slope: mp.mpf = mp.mpf(0)
    arc: tuple[LoadSegment, mp.mpf, mp.mpf] | None = None

    def value(self, eta: mp.mpf) -> mp.mpf:
        """M(eta)."""
        if self.arc is None:
            return self.q + self.slope * (eta - self.p)
        leg, first, last = self.arc
        return leg.loads(root(leg, (1, 0), eta, first, last))[1]

    def front(self, d: int, f: mp.mpf, level: mp.mpf) -> mp.mpf:
        """The eta at which d M(eta) - f eta is `level`."""
        if self.arc is None:
            return self.p + (level - d * self.q + f * self.p) / (d * self.slope - f)
        leg, first, last = self.arc
        return leg.loads(root(leg, (-f, d), level, first, last))[0]


class Run(NamedTuple):
    """A stretch of slip on one piece of the memory (None: on nothing, P_c = 0): times, direction, leg."""

    begin: mp.mpf
    end: mp.mpf
    direction: int
    leg: LoadSegment
    piece: Piece | None

    def level(self, f: mp.mpf, t: mp.mpf) -> mp.mpf:
        p, q = self.leg.loads(t)
        return self.direction * q - f * p

    def growth(self, f: mp.mpf, t: mp.mpf) -> mp.mpf:
        p, q = self.leg.rates(t)
        return max(self.direction * q - f * p, mp.mpf(0))

    def front(self, f: mp.mpf, t: mp.mpf) -> mp.mpf:
        return self.piece.front(self.direction, f, self.level(f, t)) if self.piece else mp.mpf(0)


Curve = tuple[Piece, ...]


def value(curve: Curve, eta: mp.mpf) -> mp.mpf:
    """M(eta)."""
    return next((piece for piece in curve if eta <= piece.top), curve[-1]).value(eta) if curve else mp.mpf(0)


def cut(curve: Curve, load: mp.mpf) -> Curve:
    """What is left of the curve below `load`."""
    kept = []
    for piece, bottom in zip(curve, (mp.mpf(0), *(piece.top for piece in curve)), strict=False):
        if bottom < load:
            kept.append(piece._replace(top=min(piece.top, load)))
    return tuple(kept)


def follow(curve: Curve, leg: LoadSegment, f: mp.mpf) -> tuple[Curve, list[Run]]:
    """The memory curve after a leg, and its runs of slip."""
    turns = sorted(t for what in ((1, 0), (-f, 1), (-f, -1)) for t in leg.turns(*map(mp.mpf, what)))
    runs: list[Run] = []
    for begin, end in pairwise([leg.begin, *turns, leg.end]):
        if end - begin > same():
            curve, found = _stretch(curve, leg, begin, end, f)
            runs += found
    return curve, runs


def _stretch(curve: Curve, leg: LoadSegment, begin: mp.mpf, end: mp.mpf, f: mp.mpf) -> tuple[Curve, list[Run]]:
    """The same for a stretch on which neither P, Q - fP nor Q + fP turns round."""
    p_rate, q_rate = leg.rates((begin + end) / 2)
    noise = same() * (abs(q_rate) + f * abs(p_rate))
    p_last, q_last = leg.loads(end)
    if p_rate > 0 and abs(q_rate) < f * p_rate - noise:
        p_first, q_first = leg.loads(begin)
        if isinstance(leg, Straight):
            return (*curve, Piece(p_last, p_first, q_first, q_rate / p_rate)), []
        return (*curve, Piece(p_last, p_last, q_last, arc=(leg, begin, end))), []
    if q_rate - f * p_rate > noise and q_rate + f * p_rate > -noise:
        sides = [(begin, end, 1)]
    elif -q_rate - f * p_rate > noise and -q_rate + f * p_rate > -noise:
        sides = [(begin, end, -1)]
    else:
        sides = _sides(curve, leg, begin, end)
    runs: list[Run] = []
    for first, last, d in sides:
        runs += _passed(curve, leg, first, last, d, f) if d else []
    d = sides[-1][2]
    if not d:
        return cut(curve, p_last), runs
    return (*cut(curve, runs[-1].front(f, end)), Piece(p_last, p_last, q_last, d * f)), runs


def _sides(curve: Curve, leg: LoadSegment, begin: mp.mpf, end: mp.mpf) -> list[tuple[mp.mpf, mp.mpf, int]]:
    """(begin, end, direction) of the stretches of an unloading on which the path runs above, below, or along the curve."""

    def above(t: mp.mpf) -> mp.mpf:
        p, q = leg.loads(t)
        off = q - value(curve, p)
        return off if abs(off) > same() * p else mp.mpf(0)

    times = mp.linspace(begin, end, _SAMPLES)[1:]
    signs = [int(mp.sign(above(t))) for t in times]
    marks, directions = [begin], [next((s for s in signs if s), 0)]
    for (t0, t1), (s0, s1) in zip(pairwise(times), pairwise(signs), strict=True):
        if s0 * s1 < 0:
            marks.append(mp.findroot(above, (t0, t1), solver="anderson", tol=mp.mpf(10) ** -50, verify=False))
            directions.append(s1)
    return list(zip(marks, [*marks[1:], end], directions, strict=True))


def _passed(curve: Curve, leg: LoadSegment, begin: mp.mpf, end: mp.mpf, d: int, f: mp.mpf) -> list[Run]:
    """Runs of slip from `begin` to `end`, one for each piece that the front is in."""
    runs, first = [], begin
    bottoms = [mp.mpf(0), *(piece.top for piece in curve)]
    for piece, bottom in zip(reversed(curve), reversed(bottoms[:-1]), strict=True):
        if piece.arc is None and piece.slope == d * f:
            continue  # at the limit already: a front passes it at once
        level = d * value(curve, bottom) - f * bottom if bottom else mp.mpf(0)
        p, q = leg.loads(end)
        last = root(leg, (-f, d), level, first, end) if d * q - f * p > level else end
        if last > first:
            runs.append(Run(first, last, d, leg, piece))
            first = last
        if last == end:
            break
    return runs


def steady_runs(initial_loading: Sequence[LoadSegment], cycle: Sequence[LoadSegment], f: mp.mpf) -> list[Run]:
    """The runs of slip of the second cycle; of the initial loading where there is no cycle."""
    curve: Curve = ()
    runs: list[Run] = []
    for turn in (initial_loading, cycle, cycle) if cycle else (initial_loading,):
        runs = []
        for leg in turn:
            curve, found = follow(curve, leg, f)
            runs += found
    return runs
