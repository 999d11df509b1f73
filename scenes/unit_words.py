"""Words for units: their sizes, whether three of them are one consistent set, what turns a column
of a file into it.
"""

from __future__ import annotations

import math
import re
import unicodedata
from typing import Literal

UNITS = {
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605, "kip": 4448.2216152605},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "μm": 1e-6, "um": 1e-6, "in": 0.0254},
    "stress": {
        "Pa": 1.0,
        "kPa": 1e3,
        "MPa": 1e6,
        "GPa": 1e9,
        "psi": 6894.757293168,
        "ksi": 6894757.293168,
    },
}
"""What a scene may be in: the size of each word in N, m and Pa."""
_UNITS_OF_FILES = {
    "load": UNITS["force"] | {"mN": 1e-3, "daN": 10.0, "kgf": 9.80665},
    "length": UNITS["length"] | {"nm": 1e-9},
    "stress": UNITS["stress"],
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": 0.017453292519943295, "°": 0.017453292519943295},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "min": 60.0, "h": 3600.0},
    "moment": {},  # is not converted
}
# Units written out in the languages of `column_names`, in lower case without accents; a plural's s
# is left out.
_SPELLED_UNITS = {
    "micron": "um",
    "mikron": "um",
    "micrometer": "um",
    "micrometre": "um",
    "mikrometer": "um",
    "micrometro": "um",
    "micrometri": "um",
    "nanometer": "nm",
    "nanometre": "nm",
    "nanometro": "nm",
    "nanometri": "nm",
    "millimeter": "mm",
    "millimetre": "mm",
    "millimetro": "mm",
    "milimetro": "mm",
    "millimetri": "mm",
    "centimeter": "cm",
    "centimetre": "cm",
    "meter": "m",
    "metre": "m",
    "metro": "m",
    "inch": "in",
    "inche": "in",  # inches
    "newton": "N",
    "kilonewton": "kN",
    "millinewton": "mN",
    "pascal": "Pa",
    "kilopascal": "kPa",
    "megapascal": "MPa",
    "gigapascal": "GPa",
    "second": "s",
    "sec": "s",
    "sek": "s",
    "sekunde": "s",
    "sekunden": "s",
    "seconde": "s",
    "secondo": "s",
    "secondi": "s",
    "segundo": "s",
    "millisecond": "ms",
    "millisekunden": "ms",
    "microsecond": "us",
    "minute": "min",
    "minuten": "min",
    "hour": "h",
    "stunden": "h",
    "radian": "rad",
    "milliradian": "mrad",
    "degree": "deg",
}
# Words that are units in brackets and more than that as the last word of a heading: "gap min",
# "profile h".
_SHORT_UNITS = ("m", "s", "h", "N", "in", "min", "°")
_ROUNDING = 1e-6

Kind = Literal["time", "length", "load", "stress", "angle", "moment"]
"""Kinds of columns."""


def inconsistent(units: str) -> str:
    """Check that the unit of stress in a scene's `units` is that of force over length squared: the
    fault with what to do; empty for a consistent set, and for unknown words.

    >>> (
    ...     inconsistent("N, mm, MPa"),
    ...     inconsistent("kN, mm, GPa"),
    ...     inconsistent("SI"),
    ...     inconsistent("lbf, in, psi"),
    ... )
    ('', '', '', '')
    >>> inconsistent("N, mm, GPa")
    "N/mm^2 is MPa, not GPa: one set of units is needed, such as 'N, mm, MPa', with every number of
    the scene in it"
    >>> inconsistent("mm, N, MPa")
    "write force, length and stress in this order with commas between, such as 'N, mm, MPa'"
    """
    words = [word for word in re.split(r"[,\s]+", units) if word]
    if len(words) != 3 or not set().union(*UNITS.values()).issuperset(words):
        return ""
    if units.count(",") != 2 or any(
        word not in known_units for word, known_units in zip(words, UNITS.values(), strict=True)
    ):
        return (
            "write force, length and stress in this order with commas between, such as 'N, mm, MPa'"
        )
    force_word, length_word, stress_word = words
    stress_size = UNITS["force"][force_word] / UNITS["length"][length_word] ** 2
    right_words = [
        word for word, size in UNITS["stress"].items() if abs(size / stress_size - 1) < _ROUNDING
    ]
    if stress_word in right_words:
        return ""
    unit_of_stress = f"{right_words[0]}, " if right_words else ""
    fault_text = f"{force_word}/{length_word}^2 is {unit_of_stress}not {stress_word}"
    return (
        f"{fault_text}: one set of units is needed, such as 'N, mm, MPa', with every number of the"
        " scene in it"
    )


