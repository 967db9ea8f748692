#!/usr/bin/env bash
# first_build_test.sh <folder of the programs> <folder of the sources>: examples/run.sh builds no object that camouflage
# does not link.
set -euo pipefail
build=$(cd "$1/.." && pwd)
cd "$build"
ninja -t inputs camouflage | grep '\.o$' | sed 's|.*/||' | sort >"$OLDPWD/built"
link=$(ninja -t commands camouflage | tail -1)
cd "$OLDPWD"
(cd "$build" && bash -c "${link/ -o examples\/camouflage / -Wl,--trace,--trace -o $OLDPWD/camouflage }") |
  grep -E '\.c(pp|xx)\.o$' | sort -u | sed 's|.*[/)]||' | sort >linked
[ -s linked ] || { echo "the linker names no object: $link"; exit 1; }
# With MPI another object takes the place of one_process.
if comm -23 built linked | grep -v '^one_process'; then
  echo "are built for camouflage, and not linked"
  exit 1
fi
