"""Linear elastic, isotropic materials."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, model_validator

from scenes.frozen import Frozen

Positive = Annotated[float, Field(gt=0)]


class Elastic(Frozen):
    """One isotropic linear elastic material in plane strain.

    >>> Elastic(young_modulus=210e3, poisson_ratio=0.3).poisson_ratio
    0.3
    """

    young_modulus: Positive = Field(description="Young's modulus, stress units (library: MPa)")
    poisson_ratio: float = Field(gt=-1, lt=0.5, description="Poisson's ratio, in (-1, 0.5)")


class Materials(Frozen):
    """The materials of the two bodies; one table without `upper` and `lower` stands for both.

    >>> Materials.model_validate({"young_modulus": 70e3, "poisson_ratio": 0.33}).alike
    True
    """

    upper: Elastic
    lower: Elastic

    @model_validator(mode="before")
    @classmethod
    def _one_for_both(cls, data: Any) -> Any:
        if isinstance(data, dict) and not {"upper", "lower"} & data.keys():
            return {"upper": data, "lower": data}
        return data

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """As for every table; keys of a material without `upper` and `lower` change both bodies."""
        return super().merged(changes if {"upper", "lower"} & changes.keys() else {"upper": changes, "lower": changes})

    @property
    def alike(self) -> bool:
        """Whether both bodies are of one material."""
        return self.upper == self.lower
