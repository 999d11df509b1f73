"""Which maps there are: their studies, what each is drawn and fitted over, and what theory predicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from scenes import InputError

STUDIES = Path(__file__).with_name("studies")
PUBLISHED = Path(__file__).parents[1] / "published" / "maps"

WORDS = {
    "error.dissipation": "dissipation",
    "error.peak_dissipation": "peak dissipation",
    "error.p0": "peak pressure p0",
    "error.contact_half_width": "contact half-width a",
    "error.permanent_stick_half_width": "permanent stick half-width",
    "error.stick_half_width": "stick half-width c",
}
AXES = {
    "height": "height / a",
    "aspect": "width / height",
    "curvature": "a / R",
    "flat": "b / a",
    "beta": "Dundurs' β",
    "f": "friction f",
    "phase": "phase, degrees",
    "margin": "distance from sliding",
    "amplitude": "P1/P0",
    "base": "base",
}


def place(at: Mapping[str, str], everywhere: str = "all") -> str:
    """The coordinates of a line in words; `everywhere` where it has none.

    >>> place({"aspect": "2", "base": "fixed"}), place({})
    ('width / height 2, base fixed', 'all')
    """
    return ", ".join(f"{AXES.get(name, name)} {value}" for name, value in at.items()) or everywhere


@dataclass(frozen=True)
class Chart:
    """One study as it is drawn and fitted.

    Attributes
    ----------
    study : name of the file in studies/
    across, up : columns of the map's two axes; `up` empty: lines over `across`
    panels : column whose values have a panel each; empty for one panel
    small : the small parameter s, in words; `inverse`: s is 1/across, else across itself
    expected : exponent of s that theory predicts; None where no law is sought
    prediction : why
    within : sentence of the designer's table, "height / a >" or "a / R <"
    step : exponent by which the series in s goes on
    others : figures whose exponent is another one, with that
    """

    study: str
    across: str
    up: str
    panels: str
    small: str
    inverse: bool
    expected: float | None
    prediction: str
    within: str
    step: float = 2.0
    others: Mapping[str, float] = field(default_factory=dict)

    def order(self, figure: str) -> float | None:
        """Exponent of s that theory predicts of a figure; None where no law is sought."""
        return self.others.get(figure, self.expected)


@dataclass(frozen=True)
class Map:
    """A page: its charts, and studies of points that no law was fitted to."""

    name: str
    title: str
    question: str
    charts: tuple[Chart, ...]
    held_out: tuple[str, ...] = ()

    @property
    def studies(self) -> tuple[str, ...]:
        """Every study of the page."""
        return (*(chart.study for chart in self.charts), *self.held_out)


_SIZE = (
    "a finite body adds a smooth, even term to the surface's Green's function, -(x - ξ)² κ/2 in its leading order with κ ~ 1/h²: "
    "relative errors are O((a/h)²) at fixed width/height"
)
_CURVED = (
    "an arc's next term, x⁴/(8 R³), changes the gap by (a/R)² of itself (alone: a by −3/16, p0 by +1/16 of (a/R)²); the "
    "normals' turning is odd in the curvature of the line between the faces, which y-mirror reverses, so that it counts in its "
    "square; a body of size R adds its own O((a/R)²)"
)
_CONTOUR = (
    "a contour that is no parabola changes the body's tangential compliance in the first power of its slope, and evenly, so that W "
    "moves by k a/R (`reports/maps/contour.py`; a parabola has k = 0); what pressure and shear do to each other is odd and of the "
    "first power, so that p0, the higher of two peaks, moves by it while Q acts; the half-width, a mean of two edges, keeps to 2"
)
_BETA = (
    "y-mirror swaps the bodies (β → −β, Q → −Q), x-mirror restores Q: p0 and W are even in β, so O(β²) at fixed f. Pressing makes "
    "shear ~ β p against f p, which lets one expect (β/f)²; it is not found, for with P constant that shear stays locked where the "
    "contact sticks and is wiped out where it slips"
)
MAPS = {
    m.name: m
    for m in (
        Map(
            "block",
            "Two equal blocks: height and width",
            "How high and how wide must two equal blocks be?",
            (Chart("block", "height", "aspect", "base", "a/h", True, 2.0, _SIZE, "height / a >"),),
            ("block-held-out",),
        ),
        Map(
            "one-block",
            "One block under a half-plane: height, width and friction",
            "How high must a block be whose partner is large?",
            (
                Chart(
                    "one-block",
                    "height",
                    "aspect",
                    "f",
                    "a/h",
                    True,
                    2.0,
                    _SIZE + "; besides, normal and shear tractions feel each other by a term O(a/h) that counts in its square only",
                    "height / a >",
                ),
            ),
        ),
        Map(
            "curvature",
            "True arcs: a cylinder and a flat pad with rounded edges",
            "How small must the contact be against the radius?",
            (
                Chart("cylinder", "curvature", "", "f", "a/R", False, 2.0, _CURVED, "a / R <"),
                Chart(
                    "pad",
                    "curvature",
                    "flat",
                    "",
                    "a/R",
                    False,
                    1.0,
                    _CONTOUR,
                    "a / R <",
                    1.0,
                    {"error.contact_half_width": 2.0},
                ),
            ),
            ("pad-held-out",),
        ),
        Map(
            "unlike",
            "Unlike materials: Dundurs' beta against friction",
            "May normal and shear tractions be taken as uncoupled?",
            (Chart("unlike", "beta", "f", "", "beta", False, 2.0, _BETA, "beta <"),),
            ("unlike-held-out",),
        ),
        Map(
            "loop",
            "The loop: where the same bodies hurt most",
            "Under which loop does a body's error hurt dissipation most?",
            (Chart("loop", "phase", "margin", "amplitude", "", False, None, "", ""),),
        ),
        Map(
            "limits",
            "The engines' own limits: mesh, far field, steps",
            "What is left between the engines where the bodies are half-planes?",
            (
                Chart(
                    "limits-mesh",
                    "mesh",
                    "",
                    "",
                    "size/a",
                    False,
                    1.5,
                    "tractions end as a root at contact and stick edges: order 3/2 in the size of elements there",
                    "element / a <",
                ),
                Chart(
                    "limits-far",
                    "far",
                    "",
                    "",
                    "a/L",
                    True,
                    None,
                    "",
                    "L / a >",
                ),
                Chart(
                    "limits-step",
                    "step",
                    "",
                    "",
                    "tolerance of an increment",
                    False,
                    None,
                    "",
                    "tolerance <",
                ),
            ),
        ),
    )
}


def map_named(name: str) -> Map:
    """A map by name; InputError names those that there are."""
    if name not in MAPS:
        raise InputError(f"map {name!r}: there is none; known: {', '.join(MAPS)}, or all")
    return MAPS[name]
