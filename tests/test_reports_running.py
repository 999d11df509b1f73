"""`halfplane run` with its default options on every kind of body: it ends with a verdict, a page
and whole files.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import halfplane_fe
from command_line import halfplane, raising
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.page import writing
from reports.units import PythonNumbers
from scenes import ContactSolution, load_scene, scene_names

# As coarse as leaves room for the two coarser meshes of an uncertainty.
CHEAP = (
    "--order",
    "1",
    "--element-size",
    "0.14",
    "--edge-element-size",
    "0.14",
    "--steps-per-cycle",
    "8",
)
PATH = {"kind": "polygon", "initial_loading": [[60.0, 0.0], [60.0, 24.0]]}
STEEL = {"young_modulus": 210e3, "poisson_ratio": 0.3}
BLOCK = {"kind": "block", "width": 20.0, "height": 8.0}
PAD = {"kind": "pad", "width": 8.0, "height": 6.0}
HERTZ = {"kind": "hertz", "radius": 1000.0}
FLAT = {"kind": "flat_rounded", "radius": 200.0, "flat_half_length": 1.0}
# Name -> lower body, upper body, profile, material of the upper body.
KINDS: Mapping[str, tuple[dict[str, Any], dict[str, Any], dict[str, Any], dict[str, float]]] = {
    "half-planes": ({"kind": "half_plane"}, {"kind": "half_plane"}, HERTZ, STEEL),
    "blocks": (BLOCK, BLOCK, HERTZ, STEEL),
    "thin layer": ({**BLOCK, "height": 1.0}, BLOCK, HERTZ, STEEL),
    "cylinder on a block": (
        BLOCK,
        {"kind": "cylinder", "radius": 40.0},
        {"kind": "hertz", "radius": 40.0},
        STEEL,
    ),
    "flat pad on a block": (BLOCK, PAD, FLAT, STEEL),
    "unlike flat pad on a block": (
        BLOCK,
        PAD,
        FLAT,
        {"young_modulus": 70e3, "poisson_ratio": 0.33},
    ),
}


def scene_file(
    folder: Path,
    lower: dict[str, Any],
    upper: dict[str, Any],
    profile: dict[str, Any],
    material: dict[str, float],
) -> str:
    """A scene of these bodies under P and then Q."""
    content = {
        "profile": profile,
        "material": {"lower": STEEL, "upper": material},
        "bodies": {"lower": lower, "upper": upper},
        "friction": {"coefficient": 0.6},
        "load": PATH,
    }
    path = folder / "scene.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path.name


def require_split(content: Mapping[str, Any]) -> None:
    """The steps from theory to finite elements end at E, or a reason why there are none."""
    why = content["why"]
    if why["not_split"]:
        assert not why["steps"]
        return
    error = content["metrics"]["dissipation"]["value"]
    assert sum(step["value"] for step in why["steps"]) == pytest.approx(error, rel=1e-9)
    assert why["steps"][-2]["cause"] == "what is left"


# A layer and a flat pad of one material are like them; a roller is run by test_docs_pages.py.
SLOW = ("blocks", "cylinder on a block", "unlike flat pad on a block")


@pytest.mark.parametrize(
    "kind",
    [pytest.param(kind, marks=pytest.mark.slow) if kind in SLOW else kind for kind in KINDS],
)
def test_a_run_of_each_kind_of_body_ends_with_a_page_and_an_uncertainty(
    kind: str, tmp_path: Path
) -> None:
    is_verbose = kind == "flat pad on a block"
    options = [*CHEAP, "--out", "out", "--quiet", *["--verbose"] * is_verbose]
    outcome = halfplane(tmp_path, "run", scene_file(tmp_path, *KINDS[kind]), *options)
    assert outcome.returncode in (0, 1), outcome.stderr
    assert ("Where the difference comes from" in outcome.stdout) == is_verbose
    assert len(outcome.stdout.splitlines()) <= 25 or is_verbose
    content = json.loads((tmp_path / "out/comparison.json").read_text("utf-8"))
    # theory is exact for them, and no uncertainty is measured unless it is asked for
    if kind == "half-planes":
        assert content["budget"] is None
        assert content["why"] is None
    else:
        assert content["budget"]["metrics"]["dissipation"]["u"] > 0
        require_split(content)
    assert (tmp_path / "out/report.html").read_text("utf-8").rstrip().endswith("</html>")


@pytest.mark.slow
@pytest.mark.parametrize("name", scene_names())
def test_every_scene_of_the_library_runs_with_default_options(name: str, tmp_path: Path) -> None:
    outcome = halfplane(tmp_path, "run", name, "--preset", "coarse", "--out", "out", "--quiet")
    assert outcome.returncode in (0, 1), outcome.stderr
    assert (tmp_path / "out/report.html").read_text("utf-8").rstrip().endswith("</html>")
    json.loads((tmp_path / "out/comparison.json").read_text("utf-8"))


# ------------------------------------------------------------------ numbers that leave for the page
@pytest.mark.parametrize("module", ["measures", "metrics", "pairs", "laws", "budget"])
def test_records_that_leave_for_the_page_hold_numbers_of_python(module: str) -> None:
    """numpy's True is no index of a tuple, and a value is a share of something whatever library
    computed it.
    """
    comparison = importlib.import_module(f"reports.comparison.{module}")
    classes = [value for value in vars(comparison).values() if isinstance(value, type)]
    records = [
        kind
        for kind in classes
        if issubclass(kind, PythonNumbers)
        and dataclasses.is_dataclass(kind)
        and kind.__module__ == comparison.__name__
    ]
    assert records
    # A value of its kind for what is checked when the record is made, and numpy's everywhere else.
    pair = (np.float64(1.0), np.float64(2.0))
    known = {"sizes": pair, "values": pair, "needs": (), "measure": None, "exists": None}
    for record in records:
        names = [field.name for field in dataclasses.fields(record) if field.init]
        filled = record(**{name: known.get(name, np.float64(0.5)) for name in names})
        for name, value in vars(filled).items():
            parts = value if isinstance(value, tuple) else (value,)
            types = {type(part) for part in parts}
            assert types <= {float, bool, int, str, type(None)}, (record.__name__, name, value)


# -------------------------------------------------------------------------------- a page that fails
@pytest.fixture(scope="module")
def solved() -> ContactSolution:
    """The answer of finite elements, once for all pages that fail."""
    mesh = MeshSettings(element_size=0.25, edge_element_size=0.25, order=1)
    return halfplane_fe.solve("cattaneo-mindlin", mesh, SolverSettings(steps_per_cycle=8))


@pytest.mark.parametrize(
    ("part", "fault", "code"),
    [
        ("render", TypeError("tuple indices must be integers"), 70),
        ("as_json", MemoryError(), 2),
        ("draw", FileNotFoundError(2, "not there", "/fonts"), 2),
        ("compare", ZeroDivisionError("float division by zero"), 70),
    ],
)
def test_what_fails_after_the_solutions_leaves_them_and_says_where(
    part: str,
    fault: Exception,
    code: int,
    solved: ContactSolution,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A page that fails leaves both; a comparison that fails leaves that of finite elements."""
    (tmp_path / "out").mkdir()
    monkeypatch.setattr("halfplane_fe.solve", lambda *_, **__: solved)
    home = "reports.comparison" if part == "compare" else "reports.page.writing"
    monkeypatch.setattr(f"{home}.{part}", raising(fault))
    outcome = halfplane(tmp_path, "run", "cattaneo-mindlin", "--out", "out", "--quiet")
    assert outcome.returncode == code, outcome.stderr
    names = ("halfplane_fe.nc",) if part == "compare" else writing.SOLUTIONS
    for name in names:
        assert ContactSolution.load(tmp_path / "out" / name).scene == load_scene("cattaneo-mindlin")
        assert f"out/{name}" in outcome.stderr
    if part != "compare":
        written = {path.name for path in (tmp_path / "out").iterdir()}
        assert written - {"run.log"} == {"manifest.json", *writing.SOLUTIONS}
