"""Why a table of keys was refused: the first fault that pydantic found, as a sentence in the words of the file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from scenes.bounded import shown

_NAMED = 4  # keys at fault beside the first that a refusal names


def refusal(faults: ValidationError, data: dict[str, Any], model: type[BaseModel], listed: str) -> str:
    """The first fault with key, value, rule and what to do, and which keys more are at fault.

    Parameters
    ----------
    data : the keys as they stand in the file
    listed : where the user finds the keys of `model`, such as "`halfplane schema`"
    """
    # Unknown keys first: a misspelt key is a missing one too. Then the deepest: of a union's branches the one that got farthest.
    errors = sorted(faults.errors(), key=lambda fault: (fault["type"] != "extra_forbidden", -len(fault["loc"])))
    fault = errors[0]
    key, value = _key(fault, data), fault["input"]
    more = _also([name for name in dict.fromkeys(_key(error, data) for error in errors) if name not in (key, "")])
    rule = fault["msg"].removeprefix("Value error, ").removeprefix("Input ").replace("an object", "a table of keys")
    match fault["type"]:
        case "extra_forbidden":
            word = str(fault["loc"][-1])
            hint = did_you_mean(word, _keys(model) - {word})  # what is unknown here may be known in another table
            return f"unknown key {key} = {shown(value)};{hint} {listed} lists the keys{more}"
        case "missing" if isinstance(value, dict):
            return f"the key {key} is missing; {listed} lists the keys{more}"
        case "missing":
            rule = "a point is [P, Q]"
        case "union_tag_not_found":
            return f"the key {key}.kind is missing; {listed} lists the kinds{more}"
        case "union_tag_invalid":
            key, value, rule = f"{key}.kind", value["kind"], f"should be {fault['ctx']['expected_tags'].replace(', ', ' or ')}"
        case "value_error":
            return f"{key} is refused: {rule}{more}" if key else f"{rule}{more}"
    return f"{key} = {shown(value)} is refused: {rule}{more}"


def _also(keys: Sequence[str]) -> str:
    """The other keys at fault, in brackets; of many the first few, told once these are mended.

    >>> _also(["friction.coefficient"]), _also(list("abcdef")), _also([])
    (' (also at fault: friction.coefficient)', ' (also at fault: a, b, c, d and 2 more, named once these are mended)', '')
    """
    rest = f" and {len(keys) - _NAMED} more, named once these are mended" if len(keys) > _NAMED else ""
    return f" (also at fault: {', '.join(keys[:_NAMED])}{rest})" if keys else ""


def not_toml(text: str, reason: Exception) -> str:
    """Why TOML was refused, with the line at fault; a comma within a number is pointed at.

    >>> not_toml("a = 1\\nb = 0,4", ValueError("Expected newline (at line 2, column 6)"))
    "not valid TOML: Expected newline (at line 2, column 6), in 'b = 0,4'; write a decimal point, not a comma"
    """
    found = re.search(r"\(at line (\d+), column \d+\)", str(reason))
    lines = text.split("\n")
    if not found or not 0 < int(found[1]) <= len(lines):
        return f"not valid TOML: {reason}"
    line = lines[int(found[1]) - 1].strip()
    comma = "; write a decimal point, not a comma" if re.search(r"=\s*[-+]?\d+,\d", line) else ""
    return f"not valid TOML: {reason}, in {shown(line)}{comma}"


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A question after the known word that is most like `word`, with a blank before it; empty where none is.

    >>> did_you_mean("radias", ["radius", "kind"]), did_you_mean("zzz", ["radius", "kind"])
    (' did you mean radius?', '')
    >>> did_you_mean("phase", ["base", "phase_degrees"])
    ' did you mean phase_degrees?'
    """
    words = sorted(known, key=len)
    # A key cut short, or with a unit behind it, is nearer than one with as many letters in common.
    begun = [key for key in words if min(len(key), len(word)) > 2 and (key.startswith(word) or word.startswith(key))]
    near = begun or difflib.get_close_matches(word, words, n=1)
    return f" did you mean {near[0]}?" if near else ""


def _keys(model: type[BaseModel]) -> set[str]:
    """Every key of a model, of whatever table."""
    schema = model.model_json_schema()
    return {key for table in (schema, *schema.get("$defs", {}).values()) for key in table.get("properties", {})}


def _key(fault: ErrorDetails, data: dict[str, Any]) -> str:
    """The key as it stands in the file: pydantic's location less the parts that only its unions know."""
    found: list[str] = []
    level: Any = data
    for part in fault["loc"]:
        if isinstance(part, int) and isinstance(level, list) and part < len(level):
            level = level[part]
        elif isinstance(level, dict) and part in level:
            level = level[str(part)]
        elif fault["type"] == "missing" and isinstance(level, dict) and part == fault["loc"][-1]:
            level = None
        else:
            continue
        found.append(str(part))
    return ".".join(found)
