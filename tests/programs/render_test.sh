#!/usr/bin/env bash
# render from the outside.
source "$(dirname "$0")/support.sh"
needs render

size_of() { od -An -tu1 -j16 -N8 "$1" | awk '{ print $3 * 256 + $4, $7 * 256 + $8 }'; }

expect_exit 0 "the bundled car" "$render" --size 96 --output car.png
expect_file car.png
[ "$(size_of car.png)" = "96 96" ] && pass || fail "car.png is $(size_of car.png)"
expect_exit 0 "again" "$render" --size 96 --output again.png --threads 1
expect_same car.png again.png
for view in normal uv face coverage depth position; do
  expect_exit 0 "view $view" "$render" --size 96 --view "$view" --output "$view.png"
  cmp -s car.png "$view.png" && fail "view $view is the coloured picture" || pass
done
for samples in 1 2 8; do
  expect_exit 0 "$samples samples" "$render" --size 96 --samples "$samples" --output "samples$samples.png"
  cmp -s car.png "samples$samples.png" && fail "$samples samples are as 4" || pass
done
# Far away the bundled car's edges are shorter than half a pixel, close by longer than two.
for case in "8 8" "0.9 2"; do
  read -r distance samples <<<"$case"
  expect_exit 0 "automatic rate" "$render" --size 96 --distance "$distance" --samples 0 --output automatic.png
  expect_exit 0 "the same rate" "$render" --size 96 --distance "$distance" --samples "$samples" --output same.png
  expect_same automatic.png same.png
done
expect_exit 0 "width and height" "$render" --size 120 50 --output wide.png
[ "$(size_of wide.png)" = "120 50" ] && pass || fail "wide.png is $(size_of wide.png)"

# A sheet of two rows of five; each picture has a gap of 4 pixels around it.
expect_exit 0 "a turntable" "$render" --turntable 5 --distance 8 20 --size 40 --output sheet.png
[ "$(size_of sheet.png)" = "224 92" ] && pass || fail "sheet.png is $(size_of sheet.png)"

# Moving and transparent pictures, read by a program that shares nothing with ours.
expect_exit 0 "a turn" "$render" --size 48 --azimuth 30 --turntable 3 --seconds 1.5 --output turn.png
expect_exit 0 "a turn of it" "$render" --size 48 --azimuth 30 --turntable 3 --seconds 0.09 --transparent --output clear_turn.png
for turn in 30 150 270; do
  expect_exit 0 "a view" "$render" --size 48 --azimuth "$turn" --output "view$turn.png"
  expect_exit 0 "without a background" "$render" --size 48 --azimuth "$turn" --transparent --output "clear$turn.png"
done
expect_exit 0 "its coverage" "$render" --size 48 --azimuth 30 --view coverage --output covered.png
for view in colour normal; do
  expect_exit 0 "$view" "$render" --size 48 --azimuth 30 --view "$view" --transparent --output "clear_$view.png"
  expect_exit 0 "$view" "$render" --size 48 --azimuth 30 --view "$view" --background 0.3 0.6 0.5 --output "before_$view.png"
done
sun=(--light sun --light-direction 1 1 1 --size 48 --azimuth 30)
expect_exit 0 "a shadow before white" "$render" "${sun[@]}" --ground --output lit.png
expect_exit 0 "a shadow" "$render" "${sun[@]}" --ground --transparent --output shadow.png
if command -v python3 >/dev/null; then
  python3 -c 'import PIL' 2>/dev/null || echo "Pillow is not installed (python3-pil): frames are not compared with its reader"
  reads() { expect_exit 0 "moving_picture.py $*" python3 "$sources/tests/programs/moving_picture.py" "$@"; }
  reads frames turn.png 3 500 view30.png view150.png view270.png
  reads frames clear_turn.png 3 30 clear30.png clear150.png clear270.png
  reads opacity clear30.png covered.png
  reads over clear30.png 1 1 1 view30.png
  reads over clear_colour.png 0.3 0.6 0.5 before_colour.png
  reads over clear_normal.png 0.3 0.6 0.5 before_normal.png encoded
  reads shadow shadow.png lit.png
