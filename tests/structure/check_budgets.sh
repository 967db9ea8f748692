#!/usr/bin/env bash
# check_budgets.sh FOLDER [TABLE]: prints the folders of FOLDER/include/tapestry and FOLDER/examples that have more lines
# (.hpp, .inl, .cpp, .sh) than TABLE, budgets.txt beside this script, allows, and folders that it does not name. Exits
# with 1 if there are any. A change that needs more lines raises the budget in the same commit, which says why.
set -euo pipefail
table=${2:-$(dirname "${BASH_SOURCE[0]}")/budgets.txt}
cd "$1"
status=0
for folder in include/tapestry include/tapestry/*/ examples/*/; do
  name=${folder%/}
  depth=()
  if [ "$name" = include/tapestry ]; then depth=(-maxdepth 1); fi
  lines=$(find "$name" "${depth[@]}" \( -name '*.hpp' -o -name '*.inl' -o -name '*.cpp' -o -name '*.sh' \) -exec cat {} + | wc -l)
  [ "$lines" -gt 0 ] || continue
  budget=$(awk -v name="$name" '$1 == name { print $2 }' "$table")
  if [ -z "$budget" ]; then
    echo "$name has no budget in $(basename "$table")"
    status=1
  elif [ "$lines" -gt "$budget" ]; then
    echo "$name has $lines lines, its budget is $budget"
    status=1
  fi
done
exit "$status"
