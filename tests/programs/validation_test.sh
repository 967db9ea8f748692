#!/usr/bin/env bash
# camouflage --validation: views that are not optimised on choose the epoch whose paint a run ends with.
source "$(dirname "$0")/support.sh"
needs camouflage

mkdir -p frames/train frames/test
cp "$assets"/frames/test/00[0-7].npz frames/train
cp "$assets"/frames/test/01[0-1].npz frames/test
shorter=("$camouflage" --frames frames --texels 16 --size 128 --batch 2 --learning-rate 0.5 --checkpoint-steps 1)
run=("${shorter[@]}" --epochs 5)
expect_exit 0 "a run" "${run[@]}" --validation 2 --output whole
number='[-+.0-9e]+'
scores=$(tr -d '\n' <whole/metrics.json | sed -nE 's/.*"max_score_by_epoch": \[([^]]*)\].*/\1/p')
[ "$(tr ',' '\n' <<<"$scores" | grep -cE "$number")" = 5 ] && pass || fail "not a score for each epoch: $scores"
best=$(sed -nE 's/^ *"best_epoch": ([0-9]+),$/\1/p' whole/metrics.json)
least=$(tr ',' '\n' <<<"$scores" | awk '{ if (NR == 1 || $1 < least) { least = $1; at = NR } } END { print at }')
[ "$best" = "$least" ] && pass || fail "epoch $best is not the best of $scores"
grep -q "paint of epoch $best of 5, the best on 2 further views" command.out command.err && pass || fail "nothing says which epoch: $(cat command.err)"

# The run ends with that epoch's paint: a run of so many epochs ends with the same.
expect_exit 0 "as many epochs" "${shorter[@]}" --validation 2 --epochs "$best" --output shorter
sed 1d whole/metrics.csv | grep '^adversarial,' >whole.row
sed 1d shorter/metrics.csv | grep '^adversarial,' >shorter.row
expect_same whole.row shorter.row

# Killed and resumed, the same files.
kill_until_done killed 6 2 "${run[@]}" --validation 2
for file in texture.npz best.npz texture.png metrics.csv; do expect_same "whole/$file" "killed/$file"; done

# With --patience it ends once so many epochs were no better, resumed or not.
patient=("${shorter[@]}" --validation 2 --epochs 40 --patience 2)
expect_exit 0 "patience" "${patient[@]}" --output patient
scores_of() { tr -d '\n ' <"$1/metrics.json" | sed -nE 's/.*"max_score_by_epoch":\[([^]]*)\].*/\1/p' | tr ',' '\n'; }
scores_of patient | awk '{ if (NR == 1 || $1 < least) { least = $1; at = NR } else if (NR < 40 && NR - at > 2) exit 1 }
  END { exit !(NR == 40 || NR - at == 2) }' && pass || fail "ended elsewhere: $(scores_of patient)"
epochs=$(scores_of patient | grep -c .)
[ "$epochs" -lt 40 ] && [ "$(sed 1d patient/history.csv | wc -l)" = $((3 * epochs)) ] && pass || fail "$epochs epochs, $(sed 1d patient/history.csv | wc -l) steps"
kill_until_done patient_killed 6 2 "${patient[@]}"
for file in texture.npz best.npz history.csv metrics.csv; do expect_same "patient/$file" "patient_killed/$file"; done
expect_refusal 2 '--patience needs --validation above 0' "patience for nothing" "${shorter[@]}" --patience 2 --output none

# The scores are of max_score whatever the loss is, so that runs can be compared.
for loss in paper vanish; do
  expect_exit 0 "$loss" "${run[@]}" --validation 2 --loss $loss --output $loss
  tr -d '\n ' <$loss/metrics.json | sed -nE 's/.*"max_score_by_epoch":\[([^]]*)\].*/\1/p' | tr ',' '\n' |
    awk '!($1 > 0) || $1 > 1 { exit 1 } END { exit NR != 5 }' && pass || fail "scores of $loss"
done
cmp -s paper/best.npz whole/best.npz && fail "the loss had no part in the run" || pass

# Held-out views were not optimised on.
expect_exit 0 "without validation" "${run[@]}" --output without
grep -q '"validation": null' without/metrics.json && pass || fail "a validation that nobody asked for"
cmp -s whole/texture.npz without/texture.npz && fail "the held-back views were optimised on" || pass
expect_refusal 2 '--validation 8: of 8 views that show the car none are left to optimise on' "no view left" "${run[@]}" --validation 8 --output none
[ -e none ] && fail "a refused run left a folder" || pass

# The kept paint belongs to the run.
expect_exit 0 "a run to damage" "${run[@]}" --validation 2 --output torn
rm torn/metrics.json torn/best.npz
expect_refusal 3 'torn/best.npz: the best paint so far is missing' "the best paint is lost" "$camouflage" --resume --output torn

# A 0 for "none" differs from a 0 that leaves the choice to the program.
expect_refusal 7 '--validation \(was 2, now 0\)' "resumed without validation" "$camouflage" --resume --validation 0 --output whole
expect_exit 0 "resumed with texels left open" "$camouflage" --resume --texels 0 --validation 2 --output whole
finish
