"""Who does the work: processes of this machine, or the workers of a dask scheduler. Both are a `concurrent.futures.Executor`."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from enum import Enum
from multiprocessing import get_context, resource_tracker
from typing import Any, Protocol

from meshes.interrupts import interrupts_wait
from reports.sweep.solving import solve_task
from scenes import InputError

# For BLAS and OpenMP: on matrices of a few hundred rows more threads gain nothing, and fight for the cores of other workers.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_RECONNECT_FOR = 120.0


class Loss(Enum):
    """Why a task came back without an answer."""

    WORKER = "the worker died"
    SCHEDULER = "the scheduler is gone"


class Crew(Protocol):
    """A family of executors that can be made anew once they broke."""

    width: int
    shared_fate: bool  # whether one dead worker takes every task with it that was handed out

    def submit(self, text: str) -> Future[str]:
        """Hand out a task."""

    def loss(self, fault: BaseException) -> Loss | None:
        """What a task's exception says of its worker or scheduler; None where it is the task's own."""

    def broken(self) -> bool:
        """Whether tasks handed out will never come back, though no exception says so."""

    def renew(self, signals: Sequence[int] = (), /) -> None:
        """Take new workers in place of the broken ones; the tasks handed out are lost. Not waited for once `signals` holds one."""

    def dismiss(self, at_once: bool = False) -> None:
        """Let the workers go; at once: in the midst of their work."""


class Processes:
    """Processes of this machine, one BLAS thread each."""

    shared_fate = True

    def __init__(self, width: int) -> None:
        self.width = width
        self._executor = self._hired()

    def _hired(self) -> ProcessPoolExecutor:
        with _deaf_to_ctrl_c():
            return self._started()

    def _started(self) -> ProcessPoolExecutor:
        before = {name: os.environ.get(name) for name in _ONE_THREAD}
        os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
        try:
            executor = ProcessPoolExecutor(self.width, mp_context=get_context("spawn"), initializer=_begin, initargs=(os.getpid(),))
            # All of them start now, while the variables stand.
            for _ in range(self.width):
                executor.submit(_nothing)
            return executor
        finally:
            for name, value in before.items():
                os.environ.pop(name, None) if value is None else os.environ.update({name: value})

    def submit(self, text: str) -> Future[str]:
        return self._executor.submit(solve_task, text)

    def loss(self, fault: BaseException) -> Loss | None:
        return Loss.WORKER if isinstance(fault, BrokenExecutor | CancelledError) else None

    def broken(self) -> bool:
        return False

    def renew(self, _signals: Sequence[int] = (), /) -> None:
        self.dismiss(at_once=True)
        self._executor = self._hired()

    def dismiss(self, at_once: bool = False) -> None:
        # The one way to stop a process in mid-task; `terminate_workers` comes with Python 3.14.
        workers = dict(getattr(self._executor, "_processes", None) or {})
        self._executor.shutdown(wait=not at_once, cancel_futures=True)
        if at_once:
            for worker in workers.values():
                worker.kill()
            for worker in workers.values():
                worker.join()


class Dask:
    """The workers of a dask scheduler at an address."""

    shared_fate = False

    def __init__(self, address: str, width: int | None = None, patience: float = 10.0) -> None:
        self._address = address
        self._asked = width
        self._connect(patience)

    def _connect(self, patience: float) -> None:
        client_class = _client_class()
        # What it loses we say in our own words, once; its tracebacks tell nothing more.
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
        try:
            self._client = client_class(self._address, timeout=patience, set_as_default=False)
        except (OSError, TimeoutError) as reason:
            raise InputError(f"--scheduler {self._address}: no dask scheduler answers there ({type(reason).__name__})") from reason
        try:
            self._client.wait_for_workers(1, timeout=patience)
        except (OSError, TimeoutError) as reason:
            self._client.close(timeout=1.0)
            raise InputError(
                f"--scheduler {self._address}: the scheduler has no worker: start some, then go on with --resume"
            ) from reason
        threads = [int(worker["nthreads"]) for worker in self._client.scheduler_info(n_workers=-1)["workers"].values()]
        self.width = self._asked or max(1, sum(threads))
        self._executor: Executor = self._client.get_executor(pure=False)

    def submit(self, text: str) -> Future[str]:
        return self._executor.submit(solve_task, text)

    def loss(self, fault: BaseException) -> Loss | None:
        from distributed import KilledWorker
        from distributed.comm.core import CommClosedError

        if isinstance(fault, KilledWorker):
            return Loss.WORKER
        return Loss.SCHEDULER if isinstance(fault, CancelledError | CommClosedError | TimeoutError | OSError) else None

    def broken(self) -> bool:
        return str(self._client.status) != "running"

    def renew(self, signals: Sequence[int] = (), /) -> None:
        if not self.broken():
            return
        self.dismiss(at_once=True)
        end = time.monotonic() + _RECONNECT_FOR
        while not signals:
            try:
                self._connect(5.0)
                return
            except InputError:
                if time.monotonic() > end:
                    raise

    def dismiss(self, at_once: bool = False) -> None:
        self._executor.shutdown(wait=False)  # dask's own cancels what is not begun
        self._client.close(timeout=1.0 if at_once else 10.0)


def _client_class() -> Any:
    try:
        from distributed import Client
    except ImportError as reason:
        raise InputError("--executor dask: the package distributed is not installed: pip install 'halfplane[cluster]'") from reason
    return Client


def crew_of(executor: str, scheduler: str, workers: int | None) -> Callable[[], Crew]:
    """What makes the crew that is asked for.

    Raises
    ------
    InputError
        For an option without the other that it needs.
    """
    if workers is not None and workers < 1:
        raise InputError(f"--workers {workers}: at least 1, or leave it out for all cores")
    if executor == "dask":
        if not scheduler:
            raise InputError("--executor dask: it needs --scheduler ADDRESS, such as tcp://node1:8786")
        return lambda: Dask(scheduler, workers)
    if scheduler:
        raise InputError(f"--scheduler {scheduler}: it goes with --executor dask")
    return lambda: Processes(workers or available_cores())


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _deaf_to_ctrl_c() -> Generator[None, None, None]:
    """Processes that start inside never hear a Ctrl-C, from their birth on; we hear it at the end. A terminal sends it to all.

    They inherit that the signal is blocked. To us the block is of no use: the system hands the signal to any other thread, such as
    one of BLAS, and Python acts on it in this one.
    """
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # which lifts the block once it has started
    with interrupts_wait():
        before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _nothing() -> None:
    """Makes a worker start."""


def _begin(parent: int) -> None:
    """In a worker: the client sees to Ctrl-C; a worker whose client is gone goes too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)
