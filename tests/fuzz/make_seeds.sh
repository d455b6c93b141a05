#!/usr/bin/env bash
# make_seeds.sh SIMULATE DIR: seeds for the fuzz targets, DIR/scene, DIR/expression, DIR/mesh, DIR/checkpoint, out of
# the scenes of the tests. SIMULATE is the executable, which makes the checkpoint.
set -euo pipefail
simulate=$(realpath "$1") out=$2
scenes=$(cd "$(dirname "$0")/../experiments/scenes" && pwd)
mkdir -p "$out"/{scene,expression,mesh,checkpoint}
cp "$scenes"/valid/*.toml "$out/scene"
{ printf '#set end_time=2\n#set particle.p.mass=3\n' && cat "$scenes/valid/times.toml"; } >"$out/scene/set.toml"
number=0
for file in "$scenes"/wrong/*.txt; do # a case a file, without its head
  csplit -s -z -n 3 -f "$out/scene/$(basename "$file" .txt)_" "$file" '/^=== /' '{*}'
done
sed -i -e '/^=== /d' -e '/^! /d' -e 's/^\$ /#set /' "$out"/scene/*_???
grep -oh '"[^"]*[-+*/(?][^"]*"' "$scenes"/valid/*.toml "$scenes"/wrong/expressions.txt | sort -u |
  while read -r text; do
    printf '%s' "${text:1:-1}" >"$out/expression/$((number += 1))"
  done
for mesh in "$scenes"/valid/*.obj "$scenes"/wrong/*.obj; do
  { printf o && cat "$mesh"; } >"$out/mesh/$(basename "$mesh")"
done
{ printf s && cat "$scenes/valid/tetrahedron.stl"; } >"$out/mesh/tetrahedron.stl"
for name in method joints generators; do
  "$simulate" "$scenes/valid/$name.toml" --quiet --set end_time=0.1 --set method.dt=0.01 \
    --set 'output={interval=0.05,files=["energy"]}' --set method.integrator=implicit_euler_notes \
    --out "$out/run" >/dev/null 2>&1 || true
  [[ -f $out/run/checkpoint.bin ]] && mv "$out/run/checkpoint.bin" "$out/checkpoint/$name.bin"
  rm -rf "$out/run"
done
