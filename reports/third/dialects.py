"""A deck as text, for CalculiX or Abaqus: cards in their order, each with the comment that explains it.

The dialects differ in the form of friction (stick slope or elastic slip), the data of the interaction, and the output requests.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.third.deck import Deck, DeckBody

Array = NDArray[np.float64]
Dialect = Literal["calculix", "abaqus"]

# The longest line that CalculiX reads.
_LINE = 132
# Increments between two outputs: more than a step has, so that only its last is written.
_LAST = "FREQUENCY=1000000"
_ABOUT = {
    "calculix": (
        "dialect: CalculiX 2.20; run it by `ccx <name of this file without .inp>`",
        "result: CPRESS, CSHEAR1, CSLIP1 at the nodes of the lower face at every instant, read by `halfplane score <name>.frd`",
    ),
    "abaqus": (
        "dialect: Abaqus/Standard, without parts and assembly. NOT run in Abaqus: checked by a parser of its keywords, and by "
        "CalculiX on the blocks that the two dialects share",
        "result: CPRESS, CSHEAR1, CSLIP1 along LOWER_FACE at every instant; as a path table (CSV) it is read by `halfplane score`",
    ),
}
# Residual and correction over the mean force: CalculiX' own, of 0.5 % and 1 %, leave a larger error in Q than its mesh does.
_RESIDUAL = "0.0001, 0.01"
# Share by which the number of contact elements may differ, share let go at random, softening, and iterations before an increment
# is halved: CalculiX' own but the last, 60; those that need more than 30 hardly ever converge.
_CONTACT = "0.001, 0.1, 100., 30"


def number(value: float) -> str:
    """Thirteen digits and twenty characters at most, which is what CalculiX reads; always with a point.

    >>> number(0.1), number(-1234.5), number(1e-20), number(2)
    ('0.1', '-1234.5', '1.e-20', '2.')
    """
    mantissa, _, exponent = f"{value:.13g}".partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.") + (f"e{exponent}" if exponent else "")


def elastic_slip(deck: Deck) -> float:
    """Slip [length] at which the friction of the mean pressure, f P/(2 a), is reached at the deck's stick slope."""
    return deck.scene.friction.coefficient * deck.mean_pressure / deck.stick_slope


def deck_text(deck: Deck, dialect: Dialect, command: str = "", versions: Mapping[str, str] | None = None) -> str:
    """The text of the input file; `command` and `versions` go into its first comment."""
    lines = [*_header(deck, dialect, command, versions or {}), *_bodies(deck), *_contact(deck, dialect), *_steps(deck, dialect)]
    return "\n".join(lines) + "\n"


def _card(keyword: str, data: Iterable[str] = (), comment: str = "") -> Iterator[str]:
    """The comment, the keyword with its parameters, and its data lines."""
    yield from _comment(comment)
    yield f"*{keyword}"
    yield from data


def _comment(text: str) -> list[str]:
    return [f"** {line}" for line in textwrap.wrap(text, _LINE - 7, break_on_hyphens=False)]


def _rows(values: ArrayLike, per_line: int) -> Iterator[str]:
    """Data lines of so many integers or numbers each."""
    flat = np.ravel(values)
    words = [str(v) if flat.dtype.kind == "i" else number(v) for v in flat.tolist()]
    return (", ".join(words[k : k + per_line]) for k in range(0, len(words), per_line))


def _header(deck: Deck, dialect: Dialect, command: str, versions: Mapping[str, str]) -> Iterator[str]:
    """What this is, how it was made, what it costs."""
    scene, reach = deck.scene, deck.settings.far_radius
    yield from _card("HEADING", [" ".join(f"halfplane, scene {scene.name}".split())[:80]])  # one line: the next could begin a card
    yield from _comment(f"halfplane: {scene.title or scene.name} (scene {scene.name})")
    yield from _comment(f"made by: {command}" if command else "")
    yield from _comment("with: " + ", ".join(f"{name} {version}" for name, version in versions.items()))
    yield from _comment(f"units: {scene.units}; loads per unit thickness, lower body below y = 0, x along the face")
    yield from _comment(
        f"size: {deck.reference - 1} nodes, surface elements of a/{1 / deck.settings.edge_element_size:g} where edges travel, a = "
        f"{deck.scales.half_width:.6g} at the largest load {deck.scales.load:.6g}; {len(deck.time) - 1} instants"
    )
    if "half_plane" in (scene.bodies.lower.kind, scene.bodies.upper.kind):
        yield from _comment(
            f"half-planes are half-discs of radius {reach:g} a, held along the arc: the tractions miss those of half-planes by "
            f"about (a/L)^2 = {reach**-2:.1e}; displacements of the planes are counted from the arcs"
        )
    for line in _ABOUT[dialect]:
        yield from _comment(line)


