"""A strict reader of input decks: a closed set of keywords, their parameters and their data, for CalculiX and Abaqus."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

LINE, NUMBER = 132, 20

# keyword -> (parameters needed, parameters allowed on top, kinds of the entries of a data line: i integer, f number with a point,
# n any number, w word; "+" for any count of them). "" has no data line.
_BOTH = {
    "HEADING": ((), (), "text"),
    "NODE": (("NSET",), (), "ifff"),
    "ELEMENT": (("TYPE", "ELSET"), (), "iiiii"),
    "NSET": (("NSET",), (), "i+"),
    "SURFACE": (("NAME", "TYPE"), (), "iw"),
    "MATERIAL": (("NAME",), (), ""),
    "ELASTIC": ((), (), "ff"),
    "SOLID SECTION": (("ELSET", "MATERIAL"), (), "f"),
    "SURFACE BEHAVIOR": (("PRESSURE-OVERCLOSURE",), (), "f"),
    "CONTACT PAIR": (("INTERACTION", "TYPE"), (), "ww"),
    "EQUATION": ((), (), "equation"),
    "AMPLITUDE": (("NAME", "TIME"), (), "f+"),
    "STEP": (("NLGEOM", "INC"), (), ""),
    "STATIC": ((), (), "ffff"),
    "BOUNDARY": ((), ("OP",), "boundary"),
    "CLOAD": (("AMPLITUDE",), (), "iif"),
    "END STEP": ((), (), ""),
}
CALCULIX = _BOTH | {
    "SURFACE INTERACTION": (("NAME",), (), ""),
    "FRICTION": ((), (), "ff"),
    "CONTROLS": (("PARAMETERS",), (), "n+"),
    "CONTACT FILE": (("FREQUENCY",), (), "w+"),
    "CONTACT PRINT": (("SLAVE", "MASTER", "FREQUENCY"), (), "w+"),
    "NODE PRINT": (("NSET", "FREQUENCY"), (), "w+"),
}
ABAQUS = _BOTH | {
    "SURFACE INTERACTION": (("NAME",), (), "f"),
    "FRICTION": (("ELASTIC SLIP",), (), "f"),
    "OUTPUT": (("FREQUENCY",), ("FIELD", "HISTORY"), ""),
    "CONTACT OUTPUT": (("NSET",), (), "w+"),
    "NODE OUTPUT": ((), ("NSET",), "w+"),
}
_IN_STEP = {"STATIC", "CLOAD", "CONTROLS", "END STEP"}
_ONLY_BEFORE = {"NODE", "ELEMENT", "NSET", "SURFACE", "MATERIAL", "ELASTIC", "EQUATION", "AMPLITUDE", "CONTACT PAIR"}


class DeckError(ValueError):
    """A line that is not in the closed set, with its number."""


@dataclass(frozen=True)
class Card:
    """A keyword with its parameters, its data lines as words, and its line."""

    keyword: str
    parameters: Mapping[str, str]
    data: tuple[tuple[str, ...], ...]
    line: int

    def numbers(self) -> list[float]:
        return [float(word) for row in self.data for word in row]


def parse(text: str, keywords: Mapping[str, tuple]) -> list[Card]:
    """The cards of a deck; DeckError at the first line that is not allowed."""
    cards: list[tuple[str, dict[str, str], list[tuple[str, ...]], int]] = []
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > LINE:
            raise DeckError(f"line {number}: {len(line)} characters")
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            cards.append((*_keyword(line, number, keywords), [], number))
        elif not line.strip() or not cards:
            raise DeckError(f"line {number}: neither keyword nor data")
        else:
            cards[-1][2].append(tuple(word.strip() for word in line.rstrip(",").split(",")))
    found = [Card(keyword, parameters, tuple(data), line) for keyword, parameters, data, line in cards]
    for card in found:
        _check_data(card, keywords[card.keyword][2])
    _check_order(found)
    return found


def _keyword(line: str, number: int, keywords: Mapping[str, tuple]) -> tuple[str, dict[str, str]]:
    name, *words = (part.strip() for part in line[1:].split(","))
    if name not in keywords:
        raise DeckError(f"line {number}: unknown keyword {name}")
    parameters = {key.strip(): value.strip() for key, _, value in (word.partition("=") for word in words)}
    needed, more, _ = keywords[name]
    if missing := set(needed) - set(parameters):
        raise DeckError(f"line {number}: *{name} lacks {missing}")
    if unknown := set(parameters) - set(needed) - set(more):
        raise DeckError(f"line {number}: *{name} has no parameter {unknown}")
    return name, parameters


def _check_data(card: Card, kinds: str) -> None:
    if kinds == "text":
        return
    if kinds == "equation":
        for head, row in zip(card.data[::2], card.data[1::2], strict=True):
            _check_row(card, row, "iif" * int(head[0]))
        return
    if bool(card.data) != bool(kinds):
        raise DeckError(f"line {card.line}: *{card.keyword} with {len(card.data)} data lines")
    for row in card.data:
        if kinds == "boundary":
            _check_row(card, row, {2: "ii", 4: "iiif"}.get(len(row), "i"))
        else:
            _check_row(card, row, kinds[0] * len(row) if kinds.endswith("+") else kinds)


def _check_row(card: Card, row: tuple[str, ...], kinds: str) -> None:
    if len(row) != len(kinds):
        raise DeckError(f"*{card.keyword} of line {card.line}: {len(row)} entries, {len(kinds)} wanted: {row}")
    for word, kind in zip(row, kinds, strict=True):
        try:
            good = _is(word, kind)
        except ValueError:
            good = False
        if not good or len(word) > NUMBER:
            raise DeckError(f"*{card.keyword} of line {card.line}: {word!r} is no {kind} of at most {NUMBER} characters")


def _is(word: str, kind: str) -> bool:
    """Whether a word is of a kind; ValueError where it is no number."""
    if kind == "w":
        return word.replace("_", "A").isupper()
    if kind == "i":
        return str(int(word)) == word
    return math.isfinite(float(word)) and (kind == "n" or "." in word)


def _check_order(cards: list[Card]) -> None:
    inside = False
    for card in cards:
        if card.keyword == "STEP":
            if inside:
                raise DeckError(f"line {card.line}: a step inside a step")
            inside = True
        elif (card.keyword in _IN_STEP and not inside) or (card.keyword in _ONLY_BEFORE and inside):
            raise DeckError(f"line {card.line}: *{card.keyword} on the wrong side of *STEP")
        elif card.keyword == "END STEP":
            inside = False
    if inside:
        raise DeckError("the last step does not end")


def by_name(cards: list[Card], keyword: str, parameter: str) -> dict[str, Card]:
    """Cards of a keyword by the value of a parameter."""
    return {card.parameters[parameter]: card for card in cards if card.keyword == keyword}


def common_part(text: str, stick_slope: float) -> str:
    """The Abaqus deck without its output requests and with CalculiX' form of friction: what CalculiX can run."""
    lines: list[str] = []
    keyword = ""
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            keyword = line[1:].split(",")[0].strip()
            if keyword not in {"OUTPUT", "CONTACT OUTPUT", "NODE OUTPUT"}:
                lines.append("*FRICTION" if keyword == "FRICTION" else line)
        elif keyword == "FRICTION":
            lines.append(f"{line}, {stick_slope:.8e}")
        elif keyword not in {"OUTPUT", "CONTACT OUTPUT", "NODE OUTPUT", "SURFACE INTERACTION"}:
            lines.append(line)
    return "\n".join(lines) + "\n"
