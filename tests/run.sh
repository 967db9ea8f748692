#!/usr/bin/env bash
# Builds everything and runs every test, on a Debian 12 that need only have git: the library's tests with sanitizers,
# and the optimised programs with the tests that run them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
.ci/packages tests
jobs=$(nproc)

for preset in release check; do
  cmake --preset "$preset" -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
  cmake --build --preset "$preset" --parallel "$jobs"
done

echo 'subdirs(check release)' > build/CTestTestfile.cmake  # one run of ctest over both
ctest --test-dir build --parallel "$jobs" --output-on-failure --no-tests=error
