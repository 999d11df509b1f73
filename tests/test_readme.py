"""The README's blocks are run, and what it names exists."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import scenes

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)


def blocks(language: str) -> list[str]:
    return [text for kind, text in BLOCKS if kind == language]


def halfplane(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "reports", *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=120, check=False)


def test_every_make_target_that_a_block_calls_is_in_the_makefile() -> None:
    called = {word for text in blocks("sh") for word in re.findall(r"^make (\w+)", text, flags=re.MULTILINE)}
    targets = set(re.findall(r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    assert {"run", "test"} <= called <= targets


def test_ci_installs_the_packages_of_the_readme_and_calls_make_test() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "README.md" in script
    assert re.search(r"^(exec )?make test$", script, flags=re.MULTILINE)


@pytest.mark.parametrize("text", blocks("toml"))
def test_the_scene_of_the_readme_runs_through_both_engines(text: str, tmp_path: Path) -> None:
    (tmp_path / "roller.toml").write_text(text, encoding="utf-8")
    checked = halfplane("check", "roller.toml", cwd=tmp_path)
    assert checked.returncode == 0, checked.stderr
    run = halfplane("run", "roller.toml", cwd=tmp_path)
    assert run.returncode == 0, run.stdout + run.stderr
    assert (tmp_path / "out" / "roller" / "report.html").is_file()


@pytest.mark.parametrize("text", blocks("python"))
def test_python_blocks_run(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "README.md", "exec"), {})


def test_the_command_table_and_the_help_agree(tmp_path: Path) -> None:
    named = set(re.findall(r"^\| `halfplane (\w+)", README, flags=re.MULTILINE))
    shown = halfplane("--help", cwd=tmp_path).stdout
    assert named
    missing = {name for name in named if not re.search(rf"\b{name}\b", shown)}
    assert not missing


def test_files_that_the_readme_links_to_exist() -> None:
    links = [target for target in re.findall(r"\]\(([^)#]+)\)", README) if "://" not in target]
    assert links
    assert all((ROOT / target).exists() for target in links)


def test_nothing_in_the_project_reads_the_folder_beside_it() -> None:
    """Code, tests, benchmarks, pages and settings; the name stands here in two parts, so that this file is judged too."""
    outside = "../" + "shared"
    suffixes = {".py", ".md", ".toml", ".ipynb", ".yml", ".yaml", ".sh", ".jinja", ".html", ".js", ".css"}
    folders = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports", "tests", "benchmarks", ".ci")
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file()]
    sources += [path for path in (ROOT / "docs").rglob("*") if "_build" not in path.parts and path.is_file()]
    sources += [path for path in ROOT.iterdir() if path.is_file()]
    read = [path for path in sources if path.suffix in suffixes or path.name in ("Makefile", "run")]
    assert len(read) > 500
    assert not [path for path in read if outside in path.read_text(encoding="utf-8")]
    assert scenes.scene_names()
