"""How well the numbers of a scene are known: standard uncertainties of its inputs, their
correlations, and the scene with its inputs moved. None stated, none assumed.

A standard uncertainty is one standard deviation. It is stated as a share of the value ("5 %") or as
an amount with its unit ("0.1 mm"); the phase, of which no share makes sense, in degrees. A bare
number is refused elsewhere: 0.05 may be a share or an amount.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Annotated, Any, Literal, NamedTuple, Protocol, Self, TypeVar

import numpy as np
from pydantic import BeforeValidator, Field, field_validator, model_validator

from scenes.array_types import Array
from scenes.bodies import Bodies, Cylinder, Materials
from scenes.errors import shortened_repr
from scenes.frozen import Frozen
from scenes.loads import (
    CallableLoad,
    EllipseLoad,
    HarmonicLoad,
    PolygonLoad,
    TimeSeriesLoad,
)
from scenes.rig import Rig
from scenes.unit_words import Kind, unit_factor

# Beyond it the value is of unknown size: neither a derivative nor a normal distribution says
# anything of it.
_LARGEST_SHARE = 0.5
_LARGEST_ANGLE = 45.0
# Of the least eigenvalue of a correlation matrix: below minus this it is none.
_ROUND_OFF_OF_CORRELATION = 1e-9
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
_SPELLINGS_OF_PERCENT = ("%", "percent", "per cent")
_EXAMPLES_BY_KIND = {
    "share": '"5 %"',
    "length": '"1 %" or "0.1 mm"',
    "stress": '"1 %" or "2 GPa"',
}

UncertaintyKind = Literal["share", "length", "stress"]


class _NumberAndUnit(NamedTuple):
    """A number and its unit; "%" for a percentage."""

    number: float
    unit: str


def _number_and_unit(text: str) -> _NumberAndUnit | None:
    """A number with what stands behind it; None where no number begins the text.

    >>> _number_and_unit("5 %"), _number_and_unit("0.1mm"), _number_and_unit("about 3")
    (_NumberAndUnit(number=5.0, unit='%'), _NumberAndUnit(number=0.1, unit='mm'), None)
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        return None
    unit = match[2] or ""
    return _NumberAndUnit(float(match[1]), "%" if unit.lower() in _SPELLINGS_OF_PERCENT else unit)


def _require_uncertainty_text(kind: UncertaintyKind, stated_uncertainty: Any) -> str:
    """Check the text of a standard uncertainty and return it without blanks at its ends: a
    percentage of the input's value, such as "5 %", or an amount with a unit, such as "0.1 mm".

    `kind` "share" takes a percentage alone, "length" and "stress" also an amount.

    Raises
    ------
    ValueError
        With what to write: for a bare number, for text of another form, for a number that is not
        above 0, for an amount where a percentage alone is taken, and for more than 50 %.
    """
    # _EXAMPLES_BY_KIND: examples of what to write
    what_to_write = f"write {_EXAMPLES_BY_KIND[kind]}, in quotation marks"
    quoted_text = shortened_repr(stated_uncertainty)
    if not isinstance(stated_uncertainty, str):
        raise ValueError(
            f"{quoted_text} is a bare number, which may be a share or an amount; {what_to_write}"
        )
    # Number and unit, "%" for a percentage; None where the text does not begin with a number.
    parsed_text = _number_and_unit(stated_uncertainty)
    if parsed_text is None:
        raise ValueError(f"{quoted_text} does not begin with a number; {what_to_write}")
    if not parsed_text.unit:
        raise ValueError(
            f"{quoted_text} has no unit: it may be a share or an amount; {what_to_write}"
        )
    if not 0 < parsed_text.number < math.inf:
        raise ValueError(
            f"{quoted_text} is not above 0; leave the key out for an input that is known exactly"
        )
    if parsed_text.unit == "%":
        _require_small(parsed_text.number / 100, stated_uncertainty)
    elif kind == "share":
        raise ValueError(f"{quoted_text} is not in per cent; {what_to_write}")
    return stated_uncertainty.strip()


