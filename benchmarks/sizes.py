"""How large each package is beside the last release: files, lines and statements; a brake on growth.

    python benchmarks/sizes.py            the table; exit code 1 where a package grew and the changelog does not say for what
    python benchmarks/sizes.py --release  the sizes of now become those of the last release

A package that users install may grow by 2 % from one release to the next. Beyond that the newest section of CHANGELOG.md holds,
under "### Growth", a line "- **package**: what a user can now do".
"""

from __future__ import annotations

import ast
import json
import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
RELEASE = Path(__file__).with_suffix(".json")
INSTALLED = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")
PARTS = (*INSTALLED, "benchmarks", "tests", "docs")
HEADS = ("files", "lines", "statements")
ADMITTED = 0.02

Sizes = dict[str, dict[str, int]]


def sizes() -> Sizes:
    """Files of Python, lines and statements (docstrings are none) of each part."""
    found = {}
    for part in PARTS:
        own = [path.read_text(encoding="utf-8") for path in (ROOT / part).rglob("*.py") if "_build" not in path.parts]
        found[part] = dict(zip(HEADS, (len(own), sum(text.count("\n") for text in own), sum(map(statements, own))), strict=True))
    return found


def statements(text: str) -> int:
    """Statements of a file, at every depth, without docstrings and other lone strings.

    >>> statements('def f():\\n    "what it does"\\n    return 1\\n')
    2
    """
    every = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.stmt)]
    return sum(not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)) for node in every)


def unexplained(now: Sizes, before: Sizes, changelog: str) -> dict[str, float]:
    """How much installed packages grew in lines or statements, where it is more than 2 % and the changelog does not explain it.

    >>> small, large = ({"scenes": {"lines": n, "statements": n}} for n in (100, 103))
    >>> unexplained(large, small, "## 0.2.0"), unexplained(large, small, "## 0.2.0\\n### Growth\\n- **scenes**: reads units")
    ({'scenes': 0.03}, {})
    """
    newest = re.split(r"^## ", changelog, maxsplit=2, flags=re.MULTILINE)[1]
    said = re.findall(r"^- \*\*(\w+)\*\*: \S", newest.partition("### Growth")[2].partition("\n### ")[0], re.MULTILINE)
    growth = {n: max(now[n][h] / before[n][h] - 1 for h in ("lines", "statements")) for n in INSTALLED if n in now}
    return {name: round(share, 4) for name, share in growth.items() if share > ADMITTED and name not in said}


def table(now: Sizes, before: Sizes, release: str) -> Iterable[str]:
    """Lines of the table, the sum last."""
    yield f"{'':<15}" + "".join(f"{head:>12}{release:>9}" for head in HEADS)
    for name in (*PARTS, "all"):
        one, other = (found.get(name) or {h: sum(v[h] for v in found.values()) for h in HEADS} for found in (now, before))
        yield f"{name:<15}" + "".join(f"{one[head]:>12,}{other[head]:>9,}" for head in HEADS)


def main(words: list[str]) -> int:
    now = sizes()
    if words == ["--release"]:
        version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
        RELEASE.write_text(json.dumps({"release": version, "sizes": now}, indent=1) + "\n", encoding="utf-8")
        return 0
    last = json.loads(RELEASE.read_text(encoding="utf-8"))
    print("\n".join(table(now, last["sizes"], last["release"])))
    missing = unexplained(now, last["sizes"], (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    for name, share in missing.items():
        print(f"{name} grew by {share:.1%}: CHANGELOG.md must say under '### Growth' what a user can now do, in a line")
        print(f"that begins with '- **{name}**: '")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
