#!/usr/bin/env bash
# Builds the consumer project against the install tree, runs it, and checks its numbers against closed forms.
# shellcheck source=tests/package/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

build=$FEDER_PACKAGE_WORK/consumer
build_consumer "$here/consumer" "$build"
if grep -E '^CMAKE_CXX_FLAGS[A-Z_]*:' "$build/CMakeCache.txt" | grep -E -e '-m(arch|avx|tune)'; then
  fail "the consumer was not built with plain flags"
fi
output=$("$build/consumer") || fail "the consumer ended with code $?"
printf '%s\n' "$output"

# Oscillator x'' = -omega^2 x from rest at A: every method multiplies the amplitude by its own factor. With theta = omega dt,
#   implicit Euler 1/(1 - i theta), RK4 the Taylor polynomial of exp(i theta), leapfrog a turn by acos(1 - theta^2/2).
printf '%s\n' "$output" | awk '
  function check(name, expected, bound,   error) {
    if (!(name in value)) { print "FAILED: no line " name; bad = 1; return }
    error = value[name] - expected; if (error < 0) error = -error
    printf "%-24s %.15g expected %.15g error %.1e\n", name, value[name], expected, error
    if (!(error <= bound)) { print "FAILED: " name; bad = 1 }
  }
  function power(re, im, n,   i, t) {
    X = 1; Y = 0
    for (i = 0; i < n; ++i) { t = X * re - Y * im; Y = X * im + Y * re; X = t }
  }
  NF == 2 { value[$1] = $2 + 0 }
  END {
    amplitude = 0.1; theta = 10 * 0.01; n = 100
    power(1 / (1 + theta^2), theta / (1 + theta^2), n);             check("implicit_euler_notes", amplitude * X, 1e-14)
    power(1 - theta^2 / 2 + theta^4 / 24, theta - theta^3 / 6, n);  check("rk4", amplitude * X, 1e-14)
    power(1 - theta^2 / 2, sqrt(theta^2 - theta^4 / 4), n);         check("leapfrog", amplitude * X, 1e-14)
    check("ida", amplitude * cos(10), 1e-7)  # measured 1.3e-8 at the default tolerance
    check("catalog_exact", amplitude * cos(10), 1e-15)
    # a rod under load: 2 kg, 9.81 m/s^2; tension is a negative multiplier
    check("rod_multiplier", -2 * 9.81, 1e-12)
    check("rod_length", 1, 1e-15)
    check("refused_mass", 1, 0)
    exit bad
  }' || fail "the consumer's numbers are wrong"
