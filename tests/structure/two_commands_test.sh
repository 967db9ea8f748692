#!/usr/bin/env bash
# two_commands_test.sh: tests/run.sh --all takes every object that examples/run.sh has compiled, though more packages are there
# by then, ccache and MPI among them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# configure NAME ARGUMENT...: a build folder of the preset `release`.
configure() {
  local name=$1
  shift
  cmake --preset release -B "$folder/$name" "$@" >"$folder/messages" 2>&1 || { cat "$folder/messages"; exit 1; }
}

# compilations FOLDER TARGET...: command lines of the objects.
compilations() {
  local build=$folder/$1
  shift
  ninja -C "$build" -t commands "$@" | grep -F ' -c ' | sed "s|$build|BUILD|g" | LC_ALL=C sort -u
}

arguments=$(sed -n 's/^cmake --preset release //p' examples/run.sh)
targets=$(sed -n 's/^build //p' examples/run.sh)
# shellcheck disable=SC2086 # several arguments
configure programs $arguments -DTAPESTRY_CCACHE_PROGRAM= -DCMAKE_DISABLE_FIND_PACKAGE_MPI=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_benchmark=ON
configure tests 
# shellcheck disable=SC2086 # several targets
compilations programs $targets >"$folder/first"
compilations tests >"$folder/second"
[ "$(wc -l <"$folder/first")" -ge 20 ] || { echo "found no objects of $targets"; exit 1; }
if LC_ALL=C comm -23 "$folder/first" "$folder/second" | grep .; then
  echo "are compiled by examples/run.sh, and not by tests/run.sh --all in the same way"
  exit 1
fi
