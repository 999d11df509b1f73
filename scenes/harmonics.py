"""Loads with several harmonics: P = P0 + sum P_k cos(k t - phi_k), likewise Q."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from scenes.frozen import Frozen
from scenes.loads import LoadPath, WayIn, straight_way_in
from scenes.materials import Positive
from scenes.segments import HarmonicSegment

Harmonic = tuple[Annotated[float, Field(ge=0, description="amplitude")], Annotated[float, Field(description="lag, degrees")]]


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
        turn = HarmonicSegment(0.0, 2 * math.pi, (self.mean_normal_load, self.mean_tangential_load), *waves)
        return LoadPath(straight_way_in(self.way_in, turn, math.pi), (turn,))

    def in_words(self, unit: str) -> str:
        """The loads as the end of a sentence."""
        return (
            f"the loads hold {len(self.normal_harmonics)} and {len(self.tangential_harmonics)} harmonics about "
            f"P = {self.mean_normal_load:.6g}, Q = {self.mean_tangential_load:.6g} {unit}"
        )
