"""A whole sweep: the study checked, tasks handed to processes or to a dask cluster, results stored,
the table returned.

Where a process of the pool dies, a new pool solves the other points, and the sweep ends with a
sentence that names those that were lost with it; dask hands them out again by itself. A scheduler
that is gone ends the sweep. The next run solves what has no result.
"""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context, parent_process, resource_tracker
from pathlib import Path
from typing import Any

import pandas as pd

from meshes.interrupts import interrupts_wait
from reports.console import complain
from reports.studies.sweep.solving import code_versions, solve_task
from reports.studies.sweep.store import Store
from reports.studies.sweep.study import Point, Study, described, expand, load_study
from scenes import InputError
from scenes.frozen import validated

Report = Callable[[int, int, str], None]
Task = list[Point]
# Half-plane theory alone takes some milliseconds a point: that many at once make the cost of
# handing them out small.
_EXACT_AT_ONCE = 50
_FE_AT_ONCE = 4
_ROUND = 0.5  # of the loop [s]
_PATIENCE = 10.0  # largest wait for a scheduler's first answer [s]
# Pools that may break one after the other without a result: the next one would too.
_MOST_BROKEN = 3
# Lost points that a sentence names.
_NAMED = 4


# Of a cluster started here: its web servers, which know no TLS, answer nothing but "404".
_NO_ROUTES: dict[str, list[str]] = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}


class Processes:
    """Processes of this machine. `died` of these and of `Dask`: whether an exception of a task
    means that its worker died.
    """

    executor: Executor

    def __init__(self, width: int) -> None:
        self.width = width

    def died(self, fault: BaseException) -> bool:
        return isinstance(fault, BrokenExecutor | CancelledError)

    def require_alive(self) -> None:
        """InputError where tasks will never come back: not of these."""

    def start(self) -> None:
        """Start all processes now."""
        with _born_without_ctrl_c():
            self.executor = ProcessPoolExecutor(
                self.width, mp_context=get_context("spawn"), initializer=_begin
            )
            for _ in range(self.width):  # all of them start now
                self.executor.submit(os.getpid)

    def stop(self, *, at_once: bool) -> None:
        # The one way to stop a process in mid-task; `terminate_workers` comes with Python 3.14.
        """End the processes: after their tasks, or in mid-task with `at_once`."""
        workers = dict(getattr(self.executor, "_processes", None) or {})
        self.executor.shutdown(wait=not at_once, cancel_futures=True)
        if at_once:
            for worker in workers.values():
                worker.kill()
            for worker in workers.values():
                worker.join()


