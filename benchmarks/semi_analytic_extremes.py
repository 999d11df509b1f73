"""The worst figures of the half-plane engine over everything that is hard: stored 30-digit tables, scales, routes, inverses.

python benchmarks/semi_analytic_extremes.py        (about a minute)
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from claim import Row, table

import semi_analytic
from scenes import (
    CallableProfile,
    Compound,
    Elastic,
    EllipseLoad,
    EvenPolynomial,
    FlatRounded,
    Friction,
    Hertz,
    Materials,
    PowerLaw,
    Profile,
    Scene,
    Tabulated,
    Wedge,
    load_scene,
    scene_names,
)
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import closed_integral, global_dissipation
from semi_analytic.hertz import HertzContact
from semi_analytic.history import history_of
from semi_analytic.profiles import contact_of
from semi_analytic_oracle import work_over_points

TABLE = Path(__file__).with_name("semi_analytic_reference.json")


def profile_of(flat: float, size: float = 1.0) -> Profile:
    """Hertz or flat and rounded with R = `size`."""
    return FlatRounded(radius=size, flat_half_length=flat * size) if flat else Hertz(radius=size)


def like(modulus: float) -> Materials:
    """Like bodies with that E*."""
    body = Elastic(young_modulus=2 * modulus, poisson_ratio=0.0)
    return Materials(upper=body, lower=body)


def batch(row: dict[str, Any], load: float = 1.0, length: float = 1.0, modulus: float = 1.0) -> float:
    """Dissipation of a row of the table in other units; W E*/load^2 must not know them."""
    phase = row["phase"] if row["radians"] else math.radians(row["phase"])
    radius = length**2 * modulus / load  # b/a stays
    profile = FlatRounded(radius=radius, flat_half_length=row["flat"] * length) if row["flat"] else Hertz(radius=radius)
    return float(
        semi_analytic.dissipation(
            profile=profile,
            material=like(modulus),
            friction_coefficient=row["friction"],
            mean_normal_load=row["mean"] * load,
            normal_amplitude=row["amplitude"] * load,
            mean_tangential_load=0.0,
            tangential_amplitude=row["tangential"] * load,
            phase=phase,
        ).value
    )


def scene_of(row: dict[str, Any]) -> Scene:
    """A row of the table as a scene."""
    load = EllipseLoad(
        mean_normal_load=row["mean"],
        normal_amplitude=row["amplitude"],
        mean_tangential_load=0.0,
        tangential_amplitude=row["tangential"],
        phase_degrees=math.degrees(row["phase"]) if row["radians"] else row["phase"],
        initial_loading="straight",
    )
    friction = Friction(coefficient=row["friction"])
    return Scene(name="row", material=like(1.0), profile=profile_of(row["flat"]), friction=friction, load=load)


def table_rows() -> Iterator[Row]:
    """The 41 scenes of the table and its extremes."""
    rows = json.loads(TABLE.read_text(encoding="utf-8"))
    plain = [row for row in rows if not row["radians"]]
    works, densities = [], []
    for row in plain:
        answer = semi_analytic.solve(scene_of(row), x=row["x"], fields=("dissipation", "dissipation_density"))
        exact = np.array([float(value) for value in row["density"]])
        works.append(abs(answer.dissipation / float(row["dissipation"]) - 1))
        densities.append(np.max(np.abs(answer.dissipation_density - exact)) / np.max(exact))
    how = f"{len(plain)} ellipses, Hertz and flat face, five phases, f from 1e-3 to 10; solve against 30 digits"
    yield Row("worst relative error of W", max(works), 1e-12, how)
    yield Row("worst error of W(x) over max W", float(max(densities)), 1e-9, how)
    extremes = [row for row in rows if row["radians"]]
    for name, chosen in classes(extremes).items():
        errors = [abs(batch(row) / float(row["dissipation"]) - 1) for row in chosen]
        yield Row(f"worst relative error of W, {name}", max(errors), 1e-10, f"{len(chosen)} ellipses, batch against 30 digits")


def classes(rows: list[dict[str, Any]]) -> dict[str, list[dict[str, Any]]]:
    """The extremes by what makes them hard."""

    def chosen(test: Any) -> list[dict[str, Any]]:
        return [row for row in rows if test(row, row["tangential"] / row["friction"], row["amplitude"])]

    return {
        "slip of 1e-9 to 1e-6 of f P": chosen(lambda row, q, p: q <= 1e-6 and p < 0.9),
        "1 - 1e-12 of gross sliding": chosen(lambda row, q, p: p == 0.4),
        "P1/P0 = 1 - 1e-9": chosen(lambda row, q, p: p > 0.9),
        "within 1e-9 of phase 0 or pi": chosen(lambda row, q, p: abs(math.sin(row["phase"])) < 1e-8 and q != p),
        "the same at tangency, dQ/dP = +-f": chosen(lambda row, q, p: abs(math.sin(row["phase"])) < 1e-8 and q == p),
    }


def scale_rows() -> Iterator[Row]:
    """Loads, lengths and E scaled, all together: by powers of two, which leave the question the same to the last digit, and of ten,
    which round it: two figures that are good to 1e-12 each.
    """
    rows = json.loads(TABLE.read_text(encoding="utf-8"))[:41:5]
    for base, loads, lengths, limit in ((2.0, 40, 30, 1e-13), (10.0, 12, 9, 2e-12)):
        worst = 0.0
        units = (base ** np.array([-power, power]) for power in (loads, lengths, loads))
        for row, load, length, modulus in product(rows, *units):
            worst = max(worst, abs(batch(row, load, length, modulus) * modulus / load**2 / batch(row) - 1))
        how = f"{len(rows)} ellipses, loads and E by {base:g}^+-{loads}, lengths by {base:g}^+-{lengths}"
        yield Row(f"worst change of W E*/P^2 with the units, powers of {base:g}", worst, limit, how)


def route_rows() -> Iterator[Row]:
    """Slip integral, int W(x) dx, the figure of solve, closed-int Q dU and the batch, in every scene of the library that slips."""
    for name in scene_names():
        values = routes(load_scene(name))
        if values["slip"]:
            worst = max(abs(value / values["slip"] - 1) for value in values.values())
            yield Row(f"{name}: routes to W apart", worst, 1e-10, ", ".join(values))


def routes(scene: Scene) -> dict[str, float]:
    """W of the last cycle by every way that there is."""
    contact, modulus = contact_of(scene.profile, scene.material), composite_modulus(scene.material)
    history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    spans = history.cycles[-1]
    work = float(global_dissipation(contact, modulus, spans).total)
    found = {
        "slip": work,
        "solve": semi_analytic.solve(scene, x=[0.0], fields=("dissipation",)).dissipation,
        "W(x)": work_over_points(contact, modulus, spans, work),
    }
    if scene.load.path().period is not None:
        found["Q dU"] = closed_integral(contact, modulus, spans)[0]
    if isinstance(scene.load, EllipseLoad):
        found["batch"] = of_batch(scene)
    return found


def of_batch(scene: Scene) -> float:
    """W of a scene with an ellipse by the batch."""
    load = scene.load
    assert isinstance(load, EllipseLoad)
    answer = semi_analytic.dissipation(
        profile=scene.profile,
        material=scene.material,
        friction_coefficient=scene.friction.coefficient,
        mean_normal_load=load.mean_normal_load,
        normal_amplitude=load.normal_amplitude,
        mean_tangential_load=load.mean_tangential_load,
        tangential_amplitude=load.tangential_amplitude,
        phase=math.radians(load.phase_degrees),
    )
    return float(answer.value)


PROFILES: dict[str, Profile] = {
    "hertz": Hertz(radius=1.0),
    "power law 1.5": PowerLaw(exponent=1.5, length=1.0, rise=0.5),
    "power law 4": PowerLaw(exponent=4.0, length=1.0, rise=0.5),
    "compound": Compound(inner_radius=1.0, outer_radius=0.4, inner_half_length=0.8),
    "wedge": Wedge(tip_radius=1.0, tip_half_length=1.0),
    "polynomial": EvenPolynomial(length=1.0, rises=(0.5, 0.1)),
}


X = np.linspace(0, 3, 61)
ENDING: dict[str, Profile] = {
    "table of cosh": Tabulated(points=np.column_stack([X, np.cosh(X) - 1]).tolist()),
    "table beside a flat": Tabulated(points=np.column_stack([X, np.maximum(X - 0.5, 0.0) ** 2]).tolist()),
    "slope sinh": CallableProfile(slope_function=np.sinh, extent=3.0),
    "height x^2/2": CallableProfile(height_function=lambda x: x * x / 2, extent=3.0),
    "slope beside a flat": CallableProfile(slope_function=lambda x: np.sign(x) * np.maximum(np.abs(x) - 0.5, 0.0), extent=3.0),
}


def ending_rows() -> Iterator[Row]:
    """P(a(P)) over the sixteen decades below the largest load of profiles that end; a(0) > 0 leaves only what a - a(0) can tell."""
    for name, profile in ENDING.items():
        contact = contact_of(profile, like(1.0))
        assert not isinstance(contact, HertzContact)
        load = float(contact.load(2.99)) * 10.0 ** np.linspace(-16, 0, 161)
        half = contact.half_width(load)
        off = np.abs(contact.load(half) / load - 1)
        told = 4 * np.finfo(float).eps * half * contact.stiffness(half) / load < 1e-13
        decades = float(np.log10(load[-1] / load[told][0]))
        yield Row(f"{name}: P(a(P))/P - 1", float(np.max(off[told])), 1e-13, f"{decades:.1f} of 16 decades below the last load")


def inverse_rows() -> Iterator[Row]:
    """P(a(P)) over sixteen decades; for the flat face b/a from 1e-8 to 1 - 1e-8."""
    load = 10.0 ** np.linspace(-8, 8, 161)
    for name, profile in PROFILES.items():
        contact = contact_of(profile, like(1.0))
        worst = float(np.max(np.abs(contact.load(contact.half_width(load)) / load - 1)))
        yield Row(f"{name}: P(a(P))/P - 1", worst, 1e-13, "P from 1e-8 to 1e8")
    contact = contact_of(FlatRounded(radius=1.0, flat_half_length=1.0), like(1.0))
    part = np.concatenate([10.0 ** np.linspace(-8, -1, 50), 1 - 10.0 ** np.linspace(-1, -8, 50)])
    back = contact.half_width(contact.load(1 / part)) * part
    yield Row("flat and rounded: a(P(a))/a - 1", float(np.max(np.abs(back - 1))), 1e-13, "b/a from 1e-8 to 1 - 1e-8")


def rows() -> Iterator[Row]:
    """All of them."""
    for part in (table_rows, scale_rows, route_rows, inverse_rows, ending_rows):
        yield from part()


def main() -> None:
    print(table(list(rows())))


if __name__ == "__main__":
    main()
