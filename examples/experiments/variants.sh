#!/usr/bin/env bash
# Variants of an optimisation beside each other, at equal steps and over several seeds: of each the mean and the spread,
# what it does beyond its own matched noise, and what it does beyond the first variant in the same views. What is there is
# not done again, so that an interrupted table goes on.
#
#   variants.sh OUTPUT COMMON NAME=OPTIONS NAME=OPTIONS...
#
# OUTPUT    folder for everything; the table is OUTPUT/variants.md
# COMMON    options of camouflage for all of them, one argument: mesh, detector, frames, epochs; "" for what is bundled
# OPTIONS   further options of one of them; may be empty. The first is what the others are compared with
# All must paint as many texels, unless AGAINST=no leaves the last comparison out. What was begun with other options is
# refused. Paths must have no spaces. In the environment: AGAINST, SEEDS ("1 2 3"), and MEASURE, options of evaluate for all
# of them: other frames, another detector, --conditions.
set -euo pipefail
export LC_ALL=C  # numbers with points
[ $# -ge 3 ] || { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
programs=$(cd "$(dirname "$0")/../.." && pwd)/build/release/examples
output=$1
read -ra common <<<"$2"
read -ra measure <<<"${MEASURE:-}"
read -ra seeds <<<"${SEEDS:-1 2 3}"
shift 2
[ -x "$programs/evaluate" ] || { echo "error: $programs/evaluate is not built; examples/run.sh builds camouflage, cmake --build --preset release all" >&2; exit 2; }

# Of an effect, by the words it is printed with, the mean best confidence and its interval: three numbers.
effect() { sed -n "s/^ *effect beyond $2: mean best confidence \([^ ]*\) \[\([^,]*\), \([^]]*\)\].*/\1 \2 \3/p" "$1/printed.txt"; }
confidence() { awk -F, -v row="$2" '$1 == row { print $7 }' "$1/metrics.csv"; }
# Pictures in which the car is boxed under another name, a vehicle's or any other; and in which no box covers it.
renamed() { awk -F, -v row="$2" '$1 == row { print $9 + $10 }' "$1/metrics.csv"; }
lost() { awk -F, -v row="$2" '$1 == row { print $12 }' "$1/metrics.csv"; }
rate() { awk -F, -v row="$2" '$1 == row { print 100 * $4 }' "$1/metrics.csv"; }
spread() { [ "$1" != - ] || { echo -; return; }; printf '%s\n' "$@" | awk 'NR == 1 { low = high = $1 } { sum += $1; if ($1 < low) low = $1; if ($1 > high) high = $1 } END { printf "%.3f (%.3f to %.3f)", sum / NR, low, high }'; }
interval() { [ "$1" = - ] && echo - || printf '%s [%s, %s]' "$1" "$2" "$3"; }

mkdir -p "$output"
table=$output/variants.md
first=${1%%=*}
{
  echo "| variant | seed | P@0.5 | another name | lost | mean best confidence | matched noise | effect [95 %] | beyond $first [95 %] |"
  echo "|---|---|---|---|---|---|---|---|---|"
} >"$table.part"
for variant in "$@"; do
  name=${variant%%=*}
  read -ra own <<<"${variant#*=}"
  confidences=() noises=() effects=() beyonds=()
  for seed in "${seeds[@]}"; do
    run=$output/run-$name-$seed result=$output/measured-$name-$seed
    if [ ! -e "$run/metrics.json" ]; then
      resume=()
      [ ! -e "$run/manifest.json" ] || resume=(--resume)
      "$programs/camouflage" "${common[@]}" "${own[@]}" --seed "$seed" --output "$run" "${resume[@]}"
    fi
    settings="${common[*]} ${own[*]} measured: ${measure[*]}"
    if [ -e "$result/done" ] && [ "$(cat "$result/done")" != "$settings" ]; then
      echo "error: $result was measured with other options: $(cat "$result/done")" >&2
      exit 7
    fi
    if [ ! -e "$result/done" ]; then
      mkdir -p "$result"
      against=(--against "$output/run-$first-$seed")
      [ "${AGAINST:-yes}" != no ] || against=()
      "$programs/evaluate" --run "$run" "${against[@]}" "${measure[@]}" --output "$result" >"$result/printed.txt"
      echo "$settings" >"$result/done"
    fi
    read -ra effect <<<"$(effect "$result" "matched noise")"
    read -ra beyond <<<"$(effect "$result" "other run")"
    [ ${#beyond[@]} -gt 0 ] || beyond=(-)
    confidences+=("$(confidence "$result" adversarial)") noises+=("$(confidence "$result" "matched noise")")
    effects+=("${effect[0]}") beyonds+=("${beyond[0]}")
    printf '| %s | %s | %.1f %% | %s | %s | %.3f | %.3f | %s | %s |\n' "$name" "$seed" "$(rate "$result" adversarial)" \
      "$(renamed "$result" adversarial)" "$(lost "$result" adversarial)" "${confidences[-1]}" "${noises[-1]}" "$(interval "${effect[@]}")" "$(interval "${beyond[@]}")" >>"$table.part"
  done
  echo "| $name | all | | | | $(spread "${confidences[@]}") | $(spread "${noises[@]}") | $(spread "${effects[@]}") | $(spread "${beyonds[@]}") |" >>"$table.part"
done
{
  echo
  echo "P@0.5: views in which the detector finds the painted car with IoU at least .5. Another name: views in which a box of"
  echo "another class covers it so; lost: in which no box covers it. Effect: matched noise minus camouflage;"
  echo "beyond $first: its mean best confidence minus this one's in the same views; paired bootstrap over views. Rows of all"
  echo "seeds: the mean and, in brackets, the least and the greatest."
} >>"$table.part"
mv "$table.part" "$table"
cat "$table"
echo "table: $table"
