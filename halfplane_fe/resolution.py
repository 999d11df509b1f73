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

from halfplane_fe.arrays import Array
from meshes import MeshSettings, SurfaceGrading
from scenes import Profile, Scene

# Error in L2 over h/a, of q and of p; that of linear elements over that of quadratic ones.
_SHEAR, _PRESSURE, _LINEAR = 0.65, 0.25, 3.7
# Error above which there is a note.
_TOLD = 0.05
# Share of the largest load from which on instants count: below it tractions are off in a contact
# that carries next to nothing.
_LOADED = 0.3
# Exponent of a power law below which the peak at its tip is lost: it is 2.4 % low for x^1.2 on a
# coarse mesh, 6.8 % for x^1.15, 41 % for x^1.05; p and q in L2 have errors of 0.4 % and 1 % at
# most.
_SHARP = 1.25
# Halvings of an element at a tip: at most; share of the error of the pressure there that is to be
# left.
_MOST_HALVINGS, _LEFT_AT_TIP = 16, 1 / 64
# Further ones within a rounded tip: the peak of a wedge has an error of 1e-3 with two elements
# there,
# and of a tenth of that with eight.
_WITHIN_TIP = 2
# Power from which on a tip counts as smooth, and digits that a power has: rows and fitted curves
# are no exact parabolas.
_SMOOTH, _DIGITS_OF_POWER = 1.99, 9
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
        lowest, near, far = profile.height(side * distance * np.arange(3)).tolist()
        rises = near > lowest and far > near
        powers.append(math.log2((far - lowest) / (near - lowest)) if rises else math.inf)
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
    count, left = 0, 1.0
    while count < _MOST_HALVINGS and left > _LEFT_AT_TIP:
        power = tip_power(profile, size / 2**count)
        if power >= _SMOOTH:
            return count + _WITHIN_TIP if count else 0
        count, left = count + 1, left / 2 ** (power - 1)
    return count


def resolution_notes(
    scene: Scene,
    load: Array,
    contact: Array,
    stick: Array,
    element: float,
    order: int,
    dissipation: float,
    sheared: bool,
) -> Iterator[str]:
    """One sentence for whatever in the last revolution is too narrow for the surface elements.

    Contacts, or their flanks beyond a kink of the profile, and slip zones of few elements;
    dissipation not far above what the mesh alone makes.

    Parameters
    ----------
    load, contact, stick : (n,) normal load and half-widths at its instants [force per thickness,
        length]; stick NaN where nothing sticks
    element : at the edges of contact and stick, of the coarser side [length]
    order : of the elements
    dissipation : of the revolution over A f^2 P^2, P the largest load
    sheared : whether any shear can arise
    """
    worse = _LINEAR if order == 1 else 1.0
    # elements from which on the shear is right to what need not be told
    enough = np.ceil(worse * _SHEAR / _TOLD)

    def off(elements: float) -> tuple[float, float, str]:
        """Expected errors of q and p in L2, over f p and p, and what to expect of the tractions."""
        shear, pressure = worse * _SHEAR / elements, worse * _PRESSURE / elements
        if (shear if sheared else pressure) > 0.5:
            return (
                shear,
                pressure,
                "expect errors of tractions and dissipation of half their size and more",
            )
        of_shear = f"of {shear:.0%} of f p in the shear and " if sheared else ""
        return shear, pressure, f"expect an error {of_shear}of {pressure:.0%} in the pressure (L2)"

    least = float(np.min(contact[load > _LOADED * np.max(load)], initial=np.inf)) / element
    shear, pressure, words = off(least)
    if shear > _TOLD and (sheared or pressure > _TOLD):
        yield (
            f"the contact is {least:.2g} elements from its middle to its edge where it is smallest"
            f" (loads above {_LOADED:g} of the largest), {element:.3g} each on the coarser side:"
            f" {words}; make edge_element_size of that side less than 1/{enough:.0f} of the"
            " half-width there"
        )
    exponent = tip_power(scene.profile, element / 2**_MOST_HALVINGS)
    if exponent < _SHARP:
        yield (
            f"the profile rises as |x|^{exponent:g}, next to a wedge, whose pressure is infinite at"
            " the tip: the largest pressure is too low, by 7% for |x|^1.15 and by 40% for"
            " |x|^1.05; away from the tip the mesh follows it"
        )
    for kink in scene.profile.kinks:
        # A flank is as steep as it is narrow beside what it ends: one that takes most of the
        # contact is Hertz' own.
        width = least - kink / element
        shear, _, words = off(max(width, 1e-9) * max(least / (kink / element), 1.0))
        if width > -1 and shear > _TOLD:
            yield (
                f"the contact ends {max(width, 0.0):.2g} elements, {element:.3g} each, beyond x ="
                f" {kink:.6g}, where the pressure is steep: it is not resolved there, {words}; make"
                f" edge_element_size {enough:.0f} times less than that distance"
            )
    if not sheared:
        return
    slip = float(np.max(contact - np.where(np.isfinite(stick), stick, 0.0), initial=0.0)) / element
    floor = _FLOOR * (element / float(np.max(contact, initial=element))) ** 2
    if not dissipation > 0:
        yield (
            f"no node slips: a slip zone narrower than an element, {element:.3g} at the edges,"
            " would not be seen, and its dissipation would be missing"
        )
    elif slip < _FEW:
        much = "some per cent or more" if slip > 1 else "a factor, up or down"
        yield (
            f"slip zones are {slip:.2g} elements wide at most, {element:.3g} each: the error of the"
            f" dissipation is {much}; make edge_element_size several times less than their width"
        )
    elif floor > _TOLD * dissipation:
        yield (
            f"the dissipation is {dissipation:.2g} A f^2 P^2, and the mesh alone makes up to"
            f" {floor:.2g} of that unit where all of the contact is next to slipping, even if"
            " nothing slips: take the figure for uncertain by that much"
        )


