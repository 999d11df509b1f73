"""Series and grids of an answer from the memory curves of its instants; whatever was not asked for is NaN and takes no room."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, NotFoundError
from semi_analytic.contact import Contact
from semi_analytic.fields import Integrals
from semi_analytic.snapshot import Snapshot

Array = NDArray[np.float64]


class Asked(Protocol):
    """What is to be evaluated: (n,) instants, (k,) different |x| and (m,) where each point finds its own, and the fields."""

    @property
    def contact(self) -> Contact: ...
    @property
    def modulus(self) -> float: ...
    @property
    def time(self) -> Array: ...
    @property
    def distance(self) -> Array: ...
    @property
    def fold(self) -> NDArray[np.int64]: ...
    @property
    def fields(self) -> frozenset[str]: ...


def series_of(asked: Asked, snapshot: Snapshot) -> dict[str, Array]:
    """Loads, half-widths, edges and rigid movements: (n,) or (n, 2); NotFoundError where no half-width was found for a load."""
    contact, fields = asked.contact, asked.fields
    factor, nothing = 2 / (math.pi * asked.modulus), np.full(len(asked.time), np.nan)
    front = snapshot.load - snapshot.slipped
    half = _half_width(contact, snapshot.load)
    slid = np.flatnonzero(snapshot.slipped)
    stick = half.copy()
    stick[slid] = _half_width(contact, front[slid])
    stick[(front <= 0) & (stick == 0)] = np.nan
    shift = Integrals(contact, np.zeros(1), "shift").over(snapshot)[:, 0] if "rigid_shift" in fields else nothing
    return {
        "normal_load": snapshot.load,
        "tangential_load": snapshot.force,
        "rigid_shift": factor * shift,
        "rigid_approach": factor * contact.log_distance(snapshot.load) if "rigid_approach" in fields else nothing,
        "contact_half_width": half,
        "stick_half_width": stick,
        "contact_edges": half[:, None] * np.array([-1.0, 1.0]),
        "stick_edges": stick[:, None] * np.array([-1.0, 1.0]),
    }


def _half_width(contact: Contact, load: Array) -> Array:
    """a(P), (n,): an inverse that was not found, NaN, must not go on as an answer."""
    half = contact.half_width(load)
    lost = np.flatnonzero(~np.isfinite(half))
    if len(lost):
        raise NotFoundError(f"no half-width was found for the normal load {float(load[lost[0]]):.17g}")
    return half


def grids_of(asked: Asked, snapshot: Snapshot, half: Array, stick: Array) -> dict[str, NDArray[Any]]:
    """pressure, shear, slip, state: (n, m), read-only; `half` and `stick` are the half-widths (n,) there.

    NotFoundError where a value that is due was not found.
    """
    contact, x = asked.contact, asked.distance
    shape = (len(asked.time), len(asked.fold))
    grids: dict[str, NDArray[Any]] = {name: np.broadcast_to(np.nan, shape) for name in ("pressure", "shear", "slip")}
    grids["state"] = np.broadcast_to(np.int8(OPEN), shape)
    found: dict[str, NDArray[Any]] = {}
    if "pressure" in asked.fields:
        found["pressure"] = contact.pressure(x, snapshot.load[:, None])
    if "shear" in asked.fields:
        found["shear"] = Integrals(contact, x, "shear").over(snapshot)
    if "slip" in asked.fields:
        found["slip"] = 2 / (math.pi * asked.modulus) * Integrals(contact, x, "slip").over(snapshot)
    if "state" in asked.fields:
        found["state"] = _states(x, snapshot, half, stick)
    for name, values in found.items():
        _check(name, values, asked)
        grid = values.take(asked.fold, axis=1)
        grid.flags.writeable = False
        grids[name] = grid
    return grids


def _check(name: str, values: NDArray[Any], asked: Asked) -> None:
    """A field that was not found, NaN, must not go on as an answer; tractions are infinite at the tip of a sharp wedge."""
    due = np.isfinite(values)
    if name in ("pressure", "shear"):
        due |= np.isinf(values) & (asked.distance == 0)
    if not np.all(due):
        instant, point = (int(each[0]) for each in np.nonzero(~due))
        raise NotFoundError(f"no {name} was found at |x| = {asked.distance[point]:.17g}, time {asked.time[instant]:.17g}")


def _states(x: Array, snapshot: Snapshot, half: Array, stick: Array) -> NDArray[np.int8]:
    names = (SLIP_REVERSE, STICK, SLIP_FORWARD)
    sliding = np.array(names, dtype=np.int8)[snapshot.direction + 1][:, None]
    inner = np.where(x > np.nan_to_num(stick)[:, None], sliding, np.int8(STICK))
    return np.where((x <= half[:, None]) & (snapshot.load[:, None] > 0), inner, np.int8(OPEN))
