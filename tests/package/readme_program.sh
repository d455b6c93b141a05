#!/usr/bin/env bash
# The C++ program README.md shows compiles against the installed package, runs, and prints something.
# shellcheck source=tests/package/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

readme=$FEDER_SOURCE/README.md
program=$FEDER_PACKAGE_WORK/readme_program.cpp
[[ -f $readme ]] || fail "$readme does not exist"
awk '/^```cpp[[:space:]]*$/ && !inside { inside = 1; next } inside && /^```/ { exit } inside' "$readme" >"$program"
[[ -s $program ]] || fail "$readme has no block that starts with \`\`\`cpp"
grep -q 'int main' "$program" || fail "the first cpp block of $readme is not a whole program: it has no main"
closed=$(awk '/^```cpp[[:space:]]*$/ && !inside { inside = 1; next } inside && /^```/ { print "closed"; exit }' "$readme")
[[ $closed == closed ]] || fail "the first cpp block of $readme is never closed"

build=$FEDER_PACKAGE_WORK/readme_build
build_consumer "$here/consumer" "$build" "-DREADME_PROGRAM=$program"
cd "$FEDER_PACKAGE_WORK"
output=$("$build/readme_program") || fail "the README's program ended with code $?"
[[ -n $output ]] || fail "the README's program prints nothing"
printf '%s\n' "$output"
