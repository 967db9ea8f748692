#!/usr/bin/env bash
# aarch64.sh [ROOM…]: the library on 64-bit ARM, in an emulator: the tests of the rooms named, or of those below, with NEON and with
# portable instructions; the default run for 40 steps and an ONNX detector, which must have the bits that this processor gives
# with AVX2 or portable instructions if both have the elementary functions of elementary.cpp; and a run that is killed and resumed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
for program in aarch64-linux-gnu-g++ qemu-aarch64; do
  command -v "$program" >/dev/null || { echo "arm: skipped, $program is not installed"; exit 0; }
done
rooms=("$@")
[ $# -gt 0 ] || rooms=(core nn raster geometry image optim detect segment loss io camouflage)
out=build/reach/arm status=0
mkdir -p "$out/frames"
tests/reach/arm64_libraries.sh build/reach/arm64
cmake -S . -B "$out" -G Ninja --toolchain cmake/aarch64.cmake -DCMAKE_PREFIX_PATH="$PWD/build/reach/arm64/usr" \
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O1 -DTAPESTRY_TESTS=library -DTAPESTRY_CATCH_MAIN=ON \
  -DTAPESTRY_CCACHE=ON -DCMAKE_MESSAGE_LOG_LEVEL=ERROR
cmake --build "$out" --parallel "$(nproc)" --target camouflage detect "${rooms[@]/%/_test}"
cmake --preset release -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --parallel "$(nproc)" --target camouflage detect
export QEMU_LD_PREFIX=/usr/aarch64-linux-gnu TAPESTRY_THREADS=2

fail() { echo "arm: FAILED: $*"; status=1; }
for room in "${rooms[@]}"; do
  for set in neon portable; do
    echo "$room, $set"
    TAPESTRY_INSTRUCTION_SET=$set qemu-aarch64 "$out/tests/${room}_test" '~[long]' | tail -n 3 || fail "$room, $set"
  done
done

# on ARM|HERE SET PROGRAM ARGUMENT…
on() {
  local place=$1 runner=(qemu-aarch64 -E LD_PRELOAD="$PWD/$out/functions.arm" "$out/examples/$3")
  [ "$place" = arm ] || runner=(env LD_PRELOAD="$PWD/$out/functions.here" "build/release/examples/$3")
  TAPESTRY_INSTRUCTION_SET=$2 "${runner[@]}" "${@:4}"
}
functions=(-O1 -fno-builtin -ffp-contract=off -shared -fPIC tests/reach/elementary.cpp -o "$out/functions")
g++ "${functions[@]}.here" && aarch64-linux-gnu-g++ "${functions[@]}.arm"
cp examples/assets/frames/test/00[0-3].npz "$out/frames"
steps=(camouflage --quiet --scenes 40 --frames "$out/frames" --batch 1 --epochs 1 --checkpoint-steps 10 --controls matched)
compare() {
  for file in texture.npz history.csv metrics.csv; do
    cmp "$out/$1/$file" "$out/$2/$file" || fail "$1 and $2 have other bits of $file"
  done
}
onnx=../shared/data/detectors/yolox_nano.onnx
for sets in "portable portable" "neon avx2"; do
  here=${sets#* } arm=${sets% *}
  rm -rf "$out/arm-$arm" "$out/here-$here"
  on here "$here" "${steps[@]}" --output "$out/here-$here" >/dev/null && on arm "$arm" "${steps[@]}" --output "$out/arm-$arm" || fail "run, $arm"
  compare "arm-$arm" "here-$here"
  [ -e "$onnx" ] || { echo "arm: $onnx is absent: no ONNX detector"; continue; }
  cmp <(on here "$here" detect --json --weights "$onnx" "$out"/frames/000.npz) \
      <(on arm "$arm" detect --json --weights "$onnx" "$out"/frames/000.npz) || fail "ONNX detector, $arm"
done

rm -rf "$out/killed"
on arm neon "${steps[@]}" --output "$out/killed" &
until [ -e "$out/killed/checkpoint.npz" ] || ! kill -0 $! 2>/dev/null; do sleep 0.2; done
pkill -KILL -P $! && echo "killed" || fail "the run ended before it could be killed"
wait $! || true
on arm neon camouflage --quiet --resume --output "$out/killed" || fail "no resume"
compare killed arm-neon
exit "$status"
