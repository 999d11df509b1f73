"""Every door against spoilt files: read, or refused in one sentence; never a traceback, a warning, or a process brought down."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzing import DOORS, TOKENS, Door, attempt, outcome, spoilt
from scenes import InputError

# Spoilt files for each door: in every test run, and under --slow.
QUICK, THOROUGH = 40, 2000


def good(door: Door, folder: Path) -> list[bytes]:
    home = folder / door.name
    home.mkdir()
    return door.seeds(home)


@pytest.mark.parametrize("name", DOORS)
def test_good_files_are_read(name: str, tmp_path: Path) -> None:
    door = DOORS[name]
    for seed in good(door, tmp_path):
        (tmp_path / name / name).write_bytes(seed)
        assert outcome(door, tmp_path / name / name) == "read"


@pytest.mark.parametrize("name", DOORS)
def test_spoilt_files_are_read_or_refused(name: str, tmp_path: Path) -> None:
    seeds = good(DOORS[name], tmp_path)
    for number in range(QUICK):
        attempt(DOORS[name], seeds[number % len(seeds)], number, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", DOORS)
def test_thousands_of_spoilt_files_are_read_or_refused(name: str, tmp_path: Path) -> None:
    seeds = good(DOORS[name], tmp_path)
    for number in range(QUICK, QUICK + THOROUGH):
        attempt(DOORS[name], seeds[number % len(seeds)], number, tmp_path)


@given(content=st.binary(max_size=80) | st.lists(st.sampled_from(TOKENS), max_size=6).map(b"".join))
@settings(max_examples=30)
@pytest.mark.parametrize("name", DOORS)
def test_bytes_of_any_kind_are_read_or_refused(name: str, content: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    home = tmp_path_factory.getbasetemp() / f"bytes of {name}"
    home.mkdir(exist_ok=True)
    (home / name).write_bytes(content)
    outcome(DOORS[name], home / name)


def test_accidents_do_spoil_files_and_repeat() -> None:
    """The tester tested: most files change, in many ways, and a number gives the same file again."""
    seed = DOORS["study.json"].seeds(Path())[0]
    spoiled = [spoilt(seed, random.Random(number)) for number in range(100)]
    assert len({*spoiled}) > 70
    assert spoilt(seed, random.Random(3)) == spoiled[3]


def test_a_door_that_breaks_is_seen(tmp_path: Path) -> None:
    """The tester tested: another error than InputError, or a sentence that is none, fails."""

    def broken(path: Path) -> object:
        raise KeyError(path)

    def silent(_: Path) -> object:
        raise InputError

    with pytest.raises(KeyError):
        outcome(Door("broken", lambda _: [b""], broken), tmp_path)
    with pytest.raises(AssertionError, match="empty"):
        outcome(Door("silent", lambda _: [b""], silent), tmp_path)
