"""What is said of a dissipation that is in doubt: revolutions that do not repeat, meshes that are not fine enough. In the record,
on the terminal, in JSON and on the page."""

import functools
import html
import json
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from halfplane_fe.resolution import coarse
from meshes import MeshSettings
from reports.cli import main
from reports.cli.solving import summary_rows
from scenes import ContactSolution, ConvergenceError, Interrupted, Scene, load_scene

COARSE = MeshSettings(element_size=0.25, edge_element_size=0.125, growth=1.0)
FEW = SolverSettings(steps_per_cycle=8)
OPTIONS = ("--element-size", "0.25", "--edge-element-size", "0.125", "--growth", "1", "--steps-per-cycle", "8", "--quiet")
BLOCK = {"kind": "block", "width": 18.0, "height": 18.0, "base": "rollers", "sides": "guided"}
# Rounded from one of 7 found among 40 random pairs with a block on rollers under tilted ellipses.
ON_ROLLERS: dict[str, Any] = {
    "name": "blocks-on-rollers",
    "material": {"lower": {"young_modulus": 210e3, "poisson_ratio": 0.3}, "upper": {"young_modulus": 31e3, "poisson_ratio": 0.18}},
    "profile": {"kind": "flat_rounded", "radius": 500.0, "flat_half_length": 0.37},
    "friction": {"coefficient": 0.1},
    "bodies": {"lower": BLOCK, "upper": BLOCK},
    "load": {
        "kind": "ellipse",
        "mean_normal_load": 860.0,
        "normal_amplitude": 700.0,
        "mean_tangential_load": 2.7,
        "tangential_amplitude": 13.0,
        "phase_degrees": -35.0,
    },
}


def ellipse(mean: float, swing: float, friction: float, offset: float, amplitude: float, phase: float) -> dict[str, Any]:
    """P1 over P0, Q0 and Q1 over f P0, phase in radians."""
    return {
        "friction": {"coefficient": friction},
        "load": {
            "kind": "ellipse",
            "mean_normal_load": mean,
            "normal_amplitude": swing * mean,
            "mean_tangential_load": offset * friction * mean,
            "tangential_amplitude": amplitude * friction * mean,
            "phase_degrees": float(np.degrees(phase)),
        },
    }


STEEL = load_scene("hertz-paper").model_dump(mode="json")["material"]
FLAT = {"kind": "flat_rounded", "radius": 1000.0, "flat_half_length": 2.81}
# An audit found both beyond the tolerance of 1.5e-3 on the default mesh, without a word: +1.9e-3 and -9.8e-3.
BEYOND = {
    "parabola": {"profile": {"kind": "hertz", "radius": 1000.0}, **ellipse(90.0, 0.85, 0.056, 0.51, 0.56, 0.37)},
    "flat": {"profile": FLAT, **ellipse(90.0, 0.71, 0.97, -0.55, 0.44, 2.63)},
}


def beyond(name: str) -> Scene:
    return Scene.model_validate({"name": name, "material": STEEL, **BEYOND[name]})


@functools.cache
def unsettled() -> FiniteElementSolution:
    return halfplane_fe.solve(Scene.model_validate({**ON_ROLLERS, "cycles": 2}), COARSE, FEW)


def drift_note(solution: ContactSolution) -> str:
    (note,) = (note for note in solution.record.notes if note.startswith("no revolution repeats"))
    return note


# ------------------------------------------------------------------------------------------------- no revolution repeats
def test_revolutions_that_do_not_repeat_are_noted_with_how_the_dissipation_drifts() -> None:
    solution = unsettled()
    before, last = solution.cycle_dissipation
    assert solution.steady_from is None
    assert solution.dissipation_drift == pytest.approx(1 - before / last)
    assert "the last of 2 ends" in drift_note(solution)
    assert f"differs by {1 - before / last:+.1e} of itself" in drift_note(solution)


