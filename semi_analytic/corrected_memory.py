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
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes.array_types import Array
from semi_analytic.profiles import SymmetricContact

Indices = NDArray[np.int64]

# Cells of the table between two corners: cubics leave 1e-12 of a load at 512, 4e-9 at 64.
_CELLS, _FEWEST_CELLS = 512, 64
_MOST_CELLS = 4096
_BISECTIONS = 60
# Of many edges of contact at once: an eighth of a cell, and then Newton's rule, which halves the
# error four times at worst before it squares it.
_FIRST_BISECTIONS, _STEPS_AFTER = 12, 6
# Of edges that are known to a share of 1e-3.
_STEPS_NEAR = 2
_STEPS_OF_NEWTON = 60
# Share of f P below which a difference of forces is round-off. A steady cycle slips along the line
# of the cycle before: differences of the two are sums over all pieces of the curve, and reach a few
# 1e-13. Taken for slip they move the edge of stick to an older piece.
_ROUNDING = 1e-11
# Share of the largest half-width that stands for 0 in a logarithm.
_LEAST = 1e-9
# How often p_2 and the edge of contact follow from each other, at most and until the load of what
# they change is this share of P: p_2 moves by a per cent of itself.
_ROUNDS_OF_MOMENT = 8
_LEFT_OF_MOMENT = 1e-12
_GAUSS = np.polynomial.legendre.leggauss(3)
# Between two tops of a memory curve: |dF| is a cubic in s there for Hertz.
_GAUSS_OF_WORK = np.polynomial.legendre.leggauss(8)


def area_of_loop(load: Array, movement: Array) -> float:
    """Integral of a load over its movement, (n,) each, by straight steps; of a cycle its loop."""
    means = (load[1:] + load[:-1]) / 2
    return float(np.sum(means * np.diff(movement)))


# ---------------------------------------------------------------------------------- flat punches
# Of the punches of the profile, of a parabola and of x^4/24.
OfPunches = tuple[float, float, float]


class PunchLoads(NamedTuple):
    """eta, G and G_4 of one punch, and their rates per s."""

    load: float
    parabola: float
    fourth: float
    load_rate: float
    parabola_rate: float
    fourth_rate: float

    @property
    def loads(self) -> OfPunches:
        """eta, G and G_4."""
        return self.load, self.parabola, self.fourth


class PunchSums(NamedTuple):
    """Up to one punch: int ln(2 L/c) and c^2/2 over d eta, and over dG."""

    logarithm: float
    parabola_logarithm: float
    second: float
    parabola_second: float


class PunchMoments(NamedTuple):
    """Up to punches (k,): a moment over d eta, over dG and over dG_4, (k,) each."""

    profile: Array
    parabola: Array
    fourth: Array


