"""The next order of finite bodies in the dissipation: what x^4 and x^2 s^2 of their kernels add to
the curvatures of `corrected`.

A body's kernel k_nn(x, s) has after N (x^2 + s^2)/2 the terms N_4 (x^4 + s^4)/24 + N_22 x^2 s^2,
and k_tt likewise with T. Under tractions that are even in x they add to gap and faces::

    gap    (N_4 P) x^4/24 + (2 N_22 p_2) x^2/2        p_2 = int x^2 p dx
    faces  (T_4 Q) x^4/24 + (2 T_22 q_2) x^2/2        q_2 = int x^2 q dx

The punches of x^4/24 carry G_4(c) = G(c) c^2/8 up to half-width c, so that the memory force of each
punch, F(c) = M - kt G - t4 G_4, lies between two bounds that follow the loads, as in
`corrected_memory`::

    B_s = (Q - kt G - t4 G_4) - s f pi,    pi = P - eta - kn G - n4 G_4

and W = (A/pi) int f pi |dF| dc/c over what slips. Here F is carried along on a grid of punches,
step by step, with these terms and without: the difference of the two is what they add, and the
error of grid and steps leaves it. Moments p_2 and q_2 are those without.

Derived here; held to finite elements of blocks, layers and T-shapes 3 to 20 half-widths high, of
which it leaves a tenth of what the curvatures leave.

The same terms move normal contact (`next_order_of_contact`), with the pressure of x^4/24::

    P = eta(a) + kn G(a) + n4 G_4(a),    p_4 = (E*/24) sqrt(a^2 - x^2) (a^2 + 2 x^2)

# notation: A = 2/E*, c half-width of a punch, eta and G its loads, s sense of slip
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from scenes import BodyEffects
from scenes.array_types import Array
from semi_analytic.profiles import SymmetricContact

# They leave up to 0.2 % of what the next order adds, as 400 do; 200 leave 0.5 %.
_PUNCHES = 300
# Rows whose punches are held at once: some ten arrays of 1 MB.
_AT_ONCE = 256
# Rows of a path at most: each takes some 50 us.
MOST_ROWS = 10_000


# Places from the middle to the edge at which the pressure is taken, steps of Newton's rule for a,
# and how often p_2 follows from the pressure: it moves by a per cent of itself.
_PLACES = 200
_STEPS_OF_NEWTON = 30
_ROUNDS = 6


class ChangeOfContact(NamedTuple):
    """Of the largest pressure and the half-width of contact, over what curvatures alone make of
    them, minus 1.
    """

    pressure: float
    half_width: float


@dataclass(frozen=True, eq=False)
class _Terms:
    """What bodies add at the rows of a path, (n,) each: kn, kt, and n4, t4 of x^4/24."""

    gap_curvature: Array
    face_curvature: Array
    gap_fourth: Array
    face_fourth: Array

    def at(self, rows: slice) -> _Terms:
        """Those of some rows, (m, 1) each."""
        return _Terms(
            self.gap_curvature[rows, None],
            self.face_curvature[rows, None],
            self.gap_fourth[rows, None],
            self.face_fourth[rows, None],
        )


def next_order_of_contact(
    normal_load: float,
    tangential_load: float,
    contact: SymmetricContact,
    modulus: float,
    effects: BodyEffects,
) -> ChangeOfContact:
    """What the next order adds to normal contact under loads P > 0 and Q.

    >>> from scenes import Estimate
    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=4 / np.pi, radius=1.0, datum_length=1.0)  # a^2 = P
    >>> effects = BodyEffects(datum_length=1.0, normal_fourth=Estimate(0.08))
    >>> change = next_order_of_contact(1.0, 0.0, contact, contact.modulus, effects)
    >>> round((1 + change.half_width) ** 2, 5)  # a^2 + 0.08 a^4/8 = 1
    0.9902
    """
    curvature = effects.normal_curvature.value * normal_load
    curvature += effects.normal_curvature_under_shear.value * tangential_load
    fourth = effects.normal_fourth.value * normal_load
    by_curvature = _pressed(normal_load, curvature, 0.0, contact, modulus)
    second = by_curvature.second
    for _ in range(_ROUNDS):
        bend = curvature + 2 * effects.normal_mixed.value * second
        pressed = _pressed(normal_load, bend, fourth, contact, modulus)
        second = pressed.second
    return ChangeOfContact(
        pressed.largest_pressure / by_curvature.largest_pressure - 1,
        pressed.half_width / by_curvature.half_width - 1,
    )


class _Pressed(NamedTuple):
    """a, the largest pressure and p_2 of a contact."""

    half_width: float
    largest_pressure: float
    second: float


def _pressed(
    normal_load: float, curvature: float, fourth: float, contact: SymmetricContact, modulus: float
) -> _Pressed:
    """Contact of a profile with kn x^2/2 + n4 x^4/24 added to the gap."""
    stiffness = np.pi * modulus / 4
    half_width = float(contact.half_width(normal_load))
    for _ in range(_STEPS_OF_NEWTON):
        square = half_width**2
        load = float(contact.load(half_width))
        load += stiffness * (curvature * square + fourth * square**2 / 8)
        rate = float(contact.stiffness(half_width))
        rate += stiffness * half_width * (2 * curvature + fourth * square / 2)
        half_width = max(half_width + (normal_load - load) / rate, half_width / 2)
    angle = (np.arange(_PLACES) + 0.5) * np.pi / 2 / _PLACES
    x = half_width * np.sin(angle)
    root = half_width * np.cos(angle)
    pressure = contact.pressure(x, float(contact.load(half_width)))
    pressure = pressure + modulus / 2 * curvature * root
    pressure = pressure + modulus / 24 * fourth * root * (half_width**2 + 2 * x**2)
    second = 2 * float(np.sum(x**2 * pressure * root)) * np.pi / 2 / _PLACES
    return _Pressed(half_width, float(np.max(pressure)), second)


@dataclass(frozen=True, eq=False)
class _Punches:
    """Flat punches (k,) in ascending order: half-widths, the share dc/c of each, eta, G and G_4."""

    half_width: Array
    share: Array
    load: Array
    parabola: Array
    fourth: Array


@dataclass(frozen=True, eq=False)
class _Course:
    """Work of each step, (n,), over A/pi; p_2 and q_2 at the rows, (n,)."""

    work: Array
    pressure_second: Array
    shear_second: Array


def next_order_works(
    normal_load: Array,
    tangential_load: Array,
    cycles: Sequence[slice],
    contact: SymmetricContact,
    modulus: float,
    friction: float,
    effects: BodyEffects,
) -> list[float]:
    """Work that the next order adds in each cycle.

    Parameters
    ----------
    normal_load, tangential_load
        (n,) P and Q at the rows of a path from rest, in straight steps
    cycles
        rows of each; the first row of a cycle begins its first step
    """
    none = np.zeros(len(normal_load))
    terms = _Terms(
        effects.normal_curvature.value * normal_load
        + effects.normal_curvature_under_shear.value * tangential_load,
        effects.tangential_curvature.value * tangential_load
        + effects.tangential_curvature_under_pressure.value * normal_load,
        none,
        none,
    )
    largest_width = 1.3 * float(contact.half_width(float(np.max(normal_load))))
    punches = _punches(contact, modulus, min(largest_width, contact.extent))
    loads = (normal_load, tangential_load)
    works_without_punches = _course(*loads, friction, punches, terms)
    finer_punches = replace(
        terms,
        gap_curvature=terms.gap_curvature
        + 2 * effects.normal_mixed.value * works_without_punches.pressure_second,
        face_curvature=terms.face_curvature
        + 2 * effects.tangential_mixed.value * works_without_punches.shear_second,
        gap_fourth=effects.normal_fourth.value * normal_load,
        face_fourth=effects.tangential_fourth.value * tangential_load,
    )
    change = _course(*loads, friction, punches, finer_punches).work - works_without_punches.work
    unit = 2 / (np.pi * modulus)
    return [unit * float(np.sum(change[rows][1:])) for rows in cycles]


def _punches(contact: SymmetricContact, modulus: float, largest_width: float) -> _Punches:
    """Evenly spread half-widths."""
    borders = np.linspace(0.0, largest_width, _PUNCHES + 1)
    half_width = (borders[1:] + borders[:-1]) / 2
    load = np.where(half_width > contact.least, contact.load(half_width), 0.0)
    parabola = np.pi * modulus / 4 * half_width**2
    share = np.diff(borders) / half_width
    return _Punches(half_width, share, load, parabola, parabola * half_width**2 / 8)


def _course(
    normal_load: Array, tangential_load: Array, friction: float, punches: _Punches, terms: _Terms
) -> _Course:
    """The memory forces of the punches carried along a path, block by block of its rows."""
    count = len(normal_load)
    work = np.zeros(count)
    seconds = np.zeros((2, count))
    state_before = _Carried.at_rest(punches)
    for begin in range(0, count, _AT_ONCE):
        rows = slice(begin, begin + _AT_ONCE)
        loads = (normal_load[rows, None], tangential_load[rows, None])
        block = _block(*loads, friction, punches, terms.at(rows), state_before)
        work[rows] = block.work
        seconds[:, rows] = block.seconds
        state_before = block.last
    return _Course(work, *seconds)


@dataclass(frozen=True, eq=False)
class _Carried:
    """Of each punch at one row, (k,) each: pi, the force Q - kt G - t4 G_4 of the bound without
    friction, and F.
    """

    beyond: Array
    core: Array
    force: Array

    @classmethod
    def at_rest(cls, punches: _Punches) -> _Carried:
        """Before the first load."""
        none = np.zeros(len(punches.load))
        return cls(-punches.load, none, none)


@dataclass(frozen=True, eq=False)
class _Block:
    """Work of each step, (n,), over A/pi; p_2 and q_2, (2, n); what is carried at the last row."""

    work: Array
    seconds: Array
    last: _Carried


def _block(
    normal_load: Array,
    tangential_load: Array,
    friction: float,
    punches: _Punches,
    terms: _Terms,
    state_before: _Carried,
) -> _Block:
    """Some rows of a path, loads (n, 1) and terms (n, 1), after what was carried `state_before`."""
    of_gap = terms.gap_curvature * punches.parabola + terms.gap_fourth * punches.fourth
    of_faces = terms.face_curvature * punches.parabola + terms.face_fourth * punches.fourth
    beyond = np.vstack([state_before.beyond, normal_load - punches.load - of_gap])  # pi
    core = np.vstack([state_before.core, tangential_load - of_faces])
    pressed = np.maximum(beyond, 0.0)
    touches = beyond[1:] > 0
    is_new = touches & (beyond[:-1] <= 0)
    new_rows, new_punches = np.nonzero(is_new)
    before = (new_rows, new_punches)
    after = (new_rows + 1, new_punches)
    share = beyond[before] / (beyond[before] - beyond[after])
    at_touch = np.zeros_like(of_gap)
    at_touch[before] = core[before] + share * (core[after] - core[before])
    reach = friction * pressed[1:]
    lower = core[1:] - reach
    upper = core[1:] + reach

    forces = np.empty_like(of_gap)
    starts = np.empty_like(of_gap)
    force = state_before.force
    has_new = np.any(is_new, axis=1)
    for row, start in enumerate(starts):
        start[:] = force
        if has_new[row]:
            np.copyto(start, at_touch[row], where=is_new[row])
        force = np.maximum(start, lower[row], out=forces[row])
        np.minimum(force, upper[row], out=force)

    mean_beyond = (pressed[1:] + pressed[:-1]) / 2
    moved_force = np.where(touches, np.abs(forces - starts), 0.0)
    work = friction * ((mean_beyond * moved_force) @ punches.share)
    arm = punches.half_width**2 / 2
    arm_falls = arm - np.append(arm[1:], 0.0)
    carried_load = np.where(touches, punches.load + of_gap, normal_load)
    shear = np.where(touches, forces + of_faces, tangential_load)
    # int arm d(carried), in which carried is 0 at the middle: summed by parts
    seconds = np.stack([carried_load @ arm_falls, shear @ arm_falls])
    last_state = _Carried(beyond[-1], core[-1], forces[-1])
    return _Block(work, seconds, last_state)
