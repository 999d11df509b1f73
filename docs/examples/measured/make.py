"""One small file of each kind that loads and profiles are read from, as spreadsheets, data loggers and scripts write them.

    python docs/examples/measured/make.py FOLDER

No rig stands behind them: the numbers are formulas with noise from a seed. `SCENES` has the keys that each file needs.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

THICKNESS = 10.0  # of the specimen [mm]
# By file: keys of [load] or [profile] beside `file`.
SCENES = {
    "spreadsheet.csv": 'kind = "time_series"\nthickness = 10.0',
    "logger.txt": 'kind = "time_series"\nthickness = 10.0\nzero = {P = 0.02, Q = -3.5}\nsign = {P = -1}',
    "script.txt": 'kind = "time_series"',
    "channels.csv": 'kind = "time_series"\ncolumns = {time = 1, P = 3, Q = 2}\nthickness = 10.0',
    "noisy.csv": 'kind = "time_series"\naverage = 4\nreduce = "tolerance"\nthreshold = {P = 1.0, Q = 0.5}',
    "trace.txt": 'kind = "tabulated"\nzero = {x = 1500.0}',
}


def record(rows: int, noise: float = 0.0) -> NDArray[np.float64]:
    """Time [s], P and Q [N/mm], (rows, 3): a run-up, then swings of Q of two periods while P swings too; noise of P and Q."""
    time = np.linspace(0.0, 8.0, rows)
    up = 1 - np.exp(-4 * time)
    normal = 2 + 88 * up + 9 * up * np.sin(2 * np.pi * 0.7 * time)
    tangential = up * (16 * np.sin(2 * np.pi * 0.7 * time + 0.6) + 7 * np.sin(2 * np.pi * 0.23 * time))
    both = np.column_stack([normal, tangential]) + noise * np.random.default_rng(21).normal(size=(rows, 2))
    return np.column_stack([time, both])


def main(folder: Path) -> None:
    """Writes them all."""
    time, normal, tangential = record(161).T
    lines = [f"{t:.2f};{p:.4f};{q:.1f}" for t, p, q in zip(time, normal * THICKNESS / 1e3, tangential * THICKNESS, strict=True)]
    text = "\r\n".join(["Time [s];Normal force [kN];Shear force [N]", *lines]) + "\r\n"
    (folder / "spreadsheet.csv").write_bytes(text.replace(".", ",").encode("utf-8-sig"))

    rows = zip(1e3 * time, 0.02 - normal * THICKNESS / 1e3, tangential * THICKNESS - 3.5, strict=True)
    lines = [
        "Rig 4, run 12",
        "Date\t3.2.2026",
        "t\tFN\tFT\tstate",
        "ms\tkN\tN\t-",
        *(f"{t:.0f}\t{p:.5f}\t{q:.2f}\tok" for t, p, q in rows),
    ]
    (folder / "logger.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")

    np.savetxt(folder / "script.txt", np.column_stack([time, tangential, normal]), fmt="%.6e", header="time Q P")

    lines = [f"{t:.2f},{q:.3f},{p:.3f},21.5" for t, p, q in zip(time, normal * THICKNESS, tangential * THICKNESS, strict=True)]
    (folder / "channels.csv").write_text("\n".join(["channel data", *lines]) + "\n", encoding="utf-8")

    lines = ["time,P [N/mm],Q [N/mm]", *(f"{t:.4f},{p:.3f},{q:.3f}" for t, p, q in record(2000, noise=0.3))]
    (folder / "noisy.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    place = np.linspace(-1.5, 1.5, 61)
    lines = ["x [µm];z [nm]", *(f"{1e3 * x + 1500:.0f};{1e6 * x**2 / 2000:.3f}".replace(".", ",") for x in place)]
    (folder / "trace.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
