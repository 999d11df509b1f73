"""What the published maps say of a scene: the error by each departure from half-planes, their sum,
and whether to use theory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from reports.comparison.verdicts import Verdict, verdict_on
from reports.studies.maps.corrections import (
    correction,
    share_of,
    smaller_than_the_maps,
    to_and_fro,
    work_constant,
)
from reports.studies.maps.laws import MAPS, PUBLISHED, Chart, Line, along, lines, read
from reports.studies.sweep.solving import QUANTITIES
from scenes import (
    Block,
    Cylinder,
    FlatRounded,
    Hertz,
    InputError,
    Pad,
    Scene,
    ShoulderedPad,
    TShape,
)
from scenes.frozen import validated

FIGURES = ("error.dissipation", "error.p0", "error.contact_half_width")
# of the study `pad`: Q over f P, and over P
RATIO = 0.6
_SHEAR = 0.3
_COORDINATES = {"flat": "b/a", "aspect": "width/height"}
# Of the error, what the correction left on the worst held-out point: 14 % (map `block`); rounded
# up.
_LEFT = 0.15


@dataclass(frozen=True)
class Part:
    """What one departure from half-planes does."""

    what: str  # its words, with the group's value
    # error's name -> (error of theory, uncertainty); None: the maps have nothing
    values: Mapping[str, tuple[float, float]] | None
    how: str  # where it was read, and whether it was extrapolated
    extrapolated: bool = False  # outside of what was run


@dataclass(frozen=True)
class Advice:
    """What the maps say of a scene."""

    scene: Scene
    half_width: float  # a by half-plane theory at the mean (else the largest) load [length]
    parts: tuple[Part, ...]  # every departure from half-planes; none where theory is the very model
    limit: float  # error of dissipation up to which theory may be used

    @property
    def known(self) -> list[Part]:
        """The departures of which the maps know something."""
        return [part for part in self.parts if part.values is not None]

    @property
    def extrapolated(self) -> bool:
        """Whether a departure is outside of what was run."""
        return any(part.extrapolated for part in self.parts)

    @property
    def verdict(self) -> Verdict | None:
        """Whether the error of dissipation, with its uncertainty, is within the limit; None where a
        departure is unknown.
        """
        if len(self.known) < len(self.parts):
            return None
        error, doubt = total(self.known, "error.dissipation")
        return verdict_on(error, self.limit, doubt)

    @property
    def may_be_used(self) -> bool:
        """Whether the error is within the limit for sure: known, not extrapolated, its uncertainty
        inside.
        """
        return self.verdict is Verdict.WITHIN and not self.extrapolated


# -------------------------------------------------------------------------------------------- words
def total(known: Sequence[Part], figure: str) -> tuple[float, float]:
    """Errors and uncertainties of one name, added up."""
    pairs = [part.values[figure] for part in known if part.values is not None]
    return sum(error for error, _ in pairs), sum(doubt for _, doubt in pairs)


def percent(error: float, doubt: float) -> str:
    """Error with its uncertainty.

    >>> percent(-0.4814, 0.0021), percent(0.00012, 0.0004), percent(-0.5, 0.28)
    ('−48.1 ± 0.2 %', '+0.012 ± 0.04 % (not resolved)', '−50.0 ± 30 %')
    """
    digits = max(0, min(3, -math.floor(math.log10(100 * doubt)))) if doubt > 0 else 3
    digits = max(digits, 3 if abs(error) < 1e-3 else 1)
    first_digit = float(f"{100 * doubt:.1g}")
    text = f"{100 * error:+.{digits}f} ± {first_digit:g} %".replace("-", "−")
    return text + (" (not resolved)" if abs(error) <= doubt else "")


def cell(error: float, doubt: float, extrapolated: bool) -> str:
    """An error in per cent with its uncertainty; an extrapolated one has no uncertainty
    estimate.
    """
    return (
        f"about {100 * error:+.2g} %, extrapolated".replace("-", "−")
        if extrapolated
        else percent(error, doubt)
    )


def cells(part: Part) -> tuple[str, ...]:
    """The errors of a departure in words, one a name of `FIGURES`."""
    values = part.values
    return tuple(
        "unknown" if values is None else cell(*values[figure], part.extrapolated)
        for figure in FIGURES
    )


def sentence(advice: Advice) -> str:
    """May theory be used, by how much it is off, and what to do."""
    if not advice.parts:
        return (
            "both bodies are half-planes of like materials (Dundurs' β is 0): half-plane theory is"
            " the very model"
        )
    if advice.verdict is None:
        n_missing = len(advice.parts) - len(advice.known)
        return (
            f"Not known: departures that are in no map: {n_missing} of {len(advice.parts)}."
            " Solve the"
            " scene (`halfplane run`)."
        )
    error_in_words = cell(*total(advice.known, "error.dissipation"), advice.extrapolated)
    words = f"dissipation of the bodies over that of half-plane theory, minus 1: {error_in_words}"
    words += ", cross terms left out" * (len(advice.parts) > 1)
    words += (
        "; outside the maps, so solve the scene (`halfplane run`) before you rely on it"
        * advice.extrapolated
    )
    words += "; undecided, for the uncertainty reaches across the limit" * (
        advice.verdict is Verdict.UNDECIDED
    )
    answer = (
        "No" if advice.verdict is Verdict.OUTSIDE else "Yes" if advice.may_be_used else "Not sure"
    )
    return f"{answer}: {words}. The limit is {100 * advice.limit:g} %."


# --------------------------------------------------------------------------------------- departures
def parts_of(scene: Scene, folder: Path = PUBLISHED) -> tuple[float, tuple[Part, ...]]:
    """Half-width a by half-plane theory at the mean (else the largest) load, and every departure of
    a scene.

    Raises
    ------
    InputError
        Where the maps are not there, or have no such contact: frictionless, bulk stress or tilt,
        another profile than Hertz or flat with rounded edges.
    """
    import semi_analytic
    from halfplane_fe.dundurs import dundurs

    scene = validated(scene, Scene)
    profile = scene.profile
    f = scene.friction.coefficient
    if f == 0:
        raise InputError(
            f"{scene.name}: friction.coefficient = 0: nothing is dissipated, and no map is of"
            " frictionless contacts"
        )
    if scene.load.has_bulk_or_tilt:
        raise InputError(
            f"{scene.name}: advice covers no bulk stress or tilt; the map `bulk` shows specimens,"
            " `halfplane run` solves the scene"
        )
    if not isinstance(profile, Hertz | FlatRounded):
        raise InputError(
            f"{scene.name}: profile.kind = {profile.kind!r}: the maps are of 'hertz' and"
            " 'flat_rounded'; take `halfplane run`"
        )
    steady_cycle = semi_analytic.solve(scene, cycles="steady", fields=())
    half_width = QUANTITIES["contact_half_width"].of(steady_cycle, scene)
    found = _size(scene, half_width, folder)
    bodies = (scene.bodies.lower, scene.bodies.upper)
    if any(isinstance(body, Cylinder | Pad | ShoulderedPad) for body in bodies):
        curvature = half_width / profile.radius
        cylinder, pad = MAPS["curvature"].charts
        what = f"true arcs, a/R = {curvature:.3g}"
        if isinstance(profile, FlatRounded):
            flat = profile.flat_half_length / half_width
            read_off = _from_map(
                f"{what}, b/a = {flat:.3g}", pad, curvature, {"flat": flat}, folder
            )
            found.append(_by_the_law(scene, read_off, curvature, flat, folder))
        else:
            found.append(_from_map(what, cylinder, curvature, {"f": f}, folder))
    if abs(beta := dundurs(scene.material).beta) > 1e-9:
        what = f"unlike materials, β = {beta:.3g}, f = {f:g}".replace("-", "−")
        found.append(_from_map(what, MAPS["unlike"].charts[0], abs(beta), {"f": f}, folder))
    return half_width, tuple(found)


def _size(scene: Scene, half_width: float, folder: Path) -> list[Part]:
    """What finite heights and widths do: two equal blocks by their correction, one by its map, pads
    as those of theirs.
    """
    lower = scene.bodies.lower
    upper = scene.bodies.upper
    if isinstance(lower, Block) and lower == upper:
        try:
            map_correction = correction(scene)
        except InputError as refused:
            return [Part("two equal blocks", None, str(refused))]
        errors = (
            map_correction.dissipation,
            map_correction.peak_pressure,
            map_correction.contact_half_width,
        )
        values = {
            name: (error, _LEFT * abs(error)) for name, error in zip(FIGURES, errors, strict=True)
        }
        size = (
            f"height/a = {lower.height / half_width:.3g}, width/height ="
            f" {map_correction.aspect:.3g}, base"
            f" {lower.base}"
        )
        source = "correction of the map `block` for this very loop; p0 and a at the largest load"
        return [Part(f"two equal blocks, {size}", values, source)]
    parts = []
    for name, body in (("lower", lower), ("upper", upper)):
        if isinstance(body, Pad) and isinstance(scene.profile, FlatRounded):
            if refusal := smaller_than_the_maps(scene.profile, body):
                parts.append(
                    Part(
                        f"the {name} body, a pad {body.width:g} wide and {body.height:g} high",
                        None,
                        refusal,
                    )
                )
        elif isinstance(body, TShape | ShoulderedPad):
            words_of_body = f"the {name} body, a {body.kind}"
            parts.append(Part(words_of_body, None, "no map has bodies with a step in their sides"))
        elif isinstance(body, Block | Pad):
            height = body.height / half_width
            aspect = body.width / body.height
            words_of_body = (
                f"the {name} body, a {body.kind}: height/a = {height:.3g}, width/height ="
                f" {aspect:.3g}, base {body.base}"
            )
            if body.base != "fixed" or body.sides != "free":
                parts.append(
                    Part(
                        words_of_body,
                        None,
                        "the map `one-block` has a fixed base and free sides alone",
                    )
                )
            else:
                coordinates = {"aspect": aspect, "f": scene.friction.coefficient}
                parts.append(
                    _from_map(
                        words_of_body, MAPS["one-block"].charts[0], 1 / height, coordinates, folder
                    )
                )
    return parts


def _by_the_law(scene: Scene, found: Part, curvature: float, flat: float, folder: Path) -> Part:
    """Dissipation of a flat pad by its first-order law for this very loop, and by the map for what
    is left of it, in (a/R)^2.

    The error of p0 is what shear adds to the higher of two peaks: that of the map goes with Q/P,
    within half of the change.
    """
    if found.values is None:
        return found
    try:
        cycle = to_and_fro(scene)
    except InputError:
        return replace(
            found,
            how=f"{found.how}; it has constant P and Q = {RATIO} f P, which this loop is not",
            extrapolated=True,
        )
    second = [
        replace(
            line,
            error=line.error - work_constant(float(line.at["flat"]), RATIO) * line.s,
            order=2.0,
        )
        for line in work_lines(folder)
    ]
    # The bodies' own moduli: first and second order go with the share of the curved one.
    share = share_of(
        scene.material.upper if isinstance(scene.bodies.upper, Pad) else scene.material.lower,
        scene.material,
    )
    constant = work_constant(flat, cycle.ratio)
    rest, doubt, _ = between(second, curvature, {"flat": flat})
    # Of the rest no other loop is in the map: as much as it would move by with the law, and a tenth
    # (8 % on a pad in no map).
    other = abs(rest) * (abs(constant / work_constant(flat, RATIO) - 1) + 0.1)
    pressure, unsure = found.values["error.p0"]
    scaled = pressure * share * cycle.largest / _SHEAR
    values = {
        **found.values,
        "error.dissipation": (share * (constant * curvature + rest), share * (doubt + other)),
        "error.p0": (
            scaled,
            unsure * max(1.0, share * cycle.largest / _SHEAR) + abs(scaled - pressure) / 2,
        ),
    }
    return replace(
        found,
        values=values,
        how=f"law of its contour, first power of a/R, for this loop; {found.how}",
    )


def work_lines(folder: Path) -> list[Line]:
    """The lines of dissipation in the study `pad`."""
    pad = MAPS["curvature"].charts[1]
    return list(lines(pad, read(folder, pad.study), ("error.dissipation",)))


def _from_map(what: str, chart: Chart, s: float, place: Mapping[str, float], folder: Path) -> Part:
    name = next(one.name for one in MAPS.values() if chart in one.charts)
    source = f"map `{name}`" + (f", {chart.study}" if chart.study != name else "")
    if not (folder / f"{chart.study}.csv").exists():
        return Part(what, None, f"{source} is not there; make it by `halfplane map all`")
    every = list(lines(chart, read(folder, chart.study), FIGURES))
    values = {}
    outside = list[str]()
    for figure in FIGURES:
        error, doubt, outside = between(
            [line for line in every if line.figure == figure], s, place, chart.small
        )
        values[figure] = (error, doubt)
    return Part(
        what,
        values,
        source + (f"; extrapolated: {', '.join(outside)}" if outside else ""),
        bool(outside),
    )


def between(
    found: Sequence[Line], s: float, place: Mapping[str, float], small: str = "s"
) -> tuple[float, float, list[str]]:
    """Error and uncertainty at s, which is called `small`, and a place among the lines, and what
    lies outside of them.

    Along a line as `laws.along` reads it; between lines, over the logarithms of their coordinates.
    The doubt is that of the points, and a quarter of what neighbouring lines differ by.
    """
    outside: list[str] = []

    def level(names: Sequence[str], chosen: Sequence[Line]) -> tuple[float, float]:
        if not names:
            largest = float(chosen[0].s[chosen[0].known].max())
            if s > largest * (1 + 1e-6):
                outside.append(f"{small} = {s:.3g} is beyond {largest:.3g}")
            return along(chosen[0], s)
        name = names[0]
        rest = names[1:]
        steps = sorted({float(line.at[name]) for line in chosen})
        at = min(max(place[name], steps[0]), steps[-1])
        if not math.isclose(at, place[name], rel_tol=1e-6):
            there = f"outside {steps[0]:g} to {steps[-1]:g}" if len(steps) > 1 else "not in it"
            outside.append(
                f"{_COORDINATES.get(name, name)} = {place[name]:.3g} is {there}, taken at {at:g}"
            )
        above = next((k for k, step in enumerate(steps) if step >= at * (1 - 1e-9)), len(steps) - 1)
        below = max(above - 1, 0) if steps[above] > at * (1 + 1e-9) else above
        low, high = (
            level(rest, [line for line in chosen if float(line.at[name]) == steps[k]])
            for k in (below, above)
        )
        if below == above:
            return low
        share = math.log(at / steps[below]) / math.log(steps[above] / steps[below])
        return (1 - share) * low[0] + share * high[0], (1 - share) * low[1] + share * high[1] + abs(
            high[0] - low[0]
        ) / 4

    error, doubt = level(tuple(place), found)
    return error, doubt, list(dict.fromkeys(outside))
