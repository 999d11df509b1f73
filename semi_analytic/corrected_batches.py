"""Friction work W of steady cycles of elliptic loads with the effects of finite bodies, for arrays
of ellipses at once.

A flat punch of half-width c keeps its tangential force F while it sticks (the locked-in force). F
lies between two sinusoids of time, the Coulomb bounds B of `corrected_memory`, while the punch is
in contact. A bound that meets F carries it along; in between F stands still: a play operator. With
the normal load that is carried outside of the punch, L = P - eta - kn G,

    W = (A/pi) int w(c) dc/c,    w = closed-int f L |dF|

Between two instants at which a bound turns round both bounds move one way, F ends at the bound that
it meets, and w has a primitive: no time steps. A punch that comes into contact starts with F where
both bounds meet; one that always is in contact starts at the end of its forward slip.

# notation: c half-width of a punch, eta and G normal loads of the flat punches up to c: of the
#           profile, and of a parabola x^2/2; s = +1 forward, -1 reverse slip, A = 2/E*
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from scenes.array_types import Array
from semi_analytic.corrected_memory import Curvatures
from semi_analytic.profiles import SymmetricContact

# Gauss nodes in each of two ranges of punches. At other punches, where slip changes from one kind
# to another, w has a kink: these leave 2e-5 of W.
_GAUSS_NODE_COUNT = 32
# Iterations of the Illinois rule at most, and the residual at which it ends, over the value scale.
_MOST_SECANTS = 40
_RESIDUAL_OF_ROOT = 1e-13
# Fraction of a value at the other end of a bracket below which one is round-off.
_ROUND_OFF_VALUE_SHARE = 1e-9
_SMALLEST_FLOAT = float(np.finfo(float).tiny)
# Ellipses that are taken at once: bounds the memory of arrays (m, punches).
_ELLIPSES_AT_ONCE = 2048


@dataclass(frozen=True, eq=False)
class EllipseOfLoads:
    """Elliptic load paths P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase) [force per thickness],
    and the friction coefficient f.

    Each attribute is a column (m, 1) over m ellipses: P0, P1, Q0, Q1, the phase [rad] and f.
    """

    mean_normal: Array
    normal_amplitude: Array
    mean_tangential: Array
    tangential_amplitude: Array
    phase: Array
    friction: Array

    def take(self, members: slice) -> EllipseOfLoads:
        """Only the ellipses `members`."""
        return EllipseOfLoads(
            *(getattr(self, record_field.name)[members] for record_field in fields(self))
        )

    def divided_by(self, unit: Array) -> EllipseOfLoads:
        """The same ellipses with their loads divided by `unit` (m, 1)."""
        return replace(
            self,
            mean_normal=self.mean_normal / unit,
            normal_amplitude=self.normal_amplitude / unit,
            mean_tangential=self.mean_tangential / unit,
            tangential_amplitude=self.tangential_amplitude / unit,
        )

    def load_combination(
        self, *, normal_factor: Array, tangential_factor: Array, constant: Array
    ) -> _Sinusoid:
        """Weighted sums of the loads on m elliptic load paths, `normal_factor` P +
        `tangential_factor` Q + `constant`, as sinusoids of the phase angle t of the cycle.

        On each ellipse P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase); the attributes P0 to Q1
        and `phase` are columns (m, 1). The factors and the constant are (m, k), for k sums on each
        ellipse; so are mean, amplitude and phase of the sinusoids.
        """
        # Components along cos t and sin t; the constant part is the mean.
        tangential_part_amplitude = tangential_factor * self.tangential_amplitude
        cosine_component = (
            normal_factor * self.normal_amplitude + tangential_part_amplitude * np.cos(self.phase)
        )
        sine_component = tangential_part_amplitude * np.sin(self.phase)
        mean = (
            normal_factor * self.mean_normal + tangential_factor * self.mean_tangential + constant
        )
        return _Sinusoid(
            mean,
            np.hypot(cosine_component, sine_component),
            np.arctan2(sine_component, cosine_component),
        )


class CurvatureColumns(NamedTuple):
    """Curvatures that finite bodies add to half-planes per unit of load, a column (m, 1) each over
    m ellipses [1/(stress length^2)].

    Attributes
    ----------
    normal, normal_under_shear
        N, N_Q of the gap per unit of P and of Q
    tangential, tangential_under_pressure
        T, T_P of the tangential displacement of the faces per unit of Q and of P
    """

    normal: Array
    normal_under_shear: Array
    tangential: Array
    tangential_under_pressure: Array

    @classmethod
    def from_curvatures(cls, curvatures: Curvatures, factor: Array) -> CurvatureColumns:
        """The same curvatures for all ellipses, times `factor` (m, 1), their change of units."""
        return cls(
            normal=curvatures.normal * factor,
            normal_under_shear=curvatures.normal_under_shear * factor,
            tangential=curvatures.tangential * factor,
            tangential_under_pressure=curvatures.tangential_under_pressure * factor,
        )

    def take(self, members: slice) -> CurvatureColumns:
        """Those of the ellipses `members`."""
        return CurvatureColumns(*(column[members] for column in self))


class _Sinusoid(NamedTuple):
    """mean + amplitude cos(t - phase) over the phase angle t of a cycle, (m, k) each."""

    mean: Array
    amplitude: Array
    phase: Array

    def values_at(self, angle: Array) -> Array:
        """Values at the phase angles t, (m, k) [rad]."""
        return np.asarray(self.mean + self.amplitude * np.cos(angle - self.phase))


class CycleOfPunches(NamedTuple):
    """Coulomb bounds and normal load outside of flat punches in a steady cycle: sinusoids of its
    phase angle, for k punches under each of m ellipses, (m, k).

    Attributes
    ----------
    forward_bound
        B_+, lower bound of the locked-in tangential force, which rises with it in forward slip
    reverse_bound
        -B_-, minus the upper bound of that force, which falls with it in reverse slip
    load_outside
        normal load that is carried outside of a punch
    """

    forward_bound: _Sinusoid
    reverse_bound: _Sinusoid
    load_outside: _Sinusoid


def cycle_of_punches(
    loads: EllipseOfLoads, curvatures: CurvatureColumns, profile_load: Array, parabola_load: Array
) -> CycleOfPunches:
    """Coulomb bounds of forward and of reverse slip of flat punches over a steady cycle, and the
    normal load that is carried outside of each punch. (m, k): k punches under each of m ellipses.

        s B_s = s (Q - kt G) - f (P - eta - kn G),    s = +1 forward, -1 reverse
        kn = N P + N_Q Q,    kt = T Q + T_P P

    kn x^2/2 and kt x^2/2 are what finite bodies add to the gap and to the tangential displacement
    of the faces. The bounds hold for the tangential force that a punch keeps while it sticks. E* is
    the composite modulus.

    Parameters
    ----------
    loads
        P and Q of m ellipses
    curvatures
        N, N_Q, T and T_P
    profile_load
        eta (m, k): normal load that presses the profile into contact up to each punch
    parabola_load
        G = (pi E*/4) c^2 (m, k): normal load that presses a parabola of curvature 1 into contact
        up to each punch

    Returns
    -------
    CycleOfPunches
        B_+, -B_- and the load P - eta - kn G outside of the punches, as sinusoids
    """
    friction = loads.friction
    # kn G = gap_load_per_normal P + gap_load_per_tangential Q, and so on for kt G of the faces.
    gap_load_per_normal = parabola_load * curvatures.normal
    gap_load_per_tangential = parabola_load * curvatures.normal_under_shear
    faces_load_per_tangential = parabola_load * curvatures.tangential
    faces_load_per_normal = parabola_load * curvatures.tangential_under_pressure
    # Sums of P and Q with constant factors: sinusoids of the phase angle.
    forward_bound = loads.load_combination(
        normal_factor=-friction * (1 - gap_load_per_normal) - faces_load_per_normal,
        tangential_factor=1 - faces_load_per_tangential + friction * gap_load_per_tangential,
        constant=friction * profile_load,
    )
    reverse_bound = loads.load_combination(
        normal_factor=-friction * (1 - gap_load_per_normal) + faces_load_per_normal,
        tangential_factor=faces_load_per_tangential - 1 + friction * gap_load_per_tangential,
        constant=friction * profile_load,
    )
    load_outside = loads.load_combination(
        normal_factor=1 - gap_load_per_normal,
        tangential_factor=-gap_load_per_tangential,
        constant=-profile_load,
    )
    return CycleOfPunches(forward_bound, reverse_bound, load_outside)


class WorkOfEllipses(NamedTuple):
    """Results for m steady cycles, (m,) each.

    Attributes
    ----------
    forward_work, reverse_work
        friction work W of forward and of reverse slip, times pi/A = pi E*/2
    permanent_stick_half_width
        half-width of permanent stick, 0 where no point sticks all through [length]
    """

    forward_work: Array
    reverse_work: Array
    permanent_stick_half_width: Array


def works_of_ellipses(
    loads: EllipseOfLoads,
    curvatures: CurvatureColumns,
    contact: SymmetricContact,
    modulus: float,
) -> WorkOfEllipses:
    """Friction work of forward and of reverse slip in a steady cycle, and half-width of permanent
    stick, for m elliptic load paths on one profile, (m,) each. Works are times pi/A = pi E*/2.

    Finite bodies add `curvatures` to gap and faces. Values are NaN where the contact is wider than
    the profile or than twice that of half-planes, or would split. The half-width is 0 where no
    point sticks all through. The loads must not slide the contact as a whole: W then has no
    meaning. 2048 ellipses are taken at once.

    Parameters
    ----------
    loads
        P and Q of m ellipses, and f
    curvatures
        N, N_Q of the gap and T, T_P of the faces, (m, 1) each
    contact
        normal contact of the profile
    modulus
        E* [stress], in the units of `contact`

    Examples
    --------

    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=1.0, radius=1.0, datum_length=1.0)
    >>> one, half = np.ones((1, 1)), np.full((1, 1), 0.5)
    >>> loads = EllipseOfLoads(one, 0 * one, 0 * one, half, 0 * one, one)
    >>> no_curvatures = CurvatureColumns.from_curvatures(Curvatures(), one)
    >>> work = works_of_ellipses(loads, no_curvatures, contact, 1.0)
    >>> round(
    ...     float(work.forward_work[0] + work.reverse_work[0]), 5
    ... )  # -2 int (2 z - 1/2) ln(1 - z) dz
    0.05685
    """
    n_ellipses = len(loads.friction)
    works_and_stick = np.empty((3, n_ellipses))
    for first_ellipse in range(0, n_ellipses, _ELLIPSES_AT_ONCE):
        block = slice(first_ellipse, first_ellipse + _ELLIPSES_AT_ONCE)
        works_and_stick[:, block] = _works_and_stick(
            loads.take(block), curvatures.take(block), contact, modulus
        )
    return WorkOfEllipses(*works_and_stick)


def _works_and_stick(
    loads: EllipseOfLoads,
    curvatures: CurvatureColumns,
    contact: SymmetricContact,
    modulus: float,
) -> Array:
    """Friction work of forward and of reverse slip, times pi/A = pi E*/2, and half-width of
    permanent stick, (3, m), for all m ellipses at once.

    They are NaN where the contact is wider than the profile or than twice that of half-planes, or
    would split.
    The work is the integral of w(c) dc/c over the flat punches that slip. Their half-widths c lie
    between permanent stick and the largest contact. Each punch goes through the cycle by itself.

    Parameters
    ----------
    loads
        P and Q of m ellipses, and f
    curvatures
        N, N_Q of the gap and T, T_P of the faces, (m, 1) each
    contact
        normal contact of the profile; `least_half_width` is that of its flat, `extent` its end
    modulus
        E* [stress]
    """
    punches = _Punches(loads, curvatures, contact, modulus)
    edges_of_cycle = _edges_of_cycle(punches)
    works = _works_of_forward_and_reverse_slip(punches, edges_of_cycle)
    # dP/da must be positive, and the profile wide enough.
    least_stiffness = _least_stiffness_at_edge(
        loads, curvatures, contact, modulus, edges_of_cycle.contact_edge
    )
    is_refused = ~(least_stiffness[:, 0] > 0) | np.isnan(edges_of_cycle.least_contact_edge[:, 0])
    works[:, is_refused] = np.nan
    return np.stack([*works, np.where(is_refused, np.nan, edges_of_cycle.stick_edge[:, 0])])


class _Punches(NamedTuple):
    """The flat punches that make up the contacts of m elliptic load paths on one profile.

    Three functions of the half-width of a punch rise through 0 at an edge of a cycle: of the
    largest contact, of the least contact, of permanent stick. They take half-widths (m, k) and give
    values (m, k).

    Attributes
    ----------
    loads
        P and Q of m ellipses, and f
    curvatures
        N, N_Q of the gap and T, T_P of the faces, (m, 1) each
    contact
        normal contact of the profile; `least_half_width` is that of its flat
    modulus
        E* [stress]
    """

    loads: EllipseOfLoads
    curvatures: CurvatureColumns
    contact: SymmetricContact
    modulus: float

    def cycle_at(self, half_width: Array) -> CycleOfPunches:
        """Coulomb bounds and load outside over the cycle, of punches of these half-widths."""
        profile_load = np.where(
            half_width > self.contact.least_half_width, self.contact.load(half_width), 0.0
        )
        parabola_load = math.pi * self.modulus / 4 * half_width**2
        return cycle_of_punches(self.loads, self.curvatures, profile_load, parabola_load)

    def minus_largest_load_outside(self, half_width: Array) -> Array:
        """Minus the largest normal load outside of a punch in the cycle: the punch touches while
        that load is positive.
        """
        load_outside = self.cycle_at(half_width).load_outside
        return -(load_outside.mean + load_outside.amplitude)

    def minus_least_load_outside(self, half_width: Array) -> Array:
        """Minus the least normal load outside of a punch in the cycle."""
        load_outside = self.cycle_at(half_width).load_outside
        return load_outside.amplitude - load_outside.mean

    def overlap_of_bounds(self, half_width: Array) -> Array:
        """max(B_+) - min(B_-) of the Coulomb bounds in the cycle: if positive, no force that a
        punch locks in stays between them all through.
        """
        forward_bound, reverse_bound, _ = self.cycle_at(half_width)
        return (
            forward_bound.mean
            + forward_bound.amplitude
            + reverse_bound.mean
            + reverse_bound.amplitude
        )


class _EdgesOfCycle(NamedTuple):
    """Half-widths in a cycle, (m, 1) each [length]: of the largest and of the least contact, and of
    permanent stick, 0 where no point sticks all through. NaN where the contact would be wider than
    the profile or than twice that of half-planes.
    """

    contact_edge: Array
    least_contact_edge: Array
    stick_edge: Array


def _edges_of_cycle(punches: _Punches) -> _EdgesOfCycle:
    """Edges of the largest and of the least contact, and of permanent stick, in the cycles of m
    elliptic load paths.

    A contact ends at the flat punch outside of which no load is carried. Permanent stick ends at
    the punch whose two Coulomb bounds, over the cycle, just leave room for a constant force. Both
    are roots, sought up to twice the largest contact of half-planes, or to the end of the profile,
    `extent`.
    """
    loads = punches.loads
    largest_load = loads.mean_normal + loads.normal_amplitude
    largest_half_width = np.minimum(
        punches.contact.half_width(largest_load) * 2, punches.contact.extent
    )
    no_half_width = np.zeros_like(largest_half_width)
    contact_edge = _roots_between(
        punches.minus_largest_load_outside, no_half_width, largest_half_width
    )
    least_contact_edge = _roots_between(
        punches.minus_least_load_outside, no_half_width, contact_edge
    )
    stick_edge = _roots_between(punches.overlap_of_bounds, no_half_width, contact_edge)
    return _EdgesOfCycle(contact_edge, least_contact_edge, np.minimum(stick_edge, contact_edge))


def _works_of_forward_and_reverse_slip(punches: _Punches, edges_of_cycle: _EdgesOfCycle) -> Array:
    """Friction work of forward and of reverse slip, times pi/A = pi E*/2, (2, m). It is the
    integral of w(c) dc/c over the punches of half-width c from permanent stick to the largest
    contact.

    w(c) is the work of a punch. Punches beyond the edge of the least contact open in a part of the
    cycle: w has a kink there, at which the range is divided. E* is the composite modulus, A = 2/E*.
    """
    works = np.zeros((2, len(edges_of_cycle.contact_edge)))
    node_fractions, node_weights = _crowded_gauss_rule()
    kink_half_width = np.clip(
        edges_of_cycle.least_contact_edge, edges_of_cycle.stick_edge, edges_of_cycle.contact_edge
    )
    for inner_edge, length_of_range in (
        (edges_of_cycle.stick_edge, kink_half_width - edges_of_cycle.stick_edge),
        (kink_half_width, edges_of_cycle.contact_edge - kink_half_width),
    ):
        half_width = inner_edge + length_of_range * node_fractions
        work_of_punches = _work_of_punches(punches.cycle_at(half_width), punches.loads.friction)
        # _SMALLEST_FLOAT: smallest positive number, against division by 0
        works += np.sum(
            work_of_punches
            * (node_weights * length_of_range / np.maximum(half_width, _SMALLEST_FLOAT)),
            axis=2,
        )
    return works


def _crowded_gauss_rule() -> tuple[Array, Array]:
    """Nodes and weights (k,) of a rule on 0 to 1 whose nodes crowd at both ends, where slip begins
    like a square root: Gauss' rule over g, at g^2 (3 - 2 g).
    """
    nodes, gauss_weights = np.polynomial.legendre.leggauss(_GAUSS_NODE_COUNT)
    g = (1 + nodes) / 2
    return g**2 * (3 - 2 * g), gauss_weights / 2 * 6 * g * (1 - g)


def _least_stiffness_at_edge(
    loads: EllipseOfLoads,
    curvatures: CurvatureColumns,
    contact: SymmetricContact,
    modulus: float,
    contact_edge: Array,
) -> Array:
    """Lower bound over the cycle of dP/da at the edge of the largest contact, (m, 1) [stress]; the
    contact would split where it is not positive.

    kn = N P + N_Q Q, the curvature that the bodies add to the gap, adds kn dG/da = (pi E*/2) kn a.
    G = (pi E*/4) a^2 is the load of the flat punches of the gap x^2/2.
    A lower bound of kn is used: the least N P over the cycle, or 0 if that is positive, minus the
    largest |N_Q Q|.

    Parameters
    ----------
    loads
        P and Q of m ellipses
    curvatures
        N as `normal` and N_Q as `normal_under_shear`, (m, 1) each
    contact
        normal contact of the profile; `stiffness` is dP/da
    modulus
        E* [stress]
    contact_edge
        (m, 1) half-width a of the largest contact [length]
    """
    largest_load = loads.mean_normal + loads.normal_amplitude
    least_load = loads.mean_normal - loads.normal_amplitude
    least_curvature = np.minimum(
        curvatures.normal * np.where(curvatures.normal < 0, largest_load, least_load), 0.0
    )
    largest_tangential_load = np.abs(loads.mean_tangential) + loads.tangential_amplitude
    least_curvature = (
        least_curvature - np.abs(curvatures.normal_under_shear) * largest_tangential_load
    )
    return np.asarray(
        contact.stiffness(contact_edge) + math.pi * modulus / 2 * least_curvature * contact_edge
    )


def _roots_between(
    function: Callable[[Array], Array], lower_bound: Array, upper_bound: Array
) -> Array:
    """Roots x (m, 1) of m rising functions between `lower_bound` and `upper_bound` (m, 1), by the
    Illinois rule: secants that keep the root between them.

    The lower bound where a function is positive there. NaN where it is negative at the upper one,
    by more than 1e-9 of its larger value at the bounds (round-off). The secants end where all
    values are at most 1e-13 of the larger one at the bounds, or after 40 of them. `function` gives
    the values (m, 1) of all functions at x (m, 1).
    """
    value_at_lower_bound = function(lower_bound)
    value_at_upper_bound = function(upper_bound)
    value_scale = np.maximum(np.abs(value_at_lower_bound), np.abs(value_at_upper_bound))
    has_no_root = value_at_upper_bound < -_ROUND_OFF_VALUE_SHARE * value_scale
    last_sign = np.zeros(lower_bound.shape)
    x = lower_bound

    # 40 secants at most; residual 1e-13 of the larger value at the bounds.
    for _ in range(_MOST_SECANTS):
        # Secant through both bounds, kept between them.
        value_difference = np.where(
            value_at_upper_bound > value_at_lower_bound,
            value_at_upper_bound - value_at_lower_bound,
            1.0,
        )
        x = np.clip(
            lower_bound - value_at_lower_bound * (upper_bound - lower_bound) / value_difference,
            lower_bound,
            upper_bound,
        )
        value_at_x = function(x)
        is_converged = np.abs(value_at_x) <= _RESIDUAL_OF_ROOT * value_scale
        if np.all(is_converged | has_no_root | (value_at_lower_bound >= 0)):
            break
        is_positive = value_at_x > 0
        # Where the same end moves twice, half the value at the other end (Illinois).
        value_at_lower_bound = np.where(
            is_positive & (last_sign > 0), value_at_lower_bound / 2, value_at_lower_bound
        )
        value_at_upper_bound = np.where(
            ~is_positive & (last_sign < 0), value_at_upper_bound / 2, value_at_upper_bound
        )
        upper_bound = np.where(is_positive, x, upper_bound)
        value_at_upper_bound = np.where(is_positive, value_at_x, value_at_upper_bound)
        lower_bound = np.where(is_positive, lower_bound, x)
        value_at_lower_bound = np.where(is_positive, value_at_lower_bound, value_at_x)
        last_sign = np.where(is_positive, 1.0, -1.0)
    return np.where(has_no_root, np.nan, x)


def _work_of_punches(sinusoids: CycleOfPunches, friction: Array) -> Array:
    """Friction work w of flat punches over one steady cycle, in forward and in reverse slip, (2, m,
    k) [force^2 per thickness^2].

    w is the closed integral of f L |dF|; the dissipation W is A times the integral of w dc/(pi c)
    over the half-width c of the punches, A = 2/E*.

    Each of m elliptic load paths, P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase), has k punches.
    L is the normal load that is carried outside of a punch, and F the tangential force that the
    punch keeps while it sticks. F stays between the Coulomb bounds B_+ and B_-:

        s B_s = s (Q - kt G) - f L,    s = +1 in forward slip, -1 in reverse slip

    While L > 0, s F is raised to s B_s whenever that exceeds it, and the punch slips. kt x^2/2 is
    what finite bodies add to the tangential displacement of the faces. G is the normal load that
    presses a parabola x^2/2 to half-width c.

    Parameters
    ----------
    sinusoids
        s B_s for s = +1 and -1, and L, as sinusoids of the phase angle t through the cycle:
        `mean` + `amplitude` cos(t - `phase`), (m, k) each
    friction
        f (m, 1)
    """
    forward_bound, reverse_bound, load_outside = sinusoids
    # Phase angles: at which the cycle of a punch is begun, and over which the punch is in contact.
    begin_angle, contact_angle = _contact_angles(sinusoids)
    # F is B_+ at the former.
    locked_in_force = forward_bound.values_at(begin_angle)
    works = np.zeros((2, *begin_angle.shape))

    # From turning point to turning point, until contact ends: int L dB while the rising bound B =
    # s B_s takes s F with it, from the s F before to the bound at the angle.
    angles_since_begin = _turning_angles_since(begin_angle, contact_angle, sinusoids)
    for turning_angle in (*(begin_angle + angles_since_begin), begin_angle + contact_angle):
        for row_of_direction, direction, coulomb_bound in (
            (0, 1.0, forward_bound),
            (1, -1.0, reverse_bound),
        ):
            bound_at_angle = coulomb_bound.values_at(turning_angle)
            is_slipping = bound_at_angle > direction * locked_in_force
            # int L dB along the rising bound up to each value of it; the constant falls out
            integral_to_angle = _load_integral(coulomb_bound, load_outside, bound_at_angle)
            integral_to_force = _load_integral(
                coulomb_bound, load_outside, direction * locked_in_force
            )
            works[row_of_direction] += np.where(
                is_slipping, integral_to_angle - integral_to_force, 0.0
            )
            locked_in_force = np.where(is_slipping, direction * bound_at_angle, locked_in_force)
    return np.asarray(friction * np.maximum(works, 0.0))


def _contact_angles(sinusoids: CycleOfPunches) -> tuple[Array, Array]:
    """Phase angle t at which the cycle of a punch is begun, and the angle over which the punch is
    in contact after it, (m, k) each [rad].

    A punch that is always in contact begins at the maximum of the Coulomb bound B_+. Another one
    begins where its contact does, where both bounds meet: it is in contact within an angle of the
    largest load outside of it, or never (0).
    """
    load_outside = sinusoids.load_outside
    # _SMALLEST_FLOAT: smallest positive number, against division by 0
    cosine_of_opening = np.clip(
        -load_outside.mean / np.maximum(load_outside.amplitude, _SMALLEST_FLOAT), -1.0, 1.0
    )
    opening_angle = np.arccos(cosine_of_opening)
    is_always_closed = load_outside.mean >= load_outside.amplitude
    begin_angle = np.where(
        is_always_closed, sinusoids.forward_bound.phase, load_outside.phase - opening_angle
    )
    return begin_angle, np.where(is_always_closed, 2 * math.pi, 2 * opening_angle)


def _turning_angles_since(
    begin_angle: Array, contact_angle: Array, sinusoids: CycleOfPunches
) -> Array:
    """Angles from the begin of the cycle of a punch to the largest and the least values of both its
    Coulomb bounds, ascending, (4, m, k) [rad].

    An angle beyond the end of contact is that of the end. Between the angles each bound is
    monotonic. `begin_angle` and `contact_angle` (m, k) are the phase angle of the begin, and the
    angle over which the punch is in contact.
    """
    forward_phase = sinusoids.forward_bound.phase
    reverse_phase = sinusoids.reverse_bound.phase
    turning_angles = np.stack(
        [forward_phase, forward_phase + math.pi, reverse_phase, reverse_phase + math.pi]
    )
    angles_since_begin = np.minimum(
        np.mod(turning_angles - begin_angle, 2 * math.pi), contact_angle
    )
    angles_since_begin.sort(axis=0)
    return angles_since_begin


def _load_integral(coulomb_bound: _Sinusoid, load_outside: _Sinusoid, bound_value: Array) -> Array:
    """Integral of the normal load outside of flat punches over their rising Coulomb bound B, up to
    where the bound is `bound_value` [force^2 per thickness^2].

        int L dB = A [p cos(theta) + b (cos(D) cos^2(theta)/2
                                        - sin(D) (theta - sin(theta) cos(theta))/2)]

    Arrays are (m, k): k flat punches under each of m ellipses of loads. L is the normal load that
    the wider flat punches carry. Only differences of the integral count: the constant is left out.

    In the phase angle t of the cycle B = B_0 + A cos(t - t_B) and L = p + b cos(t - t_L). B_0 and p
    are means, A and b amplitudes, t_B and t_L phases of `coulomb_bound` and `load_outside`. While B
    rises it is at the angle theta = t_B - t before its maximum, from 0 to pi; D = t_B - t_L.
    """
    # A bound that does not vary is divided by as well; its integral is 0 by the last factor.
    # _SMALLEST_FLOAT: smallest positive number.
    positive_amplitude = np.maximum(coulomb_bound.amplitude, _SMALLEST_FLOAT)
    cosine = np.clip((bound_value - coulomb_bound.mean) / positive_amplitude, -1.0, 1.0)
    sine = np.sqrt(1 - cosine**2)
    theta = np.arccos(cosine)
    phase_difference = coulomb_bound.phase - load_outside.phase
    in_phase_term = np.cos(phase_difference) * cosine**2
    out_of_phase_term = np.sin(phase_difference) * (theta - sine * cosine)
    varying_load_term = load_outside.amplitude * (in_phase_term - out_of_phase_term) / 2
    return np.asarray(coulomb_bound.amplitude * (load_outside.mean * cosine + varying_load_term))
