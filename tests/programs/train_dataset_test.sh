#!/usr/bin/env bash
# train_detector over own labelled pictures: label forms, learning, bits after a stop, written files, refusals.
source "$(dirname "$0")/support.sh"
train=$programs/train_detector
evaluate=$programs/evaluate
assets=$sources/examples/assets
export_detector=$programs/../tests/programs/export_detector
[ -x "$train" ] && [ -x "$export_detector" ] && [ -e "$assets/detector.weights" ] || exit 77
"$export_detector" . || fail "the models to train are not written"

# Drawn frames as pictures, labelled with the bundled detector's boxes, in three forms; one picture is empty.
mapfile -t frames < <(ls "$assets"/frames/test/*.npz | head -n 6)
expect_exit 0 "pictures" "$programs/detect" --confidence 1 --annotate drawn "${frames[@]}"
mkdir -p yolo/images yolo/labels voc
for frame in "${frames[@]}"; do
  name=$(basename "$frame" .npz)
  mv "drawn/$name-detections.png" "yolo/images/$name.png"
  boxes_of "yolo/images/$name.png" | awk '$2 >= 0 && $3 >= 0' >"$name.boxes"
  [ "$frame" != "${frames[1]}" ] || : >"$name.boxes"
  label_picture "$name" voc 0 1
done
echo "{\"images\": [$(joined images.part)], \"annotations\": [$(joined annotations.part)], \"categories\":
  [{\"id\": 0, \"name\": \"vehicle\"}, {\"id\": 1, \"name\": \"van\"}, {\"id\": 2, \"name\": \"clutter\"}]}" >coco.json
coco=(--dataset coco.json --images yolo/images --classes vehicle=car)
bundled=(--cfg "$assets/detector.cfg" --weights "$assets/detector.weights" --names "$assets/detector.names" --size 96)
short=(--batch 2 --steps 3 --validate-every 2 --learning-rate 0.001)

# The three forms are the same boxes: training on them gives the same bits.
expect_exit 0 "COCO" "$train" "${coco[@]}" "${bundled[@]}" "${short[@]}" --threads 2 --output coco
grep -q '^learns from coco.json: 5 pictures, . without objects, .*car [1-9]' command.out && pass || fail "no count of objects"
grep -q '^held out of it, a share of 0.2 drawn by the seed: 1 pictures' command.out && pass || fail "no word on what is held out"
for file in detector.onnx detector.names history.csv metrics.json manifest.json report.html checkpoint.npz; do expect_file "coco/$file"; done
expect_exit 0 "YOLO" "$train" --dataset yolo --dataset-names "$assets/detector.names" "${bundled[@]}" "${short[@]}" --threads 1 --output yolo.run
expect_exit 0 "VOC" "$train" --dataset voc --images yolo/images "${bundled[@]}" "${short[@]}" --output voc.run
expect_same_files coco yolo.run detector.onnx history.csv
expect_same_files coco voc.run detector.onnx history.csv
cmp -s coco/checkpoint.npz yolo.run/checkpoint.npz && fail "two runs with one identity" || pass

# From random weights: the loss falls, and the written file measures as in memory.
fresh=(--dataset yolo --validation yolo --dataset-names "$assets/detector.names" --size 64 --batch 4 --steps 150 --validate-every 60)
expect_exit 0 "random weights" "$train" "${fresh[@]}" --output fresh
awk -F , 'NR > 1 && NR <= 31 { first += $5 } NR > 121 { last += $5 } END { exit !(NR == 151 && last < 0.8 * first) }' fresh/history.csv &&
  pass || fail "the loss does not fall: $(sed -n '2p;$p' fresh/history.csv)"
expect_exit 0 "measured from the file" "$evaluate" --dataset yolo --dataset-names "$assets/detector.names" --weights fresh/detector.onnx \
  --names fresh/detector.names --size 64 --json fresh.json
[ "$(grep -m 1 '"ap50"' fresh.json | tr -d ' ,')" = "$(sed -n '/"tuned"/,$p' fresh/metrics.json | grep -m 1 '"ap50"' | tr -d ' ,')" ] &&
  pass || fail "the file measures otherwise than the run: $(grep -m 1 ap50 fresh.json)"

# Stopped, and killed, and resumed: the same bits.
"$train" "${fresh[@]}" --save-every 1000 --threads 1 --verbose --output stopped >/dev/null 2>stopped.err &
process=$!
wait_for 60 grep -q '^step 4 ' stopped.err
stop TERM "$process"
[ $? -eq 143 ] && pass || fail "SIGTERM does not end with 143"
expect_exit 7 "resumed with other settings" "$train" --resume --output stopped --steps 9
eval "go_on() { $(grep -- ' --resume ' stopped.err); }"
expect_exit 0 "resumed" go_on
expect_same_files fresh stopped detector.onnx history.csv
kill_until_done killed 4 2 "$train" "${fresh[@]}" --save-every 7
expect_same_files fresh killed detector.onnx history.csv

# Early stopping; weights behind nodes Constant and batch normalisation, and such that is folded into them.
expect_exit 0 "weights behind nodes Constant" "$train" --dataset yolo --weights normalised.onnx --batch 2 --steps 40 --validate-every 1 \
  --patience 2 --learning-rate 1e-9 --output hidden
grep -q '^ended early: 2 validations without a better AP50' command.out && pass || fail "training goes on without a gain"
expect_exit 0 "the same with longer steps" "$train" --dataset yolo --weights normalised.onnx "${short[@]}" --patience 0 --output moved
[ "$(stat -c %s hidden/detector.onnx)" -eq "$(stat -c %s normalised.onnx)" ] && pass || fail "the model's file has another form"
expect_exit 0 "folded weights" "$programs/convert_weights" --fold "${bundled[@]:0:4}" --output folded.onnx
expect_exit 0 "training folded weights" "$train" "${coco[@]}" --weights folded.onnx --names "$assets/detector.names" --size 96 "${short[@]}" --output folded
expect_exit 0 "detecting with the outcome" "$programs/detect" --weights folded/detector.onnx "yolo/images/$name.png"

# What does not fit. (N30)
expect_exit 4 "a class that the detector does not know" "$train" --dataset coco.json --images yolo/images "${bundled[@]}" --output none
expect_error_line 'coco.json: classes that the detector does not know; .* expected car, van, clutter, found vehicle'
expect_exit 2 "a class that the data set does not have" "$train" "${coco[@]}" lorry=car "${bundled[@]}" --output none
expect_error_line '--classes lorry=car: the data set has no such class; expected one of vehicle, van, clutter'
expect_exit 4 "boxes that the network decodes" "$train" --dataset yolo --weights decoded.onnx --detector decoded.json --output none
expect_error_line 'decoded.onnx: a head that cannot be trained'
expect_refusal 2 '--dataset-names is missing: yolo numbers its classes' "classes without names" "$train" --dataset yolo --output none
expect_exit 2 "options of drawn scenes" "$train" --dataset yolo --pool 3 --output none
expect_refusal 2 '--held-out needs --dataset' "options of own pictures" "$train" --held-out 0.5 --output none
echo "0 0.5 0.5 0.2" >"yolo/labels/$name.txt"
expect_exit 3 "a label that ends early" "$train" --dataset yolo "${bundled[@]}" --output none
expect_error_line "yolo/labels/$name.txt:1: label ends early; expected class cx cy w h"
sed -i 's/"width": [0-9]*/"width": 9/' coco.json
expect_exit 4 "another size" "$train" "${coco[@]}" "${bundled[@]}" --output none
expect_error_line '.png: the picture has another size than its labels state; expected 9x'
[ -e none ] && fail "a refused run left a folder behind" || pass
finish
