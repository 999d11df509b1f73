"""The rows of the paper's two tables, and the rules that turn numbers into verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """What the engine makes of a statement of the paper."""

    CONFIRMED = "confirmed"
    REFINED = "refined"
    CONTRADICTED = "contradicted"


@dataclass(frozen=True)
class Statement:
    """A statement of the paper with what the engine computes.

    Attributes
    ----------
    key : short name; where : place in the paper; words : what the paper states, in our words
    computed : what the engine says, with numbers; verdict : follows from `values`; values : the numbers themselves
    """

    key: str
    where: str
    words: str
    computed: str
    verdict: Verdict
    values: Mapping[str, float]


@dataclass(frozen=True)
class Misprint:
    """A misprint of the paper with the numbers that prove it.

    Attributes
    ----------
    key : short name; where : place in the paper; printed, right : the two readings, formulas as they are, the rest in our words
    proof : what was evaluated, with numbers; proven : follows from `values`, None where there is nothing to
        evaluate; values : the numbers themselves
    """

    key: str
    where: str
    printed: str
    right: str
    proof: str
    proven: bool | None
    values: Mapping[str, float]


def judge(holds: bool, nearly: bool = False) -> Verdict:
    """Confirmed if it holds, refined if it nearly does, else contradicted.

    >>> judge(False, nearly=True).value
    'refined'
    """
    return Verdict.CONFIRMED if holds else Verdict.REFINED if nearly else Verdict.CONTRADICTED


def judge_number(computed: float, printed: float, digits: int, slack: float = 0.02) -> Verdict:
    """Confirmed if `computed` rounds to `printed` at that many decimal digits, refined within a share `slack`, else contradicted.

    >>> judge_number(0.72705, 0.73, 2).value, judge_number(0.8742, 0.88, 2).value, judge_number(0.557, 5.0, 0).value
    ('confirmed', 'refined', 'contradicted')
    """
    return judge(round(computed, digits) == printed, abs(computed - printed) <= slack * abs(printed))


def small(value: float) -> str:
    """A discrepancy to one digit; nothing at all is 0.

    >>> small(0.0), small(3.14e-15)
    ('0', '3e-15')
    """
    return "0" if value == 0 else f"{value:.0e}"


EXACT, APART = 1e-9, 1e-3
"""A mended formula agrees with the engine to EXACT; a misprint is off by more than APART: both shares of the right value."""


def proves(right_error: float, printed_error: float) -> bool:
    """Whether two relative errors prove a misprint.

    >>> proves(1e-12, 0.5), proves(1e-5, 0.5), proves(1e-12, 1e-6)
    (True, False, False)
    """
    return bool(right_error <= EXACT and not printed_error <= APART)


def proven_in_words(row: Misprint) -> str:
    """Yes, no, or by reading."""
    return {True: "yes", False: "no", None: "by reading"}[row.proven]


def statements_table(rows: Sequence[Statement]) -> dict[str, list[str]]:
    """Columns for CSV."""
    return {
        "statement": [row.key for row in rows],
        "where": [row.where for row in rows],
        "the paper": [row.words for row in rows],
        "computed": [row.computed for row in rows],
        "verdict": [row.verdict.value for row in rows],
        "numbers": [_numbers(row.values) for row in rows],
    }


def misprints_table(rows: Sequence[Misprint]) -> dict[str, list[str]]:
    """Columns for CSV."""
    return {
        "misprint": [row.key for row in rows],
        "where": [row.where for row in rows],
        "printed": [row.printed for row in rows],
        "right": [row.right for row in rows],
        "proof": [row.proof for row in rows],
        "proven": [proven_in_words(row) for row in rows],
        "numbers": [_numbers(row.values) for row in rows],
    }


def _numbers(values: Mapping[str, float]) -> str:
    return "; ".join(f"{name} = {value!r}" for name, value in values.items())
