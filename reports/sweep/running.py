"""A whole sweep: the study checked, points handed out to processes or to a dask cluster, results stored, the table returned.

Whatever dies, tasks go out again. A task whose worker died goes out point by point with nothing beside it, so that the point that
kills workers is found; lost again, it becomes a failure with that reason. What a lost scheduler held goes out again without blame.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, resource_tracker
from pathlib import Path
from typing import Any

import pandas as pd

from meshes.interrupts import interrupts_wait
from reports.console import complain
from reports.sweep.solving import code_versions, solve_task
from reports.sweep.store import Claims, Store
from reports.sweep.study import Point, Study, expand, load_study
from scenes import InputError
from scenes.frozen import validated

Report = Callable[[int, int, str], None]
WORKER_DIED, SCHEDULER_GONE = "the worker died", "the scheduler is gone"
# Half-plane theory alone takes some milliseconds a point: that many at once make the cost of handing them out small.
_EXACT_AT_ONCE, _FE_AT_ONCE = 50, 4
# Seconds: a round of the loop; until points of another sweep are looked at again; a scheduler may be away; a first answer takes.
_ROUND, _LOOK_AGAIN, _RECONNECT, _PATIENCE = 0.5, 2.0, 120.0, 10.0
_LOSSES = 5  # of a scheduler, before the sweep ends


class Processes:
    """Processes of this machine, behind an executor that can be started again once it broke.

    Of these and of `Dask`: `blame` is what an exception means for worker or scheduler, "" where it is the task's own; tasks of a
    crew that is `gone` never come back.
    """

    executor: Executor

    def __init__(self, width: int) -> None:
        self.width = width

    def blame(self, fault: BaseException) -> str:
        return WORKER_DIED if isinstance(fault, BrokenExecutor | CancelledError) else ""

    def gone(self) -> bool:
        return False

    def start(self) -> None:
        with _born_without_ctrl_c():
            context, pid = get_context("spawn"), os.getpid()
            self.executor = ProcessPoolExecutor(self.width, mp_context=context, initializer=_begin, initargs=(pid,))
            for _ in range(self.width):  # all of them start now
                self.executor.submit(os.getpid)

    def stop(self, *, at_once: bool) -> None:
        # The one way to stop a process in mid-task; `terminate_workers` comes with Python 3.14.
        workers = dict(getattr(self.executor, "_processes", None) or {})
        self.executor.shutdown(wait=not at_once, cancel_futures=True)
        if at_once:
            for worker in workers.values():
                worker.kill()
            for worker in workers.values():
                worker.join()


class Dask:
    """The workers of a dask scheduler: at an address, or of a cluster started here on the loopback interface.

    A task whose worker died goes to others by dask itself, as often as its setting `allowed-failures` states.
    """

    executor: Executor
    width: int

    def __init__(self, address: str, width: int | None, tls: dict[str, str]) -> None:
        self._address, self._asked, self._tls = address, width, tls
        self._open: list[Any] = []  # the client, then the cluster if it is ours

    def blame(self, fault: BaseException) -> str:
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        if isinstance(fault, KilledWorker):
            return WORKER_DIED
        return SCHEDULER_GONE if isinstance(fault, CancelledError | CommClosedError | TimeoutError | OSError) else ""

    def gone(self) -> bool:
        return str(self._open[0].status) != "running"

    def start(self) -> None:
        try:
            from distributed import Client, LocalCluster, Security
        except ImportError as reason:
            how = "pip install 'halfplane[cluster]'"
            raise InputError(f"--executor dask: the package distributed is not installed: {how}") from reason
        # What it loses we say in our own words, once; its tracebacks add nothing.
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        where = f"--scheduler {self._address}" if self._address else "--executor dask"
        security = Security(**self._tls, require_encryption=True) if self._tls else None
        place: Any = self._address
        try:
            if not place:
                with _born_without_ctrl_c():
                    own = {"host": "127.0.0.1", "dashboard_address": None, "silence_logs": logging.CRITICAL}
                    place = LocalCluster(n_workers=self._asked or available_cores(), threads_per_worker=1, **own)
                self._open = [place]
            client = Client(place, timeout=_PATIENCE, security=security, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as reason:
            raise InputError(f"{where}: no dask scheduler answers there ({type(reason).__name__}: {reason})") from reason
        self._open = [client, *self._open]
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except (OSError, TimeoutError) as reason:
            self.stop(at_once=True)
            raise InputError(f"{where}: the scheduler has no worker: start some, then start the sweep again") from reason
        threads = [int(worker["nthreads"]) for worker in client.scheduler_info(n_workers=-1)["workers"].values()]
        self.width = self._asked or max(1, sum(threads))
        self.executor = client.get_executor(pure=False)

    def stop(self, *, at_once: bool) -> None:
        while self._open:
            with suppress(OSError, TimeoutError):  # a client amid its work, a scheduler that is gone
                self._open.pop(0).close(timeout=3.0 if at_once else _PATIENCE)


def crew_of(
    executor: str = "processes",
    scheduler: str = "",
    workers: int | None = None,
    tls_ca_file: Path | None = None,
    tls_cert: Path | None = None,
    tls_key: Path | None = None,
) -> Processes | Dask:
    """Who solves the points, not started yet.

    Parameters
    ----------
    executor : "processes" of this machine, or "dask": workers of the scheduler at an address, else of a cluster started here
    scheduler : address, such as tcp://node1:8786 or tls://node1:8786
    workers : processes, or tasks at once; all cores, or all threads of the cluster, if left out
    tls_ca_file, tls_cert, tls_key : PEM files for a tls:// address, as those of `dask scheduler`

    Raises
    ------
    InputError
        For an option without the other that it needs, and a certificate that is not there.
    """
    if workers is not None and workers < 1:
        raise InputError(f"--workers {workers}: at least 1, or leave it out for all cores")
    if scheduler and executor != "dask":
        raise InputError(f"--scheduler {scheduler}: it goes with --executor dask")
    given = {"tls_ca_file": tls_ca_file, "tls_client_cert": tls_cert, "tls_client_key": tls_key}
    tls = {name: str(path) for name, path in given.items() if path is not None}
    if missing := [path for path in tls.values() if not Path(path).is_file()]:
        raise InputError(f"{missing[0]}: there is no such file; --tls-ca-file, --tls-cert and --tls-key are files in PEM form")
    if scheduler.startswith("tls://") != bool(tls) or len(tls) not in (0, len(given)):
        where = f"--scheduler {scheduler}" if scheduler else "--scheduler is left out"
        raise InputError(f"{where}: a tls:// address needs all of --tls-ca-file, --tls-cert and --tls-key, and no other takes them")
    return Dask(scheduler, workers, tls) if executor == "dask" else Processes(workers or available_cores())


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _born_without_ctrl_c() -> Generator[None, None, None]:
    """Processes that start inside never hear a Ctrl-C, which a terminal sends to all: they inherit that the signal is blocked.

    To us the block is of no use: the system hands the signal to any other thread, such as one of BLAS, and Python acts on it in
    this one. So this is done where interrupts wait.
    """
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # which lifts the block once it has started
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(parent: int) -> None:
    """In a worker: the client sees to Ctrl-C; a worker whose client is gone goes too."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=watch, daemon=True).start()


