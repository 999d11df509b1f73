"""Where errors come from: mesh refinements with known answers, terms that add up, uncertainties
that cover, three verdicts.
"""

from __future__ import annotations

import json
import re
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from command_line import raising
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.cli.solving import exit_code, verdict_shown
from reports.comparison import Comparison, compare
from reports.comparison import budget as budgets
from reports.comparison.budget import (
    Budget,
    Refinement,
    Refinements,
    Run,
    Term,
    coarser_mesh_and_settings,
    error_budget,
    extrapolate,
    kind_of_sequence,
    mesh_ratio,
    observed_order,
    solve_refinements,
)
from reports.comparison.budget_words import budget_table, cell_of_term, negligible_terms
from reports.comparison.words import verdict_in_few_words, verdict_in_sentences
from reports.console import show
from reports.page.content import as_json
from reports.page.writing import _dissipations, render
from reports.report import Report, with_budget
from scenes import InputError, load_scene

DOUBLING = (1.0, 2.0, 4.0, 8.0)


# -------------------------------------------------------------------------------------- refinements
def refinement(of, sizes=DOUBLING, **keywords) -> Refinement:
    return Refinement(sizes, tuple(float(of(h)) for h in sizes), **keywords)


def test_example_of_nasa_to_every_digit():
    """Examining Spatial (Grid) Convergence, NPARC Alliance: values, ratio 2, safety factor 1.25."""
    nasa = Refinement((1.0, 2.0, 4.0), (0.97050, 0.96854, 0.96178))
    limit = extrapolate(nasa)
    numbers = (limit.order, limit.value, limit.uncertainty / 0.97050)
    assert [f"{number:.6f}" for number in numbers] == ["1.786170", "0.971300", "0.001031"]
    assert limit.kind == "monotone"


@pytest.mark.parametrize("order", [0.7, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("sizes", [(1.0, 2.0, 4.0), DOUBLING, (1.0, 1.3, 2.1, 4.0, 5.0)])
def test_powers_are_found_whatever_the_ratios(order, sizes):
    """On such a curve the uncertainty is a quarter more than the error of the finest run, and falls
    with it.
    """
    for finer in (1.0, 0.5):
        limit = extrapolate(refinement(lambda h, k=finer: 3 - 0.02 * (k * h) ** order, sizes))
        assert limit.kind == "monotone"
        assert (limit.order, limit.value) == pytest.approx((order, 3), abs=1e-6)
        assert limit.uncertainty == pytest.approx(1.25 * 0.02 * finer**order, rel=1e-4)


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ((1.0, 1.1, 1.3), "monotone"),
        ((1.0, 1.3, 1.4), "diverging"),
        ((1.0, 1.1, 0.7), "oscillating"),
        ((1.0, 1.4, 1.3), "diverging"),
        ((1.0, 1.0, 1.0), "exact"),
        ((1.0, 1.2), "too few"),
        ((1.0,), "too few"),
        ((1.0, 1.1, 1.3, 1.7), "monotone"),
        ((1.0, 0.9, 1.3, 0.5), "oscillating"),
        ((1.0, 1.8, 2.2, 2.4), "diverging"),
        ((1.0, 0.2, 0.5, 0.4), "diverging"),
    ],
)
def test_kinds(values, kind):
    assert kind_of_sequence(Refinement(DOUBLING[: len(values)], values)) == kind


