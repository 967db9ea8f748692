#!/usr/bin/env bash
# run.sh NAME [OPTION...]: builds the benchmark NAME and runs it. One that compares libraries gets all peers that Debian 12
# has, and prints where its table and figure are; a microbenchmark, NAME_bench, takes Google Benchmark's options. Without
# arguments it lists the benchmarks. `run.sh NAME --help` explains the options.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# The first comment of each file, as one line.
list() {
  awk 'FNR == 1 { if (text) print text; name = FILENAME; gsub(/.*\/|\.cpp$/, "", name); text = "  "
                  if (name != "driver") text = text name ": "; inside = 1 }
       inside && /^\/\/ / { sub(/^\/\/ /, FNR == 1 ? "" : " "); text = text $0; next }
       { inside = 0 }
       END { print text }' benchmarks/*/driver.cpp benchmarks/*/*_bench.cpp
}

name=${1:-}
micro=(benchmarks/*/"$name".cpp)
if [ -e "benchmarks/$name/driver.cpp" ]; then
  target=${name}_benchmark
elif [[ $name == *_bench && -e ${micro[0]} ]]; then
  target=$name
else
  [ $# -eq 0 ] || echo "error: no benchmark '$name'" >&2
  echo "usage: benchmarks/run.sh NAME [OPTION...]"
  list
  [ $# -eq 0 ] && exit 0 || exit 2
fi
shift

.ci/packages benchmarks
# --against COMMIT: builds its camouflage in a working tree of its own, and gives the driver the program.
arguments=("$@")
for ((i = 0; i + 1 < $#; ++i)); do
  [ "$name" = job ] && [ "${arguments[i]}" = --against ] && [ ! -e "${arguments[i + 1]}" ] || continue
  commit=$(git rev-parse --verify --short "${arguments[i + 1]}^{commit}")
  tree=build/against/$commit
  [ -d "$tree" ] || git worktree add --detach "$tree" "$commit"
  (cd "$tree" && cmake --preset release -DTAPESTRY_BUILD_TESTS=OFF -DCMAKE_MESSAGE_LOG_LEVEL=WARNING &&
    cmake --build --preset release --parallel "$(nproc)" --target camouflage)
  arguments[i + 1]=$PWD/$tree/build/release/examples/camouflage
done
cmake --preset release -DTAPESTRY_BUILD_TESTS=OFF -DTAPESTRY_BENCH_PEERS=ON -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --parallel "$(nproc)" --target "$target"
exec "build/release/benchmarks/$name" "${arguments[@]}"
