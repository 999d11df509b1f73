"""Many steady ellipses: their angles and loads.

# notation: P = P0 + P1 cos t, Q = Q0 + Q1 cos(t - phase), r = Q1/f, A = 2/E*; u and v amplitudes of (Q -+ f P)/f;
#           E largest Q - f P, G least Q + f P, I least Q - f P, J front passes G, M = E a turn later; P_T permanent stick load

Every angle and load difference comes from r, P1 and the phase without cancellation, however small the slip:

    u = |r exp(-i phase) - P1|,  v = |r exp(-i phase) + P1|,  P_T = P0 - (u + v)/2
    D = t_G - t_E = t_M - t_J = arg(P1^2 - r^2 + 2 i r P1 sin(phase)),  t_J - t_I = pi - D
    exp(-i t_E) = (r exp(-i phase) - P1)/u

    E-G  s = t - t_E:  rate f v sin(D - s),  P - P_c = u sin^2(s/2),         P_c - P_T = v sin^2((D - s)/2)
    I-J  s = t - t_I:  rate f u sin s,       P - P_c = 2 P1 sin t_E sin s
    J-M  s = t_M - t:  rate f u sin s,       P - P_c = v sin^2((D + s)/2),   P_c - P_T = u sin^2(s/2)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Ellipses:
    """Steady ellipses, turned the way round that has 0 <= phase <= pi; all arrays of shape (m,).

    Attributes
    ----------
    mean, amplitude : P0, P1
    u, v : amplitudes of (Q -+ f P)/f
    cosine, sine : of t_E
    turn : D
    permanent : P_T
    """

    mean: Array
    amplitude: Array
    u: Array
    v: Array
    cosine: Array
    sine: Array
    turn: Array
    permanent: Array

    def take(self, members: Any) -> Ellipses:
        """Some of them, in the shape of `members`."""
        return Ellipses(**{name: values[members] for name, values in vars(self).items()})

    @property
    def start(self) -> Array:
        """t_E in (0, pi]."""
        return np.arctan2(self.sine, self.cosine)

    @property
    def moving(self) -> NDArray[np.bool_]:
        """Whether P moves: an amplitude below 1e-200 of the mean moves no edge, and dividing by a subnormal one overflows."""
        return self.amplitude > 1e-200 * self.mean

    def load(self, cosine: Array) -> Array:
        """P where cos t is known, from the least load so that it keeps its digits close to full unloading."""
        return (self.mean - self.amplitude) + self.amplitude * (1 + cosine)


def ellipses_of(mean: Array, amplitude: Array, tangential: Array, phase: Array, friction: Array) -> Ellipses:
    """The geometry of the loops; arrays (m,) of admissible values, friction > 0."""
    p1, ratio = amplitude, tangential / friction
    # cos and sin of the phase from half of it; the mirrored loop, Q -> -Q, goes round the other way: phase + pi.
    half = np.tan(phase / 2)
    share = ratio / (1 + half * half)
    along, across = np.where(half < 0, -1.0, 1.0) * share * (1 - half) * (1 + half), 2 * share * np.abs(half)
    u, v = np.hypot(along - p1, across), np.hypot(along + p1, across)
    turn = np.arctan2(2 * p1 * across, (p1 - ratio) * (p1 + ratio))
    size = np.where(u > 0, u, 1.0)
    # P_T < 0 is admitted to rounding only: it is gross sliding.
    return Ellipses(mean, p1, u, v, (along - p1) / size, across / size, turn, np.maximum(mean - (u + v) / 2, 0.0))


def phase_of(name: str, e: Ellipses, s: Array) -> tuple[Array, Array, Array]:
    """Rate over f, P - P_c and P at angles s of a phase: "E-G", "I-J" or "J-M"."""
    if name == "E-G":
        return e.v * np.sin(e.turn - s), e.u * np.sin(s / 2) ** 2, e.load(np.cos(e.start + s))
    sine = np.sin(s)
    if name == "I-J":
        return e.u * sine, 2 * e.amplitude * e.sine * sine, e.load(-np.cos(e.start + s))
    return e.u * sine, e.v * np.sin((e.turn + s) / 2) ** 2, e.load(np.cos(e.start - s))
