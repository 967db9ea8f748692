#!/usr/bin/env bash
# evaluate --dataset from the outside: the same labels in four formats have the same average precision.
source "$(dirname "$0")/support.sh"
needs evaluate

# Four bundled frames as pictures without a drawn car, and the detector's boxes there, moved by a pixel.
mapfile -t frames < <(ls "$assets"/frames/test/*.npz | head -n 4)
expect_exit 0 "pictures" "$programs/detect" --confidence 1 --annotate drawn "${frames[@]}"
mkdir -p yolo/images yolo/labels voc/Annotations
for frame in "${frames[@]}"; do
  name=$(basename "$frame" .npz)
  mv "drawn/$name-detections.png" "yolo/images/$name.png"
  echo "images/$name.png" >>yolo/train.txt
  boxes_of "yolo/images/$name.png" | awk '{ $2++; $3++; print }' >"$name.boxes"
  # One more that no detector finds.
  echo "0 1 1 9 9" >>"$name.boxes"
  label_picture "$name" voc/Annotations 90 -1
done
awk '{ printf "{\"id\": %d, \"name\": \"%s\"}\n", 91 - NR, $0 }' "$assets/detector.names" >categories.part
echo "{\"images\": [$(joined images.part)], \"annotations\": [$(joined annotations.part)]," \
  "\"categories\": [$(joined categories.part)]}" >coco.json

expect_exit 0 "YOLO's labels" "$evaluate" --dataset yolo --csv yolo.csv --json yolo.json --results yolo.results.json
head -n 2 yolo.csv | tail -n 1 | awk -F , '$1 == "all" && $2 > 4 && $4 > 0.3 && $4 < 1 && $5 >= $4 { good = 1 } END { exit !good }' &&
  pass || fail "no sensible average precision: $(head -n 2 yolo.csv)"
grep -q '^  all ' command.out && pass || fail "no table"
grep -q '"ap50"' yolo.json && pass || fail "no AP50 in the JSON"
grep -q '"bbox":\[' yolo.results.json && pass || fail "no boxes in the results"
expect_exit 0 "a list" "$evaluate" --dataset yolo/train.txt --dataset-names "$assets/detector.names" --csv list.csv
expect_same yolo.csv list.csv
expect_exit 0 "COCO" "$evaluate" --dataset coco.json --images yolo/images --csv coco.csv --results coco.results.json
expect_exit 0 "VOC" "$evaluate" --dataset voc --images yolo/images --csv voc.csv --threads 1
# Classes come in the order of ids, names or numbers, and VOC has only those that occur: its detections have no others.
sorted() { sed -n '2p' "$1" | cut -d , -f 1,2,4-; sed '1,2d' "$1" | awk -F , '$2 > 0' | sort; }
for format in yolo coco voc; do sorted $format.csv >$format.sorted; done
expect_same yolo.sorted coco.sorted
expect_same yolo.sorted voc.sorted
grep -q '"category_id":90' coco.results.json && pass || fail "the results have other categories than the data set"
expect_exit 0 "a class left out" "$evaluate" --dataset coco.json --images yolo/images --classes van= --csv few.csv
grep -q '^"van",' coco.csv && ! grep -q '^"van",' few.csv && pass || fail "a class that is left out is measured"
expect_exit 0 "two detections a picture" "$evaluate" --dataset yolo --most-detections 2 --results two.json
[ "$(grep -c '"image_id":1,' two.json)" -eq 2 ] && pass || fail "more or less than two detections of the first picture"
grep -q ' van ' command.out && pass || fail "a class that has objects has no row"

# What does not fit.
expect_refusal 4 'coco.json:[0-9]+:[0-9]+: images\[0\].file_name is missing' "a picture that is missing" "$evaluate" --dataset coco.json
head -c 200 coco.json >cut.json
expect_refusal 3 'cut.json:[0-9]+:[0-9]+: not valid JSON; expected .*, found the end' "a cut JSON" "$evaluate" --dataset cut.json --images yolo/images
expect_exit 2 "a folder for images where there is none" "$evaluate" --dataset yolo --images yolo
expect_refusal 2 '^error: --clean-only has no part in --dataset' "a camouflage and a data set" "$evaluate" --dataset yolo --clean-only
expect_exit 2 "no detections" "$evaluate" --dataset yolo --most-detections 0
expect_refusal 2 '^error: --results needs --dataset' "results of nothing" "$evaluate" --clean-only --results results.json
expect_exit 2 "results over the data set" "$evaluate" --dataset coco.json --results coco.json
printf 'lorry\n' >other.names
expect_exit 4 "classes that nobody knows" "$evaluate" --dataset yolo --dataset-names other.names
expect_exit 3 "nothing there" "$evaluate" --dataset absent
expect_exit 2 "an unknown kind of file" "$evaluate" --dataset yolo.csv
expect_exit 5 "a folder that is not there" "$evaluate" --dataset yolo --csv absent/table.csv
[ -e absent ] && fail "a refused evaluation left something behind" || pass
sed -i 's/"width": [0-9]*/"width": 9/' coco.json
expect_refusal 4 'another size than its labels state; expected 9x' "another size" "$evaluate" --dataset coco.json --images yolo/images --csv none.csv
[ -e none.csv ] && fail "half of the answer was written" || pass

finish
