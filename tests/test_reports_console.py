"""Tables on the terminal: within its width, and no word broken while every word has a place."""

import re

import pytest

from reports.comparison.words import narrow
from reports.console import show_table

HEADS = ("metric", "E", "mesh", "penalty", "step", "far field", "idealisation", "± u", "verdict", "accurate")
ROWS = [
    ("Peak pressure", "+0.691 %", "± 0.033 %", "none", "0 ± 0", "± 0.0045 %", "+0.69 %", "0.033 %", "resolved", "outside"),
    ("Contact edge", "−0.759 %", "± 3.4 %", "none", "0 ± 0", "+0.0089 % ± 0.0036 %", "−0.77 %", "3.4 %", "not resolved", "within"),
    ("Pointwise dissipation", "0", "0 ± 0", "none", "0 ± 0", "0 ± 0", "0", "0", "not resolved", "–"),
]


def shown(capsys: pytest.CaptureFixture[str], columns: int, heads: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", str(columns))
        show_table("Where the discrepancy comes from", heads, rows)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines[1:])) <= columns
    return lines


def test_a_budget_fits_80_columns_with_its_words_whole(capsys: pytest.CaptureFixture[str]) -> None:
    """It was "penal|ty", "ideal|isati|on", "Dissip|ation"."""
    heads, rows = narrow(HEADS, ROWS)
    assert not {"penalty", "accurate"} & set(heads)  # none everywhere; in the table above it
    assert all(len(row) == len(heads) for row in rows)
    pieces = {word for line in shown(capsys, 80, heads, rows) for word in re.split(r"[\s│┃]+", line)}
    assert {word for row in (heads, *rows) for cell in row for word in cell.split()} <= pieces


def test_a_long_word_is_folded_and_a_table_that_fits_is_as_wide_as_its_cells(capsys: pytest.CaptureFixture[str]) -> None:
    assert sum(line.count("a") for line in shown(capsys, 30, ("file", "size"), [("a" * 60, "1")])[5:]) == 60
    assert any("│two words │ 3    │" in line for line in shown(capsys, 80, ("what", "value"), [("two words", "3")]))
