"""CalculiX as a program: found, asked for its version, run with progress and a time limit, its failures in sentences."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from scenes import ConvergenceError, InputError

Report = Callable[[int, int | None, str], None]

PROGRAM = "ccx"
# How often the status file is read, and how many last lines of the log a failure shows [s, lines].
_EVERY = 0.25
_TAIL = 6
# CalculiX prints times to six digits.
_PRINTED = 1e-5


@dataclass(frozen=True)
class Done:
    """A run that reached its end: wall time [s], accepted increments, iterations of every attempt."""

    seconds: float
    increments: int
    iterations: int


def find_calculix() -> Path:
    """Where `ccx` is; InputError with what to do where it is not."""
    found = shutil.which(PROGRAM)
    if found is None:
        raise InputError(f"--third calculix: {PROGRAM} is not on PATH; `make peers` installs it (Debian package calculix-ccx)")
    return Path(found)


def calculix_version(program: Path) -> str:
    """What `ccx -v` says, such as "2.20"; "of unknown version" where it says nothing."""
    said = subprocess.run([str(program), "-v"], capture_output=True, text=True, check=False, timeout=20).stdout
    found = re.search(r"[Vv]ersion\s+([\w.]+)", said)
    return found[1] if found else "of unknown version"


def run_calculix(program: Path, folder: Path, name: str, end: float, limit: float, report: Report | None = None) -> Done:
    """Run the deck `name`.inp of a folder on one thread, until it ends.

    Parameters
    ----------
    end : total time of the deck's last instant
    limit : wall time [s]
    report : called with (done, total, text) in per cent of the deck's time

    Raises
    ------
    ConvergenceError
        With the last lines of its log where it stopped early, by itself or by the limit. The process is gone in any case.
    """
    begun = time.monotonic()
    log = folder / f"{name}.log"
    with log.open("w", encoding="utf-8") as stream:
        process = subprocess.Popen(
            [str(program), "-i", name],
            cwd=folder,
            env={**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_RESULTS": "1"},
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
        )
        try:
            late = _watch(process, folder / f"{name}.sta", end, begun + limit, report)
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()
    rows = status(folder / f"{name}.sta")
    reached = max((row.total for row in rows if row.accepted), default=0.0)
    if late or process.returncode != 0 or reached < end * (1 - _PRINTED):
        why = f"was stopped at the time limit of {limit:g} s" if late else f"ended with exit code {process.returncode}"
        raise ConvergenceError(
            f"CalculiX {why} at time {reached:.6g} of {end:.6g}, in increment {len(rows)}; the last lines of its log: {tail(log)}"
        )
    return Done(time.monotonic() - begun, sum(row.accepted for row in rows), sum(row.iterations for row in rows))


def _watch(process: subprocess.Popen[bytes], sta: Path, end: float, deadline: float, report: Report | None) -> bool:
    """Wait for the process; whether the deadline came first."""
    while process.poll() is None:
        if time.monotonic() > deadline:
            return True
        if report is not None:
            rows = status(sta)
            reached = rows[-1].total if rows else 0.0
            report(round(100 * min(reached / end, 1.0)), 100, f"increment {len(rows)}")
        time.sleep(_EVERY)
    return False


@dataclass(frozen=True)
class Attempt:
    """A line of the status file: whether the increment was accepted, its iterations, total time reached (its start if not)."""

    accepted: bool
    iterations: int
    total: float


def status(sta: Path) -> list[Attempt]:
    """The attempts in a .sta file so far; a line that is half-written is left out."""
    if not sta.exists():
        return []
    lines = sta.read_text(encoding="utf-8", errors="replace").splitlines()
    found = [re.match(r"\s*\d+\s+\d+\s+\d+(U?)\s+(\d+)\s+(\S+)\s+\S+\s+\S+\s*$", line) for line in lines]
    return [Attempt(not match[1], int(match[2]), float(match[3])) for match in found if match]


def tail(log: Path) -> str:
    """The last lines of a log that say something, as one line."""
    lines = [line.strip() for line in log.read_text(encoding="utf-8", errors="replace").splitlines()]
    told = [line for line in lines if line and not set(line) <= set("_-* ")]
    return " | ".join(told[-_TAIL:]) or "nothing"
