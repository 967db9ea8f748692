#!/usr/bin/env bash
# Paints and detectors of others: evaluate --paint, --pictures and --detections.
source "$(dirname "$0")/support.sh"
needs evaluate camouflage

mkdir frames && cp "$assets"/frames/test/00[0-7].npz frames
expect_exit 0 "a camouflage" "$programs/camouflage" --frames frames --texels 32 --epochs 20 --output run
expect_exit 0 "its measurement" "$evaluate" --run run --seed 1 --output own

# The texture as a picture is the same paint, with 8 bits a channel.
same='NR == FNR { found[$1] = $3; best[$1] = $7; next }
  FNR > 1 && (!($1 in found) || $3 != found[$1] || ($7 - best[$1]) ^ 2 > 0.02 ^ 2) { exit 1 }
  END { exit !(FNR > 10) }'
measured=(--frames frames --texels 32 --seed 1)
expect_exit 0 "the texture as a picture" "$evaluate" --paint run/texture.png "${measured[@]}" --output picture
awk -F , "$same" own/metrics.csv picture/metrics.csv && pass || fail "the picture of a paint is another paint"
grep -q '"paint": "run/texture.png"' picture/metrics.json && pass || fail "the metrics do not name the picture"
expect_exit 0 "a protocol on a picture" "$evaluate" --paint run/texture.png --texels 32 --protocol traffic --quick --controls matched \
  --size 128 --output traffic
grep -q '^all,all,adversarial,' traffic/traffic.csv && pass || fail "no row of the paint"
expect_exit 0 "its table" "$programs/tabulate" --output tables --name paints theirs=traffic
grep -q '^theirs,' tables/paints.csv && pass || fail "no row of another's paint"
# Without a description the picture spans u from 0 to 1 and repeats: two copies side by side are the same paint.
mkdir plain && cp run/texture.png plain/once.png
expect_exit 0 "without a description" "$evaluate" --paint plain/once.png "${measured[@]}"
grep -q 'plain/once.png: no description beside it; assumed: its width is 1 in u' command.out command.err && pass || fail "assumed in silence"
# The mesh's own material may name the paint: clean would be the camouflage. A copy of other bytes and size is the same paint.
expect_exit 4 "clean is the paint" "$evaluate" --paint run/painted.png --mesh run/painted.obj --material paint --frames frames
expect_error_line '^error: run/painted.obj: run/painted.mtl gives painted faces the texture run/painted.png .map_Kd., which is the paint run/painted.png: '
mkdir twin && cp run/painted.{obj,mtl} twin
expect_exit 0 "the paint once more" "$programs/render" --mesh run/painted.obj --material paint --texture run/painted.png --size 32 \
  --export twin/painted.obj --output look.png
expect_exit 4 "a protocol of it" "$evaluate" --paint run/painted.png --mesh twin/painted.obj --material paint_ --protocol traffic \
  --quick --controls matched
expect_error_line 'twin/painted.mtl gives painted faces the texture twin/painted.png'
expect_refusal 4 'which is the paint run/texture.png' "the run's own texture" "$evaluate" --paint run/texture.png --mesh run/painted.obj --material paint --frames frames --texels 32
sed -i '/^map_Kd/d' twin/painted.mtl
expect_exit 0 "without it" "$evaluate" --paint run/painted.png --mesh twin/painted.obj --material paint_ --frames frames --texels 16
grep -q '^warning: run/painted.png: its 32 rows are averaged to the 16 of the atlas; --texels 32 keeps them$' command.err && pass ||
  fail "averaged in silence"
expect_exit 2 "two camouflages" "$evaluate" --paint run/texture.png --run run
expect_refusal 2 '^error: --paint needs --texture atlas' "a picture on a cube" "$evaluate" --paint run/texture.png --texture cube --frames frames
expect_exit 3 "no picture" "$evaluate" --paint nothing.png --frames frames

