"""Every key of a scene file, in tables made from the models' JSON schema. `docs/pages.py` writes
them into scene-keys.md.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from scenes import Scene
from scenes.loads import KEYS

BEGIN, END = "<!-- scene keys: written by `make pages` -->", "<!-- end of scene keys -->"
# The unit as a description states it: "..., length units (library: mm)".
UNIT = re.compile(
    r"(?:, (?:both )?(?:length units|stress units|force per unit thickness|any time unit))?"
    r" \(library: ([^)]*)\)"
)
NONE = "–"
TITLES = {
    "material": "`[material]`, or `[material.upper]` and `[material.lower]`",
    "bodies": "`[bodies.lower]`, `[bodies.upper]`",
    "expected": "`[[expected]]`",
}
# Tables of keys within a table.
TABLES = {
    "ProfileFit": "table of keys: see `profile.fit`",
    "Fitted": "table, written by the fit",
    "LineOfAction": "table {x, height}",
    "RecordRow": "table {row}",
}
# Keys that every load has stand once; how their values vary with time, by the kind of load.
VARYING = {
    "Wave": "beside an ellipse",
    "WaveSum": "beside harmonics",
    "LineOfAction": "line_of_action",
}
VALUES = """A value is a number: in proportion to P during initial loading, constant afterwards. \
Or it varies with time:

| load | value |
|---|---|
| ellipse, harmonics | a table with the keys below |
| polygon | a list, one number for each point of `initial_loading` and `cycle` |
| time series | a list, one number for each row; or a column of the file, named under `columns` |
| callable | a Python function |
"""
BOUNDS = (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<"))
PLAIN = {
    "number": "any number",
    "integer": "whole number",
    "boolean": "`true`, `false`",
    "string": "text",
}
Row = tuple[str, str, Mapping[str, Any]]  # kind, key, the model that has it


def page(text: str) -> str:
    """The page with the tables between its two marks written again."""
    before, _, rest = text.partition(BEGIN)
    return "\n".join(
        [
            f"{before}{BEGIN}",
            "",
            *tables(Scene.model_json_schema()),
            f"{END}{rest.partition(END)[2]}",
        ]
    )


def tables(schema: Mapping[str, Any]) -> Iterator[str]:
    """One section for the top of the file, one for each of its tables."""
    models, properties = schema["$defs"], schema["properties"]

    def of(one: Mapping[str, Any]) -> list[Any]:
        """The models that a property refers to, in the order of the schema."""
        entries = [one, one.get("items", {}), *one.get("oneOf", ()), *one.get("anyOf", ())]
        return [models[entry["$ref"].rpartition("/")[2]] for entry in entries if "$ref" in entry]

    def keys(model: Any, kind: str = "", left_out: Iterable[str] = ()) -> list[Row]:
        return [(kind, key, model) for key in model["properties"] if key not in left_out]

    parts = {name: of(one) for name, one in properties.items()}
    yield from section(
        "Top of the file", [("", name, schema) for name, found in parts.items() if not found]
    )
    parts |= {
        "material": [models["Elastic"]],
        "bodies": of(models["Bodies"]["properties"]["lower"]),
    }
    for name, found in ((name, found) for name, found in parts.items() if found):
        title, kinds = (
            TITLES.get(name, f"`[{name}]`"),
            [(kind_of(model), model) for model in found if kind_of(model)],
        )
        if kinds:
            yield from (f"## {title}", "", "| `kind` | what it is |", "|---|---|")
            yield from (
                f"| `{kind}` | {cell(summary(model['description']))} |" for kind, model in kinds
            )
            yield ""
        shared = ("kind", *(KEYS if name == "load" else ()))
        yield from section(
            "" if kinds else title,
            [row for model in found for row in keys(model, kind_of(model), shared)],
        )
        if name == "load":
            every = {key: dict(found[0]["properties"][key]) for key in KEYS}
            for one in every.values():
                one["anyOf"] = [way for way in one["anyOf"] if "Wave" not in way.get("$ref", "")]
            yield from section(
                "Bulk stress, tilt and moment, of every load", keys({"properties": every})
            )
            yield VALUES
            yield from section(
                "", [row for model, kind in VARYING.items() for row in keys(models[model], kind)]
            )
        if name == "profile":
            yield from section("`profile.fit`", keys(models["ProfileFit"]))


def kind_of(model: Mapping[str, Any]) -> str:
    return model["properties"].get("kind", {}).get("const", "")


def section(title: str, rows: list[Row]) -> Iterator[str]:
    """A heading, if there is a title, and a table; the column of kinds only where there are any."""
    if title:
        yield from (f"## {title}", "")
    first = 0 if any(kind for kind, *_ in rows) else 1
    heads = ("kind", "key", "what it is", "unit", "default", "range")[first:]
    yield from (":::{container} keys", f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}")
    for kind, key, model in rows:
        one = model["properties"][key]
        words, value = one.get("description", ""), one.get("default")
        default = (
            "required"
            if key in model.get("required", ())
            else NONE
            if value in (None, "", [])
            else f"`{json.dumps(value)}`"
        )
        cells = (
            f"`{kind}`" if kind else "",
            f"`{key}`",
            cell(UNIT.sub("", words)),
            unit(key, words),
            default,
            admitted(one),
        )
        yield f"| {' | '.join(cells[first:])} |"
    yield from (":::", "")


def summary(description: str) -> str:
    r"""The first paragraph of a docstring, on one line.

    >>> summary("Two words,\nand three more.\n\nDetails.")
    'Two words, and three more.'
    """
    return " ".join(description.partition("\n\n")[0].split())


def unit(key: str, description: str) -> str:
    """The unit in the library's set, as its description states it."""
    found = UNIT.search(description)
    return found[1] if found else "degrees" if key.endswith("_degrees") else NONE


def admitted(one: Mapping[str, Any]) -> str:
    """The values that a key takes, in words."""
    if "not" in one:
        return "function (Python only)"
    if "$ref" in one:
        return TABLES.get(one["$ref"].rpartition("/")[2], "table with a value for each column")
    if options := one.get("anyOf"):
        return " or ".join(admitted(option) for option in options if option.get("type") != "null")
    if "enum" in one or "const" in one:
        return ", ".join(f"`{word}`" for word in one.get("enum", [one.get("const")]))
    if one["type"] == "array":
        items = one["items"]
        plain = {
            "array": "pairs" if "prefixItems" in items else "rows",
            "number": "numbers",
            "string": "words",
        }[items["type"]]
        each = admitted(items) if "enum" in items or items["type"] == "number" else PLAIN["number"]
        return f"list of {plain}" + ("" if each == PLAIN["number"] else f": {each}")
    bounds = ", ".join(
        f"{sign} {one[name]:g}".replace("-", "−") for name, sign in BOUNDS if name in one
    )
    return bounds or PLAIN[one["type"]]


def cell(text: str) -> str:
    """Words that may stand in a table: marks of Markdown escaped, but for `code`."""
    parts = text.replace("|", "\\|").split("`")
    return "`".join(
        re.sub(r"([*_])", r"\\\1", part) if k % 2 == 0 else part for k, part in enumerate(parts)
    )
