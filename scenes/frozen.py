"""What every table of keys has in common: frozen, checked at every door, changed by `vary` alone,
refused in one sentence.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NoReturn, Self, TypeVar, cast

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    PlainSerializer,
    TypeAdapter,
    ValidationError,
    WithJsonSchema,
    field_validator,
)
from pydantic_core import CoreSchema, ErrorDetails

from scenes.arrays import LARGEST
from scenes.errors import InputError, shown

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

_MOST_KEYS_NAMED = 4  # keys at fault beside the first that a refusal names

# What no scene can state, by how a word of a key begins that would state it: section "What is
# neglected" of docs/theory.md.
_NEGLECTED_PHYSICS = {
    ("wear", "archard"): "wear is not modelled",
    (
        "plastic",
        "yield",
        "hardening",
        "hardness",
    ): "the materials are linear elastic, without plasticity",
    ("creep", "visco", "relaxation"): "the materials are linear elastic, without creep",
    ("temperature", "thermal", "heat"): "temperature is not modelled",
    ("fatigue", "life", "crack"): "fatigue life is not computed",
    ("inertia", "mass", "density", "gravity"): "the contact is quasi-static, without inertia",
    (
        "static",
        "kinetic",
        "velocity",
        "frequency",
        "rate",
    ): "friction has one coefficient, and nothing depends on the rate",
    ("adhesion", "adhesive", "roughness"): "the faces are smooth and do not adhere",
    ("thickness",): "the bodies are in plane strain, and loads are per unit thickness",
}
# Rules in plain words, by pydantic's types of faults.
RULES = {
    "missing": "a point is [P, Q]",
    "tuple_type": "should be a list in square brackets",
    "list_type": "should be a list in square brackets",
    "model_type": "should be a table of keys",
    "model_attributes_type": "should be a table of keys",
}
# What loads state, asked for elsewhere or by another word.
_WORDS_OF_LOADS = (
    "bulk",
    "remote",
    "moment",
    "tilt",
    "rotation",
    "inclination",
    "misalignment",
    "eccentricity",
)


def refusal(faults: ValidationError, keys: Any, model: type[Frozen]) -> str:
    """One sentence on why a table of keys is refused: the worst fault with its key, value, rule and
    what to do, then the names of other keys at fault.

    Parameters
    ----------
    faults
        what the validation by pydantic reports
    keys
        as they stand in the file, tables as dicts and lists
    model
        class of the table, such as a scene or its load
    """
    # Unknown keys first: a misspelt key is a missing one too. Then the deepest: of the alternatives
    # for a table the one that got farthest.
    errors = sorted(
        faults.errors(), key=lambda fault: (fault["type"] != "extra_forbidden", -len(fault["loc"]))
    )
    worst_fault = errors[0]
    key = _key(worst_fault, keys)
    faulty_keys = dict.fromkeys(_key(error, keys) for error in errors)
    other_faults_text = _also([name for name in faulty_keys if name not in (key, "")])
    return _fault_in_words(worst_fault, key, model) + other_faults_text


def _fault_in_words(fault: ErrorDetails, key: str, model: type[Frozen]) -> str:
    """One fault of a table of keys as a sentence: key, value, rule and what to do.

    `fault` is pydantic's, `key` the full name of its key in the file, `model` the class of the
    table.
    """
    value = fault["input"]
    rule = RULES.get(fault["type"]) or fault["msg"].removeprefix("Value error, ").removeprefix(
        "Input "
    )
    match fault["type"]:
        case "extra_forbidden":
            unknown_key = str(fault["loc"][-1])
            # What is unknown here may be known in another table.
            hint = (
                neglected(unknown_key)
                or f"{did_you_mean(unknown_key, keys_of_all_tables(model) - {unknown_key})}"
                f" {model.keys_listed} lists the keys"
            )
            return f"unknown key {key} = {shown(value)};{hint}"
        case "missing" if isinstance(value, dict):
            return f"the key {key} is missing; {model.keys_listed} lists the keys"
        case "key_missing":
            missing_key = f"{key}{'.' if key else ''}{fault['ctx']['key']}"
            return f"the key {missing_key} is missing; {model.keys_listed} lists the keys"
        case "union_tag_not_found":
            return f"the key {key}.kind is missing; {model.keys_listed} lists the kinds"
        case "union_tag_invalid":
            kinds = fault["ctx"]["expected_tags"].replace(", ", " or ")
            return f"{key}.kind = {shown(fault['ctx']['tag'])} is refused: should be {kinds}"
        case "too_long":
            rule = f"should have at most {fault['ctx']['max_length']} entries"
        case "value_error":
            return f"{key} is refused: {rule}" if key else rule
    return f"{key} = {shown(value)} is refused: {rule}"


@cache
def keys_of_all_tables(model: type[Frozen]) -> frozenset[str]:
    """Keys of a model and of every table in it. The schema is made once for each model, since it
    takes longer than many refusals.
    """
    schema = model.model_json_schema()
    tables = (schema, *schema.get("$defs", {}).values())
    return frozenset(name for table in tables for name in table.get("properties", {}))


def _also(keys: Sequence[str]) -> str:
    """Names of further keys at fault, in brackets, for the end of a message: of many the first
    four, and how many more.

    >>> _also(["friction.coefficient"]), _also(list("abcdef")), _also([])
    (' (also at fault: friction.coefficient)', ' (also at fault: a, b, c, d and 2 more, named once
    these are mended)', '')
    """
    remainder = (
        f" and {len(keys) - _MOST_KEYS_NAMED} more, named once these are mended"
        if len(keys) > _MOST_KEYS_NAMED
        else ""
    )
    return f" (also at fault: {', '.join(keys[:_MOST_KEYS_NAMED])}{remainder})" if keys else ""


def neglected(word: str) -> str:
    """Reason why an unknown key, `word`, cannot be stated: the physics it names is neglected, or it
    belongs to the loads; with a blank before it, empty where neither is the case.

    >>> neglected("yield_stress")
    " the materials are linear elastic, without plasticity: docs/theory.md, 'What is neglected'"
    >>> neglected("phase")
    ''
    """
    words = re.split("[^a-z]+", word.lower())
    if any(part.startswith(_WORDS_OF_LOADS) for part in words):
        return (
            " bulk_stress_lower, bulk_stress_upper, tilt, moment and line_of_action are keys of"
            " [load]: docs/scene-keys.md"
        )
    for stems, limit in _NEGLECTED_PHYSICS.items():
        if any(part.startswith(stems) for part in words):
            return f" {limit}: docs/theory.md, 'What is neglected'"
    return ""


def did_you_mean(word: str, known_words: Iterable[str]) -> str:
    """Suggest the known key that a misspelt `word` probably stands for, as a question with a blank
    before it; empty where none is near.

    >>> did_you_mean("radias", ["radius", "kind"]), did_you_mean("zzz", ["radius", "kind"])
    (' did you mean radius?', '')
    >>> did_you_mean("phase", ["base", "phase_degrees"])
    ' did you mean phase_degrees?'
    """
    words = sorted(known_words, key=len)
    # A key cut short, or with a unit behind it, is nearer than one with as many letters in common.
    words_of_same_start = [
        key
        for key in words
        if min(len(key), len(word)) > 2 and (key.startswith(word) or word.startswith(key))
    ]
    candidates = words_of_same_start or difflib.get_close_matches(word, words, n=1)
    return f" did you mean {candidates[0]}?" if candidates else ""


def _key(fault: ErrorDetails, keys: Any) -> str:
    """Full name of the key that a fault of validation is about, as in "load.points.3": pydantic's
    location of it without parts that do not stand in the file, whose table is `keys`.
    """
    path: list[str] = []
    level: Any = keys  # the part of the file that the path has reached
    for part in fault["loc"]:
        if isinstance(part, int) and isinstance(level, list) and part < len(level):
            level = level[part]
        elif isinstance(level, dict) and part in level:
            level = level[str(part)]
        elif fault["type"] == "missing" and isinstance(level, dict) and part == fault["loc"][-1]:
            level = None
        else:
            continue
        path.append(str(part))
    return ".".join(path)


def _numbers(value: Any) -> Iterator[float]:
    """Numbers in the value of a key or in its tuples; long tables check their own."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, tuple) and len(value) < 10_000:
        for part in value:
            yield from _numbers(part)