@pytest.mark.slow
def test_the_scene_does_not_repeat_within_six_revolutions_on_the_coarse_mesh() -> None:
    solution = halfplane_fe.solve(Scene.model_validate(ON_ROLLERS), MeshSettings.coarse())
    assert solution.steady_from is None
    assert "the last of 6" in drift_note(solution)
    assert solution.dissipation_drift == pytest.approx(-3.4e-4, rel=0.2)  # as measured: small, and not rounding


def test_revolutions_that_repeat_are_not_noted() -> None:
    solution = halfplane_fe.solve(load_scene("cattaneo-mindlin"), COARSE, FEW)
    assert solution.steady_from is not None
    assert not any("repeats" in note for note in solution.record.notes)
    assert solution.dissipation_drift == 0


def test_one_revolution_alone_has_no_drift() -> None:
    one = Scene.model_validate({**load_scene("cattaneo-mindlin").model_dump(mode="json"), "cycles": 1})
    solution = halfplane_fe.solve(one, COARSE, FEW)
    assert np.isnan(solution.dissipation_drift)
    assert "its dissipation differs" not in drift_note(solution)


@pytest.fixture
def scene_file(tmp_path: Path) -> str:
    path = tmp_path / "blocks-on-rollers.json"
    path.write_text(json.dumps({**ON_ROLLERS, "cycles": 2}), encoding="utf-8")
    return str(path)


def test_fe_says_so_in_words_and_in_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("halfplane_fe.solve", lambda *_, **__: unsettled())
    main(["fe", "hertz-paper", "--json", "--quiet", "--out", str(tmp_path / "out")])
    found = json.loads(capsys.readouterr().out)["result"]
    assert drift_note(unsettled()) in found["notes"]
    assert found["dissipation_drift"] == unsettled().dissipation_drift
    assert found["dissipation_uncertainty"] is None
    words = summary_rows(unsettled())
    assert ("note", drift_note(unsettled())) in words
    assert ("dissipation, change from the cycle before", f"{unsettled().dissipation_drift:+.2e} of it") in words


