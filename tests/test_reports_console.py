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


def shown(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return capsys.readouterr().out.splitlines()


def test_a_budget_fits_80_columns_with_its_words_whole(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """It was "penal|ty", "ideal|isati|on", "Dissip|ation"."""
    monkeypatch.setenv("COLUMNS", "80")
    heads, rows = narrow(HEADS, ROWS)
    assert "penalty" not in heads  # none everywhere
    assert "accurate" not in heads  # in the table above it
    assert all(len(row) == len(heads) for row in rows)
    show_table("Where the discrepancy comes from", heads, rows)
    lines = shown(capsys)
    assert max(map(len, lines)) <= 80
    pieces = {word for line in lines for word in re.split(r"[\s│┃]+", line)}
    assert {word for row in (heads, *rows) for cell in row for word in cell.split()} <= pieces


def test_a_word_longer_than_the_terminal_is_folded(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    show_table("Files", ("file", "size"), [("a" * 60, "1")])
    lines = shown(capsys)
    assert max(map(len, lines)) <= 30
    assert sum(line.count("a") for line in lines[4:]) == 60


def test_a_table_that_fits_is_as_wide_as_its_cells(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    show_table("", ("what", "value"), [("two words", "3")])
    assert any("│two words │ 3    │" in line for line in shown(capsys))
