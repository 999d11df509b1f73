"""What a notebook shows of a scene and a solution, a table as HTML with every word escaped; and
`plot` and `plot_loop`.

Importing this module registers its functions with `scenes`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.charts.templating import template
from reports.comparison.datum import lacks_datum
from reports.comparison.words import bulk_and_tilt_in_words, first_summary_rows, part_of_path
from scenes import ContactSolution, InputError, Scene, SurfaceState
from scenes.notebook_forms import NotebookForms, register

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def scene_html(scene: Scene) -> str:
    """A scene as HTML for a notebook: name, bodies, material, profile, friction and loads.

    The ranges are those of P and Q, or of the displacements of the actuators where the scene
    prescribes these (`is_driven`; `states_approach` where the normal one too).
    """
    upper_material = scene.material.upper
    lower_material = scene.material.lower
    normal_range, tangential_range = scene.ranges_of_load()
    normal_words = "approach of the actuator" if scene.load.states_approach else "P"
    tangential_words = "U of the actuator" if scene.load.is_driven else "Q"
    bodies = f"upper {scene.bodies.upper.kind}, lower {scene.bodies.lower.kind}"
    rows = [
        ("name", scene.name or "–"),
        ("bodies", bodies.replace("_", "-")),
        ("E, ν upper", f"{upper_material.young_modulus:.6g}, {upper_material.poisson_ratio:.4g}"),
        ("E, ν lower", f"{lower_material.young_modulus:.6g}, {lower_material.poisson_ratio:.4g}"),
        ("profile", scene.profile.kind.replace("_", " ")),
        ("friction coefficient", f"{scene.friction.coefficient:.4g}"),
        ("load", scene.load.kind.replace("_", " ")),
        (normal_words, f"{normal_range[0]:.6g} to {normal_range[1]:.6g}"),
        (tangential_words, f"{tangential_range[0]:.6g} to {tangential_range[1]:.6g}"),
    ]
    other_loads_in_words = bulk_and_tilt_in_words(scene)
    if other_loads_in_words:
        rows.append(("beside P and Q", other_loads_in_words))
    rows.append(("units", scene.units))
    return template("notebook.html").render(title=scene.title or scene.name or "Scene", rows=rows)


def solution_html(solution: ContactSolution) -> str:
    """A solution as HTML for a notebook: how it ended, its size and its values."""
    title = solution.scene.title or solution.scene.name or "Solution"
    return template("notebook.html").render(title=title, rows=first_summary_rows(solution))


# On white, and different in grey too.
_OPEN_COLOUR = "#f2f2f2"
_STICK_COLOUR = "#9db4c0"
_FORWARD_COLOUR = "#d95f02"
_REVERSE_COLOUR = "#4b2e83"
# Of the states 0 to 3.
_STATE_COLOURS = (_OPEN_COLOUR, _STICK_COLOUR, _FORWARD_COLOUR, _REVERSE_COLOUR)


def solution_figure(solution: ContactSolution, time: float | None = None) -> Figure:
    """A matplotlib figure of a solution: tractions at the stored instant next to `time`, and the
    states of all points through the last cycle.

    Without `time` the instant is that of the largest |Q| of the last cycle. A line in the map of
    states marks it.

    Raises
    ------
    InputError
        For a time outside the solution, and a solution without pressure.
    """
    instant = _shown_instant(solution, time)  # index
    figure, (tractions_axes, states_axes) = _axes(2, (7.0, 6.5))
    _draw_tractions(tractions_axes, solution, instant)
    if len(solution.x) > 1 and len(solution.last_cycle) > 1:
        _draw_states(states_axes, solution)
        states_axes.axhline(solution.time[instant], color="black", linewidth=0.8)
    _, unit_of_length, _ = solution.scene.unit_words
    states_axes.set_ylabel("time")
    states_axes.set_xlabel(f"x [{unit_of_length}]")
    return figure


def _shown_instant(solution: ContactSolution, time: float | None) -> int:
    """Index of the instant that is shown: the stored one nearest to `time`; without `time` that of
    the largest |Q| of the last cycle. InputError for a time outside the solution, and a solution
    without pressure.
    """
    stored_times = solution.time
    if not np.isfinite(solution.pressure).any():
        raise InputError(
            "plot: the solution holds no pressure; solve it with fields='pressure' and 'shear' at"
            " least"
        )
    if time is None:
        indices = solution.last_cycle  # of the instants
        return int(indices[np.argmax(np.abs(solution.tangential_load[indices]))])
    if not stored_times.min() <= time <= stored_times.max():
        raise InputError(
            f"plot: time = {time:g} lies outside the solution, which goes from"
            f" {stored_times.min():.6g} to {stored_times.max():.6g}"
        )
    return int(np.argmin(np.abs(stored_times - time)))


def _draw_tractions(axes: Axes, solution: ContactSolution, instant: int) -> None:
    """Draw pressure p, shear traction q and the Coulomb limit ±f p over x into matplotlib `axes`,
    at the instant of that index. The pressure of the solution is (k instants, n points).
    """
    scene = solution.scene
    x = solution.x
    pressure = solution.pressure[instant]
    marker = "o" if len(x) == 1 else ""
    axes.plot(x, pressure, color="black", marker=marker, label="pressure p")
    axes.plot(
        x, solution.shear[instant], color=_FORWARD_COLOUR, marker=marker, label="shear traction q"
    )
    if scene.friction.coefficient:
        coulomb_limit = scene.friction.coefficient * pressure
        axes.plot(x, coulomb_limit, color="0.6", linestyle=":", label="Coulomb limit ±f p")
        axes.plot(x, -coulomb_limit, color="0.6", linestyle=":")
    _, _, unit_of_stress = scene.unit_words
    axes.set_ylabel(f"p, q [{unit_of_stress}]")
    axes.set_title(f"{scene.title or scene.name}, time {solution.time[instant]:.4g}", loc="left")
    axes.legend(frameon=False)


def _draw_states(axes: Axes, solution: ContactSolution) -> None:
    """Draw open, stick and slip of all points through the last cycle, over x and time, into
    matplotlib `axes`, with a legend above. The states are codes 0 to 3, (k instants, n points).
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    indices = solution.last_cycle  # of the instants
    # _STATE_COLOURS: of the codes 0 to 3
    axes.pcolormesh(
        solution.x,
        solution.time[indices],
        solution.state[indices],
        cmap=ListedColormap(list(_STATE_COLOURS)),
        vmin=-0.5,
        vmax=3.5,
        shading="nearest",
        rasterized=True,
    )
    # SurfaceState: the four states with their names
    state_names = [state_code.name.lower().replace("_", " ") for state_code in SurfaceState]
    patches = [
        Patch(facecolor=colour, edgecolor="0.5", label=name)
        for colour, name in zip(_STATE_COLOURS, state_names, strict=True)
    ]
    axes.legend(
        handles=patches, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False
    )