else
  echo "skipped: moving and transparent pictures are not read by another program; it needs python3"
fi
# Readers that know no moving pictures take the first view.
for still in turn view30; do
  expect_exit 0 "$still as a texture" "$render" --size 48 --material body --texture "$still.png" --output "$still-paint.png"
done
expect_same turn-paint.png view30-paint.png

# Paint: by material, by face list, as one colour and as a texture.
expect_exit 0 "red paint" "$render" --size 96 --material body --colour 1 0 0 --output red.png
cmp -s car.png red.png && fail "the paint does not show" || pass
seq 1 50 >faces.txt
expect_exit 0 "a face list" "$render" --size 96 --faces faces.txt --colour 1 0 0 --output some.png
cmp -s red.png some.png && fail "the face list does not count" || pass
expect_exit 0 "a texture" "$render" --size 96 --material body --texture car.png --output textured.png
expect_exit 0 "trilinear" "$render" --size 96 --material body --texture car.png --filter trilinear --output tri.png
cmp -s textured.png tri.png && fail "the filter does not show" || pass
expect_exit 0 "bilinear" "$render" --size 96 --material body --texture car.png --filter bilinear --output bi.png
cmp -s textured.png bi.png && fail "a texture is not filtered unless asked for" || pass
for light in none smooth sky sun; do
  expect_exit 0 "light $light" "$render" --size 96 --light "$light" --output "light.png"
  cmp -s car.png light.png && fail "light $light is the flat one" || pass
done
expect_exit 0 "ground" "$render" --size 96 --light sun --light-direction 1 1 1 --ground --output ground.png
cmp -s light.png ground.png && fail "the ground has no shadow" || pass
expect_exit 0 "a full grid" "$render" --turntable 8 --size 64 --output grid.png
[ "$(size_of grid.png)" = "276 140" ] && pass || fail "grid.png is $(size_of grid.png)"
expect_exit 0 "views too low for a label" "$render" --turntable 3 --size 200 5 --output low.png
expect_exit 0 "a clear coat" "$render" --size 96 --clear-coat 1 --output coated.png
cmp -s car.png coated.png && fail "a clear coat does not show" || pass
expect_exit 0 "a rough coat" "$render" --size 96 --clear-coat 1 --roughness 0.5 --output rough.png
cmp -s coated.png rough.png && fail "roughness does not show" || pass

# Numbers: 96 x 96 floats after a header of 128 bytes, a channel of a depth and three of the others.
for case in "depth 36992" "position 110720" "normal 110720"; do
  read -r view bytes <<<"$case"
  expect_exit 0 "$view as numbers" "$render" --size 96 --view "$view" --output "$view.npy"
  [ "$(wc -c <"$view.npy")" = "$bytes" ] && pass || fail "$view.npy has $(wc -c <"$view.npy") bytes"
done
# The middle pixel of a square at distance 2: its depth is 2, its place the origin, its normal towards the camera.
printf 'v 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nf 1 2 3 4\n' >square.obj
middle() { od -An -tf4 -j$((128 + 4 * $2 * (5 * 11 + 5))) -N$((4 * $2)) "$1" | tr -s ' '; }
for case in "depth 1 2" "position 3 0 0 0" "normal 3 1 0 0"; do
  read -r view channels expected <<<"$case"
  expect_exit 0 "$view of a square" "$render" --mesh square.obj --azimuth 0 --elevation 0 --distance 2 --size 11 \
    --view "$view" --output square.npy
  awk -v expected="$expected" '{ n = split(expected, e, " "); for (i = 1; i <= n; ++i) {
    d = $i - e[i]; if (d * d > 1e-10) exit 1 } }' <<<"$(middle square.npy "$channels")" && pass ||
    fail "$view is $(middle square.npy "$channels")"
