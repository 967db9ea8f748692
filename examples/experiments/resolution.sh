#!/usr/bin/env bash
# Effect against resolution: the same optimisation with atlases of 8 to 128 rows. Coarse paint prints more easily, transfers
# further, and noise of its colours and spectrum does less of its work.
#   resolution.sh OUTPUT [COMMON]; see variants.sh, also for the environment. ROWS ("8 16 32 64 128") chooses others.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
variants=()
for rows in ${ROWS:-8 16 32 64 128}; do variants+=("$rows=--texels $rows"); done
AGAINST=no exec bash "$(dirname "$0")/variants.sh" "$1" "${2:-}" "${variants[@]}"
