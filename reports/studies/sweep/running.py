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
from reports.studies.sweep.study import (
    Point,
    Study,
    coordinates_in_words,
    load_study,
    points_of_study,
)
from scenes import InputError
from scenes.frozen import validated

ProgressReport = Callable[[int, int, str], None]  # points done, how many there are to do, text
Task = list[Point]  # points that are handed out together
# Half-plane theory alone takes some milliseconds a point: that many at once make the cost of
# handing them out small.
_EXACT_AT_ONCE = 50
_FE_AT_ONCE = 4
_ROUND_SECONDS = 0.5  # a round of the loop that waits for answers
_LONGEST_WAIT = 10.0  # largest wait for a scheduler's first answer [s]
# Pools that may break one after the other without a result: the next one would too.
_MOST_BROKEN_POOLS = 3
# Lost points that a sentence names.
_MOST_NAMED_POINTS = 4


# Of a cluster started here: its web servers, which know no TLS, answer nothing but "404".
_NO_ROUTES: dict[str, list[str]] = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}


class Processes:
    """Worker processes of this machine, so many as `width`; the same methods as `Dask`."""

    executor: Executor

    def __init__(self, width: int) -> None:
        self.width = width

    def is_worker_death(self, fault: BaseException) -> bool:
        """Whether the exception that a task ended with means that its worker process died."""
        return isinstance(fault, BrokenExecutor | CancelledError)

    def require_alive(self) -> None:
        """InputError where the workers are gone, so that tasks will never come back. Processes of
        this machine are never gone without an exception of their own.
        """

    def start(self) -> None:
        """Start all processes now."""
        with _ctrl_c_blocked():
            self.executor = ProcessPoolExecutor(
                self.width, mp_context=get_context("spawn"), initializer=_set_up_worker
            )
            for _ in range(self.width):  # all of them start now
                self.executor.submit(os.getpid)

    def stop(self, *, at_once: bool) -> None:
        """End the worker processes: after their tasks, or in mid-task with `at_once`."""
        # The one way to stop a process in mid-task; `terminate_workers` comes with Python 3.14.
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
        self._option = f"--scheduler {address}" if address else "--executor dask"
        # what is to be closed at the end: the client, then the cluster if it is ours
        self._connections: list[Any] = []

    def is_worker_death(self, fault: BaseException) -> bool:
        """Whether `fault`, the exception that a task ended with, means that its worker process
        died. InputError, naming the user's option, where it means that the dask scheduler is gone.
        """
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        if isinstance(fault, CancelledError | CommClosedError | TimeoutError | OSError):
            raise InputError(
                f"{self._option}: the scheduler is gone; see to it, then start the sweep again:"
                " results are kept"
            )
        return isinstance(fault, KilledWorker)

    def require_alive(self) -> None:
        """InputError where the dask scheduler is gone, so that tasks will never come back."""
        if str(self._connections[0].status) != "running":
            self.is_worker_death(CancelledError())

    def start(self) -> None:
        """Connect to the dask scheduler, or start a cluster on this machine; InputError where no
        scheduler answers or it has no workers.

        `_option` is the user's option, for messages. `_address` is that of the scheduler, "" for a
        cluster of one's own; `_requested_width` is how many tasks are worked on at once, None for
        all cores or threads. Afterwards `executor` takes tasks, `width` is their number at once,
        and `_connections` are to be closed at the end: the client, and the cluster.
        """
        try:
            from dask.config import set as set_dask
            from distributed import Client, LocalCluster
        except ImportError as reason:
            cure = "pip install 'halfplane[cluster]'"
            raise InputError(
                f"--executor dask: the package distributed is not installed: {cure}"
            ) from reason
        # dask's log is silenced: a loss of workers is reported in one sentence instead
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)

        # a scheduler: that of the address, else a cluster on the loopback interface, without web
        # pages (_NO_ROUTES); _LONGEST_WAIT: 10 s
        security = None  # for an address: as the user's configuration of dask states
        scheduler: Any = self._address
        try:
            if not scheduler:
                security = _temporary_security()
                with _ctrl_c_blocked(), set_dask(_NO_ROUTES):
                    scheduler = LocalCluster(
                        n_workers=self._requested_width or _available_cores(),
                        threads_per_worker=1,
                        host="127.0.0.1",
                        security=security,
                        dashboard_address="127.0.0.1:0",
                        scheduler_kwargs={"dashboard": False},
                        silence_logs=logging.CRITICAL,
                    )
                self._connections = [scheduler]
            client = Client(
                scheduler, timeout=_LONGEST_WAIT, security=security, set_as_default=False
            )
        except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as reason:
            raise InputError(
                f"{self._option}: no dask scheduler answers there ({type(reason).__name__}:"
                f" {reason})"
            ) from reason
        self._connections = [client, *self._connections]

        # workers, with the number of their threads
        try:
            client.wait_for_workers(1, timeout=_LONGEST_WAIT)
        except (OSError, TimeoutError) as reason:
            self.stop(at_once=True)
            raise InputError(
                f"{self._option}: the scheduler has no worker: start some, then start the sweep"
                " again"
            ) from reason
        threads_of_workers = [
            int(worker["nthreads"])
            for worker in client.scheduler_info(n_workers=-1)["workers"].values()
        ]
        self.width = self._requested_width or max(1, sum(threads_of_workers))
        self.executor = client.get_executor(pure=False)

    def stop(self, *, at_once: bool) -> None:
        """Close the client, and the cluster that was started here; quickly with `at_once`."""
        while self._connections:
            # a client amid its work, a scheduler that is gone
            with suppress(OSError, TimeoutError):
                self._connections.pop(0).close(timeout=3.0 if at_once else _LONGEST_WAIT)


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
        cure = "pip install 'halfplane[cluster]'"
        raise InputError(
            f"--executor dask: the package cryptography is not installed, for TLS: {cure}"
        ) from reason


