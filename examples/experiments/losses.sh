#!/usr/bin/env bash
# Which loss: the paper's, the one that its published program has, and the surest candidate's score. Table 6 of FCA
# compares the terms of the first instead.
#   losses.sh OUTPUT [COMMON]; see variants.sh, also for the environment
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
exec bash "$(dirname "$0")/variants.sh" "$1" "${2:-}" paper="--loss paper" as_coded="--loss as_coded" vanish="--loss vanish" \
  max_score="--loss max_score"
