"""How an external file is read: names of columns, factors of units, signs, sides. A TOML
file whose keys are optional.
"""

from __future__ import annotations

import difflib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from scenes import InputError
from scenes.array_types import Array
from scenes.column_names import ALIASES, normalised_name
from scenes.files import keys_of
from scenes.frozen import Frozen, checked
from scenes.uncertainty import Share, share_of

ColumnQuantity = Literal[
    "time", "frame", "normal_load", "tangential_load", "x", "y", "pressure", "shear", "slip"
]

# Likeness of two names of columns from which on one may be meant by the other.
_LEAST_SIMILARITY = 0.75

_Factor = Annotated[float, Field(gt=0)]
_Column = str | Annotated[int, Field(ge=1)]


class Columns(Frozen):
    """Names of the columns (arrays, fields) in the file, or numbers from 1 on; those left out are
    looked for under `ALIASES`.
    """

    time: _Column | None = Field(None, description="times of the scene's load path")
    frame: _Column | None = Field(
        None, description="number of the instant, where rows of one instant share one"
    )
    normal_load: _Column | None = Field(None, description="P")
    tangential_load: _Column | None = Field(None, description="Q")
    x: _Column | None = Field(None, description="place along the surface")
    y: _Column | None = Field(
        None, description="place across the surface, for what needs one side told from the other"
    )
    pressure: _Column | None = Field(None, description="contact pressure")
    shear: _Column | None = Field(None, description="shear traction")
    slip: _Column | None = Field(None, description="relative tangential displacement of the faces")


class Factors(Frozen):
    """What a figure of the file is multiplied by to be in the scene's unit. None: 1, and a wrong
    scale may be guessed and named.
    """

    # `length` is the factor of y too
    length: _Factor | None = Field(None, description="of x and slip; 1000 turns m into mm")
    stress: _Factor | None = Field(
        None, description="of pressure and shear; 1e-6 turns Pa into MPa"
    )
    load: _Factor | None = Field(
        None, description="of P and Q per unit thickness; 1e-3 turns N/m into N/mm"
    )
    time: _Factor | None = Field(None, description="of time")


class Signs(Frozen):
    """Which way the file counts. None: as the project does, and a pressure that is negative
    throughout is turned and named.
    """

    pressure: Literal["compression positive", "compression negative"] | None = None
    shear: Literal["on lower", "on upper"] | None = Field(
        None, description="the body on which shear along +x is positive"
    )
    slip: Literal["upper over lower", "lower over upper"] | None = None


class Measured(Frozen):
    """Standard uncertainties of a measured result, by which it stands against theory; a result is
    said to be measured where any is stated.
    """

    dissipation: Share | None = Field(None, description='of W, such as "3 %"')
    largest_pressure: Share | None = Field(None, description="likewise")
    largest_half_width: Share | None = Field(None, description="likewise")

    @property
    def is_stated(self) -> bool:
        """Whether any is stated."""
        return any(value is not None for _, value in self)

    def relative_uncertainty(self, key: str) -> float | None:
        """Standard uncertainty of a value over that value; None where none is stated."""
        stated_share: str | None = getattr(self, key)
        return None if stated_share is None else share_of(stated_share)


class Mapping(Frozen):
    """The keys of a mapping file.

    >>> (
    ...     Mapping().sign("pressure"),
    ...     Mapping.model_validate({"signs": {"shear": "on upper"}}).sign("shear"),
    ... )
    (1.0, -1.0)
    """

    place_of_key_list = "`halfplane score --mapping-example`"

    code: str = Field("", description="what computed it, with its version")
    surface: str | None = Field(
        None,
        description="name of the boundary, cell set or contact pair, where the file has several",
    )
    thickness: _Factor = Field(
        1.0,
        description="out of the plane, in the scene's length: the file's loads are divided by it",
    )
    x_offset: float = Field(
        0.0,
        description="the file's x at the middle of the contact, in the scene's length: taken off x",
    )
    y_offset: float = Field(
        0.0, description="the file's y of the lower body's face, in the scene's length: taken off y"
    )
    times: tuple[float, ...] | None = Field(
        None, description="times of the scene's load path, one an instant, in order"
    )
    element_size: _Factor | None = Field(
        None, description="of the surface at the contact, in the scene's length"
    )
    element_sizes: dict[str, _Factor] = Field(
        {}, description="the same of each file of a folder, by file name"
    )
    columns: Columns = Columns()
    factors: Factors = Factors()
    signs: Signs = Signs()
    measured: Measured = Measured()

    def sign(self, quantity: ColumnQuantity) -> float:
        """-1 where the mapping states that the file counts `quantity` the other way than this
        program, else 1. This program has pressure positive in compression, shear as it acts on the
        lower body, slip of the upper body over the lower one.
        """
        opposite_signs = {
            "pressure": "compression negative",
            "shear": "on upper",
            "slip": "lower over upper",
        }
        if quantity not in opposite_signs:
            return 1.0
        is_opposite = getattr(self.signs, quantity) == opposite_signs[quantity]
        return -1.0 if is_opposite else 1.0


def load_mapping(source: str | Path | None) -> Mapping:
    """The mapping of a TOML file; all defaults for None. InputError with file, key, value and
    rule.
    """
    if source is None:
        return Mapping()
    path = Path(source)
    return checked(Mapping, keys_of(path, "the mapping file"), str(path))


