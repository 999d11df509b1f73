"""Packages: each file on its map, imports in no circle, the interface shown, pins and licences, a
wheel that runs.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections import Counter
from dataclasses import is_dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import distributions
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest
from sizes import parsed

from command_line import COARSE, ROOT

BENCHMARKS = ROOT / "benchmarks"
PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")


# ---------------------------------------------------------------------------------- names and files
def named(text: str | None) -> Counter[str]:
    """Files that a docstring names, with how often."""
    return Counter(re.findall(r"\b\w+\.py\b", text or ""))


@pytest.mark.parametrize("package", PACKAGES)
def test_records_that_a_package_gives_are_frozen(package: str) -> None:
    module = import_module(package)
    public = [getattr(module, name) for name in module.__all__]
    records = [each for each in public if isinstance(each, type) and is_dataclass(each)]
    assert len(records) > 3
    for record in records:
        assert record.__dataclass_params__.frozen, record


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_shows_its_interface_and_has_each_file_on_its_map_once(package: str) -> None:
    """No module of it has the name of a public function."""
    module = import_module(package)
    assert dir(module) == sorted(module.__all__)
    files = {path.name for path in (ROOT / package).glob("*.py")} - {"__init__.py"}
    if package != "reports":
        assert named(module.__doc__) == Counter(files)
    if package in ("scenes", "semi_analytic"):
        assert not {name.removesuffix(".py") for name in files} & set(module.__all__)


def test_tab_completion_of_a_scene_and_a_solution_shows_keys_and_methods_only() -> None:
    scene = import_module("scenes").load_scene("hertz-normal")
    solution = import_module("semi_analytic").solve(scene)
    assert set(dir(scene.friction)) == {"coefficient", "vary"}
    assert {*type(scene).model_fields, "save", "vary"} <= set(dir(scene))
    assert {"pressure", "dissipation", "to_dataset", "plot"} <= set(dir(solution))
    hidden = {"model_dump", "copy", "merged"}
    assert not [
        name
        for name in (*dir(scene), *dir(scene.load), *dir(solution))
        if name.startswith("_") or name in hidden
    ]


# `from module import names` in one line or in parentheses, and `import module`; no file has two
# statements in a line (ruff).
IMPORT = re.compile(r"^[ \t]*(?:from ([\w.]+) import (\([^)]*\)|.+)|import ([\w.]+))", re.MULTILINE)
COMMENT = re.compile(r"#.*")


@cache
def imports_of(text: str) -> list[tuple[str, str]]:
    """(module, name) of every `from ... import ...` in a file, wherever, for types alone too;
    (module, "") of a plain import. By lines: to parse all files takes seconds.
    """
    pairs = []
    for home, names, module in IMPORT.findall(text):
        if module:
            pairs.append((module, ""))
        else:
            bare = COMMENT.sub("", names).strip("() \n").rstrip(", \n")
            pairs += [(home, name.split()[0]) for name in bare.split(",")]
    return pairs


def imported(text: str, modules: set[str]) -> set[str]:
    """Those of `modules` that a file imports; of a package its `__init__`."""
    dotted = {(f"{module}.{name}", module) for module, name in imports_of(text)}
    return {full if full in modules else module for full, module in dotted} & modules


def circle(package: str, texts: dict[str, str]) -> set[str]:
    """What is left when modules that import none of those left are taken away, again and again:
    nothing, without a circle.
    """
    waiting = {name: imported(text, set(texts)) for name, text in texts.items() if name != package}
    while leaf := {name for name, needs in waiting.items() if not needs & waiting.keys() - {name}}:
        waiting = {name: needs for name, needs in waiting.items() if name not in leaf}
    return set(waiting)


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_go_round_in_no_circle(package: str) -> None:
    """Through all folders of reports too, and for imports for types alone."""
    files = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): path
        for path in (ROOT / package).rglob("*.py")
    }
    texts = {
        name.removesuffix(".__init__"): path.read_text(encoding="utf-8")
        for name, path in files.items()
    }
    assert circle(package, texts) == set()


def test_a_circle_of_imports_is_seen() -> None:
    circular = {"a.b": "from a import c", "a.c": "from a.d import x"}
    circular["a.d"] = "def f():\n from a.b import y"
    assert circle("a", {"a": "", **circular}) == set(circular)


@pytest.mark.parametrize("name", ["charts", "cli", "comparison", "page"])
def test_what_the_rest_of_reports_takes_of_a_folder_is_on_its_map(name: str) -> None:
    """Its docstring, or its `__all__`, names what it offers; all else may change with the folder
    alone.
    """
    module = import_module(f"reports.{name}")
    offered = {*re.findall(r"`(\w+)`", module.__doc__ or ""), *getattr(module, "__all__", ())}
    elsewhere = [path for path in (ROOT / "reports").rglob("*.py") if path.parent.name != name]
    imported_names = {
        word
        for path in elsewhere
        for home, word in imports_of(path.read_text(encoding="utf-8"))
        if f"{home}.".startswith(f"reports.{name}.")
    }
    modules = {path.stem for path in (ROOT / "reports" / name).glob("*.py")}
    assert imported_names - modules <= offered


def test_charts_import_nothing_of_reports_but_charts_and_units() -> None:
    for path in (ROOT / "reports" / "charts").glob("*.py"):
        homes = {module for module, _ in imports_of(path.read_text(encoding="utf-8"))}
        of_reports = {module for module in homes if module.split(".")[0] == "reports"}
        allowed = ("reports.charts", "reports.units")
        assert all(module.startswith(allowed) for module in of_reports), path.name


def test_the_map_has_each_folder_of_reports_and_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every statement is in one row."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    architecture = import_module("architecture")
    sizes = import_module("sizes")
    floors = {part.name: part.paths for part in architecture.packages()}
    assert floors.keys() == {*PACKAGES, "reports.studies"}
    for parts in (architecture.packages()[-2:], architecture.folders()):
        paths = [path for part in parts for path in part.paths]
        counted = sum(sizes.size(path).statements for path in paths)
        assert counted == sizes.size("reports").statements


ORDER = {"scenes": 0, "meshes": 1, "semi_analytic": 2, "halfplane_fe": 2, "reports": 3}
"""The floor of each package: it may import those of lower floors, and itself."""


BY_STRING = {"import_module", "__import__", "find_spec", "resolve_name"}


def names_of_modules(node: ast.AST) -> list[str]:
    """Packages of ours that a call imports by a string; f-strings count by how they begin."""
    if not isinstance(node, ast.Call):
        return []
    function = node.func
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    if name not in BY_STRING:
        return []
    strings = [
        part.value
        for argument in node.args
        for part in ast.walk(argument)
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
    ]
    return [text.split(".")[0] for text in strings if text.split(".")[0] in ORDER]


def upward_imports(package: str, text: str) -> list[str]:
    """Packages on a higher floor, or beside this one, that a module imports by a string."""
    names = []
    if any(function in text for function in BY_STRING):
        names = [name for node in ast.walk(parsed(text)) for name in names_of_modules(node)]
    return [name for name in names if name != package and ORDER[name] >= ORDER[package]]


@pytest.mark.parametrize("package", PACKAGES)
def test_no_package_imports_a_higher_floor_by_a_string(package: str) -> None:
    """Import contracts see import statements alone."""
    for path in (ROOT / package).rglob("*.py"):
        assert upward_imports(package, path.read_text(encoding="utf-8")) == [], path.name


def test_an_import_by_a_string_is_seen() -> None:
    assert upward_imports("scenes", 'import_module("reports.page")') == ["reports"]
    assert upward_imports("meshes", 'importlib.import_module(f"halfplane_fe.{name}")') != []
    assert upward_imports("semi_analytic", '__import__("halfplane_fe")') == ["halfplane_fe"]
    assert upward_imports("reports", 'import_module("scenes.files")') == []
    assert upward_imports("reports", 'import_module("reports.units")') == []


# -------------------------------------------------------------------------------- what pip installs
@pytest.fixture
def tool(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module of the benchmarks by its name."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return import_module


def test_licences_bounds_pythons_and_pins(tool: Any) -> None:
    """The table of licences is that of what is installed; requirements have lower bounds; all that
    is installed is pinned.
    """
    packages = tool("packages")
    assert packages.LICENCES.read_text(encoding="utf-8") == packages.licences()
    assert {"numpy", "gmsh", "markupsafe"} <= packages.closure().keys()
    assert "not stated" not in packages.licences()
    lowest = packages.lowest()
    assert len(lowest) >= 16
    assert all(pin.count("==") == 1 for pin in lowest)

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    oldest, *_, newest = re.findall(
        r"Python :: (3\.\d+)", " ".join(project["project"]["classifiers"])
    )
    assert project["project"]["requires-python"] == f">={oldest}"
    assert project["tool"]["mypy"]["python_version"] == oldest
    assert "target-version" not in project["tool"]["ruff"]  # ruff takes requires-python
    assert f"Any Python from {oldest} to {newest}" in (ROOT / "README.md").read_text(
        encoding="utf-8"
    )

    beyond = f"3.{int(newest.partition('.')[2]) + 1}"
    assert project["tool"]["uv"]["environments"] == [
        f"sys_platform == 'linux' and python_version < '{beyond}'"
    ]

    # On the newest Python too, where a requirement may hold that the oldest does not have.
    lines = packages.PINS.read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in pins)
    pinned = {packages.plain(word): word.partition("==")[2] for word in pins}
    assert len(pinned) == len(pins)
    unpinned = {"halfplane", "pip", "setuptools"}
    ours = {
        packages.plain(package.name): package.version
        for package in distributions()
        if package.name not in unpinned
    }
    assert {name: pinned.get(name) for name in ours} == ours


@pytest.mark.slow
def test_installed_packages_fit_together() -> None:
    process = subprocess.run(
        [sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stdout


def test_every_command_runs_from_an_installed_wheel(
    tmp_path: Path, tool: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the coarsest mesh."""
    packages = tool("packages")
    coarse = " ".join((*COARSE, "--quiet"))
    commands = {
        words.replace(packages.COARSE, coarse): code for words, code in packages.COMMANDS.items()
    }
    monkeypatch.setattr(packages, "COMMANDS", commands)
    assert packages.every_command(tmp_path / "environment", tmp_path / "there") == []


