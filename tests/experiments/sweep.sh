#!/usr/bin/env bash
# sweep.sh SWEEP FAKE_SIMULATE: endings, repetition, interruption, shards and bad input of the sweep, shown with a
# program that only pretends to simulate.
set -uo pipefail
program=$1
fake=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

export FAKE_SIMULATE_LOG=$folder/starts
echo 'end_time = 1' >rope.toml

sweep() { "$program" rope.toml --simulate "$fake" --quiet "$@"; }
starts() { if [[ -f starts ]]; then wc -l <starts; else echo 0; fi; }
# Without the seconds, which the fake makes different in every run.
steady() { sed -E 's/,[0-9]+\.5,,,$/,,,,/' "$1/sweep.csv"; }
same() { cmp -s <(steady "$1") <(steady "$2") || fail "$3: $(diff <(steady "$1") <(steady "$2") | head -5)"; }
rows() { grep -c "$2" "$1/sweep.csv"; }
# wait_until COMMAND...: at most ten seconds.
wait_until() {
  local _
  for _ in $(seq 500); do
    if "$@"; then return; fi
    sleep 0.02
  done
  fail "waited in vain for: $*"
}
# shellcheck disable=SC2317 # both are called through wait_until
started() { (($(starts) >= $1)); }
# shellcheck disable=SC2317
has_outcomes() { (($(find "$1/cases" -name outcome.json 2>/dev/null | wc -l) >= $2)); }
fake_runs() {
  local process
  for process in /proc/[0-9]*/exe; do
    if [[ $process -ef $fake ]]; then return; fi
  done
  return 1
}
no_fake_runs() { ! fake_runs; }

# Every ending is a row, and none of them stops the sweep.
sweep --grid do=ok,diverged,crash,hang,deaf,nothing,nothing3,input,memory,disk,preempted,garbage,liar --jobs 4 \
  --timeout 0.5 --out endings || fail "bad cases end the sweep with $?"
[[ $(wc -l <endings/sweep.csv) == 14 ]] || fail "not one row per case: $(cat endings/sweep.csv)"
code=0
sweep --grid do=input --grid n=1,2 --out refused 2>refused.txt || code=$?
[[ $code == 2 ]] || fail "a sweep of which every case is refused ends with $code"
grep -q "every case was refused, the first: the rope has no mass" refused.txt || fail "$(cat refused.txt)"
[[ $(rows refused bad_input) == 2 ]] || fail "refused cases are no rows: $(cat refused/sweep.csv)"
row() { grep -Eq "^[0-9a-f]{16},$1,(rope,fake,,0.5,)?,*$2" endings/sweep.csv || fail "$1: $(grep ",$1," endings/sweep.csv)"; }
row ok "ok,,2,0.0833"
row diverged 'diverged,"energy, 1e9 J at t = 0.1 s",2,'
row crash "internal_error,killed by signal 11 (.Segmentation fault.),"
row hang "limit_reached,no end after 0.5 s,"
row deaf "limit_reached,no end after 0.5 s,"
row nothing "internal_error,exit code 0 without a manifest,"
row nothing3 "internal_error,exit code 3 without a manifest,"
row input "bad_input,the rope has no mass,"
row memory "out_of_memory,out of memory,"
row disk "io_error,no space,"
row preempted "interrupted,stopped,"
row garbage "internal_error,\"the manifest cannot be read"
row liar "internal_error,\"exit code 3, but the manifest says 'ok'\","
grep -q '"status": "ok"' endings/manifest.json || fail "the manifest of a whole sweep does not say ok"
wait_until no_fake_runs

# The same again starts what deserves it: disk and preempted; hang and deaf too once they get more time.
: >starts
sweep --grid do=ok,diverged,crash,hang,deaf,nothing,nothing3,input,memory,disk,preempted,garbage,liar \
  --timeout 0.4 --out endings || fail "the second run fails"
