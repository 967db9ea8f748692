#!/usr/bin/env bash
# Paints a camouflage for the bundled car against the bundled detector, on a Debian 12 that need only have git. Each run
# makes a folder of its own, runs/camouflage-001 and so on, and prints the path of its report. Arguments go to the program:
# examples/run.sh --help lists them. Builds the other programs behind the first run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
.ci/packages programs

export CCACHE_DEPEND=1  # a first build finds nothing kept, and need not preprocess each source to look for it
# build TARGET
build() { cmake --build --preset release --parallel "$(nproc)" --target "$1"; }
cmake --preset release --no-warn-unused-cli -DTAPESTRY_BUILD_TESTS=OFF -DTAPESTRY_BUILD_BENCHMARKS=OFF -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
build camouflage
build/release/examples/camouflage "$@"
echo "builds the other programs into build/release/examples"
build programs
