"""What the commands about this machine do."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

from reports.application import OUTSIDE, WITHIN, app
from reports.console import say, show_table


def doctor(out: Path | None, as_json: bool, quiet: bool) -> int:
    """The doctor's findings."""
    from reports.doctor import examine

    findings = examine(out or "out")
    code = WITHIN if all(finding.good for finding in findings) else OUTSIDE
    if as_json:
        from reports.machine import doctor_json

        say(doctor_json(findings, code))
    elif not quiet:
        show_table("Doctor", ("check", "good", "found"), [(f.name, "yes" if f.good else "no", f.found) for f in findings])
    return code


def completion(shell: Literal["bash", "zsh", "fish"]) -> int:
    """The script on stdout, to the letter: a shell reads it."""
    sys.stdout.write(app.generate_completion(shell=shell))
    return WITHIN
