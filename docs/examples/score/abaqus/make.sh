#!/usr/bin/env bash
# A path table as Abaqus/CAE reports it, with CalculiX' numbers: path.rpt, path.csv, mapping.toml and made.json, made anew.
# Needs `make` (.venv) and `make peers` (ccx), and a minute or two.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../../.." && pwd)
work=$root/out/examples/abaqus

rm -rf "$work" && mkdir -p "$work"
cd "$work"
"$root/.venv/bin/python" -m reports export cattaneo-mindlin --steps-per-cycle 24 --cycles 1 --out deck --quiet > /dev/null
"$root/.venv/bin/python" "$here/make.py" deck/cattaneo-mindlin_calculix.inp .
cp path.rpt path.csv mapping.toml made.json "$here/"