def _require_small(share: float, value: Any) -> None:
    """ValueError for a standard uncertainty above half of the value (`share` over 0.5)."""
    if share > _LARGEST_SHARE:
        raise ValueError(
            f"{shortened_repr(value)} is {100 * share:g} % of the value, and at most"
            f" {100 * _LARGEST_SHARE:g} % is taken: of an input that is known so badly no"
            " uncertainty of the answer can be stated"
        )


def share_of(text: str) -> float:
    """Standard uncertainty as a fraction of the value, from a checked text in per cent.

    >>> share_of("5 %")
    0.05
    """
    parsed_text = _number_and_unit(text)
    assert parsed_text is not None  # the text was checked
    return parsed_text.number / 100


def _in_degrees(value: Any) -> Any:
    """Convert an angle stated as text with a unit, such as "0.05 rad", to degrees; a value that is
    no text is returned unchanged. ValueError where the text is no angle with a unit.
    """
    if not isinstance(value, str):
        return value
    # Number and unit; None where the text does not begin with a number.
    parsed_text = _number_and_unit(value)
    rule = 'write degrees as a number, such as 3.0, or "0.05 rad"'
    if parsed_text is None or not parsed_text.unit:
        raise ValueError(f"{shortened_repr(value)} is no angle with its unit; {rule}")
    if parsed_text.unit == "%":
        raise ValueError(f"{shortened_repr(value)}: no share of a phase is taken; {rule}")
    try:
        # Factor to radians. Angles do not depend on the units of the scene, so that none are given.
        radians_per_unit, _ = unit_factor(parsed_text.unit, "angle", "")
    except ValueError as reason:
        raise ValueError(f"{shortened_repr(value)}: {reason}; {rule}") from reason
    return math.degrees(parsed_text.number * radians_per_unit)


_DESCRIPTION_OF_SHARE = 'standard uncertainty of {}, a share as text, such as "5 %"'
_DESCRIPTION_OF_SHARE_OR_LENGTH = 'standard uncertainty, as text: "1 %" or "0.1 mm"'
_DESCRIPTION_OF_SHARE_OR_STRESS = 'standard uncertainty, as text: "1 %" or "2 GPa"'
Share = Annotated[str, BeforeValidator(partial(_require_uncertainty_text, "share"))]
Length = Annotated[str, BeforeValidator(partial(_require_uncertainty_text, "length"))]
Stress = Annotated[str, BeforeValidator(partial(_require_uncertainty_text, "stress"))]
Degrees = Annotated[float, BeforeValidator(_in_degrees), Field(gt=0, le=_LARGEST_ANGLE)]


class OfShape(Frozen):
    """Standard uncertainties of the lengths of a profile."""

    radius: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    flat_half_length: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    inner_radius: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    outer_radius: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    inner_half_length: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    tip_radius: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    tip_half_length: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)


class OfElastic(Frozen):
    """Standard uncertainties of the constants of one material."""

    young_modulus: Stress | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_STRESS)
    poisson_ratio: Share | None = Field(
        None, description=_DESCRIPTION_OF_SHARE.format("Poisson's ratio")
    )


class OfMaterials(OfElastic):
    """The same: of one material for both bodies, which then is one input; `upper` and `lower` are
    two.
    """

    upper: OfElastic | None = Field(None, description="of the upper body alone")
    lower: OfElastic | None = Field(None, description="of the lower body alone")


class OfBody(Frozen):
    """Standard uncertainties of the lengths of one body."""

    height: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    width: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    radius: Length | None = Field(
        None, description=f"of a cylinder, and so of the profile; {_DESCRIPTION_OF_SHARE_OR_LENGTH}"
    )
    flange_height: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    stem_width: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    shoulder_depth: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)
    shoulder_width: Length | None = Field(None, description=_DESCRIPTION_OF_SHARE_OR_LENGTH)


class OfPairOfBodies(Frozen):
    """Those of both bodies, each an input of its own."""

    upper: OfBody | None = Field(None, description="of the upper body")
    lower: OfBody | None = Field(None, description="of the lower body")


class OfRig(Frozen):
    """Standard uncertainties of the springs of a rig."""

    tangential_stiffness: Share | None = Field(
        None, description=_DESCRIPTION_OF_SHARE.format("k_s")
    )
    normal_stiffness: Share | None = Field(None, description=_DESCRIPTION_OF_SHARE.format("k_n"))


