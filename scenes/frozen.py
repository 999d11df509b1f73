"""What every table of keys has in common: frozen, checked at every door, changed by `vary` alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NoReturn, Self, TypeVar

from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler, TypeAdapter, ValidationError
from pydantic_core import CoreSchema

from scenes.bounded import shown
from scenes.errors import InputError
from scenes.refusals import refusal


class Frozen(BaseModel):
    """A frozen table of keys. Whatever is put into another table is checked again there, however it was made."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, revalidate_instances="always")

    keys_listed: ClassVar[str] = "`halfplane schema`"
    """Where a user finds the keys."""

    def vary(self, /, **changes: Any) -> Self:
        """A checked copy with other values; the only way to change a scene, or a part of one, from Python.

        Parameters
        ----------
        changes : key -> value. A value is what the constructor takes: a number, a list, a model. A mapping given for a table of
            keys changes those keys and keeps the others, at every depth. A mapping with another `kind` than the table has
            replaces it whole: nothing of an ellipse is right for a polygon. A list replaces the whole list.

        Raises
        ------
        InputError
            One sentence with key, value and rule: for an unknown key, or a value that the scene file would not be allowed either.

        >>> from scenes import load_scene
        >>> scene = load_scene("hertz-paper").vary(friction=0.6, load={"phase_degrees": 60})
        >>> scene.friction.coefficient, scene.load.phase_degrees, scene.load.kind
        (0.6, 60.0, 'ellipse')
        >>> scene.vary(frictoin=0.6)
        Traceback (most recent call last):
        scenes.errors.InputError: vary: unknown key frictoin = 0.6; did you mean friction? `halfplane schema` lists the keys
        """
        return _checked(type(self), self.merged(changes), "vary")

    def merged(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """The keys that were given, those of `changes` in their place; raw, for the check that follows."""
        data = {name: value for name, value in self if name == "kind" or name in self.model_fields_set}
        for name, value in changes.items():
            old = getattr(self, name, None)
            kind = getattr(old, "kind", None)
            if isinstance(old, Frozen) and isinstance(value, Mapping) and value.get("kind", kind) == kind:
                data[name] = old.merged(value)
            else:
                data[name] = value
        return data

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """pydantic's copy; with `update` it is `vary`, for pydantic itself checks nothing of an update."""
        return self.vary(**update) if update else super().model_copy(deep=deep)

    def copy(self, **_options: Any) -> NoReturn:
        """pydantic's earlier copy, which checks nothing: refused."""
        raise InputError("copy checks nothing: take vary(key=value)")


@dataclass(frozen=True)
class ShortForm:
    """Mark of a field, for the JSON schema: `form` may stand there in place of the table of keys."""

    form: Any

    def __get_pydantic_json_schema__(self, table: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [handler(table), handler(TypeAdapter(self.form).core_schema)]}


M = TypeVar("M", bound=Frozen)


def validated(given: M, wanted: type[Frozen]) -> M:
    """`given` as its own check leaves it: the door of every function that takes a scene or a part of one.

    Raises
    ------
    InputError
        One sentence: for what is none of `wanted`, and for what was made past the checks (`model_construct`) and does not pass.

    >>> from scenes import Elastic
    >>> validated(Elastic.model_construct(young_modulus=1.0, poisson_ratio=0.7), Elastic)
    Traceback (most recent call last):
    scenes.errors.InputError: Elastic: poisson_ratio = 0.7 is refused: should be less than 0.5
    """
    if not isinstance(given, wanted):
        how = "; load_scene reads one from the library or a file" if wanted.__name__ == "Scene" else ""
        raise InputError(f"a {wanted.__name__} is needed, not {shown(given)}{how}")
    name = getattr(given, "name", "")
    return _checked(type(given), given, f"{wanted.__name__} {shown(name)}" if name else type(given).__name__)


def _checked(model: type[M], data: Any, where: str) -> M:
    try:
        return model.model_validate(data)
    except ValidationError as faults:
        raise InputError(f"{where}: {refusal(faults, _plain(data), model)}") from faults


def _plain(data: Any) -> Any:
    """Models as tables of their keys, at every depth: what a refusal looks its keys up in."""
    if isinstance(data, BaseModel):
        data = data.__dict__
    if isinstance(data, Mapping):
        return {key: _plain(value) for key, value in data.items()}
    return [_plain(value) for value in data] if isinstance(data, list | tuple) else data
