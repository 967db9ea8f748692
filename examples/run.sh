#!/usr/bin/env bash
# Paints a camouflage for the bundled car against the bundled detector, on a Debian 12 that need only have git.
# Each run gets a folder of its own below runs/; arguments go to the program: examples/run.sh --help lists them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
.ci/packages programs

cmake --preset release -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --parallel "$(nproc)" --target camouflage

number=1
while [ -e "runs/bundled-$number" ]; do number=$((number + 1)); done
output=runs/bundled-$number
build/release/examples/camouflage --output "$output" "$@"

echo
echo "the result is in $output:"
ls "$output"
