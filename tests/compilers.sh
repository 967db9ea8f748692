#!/usr/bin/env bash
# compilers.sh [COMPILER...]: with each compiler named (or each below that this machine has) compiles the umbrella header
# with every warning as an error, builds the vector kernels and their tests with -O2 and runs them: with every instruction
# set, or under qemu for another processor. Ends with 1 when one of them failed; its log is then in build/compilers.
# clang++-19/libc++ is that compiler with the other standard library; g++/native compiles for this processor's instruction
# set alone; aarch64-linux-gnu-g++ and clang++-14/aarch64 also need g++-aarch64-linux-gnu and qemu-user, and take Debian's
# libraries for arm64 into build/compilers, not into the system.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source_dir=$PWD
.ci/packages tests
mkdir -p build/compilers
cd build/compilers

compilers=("$@")
if [ $# -eq 0 ]; then
  for version in {12..16}; do compilers+=("g++-$version"); done
  for version in {14..21}; do compilers+=("clang++-$version" "clang++-$version/libc++"); done
  compilers+=(g++/native aarch64-linux-gnu-g++ clang++-14/aarch64)
fi

# is_here PROGRAM...
is_here() { command -v "$@" >/dev/null; }

# The settings of CMake for a compiler of the list; fails when the machine lacks it.
configure_settings() {
  local compiler=${1%%/*}
  is_here "$compiler" || return 1
  settings=(-DCMAKE_CXX_COMPILER="$compiler")
  flags=()
  # clang 17 and later warn that std::stable_sort of libstdc++ 12 calls a deprecated function.
  if [[ $compiler =~ ^clang\+\+-(1[7-9]|2) ]]; then flags=(-Wno-deprecated-declarations); fi
  case $1 in
    */libc++)
      ls /usr/lib/llvm-"${compiler##*-}"/include/c++/v1/version &>/dev/null || return 1
      ls /usr/include/catch2/catch.hpp &>/dev/null || return 1 # Catch2 3 is a library, made for libstdc++
      flags+=(-stdlib=libc++ -isystem "$source_dir/cmake/old_libcxx")
      settings+=(-DTAPESTRY_CATCH_MAIN=ON)
      ;;
    */native) flags+=(-DTAPESTRY_ONE_INSTRUCTION_SET -march=native) ;;
    *aarch64*)
      is_here aarch64-linux-gnu-g++ && is_here qemu-aarch64 || return 1
      "$source_dir/tests/reach/arm64_libraries.sh" root
      settings+=(--toolchain "$source_dir/cmake/aarch64.cmake" -DCMAKE_PREFIX_PATH="$PWD/root/usr" -DTAPESTRY_CATCH_MAIN=ON)
      if [[ $1 == clang* ]]; then
        flags+=(-idirafter /usr/include)
        settings+=(-DCMAKE_CXX_COMPILER_TARGET=aarch64-linux-gnu)
      fi
      ;;
  esac
}

# Configures, builds and tests with the settings in a folder of its own.
build_and_test() {
  cmake -S "$source_dir" -B "$1" -G Ninja "${settings[@]}" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O2 \
    -DCMAKE_CXX_FLAGS="${flags[*]}" -DTAPESTRY_TESTS=kernels -DTAPESTRY_BUILD_EXAMPLES=OFF &&
    cmake --build "$1" --parallel "$(nproc)" --target kernels_test umbrella &&
    ctest --test-dir "$1" --parallel "$(nproc)" --output-on-failure --no-tests=error
}

failed=0
printf '%-26s %-10s %8s  %s\n' compiler version seconds tests
for compiler in "${compilers[@]}"; do
  if ! configure_settings "$compiler"; then
    [ $# -eq 0 ] || { failed=1; printf '%-26s not on this machine\n' "$compiler"; }
    continue
  fi
  folder=${compiler//\//-}
  SECONDS=0
  result=FAILED
  if build_and_test "$folder" >"$folder.log" 2>&1; then result=passed; else failed=1; fi
  printf '%-26s %-10s %8s  %s\n' "$compiler" "$("${compiler%%/*}" --version | grep -oE -m 1 '[0-9]+\.[0-9]+\.[0-9]+' | head -n 1)" "$SECONDS" \
    "$(grep -E 'tests passed' "$folder.log" || echo "$result: see build/compilers/$folder.log")"
done
exit $failed
