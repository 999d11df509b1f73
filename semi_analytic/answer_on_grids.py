"""The answer where bulk stress and tilt leave a frictional state that is no single memory curve, as
`Findings`: a numerical solution on grids of cells. W and W(x) of the steady cycle come from a
method without grids where one holds.

A memory curve is the tangential force, or the bulk strain, locked in up to each normal load.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import OPEN
from scenes.array_types import Array
from semi_analytic.answer import (
    STEADY_FIELDS,
    Findings,
    Question,
    mirrored_points,
    neglected_coupling,
)
from semi_analytic.bulk_and_tilt import path_loads_and_contact
from semi_analytic.elasticity import composite_modulus
from semi_analytic.grid import (
    INCREMENTS_PER_CYCLE,
    GridRequest,
    PathOnGrids,
    contact_edges_along,
    follow_on_grid,
)
from semi_analytic.history import time_in_followed_path

WORK_FIELDS = frozenset(("dissipation", "dissipation_density"))
"""Fields that are taken from a method without grids where one holds for the steady cycle."""

_VALUES_OF_STEADY_CYCLE = (
    "dissipation",
    "loop_work",
    "dissipation_density",
    "permanent_stick_half_width",
    "permanent_stick_edges",
)


class GridAnswer:
    """The numerical solution on grids of a scene with bulk stress and tilt, and the answer from it.

    Attributes
    ----------
    question
        what was asked for
    x
        (k,) points of the answer [length]
    path_on_grids
        loads, fields and friction work of all cycles: means over the grids
    """

    def __init__(self, question: Question) -> None:
        """Follow the load path of a question, with bulk stress and tilt, by a numerical solution on
        grids.

        Fields are found at the points of the question. Where it states none, they are 200 points
        from -c to c, with c 1.05 times the largest distance of an edge of contact from x = 0.

        Raises
        ------
        InputError
            For a time outside the path; where an increment does not converge.
        InadmissibleLoadError
            For gross sliding and separation.
        """
        self._start_of_clock = clock.perf_counter()
        scene = question.scene
        # P, Q, bulk strain and tilt over time; normal contact as a function of load and tilt
        self._path_loads, self._tilted_contact = path_loads_and_contact(scene)
        load_path = self._path_loads.path
        if question.time is not None:
            # refuses a time outside the path
            path_end = (*load_path.initial_loading, *load_path.cycle)[-1].end
            time_in_followed_path(question.time, load_path.start, path_end, load_path.period)
        self.question = question
        self.x = self._points()
        # Whether the fields asked for are the same in the steady cycle however it was reached.
        self._steady_only = question.wants_last_cycle_alone and question.fields <= STEADY_FIELDS
        self.path_on_grids: PathOnGrids = follow_on_grid(
            self._path_loads,
            self._tilted_contact,
            scene.profile.height,
            scene.friction.coefficient,
            self.x,
            question.time,
            # `steady`: the last cycle is enough; `pointwise`: fields at points are wanted
            GridRequest(
                most_cycles=max(scene.cycles, 2),
                steady=self._steady_only,
                pointwise=question.wants("shear", "slip", "state"),
            ),
        )

    def _points(self) -> Array:
        """Points of the answer (k,) [length]: those of the question, else 200 on both sides of x =
        0.

        The 200 reach up to 1.05 times the largest distance of an edge of contact from x = 0.
        """
        if self.question.x is not None:
            return self.question.x
        contact_edges = contact_edges_along(self._path_loads, self._tilted_contact)
        return mirrored_points(1.05 * float(np.max(np.abs(contact_edges))))

    def findings(self, findings_without_grids: Findings | None) -> Findings:
        """The answer of a path that was followed on grids: loads, fields and friction work, their
        estimated errors, notes, and how the path ended.

        `findings_without_grids` is the answer for the steady cycle by a method without grids; None
        where there is none, or where grids found no steady cycle. From it are taken the friction
        work W, the work per area W(x), permanent stick and loop work; W also for each cycle from
        the first steady one on. A last cycle that is not steady gets a note of how far its W may be
        from the steady one.
        """
        values = self._values()
        errors = self._errors_on_grids()
        if findings_without_grids is not None:
            values |= self._values_of_steady_cycle(
                findings_without_grids, values["cycle_dissipation"]
            )
            # those of W and W(x)
            errors |= dict.fromkeys(self.question.fields & WORK_FIELDS, 0.0)
            errors |= dict(findings_without_grids.errors)
        if np.isfinite(values["stick_edges"]).any():
            # an edge lies anywhere in its cell, however the steady cycle is found
            values["uncertainties"]["stick_edges"] = self._cell_width
        path_on_grids = self.path_on_grids
        termination, message = self._termination_and_message()
        return Findings(
            time=path_on_grids.time[self._rows()],
            x=self.x,
            values=values,
            termination=termination,
            message=message,
            notes=tuple(self._notes(findings_without_grids)),
            errors=errors,
            counts={"cycles_solved": len(path_on_grids.works), **path_on_grids.counts},
            seconds={"history": clock.perf_counter() - self._start_of_clock},
        )

    def _values_of_steady_cycle(
        self, findings_without_grids: Findings, works_on_grids: Array
    ) -> dict[str, Any]:
        """W, W(x), permanent stick and loop work of the steady cycle, found without grids, by their
        names in a solution; none of them is uncertain.

        W of each cycle is that on grids, `works_on_grids` (n_cycles,), up to the first steady one.
        W(x) is the friction work per area.
        """
        n_cycles_before = self.path_on_grids.steady_from or 0
        is_before_steady = np.arange(len(works_on_grids)) < n_cycles_before
        values: dict[str, Any] = {
            name: findings_without_grids.values.get(name) for name in _VALUES_OF_STEADY_CYCLE
        }
        values["cycle_dissipation"] = np.where(
            is_before_steady, works_on_grids, findings_without_grids.values["dissipation"]
        )
        return values | {"uncertainties": {}}

    def _notes(self, findings_without_grids: Findings | None) -> Iterator[str]:
        """Sentences for the notes: the coupling of tractions that is left out, and how fine the
        grids are.

        A last cycle that is not steady gets a sentence on how far its friction work may be from the
        steady one. `findings_without_grids` is the answer for the steady cycle by a method without
        grids, or None.
        """
        path_on_grids = self.path_on_grids
        scene = self.question.scene
        yield from neglected_coupling(scene.material)
        yield self._note_of_grids(findings_without_grids)
        # period: duration of a cycle, None for a path that does not repeat
        if scene.load.path().period is not None and path_on_grids.steady_from is None:
            unsteady_share = path_on_grids.unsteady_work / float(path_on_grids.works[-1])
            yield (
                f"the last cycle, number {len(path_on_grids.works)}, is not steady: by the trend"
                f" its dissipation is within {unsteady_share:.1e} of the steady one"
            )

    def _termination_and_message(self) -> tuple[str, str]:
        """How the path ended, as a term, "steady" or "end of path", and as a sentence."""
        path_on_grids = self.path_on_grids
        if path_on_grids.steady_from is None:
            return "end of path", "the path was followed to its end"
        return (
            "steady",
            f"cycle {path_on_grids.steady_from + 1} repeats the one before to"
            f" {path_on_grids.steady_tolerance:.0e} of its work",
        )

    def _errors_on_grids(self) -> dict[str, float]:
        """Relative errors of the fields that were asked for, by name, as the grids estimate them.

        That of the friction work of a steady cycle also contains the difference of that work from
        the closed integral of Q dU, `loop_work`. U is the tangential displacement.
        """
        path_on_grids = self.path_on_grids
        errors = dict(path_on_grids.errors)
        work_of_last_cycle = float(path_on_grids.works[-1])
        if path_on_grids.steady_from is not None and work_of_last_cycle > 0:
            errors["dissipation"] += abs(path_on_grids.loop_work / work_of_last_cycle - 1)
        return {name: error for name, error in errors.items() if name in self.question.fields}

    def _note_of_grids(self, findings_without_grids: Findings | None) -> str:
        """The sentence that an answer by grids carries: how fine the grids are, and how well the
        friction work W and the stick edges are known.

        The grids are as fine as the numbers of cells across the contact and of increments in a
        cycle.
        With `findings_without_grids`, the answer for the steady cycle by another method, the
        sentence states that W does not come from grids.
        """
        path_on_grids = self.path_on_grids
        # of cells across the largest contact, and of stick zones at most
        n_cells = path_on_grids.counts["cells"]
        n_stick_zones = path_on_grids.counts["pieces"]
        error_of_work = f"dissipation to {path_on_grids.errors['dissipation']:.1e}, "
        note_of_zones = ""
        if n_stick_zones > 1:
            note_of_zones = f"; they are the outer ones of up to {n_stick_zones} zones"
        note_of_work = ""
        if findings_without_grids is not None:
            error_of_work = ""
            note_of_work = (
                "; W, W(x) and permanent stick are those of the steady cycle, without grids"
            )
        # A cell is 2/n_cells of the largest half-width a.
        return (
            f"no one memory curve: half-plane theory on grids of {n_cells} cells and"
            f" {INCREMENTS_PER_CYCLE} increments a cycle,"
            f" {error_of_work}edges of stick to about {2 / n_cells:.2g} a"
            f"{note_of_zones}{note_of_work}"
        )

    @property
    def _cell_width(self) -> float:
        """Width of a cell [length]: that of the widest contact of the path over its cells."""
        widest_contact = float(np.max(np.diff(self.path_on_grids.contact_edges)))
        return widest_contact / self.path_on_grids.counts["cells"]

    def _rows(self) -> slice:
        """The instants of the answer, among all that were followed, as a slice. They are those of
        the last cycle where it alone is asked for, else all, as of a path that does not repeat.
        """
        load_path = self.question.scene.load.path()
        if not self.question.wants_last_cycle_alone or load_path.period is None:
            return slice(None)
        n_cycles = len(self.path_on_grids.works)
        start_of_last_cycle = load_path.cycle_start + (n_cycles - 1) * load_path.period
        return slice(
            int(np.searchsorted(self.path_on_grids.time, start_of_last_cycle * (1 + 1e-12))), None
        )

    def _values(self) -> dict[str, Any]:
        """Values as the grids give them, by their names in a solution: loads (n,), edges (n, 2),
        fields (n, k), friction work, and the uncertainty of permanent stick.

        There are n instants and k points. A field that was not asked for is NaN, a state is open.
        """
        rows = self._rows()
        return {
            **self._fields(rows),
            **self._works(),
            **self._loads_and_edges(rows),
            **self._permanent_stick(),
            "steady_from": self.path_on_grids.steady_from,
        }

    def _loads_and_edges(self, rows: slice) -> dict[str, Array]:
        """Loads, bulk stresses, tilt, moments and half-widths (n,), and edges (n, 2), at the
        instants `rows` of the path, by their names in a solution.
        """
        path_on_grids = self.path_on_grids
        normal_load, tangential_load, _, tilt = path_on_grids.loads[:, rows]
        contact_edges = path_on_grids.contact_edges[rows]
        stick_edges = path_on_grids.stick_edges[rows]
        stress_of_lower_body, stress_of_upper_body = self._path_loads.bulk_stresses(
            path_on_grids.time[rows]
        )
        return {
            "normal_load": normal_load,
            "tangential_load": tangential_load,
            "contact_edges": contact_edges,
            "stick_edges": stick_edges,
            "contact_half_width": np.diff(contact_edges)[:, 0] / 2,
            "stick_half_width": np.diff(stick_edges)[:, 0] / 2,
            "bulk_stress_lower": stress_of_lower_body,
            "bulk_stress_upper": stress_of_upper_body,
            "tilt": tilt,
            "moment": path_on_grids.moment[rows],
            "shear_moment": path_on_grids.shear_moment[rows],
        }

    def _fields(self, rows: slice) -> dict[str, NDArray[Any]]:
        """Displacements (n,), pressure, shear, slip and state (n, k) at n instants and k points,
        and friction work per area (k,), by their names in a solution.

        The instants are the `rows` of the path. A field that was not asked for is NaN, a state is
        open.
        """
        path_on_grids = self.path_on_grids
        normal_load, tangential_load, _, tilt = path_on_grids.loads[:, rows]
        contact_edges = path_on_grids.contact_edges[rows]
        contact_middle = np.mean(contact_edges, axis=1)
        contact_half_width = np.diff(contact_edges)[:, 0] / 2
        # The tangential displacement U of the grids has the datum length 1, that of the answer
        # the datum length L of the profile: (A/pi) Q ln(L) more, A = 2/E*.
        scene = self.question.scene
        unit_compliance = 2 / (math.pi * composite_modulus(scene.material))  # A/pi
        datum_shift = unit_compliance * tangential_load * math.log(scene.profile.datum_length)
        fields: dict[str, NDArray[Any]] = {
            "tangential_displacement": path_on_grids.displacement[rows] + datum_shift,
            "normal_approach": self._tilted_contact.approach(
                contact_middle, contact_half_width, normal_load, tilt
            ),
            "pressure": path_on_grids.pressure[rows],
            "shear": path_on_grids.shear[rows],
            "slip": path_on_grids.slip[rows],
            "dissipation_density": path_on_grids.density,
            "state": path_on_grids.state[rows],
        }
        for name, field in fields.items():
            if not self.question.wants(name):
                fields[name] = np.full_like(field, OPEN if name == "state" else np.nan)
        return fields

    def _works(self) -> dict[str, float | Array]:
        """Works as the grids give them, by their names in a solution [energy per thickness]:
        friction work of the last cycle and of each, and closed integral of the loads.

        The integral is that of the last cycle, NaN without a steady one. All are NaN where the work
        was not asked for.
        """
        path_on_grids = self.path_on_grids
        # of the last cycle alone where the steady cycle is enough
        works = path_on_grids.works[-1:] if self._steady_only else path_on_grids.works
        if not self.question.wants("dissipation"):
            return {
                "dissipation": math.nan,
                "loop_work": math.nan,
                "cycle_dissipation": np.full_like(works, np.nan),
            }
        is_steady = path_on_grids.steady_from is not None
        return {
            "dissipation": float(works[-1]),
            "loop_work": path_on_grids.loop_work if is_steady else math.nan,
            "cycle_dissipation": works,
        }

    def _permanent_stick(self) -> dict[str, Any]:
        """Half-width and edges (2,) of the permanent stick zone, and the uncertainty of the former
        as the grids give it, by name [length]. NaN, without uncertainty, of a path without cycles:
        it begins unloaded, where nothing sticks.
        """
        stick_edges = np.full(2, math.nan)
        uncertainties = {}
        if self.question.scene.load.path().period is not None:
            stick_edges = self.path_on_grids.permanent_stick_edges
            uncertainties["permanent_stick_half_width"] = (
                self.path_on_grids.permanent_stick_uncertainty
            )
        return {
            "permanent_stick_half_width": float(stick_edges[1] - stick_edges[0]) / 2,
            "permanent_stick_edges": stick_edges,
            "uncertainties": uncertainties,
        }
