#!/usr/bin/env bash
# make_dataset from the outside.
source "$(dirname "$0")/support.sh"
needs make_dataset

frames() { "$make_dataset" --train 2 --test 3 --size 96 "$@"; }

expect_exit 0 "the bundled car" frames --output metres
[ "$(ls metres/train metres/test | grep -c npz)" = 5 ] && pass || fail "there are $(ls metres/*)"
expect_exit 0 "again on one thread" env TAPESTRY_THREADS=1 "$make_dataset" --train 2 --test 3 --size 96 --output again
for frame in train/0000 train/0001 test/0000 test/0001 test/0002; do expect_same "metres/$frame.npz" "again/$frame.npz"; done
cmp -s metres/train/0000.npz metres/test/0000.npz && fail "a frame is held out and optimised on" || pass
expect_exit 0 "another seed" frames --seed 2 --output other
cmp -s metres/test/0000.npz other/test/0000.npz && fail "the seed changes nothing" || pass

# One street: the camera is the same, the mask of the car is not.
expect_exit 0 "one street" frames --one-street --format png --output street
[ "$(grep -hA 1 --no-group-separator camera_fov street/test/*.json | grep -v camera | sort -u | wc -l)" = 1 ] && pass || fail "the camera changes in one street"
[ "$(grep -hA 1 --no-group-separator camera_fov street/*/*.json | grep -v camera | sort -u | wc -l)" = 2 ] && pass || fail "both parts have one street"
cmp -s street/test/masks/0000.png street/test/masks/0001.png && fail "the car stays as it is in one street" || pass
expect_exit 2 "one street in photographs" frames --one-street --backgrounds street --output no
expect_refusal 2 '^error: --one-street: of a hundred streets none shows the whole car' "one street from too near" frames --one-street --distance 0.5 0.6 --output no

# One folder, one data set; the same again is no other.
expect_exit 0 "the same again" frames --output metres
expect_same metres/test/0001.npz again/test/0001.npz
expect_same metres/manifest.json again/manifest.json
expect_exit 7 "another data set in its folder" "$make_dataset" --seed 2 --train 3 --test 3 --size 96 --output metres
expect_error_line '^error: metres holds another data set: --seed \(was 1, now 2\), --train \(was "2", now "3"\); give another --output$'
[ -e metres/train/0002.npz ] && fail "a refused data set was written" || pass
mkdir -p foreign/test && cp metres/test/0000.npz foreign/test
expect_refusal 7 'foreign holds frames without the manifest of this data set' "frames of nobody knows what" frames --output foreign
[ "$(ls -A foreign)" = test ] && pass || fail "a refused data set left $(ls -A foreign)"
"$make_dataset" --train 2000 --test 1 --size 96 --output twice >/dev/null 2>&1 &
process=$!
wait_for 10 [ -e twice/manifest.json ]
expect_refusal 7 "^error: twice: folder is in use by process $process on " "two at once in one folder" frames --output twice
stop KILL "$process"

# The preview alone, at first; it claims no folder for these options.
expect_exit 0 "a preview" frames --check --output look
expect_same look/preview.png metres/preview.png
[ "$(ls -A look)" = preview.png ] && pass || fail "a check wrote $(ls -A look)"
expect_exit 0 "another seed after a check" frames --seed 2 --output look
expect_exit 7 "a check of another set in its folder" frames --check --output look
grep -q 'assumed of the camera' command.out && fail "streets have a camera of ours" || pass

# An interrupted set is reported, and the same command completes it.
cp -r metres short && rm short/test/0002.npz
expect_exit 0 "a set that was broken off" "$programs/camouflage" --check --frames short
grep -q '^warning: short/test holds 2 of the 3 frames that make_dataset was to draw;' command.err && pass || fail "no word on missing frames"
expect_exit 0 "the rest of it" frames --output short
expect_same short/test/0002.npz metres/test/0002.npz
expect_exit 0 "a set that is whole" "$programs/camouflage" --check --frames short
grep -q 'make_dataset was to draw' command.err && fail "a whole set is warned of" || pass

# The same for make_assets, which makes the bundled files.
expect_exit 0 "the bundled assets" "$programs/make_assets" --test 3 --size 32 --output bundled
expect_exit 0 "more of them" "$programs/make_assets" --test 4 --size 32 --output bundled
expect_refusal 7 '^error: bundled/frames/test holds frames that are not replaced, such as bundled/frames/test/003.npz;' "fewer of them" "$programs/make_assets" --seed 2 --test 3 --size 32 --output bundled
[ -e bundled/.lock ] && fail "the lock is left behind" || pass

# camouflage reads the frames, also in the mesh's own units: a car in centimetres.
awk '$1 == "v" { printf "v %.9g %.9g %.9g\n", 100 * $2, 100 * $3, 100 * $4; next } { print }' \
  "$assets/car_sedan.obj" >centimetres.obj