def a_scale(number: float) -> float:
    """A positive number as it is; ValueError where its square would be 0."""
    if number < 1 / LARGEST:
        raise ValueError(
            f"{number:g} is below {1 / LARGEST:g}, and its square would be 0: choose other units"
        )
    return number


class _OneDoor(ModelMetaclass):
    """The constructor refuses in one sentence, as every other door does.

    With an `__init__` of our own pydantic would forget that it reads JSON.
    """

    def __call__(cls, *_nothing: Any, **keys: Any) -> Any:
        try:
            return super().__call__(*_nothing, **keys)
        except ValidationError as faults:
            sentence = refusal(faults, _plain(keys), cast("type[Frozen]", cls))
            raise InputError(f"{cls.__name__}: {sentence}") from faults


class Frozen(BaseModel, metaclass=_OneDoor):
    """A frozen table of keys. Whatever is put into another table is checked again there, however it
    was made.
    """

    # A scene builds the validators of its parts with its own: theirs alone are built where a part
    # is first made by itself.
    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        revalidate_instances="always",
        defer_build=True,
    )

    keys_listed: ClassVar[str] = "`halfplane schema`"
    """Where a user finds the keys."""
    written: ClassVar[tuple[str, ...]] = ()
    """Keys that were written with the others and are not right for other values."""

    @field_validator("*")
    @classmethod
    def _can_be_squared(cls, value: Any) -> Any:
        """Refuse numbers of any key that are so large that their squares are no numbers
        (ValueError); the value itself otherwise.
        """
        for number in _numbers(value):
            if abs(number) > LARGEST:
                raise ValueError(
                    f"{number:g} is above {LARGEST:g}, and its square would be no number: choose"
                    " other units"
                )
        return value

    def vary(self, /, **changes: Any) -> Self:
        """A copy of a scene, or of a part of one, with some values changed; checked like a new one.

        Scenes are frozen: this is the only way to change one from Python.

        Parameters
        ----------
        changes
            key -> value. A value is what the constructor takes: a number, a list, a table. A
            mapping given for a table of keys changes those keys and keeps the others, at every
            depth. A mapping with another `kind` than the table has replaces it whole: nothing
            of an ellipse is right for a polygon. A list replaces the whole list.

        Raises
        ------
        InputError
            One sentence with key, value and rule: for an unknown key, or a value that the scene
            file would not be allowed either.

        Examples
        --------
        >>> from scenes import load_scene
        >>> scene = load_scene("hertz-paper").vary(friction=0.6, load={"phase_degrees": 60})
        >>> scene.friction.coefficient, scene.load.phase_degrees, scene.load.kind
        (0.6, 60.0, 'ellipse')
        >>> scene.vary(frictoin=0.6)
        Traceback (most recent call last):
        scenes.errors.InputError: vary: unknown key frictoin = 0.6; did you mean friction?
        `halfplane schema` lists the keys
        """
        return checked(type(self), self.merged(changes), "vary")

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """The keys of this table that its user gave, with some changed; not checked yet.

        Keys that the program itself has written are left out, since they are not right for other
        values. A change that is a mapping of the same `kind` as a table is merged into that table,
        any other replaces the value. `changes` maps keys to new values.
        """
        given_names = self.model_fields_set - {*self.written}
        keys = {
            name: given_value for name, given_value in self if name == "kind" or name in given_names
        }
        for name, new_value in changes.items():
            is_key = name in type(self).model_fields
            present_value = getattr(self, name) if is_key else None
            kind = getattr(present_value, "kind", None)
            if (
                isinstance(present_value, Frozen)
                and isinstance(new_value, Mapping)
                and new_value.get("kind", kind) == kind
            ):
                keys[name] = present_value.merged(new_value)
            else:
                keys[name] = new_value
        return keys

    def __dir__(self) -> list[str]:
        """Keys and methods of a table, which tab completion shows; not those of pydantic."""
        hidden_names = {*dir(BaseModel), "merged", "keys_listed", "written", "datum"}
        return sorted(
            name
            for name in super().__dir__()
            if name not in hidden_names and not name.startswith("_")
        )

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """pydantic's copy; with `update` it is `vary`, for pydantic itself checks nothing of an
        update.
        """
        return self.vary(**update) if update else super().model_copy(deep=deep)

    def copy(self, **_options: Any) -> NoReturn:
        """pydantic's earlier copy, which checks nothing: refused."""
        raise InputError("copy checks nothing: take vary(key=value)")


