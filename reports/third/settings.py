"""How a deck is cut, stepped and how stiff its contact is: what an established code is handed, never what is true."""

from __future__ import annotations

from dataclasses import dataclass

from scenes import InputError


@dataclass(frozen=True)
class DeckSettings:
    """Lengths over the contact half-width a at the largest load; stiffnesses over E*/h, h being the surface elements at the edges.

    Attributes
    ----------
    element_size, edge_element_size : surface elements in the middle, and where the contact and stick edges travel
    far_radius : radius of the half-disc, held along its arc, that stands for a half-plane; the tractions miss those of the
        half-plane by about the square of its inverse
    growth : growth of the elements away from the contact
    steps_per_cycle : output instants of a revolution; its turning points come on top
    cycles : revolutions at most; the scene's own number where that is less
    normal_stiffness : pressure per penetration
    stick_stiffness : shear per elastic slip, where friction would let the faces stick
    """

    element_size: float = 1 / 20
    edge_element_size: float = 1 / 40
    far_radius: float = 50.0
    growth: float = 0.4
    steps_per_cycle: int = 48
    cycles: int = 2
    normal_stiffness: float = 50.0
    stick_stiffness: float = 10.0

    def __post_init__(self) -> None:
        if not 4 <= self.steps_per_cycle <= 10_000:
            raise InputError(f"--steps-per-cycle {self.steps_per_cycle}: refused for a deck, it lies in [4, 10000]")
        if self.cycles < 1:
            raise InputError(f"--cycles {self.cycles}: refused for a deck, it is at least 1")
        for name in ("normal_stiffness", "stick_stiffness"):
            if not getattr(self, name) > 0:
                raise InputError(f"deck: {name} = {getattr(self, name)!r} is refused: it is positive, over E*/h")
