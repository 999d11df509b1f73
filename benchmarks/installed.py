"""The wheel, built, installed into an environment of its own, run outside the checkout: with the lowest versions or the pinned.

    python benchmarks/installed.py --lowest FOLDER     (make lowest; downloads some 400 MB the first time)
    python benchmarks/installed.py --pinned FOLDER

Prints what a run finds there beside what it finds in the present environment; the exit code is 1 where they differ by over 1e-6.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).parent.parent
AGREE = 1e-6  # on metrics, as `halfplane diff` has it: other versions of numpy and scipy round otherwise
FIGURES = ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")


def requirements() -> list[str]:
    """What pyproject.toml asks for, without the extras."""
    return list(tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["dependencies"])


def lowest() -> list[str]:
    """name==version of every lower bound.

    >>> all("==" in pin for pin in lowest())
    True
    """
    return [re.sub(">=", "==", word) for word in requirements()]


def build(folder: Path) -> Path:
    """The wheel of this checkout."""
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", folder, ROOT)
    (wheel,) = folder.glob("halfplane-*.whl")
    return wheel


def install(home: Path, wheel: Path, *, pins: list[str]) -> Path:
    """Its python; the environment is made anew, packages come as a user's pip gets them."""
    venv.create(home, clear=True, with_pip=True)
    python = home / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", *pins)
    run(python, "-m", "pip", "install", "--quiet", wheel)
    run(python, "-m", "pip", "check")
    return python


def run(*words: str | Path, cwd: Path | None = None) -> str:
    """What a command prints; an error with its last lines where it fails."""
    outside = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {
        "HALFPLANE_CACHE": "off",
        "MPLBACKEND": "Agg",
    }
    done = subprocess.run([str(word) for word in words], cwd=cwd, env=outside, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, words))} ended with {done.returncode}:\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def figures(python: Path, folder: Path) -> dict[str, float]:
    """The headline metrics of `halfplane run hertz-paper`, run in `folder`."""
    folder.mkdir(parents=True)
    where = run(python, "-c", "import reports; print(reports.__file__)", cwd=folder).strip()
    if python != Path(sys.executable) and Path(where).is_relative_to(ROOT) and not Path(where).is_relative_to(python.parents[1]):
        raise RuntimeError(f"the checkout was run, not the wheel: {where}")
    run(python, "-m", "reports", "run", "hertz-paper", "--quiet", "--out", "out", cwd=folder)
    metrics = json.loads((folder / "out" / "comparison.json").read_text("utf-8"))["metrics"]
    return {name: metrics[name]["value"] for name in FIGURES}


def apart(home: Path, pins: list[str], scratch: Path) -> tuple[dict[str, float], dict[str, float]]:
    """Figures of the installed wheel, and of this environment."""
    python = install(home, build(scratch), pins=pins)
    return figures(python, scratch / "there"), figures(Path(sys.executable), scratch / "here")


def main(words: list[str]) -> int:
    kind, home = words
    pins = lowest() if kind == "--lowest" else ["-c", str(ROOT / "constraints.txt"), *requirements()]
    with tempfile.TemporaryDirectory(prefix="halfplane-") as scratch:
        there, here = apart(Path(home).resolve(), pins, Path(scratch))
    worst = max(abs(there[name] - here[name]) for name in FIGURES)
    for name in FIGURES:
        print(f"{name:16}{there[name]: .9e}  here {here[name]: .9e}  apart {there[name] - here[name]: .1e}")
    print(f"worst difference {worst:.1e}, admitted {AGREE:g}: {'ok' if worst <= AGREE else 'NOT ok'}")
    return int(not worst <= AGREE)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
