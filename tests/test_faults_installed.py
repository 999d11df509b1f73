"""What a user gets by pip: licences told, requirements that fit together, a wheel that runs where there is no checkout."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


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
    assert len(pins) >= 17
    assert all(pin.count("==") == 1 for pin in pins)


def test_installed_packages_fit_together() -> None:
    done = subprocess.run([sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["--lowest", "--pinned"])
def test_the_wheel_runs_outside_the_checkout(kind: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(BENCHMARKS / "installed.py"), kind, str(tmp_path / "environment")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
