"""The store of a sweep and the loop that fills it, with workers that die on command: nothing lost, nothing twice, nothing wrong."""

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Future
from pathlib import Path
from typing import Any

import pytest

from reports.sweep import running
from reports.sweep.claims import Claims, alive
from reports.sweep.crews import Crew, Loss
from reports.sweep.index import read_index
from reports.sweep.solving import solve_task
from reports.sweep.store import Store, StoreError
from reports.sweep.study import Study
from scenes import InputError
from test_reports_sweep_study import study

AXIS = {"name": "f", "key": "friction.coefficient", "linear": {"start": 1, "stop": 2, "count": 7}}
Fault = Callable[[list[float]], BaseException | None]


class Bench:
    """A crew that works at once, in this process; `fault` sees the frictions of a task and may let its worker die."""

    shared_fate = True
    width = 2

    def __init__(self, fault: Fault = lambda _frictions: None) -> None:
        self.fault = fault
        self.renewed = 0
        self.handed: list[list[float]] = []

    def submit(self, text: str) -> "Future[str]":
        frictions = [point["scene"]["friction"]["coefficient"] for point in json.loads(text)["points"]]
        self.handed.append(frictions)
        future: Future[str] = Future()
        fault = self.fault(frictions)
        if fault is None:
            future.set_result(solve_task(text))
        else:
            future.set_exception(fault)
        return future

    def loss(self, fault: BaseException) -> Loss | None:
        if isinstance(fault, CancelledError):
            return Loss.SCHEDULER
        return Loss.WORKER if isinstance(fault, BrokenExecutor) else None

    def broken(self) -> bool:
        return False

    def renew(self, _signals: Sequence[int] = (), /) -> None:
        self.renewed += 1

    def dismiss(self, at_once: bool = False) -> None:
        pass


@pytest.fixture
def hire(monkeypatch: pytest.MonkeyPatch) -> Callable[[Crew], Crew]:
    def use(crew: Crew) -> Crew:
        monkeypatch.setattr(running, "crew_of", lambda *_: lambda: crew)
        return crew

    return use


def asked() -> Study:
    return study(axes=[AXIS])


def values(folder: Path) -> dict[float, float]:
    """Friction -> dissipation of every row; a point that is there twice fails."""
    table = read_index(folder).done()
    assert len({row["address"] for row in table.rows}) == len(table.rows)
    return dict(zip(table.numbers("f").tolist(), table.numbers("exact.dissipation").tolist(), strict=True))


@pytest.fixture
def truth(tmp_path: Path, hire: Callable[[Crew], Crew]) -> dict[float, float]:
    """An undisturbed sweep."""
    hire(Bench())
    running.run(asked(), tmp_path / "truth")
    found = values(tmp_path / "truth")
    assert len(found) == 7
    return found