class Uncertainty(Frozen):
    """Standard uncertainties of the inputs of a scene, independent of each other but for the stated
    correlations; the nested tables have the keys of the scene's.

    >>> Uncertainty(friction="5 %", phase_degrees="0.05 rad").phase_degrees
    2.864788975654116
    """

    friction: Share | None = Field(
        None, description=_DESCRIPTION_OF_SHARE.format("the coefficient")
    )
    normal_load: Share | None = Field(
        None, description=_DESCRIPTION_OF_SHARE.format("P, one scale of all its values")
    )
    tangential_load: Share | None = Field(
        None, description=_DESCRIPTION_OF_SHARE.format("Q, one scale of all its values")
    )
    approach: Share | None = Field(
        None,
        description=_DESCRIPTION_OF_SHARE.format(
            "the approach that is prescribed in the place of P"
        ),
    )
    tangential_displacement: Share | None = Field(
        None, description=_DESCRIPTION_OF_SHARE.format("U that is prescribed in the place of Q")
    )
    phase_degrees: Degrees | None = Field(
        None,
        description=(
            "standard uncertainty of the lag behind P, of an ellipse and of harmonics: a number in"
            ' degrees, or text such as "0.05 rad"'
        ),
    )
    profile: OfShape = OfShape()
    material: OfMaterials = OfMaterials()
    bodies: OfPairOfBodies = OfPairOfBodies()
    rig: OfRig = OfRig()
    correlations: tuple[tuple[str, str, float], ...] = Field(
        (),
        description=(
            "[key, key, coefficient] of two inputs that err together, such as"
            ' ["normal_load", "tangential_load", 0.9] of one load cell'
        ),
    )

    @field_validator("correlations")
    @classmethod
    def _require_coefficients(
        cls, correlations: tuple[tuple[str, str, float], ...]
    ) -> tuple[tuple[str, str, float], ...]:
        """The correlations as they are; ValueError for a coefficient beyond -1 or 1."""
        for first_key, second_key, coefficient in correlations:
            if not -1 <= coefficient <= 1:
                raise ValueError(
                    f"{coefficient:g}, that of {first_key} and {second_key}, is no coefficient of"
                    " correlation: it lies between -1 and 1"
                )
        return correlations

    @model_validator(mode="after")
    def _require_possible_correlations(self) -> Uncertainty:
        """Return this table; refuse (ValueError) correlations that are not possible: of inputs
        without standard uncertainty, of one input with itself, of a pair that is stated twice, or
        such that no random numbers can have them together.

        `correlations` holds (key, key, coefficient) of pairs of inputs; the correlation matrix of
        all inputs must have no negative eigenvalue.
        """
        uncertain_keys = [key for key, _ in self.stated()]
        earlier_pairs = set()
        for first_key, second_key, _ in self.correlations:
            for key in (first_key, second_key):
                if key not in uncertain_keys:
                    raise ValueError(
                        f"correlations: {shortened_repr(key)} has no standard uncertainty here;"
                        " stated are"
                        f" {', '.join(uncertain_keys) or 'none'}"
                    )
            if first_key == second_key:
                raise ValueError(
                    f"correlations: {first_key} stands there twice in one entry: name two inputs"
                )
            pair = frozenset((first_key, second_key))
            if pair in earlier_pairs:
                raise ValueError(
                    f"correlations: {first_key} and {second_key} have two entries: leave one out"
                )
            earlier_pairs.add(pair)
        # _ROUND_OFF_OF_CORRELATION: 1e-9, by which round-off makes an eigenvalue negative
        if (
            uncertain_keys
            and np.linalg.eigvalsh(self.correlation_matrix())[0] < -_ROUND_OFF_OF_CORRELATION
        ):
            raise ValueError(
                "correlations: no inputs can have these together (their matrix has a negative"
                " eigenvalue); state smaller ones"
            )
        return self

    def stated(self) -> Iterator[tuple[str, str | float]]:
        """Inputs for which a standard uncertainty is stated: the key of each, with dots between
        nested tables, and the uncertainty as text or in degrees.

        >>> table = Uncertainty(friction="5 %", profile=OfShape(radius="1 %"))
        >>> list(table.stated())
        [('friction', '5 %'), ('profile.radius', '1 %')]
        """
        yield from _stated_entries(self, "")

    def correlation_matrix(self) -> Array:
        """Correlation matrix (n, n) of the n inputs with a standard uncertainty, in the order in
        which the scene lists them; 1 on the diagonal, 0 where nothing is stated.

        `stated()` yields (key, standard uncertainty) of these inputs; `correlations` holds (key,
        key, coefficient) of pairs of them.
        """
        keys = [key for key, _ in self.stated()]
        matrix = np.eye(len(keys))
        for first_key, second_key, coefficient in self.correlations:
            row = keys.index(first_key)
            column = keys.index(second_key)
            matrix[row, column] = coefficient
            matrix[column, row] = coefficient
        return matrix


