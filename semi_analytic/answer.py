"""What is asked of half-plane theory, a `Question`, and what a method finds for it, `Findings`:
loads and fields at instants, friction work of the cycles, and the record. Also the one place that
makes a ContactSolution of these.

The methods for half-planes: `answer_by_memory`, `answer_in_phase`, `answer_on_grids`.
"""

from __future__ import annotations

import math
import platform
import time as clock
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import metadata
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import (
    BodyEffects,
    ContactSolution,
    InputError,
    Materials,
    NotFoundError,
    Record,
    Scene,
    Work,
    read_only_copy,
)
from scenes.array_types import Array
from scenes.arrays import LARGEST_NUMBER, real_numbers
from semi_analytic.elasticity import coupling_constant

Cycles = Literal["all", "steady"]

FIELDS = (
    "pressure",
    "shear",
    "slip",
    "state",
    "tangential_displacement",
    "normal_approach",
    "dissipation_density",
    "dissipation",
    "loop_work",
)
"""The fields that can be asked for one by one; `loop_work` comes with `dissipation`."""
POINTWISE = frozenset(("pressure", "shear", "slip", "state"))
"""Those that have a value at each point and instant."""
STEADY_FIELDS = frozenset(
    ("pressure", "state", "normal_approach", "dissipation", "loop_work", "dissipation_density")
)
"""Those that are the same in the steady cycle however it was reached; traction and slip that stay
locked in are not.
"""

_N_MIRRORED_POINTS = 200


# ------------------------------------------------------------------------------------ the question
@dataclass(frozen=True, eq=False)
class Question:
    """What is asked of half-plane theory; the arguments of `solve`, checked.

    Attributes
    ----------
    scene
        the scene
    fields
        the fields that are wanted
    x, time
        (m,) points and (n,) instants as asked for; None: theory chooses
    cycles
        "all" cycles, or the "steady" one alone; no effect where instants are given
    straight_steps
        whether the path is straight from one given instant to the next, in place of the scene's
    effects
        what finite bodies add to half-planes; None: nothing
    """

    scene: Scene
    fields: frozenset[str]
    x: Array | None = None
    time: Array | None = None
    cycles: Cycles = "all"
    straight_steps: bool = False
    effects: BodyEffects | None = None

    def wants(self, *names: str) -> bool:
        """Whether one of these fields is wanted."""
        return not self.fields.isdisjoint(names)

    @property
    def wants_pointwise(self) -> bool:
        """Whether a field at points and instants is wanted."""
        return self.wants(*POINTWISE)

    @property
    def is_default(self) -> bool:
        """Whether the scene is the only thing stated: all fields of all cycles of its own load path
        on half-planes are wanted, at the points and instants that theory chooses.
        """
        return (
            self.fields.issuperset(FIELDS)
            and self.x is None
            and self.time is None
            and self.cycles == "all"
            and not self.straight_steps
            and self.effects is None
        )

    @property
    def wants_last_cycle_alone(self) -> bool:
        """Whether no instants are stated and the steady cycle is enough."""
        return self.time is None and self.cycles == "steady"


def checked_fields(fields: str | Iterable[str], cycles: Cycles) -> frozenset[str]:
    """The names of the fields that a caller of `solve` asks for; InputError for one that does not
    exist, or for other `cycles` than "all" and "steady".

    "loop_work", the closed integral of Q dU, U the relative tangential displacement, brings
    "dissipation", the friction work W, with it.
    """
    if cycles not in ("all", "steady"):
        raise InputError(f"cycles: {cycles!r} is neither 'all' nor 'steady'")
    names = frozenset([fields] if isinstance(fields, str) else fields)
    unknown_names = sorted(names - set(FIELDS))
    if unknown_names:
        raise InputError(f"fields: {unknown_names[0]!r} is not among {', '.join(FIELDS)}")
    # The closed integral is a second route to W, and is compared with it.
    return names | {"dissipation"} if "loop_work" in names else names


def checked_numbers(values: ArrayLike | None, name: str) -> Array | None:
    """A caller's numbers as an array (n,), a single number as (1,); None where none are given.

    InputError, with the `name` of the argument, for an empty list and for more than one dimension;
    also for numbers that are not finite or above `LARGEST_NUMBER`, 1e100.
    """
    if values is None:
        return None
    array = np.atleast_1d(np.array(real_numbers(values, name)))
    if array.ndim != 1 or not len(array):
        raise InputError(
            f"{name}: a list of finite numbers is needed, not an array of shape {array.shape}"
        )
    unusable_numbers = array[~(np.abs(array) <= LARGEST_NUMBER)]
    if len(unusable_numbers):
        raise InputError(
            f"{name}: a list of finite numbers is needed, each at most {LARGEST_NUMBER:g}, and"
            f" {unusable_numbers[0]} is none"
        )
    return array


