"""The lag of Q behind P as callers give it: in degrees, or in radians under a name that says so."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from scenes import InputError
from scenes.arrays import real_numbers

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def phase_in_radians(phase_degrees: ArrayLike | None, phase_radians: ArrayLike | None) -> ArrayLike:
    """The phase lag of Q behind P in radians, any shape, from one in degrees or in radians; pi/2
    where neither is given.

    Raises
    ------
    InputError
        For both at once, and for degrees that are no real numbers.

    Examples
    --------
    >>> float(phase_in_radians(180.0, None)) == math.pi
    True
    """
    if phase_degrees is None:
        return math.pi / 2 if phase_radians is None else phase_radians
    if phase_radians is not None:
        raise InputError("phase_degrees and phase_radians are both given: give one of them")
    return np.radians(real_numbers(phase_degrees, "phase_degrees"))


def accepts_phase(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """Decorator: the function also takes `phase`, the old name of `phase_radians`, for one release,
    with a DeprecationWarning. InputError where both names are given.
    """

    @wraps(function)
    def with_old_name(*arguments: Arguments.args, **keywords: Arguments.kwargs) -> Result:
        """Call the function with `phase`, the old name, passed on as `phase_radians`, and warn."""
        if "phase" in keywords:
            name = function.__name__
            if "phase_radians" in keywords:
                raise InputError(f"{name}: phase is the old name of phase_radians: give one")
            warnings.warn(
                f"{name}: phase, in radians, is the old name of phase_radians and leaves with the"
                " next release: give phase_degrees or phase_radians",
                DeprecationWarning,
                stacklevel=2,
            )
            keywords["phase_radians"] = keywords.pop("phase")
        return function(*arguments, **keywords)

    return with_old_name
