#!/usr/bin/env bash
# Detectors as torchvision exports them, whole, by one word: boxes, a camouflage whose loss falls, and its bits.
source "$(dirname "$0")/support.sh"
exports=${TAPESTRY_SHARED:-}/data/exports
[ -d "$exports" ] || {
  echo "skipped: no exports in TAPESTRY_SHARED"
  exit 77
}
printf '%s\n' none a b car d e >names
picture=$sources/examples/assets/result.png
loss() { awk -F, -v step="$2" '$1 == step { print $NF }' "$1/history.csv"; }

for model in faster_rcnn mask_rcnn retinanet ssd; do
  cp "$exports/$model"/leg1?.onnx "$model.onnx"
  of_class=(--class 0)
  [ "$model" = retinanet ] && of_class=(--names names --class car)
  expect_exit 0 "$model: boxes" "$programs/detect" --weights "$model.onnx" "${of_class[@]:0:$((${#of_class[@]} - 2))}" \
    --confidence 0.05 "$picture"
  grep -q 'taken for an export of the family torchvision' command.err && pass || fail "$model: it is not said what is assumed"
  grep -Eq 'width +[0-9.]+ +height' command.out && pass || fail "$model: no box"
done

for model in faster_rcnn retinanet; do
  of_class=(--class 0)
  [ "$model" = retinanet ] && of_class=(--names names --class car)
  run=("$programs/camouflage" --weights "$model.onnx" --detector torchvision "${of_class[@]}" --scenes 8 --epochs 10 --texels 16
    --checkpoint-steps 1)
  expect_exit 0 "$model: a camouflage" "${run[@]}" --threads 2 --output "$model"
  awk -v first="$(loss "$model" 1)" -v last="$(loss "$model" 10)" 'BEGIN { exit !(last < first) }' && pass ||
    fail "$model: the loss goes from $(loss "$model" 1) to $(loss "$model" 10)"
  expect_exit 0 "$model: on one thread" "${run[@]}" --threads 1 --output "$model.one"
  expect_same "$model/texture.npz" "$model.one/texture.npz"
  kill_until_done "$model.killed" 2 1 "${run[@]}"
  expect_same_files "$model" "$model.killed" texture.npz history.csv
done

expect_exit 2 "RetinaNet without names" "$programs/detect" --weights retinanet.onnx --detector torchvision "$picture"
expect_error_line 'do not tell the number of classes'
expect_refusal 4 'ssd.onnx' "another family" "$programs/detect" --weights ssd.onnx --detector yolov8 "$picture"
echo '{"head": "boxes_and_scores", "outputs": {"boxes": "/m/roi_heads/Reshape_2_output_0", "form": "corners",
  "scores": "/m/roi_heads/box_predictor/cls_score/Gemm_output_0", "boxes_of": "class", "score": "softmax",
  "background": "first", "candidates": 2}}' >few.json
expect_exit 8 "room for too few candidates" "$programs/detect" --weights faster_rcnn.onnx --detector few.json "$picture"
expect_error_line "candidates in a picture, at most 2; state more as 'candidates'"
finish
