"""A scene: what is true (bodies, materials, friction, loads, tolerances), never how it is computed;
from files and the library.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticSerializationError

from scenes.arrays import LARGEST_NUMBER
from scenes.bodies import INSTEAD_OF_HOLLOW, Bodies, Elastic, Materials, Pad, ShoulderedPad
from scenes.errors import InputError, require_path, shortened_repr
from scenes.files import keys_of, parsed_toml, write_keys
from scenes.frozen import (
    Frozen,
    Positive,
    ShortForm,
    checked,
    did_you_mean,
    require_squarable,
    validated,
)
from scenes.loads import CallableLoad, EllipseLoad, HarmonicLoad, PolygonLoad, TimeSeriesLoad
from scenes.measured import READING_KEYS, SCENE_UNITS
from scenes.notebook_forms import registered_forms
from scenes.profiles import Profile
from scenes.rig import Rig
from scenes.segments import NORMAL_LOAD, TANGENTIAL_LOAD, largest_ratio, largest_ratio_of
from scenes.uncertainty import Input, Uncertainty, inputs_of, moved_scene
from scenes.unit_words import fault_of_units

Origin = Literal["paper", "benchmark", "made-up-record"]
ProfileTag = Literal["hertz", "flat", "compound", "wedge", "profile"]
BodyTag = Literal["half-planes", "bodies", "block", "pad", "cylinder", "unlike"]
LoadKind = Literal["ellipse", "polygon", "harmonics", "time-series"]
LoadTag = Literal["rig", "line", "constant-load", "normal-only", "bulk", "tilt", "unloading"]
Happens = Literal["partial-slip", "full-stick", "near-sliding", "gross-sliding", "frictionless"]
Tag = Literal[Origin, ProfileTag, BodyTag, LoadKind, LoadTag, Happens, "closed-form"]
"""The last: what its expected numbers rest on."""


def tags() -> tuple[str, ...]:
    """Every tag, in groups: origin, profile, bodies and materials, loads, what happens, proof.

    >>> "paper" in tags()
    True
    """
    return get_args(Tag)


Quantity = Literal[
    "dissipation",
    "loop_work",
    "largest_half_width",
    "least_half_width",
    "largest_pressure",
    "permanent_stick_half_width",
    "stick_share",
    "stick_centre",
    "contact_left",
    "contact_right",
    "moment",
    "lower_face_displacement",
]


class Expected(Frozen):
    """One number with its tolerance and its source.

    >>> Expected(quantity="dissipation", value=0.0, tolerance=1e-9, source="nothing slips").engine
    'half-plane theory'
    """

    quantity: Quantity = Field(
        description=(
            "of the last cycle (the whole path where nothing repeats): dissipation, loop_work,"
            " largest_half_width, least_half_width, largest_pressure, permanent_stick_half_width,"
            " stick_share (the latter over largest_half_width), stick_centre (of permanent stick),"
            " contact_left, contact_right (outermost edges); at the largest load moment (of the"
            " pressure about x = 0), lower_face_displacement (along y, of its middle: finite"
            " elements of a real body)"
        )
    )
    value: float = Field(description="in the scene's units; energies and loads per unit thickness")
    tolerance: Positive = Field(
        description=(
            "largest difference over the value; where that is 0, over A f^2 P^2, the largest"
            " half-width a, the largest pressure, or P a of a moment"
        )
    )
    engine: Literal["half-plane theory", "finite elements"] = Field(
        "half-plane theory", description="the engine that must meet it"
    )
    source: str = Field(min_length=1, description="where the number comes from")


Load = Annotated[
    EllipseLoad | PolygonLoad | HarmonicLoad | TimeSeriesLoad | CallableLoad,
    Field(discriminator="kind"),
]


# Keys that say what a scene is and what is demanded of an answer: they move no figure of it.
WORDS = (
    "name",
    "title",
    "purpose",
    "source",
    "tags",
    "units",
    "tolerances",
    "expected",
    "uncertainty",
)


class Friction(Frozen):
    """Coulomb friction with one coefficient; a number alone stands for it.

    >>> Friction.model_validate(0.6)
    Friction(coefficient=0.6)
    """

    coefficient: float = Field(ge=0, description="coefficient of friction f; 0 is frictionless")

    @model_validator(mode="before")
    @classmethod
    def _table_of_number(cls, value: Any) -> Any:
        """A table with the key coefficient, for a number that stands for it; ValueError for
        anything else.
        """
        if isinstance(value, Mapping | Friction):
            return value
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ValueError(
                f"{shortened_repr(value)} is neither a number nor a table with the key coefficient"
            )
        return {"coefficient": value}

    @field_validator("coefficient")
    @classmethod
    def _require_scale_or_zero(cls, coefficient: float) -> float:
        return require_squarable(coefficient) if coefficient else coefficient


# |E| admitted of the project's own engines, where half-plane theory is exact for the bodies:
# reasoned in tests/tolerances.py.
OWN_TOLERANCES = {
    "dissipation": 1.5e-3,
    "peak_pressure": 2e-4,
    "pressure": 2.5e-3,
    "shear": 8e-3,
    "contact_edge": 0.025,
    "stick_edge": 0.025,
}


class Tolerances(Frozen):
    """Largest admitted discrepancy of each metric, stated beforehand, in the dimensionless forms of
    the comparison.

    What is left out is judged by the tolerance of the project's own engines where half-plane theory
    is exact for the bodies, and of real bodies not at all: their discrepancy is the answer.
    """

    dissipation: Positive | None = Field(None, description="relative, of the last cycle")
    peak_pressure: Positive | None = Field(None, description="relative, worst instant")
    pressure: Positive | None = Field(None, description="relative L2 over ||p||, worst instant")
    shear: Positive | None = Field(None, description="relative L2 over f ||p||, worst instant")
    contact_edge: Positive | None = Field(
        None, description="over the reference half-width, worst instant"
    )
    stick_edge: Positive | None = Field(
        None, description="over the reference half-width, worst instant"
    )

    def limit(self, key: str) -> float | None:
        """What is stated for a metric, else `OWN_TOLERANCES`, whatever the bodies; None where
        neither has it.
        """
        stated_limit = getattr(self, key, None)
        return OWN_TOLERANCES.get(key) if stated_limit is None else float(stated_limit)


class Scene(Frozen):
    """One contact problem: the question that both engines answer.

    `name` to `tags` say what it is and where it came from, `tolerances` and `expected` what is
    demanded of an answer; everything else is physics.
    """

    name: str = Field("", description="short name; the file's stem where it is left out")
    title: str = Field("", description="one line for headings")
    purpose: str = Field("", description="what the scene is for")
    source: str = Field("", description="where its numbers come from")
    tags: tuple[Tag, ...] = Field((), description="words to find it by: `halfplane scenes --tag`")
    units: str = Field(
        "N, mm, MPa",
        description="any consistent set, as force, length, stress: words for the axes only",
    )
    material: Annotated[Materials, ShortForm(Elastic)]
    profile: Profile
    friction: Annotated[
        Friction, ShortForm(Annotated[float, Field(ge=0, description="the coefficient alone")])
    ]
    load: Load
    bodies: Bodies = Bodies()
    rig: Rig = Rig()
    tolerances: Tolerances = Tolerances()
    uncertainty: Uncertainty | None = Field(
        None, description="standard uncertainties of the inputs; none stated, none assumed"
    )
    expected: tuple[Expected, ...] = Field(
        (), description="known numbers, checked by `halfplane run`"
    )
    cycles: int = Field(
        6,
        ge=1,
        description="largest number of revolutions; the engines stop once the cycle repeats",
    )

    def vary(self, /, **changes: Any) -> Self:
        """A copy of the scene with some keys changed, checked like a new one.

        `changes` are key = value; the value for a part of the scene is a table of its keys.
        Tolerances of a scene of half-planes are left out where a body becomes finite, unless
        `changes` has some; `tolerances={}` removes them. Standard uncertainties are left out where
        the new scene lacks one of their inputs.

        >>> from scenes import Block, load_scene
        >>> scene = load_scene("hertz-normal")
        >>> block = scene.vary(bodies={"lower": Block(width=20, height=8)})
        >>> scenes = (scene, block, scene.vary(tolerances={}))
        >>> [scene.tolerances.dissipation for scene in scenes]
        [1e-09, None, None]
        """
        # An empty table removes the tolerances.
        if changes.get("tolerances") == {}:
            changes["tolerances"] = Tolerances()
        if self.uncertainty is not None and "uncertainty" not in changes:
            changed_scene = self.vary(**changes, uncertainty=None)
            try:
                return changed_scene.vary(uncertainty=self.uncertainty)
            except InputError:  # an uncertainty is of an input that the changed scene lacks
                return changed_scene
        changed_scene = super().vary(**changes)
        # `half_planes`: both bodies are half-planes.
        gains_a_body = self.bodies.half_planes and not changed_scene.bodies.half_planes
        if gains_a_body and "tolerances" not in changes:
            return super(Scene, changed_scene).vary(tolerances=Tolerances())
        return changed_scene

    @field_validator("units")
    @classmethod
    def _require_one_set_of_units(cls, units: str) -> str:
        """The units as they are; ValueError for a stress that is not force over length squared."""
        if reason := fault_of_units(units):
            raise ValueError(f"{units!r} can't be: {reason}")
        return units

    @model_validator(mode="after")
    def _require_parts_that_fit(self) -> Self:
        """Refuse a scene whose parts contradict each other (ValueError with what to do).

        Each stated uncertainty, too, must be of an input that the scene has.
        """
        self._check_units_of_columns()
        self._check_rig()
        self._check_profile()
        inputs_of(self)  # for its ValueError alone
        return self

    def _check_units_of_columns(self) -> None:
        """Refuse load or profile columns of a text file that were converted into other units than
        those of the scene (ValueError).

        `units` are those of the scene, such as "N, mm, MPa". `read_as` describes how a table was
        read from its file, as (what, how); None without a file.
        """
        for table_name, table in (("load", self.load), ("profile", self.profile)):
            # How the columns were read: what -> how.
            column_readings = dict(getattr(table, "read_as", None) or ())
            # SCENE_UNITS: the entry on the units that the columns were turned into.
            units_of_columns = column_readings.get(SCENE_UNITS, self.units)
            if units_of_columns != self.units:
                raise ValueError(
                    f"units = {self.units!r}, and the columns of {table_name}.file were turned into"
                    f" {units_of_columns!r}: give file and units together in a scene file, or to"
                    " Scene.vary"
                )

    def _check_profile(self) -> None:
        """Refuse a profile that does not fit the bodies (ValueError).

        Its characteristic length (`datum_length`) must lie between 1e-100 and 1e100. Its radius
        must be that of cylinders that touch, and its arcs must go beyond the width of a pad.
        """
        datum_length = self.profile.datum_length
        # Relative radius of the cylinders; None where no body is one.
        cylinder_radius = self.bodies.relative_radius()
        # Half the length of the flat, and the radius of the arcs beside it; None for other shapes.
        arc = self.profile.arc
        arc_radius = None if arc is None else arc[1]
        # LARGEST_NUMBER: 1e100; products of larger numbers may overflow
        if not 1 / LARGEST_NUMBER <= datum_length <= LARGEST_NUMBER:
            raise ValueError(
                f"profile has a length of {datum_length:g}, which is not between"
                f" {1 / LARGEST_NUMBER:g} and {LARGEST_NUMBER:g}: choose other units"
            )

        if cylinder_radius is not None and not (
            self.profile.kind == "hertz"
            and arc_radius is not None
            and abs(arc_radius / cylinder_radius - 1) <= 1e-9
        ):
            is_wider = arc_radius is not None and arc_radius > cylinder_radius
            raise ValueError(
                "profile is not that of the cylinders: it is kind = 'hertz' with radius ="
                f" {cylinder_radius:.12g} (1/R is the sum of 1/radius over the cylinders)"
                + (f"; {INSTEAD_OF_HOLLOW}" if is_wider else "")
            )

        for body_name, body in (("lower", self.bodies.lower), ("upper", self.bodies.upper)):
            # sum(arc): half the flat plus the radius, the x at which the arcs end.
            if isinstance(body, Pad | ShoulderedPad) and arc and body.width / 2 >= sum(arc):
                raise ValueError(
                    f"bodies.{body_name}.width = {body.width:g} goes past the end of the pad's"
                    f" arcs, at {2 * sum(arc):g}: make it less"
                )

    def _check_rig(self) -> None:
        """Refuse a rig (springs between actuators and bodies) that does not fit load and bodies
        (ValueError).

        Springs, or the distance from the contact at which a displacement is prescribed
        (`datum_length`), need a prescribed displacement (`load.is_driven`). This in turn needs
        bodies, or for half-planes that distance, and a profile with two equal sides. A spring in
        the normal direction needs a prescribed approach (`states_approach`). `rig.is_stated`: any
        key of the rig is stated.
        """
        rig = self.rig
        load = self.load
        if rig.is_stated and not load.is_driven:
            raise ValueError(
                "rig goes with load.tangential_displacement: under given loads no spring and no"
                " datum changes the contact; leave rig out"
            )
        if rig.normal_stiffness is not None and not load.states_approach:
            raise ValueError(
                "rig.normal_stiffness goes with load.approach: P is given here; leave it out"
            )

        # Under a prescribed displacement.
        if not load.is_driven:
            return
        if not self.profile.symmetric:
            raise ValueError(
                "load.tangential_displacement is followed for profiles with two equal sides: state"
                " such a profile, or the loads"
            )
        if self.bodies.half_planes and rig.datum_length is None:
            raise ValueError(
                "load.tangential_displacement needs bodies: a displacement of half-planes depends"
                " on where it is prescribed. State bodies.lower and bodies.upper, or"
                " rig.datum_length, the distance from the contact at which it is"
            )
        if not self.bodies.half_planes and rig.datum_length is not None:
            raise ValueError(
                "rig.datum_length goes with half-planes alone: of bodies the displacement is"
                " prescribed at their bases; leave it out"
            )

    @property
    def unsymmetric(self) -> bool:
        """Whether bulk stress, tilt or two unequal sides let contact and stick zone lie anywhere,
        so that no half stands for both.

        >>> from scenes import load_scene
        >>> load_scene("hertz-paper").unsymmetric, load_scene("nowell-hills").unsymmetric
        (False, True)
        """
        return self.load.has_bulk_or_tilt or not self.profile.symmetric

    @property
    def has_measured_rows(self) -> bool:
        """Whether the loads are a record, or the profile comes from rows of a table or was fitted
        to them.

        >>> from scenes import load_scene
        >>> load_scene("hertz-paper").has_measured_rows
        False
        """
        is_fitted = getattr(self.profile, "fitted", None) is not None
        is_table = self.profile.kind == "tabulated"
        return isinstance(self.load, TimeSeriesLoad) or is_fitted or is_table

    @property
    def unit_words(self) -> tuple[str, str, str]:
        """Names of force, length and stress; general words where `units` is no list of three.

        >>> from scenes import load_scene
        >>> load_scene("hertz-paper").unit_words
        ('N', 'mm', 'MPa')
        """
        parts = tuple(part.strip() for part in self.units.split(","))
        return (parts[0], parts[1], parts[2]) if len(parts) == 3 else ("force", "length", "stress")

    @property
    def smallest_friction(self) -> float:
        """Smallest coefficient of friction at which the loads cause no gross sliding: the largest
        |Q|/P on the load path.

        Infinite where P is negative, or zero while Q is not. InputError where a displacement is
        prescribed.

        >>> from scenes import load_scene
        >>> scene = load_scene("cattaneo-mindlin")
        >>> round(scene.smallest_friction / scene.friction.coefficient, 12)
        0.6
        """
        if isinstance(self.load, TimeSeriesLoad):
            rows = self.load.series()  # straight lines between rows: the largest ratio is at one
            return largest_ratio_of(rows[:, 1], rows[:, 2])
        load_path = self.load.path()
        return largest_ratio((*load_path.initial_loading, *load_path.cycle))

    @property
    def inputs(self) -> tuple[Input, ...]:
        """The inputs whose standard uncertainty is stated; none where none is.

        >>> from scenes import load_scene
        >>> scene = load_scene("hertz-paper").vary(uncertainty={"friction": "5 %"})
        >>> [(entry.words, entry.standard_uncertainty) for entry in scene.inputs]
        [('friction', 0.05)]
        """
        return inputs_of(self)

    def moved(self, changes: Mapping[str, float]) -> Self:
        """The scene with inputs moved by shares of their values, the phase by degrees:
        `uncertainty.moved_scene`.
        """
        return moved_scene(self, changes)

    def __repr__(self) -> str:
        """Five lines of text on the scene: name and title, bodies and materials, profile and
        friction, ranges of the loads, units.

        >>> from scenes import load_scene
        >>> print(load_scene("cattaneo-mindlin"))
        Scene 'cattaneo-mindlin': Cattaneo-Mindlin: constant P, Q cycling between ±0.6 f P
          half plane on half plane, E = 210000 and 210000, ν = 0.3 and 0.3 (upper, lower)
          profile: hertz; coefficient of friction 0.5
          load: polygon, P from 0 to 90.6229, Q from -27.1869 to 27.1869, |Q|/P up to 0.3
          units: N, mm, MPa
        """
        # `is_driven`: a displacement is prescribed in the place of Q; `states_approach`: an
        # approach in the place of P.
        upper_material = self.material.upper
        lower_material = self.material.lower
        # Least and largest P (or approach) and Q (or U of the actuator) on the load path.
        normal_range, tangential_range = self.ranges_of_load()
        least_normal_value, largest_normal_value = normal_range
        least_tangential_value, largest_tangential_value = tangential_range
        normal_name = "approach" if self.load.states_approach else "P"
        tangential_text = f"from {least_tangential_value:.6g} to {largest_tangential_value:.6g}"
        if self.load.is_driven:
            tangential_text = f"U of the actuator {tangential_text}"
        else:
            tangential_text = f"Q {tangential_text}, |Q|/P up to {self.smallest_friction:.6g}"
        bodies = f"{self.bodies.upper.kind} on {self.bodies.lower.kind}"
        lines = (
            f"Scene {self.name!r}" + (f": {self.title}" if self.title else ""),
            f"  {bodies.replace('_', ' ')}, E = {upper_material.young_modulus:.6g} and"
            f" {lower_material.young_modulus:.6g}, ν = {upper_material.poisson_ratio:.4g} and"
            f" {lower_material.poisson_ratio:.4g} (upper, lower)",
            f"  profile: {self.profile.kind.replace('_', ' ')}; coefficient of friction"
            f" {self.friction.coefficient:.6g}",
            f"  load: {self.load.kind.replace('_', ' ')}, {normal_name} from"
            f" {least_normal_value:.6g} to {largest_normal_value:.6g}, {tangential_text}",
            f"  units: {self.units}",
        )
        return "\n".join(lines)

    __str__ = __repr__

    def ranges_of_load(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and largest P and Q of the path, or approach and U of the actuators where these are
        prescribed.
        """
        normal_loads, tangential_loads = self._loads_at_turns()
        return (min(normal_loads), max(normal_loads)), (
            min(tangential_loads),
            max(tangential_loads),
        )

    def _loads_at_turns(self) -> tuple[list[float], list[float]]:
        """P and Q [force per thickness], two lists, at the ends and turning points of all load
        segments, so that their extremes are among them; of a record of loads at its rows.

        Where the rig's actuators are driven (`load.is_driven`), the lists are what they prescribe:
        normal approach or P, and tangential displacement U [length].
        """
        if isinstance(self.load, TimeSeriesLoad) and not self.load.is_driven:
            rows = self.load.series()
            return rows[:, 1].tolist(), rows[:, 2].tolist()
        load_path = self.load.path_of_actuators() if self.load.is_driven else self.load.path()
        normal_loads: list[float] = []
        tangential_loads: list[float] = []
        for segment in (*load_path.initial_loading, *load_path.cycle):
            # NORMAL_LOAD, TANGENTIAL_LOAD: P and Q, as combinations of the two
            turning_times_of_p = segment.turning_points(NORMAL_LOAD)
            turning_times_of_q = segment.turning_points(TANGENTIAL_LOAD)
            # Ends of the segment, and times at which P or Q turns.
            times = np.array([segment.start, segment.end, *turning_times_of_p, *turning_times_of_q])
            normal_load, tangential_load = segment.loads(times)
            normal_loads += normal_load.tolist()
            tangential_loads += tangential_load.tolist()
        return normal_loads, tangential_loads

    def _repr_html_(self) -> str | None:
        """For a notebook; None, and so the text, where no HTML is registered."""
        forms = registered_forms()
        return None if forms is None else forms.scene_html(self)

    def save(self, path: str | Path) -> None:
        """Write the scene to the .toml or .json file at `path`, from which it can be loaded again.

        Rows that were read from text files are written into it, and the keys on how these were read
        are left out.

        Raises
        ------
        InputError
            For a scene that holds a Python function, for rows that are too many for a .toml file,
            where it can't be written.
        """
        scene_keys = json.loads(self.model_dump_json(exclude_none=True))
        for table in (scene_keys["profile"], scene_keys["load"]):
            # READING_KEYS: keys on how a text file is read, such as "columns" and "units"
            for key in ("file", *READING_KEYS):
                table.pop(key, None)
        write_keys(Path(path), scene_keys)

    def model_dump_json(self, **options: Any) -> str:
        """The scene as JSON text, to be stored, hashed or sent to another process; `options` are
        those of pydantic.

        Raises
        ------
        InputError
            For a scene that holds a Python function.
        """
        try:
            return super().model_dump_json(**options)
        except PydanticSerializationError as reason:
            raise InputError(
                f"scene {self.name!r} can't be written, hashed or sent elsewhere: it holds a Python"
                " function"
            ) from reason


