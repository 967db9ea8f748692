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

# The published masks, of 608 pixels for frames of 800, under both of their names.
expect_exit 0 "masks of another size than their frames" "$programs/camouflage" --check --mask file \
  --mesh "$data/mesh/audi_et_te.obj" --material MI_CarExterior_Etron --frames "$data/carla"
mkdir -p published/masks && cp "$data"/carla/data*.npz published
for mask in "$data"/carla/mask*.png; do cp "$mask" "published/masks/data${mask##*/mask}"; done
expect_exit 0 "masks by the names of frames" "$programs/camouflage" --check --mask file \
  --mesh "$data/mesh/audi_et_te.obj" --material MI_CarExterior_Etron --frames published
expect_exit 0 "faces by number" "$programs/camouflage" --check --mesh "$data/mesh/audi_et_te.obj" \
  --faces "$data/mesh/exterior_face.txt" --frames "$data/carla"

# The report includes the effect on a detector the paint was not made for.
expect_exit 0 "transfer to another detector" "$programs/evaluate" --run real --size 416 \
  --cfg "$data/detectors/mobilenetv2-yolov3-nano.cfg" --weights "$data/detectors/mobilenetv2-yolov3-nano.weights" \
  --names "$data/detectors/coco.names" --class car
cat command.out
# Heat maps of the car's score: a picture beside each frame, by every kind of map.
yolox=(--weights "$data/detectors/yolox_nano.onnx" --names "$data/detectors/coco.names")
for kind in layer_cam grad_cam grad_cam_plus_plus; do
  expect_exit 0 "heat maps" "$programs/detect" "${yolox[@]}" --heat-map "$kind" --heat-map-kind $kind "$data/carla/data1.npz"
  expect_file "$kind/data1-heat_map.png"
done
cmp -s layer_cam/data1-heat_map.png grad_cam/data1-heat_map.png && fail "all kinds are one" || pass
expect_exit 4 "a layer that is not there" "$programs/detect" "${yolox[@]}" --heat-map none --layer nowhere "$data/carla/data1.npz"
expect_error_line "no node makes the layer 'nowhere'"
# Share of the attention on the car: largest on the plain car; the camouflage's share and pictures are printed.
expect_exit 0 "attention" "$programs/evaluate" --run real "${yolox[@]}" --size 416 --protocol attention --controls matched --output attention
grep -E '^attention on the car, % of the heat map: yolox_nano \(the car covers [0-9.]+ %' command.out && pass || fail "no shares of attention"
awk '/^attention on the car/ { inside = 1 } inside && $1 == "clean" { share = $2; exit } END { exit !(share > 60 && share <= 100) }' command.out && pass ||
  fail "the attention to the plain car is elsewhere"
awk -F , 'NR > 1 { rows++; if (!($5 >= 0 && $5 <= 1)) exit 1 } END { exit rows != 36 }' attention/photographs.csv && pass || fail "photographs.csv"
[ "$(grep -c 'src="data:image/png;base64,' attention/attention.html)" -eq 1 ] && pass || fail "no pictures in the page"
grep -o 'base64,[A-Za-z0-9+/=]*' attention/attention.html | cut -d , -f 2 | base64 -d >sheet.png && [ "$(head -c 4 sheet.png | tail -c 3)" = PNG ] && pass ||
  fail "the picture in the page is none"
cp attention/attention.html before.html
expect_exit 0 "attention again" "$programs/evaluate" --run real "${yolox[@]}" --size 416 --protocol attention --controls matched --output attention
grep -q ' for 0 frames' command.out && cmp -s attention/attention.html before.html && pass || fail "attention was measured again, or differs"
finish
