"""What many tests need, each made once in a test process: coarse runs, meshes, condensed bodies,
numbers of bodies.

They are functions of their arguments alone. While anything of the packages is replaced, as planted
faults do, nothing is taken from here and nothing is added: a fault that is planted acts on all.
"""

from __future__ import annotations

import sys
from collections import Counter, OrderedDict
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from operator import is_
from pkgutil import iter_modules
from types import ModuleType
from typing import Any

from halfplane_fe.condensed_bodies import _digest
from halfplane_fe.elasticity import CondensedBody
from halfplane_fe.scales import Scales
from meshes import BodyMesh, MeshSettings
from scenes import Elastic, Profile, Scene
from scenes.frozen import Frozen
from scenes.scene import WORDS

PACKAGES = ("halfplane_fe", "meshes", "scenes")
# Bodies and meshes that are cached: 2 MB each, as the tests make them.
MOST = 100


class Cached:
    """A function of one of the modules, its last values cached."""

    def __init__(self, module: ModuleType, name: str, most: int = MOST) -> None:
        self.make = getattr(module, name)
        self.hits = 0
        self._most = most
        self._values: OrderedDict[Hashable, Any] = OrderedDict()
        setattr(module, name, self)

    def key(self, *arguments: Any) -> Hashable:
        """What the value depends on; TypeError or ValueError where that cannot be hashed."""
        raise NotImplementedError

    def recorded(self, *arguments: Any) -> Any:
        """The value, with all that is needed to return it again."""
        return self.make(*arguments)

    def returned(self, value: Any, *arguments: Any) -> Any:
        """The value, as these arguments get it."""
        return value

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        arguments = (*arguments, *named.values())
        if not is_whole():
            return self.make(*arguments)
        try:
            key = self.key(*arguments)
        except (TypeError, ValueError):  # a profile that is a function of Python
            return self.make(*arguments)
        if key in self._values:
            self.hits += 1
            self._values.move_to_end(key)
        else:
            self._values[key] = self.recorded(*arguments)
            if len(self._values) > self._most:
                self._values.popitem(last=False)
        return self.returned(self._values[key], *arguments)


class CoarseRuns(Cached):
    """`find_scales`: scales, and the work that is counted for them."""

    def key(self, scene: Scene, work: Counter[str]) -> Hashable:
        return scene.model_dump_json(exclude=set(WORDS))  # no coarse run depends on them

    def recorded(self, scene: Scene, work: Counter[str]) -> tuple[Scales, Counter[str]]:
        own_work: Counter[str] = Counter()
        return self.make(scene, own_work), own_work

    def returned(
        self, value: tuple[Scales, Counter[str]], scene: Scene, work: Counter[str]
    ) -> Scales:
        scales, own_work = value
        work.update(own_work)
        return scales


class Meshes(Cached):
    """`build`: meshes that nobody may change."""

    def key(
        self, name: str, shape: Any, profile: Profile, grading: Any, settings: MeshSettings
    ) -> Hashable:
        return name, repr(shape), profile.model_dump_json(), repr(grading), repr(settings)

    def recorded(self, *arguments: Any) -> BodyMesh:
        body = self.make(*arguments)
        for array in (body.mesh.doflocs, body.mesh.t):
            array.flags.writeable = False
        return body


class Bodies(Cached):
    """`condense`: all but the mesh, which is that of the arguments."""

    def key(self, body: BodyMesh, material: Elastic, datum_length: float) -> Hashable:
        return _digest(body, material, datum_length)

    def returned(self, value: CondensedBody, body: BodyMesh, *_: Any) -> CondensedBody:
        return replace(value, body=body)


class Numbers(Cached):
    """`body_numbers`: what a body adds to the compliance of a half-plane."""

    def key(
        self, name: str, shape: Any, profile: Profile, material: Elastic, datum_length: float
    ) -> Hashable:
        return name, repr(shape), profile.model_dump_json(), repr(material), datum_length


def holders() -> Iterator[Mapping[str, Any]]:
    """Attributes of every module of the packages and of each class in them."""
    for package in PACKAGES:
        for entry in iter_modules(import_module(package).__path__, f"{package}."):
            import_module(entry.name)
    modules = [
        module for name, module in sorted(sys.modules.items()) if name.split(".")[0] in PACKAGES
    ]
    for module in modules:
        yield vars(module)
        for value in list(vars(module).values()):
            if isinstance(value, type) and value.__module__.split(".")[0] in PACKAGES:
                yield vars(value)


WHOLE: list[tuple[Mapping[str, Any], dict[str, Any]]] = []
"""Attributes of each holder, and what they were when the tests began."""
OFF: list[bool] = []


def is_whole() -> bool:
    """Whether nothing of the packages is replaced."""
    return not OFF and all(has_all(now, before) for now, before in WHOLE)


def has_all(now: Mapping[str, Any], before: dict[str, Any]) -> bool:
    """Whether each attribute still is what it was; others may have come."""
    if len(now) == len(before):
        return all(map(is_, now.values(), before.values()))
    return all(now.get(name) is value for name, value in before.items())


@contextmanager
def made_again() -> Iterator[None]:
    """In here every coarse run, mesh and condensed body is made, whatever was made before."""
    OFF.append(True)
    try:
        yield
    finally:
        OFF.pop()


SHARED: list[Cached] = []


def share() -> None:
    """From now on."""
    SHARED.extend(
        [
            CoarseRuns(import_module("halfplane_fe.solution"), "find_scales", 10 * MOST),
            Meshes(import_module("halfplane_fe.interface"), "build"),
            Bodies(import_module("halfplane_fe.condensed_bodies"), "condense"),
            Numbers(import_module("halfplane_fe.remainder"), "body_numbers"),
        ]
    )
    # What pydantic leaves for later, it does now: nobody has replaced it then.
    types = [Frozen]
    for type_of_scene in types:  # grows
        types += type_of_scene.__subclasses__()
        type_of_scene.model_rebuild()
    WHOLE.extend((now, dict(now)) for now in holders())
