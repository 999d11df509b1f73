"""Every key of a scene file, in tables made from the models' JSON schema. `docs/pages.py` writes
them into scene-keys.md.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from scenes import Scene
from scenes.column_names import ALIASES
from scenes.loads import BULK_AND_TILT_KEYS

BEGIN = "<!-- scene keys: written by `make pages` -->"
END = "<!-- end of scene keys -->"
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
    "ProfileFit": "table: `profile.fit`",
    "Fitted": "table",
    "LineOfAction": "table {x, height}",
    "DrivenWave": "table {mean, amplitude, phase_degrees}",
    "DrivenApproach": "table {mean, amplitude}",
    "DrivenWaveSum": "table {mean, harmonics}",
    "RecordRow": "table {row}",
}
# Tables within `[uncertainty]`, which have the keys of the scene's own.
OF_UNCERTAINTY = {
    "`[uncertainty.profile]`": "OfShape",
    "`[uncertainty.material]`": "OfMaterials",
    "`[uncertainty.bodies.lower]`, `.upper`": "OfBody",
    "`[uncertainty.rig]`": "OfRig",
}
BY_COLUMN = "by column"  # a table with a value for each column
# Keys of a file's columns, which stand once for profiles and loads.
OF_FILES = ("columns", "units", "scale", "zero", "sign")
# Keys that a reader of files writes, and nobody else.
WRITTEN = ("fitted", "read_as")
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
SHARES = """Each value is a standard uncertainty as text: "5 %" or "0.1 mm"; a bare number is \
refused, but for `phase_degrees` in degrees. `upper` and `lower` hold the material's keys \
for one body alone.
"""
BOUNDS = (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<"))
FEW = 3  # words that are listed even where the description has them
MANY = 12  # words of a closed set that are not listed: a wrong one is refused with the right ones
PLAIN = {
    "number": NONE,
    "integer": "whole number",
    "boolean": "`true`, `false`",
    "string": "text",
}
# Columns of files beside a scene, and the quantity of `ALIASES` whose headings each has.
COLUMNS = {
    "time": "time",
    "P": "normal_load",
    "Q": "tangential_load",
    "U": "displacement",
    "approach": "approach",
    "x": "x",
    "h": "height",
    "pressure": "pressure",
    "shear": "shear",
    "slip": "slip",
    "frame": "frame",
}
MOST_HEADINGS = 3  # of a column on the page
HEADINGS = """[headings.csv](headings.csv) has all, in English, German, French, Italian and Spanish.
"""
Row = tuple[str, str, Mapping[str, Any]]  # kind, key, the model that has it
Cells = tuple[str, str, str, str]  # what it is, unit, default, range


def page(text: str) -> str:
    """The page with the tables between its two marks written again."""
    before, _, rest = text.partition(BEGIN)
    return "\n".join(
        [
            f"{before}{BEGIN}",
            "",
            *tables(Scene.model_json_schema()),
            *headings(),
            f"{END}{rest.partition(END)[2]}",
        ]
    )


def tables(schema: Mapping[str, Any]) -> Iterator[str]:
    """One section for the top of the file, one for each of its tables."""
    models = schema["$defs"]
    properties = schema["properties"]

    def models_of(value: Mapping[str, Any]) -> list[Any]:
        """The models that a property refers to, in the order of the schema."""
        entries = [value, value.get("items", {}), *value.get("oneOf", ()), *value.get("anyOf", ())]
        return [models[entry["$ref"].rpartition("/")[2]] for entry in entries if "$ref" in entry]

    def keys(model: Any, kind: str = "", left_out: Iterable[str] = ()) -> list[Row]:
        """A row for each key of a model."""
        return [
            (kind, key, model)
            for key in model["properties"]
            if key not in left_out and key not in WRITTEN
        ]

    parts = {name: models_of(value) for name, value in properties.items()}
    plain_names = [name for name, of_part in parts.items() if not of_part]
    yield from section("Top of the file", [("", name, schema) for name in plain_names])
    parts["material"] = [models["Elastic"]]
    parts["bodies"] = models_of(models["Bodies"]["properties"]["lower"])
    for name, of_part in parts.items():
        if not of_part:
            continue
        title = TITLES.get(name, f"`[{name}]`")
        kinds = [(kind_of(model), model) for model in of_part if kind_of(model)]
        if kinds:
            yield from (f"## {title}", "", "| `kind` | what it is |", "|---|---|")
            yield from (
                f"| `{kind}` | {cell(summary(model['description']))} |" for kind, model in kinds
            )
            yield ""
        if name == "uncertainty":
            yield from uncertainties(title, of_part[0], models)
            continue
        shared = ("kind", *OF_FILES, *(BULK_AND_TILT_KEYS if name == "load" else ()))
        yield from section(
            "" if kinds else title,
            [row for model in of_part for row in keys(model, kind_of(model), shared)],
        )
        if name == "load":
            shared_keys = {key: dict(of_part[0]["properties"][key]) for key in BULK_AND_TILT_KEYS}
            for value in shared_keys.values():
                value["anyOf"] = [
                    way for way in value["anyOf"] if "Wave" not in way.get("$ref", "")
                ]
            yield from section(
                "Bulk stress, tilt and moment, of every load", keys({"properties": shared_keys})
            )
            yield VALUES
            yield from section(
                "", [row for model, kind in VARYING.items() for row in keys(models[model], kind)]
            )
        if name == "profile":
            yield from section("`profile.fit`", keys(models["ProfileFit"]))
    of_columns = {key: models["TimeSeriesLoad"]["properties"][key] for key in OF_FILES}
    yield from section(
        "Columns of a file, of `tabulated` and `time_series`", keys({"properties": of_columns})
    )


def headings() -> Iterator[str]:
    """The first headings that are known of each column of a file."""
    yield from ("## Headings of files", "", HEADINGS, "| column | headings |", "|---|---|")
    for column, names in known_headings().items():
        more = ", ..." if len(names) > MOST_HEADINGS else ""
        yield f"| `{column}` | {cell(', '.join(names[:MOST_HEADINGS]))}{more} |"
    yield ""


def headings_file() -> str:
    """Every heading that is known, as CSV: column, heading."""
    written = io.StringIO()
    rows = csv.writer(written, lineterminator="\n")
    rows.writerow(["column", "heading"])
    for column, names in known_headings().items():
        rows.writerows([column, name] for name in names)
    return written.getvalue()


def known_headings() -> dict[str, list[str]]:
    """The headings of each column; those that differ in case or blanks alone stand once."""
    headings_of: dict[str, list[str]] = {}
    for column, quantity in COLUMNS.items():
        names: dict[str, str] = {}
        for name in ALIASES[quantity]:
            names.setdefault(re.sub(r"[ _]", "", name).casefold(), name.replace("_", " "))
        headings_of[column] = list(names.values())
    return headings_of


def kind_of(model: Mapping[str, Any]) -> str:
    """The word for a model under `kind`; empty without one."""
    return model["properties"].get("kind", {}).get("const", "")


def uncertainties(title: str, top: Mapping[str, Any], models: Mapping[str, Any]) -> Iterator[str]:
    """The table of `[uncertainty]`: its keys by the table that has them; all have one form."""
    plain_keys = [key for key, entry in top["properties"].items() if "$ref" not in entry]
    yield from (f"## {title}", "", SHARES, "| table | keys |", "|---|---|")
    tables_of_keys = {"`[uncertainty]`": plain_keys}
    for name, model in OF_UNCERTAINTY.items():
        tables_of_keys[name] = list(models[model]["properties"])
    for name, names in tables_of_keys.items():
        yield f"| {name} | {', '.join(f'`{key}`' for key in names)} |"
    yield from ("", f"`correlations`: {top['properties']['correlations']['description']}.", "")


def section(title: str, rows: list[Row]) -> Iterator[str]:
    """A heading, if there is a title, and a table; the column of kinds only where there are any. A
    key that several kinds have in one form stands once.
    """
    if title:
        yield from (f"## {title}", "")
    first = 0 if any(kind for kind, *_ in rows) else 1
    heads = ("kind", "key", "what it is", "unit", "default", "range")[first:]
    yield from (":::{container} keys", f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}")
    kinds: dict[tuple[str, Cells], list[str]] = {}
    for kind, key, model in rows:
        kinds.setdefault((key, cells_of(key, model)), []).append(f"`{kind}`" if kind else "")
    for (key, cells), kinds_of_key in kinds.items():
        line = (", ".join(kinds_of_key), f"`{key}`", *cells)
        yield f"| {' | '.join(line[first:])} |"
    yield from (":::", "")


def cells_of(key: str, model: Mapping[str, Any]) -> Cells:
    """What a key is, its unit, default and range."""
    entry = model["properties"][key]
    words = entry.get("description", "")
    value = entry.get("default")
    if key in model.get("required", ()):
        default = "required"
    elif value in (None, "", []):
        default = NONE
    else:
        default = f"`{json.dumps(value)}`"
    choices = entry.get("enum", ())
    values = admitted(entry)
    if len(choices) > FEW and all(word in words for word in choices):
        values = "these words"
    return cell(UNIT.sub("", words)), unit(key, words), default, values


def summary(description: str) -> str:
    r"""The first paragraph of a docstring, on one line.

    >>> summary("Two words,\nand three more.\n\nDetails.")
    'Two words, and three more.'
    """
    return " ".join(description.partition("\n\n")[0].split())


def unit(key: str, description: str) -> str:
    """The unit in the library's set, as its description states it."""
    match = UNIT.search(description)
    if match:
        return match[1]
    return "degrees" if key.endswith("_degrees") else NONE


