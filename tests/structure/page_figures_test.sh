#!/usr/bin/env bash
# page_figures_test.sh: the figures of docs/EXPERIMENTS.md equal those of page.sh's files, docs/results/NAME.md, and
# these equal NAME.csv's. In the page, <!-- results: NAME NAME --> opens a part whose figures come from these files,
# <!-- end of results --> ends it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
fail() { echo "$*"; exit 1; }

# figures CSV NUDGE: what tables show of each line, computed from the CSV: shares in per cent, confidences, effects, with
# intervals. The CSV has nine digits, so that half a unit of a table's last digit may be rounded either way, see NUDGE.
figures() {
  awk -F , -v nudge="$2" '
    function number(value, digits, text) { text = sprintf("%." digits "f", value + nudge); return text ~ /^-[0.]*$/ ? substr(text, 2) : text }
    function range(mean, low, high, unit, digits) { return number(unit * mean, digits) " [" number(unit * low, digits) ", " number(unit * high, digits) "]" }
    function odd(value) { return value == "inf" || value + 0 > 100 ? "&gt; 100" : value + 0 < 0.01 ? "&lt; 0.01" : sprintf("%.3g", value) }
    function odds(ratio, low, high) { return low > 0.1 || (high != "inf" && high + 0 < 10) ? odd(ratio) " [" odd(low) ", " odd(high) "]" : "-" }
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
    at["state"] { # of harden
      label = $1 ", " $at["picture"]
      text = range($at["p_at_50"], $at["p_at_50_low"], $at["p_at_50_high"], 100, 1)
      sub(/ /, " % ", text)
      print label "\t" text
      print label "\t" number($at["mean_best_confidence"], 3)
      if ($at["state"] != "hardened" || $at["picture"] != "adaptive") next
      p = $at["p_at_50"]; below = p - $at["p_at_50_low"]; above = $at["p_at_50_high"] - p
      if ($1 == "none") { control = p; control_below = below; control_above = above }
      else if (control != "")
        print $1 " minus none, adaptive\t" range(p - control, p - control - sqrt(below * below + control_above * control_above),
          p - control + sqrt(above * above + control_below * control_below), 100, 1)
      next }
    { print $1 "\t" range($at["p_at_50"], $at["p_at_50_low"], $at["p_at_50_high"], 100, 1)
      if ($at["texture"] == "picture noise") next
      print $1 "\t" number($at["mean_best_confidence"], 3)
      if ($at["attention"] > 0) print $1 "\t" number(100 * $at["attention"], 1)
      all = $at["pictures"]; found = $at["detected"]; text = number(100 * found / all, 0)
      n = split("related renamed misplaced lost", fates, " ")
      for (i = 1; i <= n; i++) text = text " / " number(100 * $at[fates[i]] / all, 0)
      print $1 "\t" text
      if ($at["effect"] != "") {
        print $1 "\t" range($at["effect"], $at["effect_low"], $at["effect_high"], 1, 3)
        print $1 "\t" range($at["effect_p_at_50"], $at["effect_p_at_50_low"], $at["effect_p_at_50_high"], 100, 1)
        if ($at["effect_picture"] != "") print $1 "\t" range($at["effect_picture"], $at["effect_picture_low"], $at["effect_picture_high"], 100, 1)
        if ($at["odds_ratio"] != "") print $1 "\t" odds($at["odds_ratio"], $at["odds_ratio_low"], $at["odds_ratio_high"])
        if ($at["detected_in_clean"] > 0) print $1 "\t" range($at["asr"], $at["asr_low"], $at["asr_high"], 100, 1)
        if ($at["first_minus"] != "") print $1 "\t" range($at["first_minus"], $at["first_minus_low"], $at["first_minus_high"], 1, 3)
        if ($at["kept"] != "") print $1 "\t" range($at["kept"], $at["kept_low"], $at["kept_high"], 100, 1) } }' "$1"
}

# cells FILE: each cell of its tables of Markdown as LABEL, COLUMN and CELL, separated by tabs, without marks of
# emphasis. If the table's title names its figure, COLUMN once more with that name before it, such as "found: ".
cells() {
  awk -F '|' 'function plain(text) { gsub(/[*`]/, "", text); gsub(/^ +| +$/, "", text); return text }
    /^\*\*/ { shown = "" }
    /^\*\*pictures in which the car is found/ { shown = "found: " }
    /^\*\*effect beyond matched noise, P@0.5/ { shown = "effect: " }
    /^\|---/ { columns = split(above, column); next }
    /^\|/ { above = $0
      for (i = 3; i < NF; i++) if (i <= columns && $i ~ /[0-9]/) {
        print plain($2) "\t" plain(column[i]) "\t" plain($i)
        if (shown != "") print plain($2) "\t" shown plain(column[i]) "\t" plain($i) } }
    !/^\|/ { columns = 0 }' "$1"
}

