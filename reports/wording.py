"""Numbers and verdicts in words: what the page, the terminal and comparison.json say alike."""

from __future__ import annotations

import math

from reports.body_words import are_half_planes, idealisation
from reports.comparison import Comparison
from reports.definitions import name_of
from reports.units import energy_unit, load_unit, minus, number, units
from reports.verdicts import Metric, Verdict
from scenes import EllipseLoad, FlatRounded, Hertz, PolygonLoad, Scene

CLAIM = "Code verification of each engine plus assessment of the half-plane idealisation; two codes agreeing is not validation."


def question(scene: Scene) -> str:
    """What is asked, in a sentence: bodies, material, friction, loads, with units."""
    _, length, stress = units(scene)
    match scene.profile:
        case Hertz(radius=radius):
            kind = "circular" if scene.bodies.faces_are_true else "parabolic"
            shape = f"a {kind} profile of relative radius {number(radius)} {length}"
        case FlatRounded(radius=radius, flat_half_length=half):
            shape = f"a flat face of half-length {number(half)} {length} with edges of radius {number(radius)} {length}"
        case _:
            shape = scene.profile.in_words(length)
    upper, lower = (
        f"E = {number(m.young_modulus)} {stress}, ν = {number(m.poisson_ratio)}"
        for m in (scene.material.upper, scene.material.lower)
    )
    material = f"both {upper}" if scene.material.alike else f"upper {upper}; lower {lower}"
    return (
        f"Two elastic bodies in plane strain ({material}) meet with {shape} and friction coefficient "
        f"{number(scene.friction.coefficient)}; {_loads(scene, load_unit(scene))}. "
        f"What do they transmit, where do they slip, and what does {'a cycle' if _repeats(scene) else 'the path'} dissipate?"
    )


def _repeats(scene: Scene) -> bool:
    load = scene.load
    return bool(load.cycle) if isinstance(load, PolygonLoad) else getattr(load, "repeats", True)


def _loads(scene: Scene, unit: str) -> str:
    load = scene.load
    if isinstance(load, EllipseLoad):
        return (
            f"the loads go round an ellipse, P = {number(load.mean_normal_load)} + "
            f"{number(load.normal_amplitude)} cos t and Q = {number(load.mean_tangential_load)} + "
            f"{number(load.tangential_amplitude)} cos(t − {number(load.phase_degrees)}°) {unit}"
        )
    if not isinstance(load, PolygonLoad):
        return load.in_words(unit)
    corners = (load.initial_loading[-1], *load.cycle) if load.cycle else ((0.0, 0.0), *load.initial_loading)
    points = ", ".join(f"({number(p)}, {number(q)})" for p, q in corners)
    return f"the loads (P, Q) go {'round' if load.cycle else 'along'} the straight lines through {points} {unit}"


# A share of the whole that double precision can't tell from none, summed over a cycle's instants; comparison.json has every digit.
_ROUNDING = 1e-13


def percent(value: float, *, signed: bool = True) -> str:
    """Three significant digits in per cent; rounding, below 1e-13 of the whole, is 0.

    >>> percent(-0.00123456), percent(0.5, signed=False), percent(-1.87e-16), percent(float("nan"))
    ('−0.123 %', '50 %', '0 %', 'not a number')
    """
    return _number(100 * _settled(value), signed) + (" %" if math.isfinite(value) else "")


def _settled(value: float) -> float:
    return 0.0 if abs(value) < _ROUNDING else value


def _number(value: float, signed: bool) -> str:
    if not math.isfinite(value):
        return "not a number" if math.isnan(value) else "infinite"
    sign = "" if value == 0 else "−" if value < 0 else "+" if signed else ""
    return sign + minus(f"{abs(value):.3g}")


def value_of(metric: Metric) -> str:
    """The value of a metric, in per cent unless it is absolute."""
    if metric.value is None:
        return "–"
    signed = metric.definition.signed
    return _number(_settled(metric.value), signed) if metric.absolute else percent(metric.value, signed=signed)


def unit_of(metric: Metric) -> str:
    """What the value is a share of; an edge's shift in elements, or in local spacings h of the points, beside it."""
    counts = (metric.elements, "elements"), (metric.spacings, "h")
    return metric.unit + "".join(f" ({_number(count, signed=True)} {of})" for count, of in counts if count is not None)


def uncertainty_of(metric: Metric) -> str:
    """How far the value is open, to two digits: by the error budget, the result or its points; empty where nothing is stated."""
    if metric.uncertainty is None:
        return ""
    size = metric.uncertainty * (1 if metric.absolute else 100)
    return f"± {minus(f'{size:.2g}' if size < 99.5 else f'{size:.0f}')}{'' if metric.absolute else ' %'}"


def open_value_of(metric: Metric) -> str:
    """The value with its uncertainty, where one is known."""
    return f"{value_of(metric)} {uncertainty_of(metric)}".strip()


def tolerance_of(metric: Metric) -> str:
    """The tolerance of a metric, or a dash."""
    if metric.tolerance is None:
        return "–"
    return f"{metric.tolerance:.3g}" if metric.absolute else f"{100 * metric.tolerance:.3g} %"


def accuracy_of(metric: Metric) -> str:
    """Within, outside, undecided, or a dash where nothing is judged."""
    return metric.verdict or "–"


