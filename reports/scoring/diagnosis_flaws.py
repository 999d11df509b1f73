"""Faults of the model: soft penalties, bodies that end too near, pressure that draws the faces along, increments too long.

What moves the edges of contact moves square roots, of which a grid knows little. So where a fault does that, half-plane theory with
another E*/R or centre (that fits the result best) takes the part that such a change can take, exactly, and the grid adds the rest:

    predicted = theory(m) + model(flaws) - model(m)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from reports.comparison.metrics import compliance
from reports.scoring.diagnosis_discrepancy import Array, Discrepancy, Tractions
from reports.scoring.diagnosis_hypothesis import Hypothesis
from reports.scoring.diagnosis_model import Flaws, Grid, NotSettledError, grid, march

# The faults that are looked for here.
FLAWS = {"soft_normal", "small_body", "coupling", "elastic_slip", "steps"}
# Half-length of the grid over the largest half-width of the reference: soft layers widen a contact.
ROOM = 1.35
# Increments of a cycle that the model takes for a smooth path.
INCREMENTS = 32
# Longest cycle, in steps, whose steps may be too long; and increments of a path that is smooth beside any of those.
MOST_STEPS, SMOOTH = 64, 256
# Largest layers and bends looked for, over a/E* and 1/(E* a^2): beyond, nothing is left of the contact that was asked for.
LARGEST = {"normal_layer": 3.0, "shear_layer": 30.0, "normal_bend": 1.0, "shear_bend": 1.0, "coupling": 1.0}
START = {"normal_layer": 0.02, "shear_layer": 0.05, "normal_bend": 0.01, "shear_bend": 0.01, "coupling": 0.05}
# A body that ends sends back P and Q alike, both by the order of 1/L^2 of its size: neither bend is many times the other.
ALIKE = 4.0
NEVER_NEGATIVE = ("normal_layer", "shear_layer")
# Elements over the largest half-width, where nothing travels and where edges do; there, for what an edge leaves within one step or
# one thin layer, FINEST.
COARSE, FINE, FINEST = 20, 80, 320
# A layer thinner than so many of the FINE elements is not seen by them.
THIN = 2.0
_FITS, _FITS_AGAIN = 6, 2


@dataclass(frozen=True, eq=False)
class Model:
    """The grid, the loads that it steps through, and which of the increments are the instants of the discrepancy."""

    grid: Grid
    loads: Array
    wanted: Array
    half_width: float
    known: dict[Flaws, Tractions] = field(default_factory=dict)

    def unit(self, name: str) -> float:
        """What a flaw is measured in."""
        if name == "coupling":
            return 1.0
        return (self.half_width if "layer" in name else self.half_width**-2) / self.grid.modulus

    def answer(self, what: Discrepancy, flaws: Flaws) -> Tractions:
        """p and q at the points and instants of the discrepancy."""
        if flaws not in self.known:
            p, q = march(self.grid, flaws, self.loads)
            self.known[flaws] = _on_points(what.x, self.grid.x, p[self.wanted]), _on_points(what.x, self.grid.x, q[self.wanted])
        return self.known[flaws]


def _on_points(x: Array, centre: Array, values: Array) -> Array:
    at = np.abs(x) if centre[0] > 0 else x
    return np.array([np.interp(at, centre, row) for row in values])


@dataclass(frozen=True, eq=False)
class Start:
    """Tractions by half-plane theory and by the model for one question, the flaws' effect being what is added."""

    exact: Tractions
    model: Tractions


def flaw_faults(
    what: Discrepancy, stiffness: Hypothesis | None, offset: Hypothesis | None, untried: set[str]
) -> Iterator[Hypothesis]:
    """Every fault of the model that the discrepancy may have; `stiffness` and `offset`: the E*/R and the centre that fit best.

    `untried` gets those faults whose model does not settle.
    """
    model = model_of(what, INCREMENTS)
    try:
        start = Start(what.expected, model.answer(what, Flaws()))
        moved = start
        if stiffness is not None:
            moved = Start(stiffness.predicted, model.answer(what, Flaws(steepness=stiffness.figures["factor"])))
    except NotSettledError:
        untried |= FLAWS
        return
    if found := fit(what, model, moved, ("normal_layer",)):
        yield Hypothesis("soft_normal", found[1], {"stiffness": 1 / found[0]["normal_layer"]})
    if (found := fit(what, model, moved, ("normal_bend", "shear_bend"))) and _of_one_body(found[0]):
        yield Hypothesis("small_body", found[1], {"normal": 2 * found[0]["normal_bend"], "shear": 2 * found[0]["shear_bend"]})
    if not what.scene.friction.coefficient:
        return
    if np.any(what.found[1]):
        yield from _coupling(what, offset, untried)
    if np.any(what.expected[1]):
        yield from _elastic_slip(what, model, start, untried)
        yield from _implicit_steps(what, untried)


