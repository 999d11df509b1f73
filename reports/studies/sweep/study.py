"""A study: a scene, axes over its keys, engines to run, figures to keep; and its points, all
checked before anything is solved.
"""

from __future__ import annotations

import ast
import itertools
import json
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from reports.checking import require_admissible
from reports.studies.sweep.solving import Question, check_figures, check_figures_of_driven_scene
from reports.studies.sweep.store import PlannedPoint
from scenes import InputError, Scene, load_scene
from scenes.errors import require_path
from scenes.files import keys_of
from scenes.frozen import Frozen, checked, reason_of_unknown_key

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

Value = bool | int | float | str
Coordinates = dict[str, Value]  # column of an axis -> value
_MOST_POINTS = 1_000_000  # of a study
_LONGEST_EXPRESSION = 500  # letters
_WAYS = ("values", "linear", "logarithmic", "pairs")  # in which an axis states its values


class Steps(Frozen):
    """`count` values from `start` to `stop`, both included."""

    start: float
    stop: float
    count: int = Field(ge=1, le=100_000)


class Axis(Frozen):
    """One axis: a name for the table, the keys that its values go to, and the values in one of four
    ways.

    >>> Axis(name="height", linear=Steps(start=2, stop=6, count=3)).points()
    [{'height': 2.0}, {'height': 4.0}, {'height': 6.0}]
    """

    name: str = Field(
        "",
        pattern=r"^([A-Za-z_]\w*)?$",
        description="column of the table, and the name in [derived]; of one key its name, with _",
    )
    names: tuple[str, ...] = Field((), description="of rows of values: one column for each")
    label: str = Field("", description="for figures; the name where it is left out")
    unit: str = ""
    key: str = Field("", description="dotted key of the scene, or mesh.* or solver.*")
    keys: tuple[str, ...] = Field(
        (), description="several keys that take the same value; of rows of values: one key for each"
    )
    values: tuple[Value, ...] = ()
    linear: Steps | None = None
    logarithmic: Steps | None = None
    pairs: tuple[tuple[Value, ...], ...] = Field((), description="rows of values that go together")

    @model_validator(mode="after")
    def _has_values_in_one_way(self) -> Self:
        """Check that an axis states its values in exactly one of the four ways (a list, an even
        range, a logarithmic range, pairs), with the names and keys that this way needs. ValueError
        if not.

        A list or range has one `name`, which heads its column in the table, and sets one `key` of
        the scene, several `keys` or none. Where it is missing, `name` is made from `key`. Pairs are
        rows with a value for each of `names`, and of `keys` if given; they have no `name`.
        """
        if self.key and not self.name and not self.names:
            object.__setattr__(self, "name", re.sub(r"\W", "_", self.key))
        # _WAYS: the attributes that hold values, one for each way
        ways = [way for way in _WAYS if getattr(self, way)]
        if len(ways) != 1:
            ways_in_words = " and ".join(ways) or "none"
            raise ValueError(
                f"an axis has its values in exactly one of {', '.join(_WAYS)}; this one has"
                f" {ways_in_words}"
            )
        if self.key and self.keys:
            raise ValueError("key and keys: give one of the two")
        if self.pairs:
            if {len(row) for row in self.pairs} != {len(self.names)} or (
                self.keys and len(self.keys) != len(self.names)
            ):
                raise ValueError(
                    "pairs: each row has one value for each of names, and keys (if given) are as"
                    " many"
                )
            if self.key:
                raise ValueError("pairs: keys has one key for each of names; leave key out")
            if self.name:
                raise ValueError("pairs: names head their columns; leave name out")
        elif not self.name or self.names:
            raise ValueError("an axis has a name; names go with pairs")
        if self.logarithmic and not (self.logarithmic.start > 0 and self.logarithmic.stop > 0):
            raise ValueError("a logarithmic axis needs start > 0 and stop > 0")
        return self

    @property
    def is_logarithmic(self) -> bool:
        """Whether its values go by factors."""
        return self.logarithmic is not None

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its columns."""
        return self.names or (self.name,)

    @property
    def targets(self) -> list[tuple[str, str]]:
        """(key, column) of every key of the scene that the axis sets, and the column of its
        values.
        """
        keys = self.keys or ((self.key,) if self.key else ())
        return list(zip(keys, self.names if self.pairs else [self.name] * len(keys), strict=False))

    def points(self) -> list[Coordinates]:
        """The points of an axis: a value for each of its columns."""
        if self.pairs:
            return [dict(zip(self.names, row, strict=True)) for row in self.pairs]
        values: Sequence[Value] = self.values
        if self.linear:
            values = np.linspace(self.linear.start, self.linear.stop, self.linear.count).tolist()
        if self.logarithmic:
            steps = self.logarithmic
            values = np.geomspace(steps.start, steps.stop, steps.count).tolist()
        return [{self.name: value} for value in values]


def grid_points(axes: Sequence[Axis]) -> Iterator[Coordinates]:
    """Coordinates of every point of a study: the points of each axis combined with those of every
    other axis; the last axis varies first.
    """
    for points_of_axes in itertools.product(*(axis.points() for axis in axes)):
        yield {column: value for point in points_of_axes for column, value in point.items()}


_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
_OF_MATH = ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "radians", "degrees")
_FUNCTIONS: dict[str, Callable[..., float]] = {name: getattr(math, name) for name in _OF_MATH} | {
    "abs": abs,
    "min": min,
    "max": max,
}


def value_of_expression(text: str, names: Mapping[str, Any]) -> float:
    """The value of an arithmetic expression, a finite number. It may have + - * / **, the functions
    of a pocket calculator, pi, and the names in `names`, which stand for their values.

    Raises
    ------
    InputError
        For anything but arithmetic, an unknown name, a value that is no finite number, or an
        expression of more than 500 characters (`_LONGEST_EXPRESSION`).

    Examples
    --------
    >>> value_of_expression("pi*(h/2)**2 + max(1, w)", {"h": 2.0, "w": 3.0})
    6.14159...
    """
    if len(text) > _LONGEST_EXPRESSION:
        raise InputError(
            f"{text[:30]!r}... is longer than {_LONGEST_EXPRESSION} characters; give a name of its"
            " own to a part of it"
        )
    try:
        number = float(_value(ast.parse(text, mode="eval").body, {"pi": math.pi, **names}))
    except (
        SyntaxError,
        ArithmeticError,
        ValueError,
        TypeError,
        RecursionError,
        MemoryError,
    ) as reason:
        raise InputError(f"{text!r} can't be evaluated: {reason}") from reason
    if not math.isfinite(number):
        raise InputError(f"{text!r} is {number}: a finite number is needed")
    return number


def _value(node: ast.expr, names: Mapping[str, Any]) -> Any:
    """The value of a node of a parsed arithmetic expression. Known are numbers, `names` (name ->
    value), operators (`_BINARY`, with two operands) and the functions of a pocket calculator
    (`_FUNCTIONS`); InputError for anything else.
    """
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case ast.Name(id=name) if name not in names:
            raise InputError(
                f"{name!r} is not known: it is neither an axis nor derived above; known:"
                f" {', '.join(names)}"
            )
        case ast.Name(id=name):
            value = names[name]
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(f"{name!r} is {value!r}: arithmetic needs a number")
            return float(value)
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=operand):
            return _value(operand, names) * (-1.0 if isinstance(sign, ast.USub) else 1.0)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return _BINARY[type(op)](_value(left, names), _value(right, names))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in _FUNCTIONS:
            return _FUNCTIONS[name](*(_value(arg, names) for arg in args))
    raise InputError(
        f"{ast.unparse(node)!r} is refused: numbers, names, + - * / **, and {', '.join(_FUNCTIONS)}"
        " are what there is"
    )


class Study(Frozen):
    """What is asked of a sweep; see docs/sweeps.md.

    Attributes
    ----------
    scene
        the scene that all points start from
    set
        dotted key -> value, the same at every point
    derived
        name or dotted key -> arithmetic in the names of axes and of what is derived above
    figures
        names of quantities with "fe.", "exact." or "error." before them, and metric keys
    uncertainty
        "none"; "cheap": one coarser mesh, theory on the polygon of the steps, a farther far
        field; "budget": the whole error budget of `halfplane run --budget`, for metrics
    share_condensations
        cut all points alike that have bodies, materials, profile and largest load in common:
        fine elements everywhere in the contact, one condensation for all; else each is cut for
        its own edges. Without a coarse run of its own a point states no uncertainty of W, U and
        the approach; "cheap" and "budget" find it by further runs
    """

    place_of_key_list = "docs/sweeps.md"

    title: str = ""
    purpose: str = ""
    scene: Scene
    set: dict[str, Value] = Field({})
    axes: tuple[Axis, ...] = Field(min_length=1)
    derived: dict[str, str | float] = Field({})
    engines: tuple[Literal["fe", "exact"], ...] = Field(("fe", "exact"), min_length=1)
    figures: tuple[str, ...] = Field(("error.dissipation", "error.peak_pressure"), min_length=1)
    uncertainty: Literal["none", "cheap", "budget"] = "none"
    share_condensations: bool = True
    preset: Literal["default", "coarse", "fine"] = "default"

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        """Check that no column or key of the study is given twice, that every axis changes
        something, and that the quantities asked for (`figures`) can be computed. ValueError if not.

        Of an axis, `columns` are the names of its columns in the table, and `targets` pairs of a
        key of the scene that it sets and the column with the values. `set` has further keys with
        values, `derived` keys or names with arithmetic. `engines` are those that run, "fe" and
        "exact"; `uncertainty` is how uncertainties are found.
        """
        columns = [column for axis in self.axes for column in axis.columns]
        keys_set = [key for axis in self.axes for key, _ in axis.targets]
        keys_set += [*self.derived, *self.set]
        for noun, names in (("the column", columns), ("the key", keys_set)):
            for name in names:
                if names.count(name) > 1:
                    raise ValueError(f"{noun} {name!r} is given twice")

        # an axis sets a key, or its name stands in arithmetic
        arithmetic = " ".join(map(str, self.derived.values()))
        for axis in self.axes:
            if not axis.targets and not any(column in arithmetic for column in axis.columns):
                raise ValueError(
                    f"the axis {axis.columns[0]!r} moves nothing: give it a key, or use its name in"
                    " [derived]"
                )
        check_figures(self.figures, self.engines, self.uncertainty)
        return self


def load_study(source: str | Path) -> Study:
    """Read a study from a .toml or .json file: a scene, axes over its keys, and the values to keep.
    The scene in the file is a table of keys, the name of a scene in the library, or a path relative
    to the file.

    Raises
    ------
    InputError
        One sentence that names file, key, value and rule.
    """
    require_path(source, "load_study", "a Study or the path of its file")
    path = Path(source)
    return study_of(keys_of(path, "the study"), str(source), path.parent)


def study_of(content: dict[str, Any], where: str, folder: Path = Path()) -> Study:
    """A checked study, which is a scene with axes over its keys, from the keys and values of its
    file (`content`). A scene that is named as a file lies in `folder`; any other name is one of the
    library. InputError, beginning with `where`, for anything that is refused.
    """
    scene_name = content.get("scene")
    # these keys belong to a scene
    if scene_name is None and {"material", "profile", "load"} <= content.keys():
        raise InputError(
            f"{where}: this is a scene; a study is a file beside it with `scene` and `axes`:"
            " docs/sweeps.md"
        )
    if isinstance(scene_name, str):
        scene = load_scene(folder / scene_name if Path(scene_name).suffix else scene_name)
        content = content | {"scene": json.loads(scene.model_dump_json())}
    return checked(Study, content, where, of_file=True)


@dataclass(frozen=True, eq=False)
class Point(PlannedPoint):
    """A point of a study: number (from 0, the last axis first), address of its result, coordinates,
    and its question: the scene and settings to be solved, and what is kept.
    """

    question: Question


def points_of_study(
    study: Study, report: Callable[[int], None] = lambda _count: None
) -> tuple[Point, ...]:
    """All points of a study, checked: every combination of the values on its axes. `report` is
    called with the number of points checked so far.

    A point has its number, its coordinates on the axes, its question (the scene and settings to be
    solved) and its address, a hash of that question.

    Raises
    ------
    InputError
        Naming the point, its coordinates and the rule, for the first that is no scene, slides or
        separates, has bodies that loads push off their supports, or is there twice. For more than
        a million points (`_MOST_POINTS`).
    """
    from halfplane_fe.supports import check_supports

    points: list[Point] = []
    number_by_address: dict[str, int] = {}  # number of a point by its address
    scene_text = study.scene.model_dump_json()
    for number, coordinates in enumerate(grid_points(study.axes)):
        if number == _MOST_POINTS:
            raise InputError(
                f"the study has more than {_MOST_POINTS} points; take fewer values on its axes"
            )
        words_of_point = f"point {number} ({coordinates_in_words(coordinates)})"

        # each fault names the point
        try:
            point = _point(study, json.loads(scene_text), number, coordinates)
            scene = point.question.scene
            # the loads (P > 0, |Q| < f P), the values asked for, the supports of the bodies
            require_admissible(scene, words_of_point)
            check_figures_of_driven_scene(scene, study.figures)
            if "fe" in study.engines:
                check_supports(scene)
        except InputError as fault:
            sentence = str(fault)
            if not sentence.startswith(words_of_point):
                sentence = f"{words_of_point}: {sentence}"
            raise InputError(sentence) from fault

        if point.address in number_by_address:
            raise InputError(
                f"{words_of_point} asks the same as point {number_by_address[point.address]}: an"
                " axis has a value twice, or moves nothing"
            )
        number_by_address[point.address] = number
        points.append(point)
        report(number + 1)
    return tuple(points)


def coordinates_in_words(coordinates: Mapping[str, Any]) -> str:
    """The coordinates of a point as one text, numbers to six digits.

    >>> coordinates_in_words({"height": 4.0, "base": "fixed"})
    'height = 4, base = fixed'
    """
    numbers = {
        name: f"{value:.6g}" if isinstance(value, float) else value
        for name, value in coordinates.items()
    }
    return ", ".join(f"{name} = {value}" for name, value in numbers.items())


def _point(
    study: Study, scene_content: dict[str, Any], number: int, coordinates: Coordinates
) -> Point:
    """The point `number` of a study at these coordinates on its axes, with its question. The
    question is the study's scene with the values of the study and its axes, settings of mesh and
    solver, and what is kept. `scene_content` is that scene as nested tables, which are changed
    here. `coordinates` has a value for each column of the axes.
    """
    # put the values into the scene's tables, and settings aside
    changed_settings: dict[str, dict[str, Any]] = {"mesh": {}, "solver": {}}
    for key, value in _values_by_key(study, coordinates).items():
        first_word, _, setting_name = key.partition(".")
        if first_word in changed_settings:
            changed_settings[first_word][setting_name] = value
        else:
            _set_value(scene_content, key, value)

    # check the scene and the settings: those of the preset, with changes
    scene = checked(Scene, scene_content, of_file=True)
    mesh, solver = _settings(study.preset, changed_settings)
    question = Question(
        scene,
        mesh,
        solver,
        study.engines,
        study.figures,
        study.uncertainty,
        study.share_condensations,
    )
    return Point(number, question.address, coordinates, question)


def _values_by_key(study: Study, coordinates: Coordinates) -> dict[str, Value]:
    """Values of a point of a study by dotted keys, such as "load.mean_normal_load"; keys that begin
    with "mesh." or "solver." are settings, the others are of the scene.

    They are the study's own (`set`), those of its axes at these `coordinates` (a value for each
    column), and those of arithmetic in names (`derived`), which is worked out in its order.
    """
    value_by_key: dict[str, Value] = dict(study.set)
    for axis in study.axes:
        # targets: keys that the axis sets, each with the column of its values
        value_by_key |= {key: coordinates[column] for key, column in axis.targets}
    value_by_name: dict[str, Value] = dict(coordinates)  # names that arithmetic uses
    for name, expression in study.derived.items():
        derived_value = (
            value_of_expression(expression, value_by_name)
            if isinstance(expression, str)
            else float(expression)
        )
        if "." in name:  # a key of the scene
            value_by_key[name] = derived_value
        else:
            value_by_name[name] = derived_value
    return value_by_key


def _set_value(content: dict[str, Any], key: str, value: Value) -> None:
    """Set the value of a dotted key such as "load.mean_normal_load" in `content`, the nested tables
    of a scene. A key such as material.young_modulus is set for both bodies, as in a scene file. A
    number in a key is a place in a list.

    InputError where the tables that it names before its last word are not there. Whether the scene
    takes the last word is checked later.
    """
    *outer_keys, last_key = key.split(".")
    if outer_keys == ["material"] and last_key not in content["material"]:
        for body in content["material"]:
            _set_value(content, f"material.{body}.{last_key}", value)
        return

    # go down to the table (or list) that the last word belongs to
    table: Any = content
    for depth, outer_key in enumerate(outer_keys):
        if isinstance(table, list) and outer_key.isdigit() and int(outer_key) < len(table):
            table = table[int(outer_key)]
        elif isinstance(table, dict) and outer_key in table:
            table = table[outer_key]
        else:
            known_keys = "none"
            if isinstance(table, dict):
                known_keys = ", ".join(table)
            elif isinstance(table, list):
                known_keys = f"numbers up to {len(table) - 1}"
            # why no scene has such a key, "" where no reason is known
            cause = reason_of_unknown_key(outer_key) or f" known there: {known_keys}"
            raise InputError(f"{key}: the scene has no {'.'.join(outer_keys[: depth + 1])};{cause}")

    # set its value
    if isinstance(table, list) and last_key.isdigit() and int(last_key) < len(table):
        table[int(last_key)] = value
    elif isinstance(table, dict):
        table[last_key] = value
        if last_key == "file":  # rows in the table are those of another file
            for key_of_rows in ("rows", "points"):
                table.pop(key_of_rows, None)
    else:
        raise InputError(f"{key}: {'.'.join(outer_keys)} is no table of keys")


def _settings(
    preset: str, changes: Mapping[str, Mapping[str, Any]]
) -> tuple[MeshSettings, SolverSettings]:
    """Settings of mesh and solver: those of the preset ("default", "coarse" or "fine"), with
    `changes`, which are values by key under "mesh" and under "solver". InputError for a key or a
    type that does not fit; a whole number fits where a number is needed.
    """
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

    type_in_words = {int: "a whole number", float: "a number", str: "a word", bool: "true or false"}
    changed_settings: list[Any] = []
    defaults_by_name = (("mesh", MeshSettings.preset(preset)), ("solver", SolverSettings()))
    for name, default_settings in defaults_by_name:
        types = {key: type(value) for key, value in asdict(default_settings).items()}
        if name == "solver":
            # None by default: then the method of the solver has a value of its own
            types |= {"normal_stiffness": float, "tangential_stiffness": float}
        for key, value in changes[name].items():
            if key not in types:
                raise InputError(
                    f"{name}.{key}: there is no such setting; known: {', '.join(types)}"
                )
            type_of_setting = types[key]
            is_whole_for_float = type_of_setting is float and type(value) is int
            if type(value) is not type_of_setting and not is_whole_for_float:
                raise InputError(
                    f"{name}.{key} = {value!r} is refused: it is {type_in_words[type_of_setting]}"
                )
        changed_settings.append(replace(default_settings, **changes[name]))
    mesh, solver = changed_settings
    return mesh, solver
