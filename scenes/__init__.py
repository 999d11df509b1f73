"""The question and the form of the answer: frozen types, the reading of scene files, the library of scenes. No mechanics.

The question::

    scene.py                               all of it, with friction and tolerances
    materials.py, bodies.py, faces.py      elastic constants, shapes, faces as they are made
    profiles.py, measured.py, callables.py h(x): formulas, tables, Python functions
    segments.py, old_segments.py           load segments: smooth pieces of P(t) and Q(t); their old names
    loads.py, harmonics.py                 load paths: ellipse, polygon; several harmonics
    time_series.py, callable_loads.py      measured rows, Python functions
    expected.py, tags.py                   numbers that a scene expects, words to find it by
    consistent.py                          whether units can be one set
    frozen.py                              what all of these have in common: checked at every door, changed by `vary`
    chebyshev.py                           series that stand for functions

Its files and the answer::

    reading.py, tables.py, bounded.py      scene files, columns of numbers, both only up to a stated size
    writing.py                             a scene to its file
    refusals.py, errors.py                 why something was refused, as a sentence
    interrupts.py, staging.py              Ctrl-C that waits until what must not be cut in two is done; files whole or not at all
    solution.py, netcdf.py                 the form of every answer, and its file
    sources.py                             the source files that an answer was computed by, as a digest
    notebook.py                            scenes and answers in a notebook
"""

from scenes.bodies import Block, Bodies, Cylinder, HalfPlane, Pad, Shape
from scenes.callable_loads import CallableLoad
from scenes.callables import CallableProfile
from scenes.errors import ConvergenceError, InadmissibleLoadError, InputError, Interrupted, NotFoundError
from scenes.expected import Expected
from scenes.harmonics import HarmonicLoad
from scenes.loads import EllipseLoad, LoadPath, PolygonLoad
from scenes.materials import Elastic, Materials
from scenes.measured import Tabulated
from scenes.old_segments import ChebyshevLeg, EllipseLeg, HarmonicLeg, Leg, ParabolaLeg, StraightLeg
from scenes.profiles import Compound, EvenPolynomial, FlatRounded, Hertz, PowerLaw, Profile, Wedge
from scenes.reading import load_scene, scene_companions, scene_names, scene_schema, scene_text
from scenes.scene import Friction, Scene, Tolerances
from scenes.segments import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    ChebyshevSegment,
    Combination,
    Ellipse,
    HarmonicSegment,
    LoadSegment,
    StraightSegment,
    ellipse_segment,
    parabola_segment,
    sampled,
)
from scenes.solution import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, ContactSolution, Record, SurfaceState, Work, freeze
from scenes.tags import tags
from scenes.time_series import TimeSeriesLoad

__all__ = [
    "NORMAL_LOAD",
    "OPEN",
    "SLIP_FORWARD",
    "SLIP_REVERSE",
    "STICK",
    "TANGENTIAL_LOAD",
    "Block",
    "Bodies",
    "CallableLoad",
    "CallableProfile",
    "ChebyshevLeg",
    "ChebyshevSegment",
    "Combination",
    "Compound",
    "ContactSolution",
    "ConvergenceError",
    "Elastic",
    "Cylinder",
    "Ellipse",
    "EllipseLeg",
    "EllipseLoad",
    "EvenPolynomial",
    "Expected",
    "FlatRounded",
    "Friction",
    "HalfPlane",
    "HarmonicLeg",
    "HarmonicLoad",
    "HarmonicSegment",
    "Hertz",
    "InadmissibleLoadError",
    "InputError",
    "Interrupted",
    "Leg",
    "LoadPath",
    "LoadSegment",
    "Materials",
    "NotFoundError",
    "Pad",
    "ParabolaLeg",
    "PolygonLoad",
    "PowerLaw",
    "Profile",
    "Record",
    "Scene",
    "Shape",
    "StraightLeg",
    "StraightSegment",
    "SurfaceState",
    "Tabulated",
    "TimeSeriesLoad",
    "Tolerances",
    "Wedge",
    "Work",
    "ellipse_segment",
    "freeze",
    "load_scene",
    "scene_companions",
    "scene_names",
    "scene_schema",
    "scene_text",
    "parabola_segment",
    "sampled",
    "tags",
]


def __dir__() -> list[str]:
    return sorted(__all__)
