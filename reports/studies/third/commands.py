"""What the command line takes of the third solver: `halfplane export`, and `--third calculix` of
`halfplane run`.
"""

from __future__ import annotations

from typing import Any

from reports.cli.application import EXIT_WITHIN, Answer
from reports.cli.solving import Job, deck_file, solving_command
from reports.console import Sheet
from reports.studies.third.calculix import ThirdSolver, find_calculix, solve_with_calculix
from reports.studies.third.deck import Deck, DeckSettings
from scenes import ContactSolution


def require() -> None:
    """InputError where CalculiX, the third solver, is not installed."""
    find_calculix()


def answer(job: Job, fe_solution: ContactSolution) -> ThirdSolver:
    """CalculiX' answer to the scene of a job; the mesh of its deck is made for the length scales of
    contact that our finite elements had (`fe_solution`).
    """
    return solve_with_calculix(
        job.scene,
        DeckSettings(**job.options.values_given(("steps_per_cycle",))),
        stages=job.stages,
        scales=getattr(fe_solution, "scales", None),
        command=job.command("run"),
    )


@solving_command
def export(job: Job) -> Answer:
    """The command `export`: write the bodies and the load history of a scene as an input deck for
    the finite-element program CalculiX.

    `job` has the scene, the options of the command line, the folder for the results, and the stages
    that are shown and measured. Returns exit code 0, a table of the deck's size for the terminal,
    the path of the file, and the content of the JSON output.
    """
    from reports.folder import results_folder

    # the deck, and its file
    scene = job.scene
    stages = job.stages
    with stages.stage("loading"):
        from halfplane_fe.solution import versions
        from reports.studies.third.deck import DeckSettings, build_deck, deck_text
    with stages.stage("deck"):
        # settings that the user gave on the command line; the others have defaults
        stated_settings = job.options.values_given(("steps_per_cycle", "cycles"))
        deck = build_deck(scene, DeckSettings(**stated_settings))
    # The command line in the deck's first comment is without the folder of the user.
    text = deck_text(deck, job.command("export").rpartition(" --out ")[0], versions())
    file = deck_file(scene)
    with results_folder(job.folder, stale_prefixes=(file,)) as staging_folder:
        (staging_folder / file).write_text(text, encoding="utf-8")

    path = str(job.folder / file)
    content = {"passed": True, **_deck_size(deck), "file": path, "seconds": stages.seconds}
    # EXIT_WITHIN: exit code 0
    return Answer(EXIT_WITHIN, [_sheet_of_deck(deck), path], lambda: content, scene.name)


def _deck_size(deck: Deck) -> dict[str, Any]:
    """Size of an input deck, as JSON content: nodes and elements of both meshes, size of the
    elements at the edges, instants beside the unloaded one, and the stiffnesses that replace rigid
    contact and stick.
    """
    return {
        "nodes": deck.node_count,
        "elements": len(deck.lower.elements) + len(deck.upper.elements),
        "edge_element_size": deck.element_size,
        "instants": len(deck.time) - 1,
        "pressure_per_penetration": deck.stiffness,
        "shear_per_elastic_slip": deck.stick_slope,
    }


def _sheet_of_deck(deck: Deck) -> Sheet:
    """The table, for the terminal, of the size of an input deck and of its stiffnesses."""
    from reports.units import units

    size = _deck_size(deck)
    _, unit_of_length, unit_of_stress = units(deck.scene)
    words_of_stiffness = (
        f"pressure per penetration, shear per elastic slip [{unit_of_stress}/{unit_of_length}]"
    )
    rows = [
        ("nodes, elements", f"{size['nodes']}, {size['elements']}"),
        (
            f"surface elements at the edges [{unit_of_length}]",
            f"{deck.element_size:.6g} (a/{1 / deck.settings.edge_element_size:g})",
        ),
        ("instants", f"{size['instants']}"),
        (words_of_stiffness, f"{deck.stiffness:.6g}, {deck.stick_slope:.6g}"),
    ]
    # Sheet: title, heads and rows
    return Sheet("Deck for CalculiX", ("what", "value"), rows)
