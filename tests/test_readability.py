"""How densely each package is packed: five figures by the syntax tree, each with its limit.

The figures are symptoms. What counts is that a stranger can say what a function does.
"""

import ast
from collections import Counter
from pathlib import Path

import pytest
from sizes import PARTS, parsed

ROOT = Path(__file__).parents[1]

# Parallel and nested: per 1,000 statements. Empty names: per cent of all that are bound. Lines over
# 100 columns and functions of more than seven parameters: counted.
GOALS = {"parallel": 6.0, "nested": 1.5, "empty": 2.0, "wide": 0, "many": 1}
# Numerical signatures that users call by keyword, and commands, have as many parameters as there
# are quantities.
LISTED = {"dissipation", "peak_dissipation", "friction_from", "follow_instants", "score"}

# Adjectives, participles and pronouns without their noun, and fillers. Words that are right in
# mechanics (left, right, part of a path) are not among them.
SAY_NOTHING = """
    found one ones own whole others other thing things some both such here there what which who
    said told says given taken got had has been done made did again still only even just more less
    much many few seen wanted asked kept shown beside apart alike these those them it its this that
    data result results res ret temp tmp obj item items stuff info val vals foo bar the_value
    new_value
"""
FORBIDDEN = frozenset(SAY_NOTHING.split())
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.GeneratorExp, ast.DictComp)
SEQUENCES = (ast.Tuple, ast.List)
# All that counts towards a figure, of the ten times as many nodes of a file.
COUNTED = (ast.stmt, ast.Name, ast.arg, ast.IfExp, ast.Lambda, *COMPREHENSIONS)


def is_parallel(node: ast.Assign) -> bool:
    """Whether values stand side by side in one assignment; a swap is none."""
    target = node.targets[0]
    if not (isinstance(target, SEQUENCES) and isinstance(node.value, SEQUENCES)):
        return False
    names = sorted(map(ast.unparse, target.elts))
    return names != sorted(map(ast.unparse, node.value.elts))


def is_nested(node: ast.expr) -> bool:
    """Whether a conditional, a comprehension or a lambda stands inside another of its kind."""
    kind = COMPREHENSIONS if isinstance(node, COMPREHENSIONS) else type(node)
    return any(child is not node and isinstance(child, kind) for child in ast.walk(node))


def has_many_parameters(node: ast.FunctionDef) -> bool:
    """Whether there are more than seven, where the function is not listed."""
    arguments = node.args
    names = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    return len(names) > 7 and node.name not in LISTED


def counts(text: str) -> Counter:
    """What a file counts towards each figure."""
    count: Counter = Counter()
    names = []
    for node in ast.walk(parsed(text)):
        if not isinstance(node, COUNTED) or isinstance(getattr(node, "ctx", None), ast.Load):
            continue
        count["statements"] += isinstance(node, ast.stmt)
        match node:
            case ast.Name(ctx=ast.Store()):
                names.append(node.id)
            case ast.arg():
                names.append(node.arg)
            case ast.FunctionDef():
                names.append(node.name)
                count["many"] += has_many_parameters(node)
            case ast.ClassDef():
                names.append(node.name)
            case ast.Assign():
                count["parallel"] += is_parallel(node)
            case ast.IfExp() | ast.Lambda() | ast.ListComp() | ast.SetComp():
                count["nested"] += is_nested(node)
            case ast.GeneratorExp() | ast.DictComp():
                count["nested"] += is_nested(node)
    count["names"] = len(names)
    count["empty"] = sum(name.strip("_") in FORBIDDEN for name in names)
    count["wide"] = sum(len(line) > 100 for line in text.splitlines())
    return count


def figures(package: str) -> dict[str, float]:
    """The five figures of a package."""
    total: Counter = Counter()
    for file in sorted((ROOT / package).rglob("*.py")):
        total += counts(file.read_text(encoding="utf-8"))
    return {
        "parallel": 1000 * total["parallel"] / total["statements"],
        "nested": 1000 * total["nested"] / total["statements"],
        "empty": 100 * total["empty"] / total["names"],
        "wide": total["wide"],
        "many": total["many"],
    }


@pytest.mark.parametrize("package", PARTS)
def test_a_package_is_no_denser_than_it_may_be(package: str) -> None:
    measured = figures(package)
    over = {name: value for name, value in measured.items() if value > GOALS[name]}
    assert not over, f"{package}: {over}, limits {GOALS}"


def test_each_figure_sees_what_it_is_made_for() -> None:
    dense = counts(
        "a, b = 1, c\n"
        "found = [[x for x in row] for row in rows]\n"
        "def f(a, b, c, d, e, f, g, h):\n"
        "    pass\n" + "#" * 101 + "\n"
    )
    assert {name: dense[name] for name in GOALS} == dict.fromkeys(GOALS, 1)
    plain = counts("a, b = b, a\nratio = [x for x in row]\ndef f(a):\n    left, right = ends(a)\n")
    assert not any(plain[name] for name in GOALS)
