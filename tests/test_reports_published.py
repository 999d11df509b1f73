"""reports/published/: its numbers are what the code gives, its pages are what its numbers give; a wheel has the maps' tables."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hatchling.builders.wheel import WheelBuilder

from reports import publishing
from reports.cli.findings import SAME, Findings, difference
from reports.maps.laws import PUBLISHED
from reports.page.figures import published
from reports.publishing import (
    External,
    error_of,
    externals,
    findings,
    frozen,
    half_plane_findings,
    index,
    page,
    published_by_others,
    stored_content,
)
from scenes import load_scene, scene_names

ROOT = Path(__file__).parents[1]
STORED: dict[str, Any] = json.loads((publishing.FOLDER / "values.json").read_text(encoding="utf-8"))["scenes"]
RENEW = "run `make publish`, look at what moved, and say why in CHANGELOG.md"
# Half-planes without slip and with a little; make nightly has all scenes, and test_contract.py freezes twelve coarser ones.
CHEAP = ("full-stick", "tiny-slip")
EVERY = pytest.mark.parametrize("name", scene_names())


def changed(then: Findings, now: Findings) -> list[str]:
    return [f"{row.key}: {row.a} -> {row.b}, {row.verdict}" for row in difference(then, now).rows if row.verdict != SAME]


def test_the_whole_library_is_published_and_nothing_else() -> None:
    assert list(STORED) == list(scene_names())
    files = {"values.json", "README.md", "maps", *(f"{name}.{kind}" for name in scene_names() for kind in ("md", "svg"))}
    assert {path.name for path in publishing.FOLDER.iterdir()} == files, RENEW
    assert (publishing.FOLDER / "README.md").read_text(encoding="utf-8") == index(STORED), RENEW


@EVERY
def test_half_plane_figures_are_what_the_code_gives(name: str) -> None:
    kept = frozen(name, STORED[name])
    theory = {key: value for key, value in kept.figures.items() if key.startswith("semi_analytic.")}
    assert changed(replace(kept, figures=theory), half_plane_findings(name)) == [], RENEW


def test_a_stale_figure_is_found() -> None:
    """2e-10 in one value of half-plane theory, 2e-6 in one of the finite elements."""
    then = frozen("hertz-paper", STORED["hertz-paper"])
    for key, shift in (("semi_analytic.dissipation", 2e-10), ("halfplane_fe.dissipation", 2e-6)):
        value = then.figures[key]
        assert value
        stale = replace(then, figures={**then.figures, key: value * (1 + shift)})
        assert [line.split(":")[0] for line in changed(stale, then)] == [key]


@pytest.mark.parametrize("name", [name if name in CHEAP else pytest.param(name, marks=pytest.mark.slow) for name in scene_names()])
def test_figures_of_both_engines_are_what_the_code_gives(name: str) -> None:
    """Pictures are drawn alike twice, without fonts and dates."""
    comparison = publishing.compute(name)
    assert changed(frozen(name, STORED[name]), findings(comparison)) == [], RENEW
    now = stored_content(comparison)
    for key in ("admissible", "absolute", "accurate", "external"):
        assert json.loads(json.dumps(now[key])) == STORED[name][key], f"{key}: {RENEW}"
    assert published(comparison) == published(comparison)


@EVERY
def test_pages_say_what_the_numbers_say_and_these_agree_with_closed_forms_and_published_values(name: str) -> None:
    """The external column, within its own tolerances: it is not renewed by what we compute."""
    assert (publishing.FOLDER / f"{name}.md").read_text(encoding="utf-8") == page(name, STORED[name]), RENEW
    scene, stored = load_scene(name), STORED[name]
    load = stored["largest_normal_load"]
    known = [External(**entry) for entry in stored["external"]]
    assert known == list(externals(scene, load))
    assert "semi_analytic.dissipation" in {external.key for external in known}
    for external in known:
        assert abs(error_of(external, stored["frozen"], scene, load)) <= external.tolerance, external
    text = (publishing.FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    assert len(text) < 60_000
    assert ET.fromstring(text).tag.endswith("svg")
    assert not [word for word in ("@font-face", "dc:date", "data:") if word in text]


@pytest.mark.parametrize("name", ["cylinder-roller", "cylinder-roller-frictionless"])
def test_the_published_roller_is_met_once_displacements_are_large(name: str) -> None:
    """Ours miss the quadratic elements' values by 2 to 3 %; with CalculiX' change to large displacements by less than 1 %."""
    cases = json.loads(publishing.ROLLER.read_text(encoding="utf-8"))
    small, large = (cases[f"{name}: {change}"] for change in ("as exported", "large displacements"))
    for quantity, key in (("lower_face_displacement", "displacement"), ("largest_pressure", "stress")):
        (theirs,) = [one for one in published_by_others(load_scene(name)) if one.quantity == quantity and "quadratic" in one.source]
        ours = STORED[name]["frozen"][f"halfplane_fe.{quantity}"]
        assert abs(ours / theirs.value - 1) > 0.015
        assert abs(ours / theirs.value * large[key] / small[key] - 1) < 0.01
        assert theirs.source in page(name, STORED[name])


def test_of_the_published_reports_the_wheel_has_the_tables_of_the_maps_alone() -> None:
    packed = {file.distribution_path for file in WheelBuilder(str(ROOT)).recurse_included_files()}
    assert "reports/templates/report.html" in packed
    published = {Path(path) for path in packed if "published" in path}
    assert published == {path.relative_to(ROOT) for path in (*PUBLISHED.glob("*.csv"), PUBLISHED / "laws.json")}
    assert {f"{package}/py.typed" for package in ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")} <= packed
