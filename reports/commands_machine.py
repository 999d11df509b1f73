"""What the commands about this machine do."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

from reports.application import OUTSIDE, WITHIN, app
from reports.console import show_table


def doctor(out: Path | None) -> int:
    """The doctor's findings."""
    from reports.doctor import examine

    findings = examine(out or "out")
    show_table("Doctor", ("check", "good", "found"), [(f.name, "yes" if f.good else "no", f.found) for f in findings])
    return WITHIN if all(finding.good for finding in findings) else OUTSIDE


def completion(shell: Literal["bash", "zsh", "fish"]) -> int:
    """The script on stdout, to the letter: a shell reads it."""
    sys.stdout.write(app.generate_completion(shell=shell))
    return WITHIN
