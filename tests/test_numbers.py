"""The page of numbers and the ten of README say what docs/numbers.json holds, and every benchmark has its place there."""

import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def claims(monkeypatch_module: pytest.MonkeyPatch):
    monkeypatch_module.syspath_prepend(str(ROOT / "benchmarks"))
    import claims as module

    return module


@pytest.fixture(scope="module")
def monkeypatch_module():
    with pytest.MonkeyPatch.context() as patch:
        before = set(sys.modules)
        yield patch
        for name in set(sys.modules) - before:  # benchmarks have short names that must not shadow others
            if getattr(sys.modules[name], "__file__", "") and str(ROOT / "benchmarks") in str(sys.modules[name].__file__):
                del sys.modules[name]


@pytest.fixture(scope="module")
def kept(claims) -> dict:
    return json.loads(claims.STORE.read_text("utf-8"))


def test_readme_shows_the_ten_that_were_measured(claims, kept: dict) -> None:
    assert len(claims.TEN) == 10
    assert f"{claims.MARKS[0]}\n\n{claims.ten_of(kept)}\n\n{claims.MARKS[1]}" in claims.README.read_text("utf-8")


def test_the_page_holds_every_section_and_nothing_else(claims, kept: dict) -> None:
    page = claims.PAGE.read_text("utf-8")
    assert page.endswith(claims.page_of(kept).partition("\n\n## ")[2])
    assert {line.removeprefix("## ") for line in page.splitlines() if line.startswith("## ")} == set(kept)


def test_every_section_has_been_measured(claims, kept: dict) -> None:
    assert set(kept) == set(claims.sections())


def test_a_row_changed_by_hand_is_seen(claims, kept: dict) -> None:
    forged = json.loads(json.dumps(kept))
    title, what, _ = claims.TEN[0]
    next(row for row in forged[title]["rows"] if row["what"] == what)["measured"] = 1e-3
    assert claims.ten_of(forged) not in claims.README.read_text("utf-8")
    assert claims.page_of(forged).partition("\n\n## ")[2] not in claims.PAGE.read_text("utf-8")


def test_every_case_of_calculix_is_kept_by_the_name_that_measures_it(monkeypatch_module) -> None:
    monkeypatch_module.syspath_prepend(str(ROOT / "benchmarks"))
    import third

    kept = third.kept()
    assert set(kept) == set(third.cases())
    assert all(case["code"].startswith("CalculiX ") and case["day"] and case["errors"] for case in kept.values())
    assert third.main(["no such case"]) == 2