def test_rules_for_what_is_no_clean_power():
    """Which rule, which value, which uncertainty."""
    two = extrapolate(Refinement((1.0, 2.0), (1.1, 1.2)))
    assert two.kind == "too few"
    assert abs(two.value - 1.0) <= two.uncertainty
    nowhere = extrapolate(Refinement((1.0, 2.0, 4.0), (1.0, 1.4, 1.3)))
    # three times the spread
    assert (nowhere.value, nowhere.uncertainty) == (1.0, pytest.approx(1.2))
    steep = extrapolate(refinement(lambda h: 1 + 0.01 * h**4))
    assert steep.order == pytest.approx(4, abs=1e-3)
    assert "assumed" in steep.rule
    assert abs(steep.value - 1) <= steep.uncertainty
    assert "Roache" in extrapolate(refinement(lambda h: 1 + 0.01 * h**4, formal_order=4.0)).rule
    exact = extrapolate(Refinement(DOUBLING, (1.0, 1.0 + 1e-13, 1.0, 1.0), rounding=1e-12))
    assert (exact.kind, exact.value, exact.uncertainty) == ("exact", 1.0, 1e-12)
    scattered = extrapolate(Refinement(DOUBLING, (1.011, 1.018, 1.042, 1.079)))
    assert ("least squares" in scattered.rule, scattered.kind) == (True, "monotone")
    assert scattered.value == pytest.approx(1.0, abs=2e-3)
    # Mixed orders: the lowest decides.
    turned = refinement(lambda h: 1 + 0.01 * h**2 + 0.01 * h - 4e-5 * h**4)
    orders = [observed_order(turned.sizes[i : i + 3], turned.values[i : i + 3]) for i in (0, 1)]
    assert orders[0] > orders[1]
    limit = extrapolate(turned)
    assert ("Roache" in limit.rule, limit.order) == (True, orders[0])
    assert limit.uncertainty == pytest.approx(
        1.25 * (turned.values[1] - turned.values[0]) / (2 ** orders[1] - 1), rel=1e-12
    )


@pytest.mark.parametrize(("noise", "least"), [(1e-4, 1.0), (3e-3, 0.9), (3e-2, 0.9), (1.0, 0.95)])
@pytest.mark.parametrize("order", [1.0, 2.0])
def test_scattered_refinements_cover_the_truth(order, noise, least):
    """Four runs, the noise from far below to far above the trend of 0.01; of 400 draws 94 % to 100
    % are covered.
    """
    rng = np.random.default_rng(20)
    limits = [
        extrapolate(refinement(lambda h: 1 + 0.01 * h**order + noise * rng.uniform(-1, 1)))
        for _ in range(50)
    ]
    assert np.mean([abs(limit.value - 1) <= limit.uncertainty for limit in limits]) >= least


def test_refinements_that_are_none():
    assert observed_order((1.0, 2.0, 4.0), (1.0, 1.3, 1.4)) is None
    assert observed_order((1.0, 2.0, 4.0), (1.0, 1.0, 1.4)) is None
    for sizes, values, words in (
        ((1.0, 2.0), (1.0,), "2 sizes"),
        ((2.0, 1.0), (1.0, 2.0), "finest comes first"),
        ((1.0, 2.0), (1.0, float("nan")), "not finite"),
    ):
        with pytest.raises(ValueError, match=words):
            Refinement(sizes, values)


# ------------------------------------------------------------------------------------------- budget
MESH = MeshSettings(element_size=1 / 12, edge_element_size=1 / 40, growth=0.4)
STEPS = SolverSettings(steps_per_cycle=24, step_tolerance=float("inf"))


@contextmanager
def silent(_name: str):
    yield lambda _step, _total, _text: None


def compared(name: str, mesh: MeshSettings = MESH, settings: SolverSettings = STEPS) -> Comparison:
    scene = load_scene(name)
    solution = halfplane_fe.solve(scene, mesh, settings)
    reference, polygon = (
        semi_analytic.solve(scene, x=solution.x, time=solution.time, straight_steps=straight)
        for straight in (False, True)
    )
    return compare(reference, solution, polygon_reference=polygon)


@pytest.fixture(scope="module")
def paper():
    """hertz-paper on a coarse mesh with few steps, and its refinements."""
    comparison = compared("hertz-paper")
    return comparison, solve_refinements(comparison, MESH, STEPS, silent)


def invented(comparison: Comparison, slope: float, limit: float) -> Refinements:
    """Refinements on which every metric is `limit` + `slope` h, and nothing comes of the far
    field.
    """
    keys = [metric.key for metric in comparison.metrics]
    mesh = tuple(Run(f"{h:g}h", h, dict.fromkeys(keys, limit + slope * h)) for h in DOUBLING)
    return Refinements(
        mesh, tuple(replace(mesh[2], size=s) for s in (0.5, 1.0, 2.0)), (), "4h", {}, 1.0
    )


