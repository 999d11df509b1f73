"""Whether the words of a scene's `units` can be one set: a stress is a force over a squared length."""

from __future__ import annotations

import re

# Of each word: its size in N, m and Pa.
_FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605, "kip": 4448.2216152605}
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "μm": 1e-6, "um": 1e-6, "in": 0.0254}
_STRESSES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "psi": 6894.757293168, "ksi": 6894757.293168}
_ROUNDING = 1e-6


def stress_in_pascal(word: str) -> float:
    """What a unit of stress is in Pa; 0 for a word that nobody here knows.

    >>> stress_in_pascal("MPa"), stress_in_pascal("stress")
    (1000000.0, 0.0)
    """
    return _STRESSES.get(word, 0.0)


def inconsistent(units: str) -> str:
    """Why `units` can't be right, with what to do; empty for a consistent set, and for words that nobody here knows.

    >>> inconsistent("N, mm, MPa"), inconsistent("kN, mm, GPa"), inconsistent("SI"), inconsistent("lbf, in, psi")
    ('', '', '', '')
    >>> inconsistent("N, mm, GPa")
    "N/mm^2 is MPa, not GPa: one set of units is needed, such as 'N, mm, MPa', with every number of the scene in it"
    >>> inconsistent("mm, N, MPa")
    "write force, length and stress in this order with commas between, such as 'N, mm, MPa'"
    """
    words = [word for word in re.split(r"[,\s]+", units) if word]
    known = _FORCES.keys() | _LENGTHS.keys() | _STRESSES.keys()
    if len(words) != 3 or not known.issuperset(words):
        return ""
    force, length, stress = words
    if units.count(",") != 2 or force not in _FORCES or length not in _LENGTHS or stress not in _STRESSES:
        return "write force, length and stress in this order with commas between, such as 'N, mm, MPa'"
    wanted = _FORCES[force] / _LENGTHS[length] ** 2
    if abs(_STRESSES[stress] / wanted - 1) < _ROUNDING:
        return ""
    name = next((f" is {word}," for word, size in _STRESSES.items() if abs(size / wanted - 1) < _ROUNDING), " is")
    fault = f"{force}/{length}^2{name} not {stress}"
    return f"{fault}: one set of units is needed, such as 'N, mm, MPa', with every number of the scene in it"
