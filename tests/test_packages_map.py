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
from importlib import import_module
from importlib.metadata import distributions
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest

from command_line import COARSE, ROOT

BENCHMARKS = ROOT / "benchmarks"
PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")


# ---------------------------------------------------------------------------------- names and files
def named(text: str | None) -> Counter[str]:
    """Files that a docstring names, with how often."""
    return Counter(re.findall(r"\b\w+\.py\b", text or ""))


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


def test_no_module_of_the_benchmarks_has_the_name_of_one_of_the_tests() -> None:
    """Some of either import some of the other, all by plain names: whoever comes second would get
    the wrong one.
    """
    one, other = (
        {path.name for path in (ROOT / folder).glob("*.py")} for folder in ("benchmarks", "tests")
    )
    assert one & other == set()


def imported(text: str, modules: set[str]) -> set[str]:
    """Modules that a file imports, wherever in it, for types alone too; of a package its
    `__init__`.
    """
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    names = {
        (node.module or "", f"{node.module}.{name.name}") for node in nodes for name in node.names
    }
    return {whole if whole in modules else part for part, whole in names if {part, whole} & modules}


def circle(package: str, texts: dict[str, str]) -> set[str]:
    """What is left when modules that import none of those left are taken away, again and again:
    nothing, without a circle.
    """
    left = {name: imported(text, set(texts)) for name, text in texts.items() if name != package}
    while last := {name for name, needs in left.items() if not needs & left.keys() - {name}}:
        left = {name: needs for name, needs in left.items() if name not in last}
    return set(left)


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
    assert circle(
        "a",
        {
            "a": "",
            "a.b": "from a import c",
            "a.c": "from a.d import x",
            "a.d": "def f():\n from a.b import y",
        },
    ) == {*("a.b", "a.c", "a.d")}


@pytest.mark.parametrize("name", ["charts", "cli", "comparison", "page"])
def test_what_the_rest_of_reports_takes_of_a_folder_is_on_its_map(name: str) -> None:
    """Its docstring, or its `__all__`, names what it offers; all else may change with the folder
    alone.
    """
    module = import_module(f"reports.{name}")
    offered = {*re.findall(r"`(\w+)`", module.__doc__ or ""), *getattr(module, "__all__", ())}
    others = [path for path in (ROOT / "reports").rglob("*.py") if path.parent.name != name]
    nodes = [
        node for path in others for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    ]
    froms = [
        node
        for node in nodes
        if isinstance(node, ast.ImportFrom) and f"{node.module}.".startswith(f"reports.{name}.")
    ]
    modules = {path.stem for path in (ROOT / "reports" / name).glob("*.py")}
    assert {one.name for node in froms for one in node.names} - modules <= offered


def test_charts_import_nothing_of_reports_but_charts_and_units() -> None:
    for path in (ROOT / "reports" / "charts").glob("*.py"):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        names = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
        names += [
            alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names
        ]
        other = [
            n
            for n in names
            if n.split(".")[0] == "reports"
            and not n.startswith(("reports.charts", "reports.units"))
        ]
        assert not other, f"{path.name}: {other}"


STUDIES = re.compile(r"reports\.studies\.\w+(\.\w+)*|studies\.[a-z.]+commands(:\w+)?")


def test_the_core_of_reports_names_studies_in_the_tables_of_the_command_line_alone() -> None:
    """Imports are a contract in pyproject.toml; strings, which import by name, are looked at here.

    Each name is that of a module that is there, and of its function.
    """
    names: dict[str, set[str]] = {}
    for path in (ROOT / "reports").rglob("*.py"):
        if "studies" in path.relative_to(ROOT).parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and STUDIES.fullmatch(str(node.value)):
                names.setdefault(path.name, set()).add(str(node.value))
    assert names.keys() == {"application.py", "solving.py"}
    for name in names["application.py"] | names["solving.py"]:
        module, _, function = name.removeprefix("reports.").partition(":")
        assert not function or callable(getattr(import_module(f"reports.{module}"), function))