def test_terms_and_rest_add_up_to_the_metric(paper):
    """And the uncertainty covers the known error; W's step is theory's on the polygon, with what
    the run adds for the curve.
    """
    comparison, refinements = paper
    budget = error_budget(comparison, refinements, seconds_of_run=1.0)
    keys = {"dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge"}
    assert keys <= {line.metric.key for line in budget.budgets}
    for line in budget.budgets:
        assert line.rest_of_error + sum(term.value or 0.0 for term in line.terms) == pytest.approx(
            line.error, abs=1e-14
        )
        assert [term.name for term in line.terms] == [
            "mesh",
            "penalty",
            "step",
            "far field",
            "solver",
            "half-plane theory",
        ]
    headlines = [line for line in budget.budgets if line.metric.headline]
    assert all(line.is_covered for line in headlines)
    exact = comparison.metric("dissipation_step").value
    assert abs(exact) > 1e-4
    straight = comparison.polygon_reference.dissipation / comparison.reference.dissipation - 1
    assert abs(straight) > 5 * abs(exact)
    assert budget.budget("dissipation").terms[2].value == pytest.approx(exact, rel=2e-2)


def test_an_idealisation_error_stands_out_and_vanishes(paper):
    """Planted: 1 % that no mesh cures, beside a mesh error of 0.1 % of first order."""
    comparison, _ = paper
    metric = replace(comparison.metric("dissipation"), value=1.1e-2, stated=(0.0, float("nan")))
    line = error_budget(
        replace(comparison, metrics=(metric,)), invented(comparison, 1e-3, 1e-2), 1.0
    ).budget("dissipation")
    assert line.rest_of_error == pytest.approx(1e-2, rel=1e-6)
    assert line.uncertainty == pytest.approx(1.25e-3, rel=1e-3)
    assert (line.is_resolved, line.is_covered, replace(line, are_half_planes=False).is_covered) == (
        True,
        False,
        None,
    )
    nothing = error_budget(
        replace(comparison, metrics=(replace(metric, value=1e-3),)),
        invented(comparison, 1e-3, 0.0),
        1.0,
    )
    assert nothing.budget("dissipation").is_resolved is False


@pytest.mark.parametrize("key", ["dissipation", "largest_slip"])
@pytest.mark.parametrize("stated", [1e-4, 0.0, 9e-3, float("nan")])
def test_a_value_and_its_difference_are_equally_uncertain(paper, key, stated):
    """Runs at 0, 1e-3, -1e-3 are three times their spread uncertain, 6e-3: that counts only where
    the run states nothing of the value.
    """
    comparison, refinements = paper
    values = (0.0, 1e-3, -1e-3)
    runs = tuple(
        Run(f"{h:g}h", h, {key: value}) for h, value in zip((1.0, 2.0, 4.0), values, strict=True)
    )
    metric = comparison.metric(key)
    metric = replace(metric, stated=(0.0, stated * metric.denominator), uncertainty=None)
    line = error_budget(
        replace(comparison, metrics=(metric,)), replace(refinements, mesh_runs=runs), 1.0
    ).budget(key)
    mesh = line.terms[0]
    by_runs = np.isnan(stated)
    assert mesh.uncertainty == pytest.approx(6e-3 if by_runs else stated)
    assert mesh.value is None
    assert ("that the run itself states" in mesh.how_measured) is not by_runs
    if stated < 6e-3:
        assert "three times the spread, 6.0e-03" in mesh.how_measured
        assert line.uncertainty < 6e-3


def test_what_theory_on_grids_states_is_its_error_and_what_it_does_not_is_said(paper):
    """A stick edge lies anywhere in its cell. The error of W(x) is none of W."""
    comparison, refinements = paper
    reference = comparison.reference
    on_grids = replace(
        reference,
        work=replace(reference.work, counts={**reference.work.counts, "grids": 8}),
        uncertainties={"stick_edges": 0.0125 * comparison.scales.half_width},
        record=replace(
            reference.record, errors={"dissipation": 4e-4, "dissipation_density": 5e-3, "slip": 0}
        ),
    )
    budget = error_budget(
        replace(comparison, reference=on_grids, polygon_reference=None), refinements, 1.0
    )
    terms = {line.metric.key: line.terms[5] for line in budget.budgets}
    assert terms["stick_edge"].uncertainty == pytest.approx(0.0125)
    assert terms["dissipation"].uncertainty == pytest.approx(4e-4)
    assert "grids" in terms["dissipation"].how_measured
    assert "states no error" in terms["state"].how_measured
    assert terms["contact_edge"].how_measured == "closed forms: rounding"
    plain = error_budget(comparison, refinements, 1.0).budget("stick_edge").terms[5]
    assert (plain.uncertainty, plain.how_measured) == (1e-12, "closed forms: rounding")


