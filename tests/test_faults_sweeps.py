"""A sweep whose store goes while it works, and a Ctrl-C that the terminal sends to the workers too."""

from __future__ import annotations

import os
import shutil
import signal
import threading
from concurrent.futures import Future
from pathlib import Path

import pytest

from faulty_processes import STUDY
from reports.sweep import running as running_module
from reports.sweep.claims import Claims, alive, running
from reports.sweep.crews import Processes, _deaf_to_ctrl_c
from reports.sweep.progress import state_of
from reports.sweep.store import Planned, Store

ADDRESSES = [f"{number:064x}" for number in range(3)]


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """Three points done."""
    made = Store(tmp_path / "out")
    made.prepare()
    made.write_plan({"title": "t"}, [Planned(number, address, {"f": number}) for number, address in enumerate(ADDRESSES)])
    for address in ADDRESSES:
        made.write({"address": address, "status": "done", "figures": {"W": 1.0}, "seconds": 1.0, "reason": ""})
    return made


@pytest.mark.parametrize("instead", ["nothing", "a file"])
def test_a_claim_is_let_go_of_though_the_store_is_gone(instead: str, store: Store) -> None:
    """Else this fault hides the one that ended the sweep, with what it says of going on."""
    claims = Claims(store)
    assert claims.take(ADDRESSES[0])
    assert running(store) == {ADDRESSES[0]}
    shutil.rmtree(store.folder)
    if instead == "a file":
        store.folder.write_text("mine")
    claims._renewed = -1e9
    claims.renew()
    claims.drop_all()
    assert running(store) == set()
    assert not alive(store.claims / ADDRESSES[0])


def test_a_claim_that_nobody_else_may_read_counts_while_it_is_fresh(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> str:
        raise PermissionError(13, "Permission denied")

    Claims(store).take(ADDRESSES[0])
    path = store.claims / ADDRESSES[0]
    monkeypatch.setattr(Path, "read_text", refuse)
    assert alive(path)
    os.utime(path, (0, 0))
    assert not alive(path)


def test_the_state_is_told_though_a_result_goes_meanwhile(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the table and the times of its results: set aside by another process, or removed."""

    def running_then_gone(asked: Store) -> set[str]:
        asked.path(ADDRESSES[1]).unlink()
        return set()

    monkeypatch.setattr("reports.sweep.progress.running", running_then_gone)
    state, _ = state_of(store)
    assert (state.done, state.total) == (3, 3)


def test_workers_are_deaf_to_ctrl_c_from_birth() -> None:
    """A terminal sends it to them too: one that came while they were born ended in their tracebacks."""
    crew = Processes(1)
    try:
        assert signal.SIGINT in crew._executor.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result(60)
    finally:
        crew.dismiss(at_once=True)
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_ctrl_c_while_workers_are_born_is_heard_at_the_end() -> None:
    """Also where the system hands it to another thread, as it may: one of BLAS, of a pool, of pytest-xdist."""
    reached = []
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    end = threading.Event()
    other = threading.Thread(target=end.wait)
    other.start()

    def hired() -> None:
        with _deaf_to_ctrl_c():
            signal.pthread_kill(other.ident or 0, signal.SIGINT)
            os.read(reading, 1)  # it is there once the signal is
            reached.append(True)

    before = signal.set_wakeup_fd(writing)
    try:
        with pytest.raises(KeyboardInterrupt):
            hired()
    finally:
        signal.set_wakeup_fd(before)
        end.set()
        other.join()
        os.close(reading)
        os.close(writing)
    assert reached == [True]


def test_ctrl_c_in_a_round_ends_the_sweep_after_it_with_its_workers_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Raised amid the locks of a pool, it left one locked now and then: the program never ended."""
    dismissed, rounds = [], []

    class Busy:
        width, shared_fate = 1, True

        def submit(self, text: str) -> Future[str]:
            return Future()

        def broken(self) -> bool:
            rounds.append(True)
            os.kill(os.getpid(), signal.SIGINT)
            rounds.append(True)
            return False

        def dismiss(self, at_once: bool = False) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            dismissed.append(at_once)

    monkeypatch.setattr(running_module, "crew_of", lambda *_: Busy)
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    with pytest.raises(KeyboardInterrupt):
        running_module.run(tmp_path / "study.toml", tmp_path / "out")
    assert (len(rounds), dismissed) == (2, [True])
    assert list((tmp_path / "out" / "claims").iterdir()) == []
