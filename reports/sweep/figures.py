"""What a sweep can keep of a point: metrics of the comparison, quantities of either engine, and their relative errors.

A name is a metric's key ("stick_edge"), or "fe.", "exact." or "error." before a quantity ("fe.peak_pressure"); "error." is that of
the finite elements over that of half-plane theory, less 1. Quantities are those of the last cycle. Where both engines run, theory
is evaluated on the points and instants of the finite elements, so that sampling is the same in both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from reports.comparison.metrics import METRICS
from reports.units import energy_unit, units
from scenes import ContactSolution, EllipseLoad, Scene


@dataclass(frozen=True)
class Quantity:
    """A figure of one solution: how it is taken, its words, and the fields of the half-plane engine that it needs."""

    value: Callable[[ContactSolution], float]
    words: str
    fields: tuple[str, ...] = ()
    edges: str = ""  # the field of a finite-element solution that says how far its edges may be from the true ones


@dataclass(frozen=True)
class Figures:
    """Values by name, None where there is none, with the reason in `notes`."""

    values: Mapping[str, float | None]
    notes: Mapping[str, str] = field(default_factory=dict)


def mean_load(solution: ContactSolution) -> float:
    """P0 of an ellipse, else the largest load of the last cycle [force / thickness]."""
    load = solution.scene.load
    if isinstance(load, EllipseLoad):
        return load.mean_normal_load
    return float(np.max(solution.normal_load[solution.last_cycle]))


def _at_mean_load(solution: ContactSolution, series: np.ndarray) -> float:
    """A figure of the instants, at the mean load: by line between the loads of the last cycle."""
    steps = solution.last_cycle
    order = np.argsort(solution.normal_load[steps], kind="stable")
    return float(np.interp(mean_load(solution), solution.normal_load[steps][order], series[steps][order]))


def _at_largest_shear(solution: ContactSolution) -> float:
    steps = solution.last_cycle
    step = steps[int(np.argmax(np.abs(solution.tangential_load[steps])))]
    return float(solution.stick_half_width[step])


QUANTITIES: dict[str, Quantity] = {
    "dissipation": Quantity(lambda s: s.dissipation, "dissipation of the last cycle [energy / thickness]", ("dissipation",)),
    "peak_dissipation": Quantity(
        lambda s: float(np.max(s.dissipation_density)), "largest pointwise dissipation [energy / area]", ("dissipation_density",)
    ),
    "peak_pressure": Quantity(lambda s: float(np.max(s.pressure[s.last_cycle])), "largest pressure [stress]", ("pressure",)),
    "p0": Quantity(
        lambda s: _at_mean_load(s, s.pressure.max(axis=1)),
        "peak pressure at the mean load, between instants by line [stress]",
        ("pressure",),
    ),
    "peak_shear": Quantity(lambda s: float(np.max(np.abs(s.shear[s.last_cycle]))), "largest |q| [stress]", ("shear",)),
    "contact_half_width": Quantity(
        lambda s: _at_mean_load(s, s.contact_half_width), "contact half-width at the mean load, between instants by line [length]"
    ),
    "largest_half_width": Quantity(
        lambda s: float(np.max(s.contact_half_width[s.last_cycle])), "largest contact half-width [length]"
    ),
    "stick_half_width": Quantity(_at_largest_shear, "stick half-width where |Q| is largest [length]"),
    "permanent_stick_half_width": Quantity(
        lambda s: s.permanent_stick_half_width, "half-width that sticks through the cycle [length]"
    ),
    "stroke": Quantity(
        lambda s: float(np.ptp(s.tangential_displacement[s.last_cycle])),
        "range of the tangential displacement [length]",
        ("tangential_displacement",),
    ),
    "loop_work": Quantity(lambda s: s.loop_work, "closed integral of Q dU [energy / thickness]", ("dissipation",)),
}
_CONTACT, _STICK = "contact_edge_uncertainty", "stick_edge_uncertainty"
for _name, _edges in (
    ("contact_half_width", _CONTACT),
    ("largest_half_width", _CONTACT),
    ("stick_half_width", _STICK),
    ("permanent_stick_half_width", _STICK),
):
    QUANTITIES[_name] = replace(QUANTITIES[_name], edges=_edges)
PREFIXES = ("fe", "exact", "error")


def is_metric(name: str) -> bool:
    """Whether a figure needs the whole comparison."""
    return name in METRICS


def is_error(name: str) -> bool:
    """Whether a figure says how far the engines are apart: it is 0 where they agree."""
    return is_metric(name) or parts(name)[0] == "error"


def parts(name: str) -> tuple[str, str]:
    """("error", "dissipation") of "error.dissipation"."""
    prefix, _, quantity = name.partition(".")
    return prefix, quantity


def unit_of(name: str) -> str:
    """What a figure is, with its unit or what it is a share of.

    >>> unit_of("error.dissipation"), unit_of("stick_edge")
    ('dissipation of the last cycle: finite elements over half-plane theory, less 1', 'Stick edge: of a_ref')
    """
    if is_metric(name):
        return f"{METRICS[name].label}: {METRICS[name].unit}"
    prefix, quantity = parts(name)
    words = QUANTITIES[quantity].words
    return f"{words.rpartition(' [')[0]}: finite elements over half-plane theory, less 1" if prefix == "error" else words


def axis_label(name: str, scene: Scene) -> str:
    """A figure on the axis of a drawing, with its unit in the scene's, or what it is a share of.

    >>> from scenes import load_scene
    >>> [axis_label(name, load_scene("hertz-paper")) for name in ("fe.p0", "exact.dissipation", "error.p0", "stick_edge")]
    ['fe.p0  [MPa]', 'exact.dissipation  [N·mm/mm]', "error.p0  [share of theory's]", 'stick_edge  [share of a_ref]']
    """
    if is_metric(name):
        return f"{name}  [share {METRICS[name].unit}]"
    prefix, quantity = parts(name)
    if prefix == "error":
        return f"{name}  [share of theory's]"
    _, length, stress = units(scene)
    own = {"stress": stress, "length": length, "energy / thickness": energy_unit(scene), "energy / area": f"{energy_unit(scene)}²"}
    return f"{name}  [{own[QUANTITIES[quantity].words.rpartition(' [')[2].removesuffix(']')]}]"


def check_figures(figures: Sequence[str], engines: Sequence[str], uncertainty: str) -> None:
    """ValueError for a name that is none, is there twice, or needs what isn't run."""
    for name in figures:
        prefix, quantity = parts(name)
        if not is_metric(name) and (prefix not in PREFIXES or quantity not in QUANTITIES):
            raise ValueError(
                f"figures: {name!r} is none: it is the key of a metric (docs/metrics.md), or fe., exact. or error. before one of "
                f"{', '.join(QUANTITIES)}"
            )
        needed = {"fe", "exact"} if is_error(name) else {prefix}
        if missing := needed - set(engines):
            raise ValueError(f"figures: {name!r} needs engines = [..., {sorted(missing)[0]!r}]")
        if uncertainty == "budget" and not is_metric(name):
            raise ValueError(f"figures: {name!r} is no metric, and an error budget is of metrics; take uncertainty = 'cheap'")
    if len(set(figures)) < len(figures):
        raise ValueError("figures: one stands there twice")
    if uncertainty != "none" and "fe" not in engines:
        raise ValueError("uncertainty: half-plane theory is exact to rounding; with it alone take uncertainty = 'none'")
    if uncertainty == "budget" and "exact" not in engines:
        raise ValueError("uncertainty: an error budget needs both engines")


