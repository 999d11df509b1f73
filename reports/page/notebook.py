"""What a notebook shows of a scene and a solution, a table as HTML with every word escaped; and
`plot` and `plot_loop`.

Importing this module registers its functions with `scenes`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.charts.templating import template
from reports.comparison.words import bulk_and_tilt, first_rows, stretch
from scenes import ContactSolution, InputError, Scene, SurfaceState
from scenes.notebook_forms import NotebookForms, register

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def scene_html(scene: Scene) -> str:
    """Name, bodies, material, profile, friction and loads of a scene."""
    upper, lower = scene.material.upper, scene.material.lower
    path = scene.load.path()
    loads = [path.at(np.linspace(leg.start, leg.end, 65)) for leg in path.legs(1)]
    normal, tangential = (
        np.concatenate([np.atleast_1d(pair[k]) for pair in loads]) for k in (0, 1)
    )
    rows = [
        ("name", scene.name or "–"),
        (
            "bodies",
            f"upper {scene.bodies.upper.kind}, lower {scene.bodies.lower.kind}".replace("_", "-"),
        ),
        ("E, ν upper", f"{upper.young_modulus:.6g}, {upper.poisson_ratio:.4g}"),
        ("E, ν lower", f"{lower.young_modulus:.6g}, {lower.poisson_ratio:.4g}"),
        ("profile", scene.profile.kind.replace("_", " ")),
        ("friction coefficient", f"{scene.friction.coefficient:.4g}"),
        ("load", scene.load.kind.replace("_", " ")),
        ("P", f"{normal.min():.6g} to {normal.max():.6g}"),
        ("Q", f"{tangential.min():.6g} to {tangential.max():.6g}"),
        *([("beside P and Q", beside)] if (beside := bulk_and_tilt(scene)) else []),
        ("units", scene.units),
    ]
    return template("notebook.html").render(title=scene.title or scene.name or "Scene", rows=rows)


def solution_html(solution: ContactSolution) -> str:
    """How a solution ended, its size and its values."""
    title = solution.scene.title or solution.scene.name or "Solution"
    return template("notebook.html").render(title=title, rows=first_rows(solution))


# Of the states 0 to 3, on white: open, stick, forward slip, reverse slip; apart in grey too.
_STATES = ("#f2f2f2", "#9db4c0", "#d95f02", "#4b2e83")


def solution_figure(solution: ContactSolution, time: float | None = None) -> Figure:
    """Tractions at the stored instant next to `time`, and the states of all points through the last
    cycle.

    Without `time` the instant is that of the largest |Q| of the last cycle.

    Raises
    ------
    InputError
        For a time outside the solution, and a solution without pressure.
    """
    steps, now = solution.last_cycle, solution.time
    if not np.isfinite(solution.pressure).any():
        raise InputError(
            "plot: the solution holds no pressure; solve it with fields='pressure' and 'shear' at"
            " least"
        )
    if time is not None and not now.min() <= time <= now.max():
        raise InputError(
            f"plot: time = {time:g} lies outside the solution, which goes from {now.min():.6g} to"
            f" {now.max():.6g}"
        )
    if time is not None:
        step = int(np.argmin(np.abs(now - time)))
    else:
        step = int(steps[np.argmax(np.abs(solution.tangential_load[steps]))])
    figure, (tractions, states) = _axes(2, (7.0, 6.5))
    _, length, stress = solution.scene.unit_words
    x, friction = solution.x, solution.scene.friction.coefficient
    mark = "o" if len(x) == 1 else ""
    tractions.plot(x, solution.pressure[step], color="black", marker=mark, label="pressure p")
    tractions.plot(x, solution.shear[step], color=_STATES[2], marker=mark, label="shear traction q")
    for sign in (1, -1) if friction else ():
        label = "Coulomb limit ±f p" if sign > 0 else None
        tractions.plot(
            x, sign * friction * solution.pressure[step], color="0.6", linestyle=":", label=label
        )
    tractions.set_ylabel(f"p, q [{stress}]")
    tractions.set_title(
        f"{solution.scene.title or solution.scene.name}, time {now[step]:.4g}", loc="left"
    )
    tractions.legend(frameon=False)
    if len(x) > 1 and len(steps) > 1:
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch

        colours = ListedColormap(list(_STATES))
        states.pcolormesh(
            x,
            now[steps],
            solution.state[steps],
            cmap=colours,
            vmin=-0.5,
            vmax=3.5,
            shading="nearest",
            rasterized=True,
        )
        words = [state.name.lower().replace("_", " ") for state in SurfaceState]
        entries = [
            Patch(facecolor=colour, edgecolor="0.5", label=word)
            for colour, word in zip(_STATES, words, strict=True)
        ]
        states.legend(
            handles=entries, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False
        )
        states.axhline(now[step], color="black", linewidth=0.8)
    states.set_ylabel("time")
    states.set_xlabel(f"x [{length}]")
    return figure


def loop_figure(solution: ContactSolution) -> Figure:
    """Q over U through the last cycle, with the friction work that the loop encloses.

    Raises
    ------
    InputError
        For a solution without displacement.
    """
    steps = solution.last_cycle
    if not np.isfinite(solution.tangential_displacement[steps]).any():
        raise InputError(
            "plot_loop: the solution holds no relative tangential displacement; solve it with that"
            " field"
        )
    figure, (axes,) = _axes(1, (5.5, 4.5))
    force, length, _ = solution.scene.unit_words
    axes.plot(
        solution.tangential_displacement[steps], solution.tangential_load[steps], color="black"
    )
    axes.set_xlabel(f"relative tangential displacement U [{length}]")
    axes.set_ylabel(f"Q [{force}/{length}]")
    repeats = solution.scene.load.path().period is not None
    of = "per cycle" if repeats else f"of the {stretch(solution.scene)}"
    work = (
        f"W = {solution.dissipation:.4g} {force}·{length}/{length} {of}"
        if np.isfinite(solution.dissipation)
        else ""
    )
    axes.set_title(
        "\n".join(filter(None, (solution.scene.title or solution.scene.name, work))), loc="left"
    )
    return figure


def _axes(rows: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """A figure with `rows` axes one above the other; a notebook, which shows what a cell returns,
    is not to show it twice.
    """
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(
        rows, 1, figsize=size, sharex=rows > 1, squeeze=False, layout="constrained"
    )
    if "inline" in plt.get_backend():
        plt.close(figure)
    return figure, [row[0] for row in axes]


register(
    NotebookForms(
        scene_html=scene_html,
        solution_html=solution_html,
        solution_figure=solution_figure,
        loop_figure=loop_figure,
    )
)
