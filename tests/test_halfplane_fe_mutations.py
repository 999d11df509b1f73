"""Mutations that must fail: the checks of the accuracy tests, tried on wrong answers and on a broken engine.

Several well-known friction tests exercise no friction at all. Here friction is taken away, the history is dropped, dQ changes sign,
q is replaced by p, and each is refused; the right answer passes the same checks.
"""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe.contact import ContactProblem
from problems import COARSE, FEW_STEPS, PROBLEMS, errors, fe_run, law_violations, problems, step_at
from scenes import ConvergenceError, SurfaceState, freeze, load_scene
from tolerances import TOLERANCES

SHEARED = problems("tangential")
CYCLES = [problem for problem in problems("cycle") if "full stick" not in problem.tags]


def refused(problem, answer):
    """Names of the checks of `test_answers_agree_with_the_closed_forms` that fail."""
    group = "hertz" if "hertz" in problem.tags else "flat and rounded"
    found = errors(problem, answer)
    return {metric for metric, error in found.items() if not error <= TOLERANCES[f"{group} {metric}"].limit}


@pytest.mark.parametrize("problem", SHEARED, ids=lambda problem: problem.name)
def test_the_right_answer_is_not_refused(problem):
    assert refused(problem, fe_run(problem.scene)) == set()


# ----------------------------------------------------------------------------------------------------------- wrong answers
def without_friction(answer):
    still = np.zeros_like(answer.shear)
    return replace(answer, shear=still, dissipation=0.0, tangential_displacement=np.zeros_like(answer.tangential_displacement))


def shear_is_pressure(answer):
    sense = np.sign(answer.tangential_load)[:, None]
    return replace(answer, shear=sense * answer.scene.friction.coefficient * answer.pressure)


def shear_in_proportion(answer):
    """q = (Q/P) p, which has the right resultant."""
    with np.errstate(invalid="ignore"):
        slope = np.nan_to_num(answer.tangential_load / answer.normal_load)[:, None]
    return replace(answer, shear=slope * answer.pressure)


def shear_turned_round(answer):
    return replace(answer, shear=-answer.shear, tangential_displacement=-answer.tangential_displacement)


@pytest.mark.parametrize("problem", SHEARED, ids=lambda problem: problem.name)
@pytest.mark.parametrize("mutation", [without_friction, shear_is_pressure, shear_turned_round])
def test_wrong_shear_is_refused_on_every_problem(problem, mutation):
    assert "shear" in refused(problem, mutation(fe_run(problem.scene)))


@pytest.mark.parametrize("problem", SHEARED, ids=lambda problem: problem.name)
def test_shear_in_proportion_is_right_in_full_stick_alone(problem):
    wrong = refused(problem, shear_in_proportion(fe_run(problem.scene)))
    assert ("shear" in wrong) == ("full stick" not in problem.tags)


@pytest.mark.parametrize("problem", CYCLES, ids=lambda problem: problem.name)
@pytest.mark.parametrize("factor", [0.0, -1.0, 0.98, 1.02, 2.0])
def test_wrong_dissipation_is_refused(problem, factor):
    answer = fe_run(problem.scene)
    assert refused(problem, replace(answer, dissipation=factor * answer.dissipation)) == {"dissipation"}


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
@pytest.mark.parametrize(("field", "share"), [("pressure", 0.02), ("contact_half_width", 0.01), ("stick_half_width", 0.1)])
def test_a_few_per_cent_are_refused(problem, field, share):
    answer = fe_run(problem.scene)
    assert field in refused(problem, replace(answer, **{field: (1 + share) * getattr(answer, field)}))


@pytest.mark.parametrize("problem", CYCLES, ids=lambda problem: problem.name)
def test_answer_of_another_instant_is_refused(problem):
    answer = fe_run(problem.scene)
    step = step_at(answer, problem.time)
    shear = np.array(answer.shear)
    shear[step] = shear[step - 12]
    assert "shear" in refused(problem, replace(answer, shear=shear))


# --------------------------------------------------------------------------------------------------------- a broken engine
def solve_broken(problem):
    """The answer of the engine as it is now, no increment halved, or None where it gives up by itself."""
    try:
        return halfplane_fe.solve(problem.scene, COARSE, replace(FEW_STEPS, step_tolerance=np.inf))
    except (ConvergenceError, ArithmeticError, ValueError):
        return None


def in_first_revolution(name):
    """The problem at the same point of the first revolution, where its shear is true already (its stick zone and W are not)."""
    problem = PROBLEMS[name]
    path = problem.scene.load.path()
    time = path.cycle_start + (problem.time - path.cycle_start) % path.period
    return replace(problem, time=time, scene=problem.scene.vary(cycles=1))


EQUILIBRIUM = ContactProblem.equilibrium


def forgetting(self, history, time, loads):
    """Each increment starts from faces that have never slipped."""
    state = np.where(history.closed, SurfaceState.STICK, SurfaceState.OPEN)
    rest = np.zeros_like(history.slip)
    return EQUILIBRIUM(self, replace(history, slip=freeze(rest), shear=freeze(rest), state=freeze(state, np.int8)), time, loads)


