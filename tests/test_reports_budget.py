"""Where errors come from: terms add up, what was not measured is never zero, half-planes test the stated uncertainty."""

from __future__ import annotations

import json
from contextlib import contextmanager
from dataclasses import replace
from html import unescape

import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.cli import main
from reports.cli.solving import exit_code, show_verdict
from reports.comparison import Comparison, Report, compare
from reports.comparison.budget import Budget, Ladders, Rung, Term, climb, coarser, error_budget, mesh_ratio, with_budget
from reports.comparison.content import as_json
from reports.comparison.metrics import are_half_planes
from reports.comparison.words import how_judged, lead, share, verdict
from reports.page.content import render
from scenes import load_scene

MESH = MeshSettings(element_size=1 / 12, edge_element_size=1 / 40, growth=0.4)
STEPS = SolverSettings(steps_per_cycle=24, step_tolerance=float("inf"))


@contextmanager
def silent(_name: str):
    yield lambda _done, _total, _text: None


def compared(name: str, mesh: MeshSettings = MESH, settings: SolverSettings = STEPS) -> Comparison:
    scene = load_scene(name)
    result = halfplane_fe.solve(scene, mesh, settings)
    reference, polygon = (
        semi_analytic.solve(scene, x=result.x, time=result.time, straight_steps=straight) for straight in (False, True)
    )
    return compare(reference, result, polygon_reference=polygon)


@pytest.fixture(scope="module")
def paper():
    """hertz-paper on a coarse mesh with few steps, and its ladders."""
    comparison = compared("hertz-paper")
    return comparison, climb(comparison, MESH, STEPS, silent)


def invented(comparison: Comparison, slope: float, limit: float, order: float = 1.0) -> Ladders:
    """Ladders on which every metric is `limit` + `slope` h^order, and nothing comes of the far field."""
    values = [{m.key: limit + slope * h**order for m in comparison.metrics} for h in (1.0, 2.0, 4.0, 8.0)]
    mesh = tuple(Rung(f"{h:g}h", h, v) for h, v in zip((1.0, 2.0, 4.0, 8.0), values, strict=True))
    return Ladders(mesh, tuple(replace(mesh[2], size=s) for s in (0.5, 1.0, 2.0)), (), "4h", {}, 1.0)


def test_terms_and_rest_add_up_to_the_metric(paper):
    budget = error_budget(*paper, plain_seconds=1.0)
    assert {"dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge"} <= {
        b.metric.key for b in budget.budgets
    }
    for one in budget.budgets:
        assert one.rest + sum(term.value or 0.0 for term in one.terms) == pytest.approx(one.total, abs=1e-14)
        assert [term.name for term in one.terms] == ["mesh", "penalty", "step", "far field", "solver", "half-plane theory"]


def test_stated_uncertainty_covers_the_known_error(paper):
    headlines = [b for b in error_budget(*paper, plain_seconds=1.0).budgets if b.metric.definition.headline]
    assert sum(b.honest for b in headlines) >= 0.9 * len(headlines)


def test_step_of_the_dissipation_is_theory_on_the_polygon_less_theory_on_the_smooth_path(paper):
    comparison, ladders = paper
    step = next(t for t in error_budget(comparison, ladders, 1.0).budget("dissipation").terms if t.name == "step")
    exact = comparison.polygon_reference.dissipation / comparison.reference.dissipation - 1
    assert abs(exact) > 1e-4
    assert step.value == pytest.approx(exact, rel=2e-2)


def test_an_idealisation_error_stands_out_and_vanishes(paper):
    """Planted: 1 % that no mesh cures, beside a mesh error of 0.1 % of first order."""
    comparison, _ = paper
    ladders = invented(comparison, 1e-3, 1e-2)
    metric = replace(comparison.metric("dissipation"), value=1.1e-2)
    found = error_budget(replace(comparison, metrics=(metric,)), ladders, 1.0).budget("dissipation")
    assert found.rest == pytest.approx(1e-2, rel=1e-6)
    assert found.uncertainty == pytest.approx(1.25e-3, rel=1e-3)
    assert found.resolved is True
    assert found.honest is False
    assert replace(found, half_planes=False).honest is None
    nothing = error_budget(replace(comparison, metrics=(replace(metric, value=1e-3),)), invented(comparison, 1e-3, 0.0), 1.0)
    assert nothing.budget("dissipation").resolved is False


