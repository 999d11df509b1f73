"""What is asked of the half-plane engine: points, instants and fields, checked at the door, as one frozen value."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenes import InputError
from scenes.errors import present_name
from semi_analytic.bulk_and_tilt import OneCurve
from semi_analytic.profiles import Contact

Array = NDArray[np.float64]
Cycles = Literal["all", "steady"]

FIELDS = ("pressure", "shear", "slip", "state", "tangential_displacement", "normal_approach", "dissipation_density", "dissipation")
"""The fields that can be asked for one by one."""
POINTWISE = frozenset(("pressure", "shear", "slip", "state"))
"""Those that have a value at each point and instant."""

_POINTS = 200


@dataclass(frozen=True, eq=False)
class Request:
    """What is to be evaluated.

    Attributes
    ----------
    contact, modulus : normal contact, E*
    time : (n,) instants as asked for
    x : (m,) points as asked for
    distance, fold : (k,) different |x|, (m,) where each x finds its own; different x of an unsymmetric contact
    fields : what is wanted
    family : the path with bulk stress and tilt; None without
    """

    contact: Contact
    modulus: float
    time: Array
    x: Array
    distance: Array
    fold: NDArray[np.int64]
    fields: frozenset[str]
    family: OneCurve | None = None


def checked(fields: str | Iterable[str], cycles: Cycles) -> frozenset[str]:
    """The fields that are asked for; InputError for one that is not among `FIELDS`, or for other `cycles` than there are."""
    if cycles not in ("all", "steady"):
        raise InputError(f"cycles: {cycles!r} is neither 'all' nor 'steady'")
    wanted = frozenset(present_name(name) for name in ([fields] if isinstance(fields, str) else fields))
    unknown = sorted(wanted - set(FIELDS))
    if unknown:
        raise InputError(f"fields: {unknown[0]!r} is not among {', '.join(FIELDS)}")
    return wanted


def vector(values: ArrayLike | None, name: str) -> Array | None:
    """Finite numbers (n,), one alone too, None where none are given; InputError with their `name` for anything else."""
    if values is None:
        return None
    array = np.atleast_1d(np.array(values, dtype=float))
    if array.ndim != 1 or not len(array) or not np.all(np.isfinite(array)):
        raise InputError(f"{name}: a list of finite numbers is needed, not an array of shape {array.shape}")
    return array


def folded(x: Array) -> tuple[Array, NDArray[np.int64]]:
    """Different |x| (k,), ascending, and where each point (m,) finds its own; sides that differ by a last digit are one.

    >>> folded(np.array([-1.0, 0.0, 1.0 + 2.3e-16]))
    (array([0., 1.]), array([1, 0, 1]))
    """
    size, back = np.unique(np.abs(x), return_inverse=True)
    new = np.diff(size, prepend=-np.inf) > 2 * np.finfo(float).eps * size[-1]
    return size[new], (np.cumsum(new) - 1)[back]


def mirrored_points(edge: float) -> Array:
    """Points from -edge to edge, mirrored to the last digit."""
    right = np.linspace(edge / (_POINTS - 1), edge, _POINTS // 2)
    return np.concatenate([-right[::-1], right])
