#!/usr/bin/env bash
# single_header.sh: prints the scalar tape, tapestry/autodiff.hpp, as one header that needs no other of ours:
#   cmake/single_header.sh > tapestry_autodiff.hpp
# Every include of ours is replaced by the header it names, once.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../include"
version=$(sed -n 's/.*TAPESTRY_VERSION_TEXT "\(.*\)"/\1/p' tapestry/version.hpp)
printf '// Tapestry %s, tapestry/autodiff.hpp in one file; made by cmake/single_header.sh.\n' "$version"
sed 's,^,// ,; s, *$,,' ../LICENSE
printf '#pragma once\n'
awk '
  function put(file,    line) {
    if (file in seen) return
    seen[file] = 1
    if (file !~ /[.]hpp$/) { print file " is no header to be included once" >"/dev/stderr"; exit 1 }
    while ((status = (getline line <file)) > 0) {
      if (line ~ /^#pragma once/) continue
      if (line !~ /^ *# *include *[<"]tapestry\//) { print line; continue }
      sub(/^[^<"]*[<"]/, "", line)
      sub(/[>"].*/, "", line)
      put(line)
    }
    if (status < 0) { print "cannot read " file >"/dev/stderr"; exit 1 }
    close(file)
  }
  BEGIN { put("tapestry/version.hpp"); put("tapestry/autodiff.hpp") }
'
