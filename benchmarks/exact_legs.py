"""Legs of a load path in mpmath, and roots on them: straight lines and sums of harmonics. Part of `exact_history.py`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import mpmath as mp
from scipy.optimize import brentq

Number = Any
"""mpf or float: the same formulas serve for a first guess and for the truth."""


def same() -> mp.mpf:
    """What is rounding: ten digits short of all."""
    return mp.mpf(10) ** (10 - mp.mp.dps)


class Waves(NamedTuple):
    """A leg P = P0 + sum P_k cos(k t - phi_k), Q likewise; (amplitude, phase) of k = 1, 2, ..."""

    begin: mp.mpf
    end: mp.mpf
    mean: tuple[mp.mpf, mp.mpf]
    normal: tuple[tuple[mp.mpf, mp.mpf], ...]
    tangential: tuple[tuple[mp.mpf, mp.mpf], ...]

    def loads(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        """P and Q."""
        mean = (self.mean[0], self.mean[1]) if lib is mp else (float(self.mean[0]), float(self.mean[1]))
        return tuple(m + _sum(waves, t, lib, 0) for m, waves in zip(mean, self.waves, strict=True))

    def rates(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        """P' and Q'."""
        return tuple(_sum(waves, t, lib, 1) for waves in self.waves)

    @property
    def waves(self) -> tuple[tuple[tuple[mp.mpf, mp.mpf], ...], ...]:
        return self.normal, self.tangential

    def turns(self, normal: mp.mpf, tangential: mp.mpf) -> list[mp.mpf]:
        """Times at which c_P P + c_Q Q turns round: Re sum A_k z^k = 0 on the unit circle z = exp(i t)."""
        order = max(len(waves) for waves in self.waves)
        a = [mp.mpc(0)] * (order + 1)
        for factor, waves in zip((normal, tangential), self.waves, strict=True):
            for k, (size, phase) in enumerate(waves, 1):
                a[k] += 1j * k * factor * size * mp.expj(-phase)
        while order and a[order] == 0:
            order -= 1
        if not order:
            return []
        polynomial = [*a[order:0:-1], mp.mpf(0), *(mp.conj(part) for part in a[1 : order + 1])]
        roots = mp.polyroots(polynomial, maxsteps=500, extraprec=400)
        angles = [mp.arg(root) for root in roots if abs(abs(root) - 1) < same()]
        return [t for angle in angles for k in range(-1, 3) if self.begin < (t := angle + 2 * mp.pi * k) < self.end]


def _sum(waves: Sequence[tuple[mp.mpf, mp.mpf]], t: Number, lib: Any, derivative: int) -> Number:
    total = 0 * t
    for k, (size, phase) in enumerate(waves, 1):
        angle = k * t - (phase if lib is mp else float(phase))
        total += (size if lib is mp else float(size)) * (lib.cos(angle) if not derivative else -k * lib.sin(angle))
    return total


class Straight(NamedTuple):
    """A leg from one point (P, Q) to another in unit time."""

    first: tuple[mp.mpf, mp.mpf]
    last: tuple[mp.mpf, mp.mpf]
    begin: mp.mpf = mp.mpf(0)
    end: mp.mpf = mp.mpf(1)

    def loads(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        p, q = (a + (b - a) * t for a, b in zip(self.first, self.last, strict=True))
        return (p, q) if lib is mp else (float(p), float(q))

    def rates(self, t: Number, lib: Any = mp) -> tuple[Number, Number]:
        p, q = (b - a for a, b in zip(self.first, self.last, strict=True))
        return (p, q) if lib is mp else (float(p), float(q))

    def turns(self, normal: mp.mpf, tangential: mp.mpf) -> list[mp.mpf]:
        return []


LoadSegment = Waves | Straight


def root(leg: LoadSegment, what: tuple[Number, Number], wanted: mp.mpf, first: mp.mpf, last: mp.mpf) -> mp.mpf:
    """The time in [first, last] at which a combination of loads, monotone there, has a value: in doubles, then by Newton."""

    def off(t: Number, lib: Any = mp) -> Number:
        p, q = leg.loads(t, lib)
        c = what if lib is mp else (float(what[0]), float(what[1]))
        return c[0] * p + c[1] * q - (wanted if lib is mp else float(wanted))

    low, high = off(first), off(last)
    if low == 0 or high == 0 or (low > 0) == (high > 0):
        return first if abs(low) < abs(high) else last
    a, b = float(first), float(last)
    known = (off(a, math) > 0) != (off(b, math) > 0)
    t = min(max(mp.mpf(brentq(lambda s: off(s, math), a, b, xtol=1e-15)) if known else (first + last) / 2, first), last)
    floor, ceiling = first, last
    for _ in range(400):
        here = off(t)
        floor, ceiling = (t, ceiling) if (here > 0) == (low > 0) else (floor, t)
        rate = sum(c * r for c, r in zip(what, leg.rates(t), strict=True))
        step = here / rate if rate else ceiling - floor
        new = t - step
        if not floor < new < ceiling:
            new = (floor + ceiling) / 2
        if abs(new - t) <= abs(t) * mp.eps * 4 or new == t:
            return new
        t = new
    return t


def legs_of(mean: Sequence[float], normal: Sequence[Any], tangential: Sequence[Any]) -> tuple[list[LoadSegment], list[LoadSegment]]:
    """Straight initial loading (the steady cycle forgets it) and revolution."""
    pairs = (tuple((mp.mpf(size), mp.pi * mp.mpf(degrees) / 180) for size, degrees in waves) for waves in (normal, tangential))
    turn = Waves(mp.mpf(0), 2 * mp.pi, (mp.mpf(mean[0]), mp.mpf(mean[1])), *pairs)
    return [Straight((mp.mpf(0), mp.mpf(0)), turn.loads(mp.mpf(0)))], [turn]
