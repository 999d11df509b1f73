"""A scene: what is true (bodies, materials, friction, loads, tolerances), never how it is computed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field
from pydantic_core import PydanticSerializationError

from scenes.callable_loads import CallableLoad
from scenes.errors import InputError
from scenes.harmonics import HarmonicLoad
from scenes.loads import EllipseLoad, PolygonLoad
from scenes.materials import FROZEN, Materials, Positive
from scenes.profiles import Profile
from scenes.time_series import TimeSeriesLoad

Load = Annotated[EllipseLoad | PolygonLoad | HarmonicLoad | TimeSeriesLoad | CallableLoad, Field(discriminator="kind")]


class Friction(BaseModel):
    """Coulomb friction with one coefficient."""

    model_config = FROZEN

    coefficient: float = Field(ge=0, description="coefficient of friction f >= 0; 0 is frictionless")


class HalfPlanes(BaseModel):
    """Two half-planes: the bodies that half-plane theory is about."""

    model_config = FROZEN

    kind: Literal["half_planes"] = "half_planes"


class Tolerances(BaseModel):
    """Largest admitted discrepancy of each metric, stated beforehand, in the dimensionless forms of the comparison."""

    model_config = FROZEN

    dissipation: Positive = Field(1.5e-3, description="relative, of the last cycle")
    peak_pressure: Positive = Field(2e-4, description="relative, worst instant of the last cycle")
    pressure: Positive = Field(2.5e-3, description="relative L2 over ||p||, worst instant of the last cycle")
    shear: Positive = Field(8e-3, description="relative L2 over f ||p||, worst instant of the last cycle")
    contact_edge: Positive = Field(0.025, description="over the reference half-width, worst instant of the last cycle")
    stick_edge: Positive = Field(0.025, description="over the reference half-width, worst instant of the last cycle")


class Scene(BaseModel):
    """One contact problem: the question that both engines answer.

    `name` and `origin` say where it came from; everything else is physics.
    """

    model_config = FROZEN

    name: str = Field("", description="short name; the file's stem where it is left out")
    title: str = Field("", description="one line for headings")
    purpose: str = Field("", description="what the scene is for")
    source: str = Field("", description="where its numbers come from")
    units: str = Field("N, mm, MPa", description="any consistent set: words for the axes only")
    material: Materials
    profile: Profile
    friction: Friction
    load: Load
    bodies: HalfPlanes = HalfPlanes()
    tolerances: Tolerances = Tolerances()
    cycles: int = Field(6, ge=1, description="at most so many revolutions; the engines stop once the cycle repeats")

    def model_dump_json(self, **options: Any) -> str:
        """The scene as JSON text.

        Raises
        ------
        InputError
            For a scene that holds a Python function.
        """
        try:
            return super().model_dump_json(**options)
        except PydanticSerializationError as reason:
            raise InputError(
                f"scene {self.name!r} can't be written, hashed or sent elsewhere: it holds a Python function"
            ) from reason
