"""Loads with several harmonics: P = P0 + sum P_k cos(k t - phi_k), likewise Q."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from scenes.frozen import Frozen
from scenes.loads import Array, LoadPath, Loads, Point, WayIn, straight_way_in
from scenes.materials import Positive

Harmonic = tuple[Annotated[float, Field(ge=0, description="amplitude")], Annotated[float, Field(description="lag, degrees")]]


# Sines that are worked out at once: what the caches of a processor hold.
_AT_ONCE = 2**15
# Waves of a load whose sines are asked of the library one by one: more of them follow from that of the first, ten times faster.
_FEW = 7


class _Waves(NamedTuple):
    """Those of a load that have an amplitude: k, amplitude and phase in radians, (m,) each."""

    number: Array
    amplitude: Array
    phase: Array


@dataclass(frozen=True)
class HarmonicLeg:
    """P and Q as trigonometric polynomials of time; `normal`, `tangential` hold (amplitude, phase in radians) of k = 1, 2, ..."""

    start: float
    end: float
    mean: Point
    normal: tuple[tuple[float, float], ...]
    tangential: tuple[tuple[float, float], ...]

    @cached_property
    def _waves(self) -> tuple[_Waves, _Waves]:
        return _heard(self.normal), _heard(self.tangential)

    @property
    def most_turns(self) -> int:
        order = max(int(np.max(waves.number, initial=0)) for waves in self._waves)
        return 2 * order * math.ceil((self.end - self.start) / (2 * math.pi))

    def loads(self, time: ArrayLike) -> Loads:
        p, q = _sums(self._waves, np.asarray(time, dtype=float))
        return self.mean[0] + p, self.mean[1] + q

    def rates(self, time: ArrayLike) -> Loads:
        # A cos(k t - phi) has the rate k A cos(k t - phi + 90 degrees).
        rising = [_Waves(k, k * amplitude, phase - math.pi / 2) for k, amplitude, phase in self._waves]
        return _sums(rising, np.asarray(time, dtype=float))

    def change(self, time: ArrayLike, since: ArrayLike) -> Loads:
        t, t0 = np.asarray(time, dtype=float), np.asarray(since, dtype=float)
        return _changes(self._waves, (t + t0) / 2, (t - t0) / 2)

    def shifted(self, delay: float) -> HarmonicLeg:
        def late(waves: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
            return tuple((a, phase + math.remainder(k * delay, 2 * math.pi)) for k, (a, phase) in enumerate(waves, 1))

        return replace(
            self, start=self.start + delay, end=self.end + delay, normal=late(self.normal), tangential=late(self.tangential)
        )


def _heard(waves: tuple[tuple[float, float], ...]) -> _Waves:
    amplitude, phase = np.array(waves, dtype=float).reshape(-1, 2).T
    heard = amplitude != 0
    return _Waves(np.arange(1.0, len(waves) + 1)[heard], amplitude[heard], phase[heard])


def _sums(loads: Sequence[_Waves], t: Array) -> Loads:
    """Sum of A_k cos(k t - phi_k) for P and for Q, shape of t."""
    if max(len(waves.number) for waves in loads) <= _FEW:
        p, q = (sum((a * np.cos(k * t - phase) for k, a, phase in zip(*waves, strict=True)), np.zeros(t.shape)) for waves in loads)
        return p, q
    even, odd = _quadratures(loads)

    def part(times: Array) -> Array:
        cosine, sine = _multiples(times, even.shape[1])
        return (even * cosine + odd * sine).sum(axis=1)

    return _in_parts(part, even.shape[1], t)


def _changes(loads: Sequence[_Waves], middle: Array, half: Array) -> Loads:
    """The sums at middle + half less those at middle - half: of -2 A_k sin(k middle - phi_k) sin(k half), free of cancellation."""
    if max(len(waves.number) for waves in loads) <= _FEW:
        terms = (
            (-2 * a * np.sin(k * middle - phase) * np.sin(k * half) for k, a, phase in zip(*waves, strict=True)) for waves in loads
        )
        p, q = (sum(each, np.zeros(middle.shape)) for each in terms)
        return p, q
    even, odd = _quadratures(loads)

    def part(middles: Array, halves: Array) -> Array:
        cosine, sine = _multiples(middles, even.shape[1])
        return ((even * sine - odd * cosine) * (-2 * _multiples(halves, even.shape[1])[1])).sum(axis=1)

    return _in_parts(part, even.shape[1], middle, half)


def _quadratures(loads: Sequence[_Waves]) -> tuple[Array, Array]:
    """Factors of cos(k t) and of sin(k t) in P and Q, (2, m, 1) each, for all k up to the last wave's."""
    factors = np.zeros((2, len(loads), max(int(np.max(waves.number, initial=0)) for waves in loads), 1))
    for load, (number, amplitude, phase) in enumerate(loads):
        factors[:, load, number.astype(int) - 1, 0] = amplitude * np.array([np.cos(phase), np.sin(phase)])
    return factors[0], factors[1]