class Dask:
    """The workers of a dask scheduler: at an address, or of a cluster started here on the loopback
    interface.

    A task whose worker died goes to others by dask itself, as often as its setting
    `allowed-failures` states.
    """

    executor: Executor
    width: int

    def __init__(self, address: str, width: int | None) -> None:
        self._address = address
        self._requested_width = width
        self._where = f"--scheduler {address}" if address else "--executor dask"
        self._open: list[Any] = []  # the client, then the cluster if it is ours

    def died(self, fault: BaseException) -> bool:
        """Whether the exception that a task ended with means that its worker process died.
        InputError where it means that the dask scheduler is gone.
        """
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        if isinstance(fault, CancelledError | CommClosedError | TimeoutError | OSError):
            raise InputError(
                f"{self._where}: the scheduler is gone; see to it, then start the sweep again:"
                " results are kept"
            )
        return isinstance(fault, KilledWorker)

    def require_alive(self) -> None:
        if str(self._open[0].status) != "running":
            self.died(CancelledError())

    def start(self) -> None:
        """Connect to the dask scheduler, or start a cluster on this machine; InputError where none
        answers or it has no workers.
        """
        try:
            from dask.config import set as set_dask
            from distributed import Client, LocalCluster
        except ImportError as reason:
            words_of_cure = "pip install 'halfplane[cluster]'"
            raise InputError(
                f"--executor dask: the package distributed is not installed: {words_of_cure}"
            ) from reason
        # What it loses we say in our own words, once; its tracebacks add nothing.
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        security = None  # of an address what the user's configuration of dask states
        scheduler: Any = self._address
        try:
            if not scheduler:
                security = _temporary_security()
                with _born_without_ctrl_c(), set_dask(_NO_ROUTES):
                    scheduler = LocalCluster(
                        n_workers=self._requested_width or _available_cores(),
                        threads_per_worker=1,
                        host="127.0.0.1",
                        security=security,
                        dashboard_address="127.0.0.1:0",
                        scheduler_kwargs={"dashboard": False},
                        silence_logs=logging.CRITICAL,
                    )
                self._open = [scheduler]
            client = Client(scheduler, timeout=_PATIENCE, security=security, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as reason:
            raise InputError(
                f"{self._where}: no dask scheduler answers there ({type(reason).__name__}:"
                f" {reason})"
            ) from reason
        self._open = [client, *self._open]
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except (OSError, TimeoutError) as reason:
            self.stop(at_once=True)
            raise InputError(
                f"{self._where}: the scheduler has no worker: start some, then start the sweep"
                " again"
            ) from reason
        threads = [
            int(worker["nthreads"])
            for worker in client.scheduler_info(n_workers=-1)["workers"].values()
        ]
        self.width = self._requested_width or max(1, sum(threads))
        self.executor = client.get_executor(pure=False)

    def stop(self, *, at_once: bool) -> None:
        """Close the client, and the cluster that was started here; quickly with `at_once`."""
        while self._open:
            # a client amid its work, a scheduler that is gone
            with suppress(OSError, TimeoutError):
                self._open.pop(0).close(timeout=3.0 if at_once else _PATIENCE)


def _temporary_security() -> Any:
    """TLS of a dask cluster started here: a key and a certificate in memory, so that no other user
    of the machine gets a task in.

    Raises
    ------
    InputError
        Without the package that makes them.
    """
    from distributed import Security

    try:
        return Security.temporary()
    except ImportError as reason:
        words_of_cure = "pip install 'halfplane[cluster]'"
        raise InputError(
            f"--executor dask: the package cryptography is not installed, for TLS: {words_of_cure}"
        ) from reason


def workers_of(
    executor: str = "processes",
    scheduler: str = "",
    workers: int | None = None,
) -> Processes | Dask:
    """The workers that solve the points of a sweep, not started yet.

    Parameters
    ----------
    executor
        "processes" of this machine, or "dask": workers of the scheduler at an address, else of
        a cluster started here
    scheduler
        address, such as tcp://node1:8786, or tls://node1:8786 with the certificates of dask's
        own configuration
    workers
        processes, or tasks at once; all cores, or all threads of the cluster, if left out

    Raises
    ------
    InputError
        For an option without the other that it needs.
    """
    if workers is not None and workers < 1:
        raise InputError(f"--workers {workers}: at least 1, or leave it out for all cores")
    if scheduler and executor != "dask":
        raise InputError(f"--scheduler {scheduler}: it goes with --executor dask")
    if executor == "dask":
        return Dask(scheduler, workers)
    return Processes(workers or _available_cores())


def _available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _born_without_ctrl_c() -> Generator[None, None, None]:
    """Block Ctrl-C (SIGINT) within this context, so that worker processes started in it inherit the
    block: a terminal sends Ctrl-C to all processes, and only this one shall act on it.

    The block does not keep this process itself from a Ctrl-C: the system hands the signal to any
    other thread, such as one of BLAS, and Python acts on it in this one. The context is therefore
    used only where interrupts are already held back.
    """
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # which lifts the block once it has started
    mask_before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask_before)


def _begin() -> None:
    """In a worker: the client sees to Ctrl-C; a worker whose client is gone goes too."""

    def watch() -> None:
        if (client := parent_process()) is not None:
            client.join()
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=watch, daemon=True).start()


