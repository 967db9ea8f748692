#!/usr/bin/env bash
# What a camouflage keeps once it is printed and photographed (FCA, table 2, simulated), optimised without and with the
# physical conditions; each view is photographed DRAWS times, 4 when left out.
#   physical.sh OUTPUT [COMMON]; see variants.sh, also for the environment
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
MEASURE="${MEASURE:-} --conditions physical --draws ${DRAWS:-4}" exec bash "$(dirname "$0")/variants.sh" "$1" "${2:-}" \
  as_they_are="" physical="--conditions physical"
