"""How uncertain the figures of a point are: cheaply, from a coarser run beside it, or by its whole error budget."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from reports.sweep.evaluating import Asked, Evaluated, Question, Values, evaluate
from reports.sweep.figures import is_metric, parts

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution
    from meshes import MeshSettings

# Roache's index of two grids, 3/(2^p - 1) with p = 3/2: where tractions end as a root, errors fall no faster.
_MESH = 1.64
# A change by twice the distance leaves as much again, if the error falls by the first power of the distance; it falls faster.
_FAR = 2.0


def cheap_uncertainty(
    asked: Asked, question: Question, fe: FiniteElementSolution, found: Evaluated, notes: dict[str, str]
) -> Values:
    """What a coarser mesh, theory on the polygon of the steps and a farther far field change each figure by, added up.

    The mesh is made twice as coarse at the surface and in the bulk, and its share taken as `_MESH` times the change, or as what the
    solution itself says of its edges where that is more; the far field's as `_FAR` times the change.
    """
    import halfplane_fe
    from reports.comparison.budget import coarser

    scene = question.scene
    mesh, solver = coarser(question.mesh, question.solver, 2.0)

    def solved(cut: MeshSettings) -> Values:
        return evaluate(asked, scene, halfplane_fe.solve(scene, cut, solver, scales=fe.scales)).values

    shares = [(_MESH, found.values, solved(replace(mesh, growth=min(1.0, 2 * mesh.growth))))]
    if "exact" in asked.engines:
        shares.append((1.0, found.values, evaluate(asked, scene, fe, polygon=True).values))
    if "half_plane" in (scene.bodies.lower.kind, scene.bodies.upper.kind) and question.mesh.far_radius <= 500:
        # Both with the bulk as it is: a far field beyond a coarse bulk shows what the bulk does.
        shares.append((_FAR, solved(mesh), solved(replace(mesh, far_radius=2 * mesh.far_radius))))
    total: Values = {}
    for name in _names(asked):
        parts_of = [_change(name, *share) for share in shares]
        if None in parts_of:
            notes[f"{name}.uncertainty"] = "one of the runs that it is taken from has no such value"
            total[f"{name}.uncertainty"] = None
        else:
            known = [part for part in parts_of if part is not None]
            total[f"{name}.uncertainty"] = max(known[0], found.doubts.get(name, 0.0)) + sum(known[1:])
    return total


def _change(name: str, factor: float, one: Values, other: Values) -> float | None:
    """`factor` times what a figure changes by; None where one of the runs has no value."""
    here, there = one[name], other[name]
    return None if here is None or there is None else factor * abs(here - there)


def _names(asked: Asked) -> list[str]:
    """Figures that have an uncertainty: those with finite elements in them."""
    return [name for name in asked.figures if is_metric(name) or parts(name)[0] != "exact"]


def budget(question: Question, fe: FiniteElementSolution, values: Values, notes: dict[str, str]) -> Values:
    """The rest of each metric that no numerical error accounts for, and how uncertain it is."""
    import semi_analytic
    from reports.comparison import compare
    from reports.comparison.budget import climb, error_budget

    exact, polygon = (
        semi_analytic.solve(question.scene, x=fe.x, time=fe.time, straight_steps=way) for way in (False, not fe.thinned)
    )
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
