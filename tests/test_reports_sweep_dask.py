"""A sweep on a dask cluster whose scheduler is killed and comes back: no point lost, none twice, no wrong number."""

import importlib.util
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from reports.sweep.crews import crew_of
from scenes import InputError
from test_cli_commands import environment
from test_reports_sweep_processes import finish, folder, results, same, start, until

__all__ = ["folder"]  # a fixture: imported to be found
needs_dask = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None, reason="distributed is not installed: halfplane[cluster]"
)


class Cluster:
    """`dask scheduler` and two `dask worker`, as a batch system would keep them."""

    def __init__(self, home: Path) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
        self.home = home
        self.scheduler = self.begin("dask_scheduler", "--host", "127.0.0.1", "--port", self.address.rsplit(":", 1)[1])
        self.workers = [self.worker() for _ in range(2)]

    def begin(self, program: str, *arguments: str) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", f"distributed.cli.{program}", *arguments, "--no-dashboard"]
        code = {"PYTHONPATH": str(self.home / "code"), "OPENBLAS_NUM_THREADS": "1"}
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(command, cwd=self.home, env=environment() | code, **quiet)  # type: ignore[call-overload, no-any-return]

    def worker(self) -> "subprocess.Popen[bytes]":
        return self.begin("dask_worker", self.address, "--nthreads", "1", "--no-nanny")

    def restart(self) -> None:
        self.scheduler.kill()
        self.scheduler.wait()
        time.sleep(1)
        self.scheduler = self.begin("dask_scheduler", "--host", "127.0.0.1", "--port", self.address.rsplit(":", 1)[1])

    def tend(self) -> None:
        """Workers that ended with their scheduler begin again."""
        self.workers = [self.worker() if worker.poll() is not None else worker for worker in self.workers]

    def end(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(folder: Path) -> Iterator[Cluster]:
    made = Cluster(folder)
    yield made
    made.end()


def client_of(cluster: Cluster, out: str) -> "subprocess.Popen[str]":
    return start(cluster.home, "study.toml", "--out", out, "--executor", "dask", "--scheduler", cluster.address)


def tended(cluster: Cluster, client: "subprocess.Popen[str]") -> tuple[int, str, str]:
    end = time.monotonic() + 240
    while client.poll() is None and time.monotonic() < end:
        cluster.tend()
        time.sleep(0.5)
    return finish(client)


@needs_dask
@pytest.mark.slow
def test_a_scheduler_killed_and_restarted_loses_nothing(cluster: Cluster) -> None:
    client = client_of(cluster, "scheduler")
    until(lambda: results(cluster.home / "scheduler") >= 1, client)
    cluster.restart()
    code, _, err = tended(cluster, client)
    assert code == 0, err
    assert "the scheduler is gone" in err
    assert "Traceback" not in err
    same(cluster.home, "scheduler")


@needs_dask
@pytest.mark.slow
def test_a_worker_of_a_cluster_killed_in_mid_point_loses_nothing(cluster: Cluster) -> None:
    client = client_of(cluster, "node")
    until(lambda: results(cluster.home / "node") >= 1, client)
    os.kill(cluster.workers[0].pid, signal.SIGKILL)
    code, _, err = tended(cluster, client)
    assert code == 0, err
    same(cluster.home, "node")


def test_dask_needs_an_address_and_an_address_needs_dask() -> None:
    with pytest.raises(InputError, match="needs --scheduler"):
        crew_of("dask", "", None)
    with pytest.raises(InputError, match="goes with --executor dask"):
        crew_of("processes", "tcp://node1:8786", None)


@needs_dask
@pytest.mark.slow
def test_an_address_where_nobody_answers_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    from reports.sweep import crews

    with pytest.raises(InputError, match="no dask scheduler answers there"):
        crews.Dask("tcp://127.0.0.1:9", patience=0.5)