def worker_pool(
    executor: str = "processes",
    scheduler: str = "",
    workers: int | None = None,
) -> Processes | Dask:
    """The workers that solve the points of a sweep, as an object that can start and stop them. They
    are not started yet.

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
def _ctrl_c_blocked() -> Generator[None, None, None]:
    """Block Ctrl-C (SIGINT) within this context, so that worker processes started in it inherit the
    block: a terminal sends Ctrl-C to all processes, and only this one shall act on it. On Windows
    nothing is blocked.

    The block does not keep this process itself from a Ctrl-C: the system hands the signal to any
    other thread, such as one of BLAS (a library of linear algebra), and Python acts on it in the
    main thread. The context is therefore used only where interrupts are already held back.
    """
    if sys.platform == "win32":
        yield
        return
    # A helper process of Python's own: starting it lifts the block, so it is started before.
    resource_tracker.ensure_running()
    mask_before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask_before)


def _set_up_worker() -> None:
    """Prepare a worker process: it ignores Ctrl-C, which the process that started it acts on, and
    ends when that process ends.
    """

    def watch() -> None:
        """Wait for the end of the process that started this one, then end."""
        if (client := parent_process()) is not None:
            client.join()
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=watch, daemon=True).start()


@dataclass(frozen=True)
class PreparedSweep:
    """A checked study with all its points and its store; `waiting_points` are those that have no
    stored result.
    """

    study: Study
    points: tuple[Point, ...]
    store: Store
    waiting_points: tuple[Point, ...]


def prepare(
    study: Study | str | Path,
    folder: str | Path,
    report: Callable[[int], None] = lambda _count: None,
) -> PreparedSweep:
    """Check all points of a study, and find out which of them have no stored result yet. Nothing is
    solved or written; a damaged result is renamed.

    Parameters
    ----------
    study
        a scene with axes over its keys, as a `Study`, or the name of its file
    folder
        where results are stored
    report
        called with the number of points checked so far

    Returns
    -------
    PreparedSweep
        the study, all its points, the store of results, and the points without a result

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
        points = points_of_study(checked_study, report)
    except InputError as fault:
        raise InputError(f"{'study' if isinstance(study, Study) else study}: {fault}") from fault
    # address: name of a stored result, a hash of all that it depends on
    waiting_points = tuple(point for point in points if store.read(point.address) is None)
    return PreparedSweep(checked_study, points, store, waiting_points)


