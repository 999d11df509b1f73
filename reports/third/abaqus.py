"""The deck in Abaqus' words: the same blocks, Abaqus' friction by elastic slip, its output requests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from reports.third import blocks
from reports.third.blocks import AT_THE_END, CONTACT, LOWER_FACE_NODES, REFERENCE, Block, number
from reports.third.deck import Deck

_ABOUT = (
    "dialect: Abaqus/Standard, without parts and assembly. NOT run in Abaqus: checked by a parser of its keywords, and by CalculiX "
    "on the blocks that the two dialects share",
    "result: CPRESS, CSHEAR1, CSLIP1 along LOWER_FACE at every instant; as a path table (CSV) it is read by `halfplane score`",
)


def abaqus_deck(deck: Deck, command: str = "", versions: Mapping[str, str] | None = None) -> str:
    """The text of the input file."""
    lines = [*blocks.header(deck, _ABOUT, command, versions or {})]
    for block in _blocks(deck):
        lines.extend(block.text())
    return "\n".join(lines) + "\n"


def elastic_slip(deck: Deck) -> float:
    """Slip [length] at which the mean pressure's friction f P/(2 a) would be reached at the deck's stick slope."""
    return deck.scene.friction.coefficient * deck.scales.load / (2 * deck.scales.half_width * deck.stick_slope)


def _blocks(deck: Deck) -> Iterator[Block]:
    yield from blocks.geometry(deck)
    yield from blocks.sections(deck)
    yield from _interaction(deck)
    yield blocks.pairing()
    yield from blocks.upper_plane(deck)
    yield blocks.lower_support(deck)
    yield from blocks.amplitudes(deck)
    yield from blocks.touch(deck)
    yield Block("END STEP")
    yield from blocks.history(deck, [*blocks.loading(deck), *_output()])


def _interaction(deck: Deck) -> Iterator[Block]:
    yield Block("SURFACE INTERACTION", {"NAME": CONTACT}, ("1.",))
    words = blocks.stiffness_words(deck)
    yield Block("SURFACE BEHAVIOR", {"PRESSURE-OVERCLOSURE": "LINEAR"}, (number(deck.stiffness),), words)
    friction = deck.scene.friction.coefficient
    if np.isfinite(friction) and friction > 0:
        words = (
            "Friction coefficient; the elastic slip at which it is reached is absolute, and is to CalculiX' stick slope of "
            f"{deck.settings.stick_stiffness:g} E*/h what it is at the mean pressure."
        )
        yield Block("FRICTION", {"ELASTIC SLIP": number(elastic_slip(deck))}, (number(friction),), words)


def _output() -> Iterator[Block]:
    yield Block("OUTPUT", {"FIELD": None, "FREQUENCY": AT_THE_END}, (), "Contact values of the lower face, displacements.")
    yield Block("CONTACT OUTPUT", {"NSET": LOWER_FACE_NODES}, ("CSTRESS, CDISP",))
    yield Block("NODE OUTPUT", {}, ("U, RF",))
    yield Block("OUTPUT", {"HISTORY": None, "FREQUENCY": AT_THE_END}, (), "Where the upper plane is, and what it carries.")
    yield Block("NODE OUTPUT", {"NSET": REFERENCE}, ("U1, U2, CF1, CF2",))