def admitted(entry: Mapping[str, Any]) -> str:
    """The values that a key takes, in words."""
    if "not" in entry:
        return "function"
    if "$ref" in entry:
        return TABLES.get(entry["$ref"].rpartition("/")[2], BY_COLUMN)
    options = entry.get("anyOf")
    if options:
        return " or ".join(admitted(option) for option in options if option.get("type") != "null")
    if "enum" in entry or "const" in entry:
        return ", ".join(f"`{word}`" for word in entry.get("enum", [entry.get("const")]))
    if entry["type"] == "array":
        return admitted_list(entry["items"])
    bounds = ", ".join(
        f"{sign} {entry[name]:g}".replace("-", "−") for name, sign in BOUNDS if name in entry
    )
    return bounds or PLAIN[entry["type"]]


def admitted_list(entry: Mapping[str, Any]) -> str:
    """A list in words, by the schema of its entries."""
    entries_of_a_row = {2: "pairs", 3: "triples"}
    plurals = {
        "array": entries_of_a_row.get(len(entry.get("prefixItems", ())), "rows"),
        "number": "numbers",
        "string": "words",
    }
    words = plurals[entry["type"]]
    if len(entry.get("enum", ())) > MANY:
        return f"{words}, a closed set"
    if "enum" in entry or entry["type"] == "number":
        limits = admitted(entry)
        if limits != PLAIN["number"]:
            words += f": {limits}"
    return words


def cell(text: str) -> str:
    """Words that may stand in a table: marks of Markdown escaped, but for `code`."""
    parts = text.replace("|", "\\|").split("`")
    return "`".join(
        re.sub(r"([*_])", r"\\\1", part) if k % 2 == 0 else part for k, part in enumerate(parts)
    )
