"""The command about this machine: can it do the work?"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from platform import machine as processor
from platform import python_version, system

from reports.cli.application import EXIT_OUTSIDE, EXIT_WITHIN, Answer, Options
from reports.console import Sheet

_PACKAGES = (
    "numpy",
    "scipy",
    "pydantic",
    "xarray",
    "scikit-fem",
    "gmsh",
    "meshio",
    "matplotlib",
    "pyvista",
    "jinja2",
)
_GMSH = """
import gmsh
gmsh.initialize(interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.mesh.generate(2)
version = gmsh.option.getString("General.Version")
print(len(gmsh.model.mesh.getNodes()[0]), "nodes in a disc, gmsh", version)
gmsh.finalize()
"""
_SCREEN = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Sphere())
picture = plotter.screenshot(None, return_img=True)
assert picture.std() > 0, "the picture is empty"
print("a sphere rendered, pyvista", pyvista.__version__)
"""


@dataclass(frozen=True)
class Finding:
    """One check: what was looked at, whether it will do, and the words that say why."""

    name: str
    good: bool
    words: str


def doctor(options: Options) -> Answer:
    """Every check of this machine: 0 where all are good, else 1."""
    findings = examine(options.out or "out")
    code = EXIT_WITHIN if all(finding.good for finding in findings) else EXIT_OUTSIDE
    checks = {finding.name: {"good": finding.good, "found": finding.words} for finding in findings}
    rows = [(finding.name, "yes" if finding.good else "no", finding.words) for finding in findings]
    return Answer(
        code,
        [Sheet("Doctor", ("check", "good", "found"), rows)],
        lambda: {"passed": code == EXIT_WITHIN, "checks": checks},
    )


def examine(out: str | Path = "out") -> tuple[Finding, ...]:
    """The checks of this machine: Python, packages, gmsh, off-screen rendering, and whether the
    output folder `out` can be written to. Each has a name, whether it is good, and why.
    """
    # `_GMSH`, which meshes a disc, and `_SCREEN`, which renders a sphere, are programs as text
    return (
        Finding(
            "Python", sys.version_info >= (3, 11), f"{python_version()} on {system()} {processor()}"
        ),
        Finding("packages", *_packages()),
        Finding(
            "gmsh",
            *_run_in_own_process(_GMSH, "it needs the Debian packages that the README lists"),
        ),
        Finding("off-screen rendering", *drawing()),
        Finding("output folder", *_folder(out)),
    )


def drawing() -> tuple[bool, str]:
    """Whether pictures can be drawn without a screen, and what was found."""
    return _run_in_own_process(_SCREEN, "only field pictures need it")


def _packages() -> tuple[bool, str]:
    """Whether all packages that the program needs are installed; and a text that lists their
    versions, then the names of those that are missing.
    """
    version_by_package: dict[str, str] = {}
    # _PACKAGES: names of the packages that the program needs
    for name in _PACKAGES:
        with suppress(PackageNotFoundError):
            version_by_package[name] = version(name)
    packages_in_words = ", ".join(
        f"{name} {version_text}" for name, version_text in version_by_package.items()
    )
    missing_packages = [name for name in _PACKAGES if name not in version_by_package]
    if missing_packages:
        packages_in_words += f"; missing: {', '.join(missing_packages)}"
    return not missing_packages, packages_in_words


def _run_in_own_process(program: str, hint: str) -> tuple[bool, str]:
    """Run the source text of a Python program in a process of its own. Returns whether it ended
    well and printed, and the last line that it printed; else the reason and the `hint`.

    The reason is that the program did not end within 120 s, or printed nothing; or, where it ended
    with an error, its last line on stderr or its exit code. A library that crashes or hangs thus
    does not stop this process.
    """
    command = [sys.executable, "-c", program]
    with tempfile.TemporaryDirectory() as folder:
        try:
            process = subprocess.run(
                command, capture_output=True, text=True, timeout=120, check=False, cwd=folder
            )
        except subprocess.TimeoutExpired:
            return False, f"no answer in 120 s; {hint}"
    printed_lines = process.stdout.strip().splitlines()
    if process.returncode == 0 and printed_lines:
        return True, printed_lines[-1]
    if process.returncode == 0:  # a program prints once its check is done: it never came so far
        return False, f"ended before its check was done; {hint}"
    error_lines = process.stderr.strip().splitlines()
    reason = error_lines[-1] if error_lines else f"ended with code {process.returncode}"
    return False, f"{reason}; {hint}"


def _folder(out: str | Path) -> tuple[bool, str]:
    """Whether the output folder `out` can be written to, and in words that it can, or why not."""
    from reports.folder import usable_folder
    from scenes import InputError

    try:
        usable_folder(out)
    except InputError as reason:
        return False, str(reason)
    return True, f"{out}: can be written to"