def _bodies(deck: Deck) -> Iterator[str]:
    """Nodes, elements, sets and faces, then materials and sections."""
    gap = (
        "The upper body; faces are true, as they are made."
        if deck.scene.bodies.faces_are_true
        else "The upper body. Faces are flat in the scene: the gap h(x) is cut into this one, and goes on smoothly beyond the side "
        "that may touch."
    )
    for body, words in ((deck.lower, "The lower body."), (deck.upper, gap)):
        nodes = (f"{body.first_node + k}, {number(x)}, {number(y)}, 0." for k, (x, y) in enumerate(body.nodes.tolist()))
        yield from _card(f"NODE, NSET={body.name}_NODES", nodes, words)
    plane = [f"{deck.reference}, 0., {number(float(deck.upper.nodes[:, 1].max()))}, 0."]
    words = "The node that the upper rigid plane moves with: loads act on it, its reactions are P and Q."
    yield from _card("NODE, NSET=PLANE", plane, words)
    if any(deck.strain(body) is not None for body in (0, 1)):
        words = "A node whose movements along x and y are the bulk strains of the lower and the upper half-plane times a."
        yield from _card("NODE, NSET=STRAINS", [f"{deck.strained}, 0., 0., 0."], words)
    if deck.tilt is not None or deck.moment is not None:
        words = "A node whose movement along x is the tilt of the upper body times a."
        yield from _card("NODE, NSET=TURN", [f"{deck.turning}, 0., 0., 0."], words)
    for body in (deck.lower, deck.upper):
        numbered = np.hstack([np.arange(len(body.elements))[:, None] + body.first_element, body.elements])
        yield from _card(f"ELEMENT, TYPE=CPE4, ELSET={body.name}", _rows(numbered, 5), "Plane strain, linear.")
        yield from _card(f"NSET, NSET={body.name}_FACE_NODES", _rows(body.contact_nodes, 10), "The face, from left to right.")
        faces = (f"{element}, S{side}" for element, side in body.contact_faces.tolist())
        yield from _card(f"SURFACE, NAME={body.name}_FACE, TYPE=ELEMENT", faces)
    for body, material in ((deck.lower, deck.scene.material.lower), (deck.upper, deck.scene.material.upper)):
        yield from _card(f"MATERIAL, NAME={body.name}_MATERIAL")
        yield from _card("ELASTIC", _rows([material.young_modulus, material.poisson_ratio], 2))
        section = f"SOLID SECTION, ELSET={body.name}, MATERIAL={body.name}_MATERIAL"
        yield from _card(section, ["1."], "Unit thickness: loads are per unit thickness.")


def _contact(deck: Deck, dialect: Dialect) -> Iterator[str]:
    """The contact pair, the rigid plane and the support, and P(t) and Q(t)."""
    settings, friction = deck.settings, deck.scene.friction.coefficient
    yield from _card("SURFACE INTERACTION, NAME=CONTACT", ["1."] if dialect == "abaqus" else [])
    words = (
        f"Pressure per penetration, {settings.normal_stiffness:g} E*/h with E* = {deck.scales.modulus:.6g} and h = "
        f"{deck.element_size:.6g} the elements at the edges: at the mean pressure P/(2 a) the faces overlap by "
        f"{deck.mean_pressure / deck.stiffness / deck.scales.half_width:.1e} half-widths a."
    )
    yield from _card("SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", [number(deck.stiffness)], words)
    if friction > 0 and dialect == "calculix":
        words = (
            f"Friction coefficient, and shear per elastic slip while faces stick: {settings.stick_stiffness:g} E*/h; much "
            "stiffer ones let CalculiX fail to converge, softer ones creep."
        )
        yield from _card("FRICTION", _rows([friction, deck.stick_slope], 2), words)
    elif friction > 0:
        words = (
            "Friction coefficient; the elastic slip at which it is reached is absolute, and is to CalculiX' stick slope of "
            f"{settings.stick_stiffness:g} E*/h what it is at the mean pressure."
        )
        yield from _card(f"FRICTION, ELASTIC SLIP={number(elastic_slip(deck))}", [number(friction)], words)
    words = "Lower face dependent (slave), upper face independent (master); their nodes lie opposite each other if sizes are alike."
    yield from _card("CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE", ["LOWER_FACE, UPPER_FACE"], words)
    turns = deck.tilt is not None or deck.moment is not None
    words = (
        "The upper body's far side is bonded to a rigid plane"
        + (" that turns about x = y = 0" if turns else " that can't turn")
        + ": each node there moves as the plane's node"
        + (", and by the bulk strain of its half-plane." if deck.strain(1) is not None else ".")
    )
    for direction, nodes in sorted(deck.upper.held.items()):
        tied = (_equation(deck, deck.upper, node, direction) for node in nodes.tolist())
        yield from _card("EQUATION", tied, words)
        words = ""
    if deck.strain(0) is not None:
        words = "The lower half-plane's arc moves by its bulk strain."
        for direction, nodes in sorted(deck.lower.held.items()):
            tied = (_equation(deck, deck.lower, node, direction) for node in nodes.tolist() if not _still(deck, node, direction))
            yield from _card("EQUATION", tied, words)
            words = ""
    if held := [*_held(deck), *_further(deck)]:
        yield from _card("BOUNDARY", held, "What holds the lower body.")
    words = "The scene's loads, straight between the instants of output; total time 0 is the unloaded instant of its path."
    for name, values in (("NORMAL_LOAD", deck.normal_load), ("TANGENTIAL_LOAD", deck.tangential_load), *_imposed(deck)):
        pairs = np.stack([deck.deck_time, values], axis=1)
        yield from _card(f"AMPLITUDE, NAME={name}, TIME=TOTAL TIME", _rows(pairs, 4), words)
        words = ""


