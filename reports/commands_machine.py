"""What the commands about this machine do."""

from __future__ import annotations

from pathlib import Path

from reports.application import OUTSIDE, WITHIN
from reports.console import show_table


def doctor(out: Path | None) -> int:
    """The doctor's findings."""
    from reports.doctor import examine

    findings = examine(out or "out")
    show_table("Doctor", ("check", "good", "found"), [(f.name, "yes" if f.good else "no", f.found) for f in findings])
    return WITHIN if all(finding.good for finding in findings) else OUTSIDE
