#!/usr/bin/env bash
# reference_page.sh SIMULATE PAGE.md: the committed page is what the program prints, and its examples run.
set -uo pipefail
program=$1
page=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

"$program" --keys >now.md || fail "--keys ends with $?"
diff "$page" now.md >difference ||
  fail "the page is out of date: $(head -6 difference)
renew it with: simulate --keys > models/scenes/README.md"

awk '/^```toml$/ { file = "example" ++count ".toml"; next } /^```$/ { file = "" } file { print > file }' now.md
[[ $(ls example*.toml) == $'example1.toml\nexample2.toml' ]] || fail "not two examples: $(ls)"
for example in example*.toml; do
  expect 0 "no problems" "$example" --validate
  expect 0 "Results are in" "$example" --preset quick --out "${example%.toml}"
  grep -q '"status": "ok"' "${example%.toml}/manifest.json" || fail "$example: the manifest does not say ok"
done
finish
