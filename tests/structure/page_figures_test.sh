#!/usr/bin/env bash
# page_figures_test.sh: the figures of docs/EXPERIMENTS.md are those of the files that tabulate made, docs/results/NAME.csv and
# .md. In the page, <!-- results: NAME NAME --> opens a part whose figures come from these files, <!-- end of results --> ends it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
fail() { echo "$*"; exit 1; }

# figures CSV NUDGE: what tables show of each line, computed from the CSV: shares in per cent, confidences, effects, with
# intervals. The CSV has nine digits, so that half a unit of a table's last digit may be rounded either way, see NUDGE.
figures() {
  awk -F , -v nudge="$2" '
    function number(value, digits, text) { text = sprintf("%." digits "f", value + nudge); return text ~ /^-[0.]*$/ ? substr(text, 2) : text }
    function range(mean, low, high, unit, digits) { return number(unit * mean, digits) " [" number(unit * low, digits) ", " number(unit * high, digits) "]" }
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    { print $1 "\t" range($at["p_at_50"], $at["p_at_50_low"], $at["p_at_50_high"], 100, 1)
      print $1 "\t" number($at["mean_best_confidence"], 3)
      all = $at["pictures"]; found = $at["detected"]; text = number(100 * found / all, 0)
      n = split("related renamed misplaced lost", fates, " ")
      for (i = 1; i <= n; i++) text = text " / " number(100 * $at[fates[i]] / all, 0)
      print $1 "\t" text
      if ($at["effect"] != "") {
        print $1 "\t" range($at["effect"], $at["effect_low"], $at["effect_high"], 1, 3)
        print $1 "\t" range($at["effect_p_at_50"], $at["effect_p_at_50_low"], $at["effect_p_at_50_high"], 100, 1)
        if ($at["detected_in_clean"] > 0) print $1 "\t" range($at["asr"], $at["asr_low"], $at["asr_high"], 100, 1)
        if ($at["first_minus"] != "") print $1 "\t" range($at["first_minus"], $at["first_minus_low"], $at["first_minus_high"], 1, 3)
        if ($at["kept"] != "") print $1 "\t" range($at["kept"], $at["kept_low"], $at["kept_high"], 100, 1) } }' "$1"
}

parts=0 cells=0
open=""
while IFS= read -r line; do
  case $line in
    "<!-- results: "*)
      open=${line#<!-- results: }
      open=${open% -->}
      parts=$((parts + 1))
      known=$(for name in $open; do for nudge in 0 1e-6 -1e-6; do figures "docs/results/$name.csv" $nudge; done; done)
      written=$(for name in $open; do cat "docs/results/$name.md"; done)
      ;;
    "<!-- end of results -->") open="" ;;
    "| "*)
      [ -n "$open" ] || continue
      label=$(sed -E 's/^\| *([^|]*[^| ]) *\|.*/\1/; s/[*`]//g' <<<"$line")
      while IFS= read -r cell; do
        [[ $cell =~ [0-9]\.[0-9] || $cell =~ [0-9]\ /\ [0-9] ]] || continue
        # A cell of two figures, "camouflage / matched noise", stands for both.
        if grep -qxF -- "$label	$cell" <<<"$known"; then
          :
        elif [[ $cell =~ ^([0-9.]+)\ /\ ([0-9.]+)$ ]] && grep -qxF -- "$label	${BASH_REMATCH[1]}" <<<"$known" &&
          grep -qxF -- "$label	${BASH_REMATCH[2]}" <<<"$known"; then
          :
        else
          fail "docs/EXPERIMENTS.md: '$label' has $cell, which docs/results/{$open}.csv do not give"
        fi
        cells=$((cells + 1))
      done < <(tr '|' '\n' <<<"$line" | sed -E '1,2d; s/^ +//; s/ +$//; s/\*//g')
      ;;
    *)
      [ -n "$open" ] || continue
      for figure in $(grep -oE '(^|[^0-9.])[0-9]?\.[0-9]{3}([^0-9]|$)' <<<"$line" | grep -oE '\.[0-9]{3}' || true); do
        grep -qF -- "$figure" <<<"$written" || fail "docs/EXPERIMENTS.md: $figure is in none of docs/results/{$open}.md: $line"
        cells=$((cells + 1))
      done
      ;;
  esac
done <docs/EXPERIMENTS.md
[ "$parts" -ge 3 ] && [ "$cells" -ge 60 ] || fail "few figures are checked: $cells in $parts parts"

# The tables in Markdown show the figures of the CSV.
for csv in docs/results/*.csv; do
  paste <(figures "$csv" 0) <(figures "$csv" 1e-6) <(figures "$csv" -1e-6) | cut -f 2,4,6 | sort -u |
    while IFS=$'\t' read -r figure up down; do
      grep -qF -e "$figure" -e "$up" -e "$down" "${csv%.csv}.md" || fail "${csv%.csv}.md lacks $figure of its CSV"
    done
done

# In the page of the benchmarks each table of figures has the commit that brought it: as many of them in a section as tables.
awk '/^## / { section = $0 }
     /^\|---/ { table = 1 } !/^\|/ { table = 0 }
     table && /[0-9]\.[0-9]/ { tables[section]++; table = 0 }
     { commits[section] += gsub(/\([0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f]\)/, "") }
     END { for (section in tables) if (commits[section] < tables[section]) {
             print "benchmarks/README.md, " section ": " tables[section] " tables, " commits[section] + 0 " commits"; bad = 1 }
           exit bad }' benchmarks/README.md || fail "say of each table which commit it was measured with"
echo "$cells figures in $parts parts"
