"""Options of the finite-element engine on the command line.

Those left out keep the engine's own defaults, which are stated there and nowhere else.
"""

from __future__ import annotations

import shlex
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

_MESH = Group("Mesh (lengths over the contact half-width; what is left out is the engine's own)", sort_key=2)
_SOLVER = Group("Solver (what is left out is the engine's own)", sort_key=3)


def _option(group: Group, text: str) -> Parameter:
    return Parameter(group=group, help=text)


_LAYER = _option(_SOLVER, "Of the penalty layer, over E*/h; without one no answer depends on it.")


@Parameter(name="*")
@dataclass(frozen=True)
class FiniteElementOptions:
    """How the finite-element side is cut and iterated; None leaves the engine's default."""

    element_size: Annotated[float | None, _option(_MESH, "Surface elements where the tractions are smooth.")] = None
    edge_element_size: Annotated[float | None, _option(_MESH, "Surface elements where the contact and stick edges travel.")] = None
    far_radius: Annotated[float | None, _option(_MESH, "Radius of the half-disc that stands for a half-plane.")] = None
    growth: Annotated[float | None, _option(_MESH, "Growth of the elements away from the contact.")] = None
    order: Annotated[int | None, _option(_MESH, "Order of the elements, 1 or 2.")] = None
    method: Annotated[
        Literal["augmented_lagrangian", "penalty"] | None,
        _option(_SOLVER, "The contact law met exactly, or an elastic layer between the faces."),
    ] = None
    steps_per_cycle: Annotated[int | None, _option(_SOLVER, "Steps of a revolution; turning points come on top.")] = None
    normal_stiffness: Annotated[float | None, _LAYER] = None
    tangential_stiffness: Annotated[float | None, _LAYER] = None
    max_iterations: Annotated[int | None, _option(_SOLVER, "Of one step, before it counts as not converged.")] = None

    def settings(self) -> tuple[MeshSettings, SolverSettings]:
        """The settings objects; InputError for a value out of range."""
        from halfplane_fe import SolverSettings
        from meshes import MeshSettings

        given = self._given()
        mesh = {name: given[name] for name in given if name in MeshSettings.__dataclass_fields__}
        solver = {name: given[name] for name in given if name in SolverSettings.__dataclass_fields__}
        return MeshSettings(**mesh), SolverSettings(**solver)

    def command(self, name: str, source: str, out: Path, *more: tuple[str, ...]) -> str:
        """The command line that does `name` to `source` with these options and `more`.

        >>> FiniteElementOptions(order=1).command("run", "hertz-paper", Path("out/first"))
        'halfplane run hertz-paper --order 1 --out out/first'
        """
        words = ["halfplane", name, source]
        for option, value in self._given().items():
            words += [f"--{option.replace('_', '-')}", str(value)]
        return shlex.join([*words, "--out", str(out), *(word for words in more for word in words)])

    def _given(self) -> dict[str, Any]:
        return {name: value for name, value in asdict(self).items() if value is not None}
