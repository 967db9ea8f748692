#!/usr/bin/env bash
# busy.sh [ROUNDS]: what a second thread brings while others use the machine. Beside 0, 1, 2 and 4 busy loops `detect`
# reads and searches the bundled frames on one thread and on two, by turns; the medians of ROUNDS (5), images a second.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
rounds=${1:-5}
.ci/packages programs
cmake --preset release -DTAPESTRY_BUILD_TESTS=OFF -DTAPESTRY_BUILD_BENCHMARKS=OFF -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --parallel "$(nproc)" --target detect

folder=$(mktemp -d)
loops=()
stop_loops() {
  [ ${#loops[@]} -eq 0 ] || kill "${loops[@]}" 2>/dev/null || true
  loops=()
}
trap 'stop_loops; rm -r "$folder"' EXIT
frames=("$PWD"/examples/assets/frames/test/*.npz)
images=600
for ((i = 0; i < images; ++i)); do echo "${frames[i % ${#frames[@]}]}"; done >"$folder/list.txt"

# The seconds of one run on so many threads.
seconds_on() {
  local start=$EPOCHREALTIME
  build/release/examples/detect --quiet --threads "$1" "$folder/list.txt" >"$folder/found-$1"
  echo "$EPOCHREALTIME $start" | awk '{print $1 - $2}'
}

echo 'busy loops   one thread   two threads   two over one   (images a second; medians)'
for count in 0 1 2 4; do
  for ((i = 0; i < count; ++i)); do
    while :; do :; done &
    loops+=($!)
  done
  for ((round = 0; round < rounds; ++round)); do
    for threads in 1 2; do seconds_on "$threads" >>"$folder/$count-$threads"; done
  done
  stop_loops
  cmp "$folder/found-1" "$folder/found-2"
  median() { sort -g "$folder/$count-$1" | awk '{s[NR] = $1} END {print (s[int((NR + 1) / 2)] + s[int(NR / 2) + 1]) / 2}'; }
  echo "$count $images $(median 1) $(median 2)" |
    awk '{printf "%10d   %10.1f   %11.1f   %12.2f\n", $1, $2 / $3, $2 / $4, $3 / $4}'
done
