#!/usr/bin/env bash
# Builds everything and runs every test, on a Debian 12 or newer that need only have git: the library's tests with
# sanitizers, the optimised programs with the tests that run them, and the vector kernels as clang optimises them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
.ci/packages tests
jobs=$(nproc)

presets=(release check)
if command -v clang++-14 clang++ >/dev/null; then
  presets+=(clang)
else
  echo "no clang: its optimised kernels are not tested"
fi
for preset in "${presets[@]}"; do
  cmake --preset "$preset" -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
  cmake --build --preset "$preset" --parallel "$jobs"
done

echo "subdirs(${presets[*]})" > build/CTestTestfile.cmake  # one run of ctest over all
ctest --test-dir build --parallel "$jobs" --output-on-failure --no-tests=error
