#!/usr/bin/env bash
# No installed header shows CHOLMOD or SUNDIALS, every header stands alone, and no target exports machine flags.
# shellcheck source=tests/package/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

cd "$prefix/include/feder"
mapfile -t headers < <(find . -name '*.h' | LC_ALL=C sort)
((${#headers[@]} > 20)) || fail "only ${#headers[@]} headers installed"
if grep -nE '#[[:space:]]*include[[:space:]]*[<"](suitesparse/|cholmod|klu|amd\.|umfpack|SuiteSparse|ida/|sundials/|nvector/|sunmatrix/|sunlinsol/)' \
  "${headers[@]}"; then
  fail "an installed header includes SuiteSparse or SUNDIALS"
fi
if grep -nE '#[[:space:]]*include[[:space:]]*"' "${headers[@]}" | grep -vE '"(engine|solvers|models)/[a-z0-9_/]+\.h"'; then
  fail "an installed header includes a file by a path that is not one from the root"
fi
if grep -rnE '#[[:space:]]*include[[:space:]]*"(solvers|models)/' engine; then fail "engine includes solvers or models"; fi
if grep -rnE '#[[:space:]]*include[[:space:]]*"models/' solvers; then fail "solvers include models"; fi
if grep -rnE '#[[:space:]]*include[[:space:]]*"solvers/' models; then fail "models include solvers"; fi

# each header twice, as the first thing a file sees; the vector kernels are a body for their own two files
for header in "${headers[@]}"; do
  [[ $header == */*kernels_vector.h ]] && continue
  printf '#include "%s"\n#include "%s"\n' "${header#./}" "${header#./}"
done >"$FEDER_PACKAGE_WORK/all_headers.cpp"
eigen=$(sed -n 's/^Eigen3_DIR:PATH=//p' "$FEDER_TREE/CMakeCache.txt")
[[ -n $eigen ]] || fail "Eigen3_DIR is not in the cache of $FEDER_TREE"
quietly "$FEDER_CXX" -std=c++20 -fsyntax-only -I "$prefix/include/feder" -isystem "$eigen/../../../include/eigen3" \
  "$FEDER_PACKAGE_WORK/all_headers.cpp"

mapfile -t exported < <(find "$prefix" -name 'federTargets*.cmake')
((${#exported[@]} >= 2)) || fail "no exported targets"
if grep -nE -e '-m(arch|avx|fma|tune|prefer)|INTERFACE_COMPILE_OPTIONS|INTERFACE_COMPILE_DEFINITIONS' "${exported[@]}"; then
  fail "an exported target carries machine flags"
fi
if grep -nF -e "$FEDER_TREE" -e "$FEDER_SOURCE/" "${exported[@]}" | grep -vF "$prefix"; then
  fail "an exported target points into the build tree"
fi
for target in engine solvers models; do
  grep -q "feder::$target " "${exported[@]}" || fail "feder::$target is not exported"
done
printf '%d headers, %d export files\n' "${#headers[@]}" "${#exported[@]}"
