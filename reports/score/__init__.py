"""Somebody else's result: read into one form, put beside a reference, judged by the same metrics, and told what it suffers from.

`reports.score(x, p, q, scene=...)` is `reports.score.scoring.score`: the package can be called, since the command, the package and
the function are one word.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reports.comparison import Comparison


class _Callable(ModuleType):
    """A package that can be called; what it does is loaded when it is."""

    def __call__(self, *arrays: Any, **known: Any) -> Comparison:
        from reports.score.scoring import score

        return score(*arrays, **known)


sys.modules[__name__].__class__ = _Callable
