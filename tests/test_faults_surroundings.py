"""Streams that are closed, full, unread or know few signs; signals to end; names that no file can have; folders lost meanwhile."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from reports import folder as folders
from reports.folder import MANIFEST, FilledBefore, claim, filled
from reports.staging import lock
from scenes import ContactSolution, InputError
from test_cli_commands import environment, everything
from test_faults_processes import interrupted

EXACT = ("exact", "hertz-paper", "--out", "out")
WRITTEN = {
    "out",
    *(f"out/{name}" for name in (MANIFEST, "scene.json", "semi_analytic.csv", "semi_analytic.json", "semi_analytic.nc")),
}


def halfplane(
    folder: Path,
    *words: str | bytes,
    stdout: int = subprocess.PIPE,
    stderr: int = subprocess.PIPE,
    closed: bool = False,
    limit: int = resource.RLIM_INFINITY,
    **own: str,
) -> subprocess.CompletedProcess[str]:
    """In streams of its own, closed ones among them; `limit` is that of the bytes of a file."""

    def prepare() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        for handle in range(3) if closed else ():
            os.close(handle)

    return subprocess.run(
        [sys.executable, "-m", "reports", *words],
        cwd=folder,
        env=environment() | own,
        stdin=subprocess.DEVNULL,
        stdout=stdout,
        stderr=stderr,
        text=True,
        timeout=120,
        check=False,
        preexec_fn=prepare,
    )


def sentence(done: subprocess.CompletedProcess[str]) -> str:
    """The one line of a refusal."""
    assert done.returncode == 2, done
    (line,) = done.stderr.splitlines()
    return line


@pytest.fixture
def unread() -> Iterator[int]:
    """A pipe that nobody reads any more."""
    read, write = os.pipe()
    os.close(read)
    yield write
    os.close(write)


@pytest.fixture
def full() -> Iterator[int]:
    """A disk that is full."""
    with open("/dev/full", "w") as stream:
        yield stream.fileno()


@pytest.mark.parametrize("words", [("scenes",), ("scenes", "--json"), ("--help",), ("completion", "bash"), ("schema",)])
def test_an_answer_that_nobody_reads_is_141_without_a_word(words: tuple[str, ...], unread: int, tmp_path: Path) -> None:
    """As in `halfplane scenes | head -1`; 1 would mean that a verdict is bad."""
    done = halfplane(tmp_path, *words, stdout=unread)
    assert (done.returncode, done.stderr) == (141, "")


@pytest.mark.parametrize("words", [("scenes",), ("--version",), ("completion", "bash")])
def test_an_answer_that_does_not_fit_on_the_disk_is_a_sentence(words: tuple[str, ...], full: int, tmp_path: Path) -> None:
    assert "the answer could not be written to stdout: No space left on device" in sentence(
        halfplane(tmp_path, *words, stdout=full)
    )


@pytest.mark.parametrize("where", ["unread", "full"])
def test_progress_that_goes_nowhere_does_not_end_the_work(where: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    done = halfplane(tmp_path, *EXACT, stderr=request.getfixturevalue(where))
    assert done.returncode == 0
    assert "out/semi_analytic.nc" in done.stdout
    assert everything(tmp_path) == WRITTEN


def test_closed_streams_are_no_files(tmp_path: Path) -> None:
    """Else the first file that is opened is stdout."""
    assert halfplane(tmp_path, *EXACT, closed=True).returncode == 0
    assert everything(tmp_path) == WRITTEN
    assert ContactSolution.load(tmp_path / "out" / "semi_analytic.nc").record.converged
    for words in (("scenes",), ("completion", "bash"), ("init", "new.toml")):
        assert halfplane(tmp_path, *words, closed=True).returncode == 0


def test_a_terminal_that_knows_no_greek_gets_words(tmp_path: Path) -> None:
    done = halfplane(tmp_path, "check", "hertz-paper", PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert "nu = 0.3" in done.stdout
    assert "cos(t - 90 deg)" in done.stdout
    answer = halfplane(tmp_path, "check", "hertz-paper", "--json", PYTHONIOENCODING="ascii")
    assert json.loads(answer.stdout)["passed"] is True
    assert halfplane(tmp_path, *EXACT, PYTHONIOENCODING="ascii").returncode == 0


def test_signs_without_a_word_are_escapes_that_json_reads(tmp_path: Path) -> None:
    script = "import sys\nfrom reports.cli.process import settled\nwith settled(): sys.stdout.write('\"\\u6f22 \\u03bd\"')"
    own = environment() | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=own, capture_output=True, text=True, check=True)
    assert done.stdout == '"\\u6f22 nu"'
    assert json.loads(done.stdout) == "漢 nu"


@pytest.mark.parametrize("words", [("run", "hertz-paper", "--out", b"o\xff"), ("check", b"o\xff.toml")])
def test_an_argument_that_is_no_text_is_refused_before_any_work(words: tuple[str | bytes, ...], tmp_path: Path) -> None:
    """Its byte stands in the command that a report shows: the page could not be written, after all the work."""
    assert "o\\udcff" in sentence(halfplane(tmp_path, *words))
    assert everything(tmp_path) == set()


@pytest.mark.parametrize(
    "words", [("exact", "hertz-paper", "--out", 300 * "x"), ("check", 300 * "x"), ("init", 300 * "x" + ".toml")], ids=lambda w: w[0]
)
def test_a_name_that_no_file_can_have_is_a_sentence(words: tuple[str, ...], tmp_path: Path) -> None:
    assert "File name too long" in sentence(halfplane(tmp_path, *words))
    assert everything(tmp_path) == set()


@pytest.mark.parametrize("words", [("--out", ""), ("--out=",)])
def test_an_empty_argument_is_refused(words: tuple[str, ...], tmp_path: Path) -> None:
    """As of --out "$FOLDER" where that is not set: results went to the current folder, among whatever is there."""
    assert "one of the arguments is empty" in sentence(halfplane(tmp_path, "exact", "hertz-paper", *words))
    assert everything(tmp_path) == set()


def test_a_terminal_of_no_width_is_taken_for_one_that_does_not_say(tmp_path: Path) -> None:
    assert halfplane(tmp_path, *EXACT, COLUMNS="0").stdout == halfplane(tmp_path, *EXACT, COLUMNS="80").stdout != ""


@pytest.mark.parametrize("which", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_to_end_keeps_what_was_solved_as_ctrl_c_does(which: signal.Signals, tmp_path: Path) -> None:
    words = ("--order", "1", "--element-size", "0.25", "--edge-element-size", "0.25", "--steps-per-cycle", "4000", "--out", "out")
    code, told = interrupted(tmp_path, "fe", "hertz-paper", *words, which=which)
    assert code == 128 + which, told
    assert "what was solved is kept in out/partial.nc" in told
    assert {name for name in everything(tmp_path) if name.startswith(".")} == set()
    assert not ContactSolution.load(tmp_path / "out" / "partial.nc").record.converged


def scripted(folder: Path, *lines: str) -> subprocess.CompletedProcess[str]:
    """Lines of Python in a process of their own."""
    return subprocess.run(
        [sys.executable, "-c", "\n".join(["import os, signal, sys", *lines])],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_a_signal_that_was_to_be_ignored_stays_so(tmp_path: Path) -> None:
    """As nohup asks."""
    done = scripted(
        tmp_path,
        "from reports.cli.process import settled",
        "signal.signal(signal.SIGHUP, signal.SIG_IGN)",
        "with settled(): os.kill(os.getpid(), signal.SIGHUP); print('goes on')",
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "goes on\n", "")


def test_a_second_ctrl_c_while_the_first_is_told_is_no_traceback(tmp_path: Path) -> None:
    done = scripted(
        tmp_path,
        "from reports.cli import application as cli",
        "def stop(*_): os.kill(os.getpid(), signal.SIGINT)",
        "cli.app = cli._refused = stop",
        "sys.exit(cli.main())",
    )
    assert (done.returncode, done.stderr) == (130, "")


def at_move(number: int, act: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> None:
    """`act` before that move of a file."""
    moves, real = 0, os.replace

    def replace(source: Path, target: Path) -> None:
        nonlocal moves
        moves += 1
        if moves == number:
            act()
        real(source, target)

    monkeypatch.setattr(os, "replace", replace)


def fill(out: Path, *names: str, meanwhile: Callable[[], None] = lambda: None) -> None:
    with filled(out) as there:
        for name in names:
            (there / name).write_text(name)
        meanwhile()


@pytest.mark.parametrize("move", [1, 2, 4])
def test_ctrl_c_while_files_are_moved_waits_until_all_are(move: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    at_move(move, lambda: os.kill(os.getpid(), signal.SIGINT), monkeypatch)
    with pytest.raises(FilledBefore, match=r"the results in .*out are whole"):
        fill(tmp_path / "out", "a.json", "report.html")
    assert everything(tmp_path) == {"out", "out/a.json", "out/report.html", f"out/{MANIFEST}"}
    assert json.loads((tmp_path / "out" / MANIFEST).read_text())["files"] == ["a.json", MANIFEST, "report.html"]


def locked(folder: Path) -> int:
    """A handle of a process that was stopped while it moved files."""
    handle = os.open(folder, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    return handle


def test_a_folder_that_a_stopped_process_holds_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(folders, "_PATIENCE", 0.0)
    handle = locked(tmp_path)
    with pytest.raises(InputError, match="another process has held this folder for 0 s"):
        claim(tmp_path)
    os.close(handle)
    assert claim(tmp_path) == tmp_path


def spoil_by_lock(out: Path) -> None:
    locked(out)


def spoil_by_a_file(out: Path) -> None:
    out.rmdir()
    out.write_text("mine")


def spoil_by_a_taken_name(out: Path) -> None:
    (out / "a.json").write_text("mine")


@pytest.mark.parametrize("spoil", [spoil_by_lock, spoil_by_a_file, spoil_by_a_taken_name])
def test_what_was_computed_is_kept_where_its_folder_is_lost(
    spoil: Callable[[Path], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hours of work must not go because of what somebody did to the folder meanwhile."""
    monkeypatch.setattr(folders, "_PATIENCE", 0.0)
    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(InputError, match="what did not get there is kept in ") as fault:
        fill(out, "a.json", "b.json", meanwhile=lambda: spoil(out))
    claim(tmp_path / "later")
    assert (Path(str(fault.value).rsplit("kept in ", 1)[1]) / "b.json").read_text() == "b.json"
    assert not (out / MANIFEST).exists()
    assert out.is_dir() or out.read_text() == "mine"


