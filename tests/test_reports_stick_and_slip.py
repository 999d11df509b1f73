"""Stick sets, instants of full stick and of reversal, and slip: planted differences whose size is known by hand."""

import numpy as np
import pytest

from reports import compare
from scenes import ContactSolution, SurfaceState
from test_reports_all_metrics import seen, value
from test_reports_metrics import TRUTH, changed
from test_reports_synthetic import with_fields

INSIDE = TRUTH.state != SurfaceState.OPEN
STEPS = len(TRUTH.time) - 1


class TestStick:
    def test_stick_set_by_hand(self) -> None:
        """The innermost five points no longer stick through 20 of the instants; the share by plain counting."""
        state = TRUTH.state.copy()
        middle = len(TRUTH.x) // 2
        state[20:40, middle - 2 : middle + 3] = SurfaceState.SLIP_FORWARD
        found = compare(TRUTH, changed(state=state))
        weight = np.ones(STEPS + 1)
        weight[[0, -1]] = 0.5
        whole = float(weight @ (TRUTH.state == SurfaceState.STICK).sum(axis=1))
        assert found.metric("stick_set").value == pytest.approx(100 / whole, rel=1e-9)
        assert seen(found) == {"stick_set", "state"}

    def test_stick_set_is_the_same_both_ways(self) -> None:
        """Too little stick and too much of it count alike: over what sticks in either."""
        state = np.where(TRUTH.x > 0, SurfaceState.OPEN, TRUTH.state).astype(np.int8)
        there, back = (value(*pair, "stick_set") for pair in ((TRUTH, changed(state=state)), (changed(state=state), TRUTH)))
        assert there == pytest.approx(back, rel=1e-12)
        assert there == pytest.approx(0.5, abs=0.02)

    def test_stick_sets_apart_share_nothing(self) -> None:
        assert value(TRUTH, changed(state=np.where(TRUTH.state == 1, 2, 1).astype(np.int8)), "stick_set") == 1.0

    @pytest.mark.parametrize(("first", "last"), [(52, 57), (48, 60)])
    def test_full_stick_starts_and_ends(self, first: int, last: int) -> None:
        found = compare(full_stick((50, 58)), full_stick((first, last)))
        assert found.metric("full_stick_start").value == pytest.approx((first - 50) / STEPS, rel=1e-9)
        assert found.metric("full_stick_end").value == pytest.approx((last - 58) / STEPS, rel=1e-9)
        assert found.metric("full_stick_end").time == TRUTH.time[58]
        assert found.metric("full_stick_start").uncertainty == pytest.approx(1 / STEPS)

    def test_full_stick_across_the_end_of_the_cycle(self) -> None:
        """From step 110 of one cycle to step 5 of the next."""
        found = compare(full_stick((110, STEPS), (0, 5)), full_stick((0, 2)))
        assert found.metric("full_stick_start").value == pytest.approx(10 / STEPS, rel=1e-9)
        assert found.metric("full_stick_end").value == pytest.approx(-3 / STEPS, rel=1e-9)

    def test_a_single_instant_of_full_stick_is_a_turn_and_no_stretch(self) -> None:
        found = compare(full_stick((50, 58), (90, 90)), full_stick((50, 58)))
        assert found.metric("full_stick_start").value == 0.0
        assert not found.metric("full_stick_start").note

    def test_full_stick_that_the_result_lacks(self) -> None:
        metric = compare(full_stick((50, 58), (90, 93)), full_stick((50, 58))).metric("full_stick_end")
        assert metric.value is not None
        assert np.isnan(metric.value)
        assert metric.accurate is None
        assert metric.note == "1 of the reference's without a counterpart in the result"

    def test_full_stick_that_the_reference_lacks(self) -> None:
        metric = compare(full_stick((50, 58)), full_stick((50, 58), (90, 93))).metric("full_stick_end")
        assert metric.value == 0.0
        assert metric.note == "1 of the result's without a counterpart in the reference"

    @pytest.mark.parametrize("late", [-2, 3])
    def test_reversal_of_slip(self, late: int) -> None:
        """Slip in reverse begins `late` instants later (earlier) than in the reference; forward as it was."""
        begin = int(np.flatnonzero((TRUTH.time > 2) & (TRUTH.state == 3).any(axis=1))[0])
        base = begins(changed(state=TRUTH.state), begin + 5)
        found = compare(base, begins(TRUTH, begin + 5 + late))
        assert found.metric("slip_reversal").value == pytest.approx(late / STEPS, rel=1e-9)
        assert found.metric("slip_reversal").time == TRUTH.time[begin + 5]

    @pytest.mark.parametrize("late", [-2, 3])
    def test_each_reversal_is_compared_with_its_own(self, late: int) -> None:
        """Three times to and fro in a cycle, all late by as much, so that one of them comes round the end of the cycle."""
        found = compare(to_and_fro(0), to_and_fro(late))
        assert found.metric("slip_reversal").value == pytest.approx(late / STEPS, rel=1e-9)

    def test_an_edge_that_one_lacks_is_no_edge(self) -> None:
        edges = TRUTH.stick_edges.copy()
        edges[40:43] = np.nan
        found = compare(TRUTH, changed(stick_edges=edges))
        assert found.metric("stick_edge_left").value == found.metric("stick_edge_right").value == 0.0

    def test_reversals_that_are_not_as_many(self) -> None:
        state = np.where(TRUTH.state == 3, 2, TRUTH.state).astype(np.int8)
        metric = compare(TRUTH, changed(state=state)).metric("slip_reversal")
        assert np.isnan(metric.value or 0.0)
        assert metric.note.startswith("2 of the reference's")


