"""The contract: values of both engines and of comparisons that a rebuild must not move.

`make contract` runs all of it, `make test` a part. The frozen files were made once, by
`PYTHONPATH=tests python tests/contract/contract_values.py KIND`, and are made again only for what
an issue says that it changes.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from contract_values import (
    AGREES,
    COMPARED,
    FINITE_ELEMENTS,
    HERE,
    LOOSER,
    QUICK,
    comparison_values,
    differences,
    fe_values,
    finite_elements,
    frozen,
    half_plane,
    refusal,
    scene_of,
)

TABLE = json.loads((HERE / "half_plane.json").read_text(encoding="utf-8"))
FE_AGREES = 1e-9


def some(names, quick):
    return [name if name in quick else pytest.param(name, marks=pytest.mark.slow) for name in names]


@pytest.mark.parametrize("name", some(TABLE, QUICK))
def test_half_plane_theory_gives_the_frozen_values(name: str) -> None:
    kept, scene = TABLE[name], scene_of(name)
    if "refused" in kept:
        assert refusal(scene) == [
            kept["refused"][0],
            *(pytest.approx(value, rel=1e-9) for value in kept["refused"][1:]),
        ]
        return
    now = half_plane(scene, kept["x"], kept["time"])

    # The stated error of shear is a share of f times the largest pressure, `differences` takes
    # shares of the largest shear.
    pressure, shear = (
        np.nanmax(np.abs(np.array(kept["values"][field], dtype=float)))
        for field in ("pressure", "shear")
    )
    shares = {"shear": scene.friction.coefficient * pressure / shear if shear else 1.0}

    def allowed(field: str) -> float:
        return max(
            AGREES, LOOSER.get(field, 0.0), shares.get(field, 1.0) * kept["stated"].get(field, 0.0)
        )

    assert not list(differences(kept["values"], now["values"], allowed))
    if kept["reference"]:  # 30 digits, by other means
        assert now["values"]["dissipation"] == pytest.approx(
            float(kept["reference"]), rel=allowed("dissipation"), abs=1e-300
        )


@pytest.mark.parametrize(
    "name", some(FINITE_ELEMENTS, ("cattaneo-mindlin", "flat-rounded-paper", "blocks"))
)
def test_finite_elements_give_the_frozen_values(name: str) -> None:
    # 1e-15 is round-off of a loop that encloses nothing: the closed integral of Q dU where no node
    # slips.
    assert not list(
        differences(
            frozen("finite_elements")[name],
            fe_values(finite_elements(name)),
            lambda _: FE_AGREES,
            1e-15,
        )
    )


@pytest.mark.parametrize("name", some(COMPARED, ("cattaneo-mindlin", "blocks")))
def test_comparisons_give_the_frozen_values(name: str, tmp_path: Path) -> None:
    # Errors are differences of the two answers: of the size of a tolerance, known to what the
    # answers are.
    # A metric is a share of a value of the reference: 1e-14 is rounding, and all that some, such as
    # the energy balance, are.
    assert not list(
        differences(
            frozen("comparison")[name],
            comparison_values(name, tmp_path / "out"),
            lambda _: 1e-6,
            1e-14,
        )
    )


def test_every_planted_fault_of_the_list_still_has_its_test() -> None:
    rows = json.loads((HERE / "planted_faults.json").read_text(encoding="utf-8"))
    for row in rows:
        file, test = row["test"].split("::")
        text = (HERE.parent / file).read_text(encoding="utf-8")
        assert f"def {test}(" in text, (
            f"{row['fault']}: {row['test']} is gone; what found the fault now belongs into"
            " planted_faults.json"
        )
    assert len(rows) >= 60
