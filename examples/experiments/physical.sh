#!/usr/bin/env bash
# What a camouflage keeps once it is printed and photographed (FCA, table 2, simulated), optimised without and with the
# physical conditions; each view is photographed DRAWS times, 4 when left out. Then table 2 itself of every run,
# evaluate --protocol physical with the options PROTOCOL, and how much of its effect each keeps.
#   physical.sh OUTPUT [COMMON]; see variants.sh, also for the environment
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(dirname "$0")
read -ra protocol <<<"${PROTOCOL:-}"
MEASURE="${MEASURE:-} --conditions physical --draws ${DRAWS:-4}" bash "$here/variants.sh" "$1" "${2:-}" \
  as_they_are="" physical="--conditions physical"
for name in as_they_are physical; do
  for run in "$1/run-$name"-*; do
    table=$1/protocol-${run##*/run-}
    "$here/../../build/release/examples/evaluate" --run "$run" --protocol physical "${protocol[@]}" --output "$table" >"$table.txt"
    echo "${table##*/}: $(grep -m 1 -E 'effect kept|is not defined$' "$table.txt"); table: $table/physical.md"
  done
done
