"""How large each part of the project is: files, statements, and names that a user may import.

    python benchmarks/sizes.py

A table to read, no gate: joining statements is no removal.
"""

from __future__ import annotations

import ast
import gc
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PARTS = (
    "scenes",
    "semi_analytic",
    "meshes",
    "halfplane_fe",
    "reports",
    "benchmarks",
    "tests",
    "docs",
)


class Size(NamedTuple):
    """Of one part of the project."""

    files: int
    statements: int
    public_names: int


def parsed(text: str) -> ast.Module:
    """The syntax tree of a file; the search for garbage among its nodes while they are made would
    take half of the time.
    """
    gc.disable()
    try:
        return ast.parse(text)
    finally:
        gc.enable()


def statements(tree: ast.AST) -> int:
    """Statements at every depth, without docstrings and other lone strings.

    >>> statements(ast.parse('def f():\\n    "what it does"\\n    return 1\\n'))
    2
    """
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.stmt)]
    return sum(
        not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)) for node in nodes
    )


def public_names(tree: ast.Module) -> set[str]:
    """Functions, classes, methods and constants whose name has no leading underscore.

    >>> sorted(
    ...     public_names(
    ...         ast.parse(
    ...             "A = 1\\n_b = 2\\nclass C:\\n    def d(self): ...\\n    def _e(self): ...\\n"
    ...         )
    ...     )
    ... )
    ['A', 'C', 'C.d']
    """
    names = set()
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            names |= {
                f"{node.name}.{method.name}"
                for method in node.body
                if isinstance(method, ast.FunctionDef)
            }
        if isinstance(node, ast.Assign):
            names |= {target.id for target in node.targets if isinstance(target, ast.Name)}
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            names.add(node.target.id)
    return {name for name in names if not name.startswith("_") and "._" not in name}


def size(part: str) -> Size:
    """The size of a file, or of all Python files below a folder, by its path in the project."""
    place = ROOT / part
    below = sorted(place.rglob("*.py")) if place.is_dir() else [place]
    paths = [path for path in below if "_build" not in path.parts]
    sizes = [size_of_file(path) for path in paths]
    return Size(*map(sum, zip(*sizes, strict=True))) if sizes else Size(0, 0, 0)


@cache
def size_of_file(path: Path) -> Size:
    """The size of one file, which is parsed once in a process."""
    tree = parsed(path.read_text(encoding="utf-8"))
    return Size(1, statements(tree), len(public_names(tree)))


def main() -> None:
    """Print the table."""
    sizes = {part: size(part) for part in PARTS}
    sizes["all"] = Size(*map(sum, zip(*sizes.values(), strict=True)))
    print(f"{'':<15}" + "".join(f"{head.replace('_', ' '):>14}" for head in Size._fields))
    for part, numbers in sizes.items():
        print(f"{part:<15}" + "".join(f"{number:>14,}" for number in numbers))


if __name__ == "__main__":
    main()
