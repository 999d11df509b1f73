"""Which version of the project wrote a file: the commit, where the project runs from a checkout."""

from __future__ import annotations

import subprocess
from pathlib import Path


def commit() -> str:
    """The commit of the checkout that this package lies in, "with changes" where files differ from it; or why there is none."""
    home = Path(__file__).parents[1]
    if not (home / ".git").exists():
        return "installed without its history"
    try:
        done = subprocess.run(
            ["git", "-C", str(home), "describe", "--always", "--dirty", "--abbrev=12"],
            capture_output=True,
            text=True,
            timeout=10,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return "unknown: git does not answer"
    return done.stdout.strip().replace("-dirty", ", with changes")
