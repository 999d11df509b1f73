"""What is asked: points, instants and fields, checked at the door, with the history that they need already followed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError, Scene
from semi_analytic.contact import Contact, contact_of
from semi_analytic.elasticity import composite_modulus
from semi_analytic.route import Cycles, Route, default_times, locate, own_route, straight_route
from semi_analytic.snapshot import Snapshot, take

Array = NDArray[np.float64]

FIELDS = ("pressure", "shear", "slip", "state", "rigid_shift", "rigid_approach", "dissipation_density", "dissipation")
"""The fields that can be asked for one by one."""

_POINTS = 200


@dataclass(frozen=True, eq=False)
class Question:
    """What is to be evaluated: instants sorted into spans, points folded onto x >= 0.

    Attributes
    ----------
    contact, modulus, friction : normal contact, E*, f
    route : the solved history
    time : (n,) instants as asked for
    span, local : (n,) number of the span, time of its leg
    x : (m,) points as asked for
    distance, fold : (k,) different |x|, (m,) where each x finds its own
    fields : what is wanted
    """

    contact: Contact
    modulus: float
    friction: float
    route: Route
    time: Array
    span: NDArray[np.int64]
    local: Array
    x: Array
    distance: Array
    fold: NDArray[np.int64]
    fields: frozenset[str]

    def snapshot(self) -> Snapshot:
        """The memory curves at the instants, in their order."""
        order = np.argsort(self.span, kind="stable")
        numbers, starts = np.unique(self.span[order], return_index=True)
        spans = self.route.history.spans
        sorted_times = np.split(self.local[order], starts[1:])
        taken = take((spans[number], times) for number, times in zip(numbers, sorted_times, strict=True))
        back = np.argsort(order)
        columns = ("time", "load", "force", "slipped", "direction", "which")
        return replace(taken, **{name: getattr(taken, name)[back] for name in columns})


def checked(fields: Iterable[str]) -> frozenset[str]:
    """The names that are asked for; InputError for one that is not among `FIELDS`."""
    wanted = frozenset(fields)
    unknown = sorted(wanted - set(FIELDS))
    if unknown:
        raise InputError(f"fields: {unknown[0]!r} is not among {', '.join(FIELDS)}")
    return wanted


def arrays_of(x: ArrayLike | None, time: ArrayLike | None, cycles: Cycles) -> tuple[Array | None, Array | None]:
    """Points and instants as arrays (m,) and (n,), None where not given; InputError for anything else."""
    if cycles not in ("all", "steady"):
        raise InputError(f"cycles: {cycles!r} is neither 'all' nor 'steady'")
    return (None if x is None else vector(x, "x")), (None if time is None else vector(time, "time"))


def ask(
    scene: Scene, x: ArrayLike | None, time: ArrayLike | None, cycles: Cycles, fields: Iterable[str], straight: bool
) -> Question:
    """The question with its history solved; everything but the evaluation.

    Raises
    ------
    InputError, InadmissibleLoadError
    """
    wanted = checked(fields)
    given, asked = arrays_of(x, time, cycles)
    if straight and asked is None:
        raise InputError("straight_steps: give the times between which the steps are straight")
    contact, path, friction = contact_of(scene.profile, scene.material), scene.load.path(), scene.friction.coefficient
    if straight and asked is not None:
        route = straight_route(path, friction, asked)
    else:
        route = own_route(path, friction, scene.cycles, asked)
    if cycles == "steady" and asked is None:
        route = replace(route, covered=route.covered[-1:])
    instants = default_times(route, cycles) if asked is None else asked
    span, local = locate(route, instants)
    largest = max(max(s.begin.normal, s.end.normal) for s in route.history.spans)
    edge = 1.05 * float(contact.half_width(largest))
    points = spread(edge) if given is None else given
    distance, fold = folded(points)
    modulus = composite_modulus(scene.material)
    return Question(contact, modulus, friction, route, instants, span, local, points, distance, fold, wanted)


def folded(x: Array) -> tuple[Array, NDArray[np.int64]]:
    """Different |x| (k,), ascending, and where each point (m,) finds its own; sides that differ by a last digit are one.

    >>> folded(np.array([-1.0, 0.0, 1.0 + 2.3e-16]))
    (array([0., 1.]), array([1, 0, 1]))
    """
    size, back = np.unique(np.abs(x), return_inverse=True)
    new = np.diff(size, prepend=-np.inf) > 2 * np.finfo(float).eps * size[-1]
    return size[new], (np.cumsum(new) - 1)[back]


def spread(edge: float) -> Array:
    """Points from -edge to edge, mirrored to the last digit."""
    right = np.linspace(edge / (_POINTS - 1), edge, _POINTS // 2)
    return np.concatenate([-right[::-1], right])


def vector(values: ArrayLike, name: str) -> Array:
    """Finite numbers (n,); InputError with their `name` for anything else."""
    array = np.array(values, dtype=float)
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: a list of finite numbers is needed, not an array of shape {array.shape}")
    return array
