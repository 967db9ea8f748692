#!/usr/bin/env bash
# run.sh [--all]: builds everything and runs every test, on a Debian 12 or newer that need only have git: the optimised
# programs and tests by g++, the library's tests with clang's sanitizers, and the vector kernels as clang optimises them.
# --all adds what finds a mistake rarely: every source read by the other compiler, every instruction set under the
# sanitizers, long runs of faults, the benchmarks optimised, also those of other libraries that are installed. Ends with
# where the time went.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
all=OFF
case ${1:-} in
  '') ;;
  --all) all=ON ;;
  *) echo "usage: tests/run.sh [--all]" >&2; exit 2 ;;
esac

phases=()
# phase NAME COMMAND…: runs a phase and keeps its seconds.
phase() {
  local name=$1 begun=$SECONDS status=0
  shift
  "$@" || status=$?
  phases+=("$((SECONDS - begun)) s  $name")
  return "$status"
}

install_packages() {
  .ci/packages tests || return
  local version
  version=$(clang++-14 -dumpversion 2>/dev/null || clang++ -dumpversion) || return
  .ci/packages sanitizers "${version%%.*}"
}

build() {
  cmake --preset "$1" -DTAPESTRY_TESTS_RARE="$all" -DCMAKE_MESSAGE_LOG_LEVEL=WARNING &&
    cmake --build --preset "$1" --parallel "$jobs"
}

# One run of ctest over the tests of all presets.
run_tests() {
  echo "subdirs(${presets[*]})" > build/CTestTestfile.cmake
  ctest --test-dir build --parallel "$jobs" --output-on-failure --no-tests=error | tee build/tests.log
}

print_times() {
  echo "seconds by phase:"
  printf '  %s\n' "${phases[@]}"
  echo "slowest to compile:"
  for preset in "${presets[@]}"; do
    awk -v preset="$preset" '/\.o\t/ {printf "  %.0f s  %s: %s\n", ($2 - $1) / 1000, preset, $4}' "build/$preset/.ninja_log"
  done | sed 's|CMakeFiles/[^/]*/||; s|\.o$||' | sort --key=1,1 --numeric-sort --reverse | sed -n 1,10p
  echo "slowest tests:"
  sed -nE 's|^ *[0-9]+/[0-9]+ Test +#[0-9]+: (.*[^. ])[ .]+\*{0,3}[A-Z][A-Za-z ]* +([0-9.]+) sec.*|  \2 s  \1|p' build/tests.log |
    sort --key=1,1 --numeric-sort --reverse | sed -n 1,10p
}

jobs=$(nproc)
presets=(release check clang)
phase "packages" install_packages
for preset in "${presets[@]}"; do phase "build of $preset" build "$preset"; done
status=0
phase "tests" run_tests || status=$?
print_times
exit "$status"
