#!/usr/bin/env bash
# program_pages.sh PROGRAM SHARE: writes the manual page of a program, compressed, from what its --help prints (form_help() of
# examples/programs/shell/command_line.cpp) into SHARE/man/man1, and its completions, see completions.sh.
set -euo pipefail
program=$1
man=$2/man/man1
name=$(basename "$program")
help=$("$program" --help)
version=$("$program" --version)
mkdir -p "$man"
bash "$(dirname "$0")/completions.sh" "$@"

# What stands before the usage is the description, and up to its first colon or full stop the line that `whatis` shows. A
# heading stands alone with a colon; an option's name begins in column 3 and its text in column 27.
awk -v name="$name" -v version="$version" '
  function plain(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    gsub(/^ +| +$/, "", text)
    return text ~ /^[.\x27]/ ? "\\&" text : text
  }
  /^Usage: / {
    summary = about
    sub(/[:.].*/, "", summary)
    printf ".TH %s 1 \"\" \"%s\"\n.SH NAME\n", toupper(name), plain(version)
    print name " \\- " tolower(substr(summary, 1, 1)) plain(substr(summary, 2))
    print ".SH SYNOPSIS\n" plain(substr($0, 8)) "\n.SH DESCRIPTION\n" plain(about)
    began = 1
    next
  }
  !began { about = about (about == "" ? "" : " ") $0; next }
  /^(Examples|Exit status):$/ { print ".SH " toupper(substr($0, 1, length($0) - 1)) "\n.nf"; verbatim = 1; next }
  /^[A-Z].*:$/ { print ".SH " toupper(substr($0, 1, length($0) - 1)); verbatim = 0; next }
  /^$/ { if (verbatim) print ".fi"; verbatim = 0; next }
  verbatim { print plain($0); next }
  /^  [^ ]/ {
    wide = substr($0, 26, 1) != " "
    print ".TP\n.B " plain(wide ? $0 : substr($0, 1, 26))
    if (!wide) print plain(substr($0, 27))
    next
  }
  { print plain($0) }
' <<<"$help" | gzip -9n >"$man/$name.1.gz"
