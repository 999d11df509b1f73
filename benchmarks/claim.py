"""One claimed number and the table it stands in: what every benchmark yields and `make numbers` collects."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]


def commit() -> str:
    """The commit that is measured, with a plus sign where files were changed since."""
    found = subprocess.run(["git", "describe", "--always", "--dirty=+"], capture_output=True, text=True, cwd=ROOT, check=False)
    return found.stdout.strip()


@dataclass(frozen=True)
class Row:
    """One claim: what, the figure measured, the limit it shall keep (None: shown only), and how it was come by."""

    what: str
    measured: float
    limit: float | None
    how: str
    unit: str = ""

    @property
    def kept(self) -> bool | None:
        return None if self.limit is None else bool(abs(self.measured) <= self.limit)


def table(rows: list[Row]) -> str:
    """The rows as a Markdown table."""
    lines = ["| claim | measured | limit | kept | how |", "|---|---|---|---|---|"]
    for row in rows:
        limit = "" if row.limit is None else f"{row.limit:g} {row.unit}".strip()
        kept = {None: "", True: "yes", False: "**no**"}[row.kept]
        cells = (row.what, f"{row.measured:.3g} {row.unit}".strip(), limit, kept, row.how)
        lines.append("| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |")
    return "\n".join(lines)
