"""Pages that are made from files and engines are current, and what pages point to exists."""

from __future__ import annotations

import ast
import hashlib
import html
import importlib
import json
import re
import sys
import tomllib
import unicodedata
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
sys.path.append(str(DOCS))
pages: Any = importlib.import_module("pages")
quoting: Any = importlib.import_module("quoting")
architecture: Any = importlib.import_module("architecture")

TEXTS = {
    str(path.relative_to(DOCS)): path.read_text(encoding="utf-8") for path in sorted([*DOCS.glob("*.md"), *DOCS.glob("api/*.md")])
}
PACKAGES = {"scenes", "semi_analytic", "meshes", "halfplane_fe", "reports"}
RENEW = "run `make pages`, and look at what moved"


@pytest.fixture(scope="module")
def made() -> dict[str, str]:
    return dict(pages.made())


@pytest.mark.parametrize("name", ["values.json", "verification.md", "gallery.md", "misprints.md", "third.md", "architecture.svg"])
def test_pages_are_what_files_and_engines_say(made: dict[str, str], name: str) -> None:
    stored = (DOCS / name).read_text(encoding="utf-8")
    assert pages.without_rounding(stored) == pages.without_rounding(made[name]), f"docs/{name} is stale: {RENEW}"


def test_rounding_alone_is_forgiven() -> None:
    assert pages.without_rounding("off by 3e-16 and 0") == pages.without_rounding("off by 0 and 2.5e-15")
    assert pages.without_rounding("off by 3e-06, 0.7270") == "off by 3e-06, 0.7270"


def numbers(text: str) -> list[str]:
    return re.findall(r"(?<!`)\{number\}`([^`]+)`", text)


def test_every_number_that_a_page_quotes_is_known() -> None:
    known = json.loads((DOCS / "values.json").read_text(encoding="utf-8"))["values"]
    quoted = {(name, key) for name, text in TEXTS.items() for key in numbers(text)}
    assert quoted
    assert not [pair for pair in quoted if pair[1] not in known]
    assert numbers("{number}`no such key`") == ["no such key"]


A_MAP = """# A map

**Is it?** It is off by -2 ± 1 %. More of it.

| figure | where | exponent |
| --- | --- | --- |
| work | low | 2.0 |
| work | high | no law |

| figure | where | constant |
| --- | --- | --- |
| work | low | -3.1e-05 |

| figure | exponent |
| --- | --- |
| work, low | 9 |
"""


def test_cells_and_sentences_of_a_map_have_keys_and_none_that_two_share() -> None:
    found = {key: entry["text"] for key, entry in quoting.map_values("m", A_MAP).items()}
    assert found == {
        "m: work, high: exponent": "no law",
        "m: work: where": "low",
        "m: work: constant": "−3.1e-05",
        "m: It is off by -2": "It is off by −2 ± 1 %.",
        "m: More of it.": "More of it.",
    }


def test_the_tables_of_the_third_opinion_are_what_was_measured_and_published() -> None:
    """Every case of benchmarks/third.json is in a table or quoted, and a figure changed by hand does not stay."""
    page, cases = TEXTS["third.md"], pages.third()
    rows = [line for line in page.splitlines() if line.count(" | ") == 9 and not line.startswith("| scene |")]
    for column in (3, 4, 5):
        cells = rows[0].split(" | ")
        forged = page.replace(rows[0], " | ".join([*cells[:column], "+99 %", *cells[column + 1 :]]))
        assert forged != page
        assert pages.third_opinion(forged) == page
    assert len(rows) > 30
    assert len(cases) == len(rows) + 1
    assert "{number}`CalculiX, cattaneo-mindlin, stick slope 50: shear`" in page


def test_a_claim_is_quoted_with_two_digits_its_unit_and_where_it_is_from() -> None:
    rows = [("a", 2.1766, "%"), ("b", 137.0, ""), ("c", -0.00061, ""), ("d", float("inf"), "")]
    kept = {"S": {"commit": "abc", "rows": [{"what": w, "measured": m, "unit": u, "how": "so"} for w, m, u in rows]}}
    found = quoting.claim_values(kept)
    assert [entry["text"] for entry in found.values()] == ["2.2 %", "137", "−0.00061", "inf"]
    assert found["S: a"]["source"] == "so; make numbers, on abc"


def test_what_the_report_says_of_calculix_is_what_was_measured() -> None:
    """The sentence on its friction history quotes the second revolutions."""
    source, cases = (ROOT / "reports" / "third" / "calculix.py").read_text(encoding="utf-8"), pages.third()
    varying, constant = (cases[f"{name}, 2 revolutions"]["errors"]["dissipation"] for name in ("hertz-paper", "cattaneo-mindlin"))
    assert f"{100 * varying:+.0f} % of the dissipation of" in source
    assert f"{100 * constant:+.0f} % of cattaneo-mindlin's" in source