# A protocol in pictures: our own boxes without suppression, read back from a file, make every cell of our own tables; --results
# cuts boxes at the picture, which near these cars it need not.
mkdir few && cp frames/00[0-3].npz few
expect_exit 0 "a second seed" "$programs/camouflage" --frames frames --texels 32 --epochs 1 --seed 2 --output second
# Every cell of a table, but average precision within .01: it also counts how well boxes fit that are cut.
expect_cells() { # FILE FILE
  awk -F , 'FNR == 1 { for (i = 1; i <= NF; i++) precision[i] = $i ~ /^ap(50)?$/ }
    { line = ""; for (i = 1; i <= NF; i++) line = line "," (precision[i] && FNR > 1 ? "" : $i) }
    NR == FNR { lines = FNR; whole[FNR] = line; for (i = 1; i <= NF; i++) cell[FNR, i] = $i; next }
    line != whole[FNR] { exit bad = 1 }
    { for (i = 1; i <= NF; i++) if (precision[i] && FNR > 1 && ($i - cell[FNR, i]) ^ 2 > 0.01 ^ 2) exit bad = 1 }
    END { exit bad || FNR != lines }' "$1" "$2" && pass || fail "$1 and $2 differ: $(diff "$1" "$2" | head -n 4)"
}
measured_twice() { # PROTOCOL RUN LEAST OPTION...
  local of=$1-$2
  expect_exit 0 "pictures of $of" "$evaluate" --run "$2" --protocol "$1" --quick --controls matched --size 128 "${@:4}" --pictures "$of" --output "$of-own"
  expect_exit 0 "boxes in $of" "$evaluate" --dataset "$of/instances.json" --size 128 --confidence "$3" --nms 1 --most-detections 10000 \
    --results "$of.json"
  mkdir -p far && mv "$of.json" far/far.json
  expect_exit 0 "tables of $of" "$evaluate" --pictures "$of" --detections far/far.json --nms 0.45 --run "$2" --output "$of-far"
  sed 's/^photographs,detector/photographs,far/' "$of-own/$1.csv" >own.csv
  expect_cells own.csv "$of-far/$1.csv"
}
measured_twice digital second 0 --frames few --noise-draws 2
measured_twice physical run 1e-6
expect_same physical-run-own/frames.csv physical-run-far/frames.csv
measured_twice digital run 0 --frames few --noise-draws 2
sed '2,$s/^detector,/far,/' digital-run-own/photographs.csv >own.csv
expect_same own.csv digital-run-far/photographs.csv
[ "$(find digital-run -name '*.png' | wc -l)" -eq 28 ] && pass || fail "not 4 views in 7 paints"
for by in own far; do
  expect_exit 0 "a table by $by" "$programs/tabulate" --output table-$by a=digital-run-$by,digital-second-$by
  sed 's/,detector,/,far,/' table-$by/table.csv >$by.csv
done
expect_cells own.csv far.csv
awk -F , '$3 == "adversarial" && $4 == 2 && $6 == 8 || $3 == "matched noise" && $5 == 2 || $3 == "picture noise" { rows++ } END { exit rows != 3 }' far.csv &&
  pass || fail "not two seeds, two draws and noise in pictures: $(cat far.csv)"
expect_exit 0 "both detectors" "$programs/tabulate" --output both a=digital-run-own,digital-run-far
sed -i 's/"confidence": 0.25/"confidence": 0.5/' digital-second-far/settings.json
expect_refusal 4 'digital-run-far has confidence 0.25, digital-second-far has 0.5' "two thresholds" "$programs/tabulate" --output none \
  a=digital-run-far,digital-second-far
# What is unknown of the confidences of a program without weak detections; the page shows its boxes.
expect_exit 7 "a folder that holds pictures" "$evaluate" --run run --pictures digital-run
foreign=("$evaluate" --pictures digital-run --quiet --threads 1 --detections)
echo '[]' >none.json
expect_exit 0 "a silent program" "${foreign[@]}" none.json --output silent
expect_words silent/digital.md 'no confidence below 1; where no box overlaps the car it counts as 0, in 8 of 8 pictures with matched noise and 4 of 4' \
  'the effect on best confidence may be up to 1.000 more or 1.000 less'