def turned_round(self, history, time, loads):
    """The tangential load has the wrong sign, in the law's eyes alone."""
    state, iterations = EQUILIBRIUM(self, history, time, (loads[0], -loads[1]))
    return replace(state, tangential_load=loads[1]), iterations


@pytest.mark.parametrize("name", ["mindlin, half-way back", "paper, reverse slip ends"])
@pytest.mark.parametrize("engine", [EQUILIBRIUM, forgetting], ids=["whole", "without memory"])
def test_engine_without_memory_is_refused_and_the_whole_one_is_not(name, engine, monkeypatch):
    monkeypatch.setattr(ContactProblem, "equilibrium", engine)
    problem = in_first_revolution(name)
    assert ("shear" in refused(problem, solve_broken(problem))) == (engine is forgetting)


def test_first_branch_alone_would_not_see_a_lost_memory(monkeypatch):
    """Why the table has half reversals in it: loaded once, at constant P, the contact remembers nothing that matters.

    Nor does it at -Q, where Mindlin's cycle is the first branch turned round.
    """
    monkeypatch.setattr(ContactProblem, "equilibrium", forgetting)
    problem = PROBLEMS["flat and rounded, sheared"]
    assert refused(problem, solve_broken(problem)) == set()


@pytest.mark.parametrize("name", ["mindlin, Q largest", "paper, forward slip ends", "full-stick"])
def test_engine_with_dq_turned_round_is_refused(name, monkeypatch):
    monkeypatch.setattr(ContactProblem, "equilibrium", turned_round)
    problem = in_first_revolution(name)
    assert "shear" in refused(problem, solve_broken(problem))


@pytest.mark.parametrize(("factor", "ends"), [(0.0, True), (0.5, True), (0.9, False), (1.1, False)])
def test_engine_with_other_friction_is_refused(factor, ends, monkeypatch):
    """With f -> 0 nothing holds the tangential load, and the engine says so; with a little less or more it slips elsewhere."""
    solve = import_module("halfplane_fe.solve")
    make = solve.ContactProblem
    monkeypatch.setattr(solve, "ContactProblem", lambda sides, height, f, *rest: make(sides, height, factor * f, *rest))
    problem = PROBLEMS["mindlin, Q largest"]
    answer = solve_broken(problem)
    assert (answer is None) == ends
    assert ends or {"shear", "dissipation"} <= refused(problem, answer)


@pytest.mark.parametrize("name", ["mindlin, Q largest", "full-stick"])
def test_engine_that_slides_everywhere_is_refused(name, monkeypatch):
    """q replaced by p: every closed node carries f p, whatever Q is."""

    def sliding(self, history, time, loads):
        state, iterations = EQUILIBRIUM(self, history, time, loads)
        return replace(state, shear=freeze(np.sign(loads[1]) * self.friction * state.pressure)), iterations

    monkeypatch.setattr(ContactProblem, "equilibrium", sliding)
    problem = in_first_revolution(name)
    assert "shear" in refused(problem, solve_broken(problem))


# ------------------------------------------------------------------------------------------------- violations of the laws
def planted(answer, name):
    """The answer with one law broken by a thousandth."""
    step = len(answer.time) - 1
    pressure, shear, slip, state = (np.array(getattr(answer, field)) for field in ("pressure", "shear", "slip", "state"))
    node = int(np.flatnonzero(np.isin(state[step], [SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE]))[0])
    amount = 1e-3 * pressure.max()
    match name:
        case "tension":
            pressure[step, 0] -= amount
        case "open pressure":
            pressure[step, 0] += amount
        case "cone":
            shear[step, node] += np.sign(shear[step, node]) * amount
        case "sliding off the cone":
            shear[step, node] -= np.sign(shear[step, node]) * amount
        case "slip against friction":
            slip[step, node] -= np.sign(shear[step, node]) * np.abs(slip).max()
        case "normal equilibrium":
            pressure[step] *= 1.001
        case "tangential equilibrium":
            shear[step] += amount * (state[step] == SurfaceState.STICK)
        case "loads":
            return replace(answer, normal_load=answer.normal_load * 1.001)
        case "stick beyond contact":
            return replace(answer, stick_half_width=answer.contact_half_width * 1.001)
        case "negative dissipation":
            return replace(answer, dissipation_density=answer.dissipation_density - 1e-3 * answer.dissipation_density.max())
    return replace(answer, pressure=pressure, shear=shear, slip=slip, state=state)


LAWS = (
    *("tension", "open pressure", "cone", "sliding off the cone", "slip against friction"),
    *("normal equilibrium", "tangential equilibrium", "loads", "stick beyond contact", "negative dissipation"),
)


@pytest.mark.parametrize("name", LAWS)
def test_every_planted_violation_of_the_laws_is_seen(name):
    answer = fe_run(load_scene("cattaneo-mindlin"))
    assert set(law_violations(answer)) == set(LAWS)
    assert law_violations(answer)[name] < 1e-9
    assert law_violations(planted(answer, name))[name] > 1e-5