def mirrored_points(edge: float) -> Array:
    """200 points from -edge to edge, mirrored to the last digit."""
    points_on_right = np.linspace(edge / (_N_MIRRORED_POINTS - 1), edge, _N_MIRRORED_POINTS // 2)
    return np.concatenate([-points_on_right[::-1], points_on_right])


def is_between_edges(edges: Array, x: Array) -> NDArray[np.bool_]:
    """Whether points (k,) are between the left and the right edge of a zone, (n, 2), at each
    instant: (n, k). A zone without edges, NaN, has x = 0 alone.
    """
    left_edge = np.nan_to_num(edges[:, [0]])
    right_edge = np.nan_to_num(edges[:, [1]])
    return (x >= left_edge) & (x <= right_edge)


# ------------------------------------------------------------------------------------- the findings
@dataclass(frozen=True, eq=False)
class Findings:
    """What one of the ways through half-plane theory finds, before it becomes a ContactSolution.

    Attributes
    ----------
    time, x
        (n,) instants, (m,) points
    values
        loads, fields and dissipations by their names in a ContactSolution
    termination, message
        how the path ended
    notes, errors
        sentences for a reader; relative errors by the name of the value
    certificates, energy
        at each instant, by name: checks of the laws of contact, 0 where satisfied; energies, such
        as the friction work since the instant before
    counts, skipped, seconds
        by name: how much was computed; what was left out, with its count and the reason; time that
        each part took
    scene
        the scene with the loads that were found, where the question prescribes displacements;
        None: the scene of the question
    """

    time: Array
    x: Array
    values: Mapping[str, Any]
    termination: str = "end of path"
    message: str = "the path was followed to its end"
    notes: tuple[str, ...] = ()
    errors: Mapping[str, float] = field(default_factory=dict)
    certificates: Mapping[str, Array] = field(default_factory=dict)
    energy: Mapping[str, Array] = field(default_factory=dict)
    counts: Mapping[str, int] = field(default_factory=dict)
    skipped: Mapping[str, tuple[int, str]] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    scene: Scene | None = None


class StopWatch:
    """Seconds of computing that an answer has taken so far, for each of its parts by name."""

    def __init__(self, *names: str) -> None:
        """A stop watch for parts with these names that starts now."""
        self.seconds = dict.fromkeys(names, 0.0)
        self._clock_at_last_lap = clock.perf_counter()

    def add_lap(self, name: str) -> None:
        """Add the seconds since the last lap to those of a part."""
        clock_now = clock.perf_counter()
        self.seconds[name] += clock_now - self._clock_at_last_lap
        self._clock_at_last_lap = clock_now


def solution_of(question: Question, findings: Findings) -> ContactSolution:
    """The solution that `solve` returns, read-only, from what half-plane theory found for a
    question.

    The findings hold instants `time`, points `x`, and loads, fields and dissipations by their names
    in the solution, `values`. `work` of the solution states what was computed. Its `skipped` lists,
    with the reason, fields that were not asked for and what the findings name. The closed integral
    of Q dU, "loop_work", is NaN where it was not asked for. U is the relative tangential
    displacement.
    """
    values_by_name: dict[str, Any] = {"time": findings.time, "x": findings.x} | dict(
        findings.values
    )
    for name, value in values_by_name.items():
        if isinstance(value, np.ndarray) and value.flags.writeable:
            values_by_name[name] = read_only_copy(value, value.dtype)
    errors = dict(findings.errors)
    if not question.wants("loop_work"):
        values_by_name["loop_work"] = math.nan
        errors.pop("loop_work", None)
    return ContactSolution(
        engine="semi_analytic",
        scene=findings.scene or question.scene,
        record=_record_of(findings, errors),
        work=_computing_effort(question, findings),
        settings=_settings_of(question),
        versions=dict(_versions()),
        **values_by_name,
    )


def _record_of(findings: Findings, errors: Mapping[str, float]) -> Record:
    """The record of a solution: how its path ended, with checks, notes, and relative errors by
    name. No instant takes iterations.
    """
    return Record(
        converged=True,
        termination=findings.termination,
        message=findings.message,
        iterations=read_only_copy(np.zeros(len(findings.time)), np.int64),
        certificates=findings.certificates,
        energy=findings.energy,
        notes=findings.notes,
        errors=errors,
    )


def _computing_effort(question: Question, findings: Findings) -> Work:
    """What was computed for a solution, what was skipped and why, and the seconds it took. Fields
    that the question does not want count as skipped at every instant.
    """
    n_instants = len(findings.time)
    skipped_fields = {
        name: (n_instants, "not asked for") for name in FIELDS if name not in question.fields
    }
    return Work(
        {"instants": n_instants, "points": len(findings.x), **findings.counts},
        skipped_fields | dict(findings.skipped),
        findings.seconds,
    )


def _settings_of(question: Question) -> dict[str, Any]:
    """The arguments of a question by name, as a solution states them."""
    settings: dict[str, Any] = {
        "cycles": question.cycles,
        "fields": sorted(question.fields),
        "straight_steps": question.straight_steps,
    }
    if question.effects is not None:
        settings["effects"] = asdict(question.effects)
    return settings


def largest_error(values: ArrayLike) -> float:
    """The largest of some errors >= 0, 0 of none; NotFoundError where one is NaN or infinite."""
    largest_value = float(np.max(np.asarray(values, dtype=float), initial=0.0))
    if not np.isfinite(largest_value):
        raise NotFoundError(
            "an error that is to be estimated is not a number: what it is of cannot be trusted"
        )
    return largest_value


def neglected_coupling(material: Materials) -> Iterator[str]:
    """A sentence where the materials couple normal and shear tractions, which half-plane theory
    here leaves out.
    """
    beta = coupling_constant(material)
    if beta != 0:
        yield (
            f"Dundurs' beta = {beta:.6g}: the bodies are unlike, and the coupling of normal and"
            " shear tractions is neglected"
        )


@cache
def _versions() -> dict[str, str]:
    """Versions of Python and of the packages that the numbers of a solution depend on, by name."""
    try:
        halfplane_version = metadata.version("halfplane")
    except metadata.PackageNotFoundError:
        halfplane_version = "not installed"
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "halfplane": halfplane_version,
    }
