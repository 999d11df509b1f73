"""Bulk stresses in the bodies, tilt or moment: keys of a load beside P and Q, and the segments that stand for them.

# notation: sigma_l, sigma_u bulk stresses of the lower and the upper body; alpha tilt; M moment of the pressure about x = 0
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BeforeValidator, Field, model_validator

from scenes.frozen import Frozen
from scenes.segments import Combination, HarmonicSegment, LinearSegment, LoadSegment, StraightSegment, Waves

Harmonic = tuple[Annotated[float, Field(ge=0, description="amplitude")], Annotated[float, Field(description="lag, degrees")]]
_INITIAL = "values at the points of the load's initial_loading; in proportion to P if left out"


class Wave(Frozen):
    """mean + amplitude cos(t - phase), t being the time of the ellipse."""

    mean: float = Field(0.0, description="in the unit of the key")
    amplitude: float = Field(0.0, ge=0, description="in the unit of the key")
    phase_degrees: float = Field(0.0, ge=-180, le=180, description="lag behind P")
    initial_loading: tuple[float, ...] = Field((), description=_INITIAL)

    def waves(self) -> tuple[float, Waves]:
        """(mean, ((amplitude, phase in radians),))."""
        return self.mean, ((self.amplitude, math.radians(self.phase_degrees)),)


class WaveSum(Frozen):
    """mean + sum over k of amplitude_k cos(k t - phase_k), t being the time of the harmonics."""

    mean: float = Field(0.0, description="in the unit of the key")
    harmonics: tuple[Harmonic, ...] = Field((), description="[amplitude, phase in degrees] of k = 1, 2, ...")
    initial_loading: tuple[float, ...] = Field((), description=_INITIAL)

    def waves(self) -> tuple[float, Waves]:
        """(mean, ((amplitude, phase in radians), ...))."""
        return self.mean, tuple((amplitude, math.radians(phase)) for amplitude, phase in self.harmonics)


class LineOfAction(Frozen):
    """Where the load acts on the upper body: M = x P + height Q."""

    x: float = Field(0.0, description="of the line along which P acts, length units (library: mm)")
    height: float = Field(0.0, description="above the contact at which Q acts, length units (library: mm)")


V = TypeVar("V")
# A list of numbers; what has passed a function in Python is no JSON any more, where a list would be a tuple.
Column = Annotated[tuple[float, ...], BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else value)]
_PAIRS = {"bulk": ("bulk_stress_lower", "bulk_stress_upper"), "turning": ("tilt", "moment")}
KEYS = (*_PAIRS["bulk"], *_PAIRS["turning"], "line_of_action")
"""Keys of bulk stress and tilt, of every load."""


class BulkAndTilt(Frozen, Generic[V]):
    """Keys of bulk stress and tilt. During initial loading they grow in proportion to P, to their values at the cycle's start.

    >>> from scenes import EllipseLoad
    >>> load = EllipseLoad(
    ...     mean_normal_load=3.0, tangential_amplitude=1.0, bulk_stress_lower={"amplitude": 0.5, "phase_degrees": 90}
    ... )
    >>> path = load.path()
    >>> [round(float(one), 12) for one in path.cycle[0].bulk.loads(path.cycle_start)]
    [-0.5, 0.0]
    """

    bulk_stress_lower: float | V | None = Field(
        None, description="bulk stress along x in the lower body, tension positive, stress units (library: MPa)"
    )
    bulk_stress_upper: float | V | None = Field(None, description="likewise in the upper body (library: MPa)")
    tilt: float | V | None = Field(None, description="turn of the upper body that opens the gap at x > 0 (library: rad)")
    moment: float | V | None = Field(
        None, description="moment of the pressure about x = 0 per unit thickness, in place of the tilt (library: N)"
    )
    line_of_action: LineOfAction | None = Field(None, description="where P and Q act on the upper body, in place of the moment")

    @model_validator(mode="after")
    def _one_way_to_turn(self) -> Self:
        ways = [key for key in ("tilt", "moment", "line_of_action") if getattr(self, key) is not None]
        if len(ways) > 1:
            raise ValueError(f"{' and '.join(ways)} say the same thing: state one of them")
        return self

    @model_validator(mode="after")
    def _can_be_followed(self) -> Self:
        if self.has_bulk_or_tilt:
            self.path()  # type: ignore[attr-defined]
        return self

    @property
    def has_bulk_or_tilt(self) -> bool:
        """Whether any of these keys is stated."""
        return any(getattr(self, key) is not None for key in KEYS)

    @property
    def moment_given(self) -> bool:
        """Whether the moment is stated, by itself or by a line of action, so that the tilt follows from it."""
        return self.moment is not None or self.line_of_action is not None

    def _stated(self) -> dict[str, tuple[Any, Any]]:
        """The values of each pair that has one."""
        pairs = {name: tuple(getattr(self, key) for key in keys) for name, keys in _PAIRS.items()}
        return {name: (first, second) for name, (first, second) in pairs.items() if first is not None or second is not None}

    def _carried(self, legs: Sequence[LoadSegment], pairs: Mapping[str, Sequence[LoadSegment]]) -> tuple[LoadSegment, ...]:
        """`legs` with segments of the pairs of the same number, and with the moment of a line of action."""
        found = list(legs)
        if (line := self.line_of_action) is not None:
            rows = Combination(0.0, 0.0), Combination(line.x, line.height)
            found = [replace(leg, turning=LinearSegment(leg.start, leg.end, leg, rows)) for leg in found]
        for name, pair in pairs.items():
            found = [replace(leg, **{name: one}) for leg, one in zip(found, pair, strict=True)]  # type: ignore[arg-type]
        return tuple(found)


def wave_pair(leg: LoadSegment, pair: tuple[Any, Any]) -> HarmonicSegment:
    """Numbers, `Wave` or `WaveSum` of two keys over the time of a segment."""
    (one, first), (other, second) = (value.waves() if isinstance(value, Wave | WaveSum) else (value or 0.0, ()) for value in pair)
    return HarmonicSegment(leg.start, leg.end, (one, other), first, second)


def growing(legs: Sequence[LoadSegment], pair: tuple[Any, Any], last: ArrayLike) -> list[LoadSegment]:
    """Two keys over the initial loading, straight from (0, 0) to `last`: in proportion to P, or by points of their own.

    Raises
    ------
    ValueError
        For points of their own that are not as many as those of the initial loading.
    """
    if not legs:
        return []
    corners = np.array([0.0, *(float(leg.loads(leg.end)[0]) for leg in legs)])
    columns = []
    for value, end in zip(pair, np.asarray(last, dtype=float).tolist(), strict=True):
        own = getattr(value, "initial_loading", ())
        if own and len(own) != len(legs) - 1:
            raise ValueError(
                f"initial_loading of a bulk stress or tilt has {len(own)} values for {len(legs) - 1} points of the load"
            )
        columns.append(np.array([0.0, *own, end]) if own else end * corners / corners[-1])
    return straight_pairs(legs, np.stack(columns, axis=1))


def straight_pairs(legs: Sequence[LoadSegment], corners: ArrayLike) -> list[LoadSegment]:
    """Straight segments over the times of `legs` between rows (n + 1, 2) of two numbers."""
    rows = [(float(one), float(other)) for one, other in np.asarray(corners, dtype=float)]
    return [StraightSegment(leg.start, leg.end, a, b) for leg, a, b in zip(legs, rows[:-1], rows[1:], strict=True)]


def column(value: Any, places: Sequence[int], normal_load: ArrayLike, first: int, words: str) -> NDArray[np.float64]:
    """One key at the corners (n,) of straight lines: its own list, or a number that has grown with P up to corner `first`.

    Parameters
    ----------
    places : (n,) which entry of a list each corner has; -1 for none, which is 0
    words : what the entries of a list stand for

    Raises
    ------
    ValueError
        For a list of another length.
    """
    if isinstance(value, tuple):
        needed = max(places) + 1
        if len(value) != needed:
            raise ValueError(f"a bulk stress or tilt has {len(value)} values, and {needed} are needed, {words}")
        return np.array([value[k] if k >= 0 else 0.0 for k in places])
    loads = np.asarray(normal_load, dtype=float)
    return (value or 0.0) * np.where(np.arange(len(loads)) < first, loads / (loads[first] or 1.0), 1.0)
