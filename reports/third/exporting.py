"""What `halfplane export` does: a deck on disk, and what it holds in a table."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from reports import jobs
from reports.application import WITHIN
from reports.console import Stages, say, show_table
from reports.folder import claim, default_folder, filled
from scenes import Scene

if TYPE_CHECKING:
    from reports.third.deck import Deck


def export(
    source: str,
    to: Literal["calculix", "abaqus"],
    out: Path | None,
    steps_per_cycle: int | None,
    cycles: int | None,
    quiet: bool,
    as_json: bool = False,
) -> int:
    """Write the deck of a scene into a folder."""
    stages = Stages(quiet)
    scene = jobs.read(source)
    folder = claim(out or default_folder(scene.name))
    given = {"steps_per_cycle": steps_per_cycle, "cycles": cycles}
    options = {name: value for name, value in given.items() if value is not None}
    words = ["halfplane", "export", source, "--to", to]
    for name, value in options.items():
        words += [f"--{name.replace('_', '-')}", str(value)]
    path, deck = _write(scene, source, to, folder, options, shlex.join(words), stages)
    if as_json:
        from reports.machine import deck_json

        say(deck_json(scene, {"to": to, **_figures(deck)}, path, stages.seconds))
        return WITHIN
    _show(scene, to, deck)
    say(str(path))
    return WITHIN


def _figures(deck: Deck) -> dict[str, Any]:
    """What a deck holds, for programs."""
    return {
        "nodes": deck.reference,
        "elements": len(deck.lower.elements) + len(deck.upper.elements),
        "edge_element_size": deck.element_size,
        "instants": len(deck.time) - 1,
        "pressure_per_penetration": deck.stiffness,
        "shear_per_elastic_slip": deck.stick_slope,
    }


def _show(scene: Scene, to: str, deck: Deck) -> None:
    """The same in a table, with units."""
    from reports.units import units

    _, length, stress = units(scene)
    found = _figures(deck)
    show_table(
        f"Deck for {'CalculiX' if to == 'calculix' else 'Abaqus: never run there, checked by a parser and by CalculiX'}",
        ("what", "value"),
        [
            ("nodes, elements", f"{found['nodes']}, {found['elements']}"),
            (f"surface elements at the edges [{length}]", f"{deck.element_size:.6g} (a/{1 / deck.settings.edge_element_size:g})"),
            ("instants", f"{found['instants']}"),
            (
                f"pressure per penetration, shear per elastic slip [{stress}/{length}]",
                f"{deck.stiffness:.6g}, {deck.stick_slope:.6g}",
            ),
        ],
    )


def _write(
    scene: Scene, source: str, to: str, folder: Path, options: dict[str, int], command: str, stages: Stages
) -> tuple[Path, Deck]:
    with stages.stage("loading"):
        from halfplane_fe.solve import versions
        from reports.third.abaqus import abaqus_deck
        from reports.third.calculix import calculix_deck
        from reports.third.deck import build_deck
        from reports.third.settings import DeckSettings
    settings = DeckSettings(**options)
    with stages.stage("deck"), jobs.naming(source):
        deck = build_deck(scene, settings)
    text = (calculix_deck if to == "calculix" else abaqus_deck)(deck, command, versions())
    name = f"{default_folder(scene.name).name}_{to}.inp"
    with filled(folder, fresh=(name,)) as staging:
        (staging / name).write_text(text, encoding="utf-8")
    return folder / name, deck
