"""A deck as text: the blocks in their order, with what a dialect says in its own words handed in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from reports.third import blocks
from reports.third.blocks import CONTACT, Block, number
from reports.third.deck import Deck


@dataclass(frozen=True)
class Dialect:
    """What one code says otherwise than another.

    Attributes
    ----------
    about : lines of the header
    interaction : data of *SURFACE INTERACTION
    friction : the block of a scene that has friction
    loaded : what the first step under the scene's loads says and the others keep
    """

    about: tuple[str, ...]
    interaction: tuple[str, ...]
    friction: Callable[[Deck], Block]
    loaded: Callable[[Deck], Iterator[Block]]


def deck_text(dialect: Dialect, deck: Deck, command: str, versions: Mapping[str, str]) -> str:
    """The text of the input file."""
    lines = [*blocks.header(deck, dialect.about, command, versions)]
    for block in _blocks(dialect, deck):
        lines.extend(block.text())
    return "\n".join(lines) + "\n"


def _blocks(dialect: Dialect, deck: Deck) -> Iterator[Block]:
    yield from blocks.geometry(deck)
    yield from blocks.sections(deck)
    yield Block("SURFACE INTERACTION", {"NAME": CONTACT}, dialect.interaction)
    words = blocks.stiffness_words(deck)
    yield Block("SURFACE BEHAVIOR", {"PRESSURE-OVERCLOSURE": "LINEAR"}, (number(deck.stiffness),), words)
    if deck.scene.friction.coefficient > 0:
        yield dialect.friction(deck)
    yield blocks.pairing()
    yield from blocks.upper_plane(deck)
    yield blocks.lower_support(deck)
    yield from blocks.amplitudes(deck)
    yield from blocks.touch(deck)
    yield Block("END STEP")
    yield from blocks.history(deck, dialect.loaded(deck))