def name_of_column(
    mapping: Mapping,
    quantity: ColumnQuantity,
    names: Sequence[str],
    file_name: str,
    *,
    is_needed: bool = False,
) -> str | None:
    """Name of the column of a file that holds `quantity`, among all its column `names`: the one
    that the mapping states, by name or by number from 1, else the first known alias that is there;
    None where none is.

    `file_name` stands in messages; `is_needed` makes a missing column an error.

    Raises
    ------
    InputError
        Where the mapping names one that is not there, where two names answer to the same alias, or
        where none does and it `is_needed`.
    """
    stated_name = getattr(mapping.columns, quantity)
    if isinstance(stated_name, int):
        if stated_name > len(names):
            raise InputError(
                f"{file_name}: the mapping says columns.{quantity} = {stated_name}, and there are"
                f" {len(names)} columns"
            )
        return names[stated_name - 1]
    if stated_name is not None:
        if stated_name not in names:
            similar_names = difflib.get_close_matches(stated_name, names, n=1)
            hint = f"it has {names_in_words(names)}"
            if similar_names:
                hint = f"did you mean {similar_names[0]!r}?"
            raise InputError(
                f"{file_name}: the mapping says columns.{quantity} = {stated_name!r}, which is not"
                f" there; {hint}"
            )
        return stated_name
    # known names of the quantity; normalised, spellings of one name compare equal
    for alias in ALIASES[quantity]:
        matching_names = [name for name in names if normalised_name(name) == normalised_name(alias)]
        if len(matching_names) > 1:
            raise InputError(
                f"{file_name}: {names_in_words(matching_names)} could each be {quantity}; say which"
                f" by columns.{quantity} of a mapping"
            )
        if matching_names:
            return matching_names[0]
    if is_needed:
        raise InputError(
            f"{file_name}: no column for {quantity} (looked for"
            f" {', '.join(ALIASES[quantity][:4])} ...) among {names_in_words(names)};"
            f" {_naming_advice(quantity, names)}"
        )
    return None


def _naming_advice(quantity: str, names: Sequence[str]) -> str:
    """A phrase for an error message: how to name the column of a quantity in a mapping, with the
    lines to write where one of the column `names` is spelt nearly like the quantity.
    """
    # normalised: spellings of one name compare equal
    name_by_spelling = {normalised_name(name): name for name in names}
    similar_spellings = [
        spelling
        for alias in ALIASES[quantity]
        for spelling in difflib.get_close_matches(
            normalised_name(alias), name_by_spelling, n=1, cutoff=_LEAST_SIMILARITY
        )
    ]
    if not similar_spellings:
        return f"name it by columns.{quantity} of a mapping (`halfplane score --mapping-example`)"
    name = name_by_spelling[similar_spellings[0]]
    return (
        f"if {name!r} is it, write the lines [columns] and {quantity} = {json.dumps(name)} into a"
        " file mapping.toml, and add --mapping mapping.toml"
    )


def names_in_words(names: Sequence[str]) -> str:
    """Names in a sentence, at most eight of them."""
    words_of_more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return ", ".join(map(repr, names[:8])) + words_of_more


def converted_values(mapping: Mapping, quantity: ColumnQuantity, values: Array) -> Array:
    """Values of a file in the scene's unit and the project's signs, as far as the mapping states
    them: times factor and sign; loads divided by the thickness; x and y minus the offset.

    Parameters
    ----------
    quantity
        what the values are, such as "x" or "shear"

    Examples
    --------
    >>> converted_values(Mapping(x_offset=2.0), "x", np.array([2.0, 3.0])).tolist()
    [0.0, 1.0]
    """
    if quantity == "frame":
        return values
    factor_names = {
        "x": "length",
        "y": "length",
        "slip": "length",
        "pressure": "stress",
        "shear": "stress",
        "time": "time",
    }
    factor_name = factor_names.get(quantity, "load")
    # stated by the mapping, or None
    factor = getattr(mapping.factors, factor_name) or 1.0
    with np.errstate(over="ignore"):  # what is not finite is refused by the reader, with its place
        scaled_values = values * factor * mapping.sign(quantity)
        if quantity == "x":
            return np.asarray(scaled_values - mapping.x_offset)
        if quantity == "y":
            return np.asarray(scaled_values - mapping.y_offset)
        if factor_name == "load":
            return np.asarray(scaled_values / mapping.thickness)
        return np.asarray(scaled_values)


def conversion_in_words(mapping: Mapping, quantity: ColumnQuantity) -> str:
    """Name of the quantity that a column of a file holds, and in words what is done to its values
    on reading: times a factor, sign turned, divided by the thickness, minus an offset. `mapping`
    states columns, units and signs of the file.

    >>> conversion_in_words(Mapping(thickness=2.0), "normal_load")
    'normal load, divided by the thickness 2'
    >>> conversion_in_words(Mapping(), "slip")
    'slip'
    """
    converted_zero = converted_values(mapping, quantity, np.zeros(1))
    converted_one = converted_values(mapping, quantity, np.ones(1))
    # sign times factor, over the thickness
    slope = (converted_one - converted_zero)[0]
    is_load = quantity in ("normal_load", "tangential_load")
    thickness = mapping.thickness if is_load else 1.0
    phrases = []
    if abs(slope) * thickness != 1:
        phrases.append(f"times {abs(slope) * thickness:g}")
    if slope < 0:
        phrases.append("sign turned")
    if thickness != 1:
        phrases.append(f"divided by the thickness {thickness:g}")
    offset = {"x": mapping.x_offset, "y": mapping.y_offset}.get(quantity, 0.0)
    if offset:
        phrases.append(f"less {offset:g}")
    return ", ".join([quantity.replace("_", " "), *phrases])


def stated_times(source: str, mapping: Mapping, count: int) -> Array:
    """The times that the mapping states, one for each of the `count` instants of the file;
    InputError where they are not as many.
    """
    times = np.array(mapping.times, dtype=float)
    if len(times) != count:
        raise InputError(
            f"{source}: the mapping states {len(times)} times and the file has {count} instants;"
            " give one for each"
        )
    return times
