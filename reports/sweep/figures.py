"""What a sweep can keep of a point: metrics of the comparison, quantities of either engine, and their relative errors.

A name is a metric's key ("stick_edge"), or "fe.", "exact." or "error." before a quantity ("fe.peak_pressure"); "error." is that of
the finite elements over that of half-plane theory, minus 1. Quantities are those of the last cycle. Where both engines run, theory
is evaluated on the points and instants of the finite elements, so that sampling is the same in both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from reports.comparison.metrics import METRICS
from reports.units import energy_unit, units
from scenes import ContactSolution, EllipseLoad, Scene


@dataclass(frozen=True)
class Quantity:
    """A figure of one solution: how it is taken, its words, and the fields of the half-plane engine that it needs.

    `edges` names the field of a finite-element solution that states how far its edges may be from the true ones.
    """

    value: Callable[[ContactSolution], float]
    words: str
    fields: tuple[str, ...] = ()
    edges: str = ""


def _at_mean_load(solution: ContactSolution, series: np.ndarray) -> float:
    """A figure of the instants, at P0 of an ellipse, else at the largest load: linear between the loads of the last cycle."""
    steps, load = solution.last_cycle, solution.scene.load
    loads = solution.normal_load[steps]
    order = np.argsort(loads, kind="stable")
    wanted = load.mean_normal_load if isinstance(load, EllipseLoad) else float(np.max(loads))
    return float(np.interp(wanted, loads[order], series[steps][order]))


def _at_largest_shear(solution: ContactSolution) -> float:
    steps = solution.last_cycle
    return float(solution.stick_half_width[steps[int(np.argmax(np.abs(solution.tangential_load[steps])))]])


_CONTACT, _STICK = "contact_edge_uncertainty", "stick_edge_uncertainty"
QUANTITIES: dict[str, Quantity] = {
    "dissipation": Quantity(lambda s: s.dissipation, "dissipation of the last cycle [energy / thickness]", ("dissipation",)),
    "peak_dissipation": Quantity(
        lambda s: np.max(s.dissipation_density), "largest pointwise dissipation [energy / area]", ("dissipation_density",)
    ),
    "peak_pressure": Quantity(lambda s: np.max(s.pressure[s.last_cycle]), "largest pressure [stress]", ("pressure",)),
    "p0": Quantity(
        lambda s: _at_mean_load(s, s.pressure.max(axis=1)),
        "peak pressure at the mean load, linear between instants [stress]",
        ("pressure",),
    ),
    "peak_shear": Quantity(lambda s: np.max(np.abs(s.shear[s.last_cycle])), "largest |q| [stress]", ("shear",)),
    "contact_half_width": Quantity(
        lambda s: _at_mean_load(s, s.contact_half_width),
        "contact half-width at the mean load, linear between instants [length]",
        edges=_CONTACT,
    ),
    "largest_half_width": Quantity(
        lambda s: np.max(s.contact_half_width[s.last_cycle]), "largest contact half-width [length]", edges=_CONTACT
    ),
    "stick_half_width": Quantity(_at_largest_shear, "stick half-width where |Q| is largest [length]", edges=_STICK),
    "permanent_stick_half_width": Quantity(
        lambda s: s.permanent_stick_half_width, "half-width that sticks through the cycle [length]", edges=_STICK
    ),
    "permanent_stick_centre": Quantity(
        lambda s: float("nan") if s.permanent_stick_edges is None else float(np.mean(s.permanent_stick_edges)),
        "middle of what sticks through the cycle, with bulk stress or tilt [length]",
    ),
    "stroke": Quantity(
        lambda s: np.ptp(s.tangential_displacement[s.last_cycle]),
        "range of the tangential displacement [length]",
        ("tangential_displacement",),
    ),
    "loop_work": Quantity(
        lambda s: s.loop_work, "closed integral of Q dU, with its bulk term [energy / thickness]", ("dissipation",)
    ),
}
_ENGINES = {"fe": "the finite elements", "exact": "half-plane theory"}


def is_metric(name: str) -> bool:
    """Whether a figure needs the whole comparison."""
    return name in METRICS


def is_error(name: str) -> bool:
    """Whether a figure states how far the engines are apart: it is 0 where they agree."""
    return is_metric(name) or name.startswith("error.")


def unit_of(name: str) -> str:
    """What a figure is, with its unit or what it is a share of.

    >>> unit_of("error.dissipation"), unit_of("stick_edge")
    ('dissipation of the last cycle: finite elements over half-plane theory, minus 1', 'Stick edge: of a_ref')
    """
    if is_metric(name):
        return f"{METRICS[name].label}: {METRICS[name].unit}"
    prefix, _, quantity = name.partition(".")
    words = QUANTITIES[quantity].words
    return f"{words.rpartition(' [')[0]}: finite elements over half-plane theory, minus 1" if prefix == "error" else words


def axis_label(name: str, scene: Scene) -> str:
    """A figure on the axis of a drawing, with its unit in the scene's, or what it is a share of.

    >>> from scenes import load_scene
    >>> [axis_label(name, load_scene("hertz-paper")) for name in ("fe.p0", "exact.dissipation", "error.p0", "stick_edge")]
    ['fe.p0  [MPa]', 'exact.dissipation  [N·mm/mm]', "error.p0  [share of theory's]", 'stick_edge  [share of a_ref]']
    """
    if is_metric(name):
        return f"{name}  [share {METRICS[name].unit}]"
    prefix, _, quantity = name.partition(".")
    if prefix == "error":
        return f"{name}  [share of theory's]"
    _, length, stress = units(scene)
    own = {"stress": stress, "length": length, "energy / thickness": energy_unit(scene), "energy / area": f"{energy_unit(scene)}²"}
    return f"{name}  [{own[QUANTITIES[quantity].words.rpartition(' [')[2].removesuffix(']')]}]"


def check_figures(figures: Sequence[str], engines: Sequence[str], uncertainty: str) -> None:
    """ValueError for a name that is none, is there twice, or needs what isn't run."""
    for name in figures:
        prefix, _, quantity = name.partition(".")
        if not is_metric(name) and (prefix not in (*_ENGINES, "error") or quantity not in QUANTITIES):
            raise ValueError(
                f"figures: {name!r} is none: it is the key of a metric (docs/metrics.md), or fe., exact. or error. before one of "
                f"{', '.join(QUANTITIES)}"
            )
        if missing := ({*_ENGINES} if is_error(name) else {prefix}) - set(engines):
            raise ValueError(f"figures: {name!r} needs engines = [..., {min(missing)!r}]")
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
    return tuple(sorted({field for name in figures if not is_metric(name) for field in QUANTITIES[name.partition(".")[2]].fields}))


