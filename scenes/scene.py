"""A scene: what is true (bodies, materials, friction, loads, tolerances), never how it is computed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticSerializationError

from scenes.bodies import Bodies, Pad
from scenes.bounded import shown
from scenes.callable_loads import CallableLoad
from scenes.consistent import inconsistent
from scenes.errors import InputError
from scenes.expected import Expected
from scenes.frozen import Frozen, ShortForm
from scenes.harmonics import HarmonicLoad
from scenes.loads import EllipseLoad, PolygonLoad
from scenes.materials import Elastic, Materials, Positive
from scenes.notebook import scene_html
from scenes.profiles import FlatRounded, Hertz, Profile
from scenes.tags import Tag
from scenes.time_series import TimeSeriesLoad
from scenes.writing import write_keys

Load = Annotated[EllipseLoad | PolygonLoad | HarmonicLoad | TimeSeriesLoad | CallableLoad, Field(discriminator="kind")]


# Keys that say what a scene is and what is demanded of an answer: they move no figure of it.
WORDS = ("name", "title", "purpose", "source", "tags", "units", "tolerances", "expected")


class Friction(Frozen):
    """Coulomb friction with one coefficient; a number alone stands for it.

    >>> Friction.model_validate(0.6)
    Friction(coefficient=0.6)
    """

    coefficient: float = Field(ge=0, description="coefficient of friction f >= 0; 0 is frictionless")

    @model_validator(mode="before")
    @classmethod
    def _number_alone(cls, data: Any) -> Any:
        if isinstance(data, Mapping | Friction):
            return data
        if isinstance(data, bool) or not isinstance(data, Real):
            raise ValueError(f"{shown(data)} is neither a number nor a table with the key coefficient")
        return {"coefficient": data}


class Tolerances(Frozen):
    """Largest admitted discrepancy of each metric, stated beforehand, in the dimensionless forms of the comparison."""

    dissipation: Positive = Field(1.5e-3, description="relative, of the last cycle")
    peak_pressure: Positive = Field(2e-4, description="relative, worst instant of the last cycle")
    pressure: Positive = Field(2.5e-3, description="relative L2 over ||p||, worst instant of the last cycle")
    shear: Positive = Field(8e-3, description="relative L2 over f ||p||, worst instant of the last cycle")
    contact_edge: Positive = Field(0.025, description="over the reference half-width, worst instant of the last cycle")
    stick_edge: Positive = Field(0.025, description="over the reference half-width, worst instant of the last cycle")


class Scene(Frozen):
    """One contact problem: the question that both engines answer.

    `name` to `tags` say what it is and where it came from, `tolerances` and `expected` what is demanded of an answer; everything
    else is physics.
    """

    name: str = Field("", description="short name; the file's stem where it is left out")
    title: str = Field("", description="one line for headings")
    purpose: str = Field("", description="what the scene is for")
    source: str = Field("", description="where its numbers come from")
    tags: tuple[Tag, ...] = Field((), description="words to find it by, of a closed set: `halfplane scenes --tag`")
    units: str = Field("N, mm, MPa", description="any consistent set, as force, length, stress: words for the axes only")
    material: Annotated[Materials, ShortForm(Elastic)]
    profile: Profile
    friction: Annotated[Friction, ShortForm(Annotated[float, Field(ge=0, description="the coefficient alone")])]
    load: Load
    bodies: Bodies = Bodies()
    tolerances: Tolerances = Tolerances()
    expected: tuple[Expected, ...] = Field((), description="known numbers, checked by `halfplane run`")
    cycles: int = Field(6, ge=1, description="at most so many revolutions; the engines stop once the cycle repeats")

    @field_validator("units")
    @classmethod
    def _units_are_one_set(cls, units: str) -> str:
        if reason := inconsistent(units):
            raise ValueError(f"{units!r} can't be: {reason}")
        return units

    @model_validator(mode="after")
    def _faces_make_the_profile(self) -> Self:
        radius = self.bodies.relative_radius()
        if radius is not None and not (isinstance(self.profile, Hertz) and abs(self.profile.radius / radius - 1) <= 1e-9):
            raise ValueError(
                f"profile is not that of the cylinders: it is kind = 'hertz' with radius = {radius:.12g} "
                "(1/R is the sum of 1/radius over the cylinders)"
            )
        for name, body in (("lower", self.bodies.lower), ("upper", self.bodies.upper)):
            if isinstance(body, Pad) and isinstance(self.profile, Hertz | FlatRounded):
                reach = self.profile.radius + (self.profile.flat_half_length if isinstance(self.profile, FlatRounded) else 0.0)
                if body.width / 2 >= reach:
                    raise ValueError(
                        f"bodies.{name}.width = {body.width:g} goes past the end of the pad's arcs, at {2 * reach:g}: make it less"
                    )
        return self

    def _repr_html_(self) -> str:
        """For a notebook."""
        return scene_html(self)

    def save(self, path: str | Path) -> None:
        """Write a scene file, .toml or .json, which `load_scene` reads back as this scene; rows of a CSV file stand in it.

        Raises
        ------
        InputError
            For a scene that holds a Python function, for rows that are too many for a .toml file, where it can't be written.
        """
        keys = json.loads(self.model_dump_json(exclude_none=True))
        for table in (keys["profile"], keys["load"]):
            table.pop("file", None)
        write_keys(Path(path), keys)

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
