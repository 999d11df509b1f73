"""NetCDF files of named arrays with their units, by h5netcdf: xarray reads them, and is not needed
to write or to read them.
"""

from __future__ import annotations

import io
import math
import sys
import traceback
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes.errors import InputError, first_line, in_words
from scenes.files import require_readable_size, within_memory

# Bytes that are read at most, in the file and unpacked; what the file is to the user.
LARGEST_SOLUTION_BYTES = 2**31
_ROLE = "the solution"
# What the library raises on files that are broken off, spoilt or something else.
_READING_FAULTS = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    IndexError,
    RuntimeError,
    OverflowError,
)
_NO_ATTRIBUTES: Mapping[str, str] = MappingProxyType({})


class StoredArray(NamedTuple):
    """An array as a file holds it.

    Attributes
    ----------
    dimensions
        a name for each axis
    values
        numbers, or words
    attributes
        such as "units" and "long_name"
    """

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, str] = _NO_ATTRIBUTES


class StoredArrays(NamedTuple):
    """What one file holds: arrays by name, and words and numbers of the whole."""

    arrays: Mapping[str, StoredArray]
    attributes: Mapping[str, Any]


def netcdf_of(content: StoredArrays) -> memoryview:
    """Bytes of a NetCDF-4 file that holds named arrays, with their axes, units and attributes.

    `content` holds the arrays by name, each with its dimensions (names of axes), values and
    attributes, and the attributes of the file. Missing floats are marked by NaN, as xarray does;
    the coordinates along an axis have none missing. HDF5 writes to memory, since on a full disk it
    would end the process once the file is closed.
    """
    import h5netcdf
    import h5py

    buffer = io.BytesIO()
    with h5netcdf.File(buffer, "w") as file:
        for name, stored_array in content.arrays.items():
            values = np.asarray(stored_array.values)
            for dimension, length in zip(stored_array.dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = length
            holds_words = values.dtype.kind == "U"
            is_coordinate = stored_array.dimensions == (name,)
            fill_value = np.nan if values.dtype.kind == "f" and not is_coordinate else None
            variable = file.create_variable(
                name,
                stored_array.dimensions,
                h5py.string_dtype() if holds_words else values.dtype,
                data=values.astype(object) if holds_words else values,
                fillvalue=fill_value,
            )
            variable.attrs.update(stored_array.attributes)
        file.attrs.update(content.attributes)
    return buffer.getbuffer()


def read_netcdf(
    path: Path, axes_of_arrays: Mapping[str, tuple[str, ...]], newest_format: str
) -> StoredArrays:
    """Read all arrays and attributes of a stored solution from a NetCDF file, after checks of its
    size, format and arrays.

    Parameters
    ----------
    path
        of the file
    axes_of_arrays
        name -> names of the axes, for each array of real numbers that has to be in the file
    newest_format
        name and number of the newest format that can be read, such as "halfplane solution 2"

    Raises
    ------
    InputError
        One sentence: the file can't be read, is too large once unpacked, lacks an array, or is of a
        later format.
    """
    import h5netcdf

    # Of a file that it could not open h5netcdf prints a traceback when it is deleted from memory:
    # silenced, since the error that is raised says all.
    former_hook = sys.unraisablehook
    sys.unraisablehook = lambda _fault: None
    try:
        # LARGEST_SOLUTION_BYTES: 2 GB; `_ROLE` is "the solution", for messages
        require_readable_size(path, _ROLE, LARGEST_SOLUTION_BYTES)
        # Dimensions that an HDF5 file does not name are numbered, and refused by their names.
        # Arrays take the limit at most; as much again is left to buffers of the library.
        with (
            within_memory(path, 2 * LARGEST_SOLUTION_BYTES),
            h5netcdf.File(path, "r", phony_dims="access") as file,
        ):
            # Each check refuses the file by an InputError.
            _require_room(path, file)
            attributes = {str(key): _single_value(file.attrs[key]) for key in file.attrs}
            _require_format(path, attributes, newest_format)
            _require_arrays(path, file, axes_of_arrays)
            # Arrays with their dimensions, values and attributes.
            arrays = {
                str(name): _stored_array_of(variable) for name, variable in file.variables.items()
            }
            _require_lengths(path, arrays)
            return StoredArrays(arrays, attributes)
    except InputError:
        raise
    # _READING_FAULTS: what the library raises on files that are broken off or spoilt
    except _READING_FAULTS as reason:
        traceback.clear_frames(reason.__traceback__)
        raise InputError(f"{path}: {_ROLE} can't be read: {first_line(reason)}") from reason
    finally:
        sys.unraisablehook = former_hook


def _require_room(path: Path, file: Any) -> None:
    """Refuse an open NetCDF file whose arrays would take more than 2 GB of memory once unpacked,
    before any is unpacked (InputError).
    """
    unpacked_bytes = sum(
        math.prod(map(int, variable.shape)) * variable.dtype.itemsize
        for variable in file.variables.values()
    )
    # LARGEST_SOLUTION_BYTES: 2 GB; `_ROLE` is "the solution"
    if unpacked_bytes > LARGEST_SOLUTION_BYTES:
        raise InputError(
            f"{path}: {_ROLE} takes {in_words(unpacked_bytes)} once unpacked, and at most"
            f" {in_words(LARGEST_SOLUTION_BYTES)} are read"
        )


def _require_format(path: Path, attributes: Mapping[str, Any], newest_format: str) -> None:
    """Refuse a stored solution of a later format than `newest_format`, or of the first one, which
    is read no more (InputError); a file that states no format and no engine passes.

    It is called before the arrays are looked for, since in another format they may have other
    names. `attributes` are those of the file as a whole; a format is a name and a number, such as
    "halfplane solution 2".
    """
    format_name, _, newest_version = newest_format.rpartition(" ")
    if "format" not in attributes:
        if "engine" in attributes:
            raise InputError(
                f"{path}: this solution was written by version 0.1, which is read no more; load and"
                " save it with halfplane 0.3, or solve the scene again"
            )
        return
    stated_format = str(attributes["format"])
    stated_name, _, stated_version = stated_format.rpartition(" ")
    if (
        stated_name == format_name
        and stated_version.isdecimal()
        and int(stated_version) > int(newest_version)
    ):
        raise InputError(
            f"{path}: format is '{stated_format}', of a later version, and this one reads"
            f" '{newest_format}'; update halfplane, or solve the scene again"
        )


def _require_arrays(path: Path, file: Any, axes_of_arrays: Mapping[str, tuple[str, ...]]) -> None:
    """Refuse an open NetCDF file in which an array is missing, has other axes than expected, or
    holds no real numbers (InputError).

    `axes_of_arrays` maps the name of each expected array to the names of its axes; `path` is for
    the message.
    """
    for name, axes in axes_of_arrays.items():
        if name not in file.variables:
            # _ROLE: "the solution"
            raise InputError(f"{path}: {_ROLE} can't be read: {name} is missing")
        variable = file.variables[name]
        if variable.dimensions != axes or variable.dtype.kind not in "fiu":
            raise InputError(
                f"{path}: {_ROLE} can't be read: {name} should be numbers over"
                f" {' and '.join(axes)}, and is {variable.dtype} over"
                f" {' and '.join(map(str, variable.dimensions)) or 'nothing'}"
            )
    for name, variable in file.variables.items():
        if variable.dtype.kind == "c":
            raise InputError(
                f"{path}: {_ROLE} can't be read: {name} holds complex numbers, and should hold real"
                " ones"
            )


def _require_lengths(path: Path, arrays: Mapping[str, StoredArray]) -> None:
    """Refuse arrays of one file that differ in length along an axis they share (InputError).

    It looks at the unpacked values: h5netcdf reports one length of an axis for every array.
    `arrays` are by name, each with the names of its axes (`dimensions`) and its values; `path` is
    for the message.
    """
    lengths: dict[str, int] = {}
    for name, stored_array in arrays.items():
        for dimension, length in zip(
            stored_array.dimensions, stored_array.values.shape, strict=True
        ):
            expected_length = lengths.setdefault(dimension, length)
            if length != expected_length:
                # _ROLE: "the solution"
                raise InputError(
                    f"{path}: {_ROLE} can't be read: {name} has {length} values over {dimension},"
                    f" and others have {expected_length}"
                )


def _stored_array_of(variable: Any) -> StoredArray:
    """An array of an open file with the names of its axes, its values and attributes."""
    attributes = {str(key): _single_value(variable.attrs[key]) for key in variable.attrs}
    return StoredArray(tuple(variable.dimensions), np.asarray(variable[...]), attributes)


def _single_value(value: Any) -> Any:
    """A number or a word in the place of an array of one."""
    return value.item() if isinstance(value, np.ndarray | np.generic) and value.size == 1 else value