def solve_waiting_points(
    sweep: PreparedSweep,
    *,
    report: ProgressReport = lambda _count, _total, _words: None,
    **workers: Any,
) -> pd.DataFrame:
    """Solve every point of a sweep that has no stored result; returns the table of all results.

    Parameters
    ----------
    sweep
        the checked study with its points, those without a result (`waiting_points`), and the store
        of results
    report
        called with (points done, how many there are to do, text)
    workers
        who solves the points: `executor` ("processes" or "dask"), `scheduler` (address) and
        `workers` (how many)

    Raises
    ------
    InputError
        Where no workers can be had, their code differs from that of this process, results can't be
        stored, or a worker process died while it solved points.
    """
    store = sweep.store
    points = sweep.points
    pool = worker_pool(**workers)  # not started yet
    store.prepare()
    store.write_plan(json.loads(sweep.study.model_dump_json()), points)
    run_of_tasks = _RunOfTasks(sweep, pool, report)

    # hand points out and store results; after Ctrl-C the table has those that there are
    if sweep.waiting_points:
        try:
            # Ctrl-C amid the locks of a pool may leave one locked for ever: it is held back until
            # the workers are gone. `signals` gets the signals that came meanwhile.
            with interrupts_wait() as signals:
                run_of_tasks.solve_points(signals)
        except KeyboardInterrupt:
            store.write_table(store.table(points))
            raise

    table = store.table(points)
    store.write_table(table)
    if run_of_tasks.lost_points:
        raise InputError(run_of_tasks.loss_message())
    return table


def run(
    study: Study | str | Path,
    folder: str | Path,
    *,
    report: ProgressReport = lambda _count, _total, _words: None,
    **workers: Any,
) -> pd.DataFrame:
    """Run a study, or resume an earlier run of it; returns the table of results. `study` is a scene
    with axes over its keys, or the name of its file; results are stored in `folder`.

    Called from a script, it stands under `if __name__ == "__main__":`, for the workers are
    processes that read the script again. Further arguments state who solves the points: `executor`
    ("processes" or "dask"), `scheduler` (its address) and `workers` (how many), as in
    run("study.toml", "out", workers=4). `report` is called with (points done, how many there are to
    do, text).

    Raises
    ------
    InputError
        For a study that is refused, where results can't be stored, and where a worker died: all
        other points are stored then.
    """
    return solve_waiting_points(prepare(study, folder), report=report, **workers)


