"""Loads with several harmonics: P = P0 + sum P_k cos(k t - phi_k), likewise Q."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, Field

from scenes.loads import Array, LoadPath, Loads, Point, WayIn, straight_way_in
from scenes.materials import FROZEN, Positive

Harmonic = tuple[Annotated[float, Field(ge=0, description="amplitude")], Annotated[float, Field(description="lag, degrees")]]


@dataclass(frozen=True)
class HarmonicLeg:
    """P and Q as trigonometric polynomials of time; `normal`, `tangential` hold (amplitude, phase in radians) of k = 1, 2, ..."""

    start: float
    end: float
    mean: Point
    normal: tuple[tuple[float, float], ...]
    tangential: tuple[tuple[float, float], ...]

    def loads(self, time: ArrayLike) -> Loads:
        t = np.asarray(time, dtype=float)
        return self.mean[0] + _wave(self.normal, t, 0.0), self.mean[1] + _wave(self.tangential, t, 0.0)

    def rates(self, time: ArrayLike) -> Loads:
        # A cos(k t - phi) has the rate k A cos(k t - phi + 90 degrees).
        t = np.asarray(time, dtype=float)
        return (
            _wave(tuple((k * a, phase) for k, (a, phase) in enumerate(self.normal, 1)), t, math.pi / 2),
            _wave(tuple((k * a, phase) for k, (a, phase) in enumerate(self.tangential, 1)), t, math.pi / 2),
        )

    def change(self, time: ArrayLike, since: ArrayLike) -> Loads:
        t, t0 = np.asarray(time, dtype=float), np.asarray(since, dtype=float)
        return _wave_change(self.normal, t, t0), _wave_change(self.tangential, t, t0)

    def shifted(self, delay: float) -> HarmonicLeg:
        def late(waves: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
            return tuple((a, phase + math.remainder(k * delay, 2 * math.pi)) for k, (a, phase) in enumerate(waves, 1))

        return replace(
            self, start=self.start + delay, end=self.end + delay, normal=late(self.normal), tangential=late(self.tangential)
        )


def _wave(waves: tuple[tuple[float, float], ...], t: Array, lead: float) -> Array:
    total = np.zeros(t.shape)
    for k, (amplitude, phase) in enumerate(waves, 1):
        total = total + amplitude * np.cos(k * t - (phase - lead))
    return total


def _wave_change(waves: tuple[tuple[float, float], ...], t: Array, t0: Array) -> Array:
    middle, half = (t + t0) / 2, (t - t0) / 2
    total = np.zeros(middle.shape)
    for k, (amplitude, phase) in enumerate(waves, 1):
        total = total - 2 * amplitude * np.sin(k * middle - phase) * np.sin(k * half)
    return total


class HarmonicLoad(BaseModel):
    """P = P0 + sum over k of P_k cos(k t - phi_k), Q likewise; a revolution takes 2 pi and starts at t = 0.

    >>> load = HarmonicLoad(mean_normal_load=3, normal_harmonics=[(1, 0)], tangential_harmonics=[(0.5, 90), (0.25, 0)])
    >>> p, q = load.path().at(0.0)
    >>> float(p), round(float(q), 12)
    (4.0, 0.25)
    """

    model_config = FROZEN

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
