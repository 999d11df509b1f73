"""What the dialects of input decks share: keyword blocks with the comment that explains them, and the blocks that read alike."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from reports.third.bodies import DeckBody
from reports.third.deck import Deck

# The longest line and the longest number that CalculiX reads.
LINE, NUMBER = 132, 20
LOWER_FACE, UPPER_FACE, CONTACT = "LOWER_FACE", "UPPER_FACE", "CONTACT"
# Increments between two outputs: more than a step has, so that only its last is written.
AT_THE_END = "1000000"
REFERENCE, LOWER_FACE_NODES = "PLANE", "LOWER_FACE_NODES"


@dataclass(frozen=True)
class Block:
    """A keyword with its parameters (None: without a value), data lines, and the comment before it."""

    keyword: str
    parameters: Mapping[str, str | None] = field(default_factory=dict)
    data: tuple[str, ...] = ()
    comment: str = ""

    def text(self) -> Iterator[str]:
        """The lines."""
        yield from (f"** {line}" for line in _wrapped(self.comment))
        yield ", ".join(
            [f"*{self.keyword}", *(name if value is None else f"{name}={value}" for name, value in self.parameters.items())]
        )
        yield from self.data


def _wrapped(comment: str) -> Iterator[str]:
    line = ""
    for word in comment.split():
        if len(line) + len(word) > LINE - 8:
            yield line
            line = ""
        line = f"{line} {word}".strip()
    if line:
        yield line


def number(value: float) -> str:
    """Thirteen digits at most, twenty characters at most, always with a point.

    >>> number(0.1), number(-1234.5), number(1e-20), number(2)
    ('0.1', '-1234.5', '1.e-20', '2.')
    """
    mantissa, _, exponent = f"{value:.13g}".partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.") + (f"e{exponent}" if exponent else "")


def rows(values: ArrayLike, per_line: int) -> tuple[str, ...]:
    """Data lines of so many integers or numbers each."""
    flat = np.ravel(values)
    words = [str(v) for v in flat.tolist()] if flat.dtype.kind == "i" else [number(v) for v in flat.tolist()]
    return tuple(", ".join(words[k : k + per_line]) for k in range(0, len(words), per_line))


def geometry(deck: Deck) -> Iterator[Block]:
    """Nodes, elements, sets and faces."""
    for body in (deck.lower, deck.upper):
        nodes = tuple(f"{body.first_node + k}, {number(x)}, {number(y)}, 0." for k, (x, y) in enumerate(body.nodes.tolist()))
        yield Block("NODE", {"NSET": f"{body.name}_NODES"}, nodes, _gap_words(deck) if body is deck.upper else "The lower body.")
    top = number(float(deck.upper.nodes[:, 1].max()))
    plane = "The node that the upper rigid plane moves with: loads act on it, its reactions are P and Q."
    yield Block("NODE", {"NSET": REFERENCE}, (f"{deck.reference}, 0., {top}, 0.",), plane)
    for body in (deck.lower, deck.upper):
        numbers = np.arange(len(body.elements))[:, None] + body.first_element
        yield Block(
            "ELEMENT", {"TYPE": "CPE4", "ELSET": body.name}, rows(np.hstack([numbers, body.elements]), 5), "Plane strain, linear."
        )
        yield Block("NSET", {"NSET": f"{body.name}_FACE_NODES"}, rows(body.contact_nodes, 10), "The face, from left to right.")
        faces = tuple(f"{element}, S{side}" for element, side in body.contact_faces.tolist())
        yield Block("SURFACE", {"NAME": f"{body.name}_FACE", "TYPE": "ELEMENT"}, faces)


def _gap_words(deck: Deck) -> str:
    if deck.scene.bodies.faces_are_true:
        return "The upper body; faces are true, as they are made."
    return (
        "The upper body. Faces are flat in the scene: the gap h(x) is cut into this one, and goes on smoothly beyond the side that "
        "may touch."
    )


def sections(deck: Deck) -> Iterator[Block]:
    """Materials and sections; thickness 1, so that loads are per unit thickness."""
    for body, material in ((deck.lower, deck.scene.material.lower), (deck.upper, deck.scene.material.upper)):
        yield Block("MATERIAL", {"NAME": f"{body.name}_MATERIAL"})
        yield Block("ELASTIC", {}, (f"{number(material.young_modulus)}, {number(material.poisson_ratio)}",))
        yield Block(
            "SOLID SECTION",
            {"ELSET": body.name, "MATERIAL": f"{body.name}_MATERIAL"},
            ("1.",),
            "Unit thickness: loads are per unit thickness.",
        )


def stiffness_words(deck: Deck) -> str:
    """How the stiffness of the contact was chosen."""
    factor = deck.settings.normal_stiffness
    return (
        f"Pressure per penetration, {factor:g} E*/h with E* = {deck.scales.modulus:.6g} and h = {deck.element_size:.6g} the "
        f"elements at the edges: at the mean pressure P/(2 a) the faces overlap by {_overlap(deck):.1e} half-widths a."
    )


def _overlap(deck: Deck) -> float:
    return deck.scales.load / (2 * deck.scales.half_width**2 * deck.stiffness)


def pairing() -> Block:
    """The contact pair."""
    words = "Lower face dependent (slave), upper face independent (master); their nodes lie opposite each other if sizes are alike."
    return Block("CONTACT PAIR", {"INTERACTION": CONTACT, "TYPE": "SURFACE TO SURFACE"}, (f"{LOWER_FACE}, {UPPER_FACE}",), words)


def upper_plane(deck: Deck) -> Iterator[Block]:
    """The far side of the upper body moves as the plane's node does, without turning."""
    comment = "The upper body's far side is bonded to a rigid plane that can't turn: each node there moves as the plane's node."
    for direction, nodes in sorted(deck.upper.held.items()):
        lines = tuple(f"{node}, {direction}, 1., {deck.reference}, {direction}, -1." for node in nodes.tolist())
        yield Block("EQUATION", {}, tuple(part for line in lines for part in ("2", line)), comment)
        comment = ""


