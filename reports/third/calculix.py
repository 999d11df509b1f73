"""The deck in CalculiX' words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from reports.third import blocks
from reports.third.blocks import AT_THE_END, LOWER_FACE, REFERENCE, UPPER_FACE, Block, number
from reports.third.deck import Deck
from reports.third.dialect import Dialect, deck_text

_ABOUT = (
    "dialect: CalculiX 2.20; run it by `ccx <name of this file without .inp>`",
    "result: CPRESS, CSHEAR1, CSLIP1 at the nodes of the lower face at every instant, read by `halfplane score <name>.frd`",
)
# Residual and correction over the mean force: CalculiX' own, of 0.5 % and 1 %, leave Q off by more than its mesh does.
_RESIDUAL, _CORRECTION = 1e-4, 1e-2
# Share by which the number of contact elements may differ, share let go at random, softening, and iterations before an increment
# is halved: CalculiX' own but the last, 60; those that need more than 30 hardly ever converge.
_CONTACT = "0.001, 0.1, 100., 30"


def calculix_deck(deck: Deck, command: str = "", versions: Mapping[str, str] | None = None) -> str:
    """The text of the input file."""
    return deck_text(Dialect(_ABOUT, (), _friction, _loaded), deck, command, versions or {})


def _friction(deck: Deck) -> Block:
    words = (
        f"Friction coefficient, and shear per elastic slip while faces stick: {deck.settings.stick_stiffness:g} E*/h; much "
        "stiffer ones let CalculiX fail to converge, softer ones creep."
    )
    return Block("FRICTION", {}, (f"{number(deck.scene.friction.coefficient)}, {number(deck.stick_slope)}",), words)


def _loaded(deck: Deck) -> Iterator[Block]:
    yield Block("CONTROLS", {"PARAMETERS": "FIELD"}, (f"{number(_RESIDUAL)}, {number(_CORRECTION)}",), "Residual and correction.")
    yield Block("CONTROLS", {"PARAMETERS": "CONTACT"}, (_CONTACT,))
    yield from blocks.loading(deck)
    pair = {"SLAVE": LOWER_FACE, "MASTER": UPPER_FACE, "FREQUENCY": AT_THE_END}
    yield Block("CONTACT FILE", {"FREQUENCY": AT_THE_END}, ("CDIS, CSTR",), "Contact values at the nodes of the lower face.")
    yield Block("CONTACT PRINT", pair, ("CF",), "Resultant of the contact: it must be P and Q.")
    yield Block("NODE PRINT", {"NSET": REFERENCE, "FREQUENCY": AT_THE_END}, ("U",), "Where the upper plane is.")