def _equation(deck: Deck, body: DeckBody, node: int, direction: int) -> str:
    """A node of a far side moves as the rigid plane (of the upper body), by its bulk strain and by the plane's turn."""
    size, (x, y) = deck.scales.half_width, body.nodes[node - body.first_node].tolist()
    terms, which = [(node, direction, 1.0)], int(body is deck.upper)
    if which:
        terms.append((deck.reference, direction, -1.0))
    if deck.strain(which) is not None:
        ratio = (deck.scene.material.lower, deck.scene.material.upper)[which].poisson_ratio
        # A uniform stress along x in plane strain: u_x = eps x, u_y = -nu/(1 - nu) eps y.
        share = -x if direction == 1 else ratio / (1 - ratio) * y
        terms.append((deck.strained, which + 1, share / size))
    if which and (deck.tilt is not None or deck.moment is not None):
        # A turn that opens the gap at x > 0: u_x = -alpha y, u_y = alpha x.
        terms.append((deck.turning, 1, (y if direction == 1 else -x) / size))
    terms = [term for term in terms if term[2]]
    return f"{len(terms)}\n" + ", ".join(f"{of}, {way}, {number(factor)}" for of, way, factor in terms)


def _imposed(deck: Deck) -> Iterator[tuple[str, Array]]:
    """Amplitudes of bulk stress, tilt and moment: strains and tilt times a, so that they are movements of a node."""
    size = deck.scales.half_width
    for body, name in enumerate(("LOWER", "UPPER")):
        if (strain := deck.strain(body)) is not None:
            yield f"{name}_STRAIN", strain * size
        if (stresses := deck.end_stresses(body)) is not None:
            yield from zip((f"{name}_LEFT_END", f"{name}_RIGHT_END"), stresses, strict=True)
    if deck.tilt is not None:
        yield "TILT", deck.tilt * size
    if deck.moment is not None:
        yield "MOMENT", deck.moment / size


def _driven(deck: Deck, *, touching: bool) -> Iterator[str]:
    """Nodes that bulk strains and tilt move, and loads on the ends of blocks; in the touch a moment does not act yet."""
    driven = "BOUNDARY" if touching else "BOUNDARY, OP=NEW"
    for which, name in enumerate(("LOWER", "UPPER")):
        if deck.strain(which) is not None:
            words = f"Bulk stress of the {name.lower()} body, as the strain of its half-plane."
            yield from _card(f"{driven}, AMPLITUDE={name}_STRAIN", [f"{deck.strained}, {which + 1}, {which + 1}, 1."], words)
    if deck.tilt is not None:
        yield from _card(f"{driven}, AMPLITUDE=TILT", [f"{deck.turning}, 1, 1, 1."], "The tilt; it opens the gap at x > 0.")
    if deck.moment is not None and touching:
        yield from _card("BOUNDARY", [f"{deck.turning}, 1, 1, 0."], "The moment acts from the next step on.")
    elif deck.moment is not None:
        words = "The moment of the pressure about x = 0: what acts on the tilt times a is -M/a."
        yield from _card("CLOAD, AMPLITUDE=MOMENT", [f"{deck.turning}, 1, -1."], words)
    for which, body in enumerate((deck.lower, deck.upper)):
        for side, faces in zip(("LEFT", "RIGHT"), body.ends if deck.end_stresses(which) else (), strict=False):
            pulls = (f"{element}, P{face}, -1." for element, face in faces.tolist())
            words = f"Bulk stress of the {body.name.lower()} body at its {side.lower()} end: a pressure of the other sign."
            yield from _card(f"DLOAD, AMPLITUDE={body.name}_{side}_END", pulls, words)


