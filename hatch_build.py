"""The wheel: the five packages inside `halfplane`, with their imports rewritten to match.

At the top of site-packages they would stand beside a user's own `reports` or `scenes`. Line numbers
stay: a traceback of the wheel leads to the line of the checkout. An editable installation is the
checkout as it is; halfplane/package_names.py joins the two.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")
LOADERS = ("import_module", "find_spec", "files", "PackageLoader", "source_digest")
# What the engines once gave; no command reads it.
PUBLISHED = re.compile(r"reports/published/")
_ANY = rf"({'|'.join(PACKAGES)})\b"
_BEGIN = r"(?m)^(\s*(?:>>> |\.\.\. )?)"  # of a line of code, or of an example in a docstring
RULES = (
    (re.compile(rf"{_BEGIN}from {_ANY}(?=[\w.]* import\b)"), r"\1from halfplane.\2"),
    (re.compile(rf"{_BEGIN}import {_ANY}(?=\s*$)"), r"\1from halfplane import \2"),
    (re.compile(rf'(\b(?:{"|".join(LOADERS)})\(f?"){_ANY}(?=[".])'), r"\1halfplane.\2"),
)
_DOTTED = re.compile(rf'(?<="){_ANY}(\.\w+)+(?=")')


def rewritten(text: str, root: Path) -> str:
    """The text of a module with the packages inside `halfplane`: imports, examples of docstrings,
    and strings that name a module. That no other way to import them is in use, a test says.

    >>> rewritten("from scenes import Scene", Path())
    'from halfplane.scenes import Scene'
    """
    for rule, replacement in RULES:
        text = rule.sub(replacement, text)

    def with_prefix(name: re.Match[str]) -> str:
        path = root / name[0].replace(".", "/")
        is_module = path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()
        return f"halfplane.{name[0]}" if is_module else name[0]

    return _DOTTED.sub(with_prefix, text)


def write_tree(root: Path, target: Path) -> None:
    """The package `halfplane` as the wheel has it, in the folder `target`."""
    for folder in ("halfplane", *PACKAGES):
        for path in sorted((root / folder).rglob("*")):
            name = path.relative_to(root).as_posix()
            if path.is_dir() or "__pycache__" in path.parts or PUBLISHED.match(name):
                continue
            place = target / name.removeprefix("halfplane/")
            place.parent.mkdir(parents=True, exist_ok=True)
            if path.suffix == ".py":
                place.write_text(rewritten(path.read_text("utf-8"), root), "utf-8")
            else:
                shutil.copyfile(path, place)


class PackagesInside(BuildHookInterface[Any]):
    """Called by hatchling before the wheel is packed."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        self.scratch = tempfile.TemporaryDirectory(prefix="halfplane-wheel-")  # gone with the hook
        folder = Path(self.scratch.name)
        write_tree(Path(self.root), folder / "halfplane")
        names = folder / "halfplane_package_names.pth"
        names.write_text("import halfplane.package_names\n", "utf-8")
        build_data["force_include"][str(folder / "halfplane")] = "halfplane"
        build_data["force_include"][str(names)] = names.name