def _elastic_slip(what: Discrepancy, model: Model, start: Start, untried: set[str]) -> Iterator[Hypothesis]:
    """A layer in shear; a thin one, whose effect stays within elements of the edges, again on finer ones."""
    found = fit(what, model, start, ("shear_layer",))
    if found and found[0]["shear_layer"] * FINE < THIN:
        fine = model_of(what, INCREMENTS, fine=FINEST)
        try:
            found = fit(what, fine, Start(what.expected, fine.answer(what, Flaws())), ("shear_layer",), found[0], _FITS_AGAIN)
        except NotSettledError:
            untried.add("elastic_slip")
            return
    if found:
        yield Hypothesis("elastic_slip", found[1], {"stiffness": 1 / found[0]["shear_layer"]})


def _of_one_body(bends: dict[str, float]) -> bool:
    """Whether two bends are of one sign and of one order: a lone one is a wrong radius, or a soft layer."""
    quotient = bends["shear_bend"] / bends["normal_bend"]
    return 1 / ALIKE <= quotient <= ALIKE


def _coupling(what: Discrepancy, offset: Hypothesis | None, untried: set[str]) -> Iterator[Hypothesis]:
    """Pressure draws unlike faces along x, and shear lifts one side of the contact: odd parts, which the mirrored grid has not."""
    model = model_of(what, INCREMENTS, mirrored=False)
    try:
        start = Start(what.expected, model.answer(what, Flaws()))
        if offset is not None:
            start = Start(offset.predicted, model.answer(what, Flaws(offset=offset.figures["distance"] * model.half_width)))
        found = fit(what, model, start, ("coupling",))
    except NotSettledError:
        untried.add("coupling")
        return
    if found:
        yield Hypothesis("coupling", found[1], {"beta": found[0]["coupling"]})


def model_of(what: Discrepancy, increments: int, *, mirrored: bool = True, fine: int = FINE) -> Model:
    """The model of a discrepancy, stepping through its instants and so many more a cycle (0: through the result's own alone)."""
    scene = what.scene
    modulus = 2 / compliance(scene.material)
    on = grid(_ends(what, fine) if mirrored else _even_ends(what), scene.profile.height, scene.friction.coefficient, modulus)
    path = scene.load.path()
    every, wanted = _smooth_times(what, increments) if increments else _own_times(what)
    span = every.max() - path.start
    times = np.unique(np.round((every[every > path.start] - path.start) / span, 9)) * span + path.start
    places = np.abs(times[:, None] - wanted).argmin(axis=0)
    return Model(on, np.transpose(path.at(times)), places, what.comparison.scales.half_width)