@dataclass(frozen=True)
class ShortForm:
    """Mark of a field, for the JSON schema: `form` may stand there in place of the table of
    keys.
    """

    form: Any

    def __get_pydantic_json_schema__(
        self, table: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"anyOf": [handler(table), handler(TypeAdapter(self.form).core_schema)]}


PositiveNumber = Annotated[float, Field(gt=0)]
Positive = Annotated[PositiveNumber, AfterValidator(a_scale)]
"""A scale: its square and the inverse of that are numbers."""


def _function(value: Any) -> Any:
    if value is not None and not callable(value):
        raise ValueError(
            "a Python function is needed: such a scene can only be built in Python, not read from a"
            " file"
        )
    return value


def _refuse(function: Any) -> str:
    raise ValueError(
        f"the scene holds the Python function {getattr(function, '__name__', 'without a name')},"
        " which can't be written to a file"
    )


PythonFunction = Annotated[
    Callable[[Any], Any],
    BeforeValidator(_function),
    PlainSerializer(_refuse, when_used="json-unless-none"),
    WithJsonSchema({"not": {}, "description": "a Python function: only in scenes built in Python"}),
]


M = TypeVar("M", bound=Frozen)


def validated(table: M, model: type[Frozen]) -> M:
    """Check what a caller passes as a scene, or as a part of one, before it is used; the checked
    table of keys.

    Parameters
    ----------
    table
        what the caller passes
    model
        class that it has to be of, such as Scene

    Raises
    ------
    InputError
        One sentence: for another class, and for values that were set past the checks
        (`model_construct`) and do not pass.

    Examples
    --------
    >>> from scenes import Elastic
    >>> validated(Elastic.model_construct(young_modulus=1.0, poisson_ratio=0.7), Elastic)
    Traceback (most recent call last):
    scenes.errors.InputError: Elastic: poisson_ratio = 0.7 is refused: should be less than 0.5
    """
    if not isinstance(table, model):
        cause = (
            "; load_scene reads one from the library or a file" if model.__name__ == "Scene" else ""
        )
        raise InputError(f"a {model.__name__} is needed, not {shown(table)}{cause}")
    name = getattr(table, "name", "")
    return checked(
        type(table), table, f"{model.__name__} {shown(name)}" if name else type(table).__name__
    )


