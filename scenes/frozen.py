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

from scenes.arrays import LARGEST_NUMBER
from scenes.errors import InputError, shortened_repr, value_or_class

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
_RULES_BY_FAULT_TYPE = {
    "missing": "a point is [P, Q]",
    "tuple_type": "should be a list in square brackets",
    "list_type": "should be a list in square brackets",
    "model_type": "should be a table of keys",
    "model_attributes_type": "should be a table of keys",
}
# Text that is a number, with a unit or without, such as "210 GPa".
_NUMBER_WITH_UNIT = re.compile(
    r"\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*[^\d\s.,]*\s*", re.IGNORECASE
)
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


def refusal_sentence(faults: ValidationError, keys: Any, model: type[Frozen]) -> str:
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

    def rank(fault: ErrorDetails) -> tuple[bool, int]:
        """Unknown keys first: a misspelt key is a missing one too. Then the deepest: of the
        alternatives for a table the one that got farthest.
        """
        return fault["type"] != "extra_forbidden", -len(fault["loc"])

    ranked_faults = sorted(faults.errors(), key=rank)
    worst_fault = ranked_faults[0]
    # Full names of the keys at fault, as in "load.points.3".
    worst_key = _key_of_fault(worst_fault, keys)
    faulty_keys = dict.fromkeys(_key_of_fault(fault, keys) for fault in ranked_faults)
    further_keys = [key for key in faulty_keys if key not in (worst_key, "")]
    return _fault_in_words(worst_fault, worst_key, model) + _further_keys_in_words(further_keys)


def _fault_in_words(fault: ErrorDetails, key: str, model: type[Frozen]) -> str:
    """One fault of a table of keys as a sentence: key, value, rule and what to do.

    Parameters
    ----------
    fault
        as pydantic reports it: "type" of the fault, "input" (the value), "msg" (pydantic's rule in
        words), "loc" (where it is), and for some types "ctx" with more on the rule
    key
        full name of its key in the file, as in "load.points.3"
    model
        class of the table, whose `place_of_key_list` says where a user finds the keys
    """
    value = fault["input"]
    pydantic_rule = fault["msg"].removeprefix("Value error, ").removeprefix("Input ")
    # A rule in plain words, if there is one for this type of fault.
    rule = _RULES_BY_FAULT_TYPE.get(fault["type"]) or pydantic_rule
    match fault["type"]:
        case "extra_forbidden":
            unknown_key = str(fault["loc"][-1])
            # What is unknown here may be known in another table.
            hint = (
                reason_of_unknown_key(unknown_key)
                or f"{did_you_mean(unknown_key, keys_of_all_tables(model) - {unknown_key})}"
                f" {model.place_of_key_list} lists the keys"
            )
            return f"unknown key {key} = {shortened_repr(value)};{hint}"
        case "missing" if isinstance(value, dict):
            return f"the key {key} is missing; {model.place_of_key_list} lists the keys"
        case "key_missing":
            missing_key = f"{key}{'.' if key else ''}{fault['ctx']['key']}"
            return f"the key {missing_key} is missing; {model.place_of_key_list} lists the keys"
        case "union_tag_not_found":
            return f"the key {key}.kind is missing; {model.place_of_key_list} lists the kinds"
        case "union_tag_invalid":
            kinds = fault["ctx"]["expected_tags"].replace(", ", " or ")
            return (
                f"{key}.kind = {shortened_repr(fault['ctx']['tag'])} is refused: should be {kinds}"
            )
        case "too_long":
            rule = f"should have at most {fault['ctx']['max_length']} entries"
        case "float_type" | "int_type" if _NUMBER_WITH_UNIT.fullmatch(str(value)):
            rule = f"{rule}; write it without quotation marks and unit"
        case "value_error":
            return f"{key} is refused: {rule}" if key else rule
    return f"{key} = {shortened_repr(value)} is refused: {rule}"


@cache
def keys_of_all_tables(model: type[Frozen]) -> frozenset[str]:
    """Keys of a model and of every table in it. The schema is made once for each model, since it
    takes longer than many refusals.
    """
    schema = model.model_json_schema()
    tables = (schema, *schema.get("$defs", {}).values())
    return frozenset(name for table in tables for name in table.get("properties", {}))


def _further_keys_in_words(keys: Sequence[str]) -> str:
    """Names of further keys at fault, in brackets, for the end of a message: of many the first
    four, and how many more. Empty for no keys.

    >>> _further_keys_in_words(["friction.coefficient"]), _further_keys_in_words([])
    (' (also at fault: friction.coefficient)', '')
    >>> _further_keys_in_words(list("abcdef"))
    ' (also at fault: a, b, c, d and 2 more, named once these are mended)'
    """
    if not keys:
        return ""
    # _MOST_KEYS_NAMED: 4 keys
    names = ", ".join(keys[:_MOST_KEYS_NAMED])
    n_unnamed = len(keys) - _MOST_KEYS_NAMED
    remainder = f" and {n_unnamed} more, named once these are mended" if n_unnamed > 0 else ""
    return f" (also at fault: {names}{remainder})"


