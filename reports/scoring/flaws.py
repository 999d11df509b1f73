"""Faults of the model: soft penalties, bodies that end too near, pressure that draws the faces along, implicit steps too long.

Two half-planes on a grid of constant tractions take one flaw at a time. What it does is the difference between this model with it
and without, on one grid, so that the grid itself drops out to first order: it tells patterns apart, and its sizes are no figures.
What moves the edges of contact moves square roots, of which a grid knows little. So where a flaw does that, half-plane theory with
another E*/R or centre takes the part that such a change can take, exactly, and the grid adds the rest:

    predicted = theory(m) + model(flaw) - model(m)

# notation: h element lengths; p, q tractions (n,); g initial gap; delta approach; U shift; s slip, upper over lower; f friction
#           K_ij = 2/(pi E*) int ln|x_i - t| dt over element j: faces move by -K p into the bodies, s = U + K q where alike

    gap:   g - delta - (K_n - C_n) p - beta S q >= 0,  p >= 0
    slip:  s = U + (K_t - C_t) q - beta S p,  |q| <= f p,  q s' >= 0
    C = I/k, a layer: a penalty lets faces sink by p/k and creep by q/k
    K + b (x_i - x_j)^2 h_j, a body that ends: the far field of a resultant, to its lowest order that is no rigid motion
    S_ij = (1/E*) sgn(x_i - x_j) h_j, bodies that are not alike: pressure draws the faces along x, beta being Dundurs' constant
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.comparison.metrics import compliance
from reports.scoring.hypotheses import MOST_STEPS, Array, Discrepancy, Hypothesis, Tractions, fitted

Flags = NDArray[np.bool_]

# Half-length of the grid over the largest half-width of the reference: soft layers widen a contact.
ROOM = 1.35
# Elements over the largest half-width, where nothing travels and where edges do; for what an edge leaves within one step or one
# thin layer, FINEST. A layer thinner than THIN of the FINE elements is not seen by them.
COARSE, FINE, FINEST, THIN = 20, 80, 320, 2.0
# Increments of a cycle that the model takes for a smooth path; and beside steps that may be too long.
INCREMENTS, SMOOTH = 32, 256
# A body that ends sends back P and Q alike, both by the order of 1/L^2 of its size: neither bend is many times the other.
ALIKE = 4.0
# Sizes looked for: layers over a/E*, bends over 1/(E* a^2), beta. Beyond, nothing is left of the contact that was asked for.
LAYERS = (1e-3, 1e-2, 0.1, 1.0, 3.0)
SHEAR_LAYERS = (1e-3, 1e-2, 0.1, 1.0, 10.0, 30.0)
BENDS = (-0.4, -0.1, 0.0, 0.1, 0.4)
BETAS = (-0.4, -0.1, 0.0, 0.1, 0.4)
# Of the range of sizes: a fit as close as this is close enough to tell patterns apart.
CLOSE = 0.004
_MOST, _TINY = 60, 1e-10
# Pressure and shear of unlike bodies in turn, at most so often: each round leaves less than beta^2 of the error.
_COUPLED, _CONVERGED = 4, 1e-6
# Loads closer than this share of the largest are one load, solved once: those of one revolution and the next differ by rounding.
_SAME_LOAD = 1e-9


class NotSettledError(ArithmeticError):
    """The active sets of an increment do not converge, or the whole contact slides."""


@dataclass(frozen=True)
class Flaws:
    """What is wrong with a model."""

    normal_layer: float = 0.0  # 1/k [length/stress]
    shear_layer: float = 0.0
    normal_bend: float = 0.0  # b [1/(stress length)]
    shear_bend: float = 0.0
    coupling: float = 0.0  # Dundurs' beta
    steepness: float = 1.0  # factor of the gap, and so of E* in the tractions
    offset: float = 0.0  # of the gap along x [length]


class Model:
    """Two bodies in elements, the loads that they step through, and which increments are the instants of the discrepancy.

    `increments` a cycle, 0 for the result's own alone. The mirrored half has p and q even; it goes with like bodies only.
    """

    def __init__(self, what: Discrepancy, increments: int, *, mirrored: bool = True, fine: int = FINE) -> None:
        scene, cycle = what.scene, what.comparison.expected
        self.modulus, self.friction, self.height = 2 / compliance(scene.material), scene.friction.coefficient, scene.profile.height
        self.half_width = what.comparison.scales.half_width
        largest = float(np.nanmax(np.abs(cycle.contact_edges)))
        if mirrored:  # fine elements where the edges of contact and stick travel
            edges = np.concatenate([cycle.contact_edges.ravel(), cycle.stick_edges.ravel()])
            least = 0.8 * float(np.nanmin(np.abs(edges)))
            inner = np.linspace(0, least, max(2, int(np.ceil(least / largest * COARSE))))
            middle = np.linspace(least, 1.1 * largest, max(2, int(np.ceil((1.1 - least / largest) * fine))))
            ends = np.unique(np.concatenate([inner, middle, np.linspace(1.1 * largest, ROOM * largest, 7)]))
        else:
            ends = np.linspace(-ROOM * largest, ROOM * largest, int(2 * ROOM * COARSE) + 1)
        self._on_elements(ends, mirrored=mirrored)
        every, wanted = _times(what, increments)
        path = scene.load.path()
        span = every.max() - path.start
        times = np.unique(np.round((every[every > path.start] - path.start) / span, 9)) * span + path.start
        self.loads, self.wanted = np.transpose(path.at(times)), np.abs(times[:, None] - wanted).argmin(axis=0)
        self._at = np.abs(what.x) if mirrored else what.x
        self._known: dict[Flaws, Tractions] = {}

    def _on_elements(self, ends: Array, *, mirrored: bool) -> None:
        """Centres, and the matrices between elements, the mirror image, if any, added."""
        self.x, lengths = (ends[1:] + ends[:-1]) / 2, np.diff(ends)
        images = (self.x, -self.x) if mirrored else (self.x,)
        apart = [self.x[:, None] - image for image in images]
        log = [s * np.log(np.abs(s)) - s for d in apart for s in (d + lengths / 2, d - lengths / 2)]
        self.influence = 2 / (np.pi * self.modulus) * (sum(log[::2]) - sum(log[1::2]))
        self.squares = np.asarray(sum(np.square(d) for d in apart)) * lengths
        self.signs = np.asarray(sum(np.sign(d) for d in apart)) * lengths
        self.shares = lengths * len(images)  # of a traction in its resultant
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
        drawn = -flaws.coupling / self.modulus * self.signs
        p = q = np.zeros(len(self.x))
        pressures, shears = [], []
        unit = _SAME_LOAD * float(np.abs(loads).max())
        for normal, tangential in unit * np.round(loads / unit):
            old_p, old_q = p, q
            for turn in range(_COUPLED if flaws.coupling else 1):
                last = p
                p = self._pressure(flaws, float(normal), drawn @ q, p > 0)
                if turn and np.abs(p - last).max() <= _CONVERGED * np.abs(p).max():
                    break
                q = self._shear(influence, old_q, drawn @ (p - old_p), self.friction * p, float(tangential))
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

    def _pressure(self, flaws: Flaws, load: float, lifted: Array, start: Flags) -> Array:
        """No tension, no penetration, the gap `lifted` by the shear; `start`: elements that touched last, where any did.

        Kept for each load where nothing is lifted, since p then has no memory.
        """
        key = (flaws.normal_bend, flaws.normal_layer, flaws.steepness, flaws.offset, load)
        if not flaws.coupling and key in self._pressed:
            return self._pressed[key]
        influence = self.influence + flaws.normal_bend * self.squares - flaws.normal_layer * np.eye(len(self.x))
        gap = flaws.steepness * np.asarray(self.height(self.x - flaws.offset)) + lifted
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
        found = np.maximum(pressure, 0.0)
        if not flaws.coupling:
            self._pressed[key] = found
        return found

    def _shear(self, influence: Array, before: Array, drawn: Array, limit: Array, load: float) -> Array:
        """q at the end of an increment: sticking elements do not move, slipping ones are at the limit, against the slip."""
        touching, slipping = limit > 0, np.zeros(len(limit))
        for _ in range(_MOST):
            stick = touching & (slipping == 0)
            traction = slipping * limit
            if not stick.any():
                if touching.any():
                    raise NotSettledError("the whole contact slides")
                return traction
            off = influence[stick] @ (traction - before) + drawn[stick]
            solution = self._bordered(influence, stick, off, load - float(self.shares @ traction))
            traction[stick] = solution[:-1]
            slip = influence @ (traction - before) + drawn + solution[-1]
            over = stick & (np.abs(traction) > limit * (1 + _TINY))
            back = (slipping != 0) & (slip * slipping < -_TINY * np.abs(slip).max())
            if not (over | back).any():
                return traction
            slipping = np.where(over, np.sign(traction), np.where(back, 0.0, slipping))
        raise NotSettledError("friction")


def _times(what: Discrepancy, increments: int) -> tuple[Array, Array]:
    """Times to step through, and of the discrepancy's instants alone.

    So many increments a cycle for two revolutions, turns of the path and the instants included; without a number the result's own,
    from the initial loading where it has that, else its cycle twice.
    """
    path, own = what.scene.load.path(), what.comparison.found
    if not increments:
        whole = what.comparison.result.time
        if path.period is None or whole[0] <= path.cycle_start:
            return whole[whole <= own.time[-1]], what.time
        cycles = [path.cycle_start + (turn + own.fraction) * path.period for turn in (0, 1)]
        first = np.linspace(path.start, path.cycle_start, 9)
        return np.concatenate([first, *cycles]), path.cycle_start + (1 + what.fraction) * path.period
    if path.period is None:
        last = own.time[-1]
        turns = [leg.end for leg in path.initial_loading if leg.end <= last]
        return np.concatenate([np.linspace(path.start, last, 2 * increments + 1), what.time, turns]), what.time
    begin, period = path.cycle_start, path.period
    wanted = begin + (1 + what.fraction) * period
    more = np.linspace(begin, begin + 2 * period, 2 * increments + 1)
    turns = [leg.end for leg in path.legs(2)]
    return np.concatenate([np.linspace(path.start, begin, max(9, increments // 4)), more, wanted, turns]), wanted


def model_faults(
    what: Discrepancy, stiffness: Hypothesis | None, offset: Hypothesis | None, untried: set[str]
) -> Iterator[Hypothesis]:
    """Every fault of the model that the discrepancy may have; `stiffness` and `offset`: the E*/R and the centre that fit best.

    `untried` gets those faults whose model does not settle.
    """
    model = Model(what, INCREMENTS)
    compliant = model.half_width / model.modulus
    bent = 1 / (model.half_width**2 * model.modulus)
    base: dict[str, float] = {}
    exact = what.expected
    if stiffness is not None:
        base, exact = {"steepness": stiffness.figures["factor"]}, stiffness.predicted

    def added(model: Model, exact: Tractions, base: dict[str, float], **flaws: float) -> Tractions | None:
        """Theory, and what the flaws add to the model without them."""
        try:
            (p, q), (p0, q0) = model.answer(**flaws), model.answer(**base)
        except NotSettledError:
            return None
        return exact[0] + p - p0, exact[1] + q - q0

    try:
        model.answer()
        model.answer(**base)
    except NotSettledError:
        untried |= {"soft_normal", "small_body", "coupling", "elastic_slip", "steps"}
        return
    logs = tuple(np.log(LAYERS))
    fit = fitted(what, lambda s: added(model, exact, base, normal_layer=np.exp(s) * compliant), logs, close=CLOSE)
    if fit and what.explained(fit[1]) > 0:
        yield Hypothesis("soft_normal", fit[1], {"stiffness": float(np.exp(-fit[0]))})
    bend = fitted(what.of_pressure, lambda b: added(model, exact, base, normal_bend=b * bent), BENDS, close=CLOSE)
    if bend and bend[0]:
        known = {"normal_bend": bend[0] * bent}
        shear = tuple(sorted(bend[0] * ratio for ratio in (1 / ALIKE, 0.5, 1.0, 2.0, ALIKE)))
        fit = fitted(what, lambda b: added(model, exact, base, shear_bend=b * bent, **known), shear, close=CLOSE)
        if fit and what.explained(fit[1]) > 0 and 1 / ALIKE < fit[0] / bend[0] < ALIKE:
            yield Hypothesis("small_body", fit[1], {"normal": 2 * bend[0], "shear": 2 * fit[0]})
    if not what.scene.friction.coefficient:
        return
    if np.any(what.found[1]):  # odd parts, which the mirrored grid has not
        whole = Model(what, INCREMENTS, mirrored=False)
        base, exact = {}, what.expected
        if offset is not None:
            base, exact = {"offset": offset.figures["distance"] * model.half_width}, offset.predicted
        fit = fitted(what, lambda beta: added(whole, exact, base, coupling=beta), BETAS, close=CLOSE)
        if fit is None:
            untried.add("coupling")
        elif fit[0] and what.explained(fit[1]) > 0:
            yield Hypothesis("coupling", fit[1], {"beta": fit[0]})
    if not np.any(what.expected[1]):
        return
    layers = tuple(np.log(SHEAR_LAYERS))
    fit = fitted(what, lambda s: added(model, what.expected, {}, shear_layer=np.exp(s) * compliant), layers, close=CLOSE)
    if fit and np.exp(fit[0]) * FINE < THIN:  # its effect stays within elements of the edges: again on finer ones
        fine = Model(what, INCREMENTS, fine=FINEST)
        near = tuple(fit[0] + np.array([-1.0, 0.0, 1.0]))
        fit = fitted(
            what, lambda s: added(fine, what.expected, {}, shear_layer=np.exp(s) * compliant), near, rounds=2, close=10 * CLOSE
        )
        if fit is None:
            untried.add("elastic_slip")
    if fit and what.explained(fit[1]) > 0:
        yield Hypothesis("elastic_slip", fit[1], {"stiffness": float(np.exp(-fit[0]))})
    # One implicit increment from instant to instant of the result: all of P first, in effect, and Q at the last pressure.
    steps = len(what.comparison.found.time) - 1
    if what.scene.load.path().period is not None and steps <= MOST_STEPS:
        try:
            (p, q), (p0, q0) = (Model(what, increments, fine=FINEST).answer() for increments in (0, SMOOTH))
        except NotSettledError:
            untried.add("steps")
            return
        yield Hypothesis("steps", (what.expected[0] + p - p0, what.expected[1] + q - q0), {"steps": float(steps)})
