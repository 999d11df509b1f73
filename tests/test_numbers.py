"""The page of numbers says what docs/numbers.json holds, and every benchmark has its place there."""

import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def monkeypatch_module():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "benchmarks"))
        before = set(sys.modules)
        yield patch
        for name in set(sys.modules) - before:  # benchmarks have short names that must not shadow others
            if str(ROOT / "benchmarks") in str(getattr(sys.modules[name], "__file__", "")):
                del sys.modules[name]


@pytest.fixture(scope="module")
def claims(monkeypatch_module: pytest.MonkeyPatch):
    import claims as module

    return module


@pytest.fixture(scope="module")
def kept(claims) -> dict:
    return json.loads(claims.STORE.read_text("utf-8"))


def body(page: str) -> str:
    """The page below its head, which names the machine."""
    return page.partition("\n\n## ")[2]


def test_the_page_is_what_was_measured_in_at_most_60_rows(claims, kept: dict) -> None:
    assert len(claims.TEN) == 10
    page = claims.PAGE.read_text("utf-8")
    assert body(page) == body(claims.page_of(kept))
    rows = [line for line in page.splitlines() if line.startswith("| ")]
    assert len(rows) - page.count("|---|\n") <= claims.MOST_ROWS
    assert all(f"| {title} | {len(kept[title]['rows'])} |" in page for title in claims.SECTIONS)


def test_every_section_has_been_measured_and_has_its_function(claims, kept: dict) -> None:
    assert set(kept) == set(claims.SECTIONS)
    assert all(callable(claims.section(title)) for title in claims.SECTIONS)


def test_a_row_changed_by_hand_or_missed_is_seen(claims, kept: dict) -> None:
    forged = json.loads(json.dumps(kept))
    _, title, what = claims.TEN[0]
    next(row for row in forged[title]["rows"] if row["what"] == what)["measured"] = 1e-3
    assert "\n".join(claims.ten_of(forged)) not in claims.PAGE.read_text("utf-8")
    assert body(claims.page_of(forged)) not in claims.PAGE.read_text("utf-8")
    assert f"| {title} | {what} | 0.001 | 1e-12 | **no** |" in claims.page_of(forged)
    for section in forged.values():  # all missed: the page says how many it does not show
        for row in section["rows"]:
            row |= {"measured": 2.0, "limit": 1.0}
    page = claims.page_of(forged)
    assert sum(line.startswith("| ") for line in page.splitlines()) - page.count("|---|\n") == claims.MOST_ROWS
    count = sum(len(section["rows"]) for section in forged.values())
    assert f"Missed, {count} in all, the first {claims.MOST_ROWS - len(claims.TEN) - len(claims.SECTIONS)}" in page


def test_every_case_of_calculix_is_kept_by_the_name_that_measures_it(monkeypatch_module) -> None:
    import third

    stored = json.loads(third.STORED.read_text("utf-8"))
    assert set(stored) == set(third.CASES)
    assert all(case["code"].startswith("CalculiX ") and case["day"] and case["errors"] for case in stored.values())
