"""The comparison and the report on real answers of both engines, on a coarse mesh; and faults planted in these."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from meshes import MeshSettings
from reports import Report, compare, write
from reports.comparison import Comparison
from reports.page.writing import draw
from scenes import ContactSolution, InputError, load_scene
from test_reports_synthetic import with_fields

MESH = MeshSettings(element_size=1 / 10, edge_element_size=1 / 30)
ROUGH = MeshSettings(element_size=0.25, edge_element_size=0.1)
STEPS = halfplane_fe.SolverSettings(steps_per_cycle=60)


def both(name: str, mesh: MeshSettings) -> Comparison:
    scene = load_scene(name)
    result = halfplane_fe.solve(scene, mesh=mesh, settings=STEPS)
    reference = semi_analytic.solve(scene, x=result.x, time=result.time)
    polygon = semi_analytic.solve(scene, x=result.x, time=result.time, straight_steps=True)
    return compare(reference, result, polygon_reference=polygon)


@pytest.fixture(scope="module")
def paper() -> Comparison:
    return both("hertz-paper", MESH)


def test_edges_places_and_instants_are_known_to_what_is_stated_and_the_dissipations_fit(paper: Comparison) -> None:
    """Frozen values of ten comparisons stand in test_contract.py; limits of each metric in test_halfplane_fe_accuracy.py."""
    assert paper.admissible
    assert all(abs(paper.metric(key).value) < 1e-9 for key in ("resultant_normal", "resultant_tangential", "energy_balance"))
    # Edges are known to the uncertainty of the mesh, places to the spacing of points, instants to the step between them.
    edges = ("contact_edge_left", "stick_edge_left", "stick_edge_right", "shear_peak_place", "full_stick_start", "full_stick_end")
    for metric in map(paper.metric, edges):
        assert metric.value is not None
        assert metric.uncertainty is not None
        assert abs(metric.value) <= 1.000001 * metric.uncertainty, metric.key
    left, right = (paper.metric(f"contact_edge_{side}").value for side in ("left", "right"))
    assert abs(left - right) < 1e-9
    # The three dissipations: W_fe/W_polygon * W_polygon/W_smooth.
    total, other, step = (paper.metric(f"dissipation{part}").value for part in ("", "_polygon", "_step"))
    assert (1 + step) * (1 + other) == pytest.approx(1 + total, rel=1e-13)


def test_reference_on_its_own_grid_is_interpolated_and_says_so(paper: Comparison) -> None:
    own = compare(semi_analytic.solve(paper.scene), paper.result)
    assert any("was interpolated" in note for note in own.notes)
    assert own.metric("dissipation").value == pytest.approx(paper.metric("dissipation").value, abs=1e-9)
    stated = own.expected.interpolation["pressure"]
    difference = np.max(np.abs(own.expected.pressure - paper.expected.pressure)) / paper.expected.pressure.max()
    assert 0 < difference <= stated


def test_a_contact_that_dissipates_nothing_or_is_only_pressed_has_fewer_figures(tmp_path: Path) -> None:
    """No loop, no work, no cycle; and instants too light to be judged, which is said."""
    found = both("full-stick", ROUGH)
    metric = found.metric("dissipation")
    assert metric.absolute
    assert abs(metric.value or 0.0) < 1e-12
    assert not found.metric("stick_edge").note
    drawn = {drawing.name for drawing in draw(Report(found))}
    assert {"tractions", "hysteresis"} <= drawn
    assert "dissipation_density" not in drawn
    pressed = both("hertz-normal", ROUGH)
    page = write(pressed, tmp_path / "out").read_text(encoding="utf-8")
    assert not {"hysteresis", "dissipation_density"} & {drawing.name for drawing in draw(Report(pressed))}
    assert "Nothing slips under load" in page
    assert "less than 0.1 P<sub>ref</sub>" in page


def test_report_of_both_engines_its_fields_when_asked_and_its_stored_solutions(paper: Comparison, tmp_path: Path) -> None:
    out = tmp_path / "out"
    page = write(paper, out, command="halfplane run hertz-paper")
    assert {"mesh.csv", "energy.csv", "certificates_result.csv"} <= {path.name for path in (out / "figures").iterdir()}
    assert not (out / "fields").exists()
    assert page.stat().st_size < 8e6
    assert f"All metrics ({len(paper.metrics)})" in page.read_text(encoding="utf-8")
    stored = json.loads((out / "comparison.json").read_text(encoding="utf-8"))
    assert stored["result"]["skipped"]["condensations"]["count"] == 1
    assert stored["result"]["versions"]["numpy"] == np.__version__
    reference, result = (ContactSolution.load(out / f"{name}.nc") for name in ("reference", "result"))
    again = compare(reference, result, polygon_reference=paper.polygon_reference)
    # The file holds no nodal weights, so the resultants of what was stored go by another rule, which they say.
    by_weights = {"resultant_normal", "resultant_tangential"}
    for one, fresh in zip(again.metrics, paper.metrics, strict=True):
        assert one.value == fresh.value or fresh.key in by_weights, fresh.key
    assert all("states no weights" in again.metric(key).note for key in by_weights)
    write(paper, out, vtu_instants=paper.found.time[[0, 5]])
    names = {path.name for path in (out / "fields").iterdir()}
    assert names == {"fields.pvd", *(f"{part}_{number:03d}.vtu" for part in ("lower", "upper", "contact") for number in (0, 1))}
    with pytest.raises(InputError, match="semi_analytic has no bodies"):
        write(compare(paper.reference, paper.reference), tmp_path / "none", vtu_instants=[paper.found.time[0]])
    assert not (tmp_path / "none").exists()


# ---------------------------------------------------------------------------------------------------------- planted faults
def faulty(paper: Comparison, **changed: object) -> ContactSolution:
    """The half-plane answer to a scene that differs in `changed`, passed off as the answer to the paper's."""
    answer = semi_analytic.solve(paper.scene.vary(**changed), x=paper.result.x, time=paper.result.time)
    return with_fields(answer, scene=paper.scene)


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_friction_one_per_cent_off(paper: Comparison, factor: float) -> None:
    """Caught by the shear, and without any reference: what slips does not carry f p.

    The dissipation of this cycle is no witness: as a function of f it is nearly at its largest at f = 1.
    """
    result = faulty(paper, friction=factor * paper.scene.friction.coefficient)
    found = compare(paper.reference, result)
    expected = result.dissipation / paper.reference.dissipation - 1
    assert found.metric("dissipation").value == pytest.approx(expected, rel=1e-9)
    assert abs(expected) < 2e-4
    assert found.metric("shear").accurate is False
    broken = {check.label: check.value for check in found.result_certificates if not check.holds}
    assert set(broken) == ({"slip (fields)"} if factor < 1 else {"slip (fields)", "cone (fields)"})
    assert 0.002 < broken["slip (fields)"] < 0.01
    assert found.metric("peak_pressure").value == 0.0


