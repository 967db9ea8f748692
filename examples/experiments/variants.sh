#!/usr/bin/env bash
# Variants of an optimisation beside each other, over several seeds: how often each detector finds the car, and what each
# variant does beyond its own matched noise. Files that exist are not made again: an interrupted table continues.
#
#   variants.sh OUTPUT COMMON NAME=OPTIONS NAME=OPTIONS...
#
# OUTPUT    folder for everything; the tables are in OUTPUT/tables
# COMMON    options of camouflage for all of them, one argument: mesh, detector, frames, epochs; "" for what is bundled
# OPTIONS   further options of one of them; may be empty. Where they name other --weights, those of COMMON measure it, too
# Paths must have no spaces. In the environment: SEEDS ("1 2 3"), DRAWS of matched noise (20), FURTHER (weights of further
# detectors that measure, too), MEASURE (options of evaluate: other frames, --filter), PROTOCOL (digital), QUICK=yes, LAUNCH,
# NAME of the table (variants) and its TITLE (Variants).
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
command_line="variants.sh $(printf '%q ' "$@")"
output=$1
read -ra common <<<"$2"
read -ra further <<<"${FURTHER:-}"
read -ra seeds <<<"${SEEDS:-1 2 3}"
read -ra measured_with <<<"${MEASURE:-}"
draws=${DRAWS:-20} quick=()
[ "${QUICK:-}" != yes ] || quick=(--quick)
shift 2
source "$(dirname "$0")/steps.sh"
settle "${common[*]}; further ${further[*]}; measured ${PROTOCOL:-digital} ${measured_with[*]} ${quick[*]}, $draws draws"
# The detector that options name, the last --weights.
detector_of() { sed -nE 's/.* --weights ([^ ]+).*/\1/p' <<<" $*"; }
rows=() plain_of=${1%%=*}
for variant in "$@"; do
  name=${variant%%=*}
  read -ra own <<<"${variant#*=}"
  further=($(printf '%s\n' "$(detector_of "${common[@]}")" ${FURTHER:-} | grep -vxF "$(detector_of "${common[@]}" "${own[@]}")" || true))
  optimise "$name" "${own[@]}"
  measure_photographs "$name" "${PROTOCOL:-digital}" "${measured_with[@]}"
  rows+=("$(row "${PROTOCOL:-digital}" "$name")")
done
tabulate "${NAME:-variants}" "${TITLE:-Variants}" "${rows[@]}"