@dataclass(frozen=True)
class Prepared:
    """A study that was checked, its store, and `groups` of points without a result that share their condensed bodies."""

    study: Study
    points: tuple[Point, ...]
    store: Store
    groups: tuple[tuple[Point, ...], ...]

    @property
    def waiting(self) -> int:
        return sum(map(len, self.groups))


def prepare(study: Study | str | Path, folder: str | Path, report: Callable[[int], None] = lambda _count: None) -> Prepared:
    """Check the whole study and look at what is stored already; nothing is written. InputError for what is refused."""
    asked = validated(study, Study) if isinstance(study, Study) else load_study(study)
    store = Store(Path(folder))
    if store.folder.exists() and not store.folder.is_dir():
        raise InputError(f"--out {folder}: this is a file; results go to a folder, so name another")
    try:
        points = expand(asked, report)
    except InputError as fault:
        raise InputError(f"{'study' if isinstance(study, Study) else study}: {fault}") from fault
    groups: dict[str, list[Point]] = {}
    for point in points:
        if _final(store, point) is None:
            groups.setdefault(point.shared_bodies if "fe" in asked.engines else "", []).append(point)
    return Prepared(asked, points, store, tuple(map(tuple, groups.values())))


def _final(store: Store, point: Point) -> dict[str, Any] | None:
    """A result that stands: not one that says that a worker died, which is tried again by the next sweep."""
    result = store.read(point.address)
    return None if result is None or result.get("again", False) else result


