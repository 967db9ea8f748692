#!/usr/bin/env bash
# harden from the outside: what a run leaves behind, bits, resuming after any death, refusals.
source "$(dirname "$0")/support.sh"
needs harden
mkdir frames && cp "$assets"/frames/test/00[0-3].npz frames
budget=(--frames frames --scenes 12 --texels 16 --attack-steps 4 --steps 5 --pictures 4 --clean-scenes 8
  --test-scenes 4 --epochs 2 --batch 4 --checkpoint-steps 3)
tiny=("${budget[@]}" --rounds 2)
results="hardened.onnx history.csv metrics.csv views.csv report.md report.txt transfer.png adaptive_undefended.png
  adaptive_hardened.png"

expect_exit 0 "a short run" "$harden" "${tiny[@]}" --threads 2 --output two
for file in $results manifest.json metrics.json checkpoint.npz transfer.npz adaptive_undefended.npz adaptive_hardened.npz; do
  expect_file "two/$file"
done
grep -Eq '^hardening: round 2 of 2, step 18 of 18: .* left$' command.err && pass || fail "no word on how far the rounds are"
grep -Eq '^attacking the hardened detector \(adaptive_hardened\): step 6 of 6, .* left$' command.err && pass ||
  fail "no word on how far an attack is"

# The same rows for both detectors everywhere, each with its interval.
rows="photo clean transfer transfer_noise adaptive adaptive_noise random"
listed() { tr '\n' ' ' | sed 's/ $//'; }
for detector in undefended hardened; do
  [ "$(sed -n "s/^$detector,\([a-z ]*\),4,.*/\1/p" two/metrics.csv | tr ' ' _ | listed)" = "$rows" ] && pass ||
    fail "the rows of $detector in metrics.csv"
done
[ "$(sed -n 's/^  \([a-z ]*[a-z]\)  *[0-9.]* % \[.*/\1/p' two/report.txt | tr ' ' _ | listed)" = "$rows" ] && pass ||
  fail "the rows of report.txt"
[ "$(sed -n 's/^| \([a-z ]*\): .* |$/\1/p' two/report.md | tr ' ' _ | listed)" = "$rows" ] && pass || fail "the rows of report.md"
for key in undefended hardened gain adaptive mean_best_confidence ap50 held_out test_scenes seconds options; do
  grep -q "\"$key\"" two/metrics.json && pass || fail "metrics.json lacks $key"
done
grep -Eq 'under the adaptive attack [+-][0-9.]+ points \[' two/report.md && pass || fail "no gain in report.md"
# The verdict comes first, with the counts of metrics.csv; a small budget says what it leaves open.
verdict=$(awk -F , '{ found[$1 " " $2] = $4 } END { print "Under an attack on each, the undefended detector finds the car in " found["undefended adaptive"] \
  " of 4 held-out views, the hardened one in " found["hardened adaptive"] "; plain " found["undefended clean"] " undefended and " \
  found["hardened clean"] " hardened: " }' two/metrics.csv)
[[ $(head -n 1 two/report.txt) == "$verdict"* ]] && grep -qF "<p class=\"verdict\">$(head -n 1 two/report.txt)</p>" two/report.html && pass || fail "not $verdict"
grep -q 'may be too short to show an effect: 24 views each, where the default takes 2400 or more; leave out --quick' two/report.txt && pass || fail "no word on the budget"
[ "$(wc -l <two/history.csv)" -eq 11 ] && pass || fail "history.csv has not one line a step of the weights"

expect_exit 0 "the same seed again, one thread" "$harden" "${tiny[@]}" --threads 1 --output one  # T16
for file in $results; do expect_same "one/$file" "two/$file"; done
expect_exit 0 "another seed" "$harden" "${tiny[@]}" --seed 2 --output other
cmp -s other/hardened.onnx two/hardened.onnx && fail "another seed gives the same weights" || pass

# Killed at a random moment and resumed, again and again, until it is through: the same bits. (F01)
kill_until_done killed 12 2 "$harden" "${tiny[@]}"
for file in $results; do expect_same "killed/$file" "two/$file"; done

# Stopped politely: saves, and says how to go on. (F15)
"$harden" "${budget[@]}" --rounds 500 --output stopped >/dev/null 2>stopped.err &
process=$!
wait_for 30 grep -q '^hardening: ' stopped.err
stop INT "$process"
[ $? -eq 130 ] && pass || fail "SIGINT does not end with 130"
grep -q -- '--resume --output stopped' stopped.err && pass || fail "no word on how to resume"
expect_file stopped/checkpoint.npz

