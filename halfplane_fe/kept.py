"""What was worked out for sets of nodes, kept within a bound of bytes: the longest unused gives way."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

T = TypeVar("T")


class Kept(Generic[T]):
    """Values by key; what was asked for last is forgotten last.

    >>> kept = Kept(bound=10)
    >>> for key in (b"a", b"b"):
    ...     _ = kept.put(key, key.decode(), 6)
    >>> kept.get(b"a"), kept.get(b"b")
    (None, 'b')
    """

    def __init__(self, bound: int) -> None:
        self._bound, self._bytes = bound, 0
        self._values: OrderedDict[bytes, tuple[T, int]] = OrderedDict()

    def get(self, key: bytes) -> T | None:
        """The value, which thereby counts as used; None where there is none."""
        if key not in self._values:
            return None
        self._values.move_to_end(key)
        return self._values[key][0]

    def put(self, key: bytes, value: T, nbytes: int) -> T:
        """Keep a value of so many bytes, in place of one that the key may have had, and give it back."""
        self._bytes -= self._values.pop(key, (None, 0))[1]
        self._values[key] = value, nbytes
        self._bytes += nbytes
        while self._bytes > self._bound and len(self._values) > 1:
            self._bytes -= self._values.popitem(last=False)[1][1]
        return value

    def keep_only(self, wanted: Callable[[T], bool]) -> None:
        """Forget all other values."""
        for key in [key for key, (value, _) in self._values.items() if not wanted(value)]:
            self._bytes -= self._values.pop(key)[1]

    def items(self) -> Iterable[tuple[bytes, T]]:
        """All there is."""
        return ((key, value) for key, (value, _) in self._values.items())