def work(prepared: Prepared, *, report: Report = lambda _done, _total, _words: None, **workers: Any) -> pd.DataFrame:
    """Solve every point that has no result; returns the table of all. `report` gets (done, total, words) of those.

    InputError where no workers can be had, their code differs from ours, or results can't be stored.
    """
    store, points = prepared.store, prepared.points
    crew = crew_of(**workers)
    store.prepare()
    store.write_plan(json.loads(prepared.study.model_dump_json()), points)
    if prepared.groups:
        claims = Claims(store)
        try:
            # Ctrl-C amid the locks of a pool may leave one locked for ever: it waits for a round, and until the workers are gone.
            with interrupts_wait() as signals:
                crew.start()
                at_once = True
                try:
                    _Sweep(prepared, crew, claims, report, signals).go()
                    at_once = bool(signals)
                finally:
                    crew.stop(at_once=at_once)
        except KeyboardInterrupt:
            store.write_table(store.table(points))
            raise
        finally:
            claims.drop_all()
    table = store.table(points)
    store.write_table(table)
    return table


def run(
    study: Study | str | Path,
    folder: str | Path,
    *,
    report: Report = lambda _done, _total, _words: None,
    **workers: Any,
) -> pd.DataFrame:
    """Run a study into a folder, or resume an earlier run of it; returns the table.

    Called from a script, it stands under `if __name__ == "__main__":`, for the workers are processes that read the script again.
    Who solves the points is stated as to `crew_of`: run("study.toml", "out", workers=4).

    Raises
    ------
    InputError
        For a study that is refused, and where results can't be stored.
    """
    return work(prepare(study, folder), report=report, **workers)


