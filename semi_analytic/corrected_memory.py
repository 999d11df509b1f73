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
        """Tabulate eta(c), the load that flat punches of half-width up to c carry of a contact, for
        c from 0 to `largest_half_width` [length], by cubics on equal cells between the corners of
        its profile; and two integrals of it. `modulus` is E*. Loads of x^2/2 and of x^4/24 are
        in closed form.
        """
        corners = [contact.least, *contact.breaks]
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
        is_flat = half_width < contact.least * (1 - 1e-14)
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
        """Coefficients (cells, 4), constant first, of cubics of the share of a cell that is passed,
        with the values `begin_value`, `end_value` and the rates `begin_rate`, `end_rate` per sigma
        at the begin and the end of each cell; sigma runs from 0 to 1 between two corners of the
        profile.
        """
        step = 1 / self._cells_per_corner
        rise = end_value - begin_value
        begin_slope = begin_rate * step
        end_slope = end_rate * step
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
        step = 1 / self._cells_per_corner

        def integrand(s: Array) -> Array:
            half_width = self.half_width(s)
            rate = self.half_width_rate(s)
            load_per_width = self.load(s) * rate / np.where(half_width > 0, half_width, 1.0)
            return load_per_width * self.parabola(s) ** power if power else load_per_width

        s_of_nodes = np.asarray((np.arange(n_cells)[:, None] + share_of_cell) * step, dtype=float)
        integrals_of_cells = integrand(s_of_nodes) @ weights * (step / 2)
        sums_of_cells = np.concatenate([[0.0], np.cumsum(integrals_of_cells)])
        begins = np.asarray(np.arange(n_cells) * step, dtype=float)
        # Just within its cell, since beyond a corner of the profile another interval begins.
        ends = begins + step * (1 - 1e-12)
        return self._cubics(
            sums_of_cells[:-1], sums_of_cells[1:], integrand(begins), integrand(ends)
        )

    def _value(self, cubics: Array, s: ArrayLike) -> Array:
        place = np.asarray(s, dtype=float) * self._cells_per_corner
        cell = np.minimum(place.astype(int), len(cubics) - 1)
        share = place - cell
        c0, c1, c2, c3 = np.moveaxis(cubics[cell], -1, 0)
        return np.asarray(c0 + share * (c1 + share * (c2 + share * c3)))

    def half_width(self, s: ArrayLike) -> Array:
        """c [length]."""
        place = np.asarray(s, dtype=float)
        number = np.minimum(place.astype(int), int(self.last) - 1)
        length = np.diff(self._ends)[number]
        return np.asarray(self._ends[number] + length * (place - number) ** 2)

    def half_width_rate(self, s: ArrayLike) -> Array:
        """dc/ds [length]."""
        place = np.asarray(s, dtype=float)
        number = np.minimum(place.astype(int), int(self.last) - 1)
        length = np.diff(self._ends)[number]
        return np.asarray(2 * length * (place - number))

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
        half = math.sqrt(max(parabola, 0.0) / self.parabola_stiffness)
        number = max(bisect_left(self._begins, half) - 1, 0)
        return number + math.sqrt(max(half - self._begins[number], 0.0) / self._lengths[number])

    def loads_at(self, s: float) -> PunchLoads:
        """Loads that the flat punches up to the one at s carry, and their rates per s: eta of the
        profile, G of a parabola of unit curvature, G_4 of x^4/24; no eta is negative by round-off.

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
        return PunchLoads(
            load=max(c0 + share_of_cell * (c1 + share_of_cell * (c2 + share_of_cell * c3)), 0.0),
            parabola=parabola,
            fourth=parabola * squared_width / 8,
            load_rate=(c1 + share_of_cell * (2 * c2 + 3 * share_of_cell * c3))
            * self._cells_per_corner,
            parabola_rate=2 * self.parabola_stiffness * half_width * half_width_rate,
            fourth_rate=parabola * half_width * half_width_rate / 2,
        )

    def sums_at(self, s: float, datum: float) -> PunchSums:
        """Integrals over the flat punches up to the one at the place s, of half-width c: ln(2 L/c)
        and c^2/2 over d eta and over dG, eta and G the loads of the profile's and of a parabola's
        punches, L = `datum` [length]; for one s, faster than by arrays.

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
        """Coordinate s of the flat punch at the edge of contact a under one load, by bisection of P
        = eta(a) + kn G(a), `curvature` kn.

        eta(c) is the load that the profile's punches carry up to half-width c, G(c) that of a
        parabola's punches per unit of curvature.
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
        """Coordinates s (n,) of the flat punches at the edges of contact a: P = eta(a) + kn G(a) +
        n4 G_4(a), with loads P = `normal_load`, `curvature` kn and `fourth` n4 (n,).

        eta, G and G_4 are the loads carried up to half-width c by the punches of the profile, of a
        parabola and of x^4/24. `known_s` is s (n,) where it is known to 1e-3; then bisection is
        left out.
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
            rate = self._load_rate(edge_s) + curvature_at_edge * self._parabola_rate(edge_s)
            step = missing_load / np.where(rate > 0, rate, np.inf)
            edge_s = np.clip(edge_s + step, lower_s, upper_s)
        return np.where(normal_load > 0, edge_s, 0.0)

    def _load_rate(self, s: Array) -> Array:
        """d eta/ds, (n,)."""
        place = s * self._cells_per_corner
        cell = np.minimum(place.astype(int), len(self._load) - 1)
        share = place - cell
        _, c1, c2, c3 = self._load[cell].T
        return np.asarray((c1 + share * (2 * c2 + 3 * share * c3)) * self._cells_per_corner)

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
        """A piece of a memory curve F(s) above piece number `parent`, up to s = `top`, where eta, G
        and G_4 are `loads`; F rises by `slopes` per unit of each. It is not added to the pieces.
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
    edge, front
        (n,) s of the edges of contact and of stick; the same where nothing slips
    direction
        (n,) sense of slip in the step that ends at the row, 0 in full stick
    ring, ring_direction
        (n, 2) s of the ends of a slip zone further in, where a stroke goes on while the edge rests
        or slips the other way; (n,) its sense, 0 where there is none
    curve
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
    front: Array
    direction: Indices
    ring: Array
    ring_direction: Indices
    curve: Indices
    pieces: PieceTable

    @property
    def innermost(self) -> Array:
        """s of the innermost punch that slips, (n,); the edge of contact where none does."""
        return np.where(self.ring_direction != 0, self.ring[:, 0], self.front)

    @property
    def sense(self) -> Indices:
        """Sense of slip at the edge, (n,); of the ring where the edge rests."""
        return np.where(self.direction != 0, self.direction, self.ring_direction)

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
        """The same of q, of what it is up to the tops of the pieces and to the edges."""
        pieces = self.pieces
        moment = pieces.sums(
            (pieces.slope, at_tops.profile),
            (pieces.parabola_slope, at_tops.parabola),
            (pieces.fourth_slope, at_tops.fourth),
        )[self.curve]
        moment = moment + self.tangential_curvature * at_edge.parabola
        moment = moment + self.tangential_fourth * at_edge.fourth
        return np.where(self.normal_load > 0, moment, 0.0)

    @cached_property
    def step_work(self) -> Array:
        """pi/A times the friction work of the step that ends at each row, (n,)."""
        # Punches that the contact leaves in a step slip until then.
        edge_before = np.append(self.edge[:1], self.edge[:-1])
        parts = self._parts_of_zones(
            (self.direction, self.front, self.edge),
            (self.ring_direction, self.ring[:, 0], self.ring[:, 1]),
            (self.direction, self.edge, edge_before),
        )
        work = np.bincount(parts.row, self._work_of_parts(parts), len(self.edge))
        return np.asarray(work, dtype=float)

    def _work_of_parts(self, parts: _Parts) -> Array:
        """pi/A times the friction work of each part of a slip zone, (m,): the integral of
        f [load beyond c] |dF| dc/c over the flat punches of the part, of half-width c.

        A punch slips in the share of the step in which its F follows the bound B_s, which goes
        straight through the step, and no longer than it is in contact: the load beyond it counts
        with its mean over that share.
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
        # Of what slides as a whole, the curvature of the faces may move a punch against the slide.
        growth = sense_of_part * (bound_after - bound_before)
        change = sense_of_part * (bound_after - self._frozen_forces(punches, parts.piece))
        slip_share = np.clip(change / np.where(growth != 0, growth, np.inf), 0.0, 1.0)
        # Where the bodies touch within the step, slip goes on from there to its end.
        touches = parts.piece[:, None] == 0
        rise = np.where(touches & (load_after > load_before), load_after - load_before, np.inf)
        share_since_touch = np.clip(load_after / rise, 0.0, 1.0)
        slip_share = np.where(touches, share_since_touch, slip_share)
        change = np.where(touches, growth * share_since_touch, change)
        leaves = (load_after < 0) & (load_before > 0)
        fall = np.where(leaves, load_before - load_after, np.inf)
        share_out_of_contact = np.where(leaves, -load_after / fall, 0.0)
        share_in_contact = np.maximum(slip_share - share_out_of_contact, 0.0)
        change = np.where(leaves, growth * share_in_contact, change)
        middle_of_slip = 1 - slip_share + share_in_contact / 2
        mean_load = np.maximum(load_before + middle_of_slip * (load_after - load_before), 0.0)
        logarithmic_rate = table.half_width_rate(s) / table.half_width(s)
        work = self.friction * (mean_load * change * logarithmic_rate) @ weights * length[:, 0] / 2
        return np.asarray(work)

    def _load_beyond(self, punches: _PunchArrays, row: Indices) -> Array:
        """P - eta - kn G - n4 G_4 at rows (m,): load carried beyond punches (m, k), (m, k)."""
        load_beyond = self.normal_load[row][:, None] - punches.load
        load_beyond = load_beyond - self.normal_curvature[row][:, None] * punches.parabola
        return np.asarray(load_beyond - self.normal_fourth[row][:, None] * punches.fourth)

    def _slip_bound(
        self, punches: _PunchArrays, row: Indices, sense: Indices, load_beyond: Array
    ) -> Array:
        """B_s at rows (m,) of punches (m, k), (m, k): what F is while a punch slips in `sense` s,
        Q - kt G - t4 G_4 - s f [load beyond the punch].
        """
        force = self.tangential_load[row][:, None]
        force = force - self.tangential_curvature[row][:, None] * punches.parabola
        force = force - self.tangential_fourth[row][:, None] * punches.fourth
        return np.asarray(force - sense * self.friction * load_beyond)

    def _frozen_forces(self, punches: _PunchArrays, piece: Indices) -> Array:
        """F of punches (m, k) that stick, (m, k), each row on a piece (m,) of the memory curve."""
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
        """Slip zones of the steps that end at the rows, each given by the sense of slip, 0 for
        none, and s of both its ends, (n,) each; cut at the corners of the profile and at the tops
        of the memory curve before the step.

        s is the coordinate of the flat punches; at the corners it is a whole number.
        """
        parts: list[tuple[int, float, float, int, int]] = []
        tops, parents, curves = self._lists
        zones_in_steps = [
            (row, int(sense[row]), float(begin[row]), float(end[row]))
            for sense, begin, end in zones
            for row in (np.flatnonzero((sense[1:] != 0) & (end[1:] > begin[1:])) + 1).tolist()
        ]
        for row, direction, zone_begin, end in zones_in_steps:
            piece = curves[row - 1]
            part_end = end
            is_beyond_edge = True  # the edge of the contact before
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
        return self.pieces.top.tolist(), self.pieces.parent.tolist(), self.curve.tolist()

    def frozen_force(self, row: int, s: Array) -> Array:
        """F of the memory curve at a row of the path, at the flat punches of coordinates s (k,):
        the tangential force that does not change while a punch sticks. Beyond the edge of contact
        that at the edge.
        """
        numbers_of_pieces = self.pieces.chain(int(self.curve[row]))
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
        """The pieces that some memory curves, given by their uppermost pieces (n,), consist of,
        numbered again; and the new numbers of those uppermost pieces (n,).
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
        """The pieces with one piece below them, with two, and so on; the empty curve counts."""
        depth = [0]
        for below in self.parent[1:].tolist():
            depth.append(depth[below] + 1)
        depths = np.array(depth)
        order = np.argsort(depths, kind="stable")
        levels = np.split(order, np.cumsum(np.bincount(depths))[:-1])
        return levels[1:]

    def sums(self, *terms: tuple[Array, Array]) -> Array:
        """Integrals along each memory curve up to the top of each piece, (k, ...): the sum over
        pieces of slope (k,) times the rise of `values` (k, ...), primitives at the tops; several
        `terms` add.
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
    """The memory curve along straight steps between the rows of a path from rest, P = Q = 0, with
    the curvatures that the bodies add.

    Parameters
    ----------
    table
        loads of the flat punches by the half-width
    friction
        f
    normal_load, tangential_load
        (n,) P and Q at the rows
    curvatures
        what a unit of P and of Q adds to gap and faces
    half_planes
        the curve without curvatures along the path, where it was followed already

    Examples
    --------

    >>> import numpy as np
    >>> from semi_analytic.hertz import HertzContact
    >>> contact = HertzContact(modulus=4 / np.pi, radius=1.0, datum_length=1.0)  # a^2 = P
    >>> table = PunchTable(contact, contact.modulus, largest_half_width=1.2)
    >>> rows = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.3], [1.0, -0.3], [1.0, 0.3]])
    >>> followed = follow(table, 0.5, *rows.T, Curvatures())
    >>> table.half_width(followed.front[-2:]).round(9).tolist()  # c = a sqrt(1 - Q/(f P))
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
    """Second moment of the shear traction, q_2 = int x^2 q dx, at rows (10, n) of the path: (n,).

    It is that of half-planes times the ratio of the second moments of pressure, p_2 over theirs.
    What this neglects of W is a hundredth of what the order after the next may leave.
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
    """Loads, curvatures and edge of contact at each row of a path with loads P and Q (n,), as
    columns (10, n).

    The columns are P, Q; kn and kt, the factors of x^2/2 that the bodies add to gap and faces; the
    factors of x^4/24; the place s of the edge of contact in the `table`; and the loads eta, G and
    G_4 of the punches up to it, of profile, x^2/2 and x^4/24.

    `curvatures` are what P and Q add to gap and faces. kn follows from the second moment of
    pressure, p_2, and p_2 from the edge: they are iterated. kt is without what the second moment of
    shear, q_2, adds.
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
    """The path of some steps, with the memory curve at each, whose rows are `columns` (10, n): P,
    Q, the curvatures of gap and faces, their next order, the edge of contact and the loads up to
    it.
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
        front=np.array([step.front for step in steps]),
        direction=np.array([step.direction for step in steps], dtype=np.int64),
        ring=np.array([step.ring for step in steps]),
        ring_direction=np.array([step.ring_direction for step in steps], dtype=np.int64),
        curve=np.array([step.state.curve for step in steps], dtype=np.int64),
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

    curve: int = 0
    sense: int = 0


