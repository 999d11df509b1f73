"""What the published maps say of a scene: one contribution for each way in which its bodies are no half-planes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from reports.maps.atlas import MAPS, PUBLISHED, Chart
from reports.maps.contour import share_of, work_constant
from reports.maps.corrections import correction, smaller_than_the_maps, to_and_fro
from reports.maps.fitting import Line, along, lines
from reports.maps.pads import RATIO, SHEAR, work_lines
from reports.maps.readings import read
from reports.sweep.figures import QUANTITIES
from scenes import Block, Cylinder, FlatRounded, Hertz, InputError, Pad, Scene
from scenes.frozen import validated

FIGURES = ("error.dissipation", "error.p0", "error.contact_half_width")
_WORDS = {"flat": "b/a", "aspect": "width/height"}
# Of the error, what the correction left on the worst held-out point: 14 % (map `block`); rounded up.
_LEFT = 0.15


@dataclass(frozen=True)
class Part:
    """What one departure from half-planes does.

    Attributes
    ----------
    what : its words, with the group's value
    values : figure -> (error of half-plane theory, uncertainty); None where the maps have nothing
    how : where it was read, and whether it was extrapolated
    extrapolated : outside of what was run
    """

    what: str
    values: Mapping[str, tuple[float, float]] | None
    how: str
    extrapolated: bool = False


def parts(scene: Scene, folder: Path = PUBLISHED) -> tuple[float, list[Part]]:
    """Half-width a by half-plane theory at the mean (else the largest) load, and every departure of a scene.

    Raises
    ------
    InputError
        Where the maps are not there, or have no such contact: frictionless, another profile than Hertz or flat with rounded edges.
    """
    scene = validated(scene, Scene)
    if scene.friction.coefficient == 0:
        raise InputError(f"{scene.name}: friction.coefficient = 0: nothing is dissipated, and no map is of frictionless contacts")
    if not isinstance(scene.profile, Hertz | FlatRounded):
        raise InputError(
            f"{scene.name}: profile.kind = {scene.profile.kind!r}: the maps are of 'hertz' and 'flat_rounded'; take `halfplane run`"
        )
    half_width = _half_width(scene)
    found = [*_size(scene, half_width, folder), *_curvature(scene, half_width, folder), *_unlike(scene, folder)]
    return half_width, found


def _half_width(scene: Scene) -> float:
    import semi_analytic

    return QUANTITIES["contact_half_width"].value(semi_analytic.solve(scene, cycles="steady", fields=()))


def _size(scene: Scene, half_width: float, folder: Path) -> list[Part]:
    lower, upper = scene.bodies.lower, scene.bodies.upper
    if isinstance(lower, Block) and lower == upper:
        try:
            return [_two_blocks(scene, half_width)]
        except InputError as refused:
            return [Part("two equal blocks", None, str(refused))]
    found = []
    for name, body in (("lower", lower), ("upper", upper)):
        if isinstance(body, Pad) and isinstance(scene.profile, FlatRounded):
            found += _flat_pad(scene.profile, name, body)
        elif isinstance(body, Block | Pad):
            found.append(_one_block(scene, name, body, half_width, folder))
    return found


def _flat_pad(profile: FlatRounded, name: str, pad: Pad) -> list[Part]:
    """Pads as large as those of the map need nothing more, smaller ones are unknown."""
    too_small = smaller_than_the_maps(profile, pad)
    what = f"the {name} body, a pad {pad.width:g} wide and {pad.height:g} high"
    return [Part(what, None, too_small)] if too_small else []


def _two_blocks(scene: Scene, half_width: float) -> Part:
    found = correction(scene)
    errors = (found.dissipation, found.peak_pressure, found.contact_half_width)
    values = {name: (error, _LEFT * abs(error)) for name, error in zip(FIGURES, errors, strict=True)}
    block = scene.bodies.lower
    assert isinstance(block, Block)
    what = f"two equal blocks, height/a = {block.height / half_width:.3g}, width/height = {found.aspect:.3g}, base {block.base}"
    return Part(what, values, "correction of the map `block` for this very loop; p0 and a at the largest load")


def _one_block(scene: Scene, name: str, block: Block | Pad, half_width: float, folder: Path) -> Part:
    height, aspect = block.height / half_width, block.width / block.height
    what = f"the {name} body, a {block.kind}: height/a = {height:.3g}, width/height = {aspect:.3g}, base {block.base}"
    if block.base != "fixed" or block.sides != "free":
        return Part(what, None, "the map `one-block` has a fixed base and free sides alone")
    chart = MAPS["one-block"].charts[0]
    return _from_map(what, chart, 1 / height, {"aspect": aspect, "f": scene.friction.coefficient}, folder)


def _curvature(scene: Scene, half_width: float, folder: Path) -> list[Part]:
    bodies = [body for body in (scene.bodies.lower, scene.bodies.upper) if isinstance(body, Cylinder | Pad)]
    if not bodies:
        return []
    assert isinstance(scene.profile, Hertz | FlatRounded)
    radius = scene.profile.radius
    charts = {chart.study: chart for chart in MAPS["curvature"].charts}
    what = f"true arcs, a/R = {half_width / radius:.3g}"
    if isinstance(scene.profile, FlatRounded):
        flat = scene.profile.flat_half_length / half_width
        found = _from_map(f"{what}, b/a = {flat:.3g}", charts["pad"], half_width / radius, {"flat": flat}, folder)
        return [_by_the_law(scene, found, half_width / radius, flat, folder)]
    return [_from_map(what, charts["cylinder"], half_width / radius, {"f": scene.friction.coefficient}, folder)]


def _by_the_law(scene: Scene, found: Part, curvature: float, flat: float, folder: Path) -> Part:
    """Dissipation of a flat pad by its first-order law for this very loop, and by the map for what is left of it, in (a/R)^2.

    p0 is off by what shear adds to the higher of two peaks: that of the map goes with Q/P, within half of the change.
    """
    if found.values is None:
        return found
    try:
        cycle = to_and_fro(scene)
    except InputError:
        return replace(found, how=f"{found.how}; it has constant P and Q = {RATIO} f P, which this loop is not", extrapolated=True)
    second = [_less_the_law(line) for line in work_lines(folder)]
    # The bodies' own moduli: first and second order go with the share of the curved one.
    share = share_of(scene.material.upper if isinstance(scene.bodies.upper, Pad) else scene.material.lower, scene.material)
    constant = work_constant(flat, cycle.ratio)
    rest, doubt, _ = between(second, curvature, {"flat": flat})
    # Of the rest no other loop is in the map: as much as it would move by with the law.
    other = abs(rest) * abs(constant / work_constant(flat, RATIO) - 1)
    pressure, unsure = found.values["error.p0"]
    scaled = pressure * share * cycle.largest / SHEAR
    values = {
        **found.values,
        "error.dissipation": (share * (constant * curvature + rest), share * (doubt + other)),
        "error.p0": (scaled, unsure * max(1.0, share * cycle.largest / SHEAR) + abs(scaled - pressure) / 2),
    }
    return replace(found, values=values, how=f"law of its contour, first power of a/R, for this loop; {found.how}")


def _less_the_law(line: Line) -> Line:
    """What is left of a line of dissipation without its first order."""
    return replace(line, error=line.error - work_constant(float(line.at["flat"]), RATIO) * line.s, order=2.0)


def _unlike(scene: Scene, folder: Path) -> list[Part]:
    from halfplane_fe.dundurs import dundurs

    found = dundurs(scene.material)
    if abs(found.beta) < 1e-9:
        return []
    f = scene.friction.coefficient
    what = f"unlike materials, β = {found.beta:.3g}, f = {f:g}".replace("-", "−")
    return [_from_map(what, MAPS["unlike"].charts[0], abs(found.beta), {"f": f}, folder)]


def _from_map(what: str, chart: Chart, s: float, place: Mapping[str, float], folder: Path) -> Part:
    if not (folder / f"{chart.study}.csv").exists():
        return Part(what, None, f"{_source(chart)} is not there; make it by `halfplane map all`")
    every = list(lines(chart, read(folder, chart.study)))
    values, outside = {}, []
    for figure in FIGURES:
        error, doubt, said = between([line for line in every if line.figure == figure], s, place, chart.small)
        values[figure] = (error, doubt)
        outside = said
    how = _source(chart) + (f"; extrapolated: {', '.join(outside)}" if outside else "")
    return Part(what, values, how, bool(outside))


def _source(chart: Chart) -> str:
    """A map by the name that `halfplane map` takes, with the study where it has several."""
    name = next((asked.name for asked in MAPS.values() if chart in asked.charts), chart.study)
    return f"map `{name}`" + (f", {chart.study}" if chart.study != name else "")


def between(found: Sequence[Line], s: float, place: Mapping[str, float], small: str = "s") -> tuple[float, float, list[str]]:
    """Error and uncertainty at s, which is called `small`, and a place among the lines, and what lies outside of them.

    Along a line as `fitting.along` reads it; between lines, over the logarithms of their coordinates. The doubt is that of the
    points, and a quarter of what neighbouring lines differ by.
    """
    outside: list[str] = []

    def level(names: Sequence[str], chosen: Sequence[Line]) -> tuple[float, float]:
        if not names:
            largest = float(chosen[0].s[chosen[0].known].max())
            if s > largest * (1 + 1e-6):
                outside.append(f"{small} = {s:.3g} is beyond {largest:.3g}")
            return along(chosen[0], s)
        name, rest = names[0], names[1:]
        steps = sorted({float(line.at[name]) for line in chosen})
        at = min(max(place[name], steps[0]), steps[-1])
        if not math.isclose(at, place[name], rel_tol=1e-6):
            there = f"outside {steps[0]:g} to {steps[-1]:g}" if len(steps) > 1 else "not in it"
            outside.append(f"{_WORDS.get(name, name)} = {place[name]:.3g} is {there}, taken at {at:g}")
        above = next((k for k, step in enumerate(steps) if step >= at * (1 - 1e-9)), len(steps) - 1)
        below = max(above - 1, 0) if steps[above] > at * (1 + 1e-9) else above
        ends = [level(rest, [line for line in chosen if float(line.at[name]) == steps[k]]) for k in (below, above)]
        if below == above:
            return ends[0]
        share = math.log(at / steps[below]) / math.log(steps[above] / steps[below])
        error, doubt = ((1 - share) * ends[0][k] + share * ends[1][k] for k in (0, 1))
        return error, doubt + abs(ends[1][0] - ends[0][0]) / 4

    error, doubt = level(tuple(place), found)
    return error, doubt, list(dict.fromkeys(outside))
