"""How large each package is beside the last release: files, lines and statements; a brake on growth.

    python benchmarks/sizes.py            the table; exit code 1 where a package grew and the changelog does not say for what
    python benchmarks/sizes.py --release  the sizes of now become those of the last release

A package that users install may grow by 2 % from one release to the next. Beyond that the newest section of CHANGELOG.md holds,
under "### Growth", a line "- **package**: what a user can now do".
"""

from __future__ import annotations

import argparse
import ast
import json
import re
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


def unexplained(now: Sizes, before: Sizes, changelog: str) -> list[str]:
    """Installed packages that grew by more than 2 % in lines or statements, and whose growth the changelog does not explain.

    >>> small, large = ({"scenes": {"lines": n, "statements": n}} for n in (100, 103))
    >>> unexplained(large, small, "## 0.2.0"), unexplained(large, small, "## 0.2.0\\n### Growth\\n- **scenes**: reads units")
    (['scenes'], [])
    """
    newest = changelog.partition("\n## ")[0] if changelog.startswith("## ") else changelog.split("\n## ")[1]
    said = re.findall(r"^- \*\*(\w+)\*\*: \S", newest.partition("### Growth")[2].partition("\n### ")[0], re.MULTILINE)
    grown = [name for name in now if name in INSTALLED and _growth(now[name], before[name]) > ADMITTED]
    return [name for name in grown if name not in said]


def _growth(now: dict[str, int], before: dict[str, int]) -> float:
    return max(now[head] / before[head] - 1 for head in ("lines", "statements"))


def table(now: Sizes, before: Sizes, release: str) -> Iterable[str]:
    """Lines of the table, the sum last."""
    yield f"{'':<15}" + "".join(f"{head:>12}{release:>9}" for head in HEADS)
    for name in (*PARTS, "all"):
        rows = [one[name] if name != "all" else {h: sum(v[h] for v in one.values()) for h in HEADS} for one in (now, before)]
        yield f"{name:<15}" + "".join(f"{rows[0][head]:>12,}{rows[1][head]:>9,}" for head in HEADS)


def main() -> int:
    parser = argparse.ArgumentParser(description="Files, lines and statements of each package beside the last release.")
    parser.add_argument("--release", action="store_true", help="keep the sizes of now as those of the release in pyproject.toml")
    now = sizes()
    if parser.parse_args().release:
        version = re.search(r'^version = "(.+)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
        assert version is not None
        RELEASE.write_text(json.dumps({"release": version[1], "sizes": now}, indent=1) + "\n", encoding="utf-8")
        return 0
    kept = json.loads(RELEASE.read_text(encoding="utf-8"))
    print("\n".join(table(now, kept["sizes"], kept["release"])))
    missing = unexplained(now, kept["sizes"], (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
    for name in missing:
        print(
            f"{name} grew by {100 * _growth(now[name], kept['sizes'][name]):.1f} %: CHANGELOG.md must say under '### Growth' what"
        )
        print(f"a user can now do, in a line that begins with '- **{name}**: '")
    return 1 if missing else 0


if __name__ == "__main__":
    raise SystemExit(main())
