#!/usr/bin/env bash
# Builds everything and runs every test, on a Debian 12 or newer that need only have git: the optimised programs and tests by
# g++, the library's tests with clang's sanitizers, and the vector kernels as clang optimises them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
.ci/packages tests
version=$(clang++-14 -dumpversion 2>/dev/null || clang++ -dumpversion)
.ci/packages sanitizers "${version%%.*}"
jobs=$(nproc)

presets=(release check clang)
for preset in "${presets[@]}"; do
  cmake --preset "$preset" -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
  cmake --build --preset "$preset" --parallel "$jobs"
done

echo "subdirs(${presets[*]})" > build/CTestTestfile.cmake  # one run of ctest over all
ctest --test-dir build --parallel "$jobs" --output-on-failure --no-tests=error
