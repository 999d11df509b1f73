"""The table of cases: complete, each value once, references and baselines apart, able to fail."""

from __future__ import annotations

import dataclasses
import tomllib
from collections import Counter
from pathlib import Path

import case_table
import contract_values
import publishing
import pytest
from case_table import Case

import scene_cases
from cases import RUNS
from scenes import scene_names

ROOT = Path(__file__).parents[1]
SHEETS = {name: case_table.sheet(name) for name in case_table.scenes()}
FILES = (*scene_names(), *scene_cases.CASES)


def test_a_file_is_what_the_table_would_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = {name: case_table.file_of(name).read_text(encoding="utf-8") for name in SHEETS}
    monkeypatch.setattr(case_table, "FOLDER", tmp_path)
    for name, text in texts.items():
        case_table.write(SHEETS[name])
        assert case_table.file_of(name).read_text(encoding="utf-8") == text, name


def test_no_baseline_stands_twice_and_no_reference_of_a_whole_cycle_beside_a_scene_file() -> None:
    for name, sheet in SHEETS.items():
        often = Counter(case.key for case in sheet.cases if not case.is_reference)
        assert max(often.values(), default=1) == 1, name
        of_cycle = [case for case in sheet.cases if case.is_reference and not case.at]
        assert not of_cycle or name not in FILES, name


def test_a_case_is_a_baseline_with_its_commit_or_a_reference_with_its_source() -> None:
    content = (ROOT / "docs" / "requirements.toml").read_text(encoding="utf-8")
    areas = tomllib.loads(content)["area"]
    required = {row["requirement"] for area in areas for row in area["requirements"]}
    for name in (*SHEETS, *FILES):
        sheet = case_table.sheet(name)
        for case in (*sheet.cases, *case_table.expected(name)):
            assert bool(case.commit) is not bool(case.source), case
            assert case.requirement in required, case
            assert case.tolerance > 0 or case.least > 0, case
            assert not case.at or case.at in sheet.points, case


def test_every_baseline_is_measured_by_one_of_the_programs() -> None:
    """Nothing else would see it move."""
    quick = set(_keys_of("regress", "hertz-paper"))
    quick |= set(_keys_of("regress", "time-series"))
    for name, sheet in SHEETS.items():
        contract = contract_values.contract_baselines(sheet)
        for key, case in sheet.baselines().items():
            measured = key in contract or case.run.startswith("coarse ")
            measured |= key in quick and name in RUNS["regress"][0]
            measured |= publishing.is_published(case)
            assert measured, case


def _keys_of(run: str, scene: str) -> set[case_table.Key]:
    _, measure = RUNS[run]
    values, _ = measure(scene, SHEETS[scene])
    return set(values)


def test_digits_of_a_scene_file_are_all_there_and_the_engine_named_has_the_number() -> None:
    works = [
        case
        for name in scene_names()
        for case in case_table.expected(name)
        if (case.run, case.quantity) == (case_table.THEORY, "dissipation") and float(case.value)
    ]
    assert sum(len(case.value) > 25 for case in works) >= 14
    assert all(isinstance(case.value, str) for case in works)
    numbers = [
        case
        for name in scene_names()
        for case in case_table.expected(name)
        if not case.is_reference
    ]
    assert {case.run for case in numbers} == {case_table.ELEMENTS}
    assert all(case.source.startswith("our own") for case in numbers)


CASE = Case("scene", "theory", "shear", "grid", [[1.0, None, -2.0], [0.0, "E", 4]], 1e-3, 0.0, "")
# What is found in the place of `CASE`, and whether that is it.
FOUND = {
    "the same": ([[1.0, None, -2.0], [0.0, "E", 4]], True),
    "within a share of the largest": ([[1.0039, None, -2.0], [0.0, "E", 4]], True),
    "beyond it": ([[1.0, None, -2.0041], [0.0, "E", 4]], False),
    "a number for none": ([[1.0, 0.0, -2.0], [0.0, "E", 4]], False),
    "none for a number": ([[1.0, None, None], [0.0, "E", 4]], False),
    "another word": ([[1.0, None, -2.0], [0.0, "G", 4]], False),
    "fewer": ([[1.0, None, -2.0], [0.0, "E"]], False),
    "infinite": ([[1.0, None, -2.0], [0.0, "E", float("inf")]], False),
}


@pytest.mark.parametrize("name", FOUND)
def test_a_value_agrees_within_the_tolerance_and_not_beyond(name: str) -> None:
    value, same = FOUND[name]
    assert case_table.agrees(CASE, value) is same
    assert bool(case_table.moved({CASE.key: CASE}, {CASE.key: value})) is not same


def test_digits_and_round_off_of_nothing_agree_and_what_is_missing_does_not() -> None:
    exact = dataclasses.replace(CASE, value="0.333333333333333333333333333333", tolerance=1e-15)
    assert case_table.agrees(exact, 1 / 3)
    assert not case_table.agrees(exact, 0.3333333333333)
    nothing = dataclasses.replace(CASE, value=0.0, tolerance=1e-12, least=1e-14)
    assert case_table.agrees(nothing, 2e-13)
    assert not case_table.agrees(nothing, 2e-12)
    empty = dataclasses.replace(CASE, value=[])
    assert case_table.agrees(empty, [])
    assert not case_table.agrees(empty, [0.0])
    assert case_table.moved({CASE.key: CASE}, {}) == ["theory: shear at grid: missing"]
