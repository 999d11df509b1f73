"""Random scenes of real bodies, and how far the uncertainties that finite elements state cover
their true errors.

No theory knows the answers; that of bulk stress and tilt is on grids, and less exact. The reference
is the same scene on a finer mesh. Its own error is that of the first order, by a second mesh of
twice its elements: those in which edges stand alike, and err alike, would judge nothing. A value
where that error is more than a fifth of what is stated judges nothing, and is counted, unless it is
less than a fifth of how far the value is from the reference: a statement that is too small must not
hide behind its size. Nor does a reference judge that states a larger uncertainty than the value it
is held against.

`python benchmarks/covered.py bodies` prints the table.

# notation: a half-width, f friction, h edge element, P normal load
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from random_scenes import Errors, Tables, ellipse_load, share_of_sliding

import halfplane_fe
from halfplane_fe import FiniteElementSolution, SolverSettings
from meshes import MeshSettings
from scenes import ConvergenceError, InputError, Scene, load_scene
from scenes.array_types import Array
from semi_analytic.profiles import contact_of

# Elements of the two references over those of the judged mesh, by its preset. Finer ones on the
# default mesh would take minutes a scene. Ones as large as the judged mesh's would err with it.
_FINER = {"default": (0.8, 0.4), "coarse": (0.5, 0.25)}
# Error of the finest over its difference from the second, of order 1: 1/(r - 1), r = 2.
_LEFT = 1.0
# Growth of the elements of the references, and error of their steps over that of the judged run.
_GROWTH_OF_REFERENCE = 0.1
_STEPS_OF_REFERENCE = 0.1
# Share of the stated uncertainty, or of the error, that the reference may be wrong by.
_LEAST_RESOLVED = 0.2
# Decimals of the time at which two instants are the same.
_DECIMALS = 9


# --------------------------------------------------------------------------------------- the scenes
def _block(draw: np.random.Generator) -> dict[str, Any]:
    """Of aspect ratio 0.7 to 4."""
    width = draw.uniform(8.0, 30.0)
    return {"kind": "block", "width": width, "height": width / draw.uniform(0.7, 4.0)}


class _Setup(NamedTuple):
    """Parts of a scene: bodies, by side; unlike materials; further loads."""

    bodies: Mapping[str, Any]
    is_unlike: bool = False
    loads: Mapping[str, Any] = {}
    radius: float = 1000.0


def _blocks(draw: np.random.Generator) -> _Setup:
    return _Setup({"lower": _block(draw), "upper": _block(draw)})


def _one_block(draw: np.random.Generator) -> _Setup:
    return _Setup({"lower": _block(draw)})


def _layers(draw: np.random.Generator) -> _Setup:
    """Two alike, h/a from 0.3."""
    height = math.exp(draw.uniform(math.log(0.3), math.log(4.0)))
    layer = {"kind": "block", "width": 16.0, "height": height}
    return _Setup({"lower": layer, "upper": layer})


def _pad(draw: np.random.Generator) -> _Setup:
    """No wider than its block."""
    width = draw.uniform(6.0, 16.0)
    height = draw.uniform(6.0, 16.0)
    block = _block(draw)
    pad = {"kind": "pad", "width": min(width, block["width"]), "height": height}
    return _Setup({"lower": block, "upper": pad}, radius=50.0)


def _cylinders(draw: np.random.Generator) -> _Setup:
    """Of radii whose relative radius is 10 mm."""
    lower = draw.uniform(15.0, 60.0)
    upper = 1 / (1 / 10.0 - 1 / lower)
    bodies = {
        "lower": {"kind": "cylinder", "radius": lower},
        "upper": {"kind": "cylinder", "radius": upper},
    }
    return _Setup(bodies, radius=10.0)


def _unlike(draw: np.random.Generator) -> _Setup:
    return _Setup({"lower": _block(draw), "upper": _block(draw)}, is_unlike=True)


def _bulk(draw: np.random.Generator) -> _Setup:
    """A wave of bulk stress in the lower body [MPa]."""
    wave = {"mean": 0.0, "amplitude": draw.uniform(5.0, 30.0), "phase_degrees": 90.0}
    return _Setup({}, loads={"bulk_stress_lower": wave})


def _tilt(draw: np.random.Generator) -> _Setup:
    return _Setup({}, loads={"tilt": draw.uniform(2e-5, 2e-4)})


KINDS: tuple[Callable[[np.random.Generator], _Setup], ...] = (
    _blocks,
    _one_block,
    _layers,
    _pad,
    _cylinders,
    _unlike,
    _bulk,
    _tilt,
)
"""In turn; a scene's number over their count tells the constant from the varying P."""