@dataclass(frozen=True)
class Prepared:
    """A study that was checked, its store, and the points without a result."""

    study: Study
    points: tuple[Point, ...]
    store: Store
    waiting_points: tuple[Point, ...]


def prepare(
    study: Study | str | Path,
    folder: str | Path,
    report: Callable[[int], None] = lambda _count: None,
) -> Prepared:
    """Check all points of a study, and find out which of them have no stored result yet. Nothing is
    solved or written.

    Parameters
    ----------
    study
        a `Study`, or the name of its file
    folder
        where results are stored
    report
        called with the number of points checked so far

    Raises
    ------
    InputError
        For a study or a point of it that is refused, and where `folder` is a file.
    """
    checked_study = validated(study, Study) if isinstance(study, Study) else load_study(study)
    store = Store(Path(folder))
    if store.folder.exists() and not store.folder.is_dir():
        raise InputError(f"--out {folder}: this is a file; results go to a folder, so name another")
    try:
        points = expand(checked_study, report)
    except InputError as fault:
        raise InputError(f"{'study' if isinstance(study, Study) else study}: {fault}") from fault
    waiting_points = tuple(point for point in points if store.read(point.address) is None)
    return Prepared(checked_study, points, store, waiting_points)


def work(
    prepared: Prepared, *, report: Report = lambda _count, _total, _words: None, **workers: Any
) -> pd.DataFrame:
    """Solve every point of a sweep that has no stored result; returns the table of all results.

    Parameters
    ----------
    prepared
        the checked study with its points and its store
    report
        called with (points done, how many there are to do, text)
    workers
        who solves the points: the parameters of `workers_of`

    Raises
    ------
    InputError
        Where no workers can be had, their code differs from ours, results can't be stored, or a
        process died with points.
    """
    store = prepared.store
    points = prepared.points
    pool = workers_of(**workers)
    store.prepare()
    store.write_plan(json.loads(prepared.study.model_dump_json()), points)
    sweep = _Sweep(prepared, pool, report)
    if prepared.waiting_points:
        try:
            # Ctrl-C amid the locks of a pool may leave one locked for ever: it waits for a round,
            # and until the workers are gone.
            with interrupts_wait() as signals:
                sweep.go(signals)
        except KeyboardInterrupt:
            store.write_table(store.table(points))
            raise
    table = store.table(points)
    store.write_table(table)
    if sweep.lost:
        raise InputError(sweep.losses())
    return table


def run(
    study: Study | str | Path,
    folder: str | Path,
    *,
    report: Report = lambda _count, _total, _words: None,
    **workers: Any,
) -> pd.DataFrame:
    """Run a study into a folder, or resume an earlier run of it; returns the table of results.

    Called from a script, it stands under `if __name__ == "__main__":`, for the workers are
    processes that read the script again. Who solves the points is stated as to `workers_of`:
    run("study.toml", "out", workers=4).

    Raises
    ------
    InputError
        For a study that is refused, where results can't be stored, and where a worker died: all
        other points are stored then.
    """
    return work(prepare(study, folder), report=report, **workers)