def _stated_entries(table: Frozen, prefix: str) -> Iterator[tuple[str, str | float]]:
    """Keys of a table and of those in it, with dots between, and their stated uncertainties."""
    for name, value in table:
        if isinstance(value, Frozen):
            yield from _stated_entries(value, f"{prefix}{name}.")
        elif name != "correlations" and value is not None:
            yield f"{prefix}{name}", value


# ------------------------------------------------------------------------- the inputs of one scene
class Input(NamedTuple):
    """An input of a scene whose standard uncertainty is stated.

    Attributes
    ----------
    key
        dotted, as in the table
    words
        what it is, in a sentence
    stated
        as it stands in the scene file
    value
        of the scene, in its units; None of the scale of a load
    standard_uncertainty
        one standard deviation: a share of the value, of the phase in degrees
    """

    key: str
    words: str
    stated: str
    value: float | None
    standard_uncertainty: float

    @property
    def in_words(self) -> str:
        """Key, value and standard uncertainty."""
        value_in_words = "" if self.value is None else f" {self.value:.6g}"
        return f"{self.key}{value_in_words} ± {self.stated}"


_NAMES_IN_WORDS = {
    "friction": "friction",
    "normal_load": "P",
    "tangential_load": "Q",
    "approach": "the approach",
    "tangential_displacement": "U of the actuator",
    "phase_degrees": "the phase",
    "material.young_modulus": "Young's modulus",
    "material.poisson_ratio": "Poisson's ratio",
    "rig.tangential_stiffness": "the tangential stiffness of the rig",
    "rig.normal_stiffness": "the normal stiffness of the rig",
}


def _words_of(key: str) -> str:
    """Name of an input of a scene, such as "profile.radius", in words for a sentence.

    >>> _words_of("bodies.lower.height"), _words_of("profile.flat_half_length")
    ('the height of the lower body', 'the flat half length')
    """
    if key in _NAMES_IN_WORDS:
        return _NAMES_IN_WORDS[key]
    table, *body_of_table, name = key.split(".")
    quantity = _NAMES_IN_WORDS.get(f"{table}.{name}", f"the {name.replace('_', ' ')}")
    return f"{quantity} of the {body_of_table[0]} body" if body_of_table else quantity


class _Friction(Protocol):
    @property
    def coefficient(self) -> float: ...


class HasInputs(Protocol):
    """The attributes of a `Scene` that are used here. `Scene` itself imports this module."""

    @property
    def friction(self) -> _Friction: ...
    @property
    def load(self) -> Any: ...
    @property
    def profile(self) -> Any: ...
    @property
    def material(self) -> Materials: ...
    @property
    def bodies(self) -> Bodies: ...
    @property
    def rig(self) -> Rig: ...
    @property
    def units(self) -> str: ...
    @property
    def uncertainty(self) -> Uncertainty | None: ...

    def vary(self, /, **changes: Any) -> Self:
        """A checked copy with other values."""
        ...


S = TypeVar("S", bound=HasInputs)