def test_what_was_not_measured_is_not_zero(paper):
    comparison, ladders = paper
    fallen = tuple(replace(rung, values={}, failure=f"{rung.label} did not converge") for rung in ladders.mesh[1:])
    found = error_budget(comparison, replace(ladders, mesh=(ladders.mesh[0], *fallen)), 1.0).budget("dissipation")
    mesh = found.terms[0]
    assert (mesh.value, mesh.uncertainty, mesh.measured) == (None, None, False)
    assert mesh.how.startswith("not measured: 2h did not converge")
    assert (found.uncertainty, found.resolved, found.honest) == (None, None, None)


def test_bounds_add_and_scatter_adds_by_squares(paper):
    metric = paper[0].metric("dissipation")
    terms = tuple(Term(str(u), None, u, "", bound) for u, bound in ((3.0, False), (4.0, False), (0.5, True), (0.25, True)))
    assert Budget(metric, terms, True).uncertainty == pytest.approx(5.75)


def test_honesty_is_written_into_the_comparison(paper):
    comparison, ladders = paper
    budget = error_budget(comparison, ladders, 2 * ladders.seconds)
    told = with_budget(comparison, budget)
    assert told.budget is budget
    assert told.honest.startswith(f"{sum(b.honest for b in budget.budgets)} of {len(budget.budgets)} metrics")
    assert budget.cost == pytest.approx(1.5)
    assert Report(comparison).honest == "not assessed: the run was made without a budget"


def test_page_and_file_show_every_term(paper):
    comparison, ladders = paper
    told = with_budget(comparison, error_budget(comparison, ladders, ladders.seconds))
    page = render(told, (), "", {})
    assert all(f">{name}</th>" in page for name in ("mesh", "step", "far field", "unexplained"))
    assert "Run and budget took 2.00 times" in page
    assert "Where the discrepancy comes from" not in render(comparison, (), "", {})
    found = json.loads(as_json(told))
    shares = found["budget"]["metrics"]["dissipation"]
    values = [term["value"] or 0.0 for term in shares["terms"].values()]
    assert sum(values) + shares["unexplained"] == pytest.approx(shares["E"], abs=1e-14)
    assert found["metrics"]["dissipation"]["honest"] is shares["honest"]
    assert json.loads(as_json(comparison))["budget"] is None


def test_cells_tell_none_from_not_measured(paper):
    metric = paper[0].metric("dissipation")
    words = [share(Term("", *numbers, ""), metric) for numbers in ((None, None), (None, 0.0), (None, 2e-3), (-1e-3, 5e-4))]
    assert words == ["not measured", "none", "± 0.2 %", "−0.1 % ± 0.05 %"]


def test_rungs_need_no_coarse_run_of_their_own_and_answer_the_same():
    scene = load_scene("cattaneo-mindlin")
    whole = halfplane_fe.solve(scene, MESH, STEPS)
    spared = halfplane_fe.solve(scene, MESH, STEPS, scales=whole.scales)
    assert spared.dissipation == whole.dissipation
    assert not any(count for name, count in spared.work.counts.items() if name.startswith("coarse"))


def test_meshes_that_leave_no_room_for_a_ladder():
    assert mesh_ratio(MeshSettings.coarse()) == 2.0
    assert mesh_ratio(MeshSettings(element_size=0.1, edge_element_size=0.1)) == pytest.approx(2.5 ** (1 / 3))
    assert mesh_ratio(MeshSettings(element_size=0.25, edge_element_size=0.25)) is None


