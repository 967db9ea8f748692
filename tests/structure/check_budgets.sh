#!/usr/bin/env bash
# check_budgets.sh FOLDER [TABLE]: compares the lines (.hpp, .inl, .cpp, .sh) of the source folders below FOLDER with
# TABLE, budgets.txt beside this script, and prints what each part has gained or lost since the last release. Exits with 1
# if a folder has more lines than its budget or no budget, if include/ and examples/ together pass the table's ceiling, or
# if the sum of all budgets is above that of the commit before: a budget rises only where others fall by as much.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
table=${2:-$here/budgets.txt}
cd "$1"
status=0

# count_lines PATTERNS… -- FIND_ARGUMENTS…: lines of the files that find lists.
count_lines() { find "$@" -type f \( -name '*.hpp' -o -name '*.inl' -o -name '*.cpp' -o -name '*.sh' \) -exec cat {} + | wc -l; }
refuse() { echo "$1"; status=1; }
# sums TABLE COLUMN: the sum of a column for each part, the first folder of a name.
sums() { awk -v column="$2" '/^[a-z]/ { split($1, path, "/"); sum[path[1]] += $column } END { for (part in sum) print part, sum[part] }' "$1" | sort; }

total() { awk '/^[a-z]/ { sum += $2 } END { print sum + 0 }' "$1"; }

lines_of=$(mktemp)
trap 'rm -f "$lines_of" "$lines_of.before"' EXIT
for folder in include/tapestry include/tapestry/*/ examples/*/ tests tests/*/ benchmarks benchmarks/*/; do
  name=${folder%/}
  depth=()
  case $name in include/tapestry | tests | benchmarks) depth=(-maxdepth 1) ;; esac
  lines=$(count_lines "$name" "${depth[@]}")
  [ "$lines" -gt 0 ] || continue
  echo "$name $lines" >> "$lines_of"
  budget=$(awk -v name="$name" '$1 == name { print $2 }' "$table")
  if [ -z "$budget" ]; then
    refuse "$name has no budget in $(basename "$table")"
  elif [ "$lines" -gt "$budget" ]; then
    refuse "$name has $lines lines, its budget is $budget"
  fi
done

ceiling=$(awk '$1 == "#ceiling" { print $2 }' "$table")
both=$(find include examples -type f \( -name '*.hpp' -o -name '*.inl' -o -name '*.cpp' \) -exec cat {} + | wc -l)
if [ -n "$ceiling" ] && [ "$both" -gt "$ceiling" ]; then
  refuse "include and examples have $both lines without scripts, the ceiling is $ceiling"
fi

echo "lines now, and since release $(awk '$1 == "#release" { print $2 }' "$table"):"
join <(sums "$lines_of" 2) <(sums "$table" 3) | awk '{ printf "  %-10s %6d  %+d\n", $1, $2, $2 - $3 }'

# The earlier table: the last commit's if the table has uncommitted changes, else the parent commit's.
tracked=tests/structure/budgets.txt
if ! git rev-parse --quiet --verify HEAD >/dev/null 2>&1; then
  echo "no commit is at hand: budgets are not compared with those before"
  exit "$status"
fi
before=HEAD
if git diff --quiet HEAD -- "$tracked"; then before=$(git log -1 --format=%H -- "$tracked")^; fi
if git show "$before:$tracked" > "$lines_of.before" 2>/dev/null; then
  now=$(total "$table") then=$(total "$lines_of.before")
  [ "$now" -le "$then" ] || refuse "budgets sum up to $now, before they did to $then: lower others by as much"
else
  echo "the commit before is not at hand: budgets are not compared with it"
fi
exit "$status"