[[ $(starts) == 2 ]] || fail "a second run started $(starts) cases, expected 2"
: >starts
sweep --grid do=ok,hang,deaf,crash --timeout 0.6 --out endings || fail "the third run fails"
[[ $(starts) == 2 ]] || fail "a longer limit started $(starts) cases, expected 2"
[[ $(wc -l <endings/sweep.csv) == 5 ]] || fail "the table is not that of the new grid"

# The table does not depend on the number of children, nor on the order in which they end.
sweep --grid method.dt=1e-3:1e-1:9 --grid do=ok,diverged --reference --out one || fail "--jobs 1 fails"
sweep --grid method.dt=1e-3:1e-1:9 --grid do=ok,diverged --reference --jobs 4 --out four || fail "--jobs 4 fails"
same one four "--jobs 1 and 4 differ"
[[ $(rows one ',9.9999999999999998e-13,') == 18 ]] || fail "--reference does not reach the cases"
sweep --grid milliseconds=300,200,100,1 --jobs 4 --out order || fail "the delays fail"
[[ $(tail -n +2 order/sweep.csv | cut -d, -f2 | paste -sd,) == 300,200,100,1 ]] || fail "rows in the order of their ends"
hash_of() { grep results_hash "$1/manifest.json"; }
[[ $(hash_of one) == "$(hash_of four)" ]] || fail "the results hash depends on --jobs"

# Nothing is run again without need; a changed scene, setting or preset is a need.
: >starts
sweep --grid method.dt=1e-3:1e-1:9 --grid do=ok,diverged --reference --out one || fail "a finished sweep fails"
[[ $(starts) == 0 ]] || fail "a finished sweep starts $(starts) cases"
same one four "a finished sweep changes its table"
sweep --grid method.dt=0.1,0.2 --out needs
: >starts
sweep --grid method.dt=0.1,0.2,0.3 --out needs
[[ $(starts) == 1 ]] || fail "a longer grid starts $(starts) cases, expected 1"
sweep --grid method.dt=0.1,0.2,0.3 --set end_time=2 --out needs
[[ $(starts) == 4 ]] || fail "a new --set starts $(($(starts) - 1)) cases, expected 3"
sweep --grid method.dt=0.1,0.2,0.3 --set end_time=2 --preset quick --out needs
[[ $(starts) == 7 ]] || fail "a new preset starts $(($(starts) - 4)) cases, expected 3"
echo '# changed' >>rope.toml
sweep --grid method.dt=0.1,0.2,0.3 --set end_time=2 --preset quick --out needs
[[ $(starts) == 10 ]] || fail "a new scene starts $(($(starts) - 7)) cases, expected 3"

# Values reach the program as they are, and no folder but --out is touched.
# shellcheck disable=SC2016
printf 'do,note\nok,../../up\nok,$(touch pwned)\nok,"a ""b"", c; ls"\n' >list.csv
sweep --list list.csv --out odd || fail "odd values fail"
[[ $(rows odd ',ok,') == 3 && ! -e pwned && ! -e up ]] || fail "odd values: $(cat odd/sweep.csv)"
[[ $(find odd/cases -mindepth 1 -maxdepth 1 | wc -l) == 3 ]] || fail "odd folders: $(ls odd/cases)"

