"""Each package says in its docstring which file holds what: every file is there, and nothing that is not."""

import ast
import re
from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest


def named(text):
    """Files that a docstring names, with how often."""
    return Counter(re.findall(r"\b\w+\.py\b", text))


@pytest.mark.parametrize("package", ["scenes", "semi_analytic", "meshes", "halfplane_fe"])
def test_every_file_has_its_place_on_the_map_once(package):
    module = import_module(package)
    files = {path.name for path in Path(module.__file__).parent.glob("*.py")} - {"__init__.py"}
    assert named(module.__doc__) == Counter(files)


def test_a_file_that_is_missing_or_named_twice_is_noticed():
    assert named("one.py, two.py") != Counter({"one.py"})
    assert named("one.py, one.py") != Counter({"one.py"})


def test_no_module_of_the_benchmarks_has_the_name_of_one_of_the_tests() -> None:
    """Some of either import some of the other, all by plain names: whoever comes second would get the wrong one."""
    one, other = ({path.name for path in (Path(__file__).parents[1] / folder).glob("*.py")} for folder in ("benchmarks", "tests"))
    assert one & other == set()


def imported(file, package):
    """Modules of the package that a file imports, wherever in it, for types alone too."""
    nodes = [node for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(node, ast.ImportFrom)]
    names = {f"{node.module}.{name.name}" for node in nodes for name in node.names} | {node.module for node in nodes}
    return {name.split(".")[1] for name in names if name and name.startswith(f"{package}.")}


@pytest.mark.parametrize("package", ["scenes", "semi_analytic", "meshes", "halfplane_fe"])
def test_imports_go_round_in_no_circle(package):
    """Taking away, again and again, the modules that import none of those left leaves nothing."""
    folder = Path(import_module(package).__file__).parent
    left = {path.stem: imported(path, package) for path in folder.glob("*.py") if path.stem != "__init__"}
    while last := {name for name, needs in left.items() if not needs & left.keys() - {name}}:
        left = {name: needs for name, needs in left.items() if name not in last}
    assert not left


def imported_at_run_time(file: Path, modules: set[str]) -> set[str]:
    """Modules that a file imports, wherever in it, but for the checker of types; of a package its `__init__`."""
    parts = [
        part for part in ast.parse(file.read_text(encoding="utf-8")).body if not ast.unparse(part).startswith("if TYPE_CHECKING")
    ]
    nodes = [node for part in parts for node in ast.walk(part) if isinstance(node, ast.ImportFrom)]
    names = {(node.module or "", f"{node.module}.{name.name}") for node in nodes for name in node.names}
    return {whole if whole in modules else part for part, whole in names if {part, whole} & modules}


def test_imports_of_reports_go_round_in_no_circle() -> None:
    """The same through all folders of reports; a module stands for its file, a package for its `__init__.py`."""
    root = Path(import_module("reports").__file__ or "").parents[1]
    files = {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
        for path in (root / "reports").rglob("*.py")
    }
    left = {name: imported_at_run_time(path, set(files)) for name, path in files.items() if name != "reports"}
    while last := {name for name, needs in left.items() if not needs & left.keys() - {name}}:
        left = {name: needs for name, needs in left.items() if name not in last}
    assert not left


@pytest.mark.parametrize("package", ["scenes", "semi_analytic"])
def test_no_module_has_the_name_of_a_public_function(package):
    module = import_module(package)
    assert not {path.stem for path in Path(module.__file__).parent.glob("*.py")} & set(module.__all__)
