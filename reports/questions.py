"""What `halfplane init` asks on a terminal: profile, material, friction, loads, bodies. Enter takes the answer in brackets."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from reports.answers import example
from scenes import InputError

Ask = Callable[[str], str]
_CHOICES = {"profile": ("hertz", "flat_rounded"), "bodies": ("half-planes", "block-and-pad")}


@dataclass(frozen=True)
class Question:
    """Its key among the answers, its words, its place in the example."""

    key: str
    words: str
    place: tuple[str, str]


_ALWAYS = (
    Question("title", "Title", ("", "title")),
    Question("profile", "Profile: hertz (a parabola) or flat_rounded", ("profile", "kind")),
    Question("radius", "Relative radius R of the profile or its rounded edges [mm]", ("profile", "radius")),
    Question("flat_half_length", "Half-length b of the flat [mm]", ("profile", "flat_half_length")),
    Question("young_modulus", "Young's modulus of both bodies [MPa]", ("material", "young_modulus")),
    Question("poisson_ratio", "Poisson's ratio of both bodies", ("material", "poisson_ratio")),
    Question("bodies", "Bodies of the finite elements: half-planes or block-and-pad", ("", "bodies")),
)
_LOADS = (
    Question("friction", "Coefficient of friction f", ("friction", "coefficient")),
    Question("mean_normal_load", "Mean normal load P0 of P = P0 + P1 cos t [N/mm]", ("load", "mean_normal_load")),
    Question("normal_amplitude", "Its amplitude P1 [N/mm]", ("load", "normal_amplitude")),
    Question(
        "mean_tangential_load", "Mean tangential load Q0 of Q = Q0 + Q1 cos(t - phase) [N/mm]", ("load", "mean_tangential_load")
    ),
    Question("tangential_amplitude", "Its amplitude Q1 [N/mm]", ("load", "tangential_amplitude")),
    Question("phase_degrees", "Lag of Q behind P [degrees]", ("load", "phase_degrees")),
)


def asked(check: Callable[[str], None], ask: Ask, tell: Callable[[str], None]) -> str:
    """The text of a scene by questions and answers; friction and loads are asked once more while the scene is refused.

    Parameters
    ----------
    check : raises InputError for the text of a scene that is not admissible
    ask : shows a prompt, gives what was typed
    tell : shows a sentence
    """
    answers = _answers(_ALWAYS, {}, ask, tell)
    while True:
        answers |= _answers(_LOADS, answers, ask, tell)
        text = example(answers["bodies"] == "block-and-pad", {key: value for key, value in answers.items() if key != "bodies"})
        try:
            check(text)
        except InputError as fault:
            tell(f"That can't be solved: {fault}. Once more:")
            continue
        return text


def _answers(questions: tuple[Question, ...], before: dict[str, Any], ask: Ask, tell: Callable[[str], None]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    flat = tomllib.loads(example(answers={"profile": "flat_rounded"}))
    for question in questions:
        if question.key == "flat_half_length" and found["profile"] != "flat_rounded":
            continue
        table, key = question.place
        offered = before.get(question.key, (flat[table] if table else flat).get(key))
        if question.key in _CHOICES:
            offered = before.get(question.key, _CHOICES[question.key][0])
        found[question.key] = _answer(question, offered, ask, tell)
    return found


def _answer(question: Question, offered: Any, ask: Ask, tell: Callable[[str], None]) -> Any:
    """One answer, asked for until it can be read."""
    while True:
        typed = ask(f"{question.words} [{offered if isinstance(offered, str) else f'{offered:g}'}]: ").strip()
        if not typed:
            return offered
        if question.key == "title":
            return typed
        if question.key in _CHOICES:
            near = [choice for choice in _CHOICES[question.key] if choice.startswith(typed.lower())]
            if len(near) == 1:
                return near[0]
            tell(f"{typed}: one of {', '.join(_CHOICES[question.key])}")
            continue
        number = _number(typed)
        reason = _refusal(question.key, number)
        if not reason and number is not None:
            return number
        tell(f"{typed}: {reason}")


def _number(typed: str) -> float | None:
    try:
        return float(typed)
    except ValueError:
        return None


def _refusal(key: str, number: float | None) -> str:
    """Why a number can't be taken; empty if it can. The last word is that of the scene's own rules."""
    if number is None or number != number or abs(number) == float("inf"):  # noqa: PLR0124 -- NaN alone differs from itself
        return "a number is wanted, such as 12.5 or 2e5"
    if key in ("radius", "flat_half_length", "young_modulus", "mean_normal_load") and number <= 0:
        return "it must be positive"
    if key == "poisson_ratio" and not -1 < number < 0.5:
        return "it lies between -1 and 0.5"
    if key == "friction" and number < 0:
        return "it can't be negative"
    return ""
