#!/usr/bin/env bash
# CalculiX on the deck that halfplane exports, without an edit: the deck and the result in this folder, made anew.
# Needs `make` (.venv) and `make peers` (ccx), and a minute or two.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../../../.." && pwd)
work=$root/out/examples/calculix
deck=cattaneo-mindlin_calculix

rm -rf "$work" && mkdir -p "$work"
cd "$work"
"$root/.venv/bin/python" -m reports export cattaneo-mindlin --steps-per-cycle 24 --cycles 1 --out deck --quiet > /dev/null
cp "deck/$deck.inp" .
TIMEFORMAT='%U'
seconds=$({ time OMP_NUM_THREADS=1 CCX_NPROC_RESULTS=1 ccx -i "$deck" > ccx.log; } 2>&1)
increments=$(awk '$1 ~ /^[0-9]+$/ && NF == 7 && $4 !~ /U/ && $3 !~ /U/' "$deck.sta" | wc -l)
version=$({ ccx -v || true; } | awk '/[Vv]ersion/ {print $NF}')

cp "$deck.inp" "$here/"
xz -9 --keep --force --stdout "$deck.frd" > "$here/$deck.frd.xz"
xz -9 --keep --force --stdout "$deck.dat" > "$here/$deck.dat.xz"
printf '{"code": "CalculiX %s", "seconds": %s, "increments": %s}\n' "$version" "$seconds" "$increments" > "$here/made.json"
