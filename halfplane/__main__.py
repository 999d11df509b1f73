"""`python -m halfplane` is the command `halfplane`."""

from __future__ import annotations

import sys
from importlib import import_module


def main() -> int:
    """Run the command line; the exit code."""
    code: int = import_module("halfplane.reports.cli").main()
    return code


if __name__ == "__main__":
    sys.exit(main())
