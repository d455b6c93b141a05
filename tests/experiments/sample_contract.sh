#!/usr/bin/env bash
# sample_contract.sh PROGRAM PAGE: exit codes, silence, interruption and files, shown on the sample experiment.
set -uo pipefail
program=$1
page=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

# --quiet prints nothing at all.
"$program" --quiet --out quiet >printed 2>&1 || fail "--quiet fails"
[[ ! -s printed ]] || fail "--quiet prints: $(cat printed)"

# Equal runs give equal results.
"$program" --quiet --out again || fail "the second run fails"
cmp -s quiet/sample_experiment.csv again/sample_experiment.csv || fail "two runs differ"

# The script alone draws the same picture.
cp quiet/sample.svg before.svg
(cd quiet && rm sample.svg && gnuplot sample.gp) || fail "gnuplot refuses the script"
cmp -s before.svg quiet/sample.svg || fail "the script draws another picture"

# Exit codes, with the table written whatever happened to the run.
expect 3 "not_converged: the judge gave up" --set method=bad --out bad
grep -q '"status": "not_converged"' bad/manifest.json || fail "the manifest hides a failure"
[[ -s bad/sample_experiment.csv ]] || fail "a failure costs the table"
expect 1 "internal_error: a broken precondition" --set method=throw --out throw
[[ -s throw/sample_experiment.csv ]] || fail "an internal error costs the table"
expect 2 "expected positive time steps" --set dt=-1 --out wrong
[[ ! -e wrong/manifest.json ]] || fail "bad input writes results"
expect 2 "setting 'method': got 'god', expected one of good, bad, slow, throw; nearest is 'good'" --set method=god
expect 2 "setting 'dt': got 'x', expected finite numbers" --set dt=x
touch plain_file
expect 4 "io_error: cannot create the folder" --out plain_file/below

# Without gnuplot the numbers are there all the same.
mkdir empty
PATH=$folder/empty "$program" --quiet --out no_gnuplot >/dev/null 2>message
[[ $? == 4 ]] || fail "a missing gnuplot does not end with exit code 4"
grep -q "cannot run gnuplot" message || fail "the message does not name gnuplot: $(cat message)"
[[ -s no_gnuplot/sample_experiment.csv ]] || fail "a missing gnuplot costs the table"
grep -q '"status": "io_error"' no_gnuplot/manifest.json || fail "the manifest hides a missing chart"
! ls no_gnuplot/*.svg* >/dev/null 2>&1 || fail "there is a chart without gnuplot"

# Ctrl-C leaves complete files and exit code 130.
"$program" --set method=slow --out slow >slow.log 2>&1 &
child=$!
for _ in $(seq 200); do
  if grep -q started slow.log; then break; fi
  sleep 0.02
done
kill -INT "$child" 2>/dev/null || kill -TERM "$child"
wait "$child"
[[ $? == 130 ]] || fail "an interrupted run does not exit with 130"
grep -q '"status": "interrupted"' slow/manifest.json || fail "the manifest does not say interrupted"
(($(wc -l <slow/sample_experiment.csv) >= 2)) || fail "the interrupted table is empty"

# A closed pipe does not cost the results.
"$program" --out piped 2>/dev/null | true
[[ -s piped/manifest.json ]] || fail "a closed pipe costs the manifest"

# The page needs nothing but itself.
"$page" . >/dev/null || fail "no page"
! grep -Eq '(src|href)="(https?:)?//' index.html || fail "the page needs the network"
grep -q 'Everything &lt;else&gt;' index.html || fail "the page does not escape text"
finish