# A part of the page: the cells of its tables stand in the files' tables, in a row and a column of the same names.
# Figures of its text with a point, in per cent or in points, stand anywhere there.
parts=0 checked=0
check_part() { # NAMES TEXT
  local name known="" written="" cell figure
  for name in $1; do
    known+=$(cells "docs/results/$name.md")$'\n'
    written+=$(cat "docs/results/$name.md")$'\n'
  done
  while IFS= read -r cell; do
    grep -qxF -- "$cell" <<<"$known" || fail "docs/EXPERIMENTS.md: row, column, cell '$cell' is in none of docs/results/{$1}.md"
    checked=$((checked + 1))
  done < <(cells <(printf '%s\n' "$2"))
  while IFS= read -r figure; do
    grep -qE -- "(^|[^0-9.])0?${figure//./\\.}(\.0)?\.?([^0-9.]|$)" <<<"$written" ||
      fail "docs/EXPERIMENTS.md: $figure is in none of docs/results/{$1}.md"
    checked=$((checked + 1))
  done < <(grep -v '^[|!]' <<<"$2" | grep -oE '[0-9]*\.[0-9]+|[0-9]+ (%|points)' | sed -E 's/ .*//; s/^0\././' || true)
  parts=$((parts + 1))
}
open="" text=""
while IFS= read -r line; do
  case $line in
    "<!-- results: "*) open=${line#<!-- results: } open=${open% -->} text="" ;;
    "<!-- end of results -->") check_part "$open" "$text"; open="" ;;
    *) [ -z "$open" ] || text+=$line$'\n' ;;
  esac
done <docs/EXPERIMENTS.md
[ "$parts" -ge 3 ] && [ "$checked" -ge 60 ] || fail "few figures are checked: $checked in $parts parts"

# All files of a folder, a world of pictures, were made by one commit, which the page names; it names no other.
made_by=""
while IFS= read -r folder; do
  commits=$(sed -nE 's/^(- )?Made by commits? (.*)\.$/\2/p' "$folder"/*.md | sort -u)
  [[ $commits =~ ^[0-9a-f]{40}$ ]] || fail "$folder: found files of the commits '$commits', expected those of one"
  silent=$(grep -LE "^(- )?Made by commit $commits\.$" "$folder"/*.md || true)
  [ -z "$silent" ] || fail "these do not state their commit: $silent"
  made_by+=$commits$'\n'
done < <(find docs/results -name '*.md' -printf '%h\n' | sort -u)
named=$(grep -oE '\b[0-9a-f]{7,40}\b' docs/EXPERIMENTS.md | grep '[a-f]' | grep '[0-9]' | sort -u)
[ "$(cut -c 1-8 <<<"$named" | sort)" = "$(printf %s "$made_by" | cut -c 1-8 | sort -u)" ] ||
  fail "docs/EXPERIMENTS.md names the commits '$named', its files $made_by"

# The tables in Markdown show the figures of the CSV, in rows of the same names.
for csv in docs/results/*.csv docs/results/*/*.csv; do
  paste <(figures "$csv" 0) <(figures "$csv" 1e-6) <(figures "$csv" -1e-6) | cut -f 1,2,4,6 | sort -u |
    awk -F '\t' 'NR == FNR { sub(/, (matched noise|noise in each picture)$/, "", $1); cells[$1] = cells[$1] "\t" $3 "\t"; next }
      !index(cells[$1], $2) && !index(cells[$1], $3) && !index(cells[$1], $4) { print $1 ": " $2; exit 1 }' \
      <(cells "${csv%.csv}.md") - || fail "${csv%.csv}.md lacks this of its CSV"
done

# Odds and effects follow from the counts, and lie inside their intervals. Odds of shares of 0 or 1 are half a picture away,
# of all pictures in the first files and of one seed and draw in later ones, since those are equal.
for csv in docs/results/*.csv docs/results/*/*.csv; do
  awk -F , 'function share(all) { return $at["detected"] % $at["pictures"] ? $at["p_at_50"] : ($at["detected"] / $at["pictures"] * all + 0.5) / (all + 1) }
    function far(value, q, p) { return (value / (q / (1 - q) * (1 - p) / p) - 1) ^ 2 > 1e-12 }
    function once() { return share($at["pictures"] / $at["seeds"] / $at["draws"]) }
    NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; if (!at["odds_ratio"]) exit; next }
    $3 == "adversarial" { p = share($at["pictures"]); p_once = once(); ratio = $at["odds_ratio"]; low = $at["odds_ratio_low"]
      high = $at["odds_ratio_high"]; effect = $at["effect_p_at_50"]; found = $at["p_at_50"]
      if (low > ratio || (high != "inf" && high + 0 < ratio) || $at["effect_p_at_50_low"] > effect || effect > $at["effect_p_at_50_high"]) bad = $1 " " $2 ": outside" }
    $3 == "matched noise" { q = share($at["pictures"])
      if ((far(ratio, q, p) && far(ratio, once(), p_once)) || ($at["p_at_50"] - found - effect) ^ 2 > 1e-12) bad = $1 " " $2 ": " ratio }
    END { if (bad) { print FILENAME ": " bad; exit 1 } }' "$csv" || fail "not those of its counts"
done

# In the page of the benchmarks each table of figures has the commit that brought it: as many of them in a section as tables.
awk '/^## / { section = $0 }
     /^\|---/ { table = 1 } !/^\|/ { table = 0 }
     table && /[0-9]\.[0-9]/ { tables[section]++; table = 0 }
     { commits[section] += gsub(/\([0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f][0-9a-f]\)/, "") }
     END { for (section in tables) if (commits[section] < tables[section]) {
             print "benchmarks/README.md, " section ": " tables[section] " tables, " commits[section] + 0 " commits"; bad = 1 }
           exit bad }' benchmarks/README.md || fail "say of each table which commit it was measured with"
echo "$checked figures in $parts parts"
