"""Each law of contact, broken by hand, is seen by its own certificate."""

from typing import Any

import numpy as np
import pytest

from reports import compare
from scenes import freeze
from test_reports_metrics import TRUTH, changed, swapped_state


class TestCertificates:
    """Each law, broken by hand, is seen by its own certificate."""

    def names(self, **fields: Any) -> set[str]:
        return {check.label for check in compare(TRUTH, changed(**fields)).result_certificates if not check.holds}

    def test_none_broken(self) -> None:
        assert self.names() == set()

    def test_tension(self) -> None:
        pressure = TRUTH.pressure.copy()
        pressure[5, 0] = -1e-6 * pressure.max()
        assert "tension (fields)" in self.names(pressure=pressure)

    def test_cone(self) -> None:
        assert self.names(shear=1.0001 * TRUTH.shear) == {"cone (fields)", "slip (fields)"}

    def test_cone_on_the_side_of_negative_shear(self) -> None:
        outside = np.where(TRUTH.shear < 0, 1.0001, 1.0) * TRUTH.shear
        assert "cone (fields)" in self.names(shear=outside)

    def test_slip_short_of_friction(self) -> None:
        assert self.names(shear=0.9999 * TRUTH.shear) == {"slip (fields)"}

    def test_slip_with_friction_instead_of_against_it(self) -> None:
        assert self.names(state=swapped_state().state) == {"slip (fields)"}

    def test_loads(self) -> None:
        assert self.names(tangential_load=TRUTH.tangential_load + 1e-6) == {"loads (fields)"}

    @pytest.mark.parametrize("value", [1e-6, float("nan")])
    def test_record(self, value: float) -> None:
        series = np.zeros(len(TRUTH.time))
        series[9] = value
        record = type(TRUTH.record)(
            True, "steady", "", freeze(np.ones(len(TRUTH.time)), np.int64), {"energy_balance": freeze(series)}
        )
        found = compare(TRUTH, changed(record=record))
        broken = [check for check in found.result_certificates if not check.holds]
        assert [(check.label, check.time) for check in broken] == [("energy balance (record)", TRUTH.time[9])]
        assert found.accurate is bool(np.isfinite(value))
        assert not found.passed
