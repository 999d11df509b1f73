"""Answers that `halfplane init` puts into the commented example: from options, or asked for on a terminal."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib import resources
from typing import Annotated, Any, Literal

from cyclopts import Group, Parameter

_SCENE = Group("Scene (what is left out stays as in the example)", sort_key=2)
_NUMBER = r"-?[\d.]+(?:e[+-]?\d+)?"


def _option(text: str, **more: Any) -> Parameter:
    return Parameter(group=_SCENE, help=text, **more)


@Parameter(name="*")
@dataclass(frozen=True)
class SceneAnswers:
    """What a new scene has in place of the example's; None leaves the example's. Units N, mm, MPa; loads per thickness."""

    title: Annotated[str | None, _option("A line about the scene.")] = None
    profile: Annotated[Literal["hertz", "flat_rounded"] | None, _option("A parabola, or flat with rounded edges.")] = None
    radius: Annotated[float | None, _option("Relative radius of the profile or its edges, mm.")] = None
    flat_half_length: Annotated[float | None, _option("Half the flat of flat_rounded, mm.")] = None
    young_modulus: Annotated[float | None, _option("Of both bodies, MPa.")] = None
    poisson_ratio: Annotated[float | None, _option("Of both bodies.")] = None
    friction: Annotated[float | None, _option("Coulomb's coefficient.")] = None
    mean_normal_load: Annotated[float | None, _option("P0 of P0 + P1 cos t, N/mm.")] = None
    normal_amplitude: Annotated[float | None, _option("P1, N/mm.")] = None
    mean_tangential_load: Annotated[float | None, _option("Q0 of Q0 + Q1 cos(t - phase), N/mm.")] = None
    tangential_amplitude: Annotated[float | None, _option("Q1, N/mm.")] = None
    phase_degrees: Annotated[float | None, _option("Lag of Q behind P.")] = None

    def given(self) -> dict[str, Any]:
        """Name -> value of those that are not left out."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def example(bodies: bool = False, answers: Mapping[str, Any] | None = None) -> str:
    """The commented example with `answers` in it; with `bodies`, the comment signs before its tables of bodies are gone."""
    text = (resources.files("reports") / "templates" / "scene.toml").read_text("utf-8")
    start, end = text.index("# [bodies.lower]"), text.index("[tolerances]")
    if bodies:
        text = text[:start] + re.sub(r"(?m)^# ", "", text[start:end]) + text[end:]
    for name, value in (answers or {}).items():
        text = _with_answer(text, name, value)
    return text


def _with_answer(text: str, name: str, value: Any) -> str:
    """The text with one answer in place; comments stay."""
    if name == "profile":
        return text if value == "hertz" else _with_flat(text)
    if name == "title":
        return _replaced(text, r'(?m)^title = ".*"$', f"title = {_quoted(value)}")
    key = {"friction": "coefficient"}.get(name, name)
    return _replaced(text, rf"(?m)^{key} = {_NUMBER}", f"{key} = {float(value)!r}")


def _with_flat(text: str) -> str:
    text = _replaced(text, r'(?m)^kind = "hertz" ', '# kind = "hertz" ')
    text = _replaced(text, r'(?m)^# kind = "flat_rounded"', 'kind = "flat_rounded"')
    return _replaced(text, r"(?m)^# flat_half_length = 0\.5 ", "flat_half_length = 0.5 ")


def _replaced(text: str, pattern: str, by: str) -> str:
    """`text` with the first place of `pattern` replaced, and the comment behind it kept where it stood if there is room."""
    found = re.search(pattern, text)
    if found is None:
        raise ValueError(f"the example has no line for {pattern}")
    rest = text[found.end() :]
    room = re.match(r" *(?=#)", rest.split("\n", 1)[0])
    if room and room[0]:
        width = max(len(room[0]) + len(found[0]) - len(by), 1)
        rest = " " * width + rest[len(room[0]) :]
    return text[: found.start()] + by + rest


def _quoted(text: str) -> str:
    """A TOML string."""
    plain = "".join(character if character.isprintable() else " " for character in text)
    return '"' + plain.replace("\\", "\\\\").replace('"', '\\"') + '"'
