#!/usr/bin/env bash
# simulate_stops.sh SIMULATE KILLS: Ctrl-C, SIGTERM, KILLS random kill -9, a full disk, a read-only folder, a closed
# pipe. Whatever happens, files under final names are whole, and --resume gives bitwise the undisturbed results.
set -uo pipefail
program=$1
kills=$2
folder=$(mktemp -d)
mounted=
trap '[[ -z $mounted ]] || umount "$folder/small"; rm -rf "$folder"' EXIT
cd "$folder" || exit 1
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
# shellcheck source=tests/experiments/simulate_scenes.sh
source "$(dirname "${BASH_SOURCE[0]}")/simulate_scenes.sh"
write_scene

started=$(date +%s%N)
"$program" scene.toml --quiet --out whole || fail "the undisturbed run fails"
milliseconds=$((($(date +%s%N) - started) / 1000000))
whole_files whole "undisturbed"
manifest_says whole ok

# A signal ends the run after its step, with complete files; a resumed run knows nothing of it.
# shellcheck disable=SC2317 # called through wait_until
has_frames() { (($(find "$1/frames" -name '*.vtu' 2>/dev/null | wc -l) >= $2)); }
for signal in INT TERM; do
  "$program" scene.toml --out "$folder/$signal" >printed 2>&1 &
  child=$!
  wait_until has_frames "$signal" 30
  kill -"$signal" "$child"
  wait "$child"
  [[ $? == 130 ]] || fail "SIG$signal: exit code not 130: $(cat printed)"
  grep -q "simulate: interrupted:" printed || fail "SIG$signal: $(cat printed)"
  manifest_says "$signal" interrupted
  whole_files "$signal" "SIG$signal"
  ! find "$signal" -name '*.part' -o -name '*.tmp*' | grep -q . || fail "SIG$signal: $(ls "$signal")"
  frames=$(grep -o '"frames": [0-9]*' "$signal/manifest.json" | grep -o '[0-9]*')
  ((frames >= 30 && frames < 201)) || fail "SIG$signal: stopped after $frames frames"
  [[ $(wc -l <"$signal/energy.csv") == $((frames + 1)) ]] || fail "SIG$signal: $frames frames, but another energy.csv"
  "$program" scene.toml --quiet --resume --out "$signal" || fail "SIG$signal: --resume ends with $?"
  same_results whole "$signal" "resumed after SIG$signal"
  manifest_says "$signal" ok
done

# kill -9 at any time.
RANDOM=1
resumed=0
for ((i = 0; i < kills; ++i)); do
  rm -rf killed
  "$program" scene.toml --quiet --out killed &
  child=$!
  delay=$((RANDOM * (milliseconds + 20) / 32768))
  sleep "$(printf '0.%03d' $((delay % 1000)))"
  ((delay < 1000)) || sleep $((delay / 1000))
  kill -KILL "$child" 2>/dev/null
  wait "$child" 2>/dev/null
  if [[ -d killed ]]; then whole_files killed "kill -9 after $delay ms"; fi
  "$program" scene.toml --quiet --resume --out killed 2>message
  code=$?
  if [[ $code == 4 && ! -e killed/checkpoint.bin ]]; then
    grep -q "run without --resume" message || fail "nothing to resume: $(cat message)"
    continue
  fi
  [[ $code == 0 ]] || fail "--resume after kill -9 after $delay ms ends with $code: $(cat message)"
  find killed -name '*.tmp*' -delete # what a killed program cannot remove itself
  same_results whole killed "resumed after kill -9 after $delay ms"
  resumed=$((resumed + 1))
done
((2 * resumed >= kills)) || fail "only $resumed of $kills killed runs could be resumed"
echo "$resumed of $kills killed runs resumed, the others had not begun"

# A full disk: what was there stays, what came so far can be read.
mkdir small
if mount -t tmpfs -o size=2m tmpfs small 2>/dev/null; then
  mounted=yes
  "$program" scene.toml --quiet --preset quick --out small/before || fail "a run on the small disk ends with $?"
  cp -r small/before before
  "$program" scene.toml --quiet --out small/full 2>message
  [[ $? == 4 ]] || fail "a full disk does not end with exit code 4"
  grep -q "simulate: io_error: .*No space left" message || fail "a full disk: $(cat message)"
  same_results before small/before "a full disk"
  whole_files small/full "a full disk"
  (($(wc -l <small/full/energy.csv) > 10)) || fail "a full disk costs the frames before"
  umount small && mounted=
else
  echo "not shown here: a full disk (mounting is not allowed)"
fi
[[ ! -c /dev/full ]] || { "$program" scene.toml --preset quick --out full_out >/dev/full 2>&1; [[ -s full_out/manifest.json ]] || fail "a full standard output costs the results"; }

# A folder that cannot be written, a name that is a file.
touch file
expect 4 "io_error: cannot create the folder" scene.toml --preset quick --out file/below
mkdir -p fixed/scene
chmod a-w fixed/scene
if ! touch fixed/scene/x 2>/dev/null; then
  expect 4 "io_error: cannot create 'fixed/scene/" scene.toml --preset quick --out fixed/scene
  [[ -z $(ls -A fixed/scene) ]] || fail "files in a read-only folder"
else
  rm -f fixed/scene/x
  if chmod u+w fixed/scene && mount -t tmpfs -o ro tmpfs small 2>/dev/null; then
    mounted=yes
    expect 4 "io_error: cannot create" scene.toml --preset quick --out small/run
    umount small && mounted=
  else
    echo "not shown here: a read-only folder (this user writes everywhere)"
  fi
fi
chmod u+w fixed/scene

# A reader that goes away costs its lines, not the results.
"$program" scene.toml --preset quick --out piped 2>/dev/null | true
[[ ${PIPESTATUS[0]} == 0 ]] || fail "a closed pipe ends the run with ${PIPESTATUS[0]}"
manifest_says piped ok
"$program" scene.toml --preset quick --quiet --out unpiped || fail "the quick run fails"
same_results piped unpiped "a closed pipe"
finish
