"""Faults of the model: soft penalties, bodies that end too near.

Two half-planes on a grid of constant tractions take one flaw at a time. What it does is the difference between this model with it
and without, on one grid, so that the grid itself drops out to first order: it tells patterns apart, and its sizes are no figures.
What moves the edges of contact moves square roots, of which a grid knows little. So where a flaw does that, half-plane theory with
another E*/R takes the part that such a change can take, exactly, and the grid adds the rest:

    predicted = theory(m) + model(flaw) - model(m)

# notation: h element lengths; p, q tractions (n,); g initial gap; delta approach; U shift; s slip, upper over lower; f friction
#           K_ij = 2/(pi E*) int ln|x_i - t| dt over element j: faces move by -K p into the bodies, s = U + K q where alike

    gap:   g - delta - (K_n - C_n) p >= 0,  p >= 0
    slip:  s = U + (K_t - C_t) q,  |q| <= f p,  q s' >= 0
    C = I/k, a layer: a penalty lets faces sink by p/k and creep by q/k
    K + b (x_i - x_j)^2 h_j, a body that ends: the far field of a resultant, to its lowest order that is no rigid motion
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.comparison.metrics import compliance
from reports.scoring.hypotheses import SAME_LOAD, Array, Discrepancy, Hypothesis, Tractions, fitted

Flags = NDArray[np.bool_]

# Half-length of the grid over the largest half-width of the reference: soft layers widen a contact.
ROOM = 1.35
# Elements over the largest half-width, where nothing travels and where edges do; for what an edge leaves within one
# thin layer, FINEST. A layer thinner than THIN of the FINE elements is not seen by them.
COARSE, FINE, FINEST, THIN = 20, 80, 320, 2.0
# Increments of a cycle that the model takes; and of a smooth path, for thin layers, whose trace lies where an edge stopped: at
# k = 240 E*/a on hertz-paper 32 explain 0.70 of the discrepancy, 128 0.76, 256 0.77.
INCREMENTS, SMOOTH = 32, 256
# A body that ends sends back P and Q alike, both by the order of 1/L^2 of its size: neither bend is many times the other.
ALIKE = 4.0
# Sizes looked for: logarithms of layers over a/E*, bends over 1/(E* a^2). Beyond, nothing is left of the scene's contact.
LAYERS = tuple(np.log([1e-3, 1e-2, 0.1, 1.0, 3.0]))
SHEAR_LAYERS = tuple(np.log([1e-3, 1e-2, 0.1, 1.0, 10.0, 30.0]))
BENDS = (-0.4, -0.1, 0.0, 0.1, 0.4)
# Of the range of sizes: a fit as close as this is close enough to tell patterns apart.
CLOSE = 0.004
_MOST, _TINY = 60, 1e-10


class NotSettledError(ArithmeticError):
    """The active sets of an increment do not converge, or the whole contact slides."""


@dataclass(frozen=True)
class Flaws:
    """What is wrong with a model."""

    normal_layer: float = 0.0  # 1/k [length/stress]
    shear_layer: float = 0.0
    normal_bend: float = 0.0  # b [1/(stress length)]
    shear_bend: float = 0.0
    steepness: float = 1.0  # factor of the gap, and so of E* in the tractions


class Model:
    """Two bodies in elements, the loads that they step through, and which increments are the instants of the discrepancy.

    `increments` a cycle. Bodies are alike: p and q are even, and half of the contact is enough.
    """

    def __init__(self, what: Discrepancy, increments: int, fine: int = FINE) -> None:
        scene, cycle, path = what.scene, what.comparison.expected, what.scene.load.path()
        self.half_width = what.comparison.scales.half_width
        # Fine elements where the edges of contact and stick travel.
        largest = float(np.nanmax(np.abs(cycle.contact_edges)))
        least = 0.8 * float(np.nanmin(np.abs(np.concatenate([cycle.contact_edges, cycle.stick_edges]))))
        inner = np.linspace(0, least, max(2, int(np.ceil(least / largest * COARSE))))
        middle = np.linspace(least, 1.1 * largest, max(2, int(np.ceil((1.1 - least / largest) * fine))))
        ends = np.unique(np.concatenate([inner, middle, np.linspace(1.1 * largest, ROOM * largest, 7)]))
        self._on_elements(ends, 2 / compliance(scene.material), scene.friction.coefficient, scene.profile.height)
        every, wanted = _times(what, increments)
        span = every.max() - path.start
        times = np.unique(np.round((every[every > path.start] - path.start) / span, 9)) * span + path.start
        self.loads, self.wanted = np.transpose(path.at(times)), np.abs(times[:, None] - wanted).argmin(axis=0)
        self._at, self._known = np.abs(what.x), dict[Flaws, Tractions]()

    def _on_elements(self, ends: Array, modulus: float, friction: float, height: Callable[[Array], Array]) -> None:
        """Centres and gaps of the elements between `ends` from 0 up, and the matrices between them, the mirror image added."""
        self.modulus, self.friction = modulus, friction
        self.x, lengths = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
        self.gap = np.asarray(height(self.x))
        self.influence, self.squares = np.zeros((2, len(self.x), len(self.x)))
        for image in (self.x, -self.x):
            apart = self.x[:, None] - image
            for sign, s in ((1, apart + lengths / 2), (-1, apart - lengths / 2)):
                self.influence += 2 / (np.pi * modulus) * sign * (s * np.log(np.abs(s)) - s)
            self.squares += np.square(apart) * lengths
        self.shares = 2 * lengths  # of a traction in its resultant
        self._pressed: dict[tuple[float, ...], Array] = {}

    def answer(self, **flaws: float) -> Tractions:
        """p and q at the points and instants of the discrepancy."""
        key = Flaws(**flaws)
        if key not in self._known:
            pressure, shear = (
                np.array([np.interp(self._at, self.x, row) for row in field[self.wanted]]) for field in self.march(key, self.loads)
            )
            self._known[key] = pressure, shear
        return self._known[key]

    def march(self, flaws: Flaws, loads: Array) -> Tractions:
        """p and q at the end of every increment, (k, n) each; `loads` (k, 2) are P and Q there, from the unloaded state.

        Each increment is one implicit step, as finite-element codes take it: the law holds at its end. NotSettledError where an
        increment has no solution or its active sets do not converge.
        """
        influence = self.influence + flaws.shear_bend * self.squares - flaws.shear_layer * np.eye(len(self.x))
        p = q = np.zeros(len(self.x))
        pressures, shears = [], []
        unit = SAME_LOAD * float(np.abs(loads).max())
        for normal, tangential in unit * np.round(loads / unit):
            p = self._pressure(flaws, float(normal), p > 0)
            q = self._shear(influence, q, self.friction * p, float(tangential))
            pressures.append(p)
            shears.append(q)
        return np.array(pressures), np.array(shears)

    def _bordered(self, influence: Array, free: Flags, known: Array, total: float) -> Array:
        """t on the free elements with K t + constant = -known there and shares t = total; the constant last."""
        matrix = np.zeros((len(known) + 1, len(known) + 1))
        matrix[:-1, :-1] = influence[np.ix_(free, free)]
        matrix[:-1, -1] = scale = np.abs(influence).max()
        matrix[-1, :-1] = self.shares[free]
        solution = np.linalg.solve(matrix, np.append(-known, total))
        solution[-1] *= scale
        return solution

    def _pressure(self, flaws: Flaws, load: float, start: Flags) -> Array:
        """No tension, no penetration; kept for each load, as p has no memory. `start`: elements that touched last, if any did."""
        key = (flaws.normal_bend, flaws.normal_layer, flaws.steepness, load)
        if key in self._pressed:
            return self._pressed[key]
        influence = self.influence + flaws.normal_bend * self.squares - flaws.normal_layer * np.eye(len(self.x))
        gap = flaws.steepness * self.gap
        pressure, touching = np.zeros(len(self.x)), start if start.any() else np.ones(len(self.x), dtype=bool)
        for _ in range(_MOST if load > 0 else 0):
            solution = self._bordered(influence, touching, -gap[touching], load)
            pressure = np.zeros(len(self.x))
            pressure[touching] = solution[:-1]
            opening = gap - influence @ pressure - solution[-1]
            new = np.where(touching, pressure > -_TINY * np.abs(pressure).max(), opening < -_TINY * np.ptp(gap))
            if np.array_equal(new, touching):
                break
            touching = new
        else:
            if load > 0:
                raise NotSettledError("normal contact")
        self._pressed[key] = np.maximum(pressure, 0.0)
        return self._pressed[key]

    def _shear(self, influence: Array, before: Array, limit: Array, load: float) -> Array:
        """q at the end of an increment: sticking elements do not move, slipping ones are at the limit, against the slip."""
        touching, slipping = limit > 0, np.zeros(len(limit))
        for _ in range(_MOST):
            stick = touching & (slipping == 0)
            traction = slipping * limit
            if not stick.any():
                if touching.any():
                    raise NotSettledError("the whole contact slides")
                return traction
            off = influence[stick] @ (traction - before)
            solution = self._bordered(influence, stick, off, load - float(self.shares @ traction))
            traction[stick] = solution[:-1]
            slip = influence @ (traction - before) + solution[-1]
            over = stick & (np.abs(traction) > limit * (1 + _TINY))
            back = (slipping != 0) & (slip * slipping < -_TINY * np.abs(slip).max())
            if not (over | back).any():
                return traction
            slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
        raise NotSettledError("friction")


def _times(what: Discrepancy, increments: int) -> tuple[Array, Array]:
    """Times to step through, and of the discrepancy's instants alone.

    So many increments a cycle for two revolutions, turns of the path and the instants included.
    """
    path = what.scene.load.path()
    if path.period is None:
        last = what.comparison.found.time[-1]
        turns = [leg.end for leg in path.initial_loading if leg.end <= last]
        return np.concatenate([np.linspace(path.start, last, 2 * increments + 1), what.time, turns]), what.time
    begin, period = path.cycle_start, path.period
    wanted = begin + (1 + what.fraction) * period
    more = np.linspace(begin, begin + 2 * period, 2 * increments + 1)
    turns = [leg.end for leg in path.legs(2)]
    return np.concatenate([np.linspace(path.start, begin, max(9, increments // 4)), more, wanted, turns]), wanted


def model_faults(what: Discrepancy, stiffness: Hypothesis | None, untried: set[str]) -> Iterator[Hypothesis]:
    """Every fault of the model that the discrepancy may have; `stiffness`: the E*/R that fits best.

    `untried` gets those faults whose model does not settle.
    """
    model = Model(what, INCREMENTS)
    compliant, bent = model.half_width / model.modulus, 1 / (model.half_width**2 * model.modulus)
    exact, base = what.expected, dict[str, float]()
    if stiffness is not None:
        exact, base = stiffness.predicted, {"steepness": stiffness.figures["factor"]}

    def added(model: Model, exact: Tractions, base: dict[str, float], **flaws: float) -> Tractions | None:
        """Theory, and what the flaws add to the model without them."""
        try:
            (p, q), (p0, q0) = model.answer(**flaws), model.answer(**base)
        except NotSettledError:
            return None
        return exact[0] + p - p0, exact[1] + q - q0

    if added(model, exact, base) is None:
        untried |= {"soft_normal", "small_body", "elastic_slip"}
        return
    fit = fitted(what, lambda s: added(model, exact, base, normal_layer=np.exp(s) * compliant), LAYERS, close=CLOSE)
    if fit:
        yield Hypothesis("soft_normal", fit[1], {"stiffness": float(np.exp(-fit[0]))})
    bend = fitted(what.of_pressure, lambda b: added(model, exact, base, normal_bend=b * bent), BENDS, close=CLOSE)
    if bend and bend[0]:
        known = {"normal_bend": bend[0] * bent}
        shear = tuple(sorted(bend[0] * ratio for ratio in (1 / ALIKE, 0.5, 1.0, 2.0, ALIKE)))
        fit = fitted(what, lambda b: added(model, exact, base, shear_bend=b * bent, **known), shear, close=CLOSE)
        if fit and 1 / ALIKE < fit[0] / bend[0] < ALIKE:
            yield Hypothesis("small_body", fit[1], {"normal": 2 * bend[0], "shear": 2 * fit[0]})
    if not what.scene.friction.coefficient or not np.any(what.expected[1]):
        return

    def creeping(model: Model) -> Callable[[float], Tractions | None]:
        return lambda s: added(model, what.expected, {}, shear_layer=np.exp(s) * compliant)

    fit = fitted(what, creeping(model), SHEAR_LAYERS, close=CLOSE)
    if fit and np.exp(fit[0]) * FINE < THIN:  # its effect stays within elements of the edges, where they are at each increment
        near = (fit[0] - 1, fit[0], fit[0] + 1)
        fit = fitted(what, creeping(Model(what, SMOOTH, FINEST)), near, rounds=2, close=10 * CLOSE)
    if fit is None:
        untried.add("elastic_slip")
    else:
        yield Hypothesis("elastic_slip", fit[1], {"stiffness": float(np.exp(-fit[0]))})