# Shares of the mesh in the uncertainty of W: of its difference from the coarse run's over the
# square of the refinement; of the rms of what edges between nodes add to W, which is taken off
# (`between_nodes`); of W (h/a)^2; of A f^2 P^2 (h/a)^2. By what is known of the edges: that some
# stand between nodes, and were corrected for it; that none stands; nothing, on linear elements,
# with a penalty layer, and under bulk stress or tilt. Fitted to 115 random scenes
# (benchmarks/covered.py, seeds 5 to 7), held to others.
_SHARES = {
    "corrected": (1.0, 0.15, 0.1, 0.0),
    "moving": (1.0, 0.0, 1.0, 1e-4),
    "unknown": (2.0, 0.0, 1.5, 5e-3),
}
# Share of W over the fourth power of the growth of elements away from the edges, the order of
# quadratic elements: on four scenes 1e-6 to 3e-6 at 0.12, 1e-5 to 2.5e-5 at 0.2, 1e-4 to 3.3e-4 at
# 0.4.
_GROWN = 0.01875
# Safety factor of a difference whose order is known (Roache 1994).
_SAFETY = 1.25
# Share of p0 h^2/(a d), d from the peak to the edge, that edges between nodes move it by: up to 0.6
# for Hertz, 0.4 for x^5. Share of p0 (H/a)^2 (b/a)^4 that the elements H of the middle leave where
# they reach to b, near the edge: 0.07 at b = 0.8 a.
_PEAK_BY_EDGES, _PEAK_BY_MIDDLE = 0.8, 0.15
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
    dissipation, difference : W, and by how much that of the coarse run is off it, over A f^2 P^2
    coarse : element of the coarse run, over the half-width
    scatter : rms of what edges between nodes add to W, over A f^2 P^2; 0 where none stands, None
    where that is not known plain : linear elements or a penalty layer, whose errors are not of
    order 2: the whole difference counts

    >>> round(
    ...     uncertainty(0.1, 0.01, 0.1, MeshSettings(edge_element_size=0.01), 1e-5, plain=False), 12
    ... )
    0.000106510101
    """
    element = mesh.edge_element_size * max(mesh.upper_ratio, 1.0)
    refinement = coarse / element
    if refinement < _LEAST_REFINEMENT:
        return float("nan")
    of_difference, of_scatter, of_work, of_unit = _SHARES[
        "unknown" if scatter is None else "corrected" if scatter else "moving"
    ]
    share = of_difference / (refinement**2 - 1)  # what an error of order 2 leaves of itself
    # Where no node slips, nothing scatters: a note says what may be unseen.
    placed = (of_work * dissipation + of_unit) * element**2 if dissipation else 0.0
    return (
        difference * (max(share, 1.0) if plain else share)
        + of_scatter * (scatter or 0.0)
        + placed
        + _GROWN * mesh.growth**4 * dissipation
    )


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
        apart = abs(self.refinement**self.order - 1)
        return 1 / apart if apart else math.inf


@dataclass(frozen=True)
class Peak:
    """The largest pressure of a run.

    Attributes
    ----------
    value : [stress]
    difference : by how much that of the coarse run is off it [stress]
    half_width : of the contact then [length]
    to_edge : distance of the peak from the nearer edge of contact [length]
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
    with n < 2, of
    order 1 where the elements resolve that it is rounded. Elsewhere it is made by the edges of
    contact: of order 2, or 1 where the curvature of the profile jumps in their zone. NaN where the
    elements there are like those of the coarse run.

    Parameters
    ----------
    coarse : element of the coarse run [length]
    fine : surface of the run, of the coarser side
    mesh : of the run, of which the growth counts
    depth : of the thinner body; infinite of half-planes [length]
    plain : linear elements or a penalty layer: the whole difference counts
    """
    if not (peak.half_width > 0 and peak.to_edge > 0):
        return math.nan  # nothing touches: the first increment failed
    power = tip_power(profile, coarse)
    within_tip = 0.0
    if power < _SMOOTH:
        resolved = tip_power(profile, fine.tip_size) >= _SMOOTH
        place = Place(coarse / fine.tip_size, 1.0 if resolved else power - 1)
        within_tip = _PEAK_WITHIN_TIP if resolved else 0.0
    else:
        place = Place(coarse / fine.edge_size, 1.0 if profile.kinks else 2.0)
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
    dissipation: float, uncertain: float, tolerance: float, coarse: float
) -> Iterator[str]:
    """That W is uncertain by more than its tolerance, or by an unknown amount; `coarse` is that of
    the coarse run, or NaN.
    """
    if np.isnan(dissipation):
        return
    if np.isnan(uncertain):
        why = (
            "its bodies are shared, without a coarse run of this scene"
            if np.isnan(coarse)
            else "the coarse run has elements like these"
        )
        yield f"the dissipation has no uncertainty estimate: {why}"
    elif uncertain > tolerance * dissipation and uncertain > 0:
        share = (
            f" ({uncertain / dissipation:.2%}, for a tolerance of {tolerance:.2%})"
            if dissipation
            else ""
        )
        yield (
            f"the dissipation is uncertain by {uncertain:.3g}{share}: make edge_element_size or"
            " step_tolerance smaller"
        )
