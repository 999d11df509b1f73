"""The README on bare machines: a root of Debian for each suite, and in it the README's own shell
blocks, as they stand.

    python benchmarks/fresh.py [--keep] [SUITE ...]      (make fresh; bookworm and trixie if none is
                                                         named)

Needs root and debootstrap. The mirror is that of this machine's apt, or MIRROR=URL. apt and pip in
the root are set up as here, by their settings alone: proxies, indexes, certificates, folders. Every
command runs in namespaces of its own, which end with this program however it ends (SIGKILL too),
and its mounts and processes with them; --keep leaves the root in .cache/fresh.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parent.parent
APART = (
    "setpriv",
    "--pdeathsig",
    "KILL",
    "unshare",
    "--mount",
    "--propagation",
    "private",
    "--pid",
    "--fork",
    "--kill-child",
)
# What a running machine has and a root made by debootstrap has not; "$@" are the folders that pip
# reads, then the command after --.
MOUNTS = """
mkdir -p "$1/dev/pts" "$1/dev/shm"
mount -t proc proc "$1/proc"
mount -t devpts -o ptmxmode=666 devpts "$1/dev/pts"
mount -t tmpfs -o mode=1777 tmpfs "$1/dev/shm"
root=$1; shift
while [ "$1" != -- ]; do
    mkdir -p "$root$1"
    mount --rbind "$1" "$root$1"
    mount -o remount,bind,ro "$root$1"
    shift
done
shift
exec chroot "$root" "$@"
"""


def printed(*words: str) -> str:
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def mirror() -> str:
    """Where this machine's apt has Debian's own packages from."""
    if "MIRROR" in os.environ:
        return os.environ["MIRROR"]
    targets = printed(
        "apt-get", "indextargets", "--format", "$(ORIGIN) $(COMPONENT) $(CODENAME) $(REPO_URI)"
    )
    if target := re.search(r"^Debian main [a-z]+ (\S+)$", targets, re.MULTILINE):
        return target[1]
    raise SystemExit(
        "fresh: apt on this machine has no mirror of Debian (apt-get update?); name one: make fresh"
        " MIRROR=URL"
    )


def pip_settings(root: Path) -> tuple[dict[str, str], list[str]]:
    """PIP_... variables for what pip is set to here, and the folders that it names; its files are
    copied into the root.
    """
    settings: dict[str, str] = {}
    for line in printed(sys.executable, "-m", "pip", "config", "list").splitlines():
        key, _, value = line.partition("=")
        if not key.endswith(".cache-dir"):  # a bare machine has none
            settings[f"PIP_{key.rpartition('.')[2].upper().replace('-', '_')}"] = ast.literal_eval(
                value
            )
    folders = set()
    for key, value in settings.items():
        for path in map(Path, re.findall(r"(?:(?<=file://)|(?<!\S))/[^\s/]\S*", value)):
            if path.is_dir():
                # an index points to files beside it
                folders.add(str(path.parent if path.name == "simple" else path))
            elif path.is_file():
                copy = root / "var" / "fresh" / path.name
                copy.parent.mkdir(exist_ok=True)
                shutil.copy(path, copy)
                settings[key] = settings[key].replace(str(path), f"/{copy.relative_to(root)}")
    return settings, sorted(folders)


def apart(*words: str | Path) -> None:
    """A command whose mounts and processes end with it, and with this program."""
    last, theirs = os.pipe()
    with subprocess.Popen(
        [*APART, *map(str, words)], stdin=subprocess.DEVNULL, pass_fds=(theirs,)
    ) as running:
        os.close(theirs)
        try:
            code = running.wait()
        except BaseException:
            running.kill()
            raise
        finally:
            # returns when the last process inside is gone: no file appears in the root any more
            os.read(last, 1)
            os.close(last)
    if code:
        raise subprocess.CalledProcessError(code, [str(word) for word in words])


def build(suite: str, root: Path) -> None:
    """Debian's smallest system, with this machine's names of hosts, settings of apt, and a copy of
    this checkout.
    """
    scripts = Path("/usr/share/debootstrap/scripts")
    # a suite younger than debootstrap itself
    script = [] if (scripts / suite).exists() else [scripts / "sid"]
    apart("debootstrap", "--variant=minbase", suite, root, mirror(), *script)
    for name in ("hosts", "resolv.conf"):
        shutil.copy(Path("/etc") / name, root / "etc" / name)
    (root / "etc" / "apt" / "apt.conf.d" / "00host").write_text(
        printed("apt-config", "dump", "Acquire")
    )
    names = printed(
        "git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"
    ).split("\0")
    for name in (name for name in names if name and (ROOT / name).is_file()):
        target = root / "root" / "halfplane" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, target)


def readme(root: Path) -> list[str]:
    """Run the shell blocks; the Python found there, and how long each block took."""
    settings, folders = pip_settings(root)
    proxies = {key: value for key, value in os.environ.items() if key.lower().endswith("_proxy")}
    variables = (
        {"HOME": "/root", "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"}
        | settings
        | proxies
    )
    clean = ["/usr/bin/env", "-i", *(f"{key}={value}" for key, value in variables.items())]
    took = []
    for block in re.findall(
        r"^```sh\n(.*?)^```",
        (ROOT / "README.md").read_text("utf-8"),
        flags=re.DOTALL | re.MULTILINE,
    ):
        start = time.monotonic()
        apart(
            "bash",
            "-euc",
            MOUNTS,
            "fresh",
            root,
            *folders,
            "--",
            *clean,
            "bash",
            "-exc",
            f"cd /root/halfplane\n{block}",
        )
        took.append(f"{block.splitlines()[-1][:15].strip()} {time.monotonic() - start:.0f} s")
    python = root / "root" / "halfplane" / ".venv" / "pyvenv.cfg"
    return [*re.findall(r"^version = (\S+)", python.read_text("utf-8"), flags=re.MULTILINE), *took]


def main(words: list[str]) -> int:
    suites = [word for word in words if word != "--keep"] or ["bookworm", "trixie"]
    if os.geteuid() or not shutil.which("debootstrap"):
        print("fresh: needs root and debootstrap (apt-get install debootstrap)", file=sys.stderr)
        return 2
    for signum in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(signum, lambda number, _: sys.exit(128 + number))
    lines = []
    for suite in suites:
        root = ROOT / ".cache" / "fresh" / suite
        shutil.rmtree(root, ignore_errors=True)  # of a run that was killed; its mounts went with it
        root.mkdir(parents=True)
        print(f"==> fresh: a bare root of {suite}", flush=True)
        try:
            build(suite, root)
            lines.append(f"{suite}: Python {', '.join(readme(root))}: ok")
        except subprocess.CalledProcessError as failed:
            lines.append(
                f"{suite}: FAILED, exit code {failed.returncode}: {failed.cmd[-1].splitlines()[-1]}"
            )
        finally:
            if "--keep" not in words:
                shutil.rmtree(root)
        print(f"==> fresh: {lines[-1]}", flush=True)
    return int(any("FAILED" in line for line in lines))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
