"""What pip installs: licences, and the wheel in an environment of its own.

    python benchmarks/packages.py lowest FOLDER     (make lowest) the wheel with the lowest versions
                                                    that pyproject.toml allows
    python benchmarks/packages.py pinned FOLDER     the same with the pinned versions
    python benchmarks/packages.py commands FOLDER   every command of the wheel, with the packages of
                                                    the present environment
    python benchmarks/packages.py licences          docs/licences.csv

The wheel runs outside the checkout. `lowest` and `pinned` print what a run finds there beside what
it finds in the present environment: exit code 1 where they differ by over 1e-6. `commands`: 1 where
one does not end as it must, or has no line here.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
import venv
from importlib.metadata import Distribution, distribution
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
PINS = ROOT / "constraints.txt"
LICENCES = ROOT / "docs" / "licences.csv"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
REQUIREMENTS: list[str] = PROJECT["dependencies"]


def run(*words: str | Path, cwd: Path | None = None) -> str:
    """What a command prints; an error with its last lines where it fails."""
    outside = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    outside |= {"MPLBACKEND": "Agg"}
    process = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=outside,
        capture_output=True,
        text=True,
        check=False,
    )
    if process.returncode:
        raise RuntimeError(
            f"{' '.join(map(str, words))} ended with"
            f" {process.returncode}:\n{(process.stdout + process.stderr)[-2000:]}"
        )
    return process.stdout


# ----------------------------------------------------------------------------------------- licences
def plain(word: str) -> str:
    """The name in a requirement.

    >>> plain("Jinja2>=3.1")
    'jinja2'
    """
    return re.sub(r"[-_.]+", "-", re.split(r"[^A-Za-z0-9._-]", word, maxsplit=1)[0]).lower()


def closure() -> dict[str, Distribution]:
    """Every package that the requirements need here, theirs included, without extras."""
    from packaging.requirements import Requirement

    distributions: dict[str, Distribution] = {}
    waiting = [*REQUIREMENTS]
    while waiting:
        word = waiting.pop()
        marker = Requirement(word).marker
        if plain(word) not in distributions and (marker is None or marker.evaluate({"extra": ""})):
            distributions[plain(word)] = distribution(plain(word))
            waiting += distributions[plain(word)].requires or []
    return dict(sorted(distributions.items()))


def licence(package: Distribution) -> str:
    """The SPDX expression, else the classifiers, else the first line of the free text."""
    meta: Any = package.metadata  # its type lacks `get` before Python 3.12
    classifiers = [
        line.split(" :: ")[-1]
        for line in meta.get_all("Classifier") or []
        if line.startswith("License :: ")
    ]
    named = ", ".join(name for name in classifiers if name != "OSI Approved")
    text = (meta.get("License") or "").strip().partition("\n")[0][:60]
    return meta.get("License-Expression") or named or text or "not stated"


def licences() -> str:
    """The licence of every package that `pip install halfplane` brings, by its own metadata, as
    CSV.
    """
    written = io.StringIO()
    rows = csv.writer(written, lineterminator="\n")
    rows.writerow(["package", "licence"])
    rows.writerows([name, licence(package)] for name, package in closure().items())
    return written.getvalue()


# ---------------------------------------------------------------------------------------- the wheel
# on metrics, as `halfplane diff` has it: other versions of numpy and scipy round otherwise
AGREE = 1e-6
FIGURES = ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")
COARSE = "--steps-per-cycle 16 --element-size 0.1 --edge-element-size 0.05 --quiet"
# What every command is asked, one after another in one folder, and its exit code; `run` is too
# coarse for its limits.
COMMANDS = {
    "init plain.toml": 0,
    "init bodies.toml --bodies": 0,
    "check bodies.toml": 0,
    "scenes hertz-paper": 0,
    "schema": 0,
    "doctor": 0,
    "exact plain.toml --out exact --quiet": 0,
    f"fe plain.toml --out fe {COARSE}": 0,
    f"run plain.toml --out run {COARSE}": 1,
    f"fields plain.toml --out fields --at 14 {COARSE}": 0,
    "export plain.toml --out deck --steps-per-cycle 8 --quiet": 0,
    "score exact/semi_analytic.nc --scene plain.toml --out score --quiet": 0,
    "diff run run": 0,
    "advise bodies.toml": 0,
    "sweep study.toml --workers 1 --quiet": 0,
    "sweep status out/study": 0,
    "sweep report out/study": 0,
    "map pair --out maps --pages": 2,  # no tables there
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
from halfplane.reports.cli import main
from halfplane.reports.cli.application import app
if __name__ == "__main__":
    found = {"": [name for name in app if name[0] != "-"]}
    for words in json.loads(sys.argv[1]):
        try:
            found[words] = main(words.split())
        except BaseException as fault:
            found[words] = repr(fault)
    Path("codes.json").write_text(json.dumps(found))
"""


