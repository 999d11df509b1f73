"""Start-up: time to help and to the engines, size of wheel and environment."""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
TITLE = "Start-up and size"
RUNS = 5
COMMANDS = {
    "a bare interpreter": ["-c", "pass"],
    "`halfplane --help`": ["-m", "reports", "--help"],
    "`import semi_analytic`": ["-c", "import semi_analytic"],
    "`import halfplane_fe`": ["-c", "import halfplane_fe"],
}


def child_seconds(arguments: list[str]) -> float:
    """CPU time of a process, its children included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, cwd=ROOT)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def wheel_bytes() -> int:
    """Size of the wheel, built from the checkout without its dependencies."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, "."]
        subprocess.run([sys.executable, *command], check=True, capture_output=True, cwd=ROOT)
        return next(Path(folder).glob("*.whl")).stat().st_size


def folder_bytes(folder: Path) -> int:
    """Bytes on disk of all files below it."""
    return sum(512 * file.lstat().st_blocks for file in folder.rglob("*") if file.is_file() and not file.is_symlink())


def largest(packages: Path, count: int = 8) -> dict[str, int]:
    """The largest folders of an environment's packages, in bytes."""
    sizes = {folder.name: folder_bytes(folder) for folder in packages.iterdir() if folder.is_dir()}
    return dict(sorted(sizes.items(), key=lambda item: -item[1])[:count])


def measure() -> dict[str, Any]:
    """CPU times in turn, so that what else the machine does falls on all alike; sizes."""
    for arguments in COMMANDS.values():
        child_seconds(arguments)
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for _ in range(RUNS):
        for name, arguments in COMMANDS.items():
            times[name].append(child_seconds(arguments))
    packages = Path(sys.prefix) / "lib" / f"python3.{sys.version_info.minor}" / "site-packages"
    return {
        "seconds": times,
        "wheel": wheel_bytes(),
        "environment": folder_bytes(Path(sys.prefix)),
        "largest": largest(packages),
    }


def draw(found: dict[str, Any], folder: Path) -> None:
    """No figure."""


def page(found: dict[str, Any]) -> list[str]:
    """Two tables."""
    lines = [
        f"CPU time of a process from its start to its end, {RUNS} runs in turn after one to warm up:",
        "",
        "| process | least [s] | median [s] | most [s] |",
        "|---|---|---|---|",
    ]
    for name, times in found["seconds"].items():
        lines.append(f"| {name} | {min(times):.2f} | {statistics.median(times):.2f} | {max(times):.2f} |")
    largest_words = ", ".join(f"{name} {size / 1e6:.0f}" for name, size in found["largest"].items())
    lines += [
        "",
        f"The wheel has {found['wheel'] / 1e6:.2f} MB. The environment that `make` sets up, tests, linters, browser and pages "
        f"included, has {found['environment'] / 1e9:.2f} GB on disk; the largest of it [MB]: {largest_words}.",
    ]
    return lines