done

# Cameras by pose: from 10 m in front, looking back.
expect_exit 0 "a pose" "$render" --size 96 --pose 0 1 0 0 0 0 -1 0.7 -1 0 0 10 --output pose.png
expect_exit 0 "a pose in one picture with an orbit" \
  "$render" --size 96 --azimuth 0 --elevation 0 --distance 10 --target 0 0 0.7 --output orbit.png
expect_same pose.png orbit.png
frame=$(ls "$assets"/frames/test/*.npz 2>/dev/null | head -n 1)
[ -n "$frame" ] && expect_exit 0 "a frame's camera" "$render" --size 96 --frame "$frame" --output frame.png

# A mesh with y up draws as it does with z up, and is refused where it stands on its nose, unless it is no car.
awk '$1 == "v" { print "v", $3, $4, $2; next } $1 == "vn" { print "vn", $3, $4, $2; next } { print }' \
  "$assets/car_sedan.obj" >y_up.obj
cp "$assets/car_sedan.mtl" .
expect_exit 0 "y up" "$render" --mesh y_up.obj --up y --forward z --size 96 --output upright.png
expect_same car.png upright.png
[ -s command.err ] && fail "a word on a mesh that lies as told: $(cat command.err)" || pass
expect_exit 4 "a mesh on its nose" "$render" --mesh y_up.obj --size 96 --output nose.png
expect_error_line "y_up.obj: the mesh is .* high \(along z\).*--up y --forward z would right it .*--object any"
expect_exit 0 "no car" "$render" --mesh y_up.obj --object any --size 96 --output nose.png
expect_exit 0 "a front at a negative axis" "$render" --mesh y_up.obj --up y --forward -z --size 96 --output behind.png
cmp -s upright.png behind.png && fail "the front does not count" || pass

# Exports: the painted car drawn again looks the same.
expect_exit 0 "export as OBJ" "$render" --size 96 --material body --texture car.png --export out.obj --output one.png
expect_exit 0 "the export" "$render" --mesh out.obj --size 96 --material paint --texture out.png --u-extent 1 \
  --output two.png
expect_same one.png two.png
expect_exit 0 "the export with its own texture" "$render" --mesh out.obj --size 96 --output two.png
expect_same one.png two.png
# Texels beside the charts of a user's atlas take nearby colours: viewers filter over the charts' rims.
expect_exit 0 "export of its texture" "$render" --size 96 --material body --texture car.png --export gutter.obj --output two.png
cmp -s car.png gutter.png && fail "texels beside the charts are exported as they are" || pass
# O35
sed 's/ out.png/ absent.png/' out.mtl >other.mtl && sed 's/out.mtl/other.mtl/' out.obj >other.obj
expect_exit 0 "a texture that is not there" "$render" --mesh other.obj --size 96 --output two.png
grep -q 'absent.png.*stand in for this texture' command.err && pass || fail "no word on the texture"
cmp -s one.png two.png && fail "a texture that is not there is drawn" || pass
# Three walls: two textures, one of them shared and of one pixel, and a colour. The exported mesh looks the same.
printf 'P6 1 1 255\n\377\200\100' >dot.ppm
printf 'newmtl a\nmap_Kd car.png\nnewmtl b\nmap_Kd dot.ppm\nnewmtl c\nmap_Kd dot.ppm\nnewmtl d\nKd 0 1 0\n' >walls.mtl
{ printf 'mtllib walls.mtl\nvt -1 0\nvt 2 0\nvt 2 1\nvt -1 1\n'
  for wall in 0 1 2 3; do
    printf 'v 0 %d 0\nv 0 %d 0\nv 0 %d 1\nv 0 %d 1\n' "$wall" "$((wall + 1))" "$((wall + 1))" "$wall"
  done
  for wall in 0 1 2 3; do
    n=$((4 * wall)) && printf 'usemtl %s\nf %d/1 %d/2 %d/3 %d/4\n' "$(cut -c $((wall + 1)) <<<abcd)" $((n + 1)) $((n + 2)) $((n + 3)) $((n + 4))
  done; } >walls.obj
walls=("$render" --object any --size 96)
expect_exit 0 "walls" "${walls[@]}" --mesh walls.obj --export both.obj --output one.png
grep -q texture command.err && fail "walls: $(cat command.err)" || pass
expect_exit 0 "the exported walls" "${walls[@]}" --mesh both.obj --output two.png
expect_same one.png two.png
sed 's/^map_Kd dot.ppm/map_Kd none.png/' walls.mtl >fewer.mtl && sed 's/walls.mtl/fewer.mtl/' walls.obj >fewer.obj
expect_exit 0 "walls without one texture" "${walls[@]}" --mesh fewer.obj --output two.png
[ "$(grep -c 'none.png.*stand in' command.err)" = 1 ] && pass || fail "walls: $(cat command.err)"
cmp -s one.png two.png && fail "one of several textures is not drawn" || pass
expect_exit 2 "a picture of the mesh overwritten" "${walls[@]}" --mesh both.obj --export both.obj --output two.png

expect_exit 0 "export as glTF" "$render" --size 96 --material body --texture car.png --export out.glb --output one.png
[ "$(head -c 4 out.glb)" = glTF ] && pass || fail "out.glb is no glTF"
expect_exit 0 "export of a colour" "$render" --size 96 --material body --colour 1 0 0 --export red.obj --output one.png
expect_exit 0 "the export" "$render" --mesh red.obj --size 96 --output two.png
expect_same one.png two.png
expect_exit 0 "export of a colour as glTF" "$render" --size 96 --colour 1 0 0 --export red.glb --output one.png

# Panels to print. The square of 1 m has its uv in a square; a window of A4 is 19 x 25.9 cm, and tiles share 1 cm, so that
# 99 cm take 99 / 18 columns and 99 / 24.9 rows: 6 x 4 sheets after the index. Its scale is the same everywhere.
printf 'v 0 -0.5 -0.5\nv 0 0.5 -0.5\nv 0 0.5 0.5\nv 0 -0.5 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n' >sheet.obj
panels() { expect_exit 0 "panels: $*" "$render" --size 8 --texture car.png --output one.png "$@"; }
shows() { grep -aqF -- "$2" "$1" && pass || fail "$1 does not show '$2'"; }
panels --mesh sheet.obj --panels square.pdf
grep -q '^square.pdf: 1 panel on 24 sheets after an index of 1 page$' command.out && pass || fail "panels: $(cat command.out)"
[ "$(grep -ac '/MediaBox \[ 0 0 595.276 841.890 \]' square.pdf)" = 25 ] && pass || fail "not 25 pages of A4"
shows square.pdf '(100.0 x 100.0 cm, 24 sheets)'
shows square.pdf '(stretch 1.000 to 1.000)'
shows square.pdf '(panel 1, tile 9 of 24, row 2 column 3, scale 1)'
# The lower right tile begins 90 cm from the left and ends at the bottom: 10 cm wide, 100 - 3 * 24.9 cm high.
shows square.pdf 'q 283.465 0 0 717.165 28.346 '
ruler=$(grep -a ' w 28.346 39.685 m .* 39.685 l S$' square.pdf | sort -u | awk '{ printf "%.2f", $6 - $3 }')
[ "$ruler" = 141.73 ] && pass || fail "the ruler is $ruler points long"
# The table of the file names the place of every object.
broken=0 entry=0
start=$(tail -n 2 square.pdf | head -n 1)
while read -r place _ kind; do
  entry=$((entry + 1))
  [ "$kind" = n ] || continue
  [ "$(tail -c +$((10#$place + 1)) square.pdf | head -c 16 | head -n 1 | tr -d '\0')" = "$((entry - 1)) 0 obj" ] || broken=1
done < <(tail -c +$((start + 1)) square.pdf | sed -n '3,/trailer/p' | sed '$d')
[ "$broken" = 0 ] && [ "$entry" -gt 80 ] && pass || fail "$entry objects, or their places are wrong"
panels --mesh sheet.obj --panels again.pdf --threads 1
expect_same square.pdf again.pdf
# 1 m at 1 : 18 fits a sheet of any size.
panels --mesh sheet.obj --panels small.pdf --panel-scale 0.0556 --paper letter
grep -q '^small.pdf: 1 panel on 1 sheet after an index of 1 page$' command.out && pass || fail "panels: $(cat command.out)"
shows small.pdf '(5.6 x 5.6 cm, 1 sheet)'
shows small.pdf '/MediaBox [ 0 0 612.000 792.000 ]'
panels --mesh sheet.obj --panels long.pdf --length 2 --paper a0  # 199 / 81.1 columns, 199 / 114.1 rows
grep -q '^long.pdf: 1 panel on 6 sheets after an index of 1 page$' command.out && pass || fail "panels: $(cat command.out)"
# A part of 1 cm is left out, and named.
{ cat sheet.obj && printf 'v 0 2 0\nv 0 2.01 0\nv 0 2.01 0.01\nv 0 2 0.01\nusemtl badge\nf 5/1 6/2 7/3 8/4\n'; } >badge.obj
panels --mesh badge.obj --panels badge.pdf
grep -q '^badge.pdf: 1 panel on .*, 1 smaller than 2 cm left out: 0.01 % of the paint in badge$' command.out && pass || fail "panels: $(cat command.out)"
panels --material body --panels car.pdf --panel-scale 0.0556
grep -q '^car.pdf: 5 panels on 6 sheets' command.out && pass || fail "panels of the car: $(cat command.out)"

refused() { # refused CODE PATTERN OPTIONS...
  local code=$1 pattern=$2
  shift 2
  expect_exit "$code" "$*" "$render" "$@" --output untouched.png
  expect_error_line "$pattern"
}
for words in "--size 0" "--size 20000" "--samples 3" "--view deep" "--filter cubic" "--light soft" "--fov 180" \
  "--distance -1" "--distance 1 2" "--colour 2 0 0" "--background 0 0 nan" "--turntable 361" "--threads -1" "--export car.stl" \
  "--ambient -1" "--clear-coat 2" "--roughness 0" "--directional nan" "--light-direction 0 0 0"; do
  # shellcheck disable=SC2086  # several words on purpose
  refused 2 "${words% *}|${words%% *}|distance" $words
done
refused 2 '--seconds needs --turntable' --seconds 2
refused 2 '--seconds gives each view 0.001 s; expected 0.01 to 60' --turntable 300 --seconds 0.3
refused 2 'with --turntable needs --seconds' --transparent --turntable 3
paint=(--mesh sheet.obj --texture car.png)
refused 2 '--paper is .b9.; expected one of a4, a3, a0, letter' "${paint[@]}" --panels no.pdf --paper b9
for scale in 0 -1 nan 11; do refused 2 'panel-scale' "${paint[@]}" --panels no.pdf --panel-scale "$scale"; done
refused 2 '--length' "${paint[@]}" --panels no.pdf --length -1
refused 2 'ends with .pdf' "${paint[@]}" --panels no.png
refused 2 'needs --length' "${paint[@]}" --panels no.pdf --normalise
refused 4 'needs --texture' --mesh sheet.obj --panels no.pdf
refused 4 'no painted part is as large as 2 cm' "${paint[@]}" --panels no.pdf --panel-scale 0.01
refused 8 'more than 5000 sheets' "${paint[@]}" --panels no.pdf --length 20 --panel-scale 10
sed 's/0\.5/50/g' sheet.obj >centimetres.obj
refused 4 'is 100.000000 m long, expected 1 to 20; --length' --mesh centimetres.obj --texture car.png --panels no.pdf
[ -e no.pdf ] && fail "a refused command left sheets behind" || pass
refused 2 'cannot be given together' --material body --faces faces.txt
refused 2 'no rotation' --pose 1 0 0 0 0 1 0 0 0 0 2 0
refused 2 'leave out' --pose 0 1 0 0 0 0 -1 0.7 -1 0 0 10 --distance 3
refused 3 'absent.obj' --mesh absent.obj
refused 4 "no material 'chrome'" --material chrome --colour 1 0 0
refused 3 'faces.txt' --texture faces.txt
printf '0\n' >zero.txt
refused 3 'zero.txt:1: face number 0' --faces zero.txt --colour 1 0 0
: >empty.txt
refused 4 'face list is empty' --faces empty.txt --colour 1 0 0
echo 99999999 >far.txt
refused 4 'beyond the faces' --faces far.txt --colour 1 0 0
head -c 300 car.png >cut.png
refused 3 'cut.png' --texture cut.png
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >plain.obj
refused 4 'no texture coordinates' --mesh plain.obj --texture car.png
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\nf 1 2 3\n' >partly.obj
refused 4 'partly.obj: painted face 2 .the first is 1. has none of the texture coordinates that --texture needs' \
  --mesh partly.obj --texture car.png
printf 'v 0 0 0 1 0 0\nv 0 1 0 0 1 0\nv 0 0 1 0 0 1\nf 1 2 3\n' >coloured.obj
printf 'v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n' >grey.obj
expect_exit 0 "vertex colours" "$render" --mesh coloured.obj --azimuth 0 --size 32 --output coloured.png --export coloured_again.obj
expect_exit 0 "no vertex colours" "$render" --mesh grey.obj --azimuth 0 --size 32 --output grey.png
cmp -s coloured.png grey.png && fail "vertex colours are not drawn" || pass
grep -q '^v 0 1 0 0 1 0$' coloured_again.obj && pass || fail "vertex colours are not exported"
expect_exit 0 "a mesh of one face" "$render" --mesh plain.obj --size 1 --output one.png
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >faceless.obj
refused 3 'faceless.obj: OBJ has no faces' --mesh faceless.obj
cp car.png paint.png
refuses_to_write() { # refuses_to_write PATTERN OPTIONS...
  local pattern=$1
  shift
  expect_refusal 2 "$pattern" "$*" "$render" --size 8 --material body "$@"
}
refuses_to_write '--output would overwrite .*paint.png' --texture paint.png --output ./paint.png
refuses_to_write '--export would overwrite paint.png' --texture paint.png --export paint.obj --output untouched.png
refuses_to_write 'which is --output' --texture paint.png --export untouched.obj --output untouched.png
refuses_to_write '--export would overwrite out.obj' --mesh out.obj --export out.obj --output untouched.png
refuses_to_write 'ends with .png' --output untouched.jpg
refuses_to_write 'with .npy for one' --output untouched.npy
refuses_to_write 'with .npy for one' --view depth --turntable 3 --output untouched.npy
refuses_to_write '--transparent needs an --output' --view depth --transparent --output untouched.npy
refuses_to_write 'ground needs --light sky or sun' --ground --output untouched.png
refuses_to_write 'needs a light' --clear-coat 1 --light none --output untouched.png
expect_same car.png paint.png
refuses_to_write '--output would overwrite .*out.png' --mesh out.obj --output out.png
cp out.obj again.obj
refuses_to_write '--export would overwrite .*out.mtl' --mesh again.obj --export out.obj --output untouched.png
refuses_to_write 'other.png, which is --output' --mesh again.obj --export other.obj --output other.png
refuses_to_write 'control character in a name' --export $'a\nv 9 9 9.obj' --output untouched.png
[ -e untouched.png ] && fail "a refused command left a picture behind" || pass
expect_exit 0 "a name of 255 bytes" "$render" --size 8 --output "$(printf 'n%.0s' $(seq 251)).png"
expect_exit 5 "a folder that is not there" "$render" --size 8 --output absent/car.png
finish