def functions(path: Path) -> set[str]:
    """Names of a file's tests, those of classes as Class::test."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}::{inner.name}" for inner in node.body if isinstance(inner, ast.FunctionDef)}
    return found


def missing(tests: list[str]) -> list[str]:
    """Those that are not there; a file alone stands for all its tests."""
    lost = []
    for test in tests:
        file, _, name = test.partition("::")
        path = ROOT / "tests" / file
        if not path.is_file() or (name and name not in functions(path)):
            lost.append(test)
    return lost


def test_every_test_of_a_requirement_exists() -> None:
    rows = [row for area in pages.requirements().values() for row in area]
    assert len(rows) > 20
    assert all(row["tests"] for row in rows)
    assert not missing([test for row in rows for test in row["tests"]])
    assert missing(["test_docs_pages.py::test_no_such"]) == ["test_docs_pages.py::test_no_such"]


def test_the_architecture_is_that_of_the_contracts(tmp_path: Path) -> None:
    contracts = architecture.read(ROOT / "pyproject.toml")
    assert set(contracts.packages) == PACKAGES
    arrows = set(contracts.arrows())
    assert {
        ("reports", "semi_analytic"),
        ("reports", "halfplane_fe"),
        ("halfplane_fe", "meshes"),
        ("semi_analytic", "scenes"),
    } <= arrows
    assert not {("semi_analytic", "halfplane_fe"), ("halfplane_fe", "semi_analytic"), ("semi_analytic", "meshes")} & arrows
    other = (
        (ROOT / "pyproject.toml")
        .read_text(encoding="utf-8")
        .replace('"reports", "semi_analytic | halfplane_fe"', '"reports | halfplane_fe", "semi_analytic"')
    )
    (tmp_path / "pyproject.toml").write_text(other, encoding="utf-8")
    assert architecture.svg(tmp_path / "pyproject.toml") != architecture.svg(ROOT / "pyproject.toml")


def named(target: str) -> bool:
    """Whether a dotted name leads to something."""
    parts = target.split(".")
    for cut in range(len(parts) - 1, 0, -1):
        try:
            found: Any = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        for part in parts[cut:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


def test_every_formula_leads_to_a_function_that_is_shown() -> None:
    targets = set(re.findall(r"\{py:\w+\}`(?:[^`<]*<)?~?([\w.]+)>?`", TEXTS["theory.md"]))
    assert len(targets) > 15
    assert not [target for target in targets if not named(target)]
    shown = TEXTS["api/formulas.md"]
    assert not [target for target in targets if target not in shown and target.rpartition(".")[0] not in shown]
    assert not named("semi_analytic.hertz.no_such_function")


def test_each_package_has_its_page_of_public_names() -> None:
    assert {name[len("api/") : -len(".md")] for name in TEXTS if name.startswith("api/")} - {"formulas"} == PACKAGES
    assert all(f".. automodule:: {package}\n" in TEXTS[f"api/{package}.md"] for package in PACKAGES)


def test_the_citation_is_of_this_version() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f'version: "{version("halfplane")}"' in citation
    assert f"license: {tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']['license']}\n" in citation


def words(text: str) -> list[str]:
    """Words and numbers in lower case, without tags, escapes, LaTeX commands and the prefixes of Python's strings."""
    text = re.sub(r"<[^<>]{0,300}>|\\n|\\[a-zA-Z]+|\b[fr]{1,2}(?=[\"'])", " ", html.unescape(text))
    return re.findall(r"[a-z0-9]+", unicodedata.normalize("NFKD", text).lower())


def digest(run: str) -> bytes:
    """What tests/data/paper.bin holds of nine words."""
    return hashlib.blake2b(run.encode(), digest_size=5).digest()


def runs(found: list[str]) -> dict[bytes, str]:
    """Digest -> nine words that follow each other."""
    each = (" ".join(found[k : k + 9]) for k in range(len(found) - 8))
    return {digest(run): run for run in each}


def common(text: str, known: frozenset[bytes]) -> list[str]:
    """Runs of nine words of the text that are among the known ones."""
    return [run for key, run in runs(words(text)).items() if key in known]


def test_the_paper_is_quoted_nowhere() -> None:
    """No nine words in a row are the paper's, but for its title; formulas and numbers are left out."""
    stored = (ROOT / "tests" / "data" / "paper.bin").read_bytes()
    paper = frozenset(stored[k : k + 5] for k in range(0, len(stored), 5))
    assert len(paper) > 4000
    texts = {path: path.read_text(encoding="utf-8") for path in written()}
    assert {ROOT / "README.md", DOCS / "misprints.md", ROOT / "reports" / "paper" / "paper.toml"} <= texts.keys()
    found = {str(path.relative_to(ROOT)): quoted for path, text in texts.items() if (quoted := common(text, paper))}
    assert not found
    # A quotation is seen through line breaks, markup and the joints of strings.
    planted = frozenset(runs(["one", "two", "three", "four", "five", "six", "seven", "eight", "nine"]))
    assert common('("zero One two, *three*, four "\n f"five <b>six</b> seven-eight nine ten")', planted)
    assert not common("one two three four five six seven eight ten", planted)


def written() -> list[Path]:
    """What people wrote, and the pages that are made from it."""
    folders = [*sorted(PACKAGES), "benchmarks", "docs", "tests"]
    kinds = {".py", ".md", ".html", ".toml", ".txt", ".ipynb"}
    inside = [path for name in folders for path in (ROOT / name).rglob("*") if path.suffix in kinds and "_build" not in path.parts]
    return [*sorted(ROOT.glob("*.md")), *inside]
