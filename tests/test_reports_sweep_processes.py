"""Sweeps in processes of their own, killed, starved and doubled: no point lost, none twice in the index, no wrong number."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from reports.sweep.index import Table, read_index
from reports.sweep.store import Store
from test_cli_commands import ROOT, environment

STUDY = """
scene = "blocks"
engines = ["fe", "exact"]
figures = ["error.dissipation", "stick_edge"]
share_condensations = true
[set]
"mesh.element_size" = 0.25
"mesh.edge_element_size" = 0.125
"mesh.order" = 1
"mesh.growth" = 1.0
"solver.steps_per_cycle" = 24
[[axes]]
name = "f"
key = "friction.coefficient"
linear = {start = 1.0, stop = 2.0, count = 12}
"""
EXACT = """
scene = "hertz-paper"
engines = ["exact"]
figures = ["exact.dissipation", "exact.peak_dissipation"]
[[axes]]
name = "f"
key = "friction.coefficient"
linear = {start = 1.0, stop = 2.0, count = 300}
"""
POINTS = 12


def start(folder: Path, *arguments: str, **options: object) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "reports", "sweep", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    code = {"PYTHONPATH": str(folder / "code")}
    return subprocess.Popen(command, cwd=folder, env=environment() | code, **(pipes | options))  # type: ignore[call-overload, no-any-return]


def finish(client: "subprocess.Popen[str]") -> tuple[int, str, str]:
    out, err = client.communicate(timeout=300)
    return client.returncode, out, err


def children(pid: int) -> list[int]:
    """Workers of a client: its children that run tasks."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(path.read_text().rsplit(")", 1)[1].split()[1])
            words = (path.parent / "cmdline").read_bytes()
        except (OSError, IndexError):
            continue
        if parent == pid and b"spawn_main" in words:
            found.append(int(path.parent.name))
    return found


def until(true: Callable[[], bool], client: "subprocess.Popen[str]") -> None:
    end = time.monotonic() + 120
    while not true():
        assert client.poll() is None, finish(client)
        assert time.monotonic() < end
        time.sleep(0.02)


def results(folder: Path) -> int:
    return len(Store(folder).addresses())