def _further(deck: Deck) -> list[str]:
    """Movements that mean nothing of the nodes for bulk strain and tilt."""
    found = []
    if any(deck.strain(body) is not None for body in (0, 1)):
        found += [f"{deck.strained}, {body + 1}" for body in (0, 1) if deck.strain(body) is None]
    return found + ([f"{deck.turning}, 2"] if deck.tilt is not None or deck.moment is not None else [])


def _held(deck: Deck) -> list[str]:
    """Nodes of the lower body that stand still."""
    held = ((direction, node) for direction, nodes in sorted(deck.lower.held.items()) for node in nodes.tolist())
    return [f"{node}, {direction}" for direction, node in held if _still(deck, node, direction)]


def _still(deck: Deck, node: int, direction: int) -> bool:
    """Whether a held node of the lower body does not move: on a half-plane's arc bulk strain leaves its middle alone."""
    place = deck.lower.nodes[node - deck.lower.first_node, direction - 1]
    return deck.strain(0) is None or not place * (1.0 if direction == 1 else deck.scene.material.lower.poisson_ratio)


def _steps(deck: Deck, dialect: Dialect) -> Iterator[str]:
    """The touch, then a step to each instant of output; the first of them says what the others keep."""

    def step(duration: float, words: str) -> Iterator[str]:
        yield from _card("STEP, NLGEOM=NO, INC=1000", (), words)
        yield from _card("STATIC", _rows([duration, duration, 1e-4 * duration, duration], 4))

    plane = deck.reference
    words = (
        "Step 1, the touch: without contact nothing holds the upper body against a load, so its plane comes down by a small "
        "prescribed way. Not an instant of the scene."
    )
    yield from step(deck.touch_time, words)
    yield from _card("BOUNDARY", [f"{plane}, 1, 1, 0.", f"{plane}, 2, 2, {number(-deck.touch_approach)}"])
    yield from _driven(deck, touching=True)
    yield from _card("END STEP")
    words = (
        "Step 2 and all others, the scene's loads: initial loading and cycles, a step to each instant of output. Every step is one "
        "increment, halved where need be; its last one is written. What is said here holds in every step that follows."
    )
    durations = deck.increments.tolist()
    yield from step(durations[0], words)
    yield from _loads_and_output(deck, dialect)
    yield from _card("END STEP")
    for duration in durations[1:]:
        yield from step(duration, "")
        yield from _card("END STEP")


def _loads_and_output(deck: Deck, dialect: Dialect) -> Iterator[str]:
    plane, slides = deck.reference, deck.scene.friction.coefficient > 0
    if dialect == "calculix":
        yield from _card("CONTROLS, PARAMETERS=FIELD", [_RESIDUAL], "Residual and correction.")
        yield from _card("CONTROLS, PARAMETERS=CONTACT", [_CONTACT])
    words = "The upper plane is let go" + ("." if slides else " along y; there is no friction, and nothing else holds it along x.")
    held = [*_held(deck), *_further(deck), *([] if slides else [f"{plane}, 1, 1, 0."])]
    yield from _card("BOUNDARY, OP=NEW", held, words) if held else _comment(words)
    yield from _driven(deck, touching=False)
    yield from _card("CLOAD, AMPLITUDE=NORMAL_LOAD", [f"{plane}, 2, -1."], "P presses, Q pulls along +x.")
    if slides:
        yield from _card("CLOAD, AMPLITUDE=TANGENTIAL_LOAD", [f"{plane}, 1, 1."])
    if dialect == "calculix":
        yield from _card(f"CONTACT FILE, {_LAST}", ["CDIS, CSTR"], "Contact values at the nodes of the lower face.")
        pair = f"CONTACT PRINT, SLAVE=LOWER_FACE, MASTER=UPPER_FACE, {_LAST}"
        yield from _card(pair, ["CF"], "Resultant of the contact: it must be P and Q.")
        yield from _card(f"NODE PRINT, NSET=PLANE, {_LAST}", ["U"], "Where the upper plane is.")
    else:
        yield from _card(f"OUTPUT, FIELD, {_LAST}", (), "Contact values of the lower face, displacements.")
        yield from _card("CONTACT OUTPUT, NSET=LOWER_FACE_NODES", ["CSTRESS, CDISP"])
        yield from _card("NODE OUTPUT", ["U, RF"])
        yield from _card(f"OUTPUT, HISTORY, {_LAST}", (), "Where the upper plane is, and what it carries.")
        yield from _card("NODE OUTPUT, NSET=PLANE", ["U1, U2, CF1, CF2"])
