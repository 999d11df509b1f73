"""Arrays of real numbers from what a Python caller gives: the one door, so that nothing is read by
a part of itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes.errors import InputError, shortened_repr

LARGEST_NUMBER = 1e100
"""Largest number that is admitted, and the inverse of the smallest scale: their squares and
products are numbers.
"""


def real_numbers(values: Any, name: str) -> NDArray[np.float64]:
    """Convert what a Python caller passes as numbers into an array of floats, of any shape; masked
    entries and None become NaN.

    Parameters
    ----------
    values
        a number, nested lists or an array
    name
        of the argument, for the message of a refusal

    Raises
    ------
    InputError
        For complex numbers, truth values, texts, dates, and what is no array of numbers.

    Examples
    --------
    >>> real_numbers(np.ma.masked_greater([1.0, 3.0], 2.0), "load").tolist()
    [1.0, nan]
    >>> real_numbers([1j], "load")
    Traceback (most recent call last):
    scenes.errors.InputError: load = [1j] is refused: real numbers are needed, not complex ones
    """
    # `np.ma`: masked arrays of numpy, whose masked entries have no value.
    try:
        unmasked_values = np.asarray(np.ma.getdata(values))
    except (TypeError, ValueError, OverflowError) as reason:  # such as rows of unequal length
        raise _refusal(values, name, "an array of real numbers is needed") from reason
    if unmasked_values.dtype.kind == "c":
        raise _refusal(values, name, "real numbers are needed, not complex ones")
    # Kinds of numpy's types: "c" complex, "O" Python objects, "iuf" integers and floats.
    if unmasked_values.dtype.kind == "O" and not any(
        isinstance(value, bool | np.bool_ | str | bytes) for value in unmasked_values.flat
    ):
        try:
            unmasked_values = unmasked_values.astype(float)
        except (TypeError, ValueError, OverflowError) as reason:
            raise _refusal(values, name, "real numbers are needed") from reason
    if unmasked_values.dtype.kind not in "iuf":
        raise _refusal(values, name, "real numbers are needed")
    numbers = unmasked_values.astype(float, copy=False)
    mask = np.ma.getmask(values)
    return np.where(mask, np.nan, numbers) if np.any(mask) else numbers


def _refusal(values: Any, name: str, rule: str) -> InputError:
    """The error for an argument called `name` with these `values`, which break the `rule`."""
    return InputError(f"{name} = {shortened_repr(values)} is refused: {rule}")