def random_bodies(draw: np.random.Generator, number: int) -> Scene:
    """Scene number `number`: a parabola with a = 1 mm between half-planes under the largest load, f
    from 0.05 to 1.5; Q to and fro or, every second time, an ellipse.
    """
    setup = KINDS[number % len(KINDS)](draw)
    paper = load_scene("hertz-paper")
    material: Any = paper.material.model_dump(mode="json")
    if setup.is_unlike:
        # Dundurs' beta is up to 0.2 where the softer of two bodies of nu = 0.3 has 0.18 E.
        stiffness = math.exp(draw.uniform(math.log(0.18), math.log(0.9)))
        steel = {"young_modulus": 210e3, "poisson_ratio": 0.3}
        softer = steel | {"young_modulus": 210e3 * stiffness}
        material = {"lower": steel, "upper": softer}
    friction = math.exp(draw.uniform(math.log(0.05), math.log(1.5)))
    arguments = {
        "name": f"random-bodies-{number}",
        "material": material,
        "profile": {"kind": "hertz", "radius": setup.radius},
        "friction": {"coefficient": friction},
        "load": paper.load.model_dump(mode="json", exclude_none=True),
        "bodies": setup.bodies,
    }
    unloaded = Scene.model_validate(arguments)
    largest = float(contact_of(unloaded.profile, unloaded.material).load(1.0))
    swing = 0.0 if number // len(KINDS) % 2 == 0 else draw.uniform(0.1, 0.8)
    phase = draw.uniform(30.0, 150.0)
    share = share_of_sliding(draw)
    load = ellipse_load(largest, friction, share, swing=swing, phase=phase) | setup.loads
    return Scene.model_validate(arguments | {"load": load})


# ------------------------------------------------------------------------------------------- values
class Value(NamedTuple):
    """A quantity of an answer, one or one an instant, with its stated uncertainty; NaN of `stated`
    is "no estimate".
    """

    value: Array
    stated: Array


def values_of(answer: FiniteElementSolution, times: Array) -> dict[str, Value]:
    """Every quantity that finite elements state an uncertainty of; series at `times`."""
    uncertainties = answer.uncertainties
    rows = np.searchsorted(np.round(answer.time, _DECIMALS), times)
    single = {
        "W": (answer.dissipation, answer.dissipation_uncertainty),
        "peak W(x)": (
            float(answer.dissipation_density.max()),
            uncertainties["largest_dissipation_density"],
        ),
        "peak pressure": (float(answer.pressure.max()), uncertainties["largest_pressure"]),
        "largest half-width": (
            float(answer.contact_half_width.max()),
            uncertainties["largest_half_width"],
        ),
        "permanent stick": (
            answer.permanent_stick_half_width,
            uncertainties["permanent_stick_half_width"],
        ),
        "largest slip": (
            halfplane_fe.largest_slip(answer).value,
            uncertainties["largest_slip"],
        ),
    }
    tension = halfplane_fe.largest_edge_tension(answer)
    # An answer without it counts as one without an estimate.
    single["largest edge tension"] = (
        (0.0, math.nan) if tension is None else (tension.value, tension.uncertainty)
    )
    values = {name: Value(*map(np.atleast_1d, pair)) for name, pair in single.items()}
    shift_stated = np.full(len(rows), uncertainties["tangential_displacement"])
    approach_stated = np.full(len(rows), uncertainties["normal_approach"])
    return values | {
        "contact edges, all instants": Value(
            answer.contact_edges[rows].ravel(), answer.contact_edge_uncertainty[rows].ravel()
        ),
        "stick edges, all instants": Value(
            answer.stick_edges[rows].ravel(), answer.stick_edge_uncertainty[rows].ravel()
        ),
        "U, all instants": Value(answer.tangential_displacement[rows], shift_stated),
        "approach, all instants": Value(answer.normal_approach[rows], approach_stated),
    }