def _multiples(angle: Array, count: int) -> tuple[Array, Array]:
    """cos(k t) and sin(k t), (count, n) each, k = 1, 2, ...: twice as many by the sums of angles each time.

    Small sines keep their digits: nothing cancels in s_j c_k + c_j s_k there.
    """
    cosine, sine = np.empty((count, len(angle))), np.empty((count, len(angle)))
    cosine[0], sine[0] = np.cos(angle), np.sin(angle)
    known = 1
    while known < count:
        more = slice(known, min(2 * known, count))
        these = slice(0, more.stop - known)
        cosine[more] = cosine[these] * cosine[known - 1] - sine[these] * sine[known - 1]
        sine[more] = sine[these] * cosine[known - 1] + cosine[these] * sine[known - 1]
        known = more.stop
    return cosine, sine


def _in_parts(part: Callable[..., Array], count: int, *times: Array) -> Loads:
    """`part`, (2, n) sums of `count` rows, at times of one shape: the same last digit however many times are asked for."""
    size, shape = times[0].size, times[0].shape
    # Never one time alone: its column would be summed in another order.
    flat = [np.resize(time, 2) if size == 1 else time.ravel() for time in times]
    marks = np.arange(0, max(size - 1, 1), max(_AT_ONCE // count, 2)).tolist()
    parts = [part(*(time[a:b] for time in flat)) for a, b in zip(marks, [*marks[1:], None], strict=True)]
    p, q = np.concatenate(parts, axis=1)[:, :size]
    return p.reshape(shape), q.reshape(shape)


class HarmonicLoad(Frozen):
    """P = P0 + sum over k of P_k cos(k t - phi_k), Q likewise; a revolution takes 2 pi and starts at t = 0.

    >>> load = HarmonicLoad(mean_normal_load=3, normal_harmonics=[(1, 0)], tangential_harmonics=[(0.5, 90), (0.25, 0)])
    >>> p, q = load.path().at(0.0)
    >>> float(p), round(float(q), 12)
    (4.0, 0.25)
    """

    kind: Literal["harmonics"] = "harmonics"
    mean_normal_load: Positive = Field(description="P0, force per unit thickness (library: N/mm)")
    mean_tangential_load: float = Field(0.0, description="Q0")
    normal_harmonics: tuple[Harmonic, ...] = Field((), description="[P_k, phi_k in degrees] of k = 1, 2, ...")
    tangential_harmonics: tuple[Harmonic, ...] = Field((), description="[Q_k, phi_k in degrees] of k = 1, 2, ...")
    way_in: WayIn = Field("straight", description="from (0, 0) to the first point of the cycle: straight, or by the [P, Q] points")

    def path(self) -> LoadPath:
        """The legs of this history."""
        waves = (
            tuple((amplitude, math.radians(phase)) for amplitude, phase in harmonics)
            for harmonics in (self.normal_harmonics, self.tangential_harmonics)
        )
        turn = HarmonicLeg(0.0, 2 * math.pi, (self.mean_normal_load, self.mean_tangential_load), *waves)
        return LoadPath(straight_way_in(self.way_in, turn, math.pi), (turn,))

    def in_words(self, unit: str) -> str:
        """The loads as the end of a sentence."""
        return (
            f"the loads hold {len(self.normal_harmonics)} and {len(self.tangential_harmonics)} harmonics about "
            f"P = {self.mean_normal_load:.6g}, Q = {self.mean_tangential_load:.6g} {unit}"
        )
