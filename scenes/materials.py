"""Linear elastic, isotropic materials."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

FROZEN = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

Positive = Annotated[float, Field(gt=0)]


class Elastic(BaseModel):
    """One isotropic linear elastic material in plane strain.

    >>> Elastic(young_modulus=210e3, poisson_ratio=0.3).poisson_ratio
    0.3
    """

    model_config = FROZEN

    young_modulus: Positive = Field(description="Young's modulus, stress units (library: MPa)")
    poisson_ratio: float = Field(gt=-1, lt=0.5, description="Poisson's ratio, in (-1, 0.5)")


class Materials(BaseModel):
    """The materials of the two bodies; one table without `upper` and `lower` stands for both.

    >>> Materials.model_validate({"young_modulus": 70e3, "poisson_ratio": 0.33}).alike
    True
    """

    model_config = FROZEN

    upper: Elastic
    lower: Elastic

    @model_validator(mode="before")
    @classmethod
    def _one_for_both(cls, data: Any) -> Any:
        if isinstance(data, dict) and not {"upper", "lower"} & data.keys():
            return {"upper": data, "lower": data}
        return data

    @property
    def alike(self) -> bool:
        """Whether both bodies are of one material."""
        return self.upper == self.lower
