#!/usr/bin/env bash
# The benchmark "autodiff" on small cases, with ours alone.
source "$(dirname "$0")/support.sh"
built=$programs/../benchmarks
[ -x "$built/autodiff" ] && [ -x "$built/autodiff_tapestry" ] || exit 77
mkdir alone && cp "$built/autodiff" "$built/autodiff_tapestry" alone
autodiff=(alone/autodiff --output results --rounds 2 --seconds 0.001)

expect_exit 0 "three cases" "${autodiff[@]}" --case '^iou$|speelpenning|bundle-jacobian'
csv=results/autodiff.csv
[ "$(head -n 1 $csv)" = "case,variant,threads,seconds,error,memory_mib,spread,version,commit,compiler,instruction_set,processor" ] && pass || fail "header: $(head -n 1 $csv)"
for row in iou,{plain,hand,scalar,hessian-product,array,array-float},1 iou,scalar,2 speelpenning,scalar-8-roots,1 \
  bundle-jacobian,{scalar,dual,compressed},1; do
  grep -Eq "^$row(,[0-9][0-9.e+-]*){4},[0-9]" $csv && pass || fail "no numbers for $row"
done
grep -q "^iou,peer:adolc,1,,,,,[0-9]" $csv && pass || fail "a peer that was not built has a value"
grep -q "^speelpenning,array" $csv && fail "a product of numbers has no array form" || pass
awk -F, 'NR > 1 && $5 != "" && !($4 > 0 && $5 >= 0 && $6 > 0 && $5 < ($2 == "array-float" ? 1e-5 : 1e-13))' $csv >wrong.csv
[ -s wrong.csv ] && fail "impossible numbers: $(cat wrong.csv)" || pass
grep -q "<svg" results/autodiff.svg && grep -q "compressed" results/autodiff.svg && pass || fail "no figure"
ls results/autodiff-files | grep -q answer && fail "answers are left behind" || pass
expect_exit 0 "few turns" alone/autodiff --output results --quick --case '^iou$'
expect_exit 2 "no such case" "${autodiff[@]}" --case iuo
expect_exit 2 "a pattern that is none" "${autodiff[@]}" --case '('
finish
