"""Units and numbers as the page and the terminal write them; scalars of numpy as Python's own
numbers, where a computation ends and page, JSON and tables begin.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from scenes import Scene


def units(scene: Scene) -> tuple[str, str, str]:
    """Names of force, length and stress."""
    return scene.unit_words


def load_unit(scene: Scene) -> str:
    """Unit of a load per thickness.

    >>> from scenes import load_scene
    >>> load_unit(load_scene("hertz-paper"))
    'N/mm'
    """
    unit_of_force, unit_of_length, _ = units(scene)
    return f"{unit_of_force}/{unit_of_length}"


def energy_unit(scene: Scene) -> str:
    """Unit of an energy per thickness.

    >>> from scenes import load_scene
    >>> energy_unit(load_scene("hertz-paper"))
    'N·mm/mm'
    """
    unit_of_force, unit_of_length, _ = units(scene)
    return f"{unit_of_force}·{unit_of_length}/{unit_of_length}"


def signed(value: float) -> str:
    """Four significant digits, with a minus sign that is one.

    >>> signed(-0.28273), signed(0.5)
    ('−0.2827', '0.5')
    """
    return minus(f"{value:.4g}")


def number(value: float) -> str:
    """Six significant digits, with a minus sign that is one.

    >>> number(90.62286500739786), number(-210e3)
    ('90.6229', '−210000')
    """
    return minus(f"{value:.6g}")


def significant(value: float, n_digits: int) -> str:
    """A number as text, rounded to `n_digits` significant digits, among them zeros behind the
    point; a dash for NaN and infinity.

    >>> significant(4.0, 2), significant(184.2, 2), significant(2.5e-6, 2)
    ('4.0', '180', '2.5e−06')
    """
    if not math.isfinite(value):
        return "–"
    # Digits before the point beyond `n_digits` become zeros.
    if abs(value) >= 10**n_digits:
        return minus(f"{float(f'{value:.{n_digits}g}'):.0f}")
    keeps_zeros = 0 < abs(value) < 10 ** (n_digits - 1)
    return minus(f"{value:{'#' if keeps_zeros else ''}.{n_digits}g}")


def minus(figure: str) -> str:
    """A figure as Python prints it, with minus signs for hyphens.

    >>> minus("-2.0e-06"), minus("8.6")
    ('−2.0e−06', '8.6')
    """
    return figure.replace("-", "−")


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
