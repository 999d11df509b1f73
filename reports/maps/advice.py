"""What `halfplane advise` says: each departure from half-planes with its error, their sum, and whether theory may be used."""

from __future__ import annotations

from reports.application import OUTSIDE, WITHIN
from reports.console import say, show_table
from reports.maps.advising import FIGURES, Part, parts
from reports.maps.answers import percent
from reports.maps.atlas import WORDS
from scenes import InputError, load_scene


def tell(source: str, limit: float) -> int:
    """Print the advice on a scene; 1 where the error of dissipation may exceed `limit`, or is not known."""
    if not limit > 0:
        raise InputError(f"--limit {limit:g} is refused: it is an error above 0, such as 0.05")
    scene = load_scene(source)
    half_width, found = parts(scene)
    if not found:
        say(f"{source}: both bodies are half-planes of like materials: half-plane theory is the very model")
        return WITHIN
    known = [part for part in found if part.values is not None]
    rows = [(part.what, *cells(part), part.how) for part in found]
    if len(found) > 1 and known:
        rows.append(("sum", *(percent(*total(known, figure)) for figure in FIGURES), "errors and uncertainties added up"))
    heads = ("departure", *(WORDS[figure] for figure in FIGURES), "where from")
    show_table(f"{scene.title or source}: error of half-plane theory, a = {half_width:.4g}", heads, rows)
    return _verdict(found, known, limit)


def total(known: list[Part], figure: str) -> tuple[float, float]:
    """Errors and uncertainties of a figure, added up."""
    pairs = [part.values[figure] for part in known if part.values is not None]
    return sum(error for error, _ in pairs), sum(doubt for _, doubt in pairs)


def cells(part: Part) -> tuple[str, ...]:
    """The errors of a departure in words, one a figure."""
    if part.values is None:
        return ("unknown",) * len(FIGURES)
    return tuple(percent(*part.values[figure]) for figure in FIGURES)


def _verdict(found: list[Part], known: list[Part], limit: float) -> int:
    if len(known) < len(found):
        say(f"The maps do not know {len(found) - len(known)} of these departures: run it (`halfplane run`).")
        return OUTSIDE
    error, doubt = total(known, "error.dissipation")
    beyond = any(part.extrapolated for part in found)
    worst = abs(error) + doubt
    words = f"dissipation by half-plane theory is off by {percent(error, doubt)}"
    if len(found) > 1:
        words += ", cross terms left out"
    if beyond:
        words += "; part of that is extrapolated, so run it (`halfplane run`) before you rely on it"
    say(f"{'Yes' if worst <= limit else 'No'}: {words}. The limit is {100 * limit:g} %.")
    return WITHIN if worst <= limit and not beyond else OUTSIDE
