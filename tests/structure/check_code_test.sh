#!/usr/bin/env bash
# check_code_test.sh: check_code.sh accepts code that is in order and refuses deliberate violations.
set -euo pipefail
check=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/check_code.sh
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# expect STATUS WORDS: runs check_code.sh on the folder.
expect() {
  local status=0
  "$check" "$folder" >"$folder/said" || status=1
  if [ "$status" -ne "$1" ] || { [ -n "$2" ] && ! grep -q "$2" "$folder/said"; }; then
    printf 'expected %s and "%s", found %s:\n' "$1" "$2" "$status"
    cat "$folder/said"
    exit 1
  fi
}

# body LINES: so many statements.
body() { for _ in $(seq "$1"); do echo '  call("{", 2);  // {'; done; }

mkdir -p "$folder/include" "$folder/examples"
{ printf 'class Later;\nclass Box {\n'; body 50; printf '};\ninline void f() {\n'; body 40; echo '}'; } >"$folder/include/a.hpp"
printf 'struct Later {};\nstruct Box<int> {};\n' >"$folder/include/b.hpp"
touch "$folder/examples/c.cpp"
expect 0 ''
{ printf 'int g(int a,\n      int b) {\n'; body 41; echo '}'; } >"$folder/examples/c.cpp"
expect 1 'c.cpp:2: a function of 41 lines'
{ printf 'X::X()\n    : x_(1) {\n'; body 41; echo '}'; } >"$folder/examples/c.cpp"
expect 1 'c.cpp:2: a function of 41 lines'
echo >"$folder/examples/c.cpp"
printf 'template <class T>\nclass Box {};\n' >"$folder/include/b.hpp"
expect 1 'b.hpp: Box is also in include/a.hpp'
mkdir -p "$folder/include/tapestry/image" "$folder/include/tapestry/autodiff"
echo >"$folder/include/b.hpp"
printf 'template <class T>\nvoid f(T);\n' | tee "$folder/include/tapestry/autodiff/d.hpp" >"$folder/include/tapestry/image/e.hpp"
expect 1 'image/e.hpp:1: T is not std::floating_point'
rm "$folder/include/tapestry/image/e.hpp"
expect 0 ''