@pytest.mark.parametrize(("error", "is_seen"), [(3.9e-3, False), (4.1e-3, True)])
def test_a_far_field_error_is_judged_on_the_mesh_where_it_is_measured(paper, error, is_seen):
    """At 4h, though the coarsest mesh is that of 8h."""
    comparison, refinements = paper
    metric = comparison.metric("dissipation")
    metric = replace(metric, stated=(0.0, 1e-3 * metric.denominator), uncertainty=None)
    mesh_runs = tuple(Run(f"{h:g}h", h, {"dissipation": 1e-3 * h}) for h in (1.0, 2.0, 4.0, 8.0))
    far_field_runs = tuple(
        Run(f"4h, {size:g}", size, {"dissipation": error * size**4}) for size in (0.5, 1.0, 2.0)
    )
    planted = replace(
        refinements, mesh_runs=mesh_runs, far_field_runs=far_field_runs, coarse_label="4h"
    )
    budget = error_budget(replace(comparison, metrics=(metric,)), planted, 1.0)
    far_field = budget.budget("dissipation").terms[3]
    assert far_field.value == (pytest.approx(error) if is_seen else None)


def test_what_was_not_measured_is_not_zero_and_bounds_add_where_scatter_adds_by_squares(paper):
    comparison, refinements = paper
    fallen = tuple(
        replace(run, values={}, failure=f"{run.label} did not converge")
        for run in refinements.mesh_runs[1:]
    )
    line = error_budget(
        comparison, replace(refinements, mesh_runs=(refinements.mesh_runs[0], *fallen)), 1.0
    ).budget("dissipation")
    mesh = line.terms[0]
    assert (mesh.value, mesh.uncertainty, mesh.is_measured) == (None, None, False)
    assert mesh.how_measured.startswith("not measured: 2h did not converge")
    assert (line.uncertainty, line.is_resolved, line.is_covered) == (None, None, None)
    metric = comparison.metric("dissipation")
    terms = tuple(
        Term(str(u), None, u, "", bound)
        for u, bound in ((3.0, False), (4.0, False), (0.5, True), (0.25, True))
    )
    assert Budget(metric, terms, True).uncertainty == pytest.approx(5.75)
    cells = [
        cell_of_term(Term("", *numbers, ""), metric)
        for numbers in ((None, None), (None, 0.0), (None, 2e-3), (-1e-3, 5e-4))
    ]
    assert cells == ["not measured", "none", "± 0.2 %", "−0.1 % ± 0.05 %"]


def test_a_term_below_a_thousandth_everywhere_has_no_column_and_is_named(paper):
    comparison, refinements = paper
    budget = error_budget(comparison, refinements, refinements.cpu_seconds)
    without = negligible_terms(budget)
    assert "mesh" not in without
    assert without
    heads, rows, others = budget_table(budget, without)
    assert not set(without) & set(heads)
    assert all(len(row) == len(heads) for row in (*rows, *others))
    assert f"not shown: {', '.join(without)}." in render(
        Report(comparison, budget=budget), (), "", {}
    )

    first, *further = budget.budgets
    assert first.metric.headline
    planted = tuple(
        replace(term, value=0.5, uncertainty=0.0) if term.name == without[0] else term
        for term in first.terms
    )
    with_fault = replace(budget, budgets=(replace(first, terms=planted), *further))
    assert without[0] not in negligible_terms(with_fault)


