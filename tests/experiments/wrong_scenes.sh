#!/usr/bin/env bash
# wrong_scenes.sh SIMULATE SCENES: a scene that is refused ends with exit code 2 and its place, and leaves the results
# of an earlier run as they are.
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "$0")/expect.sh"
program=$(realpath "$1") scenes=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1

expect 0 'Results are in' "$scenes/valid/falling.toml" --out out --set method.dt=0.1
state() { find out -type f -exec sha256sum {} + | sort; }
before=$(state)
[[ -n $before ]] || fail "no results"

csplit -s -z -n 3 -f case_ "$scenes/wrong/syntax.txt" '/^=== /' '{*}'
csplit -s -z -n 3 -f key_ "$scenes/wrong/types.txt" '/^=== /' '{*}'
tried=0
for file in case_??? key_???; do
  sed -e '/^=== /d' -e '/^! /d' -e '/^\$ /d' "$file" >"$file.toml"
  expect 2 "bad_input: $file.toml:[0-9]*:[0-9]*: " "$file.toml" --out out
  expect 2 "bad_input: $file.toml:[0-9]*:[0-9]*: " "$file.toml" --out new
  tried=$((tried + 1))
done
((tried > 60)) || fail "only $tried scenes"
expect 2 "bad_input: --set drag=-1: scene: drag = -1 kg/s" "$scenes/valid/falling.toml" --set drag=-1 --out out
expect 2 'no such file\|No such file' none.toml --out out
expect 2 'expected a readable file' . --out out
[[ $(state) == "$before" ]] || fail "an earlier result has changed"
[[ ! -e new ]] || fail "a refused scene has written into --out"
finish
