"""Initial gap h(x) between the faces: symmetric, not falling for x > 0. The one verb that both engines share."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, Field

from scenes.materials import FROZEN, Positive


class Hertz(BaseModel):
    """Parabola: h = x^2 / (2 R), R being the relative radius (1/R = 1/R1 + 1/R2).

    >>> float(Hertz(radius=1000.0).height(2.0))
    0.002
    """

    model_config = FROZEN

    kind: Literal["hertz"] = "hertz"
    radius: Positive = Field(description="relative radius of curvature R, length units (library: mm)")

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.radius

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        return np.square(np.asarray(x, dtype=float)) / (2 * self.radius)


class FlatRounded(BaseModel):
    """Flat face |x| < b with parabolic edges: h = (|x| - b)^2 / (2 R) beyond.

    >>> FlatRounded(radius=10.0, flat_half_length=1.0).height([0.5, 3.0]).tolist()
    [0.0, 0.2]
    """

    model_config = FROZEN

    kind: Literal["flat_rounded"] = "flat_rounded"
    radius: Positive = Field(description="edge radius R, length units (library: mm)")
    flat_half_length: Positive = Field(description="half-length b of the flat face, length units (library: mm)")

    @property
    def datum_length(self) -> float:
        """Distance from the load at which a half-plane's surface counts as unmoved: origin of rigid shift and approach."""
        return self.radius

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Gap h(x) >= 0 [length] of the untouched faces at x [length]; any shape."""
        beyond = np.maximum(np.abs(np.asarray(x, dtype=float)) - self.flat_half_length, 0.0)
        return np.square(beyond) / (2 * self.radius)


Profile = Annotated[Hertz | FlatRounded, Field(discriminator="kind")]