def test_honesty_is_written_into_the_comparison_page_and_file(paper):
    comparison, refinements = paper
    budget = error_budget(comparison, refinements, refinements.cpu_seconds)
    report = with_budget(comparison, budget)
    assert report.budget is budget
    assert report.coverage_in_words.startswith(
        f"{sum(b.is_covered for b in budget.budgets)} of {len(budget.budgets)} metrics"
    )
    assert budget.cpu_time_ratio == pytest.approx(2.0)
    assert Report(comparison).coverage_in_words == "not assessed: the run was made without a budget"
    page = render(report, (), "", {})
    assert all(f">{name}</th>" in page for name in ("mesh", "step", "far field", "unexplained"))
    assert "Run and budget took 2.00 times" in page
    assert "Where the discrepancy comes from" not in render(Report(comparison), (), "", {})
    stored = json.loads(as_json(report))
    shares = stored["budget"]["metrics"]["dissipation"]
    values = [term["value"] or 0.0 for term in shares["terms"].values()]
    assert sum(values) + shares["unexplained"] == pytest.approx(shares["E"], abs=1e-14)
    assert stored["metrics"]["dissipation"]["honest"] is shares["honest"]
    assert json.loads(as_json(Report(comparison)))["budget"] is None


def test_where_theory_has_no_polygon_the_step_is_measured_by_halving_it(paper, monkeypatch) -> None:
    """Known amounts: a metric of 1 % that halved increments take to 0.97 %."""
    comparison, _ = paper
    metric = replace(comparison.metric("dissipation"), value=0.0100)

    def run(label: str, value: float | None, failure: str = "") -> Run:
        return Run(label, 1.0, {} if value is None else {"dissipation": value}, failure)

    def step(*runs: Run) -> Term:
        return budgets._step_term(
            metric, Refinements((run("h", 0.01),), (), (), "4h", {}, 1.0, runs)
        )

    term = step(run("4h", 0.0100), run("4h, halved", 0.0097))
    assert (term.value, term.uncertainty) == pytest.approx((4e-4, 3e-4), rel=1e-9)
    assert "halved increments" in term.how_measured
    for lost in (
        step(),
        step(run("4h", 0.01), run("4h, halved", None, "4h, halved did not converge")),
    ):
        assert not lost.is_measured
        assert "no answer on the polygon" in lost.how_measured
    # Theory that refuses its polygon: never of a scene without bulk stress and tilt.
    solution = comparison.result
    assert budgets.theory_on_steps(solution) is not None

    monkeypatch.setattr(
        semi_analytic, "solve", raising(InputError("straight_steps: not with bulk stress or tilt"))
    )
    with pytest.raises(InputError):
        budgets.theory_on_steps(solution)
    pulled = replace(solution, scene=solution.scene.vary(load={"bulk_stress_lower": 1.0}))
    assert budgets.theory_on_steps(pulled) is None


def test_without_a_budget_theory_on_the_steps_is_shown_with_the_same_values(paper):
    """The page and comparison.json show it; what is left out is stated."""
    comparison = paper[0]
    few_fields = budgets.theory_on_steps(comparison.result, budgets.SHOWN_ON_STEPS)
    whole, short = (
        compare(comparison.reference, comparison.result, polygon_reference=on_steps)
        for on_steps in (budgets.theory_on_steps(comparison.result), few_fields)
    )
    assert np.isnan(few_fields.shear).all()
    assert "shear" in few_fields.work.skipped
    contents = [json.loads(as_json(Report(one)))["polygon_reference"] for one in (whole, short)]
    for content in contents:
        for of_the_work in ("counts", "skipped", "seconds", "settings"):
            del content[of_the_work]
    assert contents[0] == contents[1]
    assert list(_dissipations(short)) == list(_dissipations(whole))


def test_rungs_need_no_coarse_run_of_their_own_and_keep_the_penalty_layer(paper):
    solution = paper[0].result
    scene = load_scene("cattaneo-mindlin")
    coarse = MeshSettings(element_size=0.25, edge_element_size=0.1, order=1)
    first = halfplane_fe.solve(scene, coarse, STEPS)
    spared = halfplane_fe.solve(scene, coarse, STEPS, scales=first.scales)
    assert spared.dissipation == first.dissipation
    assert not any(count for name, count in spared.work.counts.items() if name.startswith("coarse"))
    assert any(count for name, count in solution.work.counts.items() if name.startswith("coarse"))
    assert mesh_ratio(MeshSettings.coarse()) == 2.0
    assert mesh_ratio(MeshSettings(element_size=0.1, edge_element_size=0.1)) == pytest.approx(
        2.5 ** (1 / 3)
    )
    # no room for a refinement
    assert mesh_ratio(MeshSettings(element_size=0.25, edge_element_size=0.25)) is None
    soft = SolverSettings(method="penalty", normal_stiffness=50.0, tangential_stiffness=20.0)
    mesh, settings = coarser_mesh_and_settings(MESH, soft, 4.0)
    assert (settings.normal_stiffness, settings.tangential_stiffness) == (200.0, 80.0)
    assert (
        settings.normal_stiffness / mesh.edge_element_size
        == soft.normal_stiffness / MESH.edge_element_size
    )
    assert coarser_mesh_and_settings(MESH, STEPS, 4.0)[1] == STEPS