@pytest.mark.slow
# The lower bounds are older than Python 3.14, so without wheels for it.
@pytest.mark.parametrize("kind", ["pinned", *(["lowest"] if sys.version_info < (3, 14) else [])])
def test_the_wheel_runs_outside_the_checkout(kind: str, tmp_path: Path) -> None:
    command = [sys.executable, str(BENCHMARKS / "packages.py"), kind, str(tmp_path / "environment")]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == 0, process.stdout + process.stderr


def test_every_line_of_costly_names_a_test(request: pytest.FixtureRequest) -> None:
    """Of the files that were collected whole; a file that is not there at all is a stale line
    too.
    """
    folder = Path(__file__).parent
    config = request.config
    costly = set((folder / "costly.txt").read_text(encoding="utf-8").splitlines())
    collected = {test.nodeid.removeprefix("tests/") for test in request.session.items}
    stale = {name for name in costly if not (folder / name.split("::")[0]).exists()}
    selected = any("::" in name for name in config.args)
    if not (selected or any(map(config.getoption, ("lf", "keyword", "markexpr")))):
        files = {name.split("::")[0] for name in collected}
        stale |= {name for name in costly - collected if name.split("::")[0] in files}
    assert stale == set()


# ---------------------------------------------------------- the way of a scene, and where things go
def test_the_functions_and_files_that_pages_name_exist() -> None:
    """The ten functions of a scene's way say what they do; recipes name files and tests."""
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    names = re.findall(r"^ ?\d+  (\S+) ", page, re.M)
    assert len(names) == 10
    assert all(resolve_name(name).__doc__ for name in names)
    page = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
    recipes = page.partition("## Where to put it")[2].partition("\n## ")[0]
    files = re.findall(r"`((?:\w+/)+\w+\.py)`", recipes)
    files += [f"tests/{name}" for name in re.findall(r"`(test_\w+\.py)`", recipes)]
    assert len(files) > 10
    assert [file for file in files if not (ROOT / file).exists()] == []
