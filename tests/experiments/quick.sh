#!/usr/bin/env bash
# quick.sh PROGRAM OUT: the quick preset runs, succeeds and leaves the promised files.
set -uo pipefail
program=$1
out=$2
name=$(basename "$program")
rm -rf "$out"
mkdir -p "$out"
cd "$out" || exit 1
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

expect 0 "Results are in" --preset quick --out .
[[ -s $name.csv ]] || fail "no $name.csv"
(($(wc -l <"$name.csv") > 1)) || fail "$name.csv holds no rows"
grep -q '"status": "ok"' manifest.json || fail "the manifest does not say ok"
ls ./*.svg >/dev/null 2>&1 || fail "no chart"
for svg in ./*.svg; do [[ -s ${svg%.svg}.gp ]] || fail "no script for $svg"; done
! ls ./*.tmp* >/dev/null 2>&1 || fail "temporary files are left over"
finish