# kill -9 in the middle loses the running cases and nothing else; their processes die with the sweep.
grid=(--grid "method.dt=1e-3:1e-1:12" --set milliseconds=100)
sweep "${grid[@]}" --jobs 2 --out whole || fail "the undisturbed sweep fails"
: >starts
"$program" rope.toml --simulate "$fake" --quiet "${grid[@]}" --jobs 2 --out "$folder/killed" &
child=$!
wait_until has_outcomes killed 4
fake_runs || fail "nothing runs in the middle of a sweep"
kill -KILL "$child"
wait "$child" 2>/dev/null
wait_until no_fake_runs
before=$(starts)
finished=$(find killed/cases -name outcome.json | wc -l)
((finished >= 4 && finished < 12)) || fail "$finished cases were finished at kill -9"
((before - finished <= 2)) || fail "kill -9 loses $((before - finished)) cases, expected at most 2"
grep -q '"status": "interrupted"' killed/manifest.json || fail "a killed sweep does not say so"
"$program" merge killed --out nowhere >printed 2>&1
[[ $? == 4 && ! -e nowhere/sweep.csv ]] || fail "a killed sweep passes for a whole one"
touch killed/sweep.csv.tmp1
sweep "${grid[@]}" --jobs 2 --out "$folder/killed" || fail "a killed sweep cannot be resumed"
[[ $(($(starts) - before)) == $((12 - finished)) ]] || fail "resumed: $(($(starts) - before)) of $((12 - finished)) cases"
same whole killed "a resumed sweep differs"
! find killed -name '*.tmp[0-9]*' | grep -q . || fail "temporary files are left over"

# A child that never ends dies with a killed sweep all the same.
: >starts
"$program" rope.toml --simulate "$fake" --quiet --grid do=hang,deaf --jobs 2 --out orphans &
child=$!
wait_until started 2
kill -KILL "$child"
wait "$child" 2>/dev/null
wait_until no_fake_runs

# Ctrl-C ends the children, writes what there is, exit code 130.
"$program" rope.toml --simulate "$fake" --grid do=ok,hang,deaf --jobs 3 --out "$folder/stopped" >printed 2>&1 &
child=$!
wait_until has_outcomes stopped 1
# An asynchronous child of a script ignores SIGINT until it installs a handler of its own, as this one does.
kill -INT "$child"
wait "$child"
[[ $? == 130 ]] || fail "an interrupted sweep does not exit with 130: $(cat printed)"
no_fake_runs || fail "children survive Ctrl-C"
grep -q '"status": "interrupted"' stopped/manifest.json || fail "the manifest does not say interrupted"
[[ $(rows stopped ,ok,) == 1 && $(wc -l <stopped/sweep.csv) == 2 ]] || fail "interrupted table: $(cat stopped/sweep.csv)"

# One sweep at a time in a folder.
"$program" rope.toml --simulate "$fake" --quiet --grid do=hang --out busy &
child=$!
wait_until test -s busy/manifest.json
expect 4 "io_error: another sweep is running in 'busy'" rope.toml --simulate "$fake" --grid do=ok --out busy
kill -TERM "$child"
wait "$child"

# A scene that changes under way ends the sweep: its table would be one of two scenes.
cp rope.toml moving.toml
: >starts
"$program" moving.toml --simulate "$fake" --grid milliseconds=400,401 --out moving >printed 2>&1 &
child=$!
wait_until started 1
echo '# changed' >>moving.toml
wait "$child"
[[ $? == 2 ]] || fail "a changed scene goes unnoticed: $(cat printed)"
grep -q "the scene changed while its sweep ran" printed || fail "changed scene: $(cat printed)"

# The shards of a sweep make the whole of it.
grid=(--grid "method.dt=1e-3:1e-1:7" --grid "do=ok,diverged")
sweep "${grid[@]}" --out unsharded || fail "unsharded"
for i in 1 2 3; do sweep "${grid[@]}" --shard $i/3 --out part$i || fail "shard $i"; done
"$program" merge part1 part2 part3 --out merged >/dev/null || fail "merge fails"
same unsharded merged "the shards differ from the whole"
"$program" merge part3 part1 part2 --out merged2 --quiet || fail "merge in another order fails"
cmp -s merged/sweep.csv merged2/sweep.csv || fail "merge depends on the order of its folders"
[[ $(hash_of unsharded) == "$(hash_of merged)" ]] || fail "the results hash depends on sharding"