def verdict(comparison: Comparison) -> str:
    """The answer in words: what is outside, what is undecided, or that all is within; and whether the laws of contact hold."""
    theirs, ours = name_of(comparison.reference.engine), name_of(comparison.result.engine)
    outside, undecided = (_listed(comparison, state) for state in (Verdict.OUTSIDE, Verdict.UNDECIDED))
    judged = sum(metric.tolerance is not None for metric in comparison.metrics)
    broken = [
        f"{check.label} in {name_of(engine)}"
        for engine, checks in (
            (comparison.reference.engine, comparison.reference_certificates),
            (comparison.result.engine, comparison.result_certificates),
        )
        for check in checks
        if not check.holds
    ]
    if outside or undecided:
        differ = f"{_first_large(ours)} and {theirs} differ by more than the scene's tolerance in {outside}"
        reaches = f"The uncertainty reaches across the tolerance in {undecided}; undecided counts as outside"
        first = ". ".join(words for words, metrics in ((differ, outside), (reaches, undecided)) if metrics)
    else:
        verb = "agree" if ours == "finite elements" else "agrees"
        first = f"{_first_large(ours)} {verb} with {theirs} within all {judged} tolerances of the scene"
        known = comparison.metric("dissipation").value is not None
        first += (
            f"; dissipation differs by {value_of(comparison.metric('dissipation'))}" if known else "; dissipation was not compared"
        )
    second = f" A law of contact is violated: {', '.join(broken)}." if broken else " Both answers are admissible."
    return f"{first}.{second}"


def _listed(comparison: Comparison, state: Verdict) -> str:
    """The metrics of that verdict with value, uncertainty and tolerance; empty where there are none."""
    return ", ".join(
        f"{_inside(metric.label)} ({open_value_of(metric)} {unit_of(metric)}, tolerance {tolerance_of(metric)})"
        for metric in comparison.metrics
        if metric.verdict is state
    )


def how_judged(comparison: Comparison) -> str:
    """What the verdicts rest on: sizes and uncertainties, or sizes alone where no uncertainty is known."""
    judged = [metric for metric in comparison.metrics if metric.tolerance is not None and metric.value is not None]
    unknown = [metric for metric in judged if metric.uncertainty is None]
    if not unknown:
        return "Within: |E| + u ≤ tolerance. Outside: |E| − u > tolerance. Undecided: neither, and it counts as outside."
    if comparison.budget is not None:
        names = ", ".join(_inside(metric.label) for metric in unknown)
        return f"No uncertainty is known for {names}: a term was not measured. There |E| alone is judged."
    asked = "requested for these values; `--budget` measures it" if _both_ours(comparison) else "stated for these values"
    return f"No uncertainty was {asked}. Each verdict is by |E| alone."


def uncertain_work(comparison: Comparison) -> str:
    """The result's dissipation with what it is uncertain by at least, in a sentence; empty where that was not looked for."""
    found = comparison.result
    if math.isnan(found.dissipation_uncertainty):
        return ""
    share = f" ({percent(found.dissipation_uncertainty / found.dissipation, signed=False)})" if found.dissipation else ""
    return (
        f"Dissipation of a cycle by {name_of(found.engine)}: {found.dissipation:.6g} {energy_unit(comparison.scene)} ± at least "
        f"{found.dissipation_uncertainty:.2g}{share}: so far it is from that of a coarse mesh."
    )


def lead(comparison: Comparison) -> str:
    """The verdict in a few words.

    A tolerance missed by answers that obey every law is a finding where theory is an idealisation: real bodies, or half-planes of
    unlike materials. Of somebody else's result it may be a fault as well.
    """
    if comparison.passed:
        return "Within tolerance."
    if comparison.admissible and comparison.verdict is Verdict.UNDECIDED:
        return "Undecided."
    if not comparison.admissible or not beyond_theory(comparison):
        return "Not within tolerance."
    if _both_ours(comparison):
        return "Outside tolerance: a finding about the idealisation."
    return "Outside tolerance: by the idealisation, by the result, or by both."


def standing(comparison: Comparison) -> Verdict:
    """The verdict as a colour: of a comparison in which a law of contact is violated, outside."""
    return comparison.verdict if comparison.admissible else Verdict.OUTSIDE


def beyond_theory(comparison: Comparison) -> str:
    """What the discrepancy holds beside errors of the engines, in a sentence; empty where the reference is exact for the bodies."""
    if _both_ours(comparison):
        return idealisation(comparison.scene)
    if comparison.reference.engine != "semi_analytic" or are_half_planes(comparison.scene):
        return ""
    return (
        "Half-plane theory is an idealisation of these bodies: the discrepancy contains its error beside that of "
        f"{name_of(comparison.result.engine)}, and nothing here tells the two apart; `--against fe` takes finite elements of the "
        "bodies for the reference."
    )


def _both_ours(comparison: Comparison) -> bool:
    return {comparison.reference.engine, comparison.result.engine} == {"semi_analytic", "halfplane_fe"}


def sentence(text: str) -> str:
    """`text` with a capital and a full stop; nothing of nothing.

    >>> sentence("to compare"), sentence("Why?"), sentence("")
    ('To compare.', 'Why?', '')
    """
    return text[:1].upper() + text[1:] + ("" if not text or text.endswith((".", "!", "?")) else ".")


def _first_large(name: str) -> str:
    """An engine at the start of a sentence; other people's codes and files keep the letters that they have."""
    return name.capitalize() if name in ("finite elements", "half-plane theory") else name


def _inside(label: str) -> str:
    """A label inside a sentence: its first letter small."""
    return label[:1].lower() + label[1:]
