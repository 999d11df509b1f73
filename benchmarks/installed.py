"""The wheel, built, installed into an environment of its own, run outside the checkout: with the lowest versions or the pinned.

    python benchmarks/installed.py --lowest FOLDER     (make lowest; downloads some 400 MB the first time)
    python benchmarks/installed.py --pinned FOLDER
    python benchmarks/installed.py --commands FOLDER   (a test) every command, with the packages of the present environment

The first two print what a run finds there beside what it finds in the present environment; the exit code is 1 where they differ by
over 1e-6. The third prints each command with its exit code; 1 where one is not as it must be, or a command has no line here.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).parent.parent
AGREE = 1e-6  # on metrics, as `halfplane diff` has it: other versions of numpy and scipy round otherwise
COARSE = "--steps-per-cycle 16 --element-size 0.1 --edge-element-size 0.05 --quiet"
# What every command is asked, one after another in one folder, and its exit code; `run` is too coarse for its limits.
COMMANDS = {
    "init plain.toml": 0,
    "init bodies.toml --bodies": 0,
    "check bodies.toml": 0,
    "scenes hertz-paper": 0,
    "schema": 0,
    "doctor": 0,
    "completion bash": 0,
    "exact plain.toml --out exact --quiet": 0,
    f"fe plain.toml --out fe {COARSE}": 0,
    f"run plain.toml --out run {COARSE}": 1,
    f"fields plain.toml --out fields --at 14 {COARSE}": 0,
    "export plain.toml --out deck --to calculix --steps-per-cycle 8 --quiet": 0,
    "score exact/semi_analytic.nc --scene plain.toml --out score --quiet": 0,
    "diff run run": 0,
    "advise bodies.toml": 1,
    "sweep study.toml --workers 1 --quiet": 0,
    "sweep status out/study": 0,
    "sweep report out/study": 0,
    "map limits": 2,  # an installed copy's own tables are not written over
    "map limits --out maps --pages": 0,
    "paper --out paper --quiet": 0,
}
STUDY = """
title = "Friction"
scene = "plain.toml"
engines = ["exact"]
figures = ["exact.dissipation"]
[[axes]]
name = "f"
key = "friction.coefficient"
values = [0.6, 0.7]
"""
# One process for all of them: half of what a short command takes is its start.
DRIVER = """
import json, sys
from pathlib import Path
from reports.cli import main
from reports.cli.application import app
from reports.maps.laws import PUBLISHED
if __name__ == "__main__":
    Path("maps").mkdir()
    for table in PUBLISHED.glob("limits-*.csv"):
        (Path("maps") / table.name).write_bytes(table.read_bytes())
    found = {"": [name for name in app if name[0] != "-"]}
    for words in json.loads(sys.argv[1]):
        try:
            found[words] = main(words.split())
        except BaseException as fault:
            found[words] = repr(fault)
    Path("codes.json").write_text(json.dumps(found))
"""
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


def beside(home: Path, wheel: Path) -> Path:
    """Its python: an environment with the wheel alone, which finds all other packages in the present one."""
    venv.create(home, clear=True, with_pip=False)
    python = home / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--no-index", wheel)
    (own,) = home.glob("lib/python*/site-packages")
    # A plain path: the .pth files of that folder, which lead to the checkout, are not read.
    (own / "packages.pth").write_text(sysconfig.get_path("purelib"), "utf-8")
    return python


def every_command(home: Path, folder: Path) -> list[str]:
    """A line for each command that did not end as it must."""
    folder.mkdir()
    python = beside(home, build(folder))
    checked(python, folder)
    run(home / "bin" / "halfplane", "--version", cwd=folder)
    (folder / "study.toml").write_text(STUDY, "utf-8")
    (folder / "driver.py").write_text(DRIVER, "utf-8")
    said = run(python, "driver.py", json.dumps(list(COMMANDS)), cwd=folder)
    codes = json.loads((folder / "codes.json").read_text("utf-8"))
    without = set(codes.pop("")) - {words.split()[0] for words in COMMANDS}
    wrong = [f"halfplane {words}: {codes[words]} for {code}" for words, code in COMMANDS.items() if codes[words] != code]
    return [*wrong, *(f"halfplane {name}: not run" for name in sorted(without)), *([said[-2000:]] if wrong else [])]


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


def checked(python: Path, folder: Path) -> None:
    """RuntimeError where an environment has the checkout, not the wheel."""
    where = run(python, "-c", "import reports; print(reports.__file__)", cwd=folder).strip()
    if not Path(where).is_relative_to(python.parents[1]):
        raise RuntimeError(f"the checkout was run, not the wheel: {where}")


def figures(python: Path, folder: Path) -> dict[str, float]:
    """The headline metrics of `halfplane run hertz-paper`, run in `folder`."""
    folder.mkdir(parents=True)
    if python != Path(sys.executable):
        checked(python, folder)
    run(python, "-m", "reports", "run", "hertz-paper", "--quiet", "--out", "out", cwd=folder)
    metrics = json.loads((folder / "out" / "comparison.json").read_text("utf-8"))["metrics"]
    return {name: metrics[name]["value"] for name in FIGURES}


def apart(home: Path, pins: list[str], scratch: Path) -> tuple[dict[str, float], dict[str, float]]:
    """Figures of the installed wheel, and of this environment."""
    python = install(home, build(scratch), pins=pins)
    return figures(python, scratch / "there"), figures(Path(sys.executable), scratch / "here")


def main(words: list[str]) -> int:
    kind, home = words
    if kind == "--commands":
        with tempfile.TemporaryDirectory(prefix="halfplane-") as scratch:
            wrong = every_command(Path(home).resolve(), Path(scratch) / "there")
        print("\n".join(wrong) or f"{len(COMMANDS)} command lines of an installed copy: ok")
        return int(bool(wrong))
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
