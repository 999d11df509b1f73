"""Every key of a scene file, in tables made from the models' JSON schema. `docs/pages.py` writes them into scene-keys.md."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from scenes import Scene
from scenes.loads import KEYS

BEGIN, END = "<!-- scene keys: written by `make pages` -->", "<!-- end of scene keys -->"
# The unit as a description states it: "..., length units (library: mm)".
_UNIT = re.compile(r"(?:, (?:both )?(?:length units|stress units|force per unit thickness|any time unit))? \(library: ([^)]*)\)")
_NONE = "–"
# Tables of keys within a table.
_TABLES = {
    "ProfileFit": "table of keys: see `profile.fit`",
    "Fitted": "table, written by the fit",
    "LineOfAction": "table {x, height}",
}
# Keys that every load has stand once; how their values vary with time, by the kind of load.
_VARYING = {"Wave": "beside an ellipse", "WaveSum": "beside harmonics", "LineOfAction": "line_of_action"}
_VALUES = """A value is a number: in proportion to P during initial loading, constant afterwards. Or it varies with time:

| load | value |
|---|---|
| ellipse, harmonics | a table with the keys below |
| polygon | a list, one number for each point of `initial_loading` and `cycle` |
| time series | a list, one number for each row; or a column of the file, named under `columns` |
| callable | a Python function |
"""
_BOUNDS = (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<"))
_Row = tuple[str, str, str, str, str, str]


def page(text: str) -> str:
    """The page with the tables between its two marks written again."""
    before, _, rest = text.partition(BEGIN)
    return "\n".join([f"{before}{BEGIN}", "", *tables(Scene.model_json_schema()), f"{END}{rest.partition(END)[2]}"])


def tables(schema: Mapping[str, Any]) -> Iterator[str]:
    """One section for the top of the file, one for each of its tables."""
    models, properties = schema["$defs"], schema["properties"]
    parts = {name: _models(one, models) for name, one in properties.items()}
    yield from _section("Top of the file", [_row("", name, schema) for name, found in parts.items() if not found])
    parts["material"] = [models["Elastic"]]
    parts["bodies"] = _models(models["Bodies"]["properties"]["lower"], models)
    titles = {
        "material": "`[material]`, or `[material.upper]` and `[material.lower]`",
        "bodies": "`[bodies.lower]`, `[bodies.upper]`",
        "expected": "`[[expected]]`",
    }
    for name, found in parts.items():
        title, kinds = titles.get(name, f"`[{name}]`"), [model for model in found if "kind" in model["properties"]]
        if kinds:
            yield from (f"## {title}", "", "| `kind` | what it is |", "|---|---|")
            for model in kinds:
                yield f"| `{_kind(model)}` | {_cell(model['description'].partition(chr(10))[0])} |"
            yield ""
        if found:
            shared = ("kind", *(KEYS if name == "load" else ()))
            rows = [_row(_kind(model), key, model) for model in found for key in model["properties"] if key not in shared]
            yield from _section("" if kinds else title, rows)
        if name == "load":
            every = {key: dict(found[0]["properties"][key]) for key in KEYS}
            for one in every.values():
                one["anyOf"] = [way for way in one["anyOf"] if "Wave" not in way.get("$ref", "")]
            rows = [_row("", key, {"properties": every}) for key in every]
            yield from _section("Bulk stress, tilt and moment, of every load", rows)
            yield _VALUES
            rows = [_row(kind, key, models[model]) for model, kind in _VARYING.items() for key in models[model]["properties"]]
            yield from _section("", rows)
        if name == "profile":
            yield from _section(
                "`profile.fit`", [_row("", key, models["ProfileFit"]) for key in models["ProfileFit"]["properties"]]
            )


def _models(one: Mapping[str, Any], models: Mapping[str, Any]) -> list[Any]:
    """The models that a property refers to, in the order of the schema."""
    entries = [one, one.get("items", {}), *one.get("oneOf", ()), *one.get("anyOf", ())]
    return [models[entry["$ref"].rpartition("/")[2]] for entry in entries if "$ref" in entry]


def _kind(model: Mapping[str, Any]) -> str:
    return model["properties"].get("kind", {}).get("const", "")


def _section(title: str, rows: list[_Row]) -> Iterator[str]:
    """A heading, if there is a title, and a table; the column of kinds only where there are any."""
    if title:
        yield from (f"## {title}", "")
    first = 0 if any(row[0] for row in rows) else 1
    heads = ("kind", "key", "what it is", "unit", "default", "range")[first:]
    yield from (":::{container} keys", f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}")
    yield from (f"| {' | '.join(row[first:])} |" for row in rows)
    yield from (":::", "")


def _row(kind: str, key: str, model: Mapping[str, Any]) -> _Row:
    one = model["properties"][key]
    words = one.get("description", "")
    return (
        f"`{kind}`" if kind else "",
        f"`{key}`",
        _cell(_UNIT.sub("", words)),
        unit(key, words),
        _default(key, model),
        admitted(one),
    )


def unit(key: str, description: str) -> str:
    """The unit in the library's set, as its description states it."""
    found = _UNIT.search(description)
    return found[1] if found else "degrees" if key.endswith("_degrees") else _NONE


def _default(key: str, model: Mapping[str, Any]) -> str:
    if key in model.get("required", ()):
        return "required"
    value = model["properties"][key].get("default")
    return _NONE if value in (None, "", []) else f"`{json.dumps(value)}`"


def admitted(one: Mapping[str, Any]) -> str:
    """The values that a key takes, in words."""
    if "not" in one:
        return "function (Python only)"
    if "$ref" in one:
        return _TABLES.get(one["$ref"].rpartition("/")[2], "table with a value for each column")
    if options := one.get("anyOf"):
        return " or ".join(admitted(option) for option in options if option.get("type") != "null")
    if "enum" in one or "const" in one:
        return ", ".join(f"`{word}`" for word in one.get("enum", [one.get("const")]))
    bounds = ", ".join(f"{sign} {one[name]:g}".replace("-", "−") for name, sign in _BOUNDS if name in one)
    if one["type"] == "array":
        items = one["items"]
        plain = {"array": "pairs" if "prefixItems" in items else "rows", "number": "numbers", "string": "words"}[items["type"]]
        each = admitted(items) if "enum" in items or items["type"] == "number" else "any number"
        return f"list of {plain}" + ("" if each == "any number" else f": {each}")
    return (
        bounds or {"number": "any number", "integer": "whole number", "boolean": "`true`, `false`", "string": "text"}[one["type"]]
    )


def _cell(text: str) -> str:
    """Words that may stand in a table: marks of Markdown escaped, but for `code`."""
    parts = text.replace("|", "\\|").split("`")
    return "`".join(re.sub(r"([*_])", r"\\\1", part) if k % 2 == 0 else part for k, part in enumerate(parts))