def test_run_says_so_on_the_terminal_in_json_and_on_the_page(
    scene_file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    main(["run", scene_file, "--no-budget", "--out", str(out), *OPTIONS])
    words = " ".join(capsys.readouterr().out.split())
    note = drift_note(unsettled())
    assert f"Note: {note}." in words
    content = json.loads((out / "comparison.json").read_text(encoding="utf-8"))
    assert note in content["result"]["notes"]
    assert content["result"]["dissipation_drift"] == pytest.approx(unsettled().dissipation_drift, rel=1e-6)
    shown = html.unescape((out / "report.html").read_text(encoding="utf-8"))
    assert f"finite elements: {note}" in shown
    # And the coarse mesh, which `run` solves too.
    apart = content["result"]["dissipation_uncertainty"]
    assert apart > 0
    assert f"± at least {apart:.2g}" in words
    assert f"± at least {apart:.2g}" in shown


# --------------------------------------------------------------------------------------------- the difference from a coarse mesh
@functools.cache
def doubted(name: str, mesh: MeshSettings) -> tuple[FiniteElementSolution, float]:
    """The answer with its coarse mesh, and its error over the true dissipation."""
    solution = halfplane_fe.solve(beyond(name), mesh, SolverSettings(steps_per_cycle=48), coarse_mesh=True)
    return solution, solution.dissipation / semi_analytic.solve(beyond(name)).dissipation - 1


@pytest.mark.parametrize(
    ("name", "mesh"),
    [
        ("parabola", MeshSettings(element_size=1 / 12, edge_element_size=1 / 48, growth=0.5)),
        pytest.param("parabola", MeshSettings(), marks=pytest.mark.slow),
        pytest.param("flat", MeshSettings(), marks=pytest.mark.slow),
    ],
)
def test_a_dissipation_beyond_its_tolerance_is_noted(name: str, mesh: MeshSettings) -> None:
    solution, error = doubted(name, mesh)
    assert abs(error) > 1.5e-3
    assert solution.dissipation_uncertainty >= abs(error) * solution.dissipation
    (note,) = (note for note in solution.record.notes if "at least" in note)
    assert f"uncertain by {solution.dissipation_uncertainty:.3g} at least" in note


def test_what_stands_beside_it_is_the_difference_from_the_coarse_mesh(tmp_path: Path) -> None:
    solution = halfplane_fe.solve(load_scene("hertz-paper"), replace(COARSE, edge_element_size=0.05), FEW, coarse_mesh=True)
    other, settings = coarse(replace(COARSE, edge_element_size=0.05), FEW) or (COARSE, FEW)
    assert other == replace(COARSE, edge_element_size=0.25, far_radius=6.0)
    alone = halfplane_fe.solve(load_scene("hertz-paper"), other, settings)
    assert solution.dissipation_uncertainty == pytest.approx(abs(alone.dissipation - solution.dissipation), rel=1e-9)
    assert solution.work.counts["coarse mesh, steps solved"] == alone.work.counts["steps solved"]
    assert "coarse mesh" in solution.work.seconds
    assert any(f" ± at least {solution.dissipation_uncertainty:.2g} (" in value for _, value in summary_rows(solution))
    solution.save(tmp_path / "one.nc")
    assert ContactSolution.load(tmp_path / "one.nc").dissipation_uncertainty == solution.dissipation_uncertainty


def test_from_python_it_is_not_solved_unasked() -> None:
    solution = unsettled()
    assert np.isnan(solution.dissipation_uncertainty)
    assert not any(name.startswith("coarse mesh") for name in solution.work.counts)


def test_a_mesh_that_can_be_no_coarser_has_no_uncertainty_and_says_so() -> None:
    mesh = MeshSettings(element_size=0.25, edge_element_size=0.25, growth=1.0)
    solution = halfplane_fe.solve(load_scene("cattaneo-mindlin"), mesh, FEW, coarse_mesh=True)
    assert np.isnan(solution.dissipation_uncertainty)
    assert "the dissipation has no uncertainty: no mesh is coarser than this one" in solution.record.notes


def test_without_shear_no_coarse_mesh_is_solved() -> None:
    solution = halfplane_fe.solve(load_scene("hertz-normal"), COARSE, FEW, coarse_mesh=True)
    assert "coarse mesh" in solution.work.skipped
    assert "coarse mesh" not in solution.work.seconds
    assert solution.dissipation == 0


@pytest.mark.parametrize("failure", [ConvergenceError("it moved"), KeyboardInterrupt()])
def test_a_coarse_mesh_that_fails_takes_nothing_away(failure: BaseException, monkeypatch: pytest.MonkeyPatch) -> None:
    solving = import_module("halfplane_fe.solve")
    real, calls = solving._solve, []

    def solve(*given: object) -> object:
        calls.append(given)
        if len(calls) == 2:
            raise failure
        return real(*given)

    monkeypatch.setattr(solving, "_solve", solve)
    ask = functools.partial(halfplane_fe.solve, load_scene("cattaneo-mindlin"), COARSE, FEW, coarse_mesh=True)
    if isinstance(failure, KeyboardInterrupt):
        with pytest.raises(Interrupted, match="on the coarse mesh") as caught:
            ask()
        assert caught.value.partial is not None
        assert caught.value.partial.record.converged
        return
    solution = ask()
    assert np.isnan(solution.dissipation_uncertainty)
    assert solution.record.notes[-1].endswith("the coarse mesh that it is taken from has no answer: it moved")


def test_a_penalty_layer_stays_the_same_layer_on_the_coarse_mesh() -> None:
    """Stiffness over E*/h: as many times larger as the elements."""
    settings = SolverSettings(method="penalty", normal_stiffness=10.0, tangential_stiffness=20.0)
    found = coarse(MeshSettings(), settings)
    assert found is not None
    assert found[1] == replace(settings, normal_stiffness=50.0, tangential_stiffness=100.0)
