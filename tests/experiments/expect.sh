# shellcheck shell=bash disable=SC2154
# Sourced by the contract tests. `program` is the executable under test.
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect CODE PATTERN ARGUMENT...: runs the program; exit code and output (both streams) must match, and the output
# must hold no control characters.
expect() {
  local code=$1 pattern=$2 status=0
  shift 2
  "$program" "$@" >output 2>&1 </dev/null || status=$?
  [[ $status == "$code" ]] || fail "$*: exit code $status, expected $code: $(head -c 500 output)"
  grep -q -e "$pattern" output || fail "$*: no '$pattern' in: $(head -c 500 output)"
  ! LC_ALL=C grep -q '[^[:print:][:space:]]' <(LC_ALL=C tr -d '\200-\377' <output) || fail "$*: control characters"
  ! grep -q $'\r' output || fail "$*: carriage returns"
  rm -f output
}

finish() {
  ((failures == 0)) && echo "all as promised"
  exit $((failures != 0))
}
