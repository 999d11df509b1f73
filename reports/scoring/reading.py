"""Which reader takes which file."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from reports.scoring.mapping import Mapping
from reports.scoring.surface import SurfaceResult
from scenes import InputError, Scene

# Suffix -> module and function, each read(path, mapping, scene) -> SurfaceResult; loaded when a file asks for it.
READERS: dict[str, str] = {
    ".csv": "reports.scoring.reading_csv:read",
    ".txt": "reports.scoring.reading_csv:read",
    ".rpt": "reports.scoring.reading_csv:read",
    ".frd": "reports.scoring.calculix_surface:read",
    ".dat": "reports.scoring.calculix_printed:read",
    **dict.fromkeys((".vtu", ".vtk", ".pvd", ".series", ".xdmf", ".xmf"), "reports.scoring.reading_fields:read"),
}


def read(path: Path, mapping: Mapping, scene: Scene) -> SurfaceResult:
    """The result in the file, in the scene's units and our signs as far as the mapping says.

    Raises
    ------
    InputError
        One sentence: no such file, no reader for it, or what its reader found.
    """
    if not path.exists():
        raise InputError(f"{path}: there is no such file")
    home = READERS.get(path.suffix.lower())
    if home is None:
        raise InputError(
            f"{path}: no reader for {path.suffix or 'a file without suffix'!r}; it reads {', '.join(sorted(READERS))}, .nc"
        )
    module, function = home.split(":")
    found = getattr(import_module(module), function)(path, mapping, scene)
    if not isinstance(found, SurfaceResult):
        raise TypeError(f"{home} returned {type(found).__name__}")
    return found
