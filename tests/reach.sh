#!/usr/bin/env bash
# reach.sh [--short] [TARGET…]: the tape on other machines than this one: compiles it for each target below, and runs it there
# or in an emulator. Prints which operations have other bits there than here, and fails if the tape's own arithmetic has.
#   aarch64   64 bits, another order of operations in memory      s390x    big-endian
#   i686      32 bits, SSE2                                       windows  mingw and wine
#   wasm      32 bits, without a processor's flags: emscripten and node
#   libcxx    this machine, by clang with libc++, which macOS has
# Without --short also the tests of tests/autodiff, and of the platform, that the target can run; with libcxx all of behaviour.
# What is not installed is skipped with a sentence; .ci/packages reach installs it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
sources=$PWD
tests=true
if [ "${1-}" = --short ]; then tests=false; shift; fi
targets=("$@")
[ $# -gt 0 ] || targets=(aarch64 s390x i686 windows wasm libcxx)
mkdir -p build/reach/include
# Headers of Debian's that are the same for every processor.
for name in catch2 xtensor xtl eigen3/Eigen eigen3/unsupported; do ln -sfn "/usr/include/$name" "build/reach/include/${name#*/}"; done
common=(-std=c++20 -ffp-contract=off -Wall -Wextra -I"$sources/include" -isystem "$sources/build/reach/include")

# Sets compiler, runner and flags; fails with a sentence where a program is absent.
choose() {
  runner=() flags=(-static -pthread) precompiled=gch select='~[long]'
  case $1 in
    aarch64) compiler=aarch64-linux-gnu-g++ runner=(qemu-aarch64) ;;
    s390x) compiler=s390x-linux-gnu-g++ runner=(qemu-s390x) ;;
    i686) compiler=i686-linux-gnu-g++ runner=(qemu-i386) flags+=(-msse2 -mfpmath=sse) ;;
    windows) compiler=x86_64-w64-mingw32-g++-posix runner=(wine) flags+=(-DCATCH_CONFIG_NO_WINDOWS_SEH -Wa,-mbig-obj) ;;
    wasm)
      compiler=em++ runner=(node --no-experimental-fetch) precompiled=pch
      # Without -O1 a test has more locals than a browser's engine takes.
      flags=(-O1 -isystem "$sources/cmake/old_libcxx" -pthread -fexceptions -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=256MB
             -sNODERAWFS -sPROXY_TO_PTHREAD -sEXIT_RUNTIME -Wno-pthreads-mem-growth -Wno-unused-command-line-argument -DCATCH_CONFIG_NO_POSIX_SIGNALS)
      ;;
    libcxx) compiler=clang++-14 flags=(-stdlib=libc++ -isystem "$sources/cmake/old_libcxx" -pthread) ;;
    *) echo "reach.sh: no target $1" >&2; exit 2 ;;
  esac
  # Their C libraries miss the bounds of some functions: mingw's those of exp10, pow, lgamma and of sin at 1e308.
  case $1 in windows | wasm) select+='~[accuracy]~[table]~"derivatives of duals that overflow*"' ;; esac
  # musl's pow of denormals is off, and its long double has the digits of double.
  case $1 in wasm) select+='~"powers have two*"~"random scalar programs*"' ;; esac
  local missing=()
  for program in "$compiler" ${runner[@]+"${runner[0]}"}; do command -v "$program" >/dev/null || missing+=("$program"); done
  if [ "$1" = libcxx ] && [ ! -e /usr/lib/llvm-14/include/c++/v1 ]; then missing+=(libc++-14-dev); fi
  if [ ${#missing[@]} -gt 0 ]; then
    echo "$1: skipped, ${missing[*]} is not installed"
    return 1
  fi
}

# Whether a test can run on the target: it needs no shared library, and neither Boost nor minutes of a compiler; and where the
# rest of the library refuses the processor, the scalar tape alone. So on Windows: g++ has no stack aligned for AVX-512 there.
can_run() {
  local headers
  case $1 in *two_libraries* | *boost* | *_optimised_* | *_at_zeros* | *eigen_spectrum*) return 1 ;; esac
  case $target/$1 in wasm/*complex*) return 1 ;; esac # libc++ divides complex numbers by logb() of the part
  headers=$("$compiler" "${common[@]}" -MM "$1" 2>/dev/null) && [[ $target != windows || $headers != *supported_target* ]]
}

# Compiles with what is set for the target: build OUTPUT ARGUMENT…
build() { "$compiler" "${common[@]}" "${flags[@]}" -o "$@"; }
export TAPESTRY_INSTRUCTION_SET=portable  # the only one elsewhere
export NODE_PATH=/usr/share/nodejs  # of Debian's packages, also for another node than Debian's
export WINEDEBUG=-all WINEPREFIX=$sources/build/reach/wine WINEDLLOVERRIDES="mscoree,mshtml=" TAPESTRY_THREADS=2

run_bits() {
  build "$out/bits$end" -O2 tests/autodiff/bits.cpp &&
    "${runner[@]}" "$out/bits$end" | tr -d '\r' >"$out/bits.txt" &&
    echo "$target: operations with other bits than here:" && build/reach/bits build/reach/bits.txt "$out/bits.txt"
}

run_tests() {
  local pairs=() objects=() file paths=(-DTAPESTRY_SOURCE="\"$sources\"" -DTAPESTRY_SHARED='""')
  printf '#include "%s"\n' "$sources/tests/support/catch.hpp" "$sources/include/tapestry/autodiff.hpp" >"$out/first.hpp"
  "$compiler" "${common[@]}" "${flags[@]}" -x c++-header -o "$out/first.hpp.$precompiled" "$out/first.hpp" || return
  for file in tests/autodiff/*_test.cpp tests/autodiff/*/*_test.cpp tests/core/platform_test.cpp; do
    can_run "$file" || continue
    objects+=("$out/${file//\//-}.o")
    pairs+=("${objects[-1]}" "$file")
  done
  echo "$target: ${#objects[@]} files of tests"
  printf '%s\0' "${pairs[@]}" |
    xargs -0 -n 2 -P "$(nproc)" "$compiler" "${common[@]}" "${flags[@]}" -include "$out/first.hpp" -c -o &&
    build "$out/tests$end" "${paths[@]}" "${objects[@]}" tests/support/{catch_main,paths}.cpp cmake/compiled/core.cpp &&
    "${runner[@]}" "$out/tests$end" "$select" | tail -n 3
}

# All rooms, and the programs.
run_rooms() {
  cmake --preset "$target" -DCMAKE_MESSAGE_LOG_LEVEL=WARNING && cmake --build --preset "$target" --parallel "$(nproc)" &&
    ctest --preset "$target" --parallel "$(nproc)" --label-exclude rare | tail -n 20
}

g++ "${common[@]}" -O2 -o build/reach/bits tests/autodiff/bits.cpp
build/reach/bits >build/reach/bits.txt
status=0
for target in "${targets[@]}"; do
  choose "$target" || continue
  out=build/reach/$target end=
  case $target in windows) end=.exe ;; wasm) end=.js ;; esac
  mkdir -p "$out"
  begun=$SECONDS
  FLAGS=${flags[*]} RUNNER=${runner[*]} ENDING=$end bash tests/structure/single_header_test.sh "$compiler" || status=1
  run_bits || status=1
  if "$tests" && [ "$target" = libcxx ]; then run_rooms || status=1; elif "$tests"; then run_tests || status=1; fi
  if "$tests" && [ -x "tests/reach/$target.sh" ]; then "tests/reach/$target.sh" || status=1; fi  # what is above the tape
  echo "$target: $((SECONDS - begun)) s"
done
exit "$status"