# Without an attack: a control of hardening, with the same bits after any death, and its false alarms.
plain=("${budget[@]}" --rounds 2 --paint none --attacks none)
expect_exit 0 "fine-tuned without a paint" "$harden" "${plain[@]}" --threads 1 --output plain
[ "$(sed -n "s/^hardened,\([a-z ]*\),4,.*/\1/p" plain/metrics.csv | tr ' ' _ | listed)" = "photo clean random" ] && pass ||
  fail "the rows without an attack"
grep -q 'false alarms a picture undefended' plain/report.txt && pass || fail "no word on false alarms"
grep -q '"false_alarms_a_picture": [0-9]' plain/metrics.json && pass || fail "no false alarms in metrics.json"
[ "$(wc -l <plain/history.csv)" -eq 11 ] && [ ! -e plain/transfer.png ] && pass || fail "a paint was optimised"
cmp -s plain/hardened.onnx two/hardened.onnx && fail "the paint changes nothing" || pass
kill_until_done plain_killed 4 1 "$harden" "${plain[@]}"
for file in hardened.onnx metrics.csv report.txt; do expect_same "plain_killed/$file" "plain/$file"; done

# What comes out is a detector like others.
expect_exit 0 "evaluate with the hardened detector" "$programs/evaluate" --clean-only --frames frames \
  --weights two/hardened.onnx --names "$assets/detector.names"
grep -q '^  clean .* of   4 ' command.out && pass || fail "evaluate does not measure the hardened detector"
expect_exit 0 "a hardened detector hardened again" "$harden" "${budget[@]}" --rounds 1 --output again \
  --weights two/hardened.onnx --names "$assets/detector.names"
expect_exit 0 "a detector of which only numbers are known" "$harden" "${budget[@]}" --rounds 1 --output numbers \
  --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" --class 0
grep -q '"ap50": [01]' numbers/metrics.json && pass || fail "no precision of the one class that the detector has of the scenes"

expect_refusal 7 'two already holds a run' "a folder that holds a run" "$harden" "${tiny[@]}" --output two  # F11
expect_refusal 7 '\-\-seed \(was 1, now 9\)' "resume with another seed" "$harden" --resume --output two --seed 9  # F12
expect_refusal 7 '\-\-rounds \(was 2, now 3\)' "resume with another budget" "$harden" --resume --output two --rounds 3
expect_exit 3 "resume where nothing is" "$harden" --resume --output nowhere
expect_exit 2 "resume without a folder" "$harden" --resume
cp -r two foreign && sed 's/"program": "harden"/"program": "camouflage"/' two/manifest.json >foreign/manifest.json
expect_exit 4 "resuming the run of another program" "$harden" --resume --output foreign
expect_error_line "foreign/manifest.json: the run of another program; expected harden, found 'camouflage'"
expect_exit 4 "evaluating a run that has no camouflage" "$programs/evaluate" --run two
expect_error_line "two/manifest.json: the run of another program; expected camouflage, found 'harden'"
cp -r two torn && head -c 3000 two/checkpoint.npz >torn/checkpoint.npz
expect_refusal 3 'torn/checkpoint.npz' "a cut checkpoint" "$harden" --resume --output torn
cp stopped/checkpoint.npz torn/checkpoint.npz
expect_refusal 7 'torn/checkpoint.npz: belongs to a run with other settings' "the checkpoint of another run" "$harden" --resume --output torn

expect_refusal 2 '--precision bfloat16 has no part in harden' "hardening in bfloat16" "$harden" "${tiny[@]}" --precision bfloat16 --output none

expect_senseless "$harden --output none" "--rounds 0" "--steps 0" "--pictures 0" "--pictures 5000" "--painted 1.5" "--weight-rate 0" "--batch 0" \
  "--learning-rate -1" "--smoothness-weight -1" "--epochs -1" "--clean-scenes 1000000" "--threads 1000000" \
  "--checkpoint-steps 0" "--weight-rate nan" # T04, T05
expect_exit 2 "an unknown loss" "$harden" --loss hinge --output none
expect_refusal 2 'did you mean --rounds' "a misspelt option" "$harden" --round 3
expect_exit 4 "a missing class" "$harden" --class unicorn --output none
[ -e none ] && fail "a refused run left a folder behind" || pass
expect_exit 6 "a loss that overflows" "$harden" "${tiny[@]}" --weight-rate 1e30 --output overflow  # T01
expect_exit 0 "help" "$harden" --help
grep -q -- '--weight-rate' command.out && pass || fail "help lacks an option"
finish
