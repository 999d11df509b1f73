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
"""Units that a scene may use: symbol -> its size in N, m or Pa."""
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
_ROUND_OFF_OF_UNITS = 1e-6

Kind = Literal["time", "length", "load", "stress", "angle", "moment"]
"""Kinds of columns."""


def fault_of_units(units: str) -> str:
    """What is wrong with a scene's `units`, and what to do: three known units in another order than
    force, length, stress, or a unit of stress that is not that of force over length squared. Empty
    for a consistent set, and for words that are no known units.

    >>> (
    ...     fault_of_units("N, mm, MPa"),
    ...     fault_of_units("kN, mm, GPa"),
    ...     fault_of_units("SI"),
    ...     fault_of_units("lbf, in, psi"),
    ... )
    ('', '', '', '')
    >>> fault_of_units("N, mm, GPa")
    "N/mm^2 is MPa, not GPa: one set of units is needed, such as 'N, mm, MPa', with every number of
    the scene in it"
    >>> fault_of_units("mm, N, MPa")
    "write force, length and stress in this order with commas between, such as 'N, mm, MPa'"
    """
    # UNITS: for force, length and stress, the size of each known unit in N, m or Pa.
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
    # _ROUND_OFF_OF_UNITS: 1e-6 of a size
    consistent_words = [
        word
        for word, size in UNITS["stress"].items()
        if abs(size / stress_size - 1) < _ROUND_OFF_OF_UNITS
    ]
    if stress_word in consistent_words:
        return ""
    right_unit_text = f"{consistent_words[0]}, " if consistent_words else ""
    fault_text = f"{force_word}/{length_word}^2 is {right_unit_text}not {stress_word}"
    return (
        f"{fault_text}: one set of units is needed, such as 'N, mm, MPa', with every number of the"
        " scene in it"
    )


