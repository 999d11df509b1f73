"""The mesh of a .frd file with rows in place of node numbers, and where its element faces lie."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reports.scoring.calculix_frd import FrdElement, FrdFile
from reports.scoring.inside_out import inside_out
from scenes import InputError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_Faces = dict[int, tuple[int, ...]]
# Corners (from 0) of the faces of bricks, wedges, tetrahedra, and of plane elements: CalculiX counts their edges as faces 3 to 6.
_BRICK: _Faces = {1: (0, 1, 2, 3), 2: (4, 5, 6, 7), 3: (0, 1, 5, 4), 4: (1, 2, 6, 5), 5: (2, 3, 7, 6), 6: (3, 0, 4, 7)}
_WEDGE: _Faces = {1: (0, 1, 2), 2: (3, 4, 5), 3: (0, 1, 4, 3), 4: (1, 2, 5, 4), 5: (2, 0, 3, 5)}
_TETRAHEDRON: _Faces = {1: (0, 1, 2), 2: (0, 1, 3), 3: (1, 2, 3), 4: (0, 2, 3)}
_QUADRANGLE: _Faces = {3: (0, 1), 4: (1, 2), 5: (2, 3), 6: (3, 0)}
_TRIANGLE: _Faces = {3: (0, 1), 4: (1, 2), 5: (2, 0)}
# By the kinds of the .frd form: linear, quadratic.
_FACES: dict[int, _Faces] = {
    **dict.fromkeys((1, 4), _BRICK),
    **dict.fromkeys((2, 5), _WEDGE),
    **dict.fromkeys((3, 6), _TETRAHEDRON),
    **dict.fromkeys((7, 8), _TRIANGLE),
    **dict.fromkeys((9, 10), _QUADRANGLE),
}
_SHAPES: dict[int, str] = {
    **dict.fromkeys((1, 4), "hexahedron"),
    **dict.fromkeys((2, 5), "wedge"),
    **dict.fromkeys((3, 6), "tetra"),
    **dict.fromkeys((7, 8), "triangle"),
    **dict.fromkeys((9, 10), "quad"),
}


@dataclass(frozen=True, eq=False)
class CalculixMesh:
    """Nodes and elements of a .frd file.

    Attributes
    ----------
    path : where it was read
    numbers : (n_nodes,), of the nodes, ascending
    points : (n_nodes, 3) [length]
    cells : rows of nodes of the elements, (n_elements, n_nodes_each), a block for each kind
    kinds : of the blocks, as meshio calls their shape; "" for one without faces
    elements : by number
    """

    path: Path
    numbers: Integers
    points: Array
    cells: tuple[Integers, ...]
    kinds: tuple[str, ...]
    elements: dict[int, FrdElement]

    @classmethod
    def of(cls, file: FrdFile) -> CalculixMesh:
        """The mesh of a file; InputError for an element with a node that is not there."""
        order = np.argsort(file.nodes)
        bare = cls(file.path, file.nodes[order], file.points[order], (), (), {element.number: element for element in file.elements})
        alike: dict[tuple[int, str], list[tuple[int, ...]]] = {}
        for element in file.elements:
            alike.setdefault((len(element.nodes), _SHAPES.get(element.kind, "")), []).append(element.nodes)
        cells = tuple(bare.rows(np.array(alike[key], np.int64)) for key in sorted(alike))
        return replace(bare, cells=cells, kinds=tuple(shape for _, shape in sorted(alike)))

    def rows(self, nodes: Integers) -> Integers:
        """Rows of node numbers of any shape; InputError for a node without coordinates."""
        at = np.minimum(np.searchsorted(self.numbers, nodes), len(self.numbers) - 1)
        strange = np.asarray(nodes)[self.numbers[at] != nodes]
        if len(strange):
            raise InputError(
                f"{self.path}: node {strange[0]} has a result or an element and no coordinates (CalculiX numbers the nodes of "
                "plane elements anew); write *NODE FILE, OUTPUT=3D in the deck and run it again"
            )
        return np.asarray(at, np.int64)

    def inside_out(self) -> list[str]:
        """A sentence where elements are turned inside out."""
        return inside_out(self.points, zip(self.kinds, self.cells, strict=True))

    def face(self, element: int, face: int) -> tuple[Array, float, float]:
        """Middle of an element's face (3,), its length in x, and how far the element's middle lies above it [length]."""
        found = self.elements.get(element)
        corners = _FACES.get(found.kind, {}).get(face) if found else None
        if found is None or corners is None:
            what = (
                f"element {element} is not in it" if found is None else f"element {element} of kind {found.kind} has no face {face}"
            )
            raise InputError(f"{self.path}: {what}; it must be of the same run as the .dat file, with *NODE FILE and *EL FILE")
        rows = self.rows(np.array(found.nodes))
        on_face = self.points[rows[list(corners)]]
        return on_face.mean(axis=0), float(np.ptp(on_face[:, 0])), float(self.points[rows, 1].mean() - on_face[:, 1].mean())
