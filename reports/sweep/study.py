"""A study file: a scene, axes over its keys, the engines to run and the figures to keep. Read and checked whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from reports.sweep.axes import Axis, Value
from reports.sweep.figures import check_figures
from scenes import InputError, Scene, load_scene
from scenes.errors import present_name
from scenes.files import keys_of
from scenes.frozen import Frozen, refusal

Engine = Literal["fe", "exact"]
Preset = Literal["default", "coarse", "fine"]
Uncertainty = Literal["none", "cheap", "budget"]


class Study(Frozen):
    """What is asked of a sweep; see docs/sweeps.md.

    Attributes
    ----------
    scene : the scene that all points start from
    set : dotted key -> value, the same at every point
    derived : name or dotted key -> arithmetic in the names of axes and of what is derived above
    figures : names of `figures.FIGURES`, metric keys among them
    uncertainty : "none"; "cheap": one coarser mesh, theory on the polygon of the steps, a farther far field; "budget": the whole
        error budget of `halfplane run --budget`, for metrics
    share_condensations : cut all points alike that have bodies, materials, profile and largest load in common: fine elements
        everywhere in the contact, one condensation for all; else each is cut for its own edges
    samples, seed : of the Latin hypercube
    """

    keys_listed = "docs/sweeps.md"

    title: str = ""
    purpose: str = ""
    scene: Scene
    set: dict[str, Value] = Field({})
    axes: tuple[Axis, ...] = Field(min_length=1)
    derived: dict[str, str | float] = Field({})
    engines: tuple[Engine, ...] = Field(("fe", "exact"), min_length=1)
    figures: tuple[str, ...] = Field(("error.dissipation", "error.peak_pressure"), min_length=1)
    uncertainty: Uncertainty = "none"
    share_condensations: bool = True
    samples: int = Field(0, ge=0, le=1_000_000)
    seed: int = Field(0, ge=0)
    preset: Preset = "default"

    @field_validator("preset", mode="before")
    @classmethod
    def _present_preset(cls, preset: Any) -> Any:
        return present_name(preset) if isinstance(preset, str) else preset

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        columns = [column for axis in self.axes for column in axis.columns]
        targets = [key for axis in self.axes for key, _ in axis.targets] + [*self.derived, *self.set]
        for what, names in (("the column", columns), ("the key", targets)):
            if twice := next((name for name in names if names.count(name) > 1), None):
                raise ValueError(f"{what} {twice!r} is given twice")
        if (self.samples > 0) != any(axis.latin_hypercube for axis in self.axes):
            raise ValueError("samples goes with axes that have a latin_hypercube, and these need it")
        if idle := next((a.columns[0] for a in self.axes if not a.targets and not self._uses(a)), None):
            raise ValueError(f"the axis {idle!r} moves nothing: give it a key, or use its name in [derived]")
        check_figures(self.figures, self.engines, self.uncertainty)
        return self

    def _uses(self, axis: Axis) -> bool:
        return any(column in str(text) for column in axis.columns for text in self.derived.values())


def load_study(source: str | Path) -> Study:
    """The study of a .toml or .json file; its scene is a table, a library name, or a path beside the file.

    Raises
    ------
    InputError
        One sentence that names file, key, value and rule.
    """
    path = Path(source)
    return study_of(keys_of(path, "the study"), str(source), path.parent)


def study_of(data: dict[str, Any], where: str, folder: Path = Path()) -> Study:
    """A checked study from raw keys; a scene named as a file lies in `folder`."""
    named = data.get("scene")
    if named is None and {"material", "profile", "load"} <= data.keys():
        raise InputError(f"{where}: this is a scene; a study is a file beside it with `scene` and `axes`: docs/sweeps.md")
    if isinstance(named, str):
        scene = load_scene(folder / named if Path(named).suffix else named)
        data = data | {"scene": json.loads(scene.model_dump_json())}
    try:
        return Study.model_validate_json(json.dumps(data, default=str), strict=True)
    except ValidationError as faults:
        raise InputError(f"{where}: {refusal(faults, data, Study)}") from faults
    except RecursionError as reason:  # JSON with brackets by the hundred
        raise InputError(f"{where}: its tables are nested too deeply") from reason