def _smooth_times(what: Discrepancy, increments: int) -> tuple[Array, Array]:
    """Times of so many increments a cycle, turns of the path and the discrepancy's instants included; and of the latter alone."""
    path, last = what.scene.load.path(), what.comparison.found.time[-1]
    if path.period is None:
        turns = [leg.end for leg in path.initial_loading if leg.end <= last]
        return np.concatenate([np.linspace(path.start, last, 2 * increments + 1), what.time, turns]), what.time
    begin, period = path.cycle_start, path.period
    wanted = begin + (1 + what.fraction) * period
    more = np.linspace(begin, begin + 2 * period, 2 * increments + 1)
    turns = [leg.end for leg in path.legs(2)]
    return np.concatenate([np.linspace(path.start, begin, max(9, increments // 4)), more, wanted, turns]), wanted


def _own_times(what: Discrepancy) -> tuple[Array, Array]:
    """Times of the result's own increments, from initial loading where it has that, else of its cycle, twice; of the instants."""
    path, own = what.scene.load.path(), what.comparison.found
    whole = what.comparison.result.time
    if path.period is None or whole[0] <= path.cycle_start:
        return whole[whole <= own.time[-1]], what.time
    begin, period = path.cycle_start, path.period
    cycles = [begin + own.fraction * period, begin + (1 + own.fraction) * period]
    return np.concatenate([np.linspace(path.start, begin, 9), *cycles]), begin + (1 + what.fraction) * period


def _ends(what: Discrepancy, fine: int) -> Array:
    """Ends of elements from 0 outwards, `fine` to the largest half-width where the edges of contact and stick travel."""
    cycle = what.comparison.expected
    largest = float(np.nanmax(np.abs(cycle.contact_edges)))
    edges = np.concatenate([cycle.contact_edges.ravel(), cycle.stick_edges.ravel()])
    least = 0.8 * float(np.nanmin(np.abs(edges)))
    inner = np.linspace(0, least, max(2, int(np.ceil(least / largest * COARSE))))
    middle = np.linspace(least, 1.1 * largest, max(2, int(np.ceil((1.1 - least / largest) * fine))))
    outer = np.linspace(1.1 * largest, ROOM * largest, 7)
    return np.unique(np.concatenate([inner, middle, outer]))


def _even_ends(what: Discrepancy) -> Array:
    """Ends of equal elements over the whole contact and more."""
    reach = ROOM * float(np.nanmax(np.abs(what.comparison.expected.contact_edges)))
    return np.linspace(-reach, reach, int(2 * ROOM * COARSE) + 1)


def fit(
    what: Discrepancy, model: Model, start: Start, names: tuple[str, ...], first: dict[str, float] = START, most: int = _FITS
) -> tuple[dict[str, float], Tractions] | None:
    """The flaws of these names by least squares, and their prediction; None where they explain nothing or can't be solved.

    The effect of each flaw over its size is a mode; the modes of the sizes found last are fitted anew until the sizes stay.
    """
    sizes = {name: first[name] for name in names}
    best: tuple[dict[str, float], Tractions] | None = None
    least = what.apart(what.expected)
    for _ in range(most):
        predicted = _prediction(what, model, start, sizes)
        if predicted is None:
            return best
        if (left := what.apart(predicted)) < least:
            least, best = left, (sizes, predicted)
        new = _least_squares(what, model, start, sizes)
        if new is None or all(abs(new[name] / sizes[name] - 1) < 0.02 for name in names):
            break
        sizes = new
    return best


def _prediction(what: Discrepancy, model: Model, start: Start, sizes: dict[str, float]) -> Tractions | None:
    """Half-plane theory, and what the flaws add to the model that it is the answer of."""
    flaws = replace(Flaws(), **{name: size * model.unit(name) for name, size in sizes.items()})
    try:
        p, q = model.answer(what, flaws)
    except NotSettledError:
        return None
    return start.exact[0] + p - start.model[0], start.exact[1] + q - start.model[1]


def _least_squares(what: Discrepancy, model: Model, start: Start, sizes: dict[str, float]) -> dict[str, float] | None:
    """Sizes that fit the discrepancy best, each mode being the effect of its present size over that."""
    weight, scales = np.sqrt(what.weight), what.comparison.scales

    def vector(tractions: Tractions) -> Array:
        p, q = tractions[0] - what.expected[0], tractions[1] - what.expected[1]
        return np.concatenate([(weight * p / scales.pressure).ravel(), (weight * q / scales.shear).ravel()])

    modes = []
    for name, size in sizes.items():
        alone = _prediction(what, model, start, {name: size})
        if alone is None:
            return None
        modes.append(vector(alone) / size)
    found = np.linalg.lstsq(np.transpose(modes), vector(what.found), rcond=None)[0]
    new = {}
    for name, size in zip(sizes, found, strict=True):
        least = 1e-6 if name in NEVER_NEGATIVE else -LARGEST[name]
        new[name] = float(np.clip(size, least, LARGEST[name])) or 1e-9
    return None if all(abs(size) <= 1e-5 for size in new.values()) else new


def _implicit_steps(what: Discrepancy, untried: set[str]) -> Iterator[Hypothesis]:
    """One implicit increment from instant to instant of the result: all of P first, in effect, and Q at the last pressure."""
    steps = len(what.comparison.found.time) - 1
    if what.scene.load.path().period is None or steps > MOST_STEPS:
        return
    try:
        base = model_of(what, SMOOTH, fine=FINEST).answer(what, Flaws())
        p, q = model_of(what, 0, fine=FINEST).answer(what, Flaws())
    except NotSettledError:
        untried.add("steps")
        return
    yield Hypothesis("steps", (what.expected[0] + p - base[0], what.expected[1] + q - base[1]), {"steps": float(steps)})