@pytest.mark.slow
def test_penalty_is_a_term_of_its_own():
    soft = replace(STEPS, method="penalty", normal_stiffness=3.0, tangential_stiffness=3.0)
    comparison = compared("cattaneo-mindlin", settings=soft)
    line = error_budget(comparison, solve_refinements(comparison, MESH, soft, silent), 1.0).budget(
        "dissipation"
    )
    penalty = line.terms[1]
    exact = compared("cattaneo-mindlin").metric("dissipation").value
    assert abs(line.error - exact) > 1e-3
    assert penalty.value == pytest.approx(line.error - exact, rel=1e-9)
    layered, bare = (
        halfplane_fe.solve(
            comparison.scene, *coarser_mesh_and_settings(MESH, law, 0.25)
        ).dissipation
        / comparison.reference.dissipation
        for law in (soft, STEPS)
    )
    assert abs(penalty.value - (layered - bare)) < penalty.uncertainty < 2 * abs(penalty.value)


def test_an_edge_without_an_estimate_leaves_that_of_the_other_one(paper):
    """Runs agree to the last digit; the left contact edge has no estimate, the right one 0.01 a."""
    comparison, refinements = paper
    metric = replace(comparison.metric("contact_edge"), uncertainty=None)
    half_width = comparison.scales.half_width
    uncertainties = np.tile([np.nan, 0.01 * half_width], (len(comparison.result.time), 1))
    result = replace(comparison.result, contact_edge_uncertainty=uncertainties)
    runs = tuple(Run(f"{h:g}h", h, {metric.key: metric.value}) for h in (1.0, 2.0, 4.0))
    line = error_budget(
        replace(comparison, metrics=(metric,), result=result),
        replace(refinements, mesh_runs=runs),
        1.0,
    ).budget(metric.key)
    assert line.terms[0].uncertainty == pytest.approx(0.01)


def test_meshes_of_real_bodies_that_agree_by_chance_leave_the_peak_as_uncertain_as_the_run_states():
    """Of a pair of layers an error of 1.4e-4 was stated as 4e-6."""
    comparison = compared("blocks", MeshSettings.coarse(), replace(STEPS, steps_per_cycle=8))
    solution = comparison.result
    values = budgets.values_without_step_error(comparison)
    largest = {"largest_pressure": values["largest_pressure"]}
    runs = tuple(Run(f"{size:g}h", size, largest) for size in (1.0, 2.0, 4.0))
    line = error_budget(comparison, Refinements(runs, (), (), "4h", {}, 0.0), 1.0).budget(
        "largest_pressure"
    )
    stated = (
        solution.uncertainties["largest_pressure"]
        / comparison.reference.pressure[comparison.reference.last_cycle].max()
    )
    assert line.uncertainty == pytest.approx(stated, rel=1e-2)
    assert line.uncertainty > 1e-4
    assert "the run itself states" in line.terms[0].how_measured


@pytest.mark.slow
def test_real_bodies_have_an_idealisation_error_and_no_far_field():
    comparison = compared("blocks", MeshSettings(), SolverSettings())
    line = error_budget(
        comparison, solve_refinements(comparison, MeshSettings(), SolverSettings(), silent), 1.0
    ).budget("peak_pressure")
    assert (line.is_resolved, line.is_covered) == (True, None)
    assert line.terms[3].how_measured == "none: the bodies have a size of their own"