def take(name: str, fe: ContactSolution | None, exact: ContactSolution | None) -> tuple[float | None, str]:
    """A quantity of either engine or its error: the value, or None and why there is none."""
    prefix, _, quantity = name.partition(".")
    found = {}
    for engine, solution in (("fe", fe), ("exact", exact)):
        if solution is not None and prefix in (engine, "error"):
            found[engine] = float(QUANTITIES[quantity].value(solution))
            if not math.isfinite(found[engine]):
                return None, f"there is none in {_ENGINES[engine]}"
    if prefix != "error":
        return found[prefix], ""
    if not found["exact"]:
        return None, "it is 0 in half-plane theory, so nothing is relative to it"
    return found["fe"] / found["exact"] - 1, ""


def stated_by_edges(name: str, fe: ContactSolution, exact: ContactSolution | None) -> float:
    """What the finite elements themselves state for a half-width, 0 where they state nothing.

    The larger of both edges' uncertainties, the median over the last cycle; of an error, over the half-width of theory.
    """
    prefix, _, quantity = name.partition(".")
    if prefix == "exact" or not QUANTITIES[quantity].edges:
        return 0.0
    stated = np.asarray(getattr(fe, QUANTITIES[quantity].edges))[fe.last_cycle]
    known = stated.max(axis=1)[np.isfinite(stated).all(axis=1)]
    scale = QUANTITIES[quantity].value(exact) if prefix == "error" and exact is not None else 1.0
    found = float(np.median(known)) / scale if len(known) and scale else math.nan
    return found if math.isfinite(found) else 0.0