def inputs_of(scene: HasInputs) -> tuple[Input, ...]:
    """Inputs of a scene for which a standard uncertainty is stated, each with its value.

    `standard_uncertainty` of each is a fraction of the value; for the phase it is in degrees.

    Raises
    ------
    ValueError
        One sentence: for an input that the scene does not have, for an amount in a unit that is not
        known, for one above half of the value.
    """
    if scene.uncertainty is None:
        return ()
    inputs = []
    # `stated_uncertainty`: a text, such as "5 %" or "0.1 mm", or the number of degrees of the
    # phase.
    for key, stated_uncertainty in scene.uncertainty.stated():
        # In the scene's units; None for a load, whose uncertainty scales all its values.
        value = _value_of_input(scene, key)
        if isinstance(stated_uncertainty, str):
            standard_uncertainty = _relative_uncertainty(
                key, stated_uncertainty, value, scene.units
            )
            stated_text = stated_uncertainty
        else:  # the phase, in degrees
            standard_uncertainty = stated_uncertainty
            stated_text = f"{stated_uncertainty:.4g}°"
        inputs.append(Input(key, _words_of(key), stated_text, value, standard_uncertainty))
    return tuple(inputs)


def _relative_uncertainty(key: str, stated_text: str, value: float | None, units: str) -> float:
    """Standard uncertainty of an input as a fraction of its value, from a checked text: "5 %", or
    an amount with a unit, such as "0.1 mm".

    Parameters
    ----------
    key
        of the input, such as "profile.radius"
    stated_text
        standard uncertainty as the scene file states it
    value
        of the input in the scene's units; None for the load P or Q (or U, approach), whose
        uncertainty scales all values alike and is stated in per cent
    units
        of the scene, such as "N, mm, MPa"

    Raises
    ------
    ValueError
        For a unit that is not known, and for more than half of the value.
    """
    # Number and unit, "%" for a percentage.
    parsed_text = _number_and_unit(stated_text)
    assert parsed_text is not None  # the table was checked
    if parsed_text.unit == "%":
        return share_of(stated_text)
    kind: Kind = "stress" if key.endswith("young_modulus") else "length"
    try:
        factor_to_scene_units, _ = unit_factor(parsed_text.unit, kind, units)
    except ValueError as reason:
        # A file's column has a scale to state instead; an uncertainty has none.
        reason_text = str(reason).removesuffix("; use scale")
        raise ValueError(
            f"uncertainty.{key} = {shortened_repr(stated_text)} is refused: {reason_text}; write a"
            ' share, such as "1 %"'
        ) from reason
    assert value is not None  # loads are stated in per cent
    relative_uncertainty = parsed_text.number * factor_to_scene_units / value
    try:
        _require_small(relative_uncertainty, stated_text)
    except ValueError as reason:
        raise ValueError(f"uncertainty.{key} is refused: {reason}") from reason
    return relative_uncertainty


def _value_of_input(scene: HasInputs, key: str) -> float | None:
    """Value, in the scene's units, of the input that an uncertainty is stated for; None for a load,
    whose uncertainty scales all its values alike.

    `key` is "friction" or a load such as "normal_load" (no dot in it), "table.name", such as
    "profile.radius", or "table.body.name", such as "material.upper.poisson_ratio".

    Raises
    ------
    ValueError
        Where the scene has no such input, with what to state instead.
    """
    if "." not in key:
        return _value_of_load_input(scene, key)
    table_name, *body_names, name = key.split(".")
    # The part of the scene that has the input, or the reason why none has it.
    reason = ""
    part_of_scene: Any = getattr(scene, table_name)
    if table_name == "material":
        is_one_material = scene.material.alike
        if not body_names and not is_one_material:
            reason = "the bodies are of two materials; state it under upper and lower"
        elif body_names and is_one_material:
            reason = "both bodies are of one material; state it without upper and lower"
        part_of_scene = getattr(part_of_scene, body_names[0] if body_names else "upper")
    elif body_names:
        part_of_scene = getattr(part_of_scene, body_names[0])

    # The radius of cylinders, which is that of the profile, is no input of its own.
    if table_name == "profile" and scene.bodies.relative_radius() is not None:
        reason = "the profile follows from the cylinders; state the radius of the bodies"
    value = getattr(part_of_scene, name, None)
    if not reason and value is None:
        kind = getattr(part_of_scene, "kind", "")
        reason = (
            f"{table_name}{f' of kind {kind!r}' if kind else ''} has no {name} here; leave it out"
        )
    if reason:
        raise ValueError(f"uncertainty.{key} is refused: {reason}")
    assert value is not None
    return float(value)