def test_the_map_has_each_folder_of_reports_and_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every statement is in one row; a size on the page moves only when it is off by a hundred."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    architecture, sizes = import_module("architecture"), import_module("sizes")
    floors = {part.name: part.paths for part in architecture.packages()}
    assert floors.keys() == {*PACKAGES, "reports.studies"}
    for parts in (architecture.packages()[-2:], architecture.folders()):
        paths = [path for part in parts for path in part.paths]
        counted = sum(sizes.size(path).statements for path in paths)
        assert counted == sizes.size("reports").statements
    part = [architecture.Part("meshes", "meshes", "", ("meshes",))]
    statements = sizes.size("meshes").statements
    for written, shown in ((statements + 99, statements + 99), (9999, round(statements, -2))):
        page = f"| `meshes` | meshes | {written:,} |"
        assert next(architecture.rows(part, page))[-1] == f"{shown:,}"


ORDER = {"scenes": 0, "meshes": 1, "semi_analytic": 2, "halfplane_fe": 2, "reports": 3}
"""The floor of each package: it may import those of lower floors, and itself."""


def names_of_modules(node: ast.AST) -> list[str]:
    """Packages of ours that a call imports by a string; f-strings count by how they begin."""
    if not isinstance(node, ast.Call):
        return []
    function = node.func
    name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    if name not in {"import_module", "__import__", "find_spec", "resolve_name"}:
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
    names = [name for node in ast.walk(ast.parse(text)) for name in names_of_modules(node)]
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


def test_nothing_in_the_project_reads_the_folder_beside_it() -> None:
    """Code, tests, benchmarks, pages and settings; the name stands here in two parts, so that this
    file is judged too.
    """
    outside = "../" + "shared"
    suffixes = {
        ".py",
        ".md",
        ".toml",
        ".ipynb",
        ".yml",
        ".yaml",
        ".sh",
        ".jinja",
        ".html",
        ".js",
        ".css",
    }
    below = [
        path
        for folder in (*PACKAGES, "tests", "benchmarks", ".ci", "docs")
        for path in (ROOT / folder).rglob("*")
    ]
    files = [
        path for path in (*below, *ROOT.iterdir()) if path.is_file() and "_build" not in path.parts
    ]
    read = [path for path in files if path.suffix in suffixes or path.name in ("Makefile", "run")]
    assert len(read) > 300
    assert not [path for path in read if outside in path.read_text(encoding="utf-8")]


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
    others = {"halfplane", "pip", "setuptools"}
    ours = {
        packages.plain(found.name): found.version
        for found in distributions()
        if found.name not in others
    }
    assert {name: pinned.get(name) for name in ours} == ours


@pytest.mark.slow
def test_installed_packages_fit_together() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


def test_every_command_runs_from_an_installed_wheel(
    tmp_path: Path, tool: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the coarsest mesh."""
    packages, coarse = tool("packages"), " ".join((*COARSE, "--quiet"))
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
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_line_of_costly_names_a_test(request: pytest.FixtureRequest) -> None:
    """Of the files that were collected whole; a file that is not there at all is a stale line
    too.
    """
    here, config = Path(__file__).parent, request.config
    costly = set((here / "costly.txt").read_text(encoding="utf-8").splitlines())
    found = {item.nodeid.removeprefix("tests/") for item in request.session.items}
    whole = (
        not any("::" in name for name in config.args)
        and not config.getoption("lf")
        and not config.getoption("keyword")
    )
    collected = (
        {name.split("::")[0] for name in found}
        if whole and not config.getoption("markexpr")
        else set()
    )
    lost = {
        name
        for name in costly - found
        if name.split("::")[0] in collected or not (here / name.split("::")[0]).exists()
    }
    assert lost == set()


# ---------------------------------------------------------- the way of a scene, and where things go
def test_the_ten_functions_of_the_way_exist_and_say_what_they_do() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    names = re.findall(r"^ ?\d+  (\S+) ", page, re.M)
    assert len(names) == 10
    for name in names:
        assert resolve_name(name).__doc__, name


def test_the_files_of_the_recipes_exist() -> None:
    page = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
    recipes = page.partition("## Where to put it")[2].partition("\n## ")[0]
    files = re.findall(r"`((?:\w+/)+\w+\.py)`", recipes)
    tests = re.findall(r"`(test_\w+\.py)`", recipes)
    assert len(files) > 5
    assert len(tests) > 5
    missing = [
        file
        for file in [*files, *(f"tests/{name}" for name in tests)]
        if not (ROOT / file).exists()
    ]
    assert not missing
