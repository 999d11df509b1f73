"""Does half-plane theory state its own errors? Random scenes of each of its ways to a value, beside
references that share no code with it, or finer ones.

`python benchmarks/covered.py theory` prints the tables.

| way | reference |
|---|---|
| closed forms; tables and series, by quadratures | integrals in extended precision, 18 digits |
| callables, that are known by values alone | the same profile in closed form |
| grids, under bulk stress or tilt out of phase | the limit, by three times the cells and points |

Grids whose cells are wider than the slip zones have rows of their own: they hardly slip.

# notation: f friction, E* = 1, R = 1
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from random_scenes import HEAD, Coverage, Errors, ellipse_load, share_of_sliding

import semi_analytic
from scenes import (
    CallableProfile,
    ContactSolution,
    FlatRounded,
    Hertz,
    InputError,
    PowerLaw,
    Profile,
    Scene,
)
from semi_analytic import answer_on_grids
from semi_analytic.bulk_and_tilt import path_loads_and_contact
from semi_analytic.grid import (
    CELLS_ACROSS_CONTACT,
    INCREMENTS_PER_CYCLE,
    GridRequest,
    friction_ratio_on_grids,
)
from semi_analytic.memory import PROMISED_ERROR
from semi_analytic.profiles import contact_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from semi_analytic_oracle import Oracle, Work

Array = NDArray[np.float64]

# Finer grids: times as many cells and increments.
_CELLS = 3
_INCREMENTS = 2
# Difference of two answers times this is the error of the coarser one, by the order of convergence:
# 3/2 of W, the first of all else.
_BEYOND_FINER = _CELLS / (_CELLS - 1)
_BEYOND_FINER_OF_WORK = _CELLS**1.5 / (_CELLS**1.5 - 1)
# A reference whose own error is above this share of the statement judges nothing.
_GOOD_REFERENCE = 1 / 3
# Instants of the last cycle, and points, at which fields are compared.
_INSTANTS = 5
_POINTS = 9
_POINTS_ON_GRIDS = 181
# Shares of a contact from its edges at which a finer answer has points too, and places of the
# integral that is the edge tension.
_SHARES_FROM_EDGE = 10.0 ** np.arange(-5, -1.5, 0.2)
_PLACES_OF_TENSION = 4096
# Points nearer to an edge of contact or of stick than this share of a: "at the edge", where a last
# digit of the edge counts for more.
_NEAR = 0.01
# Shares of f P that slip, down to which the tiny ones are drawn: below, the references lose digits.
_LEAST_SHARE = 1e-6
# Last digits in extended precision by which W of a reference may be wrong, over the share of f P
# that Q reaches: 63 to 91 on a wedge of seed 231, for shares of 1.6e-6 to 4e-4.
_DIGITS_OF_REFERENCE = 100

# E* = 1: two bodies of E = 2 without a Poisson's ratio.
_BODY = {"young_modulus": 2.0, "poisson_ratio": 0.0}
_COUNTS = ("scenes", "refused", "not judged", "values not judged")
_FIELDS = ("pressure", "shear", "slip", "tangential_displacement", "dissipation")
_WORDS = {
    "pressure": "p",
    "shear": "q",
    "slip": "s",
    "tangential_displacement": "U",
    "dissipation": "W",
    "dissipation_density": "W(x)",
}


class Way(NamedTuple):
    """A way to a value, how its scenes are drawn, and how their errors are told.

    Attributes
    ----------
    name
        in the table
    draw
        a scene of it
    errors_of
        true and stated errors by the name of the quantity; None of what the reference is too coarse
        to judge
    """

    name: str
    draw: Callable[[np.random.Generator], Scene]
    errors_of: Callable[[Scene], dict[str, Errors | None]]


# --------------------------------------------------------------------------------------- the scenes
def _closed_form(draw: np.random.Generator) -> dict[str, Any]:
    kinds: list[dict[str, Any]] = [
        {"kind": "hertz", "radius": 1.0},
        {"kind": "flat_rounded", "radius": 1.0, "flat_half_length": draw.uniform(0.1, 0.95)},
        {"kind": "power_law", "exponent": draw.uniform(1.15, 6.0), "length": 1.0, "rise": 0.5},
        {
            "kind": "compound",
            "inner_radius": 1.0,
            "outer_radius": draw.uniform(0.3, 3.0),
            "inner_half_length": draw.uniform(0.2, 0.95),
        },
        {"kind": "wedge", "tip_radius": 1.0, "tip_half_length": draw.uniform(0.05, 0.5)},
    ]
    return kinds[int(draw.integers(len(kinds)))]


def _by_quadratures(draw: np.random.Generator) -> dict[str, Any]:
    """Rows of x^2 and x^4, or a series of them."""
    share = draw.uniform(0.0, 1.0)
    if draw.random() < 0.5:
        return {"kind": "polynomial", "length": 1.0, "rises": [0.5, 0.5 * share]}
    x = np.linspace(0.0, 1.6, int(draw.integers(8, 16)))
    height = 0.5 * (x**2 + share * x**4)
    return {"kind": "tabulated", "points": np.column_stack([x, height]).tolist()}


def _with_slope(draw: np.random.Generator) -> dict[str, Any]:
    """A closed form whose slope is one, too."""
    while True:
        profile = _closed_form(draw)
        if profile["kind"] in _SLOPES:
            return profile


def _hertz_slope(profile: Profile, x: Array) -> Array:
    assert isinstance(profile, Hertz)
    return x / profile.radius


def _flat_slope(profile: Profile, x: Array) -> Array:
    assert isinstance(profile, FlatRounded)
    beyond = np.maximum(np.abs(x) - profile.flat_half_length, 0.0)
    return np.sign(x) * beyond / profile.radius


def _power_slope(profile: Profile, x: Array) -> Array:
    assert isinstance(profile, PowerLaw)
    n = profile.exponent
    return n * profile.rise / profile.length * np.sign(x) * np.abs(x / profile.length) ** (n - 1)


_SLOPES: dict[str, Callable[[Profile, Array], Array]] = {
    "hertz": _hertz_slope,
    "flat_rounded": _flat_slope,
    "power_law": _power_slope,
}


def _waves(draw: np.random.Generator, largest: float, friction: float) -> dict[str, Any]:
    """An ellipse, half of them with very little slip."""
    swing = draw.uniform(0.0, 0.95)
    phase = draw.uniform(0.0, 180.0)
    share = share_of_sliding(draw)
    if draw.random() < 0.5:
        # Under a varying P even a small Q slips where P is unloaded: only at a constant P, or with
        # Q in proportion to P, does next to nothing slip.
        share = math.exp(draw.uniform(math.log(_LEAST_SHARE), 0.0)) * share
        swing = 0.0
    return ellipse_load(largest, friction, share, swing=swing, phase=phase)


def _scene(
    draw: np.random.Generator, profile: Mapping[str, Any], more: Mapping[str, Any] = {}
) -> Scene:
    """Of a profile, with a = 1 at the largest load, f from 0.05 to 1.5, and further loads."""
    friction = math.exp(draw.uniform(math.log(0.05), math.log(1.5)))
    content = {
        "name": "random theory",
        "material": {"lower": _BODY, "upper": _BODY},
        "profile": profile,
        "friction": {"coefficient": friction},
    }
    at_rest = _waves(np.random.default_rng(0), 1.0, friction)
    unloaded = Scene.model_validate(content | {"load": at_rest})
    largest = float(contact_of(unloaded.profile, unloaded.material).load(1.0))
    return Scene.model_validate(content | {"load": _waves(draw, largest, friction) | more})


def _scene_with_bulk_or_tilt(draw: np.random.Generator) -> Scene:
    """Bulk stress of a quarter to half the largest pressure, or a tilt that moves the contact by up
    to a tenth of its half-width; out of phase with Q.
    """
    wave = {"mean": 0.0, "phase_degrees": draw.uniform(0.0, 180.0)}
    # E* a/(2 R) = 0.5 is the largest pressure of a parabola.
    loads: dict[str, Any] = {"bulk_stress_lower": wave | {"amplitude": draw.uniform(0.05, 0.25)}}
    if draw.random() < 0.5:
        loads = {"tilt": wave | {"amplitude": draw.uniform(0.01, 0.1)}}
    return _scene(draw, {"kind": "hertz", "radius": 1.0}, loads)


def _slips_within_a_cell(scene: Scene) -> bool:
    """Whether the slip zones of a parabola under the tangential load alone, by Cattaneo and
    Mindlin at the mean P, are narrower than a cell of the grids: those hardly slip.
    """
    load = scene.load
    share = load.tangential_amplitude / (scene.friction.coefficient * load.mean_normal_load)
    return 1 - math.sqrt(max(1 - share, 0.0)) < 2 / CELLS_ACROSS_CONTACT


# ------------------------------------------------------------------------------ errors of one scene
def _errors(true_error: Any, stated: float) -> Errors:
    error = np.atleast_1d(np.asarray(true_error, dtype=float))
    return Errors(error, np.full(error.shape, stated))


def _stated(answer: ContactSolution, name: str) -> float:
    """What an answer states over the largest value: its error, or what all closed forms promise."""
    return answer.record.errors.get(name, 0.0) + PROMISED_ERROR


def _places(scene: Scene) -> tuple[Array, Array]:
    """Instants of the last cycle, and points of the contact."""
    path = scene.load.path()
    first = path.cycle_start + (scene.cycles - 1) * float(path.period or 0.0)
    time = first + float(path.period or 0.0) * (np.arange(_INSTANTS) + 0.37) / _INSTANTS
    return time, np.linspace(0.03, 0.98, _POINTS)


def _away_from_edges(answer: ContactSolution) -> NDArray[np.bool_]:
    """(n, k) points that are not at an edge of contact or stick."""
    edges = np.stack([answer.contact_half_width, np.nan_to_num(answer.stick_half_width)])
    distance = np.min(np.abs(np.abs(answer.x) - edges[:, :, None]), axis=0)
    return np.asarray(distance > _NEAR * answer.contact_half_width[:, None])


def _beside_fields(
    answer: ContactSolution, true_fields: Mapping[str, Array], true_work: float
) -> dict[str, Errors | None]:
    """True and stated errors of an answer, each over the largest value."""
    away = _away_from_edges(answer)
    friction = answer.scene.friction.coefficient
    largest = {name: float(np.max(np.abs(values))) for name, values in true_fields.items()}
    largest["shear"] = friction * largest["pressure"]
    errors: dict[str, Errors | None] = {}
    for name, values in true_fields.items():
        difference = np.abs(getattr(answer, name) - values)
        if name in ("pressure", "shear"):
            difference = difference[away]
        if largest[name] > 0:
            error = np.max(difference, initial=0.0) / largest[name]
            errors[_WORDS[name]] = _errors(error, _stated(answer, name))
    if true_work > 0:
        error = abs(float(answer.dissipation) / true_work - 1)
        errors["W"] = _errors(error, _stated(answer, "dissipation"))
    return errors


def beside_extended_precision(scene: Scene) -> dict[str, Errors | None]:
    """Beside the integrals of `tests/semi_analytic_oracle.py`."""
    time, x = _places(scene)
    answer = semi_analytic.solve(scene, x=x, time=time, fields=_FIELDS)
    oracle = Oracle(scene, time)
    rows = [oracle.at(instant, x) for instant in range(len(time))]
    names = ("pressure", "shear", "slip", "tangential_displacement")
    true_fields = {name: np.array([row[name] for row in rows], dtype=float) for name in names}
    true_work = float(Work(scene, scene.cycles - 1).whole().sum())
    errors = _beside_fields(answer, true_fields, true_work)
    if _error_of_reference(scene) > _GOOD_REFERENCE * _stated(answer, "dissipation"):
        errors["W"] = None
    return errors


def _error_of_reference(scene: Scene) -> float:
    """Relative error of W in extended precision by its last digits, where little slips."""
    load = scene.load
    share = load.tangential_amplitude / (scene.friction.coefficient * load.mean_normal_load)
    return float(_DIGITS_OF_REFERENCE * np.finfo(np.longdouble).eps / share)


def beside_closed_form(scene: Scene) -> dict[str, Errors | None]:
    """The slope of the profile as a function alone, beside the profile."""
    time, x = _places(scene)
    slope = functools.partial(_SLOPES[scene.profile.kind], scene.profile)
    by_slope = CallableProfile(slope_function=slope, extent=1.6)
    answer = semi_analytic.solve(scene.vary(profile=by_slope), x=x, time=time, fields=_FIELDS)
    true = semi_analytic.solve(scene, x=x, time=time, fields=_FIELDS)
    names = ("pressure", "shear", "slip")
    fields = {name: getattr(true, name) for name in names}
    return _beside_fields(answer, fields, float(true.dissipation))


def beside_finer_grids(scene: Scene) -> dict[str, Errors | None]:
    """Root mean squares over the points, over the largest value, as the statements are; the edge
    tension at instants of the last cycle, from the answer's own points and from points beside the
    edges. Errors are those beside the limit of fine grids, from both answers.

    The finer answer has three times the points, and points beside the edges.
    """
    x = np.linspace(-1.1, 1.1, _POINTS_ON_GRIDS)
    fields = (*_FIELDS, "dissipation_density")
    answer = semi_analytic.solve(scene, x=x, fields=fields)
    rows = answer.last_cycle[:: len(answer.last_cycle) // _INSTANTS]
    finer_x = _finer_points(x, answer.contact_edges[rows])
    finer = functools.partial(
        GridRequest,
        cells=_CELLS * CELLS_ACROSS_CONTACT,
        increments=_INCREMENTS * INCREMENTS_PER_CYCLE,
    )
    with mock.patch.object(answer_on_grids, "GridRequest", finer):
        finer_answer = semi_analytic.solve(scene, x=finer_x, time=answer.time, fields=fields)
    common_points = np.searchsorted(finer_x, x)
    errors: dict[str, Errors | None] = {}
    for name in ("shear", "slip", "dissipation", "dissipation_density"):
        values_of_finer = np.asarray(getattr(finer_answer, name))
        if values_of_finer.ndim:
            values_of_finer = values_of_finer[..., common_points]
        largest = float(np.max(np.abs(values_of_finer)))
        difference = np.asarray(getattr(answer, name)) - values_of_finer
        by_limit = _BEYOND_FINER_OF_WORK if name == "dissipation" else _BEYOND_FINER
        error = by_limit * float(np.sqrt(np.mean(difference**2))) / largest
        errors[_WORDS[name]] = _errors(error, _stated(answer, name))
    name = "permanent_stick_half_width"
    if name in answer.uncertainties:  # not of a steady cycle without grids
        value = getattr(answer, name)
        value_of_finer = getattr(finer_answer, name)
        # Without such a zone in both there is nothing to estimate; in the answer alone it has none.
        if math.isfinite(value) or math.isfinite(value_of_finer):
            error = _BEYOND_FINER * abs(value - value_of_finer)
            stated = answer.uncertainties[name] if math.isfinite(error) else math.nan
            errors["permanent stick"] = _errors(error, stated)
    reference = _tension_of_reference(finer_answer, rows)
    time = answer.time[rows]
    for words, source in (("edge tension", answer), ("edge tension, dense points", scene)):
        tension, stated_of_tension = semi_analytic.edge_tension(source, time)
        errors[words] = _errors_of_tension(tension, stated_of_tension, reference)
    return errors


def _finer_points(x: Array, edges: Array) -> Array:
    """Points (k,), and two between each of them and the next, and close to the edges (n, 2)."""
    between = np.interp(np.arange(_CELLS * (len(x) - 1) + 1) / _CELLS, np.arange(len(x)), x)
    between[::_CELLS] = x
    inwards = np.array([[1.0], [-1.0]])
    beside_edges = edges[:, :, None] + np.diff(edges)[:, :, None] * inwards * _SHARES_FROM_EDGE
    return np.unique(np.concatenate([between, beside_edges.ravel()]))


class Tensions(NamedTuple):
    """Stress along both faces at the edges of contact by finer grids, (n, 2, 2) as `edge_tension`
    has it: by all points, by half of them, and by grids of half as many cells.
    """

    values: Array
    by_half_of_points: Array
    by_half_of_cells: Array


def _tension_of_reference(finer_answer: ContactSolution, rows: NDArray[np.intp]) -> Tensions:
    """Edge tension of a finer answer at the instants of some rows, by an integral of its own."""
    scene = finer_answer.scene
    friction = scene.friction.coefficient
    path_loads, profile = path_loads_and_contact(scene)
    request = GridRequest(
        most_cycles=finer_answer.work.counts["cycles_solved"],
        cells=_CELLS * CELLS_ACROSS_CONTACT // 2,
        increments=_INCREMENTS * INCREMENTS_PER_CYCLE // 2,
    )
    x = finer_answer.x
    ratio_of_coarser = friction_ratio_on_grids(
        path_loads, profile, scene.profile.height, friction, x, finer_answer.time[rows], request
    ).friction_ratio
    bulk = [
        np.zeros(len(rows)) if stress is None else stress[rows]
        for stress in (finer_answer.bulk_stress_lower, finer_answer.bulk_stress_upper)
    ]
    tensions = np.zeros((3, len(rows), 2))
    for number, row in enumerate(rows.tolist()):
        edges = finer_answer.contact_edges[row]
        is_inside = (x > edges[0]) & (x < edges[1])
        ratio = finer_answer.shear[row, is_inside] / (
            friction * finer_answer.pressure[row, is_inside]
        )
        points = x[is_inside]
        tensions[:, number] = [
            friction * _tension_over_friction(points, ratio, edges),
            friction * _tension_over_friction(points[::2], ratio[::2], edges),
            friction * _tension_over_friction(points, ratio_of_coarser[number, is_inside], edges),
        ]
    # The upper body has the opposite shear.
    of_bodies = np.stack([tensions, -tensions], axis=2) + np.stack(bulk, axis=1)[..., None]
    return Tensions(*of_bodies)


def _tension_over_friction(x: Array, friction_ratio: Array, edges: Array) -> Array:
    """+-(2/pi) int q/|x - edge| dx at both edges of a parabola, over f. q/(f p) is given at points
    x and straight in between; p = sqrt(h^2 - (x - m)^2)/2 with E* = R = 1.
    """
    phi = np.pi * (np.arange(_PLACES_OF_TENSION) + 0.5) / _PLACES_OF_TENSION
    half_width = float(np.diff(edges)[0]) / 2
    places = float(np.mean(edges)) - half_width * np.cos(phi)
    shear = half_width * np.sin(phi) / 2 * np.interp(places, x, friction_ratio)
    return np.mean(2 * shear * np.stack([1 / np.tan(phi / 2), -np.tan(phi / 2)]), axis=1)


def _errors_of_tension(tension: Array, stated: Array, reference: Tensions) -> Errors:
    """True and stated errors of values in contact, (n, 2, 2).

    The limit of fine grids follows from the answer and the reference, and once more from the
    reference and grids of half its cells. By how much these two limits differ, and by what half of
    its points change it, the reference is wrong. Values for which that is more than a third of the
    true error and of the stated one are not judged.
    """
    limit = tension + _BEYOND_FINER * (reference.values - tension)
    other_limit = reference.values + (reference.values - reference.by_half_of_cells)
    error = np.abs(tension - limit)
    error_of_reference = np.abs(limit - other_limit)
    error_of_reference += np.abs(reference.by_half_of_points - reference.values)
    is_good = error_of_reference <= _GOOD_REFERENCE * np.maximum(
        error, np.nan_to_num(stated, nan=np.inf)
    )
    is_in_contact = stated != 0
    is_judged = is_in_contact & is_good
    return Errors(error[is_judged], stated[is_judged], int(np.sum(is_in_contact & ~is_good)))


WAYS = (
    Way(
        "closed forms",
        lambda draw: _scene(draw, _closed_form(draw)),
        beside_extended_precision,
    ),
    Way(
        "tables and series",
        lambda draw: _scene(draw, _by_quadratures(draw)),
        beside_extended_precision,
    ),
    Way(
        "callables",
        lambda draw: _scene(draw, _with_slope(draw)),
        beside_closed_form,
    ),
    Way("grids", _scene_with_bulk_or_tilt, beside_finer_grids),
)


# ---------------------------------------------------------------------------------------- the table
class TheoryTable:
    """What theory's statements did over random scenes, by way and quantity.

    Attributes
    ----------
    seed
        of the scenes
    counts
        scenes of each way, those refused, and quantities, or single values of them, that no
        reference could judge
    """

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.coverage: dict[tuple[str, str], Coverage] = {}
        self.counts: dict[str, dict[str, int]] = {}

    def add(self, way: str, scene: str, errors: Mapping[str, Errors | None]) -> str:
        """Count a scene; returns its line."""
        of_way = self.counts.setdefault(way, dict.fromkeys(_COUNTS, 0))
        of_way["scenes"] += 1
        missed = []
        for quantity, of_quantity in errors.items():
            if of_quantity is None:
                of_way["not judged"] += 1
                continue
            of_way["values not judged"] += of_quantity.unjudged
            self.coverage.setdefault((way, quantity), Coverage()).add(scene, of_quantity)
            ratio = float(np.max(of_quantity.error / of_quantity.stated, initial=0.0))
            if ratio > 1:
                missed.append(f"{quantity} {ratio:.2g}")
        return f"{way}, {scene}: {'; '.join(missed) or 'all covered'}"

    def refuse(self, way: str) -> None:
        """Count a scene that was refused."""
        self.counts.setdefault(way, dict.fromkeys(_COUNTS, 0))["refused"] += 1

    def lines(self) -> Iterable[str]:
        """The table."""
        yield f"seed {self.seed}"
        for way, counts in self.counts.items():
            words = ", ".join(f"{number} {word}" for word, number in counts.items())
            yield f"{way}: {words}"
        yield from ("", *HEAD)
        for (way, quantity), coverage in self.coverage.items():
            yield coverage.row(f"{way}: {quantity}")

    def content(self) -> dict[str, Any]:
        """The same as one value that JSON can hold."""
        return {
            "seed": self.seed,
            "counts": self.counts,
            "quantities": {
                f"{way}: {quantity}": coverage.content()
                for (way, quantity), coverage in self.coverage.items()
            },
        }


def judge_theory(
    count: int, seed: int, report: Callable[[str], None] = lambda _line: None
) -> TheoryTable:
    """`count` scenes of each way; a fifth as many on grids, whose references are dear."""
    table = TheoryTable(seed)
    for number_of_way, way in enumerate(WAYS):
        draw = np.random.default_rng([seed, number_of_way])
        n_scenes = max(count // 5, 1) if way.name == "grids" else count
        for number in range(n_scenes):
            scene = way.draw(draw)
            words = f"{number} {_profile_words(scene.profile)}"
            try:
                errors = way.errors_of(scene)
            except InputError as reason:
                table.refuse(way.name)
                report(f"{way.name}, {words}: refused, {reason}")
                continue
            way_name = way.name
            if way_name == "grids" and _slips_within_a_cell(scene):
                way_name = "grids, slip zones below a cell"
            report(table.add(way_name, words, errors))
    return table


def _profile_words(profile: Profile) -> str:
    exponent = f" n = {profile.exponent:.3g}" if profile.kind == "power_law" else ""
    return f"{profile.kind}{exponent}"