def test_a_coarser_mesh_keeps_the_same_penalty_layer():
    soft = SolverSettings(method="penalty", normal_stiffness=50.0, tangential_stiffness=20.0)
    mesh, settings = coarser(MESH, soft, 4.0)
    assert (settings.normal_stiffness, settings.tangential_stiffness) == (200.0, 80.0)
    assert settings.normal_stiffness / mesh.edge_element_size == soft.normal_stiffness / MESH.edge_element_size
    assert coarser(MESH, STEPS, 4.0)[1] == STEPS


@pytest.mark.slow
def test_penalty_is_a_term_of_its_own():
    soft = replace(STEPS, method="penalty", normal_stiffness=3.0, tangential_stiffness=3.0)
    comparison = compared("cattaneo-mindlin", settings=soft)
    found = error_budget(comparison, climb(comparison, MESH, soft, silent), 1.0).budget("dissipation")
    penalty = found.terms[1]
    exact = compared("cattaneo-mindlin").metric("dissipation").value
    assert abs(found.total - exact) > 1e-3
    assert penalty.value == pytest.approx(found.total - exact, abs=penalty.uncertainty + 0.2 * abs(penalty.value))


@pytest.mark.slow
def test_real_bodies_have_an_idealisation_error_and_no_far_field():
    comparison = compared("blocks", MeshSettings(), SolverSettings())
    found = error_budget(comparison, climb(comparison, MeshSettings(), SolverSettings(), silent), 1.0).budget("peak_pressure")
    assert found.resolved is True
    assert found.honest is None
    assert found.terms[3].how == "none: the bodies have a size of their own"


@pytest.mark.parametrize(
    ("name", "expected"), [("hertz-paper", True), ("unlike-beta-tenth", False), ("unlike-beta-fifth", False), ("blocks", False)]
)
def test_coupling_of_unlike_materials_is_an_idealisation_too(name: str, expected: bool) -> None:
    """Of such half-planes theory is not the truth: their discrepancy is no error that an uncertainty of the numbers must cover."""
    assert are_half_planes(load_scene(name)) is expected


