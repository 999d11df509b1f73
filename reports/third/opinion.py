"""CalculiX' answer to a scene, judged by the same metrics as the project's own finite elements."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.scales import Scales
from halfplane_fe.solve import versions
from reports.comparison import Comparison, Report
from reports.console import Stages
from reports.scoring.against import score_solution
from reports.scoring.guesses import whole_path
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read
from reports.scoring.solution import contact_solution
from reports.scoring.surface import SurfaceResult
from reports.third.calculix import calculix_deck
from reports.third.deck import Deck, build_deck
from reports.third.running import Done, calculix_version, find_calculix, run_calculix
from reports.third.settings import DeckSettings
from scenes import ConvergenceError, Scene, freeze

Array = NDArray[np.float64]

NAME = "third"


@dataclass(frozen=True, eq=False)
class ThirdOpinion:
    """What CalculiX says, or why it does not.

    Attributes
    ----------
    code : with its version
    deck, text : what it was given, as a value and as written
    comparison : its answer against half-plane theory; None where it failed
    done : how the run went; None where it failed
    failure : the sentence, "" where it did not
    limits : known limits of its numbers, in sentences
    guesses : what was taken for granted in reading its answer
    """

    code: str
    deck: Deck
    text: str
    comparison: Comparison | None
    done: Done | None
    failure: str
    limits: tuple[str, ...]
    guesses: tuple[str, ...] = ()


def ask_calculix(
    scene: Scene, settings: DeckSettings, limit: float, stages: Stages, scales: Scales | None = None, command: str = ""
) -> ThirdOpinion:
    """Write the deck into a temporary folder, run it, read and judge the result; a run that fails is told in `failure`.

    Raises
    ------
    InputError
        Where there is no CalculiX, or the scene can't be made a deck.
    """
    program = find_calculix()
    code = f"CalculiX {calculix_version(program)}"
    with stages.stage("deck"):
        deck = build_deck(scene, settings, scales)
        text = calculix_deck(deck, command, versions())
    known = {"code": code, "deck": deck, "text": text, "limits": limits(deck)}
    with tempfile.TemporaryDirectory(prefix="halfplane-third-") as name:
        folder = Path(name)
        (folder / f"{NAME}.inp").write_text(text, encoding="utf-8")
        try:
            with stages.stage(code, "per cent of the load path") as report:
                done = run_calculix(program, folder, NAME, float(deck.deck_time[-1]), limit, report)
        except ConvergenceError as failure:
            return ThirdOpinion(comparison=None, done=None, failure=str(failure), **known)  # type: ignore[arg-type]
        with stages.stage("reading CalculiX"):
            found = judged(folder / f"{NAME}.frd", deck, code)
    return ThirdOpinion(comparison=found.comparison, guesses=found.guesses, done=done, failure="", **known)  # type: ignore[arg-type]


def judged(path: Path, deck: Deck, code: str) -> Report:
    """The result of a deck in a .frd file, against half-plane theory at its own points and instants."""
    mapping = Mapping(code=code, times=tuple(deck.time[1:].tolist()), element_size=deck.element_size)
    result = replace(
        _from_unloaded(read(path, mapping, deck.scene), deck), source=f"{path.name}, the deck of scene {deck.scene.name}"
    )
    whole = whole_path(deck.scene)
    return score_solution(*contact_solution(result, mapping, whole), whole)


def _from_unloaded(result: SurfaceResult, deck: Deck) -> SurfaceResult:
    """The result with the unloaded instant before it: there nothing touches."""

    def led(series: Array | None) -> Array | None:
        return None if series is None else freeze(np.concatenate([np.zeros_like(series[:1]), series]))

    fields = {name: led(getattr(result, name)) for name in ("pressure", "shear", "slip", "normal_load", "tangential_load")}
    return replace(result, **fields, time=freeze(deck.time))  # type: ignore[arg-type]


def limits(deck: Deck) -> tuple[str, ...]:
    """Known limits of CalculiX' numbers on this deck: from its documentation, from the deck, and measured (docs/third.md)."""
    friction, unit = deck.scene.friction.coefficient, deck.scales.half_width
    pressure = deck.scales.load / (2 * unit)
    found = [
        f"Its contact is a penalty: faces overlap by {pressure / deck.stiffness / unit:.1e} a at the largest mean pressure.",
        "Plane elements are expanded to a layer of three-dimensional ones with constraints; contact is integrated over pieces of "
        "faces, and the values read here are its extrapolation of them to the nodes: an element at the edge of the contact is off.",
        "The work of friction is the sum of q ds over the instants that it wrote: the error of the steps is in it.",
    ]
    if friction:
        slip = friction * pressure / deck.stick_slope / unit
        found.insert(
            1,
            f"Faces that stick creep elastically, by up to {slip:.1e} a at the largest mean pressure; at a stick slope of "
            "1000 E*/h it does not converge.",
        )
        if _varies(deck):
            found.insert(
                2,
                "Under varying normal load its friction history is off by more than its mesh explains: +6 % of the dissipation of "
                "hertz-paper at a/40, against +2 % of cattaneo-mindlin's at constant load (docs/third.md).",
            )
    if deck.scene.bodies.lower.kind == "half_plane" or deck.scene.bodies.upper.kind == "half_plane":
        found.append(
            f"Its half-planes are half-discs of radius {deck.settings.far_radius:g} a held along the arc: an error of about "
            f"{deck.settings.far_radius**-2:.0e}."
        )
    return tuple(found)


def _varies(deck: Deck) -> bool:
    """Whether the normal load changes in a cycle."""
    path = deck.scene.load.path()
    turning = deck.normal_load[deck.time >= path.cycle_start]
    return path.period is not None and bool(np.ptp(turning) > 1e-9 * turning.max())