def full_stick(*runs: tuple[int, int]) -> ContactSolution:
    """The closed form with the whole contact sticking from the first to the last step of each run."""
    edges = TRUTH.stick_edges.copy()
    for first, last in runs:
        edges[first : last + 1] = TRUTH.contact_edges[first : last + 1]
    return changed(stick_edges=edges)


def to_and_fro(late: int) -> ContactSolution:
    """Slip all over the contact, its sense changing every 20 of the 120 steps, the first time at step 1 + `late`."""
    forward = ((np.arange(STEPS + 1) - 1 - late) % STEPS // 20 % 2 == 0)[:, None]
    return changed(state=np.where(INSIDE, np.where(forward, 2, 3), 0).astype(np.int8))


def begins(solution: ContactSolution, step: int) -> ContactSolution:
    """`solution` with reverse slip beginning at `step` and sticking from Q's maximum until then."""
    state = solution.state.copy()
    state[41:step][state[41:step] > 1] = SurfaceState.STICK
    state[step:60][TRUTH.state[step:60] == SurfaceState.STICK] = SurfaceState.STICK
    return with_fields(solution, state=state)


class TestSlip:
    """s = 3 x sin(turn) in contact, so its range is 6; anything out of contact."""

    def slipping(self, factor: float = 1.0, outside: float = 0.0) -> ContactSolution:
        turn = 2 * np.pi * (TRUTH.time - 1) / 3
        slip = factor * 3 * TRUTH.x / np.abs(TRUTH.x[INSIDE[0]]).max() * np.sin(turn)[:, None]
        return changed(slip=np.where(INSIDE, slip, outside))

    def test_scaled(self) -> None:
        """2 % more: at the edge of the contact 1 % of the range; the root of the mean square by plain sums."""
        found = compare(self.slipping(), self.slipping(1.02))
        assert abs(found.metric("slip_maximum").value or 0.0) == pytest.approx(0.01, rel=1e-9)
        x = TRUTH.x[INSIDE[0]]
        assert found.metric("slip").value == pytest.approx(0.01 * np.sqrt(np.mean(x**2)) / np.abs(x).max(), rel=1e-9)
        assert seen(found) == {"largest_slip", "slip", "slip_maximum"}
        assert found.metric("largest_slip").value == pytest.approx(0.02, rel=1e-9)

    @pytest.mark.parametrize("offset", [-0.06, 0.06])
    def test_sign(self, offset: float) -> None:
        base = self.slipping()
        found = compare(base, with_fields(base, slip=base.slip + offset))
        assert found.metric("slip_maximum").value == pytest.approx(offset / 6, rel=1e-9)
        assert found.metric("slip").value == pytest.approx(0.01, rel=1e-9)

    def test_out_of_contact_nothing_slips(self) -> None:
        assert seen(compare(self.slipping(), self.slipping(outside=7.0))) == set()

    def test_absolute_where_the_reference_does_not_slip(self) -> None:
        scales = compare(TRUTH, TRUTH).scales
        metric = compare(TRUTH, changed(slip=0 * TRUTH.slip + 1e-3)).metric("slip_maximum")
        assert metric.absolute
        assert metric.value == pytest.approx(1e-3 / (scales.compliance / 2 * scales.shear * scales.half_width))
