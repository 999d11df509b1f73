"""Least-recently-used cache of condensed bodies in this process, bounded in bytes.

A body is known by what `condense` reads of it: nodes, elements, boundaries, supports and grading of
the mesh, the material and the datum length. Loads and friction are no part of it, so a study of
them condenses each body once in each worker. `work` of the answer counts both, condensations and
bodies taken from the cache.
"""

from __future__ import annotations

import hashlib
from collections import Counter, OrderedDict
from dataclasses import fields
from threading import Lock
from typing import Any

import numpy as np

from halfplane_fe.elasticity import CondensedBody, condense
from meshes import BodyMesh
from scenes import Elastic

# Name in the counts of work of a body that was condensed before in this process.
CACHED = "condensations from the cache"


class CondensedBodies:
    """The bodies condensed last in this process.

    Attributes
    ----------
    bound_bytes
        of the arrays that are cached; 0 caches nothing
    """

    def __init__(self, bound_bytes: int) -> None:
        self.bound_bytes = bound_bytes
        # fields of each body but for its mesh, least recently used first
        self._cached: OrderedDict[bytes, dict[str, Any]] = OrderedDict()
        self._lock = Lock()

    @property
    def nbytes(self) -> int:
        """Bytes of the cached arrays."""
        return sum(_nbytes(values) for values in self._cached.values())

    def condensed_body(
        self, body: BodyMesh, material: Elastic, datum_length: float, work_counts: Counter[str]
    ) -> CondensedBody:
        """Compliance of a meshed body at the nodes of its contact face, by static condensation;
        taken from this process's cache where the same body was condensed before.

        Parameters
        ----------
        body, material
            mesh with its supports, and elastic constants
        datum_length
            distance from a force at which a half-plane's surface counts as unmoved [length]
        work_counts
            counters of the solution, raised here: by a body from the cache, or by the condensations
            and factorisations that were needed

        Returns
        -------
        CondensedBody
            With the very mesh of `body`; its arrays may be shared with other solutions.
        """
        # hash of everything that the compliance depends on
        key = _digest(body, material, datum_length)
        with self._lock:
            cached_fields = self._cached.get(key)
            if cached_fields is not None:
                self._cached.move_to_end(key)
        if cached_fields is not None:
            # CACHED: name of the count of bodies taken from the cache
            work_counts[CACHED] += 1
            return CondensedBody(body=body, **cached_fields)

        condensed_body = condense(body, material, datum_length)
        work_counts["condensations"] += 1
        work_counts["sparse factorisations"] += int(
            condensed_body.diagnostics["sparse_factorisations"]
        )
        # Without the mesh, which is larger than what was made of it.
        stored_names = [field.name for field in fields(condensed_body) if field.name != "body"]
        self._add(key, {name: getattr(condensed_body, name) for name in stored_names})
        return condensed_body

    def _add(self, key: bytes, values: dict[str, Any]) -> None:
        """Cache the fields of a body under its hash `key`; those that were used least recently
        leave the cache, so that its arrays take at most `bound_bytes`.
        """
        if _nbytes(values) > self.bound_bytes:
            return
        with self._lock:
            self._cached[key] = values
            while self.nbytes > self.bound_bytes:
                self._cached.popitem(last=False)


def _nbytes(values: dict[str, Any]) -> int:
    """Bytes of all arrays among the values of a dictionary."""
    return sum(value.nbytes for value in values.values() if isinstance(value, np.ndarray))


def _digest(body: BodyMesh, material: Elastic, datum_length: float) -> bytes:
    """SHA-256 hash of a body by which a cache finds its condensed compliance: of its mesh, element
    sizes, supports, elastic constants and `datum_length`.

    A body that differs in any bit of these has another hash. The datum length is the distance from
    a force at which a half-plane's surface counts as unmoved [length]. `doflocs` and `t` of the
    mesh are places of its nodes and node numbers of its elements.
    """
    mesh = body.mesh
    settings = [
        type(mesh).__name__,
        body.grading,
        sorted(body.supports.items()),
        material,
        float(datum_length),
    ]
    arrays = {"nodes": mesh.doflocs, "elements": mesh.t}
    arrays |= {f"boundary {name}": facets for name, facets in mesh.boundaries.items()}
    hasher = hashlib.sha256(repr(settings).encode())
    for name, array in sorted(arrays.items()):
        hasher.update(repr((name, array.dtype.str, array.shape)).encode())
        hasher.update(np.ascontiguousarray(array).tobytes())
    return hasher.digest()


# 300 MB hold some two hundred bodies of the default mesh (1.5 MB each), or two of 2,000 contact
# nodes.
BODY_CACHE = CondensedBodies(bound_bytes=300_000_000)
