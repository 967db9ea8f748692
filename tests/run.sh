#!/usr/bin/env bash
# run.sh [ROOM… | --all | --long | --reach], on a Debian 12 or newer that need only have git:
#   without an argument  builds and runs every test of behaviour: an optimised library, and tests of it and of the programs
#   ROOM                 the tests of this folder of tests/, such as raster, with the rooms of the library that they call
#   --all                also what finds a mistake rarely: clang's sanitizers, the programs and longer tests by g++, lesser
#                        instruction sets, headers alone, users' projects, every table of the paper
#   --long               also every source read by the other compiler, instruction sets under the sanitizers, every fault, the
#                        page of experiments, all benchmarks and those of other libraries that are installed, clang-tidy-14
#                        where it is: hours
#   --reach              the tape on other machines, in emulators, see tests/reach.sh; --all runs a part of it
# Ends with where the time went.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
all=OFF long=OFF rooms=()
for argument; do
  case $argument in
    --all) all=ON ;;
    --long) all=ON long=ON ;;
    --reach) .ci/packages reach && exec tests/reach.sh ;;
    *)
      if [[ $argument == -* ]] || ! compgen -G "tests/$argument/*_test.cpp" >/dev/null; then
        echo "usage: tests/run.sh [--all | --long | --reach | ROOM…], where a room is one of" \
             "$(printf '%s\n' tests/*/*_test.cpp | cut -d / -f 2 | sort -u | tr '\n' ' ')" >&2
        exit 2
      fi
      rooms+=("$argument") ;;
  esac
done
if [ "$all" = ON ] && [ ${#rooms[@]} -gt 0 ]; then
  echo "tests/run.sh: --all and --long run every room" >&2
  exit 2
fi

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
  [ "$all" = ON ] || return 0
  local version
  version=$(clang++-14 -dumpversion 2>/dev/null || clang++ -dumpversion) || return
  .ci/packages sanitizers "${version%%.*}" && .ci/packages python &&
    { [ "$long" = OFF ] || .ci/packages packing; }
}

built=()
# build PRESET [TARGET…]
build() {
  local preset=$1
  shift
  built+=("$preset")
  cmake --preset "$preset" -DTAPESTRY_TESTS_LONG="$long" -DCMAKE_MESSAGE_LOG_LEVEL=WARNING &&
    cmake --build --preset "$preset" --parallel "$jobs" ${1:+--target "$@"}
}

# run_tests PRESETS ARGUMENT…: one run of ctest over the tests of some presets.
run_tests() {
  echo "subdirs($1)" > build/CTestTestfile.cmake
  shift
  ctest --test-dir build --parallel "$jobs" --output-on-failure --no-tests=error "$@" | tee -a build/tests.log
}

print_times() {
  echo "seconds by phase:"
  printf '  %s\n' "${phases[@]}"
  echo "slowest to compile:"
  for preset in "${built[@]}"; do
    awk -v preset="$preset" '/\.o\t/ {printf "  %.0f s  %s: %s\n", ($2 - $1) / 1000, preset, $4}' "build/$preset/.ninja_log"
  done | sed 's|CMakeFiles/[^/]*/||; s|\.o$||' | sort --key=1,1 --numeric-sort --reverse | sed -n 1,10p
  echo "slowest tests:"
  sed -nE 's|^ *[0-9]+/[0-9]+ Test +#[0-9]+: (.*[^. ])[ .]+\*{0,3}[A-Z][A-Za-z ]* +([0-9.]+) sec.*|  \2 s  \1|p' build/tests.log |
    sort --key=1,1 --numeric-sort --reverse | sed -n 1,20p
}

jobs=$(nproc)
status=0
phase "packages" install_packages
phase "build of test" build test ${rooms[@]+"${rooms[@]/%/_test}"}
: > build/tests.log
select=(--label-exclude rare)
if [ ${#rooms[@]} -gt 0 ]; then select+=(--tests-regex "^($(IFS='|'; echo "${rooms[*]}"))/"); fi
phase "tests of behaviour" run_tests test "${select[@]}" || status=$?
if [ "$all" = ON ] && [ "$status" -eq 0 ]; then
  for preset in check release; do phase "build of $preset" build "$preset"; done
  phase "other machines" tests/reach.sh --short s390x i686 aarch64 libcxx || status=$?
  phase "lesser instruction sets" run_tests test --label-regex rare || status=$?
  phase "tests that find a mistake rarely" run_tests "check release" || status=$?
  if [ "$long" = ON ] && command -v clang-tidy-14 >/dev/null; then phase "tidy" build tidy || status=$?; fi
fi
print_times
exit "$status"