def unit_in(heading: str) -> tuple[str, str]:
    """Split the heading of a column into the name of its quantity and its unit; the unit is empty
    where the heading has none.

    A unit stands in brackets, behind a slash or "in", or as the last word. Brackets at the end may
    hold any word; "-" and "1" in brackets are no unit.

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

    # A slash or "in" before the unit; else the last word, unless it is a word of names too.
    name_and_unit = re.match(r"(.*?\S)(?:\s*/\s*|\s+in\s+)(\S+)$", text)
    if name_and_unit and is_unit(name_and_unit[2]):
        return name_and_unit[1], name_and_unit[2]
    name, word = _last_word(text)
    # _SHORT_UNITS: "m", "s", "h", "N" and the like
    return (name, word) if is_unit(word) and word not in _SHORT_UNITS else (text, "")


def _last_word(text: str) -> tuple[str, str]:
    """What stands before the last word, and that word; it is empty where there is one word only."""
    words = re.match(r"(.*[^\s_,;])[\s_,;]+([^\s_,;]+)$", text)
    return (words[1], words[2]) if words else (text, "")


def short_unit_in(heading: str, kind: Kind) -> str:
    """Unit of the expected `kind` at the end of a heading without brackets, such as "Time s"; else
    empty.

    Only units are found that are also words of names, so that `unit_in` takes them for part of the
    name.

    >>> (
    ...     short_unit_in("Time s", "time"),
    ...     short_unit_in("Force N", "load"),
    ...     short_unit_in("profile h", "length"),
    ... )
    ('s', 'N', '')
    """
    word = _last_word(heading.strip())[1]
    # _SHORT_UNITS: "m", "s", "h", "N" and the like
    return word if word in _SHORT_UNITS and _si_size(word, kind) is not None else ""


def name_without_unit(heading: str) -> str:
    """A heading without its unit, and without a last word that may be one.

    >>> name_without_unit("Time s"), name_without_unit("P [N]"), name_without_unit("friction force")
    ('Time', 'P', 'friction force')
    """
    name, unit = unit_in(heading)
    text_before_word, word = _last_word(name)
    return text_before_word if not unit and word in _SHORT_UNITS else name


def is_unit(word: str) -> bool:
    """Whether it is a unit of time, angle, length, force, force per length or stress.

    >>> is_unit("N/mm"), is_unit("ms"), is_unit("volts")
    (True, True, False)
    """
    return any(_si_size(word, kind) is not None for kind in _UNITS_OF_FILES)


def _si_size(unit: str, kind: str) -> tuple[float, bool] | None:
    """Size of a unit in SI units (N, m, Pa, rad, s), and whether it is a force per length, whose
    size is in N/m; None for a word that is no unit of this `kind`.

    `kind` is "load", "length", "stress", "angle", "time" or "moment". Only a load may be a force
    per length, such as "N/mm".
    """
    numerator, slash, denominator = unit, "", ""
    if kind == "load":
        numerator, slash, denominator = unit.replace(" ", "").partition("/")
    numerator = _unit_symbol(numerator)
    denominator = _unit_symbol(denominator)
    is_per_length = bool(slash)
    # _UNITS_OF_FILES: for each kind of unit, symbol -> size in SI units
    sizes_by_symbol = _UNITS_OF_FILES[kind]
    length_sizes_by_symbol = _UNITS_OF_FILES["length"]
    if numerator not in sizes_by_symbol or (
        is_per_length and denominator not in length_sizes_by_symbol
    ):
        return None
    return sizes_by_symbol[numerator] / length_sizes_by_symbol.get(denominator, 1.0), is_per_length


def _unit_symbol(word: str) -> str:
    """Symbol of a unit that is written out in one of several languages, such as "um" of "Microns";
    any other word unchanged.

    >>> _unit_symbol("Microns"), _unit_symbol("kN"), _unit_symbol("Micrometer")
    ('um', 'kN', 'um')
    >>> _unit_symbol("millimètres"), _unit_symbol("Sekunden")
    ('mm', 's')
    """
    letters_and_accents = unicodedata.normalize("NFKD", word.strip().rstrip("."))
    word_without_accents = "".join(
        letter for letter in letters_and_accents if not unicodedata.combining(letter)
    ).lower()
    # _SPELLED_UNITS: unit written out -> symbol
    return (
        _SPELLED_UNITS.get(word_without_accents)
        or _SPELLED_UNITS.get(word_without_accents.removesuffix("s"))
        or word
    )


def unit_factor(unit: str, kind: Kind, units: str) -> tuple[float, bool]:
    """Factor that converts a number from `unit` into the unit of the scene, and whether `unit` is a
    force per length. Times are converted into s and angles into rad.

    Parameters
    ----------
    unit
        of the number, such as "kN"
    kind
        of the quantity, such as "load"
    units
        of the scene, such as "N, mm, MPa": force, length, stress

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
    # Size in SI units, and whether it is a force per length.
    size_and_is_per_length = _si_size(unit, kind)
    if size_and_is_per_length is None:
        quantity = "force, or of force per length," if kind == "load" else kind
        # _UNITS_OF_FILES: for each kind, its units
        raise ValueError(
            f"{unit!r} is no unit of {quantity} that is known; known are"
            f" {', '.join(_UNITS_OF_FILES[kind]) or 'none'}"
        )
    si_size, is_per_length = size_and_is_per_length
    if kind in ("time", "angle"):
        return si_size, False

    # Sizes of the scene's units of force, length and stress, from three words at least: empty ones
    # for what the scene does not state. The size is 0 for an unknown word.
    words_of_scene = [*re.split(r"[,\s]+", units), "", "", ""]
    force_size = UNITS["force"].get(words_of_scene[0], 0.0)
    length_size = UNITS["length"].get(words_of_scene[1], 0.0)
    stress_size = UNITS["stress"].get(words_of_scene[2], 0.0)
    load_size = force_size
    if is_per_length:
        load_size = force_size / (length_size or math.inf)

    # Size in SI units of the scene's unit of this kind.
    size_of_scene_unit = {"length": length_size, "load": load_size, "stress": stress_size}[kind]
    if not size_of_scene_unit:
        raise ValueError(
            f"{unit!r} can't be turned into the units of the scene, {units!r}, which are no known"
            " words; use scale"
        )
    # To twelve digits: kN over kN is 1, whatever the round-off of the sizes.
    return float(f"{si_size / size_of_scene_unit:.12g}"), is_per_length