def test_poisson_ratio_of_one_body(paper: Comparison) -> None:
    """A softer body makes a wider contact: pressure and edges see it, and nothing is inadmissible."""
    found = compare(paper.reference, faulty(paper, material={"upper": {"poisson_ratio": 0.25}}))
    assert {"peak_pressure", "pressure", "dissipation"} <= {metric.key for metric in found.metrics if metric.accurate is False}
    assert found.admissible
    assert found.metric("peak_pressure").value < 0 < found.metric("contact_edge").value


def test_shear_backwards_pressure_in_its_place_and_without_history(paper: Comparison) -> None:
    """The last: each instant as if loaded to it directly, the tractions of the initial loading without the memory of the cycle."""
    true = paper.reference
    share = np.sqrt(np.maximum(1 - np.abs(true.tangential_load) / np.maximum(true.normal_load, 1e-300), 0))
    inner = true.pressure**2 - (true.pressure.max(axis=1) * (1 - share**2) ** 0.5)[:, None] ** 2
    forgetful = np.sign(true.tangential_load)[:, None] * (true.pressure - np.sqrt(np.maximum(inner, 0)))
    for shear in (-true.shear, true.pressure.copy(), forgetful):
        found = compare(true, with_fields(true, shear=shear))
        assert [metric.key for metric in found.metrics if metric.accurate is False] == ["shear"]
