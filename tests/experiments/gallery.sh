#!/usr/bin/env bash
# gallery.sh SIMULATE SCENE.toml OUT: a scene of the gallery has no problems, its quick form runs and writes the files
# its [output] asks for.
set -uo pipefail
program=$1
scene=$2
out=$3
name=$(basename "$scene" .toml)
rm -rf "$out"
mkdir -p "$out"
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
cd "$out" || exit 1

for key in title end_time quick_end_time integrator dt; do
  [[ $key == end_time ]] && grep -q '^model = ' "$scene" && continue # it has its model's
  grep -q "^$key = " "$scene" || fail "no $key"
done
head -1 "$scene" | grep -q '^# [A-Z]' || fail "no comment at the top that says what to look at"
grep '^#' "$scene" | grep -q '\.csv\|ParaView' || fail "the comment names no file to look into"

expect 0 "no problems" "$scene" --validate
expect 0 "Results are in" "$scene" --preset quick --out run
grep -q '"status": "ok"' run/manifest.json || fail "the manifest does not say ok"
words=$(sed -n 's/^files = \[\(.*\)\]$/\1/p' "$scene" | tr -d '",')
for word in ${words:-states energy}; do
  case $word in
    npy) file=run/trajectory.npy ;;
    vtu) file=$(find run -maxdepth 1 -name '*.pvd') ;;
    *) file=run/$word.csv ;;
  esac
  [[ -n $file && -s $file ]] || fail "no file for '$word'"
done
written=$(find run -maxdepth 1 \( -name '*.csv' -o -name '*.npy' -o -name '*.pvd' \) | wc -l)
((written == $(wc -w <<<"${words:-states energy}"))) || fail "$written files, asked for: ${words:-states energy}"
((failures == 0)) && echo "$name is fine"
finish