def fields_needed(figures: Sequence[str]) -> tuple[str, ...]:
    """The fields of the half-plane engine that the quantities among `figures` need."""
    wanted = {name for figure in figures if not is_metric(figure) for name in QUANTITIES[parts(figure)[1]].fields}
    return tuple(sorted(wanted))


def take(figures: Sequence[str], fe: ContactSolution | None, exact: ContactSolution | None) -> Figures:
    """The quantities among `figures`; metrics are left to the comparison."""
    values: dict[str, float | None] = {}
    notes: dict[str, str] = {}
    for name in figures:
        if is_metric(name):
            continue
        prefix, quantity = parts(name)
        found = {k: QUANTITIES[quantity].value(s) for k, s in (("fe", fe), ("exact", exact)) if s is not None}
        values[name], why = _figure(prefix, found)
        if why:
            notes[name] = why
    return Figures(values, notes)


def own_doubts(figures: Sequence[str], fe: ContactSolution, exact: ContactSolution | None) -> dict[str, float]:
    """What the finite elements themselves say of half-widths: the larger of both edges' uncertainties, the median over the last
    cycle; of an error, over the half-width of theory.
    """
    found: dict[str, float] = {}
    for name in figures:
        prefix, quantity = ("", "") if is_metric(name) else parts(name)
        field_name = QUANTITIES[quantity].edges if quantity and prefix != "exact" else ""
        if not field_name:
            continue
        stated = np.asarray(getattr(fe, field_name))[fe.last_cycle]
        scale = QUANTITIES[quantity].value(exact) if prefix == "error" and exact is not None else 1.0
        known = stated.max(axis=1)[np.isfinite(stated).all(axis=1)]
        doubt = float(np.median(known)) / scale if len(known) and scale else math.nan
        if math.isfinite(doubt):
            found[name] = doubt
    return found


def _figure(prefix: str, found: Mapping[str, float]) -> tuple[float | None, str]:
    if prefix != "error":
        value = found[prefix]
        return (value, "") if math.isfinite(value) else (None, f"there is none in {_WORDS[prefix]}")
    fe, exact = found["fe"], found["exact"]
    for engine, value in (("fe", fe), ("exact", exact)):
        if not math.isfinite(value):
            return None, f"there is none in {_WORDS[engine]}"
    return (fe / exact - 1, "") if exact else (None, "it is 0 in half-plane theory, so nothing is relative to it")


_WORDS = {"fe": "the finite elements", "exact": "half-plane theory"}