# ------------------------------------------------------------------------------------- three states
# Error and uncertainty over the tolerance, and what follows; the second is the stick edge of
# `blocks`.
CASES = (
    *(
        (0.9, 0.05, "within"),
        (-0.32, 15.0, "undecided"),
        (0.9, 0.2, "undecided"),
        (-1.1, 0.05, "outside"),
    ),
    *(
        (1.1, 0.2, "undecided"),
        (-3.0, 1.5, "outside"),
        (0.9, None, "within"),
        (-1.1, None, "outside"),
    ),
    *(
        (0.9, float("inf"), "undecided"),
        (float("nan"), 0.1, "outside"),
        (float("nan"), None, "outside"),
    ),
    *((-1.0, 0.0, "within"), (0.75, 0.25, "within"), (1.25, 0.25, "undecided")),
)


def planted(paper, error: float, doubt: float | None) -> Report:
    """The report with this dissipation, in tolerances, and a budget of one term; all else that is
    judged is 0.
    """
    comparison, refinements = paper
    size = comparison.metric("dissipation").tolerance
    values = {m.key: m.value if m.tolerance is None else 0.0 for m in comparison.metrics} | {
        "dissipation": error * size
    }
    metrics = tuple(replace(metric, value=values[metric.key]) for metric in comparison.metrics)
    budget = error_budget(replace(comparison, metrics=metrics), refinements, 1.0)
    doubts = {"dissipation": None if doubt is None else doubt * size}
    budgets = (
        replace(line, terms=(Term("mesh", 0.0, doubts.get(line.metric.key, 0.0), ""),))
        for line in budget.budgets
    )
    return with_budget(
        replace(comparison, metrics=metrics), replace(budget, budgets=tuple(budgets))
    )


@pytest.mark.parametrize(("error", "doubt", "state"), CASES)
def test_every_door_says_the_same_of_a_verdict(
    paper, error: float, doubt: float | None, state: str, capsys
):
    """It follows from the error, its uncertainty and the tolerance."""
    report = planted(paper, error, doubt)
    metric = report.metric("dissipation")
    assert metric.verdict == report.comparison.verdict == state
    assert metric.accurate is report.passed is (state == "within")
    stored = json.loads(as_json(report))
    assert stored["metrics"]["dissipation"]["verdict"] == stored["verdict"]["verdict"] == state
    assert (
        stored["verdict"]["passed"]
        is stored["metrics"]["dissipation"]["accurate"]
        is (state == "within")
    )
    page = render(report, (), "", {})
    css = {"within": "good", "outside": "bad", "undecided": "open"}
    assert f'<p class="verdict {css[state]}">' in page
    table = page[page.index("<tbody>") : page.index("</tbody>")]
    assert table.count(f'<td class="{state}">{state}</td>') == (3 if state == "within" else 1)
    assert (verdict_in_few_words(report.comparison) == "Undecided.") is (state == "undecided")
    assert ("undecided counts as outside" in verdict_in_sentences(report.comparison)) is (
        state == "undecided"
    )
    show(verdict_shown(report))
    assert exit_code(report.comparison) == (0 if state == "within" else 1)
    streams = capsys.readouterr()
    assert re.search(rf"│ ?{state} *│?$", streams.out, re.MULTILINE)
    last = "halfplane: hertz-paper: undecided: dissipation; this counts as outside: exit code 1"
    assert streams.err.splitlines() == ([last] if state == "undecided" else [])


def test_outside_and_a_violated_law_come_before_undecided(paper, capsys):
    report = planted(paper, 0.9, 0.2)
    worse = tuple(
        replace(m, value=1.0) if m.key == "shear" else m for m in report.comparison.metrics
    )
    report_of_both = replace(report, comparison=replace(report.comparison, metrics=worse))
    assert report_of_both.comparison.verdict == "outside"
    assert "more than the tolerance in shear traction, L2 (" in verdict_in_sentences(
        report_of_both.comparison
    )
    assert "reaches across the tolerance in dissipation (" in verdict_in_sentences(
        report_of_both.comparison
    )
    law = replace(report.comparison.result_certificates[0], value=9.0)
    violated = replace(report, comparison=replace(report.comparison, result_certificates=(law,)))
    assert (verdict_in_few_words(violated.comparison), exit_code(violated.comparison)) == (
        "Not within tolerance.",
        1,
    )
    assert capsys.readouterr().err == ""
