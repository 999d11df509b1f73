"""What CalculiX really wrote (tests/data/README.md), as it is or with pieces of text replaced."""

from pathlib import Path

from reports.scoring.mapping import Mapping
from reports.scoring.reading import read

DATA = Path(__file__).parent / "data"


def result(source, **mapping):
    """The tractions of a data file by its name, or of a file by its whole path."""
    return read(DATA / source, Mapping.model_validate(mapping), None)


def edited(tmp_path, name, *changes):
    """A copy of a data file with pieces of text replaced."""
    text = (DATA / name).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / name
    path.write_text(text)
    return path