def loop_figure(solution: ContactSolution) -> Figure:
    """A matplotlib figure of the loop of Q over the relative tangential displacement U through the
    last cycle, with the friction work W in its title.

    Raises
    ------
    InputError
        For a solution without displacement.
    """
    indices = solution.last_cycle  # of the instants
    displacement = solution.tangential_displacement[indices]
    if not np.isfinite(displacement).any():
        raise InputError(
            "plot_loop: the solution holds no relative tangential displacement; solve it with that"
            " field"
        )
    scene = solution.scene
    figure, (axes,) = _axes(1, (5.5, 4.5))
    unit_of_force, unit_of_length, _ = scene.unit_words
    axes.plot(displacement, solution.tangential_load[indices], color="black")
    words_of_axis = f"relative tangential displacement U [{unit_of_length}]"
    # U of theory counts from a place at that distance
    if scene.bodies.half_planes or lacks_datum(solution):
        words_of_axis += f", datum length {scene.profile.datum_length:g} {unit_of_length}"
    axes.set_xlabel(words_of_axis)
    axes.set_ylabel(f"Q [{unit_of_force}/{unit_of_length}]")
    title_lines = filter(None, (scene.title or scene.name, _work_in_words(solution)))
    axes.set_title("\n".join(title_lines), loc="left")
    return figure


def _work_in_words(solution: ContactSolution) -> str:
    """The friction work W of a solution with its unit, per cycle or of the whole path; "" where it
    is not known.
    """
    if not np.isfinite(solution.dissipation):
        return ""
    scene = solution.scene
    unit_of_force, unit_of_length, _ = scene.unit_words
    repeats = scene.load.path().period is not None
    part_in_words = "per cycle" if repeats else f"of the {part_of_path(scene)}"
    unit_of_work = f"{unit_of_force}·{unit_of_length}/{unit_of_length}"
    return f"W = {solution.dissipation:.4g} {unit_of_work} {part_in_words}"


def _axes(n_axes: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """A matplotlib figure of that width and height [inches] with `n_axes` axes one above the other.
    It is closed in a notebook (matplotlib draws "inline"), which shows what a cell returns and
    would show it twice.
    """
    import matplotlib.pyplot as plt

    figure, grid_of_axes = plt.subplots(
        n_axes, 1, figsize=size, sharex=n_axes > 1, squeeze=False, layout="constrained"
    )
    if "inline" in plt.get_backend():
        plt.close(figure)
    return figure, [axes_of_row[0] for axes_of_row in grid_of_axes]


register(
    NotebookForms(
        scene_html=scene_html,
        solution_html=solution_html,
        solution_figure=solution_figure,
        loop_figure=loop_figure,
    )
)
