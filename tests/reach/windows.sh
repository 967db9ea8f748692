#!/usr/bin/env bash
# windows.sh: builds library, programs and tests for Windows, 64 bits, by mingw, and runs them by wine: the tests of the platform
# and of io; programs from the zip that CPack makes, with names that are not ASCII; a run that is killed and resumed; two runs in
# one folder; and a run of 40 steps with elementary functions of our own, whose bits are those of the same run here. What is not
# installed is skipped with a sentence.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
sources=$PWD build=$PWD/build/windows work=$PWD/build/windows/work compiler=x86_64-w64-mingw32-g++-posix
for file in "/usr/bin/$compiler" /usr/bin/wine /usr/x86_64-w64-mingw32/lib/libz.a; do
  [ -e "$file" ] || { echo "windows: skipped, $file is not there; .ci/packages reach installs it"; exit 0; }
done
export WINEDEBUG=-all WINEPREFIX=$build/wine WINEDLLOVERRIDES="mscoree,mshtml=" TAPESTRY_THREADS=2
status=0
check() { if "${@:2}"; then echo "windows: $1"; else echo "windows: FAILED: $1"; status=1; fi; }

for preset in windows release; do cmake --preset $preset -DCMAKE_MESSAGE_LOG_LEVEL=WARNING; done
cmake --build --preset windows --target core_test io_test programs tapestry_compiled
cmake --build --preset release --target camouflage
rm -rf "$work" && mkdir -p "$work/bin" "$work/share/tapestry"
for room in core io; do check "tests of $room" wine "$build/tests/${room}_test.exe" '~[long]~[posix]'; done

(cd "$build" && cpack -B "$work" >/dev/null)
# The linker takes these functions before those of the C library, as the loader does here.
functions=(-O1 -ffp-contract=off -fno-builtin "$sources/tests/reach/elementary.cpp")
g++ "${functions[@]}" -fPIC -shared -o "$work/elementary.so"
"$compiler" "${functions[@]}" -c -o "$work/elementary.obj"
link=$(ninja -C "$build" -t commands examples/camouflage.exe | tail -n 1)
(cd "$build" && bash -c "${link/-o examples\/camouflage.exe/$work/elementary.obj -o $work/bin/camouflage.exe}")
ln -s "$sources/examples/assets" "$work/share/tapestry/assets"

cd "$work"
cmake -E tar xf tapestry-*.zip
program=$(echo "$work"/tapestry-*/bin/camouflage.exe) frames='four frames ä'
mkdir "$frames" && cp "$sources"/examples/assets/frames/test/00[0-3].npz "$frames"
short=(--quiet --frames "$frames" --scenes 40 --texels 32 --epochs 8 --checkpoint-steps 3)  # 40 steps
check "a program of the zip" wine "$program" "${short[@]}" --output 'whole ü'

for set in portable avx2 avx512; do
  [ $set = portable ] || grep -qw "${set/avx512/avx512dq}" /proc/cpuinfo || continue
  export TAPESTRY_INSTRUCTION_SET=$set
  LD_PRELOAD=$work/elementary.so "$sources/build/release/examples/camouflage" "${short[@]}" --output "here-$set" >/dev/null
  wine bin/camouflage.exe "${short[@]}" --output "there-$set" >/dev/null
  for file in texture.npz history.csv metrics.csv painted.obj; do
    check "bits of $file, $set" cmp "here-$set/$file" "there-$set/$file"
  done
done
unset TAPESTRY_INSTRUCTION_SET

resume=() kills=0
while [ ! -e killed/metrics.json ] && [ $kills -lt 20 ]; do
  timeout -s KILL $((2 + kills)) wine "$program" "${short[@]}" --output killed "${resume[@]}" || kills=$((kills + 1))
  [ ! -e killed/manifest.json ] || resume=(--resume)
done >/dev/null 2>&1
check "resumed after $kills kills" cmp killed/texture.npz 'whole ü/texture.npz'

codes=0
wine "$program" "${short[@]}" --output twice >/dev/null 2>&1 & first=$!
wine "$program" "${short[@]}" --output twice >/dev/null 2>&1 || codes=$?
wait $first || codes=$((codes + $?))
check "of two runs in one folder one is refused ($codes)" [ $codes -eq 7 ]
exit $status