UNLOADED = State()
_TANGENTIAL_CURVATURE = Row._fields.index("tangential_curvature")


class Step(NamedTuple):
    """What is found at the end of a step: the state, and the slip zones as in `Followed`."""

    state: State
    front: float
    direction: int = 0
    ring: tuple[float, float] = (0.0, 0.0)
    ring_direction: int = 0


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
        """The state of the contact after a straight step of the loads from `state` to `row`, with
        the edge of stick and the zones of slip.

        The memory curve F is cut at the edge of contact or grows to it in stick. Where F is then
        beyond the bound of slip it follows the bound, from the edge inwards; where the edge rests,
        the slip of the stroke before may go on further in, in a ring.
        """
        if self.is_unloaded(row.normal_load):
            return Step(UNLOADED, front=row.edge)
        pieces = self.pieces
        round_off = _ROUNDING * self.friction * self.largest_load
        outermost_piece, number_of_top = self._up_to_edge(state.curve, row)
        stick_edge = row.edge
        direction = _slipping(
            outermost_piece, pieces[outermost_piece.parent], self.friction, row, round_off
        )
        bound = None
        if direction:
            bound = _bound(direction, self.friction, row)
            number_of_top = _front(
                self.table, pieces, outermost_piece, number_of_top, bound, round_off
            )
            stick_edge = pieces[number_of_top].top
        elif number_of_top is None:
            number_of_top = pieces.append_numbered(outermost_piece)
        ring = (0.0, 0.0)
        ring_direction = 0
        if state.sense and direction != state.sense:
            # Further in the stroke before may go on.
            bound_of_last_slip = _bound(state.sense, self.friction, row)
            number_of_top, *ring_ends = _ring(
                self.table, pieces, number_of_top, bound_of_last_slip, round_off
            )
            ring = (ring_ends[0], ring_ends[1])
            if ring[1] > ring[0]:
                ring_direction = state.sense
        if bound is not None:
            number_of_top = pieces.add(number_of_top, row.edge, row.edge_loads, bound.slopes)
        return Step(
            State(number_of_top, ring_direction or direction),
            stick_edge,
            direction,
            ring,
            ring_direction,
        )

    def _up_to_edge(self, curve: int, row: Row) -> tuple[Piece, int | None]:
        """The outermost piece of a curve that is cut at the edge of contact, or grows to it in
        stick, a chord; its number, None of one that is new.
        """
        pieces = self.pieces
        number = curve
        piece = pieces[number]
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
        while number and pieces[piece.parent].top >= row.edge:
            number = piece.parent
            piece = pieces[number]
        if piece.top <= row.edge:
            return piece, number
        return pieces.above(piece.parent, row.edge, loads, piece.slopes), None

    def slide(self, row: Row, direction: int) -> Step:
        """The state in which the contact slides as a whole, F at the bound of that direction all
        along, whatever was before.
        """
        bound = _bound(direction, self.friction, row)
        curve = self.pieces.add(0, row.edge, row.edge_loads, bound.slopes)
        return Step(State(curve, direction), front=0.0, direction=direction)


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
    """Direction of slip at the edge of contact, +1 or -1, 0 in stick: |Q - kt G - t4 G_4 - F| > f
    [load beyond] at one end of the outermost piece of the memory curve F, whose lower end is the
    top of the piece below it.

    `row` has P, Q and the curvatures; `round_off` is the excess that counts as none.
    """
    for piece_end in (outermost_piece, piece_below):
        force_excess = row.tangential_load - row.tangential_curvature * piece_end.parabola
        force_excess -= row.tangential_fourth * piece_end.fourth + piece_end.force
        load_beyond = row.normal_load - piece_end.load - row.normal_curvature * piece_end.parabola
        load_beyond -= row.normal_fourth * piece_end.fourth
        if abs(force_excess) - friction * load_beyond > round_off:
            return 1 if force_excess > 0 else -1
    return 0


