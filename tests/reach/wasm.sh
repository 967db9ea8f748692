#!/usr/bin/env bash
# wasm.sh [FOLDER]: builds the page of examples/web and its C++ side natively, and tests the page in a headless Chromium, see
# web.mjs. The native program has the C library's functions of emscripten: musl's, compiled here. The pictures lie in
# FOLDER/pictures (build/web). What is not installed is skipped with a sentence; .ci/packages reach installs it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
out=${1-$PWD/build/web}
for program in em++ node chromium cmake; do
  command -v "$program" >/dev/null || { echo "web: skipped, $program is not installed"; exit 0; }
done
examples/web/build.sh "$out"
cmake --preset test -DCMAKE_MESSAGE_LOG_LEVEL=WARNING
cmake --build --preset test --target web_page
musl=/usr/share/emscripten/system/lib/libc/musl/src
functions=(sin cos tan asin acos atan atan2 exp exp2 expm1 log log1p log2 log10 pow sinh cosh tanh cbrt hypot)
files=("${functions[@]}" "${functions[@]/%/f}" sincos sincosf __cos __cosdf __sin __sindf __tan __tandf __rem_pio2 __rem_pio2f
       __rem_pio2_large __expo2 __expo2f __math_{divzero,invalid,oflow,uflow,xflow}{,f} {exp,log,log2,pow}_data
       {exp2f,logf,log2f,powf}_data)
sources=("${files[@]/#/$musl/math/}")
sources=("${sources[@]/%/.c}")
{ # glibc has other functions of these names
  echo '#include <math.h>'
  for name in sin cos tan sinl cosl tanl sindf cosdf tandf; do echo "#define __$name musl_$name"; done
} >"$out/musl.h"
gcc -std=gnu11 -O2 -ffp-contract=off -fno-builtin -w -shared -fPIC -Wl,-Bsymbolic -include "$out/musl.h" -D'weak_alias(a, b)=' \
  -D'hidden=__attribute__((visibility("hidden")))' -I"$musl/internal" -I"$musl/../arch/generic" -o "$out/musl.so" "${sources[@]}"
node --no-experimental-fetch tests/reach/web.mjs "$out/index.html" "$out/pictures" "$PWD/build/test/examples/web_page" "$out/musl.so"
