"""What the maps say of a scene: each departure from half-planes with its error, their sum, and whether theory may be used."""

from __future__ import annotations

from dataclasses import dataclass

from reports.comparison.metrics import Verdict, verdict_on
from reports.maps.advising import FIGURES, Part, parts
from reports.maps.answers import percent
from scenes import Scene


@dataclass(frozen=True)
class Advice:
    """What the maps say of a scene.

    Attributes
    ----------
    half_width : a by half-plane theory at the mean (else the largest) load [length]
    parts : every departure from half-planes; none where theory is the very model
    limit : error of dissipation up to which theory may be used
    """

    scene: Scene
    half_width: float
    parts: tuple[Part, ...]
    limit: float

    @property
    def known(self) -> list[Part]:
        """The departures of which the maps know something."""
        return [part for part in self.parts if part.values is not None]

    @property
    def extrapolated(self) -> bool:
        """Whether a departure is outside of what was run."""
        return any(part.extrapolated for part in self.parts)

    @property
    def verdict(self) -> Verdict | None:
        """Whether the error of dissipation, with its uncertainty, is within the limit; None where a departure is unknown."""
        if len(self.known) < len(self.parts):
            return None
        error, doubt = total(self.known, "error.dissipation")
        return verdict_on(error, self.limit, doubt)

    @property
    def may_be_used(self) -> bool:
        """Whether the error is within the limit for sure: known, not extrapolated, its uncertainty inside."""
        return self.verdict is Verdict.WITHIN and not self.extrapolated


def parts_of(scene: Scene) -> tuple[float, tuple[Part, ...]]:
    """Half-width and departures."""
    half_width, found = parts(scene)
    return half_width, tuple(found)


def total(known: list[Part], figure: str) -> tuple[float, float]:
    """Errors and uncertainties of a figure, added up."""
    pairs = [part.values[figure] for part in known if part.values is not None]
    return sum(error for error, _ in pairs), sum(doubt for _, doubt in pairs)


def cells(part: Part) -> tuple[str, ...]:
    """The errors of a departure in words, one a figure; nobody knows how far an extrapolated one is off."""
    if part.values is None:
        return ("unknown",) * len(FIGURES)
    return tuple(cell(*part.values[figure], part.extrapolated) for figure in FIGURES)


def cell(error: float, doubt: float, extrapolated: bool) -> str:
    """An error in per cent with its uncertainty; without one where it is extrapolated."""
    return f"about {100 * error:+.2g} %, extrapolated".replace("-", "−") if extrapolated else percent(error, doubt)


def sentence(advice: Advice) -> str:
    """May theory be used, by how much it is off, and what to do."""
    if not advice.parts:
        return "both bodies are half-planes of like materials (Dundurs' β is 0): half-plane theory is the very model"
    if advice.verdict is None:
        return f"The maps do not know {len(advice.parts) - len(advice.known)} of these departures: run it (`halfplane run`)."
    error, doubt = total(advice.known, "error.dissipation")
    off = cell(error, doubt, advice.extrapolated)
    words = f"dissipation by half-plane theory is off by {off}"
    if len(advice.parts) > 1:
        words += ", cross terms left out"
    if advice.extrapolated:
        words += "; the maps do not reach there, so run it (`halfplane run`) before you rely on it"
    if advice.verdict is Verdict.UNDECIDED:
        words += "; undecided, for the uncertainty reaches across the limit"
    answer = "No" if advice.verdict is Verdict.OUTSIDE else "Yes" if advice.may_be_used else "Not sure"
    return f"{answer}: {words}. The limit is {100 * advice.limit:g} %."
