#!/usr/bin/env bash
# simulate.sh SIMULATE SWEEP PAGE: command line, repetition, --rerun, --reference, bad scenes, and a sweep of real runs.
set -uo pipefail
program=$1
sweep=$2
page=$3
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
export XDG_CACHE_HOME=$folder/cache
# shellcheck source=tests/experiments/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
# shellcheck source=tests/experiments/simulate_scenes.sh
source "$(dirname "${BASH_SOURCE[0]}")/simulate_scenes.sh"
mkdir scenes && cd scenes && write_scene && cd ..
scene=scenes/scene.toml

# Questions write nothing.
before=$(find . | sort)
expect 0 "Exit codes: 0 done" --help
expect 0 "Does not model" --help
expect 0 "feder simulate [0-9]" --version
expect 0 "integrator implicit_euler_newton" --list
expect 0 "route dual_blocks" --list
expect 0 "checkpoint_frames" --keys
expect 0 "scene: 64 particles and points, 1 bodies, .* 2 s: no problems" $scene --validate
expect 0 "recommended" $scene --explain
expect 0 "integrator implicit_euler_geometric, route kkt, dt 0.0005 s, 201 frames into results/scenes/scene$" $scene --dry-run
expect 0 "6 frames into here$" $scene --dry-run --preset quick --out here
"$program" $scene --validate --quiet >printed 2>&1 || fail "--validate --quiet fails"
[[ ! -s printed ]] || fail "--quiet prints: $(cat printed)"
rm -f printed
[[ $(find . | sort) == "$before" ]] || fail "a question writes: $(diff <(echo "$before") <(find . | sort))"

# Bad input.
expect 2 "no scene file"
expect 2 "--no-such-option" $scene --no-such-option
expect 2 "missing.toml" missing.toml
expect 2 "preset" $scene --preset quik
expect 2 "threads" $scene --threads 0
expect 2 "implicit_euler_nots" $scene --integrator implicit_euler_nots
expect 2 "method: route" $scene --route lu
expect 2 "method: dt = -1" $scene --dt -1
expect 2 "no_such_key" $scene --set no_such_key=1
expect 2 "expected a step that the clock can resolve" $scene --dt 1e-300
expect 2 "expected a step that the clock can resolve" $scene --dt 1e-300 --validate
expect 2 "output: interval = 1.*e-09 s, expected at most 1e7 frames" $scene --set output.interval=1e-9
expect 2 "takes scene and settings from the manifest" $scene --rerun manifest.json
expect 4 "cannot read" --rerun manifest.json
[[ ! -e results ]] || fail "bad input writes results"

# Without --out results go where they do not disturb the page of the experiments.
expect 0 "Results are in results/scenes/scene$" $scene --preset quick
mkdir results/beside && cp results/scenes/scene/manifest.json results/beside
"$page" results >/dev/null || fail "no page"
! grep -q "cannot be shown" results/index.html || fail "simulate's results break the page"

# Twice the same, whatever the number of threads, on a cloth large enough for dense blocks in its factor.
sed '/^\[\[body\]\]/,/^\[method\]/{/^\[method\]/!d}' $scene >cloth.toml
large=(--set 'cloth.cloth.count=[30,30]' --set end_time=0.005 --set output.interval=0.001 --quiet --integrator
  implicit_euler_notes)
for route in primal dual; do
  for folder_of in "$route 1" "${route}_again 1" "${route}_two 2"; do
    read -r out threads <<<"$folder_of"
    "$program" cloth.toml "${large[@]}" --route $route --threads "$threads" --out "$out" || fail "$out fails"
  done
  same_results $route ${route}_again "two runs on route $route"
  same_results $route ${route}_two "1 and 2 threads on route $route"
done

# The short options are those of --set.
"$program" $scene --preset quick --quiet --integrator leapfrog --dt 1e-4 --route dual --out short || fail "short options fail"
"$program" $scene --preset quick --quiet --set method.integrator=leapfrog --set method.route=dual --set method.dt=1e-4 \
  --out long || fail "--set fails"
same_results short long "short options"
grep -q '"integrator": "leapfrog"' short/manifest.json || fail "the manifest does not name the integrator"

# --rerun
expect 0 "bitwise those of the manifest" --rerun short/manifest.json --out again
same_results short again "--rerun"
expect 0 "Results are in results/scenes/scene_rerun" --rerun again/manifest.json
cp -r short changed && echo '# changed' >>changed/scene.toml
expect 2 "the scene beside it has another hash" --rerun changed/manifest.json --out nowhere
[[ ! -e nowhere ]] || fail "a refused --rerun writes"
cp -r short other && sed -i -E 's/("results_hash": ")[0-9a-f]+/\10123456789abcdef/' other/manifest.json
expect 3 "inconsistent: results hash .*, the manifest says 0123456789abcdef" --rerun other/manifest.json --out again
echo '[]' >no_manifest.json
expect 2 "expected a manifest.json of simulate" --rerun no_manifest.json
rm -rf broken && cp -r short broken && sed -i '/"hash"/d' broken/manifest.json
expect 2 "expected a manifest.json of simulate" --rerun broken/manifest.json

