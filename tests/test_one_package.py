"""`import halfplane`: its names, the wheel that has the five packages inside it, and the two names
of each package, beside a user's own modules.
"""

from __future__ import annotations

import ast
import csv
import doctest
import io
import json
import math
import os
import re
import subprocess
import sys
import sysconfig
import venv
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import halfplane
import reports
import scenes
from command_line import COARSE, ROOT
from halfplane.package_names import PACKAGES


@pytest.fixture(scope="module")
def build() -> ModuleType:
    """The build hook, which lies at the top of the project."""
    sys.path.insert(0, str(ROOT))
    try:
        return import_module("hatch_build")
    finally:
        sys.path.remove(str(ROOT))


@pytest.fixture(scope="module")
def tree(build: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package `halfplane` as the wheel has it."""
    folder = tmp_path_factory.mktemp("wheel")
    build.write_tree(ROOT, folder / "halfplane")
    return folder


def run_python(
    words: list[str], folder: Path, *places: Path | str, python: str = sys.executable
) -> subprocess.CompletedProcess[str]:
    """Python in `folder`, which stands before `places` on its search path."""
    search = os.pathsep.join(map(str, (folder, *places)))
    environment = os.environ | {"PYTHONPATH": search, "MPLBACKEND": "Agg"}
    return subprocess.run(
        [python, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


# ---------------------------------------------------------------------------------------- the names
def test_the_names_are_those_of_the_packages() -> None:
    assert halfplane.load_scene is scenes.load_scene
    assert halfplane.Scene is scenes.Scene
    assert halfplane.compare is reports.compare
    assert halfplane.report is reports.write
    assert halfplane.theory is import_module("semi_analytic").solve
    assert halfplane.finite_elements is import_module("halfplane_fe").solve
    assert halfplane.body_effects is import_module("halfplane_fe").body_effects
    assert halfplane.advise is import_module("reports.advising").advise
    assert dir(halfplane) == sorted(halfplane.__all__)
    assert re.match(r"\d+\.\d+\.\d+", halfplane.__version__)
    with pytest.raises(AttributeError, match="module 'halfplane' has no attribute 'solve'"):
        halfplane.solve  # noqa: B018


def test_a_name_is_loaded_when_it_is_first_used() -> None:
    """Neither numpy nor one of the five packages before."""
    words = "import sys; before = set(sys.modules); import halfplane\n"
    words += "print(*sorted(set(sys.modules) - before))"
    done = run_python(["-S", "-c", words], ROOT, ROOT)
    assert done.returncode == 0, done.stderr
    ours = {name for name in done.stdout.split() if name.startswith("halfplane")}
    assert ours == {"halfplane", "halfplane.package_names"}
    assert not {"numpy", "typing", "pathlib", *PACKAGES} & set(done.stdout.split())


def test_in_a_checkout_a_package_has_the_name_of_the_wheel_too() -> None:
    assert import_module("halfplane.scenes").Block is scenes.Block
    assert import_module("halfplane.reports.page.writing").write is reports.write
    assert halfplane.scenes.loads.EllipseLoad is scenes.EllipseLoad
    assert dir(import_module("halfplane.scenes")) == dir(scenes)
    for name in ("halfplane.gone", "halfplane.scenes.gone"):
        with pytest.raises(ModuleNotFoundError, match=f"No module named '{name}'"):
            import_module(name)


SHOWN = """
import sys, halfplane
scene = halfplane.load_scene("hertz-normal")
assert not [name for name in sys.modules if name.endswith("reports.page.notebook")]
assert "<table" in scene._repr_html_()
"""


def test_scenes_show_themselves_without_another_import() -> None:
    done = run_python(["-c", SHOWN], ROOT, ROOT)
    assert done.returncode == 0, done.stderr


def test_a_users_module_that_hides_a_package_of_a_checkout_is_named(tmp_path: Path) -> None:
    (tmp_path / "reports.py").write_text("", "utf-8")
    done = run_python(["-c", "import halfplane; halfplane.theory"], tmp_path, ROOT)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert f"Python finds {tmp_path / 'reports.py'} by that name: rename that module" in last


# ------------------------------------------------------------------------- what a script reads off


@pytest.mark.parametrize(
    ("loads", "ratio"),
    [
        ([(1, 0), (0, 0)], 0.0),
        ([(1, 0.25), (0, 0)], 0.25),
        ([(1, 0), (0, 0.1)], math.inf),
        ([(1, 0), (-1, 0)], math.inf),
    ],
)
def test_no_friction_is_enough_where_nothing_presses(
    loads: list[tuple[float, float]], ratio: float
) -> None:
    load = scenes.PolygonLoad(initial_loading=loads)
    assert scenes.load_scene("hertz-normal").vary(load=load).smallest_friction == ratio


def test_a_scene_is_shown_in_five_lines() -> None:
    for name in scenes.scene_names():
        lines = repr(scenes.load_scene(name)).splitlines()
        assert len(lines) == 5, name
        assert lines[0].startswith(f"Scene {name!r}")


def test_a_solution_as_a_table_of_instants_and_a_comparison_as_csv_and_latex() -> None:
    solution = halfplane.theory("cattaneo-mindlin")
    table = solution.to_dataframe()
    assert len(table) == len(solution.time)
    assert np.array_equal(table["tangential_load"], solution.tangential_load)
    assert np.array_equal(table["stick_edges_right"], solution.stick_edges[:, 1], equal_nan=True)
    assert "pressure" not in table

    comparison = halfplane.compare(reference=solution, result=solution)
    rows = list(csv.DictReader(io.StringIO(comparison.to_csv())))
    assert [row["key"] for row in rows] == [metric.key for metric in comparison.headlines]
    (work,) = (row for row in rows if row["key"] == "dissipation")
    assert float(work["reference"]) == solution.dissipation
    assert (work["unit"], work["error"], work["uncertainty"]) == ("N·mm/mm", "0.0", "")
    lines = comparison.to_latex().splitlines()
    assert lines[:2] == [r"\begin{tabular}{lrrrl}", r"\toprule"]
    assert len(lines) == 6 + len(rows)
    cells = [line for line in lines if line.endswith(r"\\")]
    assert all(len(re.findall(r"(?<!\\)&", line)) == 4 for line in cells)
    assert r"0 \%" in comparison.to_latex()
    assert comparison.to_latex().isascii()


# ------------------------------------------------------------------------------------ the rewriting
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from scenes import Scene", "from halfplane.scenes import Scene"),
        ("    from reports.page import (", "    from halfplane.reports.page import ("),
        ("import semi_analytic", "from halfplane import semi_analytic"),
        ('import_module("reports.units")', 'import_module("halfplane.reports.units")'),
        ('import_module(f"reports.{x}")', 'import_module(f"halfplane.reports.{x}")'),
        ('resources.files("scenes")', 'resources.files("halfplane.scenes")'),
        ('X = {"a": "reports.units"}', 'X = {"a": "halfplane.reports.units"}'),
        (
            '"""\n>>> from meshes import build\n"""',
            '"""\n>>> from halfplane.meshes import build\n"""',
        ),
        # no names of modules
        (
            'X = ("scenes", "halfplane_fe.dissipation")',
            'X = ("scenes", "halfplane_fe.dissipation")',
        ),
        ("from scenes_of_mine import x", "from scenes_of_mine import x"),
        ('"""\nfrom scenes and reports\n"""', '"""\nfrom scenes and reports\n"""'),
    ],
)
def test_imports_lead_into_the_package(build: Any, text: str, expected: str) -> None:
    if text.endswith("("):
        text, expected = f"def f():\n{text}x)", f"def f():\n{expected}x)"
    assert build.rewritten(text, ROOT) == expected


def called(node: ast.Call) -> str:
    """The name of what is called, without what stands before its last dot."""
    return str(getattr(node.func, "attr", getattr(node.func, "id", "")))


def old_names(text: str, loaders: tuple[str, ...]) -> list[str]:
    """What a module imports of the five packages by their names in the checkout, or hands to one of
    the functions that load a module or its files; in the examples of its docstrings too.
    """
    nodes = list(ast.walk(ast.parse(text)))
    for node in tuple(nodes):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and ">>> " in node.value:
            for example in doctest.DocTestParser().get_examples(node.value):
                nodes += ast.walk(ast.parse(example.source))
    names: list[object] = []
    for node in nodes:
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names.append(node.module)
        elif isinstance(node, ast.Call) and called(node) in loaders:
            inside = [part for argument in node.args for part in ast.walk(argument)]
            names += [part.value for part in inside if isinstance(part, ast.Constant)]
    return [str(name) for name in names if str(name).split(".")[0] in PACKAGES]


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("import scenes.loads", ["scenes.loads"]),
        ("import numpy, scenes", ["scenes"]),
        ("import scenes as question", ["scenes"]),
        ("if True: from scenes import Scene", ["scenes"]),
        ('files(1, "scenes")', ["scenes"]),
        ('"""\n>>> import numpy, reports\n"""', ["reports"]),
        ("from scenes import Scene", []),
    ],
)
def test_what_the_build_cannot_rewrite_is_seen(build: Any, text: str, left: list[str]) -> None:
    assert old_names(build.rewritten(text, ROOT), build.LOADERS) == left


def test_no_module_of_the_wheel_imports_an_old_name(build: Any, tree: Path) -> None:
    for path in (tree / "halfplane").rglob("*.py"):
        assert not old_names(path.read_text("utf-8"), build.LOADERS), path


def test_the_wheel_has_every_module_with_its_lines(tree: Path) -> None:
    """Nothing but names differs: the same statements on the same lines, the same files of data."""
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            copy = tree / "halfplane" / path.relative_to(ROOT)
            original_text = path.read_text("utf-8")
            text = copy.read_text("utf-8")
            assert len(text.splitlines()) == len(original_text.splitlines()), path
            assert text.replace("halfplane.", "").replace(
                "from halfplane import ", "import "
            ) == original_text.replace("halfplane.", ""), path
    inside = tree / "halfplane"
    packed = {path.relative_to(inside).as_posix() for path in inside.rglob("*") if path.is_file()}
    assert {"py.typed", "__main__.py", "package_names.py"} <= packed
    assert {"reports/templates/report.html", "scenes/library/hertz-paper.toml"} <= packed
    assert {f"{package}/py.typed" for package in PACKAGES} <= packed
    assert not [name for name in packed if "__pycache__" in name]
    assert not [name for name in packed if "reports/published" in name]


# ------------------------------------------------------------------- the wheel beside other modules
OLD_SCRIPT = """
import warnings
import halfplane.package_names  # as the .pth file of the wheel has it
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    from scenes import Scene, load_scene
    import semi_analytic
    import scenes.loads
(notice,) = caught
assert notice.category is DeprecationWarning
assert "write `from halfplane import scenes`" in str(notice.message)
assert notice.filename == __file__, notice.filename
import pickle
import halfplane
from halfplane.scenes.loads import EllipseLoad
from halfplane.scenes.files import source_digest
assert Scene is halfplane.Scene
assert scenes.loads.EllipseLoad is EllipseLoad
assert semi_analytic.solve is halfplane.theory
assert Scene.__module__ == "halfplane.scenes.scene"
assert pickle.loads(b"cscenes.scene\\nScene\\n.") is Scene
assert len(source_digest("halfplane.scenes")) == 64
import reports
assert reports.MINE
import halfplane.reports
assert halfplane.reports.compare is halfplane.compare is not None
"""


def test_old_names_work_with_a_notice_and_a_users_module_comes_first(
    tree: Path, tmp_path: Path
) -> None:
    """His `reports.py` is his; his folder of scene files, which has no code, hides nothing."""
    (tmp_path / "reports.py").write_text("MINE = True", "utf-8")
    (tmp_path / "scenes").mkdir()
    (tmp_path / "old.py").write_text(OLD_SCRIPT, "utf-8")
    # Without site: no .pth file leads to the checkout.
    places = (tmp_path, tree, sysconfig.get_path("purelib"))
    done = run_python(["-S", "old.py"], *places)
    assert done.returncode == 0, done.stderr
    (tmp_path / "scenes" / "own.py").write_text("", "utf-8")
    done = run_python(["-S", "-c", "import halfplane, scenes.own, scenes.loads"], *places)
    assert "No module named 'scenes.loads'" in done.stderr


# ---------------------------------------------------------------------------- a clean environment
STUDY = """
title = "Friction"
scene = "cattaneo-mindlin"
engines = ["exact"]
figures = ["exact.dissipation"]
[[axes]]
name = "f"
key = "friction.coefficient"
values = [0.6, 0.7]
"""
TYPED = """
import halfplane
scene: int = halfplane.load_scene("hertz-paper")
theory: str = halfplane.theory(scene).pressure
"""


@pytest.fixture(scope="module")
def users_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with modules that have the names of all five packages."""
    folder = tmp_path_factory.mktemp("user")
    for package in PACKAGES:
        (folder / f"{package}.py").write_text("raise SystemExit('a module of the user')", "utf-8")
    (folder / "study.toml").write_text(STUDY, "utf-8")
    (folder / "typed.py").write_text(TYPED, "utf-8")
    return folder


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Python of an environment with the wheel, and the present one's packages."""
    packages = import_module("packages")
    folder = tmp_path_factory.mktemp("environment")
    return str(packages.environment(folder / "home", folder, None))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "code"),
    [
        (["run", "cattaneo-mindlin", *COARSE], 1),  # too coarse for its limits
        (["sweep", "study.toml", "--workers", "2"], 0),
        (["sweep", "study.toml", "--workers", "2", "--executor", "dask"], 0),
    ],
    ids=["run", "processes", "dask"],
)
def test_the_wheel_runs_beside_modules_of_the_user(
    command: list[str], code: int, installed: str, users_folder: Path, tmp_path: Path
) -> None:
    if "dask" in command:
        pytest.importorskip("distributed")
    words = ["-m", "halfplane", *command, "--quiet", "--out", str(tmp_path / "out")]
    done = run_python(words, users_folder, python=installed)
    assert done.returncode == code, done.stdout + done.stderr
    if command[0] == "sweep":
        table = (tmp_path / "out" / "index.csv").read_text("utf-8")
        assert table.count("done") == 2