class TestLosses:
    def test_a_worker_that_dies_once_costs_nothing(
        self, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew]
    ) -> None:
        deaths = iter([True])
        crew = Bench(lambda frictions: BrokenExecutor() if 1.5 in frictions and next(deaths, False) else None)
        hire(crew)
        running.run(asked(), tmp_path / "out")
        assert values(tmp_path / "out") == truth
        assert crew.renewed == 1

    def test_a_point_that_kills_its_worker_fails_alone(
        self, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew]
    ) -> None:
        crew = Bench(lambda frictions: BrokenExecutor() if 1.5 in frictions else None)
        hire(crew)
        table = running.run(asked(), tmp_path / "out")
        assert values(tmp_path / "out") == {f: w for f, w in truth.items() if f != 1.5}
        [failed] = [row for row in table.rows if row["status"] == "failed"]
        assert (failed["f"], failed["exact.dissipation"]) == (1.5, None)
        assert "died twice" in failed["reason"]
        assert [1.5] in crew.handed  # the second time alone
        hire(Bench())
        running.run(asked(), tmp_path / "out")  # and the next sweep tries it again
        assert values(tmp_path / "out") == truth

    def test_a_lost_scheduler_blames_nobody(self, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew]) -> None:
        losses = iter([True, True])
        crew = Bench(lambda frictions: CancelledError() if 1.5 in frictions and next(losses, False) else None)
        hire(crew)
        running.run(asked(), tmp_path / "out")
        assert values(tmp_path / "out") == truth
        assert crew.renewed == 2

    def test_a_scheduler_that_never_stays_ends_the_sweep(self, tmp_path: Path, hire: Callable[[Crew], Crew]) -> None:
        hire(Bench(lambda _frictions: CancelledError()))
        with pytest.raises(InputError, match="scheduler was lost"):
            running.run(asked(), tmp_path / "out")

    def test_other_code_on_a_worker_is_refused(
        self, tmp_path: Path, hire: Callable[[Crew], Crew], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        hire(Bench())
        monkeypatch.setattr("reports.sweep.solving.code_versions", lambda: {"code": "other"})
        with pytest.raises(InputError, match=r"code is .* here and other there"):
            running.run(asked(), tmp_path / "out")
        assert Store(tmp_path / "out").addresses() == set()


class TestResume:
    def test_what_is_done_is_not_done_again(self, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew]) -> None:
        crew = Bench()
        hire(crew)
        running.run(asked(), tmp_path / "truth")
        assert crew.handed == []
        more = study(axes=[AXIS | {"linear": {"start": 1, "stop": 2, "count": 13}}])
        running.run(more, tmp_path / "truth")
        assert sum(len(task) for task in crew.handed) == 6
        assert truth.items() <= values(tmp_path / "truth").items()

    def test_results_are_not_mixed_in_unasked(self, tmp_path: Path, truth: dict[float, float]) -> None:
        with pytest.raises(InputError, match="--resume"):
            running.prepare(asked(), tmp_path / "truth", resume=False)

    def test_an_interrupted_sweep_keeps_what_it_has(
        self, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew]
    ) -> None:
        hire(Bench(lambda frictions: KeyboardInterrupt() if 2.0 in frictions else None))
        with pytest.raises(KeyboardInterrupt):
            running.run(asked(), tmp_path / "out")
        assert list((tmp_path / "out" / "claims").iterdir()) == []
        assert (tmp_path / "out" / "index.csv").exists()
        kept = values(tmp_path / "out")
        assert 0 < len(kept) < 7
        hire(Bench())
        running.run(asked(), tmp_path / "out")
        assert values(tmp_path / "out") == truth

    def test_a_failed_point_is_a_row_with_its_reason(
        self, tmp_path: Path, hire: Callable[[Crew], Crew], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        from reports.sweep import solving

        def solve(_asked: object, scene: Any) -> Any:
            if scene.friction.coefficient == 1.5:
                raise ArithmeticError("no root")
            return original(_asked, scene)  # type: ignore[arg-type]

        original = solving.exact_alone
        monkeypatch.setattr(solving, "exact_alone", solve)
        monkeypatch.setattr(solving, "in_one_call", lambda *_: {})
        hire(Bench())
        table = running.run(asked(), tmp_path / "out")
        assert [row["reason"] for row in table.rows if row["status"] == "failed"] == ["ArithmeticError: no root"]
        assert len(table.done().rows) == 6


class TestDamage:
    @pytest.mark.parametrize("how", ["digit", "cut", "empty", "binary", "swapped"])
    def test_a_damaged_result_is_set_aside_and_made_anew(
        self, how: str, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew]
    ) -> None:
        store = Store(tmp_path / "truth")
        one, other = sorted(store.addresses())[:2]
        path = store.path(one)
        text = path.read_text(encoding="utf-8")
        if how == "digit":
            path.write_text(text.replace('"exact.dissipation": 0.002', '"exact.dissipation": 0.003'), encoding="utf-8")
            assert path.read_text(encoding="utf-8") != text
        elif how == "swapped":
            path.write_text(store.path(other).read_text(encoding="utf-8"), encoding="utf-8")
        else:
            path.write_bytes({"cut": text.encode()[:200], "empty": b"", "binary": b"\xff\x00\xfe" * 50}[how])
        assert len(values(tmp_path / "truth")) == 6
        assert len(store.damaged()) == 1
        crew = Bench()
        hire(crew)
        running.run(asked(), tmp_path / "truth")
        assert values(tmp_path / "truth") == truth
        assert sum(len(task) for task in crew.handed) == 1

    @pytest.mark.usefixtures("truth")
    def test_a_result_that_can_not_be_read_is_a_sentence_and_stays(self, tmp_path: Path) -> None:
        """What is no damage is not made anew over it: no right to read, a folder in its place."""
        store = Store(tmp_path / "truth")
        path = store.path(min(store.addresses()))
        path.unlink()
        path.mkdir()
        with pytest.raises(StoreError, match="this result can't be read: Is a directory; mend that, or name another"):
            store.read(path.stem)
        assert path.is_dir()

    def test_a_full_disk_is_a_sentence_and_loses_nothing(
        self, tmp_path: Path, truth: dict[float, float], hire: Callable[[Crew], Crew], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        real, room = os.fsync, iter(range(4))  # the plan, then three results

        def fsync(handle: int) -> None:
            if next(room, None) is None:
                raise OSError(errno.ENOSPC, "No space left on device")
            real(handle)

        hire(Bench())
        monkeypatch.setattr(os, "fsync", fsync)
        with pytest.raises(StoreError, match=r"no room left on the disk.*stays"):
            running.run(asked(), tmp_path / "out")
        monkeypatch.setattr(os, "fsync", real)
        assert len(values(tmp_path / "out")) == 3
        assert not list((tmp_path / "out").rglob("*.part"))
        running.run(asked(), tmp_path / "out")
        assert values(tmp_path / "out") == truth


class TestClaims:
    def test_a_point_of_a_living_sweep_is_left_to_it(self, tmp_path: Path) -> None:
        store = Store(tmp_path)
        store.prepare()
        owner = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
        try:
            ours = Claims(store)
            from reports.sweep import claims

            words = json.loads(ours._words) | {"pid": owner.pid, "born": claims._born(owner.pid)}
            (store.claims / "a").write_text(json.dumps(words), encoding="utf-8")
            assert not ours.take("a")
            assert ours.take("b")
            assert not Claims(store).take("b") or alive(store.claims / "b")
        finally:
            owner.kill()
            owner.wait()
        assert ours.take("a")  # its owner is dead
        ours.drop_all()
        assert list(store.claims.iterdir()) == []

    def test_a_process_number_used_again_is_not_the_owner(self, tmp_path: Path) -> None:
        store = Store(tmp_path)
        store.prepare()
        words = json.loads(Claims(store)._words) | {"born": "1"}
        (store.claims / "a").write_text(json.dumps(words), encoding="utf-8")
        assert Claims(store).take("a")
