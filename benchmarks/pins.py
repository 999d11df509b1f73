"""The pins of constraints.txt: one set that every Python named in pyproject.toml takes, from the first release of each.

    python benchmarks/pins.py            (make constraints) newest packages, checked, written
    python benchmarks/pins.py --check    (make nightly) the present pins checked

What may be installed is resolved for the oldest Python; each pin is then looked up, as a wheel, for all of them.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
PINS = ROOT / "constraints.txt"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
BUILD = ("hatchling", "editables")  # editables is what hatchling wants for `pip install -e`


def pythons() -> list[str]:
    """The minor versions that pyproject.toml names, oldest first.

    >>> pythons()[0]
    '3.11'
    """
    return [word.rsplit(" ", 1)[1] for word in PROJECT["classifiers"] if re.search(r"Python :: 3\.\d+$", word)]


def pinned() -> list[str]:
    """name==version, as constraints.txt has them."""
    return [line for line in PINS.read_text("utf-8").splitlines() if line and not line.startswith("#")]


def look_up(version: str, words: list[str], *options: str) -> str:
    """What pip would install on the first release of a Python, without doing so; RuntimeError with pip's words where it can't."""
    with tempfile.TemporaryDirectory() as nowhere:
        install = [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--ignore-installed", "--only-binary", ":all:"]
        where = ["--python-version", f"{version}.0", "--target", nowhere]
        done = subprocess.run([*install, *where, *options, *words], capture_output=True, text=True, check=False)
    if done.returncode:
        reasons = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
        raise RuntimeError(f"Python {version}: {' '.join(reasons) or done.stderr}")
    return done.stdout


def newest() -> list[str]:
    """name==version of all that the project and its extras bring, for the oldest Python."""
    oldest = pythons()[0]
    if sys.version_info[:2] != tuple(map(int, oldest.split("."))):
        # pip reads markers such as python_version < "3.12" by the Python it runs on, whatever --python-version is.
        raise RuntimeError(f"pins are made with the oldest Python, {oldest}; this is {sys.version.split()[0]}")
    extras = [word for extra in PROJECT["optional-dependencies"].values() for word in extra]
    report = json.loads(look_up(oldest, [*BUILD, *PROJECT["dependencies"], *extras], "--report", "-"))
    found = [f"{package['metadata']['name']}=={package['metadata']['version']}" for package in report["install"]]
    return sorted(found, key=str.lower)


def main(words: list[str]) -> int:
    try:
        pins = pinned() if words == ["--check"] else newest()
        for version in pythons():
            look_up(version, pins, "--no-deps")
            print(f"{len(pins)} pins have wheels for Python {version}.0 and later")
    except RuntimeError as refused:
        print(f"pins: {refused}", file=sys.stderr)
        return 1
    if words != ["--check"]:
        head = [line for line in PINS.read_text("utf-8").splitlines() if line.startswith("#")]
        PINS.write_text("\n".join([*head, *pins, ""]), "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
