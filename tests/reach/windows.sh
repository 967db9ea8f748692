#!/usr/bin/env bash
# windows.sh: builds library, programs and tests for Windows, 64 bits, by mingw, and runs them by wine: the tests of the platform
# and of io, then programs from the zip that CPack makes: a run of 40 steps, whose paint has the bits of one made here, a run that
# is killed and resumed, and two runs in one folder. Skips with a sentence what is not installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
sources=$PWD build=$PWD/build/windows work=$PWD/build/windows/work
for file in /usr/bin/x86_64-w64-mingw32-g++-posix /usr/bin/wine /usr/x86_64-w64-mingw32/lib/libz.a; do
  [ -e "$file" ] || { echo "windows: skipped, $file is not there; .ci/packages reach installs it"; exit 0; }
done
export WINEDEBUG=-all WINEPREFIX=$build/wine WINEDLLOVERRIDES="mscoree,mshtml=" TAPESTRY_THREADS=2
status=0
check() { if "${@:2}"; then echo "windows: $1"; else echo "windows: FAILED: $1"; status=1; fi; }

cmake --preset windows -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset windows --target core_test io_test programs
cmake --preset release -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset release --target camouflage
for room in core io; do
  check "tests of $room" wine "$build/tests/${room}_test.exe" '~[long]~[posix]'
done

rm -rf "$work" && mkdir -p "$work" && cd "$work"
(cd "$build" && cpack -B "$work" >/dev/null)
cmake -E tar xf tapestry-*.zip
program=$(echo "$work"/tapestry-*/bin/camouflage.exe)
check "programs of the zip start" wine "$program" --version
mkdir 'four frames ä' && cp "$sources"/examples/assets/frames/test/00[0-3].npz 'four frames ä'
short=(--frames 'four frames ä' --scenes 40 --texels 32 --epochs 8 --checkpoint-steps 3)  # 40 steps

for set in portable avx2 avx512; do
  [ $set = portable ] || grep -qw "${set/avx512/avx512dq}" /proc/cpuinfo || continue
  export TAPESTRY_INSTRUCTION_SET=$set
  "$sources/build/release/examples/camouflage" "${short[@]}" --output "here-$set" >/dev/null 2>&1
  check "a run of 40 steps ($set)" wine "$program" "${short[@]}" --output "there-$set" >run.out 2>&1
  for file in texture.npz history.csv metrics.csv; do
    check "$file has the bits of here ($set)" cmp "here-$set/$file" "there-$set/$file"
  done
done

resume=() kills=0
while [ ! -e killed/metrics.json ] && [ $kills -lt 20 ]; do
  timeout -s KILL $((3 + kills)) wine "$program" "${short[@]}" --output killed "${resume[@]}" >/dev/null 2>&1 || kills=$((kills + 1))
  [ ! -e killed/manifest.json ] || resume=(--resume)
done
check "killed $kills times and resumed, the paint is the same" cmp killed/texture.npz "there-$set/texture.npz"

wine "$program" "${short[@]}" --output twice >/dev/null 2>&1 & first=$!
wine "$program" "${short[@]}" --output twice >/dev/null 2>second.err && second=0 || second=$?
wait $first && first=0 || first=$?
check "of two runs in one folder one is refused ($first, $second)" [ $((first + second)) -eq 7 ]
exit $status