_LIBRARY = Path(__file__).parent / "library"


def scene_names() -> tuple[str, ...]:
    """Names of the scenes of given loads in the library, in alphabetical order: those that both
    engines take, and that have a published page.

    >>> "hertz-paper" in scene_names()
    True
    """
    return _names_in(_LIBRARY)


def rig_names() -> tuple[str, ...]:
    """Names of the library's scenes whose rig prescribes a displacement, in alphabetical order.

    >>> "rig-gross-slip" in rig_names()
    True
    """
    return _names_in(_LIBRARY / "rigs")


def _names_in(folder: Path) -> tuple[str, ...]:
    """Names of the scene files of a folder, in alphabetical order."""
    files = [entry.name for entry in folder.iterdir() if entry.name.endswith(".toml")]
    return tuple(sorted(name.removesuffix(".toml") for name in files))


def _folder_of(name: str) -> Path | None:
    """The folder of a library scene; None for an unknown name."""
    for folder in (_LIBRARY, _LIBRARY / "rigs"):
        if name in _names_in(folder):
            return folder
    return None


def scene_text(name: str) -> str:
    """The text of a library scene, to start an own one from; InputError for an unknown name."""
    folder = _folder_of(name)
    if folder is None:
        raise InputError(_unknown_scene(name))
    return (folder / f"{name}.toml").read_text(encoding="utf-8")


