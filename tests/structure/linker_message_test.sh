#!/usr/bin/env bash
# linker_message_test.sh COMPILER: a program without tapestry/implementation.hpp, or with it in two source files, is
# refused by the linker with a name that states the remedy.
set -euo pipefail
compiler=$1
include=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../include" && pwd)
remedy=tapestry::include_tapestry_implementation_hpp_in_one_source_file_or_link_tapestry_compiled
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

cat >calls.cpp <<'END'
#include <tapestry/io/obj_file.hpp>

int main(int count, char** arguments) { return tapestry::io::read_obj(arguments[count - 1]).mesh.faces.empty() ? 1 : 0; }
END
cat >tape.cpp <<'END'
#include <tapestry/autodiff.hpp>

int main() {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(0.5);
  tape.reverse(x * x);
  return x.adjoint() == 1 ? 0 : 1;
}
END
# The part of tapestry/implementation.hpp that matters here; the rest takes minutes.
echo '#include <tapestry/core/implementation.hpp>' | tee first.cpp >second.cpp

# expect_refusal WORDS ARGUMENT...: the linker prints one line with these words and the remedy.
expect_refusal() {
  local words=$1
  shift
  if "$compiler" "$@" -o program 2>messages; then
    echo "linked all the same: $*"
    exit 1
  fi
  if [ "$(grep -c "$words.*$remedy" messages)" -ne 1 ]; then
    printf '%s: expected "%s ... %s" once, found:\n' "$*" "$words" "$remedy"
    cat messages
    exit 1
  fi
}

export LC_ALL=C
for flags in -O0 -O2 "-O2 -fdata-sections"; do
  for source in calls tape first second; do
    # shellcheck disable=SC2086 # several flags
    "$compiler" -std=c++20 $flags -I"$include" -c $source.cpp -o $source.o
  done
  for unused in --no-gc-sections --gc-sections; do
    expect_refusal "undefined reference" -Wl,$unused calls.o
    expect_refusal "multiple definition" -Wl,$unused calls.o first.o second.o
  done
  "$compiler" tape.o -o program # the tape needs nothing compiled
  ./program
done