def _front(
    table: PunchTable,
    pieces: Pieces,
    piece: Piece,
    number: int | None,
    bound: _Bound,
    round_off: float,
) -> int:
    """Number of the uppermost piece of the memory curve that is left below the line of slip, which
    goes from the edge of contact inwards to where F meets the `bound`.

    Parameters
    ----------
    table
        loads of the punches by the place s of the edge
    pieces
        pieces of the curve
    piece, number
        the outermost one, and its number, None where it is new
    bound
        the Coulomb limit F of slip in one direction
    round_off
        excess of F that counts as round-off
    """
    empty_curve = pieces[0]
    piece_below = pieces[piece.parent]
    while piece is not empty_curve and bound.excess(piece_below) > round_off:
        number = piece.parent
        piece = piece_below
        piece_below = pieces[piece.parent]
    excess_below = bound.excess(piece_below)
    if excess_below >= 0:
        return piece.parent
    excess_at_top = bound.excess(piece)
    if excess_at_top <= 0:
        return pieces.append_numbered(piece) if number is None else number
    place, punch = _crossing(
        table, (piece_below, piece), (excess_below, excess_at_top), bound, round_off
    )
    return pieces.add(piece.parent, place, punch.loads, piece.slopes)


def _ring(
    table: PunchTable, pieces: Pieces, top: int, bound: _Bound, round_off: float
) -> tuple[int, float, float]:
    """The memory curve with a line of slip inside it, where a stroke resumes while the edge of
    contact rests: number of its uppermost piece, and the places s of both ends of the slip zone,
    equal where there is none.

    Parameters
    ----------
    table
        loads of the punches by the place s of the edge
    pieces, top
        pieces of the curve, and the number of the uppermost one
    bound
        the Coulomb limit F of slip in the direction of that stroke
    round_off
        excess of F that counts as round-off
    """
    number = top
    piece = pieces[number]
    pieces_above = []
    while number and bound.excess(pieces[piece.parent]) <= round_off:
        pieces_above.append(piece)
        number = piece.parent
        piece = pieces[number]
    excess_at_top = bound.excess(piece)
    if not number or excess_at_top > 0:
        edge = pieces[top].top
        return top, edge, edge
    piece_ends = (pieces[piece.parent], piece)
    excesses_at_ends = (bound.excess(piece_ends[0]), excess_at_top)
    outer_end, loads_at_outer_end = _crossing(table, piece_ends, excesses_at_ends, bound, round_off)
    number_below = _front(table, pieces, pieces[piece.parent], piece.parent, bound, round_off)
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
    """Coordinate s of the flat punch at which friction that was locked in meets a bound of slip,
    and the loads of the punches up to there.

    The force F that a piece of the memory curve locked in grows with the loads of the punches of
    the profile (P), of a parabola (G) and of x^4/24 (H), with a slope over each; so does the bound.
    The excess of F over it is zero at s: Newton's rule between brackets.

    Parameters
    ----------
    ends
        the piece below, and the piece itself
    excesses
        of F over the bound at the tops of the two pieces, of opposite signs
    bound
        direction of slip, and slopes of the bound over P, G and H
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
    loads = table.loads_at(s)
    # Newton's rule, in the middle between two punches where it would leave them.
    for _ in range(_STEPS_OF_NEWTON):
        excess = excess_below + slope * (loads.load - piece_below.load)
        excess += parabola_slope * (loads.parabola - piece_below.parabola)
        excess += fourth_slope * (loads.fourth - piece_below.fourth)
        if abs(excess) <= round_off:
            break
        if excess * sign_of_rise > 0:
            high_s = s
        else:
            low_s = s
        rate = slope * loads.load_rate + parabola_slope * loads.parabola_rate
        rate += fourth_slope * loads.fourth_rate
        newton_s = s - excess / rate if rate * sign_of_rise > 0 else math.nan
        s = newton_s if low_s < newton_s < high_s else (low_s + high_s) / 2
        loads = table.loads_at(s)
    return s, loads