def unit_in(heading: str) -> tuple[str, str]:
    """Split the heading of a column into the name of its quantity and its unit; the unit is empty
    where the heading has none.

    A unit stands in brackets, behind a slash or "in", or as the last word. Brackets at the end may
    hold any word.

    >>> (
    ...     unit_in("Normal force [kN]"),
    ...     unit_in("P / N"),
    ...     unit_in("x (mm)"),
    ...     unit_in("time"),
    ...     unit_in("P in N/mm"),
    ... )
    (('Normal force', 'kN'), ('P', 'N'), ('x', 'mm'), ('time', ''), ('P', 'N/mm'))
    >>> (
    ...     unit_in("X_(microns)"),
    ...     unit_in("Lateral um"),
    ...     unit_in("Raw Micrometer"),
    ...     unit_in("x_mm"),
    ...     unit_in("gap min"),
    ... )
    (('X', 'microns'), ('Lateral', 'um'), ('Raw', 'Micrometer'), ('x', 'mm'), ('gap min', ''))
    >>> unit_in("Force [N] filtered"), unit_in("Q (left)"), unit_in("U [-]")
    (('Force', 'N'), ('Q', 'left'), ('U', ''))
    """
    text = heading.strip()
    for bracket in re.finditer(r"[\[({<]([^][(){}<>]*)[\])}>]", text):
        bracketed_word = bracket[1].strip().removeprefix("in ").strip()
        is_last = bracket.end() == len(text)
        if is_unit(bracketed_word) or is_last:
            name = text[: bracket.start()].rstrip(" _,;:-")
            has_no_dimension = bracketed_word in ("-", "1")
            return name, "" if has_no_dimension else bracketed_word
    name_and_unit = re.match(r"(.*?\S)(?:\s*/\s*|\s+in\s+)(\S+)$", text)
    if name_and_unit and is_unit(name_and_unit[2]):
        return name_and_unit[1], name_and_unit[2]
    name, word = _last_word(text)
    return (name, word) if is_unit(word) and word not in _SHORT_UNITS else (text, "")


def _last_word(text: str) -> tuple[str, str]:
    """What stands before the last word, and that word; it is empty where there is one word only."""
    words = re.match(r"(.*[^\s_,;])[\s_,;]+([^\s_,;]+)$", text)
    return (words[1], words[2]) if words else (text, "")


def short_unit_in(heading: str, kind: Kind) -> str:
    """Unit at the end of a heading without brackets, such as "Time s", if it is a unit of at most
    three letters and of the expected kind; else empty.

    >>> (
    ...     short_unit_in("Time s", "time"),
    ...     short_unit_in("Force N", "load"),
    ...     short_unit_in("profile h", "length"),
    ... )
    ('s', 'N', '')
    """
    word = _last_word(heading.strip())[1]
    return word if word in _SHORT_UNITS and _size(word, kind) is not None else ""


def name_without_unit(heading: str) -> str:
    """A heading without its unit, and without a last word that may be one.

    >>> name_without_unit("Time s"), name_without_unit("P [N]"), name_without_unit("friction force")
    ('Time', 'P', 'friction force')
    """
    name, unit = unit_in(heading)
    text_before, word = _last_word(name)
    return text_before if not unit and word in _SHORT_UNITS else name