def reason_of_unknown_key(word: str) -> str:
    """Reason why no scene has the unknown key `word`, for the end of a message, with a blank before
    it: physics that the model neglects, or a key that belongs to the table of the loads.

    Empty where neither is the case. A key is recognised by how the words in it begin.

    >>> reason_of_unknown_key("yield_stress")
    " the materials are linear elastic, without plasticity: docs/theory.md, 'What is neglected'"
    >>> reason_of_unknown_key("phase")
    ''
    """
    # `_WORDS_OF_LOADS` and `_NEGLECTED_PHYSICS` hold beginnings of words, such as "bulk" and
    # "wear".
    words_in_key = re.split("[^a-z]+", word.lower())
    if any(word_in_key.startswith(_WORDS_OF_LOADS) for word_in_key in words_in_key):
        return (
            " bulk_stress_lower, bulk_stress_upper, tilt, moment and line_of_action are keys of"
            " [load]: docs/scene-keys.md"
        )
    for word_beginnings, assumption in _NEGLECTED_PHYSICS.items():
        if any(word_in_key.startswith(word_beginnings) for word_in_key in words_in_key):
            return f" {assumption}: docs/theory.md, 'What is neglected'"
    return ""


def did_you_mean(word: str, known_words: Iterable[str]) -> str:
    """Suggest the known key that a misspelt `word` probably stands for, as a question with a blank
    before it; empty where none of the `known_words` is near.

    >>> did_you_mean("radias", ["radius", "kind"]), did_you_mean("zzz", ["radius", "kind"])
    (' did you mean radius?', '')
    >>> did_you_mean("phase", ["base", "phase_degrees"])
    ' did you mean phase_degrees?'
    """
    words = sorted(known_words, key=len)
    # A key cut short, or with a unit behind it, is nearer than one with as many letters in common.
    words_of_same_start = [
        known_word
        for known_word in words
        if min(len(known_word), len(word)) > 2
        and (known_word.startswith(word) or word.startswith(known_word))
    ]
    candidates = words_of_same_start or difflib.get_close_matches(word, words, n=1)
    return f" did you mean {candidates[0]}?" if candidates else ""


def _key_of_fault(fault: ErrorDetails, keys: Any) -> str:
    """Full name in the file of the key that a fault is about, as in "load.points.3".

    `fault["loc"]` is pydantic's location of the fault, names and numbers from the outermost table
    to the key. It also names alternatives of a model, such as kinds; these do not stand in the file
    and are left out. `keys` is the table of the file, as dicts and lists.
    """
    name_parts: list[str] = []
    value_at_path: Any = keys
    for part in fault["loc"]:
        is_last = part == fault["loc"][-1]
        if isinstance(part, int) and isinstance(value_at_path, list) and part < len(value_at_path):
            value_at_path = value_at_path[part]
        elif isinstance(value_at_path, dict) and part in value_at_path:
            value_at_path = value_at_path[str(part)]
        elif fault["type"] == "missing" and isinstance(value_at_path, dict) and is_last:
            value_at_path = None
        else:
            continue
        name_parts.append(str(part))
    return ".".join(name_parts)


def _numbers_in(value: Any) -> Iterator[float]:
    """Numbers in the value of a key or in its tuples; long tables check their own."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, tuple) and len(value) < 10_000:
        for part in value:
            yield from _numbers_in(part)


def require_squarable(number: float) -> float:
    """A positive number as it is; ValueError for one below 1e-100, since inverses of products of
    such numbers may overflow.
    """
    # LARGEST_NUMBER: 1e100
    if number < 1 / LARGEST_NUMBER:
        raise ValueError(
            f"{number:g} is below {1 / LARGEST_NUMBER:g}, too small to compute with: choose other"
            " units"
        )
    return number


class _RefusalsInOneSentence(ModelMetaclass):
    """Metaclass of tables of keys: their constructor refuses in one sentence, as `checked` does.

    With an `__init__` of our own pydantic would forget that it reads JSON.
    """

    def __call__(cls, *_nothing: Any, **keys: Any) -> Any:
        try:
            return super().__call__(*_nothing, **keys)
        except ValidationError as faults:
            sentence = refusal_sentence(faults, _without_models(keys), cast("type[Frozen]", cls))
            raise InputError(f"{cls.__name__}: {sentence}") from faults


class Frozen(BaseModel, metaclass=_RefusalsInOneSentence):
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

    place_of_key_list: ClassVar[str] = "`halfplane schema`"
    """Where a user finds the keys."""
    keys_of_program: ClassVar[tuple[str, ...]] = ()
    """Keys that the program adds to those of the user, such as the record of a fit: they are not
    right for other values.
    """

    @field_validator("*")
    @classmethod
    def _can_be_squared(cls, value: Any) -> Any:
        """Refuse numbers of any key above 1e100 in size, since products of such numbers may
        overflow (ValueError); the value itself otherwise.
        """
        # LARGEST_NUMBER: 1e100, whose square is still a number
        for number in _numbers_in(value):
            if abs(number) > LARGEST_NUMBER:
                raise ValueError(
                    f"{number:g} is above {LARGEST_NUMBER:g}, too large to compute with: choose"
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
        # `merged`: all keys with the changes, which `checked` validates.
        return checked(type(self), self.merged(changes), "vary")

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Keys and values that the user gave for this table, some of them changed: what a changed
        copy is made from. Nothing is validated yet.

        `changes` maps keys to new values. A mapping given for a key whose value is a table of the
        same `kind` is merged into that table; any other value replaces the present one. Keys that
        the program itself has written (`keys_of_program`), such as the record of a fit, are left
        out: they are not right for other values.
        """
        # pydantic's `model_fields_set`: keys that were given; `model_fields`: all keys of a table.
        given_keys = self.model_fields_set - {*self.keys_of_program}
        merged_values = {key: value for key, value in self if key == "kind" or key in given_keys}
        for key, changed_value in changes.items():
            is_known = key in type(self).model_fields
            present_value = getattr(self, key) if is_known else None
            present_kind = getattr(present_value, "kind", None)
            if (
                isinstance(present_value, Frozen)
                and isinstance(changed_value, Mapping)
                and changed_value.get("kind", present_kind) == present_kind
            ):
                merged_values[key] = present_value.merged(changed_value)
            else:
                merged_values[key] = changed_value
        return merged_values

    def __dir__(self) -> list[str]:
        """Keys and methods of a table, which tab completion shows; not those of pydantic."""
        hidden_names = {*dir(BaseModel), "merged", "place_of_key_list", "keys_of_program", "datum"}
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
Positive = Annotated[PositiveNumber, AfterValidator(require_squarable)]
"""A scale: from 1e-100 to 1e100, so that its square and the inverse of that are numbers."""


