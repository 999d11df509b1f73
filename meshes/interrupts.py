"""Signals that end the program, held back where half a piece of work would be worse than the
wait.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_SIGNAL_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # the last is none of Windows


@contextmanager
def interrupts_wait() -> Iterator[Sequence[int]]:
    """Context manager that holds back Ctrl-C, SIGTERM and SIGHUP until its block ends, then acts on
    the first of them once.

    The signal is acted on whether the block ends well or raises. What the block raised is then the
    context of what the signal raises. Yields the list of signal numbers that have come so far, for
    loops that look there and end early. In other threads than the main one, which get no signals,
    nothing is held back.

    Needed around gmsh, whose one global state has to be closed properly, and around changes of
    files that must not be left half done.
    """
    # _SIGNAL_NAMES: "SIGINT", "SIGTERM", "SIGHUP"
    signal_numbers = [
        number for name in _SIGNAL_NAMES if (number := getattr(signal, name, None)) is not None
    ]
    handlers = {
        number: handler
        for number in signal_numbers
        if callable(handler := signal.getsignal(number))
    }
    signals_caught: list[int] = []
    # Python delivers signals to the main thread alone: elsewhere there is nothing to hold back.
    if threading.current_thread() is not threading.main_thread() or not handlers:
        yield signals_caught
        return
    for number in handlers:
        signal.signal(number, lambda signal_number, _frame: signals_caught.append(signal_number))
    try:
        yield signals_caught
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if signals_caught:
            first_signal = signal.Signals(signals_caught[0])
            handlers[first_signal](first_signal, None)
