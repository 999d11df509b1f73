"""A deck as text, for CalculiX or Abaqus: `reports/templates/deck.inp` is the deck, and this is what it calls for.

The dialects differ in the form of friction (stick slope or elastic slip), the data of the interaction, and the output requests.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.charts.templating import template
from reports.third.deck import Deck, DeckBody

Array = NDArray[np.float64]
Dialect = Literal["calculix", "abaqus"]

# The longest line that CalculiX reads.
_LINE = 132


def deck_text(deck: Deck, dialect: Dialect, command: str = "", versions: Mapping[str, str] | None = None) -> str:
    """The text of the input file; `command` and `versions` go into its first comment."""
    told = ", ".join(f"{name} {version}" for name, version in (versions or {}).items())
    tools = (amplitudes, elastic_slip, equations_of, held_of, number, one_line, rows)
    known = {tool.__name__: tool for tool in tools}
    text = template("deck.inp").render(deck=deck, dialect=dialect, command=command, versions=told, **known)
    lines: list[str] = []
    for line in text.split("\n"):
        comment = textwrap.wrap(line[2:].strip(), _LINE - 7, break_on_hyphens=False) if line.startswith("**") else None
        lines += [line] * bool(line) if comment is None else [f"** {part}" for part in comment]
    return "\n".join(lines) + "\n"


def one_line(text: str) -> str:
    """What stands outside of our hands on one line: the next could begin a card."""
    return " ".join(text.split())


def number(value: float) -> str:
    """Thirteen digits and twenty characters at most, which is what CalculiX reads; always with a point.

    >>> number(0.1), number(-1234.5), number(1e-20), number(2)
    ('0.1', '-1234.5', '1.e-20', '2.')
    """
    mantissa, _, exponent = f"{value:.13g}".partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.") + (f"e{exponent}" if exponent else "")


def rows(values: ArrayLike, per_line: int) -> str:
    """Data lines of so many integers or numbers each."""
    flat = np.ravel(values)
    words = [str(v) if flat.dtype.kind == "i" else number(v) for v in flat.tolist()]
    return "\n".join(", ".join(words[k : k + per_line]) for k in range(0, len(words), per_line))


def elastic_slip(deck: Deck) -> float:
    """Slip [length] at which the friction of the mean pressure, f P/(2 a), is reached at the deck's stick slope."""
    return deck.scene.friction.coefficient * deck.mean_pressure / deck.stick_slope


def amplitudes(deck: Deck) -> dict[str, Array]:
    """(n + 1, 2) total time and loads, bulk stress, tilt and moment: strains and tilt times a, so that they move a node."""
    found, size = {"NORMAL_LOAD": deck.normal_load, "TANGENTIAL_LOAD": deck.tangential_load}, deck.scales.half_width
    for body, name in enumerate(("LOWER", "UPPER")):
        if (strain := deck.strain(body)) is not None:
            found[f"{name}_STRAIN"] = strain * size
        found |= zip((f"{name}_LEFT_END", f"{name}_RIGHT_END"), deck.end_stresses(body) or (), strict=False)
    if deck.tilt is not None:
        found["TILT"] = deck.tilt * size
    if deck.moment is not None:
        found["MOMENT"] = deck.moment / size
    return {name: np.stack([deck.deck_time, values], axis=1) for name, values in found.items()}


def _tied(deck: Deck, body: DeckBody) -> Iterator[list[tuple[int, int, float]]]:
    """For each node and direction of a far side, by directions, the terms (node, direction, factor) that add up to 0.

    It moves as the rigid plane (of the upper body), by the bulk strain of its half-plane and by the plane's turn. With one term it
    stands still: on the lower half-plane's arc bulk strain leaves the middle alone.
    """
    size, which = deck.scales.half_width, int(body is deck.upper)
    ratio = (deck.scene.material.lower, deck.scene.material.upper)[which].poisson_ratio
    for direction, nodes in sorted(body.held.items()):
        for node in nodes.tolist():
            x, y = body.nodes[node - body.first_node].tolist()
            terms = [(node, direction, 1.0)]
            if which:
                terms.append((deck.reference, direction, -1.0))
            if deck.strain(which) is not None:
                # A uniform stress along x in plane strain: u_x = eps x, u_y = -nu/(1 - nu) eps y.
                share = -x if direction == 1 else ratio / (1 - ratio) * y
                terms.append((deck.strained, which + 1, share / size))
            if which and (deck.tilt is not None or deck.moment is not None):
                # A turn that opens the gap at x > 0: u_x = -alpha y, u_y = alpha x.
                terms.append((deck.turning, 1, (y if direction == 1 else -x) / size))
            yield [term for term in terms if term[2]]


def equations_of(deck: Deck, body: DeckBody) -> Iterator[str]:
    """Data lines of the equations of a far side, those of each direction together."""
    tied = (terms for terms in _tied(deck, body) if len(terms) > 1)
    for _, own in groupby(tied, lambda terms: terms[0][1]):
        yield "\n".join(f"{len(terms)}\n" + ", ".join(f"{of}, {way}, {number(k)}" for of, way, k in terms) for terms in own)


def held_of(deck: Deck) -> list[str]:
    """Nodes of the lower body that stand still, and movements that mean nothing of the nodes for bulk strain and tilt."""
    found = [f"{terms[0][0]}, {terms[0][1]}" for terms in _tied(deck, deck.lower) if len(terms) == 1]
    unstrained = [deck.strain(body) is None for body in (0, 1)]
    found += [f"{deck.strained}, {body + 1}" for body in (0, 1) if unstrained[body] and not all(unstrained)]
    return found + ([f"{deck.turning}, 2"] if deck.tilt is not None or deck.moment is not None else [])