def tasks_of(sweep: PreparedSweep, n_workers: int) -> deque[Task]:
    """The points of a sweep that wait for a result, in tasks, the groups in which they are handed
    out: small enough that all workers have some until the end.
    """
    # _FE_AT_ONCE, _EXACT_AT_ONCE: 4 and 50 points
    points_at_once = _FE_AT_ONCE if "fe" in sweep.study.engines else _EXACT_AT_ONCE
    n_waiting_points = len(sweep.waiting_points)
    # of at most 4 points with finite elements, 50 without; about four tasks for each worker
    task_size = max(1, min(points_at_once, -(-n_waiting_points // (4 * n_workers))))
    return deque(
        [*sweep.waiting_points[start : start + task_size]]
        for start in range(0, n_waiting_points, task_size)
    )


@dataclass
class _RunOfTasks:
    """Hands the tasks of a sweep to a pool of workers and stores their answers.

    Attributes
    ----------
    report
        called with (points done, how many there are to do, text)
    n_solved, n_failed
        points with an answer: solved, and failed with a reason
    lost_points
        points that were with a process that died
    n_broken_pools
        pools that died one after the other since the last answer
    """

    sweep: PreparedSweep
    pool: Processes | Dask
    report: ProgressReport
    n_solved: int = 0
    n_failed: int = 0
    lost_points: list[Point] = field(default_factory=list)
    n_broken_pools: int = 0

    def solve_points(self, signals: Sequence[int]) -> None:
        """Work until every point of the sweep has a result or is lost with a worker that died; end
        early once `signals`, which gets signals such as that of Ctrl-C, holds one.
        """
        self.pool.start()
        at_once = True  # whether the workers are stopped in mid-task
        try:
            self._hand_out(tasks_of(self.sweep, self.pool.width), signals)
            at_once = bool(signals)
        finally:
            self.pool.stop(at_once=at_once)

    def loss_message(self) -> str:
        """The sentence about the points that were lost with a worker that died; the first four are
        named by their coordinates.
        """
        names = "; ".join(
            coordinates_in_words(point.coordinates)
            for point in self.lost_points[:_MOST_NAMED_POINTS]
        )
        if len(self.lost_points) > _MOST_NAMED_POINTS:
            names += f" and {len(self.lost_points) - _MOST_NAMED_POINTS} more"
        return (
            f"{self.sweep.store.folder}: a worker died (killed, or out of memory); points"
            f" without a result: {names}; all others are stored. Start the sweep again, with"
            " fewer --workers where memory was short"
        )

    def _hand_out(self, tasks: deque[Task], signals: Sequence[int]) -> None:
        """Give the tasks to the workers and store their answers, until no task is left or a signal
        has come.

        Every worker has a task, and one more waits. A task is a group of points. `signals` gets the
        signal of Ctrl-C, or of the system to end. `pool.width` is how many tasks are worked on at
        once.
        """
        # tasks handed out, by the future of their answer
        task_by_future: dict[Future[str], Task] = {}
        while (tasks or task_by_future) and not signals:
            # hand out, as JSON text
            while tasks and len(task_by_future) <= self.pool.width:
                questions = [point.question.as_json() for point in tasks[0]]
                task_text = json.dumps({"versions": code_versions(), "points": questions})
                future = self._submit(task_text)
                task_by_future[future] = tasks.popleft()

            # store what has come; _ROUND_SECONDS: 0.5 s
            for future in wait(
                task_by_future, timeout=_ROUND_SECONDS, return_when=FIRST_COMPLETED
            ).done:
                self._store_answers(future, task_by_future.pop(future))
            if task_by_future:
                self.pool.require_alive()  # InputError where tasks will never come back

            # report the progress
            n_handed_out = sum(map(len, task_by_future.values()))
            progress_in_words = f"{self.n_failed} failed, {n_handed_out} handed out"
            if self.lost_points:
                progress_in_words += f", {len(self.lost_points)} lost with a worker"
            n_done = self.n_solved + self.n_failed
            self.report(n_done, len(self.sweep.waiting_points), progress_in_words)

    def _submit(self, task_text: str) -> Future[str]:
        """Give a task, as JSON text, to the pool of workers, one of which solves it; where the pool
        is broken, to a new one. Returns the future of its answer.

        InputError where more than three pools (`_MOST_BROKEN_POOLS`) died one after the other
        without an answer; `n_broken_pools` counts them since the last answer.
        """
        while True:
            try:
                return self.pool.executor.submit(solve_task, task_text)
            except Exception as fault:
                if not self.pool.is_worker_death(fault):
                    raise
                self.n_broken_pools += 1
                if self.n_broken_pools > _MOST_BROKEN_POOLS:
                    raise InputError(
                        f"{self.sweep.store.folder}: {self.n_broken_pools} pools of workers died"
                        " one after the other without a result; a script that runs a sweep does it"
                        " under `if __name__ == '__main__':`"
                    ) from fault
                self.pool.stop(at_once=True)
                self.pool.start()

    def _store_answers(self, future: Future[str], points: Task) -> None:
        """Store the answers of a task, whose `future` is done, one for each of its `points`. Where
        its worker process died, the points are noted as lost. InputError where the worker has other
        versions of the code.
        """
        try:
            # {"mismatch": sentence on versions that differ or "", "answers": one for each point}
            answer_of_task = json.loads(future.result())
        except Exception as fault:
            if not self.pool.is_worker_death(fault):
                raise
            # on stderr
            complain(f"sweep: a worker died; points that it had: {len(points)}")
            self.lost_points += points
            return

        if answer_of_task["mismatch"]:
            cure = "results of different code are not to be mixed; install the same on all workers"
            raise InputError(f"{answer_of_task['mismatch']}: {cure}")
        self.n_broken_pools = 0  # pools that died since the last answer
        for point, answer_of_point in zip(points, answer_of_task["answers"], strict=True):
            self._store_answer(point, answer_of_point)

    def _store_answer(self, point: Point, answer: dict[str, Any]) -> None:
        """Store the answer of a point with its origin: scene, settings and versions of the code.
        Count the point as solved or failed, by the answer's "status".
        """
        question = point.question.as_json()
        settings = {"mesh": question["mesh"], "solver": question["solver"]}
        origin = {
            "address": point.address,
            "scene": question["scene"],
            "settings": settings,
            "versions": code_versions(),
        }
        self.sweep.store.write(answer | origin)
        self.n_solved += answer["status"] == "done"
        self.n_failed += answer["status"] != "done"
