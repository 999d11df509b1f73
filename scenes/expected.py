"""Numbers that a scene expects, each with the engine that must meet it and the source that says so."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from scenes.frozen import Frozen
from scenes.materials import Positive

Quantity = Literal[
    "dissipation",
    "loop_work",
    "largest_half_width",
    "least_half_width",
    "largest_pressure",
    "permanent_stick_half_width",
    "stick_share",
    "lower_face_displacement",
]


class Expected(Frozen):
    """One number with its tolerance and its source.

    >>> Expected(quantity="dissipation", value=0.0, tolerance=1e-9, source="nothing slips").engine
    'half-plane theory'
    """

    quantity: Quantity = Field(
        description="of the last cycle (the whole path where nothing repeats): dissipation, loop_work (closed integral of Q dU), "
        "largest_half_width, least_half_width of the contact, largest_pressure, permanent_stick_half_width, "
        "stick_share (the latter over largest_half_width), lower_face_displacement (along y, of the lower face's middle at the "
        "largest load: finite elements of a real body)"
    )
    value: float = Field(description="in the scene's units; energies and loads per unit thickness")
    tolerance: Positive = Field(
        description="largest difference over the value; where the value is 0, over A f^2 P^2 (energies; f = 1 if frictionless, "
        "P the largest load), the largest half-width or the largest pressure"
    )
    engine: Literal["half-plane theory", "finite elements"] = Field("half-plane theory", description="which must meet it")
    source: str = Field(min_length=1, description="where the number comes from")
