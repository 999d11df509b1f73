"""The program killed at random moments: for the tests of faults and benchmarks/jobs.py."""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

from command_line import COARSE, ROOT, start
from reports.studies.sweep.store import Store
from scenes import ContactSolution

# What is timed, and what the cache of bodies saved: all else of two runs must be the same to the
# last bit.
TIMED = ("seconds", "command", "condensations", "sparse factorisations")
PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")
STUDY = """scene = "hertz-paper"\nengines = ["exact"]
figures = ["exact.dissipation", "exact.peak_dissipation"]
[[axes]]\nname = "f"\nkey = "friction.coefficient"
linear = {start = 1.0, stop = 2.0, count = 40}\n"""
JOBS = {
    "run": ("run", "hertz-paper", *COARSE, "--out", "out"),
    "sweep": ("sweep", "study.toml", "--workers", "1", "--out", "out", "--resume"),
}


def started(folder: Path, job: str) -> subprocess.Popen[str]:
    """A job in a session of its own, so that its workers can be killed with it."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return start(
        folder, *JOBS[job], "--quiet", session=True, PYTHONPATH=str(folder.parent / "code")
    )


def finished(folder: Path, job: str) -> int:
    with started(folder, job) as process:
        _, errors = process.communicate(timeout=3600)
    assert "Traceback" not in errors, errors
    return process.returncode


def half_files(folder: Path) -> list[str]:
    """Files under a name that a reader would open, and that are not whole; what is hidden or ends
    in .part has no such name.
    """
    half = []
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        is_open = (
            path.is_file()
            and path.suffix != ".part"
            and not any(part.startswith(".") for part in parts)
        )
        if is_open and not _whole(path):
            half.append("/".join(parts))
    store = Store(folder / "out")
    return half + [address for address in store.addresses() if store.read(address) is None]


def _whole(path: Path) -> bool:
    try:
        match path.suffix:
            case ".json":
                json.loads(path.read_text(encoding="utf-8"))
            case ".nc":
                ContactSolution.load(path)
            case ".html":
                return path.read_text(encoding="utf-8").rstrip().endswith("</html>")
            case ".csv" | ".toml" | ".log":
                return path.read_text(encoding="utf-8").endswith("\n")
    except (ValueError, OSError):
        return False
    return True


def numbers(folder: Path) -> dict[str, str]:
    """Everything computed that lies in `folder`, by file; what is timed taken out."""
    texts = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.suffix == ".json" and path.name != "manifest.json":
            content = json.loads(path.read_text(encoding="utf-8"))
            texts[name] = json.dumps(
                _untimed(content.get("result", content) if "sha256" in content else content),
                sort_keys=True,
            )
        elif path.suffix == ".csv" and path.name != "index.csv":
            texts[name] = path.read_text(encoding="utf-8")
        elif path.suffix == ".nc":
            dataset = ContactSolution.load(path).to_dataset()
            texts[name] = "".join(
                str(dataset[key].values.tobytes()) for key in sorted(map(str, dataset.variables))
            )
    return texts


def _untimed(value: object) -> object:
    if isinstance(value, dict):
        timed = re.compile("|".join(TIMED))
        return {key: _untimed(entry) for key, entry in value.items() if not timed.search(key)}
    return [_untimed(entry) for entry in value] if isinstance(value, list) else value


def survive(
    folder: Path, job: str, kills: int, seed: int, longest: float, truth: dict[str, str]
) -> int:
    """Kill the job and its workers `kills` times at random moments, then let it end; returns how
    often it held.

    After each kill every file is whole or absent, and in the end the numbers are those of an
    undisturbed run bit for bit.
    """
    chance = random.Random(seed)
    for _ in range(kills):
        process = started(folder, job)
        try:
            process.communicate(timeout=chance.uniform(0.2, longest))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        assert half_files(folder) == []
    assert finished(folder, job) in (0, 1)
    assert half_files(folder) == []
    assert numbers(folder / "out") == truth
    return kills


def copy_the_code(folder: Path) -> None:
    """The packages, which nobody edits there while jobs run; once."""
    for package in PACKAGES:
        if not (folder / package).exists():
            shutil.copytree(
                ROOT / package,
                folder / package,
                ignore=shutil.ignore_patterns("published", "__pycache__"),
            )


def undisturbed(folder: Path, job: str) -> tuple[dict[str, str], float]:
    """The numbers of a run that nothing happened to, and how long it took."""
    copy_the_code(folder.parent / "code")
    folder.mkdir()
    begun = time.monotonic()
    assert finished(folder, job) in (0, 1)
    return numbers(folder / "out"), time.monotonic() - begun