awk -F , '$3 == "clean" && $7 == 0 && $21 == 0 && $22 == 0 { found++ } END { exit !found }' silent/digital.csv && pass || fail "found without a detection"
sheet() { grep -o '"data:image/png;base64,[^"]*"' "$1/digital.html" | sha256sum; }
[ "$(sheet silent)" != "$(sheet digital-run-far)" ] && grep -q 'Boxes above the confidence' silent/digital.html && pass || fail "no boxes in the pictures"
expect_refusal 2 '^error: --sweep has no part in --detections' "a sweep" "${foreign[@]}" none.json --sweep 0.5
expect_refusal 2 '^error: --pictures has no part in --protocol attention; digital does' "heat maps" "$evaluate" --run run --protocol attention --pictures none
expect_refusal 2 '^error: --conditions has no part in --protocol' "photographs of the views" "$evaluate" --run run --conditions light --pictures none
for entry in '{"image_id": 97, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}' \
  '{"image_id": 1, "category_id": 4, "bbox": [1, 2, 3, 4], "score": 0.5}'; do
  echo "[$entry]" >wrong.json
  expect_refusal 4 '^error: wrong.json:entry 1: there is no (picture 97|category 4)' "an entry of nothing" "${foreign[@]}" wrong.json
done
echo '[{"image_id": 1, "category_id": 1, "bbox": [1, 2, 3], "score": 0.5}]' >wrong.json
expect_refusal 3 '^error: wrong.json:entry 1: a value of another kind, or too few of them$' "a box of three numbers" "${foreign[@]}" wrong.json
for fault in '"score": "x"|expected number, found string' "\"sure\": 1|no member 'score'"; do
  echo "[{\"image_id\": 1, \"category_id\": 1, \"bbox\": [1, 2, 3, 4], ${fault%|*}}]" >wrong.json
  expect_refusal 3 "^error: wrong.json:entry 1: ${fault#*|}\$" "a member of another kind" "${foreign[@]}" wrong.json
done
sed 's/"image_id": 3,/"image_id": 4,/' digital-run/instances.json >moved && mkdir moved_pictures && mv moved moved_pictures/instances.json
expect_refusal 3 'not the pictures of evaluate --pictures: image 3 in another place' "labels in another order" "$evaluate" --pictures moved_pictures --detections none.json
expect_refusal 3 '^error: frames: no instances.json in it; expected a folder that evaluate --pictures has written$' "no pictures" "$evaluate" \
  --pictures frames --detections none.json
expect_refusal 3 '^error: .: no manifest.json in it; expected a folder that camouflage has written, such as ./' "no run" "$evaluate" --run .
expect_refusal 2 '^error: --seed has no part in --detections' "detections with a seed" "${foreign[@]}" none.json --seed 2

# Exported pictures are compared by their hashes; the run by its paint.
again=("${foreign[@]}" none.json)
expect_exit 0 "labels as they were" "${again[@]}"
grep -q '^written: ' command.out && fail "--quiet is not heard" || pass
expect_refusal 4 '^error: digital-run/instances.json: pictures of another paint than second/texture.npz' "pictures of another run" "${again[@]}" --run second
cp digital-run/000020.png kept.png && cp digital-run/000021.png digital-run/000020.png
expect_refusal 4 '^error: digital-run/000020.png: not as evaluate --pictures wrote it; expected SHA-256 [0-9a-f]{64}, found SHA-256 [0-9a-f]{64}$' "an exchanged picture" "${again[@]}"
rm digital-run/000020.png
expect_refusal 3 '^error: digital-run/000020.png: cannot open' "a picture that is gone" "${again[@]}"
cp kept.png digital-run/000020.png
cp digital-run/instances.json kept.json
sed -i 's/"name": "van"/"name": "bus"/' digital-run/instances.json
expect_refusal 4 '^error: digital-run/instances.json: not as evaluate --pictures wrote it; expected SHA-256 ' "edited labels" "${again[@]}"
tr -d '\n' <kept.json >digital-run/instances.json
expect_exit 0 "labels laid out in another way" "${again[@]}"
# Corners in the place of sides.
expect_exit 0 "detections" "$evaluate" --dataset digital-run/instances.json --size 128 --results results.json
awk 'BEGIN { RS = "\"bbox\":[[ ]*"; ORS = "" } NR == 1 { print; next }
  { end = index($0, "]"); split(substr($0, 1, end - 1), n, ","); printf "\"bbox\": [%.6f, %.6f, %.6f, %.6f]", n[1], n[2], n[1] + n[3], n[2] + n[4]
    print substr($0, end + 1) }' results.json >corners.json
expect_refusal 4 '^error: corners.json: bbox looks like left, top, right, bottom: .* boxes lie over their car.*; expected left, top, width, height' "corners" "${foreign[@]}" corners.json
finish
