"""The rows of the paper's two tables: words from paper.toml, numbers from rules, and how numbers
become verdicts.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import Any, TypeVar

# Relative error up to which a mended formula agrees with the engine.
AGREEMENT_TOLERANCE = 1e-9
# Relative error from which a formula as printed disagrees with the engine.
LEAST_MISPRINT_ERROR = 1e-3
PAPER_WORDS: dict[str, list[dict[str, str]]] = tomllib.loads(
    Path(__file__).with_name("paper.toml").read_text(encoding="utf-8")
)
_PROVEN = {True: "yes", False: "no", None: "by reading"}


class Verdict(StrEnum):
    """What the engine makes of a statement of the paper."""

    CONFIRMED = "confirmed"
    REFINED = "refined"
    CONTRADICTED = "contradicted"


@dataclass(frozen=True)
class Statement:
    """A statement of the paper with what the engine computes."""

    key: str
    where: str  # place in the paper
    words: str  # what the paper states, in our words
    computed: str  # what the engine says, with numbers
    verdict: Verdict  # follows from `values`
    values: Mapping[str, float]


@dataclass(frozen=True)
class Misprint:
    """A misprint of the paper with the numbers that prove it."""

    key: str
    where: str  # place in the paper
    printed: str  # the reading as printed: formulas as they are, the rest in our words
    right: str
    proof: str  # what was evaluated, with numbers
    proven: bool | None  # follows from `values`; None: there is nothing to evaluate
    values: Mapping[str, float]


Row = TypeVar("Row", Statement, Misprint)
# The verdict, or whether the misprint is proven, and what the words of its row name.
VerdictAndNumbers = tuple[Any, dict[str, Any]]


def fill_in(text: str, values: Mapping[str, Any]) -> str:
    """A text of the file paper.toml with each {name:format} replaced by the value of that name.

    Formats are Python's, or "small" for one digit. A name may hold any character but : and braces.
    `values` may be numbers or text.

    >>> fill_in("error {error at a/b:small}", {"error at a/b": 3.14e-15})
    'error 3e-15'
    """

    def formatted_value(match: re.Match[str]) -> str:
        """The value for a name and a format in braces, as text; `match` has both as groups."""
        name = match[1]
        number_format = match[2]
        if number_format == "small":
            return _small(values[name])
        return format(values[name], number_format or "")

    return re.sub(r"\{([^{}:]+)(?::([^{}]*))?\}", formatted_value, text)


def table_row(kind: type[Row], words: Mapping[str, str], judgement: VerdictAndNumbers) -> Row:
    """A row of the paper's table of statements or of that of misprints, as a record of this `kind`.

    `words` are the row's texts in paper.toml by the names of the record's fields, and "text", into
    which values of the judgement are filled. `judgement` is the verdict, or whether the misprint is
    proven, and values by name, which are numbers or text.
    """
    verdict, values = judgement
    numbers = {name: value for name, value in values.items() if not isinstance(value, str)}
    # the last three fields of both records are text, verdict and numbers
    cells: list[Any] = [words[field.name] for field in fields(kind)[:-3]]
    cells += [fill_in(words["text"], values), verdict, numbers]
    return kind(*cells)


def verdict_of_condition(holds: bool, nearly_holds: bool = False) -> Verdict:
    """Verdict on a statement: confirmed if its condition holds, refined if a weaker one does
    (`nearly_holds`), else contradicted.

    >>> verdict_of_condition(False, nearly_holds=True).value
    'refined'
    """
    if holds:
        return Verdict.CONFIRMED
    return Verdict.REFINED if nearly_holds else Verdict.CONTRADICTED


def verdict_of_number(
    computed_value: float, printed_value: float, digits: int, slack: float = 0.02
) -> Verdict:
    """Verdict on a number that the paper prints, `printed_value`, by the computed one. It is
    "confirmed" if this rounds to the printed one at `digits` decimals, "refined" if the relative
    difference is at most `slack`, else "contradicted".

    >>> (
    ...     verdict_of_number(0.72705, 0.73, 2).value,
    ...     verdict_of_number(0.8742, 0.88, 2).value,
    ...     verdict_of_number(0.557, 5.0, 0).value,
    ... )
    ('confirmed', 'refined', 'contradicted')
    """
    rounds_to_printed = round(computed_value, digits) == printed_value
    # confirmed if the first holds, refined if `nearly_holds` does
    return verdict_of_condition(
        rounds_to_printed,
        nearly_holds=abs(computed_value - printed_value) <= slack * abs(printed_value),
    )


def _small(value: float) -> str:
    """A discrepancy to one digit; nothing at all is 0.

    >>> _small(0.0), _small(3.14e-15)
    ('0', '3e-15')
    """
    return "0" if value == 0 else f"{value:.0e}"


def is_misprint_proven(mended_error: float, printed_error: float) -> bool:
    """Whether the relative errors of the mended and the printed formula prove a misprint: the
    mended one is at most 1e-9, the printed one above 1e-3.

    >>> (
    ...     is_misprint_proven(1e-12, 0.5),
    ...     is_misprint_proven(1e-5, 0.5),
    ...     is_misprint_proven(1e-12, 1e-6),
    ... )
    (True, False, False)
    """
    # not <=: a printed formula without a real value (NaN) counts as an error too
    # AGREEMENT_TOLERANCE, LEAST_MISPRINT_ERROR: 1e-9 and 1e-3
    return bool(mended_error <= AGREEMENT_TOLERANCE and not printed_error <= LEAST_MISPRINT_ERROR)


def proven_in_words(table_row: Misprint) -> str:
    """Whether a misprint is proven, in words: "yes", "no", or "by reading" where there is nothing
    to evaluate.
    """
    return _PROVEN[table_row.proven]


def as_columns(rows: Sequence[Statement] | Sequence[Misprint], key: str) -> dict[str, list[str]]:
    """Columns of the table of statements or of misprints for CSV: heading -> cells. `key` is the
    heading of the first column.
    """
    heads = {"key": key, "words": "the paper", "values": "numbers"}
    columns = {}
    for field in fields(rows[0]):
        cells = [_cell(getattr(table_row, field.name)) for table_row in rows]
        columns[heads.get(field.name, field.name)] = cells
    return columns


def _cell(value: Any) -> str:
    """Text of a cell: of numbers by name, of words, or of whether a misprint is proven."""
    if isinstance(value, Mapping):
        return "; ".join(f"{name} = {number!r}" for name, number in value.items())
    return value if isinstance(value, str) else _PROVEN[value]
