"""Functions that show scenes and solutions in a notebook, and draw them; whoever has them registers
them here.

Nothing is drawn in this package. `reports.page.notebook` registers its functions when it is
imported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scenes.errors import InputError


@dataclass(frozen=True)
class NotebookForms:
    """The functions that show scenes and solutions in a notebook, one for each kind of output.

    Attributes
    ----------
    scene_html, solution_html
        of a scene, of a solution; a table as HTML
    solution_figure
        of a solution and a time or None; a matplotlib Figure
    loop_figure
        of a solution; a matplotlib Figure
    """

    scene_html: Callable[[Any], str]
    solution_html: Callable[[Any], str]
    solution_figure: Callable[[Any, float | None], Any]
    loop_figure: Callable[[Any], Any]


_registered: list[NotebookForms] = []


def register(forms: NotebookForms) -> None:
    """Take these functions from now on."""
    _registered[:] = [forms]


def registered_forms() -> NotebookForms | None:
    """The functions that were registered last; None without any: a notebook then prints text."""
    return _registered[0] if _registered else None


def forms_for(method: str) -> NotebookForms:
    """The registered functions that show scenes and solutions in a notebook as HTML or figures.

    `method` is the name of the method that needs them, for the message.

    Raises
    ------
    InputError
        Where none are registered, with the import that registers them.
    """
    # None where no module has registered any.
    forms = registered_forms()
    if forms is None:
        raise InputError(f"{method}: no figures are loaded; write `import reports.page.notebook`")
    return forms