def common_times(answers: list[FiniteElementSolution]) -> Array:
    """Instants that all have, after the first."""
    times = np.round(answers[0].time, _DECIMALS)
    for answer in answers[1:]:
        times = np.intersect1d(times, np.round(answer.time, _DECIMALS))
    return times[1:]


@dataclass
class Judged:
    """Errors of the values that the references resolve, and the names of those they do not."""

    errors: dict[str, Errors] = field(default_factory=dict)
    unresolved: list[str] = field(default_factory=list)


def errors_of_bodies(answer: FiniteElementSolution, preset: str) -> Judged:
    """Against two finer meshes than that of the preset."""
    mesh = MeshSettings.preset(preset)
    steps = SolverSettings()
    finer_steps = replace(steps, step_tolerance=_STEPS_OF_REFERENCE * steps.step_tolerance)
    references = []
    for share in _FINER[preset]:
        finer = replace(
            mesh,
            edge_element_size=share * mesh.edge_element_size,
            element_size=share * mesh.element_size,
            growth=_GROWTH_OF_REFERENCE,
        )
        references.append(halfplane_fe.solve(answer.scene, finer, finer_steps))
    return _judged(answer, *references)


class _Reference(NamedTuple):
    """A quantity on the finest mesh, one value or one an instant.

    Attributes
    ----------
    value
        taken for the true one
    error
        how far it may be from the true one
    stated
        uncertainty that the finest mesh itself states
    """

    value: Array
    error: Array
    stated: Array


def _references(
    second: FiniteElementSolution, finest: FiniteElementSolution, times: Array
) -> dict[str, _Reference]:
    """Every quantity on the finest mesh, with its error by the second finest; series at `times`."""
    of_second = values_of(second, times)
    references = {}
    for name, (value, stated) in values_of(finest, times).items():
        # _LEFT: error of the finest over the difference
        error = _LEFT * np.abs(value - of_second[name].value)
        references[name] = _Reference(value, error, stated)
    return references


def _judged(
    answer: FiniteElementSolution, second: FiniteElementSolution, finest: FiniteElementSolution
) -> Judged:
    """Errors against the finest mesh where its own is at most a fifth of what is stated, or of the
    error; a value without an estimate needs no reference.
    """
    times = common_times([answer, second, finest])
    judged = Judged()
    references = _references(second, finest, times)
    for name, (value, stated) in values_of(answer, times).items():
        reference = references[name]
        error = np.abs(value - reference.value)
        without_value = ~np.isfinite(value)
        stated_of_value = np.where(without_value, np.nan, stated)
        # _LEAST_RESOLVED: largest error of the reference over what is stated, or over the error
        is_resolved = reference.error <= _LEAST_RESOLVED * np.maximum(stated_of_value, error)
        is_resolved &= reference.stated <= stated_of_value
        is_known = np.isfinite(reference.value) & (~np.isfinite(stated_of_value) | is_resolved)
        if is_known.any():
            error_of_known = np.where(without_value, 0.0, error)[is_known]
            judged.errors[name] = Errors(error_of_known, stated_of_value[is_known])
        elif np.isfinite(reference.value).any():
            judged.unresolved.append(name)
    return judged


# ---------------------------------------------------------------------------------------- the table
def judge_bodies(
    count: int, seed: int, preset: str, report: Callable[[str], None] = lambda _line: None
) -> Tables:
    """The tables of `count` random scenes: those that slip, those that hardly slip.

    Parameters
    ----------
    report
        called with a line for each scene, as it is done
    """
    draw = np.random.default_rng(seed)
    mesh = MeshSettings.preset(preset)
    tables = Tables(count, seed, preset)
    for number in range(count):
        scene = random_bodies(draw, number)
        name = f"{number} {KINDS[number % len(KINDS)].__name__.strip('_').replace('_', ' ')}"
        try:
            answer = halfplane_fe.solve(scene, mesh)
            judged = errors_of_bodies(answer, preset)
        except (InputError, ConvergenceError) as reason:
            tables.refused += 1
            report(f"{name}: refused, {reason}")
            continue
        tables.unresolved.update(judged.unresolved)
        report(tables.add(name, answer, judged.errors))
    return tables