def is_unit(word: str) -> bool:
    """Whether it is a unit of time, angle, length, force, force per length or stress.

    >>> is_unit("N/mm"), is_unit("ms"), is_unit("volts")
    (True, True, False)
    """
    return any(_size(word, kind) is not None for kind in _UNITS_OF_FILES)


def _size(unit: str, kind: str) -> tuple[float, bool] | None:
    """Size of a unit in SI units (N, m, Pa, rad, s; N/m of a force per length), and whether it is
    per length; None where the word is no unit of this `kind`.
    """
    numerator, slash, denominator = (
        unit.replace(" ", "").partition("/") if kind == "load" else (unit, "", "")
    )
    numerator = _symbol(numerator)
    denominator = _symbol(denominator)
    if numerator not in _UNITS_OF_FILES[kind] or (
        slash and denominator not in _UNITS_OF_FILES["length"]
    ):
        return None
    return _UNITS_OF_FILES[kind][numerator] / _UNITS_OF_FILES["length"].get(denominator, 1.0), bool(
        slash
    )


def _symbol(word: str) -> str:
    """Symbol of a unit that is written out in one of several languages, such as "um" of "Microns";
    any other word unchanged.

    >>> _symbol("Microns"), _symbol("kN"), _symbol("Micrometer")
    ('um', 'kN', 'um')
    >>> _symbol("millimètres"), _symbol("Sekunden")
    ('mm', 's')
    """
    letters = unicodedata.normalize("NFKD", word.strip().rstrip("."))
    word_alone = "".join(letter for letter in letters if not unicodedata.combining(letter)).lower()
    return (
        _SPELLED_UNITS.get(word_alone) or _SPELLED_UNITS.get(word_alone.removesuffix("s")) or word
    )


def unit_factor(unit: str, kind: Kind, units: str) -> tuple[float, bool]:
    """Factor that turns a number in one unit into the unit of the scene, and whether the unit is a
    force per length; times go to s, angles to rad.

    Parameters
    ----------
    unit
        of the number, such as "kN"
    kind
        of the quantity, such as "load"
    units
        units of the scene, such as "N, mm, MPa"

    Raises
    ------
    ValueError
        Half a sentence: for a word that is no unit of this kind, for a scene whose own units are
        not known words.

    Examples
    --------
    >>> (
    ...     unit_factor("kN", "load", "N, mm, MPa"),
    ...     unit_factor("kN/m", "load", "N, mm, MPa"),
    ...     unit_factor("ms", "time", "SI"),
    ... )
    ((1000.0, False), (1.0, True), (0.001, False))
    """
    size_and_form = _size(unit, kind)
    if size_and_form is None:
        quantity = "force, or of force per length," if kind == "load" else kind
        raise ValueError(
            f"{unit!r} is no unit of {quantity} that is known; known are"
            f" {', '.join(_UNITS_OF_FILES[kind]) or 'none'}"
        )
    unit_size, per_length = size_and_form
    words_of_scene = [*re.split(r"[,\s]+", units), "", "", ""]
    force_size, length_size, stress_size = (
        known_units.get(word, 0.0)
        for word, known_units in zip(words_of_scene, UNITS.values(), strict=False)
    )
    if kind in ("time", "angle"):
        return unit_size, False
    scene_size = {
        "length": length_size,
        "load": force_size / ((length_size or math.inf) if per_length else 1.0),
        "stress": stress_size,
    }[kind]
    if not scene_size:
        raise ValueError(
            f"{unit!r} can't be turned into the units of the scene, {units!r}, which are no known"
            " words; use scale"
        )
    # To twelve digits: kN over kN is 1, whatever the rounding of the sizes.
    return float(f"{unit_size / scene_size:.12g}"), per_length
