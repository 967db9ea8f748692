#!/usr/bin/env bash
# Which first texture (FCA, table 7): random colours, mid grey, the car's own.
#   initialisation.sh OUTPUT [COMMON]; see variants.sh, also for the environment
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0" >&2; exit 2; }
exec bash "$(dirname "$0")/variants.sh" "$1" "${2:-}" random="--start random" zero="--start zero" own="--start own"
