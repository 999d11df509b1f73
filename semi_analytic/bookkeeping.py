"""What a solution says of itself: certificates, notes, work done and not done, versions."""

from __future__ import annotations

import platform
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from scenes import Materials, Record, Scene, Work, freeze
from semi_analytic.elasticity import coupling_constant
from semi_analytic.history import Span
from semi_analytic.memory import pieces, value_on
from semi_analytic.proofs import certificates, ending
from semi_analytic.quadrature import NODES
from semi_analytic.question import FIELDS, Question
from semi_analytic.snapshot import Snapshot

Array = NDArray[np.float64]

_DOUBTFUL = 1e-9
_SINGLE = ("dissipation", "loop_work")


@dataclass(frozen=True, eq=False)
class Dissipations:
    """Friction work of the cycles, the last one by a second route too, and how many quadratures it took.

    `doubts` are the estimated errors of those quadratures that settle by themselves: of W over W, of W(x) over the largest; and
    that of the second route.
    """

    last: float
    second_route: float
    arrays: Mapping[str, Array]
    slip_spans: int
    stick_spans: int
    doubts: Mapping[str, float]


def record_of(
    scene: Scene, question: Question, snapshot: Snapshot, arrays: Mapping[str, NDArray[Any]], errors: Mapping[str, float]
) -> Record:
    """How the answer came about: M(P) = Q and the friction cone at every instant, the end of the path, what a reader must know."""
    history, friction = question.route.history, question.friction
    followed, cycles = "the path was followed to its end", len(history.cycles)
    termination, message = ending(followed, question.route.period, history.steady_from, cycles)
    return Record(
        converged=True,
        termination=termination,
        message=message,
        iterations=freeze(np.zeros(len(question.time)), np.int64),
        certificates=certificates(friction, snapshot.load, _mismatch(snapshot), arrays, question.fields),
        notes=tuple(_notes(scene, question, errors)),
        errors=errors,
    )


def _mismatch(snapshot: Snapshot) -> Array:
    """M(P) - Q, (n,): what the pieces carry less what is applied."""
    held = snapshot.direction * snapshot.friction * snapshot.slipped
    for piece, here in snapshot.groups():
        held[here] += value_on(piece, (snapshot.load - snapshot.slipped)[here])
    return held - snapshot.force


def _notes(scene: Scene, question: Question, errors: Mapping[str, float]) -> Iterator[str]:
    yield from neglected_coupling(scene.material)
    steady = question.route.history.steady_from
    unsteady = steady is None or question.route.covered[-1] < steady
    if unsteady and "dissipation" in question.fields and question.route.period is not None:
        yield "the last cycle is not steady: no closed integral of Q dU to compare the dissipation with"
    for name, error in errors.items():
        if error > _DOUBTFUL and "edge" not in name:
            size = "it" if name in _SINGLE else "the largest value"
            yield f"{name}: quadratures and rounding may have left an error of {error:.1e} of {size}"


def neglected_coupling(material: Materials) -> Iterator[str]:
    """A sentence where the materials couple normal and shear tractions, which half-plane theory here leaves out."""
    beta = coupling_constant(material)
    if beta != 0:
        yield f"Dundurs' beta = {beta:.6g}: the bodies are unlike, and the coupling of normal and shear tractions is neglected"


def work_of(scene: Scene, question: Question, work_done: Dissipations, seconds: Mapping[str, float]) -> Work:
    """What was done and what was not."""
    history = question.route.history
    alive = max(_depths(history.spans))
    copies = max(scene.cycles, len(question.route.covered)) - len(history.cycles)
    skipped = not_evaluated(question.fields, len(question.time), None if question.route.straight else history.steady_from, copies)
    if work_done.stick_spans:
        skipped["quadratures"] = (work_done.stick_spans, "full stick: nothing slips")
    counts = {
        "instants": len(question.time),
        "points": len(question.x),
        "points_evaluated": len(question.distance),
        "spans": len(history.spans),
        "cycles_solved": len(history.cycles),
        "pieces_alive": alive,
        "slip_quadratures": work_done.slip_spans,
        "quadrature_nodes": work_done.slip_spans * NODES,
    }
    return Work(counts, skipped, dict(seconds))


def not_evaluated(fields: Collection[str], instants: int, steady_from: int | None, copies: int) -> dict[str, tuple[int, str]]:
    """What was skipped, with count and reason: fields that nobody asked for, cycles that are `copies` of a steady one."""
    skipped = {name: (instants, "not asked for") for name in FIELDS if name not in fields}
    if steady_from is not None and copies > 0:
        skipped["cycles"] = (copies, f"copies of cycle {steady_from + 1}, which is steady")
    return skipped


def _depths(spans: Iterable[Span]) -> Iterator[int]:
    """Number of pieces of each span's curve."""
    known: dict[int, int] = {}
    for span in spans:
        chain, depth = [], 0
        for piece in pieces(span.active):
            depth = known.get(id(piece), 0)
            if depth:
                break
            chain.append(piece)
        for piece in reversed(chain):
            depth += 1
            known[id(piece)] = depth
        yield depth


def versions() -> dict[str, str]:
    """Versions of what the numbers depend on."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "halfplane": _version_of("halfplane"),
    }


def _version_of(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
