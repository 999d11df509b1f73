"""Random scenes of half-planes, whose every value theory knows, and how far the uncertainties that
finite elements state cover their true errors.

`python benchmarks/covered.py values` prints the table.

# notation: a half-width, f friction, A = 2/E*, P the largest normal load, n power of a profile
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution
from halfplane_fe.body_fields import edge_tension
from meshes import MeshSettings
from reports.comparison.measures import l2_norm
from scenes import ContactSolution, ConvergenceError, InputError, Scene, load_scene
from semi_analytic.profiles import contact_of

Array = NDArray[np.float64]

# W below this share of A f^2 P^2 hardly slips: rows of their own.
LITTLE_SLIP = 1e-4
# True errors below this share of a value are round-off: covered by any statement.
ROUND_OFF = 1e-9
# Instants at which the edge tension is compared; theory integrates at each.
_TENSIONS = 12
# Rows of a table on each side.
_ROWS = 41
# A table goes on straight beyond this distance [mm]: no contact reaches it.
_END_OF_TABLE = 1.6


# --------------------------------------------------------------------------------------- the scenes
def _hertz(_draw: np.random.Generator) -> dict[str, Any]:
    return {"kind": "hertz", "radius": 1000.0}


def _flat(draw: np.random.Generator) -> dict[str, Any]:
    flat_half_length = draw.uniform(0.1, 0.95)
    return {"kind": "flat_rounded", "radius": 1000.0, "flat_half_length": flat_half_length}


def _power(draw: np.random.Generator) -> dict[str, Any]:
    exponent = math.exp(draw.uniform(math.log(1.15), math.log(6.0)))
    return {"kind": "power_law", "exponent": exponent, "length": 1.0, "rise": 5e-4}


def _compound(draw: np.random.Generator) -> dict[str, Any]:
    return {
        "kind": "compound",
        "inner_radius": 1000.0,
        "outer_radius": math.exp(draw.uniform(math.log(300.0), math.log(3000.0))),
        "inner_half_length": draw.uniform(0.2, 0.95),
    }


def _wedge(draw: np.random.Generator) -> dict[str, Any]:
    tip_half_length = math.exp(draw.uniform(math.log(0.02), math.log(0.5)))
    return {"kind": "wedge", "tip_radius": 1000.0, "tip_half_length": tip_half_length}


def _table(draw: np.random.Generator) -> dict[str, Any]:
    """Rows of x^2 and x^4."""
    x = np.linspace(0.0, _END_OF_TABLE, _ROWS)
    share = draw.uniform(0.0, 1.0)
    height = 5e-4 * (x**2 + share * x**4)
    return {"kind": "tabulated", "points": np.column_stack([x, height]).tolist()}


_PROFILES: tuple[Callable[[np.random.Generator], dict[str, Any]], ...] = (
    _hertz,
    _flat,
    _power,
    _compound,
    _wedge,
    _table,
)


def ellipse_load(
    largest: float, friction: float, share: float, *, swing: float, phase: float, offset: float = 0
) -> dict[str, Any]:
    """P = P0 + P1 cos t and Q = Q0 + Q1 cos(t - phase) with a largest P and a largest |Q|/(f P).

    Parameters
    ----------
    share
        largest |Q|/(f P)
    swing
        P1/P0
    phase
        [degrees]
    offset
        Q0/(Q0 + Q1)
    """
    mean = largest / (1 + swing)
    angle = np.linspace(0, 2 * np.pi, 4001)
    wave = offset + (1 - offset) * np.cos(angle - np.radians(phase))
    limit = friction * mean * (1 + swing * np.cos(angle))
    amplitude = share / np.max(np.abs(wave) / limit)
    return {
        "kind": "ellipse",
        "mean_normal_load": mean,
        "normal_amplitude": mean * swing,
        "mean_tangential_load": amplitude * offset,
        "tangential_amplitude": amplitude * (1 - offset),
        "phase_degrees": phase,
        "initial_loading": "straight",
    }


def _ellipse(draw: np.random.Generator, largest: float, friction: float) -> dict[str, Any]:
    """An ellipse, Q about any mean."""
    swing = draw.uniform(0.0, 0.95)
    phase = draw.uniform(0.0, 180.0)
    offset = draw.random()
    share = share_of_sliding(draw)
    return ellipse_load(largest, friction, share, swing=swing, phase=phase, offset=offset)


def _polygon(draw: np.random.Generator, largest: float, friction: float) -> dict[str, Any]:
    """Three to six vertices, the largest P among them."""
    count = int(draw.integers(3, 7))
    normal = largest * draw.uniform(0.1, 1.0, count)
    normal[0] = largest
    shares = draw.uniform(-1.0, 1.0, count)
    shares *= share_of_sliding(draw) / np.abs(shares).max()
    vertices = np.column_stack([normal, friction * normal * shares]).tolist()
    return {"kind": "polygon", "initial_loading": vertices[:1], "cycle": vertices[1:]}


def share_of_sliding(draw: np.random.Generator) -> float:
    """Largest |Q|/(f P): 1 minus 1e-3 to 0.9."""
    return 1 - math.exp(draw.uniform(math.log(1e-3), math.log(0.9)))


def random_half_planes(draw: np.random.Generator, number: int) -> Scene:
    """Scene number `number`: profiles in turn, ellipses and polygons in turn, a = 1 mm at the
    largest load, f from 0.05 to 1.5.
    """
    material = load_scene("hertz-paper").material
    profile = _PROFILES[number % len(_PROFILES)](draw)
    friction = math.exp(draw.uniform(math.log(0.05), math.log(1.5)))
    unloaded = {
        "name": f"random-{number}",
        "material": material.model_dump(mode="json"),
        "profile": profile,
        "friction": {"coefficient": friction},
    }
    ellipse = load_scene("hertz-paper").load.model_dump(mode="json", exclude_none=True)
    shape = Scene.model_validate(unloaded | {"load": ellipse}).profile
    largest = float(contact_of(shape, material).load(1.0))
    loads = _polygon if number // len(_PROFILES) % 2 else _ellipse
    return Scene.model_validate(unloaded | {"load": loads(draw, largest, friction)})


# ------------------------------------------------------------------------------ errors of one scene
@dataclass(frozen=True)
class Errors:
    """True errors and stated uncertainties of one quantity of one answer, one or one an instant.

    Attributes
    ----------
    error, stated
        (k,), without sign; NaN of `stated` is "no estimate"
    unjudged
        number of further values, of which the reference is not exact enough
    """

    error: Array
    stated: Array
    unjudged: int = 0


def errors_of(answer: FiniteElementSolution) -> dict[str, Errors]:
    """Of every quantity, by its name in the table."""
    scene = answer.scene
    theory = semi_analytic.solve(scene, x=answer.x, time=answer.time)
    largest = semi_analytic.extremes(theory)
    uncertainties = answer.uncertainties
    slip = halfplane_fe.largest_slip(answer).value
    step = int(np.argmax(answer.contact_half_width))
    values: dict[str, tuple[Any, Any, Any]] = {
        "W": (answer.dissipation, theory.dissipation, answer.dissipation_uncertainty),
        "peak W(x)": (
            answer.dissipation_density.max(),
            largest.dissipation_density,
            uncertainties["largest_dissipation_density"],
        ),
        "peak pressure": (
            answer.pressure.max(),
            largest.pressure,
            uncertainties["largest_pressure"],
        ),
        "largest half-width": (
            answer.contact_half_width[step],
            largest.half_width,
            uncertainties["largest_half_width"],
        ),
        "contact edges, all instants": (
            answer.contact_edges[1:],
            theory.contact_edges[1:],
            answer.contact_edge_uncertainty[1:],
        ),
        "stick edges, all instants": (
            answer.stick_edges[1:],
            theory.stick_edges[1:],
            answer.stick_edge_uncertainty[1:],
        ),
        "permanent stick": (
            answer.permanent_stick_half_width,
            theory.permanent_stick_half_width,
            uncertainties["permanent_stick_half_width"],
        ),
        "largest slip": (slip, largest.slip, uncertainties["largest_slip"]),
        # One statement for the whole path: its largest error counts.
        "U, worst instant": (
            np.abs(answer.tangential_displacement - theory.tangential_displacement)[1:].max(),
            0.0,
            uncertainties["tangential_displacement"],
        ),
        "approach, worst instant": (
            np.abs(answer.normal_approach - theory.normal_approach)[1:].max(),
            0.0,
            uncertainties["normal_approach"],
        ),
    }
    values |= _norms(answer, theory)
    tension = halfplane_fe.largest_edge_tension(answer)
    if tension is not None:
        values["largest edge tension"] = (tension.value, largest.edge_tension, tension.uncertainty)
    loaded = np.flatnonzero(answer.normal_load > 0)[1:]
    steps = loaded[np.linspace(0, len(loaded) - 1, _TENSIONS).round().astype(int)]
    by_elements, stated = edge_tension(answer, steps.tolist())
    by_theory, _ = semi_analytic.edge_tension(theory, answer.time[steps])
    values["edge tension, all instants"] = (by_elements, by_theory, stated)
    return {name: _errors(*three) for name, three in values.items()}


def _norms(
    answer: FiniteElementSolution, theory: ContactSolution
) -> dict[str, tuple[float, float, float]]:
    """The largest L2 errors of p and q in the last cycle, as the statements are."""
    friction = answer.scene.friction.coefficient
    cycle = answer.last_cycle
    loaded = np.zeros(len(answer.time), dtype=bool)
    loaded[cycle] = answer.normal_load[cycle] > 0
    norm_of_p = l2_norm(answer.x, theory.pressure[loaded])
    names = {"p, L2": ("pressure", 1.0), "q, L2": ("shear", friction)}
    errors = {}
    for words, (name, unit) in names.items():
        difference = getattr(answer, name)[loaded] - getattr(theory, name)[loaded]
        largest = float(np.max(l2_norm(answer.x, difference) / (unit * norm_of_p)))
        errors[words] = (largest, 0.0, answer.uncertainties[name])
    return errors


def _errors(value: Any, true: Any, stated: Any) -> Errors:
    """Pairs of one quantity; instants without a value in either are left out, those without one in
    the answer alone have no estimate.
    """
    value_array, true_array, stated_array = np.broadcast_arrays(
        np.asarray(value, dtype=float), np.asarray(true, dtype=float), np.asarray(stated, float)
    )
    known = np.isfinite(true_array)
    error = np.abs(value_array - true_array)[known].ravel()
    without_value = ~np.isfinite(error)
    scale = np.abs(true_array[known]).max(initial=0.0)
    error = np.where(without_value | (error > ROUND_OFF * scale), error, 0.0)
    of_known = stated_array[known].ravel()
    return Errors(error, np.where(without_value, np.nan, of_known))


# ---------------------------------------------------------------------------------------- the table
@dataclass
class Coverage:
    """What the statements of one quantity did over scenes.

    Attributes
    ----------
    covered, unknown
        share of each scene's values that are covered, and that have no estimate
    generosity
        stated over true of each scene, its median instant
    shortfall
        true over stated of each scene, its worst instant
    worst_scene
        of the largest shortfall
    """

    covered: list[float] = field(default_factory=list)
    unknown: list[float] = field(default_factory=list)
    generosity: list[float] = field(default_factory=list)
    shortfall: list[float] = field(default_factory=list)
    worst_scene: str = "-"

    def add(self, scene: str, errors: Errors) -> None:
        """One scene more."""
        if not len(errors.error):
            return
        unknown = ~np.isfinite(errors.stated)
        self.covered.append(float(np.mean(~unknown & (errors.error <= errors.stated))))
        self.unknown.append(float(np.mean(unknown)))
        judged = ~unknown & (errors.error > 0)
        if not judged.any():
            return
        stated = np.maximum(errors.stated[judged], 1e-300)
        ratio = errors.error[judged] / stated
        self.generosity.append(float(np.median(1 / ratio)))
        worst = float(ratio.max())
        if worst > max(self.shortfall, default=0.0):
            self.worst_scene = scene
        self.shortfall.append(worst)

    def content(self) -> dict[str, Any]:
        """Percentages that are covered and without an estimate; stated over true, the median; true
        over stated, the worst, and in which scene. None where nothing could be judged.
        """
        is_judged = bool(self.shortfall)
        return {
            "covered": round(100 * float(np.mean(self.covered))),
            "unknown": round(100 * float(np.mean(self.unknown))),
            "generosity": _two_digits(np.median(self.generosity)) if is_judged else None,
            "shortfall": _two_digits(max(self.shortfall)) if is_judged else None,
            "worst_scene": self.worst_scene,
        }

    def row(self, name: str) -> str:
        """A row of the table."""
        content = self.content()
        generosity, shortfall = (
            "-" if content[key] is None else f"{content[key]:g}"
            for key in ("generosity", "shortfall")
        )
        return (
            f"| {name} | {content['covered']} % | {content['unknown']} %"
            f" | {generosity} | {shortfall} | {self.worst_scene} |"
        )


def _two_digits(value: Any) -> float:
    return float(f"{float(value):.2g}")


HEAD = (
    "| quantity | covered | no estimate | stated over true, median | true over stated, worst |"
    " in scene |",
    "|---|---|---|---|---|---|",
)


class Tables:
    """What random scenes show of every quantity: of those that slip, and of those that hardly do.

    Attributes
    ----------
    count, seed, preset
        of the scenes that were drawn, and of their meshes
    refused
        scenes that were refused, or did not converge
    unresolved
        in how many scenes a quantity judges nothing, the references differing too much
    """

    def __init__(self, count: int, seed: int, preset: str) -> None:
        self._groups: dict[str, dict[str, Coverage]] = {"slip": {}, "hardly slip": {}}
        self._scenes = {"slip": 0, "hardly slip": 0}
        self.count = count
        self.seed = seed
        self.preset = preset
        self.refused = 0
        self.unresolved = Counter[str]()

    def add(self, name: str, answer: FiniteElementSolution, errors: Mapping[str, Errors]) -> str:
        """Count a scene; returns its line, with the quantities that are not covered."""
        friction = answer.scene.friction.coefficient
        work_unit = 2 / answer.scales.modulus * (friction * answer.scales.load) ** 2
        group = "slip" if answer.dissipation >= LITTLE_SLIP * work_unit else "hardly slip"
        self._scenes[group] += 1
        for quantity, of_quantity in errors.items():
            self._groups[group].setdefault(quantity, Coverage()).add(name, of_quantity)
        return f"{name}: {'; '.join(_missed(errors)) or 'all covered'}"

    def lines(self) -> list[str]:
        """What was drawn, and both tables."""
        lines = [
            f"seed {self.seed}, {self.preset} preset, {self.count} scenes, {self.refused} refused"
            " or not converged"
        ]
        for group, quantities in self._groups.items():
            if quantities:
                lines += ["", f"{self._scenes[group]} scenes that {group}:", "", *HEAD]
                lines += [coverage.row(quantity) for quantity, coverage in quantities.items()]
        if self.unresolved:
            counts = [f"{quantity} in {number}" for quantity, number in self.unresolved.items()]
            lines += ["", f"Not judged, the references differing too much: {', '.join(counts)}."]
        return lines

    def content(self) -> dict[str, Any]:
        """The same as one value that JSON can hold."""
        groups = {
            group: {
                "scenes": self._scenes[group],
                "quantities": {name: of_one.content() for name, of_one in quantities.items()},
            }
            for group, quantities in self._groups.items()
        }
        return {
            "seed": self.seed,
            "preset": self.preset,
            "count": self.count,
            "refused": self.refused,
            "groups": groups,
            "unresolved": dict(self.unresolved),
        }


def judge(
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
        scene = random_half_planes(draw, number)
        name = f"{number} {_words(scene)}"
        try:
            answer = halfplane_fe.solve(scene, mesh)
        except (InputError, ConvergenceError) as reason:
            tables.refused += 1
            report(f"{name}: refused, {reason}")
            continue
        report(tables.add(name, answer, errors_of(answer)))
    return tables


def _words(scene: Scene) -> str:
    profile = scene.profile
    exponent = f" n = {profile.exponent:.3g}" if profile.kind == "power_law" else ""
    return f"{profile.kind}{exponent}, {scene.load.kind}"


def _missed(errors: Mapping[str, Errors]) -> Iterable[str]:
    """Quantities with a statement that is too small, and by which factor."""
    for name, of_quantity in errors.items():
        missed = of_quantity.error > of_quantity.stated
        if missed.any():
            ratio = of_quantity.error[missed] / np.maximum(of_quantity.stated[missed], 1e-300)
            yield f"{name} {ratio.max():.2g}"