def _require_function(value: Any) -> Any:
    """The value of a key for a Python function as it is; ValueError for what cannot be called."""
    if value is not None and not callable(value):
        raise ValueError(
            "a Python function is needed: such a scene can only be built in Python, not read from a"
            " file"
        )
    return value


def _refuse_to_write(function: Any) -> str:
    """ValueError: a scene that holds a Python function can't be written to a file."""
    raise ValueError(
        f"the scene holds the Python function {getattr(function, '__name__', 'without a name')},"
        " which can't be written to a file"
    )


PythonFunction = Annotated[
    Callable[[Any], Any],
    BeforeValidator(_require_function),
    PlainSerializer(_refuse_to_write, when_used="json-unless-none"),
    WithJsonSchema({"not": {}, "description": "a Python function: only in scenes built in Python"}),
]


M = TypeVar("M", bound=Frozen)


def validated(table: M, model: type[Frozen]) -> M:
    """Check a scene, or a part of one, that a Python caller passes, before it is used: a checked
    copy.

    Parameters
    ----------
    table
        what the caller passes
    model
        class that it has to be of, such as Scene

    Raises
    ------
    InputError
        One sentence: for another class, and for values that do not pass, set by pydantic's
        `model_construct`, which checks nothing.

    Examples
    --------
    >>> from scenes import Elastic
    >>> validated(Elastic.model_construct(young_modulus=1.0, poisson_ratio=0.7), Elastic)
    Traceback (most recent call last):
    scenes.errors.InputError: Elastic: poisson_ratio = 0.7 is refused: should be less than 0.5
    """
    if not isinstance(table, model):
        advice = (
            "; load_scene reads one from the library or a file" if model.__name__ == "Scene" else ""
        )
        raise InputError(f"a {model.__name__} is needed, not {value_or_class(table)}{advice}")
    name = getattr(table, "name", "")
    message_begin = f"{model.__name__} {shortened_repr(name)}" if name else type(table).__name__
    return checked(type(table), table, message_begin)


def checked(
    model: type[M], keys: Any, where: str = "", *, of_file: bool = False, folder: Path = Path()
) -> M:
    """Make a scene, or a part of one, from keys and values, with all checks: the one way to do so.

    Parameters
    ----------
    model
        class of the table of keys, such as Scene
    keys
        a mapping of keys to values, or an instance of `model`, which is checked again
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
    # What the validation needs beside the keys: folder of files, and units of the scene.
    context: dict[str, Any] = {"folder": folder}
    if isinstance(units, str):
        context["units"] = units
    message_begin = f"{where}: " if where else ""
    try:
        if of_file:  # as JSON, where strict still lets 1 be a float and a list a tuple
            return model.model_validate_json(
                json.dumps(keys, default=str), strict=True, context=context
            )
        return model.model_validate(keys, context=context)
    except ValidationError as faults:
        raise InputError(
            f"{message_begin}{refusal_sentence(faults, _without_models(keys), model)}"
        ) from faults
    except RecursionError as reason:  # JSON with brackets by the hundred
        raise InputError(f"{message_begin}its tables are nested too deeply") from reason


def _without_models(table: Any) -> Any:
    """Models as tables of their keys, at every depth: what a refusal looks its keys up in."""
    if isinstance(table, BaseModel):
        table = table.__dict__
    if isinstance(table, Mapping):
        return {key: _without_models(value) for key, value in table.items()}
    return [_without_models(value) for value in table] if isinstance(table, list | tuple) else table
