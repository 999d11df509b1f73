"""Process time of a piece of work, the least of a few runs."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


def seconds(work: Callable[[], Any], times: int = 1) -> float:
    """Least process time of a few runs, after one to warm up where there are several."""
    if times > 1:
        work()
    found = []
    for _ in range(times):
        begun = time.process_time()
        work()
        found.append(time.process_time() - begun)
    return min(found)
