"""What the mesh can't see, in sentences: contacts, slip zones and flanks of the pressure that are
too few elements wide.

And the uncertainty of the dissipation, from the difference to the coarse run and from the steps.

# notation: h element at the edges of contact and stick, of the coarser side; a half-width; A =
2/E*; f coefficient of friction

Measured on Hertz at P0 : P1 = 3 : 1, quadratic elements, h = a/1.1 ... a/160, matching sides and
sides of ratio 1.5 ... 20, the worst instant with more than 0.3 of the largest load: the error in L2
is 0.3 to 0.62 h/a of f p for q, 0.1 to 0.25 h/a for p; linear elements are 3.7 times worse. Where P
and Q go along the limit of friction, so that nothing slips and all of it nearly does, elements of
a/16 to a/160 dissipate 0.024 to 0.04 (h/a)^2 A f^2 P^2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from meshes import MeshSettings, SurfaceGrading
from scenes import Profile
from scenes.array_types import Array

# Error in L2 over h/a, of q and of p.
_SHEAR = 0.65
_PRESSURE = 0.25
# That of linear elements over that of quadratic ones.
_LINEAR = 3.7
# Error above which there is a note.
_TOLD = 0.05
# Share of the largest load from which on instants count: below it tractions are off in a contact
# that carries next to nothing.
_LOADED = 0.3
# Exponent of a power law below which the peak at its tip is lost: it is 2.4 % low for x^1.2 on a
# coarse mesh, 6.8 % for x^1.15, 41 % for x^1.05; p and q in L2 have errors of 0.4 % and 1 % at
# most.
_SHARP = 1.25
# Halvings of an element at a tip, at most.
_MOST_HALVINGS = 16
# Share of the error of the pressure there that is to be left.
_LEFT_AT_TIP = 1 / 64
# Further halvings within a rounded tip: the peak of a wedge has an error of 1e-3 with two elements
# there, and of a tenth of that with eight.
_WITHIN_TIP = 2
# Power from which on a tip counts as smooth: rows and fitted curves are no exact parabolas.
_SMOOTH = 1.99
# Digits that a power has.
_DIGITS_OF_POWER = 9
# Dissipation over A f^2 P^2 (h/a)^2 of a mesh on which nothing should slip.
_FLOOR = 0.04
# Elements below which the dissipation of a slip zone has an error of per cents: Cattaneo-Mindlin's
# cycle has 0.4 % at 3.4 elements, 3 % at 1.6, 34 % at 0.7, and is seven times too large or nothing
# at 0.2.
_FEW = 2.0


def tip_power(profile: Profile, distance: float) -> float:
    """Power of |x| that the gap follows from `distance` to twice that, of the sharper side.

    Infinite where it is flat.

    >>> from scenes import PowerLaw
    >>> tip_power(PowerLaw(exponent=1.5, length=1.0, rise=1e-3), 0.1)
    1.5
    """
    powers = []
    for side in (-1.0, 1.0):
        at_tip, at_distance, at_twice = profile.height(side * distance * np.arange(3)).tolist()
        rises = at_distance > at_tip and at_twice > at_distance
        ratio = (at_twice - at_tip) / (at_distance - at_tip) if rises else math.inf
        powers.append(math.log2(ratio))
    return round(min(powers), _DIGITS_OF_POWER)


def tip_halvings(profile: Profile, size: float) -> int:
    """How often elements of that size [length] are halved towards x = 0, where the profile has a
    tip.

    Where the gap rises as |x|^n with n < 2 the pressure is p(0) - c |x|^(n - 1), and its error at
    the tip goes with the element to the power n - 1. Elements are halved until a share
    `_LEFT_AT_TIP` of it is left, or until there are some within a rounded tip.

    >>> from scenes import PowerLaw
    >>> [
    ...     tip_halvings(PowerLaw(exponent=n, length=1.0, rise=1e-3), 0.04)
    ...     for n in (1.1, 1.5, 1.9, 2.0, 4.0)
    ... ]
    [16, 12, 7, 0, 0]
    """
    count = 0
    error_left = 1.0
    while count < _MOST_HALVINGS and error_left > _LEFT_AT_TIP:
        power = tip_power(profile, size / 2**count)
        if power >= _SMOOTH:
            return count + _WITHIN_TIP if count else 0
        count += 1
        error_left /= 2 ** (power - 1)
    return count


@dataclass(frozen=True, eq=False)
class Revolution:
    """The last revolution of a run, n instants of it.

    Attributes
    ----------
    load
        (n,) normal load [force per thickness]
    contact, stick
        (n,) half-widths [length]; stick NaN where nothing sticks
    dissipation
        over A f^2 P^2, P the largest load
    sheared
        whether any shear can arise
    """

    load: Array
    contact: Array
    stick: Array
    dissipation: float
    sheared: bool

    def least_contact(self) -> float:
        """Least half-width under more than a share of the largest load [length]."""
        loaded = self.load > _LOADED * np.max(self.load)
        return float(np.min(self.contact[loaded], initial=np.inf))

    def widest_slip_zone(self) -> float:
        """Width of a slip zone, at most [length]."""
        stick = np.where(np.isfinite(self.stick), self.stick, 0.0)
        return float(np.max(self.contact - stick, initial=0.0))


def resolution_notes(
    profile: Profile, revolution: Revolution, element: float, order: int
) -> Iterator[str]:
    """One sentence for whatever in a revolution is too narrow for the surface elements.

    Contacts, or their flanks beyond a kink of the profile, and slip zones of few elements;
    dissipation not far above what the mesh alone makes.

    Parameters
    ----------
    element
        at the edges of contact and stick, of the coarser side [length]
    order
        of the elements
    """
    expected = _ExpectedErrors(_LINEAR if order == 1 else 1.0, revolution.sheared)
    least = revolution.least_contact() / element
    if expected.matter(least):
        yield (
            f"the contact is {least:.2g} elements from its middle to its edge where it is smallest"
            f" (loads above {_LOADED:g} of the largest), {element:.3g} each on the coarser side:"
            f" {expected.words(least)}; make edge_element_size of that side less than"
            f" 1/{expected.enough_elements():.0f} of the half-width there"
        )
    exponent = tip_power(profile, element / 2**_MOST_HALVINGS)
    if exponent < _SHARP:
        yield (
            f"the profile rises as |x|^{exponent:g}, next to a wedge, whose pressure is infinite at"
            " the tip: the largest pressure is too low, by 7% for |x|^1.15 and by 40% for"
            " |x|^1.05; away from the tip the mesh follows it"
        )
    for kink in profile.kinks:
        width = least - kink / element
        # A flank is as steep as it is narrow beside what it ends: one that takes most of the
        # contact is Hertz' own.
        resolved_by = max(width, 1e-9) * max(least / (kink / element), 1.0)
        if width > -1 and expected.of_shear(resolved_by) > _TOLD:
            yield (
                f"the contact ends {max(width, 0.0):.2g} elements, {element:.3g} each, beyond x ="
                f" {kink:.6g}, where the pressure is steep: it is not resolved there,"
                f" {expected.words(resolved_by)}; make edge_element_size"
                f" {expected.enough_elements():.0f} times less than that distance"
            )
    if revolution.sheared:
        yield from _slip_notes(revolution, element)


@dataclass(frozen=True)
class _ExpectedErrors:
    """Errors of q and p in L2, over f p and p, by the elements from the middle of a contact to its
    edge.

    Attributes
    ----------
    factor
        over those of quadratic elements
    sheared
        whether any shear can arise
    """

    factor: float
    sheared: bool

    def of_shear(self, elements: float) -> float:
        """That of q."""
        return self.factor * _SHEAR / elements

    def of_pressure(self, elements: float) -> float:
        """That of p."""
        return self.factor * _PRESSURE / elements

    def matter(self, elements: float) -> bool:
        """Whether there is to be a note."""
        if self.sheared:
            return self.of_shear(elements) > _TOLD
        return self.of_shear(elements) > _TOLD and self.of_pressure(elements) > _TOLD

    def enough_elements(self) -> float:
        """Elements from which on q is right to what needs no note."""
        return float(np.ceil(self.factor * _SHEAR / _TOLD))

    def words(self, elements: float) -> str:
        """What to expect of the tractions."""
        shear = self.of_shear(elements)
        pressure = self.of_pressure(elements)
        if (shear if self.sheared else pressure) > 0.5:
            return "expect errors of tractions and dissipation of half their size and more"
        of_shear = f"of {shear:.0%} of f p in the shear and " if self.sheared else ""
        return f"expect an error {of_shear}of {pressure:.0%} in the pressure (L2)"


def _slip_notes(revolution: Revolution, element: float) -> Iterator[str]:
    """Slip zones of few elements, and dissipation that the mesh alone may have made."""
    dissipation = revolution.dissipation
    slip_zone = revolution.widest_slip_zone() / element
    largest_contact = float(np.max(revolution.contact, initial=element))
    made_by_mesh = _FLOOR * (element / largest_contact) ** 2
    if not dissipation > 0:
        yield (
            f"no node slips: a slip zone narrower than an element, {element:.3g} at the edges,"
            " would not be seen, and its dissipation would be missing"
        )
    elif slip_zone < _FEW:
        error = "some per cent or more" if slip_zone > 1 else "a factor, up or down"
        yield (
            f"slip zones are {slip_zone:.2g} elements wide at most, {element:.3g} each: the error"
            f" of the dissipation is {error}; make edge_element_size several times less than their"
            " width"
        )
    elif made_by_mesh > _TOLD * dissipation:
        yield (
            f"the dissipation is {dissipation:.2g} A f^2 P^2, and the mesh alone makes up to"
            f" {made_by_mesh:.2g} of that unit where all of the contact is next to slipping, even"
            " if nothing slips: take the figure for uncertain by that much"
        )


class _Shares(NamedTuple):
    """Shares of the mesh in the uncertainty of W.

    Attributes
    ----------
    difference
        of its difference from the coarse run's over the square of the refinement
    scatter
        of the rms of what edges between nodes add to W, which is taken off (`between_nodes`)
    work
        of W (h/a)^2
    unit
        of A f^2 P^2 (h/a)^2
    """

    difference: float
    scatter: float
    work: float
    unit: float


# By what is known of the edges. Fitted to 115 random scenes (benchmarks/covered.py, seeds 5 to 7),
# held to others. Some stand between nodes, and W was corrected for it:
_CORRECTED = _Shares(difference=1.0, scatter=0.15, work=0.1, unit=0.0)
# none stands:
_MOVING = _Shares(difference=1.0, scatter=0.0, work=1.0, unit=1e-4)
# nothing is known, on linear elements, with a penalty layer, and under bulk stress or tilt:
_UNKNOWN = _Shares(difference=2.0, scatter=0.0, work=1.5, unit=5e-3)
# Share of W over the fourth power of the growth of elements away from the edges, the order of
# quadratic elements: on four scenes 1e-6 to 3e-6 at 0.12, 1e-5 to 2.5e-5 at 0.2, 1e-4 to 3.3e-4 at
# 0.4.
_GROWN = 0.01875
# Safety factor of a difference whose order is known (Roache 1994).
_SAFETY = 1.25
# Share of p0 h^2/(a d), d from the peak to the edge, that edges between nodes move it by: up to 0.6
# for Hertz, 0.4 for x^5.
_PEAK_BY_EDGES = 0.8
# Share of p0 (H/a)^2 (b/a)^4 that the elements H of the middle leave where they reach to b, near
# the edge: 0.07 at b = 0.8 a.
_PEAK_BY_MIDDLE = 0.15
# Share of p0 (H/t)^2 that they leave in a body t thin: 0.0035 at most on pairs of layers of 0.17 to
# 0.4 a with H = a/12 and a/24, of which the terms above cover a part.
_PEAK_BY_DEPTH = 0.003
# Share of p0 over the fourth power of the growth of elements away from the edges, as of W: 2.7e-6
# of Hertz at 0.12 in all.
_PEAK_GROWN = 0.005
# Share of p0 that eight elements within a rounded tip leave: 1.6e-4 of a sharp wedge on the default
# mesh, 1.3e-4 on a fine one.
_PEAK_WITHIN_TIP = 3e-4
# Refinement from the coarse run below which their difference says nothing.
_LEAST_REFINEMENT = 1.4


def uncertainty(
    dissipation: float,
    difference: float,
    coarse: float,
    mesh: MeshSettings,
    scatter: float | None,
    plain: bool,
) -> float:
    """Share of the mesh in the uncertainty of W over A f^2 P^2; NaN on a mesh hardly finer than
    that of the coarse run.

    Parameters
    ----------
    dissipation, difference
        W, and its difference from that of the coarse run, over A f^2 P^2
    coarse
        element of the coarse run, over the half-width
    scatter
        rms of what edges between nodes add to W, over A f^2 P^2; 0 where none stands, None
        where that is not known
    plain
        linear elements or a penalty layer, whose errors are not of order 2: the difference
        counts in full

    Examples
    --------
    >>> round(
    ...     uncertainty(0.1, 0.01, 0.1, MeshSettings(edge_element_size=0.01), 1e-5, plain=False), 12
    ... )
    0.000106510101
    """
    element = mesh.edge_element_size * max(mesh.upper_ratio, 1.0)
    refinement = coarse / element
    if refinement < _LEAST_REFINEMENT:
        return float("nan")
    if scatter is None:
        shares = _UNKNOWN
    elif scatter:
        shares = _CORRECTED
    else:
        shares = _MOVING
    share_left = shares.difference / (refinement**2 - 1)  # of an error of order 2
    if plain:
        share_left = max(share_left, 1.0)
    by_edges = 0.0
    # Where no node slips, nothing scatters: a note says what may be unseen.
    if dissipation:
        by_edges = (shares.work * dissipation + shares.unit) * element**2
    by_scatter = shares.scatter * (scatter or 0.0)
    by_growth = _GROWN * mesh.growth**4 * dissipation
    return difference * share_left + by_scatter + by_edges + by_growth


class Place(NamedTuple):
    """Where the mesh makes an error of a known order: elements there over those of the coarse run,
    and the order.
    """

    refinement: float
    order: float

    def share_left(self) -> float:
        """Error of the run over its difference from the coarse run, 1/|r^p - 1|; infinite where the
        elements are alike.

        With errors C h^p and C H^p, r = H/h the refinement, the difference is C h^p (r^p - 1).

        >>> (
        ...     Place(refinement=4.0, order=0.5).share_left(),
        ...     Place(refinement=0.5, order=1.0).share_left(),
        ... )
        (1.0, 2.0)
        """
        difference = abs(self.refinement**self.order - 1)  # over the error of the run
        return 1 / difference if difference else math.inf


@dataclass(frozen=True)
class Peak:
    """The largest pressure of a run.

    Attributes
    ----------
    value
        [stress]
    difference
        from that of the coarse run [stress]
    half_width
        of the contact then [length]
    to_edge
        distance of the peak from the nearer edge of contact [length]
    """

    value: float
    difference: float
    half_width: float
    to_edge: float


def peak_uncertainty(
    peak: Peak,
    profile: Profile,
    coarse: float,
    fine: SurfaceGrading,
    mesh: MeshSettings,
    *,
    depth: float,
    plain: bool,
) -> float:
    """Uncertainty of the largest pressure [stress].

    u = 1.25 |p_h - p_H| / (r^p - 1), and what the edges of contact and a thin body do to it. Where
    the profile has a tip, the difference is made there: of order n - 1 where the gap rises as |x|^n
    with n < 2, of order 1 where the elements resolve that it is rounded. Elsewhere it is made by
    the edges of contact: of order 2, or 1 where the curvature of the profile jumps in their zone.
    NaN where the elements there are like those of the coarse run.

    Parameters
    ----------
    coarse
        element of the coarse run [length]
    fine
        surface of the run, of the coarser side
    mesh
        of the run, of which the growth counts
    depth
        of the thinner body; infinite of half-planes [length]
    plain
        linear elements or a penalty layer: the difference counts in full
    """
    if not (peak.half_width > 0 and peak.to_edge > 0):
        return math.nan  # nothing touches: the first increment failed
    power = tip_power(profile, coarse)
    within_tip = 0.0
    if power >= _SMOOTH:
        place = Place(coarse / fine.edge_size, 1.0 if profile.kinks else 2.0)
    elif tip_power(profile, fine.tip_size) < _SMOOTH:
        place = Place(coarse / fine.tip_size, power - 1)
    else:
        place = Place(coarse / fine.tip_size, 1.0)
        within_tip = _PEAK_WITHIN_TIP
    if 1 / _LEAST_REFINEMENT < place.refinement < _LEAST_REFINEMENT:
        return math.nan
    share = max(place.share_left(), 1.0 if plain else 0.0)
    a = peak.half_width
    of_edges = _PEAK_BY_EDGES * fine.edge_size**2 / (a * peak.to_edge)
    of_middle = _PEAK_BY_MIDDLE * (fine.size / a) ** 2 * (fine.inner / a) ** 4
    of_depth = _PEAK_BY_DEPTH * (fine.size / depth) ** 2
    of_growth = _PEAK_GROWN * mesh.growth**4
    return (
        _SAFETY * peak.difference * share
        + (of_edges + of_middle + of_depth + of_growth + within_tip) * peak.value
    )


def uncertainty_note(
    dissipation: float, uncertainty: float, tolerance: float, coarse: float
) -> Iterator[str]:
    """That W is uncertain by more than its tolerance, or by an unknown amount; `coarse` is that of
    the coarse run, or NaN.
    """
    if np.isnan(dissipation):
        return
    if np.isnan(uncertainty):
        reason = "the coarse run has elements like these"
        if np.isnan(coarse):
            reason = "its bodies are shared, without a coarse run of this scene"
        yield f"the dissipation has no uncertainty estimate: {reason}"
    elif uncertainty > tolerance * dissipation and uncertainty > 0:
        share = ""
        if dissipation:
            share = f" ({uncertainty / dissipation:.2%}, for a tolerance of {tolerance:.2%})"
        yield (
            f"the dissipation is uncertain by {uncertainty:.3g}{share}: make edge_element_size or"
            " step_tolerance smaller"
        )
