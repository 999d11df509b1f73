"""Memory curve of two half-planes to which finite bodies add curvature that follows the loads.

The bodies add kn x^2/2 to the gap and kt x^2/2 to the tangential displacement of the faces, with
kn = N P + N_Q Q and kt = T Q + T_P P. A parabola is a superposition of flat punches too: its share
up to half-width c is G(c) = (pi E*/4) c^2 per unit of curvature, eta(c) = P(c) that of the profile.

Derivation. With A = 2/E* a punch of half-width c under the force m displaces x > c by (A/pi) m
arccosh(x/c) less than its middle.

- Normal contact: P = eta(a) + kn G(a). Of this load eta(c) + kn G(c) is carried within c.
- Stick: the slip of a point stands still. Punches m(c) = kt dG/dc displace x by kt x^2/2, so that
  F(c) = M(c) - kt G(c) does not change while c sticks; M(c) is the force carried within c.
- Slip of sense s from c to a: |q| = f p there, M(c) = Q - s f [P - eta(c) - kn G(c)], hence
  F(c) = B_s(c) = (Q - s f P) + s f eta(c) + (s f kn - kt) G(c).
- At c = a both B meet at Q - kt G(a): the value of F where the contact grows in stick.

So F(c) is clipped by two bounds that follow the loads, each c for itself. On a straight step P, Q,
kn and kt are linear, the bounds move one way each, and one clip at the end of the step is exact.
With kn = kt = 0 this is `memory`, where F = M.

The next order. A body's kernel k_nn(x, s) has after N (x^2 + s^2)/2 the terms N_4 (x^4 + s^4)/24 +
N_22 x^2 s^2, and k_tt likewise with T. Under tractions that are even in x they add::

    gap    n4 x^4/24 + (2 N_22 p_2) x^2/2        n4 = N_4 P, p_2 = int x^2 p dx
    faces  t4 x^4/24 + (2 T_22 q_2) x^2/2        t4 = T_4 Q, q_2 = int x^2 q dx

The second terms are in kn and kt. Those of x^4/24 are punches too, which carry G_4(c) = G(c) c^2/8
up to half-width c: above, n4 G_4 goes with kn G and t4 G_4 with kt G, so that

    P = eta(a) + kn G(a) + n4 G_4(a),    F(c) = M(c) - kt G(c) - t4 G_4(c),
    F(c) = B_s(c) = (Q - s f P) + s f eta(c) + (s f kn - kt) G(c) + (s f n4 - t4) G_4(c)

Work. W = (A/pi) int f [P - eta - kn G - n4 G_4] |dF| dc/c over the punches that slip, all terms
positive, with the mean of the bracket over the part of the step in which the punch slips: exact of
a straight step. It equals the closed integral of Q dU + P d(approach), since the compliances are
reciprocal.

Exact are P(a), the pressure, and any history in which the slip zone reaches the edge of contact.
Two things are not: growth in stick is a chord between two instants of the path, and where a stroke
of slip ends smoothly, points next to the edge may come to rest before points further in. For a
moment the slip zone is a ring, in which q = f p is met by its resultant only: |q| - f p is of
second order in kn and kt there, which `inner_slip` takes away in the fields. Tilt and strain of the
bodies are not in here.

# notation: c half-width of a punch, a that of the contact, f friction coefficient, s = +1 forward,
#           -1 reverse slip, P - eta - kn G - n4 G_4 load carried beyond c
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.array_types import Array, Indices
from semi_analytic.profiles import SymmetricContact

# Cells of the table between two kinks of the profile: cubics leave 1e-12 of a load at 512, 4e-9
# at 64.
_CELLS_PER_INTERVAL, _FEWEST_CELLS_PER_INTERVAL = 512, 64
_MOST_CELLS = 4096
_BISECTION_COUNT = 60
# Of many edges of contact at once: bisection to an eighth of a cell, then Newton's method, which
# halves the error four times at worst before it squares it.
_FIRST_BISECTIONS, _NEWTON_STEPS_AFTER_BISECTION = 12, 6
# Newton's method from edges of contact that are known to 1e-3.
_NEWTON_STEPS_FROM_KNOWN_EDGE = 2
_MOST_NEWTON_STEPS = 60
# Fraction of f P below which a difference of forces is round-off. A steady cycle slips along the
# line of the cycle before: differences of the two are sums over all pieces of the curve, and reach
# a few 1e-13. Taken for slip they move the edge of stick to an older piece.
_ROUND_OFF_FORCE_SHARE = 1e-11
# Punches at which the memory curves of two instants are compared, and the fraction of f P by which
# they may differ and be the same state.
_PUNCHES_COMPARED = 200
_STEADY_FORCE_SHARE = 1e-9
# Fraction of the largest half-width that stands for 0 in a logarithm.
_LEAST_HALF_WIDTH_SHARE = 1e-9
# Iterations of p_2 and the edge of contact: at most, and until the load that they still move is
# this fraction of P. p_2 changes by a per cent in all.
_MOST_MOMENT_ITERATIONS = 8
_LOAD_SHARE_MOVED_BY_MOMENT = 1e-12
_GAUSS_RULE_OF_CELL = np.polynomial.legendre.leggauss(3)
# Between two tops of a memory curve: |dF| is a cubic in s there for Hertz.
_GAUSS_RULE_OF_WORK = np.polynomial.legendre.leggauss(8)


def area_of_loop(load: Array, movement: Array) -> float:
    """Work of a load over its displacement `movement`, both (n,) at successive instants, by the
    trapezoidal rule [energy per thickness]; of a closed cycle the area of the loop.
    """
    mean_load = (load[1:] + load[:-1]) / 2
    return float(np.sum(mean_load * np.diff(movement)))


# ---------------------------------------------------------------------------------- flat punches
# Three numbers: of the flat punches of the profile, of x^2/2 and of x^4/24.
LoadTriple = tuple[float, float, float]


class PunchLoads(NamedTuple):
    """Loads eta, G and G_4 that press the profile, x^2/2 and x^4/24 into contact up to the
    half-width at one coordinate s, and their derivatives with respect to s.
    """

    profile_load: float
    parabola_load: float
    fourth_load: float
    load_rate: float
    parabola_rate: float
    fourth_rate: float

    @property
    def loads(self) -> LoadTriple:
        """eta, G and G_4."""
        return self.profile_load, self.parabola_load, self.fourth_load


class PunchSums(NamedTuple):
    """Integrals over the flat punches of half-width up to c: int ln(2 L/c) d eta and int ln(2 L/c)
    dG; int (c^2/2) d eta and int (c^2/2) dG.
    """

    logarithm: float
    parabola_logarithm: float
    second_moment: float
    parabola_second_moment: float


class PunchMoments(NamedTuple):
    """Integrals int w d eta, int w dG and int w dG_4 over the flat punches up to each of k, (k,)
    each; w(c) is a value of a punch of half-width c under unit load, such as a moment.
    """

    profile_integral: Array
    parabola_integral: Array
    fourth_integral: Array


class PunchTable:
    """Loads and integrals of the flat punches of half-width up to c, over a coordinate s of c.

    The profile has kinks, jumps of slope or curvature, at half-widths b. Between two of them c = b
    + (b' - b) sigma^2: then P(a) over sigma has no square root at the kink. s is the number of
    kinks passed plus sigma.

    Attributes
    ----------
    largest_s
        s of the widest punch of the table
    parabola_stiffness
        pi E*/4: G(c) over c^2 [stress]
    """

    def __init__(
        self, contact: SymmetricContact, modulus: float, largest_half_width: float
    ) -> None:
        """Tabulate the normal load eta(c) = P(a = c) of a contact on half-planes [force per
        thickness], for half-widths c from 0 to `largest_half_width` [length].

        The kinks of the profile divide this range into intervals, and each interval is divided into
        equal cells of the coordinate s. eta, int eta dc/c and int eta G dc/c are cubics on each
        cell. Loads of x^2/2 and of x^4/24 need no table: they are closed forms.

        Parameters
        ----------
        contact
            P(a) of the profile on half-planes
        modulus
            E* [stress]
        """
        self._divide_into_intervals(contact, largest_half_width)
        self.parabola_stiffness = math.pi * modulus / 4
        # Coefficients of a cubic in each cell, constant first; as lists too, which are faster for
        # one s.
        self._load_cubics = self._cubics_of_loads(contact)
        self._load_coefficients: list[list[float]] = self._load_cubics.tolist()

        # int eta dc/c and int eta G dc/c: by parts they give int ln(2 L/c) over d eta and d(eta G).
        self._load_integral_cubics = self._integral_cubics(exponent=0)
        self._load_parabola_integral_cubics = self._integral_cubics(exponent=1)
        self._load_integral_coefficients: list[list[float]] = self._load_integral_cubics.tolist()
        self._load_parabola_integral_coefficients: list[list[float]] = (
            self._load_parabola_integral_cubics.tolist()
        )

    def _divide_into_intervals(self, contact: SymmetricContact, largest_half_width: float) -> None:
        """Divide the half-widths of flat punches, from 0 to the largest [length], into intervals
        between the kinks of the profile, and these into cells.

        Cells are equal steps of a coordinate s. It grows with the half-width and is a whole number
        at each kink. The kinks are the end of the flat part, `least_half_width`, 0 without one, and
        the corners, where the slope or the curvature of the profile jumps.
        """
        kinks = [contact.least_half_width, *contact.corner_half_widths]
        inner_kinks = sorted({kink for kink in kinks if 0 < kink < largest_half_width})
        # half-widths c of the kinks; s of each is its index
        self._interval_ends = np.array([0.0, *inner_kinks, largest_half_width])
        self._interval_begins: list[float] = self._interval_ends[:-1].tolist()
        self._interval_lengths: list[float] = np.diff(self._interval_ends).tolist()
        n_intervals = len(self._interval_lengths)
        self.largest_s = float(n_intervals)
        # at most 512 cells an interval and 4096 in all, but at least 64 an interval
        self._cells_per_interval = max(
            min(_CELLS_PER_INTERVAL, _MOST_CELLS // n_intervals), _FEWEST_CELLS_PER_INTERVAL
        )

    def _cubics_of_loads(self, contact: SymmetricContact) -> Array:
        """Cubics of the normal load eta of the flat punches over s: coefficients in each cell,
        constant first, that match eta = P(a = c) and d eta/ds at both its ends.

        Within the flat of the profile no punch carries load. `stiffness` of the contact is dP/da.
        """
        fraction_of_interval = np.linspace(0.0, 1.0, self._cells_per_interval + 1)
        begin_of_interval = self._interval_ends[:-1, None]
        interval_length = np.diff(self._interval_ends)[:, None]
        # c over sigma, the fraction of an interval in s: by its square P(a) is smooth at a kink.
        half_width = begin_of_interval + interval_length * fraction_of_interval**2
        half_width_rate_in_s = 2 * interval_length * fraction_of_interval
        load = contact.load(half_width)
        load_rate_in_s = contact.stiffness(half_width) * half_width_rate_in_s
        is_flat = half_width < contact.least_half_width * (1 - 1e-14)
        load = np.where(is_flat, 0.0, load)
        load_rate_in_s = np.where(is_flat | (half_width_rate_in_s == 0), 0.0, load_rate_in_s)
        return self._hermite_cubics(
            load[:, :-1], load[:, 1:], load_rate_in_s[:, :-1], load_rate_in_s[:, 1:]
        )

    def _hermite_cubics(
        self, begin_value: Array, end_value: Array, begin_rate: Array, end_rate: Array
    ) -> Array:
        """Coefficients, (cells, 4), constant first, of the cubics that take given values and
        derivatives at both ends of each cell of the table (Hermite interpolation).

        The variable of a cubic runs from 0 to 1 along its cell.

        Parameters
        ----------
        begin_value, end_value
            values at both ends of the cells, any shape with one entry per cell
        begin_rate, end_rate
            derivatives there with respect to the punch coordinate s
        """
        # _cells_per_interval: number of cells in each unit of s.
        # Slopes: derivatives in the fraction of the cell, 0 to 1.
        cell_length = 1 / self._cells_per_interval
        rise = end_value - begin_value
        begin_slope = begin_rate * cell_length
        end_slope = end_rate * cell_length
        columns = [
            begin_value,
            begin_slope,
            3 * rise - 2 * begin_slope - end_slope,
            begin_slope + end_slope - 2 * rise,
        ]
        return np.stack([column.ravel() for column in columns], axis=1)

    def _integral_cubics(self, exponent: int) -> Array:
        """Coefficients (cells, 4), constant first, of cubics for int eta G^exponent dc/c from 0 to
        c.

        eta(c) (`profile_load`) and G(c) (`parabola_load`) are the loads that press the profile and
        x^2/2 into contact up to half-width c. The variable of a cubic runs from 0 to 1 along its
        cell; cells are equal steps of the punch coordinate s.

        Parameters
        ----------
        exponent
            of G: 0, 1 or 2
        """
        # _load_cubics (cells, 4): the cubics of eta, one for each cell.
        n_cells = len(self._load_cubics)
        # Gauss' rule with three nodes on each cell. _cells_per_interval: cells in each unit of s.
        gauss_nodes, gauss_weights = _GAUSS_RULE_OF_CELL
        fraction_of_cell = (gauss_nodes + 1) / 2
        cell_length = 1 / self._cells_per_interval  # in s

        def integrand(s: Array) -> Array:
            """eta G^exponent (dc/ds)/c: derivative of the integral with respect to s."""
            half_width = self.half_width(s)
            half_width_rate = self.half_width_rate(s)
            load_per_half_width = (
                self.profile_load(s) * half_width_rate / np.where(half_width > 0, half_width, 1.0)
            )
            return (
                load_per_half_width * self.parabola_load(s) ** exponent
                if exponent
                else load_per_half_width
            )

        # Sums of the integrals over cells give the value at both ends of each cell.
        s_of_nodes = np.asarray(
            (np.arange(n_cells)[:, None] + fraction_of_cell) * cell_length, dtype=float
        )
        integrals_of_cells = integrand(s_of_nodes) @ gauss_weights * (cell_length / 2)
        integral_at_cell_ends = np.concatenate([[0.0], np.cumsum(integrals_of_cells)])
        begin_s = np.asarray(np.arange(n_cells) * cell_length, dtype=float)

        # Just within the cell: at a kink of the profile dc/ds jumps.
        end_s = begin_s + cell_length * (1 - 1e-12)
        return self._hermite_cubics(
            integral_at_cell_ends[:-1],
            integral_at_cell_ends[1:],
            integrand(begin_s),
            integrand(end_s),
        )

    def _values_of_cubics(self, cubics: Array, s: ArrayLike) -> Array:
        """Values of a piecewise cubic function at the punch coordinates s, of the shape of s.

        `cubics` (cells, 4) are the coefficients on each cell of the table, constant first, in the
        fraction of the cell from 0 to 1. Cells are equal steps of s.
        """
        # _cells_per_interval: cells in each unit of s.
        s_in_cells = np.asarray(s, dtype=float) * self._cells_per_interval
        cell = np.minimum(s_in_cells.astype(int), len(cubics) - 1)
        fraction_of_cell = s_in_cells - cell
        c0, c1, c2, c3 = np.moveaxis(cubics[cell], -1, 0)
        return np.asarray(
            c0 + fraction_of_cell * (c1 + fraction_of_cell * (c2 + fraction_of_cell * c3))
        )

    def half_width(self, s: ArrayLike) -> Array:
        """Half-width c of the flat punches at s [length]."""
        s_of_punches = np.asarray(s, dtype=float)
        interval = np.minimum(s_of_punches.astype(int), int(self.largest_s) - 1)
        length = np.diff(self._interval_ends)[interval]
        return np.asarray(self._interval_ends[interval] + length * (s_of_punches - interval) ** 2)

    def half_width_rate(self, s: ArrayLike) -> Array:
        """dc/ds [length]."""
        s_of_punches = np.asarray(s, dtype=float)
        interval = np.minimum(s_of_punches.astype(int), int(self.largest_s) - 1)
        length = np.diff(self._interval_ends)[interval]
        return np.asarray(2 * length * (s_of_punches - interval))

    def profile_load(self, s: ArrayLike) -> Array:
        """eta(c): load of the profile's punches up to c [force per thickness]."""
        return self._values_of_cubics(self._load_cubics, s)

    def parabola_load(self, s: ArrayLike) -> Array:
        """G(c) = (pi E*/4) c^2: load of a parabola's punches up to c per curvature."""
        return self.parabola_stiffness * np.square(self.half_width(s))

    def fourth_load(self, s: ArrayLike) -> Array:
        """G_4(c) = G(c) c^2/8: load of the punches of x^4/24 up to c per unit of its factor."""
        squared_width = np.square(self.half_width(s))
        return np.asarray(self.parabola_stiffness * squared_width**2 / 8)

    def s_of_parabola_load(self, parabola_load: float) -> float:
        """Coordinate s of the half-width c up to which the load G = `parabola_load` presses a
        parabola x^2/2 into contact, from G = (pi E*/4) c^2.

        The kinks of the profile divide the half-widths c into intervals. On each, c grows with the
        square of the fraction of the interval in s.
        """
        # parabola_stiffness: pi E*/4.
        half_width = math.sqrt(max(parabola_load, 0.0) / self.parabola_stiffness)
        # Half-widths at which the intervals begin, and their lengths.
        interval = max(bisect_left(self._interval_begins, half_width) - 1, 0)
        return interval + math.sqrt(
            max(half_width - self._interval_begins[interval], 0.0)
            / self._interval_lengths[interval]
        )

    def punch_loads_at(self, s: float) -> PunchLoads:
        """Normal loads that press the profile, x^2/2 and x^4/24 into contact up to the half-width
        c(s), and their derivatives with respect to s, at one s.

        They are eta for the profile [force per thickness]; G for the gap x^2/2 [force per thickness
        * length]; and G_4 for x^4/24 [force per thickness * length^3]. The flat punches up to c
        carry them. Floats are faster than arrays here. eta is at least 0, whatever its round-off.

        s is a coordinate of the half-width c: it counts the kinks of the profile that are passed,
        and runs from one whole number to the next between two of them.

        # notation: c0 to c3 coefficients of the cubic on a cell, in the fraction of the cell
        """
        # Cells are equal steps of s; _load_coefficients: the cubic of eta on each.
        s_in_cells = s * self._cells_per_interval
        cell = min(int(s_in_cells), len(self._load_coefficients) - 1)
        fraction_of_cell = s_in_cells - cell
        c0, c1, c2, c3 = self._load_coefficients[cell]
        # Between two kinks of the profile c grows with the square of the fraction of s. Each such
        # interval has its begin and its length. parabola_stiffness: pi E*/4.
        interval = min(int(s), len(self._interval_lengths) - 1)
        interval_length = self._interval_lengths[interval]
        half_width = self._interval_begins[interval] + interval_length * (s - interval) ** 2
        half_width_rate = 2 * interval_length * (s - interval)
        squared_half_width = half_width * half_width
        parabola_load = self.parabola_stiffness * half_width * half_width
        profile_load = c0 + fraction_of_cell * (
            c1 + fraction_of_cell * (c2 + fraction_of_cell * c3)
        )
        profile_load_rate = (
            c1 + fraction_of_cell * (2 * c2 + 3 * fraction_of_cell * c3)
        ) * self._cells_per_interval
        return PunchLoads(
            profile_load=max(profile_load, 0.0),
            parabola_load=parabola_load,
            fourth_load=parabola_load * squared_half_width / 8,
            load_rate=profile_load_rate,
            parabola_rate=2 * self.parabola_stiffness * half_width * half_width_rate,
            fourth_rate=parabola_load * half_width * half_width_rate / 2,
        )

    def punch_sums_at(self, s: float, datum_length: float) -> PunchSums:
        """Integrals over the flat punches of half-width 0 to c(s): of ln(2 L/c), which gives
        displacements, and of c^2/2, which gives second moments.

        Each is taken over d eta and over dG: eta(c) and G(c) are the loads that press the profile
        and x^2/2 into contact up to c. L is the datum length. By parts, with tabulated integrals of
        eta dc/c and eta G dc/c:

            int ln(2 L/c) d eta = eta ln(2 L/c) + int eta dc/c
            int (c^2/2) d eta = eta c^2/2 - int eta G dc/c / (pi E*/4)

        s is a coordinate of the half-width c, a whole number at each kink of the profile.

        # notation: c0 to c3 coefficients of the cubic on a cell, in the fraction of the cell
        """
        # Cells are equal steps of s: each has a cubic of eta and of its integrals.
        s_in_cells = s * self._cells_per_interval
        cell = min(int(s_in_cells), len(self._load_coefficients) - 1)
        fraction_of_cell = s_in_cells - cell

        def value_at_s(coefficients_of_cells: list[list[float]]) -> float:
            """Value at s of a function with a cubic on each cell of the table."""
            c0, c1, c2, c3 = coefficients_of_cells[cell]
            return c0 + fraction_of_cell * (c1 + fraction_of_cell * (c2 + fraction_of_cell * c3))

        # Between two kinks of the profile c grows with the square of the fraction of s. Each such
        # interval has its begin and its length. parabola_stiffness: pi E*/4.
        interval = min(int(s), len(self._interval_lengths) - 1)
        half_width = (
            self._interval_begins[interval] + self._interval_lengths[interval] * (s - interval) ** 2
        )
        squared_half_width = half_width * half_width
        profile_load = value_at_s(self._load_coefficients)
        parabola_load = self.parabola_stiffness * squared_half_width

        # 1e-9 of the largest half-width stands for c = 0 in the logarithm.
        least_half_width = _LEAST_HALF_WIDTH_SHARE * float(self._interval_ends[-1])
        log_datum_ratio = math.log(2 * datum_length / max(half_width, least_half_width))
        return PunchSums(
            logarithm=profile_load * log_datum_ratio + value_at_s(self._load_integral_coefficients),
            parabola_logarithm=parabola_load * (log_datum_ratio + 0.5),
            second_moment=squared_half_width * profile_load / 2
            - value_at_s(self._load_parabola_integral_coefficients) / self.parabola_stiffness,
            parabola_second_moment=squared_half_width * parabola_load / 4,
        )

    def edge_s_of_load(self, normal_load: float, curvature: float) -> float:
        """Coordinate s of the edge of contact a under one normal load P, from P = eta(a) + kn G(a)
        by bisection; of the widest punch of the table where its contact carries less than P.

        eta(c) and G(c) are the loads that press the profile and x^2/2 into contact up to half-width
        c. `curvature` is kn: the bodies add kn x^2/2 to the gap [1/length].

        s is a whole number at each kink of the profile.
        """
        # Bracket of s, from the middle to the widest punch of the table.
        low_s = 0.0
        high_s = self.largest_s
        for _ in range(_BISECTION_COUNT):  # 60
            middle_s = (low_s + high_s) / 2
            loads_of_punches = self.punch_loads_at(middle_s)
            if (
                loads_of_punches.profile_load + curvature * loads_of_punches.parabola_load
                <= normal_load
            ):
                low_s = middle_s
            else:
                high_s = middle_s
        return (low_s + high_s) / 2

    def load_integral(self, s: ArrayLike) -> Array:
        """int eta dc/c from 0 to c."""
        return self._values_of_cubics(self._load_integral_cubics, s)

    def load_parabola_integral(self, s: ArrayLike) -> Array:
        """int eta G dc/c from 0 to c."""
        return self._values_of_cubics(self._load_parabola_integral_cubics, s)

    @cached_property
    def _load_fourth_integral_cubics(self) -> Array:
        """Cubics of int eta G^2 dc/c."""
        return self._integral_cubics(exponent=2)

    def second_moments(self, s: ArrayLike) -> PunchMoments:
        """Second moments int x^2 p dx of the pressure of flat punches up to each coordinate s (k,):
        of the punches of the profile, of x^2/2 and of x^4/24, (k,) each.

        s is a coordinate of the half-width c of a punch, a whole number at each kink of the
        profile. A punch has the moment c^2/2 per unit load. eta, G and G_4 are the loads that press
        the profile, x^2/2 and x^4/24 into contact up to half-width c: G = (pi E*/4) c^2, and G_4
        grows as c^4. The integral of eta G dc/c is tabulated.
        """
        # By parts: int c^2/2 d eta = c^2 eta/2 - int eta c dc, with c dc = (G dc/c)/(pi E*/4), and
        # parabola_stiffness = pi E*/4.
        squared_half_width = np.square(self.half_width(s))
        moment_of_profile = (
            squared_half_width * self.profile_load(s) / 2
            - self.load_parabola_integral(s) / self.parabola_stiffness
        )
        return PunchMoments(
            moment_of_profile,
            squared_half_width * self.parabola_load(s) / 4,
            squared_half_width * self.fourth_load(s) / 3,
        )

    def fourth_moments(self, s: ArrayLike) -> PunchMoments:
        """Fourth moments int x^4 p dx of the pressure of flat punches up to each coordinate s (k,):
        of the punches of the profile, of x^2/2 and of x^4/24, (k,) each.

        A punch of half-width c has the moment 3 c^4/8 per unit load. The table gives the loads eta,
        G and G_4 that punches up to c carry, and int eta G^2 dc/c.
        """
        squared_half_width = np.square(self.half_width(s))
        # Times 3/8 the moment of the punches of the profile, by parts with int eta G^2 dc/c;
        # parabola_stiffness is pi E*/4.
        scaled_moment_of_profile = squared_half_width**2 * self.profile_load(s)
        scaled_moment_of_profile -= (
            4
            * self._values_of_cubics(self._load_fourth_integral_cubics, s)
            / self.parabola_stiffness**2
        )
        moment_of_parabola = squared_half_width**2 * self.parabola_load(s) / 8
        return PunchMoments(
            3 / 8 * scaled_moment_of_profile,
            moment_of_parabola,
            3 / 16 * squared_half_width**2 * self.fourth_load(s),
        )

    def logarithm_integrals(self, s: ArrayLike, datum_length: float) -> PunchMoments:
        """Integrals of ln(2 L/c) over d eta, dG and dG_4 of the flat punches of half-width up to
        c(s), (k,) each; times A/pi, A = 2/E*, displacements of half-planes under these punches.

        L is the datum length, `datum_length`. eta, G and G_4 are the loads that press the profile,
        x^2/2 and x^4/24 into contact up to half-width c.

        s is the coordinate of the half-width in the table.
        """
        # 1e-9 of the largest half-width stands for c = 0 in the logarithm.
        half_width = np.maximum(
            self.half_width(s), _LEAST_HALF_WIDTH_SHARE * self._interval_ends[-1]
        )
        log_datum_ratio = math.log(2 * datum_length) - np.log(half_width)
        return PunchMoments(
            # load_integral: int eta dc/c
            profile_integral=self.profile_load(s) * log_datum_ratio + self.load_integral(s),
            parabola_integral=self.parabola_load(s) * (log_datum_ratio + 0.5),
            fourth_integral=self.fourth_load(s) * (log_datum_ratio + 0.25),
        )

    def edge_s_of_loads(
        self,
        normal_load: Array,
        curvature: Array,
        fourth_coefficient: Array | float = 0.0,
        known_s: Array | None = None,
    ) -> Array:
        """Edges of contact a under normal loads P (n,), as coordinates s (n,) of the table.

        They are the roots of P = eta(a) + kn G(a) + n4 G_4(a), by bisection and Newton's method.
        eta, G and G_4 are the loads that press the profile, x^2/2 and x^4/24 into contact up to
        half-width a. s is 0 where P = 0, and at most that of the widest punch.

        Parameters
        ----------
        normal_load
            P (n,)
        curvature, fourth_coefficient
            kn and n4 (n,): factors of x^2/2 and x^4/24 that the bodies add to the gap
        known_s
            s (n,) if it is known to 1e-3: then Newton's method starts from it without bisection
        """

        def carried_load(s: Array) -> Array:
            """eta + kn G + n4 G_4 of the punches up to s, (n,)."""
            load = self.profile_load(s) + curvature * self.parabola_load(s)
            return np.asarray(load + fourth_coefficient * self.fourth_load(s))

        # Bisection to an eighth of a cell of the table; largest_s: the widest punch of the table.
        lower_s = np.zeros(len(normal_load))
        upper_s = np.full(len(normal_load), self.largest_s)
        edge_s = known_s
        # Numbers of iterations: 12 bisections, then 6 Newton steps; 2 Newton steps from a known
        # edge.
        n_newton_steps = _NEWTON_STEPS_FROM_KNOWN_EDGE
        if edge_s is None:
            for _ in range(_FIRST_BISECTIONS):
                middle_s = (lower_s + upper_s) / 2
                carries_less_or_equal = carried_load(middle_s) <= normal_load
                lower_s = np.where(carries_less_or_equal, middle_s, lower_s)
                upper_s = np.where(carries_less_or_equal, upper_s, middle_s)
            edge_s = (lower_s + upper_s) / 2
            n_newton_steps = _NEWTON_STEPS_AFTER_BISECTION

        # Newton's method: the load that the edge still misses, over its rate d/ds.
        for _ in range(n_newton_steps):
            missing_load = normal_load - carried_load(edge_s)
            # kn dG + n4 dG_4 = (kn + n4 a^2/4) dG
            curvature_at_edge = (
                curvature + fourth_coefficient * np.square(self.half_width(edge_s)) / 4
            )
            load_rate = self._load_rate(edge_s) + curvature_at_edge * self._parabola_rate(edge_s)
            newton_step = missing_load / np.where(load_rate > 0, load_rate, np.inf)
            edge_s = np.clip(edge_s + newton_step, lower_s, upper_s)
        return np.where(normal_load > 0, edge_s, 0.0)

    def _load_rate(self, s: Array) -> Array:
        """Derivative d eta/ds at coordinates s (n,), (n,), from the cubic on each cell of the
        table; eta is the load that presses the profile into contact up to the half-width at s.
        """
        s_in_cells = s * self._cells_per_interval
        cell = np.minimum(s_in_cells.astype(int), len(self._load_cubics) - 1)
        fraction_of_cell = s_in_cells - cell
        _, c1, c2, c3 = self._load_cubics[cell].T
        return np.asarray(
            (c1 + fraction_of_cell * (2 * c2 + 3 * fraction_of_cell * c3))
            * self._cells_per_interval
        )

    def _parabola_rate(self, s: Array) -> Array:
        """dG/ds, (n,)."""
        return 2 * self.parabola_stiffness * self.half_width(s) * self.half_width_rate(s)


# ------------------------------------------------------------------------------------- the memory
class Curvatures(NamedTuple):
    """Curvatures that finite bodies add to half-planes per unit of load, in the gap and in the
    tangential displacement of the faces.

    Attributes
    ----------
    normal, normal_under_shear
        N and N_Q: factors of x^2/2 in the gap per P and per Q [1 / (stress length^2)]
    tangential, tangential_under_pressure
        T and T_P: factors of x^2/2 in the displacement of the faces per Q and per P
    normal_fourth, tangential_fourth
        N_4 and T_4: factors of x^4/24 in the gap per P, and in the displacement per Q [1 / (stress
        length^4)]
    normal_mixed, tangential_mixed
        N_22 and T_22: the second moments p_2 and q_2 of pressure and shear add 2 N_22 p_2 to the
        factor of x^2/2 in the gap, and 2 T_22 q_2 to that of the faces [1 / (stress length^4)]
    """

    normal: float = 0.0
    normal_under_shear: float = 0.0
    tangential: float = 0.0
    tangential_under_pressure: float = 0.0
    normal_fourth: float = 0.0
    tangential_fourth: float = 0.0
    normal_mixed: float = 0.0
    tangential_mixed: float = 0.0

    @property
    def are_of_mirrored_bodies(self) -> bool:
        """Whether N_Q and T_P are 0."""
        return not (self.normal_under_shear or self.tangential_under_pressure)

    def gap_curvature_under(self, normal_load: Array, tangential_load: Array) -> Array:
        """kn = N P + N_Q Q [1 / length], without what p_2 adds."""
        return self.normal * normal_load + self.normal_under_shear * tangential_load

    def face_curvature_under(self, normal_load: Array, tangential_load: Array) -> Array:
        """kt = T Q + T_P P [1 / length], without what q_2 adds."""
        return self.tangential * tangential_load + self.tangential_under_pressure * normal_load


class Piece(NamedTuple):
    """A piece of a memory curve F(s), the locked-in tangential force of the flat punches up to s:
    what they carry beyond the share that the curvature of the faces gives them.

    A whole curve is held by the number of its uppermost piece in `Pieces`. Each piece
    continues another one outwards, number `number_below`, from that one's `top_s` to its own. The
    chain ends at piece 0, the empty curve.

    On a piece dF = `profile_slope` d eta + `parabola_slope` dG + `fourth_slope` dG_4. The loads
    eta, G, G_4 and F at its top are `profile_load`, `parabola_load`, `fourth_load` and
    `locked_in_force`.
    """

    number_below: int
    top_s: float
    profile_load: float
    parabola_load: float
    fourth_load: float
    locked_in_force: float
    profile_slope: float
    parabola_slope: float
    fourth_slope: float

    @property
    def loads(self) -> LoadTriple:
        """eta, G and G_4 at the top."""
        return self.profile_load, self.parabola_load, self.fourth_load

    @property
    def slopes(self) -> LoadTriple:
        """dF per d eta, per dG and per dG_4."""
        return self.profile_slope, self.parabola_slope, self.fourth_slope


_EMPTY_CURVE = Piece(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Pieces(list[Piece]):
    """Pieces of all memory curves of a path by their numbers; piece 0 is the empty curve.

    A curve is the number of its uppermost piece; curves of several instants share pieces.
    """

    def __init__(self) -> None:
        super().__init__([_EMPTY_CURVE])

    def piece_above(
        self, number_below: int, top_s: float, loads: LoadTriple, slopes: LoadTriple
    ) -> Piece:
        """A new piece of memory curve that continues piece `number_below` outwards; it is not yet
        stored.

        A memory curve is F(s), the locked-in tangential force of the flat punches up to the
        coordinate s of their half-width. It is a chain of pieces; on each F is linear in eta, G and
        G_4, the loads that press the profile, x^2/2 and x^4/24 into contact up to that half-width.
        The pieces are stacked: "above" and "top" are outwards, to wider punches and larger s.

        Parameters
        ----------
        number_below
            number of the piece that it continues
        top_s
            s of the outer end of the new piece
        loads
            eta, G and G_4 there
        slopes
            dF/d eta, dF/dG and dF/dG_4
        """
        # The piece at whose outer end the new one begins; self[k] is piece number k.
        piece_below = self[number_below]
        profile_load, parabola_load, fourth_load = loads
        # Loads eta, G and G_4 at the outer end, and slopes dF per each.
        profile_slope, parabola_slope, fourth_slope = slopes
        force_at_top = piece_below.locked_in_force + profile_slope * (
            profile_load - piece_below.profile_load
        )
        force_at_top += parabola_slope * (parabola_load - piece_below.parabola_load)
        force_at_top += fourth_slope * (fourth_load - piece_below.fourth_load)
        return Piece(
            number_below,
            top_s,
            profile_load,
            parabola_load,
            fourth_load,
            force_at_top,
            profile_slope,
            parabola_slope,
            fourth_slope,
        )

    def append_and_number(self, piece: Piece) -> int:
        """Store a piece and return its number."""
        self.append(piece)
        return len(self) - 1

    def add_piece(
        self, number_below: int, top_s: float, loads: LoadTriple, slopes: LoadTriple
    ) -> int:
        """Store a new piece of memory curve that continues piece `number_below` outwards to
        coordinate `top_s`, and return its number.

        `loads` are eta, G and G_4 at its outer end, the loads of the punches up to there. `slopes`
        are the rates of its locked-in tangential force with respect to each of them.
        """
        return self.append_and_number(self.piece_above(number_below, top_s, loads, slopes))

    def keep_first(self, n_pieces: int) -> None:
        """Keep the first `n_pieces` pieces; those of a rejected trial are removed."""
        del self[n_pieces:]


class _Bound(NamedTuple):
    """Coulomb bound B of the locked-in tangential force F of flat punches: what F is while they
    slip in one direction s. Where a punch sticks, s F >= s B.

    Attributes
    ----------
    direction
        s, direction of slip: +1 or -1
    constant
        B where the loads eta, G and G_4 of the punches are 0 [force per thickness]
    profile_slope, parabola_slope, fourth_slope
        dB per d eta, dG and dG_4
    """

    direction: int
    constant: float
    profile_slope: float
    parabola_slope: float
    fourth_slope: float

    @property
    def slopes(self) -> LoadTriple:
        """dB per d eta, per dG and per dG_4."""
        return self.profile_slope, self.parabola_slope, self.fourth_slope

    def excess_at_top(self, memory_piece: Piece) -> float:
        """How far the locked-in tangential force F at the outer end of a piece of memory curve is
        beyond the Coulomb bound [force per thickness]; the punch there slips where this is
        positive.

        The bound is linear in the loads eta, G and G_4 that the punches up to there carry:
        `constant` plus a slope times each. The sign is that of the direction of slip, +1 or -1.
        """
        # profile_load, parabola_load, fourth_load of the piece: eta, G and G_4 at its outer end.
        bound_at_top = self.constant + self.profile_slope * memory_piece.profile_load
        bound_at_top += (
            self.parabola_slope * memory_piece.parabola_load
            + self.fourth_slope * memory_piece.fourth_load
        )
        return self.direction * (bound_at_top - memory_piece.locked_in_force)


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """Memory of friction and slip zones along a load path, with the curvatures of finite bodies.

    Attributes
    ----------
    table
        the flat punches
    friction
        f
    normal_load, tangential_load, normal_curvature, tangential_curvature
        (n,) P, Q, kn, kt at the rows of the path, the ends of its straight steps
    normal_fourth, tangential_fourth
        (n,) n4, t4 there
    edge_s, stick_edge_s
        (n,) coordinate s in the table of the edge of contact and of the stick edge; the same where
        the edge sticks, stick edge 0 where the bodies slide as a whole
    direction
        (n,) direction of slip at the edge in the step that ends at the row, 0 where the edge sticks
    inner_zone_s, inner_zone_direction
        (n, 2) s of the ends of an inner slip zone, where slip continues while the edge sticks or
        slips the other way; (n,) its direction, 0 where there is none
    uppermost_piece
        (n,) number of the uppermost piece of the memory curve, the locked-in tangential force
    pieces
        pieces of the memory curves of all instants
    """

    table: PunchTable
    friction: float
    normal_load: Array
    tangential_load: Array
    normal_curvature: Array
    tangential_curvature: Array
    normal_fourth: Array
    tangential_fourth: Array
    edge_s: Array
    stick_edge_s: Array
    direction: Indices
    inner_zone_s: Array
    inner_zone_direction: Indices
    uppermost_piece: Indices
    pieces: PieceTable

    @property
    def innermost_slip_s(self) -> Array:
        """s of the inner end of all slip zones, (n,); of the edge of contact in full stick."""
        return np.where(self.inner_zone_direction != 0, self.inner_zone_s[:, 0], self.stick_edge_s)

    @property
    def slip_direction(self) -> Indices:
        """Direction of slip at the edge, (n,), +1 or -1; that of the inner zone where the edge
        sticks; 0 in full stick.
        """
        return np.where(self.direction != 0, self.direction, self.inner_zone_direction)

    @cached_property
    def pressure_second_moment(self) -> Array:
        """p_2, (n,)."""
        return self.pressure_integral(self.table.second_moments(self.edge_s))

    @cached_property
    def shear_second_moment(self) -> Array:
        """q_2, (n,)."""
        moments = self.table.second_moments
        return self.shear_integral(moments(self.pieces.top_s), moments(self.edge_s))

    @cached_property
    def pressure_fourth_moment(self) -> Array:
        """p_4 = int x^4 p dx, (n,)."""
        return self.pressure_integral(self.table.fourth_moments(self.edge_s))

    @cached_property
    def shear_fourth_moment(self) -> Array:
        """q_4 = int x^4 q dx, (n,)."""
        moments = self.table.fourth_moments
        return self.shear_integral(moments(self.pieces.top_s), moments(self.edge_s))

    def pressure_integral(self, at_edge: PunchMoments) -> Array:
        """Integral of the pressure over the contact at each instant, (n,), such as a moment; 0
        where the bodies are apart, P = 0.

        `at_edge` holds its parts up to the edge of contact, by the punches of the profile, of x^2/2
        and of x^4/24. The latter two are multiplied by kn and n4, the curvatures of the gap.
        """
        integral = _pressure_moment(at_edge, self.normal_curvature, self.normal_fourth)
        return np.where(self.normal_load > 0, integral, 0.0)

    def shear_integral(self, at_tops: PunchMoments, at_edge: PunchMoments) -> Array:
        """Integral of the shear traction over the contact at each instant, (n,), such as a moment;
        0 where the bodies are apart.

        Let w(c) be the integral for a flat punch of half-width c under unit tangential force. Then
        the whole is int w dM = int w dF + kt int w dG + t4 int w dG_4. M is the tangential force
        that punches up to c carry. F(c) is the memory curve, the locked-in part of M. kt and t4 are
        curvatures that the loads give to the faces. eta, G and G_4 are the loads that press the
        profile, x^2/2 and x^4/24 into contact up to the half-width of a punch.

        Parameters
        ----------
        at_tops
            int w d eta, int w dG and int w dG_4 up to the top of each piece of a memory curve
        at_edge
            these three integrals up to the edge of contact at each instant, of which the latter two
            are used

        # notation: profile_slope, parabola_slope, fourth_slope dF per d eta, dG and dG_4 on a piece
        #           of the memory curve
        """
        # Sums over the pieces of the memory curves, each at the top of the uppermost piece of an
        # instant.
        pieces = self.pieces
        integral = pieces.integrals_at_tops(
            (pieces.profile_slope, at_tops.profile_integral),
            (pieces.parabola_slope, at_tops.parabola_integral),
            (pieces.fourth_slope, at_tops.fourth_integral),
        )[self.uppermost_piece]
        integral = integral + self.tangential_curvature * at_edge.parabola_integral
        integral = integral + self.tangential_fourth * at_edge.fourth_integral
        return np.where(self.normal_load > 0, integral, 0.0)

    @cached_property
    def step_work(self) -> Array:
        """Friction work of the straight step that ends at each instant, times pi/A = pi E*/2, (n,);
        0 at the first one.

        Work is done in three places: the slip zone at the edge of contact, an inner slip zone, and
        the strip that the receding contact leaves, which slips until it separates. A = 2/E*, E* the
        composite modulus.
        """
        # Zones by direction of slip, inner and outer end; _s: coordinate s in the table of punches.
        edge_before = np.append(self.edge_s[:1], self.edge_s[:-1])
        intervals = self._intervals_of_zones(
            (self.direction, self.stick_edge_s, self.edge_s),
            (self.inner_zone_direction, self.inner_zone_s[:, 0], self.inner_zone_s[:, 1]),
            (self.direction, self.edge_s, edge_before),  # empty where the contact grows
        )
        # Sum over the intervals of each step; intervals.row: number of the instant at which it
        # ends.
        work = np.bincount(intervals.row, self._work_of_intervals(intervals), len(self.edge_s))
        return np.asarray(work, dtype=float)

    def _work_of_intervals(self, intervals: _SlipIntervals) -> Array:
        """Friction work of one step in each interval of a slip zone, times pi/A = pi E*/2, (m,), by
        Gauss quadrature over its flat punches.

            int f [mean load beyond c] |dF| dc/c,    c half-width of a punch

        F is the tangential force that a punch locks in while it sticks. The mean of the load is
        over the time in which the punch slips.

        Parameters
        ----------
        intervals
            m intervals: number of the instant at which the step ends, coordinate s of both ends in
            the table of punches, direction of slip, and number of the piece of the memory curve
            before the step on which each lies; 0 if it was outside the contact
        """
        # Gauss' rule with k = 8 nodes on each interval: a node is a flat punch.
        gauss_nodes, gauss_weights = _GAUSS_RULE_OF_WORK
        interval_length_s = (intervals.outer_s - intervals.inner_s)[:, None]
        s = (
            intervals.inner_s[:, None] + interval_length_s * (gauss_nodes + 1) / 2
        )  # of the punches, (m, k)
        table = self.table
        punches = _PunchArrays(table.profile_load(s), table.parabola_load(s), table.fourth_load(s))
        log_half_width_rate = table.half_width_rate(s) / table.half_width(s)
        integrand = self._work_of_punches(punches, intervals) * log_half_width_rate
        return np.asarray(self.friction * integrand @ gauss_weights * interval_length_s[:, 0] / 2)

    def _work_of_punches(self, punches: _PunchArrays, intervals: _SlipIntervals) -> Array:
        """Work of one step on each of k flat punches in m intervals of slip zones, (m, k): mean
        load beyond the punch times |dF|, without f [force^2 per thickness^2].

        F is the tangential force that a punch locks in while it sticks. During the step the Coulomb
        bound of F moves linearly. A punch slips from when the bound meets F, or it comes into
        contact, to the end of the step, or until it leaves the contact. `intervals` have the number
        of the instant at which the step ends, and the direction of slip. They have the number of
        the piece of the memory curve before the step, 0 outside the contact.
        """
        # normal load that is carried beyond each punch, and its Coulomb bound, before and after
        row = intervals.row
        direction = intervals.direction[:, None]
        load_before = self._load_beyond(punches, row - 1)
        load_after = self._load_beyond(punches, row)
        bound_before = self._coulomb_bound(punches, row - 1, direction, load_before)
        bound_after = self._coulomb_bound(punches, row, direction, load_after)
        locked_in_force = self._locked_in_forces(punches, intervals.piece_number)

        # Both are positive along the slip; `locked_in_force` is F before the step. In gross sliding
        # the curvature of the faces may move a punch against the slide.
        bound_rise = direction * (bound_after - bound_before)
        force_change = direction * (bound_after - locked_in_force)  # |dF|
        # fraction of the step, up to its end, in which the bound is beyond F
        slip_fraction = np.clip(
            force_change / np.where(bound_rise != 0, bound_rise, np.inf), 0.0, 1.0
        )

        # A punch that comes into contact within the step slips from there to its end.
        is_new_contact = intervals.piece_number[:, None] == 0
        fraction_since_touch = _fraction_since_touch(load_before, load_after, is_new_contact)
        slip_fraction = np.where(is_new_contact, fraction_since_touch, slip_fraction)
        force_change = np.where(is_new_contact, bound_rise * fraction_since_touch, force_change)

        # A punch that leaves the contact within the step slips until then.
        leaves_contact = (load_after < 0) & (load_before > 0)
        load_loss = np.where(leaves_contact, load_before - load_after, np.inf)
        separated_fraction = np.where(leaves_contact, -load_after / load_loss, 0.0)
        slip_fraction_in_contact = np.maximum(slip_fraction - separated_fraction, 0.0)
        force_change = np.where(leaves_contact, bound_rise * slip_fraction_in_contact, force_change)

        # The load is linear in the step: its mean is its value in the middle of the slip.
        middle_of_slip = 1 - slip_fraction + slip_fraction_in_contact / 2
        mean_load = np.maximum(load_before + middle_of_slip * (load_after - load_before), 0.0)
        return np.asarray(mean_load * force_change)

    def _load_beyond(self, punches: _PunchArrays, row: Indices) -> Array:
        """P - eta - kn G - n4 G_4 at rows (m,): load carried beyond punches (m, k), (m, k)."""
        load_beyond = self.normal_load[row][:, None] - punches.profile_load
        load_beyond = load_beyond - self.normal_curvature[row][:, None] * punches.parabola_load
        return np.asarray(load_beyond - self.normal_fourth[row][:, None] * punches.fourth_load)

    def _coulomb_bound(
        self, punches: _PunchArrays, row: Indices, direction: Indices, load_beyond: Array
    ) -> Array:
        """Value of the locked-in tangential force F of flat punches while they slip, (m, k) for k
        punches at each of m instants [force per thickness].

            Q - kt G - t4 G_4 - direction f [load beyond the punch]

        kt x^2/2 + t4 x^4/24 is the tangential displacement that the loads give to the faces. G and
        G_4 are the loads of x^2/2 and x^4/24.

        Parameters
        ----------
        punches
            their loads eta, G and G_4, (m, k)
        row
            (m,) number of the instant
        direction
            (m, 1) of slip: +1 forward, -1 reverse
        load_beyond
            (m, k) normal load that is carried outside of each punch
        """
        # Q - kt G - t4 G_4: Q without the share that the curvatures kt and t4 of the faces give to
        # the punches.
        force_without_faces = self.tangential_load[row][:, None]
        force_without_faces = (
            force_without_faces - self.tangential_curvature[row][:, None] * punches.parabola_load
        )
        force_without_faces = (
            force_without_faces - self.tangential_fourth[row][:, None] * punches.fourth_load
        )
        return np.asarray(force_without_faces - direction * self.friction * load_beyond)

    def _locked_in_forces(self, punches: _PunchArrays, piece_number: Indices) -> Array:
        """Tangential force F that flat punches keep while they stick, (m, k) for m rows of k
        punches [force per thickness].

        The memory curve is F as a function of the half-width. It consists of pieces on which F
        is linear in eta, G and G_4, the loads that press the profile, x^2/2 and x^4/24 into contact
        up to that half-width. `piece_number` (m,) is that of the piece on which row m of `punches`
        (m, k) lies; F is 0 on number 0, the empty curve.
        """
        pieces = self.pieces
        # F at the top of the piece below, plus the rise on the piece itself.
        number_below = pieces.number_below[piece_number]
        locked_in_force = pieces.locked_in_force[number_below][:, None]
        # Slopes of F on the piece, per d eta, dG and dG_4.
        # profile_load, parabola_load, fourth_load: eta, G and G_4, of the punches and at the tops
        # of pieces.
        load_rise = punches.profile_load - pieces.profile_load[number_below][:, None]
        locked_in_force = locked_in_force + pieces.profile_slope[piece_number][:, None] * load_rise
        parabola_rise = punches.parabola_load - pieces.parabola_load[number_below][:, None]
        locked_in_force = (
            locked_in_force + pieces.parabola_slope[piece_number][:, None] * parabola_rise
        )
        fourth_rise = punches.fourth_load - pieces.fourth_load[number_below][:, None]
        return np.asarray(
            locked_in_force + pieces.fourth_slope[piece_number][:, None] * fourth_rise
        )

    def _intervals_of_zones(self, *slip_zones: tuple[Indices, Array, Array]) -> _SlipIntervals:
        """Intervals of the punch coordinate s of which the slip zones of all steps consist, such
        that the integrand of the friction work is smooth on each. s grows with the half-width of
        the flat punches.

        They are cut at kinks of the profile, which are at whole numbers of s. They are also cut
        where pieces of the memory curve before the step meet: the locked-in tangential force of the
        flat punches up to each s. Each interval has the number of the piece on which it lies, 0 if
        it was outside the contact before.

        Parameters
        ----------
        slip_zones
            each as three arrays (n,) over the steps: direction of slip, 0 for no slip; s of the
            inner end; s of the outer end
        """
        # each: instant at which the step ends, s of inner and outer end, piece, direction of slip
        intervals: list[tuple[int, float, float, int, int]] = []
        # the zones that are not empty; a step has the number of the instant at which it ends
        for directions, inner_ends, outer_ends in slip_zones:
            rows_of_zone = (
                np.flatnonzero((directions[1:] != 0) & (outer_ends[1:] > inner_ends[1:])) + 1
            )
            for row in rows_of_zone.tolist():
                for inner_s, outer_s, piece_number in self._smooth_intervals(
                    row, float(inner_ends[row]), float(outer_ends[row])
                ):
                    intervals.append((row, inner_s, outer_s, piece_number, int(directions[row])))
        columns = np.array(intervals).reshape(-1, 5).T
        return _SlipIntervals(
            row=columns[0].astype(np.int64),
            inner_s=columns[1],
            outer_s=columns[2],
            piece_number=columns[3].astype(np.int64),
            direction=columns[4].astype(np.int64),
        )

    def _smooth_intervals(
        self, row: int, inner_end: float, outer_end: float
    ) -> Iterator[tuple[float, float, int]]:
        """Intervals of the punch coordinate s within one slip zone, from the outer end inwards:
        inner and outer end, and the number of the piece of the memory curve on which each lies.

        The zone is that of the step that ends at the instant number `row`. The memory curve, the
        locked-in tangential force of the flat punches up to each s, is that before the step. The
        number is 0 where that was outside the contact. Intervals end where two pieces meet, and at
        whole numbers of s, the kinks of the profile.
        """
        # top_s: outer end of each piece; numbers_below: number of the piece below it;
        # uppermost_pieces: number of the uppermost piece of the memory curve at each instant
        top_s, numbers_below, uppermost_pieces = self._lists_of_pieces
        piece_number = uppermost_pieces[row - 1]
        is_beyond_edge = True  # of the contact before the step
        outer_s = outer_end
        while outer_s > inner_end:
            number_below = piece_number if is_beyond_edge else numbers_below[piece_number]
            inner_s = max(top_s[number_below], inner_end)
            piece_of_interval = 0 if is_beyond_edge else piece_number
            while math.ceil(outer_s) - 1 > inner_s:
                kink_s = float(math.ceil(outer_s) - 1)
                yield kink_s, outer_s, piece_of_interval
                outer_s = kink_s
            if outer_s > inner_s:
                yield inner_s, outer_s, piece_of_interval
                outer_s = inner_s
            piece_number = number_below
            is_beyond_edge = False

    @cached_property
    def _lists_of_pieces(self) -> tuple[list[float], list[int], list[int]]:
        """s of the tops of all pieces, numbers of the pieces below them, and number of the
        uppermost piece at each instant: loops over lists are faster than over arrays.
        """
        return (
            self.pieces.top_s.tolist(),
            self.pieces.number_below.tolist(),
            self.uppermost_piece.tolist(),
        )

    def first_steady_cycle(self, ends: Sequence[int]) -> int | None:
        """Index, from 0, of the first cycle that ends in the friction state it started from; None
        where none does.

        The state is the memory curve: the locked-in tangential force of the flat punches up to each
        half-width. The curves at the begin and end of the cycle must agree at 200 punches to 1e-9
        of f times the largest P of the path. `ends` are the rows at which the initial loading and
        each cycle end.
        """
        # s is the coordinate of the half-width in the table of punches.
        s_of_punches = np.linspace(0.0, self.table.largest_s, _PUNCHES_COMPARED)
        force_tolerance = _STEADY_FORCE_SHARE * self.friction * float(np.max(self.normal_load))
        # F of these punches at the end of the initial loading and of each cycle.
        forces_at_ends = [self.locked_in_force(row, s_of_punches) for row in ends]
        for cycle, (forces_before, forces_after) in enumerate(pairwise(forces_at_ends)):
            if np.max(np.abs(forces_after - forces_before)) <= force_tolerance:
                return cycle
        return None

    def locked_in_force(self, row: int, s: Array) -> Array:
        """Locked-in tangential force F of the flat punches up to the coordinates s of their
        half-widths, (k,), at instant number `row` [force per thickness].

        F does not change while a punch sticks: it is the memory of the contact. It is read from the
        pieces of the memory curve F(s). Beyond the edge of contact F is that at the edge; 0 while
        the bodies are apart.
        """
        pieces = self.pieces
        # From the empty curve, number 0, to the uppermost piece.
        numbers_of_pieces = pieces.piece_numbers_of_curve(int(self.uppermost_piece[row]))
        top_s_of_pieces = pieces.top_s[numbers_of_pieces]
        index_in_chain = np.clip(
            np.searchsorted(top_s_of_pieces, s), 1, max(len(numbers_of_pieces) - 1, 1)
        )
        if len(numbers_of_pieces) == 1:
            return np.zeros(len(s))
        # F at the top of the piece below, plus slopes times the rise of the loads on the piece.
        s_in_contact = np.minimum(s, top_s_of_pieces[-1])
        number_below = numbers_of_pieces[index_in_chain - 1]
        piece_number = numbers_of_pieces[index_in_chain]
        # profile_load, parabola_load, fourth_load: eta, G and G_4, up to a punch and at the tops of
        # pieces; the slopes are those of F per each.
        load_rise = self.table.profile_load(s_in_contact) - pieces.profile_load[number_below]
        parabola_rise = self.table.parabola_load(s_in_contact) - pieces.parabola_load[number_below]
        force_rise = pieces.profile_slope[piece_number] * load_rise
        force_rise = force_rise + pieces.parabola_slope[piece_number] * parabola_rise
        fourth_rise = self.table.fourth_load(s_in_contact) - pieces.fourth_load[number_below]
        force_rise = force_rise + pieces.fourth_slope[piece_number] * fourth_rise
        return np.asarray(pieces.locked_in_force[number_below] + force_rise)


class _PunchArrays(NamedTuple):
    """eta, G and G_4 of flat punches (m, k): loads of the punches up to each, of the profile, of a
    parabola and of x^4/24.
    """

    profile_load: Array
    parabola_load: Array
    fourth_load: Array


class _SlipIntervals(NamedTuple):
    """Intervals (m,) of the punch coordinate s within the slip zones of steps.

    Attributes
    ----------
    row
        number of the instant at which the step ends
    inner_s, outer_s
        s of both ends
    piece_number
        number of the piece of the memory curve before the step on which the interval lies; 0 if it
        was outside the contact
    direction
        direction of slip, +1 or -1
    """

    row: Indices
    inner_s: Array
    outer_s: Array
    piece_number: Indices
    direction: Indices


def _fraction_since_touch(
    load_before: Array, load_after: Array, is_new_contact: NDArray[np.bool_]
) -> Array:
    """Fraction of a step, up to its end, in which a punch that comes into contact within the step
    is in contact, (m, k). The load beyond the punch, which is linear in the step, is then positive.

    Loads beyond the punch before and after the step are (m, k) [force per thickness],
    `is_new_contact` is (m, 1). 0 where the load does not grow, or the punch was in contact.
    """
    load_gain = np.where(
        is_new_contact & (load_after > load_before), load_after - load_before, np.inf
    )
    return np.clip(load_after / load_gain, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class PieceTable:
    """The pieces of all memory curves as arrays (k,), with the fields of a `Piece`."""

    number_below: Indices
    top_s: Array
    profile_load: Array
    parabola_load: Array
    fourth_load: Array
    locked_in_force: Array
    profile_slope: Array
    parabola_slope: Array
    fourth_slope: Array

    def piece_numbers_of_curve(self, uppermost_piece: int) -> Indices:
        """Numbers of the pieces of one memory curve, from the empty one, 0, to the uppermost."""
        numbers = [uppermost_piece]
        while numbers[-1]:
            numbers.append(int(self.number_below[numbers[-1]]))
        return np.array(numbers[::-1])

    def pieces_of_curves(self, uppermost_pieces: Indices) -> tuple[PieceTable, Indices]:
        """Table of only those pieces of which the memory curves at some instants consist, and the
        numbers in that table of their uppermost pieces, (n,).

        A memory curve is the locked-in tangential force of the flat punches up to each half-width.
        It is a chain of pieces from the middle of the contact outwards. `uppermost_pieces` (n,) are
        the numbers of their uppermost pieces in this table. `number_below` of a piece is the number
        of the one that it continues.
        """
        # Down the chains from their uppermost pieces, all at once, until no new piece is met.
        is_needed = np.zeros(len(self.number_below), dtype=bool)
        piece_numbers = np.unique(uppermost_pieces)
        while len(piece_numbers):
            is_needed[piece_numbers] = True
            piece_numbers = np.unique(self.number_below[piece_numbers])
            piece_numbers = piece_numbers[~is_needed[piece_numbers]]
        is_needed[0] = True  # the empty curve
        numbers_needed = np.flatnonzero(is_needed)
        new_number = np.cumsum(is_needed) - 1
        # The numbers of pieces below become those of the smaller table.
        columns = {field.name: getattr(self, field.name)[numbers_needed] for field in fields(self)}
        columns["number_below"] = new_number[columns["number_below"]]
        return PieceTable(**columns), new_number[uppermost_pieces]

    @cached_property
    def _pieces_by_depth(self) -> list[Indices]:
        """Numbers of the pieces, grouped by the number of pieces below each in its memory curve:
        first those on the empty curve, piece 0; then those on the first group; and so on.

        A memory curve is the locked-in tangential force of the flat punches up to each half-width.
        """
        # number_below: number of the piece that each continues; smaller than its own number.
        depth_list = [0]
        for number_below in self.number_below[1:].tolist():
            depth_list.append(depth_list[number_below] + 1)
        depth = np.array(depth_list)
        numbers_by_depth = np.argsort(depth, kind="stable")
        # The first group is the empty curve alone.
        groups = np.split(numbers_by_depth, np.cumsum(np.bincount(depth))[:-1])
        return groups[1:]

    def integrals_at_tops(self, *terms: tuple[Array, Array]) -> Array:
        """Integrals int w dF along the memory curves, from the middle of the contact to the top of
        each of the k pieces, (k, ...).

        A memory curve is F, the locked-in tangential force of the flat punches up to each
        half-width. On a piece dF = profile_slope d eta + parabola_slope dG + fourth_slope dG_4.
        eta, G and G_4 are the loads that press the profile, x^2/2 and x^4/24 into contact up to
        that half-width.

        Parameters
        ----------
        terms
            each: one of these slopes (k,), and int w d eta, int w dG or int w dG_4 from the middle
            to the tops (k, ...); w(c) is a quantity of a punch of half-width c under unit load;
            more axes are those of w, such as places
        """
        # Number of the piece that each continues inwards; 0 is the empty curve.
        number_below = self.number_below
        integrals = np.zeros_like(terms[0][1])
        for slopes, primitives in terms:
            if np.any(slopes):
                rise_on_piece = primitives - primitives[number_below]
                slopes_as_column = slopes.reshape((-1,) + (1,) * (primitives.ndim - 1))
                integrals += slopes_as_column * rise_on_piece
        integrals[0] = 0.0
        # To its own part each piece adds the integral up to the piece below: lower groups first.
        # The first group of _pieces_by_depth lies on the empty curve and has nothing below.
        for piece_numbers in self._pieces_by_depth[1:]:
            integrals[piece_numbers] += integrals[number_below[piece_numbers]]
        return integrals


def follow(
    table: PunchTable,
    friction: float,
    normal_load: Array,
    tangential_load: Array,
    curvatures: Curvatures,
    path_of_half_planes: FollowedPath | None = None,
) -> FollowedPath:
    """Stick edges, slip zones and memory curves at the n ends of the straight steps of a load path
    from the unloaded state. Finite bodies add curvatures to half-planes.

    The memory curve is the locked-in tangential force of the flat punches that make up the contact,
    up to each half-width. It does not change in stick; slip clips it at the Coulomb limit.

    Parameters
    ----------
    table
        loads of the flat punches by the half-width
    friction
        f
    normal_load, tangential_load
        (n,) P and Q at the ends of the steps [force per thickness]
    curvatures
        what a unit of P and of Q adds to the gap and to the tangential displacement of the faces
    path_of_half_planes
        the same path without curvatures, if it is known; else it is followed here if needed

    Examples
    --------

    >>> import numpy as np
    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=4 / np.pi, radius=1.0, datum_length=1.0)  # a^2 = P
    >>> table = PunchTable(contact, contact.modulus, largest_half_width=1.2)
    >>> rows = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.3], [1.0, -0.3], [1.0, 0.3]])
    >>> followed_path = follow(table, 0.5, *rows.T, Curvatures())
    >>> table.half_width(followed_path.stick_edge_s[-2:]).round(
    ...     9
    ... ).tolist()  # c = a sqrt(1 - Q/(f P))
    [0.632455532, 0.632455532]
    """
    # (10, n): P, Q, curvatures kn, kt, n4, t4, and s, eta, G, G_4 of the edge of contact at each
    # instant, the fields of a `Row`.
    columns = _columns_of_path(table, normal_load, tangential_load, curvatures)
    # T_22: the second moment of the shear adds to the curvature of the faces under Q. The path of
    # half-planes gives that moment.
    if curvatures.tangential_mixed:
        if path_of_half_planes is None:
            path_of_half_planes = follow(
                table, friction, normal_load, tangential_load, Curvatures()
            )
        shear_second_moment = _estimated_shear_second_moment(table, columns, path_of_half_planes)
        # _INDEX_OF_TANGENTIAL_CURVATURE: 3, that of kt among the ten quantities.
        columns[_INDEX_OF_TANGENTIAL_CURVATURE] += (
            2 * curvatures.tangential_mixed * shear_second_moment
        )
    return _followed_rows(table, friction, columns)


def _estimated_shear_second_moment(
    table: PunchTable, columns: Array, path_of_half_planes: FollowedPath
) -> Array:
    """Second moment of the shear traction, q_2 = int x^2 q dx, at each instant of the path, (n,),
    estimated from that of half-planes.

    q_2 = (q_2 of half-planes) (p_2/(p_2 of half-planes)), with p_2 = int x^2 p dx of the pressure.
    The work W is changed by this estimate a hundred times less than by the curvatures of sixth and
    higher order, which are neglected anyway.

    Parameters
    ----------
    table
        loads and moments of the flat punches, by the coordinate s of their half-width
    columns
        (10, n) at each instant, the fields of a `Row`: P and Q; the curvatures kn, kt, n4, t4 of
        gap and faces under them; s of the edge of contact; the loads of the punches up to it
    path_of_half_planes
        the same path without curvatures
    """
    # Row._fields: names of the ten quantities, among them the curvatures kn and n4 of the gap and
    # the coordinate s of the edge of contact.
    columns_by_name = dict(zip(Row._fields, columns, strict=True))
    pressure_moment = _pressure_moment(
        table.second_moments(columns_by_name["edge_s"]),
        columns_by_name["normal_curvature"],
        columns_by_name["normal_fourth"],
    )
    pressure_moment_of_half_planes = path_of_half_planes.pressure_second_moment
    pressure_moment_ratio = np.divide(
        pressure_moment,
        pressure_moment_of_half_planes,
        out=np.zeros_like(pressure_moment),
        where=pressure_moment_of_half_planes > 0,
    )
    return path_of_half_planes.shear_second_moment * pressure_moment_ratio


def _pressure_moment(at_edge: PunchMoments, curvature: Array, fourth_coefficient: Array) -> Array:
    """Moment, or another integral, of the contact pressure of n contacts, (n,): that of the punches
    of the profile, plus kn times that of x^2/2, plus n4 times that of x^4/24.

    Parameters
    ----------
    at_edge
        the same integral over the flat punches up to the edge of contact, (n,) each: over those of
        the profile, of x^2/2 and of x^4/24
    curvature, fourth_coefficient
        kn and n4 (n,): factors of x^2/2 and x^4/24 that the bodies add to the gap
    """
    moment_by_curvature = curvature * at_edge.parabola_integral
    return np.asarray(
        at_edge.profile_integral
        + moment_by_curvature
        + fourth_coefficient * at_edge.fourth_integral
    )


def _columns_of_path(
    table: PunchTable, normal_load: Array, tangential_load: Array, curvatures: Curvatures
) -> Array:
    """Loads, curvatures of gap and faces under them, and edge of contact at each of the n instants
    of a load path, (10, n): ten quantities, the fields of a `Row` in their order.

    - P and Q;
    - kn and kt, the factors of x^2/2 that the bodies add to the gap and to the tangential
      displacement of the faces;
    - n4 and t4, those of x^4/24;
    - s of the edge of contact, in the table of punches;
    - eta, G and G_4, the loads that press the profile, x^2/2 and x^4/24 into contact up to the
      edge.

    kn depends on the second moment p_2 of the pressure and p_2 on the edge: they are iterated, at
    most eight times. In kt the part by the second moment of the shear traction is left out.

    Parameters
    ----------
    table
        loads and moments of the flat punches, by the coordinate s of their half-width
    curvatures
        what the bodies add per unit load to gap and faces; normal_fourth: N_4, tangential_fourth:
        T_4, normal_mixed: N_22, by which p_2 adds 2 N_22 p_2 to kn
    """
    # kn without p_2, kt without q_2, n4 and t4.
    curvature_without_p2 = curvatures.gap_curvature_under(normal_load, tangential_load)
    tangential_curvature = curvatures.face_curvature_under(normal_load, tangential_load)
    gap_fourth_coefficient = curvatures.normal_fourth * normal_load
    faces_fourth_coefficient = curvatures.tangential_fourth * tangential_load
    normal_curvature = curvature_without_p2
    edge_s = table.edge_s_of_loads(normal_load, normal_curvature, gap_fourth_coefficient)
    if curvatures.normal_mixed:
        for _ in range(_MOST_MOMENT_ITERATIONS):
            moments_at_edge = table.second_moments(edge_s)
            pressure_moment = _pressure_moment(
                moments_at_edge, normal_curvature, gap_fourth_coefficient
            )
            curvature_before = normal_curvature
            normal_curvature = curvature_without_p2 + 2 * curvatures.normal_mixed * pressure_moment
            edge_s = table.edge_s_of_loads(
                normal_load, normal_curvature, gap_fourth_coefficient, edge_s
            )
            # Until the load that the last change of kn moves is 1e-12 of the largest P.
            load_change = np.max(
                np.abs(normal_curvature - curvature_before) * table.parabola_load(edge_s)
            )
            if load_change <= _LOAD_SHARE_MOVED_BY_MOMENT * np.max(normal_load):
                break
    columns = [
        normal_load,
        tangential_load,
        normal_curvature,
        tangential_curvature,
        gap_fourth_coefficient,
        faces_fourth_coefficient,
        edge_s,
        table.profile_load(edge_s),
        table.parabola_load(edge_s),
        table.fourth_load(edge_s),
    ]
    return np.stack(columns)


def _followed_rows(table: PunchTable, friction: float, columns: Array) -> FollowedPath:
    """Memory of friction, stick edges and slip zones along a load path from the unloaded state, at
    its n instants.

    Parameters
    ----------
    table
        loads of the flat punches, by the coordinate s of their half-width
    friction
        f
    columns
        (10, n) at each instant: P and Q; the curvatures kn, kt, n4, t4 of gap and faces under them;
        s of the edge of contact; the loads eta, G and G_4 of the punches up to it

    # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to the
    #           half-width of a punch
    """
    # Step by step from the unloaded state; a step gives the new state of the memory.
    # Pieces(): list of the pieces of memory curves, with the empty curve alone at first.
    friction_memory = FrictionMemory(table, friction, float(np.max(columns[0])), Pieces())
    memory_state = UNLOADED_STATE
    steps = []
    for values_at_instant in columns.T.tolist():
        memory_step = friction_memory.step(memory_state, Row(*values_at_instant))
        memory_state = memory_step.state
        steps.append(memory_step)
    return path_of_steps(friction_memory, columns, steps)


def path_of_steps(
    memory: FrictionMemory, columns: Array, steps: Sequence[MemoryStep]
) -> FollowedPath:
    """Arrays over the n instants of a load path, from the single steps that were taken along it.

    Attributes that end in `_s` are half-widths as the coordinate s of the table of flat punches.

    Parameters
    ----------
    memory
        holds the pieces of the memory curves of all steps: locked-in tangential force of the flat
        punches up to each half-width
    columns
        (10, n) at each instant: P and Q; the curvatures kn, kt, n4, t4 of gap and faces under them;
        s of the edge of contact; the loads eta, G and G_4 of the punches up to it
    steps
        n steps: at the end of each the number of the uppermost piece of the memory curve, the stick
        edge and the slip zones

    # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to the
    #           half-width of a punch
    """
    pieces = memory.pieces
    # The fields of all pieces, one piece after another.
    flat_fields = np.fromiter(chain.from_iterable(pieces), float, len(pieces) * len(Piece._fields))
    number_below, *float_columns = flat_fields.reshape(len(pieces), -1).T
    piece_table = PieceTable(number_below.astype(np.int64), *float_columns)
    # Row._fields: names of the columns.
    columns_by_name = dict(zip(Row._fields, columns, strict=True))
    return FollowedPath(
        table=memory.table,
        friction=memory.friction,
        normal_load=columns_by_name["normal_load"],
        tangential_load=columns_by_name["tangential_load"],
        normal_curvature=columns_by_name["normal_curvature"],
        tangential_curvature=columns_by_name["tangential_curvature"],
        normal_fourth=columns_by_name["normal_fourth"],
        tangential_fourth=columns_by_name["tangential_fourth"],
        edge_s=columns_by_name["edge_s"],
        stick_edge_s=np.array([step.stick_edge_s for step in steps]),
        direction=np.array([step.direction for step in steps], dtype=np.int64),
        inner_zone_s=np.array([step.inner_zone_s for step in steps]),
        inner_zone_direction=np.array(
            [step.inner_zone_direction for step in steps], dtype=np.int64
        ),
        uppermost_piece=np.array([step.state.uppermost_piece for step in steps], dtype=np.int64),
        pieces=piece_table,
    )


class Row(NamedTuple):
    """Loads, curvatures and edge of contact at the end of a step: ten quantities.

    Attributes
    ----------
    normal_load, tangential_load
        P and Q [force per thickness]
    normal_curvature, tangential_curvature
        kn and kt, factors of x^2/2 that the bodies add to the gap and to the tangential
        displacement of the faces [1/length]
    normal_fourth, tangential_fourth
        n4 and t4, factors of x^4/24 there [1/length^3]
    edge_s
        s of the edge of contact in the table of flat punches
    edge_load, edge_parabola_load, edge_fourth_load
        eta, G and G_4 at the edge: loads that press the profile, x^2/2 and x^4/24 into contact up
        to there
    """

    normal_load: float
    tangential_load: float
    normal_curvature: float
    tangential_curvature: float
    normal_fourth: float
    tangential_fourth: float
    edge_s: float
    edge_load: float
    edge_parabola_load: float
    edge_fourth_load: float

    @property
    def edge_loads(self) -> LoadTriple:
        """eta, G and G_4 of the edge of contact."""
        return self.edge_load, self.edge_parabola_load, self.edge_fourth_load


class MemoryState(NamedTuple):
    """What a contact remembers.

    Attributes
    ----------
    uppermost_piece
        number of the uppermost piece of its memory curve, which holds those below by their
        numbers; 0 is the empty curve
    last_direction
        direction of slip in the last step, +1 or -1, that of the inner slip zone if there was one;
        0 in full stick
    """

    uppermost_piece: int = 0
    last_direction: int = 0


UNLOADED_STATE = MemoryState()
_INDEX_OF_TANGENTIAL_CURVATURE = Row._fields.index("tangential_curvature")


class MemoryStep(NamedTuple):
    """Memory at the end of a step, and its slip zones. s is the coordinate of a half-width in the
    table of flat punches.

    Attributes
    ----------
    state
        what is remembered
    stick_edge_s
        s of the stick edge; of the edge of contact where that sticks
    direction
        direction of slip at the edge of contact, +1 or -1; 0 where it sticks
    inner_zone_s
        s of the inner and the outer end of an inner slip zone
    inner_zone_direction
        direction of slip there, +1 or -1; 0 without such a zone
    """

    state: MemoryState
    stick_edge_s: float
    direction: int = 0
    inner_zone_s: tuple[float, float] = (0.0, 0.0)
    inner_zone_direction: int = 0


@dataclass(frozen=True, eq=False)
class FrictionMemory:
    """Memory of friction of a contact, which straight steps of the loads change; a step returns a
    new state and leaves the old one as it is.

    Attributes
    ----------
    table
        the flat punches
    friction
        f
    largest_load
        largest P of the path, by which round-off is judged
    pieces
        pieces of the memory curves of all states so far
    """

    table: PunchTable
    friction: float
    largest_load: float
    pieces: Pieces

    def is_unloaded(self, normal_load: float) -> bool:
        """Whether P is 0 but for round-off: the bodies are apart, and nothing is remembered."""
        return normal_load <= _ROUND_OFF_FORCE_SHARE * self.largest_load

    def step(self, state: MemoryState, row: Row) -> MemoryStep:
        """Memory curve, stick edge and slip zones at the end of a straight step of the loads.

        The memory curve is the locked-in tangential force F of the flat punches up to each
        half-width. First it is cut at the new edge of contact, or extended to it in stick. Then,
        from the edge inwards, F is set to the Coulomb bound as far as F is beyond that bound. When
        the edge of contact stops slipping, or slips the other way, points further in may still slip
        as before: an inner slip zone. Where the bodies are apart, P = 0, nothing is remembered.

        Parameters
        ----------
        state
            memory before the step: number of the uppermost piece of the curve, and direction of
            slip in the step before, 0 for none
        row
            P, Q, curvatures of gap and faces, and edge of contact at the end of the step

        # notation: P, Q normal and tangential load, s coordinate of the half-width of a punch in
        #           the table
        """
        if self.is_unloaded(row.normal_load):
            return MemoryStep(UNLOADED_STATE, stick_edge_s=row.edge_s)
        pieces = self.pieces
        # 1e-11 of f times the largest P of the path.
        force_roundoff = _ROUND_OFF_FORCE_SHARE * self.friction * self.largest_load

        # piece_at_edge: the uppermost piece, which ends at the edge of contact.
        # uppermost_number: its number, None as long as it is not stored.
        piece_at_edge, uppermost_number = self._fit_to_edge(state.uppermost_piece, row)
        # _s: coordinate s in the table of flat punches.
        stick_edge_s = row.edge_s

        # +1 or -1; 0 where the edge of contact sticks.
        direction = _slip_direction_at_edge(
            piece_at_edge,
            pieces[piece_at_edge.number_below],
            self.friction,
            row,
            force_roundoff,
        )

        # Slip at the edge: the slip zone is taken off the curve, down to where F meets its bound.
        coulomb_bound = None
        if direction:
            coulomb_bound = _coulomb_bound_of(direction, self.friction, row)
            uppermost_number = _cut_at_end_of_slip(
                self.table, pieces, piece_at_edge, uppermost_number, coulomb_bound, force_roundoff
            )
            stick_edge_s = pieces[uppermost_number].top_s
        elif uppermost_number is None:
            uppermost_number = pieces.append_and_number(piece_at_edge)
        inner_zone_s = (0.0, 0.0)
        inner_zone_direction = 0
        if state.last_direction and direction != state.last_direction:
            # Further in, slip in the last direction may continue.
            bound_of_last_slip = _coulomb_bound_of(state.last_direction, self.friction, row)
            uppermost_number, inner_end, outer_end = _add_inner_slip_zone(
                self.table, pieces, uppermost_number, bound_of_last_slip, force_roundoff
            )
            inner_zone_s = (inner_end, outer_end)
            if outer_end > inner_end:
                inner_zone_direction = state.last_direction
        if coulomb_bound is not None:
            # The slip zone at the edge, where F is the bound.
            uppermost_number = pieces.add_piece(
                uppermost_number, row.edge_s, row.edge_loads, coulomb_bound.slopes
            )
        return MemoryStep(
            MemoryState(uppermost_number, inner_zone_direction or direction),
            stick_edge_s,
            direction,
            inner_zone_s,
            inner_zone_direction,
        )

    def _fit_to_edge(self, uppermost_number: int, row: Row) -> tuple[Piece, int | None]:
        """Uppermost piece of the memory curve after it is cut at the new edge of contact, or
        extended to it in stick; and its number, None if it is new and not stored yet.

        The memory curve is the locked-in tangential force F of the flat punches up to each
        half-width. Extended, it gets a piece on which F is linear in eta; on a flat, where eta is
        0, in G. At the new edge F = Q - kt G - t4 G_4: all of Q is carried within it, of which the
        curvatures of the faces carry kt G + t4 G_4.

        Parameters
        ----------
        uppermost_number
            number of the uppermost piece before the step
        row
            loads, curvatures and edge of contact at the end of the step

        # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to
        #           the half-width of a punch; kt, t4 curvatures of the faces under the loads
        """
        # row.edge_s: coordinate s of the new edge of contact; edge_load, edge_parabola_load and
        # edge_fourth_load: eta, G and G_4 of the punches up to it; row.tangential_curvature and
        # row.tangential_fourth: kt and t4. top_s: s of the outer end of a piece.
        pieces = self.pieces
        piece_number = uppermost_number
        memory_piece = pieces[piece_number]
        loads_at_edge = row.edge_loads
        if row.edge_s > memory_piece.top_s:
            # The contact has grown: F rises from that of the old edge to that of the new one.
            force_without_fourth = (
                row.tangential_load - row.tangential_curvature * row.edge_parabola_load
            )
            force_rise = (
                force_without_fourth
                - row.tangential_fourth * row.edge_fourth_load
                - memory_piece.locked_in_force
            )
            load_rise = row.edge_load - memory_piece.profile_load
            if load_rise > 0:
                force_slopes = (force_rise / load_rise, 0.0, 0.0)
                return pieces.piece_above(
                    uppermost_number, row.edge_s, loads_at_edge, force_slopes
                ), None
            # The profile is still flat here: only the curvature of the bodies carries load.
            force_slopes = (
                0.0,
                force_rise / (row.edge_parabola_load - memory_piece.parabola_load),
                0.0,
            )
            return pieces.piece_above(
                uppermost_number, row.edge_s, loads_at_edge, force_slopes
            ), None

        # The contact recedes: pieces that lie outside the new edge go.
        while piece_number and pieces[memory_piece.number_below].top_s >= row.edge_s:
            piece_number = memory_piece.number_below
            memory_piece = pieces[piece_number]
        if memory_piece.top_s <= row.edge_s:
            return memory_piece, piece_number
        return pieces.piece_above(
            memory_piece.number_below, row.edge_s, loads_at_edge, memory_piece.slopes
        ), None

    def step_of_gross_sliding(self, row: Row, direction: int) -> MemoryStep:
        """Memory state in which the contact slides as a whole in one direction, +1 or -1, whatever
        was before: the locked-in tangential force F is the Coulomb bound of that direction at all
        punches.

        `row` holds loads, curvatures and edge of contact at the end of the step. The curve is one
        piece from the middle (piece 0 is the empty curve) to the edge.

        # notation: eta, G, G_4 loads that press the profile, x^2/2 and x^4/24 into contact up to
        #           the half-width of a punch
        """
        bound = _coulomb_bound_of(direction, self.friction, row)
        # bound.slopes: of the Coulomb bound per d eta, dG and dG_4; the new piece of F has them.
        piece_number = self.pieces.add_piece(0, row.edge_s, row.edge_loads, bound.slopes)
        return MemoryStep(
            MemoryState(piece_number, direction), stick_edge_s=0.0, direction=direction
        )


def _coulomb_bound_of(direction: int, friction: float, row: Row) -> _Bound:
    """Coulomb bound of the locked-in tangential force F in one `direction` of slip, +1 or -1, at
    the end of a step: the value that F takes while punches slip.

        B = (Q - s f P) + s f eta + (s f kn - kt) G + (s f n4 - t4) G_4,    s direction

    eta, G and G_4 are the loads that press the profile, x^2/2 and x^4/24 into contact up to the
    half-width of a punch. `row` holds P, Q and the curvatures kn, n4 of the gap and kt, t4 of the
    faces.
    """
    # row: normal_curvature, normal_fourth are kn and n4; tangential_curvature, tangential_fourth kt
    # and t4.
    signed_friction = direction * friction
    return _Bound(
        direction,
        constant=row.tangential_load - signed_friction * row.normal_load,
        profile_slope=signed_friction,
        parabola_slope=signed_friction * row.normal_curvature - row.tangential_curvature,
        fourth_slope=signed_friction * row.normal_fourth - row.tangential_fourth,
    )


def _slip_direction_at_edge(
    piece_at_edge: Piece, piece_below: Piece, friction: float, row: Row, force_roundoff: float
) -> int:
    """Direction of slip at the edge of contact, +1 or -1; 0 if the edge sticks.

        |Q - kt G - t4 G_4 - F| > f [P - eta - kn G - n4 G_4]

    The edge slips if this holds at one end of the uppermost piece of the memory curve F, the force
    that flat punches lock in: more tangential force is then carried outside of that point than f
    times the normal load there. eta, G and G_4 are the loads that press the profile, x^2/2 and
    x^4/24 into contact up to there.

    Parameters
    ----------
    piece_at_edge, piece_below
        uppermost piece of the memory curve, and the one from whose outer end it continues
    friction
        f
    row
        P, Q and the curvatures kn, n4 of the gap and kt, t4 of the faces at the end of the step
    force_roundoff
        excess of force that counts as 0
    """
    # Of each piece the attributes are those at its outer end.
    for piece_end in (piece_at_edge, piece_below):
        force_beyond = row.tangential_load - row.tangential_curvature * piece_end.parabola_load
        force_beyond -= row.tangential_fourth * piece_end.fourth_load + piece_end.locked_in_force
        load_beyond = (
            row.normal_load
            - piece_end.profile_load
            - row.normal_curvature * piece_end.parabola_load
        )
        load_beyond -= row.normal_fourth * piece_end.fourth_load
        if abs(force_beyond) - friction * load_beyond > force_roundoff:
            return 1 if force_beyond > 0 else -1
    return 0


def _cut_at_end_of_slip(
    table: PunchTable,
    all_pieces: Pieces,
    memory_piece: Piece,
    piece_number: int | None,
    coulomb_bound: _Bound,
    force_roundoff: float,
) -> int:
    """Cut the slip zone next to the edge of contact off a memory curve: number of the uppermost
    piece that is left, which still sticks. The outer end of that piece is the stick edge.

    The curve is the locked-in tangential force F of the flat punches up to each half-width. The
    zone ends where F meets its Coulomb bound. If that is within a piece, its inner part becomes a
    new piece.

    Parameters
    ----------
    table
        loads of the flat punches by their coordinate s
    all_pieces
        all pieces of memory curves
    memory_piece, piece_number
        the uppermost one of this curve, and its number, None if it is not stored yet
    coulomb_bound
        what F is during slip in the direction of the zone
    force_roundoff
        excess of F over the bound that counts as 0
    """
    # Inwards, past all pieces that slip as a whole. excess_at_top: how far F at the outer end of a
    # piece is beyond the bound; number_below: number of the piece that it continues.
    empty_curve = all_pieces[0]
    piece_below = all_pieces[memory_piece.number_below]
    while (
        memory_piece is not empty_curve
        and coulomb_bound.excess_at_top(piece_below) > force_roundoff
    ):
        piece_number = memory_piece.number_below
        memory_piece = piece_below
        piece_below = all_pieces[memory_piece.number_below]
    # The zone ends at one of the two ends of this piece, or within it.
    excess_below = coulomb_bound.excess_at_top(piece_below)
    if excess_below >= 0:
        return memory_piece.number_below
    excess_of_piece = coulomb_bound.excess_at_top(memory_piece)
    if excess_of_piece <= 0:
        return all_pieces.append_and_number(memory_piece) if piece_number is None else piece_number
    # F meets the bound within the piece: its inner part, up to there, sticks.
    crossing_s, loads_at_crossing = _crossing_of_bound(
        table,
        (piece_below, memory_piece),
        (excess_below, excess_of_piece),
        coulomb_bound,
        force_roundoff,
    )
    return all_pieces.add_piece(
        memory_piece.number_below, crossing_s, loads_at_crossing.loads, memory_piece.slopes
    )


def _add_inner_slip_zone(
    table: PunchTable,
    all_pieces: Pieces,
    uppermost_number_before: int,
    coulomb_bound: _Bound,
    force_roundoff: float,
) -> tuple[int, float, float]:
    """Set the memory curve to its Coulomb bound in a slip zone inside the contact: number of the
    uppermost piece of the curve then, and s of the inner and outer end of the zone (equal if there
    is none).

    The memory curve is the locked-in tangential force F of the flat punches up to each half-width.
    A slip zone inside the contact forms when points further in still slip as before, while the edge
    of contact already sticks or slips the other way.

    Parameters
    ----------
    table
        loads of the flat punches by their coordinate s
    all_pieces, uppermost_number_before
        all pieces of memory curves, and the number of the uppermost one of this curve
    coulomb_bound
        what F is during slip in the direction of the zone
    force_roundoff
        excess of F over the bound that counts as 0
    """
    # From the edge inwards to the first piece at whose inner end F is beyond the bound.
    # number_below: number of the piece that a piece continues; excess_at_top: of F over the bound
    # at its outer end.
    piece_number = uppermost_number_before
    memory_piece = all_pieces[piece_number]
    sticking_pieces_outside = []
    while (
        piece_number
        and coulomb_bound.excess_at_top(all_pieces[memory_piece.number_below]) <= force_roundoff
    ):
        sticking_pieces_outside.append(memory_piece)
        piece_number = memory_piece.number_below
        memory_piece = all_pieces[piece_number]
    excess_of_piece = coulomb_bound.excess_at_top(memory_piece)
    if not piece_number or excess_of_piece > 0:
        edge_s = all_pieces[uppermost_number_before].top_s
        return uppermost_number_before, edge_s, edge_s

    # F meets the bound within this piece: there the zone ends outwards; it ends inwards further in.
    piece_below = all_pieces[memory_piece.number_below]
    excesses_at_ends = (coulomb_bound.excess_at_top(piece_below), excess_of_piece)
    outer_end_s, loads_at_outer_end = _crossing_of_bound(
        table, (piece_below, memory_piece), excesses_at_ends, coulomb_bound, force_roundoff
    )
    number_below_zone = _cut_at_end_of_slip(
        table, all_pieces, piece_below, memory_piece.number_below, coulomb_bound, force_roundoff
    )
    uppermost_number = all_pieces.add_piece(
        number_below_zone, outer_end_s, loads_at_outer_end.loads, coulomb_bound.slopes
    )

    # On top of the zone again what sticks outside of it.
    for sticking_piece in (memory_piece, *reversed(sticking_pieces_outside)):
        uppermost_number = all_pieces.add_piece(
            uppermost_number, sticking_piece.top_s, sticking_piece.loads, sticking_piece.slopes
        )
    return uppermost_number, all_pieces[number_below_zone].top_s, outer_end_s


def _crossing_of_bound(
    table: PunchTable,
    neighbouring_pieces: tuple[Piece, Piece],
    excesses_at_tops: tuple[float, float],
    coulomb_bound: _Bound,
    force_roundoff: float,
) -> tuple[float, PunchLoads]:
    """Coordinate s at which a piece of the memory curve crosses the Coulomb bound of slip, and the
    loads of the flat punches up to there.

    The memory curve is the locked-in tangential force F of the flat punches up to each half-width.
    On a piece F and the bound are linear in eta, G and G_4, the loads that press the profile, x^2/2
    and x^4/24 into contact up to that half-width. The zero of their difference over s is found by
    Newton's method, bracketed by the ends of the piece.

    Parameters
    ----------
    table
        loads of the flat punches by their coordinate s
    neighbouring_pieces
        the piece below, and the piece itself
    excesses_at_tops
        of F over the bound at the tops of the two pieces, of opposite signs
    coulomb_bound
        direction of slip, and derivatives of the bound with respect to eta, G and G_4
    force_roundoff
        excess that counts as 0 [force per thickness]
    """
    # Bracket of s: the two ends of the piece, at its top and at that of the piece below.
    piece_below, piece = neighbouring_pieces
    low_s = piece_below.top_s
    high_s = piece.top_s
    excess_below, excess_above = excesses_at_tops
    sign_of_rise = 1.0 if excess_above > excess_below else -1.0
    excess_on_piece = _ExcessOnPiece(
        piece_below,
        excess_below,
        profile_slope=coulomb_bound.direction * (coulomb_bound.profile_slope - piece.profile_slope),
        parabola_slope=coulomb_bound.direction
        * (coulomb_bound.parabola_slope - piece.parabola_slope),
        fourth_slope=coulomb_bound.direction * (coulomb_bound.fourth_slope - piece.fourth_slope),
    )

    # First guess: without x^4 the excess of a parabolic profile is a straight line over G.
    fraction_of_piece = excess_below / (excess_below - excess_above)
    s = table.s_of_parabola_load(
        piece_below.parabola_load
        + fraction_of_piece * (piece.parabola_load - piece_below.parabola_load)
    )
    if not low_s < s < high_s:
        s = low_s + fraction_of_piece * (high_s - low_s)
    loads_at_s = table.punch_loads_at(s)

    # Newton's method; a step that would leave the bracket is replaced by a bisection.
    # _MOST_NEWTON_STEPS: 60.
    for _ in range(_MOST_NEWTON_STEPS):
        excess = excess_on_piece.at(loads_at_s)
        if abs(excess) <= force_roundoff:
            break
        if excess * sign_of_rise > 0:
            high_s = s
        else:
            low_s = s
        excess_rate = excess_on_piece.rate_at(loads_at_s)
        newton_s = s - excess / excess_rate if excess_rate * sign_of_rise > 0 else math.nan
        s = newton_s if low_s < newton_s < high_s else (low_s + high_s) / 2
        loads_at_s = table.punch_loads_at(s)
    return s, loads_at_s


class _ExcessOnPiece(NamedTuple):
    """Excess of the locked-in tangential force F over the Coulomb bound of slip, along one piece of
    a memory curve: linear in eta, G and G_4, the loads that press the profile, x^2/2 and x^4/24
    into contact up to the half-width of a punch.

    Attributes
    ----------
    piece_below
        the piece below, with these loads at its top, where this piece begins
    excess_below
        excess there [force per thickness]
    profile_slope, parabola_slope, fourth_slope
        of the excess, per d eta, dG and dG_4
    """

    piece_below: Piece
    excess_below: float
    profile_slope: float
    parabola_slope: float
    fourth_slope: float

    def at(self, loads: PunchLoads) -> float:
        """The excess at the punch up to which the punches carry these loads."""
        piece_below = self.piece_below
        excess = self.excess_below + self.profile_slope * (
            loads.profile_load - piece_below.profile_load
        )
        excess += self.parabola_slope * (loads.parabola_load - piece_below.parabola_load)
        excess += self.fourth_slope * (loads.fourth_load - piece_below.fourth_load)
        return excess

    def rate_at(self, loads: PunchLoads) -> float:
        """Derivative of the excess with respect to the coordinate s of the punch; `loads` has those
        of the loads as rates.
        """
        excess_rate = self.profile_slope * loads.load_rate
        excess_rate += self.parabola_slope * loads.parabola_rate
        excess_rate += self.fourth_slope * loads.fourth_rate
        return excess_rate
