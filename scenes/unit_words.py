"""Words for units: their sizes, whether three of them are one consistent set, what turns a column of a file into it."""

from __future__ import annotations

import re
from typing import Literal

# Of each word: its size in N, m and Pa.
FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605, "kip": 4448.2216152605}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "μm": 1e-6, "um": 1e-6, "in": 0.0254}
STRESSES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "psi": 6894.757293168, "ksi": 6894757.293168}
ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": 0.017453292519943295, "°": 0.017453292519943295}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "min": 60.0, "h": 3600.0}
# Of files alone: no scene has them.
_MORE_FORCES, _MORE_LENGTHS = {"mN": 1e-3, "daN": 10.0, "kgf": 9.80665}, {"nm": 1e-9}
_ROUNDING = 1e-6

# Kinds of columns; a moment is not converted.
Kind = Literal["time", "length", "load", "stress", "angle", "moment"]


def stress_in_pascal(word: str) -> float:
    """What a unit of stress is in Pa; 0 for a word that nobody here knows.

    >>> stress_in_pascal("MPa"), stress_in_pascal("stress")
    (1000000.0, 0.0)
    """
    return STRESSES.get(word, 0.0)


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
    known = FORCES.keys() | LENGTHS.keys() | STRESSES.keys()
    if len(words) != 3 or not known.issuperset(words):
        return ""
    force, length, stress = words
    if units.count(",") != 2 or force not in FORCES or length not in LENGTHS or stress not in STRESSES:
        return "write force, length and stress in this order with commas between, such as 'N, mm, MPa'"
    wanted = FORCES[force] / LENGTHS[length] ** 2
    if abs(STRESSES[stress] / wanted - 1) < _ROUNDING:
        return ""
    name = next((f" is {word}," for word, size in STRESSES.items() if abs(size / wanted - 1) < _ROUNDING), " is")
    fault = f"{force}/{length}^2{name} not {stress}"
    return f"{fault}: one set of units is needed, such as 'N, mm, MPa', with every number of the scene in it"


def unit_in(heading: str) -> tuple[str, str]:
    """The name and the unit of a heading; an empty unit where none stands there.

    >>> unit_in("Normal force [kN]"), unit_in("P / N"), unit_in("x (mm)"), unit_in("time"), unit_in("P in N/mm")
    (('Normal force', 'kN'), ('P', 'N'), ('x', 'mm'), ('time', ''), ('P', 'N/mm'))
    """
    text = heading.strip()
    if found := re.match(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$", text):
        return found[1], found[2].strip()
    found = re.match(r"(.*?\S)(?:\s*/\s*|\s+in\s+)(\S+)$", text)
    return (found[1], found[2]) if found and is_unit(found[2]) else (text, "")


def is_unit(word: str) -> bool:
    """Whether it is a unit of time, angle, length, force, force per length or stress.

    >>> is_unit("N/mm"), is_unit("ms"), is_unit("volts")
    (True, True, False)
    """
    return word in TIMES or word in ANGLES or word in STRESSES or _size(word) is not None


def unit_factor(unit: str, kind: Kind, units: str) -> tuple[float, bool]:
    """What turns a number in `unit` into the scene's unit, and whether it is a force per length; time goes to s.

    Parameters
    ----------
    units : those of the scene, such as "N, mm, MPa"

    Raises
    ------
    ValueError
        Half a sentence: for a word that is no unit of this kind, for a scene whose own units are not known words.

    >>> unit_factor("kN", "load", "N, mm, MPa"), unit_factor("kN/m", "load", "N, mm, MPa"), unit_factor("ms", "time", "SI")
    ((1000.0, False), (1.0, True), (0.001, False))
    """
    if kind in ("time", "angle", "moment"):
        known = {"time": TIMES, "angle": ANGLES}.get(kind, {})
        if unit not in known:
            raise ValueError(f"{unit!r} is no unit of {kind} that is known; known are {', '.join(known) or 'none'}")
        return known[unit], False
    if kind == "stress":
        own = STRESSES.get(([*re.split(r"[,\s]+", units), "", "", ""])[2])
        if unit not in STRESSES or own is None:
            raise ValueError(
                f"{unit!r} can't be turned into the stresses of {units!r}; known are {', '.join(STRESSES)}; or use scale"
            )
        return float(f"{STRESSES[unit] / own:.12g}"), False
    size = _size(unit)
    if size is None or size[0] != kind:
        what = {"length": "length", "load": "force, or of force per length,"}[kind]
        known = {"length": LENGTHS | _MORE_LENGTHS, "load": FORCES | _MORE_FORCES}[kind]
        raise ValueError(f"{unit!r} is no unit of {what} that is known; known are {', '.join(known)}")
    force, length = ([*re.split(r"[,\s]+", units), "", ""])[:2]
    if force not in FORCES or length not in LENGTHS:
        raise ValueError(f"{unit!r} can't be turned into the units of the scene, {units!r}, which are no known words; use scale")
    _, value, per_length = size
    own = LENGTHS[length] if kind == "length" else FORCES[force] / (LENGTHS[length] if per_length else 1.0)
    return float(f"{value / own:.12g}"), per_length  # 1e3/1e3 is 1, whatever the quotients' rounding


def _size(unit: str) -> tuple[str, float, bool] | None:
    """Kind, size in N, m or N/m, and whether it is per length; None for what is neither."""
    forces, lengths = FORCES | _MORE_FORCES, LENGTHS | _MORE_LENGTHS
    above, _, below = unit.replace(" ", "").partition("/")
    if above in lengths and not below:
        return "length", lengths[above], False
    if above in forces and below in (*lengths, ""):
        return "load", forces[above] / lengths.get(below, 1.0), bool(below)
    return None