# A missing or repeated shard is refused, with names and the command that helps.
"$program" merge part1 part3 --out hole >printed 2>&1
[[ $? == 4 && ! -e hole ]] || fail "a missing shard is not refused: $(cat printed)"
[[ $(grep -c "^  [0-9a-f]\{16\}  method.dt=" printed) == 5 ]] || fail "5 missing cases are not named: $(cat printed)"
tail -n +2 part2/sweep.csv | cut -d, -f1 | while read -r id; do grep -q "$id" printed || echo "$id"; done >unnamed
[[ ! -s unnamed ]] || fail "missing, but not named: $(cat unnamed)"
command=$(grep -- "--shard 2/3 --out DIR" printed) || fail "no command that runs the missing shard: $(cat printed)"
rm -r part2
eval "\"$program\" ${command#*sweep} --simulate \"$fake\" --quiet" || fail "the printed command fails: $command"
"$program" merge part1 DIR part3 --out mended --quiet || fail "the printed command does not mend the sweep"
same unsharded mended "the mended sweep differs"
expect 4 "there twice:" merge part1 DIR part3 part1 --out twice
[[ ! -e twice ]] || fail "a refused merge writes"
sweep "${grid[@]}" --set end_time=3 --shard 2/3 --out other
expect 2 "hold different sweeps: the values of --set differ" merge part1 other part3 --out mixed
expect 4 "cannot read" merge part1 nothing_here --out mixed
expect 2 "is one of the shards" merge part1 DIR part3 --out part1
expect 2 "--out" merge part1
expect 2 "folders" merge --out mixed
[[ ! -e mixed ]] || fail "a refused merge writes"

# Dry run: the number of cases, each case, the time once it can be known.
: >starts
expect 0 "^14 cases, 5 of them in shard 2/3" rope.toml "${grid[@]}" --shard 2/3 --dry-run --out dry
expect 0 "method.dt=0.001 do=diverged" rope.toml "${grid[@]}" --shard 2/3 --dry-run --out dry
expect 0 "no estimate" rope.toml "${grid[@]}" --dry-run --out dry
expect 0 "^0 to do, .* s each, 2 at a time: about 0 s" rope.toml "${grid[@]}" --jobs 2 --dry-run --out unsharded
[[ $(starts) == 0 && ! -e dry ]] || fail "--dry-run runs something"

# Bad input.
expect 0 "SBATCH --array" --help
expect 0 "feder sweep [0-9]" --version
expect 2 "scene" --grid a=1
expect 2 "--no-such-option" rope.toml --grid a=1 --no-such-option
expect 2 "expected --grid key=values or --list" rope.toml
expect 2 "no value" rope.toml --grid a=
expect 2 "expected key=value" rope.toml --grid a
expect 2 "'a' is swept twice" rope.toml --grid a=1 --grid a=2
expect 2 "a: the key is set twice" rope.toml --grid b=1 --set a=1 --set a=2
expect 2 "a: the key is swept as well" rope.toml --grid a=1 --set a=1
expect 2 "expected i/n" rope.toml --grid a=1 --shard 4/3
expect 2 "jobs" rope.toml --grid a=1 --jobs 0
expect 2 "threads" rope.toml --grid a=1 --threads 0
expect 2 "timeout" rope.toml --grid a=1 --timeout 0
expect 2 "timeout" rope.toml --grid a=1 --timeout nan
expect 2 "preset" rope.toml --grid a=1 --preset quik
expect 2 "there is no file 'missing.toml'" missing.toml --grid a=1
expect 2 "there is no file 'missing.csv'" rope.toml --list missing.csv
expect 2 "excludes" rope.toml --list list.csv --grid a=1
expect 2 "is not a program that can be run" rope.toml --grid a=1 --simulate ./missing
expect 4 "cannot create the folder" rope.toml --grid a=1 --simulate "$fake" --out rope.toml/below
[[ ! -e results ]] || fail "bad input writes results"
echo 'not a program' >text && chmod +x text
"$program" rope.toml --grid a=1 --simulate ./text --out text_out --quiet || fail "a text file as program"
[[ $(rows text_out 'internal_error,the program cannot be run') == 1 ]] || fail "text: $(cat text_out/sweep.csv)"
finish