def _value_of_load_input(scene: HasInputs, key: str) -> float | None:
    """Value of the friction coefficient, or phase lag of Q behind P [degrees], for an uncertainty
    stated under this `key`.

    None for P, Q, approach or displacement, which are scaled, and for the phase of harmonics, each
    of which has its own. The scene's table `load` states by `states_approach` whether the approach
    is prescribed in the place of P; by `is_driven`, whether a displacement in the place of Q.

    Raises
    ------
    ValueError
        Where the scene has no such input, with the one to state instead.
    """
    load_table = scene.load
    reason = ""
    value: float | None = None
    if key == "friction":
        value = scene.friction.coefficient
        if not value:
            reason = "the contact is frictionless; leave it out"
    elif key == "phase_degrees":
        # The lag is that of the prescribed tangential displacement, where there is one.
        lagging_input = getattr(load_table, "tangential_displacement", None) or load_table
        value = getattr(lagging_input, "phase_degrees", None)
        if not isinstance(load_table, EllipseLoad | HarmonicLoad):
            reason = (
                "an ellipse and harmonics have a phase, and the load of this scene is a"
                f" {load_table.kind.replace('_', ' ')}; leave it out"
            )
    elif key == "approach" and not load_table.states_approach:
        reason = "P is given here; state normal_load"
    elif key == "normal_load" and load_table.states_approach:
        reason = "the approach is prescribed in the place of P; state approach"
    elif key == "tangential_displacement" and not load_table.is_driven:
        reason = "Q is given here; state tangential_load"
    elif key == "tangential_load" and load_table.is_driven:
        reason = "U is prescribed in the place of Q; state tangential_displacement"
    if reason:
        raise ValueError(f"uncertainty.{key} is refused: {reason}")
    return value


# --------------------------------------------------------------------- the scene with moved inputs
def moved_scene(scene: S, changes: Mapping[str, float]) -> S:
    """Copy of a scene with some inputs changed by small amounts, to see how its solution depends on
    them; stated uncertainties and expected values are left out.

    Parameters
    ----------
    scene
        as it stands in its file
    changes
        key of an input, such as "profile.radius" -> relative change of its value;
        "phase_degrees" -> change of the phase in degrees

    Raises
    ------
    InputError
        Where a scene does not admit a changed value.

    Examples
    --------
    >>> from scenes import load_scene
    >>> scene = moved_scene(load_scene("hertz-paper"), {"friction": 0.1, "phase_degrees": 3.0})
    >>> round(scene.friction.coefficient, 12), scene.load.phase_degrees
    (1.1, 93.0)
    """
    # Parts of the scene with the entries that change; those of the load are collected first.
    changed_tables: dict[str, Any] = {"uncertainty": None, "expected": ()}
    changes_of_load: dict[str, float] = {}
    for key, change in changes.items():
        if key == "friction":
            changed_tables["friction"] = scene.friction.coefficient * (1 + change)
        elif "." not in key:
            changes_of_load[key] = change
        else:
            # The part of the scene that holds the input, such as "bodies", and its new value,
            # nested as in the scene file; merged with other changes of that part.
            table_name, entries = _changed_entry(scene, key, change)
            present_entries = changed_tables.get(table_name, {})
            changed_tables[table_name] = _merged_entries(present_entries, entries)

    if changes_of_load:
        changed_tables["load"] = _changed_load(scene, changes_of_load)
    # The profile of cylinders follows from their radii. `vary`: a checked copy with changed keys.
    if _changes_a_cylinder(scene, changed_tables):
        bodies = scene.bodies.vary(**changed_tables["bodies"])
        changed_tables["profile"] = {"radius": bodies.relative_radius()}
    return scene.vary(**changed_tables)