def checked(
    model: type[M], keys: Any, where: str = "", *, of_file: bool = False, folder: Path = Path()
) -> M:
    """Make a scene, or a part of one, from keys and values, with all checks: the one way to do so.

    Parameters
    ----------
    model
        class of the table, such as Scene
    keys
        key -> value, or a table of that class
    where
        how the message of a refusal begins, as in "vary"
    of_file
        whether the keys come from a file: then "1.0" and true are no numbers
    folder
        in which files lie that the keys name

    Raises
    ------
    InputError
        One sentence: key, value, rule and what to do.
    """
    units = keys.get("units") if isinstance(keys, Mapping) else getattr(keys, "units", None)
    context = {"folder": folder} | ({"units": units} if isinstance(units, str) else {})
    prefix = f"{where}: " if where else ""
    try:
        if of_file:  # as JSON, where strict still lets 1 be a float and a list a tuple
            return model.model_validate_json(
                json.dumps(keys, default=str), strict=True, context=context
            )
        return model.model_validate(keys, context=context)
    except ValidationError as faults:
        raise InputError(f"{prefix}{refusal(faults, _plain(keys), model)}") from faults
    except RecursionError as reason:  # JSON with brackets by the hundred
        raise InputError(f"{prefix}its tables are nested too deeply") from reason


def _plain(table: Any) -> Any:
    """Models as tables of their keys, at every depth: what a refusal looks its keys up in."""
    if isinstance(table, BaseModel):
        table = table.__dict__
    if isinstance(table, Mapping):
        return {key: _plain(value) for key, value in table.items()}
    return [_plain(value) for value in table] if isinstance(table, list | tuple) else table
