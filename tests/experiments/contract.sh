#!/usr/bin/env bash
# contract.sh PROGRAM: what every experiment promises about its command line, without running it.
set -uo pipefail
program=$1
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

expect 0 "--set" --help
expect 0 "Does not model" --help
expect 0 "" --list
expect 0 "settings" --dry-run
expect 0 "settings" --dry-run --preset full
expect 0 "feder $(basename "$program") [0-9]" --version
expect 2 "unknown setting 'no_such_key'; nearest is" --set no_such_key=1
expect 2 "expected key=value" --set no_equals_sign
expect 2 "expected quick or full; nearest is 'quick'" --preset quik
expect 2 "--no-such-option" --no-such-option
expect 2 "threads" --threads 0
expect 2 "seed" --seed minus_one

# None of these runs anything.
[[ -z $(ls -A) ]] || fail "files were written without a run: $(ls)"
finish
