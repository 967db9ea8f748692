#!/usr/bin/env bash
# The comparators on the same mesh, detector and budget (FCA, table 1).
#   methods.sh OUTPUT [COMMON]; see variants.sh, also for the environment
# rauca is optimised in light estimated from the photographs, and measured in the frames' own as all others. mesh_adv is
# optimised with a bilinear atlas and measured with the filter of all others; where COMMON has a --filter, it must suit it.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2; }
[[ " ${2:-} ${MEASURE:-} " != *" --light"* && " ${2:-} " != *" --method"* ]] || {
  echo "--method and --light are what is compared here" >&2
  exit 2
}
filter="--filter bilinear"
[[ " ${2:-} " != *" --filter"* ]] || filter=""
[[ -z $filter || " ${MEASURE:-} " == *" --filter"* ]] || MEASURE="--filter anisotropic ${MEASURE:-}"
MEASURE="--light frame ${MEASURE:-}" exec bash "$(dirname "$0")/variants.sh" "$1" "${2:-}" fca="" planar_patch="--method planar_patch" \
  camou="--method camou" upc="--method upc" das="--method das" \
  das_full="--method das_full" rauca="--method rauca --light photo" mesh_adv="--method mesh_adv $filter" \
  random="--method random" solid="--method solid"
