"""What a refusal must say: the file, the key, the value, and the rule in a few words."""

from __future__ import annotations

import re
from collections.abc import Generator
from contextlib import contextmanager

import pytest

from scenes import InputError


@contextmanager
def refused_for(*facts: str, error: type[Exception] = InputError) -> Generator[None, None, None]:
    """The block raises `error`, and its message names each of `facts`."""
    with pytest.raises(error) as caught:
        yield
    require_facts(str(caught.value), *facts)


def require_facts(message: str, *facts: str) -> None:
    """Each of `facts` stands in the message, which may be broken into lines."""
    plain = re.sub(r"\s+", " ", message)
    missing = [fact for fact in facts if fact not in plain]
    assert not missing, f"{missing} not in: {message}"
