"""Running CalculiX: found or not, its status file, progress, time limit, interrupts and failures. A script stands in for it."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from reports.third.running import Attempt, calculix_version, find_calculix, run_calculix, status
from scenes import ConvergenceError, InputError

STA = """ SUMMARY OF JOB INFORMATION
  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME
     1          1     1U   60  0.000000E+00  0.000000E+00  0.625000E-01
     1          1     2     9  0.625000E-01  0.625000E-01  0.625000E-01
     2          1     1    15  0.250000E+00  0.187500E+00  0.187500E+00
"""


def stand_in(folder: Path, body: str) -> Path:
    """A program that leaves STA as the status file of the job `deck` and then does `body`."""
    (folder / "sta").write_text(STA, encoding="utf-8")
    program = folder / "ccx"
    program.write_text(f"#!/bin/sh\necho $$ > pid\ncp sta deck.sta\n{body}\n", encoding="utf-8")
    program.chmod(0o755)
    return program


def gone(folder: Path) -> bool:
    pid = int((folder / "pid").read_text())
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_the_status_file_tells_accepted_from_rejected_and_skips_half_a_line(tmp_path: Path) -> None:
    (tmp_path / "deck.sta").write_text(STA + "     2          2     1", encoding="utf-8")
    rows = status(tmp_path / "deck.sta")
    assert rows == [Attempt(False, 60, 0.0), Attempt(True, 9, 0.0625), Attempt(True, 15, 0.25)]
    assert status(tmp_path / "none.sta") == []


def test_a_run_that_reaches_its_end_counts_increments_and_iterations(tmp_path: Path) -> None:
    seen: list[tuple[int, int | None, str]] = []
    program = stand_in(tmp_path, "sleep 0.6")
    done = run_calculix(program, tmp_path, "deck", 0.25, 20.0, lambda *state: seen.append(state))
    assert (done.increments, done.iterations) == (2, 84)
    assert seen[-1][:2] == (100, 100)


@pytest.mark.parametrize(
    ("body", "end", "words"),
    [
        ("echo '*ERROR: too many cutbacks'; exit 201", 0.25, "exit code 201 .* too many cutbacks"),
        ("echo 'Job finished'; exit 0", 1.0, "exit code 0 at time 0.25 of 1.*Job finished"),
    ],
)
def test_a_run_that_stops_early_is_told_with_the_end_of_its_log(tmp_path: Path, body: str, end: float, words: str) -> None:
    with pytest.raises(ConvergenceError, match=words):
        run_calculix(stand_in(tmp_path, body), tmp_path, "deck", end, 20.0)


def test_the_time_limit_ends_the_process(tmp_path: Path) -> None:
    begun = time.monotonic()
    with pytest.raises(ConvergenceError, match=r"time limit of 0.5 s at time 0.25 of 1"):
        run_calculix(stand_in(tmp_path, "exec sleep 60"), tmp_path, "deck", 1.0, 0.5)
    assert time.monotonic() - begun < 30
    assert gone(tmp_path)


def test_an_interrupt_ends_the_process_too(tmp_path: Path) -> None:
    def interrupted(_done: int, _total: int | None, _text: str) -> None:
        if (tmp_path / "deck.sta").exists():
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_calculix(stand_in(tmp_path, "exec sleep 60"), tmp_path, "deck", 1.0, 30.0, interrupted)
    assert gone(tmp_path)


def test_no_calculix_names_make_peers(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="make peers"):
        find_calculix()


def test_the_version_is_what_the_program_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # the stand-in leaves files where it is called
    assert calculix_version(stand_in(tmp_path, "echo 'This is Version 2.20'")) == "2.20"
    assert calculix_version(stand_in(tmp_path, "true")) == "of unknown version"