class TestThreeStates:
    """Every verdict follows from the error, its uncertainty and the tolerance, and all doors say the same."""

    # Error and uncertainty over the tolerance, and what follows; the second is the stick edge of `blocks`.
    CASES = (
        *((0.9, 0.05, "within"), (-0.32, 15.0, "undecided"), (0.9, 0.2, "undecided"), (-1.1, 0.05, "outside")),
        *((1.1, 0.2, "undecided"), (-3.0, 1.5, "outside"), (0.9, None, "within"), (-1.1, None, "outside")),
        *((0.9, float("inf"), "undecided"), (float("nan"), 0.1, "outside"), (float("nan"), None, "outside")),
        *((-1.0, 0.0, "within"), (0.75, 0.25, "within"), (1.25, 0.25, "undecided")),
    )

    @staticmethod
    def planted(paper, error: float, doubt: float | None) -> Report:
        """The report with this dissipation, in tolerances, and a budget of one term; all else that is judged is 0."""
        comparison, ladders = paper
        size = comparison.metric("dissipation").tolerance
        values = {m.key: m.value if m.tolerance is None else 0.0 for m in comparison.metrics} | {"dissipation": error * size}
        metrics = tuple(replace(metric, value=values[metric.key]) for metric in comparison.metrics)
        whole = error_budget(replace(comparison, metrics=metrics), ladders, 1.0)
        doubts = {"dissipation": None if doubt is None else doubt * size}
        budgets = (replace(one, terms=(Term("mesh", 0.0, doubts.get(one.metric.key, 0.0), ""),)) for one in whole.budgets)
        return with_budget(replace(comparison, metrics=metrics), replace(whole, budgets=tuple(budgets)))

    @pytest.mark.parametrize(("error", "doubt", "state"), CASES)
    def test_every_door_says_the_same(self, paper, error: float, doubt: float | None, state: str, capsys):
        found = self.planted(paper, error, doubt)
        metric = found.metric("dissipation")
        assert metric.verdict == found.comparison.verdict == state
        assert metric.accurate is found.passed is (state == "within")
        stored = json.loads(as_json(found))
        assert stored["metrics"]["dissipation"]["verdict"] == stored["verdict"]["verdict"] == state
        assert stored["verdict"]["passed"] is stored["metrics"]["dissipation"]["accurate"] is (state == "within")
        page = render(found, (), "", {})
        css = {"within": "good", "outside": "bad", "undecided": "open"}
        assert f'<p class="verdict {css[state]}">' in page
        table = page[page.index("<tbody>") : page.index("</tbody>")]
        assert table.count(f'<td class="{state}">{state}</td>') == (3 if state == "within" else 1)
        assert (lead(found) == "Undecided.") is (state == "undecided")
        assert ("undecided counts as outside" in verdict(found)) is (state == "undecided")
        show_verdict(found)
        assert exit_code(found.comparison) == (0 if state == "within" else 1)
        shown = capsys.readouterr()
        assert f"│ {state}" in shown.out
        last = "halfplane: hertz-paper: undecided: dissipation; this counts as outside: exit code 1"
        assert shown.err.splitlines() == ([last] if state == "undecided" else [])

    def test_what_no_uncertainty_is_known_for_is_said(self, paper):
        """Without a budget, and where a term was not measured; nothing is said to be unknown where all is known."""
        comparison = Report(paper[0])
        assert "No uncertainty was requested" in how_judged(comparison)
        unknown = self.planted(paper, 0.9, None)
        assert how_judged(unknown).startswith("No uncertainty is known for dissipation: ")
        known = self.planted(paper, 0.9, 0.05)
        assert "No uncertainty" not in how_judged(known)
        for one in (comparison, unknown, known):
            assert how_judged(one) in unescape(render(one, (), "", {}))
            assert json.loads(as_json(one))["verdict"]["judged"] == how_judged(one)
        assert json.loads(as_json(comparison))["metrics"]["dissipation"]["uncertainty"] is None

    def test_outside_and_undecided_stand_side_by_side(self, paper):
        """One metric outside decides; the sentence names the other as undecided."""
        found = self.planted(paper, 0.9, 0.2)
        worse = tuple(replace(m, value=1.0) if m.key == "shear" else m for m in found.comparison.metrics)
        both = replace(found, comparison=replace(found.comparison, metrics=worse))
        assert both.comparison.verdict == "outside"
        assert "more than the tolerance in shear traction, L2 (" in verdict(both)
        assert "reaches across the tolerance in dissipation (" in verdict(both)

    def test_a_violated_law_is_not_undecided(self, paper, capsys):
        found = self.planted(paper, 0.9, 0.2)
        law = replace(found.comparison.result_certificates[0], value=9.0)
        violated = replace(found, comparison=replace(found.comparison, result_certificates=(law,)))
        assert lead(violated) == "Not within tolerance."
        assert exit_code(violated.comparison) == 1
        assert capsys.readouterr().err == ""

    def test_run_with_a_budget_ends_with_1_and_says_why_on_its_last_line(self, tmp_path, capsys):
        """Blocks on a mesh so coarse that the budget leaves every tolerance open."""
        coarse = ("--order", "1", "--element-size", "0.25", "--edge-element-size", "0.1", "--steps-per-cycle", "8")
        assert main(["run", "blocks", "--budget", "--out", str(tmp_path / "out"), "--quiet", *coarse]) == 1
        shown = capsys.readouterr()
        last = shown.err.splitlines()[-1]
        assert last.startswith("halfplane: blocks: undecided: ")
        assert "stick_edge" in last
        assert last.endswith("this counts as outside: exit code 1")
        stored = json.loads((tmp_path / "out" / "comparison.json").read_text(encoding="utf-8"))
        edge = stored["metrics"]["stick_edge"]
        assert edge["uncertainty"] == stored["budget"]["metrics"]["stick_edge"]["u"] > edge["tolerance"]
        assert (edge["verdict"], edge["accurate"], stored["verdict"]["passed"]) == ("undecided", False, False)
