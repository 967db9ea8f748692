#!/usr/bin/env bash
# harden with ONNX models, of heads without anchors: what is written, bits, resuming after any death, refusals.
source "$(dirname "$0")/support.sh"
export_detector=$programs/../tests/programs/export_detector
needs harden
[ -x "$export_detector" ] || exit 77
"$export_detector" . || fail "the models to harden are not written"
mkdir frames && cp "$assets"/frames/test/00[0-3].npz frames
tiny=(--frames frames --scenes 8 --texels 16 --rounds 2 --attack-steps 3 --steps 3 --pictures 4 --epochs 1 --batch 4
  --checkpoint-steps 2 --class 0)
results="hardened.onnx history.csv metrics.csv views.csv report.md report.txt transfer.png adaptive_undefended.png
  adaptive_hardened.png"

expect_exit 0 "a short run" "$harden" "${tiny[@]}" --weights yolox.onnx --threads 2 --output two
for file in $results manifest.json metrics.json checkpoint.npz; do expect_file "two/$file"; done
[ "$(wc -l <two/history.csv)" -eq 7 ] && pass || fail "history.csv has not one line a step of the weights"
awk -F, 'NR > 1 && !($3 > 0 && $4 > 0 && $5 > 0) { bad = 1 } END { exit bad }' two/history.csv && pass ||
  fail "terms of the loss without objectness or classes"
[ "$(stat -c %s two/hardened.onnx)" -eq "$(stat -c %s yolox.onnx)" ] && pass || fail "the model's file has another form"
cmp -s two/hardened.onnx yolox.onnx && fail "the weights have not learnt" || pass

# The same bits with one thread, and killed at random moments and resumed.
expect_exit 0 "the same seed again, one thread" "$harden" "${tiny[@]}" --weights yolox.onnx --threads 1 --output one
for file in $results; do expect_same "one/$file" "two/$file"; done
kill_until_done killed 6 1 "$harden" "${tiny[@]}" --weights yolox.onnx
for file in $results; do expect_same "killed/$file" "two/$file"; done

# What comes out is a detector like others, and measures as it did in memory.
expect_exit 0 "evaluate with the hardened model" "$programs/evaluate" --clean-only --frames frames \
  --weights two/hardened.onnx --class 0
grep -q '^  clean .* of   4 ' command.out && pass || fail "evaluate does not measure the hardened model"
expect_exit 0 "a hardened model hardened again" "$harden" "${tiny[@]}" --weights two/hardened.onnx --output again
clean_row() { sed -n "s/^$1,clean,//p" "$2/metrics.csv"; }
[ -n "$(clean_row hardened two)" ] && [ "$(clean_row hardened two)" = "$(clean_row undefended again)" ] && pass ||
  fail "the model that was read back measures otherwise: $(clean_row undefended again), not $(clean_row hardened two)"

# Batch normalisation apart from the convolutions, weights behind nodes Constant; heads whose classes say everything.
expect_exit 0 "a model with batch normalisation and nodes Constant" "$harden" "${tiny[@]}" --weights normalised.onnx --output normalised
[ "$(stat -c %s normalised/hardened.onnx)" -eq "$(stat -c %s normalised.onnx)" ] && pass ||
  fail "the form of the file with batch normalisation"
expect_exit 0 "heads of the family distance" "$harden" "${tiny[@]}" --weights nanodet.onnx --output distance
awk -F, 'NR > 1 && !($3 == 0 && $4 > 0) { bad = 1 } END { exit bad || NR != 7 }' distance/history.csv && pass ||
  fail "objectness of a head without one"
expect_exit 0 "heads with anchors" "$harden" "${tiny[@]}" --weights yolov5.onnx --detector yolov5.json --output anchored
awk -F, 'NR > 1 && !($2 > 0 && $3 > 0 && $4 > 0) { bad = 1 } END { exit bad || NR != 7 }' anchored/history.csv && pass ||
  fail "terms of the loss of heads with anchors"
cmp -s anchored/hardened.onnx yolov5.onnx && fail "the weights of heads with anchors have not learnt" || pass

# Models that cannot learn here.
touch empty.onnx
expect_refusal 3 'empty.onnx' "an empty file" "$harden" "${tiny[@]}" --weights empty.onnx --output none
expect_exit 4 "boxes that the network decodes" "$harden" "${tiny[@]}" --weights decoded.onnx --detector decoded.json --output none
expect_error_line 'decoded.onnx: a head that cannot be trained; expected heads of raw outputs'
expect_exit 4 "a number in two roles" "$harden" "${tiny[@]}" --weights sharing.onnx --output none
expect_error_line 'sharing.onnx: weights cannot learn: written back they make another network'
mkdir models && cp two/hardened.onnx models
expect_exit 7 "a model that would be written over" "$harden" "${tiny[@]}" --weights models/hardened.onnx --output models
expect_error_line 'models/hardened.onnx is there already; give another --output'
expect_same models/hardened.onnx two/hardened.onnx
[ "$(ls models)" = hardened.onnx ] && pass || fail "something was written beside it"
cp two/manifest.json before.json
expect_exit 7 "resume with another model" "$harden" --resume --output two --weights nanodet.onnx
expect_same two/manifest.json before.json
expect_exit 6 "a loss that overflows" "$harden" "${tiny[@]}" --weights yolox.onnx --weight-rate 1e39 --output overflow
expect_error_line "harden: the detector's loss in step"
[ -e none ] && fail "a refused run left a folder behind" || pass
finish
