"""Our own finite elements as somebody else's result: the tables that come out of them score as the run itself does."""

from __future__ import annotations

import numpy as np
import pytest

import halfplane_fe
import reports
import semi_analytic
from meshes import MeshSettings
from problems import COARSE, FEW_STEPS, fe_run
from reports.field_output.files import write_fields
from reports.scoring.against import score_file
from reports.scoring.mapping import Mapping
from scenes import Bodies, load_scene


def digits(values):
    """As printed in seven digits."""
    return np.array([float(f"{value:.7g}") for value in np.ravel(values)]).reshape(np.shape(values))


def run(**sizes):
    scene = load_scene("hertz-paper")
    result = halfplane_fe.solve(scene, mesh=MeshSettings(**sizes))
    return result, reports.compare(semi_analytic.solve(scene, x=result.x, time=result.time), result)


# Measured against the run's own score: 1e-7 of the tractions (seven digits); of the edges, which the run knows better than its
# tractions tell, 3e-5 (contact), 4e-4 (stick, with slip) and 1.2e-2 (stick, without); 3e-4 of the dissipation, of which the rule's
# own share is taken off.
@pytest.mark.slow
@pytest.mark.parametrize(("with_slip", "stick"), [(True, 2e-3), (False, 0.015)])
def test_a_finite_element_result_in_seven_digits_scores_as_the_run_does(with_slip, stick):
    result, ours = run()
    slip = digits(result.slip) if with_slip else None
    found = reports.score(
        digits(result.x), digits(result.pressure), digits(result.shear), slip=slip, scene=result.scene, time=digits(result.time)
    )
    assert found.guesses == ()
    assert found.passed
    assert found.diagnoses == ()
    for key in ("peak_pressure", "pressure", "shear"):
        assert found.metric(key).value == pytest.approx(ours.metric(key).value, abs=1e-6), key
    assert found.metric("contact_edge").value == pytest.approx(ours.metric("contact_edge").value, abs=2e-4)
    assert found.metric("stick_edge").value == pytest.approx(ours.metric("stick_edge").value, abs=stick)
    if with_slip:
        assert found.metric("dissipation").value == pytest.approx(ours.metric("dissipation").value, abs=1e-3)


@pytest.mark.parametrize("bodies", ["half-planes", "blocks"])
def test_our_own_field_files_come_back_as_they_were_written(tmp_path, bodies):
    """Tractions to the last digit, so that theory scores the files as it scores the run, and the run scores them 0."""
    scene = load_scene("cattaneo-mindlin")
    if bodies == "blocks":
        block = {"kind": "block", "width": 20.0, "height": 12.0}
        scene = scene.vary(bodies=Bodies.model_validate({"lower": block, "upper": block}))
    run = fe_run(scene, COARSE, FEW_STEPS)
    steps = run.last_cycle[:: max(1, len(run.last_cycle) // 5)]
    write_fields(run, halfplane_fe.fields(run, run.time[steps]), tmp_path)
    found = score_file(tmp_path / "fields.pvd", Mapping(), scene)
    np.testing.assert_array_equal(found.comparison.result.time, run.time[steps])
    for name in ("pressure", "shear", "slip"):
        np.testing.assert_array_equal(getattr(found.comparison.result, name), getattr(run, name)[steps], err_msg=name)
    np.testing.assert_allclose(found.comparison.result.x, run.x, rtol=0, atol=1e-12)
    assert found.guesses == ()
    for part in ("lower", "upper"):
        assert any(f"{part}_000.vtu has no 'pressure', 'shear': left out" in note for note in found.comparison.notes)
    by_arrays = reports.score(run.x, run.pressure[steps], run.shear[steps], slip=run.slip[steps], scene=scene, time=run.time[steps])
    for key in ("peak_pressure", "pressure", "shear", "contact_edge", "stick_edge"):
        assert found.metric(key).value == pytest.approx(by_arrays.metric(key).value, rel=1e-9), key
        assert found.metric(key).value != 0, key


def test_the_finite_elements_can_be_the_reference(monkeypatch):
    result, _ = run(element_size=0.1, edge_element_size=0.05)
    monkeypatch.setattr(halfplane_fe, "solve", lambda scene: result)
    steps = result.last_cycle[::40]
    exact = semi_analytic.solve(result.scene, x=np.linspace(-1.3, 1.3, 105), time=result.time[steps])
    found = reports.score(exact.x, exact.pressure, exact.shear, scene=result.scene, time=exact.time, against="fe")
    assert found.comparison.reference.engine == "halfplane_fe"
    assert any("was interpolated" in note for note in found.comparison.notes)
    # A mesh of a/10 and linear interpolation between its nodes.
    assert 1e-4 < found.metric("pressure").value < 0.05
