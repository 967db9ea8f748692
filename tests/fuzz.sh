#!/usr/bin/env bash
# fuzz.sh SECONDS [TARGET...]: builds the fuzz targets with clang and runs each for so many seconds on one core, from
# seeds and from what earlier runs found worth keeping in build/fuzz/corpus. Ends with 1 when one of them failed; the
# input is then in build/fuzz/failures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:?"how many seconds a target?"}
shift
.ci/packages tests
version=$(clang++-14 -dumpversion 2>/dev/null || clang++ -dumpversion)
.ci/packages sanitizers "${version%%.*}"
cmake --preset fuzz -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset fuzz --target fuzz
cd build/fuzz
program=$PWD/tests/fuzz/fuzz
targets=("$@")
[ $# -gt 0 ] || mapfile -t targets < <("$program")

[ ! -w /dev/shm ] || export TMPDIR=/dev/shm # readers of files are ten times as fast there
trap 'exit 130' INT # libFuzzer ends well on it, and the next target would begin
failed=0
mkdir -p failures
printf '%-16s %12s %9s %9s %9s\n' target executions 'a second' coverage 'MiB most'
for target in "${targets[@]}"; do
  mkdir -p "seeds/$target" "corpus/$target"
  export TAPESTRY_FUZZ_TARGET=$target
  TAPESTRY_FUZZ_SEEDS=seeds/$target "$program"
  # ONNX's own models, one an operator, where Debian's libonnx-testdata is installed.
  case $target in onnx | onnx_network | onnx_staged)
    for model in "${TAPESTRY_ONNX_TESTDATA:-/usr/share/libonnx-testdata/data}"/*/*/model.onnx; do
      [ ! -e "$model" ] || cp "$model" "seeds/$target/$(basename "$(dirname "$model")").onnx"
    done ;;
  esac
  words=()
  for dictionary in "$OLDPWD"/tests/fuzz/*.dict; do # cfg's is also that of classifier_cfg
    [[ $target != *$(basename "$dictionary" .dict) ]] || words=("-dict=$dictionary")
  done
  "$program" "corpus/$target" "seeds/$target" "${words[@]}" -max_total_time="$seconds" -max_len=65536 -timeout=5 \
    -rss_limit_mb=1024 -print_final_stats=1 -artifact_prefix="failures/$target-" >"$target.log" 2>&1 || {
    failed=1
    echo "$target failed: see build/fuzz/$target.log"
  }
  stat() { sed -n "s/^stat::$1: *//p" "$target.log"; }
  printf '%-16s %12s %9s %9s %9s\n' "$target" "$(stat number_of_executed_units)" "$(stat average_exec_per_sec)" \
    "$(grep -oE 'cov: [0-9]+' "$target.log" | tail -n 1 | cut -d' ' -f2)" "$(stat peak_rss_mb)"
done
exit "$failed"
