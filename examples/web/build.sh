#!/usr/bin/env bash
# build.sh [FOLDER]: builds the page with emscripten: FOLDER/index.html, one file that needs no server (build/web by default).
# EMXX replaces em++, as "ccache em++".
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
out=${1-build/web}
read -ra compiler <<<"${EMXX-em++}"
command -v "${compiler[-1]}" >/dev/null || { echo "build.sh: ${compiler[-1]} is not installed" >&2; exit 1; }
mkdir -p "$out/include" "$out/objects"
export NODE_PATH=/usr/share/nodejs # of Debian's packages
# Headers of other libraries, which are the same for every processor.
for name in Eigen=eigen3/Eigen unsupported=eigen3/unsupported xtensor xtl nlohmann protozero stb zlib.h zconf.h; do
  ln -sfn "/usr/include/${name#*=}" "$out/include/${name%=*}"
done
flags=(-std=c++20 -O2 -msimd128 -ffp-contract=off -fwasm-exceptions -Iinclude -isystem cmake/old_libcxx -isystem "$out/include" -isystem "$out/include/stb")
sources=(cmake/compiled/{camouflage,core,detect,evaluate,geometry,image,io,loss,nn,raster}.cpp
         examples/scenes/{car,drawn_frames,make_scene,photograph,picture,scene_parts,vehicle}.cpp examples/web/page.cpp)
objects=() pairs=()
for source in "${sources[@]}"; do
  object=$out/objects/$(basename "$(dirname "$source")")-$(basename "$source" .cpp).o
  objects+=("$object")
  if [ ! -e "$object" ] || [ -n "$(find include examples/scenes examples/web cmake/compiled -newer "$object" -name '*.[chi]*' -print -quit)" ]; then
    pairs+=("$object" "$source")
  fi
done
[ ${#pairs[@]} -eq 0 ] || printf '%s\0' "${pairs[@]}" | xargs -0 -n 2 -P "$(nproc)" "${compiler[@]}" "${flags[@]}" -c -o
assets=()
for name in car_sedan.obj car_sedan.mtl detector.weights detector.cfg detector.names; do
  assets+=(--embed-file "examples/assets/$name@/$name")
done
em++ "${flags[@]}" "${objects[@]}" "${assets[@]}" -o "$out/tapestry.js" -sSINGLE_FILE -sMODULARIZE -sEXPORT_NAME=Tapestry \
  -sENVIRONMENT=worker,node -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=256MB -sFORCE_FILESYSTEM \
  -sEXPORTED_FUNCTIONS=_main,_answer,_pixels -sEXPORTED_RUNTIME_METHODS=ccall,FS,HEAPU8
while IFS= read -r line; do
  case $line in
    '<!-- style.css -->') echo '<style>' && cat examples/web/style.css && echo '</style>' ;;
    '<!-- worker.js -->') echo '<script id="worker" type="text/plain">' && cat "$out/tapestry.js" examples/web/worker.js && echo '</script>' ;;
    '<!-- page.js -->') echo '<script>' && cat examples/web/page.js && echo '</script>' ;;
    *) printf '%s\n' "$line" ;;
  esac
done <examples/web/index.html >"$out/index.html"
echo "$out/index.html: $(stat -c %s "$out/index.html") bytes, $(gzip -9 -c "$out/index.html" | wc -c) by gzip"