def tasks_of(prepared: Prepared, width: int) -> deque[Task]:
    """Points in the portions in which they are handed out: small enough that all of `width` workers
    have some until the end.
    """
    points_at_once = _FE_AT_ONCE if "fe" in prepared.study.engines else _EXACT_AT_ONCE
    size = max(1, min(points_at_once, -(-len(prepared.waiting_points) // (4 * width))))
    return deque(
        [*prepared.waiting_points[k : k + size]]
        for k in range(0, len(prepared.waiting_points), size)
    )


@dataclass
class _Sweep:
    """Hands tasks to a pool and stores what comes back.

    Attributes
    ----------
    lost
        points that were with a process that died
    """

    prepared: Prepared
    pool: Processes | Dask
    report: Report
    solved: int = 0
    failed: int = 0
    lost: list[Point] = field(default_factory=list)
    broken: int = 0  # pools, since the last result

    def go(self, signals: Sequence[int]) -> None:
        """Work until every point has a result or is lost; end early once `signals` holds one."""
        self.pool.start()
        at_once = True
        try:
            self._hand_out(tasks_of(self.prepared, self.pool.width), signals)
            at_once = bool(signals)
        finally:
            self.pool.stop(at_once=at_once)

    def losses(self) -> str:
        """The sentence about the points that were lost."""
        names = "; ".join(described(point.coordinates) for point in self.lost[:_NAMED])
        if len(self.lost) > _NAMED:
            names += f" and {len(self.lost) - _NAMED} more"
        return (
            f"{self.prepared.store.folder}: a worker died (killed, or out of memory); points"
            f" without a result: {names}; all others are stored. Start the sweep again, with"
            " fewer --workers where memory was short"
        )

    def _hand_out(self, tasks: deque[Task], signals: Sequence[int]) -> None:
        """Give the tasks to the workers and store their answers, until no task is left or a signal
        has come.

        Every worker has a task, and one more waits. A task is a group of points; a signal is that
        of Ctrl-C or of the system to end.
        """
        task_of: dict[Future[str], Task] = {}  # those with the workers
        while (tasks or task_of) and not signals:
            while tasks and len(task_of) <= self.pool.width:
                questions = [point.question.as_json() for point in tasks[0]]
                task_text = json.dumps({"versions": code_versions(), "points": questions})
                task_of[self._submitted(task_text)] = tasks.popleft()
            for future in wait(task_of, timeout=_ROUND, return_when=FIRST_COMPLETED).done:
                self._take(future, task_of.pop(future))
            if task_of:
                self.pool.require_alive()
            n_handed_out = sum(map(len, task_of.values()))
            progress_in_words = f"{self.failed} failed, {n_handed_out} handed out"
            if self.lost:
                progress_in_words += f", {len(self.lost)} lost with a worker"
            self.report(
                self.solved + self.failed, len(self.prepared.waiting_points), progress_in_words
            )

    def _submitted(self, task: str) -> Future[str]:
        """Give a task to the pool of workers, or to a new pool where that is broken; returns the
        future of its answer.
        """
        while True:
            try:
                return self.pool.executor.submit(solve_task, task)
            except Exception as fault:
                if not self.pool.died(fault):
                    raise
                self.broken += 1
                if self.broken > _MOST_BROKEN:
                    raise InputError(
                        f"{self.prepared.store.folder}: {self.broken} pools of workers died one"
                        " after the other without a result; a script that runs a sweep does it"
                        " under `if __name__ == '__main__':`"
                    ) from fault
                self.pool.stop(at_once=True)
                self.pool.start()

    def _take(self, future: Future[str], points: Task) -> None:
        """Store the answers of a task's points when its `future` is done. Where its worker process
        died, the points are noted as lost. InputError where the worker has other versions of the
        code.
        """
        try:
            answer = json.loads(future.result())
        except Exception as fault:
            if not self.pool.died(fault):
                raise
            complain(f"sweep: a worker died; points that it had: {len(points)}")
            self.lost += points
            return
        if answer["mismatch"]:
            cure = "results of different code are not to be mixed; install the same on all workers"
            raise InputError(f"{answer['mismatch']}: {cure}")
        self.broken = 0
        for point, content in zip(points, answer["answers"], strict=True):
            self._store(point, content)

    def _store(self, point: Point, answer: dict[str, Any]) -> None:
        """Store the answer of a point, with the question and the versions that it belongs to."""
        question = point.question.as_json()
        settings = {"mesh": question["mesh"], "solver": question["solver"]}
        origin = {
            "address": point.address,
            "scene": question["scene"],
            "settings": settings,
            "versions": code_versions(),
        }
        self.prepared.store.write(answer | origin)
        self.solved += answer["status"] == "done"
        self.failed += answer["status"] != "done"
