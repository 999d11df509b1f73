"""Notes on what the mesh does not resolve: contacts, slip zones and flanks of the pressure (parts
of a contact beyond a kink of the profile) that are too few elements wide.

# notation: h element size at the edges of contact and stick, of the coarser side; a half-width;
A = 2/E*; f coefficient of friction

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

from meshes import MeshSettings
from scenes import Profile
from scenes.array_types import Array

# Error in L2 over h/a, of q and of p.
_ERROR_OF_SHEAR = 0.65
_ERROR_OF_PRESSURE = 0.25
# That of linear elements over that of quadratic ones.
_FACTOR_OF_LINEAR = 3.7
# Error above which there is a note.
_NOTED_ERROR = 0.05
# Share of the largest load from which on instants count: below it tractions are off in a contact
# that carries next to nothing.
_LEAST_LOAD_RATIO = 0.3
# Exponent of a power law below which the peak at its tip is lost: it is 2.4 % low for x^1.2 on a
# coarse mesh, 6.8 % for x^1.15, 41 % for x^1.05; p and q in L2 have errors of 0.4 % and 1 % at
# most.
_LEAST_EXPONENT_OF_PEAK = 1.25
# Halvings of an element at a tip, at most.
_MOST_HALVINGS = 16
# Share of the error of the pressure there that is to be left.
_ERROR_LEFT_AT_TIP = 1 / 64
# Further halvings within a rounded tip: the peak of a wedge has an error of 1e-3 with two elements
# there, and of a tenth of that with eight.
_HALVINGS_WITHIN_TIP = 2
# Exponent from which on a tip counts as smooth: rows and fitted curves are no exact parabolas.
SMOOTH_TIP = 1.99
# Digits behind the point to which an exponent is rounded.
_DIGITS_OF_EXPONENT = 9
# Dissipation over A f^2 P^2 (h/a)^2 of a mesh on which nothing should slip.
_DISSIPATION_BY_MESH = 0.04
# Elements below which the dissipation of a slip zone has an error of per cents: Cattaneo-Mindlin's
# cycle has 0.4 % at 3.4 elements, 3 % at 1.6, 34 % at 0.7, and is seven times too large or nothing
# at 0.2.
_FEW_ELEMENTS = 2.0
# Elements that a note recommends in a slip zone: twice as many.
_ENOUGH_ELEMENTS_IN_SLIP = 4.0


def exponent_at_tip(profile: Profile, distance: float) -> float:
    """Exponent n of the power |x|^n by which the initial gap rises near x = 0, from its values at
    `distance` and at twice that [length].

    Of the two sides the smaller exponent counts, the sharper tip. It is infinite on a side where
    the gap does not rise all the way. It is rounded to nine digits behind the point.

    >>> from scenes import PowerLaw
    >>> exponent_at_tip(PowerLaw(exponent=1.5, length=1.0, rise=1e-3), 0.1)
    1.5
    """
    exponents = []
    for sign_of_x in (-1.0, 1.0):
        height_at_tip, height_at_distance, height_at_double_distance = profile.height(
            sign_of_x * distance * np.arange(3)
        ).tolist()
        is_rising = (
            height_at_distance > height_at_tip and height_at_double_distance > height_at_distance
        )
        height_ratio = (
            (height_at_double_distance - height_at_tip) / (height_at_distance - height_at_tip)
            if is_rising
            else math.inf
        )
        exponents.append(math.log2(height_ratio))
    return round(min(exponents), _DIGITS_OF_EXPONENT)


def tip_halvings(profile: Profile, size: float) -> int:
    """Number of times that the surface element at x = 0, of a given `size` [length], is halved
    because the profile has a tip there; 0 for a smooth profile.

    Where the gap rises as |x|^n with n < 2 the pressure is p(0) - c |x|^(n - 1), and its error at
    the tip goes with the element size to the power n - 1. Elements are halved until 1/64 of that
    error is left, 16 times at most. Where the tip is rounded, n >= 1.99 at some size: two halvings
    follow within the rounding.

    >>> from scenes import PowerLaw
    >>> [
    ...     tip_halvings(PowerLaw(exponent=n, length=1.0, rise=1e-3), 0.04)
    ...     for n in (1.1, 1.5, 1.9, 2.0, 4.0)
    ... ]
    [16, 12, 7, 0, 0]
    """
    n_halvings = 0
    error_left = 1.0
    # _MOST_HALVINGS: 16; _ERROR_LEFT_AT_TIP: 1/64; SMOOTH_TIP: 1.99; _HALVINGS_WITHIN_TIP: 2
    while n_halvings < _MOST_HALVINGS and error_left > _ERROR_LEFT_AT_TIP:
        exponent = exponent_at_tip(profile, size / 2**n_halvings)  # n at the present size
        if exponent >= SMOOTH_TIP:
            return n_halvings + _HALVINGS_WITHIN_TIP if n_halvings else 0
        n_halvings += 1
        error_left /= 2 ** (exponent - 1)
    return n_halvings


@dataclass(frozen=True, eq=False)
class Revolution:
    """Loads, half-widths and friction work of the last revolution of a run, at n instants.

    Attributes
    ----------
    load
        (n,) normal load [force per thickness]
    contact_half_width, stick_half_width
        (n,) [length]; that of stick NaN where nothing sticks
    dissipation
        friction work of the revolution over A f^2 P^2, A = 2/E*, P the largest load
    has_shear
        whether the contact can carry shear
    """

    load: Array
    contact_half_width: Array
    stick_half_width: Array
    dissipation: float
    has_shear: bool

    def least_half_width(self) -> float:
        """Least half-width of contact at instants with more than 0.3 of the largest load [length];
        in a contact that carries next to nothing the error of the tractions does not matter.
        """
        is_loaded = self.load > _LEAST_LOAD_RATIO * np.max(self.load)
        return float(np.min(self.contact_half_width[is_loaded], initial=np.inf))

    def widest_slip_zone(self) -> float:
        """Largest width of a slip zone, half-width of contact minus that of stick [length]; where
        nothing sticks, the half-width of contact.
        """
        stick_half_width = np.where(np.isfinite(self.stick_half_width), self.stick_half_width, 0.0)
        return float(np.max(self.contact_half_width - stick_half_width, initial=0.0))


class Flank(NamedTuple):
    """Part of a contact beyond a kink of the profile.

    Attributes
    ----------
    kink
        x of the kink [length]
    width_in_elements
        from the kink to the edge of contact; negative where the contact ends before the kink
    equivalent_hertz_elements
        resolution of the steep pressure: number of elements from the middle to the edge of a Hertz
        contact whose pressure is as steep at its edge
    """

    kink: float
    width_in_elements: float
    equivalent_hertz_elements: float


def flanks(profile: Profile, half_width: float, element_size: float) -> Iterator[Flank]:
    """Flanks of a contact, the parts of it beyond a kink of the profile, where the pressure falls
    steeply: place, width and resolution of each.

    With kink b, half-width a and element size h, a flank of (a - b)/h elements is as steep as the
    edge of a Hertz contact of (a - b)/h max(a/b, 1) elements from middle to edge. Where the contact
    ends less than an element before a kink, it counts as a flank too.

    Parameters
    ----------
    profile
        initial gap, with its kinks
    half_width
        of the contact [length]
    element_size
        size of surface elements at its edge [length]

    Examples
    --------
    >>> from scenes import FlatRounded
    >>> punch = FlatRounded(radius=1000.0, flat_half_length=0.8)
    >>> [round(flank.equivalent_hertz_elements, 6) for flank in flanks(punch, 1.0, 0.01)]
    [25.0]
    """
    for kink in profile.kinks:
        width_in_elements = (half_width - kink) / element_size
        if width_in_elements > -1:
            # A flank that takes most of the contact is that of a Hertz contact itself.
            ratio_to_hertz = max(half_width / kink, 1.0)
            equivalent_hertz_elements = max(width_in_elements, 1e-9) * ratio_to_hertz
            yield Flank(kink, width_in_elements, equivalent_hertz_elements)


def resolution_notes(
    profile: Profile, revolution: Revolution, element_size: float, mesh: MeshSettings
) -> Iterator[str]:
    """Sentences for the reader on what the mesh is too coarse for in the last cycle, with the
    element size that would do where a finer mesh helps.

    They are on contacts of few elements, a profile near a wedge, steep parts of the pressure beyond
    a kink of the profile, narrow slip zones, and friction work near the error that the mesh makes
    in it.

    Parameters
    ----------
    profile
        initial gap, with its kinks
    revolution
        loads, half-widths of contact and stick, and friction work of the last cycle; `has_shear` is
        whether the contact can carry shear
    element_size
        size of surface elements at the edges of contact and stick, of the body with the larger
        ones [length]
    mesh
        settings of the mesh, from which the advice starts: order and sizes of its elements
    """
    # Errors of shear and pressure that are to be expected, by the number of elements from the
    # middle of a contact to its edge; those of linear elements are 3.7 times larger.
    expected_errors = _ExpectedErrors(
        _FACTOR_OF_LINEAR if mesh.order == 1 else 1.0, revolution.has_shear
    )
    n_elements_without_note = expected_errors.n_elements_without_note()

    # The narrowest contact under load.
    elements_in_least_contact = revolution.least_half_width() / element_size
    if expected_errors.needs_note(elements_in_least_contact):
        yield (
            f"the contact is {elements_in_least_contact:.2g} elements from its middle to its edge"
            f" where it is smallest (loads above {_LEAST_LOAD_RATIO:g} of the largest),"
            f" {element_size:.3g} each on the coarser side:"
            f" {expected_errors.errors_in_words(elements_in_least_contact)};"
            f" {_advice_on_mesh(mesh, elements_in_least_contact / n_elements_without_note)}"
        )

    # A profile near a wedge.
    # _MOST_HALVINGS: 16
    exponent = exponent_at_tip(profile, element_size / 2**_MOST_HALVINGS)
    # _LEAST_EXPONENT_OF_PEAK: 1.25
    if exponent < _LEAST_EXPONENT_OF_PEAK:
        yield (
            f"the profile rises as |x|^{exponent:g}, next to a wedge, whose pressure is infinite at"
            " the tip: the largest pressure is too low, by 7% for |x|^1.15 and by 40% for"
            " |x|^1.05; away from the tip the mesh follows it"
        )

    # Steep parts of the pressure beyond a kink: each flank has the resolution of a Hertz contact of
    # so many elements.
    for flank in flanks(profile, elements_in_least_contact * element_size, element_size):
        factor_on_size = flank.equivalent_hertz_elements / n_elements_without_note
        # _NOTED_ERROR: error that is worth a note, 0.05
        if expected_errors.shear_error(flank.equivalent_hertz_elements) > _NOTED_ERROR:
            yield (
                f"the contact ends {max(flank.width_in_elements, 0.0):.2g} elements,"
                f" {element_size:.3g} each, beyond"
                f" x = {flank.kink:.6g}, where the pressure is steep: it is not resolved there,"
                f" {expected_errors.errors_in_words(flank.equivalent_hertz_elements)};"
                f" {_advice_on_mesh(mesh, factor_on_size)}"
            )
    if revolution.has_shear:
        yield from _slip_notes(revolution, element_size, mesh)


@dataclass(frozen=True)
class _ExpectedErrors:
    """Errors of shear q and pressure p in L2, over f p and p, by the number of elements from the
    middle of a contact to its edge.

    Attributes
    ----------
    factor
        of these errors over those of quadratic elements
    has_shear
        whether the contact can carry shear
    """

    factor: float
    has_shear: bool

    def shear_error(self, n_elements: float) -> float:
        """Expected error of the shear in L2, over f p, in a contact of so many elements from its
        middle to its edge: inversely proportional to their number.
        """
        return self.factor * _ERROR_OF_SHEAR / n_elements

    def pressure_error(self, n_elements: float) -> float:
        """Expected error of the pressure in L2, over p, in a contact of so many elements from its
        middle to its edge: inversely proportional to their number.
        """
        return self.factor * _ERROR_OF_PRESSURE / n_elements

    def needs_note(self, n_elements: float) -> bool:
        """Whether there is to be a note: the error of the shear is above 0.05, or that of the
        pressure where the contact carries no shear.
        """
        error = self.shear_error(n_elements) if self.has_shear else self.pressure_error(n_elements)
        return error > _NOTED_ERROR

    def n_elements_without_note(self) -> float:
        """Number of elements, from the middle of a contact to its edge, from which on the expected
        error of the shear is at most 0.05 and needs no note.
        """
        return float(np.ceil(self.factor * _ERROR_OF_SHEAR / _NOTED_ERROR))

    def errors_in_words(self, n_elements: float) -> str:
        """Part of a sentence on the expected errors of shear and pressure, in a contact of so many
        elements from its middle to its edge.
        """
        shear_error = self.shear_error(n_elements)
        pressure_error = self.pressure_error(n_elements)
        if (shear_error if self.has_shear else pressure_error) > 0.5:
            return "expect errors of tractions and dissipation of half their size and more"
        shear_text = f"of {shear_error:.0%} of f p in the shear and " if self.has_shear else ""
        return f"expect an error {shear_text}of {pressure_error:.0%} in the pressure (L2)"


def _advice_on_mesh(mesh: MeshSettings, factor: float) -> str:
    """Advice on a finer mesh, as part of a sentence: the setting that multiplies the size of edge
    elements by a `factor` below 1, rounded down to two digits. Where that is below the least size
    of the settings, the advice is that no size resolves it.

    >>> _advice_on_mesh(MeshSettings(edge_element_size=0.01), 0.2469)
    'use edge_element_size = 0.0024'
    >>> _advice_on_mesh(MeshSettings(), 1e-9)
    'no edge_element_size resolves it'
    """
    element_size = mesh.edge_element_size * factor
    second_digit = 10.0 ** (math.floor(math.log10(element_size)) - 1) if element_size > 0 else 1.0
    element_size = math.floor(element_size / second_digit) * second_digit
    if element_size < MeshSettings.LEAST_SIZE:
        return "no edge_element_size resolves it"
    return f"use edge_element_size = {element_size:.2g}"


def _slip_notes(revolution: Revolution, element_size: float, mesh: MeshSettings) -> Iterator[str]:
    """A sentence where slip is not resolved: no node slips, slip zones are few elements wide, or
    more than 5 % of the friction work may be an error of the mesh.

    Parameters
    ----------
    revolution
        the last cycle: half-widths of contact, widest slip zone, and friction work
    element_size
        of surface elements at the edges of its contacts [length]
    mesh
        settings of the mesh, from which the advice starts

    # notation: A = 2/E*, f coefficient of friction, P largest load
    """
    dissipation = revolution.dissipation  # over A f^2 P^2
    elements_in_slip_zone = revolution.widest_slip_zone() / element_size
    largest_half_width = float(np.max(revolution.contact_half_width, initial=element_size))
    # friction work of a mesh on which nothing should slip, over A f^2 P^2
    # _DISSIPATION_BY_MESH: times the square of the element size over the half-width
    dissipation_by_mesh = _DISSIPATION_BY_MESH * (element_size / largest_half_width) ** 2
    # Worth a note: a slip zone of less than two elements (_FEW_ELEMENTS; four are enough), and an
    # error of more than 5 % (_NOTED_ERROR).
    if not dissipation > 0:
        yield (
            f"no node slips: a slip zone narrower than an element, {element_size:.3g} at the edges,"
            " would not be seen, and its dissipation would be missing"
        )
    elif elements_in_slip_zone < _FEW_ELEMENTS:
        error_text = (
            "some per cent or more" if elements_in_slip_zone > 1 else "a factor, up or down"
        )
        yield (
            f"slip zones are {elements_in_slip_zone:.2g} elements wide at most,"
            f" {element_size:.3g} each: the"
            f" error of the dissipation is {error_text};"
            f" {_advice_on_mesh(mesh, elements_in_slip_zone / _ENOUGH_ELEMENTS_IN_SLIP)}"
        )
    elif dissipation_by_mesh > _NOTED_ERROR * dissipation:
        yield (
            f"the dissipation is {dissipation:.2g} A f^2 P^2, and the mesh alone makes up to"
            f" {dissipation_by_mesh:.2g} of that unit where all of the contact is next to slipping,"
            " even if nothing slips: take the figure for uncertain by that much"
        )
