"""The two names of each package: `scenes` in a checkout, `halfplane.scenes` where the wheel is
installed.

In a checkout the five packages lie beside this one, at the top. The wheel has them inside it, since
a user may have a module `reports` or `scenes`. So that scripts run with both, each name leads to
the other's modules:

- in a checkout, `halfplane.scenes` is `scenes`;
- with the wheel, `scenes` is `halfplane.scenes` for one release, with one DeprecationWarning. A
  module or package of the user with that name comes first, wherever it lies.

A second name is a module of its own with the attributes of the first. It has no folder: a search
there would load the same file a second time, and its classes would be others.

The wheel calls `install` whenever Python starts, by a line in a .pth file: hence no import here
that is not loaded already.
"""

from __future__ import annotations

import os
import sys
from importlib.machinery import ModuleSpec

TYPE_CHECKING = False  # as in `typing`, whose import takes longer than this module
if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import CodeType, ModuleType
    from typing import Any

PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")


class SecondNames:
    """Finder of the second names, and loader of their modules.

    `prefix` stands before the second names, `home` before the first: "halfplane." and "" in a
    checkout, "" and "halfplane." with the wheel.
    """

    def __init__(self, prefix: str, home: str) -> None:
        self.prefix = prefix
        self.home = home
        self.has_warned = False

    def first_name(self, name: str) -> str:
        """The name of the module itself.

        >>> SecondNames("", "halfplane.").first_name("scenes.loads")
        'halfplane.scenes.loads'
        """
        return self.home + name.removeprefix(self.prefix)

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: object = None
    ) -> ModuleSpec | None:
        """The specification of a module under a second name, such as `halfplane.scenes` of
        `scenes`; None for any other name, and for one that a user's own module has.

        The interface is that of an import finder of Python. `prefix` stands before the second
        names, `home` before the first; one of them is "halfplane.", the other "".
        """
        if not name.startswith(self.prefix):
            return None
        package, _, submodule = name.removeprefix(self.prefix).partition(".")
        # PACKAGES: the five packages that have two names
        if package not in PACKAGES:
            return None
        if submodule:
            # A submodule counts only where its package was loaded under the second name.
            parent = sys.modules.get(name.rpartition(".")[0])
            if not is_second_name(parent):
                return None
        elif not self.prefix and self._users_own(name):
            return None
        from importlib.util import find_spec

        if not self.home and not submodule:
            _require_checkout()

        # The specification of the module itself, under its first name.
        spec = find_spec(self.first_name(name))
        if spec is None:
            return None
        is_package = spec.submodule_search_locations is not None
        loader: Any = self  # importlib asks for the methods below alone
        return ModuleSpec(name, loader, origin=spec.origin, is_package=is_package)

    def _users_own(self, name: str) -> bool:
        """Whether any other finder of Python has code by that name, a module or package of the
        user; a folder without any code, such as one of scene files, is none.
        """
        for finder in sys.meta_path:
            find_user_spec = getattr(finder, "find_spec", None)
            user_spec = (
                None if finder is self or find_user_spec is None else find_user_spec(name, None)
            )
            if user_spec is None:
                continue
            folders = user_spec.submodule_search_locations
            if user_spec.origin is not None or folders is None:
                return True
            files = [file for folder in folders for file in os.listdir(folder)]
            return any(file.endswith(".py") for file in files)
        return False

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """A new module under the second name, with the attributes of the module under the first.

        With the wheel (`prefix` is "") a DeprecationWarning is given once.
        """
        from importlib import import_module
        from types import ModuleType

        if not self.prefix and not self.has_warned:
            self.has_warned = True
            _warn_of(spec.name.partition(".")[0])
        first_module = import_module(self.first_name(spec.name))
        module = ModuleType(spec.name, first_module.__doc__)
        module.__dict__["__getattr__"] = lambda attribute: getattr(first_module, attribute)
        module.__dict__["__dir__"] = lambda: dir(first_module)
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Nothing: the module itself has run."""

    def get_code(self, name: str) -> CodeType | None:
        """The code of the module itself, for `python -m`."""
        from importlib.util import find_spec

        spec = find_spec(self.first_name(name))
        loader: Any = spec and spec.loader
        code: CodeType | None = loader.get_code(self.first_name(name))
        return code


def _warn_of(package: str) -> None:
    """DeprecationWarning for an import of the `package` without `halfplane` before it."""
    import warnings

    warnings.warn(
        f"`import {package}` works until 0.6: write `from halfplane import {package}`",
        DeprecationWarning,
        stacklevel=3,
    )


def is_second_name(module: ModuleType | None) -> bool:
    """Whether the module has the attributes of another."""
    spec = getattr(module, "__spec__", None)
    return isinstance(getattr(spec, "loader", None), SecondNames)


def _require_checkout() -> None:
    """Refuse a module of the user that hides one of the five packages of a checkout.

    The checkout is the folder above this package: its packages lie there.

    Raises
    ------
    ImportError
        With the file, and what to do.
    """
    from importlib.util import find_spec
    from pathlib import Path

    checkout = Path(__file__).parents[1]
    # PACKAGES: the five packages at the top of a checkout
    for package in PACKAGES:
        spec = find_spec(package)
        origin = None if spec is None else spec.origin
        if origin is None or not Path(origin).is_relative_to(checkout / package):
            raise ImportError(
                f"halfplane runs from its checkout {checkout}, where its package {package!r} lies"
                f" at the top, but Python finds {origin or 'none'} by that name: rename that"
                f" module, or install halfplane with `pip install {checkout}`, which puts its"
                " packages inside `halfplane`"
            )


def install() -> None:
    """Have the second names found, once."""
    if any(isinstance(finder, SecondNames) for finder in sys.meta_path):
        return
    is_wheel = os.path.isdir(os.path.join(os.path.dirname(__file__), "scenes"))
    # First, for second names only: a folder of scene files called `scenes` would count as a
    # package without code. What a user has by that name is looked up before.
    names = SecondNames("", "halfplane.") if is_wheel else SecondNames("halfplane.", "")
    sys.meta_path.insert(0, names)
