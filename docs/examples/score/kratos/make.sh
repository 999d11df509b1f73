#!/usr/bin/env bash
# Kratos on the bodies and the history of the CalculiX deck beside this folder: result.csv and made.json, made anew.
# Needs `make peers` (.peers), and a minute.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../../.." && pwd)
work=$root/out/examples/kratos

rm -rf "$work" && mkdir -p "$work"
OMP_NUM_THREADS=1 "$root/.peers/bin/python" "$here/make.py" "$here/../calculix/cattaneo-mindlin_calculix.inp" "$work/result.csv" > "$work/kratos.log"
cp "$work/result.csv" "$work/made.json" "$here/"
