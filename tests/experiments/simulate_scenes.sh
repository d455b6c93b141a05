# shellcheck shell=bash
# Sourced by the tests of simulate: scenes, and how results are compared.

# A cloth with a motor-driven linkage beside it: every kind of unknown, about a second of steps.
write_scene() {
  cat >scene.toml <<'TOML'
end_time = 2
quick_end_time = 0.05
gravity = [0, 0, -9.81]

[[cloth]]
name = "cloth"
edge_u = [1, 0, 0]
edge_v = [0, 1, 0]
count = [8, 8]
mass = 0.2
stiffness = 1e3
bend_stiffness = 5
damping_time = 1e-3
fixed = ["c00", "c10"]

[[body]]
name = "crank"
shape = "box"
mass = 0.4
edges = [0.2, 0.02, 0.02]
position = [2.1, 0, 0]

[[joint]]
type = "hinge"
between = ["world", "crank"]
place = [2, 0, 0]
axis = [0, 1, 0]

[[turn]]
between = ["world", "crank"]
axis = [0, 1, 0]
stiffness = 20
damping = 0.1
target = "9*t"

[method]
integrator = "implicit_euler_geometric"
route = "kkt"
dt = 5e-4

[output]
interval = 0.01
files = ["states", "trajectory", "npy", "rows", "energy", "vtu"]
TOML
}

# results_hash FOLDER
results_hash() { grep '"results_hash"' "$1/manifest.json"; }
manifest_says() { grep -q "\"status\": \"$2\"" "$1/manifest.json" || fail "$1: manifest: $(grep '"status"' "$1/manifest.json"), expected $2"; }

# result_files FOLDER: all but the manifest, which holds times of the wall.
result_files() { (cd "$1" && find . -type f ! -name manifest.json | sort); }

# same_results A B WHAT: the same files, bitwise, and the same hash.
same_results() {
  local file
  [[ $(result_files "$1") == "$(result_files "$2")" ]] || fail "$3: $(diff <(result_files "$1") <(result_files "$2") | head -5)"
  while read -r file; do cmp -s "$1/$file" "$2/$file" || fail "$3: $file differs"; done < <(result_files "$1")
  [[ $(results_hash "$1") == "$(results_hash "$2")" ]] || fail "$3: another results hash"
}

# whole_files FOLDER WHAT: whatever stands under a final name can be read to its end.
whole_files() {
  python3 - "$1" <<'PY' || fail "$2: a file in $1 is not whole"
import ast, csv, glob, json, os, sys
def need(true, path):
    if not true:
        sys.exit(path + " is not whole")
for path in glob.glob(sys.argv[1] + "/*.csv"):
    text = open(path, newline="").read()
    need(text.endswith("\n") and len({len(row) for row in csv.reader(text.splitlines())}) == 1, path)
for path in glob.glob(sys.argv[1] + "/frames/*.vtu") + glob.glob(sys.argv[1] + "/*.pvd"):
    need(open(path, "rb").read().endswith(b"</VTKFile>\n"), path)
for path in glob.glob(sys.argv[1] + "/*.npy"):
    data = open(path, "rb").read()
    start = 10 if data[6] == 1 else 12
    end = start + int.from_bytes(data[8:start], "little")
    head = ast.literal_eval(data[start:end].decode())
    size = int(head["descr"][2:])
    for n in head["shape"]:
        size *= n
    need(len(data) == end + size, path)
if os.path.exists(sys.argv[1] + "/manifest.json"):
    json.load(open(sys.argv[1] + "/manifest.json"))
PY
}

# wait_until COMMAND...: at most ten seconds.
wait_until() {
  local _
  for _ in $(seq 1000); do
    if "$@"; then return; fi
    sleep 0.01
  done
  fail "waited in vain for: $*"
}
