"""Why a table of keys was refused: the first fault that pydantic found, as a sentence in the words of the file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from scenes.bounded import shown

if TYPE_CHECKING:
    from scenes.frozen import Frozen

_NAMED = 4  # keys at fault beside the first that a refusal names

# What no scene can state, by how a word of a key begins that would state it: section "What is neglected" of docs/theory.md.
_NEGLECTED = {
    ("bulk", "remote"): "bulk stress in a body is not modelled, loads are P and Q",
    ("moment", "tilt", "rotation", "inclination", "misalignment"): "the bodies carry no moment and do not tilt",
    ("wear", "archard"): "wear is not modelled",
    ("plastic", "yield", "hardening", "hardness"): "the materials are linear elastic, without plasticity",
    ("creep", "visco", "relaxation"): "the materials are linear elastic, without creep",
    ("temperature", "thermal", "heat"): "temperature is not modelled",
    ("fatigue", "life", "crack"): "fatigue life is not computed",
    ("inertia", "mass", "density", "gravity"): "the contact is quasi-static, without inertia",
    ("static", "kinetic", "velocity", "frequency", "rate"): "friction has one coefficient, and nothing depends on the rate",
    ("adhesion", "adhesive", "roughness"): "the faces are smooth and do not adhere",
    ("thickness",): "the bodies are in plane strain, and loads are per unit thickness",
}


def refusal(faults: ValidationError, data: Any, model: type[Frozen]) -> str:
    """The first fault with key, value, rule and what to do, and which keys more are at fault.

    Parameters
    ----------
    data : the keys as they stand in the file, tables as dicts and lists
    """
    listed = model.keys_listed
    # Unknown keys first: a misspelt key is a missing one too. Then the deepest: of a union's branches the one that got farthest.
    errors = sorted(faults.errors(), key=lambda fault: (fault["type"] != "extra_forbidden", -len(fault["loc"])))
    fault = errors[0]
    key, value = _key(fault, data), fault["input"]
    more = _also([name for name in dict.fromkeys(_key(error, data) for error in errors) if name not in (key, "")])
    rule = fault["msg"].removeprefix("Value error, ").removeprefix("Input ")
    match fault["type"]:
        case "extra_forbidden":
            word = str(fault["loc"][-1])
            # What is unknown here may be known in another table.
            hint = neglected(word) or f"{did_you_mean(word, _keys(model) - {word})} {listed} lists the keys"
            return f"unknown key {key} = {shown(value)};{hint}{more}"
        case "missing" if isinstance(value, dict):
            return f"the key {key} is missing; {listed} lists the keys{more}"
        case "missing":
            rule = "a point is [P, Q]"
        case "union_tag_not_found":
            return f"the key {key}.kind is missing; {listed} lists the kinds{more}"
        case "union_tag_invalid":
            kinds = fault["ctx"]["expected_tags"].replace(", ", " or ")
            key, value, rule = f"{key}.kind", fault["ctx"]["tag"], f"should be {kinds}"
        case "model_type" | "model_attributes_type":
            rule = "should be a table of keys"
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


def neglected(word: str) -> str:
    """Why no scene has a key of this name, with a blank before it and the page that says so; empty where that is not the reason.

    >>> neglected("yield_stress")
    " the materials are linear elastic, without plasticity: docs/theory.md, 'What is neglected'"
    >>> neglected("phase")
    ''
    """
    words = re.split("[^a-z]+", word.lower())
    found = next((limit for stems, limit in _NEGLECTED.items() if any(part.startswith(stems) for part in words)), "")
    return f" {found}: docs/theory.md, 'What is neglected'" if found else ""


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


def _keys(model: type[Frozen]) -> set[str]:
    """Every key of a model, of whatever table."""
    schema = model.model_json_schema()
    return {key for table in (schema, *schema.get("$defs", {}).values()) for key in table.get("properties", {})}


def _key(fault: ErrorDetails, data: Any) -> str:
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