def held(body: DeckBody) -> tuple[str, ...]:
    """Data lines of *BOUNDARY for what holds a body."""
    return tuple(f"{node}, {direction}" for direction, nodes in sorted(body.held.items()) for node in nodes.tolist())


def lower_support(deck: Deck) -> Block:
    """What holds the lower body."""
    return Block("BOUNDARY", {}, held(deck.lower), "What holds the lower body.")


def amplitudes(deck: Deck) -> Iterator[Block]:
    """P(t) and Q(t) on total time."""
    comment = "The scene's loads, straight between the instants of output; total time 0 is the unloaded instant of its path."
    for name, values in (("NORMAL_LOAD", deck.normal_load), ("TANGENTIAL_LOAD", deck.tangential_load)):
        pairs = np.stack([deck.deck_time, values], axis=1)
        yield Block("AMPLITUDE", {"NAME": name, "TIME": "TOTAL TIME"}, rows(pairs, 4), comment)
        comment = ""


def touch(deck: Deck) -> Iterator[Block]:
    """The first step: a prescribed approach, until the faces have met."""
    duration = deck.touch_time
    words = (
        "Step 1, the touch: without contact nothing holds the upper body against a load, so its plane comes down by a small "
        "prescribed way. Not an instant of the scene."
    )
    yield Block("STEP", {"NLGEOM": "NO", "INC": "1000"}, (), words)
    yield Block("STATIC", {}, (", ".join(map(number, (duration, duration, 1e-4 * duration, duration))),))
    moved = (f"{deck.reference}, 1, 1, 0.", f"{deck.reference}, 2, 2, {number(-deck.touch_approach)}")
    yield Block("BOUNDARY", {}, moved)


def history(deck: Deck, first: Iterable[Block]) -> Iterator[Block]:
    """A step to each instant of output; `first` is what the first of them says and the others keep."""
    words = (
        "Step 2 and all others, the scene's loads: initial loading and cycles, a step to each instant of output. Every step is one "
        "increment, halved where need be; its last one is written. What is said here holds in every step that follows."
    )
    for duration in deck.increments.tolist():
        yield Block("STEP", {"NLGEOM": "NO", "INC": "1000"}, (), words)
        yield Block("STATIC", {}, (", ".join(map(number, (duration, duration, 1e-4 * duration, duration))),))
        yield from first
        yield Block("END STEP")
        words, first = "", ()


def loading(deck: Deck) -> Iterator[Block]:
    """What the steps after the touch hold and load."""
    along = () if deck.slides_along_x else (f"{deck.reference}, 1, 1, 0.",)
    words = "The upper plane is let go" + (
        "." if deck.slides_along_x else " along y; there is no friction, and nothing else holds it along x."
    )
    yield Block("BOUNDARY", {"OP": "NEW"}, (*held(deck.lower), *along), words)
    yield Block("CLOAD", {"AMPLITUDE": "NORMAL_LOAD"}, (f"{deck.reference}, 2, -1.",), "P presses, Q pulls along +x.")
    if deck.slides_along_x:
        yield Block("CLOAD", {"AMPLITUDE": "TANGENTIAL_LOAD"}, (f"{deck.reference}, 1, 1.",))


def header(deck: Deck, dialect: Iterable[str], command: str, versions: Mapping[str, str]) -> Iterator[str]:
    """The comment at the top: what this is, how it was made, what it costs."""
    scene, settings = deck.scene, deck.settings
    nodes = len(deck.lower.nodes) + len(deck.upper.nodes)
    lines = [
        f"halfplane: {scene.title or scene.name} (scene {scene.name})",
        *([f"made by: {command}"] if command else []),
        "with: " + ", ".join(f"{name} {version}" for name, version in versions.items()),
        f"units: {scene.units}; loads per unit thickness, lower body below y = 0, x along the face",
        f"size: {nodes} nodes, surface elements of a/{1 / settings.edge_element_size:g} where edges travel, a = "
        f"{deck.scales.half_width:.6g} at the largest load {deck.scales.load:.6g}; {len(deck.time) - 1} instants",
        *far_field_words(deck),
        *dialect,
    ]
    yield "*HEADING"
    yield " ".join(f"halfplane, scene {scene.name}".split())[:80]  # on one line: the next could begin a card
    for line in lines:
        yield from (f"** {part}" for part in _wrapped(line))


def far_field_words(deck: Deck) -> list[str]:
    """What the half-disc in place of a half-plane costs; nothing where there is none."""
    if all(body.kind != "half_plane" for body in (deck.scene.bodies.lower, deck.scene.bodies.upper)):
        return []
    reach = deck.settings.far_radius
    return [
        f"half-planes are half-discs of radius {reach:g} a, held along the arc: the tractions miss those of half-planes by about "
        f"(a/L)^2 = {reach**-2:.1e}; displacements of the planes are counted from the arcs"
    ]
