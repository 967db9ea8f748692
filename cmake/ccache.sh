#!/bin/sh
# ccache.sh <folder of the sources> <compiler> <argument>…: compiles through ccache, where it is installed, so that a fresh
# clone in another folder finds what this one compiled. Paths below the sources are hashed relative to the build folder.
# A precompiled header holds absolute paths and is made anew in each clone. What is compiled with it depends on the
# checksum of the headers in it, which is the same in all.
export CCACHE_BASEDIR="$1" CCACHE_NOHASHDIR=1 CCACHE_PCH_EXTSUM=1
export CCACHE_SLOPPINESS=pch_defines,time_macros
shift
command -v ccache >/dev/null || exec "$@"
depfile= output= previous= makes_header=false
for argument; do
  shift
  argument=${argument#"$PWD"/}  # ccache leaves the paths behind -Xclang as they are
  set -- "$@" "$argument"
  case $previous in
    -MF) depfile=$argument ;;
    -o) output=$argument ;;
    -x) [ "$argument" != c++-header ] || makes_header=true ;;
  esac
  previous=$argument
done
if ! $makes_header; then exec ccache "$@"; fi
"$@" || exit
sed -e 's/^[^:]*: *//' -e 's/\\$//' "$depfile" | xargs cat | sha256sum > "$output.sum"
