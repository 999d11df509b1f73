"""Normal contact of a profile given by a Python function: P(a) and dP/da by quadrature of h', kept as piecewise Chebyshev series.

# notation: a half-width, P normal load

    P = E* a int cos(angle) h'(x) d angle,  dP/da = E* int cos(angle) (x h')' d angle,  x = a cos(angle), 0 < angle < pi/2
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import CallableProfile, InputError
from scenes.chebyshev import Pieces, halved
from semi_analytic.panels import panels
from semi_analytic.pile import Pile, rising_root

Array = NDArray[np.float64]

_OCTAVES = 54
_CORNER = 1e-6


@dataclass(frozen=True, eq=False)
class Stretch:
    """P and dP/da between two corners as functions of a distance u: u = a - begin from the middle, else u^2 = a - begin.

    Behind a corner of the profile, and beside a flat, both are smooth functions of the root only.
    """

    begin: float
    rooted: bool
    loads: Pieces
    rates: Pieces

    def distance(self, half_width: Array) -> Array:
        """u."""
        above = np.maximum(half_width - self.begin, 0.0)
        return np.sqrt(above) if self.rooted else above


@dataclass(frozen=True, eq=False)
class CallableContact(Pile):
    """Two half-planes pressed together by a profile known as a function. Methods as in `Contact`.

    Attributes
    ----------
    stretches : P and dP/da from a(0) on
    extent : largest half-width [length]
    """

    stretches: tuple[Stretch, ...]
    extent: float

    @property
    def least(self) -> float:
        """a for P = 0 [length]."""
        return self.stretches[0].begin

    @property
    def breaks(self) -> tuple[float, ...]:
        """Half-widths at which dP/da is not smooth."""
        return tuple(stretch.begin for stretch in self.stretches[1:])

    @property
    def bends_anywhere(self) -> bool:
        """A function may hardly grow wherever it likes."""
        return True

    @property
    def noise(self) -> float:
        """Relative error of P and dP/da themselves: a derivative was taken of h, two of it in dP/da."""
        return 1e-11

    def load(self, half_width: ArrayLike) -> Array:
        """P(a) [force per thickness]; in the very middle as a power of a."""
        return self._at(np.abs(np.asarray(half_width, dtype=float)), 0)

    def stiffness(self, half_width: ArrayLike) -> Array:
        """dP/da [stress]."""
        return self._at(np.abs(np.asarray(half_width, dtype=float)), 1)

    def _at(self, half: Array, order: int) -> Array:
        result = np.zeros(half.shape)
        number = np.maximum(np.searchsorted([stretch.begin for stretch in self.stretches], half, side="right") - 1, 0)
        for k, stretch in enumerate(self.stretches):
            here = number == k
            if np.any(here):
                result[here] = self._on(stretch, stretch.distance(half[here]), order)
        return result

    def _on(self, stretch: Stretch, distance: Array, order: int) -> Array:
        series = (stretch.loads, stretch.rates)[order]
        first = float(series.edges[0])
        inside = series(np.maximum(distance, first))
        if first == 0:
            return inside
        part = np.minimum(distance / first, 1.0)
        return inside * np.where(part < 1, part ** (self._power - order * (2 if stretch.rooted else 1)), 1.0)

    @property
    def _power(self) -> float:
        """Power of the distance u that P follows below the least octave."""
        stretch = self.stretches[0]
        first = np.array(stretch.loads.edges[0])
        return float(first * stretch.rates(first) / stretch.loads(first) * (2 * first if stretch.rooted else 1.0))

    def half_width(self, load: ArrayLike) -> Array:
        """a(P) [length], by Newton's method.

        Raises
        ------
        InputError
            For a load that needs a contact wider than the extent of the profile.
        """
        p = np.asarray(load, dtype=float)
        most, carried = float(np.max(p, initial=0.0)), float(self.load(self.extent))
        if most > carried * (1 + 1e-12):
            raise InputError(
                f"profile.extent = {self.extent:.6g}: the normal load {most:.6g} needs a wider contact, the extent carries "
                f"{carried:.6g}"
            )
        different, fold = np.unique(p.ravel(), return_inverse=True)
        ends = [float(stretch.loads(stretch.loads.edges[-1])) for stretch in self.stretches]
        number = np.minimum(np.searchsorted(ends, different), len(ends) - 1)
        half = np.empty(different.shape)
        for k, stretch in enumerate(self.stretches):
            here = number == k
            if np.any(here):
                distance = self._distance_of(stretch, different[here])
                half[here] = stretch.begin + (distance**2 if stretch.rooted else distance)
        return half[fold].reshape(p.shape)

    def _distance_of(self, stretch: Stretch, load: Array) -> Array:
        """u of a load within one stretch."""
        edges = stretch.loads.edges
        # Counted from where the stretch begins, so that the root of the difference keeps its digits.
        bottom = float(stretch.loads(edges[0])) if edges[0] == 0 else 0.0
        marks = stretch.loads(edges)
        inside = np.interp(load, marks, edges)
        low = edges[0] * (load / marks[0]) ** (1 / self._power) if edges[0] else np.zeros(load.shape)
        guess = np.where(load < marks[0], low, np.maximum(inside, edges[1] / 4))

        def rate(u: Array) -> Array:
            return self._on(stretch, u, 1) * (2 * u if stretch.rooted else 1.0)

        return rising_root(lambda u: self._on(stretch, u, 0) - bottom, rate, np.maximum(load - bottom, 0.0), guess)


def callable_contact(modulus: float, profile: CallableProfile) -> CallableContact:
    """The mechanics of a profile given as a function.

    Raises
    ------
    InputError
        For a profile under which the contact would split.

    >>> contact = callable_contact(100.0, CallableProfile(slope_function=lambda x: x, extent=2.0))  # Hertz with R = 1
    >>> round(float(contact.half_width(25 * np.pi)), 12)
    1.0
    """
    start, corners = _start(profile), _corners(profile)
    cuts = [start, *(b for b in corners if start < b < profile.extent)]
    stretches = tuple(
        _stretch(modulus, profile, begin, end, tuple(reversed(cuts if start else cuts[1:])))
        for begin, end in pairwise([*cuts, profile.extent])
    )
    contact = CallableContact(modulus, profile.datum_length, stretches, profile.extent)
    sample = np.unique(np.concatenate([np.linspace(begin, end, 200) for begin, end in pairwise([*cuts, profile.extent])]))
    stiffness = contact.stiffness(sample)
    falls = stiffness < -1e-10 * np.max(stiffness)
    if np.any(falls):
        raise InputError(f"profile: the contact would split near a half-width of {sample[falls][0]:.6g}")
    return contact


def _stretch(modulus: float, profile: CallableProfile, begin: float, end: float, cuts: tuple[float, ...]) -> Stretch:
    """P and dP/da for begin < a < end; `cuts`, descending, is where the slope has corners."""
    rooted = begin > 0
    whole = np.sqrt(end - begin) if rooted else end - begin
    edges = whole * 0.5 ** np.arange(_OCTAVES - 1, -1.0, -1.0)
    if rooted and profile.slope(np.array(begin)) > 0:
        edges = np.concatenate([[0.0], edges[-4:]])
    elif rooted:
        edges = edges[edges > 1e-5 * np.sqrt(begin)]

    def integral(distance: Array, order: int) -> Array:
        # x = a cos(angle); the angle at a corner from the distance to it, which is known.
        above = distance**2 if rooted else distance
        half = begin + above
        gaps = [np.maximum(above + (begin - b), 0.0) for b in cuts]
        angles = [np.arctan2(np.sqrt(gap * (half + b)), b) for gap, b in zip(gaps, cuts, strict=True)]
        node = panels(np.zeros(half.shape), np.pi / 2, angles)
        cosine = np.sin(np.where(node.at < 0.7, np.pi / 2 - node.at, node.below))
        x = half[..., None, None] * cosine
        inner = profile.slope(x) + profile.bend(x) if order else profile.slope(x) * half[..., None, None]
        return np.asarray(modulus * np.sum(node.weight * cosine * inner, axis=(-2, -1)))

    # Beside a flat, or behind a corner, the slope is known to rounding of its largest value and its bend jumps within rounding
    # of the corner: 4e-15 of the scale can be had for the load, 1e-12 for its derivative.
    scales = [float(integral(edges[-1:], order).item()) * (1.0, 250.0)[order] if rooted else None for order in (0, 1)]
    loads, rates = (halved(partial(integral, order=order), edges, scales[order]) for order in (0, 1))
    return Stretch(begin, rooted, loads, rates)


def _start(profile: CallableProfile) -> float:
    """Half-length of the flat in the middle; 0 if there is none."""
    marks = np.array([*profile.corners, profile.extent])
    flat = profile.slope(marks * 0.999) <= 1e-15 * float(np.max(profile.slope(marks)))
    inner = marks[flat]
    # Slopes fall towards 0 without being flat: a flat is one whose edge is a corner of the profile.
    sharp = [b for b in _corners(profile) if len(inner) and b <= inner[-1] * (1 + 1e-9)]
    return float(sharp[-1]) if sharp and profile.slope(sharp[-1] * 0.9) <= 1e-13 * np.max(profile.slope(marks)) else 0.0


def _corners(profile: CallableProfile) -> tuple[float, ...]:
    """Where the curvature jumps."""
    found = []
    for b in profile.corners:
        left, right = profile.bend(np.array([b * (1 - 1e-9), b * (1 + 1e-9)]))
        if abs(left - right) > _CORNER * (abs(left) + abs(right) + float(profile.slope(np.array(b)))) + 1e-300:
            found.append(b)
    return tuple(found)
