"""Signals that end the program, held back where half a piece of work would be worse than the wait."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # the last is none of Windows


@contextmanager
def interrupts_wait() -> Iterator[Sequence[int]]:
    """What a Ctrl-C inside raises comes at the end, once; the same of SIGTERM and SIGHUP, where the program hears them.

    Yields the signals that came so far, for loops that look there and end early.

    Needed where gmsh is at work, whose one global state has to be left in order, or where half of a change would be left (files
    that are moved).
    """
    numbers = [number for name in _NAMES if (number := getattr(signal, name, None)) is not None]
    heard = {number: handler for number in numbers if callable(handler := signal.getsignal(number))}
    caught: list[int] = []
    if threading.current_thread() is not threading.main_thread() or not heard:  # only the main thread is interrupted
        yield caught
        return
    for number in heard:
        signal.signal(number, lambda which, _frame: caught.append(which))
    try:
        yield caught
    finally:
        for number, handler in heard.items():
            signal.signal(number, handler)
    if caught:
        heard[signal.Signals(caught[0])](caught[0], None)
