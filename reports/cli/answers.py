"""`--json`: one envelope for every command, and its schema."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import resources
from typing import Any

FORMAT = "halfplane answer 2"


def answer(command: str, code: int, result: Mapping[str, Any], scene: str | None = None) -> int:
    """Print the answer of a command as the one JSON document on stdout, and give its exit code.

    What is not finite in `result` becomes null. `scene` is the name of the scene; None where a command is about none.
    """
    from reports.comparison.content import strict
    from reports.console import say

    content = {"format": FORMAT, "command": command, "exit_code": code, "scene": scene, "result": result}
    say(json.dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False))
    return code


def answer_schema() -> dict[str, Any]:
    """The JSON schema of every answer: the envelope, and for each command what `result` holds."""
    found: dict[str, Any] = json.loads((resources.files("reports") / "templates" / "answer.schema.json").read_text("utf-8"))
    return found