def _changed_entry(scene: HasInputs, key: str, change: float) -> tuple[str, dict[str, Any]]:
    """One input of a scene, changed by the relative `change`: the table of the scene that holds it,
    such as "bodies", and its new value, nested as in that table: {"upper": {"height": 1.1}}.

    `key` is "table.name", such as "profile.radius", or "table.body.name". One material of both
    bodies has "table.name".
    """
    table_name, *body_names, name = key.split(".")
    part_of_scene: Any = getattr(scene, table_name)
    if table_name == "material" and not body_names:
        part_of_scene = part_of_scene.upper
    for body_name in body_names:
        part_of_scene = getattr(part_of_scene, body_name)
    # Nested as in the scene: the body's name around the entry.
    entries: dict[str, Any] = {name: getattr(part_of_scene, name) * (1 + change)}
    for body_name in body_names:
        entries = {body_name: entries}
    return table_name, entries


def _merged_entries(entries: dict[str, Any], further_entries: dict[str, Any]) -> dict[str, Any]:
    """Entries of one table of a scene from two mappings, nested ones merged."""
    all_entries = dict(entries)
    for key, value in further_entries.items():
        if isinstance(value, dict) and isinstance(all_entries.get(key), dict):
            all_entries[key] = _merged_entries(all_entries[key], value)
        else:
            all_entries[key] = value
    return all_entries


def _changes_a_cylinder(scene: HasInputs, changed_tables: Mapping[str, Any]) -> bool:
    """Whether the changed tables of a scene hold another radius of a body that is a cylinder."""
    changed_bodies = changed_tables.get("bodies", {})
    return any(
        isinstance(getattr(scene.bodies, body), Cylinder) and "radius" in entries
        for body, entries in changed_bodies.items()
    )