@pytest.mark.slow
def test_the_wheel_reads_files_of_version_0_3(
    installed: str, users_folder: Path, tmp_path: Path
) -> None:
    """A solution that the packages at the top wrote, as 0.3 had them."""
    solution = import_module("semi_analytic").solve("hertz-paper")
    solution.save(tmp_path / "theory.nc")
    words = (
        "import sys; from halfplane.scenes import ContactSolution\n"
        "print(ContactSolution.load(sys.argv[1]).dissipation)"
    )
    done = run_python(["-c", words, str(tmp_path / "theory.nc")], users_folder, python=installed)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) == solution.dissipation


@pytest.mark.slow
def test_type_hints_are_found(installed: str, users_folder: Path, tmp_path: Path) -> None:
    words = ["-m", "mypy", "--cache-dir", str(tmp_path), "typed.py"]
    done = run_python(words, users_folder, python=installed)
    faults = re.findall(r"typed.py:(\d+): error: (.*)", done.stdout)
    assert [int(line) for line, _ in faults] == [3, 4, 4], done.stdout
    first, *others = [words for _, words in faults]
    assert '"Scene", variable has type "int"' in first
    (of_argument,) = (words for words in others if words.startswith("Argument 1"))
    assert 'has incompatible type "int"; expected' in of_argument
    (of_pressure,) = (words for words in others if words != of_argument)
    assert 'has type "ndarray' in of_pressure


@pytest.mark.slow
def test_an_editable_installation_runs_beside_modules_of_the_user(
    users_folder: Path, tmp_path: Path
) -> None:
    """Its command does; a script in their folder is refused, as in a checkout."""
    home = tmp_path / "home"
    venv.create(home)
    python = home / "bin" / "python"
    (site,) = home.glob("lib/python*/site-packages")
    (site / "packages.pth").write_text(sysconfig.get_path("purelib"), "utf-8")
    pip = [sys.executable, "-m", "pip", "--python", str(python), "install", "--no-deps"]
    pip += ["--no-index", "--no-build-isolation", "--quiet", "-e", str(ROOT)]
    done = subprocess.run(pip, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}

    def ended(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            words, cwd=users_folder, env=environment, capture_output=True, text=True, check=False
        )

    done = ended(str(home / "bin" / "halfplane"), "check", "hertz-paper", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["exit_code"] == 0
    where = ended(str(python), "-P", "-c", "import halfplane; print(halfplane.scenes.__file__)")
    assert where.stdout.strip() == str(ROOT / "scenes" / "__init__.py"), where.stderr
    refused = ended(str(python), "-c", "import halfplane; halfplane.theory")
    assert "rename that module, or install halfplane with `pip install" in refused.stderr
