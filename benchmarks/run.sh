#!/usr/bin/env bash
# run.sh NAME [OPTION...]: builds the benchmark NAME with all peers that Debian 12 has, runs it and says where its
# table and figure are. Without arguments it lists the benchmarks. `run.sh NAME --help` explains the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [ $# -eq 0 ] || [ ! -e "benchmarks/$1/driver.cpp" ]; then
  [ $# -eq 0 ] || echo "error: no benchmark '$1'" >&2
  echo "usage: benchmarks/run.sh NAME [OPTION...]"
  sed -s -n '1s|^// |  |p' benchmarks/*/driver.cpp
  [ $# -eq 0 ] && exit 0 || exit 2
fi
name=$1
shift

.ci/packages benchmarks
cmake --preset release -DTAPESTRY_BUILD_TESTS=OFF -DTAPESTRY_BENCH_PEERS=ON -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --parallel "$(nproc)" --target "${name}_benchmark"
exec "build/release/benchmarks/$name" "$@"
