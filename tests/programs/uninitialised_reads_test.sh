#!/usr/bin/env bash
# The pool, tapes of several threads, the renderer and networks neither branch on memory that nobody wrote nor write it
# out: valgrind's memcheck follows every byte up to branches and to what the programs write out. It knows no AVX-512.
# MemorySanitizer would need the standard library compiled for it, which Debian does not have.
source "$(dirname "$0")/support.sh"
if ! command -v valgrind >/dev/null; then
  echo "skipped: valgrind is missing"
  exit 77
fi
memcheck=(valgrind --quiet --error-exitcode=99 --leak-check=no)
export TAPESTRY_THREADS=2

# Faults that it must find: a branch, and a byte of a file.
cat >planted.cpp <<'END'
#include <cstdio>
#include <memory>
int main(int count, char**) {
  const auto values = std::make_unique_for_overwrite<char[]>(100);
  values[0] = 1;
  if (count > 1) return values[count] == 7 ? 1 : 2;
  std::fwrite(values.get(), 1, 100, stdout);
}
END
"${CXX:-c++}" -std=c++20 planted.cpp -o planted || fail "the program with planted faults is not compiled"
expect_exit 99 "a planted write" "${memcheck[@]}" ./planted
expect_exit 99 "a planted branch" "${memcheck[@]}" ./planted 2

expect_exit 0 "a tape on one thread" "${memcheck[@]}" "$programs/fit_curve"
expect_exit 0 "a tape for each thread" "${memcheck[@]}" "$programs/tape_threads"
expect_exit 0 "a network and its gradient" "${memcheck[@]}" "$programs/input_gradient"
expect_exit 0 "and by portable kernels" env TAPESTRY_INSTRUCTION_SET=portable "${memcheck[@]}" "$programs/input_gradient"
expect_exit 0 "gradients through a renderer" "${memcheck[@]}" "$programs/recover_paint"
expect_exit 0 "a picture" "${memcheck[@]}" "$programs/render" --size 48 --output car.png
expect_exit 0 "depths" env TAPESTRY_INSTRUCTION_SET=portable \
  "${memcheck[@]}" "$programs/render" --size 48 --view depth --output depth.npy
finish
