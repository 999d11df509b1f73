"""Stored answers: written whole, and read back with names, dimensions and sizes checked before any array is unpacked."""

from __future__ import annotations

import io
import sys
import traceback
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scenes.bounded import SOLUTION, check_size, in_words, shown, within_memory
from scenes.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

# What the libraries raise on files that are broken off, spoilt or something else.
_FAULTS = (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, RuntimeError, OverflowError)
WHAT = "the solution"


def netcdf_of(data: xr.Dataset) -> memoryview:
    """The bytes of a NetCDF file.

    HDF5 writes to memory: a disk that is full under it leaves it in a state that ends the process once the file is closed.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        data.dump_to_store(H5NetCDFStore(file))
    return content.getbuffer()


def stored_dataset(path: Path, form: Mapping[str, tuple[str, ...]]) -> xr.Dataset:
    """The dataset in a NetCDF file, in memory, with every variable of `form` (name -> dimensions) there and made of numbers.

    Raises
    ------
    InputError
        One sentence: it can't be read, is larger than the limit once unpacked, or is of another form.
    """
    with _closing_in_silence():
        try:
            check_size(path, WHAT, SOLUTION)
            with within_memory(path, 2 * SOLUTION), _opened(path) as data:
                _check_form(path, data, form)
                return data.load()
        except InputError:
            raise
        except _FAULTS as reason:
            traceback.clear_frames(reason.__traceback__)
            raise InputError(f"{path}: {WHAT} can't be read: {first_line(reason)}") from reason


def _opened(path: Path) -> xr.Dataset:
    """Nothing of it is unpacked yet; dimensions that an HDF5 file does not name are numbered, and refused by their names."""
    import xarray as xr

    return xr.open_dataset(path, engine="h5netcdf", phony_dims="access")


@contextmanager
def _closing_in_silence() -> Generator[None, None, None]:
    """h5netcdf prints a traceback of its own when a file goes that it could not open; the refusal says all there is to say."""
    before, sys.unraisablehook = sys.unraisablehook, lambda _fault: None
    try:
        yield
    finally:
        sys.unraisablehook = before


def first_line(reason: BaseException) -> str:
    """The first line of an error's text, its beginning; its kind where it says nothing."""
    lines = str(reason).splitlines()
    return shown(lines[0])[1:-1] if lines and lines[0] else type(reason).__name__


def _check_form(path: Path, data: xr.Dataset, form: Mapping[str, tuple[str, ...]]) -> None:
    unpacked = sum(int(np.prod(variable.shape, dtype=object)) * variable.dtype.itemsize for variable in data.variables.values())
    if unpacked > SOLUTION:
        raise InputError(f"{path}: {WHAT} takes {in_words(unpacked)} once unpacked, and at most {in_words(SOLUTION)} are read")
    for name, dimensions in form.items():
        if name not in data.variables:
            raise InputError(f"{path}: {WHAT} can't be read: {name} is missing")
        variable = data.variables[name]
        if variable.dims != dimensions or variable.dtype.kind not in "fiu":
            raise InputError(
                f"{path}: {WHAT} can't be read: {name} should be numbers over {' and '.join(dimensions)}, and is "
                f"{variable.dtype} over {' and '.join(map(str, variable.dims)) or 'nothing'}"
            )
