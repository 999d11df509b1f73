"""What a user gets by pip: licences told, requirements that fit together, a wheel that runs where there is no checkout."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from importlib import import_module
from importlib.metadata import distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BENCHMARKS = ROOT / "benchmarks"


@pytest.fixture(autouse=True)
def benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def test_the_table_of_licences_is_that_of_what_is_installed() -> None:
    import licences

    assert licences.PAGE.read_text(encoding="utf-8") == licences.page()
    assert {"numpy", "gmsh", "markupsafe"} <= licences.closure().keys()
    assert "not stated" not in licences.page()


def test_every_requirement_has_a_lower_bound() -> None:
    import installed

    pins = installed.lowest()
    assert len(pins) >= 16
    assert all(pin.count("==") == 1 for pin in pins)


def test_installed_packages_fit_together() -> None:
    done = subprocess.run([sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_project_names_its_pythons_the_same_everywhere() -> None:
    import pins

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    oldest, *_, newest = pins.pythons()
    assert project["project"]["requires-python"] == f">={oldest}"
    assert project["tool"]["mypy"]["python_version"] == oldest
    assert "target-version" not in project["tool"]["ruff"]  # ruff takes requires-python
    assert f"Any Python from {oldest} to {newest}" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_all_that_is_installed_is_pinned() -> None:
    """On the newest Python too, where a requirement may hold that the oldest does not have."""
    import pins
    from licences import plain

    pinned = {plain(word): word.partition("==")[2] for word in pins.pinned()}
    ours = {plain(found.name): found.version for found in distributions() if found.name not in {"halfplane", "pip", "setuptools"}}
    assert {name: pinned.get(name) for name in ours} == ours


def test_every_command_runs_from_an_installed_wheel(tmp_path: Path) -> None:
    import installed

    assert installed.every_command(tmp_path / "environment", tmp_path / "there") == []


@pytest.mark.parametrize("package", ["scenes", "semi_analytic", "meshes", "halfplane_fe", "reports"])
def test_dir_shows_the_interface_and_nothing_else(package: str) -> None:
    module = import_module(package)
    assert dir(module) == sorted(module.__all__)


@pytest.mark.slow
# The lower bounds are older than Python 3.14, so without wheels for it.
@pytest.mark.parametrize("kind", ["--pinned", *(["--lowest"] if sys.version_info < (3, 14) else [])])
def test_the_wheel_runs_outside_the_checkout(kind: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(BENCHMARKS / "installed.py"), kind, str(tmp_path / "environment")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
