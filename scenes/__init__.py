"""The question and the form of the answer: frozen types, the reading of scene files, the library of scenes. No mechanics."""

from scenes.errors import ConvergenceError, InadmissibleLoadError, InputError
from scenes.loads import EllipseLeg, EllipseLoad, Leg, LoadPath, ParabolaLeg, PolygonLoad, StraightLeg
from scenes.materials import Elastic, Materials
from scenes.profiles import FlatRounded, Hertz, Profile
from scenes.reading import load_scene, scene_names, scene_schema, scene_text
from scenes.scene import Friction, HalfPlanes, Scene, Tolerances
from scenes.solution import ContactSolution, Record, SurfaceState, Work, freeze

__all__ = [
    "ContactSolution",
    "ConvergenceError",
    "Elastic",
    "EllipseLeg",
    "EllipseLoad",
    "FlatRounded",
    "Friction",
    "HalfPlanes",
    "Hertz",
    "InadmissibleLoadError",
    "InputError",
    "Leg",
    "LoadPath",
    "Materials",
    "ParabolaLeg",
    "PolygonLoad",
    "Profile",
    "Record",
    "Scene",
    "StraightLeg",
    "SurfaceState",
    "Tolerances",
    "Work",
    "freeze",
    "load_scene",
    "scene_names",
    "scene_schema",
    "scene_text",
]