cp "$assets/car_sedan.mtl" .
expect_exit 0 "centimetres" frames --mesh centimetres.obj --material body --length 4.8 --output centimetres
expect_exit 0 "camouflage takes them" "$programs/camouflage" --mesh centimetres.obj --material body \
  --frames centimetres --epochs 1 --batch 2 --texels 8 --output run
# In frames of metres the same car must be scaled: its size in the frames shows it.
plain=("$programs/camouflage" --material body --frames metres --epochs 1 --batch 2 --texels 8)
expect_refusal 4 'the mesh is 4[0-9]* long, and a car in metres 1 to 30: --scale 0.01 makes it 4' "units of a hundredth" "${plain[@]}" --mesh centimetres.obj --output none
expect_exit 0 "scaled" "${plain[@]}" --mesh centimetres.obj --scale 0.01 --output scaled
expect_exit 0 "resumed" "$programs/camouflage" --resume --output scaled
expect_exit 7 "resumed at another scale" "$programs/camouflage" --resume --output scaled --scale 1
expect_exit 0 "the car in metres" "${plain[@]}" --mesh "$assets/car_sedan.obj" --output unscaled
# Without frames to optimise on, the next command measures.
expect_exit 0 "held-out frames alone" "$make_dataset" --train 0 --test 1 --size 96 --output turn
next=$(sed -n 's/^next: //p' command.out)
[[ $next == 'evaluate --frames turn --run run    # '*'no frames to optimise on' ]] && pass || fail "next is: $next"
PATH=$programs:$PATH expect_exit 0 "$next" bash -c "${next/--run run/--run unscaled}"
grep -q '"scale": "0.01"' scaled/manifest.json && pass || fail "the manifest lacks the scale"
grep -q '"scale"' unscaled/manifest.json && fail "the manifest names a scale that was not given" || pass
awk -F , 'NR == FNR { best[$1] = $7; next } FNR > 1 && ($7 - best[$1]) ^ 2 > 0.01 ^ 2 { exit 1 } END { exit !(FNR > 5) }' \
  unscaled/metrics.csv scaled/metrics.csv && pass || fail "the scaled car is another car"
awk '$1 == "v" { printf "v %.9g %.9g %.9g\n", $2 / 10000, $3 / 10000, $4 / 10000; next } { print }' centimetres.obj >tiny.obj
expect_refusal 4 '^error: tiny.obj: the car covers at most .* of a frame.s picture; the mesh is .*: --scale 100 makes it 4' "units of hundreds of metres" "${plain[@]}" --mesh tiny.obj --output none
expect_exit 2 "no scale" "${plain[@]}" --mesh tiny.obj --scale 0 --output none
expect_exit 0 "from afar" frames --distance 20 30 --fov 20 25 --elevation 0 10 --occluded 0 --output afar

# Frames in three parts are the same frames.
expect_exit 0 "three parts" frames --format png --output parts
[ "$(ls parts/train parts/test parts/*/masks | grep -cE '\.(png|json)$')" = 15 ] && pass || fail "there are $(ls parts/*)"
start=(--epochs 1 --batch 2 --texels 8)
expect_exit 0 "camouflage takes them" "$programs/camouflage" --frames parts "${start[@]}" --output run_parts
expect_exit 0 "camouflage takes the others" "$programs/camouflage" --frames metres "${start[@]}" --output run_npz
expect_same run_parts/texture.npz run_npz/texture.npz
grep -q '"path": "parts/test/masks/0000.png"' run_parts/manifest.json && pass || fail "the manifest lacks a mask"
expect_exit 0 "evaluate takes them" "$programs/evaluate" --run run_parts
expect_exit 0 "the rest of a set in parts" frames --format png --output parts
expect_exit 7 "another format in its folder" frames --output parts
rm parts/test/masks/0001.png
expect_exit 7 "a mask is gone" "$programs/evaluate" --run run_parts
rm parts/train/0001.json parts/test/0002.png
expect_exit 4 "a set that was broken off" "$programs/camouflage" --check --frames parts
grep -q '^warning: parts/train holds 1 of the 2 frames' command.err && pass || fail "no word on missing frames: $(cat command.err)"
grep -q 'parts/test/0002.json: no picture beside the frame; expected parts/test/0002.png' command.err && pass || fail "$(cat command.err)"

# An object below a metre is as large in the picture as a car.
expect_refusal 4 "is 0.400000 m long, expected 1 to 20; --length" "a small car" frames --mesh "$assets/car_sedan.obj" --material body --length 0.4 --output small
expect_exit 0 "a small object" frames --mesh "$assets/car_sedan.obj" --material body --length 0.4 --object any --output small
expect_exit 0 "camouflage takes it" "$programs/camouflage" --mesh "$assets/car_sedan.obj" --object any --material body \
  --frames small "${start[@]}" --output run_small
