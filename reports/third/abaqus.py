"""The deck in Abaqus' words: the same blocks, Abaqus' friction by elastic slip, its output requests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from reports.third import blocks
from reports.third.blocks import AT_THE_END, LOWER_FACE_NODES, REFERENCE, Block, number
from reports.third.deck import Deck
from reports.third.dialect import Dialect, deck_text

_ABOUT = (
    "dialect: Abaqus/Standard, without parts and assembly. NOT run in Abaqus: checked by a parser of its keywords, and by CalculiX "
    "on the blocks that the two dialects share",
    "result: CPRESS, CSHEAR1, CSLIP1 along LOWER_FACE at every instant; as a path table (CSV) it is read by `halfplane score`",
)


def abaqus_deck(deck: Deck, command: str = "", versions: Mapping[str, str] | None = None) -> str:
    """The text of the input file."""
    return deck_text(Dialect(_ABOUT, ("1.",), _friction, _loaded), deck, command, versions or {})


def elastic_slip(deck: Deck) -> float:
    """Slip [length] at which the mean pressure's friction f P/(2 a) would be reached at the deck's stick slope."""
    return deck.scene.friction.coefficient * deck.scales.load / (2 * deck.scales.half_width * deck.stick_slope)


def _friction(deck: Deck) -> Block:
    words = (
        "Friction coefficient; the elastic slip at which it is reached is absolute, and is to CalculiX' stick slope of "
        f"{deck.settings.stick_stiffness:g} E*/h what it is at the mean pressure."
    )
    return Block("FRICTION", {"ELASTIC SLIP": number(elastic_slip(deck))}, (number(deck.scene.friction.coefficient),), words)


def _loaded(deck: Deck) -> Iterator[Block]:
    yield from blocks.loading(deck)
    yield Block("OUTPUT", {"FIELD": None, "FREQUENCY": AT_THE_END}, (), "Contact values of the lower face, displacements.")
    yield Block("CONTACT OUTPUT", {"NSET": LOWER_FACE_NODES}, ("CSTRESS, CDISP",))
    yield Block("NODE OUTPUT", {}, ("U, RF",))
    yield Block("OUTPUT", {"HISTORY": None, "FREQUENCY": AT_THE_END}, (), "Where the upper plane is, and what it carries.")
    yield Block("NODE OUTPUT", {"NSET": REFERENCE}, ("U1, U2, CF1, CF2",))