def test_a_folder_that_was_replaced_is_locked_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A lock on a folder that is there no more keeps nobody out."""
    out, real = tmp_path / "out", fcntl.flock
    out.mkdir()

    def flock(handle: int, how: int) -> None:
        real(handle, how)
        if not (tmp_path / "old").exists():
            out.rename(tmp_path / "old")
            out.mkdir()

    monkeypatch.setattr(fcntl, "flock", flock)
    assert lock(out) is None
    handle = lock(out)
    assert handle is not None
    assert os.path.samestat(os.fstat(handle), out.stat())
    os.close(handle)


@pytest.mark.parametrize("reason", [errno.EXDEV, errno.EACCES])
def test_a_folder_is_filled_whatever_is_above_it(reason: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another disk, where `out` is a mounted one or a link; or a folder of somebody else's."""

    def refuse(*_: object) -> None:
        raise OSError(reason, os.strerror(reason))

    (tmp_path / "out").mkdir()
    monkeypatch.setattr(os, "rename", refuse)
    fill(tmp_path / "out", "a.json")
    assert everything(tmp_path) == {"out", "out/a.json", f"out/{MANIFEST}"}


def test_a_link_to_another_disk_is_filled(tmp_path: Path) -> None:
    """The same, where this machine has two."""
    memory = Path("/dev/shm")
    if not os.access(memory, os.W_OK) or memory.stat().st_dev == tmp_path.stat().st_dev:
        other = tmp_path / "other"
        other.mkdir()
    else:
        other = memory / f"halfplane-{os.getpid()}-{tmp_path.name}"
        other.mkdir(exist_ok=True)
    (tmp_path / "out").symlink_to(other)
    try:
        fill(tmp_path / "out", "a.json")
        assert everything(other) == {"a.json", MANIFEST}
    finally:
        for path in other.iterdir():
            path.unlink()
        other.rmdir()


