"""The pages' examples run, print what the page says and draw what it shows. `make pages` writes both anew."""

from __future__ import annotations

import importlib
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[1] / "docs"
sys.path.append(str(DOCS))
executed = importlib.import_module("executed")

PAGES = {path.name: path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("*.md"))}
RUNNABLE = [name for name, text in PAGES.items() if executed.runnable(text)]
NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
HUNDREDTH = 0.02  # of a point; another processor turns a last digit round


def same_drawing(one: str, other: str) -> bool:
    """Whether two drawings have the same elements and words, with numbers that differ by no more than is seen."""
    if [(element.tag, element.text) for element in ET.fromstring(one).iter()] != [
        (element.tag, element.text) for element in ET.fromstring(other).iter()
    ]:
        return False
    numbers = [
        np.array([float(word) for word in NUMBER.findall(re.sub(r'(id|href)="[^"]*"|url\([^)]*\)', "", text))])
        for text in (one, other)
    ]
    return len(numbers[0]) == len(numbers[1]) and bool(np.all(np.abs(numbers[0] - numbers[1]) <= HUNDREDTH))


@pytest.mark.parametrize("name", RUNNABLE)
def test_a_page_says_what_its_blocks_print(name: str, tmp_path: Path) -> None:
    assert executed.run(PAGES[name], tmp_path) == PAGES[name], f"docs/{name} is stale: run `make pages` and look at what moved"
    for picture in tmp_path.glob("*.svg"):
        kept = (DOCS / "figures" / picture.name).read_text(encoding="utf-8")
        assert same_drawing(kept, picture.read_text(encoding="utf-8")), f"docs/figures/{picture.name} is stale: run `make pages`"
        assert f"figures/{picture.name}" in PAGES[name]


def test_the_manual_has_examples_in_its_tutorial_and_every_how_to() -> None:
    wanted = {"quick-start", "tutorial", "theory", "score-abaqus", "own-profile", "measured-loads", "cluster-sweep"}
    assert {f"{name}.md" for name in (*wanted, "read-the-error-budget", "penalty-or-lagrangian")} <= set(RUNNABLE)


def test_every_picture_of_a_page_is_there_and_every_figure_is_shown() -> None:
    shown = {target for text in PAGES.values() for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)}
    assert not [target for target in shown if not (DOCS / target).is_file()]
    assert {f"figures/{path.name}" for path in (DOCS / "figures").iterdir()} <= shown


class TestPlanted:
    """What must not pass."""

    def test_another_number_is_seen(self, tmp_path: Path) -> None:
        page = "```python\nprint(1 + 1)\n```\n\n```text\n3\n```\n"
        assert executed.run(page, tmp_path) == page.replace("3", "2")

    def test_text_that_is_no_output_is_left_alone(self, tmp_path: Path) -> None:
        page = "```python\nprint(1)\n```\n\nLook:\n\n```text\nanything\n```\n"
        assert executed.run(page, tmp_path) == page

    def test_a_block_that_fails_is_a_failure(self, tmp_path: Path) -> None:
        with pytest.raises(ZeroDivisionError):
            executed.run("```python\n1 / 0\n```\n", tmp_path)

    def test_a_command_ends_as_the_page_says(self, tmp_path: Path) -> None:
        with pytest.raises(executed.StaleError, match="ended with 2"):
            executed.run("```console\n$ halfplane check nothing.toml\n```\n", tmp_path)
        page = "```console\n$ halfplane check nothing.toml # ends with 2\n```\n"
        assert executed.run(page, tmp_path) == page

    def test_a_block_with_a_caption_is_a_file(self, tmp_path: Path) -> None:
        page = "```{code-block} toml\n:caption: a.toml\n\nx = 1\n```\n\n"
        page += '```python\nfrom pathlib import Path\nprint(Path("a.toml").read_text(), end="")\n```\n\n```text\n?\n```\n'
        assert executed.run(page, tmp_path) == page.replace("?", "x = 1")

    def test_a_curve_that_moved_is_seen(self) -> None:
        drawing = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M 1.00 2.00 L 3 4"/><text>a</text></svg>'
        assert same_drawing(drawing, drawing.replace("1.00", "1.001"))
        assert not same_drawing(drawing, drawing.replace("1.00", "1.10"))
        assert not same_drawing(drawing, drawing.replace(">a<", ">b<"))
