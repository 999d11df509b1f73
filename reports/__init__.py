"""Comparison of two solutions, the page about it, and the command line.

`compare`, `score`, `input_effects`, `write` and `figure` are all that a script needs. Public is
what `__all__` of `reports` and `reports.studies.sweep` names; the modules beneath may change.
Names are loaded when they are first asked for: `halfplane --help` must not wait for numpy. With the
first of them, or at once where `scenes` or an engine is loaded already, scenes and solutions get
their HTML and figures.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reports.comparison import Comparison, compare
    from reports.comparison.laws import Certificate
    from reports.comparison.metrics import Metric
    from reports.inputs import InputEffects, input_effects
    from reports.page.writing import figure, write
    from reports.report import Report
    from reports.scoring.against import score

__all__ = [
    "Certificate",
    "Comparison",
    "InputEffects",
    "Metric",
    "Report",
    "compare",
    "figure",
    "input_effects",
    "score",
    "write",
]

_HOME = {
    "Certificate": "reports.comparison.laws",
    "Comparison": "reports.comparison",
    "InputEffects": "reports.inputs",
    "Metric": "reports.comparison.metrics",
    "Report": "reports.report",
    "compare": "reports.comparison",
    "figure": "reports.page.writing",
    "input_effects": "reports.inputs",
    "score": "reports.scoring.against",
    "write": "reports.page.writing",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'reports' has no attribute {name!r}")
    import_module("reports.page.notebook")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)


# `scenes` in a checkout, `halfplane.scenes` where the wheel is installed
_BESIDE = __name__.removesuffix("reports")
if not sys.modules.keys().isdisjoint(
    (f"{_BESIDE}scenes", f"{_BESIDE}semi_analytic", f"{_BESIDE}halfplane_fe")
):
    import_module("reports.page.notebook")