def _changed_load(scene: HasInputs, changes: Mapping[str, float]) -> dict[str, Any]:
    """Changed entries of a scene's table `load`: P and Q scaled all along the load path, and the
    phase lag of Q behind P increased.

    Under displacement control, the approach is scaled in the place of P and the relative tangential
    displacement in the place of Q. `changes` maps "normal_load", "tangential_load", "approach" and
    "tangential_displacement" to relative changes, and "phase_degrees" to degrees.
    """
    load_table = scene.load
    # Factors of P (or the approach) and Q (or U), and the added lag in degrees.
    normal_factor = 1 + changes.get("normal_load", changes.get("approach", 0.0))
    displacement_change = changes.get("tangential_displacement", 0.0)
    tangential_factor = 1 + changes.get("tangential_load", displacement_change)
    added_lag = changes.get("phase_degrees", 0.0)

    def scaled_points(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        """Points (P, Q) with both loads scaled."""
        return [
            (normal_factor * normal_load, tangential_factor * tangential_load)
            for normal_load, tangential_load in points
        ]

    if isinstance(load_table, TimeSeriesLoad):  # a record has no initial loading of its own
        return _changed_record(load_table, normal_factor, tangential_factor)
    # Points (P, Q) in order; or the form of the curve to the cycle, "straight" or "parabola".
    initial_loading = load_table.initial_loading
    if isinstance(initial_loading, tuple):
        initial_loading = scaled_points(initial_loading)
    entries: dict[str, Any] = {}
    if isinstance(load_table, EllipseLoad):
        entries = _changed_ellipse(load_table, normal_factor, tangential_factor, added_lag)
    elif isinstance(load_table, HarmonicLoad):
        entries = _changed_harmonics(load_table, normal_factor, tangential_factor, added_lag)
    elif isinstance(load_table, PolygonLoad):
        entries = {"cycle": scaled_points(load_table.cycle)}
    else:
        entries = _changed_functions(load_table, normal_factor, tangential_factor)
    return entries | {"initial_loading": initial_loading}


def _changed_ellipse(
    load: EllipseLoad, normal_factor: float, tangential_factor: float, added_lag: float
) -> dict[str, Any]:
    """Changed entries of the table of an elliptical load path: P and Q scaled by the two factors,
    and the phase lag of Q behind P increased by `added_lag` [degrees].

    Under displacement control, the approach and the relative tangential displacement U stand in the
    place of P and Q; they are None where the loads are given. A lag beyond 180 degrees becomes the
    same angle between -180 and 180.
    """
    entries: dict[str, Any] = {}
    if load.approach is not None:
        entries["approach"] = {
            "mean": normal_factor * load.approach.mean,
            "amplitude": normal_factor * load.approach.amplitude,
        }
    else:
        entries["mean_normal_load"] = normal_factor * load.mean_normal_load
        entries["normal_amplitude"] = normal_factor * load.normal_amplitude
    displacement = load.tangential_displacement
    if displacement is not None:
        entries["tangential_displacement"] = {
            "mean": tangential_factor * displacement.mean,
            "amplitude": tangential_factor * displacement.amplitude,
            "phase_degrees": _wrapped_degrees(displacement.phase_degrees + added_lag),
        }
    else:
        entries["mean_tangential_load"] = tangential_factor * load.mean_tangential_load
        entries["tangential_amplitude"] = tangential_factor * load.tangential_amplitude
        entries["phase_degrees"] = _wrapped_degrees(load.phase_degrees + added_lag)
    return entries


def _wrapped_degrees(degrees: float) -> float:
    """The same angle between -180 and 180 degrees.

    >>> _wrapped_degrees(183.0), _wrapped_degrees(90.0)
    (-177.0, 90.0)
    """
    return degrees if -180 <= degrees <= 180 else (degrees + 180) % 360 - 180


def _changed_harmonics(
    load: HarmonicLoad, normal_factor: float, tangential_factor: float, added_lag: float
) -> dict[str, Any]:
    """Changed entries of the table of a load by Fourier series: P and Q scaled by the two factors,
    and Q delayed behind P by `added_lag` [degrees] of the cycle: its k-th harmonic by k times that.

    Under displacement control, the approach and the relative tangential displacement U stand in the
    place of P and Q; they are None where the loads are given. A harmonic is (amplitude, phase lag
    in degrees) of k = 1, 2, ...
    """
    entries: dict[str, Any] = {}
    approach = load.approach
    normal_harmonics = [
        (normal_factor * amplitude, phase)
        for amplitude, phase in (load.normal_harmonics if approach is None else approach.harmonics)
    ]
    if approach is not None:
        entries["approach"] = {
            "mean": normal_factor * approach.mean,
            "harmonics": normal_harmonics,
        }
    else:
        entries["mean_normal_load"] = normal_factor * load.mean_normal_load
        entries["normal_harmonics"] = normal_harmonics

    displacement = load.tangential_displacement
    stated_harmonics = load.tangential_harmonics if displacement is None else displacement.harmonics
    tangential_harmonics = [
        (tangential_factor * amplitude, phase + k * added_lag)
        for k, (amplitude, phase) in enumerate(stated_harmonics, 1)
    ]
    if displacement is not None:
        entries["tangential_displacement"] = {
            "mean": tangential_factor * displacement.mean,
            "harmonics": tangential_harmonics,
        }
    else:
        entries["mean_tangential_load"] = tangential_factor * load.mean_tangential_load
        entries["tangential_harmonics"] = tangential_harmonics
    return entries


def _changed_record(
    load: TimeSeriesLoad, normal_factor: float, tangential_factor: float
) -> dict[str, Any]:
    """Changed entries of the table of a recorded load: rows (n, 3) of time, P and Q, with P and Q
    scaled by the two factors.

    The rows are those that the load path goes through (`kept_rows`), or all `rows` where bulk
    stress or tilt (`has_bulk_or_tilt`) has an entry for each. The keys that chose them (start and
    end, averaging, thresholds) are reset: on scaled loads a threshold would choose other rows.
    """
    factors = np.array([1.0, normal_factor, tangential_factor])
    if load.has_bulk_or_tilt:  # their lists have an entry for each row: no row may go
        return {"rows": load.rows.values * factors}
    return {
        "rows": load.kept_rows() * factors,
        "start": None,
        "end": None,
        "average": 1,
        "reduce": None,
        "threshold": None,
        "least_normal_load": None,
    }


def _changed_functions(
    load: CallableLoad, normal_factor: float, tangential_factor: float
) -> dict[str, Any]:
    """Changed entries of a load by functions of time: its P and Q, `normal_load` and
    `tangential_load`, scaled by the two factors.
    """

    def scaled(function: Callable[[Any], Any], factor: float) -> Callable[[Any], Any]:
        """The function times the factor."""
        return lambda time: factor * function(time)

    return {
        "normal_load": scaled(load.normal_load, normal_factor),
        "tangential_load": scaled(load.tangential_load, tangential_factor),
    }