class _Sweep:
    """The loop that hands tasks to a crew and stores what comes back; it ends early once `signals` holds one."""

    def __init__(self, prepared: Prepared, crew: Processes | Dask, claims: Claims, report: Report, signals: Sequence[int]) -> None:
        self.prepared, self.store, self.crew, self.claims = prepared, prepared.store, crew, claims
        self.report, self.signals = report, signals
        # Tasks small enough that all workers have some to do until the end.
        most = _FE_AT_ONCE if "fe" in prepared.study.engines else _EXACT_AT_ONCE
        size = max(1, min(most, -(-prepared.waiting // (4 * crew.width))))
        self.pending = deque([*group[k : k + size]] for group in prepared.groups for k in range(0, len(group), size))
        self.suspects: deque[Point] = deque()
        self.elsewhere: list[list[Point]] = []
        self.flying: dict[Future[str], list[Point]] = {}
        self.alone = False  # the one task that is handed out is a suspect
        self.looked, self.losses, self.done, self.failed = time.monotonic(), 0, 0, 0

    def go(self) -> None:
        """Work until every point has a result, or a signal asks to end."""
        while (self.pending or self.suspects or self.elsewhere or self.flying) and not self.signals:
            self._hand_out()
            if not self.flying:
                time.sleep(_ROUND if self.elsewhere else 0.0)
            finished, faults = wait(self.flying, timeout=_ROUND, return_when=FIRST_COMPLETED).done, list[BaseException]()
            for future in finished:
                fault = CancelledError() if future.cancelled() else future.exception()
                if fault is None:
                    self._keep(json.loads(future.result()), self.flying.pop(future))
                else:
                    faults.append(fault)
            whys = [self._blamed(fault) for fault in faults]
            if self.flying and self.crew.gone():
                whys.append(SCHEDULER_GONE)
            if whys:
                self._again(whys[-1])
            others = f", {sum(map(len, self.elsewhere))} done by another sweep" if self.elsewhere else ""
            flying = sum(map(len, self.flying.values()))
            self.report(self.done + self.failed, self.prepared.waiting, f"{self.failed} failed, {flying} handed out{others}")

    def _hand_out(self) -> None:
        """Keep every worker busy, and one task ready; a suspect goes alone."""
        if self.elsewhere and not self.pending and time.monotonic() - self.looked > _LOOK_AGAIN:
            self.pending.extend(self.elsewhere)
            self.elsewhere, self.looked = [], time.monotonic()
        if self.suspects and not self.flying:
            self.alone = True
            self._submit([self.suspects.popleft()])
        while self.pending and not self.suspects and not self.alone and len(self.flying) <= self.crew.width:
            self._submit(self._claimed(self.pending.popleft()))

    def _claimed(self, points: list[Point]) -> list[Point]:
        """Those that have no result and that no other sweep is at work on."""
        mine, others = [], []
        for point in points:
            if not self.claims.take(point.address):
                others.append(point)
            elif (found := _final(self.store, point)) is not None:
                self._count(point, found)
            else:
                mine.append(point)
        if others:
            self.elsewhere.append(others)
        return mine

    def _submit(self, points: list[Point]) -> None:
        if not points:
            return
        task = json.dumps({"versions": code_versions(), "points": [point.question.as_json() for point in points]})
        try:
            future = self.crew.executor.submit(solve_task, task)
        except (RuntimeError, OSError) as fault:  # a pool that broke, or a client that closed, between two tasks
            future = Future()
            future.set_exception(fault)
        self.flying[future] = points

    def _keep(self, answer: dict[str, Any], points: list[Point]) -> None:
        """Store the results of a task, with the question of each."""
        if answer["mismatch"]:
            raise InputError(
                f"{answer['mismatch']}: results of different code are not to be mixed; install the same on all workers"
            )
        self.alone = False
        for point, result in zip(points, answer["answers"], strict=True):
            asked = point.question.as_json()
            settings = {"mesh": asked["mesh"], "solver": asked["solver"]}
            about = {"address": point.address, "scene": asked["scene"], "settings": settings, "versions": code_versions()}
            self.store.write(result | about)
            self._count(point, result)

    def _count(self, point: Point, result: dict[str, Any]) -> None:
        self.claims.drop(point.address)
        self.done += result["status"] == "done"
        self.failed += result["status"] != "done"

    def _blamed(self, fault: BaseException) -> str:
        """Who is to blame for a task that did not come back; a fault of its own is raised."""
        if why := self.crew.blame(fault):
            return why
        raise fault

    def _again(self, why: str) -> None:
        """A new crew; what was handed out goes out again: after a worker's death point by point, each with nothing beside it."""
        lost = [*self.flying.values()]
        self.flying.clear()
        points = [point for task in lost for point in task]
        complain(f"sweep: {why}: {len(points)} points go out again")
        if why == SCHEDULER_GONE:
            self.losses += 1
            if self.losses > _LOSSES:
                raise InputError(f"the scheduler was lost {self.losses} times; see to it, then start the sweep again")
            self.pending.extendleft(lost)
        elif self.alone:
            reason = "the worker that solved it died twice (killed, or out of memory): see its memory, then start the sweep again"
            failed = {"status": "failed", "reason": reason, "figures": {}, "notes": {}, "record": {}, "seconds": 0.0, "host": ""}
            self._keep({"mismatch": "", "answers": [failed | {"again": True}]}, points)
        else:
            self.suspects.extend(points)
        self.alone = False
        self._renew()

    def _renew(self) -> None:
        """Workers in place of the broken ones; a scheduler is waited for, until a signal asks to end."""
        self.crew.stop(at_once=True)
        end = time.monotonic() + _RECONNECT
        while not self.signals:
            try:
                self.crew.start()
                break
            except InputError:
                if time.monotonic() > end:
                    raise
