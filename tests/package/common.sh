# shellcheck shell=bash
# Sourced by the package tests. Their CMakeLists.txt sets the FEDER_ variables.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
prefix=$FEDER_PACKAGE_WORK/installed

fail() {
  printf 'FAILED: %s\n' "$*" >&2
  exit 1
}

# Runs a command quietly; shows what it said only if it fails.
quietly() {
  local log=$FEDER_PACKAGE_WORK/last.$$.log
  if ! "$@" >"$log" 2>&1; then
    cat "$log" >&2
    fail "$*"
  fi
  rm -f "$log"
}

# build_consumer SOURCE BUILD [-D...]: a project outside the tree, with the compiler's own flags only.
build_consumer() {
  local source=$1 build=$2
  shift 2
  rm -rf "$build"
  quietly env -u CXXFLAGS -u CPPFLAGS -u LDFLAGS "$FEDER_CMAKE" -S "$source" -B "$build" -G "$FEDER_GENERATOR" \
    "-DCMAKE_CXX_COMPILER=$FEDER_CXX" -DCMAKE_BUILD_TYPE=Release "-DCMAKE_PREFIX_PATH=$prefix" "$@"
  quietly "$FEDER_CMAKE" --build "$build" --parallel 1
}
