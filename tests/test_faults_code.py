"""What is read back can't run code, and what is written for a while is private: the source tree searched for what could."""

from __future__ import annotations

import ast
import os
import stat
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from fuzzing import _body
from halfplane_fe.elasticity import condense
from halfplane_fe.store import _write
from reports.folder import filled
from reports.staging import replace_text
from reports.sweep.store import Store

ROOT = Path(__file__).parents[1]
PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")
# Modules that make objects, and so run code, out of bytes.
MODULES = {"pickle", "_pickle", "cPickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "yaml", "jsonpickle"}
CALLS = {"eval", "exec", "compile", "__import__", "os.system"}
METHODS = {"read_pickle", "to_pickle", "mktemp", "popen"}


def dangers(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)]
        yield from (f"import {name}" for name in names if set(name.split(".")) & MODULES)
        if isinstance(node, ast.Call):
            yield from _call(node)


def _call(node: ast.Call) -> Iterator[str]:
    word = ast.unparse(node.func)
    given = {word.arg: ast.unparse(word.value) for word in node.keywords}
    if word in CALLS:
        yield word
    if isinstance(node.func, ast.Attribute) and node.func.attr in METHODS:
        yield word
    if word in {"np.load", "numpy.load"} and given.get("allow_pickle") != "False":
        yield f"{word} without allow_pickle=False"
    if given.get("allow_pickle") == "True" or given.get("shell") == "True":
        yield f"{word} with {given}"


@pytest.mark.parametrize("package", PACKAGES)
def test_no_source_file_can_run_what_it_reads(package: str) -> None:
    files = sorted((ROOT / package).rglob("*.py"))
    assert len(files) > 10
    found = {f"{path}: {danger}" for path in files for danger in dangers(ast.parse(path.read_text(encoding="utf-8")))}
    assert found == set()


@pytest.mark.parametrize(
    "line",
    [
        "import pickle",
        "from pickle import loads",
        "import joblib.memory",
        "from yaml import safe_load",
        "eval(text)",
        "exec(text)",
        "np.load(path)",
        "np.load(path, allow_pickle=True)",
        "pd.read_pickle(path)",
        "subprocess.run(text, shell=True)",
        "tempfile.mktemp()",
        "os.system(text)",
    ],
)
def test_the_search_finds_each(line: str) -> None:
    assert list(dangers(ast.parse(line)))


def test_the_search_passes_what_is_harmless() -> None:
    assert not list(dangers(ast.parse("np.load(f, allow_pickle=False); ast.parse(t, mode='eval'); json.loads(t); re.compile(t)")))


@pytest.fixture
def generous() -> Iterator[None]:
    """An umask that gives every right to everybody."""
    before = os.umask(0)
    yield
    os.umask(before)


def rights(path: str | Path) -> int:
    return stat.S_IMODE(os.stat(path).st_mode)


@pytest.mark.usefixtures("generous")
def test_a_folder_that_is_being_filled_is_private_and_the_filled_one_is_not(tmp_path: Path) -> None:
    with filled(tmp_path / "out") as staging:
        (staging / "figures").mkdir()
        (staging / "figures" / "a.csv").write_text("x")
        assert rights(staging) == 0o700
    assert (rights(tmp_path / "out"), rights(tmp_path / "out" / "figures" / "a.csv")) == (0o777, 0o666)


@pytest.mark.usefixtures("generous")
@pytest.mark.parametrize("writer", ["store of a sweep", "baseline", "store of bodies"])
def test_a_file_that_is_being_written_is_private(writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Seen at the moment at which it gets its rights and its name."""
    seen = []
    real = {name: getattr(os, name) for name in ("replace", "chmod")}

    def watched(name: str) -> object:
        def call(first: str, *rest: object) -> None:
            seen.append(rights(first))
            real[name](first, *rest)

        return call

    for name in real:
        monkeypatch.setattr(os, name, watched(name))
    if writer == "store of a sweep":
        Store(tmp_path).write_text(tmp_path / "a.json", "{}")
    elif writer == "baseline":
        replace_text(tmp_path / "a.json", "{}")
    else:
        _write(tmp_path / "a.npz", condense(*_body(), 4.0), Counter())
    assert seen[0] == 0o600
    assert len(list(tmp_path.iterdir())) == 1