@pytest.mark.parametrize("fault", ["ImportError('initialization failed')", "RuntimeError('release unlocked lock')"])
def test_what_compiled_modules_and_locks_make_of_ctrl_c_is_one_still(fault: str, tmp_path: Path) -> None:
    """And the same without a Ctrl-C is what it is: a fault of ours, with its traceback in a file."""
    lines = (
        "from reports.cli import application as cli",
        "def app(_):",
        "    try: ASKED",
        "    except KeyboardInterrupt: pass",
        f"    raise {fault}",
        "cli.app = app",
        "sys.exit(cli.main())",
    )
    done = scripted(tmp_path, *(line.replace("ASKED", "os.kill(os.getpid(), signal.SIGINT)") for line in lines))
    assert (done.returncode, done.stderr) == (130, "halfplane: interrupted; nothing was written\n")
    ours = scripted(tmp_path, *(line.replace("ASKED", "pass") for line in lines))
    assert ours.returncode == 70
    assert "internal error" in ours.stderr
    assert "Traceback" not in ours.stderr


def test_a_fault_about_another_file_is_not_told_of_the_folder(tmp_path: Path) -> None:
    """A program that is missing, say, while a page is made."""
    with pytest.raises(FileNotFoundError, match=r"lost\.txt"):
        fill(tmp_path / "out", "a.json", meanwhile=(tmp_path / "lost.txt").read_text)
    assert everything(tmp_path) == set()