# A checkpoint of other settings is not gone on from, and nothing is touched.
cp -r short kept
expect 2 "of a scene with hash" $scene --preset quick --integrator rk4 --resume --out short
same_results kept short "a refused --resume"
expect 4 "run without --resume" $scene --preset quick --resume --out never
[[ ! -e never ]] || fail "a refused --resume writes"
# A finished run has nothing left to do, and says the same.
expect 0 "500 steps of at most 0.0001 s" $scene --preset quick --integrator leapfrog --dt 1e-4 --route dual --resume --out short
"$program" $scene --preset quick --quiet --set method.integrator=leapfrog --set method.route=dual --set method.dt=1e-4 \
  --resume --out long || fail "a finished run cannot be resumed"
same_results kept long "a finished run, resumed"

# Failures are results: exit code, manifest, and the frames before.
cat >spring.toml <<'TOML'
end_time = 2
gravity = [0, 0, -9.81]
[[point]]
name = "hook"
position = [0, 0, 0]
[[particle]]
name = "p"
mass = 0.5
position = [0.3, 0, -1]
[[spring]]
name = "s"
between = ["hook", "p"]
stiffness = 400
length = 1
[method]
dt = 1e-3
integrator = "leapfrog"
TOML
expect 3 "simulate: diverged: .* t = " spring.toml --integrator explicit_euler --dt 0.05 --set end_time=40 --out diverged
manifest_says diverged diverged
whole_files diverged diverged
(($(wc -l <diverged/energy.csv) > 3)) || fail "a diverged run has no frames: $(cat diverged/energy.csv)"
expect 3 "simulate: diverged: " --rerun diverged/manifest.json --out again
expect 2 "spring 's': this rigid distance is open by 0.0440" spring.toml --set spring.s.stiffness=rigid --out open
[[ ! -e open ]] || fail "a refused scene leaves files"
expect 3 "simulate: refused: explicit_euler .* rigid" spring.toml --integrator explicit_euler \
  --set spring.s.stiffness=rigid --set spring.s.length=1.044030650891055 --out refused
manifest_says refused refused
expect 5 "simulate: limit_reached: wall-clock budget" spring.toml --set end_time=1e6 --set output.interval=5e5 \
  --set method.max_seconds=0.1 --out limit
manifest_says limit limit_reached
sed 's/position = \[0, 0, 0\]/motion = ["sqrt(0.5 - t)", 0, 0]/' spring.toml >nan.toml
expect 3 "simulate: non_finite: .* t = 0.5" nan.toml --out nan
manifest_says nan non_finite
whole_files nan "a bad number"

# The judge.
expect 0 "error [0-9.e-]* m against the judge, whose own is [0-9.e-]* m" spring.toml --reference --out judged
python3 - judged/manifest.json <<'PY' || fail "error in the manifest: $(cat judged/manifest.json)"
import json, sys
results = json.load(open(sys.argv[1]))["results"]
sys.exit(not (1e-7 < results["error"] < 1e-2 and 0 < results["reference_error"] < 1e-7))
PY

# A sweep of real runs, one row per case, failures among them.
"$sweep" spring.toml --simulate "$program" --quiet --reference --out swept --grid method.dt=1e-3,2e-3 \
  --grid method.integrator=leapfrog,rk4,explicit_euler --set spring.s.stiffness=4e5 --jobs 2 || fail "the sweep ends with $?"
python3 - swept/sweep.csv <<'PY' || fail "swept: $(cat swept/sweep.csv)"
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
assert [r["method.dt"] for r in rows] == ["1e-3"] * 3 + ["2e-3"] * 3, rows
for r in rows:
    assert r["scene"] == "spring" and r["integrator"] == r["method.integrator"], r
    if r["integrator"] == "explicit_euler":
        assert r["status"] == "diverged" and "kinetic energy" in r["reason"] and r["error"] == "", r
    else:
        assert r["status"] == "ok" and float(r["dt"]) == float(r["method.dt"]), r
        assert int(r["steps"]) == round(2 / float(r["dt"])), r
        assert 0 < float(r["error"]) and 0 < float(r["reference_error"]) < 0.1 * float(r["error"]), r
PY
finish
