"""What a worker does: points in as JSON, figures out as JSON. A point that fails is an answer too, with its reason and record."""

from __future__ import annotations

import json
import math
import os
import platform
import tempfile
import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Any

from threadpoolctl import threadpool_limits

from reports.sweep.batching import in_one_call
from reports.sweep.evaluating import Asked, Question, Values, evaluate, exact_alone, finite_elements
from reports.sweep.figures import take
from reports.sweep.uncertainty import budget, cheap_uncertainty
from reports.sweep.versions import code_versions, difference
from scenes import ContactSolution, ConvergenceError, InputError, Scene


def solve_task(text: str) -> str:
    """Solve the points of a task.

    Parameters
    ----------
    text : JSON of {"versions", "engines", "figures", "uncertainty", "share", "points": [{"address", "scene", "mesh", "solver"}]}

    Returns
    -------
    JSON of {"mismatch": sentence or "", "answers": one for each point}
    """
    task = json.loads(text)
    if words := difference(task["versions"], code_versions()):
        return json.dumps({"mismatch": f"worker {platform.node()} (process {os.getpid()}): {words}", "answers": []})
    asked = Asked(tuple(task["engines"]), tuple(task["figures"]), task["uncertainty"], task["share"])
    with threadpool_limits(limits=1), _shared_store(asked.share and len(task["points"]) > 1):
        batch = in_one_call(asked, task["points"])
        answers = [batch.get(number) or _answer(asked, job) for number, job in enumerate(task["points"])]
    return json.dumps({"mismatch": "", "answers": answers}, allow_nan=False)


@contextmanager
def _shared_store(wanted: bool) -> Generator[None, None, None]:
    """A store of condensed bodies for the time of a task, where the user keeps none."""
    from halfplane_fe.store import cache_folder

    if not wanted or cache_folder() is not None:
        yield
        return
    before = os.environ.get("HALFPLANE_CACHE")
    with tempfile.TemporaryDirectory(prefix="halfplane-") as folder:
        os.environ["HALFPLANE_CACHE"] = folder
        try:
            yield
        finally:
            os.environ.pop("HALFPLANE_CACHE") if before is None else os.environ.update(HALFPLANE_CACHE=before)


def _answer(asked: Asked, job: Mapping[str, Any]) -> dict[str, Any]:
    """One point: its figures, or the reason why it has none."""
    begun = time.perf_counter()
    answer: dict[str, Any] = {"address": job["address"], "status": "done", "reason": "", "figures": {}, "notes": {}, "record": {}}
    try:
        answer |= _solve(asked, _question(job))
    except ConvergenceError as failure:
        answer |= {"status": "failed", "reason": f"not converged: {failure}", "record": _record(failure.partial)}
    except InputError as failure:
        answer |= {"status": "failed", "reason": str(failure)}
    except (ArithmeticError, ValueError, RuntimeError, MemoryError, LookupError) as failure:
        # One point must not end a sweep of thousands; what went wrong stands in its row, and nothing is taken for an answer.
        answer |= {"status": "failed", "reason": f"{type(failure).__name__}: {failure}"}
    return answer | {"seconds": time.perf_counter() - begun, "host": platform.node()}


def _question(job: Mapping[str, Any]) -> Question:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

    scene = Scene.model_validate_json(json.dumps(job["scene"]))
    return Question(scene, MeshSettings(**job["mesh"]), SolverSettings(**job["solver"]))


def _solve(asked: Asked, question: Question) -> dict[str, Any]:
    if "fe" not in asked.engines:
        exact = exact_alone(asked, question.scene)
        figures = take(asked.figures, None, exact)
        return _finished(dict(figures.values), dict(figures.notes), _record(exact))
    fe, notes = finite_elements(asked, question)
    found = evaluate(asked, question.scene, fe)
    values = dict(found.values)
    notes |= found.notes
    if asked.uncertainty == "cheap":
        values |= cheap_uncertainty(asked, question, fe, found, notes)
    if asked.uncertainty == "budget":
        values |= budget(question, fe, values, notes)
    record = _record(fe)
    return _finished(values, notes, record | {"notes": [*record["notes"], *found.of_theory]})


def _finished(values: Values, notes: dict[str, str], record: dict[str, Any]) -> dict[str, Any]:
    """Figures with no NaN among them: what is not finite is no value, and says so."""
    clean: Values = {}
    for name, value in values.items():
        finite = value is not None and math.isfinite(value)
        clean[name] = float(value) if finite and value is not None else None
        if not finite and value is not None:
            notes.setdefault(name, f"the value is {value}")
    return {"figures": clean, "notes": notes, "record": record}


def _record(solution: ContactSolution | None) -> dict[str, Any]:
    """How an answer came about, in few words."""
    if solution is None:
        return {}
    return {
        "converged": solution.record.converged,
        "message": solution.record.message,
        "notes": list(solution.record.notes),
        "steps": len(solution.time),
        "points": len(solution.x),
        "time": float(solution.time[-1]),
        "steady_from": solution.steady_from,
        "counts": {name: int(count) for name, count in solution.work.counts.items()},
        "seconds": {name: float(seconds) for name, seconds in solution.work.seconds.items()},
        "worst": {name: _largest(values) for name, values in solution.record.certificates.items()},
    }


def _largest(values: Any) -> float | None:
    found = float(max(values, default=0.0))
    return found if math.isfinite(found) else None
