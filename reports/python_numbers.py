"""Scalars of numpy as Python's own numbers, where a computation ends and page, JSON and tables
begin.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def python_number(value: Any) -> Any:
    """A numpy scalar, or a tuple of them, as Python's own number; anything else as it is.

    Page, JSON and tables take `True` for an index and `0.5` for a number; numpy's own scalars are
    neither everywhere.

    >>> python_number(np.float64(0.5)), python_number((np.bool_(True), 1)), python_number("within")
    (0.5, (True, 1), 'within')
    """
    if isinstance(value, np.generic):
        return value.item()
    return tuple(python_number(entry) for entry in value) if type(value) is tuple else value


class PythonNumbers:
    """A frozen record that leaves a computation for the page: its scalars become Python numbers
    when it is made.

    Arrays of shape (k,) and more stay arrays.
    """

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            object.__setattr__(self, name, python_number(value))
