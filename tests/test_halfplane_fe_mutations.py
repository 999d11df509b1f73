"""Faults that must fail: wrong answers, a broken engine, laws broken by a thousandth, and the table
of `benchmarks/must_fail.py`.

Several well-known friction tests exercise no friction at all. Here friction is taken away, the
history is dropped, dQ changes sign, q is replaced by p, and each is refused; the right answer
passes the same checks.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe.contact import ContactProblem
from problems import COARSE, FEW_STEPS, PROBLEMS, errors, fe_run, law_violations, problems, step_at
from scenes import ConvergenceError, SurfaceState, load_scene
from tolerances import TOLERANCES

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import must_fail  # noqa: E402
from must_fail import EQUILIBRIUM, forgetting, turned_round  # noqa: E402

sys.path.remove(str(BENCHMARKS))
SHEARED = problems("tangential")
CYCLES = [problem for problem in problems("cycle") if "full stick" not in problem.tags]


def refused(problem, answer):
    """Names of the checks of `test_answers_agree_with_the_closed_forms` that fail."""
    group = "hertz" if "hertz" in problem.tags else "flat and rounded"
    measured = errors(problem, answer)
    return {
        metric
        for metric, error in measured.items()
        if not error <= TOLERANCES[f"{group} {metric}"].limit
    }


# ------------------------------------------------------------------------------------ wrong answers


def without_friction(answer):
    no_shear = np.zeros_like(answer.shear)
    return replace(
        answer,
        shear=no_shear,
        dissipation=0.0,
        tangential_displacement=np.zeros_like(answer.tangential_displacement),
    )


def shear_is_pressure(answer):
    sense = np.sign(answer.tangential_load)[:, None]
    return replace(answer, shear=sense * answer.scene.friction.coefficient * answer.pressure)


def shear_in_proportion(answer):
    """q = (Q/P) p, which has the right resultant."""
    with np.errstate(invalid="ignore"):
        slope = np.nan_to_num(answer.tangential_load / answer.normal_load)[:, None]
    return replace(answer, shear=slope * answer.pressure)


def shear_turned_round(answer):
    return replace(
        answer, shear=-answer.shear, tangential_displacement=-answer.tangential_displacement
    )


def of_another_instant(answer, problem):
    """The shear of twelve steps before."""
    step = step_at(answer, problem.time)
    shear = np.array(answer.shear)
    shear[step] = shear[step - 12]
    return replace(answer, shear=shear)


@pytest.mark.parametrize("problem", SHEARED, ids=lambda problem: problem.name)
def test_wrong_shear_is_refused_on_every_problem(problem):
    """The right answer is not. Shear in proportion to the pressure is right in full stick alone."""
    answer = fe_run(problem.scene)
    assert refused(problem, answer) == set()
    for mutation in (without_friction, shear_is_pressure, shear_turned_round):
        assert "shear" in refused(problem, mutation(answer)), mutation.__name__
    assert ("shear" in refused(problem, shear_in_proportion(answer))) == (
        "full stick" not in problem.tags
    )
    if problem in CYCLES:
        assert "shear" in refused(problem, of_another_instant(answer, problem))
        for factor in (0.0, -1.0, 0.98, 1.02, 2.0):
            assert refused(problem, replace(answer, dissipation=factor * answer.dissipation)) == {
                "dissipation"
            }


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
def test_a_few_per_cent_are_refused(problem):
    answer = fe_run(problem.scene)
    for field, share in (
        ("pressure", 0.02),
        ("contact_half_width", 0.01),
        ("stick_half_width", 0.1),
    ):
        assert field in refused(
            problem, replace(answer, **{field: (1 + share) * getattr(answer, field)})
        )


# ---------------------------------------------------------------------------------- a broken engine


def solve_broken(problem):
    """The answer of the engine as it is now, no increment halved, or None where it gives up by
    itself.

    Where Newton's sets chase each other there is no second way: with a broken law that one ends
    after nine seconds, without an answer too.
    """
    try:
        with mock.patch.object(
            ContactProblem, "_alternate_pressure_and_shear", return_value=(None, 1, 1)
        ):
            return halfplane_fe.solve(
                problem.scene, COARSE, replace(FEW_STEPS, step_tolerance=np.inf)
            )
    except (ConvergenceError, ArithmeticError, ValueError):
        return None


def in_first_revolution(name):
    """The problem at the same point of the first revolution, where its shear is true already (its
    stick zone and W are not).
    """
    problem = PROBLEMS[name]
    path = problem.scene.load.path()
    time = path.cycle_start + (problem.time - path.cycle_start) % path.period
    return replace(problem, time=time, scene=problem.scene.vary(cycles=1))


def sliding(self, history, time, loads, *_expected):
    """q replaced by p: every closed node carries f p, whatever Q is."""
    state, iterations = EQUILIBRIUM(self, history, time, loads)
    return state.changed(shear=np.sign(loads[1]) * self.friction * state.pressure), iterations


# First branches alone would not see a lost memory: that is why the table of problems has half
# reversals in it.
BROKEN = [
    (EQUILIBRIUM, "paper, reverse slip ends", False),
    (forgetting, "mindlin, half-way back", True),
    (forgetting, "paper, reverse slip ends", True),
    (forgetting, "flat and rounded, sheared", False),
    (turned_round, "paper, forward slip ends", True),
    (sliding, "mindlin, Q largest", True),
]


@pytest.mark.parametrize(
    ("engine", "name", "checks"), BROKEN, ids=lambda value: getattr(value, "__name__", value)
)
def test_a_broken_engine_is_refused_and_the_whole_one_is_not(engine, name, checks):
    problem = (
        PROBLEMS[name]
        if PROBLEMS[name].scene.load.path().period is None
        else in_first_revolution(name)
    )
    with must_fail.equilibrium(engine):
        answer = solve_broken(problem)
    assert (answer is None or "shear" in refused(problem, answer)) == checks


@pytest.mark.parametrize(("factor", "ends"), [(0.0, True), (0.5, True), (0.9, False), (1.1, False)])
def test_engine_with_other_friction_is_refused(factor, ends):
    """With f -> 0 nothing holds the tangential load, and the engine says so; with a little less or
    more it slips elsewhere.
    """
    problem = PROBLEMS["mindlin, Q largest"]
    with must_fail.friction(factor):
        answer = solve_broken(problem)
    assert (answer is None) == ends
    assert ends or {"shear", "dissipation"} <= refused(problem, answer)


# --------------------------------------------------------------------------- violations of the laws
def a_law_broken(answer, law):
    """The answer with one law broken by a thousandth."""
    step = len(answer.time) - 1
    changed = {name: np.array(getattr(answer, name)) for name in ("pressure", "shear", "slip")}
    state = answer.state[step]
    pressure, shear, slip = (values[step] for values in changed.values())
    node = int(
        np.flatnonzero(np.isin(state, [SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE]))[0]
    )
    amount = 1e-3 * answer.pressure.max()
    sense = np.sign(shear[node])
    match law:
        case "tension":
            pressure[0] -= amount
        case "open pressure":
            pressure[0] += amount
        case "cone":
            shear[node] += sense * amount
        case "sliding off the cone":
            shear[node] -= sense * amount
        case "slip against friction":
            slip[node] -= sense * np.abs(answer.slip).max()
        case "normal equilibrium":
            pressure *= 1.001
        case "tangential equilibrium":
            shear += amount * (state == SurfaceState.STICK)
        case "loads":
            changed = {"normal_load": answer.normal_load * 1.001}
        case "stick beyond contact":
            changed = {"stick_half_width": answer.contact_half_width * 1.001}
        case "negative dissipation":
            changed = {
                "dissipation_density": (
                    answer.dissipation_density - 1e-3 * answer.dissipation_density.max()
                )
            }
    return replace(answer, **changed)


def test_every_planted_violation_of_the_laws_is_seen():
    answer = fe_run(load_scene("cattaneo-mindlin"))
    healthy = law_violations(answer)
    assert max(healthy.values()) < 1e-9
    assert len(healthy) == 10
    for law in healthy:
        assert law_violations(a_law_broken(answer, law))[law] > 1e-5, law


# ----------------------------------------------------------------------- the table of the benchmark
FAULTS = {fault.name: fault for fault in must_fail.FAULTS}


@cache
def caught(name: str | None) -> frozenset[str]:
    """The checks that the answer with that fault fails, on the default mesh."""
    answer = must_fail.solved(FAULTS.get(name))
    figures = (
        dict.fromkeys(must_fail.LIMITS, float("inf"))
        if isinstance(answer, str)
        else must_fail.figures(answer)
    )
    return frozenset(
        check for check, limit in must_fail.LIMITS.items() if not figures[check] <= limit
    )


def test_every_fault_of_the_list_is_in_the_table_and_names_checks_that_exist() -> None:
    frozen = json.loads(
        (Path(__file__).parent / "contract" / "planted_faults.json").read_text(encoding="utf-8")
    )
    assert set(FAULTS) >= {row["fault"] for row in frozen if row["part"] == "finite elements"}
    assert all(
        fault.caught_by and set(fault.caught_by) <= set(must_fail.LIMITS)
        for fault in must_fail.FAULTS
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_is_caught_by_the_checks_that_it_names(name: str) -> None:
    assert set(FAULTS[name].caught_by) <= caught(name)


@pytest.mark.slow
def test_every_check_is_tripped_by_some_fault_and_by_none_of_the_healthy_model() -> None:
    assert caught(None) == set()
    assert set().union(*map(caught, FAULTS)) == set(must_fail.LIMITS)


@cache
def healthy_on_a_coarse_mesh() -> dict[str, float]:
    return must_fail.figures(must_fail.solved(None, COARSE))


@pytest.mark.parametrize(
    "name", ["history dropped", "sign of Q flipped", "pressure of sliding nodes 1 % short"]
)
def test_faults_are_caught_on_a_coarse_mesh_too(name: str) -> None:
    """What needs no reference has one limit on any mesh; against theory, shear is off by more than
    a coarse mesh costs.
    """
    healthy = healthy_on_a_coarse_mesh()
    broken = must_fail.figures(must_fail.solved(FAULTS[name], COARSE))
    for check in FAULTS[name].caught_by:
        assert broken[check] > max(must_fail.LIMITS[check], 1.5 * healthy[check]), check
    for check in ("laws of contact", "energy balance", "overlap of the faces", "creep"):
        assert healthy[check] <= must_fail.LIMITS[check]
