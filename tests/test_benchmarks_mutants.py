"""The random mutants: each is another program that compiles, drawn again by the same seed, and judged by what pytest says."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
SOURCE = '''"""A module of six lines that operators fit."""
LIMIT: float = 2.0


def half(a, load):
    """3.0 in a text and in a message are left alone."""
    if load[0] < LIMIT:
        raise ValueError(f"{3.0 * LIMIT} is too small")
    return -a[1] + 0.5 * load[-1]
'''
MUTANTS = {
    ("constant x 1.01", "2.0", "(2.0 * 1.01)"),
    ("neighbouring index", "0", "1"),
    ("comparison", "load[0] < LIMIT", "(load[0] >= LIMIT)"),
    ("sign", "-a[1]", "(a[1])"),
    ("neighbouring index", "1", "2"),
    ("sign", "-a[1] + 0.5 * load[-1]", "(-a[1] - 0.5 * load[-1])"),
    ("dropped term", "-a[1] + 0.5 * load[-1]", "(-a[1])"),
    ("constant x 1.01", "0.5", "(0.5 * 1.01)"),
    ("dropped term", "0.5 * load[-1]", "(0.5)"),
    ("neighbouring index", "-1", "-2"),
}


@pytest.fixture
def mutants(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("mutants")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Two engines of one module each; only the first has a test, of one of its lines."""
    for engine in ("semi_analytic", "halfplane_fe"):
        (tmp_path / engine).mkdir()
        (tmp_path / engine / "part.py").write_text(SOURCE, encoding="utf-8")
    return tmp_path


def test_every_operator_fits_where_it_should_and_nowhere_else(mutants: ModuleType, tree: Path) -> None:
    found, executable = mutants.places(tree)
    rows = [row for rows in found.values() for row in rows if row["file"].startswith("semi_analytic")]
    assert {(row["operator"], row["before"], row["after"]) for row in rows} == MUTANTS
    assert len(found) == 2 * 3 < executable
    for row in rows:
        compile(row["source"], row["file"], "exec")
        assert row["source"] != SOURCE
        assert row["after"] in row["source"]


def test_the_same_seed_draws_the_same_and_more_are_added_at_the_end(mutants: ModuleType, tree: Path) -> None:
    found, _ = mutants.places(tree)
    assert mutants.draw(found, 3, 1) == mutants.draw(found, 6, 1)[:3]
    assert mutants.draw(found, 6, 1) != mutants.draw(found, 6, 2)


@pytest.mark.parametrize(("code", "verdict"), [(0, "survived"), (1, "killed"), (None, "timeout")])
def test_a_verdict_is_what_the_tests_say_and_the_original_comes_back(
    mutants: ModuleType, tree: Path, monkeypatch: pytest.MonkeyPatch, code: int | None, verdict: str
) -> None:
    seen = []

    def run(stage: str, engine: str, place: Path, processes: int, limit: float | None) -> tuple[int | None, str]:
        changed = (place / engine / "part.py").read_text(encoding="utf-8") != SOURCE
        seen.append((stage, changed))
        return (code, "a test") if changed else (0, "")

    monkeypatch.setattr(mutants, "run_tests", run)
    row = mutants.draw(mutants.places(tree)[0], 1, 1)[0]
    assert mutants.judge(row, ["contract", "engine"], tree, 1, {})["verdict"] == verdict
    assert (tree / row["file"]).read_text(encoding="utf-8") == SOURCE
    # The unchanged tree first, for the limit of time, then the mutant; the engine's own tests only if the contract lets it pass.
    assert seen == [("contract", False), ("contract", True), *([("engine", False), ("engine", True)] if code == 0 else [])]


def test_a_tree_that_fails_by_itself_judges_nothing(mutants: ModuleType, tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "run_tests", lambda *_: (1, "tests/test_a.py::test_b"))
    row = mutants.draw(mutants.places(tree)[0], 1, 1)[0]
    with pytest.raises(SystemExit, match="the unchanged tree fails the stage 'contract'"):
        mutants.judge(row, ["contract"], tree, 1, {})


def test_equivalent_mutants_leave_the_count_only_with_a_reason(mutants: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    row = {"file": "a.py", "line": 1, "operator": "sign", "before": "a", "after": "(b)", "stages": ["contract"]}
    rows = [row | {"verdict": "killed"}, row | {"verdict": "survived"}, row | {"verdict": "timeout", "before": "c"}]
    assert "2 of 3 killed (67 %), 1 of them stopped" in mutants.report(rows)
    monkeypatch.setattr(mutants, "equivalents", lambda: {("a.py", "a", "(b)"): "rounds the same"})
    assert "1 equivalent, 2 of 2 killed" in mutants.report(rows)
    assert all(reason.strip() for reason in mutants.equivalents().values())
