#!/usr/bin/env bash
# Paints a camouflage for the bundled car against the bundled detector, on a Debian 12 that need only have git. Each run
# makes a folder of its own, runs/camouflage-001 and so on, and prints the path of its report. Arguments go to the program:
# examples/run.sh --help lists them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
.ci/packages programs

cmake --preset release -DTAPESTRY_BUILD_TESTS=OFF -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --parallel "$(nproc)" --target camouflage
exec build/release/examples/camouflage "$@"
