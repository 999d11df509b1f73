"""Sweeps in processes of their own and on dask, killed, starved and doubled: no point lost, none twice in the index, none wrong."""

import importlib.util
import json
import os
import random
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from command_line import start
from faulty import copy_the_code
from reports.sweep.store import STATUS, Store, done, read_index

pytestmark = pytest.mark.slow
needs_dask = pytest.mark.skipif(not importlib.util.find_spec("distributed"), reason="distributed is missing: halfplane[cluster]")
POINTS = 500
STUDY = f"""scene = "hertz-paper"\nengines = ["exact"]\nfigures = ["exact.dissipation", "exact.peak_dissipation"]
[[axes]]\nname = "f"\nkey = "friction.coefficient"\nlinear = {{start = 1.0, stop = 2.0, count = {POINTS}}}\n"""
LIGHT = STUDY.replace("hertz-paper", "cattaneo-mindlin")  # a quarter of the time
BLOCKS = """scene = "blocks"\nfigures = ["error.dissipation", "stick_edge"]
[set]\n"mesh.element_size" = 0.25\n"mesh.edge_element_size" = 0.125\n"mesh.order" = 1\n"mesh.growth" = 1.0
"solver.steps_per_cycle" = 24\n[[axes]]\nname = "f"\nkey = "friction.coefficient"\nlinear = {start = 1.0, stop = 2.0, count = 8}
"""


def sweep(home: Path, *words: str, session: bool = False) -> subprocess.Popen[str]:
    return start(home, "sweep", *words, session=session, PYTHONPATH=str(home / "code"))


def finish(client: subprocess.Popen[str], code: int = 0) -> tuple[str, str]:
    out, err = client.communicate(timeout=900)
    assert client.returncode == code, err
    assert "Traceback" not in err
    return out, err


def children(pid: int) -> list[int]:
    """Workers of a client: processes below it that were spawned."""
    parents, workers = {}, []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(path.parent.name)] = int(path.read_text().rsplit(")", 1)[1].split()[1])
            if b"spawn_main" in (path.parent / "cmdline").read_bytes():
                workers.append(int(path.parent.name))
        except (OSError, IndexError):
            continue
    return [worker for worker in workers if parents.get(worker) == pid]


