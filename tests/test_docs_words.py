"""Phrases that no page, template, comment, docstring or message uses: each has a plain word that the field would search for."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
# Phrase -> what to write.
PHRASES = {
    "is told": "is reported, is stated",
    "are told": "are reported, are stated",
    "way in": "initial loading",
    "off by": "error of",
    "the system refuses": "cannot read FILE: reason",
    "has no use for": "unexpected argument",
    "suffers from": "likely cause",
    "goes on where": "resumes",
    "deaf to": "ignores",
    "anew": "again",
}
# Printed by benchmarks from stored results: words of the notes of that day.
PRINTED = ("docs/stress.md", "docs/numbers.md", "docs/performance.md")
PATTERN = re.compile("|".join(rf"\b{phrase.replace(' ', chr(92) + 's+')}\b" for phrase in PHRASES), re.I)
COMMENT = re.compile(r"<!--.*?-->", re.S)


def words_of(source: str) -> Iterator[str]:
    """Strings and docstrings of Python code, and its comments as one text. Names are no words: `way in ways`, `way_in`."""
    yield from (
        node.value for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant) and isinstance(node.value, str)
    )
    found = tokenize.generate_tokens(io.StringIO(source).readline)
    yield " ".join(token.string.lstrip("# ") for token in found if token.type == tokenize.COMMENT)


def pages() -> Iterator[tuple[str, str]]:
    """(path, text) of every page, template and library scene."""
    yield "README.md", (ROOT / "README.md").read_text(encoding="utf-8")
    folders = {
        "docs": {".md", ".ipynb"},
        "reports/templates": {".html", ".js", ".css", ".typ", ".toml", ".json"},
        "scenes/library": {".toml"},
    }
    for folder, kinds in folders.items():
        for path in sorted((ROOT / folder).rglob("*")):
            name = path.relative_to(ROOT).as_posix()
            if path.suffix in kinds and "_build" not in name and "docs/published" not in name and name not in PRINTED:
                yield name, COMMENT.sub("", path.read_text(encoding="utf-8"))


def code() -> Iterator[tuple[str, str]]:
    """(path, a string or all comments) of the five packages."""
    for package in ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports"):
        for path in sorted((ROOT / package).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            yield from ((name, words) for words in words_of(path.read_text(encoding="utf-8")))


def faults(texts: Iterator[tuple[str, str]]) -> list[str]:
    """Each phrase with its place and what to write instead."""
    return [
        f"{name}: ...{text[max(0, hit.start() - 40) : hit.end() + 20]}...: write {PHRASES[' '.join(hit[0].lower().split())]!r}"
        for name, text in texts
        for hit in PATTERN.finditer(text)
    ]


def test_no_page_and_no_template_uses_them() -> None:
    assert not faults(pages())


def test_no_string_docstring_or_comment_uses_them() -> None:
    texts = list(code())
    assert len(texts) > 2000
    assert not faults(iter(texts))


def test_each_phrase_is_seen_through_line_breaks_and_names_are_not() -> None:
    assert all(len(faults(iter([("page", f"It {phrase.replace(' ', chr(10))} x.")]))) == 1 for phrase in PHRASES)
    source = 'x = f"{x} is off "  "by {x}"\n# suffers\n# from it\nfor way in ways: way_in = "way_in"\n'
    assert len(faults(("code", words) for words in words_of(source))) == 2
    assert {"README.md", "docs/index.md", "reports/templates/scene.toml", "scenes/library/blocks.toml"} <= {
        name for name, _ in pages()
    }


# Pages that commands write as a whole: evidence, which has a limit of its own, and lists of what the library and the models hold.
EVIDENCE = ("numbers", "verification", "scenes", "performance", "stress")
LISTS = ("scene-keys", "gallery", "misprints", "licences", "changelog")
NOT_BY_HAND = re.compile(r"<!-- ([\w ]+): written by `make pages` -->.*?<!-- end of \1 -->|^```.*?^```|<!--.*?-->", re.S | re.M)


def count(text: str) -> int:
    """Words of a page, outside code blocks, comments and tables that commands write; a bar of a table is no word."""
    text = re.sub(r"^```\{glossary\}(.*?)^```", r"\1", text, flags=re.S | re.M)
    return sum(bool(re.search(r"\w", word)) for word in NOT_BY_HAND.sub("", text).split())


def test_the_manual_stays_short() -> None:
    by_hand = [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "api").glob("*.md")]
    by_hand = [path for path in by_hand if path.stem not in {*EVIDENCE, *LISTS} or path.parent.name == "api"]
    assert len(by_hand) > 30
    # 19,600 words without measured data, fits, loops, stress at the edge and uncertainty, which take 2,800 more.
    assert sum(count(path.read_text(encoding="utf-8")) for path in by_hand) <= 22_600
    evidence = [(ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8") for name in EVIDENCE]
    assert sum(len(text.split()) for text in evidence) <= 15_000
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= 900
    table = "<!-- a table: written by `make pages` -->\n| one | two |\n<!-- end of a table -->"
    assert count(f"a b | c <!-- n:x y -->1<!-- /n -->\n```sh\nd e\n```\n{table} f\n") == 5