expect_refusal 4 "is 0.100000 m long, expected 0.200000 to 20; --length" "a tiny object" frames --mesh "$assets/car_sedan.obj" --material body --length 0.1 --object any --output tiny

# Photographs: each either in train or in test.
mkdir photographs
for picture in a b c; do
  expect_exit 0 "a photograph" "$programs/render" --size 120 90 --azimuth "$((16#$picture))" --output "photographs/$picture.png"
done
expect_exit 0 "photographs" frames --backgrounds photographs --camera-height 2 --camera-pitch 8 --output photographed
grep -qx 'preview: photographed/preview.png' command.out && pass || fail "no path of the preview"
grep -qx 'assumed of the camera: field of view 50 to 60 degrees; set --fov to what is true' command.out && pass ||
  fail "what is assumed: $(cat command.out)"
expect_exit 0 "all is given" frames --backgrounds photographs --camera-height 2 --camera-pitch 8 --fov 60 60 --check --output given
grep -q 'assumed' command.out && fail "what is given is assumed" || pass
grep -q 'taken for grey asphalt; the sun.s direction and share are drawn at random$' command.out && pass || fail "the light is assumed in silence"
grep -q '^warning: photographs: 3 photographs are few' command.err && grep -q '^warning: photographs/a.png: [0-9]* % of neighbouring pixels are equal' command.err && pass ||
  fail "three drawings are taken for photographs without a word"
expect_refusal 2 '^error: --fov: one of 2 values is missing before --check; give one number twice for itself$' "one of two numbers" frames --backgrounds photographs --fov 90 --check --output given
# A report shows photographs in their own shape: 4 : 3 in an input of 256 x 256.
if [ -x "$programs/camouflage" ]; then
  expect_exit 0 "a run on wide frames" "$programs/camouflage" --frames photographed --texels 8 --epochs 1 --controls matched --output wide
  extents=$(od -A n -t u1 -j 16 -N 8 wide/result.png | awk '{ print ($3 * 256 + $4 - 4) % 260, 256 * $7 + $8 }')
  [ "$extents" = "0 $((2 * (192 + 4) + 4))" ] && pass || fail "result.png: $extents"
fi
[ "$(ls photographed/train photographed/test | grep -c npz)" = 5 ] && pass || fail "there are $(ls photographed/*)"
expect_exit 0 "camouflage takes them" "$programs/camouflage" --frames photographed --epochs 1 --batch 2 --texels 8 --output run2
printf 'no picture' >photographs/d.png
printf 'P6 1 1 255\n\377\200\100' >photographs/e.ppm
cp photographs/d.png photographs/f.WebP
expect_exit 0 "one unusable photograph" frames --backgrounds photographs --camera-height 2 --camera-pitch 8 --output three
grep -q '^warning: photographs/d.png:.*; the photograph is left out$' command.err && pass || fail "no word on it: $(cat command.err)"
grep -q '^warning: photographs/e.ppm: too small for a photograph; expected at least 64 pixels a side, found 1 x 1' command.err && pass ||
  fail "a street of one pixel: $(cat command.err)"
grep -q '^warning: 1 picture(s) such as photographs/f.WebP are left out' command.err && pass || fail "no word on a WebP"
rm photographs/[ef].*
expect_same three/test/0001.npz photographed/test/0001.npz
expect_refusal 4 "photographs: too few .*found 0, and 4 left out, such as photographs/a.png: the car does not lie in it" "a lens in which no car fits" frames --backgrounds photographs --fov 5 5 --output tele
rm photographs/[bcd].png
expect_refusal 4 "photographs: too few photographs .*expected at least 2.*found 1" "one photograph" frames --backgrounds photographs --output one
expect_refusal 3 "nowhere: cannot list the folder" "no folder" frames --backgrounds nowhere --output nowhere
expect_exit 2 "heights of a street's camera" frames --backgrounds photographs --elevation 1 2 --output mixed

