"""The question and the form of the answer: frozen types, the reading of scene files, the library of
scenes. No mechanics.

The question::

    scene.py        all of it: friction, tolerances, units, tags, expected numbers; read from files
                    and the library
    bodies.py       materials, shapes, faces as they are made
    body_effects.py what finite bodies add to half-planes, as numbers
    profiles.py     h(x) by formulas, through measured rows, by Python functions
    measured.py     tables of numbers, from files, in the scene's units; long records by turning
                    points or within a tolerance
    fitting.py      convex curves through noisy rows: parabola, flat and rounded, polynomial,
                    smoothing spline
    loads.py        load paths: ellipse, harmonics, polygon, measured rows, Python functions; bulk
                    stress and tilt beside P and Q
    rig.py          springs between the actuators of a rig and the contact
    uncertainty.py  standard uncertainties of the inputs and their correlations; the scene with its
                    inputs moved
    segments.py     load segments, of which paths consist: straight lines, harmonics, Chebyshev
                    series
    chebyshev.py    piecewise Chebyshev series that stand for functions
    height_slopes.py    slope of a height function, and what its rounding leaves uncertain
    frozen.py       what every table of keys has in common: checked at every door, changed by
                    `vary`, refused in one sentence

Its files and the answer::

    text_tables.py  text tables of any program to columns of numbers: separators, headings, the line
                    of a fault
    spikes.py       single rows of a trace that stand out from their neighbours
    column_names.py     headings of columns in five languages
    clock_times.py  times of day and dates, to seconds since the first row
    unit_words.py   words for units, their sizes, whether they are one set
    files.py        files up to a stated size, whole or not at all: text, keys, source files
    netcdf.py       NetCDF files of named arrays with their units, by h5netcdf
    errors.py       what can go wrong, as sentences
    array_types.py  types of arrays by what their entries are, for every package
    arrays.py       arrays of real numbers from Python callers; the largest number that is admitted
    solution.py     the form of every answer
    notebook_forms.py   HTML and figures of scenes and solutions, registered by whoever draws them
"""

from scenes.bodies import (
    Block,
    Bodies,
    Cylinder,
    Elastic,
    HalfPlane,
    Materials,
    Pad,
    Shape,
    ShoulderedPad,
    TShape,
)
from scenes.body_effects import BodyEffects, Estimate
from scenes.errors import (
    ConvergenceError,
    InadmissibleLoadError,
    InputError,
    Interrupted,
    LoadedInstant,
    NotFoundError,
    ProfileDataError,
)
from scenes.loads import (
    CallableLoad,
    DrivenWave,
    DrivenWaveSum,
    EllipseLoad,
    HarmonicLoad,
    LineOfAction,
    PolygonLoad,
    TimeSeriesLoad,
    Wave,
    WaveSum,
)
from scenes.profiles import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    PowerLaw,
    Profile,
    Tabulated,
    Wedge,
    fit_profile,
)
from scenes.rig import Rig
from scenes.scene import (
    Expected,
    Friction,
    Scene,
    Tolerances,
    load_scene,
    rig_names,
    scene_companions,
    scene_names,
    scene_of,
    scene_schema,
    scene_text,
    tags,
)
from scenes.segments import (
    NORMAL_LOAD,
    TANGENTIAL_LOAD,
    ChebyshevSegment,
    Combination,
    Ellipse,
    HarmonicSegment,
    LoadPath,
    LoadSegment,
    StraightSegment,
    ellipse_segment,
    parabola_segment,
    sampled_times,
)
from scenes.solution import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    ContactSolution,
    Record,
    SurfaceState,
    Work,
    read_only_copy,
)
from scenes.uncertainty import Input, Uncertainty

__all__ = [
    "NORMAL_LOAD",
    "OPEN",
    "SLIP_FORWARD",
    "SLIP_REVERSE",
    "STICK",
    "TANGENTIAL_LOAD",
    "Block",
    "Bodies",
    "BodyEffects",
    "CallableLoad",
    "CallableProfile",
    "ChebyshevSegment",
    "Combination",
    "Compound",
    "ContactSolution",
    "ConvergenceError",
    "DrivenWave",
    "DrivenWaveSum",
    "Elastic",
    "Cylinder",
    "Ellipse",
    "EllipseLoad",
    "Estimate",
    "EvenPolynomial",
    "Expected",
    "FlatRounded",
    "Friction",
    "HalfPlane",
    "HarmonicSegment",
    "HarmonicLoad",
    "Hertz",
    "InadmissibleLoadError",
    "InputError",
    "Input",
    "Interrupted",
    "LineOfAction",
    "LoadedInstant",
    "LoadSegment",
    "LoadPath",
    "Materials",
    "NotFoundError",
    "Pad",
    "PolygonLoad",
    "PowerLaw",
    "Profile",
    "ProfileDataError",
    "Record",
    "Rig",
    "Scene",
    "Shape",
    "ShoulderedPad",
    "StraightSegment",
    "SurfaceState",
    "TShape",
    "Tabulated",
    "TimeSeriesLoad",
    "Tolerances",
    "Uncertainty",
    "Wave",
    "WaveSum",
    "Wedge",
    "Work",
    "ellipse_segment",
    "fit_profile",
    "read_only_copy",
    "load_scene",
    "scene_companions",
    "rig_names",
    "scene_names",
    "scene_of",
    "scene_schema",
    "scene_text",
    "parabola_segment",
    "sampled_times",
    "tags",
]


def __dir__() -> list[str]:
    return sorted(__all__)
