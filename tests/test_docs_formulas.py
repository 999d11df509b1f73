"""The table of formulas: every function that it names is there, and the example in its docstring is right."""

from __future__ import annotations

import doctest
import importlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

PAGE = (Path(__file__).parents[1] / "docs" / "api" / "formulas.md").read_text(encoding="utf-8")
ROLE = re.compile(r"\{py:\w+\}`(?:[^`<]*<)?~?([\w.]+)>?`")
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
FORMULAS = (
    "Hertz law",
    "flat-and-rounded law",
    "power law",
    "Ciavarella-Jaeger superposition",
    "Cattaneo-Mindlin traction",
    "memory curve",
    "Masing reversal",
    "Coulomb limit",
    "permanent stick zone",
    "slip outside the stick zone",
    "relative tangential displacement",
    "pointwise dissipation",
    "global dissipation",
    "W of a steady ellipse",
    "hysteresis damping",
    "gross-sliding check",
    "separation",
    "Abel transform",
    "events",
    "return mapping",
    "static condensation (Schur complement)",
    "Flamant far field",
    "dual mortar",
    "active set",
)


def rows(page: str) -> list[list[str]]:
    """The table's rows, four cells each: formula, equation, function, source."""
    found = [re.split(r"(?<!\\)\|", line)[1:-1] for line in page.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in row] for row in found if row[0].strip() != "formula"]


def load(target: str) -> tuple[Any, Any]:
    """The module and the object of a dotted name."""
    parts = target.split(".")
    for cut in range(len(parts) - 1, 0, -1):
        try:
            module = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        found = module
        for part in parts[cut:]:
            found = getattr(found, part)
        return module, found
    raise ModuleNotFoundError(target)


def fault(target: str, load: Callable[[str], tuple[Any, Any]] = load) -> str:
    """What is wrong with a function of the table, "" if nothing is."""
    try:
        module, found = load(target)
    except (ModuleNotFoundError, AttributeError):
        return f"{target}: there is no such function"
    examples: Sequence[doctest.DocTest] = doctest.DocTestFinder(recurse=False).find(found, target, module)
    if not any(one.examples for one in examples):
        return f"{target}: no example in its docstring"
    said: list[str] = []
    runner = doctest.DocTestRunner(optionflags=FLAGS, verbose=False)
    for one in examples:
        runner.run(one, out=said.append)
    return "".join(said)


TABLE = rows(PAGE)
TARGETS = sorted({target for row in TABLE for target in ROLE.findall(row[2])})


def test_the_table_holds_every_formula_with_function_and_source() -> None:
    assert all(len(row) == 4 and all(row) and ROLE.search(row[2]) for row in TABLE)
    missing = [name for name in FORMULAS if not any(row[0].startswith(name) for row in TABLE)]
    assert not missing


@pytest.mark.parametrize("target", TARGETS)
def test_the_example_of_each_function_is_right(target: str) -> None:
    assert not fault(target)


def test_a_missing_function_a_missing_example_and_a_wrong_one_are_seen() -> None:
    def bare() -> None:
        """No example."""

    def wrong() -> None:
        """A wrong one.

        >>> 1 + 1
        3
        """

    assert "no such function" in fault("semi_analytic.hertz.no_such_function")
    assert "no such function" in fault("no_such_package.function")
    assert "no example" in fault("bare", lambda _: (None, bare))
    assert "Expected:\n    3" in fault("wrong", lambda _: (None, wrong))