# The mesh's own texture, on painted faces; the rest of the picture stays.
mkdir own && cp "$assets/car_sedan.obj" own/car.obj && cp "$assets/result.png" own/skin.png
sed 's/^newmtl body$/&\nmap_Kd skin.png/' "$assets/car_sedan.mtl" >own/car_sedan.mtl
cp -r own plain && cp "$assets/car_sedan.mtl" plain
expect_exit 0 "a car with a texture" frames --mesh own/car.obj --material body --output textured
grep -q warning command.err && fail "a texture is warned of: $(cat command.err)" || pass
grep -q own/skin.png textured/manifest.json && pass || fail "the texture is no input"
expect_exit 0 "the car without it" frames --mesh plain/car.obj --material body --output untextured
cmp -s textured/test/0001.npz untextured/test/0001.npz && fail "the texture is not drawn" || pass
expect_same untextured/test/0001.npz metres/test/0001.npz
awk '$1 == "usemtl" && $2 == "body" && ++parts % 2 { print "usemtl hood"; next } { print }' own/car.obj >plain/car.obj
printf 'P6 1 1 255\n\377\200\100' >plain/dot.ppm
for textures in one two; do
  { sed 's/^newmtl body$/&\nmap_Kd skin.png/' "$assets/car_sedan.mtl" && printf '\nnewmtl hood\nKd 0 1 0\n'; } >plain/car_sedan.mtl
  [ $textures = one ] || echo 'map_Kd dot.ppm' >>plain/car_sedan.mtl
  expect_exit 0 "a car of $textures" frames --mesh plain/car.obj --material body --output $textures
  grep -q texture command.err && fail "a texture is warned of: $(cat command.err)" || pass
done
cmp -s one/test/0001.npz two/test/0001.npz && fail "of two textures one is drawn" || pass
rm own/skin.png
expect_exit 0 "a texture that is gone" frames --mesh own/car.obj --material body --output gone
grep -q '^warning: own/skin.png: .*colours (Kd) stand in' command.err && pass || fail "no word on a texture that is gone"
expect_same gone/test/0001.npz metres/test/0001.npz

# The same car with y up and its front at +z: refused as it is, the same to the byte with options for its axes.
awk '$1 == "v" { print "v", $3, $4, $2; next } $1 == "vn" { print "vn", $3, $4, $2; next } { print }' \
  "$assets/car_sedan.obj" >y_up.obj
cp "$assets/car_sedan.obj" z_up.obj
expect_refusal 4 "y_up.obj: the mesh is .* high \(along z\) and .* long \(along x\), and does not stand on its wheels.*; --up y --forward z would right it" "a car on its nose" frames --mesh y_up.obj --material body --output nose
expect_refusal 4 "y_up.obj: the mesh is .* high" "a car on its nose, camouflaged" "$programs/camouflage" --check --mesh y_up.obj --material body
expect_exit 0 "no car" frames --mesh y_up.obj --object any --material body --check --output no_car
awk '$1 == "v" { print "v", $2, $4, -$3; next } $1 == "vn" { print "vn", $2, $4, -$3; next } { print }' \
  "$assets/van.obj" >side.obj
cp "$assets/van.mtl" .
expect_refusal 4 "side.obj: .*does not stand on its wheels.*; --up y --forward x would right it; --object any" "a van on its side" frames --mesh side.obj --material body --output side
expect_refusal 4 "van.obj: .*; --up z --forward x would right it" "a van upside down" frames --mesh "$assets/van.obj" --material body --up -z --output side
expect_refusal 4 "van.obj: .*; --up z --forward x would right it or, if that is its tail, --forward -x" "a van across" frames --mesh "$assets/van.obj" --material body --forward -y --output side
expect_exit 0 "the van righted" frames --mesh side.obj --up y --material body --check --output side
expect_exit 2 "no kind of object" frames --object truck --output kind
expect_exit 0 "a car with z up" frames --mesh z_up.obj --material body --output z_up
expect_exit 0 "a car with y up" frames --mesh y_up.obj --up y --forward z --material body --output y_up
for frame in train/0001 test/0002; do expect_same "z_up/$frame.npz" "y_up/$frame.npz"; done
for axes in "z z" "y -y" "up x"; do
  read -r up forward <<<"$axes"
  expect_exit 2 "axes $axes" frames --up "$up" --forward "$forward" --output axes
done
expect_error_line "--up is 'up'; expected one of x, y, z, -x, -y, -z"
expect_exit 0 "camouflage with y up" "$programs/camouflage" --mesh y_up.obj --up y --forward z --material body \
  --frames y_up --epochs 1 --batch 2 --texels 8 --output run_y_up
grep -q '"up": "y"' run_y_up/manifest.json && pass || fail "the manifest does not say what is up"
grep -q '"up"' run/manifest.json && fail "the manifest names an axis that was not given" || pass
expect_exit 0 "the run again" "$programs/camouflage" --resume --output run_y_up
expect_exit 7 "resumed with another axis" "$programs/camouflage" --resume --output run_y_up --up z

expect_refusal 4 "centimetres.obj: the mesh is .* m long, expected 1 to 20; --length" "a car of hundreds of metres" frames --mesh centimetres.obj --material body --output long
expect_refusal 2 "--distance: 9.* is more than 8" "a range the wrong way round" frames --distance 9 8 --output turned
expect_exit 2 "no output" frames
finish
