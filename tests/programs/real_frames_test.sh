#!/usr/bin/env bash
# The main job on real input: six simulator frames, the car in them, a detector trained on COCO.
source "$(dirname "$0")/support.sh"
data=${TAPESTRY_SHARED:-}/data
[ -d "$data/detectors" ] || {
  echo "skipped: no real data in TAPESTRY_SHARED"
  exit 77
}
detected() { grep -A3 "\"$1\": {" real/metrics.json | grep -m1 '"detected"' | tr -dc '0-9'; }

expect_exit 0 "camouflage on the real frames" "$programs/camouflage" \
  --mesh "$data/mesh/audi_et_te.obj" --material MI_CarExterior_Etron --frames "$data/carla" \
  --cfg "$data/detectors/yolo-fastest-1.1-xl.cfg" --weights "$data/detectors/yolo-fastest-1.1-xl.weights" \
  --names "$data/detectors/coco.names" --size 416 --class car --epochs 100 --output real
cat command.out
[ "$(detected photo)" -eq 6 ] && pass || fail "photo: the car is found in $(detected photo) of 6"
[ "$(detected clean)" -ge 5 ] && pass || fail "clean: the car is found in $(detected clean) of 6"
[ "$(detected adversarial)" -le 1 ] && pass || fail "adversarial: the car is found in $(detected adversarial) of 6"

expect_exit 4 "masks of another size than their frames" "$programs/camouflage" --check --mask file \
  --mesh "$data/mesh/audi_et_te.obj" --material MI_CarExterior_Etron --frames "$data/carla"
grep -q 'mask1.png.*800x800.*608x608' command.err && pass || fail "the message does not give both sizes"
expect_exit 0 "faces by number" "$programs/camouflage" --check --mesh "$data/mesh/audi_et_te.obj" \
  --faces "$data/mesh/exterior_face.txt" --frames "$data/carla"

# How the camouflage fares with a detector it was not made for is reported, whatever it is.
expect_exit 0 "transfer to another detector" "$programs/evaluate" --run real --size 416 \
  --cfg "$data/detectors/mobilenetv2-yolov3-nano.cfg" --weights "$data/detectors/mobilenetv2-yolov3-nano.weights" \
  --names "$data/detectors/coco.names" --class car
cat command.out
# Where the score of the car comes from: a picture beside each frame, by every kind of map.
yolox=(--weights "$data/detectors/yolox_nano.onnx" --names "$data/detectors/coco.names")
for kind in layer_cam grad_cam grad_cam_plus_plus; do
  expect_exit 0 "heat maps" "$programs/detect" "${yolox[@]}" --heat-map "$kind" --heat-map-kind $kind "$data/carla/data1.npz"
  expect_file "$kind/data1-heat_map.png"
done
cmp -s layer_cam/data1-heat_map.png grad_cam/data1-heat_map.png && fail "all kinds are one" || pass
expect_exit 4 "a layer that is not there" "$programs/detect" "${yolox[@]}" --heat-map none --layer nowhere "$data/carla/data1.npz"
expect_error_line "no node makes the layer 'nowhere'"
finish
