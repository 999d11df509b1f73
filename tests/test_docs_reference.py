"""The table of scene keys is what the models say: every key, load kind and profile, with its unit, default and range."""

from __future__ import annotations

import importlib
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from scenes import Scene, Tolerances, scene_names, scene_text
from scenes.loads import KEYS

DOCS = Path(__file__).parents[1] / "docs"
sys.path.append(str(DOCS))
reference: Any = importlib.import_module("reference")

PAGE = (DOCS / "scene-keys.md").read_text(encoding="utf-8")
# Numbers without a dimension.
PLAIN = {"poisson_ratio", "coefficient", "friction", "exponent", "asymmetry", "value", "tolerance", "cycles", "average"}
PLAIN |= {*Tolerances.model_fields, "freedom", "weight", "left_out"}
PLAIN |= {"mean", "amplitude"}  # of a wave, in the unit of its key


def test_the_page_is_what_the_models_say() -> None:
    assert reference.page(PAGE) == PAGE, "docs/scene-keys.md is stale: run `make pages`"


def test_a_key_a_default_and_a_range_changed_by_hand_do_not_stay() -> None:
    forgeries = {
        "| `ellipse` | `phase_degrees` |": "| `ellipse` | `phase` |",
        "| `90.0` | ≥": "| `0.0` | ≥",
        "| `90.0` | ≥ −180, ≤ 180 |": "| `90.0` | any number |",
    }
    for old, new in forgeries.items():
        assert PAGE.count(old) == 1
        assert reference.page(PAGE.replace(old, new)) == PAGE


def numbers(schema: Any) -> Iterator[tuple[str, str]]:
    """(key, description) of every key that is a number; what a table states of a column is in the unit of that column."""
    for model in (schema, *(model for name, model in schema["$defs"].items() if not name.startswith(("OfLoads", "OfProfile")))):
        for key, one in model["properties"].items():
            kinds = {one.get("type"), *(option.get("type") for option in one.get("anyOf", ()))}
            if kinds & {"number", "integer"}:
                yield key, one.get("description", "")


def test_every_number_with_a_dimension_states_its_unit() -> None:
    found = list(numbers(Scene.model_json_schema()))
    assert len(found) > 30
    assert not [key for key, words in found if key not in PLAIN and reference.unit(key, words) == "–"]


def test_every_key_of_the_library_is_in_its_table() -> None:
    """From the files, not from the models: a key that the schema hides would be missed otherwise."""
    for name in scene_names():
        scene = tomllib.loads(scene_text(name))
        tables = [scene["profile"], scene["load"], *scene.get("bodies", {}).values()]
        stated = [(one["kind"], key) for one in tables for key in one if key not in {"kind", *KEYS}]
        missing = [key for kind, key in stated if f"| `{kind}` | `{key}` |" not in PAGE]
        missing += [key for key in scene["load"] if key in KEYS and f"| `{key}` |" not in PAGE]
        missing += [key for key in scene if f"| `{key}` |" not in PAGE and f"`[{key}" not in PAGE and f"`[[{key}" not in PAGE]
        assert not missing, name
