# shellcheck shell=bash
# Sourced by experiments/run and tests/run: brings a Debian 12 machine from nothing to a built tree in build/release.
# Exit codes as everywhere in this project: 4 when packages cannot be had.

feder_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
feder_tree=$feder_root/build/release

feder_packages=(
  g++ cmake ninja-build git                            # to build, and to write the commit into every manifest
  libeigen3-dev libsuitesparse-dev libsundials-dev     # matrices, sparse factorisations, the judge
  libopenblas-dev                                      # the BLAS below them
  libcli11-dev nlohmann-json3-dev libfmt-dev           # command line, manifests, text
  libspectra-dev                                       # eigenvalues
  libtomlplusplus-dev                                  # the syntax of scene files
  libgtest-dev libbenchmark-dev librapidcheck-dev      # tests
  libmuparser-dev libtinyobjloader-dev                 # judges in tests: of expressions, of mesh files
  libgmp-dev                                           # exact integers: the judge of overlap tests
  gnuplot-nox                                          # charts
)

# gnuplot draws UTF-8 text whatever the caller's locale is.
export LC_ALL=C.UTF-8

feder_say() { printf '== %s\n' "$*"; }

feder_stop() {
  local code=$1
  shift
  printf '%s\n' "$*" >&2
  exit "$code"
}

feder_missing_packages() {
  local package
  for package in "${feder_packages[@]}"; do
    [[ $(dpkg-query -W -f='${db:Status-Status}\n' "$package" 2>/dev/null) == *installed* ]] || echo "$package"
  done
}

# Root works directly, anybody else through sudo (which may ask for a password only on a terminal).
feder_as_root() {
  if [[ $(id -u) == 0 ]]; then
    "$@"
  elif [[ -t 0 ]]; then
    sudo "$@"
  else
    sudo -n "$@"
  fi
}

feder_apt() {
  feder_as_root env DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 apt-get -q \
    -o DPkg::Lock::Timeout=120 -o Acquire::Retries=2 -o Acquire::http::Timeout=20 "$@"
}

feder_install() {
  local missing
  if ! command -v dpkg-query >/dev/null; then
    command -v cmake >/dev/null && return
    feder_stop 4 "This is not Debian, so please install the equivalents of: ${feder_packages[*]}"
  fi
  read -r -d "" -a missing <<<"$(feder_missing_packages)" || true
  ((${#missing[@]})) || return 0
  feder_say "Installing ${#missing[@]} Debian packages (compiler, libraries, gnuplot): ${missing[*]}"
  if [[ $(id -u) != 0 ]] && ! command -v sudo >/dev/null; then
    feder_stop 4 "No rights to install packages; please run as root: apt-get install ${missing[*]}"
  fi
  # Only the installation decides: an update may complain about sources that are not needed here.
  feder_apt update || true
  feder_apt install -y --no-install-recommends "${missing[@]}" ||
    feder_stop 4 "The packages could not be installed (no network, no rights, or not Debian 12); see apt's message above."
}

# Results and timings are meant for OpenBLAS; the manifest records which library really ran.
feder_check_blas() {
  command -v update-alternatives >/dev/null || return 0
  local name value
  while read -r name _ value; do
    [[ $name == libblas.so.3-* || $name == liblapack.so.3-* ]] || continue
    [[ $value == *openblas* ]] ||
      feder_say "Note: $name is $value, not OpenBLAS; to change it: update-alternatives --config $name"
  done <<<"$(update-alternatives --get-selections 2>/dev/null || true)"
}

# One compiler per core, but each may take 1.5 GB.
feder_jobs() {
  local cores memory
  cores=$(nproc)
  memory=$(awk '/^MemAvailable/ {print int($2 / 1572864)}' /proc/meminfo 2>/dev/null || true)
  memory=${memory:-1}
  echo $((memory < 1 ? 1 : memory < cores ? memory : cores))
}

# feder_build [TARGET]: packages, configuration and build of one target or of everything.
feder_build() {
  local jobs
  feder_install
  feder_check_blas
  jobs=$(feder_jobs)
  cd "$feder_root" || exit
  feder_say "Configuring $feder_tree"
  cmake --preset release
  feder_say "Building with $jobs job(s)"
  cmake --build --preset release --parallel "$jobs" --target "${1:-all}"
}