def until(true: Callable[[], bool], client: subprocess.Popen[str]) -> None:
    end = time.monotonic() + 400
    while not true():
        assert client.poll() is None, client.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def results(folder: Path) -> int:
    return len(Store(folder).addresses())


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the studies are, with the stores `true-...` of undisturbed sweeps."""
    home = tmp_path_factory.mktemp("sweeps")
    copy_the_code(home / "code")
    for name, text in (("study", STUDY), ("light", LIGHT), ("blocks", BLOCKS)):
        (home / f"{name}.toml").write_text(text, encoding="utf-8")
        finish(sweep(home, f"{name}.toml", "--out", f"true-{name}"))
    return home


def same(home: Path, name: str, study: str = "study") -> None:
    """All points are there, once, with the figures of the undisturbed sweep, in the results and in index.csv."""
    columns = [name for name in read_index(home / name).columns if name not in STATUS]
    found, wanted = (done(read_index(home / folder))[columns].values.tolist() for folder in (name, f"true-{study}"))
    assert len(columns) == 4
    assert found == wanted
    assert len(found) == (8 if study == "blocks" else POINTS)
    lines = (home / name / "index.csv").read_text(encoding="utf-8").splitlines()
    assert [line.split(",")[0] for line in lines[1:]] == [str(number) for number in range(len(wanted))]
    assert Store(home / name).running() == set()
    assert Store(home / name).damaged() == []


def test_nine_interruptions_of_500_points(home: Path) -> None:
    """Killed, by Ctrl-C, by a batch system: workers end too, what is stored stays, and the last run ends with the truth."""
    store, chance, kept = home / "nine", random.Random(19), 0
    for how in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM) * 3:
        client = sweep(home, "study.toml", "--out", "nine", "--workers", "2")
        wanted = kept + chance.randrange(10, 40)
        until(lambda wanted=wanted: results(store) >= wanted, client)  # type: ignore[misc]
        workers = children(client.pid)
        assert workers
        client.send_signal(how)
        _, err = finish(client, -how if how == signal.SIGKILL else 128 + how)
        end = time.monotonic() + 60
        while any(Path(f"/proc/{pid}").exists() for pid in workers):  # they notice that their client is gone
            assert how == signal.SIGKILL
            assert time.monotonic() < end
            time.sleep(0.1)
        if how != signal.SIGKILL:
            assert f"halfplane sweep study.toml --workers 2 --out {store.name}" in err
            assert list((store / "claims").iterdir()) == []
        assert kept < results(store) < POINTS
        kept = results(store)
    out, _ = finish(sweep(home, "study.toml", "--out", "nine"))
    assert f"{kept} points have results already" in out
    same(home, "nine")


def test_two_sweeps_at_once_on_one_store_and_one_more_that_is_killed(home: Path) -> None:
    """None computed twice while its sweep lives; status and page are seen meanwhile."""
    clients = [sweep(home, "study.toml", "--out", "two", "--workers", "1") for _ in range(3)]
    until(lambda: results(home / "two") >= 60, clients[0])
    for client in clients:  # alive, so that their points are theirs; else a slow machine reads the state after the last point
        client.send_signal(signal.SIGSTOP)
    found = json.loads(finish(sweep(home, "status", "two", "--json"))[0])["result"]["points"]
    assert found["done"] >= 60
    assert found["running"] > 0
    assert found["done"] + found["running"] + found["waiting"] == found["total"] == POINTS
    finish(sweep(home, "report", "two"))
    for client in clients:
        client.send_signal(signal.SIGCONT)
    assert "<svg" in (home / "two" / "sweep.html").read_text(encoding="utf-8")
    clients[2].kill()
    clients[2].communicate()
    errors = [finish(client)[1] for client in clients[:2]]
    assert any("done by another sweep" in err for err in errors)
    same(home, "two")


def test_a_worker_killed_in_mid_point_loses_nothing(home: Path) -> None:
    client = sweep(home, "blocks.toml", "--out", "worker", "--workers", "2")
    until(lambda: results(home / "worker") >= 1, client)
    os.kill(children(client.pid)[0], signal.SIGKILL)
    assert "the worker died" in finish(client)[1]
    same(home, "worker", "blocks")


class Cluster:
    """`dask scheduler` and two `dask worker`, as a batch system would keep them; with TLS where `tls` has its options."""

    def __init__(self, home: Path, tls: tuple[str, ...] = ()) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = str(probe.getsockname()[1])
        self.home, self.tls = home, tls
        self.address = f"{'tls' if tls else 'tcp'}://127.0.0.1:{self.port}"
        self.scheduler = self.schedule()
        self.workers = [self.work() for _ in range(2)]

    def begin(self, program: str, *words: str) -> subprocess.Popen[str]:
        return start(
            self.home,
            *words,
            *self.tls,
            "--no-dashboard",
            program=("-m", f"distributed.cli.{program}"),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            PYTHONPATH=str(self.home / "code"),
            OPENBLAS_NUM_THREADS="1",
        )

    def schedule(self) -> subprocess.Popen[str]:
        protocol = ("--protocol", "tls") if self.tls else ()
        return self.begin("dask_scheduler", "--host", "127.0.0.1", "--port", self.port, *protocol)

    def work(self) -> subprocess.Popen[str]:
        return self.begin("dask_worker", self.address, "--nthreads", "1", "--no-nanny")

    def client(self, out: str, *options: str, study: str = "light.toml") -> subprocess.Popen[str]:
        return sweep(self.home, study, "--out", out, "--executor", "dask", "--scheduler", self.address, *options)

    def tended(self, client: subprocess.Popen[str]) -> tuple[str, str]:
        """What the client prints; workers that end with their scheduler begin again meanwhile."""
        end = time.monotonic() + 600
        while client.poll() is None and time.monotonic() < end:
            self.workers = [self.work() if worker.poll() is not None else worker for worker in self.workers]
            time.sleep(0.5)
        return finish(client)

    def end(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(home: Path) -> Iterator[Cluster]:
    made = Cluster(home)
    yield made
    made.end()


@needs_dask
@pytest.mark.parametrize("who", ["scheduler", "worker"])
def test_a_scheduler_or_a_worker_of_a_cluster_killed_loses_nothing(who: str, cluster: Cluster) -> None:
    client = cluster.client(who)
    until(lambda: results(cluster.home / who) >= 50, client)
    if who == "worker":
        cluster.workers[0].kill()
    else:
        cluster.scheduler.kill()
        cluster.scheduler.wait()
        time.sleep(1)
        cluster.scheduler = cluster.schedule()
    _, err = cluster.tended(client)
    assert ("the scheduler is gone" in err) is (who == "scheduler")
    same(cluster.home, who, "light")


def listening(pid: int) -> set[str]:
    """Addresses that a process listens at."""
    psutil = importlib.import_module("psutil")  # there with distributed
    return {one.laddr.ip for one in psutil.Process(pid).net_connections("inet") if one.status == psutil.CONN_LISTEN}


@needs_dask
def test_a_cluster_without_an_address_is_of_this_machine_alone_and_outlives_a_worker_and_ctrl_c(home: Path) -> None:
    words = ("study.toml", "--out", "local", "--executor", "dask", "--workers", "2")
    client = sweep(home, *words, session=True)
    until(lambda: results(home / "local") >= 50, client)
    workers = children(client.pid)
    assert {address for pid in (client.pid, *workers) for address in listening(pid)} == {"127.0.0.1"}
    os.kill(workers[0], signal.SIGKILL)
    until(lambda: results(home / "local") >= 150, client)
    os.killpg(client.pid, signal.SIGINT)  # as a terminal does, to all
    _, err = finish(client, 130)
    assert "resume with: halfplane sweep study.toml --executor dask" in err
    finish(sweep(home, *words))
    same(home, "local")


@needs_dask
def test_a_scheduler_with_tls_takes_our_certificate_and_nobody_without(home: Path) -> None:
    """And an address where nobody answers is a sentence."""
    make = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=sweep"]
    subprocess.run([*make, "-keyout", home / "key.pem", "-out", home / "cert.pem"], check=True, capture_output=True)
    tls = ("--tls-ca-file", str(home / "cert.pem"), "--tls-cert", str(home / "cert.pem"), "--tls-key", str(home / "key.pem"))
    cluster = Cluster(home, tls)
    try:
        cluster.tended(cluster.client("tls", *tls, study="blocks.toml"))
        same(home, "tls", "blocks")
        plain = ("--executor", "dask", "--scheduler", f"tcp://127.0.0.1:{cluster.port}")
        for where in (plain, (*plain[:-1], "tcp://127.0.0.1:9")):
            assert "no dask scheduler answers there" in finish(sweep(home, "study.toml", "--out", "none", *where), code=2)[1]
    finally:
        cluster.end()
