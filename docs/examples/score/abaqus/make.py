"""A path table in the form in which Abaqus/CAE reports it, with CalculiX' numbers: nobody here has
Abaqus.

    python make.py DECK.inp FOLDER

Takes the deck that `halfplane export SCENE` writes, runs CalculiX, and reports CPRESS and CSHEAR1
along the lower face at every instant of the last revolution: path.rpt, and the same as path.csv.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

from reports.scoring.mapping import Mapping
from reports.scoring.reading import read
from reports.studies.third.calculix import calculix_version, find_calculix, status
from scenes import load_scene

SCENE, NAME = "cattaneo-mindlin", "path"
REVOLUTION = 2.0  # of the scene's load path, in its time
REACH = 1.5  # of the path to each side of the middle [mm]


def figure(value: float) -> str:
    """Six digits, zero with a point."""
    text = f"{value + 0.0:.6G}"
    return text if "." in text or "E" in text else f"{text}."


def report(folder: Path, names: list[str], columns: np.ndarray) -> None:
    """path.rpt, all XY data in one table, page width without limit; path.csv."""
    rows = [[figure(value) for value in row] for row in columns]
    head = "".join(f"{name:>18}" for name in names)
    body = "\n".join("".join(f"{cell:>18}" for cell in row) for row in rows)
    (folder / "path.rpt").write_text(f"\n{head}\n\n{body}\n\n", encoding="utf-8")
    lines = [",".join(names), *(",".join(row) for row in rows)]
    (folder / "path.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main(deck: Path, folder: Path) -> None:
    """Deck, run, tables, mapping, and what made them."""
    program = find_calculix()
    shutil.copyfile(deck, folder / f"{NAME}.inp")
    alone = {**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_RESULTS": "1"}
    with (folder / "ccx.log").open("w", encoding="utf-8") as log:
        subprocess.run([program, "-i", NAME], cwd=folder, env=alone, stdout=log, check=True)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    scene = load_scene(SCENE)
    found = read(folder / f"{NAME}.frd", Mapping())
    if found.time is None:
        raise ValueError(f"{NAME}.frd states no times")
    on = np.abs(found.x) < REACH
    steps = np.flatnonzero(found.time > found.time[-1] - REVOLUTION * (1 + 1e-6))
    # The first step of the deck, the touch, is none of the instants.
    names = ["X", *(f"{field}_STEP{step + 2}" for step in steps for field in ("CPRESS", "CSHEAR1"))]
    fields = [values[step, on] for step in steps for values in (found.pressure, found.shear)]
    start = float(found.x[on][0])
    report(folder, names, np.column_stack([found.x[on] - start, *fields]))
    words = f'code = "CalculiX {calculix_version(program)} in the form of an Abaqus path table"\n'
    words += (
        "# The path counts the true distance from its first node.\n" + f"x_offset = {-start:.7g}\n"
    )
    times = found.time[steps] + scene.load.path().start
    words += "# Times of the scene's load path: the names of the columns count steps.\n"
    words += f"times = [{', '.join(f'{value:.7g}' for value in times)}]\n"
    (folder / "mapping.toml").write_text(words, encoding="utf-8")
    accepted = sum(attempt.accepted for attempt in status(folder / f"{NAME}.sta"))
    made = {
        "code": f"CalculiX {calculix_version(program)}",
        "seconds": round(seconds, 1),
        "increments": accepted,
    }
    (folder / "made.json").write_text(json.dumps(made) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve())
