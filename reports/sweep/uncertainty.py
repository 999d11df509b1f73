"""How uncertain the figures of a point are: cheaply, from a coarser run beside it, or by its whole error budget."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from reports.sweep.evaluating import Asked, Question, Values, evaluate
from reports.sweep.figures import is_metric, parts

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution


def cheap_uncertainty(asked: Asked, question: Question, fe: FiniteElementSolution, values: Values, notes: dict[str, str]) -> Values:
    """What one coarser mesh, theory on the polygon of the steps and a farther far field change each figure by, added up."""
    import halfplane_fe
    from reports.ladders import coarser

    mesh, solver = coarser(question.mesh, question.solver, 2.0)
    solve = partial(halfplane_fe.solve, question.scene, settings=solver, scales=fe.scales)
    sources: list[Callable[[], tuple[Values, Values]]] = []
    coarse = evaluate(asked, question.scene, solve(mesh=mesh))[0]
    sources.append(lambda: (values, coarse))
    if "exact" in asked.engines:
        sources.append(lambda: (values, evaluate(asked, question.scene, fe, polygon=True)[0]))
    if "half_plane" in (question.scene.bodies.lower.kind, question.scene.bodies.upper.kind) and question.mesh.far_radius <= 500:
        far = replace(mesh, far_radius=2 * mesh.far_radius)
        sources.append(lambda: (coarse, evaluate(asked, question.scene, solve(mesh=far))[0]))
    total: Values = dict.fromkeys(_names(asked), 0.0)
    for source in sources:
        one, other = source()
        for name in total:
            pair = one[name], other[name]
            known = total[name]
            total[name] = None if pair[0] is None or pair[1] is None or known is None else known + abs(pair[0] - pair[1])
    for name in (name for name, value in total.items() if value is None):
        notes[f"{name}.uncertainty"] = "one of the runs that it is taken from has no such value"
    return {f"{name}.uncertainty": value for name, value in total.items()}


def _names(asked: Asked) -> list[str]:
    """Figures that have an uncertainty: those with finite elements in them."""
    return [name for name in asked.figures if is_metric(name) or parts(name)[0] != "exact"]


def budget(question: Question, fe: FiniteElementSolution, values: Values, notes: dict[str, str]) -> Values:
    """The rest of each metric that no numerical error accounts for, and how uncertain it is."""
    import semi_analytic
    from reports.budget import error_budget
    from reports.comparison import compare
    from reports.ladders import climb

    exact, polygon = (semi_analytic.solve(question.scene, x=fe.x, time=fe.time, straight_steps=way) for way in (False, True))
    comparison = compare(exact, fe, polygon_reference=polygon)
    found = error_budget(comparison, climb(comparison, question.mesh, question.solver, _silent), 1.0)
    more: Values = {}
    budgets = {budget.metric.key: budget for budget in found.budgets}
    for name in list(values):
        budget = budgets.get(name)
        more[f"{name}.idealisation"] = None if budget is None else budget.rest
        more[f"{name}.uncertainty"] = None if budget is None else budget.uncertainty
        if budget is None or budget.uncertainty is None:
            why = "; ".join(f"{term.name}: {term.how}" for term in (budget.terms if budget else ()) if not term.measured)
            notes[f"{name}.uncertainty"] = why or "the budget has no such metric"
    return more


@contextmanager
def _silent(_name: str) -> Generator[Callable[[int, int | None, str], None], None, None]:
    yield lambda _done, _total, _text: None