def lowest() -> list[str]:
    """name==version of every lower bound.

    >>> all("==" in pin for pin in lowest())
    True
    """
    return [word.replace(">=", "==") for word in REQUIREMENTS]


def build_wheel(folder: Path) -> Path:
    """The wheel of this checkout, built in `folder`."""
    run(
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--quiet",
        "--no-deps",
        "--no-build-isolation",
        "--wheel-dir",
        folder,
        ROOT,
    )
    (wheel,) = folder.glob("halfplane-*.whl")
    return wheel


def environment(home: Path, scratch: Path, pins: list[str] | None) -> Path:
    """Python of a new environment with the wheel of this checkout; without pins all other packages
    are the present one's.
    """
    wheel = build_wheel(scratch)
    venv.create(home, clear=True, with_pip=pins is not None)
    python = home / "bin" / "python"
    if pins is None:
        run(
            sys.executable,
            "-m",
            "pip",
            "--python",
            python,
            "install",
            "--quiet",
            "--no-deps",
            "--no-index",
            wheel,
        )
        (packages,) = home.glob("lib/python*/site-packages")
        # A plain path: the .pth files of that folder, which lead to the checkout, are not read.
        (packages / "packages.pth").write_text(sysconfig.get_path("purelib"), "utf-8")
    else:
        run(python, "-m", "pip", "install", "--quiet", *pins)
        run(python, "-m", "pip", "install", "--quiet", wheel)
        run(python, "-m", "pip", "check")
    where = run(python, "-c", "import halfplane; print(halfplane.__file__)", cwd=scratch).strip()
    if not Path(where).is_relative_to(home):
        raise RuntimeError(f"the checkout was run, not the wheel: {where}")
    return python


def every_command(home: Path, folder: Path) -> list[str]:
    """A line for each command that did not end as it must."""
    folder.mkdir()
    python = environment(home, folder, None)
    run(home / "bin" / "halfplane", "--version", cwd=folder)
    (folder / "study.toml").write_text(STUDY, "utf-8")
    (folder / "driver.py").write_text(DRIVER, "utf-8")
    said = run(python, "driver.py", json.dumps(list(COMMANDS)), cwd=folder)
    codes = json.loads((folder / "codes.json").read_text("utf-8"))
    without = set(codes.pop("")) - {words.split()[0] for words in COMMANDS}
    wrong = [
        f"halfplane {words}: {codes[words]} for {code}"
        for words, code in COMMANDS.items()
        if codes[words] != code
    ]
    return [
        *wrong,
        *(f"halfplane {name}: not run" for name in sorted(without)),
        *([said[-2000:]] if wrong else []),
    ]


def compared(home: Path, folder: Path, pins: list[str]) -> list[str]:
    """The headline metrics of `halfplane run hertz-paper` there and here; a line for each that
    differs.
    """
    folder.mkdir()
    answers = []
    for python in (environment(home, folder, pins), sys.executable):
        run(
            python,
            "-m",
            "halfplane",
            "run",
            "hertz-paper",
            "--quiet",
            "--out",
            f"out-{len(answers)}",
            cwd=folder,
        )
        metrics = json.loads(
            (folder / f"out-{len(answers)}" / "comparison.json").read_text("utf-8")
        )["metrics"]
        answers.append({name: metrics[name]["value"] for name in FIGURES})
    elsewhere, answer_here = answers
    for name in FIGURES:
        print(
            f"{name:16}{elsewhere[name]: .9e}  here {answer_here[name]: .9e}  apart"
            f" {elsewhere[name] - answer_here[name]: .1e}"
        )
    return [
        f"{name} differs by more than {AGREE:g}"
        for name in FIGURES
        if not abs(elsewhere[name] - answer_here[name]) <= AGREE
    ]


def main(words: list[str]) -> int:
    kind, *rest = words
    try:
        if kind == "licences":
            LICENCES.write_text(licences(), encoding="utf-8")
        else:
            pins = {
                "commands": None,
                "lowest": lowest(),
                "pinned": ["-c", str(PINS), *REQUIREMENTS],
            }[kind]
            with tempfile.TemporaryDirectory(prefix="halfplane-") as scratch:
                home = Path(rest[0]).resolve()
                folder = Path(scratch) / "there"
                wrong = (
                    every_command(home, folder) if pins is None else compared(home, folder, pins)
                )
            print("\n".join(wrong) or f"{kind}: ok")
            return int(bool(wrong))
    except RuntimeError as refused:
        print(f"packages: {refused}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
