"""Licences of everything that `pip install halfplane` brings, from the packages' own metadata, into docs/licences.md.

python benchmarks/licences.py
"""

from __future__ import annotations

import re
from importlib.metadata import Distribution, distribution
from pathlib import Path

from installed import requirements

PAGE = Path(__file__).parent.parent / "docs" / "licences.md"
_NAME = re.compile(r"[A-Za-z0-9._-]+")
HEAD = """# Licences

halfplane is GPL-3.0-or-later, since it links gmsh, which is GPL. The packages that `pip install halfplane` brings, by their own
metadata. Written by `python benchmarks/licences.py`; a test compares it with what is installed.

| package | licence |
|---|---|
"""


def closure() -> dict[str, Distribution]:
    """Every package that the requirements need, theirs included, without extras."""
    found: dict[str, Distribution] = {}
    waiting = requirements()
    while waiting:
        word = waiting.pop()
        name = plain(word)
        if name in found or not wanted(word):
            continue
        found[name] = distribution(name)
        waiting += found[name].requires or []
    return dict(sorted(found.items()))


def plain(word: str) -> str:
    """The name in a requirement.

    >>> plain("Jinja2>=3.1")
    'jinja2'
    """
    match = _NAME.match(word)
    if match is None:
        raise ValueError(f"{word!r} begins with no name")
    return re.sub(r"[-_.]+", "-", match[0]).lower()


def wanted(word: str) -> bool:
    """Whether a requirement holds here: no extra, and its marker true."""
    from packaging.requirements import Requirement

    marker = Requirement(word).marker
    return marker is None or marker.evaluate({"extra": ""})


def licence(package: Distribution) -> str:
    """The SPDX expression, else the classifiers, else the first line of the free text."""
    meta = package.metadata
    if expression := meta.get("License-Expression"):
        return expression
    classifiers = [line.split(" :: ")[-1] for line in meta.get_all("Classifier") or [] if line.startswith("License :: ")]
    named = [name for name in classifiers if name != "OSI Approved"]
    text = (meta.get("License") or "").strip()
    return ", ".join(named) or (text.splitlines()[0][:60] if text else "not stated")


def page() -> str:
    return HEAD + "".join(f"| {name} | {licence(package).replace('|', ' or ')} |\n" for name, package in closure().items())


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
