"""Exit codes, and what the system hands the program: streams that are closed, full, unread or know few signs, and signals."""

from __future__ import annotations

import codecs
import io
import json
import os
import select
import signal
import sys
from collections.abc import Generator
from contextlib import contextmanager

# 0: within tolerance, or nothing to judge; 1: outside or undecided. As shells count: 130 is 128 + SIGINT, 141 128 + SIGPIPE.
WITHIN, OUTSIDE, BAD_INPUT, NOT_CONVERGED, INTERNAL, INTERRUPTED, _UNREAD = 0, 1, 2, 3, 70, 130, 141


def _escaped(fault: UnicodeError) -> tuple[str, int]:
    """Signs that an encoding lacks as their JSON escapes: JSON stays JSON."""
    if not isinstance(fault, UnicodeEncodeError):
        raise fault
    return json.dumps(fault.object[fault.start : fault.end])[1:-1], fault.end


codecs.register_error("halfplane-escaped", _escaped)


class _Outlet(io.FileIO):
    """A stream that keeps the reason why nobody takes its words any more, and lets the work go on."""

    def __init__(self, handle: int) -> None:
        super().__init__(handle, "w", closefd=False)
        self.fault: OSError | None = None

    def write(self, words: object, /) -> int:
        while self.fault is None:
            try:
                written = super().write(words)  # type: ignore[arg-type]
                if written is not None:
                    return written
                select.select([], [self], [])  # a pipe that does not wait by itself, and is full
            except OSError as reason:
                self.fault = reason
        return memoryview(words).nbytes  # type: ignore[arg-type]

    def as_text(self, like: io.TextIOWrapper) -> io.TextIOWrapper:
        """A stream of text on it, its encoding and breaking of lines those of another."""
        buffer, lines = io.BufferedWriter(self), like.line_buffering
        return io.TextIOWrapper(buffer, like.encoding, "halfplane-escaped", line_buffering=lines, write_through=like.write_through)


class _Surroundings:
    """The streams of this process, and the signals that it received, from `settled`."""

    def __init__(self) -> None:
        self.received: list[int] = []
        self._out, self._errors = _Outlet(1), _Outlet(2)

    def take_streams(self) -> None:
        """stdout and stderr from now on; none of another kind, which somebody put there on purpose."""
        if isinstance(sys.stdout, io.TextIOWrapper) and isinstance(sys.stderr, io.TextIOWrapper):
            sys.stdout, sys.stderr = self._out.as_text(sys.stdout), self._errors.as_text(sys.stderr)

    def unwritten(self) -> OSError | None:
        """Why the answer did not get to stdout; None where it did, and where nobody read it to its end."""
        sys.stdout.flush()
        return None if isinstance(self._out.fault, BrokenPipeError) else self._out.fault

    def exit_code(self, code: int) -> int:
        """128 and the signal that ended the process, `_UNREAD` where nobody read the answer to its end, else `code`."""
        if code == INTERRUPTED and self.received:
            return 128 + self.received[0]
        return _UNREAD if isinstance(self._out.fault, BrokenPipeError) else code

    def end(self, number: int, _frame: object) -> None:
        """The handler of a signal: what Ctrl-C does."""
        self.received.append(number)
        raise KeyboardInterrupt


@contextmanager
def settled() -> Generator[_Surroundings, None, None]:
    """Streams that can always be written to, and signals that end the program as Ctrl-C does, until its end.

    A signal that was to be ignored (nohup) stays ignored. Not on Windows, whose terminals and signals are others.
    """
    _open_standard_handles()
    if not os.environ.get("COLUMNS", "80").strip("0"):
        del os.environ["COLUMNS"]  # a terminal of no width is one that did not say
    found = _Surroundings()
    if sys.platform == "win32":
        yield found
        return
    found.take_streams()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, found.end)
    try:
        yield found
    finally:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if callable(signal.getsignal(number)):
                signal.signal(number, signal.SIG_DFL)  # nothing is left to keep


def _open_standard_handles() -> None:
    """Closed ones lead nowhere: else the next file that is opened takes their number, and gets what libraries say."""
    for handle, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(handle)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
        if getattr(sys, name) is None:
            setattr(sys, name, open(handle, "w" if handle else "r", encoding="utf-8", closefd=False))  # noqa: SIM115