def scene_companions(name: str) -> dict[str, str]:
    """Files that a scene of the library reads besides its own .toml file, such as measured loads:
    file name -> text; empty for an unknown scene.

    >>> list(scene_companions("time-series"))
    ['time-series.csv']
    """
    # Folder of the library that holds the scene; None for an unknown name.
    folder = _folder_of(name)
    if folder is None:
        return {}
    files = [
        entry
        for entry in folder.iterdir()
        if entry.name.startswith(f"{name}.") and not entry.name.endswith(".toml")
    ]
    return {entry.name: entry.read_text(encoding="utf-8") for entry in files}


def scene_schema() -> dict[str, Any]:
    """JSON schema of a scene file, for editors."""
    return Scene.model_json_schema()


def load_scene(source: str | Path) -> Scene:
    """Read a scene, a contact problem with bodies, profile, friction and loads, from the library by
    its name, or from a .toml or .json file.

    Parameters
    ----------
    source
        name of a scene of the library, or path of a file

    Raises
    ------
    InputError
        One sentence that names file, key, value and rule.

    Examples
    --------
    >>> load_scene("hertz-paper").friction.coefficient
    1.0
    """
    require_path(source, "load_scene", "the name of a scene or the path of its file")
    path = Path(source)
    name = str(source)
    # Folder of the library that holds a scene of this name; None without one.
    library_folder = _folder_of(name)
    if library_folder is not None:
        keys = parsed_toml(scene_text(name))
        folder = Path(str(library_folder))
    elif not path.suffix and not os.path.exists(path):  # False too for a name too long for a path
        raise InputError(_unknown_scene(name))
    elif path.suffix not in (".toml", ".json"):
        if path.is_dir():
            raise InputError(
                f"{path}: this is a folder; name the scene file in it, which ends in .toml or .json"
            )
        raise InputError(
            f"{path}: a scene file ends in .toml or .json, not in {path.suffix or 'nothing'!r}"
        )
    else:
        keys = keys_of(
            path,
            "the scene file",
            "put long tables into a CSV file beside it, named by the key `file`",
        )
        if not keys:
            raise InputError(
                f"{path}: the scene file is empty; `halfplane init FILE.toml` writes one to start"
                " from"
            )
        name = path.stem
        folder = path.parent

    # A validated scene; the file's keys override the name taken from the file.
    return checked(Scene, {"name": name} | keys, str(path), of_file=True, folder=folder)


def scene_of(scene: Scene | str | Path) -> Scene:
    """Turn what a user passes as a scene into a checked one: a Scene, the name of a scene of the
    library, or the path of a scene file.

    Raises
    ------
    InputError
        One sentence with key, value and rule: for an unknown name, a file that can't be read, or
        values that do not pass.

    Examples
    --------
    >>> scene_of("hertz-paper") == load_scene("hertz-paper")
    True
    """
    return load_scene(scene) if isinstance(scene, str | Path) else validated(scene, Scene)


def _unknown_scene(name: str) -> str:
    """Message for a name that is no scene of the library and no file, with the nearest name."""
    names = (*scene_names(), *rig_names())
    hint = did_you_mean(name, names) or f" the library has {', '.join(names)};"
    return (
        f"{name}: no such scene or file;{hint} `halfplane init FILE.toml` writes one to start from"
    )