def figures(table: Table) -> dict[float, tuple[float, ...]]:
    """Friction -> figures; a point that is there twice fails."""
    assert len({row["number"] for row in table.rows}) == len(table.rows)
    return {row["f"]: tuple(row[name] for name in table.figures) for row in table.rows if row["status"] == "done"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the studies are, with `truth` of an undisturbed sweep of one process."""
    home = tmp_path_factory.mktemp("sweeps")
    for package in ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports"):  # nobody edits these while a sweep runs
        shutil.copytree(ROOT / package, home / "code" / package, ignore=shutil.ignore_patterns("published", "__pycache__"))
    (home / "study.toml").write_text(STUDY, encoding="utf-8")
    (home / "exact.toml").write_text(EXACT, encoding="utf-8")
    code, _, err = finish(start(home, "study.toml", "--out", "truth", "--workers", "1"))
    assert code == 0, err
    assert len(figures(read_index(home / "truth"))) == POINTS
    return home


def same(folder: Path, name: str) -> None:
    """All points are there, once, with the figures of the undisturbed sweep, in the results and in index.csv."""
    assert figures(read_index(folder / name)) == figures(read_index(folder / "truth"))
    lines = (folder / name / "index.csv").read_text(encoding="utf-8").splitlines()
    assert sorted(line.split(",")[0] for line in lines[1:]) == sorted(str(number) for number in range(POINTS))
    assert list((folder / name / "claims").iterdir()) == []
    assert not list((folder / name).rglob("*.part"))


@pytest.mark.slow
def test_a_worker_killed_in_mid_point_loses_nothing(folder: Path) -> None:
    client = start(folder, "study.toml", "--out", "worker", "--workers", "2")
    until(lambda: results(folder / "worker") >= 1, client)
    os.kill(children(client.pid)[0], signal.SIGKILL)
    code, _, err = finish(client)
    assert code == 0, err
    assert "the worker died" in err
    same(folder, "worker")


@pytest.mark.slow
def test_a_client_killed_leaves_a_store_that_the_next_goes_on_with(folder: Path) -> None:
    client = start(folder, "study.toml", "--out", "client", "--workers", "2")
    until(lambda: results(folder / "client") >= 1, client)
    workers = children(client.pid)
    client.kill()
    finish(client)
    kept = results(folder / "client")
    assert kept < POINTS
    end = time.monotonic() + 60
    while any(Path(f"/proc/{pid}").exists() for pid in workers):  # they notice that their client is gone
        assert time.monotonic() < end
        time.sleep(0.1)
    code, out, err = finish(start(folder, "study.toml", "--out", "client", "--resume"))
    assert code == 0, err
    assert f"{kept} points have results already" in out
    same(folder, "client")


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_cleanly_and_says_how_to_go_on(folder: Path, how: signal.Signals) -> None:
    client = start(folder, "study.toml", "--out", how.name, "--workers", "2")
    until(lambda: results(folder / how.name) >= 1, client)
    workers = children(client.pid)
    client.send_signal(how)
    code, _, err = finish(client)
    assert code == 128 + how, err
    assert "Traceback" not in err
    assert f"halfplane sweep study.toml --out {how.name} --resume" in err
    assert not any(Path(f"/proc/{pid}").exists() for pid in workers)
    assert list((folder / how.name / "claims").iterdir()) == []
    code, _, err = finish(start(folder, "study.toml", "--out", how.name, "--resume"))
    assert code == 0, err
    same(folder, how.name)


@pytest.mark.slow
def test_two_clients_on_one_store_share_the_work(folder: Path) -> None:
    clients = [start(folder, "study.toml", "--out", "two", "--workers", "1", "--resume") for _ in range(2)]
    for client in clients:
        code, _, err = finish(client)
        assert code == 0, err
    same(folder, "two")
    hosts = [Store(folder / "two").read(address) for address in Store(folder / "two").addresses()]
    assert len(hosts) == POINTS


@pytest.mark.slow
def test_the_status_of_a_sweep_is_seen_while_it_runs(folder: Path) -> None:
    client = start(folder, "study.toml", "--out", "seen", "--workers", "2")
    until(lambda: results(folder / "seen") >= 3, client)
    code, out, _ = finish(start(folder, "status", "seen"))
    assert code == 0
    rows = {
        words[0].strip("│ "): int(words[1].strip("│ "))
        for line in out.splitlines()
        if len(words := line.strip("│").split("│")) == 2
    }
    assert rows["done"] >= 3
    assert rows["running"] >= 1
    assert rows["done"] + rows["running"] + rows["waiting"] == POINTS
    assert finish(start(folder, "report", "seen"))[0] == 0
    assert "<svg" in (folder / "seen" / "sweep.html").read_text(encoding="utf-8")
    code, _, err = finish(client)
    assert code == 0, err
    same(folder, "seen")


@pytest.fixture
def disk_size() -> str:
    """About a megabyte, where each file takes four kilobytes."""
    return "1200k"


@pytest.mark.slow
def test_a_full_disk_is_a_sentence_and_what_was_stored_stays(folder: Path, small_disk: Path) -> None:
    code, _, err = finish(start(folder, "exact.toml", "--out", str(small_disk / "out"), "--workers", "1"))
    assert code == 2, err
    assert "there is no room left on the disk" in err
    assert "--resume" in err
    assert "Traceback" not in err
    kept = results(small_disk / "out")
    assert 0 < kept < 300
    store = Store(small_disk / "out")
    assert all(store.read(address) is not None for address in store.addresses())
    shutil.copytree(small_disk / "out", folder / "moved")  # to where there is room
    code, out, err = finish(start(folder, "exact.toml", "--out", "moved", "--resume", "--workers", "1"))
    assert code == 0, err
    assert f"{kept} points have results already" in out
    assert len(figures(read_index(folder / "moved"))) == 300


def _small_files() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


@pytest.mark.slow
def test_a_file_that_may_not_grow_is_a_sentence_too(folder: Path) -> None:
    code, _, err = finish(start(folder, "exact.toml", "--out", "limited", "--workers", "1", preexec_fn=_small_files))
    assert code == 2, err
    assert "there is no room left on the disk" in err
    assert results(folder / "limited") == 0
