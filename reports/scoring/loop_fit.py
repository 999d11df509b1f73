"""The f, the turning points and the rig at which theory's loop follows the rows of a measured one,
where P varies with Q as in the scene.

# notation: C compliance of the rig, f friction coefficient, Q_max and Q_min turning points of Q,
#           R = Q_max - Q_min, r factor of the file's Q over the scene's, tau share of the scene's
#           cycle, U0 origin of U, sigma standard deviation of the noise of a row

Least squares over f, Q_max, Q_min, C and U0. The turning points lie between rows: they are
parameters of the fit, beside what the rows of Q near them show. The loop is the closed curve

    U = r U(tau; f/r) + C Q + U0,   Q = r Q(tau) + Q0,

and the distance of a row is that from the nearest point of its branch, in sigma of U and of Q. Time
is no part of it. Where P is constant see `loop_masing`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.scoring.loop_branches import Branches, row_noise
from reports.scoring.loop_steadiness import Misfit, misfit_of
from scenes.array_types import Array

Indices = NDArray[np.intp]

# First trials of f, from just above gross sliding to so many times as much; beyond, a loop is a
# line.
_N_TRIAL_FRICTIONS = 24
_LEAST_LOG_OF_TRIALS = 0.04
_LARGEST_FRICTION_RATIO = 40.0
# Minima among the trials from which a fit begins.
_MOST_MINIMA = 3
# ln f on the way of a fit: so far below sliding the curve goes on straight, lest a fit end at a
# wall.
_LOG_BELOW_SLIDING = 0.2
# Chance gives so much of the sum of squares over its mean in 95 %: chi squared of one degree.
_CHI_SQUARED = 3.841
# Fits with the noise of the fit before, at most: they end where it changes by less than 5 %.
_MOST_REWEIGHTINGS = 8
# Distance from a branch, in sigma and over that from the other one, from which a row beside a
# turning point is the other's.
_LEAST_DISTANCE_OF_OTHER_BRANCH = 4.0
# Steps outwards to the end of an interval, each 1.3 times the one before, and halvings: to 1 % of
# the last step.
_MOST_STEPS_OUTWARDS = 60
_N_HALVINGS = 6
# Noise of rows that show none, over their largest value: f is not known better than theory's
# samples leave it.
_LEAST_NOISE = 1e-9
# Step of sqrt(ln(f/f of gross sliding)) between the loops that theory gives; cubic between them,
# to 1e-7 of U.
_ROOT_STEP = 0.02
# Both branches hold the part of the loop beside a turning point in which Q is so near to it, over
# the range of Q: noise and a standstill of Q leave open on which side of it a row lies.
_SHARE_BESIDE_TURN = 0.05
# Part of the range of Q in which the branch alone says where a row lies, for the start of a fit.
_MIDDLE_OF_RANGE = (0.1, 0.9)
# Instants of a branch between two that are compared first with each row; rows that are compared at
# a time.
_STRIDE_OF_CORNERS = 16
_ROWS_AT_ONCE = 8192


class RowNoise(NamedTuple):
    """Standard deviations of the noise of U [length] and of Q [force / thickness] in a row."""

    of_displacement: float
    of_load: float


@dataclass(frozen=True, eq=False)
class LoopRows:
    """Rows of a measured loop.

    Attributes
    ----------
    displacement, load
        (n,) U [length] and Q [force / thickness]
    branches
        whether each row lies on the rising or on the falling branch, and the turning points of Q
    compliance
        C of the rig [1/stress], or None where it is fitted
    """

    displacement: Array
    load: Array
    branches: Branches
    compliance: float | None

    @property
    def term_sizes(self) -> Array:
        """Typical sizes, (4,), of the four terms that are fitted beside f, in which steps of the
        fit are counted: highest and lowest Q of the loop [force / thickness], compliance C of the
        rig [1/stress] and origin U0 of the displacement [length].

        # notation: f coefficient of friction, Q tangential load
        """
        range_of_load = float(np.ptp(self.load))
        range_of_displacement = float(np.ptp(self.displacement))
        return np.array(
            [
                range_of_load,
                range_of_load,
                range_of_displacement / range_of_load,
                range_of_displacement,
            ]
        )

    def fitted_rig(
        self, theory_displacement: Array, is_counted: NDArray[np.bool_] | None = None
    ) -> tuple[float, float]:
        """The rig that fits the rows of a measured loop best: compliance C [1/stress] and origin U0
        [length] of U = U_theory + C Q + U0, by linear least squares. C is the stated one,
        `self.compliance`, where that is not None.

        Parameters
        ----------
        theory_displacement
            (n,) U of theory at the rows
        is_counted
            (n,) which of the rows count; all of them by default

        # notation: Q tangential load, U relative tangential displacement
        """
        is_used = (
            np.ones(len(theory_displacement), dtype=bool) if is_counted is None else is_counted
        )
        # measured U minus theory's: what the rig adds
        rig_displacement = (self.displacement - theory_displacement)[is_used]
        load_of_used_rows = self.load[is_used]
        if self.compliance is not None:
            return self.compliance, float(
                np.mean(rig_displacement - self.compliance * load_of_used_rows)
            )
        # unknowns: C and U0
        columns = np.column_stack([load_of_used_rows, np.ones_like(rig_displacement)])
        compliance, origin = np.linalg.lstsq(columns, rig_displacement, rcond=None)[0]
        return float(compliance), float(origin)


@dataclass(frozen=True, eq=False)
class LoopFit:
    """f at which theory's loop follows the rows best, and what was fitted with it.

    Attributes
    ----------
    friction, lowest_friction, highest_friction
        f that fits best, and the ends of its 95 % interval; the upper one is None where the rows
        exclude no larger f
    highest_load, lowest_load
        turning points of Q [force per thickness]
    compliance, origin
        C [1/stress] and U0 [length]
    displacement_noise, load_noise
        sigma of U and of Q
    misfit
        what the distances of the rows show beside scatter: correlation of neighbours, and the
        part that is systematic
    """

    friction: float
    lowest_friction: float
    highest_friction: float | None
    highest_load: float
    lowest_load: float
    compliance: float
    origin: float
    displacement_noise: float
    load_noise: float
    misfit: Misfit

    @property
    def terms(self) -> Array:
        """Q_max, Q_min, C and U0."""
        return np.array([self.highest_load, self.lowest_load, self.compliance, self.origin])


# -------------------------------------------------------------------- P varies: theory's whole loop
@dataclass(frozen=True, eq=False)
class NearestPoints:
    """The points of theory's loop that rows are nearest to.

    place : (n,) index of an instant of the loop, with a fraction
    distance : (n,) in sigma, positive on the left of the loop's direction
    displacement_part, load_part : (n,) components of the unit normal to the left of the loop
    """

    place: Array
    distance: Array
    displacement_part: Array
    load_part: Array


@dataclass(frozen=True, eq=False)
class LoopsOverFriction:
    """Theory's loops of a scene in which P varies: U at instants of a cycle for any f.

    Attributes
    ----------
    load
        (m,) Q of the scene at instants of a cycle; the last instant is the first of the next
    sliding_friction
        f of gross sliding of the scene
    displacement_with_friction
        solves the scene with another f: U (m,)
    displacement_by_step
        what that gave, by number of the step of sqrt(ln(f/sliding))
    """

    load: Array
    sliding_friction: float
    displacement_with_friction: Callable[[float], Array]
    displacement_by_step: dict[int, Array] = field(default_factory=dict)

    @property
    def range_of_load(self) -> float:
        """Range of the scene's Q, largest minus least [force / thickness]."""
        return float(np.ptp(self.load))

    def load_scale(self, highest_load: float, lowest_load: float) -> float:
        """Factor r of the file's Q over the scene's, from the turning points of the file's Q."""
        return (highest_load - lowest_load) / self.range_of_load

    def friction_at_gross_sliding(self, highest_load: float, lowest_load: float) -> float:
        """f of gross sliding between these turning points of the file's Q."""
        return self.sliding_friction * self.load_scale(highest_load, lowest_load)

    def first_frictions(self, highest_load: float, lowest_load: float) -> Array:
        """The 24 values of the friction coefficient f to try first, ascending. They go from 1.04 to
        40 times that of gross sliding between the turning points of the file's Q, `highest_load`
        and `lowest_load`.

        Their roots sqrt(ln(f/f of sliding)) are multiples of 0.02 (`_ROOT_STEP`), at which loops of
        theory are cached: one solution of theory is enough for each.

        # notation: Q tangential load
        """
        roots_of_log = np.linspace(
            math.sqrt(_LEAST_LOG_OF_TRIALS),
            math.sqrt(math.log(_LARGEST_FRICTION_RATIO)),
            _N_TRIAL_FRICTIONS,
        )
        roots_of_log = _ROOT_STEP * np.round(roots_of_log / _ROOT_STEP)
        return self.friction_at_gross_sliding(highest_load, lowest_load) * np.exp(roots_of_log**2)

    def _displacement_at_step(self, root_number: int) -> Array:
        """U (m,) of the scene with f = f_s exp(r^2), f_s that of gross sliding and the root r =
        0.02 times `root_number` (`_ROOT_STEP`). U is even in r. What was computed is cached.
        """
        root_number = abs(root_number)
        if root_number not in self.displacement_by_step:
            self.displacement_by_step[root_number] = self.displacement_with_friction(
                self.sliding_friction * math.exp((_ROOT_STEP * root_number) ** 2)
            )
        return self.displacement_by_step[root_number]

    def displacement(self, friction: float) -> Array:
        """U (m,) of the scene with the friction coefficient f [length]: interpolated by a cubic
        between loops of theory at steps of sqrt(ln(f/f of gross sliding)).
        """
        # the root for this f, in steps of 0.02
        root_in_steps = self._root_in_steps(friction)
        root_number = round(root_in_steps)
        if abs(root_in_steps - root_number) < 1e-9:
            return self._displacement_at_step(root_number)
        weights, _ = _cubic_weights(root_in_steps - math.floor(root_in_steps))
        return np.asarray(weights @ self._displacements_around(root_in_steps))

    def displacement_by_log_friction(self, friction: float) -> Array:
        """Derivative (m,) of U of the scene by ln f [length], f being the friction coefficient: by
        a cubic in the root sqrt(ln(f/f of gross sliding)), which is counted in steps of 0.02
        (`_ROOT_STEP`). With the root r in steps, ln f changes by 2 step^2 r dr.
        """
        # The root has no derivative at gross sliding itself: that just above is taken.
        root = max(self._root_in_steps(friction), 1e-3)
        _, weights_of_derivative = _cubic_weights(root - math.floor(root))
        # derivative of U by the root in steps; the four loops are those at the steps around it
        derivative_by_root = np.asarray(weights_of_derivative @ self._displacements_around(root))
        return derivative_by_root / (2 * _ROOT_STEP**2 * root)

    def _root_in_steps(self, friction: float) -> float:
        """sqrt(ln(f/sliding)) in steps of `_ROOT_STEP`; 0 below gross sliding, where U is that of
        sliding.
        """
        return math.sqrt(max(math.log(friction / self.sliding_friction), 0.0)) / _ROOT_STEP

    def _displacements_around(self, root_in_steps: float) -> Array:
        """U (4, m) at the two steps on each side of a root, which is counted in steps."""
        root_number = math.floor(root_in_steps)
        return np.array(
            [self._displacement_at_step(root_number + neighbour) for neighbour in (-1, 0, 1, 2)]
        )

    def ends_of_branch(self, *, is_rising: bool) -> tuple[int, int]:
        """Numbers of the first and the last instant of a branch of the scene's cycle. Q rises on it
        from its lowest to its highest value, or falls (`is_rising` False). Beyond the end of the
        cycle the numbers count on.

        # notation: Q tangential load
        """
        # self.load (m,): Q of the scene through a cycle; its last instant is the first of the next
        # one
        n_instants = len(self.load) - 1
        lowest_instant = int(np.argmin(self.load[:-1]))
        highest_instant = int(np.argmax(self.load[:-1]))
        begin = lowest_instant if is_rising else highest_instant
        end = highest_instant if is_rising else lowest_instant
        return begin, end if end > begin else end + n_instants

    @functools.cached_property
    def instants_by_branch(self) -> dict[bool, list[Indices]]:
        """Numbers of the instants of theory's cycle at which a row of the rising branch (True), or
        of the falling one (False), may lie: for each branch a list of up to three arrays.

        They are those of the branch itself, and some of the other branch before and behind it.
        There Q is within 5 % of its range from the turning point (`_SHARE_BESIDE_TURN`): noise can
        lay a row beyond it.

        # notation: Q tangential load
        """
        # self.load (m,): Q of the scene through a cycle, the first instant repeated at its end
        load_of_cycle = self.load[:-1]
        n_instants = len(load_of_cycle)
        instants_of_branches = {}
        for is_branch_rising in (True, False):
            # first and last instant of the branch
            begin, end = self.ends_of_branch(is_rising=is_branch_rising)
            instants_before = (begin - np.arange(1, n_instants // 2)) % n_instants
            instants_behind = (end + np.arange(1, n_instants // 2)) % n_instants
            # how many instants of the other branch lie near to the turning point
            first_near_begin = begin - self._count_of_instants_near_turn(
                load_of_cycle[instants_before]
            )
            last_near_end = end + self._count_of_instants_near_turn(load_of_cycle[instants_behind])
            spans_of_instants = ((begin, end), (first_near_begin, begin), (end, last_near_end))
            instants_of_branches[is_branch_rising] = [
                np.arange(first_instant, last_instant + 1)
                for first_instant, last_instant in spans_of_instants
                if last_instant > first_instant
            ]
        return instants_of_branches

    def _count_of_instants_near_turn(self, loads_from_turn: Array) -> int:
        """How many instants of the scene's cycle pass from a turning point of Q on, until Q is
        farther than 5 % of its range (`_SHARE_BESIDE_TURN`) from both ends of it. `loads_from_turn`
        (k,) is Q at these instants, from the turning point away; all count where Q never is.
        """
        margin = _SHARE_BESIDE_TURN * self.range_of_load
        distance_to_end = np.minimum(
            loads_from_turn - self.load.min(), self.load.max() - loads_from_turn
        )
        instants_beyond = np.flatnonzero(distance_to_end > margin)
        return int(instants_beyond[0]) if len(instants_beyond) else len(loads_from_turn)

    def start_of_rig(
        self, rows: LoopRows, friction: float, highest_load: float, lowest_load: float
    ) -> tuple[float, float]:
        """Compliance C [1/stress] and origin U0 [length] of the rig from which a fit begins: U = r
        U_theory + C Q + U0. r is the factor of the file's Q over the scene's.

        Each row is compared with theory's loop at the same Q, on the same branch. Rows near the
        turning points, where the branch is not certain, are left out as long as more than eight
        others remain.

        Parameters
        ----------
        rows
            U and Q of the measured rows, and whether each lies on the rising branch
        friction
            f of the file, whose Q is r times that of the scene
        highest_load, lowest_load
            Q at the upper and at the lower turning point of the rows

        # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
        """
        # r; self.load (m,): Q of the scene at instants of its cycle
        load_scale = self.load_scale(highest_load, lowest_load)
        displacement_of_scene = self.displacement(friction / load_scale)
        fraction_of_range = (rows.load - lowest_load) / (highest_load - lowest_load)
        load_of_scene = self.load.min() + self.range_of_load * np.clip(fraction_of_range, 0.0, 1.0)
        n_instants = len(self.load) - 1
        displacement_at_rows = np.empty(len(rows.load))
        for is_branch_rising in (True, False):
            is_on_branch = rows.branches.is_rising == is_branch_rising
            # first and last instant of the branch
            begin, end = self.ends_of_branch(is_rising=is_branch_rising)
            instants = np.arange(begin, end + 1) % n_instants
            instants_by_load = instants if is_branch_rising else instants[::-1]
            ascending_loads = np.maximum.accumulate(self.load[instants_by_load])
            displacement_at_rows[is_on_branch] = np.interp(
                load_of_scene[is_on_branch],
                ascending_loads,
                displacement_of_scene[instants_by_load],
            )
        # the middle: from 0.1 to 0.9 of the range of Q
        is_in_middle = (fraction_of_range > _MIDDLE_OF_RANGE[0]) & (
            fraction_of_range < _MIDDLE_OF_RANGE[1]
        )
        # least squares of U - r U_theory over C Q + U0
        rows_that_count = is_in_middle if np.count_nonzero(is_in_middle) > 8 else None
        return rows.fitted_rig(load_scale * displacement_at_rows, rows_that_count)

    def displacement_and_load_of_loop(self, friction: float, terms: Array) -> tuple[Array, Array]:
        """U and Q of theory's loop at instants of a cycle, (m,) each [length, force / thickness];
        the last instant is the first of the next cycle. U is r U_theory + C Q + U0, where r is the
        range of Q of the loop over that of the scene. U_theory belongs to the friction coefficient
        f/r.

        Parameters
        ----------
        friction
            f of the loop
        terms
            (4,) highest Q, lowest Q, and compliance C and origin U0 of the rig

        # notation: Q tangential load, U relative tangential displacement
        """
        highest_load, lowest_load, compliance, origin = terms.tolist()
        load_scale = self.load_scale(highest_load, lowest_load)  # r
        # self.load (m,): Q of the scene
        load_of_loop = lowest_load + load_scale * (self.load - self.load.min())
        displacement_of_loop = (
            load_scale * self.displacement(friction / load_scale)
            + compliance * load_of_loop
            + origin
        )
        return displacement_of_loop, load_of_loop

    def nearest_points(
        self, rows: LoopRows, friction: float, terms: Array, noise: RowNoise
    ) -> NearestPoints:
        """The point of theory's loop of Q over U that is nearest to each of n measured rows, on the
        branch of the row or just beyond the branch's turning points.

        Returns, (n,) each: the place of the point, an index of an instant of the cycle, with a
        fraction, which may lie beyond the cycle's begin or end; the distance of the row from it,
        positive on the left of the direction in which the loop is passed; and both components of
        the unit normal to the left. U and Q are divided by their sigma, so that distances have no
        unit.

        U of the loop is r U(f/r) + C Q + U0, where U(f/r) is that of the scene with friction f/r,
        and r the range of Q of the loop over that of the scene. At the same P, r times as large a
        Q with f makes r times the U that Q makes with f/r.

        Parameters
        ----------
        rows
            the measured rows: `displacement` U and `load` Q, (n,) each; `branches.is_rising` (n,)
            states whether each lies on the branch of rising Q
        friction
            f of the loop
        terms
            (4,) highest Q, lowest Q, and C and U0 of the rig
        noise
            sigma, the standard deviation of the noise of U and of Q

        # notation: C compliance of the rig, f coefficient of friction, P normal load, Q tangential
        #           load, U relative tangential displacement, U0 its origin
        """
        # Rows and loop in sigmas, (2, n) and (2, m): U, then Q.
        row_points = np.array(
            [rows.displacement / noise.of_displacement, rows.load / noise.of_load]
        )
        displacement_of_loop, load_of_loop = self.displacement_and_load_of_loop(friction, terms)
        loop_points = np.array(
            [displacement_of_loop / noise.of_displacement, load_of_loop / noise.of_load]
        )

        # Nearest points on all pieces of the loop where a row of the branch may lie. Of each row:
        # place, distance, components of the unit normal along U and Q.
        n_instants = len(self.load) - 1
        values_of_nearest = np.empty((4, len(rows.load)))
        values_of_nearest[1] = math.inf
        for is_branch_rising in (True, False):
            indices_of_branch = np.flatnonzero(rows.branches.is_rising == is_branch_rising)
            # instants of the branch itself, and of pieces of the other one beside it
            for instants in self.instants_by_branch[is_branch_rising]:
                polyline = loop_points[:, instants % n_instants]
                for first_of_block in range(0, len(indices_of_branch), _ROWS_AT_ONCE):
                    # one block of rows, which bounds the memory, against one piece of the loop
                    block = slice(first_of_block, first_of_block + _ROWS_AT_ONCE)
                    block_indices = indices_of_branch[block]
                    candidates = nearest_on_polyline(row_points[:, block_indices], polyline)
                    candidates[0] += instants[0]
                    is_nearer = np.abs(candidates[1]) < np.abs(values_of_nearest[1, block_indices])
                    values_of_nearest[:, block_indices[is_nearer]] = candidates[:, is_nearer]
        return NearestPoints(*values_of_nearest)

    def distances(self, rows: LoopRows, friction: float, terms: Array, noise: RowNoise) -> Array:
        """Distances (n,) of the rows from their branches of theory's loop, in sigma."""
        return self.nearest_points(rows, friction, terms, noise).distance

    def distances_with_derivatives(
        self, rows: LoopRows, friction: float, terms: Array, noise: RowNoise
    ) -> tuple[Array, Array]:
        """Distances of measured rows from theory's loop of Q over U in sigma (n,), and their
        derivatives by ln f, highest Q, lowest Q, C and U0 (n, 5).

        Parameters
        ----------
        rows
            U and Q of the n rows, and whether each lies on the rising branch
        friction
            f of the loop
        terms
            (4,) highest Q, lowest Q, and C and U0 of the rig
        noise
            sigma, standard deviation of the noise of U and of Q

        # notation: C compliance of the rig, f friction coefficient, Q tangential load, U relative
        #           tangential displacement, U0 origin of U
        """
        # place, distance and unit normal (displacement_part, load_part) of each row
        nearest_points = self.nearest_points(rows, friction, terms, noise)
        # place of the nearest point in the scene's cycle, as a number of instants. The point moves
        # along the loop too; the distance, measured across the loop, does not change by that.
        place = np.mod(nearest_points.place, len(self.load) - 1)
        displacement_derivatives, load_derivatives = self._derivatives_at_places(
            place, friction, terms
        )
        # a signed distance falls by what the nearest point moves along the unit normal
        derivatives = (
            -nearest_points.displacement_part[:, None]
            * displacement_derivatives
            / noise.of_displacement
            - nearest_points.load_part[:, None] * load_derivatives / noise.of_load
        )
        return nearest_points.distance, derivatives

    def _derivatives_at_places(
        self, place: Array, friction: float, terms: Array
    ) -> tuple[Array, Array]:
        """Derivatives of U and of Q of theory's loop by ln f, highest Q, lowest Q, C and U0, (n, 5)
        each, at fixed places of the scene's cycle. The loop is U = r U_theory + C Q + U0, where r
        is its range of Q over that of the scene. U_theory belongs to f/r.

        Parameters
        ----------
        place
            (n,) places in the cycle: index of an instant, with a fraction
        friction
            f of the loop
        terms
            (4,) highest Q, lowest Q, and C and U0 of the rig

        # notation: C compliance of the rig, f friction coefficient, Q tangential load, U relative
        #           tangential displacement, U0 origin of U
        """
        highest_load, lowest_load, compliance, _ = terms.tolist()
        load_scale = self.load_scale(highest_load, lowest_load)  # r
        instants = np.arange(len(self.load))
        # self.load (m,): Q of the scene at the instants
        load_above_lowest = np.interp(place, instants, self.load - self.load.min())
        fraction_of_range = load_above_lowest / self.range_of_load
        displacement_at_place = np.interp(place, instants, self.displacement(friction / load_scale))
        displacement_by_log = self.displacement_by_log_friction(friction / load_scale)
        displacement_by_log_at_place = load_scale * np.interp(place, instants, displacement_by_log)
        # U depends on r, and so on the range of Q, by r U_theory(f/r)
        displacement_by_range = (
            displacement_at_place - displacement_by_log_at_place / load_scale
        ) / self.range_of_load
        displacement_derivatives = np.column_stack(
            [
                displacement_by_log_at_place,
                displacement_by_range + compliance * fraction_of_range,
                -displacement_by_range + compliance * (1 - fraction_of_range),
                lowest_load + (highest_load - lowest_load) * fraction_of_range,
                np.ones_like(fraction_of_range),
            ]
        )
        load_derivatives = np.zeros_like(displacement_derivatives)
        load_derivatives[:, 1] = fraction_of_range
        load_derivatives[:, 2] = 1 - fraction_of_range
        return displacement_derivatives, load_derivatives


def _cubic_weights(x: float) -> tuple[Array, Array]:
    """Weights of the four values at the nodes -1, 0, 1 and 2 in Lagrange's cubic through them: in
    its value at `x`, (4,), and in its derivative there, (4,).

    >>> at = np.array([-1.0, 0.0, 1.0, 2.0])
    >>> values, rates = _cubic_weights(0.5)
    >>> float(values @ at**3), float(rates @ at**3)
    (0.125, 0.75)
    """
    nodes = np.array([-1.0, 0.0, 1.0, 2.0])
    weights = np.empty(4)
    weights_of_derivative = np.empty(4)
    for node_number in range(4):
        other_nodes = np.delete(nodes, node_number)
        divisor = np.prod(nodes[node_number] - other_nodes)
        x_from_first, x_from_second, x_from_third = x - other_nodes
        weights[node_number] = x_from_first * x_from_second * x_from_third / divisor
        weights_of_derivative[node_number] = (
            x_from_first * x_from_second
            + x_from_second * x_from_third
            + x_from_third * x_from_first
        ) / divisor
    return weights, weights_of_derivative


def nearest_on_polyline(points: Array, polyline: Array) -> Array:
    """The point of a polyline that is nearest to each of n points.

    Returns (4, n): the place on the polyline (index of its segment plus the fraction of it that is
    passed); the distance, positive on the left of the polyline; and two components of the unit
    normal, to the left. The nearest of every sixteenth corner (`_STRIDE_OF_CORNERS`) is searched
    first, then the nearest corner around it. The polyline does not fold back.

    Parameters
    ----------
    points
        (2, n) their coordinates
    polyline
        (2, m) its corners

    Examples
    --------
    >>> points = np.array([[1.5, -1.0], [1.0, 0.0]])
    >>> polyline = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
    >>> np.round(nearest_on_polyline(points, polyline), 12).tolist()
    [[1.5, 0.0], [1.0, 1.0], [0.0, -1.0], [1.0, 0.0]]
    """
    # nearest corner of the polyline to each point: among coarse ones, then around the best
    last_corner = polyline.shape[1] - 1
    coarse_corners = np.minimum(
        np.arange(0, last_corner + _STRIDE_OF_CORNERS, _STRIDE_OF_CORNERS), last_corner
    )
    nearest_corner = coarse_corners[
        _index_of_nearest_corner(points, polyline[:, coarse_corners][:, None, :])
    ]
    corners_around = np.clip(
        nearest_corner[:, None] + np.arange(-_STRIDE_OF_CORNERS, _STRIDE_OF_CORNERS + 1),
        0,
        last_corner,
    )
    index_of_nearest = _index_of_nearest_corner(points, polyline[:, corners_around])
    nearest_corner = corners_around[np.arange(len(index_of_nearest)), index_of_nearest]

    # (n, 2) indices of the segment in front of the nearest corner, and of the one behind it
    adjacent_segments = np.clip(nearest_corner[:, None] + np.array([-1, 0]), 0, last_corner - 1)
    segment_start = polyline[:, adjacent_segments]
    segment_vector = polyline[:, adjacent_segments + 1] - segment_start
    vector_from_start = points[:, :, None] - segment_start
    length_squared = np.maximum(np.sum(segment_vector**2, axis=0), 1e-300)
    fraction_of_segment = np.clip(
        np.sum(vector_from_start * segment_vector, axis=0) / length_squared, 0.0, 1.0
    )
    vector_to_point = vector_from_start - fraction_of_segment * segment_vector
    which_is_nearer = np.argmin(np.sum(vector_to_point**2, axis=0), axis=1)

    # of the nearer of the two segments
    point_numbers = np.arange(points.shape[1])
    fraction_of_segment = fraction_of_segment[point_numbers, which_is_nearer]
    segment_vector = segment_vector[:, point_numbers, which_is_nearer]
    vector_to_point = vector_to_point[:, point_numbers, which_is_nearer]
    distance = np.hypot(vector_to_point[0], vector_to_point[1])
    cross_product = segment_vector[0] * vector_to_point[1] - segment_vector[1] * vector_to_point[0]
    distance = np.where(cross_product < 0, -distance, distance)

    # Normal of the segment, to its left. Beyond a corner it has the direction from there to the
    # point, or the opposite one where the point lies on the right.
    segment_length = np.sqrt(length_squared[point_numbers, which_is_nearer])
    normal_of_segment = np.array([-segment_vector[1], segment_vector[0]]) / segment_length
    is_at_corner = ((fraction_of_segment == 0) | (fraction_of_segment == 1)) & (distance != 0)
    normal = np.where(
        is_at_corner, vector_to_point / np.where(is_at_corner, distance, 1.0), normal_of_segment
    )
    return np.array(
        [adjacent_segments[point_numbers, which_is_nearer] + fraction_of_segment, distance, *normal]
    )


def _index_of_nearest_corner(points: Array, corners: Array) -> Indices:
    """Index (n,) of the corner nearest to each of n points (2, n), among k corners of that point
    alone, (2, n, k), or k corners common to all points, (2, 1, k).
    """
    distance_squared = (points[0][:, None] - corners[0]) ** 2
    distance_squared += (points[1][:, None] - corners[1]) ** 2
    return np.asarray(np.argmin(distance_squared, axis=1))


# ------------------------------------------------------------------------------------------ the fit
@dataclass(frozen=True, eq=False)
class _FitParameters:
    """The five parameters of a loop of tangential load Q over displacement U, and which of them a
    fit changes: ln f, highest Q, lowest Q, compliance C of the rig and origin U0 of U. f is the
    friction coefficient.

    Attributes
    ----------
    start
        (5,) their values at the begin of the fit
    is_fitted
        (5,) whether the fit changes each
    typical_sizes
        (n_fitted,) unit in which a step of each fitted parameter is counted
    log_friction_bounds
        least and largest ln f on the way of the fit
    """

    start: Array
    is_fitted: NDArray[np.bool_]
    typical_sizes: Array
    log_friction_bounds: tuple[float, float]

    def after_steps(self, steps: Array) -> tuple[float, Array]:
        """f, and highest Q, lowest Q, C and U0 (4,), after `steps` (n_fitted,) from the start in
        typical sizes. ln f stays within its bounds.
        """
        parameters = self.start.copy()
        parameters[self.is_fitted] += steps * self.typical_sizes
        lowest_log, highest_log = self.log_friction_bounds
        log_friction = min(max(parameters[0], lowest_log), highest_log)
        return math.exp(log_friction), parameters[1:]


@dataclass(frozen=True, eq=False)
class _Search:
    """Least squares of the distances of rows from a model, and of its turning points from those of
    Q alone.
    """

    rows: LoopRows
    model: LoopsOverFriction
    noise: RowNoise
    sliding_friction: float  # f of gross sliding between the turning points of the rows

    def residuals(self, friction: float, terms: Array) -> Array:
        """Residuals of theory's loop of Q over U from n measured rows, each over its standard
        deviation, (n + 2,): distances of the rows from the loop, then differences of its highest
        and lowest Q from those that the rows of Q show. `terms` (4,) are highest Q, lowest Q,
        compliance C of the rig and origin U0 of the displacement.
        """
        distances = self.model.distances(self.rows, friction, terms, self.noise)
        return np.concatenate([distances, self._residuals_of_turns(terms)])

    def _residuals_of_turns(self, terms: Array) -> Array:
        """Differences (2,) of highest and lowest Q of a loop from the turning points that the
        measured rows show, over the standard errors of these. `terms` (4,) begins with highest and
        lowest Q.

        # notation: Q tangential load
        """
        highest_turn = self.rows.branches.highest_turn
        lowest_turn = self.rows.branches.lowest_turn
        # highest_turn.load: highest Q that the rows show
        return np.array(
            [
                (terms[0] - highest_turn.load) / highest_turn.standard_error,
                (terms[1] - lowest_turn.load) / lowest_turn.standard_error,
            ]
        )

    def _residuals_with_derivatives(
        self, friction: float, terms: Array, model: LoopsOverFriction
    ) -> tuple[Array, Array]:
        """Residuals of theory's loop from n measured rows over sigma, (n + 2,): distances of the
        rows, then differences of highest and lowest Q; and their derivatives by ln f and the four
        terms, (n + 2, 5). The terms are highest Q, lowest Q, rig compliance C and origin U0.

        # notation: f coefficient of friction, Q tangential load, sigma standard deviation of the
        #           noise
        """
        distances, derivatives_of_distances = model.distances_with_derivatives(
            self.rows, friction, terms, self.noise
        )
        # of the differences over the standard errors of both turning points
        derivatives_of_turns = np.zeros((2, 5))
        derivatives_of_turns[0, 1] = 1 / self.rows.branches.highest_turn.standard_error
        derivatives_of_turns[1, 2] = 1 / self.rows.branches.lowest_turn.standard_error
        residuals = np.concatenate([distances, self._residuals_of_turns(terms)])
        return residuals, np.concatenate([derivatives_of_distances, derivatives_of_turns])

    def start_terms(self, friction: float) -> Array:
        """The four terms from which a fit at this friction coefficient begins: highest and lowest Q
        of the measured loop, compliance C of the rig and origin U0 of the displacement, (4,).
        """
        # Q at the turning points, as the rows show it
        highest_load = self.rows.branches.highest_turn.load
        lowest_load = self.rows.branches.lowest_turn.load
        rig = self.model.start_of_rig(self.rows, friction, highest_load, lowest_load)
        return np.array([highest_load, lowest_load, *rig])

    def first_fit(self, trial_frictions: Array) -> tuple[float, Array]:
        """f and the four terms of the best fit to measured rows (highest Q, lowest Q, and C and U0
        of the rig). Fits begin from up to three trial values of f, at which the sum of squares is
        smaller than at both neighbours. The squares are distances of the rows from theory's loop.

        A loop that hardly slips, in a stiffer rig, is a minimum of its own where P varies.

        Parameters
        ----------
        trial_frictions
            (k,) values of f, ascending

        # notation: C compliance of the rig, f coefficient of friction, P normal load, Q tangential
        #           load, U0 origin of the displacement
        """
        # of each trial, terms (4,) to begin with
        starts = [self.start_terms(friction) for friction in trial_frictions.tolist()]
        sums_of_squares = np.array(
            [
                np.sum(self.residuals(friction, start_terms) ** 2)
                for friction, start_terms in zip(trial_frictions.tolist(), starts, strict=True)
            ]
        )
        # minima among the trials, with infinite sums beyond the first and the last one
        sums_with_walls = np.concatenate([[math.inf], sums_of_squares, [math.inf]])
        indices_of_minima = np.flatnonzero(
            (sums_of_squares <= sums_with_walls[:-2]) & (sums_of_squares <= sums_with_walls[2:])
        )
        indices_of_lowest = indices_of_minima[np.argsort(sums_of_squares[indices_of_minima])][
            :_MOST_MINIMA
        ]
        # least sum of squares, f and terms of each fit
        fits = [
            self.best_fit(float(trial_frictions[trial_number]), starts[trial_number])
            for trial_number in indices_of_lowest.tolist()
        ]
        _, friction, terms = min(fits, key=lambda fit: fit[0])
        return friction, terms

    def best_terms(self, friction: float, start_terms: Array) -> tuple[float, Array]:
        """Least sum of squares at this f, and Q_max, Q_min, C, U0 that give it, from `start_terms`
        near them.
        """
        sum_of_squares, _, terms = self._least_squares(friction, start_terms, fits_friction=False)
        return sum_of_squares, terms

    def best_fit(self, friction: float, start_terms: Array) -> tuple[float, float, Array]:
        """Least sum of squares, and f and the four terms that give it, from values near them."""
        return self._least_squares(friction, start_terms, fits_friction=True)

    def _least_squares(
        self, friction: float, start_terms: Array, *, fits_friction: bool
    ) -> tuple[float, float, Array]:
        """Least sum of squares between measured rows and theory's loop, and the friction
        coefficient f and terms that give it. Levenberg and Marquardt's method begins from
        `friction` and `start_terms`.

        The terms are highest Q, lowest Q, compliance C of the rig and origin U0 of the
        displacement, (4,). f keeps its value unless `fits_friction`; C keeps it where the rig's
        compliance is stated.

        # notation: Q tangential load
        """
        from scipy.optimize import least_squares

        # ln f, then the four terms
        is_fitted = np.array([fits_friction, True, True, self.rows.compliance is None, True])
        parameters = _FitParameters(
            start=np.array([math.log(friction), *start_terms]),
            is_fitted=is_fitted,
            typical_sizes=np.array([1.0, *self.rows.term_sizes])[is_fitted],
            log_friction_bounds=self.log_friction_bounds,
        )

        # scipy calls for residuals and for derivatives separately: both are cached for these steps
        @functools.lru_cache(maxsize=2)
        def residuals_and_derivatives(step_bytes: bytes) -> tuple[Array, Array]:
            """Residuals over sigma (n + 2,), and derivatives by steps of the fitted parameters."""
            trial_friction, trial_terms = parameters.after_steps(np.frombuffer(step_bytes))
            residuals, derivatives = self._residuals_with_derivatives(
                trial_friction, trial_terms, self.model
            )
            return residuals, derivatives[:, is_fitted] * parameters.typical_sizes

        minimum = least_squares(
            lambda steps: residuals_and_derivatives(steps.tobytes())[0],
            np.zeros(len(parameters.typical_sizes)),
            jac=lambda steps: residuals_and_derivatives(steps.tobytes())[1],
            method="lm",
            xtol=1e-11,
            ftol=1e-11,
        )
        best_friction, best_terms = parameters.after_steps(minimum.x)
        # scipy's cost is half the sum of squares
        return 2 * float(minimum.cost), best_friction, best_terms

    @property
    def log_friction_bounds(self) -> tuple[float, float]:
        """Least and largest ln f on the way of a fit: 0.2 below that of gross sliding, and that of
        40 times f of gross sliding. f is the friction coefficient.
        """
        return (
            math.log(self.sliding_friction) - _LOG_BELOW_SLIDING,
            math.log(self.sliding_friction * _LARGEST_FRICTION_RATIO),
        )

    @property
    def degrees_of_freedom(self) -> int:
        """Number of rows minus the number of fitted parameters: f, highest Q, lowest Q, origin of
        the displacement, and compliance of the rig where it is not stated.
        """
        return len(self.rows.displacement) - 4 - (self.rows.compliance is None)

    def friction_interval(
        self, friction: float, terms: Array, least_sum: float, widening: float
    ) -> tuple[float, float | None]:
        """Ends of the 95 % interval of the friction coefficient f. The lower one is at least f of
        gross sliding; the upper one is None where the sum of squares stays below its limit up to 40
        times that f. The squares are distances of measured rows from theory's loop.

        Parameters
        ----------
        friction, terms
            f of the best fit; its highest Q, lowest Q, rig compliance C and origin U0, (4,)
        least_sum
            sum of squares of the best fit
        widening
            factor of the interval where neighbouring rows lie on one side of the loop, 1 or more

        # notation: Q tangential load
        """
        # _CHI_SQUARED: 3.841, of one degree of freedom in 95 %
        largest_sum = least_sum + _CHI_SQUARED * widening**2 * max(
            least_sum / self.degrees_of_freedom, 1.0
        )
        log_friction = math.log(friction)
        # ln f, None where the sum stays below the largest one
        log_lower_end = self.interval_end(
            log_friction, terms, math.log(self.sliding_friction * (1 + 1e-9)), largest_sum
        )
        log_upper_end = self.interval_end(
            log_friction,
            terms,
            math.log(self.sliding_friction * _LARGEST_FRICTION_RATIO),
            largest_sum,
        )
        lower_end = self.sliding_friction if log_lower_end is None else math.exp(log_lower_end)
        return lower_end, None if log_upper_end is None else math.exp(log_upper_end)

    def search_with_rows_at_turns_moved(self, friction: float, terms: Array) -> _Search:
        """A search for the best fit in which rows beside a turning point are moved to the other
        branch. A row is moved if it lies more than 4 sigma from theory's loop, and less than a
        quarter as far from the other branch. A turning point is known to within one row only.

        `terms` (4,) are highest Q, lowest Q, compliance C of the rig and origin U0 of the
        displacement.

        # notation: Q tangential load, sigma standard deviation of the noise
        """
        branches = self.rows.branches
        # (n,) whether each row lies on the rising branch
        is_rising = branches.is_rising
        last_rows_of_branches = np.flatnonzero(is_rising[1:] != is_rising[:-1])
        rows_at_turns = np.unique(
            np.concatenate([last_rows_of_branches, last_rows_of_branches + 1])
        )
        rising_if_moved = is_rising.copy()
        rising_if_moved[rows_at_turns] = ~is_rising[rows_at_turns]
        # the last two residuals are of the turning points
        distance_as_is = np.abs(self.residuals(friction, terms)[:-2])
        distance_if_moved = np.abs(
            self._search_with_branches(rising_if_moved).residuals(friction, terms)[:-2]
        )
        is_moved = (is_rising != rising_if_moved) & (
            distance_as_is > _LEAST_DISTANCE_OF_OTHER_BRANCH * np.maximum(distance_if_moved, 1.0)
        )
        return self._search_with_branches(np.where(is_moved, rising_if_moved, is_rising))

    def _search_with_branches(self, is_rising: NDArray[np.bool_]) -> _Search:
        """The same search with rows on other branches, `is_rising` (n,) where Q rises."""
        branches = replace(self.rows.branches, is_rising=is_rising)
        return replace(self, rows=replace(self.rows, branches=branches))

    def interval_end(
        self, log_friction: float, terms: Array, end_of_search: float, largest_sum: float
    ) -> float | None:
        """One end of the 95 % interval of the friction coefficient f, as ln f: where the least sum
        of squares rises above `largest_sum` on the way from the best f to the end of the search.
        None where it stays below. The squares are distances of measured rows from theory's loop.

        Parameters
        ----------
        log_friction, terms
            ln f of the best fit; its highest Q, lowest Q, rig compliance C and origin U0, (4,)
        end_of_search
            ln f up to which it is sought, below or above the best one
        largest_sum
            sum of squares that the interval admits

        # notation: Q tangential load
        """
        latest_terms = terms

        def excess_over_largest(log_trial: float) -> float:
            """Least sum of squares at ln f = `log_trial`, minus the largest one admitted."""
            nonlocal latest_terms
            # the best terms at this f, searched from the latest ones on
            sum_of_squares, latest_terms = self.best_terms(math.exp(log_trial), latest_terms)
            return sum_of_squares - largest_sum

        # 1 towards the upper end, -1 towards the lower one
        direction = 1.0 if end_of_search > log_friction else -1.0
        # The sum of squares is nearly a parabola: its rise over a small step gives the distance to
        # the end of the interval.
        excess_at_best = excess_over_largest(log_friction)
        step_of_log = min(1e-3, abs(end_of_search - log_friction) / 2)
        rise_at_step = max(
            excess_over_largest(log_friction + direction * step_of_log) - excess_at_best, 1e-300
        )
        step_of_log *= math.sqrt(max(-excess_at_best / rise_at_step, 1e-8))

        # steps outwards, each 1.3 times the one before
        log_friction_within = log_friction
        for _ in range(_MOST_STEPS_OUTWARDS):
            log_friction_beyond = log_friction + direction * min(
                step_of_log, abs(end_of_search - log_friction)
            )
            if excess_over_largest(log_friction_beyond) > 0:
                # the end lies between the last two ln f, which six halvings bring together
                for _ in range(_N_HALVINGS):
                    log_friction_between = (log_friction_within + log_friction_beyond) / 2
                    if excess_over_largest(log_friction_between) > 0:
                        log_friction_beyond = log_friction_between
                    else:
                        log_friction_within = log_friction_between
                return log_friction_beyond
            if log_friction_beyond == end_of_search:
                return None
            log_friction_within = log_friction_beyond
            step_of_log *= 1.3
        return None


def fit_loop(
    rows: LoopRows,
    model: LoopsOverFriction,
    resolution: tuple[float, float],
    error_of_theory: float,
) -> LoopFit:
    """Fit theory's loop of load Q over displacement U to the rows of a measured one, where P
    varies: friction coefficient f, turning points, compliance C of the rig and origin U0 of the
    displacement, with the 95 % interval of f. The noise of U and of Q is estimated from the rows,
    and again from the residuals of each fit.

    The upper end of the interval is None where the sum of squares never rises far enough; the lower
    one is at least f of gross sliding.

    Parameters
    ----------
    rows
        U and Q of each row; `branches`, with the highest and the lowest turning point of Q and the
        noise of Q; `compliance`, C where it is stated, else None
    model
        theory's loops for any f
    resolution
        smallest differences of U [length] and Q [force / thickness] that the digits of the rows
        show
    error_of_theory
        error of a fitted f, over f, since theory's loops are interpolated between samples

    # notation: P normal load
    """
    # Q at the turning points, as the rows show it
    highest_load = rows.branches.highest_turn.load
    lowest_load = rows.branches.lowest_turn.load
    sliding_friction = model.friction_at_gross_sliding(highest_load, lowest_load)
    least_noise = noise_of_last_digits(rows.displacement, rows.load, resolution)
    first_noise = _noise_of_neighbouring_rows(rows, least_noise)
    search = _Search(rows, model, first_noise, sliding_friction)

    # trial values of f begin just above gross sliding; terms: highest Q, lowest Q, C and U0
    friction, terms = search.first_fit(model.first_frictions(highest_load, lowest_load))
    search, friction, terms = _search_with_noise_of_fit(search, friction, terms, least_noise)
    least_sum, friction, terms = search.best_fit(friction, terms)
    friction = max(friction, sliding_friction * (1 + 1e-9))

    # how the distances of neighbouring rows go together, which widens the interval of f
    # the last two residuals are of the turning points
    distances = search.residuals(friction, terms)[:-2]
    misfit = misfit_of(distances, search.noise.of_displacement)
    lowest_friction, highest_friction = search.friction_interval(
        friction, terms, least_sum, misfit.widening
    )
    sampling_error = friction * error_of_theory
    return LoopFit(
        friction=friction,
        lowest_friction=max(sliding_friction, lowest_friction - sampling_error),
        highest_friction=None if highest_friction is None else highest_friction + sampling_error,
        highest_load=float(terms[0]),
        lowest_load=float(terms[1]),
        compliance=float(terms[2]),
        origin=float(terms[3]),
        displacement_noise=search.noise.of_displacement,
        load_noise=search.noise.of_load,
        misfit=misfit,
    )


def noise_of_last_digits(
    displacement: Array, load: Array, resolution: tuple[float, float]
) -> RowNoise:
    """Least standard deviations of the noise of U and Q in the rows of a measured loop: those of
    rounding to the last digit, and at least 1e-9 of the largest value.

    A value that is rounded to steps has the standard deviation step/sqrt(12).

    Parameters
    ----------
    displacement, load
        (n,) U [length] and Q [force / thickness] of the rows
    resolution
        steps of U and of Q that the digits show, in the same units

    # notation: Q tangential load, U relative tangential displacement
    """
    displacement_step, load_step = resolution
    return RowNoise(
        max(displacement_step / math.sqrt(12), _LEAST_NOISE * float(np.max(np.abs(displacement)))),
        max(load_step / math.sqrt(12), _LEAST_NOISE * float(np.max(np.abs(load)))),
    )


def _noise_of_neighbouring_rows(rows: LoopRows, least_noise: RowNoise) -> RowNoise:
    """Standard deviations of the noise of U and Q that neighbouring rows of a measured loop show,
    each at least that of `least_noise`.

    # notation: Q tangential load, U relative tangential displacement
    """
    return RowNoise(
        max(row_noise(rows.displacement), least_noise.of_displacement),
        max(rows.branches.load_noise, least_noise.of_load),
    )


def _search_with_noise_of_fit(
    search: _Search, friction: float, terms: Array, least_noise: RowNoise
) -> tuple[_Search, float, Array]:
    """Fit theory's loop to measured rows again and again, each time weighted with the noise that
    the fit before left. Eight fits at most; they end where the noise changes by less than 5 %.

    Rows beside a turning point go to the other branch where that is far nearer.

    Parameters
    ----------
    search
        fits the loop, with the noise that neighbouring rows show
    friction, terms
        f, and highest Q, lowest Q, compliance C of the rig and origin U0 (4,), of the first fit
    least_noise
        standard deviations of U and Q below which no estimate goes

    Returns
    -------
    search, friction, terms
        the search with the last noise, and f and terms of the last fit

    # notation: f coefficient of friction, Q tangential load, U relative tangential displacement
    """
    for _ in range(_MOST_REWEIGHTINGS):
        _, friction, terms = search.best_fit(friction, terms)
        search = search.search_with_rows_at_turns_moved(friction, terms)
        # of the rows alone: the last two residuals are of the turning points
        sum_of_squares = float(np.sum(search.residuals(friction, terms)[:-2] ** 2))
        # noise that the fit leaves, over the noise it was weighted with
        noise_ratio = math.sqrt(sum_of_squares / search.degrees_of_freedom)
        new_noise = RowNoise(
            max(noise_ratio * search.noise.of_displacement, least_noise.of_displacement),
            max(noise_ratio * search.noise.of_load, least_noise.of_load),
        )
        noise_changes = np.array(new_noise) / np.array(search.noise) - 1
        search = replace(search, noise=new_noise)
        if np.max(np.abs(noise_changes)) < 0.05:
            break
    return search, friction, terms