class PunchTable:
    """Loads and integrals of the flat punches up to half-width c, along a coordinate s of c.

    Between two corners b of the profile c = b + (b' - b) sigma^2, which takes the roots of P(a)
    behind a corner away; s counts the corners and adds sigma.

    Attributes
    ----------
    last
        the largest s
    parabola_stiffness
        pi E*/4: G(c) over c^2 [stress]
    """

    def __init__(
        self, contact: SymmetricContact, modulus: float, largest_half_width: float
    ) -> None:
        """Tabulate the load eta(c) that flat punches of half-width up to c carry in a contact, for
        c from 0 to `largest_half_width` [length].

        eta(c) is P(a) at a = c. It is stored as cubics on equal cells between the corners of the
        profile, with two integrals of it. Loads of x^2/2 and of x^4/24 need no table: they are
        closed forms.

        Parameters
        ----------
        contact
            P(a) of the profile on half-planes
        modulus
            E* [stress]
        """
        corners = [contact.least_half_width, *contact.breaks]
        inner_corners = sorted({corner for corner in corners if 0 < corner < largest_half_width})
        self._ends = np.array([0.0, *inner_corners, largest_half_width])
        self._begins: list[float] = self._ends[:-1].tolist()
        self._lengths: list[float] = np.diff(self._ends).tolist()
        n_intervals = len(self._lengths)
        self._cells_per_corner = max(min(_CELLS, _MOST_CELLS // n_intervals), _FEWEST_CELLS)
        self.last = float(n_intervals)
        self.parabola_stiffness = math.pi * modulus / 4
        sigma = np.linspace(0.0, 1.0, self._cells_per_corner + 1)
        interval_begin = self._ends[:-1, None]
        interval_length = np.diff(self._ends)[:, None]
        half_width = interval_begin + interval_length * sigma**2
        half_width_rate = 2 * interval_length * sigma
        load = contact.load(half_width)
        load_rate = contact.stiffness(half_width) * half_width_rate
        is_flat = half_width < contact.least_half_width * (1 - 1e-14)
        load = np.where(is_flat, 0.0, load)
        load_rate = np.where(is_flat | (half_width_rate == 0), 0.0, load_rate)
        self._load = self._cubics(load[:, :-1], load[:, 1:], load_rate[:, :-1], load_rate[:, 1:])
        self._loads_of_cells: list[list[float]] = self._load.tolist()
        # int eta dc/c and int eta G dc/c: by parts they give int ln(2 L/c) over d eta and d(eta G).
        self._log_area = self._integral(power=0)
        self._log_moment = self._integral(power=1)
        self._areas_of_cells: list[list[float]] = self._log_area.tolist()
        self._moments_of_cells: list[list[float]] = self._log_moment.tolist()

    def _cubics(
        self, begin_value: Array, end_value: Array, begin_rate: Array, end_rate: Array
    ) -> Array:
        """Cubic polynomials that have given values and slopes at both ends of each cell of the
        table (Hermite interpolation).

        Returns coefficients (cells, 4), constant first. Their variable is the passed share of the
        cell, 0 to 1. The rates are per sigma, which runs from 0 to 1 between two corners of the
        profile.
        """
        cell_length = 1 / self._cells_per_corner
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

    def _integral(self, power: int) -> Array:
        """Cubics for the integral of eta G^power dc/c from 0 to each half-width c of the punches.

        eta(c) (`load`) and G(c) (`parabola`) are the loads that flat punches of half-width up to c
        carry, of the profile and of a parabola. Returns coefficients (cells, 4), constant first, of
        a cubic of the share of each cell; cells are equal steps of the coordinate s of c.
        """
        n_cells = len(self._load)
        nodes, weights = _GAUSS
        share_of_cell = (nodes + 1) / 2
        cell_length = 1 / self._cells_per_corner

        def integrand(s: Array) -> Array:
            half_width = self.half_width(s)
            half_width_rate = self.half_width_rate(s)
            load_per_width = (
                self.load(s) * half_width_rate / np.where(half_width > 0, half_width, 1.0)
            )
            return load_per_width * self.parabola(s) ** power if power else load_per_width

        s_of_nodes = np.asarray(
            (np.arange(n_cells)[:, None] + share_of_cell) * cell_length, dtype=float
        )
        integrals_of_cells = integrand(s_of_nodes) @ weights * (cell_length / 2)
        sums_of_cells = np.concatenate([[0.0], np.cumsum(integrals_of_cells)])
        begins = np.asarray(np.arange(n_cells) * cell_length, dtype=float)
        # Just within its cell, since beyond a corner of the profile another interval begins.
        ends = begins + cell_length * (1 - 1e-12)
        return self._cubics(
            sums_of_cells[:-1], sums_of_cells[1:], integrand(begins), integrand(ends)
        )

    def _value(self, cubics: Array, s: ArrayLike) -> Array:
        place_in_cells = np.asarray(s, dtype=float) * self._cells_per_corner
        cell = np.minimum(place_in_cells.astype(int), len(cubics) - 1)
        share_of_cell = place_in_cells - cell
        c0, c1, c2, c3 = np.moveaxis(cubics[cell], -1, 0)
        return np.asarray(c0 + share_of_cell * (c1 + share_of_cell * (c2 + share_of_cell * c3)))

    def half_width(self, s: ArrayLike) -> Array:
        """c [length]."""
        s_of_punches = np.asarray(s, dtype=float)
        interval = np.minimum(s_of_punches.astype(int), int(self.last) - 1)
        length = np.diff(self._ends)[interval]
        return np.asarray(self._ends[interval] + length * (s_of_punches - interval) ** 2)

    def half_width_rate(self, s: ArrayLike) -> Array:
        """dc/ds [length]."""
        s_of_punches = np.asarray(s, dtype=float)
        interval = np.minimum(s_of_punches.astype(int), int(self.last) - 1)
        length = np.diff(self._ends)[interval]
        return np.asarray(2 * length * (s_of_punches - interval))

    def load(self, s: ArrayLike) -> Array:
        """eta(c): load of the profile's punches up to c [force per thickness]."""
        return self._value(self._load, s)

    def parabola(self, s: ArrayLike) -> Array:
        """G(c) = (pi E*/4) c^2: load of a parabola's punches up to c per curvature."""
        return self.parabola_stiffness * np.square(self.half_width(s))

    def fourth(self, s: ArrayLike) -> Array:
        """G_4(c) = G(c) c^2/8: load of the punches of x^4/24 up to c."""
        square = np.square(self.half_width(s))
        return np.asarray(self.parabola_stiffness * square**2 / 8)

    def place_of(self, parabola: float) -> float:
        """s of the punch up to which a parabola carries G."""
        half_width = math.sqrt(max(parabola, 0.0) / self.parabola_stiffness)
        interval = max(bisect_left(self._begins, half_width) - 1, 0)
        return interval + math.sqrt(
            max(half_width - self._begins[interval], 0.0) / self._lengths[interval]
        )

    def loads_at(self, s: float) -> PunchLoads:
        """Loads that the flat punches up to the one at coordinate s carry, and their rates per s.

        They are eta of the profile [force per thickness], G of a parabola x^2/2 and G_4 of x^4/24,
        each per unit of its factor. For one s this is faster than by arrays. Round-off below 0 in
        eta is cut.

        # notation: c0 to c3 coefficients of a cubic of the share of a cell
        """
        place_in_cells = s * self._cells_per_corner
        cell = min(int(place_in_cells), len(self._loads_of_cells) - 1)
        share_of_cell = place_in_cells - cell
        c0, c1, c2, c3 = self._loads_of_cells[cell]
        interval = min(int(s), len(self._lengths) - 1)
        length = self._lengths[interval]
        half_width = self._begins[interval] + length * (s - interval) ** 2
        half_width_rate = 2 * length * (s - interval)
        squared_width = half_width * half_width
        parabola = self.parabola_stiffness * half_width * half_width
        load = c0 + share_of_cell * (c1 + share_of_cell * (c2 + share_of_cell * c3))
        load_rate = (
            c1 + share_of_cell * (2 * c2 + 3 * share_of_cell * c3)
        ) * self._cells_per_corner
        return PunchLoads(
            load=max(load, 0.0),
            parabola=parabola,
            fourth=parabola * squared_width / 8,
            load_rate=load_rate,
            parabola_rate=2 * self.parabola_stiffness * half_width * half_width_rate,
            fourth_rate=parabola * half_width * half_width_rate / 2,
        )

    def sums_at(self, s: float, datum: float) -> PunchSums:
        """Integrals over the flat punches from the middle to the one at coordinate s, for
        displacements and moments: of ln(2 L/c) and of c^2/2, each over d eta and over dG.

        c is the half-width of a punch, eta and G are the loads of the profile's and of a parabola's
        punches up to c, L = `datum` [length]. For one s this is faster than by arrays.

        # notation: c0 to c3 coefficients of a cubic of the share of a cell
        """
        place_in_cells = s * self._cells_per_corner
        cell = min(int(place_in_cells), len(self._loads_of_cells) - 1)
        share_of_cell = place_in_cells - cell

        def cubic(coefficients_of_cells: list[list[float]]) -> float:
            c0, c1, c2, c3 = coefficients_of_cells[cell]
            return c0 + share_of_cell * (c1 + share_of_cell * (c2 + share_of_cell * c3))

        interval = min(int(s), len(self._lengths) - 1)
        half_width = self._begins[interval] + self._lengths[interval] * (s - interval) ** 2
        squared_width = half_width * half_width
        load = cubic(self._loads_of_cells)
        parabola = self.parabola_stiffness * squared_width
        least_half_width = _LEAST * float(self._ends[-1])
        log_ratio = math.log(2 * datum / max(half_width, least_half_width))
        return PunchSums(
            logarithm=load * log_ratio + cubic(self._areas_of_cells),
            parabola_logarithm=parabola * (log_ratio + 0.5),
            second=squared_width * load / 2
            - cubic(self._moments_of_cells) / self.parabola_stiffness,
            parabola_second=squared_width * parabola / 4,
        )

    def contact_at(self, normal_load: float, curvature: float) -> float:
        """Coordinate s of the flat punch at the edge of contact a under one load P, by bisection of
        P = eta(a) + kn G(a).

        eta(c) and G(c) are the loads that punches up to half-width c carry, of the profile and of a
        parabola x^2/2. `curvature` is kn, the factor of x^2/2 that the bodies add to the gap
        [1/length].
        """
        low_s = 0.0
        high_s = self.last
        for _ in range(_BISECTIONS):
            middle_s = (low_s + high_s) / 2
            loads = self.loads_at(middle_s)
            if loads.load + curvature * loads.parabola <= normal_load:
                low_s = middle_s
            else:
                high_s = middle_s
        return (low_s + high_s) / 2

    def log_area(self, s: ArrayLike) -> Array:
        """int eta dc/c from 0 to c."""
        return self._value(self._log_area, s)

    def log_moment(self, s: ArrayLike) -> Array:
        """int eta G dc/c from 0 to c."""
        return self._value(self._log_moment, s)

    @cached_property
    def _log_fourth(self) -> Array:
        """Cubics of int eta G^2 dc/c."""
        return self._integral(power=2)

    def second_moments(self, s: ArrayLike) -> PunchMoments:
        """Integrals of c^2/2, the second moment of a punch of unit load, up to s (k,)."""
        square = np.square(self.half_width(s))
        of_profile = square * self.load(s) / 2 - self.log_moment(s) / self.parabola_stiffness
        return PunchMoments(of_profile, square * self.parabola(s) / 4, square * self.fourth(s) / 3)

    def fourth_moments(self, s: ArrayLike) -> PunchMoments:
        """Integrals of 3 c^4/8, the fourth moment of a punch of unit load, up to s (k,)."""
        square = np.square(self.half_width(s))
        of_profile = square**2 * self.load(s)
        of_profile -= 4 * self._value(self._log_fourth, s) / self.parabola_stiffness**2
        of_parabola = square**2 * self.parabola(s) / 8
        return PunchMoments(3 / 8 * of_profile, of_parabola, 3 / 16 * square**2 * self.fourth(s))

    def logarithm(self, s: ArrayLike) -> Array:
        """ln c; of the least punch that counts for c = 0."""
        return np.log(np.maximum(self.half_width(s), _LEAST * self._ends[-1]))

    def contact(
        self,
        normal_load: Array,
        curvature: Array,
        fourth: Array | float = 0.0,
        known_s: Array | None = None,
    ) -> Array:
        """Coordinates s (n,) of the flat punches at the edges of contact a under loads P (n,), from
        P = eta(a) + kn G(a) + n4 G_4(a), by bisection and Newton's rule.

        eta, G and G_4 are the loads that punches up to half-width c carry: of the profile, of x^2/2
        and of x^4/24. Where P = 0, s is 0.

        Parameters
        ----------
        normal_load
            P (n,)
        curvature, fourth
            kn and n4 (n,): factors of x^2/2 and x^4/24 that the bodies add to the gap
        known_s
            s (n,) where it is known to 1e-3; then bisection is left out
        """

        def carried(s: Array) -> Array:
            load = self.load(s) + curvature * self.parabola(s)
            return np.asarray(load + fourth * self.fourth(s))

        lower_s = np.zeros(len(normal_load))
        upper_s = np.full(len(normal_load), self.last)
        edge_s = known_s
        newton_steps = _STEPS_NEAR
        if edge_s is None:
            for _ in range(_FIRST_BISECTIONS):
                middle_s = (lower_s + upper_s) / 2
                carries_less = carried(middle_s) <= normal_load
                lower_s = np.where(carries_less, middle_s, lower_s)
                upper_s = np.where(carries_less, upper_s, middle_s)
            edge_s = (lower_s + upper_s) / 2
            newton_steps = _STEPS_AFTER
        for _ in range(newton_steps):
            missing_load = normal_load - carried(edge_s)
            curvature_at_edge = curvature + fourth * np.square(self.half_width(edge_s)) / 4
            load_rate = self._load_rate(edge_s) + curvature_at_edge * self._parabola_rate(edge_s)
            newton_step = missing_load / np.where(load_rate > 0, load_rate, np.inf)
            edge_s = np.clip(edge_s + newton_step, lower_s, upper_s)
        return np.where(normal_load > 0, edge_s, 0.0)

    def _load_rate(self, s: Array) -> Array:
        """d eta/ds, (n,)."""
        place_in_cells = s * self._cells_per_corner
        cell = np.minimum(place_in_cells.astype(int), len(self._load) - 1)
        share_of_cell = place_in_cells - cell
        _, c1, c2, c3 = self._load[cell].T
        return np.asarray(
            (c1 + share_of_cell * (2 * c2 + 3 * share_of_cell * c3)) * self._cells_per_corner
        )

    def _parabola_rate(self, s: Array) -> Array:
        """dG/ds, (n,)."""
        return 2 * self.parabola_stiffness * self.half_width(s) * self.half_width_rate(s)


# ------------------------------------------------------------------------------------- the memory
class Curvatures(NamedTuple):
    """What bodies add per load: N, N_Q, T, T_P [1 / (stress length^2)], and the next order, N_4,
    T_4, N_22, T_22 [1 / (stress length^4)].
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

    def of_gap(self, normal_load: Array, tangential_load: Array) -> Array:
        """kn = N P + N_Q Q [1 / length], without what p_2 adds."""
        return self.normal * normal_load + self.normal_under_shear * tangential_load

    def of_faces(self, normal_load: Array, tangential_load: Array) -> Array:
        """kt = T Q + T_P P [1 / length], without what q_2 adds."""
        return self.tangential * tangential_load + self.tangential_under_pressure * normal_load


class Piece(NamedTuple):
    """A piece of a memory curve above another one, its parent, whose number it has.

    From the top of its parent to its own, F rises by `slope` d eta + `parabola_slope` dG +
    `fourth_slope` dG_4. At its top are eta, G, G_4 and F.
    """

    parent: int
    top: float
    load: float
    parabola: float
    fourth: float
    force: float
    slope: float
    parabola_slope: float
    fourth_slope: float

    @property
    def loads(self) -> OfPunches:
        """eta, G and G_4 at the top."""
        return self.load, self.parabola, self.fourth

    @property
    def slopes(self) -> OfPunches:
        """dF per d eta, per dG and per dG_4."""
        return self.slope, self.parabola_slope, self.fourth_slope


_EMPTY_CURVE = Piece(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Pieces(list[Piece]):
    """Pieces of all memory curves of a path by their numbers; piece 0 is the empty curve."""

    def __init__(self) -> None:
        super().__init__([_EMPTY_CURVE])

    def above(self, parent: int, top: float, loads: OfPunches, slopes: OfPunches) -> Piece:
        """A new piece of memory curve on top of piece number `parent`, not yet stored.

        A memory curve is F(s), the locked-in tangential force of the flat punches up to s. It is a
        chain of pieces; on each F rises by constant `slopes` per unit of the punches' loads eta, G
        and G_4.

        Parameters
        ----------
        top
            s at which the new piece ends
        loads
            eta, G and G_4 there
        slopes
            dF/d eta, dF/dG and dF/dG_4
        """
        parent_piece = self[parent]
        load, parabola, fourth = loads
        slope, parabola_slope, fourth_slope = slopes
        force = parent_piece.force + slope * (load - parent_piece.load)
        force += parabola_slope * (parabola - parent_piece.parabola)
        force += fourth_slope * (fourth - parent_piece.fourth)
        return Piece(
            parent, top, load, parabola, fourth, force, slope, parabola_slope, fourth_slope
        )

    def append_numbered(self, piece: Piece) -> int:
        """Number of a piece that is added."""
        self.append(piece)
        return len(self) - 1

    def add(self, parent: int, top: float, loads: OfPunches, slopes: OfPunches) -> int:
        """Number of a new piece, as `above`."""
        return self.append_numbered(self.above(parent, top, loads, slopes))

    def forget_beyond(self, count: int) -> None:
        """Keep the first `count` pieces: those of a trial that was rejected go."""
        del self[count:]


class _Bound(NamedTuple):
    """B_s: F of slip in one direction, `direction` times which F may not be below."""

    direction: int
    constant: float
    slope: float
    parabola_slope: float
    fourth_slope: float

    @property
    def slopes(self) -> OfPunches:
        """dB per d eta, per dG and per dG_4."""
        return self.slope, self.parabola_slope, self.fourth_slope

    def excess(self, piece: Piece) -> float:
        """How far F at the top of a piece is beyond the bound; it slips where this is positive."""
        at_top = self.constant + self.slope * piece.load
        at_top += self.parabola_slope * piece.parabola + self.fourth_slope * piece.fourth
        return self.direction * (at_top - piece.force)


@dataclass(frozen=True, eq=False)
class Followed:
    """A path that was followed with the curvatures of the bodies.

    Attributes
    ----------
    table
        the flat punches
    friction
        f
    normal_load, tangential_load, normal_curvature, tangential_curvature
        (n,) P, Q, kn, kt at the rows of the path
    normal_fourth, tangential_fourth
        (n,) n4, t4 there
    edge, stick_edge
        (n,) s of the edges of contact and of stick; the same where nothing slips
    direction
        (n,) sense of slip in the step that ends at the row, 0 in full stick
    inner_zone, inner_zone_direction
        (n, 2) s of the ends of a slip zone further in, where a stroke goes on while the edge rests
        or slips the other way; (n,) its sense, 0 where there is none
    uppermost_piece
        (n,) uppermost piece of the memory curve
    pieces
        all pieces
    """

    table: PunchTable
    friction: float
    normal_load: Array
    tangential_load: Array
    normal_curvature: Array
    tangential_curvature: Array
    normal_fourth: Array
    tangential_fourth: Array
    edge: Array
    stick_edge: Array
    direction: Indices
    inner_zone: Array
    inner_zone_direction: Indices
    uppermost_piece: Indices
    pieces: PieceTable

    @property
    def innermost(self) -> Array:
        """s of the innermost punch that slips, (n,); the edge of contact where none does."""
        return np.where(self.inner_zone_direction != 0, self.inner_zone[:, 0], self.stick_edge)

    @property
    def sense(self) -> Indices:
        """Sense of slip at the edge, (n,); of the inner zone where the edge rests."""
        return np.where(self.direction != 0, self.direction, self.inner_zone_direction)

    @cached_property
    def pressure_second(self) -> Array:
        """p_2, (n,)."""
        return self.of_pressure(self.table.second_moments(self.edge))

    @cached_property
    def shear_second(self) -> Array:
        """q_2, (n,)."""
        moments = self.table.second_moments
        return self.of_shear(moments(self.pieces.top), moments(self.edge))

    @cached_property
    def pressure_fourth(self) -> Array:
        """p_4 = int x^4 p dx, (n,)."""
        return self.of_pressure(self.table.fourth_moments(self.edge))

    @cached_property
    def shear_fourth(self) -> Array:
        """q_4 = int x^4 q dx, (n,)."""
        moments = self.table.fourth_moments
        return self.of_shear(moments(self.pieces.top), moments(self.edge))

    def of_pressure(self, at_edge: PunchMoments) -> Array:
        """An integral over the punches of p, (n,), by what it is up to the edges.

        It is 0 where the bodies are apart.
        """
        moment = _pressure_moment(at_edge, self.normal_curvature, self.normal_fourth)
        return np.where(self.normal_load > 0, moment, 0.0)

    def of_shear(self, at_tops: PunchMoments, at_edge: PunchMoments) -> Array:
        """An integral of the shear traction over the contact at each instant, (n,), such as a
        moment.

        It is summed along the memory curve, the locked-in tangential force over the half-width of
        the punches. Each piece adds its slope times the rise of the integral over its punches. The
        curvature that the loads give to the faces adds its own share. 0 where the bodies are apart.

        Parameters
        ----------
        at_tops
            the integral over punches of unit load, up to the top of each piece
        at_edge
            that integral up to the edge of contact at each instant
        """
        pieces = self.pieces
        moment = pieces.sums(
            (pieces.slope, at_tops.profile),
            (pieces.parabola_slope, at_tops.parabola),
            (pieces.fourth_slope, at_tops.fourth),
        )[self.uppermost_piece]
        moment = moment + self.tangential_curvature * at_edge.parabola
        moment = moment + self.tangential_fourth * at_edge.fourth
        return np.where(self.normal_load > 0, moment, 0.0)

    @cached_property
    def step_work(self) -> Array:
        """Friction work of the straight step that ends at each instant, times pi/A, (n,).

        Work is done in the slip zone at the edge, in an inner slip zone, and by punches
        that the contact leaves during the step: they slip until then. A = 2/E*.
        """
        # Punches that the contact leaves in a step slip until then.
        edge_before = np.append(self.edge[:1], self.edge[:-1])
        parts = self._parts_of_zones(
            (self.direction, self.stick_edge, self.edge),
            (self.inner_zone_direction, self.inner_zone[:, 0], self.inner_zone[:, 1]),
            (self.direction, self.edge, edge_before),
        )
        work = np.bincount(parts.row, self._work_of_parts(parts), len(self.edge))
        return np.asarray(work, dtype=float)

    def _work_of_parts(self, parts: _Parts) -> Array:
        """Friction work of each part of a slip zone in one step, times pi/A, (m,): the integral of
        f [load beyond c] |dF| dc/c over the flat punches of the part, of half-width c.

        F is the tangential force that a punch locks in. A punch slips in that share of the step in
        which F follows the Coulomb bound, which moves linearly. It slips no longer than it is in
        contact. The load beyond it counts with its mean over that share.
        """
        nodes, weights = _GAUSS_OF_WORK
        length = (parts.high - parts.low)[:, None]
        s = parts.low[:, None] + length * (nodes + 1) / 2
        table = self.table
        punches = _PunchArrays(table.load(s), table.parabola(s), table.fourth(s))
        sense_of_part = parts.sense[:, None]
        load_before = self._load_beyond(punches, parts.row - 1)
        load_after = self._load_beyond(punches, parts.row)
        bound_before = self._slip_bound(punches, parts.row - 1, sense_of_part, load_before)
        bound_after = self._slip_bound(punches, parts.row, sense_of_part, load_after)
        # bound_rise: how far the bound moves in the step; slip_force: |dF| that the punch slips by.
        # Of what slides as a whole, the curvature of the faces may move a punch against the slide.
        bound_rise = sense_of_part * (bound_after - bound_before)
        slip_force = sense_of_part * (bound_after - self._frozen_forces(punches, parts.piece))
        slip_share = np.clip(slip_force / np.where(bound_rise != 0, bound_rise, np.inf), 0.0, 1.0)
        # Where the bodies touch within the step, slip goes on from there to its end.
        touches = parts.piece[:, None] == 0
        load_gain = np.where(touches & (load_after > load_before), load_after - load_before, np.inf)
        share_since_touch = np.clip(load_after / load_gain, 0.0, 1.0)
        slip_share = np.where(touches, share_since_touch, slip_share)
        slip_force = np.where(touches, bound_rise * share_since_touch, slip_force)
        leaves = (load_after < 0) & (load_before > 0)
        load_loss = np.where(leaves, load_before - load_after, np.inf)
        share_out_of_contact = np.where(leaves, -load_after / load_loss, 0.0)
        share_in_contact = np.maximum(slip_share - share_out_of_contact, 0.0)
        slip_force = np.where(leaves, bound_rise * share_in_contact, slip_force)
        middle_of_slip = 1 - slip_share + share_in_contact / 2
        mean_load = np.maximum(load_before + middle_of_slip * (load_after - load_before), 0.0)
        logarithmic_rate = table.half_width_rate(s) / table.half_width(s)
        work = (
            self.friction * (mean_load * slip_force * logarithmic_rate) @ weights * length[:, 0] / 2
        )
        return np.asarray(work)

    def _load_beyond(self, punches: _PunchArrays, row: Indices) -> Array:
        """P - eta - kn G - n4 G_4 at rows (m,): load carried beyond punches (m, k), (m, k)."""
        load_beyond = self.normal_load[row][:, None] - punches.load
        load_beyond = load_beyond - self.normal_curvature[row][:, None] * punches.parabola
        return np.asarray(load_beyond - self.normal_fourth[row][:, None] * punches.fourth)

    def _slip_bound(
        self, punches: _PunchArrays, row: Indices, sense: Indices, load_beyond: Array
    ) -> Array:
        """Coulomb bound of the locked-in tangential force F of each punch at each instant, (m, k):
        what F is while the punch slips.

            Q - kt G - t4 G_4 - s f [load beyond the punch],    s = `sense`: +1 forward, -1 reverse.

        Parameters
        ----------
        punches
            loads eta, G and G_4 (m, k)
        row
            (m,) numbers of the instants
        load_beyond
            (m, k) normal load that is carried outside of each punch
        """
        force = self.tangential_load[row][:, None]
        force = force - self.tangential_curvature[row][:, None] * punches.parabola
        force = force - self.tangential_fourth[row][:, None] * punches.fourth
        return np.asarray(force - sense * self.friction * load_beyond)

    def _frozen_forces(self, punches: _PunchArrays, piece: Indices) -> Array:
        """Tangential force F that punches (m, k) keep while they stick, (m, k).

        The memory curve is F over the half-width of the punches, in pieces of constant slopes. On a
        piece F is the force at its foot plus each slope times the rise of a load of the punches:
        eta, G and G_4. `piece` (m,) is the number of the piece for each row of `punches`.
        """
        pieces = self.pieces
        below = pieces.parent[piece]
        force = pieces.force[below][:, None]
        load_rise = punches.load - pieces.load[below][:, None]
        force = force + pieces.slope[piece][:, None] * load_rise
        parabola_rise = punches.parabola - pieces.parabola[below][:, None]
        force = force + pieces.parabola_slope[piece][:, None] * parabola_rise
        fourth_rise = punches.fourth - pieces.fourth[below][:, None]
        return np.asarray(force + pieces.fourth_slope[piece][:, None] * fourth_rise)

    def _parts_of_zones(self, *zones: tuple[Indices, Array, Array]) -> _Parts:
        """The slip zones of all steps, cut into parts within which the integrand of the work is
        smooth.

        Cuts are at corners of the profile, which are whole numbers of the punch coordinate s. They
        are also at the tops of the pieces of the memory curve before the step, the locked-in
        tangential force over s. A part names the piece in which it lies, 0 beyond the edge of
        contact before the step.

        Parameters
        ----------
        zones
            each as three arrays (n,) over the steps: direction of slip, 0 for no slip; s of the
            inner end; s of the outer end
        """
        parts: list[tuple[int, float, float, int, int]] = []
        tops, parents, curves = self._lists
        zones_in_steps = [
            (row, int(sense[row]), float(begin_s[row]), float(zone_end[row]))
            for sense, begin_s, zone_end in zones
            for row in (
                np.flatnonzero((sense[1:] != 0) & (zone_end[1:] > begin_s[1:])) + 1
            ).tolist()
        ]
        for row, direction, zone_begin, zone_end in zones_in_steps:
            piece = curves[row - 1]
            part_end = zone_end
            is_beyond_edge = True  # of the contact before the step
            # From the outer end inwards, piece by piece.
            while part_end > zone_begin:
                part_begin = max(
                    tops[piece] if is_beyond_edge else tops[parents[piece]], zone_begin
                )
                piece_of_part = 0 if is_beyond_edge else piece
                while math.ceil(part_end) - 1 > part_begin:
                    corner = math.ceil(part_end) - 1
                    parts.append((row, float(corner), part_end, piece_of_part, direction))
                    part_end = float(corner)
                if part_end > part_begin:
                    parts.append((row, part_begin, part_end, piece_of_part, direction))
                    part_end = part_begin
                if not is_beyond_edge:
                    piece = parents[piece]
                is_beyond_edge = False
        columns = np.array(parts).reshape(-1, 5).T
        return _Parts(
            row=columns[0].astype(np.int64),
            low=columns[1],
            high=columns[2],
            piece=columns[3].astype(np.int64),
            sense=columns[4].astype(np.int64),
        )

    @cached_property
    def _lists(self) -> tuple[list[float], list[int], list[int]]:
        """Tops and parents of the pieces, and the uppermost piece at each row: loops over them are
        faster than over arrays.
        """
        return self.pieces.top.tolist(), self.pieces.parent.tolist(), self.uppermost_piece.tolist()

    def frozen_force(self, row: int, s: Array) -> Array:
        """Locked-in tangential force F at flat punches of coordinate s (k,), at instant number
        `row`, (k,) [force per thickness].

        F is the memory of the contact: it does not change while a punch sticks. It is read from the
        chain of pieces of the memory curve. Beyond the edge of contact its value at the edge is
        returned.
        """
        numbers_of_pieces = self.pieces.chain(int(self.uppermost_piece[row]))
        tops = self.pieces.top[numbers_of_pieces]
        number_in_chain = np.clip(np.searchsorted(tops, s), 1, max(len(numbers_of_pieces) - 1, 1))
        if len(numbers_of_pieces) == 1:
            return np.zeros(len(s))
        s_in_contact = np.minimum(s, tops[-1])
        below = numbers_of_pieces[number_in_chain - 1]
        piece = numbers_of_pieces[number_in_chain]
        load_rise = self.table.load(s_in_contact) - self.pieces.load[below]
        parabola_rise = self.table.parabola(s_in_contact) - self.pieces.parabola[below]
        force_rise = self.pieces.slope[piece] * load_rise
        force_rise = force_rise + self.pieces.parabola_slope[piece] * parabola_rise
        fourth_rise = self.table.fourth(s_in_contact) - self.pieces.fourth[below]
        force_rise = force_rise + self.pieces.fourth_slope[piece] * fourth_rise
        return np.asarray(self.pieces.force[below] + force_rise)


class _PunchArrays(NamedTuple):
    """eta, G and G_4 of flat punches (m, k): loads of the punches up to each, of the profile, of a
    parabola and of x^4/24.
    """

    load: Array
    parabola: Array
    fourth: Array


class _Parts(NamedTuple):
    """Parts (m,) of slip zones: row of the path, s of both ends, the piece of the curve before in
    which it is, 0 beyond the edge of the contact before, the sense of the slip.
    """

    row: Indices
    low: Array
    high: Array
    piece: Indices
    sense: Indices


@dataclass(frozen=True, eq=False)
class PieceTable:
    """The pieces as arrays (k,), in the order of a `Piece`."""

    parent: Indices
    top: Array
    load: Array
    parabola: Array
    fourth: Array
    force: Array
    slope: Array
    parabola_slope: Array
    fourth_slope: Array

    def chain(self, piece: int) -> Indices:
        """The pieces of a curve from the empty one to the uppermost."""
        numbers = [piece]
        while numbers[-1]:
            numbers.append(int(self.parent[numbers[-1]]))
        return np.array(numbers[::-1])

    def of_curves(self, curves: Indices) -> tuple[PieceTable, Indices]:
        """The pieces that some memory curves consist of, with new numbers; others are left out.

        A memory curve is the locked-in tangential force over the half-width of the flat punches.
        `curves` (n,) gives each curve by the number of its uppermost piece; from there each piece
        names the one below it. Also returned are the new numbers of these uppermost pieces, (n,).
        """
        is_needed = np.zeros(len(self.parent), dtype=bool)
        pieces = np.unique(curves)
        while len(pieces):
            is_needed[pieces] = True
            pieces = np.unique(self.parent[pieces])
            pieces = pieces[~is_needed[pieces]]
        is_needed[0] = True
        numbers_needed = np.flatnonzero(is_needed)
        new_number = np.cumsum(is_needed) - 1
        columns = {item.name: getattr(self, item.name)[numbers_needed] for item in fields(self)}
        columns["parent"] = new_number[columns["parent"]]
        return PieceTable(**columns), new_number[curves]

    @cached_property
    def _levels(self) -> list[Indices]:
        """Numbers of the pieces, grouped by how many pieces lie below each in its memory curve:
        one, two, and so on.

        A memory curve is the locked-in tangential force over the half-width of the flat punches.
        Piece 0, the empty curve, counts as one below. Sums along curves are taken group by group.
        """
        depth = [0]
        for below in self.parent[1:].tolist():
            depth.append(depth[below] + 1)
        depths = np.array(depth)
        order_by_depth = np.argsort(depths, kind="stable")
        levels = np.split(order_by_depth, np.cumsum(np.bincount(depths))[:-1])
        return levels[1:]

    def sums(self, *terms: tuple[Array, Array]) -> Array:
        """Integrals along the memory curves, from the middle up to the top of each piece, (k, ...).

        A memory curve is the locked-in tangential force over the half-width of the flat punches. A
        piece adds its slope (k,) times the rise of a primitive from the piece below it to its own
        top. `terms` are pairs of slopes (k,) and primitives at the tops (k, ...); they add up.
        """
        parent = self.parent
        sums_at_tops = np.zeros_like(terms[0][1])
        for slopes, values in terms:
            if np.any(slopes):
                rise = values - values[parent]
                sums_at_tops += slopes.reshape((-1,) + (1,) * (values.ndim - 1)) * rise
        sums_at_tops[0] = 0.0
        for level in self._levels[1:]:
            sums_at_tops[level] += sums_at_tops[parent[level]]
        return sums_at_tops


def follow(
    table: PunchTable,
    friction: float,
    normal_load: Array,
    tangential_load: Array,
    curvatures: Curvatures,
    half_planes: Followed | None = None,
) -> Followed:
    """Memory of friction along a load path of straight steps, from rest, with the curvatures that
    finite bodies add to half-planes.

    The memory curve is the locked-in tangential force over the half-width of the flat punches that
    make up the contact. Stick leaves it, slip clips it at the Coulomb limit.

    Parameters
    ----------
    table
        loads of the flat punches by the half-width
    friction
        f
    normal_load, tangential_load
        (n,) P and Q at the ends of the steps
    curvatures
        what a unit of P and of Q adds to gap and faces
    half_planes
        the path already followed without curvatures, if there is one

    Examples
    --------

    >>> import numpy as np
    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=4 / np.pi, radius=1.0, datum_length=1.0)  # a^2 = P
    >>> table = PunchTable(contact, contact.modulus, largest_half_width=1.2)
    >>> rows = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.3], [1.0, -0.3], [1.0, 0.3]])
    >>> followed = follow(table, 0.5, *rows.T, Curvatures())
    >>> table.half_width(followed.stick_edge[-2:]).round(9).tolist()  # c = a sqrt(1 - Q/(f P))
    [0.632455532, 0.632455532]
    """
    rows = _rows(table, normal_load, tangential_load, curvatures)
    if curvatures.tangential_mixed:
        if half_planes is None:
            half_planes = follow(table, friction, normal_load, tangential_load, Curvatures())
        shear_second = _shear_second(table, rows, half_planes)
        rows[_TANGENTIAL_CURVATURE] += 2 * curvatures.tangential_mixed * shear_second
    return _follow(table, friction, rows)


def _shear_second(table: PunchTable, rows: Array, half_planes: Followed) -> Array:
    """Second moment of the shear traction, q_2 = int x^2 q dx, at each instant of the path, (n,),
    estimated from half-planes.

    It is their q_2 times the ratio of the second moments of pressure, with the curvatures of finite
    bodies over without. What this neglects of the work W is a hundredth of what is left out anyway,
    the curvatures of sixth order and beyond.

    Parameters
    ----------
    rows
        (10, n) loads, curvatures and edge of contact at the instants
    half_planes
        the path followed without curvatures
    """
    columns_by_name = dict(zip(Row._fields, rows, strict=True))
    bends = (columns_by_name["normal_curvature"], columns_by_name["normal_fourth"])
    pressure_second = _pressure_moment(table.second_moments(columns_by_name["edge"]), *bends)
    pressure_second_of_half_planes = half_planes.pressure_second
    ratio = np.divide(
        pressure_second,
        pressure_second_of_half_planes,
        out=np.zeros_like(pressure_second),
        where=pressure_second_of_half_planes > 0,
    )
    return half_planes.shear_second * ratio


def _pressure_moment(at_edge: PunchMoments, curvature: Array, fourth: Array) -> Array:
    """A moment of p, (n,), of what it is up to the edges of contact."""
    return np.asarray(at_edge.profile + curvature * at_edge.parabola + fourth * at_edge.fourth)


def _rows(
    table: PunchTable, normal_load: Array, tangential_load: Array, curvatures: Curvatures
) -> Array:
    """Loads, curvatures and edge of contact at each instant of a path with loads P and Q (n,), as
    columns (10, n).

    The columns are P, Q; kn and kt, the factors of x^2/2 that the bodies add to gap and faces; the
    factors of x^4/24; the coordinate s of the edge of contact in the `table`; and the loads eta, G
    and G_4 of the punches up to it, of profile, x^2/2 and x^4/24.

    kn follows from the second moment of pressure, p_2, and p_2 from the edge: they are iterated. kt
    is without what the second moment of shear adds. `curvatures` are what P and Q add to gap and
    faces.
    """
    curvature_without_p2 = curvatures.of_gap(normal_load, tangential_load)
    tangential_curvature = curvatures.of_faces(normal_load, tangential_load)
    gap_fourth_order = curvatures.normal_fourth * normal_load
    faces_fourth_order = curvatures.tangential_fourth * tangential_load
    normal_curvature = curvature_without_p2
    edge = table.contact(normal_load, normal_curvature, gap_fourth_order)
    if curvatures.normal_mixed:
        for _ in range(_ROUNDS_OF_MOMENT):
            moments_at_edge = table.second_moments(edge)
            second_moment = _pressure_moment(moments_at_edge, normal_curvature, gap_fourth_order)
            curvature_before = normal_curvature
            normal_curvature = curvature_without_p2 + 2 * curvatures.normal_mixed * second_moment
            edge = table.contact(normal_load, normal_curvature, gap_fourth_order, edge)
            load_change = np.max(np.abs(normal_curvature - curvature_before) * table.parabola(edge))
            if load_change <= _LEFT_OF_MOMENT * np.max(normal_load):
                break
    columns = [
        normal_load,
        tangential_load,
        normal_curvature,
        tangential_curvature,
        gap_fourth_order,
        faces_fourth_order,
        edge,
        table.load(edge),
        table.parabola(edge),
        table.fourth(edge),
    ]
    return np.stack(columns)


def _follow(table: PunchTable, friction: float, columns: Array) -> Followed:
    """The memory curve along rows (10, n)."""
    memory = MemoryCurve(table, friction, float(np.max(columns[0])), Pieces())
    state = UNLOADED
    steps = []
    for values in columns.T.tolist():
        step = memory.step(state, Row(*values))
        state = step.state
        steps.append(step)
    return followed_of(memory, columns, steps)


def followed_of(memory: MemoryCurve, columns: Array, steps: Sequence[Step]) -> Followed:
    """The followed load path as arrays over its instants, from the list of its steps.

    Parameters
    ----------
    memory
        the memory curves of all steps (locked-in tangential force over the half-width of the
        punches), as a list of pieces
    columns
        (10, n) P, Q, curvatures of gap and faces, their factors of x^4/24, edge of contact and the
        loads of the punches up to it
    steps
        n results of single steps: state, stick edge, slip zones
    """
    pieces = memory.pieces
    entries_of_pieces = np.fromiter(
        chain.from_iterable(pieces), float, len(pieces) * len(_EMPTY_CURVE)
    )
    parent, *columns_of_pieces = entries_of_pieces.reshape(len(pieces), -1).T
    piece_table = PieceTable(parent.astype(np.int64), *columns_of_pieces)
    columns_by_name = dict(zip(Row._fields, columns, strict=True))
    return Followed(
        table=memory.table,
        friction=memory.friction,
        normal_load=columns_by_name["normal_load"],
        tangential_load=columns_by_name["tangential_load"],
        normal_curvature=columns_by_name["normal_curvature"],
        tangential_curvature=columns_by_name["tangential_curvature"],
        normal_fourth=columns_by_name["normal_fourth"],
        tangential_fourth=columns_by_name["tangential_fourth"],
        edge=columns_by_name["edge"],
        stick_edge=np.array([step.stick_edge for step in steps]),
        direction=np.array([step.direction for step in steps], dtype=np.int64),
        inner_zone=np.array([step.inner_zone for step in steps]),
        inner_zone_direction=np.array(
            [step.inner_zone_direction for step in steps], dtype=np.int64
        ),
        uppermost_piece=np.array([step.state.uppermost_piece for step in steps], dtype=np.int64),
        pieces=piece_table,
    )


class Row(NamedTuple):
    """P, Q, kn, kt, n4, t4 at the end of a step, and s, eta, G and G_4 of the edge of contact
    there.
    """

    normal_load: float
    tangential_load: float
    normal_curvature: float
    tangential_curvature: float
    normal_fourth: float
    tangential_fourth: float
    edge: float
    edge_load: float
    edge_parabola: float
    edge_fourth: float

    @property
    def edge_loads(self) -> OfPunches:
        """eta, G and G_4 of the edge of contact."""
        return self.edge_load, self.edge_parabola, self.edge_fourth


class State(NamedTuple):
    """What a contact remembers: the uppermost piece of its curve, the sense of its last slip."""

    uppermost_piece: int = 0
    sense: int = 0


UNLOADED = State()
_TANGENTIAL_CURVATURE = Row._fields.index("tangential_curvature")


class Step(NamedTuple):
    """What is found at the end of a step: the state, and the slip zones as in `Followed`."""

    state: State
    stick_edge: float
    direction: int = 0
    inner_zone: tuple[float, float] = (0.0, 0.0)
    inner_zone_direction: int = 0


@dataclass(frozen=True, eq=False)
class MemoryCurve:
    """The memory of a contact, straight step by straight step; a step leaves no trace in a state.

    Attributes
    ----------
    table
        the flat punches
    friction
        f
    largest_load
        largest P of the path, by which round-off is judged
    pieces
        of all curves, those of the states among them
    """

    table: PunchTable
    friction: float
    largest_load: float
    pieces: Pieces

    def is_unloaded(self, normal_load: float) -> bool:
        """Whether P is 0 but for round-off: the bodies are apart, and nothing is remembered."""
        return normal_load <= _ROUNDING * self.largest_load

    def step(self, state: State, row: Row) -> Step:
        """State of the contact after a straight step of the loads, with the stick edge and the slip
        zones at its end.

        The memory curve F, locked-in tangential force over punches, is cut at the edge of contact
        or grows to it in stick. Where F is then beyond the Coulomb bound it follows the bound, from
        the edge inwards. Where the edge rests, the slip of the stroke before may go on further in,
        in an inner zone.

        Parameters
        ----------
        state
            number of the uppermost piece of the curve before the step, and the last direction of
            slip
        row
            loads, curvatures and edge of contact at the end of the step
        """
        if self.is_unloaded(row.normal_load):
            return Step(UNLOADED, stick_edge=row.edge)
        pieces = self.pieces
        round_off = _ROUNDING * self.friction * self.largest_load
        outermost_piece, number_of_top = self._up_to_edge(state.uppermost_piece, row)
        stick_edge = row.edge
        direction = _slipping(
            outermost_piece, pieces[outermost_piece.parent], self.friction, row, round_off
        )
        bound = None
        if direction:
            bound = _bound(direction, self.friction, row)
            number_of_top = _stick_below_slip(
                self.table, pieces, outermost_piece, number_of_top, bound, round_off
            )
            stick_edge = pieces[number_of_top].top
        elif number_of_top is None:
            number_of_top = pieces.append_numbered(outermost_piece)
        inner_zone = (0.0, 0.0)
        inner_zone_direction = 0
        if state.sense and direction != state.sense:
            # Further in the stroke before may go on.
            bound_of_last_slip = _bound(state.sense, self.friction, row)
            number_of_top, *ends_of_inner_zone = _with_inner_zone(
                self.table, pieces, number_of_top, bound_of_last_slip, round_off
            )
            inner_zone = (ends_of_inner_zone[0], ends_of_inner_zone[1])
            if inner_zone[1] > inner_zone[0]:
                inner_zone_direction = state.sense
        if bound is not None:
            number_of_top = pieces.add(number_of_top, row.edge, row.edge_loads, bound.slopes)
        return Step(
            State(number_of_top, inner_zone_direction or direction),
            stick_edge,
            direction,
            inner_zone,
            inner_zone_direction,
        )

    def _up_to_edge(self, curve: int, row: Row) -> tuple[Piece, int | None]:
        """The memory curve fitted to the new edge of contact, before any slip: its outermost piece,
        and that piece's number (None if it is new and not stored yet).

        The memory curve is the locked-in tangential force F over the half-width of the flat
        punches. A contact that shrinks cuts the curve at its edge. One that grows in stick adds a
        straight chord up to Q - kt G - t4 G_4 at the new edge, where all of Q is carried within.

        Parameters
        ----------
        curve
            number of the uppermost piece before the step
        row
            loads, curvatures and edge of contact at its end
        """
        pieces = self.pieces
        piece_number = curve
        piece = pieces[piece_number]
        loads = row.edge_loads
        if row.edge > piece.top:
            force_without_fourth = (
                row.tangential_load - row.tangential_curvature * row.edge_parabola
            )
            force_rise = (
                force_without_fourth - row.tangential_fourth * row.edge_fourth - piece.force
            )
            load_rise = row.edge_load - piece.load
            if load_rise > 0:
                return pieces.above(
                    curve, row.edge, loads, (force_rise / load_rise, 0.0, 0.0)
                ), None
            # The face is still flat: only the curvature of the bodies has punches here.
            parabola_slope = force_rise / (row.edge_parabola - piece.parabola)
            return pieces.above(curve, row.edge, loads, (0.0, parabola_slope, 0.0)), None
        while piece_number and pieces[piece.parent].top >= row.edge:
            piece_number = piece.parent
            piece = pieces[piece_number]
        if piece.top <= row.edge:
            return piece, piece_number
        return pieces.above(piece.parent, row.edge, loads, piece.slopes), None

    def slide(self, row: Row, direction: int) -> Step:
        """The state in which the contact slides as a whole, F at the bound of that direction all
        along, whatever was before.
        """
        bound = _bound(direction, self.friction, row)
        curve = self.pieces.add(0, row.edge, row.edge_loads, bound.slopes)
        return Step(State(curve, direction), stick_edge=0.0, direction=direction)


def _bound(direction: int, friction: float, row: Row) -> _Bound:
    """B_s at the end of a step."""
    limit = direction * friction
    return _Bound(
        direction,
        constant=row.tangential_load - limit * row.normal_load,
        slope=limit,
        parabola_slope=limit * row.normal_curvature - row.tangential_curvature,
        fourth_slope=limit * row.normal_fourth - row.tangential_fourth,
    )


def _slipping(
    outermost_piece: Piece, piece_below: Piece, friction: float, row: Row, round_off: float
) -> int:
    """Direction of slip at the edge of contact, +1 or -1; 0 where the edge sticks.

    The edge slips if the tangential force beyond one end of the outermost piece of the memory curve
    F exceeds f times the normal load beyond it: |Q - kt G - t4 G_4 - F| > f [P - eta - kn G - n4
    G_4].

    Parameters
    ----------
    outermost_piece, piece_below
        last piece of the curve, and the one at whose top it starts
    friction
        f
    row
        P, Q and curvatures at the end of the step
    round_off
        excess force that counts as none
    """
    for piece_end in (outermost_piece, piece_below):
        force_excess = row.tangential_load - row.tangential_curvature * piece_end.parabola
        force_excess -= row.tangential_fourth * piece_end.fourth + piece_end.force
        load_beyond = row.normal_load - piece_end.load - row.normal_curvature * piece_end.parabola
        load_beyond -= row.normal_fourth * piece_end.fourth
        if abs(force_excess) - friction * load_beyond > round_off:
            return 1 if force_excess > 0 else -1
    return 0


def _stick_below_slip(
    table: PunchTable,
    pieces: Pieces,
    piece: Piece,
    piece_number: int | None,
    bound: _Bound,
    round_off: float,
) -> int:
    """Cut the memory curve where slip from the edge of contact inwards ends: number of the
    uppermost piece that still sticks.

    Slip ends where the curve, the locked-in tangential force F over the half-width of the punches,
    meets the `bound`. A piece that is crossed there is cut in two.

    Parameters
    ----------
    table
        loads of the flat punches by their coordinate s
    pieces
        all pieces of memory curves
    piece, piece_number
        the outermost one, and its number, None where it is new
    bound
        the Coulomb limit that F follows during slip in one direction
    round_off
        excess of F that counts as round-off
    """
    empty_curve = pieces[0]
    piece_below = pieces[piece.parent]
    while piece is not empty_curve and bound.excess(piece_below) > round_off:
        piece_number = piece.parent
        piece = piece_below
        piece_below = pieces[piece.parent]
    excess_below = bound.excess(piece_below)
    if excess_below >= 0:
        return piece.parent
    excess_at_top = bound.excess(piece)
    if excess_at_top <= 0:
        return pieces.append_numbered(piece) if piece_number is None else piece_number
    crossing_s, loads_at_crossing = _crossing(
        table, (piece_below, piece), (excess_below, excess_at_top), bound, round_off
    )
    return pieces.add(piece.parent, crossing_s, loads_at_crossing.loads, piece.slopes)


def _with_inner_zone(
    table: PunchTable, pieces: Pieces, top: int, bound: _Bound, round_off: float
) -> tuple[int, float, float]:
    """Put a slip zone inside the contact into the memory curve: number of its uppermost piece after
    that, and the punch coordinates s of the inner and outer end of the zone (equal if none).

    The memory curve is the locked-in tangential force over the half-width of the flat punches. A
    slip zone inside the contact forms where the slip of a stroke goes on further in, while the edge
    of contact sticks or slips the other way.

    Parameters
    ----------
    table
        loads of the flat punches by their coordinate s
    pieces, top
        all pieces of memory curves, and the number of the uppermost one of this curve
    bound
        the Coulomb limit that F follows during slip in the direction of that stroke
    round_off
        excess of F that counts as round-off
    """
    piece_number = top
    piece = pieces[piece_number]
    pieces_above = []
    while piece_number and bound.excess(pieces[piece.parent]) <= round_off:
        pieces_above.append(piece)
        piece_number = piece.parent
        piece = pieces[piece_number]
    excess_at_top = bound.excess(piece)
    if not piece_number or excess_at_top > 0:
        edge = pieces[top].top
        return top, edge, edge
    piece_ends = (pieces[piece.parent], piece)
    excesses_at_ends = (bound.excess(piece_ends[0]), excess_at_top)
    outer_end, loads_at_outer_end = _crossing(table, piece_ends, excesses_at_ends, bound, round_off)
    number_below = _stick_below_slip(
        table, pieces, pieces[piece.parent], piece.parent, bound, round_off
    )
    curve = pieces.add(number_below, outer_end, loads_at_outer_end.loads, bound.slopes)
    for piece_above in (piece, *reversed(pieces_above)):
        curve = pieces.add(curve, piece_above.top, piece_above.loads, piece_above.slopes)
    return curve, pieces[number_below].top, outer_end


def _crossing(
    table: PunchTable,
    ends: tuple[Piece, Piece],
    excesses: tuple[float, float],
    bound: _Bound,
    round_off: float,
) -> tuple[float, PunchLoads]:
    """Coordinate s of the flat punch at which the memory curve crosses the Coulomb bound of slip,
    and the loads of the punches up to there.

    The memory curve is the locked-in tangential force F over the half-width of the flat punches. On
    one piece of it F grows linearly with the loads of the punches of the profile, of x^2/2 and of
    x^4/24; so does the bound. The zero of their difference is found by Newton's rule between
    brackets.

    Parameters
    ----------
    ends
        the piece below, and the piece itself
    excesses
        of F over the bound at the tops of the two pieces, of opposite signs
    bound
        direction of slip, and slopes of the bound per unit of each load
    round_off
        excess that counts as 0
    """
    piece_below, piece = ends
    low_s = piece_below.top
    high_s = piece.top
    excess_below, excess_above = excesses
    sign_of_rise = 1.0 if excess_above > excess_below else -1.0
    slope = bound.direction * (bound.slope - piece.slope)
    parabola_slope = bound.direction * (bound.parabola_slope - piece.parabola_slope)
    fourth_slope = bound.direction * (bound.fourth_slope - piece.fourth_slope)
    # Without x^4 the excess of a parabolic profile is a straight line over G.
    share_of_piece = excess_below / (excess_below - excess_above)
    s = table.place_of(
        piece_below.parabola + share_of_piece * (piece.parabola - piece_below.parabola)
    )
    if not low_s < s < high_s:
        s = low_s + share_of_piece * (high_s - low_s)
    loads_at_s = table.loads_at(s)
    # Newton's rule, in the middle between two punches where it would leave them.
    for _ in range(_STEPS_OF_NEWTON):
        excess = excess_below + slope * (loads_at_s.load - piece_below.load)
        excess += parabola_slope * (loads_at_s.parabola - piece_below.parabola)
        excess += fourth_slope * (loads_at_s.fourth - piece_below.fourth)
        if abs(excess) <= round_off:
            break
        if excess * sign_of_rise > 0:
            high_s = s
        else:
            low_s = s
        excess_rate = slope * loads_at_s.load_rate + parabola_slope * loads_at_s.parabola_rate
        excess_rate += fourth_slope * loads_at_s.fourth_rate
        newton_s = s - excess / excess_rate if excess_rate * sign_of_rise > 0 else math.nan
        s = newton_s if low_s < newton_s < high_s else (low_s + high_s) / 2
        loads_at_s = table.loads_at(s)
    return s, loads_at_s
