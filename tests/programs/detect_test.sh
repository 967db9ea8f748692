#!/usr/bin/env bash
# detect and evaluate from the outside.
source "$(dirname "$0")/support.sh"
needs detect
frame=$(ls "$assets"/frames/test/*.npz | head -n 1)

expect_exit 0 "a table" "$detect" "$frame"
grep -q '^  car ' command.out && pass || fail "no car in the table"
expect_exit 0 "json" "$detect" --json --annotate drawn "$frame" "$frame"
for key in image detections class name confidence x y width height; do
  grep -q "\"$key\"" command.out && pass || fail "json lacks $key"
done
expect_file "drawn/$(basename "$frame" .npz)-detections.png"
expect_exit 0 "a PNG" "$detect" --json "drawn/$(basename "$frame" .npz)-detections.png"
confidence_of() { grep -o '"confidence": [0-9.]*' "$1" | head -n 1 | cut -d' ' -f2; }
expect_exit 0 "in float" "$detect" --json "$frame"
cp command.out float.json
expect_exit 0 "in bfloat16" "$detect" --json --precision bfloat16 "$frame"
grep -q '"precision": "bfloat16"' command.out && pass || fail "the precision is not told"
cmp -s <(grep confidence command.out) <(grep confidence float.json) && fail "--precision bfloat16 changes nothing" || pass
awk -v a="$(confidence_of float.json)" -v b="$(confidence_of command.out)" 'BEGIN { exit !(a > 0.5 && a - b < 0.05 && b - a < 0.05) }' &&
  pass || fail "the confidence is $(confidence_of command.out), $(confidence_of float.json) in float"
expect_refusal 2 '--precision .*half' "an unknown precision" "$detect" --precision half "$frame"
expect_refusal 3 'absent.png' "a missing picture" "$detect" absent.png
expect_exit 2 "no picture" "$detect"
mkdir copied && cp "$detect" copied && ln -s "$detect" linked
expect_refusal 3 'detector.*; this copy of the program has no bundled files beside it: make a link' "a copied program" copied/detect "$frame"
expect_exit 0 "a link to it" ./linked "$frame"
expect_exit 2 "weights without cfg" "$detect" --weights "$assets/detector.weights" "$frame"
head -c 5000 "$assets/detector.weights" >cut.weights
expect_refusal 3 'cut.weights' "cut weights" "$detect" --cfg "$assets/detector.cfg" --weights cut.weights "$frame"
printf '<html>not found</html>' >page.weights
expect_refusal 3 'page.weights.*HTML' "a page instead of weights" "$detect" --cfg "$assets/detector.cfg" --weights page.weights "$frame"


# Boxes with labels in the colours of their classes, cut at the edge of the picture; several pictures on one sheet.
copy="drawn/$(basename "$frame" .npz)-detections.png"
expect_exit 0 "nothing drawn" "$detect" --confidence 1 --annotate bare "$frame"
cmp -s "$copy" "bare/$(basename "$copy")" && fail "no box is drawn" || pass
expect_exit 0 "boxes of every size" "$detect" --json --confidence 0.01 --nms 1 "$assets"/frames/test/00?.npz
awk -F '[:,]' '/"x"/ { x = $2 } /"y"/ { y = $2 } /"width"/ { w = $2 }
  /"height"/ { n++; if (x < 0 || y < 0 || x + w > 256.001 || y + $2 > 256.001) bad++; if (x == 0 || y == 0) cut++ }
  END { exit !(n > 20 && !bad && cut) }' command.out && pass || fail "boxes are not cut at the edge of the picture"
expect_exit 0 "a sheet" "$detect" --sheet sheet.png "$assets"/frames/test/00[0-3].npz
side_of() { od -An -j"$2" -N4 -tu1 "$1" | awk '{ print $1 * 16777216 + $2 * 65536 + $3 * 256 + $4 }'; }
[ "$(side_of sheet.png 16)" = $((3 * 260 + 4)) ] && [ "$(side_of sheet.png 20)" = $((2 * 273 + 4)) ] && pass ||
  fail "the sheet is $(side_of sheet.png 16) x $(side_of sheet.png 20)"
for threads in 1 3; do
  expect_exit 0 "a sheet by $threads threads" "$detect" --threads $threads --sheet by-$threads.png "$assets"/frames/test/0[01]?.npz
done
expect_same by-1.png by-3.png
expect_exit 3 "a sheet without a broken picture" "$detect" --sheet of-sound.png absent.png "$assets"/frames/test/00[0-3].npz
expect_same of-sound.png sheet.png
expect_refusal 2 '--sheet takes a name that ends with .png' "a sheet that is no PNG" "$detect" --sheet sheet.jpg "$frame"
expect_refusal 2 '^error: --sheet would overwrite drawn/' "a sheet over a picture" "$detect" --sheet "./$copy" "$copy"
expect_exit 5 "a sheet that cannot be written" "$detect" --sheet nowhere/sheet.png "$frame"

# A network of 80 classes without names gets COCO's, with a message; else classes are numbers.
for classes in 80 79; do
  sed "s/^classes=.*/classes=$classes/" "$assets/detector.cfg" |
    awk -v filters=$((3 * (classes + 5))) '{ lines[NR] = $0 } /^filters=/ { last = NR } /^\[yolo\]/ { lines[last] = "filters=" filters }
      END { for (i = 1; i <= NR; i++) print lines[i] }' >classes$classes.cfg
  zeros() { { head -c 20 "$assets/detector.weights"; head -c "$1" /dev/zero; } >classes$classes.weights; }
  zeros 3000000  # too many: the error counts them
  "$detect" --cfg classes$classes.cfg --weights classes$classes.weights "$frame" 2>command.err >command.out
  zeros $((4 * $(sed -n 's/.*expected \([0-9]*\) floats.*/\1/p' command.err)))
  expect_exit 0 "a network of $classes classes" "$detect" --cfg classes$classes.cfg --weights classes$classes.weights \
    --size 32 --confidence 0.2 --nms 0 "$frame"
  cp command.out classes$classes.out
  cp command.err classes$classes.err
done
grep -q '^warning: classes80.weights: 80 classes and no --names; they are taken for those of COCO' classes80.err && pass ||
  fail "it is not said whose names are taken"
grep -q '^  person ' classes80.out && pass || fail "COCO's names are not taken"
grep -q 'COCO' classes79.err && fail "79 classes are taken for COCO's" || pass
grep -q '^  0 ' classes79.out && pass || fail "classes without names are not numbers"

# Placement of a picture on the input: by --fit, or letter_box of the cfg, or in a letterbox.
wide=$sources/examples/assets/result.png
weights=(--weights "$assets/detector.weights")
expect_exit 0 "the usual fit" "$detect" --json "$wide"
grep -q '"fit": "letterbox"' command.out && pass || fail "no letterbox without --fit"
cp command.out usual.json
expect_exit 0 "saying the usual fit" "$detect" --json --fit letterbox "$wide"
expect_same command.out usual.json
for fit in stretch letterbox_top_left; do
  expect_exit 0 "the fit $fit" "$detect" --json --fit $fit "$wide"
  cmp -s command.out usual.json && fail "--fit $fit changes nothing" || pass
  cp command.out $fit.json
done
expect_exit 0 "the fit in a table" "$detect" --fit stretch "$wide"
grep -q '^fit stretch, ' command.out && pass || fail "the table does not say its fit"
for value in 0 1; do sed "s/^\[net\]/[net]\nletter_box=$value/" "$assets/detector.cfg" >box$value.cfg; done
expect_exit 0 "letter_box=1" "$detect" --json --cfg box1.cfg "${weights[@]}" --names "$assets/detector.names" "$wide"
expect_same command.out usual.json
expect_exit 0 "letter_box=0" "$detect" --json --cfg box0.cfg "${weights[@]}" --names "$assets/detector.names" "$wide"
expect_same command.out stretch.json
expect_exit 0 "--fit above letter_box=0" "$detect" --json --cfg box0.cfg "${weights[@]}" \
  --names "$assets/detector.names" --fit letterbox "$wide"
expect_same command.out usual.json
expect_refusal 2 '^error: --fit' "an unknown fit" "$detect" --fit crop "$frame"

# Several pictures, one of them broken: it gets a message, the others their results. (F29)
head -c 900 "drawn/$(basename "$frame" .npz)-detections.png" >cut.png
mkfifo pipe.png
: >empty.png
for broken in cut.png pipe.png empty.png /dev/zero; do
  expect_refusal 3 "^error: $broken:" "$broken before a sound one" "$detect" --json --annotate beside "$broken" "$frame"
  grep -q '^1 of 2 pictures failed$' command.err && pass || fail "no count of failures"
  [ "$(grep -c '"image"' command.out)" = 1 ] && pass || fail "the sound picture is missing"
  expect_file "beside/$(basename "$frame" .npz)-detections.png"
done
expect_exit 3 "nothing but a broken one" "$detect" --json cut.png
[ "$(tr -d ' \n' <command.out)" = "[]" ] && pass || fail "not an empty array"
grep -q 'failed$' command.err && fail "a count of one" || pass

# Times by operator: sorted, of all operators, and adding up to the whole pass.
export_detector=$programs/../tests/programs/export_detector
[ ! -x "$export_detector" ] || "$export_detector" .
models=(bundled)
[ ! -e yolox.onnx ] || models+=(yolox.onnx)
for model in "${models[@]}"; do
  of_model=()
  [ "$model" = bundled ] || of_model=(--weights "$model")
  expect_exit 0 "a profile of $model" "$detect" "${of_model[@]}" --profile "$frame" "$frame"
  for title in forward "backward to the picture"; do
    sed -n "/^$title: calls and time of a pass, mean of 2\$/,/^  sum/p" command.out >profile.txt
    grep -q 'Conv  *[1-9]' profile.txt && pass || fail "the times $title of $model lack convolutions"
    awk -F '  +' '
      NR > 1 && !/^  (between|sum)/ { if (NR > 2 && $(NF - 1) + 0 > last) exit 1; last = $(NF - 1) + 0 }
      NR > 1 && !/^  sum/ { parts += $(NF - 1); shares += $NF }
      /^  sum/ { sum = $(NF - 1) + 0 }
      END { exit !(NR > 4 && sum > 0 && parts - sum < .0005 * NR && sum - parts < .0005 * NR && shares > 98 && shares < 102) }
    ' profile.txt && pass || fail "the times $title of $model do not add up, or are in disorder: $(cat profile.txt)"
  done
done
expect_exit 0 "a profile beside JSON" "$detect" --profile --json "$frame"
grep -q '^forward: ' command.err && ! grep -q '^forward: ' command.out && pass || fail "the profile is not on the standard error"
expect_same <(grep -v '^$' command.out) float.json
expect_exit 0 "no profile" "$detect" "$frame"
grep -q '^forward: ' command.out && fail "a profile that nobody wants" || pass

# Heat maps of the bundled detector; maps of .onnx models are in real_frames_test.sh.
expect_exit 0 "heat maps" "$detect" --heat-map last "$frame"
expect_exit 0 "heat maps of an early layer" "$detect" --heat-map early --layer 1 "$frame"
map="$(basename "$frame" .npz)-heat_map.png"
expect_file "last/$map"
cmp -s "last/$map" "early/$map" && fail "all layers are one" || pass
expect_refusal 4 'layer 999 cannot be observed' "a layer that is not there" "$detect" --heat-map maps --layer 999 "$frame"
expect_refusal 2 "layers of Darknet networks are numbers" "a layer by name" "$detect" --heat-map maps --layer conv1 "$frame"
expect_exit 2 "a layer of nothing" "$detect" --layer conv1 "$frame"
expect_refusal 2 '--heat-map-kind needs --heat-map' "a kind of nothing" "$detect" --heat-map-kind grad_cam "$frame"
expect_exit 2 "a heat map of no kind" "$detect" --heat-map maps --heat-map-kind warm "$frame"
expect_error_line "expected one of layer_cam, grad_cam, grad_cam_plus_plus"
[ -e maps ] && fail "a refused command left a folder behind" || pass

# Folders and lists.
mkdir -p many
cp "$assets"/frames/test/00[0-2].npz many
cp drawn/*-detections.png many/zz.png
echo text >many/notes.md
expect_exit 0 "a folder" "$detect" --json many
[ "$(grep -c '"image": "many/' command.out)" = 4 ] && pass || fail "not the pictures of the folder"
cp command.out folder.json
printf '000.npz\n001.npz\n\n002.npz\r\nzz.png\n' >many/list.txt
expect_exit 0 "a list" "$detect" --json many/list.txt
expect_same command.out folder.json
for i in {1..6}; do printf '00%d.npz\nabsent-%d.png\nzz.png\n' $((i % 3)) "$i"; done >many/mixed.txt
for threads in 1 3; do
  expect_exit 3 "a list with files that are not there" "$detect" --threads $threads --json many/mixed.txt
  cp command.out mixed-$threads.json
  cp command.err mixed-$threads.err
done
expect_same mixed-1.json mixed-3.json
expect_same mixed-1.err mixed-3.err
grep -o 'absent-.' mixed-3.err | tr -d '\n' | grep -qx 'absent-1absent-2absent-3absent-4absent-5absent-6' && pass ||
  fail "errors are not in the order of the list"
grep -q '^6 of 18 pictures failed$' mixed-3.err && pass || fail "no count of failures in a list"
mkdir none && : >none.txt
expect_refusal 3 '^error: none: no pictures in the folder' "a folder without pictures" "$detect" none
expect_refusal 3 '^error: none.txt.*no pictures in the list' "a list of nothing" "$detect" none.txt
expect_exit 3 "a list that is not there" "$detect" absent.txt
mkdir other && cp "$frame" other
expect_exit 2 "two pictures of one name" "$detect" --annotate untouched "$frame" "other/$(basename "$frame")"
[ -e untouched ] && fail "a refused command left a folder behind" || pass
# A copy is never written over a picture that is to be read: another thread might read either of them.
mkdir into_itself && cp "drawn/$(basename "$frame" .npz)-detections.png" into_itself/street.png
expect_exit 0 "copies beside the pictures" "$detect" --annotate into_itself into_itself
cp into_itself/street-detections.png copy_before.png
expect_exit 2 "copies over pictures" "$detect" --annotate ./into_itself "$PWD/into_itself"
expect_error_line '^error: ./into_itself: the copy of .*/street.png would be written over ./into_itself/street-detections.png, which is one'
expect_same into_itself/street-detections.png copy_before.png
# One process at a time writes copies into a folder, one of its own both kinds.
expect_exit 0 "both kinds of copies in one folder" "$detect" --annotate both --heat-map ./both "$frame"
[ "$(ls -A both | wc -l)" -eq 2 ] && pass || fail "the folder of both kinds holds $(ls -A both)"
for _ in $(seq 5000); do echo "$frame"; done >many.txt
"$detect" --annotate claimed many.txt >/dev/null 2>&1 &
process=$!
wait_for 10 [ -s claimed/.lock ]
expect_refusal 7 "^error: claimed: folder is in use by process $process on " "two at once in one folder" "$detect" --annotate claimed "$frame"
stop KILL "$process"
picture=$'not utf-8 \xff.png'
cp "drawn/$(basename "$frame" .npz)-detections.png" "$picture"
expect_exit 0 "a name that is not UTF-8" "$detect" --json "$picture"  # F21
expect_senseless "$detect $frame" "--confidence nan" "--nms 2" "--size -32" "--size 0x40" "--threads -1" "--threads 1000000"
expect_exit 4 "a size that does not divide" "$detect" --size 33 "$frame"
expect_refusal 2 'did you mean --json' "a misspelt option and no picture" "$detect" --jsn
printf 'car\nvan\n' >two.names
expect_exit 4 "too few names" "$detect" --cfg "$assets/detector.cfg" --weights "$assets/detector.weights" \
  --names two.names "$frame"
expect_error_line 'two.names.*expected 3, found 2'
"$detect" "$frame" >/dev/full 2>command.err
[ $? -eq 5 ] && pass || fail "a full standard output does not end with 5"

# Finite weights that overflow on the way.
expect_exit 6 "a step far too long" "$programs/train_detector" --steps 1 --batch 2 --validate 2 --learning-rate 1e30 \
  --output far.weights
far=(--cfg "$assets/detector.cfg" --weights far.weights)
expect_refusal 6 'expected a finite number' "outputs that are not finite" "$detect" "${far[@]}" "$frame"

evaluate=$programs/evaluate
expect_exit 6 "evaluate with such outputs" "$evaluate" --clean-only "${far[@]}" --names "$assets/detector.names"
expect_exit 2 "a threshold beyond 1" "$evaluate" --clean-only --sweep 0.5 2
expect_exit 2 "a confidence that is none" "$evaluate" --clean-only --confidence nan
mkdir nothing
expect_exit 4 "a folder without frames" "$evaluate" --clean-only --frames nothing --output absent
[ -e absent ] && fail "a refused evaluation left a folder behind" || pass
expect_exit 0 "evaluate without a texture" "$evaluate" --clean-only --sweep 0.1 0.9 --output measured
cp command.out table.out
expect_file measured/metrics.json
expect_exit 0 "evaluate at a threshold of the sweep" "$evaluate" --clean-only --sweep 0.5 --confidence 0.9
swept=$(awk '/^P@0.5 by confidence/ { on = 1 } on && $1 == "clean" { print $4 }' table.out)
direct=$(awk '$1 == "clean" { for (i = 1; i < NF; i++) if ($i == "P@0.5") { print $(i + 1); exit } }' command.out)
[ -n "$swept" ] && [ "$swept" = "$direct" ] && pass || fail "P@0.5 at 0.9 is $direct, in the sweep $swept"
expect_exit 2 "evaluate without a run" "$evaluate"
expect_exit 0 "evaluate another fit" "$evaluate" --clean-only --size 128 --fit letterbox_top_left --output corner
grep -q '"fit": "letterbox_top_left"' corner/metrics.json && pass || fail "the metrics do not say --fit"
grep -q '"fit"' measured/metrics.json && fail "the metrics say a fit that was not given" || pass
# Names that would give a terminal orders.
sed '1s/.*/\x1b[31mcar\x1b]0;title\x07/' "$assets/detector.names" >orders.names
expect_exit 0 "class names with control characters" "$detect" --cfg "$assets/detector.cfg" \
  --weights "$assets/detector.weights" --names orders.names "$frame"
cat command.out command.err | grep -q $'[\x1b\x07]' && fail "control characters reach the terminal" || pass
expect_exit 3 "a file name with control characters" "$detect" $'none\x1b[31m\n.png'
grep -q $'\x1b' command.err && fail "control characters reach the terminal" || pass
[ "$(grep -vc "^input of " command.err)" -eq 1 ] && pass || fail "an error of more than one line"

finish
